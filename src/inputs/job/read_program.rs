//! `[program]` of a job.

use crate::inputs::job::read_places::{order, places, size, steps};
use crate::inputs::job::{
    DiagonalMeasurement, MeasuredData, Measurement, ProgramRequest, Reflector, RunType, TargetGrid,
    WayBack,
};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::document::Section;

const DEFAULT_FEED_MM_PER_MIN: f64 = 1000.0; // a step of 30 mm in two seconds, without swinging
const DEFAULT_DWELL_S: f64 = 3.0; // 2 … 5 s is usual: to settle, and to average the laser
const DEFAULT_OVERRUN_MM: f64 = 2.0; // a hundred times the reversal of a sound axis
const DEFAULT_ISO_RUNS: u32 = 5; // ISO 230-2, axes up to 2 m
const SHORTEST_DWELL_S: f64 = 0.1;
const LONGEST_DWELL_S: f64 = 600.0;
const SHORTEST_LENGTH_MM: f64 = 0.01;
const LONGEST_LENGTH_MM: f64 = 100.0; // overrun, preload and shift: no machine has more to spare
const MOST_RUNS: u32 = 100;
const MOST_NUMBER: u32 = 9990; // four digits on every Fanuc control, with room for four programs

/// The section; `measurement` is `None` where the job's measurement could not be read.
pub(super) fn program(
    section: &Section<'_>,
    measurement: Option<&Measurement>,
) -> Option<ProgramRequest> {
    let what = what(section);
    let volume = volume(section, what, measurement);
    let (axes, rest) = single_axes(section, what);
    let (bidirectional, way_back) = directions(section);
    let (overrun, preload) = run_out(section, what, bidirectional);
    let targets = targets(section, what);
    let feed = section.within("feed_mm_per_min", 1e-3, 1e6, "mm/min");
    let dwell = section.within("dwell_s", SHORTEST_DWELL_S, LONGEST_DWELL_S, "s");
    let runs = count(section, "runs", MOST_RUNS);
    let alignment_pass = section.flag("alignment_pass").unwrap_or(true);
    let number = count(section, "number", MOST_NUMBER);
    section.refuse_unknown_keys();
    let what = what?;
    let usual_runs = match what {
        RunType::SingleAxis => DEFAULT_ISO_RUNS,
        RunType::StepDiagonal | RunType::StraightDiagonal => 1,
    };
    let (volume, size_path) = volume?;
    Some(ProgramRequest {
        what,
        volume,
        size_path,
        axes,
        rest,
        feed_mm_per_min: feed.unwrap_or(DEFAULT_FEED_MM_PER_MIN),
        dwell_s: dwell.unwrap_or(DEFAULT_DWELL_S),
        overrun: Millimetres::new(overrun),
        preload: Millimetres::new(preload),
        runs: runs.unwrap_or(usual_runs),
        bidirectional,
        way_back,
        targets,
        alignment_pass,
        number,
        target: target(what, measurement),
    })
}

fn what(section: &Section<'_>) -> Option<RunType> {
    if !section.has("what") {
        section.missing(
            "what",
            "`step-diagonal`, `straight-diagonal` or `single-axis`",
        );
    }
    let words = [
        RunType::StepDiagonal,
        RunType::StraightDiagonal,
        RunType::SingleAxis,
    ];
    section.choice("what", &words.map(|what| (what.word(), what)))
}

/// The box as stated here, else as stated for the measurement, and the key of its size.
fn volume(
    section: &Section<'_>,
    what: Option<RunType>,
    measurement: Option<&Measurement>,
) -> Option<(Volume, &'static str)> {
    let measured = measurement.and_then(|m| match &m.data {
        MeasuredData::Diagonals(DiagonalMeasurement { volume, .. }) => Some(volume),
        MeasuredData::Errors(_) => None,
    });
    let size_path = if section.has("size_mm") || measured.is_none() {
        "program.size_mm"
    } else {
        "measurement.step_diagonal.size_mm"
    };
    if measured.is_none() && measurement.is_some() {
        let needed = [
            (
                "start_mm",
                "the corner with the smallest machine coordinates, e.g. { x = 10.0, y = 10.0, z = -400.0 }",
            ),
            (
                "size_mm",
                "the edges of the measured box, e.g. { x = 900.0, y = 720.0, z = 720.0 }",
            ),
            ("steps", "the number of steps of each axis"),
        ];
        for (key, expected) in needed {
            if !section.has(key) {
                section.missing(key, expected);
            }
        }
    }
    let start = places(section, "start_mm").or(measured.map(|v| v.start));
    let size = size(section).or(measured.map(|v| v.size));
    let steps = if section.has("steps") {
        steps(section)
    } else {
        measured.map(|v| v.steps)
    };
    refuse_order(section, what);
    let is_step = what == Some(RunType::StepDiagonal);
    let order = match measured {
        Some(volume) if !section.has("order") => Some(volume.order),
        _ if measurement.is_none() && !section.has("order") => None,
        _ if is_step => order(section, PathKind::Step),
        _ => order(section, PathKind::Straight),
    };
    let volume = Volume {
        start: start?,
        size: size?,
        steps: steps?,
        order: order?,
    };
    Some((volume, size_path))
}

/// The order of single-axis moves has no effect where an axis moves alone, or all together.
fn refuse_order(section: &Section<'_>, what: Option<RunType>) {
    if let Some(what) = what.filter(|what| *what != RunType::StepDiagonal)
        && section.has("order")
    {
        section.problem(
            "order",
            format!(
                "`program.order` is stated, but runs of `{}` have no order of moves",
                what.word()
            ),
            "remove it, or write `what = \"step-diagonal\"`",
        );
    }
}

/// What the job states for the same kind of run, else what is usual for it.
fn target(what: RunType, measurement: Option<&Measurement>) -> Reflector {
    match measurement.map(|m| &m.data) {
        Some(MeasuredData::Diagonals(measured)) if Some(measured.kind) == what.path() => {
            measured.target
        }
        _ if what == RunType::StepDiagonal => Reflector::FlatMirror,
        _ => Reflector::Retroreflector,
    }
}

type Rest = Option<PerAxis<Millimetres>>;

fn single_axes(section: &Section<'_>, what: Option<RunType>) -> (Vec<Axis>, Rest) {
    let single = what == Some(RunType::SingleAxis);
    for key in ["axes", "rest_mm"] {
        if section.has(key) && !single {
            section.problem(
                key,
                format!("`program.{key}` belongs to runs of single axes, but `what` is another"),
                "remove it, or write `what = \"single-axis\"`",
            );
        }
    }
    let stated = section.texts("axes");
    let mut axes = Vec::new();
    for name in stated.iter().flatten() {
        match Axis::from_letter(name) {
            Some(axis) if !axes.contains(&axis) => axes.push(axis),
            _ => section.problem(
                "axes",
                "`program.axes` names each of `x`, `y`, `z` at most once",
                "for instance `axes = [\"x\", \"z\"]`",
            ),
        }
    }
    if stated.is_some_and(|list| list.is_empty()) {
        section.problem(
            "axes",
            "`program.axes` is empty",
            "name an axis, or remove it",
        );
    }
    if axes.is_empty() {
        axes = Axis::ALL.to_vec();
    }
    (axes, places(section, "rest_mm"))
}

/// Whether the way back is measured, and how it goes where it is not: a way back along the
/// diagonal meets no node, so it is not measured.
fn directions(section: &Section<'_>) -> (bool, WayBack) {
    let words = [WayBack::Retrace, WayBack::Diagonal].map(|way| (way.word(), way));
    let way_back = section.choice("return", &words).unwrap_or(WayBack::Retrace);
    let stated = section.flag("bidirectional");
    if stated == Some(true) && way_back == WayBack::Diagonal {
        section.problem(
            "return",
            "`return` is `diagonal`, but `bidirectional = true` measures the nodes on the way back",
            "write `return = \"retrace\"`, or `bidirectional = false`",
        );
    }
    (stated.unwrap_or(way_back == WayBack::Retrace), way_back)
}

fn run_out(section: &Section<'_>, what: Option<RunType>, bidirectional: bool) -> (f64, f64) {
    let overrun = section.not_negative("overrun_mm");
    let stated = overrun.filter(|mm| *mm > 0.0);
    if stated.is_some_and(|mm| mm > LONGEST_LENGTH_MM) {
        section.within("overrun_mm", SHORTEST_LENGTH_MM, LONGEST_LENGTH_MM, "mm");
    }
    if overrun.is_some() && !bidirectional {
        section.problem(
            "overrun_mm",
            "`overrun_mm` is stated, but nothing is measured on the way back",
            "remove it, or write `bidirectional = true`",
        );
    }
    let turns = overrun.is_some() && stated.is_none() && bidirectional;
    if turns && what != Some(RunType::StepDiagonal) {
        section.problem(
            "overrun_mm",
            "`overrun_mm` is 0, so the last target would be approached from one side only",
            "give an overrun larger than the reversal of every axis, e.g. `overrun_mm = 2.0`",
        );
    }
    let preload = section.within("preload_mm", SHORTEST_LENGTH_MM, LONGEST_LENGTH_MM, "mm");
    let overrun = overrun.unwrap_or(DEFAULT_OVERRUN_MM);
    let usual_preload = stated.unwrap_or(DEFAULT_OVERRUN_MM);
    (overrun, preload.unwrap_or(usual_preload))
}

fn targets(section: &Section<'_>, what: Option<RunType>) -> TargetGrid {
    let offset = section
        .choice("targets", &[("equal", false), ("offset", true)])
        .unwrap_or(false);
    let shift = section.within("shift_mm", SHORTEST_LENGTH_MM, LONGEST_LENGTH_MM, "mm");
    if offset && what != Some(RunType::SingleAxis) {
        section.problem(
            "targets",
            "`targets` is `offset`, but the nodes of a diagonal are equal steps (readings are numbered by them)",
            "write `targets = \"equal\"`, or measure single axes (`what = \"single-axis\"`)",
        );
    }
    if section.has("shift_mm") && !offset {
        section.problem(
            "shift_mm",
            "`shift_mm` is stated, but the targets are equal steps",
            "remove it, or write `targets = \"offset\"`",
        );
    }
    if offset {
        TargetGrid::Offset {
            shift: shift.map(Millimetres::new),
        }
    } else {
        TargetGrid::Equal
    }
}

/// A whole number from 1, if the key is present.
fn count(section: &Section<'_>, key: &'static str, most: u32) -> Option<u32> {
    let number = section.whole(key)?;
    if (1..=most).contains(&number) {
        return Some(number);
    }
    section.problem(
        key,
        format!("`program.{key}` is {number}, expected 1 … {most}"),
        format!("write `{key} = …` with a whole number of that range"),
    );
    None
}
