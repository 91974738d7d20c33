//! The programs of a measuring run from end to end, in memory: plan → text → read back → walk.
//!
//! What is written later is exactly `ProgramKit::files`. Before that, the bytes were read by code
//! that shares nothing with the templates and walked: every commanded point in the travel, every
//! node in order, a standstill at each, every axis arriving in the direction of its pass.

use crate::control::claims::{Assumption, Precondition};
use crate::control::controller::program::ProgramFacts;
use crate::control::controller::{ControlUnit, Evidence, Profile};
use crate::inputs::job::{Job, ProgramRequest, RunType, TargetGrid};
use crate::judge::active::HashedFile;
use crate::kit::manifest::SCHEMA;
use crate::kit::refusals;
use crate::kit::sha256;
use crate::quantity::{Axis, Diagonal, LaserPath, Pass, PathKind, PerAxis, rounded};
use crate::read::program::walk::{
    self as readback_positions, Bounds, Position, Walked, form_differences, walk,
};
use crate::read::program::{Cancelled, OwnWords, read};
use crate::text::{Finding, NamedEntries, Problems};
use crate::write::emit::{TOOL, other_letters};
use crate::write::program::{
    FileRole, MeasuringRun, MirrorSize, ProgramFile, RunTask, SetUpProgram, plan, positions,
    programs, readings_to_fill,
};
use serde::Serialize;
use serde_json::{Value, json};

/// Programs and positions of a run, judged; as a document it is `manifest.json`, and what `--format json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct ProgramKit {
    schema: u32,
    tool: &'static str,
    /// Id of the profile.
    controller: String,
    what: RunType,
    unit: ControlUnit,
    overrun: Option<bool>,
    /// What went in.
    inputs: Vec<HashedFile>,
    #[serde(rename = "files")]
    listed: Vec<Value>,
    /// How many readings are taken.
    pub readings: usize,
    duration_s: f64,
    reach_mm: NamedEntries<&'static str, (f64, f64)>,
    mirror_mm: Option<NamedEntries<&'static str, f64>>,
    /// Facts of the profile that nobody has shown yet.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// What to know of the run.
    pub notes: Vec<Finding>,
    /// What was planned.
    #[serde(skip)]
    pub run: MeasuringRun,
    /// What the job asks for.
    #[serde(skip)]
    pub request: ProgramRequest,
    /// The programs, the positions, the readings to be filled in.
    #[serde(skip)]
    pub files: Vec<ProgramFile>,
}

/// A file of the list; positions and readings belong to no single program.
fn listed((file, program): (&ProgramFile, Option<&SetUpProgram>)) -> Value {
    json!({
        "path": file.path,
        "role": file.role,
        "of": program.map(|program| program.subject.to_string()),
        "readings": program.map(|program| program.readings.len()),
        "sha256": sha256(&file.bytes),
    })
}

/// Sizes on the mirror, to a micrometre.
fn on_mirror(size: MirrorSize) -> NamedEntries<&'static str, f64> {
    let [first, second] = size.excursion_mm;
    let (farthest, circle) = (("farthest", size.farthest_mm), ("circle", size.circle_mm));
    let all = [("after_first_move", first), ("after_second_move", second), farthest, circle];
    all.map(|(name, mm)| (name, rounded(mm, 3))).into_iter().collect()
}

impl ProgramKit {
    /// The same without readings to be filled in: there is a table for them already.
    pub(crate) fn without_form(mut self) -> ProgramKit {
        self.files.retain(|file| file.role != FileRole::Readings);
        self.listed.truncate(self.files.len()); // they are the last
        self
    }
}

/// Makes and judges the programs that a job asks for.
pub fn make(job: &Job, profile: &Profile, inputs: &[HashedFile]) -> Result<ProgramKit, Problems> {
    let task = RunTask::of(job, profile)?;
    let run = plan(task)?;
    let mut files = programs(task, &run)?;
    files.push(positions(&run));
    files.extend(readings_to_fill(&run));
    let walked = judge(task, &files)?;
    let request = task.request.clone();
    let programs = run.programs.iter().map(Some).chain(std::iter::repeat(None));
    let reach = Axis::ALL.into_iter().filter_map(|axis| Some((axis.key(), run.reach_mm(axis)?)));
    Ok(ProgramKit {
        schema: SCHEMA,
        tool: TOOL,
        controller: profile.id.clone(),
        what: request.what,
        unit: run.resolution.unit,
        overrun: request.runs_over(),
        inputs: inputs.to_vec(),
        listed: files.iter().zip(programs).map(listed).collect(),
        readings: run.programs.iter().map(|program| program.readings.len()).sum(),
        duration_s: run.duration_s(&request).round(),
        reach_mm: reach.collect(),
        mirror_mm: run.mirror.map(on_mirror),
        assumptions: assumptions(task),
        preconditions: preconditions(task.facts, &walked),
        notes: [run.notes.clone(), other_letters(job, &profile.name)].concat(),
        run,
        request,
        files,
    })
}

/// Reads bytes back and walks them, whoever made them; what is wrong comes all at once.
pub fn judge(task: RunTask<'_>, files: &[ProgramFile]) -> Result<Vec<Walked>, Problems> {
    let mut problems = Problems::none();
    let of_role = |role: FileRole| files.iter().filter(move |file| file.role == role);
    let rows = match of_role(FileRole::Positions).next() {
        Some(file) => readback_positions::read(&file.path, &file.bytes)?,
        None => Vec::new(),
    };
    let mut wrong = position_differences(&rows, task);
    let forms: Vec<&[u8]> = of_role(FileRole::Readings).map(|f| f.bytes.as_slice()).collect();
    wrong.extend(form_differences(&rows, &forms));
    let programs: Vec<&ProgramFile> = of_role(FileRole::Program).collect();
    // The rows of each program: neighbours of one diagonal or axis.
    let set_ups: Vec<&[Position]> = rows.chunk_by(|a, b| a.of == b.of).collect();
    if programs.len() != set_ups.len() {
        let (programs, set_ups) = (programs.len(), set_ups.len());
        wrong.push(format!("{programs} programs for {set_ups} set-ups of the laser"));
    }
    for words in wrong {
        problems.push(refusals::other_program(words));
    }
    let bounds = bounds(task);
    let mut walked = Vec::new();
    for (file, rows) in programs.into_iter().zip(set_ups) {
        walked.extend(problems.take(walk_file(task.facts, file, rows, &bounds)));
    }
    problems.or_ok(walked)
}

fn walk_file(
    facts: &ProgramFacts,
    file: &ProgramFile,
    rows: &[Position],
    bounds: &Bounds,
) -> Result<Walked, Problems> {
    let words = OwnWords { letters: &facts.axis_letters.value, seconds: facts.dwell_address() };
    let steps = read(facts.language, &words, &file.path, &file.bytes)?;
    walk((&file.path, &String::from_utf8_lossy(&file.bytes)), &steps, rows, bounds)
}

fn bounds(task: RunTask<'_>) -> Bounds {
    let (axes, request) = (&task.job.machine.axes, task.request);
    let travel = |axis| axes[axis].map_or((0.0, 0.0), |own| (own.low.mm(), own.high.mm()));
    Bounds {
        travel: PerAxis::from_fn(travel),
        max_feed: PerAxis::from_fn(|axis| axes[axis]?.max_feed),
        dwell_s: request.dwell_s,
        digit_mm: task.resolution().digit_mm(),
        overrun: request.overrun.mm() > 0.0,
    }
}

fn assumptions(task: RunTask<'_>) -> Vec<Assumption> {
    let RunTask { facts, request, .. } = task;
    let unit = task.resolution().unit;
    let assumed = facts.statements_of(unit).filter(|s| s.evidence == Evidence::Assumed).map(|s| {
        let consequence = s.consequence.clone().unwrap_or_default();
        Assumption::of_job(format!("program.{}", s.fact), s.value.clone(), consequence)
    });
    let number = facts.language.facts().numbered.map(|_| {
        let free = format!("O{:04} and those that follow are free", request.number_of(0));
        Assumption::of_job("program.number", free, "the control refuses to load a number that exists, or overwrites that program: state `number` in [program]")
    });
    assumed.chain(number).collect()
}

fn preconditions(facts: &ProgramFacts, walked: &[Walked]) -> Vec<Precondition> {
    const PAGE: &str = "docs/measuring.md §3";
    let zero = "machine coordinates exist only after the reference return";
    let own = [
        ["all axes", "referenced", zero, PAGE],
        ["tool offset", "none active before cycle start", "cancelling it could move an axis", PAGE],
    ];
    let wanted = [
        (Cancelled::Rotation, "rotation"),
        (Cancelled::Scaling, "scaling"),
        (Cancelled::Mirroring, "mirroring"),
    ];
    let is_open =
        |(what, _): &(Cancelled, _)| !walked.iter().all(|own| own.cancelled.contains(what));
    let (why, source) =
        ("the profile's `cancel` does not switch it off", "facts of [program] in the profile");
    let open = wanted.into_iter().filter(is_open).map(|(_, name)| [name, "off", why, source]);
    let all =
        own.into_iter().chain(facts.language.facts().preconditions.iter().copied()).chain(open);
    all.map(|[what, value, why, source]| Precondition::new(what, value, why, source)).collect()
}

/// What differs between the rows and what the job asks for, one sentence each; empty = nothing.
/// Diagonals are compared with the nodes that `separate` will expect.
fn position_differences(rows: &[Position], task: RunTask<'_>) -> Vec<String> {
    const MOST: usize = 20;
    let expected = order(task.request);
    let (read, wanted) = (rows.len(), expected.len());
    let count = format!("positions.csv has {read} readings, expected {wanted}");
    let wrong = rows.iter().zip(&expected).filter_map(|(row, (of, run, pass, node))| {
        let is_same = (row.of, row.run, row.pass, row.node) == (*of, *run, *pass, *node);
        match is_same {
            false => Some(format!(
                "reading {} of run {} should be node {node} of run {run}, {}",
                row.node,
                row.run,
                pass.word()
            )),
            true => (!is_at_node(row, task)).then(|| {
                format!("node {} of run {} is not where the job has it", row.node, row.run)
            }),
        }
    });
    (read != wanted).then_some(count).into_iter().chain(wrong).take(MOST + 1).collect()
}

type Key = (LaserPath, u32, Pass, usize);

/// Diagonal, run, direction and node of every reading in the order of the files of readings.
fn order(request: &ProgramRequest) -> Vec<Key> {
    let volume = &request.volume;
    let (set_ups, last): (Vec<LaserPath>, usize) = match request.what.path() {
        Some(kind) => (Diagonal::ALL.map(LaserPath::Diagonal).to_vec(), volume.last_node(kind)),
        None => (request.axes.iter().copied().map(LaserPath::Axis).collect(), volume.steps),
    };
    let back = (0..=last).rev().filter(|_| request.bidirectional);
    let there = (0..=last).map(|node| (Pass::Forward, node));
    let passes = there.chain(back.map(|node| (Pass::Reverse, node)));
    let runs = set_ups.into_iter().flat_map(|of| (1..=request.runs).map(move |run| (of, run)));
    let keys =
        runs.flat_map(|(of, run)| passes.clone().map(move |(pass, node)| (of, run, pass, node)));
    keys.collect()
}

fn is_at_node(row: &Position, task: RunTask<'_>) -> bool {
    let (request, digit_mm) = (task.request, task.resolution().digit_mm());
    let close = |a: f64, b: f64, slack: f64| (a - b).abs() <= slack;
    match (row.of, request.what.path()) {
        (LaserPath::Diagonal(diagonal), Some(kind)) => {
            let place = request.volume.place(diagonal, kind, row.node);
            let moved =
                (kind == PathKind::Step && row.node > 0).then(|| request.volume.moved(row.node));
            moved == row.moved
                && close(row.nominal_mm, request.volume.nominal_mm(diagonal, kind, row.node), 1e-6)
                && place.iter().all(|(axis, mm)| close(row.place[axis], mm.mm(), digit_mm / 100.0))
        }
        (LaserPath::Axis(axis), None) => {
            let equal = request.volume.start[axis].mm() + request.volume.along_mm(axis, row.node);
            let step = request.volume.step_mm(axis);
            let slack = match request.targets {
                TargetGrid::Equal => digit_mm / 100.0,
                TargetGrid::Offset { shift } => shift.map_or(step / 4.0, |s| s.mm()) + digit_mm,
            };
            close(row.place[axis], equal, slack)
        }
        _ => false,
    }
}
