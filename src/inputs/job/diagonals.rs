//! `[measurement.step_diagonal]`: how the body diagonals were measured (contract §2.3).

use crate::inputs::job::MachineAxis;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;

/// A measurement of the four body diagonals.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagonalMeasurement {
    /// Path of the readings, relative to the job.
    pub readings: String,
    /// Single-axis steps or straight.
    pub kind: PathKind,
    /// The measured box.
    pub volume: Volume,
    /// `Minus` where the instrument counts towards the laser head.
    pub laser_sign: Direction,
    /// Whether the tilt of the mirror is solved for.
    pub setup: SetUp,
    /// Frame of the cross terms.
    pub frame: Frame,
    /// What the beam is reflected by.
    pub target: Reflector,
    /// Whether the axes ran over the far end before the reverse pass; `None` = judged from the data.
    pub overrun: Option<bool>,
    /// Measurements of single axes along their length.
    pub linear: Vec<Linear>,
    /// Measurements along other straight lines.
    pub beams: Vec<Beam>,
    /// Temperature of the scales and what was corrected already.
    pub material: Option<Material>,
    /// Path of an error table that a straight run is compared with (closure test).
    pub closure_errors: Option<String>,
}

/// What is assumed of the direction of mirror and beam in the four set-ups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetUp {
    /// Unknown in every set-up, solved for.
    Solve,
    /// Exactly along the nominal diagonals: labelled in every output.
    AssumePerfect,
}

/// Frame in which the slopes of the cross terms are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// X primary, XY plane secondary: EYX, EZX and EZY have no slope.
    XPrimary,
    /// The slopes as they fell out.
    AsMeasured,
}

/// What reflects the beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reflector {
    /// A flat mirror: needed for single-axis steps; it turns with the tool.
    FlatMirror,
    /// A retroreflector: for straight runs.
    Retroreflector,
}

/// One `[[measurement.step_diagonal.linear]]`: positioning error of an axis along its length.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// The axis.
    pub axis: Axis,
    /// Its slope.
    pub slope: LinearSlope,
    /// Standard uncertainty (k = 1) of the slope, µm/m.
    pub u_um_per_m: Option<f64>,
}

/// Where the slope of a linear measurement comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum LinearSlope {
    /// Stated, µm/m.
    Stated(f64),
    /// The positioning error in an error table: its path, relative to the job.
    Errors(String),
}

/// One `[[measurement.step_diagonal.beam]]`: displacement measured along any other straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the line begins, machine coordinates.
    pub from: PerAxis<Millimetres>,
    /// Where it ends.
    pub to: PerAxis<Millimetres>,
    /// Displacement error along the line by its length, µm/m.
    pub slope_um_per_m: f64,
    /// Standard uncertainty (k = 1) of the slope, µm/m.
    pub u_um_per_m: Option<f64>,
}

/// `[measurement.step_diagonal.material]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The readings hold a correction of the scales' expansion already.
    pub material_corrected: bool,
    /// The readings hold a correction of the air's refraction already.
    pub air_corrected: bool,
    /// Of each axis; absent where the job gives none.
    pub axes: PerAxis<Option<AxisMaterial>>,
}

/// Expansion of one axis' scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMaterial {
    /// Coefficient of linear expansion, 1/K.
    pub alpha_per_k: f64,
    /// Mean temperature during the measurement, °C; `None` where each reading carries its own.
    pub temperature_c: Option<f64>,
}

/// `[measurement.uncertainty]`: standard uncertainties (k = 1); what is `None` is listed as not included.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct StatedUncertainty {
    /// Noise of a single reading, µm.
    pub noise_um: Option<f64>,
    /// Scale of the laser (wavelength, air), 10⁻⁶.
    pub laser_ppm: Option<f64>,
    /// Temperature of the scales, K.
    pub temperature_k: Option<f64>,
    /// Coefficient of expansion, 1/K.
    pub alpha_per_k: Option<f64>,
    /// Change of length scale (laser, air, scales) from one set-up to the next, 10⁻⁶.
    pub setup_ppm: Option<f64>,
    /// Bound on each pitch, yaw and roll that was not measured: how far it departs anywhere in the
    /// box from its value at the low end of its axis, whatever its shape, µrad.
    pub angle_urad: Option<f64>,
    /// Bound on the angle between the beam and the mirror's normal (straight runs: and the
    /// diagonal), mrad.
    pub beam_mrad: Option<f64>,
    /// Tilt of the mirror in each direction across the diagonal where the set-up is assumed
    /// perfect, seconds of arc.
    pub tilt_arcsec: Option<f64>,
}

impl StatedUncertainty {
    /// The stated keys that only readings of the diagonals have a use for.
    pub(crate) fn keys_of_readings(&self) -> Vec<&'static str> {
        let all = [
            ("temperature_k", self.temperature_k),
            ("alpha_per_k", self.alpha_per_k),
            ("setup_ppm", self.setup_ppm),
            ("angle_urad", self.angle_urad),
            ("beam_mrad", self.beam_mrad),
            ("tilt_arcsec", self.tilt_arcsec),
        ];
        let stated = all.into_iter().filter(|(_, value)| value.is_some());
        stated.map(|(key, _)| key).collect()
    }

    /// What the beam may take off every length, 10⁻⁶: 1 − cos of `beam_mrad`. All of it counts as a
    /// standard uncertainty: it has one sign and stays in the readings.
    pub(crate) fn beam_ppm(&self) -> f64 {
        self.beam_mrad.map_or(0.0, |mrad| mrad * mrad / 2.0)
    }
}

/// Places that the lever arms of angular errors are counted from; machine coordinates, `None` =
/// not stated.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Levers {
    /// `offsets_mm`: where each axis rested while the others were measured (paper 002 §3.1).
    pub offsets: PerAxis<Option<Millimetres>>,
    /// `tool_offset_mm`: from the point where the errors were measured to the tool point.
    pub tool: Option<PerAxis<Millimetres>>,
    /// `angles_zero_mm`: where the angles of an axis count as zero, which is where it stood while
    /// the squareness was measured.
    pub angles_zero: PerAxis<Option<Millimetres>>,
    /// `straightness_optic_mm`: of an axis that carries the workpiece, the place on its table where
    /// the optic of its straightness measurement rode; `None` = it was measured at the tool point.
    pub straightness_optic: PerAxis<Option<Millimetres>>,
}

impl Levers {
    /// Where the levers of the angles count from: the stated `offsets_mm`, else the reference
    /// (machine zero of an axis that the job does not have). One rule for everyone: curves that
    /// were separated with one origin and judged with another are those of no machine.
    pub fn origin(&self, axes: &PerAxis<Option<MachineAxis>>) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| {
            let reference = axes[axis].map(|machine| machine.reference);
            let place = self.offsets[axis].or(reference);
            place.map_or(0.0, Millimetres::mm)
        })
    }
}
