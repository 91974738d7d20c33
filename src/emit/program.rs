//! Planned moves → part programs and the positions beside them.

use crate::axis::{Axis, PerAxis};
use crate::controller::LengthUnit;
use crate::controller::program::Language;
use crate::emit::{COMMENT_TEXT, LONGEST_TEXT};
use crate::emit::{TOOL, fixed, is_comment_text, render_text, with_line_ends};
use crate::job::{RunType, TargetGrid};
use crate::problem::{Problem, Problems};
use crate::program::{Digits, MeasuringRun, Move, Resolution, RunTask, SetUpProgram, Subject};
use serde::Serialize;

/// A file of a measuring run, ready to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramFile {
    /// Its name.
    pub path: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Name of the file of expected positions.
pub const POSITIONS: &str = "positions.csv";

/// What the template of a program sees. Every number is finished text.
#[derive(Clone, Debug, Serialize)]
struct ProgramContext<'a> {
    name: String,
    number: String,
    header: Vec<String>,
    opening: String,
    cancel: &'a [String],
    machine_position: &'a str,
    increment: &'a str,
    dwell: &'a str,
    dwell_s: String,
    unit_word: &'static str,
    feed: String,
    blocks: Vec<Block>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Block {
    Comment { text: String },
    Stop { text: String },
    Approach { words: String },
    Feed { words: String },
    Dwell { number: String },
}

/// Decimals of times and feeds: a thousandth of a second, of a millimetre per minute.
const TIME_DECIMALS: u32 = 3;

/// The programs of a run as files, in the order of the plan.
pub fn programs(task: RunTask<'_>, run: &MeasuringRun) -> Result<Vec<ProgramFile>, Problems> {
    refuse_unsafe_text(task)?;
    let mut problems = Problems::none();
    let mut files = Vec::new();
    for (index, program) in run.programs.iter().enumerate() {
        let number = task.request.number + u32::try_from(index).unwrap_or(0);
        let context = context(task, program, run.resolution, number);
        files.extend(problems.take(render(task, &context, number, program)));
    }
    problems.or_ok(files)
}

fn refuse_unsafe_text(task: RunTask<'_>) -> Result<(), Problems> {
    let RunTask {
        job,
        profile,
        facts,
        ..
    } = task;
    let mut problems = Problems::none();
    let serial = job.machine.serial.clone().unwrap_or_default();
    for (path, text) in [
        ("machine.name", &job.machine.name),
        ("machine.serial", &serial),
    ] {
        if !is_comment_text(text) {
            let message =
                format!("`{path}` goes into comments of the programs, expected {COMMENT_TEXT}");
            problems.push(
                job.problem_at(path, message)
                    .help("write it in plain letters and digits"),
            );
        }
    }
    let blocks = facts.cancel.value.iter().chain([
        &facts.machine_position.value,
        &facts.increment.value,
        &facts.dwell.value,
    ]);
    for text in blocks.chain([&profile.name]) {
        if !is_comment_text(text) || text.len() > LONGEST_TEXT {
            problems.push(
                Problem::new(format!(
                    "the profile's text `{}` cannot stand in a program",
                    crate::problem::shown(text)
                ))
                .help(format!("expected {COMMENT_TEXT}")),
            );
        }
    }
    problems.or_ok(())
}

fn context<'a>(
    task: RunTask<'a>,
    program: &SetUpProgram,
    resolution: Resolution,
    number: u32,
) -> ProgramContext<'a> {
    let RunTask { request, facts, .. } = task;
    let unit = resolution.unit;
    let letters = &facts.axis_letters.value;
    let name = program.subject.name();
    let start = program
        .places()
        .first()
        .copied()
        .unwrap_or(PerAxis::from_fn(|_| 0));
    let approach = words(letters, &start, resolution, true);
    ProgramContext {
        name: format!("NONIUS {name}"),
        number: format!("{number:04}"),
        header: header(task, program, unit),
        opening: format!("{name} GOES TO{approach}: PATH FREE, NO TOOL OFFSET ACTIVE, CYCLE START"),
        cancel: &facts.cancel.value,
        machine_position: &facts.machine_position.value,
        increment: &facts.increment.value,
        dwell: &facts.dwell.value,
        dwell_s: decimal(request.dwell_s),
        unit_word: unit_word(facts.language, unit),
        feed: decimal(request.feed_mm_per_min / unit.in_mm()),
        blocks: blocks(program, letters, resolution),
    }
}

const fn unit_word(language: Language, unit: LengthUnit) -> &'static str {
    match (language, unit) {
        (Language::Siemens, LengthUnit::Millimetre) => "G710",
        (Language::Siemens, LengthUnit::Inch) => "G700",
        (Language::Fanuc, LengthUnit::Millimetre) => "G21",
        (Language::Fanuc, LengthUnit::Inch) => "G20",
    }
}

fn header(task: RunTask<'_>, program: &SetUpProgram, unit: LengthUnit) -> Vec<String> {
    let RunTask {
        job,
        request,
        profile,
        ..
    } = task;
    let unit = unit.word();
    let serial = job.machine.serial.as_deref().unwrap_or("NOT STATED");
    let directions = if request.bidirectional {
        "BOTH DIRECTIONS"
    } else {
        "FORWARD ONLY"
    };
    let order: String = request
        .volume
        .order
        .iter()
        .map(|axis| axis.letter())
        .collect();
    let path = match request.what {
        RunType::StepDiagonal => format!("ORDER OF MOVES {order}, FLAT MIRROR"),
        RunType::StraightDiagonal => "ALL AXES TOGETHER, RETROREFLECTOR".to_string(),
        RunType::SingleAxis => match request.targets {
            TargetGrid::Equal => "EQUAL TARGETS".to_string(),
            TargetGrid::Offset { .. } => "OFFSET TARGETS".to_string(),
        },
    };
    let lines = [
        format!(
            "MEASURING RUN {}: {}",
            request.what.word(),
            program.subject.name()
        ),
        format!("MACHINE {}", job.machine.name),
        format!("SERIAL {serial}"),
        format!("MADE BY {TOOL} FOR {}", profile.name),
        path,
        format!(
            "STEPS {}, RUNS {}, {directions}, UNIT {unit}",
            request.volume.steps, request.runs
        ),
        format!(
            "{} READINGS: BLOCK N IS READING N OF positions.csv",
            program.readings.len()
        ),
        "NO OFFSET IS WRITTEN; POSITIONS ARE MACHINE COORDINATES".to_string(),
    ];
    lines.map(|line| line.to_uppercase()).to_vec()
}

fn blocks(program: &SetUpProgram, letters: &[String], resolution: Resolution) -> Vec<Block> {
    let block = |step: &Move| match step {
        Move::Stop(text) => Block::Stop { text: text.clone() },
        Move::Remark(text) => Block::Comment { text: text.clone() },
        Move::Approach(place) => Block::Approach {
            words: words(letters, place, resolution, true),
        },
        Move::Feed(by) => Block::Feed {
            words: words(letters, by, resolution, false),
        },
        Move::Dwell(reading) => Block::Dwell {
            number: (reading + 1).to_string(),
        },
    };
    program.moves.iter().map(block).collect()
}

/// ` X1.000 Y-2.000`; an axis that does not move is written only where `all` are.
fn words(letters: &[String], of: &PerAxis<Digits>, resolution: Resolution, all: bool) -> String {
    let word = |(axis, letter): (Axis, &String)| {
        let wanted = all || of[axis] != 0;
        wanted.then(|| format!(" {letter}{}", resolution.text(of[axis])))
    };
    Axis::ALL
        .into_iter()
        .zip(letters)
        .filter_map(word)
        .collect()
}

fn render(
    task: RunTask<'_>,
    context: &ProgramContext<'_>,
    number: u32,
    program: &SetUpProgram,
) -> Result<ProgramFile, Problems> {
    let RunTask { profile, facts, .. } = task;
    let stem = match facts.language {
        Language::Siemens => format!("NONIUS_{}", program.subject.name()),
        Language::Fanuc => format!("O{number:04}"),
    };
    let seen = tera::Context::from_serialize(context).map_err(|error| {
        Problem::new(format!(
            "the context of the program cannot be made: {error}"
        ))
    })?;
    let text = render_text(&facts.template_name, &facts.template, &seen)?;
    Ok(ProgramFile {
        path: format!("{stem}.{}", facts.extension),
        bytes: with_line_ends(text, profile.line_end.value.text()).into_bytes(),
    })
}

/// Expected positions: one row for each reading, in the order in which they are taken.
pub fn positions(run: &MeasuringRun) -> ProgramFile {
    let of_diagonals = run
        .programs
        .iter()
        .any(|p| matches!(p.subject, Subject::Diagonal(_)));
    let subject = if of_diagonals { "diagonal" } else { "axis" };
    let mut text = format!("{subject},run,direction,node,moved,nominal_mm,x_mm,y_mm,z_mm,block\n");
    for program in &run.programs {
        let name = match program.subject {
            Subject::Diagonal(diagonal) => diagonal.name().to_string(),
            Subject::Axis(axis) => axis.key().to_string(),
        };
        for (index, reading) in program.readings.iter().enumerate() {
            let place = reading
                .place
                .iter()
                .map(|(_, d)| shortest(run.resolution.mm(*d)));
            let place: Vec<String> = place.collect();
            text.push_str(&format!(
                "{name},{},{},{},{},{},{},{}\n",
                reading.run,
                reading.pass.word(),
                reading.node,
                reading.moved.map_or("", Axis::key),
                shortest(reading.nominal_mm),
                place.join(","),
                index + 1
            ));
        }
    }
    ProgramFile {
        path: POSITIONS.to_string(),
        bytes: text.into_bytes(),
    }
}

/// A time or a feed: at least one decimal, so that no control takes it for its smallest units.
fn decimal(number: f64) -> String {
    let text = fixed(number, TIME_DECIMALS);
    let short = text.trim_end_matches('0');
    if short.ends_with('.') {
        format!("{short}0")
    } else {
        short.to_string()
    }
}

/// A length in mm with all digits that a laser can show, 1e-6 mm, without trailing zeros.
fn shortest(mm: f64) -> String {
    let text = fixed(mm, 6);
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
