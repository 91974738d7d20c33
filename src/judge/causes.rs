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
//! chi-squared with as many degrees of freedom as there are curves, at 0.1 %. That dilutes a slope or
//! a step, so no two values of one zero may lie farther apart than their σ allows either.
//!
//! One fault at a time is tried; two faults at once are `unknown` unless one explains both.

mod candidates;
mod data;
mod decide;
mod fault;
mod fit;
mod question;

pub use self::data::Basis;
pub use self::question::{Corrected, Question, Slip};

use self::candidates::{all_faults, alone, cause};
use self::data::{Data, RISK, quantile};
use self::decide::decides;
use self::fault::{Act, Fault, Fit, Scope};
use crate::judge::after::Observation;
use crate::judge::findings::OfTerm;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::Figure;
use crate::text::finding::Finding;
use crate::text::problem::Problem;
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

/// A fault that the data do not exclude.
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

/// Tries all faults on the data. Refused where the second measurement makes sense in another unit
/// only: a slip of 1000.
pub(crate) fn diagnose(question: &Question<'_>) -> Result<Diagnosis, Problem> {
    let faults = all_faults(question);
    let mut data = Data::new(question);
    if data.is_empty() {
        return Err(Problem::new("no position was measured both times")
            .help("measure the same range of the same axes again"));
    }
    if !data.has_both_uncertainties() {
        data.settle(&all_fits(&data, &faults));
    }
    let forecast = data.fit(&Fault::none());
    refuse_too_small(&data, &faults, &forecast)?;
    let as_forecast = data.stands(&forecast);
    let mut found = Diagnosis {
        as_forecast,
        hides_tables: as_forecast && hides_tables(&data, &faults),
        shows_signs: as_forecast && shows_signs(&data, &faults),
        off_um: data.rms(&forecast),
        causes: Vec::new(),
        by_term: Vec::new(),
        decides: None,
        basis: data.basis.clone(),
    };
    if as_forecast {
        refuse_too_large(&data)?;
        return Ok(found);
    }
    let fits = all_fits(&data, &faults);
    let standing = not_excluded(&data, &faults, fits);
    if standing.is_empty() {
        refuse_too_large(&data)?;
        found.by_term = term_by_term(&data);
        return Ok(found);
    }
    found.decides = Some(decides(question, &standing));
    found.causes = causes(question, &data, &faults, standing);
    Ok(found)
}

fn all_fits(data: &Data<'_>, faults: &[Fault]) -> Vec<Fit> {
    faults.iter().map(|fault| data.fit(fault)).collect()
}

/// Whether as left agrees as well with tables that do not act at all.
fn hides_tables(data: &Data<'_>, faults: &[Fault]) -> bool {
    let inactive = faults.iter().find(|fault| fault.kind == "not active");
    inactive.is_some_and(|fault| data.stands(&data.fit(fault)))
}

/// Whether the tables of each mechanism were seen, and would not fit with their sign turned.
fn shows_signs(data: &Data<'_>, faults: &[Fault]) -> bool {
    let is_shown = |scope: Scope| {
        let turned = faults.iter().find(|fault| fault.act == Act::Times(scope, Some(-1.0)));
        turned.is_some_and(|fault| !data.stands(&data.fit(fault)))
    };
    let tabled = |term: &ErrorTerm| data.question.control.has_table(*term);
    let tabled: Vec<ErrorTerm> = ErrorTerm::ALL.into_iter().filter(tabled).collect();
    let is_there = |scope: &Scope| tabled.iter().any(|term| scope.holds(*term));
    !tabled.is_empty()
        && [Scope::Positioning, Scope::Cross].into_iter().filter(is_there).all(is_shown)
}

/// Faults with their fits that fit by themselves and are as good as the best one, the usual ones
/// first; what holds a simpler one of them as a special case is left out.
fn not_excluded<'a>(data: &Data<'_>, faults: &'a [Fault], fits: Vec<Fit>) -> Vec<(&'a Fault, Fit)> {
    let fits = faults.iter().zip(fits);
    let possible = fits.filter(|(fault, fit)| data.stands(fit) && fault.is_plausible(fit));
    let possible: Vec<(&Fault, Fit)> = possible.collect();
    let scores: Vec<f64> = possible.iter().map(|(_, fit)| data.score(fit)).collect();
    let best = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let limit = best + quantile(1.0 - RISK, 1.0);
    let near = possible.into_iter().zip(scores);
    let mut near: Vec<(f64, (&Fault, Fit))> =
        near.filter(|(_, score)| *score <= limit).map(|(found, score)| (score, found)).collect();
    near.sort_by(|(one, (a, _)), (other, (b, _))| {
        a.rank().cmp(&b.rank()).then(one.total_cmp(other))
    });
    let simple: Vec<&Fault> = near.iter().map(|(_, (fault, _))| *fault).collect();
    near.into_iter()
        .map(|(_, found)| found)
        .filter(|(fault, _)| !simple.iter().any(|other| fault.contains(other)))
        .collect()
}

/// Faults of one kind with one prediction are one cause, the widest of them first, as they were tried.
fn causes(
    question: &Question<'_>,
    data: &Data<'_>,
    tried: &[Fault],
    mut standing: Vec<(&Fault, Fit)>,
) -> Vec<Cause> {
    standing.sort_by_key(|(fault, _)| tried.iter().position(|other| other == *fault));
    let mut groups: Vec<(Vec<Fault>, Fit)> = Vec::new();
    for (fault, fit) in standing {
        let same = groups.iter_mut().find(|(faults, other)| {
            faults[0].kind == fault.kind && fit.differs_from(other) < SAME_UM
        });
        // The kit may hold the same tables in either scope.
        let is_same = |other: &Fault| other.is_the_same_on(question, fault);
        match same {
            Some((faults, _)) if faults.iter().any(is_same) => {}
            Some((faults, _)) => faults.push(fault.clone()),
            None => groups.push((vec![fault.clone()], fit)),
        }
    }
    groups.sort_by(|(a, one), (b, other)| {
        let usual = a[0].rank().cmp(&b[0].rank());
        usual.then(data.rms(one).total_cmp(&data.rms(other)))
    });
    let cause = |(faults, fit): (Vec<Fault>, Fit)| {
        let uncertainty_mm = data.shift_uncertainty_mm(&faults[0], &fit);
        Cause {
            kind: faults[0].kind,
            words: cause(question, &faults, &fit.fitted, &uncertainty_mm),
            left_um: data.rms(&fit),
            fitted: fit.fitted,
        }
    };
    groups.into_iter().map(cause).collect()
}

/// What each term looks like by itself: how far it is off, and every fault that fits, the best
/// first.
fn term_by_term(data: &Data<'_>) -> Vec<Finding> {
    let forecast = data.fit(&Fault::none());
    let alone = |term: ErrorTerm| {
        if data.stands_alone(&forecast, term) {
            return OfTerm::AsForecast { term }.into();
        }
        let off = data.farthest_off(term);
        let off = off.map_or_else(String::new, |(um, seen)| off_forecast(um, seen));
        let tried = alone(data.question, term);
        let fits = tried.iter().map(|fault| (fault, data.fit(fault)));
        let mut fits: Vec<(&Fault, Fit)> = fits
            .filter(|(fault, fit)| data.stands_alone(fit, term) && fault.is_plausible(fit))
            .collect();
        fits.sort_by(|a, b| data.rms_of(&a.1, term).total_cmp(&data.rms_of(&b.1, term)));
        let faults = fits.iter().map(|(fault, _)| fault.kind).collect();
        OfTerm::OffForecast { term, off, faults }.into()
    };
    data.single_terms().into_iter().map(alone).collect()
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

const UNIT_HELP: &str =
    "the unit is part of the column's name (`ex_um`, `ex_mm`); correct the column or its values";

fn refuse_too_large(data: &Data<'_>) -> Result<(), Problem> {
    if data.times_found() <= SUSPICIOUS {
        return Ok(());
    }
    let divided = data.in_another_unit(1.0 / UNIT, 1.0 / UNIT);
    if divided.stands(&divided.fit(&Fault::none())) {
        return Err(Problem::new(format!(
            "the values measured afterwards are {:.0} times those as found; divided by 1000 they agree with the forecast: a slip of their unit",
            data.times_found()
        ))
        .help(UNIT_HELP));
    }
    Ok(())
}

/// A machine that was not corrected looks perfect where its errors stand in mm under a heading for
/// µm. Values that are the forecast itself come from a simulation without noise.
fn refuse_too_small(data: &Data<'_>, faults: &[Fault], forecast: &Fit) -> Result<(), Problem> {
    const THE_FORECAST_ITSELF: f64 = 0.1;
    let measured_um = data.measured_rms();
    let simulated = data.rms(forecast) <= THE_FORECAST_ITSELF * measured_um;
    if measured_um == 0.0 || simulated || measured_um * SUSPICIOUSLY_SMALL > data.found_rms() {
        return Ok(());
    }
    let why = if measured_um < NO_SCATTER_UM {
        "no laser resolves that".to_string()
    } else if let Some(kind) = fits_in_mm(data, faults) {
        format!("1000 times as large they show {}", kind.to_uppercase())
    } else {
        return Ok(());
    };
    Err(Problem::new(format!(
        "the values measured afterwards are {measured_um:.6} µm (root mean square), those as found {:.3} µm: {why}; a slip of their unit",
        data.found_rms()
    ))
    .help(UNIT_HELP))
}

/// The fault that the second measurement shows once its values are multiplied by 1000.
fn fits_in_mm(data: &Data<'_>, faults: &[Fault]) -> Option<&'static str> {
    const FAR_FROM_NOISE: f64 = 10.0;
    let mut multiplied = data.in_another_unit(UNIT, 1.0);
    let fits = all_fits(&multiplied, faults);
    if !data.has_both_uncertainties() {
        multiplied.settle(&fits);
    }
    if multiplied.measured_rms() < FAR_FROM_NOISE * multiplied.basis.sigma_um {
        return None;
    }
    let stands = |(fault, fit): &(&Fault, Fit)| multiplied.stands(fit) && fault.is_plausible(fit);
    let mut found: Vec<&Fault> =
        (faults.iter().zip(fits).filter(stands)).map(|(fault, _)| fault).collect();
    found.sort_by_key(|fault| fault.rank());
    found.first().map(|fault| fault.kind)
}
