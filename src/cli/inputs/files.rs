//! Files and their names, as a user gives them.

use crate::problem::{Problem, Problems};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Files larger than this are no job, table or profile (an error table of 10 000 points has 1 MB).
const LARGEST_INPUT_BYTES: u64 = 64 * 1024 * 1024;

pub(in crate::cli) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || "-".to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// A file argument: `-` is standard input.
pub(in crate::cli) fn read_argument(path: &Path) -> Result<(String, Vec<u8>), Problems> {
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
pub(in crate::cli) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    let name = path.display().to_string();
    if name.chars().any(char::is_control) {
        let plain = name.escape_debug();
        return Err(Problem::new(format!("`{plain}` is no path of a file"))
            .help("between double quotes a backslash begins a control character: write `/`, or single quotes around the path"));
    }
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
pub(in crate::cli) fn plain_words(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "it does not exist".to_string(),
        std::io::ErrorKind::NotADirectory => "a part of its path is a file".to_string(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_string(),
        std::io::ErrorKind::StorageFull => "no space left".to_string(),
        _ => error.to_string(),
    }
}

/// A path beside another one: the same name with something added.
pub(in crate::cli) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(suffix);
    PathBuf::from(name)
}

/// The next step for a file that a job names.
pub(in crate::cli) fn beside_job(problem: Problem) -> Problem {
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
