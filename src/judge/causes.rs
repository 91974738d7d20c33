//! Why a second measurement is not what the forecast said: hypotheses tried out on the data.
//!
//! ```text
//!   as found + what the control would add with change h  =  as left, predicted by h
//!   as left, measured                                    ─→ misfit of h
//!   those that fit and are as good as the best one       ─→ the set of causes
//! ```
//! Every change is played through the emulated tables. What is measured twice carries the noise of
//! both measurements; corrections are exact. So a value has the variance
//!
//! ```text
//!   σ² = u²(as left) + Σ (weight · u(as found))² + Σ (weight · unseen)² + (count/√12)²
//! ```
//! (unseen: what a straight line and a spline through the first targets differ by, between them)
//! and each term (each diagonal) a free zero, since both measurements are zeroed at one reading.
//! The points of one curve are not independent (an angle of the beam tilts them all), so a curve
//! counts as **one** figure: the mean of its squared residuals over σ². Thresholds are those of
//! chi-squared with as many degrees of freedom as there are curves, at 0.1 %. That dilutes a slope or
//! a step, so no two values of one zero may lie farther apart than their σ allows either.
//!
//! One change at a time is tried; two at once are `unknown` unless one explains both.

mod change;
mod data;
mod decide;
mod hypotheses;

pub use self::change::{Question, Slip, WithoutSlip};
pub use self::data::Basis;

use self::change::{Change, Scope, Terms};
use self::data::{Data, Fit, RISK, quantile};
use self::decide::decides;
use self::hypotheses::Hypothesis;
use crate::judge::after::Observation;
use crate::judge::findings::OfTerm;
use crate::judge::refusals;
use crate::quantity::{ErrorTerm, Figure};
use crate::text::{Finding, Problem, once};
use serde::Serialize;

/// Predictions of one kind that differ by less are one cause, µm.
const SAME_UM: f64 = 1e-6;
/// A second measurement this many times the first one may be in another unit.
const SUSPICIOUS: f64 = 30.0;
/// One that is this many times smaller may be, too: no table leaves a hundredth.
const SUSPICIOUSLY_SMALL: f64 = 100.0;
/// What no laser resolves: a measurement does not scatter by less, µm.
const NO_SCATTER_UM: f64 = 0.01;
/// A unit error: mm under a heading for µm, or the other way.
const UNIT: f64 = 1000.0;

/// What the data do not exclude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// Its kind, e.g. `not active`.
    pub kind: &'static str,
    /// In words.
    pub words: String,
    /// Fitted numbers: mm of a shift, factor, K of a temperature.
    pub fitted: Vec<f64>,
    /// What it leaves unexplained, root mean square, µm.
    pub left_um: f64,
}

/// What the data say of the causes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnosis {
    /// As left is what the forecast said, within the uncertainty of both measurements.
    pub as_forecast: bool,
    /// It would be so, too, if the tables did not act: the noise hides them.
    pub hides_tables: bool,
    /// As left excludes that positioning tables or those of cross terms act with the sign turned, whichever there are.
    pub shows_signs: bool,
    /// Root mean square of as left − forecast, µm.
    #[serde(rename = "off_forecast_um")]
    pub off_um: f64,
    /// What the comparison rests on.
    #[serde(flatten)]
    pub basis: Basis,
    /// The causes that the data cannot tell apart, the usual ones first; empty if nothing fits.
    pub causes: Vec<Cause>,
    /// Term by term, where no single cause fits.
    pub by_term: Vec<Finding>,
    /// The one measurement that decides between the causes.
    pub decides: Option<String>,
}

/// Tries all hypotheses on the data. Refused where the second measurement makes sense in another unit
/// only: a slip of 1000.
pub(crate) fn diagnose(question: &Question<'_>) -> Result<Diagnosis, Problem> {
    if question.seen.is_empty() {
        return Err(refusals::nothing_twice());
    }
    let tried = hypotheses::all(question);
    let mut data = Data::new(question);
    if !data.has_both_uncertainties() {
        data.settle(&all_fits(&data, &tried));
    }
    let forecast = data.fit(&Change::None);
    refuse_too_small(&data, &tried, &forecast)?;
    let as_forecast = data.stands(&forecast, None);
    let mut found = Diagnosis {
        as_forecast,
        hides_tables: as_forecast && hides_tables(&data),
        shows_signs: as_forecast && shows_signs(&data),
        off_um: data.rms(&forecast, None),
        causes: Vec::new(),
        by_term: Vec::new(),
        decides: None,
        basis: data.basis.clone(),
    };
    let standing = if as_forecast { Vec::new() } else { not_excluded(&data, &tried) };
    if !standing.is_empty() {
        found.decides = Some(decides(question, &standing));
        found.causes = causes(&data, &tried, standing);
        return Ok(found);
    }
    refuse_too_large(&data)?;
    if !as_forecast {
        found.by_term = term_by_term(&data, &tried, &forecast);
    }
    Ok(found)
}

fn all_fits(data: &Data<'_>, tried: &[Hypothesis]) -> Vec<Fit> {
    tried.iter().map(|tried| data.fit(&tried.change)).collect()
}

/// Whether as left agrees as well with tables that do not act at all.
fn hides_tables(data: &Data<'_>) -> bool {
    let (control, seen) = (data.question.control, data.question.terms());
    let all = Scope { parameters: true, ..Scope::tables(Terms::from_fn(|_| true)) };
    let acts =
        |term| control.has_parameter(term) || seen.contains(&term) && control.has_table(term);
    all.any(acts) && data.stands(&data.fit(&Change::Times(all, Some(0.0))), None)
}

/// Whether the tables of each mechanism were seen, and would not fit with their sign turned.
fn shows_signs(data: &Data<'_>) -> bool {
    let has_table = |term| data.question.control.has_table(term);
    let positioning = Terms::from_fn(|term| term.is_positioning() && has_table(term));
    let cross = Terms::from_fn(|term| term.is_cross() && has_table(term));
    let there = [positioning, cross].into_iter().filter(|of| of.iter().any(|(_, held)| *held));
    let turned: Vec<Fit> =
        there.map(|of| data.fit(&Change::Times(Scope::tables(of), Some(-1.0)))).collect();
    !turned.is_empty() && turned.iter().all(|fit| !data.stands(fit, None))
}

/// Hypotheses that fit by themselves, of one term or all.
fn standing<'a>(
    data: &Data<'_>,
    tried: impl Iterator<Item = &'a Hypothesis>,
    term: Option<ErrorTerm>,
) -> Vec<(&'a Hypothesis, Fit)> {
    let fits = tried.map(|tried| (tried, data.fit(&tried.change)));
    let stands = |(tried, fit): &(&Hypothesis, Fit)| {
        data.stands(fit, term) && tried.change.is_plausible(&fit.fitted)
    };
    fits.filter(stands).collect()
}

/// Hypotheses with their fits that fit by themselves and are as good as the best one, the usual ones
/// first; what holds a simpler one of them as a special case is left out.
fn not_excluded<'a>(data: &Data<'_>, tried: &'a [Hypothesis]) -> Vec<(&'a Hypothesis, Fit)> {
    let standing = standing(data, tried.iter(), None).into_iter();
    let mut near: Vec<_> = standing.map(|found| (data.score(&found.1), found)).collect();
    let best = near.iter().map(|(score, _)| *score).fold(f64::INFINITY, f64::min);
    near.retain(|(score, _)| *score <= best + quantile(1.0 - RISK, 1.0));
    near.sort_by(|(one, (a, _)), (other, (b, _))| {
        a.kind.0.cmp(&b.kind.0).then(one.total_cmp(other))
    });
    let simple: Vec<&Hypothesis> = near.iter().map(|(_, (tried, _))| *tried).collect();
    let is_simple = |(tried, _): &(&Hypothesis, Fit)| {
        !simple.iter().any(|other| tried.change.contains(&other.change))
    };
    near.into_iter().map(|(_, found)| found).filter(is_simple).collect()
}

/// Hypotheses of one kind with one prediction are one cause, the widest of them first, as they were tried.
fn causes(
    data: &Data<'_>,
    tried: &[Hypothesis],
    mut standing: Vec<(&Hypothesis, Fit)>,
) -> Vec<Cause> {
    standing.sort_by_key(|(own, _)| tried.iter().position(|other| other == *own));
    let mut groups: Vec<(Vec<Hypothesis>, Fit)> = Vec::new();
    for (tried, fit) in standing {
        let same = groups.iter_mut().find(|(group, other)| {
            group[0].kind == tried.kind && fit.differs_from(other) < SAME_UM
        });
        // The kit may hold the same tables in either scope.
        let is_same =
            |other: &Hypothesis| other.change.is_the_same_on(data.question, &tried.change);
        match same {
            Some((group, _)) if group.iter().any(is_same) => {}
            Some((group, _)) => group.push(tried.clone()),
            None => groups.push((vec![tried.clone()], fit)),
        }
    }
    groups.sort_by(|(a, one), (b, other)| {
        a[0].kind.0.cmp(&b[0].kind.0).then(data.rms(one, None).total_cmp(&data.rms(other, None)))
    });
    let cause = |(group, fit): (Vec<Hypothesis>, Fit)| {
        let uncertainty_mm = data.shift_uncertainty_mm(&group[0].change, &fit);
        Cause {
            kind: group[0].kind.1,
            words: hypotheses::words(data.question, &group, &fit.fitted, &uncertainty_mm),
            left_um: data.rms(&fit, None),
            fitted: fit.fitted,
        }
    };
    groups.into_iter().map(cause).collect()
}

/// What each term that was measured by itself looks like: how far it is off, and everything that fits,
/// the best first.
fn term_by_term(data: &Data<'_>, tried: &[Hypothesis], forecast: &Fit) -> Vec<Finding> {
    let of = |term: ErrorTerm| {
        let own = data.question.seen.iter().filter(|seen| seen.is_of(term));
        let off = own.map(|seen| (seen.off_um(data.question.control), seen));
        let (um, seen) = off.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        if data.stands(forecast, Some(term)) {
            return Some(OfTerm::AsForecast { term }.into());
        }
        let mut found = standing(data, tried.iter().filter(|tried| tried.is_of(term)), Some(term));
        let rms = |fit: &Fit| data.rms(fit, Some(term));
        found.sort_by(|(_, one), (_, other)| rms(one).total_cmp(&rms(other)));
        let faults = once(found.iter().map(|(tried, _)| tried.kind.1).collect());
        Some(OfTerm::OffForecast { term, off: off_forecast(um, seen), faults }.into())
    };
    ErrorTerm::ALL.into_iter().filter_map(of).collect()
}

/// Where and by how much a term is off the forecast.
fn off_forecast(um: f64, seen: &Observation) -> String {
    let place = match seen.parts.as_slice() {
        [] => String::new(),
        [one] => format!(" at {} mm moving {}", Figure(one.at.mm()).trimmed(3), one.direction),
        [mean, ..] => format!(" at {} mm", Figure(mean.at.mm()).trimmed(3)),
    };
    format!("{:+.3} µm off the forecast{place}, ", Figure(um))
}

fn refuse_too_large(data: &Data<'_>) -> Result<(), Problem> {
    let times = data.times_found();
    let divided = data.in_another_unit(1.0 / UNIT, 1.0 / UNIT);
    if times <= SUSPICIOUS || !divided.stands(&divided.fit(&Change::None), None) {
        return Ok(());
    }
    Err(refusals::slip_of_unit(format!(
        "{times:.0} times those as found; divided by 1000 they agree with the forecast:"
    )))
}

/// A machine that was not corrected looks perfect where its errors stand in mm under a heading for
/// µm. Values that are the forecast itself come from a simulation without noise.
fn refuse_too_small(data: &Data<'_>, tried: &[Hypothesis], forecast: &Fit) -> Result<(), Problem> {
    const THE_FORECAST_ITSELF: f64 = 0.1;
    let (measured_um, found_um) = (data.rms_of(&data.measured_um), data.rms_of(&data.found_um));
    let simulated = data.rms(forecast, None) <= THE_FORECAST_ITSELF * measured_um;
    if measured_um == 0.0 || simulated || measured_um * SUSPICIOUSLY_SMALL > found_um {
        return Ok(());
    }
    let why = if measured_um < NO_SCATTER_UM {
        "no laser resolves that".to_string()
    } else if let Some(kind) = fits_in_mm(data, tried) {
        format!("1000 times as large they show {}", kind.to_uppercase())
    } else {
        return Ok(());
    };
    Err(refusals::slip_of_unit(format!(
        "{measured_um:.6} µm (root mean square), those as found {found_um:.3} µm: {why};"
    )))
}

/// What the second measurement shows once its values are multiplied by 1000.
fn fits_in_mm(data: &Data<'_>, tried: &[Hypothesis]) -> Option<&'static str> {
    const FAR_FROM_NOISE: f64 = 10.0;
    let mut multiplied = data.in_another_unit(UNIT, 1.0);
    if !data.has_both_uncertainties() {
        multiplied.settle(&all_fits(&multiplied, tried));
    }
    let measured_um = multiplied.rms_of(&multiplied.measured_um);
    if measured_um < FAR_FROM_NOISE * multiplied.basis.sigma_um {
        return None;
    }
    let found = standing(&multiplied, tried.iter(), None);
    found.into_iter().map(|(tried, _)| tried.kind).min_by_key(|kind| kind.0).map(|kind| kind.1)
}
