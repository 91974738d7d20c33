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

use super::curves::{mean, noise_gain};
use super::readings::{
    DIGIT_UM, FALSE_DOUBT, MOST_OUTLIERS, NORMAL_ONE_SIDED, Noise, NoiseSource, Outlier,
    ReadingPlace, UNRESOLVED_UM, chance_of, float, stands_out, student, tails,
};
use super::start::Start;
use crate::machine::findings::SeparationFinding as Found;
use crate::quantity::{Axis, PerAxis, Squared, Volume};
use crate::text::Finding;
use nalgebra::{DVector, Matrix3, Vector3};
use nonius_numerics::banded::Banded;
use nonius_numerics::rows::{Layout, Model, Row};
use serde::Serialize;

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
    /// Expected standard deviation of the w of the middle interval for readings of 1 µm; 2√2 with one run.
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

    /// What it says against the nine errors; `perfect`: the noise, where the set-up is assumed perfect.
    pub(super) fn doubts(&self, volume: &Volume, perfect: Option<Noise>) -> Vec<Finding> {
        // How far a disturbed reading moves the curves: one increment too long, the next too short.
        let gain = Axis::ALL.map(|of| noise_gain(volume, of) / 2.0).into_iter().fold(0.0, f64::max);
        let named = self.outliers.iter().take(NAMED).map(|outlier| Found::Disturbed {
            um: gain * outlier.of_mean_um.abs(),
            which: outlier.words(),
        });
        let more = self.outliers.len().saturating_sub(NAMED);
        let more = (more > 0).then_some(Found::MoreDisturbed { more });
        let roll = self.ramps.as_ref().filter(|ramps| ramps.roll);
        let roll = roll.map(|ramps| Found::Roll { changes: ramps.change_um });
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

/// The closure of mean readings, without the first and last intervals where a missing overrun spoils them. And its
/// least-squares problem; `None` where that is singular.
pub(super) fn closure(start: &Start<'_>) -> (Closure, Option<Patterns>) {
    let steps = start.volume().steps;
    let w = |axis, at| start.mean(|group| start.closure(group, axis, at));
    let by_interval: PerAxis<Vec<f64>> =
        PerAxis::from_fn(|axis| (0..steps).map(|at| w(axis, at).dot(&start.z)).collect());
    let variance = |(place, weight): &(usize, f64)| weight.squared() / start.counts[*place];
    let scatter = |axis| w(axis, steps / 2).merged().0.iter().map(variance).sum::<f64>().sqrt();
    let mut closure = Closure {
        mean: PerAxis::from_fn(|axis| mean(by_interval[axis].iter().copied())),
        by_interval,
        scatter: PerAxis::from_fn(scatter),
        ramps: None,
        weighted_square: 0.0,
        freedom: 0,
        outliers: start.outliers.clone(),
    };
    let Some(mut patterns) = Patterns::new(start) else {
        return (closure, None);
    };
    closure.outliers.extend(patterns.name_outliers(start.known.map(|noise| noise.sigma_um)));
    closure.ramps = patterns.ramps(start.known, &start.model);
    if closure.ramps.as_ref().is_some_and(Ramps::is_no_noise) {
        patterns.leave_out(patterns.ramps.clone());
    }
    (closure.weighted_square, closure.freedom) = patterns.scatter();
    (closure, Some(patterns))
}

// All w in one least-squares problem, and the patterns in them that are no noise: w = K z, with rows as in `linear`; what
// anything does to the readings is a column c, and K c the pattern that it makes of w. Patterns are kept as an orthonormal
// basis in the metric of C⁻¹, C = K diag(1/runs) Kᵀ, so that P x = C⁻¹x − Σ b (bᵀx) is what is left of x, weighed, and
// leaving out one more is one step. C has entries near its diagonal only.

/// The least-squares problem of all w.
pub(super) struct Patterns {
    layout: Layout,
    /// K.
    rows: Vec<Row>,
    w: DVector<f64>,
    factor: Banded,
    /// The straight ramp of each axis.
    ramps: [DVector<f64>; 3],
    /// For each reading, the w that it takes part in and how.
    effects: Vec<Vec<(usize, f64)>>,
    /// What is left out so far.
    basis: Vec<DVector<f64>>,
    /// How much of it is the constants of the axes.
    constants: usize,
    /// P w.
    left: DVector<f64>,
}

/// Straight ramps of w over each axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ramps {
    /// From the first interval to the last, µm.
    pub change_um: PerAxis<f64>,
    /// Their standard deviations for readings of 1 µm.
    #[serde(skip)]
    pub u: PerAxis<f64>,
    /// Probability of ramps at least as large by noise alone.
    #[serde(skip)]
    by_noise: f64,
    /// The same by noise and the stated angles.
    pub probability: f64,
    /// Whether they speak of the roll of an axis that carries others, beyond what is stated of it.
    pub roll: bool,
    /// How far they are beyond what noise and these angles make, µm.
    #[serde(skip)]
    pub(super) beyond_um: PerAxis<f64>,
}

impl Ramps {
    /// Whether they are no noise of the readings, so that they do not belong in its test.
    pub(super) fn is_no_noise(&self) -> bool {
        let sizes = self.change_um.iter().map(|(_, um)| um.abs());
        self.by_noise < FALSE_DOUBT && sizes.fold(0.0, f64::max) > UNRESOLVED_UM
    }
}

/// Shares below this are rounding: such a pattern is left out already.
const NOTHING: f64 = 1e-9;

impl Patterns {
    /// With nothing left out but the constants of the axes and the disturbed readings of single runs; `None` where C
    /// is singular.
    pub(super) fn new(start: &Start<'_>) -> Option<Patterns> {
        let (layout, last) = (start.model.layout, start.volume().steps - 1);
        // What the first and last intervals close to is spoilt by a missing overrun.
        let skips_ends = start.both_ways() && start.overrun != Some(true);
        // Those that share readings stand close to each other: diagonals that travel an axis in − cross its intervals
        // from the other end.
        let is_end = |at: &usize| *at == 0 || *at == last;
        let mut intervals: Vec<usize> =
            (0..=last).filter(|at| !(skips_ends && is_end(at))).collect();
        intervals.sort_by_key(|at| (*at.min(&(last - at)), *at));
        let of_group = |at: usize| start.groups().iter().map(move |group| (at, *group));
        let places = intervals.into_iter().flat_map(of_group);
        let places = places.flat_map(|(at, group)| Axis::ALL.map(|axis| (group, axis, at)));
        let places: Vec<_> = places.collect();
        let rows = places.iter().map(|(group, axis, at)| start.closure(*group, *axis, *at));
        let rows: Vec<Row> = rows.collect();
        let mut effects = vec![Vec::new(); layout.entries()];
        for (index, row) in rows.iter().enumerate() {
            row.0.iter().for_each(|(place, weight)| effects[*place].push((index, *weight)));
        }
        let ends = effects.iter().filter_map(|effect| effect.first().zip(effect.last()));
        let reach = ends.map(|((first, _), (last, _))| last - first).max().unwrap_or(0);
        let products = effects.iter().zip(&start.counts).flat_map(|(effect, count)| {
            let row = effect.iter().flat_map(|one| effect.iter().map(move |other| (*one, *other)));
            row.map(move |((row, a), (column, b))| (row, column, a * b * (1.0 / count)))
        });
        let factor = Banded::factor((rows.len(), reach), products)?;
        let over = |of: &dyn Fn(f64) -> f64| {
            Axis::ALL.map(|wanted| {
                let here =
                    |(_, axis, at): &(_, _, usize)| f64::from(*axis == wanted) * of(float(*at));
                DVector::from_iterator(rows.len(), places.iter().map(here))
            })
        };
        let middle = float(last) / 2.0;
        let ramps = over(&|at| (at - middle) / (2.0 * middle).max(1.0));
        let constants = over(&|_| 1.0);
        let w = of_column(&rows, &start.z);
        let (basis, left) = (Vec::new(), DVector::from_vec(factor.solve(w.as_slice())));
        let mut patterns =
            Patterns { layout, rows, w, factor, ramps, effects, basis, constants: 0, left };
        patterns.leave_out(constants);
        patterns.constants = patterns.basis.len();
        patterns.leave_out_readings(start.outliers.iter().flat_map(|outlier| &outlier.readings));
        Some(patterns)
    }

    /// P x.
    fn projected(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut left = DVector::from_vec(self.factor.solve(x.as_slice()));
        self.basis.iter().for_each(|base| left.axpy(-base.dot(x), base, 1.0));
        left
    }

    /// Leaves out no more than so many patterns.
    fn keep(&mut self, count: usize) {
        self.basis.truncate(count);
        self.left = self.projected(&self.w);
    }

    fn leave_out(&mut self, patterns: impl IntoIterator<Item = DVector<f64>>) {
        for pattern in patterns {
            let mut base = self.projected(&pattern);
            let weight = pattern.dot(&base);
            if weight > NOTHING * pattern.norm_squared() {
                base /= weight.sqrt();
                self.left.axpy(-base.dot(&self.w), &base, 1.0);
                self.basis.push(base);
            }
        }
    }

    /// Leaves the effects of disturbed readings out, whichever runs they are of.
    fn leave_out_readings<'a>(&mut self, of: impl Iterator<Item = &'a ReadingPlace>) {
        let place = |of: &ReadingPlace| self.layout.reading(of.pass, of.diagonal, of.node);
        let patterns: Vec<_> = of.map(|of| self.pattern(place(of))).collect();
        self.leave_out(patterns);
    }

    /// Nothing but the constants, these disturbed readings and what stated angles do is left out from now on.
    pub(super) fn restart(&mut self, outliers: &[Outlier], model: &Model) {
        self.keep(self.constants);
        self.leave_out_readings(outliers.iter().flat_map(|outlier| &outlier.readings));
        let pattern = |cause: &usize| of_column(&self.rows, &model.causes[*cause].column);
        let angles: Vec<_> = model.angles.iter().flatten().map(pattern).collect();
        self.leave_out(angles);
    }

    /// Q and ν.
    pub(super) fn scatter(&self) -> (f64, usize) {
        let freedom = self.w.len().saturating_sub(self.basis.len());
        (self.w.dot(&self.left).max(0.0), freedom)
    }

    /// Q of other readings.
    pub(super) fn square_of(&self, means: &[f64]) -> f64 {
        let w = of_column(&self.rows, means);
        w.dot(&self.projected(&w)).max(0.0)
    }

    /// The ramps beside what is left out, and how likely noise and the stated angles make them: by the order of
    /// the axes that explains them best. `None` where too little is left to tell them or to judge them by.
    pub(super) fn ramps(&self, noise: Option<Noise>, model: &Model) -> Option<Ramps> {
        let weighed = self.ramps.each_ref().map(|ramp| self.projected(ramp));
        let normal = Matrix3::from_fn(|i, j| self.ramps[i].dot(&weighed[j]));
        let inverse = normal.cholesky()?.inverse();
        let of = |w: &DVector<f64>| inverse * Vector3::from_fn(|i, _| weighed[i].dot(w));
        let shares = of(&self.w);
        let (square, freedom) = self.scatter();
        let rest = freedom.checked_sub(3).filter(|rest| *rest > 0)?;
        let drop = (normal * shares).dot(&shares);
        let (variance, freedom) = match noise {
            Some(noise) => (noise.sigma_um.max(DIGIT_UM).squared(), noise.freedom),
            None => ((square - drop).max(0.0) / float(rest), Some(rest)),
        };
        let chance = |angles: &[usize]| {
            let of_angle = |at: &usize| of(&of_column(&self.rows, &model.causes[*at].column));
            let spread = angles.iter().map(of_angle).map(|c| c * c.transpose());
            let spread = spread.fold(inverse * variance, |sum, one| sum + one);
            let ratio =
                spread.cholesky().map_or(f64::INFINITY, |of| of.solve(&shares).dot(&shares));
            Some((chance_of(ratio, 3, freedom)?, spread))
        };
        let by_noise = chance(&[])?;
        let orders = model.angles.iter().filter_map(|angles| chance(angles));
        let (probability, spread) =
            orders.fold(by_noise, |best, one| if one.0 > best.0 { one } else { best });
        let by_axis = |of: &dyn Fn(usize) -> f64| PerAxis::from_fn(|axis| of(axis as usize));
        let beyond = |i: usize| shares[i].abs() - NORMAL_ONE_SIDED * spread[(i, i)].sqrt();
        let mut ramps = Ramps {
            roll: false,
            change_um: by_axis(&|i| shares[i]),
            u: by_axis(&|i| inverse[(i, i)].sqrt()),
            by_noise: by_noise.0,
            probability,
            beyond_um: by_axis(&|i| beyond(i).max(0.0)),
        };
        ramps.roll = ramps.is_no_noise() && probability < FALSE_DOUBT;
        Some(ramps)
    }

    /// Names disturbed readings one by one, the largest first, until none stands out, with the ramps left free; leaves
    /// these readings out, and nothing else.
    pub(super) fn name_outliers(&mut self, known_sigma_um: Option<f64>) -> Vec<Outlier> {
        let before = self.basis.len();
        self.leave_out(self.ramps.clone());
        let next = || {
            let found = self.largest(known_sigma_um)?;
            self.leave_out_readings(found.readings.iter().take(1));
            Some(found)
        };
        let found: Vec<Outlier> = std::iter::from_fn(next).take(MOST_OUTLIERS).collect();
        self.keep(before);
        self.leave_out_readings(found.iter().filter_map(|outlier| outlier.readings.first()));
        found
    }

    fn largest(&self, known_sigma_um: Option<f64>) -> Option<Outlier> {
        let share = |effect: &[(usize, f64)]| -> f64 {
            effect.iter().map(|(row, part)| part * self.left[*row]).sum()
        };
        let shares = self.effects.iter().map(|effect| share(effect).abs()).enumerate();
        // Of equal ones the first.
        let (index, _) = shares.rev().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let pattern = self.pattern(index);
        let weight = pattern.dot(&self.projected(&pattern));
        if weight <= NOTHING * pattern.norm_squared() {
            return None;
        }
        let size_um = pattern.dot(&self.left) / weight;
        let many = self.effects.iter().filter(|effect| !effect.is_empty()).count();
        let size = (size_um, size_um * size_um * weight);
        let ratio = stands_out(size, self.scatter(), known_sigma_um, many)?;
        Some(Outlier { readings: self.twins(index), size_um, ratio, of_mean_um: size_um })
    }

    fn pattern(&self, reading: usize) -> DVector<f64> {
        let mut pattern = DVector::zeros(self.w.len());
        self.effects[reading].iter().for_each(|(row, part)| pattern[*row] += part);
        pattern
    }

    /// A reading, then all whose effect on w is the same but for its sign.
    fn twins(&self, index: usize) -> Vec<ReadingPlace> {
        let shape = |reading: usize| {
            let effect = &self.effects[reading];
            let sign = effect.first().map_or(1.0, |(_, part)| part.signum());
            effect.iter().map(|(row, part)| (*row, sign * part)).collect::<Vec<_>>()
        };
        let wanted = shape(index);
        let others = (0..self.effects.len()).filter(|other| *other != index);
        let twins = others.filter(|other| shape(*other) == wanted);
        let place = |reading| {
            let (pass, diagonal, node) = self.layout.place(reading);
            ReadingPlace { diagonal, pass, run: None, node }
        };
        std::iter::once(index).chain(twins).map(place).collect()
    }
}

/// What a column of the readings makes of w.
fn of_column(rows: &[Row], column: &[f64]) -> DVector<f64> {
    DVector::from_iterator(rows.len(), rows.iter().map(|row| row.dot(column)))
}
