//! What goes into a separation: how it was measured, the corrected readings, lines beside them.

use super::corrections::{AngleEffects, without_angles, without_expansion};
use super::linear_reversal::LinearReversals;
use super::noise::CorrectedRun;
use crate::inputs::job::{DiagonalMeasurement, StatedUncertainty};
use crate::machine::separation::angle_evidence::AngleEvidence;
use crate::quantity::axis::PerAxis;
use crate::quantity::diagonal::Run;
use crate::quantity::units::Millimetres;

/// What goes into a separation beside the readings.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// How it was measured.
    pub measurement: &'a DiagonalMeasurement,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Slopes of single axes and other beams.
    pub lines: Vec<Line>,
    /// Reversal of single axes from linear measurements in both directions.
    pub reversals: LinearReversals,
    /// Effects of angular errors on the readings.
    pub angles: Option<AngleEffects>,
    /// Whether reverse readings count from the forward start; else only their increments hold.
    pub reverse_zero_known: bool,
}

impl Campaign<'_> {
    /// What is known of the angular errors.
    pub(crate) fn angle_evidence(&self) -> AngleEvidence {
        let angles = self.angles.as_ref();
        angles.map_or_else(|| AngleEvidence::nothing(None), |a| a.evidence.clone())
    }
}

/// A straight line beside the diagonals; the uncertainty where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Displacement error by length, µm/m.
    pub slope_um_per_m: f64,
    /// Standard uncertainty (k = 1), µm/m.
    pub u_um_per_m: Option<f64>,
    /// Where it begins and ends, inside the box (machine coordinates); `None` = every axis that
    /// moves goes from end to end of the box.
    pub ends: Option<[PerAxis<Millimetres>; 2]>,
}

/// The readings less expansion of the scales and angular effects.
pub fn corrected(campaign: &Campaign<'_>, runs: &[Run]) -> Vec<CorrectedRun> {
    let measurement = campaign.measurement;
    let kind = measurement.kind;
    let correct = |run: &Run| {
        let material = measurement
            .material
            .filter(|material| !material.material_corrected);
        let mut readings_um = match material {
            Some(material) => without_expansion(&measurement.volume, kind, &material, run),
            None => run
                .deviations
                .iter()
                .map(|deviation| deviation.um())
                .collect(),
        };
        let angles = campaign.angles.as_ref();
        if let Some(effect) = angles.and_then(|angles| angles.of(run.diagonal, run.pass)) {
            without_angles(&mut readings_um, effect);
        }
        CorrectedRun {
            diagonal: run.diagonal,
            number: run.number,
            pass: run.pass,
            readings_um,
        }
    };
    runs.iter().map(correct).collect()
}
