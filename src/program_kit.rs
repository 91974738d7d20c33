//! The programs of a measuring run from end to end, in memory: plan → text → read back → walk.
//!
//! What is written later is exactly `ProgramKit::files`. Before that, the bytes were read by code
//! that shares nothing with the templates and walked: every commanded point in the travel, every
//! node in order, a standstill at each, every axis arriving in the direction of its pass.

use crate::axis::{Axis, PerAxis};
use crate::claims::{Assumption, Precondition};
use crate::controller::program::{Language, ProgramFacts};
use crate::controller::{Evidence, LengthUnit, Profile, builtin};
use crate::emit::TOOL;
use crate::emit::program::{POSITIONS, ProgramFile, positions, programs};
use crate::job::{Job, ProgramRequest};
use crate::kit::sha256;
use crate::manifest::{HashedFile, SCHEMA};
use crate::problem::{Problem, Problems};
use crate::program::{MeasuringRun, MirrorSize, Resolution, plan};
use crate::readback::program::positions::{self as readback_positions, Position};
use crate::readback::program::walk::{Bounds, Walked, walk};
use crate::readback::program::{Cancelled, read};
use serde_json::{Value, json};

/// Programs and positions of a run, judged.
#[derive(Clone, Debug)]
pub struct ProgramKit {
    /// What was planned.
    pub run: MeasuringRun,
    /// What the job asks for.
    pub request: ProgramRequest,
    /// The programs, then the positions.
    pub files: Vec<ProgramFile>,
    /// Facts of the profile that nobody has shown yet.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// The document of `manifest.json` and of `--format json`.
    pub manifest: Value,
}

/// Makes and judges the programs that a job asks for.
pub fn make(job: &Job, profile: &Profile, inputs: &[HashedFile]) -> Result<ProgramKit, Problems> {
    let request = job.program.as_ref().ok_or_else(|| no_section(job))?;
    let facts = profile
        .program
        .as_ref()
        .ok_or_else(|| no_language(job, profile))?;
    let unit = job.compensation.control_unit;
    let resolution = Resolution {
        unit,
        decimals: facts.decimals(unit),
    };
    let run = plan(job, request, resolution)?;
    let mut files = programs(job, request, profile, facts, &run)?;
    files.push(positions(&run));
    let walked = judge(job, request, facts, resolution, &files)?;
    let assumptions = assumptions(facts, request, unit);
    let preconditions = preconditions(facts, &walked);
    let manifest = manifest(
        profile,
        request,
        &run,
        inputs,
        &files,
        &assumptions,
        &preconditions,
    );
    Ok(ProgramKit {
        request: request.clone(),
        run,
        files,
        assumptions,
        preconditions,
        manifest,
    })
}

fn no_section(job: &Job) -> Problem {
    job.problem_at("program", "the job has no section [program], so there is no run to write programs for")
        .help("add `[program]` with `what = \"step-diagonal\"`, `\"straight-diagonal\"` or `\"single-axis\"` (docs/program.md)")
}

fn no_language(job: &Job, profile: &Profile) -> Problem {
    let known = builtin::ids()
        .into_iter()
        .filter(|id| builtin::profile(id).is_ok_and(|profile| profile.program.is_some()));
    let known: Vec<&str> = known.collect();
    job.problem_at(
        "compensation.controller",
        format!(
            "`{}` says nothing about part programs, so none can be written",
            profile.id
        ),
    )
    .help(format!(
        "choose the control that will run the program: {}; or a profile of your own with [program]",
        known.join(", ")
    ))
}

/// Reads bytes back and walks them, whoever made them: a program's own walk, and what is wrong.
pub fn judge(
    job: &Job,
    request: &ProgramRequest,
    facts: &ProgramFacts,
    resolution: Resolution,
    files: &[ProgramFile],
) -> Result<Vec<Walked>, Problems> {
    let mut problems = Problems::none();
    let rows = match files.iter().find(|file| file.path == POSITIONS) {
        Some(file) => readback_positions::read(POSITIONS, &file.bytes)?,
        None => Vec::new(),
    };
    let digit_mm = resolution.digit_mm();
    for words in readback_positions::differences(&rows, request, digit_mm) {
        problems.push(Problem::new(words).help("nothing was written"));
    }
    let bounds = bounds(job, request, digit_mm);
    let mut walked = Vec::new();
    let programs = files.iter().filter(|file| file.path != POSITIONS);
    for (file, rows) in programs.zip(by_set_up(&rows)) {
        let letters = &facts.axis_letters.value;
        let Some(steps) = problems.take(read(facts.language, letters, &file.path, &file.bytes))
        else {
            continue;
        };
        let text = String::from_utf8_lossy(&file.bytes);
        walked.extend(problems.take(walk((&file.path, &text), &steps, rows, &bounds)));
    }
    problems.or_ok(walked)
}

fn bounds(job: &Job, request: &ProgramRequest, digit_mm: f64) -> Bounds {
    Bounds {
        travel: PerAxis::from_fn(|axis| {
            let travel = job.machine.axes[axis];
            travel.map_or((0.0, 0.0), |axis| (axis.low.mm(), axis.high.mm()))
        }),
        max_feed: PerAxis::from_fn(|axis| job.machine.axes[axis].and_then(|axis| axis.max_feed)),
        dwell_s: request.dwell_s,
        digit_mm,
        overrun: request.overrun.mm() > 0.0,
    }
}

/// The rows of each program: neighbours of one diagonal or axis.
fn by_set_up(rows: &[Position]) -> Vec<&[Position]> {
    rows.chunk_by(|a, b| a.of == b.of).collect()
}

fn assumptions(
    facts: &ProgramFacts,
    request: &ProgramRequest,
    unit: LengthUnit,
) -> Vec<Assumption> {
    let assumed = facts
        .statements_of(unit)
        .filter(|s| s.evidence == Evidence::Assumed);
    let mut list: Vec<Assumption> = assumed
        .map(|s| {
            Assumption::of_job(
                format!("program.{}", s.fact),
                s.value.clone(),
                s.consequence.clone().unwrap_or_default(),
            )
        })
        .collect();
    if facts.language == Language::Fanuc {
        list.push(Assumption::of_job(
            "program.number",
            format!("O{:04} and those that follow are free", request.number),
            "the control refuses to load a number that exists, or overwrites that program: state `number` in [program]",
        ));
    }
    list
}

fn preconditions(facts: &ProgramFacts, walked: &[Walked]) -> Vec<Precondition> {
    let mut list = vec![
        Precondition::new(
            "all axes",
            "referenced",
            "machine coordinates exist only after the reference return",
            "docs/program.md §3",
        ),
        Precondition::new(
            "tool offset",
            "none active before cycle start",
            "cancelling it could move an axis",
            "docs/program.md §3",
        ),
    ];
    if facts.language == Language::Siemens {
        list.push(Precondition::new(
            "basic frames and DRF offset",
            "no rotation, scaling or mirroring; DRF off",
            "increments follow a rotated, scaled or mirrored frame",
            "docs/program.md §3",
        ));
    }
    let wanted = [
        (Cancelled::Rotation, "rotation"),
        (Cancelled::Scaling, "scaling"),
        (Cancelled::Mirroring, "mirroring"),
    ];
    for (what, name) in wanted {
        if !walked.iter().all(|walked| walked.cancelled.contains(&what)) {
            list.push(Precondition::new(
                name,
                "off",
                "the profile's `cancel` does not switch it off",
                "facts of [program] in the profile",
            ));
        }
    }
    list
}

fn manifest(
    profile: &Profile,
    request: &ProgramRequest,
    run: &MeasuringRun,
    inputs: &[HashedFile],
    files: &[ProgramFile],
    assumptions: &[Assumption],
    preconditions: &[Precondition],
) -> Value {
    let readings: Vec<usize> = run.programs.iter().map(|p| p.readings.len()).collect();
    let files: Vec<Value> = files
        .iter()
        .enumerate()
        .map(|(index, file)| {
            let role = if file.path == POSITIONS {
                "positions"
            } else {
                "program"
            };
            let of = run
                .programs
                .get(index)
                .map(|program| program.subject.name());
            json!({
                "path": file.path,
                "role": role,
                "of": of,
                "readings": readings.get(index),
                "sha256": sha256(&file.bytes),
            })
        })
        .collect();
    let reach = Axis::ALL.into_iter().filter_map(|axis| {
        let (low, high) = run.reach_mm(axis)?;
        Some((axis.key().to_string(), json!([low, high])))
    });
    json!({
        "schema": SCHEMA,
        "tool": TOOL,
        "controller": profile.id,
        "what": request.what.word(),
        "unit": run.resolution.unit.word(),
        "inputs": inputs,
        "files": files,
        "readings": readings.iter().sum::<usize>(),
        "duration_s": run.duration_s(request).round(),
        "reach_mm": reach.collect::<serde_json::Map<_, _>>(),
        "mirror_mm": run.mirror.map(mirror),
        "assumptions": assumptions,
        "preconditions": preconditions,
        "notes": run.notes,
    })
}

fn mirror(size: MirrorSize) -> Value {
    let rounded = |mm: f64| (mm * 1e3).round() / 1e3;
    json!({
        "after_first_move": rounded(size.excursion_mm[0]),
        "after_second_move": rounded(size.excursion_mm[1]),
        "farthest": rounded(size.farthest_mm),
        "circle": rounded(size.circle_mm),
    })
}
