//! Files and their names, as a user gives them; and what was read in this run, over which nothing
//! is written (`src/cli/write.rs` asks).

use crate::text::document::LARGEST_FILE_MIB;
use crate::text::problem::{Problem, Problems};
use std::fs::{File, Metadata, TryLockError};
use std::io::{Error, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A file or directory that was read.
struct Input {
    name: String,
    /// Without links; empty of standard input.
    place: PathBuf,
    is_directory: bool,
    identity: Option<Identity>,
}

/// The same for all names of a file: device and number on it.
type Identity = (u64, u64);

/// Everything that was read so far: a process runs one command. Whatever reads adds to it, so that
/// no command has to list its inputs.
static READ: Mutex<Vec<Input>> = Mutex::new(Vec::new());

fn remember(name: &str, place: Option<&Path>, metadata: &Metadata) {
    let input = Input {
        name: name.to_string(),
        place: place.map(resolved).unwrap_or_default(),
        is_directory: metadata.is_dir(),
        identity: identity(metadata),
    };
    READ.lock().unwrap_or_else(PoisonError::into_inner).push(input);
}

/// What was read in this run and is, contains or lies in what is at `output` (that need not exist).
pub(super) fn input_at(output: &Path) -> Option<String> {
    let place = resolved(output);
    let own = output.metadata().ok().and_then(|m| identity(&m));
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let concerns = |input: &&Input| {
        (own.is_some() && own == input.identity)
            || input.place.starts_with(&place)
            || (input.is_directory && place.starts_with(&input.place))
    };
    read.iter().find(concerns).map(|input| input.name.clone())
}

/// A path without links, also of something that does not exist yet.
fn resolved(path: &Path) -> PathBuf {
    match (path.canonicalize(), path.parent(), path.file_name()) {
        (Ok(found), _, _) => found,
        (Err(_), Some(parent), Some(name)) if parent != Path::new("") => {
            resolved(parent).join(name)
        }
        (Err(_), _, Some(name)) => resolved(Path::new(".")).join(name),
        (Err(_), _, None) => path.to_path_buf(),
    }
}

#[cfg(unix)]
fn identity(metadata: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// Elsewhere a file is known by its path alone.
#[cfg(not(unix))]
fn identity(_: &Metadata) -> Option<Identity> {
    None
}

pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| "-".to_string(), |name| name.to_string_lossy().into_owned())
}

/// A file argument: `-` is standard input.
pub(super) fn read_argument(path: &Path) -> Result<(String, Vec<u8>), Problems> {
    if path != Path::new("-") {
        let bytes = read_file(path).map_err(|p| or_help(p, "check the path"))?;
        return Ok((path.display().to_string(), bytes));
    }
    let bytes = bounded(STANDARD_INPUT, 0, standard_input())?;
    Ok((STANDARD_INPUT.to_string(), bytes))
}

/// A form, which may be replaced by what it becomes when it is filled in. As long as the file is held, no other run
/// fills in the same one (on Windows nothing is locked).
pub(super) fn read_form(
    path: &Path,
    output: Option<&Path>,
) -> Result<(String, Vec<u8>, Option<File>), Problems> {
    let is_replaced = path.is_file() && output.is_some_and(|own| resolved(own) == resolved(path));
    let held = (cfg!(unix) && is_replaced).then(|| File::open(path).ok()).flatten();
    if let Some(Err(TryLockError::WouldBlock)) = held.as_ref().map(File::try_lock) {
        let message = format!("another run is filling in `{}`", path.display());
        return Err(Problem::new(message).help("look at what it wrote").into());
    }
    let (name, bytes) = read_argument(path)?; // by its name: what was put there meanwhile is read
    READ.lock().unwrap_or_else(PoisonError::into_inner).pop();
    Ok((name, bytes, held))
}

/// How standard input is called.
pub(super) const STANDARD_INPUT: &str = "standard input";

/// Standard input, which may be a file into which something else is to be written.
pub(super) fn standard_input() -> impl Read {
    let input = std::io::stdin();
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let handle = input.as_fd().try_clone_to_owned().map(File::from);
        if let Ok(metadata) = handle.and_then(|file| file.metadata()) {
            remember(STANDARD_INPUT, None, &metadata);
        }
    }
    input.lock()
}

/// The bytes of a file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    let name = path.display().to_string();
    let (file, metadata) = open(path)?;
    let bytes = bounded(&format!("`{name}`"), metadata.len(), file)?;
    if bytes.is_empty() && !metadata.is_file() {
        return Err(Problem::new(format!("`{name}` is a pipe, and nothing was written into it"))
            .help("name a file"));
    }
    Ok(bytes)
}

/// Opens a regular file or a pipe, without waiting for somebody who writes into it.
pub(super) fn open(path: &Path) -> Result<(File, Metadata), Problem> {
    let name = path.display().to_string();
    if name.chars().any(char::is_control) {
        let plain = name.escape_debug();
        return Err(Problem::new(format!("`{plain}` is no path of a file"))
            .help("between double quotes a backslash begins a control character: write `/`, or single quotes around the path"));
    }
    let refuse = |error: std::io::Error| {
        Problem::new(format!("`{name}` cannot be read: {}", plain_words(&error)))
    };
    let metadata = std::fs::metadata(path).map_err(refuse)?;
    if metadata.is_dir() {
        return Err(Problem::new(format!("`{name}` is a directory, expected a file"))
            .help("name a file in it"));
    }
    if !metadata.is_file() && !is_pipe(&metadata) {
        return Err(Problem::new(format!("`{name}` is no regular file")).help("name a file"));
    }
    let file = if metadata.is_file() { File::open(path) } else { open_pipe(path) };
    let file = file.map_err(refuse)?;
    remember(&name, Some(path), &metadata);
    Ok((file, metadata))
}

#[cfg(unix)]
fn is_pipe(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

/// A pipe that nobody writes into would be waited for when it is opened; when it is read, it ends.
#[cfg(unix)]
fn open_pipe(path: &Path) -> std::io::Result<File> {
    use rustix::fs::{CWD, Mode, OFlags, fcntl_setfl, openat};
    let flags = OFlags::RDONLY | OFlags::CLOEXEC | OFlags::NONBLOCK;
    let file = openat(CWD, path, flags, Mode::empty())?;
    fcntl_setfl(&file, OFlags::empty())?;
    Ok(file.into())
}

#[cfg(not(unix))]
fn open_pipe(path: &Path) -> std::io::Result<File> {
    File::open(path)
}

/// All bytes of an input, or a refusal; `length` is what the system says that there are, `name` as
/// it stands in a sentence.
fn bounded(name: &str, length: u64, input: impl Read) -> Result<Vec<u8>, Problem> {
    let limit = LARGEST_FILE_MIB << 20;
    let too_long = || {
        Problem::new(format!(
            "{name} holds more than {LARGEST_FILE_MIB} MiB, too much for an input"
        ))
    };
    if length > limit {
        return Err(too_long());
    }
    let expected = usize::try_from(length).unwrap_or(0);
    let mut bytes = Vec::with_capacity(expected + 1);
    let read = input.take(limit + 1).read_to_end(&mut bytes);
    read.map_err(|error| {
        let words = plain_words(&error);
        Problem::new(format!("{name} cannot be read: {words}"))
    })?;
    if bytes.len() as u64 > limit {
        return Err(too_long());
    }
    Ok(bytes)
}

/// The names of the files in a directory, in order; links and directories are none.
pub(super) fn file_names(directory: &Path) -> std::io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let entry = entry?;
        if entry.file_type()?.is_file() {
            names.push(entry.file_name().into_string().map_err(|name| {
                Error::other(format!("the name {name:?} of a file in it is not UTF-8"))
            })?);
        }
    }
    names.sort();
    let name = directory.display().to_string();
    remember(&name, Some(directory), &directory.metadata()?);
    Ok(names)
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

/// The next step for a file that a job names.
pub(super) fn beside_job(problem: Problem) -> Problem {
    or_help(problem, "relative paths in a job are relative to the job file")
}

fn or_help(problem: Problem, help: &str) -> Problem {
    match problem.help {
        Some(_) => problem,
        None => problem.help(help),
    }
}
