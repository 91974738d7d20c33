//! What is left over: the closure w, its test, and the readings that spoil it (formula 2).
//!
//! Four diagonals give four equations for three unknowns in every interval of every axis, so that
//! one combination w must be zero. A constant on an axis is set-up error or, with a flat mirror,
//! roll; a straight ramp is the roll of an axis that carries others, a doubt only beyond what `angle_urad` states; the rest is noise of the
//! readings or a disturbed reading. w is blind to pitch and yaw and to five of the eight patterns
//! of set-up error: a clean closure proves nothing.
//!
//! A reading takes part in two neighbouring increments, so the w are correlated. With C the
//! covariance of all w for readings of variance 1, and K the patterns that are no noise (the
//! constant of each axis; one for each disturbed reading; the ramps, where they are significant),
//!
//! ```text
//!   Q = min over c of (w − K c)ᵀ C⁻¹ (w − K c)        ~ σ² χ²(ν),  ν = number of w − patterns
//! ```
//! With forward passes only and nothing disturbed ν = 3n − 3. Order of the judgement: disturbed
//! readings are named with the ramps left free, so that a ramp accuses no reading; then the ramps
//! are judged with those readings left out, so that no reading makes a ramp.

use crate::inputs::job::SetUp;
use crate::machine::separation::curves::{mean, noise_gain};
use crate::machine::separation::findings::{SeparationFinding, SeparationFinding as Found};
use crate::machine::separation::linear::Model;
use crate::machine::separation::metric::{Equation, Equations, Metric};
use crate::machine::separation::noise::{
    FALSE_DOUBT, NORMAL_ONE_SIDED, Noise, NoiseSource, Outlier, UNRESOLVED_UM, chance_of, float,
    student, tails,
};
use crate::machine::separation::patterns::{Patterns, Ramps};
use crate::machine::separation::readings::pass_of;
use crate::machine::separation::uncertainty::Budget;
use crate::quantity::{Axis, Diagonal, Figure, PerAxis, Squared, Volume};
use crate::text::{Finding, joined};

/// More disturbed readings are counted in the doubts; the result lists them.
const NAMED: usize = 3;
/// Largest noise of a laser reading that needs no word, where the job states none (k = 1), µm.
const ASSUMED_NOISE_UM: f64 = 1.0;
/// A stated noise is a round figure: so many times of it count as far above.
const FAR_ABOVE: f64 = 2.0;

/// The closure of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    /// w by axis and machine interval, µm (mean of both directions where there are two).
    pub by_interval: PerAxis<Vec<f64>>,
    /// Its mean over each axis, µm: set-up error or, with a flat mirror, roll.
    pub mean: PerAxis<f64>,
    /// Expected standard deviation of one w of `by_interval` for readings of 1 µm; 2√2 with one run.
    pub scatter: PerAxis<f64>,
    /// Straight ramps of w.
    pub ramps: Option<Ramps>,
    /// Q for readings of 1 µm standard deviation, disturbed readings (and significant ramps) left out.
    pub weighted_square: f64,
    /// ν, degrees of freedom of Q.
    pub freedom: usize,
    /// Disturbed readings: those of single runs first, then those that only the closure shows.
    pub outliers: Vec<Outlier>,
}

/// The scatter of the closure against a noise that is known otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterTest {
    /// Probability of a scatter at least as far off, to either side.
    pub probability: f64,
    /// Whether the scatter is larger than the noise says, not smaller.
    pub larger: bool,
}

impl ScatterTest {
    /// Whether the closure scatters more than the noise explains.
    pub(super) fn is_larger(&self) -> bool {
        self.larger && self.probability < FALSE_DOUBT
    }
}

impl Closure {
    /// The noise of a single reading that the scatter of the closure speaks for; `None` without degrees
    /// of freedom.
    pub fn noise(&self) -> Option<Noise> {
        Noise::of_scatter(self.weighted_square, self.freedom, NoiseSource::Closure)
    }

    /// Its standard deviation, µm.
    pub fn sigma_um(&self) -> Option<f64> {
        self.noise().map(|noise| noise.sigma_um)
    }

    /// Two-sided test against a noise that is known otherwise: χ² where it is stated, F where it
    /// comes from repeated runs. `None` where it comes from this closure, so that nothing is tested.
    pub fn test(&self, noise: &Noise) -> Option<ScatterTest> {
        let is_own = matches!(noise.source, NoiseSource::Closure | NoiseSource::Joined);
        if is_own || noise.sigma_um <= 0.0 {
            return None;
        }
        let ratio = self.weighted_square / noise.sigma_um.squared();
        let (below, above) = tails(ratio, self.freedom, noise.freedom)?;
        Some(ScatterTest { probability: (2.0 * below.min(above)).min(1.0), larger: above < below })
    }

    /// Expected standard deviation of the mean over an axis for a noise, µm.
    pub fn u_mean_um(&self, axis: Axis, sigma_um: f64) -> f64 {
        sigma_um * self.scatter[axis] / float(self.by_interval[axis].len()).sqrt()
    }

    /// What it says against the nine errors.
    pub(super) fn doubts(
        &self,
        noise: Option<Noise>,
        volume: &Volume,
        setup: SetUp,
    ) -> Vec<Finding> {
        // How far a disturbed reading moves the curves: one increment too long, the next too short.
        let gain = Axis::ALL.map(|of| noise_gain(volume, of) / 2.0);
        let gain = gain.into_iter().fold(0.0, f64::max);
        let named = self.outliers.iter().take(NAMED).map(|outlier| {
            let um = gain * outlier.of_mean_um.abs();
            Found::Disturbed { um, which: outlier.words() }
        });
        let more = self.outliers.len().saturating_sub(NAMED);
        let more = (more > 0).then_some(Found::MoreDisturbed { more });
        let roll = self.ramps.as_ref().filter(|ramps| ramps.is_roll());
        let roll = roll.map(|ramps| Found::Roll { changes: ramps.change_um });
        let perfect = noise.filter(|_| setup == SetUp::AssumePerfect);
        let tilted = perfect.and_then(|noise| self.against_perfect(noise));
        named.chain(more).chain(roll).chain(tilted).map(Finding::from).collect()
    }

    /// A closure whose mean is not zero contradicts a perfect set-up.
    fn against_perfect(&self, noise: Noise) -> Option<Found> {
        let limit = student(1.0 - FALSE_DOUBT / 2.0 / 3.0, noise.freedom_f64());
        let is_off = |axis: &Axis| {
            let mean = self.mean[*axis].abs();
            mean > UNRESOLVED_UM && mean > limit * self.u_mean_um(*axis, noise.sigma_um)
        };
        let off: Vec<Axis> = Axis::ALL.into_iter().filter(is_off).collect();
        (!off.is_empty()).then_some(Found::SetUpNotPerfect { means: self.mean, off })
    }
}

/// A scatter that was found and is far above what was to be expected: one-sided, χ² = ν σ²/σ₀² at
/// one in a thousand, with σ₀ = twice the stated `noise_um`, or 1 µm where none is stated. With few
/// steps no reading stands out of such a scatter, however far it is off: it makes the scatter.
pub(super) fn large_noise(noise: Option<Noise>, stated_um: Option<f64>) -> Option<Finding> {
    let is_found = |source| matches!(source, NoiseSource::Repeats | NoiseSource::Closure);
    let found = noise.filter(|noise| is_found(noise.source))?;
    let freedom = found.freedom?;
    let limit_um = stated_um.map_or(ASSUMED_NOISE_UM, |um| FAR_ABOVE * um);
    let square = float(freedom) * (found.sigma_um / limit_um).squared();
    let doubt = match stated_um {
        Some(stated_um) => Found::NoiseFar { noise: found, times: FAR_ABOVE, stated_um },
        None => Found::NoiseLarge { noise: found, assumed_um: ASSUMED_NOISE_UM },
    };
    (chance_of(square, freedom, None)? < FALSE_DOUBT).then(|| doubt.into())
}

/// The closure of mean readings, without the first and last intervals where a missing overrun spoils them; `causes`:
/// what stated angles do to the readings. And its least-squares problem; `None` where that is singular.
pub(super) fn closure(budget: &Budget<'_>, causes: Option<&Model>) -> (Closure, Option<Patterns>) {
    let start = budget.start;
    let (z, counts) = (start.means(), start.counts());
    let w = |axis, at| budget.mean(|group| budget.closure(group, axis, at)).dot(&z);
    let by_interval: PerAxis<Vec<f64>> =
        PerAxis::from_fn(|axis| (0..budget.volume().steps).map(|at| w(axis, at)).collect());
    let mut closure = Closure {
        mean: PerAxis::from_fn(|axis| mean(by_interval[axis].iter().copied())),
        by_interval,
        scatter: PerAxis::from_fn(|axis| scatter(budget, &counts, axis)),
        ramps: None,
        weighted_square: 0.0,
        freedom: 0,
        outliers: start.outliers.clone(),
    };
    let Some(mut patterns) = Patterns::new(budget) else {
        return (closure, None);
    };
    closure.outliers.extend(patterns.name_outliers(start.noise.map(|noise| noise.sigma_um)));
    closure.ramps = patterns.ramps(start.noise, causes);
    if closure.ramps.as_ref().is_some_and(Ramps::is_no_noise) {
        patterns.leave_out_ramps();
    }
    (closure.weighted_square, closure.freedom) = patterns.scatter();
    (closure, Some(patterns))
}

/// Standard deviation of one w, mean of the groups, for readings of 1 µm.
fn scatter(budget: &Budget<'_>, counts: &[f64], axis: Axis) -> f64 {
    let groups = budget.groups();
    let walks =
        groups.iter().flat_map(|group| Diagonal::ALL.map(|d| (d, pass_of(*group, d, axis))));
    let variances = walks.map(|(d, pass)| 2.0 / counts[budget.layout().reading(pass, d, 0)]);
    variances.sum::<f64>().sqrt() / float(groups.len())
}

// Whether linear axes, beams and diagonals agree: the redundancy of formula (7).
//
// ```text
//   χ² = min over θ of (y − Mθ)ᵀ V⁻¹ (y − Mθ)       ~ χ²(ν),   ν = number of equations − rank
//   a line against all others:   stated − vᵀhv, with h solved from (7) without that line
// ```
// With the four diagonals and three linear axes ν = 1: X²p_xx + Y²p_yy + Z²p_zz against S. It is
// the only thing that notices a slope of the wrong sign or unit, or a wrong edge of the box; which
// of the equations is wrong it cannot tell. A line whose uncertainty is not known counts as exact.

/// Below this probability the equations contradict each other.
const SMALL_PROBABILITY: f64 = 0.001;
/// The first four equations are those of the diagonals.
const DIAGONALS: usize = 4;

/// One line against the diagonals and all other lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineCheck {
    /// Its direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Its slope as measured (a beam: less the shapes between its ends), µm/m.
    pub stated_um_per_m: f64,
    /// What everything else says of it; `None` where nothing else does.
    pub others: Option<Others>,
}

/// What everything else says of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Others {
    /// Its slope, µm/m.
    pub found_um_per_m: f64,
    /// Standard uncertainty (k = 1) of stated − found, µm/m.
    pub u_difference_um_per_m: f64,
}

impl LineCheck {
    /// Stated − found, µm/m, and the same in standard deviations.
    pub fn difference(&self) -> Option<(f64, f64)> {
        let others = self.others?;
        let difference = self.stated_um_per_m - others.found_um_per_m;
        Some((difference, difference / others.u_difference_um_per_m))
    }

    /// `X` for a linear axis, else `beam` and its direction.
    pub fn name(&self) -> String {
        let along = |axis: &Axis| (self.direction[*axis].abs() - 1.0).abs() < 1e-9;
        match Axis::ALL.iter().find(|axis| along(axis)) {
            Some(axis) => axis.to_string(),
            None => {
                let PerAxis { x, y, z } = self.direction;
                format!("beam ({x:.2}, {y:.2}, {z:.2})")
            }
        }
    }
}

/// The test of what is redundant.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Weighed residuals.
    pub chi_squared: f64,
    /// ν, number of redundant equations, at least 1.
    pub freedom: usize,
    /// Probability of residuals at least as large; `None` where the noise of the readings is not known.
    pub probability: Option<f64>,
    /// The lines, in the order of the job.
    pub lines: Vec<LineCheck>,
    /// Whether a line's uncertainty is not known: it counts as exact in this test.
    pub taken_as_exact: bool,
    /// By how much each equation may be false if it alone is: the diagonals, then the lines, µm/m.
    pub(super) false_by_um_per_m: Vec<f64>,
}

impl Agreement {
    /// Whether the equations contradict each other.
    pub fn is_refuted(&self) -> bool {
        self.probability.is_some_and(|p| p < SMALL_PROBABILITY)
    }

    /// The contradiction; `None` where there is none.
    pub(crate) fn contradiction(&self) -> Option<SeparationFinding> {
        let says = |line: &LineCheck| {
            let (um_per_m, ratio) = line.difference()?;
            let (name, um_per_m, ratio) = (line.name(), Figure(um_per_m), ratio.abs());
            Some(format!("{name} by {um_per_m:+.3} µm/m ({ratio:.1} standard deviations)"))
        };
        self.is_refuted().then(|| SeparationFinding::LinesDisagree {
            lines: joined(self.lines.iter().filter_map(says)),
            taken_as_exact: self.taken_as_exact,
        })
    }
}

impl Equations {
    /// Tests the redundancy; `None` where there is none, or no line beside the four diagonals (of a thin box they
    /// determine less).
    pub(super) fn agreement(&self, found: &Metric) -> Option<Agreement> {
        let freedom = self.redundancy();
        if freedom == 0 || self.all.len() <= Diagonal::ALL.len() {
            return None;
        }
        let largest = found.largest_um_per_m();
        let variances = self.test_variances(largest);
        let chi_squared = self.solved_with(|one| one.direction, &variances)?.chi_squared;
        let check = |(index, one): (usize, &Equation)| {
            let rest = self.without(index);
            let solved = || rest.solved_with(|one| one.direction, &rest.test_variances(largest));
            let found = rest.holds(&one.direction).then(solved).flatten();
            let others = found.map(|solution| {
                let (found_um_per_m, variance) = solution.along(&one.direction);
                let u_difference_um_per_m = (variances[index] + variance).sqrt();
                Others { found_um_per_m, u_difference_um_per_m }
            });
            LineCheck { direction: one.direction, stated_um_per_m: one.value, others }
        };
        let mut lines: Vec<LineCheck> = self.all.iter().enumerate().map(check).collect();
        let false_by = |line: &LineCheck| {
            let by = line.difference().zip(line.others).map_or(0.0, |((by, _), others)| {
                by.abs() - NORMAL_ONE_SIDED * others.u_difference_um_per_m
            });
            by.max(0.0)
        };
        let false_by_um_per_m = lines.iter().map(false_by).collect();
        let known = self.all[..DIAGONALS].iter().all(|one| one.known);
        Some(Agreement {
            chi_squared,
            freedom,
            probability: chance_of(chi_squared, freedom, None).filter(|_| known),
            lines: lines.split_off(DIAGONALS),
            taken_as_exact: self.all[DIAGONALS..].iter().any(|line| !line.known),
            false_by_um_per_m,
        })
    }
}
