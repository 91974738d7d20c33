//! What is known of the uncertainty of measured values.
//!
//! Every curve is zero at the reference, so a value is a difference of two of the table:
//!
//! ```text
//!   u²(x) = u_value²(x) + u_value²(reference) + (laser · |x − reference|)²      u_value² = column² + noise²
//! ```
//! and 0 at the reference itself. The values of a table are taken as independent of each other, which
//! is cautious for differences to the reference where they rise together. The scale of the laser is one
//! error of all positions and axes: along a diagonal it counts once ([`laser_um_per_m`]). A table that `separate` wrote states u = 0 where its curves
//! are zero and holds noise and scale of the laser already.

use crate::inputs::error_table::Series;
use crate::inputs::job::{Job, MachineAxis, MeasuredData};
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{Millimetres, larger};

/// Positions closer than this are one, mm.
const SAME_PLACE_MM: f64 = 1e-6;

/// Standard uncertainty (k = 1) at one measured position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointUncertainty {
    /// The way the axis travelled; `None` = both.
    pub direction: Option<Direction>,
    /// Where.
    pub at: Millimetres,
    /// Of the value by itself, without the scale of the laser, µm.
    pub value_um: f64,
    /// Of the value against that at the reference, µm.
    pub u_um: f64,
}

/// The uncertainty of a term at each of its positions; empty = not stated.
pub(super) fn points(
    job: &Job,
    series: &[Series],
    term: ErrorTerm,
    axis: MachineAxis,
) -> Vec<PointUncertainty> {
    let noise_um = match job.measurement.data {
        MeasuredData::Errors(_) => job.measurement.uncertainty.noise_um,
        MeasuredData::Diagonals(_) => None, // their table holds it
    };
    let noise_um = noise_um.filter(|noise| *noise > 0.0); // 0 states nothing
    let laser_um_per_m = laser_um_per_m(job).filter(|_| term.is_positioning());
    let measured = || series.iter().filter(|s| s.deviations[term.of].is_some());
    let column = measured().any(|s| s.uncertainties_um[term.of].is_some());
    if !column && noise_um.is_none() && laser_um_per_m.is_none() {
        return Vec::new();
    }
    let (noise_um, laser) = (noise_um.unwrap_or(0.0), laser_um_per_m.unwrap_or(0.0));
    let homing = measured().find(|s| s.direction == Some(axis.homing()));
    let zeroed = homing.or(measured().next());
    let at_zero = zeroed.and_then(|s| nearest_um(s, term, axis.reference));
    let at_zero = at_zero.unwrap_or(0.0).hypot(noise_um);
    let mut points = Vec::new();
    for s in measured() {
        let column = s.uncertainties_um[term.of].as_ref();
        for (row, at) in s.positions.iter().enumerate() {
            let from_zero = (*at - axis.reference).mm().abs();
            let own = column.and_then(|c| c.get(row)).copied().unwrap_or(0.0);
            let value_um = own.hypot(noise_um);
            let reach_um = laser * from_zero / 1000.0;
            let is_zero = from_zero <= SAME_PLACE_MM && zeroed.is_some_and(|z| std::ptr::eq(z, s));
            let u_um = if is_zero {
                0.0
            } else {
                value_um.hypot(at_zero).hypot(reach_um)
            };
            points.push(PointUncertainty {
                direction: s.direction,
                at: *at,
                value_um,
                u_um,
            });
        }
    }
    points
}

/// Scale of the laser that the job states beside its table, µm/m; separated readings hold it already.
pub(super) fn laser_um_per_m(job: &Job) -> Option<f64> {
    let stated = job.measurement.uncertainty.laser_ppm;
    let beside = matches!(job.measurement.data, MeasuredData::Errors(_));
    stated.filter(|ppm| beside && *ppm > 0.0)
}

/// The column's u where the curve is zeroed, µm: of the row at the reference, else the larger of its
/// neighbours.
fn nearest_um(series: &Series, term: ErrorTerm, reference: Millimetres) -> Option<f64> {
    let column = series.uncertainties_um[term.of].as_ref()?;
    let behind = |at: &Millimetres| at.mm() >= reference.mm() - SAME_PLACE_MM;
    let last = series.positions.len().checked_sub(1)?;
    let above = series.positions.iter().position(behind).unwrap_or(last);
    let is_there = (series.positions[above] - reference).mm() <= SAME_PLACE_MM;
    let below = if is_there {
        above
    } else {
        above.saturating_sub(1)
    };
    let of = |row: usize| column.get(row).copied();
    let (above, below) = (of(above)?, of(below)?);
    Some(larger(above, below))
}
