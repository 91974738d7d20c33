//! The linear model of a measurement: every figure is a row over what was measured, every cause a column.
//!
//! ```text
//!   z      = (mean readings of each pass, linear axes and beams, what (7) neglects of each equation,
//!             what tells the reversal beside the readings)
//!   figure = row · z
//!   cov(z) = diag(σ²/runs, u² of the lines, neglected²) + Σ u² c cᵀ     c: column, what a unit of a cause does to z
//!   u²     = row · cov(z) · rowᵀ
//! ```
//! The increments of the nine curves (1), the closure (2) and the totals of the diagonals (3) are such rows.
//! Rows are of first order: of the tilt of the mirror times noise nothing is kept.
//! Rows of neighbouring points of a curve differ by the increments of one interval: a curve is a running sum.

use crate::draws::{LANES, Lanes, add};
use crate::quantity::{Diagonal, Pass, Rotation, Squared};
use chacha20::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use std::borrow::Borrow;
use std::ops::Range;
use std::sync::Arc;

/// Parts of a variance below this share of it are rounding.
const ROUNDING: f64 = 1e-12;

/// Where the entries of z stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Readings of a pass along a diagonal.
    pub nodes: usize,
    /// Passes along each diagonal: 1 or 2.
    pub passes: usize,
    /// Linear axes and beams.
    pub lines: usize,
    /// Entries of the reversal.
    pub apart: usize,
}

impl Layout {
    /// Place of a mean reading.
    pub fn reading(self, pass: Pass, diagonal: Diagonal, node: usize) -> usize {
        let line = usize::from(pass == Pass::Reverse) * 4 + diagonal as usize;
        line * self.nodes + node
    }

    /// Which mean reading stands at a place.
    pub fn place(self, index: usize) -> (Pass, Diagonal, usize) {
        let line = index / self.nodes;
        (Pass::BOTH[line / 4], Diagonal::ALL[line % 4], index % self.nodes)
    }

    /// Place of a linear axis or beam.
    pub fn line(self, index: usize) -> usize {
        self.passes * 4 * self.nodes + index
    }

    /// Place of what an equation of (7) neglects; the diagonals come first, then the lines.
    pub fn neglected(self, equation: usize) -> usize {
        self.line(self.lines) + equation
    }

    /// A column by what a cause does to a reading at a node, the same in both passes.
    pub fn column(self, of: impl Fn(Diagonal, usize) -> f64) -> Vec<f64> {
        let walks = Diagonal::ALL.repeat(self.passes).into_iter();
        let nodes = walks.flat_map(|d| (0..self.nodes).map(move |node| (d, node)));
        let mut column: Vec<f64> = nodes.map(|(d, node)| of(d, node)).collect();
        column.resize(self.entries(), 0.0);
        column
    }

    /// How many entries there are.
    pub fn entries(self) -> usize {
        self.neglected(4 + self.lines) + self.apart
    }
}

/// A figure by the entries of z that it hangs on; an entry may stand in it more than once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row(pub Vec<(usize, f64)>);

impl Row {
    /// One entry.
    pub fn of(place: usize) -> Row {
        Row(vec![(place, 1.0)])
    }

    /// Adds another figure so many times.
    pub fn add(&mut self, times: f64, other: impl Borrow<Row>) {
        if times != 0.0 {
            self.0.extend(other.borrow().0.iter().map(|(place, weight)| (*place, times * weight)));
        }
    }

    /// The sum of figures, each so many times.
    pub fn sum<R: Borrow<Row>>(of: impl IntoIterator<Item = (f64, R)>) -> Row {
        let mut sum = Row::default();
        of.into_iter().for_each(|(times, row)| sum.add(times, row));
        sum
    }

    /// The same with each entry once.
    pub fn merged(&self) -> Row {
        let mut entries = self.0.clone();
        entries.sort_by_key(|(place, _)| *place);
        let same = entries.chunk_by(|one, next| one.0 == next.0);
        let merged = same.map(|same| (same[0].0, same.iter().map(|(_, weight)| weight).sum()));
        Row(merged.filter(|(_, weight): &(usize, f64)| weight.abs() > 1e-12).collect())
    }

    /// The figure of these entries.
    pub fn dot(&self, z: &[f64]) -> f64 {
        self.0.iter().fold(0.0, |sum, (place, weight)| sum + weight * z[*place])
    }

    /// The same of entries in some draws.
    pub(crate) fn dots<const N: usize>(&self, z: &[[f64; N]]) -> [f64; N] {
        let mut sum = [0.0; N];
        self.0.iter().for_each(|(place, weight)| add(&mut sum, *weight, &z[*place]));
        sum
    }
}

/// What acts on many entries of z at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// What it is.
    pub part: Part,
    /// What one unit of it does to z.
    pub column: Vec<f64>,
    /// Of its size, in these units.
    pub variance: f64,
    /// The part of the beam beside it, in the scale of a set-up.
    pub of_beam: f64,
}

impl Cause {
    fn size(&self) -> f64 {
        self.variance + self.of_beam
    }
}

/// What is uncertain of z.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Where the entries stand.
    pub layout: Layout,
    /// Degrees of freedom of the noise, infinite where it is stated; `None` = the noise is not known.
    pub freedom: Option<f64>,
    /// Variance of each entry by itself: of a reading by its noise.
    pub own: Vec<f64>,
    /// The part of a set-up in that of each line.
    pub of_setup: f64,
    /// Unmeasured angles come last.
    pub causes: Vec<Cause>,
    /// Which of the causes is the scale of the laser.
    pub laser: Option<usize>,
    /// Which are unmeasured angles with a stated bound, for each order of the axes that may be; the worst counts.
    pub angles: Vec<Vec<usize>>,
}

/// A cause of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Of the readings.
    Noise,
    /// Scale of the laser, temperature and expansion, alike in all set-ups.
    Laser,
    /// Its tilt, where the set-up is assumed perfect.
    Mirror,
    /// Change of scale from one set-up to the next.
    SetUps,
    /// Between the beam and the mirror's normal.
    Beam,
    /// A linear axis or another beam, by its place among the lines.
    Line(usize),
    /// Without a measurement.
    Angle(Rotation),
    /// As an error table states it.
    Stated,
}

/// Share of a normal distribution within two standard deviations: what U stands for.
const COVERAGE: f64 = 0.954_499_736_103_642;
/// From here on Student's distribution is the normal one in every digit that is printed.
const MANY: f64 = 1e6;

/// k with which U = k·u holds the true value in 95.45 % of all cases: 2 for a known standard
/// deviation, more by Student where it was estimated from few (GUM, annex G).
pub fn coverage_factor(freedom: Option<f64>) -> f64 {
    let few = freedom.filter(|freedom| *freedom < MANY);
    few.map_or(2.0, |_| student(0.5 + COVERAGE / 2.0, few))
}

/// Quantile of Student's distribution; of the normal one where the freedom is not limited.
pub fn student(share: f64, freedom: Option<f64>) -> f64 {
    match freedom.filter(|freedom| *freedom < MANY) {
        Some(freedom) => StudentsT::new(0.0, 1.0, freedom.max(1.0)).map(|of| of.inverse_cdf(share)),
        None => Ok(Normal::standard().inverse_cdf(share)),
    }
    .unwrap_or(f64::INFINITY)
}

/// How well a figure is known, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Standard uncertainty (k = 1).
    pub u: f64,
    /// Its effective degrees of freedom; `None` = unlimited.
    pub freedom: Option<f64>,
}

impl Uncertainty {
    /// U: with the coverage factor of its degrees of freedom.
    pub fn expanded(&self) -> f64 {
        self.u * coverage_factor(self.freedom)
    }
}

/// What each entry of z, then a unit of each cause makes of a figure.
pub struct Weights(Vec<f64>, Vec<f64>);

/// u² of a figure.
#[derive(Clone, Copy, Debug, Default)]
pub struct Variance {
    /// By the noise of the readings.
    pub noise: f64,
    /// By everything that counts.
    pub all: f64,
}

impl Model {
    /// A variance as standard uncertainty with its degrees of freedom; `None` = the noise is not known.
    ///
    /// source Welch and Satterthwaite, GUM G.4.1
    pub fn uncertainty(&self, Variance { noise, all }: Variance) -> Option<Uncertainty> {
        let share = if all > 0.0 { noise / all } else { 0.0 };
        let freedom = self.freedom? / share.squared();
        Some(Uncertainty { u: all.sqrt(), freedom: Some(freedom).filter(|many| *many < MANY) })
    }

    /// One more entry of z, with this standard uncertainty: its place.
    pub fn add(&mut self, u: f64) -> usize {
        self.own.push(u.squared());
        self.causes.iter_mut().for_each(|cause| cause.column.push(0.0));
        self.layout.apart += 1;
        self.own.len() - 1
    }

    /// Standard deviations of the readings and lines, whose causes are left out.
    pub fn drawn(&self) -> Vec<f64> {
        self.own[..self.layout.neglected(0)].iter().map(|own| own.sqrt()).collect()
    }

    /// One draw by each generator, without angles: what is off in z by itself, the noise so many times as large as
    /// estimated; how many times each column acts.
    pub fn draw(
        &self,
        noise: Lanes,
        random: &mut [ChaCha8Rng; LANES],
    ) -> (Vec<Lanes>, Vec<(usize, Lanes)>) {
        let (readings, spread) = (self.layout.line(0), self.own.iter().map(|own| own.sqrt()));
        let spread: Vec<f64> = spread.collect();
        let mut z = vec![[0.0; LANES]; spread.len()];
        let mut shares: Vec<_> = self.everywhere().map(|_| [0.0; LANES]).enumerate().collect();
        for (lane, random) in random.iter_mut().enumerate() {
            let mut normal = |u: f64| -> f64 {
                let draw: f64 = StandardNormal.sample(random);
                u * draw
            };
            for (at, (z, u)) in z.iter_mut().zip(&spread).enumerate().filter(|of| *of.1.1 > 0.0) {
                z[lane] = normal(*u) * if at < readings { noise[lane] } else { 1.0 };
            }
            for ((_, times), cause) in shares.iter_mut().zip(self.everywhere()) {
                times[lane] = normal(cause.size().sqrt());
            }
        }
        (z, shares)
    }

    /// The causes that act whatever the order of the axes is.
    fn everywhere(&self) -> impl Iterator<Item = &Cause> {
        self.causes.iter().take_while(|cause| !matches!(cause.part, Part::Angle(_)))
    }

    /// Standard uncertainty of the difference of two readings, without angles.
    pub fn u_of_difference(&self, one: usize, other: usize) -> f64 {
        let effects: Vec<f64> =
            self.causes.iter().map(|of| of.column[one] - of.column[other]).collect();
        (self.own[one] + self.own[other] + self.by_causes(&effects, &effects, |_| true)).sqrt()
    }

    /// What each entry of z and a unit of each cause make of a figure.
    pub fn weights(&self, row: &Row) -> Weights {
        let mut dense = vec![0.0; self.layout.entries()];
        row.0.iter().for_each(|(place, weight)| dense[*place] += weight);
        let entries = dense.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0);
        let row = Row(entries.collect());
        Weights(dense, self.causes.iter().map(|cause| row.dot(&cause.column)).collect())
    }

    /// cov of two figures by some of the causes, without angles.
    fn by_causes(&self, one: &[f64], other: &[f64], of: impl Fn(&Cause) -> bool) -> f64 {
        let each = self.everywhere().zip(one.iter().zip(other)).filter(|(cause, _)| of(cause));
        each.map(|(cause, (one, other))| cause.size() * one * other).sum()
    }

    /// cov of two figures without unmeasured angles, and the part of the causes common to all set-ups in it.
    pub fn covariance(&self, one: &Weights, other: &Weights) -> (f64, f64) {
        let own: f64 = self.by_entries(&one.0, &other.0).iter().sum();
        let [all, common]: [fn(&Cause) -> bool; 2] =
            [|_| true, |cause| matches!(cause.part, Part::Laser | Part::Beam)];
        let [all, common] = [all, common].map(|of| self.by_causes(&one.1, &other.1, of));
        (own + all, common)
    }

    /// u² of a figure.
    pub fn variance(&self, row: &Row) -> Variance {
        let Weights(row, effects) = self.weights(row);
        self.combined(self.by_entries(&row, &row), &effects)
    }

    /// cov of two figures by noise, and by lines and what is neglected.
    fn by_entries(&self, one: &[f64], other: &[f64]) -> [f64; 2] {
        let weighed = |of: Range<usize>| of.map(|at| one[at] * other[at] * self.own[at]).sum();
        let readings = self.layout.line(0);
        [weighed(0..readings), weighed(readings..self.own.len())]
    }

    /// What the variance of a figure is made of: by how much it is less without each cause.
    pub fn parts(&self, row: &Row) -> Vec<(Part, f64)> {
        let causes = [Part::Noise, Part::Laser, Part::Mirror, Part::SetUps, Part::Beam];
        let angles = Rotation::all().map(Part::Angle);
        let angles = angles.filter(|angle| self.causes.iter().any(|cause| cause.part == *angle));
        let lines = (0..self.layout.lines).map(Part::Line);
        let all = self.variance(row).all;
        let of = |cause: Part| (cause, all - self.without(cause).variance(row).all);
        causes.into_iter().chain(lines).chain(angles).map(of).collect()
    }

    /// The same with one cause less.
    fn without(&self, part: Part) -> Model {
        let mut model = self.clone();
        for cause in &mut model.causes {
            cause.variance = if cause.part == part { 0.0 } else { cause.variance };
            cause.of_beam = if part == Part::Beam { 0.0 } else { cause.of_beam };
        }
        let lines = self.layout.line(0)..self.layout.neglected(0);
        match part {
            Part::Noise => model.own[..lines.start].fill(0.0),
            Part::SetUps => model.own[lines].iter_mut().for_each(|v| *v -= self.of_setup),
            Part::Line(index) => model.own[lines.start + index] = self.of_setup,
            _ => {}
        }
        model
    }

    fn combined(&self, [noise, other]: [f64; 2], effects: &[f64]) -> Variance {
        let of_angle = |at: &usize| self.causes[*at].variance * effects[*at].squared();
        let of_order = |acting: &Vec<usize>| acting.iter().map(of_angle).sum();
        let by_angles = self.angles.iter().map(of_order).fold(0.0, f64::max);
        let causes = self.by_causes(effects, effects, |_| true);
        Variance { noise, all: noise + other + causes + by_angles }
    }
}

/// A curve: at interval end i of n its value is start + steps 1 … i + (i/n) line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveRows {
    /// At the low end.
    pub start: Row,
    /// Over each interval.
    pub steps: Arc<[Row]>,
    /// Straight line from 0 at the low end to this at the high one.
    pub line: Row,
    /// The line at the high end as measured, µm: it need not be linear in z.
    pub line_um: f64,
}

impl CurveRows {
    /// The same with so many times another curve beside it, from its low end on.
    pub fn beside(&self, times: f64, other: &CurveRows) -> CurveRows {
        let sum = |own: &Row, other: &Row| Row::sum([(1.0, own), (times, other)]).merged();
        let steps = self.steps.iter().zip(other.steps.iter());
        let steps = steps.map(|(own, other)| sum(own, other)).collect();
        let (line, line_um) = (sum(&self.line, &other.line), self.line_um + times * other.line_um);
        CurveRows { start: self.start.clone(), steps, line, line_um }
    }

    /// The same with each entry of a row once.
    pub fn merged(&self) -> CurveRows {
        let steps = self.steps.iter().map(Row::merged).collect();
        let (start, line) = (self.start.merged(), self.line.merged());
        CurveRows { start, steps, line, line_um: self.line_um }
    }

    /// What the value at a place hangs on, in steps from the low end.
    pub fn at(&self, place: f64) -> Row {
        let mut row = self.start.clone();
        let mut left = place;
        for step in self.steps.iter() {
            row.add(left.clamp(0.0, 1.0), step);
            left -= 1.0;
        }
        row.add(place / self.steps.len().max(1) as f64, &self.line);
        row
    }

    /// The values for these entries; `line_um`: the line at the high end.
    pub fn values(&self, z: &[f64], line_um: f64) -> Vec<f64> {
        let mut values = vec![[0.0]; self.steps.len() + 1];
        self.fill(z.as_chunks().0, [line_um], &mut values);
        values.into_flattened()
    }

    /// The same of entries in some draws, into a list of as many values.
    pub(crate) fn fill<const N: usize>(
        &self,
        z: &[[f64; N]],
        line_um: [f64; N],
        values: &mut [[f64; N]],
    ) {
        let last = self.steps.len().max(1) as f64;
        let mut sum = self.start.dots(z);
        values[0] = sum;
        for (index, step) in self.steps.iter().enumerate() {
            add(&mut sum, 1.0, &step.dots(z));
            values[index + 1] = sum;
            add(&mut values[index + 1], (index + 1) as f64 / last, &line_um);
        }
    }

    /// u² of each value.
    pub fn variances(&self, model: &Model) -> Vec<Variance> {
        let Weights(line, line_effects) = model.weights(&self.line);
        let of_line = model.by_entries(&line, &line);
        // By entries: of the sum of the steps, and of it with the line.
        let Weights(mut sum, mut sum_effects) = model.weights(&self.start);
        let mut of_sum = model.by_entries(&sum, &sum);
        let mut with_line = model.by_entries(&sum, &line);
        let mut effects = sum_effects.clone();
        let (last, readings) = (self.steps.len().max(1) as f64, model.layout.line(0));
        (0..=self.steps.len())
            .map(|index| {
                let step = index.checked_sub(1).map(|step| &self.steps[step]);
                for (place, weight) in step.iter().flat_map(|step| &step.0) {
                    let (i, v) = (usize::from(*place >= readings), model.own[*place]);
                    of_sum[i] += v * weight * (2.0 * sum[*place] + weight);
                    with_line[i] += v * weight * line[*place];
                    sum[*place] += weight;
                    let causes = sum_effects.iter_mut().zip(&model.causes);
                    causes.for_each(|(sum, cause)| *sum += weight * cause.column[*place]);
                }
                let share = index as f64 / last;
                let by_entries = [0, 1].map(|i| {
                    let (mixed, line) = (2.0 * share * with_line[i], share * share * of_line[i]);
                    let all = of_sum[i] + mixed + line;
                    // What is left of parts that cancel is rounding.
                    if all > ROUNDING * (of_sum[i] + line) { all } else { 0.0 }
                });
                let both = effects.iter_mut().zip(sum_effects.iter().zip(&line_effects));
                both.for_each(|(both, (sum, line))| *both = sum + share * line);
                model.combined(by_entries, &effects)
            })
            .collect()
    }
}
