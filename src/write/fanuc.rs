//! Fanuc: pitch increments for positioning, straightness sets for the cross terms.

pub mod four_point;
mod numbers;
mod requirements;
mod tables;

use self::numbers::{Run, is_four_point, runs};
use self::tables::{Totals, Writer, points};
use crate::control::controller::{ControlUnit, FanucFacts, Mechanism, TableSign};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::inputs::job::Compensation;
use crate::quantity::{Deviation, ErrorTerm};
use crate::text::Problems;
use crate::write::compiled::{Bump, Compiled, control_state};
use crate::write::control_text::{Seen, seen};
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::grid::{LengthDigit, as_number, whole};
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task, axis_pairs};
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
            ..TableStock::default()
        })
    }

    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str) {
        let blocks = self.pitch_points.value.iter();
        let space = blocks.map(|r| r.last - r.first + 1).max().unwrap_or(0);
        if targets.iter().any(|t| t.term.is_cross()) {
            let most = self.straightness_axis_points.value.min(space);
            (most, "the moving axis of a straightness compensation")
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
        Some(context(emitted.tables.own()?, self))
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
        memory(proof, self, proof.kit.own()?).map(Tables::Fanuc)
    }

    fn zero_the_rest(&self, kit: &Tables, proofs: &mut [&mut Tables]) {
        if let Tables::Fanuc(kit) = kit {
            zero_the_rest(kit, proofs);
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

// Points and straightness amounts of the kit, zero but for the bump.
//
// The parameters of the kit (3620 to 3624, magnifications, sets) stay as they are: the bump is in
// counts of these magnifications.

/// What the file of a mechanism writes.
fn memory(proof: &ProofOf<'_>, facts: &FanucFacts, kit: &FanucMemory) -> Option<FanucMemory> {
    let pairs = axis_pairs(&proof.plan.names, proof.term).into_iter();
    let pairs = pairs.map(|(base, output)| Some((base.parse().ok()?, output.parse().ok()?)));
    let pairs: Vec<(u32, u32)> = pairs.collect::<Option<_>>()?;
    let (runs, _) = runs(proof.task, proof.plan, facts, &mut Problems::none());
    let mut out = FanucMemory::default();
    if proof.mechanism == Mechanism::Pitch {
        for run in &runs {
            let has_bump = pairs.iter().any(|(_, output)| *output == run.id);
            let totals = has_bump.then(|| totals(proof.bump, facts.pitch_sign.value));
            for first in std::iter::once(run.first).chain(run.minus_first) {
                points(&mut out, first, run, totals.as_ref());
            }
        }
        return Some(out);
    }
    for index in 0..facts.straightness_sets.value {
        let axis = |first: u32| kit.count(first + index, None);
        let (Some(moving), Some(output)) = (axis(5711), axis(5721)) else { continue };
        let bump = pairs.contains(&(moving, output)).then_some(proof.bump);
        let sign = facts.straightness_sign.value;
        let run = runs.iter().find(|run| run.id == moving)?;
        if proof.mechanism == Mechanism::PerPoint {
            let first = axis(facts.straightness_start_parameter.value)?;
            points(&mut out, first, run, bump.map(|bump| totals(bump, sign)).as_ref());
        } else {
            four_points(kit, index, run, bump.map(|bump| (bump, sign)), &mut out)?;
        }
    }
    Some(out)
}

/// Points of the kit that no proof writes would keep what the control holds: the first file that
/// holds points writes zeros there.
fn zero_the_rest(kit: &FanucMemory, proofs: &mut [&mut Tables]) {
    let proofs = proofs.iter_mut().filter_map(|tables| match tables {
        Tables::Fanuc(memory) => Some(memory),
        _ => None,
    });
    let mut proofs: Vec<&mut FanucMemory> = proofs.collect();
    let is_missing = |point: &&u32| !proofs.iter().any(|p| p.points.contains_key(*point));
    let rest: Vec<u32> = kit.points.keys().filter(is_missing).copied().collect();
    if let Some(memory) = proofs.iter_mut().find(|p| !p.points.is_empty()) {
        let zeros = rest.into_iter().map(|point| (point, 0));
        memory.points.extend(zeros);
    }
}

/// What a bump is in increments; both directions of travel have the same.
fn totals(bump: &Bump, sign: TableSign) -> Totals {
    let nodes = bump.grid.first..=bump.grid.last;
    let counts = nodes.map(|node| in_table(sign, bump.counts_at(node))).collect();
    Totals { grid: bump.grid, counts }
}

/// Counts of a deviation in the sense of the table.
fn in_table(sign: TableSign, counts: i64) -> i64 {
    whole(sign.table_um(Deviation::from_um(as_number(counts))).round())
}

/// The points of a set without the bump stay, with amounts 0. A set with it has the reference as
/// its fourth point.
fn four_points(
    kit: &FanucMemory,
    set: u32,
    run: &Run,
    bump: Option<(&Bump, TableSign)>,
    out: &mut FanucMemory,
) -> Option<()> {
    for knot in 0..4 {
        let number = 10 * set + knot;
        let (point, amount) = match bump {
            None => (kit.count(5731 + number, None)?, 0),
            Some((bump, sign)) => {
                let node = bump_nodes(bump)[usize::try_from(knot).ok()?];
                (run.point(node), in_table(sign, bump.counts_at(node)))
            }
        };
        out.set(5731 + number, None, point);
        out.set(5761 + number, None, amount);
    }
    Some(())
}

/// Beginning, peak and end of the bump, and the reference, ascending.
fn bump_nodes(bump: &Bump) -> [i64; 4] {
    let mut nodes = [0, bump.peak - bump.rise, bump.peak, bump.peak + bump.rise];
    nodes.sort_unstable();
    nodes
}
