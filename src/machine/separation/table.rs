//! Nine errors → the rows of an error table (contract §2.1), as the backlash policy of a job asks for them.

use super::Separation;
use super::joint::{JointTable, directions};
use super::readings::Noise;
use super::solved::SeparatedError;
use crate::inputs::error_table::{self, Draft, ErrorTable, Kind, Remarks, Series};
use crate::inputs::job::{BacklashPolicy, Job};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, PerAxis, rounded};
use crate::text::{Finding, Problem, Problems, Source, joined};
use std::borrow::Cow;
use std::cmp::Reverse;
use std::sync::Arc;

/// Where the errors of a job come from. Of readings the table depends on the policy that the job has for the
/// reversal, so it is made anew for each.
#[derive(Clone, Debug)]
pub enum ErrorSource {
    /// A table, whatever the policy is.
    Table(Arc<ErrorTable>),
    /// Readings that were separated.
    Separated {
        /// The nine errors.
        separation: Arc<Separation>,
        /// File of the readings.
        readings: String,
        /// What the table says of where it comes from.
        comments: Vec<String>,
    },
}

impl From<&ErrorTable> for ErrorSource {
    fn from(table: &ErrorTable) -> ErrorSource {
        ErrorSource::Table(Arc::new(table.clone()))
    }
}

impl ErrorSource {
    /// The errors of a job, of readings as the very table that `separate -o` writes.
    pub fn table(&self, job: &Job) -> Result<Cow<'_, ErrorTable>, Problems> {
        match self {
            ErrorSource::Table(table) => Ok(Cow::Borrowed(table)),
            ErrorSource::Separated { separation, readings, comments } => {
                check_policy(job, separation)?;
                let text = error_table::write(&draft(separation, job, comments.clone()));
                let name = format!("nine errors separated from {readings}");
                Ok(Cow::Owned(ErrorTable::read(Source::from_bytes(&name, text.as_bytes())?)?))
            }
        }
    }
}

/// The table that `separate` writes and `generate` reads. Terms that are not determined are
/// absent. Directions stand apart only where the reversal between them is determined; without it
/// a job that asks for the curves moving + gets these alone, any other one the mean of both.
pub fn draft(separation: &Separation, job: &Job, mut comments: Vec<String>) -> Draft {
    let directions = directions(separation, job);
    comments.extend(JointTable::new(separation, job).remarks(job, remarks(separation)).lines());
    let of_axis = |axis| directions[axis].iter().map(move |way| (axis, *way));
    let series = Axis::ALL.into_iter().flat_map(of_axis);
    let series = series.map(|(axis, way)| one_series(separation, axis, way));
    Draft { comments, series: series.collect() }
}

/// What the table has to say of itself, so that it reaches whoever uses the table.
pub fn remarks(separation: &Separation) -> Remarks {
    let missing = separation.missing();
    // The reversal is no term of its own.
    let is_other = |found: &Finding| {
        missing.is_empty() || matches!(found.kind(), Some(SeparationFinding::OpenReversal { .. }))
    };
    let undetermined = separation.undetermined.iter().cloned();
    let (other, open): (Vec<_>, Vec<_>) = undetermined.partition(is_other);
    let why = open.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    let other = other.into_iter().map(|what| SeparationFinding::StillOpen { what }.into());
    let evidence = &separation.evidence;
    let lines = || PerAxis::from_fn(|axis| Millimetres::new(evidence.origin[axis]));
    let mut labels = separation.labels.clone();
    labels.sort_by_key(|label| Reverse(label.severity())); // what the readings say of themselves first
    let notes = other.chain(labels).collect();
    Remarks {
        doubts: separation.doubts.clone(),
        not_determined: missing.into_iter().map(|term| (term, why.clone())).collect(),
        hidden_reversal_um: separation.hidden_reversal_um,
        degrees_of_freedom: separation.noise.and_then(Noise::freedom_f64),
        silence: separation.silence.clone(),
        frame: Some(separation.frame),
        lines: evidence.has_angles().then(lines),
        notes,
        ..Remarks::default()
    }
}

fn one_series(separation: &Separation, axis: Axis, direction: Option<Direction>) -> Series {
    let mut series = Series::new(axis, direction, separation.volume.positions(axis));
    for of in Axis::ALL {
        let found = separation.of_table(ErrorTerm { of, along: axis }, direction);
        let of = Kind::Deviation(of);
        series.values.extend(found.map(|found| (of, written(&found.deviation_um))));
        let u_um = found.and_then(SeparatedError::u_um);
        series.uncertainties.extend(u_um.map(|u_um| (of, written(&u_um))));
    }
    series
}

/// Nine decimals, 10⁻⁹ µm: as many as readings carry, without the dust of binary sums.
fn written(values_um: &[f64]) -> Vec<f64> {
    values_um.iter().map(|um| rounded(*um, 9)).collect()
}

/// Readings in both directions need a word on the reversal, even where they do not determine it.
fn check_policy(job: &Job, separation: &Separation) -> Result<(), Problem> {
    if !separation.is_both_ways() {
        return Ok(());
    }
    let open = Axis::ALL.into_iter().filter(|axis| !separation.is_directed(*axis));
    let policy = |axis: &Axis| job.compensation.backlash[*axis];
    if open.clone().any(|axis| policy(&axis).is_none()) {
        return Err(job
            .problem_at("compensation", "the readings were taken in both directions, but `backlash` is not stated; there is no default")
            .help("write `backlash = \"mean\"` or \"forward-only\"; the reversal of each axis is not determined by these readings"));
    }
    let both = [Some(BacklashPolicy::TwoTables), Some(BacklashPolicy::CurveAndParameter)];
    let needed = joined(open.filter(|axis| both.contains(&policy(axis))));
    if needed.is_empty() {
        return Ok(());
    }
    let words = format!(
        "this needs the reversal of each axis, which these readings do not determine for {needed}"
    );
    Err(job.problem_at("compensation.backlash", words)
        .help("turn once without overrun at the far end of the diagonals, or name a linear measurement of each axis with rows of both directions (`errors` of [[measurement.step_diagonal.linear]]), or use `backlash = \"mean\"`"))
}
