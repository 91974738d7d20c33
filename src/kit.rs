//! A kit from end to end, in memory: model → plan → numbers → text → read back → forecast.
//!
//! Nothing here touches a file. What is written later is exactly `Kit::files`, and the forecast
//! comes from these bytes through the readers and the emulator, never from the numbers that
//! went in.

use crate::compensation::{Compiled, compile};
use crate::control_state::ControlState;
use crate::controller::{Dialect, Profile};
use crate::disagreement;
use crate::emit::{self, RenderedFile, TOOL};
use crate::emulate::fanuc::FanucControl;
use crate::emulate::generic::GenericControl;
use crate::emulate::siemens::SiemensControl;
use crate::emulate::{CannotEmulate, Emulator};
use crate::error_table::ErrorTable;
use crate::forecast::{Forecast, Verdict, forecast};
use crate::job::Job;
use crate::manifest::{self, HashedFile, Manifest, SCHEMA};
use crate::model::ErrorModel;
use crate::plan::{Plan, Task, plan};
use crate::problem::{Problem, Problems};
use crate::readback::kit::{KitFile, ReadBack, read};
use crate::table::Tables;
use crate::target::wants;
use serde_json::json;
use sha2::{Digest, Sha256};

/// The inputs of a kit, read and checked.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The job.
    pub job: Job,
    /// The control.
    pub profile: Profile,
    /// The measured errors as curves.
    pub model: ErrorModel,
    /// Every file that went in, with its hash.
    pub hashes: Vec<HashedFile>,
}

impl Inputs {
    /// Puts checked files together.
    pub fn new(
        job: Job,
        profile: Profile,
        table: &ErrorTable,
        hashes: Vec<HashedFile>,
    ) -> Result<Inputs, Problems> {
        let model = ErrorModel::build(&job, table)?;
        Ok(Inputs {
            job,
            profile,
            model,
            hashes,
        })
    }

    /// Adds the angular errors of a table of their own (`measurement.angles`).
    pub fn with_angles(mut self, table: &ErrorTable) -> Result<Inputs, Problems> {
        self.model.add_angles(&self.job, table)?;
        Ok(self)
    }

    fn task(&self) -> Task<'_> {
        Task {
            job: &self.job,
            profile: &self.profile,
            model: &self.model,
        }
    }
}

/// Hash of an input.
pub fn hashed(path: &str, bytes: &[u8]) -> HashedFile {
    HashedFile {
        path: path.to_string(),
        role: None,
        sha256: sha256(bytes),
        through: None,
    }
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

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
    /// Why the measured errors are doubtful, one sentence each.
    pub doubts: Vec<String>,
    /// Forecast against the acceptance of the job; undecided at most where there are doubts.
    pub verdict: Verdict,
    /// The manifest.
    pub manifest: Manifest,
}

impl Kit {
    /// The bytes of `manifest.json`.
    pub fn manifest_bytes(&self) -> Result<Vec<u8>, Problems> {
        let text = serde_json::to_string_pretty(&self.manifest)
            .map_err(|error| Problem::new(format!("the manifest cannot be written: {error}")))?;
        Ok(format!("{text}\n").into_bytes())
    }
}

/// What a template sees.
pub fn template_context(inputs: &Inputs) -> Result<emit::Context, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    emit::context(task, &compile(task, &plan)?)
}

/// Makes a kit. Refused unless every file reads back to exactly what was meant.
pub fn generate(inputs: &Inputs) -> Result<Kit, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let mut compiled = compile(task, &plan)?;
    let files = emit::render(task, &emit::context(task, &compiled)?)?;
    let read = read_back(&inputs.profile, &files)?;
    ensure_same(inputs, &plan, &compiled, &read)?;
    let absent = disagreement::absent(&inputs.profile, &compiled.tables, &read);
    compiled.notes.extend(absent);
    let control =
        emulator(&inputs.profile, &read.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let forecast =
        forecast(&inputs.model, &plan, control.as_ref()).map_err(|e| cannot_emulate(&e))?;
    let doubts = doubts(inputs);
    let verdict = judged(&forecast, inputs, &doubts);
    let manifest = build_manifest(inputs, &plan, &compiled, &files, &forecast);
    Ok(Kit {
        plan,
        compiled,
        files,
        forecast,
        doubts,
        verdict,
        manifest,
    })
}

/// Why the measured errors that the job asks for are doubtful.
fn doubts(inputs: &Inputs) -> Vec<String> {
    inputs.model.doubts(|term| wants(&inputs.job, term))
}

/// Forecast against the acceptance; doubtful errors decide nothing in favour.
fn judged(forecast: &Forecast, inputs: &Inputs, doubts: &[String]) -> Verdict {
    let doubtful = (!doubts.is_empty()).then_some(Verdict::Undecided);
    let verdict = forecast.verdict(inputs.job.acceptance);
    doubtful.map_or(verdict, |doubtful| verdict.max(doubtful))
}

/// Files in memory as they would lie on the disk.
fn kit_files(files: &[RenderedFile]) -> Vec<KitFile<'_>> {
    files
        .iter()
        .map(|file| KitFile {
            path: &file.path,
            role: file.role,
            bytes: &file.bytes,
        })
        .collect()
}

fn read_back(profile: &Profile, files: &[RenderedFile]) -> Result<ReadBack, Problems> {
    read(profile, &kit_files(files)).map_err(|problems| {
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
    let sentences = differences(inputs, plan, compiled, read).words;
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
        problems.push(Problem::new(words));
    }
    Err(problems)
}

/// What was read, against what was compiled.
struct Differences {
    /// One sentence for everything surplus, missing or contradictory.
    words: Vec<String>,
    /// The control that the files would make, or why there is none.
    found: Result<Box<dyn Emulator>, CannotEmulate>,
}

/// How files differ from what was compiled: what the tables do to the axes first, then what else
/// the files hold.
fn differences(inputs: &Inputs, plan: &Plan, compiled: &Compiled, read: &ReadBack) -> Differences {
    let profile = &inputs.profile;
    let found = emulator(profile, &read.tables, &compiled.state);
    if let (true, Ok(_)) = (compiled.tables == read.tables, &found) {
        // The same tables do the same: only what the files hold beside them is left to judge.
        let words = disagreement::contents(profile, &compiled.tables, read, None);
        return Differences { words, found };
    }
    let mut words = disagreement::measuring_systems(&compiled.tables, &read.tables);
    let wanted = emulator(profile, &compiled.tables, &compiled.state);
    let diagnosis = match (&wanted, &found) {
        (Ok(wanted), Ok(found)) => {
            Some(disagreement::compare(plan, wanted.as_ref(), found.as_ref()))
        }
        (Err(reason), _) | (_, Err(reason)) => {
            words.push(reason.0.clone());
            None
        }
    };
    words.extend(diagnosis.iter().flat_map(|d| d.words.clone()));
    words.extend(disagreement::contents(
        profile,
        &compiled.tables,
        read,
        diagnosis.as_ref(),
    ));
    Differences { words, found }
}

fn cannot_emulate(reason: &CannotEmulate) -> Problems {
    Problem::new(format!("the tables cannot be emulated: {}", reason.0))
        .help("nothing is written, because no forecast could be given")
        .into()
}

/// The emulator of a profile's dialect, loaded with tables.
pub fn emulator(
    profile: &Profile,
    tables: &Tables,
    state: &ControlState,
) -> Result<Box<dyn Emulator>, CannotEmulate> {
    Ok(match (&profile.dialect, tables) {
        (Dialect::Siemens(facts), Tables::Siemens(tables)) => {
            Box::new(SiemensControl::new(tables, facts, state)?)
        }
        (Dialect::Fanuc(facts), Tables::Fanuc(memory)) => {
            Box::new(FanucControl::new(memory, facts, state)?)
        }
        (Dialect::Generic(_), Tables::Generic(table)) => {
            Box::new(GenericControl::new(table, state)?)
        }
        _ => {
            return Err(CannotEmulate(
                "the tables are not of the profile's dialect".to_string(),
            ));
        }
    })
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
        machine: json!({
            "name": job.machine.name,
            "serial": job.machine.serial,
            "chain": job.machine.chain.map(|chain| chain.to_string()),
            "measured": job.measurement.date,
            "protocol": job.measurement.protocol.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
        }),
        doubts: doubts(inputs),
        notes: [compiled.notes.clone(), forecast.worsened()].concat(),
    }
}

/// What `verify` finds.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The plan of the job.
    pub plan: Plan,
    /// What the job compiles to (assumptions, preconditions, notes).
    pub compiled: Compiled,
    /// What the tables will leave; absent where they cannot be emulated.
    pub forecast: Option<Forecast>,
    /// How the tables differ from what the job asks for, one sentence each.
    pub disagreements: Vec<String>,
    /// What no file of the directory does, and what to see to on the control instead.
    pub absent: Vec<String>,
    /// Why the measured errors are doubtful, one sentence each.
    pub doubts: Vec<String>,
    /// Forecast against the acceptance; a disagreement fails, a doubt leaves it undecided.
    pub verdict: Verdict,
}

/// Judges the bytes of a directory against a job. Only these bytes and the state of the control
/// that the job states go into the forecast.
pub fn verify(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    mut disagreements: Vec<String>,
) -> Result<Verification, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let compiled = compile(task, &plan)?;
    let read = read(&inputs.profile, files)?;
    emulator(&inputs.profile, &compiled.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let Differences { words, found } = differences(inputs, &plan, &compiled, &read);
    disagreements.extend(words);
    let mut result = None;
    if let Ok(found) = found {
        match forecast(&inputs.model, &plan, found.as_ref()) {
            Ok(forecast) => result = Some(forecast),
            Err(reason) => disagreements.push(reason.0),
        }
    }
    disagreements.dedup();
    let doubts = doubts(inputs);
    let verdict = match &result {
        Some(forecast) if disagreements.is_empty() => judged(forecast, inputs, &doubts),
        _ => Verdict::Fail,
    };
    let absent = disagreement::absent(&inputs.profile, &compiled.tables, &read);
    Ok(Verification {
        absent,
        plan,
        compiled,
        forecast: result,
        disagreements,
        doubts,
        verdict,
    })
}

/// A control with tables in it, and the plan that names its axes.
pub struct LoadedControl {
    /// The plan of the job.
    pub plan: Plan,
    /// What the files make of the control.
    pub control: Box<dyn Emulator>,
    /// How the files differ from what the job asks for, one sentence each.
    pub disagreements: Vec<String>,
}

/// Loads the bytes of files into the emulated control of a job.
pub fn load(inputs: &Inputs, files: &[KitFile<'_>]) -> Result<LoadedControl, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let compiled = compile(task, &plan)?;
    let read = read(&inputs.profile, files)?;
    let Differences { words, found } = differences(inputs, &plan, &compiled, &read);
    Ok(LoadedControl {
        plan,
        control: found.map_err(|reason| cannot_emulate(&reason))?,
        disagreements: words,
    })
}

/// Makes the files of a job in memory and loads their bytes.
pub fn load_own(inputs: &Inputs) -> Result<LoadedControl, Problems> {
    let kit = generate(inputs)?;
    load(inputs, &kit_files(&kit.files))
}
