//! What the figures rest on: frame, levers, tables that were active, notes of the measurement.

use crate::inputs::error_table::Remarks;
use crate::inputs::job::{ActiveTables, Frame, Job, Levers, MeasuredData};
use crate::kit::Inputs;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, PerAxis, Rotation};
use crate::quantity::units::Millimetres;
use crate::volume::volume_model::{Component, VolumeModel};

/// A deviation above this is more often a slip of the unit, µm.
const UNLIKELY_UM: f64 = 5_000.0;
/// An angle above this, µrad, and a squareness above this, µm/m, likewise.
const UNLIKELY_URAD: f64 = 5_000.0;

/// What the figures rest on.
pub(super) struct Basis {
    /// How the axes are aligned: `as given`, `x-primary`, `as-measured`.
    pub(super) frame: &'static str,
    /// The stated places that levers depend on.
    pub(super) levers: Levers,
    /// The tables that were active while measuring.
    pub(super) active: Option<String>,
    /// VA of the machine without them, µm.
    pub(super) without_tables_um: Option<f64>,
    /// What whoever reads a figure has to know, one sentence each.
    pub(super) labels: Vec<String>,
}

impl Basis {
    /// Of a job.
    pub(super) fn of_job(inputs: &Inputs, volume: &VolumeModel) -> Basis {
        let job = &inputs.job;
        let measurement = &job.measurement;
        let mut labels = doubts(job, inputs.as_measured());
        labels.extend(volume.labels.iter().cloned());
        labels.extend(outside(job));
        let active = match &measurement.active {
            ActiveTables::None => None,
            ActiveTables::NotStated => {
                labels.push("`active_while_measuring` is not stated: if a compensation (or a backlash parameter) was active during the measurement, these figures are those of the machine with it; write \"none\", or the path of the kit or of the files read out of the control".to_string());
                None
            }
            ActiveTables::Path(path) => Some(path.clone()),
        };
        labels.extend(inputs.active_notes.iter().cloned());
        labels.extend(measurement.notes());
        labels.extend(said(&inputs.model.remarks));
        Basis {
            frame: frame(&measurement.data),
            levers: measurement.levers,
            active,
            without_tables_um: None,
            labels,
        }
    }

    /// Of an error table alone.
    pub(super) fn of_table(job: &Job, model: &ErrorModel, volume: &VolumeModel) -> Basis {
        let mut labels = doubts(job, model);
        labels.extend(volume.labels.iter().cloned());
        labels.push("no job describes this machine: the curves are zero, and levers count from, the lowest measured position of each axis; whether a compensation was active during the measurement is not known".to_string());
        labels.extend(said(&model.remarks));
        Basis {
            frame: frame(&job.measurement.data),
            levers: job.measurement.levers,
            active: None,
            without_tables_um: None,
            labels,
        }
    }

    /// How the axes are aligned, in words.
    pub(super) fn frame_words(&self) -> &'static str {
        match self.frame {
            "x-primary" => {
                "X primary, XY plane secondary: the separation took the slopes off EYX, EZX and EZY"
            }
            "as-measured" => {
                "as measured: the slopes of the cross terms hold an arbitrary rotation of the separation"
            }
            _ => "as given in the error table",
        }
    }
}

/// The word of the job where readings were separated; given errors are not rotated.
fn frame(data: &MeasuredData) -> &'static str {
    match data {
        MeasuredData::Errors(_) => "as given",
        MeasuredData::Diagonals(measurement) => match measurement.frame {
            Frame::XPrimary => "x-primary",
            Frame::AsMeasured => "as-measured",
        },
    }
}

/// What the error table says of itself, beside the doubts that the model tells.
fn said(remarks: &Remarks) -> Vec<String> {
    let missing = remarks.not_determined.iter();
    let missing = missing.map(|(term, why)| format!("{term} is not determined: {why}"));
    let reversal = remarks.hidden_reversal_um.map(|um| format!("the readings show a reversal of about {um:.3} µm along the diagonals, which these curves do not hold: every figure here is without it"));
    let notes = remarks.notes.iter().cloned();
    missing.chain(reversal).chain(notes).collect()
}

/// Values that no machine tool has, which are more often a slip of the unit.
fn doubts(job: &Job, model: &ErrorModel) -> Vec<String> {
    let deviations = model
        .measured()
        .map(|(term, measured)| (term.to_string(), measured.largest_um(), "µm", UNLIKELY_UM));
    let angles = Rotation::all().filter_map(|rotation| {
        let curve = model.rotations[rotation].as_ref()?.mean();
        let (from, to) = curve.measured_range();
        let largest = curve.largest_magnitude(from, to);
        Some((rotation.to_string(), largest, "µrad", UNLIKELY_URAD))
    });
    let squareness = job.measurement.squareness.iter().map(|(term, slope)| {
        let name = Component::Squareness(*term).to_string();
        (name, slope.abs(), "µm/m", UNLIKELY_URAD)
    });
    let small = model.unlikely_small(job.measurement.uncertainty.noise_um);
    let small = small.map(|words| format!("doubt: {words}"));
    deviations
        .chain(angles)
        .chain(squareness)
        .filter(|(_, largest, _, limit)| largest > limit)
        .map(|(name, largest, unit, limit)| {
            format!("doubt: {name} reaches {largest:.0} {unit}, and more than {limit:.0} {unit} is unlikely: check the unit of its column or key")
        })
        .chain(small)
        .collect()
}

/// Offsets that no axis reaches.
fn outside(job: &Job) -> Option<String> {
    let beyond = |axis: Axis| not_reached(job, job.measurement.levers.offsets, axis);
    let words: Vec<String> = Axis::ALL.into_iter().filter_map(beyond).collect();
    (!words.is_empty()).then(|| {
        format!(
            "`offsets_mm` names a place that the machine does not reach: {}; levers count from there all the same",
            words.join(", ")
        )
    })
}

fn not_reached(job: &Job, places: PerAxis<Option<Millimetres>>, axis: Axis) -> Option<String> {
    let (place, machine) = (places[axis]?.mm(), job.machine.axes[axis]?);
    let (low, high) = (machine.low.mm(), machine.high.mm());
    (place < low || place > high)
        .then(|| format!("{axis} {place} mm (its travel is {low} … {high} mm)"))
}
