//! Values between the positions of a table: straight lines, ends held.

use crate::quantity::units::Millimetres;

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
