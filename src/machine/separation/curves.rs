//! Formulas (1), (2) and (3): increments → nine curves and their closure.

use super::increments::Increments;
use crate::quantity::axis::{Axis, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Volume};

/// Values of one curve at the n + 1 interval ends of its moving axis, lowest first; µm, the
/// first is 0.
pub type Curve = Vec<f64>;

/// R/(2 V_j): noise of a separated increment by the noise of a measured one (docs/method.md §7).
pub(crate) fn noise_gain(volume: &Volume, of: Axis) -> f64 {
    1.0 / (2.0 * volume.cosine(of))
}

/// Formulas (1) and (3). The slopes hold the tilt of the mirror.
pub fn curves(volume: &Volume, increments: &Increments) -> PerTerm<Curve> {
    PerTerm::from_fn(|term| {
        let gain = noise_gain(volume, term.of) / 2.0;
        let signs = Diagonal::ALL.map(|d| gain * d.sign(term.along) * d.sign(term.of));
        let sets = Diagonal::ALL.map(|d| increments[d][term.along].as_slice());
        running_sum(volume.steps, signs, sets)
    })
}

/// w of formula (2): by axis, one value for each machine interval; µm.
pub(crate) fn closures(volume: &Volume, increments: &Increments) -> PerAxis<Vec<f64>> {
    PerAxis::from_fn(|axis| {
        let interval = |i: usize| {
            let part = |d: Diagonal| closure_sign(d, axis) * increments[d][axis][i];
            Diagonal::ALL.into_iter().map(part).sum()
        };
        (0..volume.steps).map(interval).collect()
    })
}

/// s_dk (s_x s_y s_z)_d: the sign with which a diagonal enters the closure of an axis.
pub(crate) fn closure_sign(diagonal: Diagonal, axis: Axis) -> f64 {
    let all: f64 = Axis::ALL
        .into_iter()
        .map(|axis| diagonal.sign(axis))
        .product();
    diagonal.sign(axis) * all
}

fn running_sum(steps: usize, signs: [f64; 4], sets: [&[f64]; 4]) -> Curve {
    let mut curve = Vec::with_capacity(steps + 1);
    let mut sum = 0.0;
    curve.push(sum);
    for (((a, b), c), d) in sets[0].iter().zip(sets[1]).zip(sets[2]).zip(sets[3]) {
        sum += signs[0] * a + signs[1] * b + signs[2] * c + signs[3] * d;
        curve.push(sum);
    }
    curve
}

/// A curve with the line through its ends turned to `slope_um_per_m`; shape and first value stay.
pub fn with_slope(volume: &Volume, along: Axis, curve: &[f64], slope_um_per_m: f64) -> Curve {
    let end = curve.last().copied().unwrap_or(0.0);
    plus_line(
        volume,
        along,
        curve,
        slope_um_per_m - end / metres(volume, along),
    )
}

/// A curve plus a straight line through zero at its low end.
pub(crate) fn plus_line(volume: &Volume, along: Axis, curve: &[f64], slope_um_per_m: f64) -> Curve {
    let value = |(index, value): (usize, &f64)| {
        value + slope_um_per_m * volume.along_mm(along, index) / 1000.0
    };
    curve.iter().enumerate().map(value).collect()
}

/// Slope of the line through the ends of a curve, µm/m.
pub(crate) fn end_slope(volume: &Volume, along: Axis, curve: &[f64]) -> f64 {
    curve.last().copied().unwrap_or(0.0) / metres(volume, along)
}

fn metres(volume: &Volume, along: Axis) -> f64 {
    volume.size[along].mm() / 1000.0
}

/// Mean of curves of the same length.
pub fn mean(curves: &[&Curve]) -> Curve {
    let Some(first) = curves.first() else {
        return Vec::new();
    };
    #[allow(clippy::cast_precision_loss, reason = "two directions at most")]
    let count = curves.len() as f64;
    let at = |index: usize| curves.iter().map(|curve| curve[index]).sum::<f64>() / count;
    (0..first.len()).map(at).collect()
}
