//! `manifest.json`: what a kit is made from, what it relies on, what it will achieve (contract §4).
//!
//! Figures are rounded to a picometre, so that the file is readable and the same everywhere.

use crate::control::claims::{Assumption, Precondition};
use crate::judge::active::{HashedFile, Machine, Predecessor, State};
use crate::judge::forecast::{Change, Forecast};
use crate::kit::field::ProofFigures;
use crate::kit::refusals;
use crate::kit::visit_plan::WhatDecides;
use crate::quantity::{ErrorTerm, Millimetres, picometres};
use crate::text::{Finding, NamedEntries, Problem, plain, refuse_large_page};
use crate::write::compensation::Placement;
use crate::write::target::Omission;
use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;

/// Version of the format.
pub const SCHEMA: u32 = 1;

/// Name of the file in a kit.
pub const MANIFEST: &str = "manifest.json";

/// The bytes of the manifest of a kit: no more than are read again.
pub(crate) fn bytes_of_kit(document: &impl Serialize) -> Result<Vec<u8>, Problem> {
    let bytes = bytes(document)?;
    refuse_large_page(MANIFEST, bytes.len())?;
    Ok(bytes)
}

/// A document as it is printed: its figures rounded to a picometre, zeros without a sign.
pub(crate) fn rounded(document: &impl Serialize) -> Result<Value, Problem> {
    let mut document = serde_json::to_value(document).map_err(refusals::not_written)?;
    round_figures(&mut document, false);
    Ok(document)
}

/// Figures are what stands below a key that ends in a unit, or in the name of a figure without one.
fn round_figures(document: &mut Value, is_figure: bool) {
    const UNITS: [&str; 6] = ["um", "mm", "m", "arcsec", "urad", "mrad"];
    const NAMES: [&str; 9] =
        ["fitted", "squared", "freedom", "factor", "estimate", "bias", "95", "u", "k"];
    match document {
        Value::Number(number) if number.is_f64() => {
            let round = |number| if is_figure { picometres(number) } else { number + 0.0 };
            *document = number.as_f64().map(round).into();
        }
        Value::Array(items) => items.iter_mut().for_each(|item| round_figures(item, is_figure)),
        Value::Object(fields) => fields.iter_mut().for_each(|(key, value)| {
            let last = key.rsplit('_').next().unwrap_or_default();
            let is_named = UNITS.contains(&last) || NAMES.contains(&last);
            round_figures(value, is_figure || is_named);
        }),
        _ => {}
    }
}

/// The bytes of a manifest, or of another JSON document, laid out for people.
pub fn bytes(document: &impl Serialize) -> Result<Vec<u8>, Problem> {
    const USUAL_BYTES: usize = 1 << 14;
    let mut page = Vec::with_capacity(USUAL_BYTES);
    let document = rounded(document)?;
    serde_json::to_writer_pretty(&mut page, &document).map_err(refusals::not_written)?;
    page.push(b'\n');
    Ok(match std::str::from_utf8(&page).map(plain::json) {
        Ok(Cow::Owned(escaped)) => escaped.into_bytes(),
        _ => page,
    })
}

/// The manifest of a kit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// Version of the format.
    pub schema: u32,
    /// Name and version of the program.
    pub tool: &'static str,
    /// Id of the profile.
    pub controller: String,
    /// What went in.
    pub inputs: Vec<HashedFile>,
    /// The tables that were active while measuring and that this kit replaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predecessor: Option<Predecessor>,
    /// What was written.
    pub files: Vec<HashedFile>,
    /// What is assumed.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// Terms without a table.
    pub omitted: Vec<Omission>,
    /// What the tables will leave, computed from the bytes of the files.
    pub forecast: ForecastFigures,
    /// Where each term went.
    pub tables: Vec<Placement>,
    /// The state of the control outside the files that the tables are made for.
    pub state: State,
    /// Machine and protocol, as stated in the job.
    pub machine: Machine,
    /// What each sign proof has to show, computed from the bytes of its file; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sign_proofs: Vec<ProofFigures>,
    /// What keeps a limit from being decided, and what would decide it; absent where it passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub what_decides: Option<WhatDecides>,
    /// Why the verdict is undecided at most; absent where nothing is doubtful.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Finding>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

/// A forecast with the keys of the manifest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForecastFigures {
    max_residual_um: f64,
    max_residual_expanded_um: Option<f64>,
    max_residual_at_most_um: Option<f64>,
    terms: NamedEntries<ErrorTerm, Change>,
    /// Stretches of tables that nobody measured.
    unmeasured_mm: NamedEntries<&'static str, Vec<(Millimetres, Millimetres)>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagonals: Option<NamedEntries<&'static str, Change>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    without_reversal_um: Option<f64>,
}

impl From<&Forecast> for ForecastFigures {
    fn from(forecast: &Forecast) -> ForecastFigures {
        let unmeasured = forecast.unmeasured.iter().filter(|(_, found)| !found.is_empty());
        let diagonals = forecast.diagonals.iter().map(|of| (of.diagonal.name(), of.change));
        ForecastFigures {
            max_residual_um: forecast.max_residual_um(),
            max_residual_expanded_um: forecast.max_expanded_um(),
            max_residual_at_most_um: forecast.all_at_most_um(),
            terms: forecast.terms.iter().map(|of| (of.term, of.change)).collect(),
            unmeasured_mm: unmeasured.map(|(axis, found)| (axis.key(), found.clone())).collect(),
            diagonals: (!forecast.diagonals.is_empty()).then(|| diagonals.collect()),
            without_reversal_um: forecast.without_reversal_um,
        }
    }
}
