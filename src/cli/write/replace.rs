//! A new directory takes the place of an old one, which is kept.
//!
//! ```text
//!   DIR.partial-… → DIR.previous, then DIR.previous ⇄ DIR   (DIR is never absent)
//!   where the system exchanges no names: DIR → DIR.previous, DIR.partial-… → DIR
//! ```
//! An older DIR.previous makes it DIR.previous-2, and goes afterwards if it is as it was made: nothing else
//! is removed, and nothing before the new one is in its place.

use super::partial::Partial;
use super::{ensure_free, not_written};
use crate::cli::inputs::{file_names, input_at, read_file, with_suffix};
use crate::cli::say;
use crate::kit::manifest::MANIFEST;
use crate::text::document::{json_page, sha256};
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
        return partial.placed(|new| fs::rename(new, place)).map_err(failed);
    }
    ensure_free(place, force)?;
    let kept = free_name(place);
    partial
        .placed(|new| exchange(new, place, &kept))
        .map_err(failed)?;
    let latest = previous(place, 1);
    let kept = match kept != latest && remove_older(place, &latest) {
        true => {
            let name = latest.display();
            say(&format!(
                "removed the older {name}, which was as it was made"
            ));
            fs::rename(&kept, &latest).map_or(kept, |()| latest)
        }
        false => kept,
    };
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

/// The files of a directory that holds what its manifest lists, each as it was made, and nothing else;
/// `None` of any other.
fn unchanged_files(directory: &Path) -> Option<Vec<String>> {
    if !fs::symlink_metadata(directory).ok()?.is_dir() {
        return None;
    }
    let names = file_names(directory).ok()?;
    if fs::read_dir(directory).ok()?.count() != names.len() {
        return None;
    }
    let bytes = |name: &str| read_file(&directory.join(name)).ok();
    let manifest = json_page(&bytes(MANIFEST)?).ok()?;
    let listed = manifest["files"].as_array()?;
    let unchanged = |name: &String| {
        let entry = listed.iter().find(|entry| entry["path"] == name.as_str());
        let stated = entry.and_then(|entry| entry["sha256"].as_str());
        stated.is_some() && stated == bytes(name).map(|bytes| sha256(&bytes)).as_deref()
    };
    let mut own = names.iter().filter(|name| *name != MANIFEST);
    own.all(unchanged).then_some(names)
}

/// So many names are tried for what has to be kept.
const MOST_KEPT: usize = 10_000;

/// Removes an older kit that is as it was made, and tells whether it is gone.
fn remove_older(place: &Path, kit: &Path) -> bool {
    // Asked first: what is looked at counts as read.
    if input_at(kit).is_some() || unchanged_files(kit).is_none() {
        return false;
    }
    // Moved away first: killed while removing, no half kit is left at DIR.previous, and no other run
    // exchanges it any more.
    let Ok(aside) = Partial::directory(place) else {
        return false;
    };
    let moved = aside.path().join("previous");
    if fs::rename(kit, &moved).is_err() {
        return false;
    }
    let Some(files) = unchanged_files(&moved) else {
        // Another run put its own there in between: it goes back, or to the next number.
        let mut names = (1..MOST_KEPT).map(|number| previous(place, number));
        if !names.any(|name| fs::rename(&moved, name).is_ok()) {
            std::mem::forget(aside); // dropped, it would be removed
        }
        return false;
    };
    for file in files {
        // What cannot be removed now goes with `aside`, or when the next run cleans up.
        let _ = fs::remove_file(moved.join(file));
    }
    true
}
