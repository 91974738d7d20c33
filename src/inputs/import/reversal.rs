//! The reversal of an imported curve: the one figure that shows a direction or sign taken wrongly.

use crate::inputs::error_table::DraftSeries;
use crate::quantity::axis::{Axis, Direction};

/// A reversal above this is no scatter (the limit of `generate`), µm.
const NOTABLE_UM: f64 = 0.5;

/// A sentence for each axis whose positioning has B > 0.
///
/// formula B = mean deviation moving + minus mean deviation moving −, over all positions (ISO 230-2)
/// limits  positions of the two directions are not compared: it is a warning, no figure
pub(super) fn warnings(series: &[DraftSeries]) -> Vec<String> {
    let of = |axis: Axis| {
        let plus = mean_um(series, axis, Direction::Plus)?;
        let um = plus - mean_um(series, axis, Direction::Minus)?;
        (um > NOTABLE_UM).then(|| {
            format!(
                "E{axis}{axis}: B = {um:+.3} µm is above 0, ordinary lost motion gives B < 0: are the way of the targets, the directions or the sign stated as they were?"
            )
        })
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

fn mean_um(series: &[DraftSeries], axis: Axis, direction: Direction) -> Option<f64> {
    let mut of_axis = series.iter().filter(|s| s.axis == axis);
    let series = of_axis.find(|s| s.direction == Some(direction))?;
    let values = series.deviations_um[axis].as_ref()?;
    #[allow(clippy::cast_precision_loss, reason = "a table has few points")]
    let count = values.len() as f64;
    Some(values.iter().sum::<f64>() / count)
}
