//! Writing a kit, or a single file: whole or not at all.
//!
//! ```text
//!   DIR.partial-…/   all files, manifest.json last; each read back, then synced
//!        │ standard output is written (src/cli/outcome.rs)
//!        ▼ one rename
//!       DIR/
//! ```
//! No output is an input of the run, or lies in a directory that is read, or is anything but a regular
//! file. Killed at any moment, what lies at DIR is the old kit, nothing, or the complete new one. A
//! left-over `DIR.partial-…` is no kit, whatever it holds.

mod partial;
mod replace;

use crate::cli::inputs::{input_at, plain_words};
use crate::text::problem::{Problem, Problems};
use partial::Partial;
pub(super) use replace::previous;
use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// A file to be written: name and bytes.
pub(super) type NamedBytes<'a> = (&'a str, &'a [u8]);

/// Refuses a directory that holds something, before any work is done.
pub(super) fn ensure_free(directory: &Path, force: bool) -> Result<(), Problems> {
    let name = directory.display();
    let found = fs::symlink_metadata(trimmed(directory));
    if found.is_ok_and(|found| !found.is_dir()) {
        return Err(Problem::new(format!(
            "`{name}` is a link or a file, expected a new or an empty directory"
        ))
        .help("choose another directory; of a link, name what it leads to")
        .into());
    }
    if is_drive(directory) {
        return Err(
            Problem::new(format!("`{name}` is a drive, expected a directory on it"))
                .help(format!(
                    "name one, e.g. `{}`",
                    directory.join("kit").display()
                ))
                .into(),
        );
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

/// An output that is complete beside its place.
pub(super) enum Ready {
    /// One file.
    File(ReadyFile),
    /// A directory.
    Kit(ReadyKit),
}

impl Ready {
    /// One rename puts it into its place.
    pub(super) fn put(self) -> Result<(), Problems> {
        match self {
            Ready::File(file) => file.put(),
            Ready::Kit(kit) => kit.put(),
        }
    }
}

/// A directory of files beside its place.
pub(super) struct ReadyKit {
    partial: Partial,
    /// Directories that were made for it; without it they go, so they stand behind it.
    _parents: Vec<Partial>,
    place: PathBuf,
    force: bool,
}

/// Whether a directory is where a drive begins: nothing can take its place.
#[cfg(unix)]
fn is_drive(directory: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |path: &Path| fs::metadata(path).map(|found| found.dev()).ok();
    let own = device(directory);
    own.is_some() && own != device(&directory.join(".."))
}

#[cfg(not(unix))]
fn is_drive(_: &Path) -> bool {
    false
}

/// Writes all files, then `manifest`, beside the place of the directory.
pub(super) fn write_kit(
    directory: &Path,
    files: &[NamedBytes<'_>],
    manifest: NamedBytes<'_>,
    force: bool,
) -> Result<Ready, Problems> {
    let place = trimmed(directory);
    if place.file_name().is_none() {
        let message = format!("`{}` is no name for a new directory", place.display());
        return Err(Problem::new(message)
            .help("name a directory below it, e.g. `kit`")
            .into());
    }
    refuse_input(&place)?;
    let parent = parent_of(&place);
    let parents = Partial::parents(&parent)
        .map_err(|e| not_written("cannot make the directory", &parent, &e))?;
    let partial = Partial::directory(&place)
        .map_err(|e| not_written("cannot make a directory in", &parent, &e))?;
    for (file, bytes) in files.iter().chain([&manifest]) {
        let path = partial.path().join(file);
        write_new(&path, bytes).map_err(|e| not_written("cannot write", &path, &e))?;
    }
    sync_directory(partial.path());
    Ok(Ready::Kit(ReadyKit {
        partial,
        _parents: parents,
        place,
        force,
    }))
}

impl ReadyKit {
    fn put(self) -> Result<(), Problems> {
        replace::take_place(&self.partial, &self.place, self.force)?;
        sync_directory(&parent_of(&self.place));
        Ok(())
    }
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

/// A file beside its place.
pub(super) struct ReadyFile {
    partial: Partial,
    file: File,
    place: PathBuf,
    force: bool,
}

/// Writes a file beside its place, whole.
pub(super) fn write_file(place: &Path, bytes: &[u8], force: bool) -> Result<Ready, Problems> {
    let mut ready = ReadyFile::new(place, force)?;
    let written = write_and_read_back(&mut ready.file, bytes);
    written.map_err(|error| not_written("cannot write", place, &error))?;
    ready.complete()
}

impl ReadyFile {
    /// A new file beside a place where a file may be put.
    pub(super) fn new(place: &Path, force: bool) -> Result<ReadyFile, Problems> {
        ensure_new(place, force)?;
        refuse_input(place)?;
        let made = Partial::file(place);
        let (partial, file) = made.map_err(|e| not_written("cannot write", place, &e))?;
        Ok(ReadyFile {
            partial,
            file,
            place: place.to_path_buf(),
            force,
        })
    }

    /// The file, to write into.
    pub(super) fn file(&self) -> std::io::Result<File> {
        self.file.try_clone()
    }

    /// Where it will be.
    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// Waits until it is on the disk.
    pub(super) fn complete(self) -> Result<Ready, Problems> {
        let synced = self.file.sync_all();
        synced.map_err(|error| not_written("cannot write", &self.place, &error))?;
        Ok(Ready::File(self))
    }

    fn put(self) -> Result<(), Problems> {
        ensure_new(&self.place, self.force)?;
        let put = self.partial.placed(&self.place, |new| match self.force {
            true => fs::rename(new, &self.place),
            false => {
                let new = tempfile::TempPath::try_from_path(new)?;
                new.persist_noclobber(&self.place).map_err(|e| e.error)
            }
        });
        put.map_err(|error| not_written("cannot put into place", &self.place, &error))?;
        sync_directory(&parent_of(&self.place));
        Ok(())
    }
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

/// Writes a new file, reads it back from the system and waits until it is on the disk.
fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = File::create_new(path)?;
    write_and_read_back(&mut file, bytes)?;
    file.sync_all()
}

fn write_and_read_back(file: &mut File, bytes: &[u8]) -> std::io::Result<()> {
    file.write_all(bytes)?;
    file.rewind()?;
    let mut found = Vec::with_capacity(bytes.len() + 1);
    file.read_to_end(&mut found)?;
    if found == bytes {
        return Ok(());
    }
    let other = "the bytes in the file are not those that were written";
    Err(std::io::Error::other(other))
}

/// Makes a rename durable where the system can; elsewhere the system does it in its own time.
fn sync_directory(directory: &Path) {
    if let Ok(handle) = File::open(directory) {
        let _ = handle.sync_all();
    }
}

fn parent_of(directory: &Path) -> PathBuf {
    match directory.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}
