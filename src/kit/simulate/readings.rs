//! Errors that are left → readings along the laser, node by node, as the CSV of contract §2.2 with where they come from;
//! or an error table at the positions where each error was measured.

use super::{Noise, Rehearsal, SIMULATED, SimulatedMachine, written};
use crate::inputs::error_table::{Draft, Series};
use crate::inputs::job::{Job, MeasuredData};
use crate::judge::after::{not_known, outside};
use crate::kit::Inputs;
use crate::kit::manifest::HashedFile;
use crate::machine::model::Measured;
use crate::machine::separation::corrections::{REFERENCE_C, expansion_um};
use crate::machine::separation::readings::{DiagonalFigures, figures};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run};
use crate::quantity::units::{Deviation, Figure, Millimetres, SAME_PLACE_MM, Squared};
use crate::text::document::MOST_LINES;
use crate::text::finding::Finding;
use crate::text::plain;
use crate::text::problem::{Problem, Problems};
use crate::write::emit::TOOL;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Simulated readings.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Every run, as an instrument would hand it over (but for `laser_sign`).
    pub runs: Vec<Run>,
    /// Figures of every diagonal as predicted, without noise.
    pub predicted: PerDiagonal<DiagonalFigures>,
    /// Max − min over all diagonals as predicted, µm.
    pub predicted_over_all_um: f64,
    /// The same figures of the readings with their noise, means of the runs.
    pub read: PerDiagonal<DiagonalFigures>,
    /// Max − min over all diagonals of the readings, µm.
    pub read_over_all_um: f64,
}

/// Readings of a pass by node, zero at the forward start, µm; the return pass where it is measured.
type Passes = (Vec<f64>, Option<Vec<f64>>);

/// Lines of the file beside its readings: some for each input and each note.
const MOST_COMMENTS: usize = 1000;

/// No file of readings is written that would be refused when it is read.
fn check_rows(rehearsal: &Rehearsal, problems: &mut Problems) {
    let nodes = rehearsal.volume.last_node(rehearsal.kind) + 1;
    let runs = usize::try_from(rehearsal.runs).unwrap_or(usize::MAX);
    let passes = Diagonal::ALL.len() * (1 + usize::from(rehearsal.both_directions));
    let rows = nodes.saturating_mul(passes).saturating_mul(runs);
    let most = MOST_LINES - MOST_COMMENTS;
    if rows > most {
        let message = format!("there would be {rows} readings, expected at most {most}");
        problems.push(Problem::new(message).help("fewer runs, or fewer steps"));
    }
}

/// Predicts the readings. Refused where an error is not measured, or not everywhere in the box.
pub fn readings(
    machine: &SimulatedMachine<'_>,
    rehearsal: &Rehearsal,
    job: &Job,
) -> Result<Simulation, Problems> {
    let mut problems = Problems::none();
    check_measured(machine, rehearsal, job, &mut problems);
    check_rows(rehearsal, &mut problems);
    problems.or_ok(())?;
    let mut exact = Vec::new();
    let mut runs = Vec::new();
    for (index, diagonal) in Diagonal::ALL.into_iter().enumerate() {
        let Some(passes) = passes(machine, rehearsal, diagonal) else {
            continue; // every term was found to be measured
        };
        exact.extend(as_runs(rehearsal, diagonal, 1, &passes));
        runs.extend(noisy_runs(rehearsal, diagonal, index, &passes));
    }
    let (predicted, predicted_over_all_um) = figures(&exact, rehearsal.kind);
    let (read, read_over_all_um) = figures(&runs, rehearsal.kind);
    for run in &mut runs {
        add_expansion(rehearsal, run);
    }
    Ok(Simulation { runs, predicted, predicted_over_all_um, read, read_over_all_um })
}

fn passes(
    machine: &SimulatedMachine<'_>,
    rehearsal: &Rehearsal,
    diagonal: Diagonal,
) -> Option<Passes> {
    let walked = |pass: Pass| {
        let error = |node: usize| error_at(machine, rehearsal, diagonal, pass, node);
        rehearsal.volume.along_beam(diagonal, rehearsal.kind, error)
    };
    let forward = walked(Pass::Forward)?;
    let zero = *forward.first()?;
    let read = |pass: Pass, along: Vec<f64>| -> Vec<f64> {
        let angles = rehearsal.angles.as_ref();
        let angles = angles.and_then(|a| a.of(diagonal, pass));
        let effect = |node: usize| angles.and_then(|a| a.get(node).copied()).unwrap_or(0.0);
        let nodes = along.into_iter().enumerate();
        nodes.map(|(node, um)| um - zero + effect(node)).collect()
    };
    let back = match rehearsal.both_directions {
        true => Some(read(Pass::Reverse, walked(Pass::Reverse)?)),
        false => None,
    };
    Some((read(Pass::Forward, forward), back))
}

/// The error of the tool at a node, µm, each term in the direction in which its axis arrived.
fn error_at(
    machine: &SimulatedMachine<'_>,
    rehearsal: &Rehearsal,
    diagonal: Diagonal,
    pass: Pass,
    node: usize,
) -> Option<PerAxis<f64>> {
    let place = rehearsal.volume.place(diagonal, rehearsal.kind, node);
    let mut error = PerAxis::default();
    for term in ErrorTerm::ALL {
        let direction = rehearsal.arrived(diagonal, pass, node, term.along);
        error[term.of] += machine.left_um(term, direction, place[term.along])?;
    }
    Some(error)
}

fn as_runs(rehearsal: &Rehearsal, diagonal: Diagonal, number: u32, passes: &Passes) -> Vec<Run> {
    let recorded = rehearsal.recorded();
    let run = |pass: Pass, readings: &Vec<f64>| Run {
        diagonal,
        number,
        pass,
        deviations: readings.iter().copied().map(Deviation::from_um).collect(),
        temperatures_c: PerAxis::from_fn(|axis| {
            recorded[axis].then(|| vec![REFERENCE_C; readings.len()])
        }),
    };
    let back = passes.1.iter().map(|back| run(Pass::Reverse, back));
    std::iter::once(run(Pass::Forward, &passes.0)).chain(back).collect()
}

/// The runs of a diagonal. Each draws from a stream of its own, so that more runs or the return pass
/// change nothing of the others. The instrument is zeroed once, at the start of the first run.
fn noisy_runs(
    rehearsal: &Rehearsal,
    diagonal: Diagonal,
    index: usize,
    passes: &Passes,
) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut zero_um = None;
    for number in 1..=rehearsal.runs {
        let mut random = ChaCha8Rng::seed_from_u64(rehearsal.noise.seed);
        let stream = u64::from(number - 1) * Diagonal::ALL.len() as u64 + index as u64;
        random.set_stream(stream);
        let mut noisy = |readings: &Vec<f64>| -> Vec<f64> {
            let mut read = Vec::new();
            for um in readings {
                let draw: f64 = StandardNormal.sample(&mut random);
                let off = rehearsal.noise.um * draw;
                read.push(um + off - *zero_um.get_or_insert(off));
            }
            read
        };
        let forward = noisy(&passes.0);
        let back = passes.1.as_ref().map(&mut noisy);
        runs.extend(as_runs(rehearsal, diagonal, number, &(forward, back)));
    }
    runs
}

/// Adds the expansion that the job takes off again, and rounds to the digits of a file.
fn add_expansion(rehearsal: &Rehearsal, run: &mut Run) {
    let material = rehearsal.material.filter(|m| !m.material_corrected);
    let expansion = |node: usize| {
        material.map_or(0.0, |material| {
            expansion_um(&rehearsal.volume, rehearsal.kind, &material, run, node)
        })
    };
    let nodes = run.deviations.iter().enumerate();
    let read = nodes.map(|(node, um)| Deviation::from_um(written(um.um() + expansion(node))));
    run.deviations = read.collect();
}

/// Notes errors that are not measured, or not in a direction in which a pass moves, or not all over the
/// box: nothing is extrapolated.
fn check_measured(
    machine: &SimulatedMachine<'_>,
    rehearsal: &Rehearsal,
    job: &Job,
    problems: &mut Problems,
) {
    let key = match job.measurement.data {
        MeasuredData::Errors(_) => "measurement.errors",
        MeasuredData::Diagonals(_) => "measurement.readings",
    };
    for words in not_known(machine.model, |_, _| true) {
        let problem = job.problem_at(key, words);
        problems.push(problem.help("measure them, or predict what was measured with `--errors`"));
    }
    let key = match (&job.measurement.data, &job.program) {
        (MeasuredData::Errors(_), Some(program)) => program.size_path,
        _ => "measurement.step_diagonal.size_mm",
    };
    for words in outside(machine.model, &rehearsal.volume) {
        let problem = job.problem_at(key, words);
        problems
            .push(problem.help("keep the box inside the measured range: nothing is extrapolated"));
    }
}

/// The errors that single-axis measurements would show, mean of `runs`; relative to the
/// reference. With noise the table states it as uncertainty (k = 1), less what its job states for every value
/// (`noise_um`), in squares.
pub fn single_axes(
    machine: &SimulatedMachine<'_>,
    runs: u32,
    (noise, stated_um): (Noise, Option<f64>),
    comments: Vec<String>,
) -> Draft {
    let mut series = Vec::new();
    for axis in Axis::ALL {
        for direction in directions(machine, axis) {
            let stream = series.len() as u64;
            let noise = OneSeries::new(runs, noise, stream, stated_um.unwrap_or(0.0));
            series.push(one_series(machine, axis, direction, noise));
        }
    }
    Draft { comments, series }
}

/// The directions that an axis has rows for; `None` = both alike.
fn directions(machine: &SimulatedMachine<'_>, axis: Axis) -> Vec<Option<Direction>> {
    let terms = machine.model.measured();
    let mut measured = terms.filter(|(term, _)| term.along == axis).peekable();
    if measured.peek().is_none() || machine.model.ranges[axis].is_none() {
        return Vec::new();
    }
    let one_way = measured.find_map(|(_, term)| match term.measured {
        Measured::OneWay(direction, _) => Some(direction),
        _ => None,
    });
    match one_way {
        Some(direction) => vec![Some(direction)],
        None if machine.is_directed(axis) => Direction::BOTH.map(Some).into(),
        None => vec![None],
    }
}

/// The noise of one series.
struct OneSeries {
    random: ChaCha8Rng,
    /// Standard deviation of a mean over the runs, µm.
    u_um: f64,
    /// What the columns state of it, beside `noise_um` of the job, µm.
    column_um: f64,
}

impl OneSeries {
    fn new(runs: u32, noise: Noise, stream: u64, stated_um: f64) -> OneSeries {
        let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
        random.set_stream(stream);
        let u_um = noise.um / f64::from(runs).sqrt();
        let more = u_um.squared() - stated_um.squared();
        OneSeries { random, u_um, column_um: more.max(0.0).sqrt() }
    }

    fn draw(&mut self) -> f64 {
        let draw: f64 = StandardNormal.sample(&mut self.random);
        self.u_um * draw
    }
}

fn one_series(
    machine: &SimulatedMachine<'_>,
    axis: Axis,
    direction: Option<Direction>,
    mut noise: OneSeries,
) -> Series {
    let positions = positions(machine, axis);
    let moving = direction.unwrap_or(Direction::Plus);
    let mut series = Series::new(axis, direction, positions.clone());
    series.deviations = PerAxis::from_fn(|of| {
        let term = ErrorTerm { of, along: axis };
        let at = |position: &Millimetres| machine.left_um(term, moving, *position);
        let left: Option<Vec<f64>> = positions.iter().map(at).collect();
        let noisy = |um: f64| Deviation::from_um(written(um + noise.draw()));
        Some(left?.into_iter().map(noisy).collect())
    });
    if noise.column_um > 0.0 {
        let stated = |known: &Vec<Deviation>| vec![noise.column_um; known.len()];
        series.uncertainties_um = PerAxis::from_fn(|of| series.deviations[of].as_ref().map(stated));
    }
    series
}

/// Positions at which any error of an axis was measured, inside the range of all of them.
fn positions(machine: &SimulatedMachine<'_>, axis: Axis) -> Vec<Millimetres> {
    let Some((low, high)) = machine.model.ranges[axis] else {
        return Vec::new();
    };
    let terms = machine.model.measured();
    let mut positions: Vec<Millimetres> = terms
        .filter(|(term, _)| term.along == axis)
        .flat_map(|(_, measured)| measured.curves().flat_map(|curve| curve.knots().to_vec()))
        .filter(|knot| (low.mm()..=high.mm()).contains(&knot.mm()))
        .collect();
    positions.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
    positions.dedup_by(|a, b| (a.mm() - b.mm()).abs() < SAME_PLACE_MM);
    positions
}

/// Where a simulation comes from, for the comments of its file.
#[derive(Clone, Debug)]
pub struct SimulationSource {
    /// The tables that were active, in words.
    pub tables: String,
    /// The files that hold them.
    pub table_files: Vec<HashedFile>,
    /// By how much every scale has grown, µm/m.
    pub scale_um_per_m: f64,
    /// What was taken for granted.
    pub notes: Vec<Finding>,
}

impl SimulationSource {
    /// The comment lines of a file, without their `#`. Notes are read again
    /// ([`crate::inputs::error_table::Remarks`]) and reach whatever is made from the file.
    pub fn comments(&self, inputs: &Inputs, noise: super::Noise) -> Vec<String> {
        let job = inputs.hashes.first();
        let (name, sha256) = job.map_or(("-", "-"), |job| (&job.path, &job.sha256));
        let mut lines = vec![format!(
            "note: {SIMULATED}: predicted by {TOOL} from {name} sha256 {sha256}, {}",
            self.tables
        )];
        let sources = inputs.hashes.iter().skip(1);
        lines.extend(
            sources.map(|file| format!("predicted from: {} sha256 {}", file.path, file.sha256)),
        );
        let tables = self.table_files.iter();
        lines.extend(tables.map(|file| format!("table: {} sha256 {}", file.path, file.sha256)));
        lines.push(format!(
            "noise {} um (seed {}), change of scale {} um/m",
            noise.um, noise.seed, self.scale_um_per_m
        ));
        lines.extend(self.notes.iter().map(|words| format!("note: {words}")));
        lines
    }
}

/// The file of the readings.
pub fn write(simulation: &Simulation, rehearsal: &Rehearsal, comments: &[String]) -> String {
    let recorded = rehearsal.recorded();
    let recorded = recorded.iter().filter(|(_, is_recorded)| **is_recorded);
    let recorded: String = recorded.map(|(axis, _)| format!(",t_{}_c", axis.key())).collect();
    let moved = if rehearsal.kind == PathKind::Step { ",moved" } else { "" };
    let header = format!("diagonal,run,direction,node{moved},deviation_um{recorded}");
    let rows = simulation.runs.iter().flat_map(|run| rows(run, rehearsal));
    let comments = comments.iter().map(|comment| plain::comment(comment));
    comments.chain([header]).chain(rows).map(|line| line + "\n").collect()
}

/// The rows of a run in the order in which they are measured.
fn rows(run: &Run, rehearsal: &Rehearsal) -> Vec<String> {
    let nodes = 0..run.deviations.len();
    let mut rows: Vec<String> = nodes.map(|node| row(run, node, rehearsal)).collect();
    if run.pass == Pass::Reverse {
        rows.reverse();
    }
    rows
}

fn row(run: &Run, node: usize, rehearsal: &Rehearsal) -> String {
    let um = run.deviations[node].um();
    let um = Figure(match rehearsal.laser_sign {
        Direction::Plus => um,
        Direction::Minus => 0.0 - um,
    });
    let moved = match (rehearsal.kind, node) {
        (PathKind::Straight, _) => String::new(),
        (PathKind::Step, 0) => ",".to_string(),
        (PathKind::Step, node) => format!(",{}", rehearsal.volume.moved(node).key()),
    };
    let celsius = run.temperatures_c.iter();
    let celsius = celsius.filter_map(|(_, t)| Some(format!(",{}", t.as_ref()?.get(node)?)));
    let (celsius, pass): (String, _) = (celsius.collect(), run.pass.word());
    format!("{},{},{pass},{node}{moved},{um}{celsius}", run.diagonal, run.number)
}
