//! Measured errors − old correction: the machine without compensation.
//!
//! ```text
//!   measured(x) + (−old)(x),   knots of both; the old tables over the whole range they have
//! ```
//! Outside the measured range the residual is held and the old correction goes on, so what the
//! old tables knew there is kept. Tables that a control plays in steps: at the measured positions
//! the steps themselves are taken off, between them the straight line through the nodes, which is
//! what the steps stand for; at the nodes both are the same.

use super::reading::{ActiveControl, KEY, Origin, at_key, axis_of};
use crate::control::control_state::ControlState;
use crate::control::controller::Profile;
use crate::inputs::job::{BacklashPolicy, Job, NotMeasured};
use crate::judge::field::{Field, Pair};
use crate::judge::findings::{InControl, InSum, joined};
use crate::judge::refusals;
use crate::machine::model::{ErrorModel, MeasuredTerm, TermCurves};
use crate::quantity::{
    AT_PLACE_MM, Axis, Deviation, Direction, ErrorCurve, ErrorTerm, Interpolation, Millimetres,
    PerAxis, Rotation,
};
use crate::read::emulate::{CannotEmulate, Emulated, Emulator, Response};
use crate::read::emulator;
use crate::text::{Problem, Problems};
use crate::write::plan::{axis_names, axis_pairs, replaces_backlash};
use crate::write::target::wants;

/// Corrections below it are none, µm.
const NOTHING_UM: f64 = 1e-6;
/// A table may be off zero at the reference by less than what is shown, µm.
const ZERO_UM: f64 = 1e-3;

/// The model of the machine without compensation, what the old tables added, and what the user should know of it. A term that
/// was measured in one direction counts in both where the old tables tell them apart.
///
/// unit   as the measured model: µm, zero at the reference
/// limits refused where the old tables correct what was not measured or is not asked for, are not
///        zero at the reference, hold angles, repeat, differ between the axes of a gantry, or where a
///        backlash parameter that is replaced is not known
pub(crate) fn uncompensated(
    job: &Job,
    profile: &Profile,
    measured: &mut ErrorModel,
    active: &ActiveControl,
) -> Result<(ErrorModel, Field, Vec<InSum>), Problems> {
    let names = axis_names(job, profile)?;
    let sets = |axis: Axis| sets_backlash(job, profile, measured, axis);
    check_backlash(job, active, sets)?;
    let state = acting_state(&names, active, sets);
    let control = emulator(profile, &active.tables, &state).map_err(|e| cannot(job, &e))?;
    let mut problems = Problems::none();
    if let Some(active) = angles_active(job, &names, control.as_ref()) {
        problems.push(active);
    }
    let mut sum = Sum { job, model: measured.clone(), measured, notes: Vec::new() };
    let (mut acts, mut added) = (false, Field::default());
    for term in ErrorTerm::ALL {
        let pairs = axis_pairs(&names, term);
        let old = problems.take(old_correction(job, term, &pairs, control.as_ref()));
        if let Some(old) = old.flatten() {
            acts = true;
            sum.add(term, &old, &mut problems);
            added.put(term, old);
        }
    }
    let knows_backlash = active.backlash_um.iter().any(|(_, um)| um.is_some());
    let tables = control.connected_axes().into_iter();
    let tables = joined(tables.map(|(base, output)| format!("{base} → {output}")));
    if !acts && !tables.is_empty() {
        sum.notes.push(InSum::Zeros { tables });
    } else if !acts && !knows_backlash && problems.is_empty() {
        problems.push(nothing(job, active));
    }
    problems.or_ok((sum.model, added, sum.notes))
}

/// Refuses an angle that the old tables take off.
fn angles_active(
    job: &Job,
    names: &PerAxis<Vec<String>>,
    control: &dyn Emulator,
) -> Option<Problem> {
    let is_held = |rotation: &Rotation| {
        let name = names[rotation.along].first();
        name.is_some_and(|name| control.rotation(name, rotation.about).is_some())
    };
    let rotation = Rotation::all().find(is_held)?;
    Some(at_key(job, refusals::angles_active(rotation)))
}

fn cannot(job: &Job, reason: &CannotEmulate) -> Problems {
    at_key(job, refusals::not_determined(&reason.0)).into()
}

/// No table of the job's axes at all.
fn nothing(job: &Job, active: &ActiveControl) -> Problem {
    let is_passed_over = |finding: &InControl| {
        use InControl::{OfOthers, OtherSystem, SwitchedOff};
        matches!(finding, OfOthers { .. } | OtherSystem { .. } | SwitchedOff { .. })
    };
    let passed_over = active.findings.iter().filter(|f| f.kind().is_some_and(is_passed_over));
    let passed_over: Vec<String> = passed_over.map(ToString::to_string).collect();
    let found = match passed_over.as_slice() {
        [] => "the files hold no correction at all".to_string(),
        some => some.join("; "),
    };
    at_key(job, refusals::nothing_active(found))
}

/// Axes of which the new tables set the backlash parameter.
fn sets_backlash(job: &Job, profile: &Profile, measured: &ErrorModel, axis: Axis) -> bool {
    use BacklashPolicy::{CurveAndParameter, TwoTables};
    let term = ErrorTerm::positioning(axis);
    let by_policy = matches!(job.compensation.backlash[axis], Some(TwoTables | CurveAndParameter));
    let is_set = by_policy || replaces_backlash(profile);
    is_set && measured.terms[term].is_some() && wants(job, term)
}

fn check_backlash(
    job: &Job,
    active: &ActiveControl,
    sets: impl Fn(Axis) -> bool,
) -> Result<(), Problems> {
    if active.origin == Origin::NoTables {
        return Ok(()); // what is not stated is counted as 0, and the kit says so
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        if sets(axis) && active.backlash_um[axis].is_none() {
            problems.push(at_key(job, refusals::no_backlash(axis)));
        }
    }
    problems.or_ok(())
}

/// The state without the backlash parameters that act before and after alike.
fn acting_state(
    names: &PerAxis<Vec<String>>,
    active: &ActiveControl,
    sets: impl Fn(Axis) -> bool,
) -> ControlState {
    let mut state = active.state.clone();
    for axis in &mut state.axes {
        if !axis_of(names, &axis.name).is_some_and(&sets) {
            axis.backlash_um = 0.0;
        }
    }
    state
}

/// Whether any correction is felt.
fn acts(old: &Pair) -> bool {
    differs(&old.straightened(), &Pair::default())
}

fn differs(one: &Pair, other: &Pair) -> bool {
    let places = [one.nodes(), other.nodes(), vec![Millimetres::new(0.0)]].concat();
    Direction::BOTH.into_iter().any(|way| {
        let um = |of: &Pair, at: &Millimetres| of.way(way).correction(*at).um();
        places.iter().any(|at| (um(one, at) - um(other, at)).abs() > NOTHING_UM)
    })
}

/// The old correction of a term; `None` where there is none.
fn old_correction(
    job: &Job,
    term: ErrorTerm,
    pairs: &[(&str, &str)],
    control: &dyn Emulator,
) -> Result<Option<Pair>, Problems> {
    if [term.of, term.along].iter().any(|axis| job.machine.axes[*axis].is_none()) {
        return Ok(None); // the job has no such axis
    }
    let all = pairs.iter().map(|(base, output)| Pair::of(control, base, output));
    let all: Vec<Pair> = all.collect::<Emulated<_>>().map_err(|reason| cannot(job, &reason))?;
    if let Some(index) = (1..all.len()).find(|index| differs(&all[0], &all[*index])) {
        let (first, other) = (pairs[0].1, pairs[index].1);
        return Err(at_key(job, refusals::gantry_differs(term, first, other)).into());
    }
    if all.iter().flat_map(Pair::tables).any(|table| table.modulo) {
        return Err(at_key(job, refusals::repeats(term)).into());
    }
    Ok(all.into_iter().next().filter(acts))
}

/// The model that grows term by term.
struct Sum<'a> {
    job: &'a Job,
    measured: &'a mut ErrorModel,
    model: ErrorModel,
    notes: Vec<InSum>,
}

impl Sum<'_> {
    fn add(&mut self, term: ErrorTerm, old: &Pair, problems: &mut Problems) {
        let Some(machine) = self.job.machine.axes[term.along] else {
            return;
        };
        let zero = old.way(machine.homing()).correction(machine.reference);
        let settings = &self.job.measurement.active_settings;
        if zero.um().abs() > ZERO_UM && !settings.rezero {
            let wrong = refusals::not_zero(term, zero.um(), machine.reference.mm());
            problems.push(at_key(self.job, wrong));
            return;
        }
        let refused = match (&self.model.terms[term], settings.not_measured) {
            (None, None) => Some(at_key(self.job, refusals::not_measured(term))),
            (None, Some(NotMeasured::Drop)) => {
                self.notes.push(InSum::Dropped { term });
                return;
            }
            (_, Some(NotMeasured::Drop)) => None,
            _ => (!wants(self.job, term)).then(|| not_asked(self.job, term)),
        };
        match refused {
            Some(refused) => problems.push(refused),
            None => self.put(term, old, -zero),
        }
    }

    fn put(&mut self, term: ErrorTerm, old: &Pair, zero: Deviation) {
        let kind = self.job.compensation.curve;
        let nodes = old.nodes();
        let held = |direction| held(old.way(direction), &nodes, zero);
        let Some(own) = &mut self.measured.terms[term] else {
            self.notes.push(InSum::Kept { term });
            let (plus, minus) = (held(Direction::Plus), held(Direction::Minus));
            self.model.terms[term] = Some(MeasuredTerm::new(one_if_same(plus, minus), Vec::new()));
            return;
        };
        let with = |curve: &ErrorCurve, direction| {
            let steps = steps(old.way(direction), curve, &nodes, kind);
            steps.map_or_else(|| curve.clone(), |steps| curve.plus(&steps)).plus(&held(direction))
        };
        let both = |curve: &ErrorCurve| {
            one_if_same(with(curve, Direction::Plus), with(curve, Direction::Minus))
        };
        let measured = match &own.measured {
            TermCurves::OneWay(direction, curve) => match both(curve) {
                TermCurves::Undirected(sum) => TermCurves::OneWay(*direction, sum),
                apart => apart,
            },
            TermCurves::BothWays { plus, minus } => TermCurves::BothWays {
                plus: with(plus, Direction::Plus),
                minus: with(minus, Direction::Minus),
            },
            TermCurves::Undirected(curve) => both(curve),
        };
        if measured.has_both_ways() && !own.measured.has_both_ways() {
            own.count_both_ways();
            self.notes.push(InSum::DirectionsKept { term });
        }
        let places = Some(own.measured.mean().knots().to_vec());
        self.model.terms[term] = Some(MeasuredTerm { measured, places, ..own.clone() });
    }
}

/// One curve where both directions are the same.
fn one_if_same(plus: ErrorCurve, minus: ErrorCurve) -> TermCurves {
    let same = |at: &Millimetres| (plus.at(*at) - minus.at(*at)).um().abs() <= NOTHING_UM;
    if plus.knots().iter().chain(minus.knots()).all(same) {
        TermCurves::Undirected(plus)
    } else {
        TermCurves::BothWays { plus, minus }
    }
}

/// The deviation that a response cancels, straight from node to node, less its zero.
fn held(response: &Response, nodes: &[Millimetres], zero: Deviation) -> ErrorCurve {
    let straight = response.straightened();
    let anywhere = [Millimetres::new(0.0)];
    let nodes = if nodes.is_empty() { &anywhere } else { nodes };
    let values: Vec<Deviation> = nodes.iter().map(|at| -straight.correction(*at) - zero).collect();
    ErrorCurve::through(nodes, &values, Interpolation::Linear)
}

/// What the steps of a control add to the straight line at the measured positions, as the
/// deviation it cancels; `None` where the control plays straight lines.
fn steps(
    response: &Response,
    measured: &ErrorCurve,
    nodes: &[Millimetres],
    kind: Interpolation,
) -> Option<ErrorCurve> {
    let straight = response.straightened();
    let extra = |at: &Millimetres| {
        let near = |node: &Millimetres| (node.mm() - at.mm()).abs() < AT_PLACE_MM;
        match nodes.iter().any(near) {
            true => Deviation::ZERO,
            false => -response.correction(*at) - -straight.correction(*at),
        }
    };
    let extra: Vec<Deviation> = measured.knots().iter().map(extra).collect();
    let any = extra.iter().any(|d| d.um().abs() > NOTHING_UM);
    any.then(|| ErrorCurve::through(measured.knots(), &extra, kind))
}

fn not_asked(job: &Job, term: ErrorTerm) -> Problem {
    let path = if job.source.place_of("compensation.terms").is_some() {
        "compensation.terms"
    } else {
        KEY
    };
    job.source.at(path, refusals::not_asked(term))
}
