//! `nonius simulate JOB -o readings.csv`

use crate::cli::directory::read_directory;
use crate::cli::outcome::Outcome;
use crate::cli::show::{Column, paragraphs, table};
use crate::cli::{Format, inputs, write};
use crate::inputs::error_table;
use crate::kit::manifest::picometres;
use crate::kit::simulate::{
    Loaded, Noise, Origin, Rehearsal, SIMULATED, SimulatedMachine, Simulation, Wishes, readings,
    single_axes,
};
use crate::kit::{Inputs, generate, hashed};
use crate::quantity::diagonal::{Diagonal, PathKind};
use crate::read::KitFile;
use crate::text::problem::{Problem, Problems};
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

// Options of `simulate`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// The readings (CSV); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Directory with the control's files; without it those that `generate` makes from the job
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// The machine as it was measured, no table active
    #[arg(long, conflicts_with = "tables")]
    without_tables: bool,
    /// An error table instead: what single-axis measurements show at the measured positions
    #[arg(long, conflicts_with_all = ["straight", "both_directions"])]
    errors: bool,
    /// Straight runs (all axes together), also where the job measures in steps
    #[arg(long)]
    straight: bool,
    /// The way back too; a section [program] states it by itself
    #[arg(long)]
    both_directions: bool,
    /// Number of runs [default: as [program] states, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    runs: Option<u32>,
    /// Standard deviation of the noise of every reading, µm
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = noise_um)]
    noise_um: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Growth of every scale since the measurement, µm/m (11.5 = steel, 1 K warmer)
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true, value_parser = scale_um_per_m)]
    scale_um_per_m: f64,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

impl Options {
    fn noise(&self) -> Noise {
        Noise {
            um: self.noise_um,
            seed: self.seed,
        }
    }
}

/// No laser on a machine is worse: above it a unit was mistaken.
const LARGEST_NOISE_UM: f64 = 100.0;
/// More than forty kelvin: above it a unit was mistaken.
const LARGEST_SCALE_UM_PER_M: f64 = 500.0;

fn noise_um(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number
        .filter(|um| (0.0..=LARGEST_NOISE_UM).contains(um))
        .ok_or_else(|| format!("expected 0 … {LARGEST_NOISE_UM} µm"))
}

fn scale_um_per_m(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number
        .filter(|slope| slope.abs() <= LARGEST_SCALE_UM_PER_M)
        .ok_or_else(|| {
            format!("expected -{LARGEST_SCALE_UM_PER_M} … {LARGEST_SCALE_UM_PER_M} µm/m")
        })
}

/// What was simulated: the bytes of the file, and what is printed of it.
struct Simulated {
    bytes: Vec<u8>,
    text: String,
    document: Value,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let to_stdout = options.output == Path::new("-");
    if to_stdout && options.format == Format::Json {
        return Err(Problem::new(
            "the readings and the document cannot both go to standard output",
        )
        .help("name a file with `-o`, or leave `--format json` out")
        .into());
    }
    if !to_stdout {
        write::ensure_new(&options.output, options.force)?;
    }
    let simulated = simulated(options)?;
    if to_stdout {
        return Ok(Outcome::bytes(simulated.bytes).saying(simulated.text));
    }
    let ready = write::write_file(&options.output, &simulated.bytes, options.force)?;
    let wrote = format!("wrote {} ({SIMULATED})", options.output.display());
    let outcome = match options.format {
        Format::Text => Outcome::text(&simulated.text),
        Format::Json => Outcome::json(&simulated.document)?,
    };
    Ok(outcome.writing(ready).saying(wrote))
}

fn simulated(options: &Options) -> Result<Simulated, Problems> {
    let (inputs, angles) = inputs::read_with_angles(&options.job)?;
    let noise = options.noise();
    let wishes = Wishes {
        straight: options.straight,
        both_directions: options.both_directions,
        runs: options.runs,
        noise,
    };
    let rehearsal = match options.errors {
        true => None,
        false => Some(Rehearsal::of(&inputs.job, angles.as_ref(), wishes)?),
    };
    let (loaded, mut origin) = tables(options, &inputs)?;
    origin.notes.extend(taken_for_granted(&inputs));
    let machine = SimulatedMachine::new(&inputs, loaded.as_ref(), options.scale_um_per_m);
    let Some(rehearsal) = rehearsal else {
        return Ok(error_table(options, &inputs, &machine, &origin));
    };
    origin.notes.extend(rehearsal.notes.iter().cloned());
    let simulation = readings(&machine, &rehearsal, &inputs.job)?;
    let comments = origin.comments(&inputs, noise);
    Ok(Simulated {
        bytes: crate::kit::simulate::write(&simulation, &rehearsal, &comments).into_bytes(),
        text: text(&inputs, &rehearsal, &simulation, &origin),
        document: document(&rehearsal, &simulation, &origin),
    })
}

/// The tables that are active, and where they come from.
fn tables(options: &Options, inputs: &Inputs) -> Result<(Option<Loaded>, Origin), Problems> {
    let mut origin = Origin {
        tables: "without tables".to_string(),
        table_files: Vec::new(),
        scale_um_per_m: options.scale_um_per_m,
        notes: Vec::new(),
    };
    if options.without_tables {
        return Ok((None, origin));
    }
    let hashes = |files: &[KitFile<'_>]| files.iter().map(|f| hashed(f.path, f.bytes)).collect();
    let loaded = match &options.tables {
        None => {
            let kit = generate(inputs)?;
            origin.table_files = hashes(&kit.kit_files());
            origin.tables = "with the tables that generate makes from it".to_string();
            Loaded::read(inputs, &kit.kit_files(), None)?
        }
        Some(directory) => {
            let found = read_directory(inputs, directory)?;
            origin.table_files = hashes(&found.kit_files());
            let loaded = match found.read_out(inputs, directory)? {
                Some(active) => Loaded::read_out(inputs, &active)?,
                None => Loaded::read(inputs, &found.kit_files(), found.state.as_ref())
                    .map_err(|problems| found.instead_of(problems))?,
            };
            origin.tables = format!("with the tables in {}", inputs::file_name(directory));
            origin.notes.extend(found.remarks);
            origin.notes.extend(found.notes);
            loaded
        }
    };
    origin.notes.extend(loaded.notes.iter().cloned());
    Ok((Some(loaded), origin))
}

/// What the simulated machine inherits from the measurement it rests on.
fn taken_for_granted(inputs: &Inputs) -> Vec<String> {
    let doubts = inputs.model.doubts(|_| true);
    let doubts = doubts
        .into_iter()
        .map(|doubt| format!("the errors it rests on are doubtful: {doubt}"));
    let simulated = inputs.model.remarks.simulated();
    doubts
        .chain(simulated.map(|note| format!("the errors it rests on are {note}")))
        .collect()
}

fn error_table(
    options: &Options,
    inputs: &Inputs,
    machine: &SimulatedMachine<'_>,
    origin: &Origin,
) -> Simulated {
    let noise = options.noise();
    let runs = options.runs.unwrap_or(1);
    let draft = single_axes(machine, runs, noise, origin.comments(inputs, noise));
    let rows: usize = draft.series.iter().map(|s| s.positions_mm.len()).sum();
    let heading = heading(inputs, origin);
    let what = format!(
        "error table of {} curves, {rows} positions, mean of {runs} run(s){}",
        draft.series.len(),
        noise_words(noise)
    );
    Simulated {
        bytes: error_table::write(&draft).into_bytes(),
        text: paragraphs(&[heading, what, notes(origin)]),
        document: json!({
            "schema": 1,
            "simulated": true,
            "kind": "single-axis",
            "runs": runs,
            "noise_um": noise.um,
            "seed": noise.seed,
            "scale_um_per_m": origin.scale_um_per_m,
            "tables": origin.tables,
            "table_files": origin.table_files,
            "positions": rows,
            "notes": origin.notes,
        }),
    }
}

fn heading(inputs: &Inputs, origin: &Origin) -> String {
    format!(
        "{SIMULATED}: {} - {}, {}",
        inputs.job.machine.name, inputs.profile.name, origin.tables
    )
}

fn noise_words(noise: Noise) -> String {
    if noise.um > 0.0 {
        format!(", noise {} µm (k = 1, seed {})", noise.um, noise.seed)
    } else {
        ", without noise".to_string()
    }
}

fn notes(origin: &Origin) -> String {
    let mut lines: Vec<String> = origin.notes.iter().map(|n| format!("note: {n}")).collect();
    lines.push("not in it: angular errors and repeatability of the machine, a tilted mirror, drift during the run (docs/rehearsal.md)".to_string());
    lines.join("\n")
}

const fn kind_word(rehearsal: &Rehearsal) -> &'static str {
    match rehearsal.kind {
        PathKind::Step => "step",
        PathKind::Straight => "straight",
    }
}

fn text(
    inputs: &Inputs,
    rehearsal: &Rehearsal,
    simulation: &Simulation,
    origin: &Origin,
) -> String {
    let back = match (rehearsal.both_directions, rehearsal.overrun) {
        (false, _) => "forward only",
        (true, true) => "forward, and back after an overrun",
        (true, false) => "forward, and back from a turn without overrun",
    };
    let scale = if origin.scale_um_per_m.abs() > 0.0 {
        format!(", every scale {:+} µm/m", origin.scale_um_per_m)
    } else {
        String::new()
    };
    let walked = format!(
        "{} diagonals, {} steps, {} run(s), {back}{}{scale}",
        kind_word(rehearsal),
        rehearsal.volume.steps,
        rehearsal.runs,
        noise_words(rehearsal.noise)
    );
    let legend = "end, max - min: of the nodes on the diagonal, without noise; read: with it, mean of the runs";
    paragraphs(&[
        heading(inputs, origin),
        walked,
        format!("{}\n  {legend}", figures(simulation)),
        notes(origin),
    ])
}

fn figures(simulation: &Simulation) -> String {
    let columns = [
        Column::Left("diagonal"),
        Column::Right("end/µm"),
        Column::Right("end read/µm"),
        Column::Right("max - min/µm"),
        Column::Right("max - min read/µm"),
    ];
    let three = |um: f64| format!("{:.3}", (um * 1e3).round() / 1e3 + 0.0);
    let rows = Diagonal::ALL.into_iter().map(|d| {
        let (predicted, read) = (simulation.predicted[d], simulation.read[d]);
        vec![
            d.to_string(),
            three(predicted.end_um),
            three(read.end_um),
            three(predicted.range_um),
            three(read.range_um),
        ]
    });
    let all = vec![
        "all".to_string(),
        String::new(),
        String::new(),
        three(simulation.predicted_over_all_um),
        three(simulation.read_over_all_um),
    ];
    table(&columns, rows.chain([all]))
}

fn document(rehearsal: &Rehearsal, simulation: &Simulation, origin: &Origin) -> Value {
    let mut diagonals = Map::new();
    for d in Diagonal::ALL {
        let (predicted, read) = (simulation.predicted[d], simulation.read[d]);
        diagonals.insert(
            d.to_string(),
            json!({
                "end_um": picometres(predicted.end_um),
                "range_um": picometres(predicted.range_um),
                "read_end_um": picometres(read.end_um),
                "read_range_um": picometres(read.range_um),
            }),
        );
    }
    json!({
        "schema": 1,
        "simulated": true,
        "kind": kind_word(rehearsal),
        "steps": rehearsal.volume.steps,
        "runs": rehearsal.runs,
        "both_directions": rehearsal.both_directions,
        "overrun": rehearsal.both_directions.then_some(rehearsal.overrun),
        "noise_um": rehearsal.noise.um,
        "seed": rehearsal.noise.seed,
        "scale_um_per_m": origin.scale_um_per_m,
        "tables": origin.tables,
        "table_files": origin.table_files,
        "diagonals": diagonals,
        "range_over_all_um": picometres(simulation.predicted_over_all_um),
        "read_range_over_all_um": picometres(simulation.read_over_all_um),
        "notes": origin.notes,
    })
}
