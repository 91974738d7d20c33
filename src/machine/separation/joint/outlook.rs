//! What a measurement after loading will say, before it is made: visits are drawn, each is judged as `--after` does.
//!
//! ```text
//!   left    −e of the measurement that the tables are made from: they carry its errors, and leave nothing else;
//!           or what was found, v, less what of it is noise:  λ v + √λ e    λ = 1 − Σ u²/Σ v² of each curve
//!   found   left + e of the new measurement                e: without angles, which stay and cancel
//!   at most as a table judges what was measured: 95 % quantile of max (|found + c| + g u), u by an estimated σ
//! ```

use super::{CONFIDENCE, Table, directions, largest, random, sum};
use crate::inputs::job::Job;
use crate::machine::separation::corrections::AngleEvidence;
use crate::machine::separation::linear::{Part, Row, Variance};
use crate::machine::separation::noise::{float, student};
use crate::machine::separation::separate::Separation;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{Millimetres, Squared};
use rand_distr::{ChiSquared, Distribution};

/// Visits that are drawn: a share of them is known to 5 %.
const VISITS: usize = 400;
/// Angles that are drawn for each of them.
const BIASES: usize = 100;
/// Their random numbers, apart from those of a table.
const FIRST: usize = 10_000;

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
        let points = table.points();
        let own = both.filter(|(place, _)| table.curves[place / points].term == term);
        let at_most = own.map(|(place, (um, u2))| (place, um.abs() + 2.0 * u2.sqrt()));
        let worst = at_most.max_by(|a, b| a.1.total_cmp(&b.1));
        worst.map_or_else(Vec::new, |(place, _)| {
            self.model.parts(&table.row(place / points, place % points))
        })
    }
}

impl Table<'_> {
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
        let own = self.curves.iter().flat_map(|curve| {
            let all = curve.rows.variances(&model).into_iter();
            all.map(move |v| Variance { all: v.all + curve.lacks_um.squared(), ..v })
        });
        self.beside_reference(&own.map(of).collect::<Vec<f64>>(), 1.0)
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

    fn outlook(&self, found: Option<Found<'_>>, limit_um: f64) -> Outlook {
        let freedom = self.freedom();
        // What angles do, and the factor of u beside it.
        let biases: Vec<(Vec<f64>, f64)> = match self.of.model.angles.first() {
            None => vec![(self.nothing(), student(CONFIDENCE, freedom))],
            Some(order) => {
                let bias = |number: usize| {
                    let share = (float(number) + 0.5) / float(BIASES);
                    let angles = self.angles(number, order);
                    (self.beside_reference(&angles, -1.0), student(share, freedom))
                };
                (0..BIASES).map(bias).collect()
            }
        };
        let (noise, rest) =
            (self.variances(false, |v| v.noise), self.variances(false, |v| v.all - v.noise));
        let values = self.values(found.map(|(errors, _)| errors));
        let again = found.and_then(|(_, noise)| noise);
        let points = self.points();
        let share = |place: usize| {
            let curve = place / points * points..(place / points + 1) * points;
            let squares: f64 = values[curve.clone()].iter().map(|um| um * um).sum();
            let u: f64 =
                curve.map(|at| noise[at] * again.unwrap_or(0.0).squared() + rest[at]).sum();
            (1.0 - u / squares.max(f64::MIN_POSITIVE)).max(0.0)
        };
        let shares: Vec<f64> = (0..values.len()).map(share).collect();
        let spread = freedom.and_then(|freedom| Some((freedom, ChiSquared::new(freedom).ok()?)));
        let at_most = |visit: usize| {
            let mut random = random(FIRST + visit);
            let before =
                self.beside_reference(&self.drawn(again.unwrap_or(1.0), &mut random), -1.0);
            let new = self.beside_reference(&self.drawn(1.0, &mut random), -1.0);
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
            let seen: Vec<f64> = (0..values.len()).map(seen).collect();
            let u = noise.iter().zip(&rest).map(|(noise, rest)| (noise * s2 + rest).sqrt());
            let u: Vec<f64> = u.collect();
            let at_most =
                |(bias, times): &(Vec<f64>, f64)| largest(&sum(&seen, bias), 0.0, *times, &u);
            let mut each: Vec<f64> = biases.iter().map(at_most).collect();
            let place = each.len() * 19 / 20;
            *each.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let visits = if found.is_some() && again.is_none() { 1 } else { VISITS };
        let mut at_most: Vec<f64> = (0..visits).map(at_most).collect();
        at_most.sort_by(f64::total_cmp);
        let passed = at_most.iter().filter(|um| **um <= limit_um).count();
        (at_most[visits / 2], float(passed) / float(visits))
    }
}
