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

pub(crate) use self::outlook::{AfterLoading, Outlook, Values};
use super::Separation;
use super::readings::{Noise, student};
use super::solved::SeparatedError;
use crate::inputs::error_table::{LargestErrors, Remarks, Sizes};
use crate::inputs::job::{BacklashPolicy, Job};
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Pass, PerAxis, PerDiagonal, PerTerm, larger,
};
use crate::text::joined;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nonius_numerics::draws::{self, Curves, LANES, Lanes, alike, sum};
use nonius_numerics::rows::{Row, Variance};
use nonius_numerics::threads;
use rand_distr::{ChiSquared, Distribution, StandardNormal, StandardUniform};
use std::array::from_fn;

/// Of 1,000 draws the 95 % quantile is known to 2 %.
const DRAWS: usize = 1000;
const SEED: u64 = 23;
/// Probability behind every bound.
const CONFIDENCE: f64 = 0.95;

/// One curve of a table.
struct TableCurve {
    term: ErrorTerm,
    way: Option<Direction>,
    /// Where it stands among the curves that is zero at the reference, and the place of that, in steps.
    zero: (usize, f64),
}

/// The curves of a table, to be drawn. All their values stand in one list, curve after curve, zero at the reference.
pub(super) struct JointTable<'a> {
    of: &'a Separation,
    curves: Vec<TableCurve>,
    /// Less the value at the reference.
    rows: Curves<'a>,
    /// As measured, µm.
    um: Vec<f64>,
    /// The cause that another measurement with the same laser repeats.
    laser: Option<usize>,
}

/// How many times causes act.
type Acting = Vec<(usize, Lanes)>;

/// Draws of a table, [`LANES`] at a time.
struct Draws {
    /// The values of all curves, without angles.
    values: Vec<Vec<Lanes>>,
    /// Of what another measurement repeats: angles, one after the other, then the laser.
    repeated: Vec<Acting>,
}

impl Separation {
    /// How far the largest error of the table of a job may lie off in a forecast, with max − min along the diagonals where
    /// it is asked for; of errors with a known uncertainty alone, `None` without any.
    pub(crate) fn largest(&self, job: &Job, diagonals: bool) -> Option<LargestErrors> {
        let table = JointTable::with(self, job, |found| found.u.is_some());
        table.drawn().map(|drawn| table.largest(job, &drawn, diagonals))
    }

    /// Whether the table of a job holds one of the measured directions of an axis alone.
    pub(crate) fn is_one_way(&self, job: &Job) -> bool {
        directions(self, job).iter().any(|(_, ways)| matches!(ways.as_slice(), [Some(_)]))
    }
}

impl<'a> JointTable<'a> {
    /// Says of a table how far its errors may lie off, with 95 %, and what may falsify them; nothing of the former where
    /// an uncertainty is not known.
    pub(super) fn remarks(&self, job: &Job, said: Remarks) -> Remarks {
        let said = Remarks { doubtful: self.doubtful(), ..said };
        let Some(drawn) = self.drawn() else { return said };
        let u: Vec<f64> = self.variances(|of| of.all).into_iter().map(f64::sqrt).collect();
        let mut with_laser = u.clone();
        if let Some(at) = self.laser {
            let laser = self.rows.made_by(&[(at, [1.0; LANES])]);
            with_laser.iter_mut().zip(&laser).for_each(|(u, [um, ..])| *u = u.hypot(*um));
        }
        let sizes_of = |u: &[f64]| {
            let terms = self.terms(&self.rows.made_by(&[]), &[], [1.0; LANES], u);
            let [sizes, ..] = sizes(&terms, &PerDiagonal::from_fn(|_| [0.0; LANES]));
            sizes
        };
        let instrument = job.measurement.instrument.clone().filter(|_| self.laser.is_some());
        Remarks {
            largest: Some(self.largest(job, &drawn, true)),
            measured: Some(self.measured(job, &drawn, &u)),
            anew: (!self.of.model.angles.is_empty()).then(|| sizes_of(&with_laser)),
            same_laser: instrument.map(|instrument| (instrument, sizes_of(&u))),
            ..said
        }
    }

    /// Draws of all curves; `None` where an uncertainty is not known.
    fn drawn(&self) -> Option<Draws> {
        let anew = |first| {
            let mut random = randoms(first);
            let noise = random.each_mut().map(|random| self.estimate(random));
            self.rows.drawn(noise, &mut random, None)
        };
        let repeated = || each(DRAWS, |first| self.repeated(first));
        self.is_known().then(|| Draws { values: each(DRAWS, anew), repeated: repeated() })
    }

    /// Something of u² of each value, without angles and what the laser repeats.
    fn variances(&self, of: impl Fn(Variance) -> f64) -> Vec<f64> {
        let mut model = self.of.model.clone();
        model.angles.clear();
        self.laser.into_iter().for_each(|at| model.causes[at].variance = 0.0);
        self.rows.rows.iter().flat_map(|rows| rows.variances(&model)).map(of).collect()
    }

    /// How far the largest may lie off in a forecast.
    fn largest(&self, job: &Job, drawn: &Draws, diagonals: bool) -> LargestErrors {
        let nothing = PerDiagonal::from_fn(|_| [0.0; LANES]);
        self.quantiles(job, drawn, |at, acting| {
            let values = &drawn.values[at];
            let angles = acting.len() - usize::from(self.laser.is_some());
            let left = self.terms(values, &acting[..angles], [0.0; LANES], &self.um);
            let ranges = if diagonals { self.ranges(values) } else { nothing };
            sizes(&left, &ranges)
        })
    }

    /// How far it may lie beyond the largest that was measured; `u`: of each value, without what another measurement
    /// repeats, by the noise as estimated.
    fn measured(&self, job: &Job, drawn: &Draws, u: &[f64]) -> LargestErrors {
        let at_most = self.ranges_at_most();
        let at_most = PerDiagonal::from_fn(|d| [at_most[d]; LANES]);
        let times = |first: usize| {
            let mut random = randoms(2 * DRAWS + first);
            from_fn(|lane| {
                let share = (first + lane) as f64 + 0.5;
                student(share / DRAWS as f64, None) * self.estimate(&mut random[lane])
            })
        };
        let repeats_nothing = drawn.repeated.iter().all(Vec::is_empty);
        let times: Vec<Lanes> = match repeats_nothing {
            true => vec![[student(CONFIDENCE, self.freedom()); LANES]; drawn.values.len()],
            false => each(DRAWS, times),
        };
        let measured = alike(&self.um);
        let found = self.quantiles(job, drawn, |at, acting| {
            sizes(&self.terms(&measured, acting, times[at], u), &at_most)
        });
        found.joined(&quantiles(zero(job), &[self.sizes(&measured)]), |a, b| a - b)
    }

    /// The 95 % quantiles of something of all draws, in that order of the axes in which they are largest.
    fn quantiles(
        &self,
        job: &Job,
        drawn: &Draws,
        of: impl Fn(usize, &[(usize, Lanes)]) -> [Sizes; LANES] + Sync,
    ) -> LargestErrors {
        let angles = &self.of.model.angles;
        let orders = if angles.is_empty() { &vec![Vec::new()] } else { angles };
        let of_order = |order: &Vec<usize>| {
            let of = |first| of(first / LANES, &acting(order, &drawn.repeated[first / LANES]));
            quantiles(zero(job), each(DRAWS, of).as_flattened())
        };
        let none = LargestErrors { zero: zero(job), ..LargestErrors::default() };
        orders.iter().map(of_order).fold(none, |worst, own| worst.joined(&own, larger))
    }

    /// What max − min along each diagonal was at most: its readings are direct, whatever the separation makes of them.
    fn ranges_at_most(&self) -> PerDiagonal<f64> {
        let (model, times) = (&self.of.model, student(CONFIDENCE, self.freedom()));
        let (um, mut ranges) = (alike(&self.um), PerDiagonal::default());
        for (d, pass) in self.walks() {
            let along = sum(self.points(), self.along(d, pass, &um));
            let at = |step: usize| model.layout.reading(pass, d, 3 * step);
            for (i, [low, ..]) in along.iter().enumerate() {
                for (j, [high, ..]) in along.iter().enumerate().skip(i + 1) {
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
            let sizes = causes.iter().map(|z| self.sizes(&self.rows.moved_by(&alike(z))));
            sizes.fold(Sizes::default(), |worst, own| worst.joined(&own, larger))
        };
        let each = self.of.anomalies.iter().map(worst);
        let all = each.fold(Sizes::default(), |all, own| all.joined(&own, |all, own| all + own));
        (all.all_um().max(all.ranges_um()) > 0.0).then_some(all)
    }

    pub(super) fn new(of: &'a Separation, job: &Job) -> JointTable<'a> {
        JointTable::with(of, job, |_| true)
    }

    fn with(
        of: &'a Separation,
        job: &Job,
        holds: impl Fn(&SeparatedError) -> bool,
    ) -> JointTable<'a> {
        let directions = directions(of, job);
        let (mut curves, mut all_rows, mut um) = (Vec::new(), Vec::new(), Vec::new());
        for term in ErrorTerm::ALL {
            let machine = job.machine.axes[term.along];
            let homing = machine.map(|axis| axis.homing());
            let ways = &directions[term.along];
            // Where the reference lies, in steps; the end that is nearest to one beyond.
            let (start, step) = (of.volume.start[term.along].mm(), of.volume.step_mm(term.along));
            let at = machine.map_or(0.0, |axis| (axis.reference.mm() - start) / step);
            let at = at.clamp(0.0, of.volume.steps_f64());
            let all = ways.iter().filter_map(|way| Some((*way, of.of_table(term, *way)?)));
            let all: Vec<_> = all.filter(|(_, found)| holds(found)).collect();
            let zero = all.iter().position(|(way, _)| *way == homing).unwrap_or(0);
            let Some((_, reference)) = all.get(zero) else { continue };
            let (zero_um, zero_row) = (between(&reference.deviation_um, at), reference.rows.at(at));
            let zero = (curves.len() + zero, at);
            for (way, found) in all {
                um.extend(found.deviation_um.iter().map(|um| um - zero_um));
                let mut rows = found.rows.merged();
                rows.start = Row::sum([(1.0, &rows.start), (-1.0, &zero_row)]).merged();
                curves.push(TableCurve { term, way, zero });
                all_rows.push(rows);
            }
        }
        let laser = of.model.laser.filter(|_| job.measurement.instrument.is_some());
        JointTable { of, curves, rows: Curves::new(&of.model, all_rows), um, laser }
    }

    /// Values of each curve.
    fn points(&self) -> usize {
        self.of.volume.steps + 1
    }

    /// One of the curves.
    fn curve<'v, T>(&self, values: &'v [T], index: usize) -> &'v [T] {
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

    /// What draws of all that another measurement repeats are: angles, one after the other, and the laser.
    fn repeated(&self, first: usize) -> Acting {
        let (mut of_angles, mut of_laser) = (randoms(DRAWS + first), randoms(3 * DRAWS + first));
        let angles = self.of.model.angles.first().into_iter().flatten();
        let laser =
            self.laser.map(|at| (at, of_laser.each_mut().map(|of| StandardNormal.sample(of))));
        angles.map(|at| (*at, uniform(&mut of_angles))).chain(laser).collect()
    }

    /// max of |value + what causes make that act so many times| + times · u of each term.
    fn terms(
        &self,
        values: &[Lanes],
        causes: &[(usize, Lanes)],
        times: Lanes,
        u: &[f64],
    ) -> PerTerm<Lanes> {
        let mut terms = PerTerm::from_fn(|_| [0.0; LANES]);
        let each = self.curves.iter().zip(self.rows.largest(values, causes, times, u));
        each.for_each(|(curve, own)| terms[curve.term] = draws::larger(terms[curve.term], &own));
        terms
    }

    /// max − min along each diagonal.
    fn ranges(&self, values: &[Lanes]) -> PerDiagonal<Lanes> {
        let mut ranges = PerDiagonal::from_fn(|_| [0.0; LANES]);
        for (d, pass) in self.walks() {
            let own = draws::range(&sum(self.points(), self.along(d, pass, values)));
            ranges[d] = draws::larger(ranges[d], &own);
        }
        ranges
    }

    /// The passes that were walked.
    fn walks(&self) -> impl Iterator<Item = (Diagonal, Pass)> {
        let passes = Pass::BOTH.into_iter().take(self.of.model.layout.passes);
        passes.flat_map(|pass| Diagonal::ALL.map(|d| (d, pass)))
    }

    /// What makes the displacement along the beam at the end of each cell: so many times a curve, from its low end on or from
    /// its high one.
    fn along<'v>(
        &'v self,
        d: Diagonal,
        pass: Pass,
        values: &'v [Lanes],
    ) -> impl Iterator<Item = (f64, bool, &'v [Lanes])> {
        let laser = self.of.volume.laser(d);
        let each =
            self.curves.iter().enumerate().filter(move |(_, TableCurve { term, way, .. })| {
                way.is_none_or(|way| way == d.travelled(term.along, pass))
            });
        each.map(move |(index, TableCurve { term, .. })| {
            (laser[term.of], d.sign(term.along) > 0.0, self.curve(values, index))
        })
    }

    fn sizes(&self, values: &[Lanes]) -> Sizes {
        let [sizes, ..] =
            sizes(&self.terms(values, &[], [0.0; LANES], &self.um), &self.ranges(values));
        sizes
    }
}

/// The same angles where the axes stand in another order.
fn acting(order: &[usize], repeated: &Acting) -> Acting {
    let mut acting = repeated.clone();
    acting.iter_mut().zip(order).for_each(|((at, _), own)| *at = *own);
    acting
}

/// Something of all draws, [`LANES`] at a time.
fn each<T: Send>(draws: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    threads::of_numbers(draws, LANES, of)
}

/// A generator for each of some draws.
fn randoms(first: usize) -> [ChaCha8Rng; LANES] {
    from_fn(|lane| random(first + lane))
}

fn random(stream: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(stream as u64);
    random
}

/// Uniform, with a standard deviation of 1.
fn uniform(random: &mut [ChaCha8Rng; LANES]) -> Lanes {
    random.each_mut().map(|random| {
        let share: f64 = StandardUniform.sample(random);
        12_f64.sqrt() * (share - 0.5)
    })
}

/// Draw by draw.
fn sizes(terms: &PerTerm<Lanes>, diagonals: &PerDiagonal<Lanes>) -> [Sizes; LANES] {
    from_fn(|lane| Sizes {
        terms: PerTerm::from_fn(|term| terms[term][lane]),
        diagonals: PerDiagonal::from_fn(|d| diagonals[d][lane]),
    })
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
