//! Errors that are left → readings along the laser, node by node.

use super::{Rehearsal, SimulatedMachine, written};
use crate::inputs::job::{Job, MeasuredData};
use crate::judge::after::{not_known, outside};
use crate::machine::separation::corrections::{REFERENCE_C, expansion_um};
use crate::machine::separation::readings::{CorrectedRun, DiagonalFigures, figures};
use crate::quantity::axis::{ErrorTerm, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Run};
use crate::quantity::units::Deviation;
use crate::text::document::MOST_LINES;
use crate::text::problem::{Problem, Problems};
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
    let of = |runs: &[Run]| {
        figures(&runs.iter().map(CorrectedRun::from).collect::<Vec<_>>(), rehearsal.kind)
    };
    let (predicted, predicted_over_all_um) = of(&exact);
    let (read, read_over_all_um) = of(&runs);
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
