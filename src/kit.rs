//! A kit from end to end, in memory: model → plan → numbers → text → read back → forecast.
//!
//! Nothing here touches a file. What is written later is exactly `Kit::files`, and the forecast
//! comes from these bytes through the readers and the emulator, never from the numbers that
//! went in.

mod field;
mod loaded_state;
mod rollback;

use crate::active::{self, ActiveControl};
use crate::axis::Axis;
use crate::compensation::{Compiled, compile};
use crate::control_state::ControlState;
use crate::controller::Profile;
use crate::disagreement;
pub use crate::document::sha256;
use crate::emit::{self, RenderedFile, TOOL, Templates};
pub use crate::emulate::emulator;
use crate::emulate::{CannotEmulate, Emulator};
use crate::error_table::ErrorTable;
use crate::forecast::{Forecast, Machine, Verdict, forecast};
use crate::job::Job;
pub use crate::manifest::hashed;
use crate::manifest::{self, HashedFile, Manifest, Predecessor, SCHEMA};
use crate::model::ErrorModel;
use crate::plan::{Plan, Task, plan};
use crate::problem::{Problem, Problems};
use crate::readback::kit::{KitFile, ReadBack, read};
use crate::target::wants;
use field::{Made, as_kit_file};
use loaded_state::read_out_state;
pub use loaded_state::{LoadedState, loaded_state};
use serde_json::json;

/// The inputs of a kit, read and checked.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The job.
    pub job: Job,
    /// The control.
    pub profile: Profile,
    /// The errors of the machine without compensation as curves: what the tables are made for.
    pub model: ErrorModel,
    /// The errors as they were measured, where tables were active meanwhile.
    pub under_tables: Option<ErrorModel>,
    /// Every file that went in, with its hash.
    pub hashes: Vec<HashedFile>,
    /// The control as it was while measuring, where the job names its files.
    pub active: Option<ActiveControl>,
    /// What the sum of old tables and residual has to say, one sentence each.
    pub active_notes: Vec<String>,
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
        Ok(Inputs::of(job, profile, model, hashes))
    }

    /// The same for figures of the volume, where angles alone will do.
    pub fn for_figures(
        job: Job,
        profile: Profile,
        table: &ErrorTable,
        hashes: Vec<HashedFile>,
    ) -> Result<Inputs, Problems> {
        let model = ErrorModel::for_figures(&job, table)?;
        Ok(Inputs::of(job, profile, model, hashes))
    }

    fn of(job: Job, profile: Profile, model: ErrorModel, hashes: Vec<HashedFile>) -> Inputs {
        Inputs {
            job,
            profile,
            model,
            under_tables: None,
            hashes,
            active: None,
            active_notes: Vec::new(),
        }
    }

    /// Adds the angular errors of a table of their own (`measurement.angles`).
    pub fn with_angles(mut self, table: &ErrorTable) -> Result<Inputs, Problems> {
        self.model.add_angles(&self.job, table)?;
        Ok(self)
    }

    /// The same inputs, measured while these tables were active: new = old + residual.
    pub fn with_active(mut self, active: ActiveControl) -> Result<Inputs, Problems> {
        let (model, notes) = active::uncompensated(&self.job, &self.profile, &self.model, &active)?;
        self.under_tables = Some(std::mem::replace(&mut self.model, model));
        self.active_notes = [active.notes.clone(), notes].concat();
        self.active = Some(active);
        Ok(self)
    }

    /// The errors as they were measured.
    pub fn as_measured(&self) -> &ErrorModel {
        self.under_tables.as_ref().unwrap_or(&self.model)
    }

    /// The machine as measured and without compensation.
    pub fn machine(&self) -> Machine<'_> {
        Machine {
            as_measured: self.as_measured(),
            uncompensated: &self.model,
        }
    }

    /// The plan in the control's numbers, beside the tables that were active.
    fn compile(&self, plan: &Plan) -> Result<Compiled, Problems> {
        let mut compiled = compile(self.task(), plan)?;
        if let Some(active) = &self.active {
            active::collisions(&self.job, active, &compiled.tables)?;
            let stale = active::left_over(active, &compiled.tables);
            compiled.preconditions.extend(stale);
            compiled.assumptions.extend(active.assumptions.clone());
            compiled.notes.extend(self.active_notes.clone());
        }
        Ok(compiled)
    }

    fn task(&self) -> Task<'_> {
        Task {
            job: &self.job,
            profile: &self.profile,
            model: &self.model,
        }
    }
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
    /// The control's files as a reader takes them.
    pub fn kit_files(&self) -> Vec<KitFile<'_>> {
        as_read(&self.files)
    }

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
    let control =
        emulator(&inputs.profile, &read.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let forecast =
        forecast(inputs.machine(), &plan, control.as_ref()).map_err(|e| cannot_emulate(&e))?;
    let doubts = doubts(inputs);
    let verdict = judged(&forecast, inputs, &doubts);
    let field = field::make(&Made {
        inputs,
        plan: &plan,
        compiled: &compiled,
        context: &context,
        templates: &templates,
        files: &files,
        read: &read,
        verdict,
        doubts: &doubts,
    })?;
    files.extend(field.files);
    compiled.notes.extend(field.notes);
    let mut manifest = build_manifest(inputs, &plan, &compiled, &files, &forecast);
    manifest.sign_proofs = field.sign_proofs;
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
    let measured = inputs.as_measured();
    measured.doubts(|term| wants(&inputs.job, term))
}

/// Forecast against the acceptance; doubtful errors decide nothing in favour.
fn judged(forecast: &Forecast, inputs: &Inputs, doubts: &[String]) -> Verdict {
    let doubtful = (!doubts.is_empty()).then_some(Verdict::Undecided);
    let verdict = forecast.verdict(inputs.job.acceptance);
    doubtful.map_or(verdict, |doubtful| verdict.max(doubtful))
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

/// Tables whose effect the semantics do not tell.
pub fn cannot_emulate(reason: &CannotEmulate) -> Problems {
    Problem::new(format!("the tables cannot be emulated: {}", reason.0))
        .help("nothing is written, because no forecast could be given")
        .into()
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
        doubts: doubts(inputs),
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

/// What `verify` finds.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The plan of the job.
    pub plan: Plan,
    /// What the job compiles to (assumptions, preconditions, notes).
    pub compiled: Compiled,
    /// What the files of the directory hold.
    pub found: crate::table::Tables,
    /// The control outside the files, as they go with it.
    pub state: ControlState,
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
/// outside them go into the forecast: `state` of the kit's manifest, else what the job states.
pub fn verify(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
    mut disagreements: Vec<String>,
) -> Result<Verification, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let compiled = inputs.compile(&plan)?;
    let loaded = loaded_state(inputs, &plan, &compiled, named);
    let read = read(&inputs.profile, files)?;
    emulator(&inputs.profile, &compiled.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let Differences { words, found } = differences(inputs, &plan, &compiled, &read);
    disagreements.extend(words);
    disagreements.extend(loaded.disagreements);
    disagreements.extend(field::differences(inputs, &plan, &compiled, files)?);
    let found = found.and_then(|_| emulator(&inputs.profile, &read.tables, &loaded.state));
    let verification = Verification {
        absent: disagreement::absent(&inputs.profile, &compiled.tables, &read),
        plan,
        compiled,
        found: read.tables,
        state: loaded.state,
        forecast: None,
        disagreements,
        doubts: doubts(inputs),
        verdict: Verdict::Fail,
    };
    Ok(verification.forecast_with(inputs, found.ok().as_deref()))
}

/// Judges what was read out of a control by what it does to the job's axes: whatever else it holds
/// was passed over, and its notes say so.
pub fn verify_read_out(inputs: &Inputs, control: &ActiveControl) -> Result<Verification, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let loaded = read_out_state(inputs, &plan, &compiled, control);
    let with = |tables, state| emulator(&inputs.profile, tables, state);
    let wanted = with(&compiled.tables, &compiled.state).map_err(|e| cannot_emulate(&e))?;
    let mut disagreements = disagreement::measuring_systems(&compiled.tables, &control.tables);
    match with(&control.tables, &compiled.state) {
        Ok(found) => {
            let differs = disagreement::compare(&plan, wanted.as_ref(), found.as_ref());
            disagreements.extend(differs.words);
        }
        Err(reason) => disagreements.push(reason.0),
    }
    disagreements.extend(loaded.disagreements);
    let found = with(&control.tables, &loaded.state);
    let assumed = control.assumptions.iter();
    let assumed = assumed.map(|a| format!("no file holds {}: it is taken to be on", a.fact));
    let parameters = control.backlash_um.iter().filter_map(|(axis, found)| {
        let um = found.filter(|um| um.abs() > 0.0)?;
        Some(format!(
            "the control holds a backlash parameter of {um} µm for {axis}"
        ))
    });
    let verification = Verification {
        absent: control
            .notes
            .iter()
            .cloned()
            .chain(assumed)
            .chain(parameters)
            .collect(),
        plan,
        compiled,
        found: control.tables.clone(),
        state: loaded.state,
        forecast: None,
        disagreements,
        doubts: doubts(inputs),
        verdict: Verdict::Fail,
    };
    Ok(verification.forecast_with(inputs, found.ok().as_deref()))
}

impl Verification {
    /// The forecast of a control, and the verdict.
    fn forecast_with(mut self, inputs: &Inputs, control: Option<&dyn Emulator>) -> Verification {
        match control.map(|control| forecast(inputs.machine(), &self.plan, control)) {
            Some(Ok(forecast)) => self.forecast = Some(forecast),
            Some(Err(reason)) => self.disagreements.push(reason.0),
            None => {}
        }
        self.disagreements.dedup();
        if let (Some(forecast), true) = (&self.forecast, self.disagreements.is_empty()) {
            self.verdict = judged(forecast, inputs, &self.doubts);
        }
        self
    }
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

/// Loads the bytes of files into the emulated control of a job; `named` = `state` of their manifest.
pub fn load(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&serde_json::Value>,
) -> Result<LoadedControl, Problems> {
    let plan = plan(inputs.task())?;
    let compiled = inputs.compile(&plan)?;
    let loaded = loaded_state(inputs, &plan, &compiled, named);
    let read = read(&inputs.profile, files)?;
    let Differences { mut words, found } = differences(inputs, &plan, &compiled, &read);
    words.extend(loaded.disagreements);
    let control = found.and_then(|_| emulator(&inputs.profile, &read.tables, &loaded.state));
    Ok(LoadedControl {
        plan,
        control: control.map_err(|reason| cannot_emulate(&reason))?,
        disagreements: words,
    })
}

/// Makes the files of a job in memory and loads their bytes.
pub fn load_own(inputs: &Inputs) -> Result<LoadedControl, Problems> {
    let kit = generate(inputs)?;
    load(inputs, &kit.kit_files(), None)
}
