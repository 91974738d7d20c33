//! Files of a user → checked inputs.

use crate::controller::{Origin, Profile, builtin, load};
use crate::document::Source;
use crate::error_table::ErrorTable;
use crate::job::Job;
use crate::kit::{Inputs, hashed};
use crate::manifest::HashedFile;
use crate::problem::{Problem, Problems};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Files larger than this are no job, table or profile (an error table of 10 000 points has 1 MB).
const LARGEST_INPUT_BYTES: u64 = 64 * 1024 * 1024;

/// Reads a job and everything it names.
pub(super) fn read(job_path: &Path) -> Result<Inputs, Problems> {
    let (name, bytes) = read_argument(job_path)?;
    let mut hashes = vec![hashed(&file_name(job_path), &bytes)];
    let job = Job::read(Source::from_bytes(&name, &bytes)?)?;
    let folder = job_path.parent().unwrap_or(Path::new(""));
    let mut problems = Problems::none();
    let profile = problems.take(
        profile(&job.compensation.controller, folder, &mut hashes)
            .map_err(|p| at_controller(&job, p)),
    );
    let table = problems.take(error_table(&job, folder, &mut hashes));
    match (profile, table) {
        (Some(profile), Some(table)) if problems.is_empty() => {
            Inputs::new(job, profile, &table, hashes)
        }
        _ => Err(problems),
    }
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

fn error_table(
    job: &Job,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<ErrorTable, Problems> {
    let path = &job.measurement.errors;
    let full = folder.join(path);
    let bytes =
        read_file(&full).map_err(|problem| match job.source.place_of("measurement.errors") {
            Some(place) => beside_job(problem.at(place)),
            None => problem,
        })?;
    hashes.push(hashed(path, &bytes));
    ErrorTable::read(Source::from_bytes(&full.display().to_string(), &bytes)?)
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
    let find = |name: &str| {
        own_template(&beside, name, &own_templates).or_else(|| builtin::template(name))
    };
    let profile = load::profile(source, Origin::File(reference.to_string()), &find, &|id| {
        builtin::profile(id).ok()
    })?;
    hashes.extend(own_templates.into_inner());
    Ok(profile)
}

/// A template beside the profile; its name must be a plain file name.
fn own_template(
    folder: &Path,
    name: &str,
    hashes: &std::cell::RefCell<Vec<HashedFile>>,
) -> Option<String> {
    let plain = !name.contains(['/', '\\']) && !name.starts_with('.');
    let bytes = plain
        .then(|| read_file(&folder.join(name)).ok())
        .flatten()?;
    let text = String::from_utf8(bytes).ok()?;
    let mut hashes = hashes.borrow_mut();
    if !hashes.iter().any(|known| known.path == name) {
        hashes.push(hashed(name, text.as_bytes()));
    }
    Some(text)
}

/// The next step for a file that a job names.
fn beside_job(problem: Problem) -> Problem {
    or_help(
        problem,
        "relative paths in a job are relative to the job file",
    )
}

fn or_help(problem: Problem, help: &str) -> Problem {
    match problem.help {
        Some(_) => problem,
        None => problem.help(help),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || "-".to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// A file argument: `-` is standard input.
pub(super) fn read_argument(path: &Path) -> Result<(String, Vec<u8>), Problems> {
    if path != Path::new("-") {
        let bytes = read_file(path).map_err(|p| or_help(p, "check the path"))?;
        return Ok((path.display().to_string(), bytes));
    }
    let mut bytes = Vec::new();
    std::io::stdin()
        .take(LARGEST_INPUT_BYTES)
        .read_to_end(&mut bytes)
        .map_err(|error| Problem::new(format!("standard input cannot be read: {error}")))?;
    Ok(("standard input".to_string(), bytes))
}

/// The bytes of a file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    let name = path.display();
    let refuse = |error: std::io::Error| {
        Problem::new(format!("`{name}` cannot be read: {}", plain_words(&error)))
    };
    let length = std::fs::metadata(path).map_err(refuse)?;
    if length.is_dir() {
        return Err(
            Problem::new(format!("`{name}` is a directory, expected a file"))
                .help("name a file in it"),
        );
    }
    if length.len() > LARGEST_INPUT_BYTES {
        return Err(Problem::new(format!(
            "`{name}` has {} bytes, too many for an input",
            length.len()
        )));
    }
    std::fs::read(path).map_err(refuse)
}

/// What went wrong, the same on every operating system where it is common.
pub(super) fn plain_words(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "it does not exist".to_string(),
        std::io::ErrorKind::NotADirectory => "a part of its path is a file".to_string(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_string(),
        std::io::ErrorKind::StorageFull => "no space left".to_string(),
        _ => error.to_string(),
    }
}

/// A path beside another one: the same name with something added.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(suffix);
    PathBuf::from(name)
}
