//! Curves, and the reference lines of ISO 230-1 that their slopes and straightness refer to.

use crate::quantity::{Axis, Diagonal, Millimetres, Volume, ends};

/// Values of one curve at the n + 1 interval ends of its moving axis, lowest first; µm, the
/// first is 0.
pub type Curve = Vec<f64>;

/// R/(2 V_j): noise of a separated increment by the noise of a measured one (docs/method.md §7).
pub(super) fn noise_gain(volume: &Volume, of: Axis) -> f64 {
    1.0 / (2.0 * volume.cosine(of))
}

/// s_dk (s_x s_y s_z)_d: the sign with which a diagonal enters the closure of an axis.
pub(super) fn closure_sign(diagonal: Diagonal, axis: Axis) -> f64 {
    let all: f64 = Axis::ALL.into_iter().map(|axis| diagonal.sign(axis)).product();
    diagonal.sign(axis) * all
}

/// The value at a position, mm, by the straight line between its neighbours; beyond the ends
/// (rounding of the file, callers check the range) the end value.
pub(super) fn at(positions: &[Millimetres], values: &[f64], position: f64) -> f64 {
    let after = positions.partition_point(|known| known.mm() <= position);
    let pair = |index: usize| Some((positions.get(index)?.mm(), *values.get(index)?));
    match (after.checked_sub(1).and_then(pair), pair(after)) {
        (Some((low, a)), Some((high, b))) => a + (b - a) * (position - low) / (high - low),
        (Some((_, value)), None) | (None, Some((_, value))) => value,
        (None, None) => 0.0,
    }
}

/// Which line a slope, a squareness or a straightness refers to; the two belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceLine {
    /// Least squares.
    LeastSquares,
    /// Through the first and the last point.
    EndPoints,
}

impl ReferenceLine {
    /// Slope, µm/m, of the line of this type; positions in mm, deviations in µm. Zero for fewer
    /// than two positions.
    pub(crate) fn slope_um_per_m(self, positions_mm: &[f64], deviations_um: &[f64]) -> f64 {
        let rise = |of: &[f64]| of.first().zip(of.last()).map_or(0.0, |(first, last)| last - first);
        let (rise, length) = match self {
            ReferenceLine::EndPoints => (rise(deviations_um), rise(positions_mm) / 1000.0),
            ReferenceLine::LeastSquares => {
                let middle = mean(positions_mm.iter().copied());
                let pairs = positions_mm.iter().zip(deviations_um);
                pairs.fold((0.0, 0.0), |(rise, length), (position, deviation)| {
                    let arm = (position - middle) / 1000.0;
                    (rise + arm * deviation, length + arm * arm)
                })
            }
        };
        if length > 0.0 { rise / length } else { 0.0 }
    }

    /// Straightness: max − min of what is left beside the line, µm.
    pub fn straightness_um(self, positions_mm: &[f64], deviations_um: &[f64]) -> f64 {
        let slope = self.slope_um_per_m(positions_mm, deviations_um);
        let pairs = positions_mm.iter().zip(deviations_um);
        range(pairs.map(|(position, deviation)| deviation - slope * position / 1000.0))
    }
}

/// The mean; 0 of nothing.
pub(in crate::machine) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Max − min; 0 of nothing.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = ends(values);
    if low < high { high - low } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_lines_differ_where_the_error_is_asymmetric() {
        let (x, d) = ([0.0, 500.0, 1000.0], [0.0, 9.0, 6.0]);
        assert!((ReferenceLine::EndPoints.slope_um_per_m(&x, &d) - 6.0).abs() < 1e-12);
        assert!((ReferenceLine::EndPoints.straightness_um(&x, &d) - 6.0).abs() < 1e-12);
        let d = [0.0, 0.0, 9.0, 12.0];
        let x = [0.0, 250.0, 500.0, 1000.0];
        let by_hand = 13.371_428_571_428_6; // Σ(x−x̄)D / Σ(x−x̄)² = 7.3125 / 0.546875
        let slope = ReferenceLine::LeastSquares.slope_um_per_m(&x, &d);
        assert!((slope - by_hand).abs() < 1e-9, "{slope}");
    }
}
