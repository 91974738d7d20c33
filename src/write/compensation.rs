//! The plan in a control's own numbers: rounded once, numbered, within its limits.
//!
//! ```text
//!   Plan ─→ siemens | fanuc | generic ─→ Compiled { tables, state, assumptions, preconditions }
//! ```
//! Deviations become table values through [`crate::control::controller::TableSign`], the only place where
//! a profile's sense of a table enters. Rounding is half away from zero, on totals, so no point
//! is off by more than half a count.

pub mod fanuc;
pub mod four_point;
pub mod generic;
pub mod siemens;

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{Dialect, Evidence, LengthUnit, Mechanism, StraightnessForm};
use crate::control::table::Tables;
use crate::inputs::job::{ActiveTables, AxisSettings, BacklashPolicy, Job};
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::text::problem::Problems;
use crate::write::grid::EDGE_MM;
use crate::write::plan::{Plan, Task};

/// Where one planned table went and how coarse it is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Which error.
    pub term: ErrorTerm,
    /// Direction of the moving axis it acts in; `None` = both.
    pub direction: Option<Direction>,
    /// The place in the control's words, e.g. `ENC_COMP[0,AX1]` or `points 0…30`.
    pub place: String,
    /// Number of points.
    pub points: usize,
    /// The smallest step the table can express, µm (contract §1, count).
    pub count_um: f64,
    /// Largest difference of curve and unrounded table over the whole axis, µm.
    pub grid_residual_um: f64,
    /// What the form of the control leaves at its points beyond rounding, µm (four-point
    /// straightness only).
    pub fit_residual_um: Option<f64>,
}

/// A kit before it becomes text.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// What the files will write.
    pub tables: Tables,
    /// Where each planned table went.
    pub placements: Vec<Placement>,
    /// The state of the control that the job states or requires.
    pub state: ControlState,
    /// What is assumed.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Puts a plan into the numbers of the task's control; all problems are given at once.
pub fn compile(task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
    let mut compiled = match &task.profile.dialect {
        Dialect::Siemens(facts) => siemens::compile(task, plan, facts)?,
        Dialect::Fanuc(facts) => fanuc::compile(task, plan, facts)?,
        Dialect::Generic(_) => generic::compile(task, plan),
    };
    let mut assumptions = profile_assumptions(task, plan, &compiled.tables);
    assumptions.extend(job_assumptions(task, plan));
    assumptions.append(&mut compiled.assumptions);
    assumptions.sort_by_key(|assumption| assumption.without_effect.is_some()); // those that matter first
    compiled.assumptions = assumptions;
    let mut notes = plan.notes.clone();
    notes.extend(task.job.measurement.notes.iter().cloned());
    notes.extend(task.model.remarks.notes.iter().cloned());
    notes.extend(task.model.unused.iter().cloned());
    notes.extend(unlikely_reversals(task));
    notes.extend(references_off_the_travel(task.job, plan));
    notes.append(&mut compiled.notes);
    notes.extend(active_note(&task.job.measurement.active));
    notes.extend(parameter_note(task.job, plan));
    compiled.notes = notes;
    Ok(compiled)
}

/// Moving axes of the tables that do not reach their reference point by the travel of the job. Some
/// machines have it just beyond; a slip of the job has it far off.
fn references_off_the_travel(job: &Job, plan: &Plan) -> Vec<String> {
    let is_looked_up = |axis: Axis| plan.tables.iter().any(|table| table.term.along == axis);
    let off_the_travel = |axis: Axis| {
        let of = job.machine.axes[axis].as_ref()?;
        let (low, high, at) = (of.low.mm(), of.high.mm(), of.reference.mm());
        let beyond = (low - at).max(at - high);
        (beyond > EDGE_MM).then(|| {
            format!(
                "the reference point of {axis}, {at} mm, lies {beyond:.2} mm outside the travel of the job, {low} to {high} mm: compare `reference_mm` and `travel_mm` with the machine; if the axis has its reference point elsewhere, switching a table on moves axes"
            )
        })
    };
    let axes = Axis::ALL.into_iter().filter(|axis| is_looked_up(*axis));
    axes.filter_map(off_the_travel).collect()
}

/// What the tables suppose of the compensation that was active while measuring.
fn active_note(active: &ActiveTables) -> Option<String> {
    match active {
        ActiveTables::None | ActiveTables::NotStated => None,
        ActiveTables::Path(path) => Some(format!(
            "the tables of `{path}` were active during the measurement: these tables are old + residual and replace them"
        )),
    }
}

/// Whether the backlash parameter of an axis counts as 0 while measuring because nothing says what
/// it was. Where files are named it has to be known (`active`).
fn counts_as_zero(job: &Job, axis: Axis) -> bool {
    let measurement = &job.measurement;
    let stated = measurement.active_settings.backlash_um[axis];
    !matches!(measurement.active, ActiveTables::Path(_)) && stated.is_none()
}

/// Axes of which the tables replace a backlash parameter that counts as 0 while measuring.
fn counted_as_zero(job: &Job, plan: &Plan) -> Vec<Axis> {
    let axes = Axis::ALL.into_iter();
    axes.filter(|axis| plan.sets_backlash(*axis) && counts_as_zero(job, *axis))
        .collect()
}

/// What `"none"` says of the backlash parameters that the tables replace.
fn parameter_note(job: &Job, plan: &Plan) -> Option<String> {
    let axes = counted_as_zero(job, plan);
    if axes.is_empty() || job.measurement.active != ActiveTables::None {
        return None;
    }
    let axes: Vec<String> = axes.iter().map(Axis::to_string).collect();
    Some(format!(
        "the tables replace the backlash parameter of {} (MD32450, 1851), which is counted as 0 while measuring; a machine normally holds one even with its tables off: look, and if it was on, state `active_backlash_um = {{ … }}` beside `active_while_measuring = \"none\"`",
        axes.join(", ")
    ))
}

/// Why the backlash parameter of an axis has to be −B.
pub(crate) fn backlash_why(job: &Job, axis: Axis) -> &'static str {
    if counts_as_zero(job, axis) {
        "−B of the measurement, which counts the backlash parameter as 0 while measuring (else state `active_backlash_um`); the table holds the curve of the reference direction"
    } else {
        "−B of the machine without compensation: the parameter that was active while measuring is contained in it; the table holds the curve of the reference direction"
    }
}

/// Why the backlash parameter of an axis with two tables has to be 0.
pub(crate) fn two_tables_why(job: &Job, axis: Axis) -> &'static str {
    if counts_as_zero(job, axis) {
        "the reversal is in the two tables; counted twice it would turn round. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)"
    } else {
        "the reversal is in the two tables, with the parameter that was active while measuring; counted twice it would turn round"
    }
}

/// Ordinary lost motion gives B < 0 (contract §1); the other sign is more often a slip.
fn unlikely_reversals(task: Task<'_>) -> Vec<String> {
    const NOISE_UM: f64 = 0.5; // below it the sign of B says nothing
    let unlikely = |term: ErrorTerm, um: f64| term.is_positioning() && um > NOISE_UM;
    task.model
        .measured()
        .filter_map(|(term, measured)| Some((term, measured.reversal()?.um())))
        .filter(|(term, um)| unlikely(*term, *um))
        .map(|(term, um)| {
            format!("{term}: B = {um:+.3} µm is above 0, ordinary lost motion gives B < 0: are the directions + and - exchanged?")
        })
        .collect()
}

/// Whether a kit uses what a fact belongs to; what cannot be judged counts as used.
pub(crate) fn uses(task: Task<'_>, plan: &Plan, tables: &Tables, mechanism: Mechanism) -> bool {
    let cross = plan.tables.iter().any(|t| t.term.is_cross());
    let has_form = |form| matches!(&task.profile.dialect, Dialect::Fanuc(facts) if facts.straightness_form.value == form);
    match (mechanism, tables) {
        (Mechanism::Nothing, _) => false,
        (Mechanism::Metric, _) => task.job.compensation.control_unit == LengthUnit::Millimetre,
        (Mechanism::Inch, _) => task.job.compensation.control_unit == LengthUnit::Inch,
        (Mechanism::EncComp, Tables::Siemens(tables)) => !tables.lec.is_empty(),
        (Mechanism::Cec, Tables::Siemens(tables)) => !tables.cec.is_empty(),
        (Mechanism::CecProducts, Tables::Siemens(tables)) => {
            tables.cec.iter().any(|table| table.multiply_by != 0)
        }
        (Mechanism::Pitch, Tables::Fanuc(_)) => plan.tables.iter().any(|t| t.term.is_positioning()),
        (Mechanism::Bidirectional, Tables::Fanuc(_)) => {
            plan.tables.iter().any(|t| t.direction.is_some())
        }
        (Mechanism::Straightness, Tables::Fanuc(_)) => cross,
        (Mechanism::FourPoint, Tables::Fanuc(_)) => cross && has_form(StraightnessForm::FourPoint),
        (Mechanism::PerPoint, Tables::Fanuc(_)) => cross && has_form(StraightnessForm::PerPoint),
        _ => true,
    }
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
            without_effect: s
                .mechanism
                .filter(|mechanism| !uses(task, plan, tables, *mechanism))
                .map(Mechanism::not_used),
        })
        .collect()
}

fn job_assumptions(task: Task<'_>, plan: &Plan) -> Vec<Assumption> {
    let mut assumptions = Vec::new();
    let involved = |axis: Axis| {
        plan.tables
            .iter()
            .any(|t| t.term.of == axis || t.term.along == axis)
    };
    for axis in plan.default_names.iter().filter(|axis| involved(**axis)) {
        if !matches!(task.profile.dialect, Dialect::Generic(_)) {
            assumptions.push(Assumption::of_job(
                format!("axis_name_{}", axis.key()),
                plan.names[*axis].join(", "),
                format!(
                    "tables would reach another axis: state `id` in [compensation.axes.{}]",
                    axis.key()
                ),
            ));
        }
    }
    for axis in counted_as_zero(task.job, plan) {
        assumptions.push(Assumption::of_job(
            format!("backlash_while_measuring_{}", axis.key()),
            "0",
            format!("the reversal of {axis} would be off by the parameter that was on (MD32450, 1851): state `active_backlash_um`"),
        ));
    }
    let separates = task
        .job
        .compensation
        .backlash
        .is_some_and(|p| p != BacklashPolicy::Mean);
    let both_ways = |axis: Axis| {
        task.model
            .measured()
            .any(|(term, measured)| term.along == axis && measured.measured.has_both_ways())
    };
    for axis in Axis::ALL
        .into_iter()
        .filter(|axis| separates && involved(*axis) && both_ways(*axis))
    {
        let stated =
            task.job.machine.axes[axis].is_none_or(|machine| machine.reference_direction.is_some());
        if !stated {
            assumptions.push(Assumption::of_job(
                format!("reference_direction_{}", axis.key()),
                "+",
                format!("the whole table of {axis} would be off by the reversal: state `reference_direction` in [machine.axes.{}]", axis.key()),
            ));
        }
    }
    assumptions
}

/// The state of the control that the job states: one entry for each physical axis.
/// `backlash_um` is what the backlash parameter will hold, −B rounded as it is named.
fn control_state(task: Task<'_>, plan: &Plan, backlash_um: impl Fn(Axis) -> f64) -> ControlState {
    let mut axes = Vec::new();
    for (axis, names) in plan.names.iter() {
        let Some(machine) = task.job.machine.axes[axis] else {
            continue;
        };
        let settings = task.job.compensation.axes[axis].as_ref();
        let own = |directed: bool| {
            plan.tables.iter().any(|t| {
                t.term.is_positioning() && t.term.of == axis && t.direction.is_some() == directed
            })
        };
        for name in names {
            axes.push(AxisState {
                name: name.clone(),
                reference: machine.reference,
                reference_direction: machine.homing(),
                detection_unit_um: settings.and_then(|s| s.detection_unit_um),
                backlash_um: backlash_um(axis),
                bidirectional: own(true),
                interpolated: settings.is_some_and(AxisSettings::is_interpolated),
            });
        }
    }
    ControlState {
        unit: task.job.compensation.control_unit,
        axes,
    }
}
