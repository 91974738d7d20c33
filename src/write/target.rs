//! Which curve each table has to cancel: the backlash policy applied to the measured terms.

use crate::control::controller::{Dialect, Profile};
use crate::inputs::job::{ActiveTables, BacklashPolicy, Job, WantedTerms};
use crate::machine::model::{ErrorModel, Measured, MeasuredTerm};
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::curve::ErrorCurve;
use crate::text::problem::{Problem, Problems};

/// One table's worth: a term, the direction of its moving axis the table acts in, the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Which error.
    pub term: ErrorTerm,
    /// `None` = both directions.
    pub direction: Option<Direction>,
    /// The deviation to cancel.
    pub curve: ErrorCurve,
}

/// The targets of one term.
#[derive(Clone, Debug, PartialEq)]
pub struct TermTargets {
    /// Which error.
    pub term: ErrorTerm,
    /// One for both directions, or one for each.
    pub targets: Vec<Target>,
    /// The mean of both directions, which can stand in for two tables where the control has few.
    pub mean: Option<ErrorCurve>,
    /// What the user should know about the choice.
    pub note: Option<String>,
}

impl TermTargets {
    /// The curve that the tables cancel while the moving axis travels in `direction`.
    pub fn curve(&self, direction: Direction) -> Option<&ErrorCurve> {
        self.targets
            .iter()
            .find(|target| target.direction.is_none_or(|d| d == direction))
            .map(|target| &target.curve)
    }

    /// One table with the mean of both directions instead of two tables.
    pub(crate) fn take_mean(&mut self) {
        if let Some(curve) = self.mean.take() {
            self.targets = vec![Target {
                term: self.term,
                direction: None,
                curve,
            }];
        }
    }
}

/// A term that gets no table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omission {
    /// Which error.
    pub term: ErrorTerm,
    /// Why.
    pub reason: String,
}

/// Whether a control can hold separate tables for the two directions of a term.
pub fn takes_directions(profile: &Profile, term: ErrorTerm) -> bool {
    match &profile.dialect {
        Dialect::Siemens(_) | Dialect::Generic(_) => true,
        Dialect::Fanuc(facts) => term.is_positioning() && !facts.minus_points.value.is_empty(),
    }
}

/// The targets of all wanted terms, and the terms that are not wanted or not determined.
pub fn targets(
    job: &Job,
    profile: &Profile,
    model: &ErrorModel,
) -> Result<(Vec<TermTargets>, Vec<Omission>), Problems> {
    let mut problems = Problems::none();
    check_wanted(job, model, &mut problems);
    check_policy(job, model, &mut problems);
    check_one_way(job, model, &mut problems);
    let mut targets = Vec::new();
    let mut omitted = Vec::new();
    for (term, measured) in model.measured() {
        if wants(job, term) {
            if let Some(of_term) = problems.take(term_targets(job, profile, term, measured)) {
                targets.push(of_term);
            }
        } else {
            omitted.push(Omission {
                term,
                reason: "not listed in `terms` of the job".to_string(),
            });
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

fn check_wanted(job: &Job, model: &ErrorModel, problems: &mut Problems) {
    let WantedTerms::Listed(terms) = &job.compensation.terms else {
        return;
    };
    for term in terms.iter().filter(|term| model.terms[**term].is_none()) {
        problems.push(
            job.problem_at(
                "compensation.terms",
                format!("`terms` asks for {term}, which was not measured"),
            )
            .help("remove it, or measure it"),
        );
    }
}

fn check_policy(job: &Job, model: &ErrorModel, problems: &mut Problems) {
    let wanted = || model.measured().filter(|(term, _)| wants(job, *term));
    let both_ways = wanted().any(|(_, measured)| measured.measured.has_both_ways());
    let one_way = wanted().any(|(_, measured)| matches!(measured.measured, Measured::OneWay(..)));
    match job.compensation.backlash {
        None if both_ways => problems.push(
            job.problem_at("compensation", format!("the errors {} in both directions, but `backlash` is not stated; there is no default", known_how(job)))
                .help("write `backlash = \"mean\"`, \"two-tables\", \"forward-only\" or \"curve-and-parameter\""),
        ),
        Some(policy @ (BacklashPolicy::TwoTables | BacklashPolicy::CurveAndParameter)) if !both_ways && !one_way => problems.push(
            job.problem_at("compensation.backlash", format!("`backlash = \"{}\"` needs errors measured in both directions", policy.word()))
                .help("give the error table a `direction` column with `+` and `-` rows, or leave `backlash` out"),
        ),
        _ => {}
    }
}

/// Tables that were active can bring directions that the measurement does not have.
fn known_how(job: &Job) -> &'static str {
    match job.measurement.active {
        ActiveTables::Path(_) => "(with those that the active tables cancel) are known",
        _ => "were measured",
    }
}

/// A policy for two directions says nothing about an axis that was measured in one.
fn check_one_way(job: &Job, model: &ErrorModel, problems: &mut Problems) {
    let Some(policy) = job.compensation.backlash else {
        return;
    };
    for axis in Axis::ALL {
        for direction in Direction::BOTH {
            let terms = one_way_terms(job, model, axis, direction);
            let fits = policy == BacklashPolicy::ForwardOnly && direction == Direction::Plus;
            if !terms.is_empty() && !fits {
                problems.push(one_way_problem(job, policy, axis, direction, &terms));
            }
        }
    }
}

/// The wanted terms along an axis that were measured moving in this direction only.
fn one_way_terms(
    job: &Job,
    model: &ErrorModel,
    axis: Axis,
    direction: Direction,
) -> Vec<ErrorTerm> {
    let is_one_way =
        |measured: &Measured| matches!(measured, Measured::OneWay(own, _) if *own == direction);
    model
        .measured()
        .filter(|(term, _)| term.along == axis && wants(job, *term))
        .filter(|(_, measured)| is_one_way(&measured.measured))
        .map(|(term, _)| term)
        .collect()
}

fn one_way_problem(
    job: &Job,
    policy: BacklashPolicy,
    axis: Axis,
    direction: Direction,
    terms: &[ErrorTerm],
) -> Problem {
    let names: Vec<String> = terms.iter().map(ErrorTerm::to_string).collect();
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
    let message = format!(
        "`backlash = \"{}\"` {needs}, but axis {axis} was measured in {direction} only ({})",
        policy.word(),
        names.join(", ")
    );
    job.problem_at("compensation.backlash", message).help(help)
}

fn term_targets(
    job: &Job,
    profile: &Profile,
    term: ErrorTerm,
    measured: &MeasuredTerm,
) -> Result<TermTargets, Problems> {
    let one = |curve: ErrorCurve, note: Option<String>| TermTargets {
        term,
        targets: vec![Target {
            term,
            direction: None,
            curve,
        }],
        mean: None,
        note,
    };
    let (plus, minus) = match &measured.measured {
        Measured::Undirected(curve) => return Ok(one(curve.clone(), None)),
        Measured::OneWay(direction, curve) => {
            let note = one_way_note(term, *direction);
            return Ok(one(curve.clone(), Some(note)));
        }
        Measured::BothWays { plus, minus } => (plus, minus),
    };
    let homing = job.machine.axes[term.along].map_or(Direction::Plus, |axis| axis.homing());
    let at_reference = |curve: &ErrorCurve| match job.machine.axes[term.along] {
        Some(axis) => curve.rezeroed_at(axis.reference),
        None => curve.clone(),
    };
    let policy = job.compensation.backlash.unwrap_or(BacklashPolicy::Mean);
    match policy {
        BacklashPolicy::ForwardOnly => Ok(one(at_reference(plus), None)),
        BacklashPolicy::CurveAndParameter => {
            let curve = if homing == Direction::Plus {
                plus
            } else {
                minus
            };
            let note = term.is_cross().then(|| format!("{term}: a backlash parameter cannot hold the reversal of a straightness; only the curve of the reference direction is compensated"));
            Ok(one(at_reference(curve), note))
        }
        BacklashPolicy::TwoTables if takes_directions(profile, term) => Ok(TermTargets {
            term,
            targets: vec![
                directed(term, Direction::Plus, plus),
                directed(term, Direction::Minus, minus),
            ],
            mean: plus.mean_with(minus).map(|mean| at_reference(&mean)),
            note: noise_note(term, measured.u_value_um(), plus.difference(minus)),
        }),
        BacklashPolicy::TwoTables | BacklashPolicy::Mean => {
            let mean = plus.mean_with(minus).map(|mean| at_reference(&mean));
            let Some(mean) = mean else {
                return Err(Problem::new(format!(
                    "the two directions of {term} have no common range"
                ))
                .into());
            };
            let note = (policy == BacklashPolicy::TwoTables).then(|| format!("{term}: {} has no direction-dependent table for it; the mean of both directions is used", profile.name));
            Ok(one(mean, note))
        }
    }
}

fn directed(term: ErrorTerm, direction: Direction, curve: &ErrorCurve) -> Target {
    Target {
        term,
        direction: Some(direction),
        curve: curve.clone(),
    }
}

/// Two tables of a term whose reversal could be noise: U of a difference of two values is 2·√2·u.
fn noise_note(term: ErrorTerm, u_um: Option<f64>, reversal: Option<ErrorCurve>) -> Option<String> {
    let (u_um, reversal) = (u_um?, reversal?);
    let (from, to) = reversal.measured_range();
    let largest_um = reversal.largest_magnitude(from, to);
    let expanded_um = 2.0 * std::f64::consts::SQRT_2 * u_um;
    (largest_um <= expanded_um).then(|| {
        format!(
            "{term}: its reversal, {largest_um:.1} µm at most, lies within the U = {expanded_um:.1} µm \
             of a difference: the two tables may write noise; `backlash = \"mean\"` writes one"
        )
    })
}

fn one_way_note(term: ErrorTerm, direction: Direction) -> String {
    format!(
        "{term}: measured moving {direction} only; what it is moving {} is not known",
        direction.opposite()
    )
}
