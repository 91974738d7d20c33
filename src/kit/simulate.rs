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

mod control;
mod readings;
mod rehearsal;
mod single_axes;
mod text;

pub use self::control::SimulatedTables;
pub use self::readings::{Simulation, readings};
pub use self::rehearsal::{Noise, Rehearsal, Wishes};
pub use self::single_axes::single_axes;
pub use self::text::{SimulationSource, write};

use crate::judge::after::Control;
use crate::kit::Inputs;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::units::{Correction, Millimetres, rounded};

pub use crate::inputs::error_table::SIMULATED;

/// A machine with what the loaded tables do to it.
#[derive(Clone, Debug)]
pub struct SimulatedMachine<'a> {
    model: &'a ErrorModel,
    control: Option<&'a Control>,
    references: PerAxis<Option<Millimetres>>,
    scale_um_per_m: f64,
}

impl<'a> SimulatedMachine<'a> {
    /// The machine of a job; `loaded` = the tables that are active, `scale_um_per_m` = by how much
    /// every scale has grown since it was measured (α·ΔT of a machine that warmed up).
    pub fn new(
        inputs: &'a Inputs,
        loaded: Option<&'a SimulatedTables>,
        scale_um_per_m: f64,
    ) -> SimulatedMachine<'a> {
        let axes = &inputs.job.machine.axes;
        SimulatedMachine {
            model: &inputs.model,
            control: loaded.map(|loaded| &loaded.control),
            references: PerAxis::from_fn(|axis| axes[axis].map(|axis| axis.reference)),
            scale_um_per_m,
        }
    }

    /// Deviation + correction of a term, µm; `None` where it was not measured in this direction.
    pub(crate) fn left_um(
        &self,
        term: ErrorTerm,
        direction: Direction,
        position: Millimetres,
    ) -> Option<f64> {
        let measured = self.model.terms[term].as_ref()?;
        let deviation = measured.measured.curve(direction)?.at(position);
        let correction = self
            .control
            .map_or(Correction::ZERO, |control| control.correction(term, direction, position));
        Some((deviation + correction).um() + self.grown_um(term, position))
    }

    /// What the change of scale adds to a positioning error.
    fn grown_um(&self, term: ErrorTerm, position: Millimetres) -> f64 {
        let reference = self.references[term.along].filter(|_| term.is_positioning());
        reference
            .map_or(0.0, |reference| self.scale_um_per_m * (position - reference).mm() / 1000.0)
    }

    /// Whether the two directions of an axis differ: measured apart, or corrected apart.
    fn is_directed(&self, along: Axis) -> bool {
        let apart = |term| self.control.is_some_and(|control| !control.is_undirected(term));
        let mut of_axis = self.model.measured().filter(|(t, _)| t.along == along);
        of_axis.any(|(term, measured)| measured.measured.has_both_ways() || apart(term))
    }
}

/// 10⁻⁹ µm, as many decimals as readings carry.
fn written(um: f64) -> f64 {
    rounded(um, 9)
}
