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
//! |value + e| is then at most the largest |value| + q, with 95 % (`docs/method.md` §23). The nine errors together
//! are the readings of the diagonals: what an unmeasured angle does to each of them cancels there.

mod outlook;

pub(crate) use self::outlook::Measured;
use super::curves::{Curve, range};
use super::linear::CurveRows;
use super::noise::{Noise, student};
use super::separate::Separation;
use crate::inputs::error_table::{LargestErrors, Sizes};
use crate::inputs::job::{BacklashPolicy, Job, MachineAxis};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal};
use crate::quantity::units::{Squared, larger};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
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
    um: Curve,
    rows: CurveRows,
    /// Where it stands among the curves that is zero at the reference, and the place of that, in steps.
    zero: (usize, f64),
}

/// A pass along a diagonal: the curves on it, their shares along the beam, and whether they run upwards.
struct TableWalk {
    diagonal: Diagonal,
    pass: Pass,
    parts: Vec<(usize, f64, bool)>,
}

/// The curves of a table, to be drawn.
pub(super) struct Table<'a> {
    of: &'a Separation,
    curves: Vec<TableCurve>,
    /// What each cause makes of each curve.
    by_cause: Vec<Vec<Curve>>,
    /// The cause that another measurement with the same laser repeats.
    laser: Option<usize>,
    walks: Vec<TableWalk>,
}

/// How far the errors of a table may lie off, with 95 %.
#[derive(Default)]
pub(super) struct Largest {
    /// What is left where a table takes them off.
    pub(super) forecast: Option<LargestErrors>,
    /// As they were measured, beyond the largest value.
    pub(super) measured: Option<LargestErrors>,
    /// Their largest u by what another measurement does not repeat, µm; `None` = it repeats nothing.
    pub(super) anew: Option<Sizes>,
    /// The same of one with the same laser; `None` = which it is is not stated.
    pub(super) same_laser: Option<Sizes>,
}

impl Table<'_> {
    /// The largest errors; nothing where an uncertainty is not known.
    pub(super) fn largest(&self, job: &Job) -> Largest {
        if !self.is_known() {
            return Largest::default();
        }
        let none = [Vec::new()];
        let angles = &self.of.model.angles[..];
        let orders = if angles.is_empty() { &none[..] } else { angles };
        let mut squares = self.nothing();
        let mut sizes = vec![Vec::with_capacity(DRAWS); orders.len()];
        for number in 0..DRAWS {
            let (mut anew, laser) = self.anew(number);
            for (index, square) in squares.iter_mut().enumerate() {
                let zero = self.zero(&anew, index);
                square.iter_mut().zip(&anew[index]).for_each(|(s, um)| *s += (um - zero).squared());
            }
            self.add(&mut anew, laser.into_iter());
            let single = self.sizes(&anew);
            for (order, sizes) in orders.iter().zip(&mut sizes) {
                let all = self.with_angles(anew.clone(), number, order);
                let terms = if order.is_empty() { single.terms.clone() } else { self.terms(&all) };
                sizes.push(Sizes { terms, ..single.clone() });
            }
        }
        let u = |square: &Curve| square.iter().map(|s| (s / DRAWS as f64).sqrt()).collect();
        let u: Vec<Curve> = squares.iter().map(u).collect();
        let sizes_of = |u: &[Curve]| {
            let of_u = |largest: Sizes, (curve, u): (&TableCurve, &Curve)| {
                let mut own = Sizes::default();
                own.terms[curve.term] = u.iter().copied().fold(0.0, larger);
                largest.joined(&own, larger)
            };
            self.curves.iter().zip(u).fold(Sizes::default(), of_u)
        };
        let mut with_laser = u.clone();
        for (index, u) in with_laser.iter_mut().enumerate() {
            for moved in self.laser.iter().map(|at| &self.by_cause[*at]) {
                let zero = self.zero(moved, index);
                u.iter_mut().zip(&moved[index]).for_each(|(u, um)| *u = u.hypot(um - zero));
            }
        }
        let worst = |of_orders: Vec<Vec<Sizes>>| {
            let each = of_orders.iter().map(|draws| quantiles(zero(job), draws));
            each.reduce(|one, other| one.joined(&other, larger))
        };
        let values: Vec<Curve> = self.curves.iter().map(|curve| curve.um.clone()).collect();
        let diagonals = self.ranges_at_most(&values);
        let measured = |order: &Vec<usize>| self.measured(order, (&values, &u), diagonals);
        let measured = orders.iter().map(measured).collect();
        let values = quantiles(zero(job), &[self.sizes(&values)]);
        Largest {
            forecast: worst(sizes),
            measured: worst(measured).map(|at_most| at_most.joined(&values, |a, b| a - b)),
            anew: (!angles.is_empty()).then(|| sizes_of(&with_laser)),
            same_laser: self.laser.map(|_| sizes_of(&u)),
        }
    }

    /// What the errors as measured are at most, in each draw.
    fn measured(
        &self,
        order: &[usize],
        (values, u): (&[Curve], &[Curve]),
        diagonals: PerDiagonal<f64>,
    ) -> Vec<Sizes> {
        let at_most = |number: usize| {
            let times = match self.repeats_nothing(order) {
                true => student(CONFIDENCE, self.freedom()),
                false => {
                    let share = (number as f64 + 0.5) / DRAWS as f64;
                    student(share, None) * self.estimate(&mut random(2 * DRAWS + number))
                }
            };
            let drawn = self.repeated(values.to_vec(), number, order);
            let mut sizes = Sizes { diagonals, ..Sizes::default() };
            for (index, (curve, own)) in self.curves.iter().zip(&drawn).enumerate() {
                let zero = self.zero(&drawn, index);
                let all = own.iter().zip(&u[index]).map(|(um, u)| (um - zero).abs() + times * u);
                let size = &mut sizes.terms[curve.term];
                *size = all.fold(*size, larger);
            }
            sizes
        };
        let draws = if self.repeats_nothing(order) { 1 } else { DRAWS };
        (0..draws).map(at_most).collect()
    }

    /// What max − min along each diagonal was at most: its readings are direct, whatever the separation makes of them.
    fn ranges_at_most(&self, values: &[Curve]) -> PerDiagonal<f64> {
        let (model, times) = (&self.of.model, student(CONFIDENCE, self.freedom()));
        let mut ranges = PerDiagonal::default();
        for walk in &self.walks {
            let along = self.along(walk, values);
            let at = |step: usize| model.layout.reading(walk.pass, walk.diagonal, 3 * step);
            for (i, low) in along.iter().enumerate() {
                for (j, high) in along.iter().enumerate().skip(i + 1) {
                    let u = model.u_of_difference(at(i), at(j));
                    let range = &mut ranges[walk.diagonal];
                    *range = larger(*range, (high - low).abs() + times * u);
                }
            }
        }
        ranges
    }

    /// Whether there are curves, and every uncertainty is known.
    fn is_known(&self) -> bool {
        let known = |curve: &TableCurve| {
            self.of.of_table(curve.term, curve.way).is_some_and(|found| found.u_um.is_some())
        };
        !self.curves.is_empty() && self.curves.iter().all(known)
    }

    /// How far what speaks against the result by its size may move the errors: each anomaly by its worst cause,
    /// all anomalies added; `None` where nothing speaks against it.
    pub(super) fn doubtful(&self) -> Option<Sizes> {
        let mut all = Sizes::default();
        for causes in &self.of.anomalies {
            let mut worst = Sizes::default();
            for z in causes {
                let moved: Vec<Curve> = self.curves.iter().map(|curve| curve.moved_by(z)).collect();
                worst = worst.joined(&self.sizes(&moved), larger);
            }
            all = all.joined(&worst, |all, own| all + own);
        }
        (all.all_um().max(all.ranges_um()) > 0.0).then_some(all)
    }
}

impl TableCurve {
    fn moved_by(&self, z: &[f64]) -> Curve {
        self.rows.values(z, self.rows.line.dot(z))
    }
}

impl<'a> Table<'a> {
    pub(super) fn new(
        of: &'a Separation,
        job: &Job,
        directions: &PerAxis<Vec<Option<Direction>>>,
    ) -> Table<'a> {
        let mut curves: Vec<TableCurve> = Vec::new();
        for term in ErrorTerm::ALL {
            let machine = job.machine.axes[term.along];
            let homing = machine.map(|axis| axis.homing());
            let ways = &directions[term.along];
            let zero = ways.iter().position(|way| *way == homing).unwrap_or(0) + curves.len();
            let at = of.place_of_reference(term, machine);
            for way in ways {
                let Some(found) = of.of_table(term, *way) else { continue };
                curves.push(TableCurve {
                    term,
                    way: *way,
                    um: found.deviation_um.clone(),
                    rows: found.rows.merged(),
                    zero: (zero, at),
                });
            }
        }
        let walk = |diagonal: Diagonal, pass: Pass| {
            let laser = of.volume.laser(diagonal);
            let is_on_it = |curve: &TableCurve| {
                curve.way.is_none_or(|way| way == diagonal.travelled(curve.term.along, pass))
            };
            let own = curves.iter().enumerate().filter(|(_, curve)| is_on_it(curve));
            let share = |(index, curve): (usize, &TableCurve)| {
                let is_up = diagonal.forward(curve.term.along) == Direction::Plus;
                (index, laser[curve.term.of], is_up)
            };
            TableWalk { diagonal, pass, parts: own.map(share).collect() }
        };
        let passes = Pass::BOTH.into_iter().take(of.model.layout.passes);
        let walks = passes.flat_map(|pass| Diagonal::ALL.map(|d| walk(d, pass))).collect();
        let by_cause = of.model.columns.iter();
        let by_cause =
            by_cause.map(|column| curves.iter().map(|curve| curve.moved_by(column)).collect());
        let laser = of.model.laser.filter(|_| job.measurement.instrument.is_some());
        Table { of, by_cause: by_cause.collect(), laser, curves, walks }
    }

    fn nothing(&self) -> Vec<Curve> {
        self.curves.iter().map(|curve| vec![0.0; curve.um.len()]).collect()
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

    fn repeats_nothing(&self, angles: &[usize]) -> bool {
        angles.is_empty() && self.laser.is_none()
    }

    /// One draw of what another measurement does not repeat; how many times the laser acts that it repeats.
    fn anew(&self, number: usize) -> (Vec<Curve>, Option<(usize, f64)>) {
        let mut random = random(number);
        let noise = self.estimate(&mut random);
        self.drawn(noise, &mut random)
    }

    /// The same with so many times the noise.
    fn drawn(&self, noise: f64, random: &mut ChaCha8Rng) -> (Vec<Curve>, Option<(usize, f64)>) {
        let (z, mut shares) = self.of.model.draw(noise, random);
        let laser = self.laser.map(|at| (at, std::mem::take(&mut shares[at])));
        let mut drawn: Vec<Curve> = self.curves.iter().map(|curve| curve.moved_by(&z)).collect();
        self.add(&mut drawn, shares.into_iter().enumerate());
        (drawn, laser)
    }

    /// With a draw of all that another measurement repeats.
    fn repeated(&self, curves: Vec<Curve>, number: usize, angles: &[usize]) -> Vec<Curve> {
        let mut curves = self.with_angles(curves, number, angles);
        let draw = StandardNormal.sample(&mut random(3 * DRAWS + number));
        self.add(&mut curves, self.laser.map(|at| (at, draw)).into_iter());
        curves
    }

    /// With a draw of these angles.
    fn with_angles(&self, mut curves: Vec<Curve>, number: usize, order: &[usize]) -> Vec<Curve> {
        let mut random = random(DRAWS + number);
        // Uniform, with a standard deviation of 1.
        let even = |at: &usize| {
            let share: f64 = StandardUniform.sample(&mut random);
            (*at, 12_f64.sqrt() * (share - 0.5))
        };
        self.add(&mut curves, order.iter().map(even));
        curves
    }

    fn add(&self, curves: &mut [Curve], causes: impl Iterator<Item = (usize, f64)>) {
        for (cause, times) in causes.filter(|(_, times)| *times != 0.0) {
            for (curve, part) in curves.iter_mut().zip(&self.by_cause[cause]) {
                curve.iter_mut().zip(part).for_each(|(um, part)| *um += times * part);
            }
        }
    }

    /// The value at the reference of the curve that is zero there.
    fn zero(&self, curves: &[Curve], of: usize) -> f64 {
        let (zero, place) = self.curves[of].zero;
        at(&curves[zero], place)
    }

    fn terms(&self, curves: &[Curve]) -> PerTerm<f64> {
        let mut terms = PerTerm::from_fn(|_| 0.0);
        for (index, curve) in self.curves.iter().enumerate() {
            let zero = self.zero(curves, index);
            let own = curves[index].iter().map(|um| (um - zero).abs()).fold(0.0, larger);
            terms[curve.term] = larger(terms[curve.term], own);
        }
        terms
    }

    fn sizes(&self, curves: &[Curve]) -> Sizes {
        let mut sizes = Sizes { terms: self.terms(curves), ..Sizes::default() };
        for walk in &self.walks {
            let size = &mut sizes.diagonals[walk.diagonal];
            *size = larger(*size, range(self.along(walk, curves).into_iter()));
        }
        sizes
    }

    /// The sum of the curves along a pass, by cell.
    fn along(&self, walk: &TableWalk, curves: &[Curve]) -> Curve {
        let last = self.of.volume.steps;
        let at = |step: usize| {
            let part = |(index, share, is_up): &(usize, f64, bool)| {
                share * curves[*index][if *is_up { step } else { last - step }]
            };
            walk.parts.iter().map(part).sum()
        };
        (0..=last).map(at).collect()
    }
}

fn random(stream: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(stream as u64);
    random
}

/// The 95 % quantiles of all draws, one by one and of the largest.
fn quantiles(zero: String, draws: &[Sizes]) -> LargestErrors {
    let of = |um: &dyn Fn(&Sizes) -> f64| {
        let mut all: Vec<f64> = draws.iter().map(um).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() * 19 / 20]
    };
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
    let plus_only = |axis: Axis| {
        job.compensation.backlash[axis] == Some(BacklashPolicy::ForwardOnly)
            && separation.means.reverse.is_some()
    };
    PerAxis::from_fn(|axis| {
        if separation.is_directed(axis) {
            vec![Some(Direction::Plus), Some(Direction::Minus)]
        } else if plus_only(axis) {
            vec![Some(Direction::Plus)]
        } else {
            vec![None]
        }
    })
}

impl Separation {
    /// Where the reference of an axis lies on its curves, in steps; the end that is nearest to one beyond.
    fn place_of_reference(&self, term: ErrorTerm, machine: Option<MachineAxis>) -> f64 {
        let (start, step) = (self.volume.start[term.along].mm(), self.volume.step_mm(term.along));
        let place = machine.map_or(0.0, |axis| (axis.reference.mm() - start) / step);
        place.clamp(0.0, self.volume.steps_f64())
    }
}

/// A curve between its points.
pub(super) fn at(curve: &[f64], place: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in a list")]
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
    Axis::ALL.into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
}
