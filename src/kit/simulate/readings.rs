//! Errors that are left → readings along the laser, node by node, as the CSV of contract §2.2 with where they come from;
//! or an error table at the positions where each error was measured.

use super::{Noise, Rehearsal, SIMULATED, SimulatedMachine, written};
use crate::inputs::error_table::{Draft, Kind, Series};
use crate::inputs::job::{DiagonalMeasurement, MeasuredData};
use crate::judge::active::HashedFile;
use crate::judge::after::{not_known, outside};
use crate::kit::Inputs;
use crate::kit::refusals;
use crate::machine::model::TermCurves;
use crate::machine::separation::corrections::{REFERENCE_C, expansion_um};
use crate::machine::separation::readings::{DiagonalFigures, figures};
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Figure, Millimetres, Pass, PathKind, PerAxis,
    PerDiagonal, Run, SAME_PLACE_MM, Squared,
};
use crate::text::{Finding, MOST_LINES, Problems, plain};
use crate::write::emit::TOOL;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

/// Simulated readings.
#[derive(Clone, Debug, Serialize)]
pub struct Simulation {
    /// Every run, as an instrument would hand it over (but for `laser_sign`).
    #[serde(skip)]
    pub runs: Vec<Run>,
    /// Figures of every diagonal.
    pub diagonals: PerDiagonal<Predicted>,
    /// Max − min over all diagonals as predicted, µm.
    pub range_over_all_um: f64,
    /// Max − min over all diagonals of the readings, µm.
    pub read_range_over_all_um: f64,
}

/// Figures of a diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Predicted {
    /// Far end less start as predicted, without noise, µm.
    pub end_um: f64,
    /// Max − min as predicted, µm.
    pub range_um: f64,
    /// Far end less start of the readings with their noise, mean of the runs, µm.
    pub read_end_um: f64,
    /// Max − min of the readings, µm.
    pub read_range_um: f64,
}

/// Readings of each pass by node, zero at the forward start, µm.
type Passes = Vec<(Pass, Vec<f64>)>;

/// Lines of the file beside its readings: some for each input and each note.
const MOST_COMMENTS: usize = 1000;

/// Predicts the readings. Refused where an error is not measured, or not everywhere in the box.
pub fn readings(
    machine: &SimulatedMachine<'_>,
    rehearsal: &Rehearsal,
) -> Result<Simulation, Problems> {
    let mut problems = Problems::none();
    rehearsal.check_measured(machine.inputs, &mut problems);
    rehearsal.check_rows(&mut problems);
    problems.or_ok(())?;
    let mut exact = Vec::new();
    let mut runs = Vec::new();
    for (index, diagonal) in Diagonal::ALL.into_iter().enumerate() {
        let Some(passes) = rehearsal.passes(machine, diagonal) else {
            continue; // every term was found to be measured
        };
        exact.extend(rehearsal.as_runs(diagonal, 1, &passes));
        runs.extend(rehearsal.noisy_runs(diagonal, index, &passes));
    }
    let kind = rehearsal.measurement.kind;
    let (predicted, range_over_all_um) = figures(&exact, kind);
    let (read, read_range_over_all_um) = figures(&runs, kind);
    let diagonals = PerDiagonal::from_fn(|d| {
        let DiagonalFigures { end_um, range_um } = predicted[d];
        let DiagonalFigures { end_um: read_end_um, range_um: read_range_um } = read[d];
        Predicted { end_um, range_um, read_end_um, read_range_um }
    });
    for run in &mut runs {
        rehearsal.add_expansion(run);
    }
    Ok(Simulation { runs, diagonals, range_over_all_um, read_range_over_all_um })
}

impl Rehearsal {
    /// No file of readings is written that would be refused when it is read.
    fn check_rows(&self, problems: &mut Problems) {
        let nodes = self.measurement.volume.last_node(self.measurement.kind) + 1;
        let runs = usize::try_from(self.runs).unwrap_or(usize::MAX);
        let passes = Diagonal::ALL.len() * (1 + usize::from(self.both_directions));
        let rows = nodes.saturating_mul(passes).saturating_mul(runs);
        let most = MOST_LINES - MOST_COMMENTS;
        if rows > most {
            problems.push(refusals::many_readings(rows, most));
        }
    }

    fn passes(&self, machine: &SimulatedMachine<'_>, diagonal: Diagonal) -> Option<Passes> {
        let DiagonalMeasurement { volume, kind, .. } = &self.measurement;
        let laser = volume.laser(diagonal);
        // u · E(q), not zeroed; first order: beam and mirror along the diagonal.
        let along = |pass: &Pass| {
            let um = |node| Some(laser.dot(self.error_at(machine, diagonal, *pass, node)?));
            Some((*pass, (0..=volume.last_node(*kind)).map(um).collect::<Option<_>>()?))
        };
        let passes = &Pass::BOTH[..=usize::from(self.both_directions)];
        let mut passes: Passes = passes.iter().map(along).collect::<Option<_>>()?;
        let zero = *passes.first()?.1.first()?;
        for (pass, readings) in &mut passes {
            let angles = self.angles.as_ref().and_then(|angles| angles.of(diagonal, *pass));
            let effect = |node: usize| angles.and_then(|of| of.get(node).copied()).unwrap_or(0.0);
            readings.iter_mut().enumerate().for_each(|(node, um)| *um = *um - zero + effect(node));
        }
        Some(passes)
    }

    /// The error of the tool at a node, µm, each term in the direction in which its axis arrived.
    fn error_at(
        &self,
        machine: &SimulatedMachine<'_>,
        diagonal: Diagonal,
        pass: Pass,
        node: usize,
    ) -> Option<PerAxis<f64>> {
        let DiagonalMeasurement { volume, kind, .. } = &self.measurement;
        let place = volume.place(diagonal, *kind, node);
        let mut error = PerAxis::default();
        for term in ErrorTerm::ALL {
            let direction = self.arrived(diagonal, pass, node, term.along);
            error[term.of] += machine.left_um(term, direction, place[term.along])?;
        }
        Some(error)
    }

    fn as_runs(
        &self,
        diagonal: Diagonal,
        number: u32,
        passes: &Passes,
    ) -> impl Iterator<Item = Run> {
        let recorded = self.recorded();
        passes.iter().map(move |(pass, readings)| Run {
            diagonal,
            number,
            pass: *pass,
            deviations: readings.iter().copied().map(Deviation::from_um).collect(),
            temperatures_c: PerAxis::from_fn(|axis| {
                recorded[axis].then(|| vec![REFERENCE_C; readings.len()])
            }),
        })
    }

    /// The runs of a diagonal. Each draws from a stream of its own, so that more runs or the return pass
    /// change nothing of the others. The instrument is zeroed once, at the start of the first run.
    fn noisy_runs(&self, diagonal: Diagonal, index: usize, passes: &Passes) -> Vec<Run> {
        let mut runs = Vec::new();
        let mut zero_um = None;
        for number in 1..=self.runs {
            let stream = u64::from(number - 1) * Diagonal::ALL.len() as u64 + index as u64;
            let mut off_um = self.noise.draws(stream);
            let mut noisy = passes.clone();
            for um in noisy.iter_mut().flat_map(|(_, readings)| readings) {
                let off = off_um();
                *um = *um + off - *zero_um.get_or_insert(off);
            }
            runs.extend(self.as_runs(diagonal, number, &noisy));
        }
        runs
    }

    /// Adds the expansion that the job takes off again, and rounds to the digits of a file.
    fn add_expansion(&self, run: &mut Run) {
        let DiagonalMeasurement { volume, kind, .. } = &self.measurement;
        let material = self.material();
        let expansion = |node: usize| {
            material.map_or(0.0, |material| expansion_um(volume, *kind, &material, run, node))
        };
        let nodes = run.deviations.iter().enumerate();
        let read = nodes.map(|(node, um)| Deviation::from_um(written(um.um() + expansion(node))));
        run.deviations = read.collect();
    }

    /// Notes errors that are not measured, or not in a direction in which a pass moves, or not all over the
    /// box: nothing is extrapolated.
    fn check_measured(&self, Inputs { job, model, .. }: &Inputs, problems: &mut Problems) {
        let of_errors = matches!(job.measurement.data, MeasuredData::Errors(_));
        let key = if of_errors { "measurement.errors" } else { "measurement.readings" };
        for words in not_known(model, |_, _| true) {
            problems.push(job.source.at(key, refusals::not_measured(words)));
        }
        let key = match &job.program {
            Some(program) if of_errors => program.size_path,
            _ => "measurement.step_diagonal.size_mm",
        };
        for words in outside(model, &self.measurement.volume) {
            problems.push(job.source.at(key, refusals::outside_measured(words)));
        }
    }
}

impl Noise {
    /// Draws of a stream of its own, µm.
    fn draws(self, stream: u64) -> impl FnMut() -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(stream);
        move || {
            let draw: f64 = StandardNormal.sample(&mut random);
            self.um * draw
        }
    }
}

/// The errors that single-axis measurements would show, mean of `runs`; relative to the
/// reference. With noise the table states it as uncertainty (k = 1), less what its job states for every value
/// (`noise_um`), in squares.
pub fn single_axes(
    machine: &SimulatedMachine<'_>,
    runs: u32,
    noise: Noise,
    comments: Vec<String>,
) -> Draft {
    let stated_um = machine.inputs.job.measurement.uncertainty.noise_um;
    let noise = Noise { um: noise.um / f64::from(runs).sqrt(), ..noise };
    let more = noise.um.squared() - stated_um.unwrap_or(0.0).squared();
    let column_um = more.max(0.0).sqrt();
    let of = |axis| machine.directions(axis).into_iter().map(move |way| (axis, way));
    let series = (0..).zip(Axis::ALL.into_iter().flat_map(of));
    let one = |(stream, of)| machine.series(of, noise.draws(stream), column_um);
    Draft { comments, series: series.map(one).collect() }
}

impl SimulatedMachine<'_> {
    /// The directions that an axis has rows for; `None` = both alike.
    fn directions(&self, axis: Axis) -> Vec<Option<Direction>> {
        let model = &self.inputs.model;
        let mut measured = model.measured_along(axis).peekable();
        if measured.peek().is_none() || model.ranges[axis].is_none() {
            return Vec::new();
        }
        let one_way = measured.find_map(|(_, term)| match term.measured {
            TermCurves::OneWay(direction, _) => Some(direction),
            _ => None,
        });
        match one_way {
            Some(direction) => vec![Some(direction)],
            None if self.is_directed(axis) => Direction::BOTH.map(Some).into(),
            None => vec![None],
        }
    }

    /// What one series shows with its noise; `column_um` = what the columns state of that.
    fn series(
        &self,
        (axis, direction): (Axis, Option<Direction>),
        mut off_um: impl FnMut() -> f64,
        column_um: f64,
    ) -> Series {
        let positions = self.positions(axis);
        let moving = direction.unwrap_or(Direction::Plus);
        let mut series = Series::new(axis, direction, positions.clone());
        for of in Axis::ALL {
            let term = ErrorTerm { of, along: axis };
            let at = |position: &Millimetres| self.left_um(term, moving, *position);
            let Some(left) = positions.iter().map(at).collect::<Option<Vec<f64>>>() else {
                continue;
            };
            let um = left.into_iter().map(|um| written(um + off_um())).collect();
            series.values.insert(Kind::Deviation(of), um);
        }
        if column_um > 0.0 {
            let stated = series.values.iter().map(|(of, um)| (*of, vec![column_um; um.len()]));
            series.uncertainties = stated.collect();
        }
        series
    }

    /// Positions at which any error of an axis was measured, inside the range of all of them.
    fn positions(&self, axis: Axis) -> Vec<Millimetres> {
        let model = &self.inputs.model;
        let is_measured = |at: f64| {
            model.ranges[axis].is_some_and(|(low, high)| (low.mm()..=high.mm()).contains(&at))
        };
        let terms = model.measured_along(axis);
        let mut positions: Vec<Millimetres> = terms
            .flat_map(|(_, measured)| measured.curves().flat_map(|curve| curve.knots().to_vec()))
            .filter(|knot| is_measured(knot.mm()))
            .collect();
        positions.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
        positions.dedup_by(|a, b| (a.mm() - b.mm()).abs() < SAME_PLACE_MM);
        positions
    }
}

/// Where a simulation comes from, for the comments of its file.
#[derive(Clone, Debug, Serialize)]
pub struct SimulationSource {
    /// By how much every scale has grown, µm/m.
    pub scale_um_per_m: f64,
    /// The tables that were active, in words.
    pub tables: String,
    /// The files that hold them.
    pub table_files: Vec<HashedFile>,
    /// What was taken for granted.
    #[serde(skip)]
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
    let moved = if rehearsal.measurement.kind == PathKind::Step { ",moved" } else { "" };
    let header = format!("diagonal,run,direction,node{moved},deviation_um{recorded}");
    let rows = simulation.runs.iter().flat_map(|run| {
        let nodes = run.deviations.len();
        // In the order in which they are measured.
        let node = move |turn: usize| match run.pass {
            Pass::Forward => turn,
            Pass::Reverse => nodes - 1 - turn,
        };
        (0..nodes).map(move |turn| row(run, node(turn), rehearsal))
    });
    let comments = comments.iter().map(|comment| plain::comment(comment));
    comments.chain([header]).chain(rows).map(|line| line + "\n").collect()
}

fn row(run: &Run, node: usize, rehearsal: &Rehearsal) -> String {
    let um = run.deviations[node].um();
    let DiagonalMeasurement { volume, kind, laser_sign, .. } = &rehearsal.measurement;
    let um = Figure(match laser_sign {
        Direction::Plus => um,
        Direction::Minus => 0.0 - um,
    });
    let moved = match (kind, node) {
        (PathKind::Straight, _) => String::new(),
        (PathKind::Step, 0) => ",".to_string(),
        (PathKind::Step, node) => format!(",{}", volume.moved(node).key()),
    };
    let celsius = run.temperatures_c.iter();
    let celsius = celsius.filter_map(|(_, t)| Some(format!(",{}", t.as_ref()?.get(node)?)));
    let (celsius, pass): (String, _) = (celsius.collect(), run.pass.word());
    format!("{},{},{pass},{node}{moved},{um}{celsius}", run.diagonal, run.number)
}
