//! Writing a kit, or a single file: whole or not at all.
//!
//! ```text
//!   DIR.partial-…/   all files, manifest.json last; each read back, then synced
//!        │ standard output is written (src/cli/outcome.rs)
//!        ▼ one rename
//!       DIR/
//! ```
//! A directory that is there already is kept: DIR.partial-… → DIR.previous, then DIR.previous ⇄ DIR, so
//! that DIR is never absent (where the system exchanges no names: DIR → DIR.previous, then the rename).
//! Nothing is ever removed: the next one is DIR.previous-2, and so on.
//!
//! No output is an input of the run, or lies in a directory that is read, or is anything but a regular
//! file. Killed at any moment, what lies at DIR is the old kit, nothing, or the complete new one. A
//! left-over `DIR.partial-…` is no kit, whatever it holds.

mod partial;

use crate::cli::refusals;
use crate::cli::screen::say;
use crate::text::{Problem, Problems};
use crate::visit::files::{NamedBytes, Ready, not_written, plain_words, previous, printed};
use partial::{Partial, parent_of};
use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Refuses a directory that holds something, before any work is done.
pub(super) fn ensure_free(directory: &Path, force: bool) -> Result<(), Problems> {
    let name = printed(directory);
    let found = fs::symlink_metadata(trimmed(directory));
    if found.is_ok_and(|found| !found.is_dir()) {
        return Err(refusals::no_directory(name).into());
    }
    if is_drive(directory) {
        return Err(refusals::is_drive(name, printed(&directory.join("kit"))).into());
    }
    match fs::read_dir(directory).map(Iterator::count) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Ok(entries) if entries == 0 || force => Ok(()),
        Err(error) => Err(refusals::unusable_directory(name, plain_words(&error)).into()),
        Ok(_) => Err(refusals::not_empty(name).into()),
    }
}

/// An output that is complete beside its place: a directory, or one file.
pub(super) struct Output {
    partial: Partial,
    /// Directories that were made for it; without it they go, so they stand behind it.
    _parents: Vec<Partial>,
    /// The file; a directory has none.
    file: Option<File>,
    place: PathBuf,
    force: bool,
    /// What lies at the place has to be this: a form as it was read.
    pub(super) over: Option<Vec<u8>>,
}

impl Output {
    /// A new file beside a place where a file may be put, and a handle to write with.
    pub(super) fn file(place: &Path, force: bool) -> Result<(Output, File), Problems> {
        let refuse = |error| not_written("cannot write", place, &error);
        let (partial, file) = Partial::file(place).map_err(refuse)?;
        let handle = file.try_clone().map_err(refuse)?;
        let (file, place) = (Some(file), place.to_path_buf());
        Ok((Output { partial, _parents: Vec::new(), file, place, force, over: None }, handle))
    }

    /// All files, in their order, beside the place of the directory.
    pub(super) fn folder(
        place: PathBuf,
        files: &[NamedBytes<'_>],
        force: bool,
    ) -> Result<Output, Problems> {
        let parent = parent_of(&place);
        let parents = Partial::parents(&parent)
            .map_err(|e| not_written("cannot make the directory", &parent, &e))?;
        let partial = Partial::directory(&place)
            .map_err(|e| not_written("cannot make a directory in", &parent, &e))?;
        for (file, bytes) in files {
            let path = partial.path().join(file);
            let made = File::create_new(&path).and_then(|mut file| {
                written(&mut file, bytes)?;
                file.sync_all()
            });
            made.map_err(|e| not_written("cannot write", &path, &e))?;
        }
        sync_directory(partial.path());
        Ok(Output { partial, _parents: parents, file: None, place, force, over: None })
    }

    fn put_file(&self) -> Result<(), Problems> {
        ensure_new(&self.place, self.force)?;
        let put = self.partial.placed(&self.place, |new| match (&self.over, self.force) {
            (Some(over), _) => put_over(new, &self.place, over),
            (None, true) => fs::rename(new, &self.place),
            (None, false) => {
                let new = tempfile::TempPath::try_from_path(new)?;
                new.persist_noclobber(&self.place).map_err(|e| e.error)
            }
        });
        put.map_err(|error| not_written("cannot put into place", &self.place, &error))
    }
}

impl Ready for Output {
    fn complete(&self) -> Result<(), Problems> {
        let synced = self.file.as_ref().map_or(Ok(()), File::sync_all);
        synced.map_err(|error| not_written("cannot write", &self.place, &error))
    }

    fn put(self: Box<Self>) -> Result<(), Problems> {
        if self.file.is_some() {
            self.put_file()?;
        } else {
            take_place(&self.partial, &self.place, self.force)?;
        }
        sync_directory(&parent_of(&self.place));
        Ok(())
    }
}

/// Whether a directory is where a drive begins: nothing can take its place.
#[cfg(unix)]
fn is_drive(directory: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |path: &Path| fs::metadata(path).map(|found| found.dev()).ok();
    let above = device(&directory.join(".."));
    above.is_some() && above != device(directory)
}

#[cfg(not(unix))]
fn is_drive(_: &Path) -> bool {
    false
}

/// The place of a new directory; `kit/` and `kit` are the same.
pub(super) fn named(directory: &Path) -> Result<PathBuf, Problem> {
    let place = trimmed(directory);
    match place.file_name() {
        Some(_) => Ok(place),
        None => Err(refusals::nameless(printed(&place))),
    }
}

/// Refuses a file that exists, and with `--force` anything but a regular one, before any work is done.
pub(super) fn ensure_new(file: &Path, force: bool) -> Result<(), Problems> {
    let name = printed(file);
    Err(match fs::symlink_metadata(file) {
        Err(_) => return Ok(()),
        Ok(found) if found.is_dir() => refusals::is_directory(name),
        Ok(found) if found.is_symlink() => refusals::is_link(name),
        Ok(found) if !found.is_file() => refusals::is_no_file(name),
        Ok(_) if force => return Ok(()),
        Ok(_) => refusals::exists(name),
    }
    .into())
}

/// `kit/` and `kit` are the same directory.
fn trimmed(directory: &Path) -> PathBuf {
    directory.components().collect()
}

/// Writes a new file and reads it back from the system.
pub(super) fn written(file: &mut File, bytes: &[u8]) -> std::io::Result<()> {
    file.write_all(bytes)?;
    file.rewind()?;
    let mut found = Vec::with_capacity(bytes.len() + 1);
    file.read_to_end(&mut found)?;
    if found == bytes {
        return Ok(());
    }
    let other = "the bytes in the file are not those that were written";
    Err(Error::other(other))
}

/// Makes a rename durable where the system can; elsewhere the system does it in its own time.
fn sync_directory(directory: &Path) {
    if let Ok(handle) = File::open(directory) {
        let _ = handle.sync_all();
    }
}

/// Puts a complete directory at `place`, and says what became of an old one.
fn take_place(partial: &Partial, place: &Path, force: bool) -> Result<(), Problems> {
    let failed = |error: Error| not_written("cannot put into place", place, &error);
    if is_free(place) {
        return partial.placed(place, |new| fs::rename(new, place)).map_err(failed);
    }
    ensure_free(place, force)?;
    let kept = free_name(place);
    partial.placed(place, |new| exchange(new, place, &kept)).map_err(failed)?;
    say(&format!("moved {} to {}", printed(place), printed(&kept)));
    Ok(())
}

/// The first of DIR.previous, DIR.previous-2, … where nothing is.
fn free_name(place: &Path) -> PathBuf {
    let is_new = |kept: &PathBuf| fs::symlink_metadata(kept).is_err();
    let mut names = (1..).map(|number| previous(place, number));
    names.find(is_new).unwrap_or_else(|| previous(place, 1))
}

/// Whether nothing is at a place, or an empty directory, which a rename replaces (but not on Windows).
fn is_free(place: &Path) -> bool {
    let Ok(found) = fs::symlink_metadata(place) else {
        return true;
    };
    let is_empty = || fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none());
    found.is_dir() && is_empty() && (cfg!(unix) || fs::remove_dir(place).is_ok())
}

/// `new` to `place`, and what was there to `kept`, where nothing is.
fn exchange(new: &Path, place: &Path, kept: &Path) -> std::io::Result<()> {
    fs::rename(new, kept)?;
    if swap(kept, place).is_ok() {
        return Ok(());
    }
    fs::rename(kept, new)?;
    fs::rename(place, kept)?;
    fs::rename(new, place).or_else(|error| fs::rename(kept, place).and(Err(error)))
}

/// `new` to `place`, where a file with these bytes lies: what somebody saved there meanwhile stays.
fn put_over(new: &Path, place: &Path, over: &[u8]) -> std::io::Result<()> {
    let is_as_read = |path: &Path| fs::read(path).is_ok_and(|found| found == over);
    let changed = || Error::other("somebody changed it while this run was at work");
    if swap(new, place).is_err() {
        return if is_as_read(place) { fs::rename(new, place) } else { Err(changed()) };
    }
    if is_as_read(new) {
        let _ = fs::remove_file(new); // else the next run takes it for left over
        return Ok(());
    }
    swap(new, place).or_else(|_| fs::rename(new, place))?;
    Err(changed())
}

/// Two names change what they name, at once.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn swap(one: &Path, other: &Path) -> std::io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn swap(_: &Path, _: &Path) -> std::io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}
