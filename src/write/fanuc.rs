//! Fanuc: pitch increments for positioning, straightness sets for the cross terms.

pub mod four_point;
mod numbers;
mod proof;
mod requirements;
mod tables;

use self::numbers::is_four_point;
use self::tables::Writer;
use crate::control::controller::{ControlUnit, FanucFacts, Mechanism};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::inputs::job::Compensation;
use crate::quantity::ErrorTerm;
use crate::text::Problems;
use crate::write::compiled::{Compiled, control_state};
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::grid::LengthDigit;
use crate::write::seen::{Seen, seen};
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use std::collections::BTreeMap;

impl Family for FanucFacts {
    fn expected_name(&self, name: &str) -> Option<&'static str> {
        let is_number = name.chars().all(|c| c.is_ascii_digit()) && !name.starts_with('0');
        let number: Option<u32> = name.parse().ok().filter(|_| is_number);
        number.is_none_or(|n| n > 99).then_some("the number of a controlled axis, e.g. \"1\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        let decimals = match unit {
            ControlUnit::Millimetre => self.interval_decimals_mm.value,
            ControlUnit::Inch => self.interval_decimals_inch.value,
        };
        LengthDigit { unit, decimals }
    }

    fn takes_directions(&self, term: ErrorTerm) -> bool {
        term.is_positioning() && !self.minus_points.value.is_empty()
    }

    fn budget(&self, compensation: &Compensation) -> Option<TableStock> {
        Some(TableStock {
            tables: match is_four_point(self) {
                true => self.straightness_sets.value,
                false => self.straightness_sets.value.min(numbers::blocks_of_sets(self)),
            },
            used: compensation.first_set.unwrap_or(1).saturating_sub(1),
            resource: "straightness sets",
            key: "first_set",
            takes_pairs: false,
            masters: None,
        })
    }

    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str) {
        let blocks = self.pitch_points.value.iter();
        let space = blocks.map(|r| r.last - r.first + 1).max().unwrap_or(0);
        if targets.iter().any(|t| t.term.is_cross()) {
            (
                self.straightness_axis_points.value.min(space),
                "the moving axis of a straightness compensation",
            )
        } else {
            (space, "the pitch points")
        }
    }

    fn least_spacing_mm(&self, max_feed: f64) -> f64 {
        max_feed / self.interval_feed_divisor.value
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let mut problems = Problems::none();
        let (runs, space) = numbers::runs(task, plan, self, &mut problems);
        let mut out = Writer {
            task,
            plan,
            facts: self,
            space,
            memory: FanucMemory::default(),
            placements: Vec::new(),
            notes: Vec::new(),
            problems,
        };
        for run in &runs {
            out.pitch(run);
        }
        out.straightness(&runs);
        requirements::check_backlash(task, plan, &mut out.problems);
        out.placements.sort_by_key(|p| {
            let is_of = |t: &PlannedTable| (t.term, t.direction) == (p.term, p.direction);
            plan.tables.iter().position(is_of)
        });
        out.problems.or_ok(Compiled {
            assumptions: requirements::assumptions(task, plan, &runs),
            preconditions: requirements::preconditions(task, plan, self, &runs),
            stale: Vec::new(),
            notes: out.notes,
            tables: Tables::Fanuc(out.memory),
            placements: out.placements,
            state: control_state(task, plan, |axis| {
                let backlash = requirements::backlash_counts(task, plan, axis);
                backlash.map_or(0.0, |(counts, unit_um)| counts * unit_um)
            }),
        })
    }

    fn uses(&self, mechanism: Mechanism, plan: &Plan, _tables: &Tables) -> bool {
        let crosses = plan.has_cross();
        match mechanism {
            Mechanism::Pitch => plan.tables.iter().any(|t| t.term.is_positioning()),
            Mechanism::Bidirectional => plan.tables.iter().any(|t| t.direction.is_some()),
            Mechanism::Straightness => crosses,
            Mechanism::FourPoint | Mechanism::PerPoint => crosses && self.has(mechanism),
            _ => true,
        }
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen> {
        let memory: &FanucMemory = emitted.tables.own()?;
        Some(context(memory, self))
    }

    fn has(&self, mechanism: Mechanism) -> bool {
        match mechanism {
            Mechanism::FourPoint => is_four_point(self),
            Mechanism::PerPoint => !is_four_point(self),
            _ => true,
        }
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        table.term.is_positioning() == (mechanism == Mechanism::Pitch)
    }

    /// A straightness set of four points has no increments, but the control refuses a slope that is too
    /// large (alarm PW5046, from memory; the limit is not known). So its bump rises like one of pitch
    /// points, and steeper only where the table has no room for that.
    fn section_limits(&self, mechanism: Mechanism) -> Vec<Option<i64>> {
        let increment = Some(i64::from(self.increment_max.value));
        match mechanism {
            Mechanism::FourPoint => vec![increment, None],
            _ => vec![increment],
        }
    }

    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &FanucMemory = proof.kit.own()?;
        proof::memory(proof, self, kit).map(Tables::Fanuc)
    }

    fn zero_the_rest(&self, kit: &Tables, proofs: &mut [&mut Tables]) {
        if let Tables::Fanuc(kit) = kit {
            proof::zero_the_rest(kit, proofs);
        }
    }
}

/// What the templates see: `parameters` (one block each, with its segments) and `points`.
fn context(memory: &FanucMemory, facts: &FanucFacts) -> Seen {
    let identifier = |letter: &'static str| if facts.q_identifier.value { letter } else { "" };
    let mut blocks: BTreeMap<u32, Vec<Seen>> = BTreeMap::new();
    for (ParameterKey { number, axis }, value) in &memory.parameters {
        let of_path = identifier("L1").to_string();
        let axis = axis.map_or(of_path, |axis| format!("A{axis}"));
        let segment = seen! { "axis": axis, "value": text(*value) };
        blocks.entry(*number).or_default().push(segment);
    }
    let parameters = blocks.into_iter().map(|(number, segments)| {
        seen! { "number": digits(number, facts), "identifier": identifier("Q1"), "segments": segments }
    });
    let points = memory.points.iter().map(|(point, increment)| {
        seen! {
            "number": digits(point + facts.point_offset.value, facts),
            "point": point.to_string(),
            "identifier": identifier("Q0"),
            "value": increment.to_string(),
        }
    });
    seen! {
        "parameters": parameters.collect::<Vec<Seen>>(),
        "points": points.collect::<Vec<Seen>>(),
    }
}

fn digits(number: u32, facts: &FanucFacts) -> String {
    format!("{number:0width$}", width = facts.number_digits.value as usize)
}

fn text(value: ParameterValue) -> String {
    match value {
        ParameterValue::Integer(whole) => whole.to_string(),
        ParameterValue::Bits(bits) => format!("{bits:08b}"),
        ParameterValue::Real(real) => {
            let text = format!("{}", real + 0.0);
            if text.contains('.') { text } else { format!("{text}.0") }
        }
    }
}
