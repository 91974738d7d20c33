//! What goes into a separation beside the readings: how it was measured, lines; from a job and the tables it names.

use super::corrections::{AngleEffects, falls_short};
use super::curves::{at, mean};
use crate::inputs::error_table::{Cause, ErrorTable, Kind, Silence};
use crate::inputs::job::{
    Beam, DiagonalMeasurement, Job, Linear, LinearSlope, SetUp, StatedUncertainty,
};
use crate::machine::model::measured::{check_zeros, has_angles, no_angles};
use crate::quantity::{Axis, Direction, Millimetres, PerAxis, Volume, unit};
use crate::text::{Problem, Problems};
use serde::Serialize;

/// What goes into a separation beside the readings.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// How it was measured.
    pub measurement: &'a DiagonalMeasurement,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Slopes of single axes and other beams.
    pub lines: Vec<MeasuredLine>,
    /// Reversal of single axes from linear measurements in both directions.
    pub reversals: LinearReversals,
    /// Effects of angular errors on the readings.
    pub angles: AngleEffects,
    /// Whether reverse readings count from the forward start; else only their increments hold.
    pub reverse_zero_known: bool,
}

impl Campaign<'_> {
    /// What the job leaves unsaid, or says to be nothing.
    pub(super) fn silence(&self) -> Silence {
        let stated = &self.stated;
        let is_perfect = self.measurement.setup == SetUp::AssumePerfect;
        let lacks_u = self.lines.iter().any(|line| line.u_um_per_m.is_none());
        let all = [
            (Cause::Angles, !self.angles.evidence.missing.is_empty(), stated.angle_urad),
            (Cause::SetUps, true, stated.setup_ppm),
            (Cause::Slopes, lacks_u, None),
            (Cause::Tilt, is_perfect, stated.tilt_arcsec),
        ];
        let of = |is: fn(Option<f64>) -> bool| {
            let found = all.into_iter().filter(|(_, is_open, bound)| *is_open && is(*bound));
            found.map(|(cause, ..)| cause).collect()
        };
        Silence {
            not_stated: of(|bound| bound.is_none()),
            neglected: of(|bound| bound.is_some_and(|bound| bound <= 0.0)),
        }
    }
}

/// A straight line beside the diagonals; the uncertainty where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLine {
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
        let (table, volume) = (table.as_ref(), &measurement.volume);
        let Some((line, ways)) = problems.take(linear_line(volume, linear, table)) else {
            continue;
        };
        lines.push(line);
        let known = &mut reversals[linear.axis];
        *known = known.take().or_else(|| reversal(&ways));
    }
    lines.extend(measurement.beams.iter().map(beam_line));
    let angles = tables.angles.as_ref().map(|table| angles(job, measurement, table));
    let angles = angles.and_then(|angles| problems.take(angles));
    problems.or_ok(Campaign {
        measurement,
        stated: job.measurement.uncertainty,
        lines,
        reversals,
        angles: angles.unwrap_or_else(|| AngleEffects::unmeasured(job.machine.chain)),
        reverse_zero_known,
    })
}

/// What is known of a value, µm.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct Estimate {
    /// The value.
    pub um: f64,
    /// Its standard uncertainty (k = 1); `None` = not known.
    pub u_um: Option<f64>,
}

impl Estimate {
    /// The difference to another, the two apart.
    fn less(self, other: Estimate) -> Estimate {
        let u_um = self.u_um.zip(other.u_um).map(|(u, other)| u.hypot(other));
        Estimate { um: self.um - other.um, u_um }
    }
}

/// A linear measurement of an axis in a direction, at the interval ends of the box, lowest first.
type Way = (Option<Direction>, Vec<Estimate>);

/// B of positioning errors by linear measurements in both directions, moving + minus moving −, at the interval ends of
/// the box, lowest first; `None` = there is none.
pub type LinearReversals = PerAxis<Option<Vec<Estimate>>>;

/// B where an axis was measured in both directions.
fn reversal(ways: &[Way]) -> Option<Vec<Estimate>> {
    let [plus, minus] = Direction::BOTH.map(|own| ways.iter().find(|(way, _)| *way == Some(own)));
    Some(plus?.1.iter().zip(&minus?.1).map(|(plus, minus)| plus.less(*minus)).collect())
}

/// The slope of a linear axis, and the directions in which its table gives it.
///
/// formula  positioning error at the high end of the box less that at its low end, by the length between; mean of the
///          directions: the totals of the diagonals see the same two ends. u = √(u²(high) + u²(low)) by the length, the
///          directions taken as wrong alike; `None` without a `u_…` column
fn linear_line(
    volume: &Volume,
    linear: &Linear,
    table: Option<&ErrorTable>,
) -> Result<(MeasuredLine, Vec<Way>), Problems> {
    let axis = linear.axis;
    let (stated, ways) = match (&linear.slope, table) {
        (LinearSlope::Stated(slope), _) => (Some(*slope), Vec::new()),
        (LinearSlope::Errors(_), Some(table)) => (None, over_box(volume, axis, table)?),
        _ => {
            let words = format!("the slope of axis {axis} is not stated");
            return Err(Problem::new(words).help("state `slope_um_per_m`").into());
        }
    };
    let per_m = 1000.0 / volume.size[axis].mm();
    let rises = ways.iter().map(|(_, way)| way[volume.steps].less(way[0]));
    let u: Option<Vec<f64>> = rises.clone().map(|rise| rise.u_um).collect();
    let u = u.filter(|u| !u.is_empty()).map(|u| per_m * mean(u.into_iter()));
    let line = MeasuredLine {
        direction: unit(axis),
        slope_um_per_m: stated.unwrap_or_else(|| per_m * mean(rises.map(|rise| rise.um))),
        u_um_per_m: linear.u_um_per_m.or(u),
        ends: None,
    };
    Ok((line, ways))
}

/// A linear measurement at the interval ends of the box.
fn over_box(volume: &Volume, axis: Axis, table: &ErrorTable) -> Result<Vec<Way>, Problems> {
    let is_measured = format!("E{axis}{axis} is");
    let mut ways = Vec::new();
    for series in table.series(axis) {
        let own = Kind::Deviation(axis);
        let Some(um) = series.values.get(&own) else { continue };
        let short = falls_short(table, series, (volume, axis), (&is_measured, "the axis"));
        short.map_or(Ok(()), Err)?;
        let here = |node: &Millimetres, um: &[f64]| at(&series.positions, um, node.mm());
        let u_um = series.uncertainties.get(&own);
        let of = |node| Estimate { um: here(node, um), u_um: u_um.map(|u| here(node, u)) };
        ways.push((series.direction, volume.positions(axis).iter().map(of).collect()));
    }
    if ways.is_empty() {
        let words = format!(
            "the table holds no positioning error of {axis} (E{axis}{axis}), expected its linear measurement"
        );
        let help = "name a table with rows of that axis and its own direction";
        return Err(Problem::new(words).at(table.header.clone()).help(help).into());
    }
    Ok(ways)
}

/// A beam between two places inside the box, as the job was checked for.
fn beam_line(beam: &Beam) -> MeasuredLine {
    let way = PerAxis::from_fn(|axis| (beam.to[axis] - beam.from[axis]).mm());
    MeasuredLine {
        direction: PerAxis::from_fn(|axis| way[axis] / way.length()),
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
    let (chain, levers) = (job.chain_for_angles("measurement.angles")?, job.measurement.levers);
    if let Some(problem) = no_angles(table) {
        return Err(problem.into());
    }
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let (within, words) = ((&measurement.volume, axis), format!("the angles of {axis} are"));
        let measured = table.series(axis).iter().filter(|series| has_angles(series));
        let short = measured.filter_map(|s| falls_short(table, s, within, (&words, "the angles")));
        short.for_each(|problem| problems.push(problem));
    }
    check_zeros(job, table, &mut problems);
    problems.or_ok(())?;
    let origin = levers.origin(&job.machine.axes);
    Ok(AngleEffects::of_table(table, (chain.order(), levers, origin), measurement))
}
