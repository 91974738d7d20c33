//! Reference lines of ISO 230-1: least squares and through the end points.

/// Which line a slope, a squareness or a straightness refers to; the two belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceLine {
    /// Least squares.
    LeastSquares,
    /// Through the first and the last point.
    EndPoints,
}

impl ReferenceLine {
    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            ReferenceLine::LeastSquares => "least squares line",
            ReferenceLine::EndPoints => "line through the end points",
        }
    }

    /// Slope, µm/m, of the line of this type; positions in mm, deviations in µm. Zero for fewer
    /// than two positions.
    pub fn slope_um_per_m(self, positions_mm: &[f64], deviations_um: &[f64]) -> f64 {
        match self {
            ReferenceLine::EndPoints => {
                let ends = positions_mm.first().zip(positions_mm.last());
                let values = deviations_um.first().zip(deviations_um.last());
                ends.zip(values)
                    .map_or(0.0, |((low, high), (first, last))| {
                        slope((high - low) / 1000.0, last - first)
                    })
            }
            ReferenceLine::LeastSquares => {
                let middle = mean(positions_mm);
                let pairs = positions_mm.iter().zip(deviations_um);
                let (mut numerator, mut denominator) = (0.0, 0.0);
                for (position, deviation) in pairs {
                    let arm = (position - middle) / 1000.0;
                    numerator += arm * deviation;
                    denominator += arm * arm;
                }
                slope(denominator, numerator)
            }
        }
    }

    /// Straightness: max − min of what is left beside the line, µm.
    pub fn straightness_um(self, positions_mm: &[f64], deviations_um: &[f64]) -> f64 {
        let slope = self.slope_um_per_m(positions_mm, deviations_um);
        let pairs = positions_mm.iter().zip(deviations_um);
        range(pairs.map(|(position, deviation)| deviation - slope * position / 1000.0))
    }
}

fn slope(length: f64, rise: f64) -> f64 {
    if length > 0.0 { rise / length } else { 0.0 }
}

fn mean(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 positions")]
    let count = values.len().max(1) as f64;
    values.iter().sum::<f64>() / count
}

/// Max − min; 0 of nothing.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        let (low, high) = ends.unwrap_or((value, value));
        Some((low.min(value), high.max(value)))
    });
    ends.map_or(0.0, |(low, high)| high - low)
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
