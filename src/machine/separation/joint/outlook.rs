//! What a measurement after loading will say, before it is made: visits are drawn, and each is judged as
//! `--after` judges it.
//!
//! ```text
//!   left    −e of the measurement that the tables are made from: they carry its errors, and leave nothing else;
//!           or what a measurement after loading found, v, less what of it is noise: λ v + √λ e,  λ = 1 − mean u²/mean v²
//!   found   left + e of the new measurement                e: without angles, which stay and cancel
//!   at most 95 % quantile over angles c of max (|found + c| + k u_new),    k one-sided, u_new with an estimated σ
//! ```

use super::super::linear::{Part, Row, Variance};
use super::super::separate::Separation;
use super::super::table::directions;
use super::{Curve, Table, TableCurve, at, float};
use crate::inputs::job::{Acceptance, Job};
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::diagonal::{Diagonal, PerDiagonal};
use crate::quantity::units::{Squared, larger};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution};

/// Visits that are drawn: a share of them is known to 5 %.
const VISITS: usize = 400;
/// Angles that are drawn for each of them.
const BIASES: usize = 100;
const SEED: u64 = 29;

/// A measurement after loading: how it was made, and what it found.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    pub(crate) of: &'a Separation,
    pub(crate) errors: &'a ErrorModel,
}

/// What the next measurement after loading will say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outlook {
    /// What the largest of all errors is then at most, in half of the visits, µm.
    pub(crate) at_most_um: f64,
    /// Share of the visits that pass.
    pub(crate) passes: f64,
    /// Share of those that fail.
    pub(crate) fails: f64,
}

/// How figures are judged: factors of u for a pass and for a fail, limits, u of max − min of each diagonal.
pub(crate) struct Rule {
    pub(crate) one_sided: f64,
    pub(crate) joint: f64,
    pub(crate) limits: Acceptance,
    pub(crate) u_diagonals_um: PerDiagonal<f64>,
}

/// A random sequence of its own for each visit.
fn random(visit: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(visit as u64);
    random
}

impl Separation {
    /// What the next measurement after loading will say, if it is made like this one; `None` where an
    /// uncertainty is not known.
    pub(crate) fn outlook(&self, job: &Job, found: Option<Found<'_>>, rule: &Rule) -> Option<Outlook> {
        let table = Table::of(self, job).filter(Table::is_known)?;
        let first = match found {
            Some(found) => Table::of(found.of, job).filter(Table::is_known)?,
            None => Table::of(self, job)?,
        };
        let orders = &self.model.angles;
        let orders: &[Vec<usize>] = if orders.is_empty() { &[Vec::new()] } else { orders };
        let outlooks = orders.iter().map(|order| {
            let biases: Vec<Vec<Curve>> = match order.is_empty() {
                true => vec![table.zeroed(&table.of_angles(order, &mut random(0)))],
                false => (0..BIASES).map(|bias| table.zeroed(&table.of_angles(order, &mut random(bias)))).collect(),
            };
            table.judged(&first, found, &biases, rule)
        });
        outlooks.min_by(|a, b| a.passes.total_cmp(&b.passes))
    }

    /// What the variance of the least certain error of a term is made of; of values the one that is most at most.
    pub(crate) fn parts(&self, job: &Job, term: ErrorTerm, errors: Option<&ErrorModel>) -> Vec<(Part, f64)> {
        let Some(table) = Table::of(self, job) else { return Vec::new() };
        let variances = table.variances();
        let um = |curve: usize, index: usize| {
            let value = errors.map_or(0.0, |errors| table.value(errors, curve, index).abs());
            value + super::super::noise::NORMAL_ONE_SIDED * variances[curve][index].all.sqrt()
        };
        let places = table.places(|curve| table.curves[curve].term == term);
        let worst = places.max_by(|a, b| um(a.0, a.1).total_cmp(&um(b.0, b.1)));
        worst.map_or_else(Vec::new, |(curve, index)| self.model.parts(&table.row(curve, index)))
    }
}

impl<'a> Table<'a> {
    fn of(of: &'a Separation, job: &Job) -> Option<Table<'a>> {
        let table = Table::new(of, job, &directions(of, job));
        (!table.curves.is_empty()).then_some(table)
    }

    fn places(&self, is_of: impl Fn(usize) -> bool) -> impl Iterator<Item = (usize, usize)> {
        let last = self.of.volume.steps;
        let curves = (0..self.curves.len()).filter(move |curve| is_of(*curve));
        curves.flat_map(move |curve| (0..=last).map(move |index| (curve, index)))
    }

    /// What an error hangs on, less that at the reference.
    fn row(&self, curve: usize, index: usize) -> Row {
        let (zero, place) = self.curves[curve].zero;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in a list")]
        let ends = [(1.0, curve, index), (-1.0, zero, place.round() as usize)];
        let mut row = Row::default();
        for (sign, curve, index) in ends {
            let rows = &self.curves[curve].rows;
            row.add(sign, &rows.start);
            rows.steps.iter().take(index).for_each(|step| row.add(sign, step));
            row.add(sign * float(index) / self.of.volume.steps_f64(), &rows.line);
        }
        row
    }

    /// Values less that at the reference.
    fn zeroed(&self, drawn: &[Curve]) -> Vec<Curve> {
        let own = self.curves.iter().zip(drawn);
        let zeroed = own.map(|(curve, values)| {
            let zero = at(&drawn[curve.zero.0], curve.zero.1);
            values.iter().map(|um| um - zero).collect()
        });
        zeroed.collect()
    }

    fn of_angles(&self, order: &[usize], random: &mut ChaCha8Rng) -> Vec<Curve> {
        let model = &self.of.model;
        let mut z = vec![0.0; model.noise.len()];
        model.add_angles(&mut z, order, random);
        self.curves.iter().map(|curve| curve.rows.values(&z, curve.rows.line.dot(&z))).collect()
    }

    /// Errors of a measurement beside what angles do.
    fn new_errors(&self, random: &mut ChaCha8Rng) -> Vec<Curve> {
        let z = self.of.model.draw_new(1.0, random);
        self.zeroed(&self.of_entries(&z, random))
    }

    /// u² of each error without angles, as a table and its reference give it.
    fn variances(&self) -> Vec<Vec<Variance>> {
        let mut model = self.of.model.clone();
        model.angles.clear();
        let own: Vec<Vec<Variance>> = self.curves.iter().map(|curve| {
            let lacks = curve.lacks_um.squared();
            let all = curve.rows.variances(&model).into_iter();
            all.map(|v| Variance { all: v.all + lacks, ..v }).collect()
        }).collect();
        let with_zero = own.iter().zip(&self.curves).map(|(variances, curve)| {
            let (zero, place) = curve.zero;
            let of = |of: &dyn Fn(&Variance) -> f64| at(&own[zero].iter().map(of).collect::<Vec<_>>(), place);
            let (noise, all) = (of(&|v| v.noise), of(&|v| v.all));
            variances.iter().map(|v| Variance { noise: v.noise + noise, all: v.all + all }).collect()
        });
        with_zero.collect()
    }

    /// What a model says where a curve has a point, µm; 0 where it does not know.
    fn value(&self, errors: &ErrorModel, curve: usize, index: usize) -> f64 {
        let TableCurve { term, way, .. } = &self.curves[curve];
        let known = errors.terms[*term].as_ref();
        let known = known.and_then(|known| known.measured.curve(way.unwrap_or(Direction::Plus)));
        known.map_or(0.0, |known| known.at(self.of.volume.positions(term.along)[index]).um())
    }

    /// The curve of another table that stands for one of this; the other direction where there is no better one.
    fn like(&self, other: &TableCurve) -> Option<usize> {
        let is_same = |curve: &TableCurve| curve.term == other.term;
        let exact = self.curves.iter().position(|curve| is_same(curve) && curve.way == other.way);
        exact.or_else(|| self.curves.iter().position(is_same))
    }

    fn judged(&self, first: &Table<'_>, found: Option<Found<'_>>, biases: &[Vec<Curve>], rule: &Rule) -> Outlook {
        let variances = self.variances();
        let values = found.map(|found| self.shrunk(first, found.errors));
        let judged: Vec<(usize, usize)> = self.places(|_| true).filter(|place| self.is_judged(*place, rule)).collect();
        let freedom = self.of.noise.and_then(|noise| noise.freedom).map(float);
        let spread = freedom.and_then(|freedom| ChiSquared::new(freedom).ok());
        let (mut passed, mut failed, mut at_most) = (0, 0, Vec::new());
        for visit in 0..VISITS {
            let mut random = random(visit + BIASES);
            let before = first.new_errors(&mut random);
            let new = self.new_errors(&mut random);
            let s2 = spread.zip(freedom).map_or(1.0, |(spread, freedom)| spread.sample(&mut random) / freedom);
            let um = |curve: usize, index: usize| {
                let old = first.like(&self.curves[curve]).and_then(|old| before[old].get(index));
                let old = old.copied().unwrap_or(0.0);
                let left = values.as_ref().map_or(-old, |values| {
                    let (value, share) = values[curve][index];
                    value + share * old
                });
                left + new[curve][index]
            };
            let figures: Vec<(usize, usize, f64, f64)> = judged.iter().map(|(curve, index)| {
                let v = &variances[*curve][*index];
                (*curve, *index, um(*curve, *index), (v.noise * s2 + v.all - v.noise).max(0.0).sqrt())
            }).collect();
            let bounds = |of: &dyn Fn(&[Curve]) -> f64| {
                let mut all: Vec<f64> = biases.iter().map(|bias| of(bias)).collect();
                all.sort_by(f64::total_cmp);
                all[(biases.len() * 19 / 20).min(biases.len() - 1)]
            };
            let largest = bounds(&|bias| figures.iter().map(|(curve, index, um, u)| {
                (um + bias[*curve][*index]).abs() + rule.one_sided * u
            }).fold(0.0, larger));
            let ranges = rule.limits.max_diagonal_um.map(|limit| bounds(&|bias| {
                let both = (0..self.curves.len()).map(|curve| {
                    (0..=self.of.volume.steps).map(|index| um(curve, index) + bias[curve][index]).collect()
                });
                let ranges = self.sizes(&both.collect::<Vec<Curve>>()).diagonals;
                let each = Diagonal::ALL.map(|d| ranges[d] + rule.one_sided * rule.u_diagonals_um[d]);
                each.into_iter().fold(0.0, larger) - limit
            }));
            let limit = rule.limits.max_deviation_um.unwrap_or(f64::INFINITY);
            let fails = |(_, _, um, u): &(usize, usize, f64, f64)| um.abs() - rule.joint * u > limit;
            if largest <= limit && ranges.is_none_or(|over| over <= 0.0) {
                passed += 1;
            } else if figures.iter().any(fails) {
                failed += 1;
            }
            at_most.push(largest);
        }
        at_most.sort_by(f64::total_cmp);
        let share = |count: usize| float(count) / float(VISITS);
        Outlook { at_most_um: at_most[VISITS / 2], passes: share(passed), fails: share(failed) }
    }

    /// Whether an error stands in the part of its axis that is judged.
    fn is_judged(&self, (curve, index): (usize, usize), rule: &Rule) -> bool {
        let axis = self.curves[curve].term.along;
        let at = self.of.volume.positions(axis)[index].mm();
        let half = self.of.volume.step_mm(axis) / 2.0;
        let range = rule.limits.range[axis];
        range.is_none_or(|(low, high)| at > low.mm() - half && at < high.mm() + half)
    }

    /// What was found less the share of it that its noise makes, with the share of the errors that comes with it.
    fn shrunk(&self, first: &Table<'_>, errors: &ErrorModel) -> Vec<Vec<(f64, f64)>> {
        let variances = first.variances();
        let of = |curve: usize| {
            let values: Vec<f64> = (0..=self.of.volume.steps).map(|index| self.value(errors, curve, index)).collect();
            let squares: f64 = values.iter().map(|um| um * um).sum();
            let old = first.like(&self.curves[curve]);
            let noise: f64 = old.map_or(0.0, |old| variances[old].iter().map(|v| v.all).sum());
            let share = (1.0 - noise / squares.max(f64::MIN_POSITIVE)).max(0.0);
            values.into_iter().map(|um| (share * um, share.sqrt())).collect()
        };
        (0..self.curves.len()).map(of).collect()
    }
}
