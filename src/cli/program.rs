//! `nonius program JOB -o DIR`

use crate::cli::outcome::{Outcome, Output};
use crate::cli::screen::{Screen, paragraphs, table, wrapped};
use crate::cli::show;
use crate::inputs::job::{Job, RunType, TargetGrid, UseOf};
use crate::kit::manifest::{MANIFEST, bytes_of_kit};
use crate::kit::program_kit::{ProgramKit, make};
use crate::quantity::{Axis, Figure};
use crate::text::{Line, Problems, Source, counted, header_and_rows};
use crate::visit::files::{Files, printed};
use crate::visit::job_files::{InputFile, JobFiles};
use crate::write::program::{FileRole, left_open};
use clap::Args;
use std::path::{Path, PathBuf};

// Options of `program`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true).value_name("DIR")
    .help("Directory of the programs; must not exist yet, or must be empty")))]
pub(super) struct Options {
    /// The job (TOML) with a section [program]; `-` = standard input
    job: PathBuf,
    #[command(flatten)]
    output: Output,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let directory = options.output.free_directory(files)?;
    let file = InputFile::read(files, &options.job)?;
    let job = Job::read_for(file.source()?, UseOf::Programs)?;
    let named = JobFiles::new(files, job, &options.job);
    named.hashes.borrow_mut().push(file.hash);
    let (profile, job) = (named.profile()?, &named.job);
    let mut kit = make(job, &profile, &named.hashes.borrow())?;
    let table = ReadingsTable::of(&named, &kit);
    if table.as_ref().is_some_and(|table| table.is_ready) {
        kit = kit.without_form();
    }
    let own = kit.files.iter().map(|file| (file.path.as_str(), file.bytes.as_slice()));
    let (manifest, print) = (bytes_of_kit(&kit)?, options.output.print);
    let outcome = print.as_it_is(|| screen(job, &profile.name, &kit), || &kit)?;
    let next_steps = next_steps(directory, &kit, table);
    options.output.deliver_files(files, outcome, own, (MANIFEST, &manifest), next_steps)
}

/// The table of readings that the job names for this run.
struct ReadingsTable {
    place: PathBuf,
    /// It has a row for each reading, so there is no other one to be filled in.
    is_ready: bool,
}

impl ReadingsTable {
    fn of(named: &JobFiles<'_>, kit: &ProgramKit) -> Option<ReadingsTable> {
        let measured = named.job.measurement.diagonals()?;
        if kit.request.what.path() != Some(measured.kind) {
            return None;
        }
        let place = named.folder.join(&measured.readings);
        let source = named.files.bytes(&place).ok();
        let source = source.and_then(|bytes| Source::from_bytes("", &bytes).ok());
        let rows = source.as_ref().and_then(header_and_rows);
        let is_empty =
            |row: &Line<'_>| row.cells().last().is_none_or(|cell| cell.trim().is_empty());
        let is_ready =
            rows.is_some_and(|(_, rows)| rows.len() == kit.readings && rows.iter().all(is_empty));
        Some(ReadingsTable { place, is_ready })
    }
}

fn screen(job: &Job, control: &str, kit: &ProgramKit) -> Screen {
    Screen {
        figures: paragraphs(&[
            motion(kit),
            not_determined(job, kit),
            files(kit),
            reach(job, kit),
            mirror(kit).unwrap_or_default(),
        ]),
        findings: show::notes(&kit.notes),
        more: vec![show::assumptions(&kit.assumptions), show::preconditions(&kit.preconditions)],
        ..Screen::of(format!("{} - {control}: {}", job.machine.name, kit.request.what.word()))
    }
}

fn motion(kit: &ProgramKit) -> String {
    let request = &kit.request;
    let order = Axis::letters(&request.volume.order);
    let path = match (request.what, request.targets) {
        (RunType::StepDiagonal, _) => format!("one axis at a time in the order {order}"),
        (RunType::StraightDiagonal, _) => "all axes together".to_string(),
        (RunType::SingleAxis, TargetGrid::Equal) => "equal targets (for tables)".to_string(),
        (RunType::SingleAxis, TargetGrid::Offset { .. }) => {
            "offset targets (for acceptance)".to_string()
        }
    };
    let back = match (request.bidirectional, request.overrun.mm() > 0.0) {
        (true, true) => format!("return pass measured after {} mm of overrun", request.overrun.mm()),
        (true, false) => "return pass measured, turning without overrun: the first step back shows each axis' reversal".to_string(),
        (false, _) => format!("return pass not measured ({})", request.way_back.word()),
    };
    let minutes = kit.run.duration_s(request) / 60.0;
    let runs = counted(request.runs, "run");
    let mut lines = vec![
        format!("{} steps, {path}; {runs}, {back}", request.volume.steps),
        format!(
            "feed {} mm/min, standstill {} s at every node, preload {} mm; {minutes:.0} min without set-up",
            request.feed_mm_per_min,
            request.dwell_s,
            request.preload.mm()
        ),
    ];
    lines.extend(request.runs_over().map(|over| {
        format!("with these readings state `overrun = {over}` in [measurement.step_diagonal]")
    }));
    lines.join("\n")
}

/// What this run cannot determine, with what closes it.
fn not_determined(job: &Job, kit: &ProgramKit) -> String {
    let open = left_open(job, &kit.request);
    let lines = open.iter().map(|open| wrapped(&format!("  {open}")));
    let head = "this run alone does not determine".to_string();
    std::iter::once(head).chain(lines).collect::<Vec<_>>().join("\n")
}

fn files(kit: &ProgramKit) -> String {
    let rows = kit.run.programs.iter().zip(&kit.files).map(|(program, file)| {
        let (subject, readings) = (program.subject, program.readings.len());
        format!("{}\t{subject}\t{readings}", file.path)
    });
    table("program\tmeasures\t>readings", rows)
}

fn reach(job: &Job, kit: &ProgramKit) -> String {
    let row = |axis: Axis| {
        let (low, high) = kit.run.reach_mm(axis)?;
        let travel = job.machine.axes[axis]?;
        let [low, high] = [low, high].map(Figure);
        let [from, to] = [travel.low, travel.high].map(|at| Figure(at.mm()));
        Some(format!("{axis}\t{low:.3}\t{high:.3}\t{from:.3}\t{to:.3}"))
    };
    table("axis\t>from/mm\t>to/mm\t>travel/mm\t>to/mm", Axis::ALL.into_iter().filter_map(row))
}

fn mirror(kit: &ProgramKit) -> Option<String> {
    let size = kit.run.mirror?;
    let ([first, second], farthest, circle) = (size.excursion_mm, size.farthest_mm, size.circle_mm);
    Some(format!(
        "sideways on the mirror: {first:.1} mm after the first move, {second:.1} mm after the second, {farthest:.1} mm at most with preload and overrun\nmirror: a circle of {circle:.1} mm and the diameter of the beam around it"
    ))
}

fn next_steps(directory: &Path, kit: &ProgramKit, table: Option<ReadingsTable>) -> String {
    let mut lines = Vec::new();
    for file in &kit.files {
        let purpose = match file.role {
            FileRole::Program => "part program, read back and walked",
            FileRole::Positions => "where each reading is taken",
            FileRole::Readings => "to be filled in: its last column is empty",
        };
        lines.push(format!("wrote {} ({purpose})", printed(&directory.join(&file.path))));
    }
    lines.push(format!("wrote {}", printed(&directory.join(MANIFEST))));
    lines.extend(table.map(|table| match (printed(&table.place), table.is_ready) {
        (place, true) => format!("the readings go into {place}, which the job names"),
        (place, false) => {
            format!("copy the file to be filled in to {place}, which the job names")
        }
    }));
    lines.push("before cycle start: read the header, single block and low rapid override until node 0 (docs/measuring.md)".to_string());
    lines.join("\n")
}
