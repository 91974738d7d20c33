//! A kit under test, and what the control holds of it.

use crate::support::machine::{Machine, Term};
use nonius::control::controller::{Dialect, Profile, StraightnessForm};
use nonius::control::table::Tables;
use nonius::control::table::fanuc::{FanucMemory, ParameterValue};
use nonius::kit::{Inputs, Kit};
use nonius::quantity::axis::{Direction, ErrorTerm};
use nonius::read::emulate::{Emulator, Response};
use nonius::write::findings::TableFinding;

/// A kit under test, with the control that loaded its bytes.
pub(crate) struct Case<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) profile: &'a Profile,
    pub(crate) inputs: &'a Inputs,
    pub(crate) kit: &'a Kit,
    pub(crate) control: &'a dyn Emulator,
    pub(crate) tables: &'a Tables,
}

/// One table as the control holds it: nodes with the corrections there.
pub(crate) struct Held {
    pub(crate) mm: Vec<f64>,
    pub(crate) um: Vec<f64>,
}

impl Held {
    pub(crate) fn of(response: &Response) -> Held {
        assert_eq!(response.tables().len(), 1, "one table acts");
        let nodes: Vec<_> = response.tables()[0].nodes().collect();
        Held {
            mm: nodes.iter().map(|(x, _)| x.mm()).collect(),
            um: nodes.iter().map(|(_, c)| c.um()).collect(),
        }
    }

    pub(crate) fn step(&self) -> f64 {
        (self.mm[self.mm.len() - 1] - self.mm[0]) / (self.mm.len() - 1) as f64
    }

    pub(crate) fn node_at(&self, x: f64) -> usize {
        let node = (0..self.mm.len())
            .min_by(|a, b| (self.mm[*a] - x).abs().total_cmp(&(self.mm[*b] - x).abs()));
        node.unwrap()
    }

    /// Largest change in the section (or the two sections) at `x`.
    pub(crate) fn increment_at(&self, x: f64) -> f64 {
        let place = (x - self.mm[0]) / self.step();
        (1..self.mm.len())
            .filter(|node| {
                let node = *node as f64;
                place > node - 1.0 - 1e-6 && place < node + 1e-6
            })
            .map(|node| (self.um[node] - self.um[node - 1]).abs())
            .fold(0.0, f64::max)
    }
}

/// Size of a count in the control's file, from the bytes where they tell, µm.
pub(crate) fn count_um(case: &Case<'_>, term: ErrorTerm, output: &str) -> f64 {
    match (&case.profile.dialect, case.tables) {
        // The sixth decimal of an inch, of a millimetre.
        (Dialect::Siemens(_) | Dialect::Linuxcnc(_), _) if case.machine.inch => 0.0254,
        (Dialect::Siemens(_) | Dialect::Linuxcnc(_) | Dialect::Isg(_), _) => 0.001,
        (Dialect::Declared(facts), _) => crate::support::count_um(facts),
        (Dialect::Fanuc(facts), Tables::Fanuc(memory)) => {
            let unit = case.machine.axis(term.of).unit_um.unwrap();
            let output: u32 = output.parse().unwrap();
            if term.is_positioning() {
                unit * integer(memory, 3623, Some(output))
            } else if facts.straightness_form.value == StraightnessForm::FourPoint {
                unit
            } else {
                let set = set_of(case, memory, term, output);
                unit * integer(memory, 13381 + set, None)
            }
        }
        _ => case.machine.axis(term.of).unit_um.unwrap_or(0.0),
    }
}

pub(crate) fn integer(memory: &FanucMemory, number: u32, axis: Option<u32>) -> f64 {
    match memory.parameter(number, axis) {
        Some(ParameterValue::Integer(value)) => value as f64,
        other => panic!("parameter {number} of {axis:?} is {other:?}"),
    }
}

pub(crate) fn whole(memory: &FanucMemory, number: u32, axis: Option<u32>) -> u32 {
    format!("{}", integer(memory, number, axis)).parse().unwrap()
}

/// Index from 0 of the straightness set of a term and an output.
fn set_of(case: &Case<'_>, memory: &FanucMemory, term: ErrorTerm, output: u32) -> u32 {
    let moving: u32 = case.machine.axis(term.along).names[0].parse().unwrap();
    let is = |number, axis: u32| {
        memory.parameter(number, None) == Some(ParameterValue::Integer(i64::from(axis)))
    };
    (0..6)
        .find(|set| is(5711 + set, moving) && is(5721 + set, output))
        .unwrap_or_else(|| panic!("no set for {term} on {output}"))
}

pub(crate) fn is_compensated(case: &Case<'_>, term: ErrorTerm) -> bool {
    case.kit.plan.tables.iter().any(|table| table.term == term)
}

/// Whether each direction has a table of its own. Where the policy asks for it and the control
/// could hold it, anything else has to be said.
pub(crate) fn two_tables(case: &Case<'_>, term: &Term) -> bool {
    let mut own = case.kit.plan.tables.iter().filter(|t| t.term == term.term);
    let directed = own.any(|t| t.direction.is_some());
    let asked = case.machine.policy == Some("two-tables") && term.both_ways();
    if asked && !directed && term.takes_directions(case.profile) {
        let notes = &case.kit.plan.notes;
        let is_mean = notes.iter().any(|note| match note.kind() {
            Some(TableFinding::MeanOnly { term: own, .. }) => *own == term.term,
            _ => false,
        });
        let says_equal = notes.iter().any(|note| match note.kind() {
            Some(TableFinding::OfTarget { terms, note }) => {
                terms.contains(&term.term)
                    && note == "both directions are equal, so one table is written"
            }
            _ => false,
        });
        let is_equal = || {
            let grid = case.kit.plan.grids[term.term.along].unwrap();
            (grid.first..=grid.last).all(|node| {
                let at = grid.position(node).mm();
                let [plus, minus] = Direction::BOTH.map(|way| term.deviation(way, at));
                (plus - minus).abs() < 1e-6
            })
        };
        assert!(is_mean || says_equal && is_equal());
    }
    directed
}
