//! A kit from end to end, in memory: model → plan → numbers → text → read back → forecast.
//!
//! Nothing here touches a file. `Kit::files` is written later byte for byte, and the forecast is computed
//! from these bytes by the readers and the emulator, never from the input numbers.

pub mod alternatives;
pub mod directory;
mod field;
pub mod findings;
mod inputs;
mod loaded;
pub mod manifest;
pub mod program_kit;
mod refusals;
pub mod simulate;
mod verification;
pub mod visit;
pub mod visit_plan;

use crate::control::controller::KitFile;
use crate::inputs::job::Job;
pub use crate::judge::active::hashed;
use crate::judge::active::{HashedFile, Machine, Predecessor, State};
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::forecast::Forecast;
use crate::kit::manifest::{Manifest, SCHEMA};
pub use crate::read::emulator;
pub use crate::text::sha256;
use crate::text::{Finding, Problems};
use crate::write::compensation::Compiled;
use crate::write::emit::{self, TOOL};
use crate::write::plan::Plan;
use field::ProofFigures;
pub(crate) use inputs::JobTables;
pub use inputs::{Inputs, remarks};
pub use loaded::Loaded;
use loaded::{BareKit, named_backlash};
use serde::Serialize;
pub(crate) use verification::second_look;
pub use verification::{SecondLook, Verification, forecast, verify, verify_read_out};

/// A complete kit.
#[derive(Clone, Debug)]
pub struct Kit {
    /// What was planned.
    pub plan: Plan,
    /// In the control's numbers.
    pub compiled: Compiled,
    /// The control's files.
    pub files: Vec<KitFile>,
    /// What they add to every error.
    pub(crate) effect: Field,
    /// What they will leave.
    pub forecast: Forecast,
    /// Forecast against the acceptance of the job; undecided at most where there are doubts.
    pub verdict: Verdict,
    /// What to change for a better answer.
    pub ways: Vec<Finding>,
    /// The manifest.
    pub manifest: Manifest,
}

impl Kit {
    /// The control with its files.
    pub(crate) fn load<'a>(&self, inputs: &'a Inputs) -> Result<Loaded<'a>, Problems> {
        Loaded::own(JobTables::of(inputs)?, &self.files)
    }

    /// The bytes of `manifest.json`.
    pub fn manifest_bytes(&self) -> Result<Vec<u8>, Problems> {
        Ok(manifest::bytes_of_kit(&self.manifest)?)
    }
}

/// What a template sees.
pub(crate) fn template_context(inputs: &Inputs) -> Result<impl Serialize + use<>, Problems> {
    emit::context(inputs.task(), &JobTables::of(inputs)?.compiled)
}

/// Makes a kit. Refused unless every file reads back to exactly what was meant.
pub fn generate(inputs: &Inputs) -> Result<Kit, Problems> {
    let mut made = BareKit::of(inputs)?;
    let ways = alternatives::ways(&made);
    let sign_proofs = field::add(&mut made)?;
    let manifest = manifest_of(&made, sign_proofs);
    let BareKit { plan, compiled, files, effect, forecast, verdict, .. } = made;
    Ok(Kit { plan, compiled, files, effect, forecast, verdict, ways, manifest })
}

fn manifest_of(made: &BareKit<'_>, sign_proofs: Vec<ProofFigures>) -> Manifest {
    let BareKit { inputs, plan, compiled, files, forecast, doubts, .. } = made;
    let (Job { machine, measurement, .. }, controller) = (&inputs.job, inputs.profile.id.clone());
    let active = inputs.active.as_ref();
    let hashed =
        |file: &KitFile| HashedFile { role: Some(file.role), ..hashed(&file.path, &file.bytes) };
    let decides = doubts.is_empty().then(|| inputs.judged(forecast).what_decides());
    Manifest {
        schema: SCHEMA,
        tool: TOOL,
        predecessor: active.and_then(|active| Predecessor::of(active, &controller)),
        controller,
        inputs: inputs.hashes.clone(),
        files: files.iter().map(hashed).collect(),
        assumptions: compiled.assumptions.clone(),
        preconditions: compiled.preconditions.clone(),
        omitted: plan.omitted.clone(),
        forecast: forecast.into(),
        tables: compiled.placements.clone(),
        state: State::of(&compiled.state, |name| named_backlash(inputs, plan, compiled, name)),
        machine: Machine {
            name: Some(machine.name.clone()),
            serial: machine.serial.clone(),
            chain: machine.chain.map(|chain| chain.to_string()),
            measured: measurement.date.clone(),
            protocol: measurement.protocol.iter().cloned().collect(),
        },
        what_decides: decides.flatten(),
        sign_proofs,
        doubts: doubts.clone(),
        notes: [compiled.notes.clone(), forecast.worsened()].concat(),
    }
}
