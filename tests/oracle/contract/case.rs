//! A kit under test, what the control holds of it, and how far off it may be where.

use crate::support::machine::{Machine, Term};
use crate::support::{has_two_directions, is_generic};
use nonius::control::controller::{Dialect, Profile, StraightnessForm};
use nonius::control::table::Tables;
use nonius::control::table::fanuc::{FanucMemory, ParameterValue};
use nonius::kit::Kit;
use nonius::quantity::{Direction, ErrorTerm, Interpolation, power_of_ten};
use nonius::read::emulate::{Emulator, Response};
use nonius::write::findings::TableFinding;

/// Beside a jump, mm: near enough that no curve moves by more than [`NEAR_UM`].
const BESIDE_MM: f64 = 1e-7;
/// What a curve moves within [`BESIDE_MM`], µm.
pub(crate) const NEAR_UM: f64 = 1e-5;
/// Steepest slope that the generator makes, µm/mm.
pub(crate) const STEEPEST_UM_PER_MM: f64 = 20.0;

pub(crate) struct Case<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) profile: &'a Profile,
    pub(crate) kit: &'a Kit,
    pub(crate) control: &'a dyn Emulator,
    pub(crate) tables: &'a Tables,
}

impl Case<'_> {
    /// Size of a count in the control's file, from the bytes where they tell, µm.
    pub(crate) fn count_um(&self, term: ErrorTerm, output: &str) -> f64 {
        match (&self.profile.dialect, self.tables) {
            // The sixth decimal of an inch, of a millimetre.
            (Dialect::Siemens(_) | Dialect::Linuxcnc(_), _) if self.machine.inch => 0.0254,
            (Dialect::Siemens(_) | Dialect::Linuxcnc(_) | Dialect::Isg(_), _) => 0.001,
            (Dialect::Declared(facts), _) => {
                crate::support::count_um(facts, self.machine.axis(term.of).unit_um)
            }
            (Dialect::Fanuc(facts), Tables::Fanuc(memory)) => {
                let unit = self.machine.axis(term.of).unit_um.unwrap();
                let output: u32 = output.parse().unwrap();
                if term.is_positioning() {
                    unit * integer(memory, 3623, Some(output))
                } else if facts.straightness_form.value == StraightnessForm::FourPoint {
                    unit
                } else {
                    let moving: u32 = self.machine.axis(term.along).names[0].parse().unwrap();
                    let is = |number, axis: u32| {
                        let axis = ParameterValue::Integer(i64::from(axis));
                        memory.parameter(number, None) == Some(axis)
                    };
                    let set = (0..6).find(|set| is(5711 + set, moving) && is(5721 + set, output));
                    unit * integer(memory, 13381 + set.unwrap(), None)
                }
            }
            _ => self.machine.axis(term.of).unit_um.unwrap_or(0.0),
        }
    }

    pub(crate) fn is_compensated(&self, term: ErrorTerm) -> bool {
        self.kit.plan.tables.iter().any(|table| table.term == term)
    }

    /// Whether each direction has a table of its own; where policy and control ask for it, anything else has to be said.
    pub(crate) fn two_tables(&self, term: &Term) -> bool {
        let mut tables = self.kit.plan.tables.iter();
        let directed = tables.any(|t| t.term == term.term && t.direction.is_some());
        let asked = self.machine.policy == Some("two-tables") && term.both_ways();
        let is_siemens = matches!(self.profile.dialect, Dialect::Siemens(_));
        let of_cross = is_siemens || is_generic(self.profile);
        let takes = (of_cross || term.term.is_positioning()) && has_two_directions(self.profile);
        if asked && !directed && takes {
            let mut kinds = self.kit.plan.notes.iter().filter_map(|note| note.kind());
            let (own, equal) = (term.term, "both directions are equal, so one table is written");
            let is_equal = || {
                let grid = self.kit.plan.grids[term.term.along].unwrap();
                (grid.first..=grid.last).all(|node| {
                    let at = grid.position(node).mm();
                    let [plus, minus] = Direction::BOTH.map(|way| term.deviation(way, at));
                    (plus - minus).abs() < 1e-6
                })
            };
            assert!(kinds.any(|kind| match kind {
                TableFinding::MeanOnly { term, .. } => *term == own,
                TableFinding::OfTarget { terms, note } =>
                    terms.contains(&own) && note == equal && is_equal(),
                _ => false,
            }));
        }
        directed
    }

    /// Half the last digit of positions in the control's files, mm.
    pub(crate) fn half_position_digit(&self) -> f64 {
        match &self.profile.dialect {
            Dialect::Declared(facts) => {
                0.5e-3 * facts.position_size.value.um / power_of_ten(facts.position_decimals.value)
            }
            Dialect::Siemens(_) | Dialect::Linuxcnc(_) if self.machine.inch => 0.5e-6 * 25.4,
            Dialect::Fanuc(_) => 0.0,
            _ => 0.5e-6,
        }
    }

    /// Where the deviation of a term or its correction bends, and where the correction jumps.
    pub(crate) fn bends_and_jumps(&self, term: &Term, held: &Held) -> (Vec<f64>, Vec<f64>) {
        let mut bends = term.knots();
        bends.extend(&held.mm);
        let mut jumps = Vec::new();
        if matches!(self.profile.dialect, Dialect::Fanuc(_)) {
            jumps.extend(held.mm.windows(2).map(|p| (p[0] + p[1]) / 2.0));
            let unit = self.machine.axis(term.term.of).unit_um.unwrap();
            for (pair, um) in held.mm.windows(2).zip(held.um.windows(2)) {
                let pulses = ((um[1] - um[0]) / unit).abs().round();
                let place = |n: u32| pair[0] + (pair[1] - pair[0]) * (f64::from(n) + 0.5) / pulses;
                jumps.extend((0..pulses as u32).map(place));
            }
        }
        (bends, jumps)
    }

    pub(crate) fn places(&self, term: &Term, held: &Held, from: f64, to: f64) -> Vec<f64> {
        // Straight lines bend at known places, cubics peak.
        let dense = if self.machine.kind == Interpolation::Linear { 240 } else { 2000 };
        let (mut places, jumps) = self.bends_and_jumps(term, held);
        places.extend(jumps.iter().flat_map(|x| [x - BESIDE_MM, x + BESIDE_MM]));
        places.extend((0..=dense).map(|i| from + (to - from) * i as f64 / dense as f64));
        places.retain(|x| *x >= from && *x <= to);
        places
    }

    /// Largest distance of what a control puts out from the straight line between its nodes.
    pub(crate) fn jump_um(&self, term: &Term, held: &Held, x: f64) -> f64 {
        let Dialect::Fanuc(facts) = &self.profile.dialect else { return 0.0 };
        // Half of the largest change in the section (or the two sections) at `x`.
        let place = (x - held.mm[0]) / held.step();
        let is_at = |node: &usize| (*node as f64 - 0.5 - place).abs() < 0.5 + 1e-6;
        let own = (1..held.mm.len()).filter(is_at);
        let half_step =
            own.map(|node| (held.um[node] - held.um[node - 1]).abs() / 2.0).fold(0.0, f64::max);
        let pulses = self.machine.axis(term.term.along).interpolated
            && (term.term.is_positioning()
                || facts.straightness_form.value == StraightnessForm::FourPoint);
        match pulses {
            true => half_step.min(self.machine.axis(term.term.of).unit_um.unwrap() / 2.0),
            false => half_step,
        }
    }
}

pub(crate) struct Held {
    pub(crate) mm: Vec<f64>,
    pub(crate) um: Vec<f64>,
}

impl Held {
    pub(crate) fn of(response: &Response) -> Held {
        assert_eq!(response.tables().len(), 1, "one table acts");
        let nodes = response.tables()[0].nodes();
        let (mm, um) = nodes.map(|(x, correction)| (x.mm(), correction.um())).unzip();
        Held { mm, um }
    }

    pub(crate) fn step(&self) -> f64 {
        (self.mm[self.mm.len() - 1] - self.mm[0]) / (self.mm.len() - 1) as f64
    }

    pub(crate) fn node_at(&self, x: f64) -> usize {
        let off = |node: &usize| (self.mm[*node] - x).abs();
        (0..self.mm.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
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
