//! What a measurement after loading will say, before it is made: visits are drawn, each is judged as `--after` does.
//!
//! ```text
//!   left    −e of the measurement that the tables are made from, as they hold it: they leave nothing else;
//!           or what was found, v, with another draw of what is replaced of its error e₀:  λ v + √(λ q) e₀
//!           q = 1, or 1 − Σ u²/Σ u₀² where the readings stay    λ = 1 − q Σ u₀²/Σ v² of each curve, at least 1 − q/2:
//!           the tables carry the errors of a measurement like it
//!   found   left + e of the new measurement, if its readings are new + angles that are measured now and were not
//!                                                          e: without what both repeat, which stays and cancels
//!   at most as a table judges what was measured: 95 % quantile of max (|found + c| + g u), u by an estimated σ
//! ```

use super::{CONFIDENCE, JointTable, TableCurve, acting, between, each, quantile, randoms};
use crate::inputs::job::{BacklashPolicy, Job};
use crate::machine::separation::Separation;
use crate::machine::separation::corrections::AngleEvidence;
use crate::machine::separation::curves::mean;
use crate::machine::separation::readings::{float, student};
use crate::quantity::{Diagonal, Direction, ErrorTerm, Millimetres, Pass, larger};
use nonius_numerics::draws::{LANES, Lanes, largest};
use nonius_numerics::rows::{Cause, Part, Row};
use rand_distr::{ChiSquared, Distribution};
use std::array::from_fn;

/// Visits that are drawn: a share of them is known to 5 %.
const VISITS: usize = 400;
/// Angles that are drawn for each of them.
const BIASES: usize = 100;
/// Their random numbers, apart from those of a table.
const FIRST: usize = 10_000;

/// What was measured of an error moving so at a place, µm.
pub(crate) type Values<'a> = &'a dyn Fn(ErrorTerm, Direction, Millimetres) -> f64;

/// What a measurement after loading found; what was known of it; 1 where the next one has readings of its own, else 0.
pub(crate) type AfterLoading<'a> = (Values<'a>, &'a Separation, f64);

/// What the largest of all errors is at most in half of the visits, µm; the share of visits in which it is no
/// more than the limit.
pub(crate) type Outlook = (f64, f64);

impl Separation {
    /// What the next measurement after loading will say, if it is made like this one; `None` where an uncertainty
    /// is not known.
    pub(crate) fn outlook(
        &self,
        job: &Job,
        found: Option<AfterLoading<'_>>,
        limit_um: f64,
    ) -> Option<Outlook> {
        let [table, former] =
            [self, found.map_or(self, |found| found.1)].map(|of| JointTable::new(of, job));
        let is_known = table.is_known() && former.is_known();
        is_known.then(|| table.outlook(job, found, &former, limit_um))
    }

    /// What is known of angles.
    pub(crate) fn angle_evidence(&self) -> &AngleEvidence {
        &self.evidence
    }

    /// Standard uncertainty of the slope of a line by itself, µm/m.
    pub(crate) fn u_of_line(&self, index: usize) -> f64 {
        (self.model.own[self.model.layout.line(index)] - self.model.of_setup).sqrt()
    }

    /// What the variance of the error of a term is made of that is least certain; of values, that is at most most.
    pub(crate) fn parts(
        &self,
        job: &Job,
        term: ErrorTerm,
        errors: Option<Values<'_>>,
    ) -> Vec<(Part, f64)> {
        self.model.parts(&JointTable::new(self, job).worst(term, errors))
    }

    /// The share of the noise in the variance of the error of a term that is least certain.
    pub(crate) fn share_of_noise(&self, job: &Job, term: ErrorTerm) -> f64 {
        let variance = self.model.variance(&JointTable::new(self, job).worst(term, None));
        variance.noise / variance.all
    }

    /// What the variance of the displacement along a diagonal is made of; unmeasured angles do not change it.
    pub(crate) fn parts_along(&self, diagonal: Diagonal) -> Vec<(Part, f64)> {
        let layout = self.model.layout;
        let at = |node| Row::of(layout.reading(Pass::Forward, diagonal, node));
        let mut parts = self.model.parts(&Row::sum([(1.0, at(layout.nodes - 1)), (-1.0, at(0))]));
        parts.retain(|(part, _)| !matches!(part, Part::Angle(_)));
        parts
    }
}

impl JointTable<'_> {
    /// What the value of a term hangs on that is least certain; of values, that is at most most.
    fn worst(&self, term: ErrorTerm, errors: Option<Values<'_>>) -> Row {
        let values = self.values(errors);
        let of_curve = |(index, _): (usize, &TableCurve)| {
            let rows = &self.rows.rows[index];
            let u_um = rows.variances(&self.of.model).into_iter().map(|of| of.all.sqrt());
            let each = u_um.zip(self.curve(&values, index)).enumerate();
            each.map(move |(place, (u_um, um))| (rows, place, um.abs() + 2.0 * u_um))
        };
        let own = self.curves.iter().enumerate().filter(|(_, curve)| curve.term == term);
        let worst = own.flat_map(of_curve).max_by(|a, b| a.2.total_cmp(&b.2));
        worst.map_or_else(Row::default, |(rows, place, _)| rows.at(float(place)))
    }

    /// What was found of each, µm; 0 where nothing was.
    fn values(&self, errors: Option<Values<'_>>) -> Vec<f64> {
        let each = self.curves.iter().flat_map(|curve| {
            let way = curve.way.unwrap_or(Direction::Plus);
            let places = self.of.volume.positions(curve.term.along).into_iter();
            places.map(move |place| errors.map_or(0.0, |errors| errors(curve.term, way, place)))
        });
        each.collect()
    }

    /// Values of another table for each of these curves; 0 of what it does not hold.
    fn carried(&self, other: &JointTable<'_>, values: &[f64]) -> Vec<f64> {
        let of = |curve: &TableCurve| {
            let is_way = |own: &TableCurve| own.way.is_none_or(|_| own.way == curve.way);
            let is_same = |own: &TableCurve| own.term == curve.term && is_way(own);
            let found = other.curves.iter().position(is_same);
            found.map_or(vec![0.0; self.points()], |index| other.curve(values, index).to_vec())
        };
        self.curves.iter().flat_map(of).collect()
    }

    /// What tables made from these values hold for each curve, by the policy for the reversal: the curve itself (two
    /// tables), else one curve for both directions, zero at the reference: that moving +, that of the reference
    /// direction, or the mean, also where no policy is stated. The parameter beside the second leaves no error here.
    fn tabulated(&self, job: &Job, values: &[f64]) -> Vec<f64> {
        let of = |(index, curve): (usize, &TableCurve)| {
            let way = match job.compensation.backlash[curve.term.along] {
                Some(BacklashPolicy::TwoTables) => return self.curve(values, index).to_vec(),
                Some(BacklashPolicy::ForwardOnly) => Some(Direction::Plus),
                Some(BacklashPolicy::CurveAndParameter) => self.curves[curve.zero.0].way,
                Some(BacklashPolicy::Mean) | None => None,
            };
            let is_way = |own: &TableCurve| way.is_none() || own.way.is_none() || own.way == way;
            let is_held = |own: &TableCurve| own.term == curve.term && is_way(own);
            let ways = self.curves.iter().enumerate().filter(|(_, own)| is_held(own));
            let ways: Vec<&[f64]> = ways.map(|(index, _)| self.curve(values, index)).collect();
            let of_place = |place: usize| mean(ways.iter().map(|way| way[place]));
            let held: Vec<f64> = (0..self.points()).map(of_place).collect();
            let zero = between(&held, curve.zero.1);
            held.into_iter().map(|um| um - zero).collect::<Vec<f64>>()
        };
        self.curves.iter().enumerate().flat_map(of).collect()
    }

    fn outlook(
        &self,
        job: &Job,
        found: Option<AfterLoading<'_>>,
        former: &JointTable<'_>,
        limit_um: f64,
    ) -> Outlook {
        let freedom = self.freedom();
        let times = |number| student((float(number) + 0.5) / float(BIASES), freedom);
        let times = |first| from_fn(|lane| times(first + lane));
        let first = || (0..BIASES).step_by(LANES);
        // What both measurements repeat, and the factor of u beside it.
        let of_order = |order: &[usize]| -> Vec<(Vec<Lanes>, Lanes)> {
            let bias = |first| self.rows.made_by(&acting(order, &self.repeated(first)));
            match self.laser.is_none() && order.is_empty() {
                true => vec![(self.rows.made_by(&[]), [student(CONFIDENCE, freedom); LANES])],
                false => first().map(|first| (bias(first), times(first))).collect(),
            }
        };
        let nothing = vec![0.0; self.um.len()];
        // Of the orders that the axes may have, the one in which the angles do most.
        let does_um = |biases: &[(Vec<Lanes>, Lanes)]| -> f64 {
            let most = |bias: &Vec<Lanes>| largest(bias, &nothing, [0.0; LANES], &nothing);
            biases.iter().flat_map(|(bias, _)| most(bias)).sum()
        };
        let orders = self.of.model.angles.iter().map(|order| of_order(order));
        let worst = orders.max_by(|a, b| does_um(a).total_cmp(&does_um(b)));
        let biases = worst.unwrap_or_else(|| of_order(&[]));
        let (noise, rest) = (self.variances(|v| v.noise), self.variances(|v| v.all - v.noise));
        let values = self.values(found.map(|found| found.0));
        let (is_found, again) = (found.is_some(), found.map_or(1.0, |found| found.2));
        let u2_before = self.carried(former, &former.variances(|v| v.all));
        let squares: Vec<f64> = values.iter().map(|um| um * um).collect();
        let points = self.points();
        // λ and √(λ q) of each curve.
        let share = |curve: usize| {
            let own = curve * points..(curve + 1) * points;
            let sum = |of: &[f64]| of[own.clone()].iter().sum::<f64>().max(f64::MIN_POSITIVE);
            let stays = (1.0 - again) * (sum(&noise) + sum(&rest)) / sum(&u2_before);
            let q = larger(1.0 - stays, 0.0);
            let share = larger(1.0 - q * sum(&u2_before) / sum(&squares), 1.0 - q / 2.0);
            (share, (share * q).sqrt())
        };
        let shares: Vec<(f64, f64)> = (0..self.curves.len()).map(share).collect();
        // Of angles that are measured now; in any order that the axes may have.
        let (now, before) = (&self.of.model.causes, &former.of.model);
        let order = before.angles.first().into_iter().flatten().copied();
        let is_same = |at: usize| move |cause: &Cause| cause.part == before.causes[at].part;
        let is_measured = |at: &usize| !now.iter().any(is_same(*at));
        let measured: Vec<usize> = order.filter(is_measured).collect();
        let spread = freedom.and_then(|freedom| Some((freedom, ChiSquared::new(freedom).ok()?)));
        let at_most = |first: usize| {
            let mut random = randoms(FIRST + first);
            let before = former.rows.drawn([1.0; LANES], &mut random, former.laser);
            let angles = acting(&measured, &former.repeated(first));
            let angles = former.rows.made_by(&angles[..measured.len()]);
            let new = self.rows.drawn([1.0; LANES], &mut random, self.laser);
            from_fn::<f64, LANES, _>(|lane| {
                let of_lane =
                    |values: &[Lanes]| values.iter().map(|of| of[lane]).collect::<Vec<f64>>();
                let before = match is_found {
                    true => self.carried(former, &of_lane(&before)),
                    false => former.tabulated(job, &of_lane(&before)),
                };
                let angles = self.carried(former, &of_lane(&angles));
                let random = &mut random[lane];
                let s2 = spread.map_or(1.0, |(freedom, of)| of.sample(random) / freedom);
                let seen = |place: usize| {
                    let (stays, of_before) = shares[place / points];
                    let (before, new) = (before[place], new[place][lane]);
                    let left = stays * values[place] + of_before * before + angles[place];
                    if is_found { left + again * new } else { new - before }
                };
                let seen: Vec<f64> = (0..values.len()).map(seen).collect();
                let both = noise.iter().zip(&rest);
                let u: Vec<f64> = both.map(|(noise, rest)| (noise * s2 + rest).sqrt()).collect();
                let each = biases.iter().flat_map(|(bias, times)| largest(bias, &seen, *times, &u));
                quantile(each.collect())
            })
        };
        let mut at_most: Vec<f64> = each(VISITS, at_most).into_iter().flatten().collect();
        at_most.sort_by(f64::total_cmp);
        let passed = at_most.iter().filter(|um| **um <= limit_um).count();
        (at_most[VISITS / 2], float(passed) / float(VISITS))
    }
}
