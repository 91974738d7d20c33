//! Formulas (1), (2) and (3): increments → nine curves and their closure; and the reference lines of
//! ISO 230-1 that their slopes and straightness refer to.

use super::linear::{Layout, Row};
use super::readings::Group;
use super::uncertainty::Budget;
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Volume};
use crate::quantity::units::Millimetres;

/// Values of one curve at the n + 1 interval ends of its moving axis, lowest first; µm, the
/// first is 0.
pub type Curve = Vec<f64>;

/// R/(2 V_j): noise of a separated increment by the noise of a measured one (docs/method.md §7).
pub(super) fn noise_gain(volume: &Volume, of: Axis) -> f64 {
    1.0 / (2.0 * volume.cosine(of))
}

/// Formula (1) as rows over what was measured. The slopes hold the tilt of the mirror.
pub(super) struct Steps<'a> {
    volume: &'a Volume,
    layout: Layout,
    /// Whether the axes turned without overrun: of the last cell the forward increments stand for both passes.
    turned: bool,
}

impl<'a> Steps<'a> {
    pub(super) fn new(budget: &Budget<'a>, layout: Layout) -> Steps<'a> {
        Steps { volume: budget.volume, layout, turned: budget.turned }
    }

    fn groups(&self) -> &'static [Group] {
        Group::all(self.layout.passes == 2)
    }

    /// m: the reading at the end of a step less that at its beginning.
    fn increment(&self, group: Group, d: Diagonal, axis: Axis, interval: usize) -> Row {
        let step = self.volume.interval(d, axis, interval);
        let is_turn = self.turned && step + 1 == self.volume.steps;
        let pass = if is_turn { Pass::Forward } else { group.pass(d, axis) };
        let node = self.volume.node_after(axis, step);
        let at = |node| self.layout.reading(pass, d, node);
        Row(vec![(at(node), 1.0), (at(node - 1), -1.0)])
    }

    /// δ of each interval of a term for one group of readings.
    pub(super) fn of(&self, term: ErrorTerm, group: Group) -> Vec<Row> {
        let gain = noise_gain(self.volume, term.of) / 2.0;
        let interval = |interval: usize| {
            let of = |d: Diagonal| {
                let sign = gain * d.sign(term.along) * d.sign(term.of);
                (sign, self.increment(group, d, term.along, interval))
            };
            let parts = Diagonal::ALL.map(of);
            Row::sum(parts.iter().map(|(sign, row)| (*sign, row)))
        };
        (0..self.volume.steps).map(interval).collect()
    }

    /// The same, mean of the groups.
    pub(super) fn mean(&self, term: ErrorTerm) -> Vec<Row> {
        let groups = self.groups();
        let share = 1.0 / groups.len() as f64;
        let all: Vec<Vec<Row>> = groups.iter().map(|group| self.of(term, *group)).collect();
        let at = |interval: usize| Row::sum(all.iter().map(|steps| (share, &steps[interval])));
        (0..self.volume.steps).map(at).collect()
    }

    /// Sum of the increments of a (diagonal, axis) pair, mean of the groups.
    fn sum(&self, d: Diagonal, axis: Axis) -> Row {
        let groups = self.groups();
        let share = 1.0 / groups.len() as f64;
        let mut sum = Row::default();
        for group in groups {
            for interval in 0..self.volume.steps {
                sum.add(share, &self.increment(*group, d, axis, interval));
            }
        }
        sum
    }

    /// Mean of the increments of each (diagonal, axis) pair, µm.
    pub(super) fn mean_increments(&self, z: &[f64]) -> PerDiagonal<PerAxis<f64>> {
        let n = self.volume.steps_f64();
        PerDiagonal::from_fn(|d| PerAxis::from_fn(|axis| self.sum(d, axis).dot(z) / n))
    }

    /// E_d: the total of a diagonal.
    pub(super) fn total(&self, d: Diagonal) -> Row {
        let sums = Axis::ALL.map(|axis| self.sum(d, axis));
        Row::sum(sums.iter().map(|sum| (1.0, sum)))
    }
}

/// w of formula (2): by axis, one value for each machine interval; µm.
pub(super) fn closures(
    volume: &Volume,
    increments: &PerDiagonal<PerAxis<Vec<f64>>>,
) -> PerAxis<Vec<f64>> {
    PerAxis::from_fn(|axis| {
        let interval = |i: usize| {
            let part = |d: Diagonal| closure_sign(d, axis) * increments[d][axis][i];
            Diagonal::ALL.into_iter().map(part).sum()
        };
        (0..volume.steps).map(interval).collect()
    })
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
    let before = after.checked_sub(1).and_then(pair);
    match (before, pair(after)) {
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
        let pairs = positions_mm.iter().zip(deviations_um);
        let (rise, length) = match self {
            ReferenceLine::EndPoints => {
                let mut pairs = pairs;
                let first = pairs.next().unwrap_or((&0.0, &0.0));
                let last = pairs.next_back().unwrap_or(first);
                (last.1 - first.1, (last.0 - first.0) / 1000.0)
            }
            ReferenceLine::LeastSquares => {
                let middle = mean(positions_mm.iter().copied());
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
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
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
