//! The values of the second measurement, their weights, and the misfit of a change.

use super::change::Change;
use crate::judge::after::{Observation, SeenDeviation};
use crate::judge::causes::change::Question;
use crate::quantity::{ErrorTerm, Squared, larger, smaller};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};
use std::collections::{BTreeMap, BTreeSet};

/// What no laser resolves, µm.
const SMALLEST_UM: f64 = 0.01;
/// Where no uncertainty is stated, the scatter about the best explanation is taken, up to this
/// share of what the tables add: more would explain nothing.
const MOST_SCATTER: f64 = 0.1;

/// Fewer second differences tell no scatter.
const FEWEST_DIFFERENCES: f64 = 8.0;
/// Neighbouring second differences share values, and a median knows less than a mean: so many make
/// one degree of freedom.
const DIFFERENCES_OF_A_FREEDOM: f64 = 4.0;
/// Median of |deviate| of a normal distribution.
const NORMAL_MEDIAN: f64 = 0.674_5;
/// Square of the ratio between both formulas of [`Data::widen`].
const STEPS_OF_A_SUM: f64 = 3.0;
/// √6, standard deviation of a second difference of independent deviates.
const SECOND_DIFFERENCE: f64 = 2.449_489_742_783_178;

/// What the comparison rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Basis {
    /// Root mean square of σ, µm.
    pub sigma_um: f64,
    /// Where σ comes from.
    #[serde(rename = "sigma_from")]
    pub words: String,
    /// Values that were compared.
    pub values: usize,
    /// Curves (or passes) they stand on: the degrees of freedom.
    pub curves: usize,
}

/// A change with its numbers fitted.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) fitted: Vec<f64>,
    /// Predicted values, µm, less their own zeros.
    predicted_um: Vec<f64>,
    residuals_um: Vec<f64>,
}

impl Fit {
    /// Largest difference of two predictions, µm.
    pub(super) fn differs_from(&self, other: &Fit) -> f64 {
        minus(&self.predicted_um, &other.predicted_um).into_iter().map(f64::abs).fold(0.0, f64::max)
    }
}

/// What a fit leaves of a value, and σ, µm.
type Left = (f64, f64);

/// Those of one curve, or of one zero.
type Group = Vec<Left>;

/// The values with everything that does not depend on the change.
#[derive(Clone)]
pub(super) struct Data<'a> {
    pub(super) question: &'a Question<'a>,
    pub(super) basis: Basis,
    pub(super) measured_um: Vec<f64>,
    pub(super) found_um: Vec<f64>,
    sigma_um: Vec<f64>,
}

impl<'a> Data<'a> {
    pub(super) fn new(question: &'a Question<'a>) -> Data<'a> {
        let seen = question.seen;
        let curves: BTreeSet<usize> = seen.iter().map(|o| o.curve).collect();
        let (sigma_um, words) = sigmas(question);
        let sigma = root_mean_square(&sigma_um);
        Data {
            question,
            basis: Basis { values: seen.len(), curves: curves.len(), sigma_um: sigma, words },
            measured_um: seen.iter().map(|o| o.um).collect(),
            found_um: seen.iter().map(|o| o.found_um).collect(),
            sigma_um,
        }
    }

    /// Whether both measurements state an uncertainty.
    pub(super) fn has_both_uncertainties(&self) -> bool {
        self.question.seen.iter().all(|o| o.u_um.is_some() && o.found_variance > 0.0)
    }

    /// Where an uncertainty is not stated: the scatter between neighbours about the best
    /// explanation, which a change of any smooth shape leaves out; with few values the root mean square.
    pub(super) fn settle(&mut self, fits: &[Fit]) {
        let forecast = self.fit(&Change::None);
        let floor = larger(self.question.count_um / 2.0, SMALLEST_UM);
        let (least, what) = match self.least_scatter(fits, &forecast) {
            // Noise that is larger than the errors as found is no noise.
            Some(um) => {
                let most = larger(self.rms_of(&self.found_um), floor);
                (smaller(um, most), "the scatter between neighbouring values")
            }
            None => (self.bounded_rms(fits.iter().chain([&forecast]), floor), "the scatter"),
        };
        let sigma = larger(least, floor);
        let widest = self.widen(sigma);
        self.basis.sigma_um = root_mean_square(&self.sigma_um);
        let unstated = match self.basis.words.as_str() {
            "" => "no uncertainty is stated".to_string(),
            words => format!("at least {words}"),
        };
        let sums = widest.map_or_else(String::new, |um| {
            format!("; up to {um:.3} µm, as sums of steps scatter, where no U is stated")
        });
        self.basis.words = format!(
            "{unstated}: {sigma:.3} µm is taken, {what} about the best explanation, at least half a count ({floor:.3} µm){sums}"
        );
    }

    /// Takes σ for every value that has less, µm. Beside values with a stated uncertainty those without
    /// one are sums of steps (positioning of separated readings whose linear axes state no U), whose
    /// noise neighbours hardly show: a sum of n steps of independent noise has √(3n) times the σ that
    /// their second differences show. Gives back the largest of these.
    ///
    /// formula  second difference of a sum: e(i+1) − e(i), √2 σ(e); of independent values: √6 σ
    fn widen(&mut self, sigma: f64) -> Option<f64> {
        let seen = self.question.seen;
        let is_stated = |o: &Observation| o.u_um.is_some() || o.found_variance > 0.0;
        let is_mixed = seen.iter().any(is_stated);
        let mut widest = None;
        for (observation, own) in seen.iter().zip(&mut self.sigma_um) {
            let mut least = sigma;
            if is_mixed && !is_stated(observation) {
                let curve = seen.iter().filter(|o| o.curve == observation.curve);
                let steps = curve.count().saturating_sub(1).max(1) as f64;
                least *= (STEPS_OF_A_SUM * steps).sqrt();
                widest = Some(widest.map_or(least, |um| larger(um, least)));
            }
            *own = larger(*own, least);
        }
        widest
    }

    /// Scatter about the forecast, µm; about the best explanation where that is smaller by more than
    /// chance (F at [`RISK`]). `None` = too few values.
    fn least_scatter(&self, fits: &[Fit], forecast: &Fit) -> Option<f64> {
        let (own, count) = self.scatter(forecast)?;
        let best = fits.iter().min_by(|a, b| self.rms(a, None).total_cmp(&self.rms(b, None)));
        let best = best.and_then(|fit| self.scatter(fit)).map_or(own, |(um, _)| um);
        let freedom = count / DIFFERENCES_OF_A_FREEDOM;
        let by_chance = FisherSnedecor::new(freedom, freedom).ok()?.inverse_cdf(1.0 - RISK).sqrt();
        let sigma = if own > by_chance * best { best } else { own };
        let widened = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(1.0 - RISK / 2.0);
        Some(sigma * widened / quantile(1.0 - RISK, 1.0).sqrt())
    }

    /// Least root mean square of the fits, up to a share of what the tables add, µm.
    fn bounded_rms<'b>(&self, fits: impl Iterator<Item = &'b Fit>, floor: f64) -> f64 {
        let best = fits.map(|fit| self.rms(fit, None)).fold(f64::INFINITY, smaller);
        let most = MOST_SCATTER * self.rms_of(&self.effects(&Change::None, &[]));
        best.clamp(floor, larger(most, floor))
    }

    /// σ of independent noise from second differences of what a fit leaves along each curve, µm, and
    /// their number; `None` = too few.
    ///
    /// formula  σ = median |r(i−1) − 2 r(i) + r(i+1)| / (0.6745·√6): a few wild values do not move it
    fn scatter(&self, fit: &Fit) -> Option<(f64, f64)> {
        let second = |w: &[Left]| (w[0].0 - 2.0 * w[1].0 + w[2].0).abs();
        let (curves, _) = self.groups(fit, None, |o| o.curve);
        let windows = curves.iter().flat_map(|curve| curve.windows(3));
        let mut sizes: Vec<f64> = windows.map(second).collect();
        sizes.sort_by(f64::total_cmp);
        let count = sizes.len() as f64;
        let median = *sizes.get(sizes.len() / 2)?;
        let sigma = median / NORMAL_MEDIAN / SECOND_DIFFERENCE;
        (count >= FEWEST_DIFFERENCES).then_some((sigma, count))
    }

    /// The same with the second measurement in another unit; its u is that of the values, or
    /// (`u_times` = 1) right as it stands.
    pub(super) fn in_another_unit(&self, times: f64, u_times: f64) -> Data<'a> {
        let sigma = |o: &Observation| {
            let u = o.u_um.unwrap_or(0.0) * u_times;
            (u * u + o.found_variance + other_variance(self.question, o)).sqrt()
        };
        Data {
            measured_um: self.measured_um.iter().map(|um| um * times).collect(),
            sigma_um: self.question.seen.iter().map(sigma).collect(),
            ..self.clone()
        }
    }

    /// Largest value measured afterwards by the largest as found.
    pub(super) fn times_found(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, um| most.max(um.abs()));
        largest(&self.measured_um) / largest(&self.found_um).max(SMALLEST_UM)
    }

    /// Root mean square of values less their zeros, µm.
    pub(super) fn rms_of(&self, values_um: &[f64]) -> f64 {
        root_mean_square(&self.less_zeros(values_um))
    }

    /// What each value sees of the control with a change, and beside it, µm.
    pub(super) fn effects(&self, change: &Change, fitted: &[f64]) -> Vec<f64> {
        let effect = |part: &SeenDeviation| {
            let [added, beside] = change.effect(self.question, fitted, part);
            part.weight * (added + beside)
        };
        let seen = self.question.seen.iter();
        seen.map(|observation| observation.parts.iter().map(effect).sum()).collect()
    }

    /// A change with these numbers.
    pub(super) fn evaluated(&self, change: &Change, fitted: Vec<f64>) -> Fit {
        let predicted = plus(&self.found_um, &self.effects(change, &fitted));
        Fit {
            fitted,
            residuals_um: self.less_zeros(&minus(&self.measured_um, &predicted)),
            predicted_um: self.less_zeros(&predicted),
        }
    }

    /// Values less the weighted mean of those that count from the same zero.
    pub(super) fn less_zeros(&self, values: &[f64]) -> Vec<f64> {
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        let seen = self.question.seen;
        for ((observation, sigma), value) in seen.iter().zip(&self.sigma_um).zip(values) {
            let weight = 1.0 / (sigma * sigma);
            let sum = sums.entry(observation.zero).or_default();
            *sum = (sum.0 + weight * value, sum.1 + weight);
        }
        let seen = seen.iter().zip(values);
        seen.map(|(o, value)| value - sums[&o.zero].0 / sums[&o.zero].1).collect()
    }

    /// Σ (residual/σ)².
    pub(super) fn square(&self, fit: &Fit) -> f64 {
        self.weighted(&fit.residuals_um).into_iter().map(f64::squared).sum()
    }

    /// Values by their σ, less what the scale of the laser may have added, whose own size stands behind them.
    pub(super) fn weighted(&self, values_um: &[f64]) -> Vec<f64> {
        let (left, laser) = self.left(values_um, None);
        left.into_iter().map(|(_, (left, sigma))| left / sigma).chain(laser).collect()
    }

    /// Observations (of one term, or all), their values less what the scale of the laser may have added, which is one
    /// error of all positions, axes and directions, and their σ, µm; how much of it that takes, by its own u. `None` =
    /// none is stated.
    ///
    /// formula  the s with least Σ ((value − s c)/σ)² + s²; c = what one standard uncertainty adds, less its zeros
    fn left(
        &self,
        values_um: &[f64],
        term: Option<ErrorTerm>,
    ) -> (Vec<(&'a Observation, Left)>, Option<f64>) {
        let question = self.question;
        let laser = question.laser_um_per_m;
        let grown = |o: &Observation| o.predicted(|part| Some(question.grown_um(part, laser)));
        let grown = question.seen.iter().map(|o| grown(o).unwrap_or(0.0));
        let added = self.less_zeros(&grown.collect::<Vec<f64>>());
        let each = question.seen.iter().zip(&self.sigma_um).zip(added.iter().zip(values_um));
        let each: Vec<_> =
            each.filter(|((o, _), _)| term.is_none_or(|term| o.is_of(term))).collect();
        let (mut share, mut known) = (0.0, 1.0);
        for ((_, sigma), (added, value)) in &each {
            share += *added * *value / sigma.squared();
            known += (*added / *sigma).squared();
        }
        let size = share / known;
        let left = each.into_iter();
        let left = left.map(|((o, sigma), (added, um))| (o, (um - size * added, *sigma)));
        (left.collect(), (laser > 0.0).then_some(size))
    }

    /// What a fit leaves by curve, or by zero; and how much of the laser's scale it takes.
    fn groups(
        &self,
        fit: &Fit,
        term: Option<ErrorTerm>,
        of: fn(&Observation) -> usize,
    ) -> (Vec<Group>, Option<f64>) {
        let mut groups: BTreeMap<usize, Group> = BTreeMap::new();
        let (left, laser) = self.left(&fit.residuals_um, term);
        for (observation, left) in left {
            groups.entry(of(observation)).or_default().push(left);
        }
        (groups.into_values().collect(), laser)
    }

    /// Sum over the curves of the mean squared residual over σ²; that of chi-squared with as many
    /// degrees of freedom as curves where the points of a curve move together.
    pub(super) fn score(&self, fit: &Fit) -> f64 {
        self.by_curve(fit, None).into_iter().sum()
    }

    /// The mean of each curve; the scale of the laser is one figure more.
    fn by_curve(&self, fit: &Fit, term: Option<ErrorTerm>) -> Vec<f64> {
        let (curves, laser) = self.groups(fit, term, |o| o.curve);
        let squares = |curve: &Group| curve.iter().map(|(um, u)| (um / u).squared()).sum::<f64>();
        let means = curves.iter().map(|curve| squares(curve) / curve.len() as f64);
        means.chain(laser.map(f64::squared)).collect()
    }

    /// Whether a fit is not rejected: all curves (of one term, or all) together, each by itself, and the
    /// two values of one zero that lie farthest apart.
    pub(super) fn stands(&self, fit: &Fit, term: Option<ErrorTerm>) -> bool {
        let curves = self.by_curve(fit, term);
        let count = curves.len() as f64;
        let each = quantile(1.0 - RISK / count.max(1.0), 1.0);
        let together: f64 = curves.iter().sum();
        together <= quantile(1.0 - RISK, count)
            && curves.iter().all(|mean| *mean <= each)
            && self.no_two_values_apart(fit, term)
    }

    /// A slope, a step or one bad place is diluted in the mean of a curve: so no two values that
    /// count from one zero may differ from the prediction by more than their σ allows, at
    /// [`RISK`] shared by all pairs (Bonferroni).
    fn no_two_values_apart(&self, fit: &Fit, term: Option<ErrorTerm>) -> bool {
        let (groups, _) = self.groups(fit, term, |o| o.zero);
        let pairs = groups.iter().map(|group| (group.len() * group.len()) as f64 / 2.0);
        let limit = quantile(1.0 - RISK / pairs.sum::<f64>(), 1.0);
        groups.iter().all(|group| {
            let by_left = |a: &&Left, b: &&Left| a.0.total_cmp(&b.0);
            let ends = group.iter().min_by(by_left).zip(group.iter().max_by(by_left));
            ends.is_none_or(|(low, high)| {
                (high.0 - low.0).squared() <= limit * (low.1.squared() + high.1.squared())
            })
        })
    }

    /// Root mean square of what a fit leaves, of one term or all, µm.
    pub(super) fn rms(&self, fit: &Fit, term: Option<ErrorTerm>) -> f64 {
        let seen = self.question.seen.iter().zip(&fit.residuals_um);
        let own = seen.filter(|(o, _)| term.is_none_or(|term| o.is_of(term)));
        root_mean_square(&own.map(|(_, um)| *um).collect::<Vec<f64>>())
    }
}

pub(super) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

pub(super) fn plus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Table values are whole counts, spread evenly over one; between its targets the first measurement saw nothing.
fn other_variance(question: &Question<'_>, of: &Observation) -> f64 {
    let unseen = of.parts.iter().map(|part| (part.weight * question.unseen_um(part)).squared());
    question.count_um.squared() / 12.0 + SMALLEST_UM.squared() + unseen.sum::<f64>()
}

/// σ of every value, and where it comes from.
fn sigmas(question: &Question<'_>) -> (Vec<f64>, String) {
    let sigma = |o: &Observation| {
        let found = o.found_variance;
        let left = o.u_um.map_or(found, |u| u * u);
        let found = if found > 0.0 { found } else { left };
        (left + found + other_variance(question, o)).sqrt()
    };
    let found = question.before.measured().any(|(_, m)| m.u_value_um().is_some());
    let left = question.seen.iter().any(|o| o.u_um.is_some());
    let one = |own, other| {
        format!(
            "u of the {own} measurement; that of the {other} is not stated and taken as the same"
        )
    };
    let mut words = match (found, left) {
        (true, true) => "u of both measurements".to_string(),
        (false, true) => one("second", "first"),
        (true, false) => one("first", "second"),
        (false, false) => String::new(),
    };
    if question.laser_um_per_m > 0.0 && !words.is_empty() {
        let laser = question.laser_um_per_m;
        words += &format!(", and {laser:.2} µm/m of laser scale, common to all axes");
    }
    let unseen_um = question.parts().map(|part| question.unseen_um(part)).fold(0.0, larger);
    if unseen_um > SMALLEST_UM && !words.is_empty() {
        words += &format!(
            ", and up to {unseen_um:.3} µm between the first targets, where straight lines and a spline through them differ"
        );
    }
    (question.seen.iter().map(sigma).collect(), words)
}

/// Risk of rejecting what is right.
pub(super) const RISK: f64 = 0.001;

pub(super) fn quantile(probability: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::INFINITY, |spread| spread.inverse_cdf(probability))
}
