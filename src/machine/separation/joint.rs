//! How far the largest of all errors may lie off: readings, lines and stated causes are drawn together, so what
//! errors share counts once and not for every point anew.
//!
//! ```text
//!   e = row · z, z drawn: noise normal, its σ by χ² where it was estimated; lines, scales, tilts normal; angles uniform
//!   forecast     q = 95 % quantile of max over the points of |e(x) − e(reference)|
//!   as measured  q = 95 % quantile of max over the points of |value + c| + g u,   g one normal draw (Student's)
//!                c: what another measurement repeats, which sits in the machine's error too: angles, and the scale
//!                of a laser with a serial number;  u: all else
//!   diagonals    as measured: max over pairs of nodes of |difference| + 1.645 u(difference) of the readings
//! ```
//! |value + e| is then at most the largest |value| + q, with 95 % (`docs/method.md` §22). The nine errors together
//! are the readings of the diagonals: what an unmeasured angle does to each of them cancels there.

mod outlook;

pub(crate) use self::outlook::{Found, Measured, Outlook};
use super::Separation;
use super::curves::{Curve, range};
use super::readings::{Noise, student};
use crate::inputs::error_table::{LargestErrors, Remarks, Sizes};
use crate::inputs::job::{BacklashPolicy, Job};
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Pass, PerAxis, PerDiagonal, PerTerm, Squared, larger,
};
use crate::text::joined;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nonius_numerics::rows::{CurveRows, Row, add, largest};
use rand_distr::{ChiSquared, Distribution, StandardNormal, StandardUniform};

/// Of 1,000 draws the 95 % quantile is known to 2 %.
const DRAWS: usize = 1000;
const SEED: u64 = 23;
/// Probability behind every bound.
const CONFIDENCE: f64 = 0.95;

/// One curve of a table.
struct TableCurve {
    term: ErrorTerm,
    way: Option<Direction>,
    /// Less the value at the reference.
    rows: CurveRows,
    /// Where it stands among the curves that is zero at the reference, and the place of that, in steps.
    zero: (usize, f64),
}

/// The curves of a table, to be drawn. All their values stand in one list, curve after curve, zero at the reference.
pub(super) struct Table<'a> {
    of: &'a Separation,
    curves: Vec<TableCurve>,
    /// As measured, µm.
    um: Vec<f64>,
    /// What each cause makes of the values.
    by_cause: Vec<Vec<f64>>,
    /// The cause that another measurement with the same laser repeats.
    laser: Option<usize>,
}

impl Table<'_> {
    /// Says of a table how far its errors may lie off, with 95 %, and what may falsify them; nothing of the former where
    /// an uncertainty is not known.
    pub(super) fn remarks(&self, job: &Job, said: Remarks) -> Remarks {
        let said = Remarks { doubtful: self.doubtful(), ..said };
        if !self.is_known() {
            return said;
        }
        let angles = &self.of.model.angles;
        let orders = if angles.is_empty() { &vec![Vec::new()] } else { angles };
        // What another measurement does not repeat; how many times the laser acts that it repeats.
        let anew = |number| {
            let mut random = random(number);
            let noise = self.estimate(&mut random);
            self.drawn(noise, &mut random)
        };
        let (mut drawn, lasers): (Vec<Vec<f64>>, Vec<f64>) = (0..DRAWS).map(anew).unzip();
        let mut squares = self.nothing();
        for anew in &drawn {
            squares.iter_mut().zip(anew).for_each(|(sum, um)| *sum += um.squared());
        }
        let u: Vec<f64> = squares.iter().map(|s| (s / DRAWS as f64).sqrt()).collect();
        let mut with_laser = u.clone();
        if let Some(at) = self.laser {
            let laser = &self.by_cause[at];
            drawn.iter_mut().zip(&lasers).for_each(|(anew, times)| add(anew, *times, laser));
            with_laser.iter_mut().zip(laser).for_each(|(u, um)| *u = u.hypot(*um));
        }
        let ranges: Vec<PerDiagonal<f64>> = drawn.iter().map(|anew| self.ranges(anew)).collect();
        let diagonals = self.ranges_at_most();
        let times = |number: usize| {
            let share = (number as f64 + 0.5) / DRAWS as f64;
            student(share, None) * self.estimate(&mut random(2 * DRAWS + number))
        };
        let repeats_nothing = self.laser.is_none() && orders.iter().all(Vec::is_empty);
        let times: Vec<f64> = match repeats_nothing {
            true => vec![student(CONFIDENCE, self.freedom()); DRAWS],
            false => (0..DRAWS).map(times).collect(),
        };
        let of_order = |order: &Vec<usize>| {
            let sizes = |(number, anew): (usize, &Vec<f64>)| {
                let mut left = self.angles(number, order);
                let mut found = self.repeated(number, left.clone());
                add(&mut left, 1.0, anew);
                add(&mut found, 1.0, &self.um);
                let left = Sizes { terms: self.terms(&left, 0.0, &u), diagonals: ranges[number] };
                (left, Sizes { terms: self.terms(&found, times[number], &u), diagonals })
            };
            let (left, found): (Vec<Sizes>, Vec<Sizes>) =
                drawn.iter().enumerate().map(sizes).unzip();
            [left, found].map(|draws| quantiles(zero(job), &draws))
        };
        let all = orders.iter().map(of_order);
        let worst = all.reduce(|[a, b], [c, d]| [a.joined(&c, larger), b.joined(&d, larger)]);
        let [forecast, found] = worst.map_or([None, None], |each| each.map(Some));
        let values = quantiles(zero(job), &[self.sizes(&self.um)]);
        let sizes_of =
            |u: &[f64]| Sizes { terms: self.terms(&self.nothing(), 1.0, u), ..Sizes::default() };
        let instrument = job.measurement.instrument.clone().filter(|_| self.laser.is_some());
        Remarks {
            largest: forecast,
            measured: found.map(|at_most| at_most.joined(&values, |a, b| a - b)),
            anew: (!angles.is_empty()).then(|| sizes_of(&with_laser)),
            same_laser: instrument.map(|instrument| (instrument, sizes_of(&u))),
            ..said
        }
    }

    /// What max − min along each diagonal was at most: its readings are direct, whatever the separation makes of them.
    fn ranges_at_most(&self) -> PerDiagonal<f64> {
        let (model, times) = (&self.of.model, student(CONFIDENCE, self.freedom()));
        let mut ranges = PerDiagonal::default();
        for (d, pass) in self.walks() {
            let along = self.along(d, pass, &self.um);
            let at = |step: usize| model.layout.reading(pass, d, 3 * step);
            for (i, low) in along.iter().enumerate() {
                for (j, high) in along.iter().enumerate().skip(i + 1) {
                    let u = model.u_of_difference(at(i), at(j));
                    ranges[d] = larger(ranges[d], (high - low).abs() + times * u);
                }
            }
        }
        ranges
    }

    /// Whether there are curves, and every uncertainty is known.
    fn is_known(&self) -> bool {
        let known = |curve: &TableCurve| {
            self.of.of_table(curve.term, curve.way).is_some_and(|found| found.u.is_some())
        };
        !self.curves.is_empty() && self.curves.iter().all(known)
    }

    /// How far what speaks against the result by its size may move the errors: each anomaly by its worst cause,
    /// all anomalies added; `None` where nothing speaks against it.
    fn doubtful(&self) -> Option<Sizes> {
        let worst = |causes: &Vec<Vec<f64>>| {
            let sizes = causes.iter().map(|z| self.sizes(&self.moved_by(z)));
            sizes.fold(Sizes::default(), |worst, own| worst.joined(&own, larger))
        };
        let each = self.of.anomalies.iter().map(worst);
        let all = each.fold(Sizes::default(), |all, own| all.joined(&own, |all, own| all + own));
        (all.all_um().max(all.ranges_um()) > 0.0).then_some(all)
    }
}

impl<'a> Table<'a> {
    pub(super) fn new(of: &'a Separation, job: &Job) -> Table<'a> {
        let directions = directions(of, job);
        let mut curves: Vec<TableCurve> = Vec::new();
        let mut um = Vec::new();
        for term in ErrorTerm::ALL {
            let machine = job.machine.axes[term.along];
            let homing = machine.map(|axis| axis.homing());
            let ways = &directions[term.along];
            // Where the reference lies, in steps; the end that is nearest to one beyond.
            let (start, step) = (of.volume.start[term.along].mm(), of.volume.step_mm(term.along));
            let at = machine.map_or(0.0, |axis| (axis.reference.mm() - start) / step);
            let at = at.clamp(0.0, of.volume.steps_f64());
            let all = ways.iter().filter_map(|way| Some((*way, of.of_table(term, *way)?)));
            let all: Vec<_> = all.collect();
            let zero = all.iter().position(|(way, _)| *way == homing).unwrap_or(0);
            let Some((_, reference)) = all.get(zero) else { continue };
            let (zero_um, zero_row) = (between(&reference.deviation_um, at), reference.rows.at(at));
            let zero = (curves.len() + zero, at);
            for (way, found) in all {
                um.extend(found.deviation_um.iter().map(|um| um - zero_um));
                let mut rows = found.rows.merged();
                rows.start = Row::sum([(1.0, &rows.start), (-1.0, &zero_row)]).merged();
                curves.push(TableCurve { term, way, rows, zero });
            }
        }
        let laser = of.model.laser.filter(|_| job.measurement.instrument.is_some());
        let mut table = Table { of, um, by_cause: Vec::new(), laser, curves };
        table.by_cause = of.model.causes.iter().map(|of| table.moved_by(&of.column)).collect();
        table
    }

    /// The values for these entries of z.
    fn moved_by(&self, z: &[f64]) -> Vec<f64> {
        let mut values = self.nothing();
        let places = values.chunks_exact_mut(self.points());
        for (TableCurve { rows, .. }, own) in self.curves.iter().zip(places) {
            rows.fill(z, rows.line.dot(z), own);
        }
        values
    }

    fn nothing(&self) -> Vec<f64> {
        vec![0.0; self.um.len()]
    }

    /// Values of each curve.
    fn points(&self) -> usize {
        self.of.volume.steps + 1
    }

    /// One of the curves.
    fn curve<'v>(&self, values: &'v [f64], index: usize) -> &'v [f64] {
        &values[index * self.points()..(index + 1) * self.points()]
    }

    fn freedom(&self) -> Option<f64> {
        self.of.noise.and_then(Noise::freedom_f64)
    }

    /// How many times as large as estimated the noise is, in one draw.
    fn estimate(&self, random: &mut ChaCha8Rng) -> f64 {
        let estimate = self.freedom().and_then(|freedom| {
            let spread = ChiSquared::new(freedom).ok()?.sample(random);
            Some((freedom / spread).sqrt())
        });
        estimate.unwrap_or(1.0)
    }

    /// One draw of what another measurement does not repeat, with so many times the noise; how many times the laser acts
    /// that it repeats.
    fn drawn(&self, noise: f64, random: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
        let (z, mut shares) = self.of.model.draw(noise, random);
        let laser = self.laser.map_or(0.0, |at| std::mem::take(&mut shares[at]));
        let mut drawn = self.moved_by(&z);
        let causes = shares.iter().zip(&self.by_cause).filter(|(times, _)| **times != 0.0);
        causes.for_each(|(times, part)| add(&mut drawn, *times, part));
        (drawn, laser)
    }

    /// What a draw of all that another measurement repeats does.
    fn repeated(&self, number: usize, angles: Vec<f64>) -> Vec<f64> {
        let mut values = angles;
        if let Some(at) = self.laser {
            let draw = StandardNormal.sample(&mut random(3 * DRAWS + number));
            add(&mut values, draw, &self.by_cause[at]);
        }
        values
    }

    /// What a draw of these angles does.
    fn angles(&self, number: usize, order: &[usize]) -> Vec<f64> {
        let mut random = random(DRAWS + number);
        let mut values = self.nothing();
        for cause in order {
            // Uniform, with a standard deviation of 1.
            let share: f64 = StandardUniform.sample(&mut random);
            add(&mut values, 12_f64.sqrt() * (share - 0.5), &self.by_cause[*cause]);
        }
        values
    }

    /// The largest |error| + times · u of each term.
    fn terms(&self, values: &[f64], times: f64, u: &[f64]) -> PerTerm<f64> {
        let mut terms = PerTerm::from_fn(|_| 0.0);
        for (index, curve) in self.curves.iter().enumerate() {
            let [own, u] = [values, u].map(|values| self.curve(values, index));
            terms[curve.term] = larger(terms[curve.term], largest(own, times, u));
        }
        terms
    }

    /// max − min along each diagonal.
    fn ranges(&self, values: &[f64]) -> PerDiagonal<f64> {
        let mut ranges = PerDiagonal::default();
        for (d, pass) in self.walks() {
            ranges[d] = larger(ranges[d], range(self.along(d, pass, values).into_iter()));
        }
        ranges
    }

    /// The passes that were walked.
    fn walks(&self) -> impl Iterator<Item = (Diagonal, Pass)> {
        let passes = Pass::BOTH.into_iter().take(self.of.model.layout.passes);
        passes.flat_map(|pass| Diagonal::ALL.map(|d| (d, pass)))
    }

    /// What these values make along the beam at the end of each cell.
    fn along(&self, d: Diagonal, pass: Pass, values: &[f64]) -> Curve {
        let (laser, last) = (self.of.volume.laser(d), self.of.volume.steps);
        let mut along = vec![0.0; self.points()];
        for (index, TableCurve { term, way, .. }) in self.curves.iter().enumerate() {
            if way.is_none_or(|way| way == d.travelled(term.along, pass)) {
                let (is_up, own) = (d.sign(term.along) > 0.0, self.curve(values, index));
                let ends = along.iter_mut().enumerate();
                ends.for_each(|(at, um)| {
                    *um += laser[term.of] * own[if is_up { at } else { last - at }];
                });
            }
        }
        along
    }

    fn sizes(&self, values: &[f64]) -> Sizes {
        Sizes { terms: self.terms(values, 0.0, values), diagonals: self.ranges(values) }
    }
}

fn random(stream: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(stream as u64);
    random
}

/// The 95 % quantile of draws.
fn quantile(mut draws: Vec<f64>) -> f64 {
    let place = draws.len() * 19 / 20;
    *draws.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The 95 % quantiles of all draws, one by one and of the largest.
fn quantiles(zero: String, draws: &[Sizes]) -> LargestErrors {
    let of = |um: &dyn Fn(&Sizes) -> f64| quantile(draws.iter().map(um).collect());
    LargestErrors {
        zero,
        all_um: of(&Sizes::all_um),
        ranges_um: of(&Sizes::ranges_um),
        single: Sizes {
            terms: PerTerm::from_fn(|term| of(&|sizes| sizes.terms[term])),
            diagonals: PerDiagonal::from_fn(|d| of(&|sizes| sizes.diagonals[d])),
        },
    }
}

/// Which directions stand apart.
pub(super) fn directions(separation: &Separation, job: &Job) -> PerAxis<Vec<Option<Direction>>> {
    PerAxis::from_fn(|axis| {
        let forward_only = job.compensation.backlash[axis] == Some(BacklashPolicy::ForwardOnly);
        match separation.is_directed(axis) {
            true => Direction::BOTH.map(Some).to_vec(),
            false if forward_only && separation.is_both_ways() => vec![Some(Direction::Plus)],
            false => vec![None],
        }
    })
}

/// A curve between its points.
pub(super) fn between(curve: &[f64], place: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation, reason = "a place in a list")]
    let below = place.floor() as usize;
    let low = curve.get(below).copied().unwrap_or(0.0);
    let high = curve.get(below + 1).copied().unwrap_or(low);
    low + (high - low) * place.fract()
}

/// Where the errors of a job are zero: its references, and the directions in which they are approached.
pub(crate) fn zero(job: &Job) -> String {
    let of = |axis: Axis| {
        let machine = job.machine.axes[axis]?;
        Some(format!("{axis} {} {}", machine.reference.mm(), machine.homing().symbol()))
    };
    joined(Axis::ALL.into_iter().filter_map(of))
}
