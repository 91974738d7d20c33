//! A job and the tables it names → what a separation needs beside the readings.

use super::campaign::{Campaign, Line};
use super::corrections::{AngleEffects, AngleModel, angle_effects};
use super::linear_reversal::{self, LinearReversals};
use super::lookup::at;
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{Beam, DiagonalMeasurement, Job, Linear, LinearSlope};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::Volume;
use crate::text::problem::{Problem, Problems};

/// How far a table may fall short of the measured box, mm.
const END_TOLERANCE_MM: f64 = 0.01;

/// Error tables that a job with readings names.
#[derive(Clone, Debug, Default)]
pub struct NamedTables {
    /// For each `[[measurement.step_diagonal.linear]]`, in the order of the job; `None` where the
    /// slope is stated.
    pub linear: Vec<Option<ErrorTable>>,
    /// `measurement.angles`.
    pub angles: Option<ErrorTable>,
}

/// The campaign of a job.
pub fn campaign<'a>(
    job: &Job,
    measurement: &'a DiagonalMeasurement,
    tables: &NamedTables,
    reverse_zero_known: bool,
) -> Result<Campaign<'a>, Problems> {
    let mut problems = Problems::none();
    let mut lines = Vec::new();
    let mut reversals = LinearReversals::default();
    for (linear, table) in measurement.linear.iter().zip(&tables.linear) {
        let table = table.as_ref();
        lines.extend(problems.take(linear_line(&measurement.volume, linear, table)));
        let found =
            table.and_then(|t| linear_reversal::of_table(&measurement.volume, linear.axis, t));
        if let Some(found) = found {
            reversals[linear.axis].get_or_insert(found);
        }
    }
    lines.extend(measurement.beams.iter().map(beam_line));
    let angles = match &tables.angles {
        None => Some(AngleEffects::unmeasured(job.machine.chain)),
        Some(table) => problems.take(angles(job, measurement, table)),
    };
    problems.or_ok(Campaign {
        measurement,
        stated: job.measurement.uncertainty,
        lines,
        reversals,
        angles,
        reverse_zero_known,
    })
}

fn linear_line(
    volume: &Volume,
    linear: &Linear,
    table: Option<&ErrorTable>,
) -> Result<Line, Problems> {
    let (slope_um_per_m, u_of_table) = match (&linear.slope, table) {
        (LinearSlope::Stated(slope), _) => (*slope, None),
        (LinearSlope::Errors(path), None) => {
            return Err(Problem::new(format!("`{path}` was not read")).into());
        }
        (LinearSlope::Errors(_), Some(table)) => slope_over_box(volume, linear.axis, table)?,
    };
    Ok(Line {
        direction: PerAxis::from_fn(|axis| f64::from(axis == linear.axis)),
        slope_um_per_m,
        u_um_per_m: linear.u_um_per_m.or(u_of_table),
        ends: None,
    })
}

/// Positioning error at the high end of the box less that at its low end, by the length between;
/// mean of the directions. The totals of the diagonals see the same two ends. Its standard
/// uncertainty from the `u_…` column: √(u²(high) + u²(low)) by the length, the directions taken as
/// wrong alike; `None` without such a column.
fn slope_over_box(
    volume: &Volume,
    axis: Axis,
    table: &ErrorTable,
) -> Result<(f64, Option<f64>), Problems> {
    let low = volume.start[axis].mm();
    let high = low + volume.size[axis].mm();
    let refuse = |message: String, help: &str| {
        Problems::from(Problem::new(message).at(table.header.clone()).help(help))
    };
    let (mut slopes, mut uncertainties) = (Vec::new(), Vec::new());
    for series in table.series(axis) {
        let Some(values) = &series.deviations[axis] else {
            continue;
        };
        let ends = series.positions.first().zip(series.positions.last());
        if let Some((first, last)) = ends
            && (first.mm() > low + END_TOLERANCE_MM || last.mm() < high - END_TOLERANCE_MM)
        {
            return Err(refuse(
                format!(
                    "E{axis}{axis} is measured from {} to {} mm, but the diagonals go from {low} to {high} mm",
                    first.mm(),
                    last.mm()
                ),
                "measure the axis over the whole box; nothing is extrapolated",
            ));
        }
        let values: Vec<f64> = values.iter().map(|value| value.um()).collect();
        let rise = at(&series.positions, &values, high) - at(&series.positions, &values, low);
        slopes.push(1000.0 * rise / (high - low));
        uncertainties.extend(series.uncertainties_um[axis].as_ref().map(|u| {
            let end = |position: f64| at(&series.positions, u, position);
            1000.0 * end(high).hypot(end(low)) / (high - low)
        }));
    }
    if slopes.is_empty() {
        return Err(refuse(
            format!(
                "the table holds no positioning error of {axis} (E{axis}{axis}), expected its linear measurement"
            ),
            "name a table with rows of that axis and its own direction",
        ));
    }
    #[allow(clippy::cast_precision_loss, reason = "two directions at most")]
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let all_known = uncertainties.len() == slopes.len();
    Ok((mean(&slopes), all_known.then(|| mean(&uncertainties))))
}

/// A beam between two places inside the box, as the job was checked for.
fn beam_line(beam: &Beam) -> Line {
    let way = PerAxis::from_fn(|axis| (beam.to[axis] - beam.from[axis]).mm());
    let length = (way.x * way.x + way.y * way.y + way.z * way.z).sqrt();
    Line {
        direction: PerAxis::from_fn(|axis| way[axis] / length),
        slope_um_per_m: beam.slope_um_per_m,
        u_um_per_m: beam.u_um_per_m,
        ends: Some([beam.from, beam.to]),
    }
}

/// What the angular errors of a table do to the readings of a measurement.
pub fn angles(
    job: &Job,
    measurement: &DiagonalMeasurement,
    table: &ErrorTable,
) -> Result<AngleEffects, Problems> {
    let Some(chain) = job.machine.chain else {
        return Err(job
            .problem_at("measurement.angles", "angles act through levers, which need the order of the axes: `machine.chain` is missing")
            .help("state it, e.g. `chain = \"wXYZt\"`")
            .into());
    };
    let levers = &job.measurement.levers;
    let origin = levers.origin(&job.machine.axes);
    let model = AngleModel::new(table, chain, (levers, origin), measurement.target);
    if model.is_empty() {
        return Err(Problem::new(format!(
            "`{}` holds no angles, expected columns such as `ea_urad`",
            table.source.name
        ))
        .at(table.header.clone())
        .help("name a table with ea, eb or ec, or remove `angles`")
        .into());
    }
    model.check(&measurement.volume)?;
    Ok(angle_effects(&model, &measurement.volume, measurement.kind))
}
