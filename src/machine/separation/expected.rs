//! A measurement that is still to be made: readings without any error go through the separation itself, so
//! what it says of uncertainty, degrees of freedom and what stays open is what it will say of the readings.
//!
//! ```text
//!   passes, runs ─→ corrected readings of 0 ─→ separation, σ = what is expected ─→ U, rank, what stays open
//! ```

use super::campaign::{Campaign, corrected};
use super::closure::Start;
use super::noise::Noise;
use super::separate::{Separation, of_start};
use super::uncertainty::Budget;
use crate::inputs::error_table::{Draft, DraftSeries, ErrorTable, write};
use crate::inputs::job::{DiagonalMeasurement, Linear, LinearSlope, StatedUncertainty};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run};
use crate::quantity::units::Deviation;
use crate::text::document::Source;
use crate::text::problem::Problems;

/// What is expected of a measurement before its readings exist: deviations of 0, with the uncertainties
/// that this many runs of these passes will have. `noise_um`: σ of a single reading. Whether the axes
/// overrun has to be stated where the return pass is one of the passes.
pub(crate) fn expected(
    campaign: &Campaign<'_>,
    passes: &[Pass],
    runs: u32,
    noise_um: f64,
) -> Separation {
    let of_noise = |noise: Noise| Noise { sigma_um: noise_um, ..noise };
    let mut start = Start::new(campaign, &exact(campaign, passes, runs));
    start.noise = start.noise.map(of_noise);
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

    /// Standard uncertainty of the slope over a whole axis, from so many runs in both directions, µm/m.
    ///
    /// formula  u² = 2σ²/(2r L²) + scale²: the mean of both directions at both ends
    pub(crate) fn of_slope_um_per_m(
        self,
        measurement: &DiagonalMeasurement,
        axis: Axis,
        runs: u32,
    ) -> f64 {
        let budget = Budget {
            volume: &measurement.volume,
            noise: None,
            runs: &PerDiagonal::default(),
            turned: false,
            stated: self.stated,
            material: measurement.material,
        };
        let ends = 1000.0 * self.of_mean_um(runs) / measurement.volume.size[axis].mm();
        ends.hypot(budget.of_length_ppm(axis))
    }
}

/// A linear measurement of an axis that is still to be made: at the positions of the diagonals, in both
/// directions, so many runs of the same instrument.
pub(crate) fn linear_axis(
    measurement: &DiagonalMeasurement,
    axis: Axis,
    instrument: Instrument,
    runs: u32,
) -> Result<(Linear, ErrorTable), Problems> {
    let at = measurement.volume.positions(axis);
    let at: Vec<f64> = at.iter().map(|position| position.mm()).collect();
    let series = Direction::BOTH.map(|direction| {
        let mut series = DraftSeries::new(axis, Some(direction), at.clone());
        series.deviations_um[axis] = Some(vec![0.0; at.len()]);
        series.uncertainties_um[axis] = Some(vec![instrument.of_mean_um(runs); at.len()]);
        series
    });
    let draft = Draft { comments: Vec::new(), series: series.into() };
    let name = format!("linear measurement of {axis}");
    let table = ErrorTable::read(Source::from_bytes(&name, write(&draft).as_bytes())?)?;
    let linear = Linear {
        axis,
        slope: LinearSlope::Errors(name),
        u_um_per_m: Some(instrument.of_slope_um_per_m(measurement, axis, runs)),
    };
    Ok((linear, table))
}
