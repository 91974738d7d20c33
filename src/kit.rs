//! A kit from end to end, in memory: model → plan → numbers → text → read back → forecast.
//!
//! Nothing here touches a file. What is written later is exactly `Kit::files`, and the forecast
//! comes from these bytes through the readers and the emulator, never from the numbers that
//! went in.

pub mod directory;
mod field;
pub mod findings;
mod inputs;
mod loaded;
mod made;
pub mod manifest;
mod movement;
pub mod program_kit;
mod rollback;
pub mod second_look;
pub mod simulate;
mod verification;
mod ways;

use crate::control::controller::Profile;
use crate::inputs::job::ActiveTables;
use crate::judge::conformity::Verdict;
use crate::judge::disagreement;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::{Forecast, forecast, judged_ranges};
use crate::kit::findings::KitFinding;
pub use crate::kit::manifest::hashed;
use crate::kit::manifest::{HashedFile, Manifest, Predecessor, SCHEMA};
use crate::quantity::axis::Axis;
use crate::read::emulate::{CannotEmulate, Emulator};
pub use crate::read::emulator;
use crate::read::{KitFile, ReadBack, read, unread};
pub use crate::text::document::sha256;
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};
use crate::write::compensation::Compiled;
use crate::write::emit::{self, RenderedFile, TOOL, Templates};
use crate::write::plan::{Plan, plan};
use crate::write::target::wants;
pub(crate) use inputs::cannot_emulate;
use inputs::judged;
pub use inputs::{Inputs, remarks};
pub use loaded::{LoadedControl, load};
pub(crate) use loaded::{load_own, load_read_out};
use made::{Made, as_kit_file};
use serde_json::json;
pub use verification::{Verification, verify, verify_read_out};

/// A complete kit.
#[derive(Clone, Debug)]
pub struct Kit {
    /// What was planned.
    pub plan: Plan,
    /// In the control's numbers.
    pub compiled: Compiled,
    /// The control's files.
    pub files: Vec<RenderedFile>,
    /// What they will leave.
    pub forecast: Forecast,
    /// Why the measured errors are doubtful.
    pub doubts: Vec<Finding>,
    /// Forecast against the acceptance of the job; undecided at most where there are doubts.
    pub verdict: Verdict,
    /// What to change for a better answer.
    pub ways: Vec<Finding>,
    /// The manifest.
    pub manifest: Manifest,
}

impl Kit {
    /// The control's files as a reader takes them.
    pub fn kit_files(&self) -> Vec<KitFile<'_>> {
        as_read(&self.files)
    }

    /// The bytes of `manifest.json`.
    pub fn manifest_bytes(&self) -> Result<Vec<u8>, Problems> {
        Ok(manifest::bytes_of_kit(&self.manifest)?)
    }
}

/// What a template sees.
pub(crate) fn template_context(inputs: &Inputs) -> Result<emit::Context, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    emit::context(task, &inputs.compile(&plan)?)
}

/// Makes a kit. Refused unless every file reads back to exactly what was meant.
pub fn generate(inputs: &Inputs) -> Result<Kit, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let mut compiled = inputs.compile(&plan)?;
    let context = emit::context(task, &compiled)?;
    let templates = Templates::default();
    let mut files = emit::render(task, &templates, &context)?;
    let read = read_back(&inputs.profile, &files)?;
    ensure_same(inputs, &plan, &compiled, &read)?;
    let absent = disagreement::absent(&inputs.profile, &compiled.tables, &read);
    compiled.notes.extend(absent);
    if inputs.profile.comments.value {
        let names = emit::other_letters(&inputs.job, &inputs.profile.name);
        compiled.notes.extend(names);
    }
    let control =
        emulator(&inputs.profile, &read.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let forecast = forecast(
        inputs.machine(),
        &plan,
        control.as_ref(),
        &judged_ranges(&inputs.job, inputs.as_measured()),
    )
    .map_err(|e| cannot_emulate(&e))?;
    let unread = unread(&inputs.profile, &as_read(&files));
    let doubts: Vec<Finding> = doubts(inputs).into_iter().chain(unread).collect();
    let verdict = judged(&forecast, inputs, &doubts);
    let ways = ways::ways(inputs, &plan, &compiled.placements, &forecast, &doubts);
    let field = field::make(&Made {
        inputs,
        plan: &plan,
        compiled: &compiled,
        context: &context,
        templates: &templates,
        files: &files,
        read: &read,
        forecast: &forecast,
        verdict,
        doubts: &doubts,
    })?;
    files.extend(field.files);
    compiled.notes.extend(field.notes);
    let mut manifest = build_manifest(inputs, &plan, &compiled, &files, &forecast);
    manifest.sign_proofs = field.sign_proofs;
    manifest.doubts.clone_from(&doubts);
    Ok(Kit {
        plan,
        compiled,
        files,
        forecast,
        doubts,
        verdict,
        ways,
        manifest,
    })
}

/// Why the measured errors that the job asks for are doubtful.
fn doubts(inputs: &Inputs) -> Vec<Finding> {
    let measured = inputs.as_measured();
    let mut doubts = measured.doubts(|term| wants(&inputs.job, term));
    doubts.extend(measured.unlikely_small(inputs.job.measurement.uncertainty.noise_um));
    if inputs.job.measurement.active == ActiveTables::NotStated {
        doubts.push(KitFinding::ActiveNotStated.into());
    }
    doubts
}

fn as_read(files: &[RenderedFile]) -> Vec<KitFile<'_>> {
    files.iter().map(as_kit_file).collect()
}

fn read_back(profile: &Profile, files: &[RenderedFile]) -> Result<ReadBack, Problems> {
    read(profile, &as_read(files)).map_err(|problems| {
        let mut all = Problems::from(
            Problem::new("the files that the templates made cannot be read back, so nothing is written")
                .help("a template of your own has to keep to the format of the dialect (docs/templates.md)"),
        );
        all.extend(problems);
        all
    })
}

/// A template that drops, doubles, changes or adds something is found here.
fn ensure_same(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    read: &ReadBack,
) -> Result<(), Problems> {
    let (sentences, _) = differences(inputs, plan, compiled, read);
    let same_tables = compiled.tables == read.tables;
    if same_tables && sentences.is_empty() {
        return Ok(());
    }
    let headline = if same_tables {
        Problem::new("the files that the templates made set something else than was meant, so nothing is written")
            .help("a kit sets what its tables need and nothing else; `nonius context JOB` prints what a template sees")
    } else {
        Problem::new("the files that the templates made do not read back to the tables that were meant, so nothing is written")
            .help("a template leaves something out, doubles it or changes a number; `nonius context JOB` prints what it sees")
    };
    let mut problems = Problems::from(headline);
    for words in sentences {
        problems.push(Problem::new(words.to_string()));
    }
    Err(problems)
}

/// How files differ from what was compiled: what the tables do to the axes first, then what else
/// the files hold; and the control that they would make, or why there is none.
fn differences(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    read: &ReadBack,
) -> (Vec<Finding>, Result<Box<dyn Emulator>, CannotEmulate>) {
    let profile = &inputs.profile;
    let found = emulator(profile, &read.tables, &compiled.state);
    let contents = |diagnosis| disagreement::contents(profile, &compiled.tables, read, diagnosis);
    if let (true, Ok(_)) = (compiled.tables == read.tables, &found) {
        // The same tables do the same: only what the files hold beside them is left to judge.
        return (contents(None), found);
    }
    let mut findings = disagreement::measuring_systems(&compiled.tables, &read.tables);
    let wanted = emulator(profile, &compiled.tables, &compiled.state);
    let diagnosis = match (&wanted, &found) {
        (Ok(wanted), Ok(found)) => {
            let diagnosis = disagreement::compare(plan, wanted.as_ref(), found.as_ref());
            findings.extend(diagnosis.findings.iter().cloned());
            Some(diagnosis)
        }
        (Err(reason), _) | (_, Err(reason)) => {
            findings.push(not_emulated(reason.clone()));
            None
        }
    };
    findings.extend(contents(diagnosis.as_ref()));
    (findings, found)
}

fn build_manifest(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    files: &[RenderedFile],
    forecast: &Forecast,
) -> Manifest {
    let job = &inputs.job;
    Manifest {
        schema: SCHEMA,
        tool: TOOL,
        controller: inputs.profile.id.clone(),
        inputs: inputs.hashes.clone(),
        predecessor: inputs
            .active
            .as_ref()
            .and_then(|active| Predecessor::of(active, &inputs.profile.id)),
        files: files
            .iter()
            .map(|file| HashedFile {
                path: file.path.clone(),
                role: Some(file.role.word()),
                sha256: sha256(&file.bytes),
                through: None,
            })
            .collect(),
        assumptions: compiled.assumptions.clone(),
        preconditions: compiled.preconditions.clone(),
        omitted: manifest::omitted(&plan.omitted),
        forecast: manifest::forecast(forecast),
        tables: manifest::placements(&compiled.placements),
        state: manifest::state(&compiled.state, |name| {
            named_backlash(inputs, plan, compiled, name)
        }),
        machine: json!({
            "name": job.machine.name,
            "serial": job.machine.serial,
            "chain": job.machine.chain.map(|chain| chain.to_string()),
            "measured": job.measurement.date,
            "protocol": job.measurement.protocol.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
        }),
        sign_proofs: Vec::new(),
        doubts: Vec::new(),
        notes: [compiled.notes.clone(), forecast.worsened()].concat(),
    }
}

/// The backlash parameter of an axis that goes with these tables, µm: the one they name, else the
/// one that acted while measuring; `None` where neither is known.
fn named_backlash(inputs: &Inputs, plan: &Plan, compiled: &Compiled, name: &str) -> Option<f64> {
    let has = |axis: &Axis| plan.names[*axis].iter().any(|own| own == name);
    let axis = Axis::ALL.into_iter().find(has)?;
    if plan.sets_backlash(axis) {
        return Some(compiled.state.axis(name)?.backlash_um);
    }
    inputs.active.as_ref()?.backlash_um[axis]
}
