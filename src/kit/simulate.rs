//! What a measurement would read after the tables were loaded: a rehearsal, not a measurement.
//!
//! ```text
//!   job ─→ nine curves ─────────────────┐
//!   bytes of the tables ─→ emulator ────┼→ what is left at every node ─→ along the laser ─→ readings
//!   [measurement.step_diagonal] or      │        (+ a change of scale)       (+ noise)
//!   [program]: nodes and their order ───┘
//! ```
//! The model is the one that [`crate::machine::separation`] inverts: e(q) = u · (E(q) − E(0)), nine errors,
//! each in the direction in which its axis really arrived. Not in it: angular errors (beside those
//! of `angles`, which the separation takes off again), repeatability beside the noise, a tilted
//! mirror, thermal drift beside one change of scale. Whatever is written carries [`SIMULATED`].
//!
//! The control is the one that loaded the files of a kit; the [`Rehearsal`] says how the machine is measured: box, nodes,
//! directions, runs, noise.

mod readings;

pub use self::readings::{Predicted, Simulation, SimulationSource, readings, single_axes, write};
use crate::control::controller::KitFile;
pub use crate::inputs::error_table::SIMULATED;
use crate::inputs::job::{
    DiagonalMeasurement, Job, Material, MeasuredData, ProgramRequest, Reflector,
};
use crate::judge::active::State;
use crate::judge::field::Field;
use crate::judge::findings::InControl;
use crate::kit::findings::InRehearsal;
use crate::kit::refusals;
use crate::kit::{Inputs, JobTables, Loaded};
use crate::machine::separation::campaign::angles;
use crate::machine::separation::corrections::AngleEffects;
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Millimetres, Pass, PathKind, PerAxis, rounded,
};
use crate::read::ReadFinding;
use crate::text::{Finding, Problem, Problems};
use crate::write::compensation::compile;
use crate::write::plan::plan;
use serde::Serialize;

/// A machine with what the loaded tables do to it.
#[derive(Clone, Debug)]
pub struct SimulatedMachine<'a> {
    inputs: &'a Inputs,
    control: Field,
    scale_um_per_m: f64,
}

impl<'a> SimulatedMachine<'a> {
    /// The machine of a job; `loaded` = the tables that are active, `scale_um_per_m` = by how much
    /// every scale has grown since it was measured (α·ΔT of a machine that warmed up).
    pub fn new(
        inputs: &'a Inputs,
        loaded: Option<&Loaded<'_>>,
        scale_um_per_m: f64,
    ) -> Result<SimulatedMachine<'a>, Problems> {
        let control = loaded.map(Loaded::effect).transpose()?.unwrap_or_default();
        Ok(SimulatedMachine { inputs, control, scale_um_per_m })
    }

    /// Deviation + correction of a term, µm; `None` where it was not measured in this direction.
    pub(crate) fn left_um(
        &self,
        term: ErrorTerm,
        direction: Direction,
        position: Millimetres,
    ) -> Option<f64> {
        let Inputs { job, model, .. } = self.inputs;
        let measured = model.terms[term].as_ref()?;
        let deviation = measured.measured.curve(direction)?.at(position);
        let correction = self.control.correction(term, direction, position);
        // What the change of scale adds to a positioning error.
        let axis = job.machine.axes[term.along].filter(|_| term.is_positioning());
        let from_reference = axis.map_or(0.0, |axis| (position - axis.reference).mm());
        Some((deviation + correction).um() + self.scale_um_per_m * from_reference / 1000.0)
    }

    /// Whether the two directions of an axis differ: measured apart, or corrected apart.
    fn is_directed(&self, along: Axis) -> bool {
        let apart = |term| !self.control.is_undirected(term);
        let mut of_axis = self.inputs.model.measured_along(along);
        of_axis.any(|(term, measured)| measured.measured.has_both_ways() || apart(term))
    }
}

/// 10⁻⁹ µm, as many decimals as readings carry.
fn written(um: f64) -> f64 {
    rounded(um, 9)
}

/// Files of a kit in the control of the job, with what a rehearsal takes for granted; `named` = `state` of their
/// manifest.
pub fn rehearsed<'a>(
    inputs: &'a Inputs,
    files: &[KitFile],
    named: Option<&State>,
) -> Result<Loaded<'a>, Problems> {
    let task = inputs.task();
    let plan = plan(task)?;
    let asked = JobTables { inputs, compiled: compile(task, &plan)?, plan };
    let mut loaded = Loaded::kit(asked, files, named)?;
    let parameter = |axis: Axis| {
        let name = loaded.asked.plan.names[axis].first()?;
        let um = loaded.state.axis(name)?.backlash_um;
        let is_named = named.is_some_and(|state| state.axis(name).is_some());
        (um.abs() > 0.0).then(|| InRehearsal::Backlash { axis, um, is_named }.into())
    };
    let parameters: Vec<Finding> = Axis::ALL.into_iter().filter_map(parameter).collect();
    // How the tables differ from those of the job is not told: they may be any.
    loaded.findings.retain(|found| {
        let is_other = matches!(found.kind(), Some(InControl::OtherBacklash { .. }));
        is_other || found.kind::<ReadFinding>().is_some()
    });
    loaded.findings.extend(parameters);
    Ok(loaded)
}

/// Normal noise of every single reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Noise {
    /// Standard deviation, µm; 0 = none.
    #[serde(rename = "noise_um")]
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
    /// How it is measured, and what the separation of its job takes off the readings.
    pub measurement: DiagonalMeasurement,
    /// Number of runs of each diagonal.
    pub runs: u32,
    /// Whether the return pass is measured too.
    pub both_directions: bool,
    /// Whether every axis runs past the end point before the return pass.
    pub overrun: bool,
    /// Noise of a reading.
    pub noise: Noise,
    /// Angular effects that the separation of this job takes off the readings.
    angles: Option<AngleEffects>,
    /// What was taken for granted.
    pub notes: Vec<Finding>,
}

impl Rehearsal {
    /// From `[measurement.step_diagonal]` of a job with readings, else from the run that `nonius program` writes
    /// programs for. The angles of an error table are no part of a measurement of diagonals.
    pub fn of(inputs: &Inputs, wishes: Wishes) -> Result<Rehearsal, Problems> {
        let job = &inputs.job;
        let is_of_diagonals = matches!(job.measurement.data, MeasuredData::Diagonals(_));
        let angle_table = inputs.angles.as_ref().filter(|_| is_of_diagonals);
        let measured = job.measurement.diagonals();
        let mut measurement = measured.map_or_else(|| programmed(job), |own| Ok(own.clone()))?;
        if wishes.straight {
            measurement.kind = PathKind::Straight;
            measurement.target = Reflector::Retroreflector;
        }
        let is_its_run = |run: &&ProgramRequest| {
            measured.is_none()
                || run.measured().is_some_and(|programmed| programmed.kind == measurement.kind)
        };
        let program = job.program.as_ref().filter(is_its_run);
        let angles = angle_table.map(|table| angles(job, &measurement, table)).transpose()?;
        let overrun = measurement.overrun.or(program.and_then(ProgramRequest::runs_over));
        let is_assumed = wishes.both_directions && overrun.is_none();
        let notes = is_assumed.then(|| InRehearsal::OverrunAssumed.into());
        Ok(Rehearsal {
            runs: wishes.runs.or(program.map(|run| run.runs)).unwrap_or(1),
            both_directions: wishes.both_directions || program.is_some_and(|run| run.bidirectional),
            overrun: overrun.unwrap_or(true),
            noise: wishes.noise,
            angles,
            notes: notes.into_iter().collect(),
            measurement,
        })
    }

    /// The direction in which an axis arrived at a node: without overrun it has not reversed
    /// before its first move back.
    pub fn arrived(&self, diagonal: Diagonal, pass: Pass, node: usize, axis: Axis) -> Direction {
        let DiagonalMeasurement { volume, kind, .. } = &self.measurement;
        let reversed = self.overrun || volume.steps_made(*kind, node, axis) < volume.steps;
        diagonal.travelled(axis, if reversed { pass } else { Pass::Forward })
    }

    /// Expansion that the separation takes off.
    fn material(&self) -> Option<Material> {
        self.measurement.material.filter(|material| !material.material_corrected)
    }

    /// Axes whose temperature the readings have to carry: the job corrects them and does not say
    /// how warm they are.
    fn recorded(&self) -> PerAxis<bool> {
        PerAxis::from_fn(|axis| {
            let scale = self.material().and_then(|material| material.axes[axis]);
            scale.is_some_and(|scale| scale.temperature_c.is_none())
        })
    }
}

/// How the run of `[program]` is measured.
fn programmed(job: &Job) -> Result<DiagonalMeasurement, Problem> {
    let Some(program) = &job.program else {
        return Err(job.source.at("measurement.errors", refusals::no_diagonals()));
    };
    let single = || job.source.at("program.what", refusals::single_axes_only());
    program.measured().ok_or_else(single)
}
