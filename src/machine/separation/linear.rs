//! The linear model of a measurement: every figure is a row over what was measured, every cause a column.
//!
//! ```text
//!   z      = (mean readings of each pass, linear axes and beams, what (7) neglects of each equation)
//!   figure = row · z
//!   cov(z) = diag(σ²/runs, u² of the lines, neglected²) + Σ c cᵀ     c: what one u of a cause does to z
//!   u²     = row · cov(z) · rowᵀ
//! ```
//! Rows of neighbouring points of a curve differ by the increments of one interval: a curve is a running sum.

use super::campaign::MeasuredLine;
use super::noise::{Noise, effective_freedom};
use super::readings::Means;
use super::uncertainty::SlopeUncertainty;
use crate::quantity::diagonal::{Diagonal, Pass};
use crate::quantity::units::Squared;

/// Where the entries of z stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Readings of a pass along a diagonal.
    pub(super) nodes: usize,
    /// Passes along each diagonal: 1 or 2.
    pub(super) passes: usize,
    /// Linear axes and beams.
    pub(super) lines: usize,
}

impl Layout {
    /// Place of a mean reading.
    pub(super) fn reading(self, pass: Pass, diagonal: Diagonal, node: usize) -> usize {
        let line = usize::from(pass == Pass::Reverse) * 4 + diagonal as usize;
        line * self.nodes + node
    }

    /// Place of a linear axis or beam.
    pub(super) fn line(self, index: usize) -> usize {
        self.passes * 4 * self.nodes + index
    }

    /// Place of what an equation of (7) neglects; the diagonals come first, then the lines.
    pub(super) fn neglected(self, equation: usize) -> usize {
        self.line(self.lines) + equation
    }

    /// z of these readings and lines; what is neglected is 0.
    pub(super) fn measured(self, means: &Means, lines: &[MeasuredLine]) -> Vec<f64> {
        let passes = Pass::BOTH.into_iter().take(self.passes);
        let readings = passes.flat_map(|pass| Diagonal::ALL.map(|d| &means.of(pass)[d]));
        let mut z: Vec<f64> = readings.flatten().copied().collect();
        z.extend(lines.iter().map(|line| line.slope_um_per_m));
        z.resize(self.len(), 0.0);
        z
    }

    fn len(self) -> usize {
        self.neglected(4 + self.lines)
    }
}

/// A figure by the entries of z that it hangs on; an entry may stand in it more than once.
#[derive(Clone, Debug, Default)]
pub(super) struct Row(pub(super) Vec<(usize, f64)>);

impl Row {
    /// One entry.
    pub(super) fn of(place: usize) -> Row {
        Row(vec![(place, 1.0)])
    }

    /// Adds another figure so many times.
    pub(super) fn add(&mut self, times: f64, other: &Row) {
        if times != 0.0 {
            self.0.extend(other.0.iter().map(|(place, weight)| (*place, times * weight)));
        }
    }

    /// The sum of figures, each so many times.
    pub(super) fn sum<'a>(of: impl IntoIterator<Item = (f64, &'a Row)>) -> Row {
        let mut sum = Row::default();
        of.into_iter().for_each(|(times, row)| sum.add(times, row));
        sum
    }

    /// The figure of these entries.
    pub(super) fn dot(&self, z: &[f64]) -> f64 {
        self.0.iter().map(|(place, weight)| weight * z[*place]).sum()
    }
}

/// What is uncertain of z.
pub(super) struct Model {
    pub(super) layout: Layout,
    /// Variance by the noise of the readings; 0 for what is no reading.
    pub(super) noise: Vec<f64>,
    /// Variance of lines and of what is neglected.
    pub(super) other: Vec<f64>,
    /// What one standard uncertainty of each cause does to z.
    pub(super) causes: Vec<Vec<f64>>,
    /// So many of them act alike in all set-ups.
    pub(super) common: usize,
}

/// u² of a figure: by the noise of the readings, by everything.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Variance {
    pub(super) noise: f64,
    pub(super) all: f64,
}

impl Variance {
    /// As standard uncertainty with its degrees of freedom.
    pub(super) fn as_slope(self, noise: Noise) -> SlopeUncertainty {
        let u_um_per_m = self.all.sqrt();
        let freedom = effective_freedom(u_um_per_m, self.noise.sqrt(), noise);
        SlopeUncertainty { u_um_per_m, freedom }
    }
}

impl Model {
    /// Nothing uncertain yet.
    pub(super) fn new(layout: Layout) -> Model {
        let zero = vec![0.0; layout.len()];
        Model { layout, noise: zero.clone(), other: zero, causes: Vec::new(), common: 0 }
    }

    /// Standard deviations of the readings and lines, whose causes are left out.
    pub(super) fn drawn(&self) -> Vec<f64> {
        let both = self.noise.iter().zip(&self.other).take(self.layout.neglected(0));
        both.map(|(noise, other)| (noise + other).sqrt()).collect()
    }

    /// A row with each entry once.
    fn dense(&self, row: &Row) -> Vec<f64> {
        let mut dense = vec![0.0; self.layout.len()];
        row.0.iter().for_each(|(place, weight)| dense[*place] += weight);
        dense
    }

    fn by_cause(&self, dense: &[f64]) -> Vec<f64> {
        let of = |column: &Vec<f64>| dense.iter().zip(column).map(|(a, b)| a * b).sum();
        self.causes.iter().map(of).collect()
    }

    /// cov of two figures: by the noise of the readings, by everything, by the causes common to all set-ups.
    pub(super) fn covariance(&self, one: &Row, other: &Row) -> (Variance, f64) {
        let (one, other) = (self.dense(one), self.dense(other));
        let weighed = |variance: &[f64]| -> f64 {
            one.iter().zip(&other).zip(variance).map(|((a, b), v)| a * b * v).sum()
        };
        let noise = weighed(&self.noise);
        let causes = self.by_cause(&one).into_iter().zip(self.by_cause(&other));
        let causes: Vec<f64> = causes.map(|(a, b)| a * b).collect();
        let common = causes[..self.common].iter().sum();
        let all = noise + weighed(&self.other) + causes.iter().sum::<f64>();
        (Variance { noise, all }, common)
    }

    /// u² of a figure.
    pub(super) fn variance(&self, row: &Row) -> Variance {
        self.covariance(row, row).0
    }
}

/// A curve: at interval end i of n its value is start + steps 1 … i + (i/n) line.
#[derive(Clone, Debug, Default)]
pub(super) struct CurveRows {
    /// At the low end.
    pub(super) start: Row,
    /// Over each interval.
    pub(super) steps: Vec<Row>,
    /// Straight line from 0 at the low end to this at the high one.
    pub(super) line: Row,
}

impl CurveRows {
    /// The values for these entries; `line_um`: the line at the high end, which need not be linear in z.
    pub(super) fn values(&self, z: &[f64], line_um: f64) -> Vec<f64> {
        let last = self.steps.len().max(1) as f64;
        let mut sum = self.start.dot(z);
        let mut values = vec![sum];
        for (index, step) in self.steps.iter().enumerate() {
            sum += step.dot(z);
            values.push(sum + line_um * (index + 1) as f64 / last);
        }
        values
    }

    /// u² of each value.
    pub(super) fn variances(&self, model: &Model) -> Vec<Variance> {
        let line = model.dense(&self.line);
        let line_by_cause = model.by_cause(&line);
        let mut sum = model.dense(&self.start);
        let mut by_cause = model.by_cause(&sum);
        let last = self.steps.len().max(1) as f64;
        (0..=self.steps.len())
            .map(|index| {
                let step = index.checked_sub(1).map(|step| &self.steps[step]);
                for (place, weight) in step.iter().flat_map(|step| &step.0) {
                    sum[*place] += weight;
                    let columns = by_cause.iter_mut().zip(&model.causes);
                    columns.for_each(|(sum, column)| *sum += weight * column[*place]);
                }
                let share = index as f64 / last;
                let weighed = |variance: &[f64]| -> f64 {
                    let row = sum.iter().zip(&line).zip(variance);
                    row.map(|((sum, line), v)| (sum + share * line).squared() * v).sum()
                };
                let noise = weighed(&model.noise);
                let causes = by_cause.iter().zip(&line_by_cause);
                let causes: f64 = causes.map(|(sum, line)| (sum + share * line).squared()).sum();
                Variance { noise, all: noise + weighed(&model.other) + causes }
            })
            .collect()
    }
}
