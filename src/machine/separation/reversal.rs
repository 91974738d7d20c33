//! Reversal: the two directions as twins, B = moving + minus moving −, a curve of each term.
//!
//! ```text
//!   + curve  E + (B − B0)/2      − curve  E − (B + B0)/2      E: mean of both directions, B0: B at the low end
//! ```
//! Where the axes do not run past the end point before the reverse pass, the last node is the same
//! place without any motion, and each of the three first moves back takes up the lost motion of
//! its axis. The jump J of the reverse less the forward increment over that move, and the sum G of forward less reverse
//! increments over the cells between the first and the last, are
//!
//! ```text
//!   J_dk      = Σ_j s_dk s_dj (V_j/R) B_jk(e)      e = high end of k where s_dk = +, low end where s_dk = −
//!   s_dk G_dk = Σ_j s_dk s_dj (V_j/R) (B_jk(high) − B_jk(low))
//!   0         = B_jk(high) − B_jk(low) + c_jk      u²(c): square of this change by J and G alone, its noise included,
//!                                                  at least the mean of the nine, and what noise makes of it
//! ```
//! Generalised least squares of all: of neighbouring increments the noise is shared, so that the totals of the
//! diagonals are in it. Differences of increments: neither the zero of the reverse runs nor the tilt of a mirror matters.
//! The last line says how much is known beforehand: a reversal changes along its axis no more than these readings
//! show. Without it the noise of whole sums (7 σ over 30 intervals) would go into every − curve,
//! with c = 0 a reversal that does change would be taken for one that does not (docs/method.md §8).
//!
//! With overrun all axes have reversed before the first reading back, and only Σ_k (V_k/R) B_kk
//! and three combinations of cross terms can be seen: the reversal of a single axis is not
//! determined, and both curves start at 0. With overrun, and with forward runs alone, a linear measurement of an axis in
//! both directions, which the job names, tells its reversal at every place:
//!
//! ```text
//!   B(x) = E+(x) − E−(x)      u²(B) = u²(E+) + u²(E−)
//! ```
//! The cross terms of that axis hold the mean of both directions: nothing tells their reversal.

use super::campaign::{Estimate, LinearReversals};
use super::curves::mean;
use super::readings::{DIGIT_UM, Noise, UNRESOLVED_UM, chance_of, float};
use super::solved::CurvesAndSlopes;
use super::start::Start;
use crate::machine::findings::SeparationFinding;
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Pass, PathKind, PerAxis, PerDiagonal, PerTerm, Squared,
    larger,
};
use crate::text::Finding;
use nalgebra::{DMatrix, DVector};
use nonius_numerics::rows::{CurveRows, Row};

/// Chance that an offset or a jump is believed where there is only noise.
const FALSE_ALARM: f64 = 0.01;
/// Where both an offset and jumps stand out, one must be so many times as far out of its noise.
const CLEARLY: f64 = 3.0;
/// Of σ²: what every equation of a turn neglects, so that none is exact.
const NEGLECTED: f64 = 1e-3;
/// Equations by what was measured: J and G of each axis along each diagonal.
const MEASURED: usize = 24;

/// Reversal at the turn; u by the noise of the readings, and by how much a reversal may change along its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// B of each term, mean of both ends of its axis.
    pub reversal: PerTerm<Estimate>,
    /// B of each positioning error at the low and the high end of its axis.
    pub ends: PerAxis<[Estimate; 2]>,
    /// B of each axis from each diagonal alone, at the end where it turned, if nothing but the
    /// axis itself reverses.
    pub by_diagonal: PerDiagonal<PerAxis<Estimate>>,
    /// Probability of changes at least as large where the reversals of an axis, its cross terms included, are constant
    /// along it; `None` = noise not known.
    pub constancy: PerAxis<Option<f64>>,
    /// u(c): by how much a reversal is taken to change along its axis, µm (k = 1): as much as was found, at least
    /// the root mean square of all nine and what noise makes.
    pub change_um: PerTerm<f64>,
    /// B of each term by place.
    curves: PerTerm<CurveRows>,
}

/// Whether the axes ran past the end point, judged from the readings; `None` = they do not tell.
/// Without overrun forward and reverse reading of the last node are one place read twice, and the
/// reversals follow as jumps; with overrun the offset is there at once and nothing jumps. Both
/// are tested against the noise of the means; of a jump that of the axis itself.
pub(super) fn ran_over(start: &Start<'_>, noise: Noise) -> Option<bool> {
    let (z, counts, layout) = (&start.z, &start.counts, start.model.layout);
    let square = noise.sigma_um.max(DIGIT_UM).squared();
    let of_mean = |d, pass| 1.0 / counts[layout.reading(pass, d, 0)];
    let variance = |d| square * Pass::BOTH.map(|pass| of_mean(d, pass)).iter().sum::<f64>();
    let offset = |d: Diagonal| {
        let [forward, reverse] =
            Pass::BOTH.map(|pass| z[layout.reading(pass, d, layout.nodes - 1)]);
        (forward - reverse).squared() / variance(d)
    };
    let jump = |axis: Axis| {
        let sum: f64 =
            Diagonal::ALL.map(|d| start.jump(d, axis).dot(z) / (2.0 * variance(d))).iter().sum();
        let weight: f64 = Diagonal::ALL.map(|d| 1.0 / (2.0 * variance(d))).iter().sum();
        sum.squared() / weight
    };
    let offset: f64 = Diagonal::ALL.map(offset).iter().sum();
    let jump: f64 = Axis::ALL.map(jump).iter().sum();
    let shows = |sum, count| Some(chance_of(sum, count, noise.freedom)? < FALSE_ALARM);
    let ratio = offset / 4.0 / (jump / 3.0);
    match (shows(offset, 4)?, shows(jump, 3)?) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        (true, true) if ratio > CLEARLY.squared() => Some(true),
        (true, true) if 1.0 / ratio > CLEARLY.squared() => Some(false),
        _ => None,
    }
}

/// Unknowns by equations, and the covariance of the unknowns: M, V → (MᵀV⁻¹M)⁻¹MᵀV⁻¹, (MᵀV⁻¹M)⁻¹. Of full rank: every
/// sign pattern is there once, and no equation is exact.
fn solution(design: &DMatrix<f64>, covariance: DMatrix<f64>) -> Option<[DMatrix<f64>; 2]> {
    let weighed = covariance.cholesky()?.solve(design);
    let spread = design.tr_mul(&weighed).cholesky()?.inverse();
    Some([&spread * weighed.transpose(), spread])
}

impl CurvesAndSlopes<'_> {
    /// The reversals of a turn without overrun.
    pub(super) fn turn(&mut self) -> Option<Turn> {
        let start = &self.start;
        let (volume, noise) = (start.volume(), start.noise);
        let (mut rows, mut design) = (Vec::new(), DMatrix::zeros(MEASURED + 9, 18));
        // The unknowns: B of all terms at the low ends, then at the high ones, axis by axis.
        let at = |along: Axis, of: Axis, end: Direction| {
            9 * usize::from(end == Direction::Plus) + 3 * along as usize + of as usize
        };
        for (d, axis) in Diagonal::ALL.into_iter().flat_map(|d| Axis::ALL.map(|axis| (d, axis))) {
            for of in Axis::ALL {
                let share = d.sign(axis) * d.sign(of) * volume.cosine(of);
                design[(rows.len(), at(axis, of, d.forward(axis)))] = share;
                design[(rows.len() + 1, at(axis, of, Direction::Minus))] = -share;
                design[(rows.len() + 1, at(axis, of, Direction::Plus))] = share;
            }
            let change = |step| {
                [(1.0, Pass::Forward), (-1.0, Pass::Reverse)]
                    .map(|(sign, pass)| (sign * d.sign(axis), start.moved(pass, d, axis, step)))
            };
            let between = 1..volume.steps - 1;
            rows.extend([start.jump(d, axis), Row::sum(between.flat_map(change))]);
        }
        for term in 0..9 {
            design[(MEASURED + term, term)] = -1.0;
            design[(MEASURED + term, 9 + term)] = 1.0;
        }
        let square = noise.map_or(0.0, |noise| noise.sigma_um).max(DIGIT_UM).squared();
        let mut weighed = DMatrix::zeros(start.counts.len(), MEASURED);
        for (index, row) in rows.iter().enumerate() {
            let u = |place: usize| (square / start.counts[place]).sqrt();
            row.0.iter().for_each(|(place, by)| weighed[(*place, index)] += by * u(*place));
        }
        let neglected = DMatrix::identity(MEASURED, MEASURED) * (NEGLECTED * square);
        let mut covariance = weighed.tr_mul(&weighed) + neglected;
        let [gain, spread] = solution(&design.rows(0, MEASURED).into(), covariance.clone())?;
        let ends =
            gain * DVector::from_iterator(MEASURED, rows.iter().map(|row| row.dot(&self.start.z)));
        let changes = ends.rows(9, 9) - ends.rows(0, 9);
        let of_changes = design.rows(MEASURED, 9) * spread * design.rows(MEASURED, 9).transpose();
        let constancy = |axis: Axis| {
            let own = changes.rows(3 * axis as usize, 3);
            let spread = of_changes.view((3 * axis as usize, 3 * axis as usize), (3, 3));
            let square = spread.into_owned().cholesky()?.solve(&own).dot(&own);
            chance_of(square, 3, noise.filter(|noise| noise.sigma_um > 0.0)?.freedom)
        };
        let usual = changes.norm_squared() / 9.0;
        let change_um = PerTerm::from_fn(|term| {
            let own = at(term.along, term.of, Direction::Minus);
            let found = changes[own].squared().max(of_changes[(own, own)]).max(usual).sqrt();
            larger(found, start.change_um[term])
        });
        covariance = covariance.resize(MEASURED + 9, MEASURED + 9, 0.0);
        for term in ErrorTerm::ALL {
            let (equation, um) = (rows.len(), change_um[term]); // in the order of the unknowns
            covariance[(equation, equation)] = um.squared() + NEGLECTED * square;
            rows.push(Row::of(self.start.add(0.0, um)));
        }
        let start = &self.start;
        let [gain, _] = solution(&design, covariance)?;
        let end = |term: ErrorTerm, end| {
            Row::sum(gain.row(at(term.along, term.of, end)).iter().copied().zip(&rows)).merged()
        };
        let estimate = |row: &Row| Estimate {
            um: row.dot(&self.start.z),
            u_um: noise.map(|_| self.start.model.variance(row).all.sqrt()),
        };
        let both = |term: ErrorTerm| Direction::BOTH.map(|way| end(term, way));
        let alone = |d, axis| Row::sum([(1.0 / volume.cosine(axis), start.jump(d, axis))]);
        Some(Turn {
            reversal: PerTerm::from_fn(|term| {
                estimate(&Row::sum(both(term).map(|row| (0.5, row))))
            }),
            ends: PerAxis::from_fn(|axis| {
                let [high, low] = both(ErrorTerm::positioning(axis));
                [estimate(&low), estimate(&high)]
            }),
            by_diagonal: PerDiagonal::from_fn(|d| {
                PerAxis::from_fn(|axis| estimate(&alone(d, axis)))
            }),
            constancy: PerAxis::from_fn(constancy),
            change_um,
            curves: PerTerm::from_fn(|term| {
                let [high, low] = both(term);
                let mut curve = self.between_passes(term);
                let rise = curve.steps.iter().map(|step| (-1.0, step));
                curve.line = Row::sum(rise.chain([(1.0, &high), (-1.0, &low)])).merged();
                CurveRows { start: low, line_um: curve.line.dot(&self.start.z), ..curve }
            }),
        })
    }

    /// B less that at the low end, by the increments of both directions.
    fn between_passes(&self, term: ErrorTerm) -> CurveRows {
        let of = |way, at| self.start.delta(term, Some(way), at);
        let step =
            |at| Row::sum([(1.0, of(Direction::Plus, at)), (-1.0, of(Direction::Minus, at))]);
        let steps = (0..self.start.volume().steps).map(step).collect();
        CurveRows { steps, ..CurveRows::default() }
    }

    /// B of a linear measurement: each place is measured by itself.
    fn by_linear(&mut self, reversal: &[Estimate]) -> CurveRows {
        let place = |b: &Estimate| Row::of(self.start.add(b.um, b.u_um.unwrap_or(0.0)));
        let places: Vec<Row> = reversal.iter().map(place).collect();
        let step = |ends: &[Row]| Row::sum([(1.0, &ends[1]), (-1.0, &ends[0])]);
        CurveRows {
            steps: places.windows(2).map(step).collect(),
            start: places.into_iter().next().unwrap_or_default(),
            ..CurveRows::default()
        }
    }

    /// B of each term and whether its uncertainty is known, where the two directions were measured apart; without a
    /// turn or a linear measurement it starts at 0.
    pub(super) fn apart(
        &mut self,
        turn: Option<&Turn>,
        linear: &LinearReversals,
    ) -> PerTerm<Option<(CurveRows, bool)>> {
        PerTerm::from_fn(|term| match (&linear[term.along], turn) {
            (Some(own), _) if term.is_positioning() => {
                Some((self.by_linear(own), u_largest_um(own).is_some()))
            }
            (_, Some(turn)) => Some((turn.curves[term].clone(), true)),
            _ => self.start.both_ways().then(|| (self.between_passes(term), true)),
        })
    }
}

/// The largest of the uncertainties of a linear measurement: its readings may share causes.
fn u_largest_um(reversal: &[Estimate]) -> Option<f64> {
    reversal.iter().filter_map(|b| b.u_um).reduce(f64::max)
}

/// Where the turn and the linear measurement of an axis contradict each other by more than six
/// standard deviations: the axes turned otherwise than was stated, or the two were not measured in
/// the same state.
pub(super) fn contradictions(turn: &Turn, reversals: &LinearReversals) -> Vec<Finding> {
    let of_axis = |(axis, linear): (Axis, &Option<Vec<Estimate>>)| {
        let linear = linear.as_ref()?;
        let of_turn = turn.reversal[ErrorTerm::positioning(axis)];
        let (turn_um, linear_um) = (of_turn.um, mean(linear.iter().map(|b| b.um)));
        let limit = 6.0 * of_turn.u_um?.hypot(u_largest_um(linear)?);
        let apart = (turn_um - linear_um).abs() > limit.max(UNRESOLVED_UM);
        apart.then(|| {
            Finding::from(SeparationFinding::TurnAgainstLinear { axis, turn_um, linear_um })
        })
    };
    reversals.iter().filter_map(of_axis).collect()
}

/// Reversal along the diagonals that passes with overrun show: the largest B at a cell end, µm;
/// `None` where the mean of forward minus reverse readings is within their noise. The reversal of
/// a single axis is hidden in it, so that no curve holds it. What linear measurements tell of
/// single axes, Σ_k (V_k/R) B_k at each place, is taken off.
pub(super) fn hidden_reversal_um(start: &Start<'_>, known: &LinearReversals) -> Option<f64> {
    let volume = start.volume();
    let beside = |d: Diagonal| -> Vec<f64> {
        let of_known = |node: usize| -> f64 {
            let b = known.iter().filter_map(|(axis, b)| {
                let end = volume.end_at(d, PathKind::Step, node, axis);
                Some(volume.cosine(axis) * b.as_ref()?[end].um)
            });
            b.sum()
        };
        let read = |pass, node| start.z[start.model.layout.reading(pass, d, node)];
        let back = |node| read(Pass::Forward, node) - read(Pass::Reverse, node) - of_known(node);
        (0..start.model.layout.nodes).map(back).collect()
    };
    let sigma = start.noise.map_or(0.0, |noise| noise.sigma_um);
    let u_known = known
        .iter()
        .filter_map(|(axis, b)| Some((volume.cosine(axis) * u_largest_um(b.as_ref()?)?).squared()));
    let u_known = u_known.sum::<f64>().sqrt();
    let shown = |b: &Vec<f64>| {
        // Six standard deviations of a mean difference.
        let of_noise = std::f64::consts::SQRT_2 * sigma / float(b.len()).sqrt();
        mean(b.iter().copied()).abs() > (6.0 * of_noise.hypot(u_known)).max(UNRESOLVED_UM)
    };
    let shown = Diagonal::ALL.into_iter().map(beside).filter(shown);
    let largest = |b: Vec<f64>| b.iter().step_by(3).fold(0.0, |most: f64, um| most.max(um.abs()));
    shown.map(largest).reduce(f64::max)
}
