//! `nonius simulate JOB -o readings.csv`

use crate::cli::outcome::{Outcome, Output, held, number};
use crate::cli::screen::{Screen, table};
use crate::cli::show;
use crate::control::controller::KitFile;
use crate::inputs::error_table;
use crate::inputs::job::UseOf;
use crate::kit::findings::InRehearsal;
use crate::kit::simulate::{
    Noise, Rehearsal, SIMULATED, SimulatedMachine, Simulation, SimulationSource, Wishes, readings,
    rehearsed, single_axes, write,
};
use crate::kit::{Inputs, Loaded, generate, hashed};
use crate::quantity::{Figure, PathKind};
use crate::text::{Finding, Problems};
use crate::visit::files::{Files, file_name};
use crate::visit::inputs::{self, read_directory};
use crate::visit::job_files::InputFile;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

// Options of `simulate`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true)))]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// The machine: an error table (CSV) in place of what the job measured, whose tables may be empty
    #[arg(long, value_name = "ERRORS")]
    machine: Option<PathBuf>,
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
    #[arg(long, value_name = "S", default_value_t = 0.0,
        value_parser = |text: &str| number(text, 0.0..=LARGEST_NOISE_UM, "µm"))]
    noise_um: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Growth of every scale since the measurement, µm/m (11.5 = steel, 1 K warmer)
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true,
        value_parser = |text: &str| number(text, -LARGEST_SCALE_UM_PER_M..=LARGEST_SCALE_UM_PER_M, "µm/m"))]
    scale_um_per_m: f64,
    #[command(flatten)]
    output: Output,
}

/// No laser on a machine is worse, µm.
const LARGEST_NOISE_UM: f64 = 100.0;
/// More than forty kelvin, µm/m.
const LARGEST_SCALE_UM_PER_M: f64 = 500.0;

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    options.output.ensure_new(files, "the readings")?;
    let (job, machine) = (InputFile::read(files, &options.job)?, options.machine.as_deref());
    let use_of = if options.without_tables { UseOf::Readings } else { UseOf::Tables };
    let inputs = inputs::read_job(files, machine, &job, use_of)?;
    let noise = Noise { um: options.noise_um, seed: options.seed };
    let wishes = Wishes {
        straight: options.straight,
        both_directions: options.both_directions,
        runs: options.runs,
        noise,
    };
    let rehearsal = if options.errors { None } else { Some(Rehearsal::of(&inputs, wishes)?) };
    let (loaded, mut origin) = tables(options, files, &inputs)?;
    origin.notes.extend(taken_for_granted(&inputs));
    origin.notes.extend(rehearsal.iter().flat_map(|rehearsal| rehearsal.notes.iter().cloned()));
    let machine = SimulatedMachine::new(&inputs, loaded.as_ref(), options.scale_um_per_m)?;
    let rehearsal = rehearsal.as_ref();
    let comments = origin.comments(&inputs, noise);
    let runs = rehearsal.map_or(options.runs.unwrap_or(1), |of| of.runs);
    let (text, what, positions, simulation) = match rehearsal {
        None => {
            let draft = single_axes(&machine, runs, noise, comments);
            let positions: usize = draft.series.iter().map(|s| s.positions.len()).sum();
            let what = format!(
                "error table of {} curves, {positions} positions, mean of {runs} run(s){}",
                draft.series.len(),
                noise_words(noise)
            );
            (error_table::write(&draft), what, Some(positions), None)
        }
        Some(rehearsal) => {
            let simulation = readings(&machine, rehearsal)?;
            let text = write(&simulation, rehearsal, &comments);
            (text, walked(rehearsal, &origin), None, Some(simulation))
        }
    };
    let simulation = simulation.as_ref();
    let document = Document {
        simulated: true,
        kind: rehearsal.map_or("single-axis", kind_word),
        steps: rehearsal.map(|of| of.measurement.volume.steps),
        runs,
        both_directions: rehearsal.map(|of| of.both_directions),
        overrun: rehearsal.map(|of| of.both_directions.then_some(of.overrun)),
        noise,
        origin: &origin,
        positions,
        simulation,
        notes: &origin.notes,
    };
    let figures = simulation.map_or_else(String::new, figures);
    let screen = || screen(&inputs, &origin, &what, figures);
    let document = || document;
    options.output.deliver(files, Some(held(text)), screen, document, &format!(" ({SIMULATED})"))
}

/// What scripts read: of diagonals, or of an error table.
#[derive(Serialize)]
struct Document<'a> {
    simulated: bool,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<usize>,
    runs: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    both_directions: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    overrun: Option<Option<bool>>,
    #[serde(flatten)]
    noise: Noise,
    #[serde(flatten)]
    origin: &'a SimulationSource,
    #[serde(skip_serializing_if = "Option::is_none")]
    positions: Option<usize>,
    #[serde(flatten)]
    simulation: Option<&'a Simulation>,
    notes: &'a [Finding],
}

/// The tables that are active, and where they come from.
fn tables<'a>(
    options: &Options,
    files: &dyn Files,
    inputs: &'a Inputs,
) -> Result<(Option<Loaded<'a>>, SimulationSource), Problems> {
    let hashes = |files: &[KitFile]| files.iter().map(|f| hashed(&f.path, &f.bytes)).collect();
    let (tables, table_files, loaded) = match &options.tables {
        _ if options.without_tables => ("without tables".to_string(), Vec::new(), None),
        None => {
            let kit = generate(inputs)?;
            let (words, files) = ("with the tables that generate makes from it", &kit.files);
            (words.to_string(), hashes(files), Some(rehearsed(inputs, files, None)?))
        }
        Some(directory) => {
            let found = read_directory(files, inputs, directory)?;
            let words = format!("with the tables in {}", file_name(directory));
            (words, hashes(&found.files), Some(found.rehearse(inputs)?))
        }
    };
    let notes = loaded.iter().flat_map(|loaded| loaded.findings.clone()).collect();
    let scale_um_per_m = options.scale_um_per_m;
    Ok((loaded, SimulationSource { tables, table_files, scale_um_per_m, notes }))
}

/// What the simulated machine inherits from the measurement it rests on.
fn taken_for_granted(inputs: &Inputs) -> Vec<Finding> {
    let doubts = inputs.model.doubts(|_| true).into_iter();
    let doubts = doubts.map(|doubt| InRehearsal::RestsOnDoubtful { doubt });
    let simulated = inputs.model.remarks.simulated().cloned();
    let simulated = simulated.map(|note| InRehearsal::RestsOnSimulated { note });
    doubts.chain(simulated).map(Finding::from).collect()
}

fn screen(inputs: &Inputs, origin: &SimulationSource, what: &str, figures: String) -> Screen {
    let not_in_it = "not in it: angular errors and repeatability of the machine, a tilted mirror, drift during the run (docs/visit.md §12)";
    let is_stated = inputs.job.source.place_of("compensation.controller");
    let control = is_stated.map_or_else(String::new, |_| format!(" - {}", inputs.profile.name));
    let doubts = taken_for_granted(inputs);
    let others = origin.notes.iter().filter(|note| !doubts.contains(note));
    Screen {
        figures,
        findings: show::notes(doubts.iter().chain(others)),
        always: vec![not_in_it.to_string()],
        ..Screen::of(format!(
            "{SIMULATED}: {}{control}, {}\n{what}",
            inputs.job.machine.name, origin.tables
        ))
    }
}

fn noise_words(noise: Noise) -> String {
    match noise.um > 0.0 {
        true => format!(", noise {} µm (k = 1, seed {})", noise.um, noise.seed),
        false => ", without noise".to_string(),
    }
}

const fn kind_word(rehearsal: &Rehearsal) -> &'static str {
    match rehearsal.measurement.kind {
        PathKind::Step => "step",
        PathKind::Straight => "straight",
    }
}

/// Which measurement was rehearsed.
fn walked(rehearsal: &Rehearsal, origin: &SimulationSource) -> String {
    let back = match (rehearsal.both_directions, rehearsal.overrun) {
        (false, _) => "forward only",
        (true, true) => "forward, and back after an overrun",
        (true, false) => "forward, and back from a turn without overrun",
    };
    let scale = match origin.scale_um_per_m.abs() > 0.0 {
        true => format!(", every scale {:+} µm/m", origin.scale_um_per_m),
        false => String::new(),
    };
    format!(
        "{} diagonals, {} steps, {} run(s), {back}{}{scale}",
        kind_word(rehearsal),
        rehearsal.measurement.volume.steps,
        rehearsal.runs,
        noise_words(rehearsal.noise)
    )
}

fn figures(simulation: &Simulation) -> String {
    let rows = simulation.diagonals.iter().map(|(d, of)| {
        let [end, end_read] = [of.end_um, of.read_end_um].map(Figure);
        let [range, range_read] = [of.range_um, of.read_range_um].map(Figure);
        format!("{d}\t{end:.3}\t{end_read:.3}\t{range:.3}\t{range_read:.3}")
    });
    let all = [simulation.range_over_all_um, simulation.read_range_over_all_um];
    let [all, all_read] = all.map(Figure);
    let all = format!("all\t\t\t{all:.3}\t{all_read:.3}");
    let heading = "diagonal\t>end/µm\t>end read/µm\t>max - min/µm\t>max - min read/µm";
    let legend = "end, max - min: of the nodes on the diagonal, without noise; read: with it, mean of the runs";
    format!("{}\n  {legend}", table(heading, rows.chain([all])))
}
