//! A Fanuc control, loaded with parameters and points (docs/fanuc.md §5).
//!
//! ```text
//!   memory ─┐  refuse what is not emulated
//!   facts  ─┼→ pitch: axis → itself, for each direction ────┐
//!   state  ─┘  straightness: moving axis → other axis ──────┴→ links (base, output) → Response
//! ```
//! Words: a *point* is a section of the grid of an axis, a *node* an end of it; a *run* is the
//! points of one table. Everything is checked while loading; after that a response cannot fail
//! but for an unknown axis. Signs turn in [`crate::control::controller::TableSign::correction`] only.

mod parameters;
mod pitch;
mod straightness;
#[cfg(test)]
mod tests;

use crate::control::control_state::ControlState;
use crate::control::controller::FanucFacts;
use crate::control::table::fanuc::FanucMemory;
use crate::quantity::axis::Direction;
use crate::read::emulate::{CannotEmulate, Emulated, Emulator, Response};
use parameters::{Link, Loading, Run, cannot};
use std::collections::{BTreeMap, BTreeSet};

/// 1006#5 ZMI: 1 = reference return in −.
const ZMI: u8 = 0b0010_0000;

/// A Fanuc control with stored pitch error compensation (uni- or bidirectional, step or
/// interpolated) and straightness compensation (four-point or per-point) of linear axes.
///
/// unit   corrections in µm, positions in mm of the machine
/// sign   correction = what the axis moves further in +
/// source docs/fanuc.md §5.2 to §5.5 (B-63980EN/01 p. 100; A-77810E/02; B-63522EN/02 §15.5)
/// limits after reference return; no rotary axes, inclination, total values or 3-D compensation
#[derive(Clone, Debug, PartialEq)]
pub struct FanucControl {
    axes: Vec<String>,
    links: Links,
}

/// By base and output axis.
type Links = BTreeMap<(String, String), Link>;

impl FanucControl {
    /// Loads a kit into a control; refuses, in words, where the control would not run it, or
    /// where the files alone do not say what it would do.
    ///
    /// `memory` is the sum of the kit's files ([`crate::read::fanuc::merge`]). The axes of
    /// `state` are named by controlled-axis number (`1`, `2`, …). 3605 counts where the kit
    /// writes it, else the state of the axis does. A missing point or parameter is refused: the
    /// control would keep its old content. Magnification 0 is no compensation.
    pub fn new(
        memory: &FanucMemory,
        facts: &FanucFacts,
        state: &ControlState,
    ) -> Emulated<FanucControl> {
        let from = Loading { memory, facts, state };
        from.refuse_others()?;
        refuse_other_return(from)?;
        let mut links = load_links(from)?;
        // The backlash parameter (1851/1852) moves an axis further after a reversal (docs/fanuc.md §5.3).
        for axis in &state.axes {
            let own = (axis.name.clone(), axis.name.clone());
            let link = links.entry(own).or_default();
            for direction in Direction::BOTH {
                link.way(direction).shift(axis.backlash(direction));
            }
        }
        let axes = state.axes.iter().map(|axis| axis.name.clone()).collect();
        Ok(FanucControl { axes, links })
    }

    fn known(&self, axis: &str) -> Emulated<String> {
        let found = self.axes.iter().find(|name| name.eq_ignore_ascii_case(axis));
        found.cloned().ok_or_else(|| CannotEmulate(format!("the control has no axis `{axis}`")))
    }
}

impl Emulator for FanucControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        self.links
            .iter()
            .filter(|(_, link)| !link.plus.tables().is_empty())
            .map(|(pair, _)| pair.clone())
            .collect()
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        let pair = (self.known(base)?, self.known(output)?);
        let mut link = self.links.get(&pair).cloned().unwrap_or_default();
        Ok(std::mem::take(link.way(direction)))
    }
}

fn load_links(from: Loading) -> Emulated<Links> {
    let mut links = Links::new();
    let mut runs = Vec::new();
    for number in pitch_axes(from.memory) {
        let name = from.axis(number)?.name.clone();
        let link = pitch::load(from, number, &mut runs)?;
        links.insert((name.clone(), name), link);
    }
    for shift in straightness::load(from, &mut runs)? {
        let base = from.axis(shift.moving)?.name.clone();
        let output = from.axis(shift.compensation)?.name.clone();
        let link = links.entry((base, output)).or_default();
        link.plus.push(shift.table.clone());
        link.minus.push(shift.table);
    }
    refuse_shared(&runs)?;
    Ok(links)
}

/// Axes of which the kit writes a pitch parameter.
fn pitch_axes(memory: &FanucMemory) -> BTreeSet<u32> {
    memory
        .parameters
        .keys()
        .filter(|key| (3620..=3627).contains(&key.number))
        .filter_map(|key| key.axis)
        .collect()
}

/// A kit may repeat the direction of the reference return, but not change it.
fn refuse_other_return(from: Loading) -> Emulated<()> {
    for key in from.memory.parameters.keys().filter(|key| key.number == 1006) {
        let (Some(number), Some(bits)) = (key.axis, from.bits(1006, key.axis)?) else {
            return cannot("parameter 1006 names no axis, but each axis has its own");
        };
        let minus = from.axis(number)?.reference_direction == Direction::Minus;
        if minus != (bits & ZMI != 0) {
            return cannot(format!(
                "axis {number}: 1006 bit 5 contradicts the direction of the reference return in the job"
            ));
        }
    }
    Ok(())
}

/// Two tables with a point in common would each use the other's values.
fn refuse_shared(runs: &[Run]) -> Emulated<()> {
    for (index, (own, a)) in runs.iter().enumerate() {
        let shared = runs[index + 1..].iter().find(|(_, b)| a.overlaps(*b));
        if let Some((other, b)) = shared {
            return cannot(format!(
                "{own} (points {} to {}) and {other} (points {} to {}) share points",
                a.first, a.last, b.first, b.last
            ));
        }
    }
    Ok(())
}
