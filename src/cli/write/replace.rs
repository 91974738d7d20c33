//! A new directory takes the place of an old one, which is kept.
//!
//! ```text
//!   DIR.partial-… → DIR.previous, then DIR.previous ⇄ DIR   (DIR is never absent)
//!   where the system exchanges no names: DIR → DIR.previous, DIR.partial-… → DIR
//! ```
//! Nothing is ever removed: the next one is DIR.previous-2, and so on.

use super::partial::Partial;
use super::{ensure_free, not_written};
use crate::cli::inputs::with_suffix;
use crate::cli::say;
use crate::text::problem::Problems;
use std::fs;
use std::io::Result;
use std::path::{Path, PathBuf};

/// Puts a complete directory at `place`, and says what became of an old one.
pub(super) fn take_place(
    partial: &Partial,
    place: &Path,
    force: bool,
) -> std::result::Result<(), Problems> {
    let failed = |error: std::io::Error| not_written("cannot put into place", place, &error);
    if is_free(place) {
        return partial
            .placed(place, |new| fs::rename(new, place))
            .map_err(failed);
    }
    ensure_free(place, force)?;
    let kept = free_name(place);
    partial
        .placed(place, |new| exchange(new, place, &kept))
        .map_err(failed)?;
    say(&format!("moved {} to {}", place.display(), kept.display()));
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
fn exchange(new: &Path, place: &Path, kept: &Path) -> Result<()> {
    fs::rename(new, kept)?;
    if swap(kept, place).is_ok() {
        return Ok(());
    }
    fs::rename(kept, new)?;
    fs::rename(place, kept)?;
    fs::rename(new, place).or_else(|error| fs::rename(kept, place).and(Err(error)))
}

/// Two names change what they name, at once.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn swap(one: &Path, other: &Path) -> Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn swap(_: &Path, _: &Path) -> Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Where the directory that `--force` replaces is kept: `DIR.previous`, `DIR.previous-2`, ….
pub(in crate::cli) fn previous(directory: &Path, number: usize) -> PathBuf {
    match number {
        0 | 1 => with_suffix(directory, ".previous"),
        _ => with_suffix(directory, &format!(".previous-{number}")),
    }
}
