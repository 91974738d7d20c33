//! How far the largest of all errors may lie off: readings, lines and stated causes are drawn together, so what
//! errors share counts once and not for every point anew.
//!
//! ```text
//!   q = 95 % quantile of max over the points of |e(x) − e(reference)|,   e = row · z,   z drawn
//!   noise normal, its σ by χ² where it was estimated;  lines, scales, tilts normal;  angles uniform
//! ```
//! |value + e| is then at most the largest |value| + q, with 95 % (`docs/method.md` §23).

mod outlook;

pub(crate) use self::outlook::Measured;
use super::curves::Curve;
use super::linear::CurveRows;
use super::noise::float;
use super::separate::Separation;
use crate::inputs::error_table::{LargestErrors, Sizes};
use crate::inputs::job::{BacklashPolicy, Job, MachineAxis};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal};
use crate::quantity::units::larger;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Of 1,000 draws the 95 % quantile is known to 2 %.
const DRAWS: usize = 1000;
const SEED: u64 = 23;

/// One curve of a table.
struct TableCurve {
    term: ErrorTerm,
    way: Option<Direction>,
    rows: CurveRows,
    /// Standard deviation of what all of it but the first point lacks, µm.
    lacks_um: f64,
    /// Where it stands among the curves that is zero at the reference, and the place of that, in steps.
    zero: (usize, f64),
}

/// The curves of a table, to be drawn.
pub(super) struct Table<'a> {
    of: &'a Separation,
    curves: Vec<TableCurve>,
    /// Along each diagonal, both passes: curves, their shares along the beam, and whether they run upwards.
    walks: PerDiagonal<Vec<Vec<(usize, f64, bool)>>>,
}

impl Table<'_> {
    /// The largest errors; `None` where an uncertainty is not known.
    pub(super) fn largest_errors(&self, job: &Job) -> Option<LargestErrors> {
        if !self.is_known() {
            return None;
        }
        let none = vec![Vec::new()];
        let angles = &self.of.model.angles;
        let orders = if angles.is_empty() { &none } else { angles };
        let mut largest = LargestErrors { zero: zero(job), ..LargestErrors::default() };
        for order in orders {
            let sizes: Vec<Sizes> =
                (0..DRAWS).map(|number| self.sizes(&self.drawn(number, order))).collect();
            let raise = |own: &mut f64, of: &dyn Fn(&Sizes) -> f64| {
                let mut all: Vec<f64> = sizes.iter().map(of).collect();
                all.sort_by(f64::total_cmp);
                *own = larger(*own, all[DRAWS * 19 / 20]);
            };
            raise(&mut largest.all_um, &Sizes::all_um);
            raise(&mut largest.ranges_um, &Sizes::ranges_um);
            for term in ErrorTerm::ALL {
                raise(&mut largest.single.terms[term], &|s| s.terms[term]);
            }
            for d in Diagonal::ALL {
                raise(&mut largest.single.diagonals[d], &|s| s.diagonals[d]);
            }
        }
        Some(largest)
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
                let rows = self.curves.iter().map(|curve| &curve.rows);
                let moved: Vec<Curve> = rows.map(|rows| rows.values(z, rows.line.dot(z))).collect();
                worst = worst.joined(&self.sizes(&moved), larger);
            }
            all = all.joined(&worst, |all, own| all + own);
        }
        (all.all_um().max(all.ranges_um()) > 0.0).then_some(all)
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
                    rows: found.rows.merged(),
                    lacks_um: found.left_out.sqrt(),
                    zero: (zero, at),
                });
            }
        }
        let walk = |d: Diagonal, pass: Pass| {
            let laser = of.volume.laser(d);
            let is_on_it = |curve: &TableCurve| {
                curve.way.is_none_or(|way| way == d.travelled(curve.term.along, pass))
            };
            let own = curves.iter().enumerate().filter(|(_, curve)| is_on_it(curve));
            let share = |(index, curve): (usize, &TableCurve)| {
                (index, laser[curve.term.of], d.forward(curve.term.along) == Direction::Plus)
            };
            own.map(share).collect()
        };
        let walks = PerDiagonal::from_fn(|d| {
            let mut both = Pass::BOTH.map(|pass| walk(d, pass)).to_vec();
            both.dedup();
            both
        });
        Table { of, curves, walks }
    }

    /// The curves of one draw.
    fn drawn(&self, number: usize, order: &[usize]) -> Vec<Curve> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(number as u64);
        let freedom = self.of.noise.and_then(|noise| noise.freedom);
        let off = freedom.and_then(|freedom| {
            let spread = ChiSquared::new(float(freedom)).ok()?.sample(&mut random);
            Some((float(freedom) / spread).sqrt())
        });
        let z = self.of.model.draw(off.unwrap_or(1.0), order, &mut random);
        self.of_entries(&z, &mut random)
    }

    /// The curves of what was measured, and what they lack beside it.
    fn of_entries(&self, z: &[f64], random: &mut ChaCha8Rng) -> Vec<Curve> {
        let curve = |curve: &TableCurve| {
            let draw: f64 = StandardNormal.sample(random);
            let mut values = curve.rows.values(z, curve.rows.line.dot(z));
            values.iter_mut().for_each(|um| *um += curve.lacks_um * draw);
            values
        };
        self.curves.iter().map(curve).collect()
    }

    fn sizes(&self, drawn: &[Curve]) -> Sizes {
        let mut sizes = Sizes::default();
        for (curve, values) in self.curves.iter().zip(drawn) {
            let (zero, place) = curve.zero;
            let zero = at(&drawn[zero], place);
            let own = values.iter().map(|um| (um - zero).abs()).fold(0.0, larger);
            sizes.terms[curve.term] = larger(sizes.terms[curve.term], own);
        }
        let range = |walk: &Vec<(usize, f64, bool)>| {
            let last = self.of.volume.steps;
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for step in 0..=last {
                let mut um = 0.0;
                for (index, share, is_up) in walk {
                    um += share * drawn[*index][if *is_up { step } else { last - step }];
                }
                (low, high) = (low.min(um), high.max(um));
            }
            high - low
        };
        sizes.diagonals =
            PerDiagonal::from_fn(|d| self.walks[d].iter().map(range).fold(0.0, larger));
        sizes
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
fn at(curve: &[f64], place: f64) -> f64 {
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
