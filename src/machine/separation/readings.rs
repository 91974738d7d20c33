//! Corrected readings: their means over runs, repeatability and noise, the tests against it (Student, χ², F), and the
//! disturbed readings that stand out of it.
//!
//! What repeated runs say: the standard deviation of a single reading, and the readings of single
//! runs that spoil it; and when a reading counts as disturbed.
//!
//! In each pass along a diagonal a reading is the mean of its node plus an offset of its run (each
//! run has a zero of its own) plus noise. A disturbed reading of one run stands out from the
//! others at its node; the closure sees only 1/r of it, and the scatter all of it. So these are
//! named first, and the noise is that of the others.
//!
//! A reading is named where taking it for unknown lowers the sum of squares more than chance
//! allows: t = size/u(size) against Student's t, with one false alarm in a hundred measurements
//! shared among all readings. The standard deviation is that of the others.

use super::curves::{mean, range};
use crate::quantity::{
    Axis, Diagonal, Direction, Figure, Pass, PathKind, PerDiagonal, Run, Squared, picometres,
};
use crate::text::words;
use nalgebra::DMatrix;
pub use nonius_numerics::rows::{coverage_factor, student};
use serde::{Serialize, Serializer};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

/// The mean of the runs of a pass along a diagonal.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse.
    pub pass: Pass,
    /// How many runs it is the mean of.
    pub runs: f64,
    /// Mean reading errors, µm, by node of the forward path.
    pub um: Vec<f64>,
}

/// Which readings stand for a curve: of every axis moving in this direction, forward passes of the diagonals that travel
/// so and reverse passes of the others; or the forward pass of all, with axes that a diagonal walks in − mixed in.
pub type Group = Option<Direction>;

/// The pass along a diagonal on which a group finds the steps of an axis.
pub(super) fn pass_of(group: Group, diagonal: Diagonal, axis: Axis) -> Pass {
    let is_forward = group.is_none_or(|direction| direction == diagonal.forward(axis));
    if is_forward { Pass::Forward } else { Pass::Reverse }
}

/// The passes that were walked: forward, then reverse, each by diagonal.
pub fn walks(runs: &[Run]) -> Vec<Walk> {
    let all = Pass::BOTH.into_iter().flat_map(|pass| Diagonal::ALL.map(|d| (d, pass)));
    let walk = |(diagonal, pass)| {
        let own = of(runs, (diagonal, pass));
        let mean = |node: usize| mean(own.iter().map(|run| run.deviations[node].um()));
        let um = (0..own.first()?.deviations.len()).map(mean).collect();
        Some(Walk { diagonal, pass, runs: float(own.len()), um })
    };
    all.filter_map(walk).collect()
}

/// Mean readings, and how many runs each of them is of.
pub(super) fn means(walks: Vec<Walk>) -> (Vec<f64>, Vec<f64>) {
    let of = |walk: Walk| walk.um.into_iter().map(move |um| (um, walk.runs));
    walks.into_iter().flat_map(of).unzip()
}

/// The runs of one pass along a diagonal.
fn of(runs: &[Run], way: (Diagonal, Pass)) -> Vec<&Run> {
    runs.iter().filter(|run| (run.diagonal, run.pass) == way).collect()
}

/// The readings of all runs of a pass along a diagonal by node; `None` where it was not walked.
pub(in crate::machine) fn by_node(runs: &[Run], d: Diagonal, pass: Pass) -> Option<Vec<Vec<f64>>> {
    let walks = of(runs, (d, pass));
    let at = |node: usize| walks.iter().map(|run| run.deviations[node].um()).collect();
    Some((0..walks.first()?.deviations.len()).map(at).collect())
}

/// Every how many nodes the target is on the diagonal: between the cell ends of a step run it is
/// beside it.
pub(in crate::machine) fn spacing(kind: PathKind) -> usize {
    if kind == PathKind::Step { 3 } else { 1 }
}

/// Figures of one diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalFigures {
    /// Reading error at the far end less that at the start, mean of all runs, µm.
    pub end_um: f64,
    /// Max − min over the nodes that lie on the diagonal, both passes, µm.
    pub range_um: f64,
}

/// Figures of every diagonal, and max − min over all of them, µm.
pub fn figures(runs: &[Run], kind: PathKind) -> (PerDiagonal<DiagonalFigures>, f64) {
    let walks = walks(runs);
    let of = |d: Diagonal| walks.iter().filter(move |walk| walk.diagonal == d);
    let on_diagonal = |d| of(d).flat_map(|walk| walk.um.iter().step_by(spacing(kind)));
    let figures = PerDiagonal::from_fn(|d| {
        // Far end less start of a pass, so that an offset between the passes does not count.
        let total = |walk: &Walk| Some(walk.um.last()? - walk.um.first()?);
        DiagonalFigures {
            end_um: mean(of(d).filter_map(total)),
            range_um: range(on_diagonal(d).copied()),
        }
    });
    (figures, range(Diagonal::ALL.into_iter().flat_map(on_diagonal).copied()))
}

/// Standard deviation of rounding to 0.01 µm, the last digit of an instrument, µm: no reading is
/// better known.
pub(super) const DIGIT_UM: f64 = 0.003;
/// What an instrument does not resolve is no disturbance, no roll, no reversal and no doubt, however
/// small the noise, µm.
pub(super) const UNRESOLVED_UM: f64 = 0.02;
/// 95 % quantile of the normal distribution.
pub(crate) const NORMAL_ONE_SIDED: f64 = 1.644_853_626_951_472;
/// Degrees of freedom from which on a noise that was found needs no stated one.
pub(super) const ENOUGH: usize = 20;
/// Chance that a test of the whole closure (scatter, ramps, mean) speaks against a sound
/// measurement: rarer than the naming of a reading, because no repeated run answers it.
pub const FALSE_DOUBT: f64 = 0.001;

words! {
    /// Where the standard deviation of a reading comes from.
    pub enum NoiseSource {
        /// Scatter of repeated runs.
        Repeats = "from the scatter of repeated runs",
        /// Scatter of the closure.
        Closure = "from the scatter of the closure",
        /// Stated in the job (`noise_um`).
        Stated = "as stated in the job (noise_um)",
        /// Few degrees of freedom of the readings, together with what the job states.
        Joined = "from the scatter, with few degrees of freedom, and noise_um",
    }
}

/// Standard deviation of a single reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// σ, µm.
    pub sigma_um: f64,
    /// Degrees of freedom; `None` where it is stated.
    pub freedom: Option<usize>,
    /// Where it comes from.
    pub source: NoiseSource,
}

impl std::fmt::Display for Noise {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} µm, {}", self.sigma_um, self.source.word())
    }
}

impl Noise {
    /// Degrees of freedom as a number; `None` = as good as known.
    pub fn freedom_f64(self) -> Option<f64> {
        self.freedom.map(float)
    }

    /// What counts where the job states a noise, too: with many degrees of freedom the one found; with few both,
    /// the stated one as if found with so many; the one found where they contradict each other.
    ///
    /// formula  σ² = (ν s² + 20 σ_stated²)/(ν + 20), with ν + 20 degrees of freedom
    pub(super) fn with_stated(self, stated_um: Option<f64>) -> Noise {
        let few = self.freedom.filter(|freedom| *freedom < ENOUGH);
        let (Some(freedom), Some(stated_um)) = (few, stated_um) else { return self };
        if self.contradicts(stated_um) {
            return self;
        }
        let (many, all) = (float(freedom), float(freedom + ENOUGH));
        let square = many * self.sigma_um.squared() + float(ENOUGH) * stated_um.squared();
        let (sigma_um, freedom) = ((square / all).sqrt(), Some(freedom + ENOUGH));
        Noise { sigma_um, freedom, source: NoiseSource::Joined }
    }

    /// Whether a stated noise is not that of these readings: χ², two-sided, at 1 %.
    pub(super) fn contradicts(self, stated_um: f64) -> bool {
        let freedom = self.freedom.unwrap_or(0);
        let square = float(freedom) * (self.sigma_um / stated_um.max(DIGIT_UM)).squared();
        let both = tails(square, freedom, None);
        both.is_some_and(|(below, above)| 2.0 * below.min(above) < FALSE_ALARM)
    }

    /// σ of a sum of squares of readings of 1 µm; `None` without degrees of freedom.
    pub(super) fn of_scatter(square: f64, freedom: usize, source: NoiseSource) -> Option<Noise> {
        let sigma_um = (square / float(freedom)).sqrt();
        (freedom > 0).then_some(Noise { sigma_um, freedom: Some(freedom), source })
    }
}

pub(super) const fn float(count: usize) -> f64 {
    count as f64
}

/// Probabilities of a sum of `count` squares of normal deviates by their variance below `square` and at
/// least as large: χ², or F where the variance is an estimate. `None` where `count` is 0.
pub(super) fn tails(square: f64, count: usize, freedom: Option<usize>) -> Option<(f64, f64)> {
    let many = float(count);
    if count > 0 && !square.is_finite() {
        return Some((1.0, 0.0));
    }
    let square = square.max(0.0);
    let both = |spread: &dyn ContinuousCDF<f64, f64>, at| Some((spread.cdf(at), spread.sf(at)));
    match freedom {
        Some(own) => both(&FisherSnedecor::new(many, float(own)).ok()?, square / many),
        None => both(&ChiSquared::new(many).ok()?, square),
    }
}

/// The probability of such a sum at least as large.
pub(super) fn chance_of(square: f64, count: usize, freedom: Option<usize>) -> Option<f64> {
    tails(square, count, freedom).map(|(_, above)| above)
}

/// Chance that a test names a reading of a series without any disturbed one.
const FALSE_ALARM: f64 = 0.01;
/// More disturbed readings than these are no outliers but another kind of trouble.
pub(super) const MOST_OUTLIERS: usize = 12;
/// A larger ratio says no more.
const LARGEST_RATIO: f64 = 1000.0;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct ReadingPlace {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Number of the run, as in the file; `None` = the mean of all runs of the pass.
    pub run: Option<u32>,
    /// Forward or reverse.
    #[serde(rename = "direction")]
    pub pass: Pass,
    /// Node of the forward path.
    pub node: usize,
}

impl std::fmt::Display for ReadingPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ", self.diagonal)?;
        if let Some(run) = self.run {
            write!(f, "run {run} ")?;
        }
        write!(f, "{} node {}", self.pass.word(), self.node)
    }
}

/// A disturbed reading, or several of which one is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// These cannot be told apart; one of them is disturbed.
    pub readings: Vec<ReadingPlace>,
    /// By how much, µm (sign of the first one).
    pub size_um: f64,
    /// The same in standard deviations.
    #[serde(rename = "standard_deviations", serialize_with = "to_picometres")]
    pub ratio: f64,
    /// By how much the mean over the runs is off, µm: that is what was separated.
    #[serde(skip)]
    pub of_mean_um: f64,
}

fn to_picometres<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
    picometres(*number).serialize(to)
}

impl Outlier {
    /// Which reading, by how much, in words.
    pub fn words(&self) -> String {
        let places: Vec<String> = self.readings.iter().map(ReadingPlace::to_string).collect();
        // Readings without noise leave no scatter to compare with.
        let ratio = match self.ratio < LARGEST_RATIO {
            true => format!("{:.1}", self.ratio),
            false => format!("more than {LARGEST_RATIO}"),
        };
        let (places, um) = (places.join(" or "), Figure(self.size_um));
        format!("{places}: {um:+.3} µm, {ratio} standard deviations")
    }
}

/// A candidate by what the sum of squares `square` of `freedom` loses with it: its ratio, if it
/// counts as disturbed. `sigma_um`: the standard deviation where it is known otherwise.
pub(super) fn stands_out(
    (size_um, drop): (f64, f64),
    (square, freedom): (f64, usize),
    sigma_um: Option<f64>,
    readings: usize,
) -> Option<f64> {
    let rest = freedom.saturating_sub(1);
    let (variance, freedom) = match sigma_um {
        Some(sigma) => (sigma * sigma, None),
        None if rest > 0 => ((square - drop).max(0.0) / float(rest), Some(float(rest))),
        None => return None,
    };
    let ratio = (drop / variance).sqrt();
    let limit = student(1.0 - FALSE_ALARM / 2.0 / float(readings), freedom);
    (ratio > limit && size_um.abs() > UNRESOLVED_UM).then_some(ratio)
}

/// σ of a single reading, without the disturbed ones (`None` where no pass was repeated), and the disturbed readings of
/// single runs, the largest first; pooled over all passes.
pub fn repeats(runs: &[Run]) -> (Option<Noise>, Vec<Outlier>) {
    let ways = Diagonal::ALL.into_iter().flat_map(|d| Pass::BOTH.map(|pass| (d, pass)));
    let mut passes: Vec<RepeatedPass<'_>> =
        ways.filter_map(|way| RepeatedPass::new(of(runs, way))).collect();
    let readings = passes.iter().map(|pass| pass.left.len()).sum();
    let each = passes.iter().map(|pass| (pass.runs.len() - 1) * (pass.left.ncols() - 1));
    let mut freedom: usize = each.sum();
    let square = |passes: &[RepeatedPass<'_>]| passes.iter().map(|of| of.left.norm_squared()).sum();
    let mut outliers: Vec<Outlier> = Vec::new();
    while outliers.len() < MOST_OUTLIERS {
        let all: f64 = square(&passes);
        let candidates = passes.iter_mut().filter_map(|pass| Some((pass.largest()?, pass)));
        let by_drop = candidates.max_by(|((_, a), _), ((_, b), _)| a.1.total_cmp(&b.1));
        let Some(((place, size), pass)) = by_drop else { break };
        let Some(ratio) = stands_out(size, (all, freedom), None, readings) else { break };
        outliers.push(pass.named(place, size.0, ratio));
        pass.left[place] -= size.0;
        residuals(&mut pass.left);
        freedom -= 1;
    }
    (Noise::of_scatter(square(&passes), freedom, NoiseSource::Repeats), outliers)
}

/// Readings of one pass along a diagonal that was walked more than once.
struct RepeatedPass<'a> {
    runs: Vec<&'a Run>,
    /// By run and node: readings less the mean of their node and the mean of their run, µm.
    left: DMatrix<f64>,
}

impl RepeatedPass<'_> {
    fn new(runs: Vec<&Run>) -> Option<RepeatedPass<'_>> {
        let nodes = runs.first().filter(|_| runs.len() > 1)?.deviations.len();
        let reading = |run: usize, node: usize| runs[run].deviations[node].um();
        let mut left = DMatrix::from_fn(runs.len(), nodes, reading);
        residuals(&mut left);
        Some(RepeatedPass { runs, left })
    }

    /// The reading that stands out most: its run and node; its size, and what the sum of squares loses with it.
    fn largest(&self) -> Option<((usize, usize), (f64, f64))> {
        let (runs, nodes) = self.left.shape();
        let cells = (0..runs).flat_map(|run| (0..nodes).map(move |node| (run, node)));
        let place = cells.max_by(|a, b| self.left[*a].abs().total_cmp(&self.left[*b].abs()))?;
        // What is left of a reading of size 1 in a complete table of runs and nodes.
        let share = (1.0 - 1.0 / float(runs)) * (1.0 - 1.0 / float(nodes));
        let left = self.left[place];
        (share > 0.0).then(|| (place, (left / share, left * left / share)))
    }

    /// With two runs their difference does not say which one is disturbed.
    fn named(&self, (run, node): (usize, usize), size_um: f64, ratio: f64) -> Outlier {
        let place = |of: &Run| {
            let Run { diagonal, pass, number, .. } = *of;
            ReadingPlace { diagonal, pass, run: Some(number), node }
        };
        let other = (self.runs.len() == 2).then(|| self.runs[1 - run]);
        let readings = std::iter::once(self.runs[run]).chain(other).map(place).collect();
        Outlier { readings, size_um, ratio, of_mean_um: size_um / float(self.runs.len()) }
    }
}

/// Readings less the mean of their node and the mean of their run.
fn residuals(runs: &mut DMatrix<f64>) {
    runs.column_iter_mut().for_each(|mut node| node.add_scalar_mut(-node.mean()));
    runs.row_iter_mut().for_each(|mut run| run.add_scalar_mut(-run.mean()));
}
