//! What is read of the `manifest.json` of a kit. A part that it lacks is missing; the state of an axis is whole.

use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, Role};
use crate::judge::active::{ActiveControl, Origin};
use crate::quantity::{Direction, Millimetres};
use crate::text::sha256;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A file with its hash.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct HashedFile {
    /// Path: of an input as the job names it, of an output inside the kit.
    pub path: String,
    /// What it is for; inputs have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
    /// The input that was made from it and states its hash, e.g. an imported error table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub through: Option<String>,
}

/// Hash of an input.
pub fn hashed(path: &str, bytes: &[u8]) -> HashedFile {
    HashedFile { path: path.to_string(), sha256: sha256(bytes), ..HashedFile::default() }
}

/// The tables that a kit follows: a link of the chain that `nonius history` prints.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
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

/// The state of the control: what an update compares with its job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub(crate) unit: ControlUnit,
    pub(crate) axes: Vec<AxisOfState>,
}

/// An axis of it; its backlash parameter where the kit knows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AxisOfState {
    pub(crate) name: String,
    pub(crate) reference_mm: Millimetres,
    pub(crate) reference_direction: Direction,
    pub(crate) detection_unit_um: Option<f64>,
    pub(crate) backlash_um: Option<f64>,
    pub(crate) bidirectional: bool,
    pub(crate) interpolated: bool,
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

    /// An axis by the control's name of it.
    pub(crate) fn axis(&self, name: &str) -> Option<&AxisOfState> {
        self.axes.iter().find(|axis| axis.name.eq_ignore_ascii_case(name))
    }
}

/// The machine, and who measured it when and how.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Machine {
    pub(crate) name: Option<String>,
    pub(crate) serial: Option<String>,
    pub(crate) chain: Option<String>,
    pub(crate) measured: Option<String>,
    pub(crate) protocol: BTreeMap<String, String>,
}

/// Of the manifest of a kit what is compared with a job, with files and with other kits.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct KitManifest {
    /// Name and version of the program.
    pub(crate) tool: Option<String>,
    /// Id of the profile.
    pub(crate) controller: Option<String>,
    /// What went in; `None` = not listed.
    pub(crate) inputs: Option<Vec<HashedFile>>,
    /// The tables that were active while measuring.
    pub(crate) predecessor: Option<Predecessor>,
    /// What was written.
    pub(crate) files: Vec<HashedFile>,
    /// The control outside the files; `None` of a kit from before manifests held it.
    pub state: Option<State>,
    /// The machine.
    pub(crate) machine: Machine,
}
