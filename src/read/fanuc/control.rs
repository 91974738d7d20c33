//! A Fanuc control, loaded with parameters and points (docs/fanuc.md §2).
//!
//! ```text
//!   memory ─┐  refuse what is not emulated
//!   facts  ─┼→ pitch: axis → itself, for each direction ────┐
//!   state  ─┘  straightness: moving axis → other axis ──────┴→ pairs (base, output) → Response
//! ```
//! Words: a *point* is a section of the grid of an axis, a *node* an end of it; a *run* is the
//! points of one table. Everything is checked while loading. Signs turn in [`crate::control::controller::TableSign::correction`] only.

mod parameters;
mod tables;
#[cfg(test)]
mod tests;

use crate::control::control_state::ControlState;
use crate::control::controller::FanucFacts;
use crate::control::table::fanuc::FanucMemory;
use crate::quantity::Direction;
use crate::read::emulate::{Emulated, Response, cannot};
use crate::read::listed::{Pair, PairControl};
use parameters::{Loading, Run};
use std::collections::{BTreeMap, BTreeSet};

/// 1006#5 ZMI: 1 = reference return in −.
const ZMI: u8 = 0b0010_0000;

/// A Fanuc control with stored pitch error compensation (uni- or bidirectional, step or
/// interpolated) and straightness compensation (four-point or per-point) of linear axes. Refuses, in words,
/// where the control would not run a kit, or where the files alone do not say what it would do.
///
/// `memory` is the sum of the kit's files ([`crate::read::fanuc::merge`]). The axes of
/// `state` are named by controlled-axis number (`1`, `2`, …). 3605 counts where the kit
/// writes it, else the state of the axis does. A missing point or parameter is refused: the
/// control would keep its old content. Magnification 0 is no compensation. The backlash parameter (1851/1852)
/// moves an axis further after a reversal (docs/fanuc.md §2.3).
///
/// unit   corrections in µm, positions in mm of the machine
/// sign   correction = what the axis moves further in +
/// source docs/fanuc.md §2.2, §2.5 (B-63980EN/01 p. 100; A-77810E/02; B-63522EN/02 §15.5)
/// limits after reference return; no rotary axes, inclination, total values or 3-D compensation
pub(super) fn control(
    memory: &FanucMemory,
    facts: &FanucFacts,
    state: &ControlState,
) -> Emulated<PairControl> {
    let from = Loading { memory, facts, state };
    from.refuse_others()?;
    refuse_other_return(from)?;
    let mut pairs: BTreeMap<(String, String), [Response; 2]> = BTreeMap::new();
    let mut runs = Vec::new();
    for number in pitch_axes(memory) {
        let name = from.axis(number)?.name.clone();
        let ways = tables::load_pitch(from, number, &mut runs)?;
        pairs.extend(ways.map(|ways| ((name.clone(), name), ways)));
    }
    for ([moving, compensation], table) in tables::load_straightness(from, &mut runs)? {
        let axes = (from.axis(moving)?, from.axis(compensation)?);
        let ways = pairs.entry((axes.0.name.clone(), axes.1.name.clone())).or_default();
        ways.iter_mut().for_each(|way| way.push(table.clone()));
    }
    refuse_shared(&runs)?;
    let pairs =
        pairs.into_iter().map(|((base, output), ways)| Pair { base, output, ways: ways.map(Ok) });
    Ok(PairControl { pairs: pairs.collect(), replaces_backlash: false, state: state.clone() })
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
