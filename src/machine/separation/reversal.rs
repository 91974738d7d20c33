//! Reversal of each axis from the turn at the end of the diagonals.
//!
//! Where the axes do not run over the far end before the reverse pass, the last node is the same
//! place without any motion, and each of the three first moves back takes up the lost motion of
//! its axis. The jump of the reverse less the forward increment over that move is, for axis k,
//!
//! ```text
//!   J_dk = Σ_j s_dk s_dj (V_j/R) B_jk(e)      e = high end of k where s_dk = +, low end where s_dk = −
//!   u²(J_dk) = 2σ² (1/r forward + 1/r reverse)
//! ```
//! Jumps are differences of increments, so the zero of the reverse runs does not matter. For each
//! axis four jumps meet B_kk at the high end (three of them), B_kk at the low end (one), and two
//! cross terms, taken as constant along the axis. Cross terms that do not stand out of their noise
//! are left out and the rest is fitted again by weighted least squares. Nothing is taken from
//! sums of increments over the travel: their noise is several times that of the jumps.
//!
//! With overrun all axes have reversed before the first reading back, and only Σ_k (V_k/R) B_kk
//! and three combinations of cross terms can be seen: the reversal of a single axis is not
//! determined.

use super::increments::Means;
use super::noise::{Noise, chance_of, coverage_factor_for};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// Chance that a reversal, an offset or a jump is believed where there is only noise.
const FALSE_ALARM: f64 = 0.01;
/// Where both an offset and jumps stand out, one must be so many times as far out of its noise.
const CLEARLY: f64 = 3.0;
/// Standard deviation of rounding to 0.01 µm, the last digit of an instrument, µm.
const DIGIT_UM: f64 = 0.003;

/// A reversal and its standard uncertainty (k = 1; `None` = noise not known), µm.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Estimate {
    /// B: moving + minus moving −.
    pub um: f64,
    /// From the noise of the readings.
    pub u_um: Option<f64>,
}

/// Reversal at the turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// B of each term, the same along its axis: weighted least squares of the jumps at both ends.
    pub reversal: PerTerm<Estimate>,
    /// B of each positioning error at the low and the high end of its axis: what the curves hold.
    pub ends: PerAxis<[Estimate; 2]>,
    /// B of each axis from each diagonal alone, at the end where it turned, if nothing but the
    /// axis itself reverses.
    pub by_diagonal: PerDiagonal<PerAxis<Estimate>>,
    /// Probability of jumps at least as different where the reversal is constant along the axis;
    /// `None` = noise not known.
    pub constancy: PerAxis<Option<f64>>,
    /// Whether a term's reversal stands between its two curves: positioning errors, and cross
    /// terms whose reversal stands out of its noise.
    pub in_curves: PerTerm<bool>,
    /// B of each term at the low end of its axis, as the curves hold it, µm.
    low_um: PerTerm<f64>,
    /// The jumps' shares in it.
    low: PerTerm<PerDiagonal<f64>>,
    /// The jumps' shares in B of each positioning error at the high end.
    high: PerAxis<PerDiagonal<f64>>,
}

impl Turn {
    /// B of a term along its axis, µm, from `walk_um`, the + curve less the − curve when both are
    /// zero at the low end. Of a positioning error both ends are known from the turn, and what the
    /// sum of increments is off at the high end is shared out evenly.
    pub fn along(&self, term: ErrorTerm, walk_um: &[f64]) -> Vec<f64> {
        let low = self.low_um[term];
        let last = walk_um.len().saturating_sub(1).max(1);
        let off = if term.is_positioning() {
            self.ends[term.along][1].um - low - walk_um.last().copied().unwrap_or(0.0)
        } else {
            0.0
        };
        #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 steps")]
        let at = |(index, walk): (usize, &f64)| low + walk + off * index as f64 / last as f64;
        walk_um.iter().enumerate().map(at).collect()
    }

    /// How B at the low end, and its growth to the high end as far as the turn tells it, hang on
    /// the jump along a diagonal.
    pub(super) fn shares(&self, term: ErrorTerm, diagonal: Diagonal) -> (f64, f64) {
        let low = self.low[term][diagonal];
        let growth = if term.is_positioning() {
            self.high[term.along][diagonal] - low
        } else {
            0.0
        };
        (low, growth)
    }
}

/// Jumps of every axis along every diagonal with their variances for readings of 1 µm.
struct Jumps {
    um: PerDiagonal<PerAxis<f64>>,
    variance: PerDiagonal<f64>,
}

fn jumps(means: &Means, volume: &Volume, runs: &PerDiagonal<[f64; 2]>) -> Option<Jumps> {
    let reverse = means.reverse.as_ref()?;
    let um = PerDiagonal::from_fn(|d| {
        PerAxis::from_fn(|axis| {
            let node = volume.node_after(axis, volume.steps - 1);
            let beside = |node: usize| reverse[d][node] - means.forward[d][node];
            beside(node) - beside(node - 1)
        })
    });
    let variance = PerDiagonal::from_fn(|d| 2.0 * (1.0 / runs[d][0] + 1.0 / runs[d][1]));
    Some(Jumps { um, variance })
}

/// Whether the axes ran over the far end, judged from the readings; `None` = they do not tell.
/// Without overrun forward and reverse reading of the last node are one place read twice, and the
/// reversals follow as jumps; with overrun the offset is there at once and nothing jumps. Both
/// are tested against the noise of the means.
pub(crate) fn ran_over(
    means: &Means,
    volume: &Volume,
    runs: &PerDiagonal<[f64; 2]>,
    noise: Noise,
) -> Option<bool> {
    let reverse = means.reverse.as_ref()?;
    let jumps = jumps(means, volume, runs)?;
    let sigma_um = noise.sigma_um.max(DIGIT_UM);
    let last = 3 * volume.steps;
    let offsets = Diagonal::ALL.map(|d| {
        let variance = sigma_um * sigma_um * jumps.variance[d] / 2.0;
        (means.forward[d][last] - reverse[d][last]).squared() / variance
    });
    let own = Axis::ALL.map(|axis| {
        let fit = Fit::new(volume, axis, &[Column::Own], &jumps);
        (fit.value(0) / (sigma_um * fit.spread(0))).squared()
    });
    let offset: f64 = offsets.iter().sum::<f64>() / 4.0;
    let jump: f64 = own.iter().sum::<f64>() / 3.0;
    let offset_shows = chance_of(4.0 * offset, 4, noise.freedom)? < FALSE_ALARM;
    let jump_shows = chance_of(3.0 * jump, 3, noise.freedom)? < FALSE_ALARM;
    match (offset_shows, jump_shows) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        (true, true) if offset > CLEARLY * CLEARLY * jump => Some(true),
        (true, true) if jump > CLEARLY * CLEARLY * offset => Some(false),
        _ => None,
    }
}

/// An unknown of a fit to the four jumps of an axis.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    /// B of the axis itself, the same at both ends.
    Own,
    /// B of the axis itself at one end: diagonals that travel it in + turn at the high one.
    OwnAt(Direction),
    /// B of a cross term.
    Cross(Axis),
}

impl Column {
    fn factor(self, volume: &Volume, along: Axis, d: Diagonal) -> f64 {
        match self {
            Column::Own => volume.cosine(along),
            Column::OwnAt(direction) if d.forward(along) == direction => volume.cosine(along),
            Column::OwnAt(_) => 0.0,
            Column::Cross(of) => d.sign(along) * d.sign(of) * volume.cosine(of),
        }
    }
}

/// Weighted least squares of the jumps of an axis.
struct Fit {
    /// Unknowns by jumps.
    gains: DMatrix<f64>,
    values: DVector<f64>,
    variance: [f64; 4],
    /// Σ residual²/variance for readings of 1 µm.
    left: f64,
}

impl Fit {
    fn new(volume: &Volume, along: Axis, columns: &[Column], jumps: &Jumps) -> Fit {
        let variance = Diagonal::ALL.map(|d| jumps.variance[d]);
        let jump = DVector::from_fn(4, |i, _| jumps.um[Diagonal::ALL[i]][along]);
        let design = DMatrix::from_fn(4, columns.len(), |i, j| {
            columns[j].factor(volume, along, Diagonal::ALL[i])
        });
        let weighed = DMatrix::from_fn(4, columns.len(), |i, j| design[(i, j)] / variance[i]);
        let normal = weighed.tr_mul(&design);
        // The columns are independent: edges have lengths, and every sign pattern is there once.
        let inverse = normal.try_inverse();
        let gains = inverse.map_or_else(
            || DMatrix::zeros(columns.len(), 4),
            |inverse| inverse * weighed.transpose(),
        );
        let values = &gains * &jump;
        let residual = jump - design * &values;
        let left = residual.iter().zip(variance).map(|(r, v)| r * r / v).sum();
        Fit {
            gains,
            values,
            variance,
            left,
        }
    }

    fn value(&self, unknown: usize) -> f64 {
        self.values[unknown]
    }

    /// Standard deviation for readings of 1 µm.
    fn spread(&self, unknown: usize) -> f64 {
        let part = |i: usize| self.gains[(unknown, i)].squared() * self.variance[i];
        (0..4).map(part).sum::<f64>().sqrt()
    }

    fn estimate(&self, unknown: usize, noise: Option<Noise>) -> Estimate {
        Estimate {
            um: self.value(unknown),
            u_um: noise.map(|noise| noise.sigma_um * self.spread(unknown)),
        }
    }

    fn shares(&self, unknown: usize) -> PerDiagonal<f64> {
        let mut column = (0..4).map(|i| self.gains[(unknown, i)]);
        PerDiagonal::from_fn(|_| column.next().unwrap_or(0.0))
    }
}

/// What the jumps of one axis say.
struct AxisTurn {
    all: Fit,
    at_ends: Fit,
    constant: Fit,
    /// The two cross axes, and those of them that stand out.
    others: [Axis; 2],
    kept: Vec<Axis>,
}

impl AxisTurn {
    fn new(volume: &Volume, along: Axis, jumps: &Jumps, noise: Option<Noise>) -> AxisTurn {
        let others = match along {
            Axis::X => [Axis::Y, Axis::Z],
            Axis::Y => [Axis::X, Axis::Z],
            Axis::Z => [Axis::X, Axis::Y],
        };
        let ends = [
            Column::OwnAt(Direction::Minus),
            Column::OwnAt(Direction::Plus),
        ];
        let fit = |own: &[Column], cross: &[Axis]| {
            let cross = cross.iter().map(|of| Column::Cross(*of));
            let columns: Vec<Column> = own.iter().copied().chain(cross).collect();
            Fit::new(volume, along, &columns, jumps)
        };
        let all = fit(&ends, &others);
        let stands_out = |place: usize| {
            noise.is_some_and(|noise| {
                let u = noise.sigma_um.max(DIGIT_UM) * all.spread(2 + place);
                let limit = coverage_factor_for(1.0 - FALSE_ALARM / 2.0, noise.freedom_f64());
                all.value(2 + place).abs() > limit * u
            })
        };
        let kept: Vec<Axis> = (0..2)
            .filter(|place| stands_out(*place))
            .map(|place| others[place])
            .collect();
        AxisTurn {
            at_ends: fit(&ends, &kept),
            constant: fit(&[Column::Own], &kept),
            all,
            others,
            kept,
        }
    }

    fn kept_at(&self, of: Axis) -> Option<usize> {
        self.kept.iter().position(|kept| *kept == of)
    }

    fn reversal(&self, along: Axis, of: Axis, noise: Option<Noise>) -> Estimate {
        match self.others.iter().position(|other| *other == of) {
            Some(place) if of != along => self.all.estimate(2 + place, noise),
            _ => self.constant.estimate(0, noise),
        }
    }

    /// The unknown of the curves' fit that is a term's reversal at the low end.
    fn low(&self, along: Axis, of: Axis) -> Option<usize> {
        if of == along {
            Some(0)
        } else {
            self.kept_at(of).map(|place| 2 + place)
        }
    }

    fn constancy(&self, noise: Option<Noise>) -> Option<f64> {
        let noise = noise.filter(|noise| noise.sigma_um > 0.0)?;
        let freedom = 3 - self.kept.len();
        let square = self.constant.left / noise.sigma_um.max(DIGIT_UM).squared();
        chance_of(square, freedom, noise.freedom)
    }
}

/// The reversals of a turn without overrun; `None` without reverse passes.
pub fn turn(
    means: &Means,
    volume: &Volume,
    runs: &PerDiagonal<[f64; 2]>,
    noise: Option<Noise>,
) -> Option<Turn> {
    let jumps = jumps(means, volume, runs)?;
    let axes = PerAxis::from_fn(|along| AxisTurn::new(volume, along, &jumps, noise));
    let low = |term: ErrorTerm| axes[term.along].low(term.along, term.of);
    let alone = |d: Diagonal, axis: Axis| Estimate {
        um: jumps.um[d][axis] / volume.cosine(axis),
        u_um: noise.map(|n| n.sigma_um * jumps.variance[d].sqrt() / volume.cosine(axis)),
    };
    Some(Turn {
        reversal: PerTerm::from_fn(|term| axes[term.along].reversal(term.along, term.of, noise)),
        ends: PerAxis::from_fn(|axis| [0, 1].map(|end| axes[axis].at_ends.estimate(end, noise))),
        by_diagonal: PerDiagonal::from_fn(|d| PerAxis::from_fn(|axis| alone(d, axis))),
        constancy: PerAxis::from_fn(|axis| axes[axis].constancy(noise)),
        in_curves: PerTerm::from_fn(|term| low(term).is_some()),
        low_um: PerTerm::from_fn(|term| {
            low(term).map_or(0.0, |unknown| axes[term.along].at_ends.value(unknown))
        }),
        low: PerTerm::from_fn(|term| {
            low(term).map_or_else(PerDiagonal::default, |unknown| {
                axes[term.along].at_ends.shares(unknown)
            })
        }),
        high: PerAxis::from_fn(|axis| axes[axis].at_ends.shares(1)),
    })
}

/// The means with the turn's jumps taken off the reverse pass, so that its last cell carries the
/// same increments as the forward pass: those of the lost motion are no error of the interval.
pub(crate) fn without_jumps(means: &Means, volume: &Volume) -> Means {
    let Some(reverse) = &means.reverse else {
        return means.clone();
    };
    let corner = 3 * volume.steps - 3;
    let reverse = PerDiagonal::from_fn(|diagonal| {
        let forward = &means.forward[diagonal];
        let mut readings = reverse[diagonal].clone();
        let offset = readings[corner] - forward[corner];
        for node in corner + 1..readings.len() {
            readings[node] = forward[node] + offset;
        }
        readings
    });
    Means {
        forward: means.forward.clone(),
        reverse: Some(reverse),
    }
}

/// The readings that are separated: without the jumps of a turn.
pub(super) fn separable<'a>(measured: &'a Means, volume: &Volume, turned: bool) -> Cow<'a, Means> {
    if turned {
        Cow::Owned(without_jumps(measured, volume))
    } else {
        Cow::Borrowed(measured)
    }
}
