//! Squareness of each plane, with U where readings determine it.

use crate::machine::model::ErrorModel;
use crate::machine::separation::metric::Plane;
use crate::machine::separation::table::ErrorSource;
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

/// Squareness of a plane, µm/m.
#[derive(Clone, Copy)]
pub(super) struct Squareness {
    pub(super) um_per_m: f64,
    /// U, 95 %; `None` = not stated.
    pub(super) expanded_um_per_m: Option<f64>,
}

/// Of readings what their totals say, else the sum of the slopes of both terms; `None` = not determined, or not
/// both measured.
///
/// limits  an error table states no uncertainty of a slope
pub(super) fn squareness(
    model: &ErrorModel,
    errors: Option<&ErrorSource>,
    plane: Plane,
) -> Option<Squareness> {
    if let Some(ErrorSource::Separated { separation, .. }) = errors {
        return Some(Squareness {
            um_per_m: separation.metric.squareness(plane).um_per_m?,
            expanded_um_per_m: separation.metric.squareness(plane).expanded_um_per_m(),
        });
    }
    let (first, second) = plane.axes();
    Some(Squareness {
        um_per_m: model.squareness_um_per_m(first, second)?,
        expanded_um_per_m: None,
    })
}
