//! `NAME.partial-…`: an output while it is not complete, beside its place. It goes when the run fails,
//! when a signal ends the run, or, where the run was killed, when the next one writes to that place.
//!
//! A run that is at work holds a lock on what it made, so that no other run takes it for left over.

use crate::cli::screen::say;
use crate::visit::files::printed;
use std::fs::{self, File, TryLockError};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

/// Characters of chance in the name: nobody calls a file of his own so by accident.
const CHANCE: usize = 16;
const MARK: &str = ".partial-";
/// What this run made and did not put into its place yet, for the signals.
struct Unplaced {
    paths: Vec<PathBuf>,
    /// The output is in its place: the run is finished, whatever comes.
    is_placed: bool,
}

static MADE: Mutex<Unplaced> = Mutex::new(Unplaced { paths: Vec::new(), is_placed: false });

fn made() -> MutexGuard<'static, Unplaced> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or directory that this run made; dropped before it is in its place, it goes.
pub(super) struct Partial {
    path: PathBuf,
    /// Held open: the lock.
    _lock: Option<File>,
}

impl Drop for Partial {
    fn drop(&mut self) {
        let mut made = made();
        if let Some(at) = made.paths.iter().position(|path| *path == self.path) {
            made.paths.swap_remove(at);
            remove(&self.path);
        }
    }
}

/// Removes what is not complete; of a directory that it lies in, nothing but the directory, if empty.
fn remove(path: &Path) {
    // What cannot be removed stays; the next run tries again.
    let _ = if !path.is_dir() {
        fs::remove_file(path)
    } else if is_partial(path) {
        fs::remove_dir_all(path)
    } else {
        fs::remove_dir(path)
    };
}

/// The same while the run still writes into it: what is new is removed, too.
fn remove_for_good(path: &Path) {
    const TRIES: usize = 1000;
    for _ in 0..TRIES {
        remove(path);
        if !path.exists() {
            return;
        }
    }
}

impl Partial {
    /// A new directory for what shall be at `place`.
    pub(super) fn directory(place: &Path) -> Result<Partial> {
        Partial::at(place, 0o777, |builder, parent| {
            let path = builder.tempdir_in(parent)?.keep();
            let handle = File::open(&path).ok();
            Ok((path, handle))
        })
    }

    /// A new file for what shall be at `place`, and a handle to write with.
    pub(super) fn file(place: &Path) -> Result<(Partial, File)> {
        let mut file = None;
        let partial = Partial::at(place, 0o666, |builder, parent| {
            let (new, path) = builder.tempfile_in(parent)?.keep()?;
            let handle = new.try_clone().ok();
            file = Some(new);
            Ok((path, handle))
        })?;
        let file = file.ok_or(ErrorKind::NotFound)?;
        Ok((partial, file))
    }

    /// Something new with a name of its own beside `place`, with the permissions that the user's mask
    /// leaves, after what killed runs left there was removed.
    fn at(
        place: &Path,
        mode: u32,
        new: impl FnOnce(&tempfile::Builder<'_, '_>, &Path) -> Result<(PathBuf, Option<File>)>,
    ) -> Result<Partial> {
        let parent = parent_of(place);
        let door = File::open(&parent).ok();
        clean(place, &parent, door.as_ref());
        // Held until the new thing is locked: no other run takes it for left over in between. Where the
        // system locks nothing, nothing is removed either.
        let _ = door.as_ref().map(hold);
        hear_signals();
        let prefix = prefix_of(place);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).rand_bytes(CHANCE);
        with_mode(&mut builder, mode);
        let mut made = made();
        let is_same = |own: &PathBuf| {
            let name = own.file_name().unwrap_or_default().to_string_lossy();
            let folder = |path: &Path| fs::canonicalize(path).ok();
            name.starts_with(&prefix) && own.parent().and_then(folder) == folder(&parent)
        };
        if made.paths.iter().any(is_same) {
            return Err(Error::other("this run writes something else there"));
        }
        let (path, _lock) = new(&builder, &parent)?;
        made.paths.push(path.clone());
        drop(made);
        if cfg!(unix) {
            // Windows would keep this run itself from reading the file by another handle.
            let _ = _lock.as_ref().map(File::try_lock);
        }
        Ok(Partial { path, _lock })
    }

    /// A directory that was not there, and those above it; the innermost first.
    pub(super) fn parents(directory: &Path) -> Result<Vec<Partial>> {
        let missing: Vec<&Path> = directory
            .ancestors()
            .take_while(|path| !path.as_os_str().is_empty() && !path.exists())
            .collect();
        let mut parents = Vec::new();
        for path in missing.into_iter().rev() {
            hear_signals();
            let mut made = made();
            match fs::create_dir(path) {
                Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
                Err(_) => continue, // another run made it
                Ok(()) => made.paths.push(path.to_path_buf()),
            }
            parents.insert(0, Partial { path: path.to_path_buf(), _lock: None });
        }
        Ok(parents)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Puts it into its place, with the permissions of what it replaces; a signal waits until that is done.
    pub(super) fn placed<T, E>(
        &self,
        place: &Path,
        put: impl FnOnce(&Path) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        let replaced = fs::symlink_metadata(place).map(|found| found.permissions());
        if let (true, Ok(permissions)) = (cfg!(unix), replaced) {
            // Of another user's file they cannot be had; the mask holds then.
            let _ = fs::set_permissions(&self.path, permissions);
        }
        let mut made = made();
        let done = put(&self.path)?;
        made.paths.clear(); // with it the directories above: they are in use
        made.is_placed = true;
        Ok(done)
    }
}

/// The folder that something lies in.
pub(super) fn parent_of(directory: &Path) -> PathBuf {
    match directory.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(unix)]
fn with_mode(builder: &mut tempfile::Builder<'_, '_>, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(mode));
}

#[cfg(not(unix))]
fn with_mode(_: &mut tempfile::Builder<'_, '_>, _: u32) {}

fn prefix_of(place: &Path) -> String {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}{MARK}")
}

fn is_partial(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let chance = name.rsplit_once(MARK).map(|(_, chance)| chance);
    chance.is_some_and(|c| c.len() == CHANCE && c.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// Removes what killed runs left at this place, and says so. Where nothing tells whether a run is still
/// at work, it is named only; while another run makes something there, nothing is looked at.
fn clean(place: &Path, parent: &Path, door: Option<&File>) {
    if let Some(Err(TryLockError::WouldBlock)) = door.map(File::try_lock) {
        return;
    }
    let prefix = prefix_of(place);
    let entries = fs::read_dir(parent).into_iter().flatten().flatten();
    let is_left = |path: &PathBuf| {
        let kind = fs::symlink_metadata(path);
        let is_ours = kind.is_ok_and(|kind| kind.is_file() || kind.is_dir());
        is_ours && is_partial(path)
    };
    let left = entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
        .map(|entry| place.with_file_name(entry.file_name()))
        .filter(is_left);
    for path in left {
        let name = printed(&path);
        let held = File::open(&path);
        let locked = held.as_ref().map(File::try_lock);
        if fs::symlink_metadata(&path).is_err() {
            continue; // its run put it into its place, or removed it, meanwhile
        }
        match locked {
            Ok(Ok(())) if cfg!(unix) => {
                remove(&path);
                say(&format!("removed {name}, left by a run that was killed"));
            }
            Ok(Err(TryLockError::WouldBlock)) => {}
            _ => say(&format!(
                "{name} was left by a run that was killed, or another run is at work there"
            )),
        }
    }
}

/// Shares the lock of a folder. Another run has it for moments, another program perhaps for long: then
/// it is done without.
fn hold(door: &File) {
    const TRIES: usize = 50;
    const PAUSE: Duration = Duration::from_millis(10);
    for _ in 0..TRIES {
        match door.try_lock_shared() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            _ => return,
        }
    }
}

/// Signals that the run was started without, so that it outlives its terminal (`nohup`, a shell's `&`), never reach it;
/// the others end it as ever.
#[cfg(unix)]
fn keep_ignored() {
    use nix::sys::signal::{SigSet, Signal};
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let is_ignored = |signal: &Signal| ignored.unwrap_or(0) >> (*signal as i32 - 1) & 1 == 1;
    let all = [Signal::SIGHUP, Signal::SIGINT, Signal::SIGTERM];
    // This thread and those that it begins; where it fails, they end the run, too.
    let ignored = all.into_iter().filter(is_ignored);
    // A file beyond what the user may write fails like one on a full disk.
    let _ = SigSet::from_iter(ignored.chain([Signal::SIGXFSZ])).thread_block();
}

#[cfg(not(unix))]
fn keep_ignored() {}

/// Ctrl-C, the end of the session and `kill`: what is not complete goes, exit status 2.
fn hear_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        keep_ignored();
        // A system without signals ends the program as it always does.
        let _ = ctrlc::set_handler(|| {
            let made = made();
            if made.paths.is_empty() || made.is_placed {
                return; // the run goes to its end
            }
            made.paths.iter().rev().for_each(|path| remove_for_good(path));
            std::process::exit(2);
        });
    });
}
