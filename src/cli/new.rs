//! `nonius new --controller ID --travel X,Y,Z -o DIR`

use crate::cli::outcome::{Outcome, Output};
use crate::cli::refusals;
use crate::cli::screen::{Screen, shell_word};
use crate::control::controller::{ControlUnit, Profile};
use crate::inputs::job::{Job, MeasuredData, UseOf};
use crate::judge::active::{ActiveControl, ReadOutFor, from_read_out};
use crate::judge::findings::InControl;
use crate::kit::manifest::MANIFEST;
use crate::kit::visit::{AFTER, AFTER_JOB, Begun, Earlier, JOB, KIT, TableToFill, Visit};
use crate::quantity::{Figure, MM_PER_INCH, PerAxis, rounded};
use crate::text::{Finding, LONGEST_MM, Problems, Severity, joined};
use crate::visit::files::{Files, PathEntry, printed, with_slashes};
use crate::visit::inputs::{errors, of_control};
use crate::visit::job_files::{InputFile, JobFiles, profile};
use crate::write::plan::axis_names;
use clap::Args;
use serde_json::json;
use std::path::{Component, Path, PathBuf};

// Options of `new`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true).value_name("DIR")
    .help("Directory of the visit; must not exist yet, or must be empty")))]
pub(super) struct Options {
    /// An id of `nonius controllers list`, or the path of a profile of your own
    #[arg(long, value_name = "ID", required_unless_present = "from")]
    controller: Option<String>,
    /// Travel of X, Y and Z, mm: a length from machine coordinate 0, or both ends, e.g. 800,500,-400:0; of
    /// inches each with `in`: 32in,20in,-16:0in
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true,
        num_args = 1, required_unless_present = "from", value_parser = ends)]
    travel: Vec<Ends>,
    /// Readings of the four body diagonals, in place of an error table
    #[arg(long)]
    readings: bool,
    /// Values of both directions of travel
    #[arg(long)]
    both_directions: bool,
    /// Number of equal steps of each axis [default: steps of 50 mm at most, from 10 to 30]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    steps: Option<u32>,
    /// The job of an earlier visit: all but its day is carried over, and its kit is what is active now
    #[arg(long, value_name = "JOB",
        conflicts_with_all = ["controller", "travel", "readings", "both_directions", "steps"])]
    from: Option<PathBuf>,
    /// Read out of the control since then: what is active now, and what it says of unit, references, travel and detection units
    #[arg(long, value_name = "PATH", requires = "from")]
    read_out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// Ends of a travel, mm, and whether they were given in inches.
type Ends = ((f64, f64), bool);

/// `800` = 0 … 800, `-400:0` = both ends, `-16:0in` = both in inches.
fn ends(text: &str) -> Result<Ends, String> {
    let (low, high) = text.split_once(':').unwrap_or(("0", text));
    let (high, mm) =
        high.trim().strip_suffix("in").map_or((high, 1.0), |inches| (inches, MM_PER_INCH));
    let number = |text: &str| Some(rounded(mm * text.trim().parse::<f64>().ok()?, 9));
    let ends = number(low).zip(number(high));
    let is_travel =
        |(low, high): &(f64, f64)| low < high && low.abs().max(high.abs()) <= LONGEST_MM;
    let inches = mm > 1.0;
    ends.filter(is_travel).map(|ends| (ends, inches)).ok_or_else(|| {
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

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let directory = options.output.free_directory(files)?;
    let (profile, begun, words) = match &options.from {
        Some(job) => again(files, job, options.read_out.as_deref(), directory)?,
        None => first(options, files, directory)?,
    };
    let stages = stages(&begun, directory);
    let tables = begun.tables.iter().map(|(name, text)| (name.as_str(), text.as_bytes()));
    let names: Vec<&str> =
        std::iter::once(JOB).chain(begun.tables.iter().map(|(name, _)| name.as_str())).collect();
    let next: Vec<&String> = stages.iter().flat_map(|(_, commands)| commands).collect();
    let document = json!({ "controller": profile.id, "files": names,
        "steps": begun.steps, "next": next });
    let screen = Screen {
        always: words,
        ..Screen::of(format!(
            "{}: fill in every \"\" of {JOB}, and the empty cells of {}",
            profile.name, begun.measured
        ))
    };
    let stages = stages.iter().map(|(words, all)| format!("{words}\n    {}", all.join("\n    ")));
    let stages: Vec<String> = stages.collect();
    let (place, names) = (printed(directory), names.join(", "));
    let talk = format!("wrote {place}: {names}\nthen:\n  {}", stages.join("\n  "));
    let outcome = options.output.print.outcome(|| screen, || document)?;
    options.output.deliver_files(files, outcome, tables, (JOB, begun.job.as_bytes()), talk)
}

/// The control, the files, and what has to be said of them.
type Beginning = (Profile, Begun, Vec<String>);

fn first(options: &Options, files: &dyn Files, directory: &Path) -> Result<Beginning, Problems> {
    let [x, y, z] = <[Ends; 3]>::try_from(options.travel.clone())
        .map_err(|travel| refusals::travel_of_axes(travel.len()))?;
    let controller = options.controller.as_deref().unwrap_or_default();
    let (profile, _) = profile(files, controller, Path::new(""))?;
    let visit = Visit {
        profile: &profile,
        controller: &from_inside(controller, directory),
        travel: PerAxis { x: x.0, y: y.0, z: z.0 },
        inches: [x, y, z].iter().any(|(_, inches)| *inches),
        steps: options.steps,
        readings: options.readings,
        both_directions: options.both_directions,
    };
    let (begun, better) = (visit.begun()?, visit.better_steps().into_iter());
    let better = better.map(|n| {
        format!("round steps hide errors that repeat with a usual pitch; `--steps {n}` shows more of them, where the control takes such a spacing")
    });
    let words = std::iter::once(travel_words(&visit)).chain(better).collect();
    Ok((profile, begun, words))
}

/// The visit after that of a job, whose kit lies beside it, or after what was read out since.
fn again(
    files: &dyn Files,
    path: &Path,
    read_out: Option<&Path>,
    directory: &Path,
) -> Result<Beginning, Problems> {
    let named = JobFiles::of(files, &InputFile::read(files, path)?, UseOf::Tables)?;
    let (job, profile) = (&named.job, named.profile()?);
    let measured = match &job.measurement.data {
        MeasuredData::Diagonals(how) => {
            TableToFill::Readings(named.source(&how.readings, "measurement.readings")?.0)
        }
        MeasuredData::Errors(_) => {
            TableToFill::Errors(Box::new(errors(&named)?.table(job)?.into_owned()))
        }
    };
    let folder = named.folder;
    let kit = read_out.map_or_else(|| folder.join(KIT), Path::to_path_buf);
    let mut words = vec!["carried over as they stand: machine, control, box, uncertainty and protocol; compare them with the machine".to_string()];
    let held = read_out.map(|path| held(files, job, &profile, path, &mut words)).transpose()?;
    let (held, lacks_backlash) = held.unwrap_or_default();
    let is_kit = read_out.is_some() || files.is(PathEntry::File, &kit.join(MANIFEST));
    let place = ["first_table", "first_set"].into_iter();
    let place = place.rev().find(|place| profile.job_keys.iter().any(|key| key.key == *place));
    let name = printed(&kit);
    words.push(match (is_kit, place) {
        (false, _) => {
            format!("no kit in {name}: state in `active_while_measuring` what was loaded")
        }
        (true, Some(place)) => format!(
            "`{place}` decides whether the new tables replace those of {name} or lie beside them"
        ),
        (true, None) => format!("the new tables replace those of {name}"),
    });
    let kit = if is_kit { inside(&kit, directory) } else { String::new() };
    let mut keys = profile.job_keys.iter().filter(|_| lacks_backlash);
    let backlash = keys.find(|key| key.key == "active_backlash_um");
    let earlier = Earlier { job, measured, place, backlash, kit, held };
    let begun = earlier.again(|path| inside(&folder.join(path), directory))?;
    Ok((profile, begun, words))
}

/// What was read out of the control for keys of the job that state something else, and whether no file can hold a
/// backlash parameter; said are these keys, and whatever else contradicts the job.
fn held(
    files: &dyn Files,
    job: &Job,
    profile: &Profile,
    path: &Path,
    words: &mut Vec<String>,
) -> Result<(Vec<(String, String)>, bool), Problems> {
    let (name, names) = (printed(path), axis_names(job, profile)?);
    let key = |finding: &Finding| finding.kind().and_then(|kind: &InControl| kind.key(&names));
    let read = |job: &Job| {
        let help = "name a file or a directory read out of the control";
        let (_, found) = of_control(files, path, &name, help)?;
        from_read_out(job, profile, &name, found, ReadOutFor::Judging)
    };
    let ActiveControl { findings: mut found, held_backlash, .. } = read(job)?;
    // All else counts in the unit of the control.
    let is_unit = |of: &Finding| key(of).is_some_and(|(key, _)| key == "compensation.control_unit");
    if let Some(unit) = found.iter().find(|of| is_unit(of)).cloned() {
        let mut other = job.clone();
        let is_inch = job.compensation.control_unit == ControlUnit::Inch;
        other.compensation.control_unit = ControlUnit::of_metric(f64::from(u8::from(is_inch)));
        found = read(&other)?.findings;
        found.insert(0, unit);
    }
    let mut held: Vec<(String, String)> = Vec::new();
    for finding in &found {
        let key = key(finding);
        match key.filter(|new| held.iter().all(|(key, _)| *key != new.0)) {
            Some((key, value)) => {
                words.push(format!("from the read-out: `{key} = {value}`; {finding}"));
                held.push((key, value));
            }
            None if finding.severity() > Severity::Note => {
                words.push(format!("from the read-out: {finding}"));
            }
            None => {}
        }
    }
    Ok((held, held_backlash.is_empty()))
}

/// What a length was taken for: where an axis counts from elsewhere, every position would be another one.
fn travel_words(visit: &Visit<'_>) -> String {
    let ends = visit.travel.iter();
    let ends =
        ends.map(|(axis, (low, high))| format!("{axis} {} … {} mm", Figure(*low), Figure(*high)));
    format!(
        "travel in machine coordinates: {}; compare it with the machine (an axis that counts from another zero: `--travel` with LOW:HIGH)",
        joined(ends)
    )
}

/// What a person does, and the commands that follow it.
type Stage = (String, Vec<String>);

/// The whole visit.
fn stages(begun: &Begun, directory: &Path) -> Vec<Stage> {
    let place = |name: &str| shell_word(&directory.join(name));
    let [job, kit] = [JOB, KIT].map(place);
    let checklist = place(&format!("{KIT}/checklist.html"));
    let table = begun.measured;
    let tables = format!("{job} --tables {kit}");
    let after = format!("{tables} --after {}", place(begun.after()));
    let programs = begun.programs;
    let programs = programs.then(|| format!("nonius program {job} -o {}", place("programs")));
    let planned = [format!("nonius plan {job}")].into_iter().chain(programs);
    let separate = begun.readings.then(|| format!("nonius separate {job}"));
    let generate = format!("nonius generate {job} -o {kit}");
    let before = "before measuring: what the run will determine, its part programs".to_string();
    let again = if begun.readings { format!("{AFTER} and {AFTER_JOB}") } else { AFTER.to_string() };
    let before = begun.readings.then(|| (before, planned.collect()));
    let others = [
        (
            format!("measure, fill in {table} and the rest of {JOB}: files for the control"),
            separate.into_iter().chain([generate]).collect(),
        ),
        (
            format!("before loading, which {checklist} leads through"),
            vec![format!("nonius verify {tables}")],
        ),
        (
            format!(
                "measure again, fill in {again}: the residual errors, and the page to hand over"
            ),
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
    let is_path =
        controller.contains(['/', '\\']) || controller.to_ascii_lowercase().ends_with(".toml");
    if is_path { inside(Path::new(controller), directory) } else { controller.to_string() }
}

/// A path as it is named in `directory`.
fn inside(path: &Path, directory: &Path) -> String {
    let is_down = |part: Component<'_>| matches!(part, Component::Normal(_));
    if path.is_absolute() || !directory.components().all(is_down) {
        let absolute = std::path::absolute(path);
        return absolute.map_or_else(|_| with_slashes(path), |path| with_slashes(&path));
    }
    let pairs = path.components().zip(directory.components());
    let shared = pairs.take_while(|(one, other)| one == other).count();
    let up = directory.components().skip(shared).map(|_| "..".to_string());
    let down = path.components().skip(shared);
    let down = down.map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}
