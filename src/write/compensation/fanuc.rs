//! Fanuc: pitch increments for positioning, straightness sets for the cross terms.
//!
//! ```text
//!   point number   Nmin … N0 │ N0+1 … Nmax          point n is the section from node n−1 to n
//!   node (index)       … −1  0   1   …              node 0 is the reference point, N0 in 3620
//!   data(n) = total(n) − total(n−1),  total = round(correction / count),  total(0) = 0
//! ```
//! Each increment is a difference of rounded **totals**, so rounding never adds up and no node is
//! off by more than half a count (count = magnification × detection unit). N0 and N0+1 are
//! always in the table, zero where there is no travel, so 3621 ≤ 3620 < 3622.

mod form;
mod numbers;
mod output;
mod requirements;
mod straightness;

use self::output::{Curve, Output, Totals, magnify, steepest_um, too_steep, wanted};

use self::form::detection_unit;

use crate::control::controller::{FanucFacts, IntervalForm};
use crate::control::table::Tables;
use crate::control::table::fanuc::{ParameterKey, ParameterValue};
use crate::inputs::job::AxisSettings;
use crate::quantity::axis::Direction;
use crate::text::problem::{Problem, Problems};
use crate::write::compensation::compiled::control_state;
use crate::write::compensation::{Compiled, Placement};
use crate::write::grid::Grid;
use crate::write::plan::{Plan, PlannedTable, Task};
use numbers::{Run, Space};

/// Puts a plan into parameters and points.
pub fn compile(task: Task<'_>, plan: &Plan, facts: &FanucFacts) -> Result<Compiled, Problems> {
    let mut problems = Problems::none();
    let mut space = Space::reserving(&task.job.compensation.reserved_points);
    let runs = numbers::runs(task, plan, facts, &mut space, &mut problems);
    let mut out = Output::default();
    for run in &runs {
        write_pitch(task, plan, facts, run, &mut out, &mut problems);
    }
    straightness::write(
        task,
        plan,
        facts,
        &runs,
        &mut space,
        &mut out,
        &mut problems,
    );
    let state = control_state(task, plan, |axis| {
        requirements::backlash_counts(task, plan, axis)
            .map_or(0.0, |(counts, unit_um)| counts * unit_um)
    });
    requirements::check_backlash(task, plan, &mut problems);
    out.placements.sort_by_key(|p| {
        plan.tables
            .iter()
            .position(|t| (t.term, t.direction) == (p.term, p.direction))
    });
    problems.or_ok(Compiled {
        assumptions: requirements::assumptions(task, plan, &runs),
        preconditions: requirements::preconditions(task, plan, facts, &runs),
        notes: out.notes,
        tables: Tables::Fanuc(out.memory),
        placements: out.placements,
        state,
    })
}

impl Output {
    fn parameter(&mut self, number: u32, axis: Option<u32>, value: ParameterValue) {
        self.memory
            .parameters
            .insert(ParameterKey { number, axis }, value);
    }

    fn integer(&mut self, number: u32, axis: Option<u32>, value: impl Into<i64>) {
        self.parameter(number, axis, ParameterValue::Integer(value.into()));
    }
}

/// Parameter 3627 is a signed word; parameter manual B-63530EN, from memory.
const LARGEST_REVERSAL: i64 = 32767;

fn too_large_a_reversal(task: Task<'_>, run: &Run, reversal: i64, unit_um: f64) -> Problem {
    task.job
        .problem_at(
            &format!("compensation.axes.{}.detection_unit_um", run.axis.key()),
            format!(
                "the reversal of axis {} at the reference is {reversal} × {unit_um} µm, more than ±{LARGEST_REVERSAL} that parameter 3627 holds",
                run.axis
            ),
        )
        .help("check the measurement and `detection_unit_um`")
}

/// Pitch parameters and data of one physical axis.
fn write_pitch(
    task: Task<'_>,
    plan: &Plan,
    facts: &FanucFacts,
    run: &Run,
    out: &mut Output,
    problems: &mut Problems,
) {
    let tables: Vec<&PlannedTable> = plan
        .tables
        .iter()
        .filter(|t| t.term.is_positioning() && t.term.of == run.axis)
        .collect();
    let unit_um = detection_unit(task, run.axis);
    let homing = task.job.machine.axes[run.axis].map_or(Direction::Plus, |axis| axis.homing());
    let curves: Vec<Curve> = tables
        .iter()
        .map(|planned| Curve {
            wanted_um: wanted(planned, facts.pitch_sign.value),
            carries_reversal: planned
                .direction
                .is_some_and(|direction| direction != homing),
        })
        .collect();
    let Some((magnification, reversal, totals)) = magnify(facts, run.grid, &curves, unit_um) else {
        let steepest = tables
            .iter()
            .max_by(|a, b| steepest_um(a).total_cmp(&steepest_um(b)));
        if let Some(planned) = steepest {
            problems.push(too_steep(task, facts, planned, unit_um));
        }
        return;
    };
    if reversal.abs() > LARGEST_REVERSAL {
        problems.push(too_large_a_reversal(task, run, reversal, unit_um));
        return;
    }
    write_pitch_parameters(task, facts, run, magnification, out);
    let by_direction = |wanted: Option<Direction>| {
        let index = tables
            .iter()
            .position(|t| t.direction.is_none() || t.direction == wanted);
        index.map(|index| &totals[index])
    };
    write_points(run.first, run, by_direction(Some(Direction::Plus)), out);
    if let Some(second) = run.minus_first {
        out.integer(3626, Some(run.id), second);
        out.integer(3627, Some(run.id), reversal);
        write_points(second, run, by_direction(Some(Direction::Minus)), out);
    }
    place_pitch(&tables, run, unit_um * f64::from(magnification), out);
}

fn write_pitch_parameters(
    task: Task<'_>,
    facts: &FanucFacts,
    run: &Run,
    magnification: u32,
    out: &mut Output,
) {
    let id = Some(run.id);
    out.integer(3620, id, run.reference_point());
    out.integer(3621, id, run.first);
    out.integer(3622, id, run.last());
    out.integer(3623, id, magnification);
    out.parameter(3624, id, interval(facts, &run.grid));
    let settings = task.job.compensation.axes[run.axis].as_ref();
    if let Some(found) = settings.and_then(|s| s.parameter_3605) {
        let interpolated = settings.is_some_and(AxisSettings::is_interpolated);
        let bits =
            (found & !0b11) | u8::from(run.minus_first.is_some()) | (u8::from(interpolated) << 1);
        out.parameter(3605, id, ParameterValue::Bits(bits));
    }
}

#[allow(
    clippy::cast_precision_loss,
    reason = "intervals are far below 2^52 digits"
)]
fn interval(facts: &FanucFacts, grid: &Grid) -> ParameterValue {
    match facts.interval_form.value {
        IntervalForm::Integer => ParameterValue::Integer(grid.spacing_digits),
        IntervalForm::Real => {
            ParameterValue::Real(grid.spacing_digits as f64 / grid.digit.per_unit())
        }
    }
}

/// All points of a run; zero where nothing is compensated.
fn write_points(first: u32, run: &Run, totals: Option<&Totals>, out: &mut Output) {
    for offset in 0..run.count {
        let node = run.lowest + i64::from(offset);
        let increment = totals.map_or(0, |t| t.increment(node));
        out.memory
            .points
            .insert(first + offset, i32::try_from(increment).unwrap_or(0));
    }
}

fn place_pitch(tables: &[&PlannedTable], run: &Run, count_um: f64, out: &mut Output) {
    if tables.is_empty() {
        out.notes.push(format!(
            "{}: the pitch points of axis {} are all zero; they carry the straightness of other axes only",
            run.axis, run.id
        ));
    }
    for planned in tables {
        let first = match planned.direction {
            Some(Direction::Minus) => run.minus_first.unwrap_or(run.first),
            _ => run.first,
        };
        let place = format!("axis {}: points {first}…{}", run.id, first + run.count - 1);
        out.place(planned, place, run.count, count_um, None);
    }
}

impl Output {
    /// Notes where a planned table went; a second physical axis of a gantry joins the first.
    fn place(
        &mut self,
        planned: &PlannedTable,
        place: String,
        points: u32,
        count_um: f64,
        fit_residual_um: Option<f64>,
    ) {
        let known = self
            .placements
            .iter_mut()
            .find(|p| p.term == planned.term && p.direction == planned.direction);
        if let Some(known) = known {
            known.place = format!("{}; {place}", known.place);
            return;
        }
        self.placements.push(Placement {
            term: planned.term,
            direction: planned.direction,
            place,
            points: points as usize,
            count_um,
            grid_residual_um: planned.grid_residual_um,
            fit_residual_um,
        });
    }
}
