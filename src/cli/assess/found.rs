//! Each error as it was measured: its largest deviation and squareness, with U.

use crate::cli::squareness::squareness;
use crate::inputs::job::Job;
use crate::judge::after::alone;
use crate::judge::forecast::TermForecast;
use crate::machine::model::ErrorModel;
use crate::machine::separation::metric::Plane;
use crate::machine::separation::table::ErrorSource;
use crate::quantity::units::picometres;
use crate::text::problem::Problems;
use serde_json::{Map, Value, json};

/// What the measurement says by itself.
pub(super) struct Found {
    pub(super) terms: Value,
    pub(super) squareness: Value,
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
            let figures = json!({
                "before_um_per_m": picometres(found.um_per_m),
                "expanded_um_per_m": found.expanded_um_per_m.map(picometres),
            });
            Some((plane.key().to_string(), figures))
        });
        let figures = alone(model, job)?;
        Ok(Found {
            terms: Value::Object(figures.terms.iter().map(term).collect()),
            squareness: Value::Object(planes.collect::<Map<_, _>>()),
        })
    }
}

fn term(found: &TermForecast) -> (String, Value) {
    let figures = json!({
        "before_um": found.change.before_um,
        "u_um": found.change.u_um,
        "expanded_um": found.change.expanded_um,
        "at_most_um": found.change.at_most_um,
    });
    (found.term.to_string(), figures)
}
