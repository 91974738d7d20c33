//! What is left of every error, at the positions where it was measured: an error table.

use super::{Noise, SimulatedMachine, written};
use crate::inputs::error_table::{Draft, DraftSeries};
use crate::machine::model::Measured;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::quantity::units::{Millimetres, SAME_PLACE_MM, Squared};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// The errors that single-axis measurements would show, mean of `runs`; relative to the
/// reference. With noise the table states it as uncertainty (k = 1), less what its job states for every value
/// (`noise_um`), in squares.
pub fn single_axes(
    machine: &SimulatedMachine<'_>,
    runs: u32,
    (noise, stated_um): (Noise, Option<f64>),
    comments: Vec<String>,
) -> Draft {
    let mut series = Vec::new();
    for axis in Axis::ALL {
        for direction in directions(machine, axis) {
            let stream = series.len() as u64;
            let noise = OneSeries::new(runs, noise, stream, stated_um.unwrap_or(0.0));
            series.push(one_series(machine, axis, direction, noise));
        }
    }
    Draft { comments, series }
}

/// The directions that an axis has rows for; `None` = both alike.
fn directions(machine: &SimulatedMachine<'_>, axis: Axis) -> Vec<Option<Direction>> {
    let terms = machine.model.measured();
    let mut measured = terms.filter(|(term, _)| term.along == axis).peekable();
    if measured.peek().is_none() || machine.model.ranges[axis].is_none() {
        return Vec::new();
    }
    let one_way = measured.find_map(|(_, term)| match term.measured {
        Measured::OneWay(direction, _) => Some(direction),
        _ => None,
    });
    match one_way {
        Some(direction) => vec![Some(direction)],
        None if machine.is_directed(axis) => Direction::BOTH.map(Some).into(),
        None => vec![None],
    }
}

/// The noise of one series.
struct OneSeries {
    random: ChaCha8Rng,
    /// Standard deviation of a mean over the runs, µm.
    u_um: f64,
    /// What the columns state of it, beside `noise_um` of the job, µm.
    column_um: f64,
}

impl OneSeries {
    fn new(runs: u32, noise: Noise, stream: u64, stated_um: f64) -> OneSeries {
        let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
        random.set_stream(stream);
        let u_um = noise.um / f64::from(runs).sqrt();
        let more = u_um.squared() - stated_um.squared();
        OneSeries { random, u_um, column_um: more.max(0.0).sqrt() }
    }

    fn draw(&mut self) -> f64 {
        let draw: f64 = StandardNormal.sample(&mut self.random);
        self.u_um * draw
    }
}

fn one_series(
    machine: &SimulatedMachine<'_>,
    axis: Axis,
    direction: Option<Direction>,
    mut noise: OneSeries,
) -> DraftSeries {
    let positions = positions_mm(machine, axis);
    let moving = direction.unwrap_or(Direction::Plus);
    let mut series = DraftSeries::new(axis, direction, positions.clone());
    series.deviations_um = PerAxis::from_fn(|of| {
        let term = ErrorTerm { of, along: axis };
        let at = |mm: &f64| machine.left_um(term, moving, Millimetres::new(*mm));
        let left: Option<Vec<f64>> = positions.iter().map(at).collect();
        let noisy = |um: f64| written(um + noise.draw());
        Some(left?.into_iter().map(noisy).collect())
    });
    if noise.column_um > 0.0 {
        let stated =
            |known: &Option<Vec<f64>>| known.as_ref().map(|k| vec![noise.column_um; k.len()]);
        series.uncertainties_um = PerAxis::from_fn(|of| stated(&series.deviations_um[of]));
    }
    series
}

/// Positions at which any error of an axis was measured, inside the range of all of them.
fn positions_mm(machine: &SimulatedMachine<'_>, axis: Axis) -> Vec<f64> {
    let Some((low, high)) = machine.model.ranges[axis] else {
        return Vec::new();
    };
    let terms = machine.model.measured();
    let mut positions: Vec<f64> = terms
        .filter(|(term, _)| term.along == axis)
        .flat_map(|(_, measured)| measured.curves().flat_map(|curve| curve.knots().to_vec()))
        .map(|knot| knot.mm())
        .filter(|mm| (low.mm()..=high.mm()).contains(mm))
        .collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|a, b| (*a - *b).abs() < SAME_PLACE_MM);
    positions
}
