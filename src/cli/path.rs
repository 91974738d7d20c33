//! `nonius path JOB PROGRAM`

mod points;
mod program_text;
mod show_path;

use crate::assessment::with_tables;
use crate::cli::verify::read_directory;
use crate::cli::{Answer, Format, inputs, print, print_json, say, write};
use crate::job::UseOf;
use crate::kit::{Inputs, LoadedControl, load};
use crate::nc::{Ran, run as run_program};
use crate::problem::{Problem, Problems};
use crate::space::cloud::longest;
use crate::tool_path::{PathMap, Profile, Summary, limits, path_map, setup};
use crate::volume_model::VolumeModel;
use clap::Args;
use points::Points;
use program_text::ProgramText;
use std::path::PathBuf;

/// Options of `path`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML)
    job: PathBuf,
    /// The part program; `-` = standard input
    program: PathBuf,
    /// Also write the error at every sample to this file (CSV)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "output")]
    force: bool,
    /// Also as the files of this directory leave the machine
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// The path on one machine.
struct Followed {
    summary: Summary,
    /// Largest difference of two error vectors of the samples, µm.
    accuracy_um: f64,
}

/// What is printed.
struct Page {
    program: String,
    inputs: Inputs,
    volume: VolumeModel,
    ran: Ran,
    before: Followed,
    /// With the tables, and how these differ from what the job asks for.
    after: Option<(String, Followed, Vec<String>)>,
}

/// The machine with tables.
struct WithTables {
    from: String,
    map: PathMap,
    volume: VolumeModel,
    disagreements: Vec<String>,
}

pub(super) fn run(options: &Options) -> Result<Answer, Problems> {
    if let Some(file) = &options.output {
        write::ensure_new(file, options.force)?;
    }
    let page = page(options)?;
    match options.format {
        Format::Json => print_json(&show_path::document(&page))?,
        Format::Text => print(&show_path::text(&page))?,
    };
    if let Some(file) = &options.output {
        say(&format!(
            "wrote {} ({} samples)",
            file.display(),
            page.before.summary.samples
        ));
    }
    Ok(Answer::Yes)
}

fn page(options: &Options) -> Result<Page, Problems> {
    let use_of = UseOf::with(options.tables.is_some());
    let inputs = inputs::read_for(&options.job, use_of)?;
    let volume = VolumeModel::build(&inputs.job, inputs.as_measured())?;
    let map = map_of(&inputs, &volume)?;
    let tables = match &options.tables {
        Some(directory) => Some(with_files(&inputs, &volume, directory)?),
        None => None,
    };
    let mut text = ProgramText::open(&options.program)?;
    let program = text.name().to_string();
    let setup = setup(&inputs.job);
    let mut before = Profile::new(&map, limits(&inputs.job, &volume));
    let mut after = tables
        .as_ref()
        .map(|t| Profile::new(&t.map, limits(&inputs.job, &t.volume)));
    let after_map = tables.as_ref().map(|t| &t.map);
    let mut points = match &options.output {
        Some(file) => Some(Points::create(file, after_map.is_some())?),
        None => None,
    };
    let ran = run_program(&mut text, &program, &setup, |step| {
        before.follow(step, &mut |sample| {
            if let Some(points) = &mut points {
                points.write(sample, after_map);
            }
        })?;
        match &mut after {
            Some(after) => after.follow(step, &mut |_| {}),
            None => Ok(()),
        }
    })?;
    let before = followed(before, &program)?;
    let after = match (after, &tables) {
        (Some(after), Some(tables)) => Some((
            tables.from.clone(),
            followed(after, &program)?,
            tables.disagreements.clone(),
        )),
        _ => None,
    };
    if let Some(points) = points {
        points.finish(options.force)?;
    }
    Ok(Page {
        program,
        inputs,
        volume,
        ran,
        before,
        after,
    })
}

fn map_of(inputs: &Inputs, volume: &VolumeModel) -> Result<PathMap, Problem> {
    path_map(&inputs.job, volume).ok_or_else(|| {
        Problem::new(
            "the error curves have no ascending positions, so no error can be told along a path",
        )
    })
}

fn with_files(
    inputs: &Inputs,
    volume: &VolumeModel,
    directory: &std::path::Path,
) -> Result<WithTables, Problems> {
    let found = read_directory(inputs, directory)?;
    let LoadedControl {
        plan,
        control,
        mut disagreements,
    } = load(inputs, &found.kit_files(), found.state.as_ref())?;
    disagreements.extend(found.remarks);
    let volume = with_tables(volume, &inputs.model, &plan, control.as_ref()).map_err(|e| {
        Problem::new(format!("the tables cannot be emulated: {}", e.0))
            .help("nothing can be said of the machine with them")
    })?;
    Ok(WithTables {
        from: format!("the files of {}", directory.display()),
        map: map_of(inputs, &volume)?,
        volume,
        disagreements,
    })
}

fn followed(profile: Profile<'_>, program: &str) -> Result<Followed, Problem> {
    let summary = profile.summary();
    let Some(found) = longest(&summary.vectors) else {
        let message = format!("`{program}` holds no move that counts");
        return Err(Problem::new(message)
            .help("G1, G2, G3 and the feed moves of cycles count; with `moves = \"all\"` in [path] rapid moves too"));
    };
    Ok(Followed {
        accuracy_um: found.um(),
        summary,
    })
}
