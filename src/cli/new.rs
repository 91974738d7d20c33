//! `nonius new --controller ID --travel X,Y,Z -o DIR`

use crate::cli::job_files::profile;
use crate::cli::outcome::{Outcome, Output};
use crate::cli::screen::{Screen, shell_word};
use crate::kit::visit::{AFTER, AFTER_JOB, JOB, KIT, Visit};
use crate::quantity::axis::PerAxis;
use crate::quantity::units::{Figure, MM_PER_INCH};
use crate::text::document::LONGEST_MM;
use crate::text::problem::{Problem, Problems};
use clap::Args;
use serde_json::json;
use std::fmt;
use std::path::{Component, Path};

// Options of `new`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true).value_name("DIR")
    .help("Directory of the visit; must not exist yet, or must be empty")))]
pub(super) struct Options {
    /// An id of `nonius controllers list`, or the path of a profile of your own
    #[arg(long, value_name = "ID")]
    controller: String,
    /// Travel of X, Y and Z, mm: a length from machine coordinate 0, or both ends, e.g. 800,500,-400:0; of
    /// inches each with `in`: 32in,20in,-16:0in
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true,
        num_args = 1, required = true, value_parser = ends)]
    travel: Vec<(f64, f64)>,
    /// Readings of the four body diagonals, in place of an error table
    #[arg(long)]
    readings: bool,
    /// Values of both directions of travel
    #[arg(long)]
    both_directions: bool,
    /// Number of equal steps of each axis [default: steps of 50 mm at most, from 10 to 30]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    steps: Option<u32>,
    #[command(flatten)]
    output: Output,
}

/// `800` = 0 … 800, `-400:0` = both ends, `-16:0in` = both in inches.
fn ends(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = text.split_once(':').unwrap_or(("0", text));
    let (high, mm) = match high.trim().strip_suffix("in") {
        Some(inches) => (inches, MM_PER_INCH),
        None => (high, 1.0),
    };
    let number = |text: &str| Some(mm * text.trim().parse::<f64>().ok()?);
    let ends = number(low).zip(number(high));
    let is_travel =
        |(low, high): &(f64, f64)| low < high && low.abs().max(high.abs()) <= LONGEST_MM;
    ends.filter(is_travel).ok_or_else(|| {
        let expected =
            "expected a length in mm (or `32in`), or the ends of the travel as LOW:HIGH, for each of X,Y,Z";
        match ends {
            Some((0.0, below)) if below < 0.0 => {
                format!("{expected}: from {below} to 0 mm is `{below}:0`")
            }
            _ => expected.to_string(),
        }
    })
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let directory = options.output.free_directory()?;
    let [x, y, z] = <[(f64, f64); 3]>::try_from(options.travel.clone()).map_err(|travel| {
        let (count, help) = (travel.len(), "for instance `--travel 800,500,400`");
        Problem::new(format!("`--travel` names {count} axes, expected X, Y and Z")).help(help)
    })?;
    let (profile, _) = profile(&options.controller, Path::new(""))?;
    let visit = Visit {
        profile: &profile,
        controller: &from_inside(&options.controller, directory),
        travel: PerAxis { x, y, z },
        steps: options.steps,
        readings: options.readings,
        both_directions: options.both_directions,
    };
    let (tables, job) = (visit.tables()?, visit.job()?);
    let stages = stages(&visit, directory);
    let names: Vec<&str> = tables.iter().map(|(name, _)| *name).collect();
    let names = [&[JOB], names.as_slice()].concat();
    let next: Vec<&String> = stages.iter().flat_map(|stage| &stage.commands).collect();
    let document = json!({ "schema": 1, "controller": profile.id, "files": names,
        "steps": visit.steps(), "next": next });
    let screen = Screen {
        verdict: format!(
            "{}: fill in every \"\" of {JOB}, and the empty cells of {}",
            profile.name,
            visit.table_name()
        ),
        always: vec![travel_words(&visit)],
        ..Screen::default()
    };
    let stages: Vec<String> = stages.iter().map(Stage::to_string).collect();
    let (place, names) = (directory.display(), names.join(", "));
    let talk = format!("wrote {place}: {names}\nthen:\n{}", stages.join("\n"));
    let outcome = options.output.print.outcome(|| screen, || document)?;
    let tables = tables.iter();
    let tables: Vec<_> = tables.map(|(name, text)| (*name, text.as_bytes())).collect();
    options.output.deliver_files(outcome, &tables, (JOB, job.as_bytes()), talk)
}

/// What a length was taken for: where an axis counts from elsewhere, every position would be another one.
fn travel_words(visit: &Visit<'_>) -> String {
    let ends = visit.travel.iter();
    let ends =
        ends.map(|(axis, (low, high))| format!("{axis} {} … {} mm", Figure(*low), Figure(*high)));
    let ends: Vec<String> = ends.collect();
    format!(
        "travel in machine coordinates: {}; compare it with the machine (an axis that counts from another zero: `--travel` with LOW:HIGH)",
        ends.join(", ")
    )
}

/// What a person does, and the commands that follow it.
struct Stage {
    words: String,
    commands: Vec<String>,
}

impl fmt::Display for Stage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "  {}", self.words)?;
        let mut commands = self.commands.iter();
        commands.try_for_each(|command| write!(out, "\n    {command}"))
    }
}

/// The whole visit.
fn stages(visit: &Visit<'_>, directory: &Path) -> Vec<Stage> {
    let place = |name: &str| shell_word(&directory.join(name));
    let [job, kit] = [JOB, KIT].map(place);
    let table = visit.table_name();
    let tables = format!("{job} --tables {kit}");
    let after = format!("{tables} --after {}", place(visit.after()));
    let stage = |words: String, commands: Vec<String>| Stage { words, commands };
    let programs = visit.has_programs();
    let programs = programs.then(|| format!("nonius program {job} -o {}", place("programs")));
    let planned = [format!("nonius plan {job}")].into_iter().chain(programs);
    let separate = visit.readings.then(|| format!("nonius separate {job}"));
    let generate = format!("nonius generate {job} -o {kit}");
    let before = "before measuring: what the run will determine, its part programs".to_string();
    let again = match visit.readings {
        true => format!("{AFTER} and {AFTER_JOB}"),
        false => AFTER.to_string(),
    };
    let before = visit.readings.then(|| stage(before, planned.collect()));
    let others = [
        stage(
            format!("measure, fill in {table} and what is left of {JOB}: files for the control"),
            separate.into_iter().chain([generate]).collect(),
        ),
        stage(
            format!("before loading, which {} leads through", place("kit/checklist.html")),
            vec![format!("nonius verify {tables}")],
        ),
        stage(
            format!("measure again, fill in {again}: what is left, and the page to hand over"),
            vec![
                format!("nonius verify {after}"),
                format!("nonius report {after} -o {}", place("report.html")),
            ],
        ),
    ];
    before.into_iter().chain(others).collect()
}

/// How a job in `directory` names a profile: by its id, or by its path from there.
fn from_inside(controller: &str, directory: &Path) -> String {
    let path = Path::new(controller);
    let is_down = |part: Component<'_>| matches!(part, Component::Normal(_));
    let is_path =
        controller.contains(['/', '\\']) || controller.to_ascii_lowercase().ends_with(".toml");
    if !is_path || path.is_absolute() {
        return controller.to_string();
    }
    match directory.components().all(is_down) {
        true => "../".repeat(directory.components().count()) + controller,
        false => std::path::absolute(path)
            .map_or_else(|_| controller.to_string(), |path| path.display().to_string()),
    }
}
