//! Which curve each table has to cancel: the backlash policy applied to the measured terms.

pub use crate::write::task::{Omission, Target, TermTargets};

use crate::inputs::job::{ActiveTables, BacklashPolicy, Job, WantedTerms, one_for_all};
use crate::machine::model::{MeasuredTerm, TermCurves};
use crate::quantity::{Axis, Direction, ErrorCurve, ErrorTerm};
use crate::text::{Problem, Problems, joined};
use crate::write::family::family;
use crate::write::refusals;
use crate::write::task::Task;

/// The targets of all wanted terms, and the terms that are not wanted or not determined.
pub fn targets(task: Task<'_>) -> Result<(Vec<TermTargets>, Vec<Omission>), Problems> {
    let Task { job, profile, model } = task;
    let mut problems = Problems::none();
    check_wanted(task, &mut problems);
    check_policy(task, &mut problems);
    check_one_way(task, &mut problems);
    let mut targets = Vec::new();
    let mut omitted = Vec::new();
    for (term, measured) in model.measured() {
        if let Some(reason) = family(profile).refuses(term) {
            omitted.push(Omission { term, reason });
        } else if wants(job, term) {
            if let Some(of_term) = problems.take(term_targets(task, term, measured)) {
                targets.push(of_term);
            }
        } else {
            omitted.push(Omission { term, reason: "not listed in `terms` of the job".to_string() });
        }
    }
    let missing = model.remarks.not_determined.iter();
    let missing = missing.filter(|(term, _)| model.terms[*term].is_none());
    omitted.extend(missing.map(|(term, why)| Omission {
        term: *term,
        reason: format!("not determined by the measurement: {why}"),
    }));
    problems.or_ok((targets, omitted))
}

/// Whether the job asks for a table of a term.
pub(crate) fn wants(job: &Job, term: ErrorTerm) -> bool {
    match &job.compensation.terms {
        WantedTerms::All => true,
        WantedTerms::Listed(terms) => terms.contains(&term),
    }
}

fn check_wanted(task: Task<'_>, problems: &mut Problems) {
    let WantedTerms::Listed(terms) = &task.job.compensation.terms else {
        return;
    };
    for term in terms.iter().filter(|term| task.model.terms[**term].is_none()) {
        problems.push(task.job.source.at("compensation.terms", refusals::term_not_measured(term)));
    }
}

/// The wanted errors along an axis.
fn along(task: Task<'_>, axis: Axis) -> impl Iterator<Item = (ErrorTerm, &TermCurves)> {
    let own = task.model.measured_along(axis).filter(move |(term, _)| wants(task.job, *term));
    own.map(|(term, measured)| (term, &measured.measured))
}

fn check_policy(task: Task<'_>, problems: &mut Problems) {
    let both_ways = |axis: &Axis| along(task, *axis).any(|(_, m)| m.has_both_ways());
    let policies = &task.job.compensation.backlash;
    let is_open = |axis: &Axis| policies[*axis].is_none() && both_ways(axis);
    if Axis::ALL.iter().any(is_open) {
        let wrong = refusals::no_policy(known_how(task.job));
        problems.push(task.job.source.at("compensation", wrong));
    }
    check_directions(task, problems);
}

/// A policy for two directions needs errors that have them: along the axis that it is stated for; one for all
/// axes, along any of them.
fn check_directions(task: Task<'_>, problems: &mut Problems) {
    let (job, policies) = (task.job, &task.job.compensation.backlash);
    let is_directed =
        |axis: &Axis| along(task, *axis).any(|(_, m)| !matches!(m, TermCurves::Undirected(_)));
    let for_all = one_for_all(policies);
    if for_all && Axis::ALL.iter().any(is_directed) {
        return;
    }
    let stated = Axis::ALL.into_iter().take(if for_all { 1 } else { 3 });
    for axis in stated.filter(|axis| !is_directed(axis)) {
        let needs_both = [BacklashPolicy::TwoTables, BacklashPolicy::CurveAndParameter];
        let Some(policy) = policies[axis].filter(|policy| needs_both.contains(policy)) else {
            continue;
        };
        let (key, word) = (axis.key(), policy.word());
        problems.push(if for_all {
            job.source.at("compensation.backlash", refusals::no_directions(word))
        } else {
            let found = match along(task, axis).next() {
                Some(_) => "those of the job have no direction",
                None => "the job compensates none",
            };
            let wrong = refusals::no_directions_along(key, word, axis, found);
            job.source.at(&format!("compensation.backlash.{key}"), wrong)
        });
    }
}

/// Tables and backlash that were active can bring directions that the measurement does not have.
fn known_how(job: &Job) -> &'static str {
    let backlash_um = &job.measurement.active_settings.backlash_um;
    match job.measurement.active {
        ActiveTables::Path(_) => "(with those that the active tables cancel) are known",
        _ if backlash_um.iter().any(|(_, um)| um.is_some()) => {
            "(with the backlash that was active) are known"
        }
        _ => "were measured",
    }
}

/// A policy for two directions says nothing about an axis that was measured in one.
fn check_one_way(task: Task<'_>, problems: &mut Problems) {
    for axis in Axis::ALL {
        let Some(policy) = task.job.compensation.backlash[axis] else {
            continue;
        };
        for direction in Direction::BOTH {
            let is_one_way =
                |own: &TermCurves| matches!(own, TermCurves::OneWay(way, _) if *way == direction);
            let terms = along(task, axis).filter(|(_, own)| is_one_way(own));
            let terms: Vec<ErrorTerm> = terms.map(|(term, _)| term).collect();
            let fits = policy == BacklashPolicy::ForwardOnly && direction == Direction::Plus;
            if !terms.is_empty() && !fits {
                problems.push(one_way_problem(task.job, policy, axis, direction, &terms));
            }
        }
    }
}

fn one_way_problem(
    job: &Job,
    policy: BacklashPolicy,
    axis: Axis,
    direction: Direction,
    terms: &[ErrorTerm],
) -> Problem {
    let needs = match policy {
        BacklashPolicy::ForwardOnly => "takes the + direction",
        _ => "needs both directions",
    };
    let help = match (policy, direction) {
        (BacklashPolicy::ForwardOnly, _) => "measure in +, or leave `backlash` out",
        (_, Direction::Plus) => {
            "measure both directions, or leave `backlash` out, or write `backlash = \"forward-only\"`"
        }
        (_, Direction::Minus) => "measure both directions, or leave `backlash` out",
    };
    let wrong = refusals::one_way(policy.word(), needs, axis, direction, joined(terms), help);
    job.source.at("compensation.backlash", wrong)
}

fn term_targets(
    task: Task<'_>,
    term: ErrorTerm,
    measured: &MeasuredTerm,
) -> Result<TermTargets, Problems> {
    match &measured.measured {
        TermCurves::Undirected(curve) => Ok(one_table(term, curve.clone(), None)),
        TermCurves::OneWay(way, curve) => {
            let other = way.opposite();
            let note =
                format!("measured moving {way} only; what it is moving {other} is not known");
            Ok(one_table(term, curve.clone(), Some(note)))
        }
        TermCurves::BothWays { plus, minus } => both_ways(task, (term, measured), (plus, minus)),
    }
}

fn one_table(term: ErrorTerm, curve: ErrorCurve, note: Option<String>) -> TermTargets {
    TermTargets { term, targets: vec![Target { term, direction: None, curve }], mean: None, note }
}

/// The targets of a term that was measured in both directions, as the policy of its axis asks.
fn both_ways(
    task: Task<'_>,
    (term, measured): (ErrorTerm, &MeasuredTerm),
    (plus, minus): (&ErrorCurve, &ErrorCurve),
) -> Result<TermTargets, Problems> {
    let machine = task.job.machine.axes[term.along];
    let at_reference = |curve: &ErrorCurve| match machine {
        Some(axis) => curve.rezeroed_at(axis.reference),
        None => curve.clone(),
    };
    let policy = task.job.compensation.backlash[term.along].unwrap_or(BacklashPolicy::Mean);
    let mean = plus.mean_with(minus).map(|mean| at_reference(&mean));
    let equal = are_equal(&measured.measured);
    match policy {
        BacklashPolicy::ForwardOnly => Ok(one_table(term, at_reference(plus), None)),
        BacklashPolicy::CurveAndParameter => {
            let homing = machine.map_or(Direction::Plus, |axis| axis.homing());
            let curve = measured.measured.curve(homing).unwrap_or(plus);
            let note = term.is_cross().then(|| "a backlash parameter cannot hold the reversal of a straightness; only the curve of the reference direction is compensated".to_string());
            Ok(one_table(term, at_reference(curve), note))
        }
        BacklashPolicy::TwoTables if family(task.profile).takes_directions(term) && !equal => {
            let directed = |(way, curve): (Option<Direction>, &ErrorCurve)| Target {
                term,
                direction: way,
                curve: curve.clone(),
            };
            let targets = measured.measured.ways().map(directed).collect();
            let note = noise_note(measured.u_value_um(), plus.difference(minus));
            Ok(TermTargets { term, targets, mean, note })
        }
        BacklashPolicy::TwoTables | BacklashPolicy::Mean => {
            let none = || refusals::no_common_range(term);
            let has_two = policy == BacklashPolicy::TwoTables;
            let note = has_two.then(|| match equal {
                true => "both directions are equal, so one table is written".to_string(),
                false => format!(
                    "{} has no direction-dependent table for it; the mean of both directions is used",
                    task.profile.name
                ),
            });
            Ok(one_table(term, mean.ok_or_else(none)?, note))
        }
    }
}

/// Deviations closer than this are equal, µm: a picometre, the last digit of the figures of a manifest and a
/// hundredth of that of any table. Sums of readings, and of old tables and a residual, differ by less.
const EQUAL_UM: f64 = 1e-6;

/// Whether a term is the same in both directions, so that one table says it all.
pub(crate) fn are_equal(measured: &TermCurves) -> bool {
    let TermCurves::BothWays { plus, minus } = measured else {
        return false;
    };
    let (from, to) = plus.measured_range();
    plus.measured_range() == minus.measured_range()
        && plus.difference(minus).is_some_and(|curve| curve.largest_magnitude(from, to) < EQUAL_UM)
}

/// Two tables of a term whose reversal could be noise: U of a difference of two values is 2·√2·u.
fn noise_note(u_um: Option<f64>, reversal: Option<ErrorCurve>) -> Option<String> {
    let (u_um, reversal) = (u_um?, reversal?);
    let (from, to) = reversal.measured_range();
    let largest_um = reversal.largest_magnitude(from, to);
    let expanded_um = 2.0 * std::f64::consts::SQRT_2 * u_um;
    (largest_um <= expanded_um).then(|| {
        format!(
            "its reversal, {largest_um:.1} µm at most, lies within the U = {expanded_um:.1} µm \
             of a difference: the two tables may write noise; `backlash = \"mean\"` writes one"
        )
    })
}
