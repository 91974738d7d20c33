//! Each error as it was measured: its largest deviation and squareness, with U.

use crate::cli::squareness::{PlaneFigures, squareness};
use crate::inputs::job::Job;
use crate::judge::after::alone;
use crate::judge::forecast::Change;
use crate::machine::model::ErrorModel;
use crate::machine::separation::metric::Plane;
use crate::machine::separation::table::ErrorSource;
use crate::quantity::axis::ErrorTerm;
use crate::text::problem::Problems;
use crate::text::words::Named;
use serde::Serialize;

/// What the measurement says by itself.
#[derive(Serialize)]
pub(super) struct Found {
    terms: Named<ErrorTerm, Largest>,
    squareness: Named<&'static str, PlaneFigures>,
}

/// Of a term.
#[derive(Serialize)]
struct Largest {
    before_um: f64,
    u_um: Option<f64>,
    expanded_um: Option<f64>,
    at_most_um: Option<f64>,
}

impl Found {
    /// `errors`: where the model comes from; absent = from an error table alone.
    pub(super) fn of(
        job: &Job,
        model: &ErrorModel,
        errors: Option<&ErrorSource>,
    ) -> Result<Found, Problems> {
        let planes = Plane::ALL.into_iter().filter_map(|plane| {
            let found = squareness(model, errors, plane)?;
            let figures = PlaneFigures {
                before_um_per_m: found.um_per_m,
                after_um_per_m: None,
                expanded_um_per_m: found.expanded_um_per_m,
            };
            Some((plane.key(), figures))
        });
        let terms = alone(model, job)?.terms.into_iter().map(|found| {
            let Change { before_um, u_um, expanded_um, at_most_um, .. } = found.change;
            (found.term, Largest { before_um, u_um, expanded_um, at_most_um })
        });
        Ok(Found { terms: terms.collect(), squareness: planes.collect() })
    }
}
