//! Which curve each table has to cancel: the backlash policy applied to the measured terms.

use crate::axis::{Direction, ErrorTerm};
use crate::controller::{Dialect, Profile};
use crate::curve::ErrorCurve;
use crate::job::{BacklashPolicy, Job, WantedTerms};
use crate::model::{ErrorModel, Measured, MeasuredTerm};
use crate::problem::{Problem, Problems};

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
}

/// A measured term that gets no table.
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

/// The targets of all wanted terms, and the measured terms that are not wanted.
pub fn targets(
    job: &Job,
    profile: &Profile,
    model: &ErrorModel,
) -> Result<(Vec<TermTargets>, Vec<Omission>), Problems> {
    let mut problems = Problems::none();
    check_wanted(job, model, &mut problems);
    check_policy(job, model, &mut problems);
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
    problems.or_ok((targets, omitted))
}

fn wants(job: &Job, term: ErrorTerm) -> bool {
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
    let both_ways = model
        .measured()
        .any(|(term, measured)| wants(job, term) && measured.measured.has_both_ways());
    match job.compensation.backlash {
        None if both_ways => problems.push(
            job.problem_at("compensation", "the errors were measured in both directions, but `backlash` is not stated; there is no default")
                .help("write `backlash = \"mean\"`, \"two-tables\", \"forward-only\" or \"curve-and-parameter\""),
        ),
        Some(policy @ (BacklashPolicy::TwoTables | BacklashPolicy::CurveAndParameter)) if !both_ways => problems.push(
            job.problem_at("compensation.backlash", format!("`backlash = \"{}\"` needs errors measured in both directions", policy.word()))
                .help("give the error table a `direction` column with `+` and `-` rows, or leave `backlash` out"),
        ),
        _ => {}
    }
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
        note,
    };
    let (plus, minus) = match &measured.measured {
        Measured::Undirected(curve) => return Ok(one(curve.clone(), None)),
        Measured::OneWay(direction, curve) => {
            return one_way(job, term, *direction, curve)
                .map(|note| one(curve.clone(), Some(note)));
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
            note: None,
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

fn one_way(
    job: &Job,
    term: ErrorTerm,
    direction: Direction,
    _: &ErrorCurve,
) -> Result<String, Problems> {
    if job.compensation.backlash == Some(BacklashPolicy::ForwardOnly)
        && direction == Direction::Minus
    {
        return Err(job
            .problem_at("compensation.backlash", format!("`backlash = \"forward-only\"` takes the + direction, but {term} was measured in - only"))
            .help("measure in +, or leave `backlash` out")
            .into());
    }
    Ok(format!(
        "{term}: measured moving {direction} only; what it is moving {} is not known",
        direction.opposite()
    ))
}
