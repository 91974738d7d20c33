//! How the simulated machine is measured: box, nodes, directions, runs, noise.

use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{
    DiagonalMeasurement, Job, Material, MeasuredData, ProgramRequest, Reflector,
};
use crate::kit::findings::InRehearsal;
use crate::machine::separation::campaign::angles;
use crate::machine::separation::corrections::AngleEffects;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};

/// Normal noise of every single reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation, µm; 0 = none.
    pub um: f64,
    /// Seed of the generator.
    pub seed: u64,
}

/// What is asked for beside the job.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wishes {
    /// Straight runs, whatever the job measures.
    pub straight: bool,
    /// The return pass too, whatever the job measures.
    pub both_directions: bool,
    /// Number of runs; `None` = as `[program]` states, else 1.
    pub runs: Option<u32>,
    /// Noise of a reading.
    pub noise: Noise,
}

/// A measurement of the diagonals that is going to be simulated.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    /// The measured box.
    pub volume: Volume,
    /// Step or straight.
    pub kind: PathKind,
    /// Number of runs of each diagonal.
    pub runs: u32,
    /// Whether the return pass is measured too.
    pub both_directions: bool,
    /// Whether every axis runs past the end point before the return pass.
    pub overrun: bool,
    /// Noise of a reading.
    pub noise: Noise,
    /// `Minus` where the instrument counts towards the laser head.
    pub(super) laser_sign: Direction,
    /// Expansion that the separation of this job takes off the readings.
    pub(super) material: Option<Material>,
    /// Angular effects that the separation of this job takes off the readings.
    pub(super) angles: Option<AngleEffects>,
    /// What was taken for granted.
    pub notes: Vec<Finding>,
}

impl Rehearsal {
    /// From `[measurement.step_diagonal]` of a job with readings, else from `[program]`.
    /// `angle_table` = the table that `measurement.angles` names.
    pub fn of(
        job: &Job,
        angle_table: Option<&ErrorTable>,
        wishes: Wishes,
    ) -> Result<Rehearsal, Problems> {
        match (&job.measurement.data, &job.program) {
            (MeasuredData::Diagonals(measurement), _) => {
                measured_again(job, measurement, angle_table, wishes)
            }
            (MeasuredData::Errors(_), Some(program)) => Ok(programmed(job, program, wishes)?),
            (MeasuredData::Errors(_), None) => Err(job
                .problem_at(
                    "measurement.errors",
                    "the job does not say how diagonals would be measured: it has neither readings nor a section [program]",
                )
                .help("add `[program]` with `what = \"step-diagonal\"`, `start_mm`, `size_mm`, `steps` and `order` (docs/program.md), or predict single axes with `--errors`")
                .into()),
        }
    }

    /// The direction in which an axis arrived at a node: without overrun it has not reversed
    /// before its first move back.
    pub fn arrived(&self, diagonal: Diagonal, pass: Pass, node: usize, axis: Axis) -> Direction {
        let made = self.volume.steps_made(self.kind, node, axis);
        let reversed = self.overrun || made < self.volume.steps;
        let pass = if reversed { pass } else { Pass::Forward };
        diagonal.travelled(axis, pass)
    }

    /// Axes whose temperature the readings have to carry: the job corrects them and does not say
    /// how warm they are.
    pub(super) fn recorded(&self) -> PerAxis<bool> {
        let material = self.material.filter(|material| !material.material_corrected);
        PerAxis::from_fn(|axis| {
            let scale = material.and_then(|material| material.axes[axis]);
            scale.is_some_and(|scale| scale.temperature_c.is_none())
        })
    }
}

/// The measurement of the job once more.
fn measured_again(
    job: &Job,
    measurement: &DiagonalMeasurement,
    angle_table: Option<&ErrorTable>,
    wishes: Wishes,
) -> Result<Rehearsal, Problems> {
    let mut measurement = measurement.clone();
    if wishes.straight {
        measurement.kind = PathKind::Straight;
        measurement.target = Reflector::Retroreflector;
    }
    let angles = match angle_table {
        None => None,
        Some(table) => Some(angles(job, &measurement, table)?),
    };
    let is_assumed = wishes.both_directions && measurement.overrun.is_none();
    let notes = is_assumed.then(|| InRehearsal::OverrunAssumed.into());
    Ok(Rehearsal {
        kind: measurement.kind,
        runs: wishes.runs.unwrap_or(1),
        both_directions: wishes.both_directions,
        overrun: measurement.overrun.unwrap_or(true),
        noise: wishes.noise,
        laser_sign: measurement.laser_sign,
        material: measurement.material,
        angles,
        notes: notes.into_iter().collect(),
        volume: measurement.volume,
    })
}

/// The run that `nonius program` writes programs for.
fn programmed(job: &Job, program: &ProgramRequest, wishes: Wishes) -> Result<Rehearsal, Problem> {
    let Some(kind) = program.what.path() else {
        return Err(job
            .problem_at(
                "program.what",
                "`[program]` measures single axes, so there are no diagonals to predict",
            )
            .help("write `what = \"step-diagonal\"`, or predict single axes with `--errors`"));
    };
    Ok(Rehearsal {
        volume: program.volume.clone(),
        kind: if wishes.straight { PathKind::Straight } else { kind },
        runs: wishes.runs.unwrap_or(program.runs),
        both_directions: wishes.both_directions || program.bidirectional,
        overrun: program.overrun.mm() > 0.0,
        noise: wishes.noise,
        laser_sign: Direction::Plus,
        material: None,
        angles: None,
        notes: Vec::new(),
    })
}
