//! The values of the second measurement, their weights, and the misfit of a fault.

use super::fault::{Fault, Planned};
use super::{RISK, quantile};
use crate::after::{Control, Observation, Part, before_um};
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::model::ErrorModel;
use crate::units::Deviation;
use nalgebra::{DMatrix, DVector};

/// What is known when a cause is asked for.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// As found.
    pub before: &'a ErrorModel,
    /// What the loaded tables add.
    pub control: &'a Control,
    /// The values of the second measurement.
    pub seen: &'a [Observation],
    /// Direction of the reference return of each axis.
    pub homing: PerAxis<Direction>,
    /// Reference point of each axis, mm.
    pub reference_mm: PerAxis<f64>,
    /// Expansion of each scale, 1/K.
    pub alpha_per_k: PerAxis<f64>,
    /// Largest count of the tables, µm.
    pub count_um: f64,
    /// Largest residual of the forecast, µm.
    pub forecast_um: f64,
}

impl Question<'_> {
    /// The terms that the second measurement sees.
    pub fn terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| {
            let mut parts = self.seen.iter().flat_map(|o| &o.parts);
            parts.any(|part| part.term == *term)
        };
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    pub(super) fn has_two_tables(&self) -> bool {
        self.tabled().any(|(term, at)| {
            let um = Direction::BOTH.map(|way| self.control.tables_um(term, way, at));
            (um[0] - um[1]).abs() > SMALLEST_UM
        })
    }

    pub(super) fn has_parameter(&self) -> bool {
        let ways = |term| Direction::BOTH.map(|way| self.control.constant_um(term, way));
        let terms = ErrorTerm::ALL.into_iter().flat_map(ways);
        terms.into_iter().any(|um| um.abs() > SMALLEST_UM)
    }

    fn tabled(&self) -> impl Iterator<Item = (ErrorTerm, crate::units::Millimetres)> {
        let nodes = |term: ErrorTerm| {
            let nodes = self.control.nodes(term).into_iter();
            nodes.map(move |at| (term, at))
        };
        ErrorTerm::ALL.into_iter().flat_map(nodes)
    }

    /// What a backlash parameter of −B as found adds: it acts away from the reference direction.
    pub(super) fn parameter_um(&self, axis: Axis, direction: Direction) -> f64 {
        let reversal_um = self.reversal_um(axis).unwrap_or(0.0);
        match direction {
            own if own == self.homing[axis] => 0.0,
            Direction::Minus => reversal_um,
            Direction::Plus => (-Deviation::from_um(reversal_um)).um(),
        }
    }

    /// B of an axis as found, µm.
    pub(super) fn reversal_um(&self, axis: Axis) -> Option<f64> {
        let measured = self.before.terms[ErrorTerm {
            of: axis,
            along: axis,
        }]
        .as_ref()?;
        Some(measured.reversal()?.um())
    }

    /// Mean of both directions: the correction without its part for the reversal, µm.
    pub(super) fn without_reversal_um(&self, part: &Part) -> f64 {
        let way = |direction| {
            let tables = self.control.tables_um(part.term, direction, part.at);
            tables + self.control.constant_um(part.term, direction)
        };
        f64::midpoint(way(Direction::Plus), way(Direction::Minus))
    }

    /// Whether the data see an axis (`None` = any) in both directions, and it had a reversal.
    pub(super) fn shows_reversal(&self, axis: Option<Axis>) -> bool {
        let of = |axis: Axis| {
            let term = ErrorTerm {
                of: axis,
                along: axis,
            };
            let sees = |way: Direction| {
                let mut values = self.seen.iter();
                values.any(|o| o.parts.iter().any(|p| p.term == term && p.direction == way))
            };
            self.reversal_um(axis).is_some() && Direction::BOTH.into_iter().all(sees)
        };
        match axis {
            Some(axis) => of(axis),
            None => Axis::ALL.into_iter().any(of),
        }
    }
}

/// What no laser resolves, µm.
const SMALLEST_UM: f64 = 0.01;
/// Where no uncertainty is stated, the scatter about the best explanation is taken, up to this
/// share of what the tables add: more would explain nothing.
const MOST_SCATTER: f64 = 0.1;

/// What the comparison rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// Values that were compared.
    pub values: usize,
    /// Curves (or passes) they stand on: the degrees of freedom.
    pub curves: usize,
    /// Root mean square of σ, µm.
    pub sigma_um: f64,
    /// Where σ comes from.
    pub words: String,
}

/// A fault, fitted.
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
        let pairs = self.predicted_um.iter().zip(&other.predicted_um);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

/// The values with everything that does not depend on the fault.
pub(super) struct Data<'a> {
    pub(super) question: &'a Question<'a>,
    pub(super) basis: Basis,
    measured_um: Vec<f64>,
    found_um: Vec<f64>,
    planned: Vec<Vec<Planned>>,
    sigma_um: Vec<f64>,
    zeros: usize,
}

impl<'a> Data<'a> {
    pub(super) fn new(question: &'a Question<'a>) -> Data<'a> {
        let seen = question.seen;
        let planned = |part: &Part| Planned {
            tables: question
                .control
                .tables_um(part.term, part.direction, part.at),
            constant: question.control.constant_um(part.term, part.direction),
        };
        let found = |o: &Observation| o.predicted(|part| before_um(question.before, part));
        let mut curves: Vec<usize> = seen.iter().map(|o| o.curve).collect();
        curves.sort_unstable();
        curves.dedup();
        let (sigma_um, words) = sigmas(question);
        Data {
            question,
            basis: Basis {
                values: seen.len(),
                curves: curves.len(),
                sigma_um: root_mean_square(&sigma_um),
                words,
            },
            measured_um: seen.iter().map(|o| o.um).collect(),
            found_um: seen.iter().map(|o| found(o).unwrap_or(0.0)).collect(),
            planned: seen
                .iter()
                .map(|o| o.parts.iter().map(planned).collect())
                .collect(),
            sigma_um,
            zeros: seen.iter().map(|o| o.zero + 1).max().unwrap_or(0),
        }
    }

    /// Whether either measurement states an uncertainty.
    pub(super) fn has_uncertainty(&self) -> bool {
        let after = self.question.seen.iter().any(|o| o.u_um.is_some());
        let mut before = self.question.before.measured();
        after || before.any(|(_, measured)| measured.u_um.is_some())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.measured_um.is_empty()
    }

    /// Without any stated uncertainty: the scatter about the best explanation.
    pub(super) fn settle(&mut self, fits: &[Fit]) {
        let forecast = self.fit(&Fault::None);
        let all = fits.iter().chain([&forecast]).map(|fit| self.rms(fit));
        let best = all.fold(f64::INFINITY, f64::min);
        let planned: Vec<f64> = self.effects(&Fault::None, &[]);
        let floor = floor_um(self.question);
        let most = (MOST_SCATTER * root_mean_square(&self.less_zeros(&planned))).max(floor);
        let sigma = best.clamp(floor, most);
        self.sigma_um = vec![sigma; self.sigma_um.len()];
        self.basis.sigma_um = sigma;
        self.basis.words = format!(
            "no uncertainty is stated: {sigma:.3} µm is taken, the scatter about the best explanation, at least half a count and what the forecast leaves ({floor:.3} µm)"
        );
    }

    /// The same with the second measurement in another unit.
    pub(super) fn divided_by(&self, unit: f64) -> Data<'a> {
        let found = |o: &Observation| found_variance(self.question, o);
        let seen = self.question.seen.iter();
        let sigma = |o: &Observation| {
            let u = o.u_um.unwrap_or(0.0) / unit;
            (u * u + found(o) + rounding_variance(self.question)).sqrt()
        };
        Data {
            question: self.question,
            basis: self.basis.clone(),
            measured_um: self.measured_um.iter().map(|um| um / unit).collect(),
            found_um: self.found_um.clone(),
            planned: self.planned.clone(),
            sigma_um: seen.map(sigma).collect(),
            zeros: self.zeros,
        }
    }

    /// Largest value measured afterwards by the largest as found.
    pub(super) fn times_found(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, um| most.max(um.abs()));
        largest(&self.measured_um) / largest(&self.found_um).max(SMALLEST_UM)
    }

    fn effects(&self, fault: &Fault, fitted: &[f64]) -> Vec<f64> {
        let of = |(observation, planned): (&Observation, &Vec<Planned>)| {
            let parts = observation.parts.iter().zip(planned);
            parts
                .map(|(part, planned)| {
                    part.weight * fault.effect(self.question, fitted, part, *planned)
                })
                .sum()
        };
        self.question
            .seen
            .iter()
            .zip(&self.planned)
            .map(of)
            .collect()
    }

    fn evaluated(&self, fault: &Fault, fitted: Vec<f64>) -> Fit {
        let effects = self.effects(fault, &fitted);
        let predicted: Vec<f64> = effects
            .iter()
            .zip(&self.found_um)
            .map(|(a, b)| a + b)
            .collect();
        let left: Vec<f64> = self
            .measured_um
            .iter()
            .zip(&predicted)
            .map(|(a, b)| a - b)
            .collect();
        Fit {
            fitted,
            predicted_um: self.less_zeros(&predicted),
            residuals_um: self.less_zeros(&left),
        }
    }

    /// Values less the weighted mean of those that count from the same zero.
    fn less_zeros(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.zeros];
        for ((observation, sigma), value) in
            self.question.seen.iter().zip(&self.sigma_um).zip(values)
        {
            let weight = 1.0 / (sigma * sigma);
            let sum = &mut sums[observation.zero];
            *sum = (sum.0 + weight * value, sum.1 + weight);
        }
        let seen = self.question.seen.iter().zip(values);
        seen.map(|(o, value)| value - sums[o.zero].0 / sums[o.zero].1)
            .collect()
    }

    /// The fault with its numbers fitted.
    pub(super) fn fit(&self, fault: &Fault) -> Fit {
        match fault {
            Fault::Shifted(axis) => self.fit_shift(*axis),
            fault if fault.parameters() == 0 => self.evaluated(fault, Vec::new()),
            fault => {
                let fitted = self.linear(fault, fault.parameters());
                self.evaluated(fault, fitted)
            }
        }
    }

    /// Weighted least squares of numbers that act in proportion.
    fn linear(&self, fault: &Fault, count: usize) -> Vec<f64> {
        let weighted = |values: Vec<f64>| {
            let less = self.less_zeros(&values);
            let pairs = less.iter().zip(&self.sigma_um);
            pairs
                .map(|(value, sigma)| value / sigma)
                .collect::<Vec<f64>>()
        };
        let base = self.effects(fault, &vec![0.0; count]);
        let mut columns = Vec::new();
        for index in 0..count {
            let mut unit = vec![0.0; count];
            unit[index] = 1.0;
            let effects = self.effects(fault, &unit);
            columns.extend(weighted(
                effects.iter().zip(&base).map(|(a, b)| a - b).collect(),
            ));
        }
        let known = self.found_um.iter().zip(&base).map(|(a, b)| a + b);
        let left = weighted(
            self.measured_um
                .iter()
                .zip(known)
                .map(|(a, b)| a - b)
                .collect(),
        );
        let matrix = DMatrix::from_vec(left.len(), count, columns);
        let solved = matrix
            .svd(true, true)
            .solve(&DVector::from_vec(left), NEGLIGIBLE);
        solved.map_or_else(
            |_| vec![0.0; count],
            |found| found.iter().copied().collect(),
        )
    }

    /// A shift acts through the shape of the tables: searched on a grid, then narrowed. Axes are
    /// searched one after the other; twice where they meet on a diagonal.
    fn fit_shift(&self, axis: Option<Axis>) -> Fit {
        let fault = Fault::Shifted(axis);
        match axis {
            Some(own) => {
                let found = self.search(own, |mm| self.evaluated(&fault, vec![mm]));
                self.evaluated(&fault, vec![found])
            }
            None => {
                let mut fitted = vec![0.0; 3];
                let together = self.question.seen.iter().any(|o| o.diagonal.is_some());
                let rounds = if together { 2 } else { 1 };
                for _ in 0..rounds {
                    for (index, own) in Axis::ALL.into_iter().enumerate() {
                        fitted[index] = self.search(own, |mm| {
                            let mut tried = fitted.clone();
                            tried[index] = mm;
                            self.evaluated(&fault, tried)
                        });
                    }
                }
                self.evaluated(&fault, fitted)
            }
        }
    }

    fn search(&self, axis: Axis, of: impl Fn(f64) -> Fit) -> f64 {
        let along = ErrorTerm::ALL.into_iter().filter(|term| term.along == axis);
        let nodes: Vec<f64> = along
            .flat_map(|term| self.question.control.nodes(term))
            .map(|at| at.mm())
            .collect();
        let low = nodes.iter().copied().fold(f64::INFINITY, f64::min);
        let high = nodes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if high <= low {
            return 0.0;
        }
        let most = (high - low) / 2.0;
        let step = most / SHIFTS;
        let square = |mm: f64| self.square(&of(mm));
        let grid =
            std::iter::successors(Some(-most), |mm| Some(mm + step)).take_while(|mm| *mm <= most);
        let best = grid
            .map(|mm| (square(mm), mm))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, middle) = best.unwrap_or((0.0, 0.0));
        narrowed(middle - step, middle + step, square)
    }

    /// Σ (residual/σ)².
    fn square(&self, fit: &Fit) -> f64 {
        let pairs = fit.residuals_um.iter().zip(&self.sigma_um);
        pairs.map(|(left, sigma)| (left / sigma).powi(2)).sum()
    }

    /// Sum over the curves of the mean squared residual over σ²; that of chi-squared with as many
    /// degrees of freedom as curves where the points of a curve move together.
    pub(super) fn score(&self, fit: &Fit) -> f64 {
        self.by_curve(fit, |_| true).into_iter().sum()
    }

    fn by_curve(&self, fit: &Fit, of: impl Fn(&Observation) -> bool) -> Vec<f64> {
        let mut sums: std::collections::BTreeMap<usize, (f64, f64)> =
            std::collections::BTreeMap::new();
        let values = self
            .question
            .seen
            .iter()
            .zip(&fit.residuals_um)
            .zip(&self.sigma_um);
        for ((observation, left), sigma) in values.filter(|((o, _), _)| of(o)) {
            let sum = sums.entry(observation.curve).or_default();
            *sum = (sum.0 + (left / sigma).powi(2), sum.1 + 1.0);
        }
        sums.into_values()
            .map(|(square, count)| square / count)
            .collect()
    }

    /// Whether a fit is not rejected: all curves together, and each by itself.
    pub(super) fn stands(&self, fit: &Fit) -> bool {
        not_rejected(&self.by_curve(fit, |_| true))
    }

    /// The same for the curves of one term.
    pub(super) fn stands_alone(&self, fit: &Fit, term: ErrorTerm) -> bool {
        not_rejected(&self.by_curve(fit, |o| o.is_of(term)))
    }

    /// Terms that were measured by themselves.
    pub(super) fn single_terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| self.question.seen.iter().any(|o| o.is_of(*term));
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    /// Root mean square of what a fit leaves of one term, µm.
    pub(super) fn rms_of(&self, fit: &Fit, term: ErrorTerm) -> f64 {
        let seen = self.question.seen.iter().zip(&fit.residuals_um);
        let of_term = seen.filter(|(o, _)| o.is_of(term));
        root_mean_square(&of_term.map(|(_, um)| *um).collect::<Vec<f64>>())
    }

    /// Root mean square of what a fit leaves, µm.
    pub(super) fn rms(&self, fit: &Fit) -> f64 {
        root_mean_square(&fit.residuals_um)
    }
}

/// Singular values below this share of a column's length are rounding.
const NEGLIGIBLE: f64 = 1e-9;
/// Steps to either side in which a shift is searched over half the length of the tables.
const SHIFTS: f64 = 40.0;

fn not_rejected(curves: &[f64]) -> bool {
    #[allow(clippy::cast_precision_loss, reason = "a handful of curves")]
    let count = curves.len() as f64;
    let each = quantile(1.0 - RISK / count.max(1.0), 1.0);
    let together: f64 = curves.iter().sum();
    together <= quantile(1.0 - RISK, count) && curves.iter().all(|mean| *mean <= each)
}

/// Golden section.
fn narrowed(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_895;
    const ROUNDS: usize = 24; // 10⁻⁵ of the first width
    for _ in 0..ROUNDS {
        let (a, b) = (high - SHARE * (high - low), low + SHARE * (high - low));
        if of(a) <= of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    f64::midpoint(low, high)
}

fn root_mean_square(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 values")]
    let count = values.len().max(1) as f64;
    (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt()
}

fn floor_um(question: &Question<'_>) -> f64 {
    (question.count_um / 2.0)
        .hypot(question.forecast_um)
        .max(SMALLEST_UM)
}

/// Σ (weight · u as found)² over the errors that a value sees; parts of one term move together.
fn found_variance(question: &Question<'_>, observation: &Observation) -> f64 {
    let of = |term: ErrorTerm| {
        let parts = observation.parts.iter().filter(|part| part.term == term);
        let weight: f64 = parts.map(|part| part.weight).sum();
        let u = question.before.terms[term].as_ref().and_then(|m| m.u_um);
        (weight * u.unwrap_or(0.0)).powi(2)
    };
    ErrorTerm::ALL.into_iter().map(of).sum()
}

/// Table values are whole counts, spread evenly over one.
fn rounding_variance(question: &Question<'_>) -> f64 {
    question.count_um * question.count_um / 12.0 + SMALLEST_UM * SMALLEST_UM
}

/// σ of every value, and where it comes from.
fn sigmas(question: &Question<'_>) -> (Vec<f64>, String) {
    let rounding = rounding_variance(question);
    let sigma = |o: &Observation| {
        let found = found_variance(question, o);
        let left = o.u_um.map_or(found, |u| u * u);
        let found = if found > 0.0 { found } else { left };
        (left + found + rounding).sqrt()
    };
    let found = question.before.measured().any(|(_, m)| m.u_um.is_some());
    let left = question.seen.iter().any(|o| o.u_um.is_some());
    let words = match (found, left) {
        (true, true) => "u of both measurements".to_string(),
        (false, true) => {
            "u of the second measurement; that of the first is not stated and taken as the same"
                .to_string()
        }
        (true, false) => {
            "u of the first measurement; that of the second is not stated and taken as the same"
                .to_string()
        }
        (false, false) => String::new(),
    };
    (question.seen.iter().map(sigma).collect(), words)
}
