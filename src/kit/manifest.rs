//! `manifest.json`: what a kit is made from, what it relies on, what it will achieve (contract §4).
//!
//! Figures are rounded to a picometre, so that the file is readable and the same everywhere.

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::{AxisState, ControlState};
use crate::judge::active::{ActiveControl, Origin};
use crate::judge::forecast::Forecast;
pub use crate::kit::inputs::{HashedFile, hashed};
use crate::kit::visit_plan::WhatDecides;
use crate::quantity::picometres;
use crate::text::{Finding, Named, Problem, plain, refuse_large_page, sha256};
use crate::write::compensation::Placement;
use crate::write::target::Omission;
use serde::Serialize;
use serde_json::{Value, json};
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
    let mut document = serde_json::to_value(document).map_err(|error| refused(&error))?;
    round_figures(&mut document, false);
    Ok(document)
}

fn refused(error: &serde_json::Error) -> Problem {
    Problem::new(format!("the document cannot be written: {error}"))
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
    serde_json::to_writer_pretty(&mut page, &document).map_err(|error| refused(&error))?;
    page.push(b'\n');
    Ok(match std::str::from_utf8(&page).map(plain::json) {
        Ok(Cow::Owned(escaped)) => escaped.into_bytes(),
        _ => page,
    })
}

/// A document without some of its fields.
pub(crate) fn without(mut document: Value, is_absent: impl Fn(&str, &Value) -> bool) -> Value {
    let fields = document.as_object_mut();
    fields.into_iter().for_each(|of| of.retain(|key, value| !is_absent(key, value)));
    document
}

/// A document without what is not known.
pub(crate) fn known(document: Value) -> Value {
    without(document, |_, value| value.is_null())
}

/// The fields of several documents, one after the other.
pub(crate) fn flat<const N: usize>(documents: [Value; N]) -> Value {
    let fields = documents.into_iter().map(|of| of.as_object().cloned().unwrap_or_default());
    Value::Object(fields.flatten().collect())
}

/// The link to the tables that were active while measuring, which `nonius history` follows; `None` where none were. A kit
/// is known by its manifest, files that were read out of the control by their hashes.
pub(super) fn predecessor(active: &ActiveControl, controller: &str) -> Option<Value> {
    let (manifest_sha256, tool) = match &active.origin {
        Origin::Kit { manifest, tool } => (Some(sha256(manifest)), Some(tool)),
        Origin::ReadOut(_) => (None, None),
        Origin::NoTables => return None,
    };
    let files = active.files.iter().map(|(name, bytes)| hashed(name, bytes));
    Some(json!({
        "path": active.path,
        "manifest_sha256": manifest_sha256,
        "tool": tool,
        "controller": controller,
        "files": files.collect::<Vec<_>>(),
    }))
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
    pub predecessor: Option<Value>,
    /// What was written.
    pub files: Vec<HashedFile>,
    /// What is assumed.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// Terms without a table.
    pub omitted: Vec<Omission>,
    /// What the tables will leave, computed from the bytes of the files.
    pub forecast: Value,
    /// Where each term went.
    pub tables: Vec<Placement>,
    /// The state of the control outside the files that the tables are made for.
    pub state: Value,
    /// Machine and protocol, as stated in the job.
    pub machine: Value,
    /// What each sign proof has to show, computed from the bytes of its file; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sign_proofs: Vec<Value>,
    /// What keeps a limit from being decided, and what would decide it; absent where it passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub what_decides: Option<WhatDecides>,
    /// Why the verdict is undecided at most; absent where nothing is doubtful.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Finding>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

/// The state of the control, which an update compares with its job; a backlash parameter where the kit knows it.
pub(super) fn state(of: &ControlState, backlash_um: impl Fn(&str) -> Option<f64>) -> Value {
    let axis = |axis: &AxisState| {
        json!({
            "name": axis.name,
            "reference_mm": axis.reference,
            "reference_direction": axis.reference_direction,
            "detection_unit_um": axis.detection_unit_um,
            "backlash_um": backlash_um(&axis.name),
            "bidirectional": axis.bidirectional,
            "interpolated": axis.interpolated,
        })
    };
    json!({ "unit": of.unit, "axes": of.axes.iter().map(axis).collect::<Vec<_>>() })
}

/// The figures of a forecast; stretches of tables that nobody measured.
pub(super) fn figures(forecast: &Forecast) -> Value {
    let unmeasured = forecast.unmeasured.iter().filter(|(_, found)| !found.is_empty());
    let diagonals = forecast.diagonals.iter().map(|of| (of.diagonal.name(), of.change));
    let diagonals = (!forecast.diagonals.is_empty()).then(|| Named::from_iter(diagonals));
    let document = json!({
        "max_residual_um": forecast.max_residual_um(),
        "max_residual_expanded_um": forecast.max_expanded_um(),
        "max_residual_at_most_um": forecast.all_at_most_um(),
        "terms": Named::from_iter(forecast.terms.iter().map(|of| (of.term, of.change))),
        "unmeasured_mm": Named::from_iter(unmeasured.map(|(axis, found)| (axis.key(), found))),
        "diagonals": diagonals,
        "without_reversal_um": forecast.without_reversal_um,
    });
    without(document, |key, value| {
        value.is_null() && matches!(key, "diagonals" | "without_reversal_um")
    })
}
