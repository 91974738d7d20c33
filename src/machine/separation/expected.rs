//! A measurement that is still to be made: readings without any error go through the separation itself, so
//! what it says of uncertainty, degrees of freedom and what stays open is what it will say of the readings.
//!
//! ```text
//!   passes, runs ─→ corrected readings of 0 ─→ separation, σ = what is expected ─→ U, rank, what stays open
//! ```

use super::campaign::Campaign;
use super::linear_reversal::LinearReversal;
use super::noise::Noise;
use super::readings::CorrectedRun;
use super::separate::{Separation, of_start};
use super::start::Start;
use super::uncertainty::of_length_ppm;
use crate::inputs::job::{DiagonalMeasurement, StatedUncertainty};
use crate::quantity::axis::{Axis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};

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
    let nodes = campaign.measurement.volume.last_node(PathKind::Step) + 1;
    let walks = (1..=runs).flat_map(|number| passes.iter().map(move |pass| (number, *pass)));
    let run = |(number, pass), diagonal| CorrectedRun {
        diagonal,
        number,
        pass,
        readings_um: vec![0.0; nodes],
    };
    let all = walks.flat_map(|walk| Diagonal::ALL.map(|diagonal| run(walk, diagonal)));
    let mut start = Start::of(campaign, all.collect(), campaign.measurement.material);
    start.noise = start.noise.map(|noise| Noise { sigma_um: noise_um, ..noise });
    start.expected_um = Some(noise_um);
    start.change_um.clone_from(change_um);
    of_start(campaign, &start)
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
