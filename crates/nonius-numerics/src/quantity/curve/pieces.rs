//! The cubics of an error curve: how they come from measured points, and their algebra.

use crate::quantity::Millimetres;

/// c0 + c1·s + c2·s² + c3·s³ in µm, s in mm from the left knot of the interval.
pub(crate) type Cubic = [f64; 4];

/// One cubic for each interval between neighbouring positions.
pub(super) fn through(
    positions: &[Millimetres],
    values: &[f64],
    kind: Interpolation,
) -> Vec<Cubic> {
    let widths: Vec<f64> = positions.windows(2).map(|pair| (pair[1] - pair[0]).mm()).collect();
    let rises = values.windows(2).zip(&widths);
    let chords: Vec<f64> = rises.map(|(pair, width)| (pair[1] - pair[0]) / width).collect();
    match kind {
        Interpolation::Linear => linear(values, &chords),
        Interpolation::Pchip => hermite(values, &widths, &chords),
        Interpolation::NaturalSpline => natural_spline(values, &widths, &chords),
    }
}

fn linear(values: &[f64], chords: &[f64]) -> Vec<Cubic> {
    values.iter().zip(chords).map(|(&value, &chord)| [value, chord, 0.0, 0.0]).collect()
}

/// The Hermite cubics of the PCHIP slopes.
fn hermite(values: &[f64], widths: &[f64], chords: &[f64]) -> Vec<Cubic> {
    let slopes = pchip_slopes(widths, chords);
    let piece = |i: usize| {
        let (h, chord, left, right) = (widths[i], chords[i], slopes[i], slopes[i + 1]);
        let c2 = (3.0 * chord - 2.0 * left - right) / h;
        [values[i], left, c2, (left + right - 2.0 * chord) / (h * h)]
    };
    (0..widths.len()).map(piece).collect()
}

/// Slopes at the positions: inside the weighted harmonic mean of the neighbouring chords
/// (Fritsch & Butland 1984), 0 at a turning point; at the ends the three-point formula.
fn pchip_slopes(widths: &[f64], chords: &[f64]) -> Vec<f64> {
    let count = widths.len();
    if count < 2 {
        return vec![chords.first().copied().unwrap_or(0.0); count + 1];
    }
    let mut slopes = vec![0.0; count + 1];
    for i in 1..count {
        slopes[i] = harmonic_mean([widths[i - 1], widths[i]], [chords[i - 1], chords[i]]);
    }
    slopes[0] = end_slope([widths[0], widths[1]], [chords[0], chords[1]]);
    let last = count - 1;
    slopes[count] = end_slope([widths[last], widths[last - 1]], [chords[last], chords[last - 1]]);
    slopes
}

fn harmonic_mean(widths: [f64; 2], chords: [f64; 2]) -> f64 {
    if chords[0] * chords[1] <= 0.0 {
        return 0.0;
    }
    let weights = [2.0 * widths[1] + widths[0], widths[1] + 2.0 * widths[0]];
    (weights[0] + weights[1]) / (weights[0] / chords[0] + weights[1] / chords[1])
}

/// One-sided three-point slope at an end, limited so that the shape is kept (Moler 2004).
/// The interval at the end comes first.
fn end_slope(widths: [f64; 2], chords: [f64; 2]) -> f64 {
    let weighted = (2.0 * widths[0] + widths[1]) * chords[0] - widths[0] * chords[1];
    let slope = weighted / (widths[0] + widths[1]);
    if slope * chords[0] <= 0.0 {
        0.0
    } else if chords[0] * chords[1] <= 0.0 && slope.abs() > 3.0 * chords[0].abs() {
        3.0 * chords[0]
    } else {
        slope
    }
}

/// The natural spline from its second derivatives M (de Boor 1978):
/// h₋·M₋ + 2(h₋+h)·M + h·M₊ = 6·(chord − chord₋) at every inner position, M = 0 at the ends.
fn natural_spline(values: &[f64], widths: &[f64], chords: &[f64]) -> Vec<Cubic> {
    let diagonal = widths.windows(2).map(|pair| 2.0 * (pair[0] + pair[1])).collect();
    let right = chords.windows(2).map(|pair| 6.0 * (pair[1] - pair[0])).collect();
    let beside = widths.get(1..).unwrap_or_default();
    let mut bends = vec![0.0];
    bends.extend(solve_tridiagonal(diagonal, beside, right));
    bends.push(0.0);
    let piece = |i: usize| {
        let (h, left, right) = (widths[i], bends[i], bends[i + 1]);
        let slope = chords[i] - h * (2.0 * left + right) / 6.0;
        [values[i], slope, left / 2.0, (right - left) / (6.0 * h)]
    };
    (0..widths.len()).map(piece).collect()
}

/// The solution of a symmetric tridiagonal system, by elimination without pivoting (Thomas).
///
/// shape  `beside[i]` couples unknown i with i + 1; surplus entries are not read
/// limits for diagonally dominant matrices, which is all that splines and hat functions make
pub(crate) fn solve_tridiagonal(
    mut diagonal: Vec<f64>,
    beside: &[f64],
    mut right: Vec<f64>,
) -> Vec<f64> {
    let count = diagonal.len();
    for i in 1..count {
        let factor = beside[i - 1] / diagonal[i - 1];
        diagonal[i] -= factor * beside[i - 1];
        right[i] -= factor * right[i - 1];
    }
    for i in (0..count).rev() {
        let known = if i + 1 < count { beside[i] * right[i + 1] } else { 0.0 };
        right[i] = (right[i] - known) / diagonal[i];
    }
    right
}

/// The value of a cubic, µm.
pub(super) fn value_of(c: &Cubic, s: f64) -> f64 {
    c[0] + s * (c[1] + s * (c[2] + s * c[3]))
}

/// The same cubic about a point `s` further on.
pub(super) fn about(c: &Cubic, s: f64) -> Cubic {
    let slope = c[1] + s * (2.0 * c[2] + 3.0 * s * c[3]);
    [value_of(c, s), slope, c[2] + 3.0 * s * c[3], c[3]]
}

/// Where cubic + slope·s is level, ascending; a place that does not exist is NaN or infinite and
/// lies in no interval. The form of the roots avoids the loss of digits in −b + √(b² − …).
pub(super) fn stationary_points(c: &Cubic, slope: f64) -> [f64; 2] {
    let (a, b, c) = (3.0 * c[3], c[2], c[1] + slope);
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return [f64::NAN; 2];
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (one, two) = (q / a, c / q);
    if one > two { [two, one] } else { [one, two] }
}

/// How the curve runs between the measured positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines from target to target.
    Linear,
    /// Monotone piecewise cubic: no overshoot, extremes only at targets, continuous slope.
    /// Fritsch & Carlson, SIAM J. Numer. Anal. 17 (1980) 238–246; slopes after Fritsch &
    /// Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304; ends as in SciPy's
    /// `PchipInterpolator`, from Moler, *Numerical Computing with MATLAB* (2004) §3.
    Pchip,
    /// Cubic spline, second derivative continuous and zero at both ends; may overshoot.
    /// de Boor, *A Practical Guide to Splines* (1978) ch. IV.
    NaturalSpline,
}
