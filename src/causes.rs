//! Why a second measurement is not what the forecast said: faults tried out on the data.
//!
//! ```text
//!   as found + what the control would add with fault f  =  as left, predicted by f
//!   as left, measured                                   ─→ misfit of f
//!   faults that fit and are as good as the best one     ─→ the set of causes
//! ```
//! Every fault is played through the emulated tables. What is measured twice carries the noise of
//! both measurements; corrections are exact. So a value has the variance
//!
//! ```text
//!   σ² = u²(as left) + Σ (weight · u(as found))² + (count/√12)²
//! ```
//! and each term (each diagonal) a free zero, since both measurements are zeroed at one reading.
//! The points of one curve are not independent (an angle of the beam tilts them all), so a curve
//! counts as **one** figure: the mean of its squared residuals over σ². Thresholds are those of
//! chi-squared with as many degrees of freedom as there are curves, at 0.1 %.
//!
//! One fault at a time is tried; two faults at once are `unknown` unless one explains both.

mod data;
mod decide;
mod fault;
mod fit;
mod question;
mod words;

pub use self::data::Basis;
pub use self::fault::{Fault, Scope};
pub use self::question::Question;

use self::data::{Data, Fit};
use self::fault::all_faults;
use crate::axis::ErrorTerm;
use crate::problem::Problem;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Risk of rejecting what is right.
const RISK: f64 = 0.001;
/// A scale error of more than this is no temperature of a workshop, K.
const MOST_KELVIN: f64 = 20.0;
/// Predictions of one kind that differ by less are one cause, µm.
const SAME_UM: f64 = 1e-6;
/// A second measurement this many times the first one may be in another unit.
const SUSPICIOUS: f64 = 30.0;

/// A fault that the data do not exclude.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Its kind, e.g. `not active`.
    pub kind: &'static str,
    /// The faults of this kind that are one and the same in these data, the widest first.
    pub faults: Vec<Fault>,
    /// Fitted numbers: mm of a shift, factor, µm/m of a scale error.
    pub fitted: Vec<f64>,
    /// What it leaves unexplained, root mean square, µm.
    pub left_um: f64,
    /// In words.
    pub words: String,
}

/// What the data say of the causes.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// As left is what the forecast said, within the uncertainty of both measurements.
    pub as_forecast: bool,
    /// Root mean square of as left − forecast, µm.
    pub off_um: f64,
    /// The causes that the data cannot tell apart, the best first; empty if nothing fits.
    pub causes: Vec<Cause>,
    /// Term by term, where no single cause fits.
    pub by_term: Vec<String>,
    /// The one measurement that decides between the causes.
    pub decides: Option<String>,
    /// What the comparison rests on.
    pub basis: Basis,
}

/// Tries all faults on the data. Refused where the second measurement agrees once it is divided
/// by 1000: a slip of its unit.
pub fn diagnose(question: &Question<'_>) -> Result<Diagnosis, Problem> {
    let faults = all_faults(question);
    let mut data = Data::new(question);
    if data.is_empty() {
        return Err(Problem::new("no position was measured both times")
            .help("measure the same range of the same axes again"));
    }
    let all = |data: &Data<'_>| faults.iter().map(|fault| data.fit(fault)).collect();
    // Equal weights leave the fits as they are, whatever the uncertainty turns out to be.
    let early: Option<Vec<Fit>> = (!data.has_uncertainty()).then(|| all(&data));
    if let Some(fits) = &early {
        data.settle(fits);
    }
    let forecast = data.fit(&Fault::None);
    let as_forecast = data.stands(&forecast);
    let mut found = Diagnosis {
        as_forecast,
        off_um: data.rms(&forecast),
        causes: Vec::new(),
        by_term: Vec::new(),
        decides: None,
        basis: data.basis.clone(),
    };
    if as_forecast {
        refuse_unit_slip(&data)?;
        return Ok(found);
    }
    let fits = early.unwrap_or_else(|| all(&data));
    let standing = not_excluded(&data, &faults, fits);
    if standing.is_empty() {
        refuse_unit_slip(&data)?;
        found.by_term = term_by_term(&data);
        return Ok(found);
    }
    found.decides = Some(decide::decides(question, &standing));
    found.causes = causes(question, &data, standing);
    Ok(found)
}

/// Faults with their fits that fit by themselves and are as good as the best one; what holds a
/// simpler one of them as a special case is left out.
fn not_excluded<'a>(data: &Data<'_>, faults: &'a [Fault], fits: Vec<Fit>) -> Vec<(&'a Fault, Fit)> {
    let fits = faults.iter().zip(fits);
    let possible = fits.filter(|(fault, fit)| data.stands(fit) && fault.is_plausible(data, fit));
    let possible: Vec<(&Fault, Fit)> = possible.collect();
    let scores: Vec<f64> = possible.iter().map(|(_, fit)| data.score(fit)).collect();
    let best = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let limit = best + quantile(1.0 - RISK, 1.0);
    let near = possible.into_iter().zip(scores);
    let mut near: Vec<(f64, (&Fault, Fit))> = near
        .filter(|(_, score)| *score <= limit)
        .map(|(found, score)| (score, found))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let simple: Vec<&Fault> = near.iter().map(|(_, (fault, _))| *fault).collect();
    near.into_iter()
        .map(|(_, found)| found)
        .filter(|(fault, _)| !simple.iter().any(|other| fault.contains(other)))
        .collect()
}

fn widest_first(mut standing: Vec<(&Fault, Fit)>) -> Vec<(&Fault, Fit)> {
    standing.sort_by_key(|(fault, _)| fault.breadth());
    standing
}

/// Faults of one kind with one prediction are one cause.
fn causes(question: &Question<'_>, data: &Data<'_>, standing: Vec<(&Fault, Fit)>) -> Vec<Cause> {
    let mut groups: Vec<(Vec<Fault>, Fit)> = Vec::new();
    for (fault, fit) in widest_first(standing) {
        let same = groups.iter_mut().find(|(faults, other)| {
            faults[0].kind() == fault.kind() && fit.differs_from(other) < SAME_UM
        });
        match same {
            Some((faults, _)) => {
                // The kit may hold the same tables in either scope.
                if !faults
                    .iter()
                    .any(|other| other.is_the_same_on(question, fault))
                {
                    faults.push(fault.clone());
                }
            }
            None => groups.push((vec![fault.clone()], fit)),
        }
    }
    let cause = |(faults, fit): (Vec<Fault>, Fit)| Cause {
        kind: faults[0].kind(),
        words: words::cause(question, &faults, &fit.fitted),
        left_um: data.rms(&fit),
        fitted: fit.fitted,
        faults,
    };
    let mut causes: Vec<Cause> = groups.into_iter().map(cause).collect();
    causes.sort_by(|a, b| a.left_um.total_cmp(&b.left_um));
    causes
}

/// What each term looks like by itself: every fault that fits, the best first.
fn term_by_term(data: &Data<'_>) -> Vec<String> {
    let alone = |term: ErrorTerm| {
        if data.stands_alone(&data.fit(&Fault::None), term) {
            return format!("{term}: as forecast");
        }
        let tried = fault::alone(term);
        let fits = tried.iter().map(|fault| (fault, data.fit(fault)));
        let mut fits: Vec<(&Fault, Fit)> = fits
            .filter(|(_, fit)| data.stands_alone(fit, term))
            .collect();
        fits.sort_by(|a, b| data.rms_of(&a.1, term).total_cmp(&data.rms_of(&b.1, term)));
        match fits.as_slice() {
            [] => format!("{term}: no single fault fits"),
            some => {
                let kinds: Vec<&str> = some.iter().map(|(fault, _)| fault.kind()).collect();
                format!("{term}: {}", kinds.join(" or "))
            }
        }
    };
    data.single_terms().into_iter().map(alone).collect()
}

fn refuse_unit_slip(data: &Data<'_>) -> Result<(), Problem> {
    const UNIT: f64 = 1000.0;
    if data.times_found() <= SUSPICIOUS {
        return Ok(());
    }
    let divided = data.divided_by(UNIT);
    let forecast = divided.fit(&Fault::None);
    if divided.stands(&forecast) {
        return Err(Problem::new(format!(
            "the values measured afterwards are {:.0} times those as found; divided by 1000 they agree with the forecast: a slip of their unit",
            data.times_found()
        ))
        .help("the unit is part of the column's name (`ex_um`, `ex_mm`); correct the column or its values"));
    }
    Ok(())
}

fn quantile(probability: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::INFINITY, |spread| spread.inverse_cdf(probability))
}
