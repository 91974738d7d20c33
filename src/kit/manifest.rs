//! `manifest.json`: what a kit is made from, what it relies on, what it will achieve (contract §4).
//!
//! Figures are rounded to a picometre, so that the file is readable and the same everywhere.

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::{AxisState, ControlState};
use crate::judge::active::{ActiveControl, Origin};
use crate::judge::forecast::{Change, DiagonalForecast, Forecast};
use crate::kit::visit_plan::WhatDecides;
use crate::quantity::units::{Millimetres, picometres};
use crate::text::document::{refuse_large_page, sha256};
use crate::text::finding::Finding;
use crate::text::plain;
use crate::text::problem::Problem;
use crate::write::compensation::Placement;
use crate::write::target::Omission;
use serde::Serialize;
use serde_json::{Map, Value, json};
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

/// Zeros without a sign, however deep they stand.
fn without_signed_zeros(document: &mut Value) {
    let is_zero = |number: f64| number.abs() <= 0.0;
    match document {
        Value::Number(number) if number.is_f64() && number.as_f64().is_some_and(is_zero) => {
            *document = json!(0.0);
        }
        Value::Array(items) => items.iter_mut().for_each(without_signed_zeros),
        Value::Object(fields) => fields.values_mut().for_each(without_signed_zeros),
        _ => {}
    }
}

/// The bytes of a manifest, or of another JSON document, laid out for people.
pub fn bytes(document: &impl Serialize) -> Result<Vec<u8>, Problem> {
    const USUAL_BYTES: usize = 1 << 14;
    let mut page = Vec::with_capacity(USUAL_BYTES);
    let refuse = |error| Problem::new(format!("the document cannot be written: {error}"));
    let mut value = serde_json::to_value(document).map_err(refuse)?;
    without_signed_zeros(&mut value);
    serde_json::to_writer_pretty(&mut page, &value).map_err(refuse)?;
    page.push(b'\n');
    Ok(match std::str::from_utf8(&page).map(plain::json) {
        Ok(Cow::Owned(escaped)) => escaped.into_bytes(),
        _ => page,
    })
}

/// A file with its hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct HashedFile {
    /// Path: of an input as the job names it, of an output inside the kit.
    pub path: String,
    /// What it is for; inputs have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<&'static str>,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
    /// The input that was made from it and states its hash, e.g. an imported error table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub through: Option<String>,
}

/// Hash of an input.
pub fn hashed(path: &str, bytes: &[u8]) -> HashedFile {
    HashedFile { path: path.to_string(), role: None, sha256: sha256(bytes), through: None }
}

/// The tables that a kit follows: a link of the chain that `nonius history` prints.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Predecessor {
    /// Path, as the job named it.
    pub path: String,
    /// SHA-256 of the manifest of a kit; `null` of files that were read out of the control.
    pub manifest_sha256: Option<String>,
    /// The program that made the kit; `null` of a read-out.
    pub tool: Option<String>,
    /// Id of the profile it was read with.
    pub controller: String,
    /// The control's files that were read.
    pub files: Vec<HashedFile>,
}

impl Predecessor {
    /// The link to the tables that were active while measuring; `None` where none were.
    pub fn of(active: &ActiveControl, controller: &str) -> Option<Predecessor> {
        let (manifest_sha256, tool) = match &active.origin {
            Origin::Kit { manifest, tool } => (Some(sha256(manifest)), Some(tool.clone())),
            Origin::ReadOut(_) => (None, None),
            Origin::NoTables => return None,
        };
        let files = active.files.iter();
        Some(Predecessor {
            path: active.path.clone(),
            manifest_sha256,
            tool,
            controller: controller.to_string(),
            files: files.map(|(name, bytes)| hashed(name, bytes)).collect(),
        })
    }
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
    pub omitted: Vec<Value>,
    /// What the tables will leave, computed from the bytes of the files.
    pub forecast: Value,
    /// Where each term went.
    pub tables: Vec<Value>,
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

/// Terms without a table, as JSON.
pub fn omitted(omitted: &[Omission]) -> Vec<Value> {
    let one = |o: &Omission| json!({ "term": o.term.to_string(), "reason": o.reason });
    omitted.iter().map(one).collect()
}

/// Where each term went, as JSON.
pub fn placements(placements: &[Placement]) -> Vec<Value> {
    let one = |p: &Placement| {
        json!({
            "term": p.term.to_string(),
            "direction": p.direction.map(|d| d.symbol()),
            "place": p.place,
            "points": p.points,
            "count_um": picometres(p.count_um),
            "grid_residual_um": picometres(p.grid_residual_um),
            "fit_residual_um": p.fit_residual_um.map(picometres),
        })
    };
    placements.iter().map(one).collect()
}

/// The state of the control as JSON: what an update compares with its job. `backlash_um` gives the
/// backlash parameter of an axis where the kit knows it.
pub fn state(state: &ControlState, backlash_um: impl Fn(&str) -> Option<f64>) -> Value {
    let axis = |axis: &AxisState| {
        json!({
            "name": axis.name,
            "reference_mm": picometres(axis.reference.mm()),
            "reference_direction": axis.reference_direction.symbol(),
            "detection_unit_um": axis.detection_unit_um,
            "backlash_um": backlash_um(&axis.name).map(picometres),
            "bidirectional": axis.bidirectional,
            "interpolated": axis.interpolated,
        })
    };
    let axes: Vec<Value> = state.axes.iter().map(axis).collect();
    json!({ "unit": state.unit.word(), "axes": axes })
}

/// A forecast as JSON, with the keys of the manifest.
pub fn forecast(forecast: &Forecast) -> Value {
    let terms = forecast.terms.iter();
    let terms = terms.map(|term| (term.term.to_string(), change(&term.change, "after_um")));
    let unmeasured = forecast.unmeasured.iter();
    let unmeasured = unmeasured.filter(|(_, stretches)| !stretches.is_empty());
    let unmeasured = unmeasured.map(|(axis, stretches)| {
        let pair =
            |(from, to): &(Millimetres, Millimetres)| [from, to].map(|at| picometres(at.mm()));
        let pairs: Vec<[f64; 2]> = stretches.iter().map(pair).collect();
        (axis.key().to_string(), json!(pairs))
    });
    let mut document = json!({
        "max_residual_um": picometres(forecast.max_residual_um()),
        "max_residual_expanded_um": forecast.max_expanded_um().map(picometres),
        "max_residual_at_most_um": forecast.all_at_most_um().map(picometres),
        "terms": terms.collect::<Map<_, _>>(),
        "unmeasured_mm": unmeasured.collect::<Map<_, _>>(),
    });
    if !forecast.diagonals.is_empty() {
        document["diagonals"] = diagonals(&forecast.diagonals, "after_um");
    }
    if let Some(um) = forecast.without_reversal_um {
        document["without_reversal_um"] = json!(picometres(um));
    }
    document
}

/// A change as JSON; `after` names the key of the figure with tables.
pub(crate) fn change(change: &Change, after: &str) -> Value {
    json!({
        "before_um": picometres(change.before_um),
        after: picometres(change.after_um),
        "u_um": change.u_um.map(picometres),
        "expanded_um": change.expanded_um.map(picometres),
        "at_most_um": change.at_most_um.map(picometres),
    })
}

/// Body diagonals as JSON; `after` names the key of the figure with tables.
pub fn diagonals(diagonals: &[DiagonalForecast], after: &str) -> Value {
    let rows = diagonals.iter();
    let rows = rows.map(|diagonal| (diagonal.name.to_string(), change(&diagonal.change, after)));
    Value::Object(rows.collect())
}
