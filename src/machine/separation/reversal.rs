//! Reversal of each axis from the turn at the end of the diagonals.
//!
//! Where the axes do not run past the end point before the reverse pass, the last node is the same
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

use super::linear::{Layout, Row};
use super::noise::{DIGIT_UM, Noise, chance_of, student};
use super::readings::{Means, RunCounts};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Chance that a reversal, an offset or a jump is believed where there is only noise.
const FALSE_ALARM: f64 = 0.01;
/// Where both an offset and jumps stand out, one must be so many times as far out of its noise.
const CLEARLY: f64 = 3.0;

/// A reversal and its standard uncertainty (k = 1; `None` = noise not known), µm.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
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
    /// The jumps' shares in B of each term at the low end of its axis.
    low: PerTerm<PerDiagonal<f64>>,
    /// The jumps' shares in B of each positioning error at the high end.
    high: PerAxis<PerDiagonal<f64>>,
}

impl Turn {
    /// B of a term at the low end of its axis as the curves hold it, and of a positioning error that at its
    /// high end less that, by the readings.
    pub(super) fn ends_of(&self, term: ErrorTerm, layout: Layout, volume: &Volume) -> [Row; 2] {
        let jump = |d: Diagonal| jump(layout, volume, d, term.along);
        let low = Row::sum(
            Diagonal::ALL
                .map(jump)
                .iter()
                .zip(self.low[term].iter())
                .map(|(row, (_, share))| (*share, row)),
        );
        let growth = |d: Diagonal| self.high[term.along][d] - self.low[term][d];
        let growths = Diagonal::ALL.map(|d| (growth(d), jump(d)));
        let growth = Row::sum(growths.iter().map(|(share, row)| (*share, row)));
        [low, if term.is_positioning() { growth } else { Row::default() }]
    }
}

/// J of an axis along a diagonal.
fn jump(layout: Layout, volume: &Volume, d: Diagonal, axis: Axis) -> Row {
    let node = volume.node_after(axis, volume.steps - 1);
    let at = |pass, node, sign: f64| (layout.reading(pass, d, node), sign);
    Row(vec![
        at(Pass::Reverse, node, 1.0),
        at(Pass::Reverse, node - 1, -1.0),
        at(Pass::Forward, node, -1.0),
        at(Pass::Forward, node - 1, 1.0),
    ])
}

/// Jumps of every axis along every diagonal with their variances for readings of 1 µm.
struct Jumps {
    um: PerDiagonal<PerAxis<f64>>,
    variance: PerDiagonal<f64>,
}

fn jumps(means: &Means, volume: &Volume, runs: &RunCounts) -> Option<Jumps> {
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

/// Whether the axes ran past the end point, judged from the readings; `None` = they do not tell.
/// Without overrun forward and reverse reading of the last node are one place read twice, and the
/// reversals follow as jumps; with overrun the offset is there at once and nothing jumps. Both
/// are tested against the noise of the means.
pub(super) fn ran_over(
    means: &Means,
    volume: &Volume,
    runs: &RunCounts,
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
    let by_axis = Axis::ALL.map(|axis| {
        let fit = Fit::new(axis, &[own(volume, axis)], &jumps);
        (fit.values[0] / (sigma_um * fit.spread(0))).squared()
    });
    let offset: f64 = offsets.iter().sum::<f64>() / 4.0;
    let jump: f64 = by_axis.iter().sum::<f64>() / 3.0;
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

/// What B of a term does to the four jumps of an axis, by diagonal.
type Effect = PerDiagonal<f64>;

/// B of the axis itself, the same at both ends.
fn own(volume: &Volume, along: Axis) -> Effect {
    PerDiagonal::from_fn(|_| volume.cosine(along))
}

/// B of the axis itself at one end: diagonals that travel it in + turn at the high one.
fn own_at(volume: &Volume, along: Axis, end: Direction) -> Effect {
    PerDiagonal::from_fn(|d| f64::from(d.forward(along) == end) * volume.cosine(along))
}

/// B of a cross term.
fn cross(volume: &Volume, along: Axis, of: Axis) -> Effect {
    PerDiagonal::from_fn(|d| d.sign(along) * d.sign(of) * volume.cosine(of))
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
    fn new(along: Axis, columns: &[Effect], jumps: &Jumps) -> Fit {
        let variance = Diagonal::ALL.map(|d| jumps.variance[d]);
        let jump = DVector::from_fn(4, |i, _| jumps.um[Diagonal::ALL[i]][along]);
        let many = columns.len();
        let design = DMatrix::from_fn(4, many, |i, j| columns[j][Diagonal::ALL[i]]);
        let weighed = DMatrix::from_fn(4, many, |i, j| design[(i, j)] / variance[i]);
        // The columns are independent: edges have lengths, and every sign pattern is there once.
        let inverse = weighed.tr_mul(&design).try_inverse();
        let gains = inverse
            .map_or_else(|| DMatrix::zeros(many, 4), |inverse| inverse * weighed.transpose());
        let values = &gains * &jump;
        let residual = jump - design * &values;
        Fit {
            left: residual.iter().zip(variance).map(|(r, v)| r * r / v).sum(),
            gains,
            values,
            variance,
        }
    }

    /// Standard deviation for readings of 1 µm.
    fn spread(&self, unknown: usize) -> f64 {
        let part = |i: usize| self.gains[(unknown, i)].squared() * self.variance[i];
        (0..4).map(part).sum::<f64>().sqrt()
    }

    fn estimate(&self, unknown: usize, noise: Option<Noise>) -> Estimate {
        Estimate {
            um: self.values[unknown],
            u_um: noise.map(|noise| noise.sigma_um * self.spread(unknown)),
        }
    }

    fn shares(&self, unknown: usize) -> PerDiagonal<f64> {
        let mut column = 0..4;
        PerDiagonal::from_fn(|_| column.next().map_or(0.0, |i| self.gains[(unknown, i)]))
    }
}

/// What the jumps of one axis say.
struct AxisTurn {
    /// Of the axis itself at both ends, and of both cross terms.
    all: Fit,
    /// The same without the cross terms that do not stand out; and with one reversal for both ends.
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
        let ends = [Direction::Minus, Direction::Plus].map(|end| own_at(volume, along, end));
        let fit = |own: &[Effect], others: &[Axis]| {
            let crosses = others.iter().map(|of| cross(volume, along, *of));
            let columns: Vec<Effect> = own.iter().copied().chain(crosses).collect();
            Fit::new(along, &columns, jumps)
        };
        let all = fit(&ends, &others);
        let stands_out = |place: &usize| {
            noise.is_some_and(|noise| {
                let u = noise.sigma_um.max(DIGIT_UM) * all.spread(2 + place);
                let limit = student(1.0 - FALSE_ALARM / 2.0, noise.freedom_f64());
                all.values[2 + place].abs() > limit * u
            })
        };
        let kept = (0..2).filter(stands_out).map(|place| others[place]);
        let kept: Vec<Axis> = kept.collect();
        AxisTurn {
            at_ends: fit(&ends, &kept),
            constant: fit(&[own(volume, along)], &kept),
            all,
            others,
            kept,
        }
    }

    /// One reversal for the whole axis.
    fn reversal(&self, of: Axis, noise: Option<Noise>) -> Estimate {
        match self.others.iter().position(|other| *other == of) {
            Some(place) => self.all.estimate(2 + place, noise),
            None => self.constant.estimate(0, noise),
        }
    }

    /// The unknown of the curves' fit that is a term's reversal at the low end.
    fn low(&self, of: Axis) -> Option<usize> {
        let kept = self.kept.iter().position(|kept| *kept == of);
        let own = (!self.others.contains(&of)).then_some(0);
        kept.map(|place| 2 + place).or(own)
    }

    fn constancy(&self, noise: Option<Noise>) -> Option<f64> {
        let noise = noise.filter(|noise| noise.sigma_um > 0.0)?;
        let square = self.constant.left / noise.sigma_um.max(DIGIT_UM).squared();
        chance_of(square, 3 - self.kept.len(), noise.freedom)
    }
}

/// The reversals of a turn without overrun; `None` without reverse passes.
pub(super) fn turn(
    means: &Means,
    volume: &Volume,
    runs: &RunCounts,
    noise: Option<Noise>,
) -> Option<Turn> {
    let jumps = jumps(means, volume, runs)?;
    let axes = PerAxis::from_fn(|along| AxisTurn::new(volume, along, &jumps, noise));
    let low = |term: ErrorTerm| {
        let axis = &axes[term.along];
        Some((&axis.at_ends, axis.low(term.of)?))
    };
    let alone = |d: Diagonal, axis: Axis| Estimate {
        um: jumps.um[d][axis] / volume.cosine(axis),
        u_um: noise.map(|n| n.sigma_um * jumps.variance[d].sqrt() / volume.cosine(axis)),
    };
    Some(Turn {
        reversal: PerTerm::from_fn(|term| axes[term.along].reversal(term.of, noise)),
        ends: PerAxis::from_fn(|axis| [0, 1].map(|end| axes[axis].at_ends.estimate(end, noise))),
        by_diagonal: PerDiagonal::from_fn(|d| PerAxis::from_fn(|axis| alone(d, axis))),
        constancy: PerAxis::from_fn(|axis| axes[axis].constancy(noise)),
        in_curves: PerTerm::from_fn(|term| low(term).is_some()),
        low: PerTerm::from_fn(|term| low(term).map_or_else(Effect::default, |(f, i)| f.shares(i))),
        high: PerAxis::from_fn(|axis| axes[axis].at_ends.shares(1)),
    })
}
