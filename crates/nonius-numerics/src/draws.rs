//! Curves of one measurement, drawn together: what they share counts once and not for every value anew.
//!
//! ```text
//!   value = rows · z + Σ times · column      z: noise of the readings and lines, by itself; times: how often a cause acts
//! ```
//! Draws are made [`LANES`] at a time. What a cause makes of a curve is a sum of few shapes, lines and bends, that all
//! causes have in common.

use crate::rows::{CurveRows, Model};
use chacha20::ChaCha8Rng;
use std::sync::OnceLock;

/// Draws that are made side by side: as many as a processor adds and multiplies at once.
pub const LANES: usize = 4;

/// A figure in each of them.
pub type Lanes = [f64; LANES];

/// What is left of a column beside the shapes that are known counts from here on, as a share of the column.
const ROUNDING: f64 = 1e-11;

/// Curves with equally many values, that are drawn together.
#[derive(Clone, Debug)]
pub struct Curves<'a> {
    /// What is uncertain of the measurement.
    pub model: &'a Model,
    /// Of each curve.
    pub rows: Vec<CurveRows>,
    acting: OnceLock<Vec<Acting>>,
}

/// What causes make of a curve: shapes, and how many times each of them a unit of each cause makes.
#[derive(Clone, Debug, Default)]
struct Acting {
    shapes: Vec<Vec<f64>>,
    by_cause: Vec<Vec<f64>>,
}

impl Acting {
    fn of(model: &Model, rows: &CurveRows) -> Acting {
        let mut acting = Acting::default();
        for cause in &model.causes {
            let smallest = ROUNDING * length(&cause.column);
            let mut left = rows.values(&cause.column, rows.line.dot(&cause.column));
            let mut times = Vec::new();
            for shape in &acting.shapes {
                let own: f64 = left.iter().zip(shape).map(|(left, shape)| left * shape).sum();
                left.iter_mut().zip(shape).for_each(|(left, shape)| *left -= own * shape);
                times.push(own);
            }
            let rest = length(&left);
            if rest > smallest {
                acting.shapes.push(left.into_iter().map(|um| um / rest).collect());
                times.push(rest);
            }
            acting.by_cause.push(times);
        }
        acting
    }

    /// Adds what the causes make that act so many times.
    fn add(&self, causes: &[(usize, Lanes)], values: &mut [Lanes]) {
        for (index, shape) in self.shapes.iter().enumerate() {
            let mut times = [0.0; LANES];
            for (cause, acts) in causes {
                let own = self.by_cause[*cause].get(index).copied().unwrap_or(0.0);
                add(&mut times, own, acts);
            }
            if !times.iter().all(|times| times.abs() <= 0.0) {
                values.iter_mut().zip(shape).for_each(|(value, shape)| add(value, *shape, &times));
            }
        }
    }
}

fn length(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

impl<'a> Curves<'a> {
    /// Curves of a measurement.
    pub fn new(model: &'a Model, rows: Vec<CurveRows>) -> Curves<'a> {
        Curves { model, rows, acting: OnceLock::new() }
    }

    fn acting(&self) -> &[Acting] {
        let of = |rows: &CurveRows| Acting::of(self.model, rows);
        self.acting.get_or_init(|| self.rows.iter().map(of).collect())
    }

    /// Values of each curve.
    pub fn points(&self) -> usize {
        self.rows.first().map_or(1, |rows| rows.steps.len() + 1)
    }

    /// The values of all curves, where nothing acts but these causes, so many times.
    pub fn made_by(&self, causes: &[(usize, Lanes)]) -> Vec<Lanes> {
        let mut values = vec![[0.0; LANES]; self.rows.len() * self.points()];
        self.add(causes, &mut values);
        values
    }

    /// The values of all curves for these entries of z.
    pub fn moved_by(&self, z: &[Lanes]) -> Vec<Lanes> {
        let mut values = self.made_by(&[]);
        let places = values.chunks_exact_mut(self.points());
        self.rows.iter().zip(places).for_each(|(rows, own)| rows.fill(z, rows.line.dots(z), own));
        values
    }

    /// Adds to the values of all curves what causes make that act so many times.
    pub fn add(&self, causes: &[(usize, Lanes)], values: &mut [Lanes]) {
        let places = values.chunks_exact_mut(self.points());
        self.acting().iter().zip(places).for_each(|(acting, own)| acting.add(causes, own));
    }

    /// One draw by each generator, without angles and a cause that is left out, the noise so many times as large as estimated.
    pub fn drawn(
        &self,
        noise: Lanes,
        random: &mut [ChaCha8Rng; LANES],
        without: Option<usize>,
    ) -> Vec<Lanes> {
        let (z, mut shares) = self.model.draw(noise, random);
        without.into_iter().for_each(|at| shares[at].1 = [0.0; LANES]);
        let mut drawn = self.moved_by(&z);
        self.add(&shares, &mut drawn);
        drawn
    }

    /// max of |value + what causes make that act so many times| + times · u of each curve.
    pub fn largest(
        &self,
        values: &[Lanes],
        causes: &[(usize, Lanes)],
        times: Lanes,
        u: &[f64],
    ) -> Vec<Lanes> {
        let points = self.points();
        let (mut moved, nothing) = (vec![[0.0; LANES]; points], vec![0.0; points]);
        let own = values.chunks_exact(points).zip(u.chunks_exact(points));
        let each = self.acting().iter().zip(own).map(|(acting, (values, u))| {
            moved.copy_from_slice(values);
            acting.add(causes, &mut moved);
            largest(&moved, &nothing, times, u)
        });
        each.collect()
    }
}

/// Adds a figure so many times.
#[inline]
pub(crate) fn add<const N: usize>(sum: &mut [f64; N], times: f64, part: &[f64; N]) {
    for lane in 0..N {
        sum[lane] += times * part[lane];
    }
}

/// A list that is the same in each draw.
pub fn alike(values: &[f64]) -> Vec<Lanes> {
    values.iter().map(|value| [*value; LANES]).collect()
}

/// The larger one in each draw.
#[inline]
pub fn larger(mut one: Lanes, other: &Lanes) -> Lanes {
    for lane in 0..LANES {
        one[lane] = if other[lane] > one[lane] { other[lane] } else { one[lane] };
    }
    one
}

/// max of |value + what stands beside it| + times · u.
pub fn largest(values: &[Lanes], beside: &[f64], times: Lanes, u: &[f64]) -> Lanes {
    let mut most = [0.0; LANES];
    for (value, (beside, u)) in values.iter().zip(beside.iter().zip(u)) {
        let mut own = *value;
        for lane in 0..LANES {
            own[lane] = (own[lane] + beside).abs() + times[lane] * u;
        }
        most = larger(most, &own);
    }
    most
}

/// The sum of curves, each so many times, from its low end on or from its high one.
pub fn sum<'v>(
    points: usize,
    curves: impl Iterator<Item = (f64, bool, &'v [Lanes])>,
) -> Vec<Lanes> {
    let mut sum = vec![[0.0; LANES]; points];
    for (times, is_up, values) in curves {
        let place = |at| if is_up { at } else { points - 1 - at };
        let each = sum.iter_mut().enumerate();
        each.for_each(|(at, sum)| add(sum, times, &values[place(at)]));
    }
    sum
}

/// max − min.
pub fn range(values: &[Lanes]) -> Lanes {
    let (mut least, mut most) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for value in values {
        most = larger(most, value);
        for lane in 0..LANES {
            least[lane] = if value[lane] < least[lane] { value[lane] } else { least[lane] };
        }
    }
    add(&mut most, -1.0, &least);
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::{Cause, Layout, Part, Row, Variance};
    use chacha20::rand_core::SeedableRng;

    /// Two curves of four values over the readings of a run with four nodes; three causes, the third a sum of the others.
    fn measured() -> (Model, Vec<CurveRows>) {
        let layout = Layout { nodes: 4, passes: 1, lines: 0, apart: 0 };
        let straight = layout.column(|_, node| node as f64);
        let bend = layout.column(|d, node| (node * node) as f64 * f64::from(d as u8));
        let both = straight.iter().zip(&bend).map(|(a, b)| a - 0.5 * b).collect();
        let cause = |(column, variance)| Cause { part: Part::Beam, column, variance, of_beam: 0.0 };
        let causes = [(straight, 0.04), (bend, 0.01), (both, 0.09)].map(cause).to_vec();
        let mut own = vec![0.25; layout.line(0)];
        own.resize(layout.entries(), 0.0);
        let model = Model {
            layout,
            freedom: None,
            own,
            of_setup: 0.0,
            causes,
            laser: None,
            angles: Vec::new(),
        };
        let step = |at: usize| Row(vec![(at + 1, 1.0), (at, -1.0), (at + 5, 0.5)]);
        let curve = |first: usize| CurveRows {
            steps: (first..first + 3).map(step).collect(),
            line: Row(vec![(12, 0.3)]),
            ..CurveRows::default()
        };
        (model, vec![curve(0), curve(4)])
    }

    #[test]
    fn causes_make_of_the_curves_what_their_columns_make() {
        let (model, rows) = measured();
        let curves = Curves::new(&model, rows);
        let times = [[1.0, 0.0, 0.0, 2.0], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, 1.0, 3.0]];
        let made = curves.made_by(&[(0, times[0]), (1, times[1]), (2, times[2])]);
        let mut moved = curves.made_by(&[]);
        for (cause, times) in model.causes.iter().zip(times) {
            let each = moved.iter_mut().zip(curves.moved_by(&alike(&cause.column)));
            each.for_each(|(moved, column)| {
                (0..LANES).for_each(|lane| moved[lane] += times[lane] * column[lane]);
            });
        }
        let pairs = made.as_flattened().iter().zip(moved.as_flattened());
        assert!(pairs.into_iter().all(|(made, moved)| (made - moved).abs() < 1e-9), "{made:?}");
    }

    #[test]
    fn draws_scatter_as_the_model_says() {
        let (model, rows) = measured();
        let curves = Curves::new(&model, rows);
        let drawn = |number: u64| {
            let mut random =
                [0, 1, 2, 3].map(|lane: u64| ChaCha8Rng::seed_from_u64(4 * number + lane));
            curves.drawn([1.0; LANES], &mut random, None)
        };
        let draws: Vec<Vec<Lanes>> = (0..2000).map(drawn).collect();
        let variances = curves.rows.iter().flat_map(|rows| rows.variances(&model));
        for (at, Variance { all, .. }) in variances.enumerate() {
            let squares = draws.iter().flat_map(|values| values[at]).map(|um| um * um);
            let u = (squares.sum::<f64>() / 8000.0).sqrt();
            assert!((u - all.sqrt()).abs() <= 0.05 * all.sqrt(), "{u} {}", all.sqrt());
        }
    }

    #[test]
    fn the_largest_and_the_range_are_those_of_each_draw() {
        let is = |found: &[Lanes], expected: &[Lanes]| {
            let pairs = found.as_flattened().iter().zip(expected.as_flattened());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        let values = [[1.0, -2.0, 0.0, 0.5], [-3.0, 1.0, 0.25, 0.5]];
        let most = largest(&values, &[0.5, 0.0], [1.0, 0.0, 2.0, 0.0], &[0.1, 1.0]);
        is(&[most], &[[4.0, 1.5, 2.25, 1.0]]);
        is(&[range(&values)], &[[4.0, 3.0, 0.25, 0.0]]);
        let both = [(2.0, true, &values[..]), (1.0, false, &values[..])];
        is(&sum(2, both.into_iter()), &[[-1.0, -3.0, 0.25, 1.5], [-5.0, 0.0, 0.5, 1.5]]);
    }
}
