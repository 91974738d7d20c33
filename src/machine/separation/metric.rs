//! Scales and squareness from the totals, free of the mirror's tilt (formula 7).
//!
//! A flat mirror measures along its normal g_d = u_d + η_d, where η_d is unknown in every set-up.
//! The measured displacement per commanded unit of axis k is q_dk. With A = I + P (P: slopes of
//! the nine curves) q_d = Aᵀ g_d and |g_d| = 1, so that, with h = (P + Pᵀ)/2,
//!
//! ```text
//!   (|q_d|² − 1)/2 = Σ_k q_dk² h_kk + q_dx q_dy φxy + q_dx q_dz φxz + q_dy q_dz φyz      (7)
//!   slope of EKK along axis k                = h_kk                        (a linear axis)
//!   slope along a straight line of direction v = vᵀ h v                    (another beam)
//! ```
//! No rotation occurs in (7): h is the metric of the axis triad. Four diagonals give the three
//! squareness errors and one combination of the scales; two linear axes or other beams close it.
//! Source: derived and confirmed by simulation in the project's reference on the step-diagonal
//! method (docs/method.md §5); same idea as Ibaraki and Hata (2010). Neglected: P², about 10⁻⁹.
//! Exact for any η where the beam meets the mirror along its normal; at an angle α to it every
//! diagonal reads α²/2 short.

pub use super::plane::{PerPlane, Plane};

use super::plane::per_plane;
use super::system::{KnownSpace, Row, Solution, System, UNKNOWNS};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Volume};
use crate::quantity::units::Squared;
use nalgebra::DMatrix;

const UM_PER_M: f64 = 1e-6;
/// What (7) neglects, µm/m. No equation is weighed as if it were more certain: readings without
/// any noise would make the system singular beside a line with a stated uncertainty.
const NEGLECTED_UM_PER_M: f64 = 1e-3;

/// One straight line whose length was measured beside the diagonals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLine {
    /// Direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Displacement error by length, µm/m.
    pub slope_um_per_m: f64,
    /// Its standard uncertainty (k = 1), µm/m; `None` = not known.
    pub u_um_per_m: Option<f64>,
}

/// How uncertain the totals of the diagonals are, by their length.
#[derive(Clone, Debug, PartialEq)]
pub struct TotalsUncertainty {
    /// Of each diagonal for itself (noise, changes between set-ups), standard, µm/m.
    pub own_um_per_m: PerDiagonal<f64>,
    /// False: `own_um_per_m` is only a weight, because the noise is not known.
    pub known: bool,
    /// Common to all set-ups, one for each cause: the false scales of X, Y, Z that one standard
    /// uncertainty of it makes, µm/m.
    pub common_um_per_m: Vec<PerAxis<f64>>,
}

/// What is measured of a triad's metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Slopes of EXX, EYY, EZZ, µm/m; absent = not determined by the data.
    pub scale: PerAxis<Option<f64>>,
    /// Squareness φ, µm/m: positive = the angle between the positive axis directions is less
    /// than 90°.
    pub squareness: PerPlane<Option<f64>>,
    /// Covariance (µm/m)² of X, Y, Z scale, φxy, φxz, φyz; rows and columns of what is not
    /// determined hold only the determined part.
    pub covariance: [[f64; UNKNOWNS]; UNKNOWNS],
    /// Number of combinations of the six unknowns that the data determine.
    pub rank: usize,
    /// Of X, Y, Z scale, φxy, φxz, φyz: whether the uncertainty of everything that it depends on
    /// is known.
    pub u_known: [bool; UNKNOWNS],
    /// How much φ moves with what is not determined of the scales, because the mirrors are tilted,
    /// µm/m for each µm/m; 0 where all is determined.
    pub leak: PerPlane<f64>,
}

impl Metric {
    /// Whether everything is determined.
    pub(crate) const fn is_complete(&self) -> bool {
        self.rank == UNKNOWNS
    }

    /// Standard uncertainty of a scale, µm/m; `None` = not known.
    pub fn u_scale(&self, axis: Axis) -> Option<f64> {
        self.u(scale_index(axis))
    }

    /// Standard uncertainty of a squareness, µm/m; `None` = not known.
    pub fn u_squareness(&self, plane: Plane) -> Option<f64> {
        self.u(plane_index(plane))
    }

    fn u(&self, index: usize) -> Option<f64> {
        self.u_known[index].then(|| self.covariance[index][index].sqrt())
    }

    /// What the data do not determine, in words; empty where all is.
    pub fn undetermined(&self) -> Vec<String> {
        let scales: Vec<String> = Axis::ALL
            .into_iter()
            .filter(|axis| self.scale[*axis].is_none())
            .map(|axis| axis.to_string())
            .collect();
        let mut words = Vec::new();
        match scales.as_slice() {
            [] => {}
            [x, y, z] => words.push(format!(
                "scale of {x}, {y} and {z} can be traded against each other; measure two axes along their length"
            )),
            [a, b] => words.push(format!(
                "scale of {a} and {b} can be traded against each other; measure one axis along its length"
            )),
            other => words.push(format!("scale of {}", other.join(" and "))),
        }
        for plane in Plane::ALL {
            if self.squareness.of(plane).is_none() {
                let (a, b) = plane.axes();
                words.push(format!(
                    "squareness of {a} and {b}; measure a face diagonal of their plane"
                ));
            }
        }
        words
    }
}

const fn scale_index(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

const fn plane_index(plane: Plane) -> usize {
    match plane {
        Plane::Xy => 3,
        Plane::Xz => 4,
        Plane::Yz => 5,
    }
}

/// Displacement per commanded unit: q_dk = s_dk (V_k/R + n m̄_dk/V_k). Dimensionless; `means` in µm.
pub(crate) fn displacement_ratios(
    volume: &Volume,
    means: &PerDiagonal<PerAxis<f64>>,
) -> PerDiagonal<PerAxis<f64>> {
    PerDiagonal::from_fn(|diagonal| {
        PerAxis::from_fn(|axis| {
            let step_um = volume.step_mm(axis) * 1000.0;
            diagonal.sign(axis) * (volume.cosine(axis) + means[diagonal][axis] / step_um)
        })
    })
}

/// What (7) says of one diagonal: vᵀ h v = value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalEquation {
    /// v, without unit.
    pub direction: PerAxis<f64>,
    /// The value, µm/m.
    pub value_um_per_m: f64,
}

/// (7) of step runs: q_dᵀ h q_d = (q_d² − 1)/2.
pub(crate) fn stepped(ratios: &PerDiagonal<PerAxis<f64>>) -> PerDiagonal<DiagonalEquation> {
    PerDiagonal::from_fn(|d| {
        let q = ratios[d];
        let square = q.x * q.x + q.y * q.y + q.z * q.z;
        DiagonalEquation {
            direction: q,
            value_um_per_m: (square - 1.0) / 2.0 / UM_PER_M,
        }
    })
}

/// (7) of straight runs, of first order: u_dᵀ h u_d = e_d(end)/R. `ends_um`: totals.
pub fn straight(volume: &Volume, ends_um: &PerDiagonal<f64>) -> PerDiagonal<DiagonalEquation> {
    let length_m = volume.diagonal_mm() / 1000.0;
    PerDiagonal::from_fn(|d| DiagonalEquation {
        direction: volume.laser(d),
        value_um_per_m: ends_um[d] / length_m,
    })
}

/// vᵀ h v as a row of the six unknowns.
pub(super) fn row(v: &PerAxis<f64>) -> Row {
    Row::from([
        v.x * v.x,
        v.y * v.y,
        v.z * v.z,
        v.x * v.y,
        v.x * v.z,
        v.y * v.z,
    ])
}

/// The equations of (7), diagonals first, then lines, and how they are weighed.
pub(super) struct Equations {
    pub(super) space: KnownSpace,
    rows: Vec<Row>,
    nominal: Vec<Row>,
    values: Vec<f64>,
    /// Variances of each equation for itself, (µm/m)².
    own: Vec<f64>,
    /// Whether these are known.
    known: Vec<bool>,
    /// Effects of each common cause on the equations, µm/m.
    common: Vec<Vec<f64>>,
}

impl Equations {
    pub(super) fn new(
        volume: &Volume,
        diagonals: &PerDiagonal<DiagonalEquation>,
        totals: &TotalsUncertainty,
        lines: &[StraightLine],
    ) -> Equations {
        let variance = |u: f64| u.max(NEGLECTED_UM_PER_M).squared();
        let mut rows: Vec<Row> = Vec::new();
        let (mut values, mut own, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for (diagonal, equation) in diagonals.iter() {
            rows.push(row(&equation.direction));
            values.push(equation.value_um_per_m);
            own.push(variance(totals.own_um_per_m[diagonal]));
            known.push(totals.known);
        }
        // A line of unknown uncertainty is weighed like a diagonal.
        let like_a_diagonal = own.iter().sum::<f64>() / 4.0;
        for line in lines {
            rows.push(row(&line.direction));
            values.push(line.slope_um_per_m);
            own.push(line.u_um_per_m.map_or(like_a_diagonal, variance));
            known.push(line.u_um_per_m.is_some());
        }
        let nominal = nominal_rows(volume, lines);
        let effect = |strain: &PerAxis<f64>| {
            let scales = Row::from([strain.x, strain.y, strain.z, 0.0, 0.0, 0.0]);
            let of = |(index, row): (usize, &Row)| if index < 4 { row.dot(&scales) } else { 0.0 };
            nominal.iter().enumerate().map(of).collect()
        };
        Equations {
            space: KnownSpace::of(&nominal),
            common: totals.common_um_per_m.iter().map(effect).collect(),
            rows,
            nominal,
            values,
            own,
            known,
        }
    }

    /// V: each equation for itself, and what the diagonals share.
    pub(super) fn covariance(&self, own: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(own.len(), own.len(), |i, j| {
            let shared: f64 = self.common.iter().map(|effect| effect[i] * effect[j]).sum();
            shared + if i == j { own[i] } else { 0.0 }
        })
    }

    pub(super) fn system<'a>(&'a self, covariance: &'a DMatrix<f64>) -> System<'a> {
        System {
            space: &self.space,
            rows: &self.rows,
            values: &self.values,
            covariance,
        }
    }

    /// Number of redundant equations.
    pub(super) fn redundancy(&self) -> usize {
        self.rows.len().saturating_sub(self.space.rank())
    }

    /// Variances for a test: an equation of unknown uncertainty counts as exact, but none as more
    /// certain than what (7) neglects at slopes of this size.
    pub(super) fn test_variances(&self, largest_slope_um_per_m: f64) -> Vec<f64> {
        let products = 3.0 * largest_slope_um_per_m.squared() * UM_PER_M;
        let neglected = products.max(NEGLECTED_UM_PER_M).squared();
        let of = |(own, known): (&f64, &bool)| {
            if *known {
                own.max(neglected)
            } else {
                neglected
            }
        };
        self.own.iter().zip(&self.known).map(of).collect()
    }

    /// Which unknowns rest on nothing but equations of known uncertainty; judged at the nominal
    /// directions, like the rank.
    fn u_known(&self, covariance: &DMatrix<f64>) -> [bool; UNKNOWNS] {
        if self.known.iter().all(|known| *known) {
            return [true; UNKNOWNS];
        }
        let nominal = System {
            rows: &self.nominal,
            ..self.system(covariance)
        };
        let Some(gain) = nominal.solve().and_then(|found| nominal.gain(&found)) else {
            return [false; UNKNOWNS];
        };
        let rests = |unknown: usize| {
            let mut equations = self.known.iter().enumerate();
            equations.all(|(equation, known)| *known || !gain.depends(unknown, equation))
        };
        std::array::from_fn(rests)
    }
}

/// Solves (7) for the unit vectors that were measured along.
pub(crate) fn solve(
    volume: &Volume,
    diagonals: &PerDiagonal<DiagonalEquation>,
    totals: &TotalsUncertainty,
    lines: &[StraightLine],
) -> Metric {
    Equations::new(volume, diagonals, totals, lines).metric()
}

impl Equations {
    fn metric(&self) -> Metric {
        let covariance = self.covariance(&self.own);
        let system = self.system(&covariance);
        let solution = system.solve();
        let value = |index: usize| {
            let solution = solution.as_ref()?;
            let determined = self.space.determines(index);
            determined.then(|| solution.unknowns[index])
        };
        let gain = solution.as_ref().filter(|_| self.space.rank() < UNKNOWNS);
        let gain = gain.and_then(|solution| system.gain(solution));
        let leaks = gain.map_or([0.0; UNKNOWNS], |gain| system.leaks(&gain));
        let planes = Plane::ALL.map(plane_index);
        Metric {
            scale: PerAxis::from_fn(|axis| value(scale_index(axis))),
            squareness: per_plane(planes.map(value)),
            covariance: spread(solution.as_ref()),
            rank: self.space.rank(),
            u_known: self.u_known(&covariance),
            leak: per_plane(planes.map(|index| leaks[index])),
        }
    }
}

/// How scales and squareness change with the totals of the diagonals.
pub struct EndGains(PerDiagonal<[f64; UNKNOWNS]>);

impl EndGains {
    /// Of a scale, µm/m for each µm of the total of a diagonal.
    pub fn scale(&self, axis: Axis) -> PerDiagonal<f64> {
        PerDiagonal::from_fn(|d| self.0[d][scale_index(axis)])
    }

    /// Of a squareness, µm/m for each µm of the total of a diagonal.
    pub fn squareness(&self, plane: Plane) -> PerDiagonal<f64> {
        PerDiagonal::from_fn(|d| self.0[d][plane_index(plane)])
    }
}

/// ∂θ/∂E of the solution of (7), with the weights of [`solve`]; zero where it has none.
pub(crate) fn end_gains(
    volume: &Volume,
    diagonals: &PerDiagonal<DiagonalEquation>,
    totals: &TotalsUncertainty,
    lines: &[StraightLine],
) -> EndGains {
    let equations = Equations::new(volume, diagonals, totals, lines);
    let covariance = equations.covariance(&equations.own);
    let system = equations.system(&covariance);
    let gain = system.solve().and_then(|found| system.gain(&found));
    // (|q|² − 1)/2 grows by dE/R.
    let metres = volume.diagonal_mm() / 1000.0;
    let mut equation = 0..4;
    EndGains(PerDiagonal::from_fn(|_| {
        let (gain, equation) = (gain.as_ref(), equation.next());
        let by = |unknown| {
            gain.zip(equation)
                .map(|(gain, d)| gain.of(unknown, d) / metres)
        };
        std::array::from_fn(|unknown| by(unknown).unwrap_or(0.0))
    }))
}

fn spread(solution: Option<&Solution>) -> [[f64; UNKNOWNS]; UNKNOWNS] {
    let entry = |i: usize, j: usize| solution.map_or(0.0, |s| s.spread[(i, j)]);
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

fn nominal_rows(volume: &Volume, lines: &[StraightLine]) -> Vec<Row> {
    let diagonals = Diagonal::ALL.map(|diagonal| row(&volume.laser(diagonal)));
    let others = lines.iter().map(|line| row(&line.direction));
    diagonals.into_iter().chain(others).collect()
}
