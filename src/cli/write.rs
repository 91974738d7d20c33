//! Writing a kit, or a single file: whole or not at all.
//!
//! ```text
//!   DIR.partial-…/   all files, manifest.json last; each read back, then synced
//!        │ rename (with --force: DIR → DIR.previous, or DIR.previous-2 …, first)
//!        ▼
//!       DIR/
//! ```
//! No output is an input of the run, or lies in a directory that is read, or is anything but a regular
//! file; and nothing is removed but an older kit that is as it was made.
//! Killed at any moment, what lies at DIR is the old kit, nothing, or the complete new one. A
//! left-over `DIR.partial-…` is no kit, whatever it holds.

use crate::cli::inputs::{file_names, input_at, plain_words, read_file, with_suffix};
use crate::document::sha256;
use crate::manifest::MANIFEST;
use crate::problem::{Problem, Problems};
use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file to be written: name and bytes.
pub(super) type NamedBytes<'a> = (&'a str, &'a [u8]);

/// Refuses a directory that holds something, before any work is done.
pub(super) fn ensure_free(directory: &Path, force: bool) -> Result<(), Problems> {
    let name = directory.display();
    if !directory.is_dir() && fs::symlink_metadata(directory).is_ok() {
        return Err(Problem::new(format!(
            "`{name}` is no directory, expected a new or an empty one"
        ))
        .help("choose another directory")
        .into());
    }
    match fs::read_dir(directory).map(Iterator::count) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(Problem::new(format!(
            "`{name}` cannot be used as the kit's directory: {}",
            plain_words(&error)
        ))
        .help("choose another directory")
        .into()),
        Ok(entries) if entries == 0 || force => Ok(()),
        Ok(_) => Err(Problem::new(format!(
            "the directory `{name}` is not empty, expected a new or an empty one"
        ))
        .help("choose another directory, or `--force` to keep the old one as DIR.previous")
        .into()),
    }
}

/// Writes all files, then `manifest`, then puts the directory into place. Before it waits for the
/// disk, which on Linux is at work already, it does `meanwhile`, whose result it gives, with what is
/// to be said of the old directory.
pub(super) fn write_kit<T>(
    directory: &Path,
    files: &[NamedBytes<'_>],
    manifest: NamedBytes<'_>,
    force: bool,
    meanwhile: impl FnOnce() -> T,
) -> Result<(T, Vec<String>), Problems> {
    let directory = trimmed(directory);
    if directory.file_name().is_none() {
        let message = format!("`{}` is no name for a new directory", directory.display());
        return Err(Problem::new(message)
            .help("name a directory below it, e.g. `kit`")
            .into());
    }
    refuse_input(&directory)?;
    let parent = parent_of(&directory);
    fs::create_dir_all(&parent)
        .map_err(|e| not_written("cannot make the directory", &parent, &e))?;
    let partial = partial_directory(&directory)
        .map_err(|e| not_written("cannot make a directory in", &parent, &e))?;
    let mut written = Vec::new();
    for (file, bytes) in files.iter().chain([&manifest]) {
        let path = partial.path().join(file);
        let handle = write_new(&path, bytes).map_err(|e| not_written("cannot write", &path, &e))?;
        written.push((path, handle));
    }
    begin_sync(&written);
    open_to_others(partial.path());
    let done = meanwhile();
    sync_and_close(written)?;
    sync_directory(partial.path());
    let (previous, said) = make_room(&directory, force)?;
    if let Err(error) = fs::rename(partial.path(), &directory) {
        // Put the old kit back; if that fails too, it is complete at DIR.previous.
        let _ = previous.map(|previous| fs::rename(previous, &directory));
        return Err(not_written("cannot put into place", &directory, &error));
    }
    sync_directory(&parent);
    // The directory has its final name now; there is nothing left to remove.
    let _ = partial.keep();
    Ok((done, said))
}

/// Refuses an output that this run reads, that contains something that it reads, or that would lie in
/// a directory that it reads: asked when everything was read and nothing is written.
fn refuse_input(output: &Path) -> Result<(), Problem> {
    let Some(input) = input_at(output) else {
        return Ok(());
    };
    let name = output.display();
    Err(Problem::new(format!(
        "writing `{name}` would replace or change `{input}`, which this run reads"
    ))
    .help("choose another name for `-o`"))
}

/// Refuses a file that exists, and with `--force` anything but a regular one, before any work is done.
pub(super) fn ensure_new(file: &Path, force: bool) -> Result<(), Problems> {
    let name = file.display();
    let (message, help) = match fs::symlink_metadata(file) {
        Err(_) => return Ok(()),
        Ok(found) if found.is_dir() => (
            format!("`{name}` is a directory, expected the name of a file"),
            "name a file in it",
        ),
        Ok(found) if found.is_symlink() => (
            format!("`{name}` is a link, which would be replaced by a file"),
            "name the file itself",
        ),
        Ok(found) if !found.is_file() => (
            format!("`{name}` is no regular file"),
            "name a file; `-` is standard output",
        ),
        Ok(_) if force => return Ok(()),
        Ok(_) => (
            format!("`{name}` exists, so it is not overwritten"),
            "choose another name, or `--force` to replace it",
        ),
    };
    Err(Problem::new(message).help(help).into())
}

/// Completes a file beside its place, then renames it: whole or not at all.
pub(super) fn write_file(file: &Path, bytes: &[u8], force: bool) -> Result<(), Problems> {
    let failed = |error: std::io::Error| not_written("cannot write", file, &error);
    let mut partial = partial_file(file, force)?;
    partial.write_all(bytes).map_err(failed)?;
    if fs::read(partial.path()).map_err(failed)? != bytes {
        let other = "the bytes in the file are not those that were written";
        return Err(failed(std::io::Error::other(other)));
    }
    put(partial, file, force).map_err(failed)
}

/// A new file beside a place where a file may be put, with the usual permissions.
pub(super) fn partial_file(file: &Path, force: bool) -> Result<NamedTempFile, Problems> {
    ensure_new(file, force)?;
    refuse_input(file)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let mut partial = tempfile::Builder::new();
    let prefix = format!("{name}.partial-");
    partial.prefix(&prefix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        partial.permissions(fs::Permissions::from_mode(0o666)); // less what the umask takes
    }
    partial
        .tempfile_in(parent_of(file))
        .map_err(|error| not_written("cannot write", file, &error))
}

/// Puts a complete file into its place.
pub(super) fn put(partial: NamedTempFile, file: &Path, force: bool) -> std::io::Result<()> {
    partial.as_file().sync_all()?;
    let placed = if force {
        partial.persist(file)
    } else {
        partial.persist_noclobber(file)
    };
    placed.map_err(|error| error.error)?;
    sync_directory(&parent_of(file));
    Ok(())
}

pub(super) fn not_written(what: &str, path: &Path, error: &std::io::Error) -> Problems {
    Problem::new(format!(
        "{what} `{}`: {}; nothing was written",
        path.display(),
        plain_words(error)
    ))
    .help("check the place and its free space, then run the command again")
    .into()
}

/// `kit/` and `kit` are the same directory.
fn trimmed(directory: &Path) -> PathBuf {
    directory.components().collect()
}

/// Writes a new file and reads it back from the system; its bytes may not be on the disk yet.
fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<File> {
    let mut file = File::create_new(path)?;
    file.write_all(bytes)?;
    file.rewind()?;
    let mut found = Vec::with_capacity(bytes.len() + 1);
    file.read_to_end(&mut found)?;
    if found == bytes {
        Ok(file)
    } else {
        Err(std::io::Error::other(
            "the bytes in the file are not those that were written",
        ))
    }
}

/// Asks the system to begin with writing the files to the disk, and does not wait: all of them are
/// then on their way together, and waiting for one after the other takes little more than for one.
/// Linux writes pages out that are not needed any more; elsewhere nothing is begun.
#[cfg(target_os = "linux")]
fn begin_sync(files: &[(PathBuf, File)]) {
    for (_, file) in files {
        // Only advice; `sync_all` waits for the bytes, and tells what failed.
        let _ = rustix::fs::fadvise(file, 0, None, rustix::fs::Advice::DontNeed);
    }
}

#[cfg(not(target_os = "linux"))]
fn begin_sync(_: &[(PathBuf, File)]) {}

/// Waits until all files are on the disk, and closes them: Windows renames no directory that holds
/// an open file.
fn sync_and_close(files: Vec<(PathBuf, File)>) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (path, file) in files {
        if let Err(error) = file.sync_all() {
            problems.extend(not_written("cannot write", &path, &error));
        }
    }
    problems.or_ok(())
}

/// A temporary directory is closed to others; a kit has the usual permissions.
#[cfg(unix)]
fn open_to_others(directory: &Path) {
    use std::os::unix::fs::PermissionsExt;
    // If it cannot be opened, the kit is complete all the same.
    let _ = fs::set_permissions(directory, fs::Permissions::from_mode(0o755));
}

#[cfg(not(unix))]
fn open_to_others(_: &Path) {}

/// Makes a rename durable where the system can; elsewhere the system does it in its own time.
fn sync_directory(directory: &Path) {
    if let Ok(handle) = File::open(directory) {
        let _ = handle.sync_all();
    }
}

/// Removes an empty directory, or moves a full one to a place of its own, which it gives, with what is
/// to be said.
fn make_room(directory: &Path, force: bool) -> Result<(Option<PathBuf>, Vec<String>), Problems> {
    if fs::symlink_metadata(directory).is_err() || fs::remove_dir(directory).is_ok() {
        return Ok((None, Vec::new()));
    }
    ensure_free(directory, force)?;
    let mut said = Vec::new();
    let latest = previous(directory, 1);
    if let Some(files) = unchanged_files(&latest) {
        remove_older(&latest, &files)?;
        said.push(format!(
            "removed the older {}, which was as it was made",
            latest.display()
        ));
    }
    let free = |place: &PathBuf| fs::symlink_metadata(place).is_err();
    let place = (1..).map(|number| previous(directory, number)).find(free);
    let place = place.unwrap_or(latest);
    fs::rename(directory, &place).map_err(|error| {
        Problem::new(format!(
            "cannot rename `{0}` to `{1}`: {2}; `{0}` is as it was",
            directory.display(),
            place.display(),
            plain_words(&error)
        ))
        .help("close programs that use it, or choose another directory")
    })?;
    said.push(format!(
        "moved {} to {}",
        directory.display(),
        place.display()
    ));
    Ok((Some(place), said))
}

/// Where the directory that `--force` replaces is kept: `DIR.previous`, `DIR.previous-2`, ….
pub(super) fn previous(directory: &Path, number: usize) -> PathBuf {
    match number {
        0 | 1 => with_suffix(directory, ".previous"),
        _ => with_suffix(directory, &format!(".previous-{number}")),
    }
}

/// The files of a directory that holds what its manifest lists, each as it was made, and nothing else;
/// `None` of any other, and of one that is read.
fn unchanged_files(directory: &Path) -> Option<Vec<String>> {
    if !fs::symlink_metadata(directory).ok()?.is_dir() || input_at(directory).is_some() {
        return None;
    }
    let names = file_names(directory).ok()?;
    if fs::read_dir(directory).ok()?.count() != names.len() {
        return None;
    }
    let bytes = |name: &str| read_file(&directory.join(name)).ok();
    let manifest: serde_json::Value = serde_json::from_slice(&bytes(MANIFEST)?).ok()?;
    let listed = manifest["files"].as_array()?;
    let unchanged = |name: &String| {
        let entry = listed.iter().find(|entry| entry["path"] == name.as_str());
        let stated = entry.and_then(|entry| entry["sha256"].as_str());
        stated.is_some() && stated == bytes(name).map(|bytes| sha256(&bytes)).as_deref()
    };
    let mut own = names.iter().filter(|name| *name != MANIFEST);
    own.all(unchanged).then_some(names)
}

/// Removes a kit, and of it these files only.
fn remove_older(kit: &Path, files: &[String]) -> Result<(), Problems> {
    let cannot = |error: std::io::Error| {
        Problem::new(format!(
            "cannot remove `{}`: {}",
            kit.display(),
            plain_words(&error)
        ))
    };
    // Moved into a `.partial-` directory first: killed while removing, no half kit is left at
    // DIR.previous. That directory is kept from removing itself, with whatever else is in it.
    let aside = partial_directory(kit).map_err(cannot)?.keep();
    let moved = aside.join("previous");
    fs::rename(kit, &moved).map_err(|error| {
        let _ = fs::remove_dir(&aside);
        cannot(error)
    })?;
    for file in files {
        fs::remove_file(moved.join(file)).map_err(cannot)?;
    }
    fs::remove_dir(moved).map_err(cannot)?;
    Ok(fs::remove_dir(aside).map_err(cannot)?)
}

/// A new directory `DIR.partial-…` beside a directory.
fn partial_directory(beside: &Path) -> std::io::Result<tempfile::TempDir> {
    let name = beside.file_name().unwrap_or_default().to_string_lossy();
    tempfile::Builder::new()
        .prefix(&format!("{name}.partial-"))
        .tempdir_in(parent_of(beside))
}

fn parent_of(directory: &Path) -> PathBuf {
    match directory.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}
