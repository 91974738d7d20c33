//! Files of a user → the measurement with the tables active.

use crate::after::{AfterMeasurement, ensure_same_machine, measured_curves};
use crate::cli::inputs::{self, file_name, read_argument};
use crate::diagonal::PathKind;
use crate::document::Source;
use crate::error_table::ErrorTable;
use crate::job::{Job, MeasuredData};
use crate::kit::{Inputs, hashed};
use crate::manifest::HashedFile;
use crate::problem::{Place, Problem, Problems};
use std::path::Path;

/// A second measurement, and every file that it was read from.
pub(super) struct Second {
    pub(super) measurement: AfterMeasurement,
    pub(super) hashes: Vec<HashedFile>,
}

/// Reads an error table, or a job with errors, readings or straight diagonals.
pub(super) fn read(first: &Inputs, path: &Path) -> Result<Second, Problems> {
    let (name, bytes) = read_argument(path)?;
    let mut hashes = vec![hashed(&file_name(path), &bytes)];
    let source = Source::from_bytes(&name, &bytes)?;
    let measurement = if is_job(path, &source.text) {
        let folder = path.parent().unwrap_or(Path::new(""));
        of_job(first, &Job::read(source)?, folder, &mut hashes)?
    } else {
        of_table(first, source)?
    };
    Ok(Second {
        measurement,
        hashes,
    })
}

/// A job is a `.toml` file, or begins with a key or a section.
fn is_job(path: &Path, text: &str) -> bool {
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let lines = text.lines().map(str::trim);
    let mut content = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    let begins = content.next().is_some_and(|line| line.contains(['=', '[']));
    ending.is_some_and(|ending| ending == "toml") || begins
}

/// An error table counts in the coordinates of the first job.
fn of_table(first: &Inputs, source: Source) -> Result<AfterMeasurement, Problems> {
    refuse_readings(&source)?;
    let table = ErrorTable::read(source)?;
    if !first.job.measurement.squareness.is_empty() {
        return Err(Problem::new(
            "the first job adds `squareness_um_per_m` to its errors; whether the slopes of this table hold the squareness is not stated",
        )
        .at(table.header.clone())
        .help("give a job with `errors` and its own `squareness_um_per_m` (none, if the slopes hold it)")
        .into());
    }
    Ok(AfterMeasurement::Errors(Box::new(measured_curves(
        &first.job, &table,
    )?)))
}

/// Readings by themselves do not say how they were taken.
fn refuse_readings(source: &Source) -> Result<(), Problem> {
    let mut lines = source.text.lines().zip(1..);
    let is_head = |line: &str| !line.trim().is_empty() && !line.starts_with('#');
    let head = lines.find(|(line, _)| is_head(line));
    match head.filter(|(line, _)| line.to_ascii_lowercase().contains("diagonal")) {
        None => Ok(()),
        Some((text, line)) => Err(Problem::new(
            "these are readings of the diagonals, expected an error table (CSV) or a job (TOML)",
        )
        .at(Place {
            line,
            ..Place::in_text(&source.name, text, 0, text.len())
        })
        .help(
            "write a job that names them with `readings = …`: how they were walked stands there",
        )),
    }
}

fn of_job(
    first: &Inputs,
    job: &Job,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<AfterMeasurement, Problems> {
    ensure_same_machine(&first.job, job)?;
    if let MeasuredData::Diagonals(measurement) = &job.measurement.data
        && measurement.kind == PathKind::Straight
    {
        let files = inputs::campaign_files(job, measurement, folder, hashes)?;
        return Ok(AfterMeasurement::Diagonals(files.straight_runs()?));
    }
    let table = inputs::error_table(job, folder, hashes)?;
    Ok(AfterMeasurement::Errors(Box::new(measured_curves(
        job, &table,
    )?)))
}
