//! The plan in a control's own numbers (rounded once, numbered, within its limits), and what to know of it.
//!
//! ```text
//!   Plan ─→ Family (siemens, fanuc, declared …) ─→ Compiled { tables, state, assumptions, preconditions }
//! ```
//! Deviations become table values through [`crate::control::controller::TableSign`], the only place where
//! a profile's sense of a table enters. Rounding is half away from zero, on totals, so no point
//! is off by more than half a count.

use crate::control::claims::Assumption;
use crate::control::controller::{ControlUnit, Evidence, Mechanism};
use crate::control::table::Tables;
use crate::inputs::job::{ActiveTables, BacklashPolicy, Job, MachineAxis};
use crate::machine::findings::ModelFinding;
use crate::machine::model::ErrorModel;
use crate::quantity::{AT_PLACE_MM, Axis, Direction, ErrorTerm, Millimetres};
use crate::text::{Finding, Problems};
pub(crate) use crate::write::control_text::trimmed;
pub(crate) use crate::write::family::stated_control;
pub use crate::write::family::{Compiled, Placement};
use crate::write::family::{counts_as_zero, family};
use crate::write::findings::TableFinding;
use crate::write::grid::EDGE_MM;
use crate::write::task::{Plan, Task};

/// Puts a plan into the numbers of the task's control; all problems are given at once.
pub fn compile(task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
    let mut compiled = family(task.profile).compile(task, plan)?;
    let mut assumptions = profile_assumptions(task, plan, &compiled.tables);
    assumptions.extend(job_assumptions(task, plan));
    assumptions.append(&mut compiled.assumptions);
    assumptions.sort_by_key(|assumption| assumption.without_effect.is_some()); // those that matter first
    compiled.assumptions = assumptions;
    let mut notes = plan.notes.clone();
    notes.extend(task.job.measurement.notes());
    notes.extend(task.model.remarks.notes.iter().cloned());
    let takes_angles = family(task.profile).takes_angles(task);
    let is_said = |note: &&Finding| {
        !(takes_angles && note.kind() == Some(&ModelFinding::AnglesNotCompensated))
    };
    notes.extend(task.model.unused.iter().filter(is_said).cloned());
    notes.extend(slips(task.model).into_iter().map(Finding::from));
    notes.extend(references_off_the_travel(task.job, plan).map(Finding::from));
    notes.append(&mut compiled.notes);
    notes.extend(of_active(task, plan).map(Finding::from));
    compiled.notes = notes;
    compiled.preconditions.extend_from_slice(&task.profile.preconditions);
    Ok(compiled)
}

/// Moving axes of the tables that do not reach their reference point by the travel of the job. Some
/// machines have it just beyond; a slip of the job has it far off.
fn references_off_the_travel(job: &Job, plan: &Plan) -> impl Iterator<Item = TableFinding> {
    let is_looked_up = |axis: Axis| plan.tables.iter().any(|table| table.term.along == axis);
    let off_the_travel = move |axis: Axis| {
        let of = job.machine.axes[axis].as_ref()?;
        let (low, high, reference_mm) = (of.low.mm(), of.high.mm(), of.reference.mm());
        let beyond_mm = (low - reference_mm).max(reference_mm - high);
        (is_looked_up(axis) && beyond_mm > EDGE_MM).then_some(TableFinding::ReferenceOff {
            axis,
            reference_mm,
            beyond_mm,
            travel_mm: [low, high],
        })
    };
    Axis::ALL.into_iter().filter_map(off_the_travel)
}

/// Axes of which the tables replace a backlash parameter that counts as 0 while measuring.
fn counted_as_zero(job: &Job, plan: &Plan) -> Vec<Axis> {
    let axes = Axis::ALL.into_iter();
    axes.filter(|axis| plan.sets_backlash(*axis) && counts_as_zero(job, *axis)).collect()
}

/// What of the control was active while measuring, and what the kit makes of it.
fn of_active(task: Task<'_>, plan: &Plan) -> Option<TableFinding> {
    let (parameter, axes) =
        (task.profile.family.backlash_parameter, counted_as_zero(task.job, plan));
    match &task.job.measurement.active {
        ActiveTables::Path(path) => Some(TableFinding::OldAndResidual { path: path.clone() }),
        ActiveTables::None if !axes.is_empty() => {
            Some(TableFinding::ParameterReplaced { parameter, axes })
        }
        _ => None,
    }
}

/// Whether a kit uses what a fact belongs to; what cannot be judged counts as used.
pub(crate) fn uses(task: Task<'_>, plan: &Plan, tables: &Tables, mechanism: Mechanism) -> bool {
    match mechanism {
        Mechanism::Nothing => false,
        Mechanism::Metric => task.job.compensation.control_unit == ControlUnit::Millimetre,
        Mechanism::Inch => task.job.compensation.control_unit == ControlUnit::Inch,
        _ => family(task.profile).uses(mechanism, plan, tables),
    }
}

/// What the control's display shows once these tables act, a sentence each.
pub(crate) fn displayed(task: Task<'_>, compiled: &Compiled) -> Vec<String> {
    family(task.profile).displayed(&compiled.tables, &compiled.state)
}

fn profile_assumptions(task: Task<'_>, plan: &Plan, tables: &Tables) -> Vec<Assumption> {
    let stated = |fact: &str| fact == "axis_names"; // listed axis by axis below
    task.profile
        .statements
        .iter()
        .filter(|s| s.evidence == Evidence::Assumed && !stated(&s.fact))
        .map(|s| Assumption {
            fact: s.fact.clone(),
            value: s.value.clone(),
            evidence: s.evidence.word(),
            consequence: s.consequence.clone().unwrap_or_default(),
            to_decide: false,
            without_effect: s
                .mechanism
                .filter(|mechanism| !uses(task, plan, tables, *mechanism))
                .map(Mechanism::not_used),
        })
        .collect()
}

fn job_assumptions(task: Task<'_>, plan: &Plan) -> Vec<Assumption> {
    let names = default_names(task, plan);
    let parameter = task.profile.family.backlash_parameter;
    let parameters = counted_as_zero(task.job, plan).into_iter().map(|axis| {
        Assumption::of_job(
            format!("backlash_while_measuring_{}", axis.key()),
            "0",
            format!("the reversal of {axis} would be off by the {parameter} that was on: state `active_backlash_um`"),
        )
    });
    names.chain(parameters).chain(reference_directions(task, plan)).collect()
}

fn is_involved(plan: &Plan, axis: Axis) -> bool {
    let mut terms = plan.tables.iter().map(|t| t.term);
    terms.any(|term| term.of == axis || term.along == axis)
}

/// Names that the profile gives and the job does not state.
fn default_names(task: Task<'_>, plan: &Plan) -> impl Iterator<Item = Assumption> {
    let reach_axes = family(task.profile).names_reach_axes();
    let is_default = move |axis: &Axis| task.settings(*axis).is_none_or(|own| own.ids.is_empty());
    let axes = Axis::ALL.into_iter().filter(move |axis| reach_axes && is_involved(plan, *axis));
    axes.filter(is_default).map(|axis| {
        Assumption::of_job(
            format!("axis_name_{}", axis.key()),
            plan.names[axis].join(", "),
            format!(
                "tables would reach another axis: state `id` in [compensation.axes.{}]",
                axis.key()
            ),
        )
    })
}

/// Directions of the reference return that the job does not state, where two directions stand apart.
fn reference_directions(task: Task<'_>, plan: &Plan) -> impl Iterator<Item = Assumption> {
    let matters = move |axis: &Axis| {
        let policy = task.job.compensation.backlash[*axis];
        let separates = policy.is_some_and(|policy| policy != BacklashPolicy::Mean);
        let both_ways =
            task.model.measured_along(*axis).any(|(_, own)| own.measured.has_both_ways());
        let is_open = |machine: MachineAxis| machine.reference_direction.is_none();
        let open = task.job.machine.axes[*axis].is_some_and(is_open);
        separates && both_ways && open && is_involved(plan, *axis)
    };
    Axis::ALL.into_iter().filter(matters).map(|axis| {
        Assumption::of_job(
            format!("reference_direction_{}", axis.key()),
            "+",
            format!("the whole table of {axis} would be off by the reversal: state `reference_direction` in [machine.axes.{}]", axis.key()),
        )
    })
}

// Values that look like a slip of the pen: a lost motion of the wrong sign, a single value off its neighbours.

/// What to look at in the measured values before tables are made from them.
pub(super) fn slips(model: &ErrorModel) -> Vec<TableFinding> {
    let lone = model.measured().flat_map(|(term, measured)| {
        let is_near = |places: &[Millimetres], at: Millimetres| {
            let near = |mm: f64| at.mm() + mm;
            let next = places.partition_point(|place| place.mm() < near(-AT_PLACE_MM));
            places.get(next).is_some_and(|place| place.mm() <= near(AT_PLACE_MM))
        };
        let is_own = move |at: &&Millimetres| {
            measured.places.as_ref().is_none_or(|places| is_near(places, **at))
        };
        let ways = measured.measured.ways();
        ways.filter_map(move |(way, curve)| {
            let values =
                curve.knots().iter().filter(is_own).map(|at| (at.mm(), curve.at(*at).um()));
            lone_value(term, way, values.collect())
        })
    });
    unlikely_reversals(model).chain(lone).collect()
}

/// Ordinary lost motion gives B < 0 (contract §1); the other sign is more often a slip.
fn unlikely_reversals(model: &ErrorModel) -> impl Iterator<Item = TableFinding> {
    const NOISE_UM: f64 = 0.5; // below it the sign of B says nothing
    let unlikely = |term: ErrorTerm, um: f64| term.is_positioning() && um > NOISE_UM;
    model
        .measured()
        .filter_map(|(term, measured)| Some((term, measured.reversal()?.um())))
        .filter(move |(term, um)| unlikely(*term, *um))
        .map(|(term, um)| TableFinding::UnlikelyReversal { term, um })
}

/// Fewer values than these tell nothing of a single one.
const FEWEST: usize = 8;
/// So many times the others' distance from their neighbours is not the machine's shape.
const STANDS_OUT: f64 = 5.0;
/// Below it a value does no harm, µm.
const HARMLESS_UM: f64 = 1.0;

/// Of values at places, mm and µm: that without which all others lie on lines through their neighbours at least five times better than
/// it does. A bend or a jump is none: without one of its values the next one stands out.
fn lone_value(
    term: ErrorTerm,
    direction: Option<Direction>,
    mut points: Vec<(f64, f64)>,
) -> Option<TableFinding> {
    if points.len() < FEWEST {
        return None;
    }
    let (index, off_um) = worst(&points)?;
    points[index].1 -= off_um;
    let (_, rest_um) = worst(&points)?;
    let stands_out = off_um.abs() >= HARMLESS_UM && off_um.abs() > STANDS_OUT * rest_um.abs();
    stands_out.then(|| TableFinding::LoneValue {
        term,
        direction,
        at_mm: points[index].0,
        off_um,
        rest_um: rest_um.abs(),
    })
}

/// The value that is farthest off the line through its two neighbours, and by how much, µm.
fn worst(points: &[(f64, f64)]) -> Option<(usize, f64)> {
    let off = points.windows(3).map(|three| {
        let [(a, ya), (x, y), (b, yb)] = [three[0], three[1], three[2]];
        y - (ya + (yb - ya) * (x - a) / (b - a))
    });
    let off = off.enumerate().map(|(before, um)| (before + 1, um));
    off.max_by(|one, other| one.1.abs().total_cmp(&other.1.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position and size of the value that stands out of values at 0, 30, 60 … mm.
    fn lone(um: &[f64]) -> Option<(f64, f64)> {
        let values = (0u32..).map(|n| f64::from(n) * 30.0).zip(um.iter().copied()).collect();
        match lone_value(ErrorTerm::ALL[0], None, values)? {
            TableFinding::LoneValue { at_mm, off_um, .. } => Some((at_mm, off_um)),
            _ => None,
        }
    }

    #[test]
    fn a_wrong_sign_stands_out() {
        let mut um = [0.0, 1.1, 2.0, 2.9, 4.1, 5.0, 6.1, 6.9, 8.0, 9.1];
        assert_eq!(lone(&um), None, "a sound row");
        um[5] = -5.0;
        let (at, off) = lone(&um).unwrap();
        assert!((at - 150.0).abs() < 1e-9 && (off + 10.1).abs() < 1e-9, "{at} {off}");
    }

    #[test]
    fn bends_and_jumps_are_the_machine() {
        let bend = [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 10.0, 15.0, 20.0];
        let jump = [0.0, 0.0, 0.0, 0.0, 8.0, 8.0, 8.0, 8.0, 8.0];
        let wave = [0.0, 5.0, 7.0, 5.0, 0.0, -5.0, -7.0, -5.0, 0.0];
        for um in [bend, jump, wave] {
            assert_eq!(lone(&um), None, "{um:?}");
        }
    }

    #[test]
    fn a_few_values_tell_nothing() {
        assert_eq!(lone(&[0.0, 1.0, 9.0, 3.0, 4.0]), None);
    }
}
