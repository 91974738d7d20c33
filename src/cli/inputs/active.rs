//! `active_while_measuring`: the path of a job → the control as it was while measuring.

use crate::cli::inputs::{beside_job, file_names, plain_words, read_file};
use crate::control::controller::Profile;
use crate::inputs::job::{ActiveTables, Job};
use crate::judge::active::{ActiveControl, ReadOutFor, from_kit, from_read_out, without_tables};
use crate::kit::hashed;
use crate::kit::manifest::{HashedFile, MANIFEST};
use crate::text::problem::{Problem, Problems};
use std::path::Path;

const KEY: &str = "measurement.active_while_measuring";

type OwnedFile = (String, Vec<u8>);

/// Reads what the job names; every file that was read is hashed.
pub(in crate::cli) fn read(
    job: &Job,
    profile: &Profile,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<Option<ActiveControl>, Problems> {
    let ActiveTables::Path(path) = &job.measurement.active else {
        return without_tables(job, profile);
    };
    let full = folder.join(path);
    let place = |problem: Problem| match job.source.place_of(KEY) {
        Some(place) => beside_job(problem.at(place)),
        None => beside_job(problem),
    };
    let metadata = std::fs::metadata(&full).map_err(|error| {
        let words = plain_words(&error);
        place(Problem::new(format!("`{path}` cannot be read: {words}"))
            .help("name a kit, a file or a directory read out of the control (relative to the job), or write \"none\""))
    })?;
    let (manifest, files) = if metadata.is_dir() {
        directory(&full).map_err(place)?
    } else {
        let name = full.file_name().unwrap_or_default().to_string_lossy();
        (
            None,
            vec![(name.into_owned(), read_file(&full).map_err(place)?)],
        )
    };
    if files.is_empty() {
        let empty = Problem::new(format!("`{path}` holds no file of a control"));
        return Err(place(empty.help("name the directory with the control's files")).into());
    }
    let is_file = !metadata.is_dir();
    let inside = |name: &str| {
        if is_file {
            path.clone()
        } else {
            format!("{path}/{name}")
        }
    };
    let own = manifest
        .iter()
        .map(|bytes| hashed(&inside(MANIFEST), bytes));
    let active = match &manifest {
        Some(manifest) => from_kit(job, profile, path, manifest, files)?,
        None => from_read_out(job, profile, path, files, ReadOutFor::OldTables)?,
    };
    hashes.extend(own);
    hashes.extend(
        active
            .files
            .iter()
            .map(|(name, bytes)| hashed(&inside(name), bytes)),
    );
    Ok(Some(active))
}

/// Manifest and files of a directory, by name; what operating systems leave is passed over.
fn directory(path: &Path) -> Result<(Option<Vec<u8>>, Vec<OwnedFile>), Problem> {
    let refuse = |error: std::io::Error| {
        Problem::new(format!(
            "`{}` cannot be read: {}",
            path.display(),
            plain_words(&error)
        ))
    };
    let names = file_names(path).map_err(refuse)?;
    let mut manifest = None;
    let mut files = Vec::new();
    for name in names.into_iter().filter(|name| !name.starts_with('.')) {
        let bytes = read_file(&path.join(&name))?;
        if name == MANIFEST {
            manifest = Some(bytes);
        } else {
            files.push((name, bytes));
        }
    }
    Ok((manifest, files))
}
