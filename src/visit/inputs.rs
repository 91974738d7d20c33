//! Files of a user → checked inputs.

use crate::control::controller::{Profile, builtin};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{ActiveTables, BacklashPolicy, Job, MeasuredData, UseOf};
use crate::judge::active::{ActiveControl, ReadOutFor, from_kit, from_read_out, without_tables};
use crate::kit::directory::Directory;
use crate::kit::manifest::MANIFEST;
use crate::kit::{Inputs, JobTables, Loaded, hashed};
use crate::machine::separation::table::ErrorSource;
use crate::quantity::{Axis, Chain, PathKind, PerAxis};
use crate::text::{Finding, Problem, Problems, Severity, Source};
use crate::visit::files::{
    Files, PathEntry, file_name, plain_words, printed, unreadable, with_slashes,
};
use crate::visit::job_files::{CampaignFiles, InputFile, JobFiles};
use crate::visit::refusals;
use crate::volume::assessment::with_tables;
use crate::volume::findings::VolumeFinding;
use crate::volume::volume_model::VolumeModel;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// Reads a job and everything it names, for tables.
pub(crate) fn read(files: &dyn Files, job_path: &Path) -> Result<Inputs, Problems> {
    read_job(files, None, &InputFile::read(files, job_path)?, UseOf::Tables)
}

/// Reads everything that a job names, the table of its angles too; `machine` is an error table in place of what it
/// measured.
pub(crate) fn read_job(
    files: &dyn Files,
    machine: Option<&Path>,
    job: &InputFile<'_>,
    use_of: UseOf,
) -> Result<Inputs, Problems> {
    let mut named = JobFiles::of(files, job, use_of)?;
    if matches!(use_of, UseOf::Figures | UseOf::Readings) {
        let policies = named.job.compensation.backlash;
        let or_mean = |axis| policies[axis].or(Some(BacklashPolicy::Mean));
        named.job.compensation.backlash = PerAxis::from_fn(or_mean);
    }
    let mut problems = Problems::none();
    let profile = problems.take(named.profile());
    let errors = match machine {
        None => errors(&named),
        Some(path) => stated(&named, path),
    };
    let errors = problems.take(errors);
    let (Some(profile), Some(errors)) = (profile, errors) else {
        return Err(problems);
    };
    let angles = named.job.measurement.angles.as_deref();
    let angles = angles.map(|path| named.table(path, "measurement.angles"));
    let angles = angles.transpose()?;
    let active = active(&named, &profile)?;
    let JobFiles { mut job, hashes, .. } = named;
    let hashes = hashes.into_inner();
    if let ErrorSource::Table(table) = &errors
        && let Some(lines) = table.remarks.lines
    {
        job.measurement.levers.or_lines(lines);
    }
    Inputs::of(use_of, job, profile, errors, hashes)?.with(angles.as_ref(), active)
}

/// An error table that no job describes, under this name: each axis travels where it was measured, its reference is its
/// lowest measured position.
pub(crate) fn of_table(
    file: &InputFile<'_>,
    name: String,
    chain: Option<Chain>,
) -> Result<Inputs, Problems> {
    let table = Arc::new(ErrorTable::read(file.source()?)?);
    let page = least_job(&table, chain);
    let mut job = Job::read_for(Source::from_bytes(&file.name, page.as_bytes())?, UseOf::Figures)?;
    job.machine.name = name;
    let profile = builtin::profile(&job.compensation.controller)?;
    let (errors, hashes) = (ErrorSource::Table(Arc::clone(&table)), vec![file.hash.clone()]);
    let mut inputs = Inputs::of(UseOf::Figures, job, profile, errors, hashes)?;
    if chain.is_none() && inputs.model.rotations.iter().any(|(_, angle)| angle.is_some()) {
        return Err(refusals::table_without_chain().at(table.header.clone()).into());
    }
    inputs.notes.push(VolumeFinding::NoJob.into());
    Ok(inputs)
}

/// The least job that such a table needs.
fn least_job(table: &ErrorTable, chain: Option<Chain>) -> String {
    let chain = chain.map_or_else(String::new, |chain| format!("chain = \"{chain}\"\n"));
    let axes = Axis::ALL.into_iter().filter_map(|axis| {
        let positions = || table.series(axis).iter().flat_map(|s| &s.positions).map(|at| at.mm());
        let (low, high) = (positions().reduce(f64::min)?, positions().reduce(f64::max)?);
        let axis = axis.key();
        Some(format!(
            "[machine.axes.{axis}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = {low:?}\n"
        ))
    });
    let axes: String = axes.collect();
    // Figures are of the table as it stands; nothing is compensated from it.
    format!(
        "schema = 1\n[machine]\nname = \"error table\"\n{chain}{axes}[measurement]\nerrors = \"-\"\nactive_while_measuring = \"none\"\n"
    )
}

/// An error table that no job names.
fn stated(files: &JobFiles<'_>, path: &Path) -> Result<ErrorSource, Problems> {
    let file = InputFile::read(files.files, path)?;
    let table = ErrorTable::read(file.source()?)?;
    files.hashes.borrow_mut().push(file.hash);
    Ok(ErrorSource::Table(Arc::new(table)))
}

/// The errors of a job: those that it names, or those that its readings hold.
pub(crate) fn errors(files: &JobFiles<'_>) -> Result<ErrorSource, Problems> {
    let job = &files.job;
    let paths = match &job.measurement.data {
        MeasuredData::Errors(paths) => paths,
        MeasuredData::Diagonals(measurement) if measurement.kind == PathKind::Straight => {
            let key = "measurement.step_diagonal.kind";
            return Err(job.source.at(key, refusals::only_straight_runs()).into());
        }
        MeasuredData::Diagonals(measurement) => {
            return CampaignFiles::read(files, measurement)?.errors();
        }
    };
    let mut problems = Problems::none();
    let mut table = |path| problems.take(files.table(path, "measurement.errors"));
    let tables: Vec<ErrorTable> = paths.iter().filter_map(|path| table(path)).collect();
    let tables = problems.or_ok(tables)?;
    let missing = || job.source.at("measurement.errors", refusals::no_error_table());
    let merged = ErrorTable::merged(tables)?.ok_or_else(missing)?;
    Ok(ErrorSource::Table(Arc::new(merged)))
}

/// The key of what was active.
pub(crate) const ACTIVE: &str = "measurement.active_while_measuring";

/// `active_while_measuring`: the control as it was while measuring; every file that was read is hashed.
pub(crate) fn active(
    files: &JobFiles<'_>,
    profile: &Profile,
) -> Result<Option<ActiveControl>, Problems> {
    let job = &files.job;
    let ActiveTables::Path(path) = &job.measurement.active else {
        return without_tables(job, profile);
    };
    let full = files.folder.join(path);
    let help = "name a kit, a file or a directory read out of the control (relative to the job), or write \"none\"";
    let found = of_control(files.files, &full, path, help);
    let (manifest, found) = found.map_err(|problem| files.at(ACTIVE, problem))?;
    let is_folder = files.files.is(PathEntry::Folder, &full);
    let inside = |name: &str| match is_folder {
        true => format!("{path}/{name}"),
        false => path.clone(),
    };
    let active = match &manifest {
        Some(manifest) => from_kit(job, profile, path, manifest, found)?,
        None => from_read_out(job, profile, path, found, ReadOutFor::OldTables)?,
    };
    let manifest = manifest.iter().map(|bytes| hashed(&inside(MANIFEST), bytes));
    let own = active.files.iter().map(|(name, bytes)| hashed(&inside(name), bytes));
    files.hashes.borrow_mut().extend(manifest.chain(own));
    Ok(Some(active))
}

/// The manifest, and names and bytes of the other files.
type OfControl = (Option<Vec<u8>>, Vec<(String, Vec<u8>)>);

/// A file of a control, or those of a directory; `path` = as it was named, `help` = what can be named. What operating
/// systems leave is ignored.
pub(crate) fn of_control(
    files: &dyn Files,
    full: &Path,
    path: &str,
    help: &str,
) -> Result<OfControl, Problem> {
    let refuse = |error: std::io::Error| unreadable(&format!("`{path}`"), &error).help(help);
    if files.kind(full).map_err(refuse)? == PathEntry::File {
        return Ok((None, vec![(file_name(full), files.bytes(full)?)]));
    }
    let names = files.names(full).map_err(refuse)?.into_iter();
    let (manifest, found) =
        read_all(files, full, names.filter(|name| !is_left_by_a_computer(name)))?;
    if found.is_empty() {
        return Err(refusals::no_control_file(path));
    }
    Ok((manifest, found))
}

/// The files of a folder with these names.
pub(super) fn read_all(
    files: &dyn Files,
    folder: &Path,
    names: impl IntoIterator<Item = String>,
) -> Result<OfControl, Problem> {
    let (mut manifest, mut found) = (None, Vec::new());
    for name in names {
        let bytes = files.bytes(&folder.join(&name))?;
        match name == MANIFEST {
            true => manifest = Some(bytes),
            false => found.push((name, bytes)),
        }
    }
    Ok((manifest, found))
}

// The directory of a kit, or of what was read out of a control; and the machine as such tables leave it.

/// The machine with tables, and figures of it.
#[derive(Serialize)]
pub(crate) struct CorrectedMachine<T = ()> {
    /// Where the tables come from, in words.
    #[serde(rename = "tables")]
    pub(crate) from: String,
    #[serde(flatten)]
    pub(crate) figures: T,
    /// How the files differ from what the job asks for.
    pub(crate) disagreements: Vec<Finding>,
    /// Its errors.
    #[serde(skip)]
    pub(crate) volume: VolumeModel,
    /// What no file does, what was ignored, and what is taken for granted.
    #[serde(skip)]
    pub(crate) notes: Vec<Finding>,
}

impl CorrectedMachine {
    /// `volume` is the machine as it was measured.
    pub(crate) fn of(
        volume: &VolumeModel,
        loaded: &Loaded<'_>,
    ) -> Result<CorrectedMachine, Problems> {
        let JobTables { inputs, plan, .. } = &loaded.asked;
        let volume = with_tables(volume, &inputs.model, plan, loaded.control()?)
            .map_err(|reason| refusals::not_emulated(reason.0))?;
        let found = loaded.findings.iter().chain(&loaded.unread).cloned();
        let (disagreements, notes) =
            found.partition(|found| found.severity() == Severity::Disagreement);
        Ok(CorrectedMachine { from: loaded.from(), figures: (), disagreements, volume, notes })
    }

    /// The same with figures of it.
    pub(crate) fn with<T>(self, figures: T) -> CorrectedMachine<T> {
        let CorrectedMachine { from, disagreements, volume, notes, .. } = self;
        CorrectedMachine { from, figures, disagreements, volume, notes }
    }
}

/// What operating systems leave on a USB stick; no file of a control is called so.
fn is_left_by_a_computer(name: &str) -> bool {
    let names = ["thumbs.db", "desktop.ini"];
    name.starts_with('.') || names.contains(&name.to_ascii_lowercase().as_str())
}

/// Reads the files of a directory, and its manifest where it has one.
pub(crate) fn read_directory(
    files: &dyn Files,
    inputs: &Inputs,
    path: &Path,
) -> Result<Directory, Problems> {
    let name = printed(path);
    if files.is(PathEntry::File, path) {
        return Err(refusals::file_not_kit(name).into());
    }
    let names =
        files.names(path).map_err(|error| refusals::unreadable_kit(&name, plain_words(&error)))?;
    let (left, names): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|n| is_left_by_a_computer(n));
    let (manifest, own) = read_all(files, path, names)?;
    if own.is_empty() {
        return Err(refusals::empty_kit(name).into());
    }
    let mut found = Directory::of(inputs, with_slashes(path), own, manifest.as_deref())?;
    for name in &left {
        found.ignored(name, "an operating system left it");
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visit::files::Memory;

    #[test]
    fn what_operating_systems_leave_is_no_file_of_a_control() {
        let left = [".DS_Store", "Thumbs.db", "desktop.ini"].map(|name| format!("old/{name}"));
        let left = left.iter().map(|name| (name.as_str(), &b"\0"[..]));
        let files = Memory::of(left.chain([("old/A.MPF", &b"M30"[..])]));
        let (manifest, found) = of_control(&files, Path::new("old"), "old", "").unwrap();
        assert_eq!((manifest, found), (None, vec![("A.MPF".to_string(), b"M30".to_vec())]));
    }
}
