//! The files of a kit, read back, with what they will leave.

use super::findings::KitFinding;
use super::inputs::{Asked, Inputs, judged};
use super::loaded::Loaded;
use crate::inputs::job::ActiveTables;
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::forecast::Forecast;
use crate::quantity::Axis;
use crate::read::KitFile;
use crate::text::{Finding, Problem, Problems, Severity, of_severity};
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
    /// What the tables that were read back from them add to every term; the tables are those of `compiled`.
    pub(crate) effect: Field,
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
        let asked = Asked::of(inputs)?;
        let templates = Templates::default();
        let files = emit::render(inputs.task(), &templates, &asked.compiled)?;
        let own_state = (asked.compiled.state.clone(), Vec::new());
        let loaded = Loaded::files(asked, &as_read(&files), own_state).map_err(not_read_back)?;
        ensure_same(&loaded)?;
        let effect = loaded.effect()?;
        let forecast = loaded.forecast(&effect);
        let Asked { plan, mut compiled, .. } = loaded.asked;
        compiled.notes.extend(loaded.findings);
        if inputs.profile.comments.value.are_allowed() {
            let names = emit::other_letters(&inputs.job, &inputs.profile.name);
            compiled.notes.extend(names);
        }
        let doubts = [doubts(inputs), loaded.unread.into_iter().collect()].concat();
        let verdict = judged(&forecast, inputs, &doubts);
        Ok(Made { inputs, plan, compiled, templates, files, effect, forecast, verdict, doubts })
    }

    pub(crate) fn task(&self) -> Task<'_> {
        self.inputs.task()
    }

    /// `X (AX1)`, or `X (AX1 and AX4)` for a gantry.
    pub(crate) fn axes(&self, axis: Axis) -> String {
        format!("{axis} ({})", self.plan.names[axis].join(" and "))
    }
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

fn not_read_back(problems: Problems) -> Problems {
    const WORDS: &str =
        "the files that the templates made cannot be read back, so nothing is written";
    let mut all = Problems::from(Problem::new(WORDS).help(KEEP_TO_THE_FORMAT));
    all.extend(problems);
    all
}

/// What to do where files do not read back.
pub(super) const KEEP_TO_THE_FORMAT: &str =
    "a template of your own has to keep to the format of the dialect (docs/own-control.md §3)";

/// A template that drops, doubles, changes or adds something is found here.
fn ensure_same(loaded: &Loaded<'_>) -> Result<(), Problems> {
    let sentences = of_severity(&loaded.findings, Severity::Disagreement);
    let same_tables = loaded.asked.compiled.tables == loaded.tables;
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

/// A file as the readers take it.
pub(crate) fn as_kit_file(file: &RenderedFile) -> KitFile<'_> {
    KitFile { path: &file.path, role: file.role, bytes: &file.bytes }
}
