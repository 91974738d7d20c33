//! Fanuc: pitch increments for positioning, straightness sets for the cross terms.

pub mod four_point;
mod numbers;
mod tables;

use self::numbers::{Run, is_four_point, runs};
use self::tables::{Totals, Writer, points};
use crate::control::claims::{Assumption, Precondition, SeenTo};
use crate::control::controller::{ControlUnit, FanucFacts, Mechanism, TableSign};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::inputs::job::Compensation;
use crate::quantity::{Axis, Deviation, Direction, ErrorTerm};
use crate::text::{Problems, joined};
use crate::write::control_text::{Seen, seen, trimmed};
use crate::write::family::{
    Bump, Compiled, Family, FileSource, ProofOf, backlash_parameter, control_state,
};
use crate::write::grid::{LengthDigit, as_number, whole};
use crate::write::refusals;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task, axis_key, axis_pairs};
use std::collections::BTreeMap;

impl Family for FanucFacts {
    fn expected_name(&self, _axis: Axis, name: &str) -> Option<&'static str> {
        let is_number = name.chars().all(|c| c.is_ascii_digit()) && !name.starts_with('0');
        let number: Option<u32> = name.parse().ok().filter(|_| is_number);
        number.is_none_or(|n| n > 99).then_some("the number of a controlled axis, e.g. \"1\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit, decimals: self.interval_decimals(unit) }
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
        let space = self.pitch_points.value.iter().map(|r| r.last - r.first + 1).max().unwrap_or(0);
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
        check_3605(task, &mut out.problems);
        check_backlash(task, plan, &mut out.problems);
        out.placements.sort_by_key(|p| {
            let is_of = |t: &PlannedTable| (t.term, t.direction) == (p.term, p.direction);
            plan.tables.iter().position(is_of)
        });
        let state = control_state(task, plan, |axis| {
            backlash_counts(task, plan, axis).map_or(0.0, |(counts, unit_um)| counts * unit_um)
        });
        out.problems.or_ok(Compiled {
            assumptions: assumptions(task, plan, &runs),
            preconditions: preconditions(task, plan, self, &runs),
            notes: out.notes,
            ..Compiled::of(Tables::Fanuc(out.memory), out.placements, state)
        })
    }

    /// `parameters` (one block each, with its segments) and `points`.
    fn context(&self, emitted: &FileSource<'_>) -> Seen {
        let memory: &FanucMemory = emitted.tables.own();
        let identifier = |letter: &'static str| if self.q_identifier.value { letter } else { "" };
        let mut blocks: BTreeMap<u32, Vec<Seen>> = BTreeMap::new();
        for (ParameterKey { number, axis }, value) in &memory.parameters {
            let axis = axis.map_or(identifier("L1").to_string(), |axis| format!("A{axis}"));
            blocks.entry(*number).or_default().push(seen! { "axis": axis, "value": text(*value) });
        }
        let parameters = blocks.into_iter().map(|(number, segments)| {
            seen! { "number": digits(number, self), "identifier": identifier("Q1"), "segments": segments }
        });
        let points = memory.points.iter().map(|(point, increment)| {
            seen! {
                "number": digits(point + self.point_offset.value, self),
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

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        match mechanism {
            Mechanism::Pitch => table.term.is_positioning(),
            Mechanism::Bidirectional => table.direction.is_some(),
            Mechanism::Straightness => table.term.is_cross(),
            Mechanism::FourPoint => table.term.is_cross() && is_four_point(self),
            Mechanism::PerPoint => table.term.is_cross() && !is_four_point(self),
            _ => true,
        }
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

    /// Points and straightness amounts of the kit, zero but for the bump. The parameters of the kit (3620 to 3624,
    /// magnifications, sets) stay as they are: the bump is in counts of these magnifications.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &FanucMemory = proof.kit.own();
        let pairs = axis_pairs(&proof.plan.names, proof.term).into_iter();
        let pairs = pairs.map(|(base, output)| Some((base.parse().ok()?, output.parse().ok()?)));
        let pairs: Vec<(u32, u32)> = pairs.collect::<Option<_>>()?;
        let (runs, _) = runs(proof.task, proof.plan, self, &mut Problems::none());
        let mut out = FanucMemory::default();
        if proof.mechanism == Mechanism::Pitch {
            for run in &runs {
                let has_bump = pairs.iter().any(|(_, output)| *output == run.id);
                let totals = has_bump.then(|| totals(proof.bump, self.pitch_sign.value));
                for first in std::iter::once(run.first).chain(run.minus_first) {
                    points(&mut out, first, run, totals.as_ref());
                }
            }
            return Some(Tables::Fanuc(out));
        }
        for index in 0..self.straightness_sets.value {
            let axis = |first: u32| kit.count(first + index, None);
            let (Some(moving), Some(output)) = (axis(5711), axis(5721)) else { continue };
            let bump = pairs.contains(&(moving, output)).then_some(proof.bump);
            let sign = self.straightness_sign.value;
            let run = runs.iter().find(|run| run.id == moving)?;
            if proof.mechanism == Mechanism::PerPoint {
                let first = axis(self.straightness_start_parameter.value)?;
                points(&mut out, first, run, bump.map(|bump| totals(bump, sign)).as_ref());
            } else {
                four_points(kit, index, run, bump.map(|bump| (bump, sign)), &mut out)?;
            }
        }
        Some(Tables::Fanuc(out))
    }

    /// Points of the kit that no proof writes would keep what the control holds: the first file that
    /// holds points writes zeros there.
    fn zero_the_rest(&self, kit: &Tables, proofs: &mut [&mut Tables]) {
        let kit: &FanucMemory = kit.own();
        let proofs = proofs.iter_mut().filter_map(|tables| match tables {
            Tables::Fanuc(memory) => Some(memory),
            _ => None,
        });
        let mut proofs: Vec<&mut FanucMemory> = proofs.collect();
        let is_missing = |point: &&u32| !proofs.iter().any(|p| p.points.contains_key(*point));
        let rest: Vec<u32> = kit.points.keys().filter(is_missing).copied().collect();
        if let Some(memory) = proofs.iter_mut().find(|p| !p.points.is_empty()) {
            memory.points.extend(rest.into_iter().map(|point| (point, 0)));
        }
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

// What a person has to see to on the control: reference, bits, backlash, options.

const MEMORY: &str = "parameter manual of the family, from memory";
const LARGEST_BACKLASH: f64 = 9999.0; // 1851, detection units; parameter manual, from memory

/// Backlash parameter of an axis in detection units, and the unit in µm.
fn backlash_counts(task: Task<'_>, plan: &Plan, axis: Axis) -> Option<(f64, f64)> {
    let (um, unit_um) = (plan.backlash_um[axis]?, task.detection_unit_um(axis)?);
    Some(((um / unit_um).round() + 0.0, unit_um))
}

/// 3605 as it was found: what is not emulated, and what the job says otherwise.
fn check_3605(task: Task<'_>, problems: &mut Problems) {
    for axis in Axis::ALL {
        let Some(settings) = task.settings(axis) else { continue };
        let Some(bits) = settings.parameter_3605 else { continue };
        if bits & 0b1100 != 0 {
            let key = axis_key(axis, ".parameter_3605");
            problems.push(task.job.source.at(&key, refusals::other_bits()));
        }
        let found = (bits >> 1) & 1;
        if let Some(stated) = settings.interpolated.filter(|stated| u8::from(*stated) != found) {
            let key = axis_key(axis, ".interpolated");
            problems.push(task.job.source.at(&key, refusals::other_bit_1(stated, found)));
        }
    }
}

fn check_backlash(task: Task<'_>, plan: &Plan, problems: &mut Problems) {
    for axis in Axis::ALL {
        if let Some((counts, unit_um)) = backlash_counts(task, plan, axis)
            && counts.abs() > LARGEST_BACKLASH
        {
            let wrong = refusals::large_backlash(axis, counts, unit_um, LARGEST_BACKLASH);
            problems.push(task.job.source.at("compensation.backlash", wrong));
        }
    }
}

fn assumptions(task: Task<'_>, plan: &Plan, runs: &[Run]) -> Vec<Assumption> {
    let compensation = &task.job.compensation;
    let is_free = |run: &Run| task.settings(run.axis).is_some_and(|s| s.first_point.is_none());
    let nothing_reserved = compensation.reserved_points.is_none() && runs.iter().any(is_free);
    let reserved = nothing_reserved.then(|| {
        let words =
            "points already used by other axes would be overwritten: state `reserved_points`";
        Assumption::of_job("reserved_points", "none", words)
    });
    let unused = runs.iter().filter(|run| plan.of_axis(run.axis).next().is_none());
    let unused = unused.map(|Run { id, axis, .. }| {
        let words = format!("an existing pitch compensation of axis {id} would be replaced by zeros: compensate E{axis}{axis} in the same job");
        Assumption::of_job(format!("pitch_compensation_of_axis_{id}"), "none in use", words)
    });
    let is_asked = |run: &&Run| {
        let settings = task.settings(run.axis);
        settings.is_none_or(|s| s.interpolated.is_none() && s.parameter_3605.is_none())
    };
    let axes = joined(runs.iter().filter(is_asked).map(|run| run.id));
    let interpolated = (!axes.is_empty()).then(|| {
        let words = format!("between the points the forecast is off by up to one step: read 3605#1 of axis {axes} and leave it as it is; where it is 1 (as on the one control seen), state `interpolated = true` for that axis, else `false`, and generate again");
        Assumption::of_job("interpolated", "false", words)
    });
    let first_set = (plan.has_cross() && compensation.first_set.is_none()).then(|| {
        let words =
            "straightness sets already in use from set 1 would be overwritten: state `first_set`";
        Assumption::of_job("first_set", "1", words)
    });
    let unit = compensation.control_unit;
    let odd = runs.iter().filter_map(|Run { id, axis, .. }| {
        let um = task.detection_unit_um(*axis).filter(|um| !is_detection_unit(*um, unit))?;
        let words = format!("every correction would be too large or too small by the same factor: no increment system of a machine in {} makes this unit (IS-B: {} µm / CMR), so read 1001#0, 1013 and 1820 of axis {id}", unit.word(), unit.least_increment_um());
        Some(Assumption::of_job(format!("detection_unit_um of axis {id}"), um.to_string(), words))
    });
    let all = reserved.into_iter().chain(unused).chain(interpolated).chain(first_set).chain(odd);
    all.map(Assumption::undecided).collect()
}

/// Whether IS-A to IS-E (1013) with a CMR of 1/27 … 1/2, 0.5 … 48 (1820) make this unit, to 0.2 %.
fn is_detection_unit(um: f64, unit: ControlUnit) -> bool {
    let is_whole = |own: f64, most: f64| own < most && (own / own.round() - 1.0).abs() < 2e-3;
    [10.0, 1.0, 0.1, 0.01, 0.001].iter().any(|of_is_b| {
        let cmr = unit.least_increment_um() * of_is_b / um;
        is_whole(2.0 * cmr, 96.5) || is_whole(1.0 / cmr, 27.5)
    })
}

fn preconditions(
    task: Task<'_>,
    plan: &Plan,
    facts: &FanucFacts,
    runs: &[Run],
) -> Vec<Precondition> {
    let mut list = vec![Precondition::new(
        "option stored pitch error compensation",
        "available (8135#0 = 0 where the control has it)",
        "without it the tables stay without effect",
        "B-64303CM-1/01 section 1.3.1",
    )];
    if plan.has_cross() {
        let name = if is_four_point(facts) {
            "option straightness compensation"
        } else {
            "option 128-point straightness compensation"
        };
        list.push(Precondition::new(name, "available", "the cross terms need it", MEMORY));
    }
    if runs.iter().any(|run| run.minus_first.is_some()) {
        list.push(Precondition::new(
            "option bidirectional pitch error compensation",
            "available",
            "separate tables for travel in + and -",
            "A-77810E/02",
        ));
    }
    let power_on = Precondition::new(
        "the power of the control",
        "switched off and on after loading 3620 to 3627",
        "the parameters act only then (alarm PW0000 or P/S 000)",
        "cnc.wiki, FANUC pitch error compensation; alarm numbers from memory",
    );
    let homed = Precondition::new(
        "every axis concerned",
        "returned to its reference point after power-on",
        "the compensation acts only after the reference return",
        "cnc.wiki, FANUC pitch error compensation",
    );
    list.extend([power_on, homed].map(|own| own.seen_to(SeenTo::After)));
    list.push(Precondition::new("3602#0", "0", "the data are increments, not totals", MEMORY));
    for run in runs {
        list.extend(axis_preconditions(task, plan, run));
    }
    list
}

fn axis_preconditions(task: Task<'_>, plan: &Plan, run: &Run) -> Vec<Precondition> {
    let id = run.id;
    let Some(machine) = task.job.machine.axes[run.axis] else {
        return Vec::new();
    };
    let unit = task.job.compensation.control_unit;
    let mut list = vec![Precondition::new(
        format!("1240 of axis {id}"),
        format!(
            "{} {}",
            trimmed(machine.reference.mm() / unit.in_mm(), 6),
            unit.word()
        ),
        "the points are anchored on the reference position; if it is elsewhere, switching the tables on moves the axis",
        "B-64303CM-1/01 section 1.3.1",
    ).dangerous()];
    let settings = task.settings(run.axis);
    let directed = run.minus_first.is_some();
    if settings.is_none_or(|s| s.parameter_3605.is_none()) {
        list.push(Precondition::new(
            format!("3605#0 of axis {id}"),
            if directed { "1" } else { "0" },
            "bidirectional pitch error compensation; the parameter is not written: it holds other bits, which stay as they are",
            "A-77810E/02",
        ).seen_to(SeenTo::Boxed));
        list.extend(settings.and_then(|s| s.interpolated).map(|on| {
            Precondition::new(
                format!("3605#1 of axis {id}"),
                if on { "1" } else { "0" },
                "interpolated pitch error compensation, as the job states or the files of the control hold it",
                MEMORY,
            )
        }));
    }
    let bit = if machine.homing() == Direction::Plus { "0" } else { "1" };
    list.push(Precondition::new(
        format!("1006#5 of axis {id}"),
        bit,
        format!(
            "reference return in {}; it decides which direction carries the reversal",
            machine.homing()
        ),
        MEMORY,
    ));
    list.extend(backlash(task, plan, run));
    list
}

fn backlash(task: Task<'_>, plan: &Plan, run: &Run) -> Option<Precondition> {
    plan.of_axis(run.axis).next()?;
    let what = format!("1851 and 1852 of axis {}", run.id);
    let named = |_| {
        let (counts, unit_um) = backlash_counts(task, plan, run.axis).unwrap_or_default();
        format!("{counts} (detection units of {unit_um} µm)")
    };
    Some(backlash_parameter(task, plan, run.axis, what, named, MEMORY))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same control counts in other units on a machine in inch (B-63943EN-1 p. 109).
    #[test]
    fn a_detection_unit_is_one_of_the_machine() {
        let [mm, inch] = [ControlUnit::Millimetre, ControlUnit::Inch];
        for um in [1.0, 0.1, 0.5, 2.0, 0.333, 0.01, 10.0] {
            assert!(is_detection_unit(um, mm) && !is_detection_unit(um, inch), "{um}");
        }
        for um in [2.54, 0.254, 1.27, 0.635, 5.08, 0.847] {
            assert!(is_detection_unit(um, inch) && !is_detection_unit(um, mm), "{um}");
        }
    }
}
