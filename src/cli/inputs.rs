//! Files of a user → checked inputs.

mod active;
mod campaign;
mod files;

pub(super) use self::active::read as active_control;
pub(super) use campaign::{CampaignFiles, campaign_files, read_campaign};
pub(super) use files::{
    STANDARD_INPUT, beside_job, file_name, file_names, input_at, open, plain_words, read_argument,
    read_file, standard_input, with_suffix,
};

use crate::control::controller::{Origin, Profile, builtin, load};
use crate::inputs::error_table::{self, ErrorTable};
use crate::inputs::import::source_of;
use crate::inputs::job::ahead;
use crate::inputs::job::{BacklashPolicy, DiagonalMeasurement, Job, MeasuredData, UseOf};
use crate::kit::manifest::HashedFile;
use crate::kit::{Inputs, hashed};
use crate::machine::separation::Separation;
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::PathKind;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use std::path::Path;

/// Reads a job and everything it names, for tables.
pub(super) fn read(job_path: &Path) -> Result<Inputs, Problems> {
    read_for(job_path, UseOf::Tables)
}

/// Reads a job and everything it names, for what is asked of it.
pub(super) fn read_for(job_path: &Path, use_of: UseOf) -> Result<Inputs, Problems> {
    let (name, bytes) = read_argument(job_path)?;
    read_job(job_path, &name, &bytes, use_of)
}

/// Reads everything that a job names; `bytes` are those of the job.
pub(super) fn read_job(
    job_path: &Path,
    name: &str,
    bytes: &[u8],
    use_of: UseOf,
) -> Result<Inputs, Problems> {
    let mut hashes = vec![hashed(&file_name(job_path), bytes)];
    let folder = job_path.parent().unwrap_or(Path::new(""));
    let source = Source::from_bytes(name, bytes)?;
    let mut job = Job::read_for(source.clone(), use_of).map_err(|mut problems| {
        let find = |word: &str| profile(word, folder, &mut Vec::new());
        problems.extend(ahead(source, find));
        problems
    })?;
    if use_of == UseOf::Figures {
        job.compensation.backlash = job.compensation.backlash.or(Some(BacklashPolicy::Mean));
    }
    let mut problems = Problems::none();
    let profile = problems.take(
        profile(&job.compensation.controller, folder, &mut hashes)
            .map_err(|p| at_controller(&job, p)),
    );
    let table = problems.take(error_table(&job, folder, &mut hashes));
    match (profile, table) {
        (Some(profile), Some(table)) if problems.is_empty() => {
            let angles = angles_table(&job, folder, &mut hashes)?;
            let active = active::read(&job, &profile, folder, &mut hashes)?;
            let mut inputs = match use_of {
                UseOf::Tables => Inputs::new(job, profile, &table, hashes)?,
                UseOf::Figures => Inputs::for_figures(job, profile, &table, hashes)?,
            };
            if let Some(angles) = angles {
                inputs = inputs.with_angles(&angles)?;
            }
            match active {
                Some(active) => inputs.with_active(active),
                None => Ok(inputs),
            }
        }
        _ => Err(problems),
    }
}

/// Reads a job and everything it names, the angles of its readings included.
pub(super) fn read_with_angles(job_path: &Path) -> Result<(Inputs, Option<ErrorTable>), Problems> {
    let inputs = read(job_path)?;
    let job = &inputs.job;
    let diagonals = matches!(job.measurement.data, MeasuredData::Diagonals(_));
    let Some(path) = job.measurement.angles.as_ref().filter(|_| diagonals) else {
        return Ok((inputs, None));
    };
    let folder = job_path.parent().unwrap_or(Path::new(""));
    // The hash stands among the inputs already: the readings were separated with these angles.
    let (source, _) = read_named(job, folder, path, "measurement.angles", &mut Vec::new())?;
    let table = ErrorTable::read(source)?;
    Ok((inputs, Some(table)))
}

/// Reads a job and the profile of its control, and nothing that was measured.
pub(super) fn read_job_and_profile(
    job_path: &Path,
) -> Result<(Job, Profile, Vec<HashedFile>), Problems> {
    let (name, bytes) = read_argument(job_path)?;
    let mut hashes = vec![hashed(&file_name(job_path), &bytes)];
    let job = Job::read(Source::from_bytes(&name, &bytes)?)?;
    let folder = job_path.parent().unwrap_or(Path::new(""));
    let profile = profile(&job.compensation.controller, folder, &mut hashes)
        .map_err(|problems| at_controller(&job, problems))?;
    Ok((job, profile, hashes))
}

/// Problems without a place of their own concern the key that named the controller.
fn at_controller(job: &Job, problems: Problems) -> Problems {
    let mut placed = Problems::none();
    for problem in problems.iter() {
        let mut problem = problem.clone();
        if problem.place.is_none() {
            problem.place = job.source.place_of("compensation.controller");
        }
        placed.push(problem);
    }
    placed
}

pub(super) fn error_table(
    job: &Job,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<ErrorTable, Problems> {
    let paths = match &job.measurement.data {
        MeasuredData::Errors(paths) => paths,
        MeasuredData::Diagonals(measurement) => {
            return separated_table(job, measurement, folder, hashes);
        }
    };
    let mut problems = Problems::none();
    let mut tables = Vec::new();
    for path in paths {
        let source = read_named(job, folder, path, "measurement.errors", hashes);
        let table = source.and_then(|(source, _)| ErrorTable::read(source));
        tables.extend(problems.take(table));
    }
    let tables = problems.or_ok(tables)?;
    match ErrorTable::merged(tables)? {
        Some(table) => Ok(table),
        None => Err(job
            .problem_at("measurement.errors", "no error table is named")
            .into()),
    }
}

/// The table of angles that a job names. Where readings were separated it was read, and its hash
/// kept, before.
fn angles_table(
    job: &Job,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<Option<ErrorTable>, Problems> {
    let Some(path) = &job.measurement.angles else {
        return Ok(None);
    };
    let mut seen = Vec::new();
    let (source, _) = read_named(job, folder, path, "measurement.angles", &mut seen)?;
    if matches!(job.measurement.data, MeasuredData::Errors(_)) {
        hashes.extend(seen);
    }
    ErrorTable::read(source).map(Some)
}

/// A file that a job names at `key`, and its hash; the measurement that it came from is hashed too.
fn read_named(
    job: &Job,
    folder: &Path,
    path: &str,
    key: &str,
    hashes: &mut Vec<HashedFile>,
) -> Result<(Source, String), Problems> {
    let full = folder.join(path);
    let bytes = read_file(&full).map_err(|problem| match job.source.place_of(key) {
        Some(place) => beside_job(problem.at(place)),
        None => beside_job(problem),
    })?;
    let hash = hashed(path, &bytes);
    let sha256 = hash.sha256.clone();
    hashes.push(hash);
    let source = Source::from_bytes(&full.display().to_string(), &bytes)?;
    hashes.extend(imported_from(&source.text, path));
    Ok((source, sha256))
}

/// The measurement that an imported error table came from, as its comment states it.
fn imported_from(table: &str, path: &str) -> Option<HashedFile> {
    let (name, sha256) = source_of(table)?;
    Some(HashedFile {
        path: name,
        role: None,
        sha256,
        through: Some(path.to_string()),
    })
}

/// The nine errors of a job with readings.
fn separated_table(
    job: &Job,
    measurement: &DiagonalMeasurement,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<ErrorTable, Problems> {
    if measurement.kind == PathKind::Straight {
        return Err(job
            .problem_at(
                "measurement.step_diagonal.kind",
                "straight runs of the diagonals hold no nine errors, so there is nothing to compensate",
            )
            .help("measure in single-axis steps (`kind = \"step\"`); `nonius separate` prints what straight runs hold")
            .into());
    }
    table_of(&campaign_files(job, measurement, folder, hashes)?)
}

/// The nine errors of readings, as the very table that `separate -o` writes.
pub(super) fn table_of(files: &CampaignFiles) -> Result<ErrorTable, Problems> {
    let separation = files.separate()?;
    check_policy(&files.job, &separation)?;
    let text = error_table::write(&files.draft(&separation));
    let name = format!("nine errors separated from {}", files.measurement.readings);
    ErrorTable::read(Source::from_bytes(&name, text.as_bytes())?)
}

/// Readings in both directions need a word on the reversal, even where they do not determine it.
fn check_policy(job: &Job, separation: &Separation) -> Result<(), Problem> {
    let open: Vec<String> = Axis::ALL
        .into_iter()
        .filter(|axis| !separation.is_directed(*axis))
        .map(|axis| axis.to_string())
        .collect();
    if separation.means.reverse.is_none() || open.is_empty() {
        return Ok(());
    }
    match job.compensation.backlash {
        None => Err(job
            .problem_at("compensation", "the readings were taken in both directions, but `backlash` is not stated; there is no default")
            .help("write `backlash = \"mean\"` or \"forward-only\"; the reversal of each axis is not determined by these readings")),
        Some(BacklashPolicy::TwoTables | BacklashPolicy::CurveAndParameter) => Err(job
            .problem_at(
                "compensation.backlash",
                format!("this needs the reversal of each axis, which these readings do not determine for {}", open.join(", ")),
            )
            .help("turn once without overrun at the far end of the diagonals, or name a linear measurement of each axis with rows of both directions (`errors` of [[measurement.step_diagonal.linear]]), or use `backlash = \"mean\"`")),
        Some(BacklashPolicy::Mean | BacklashPolicy::ForwardOnly) => Ok(()),
    }
}

/// A built-in profile by id, or a user's own by path (relative to `folder`).
pub(super) fn profile(
    reference: &str,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<Profile, Problems> {
    let is_path =
        reference.to_ascii_lowercase().ends_with(".toml") || reference.contains(['/', '\\']);
    if !is_path {
        return builtin::profile(reference);
    }
    let path = folder.join(reference.strip_prefix("./").unwrap_or(reference));
    let bytes = read_file(&path).map_err(beside_job)?;
    hashes.push(hashed(reference, &bytes));
    let source = Source::from_bytes(&path.display().to_string(), &bytes)?;
    let beside = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let own_templates = std::cell::RefCell::new(Vec::new());
    let unreadable = std::cell::RefCell::new(Problems::none());
    let own = |name: &str| match own_template(&beside, name, &own_templates) {
        Ok(own) => own.or_else(|| builtin::template(name)),
        Err(problems) => {
            unreadable.borrow_mut().extend(problems);
            Some(String::new())
        }
    };
    let find = |name: &str, is_own: bool| match is_own {
        true => own(name),
        false => builtin::template(name),
    };
    let profile = load::profile(
        source,
        Origin::File(reference.to_string()),
        &find,
        &builtin::page,
    );
    unreadable.into_inner().or_ok(())?;
    let profile = profile?;
    hashes.extend(own_templates.into_inner());
    Ok(profile)
}

/// A template beside the profile, `None` if there is none; its name must be a plain file name.
fn own_template(
    folder: &Path,
    name: &str,
    hashes: &std::cell::RefCell<Vec<HashedFile>>,
) -> Result<Option<String>, Problems> {
    let path = folder.join(name);
    let plain = !name.contains(['/', '\\']) && !name.starts_with('.');
    let is_absent = |error: std::io::Error| error.kind() == std::io::ErrorKind::NotFound;
    if !plain || std::fs::symlink_metadata(&path).is_err_and(is_absent) {
        return Ok(None);
    }
    let bytes = read_file(&path)?;
    let text = Source::from_bytes(&path.display().to_string(), &bytes)?.text;
    let mut hashes = hashes.borrow_mut();
    if !hashes.iter().any(|known| known.path == name) {
        hashes.push(hashed(name, &bytes));
    }
    Ok(Some(text))
}
