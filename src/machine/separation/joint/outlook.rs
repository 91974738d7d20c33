//! What a measurement after loading will say, before it is made: visits are drawn, each is judged as `--after` does.
//!
//! ```text
//!   left    −e of the measurement that the tables are made from: they carry its errors, and leave nothing else;
//!           or what was found, v, less what of it is noise:  λ v + √λ e    λ = 1 − Σ u²/Σ v² of each curve
//!   found   left + e of the new measurement                e: without angles, which stay and cancel
//!   at most 95 % quantile over angles c of max (|found + c| + k u)    k one-sided, u without angles, by an estimated σ
//! ```

use super::{Curve, Table, at, float};
use crate::inputs::job::Job;
use crate::machine::model::ErrorModel;
use crate::machine::separation::linear::{Part, Row, Variance};
use crate::machine::separation::noise::NORMAL_ONE_SIDED;
use crate::machine::separation::separate::Separation;
use crate::machine::separation::table::directions;
use crate::quantity::axis::{Direction, ErrorTerm, Rotation};
use crate::quantity::units::{Squared, larger};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution};

/// Visits that are drawn: a share of them is known to 5 %.
const VISITS: usize = 400;
/// Angles that are drawn for each of them.
const BIASES: usize = 100;
const SEED: u64 = 29;

/// What a measurement after loading found.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    pub(crate) errors: &'a ErrorModel,
    /// Its noise by that of the next one; `None` = its readings stay.
    pub(crate) noise: Option<f64>,
}

/// What the next measurement after loading will say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outlook {
    /// What the largest of all errors is then at most, in half of the visits, µm.
    pub(crate) at_most_um: f64,
    /// Share of the visits that pass, and of those that fail.
    pub(crate) passes: f64,
    pub(crate) fails: f64,
}

/// How values are judged: factors of u for a pass and for a fail, the limit.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    pub(crate) one_sided: f64,
    pub(crate) joint: f64,
    pub(crate) limit_um: f64,
}

impl Separation {
    /// What the next measurement after loading will say, if it is made like this one; `None` where an uncertainty
    /// is not known.
    pub(crate) fn outlook(
        &self,
        job: &Job,
        found: Option<Found<'_>>,
        rule: Rule,
    ) -> Option<Outlook> {
        let table = Table::new(self, job, &directions(self, job));
        table.is_known().then(|| table.outlook(job, found, rule))
    }

    /// Angles that count without a measurement.
    pub(crate) fn unmeasured_angles(&self) -> Vec<Rotation> {
        self.model.unmeasured()
    }

    /// Standard uncertainty of the slope of a line by itself, µm/m.
    pub(crate) fn u_of_line(&self, index: usize) -> f64 {
        let all = self.model.other[self.model.layout.line(index)];
        (all - self.model.setup_ppm.squared()).sqrt()
    }

    /// What the variance of the error of a term is made of that is least certain; of values, that is at most most.
    pub(crate) fn parts(
        &self,
        job: &Job,
        term: ErrorTerm,
        errors: Option<&ErrorModel>,
    ) -> Vec<(Part, f64)> {
        let table = Table::new(self, job, &directions(self, job));
        let values = table.values(errors).into_iter();
        let u = table.variances(|v, lacks| v.all + lacks).into_iter().map(f64::sqrt);
        let at_most = values.zip(u).map(|(um, u)| um.abs() + NORMAL_ONE_SIDED * u).enumerate();
        let points = self.volume.steps + 1;
        let own = at_most.filter(|(place, _)| table.curves[place / points].term == term);
        let worst = own.max_by(|a, b| a.1.total_cmp(&b.1));
        worst.map_or_else(Vec::new, |(place, _)| {
            self.model.parts(&table.row(place / points, place % points))
        })
    }
}

impl Table<'_> {
    /// All values, each with so many times that at its reference.
    fn flat(&self, drawn: &[Curve], times: f64) -> Vec<f64> {
        let own = self.curves.iter().zip(drawn);
        let both = own.flat_map(|(curve, values)| {
            let zero = times * at(&drawn[curve.zero.0], curve.zero.1);
            values.iter().map(move |um| um + zero)
        });
        both.collect()
    }

    /// What an error hangs on, less that at the reference.
    fn row(&self, curve: usize, index: usize) -> Row {
        let (zero, place) = self.curves[curve].zero;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
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

    /// Something of u² of each value without angles, its reference included.
    fn variances(&self, of: impl Fn(&Variance, f64) -> f64) -> Vec<f64> {
        let mut model = self.of.model.clone();
        model.angles.clear();
        let own = self.curves.iter().map(|curve| {
            let all = curve.rows.variances(&model);
            all.iter().map(|v| of(v, curve.lacks_um.squared())).collect()
        });
        self.flat(&own.collect::<Vec<Curve>>(), 1.0)
    }

    /// What was found of each, µm; 0 where nothing was.
    fn values(&self, errors: Option<&ErrorModel>) -> Vec<f64> {
        let each = self.curves.iter().flat_map(|curve| {
            let known = errors.and_then(|errors| errors.terms[curve.term].as_ref());
            let way = curve.way.unwrap_or(Direction::Plus);
            let known = known.and_then(|known| known.measured.curve(way));
            let places = self.of.volume.positions(curve.term.along).into_iter();
            places.map(move |place| known.map_or(0.0, |known| known.at(place).um()))
        });
        each.collect()
    }

    /// Which values stand in the part of their axis that is judged.
    fn judged(&self, job: &Job) -> Vec<bool> {
        let each = self.curves.iter().flat_map(|curve| {
            let (volume, axis) = (&self.of.volume, curve.term.along);
            let (range, half) = (job.acceptance.range[axis], volume.step_mm(axis) / 2.0);
            let is_inside = move |mm: f64| {
                range.is_none_or(|(low, high)| mm > low.mm() - half && mm < high.mm() + half)
            };
            volume.positions(axis).into_iter().map(move |place| is_inside(place.mm()))
        });
        each.collect()
    }

    fn outlook(&self, job: &Job, found: Option<Found<'_>>, rule: Rule) -> Outlook {
        let model = &self.of.model;
        let random = |number: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(number as u64);
            random
        };
        let errors = |noise: f64, random: &mut ChaCha8Rng| {
            let z = model.draw_new(noise, random);
            self.flat(&self.of_entries(&z, random), -1.0)
        };
        let angles = model.angles.first();
        let bias = |number: usize| {
            let mut z = vec![0.0; model.noise.len()];
            model.add_angles(&mut z, angles.map_or(&[], Vec::as_slice), &mut random(number));
            let values = |rows: &super::CurveRows| rows.values(&z, rows.line.dot(&z));
            self.flat(
                &self.curves.iter().map(|curve| values(&curve.rows)).collect::<Vec<_>>(),
                -1.0,
            )
        };
        let biases: Vec<Vec<f64>> =
            (0..if angles.is_some() { BIASES } else { 1 }).map(bias).collect();
        let (noise, rest) =
            (self.variances(|v, _| v.noise), self.variances(|v, lacks| v.all - v.noise + lacks));
        let judged = self.judged(job);
        let values = self.values(found.map(|found| found.errors));
        let again = found.and_then(|found| found.noise);
        // Of each value what of it is no noise.
        let share = |place: usize| {
            let points = self.of.volume.steps + 1;
            let curve = place / points * points..(place / points + 1) * points;
            let squares: f64 = values[curve.clone()].iter().map(|um| um * um).sum();
            let u: f64 =
                curve.map(|at| noise[at] * again.unwrap_or(0.0).squared() + rest[at]).sum();
            (1.0 - u / squares.max(f64::MIN_POSITIVE)).max(0.0)
        };
        let shares: Vec<f64> = (0..values.len()).map(share).collect();
        let freedom = self.of.noise.and_then(|noise| noise.freedom).map(float);
        let spread = freedom.and_then(|freedom| Some((freedom, ChiSquared::new(freedom).ok()?)));
        let visits = if found.is_some() && again.is_none() { 1 } else { VISITS };
        let (mut passed, mut failed, mut at_most) = (0, 0, Vec::new());
        for visit in 0..visits {
            let mut random = random(visit + BIASES);
            let (before, new) =
                (errors(again.unwrap_or(1.0), &mut random), errors(1.0, &mut random));
            let s2 = spread.map_or(1.0, |(freedom, spread)| spread.sample(&mut random) / freedom);
            let seen = |place: usize| match (found, again) {
                (None, _) => new[place] - before[place],
                (Some(_), None) => values[place],
                _ => {
                    shares[place] * values[place]
                        + shares[place].sqrt() * before[place]
                        + new[place]
                }
            };
            let places = (0..values.len()).filter(|place| judged[*place]);
            let figures: Vec<(usize, f64, f64)> = places
                .map(|place| (place, seen(place), (noise[place] * s2 + rest[place]).sqrt()))
                .collect();
            let mut largest: Vec<f64> = biases
                .iter()
                .map(|bias| {
                    let each = figures
                        .iter()
                        .map(|(place, um, u)| (um + bias[*place]).abs() + rule.one_sided * u);
                    each.fold(0.0, larger)
                })
                .collect();
            largest.sort_by(f64::total_cmp);
            let largest = largest[biases.len() * 19 / 20];
            passed += usize::from(largest <= rule.limit_um);
            let fails = figures.iter().any(|(_, um, u)| um.abs() - rule.joint * u > rule.limit_um);
            failed += usize::from(fails);
            at_most.push(largest);
        }
        at_most.sort_by(f64::total_cmp);
        let share = |count: usize| float(count) / float(visits);
        Outlook { at_most_um: at_most[visits / 2], passes: share(passed), fails: share(failed) }
    }
}
