//! What a measurement after loading will say, before it is made: visits are drawn, each is judged as `--after` does.
//!
//! ```text
//!   left    −e of the measurement that the tables are made from: they carry its errors, and leave nothing else;
//!           or what was found, v, less what of it is noise:  λ v + √λ e    λ = 1 − Σ u²/Σ v² of each curve
//!   found   left + e of the new measurement                e: without angles, which stay and cancel
//!   at most 95 % quantile over angles c of max (|found + c| + k u)    k one-sided, u without angles, by an estimated σ
//! ```

use super::{Curve, Table, at, directions, float};
use crate::inputs::job::Job;
use crate::machine::separation::corrections::AngleEvidence;
use crate::machine::separation::linear::{Part, Row, Variance};
use crate::machine::separation::noise::student;
use crate::machine::separation::separate::Separation;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{Millimetres, Squared, larger};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution};

/// Visits that are drawn: a share of them is known to 5 %.
const VISITS: usize = 400;
/// Angles that are drawn for each of them.
const BIASES: usize = 100;
const SEED: u64 = 29;

/// What was measured of an error moving so at a place, µm.
pub(crate) type Measured<'a> = &'a dyn Fn(ErrorTerm, Direction, Millimetres) -> f64;

/// What a measurement after loading found; its noise by that of the next one, `None` = its readings stay.
pub(crate) type Found<'a> = (Measured<'a>, Option<f64>);

/// What the largest of all errors is at most in half of the visits, µm; the share of visits in which it is no
/// more than the limit.
pub(crate) type Outlook = (f64, f64);

impl Separation {
    /// What the next measurement after loading will say, if it is made like this one; `None` where an uncertainty
    /// is not known.
    pub(crate) fn outlook(
        &self,
        job: &Job,
        found: Option<Found<'_>>,
        limit_um: f64,
    ) -> Option<Outlook> {
        let table = Table::new(self, job, &directions(self, job));
        table.is_known().then(|| table.outlook(found, limit_um))
    }

    /// What is known of angles.
    pub(crate) fn angle_evidence(&self) -> &AngleEvidence {
        &self.model.evidence
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
        errors: Option<Measured<'_>>,
    ) -> Vec<(Part, f64)> {
        let table = Table::new(self, job, &directions(self, job));
        let u = table.variances(true, |v| v.all);
        let both = table.values(errors).into_iter().zip(u).enumerate();
        let points = self.volume.steps + 1;
        let own = both.filter(|(place, _)| table.curves[place / points].term == term);
        let at_most = own.map(|(place, (um, u2))| (place, um.abs() + 2.0 * u2.sqrt()));
        let worst = at_most.max_by(|a, b| a.1.total_cmp(&b.1));
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

    /// Something of u² of each value, its reference included, with angles or without.
    fn variances(&self, angles: bool, of: impl Fn(Variance) -> f64) -> Vec<f64> {
        let mut model = self.of.model.clone();
        model.angles.retain(|_| angles);
        let own = self.curves.iter().map(|curve| {
            let all = curve.rows.variances(&model).into_iter();
            all.map(|v| of(Variance { all: v.all + curve.lacks_um.squared(), ..v })).collect()
        });
        self.flat(&own.collect::<Vec<Curve>>(), 1.0)
    }

    /// What was found of each, µm; 0 where nothing was.
    fn values(&self, errors: Option<Measured<'_>>) -> Vec<f64> {
        let each = self.curves.iter().flat_map(|curve| {
            let way = curve.way.unwrap_or(Direction::Plus);
            let places = self.of.volume.positions(curve.term.along).into_iter();
            places.map(move |place| errors.map_or(0.0, |errors| errors(curve.term, way, place)))
        });
        each.collect()
    }

    /// Errors that are drawn: what angles do, or all else with so many times the noise.
    fn errors(&self, angles: bool, noise: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
        let (model, mut same) = (&self.of.model, random.clone());
        let mut z = model.draw(noise, &[], random);
        if angles {
            let order = model.angles.first().map_or(&[][..], Vec::as_slice);
            let both = model.draw(noise, order, &mut same).into_iter().zip(z);
            z = both.map(|(both, without)| both - without).collect();
            let curves = self.curves.iter().map(|of| of.rows.values(&z, of.rows.line.dot(&z)));
            return self.flat(&curves.collect::<Vec<Curve>>(), -1.0);
        }
        self.flat(&self.of_entries(&z, random), -1.0)
    }

    fn outlook(&self, found: Option<Found<'_>>, limit_um: f64) -> Outlook {
        let random = |number: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(number as u64);
            random
        };
        let biases = if self.of.model.angles.is_empty() { 1 } else { BIASES };
        let biases: Vec<Vec<f64>> =
            (0..biases).map(|bias| self.errors(true, 1.0, &mut random(bias))).collect();
        let (noise, rest) =
            (self.variances(false, |v| v.noise), self.variances(false, |v| v.all - v.noise));
        let values = self.values(found.map(|(errors, _)| errors));
        let again = found.and_then(|(_, noise)| noise);
        let points = self.of.volume.steps + 1;
        let share = |place: usize| {
            let curve = place / points * points..(place / points + 1) * points;
            let squares: f64 = values[curve.clone()].iter().map(|um| um * um).sum();
            let u: f64 =
                curve.map(|at| noise[at] * again.unwrap_or(0.0).squared() + rest[at]).sum();
            (1.0 - u / squares.max(f64::MIN_POSITIVE)).max(0.0)
        };
        let shares: Vec<f64> = (0..values.len()).map(share).collect();
        let freedom = self.of.noise.and_then(|noise| noise.freedom).map(float);
        let spread = freedom.and_then(|freedom| Some((freedom, ChiSquared::new(freedom).ok()?)));
        let one_sided = student(0.95, freedom);
        let at_most = |visit: usize| {
            let mut random = random(visit + BIASES);
            let before = self.errors(false, again.unwrap_or(1.0), &mut random);
            let new = self.errors(false, 1.0, &mut random);
            let s2 = spread.map_or(1.0, |(freedom, of)| of.sample(&mut random) / freedom);
            let seen = |place: usize| match (found, again) {
                (None, _) => new[place] - before[place],
                (Some(_), None) => values[place],
                _ => {
                    shares[place] * values[place]
                        + shares[place].sqrt() * before[place]
                        + new[place]
                }
            };
            let figure =
                |place: usize| (seen(place), one_sided * (noise[place] * s2 + rest[place]).sqrt());
            let figures: Vec<(f64, f64)> = (0..values.len()).map(figure).collect();
            let largest = |bias: &Vec<f64>| {
                let each = figures.iter().zip(bias).map(|((um, u), bias)| (um + bias).abs() + u);
                each.fold(0.0, larger)
            };
            let mut largest: Vec<f64> = biases.iter().map(largest).collect();
            largest.sort_by(f64::total_cmp);
            largest[biases.len() * 19 / 20]
        };
        let visits = if found.is_some() && again.is_none() { 1 } else { VISITS };
        let mut at_most: Vec<f64> = (0..visits).map(at_most).collect();
        at_most.sort_by(f64::total_cmp);
        let passed = at_most.iter().filter(|um| **um <= limit_um).count();
        (at_most[visits / 2], float(passed) / float(visits))
    }
}
