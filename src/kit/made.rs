//! The files of a kit, read back, with what they will leave.

use super::findings::KitFinding;
use super::inputs::{Asked, Inputs, cannot_emulate, judged};
use crate::control::controller::Profile;
use crate::inputs::job::ActiveTables;
use crate::judge::conformity::Verdict;
use crate::judge::disagreement;
use crate::judge::findings::not_emulated;
use crate::judge::forecast::{Forecast, forecast, judged_ranges};
use crate::quantity::axis::Axis;
use crate::read::emulate::{Emulated, Emulator};
use crate::read::{KitFile, ReadBack, emulator, read, unread};
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};
use crate::write::compensation::Compiled;
use crate::write::emit::{self, RenderedFile, Templates};
use crate::write::plan::{Plan, Task};
use crate::write::target::wants;

/// A kit without what is written beside its tables.
pub(crate) struct Made<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) plan: Plan,
    pub(crate) compiled: Compiled,
    pub(crate) templates: Templates,
    /// The files of the kit itself.
    pub(crate) files: Vec<RenderedFile>,
    /// What was read back from them.
    pub(crate) read: ReadBack,
    /// What the files will leave.
    pub(crate) forecast: Forecast,
    /// Forecast against the acceptance of the job.
    pub(crate) verdict: Verdict,
    /// Why the measured errors are doubtful.
    pub(crate) doubts: Vec<Finding>,
}

impl Made<'_> {
    /// Refused unless every file reads back to exactly what was meant.
    pub(super) fn of(inputs: &Inputs) -> Result<Made<'_>, Problems> {
        let task = inputs.task();
        let mut asked = Asked::of(inputs)?;
        let templates = Templates::default();
        let files = emit::render(task, &templates, &asked.compiled)?;
        let read = read_back(&inputs.profile, &files)?;
        ensure_same(&asked, &read)?;
        let absent = disagreement::absent(&inputs.profile, &asked.compiled.tables, &read);
        asked.compiled.notes.extend(absent);
        if inputs.profile.comments.value.are_allowed() {
            let names = emit::other_letters(&inputs.job, &inputs.profile.name);
            asked.compiled.notes.extend(names);
        }
        let forecast = left(&asked, &read)?;
        let unread = unread(&inputs.profile, &as_read(&files));
        let doubts: Vec<Finding> = doubts(inputs).into_iter().chain(unread).collect();
        let verdict = judged(&forecast, inputs, &doubts);
        Ok(Made {
            inputs,
            plan: asked.plan,
            compiled: asked.compiled,
            templates,
            files,
            read,
            forecast,
            verdict,
            doubts,
        })
    }

    pub(crate) fn task(&self) -> Task<'_> {
        self.inputs.task()
    }

    /// `X (AX1)`, or `X (AX1 and AX4)` for a gantry.
    pub(crate) fn axes(&self, axis: Axis) -> String {
        format!("{axis} ({})", self.plan.names[axis].join(" and "))
    }
}

/// What files that were read back leave.
fn left(asked: &Asked<'_>, read: &ReadBack) -> Result<Forecast, Problems> {
    let Asked { inputs, plan, compiled } = asked;
    let ranges = judged_ranges(&inputs.job, inputs.as_measured());
    emulator(&inputs.profile, &read.tables, &compiled.state)
        .and_then(|control| forecast(inputs.machine(), plan, control.as_ref(), &ranges))
        .map_err(|reason| cannot_emulate(&reason))
}

/// Why the measured errors that the job asks for are doubtful.
pub(super) fn doubts(inputs: &Inputs) -> Vec<Finding> {
    let measured = inputs.as_measured();
    let mut doubts = measured.doubts(|term| wants(&inputs.job, term));
    doubts.extend(measured.unlikely_small(inputs.job.measurement.uncertainty.noise_um));
    if inputs.job.measurement.active == ActiveTables::NotStated {
        doubts.push(KitFinding::ActiveNotStated.into());
    }
    doubts
}

pub(super) fn as_read(files: &[RenderedFile]) -> Vec<KitFile<'_>> {
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
fn ensure_same(asked: &Asked<'_>, read: &ReadBack) -> Result<(), Problems> {
    let (sentences, _) = differences(asked, read);
    let same_tables = asked.compiled.tables == read.tables;
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
pub(super) fn differences(
    asked: &Asked<'_>,
    read: &ReadBack,
) -> (Vec<Finding>, Emulated<Box<dyn Emulator>>) {
    let Asked { inputs, plan, compiled } = asked;
    let profile = &inputs.profile;
    let found = emulator(profile, &read.tables, &compiled.state);
    let contents = |diagnosis| disagreement::contents(profile, compiled, read, diagnosis);
    if let (true, Ok(_)) = (compiled.tables == read.tables, &found) {
        // The same tables do the same: only what the files hold beside them is left to judge.
        return (contents(None), found);
    }
    let mut findings = disagreement::measuring_systems(profile, &compiled.tables, &read.tables);
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

/// A file as the readers take it.
pub(crate) fn as_kit_file(file: &RenderedFile) -> KitFile<'_> {
    KitFile { path: &file.path, role: file.role, bytes: &file.bytes }
}
