//! `nonius path JOB PROGRAM`

mod document;
mod holes;
mod points;
mod program_text;
mod show_path;

use crate::cli::corrected::AskedTables;
use crate::cli::outcome::Outcome;
use crate::cli::{Format, inputs, write};
use crate::inputs::nc::{Ran, run as run_program};
use crate::kit::Inputs;
use crate::text::problem::{Problem, Problems};
use crate::volume::space::cloud::longest;
use crate::volume::tool_path::{PathMap, Profile, Summary, limits, path_map};
use crate::volume::volume_model::VolumeModel;
use clap::Args;
use holes::Holes;
use points::Points;
use program_text::ProgramText;
use std::path::{Path, PathBuf};

// Options of `path`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML)
    job: PathBuf,
    /// The part program; `-` = standard input
    program: PathBuf,
    /// Also write the error at every sample to this file (CSV); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "output")]
    force: bool,
    #[command(flatten)]
    tables: AskedTables,
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
    after: Option<After>,
    holes: Holes,
}

/// The path with tables.
struct After {
    /// Where they come from.
    from: String,
    followed: Followed,
    /// How they differ from what the job asks for.
    disagreements: Vec<String>,
    /// What no file does, what was passed over, and what is taken for granted.
    notes: Vec<String>,
}

impl Options {
    /// The file of the samples; `None` = none, or standard output.
    fn file(&self) -> Option<&Path> {
        self.output.as_deref().filter(|_| !self.to_stdout())
    }

    fn to_stdout(&self) -> bool {
        self.output.as_deref() == Some(Path::new("-"))
    }

    fn refuse_doubles(&self) -> Result<(), Problem> {
        if self.to_stdout() && self.format == Format::Json {
            return Err(Problem::new(
                "the samples and the summary cannot both go to standard output",
            )
            .help("name a file with `-o`, or leave `--format json` out"));
        }
        if self.job == Path::new("-") && self.program == Path::new("-") {
            return Err(Problem::new(
                "the job and the program cannot both come from standard input",
            )
            .help("name a file for one of them"));
        }
        Ok(())
    }
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    options.refuse_doubles()?;
    if let Some(file) = options.file() {
        write::ensure_new(file, options.force)?;
    }
    let (page, points) = page(options)?;
    let shown = || match options.format {
        Format::Json => Outcome::json(&document::document(&page)),
        Format::Text => Ok(Outcome::text(&show_path::text(&page))),
    };
    match (points, options.file()) {
        (None, _) => shown(),
        (Some(points), None) => Ok(Outcome::file(points.printed()?).saying(show_path::text(&page))),
        (Some(points), Some(file)) => {
            let samples = page.before.summary.samples;
            let wrote = format!("wrote {} ({samples} samples)", file.display());
            Ok(shown()?.writing(points.written()?).saying(wrote))
        }
    }
}

/// The page, and the samples where a file of them is asked for.
fn page(options: &Options) -> Result<(Page, Option<Points>), Problems> {
    let inputs = inputs::read_for(&options.job, options.tables.use_of())?;
    let volume = VolumeModel::build(&inputs.job, inputs.as_measured())?;
    let map = map_of(&inputs, &volume)?;
    let tables = options.tables.corrected(&inputs, &volume)?;
    let after_map = tables.as_ref().map(|t| map_of(&inputs, &t.volume));
    let after_map = after_map.transpose()?;
    let after_map = after_map.as_ref();
    let mut text = ProgramText::open(&options.program)?;
    let program = text.name().to_string();
    let mut before = Profile::new(&map, limits(&inputs.job, &volume));
    let with_map = tables.as_ref().zip(after_map);
    let mut after = with_map.map(|(t, map)| Profile::new(map, limits(&inputs.job, &t.volume)));
    let mut points = match &options.output {
        Some(_) => Some(Points::create(
            options.file(),
            after_map.is_some(),
            options.force,
        )?),
        None => None,
    };
    let mut holes = Holes::default();
    let ran = run_program(&mut text, &program, &inputs.job.path.setup, |step| {
        before.follow(step, &mut |sample| {
            holes.take(sample, after_map);
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
        (Some(after), Some(tables)) => Some(After {
            followed: followed(after, &program)?,
            from: tables.from.clone(),
            disagreements: tables.disagreements.clone(),
            notes: tables.notes.clone(),
        }),
        _ => None,
    };
    let page = Page {
        program,
        inputs,
        volume,
        ran,
        before,
        after,
        holes,
    };
    Ok((page, points))
}

fn map_of(inputs: &Inputs, volume: &VolumeModel) -> Result<PathMap, Problem> {
    path_map(&inputs.job, volume).ok_or_else(|| {
        Problem::new(
            "the error curves have no ascending positions, so no error can be told along a path",
        )
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
