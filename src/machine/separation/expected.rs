//! A measurement that is still to be made: readings without any error go through the separation itself, so
//! what it says of uncertainty, degrees of freedom and what stays open is what it will say of the readings.
//!
//! ```text
//!   passes, runs ─→ corrected readings of 0 ─→ separation, σ = what is expected ─→ U, rank, what stays open
//! ```

use super::campaign::{Campaign, corrected};
use super::closure::Start;
use super::linear_reversal::LinearReversal;
use super::noise::Noise;
use super::separate::{Separation, of_start};
use super::uncertainty::of_length_ppm;
use crate::inputs::job::{DiagonalMeasurement, StatedUncertainty};
use crate::quantity::axis::{Axis, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Run, Volume};
use crate::quantity::units::Deviation;

/// What is expected of a measurement before its readings exist: deviations of 0, with the uncertainties
/// that this many runs of these passes will have. `noise_um`: σ of a single reading. Whether the axes
/// overrun has to be stated where the return pass is one of the passes. `change_um`: by how much the reversals are
/// known to change along their axes.
pub(crate) fn expected(
    campaign: &Campaign<'_>,
    passes: &[Pass],
    runs: u32,
    noise_um: f64,
    change_um: &PerTerm<f64>,
) -> Separation {
    let of_noise = |noise: Noise| Noise { sigma_um: noise_um, ..noise };
    let mut start = Start::new(campaign, &exact(campaign, passes, runs));
    start.noise = start.noise.map(of_noise);
    start.change_um.clone_from(change_um);
    of_start(campaign, &start, of_noise)
}

/// Raw readings that are 0 when they are corrected.
fn exact(campaign: &Campaign<'_>, passes: &[Pass], runs: u32) -> Vec<Run> {
    let last = campaign.measurement.volume.last_node(PathKind::Step);
    let walks = (1..=runs).flat_map(|number| passes.iter().map(move |pass| (number, *pass)));
    let run = |number, pass, diagonal| Run {
        diagonal,
        number,
        pass,
        deviations: vec![Deviation::from_um(0.0); last + 1],
        temperatures_c: PerAxis::default(),
    };
    let all = walks.flat_map(|(number, pass)| Diagonal::ALL.map(|d| run(number, pass, d)));
    let mut all: Vec<Run> = all.collect();
    let corrected = corrected(campaign, &all);
    for (run, corrected) in all.iter_mut().zip(corrected) {
        let taken_off = corrected.readings_um.into_iter();
        run.deviations = taken_off.map(|um| Deviation::from_um(-um)).collect();
    }
    all
}

/// What a laser does wherever it measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instrument {
    /// σ of a single reading, µm.
    pub(crate) noise_um: f64,
    /// `[measurement.uncertainty]`.
    pub(crate) stated: StatedUncertainty,
}

impl Instrument {
    /// Standard uncertainty of the mean of so many runs at one position, µm.
    fn of_mean_um(self, runs: u32) -> f64 {
        self.noise_um / f64::from(runs).sqrt()
    }

    /// The reversal of an axis of 0 as so many runs in both directions at the positions of the diagonals tell it.
    pub(crate) fn reversal(self, volume: &Volume, runs: u32) -> LinearReversal {
        let u_um = std::f64::consts::SQRT_2 * self.of_mean_um(runs);
        let places = volume.steps + 1;
        LinearReversal { um: vec![0.0; places], u_um: Some(vec![u_um; places]) }
    }

    /// Standard uncertainty of the slope over a whole axis, from so many runs in both directions, µm/m.
    ///
    /// formula  u² = 2σ²/(2r L²) + scale²: the mean of both directions at both ends
    pub(crate) fn of_slope_um_per_m(
        self,
        measurement: &DiagonalMeasurement,
        axis: Axis,
        runs: u32,
    ) -> f64 {
        let ends = 1000.0 * self.of_mean_um(runs) / measurement.volume.size[axis].mm();
        ends.hypot(of_length_ppm(self.stated, measurement.material, axis))
    }
}
