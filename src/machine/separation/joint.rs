//! How far the largest of all errors may lie off: readings, lines and stated causes are drawn together, so what
//! errors share counts once and not for every point anew.
//!
//! ```text
//!   q = 95 % quantile of max over the points of |e(x) − e(reference)|,   e = row · z,   z drawn
//!   noise normal, its σ by χ² where it was estimated;  lines, scales, tilts normal;  angles uniform
//! ```
//! |value + e| is then at most the largest |value| + q, with 95 % (`docs/method.md` §23).

use super::curves::Curve;
use super::noise::float;
use super::separate::Separation;
use crate::inputs::error_table::LargestErrors;
use crate::inputs::job::{Job, MachineAxis};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal};
use crate::quantity::units::larger;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Of 2,000 draws the 95 % quantile is known to about 1 %.
const DRAWS: usize = 2000;
const SEED: u64 = 23;

/// The curves of a table: every term in the directions that its axis has, as drawn.
type Drawn = Vec<(ErrorTerm, Vec<(Option<Direction>, Curve)>)>;

impl Separation {
    /// The largest errors of the table in these directions; `None` where an uncertainty is not known.
    pub(super) fn largest_errors(
        &self,
        job: &Job,
        directions: &PerAxis<Vec<Option<Direction>>>,
    ) -> Option<LargestErrors> {
        let terms: Vec<ErrorTerm> = ErrorTerm::ALL
            .into_iter()
            .filter(|term| {
                directions[term.along].iter().any(|way| self.of_table(*term, *way).is_some())
            })
            .collect();
        let ways = |term: &ErrorTerm| directions[term.along].iter().copied();
        let all_known = terms.iter().all(|term| {
            ways(term).all(|way| self.of_table(*term, way).is_some_and(|e| e.rows.is_some()))
        });
        if !all_known || terms.is_empty() {
            return None;
        }
        let none = vec![Vec::new()];
        let orders = if self.model.angles.is_empty() { &none } else { &self.model.angles };
        let mut largest = LargestErrors { zero: zero(job), ..LargestErrors::default() };
        for order in orders {
            let drawn = (0..DRAWS).map(|number| self.drawn(number, order, &terms, directions));
            let sizes = drawn.map(|curves| self.sizes(job, &curves));
            let sizes: Vec<Sizes> = sizes.collect();
            let quantile = |of: &dyn Fn(&Sizes) -> f64| {
                let mut all: Vec<f64> = sizes.iter().map(of).collect();
                all.sort_by(f64::total_cmp);
                all.get(all.len() * 19 / 20).copied().unwrap_or(0.0)
            };
            largest.all_um = larger(largest.all_um, quantile(&|size| size.all_um()));
            let ranges = |size: &Sizes| size.diagonals.iter().map(|(_, um)| *um).fold(0.0, larger);
            largest.ranges_um = larger(largest.ranges_um, quantile(&ranges));
            for term in &terms {
                let um = quantile(&|size| size.terms[*term]);
                largest.terms[*term] = larger(largest.terms[*term], um);
            }
            for d in Diagonal::ALL {
                let um = quantile(&|size| size.diagonals[d]);
                largest.diagonals[d] = larger(largest.diagonals[d], um);
            }
        }
        Some(largest)
    }

    /// Errors of one draw.
    fn drawn(
        &self,
        number: usize,
        order: &[usize],
        terms: &[ErrorTerm],
        directions: &PerAxis<Vec<Option<Direction>>>,
    ) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(number as u64);
        let freedom = self.noise.and_then(|noise| noise.freedom);
        let off = freedom.and_then(|freedom| {
            let spread = ChiSquared::new(float(freedom)).ok()?.sample(&mut random);
            Some((float(freedom) / spread).sqrt())
        });
        let z = self.model.draw(off.unwrap_or(1.0), order, &mut random);
        let mut curve = |term: ErrorTerm, way: Option<Direction>| {
            let found = self.of_table(term, way)?;
            let rows = found.rows.as_ref()?;
            let draw: f64 = StandardNormal.sample(&mut random);
            let lacks = found.left_out.sqrt() * draw;
            let values = rows.values(&z, rows.line.dot(&z));
            Some((way, values.into_iter().map(|um| um + lacks).collect()))
        };
        let of = |term: &ErrorTerm| {
            let ways = directions[term.along].iter();
            (*term, ways.filter_map(|way| curve(*term, *way)).collect())
        };
        terms.iter().map(of).collect()
    }

    fn sizes(&self, job: &Job, curves: &Drawn) -> Sizes {
        let mut sizes = Sizes::default();
        for (term, ways) in curves {
            let machine = job.machine.axes[term.along];
            let homing = machine.map(|axis| axis.homing());
            let zero = ways.iter().find(|(way, _)| *way == homing).or(ways.first());
            let zero = zero.map_or(0.0, |(_, curve)| self.at_reference(*term, machine, curve));
            let all = ways.iter().flat_map(|(_, curve)| curve);
            sizes.terms[*term] = all.map(|um| (um - zero).abs()).fold(0.0, larger);
        }
        sizes.diagonals = PerDiagonal::from_fn(|d| {
            Pass::BOTH.map(|pass| self.range_along(d, pass, curves)).into_iter().fold(0.0, larger)
        });
        sizes
    }

    /// A curve at the reference, or at the end of it that is nearest.
    fn at_reference(&self, term: ErrorTerm, machine: Option<MachineAxis>, curve: &[f64]) -> f64 {
        let (start, step) = (self.volume.start[term.along].mm(), self.volume.step_mm(term.along));
        let last = float(curve.len().saturating_sub(1));
        let place = machine.map_or(0.0, |axis| (axis.reference.mm() - start) / step);
        let place = place.clamp(0.0, last);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place in a list"
        )]
        let below = place.floor() as usize;
        let low = curve.get(below).copied().unwrap_or(0.0);
        let high = curve.get(below + 1).copied().unwrap_or(low);
        low + (high - low) * place.fract()
    }

    /// Max − min of the deviation along a diagonal, its axes travelling as on that pass.
    fn range_along(&self, d: Diagonal, pass: Pass, curves: &Drawn) -> f64 {
        let laser = self.volume.laser(d);
        let last = self.volume.steps;
        let value = |step: usize| -> f64 {
            let of = |(term, ways): &(ErrorTerm, Vec<(Option<Direction>, Curve)>)| {
                let way = Some(d.travelled(term.along, pass));
                let own = ways.iter().find(|(own, _)| *own == way).or(ways.first());
                let is_up = d.forward(term.along) == Direction::Plus;
                let index = if is_up { step } else { last - step };
                own.map_or(0.0, |(_, curve)| laser[term.of] * curve[index])
            };
            curves.iter().map(of).sum()
        };
        let values = (0..=last).map(value);
        let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), um| {
            (low.min(um), high.max(um))
        });
        ends.1 - ends.0
    }
}

/// The largest |error| of a draw, µm, and max − min along the diagonals.
#[derive(Default)]
struct Sizes {
    terms: PerTerm<f64>,
    diagonals: PerDiagonal<f64>,
}

impl Sizes {
    fn all_um(&self) -> f64 {
        self.terms.iter().map(|(_, um)| *um).fold(0.0, larger)
    }
}

/// Where the errors of a job are zero: its references, and the directions in which they are approached.
pub(crate) fn zero(job: &Job) -> String {
    let of = |axis: Axis| {
        let machine = job.machine.axes[axis]?;
        Some(format!("{axis} {} {}", machine.reference.mm(), machine.homing().symbol()))
    };
    Axis::ALL.into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
}
