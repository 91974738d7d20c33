//! `manifest.json`: what a kit is made from, what it relies on, what it will achieve (contract §4).
//!
//! Figures are rounded to a picometre, so that the file is readable and the same everywhere.

use crate::control::claims::{Assumption, Precondition};
use crate::control::control_state::ControlState;
use crate::control::controller::ControlUnit;
use crate::judge::active::{ActiveControl, Origin};
use crate::judge::forecast::{Change, Forecast};
use crate::kit::field::Shown;
pub use crate::kit::inputs::{HashedFile, hashed};
use crate::kit::refusals;
use crate::kit::visit_plan::WhatDecides;
use crate::quantity::{Direction, ErrorTerm, Millimetres, picometres};
use crate::text::{Finding, Named, Problem, plain, refuse_large_page, sha256};
use crate::write::compensation::Placement;
use crate::write::target::Omission;
use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;

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
    pub sign_proofs: Vec<Shown>,
    /// What keeps a limit from being decided, and what would decide it; absent where it passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub what_decides: Option<WhatDecides>,
    /// Why the verdict is undecided at most; absent where nothing is doubtful.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Finding>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

/// The state of the control: what an update compares with its job.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct State {
    unit: ControlUnit,
    axes: Vec<AxisOfState>,
}

/// An axis of it; its backlash parameter where the kit knows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct AxisOfState {
    name: String,
    reference_mm: Millimetres,
    reference_direction: Direction,
    detection_unit_um: Option<f64>,
    backlash_um: Option<f64>,
    bidirectional: bool,
    interpolated: bool,
}

impl State {
    /// Of a control; `backlash_um` gives the backlash parameter of an axis.
    pub fn of(state: &ControlState, backlash_um: impl Fn(&str) -> Option<f64>) -> State {
        let axes = state.axes.iter().map(|axis| AxisOfState {
            name: axis.name.clone(),
            reference_mm: axis.reference,
            reference_direction: axis.reference_direction,
            detection_unit_um: axis.detection_unit_um,
            backlash_um: backlash_um(&axis.name),
            bidirectional: axis.bidirectional,
            interpolated: axis.interpolated,
        });
        State { unit: state.unit, axes: axes.collect() }
    }
}

/// The machine, and who measured it when and how.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    pub(super) name: String,
    pub(super) serial: Option<String>,
    pub(super) chain: Option<String>,
    pub(super) measured: Option<String>,
    pub(super) protocol: BTreeMap<String, String>,
}

/// A forecast with the keys of the manifest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForecastFigures {
    max_residual_um: f64,
    max_residual_expanded_um: Option<f64>,
    max_residual_at_most_um: Option<f64>,
    terms: Named<ErrorTerm, Change>,
    /// Stretches of tables that nobody measured.
    unmeasured_mm: Named<&'static str, Vec<(Millimetres, Millimetres)>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagonals: Option<Named<&'static str, Change>>,
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
