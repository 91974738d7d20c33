//! Squareness of each plane, with U where readings determine it.

use crate::machine::model::ErrorModel;
use crate::machine::separation::metric::Plane;
use crate::machine::separation::table::ErrorSource;
use crate::text::words::Named;
use serde::Serialize;

/// What documents say of a plane.
#[derive(Serialize)]
pub(super) struct PlaneFigures {
    pub(super) before_um_per_m: f64,
    /// Only where there are tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) after_um_per_m: Option<Option<f64>>,
    /// U of the last of them.
    pub(super) expanded_um_per_m: Option<f64>,
}

/// A machine as it was measured, and what it was measured with where that is known.
pub(super) type Measured<'a> = (&'a ErrorModel, Option<&'a ErrorSource>);

/// Of each plane that is known as found: then and, where there are tables, as left, as far as that was measured.
pub(super) fn planes(
    found: Measured<'_>,
    left: Option<Option<Measured<'_>>>,
) -> Named<&'static str, PlaneFigures> {
    let planes = Plane::ALL.into_iter().filter_map(|plane| {
        let before = squareness(found, plane)?;
        let after = left.flatten().and_then(|left| squareness(left, plane));
        let figures = PlaneFigures {
            before_um_per_m: before.0,
            after_um_per_m: left.map(|_| after.map(|(um_per_m, _)| um_per_m)),
            expanded_um_per_m: after.unwrap_or(before).1,
        };
        Some((plane.key(), figures))
    });
    planes.collect()
}

/// Squareness of a plane with U (95 %; `None` = not stated), µm/m: of readings what their totals say, else the sum of
/// the slopes of both terms; `None` = not determined, or not both measured.
///
/// limits  an error table states no uncertainty of a slope
fn squareness((model, errors): Measured<'_>, plane: Plane) -> Option<(f64, Option<f64>)> {
    if let Some(ErrorSource::Separated { separation, .. }) = errors {
        let found = separation.metric.squareness(plane);
        return Some((found.um_per_m?, found.expanded_um_per_m()));
    }
    let (first, second) = plane.axes();
    Some((model.squareness_um_per_m(first, second)?, None))
}
