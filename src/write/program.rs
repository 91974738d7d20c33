//! The motion of a measuring run, planned as data (where the axes go, where they stand still, which reading belongs to
//! each standstill), and as part programs with the positions beside them.
//!
//! ```text
//!            far end ●──► overrun           every axis arrives at node 0 and at the far end in
//!                  ┌─┘◄──                   the direction in which it is measured next
//!              ┌───┘
//!          ┌───┘     single-axis steps: move, stand still, read
//!    ──►●──┘
//!  preload  node 0
//! ```
//! All places are whole numbers of the control's last digit ([`LengthDigit`]), so increments never
//! add up to something else, and what a program commands is exactly what `positions.csv` says.

mod fit;
mod route;
mod run;

pub use self::run::{
    Digits, MeasuringRun, MirrorSize, Move, PlannedReading, RunTask, SetUpProgram,
};

use crate::control::controller::{ControlUnit, KitFile};
use crate::inputs::job::{Job, ProgramRequest, Reflector, RunType, TargetGrid};
use crate::quantity::{Axis, Direction, LaserPath, Pass, PerAxis};
use crate::text::{Finding, Problems, findings, shown, words};
use crate::write::control_text::{
    COMMENT_TEXT, Seen, ascii, fixed, is_comment_text, seen, trimmed,
};
use crate::write::emit::{TOOL, bytes_of, comment_texts, engine_context, refused_texts, text};
use crate::write::grid::LengthDigit;
use crate::write::refusals;

/// The last digit of a position on most controls.
const MICROMETRE: LengthDigit = LengthDigit { unit: ControlUnit::Millimetre, decimals: 3 };

/// The motion of a run before a control is asked: lengths to the nearest micrometre, whatever the travel.
pub(crate) fn motion(request: &ProgramRequest) -> MeasuringRun {
    MeasuringRun {
        resolution: MICROMETRE,
        programs: route::programs(request, &route::Scale::nearest(request, MICROMETRE)),
        mirror: run::needed(request),
        notes: Vec::new(),
    }
}

/// Plans a run; refused where it leaves the travel.
pub fn plan(task: RunTask<'_>) -> Result<MeasuringRun, Problems> {
    let (request, resolution) = (task.request, task.resolution());
    let mut problems = Problems::none();
    for refuse in fit::REFUSALS {
        refuse(task, &mut problems);
    }
    problems.or_ok(())?;
    let programs = route::programs(request, &route::Scale::nearest(request, resolution));
    let mirror = run::needed(request);
    Ok(MeasuringRun { resolution, notes: fit::notes(task, programs.len()), programs, mirror })
}

// What a run leaves open, said before it is measured, with the measurement that closes it.

/// Axes measured along their length that determine all scales (docs/method.md §5).
const LINEAR_AXES: usize = 2;

findings! {
    /// What a run alone cannot determine.
    Open {
        Scales { given: usize } => Label,
            "scales (positioning over the whole length): a tilt of the mirror looks the same, and the job names {given} linear axes; measure two axes along their length, three to check them";
        Reversal => Label,
            "reversal: every node is read in one direction; measure with `bidirectional = true`, or linear axes in both directions";
        ReversalOfAnAxis => Label,
            "reversal of a single axis: with overrun only its sum along each diagonal shows; `overrun_mm = 0`, or linear axes in both directions";
        NineErrors => Label,
            "the nine errors: straight runs give the lengths of the diagonals only; use `what = \"step-diagonal\"`";
        Straightness { axes: String } => Label,
            "straightness and squareness: runs along {axes} give the positioning only; use `what = \"step-diagonal\"`, or measure them separately";
        Angles => Label,
            "angular errors: what they do to the diagonals is taken for straightness; measure roll, pitch and yaw and give them as `angles`";
    }
}

/// What the run of a job cannot determine.
pub fn left_open(job: &Job, request: &ProgramRequest) -> Vec<Finding> {
    let reversal = match (request.bidirectional, request.runs_over(), request.what) {
        (false, ..) => Some(Open::Reversal),
        (_, Some(true), RunType::StepDiagonal) => Some(Open::ReversalOfAnAxis),
        _ => None,
    };
    let of_run = match request.what {
        RunType::StepDiagonal => scales(job).into_iter().chain([Open::Angles]).collect(),
        RunType::StraightDiagonal => vec![Open::NineErrors],
        RunType::SingleAxis => vec![Open::Straightness { axes: Axis::letters(&request.axes) }],
    };
    of_run.into_iter().chain(reversal).map(Finding::from).collect()
}

fn scales(job: &Job) -> Option<Open> {
    let given = job.measurement.diagonals().map_or(0, |how| how.linear.len());
    (given < LINEAR_AXES).then_some(Open::Scales { given })
}

// Planned moves → part programs and the positions beside them.

/// A file of a measuring run.
pub type ProgramFile = KitFile<FileRole>;

words! {
    /// What a file of a measuring run is for.
    pub enum FileRole {
        /// A part program.
        Program = "program",
        /// Where each reading is taken.
        Positions = "positions",
        /// A file of readings whose last column is to be filled in.
        Readings = "readings",
    }
}

const POSITIONS: &str = "positions.csv";

/// Decimals of times and feeds: a thousandth of a second, of a millimetre per minute.
const TIME_DECIMALS: u32 = 3;

/// The programs of a run as files, in the order of the plan.
pub fn programs(task: RunTask<'_>, run: &MeasuringRun) -> Result<Vec<ProgramFile>, Problems> {
    refuse_unsafe_text(task)?;
    let mut problems = Problems::none();
    let mut files = Vec::new();
    for (index, program) in run.programs.iter().enumerate() {
        files.extend(problems.take(render(task, task.request.number_of(index), program)));
    }
    problems.or_ok(files)
}

fn refuse_unsafe_text(task: RunTask<'_>) -> Result<(), Problems> {
    let RunTask { job, profile, facts, .. } = task;
    let texts = comment_texts(job).filter(|(key, _)| key.starts_with("machine."));
    let mut problems = refused_texts(job, texts, "the programs");
    let profile_name = ascii(&profile.name).into_owned();
    let of_profile = facts.cancel.value.iter().chain([
        &facts.machine_position.value,
        &facts.increment.value,
        &facts.dwell.value,
        &profile_name,
    ]);
    for text in of_profile.filter(|text| !is_comment_text(text)) {
        problems.push(refusals::text_of_profile(shown(text), COMMENT_TEXT));
    }
    problems.or_ok(())
}

/// What the template of a program sees: names with finished texts.
fn context(task: RunTask<'_>, program: &SetUpProgram, number: u32) -> Seen {
    let RunTask { request, facts, .. } = task;
    let unit = task.resolution().unit;
    let name = program.subject.to_string();
    let [plane, height] = approach(task, &program.places().first().copied().unwrap_or_default());
    let tool_axis = facts.axis_letters.value.get(2).map_or("", String::as_str);
    seen! {
        "name": format!("NONIUS {name}"),
        "number": format!("{number:04}"),
        "header": header(task, program, unit),
        "opening": format!("RETRACT {tool_axis}, NO TOOL OFFSET. {name} GOES TO{plane}, THEN{height}: PATH FREE, CYCLE START"),
        "cancel": facts.cancel.value.clone(),
        "machine_position": facts.machine_position.value.as_str(),
        "increment": facts.increment.value.as_str(),
        "dwell": facts.dwell.value.as_str(),
        "dwell_s": decimal(request.dwell_s),
        "unit_word": facts.language.facts().unit_word(unit),
        "feed": decimal(request.feed_mm_per_min / unit.in_mm()),
        "blocks": blocks(task, program),
    }
}

fn header(task: RunTask<'_>, program: &SetUpProgram, unit: ControlUnit) -> Vec<String> {
    let RunTask { job, request, profile, .. } = task;
    let unit = unit.word();
    let serial = ascii(job.machine.serial.as_deref().unwrap_or("NOT STATED"));
    let directions = if request.bidirectional { "BOTH DIRECTIONS" } else { "FORWARD ONLY" };
    let order = Axis::letters(&request.volume.order);
    let reflector = match request.target {
        Reflector::FlatMirror => "FLAT MIRROR",
        Reflector::Retroreflector => "RETROREFLECTOR",
    };
    let path = match request.what {
        RunType::StepDiagonal => format!("ORDER OF MOVES {order}, {reflector}"),
        RunType::StraightDiagonal => format!("ALL AXES TOGETHER, {reflector}"),
        RunType::SingleAxis => match request.targets {
            TargetGrid::Equal => "EQUAL TARGETS".to_string(),
            TargetGrid::Offset { .. } => "OFFSET TARGETS".to_string(),
        },
    };
    let lines = [
        format!("MEASURING RUN {}: {}", request.what.word(), program.subject),
        format!("MACHINE {}", ascii(&job.machine.name)),
        format!("SERIAL {serial}"),
        format!("MADE BY {TOOL} FOR {}", ascii(&profile.name)),
        path,
        format!("STEPS {}, RUNS {}, {directions}, UNIT {unit}", request.volume.steps, request.runs),
        format!("{} READINGS: BLOCK N IS READING N OF positions.csv", program.readings.len()),
        "NO OFFSET IS WRITTEN; POSITIONS ARE MACHINE COORDINATES".to_string(),
    ];
    lines.map(|line| line.to_uppercase()).to_vec()
}

fn blocks(task: RunTask<'_>, program: &SetUpProgram) -> Vec<Seen> {
    let block = |step: &Move| match step {
        Move::Stop(text) => vec![seen! { "kind": "stop", "text": text.as_str() }],
        Move::Remark(text) => vec![seen! { "kind": "comment", "text": text.as_str() }],
        Move::Approach(place) => {
            approach(task, place).map(|words| seen! { "kind": "approach", "words": words }).to_vec()
        }
        Move::Feed(by) => {
            let words = words(task, by, |axis| by[axis] != 0);
            vec![seen! { "kind": "feed", "words": words }]
        }
        Move::Dwell(reading) => {
            vec![seen! { "kind": "dwell", "number": (reading + 1).to_string() }]
        }
    };
    program.moves.iter().flat_map(block).collect()
}

/// The first place in two blocks: X and Y at the height where the operator left Z, then Z alone.
fn approach(task: RunTask<'_>, place: &PerAxis<Digits>) -> [String; 2] {
    [false, true].map(|last| words(task, place, |axis| (axis == Axis::Z) == last))
}

/// ` X1.000 Y-2.000` of the axes that are wanted.
fn words(task: RunTask<'_>, of: &PerAxis<Digits>, wanted: impl Fn(Axis) -> bool) -> String {
    let word = |(axis, letter): (Axis, &String)| {
        wanted(axis).then(|| format!(" {letter}{}", task.resolution().text(of[axis])))
    };
    Axis::ALL.into_iter().zip(&task.facts.axis_letters.value).filter_map(word).collect()
}

fn render(task: RunTask<'_>, number: u32, program: &SetUpProgram) -> Result<ProgramFile, Problems> {
    let RunTask { profile, facts, .. } = task;
    let stem = match facts.language.facts().numbered {
        None => format!("NONIUS_{}", program.subject),
        Some(_) => format!("O{number:04}"),
    };
    let text = text(&facts.template, &engine_context(&context(task, program, number)))?;
    let path = format!("{stem}.{}", facts.extension);
    let bytes = bytes_of(&path, &text, profile)?;
    Ok(ProgramFile { path, role: FileRole::Program, bytes })
}

/// Expected positions: one row for each reading, in the order in which they are taken.
pub fn positions(run: &MeasuringRun) -> ProgramFile {
    let of_diagonals = run.programs.iter().any(|p| matches!(p.subject, LaserPath::Diagonal(_)));
    let subject = if of_diagonals { "diagonal" } else { "axis" };
    let mut text = format!("{subject},run,direction,node,moved,nominal_mm,x_mm,y_mm,z_mm,block\n");
    for program in &run.programs {
        let name = program.subject.name();
        for (index, reading) in program.readings.iter().enumerate() {
            let place = reading.place.iter().map(|(_, d)| shortest(run.resolution.mm(*d)));
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
    ProgramFile { path: POSITIONS.to_string(), role: FileRole::Positions, bytes: text.into_bytes() }
}

/// Files of readings with an empty last column: of diagonals one in the form of contract §2.2, of
/// single axes one each in the form of §2.4. What stays empty is refused as missing.
pub(crate) fn readings_to_fill(run: &MeasuringRun) -> Vec<ProgramFile> {
    let mut files: Vec<ProgramFile> = Vec::new();
    for program in &run.programs {
        let (path, header) = form_of(program);
        if files.last().is_none_or(|file| file.path != path) {
            files.push(ProgramFile {
                path,
                role: FileRole::Readings,
                bytes: header.as_bytes().to_vec(),
            });
        }
        let rows = program.readings.iter();
        let rows: String =
            rows.map(|reading| empty_row(program, reading, run.resolution)).collect();
        if let Some(file) = files.last_mut() {
            file.bytes.extend(rows.into_bytes());
        }
    }
    files
}

/// Name and header of the file that a program's readings belong to.
fn form_of(program: &SetUpProgram) -> (String, &'static str) {
    let diagonals = "readings.csv".to_string();
    match program.subject {
        LaserPath::Axis(axis) => {
            (format!("readings-{}.csv", axis.key()), "target_mm,run,direction,deviation_um\n")
        }
        LaserPath::Diagonal(_) if is_stepped(program) => {
            (diagonals, "diagonal,run,direction,node,moved,displacement_mm\n")
        }
        LaserPath::Diagonal(_) => (diagonals, "diagonal,run,direction,node,displacement_mm\n"),
    }
}

/// Straight runs have no column `moved`.
fn is_stepped(program: &SetUpProgram) -> bool {
    program.readings.iter().any(|r| r.moved.is_some())
}

fn empty_row(program: &SetUpProgram, reading: &PlannedReading, resolution: LengthDigit) -> String {
    let PlannedReading { run, node, pass, .. } = reading;
    match program.subject {
        LaserPath::Axis(axis) => {
            let target = shortest(resolution.mm(reading.place[axis]));
            let direction = match pass {
                Pass::Forward => Direction::Plus,
                Pass::Reverse => Direction::Minus,
            };
            format!("{target},{run},{},\n", direction.symbol())
        }
        LaserPath::Diagonal(of) => {
            let moved = reading.moved.map_or("", Axis::key);
            let moved = if is_stepped(program) { format!("{moved},") } else { String::new() };
            format!("{of},{run},{},{node},{moved}\n", pass.word())
        }
    }
}

/// A time or a feed: at least one decimal, so that no control takes it for its smallest units.
fn decimal(number: f64) -> String {
    let text = fixed(number, TIME_DECIMALS);
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.to_string() }
}

/// A length in mm with all digits that a laser can show, 1e-6 mm, without trailing zeros.
fn shortest(mm: f64) -> String {
    trimmed(mm, 6)
}
