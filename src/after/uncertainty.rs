//! What is known of the uncertainty of as-left figures.
//!
//! A figure is the largest |d(x) − d(reference)|, so its uncertainty holds two values of the table
//! and the length between them:
//!
//! ```text
//!   u² = u²(x) + u²(reference) + (laser · |x − reference|)²      the largest over the positions
//! ```
//! A value's u is that of its `u_…` column and of `noise_um`, taken as independent of its
//! neighbours. A table that `separate` wrote states u = 0 where its curves are zero, and holds the
//! scale of the laser already.

use super::MeasuredCurves;
use crate::axis::{ErrorTerm, PerTerm};
use crate::error_table::{ErrorTable, Series};
use crate::forecast::Forecast;
use crate::job::{Job, MachineAxis, MeasuredData};
use crate::model::ErrorModel;
use crate::problem::Problems;
use crate::units::{Millimetres, Squared};

/// Positions closer than this are one, mm.
const SAME_PLACE_MM: f64 = 1e-6;

/// The curves of a second measurement, with the uncertainty of their figures.
pub fn measured_curves(job: &Job, table: &ErrorTable) -> Result<MeasuredCurves, Problems> {
    let model = ErrorModel::build(job, table)?;
    let stated = Stated::of(job);
    let u_um = PerTerm::from_fn(|term| {
        let axis = job.machine.axes[term.along]?;
        let measured = model.terms[term].as_ref();
        measured.and_then(|_| figure_u_um(table.series(term.along), term, axis, &stated))
    });
    Ok(MeasuredCurves {
        model,
        u_um,
        scale_um_per_m: stated.scale_um_per_m,
    })
}

/// What a job states beside its table; what separated readings hold already is left out.
struct Stated {
    noise_um: Option<f64>,
    scale_um_per_m: f64,
}

impl Stated {
    fn of(job: &Job) -> Stated {
        let own = &job.measurement.uncertainty;
        match job.measurement.data {
            MeasuredData::Errors(_) => Stated {
                noise_um: own.noise_um,
                scale_um_per_m: own.laser_ppm.unwrap_or(0.0),
            },
            MeasuredData::Diagonals(_) => Stated {
                noise_um: None,
                scale_um_per_m: 0.0,
            },
        }
    }
}

fn figure_u_um(
    series: &[Series],
    term: ErrorTerm,
    axis: MachineAxis,
    stated: &Stated,
) -> Option<f64> {
    let scale = if term.is_positioning() {
        stated.scale_um_per_m
    } else {
        0.0
    };
    let zero = series.iter().find(|s| s.direction == Some(axis.homing()));
    let zero = zero.or(series.first())?;
    let at_zero = nearest_u_um(zero, term, axis.reference);
    let known = at_zero.or(stated.noise_um).is_some() || scale > 0.0;
    let rows = series.iter().flat_map(|s| {
        let column = s.uncertainties_um[term.of].as_ref();
        let row = move |(index, at): (usize, &Millimetres)| {
            let reach_um = scale * (*at - axis.reference).mm().abs() / 1000.0;
            let own = column.and_then(|c| c.get(index)).copied();
            own.unwrap_or(0.0).hypot(reach_um)
        };
        s.positions.iter().enumerate().map(row)
    });
    let noise = std::f64::consts::SQRT_2 * stated.noise_um.unwrap_or(0.0);
    let zero = at_zero.unwrap_or(0.0).hypot(noise);
    let largest = rows.reduce(f64::max)?;
    known.then(|| largest.hypot(zero))
}

/// u where the curve is zeroed: of the row at the reference, else the larger of its neighbours.
fn nearest_u_um(series: &Series, term: ErrorTerm, reference: Millimetres) -> Option<f64> {
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
    Some(of(above)?.max(of(below)?))
}

/// The same figures with these uncertainties; along a diagonal the laser's scale acts over its
/// length.
pub(super) fn counted(mut figures: Forecast, curves: &MeasuredCurves) -> Forecast {
    for term in &mut figures.terms {
        term.u_um = curves.u_um[term.term];
    }
    let lengths = curves.model.ranges.iter();
    let squares = lengths.filter_map(|(_, range)| range.map(|(a, b)| (b - a).mm().squared()));
    let scale_um = curves.scale_um_per_m * squares.sum::<f64>().sqrt() / 1000.0;
    for diagonal in &mut figures.diagonals {
        diagonal.u_um = diagonal.u_um.map(|u| u.hypot(scale_um));
    }
    figures
}
