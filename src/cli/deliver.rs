//! A finished kit on its way to the user: written, then shown, then what to do with it.

use crate::cli::{Format, print, print_bytes, say, write};
use crate::manifest::MANIFEST;
use crate::problem::Problems;
use std::path::Path;

/// Where a kit goes, and what is printed of it.
pub(super) struct Delivery<'a> {
    pub(super) directory: &'a Path,
    pub(super) force: bool,
    pub(super) format: Format,
}

impl Delivery<'_> {
    /// Writes the files and then the bytes of the manifest; prints `report` or the manifest, and
    /// says `next_steps`. The texts are composed before waiting for the disk; nothing is printed of a kit
    /// that could not be written.
    pub(super) fn deliver(
        &self,
        files: &[write::NamedBytes<'_>],
        manifest: &[u8],
        report: impl FnOnce() -> String,
        next_steps: impl FnOnce() -> String,
    ) -> Result<(), Problems> {
        let texts = || {
            let wanted = self.format == Format::Text;
            (wanted.then(report), next_steps())
        };
        let named = (MANIFEST, manifest);
        let ((report, next_steps), previous) =
            write::write_kit(self.directory, files, named, self.force, texts)?;
        let printed = match report {
            None => print_bytes(manifest),
            Some(report) => print(&report),
        };
        // The kit is in its place, also where nothing can be printed.
        if let Some(previous) = previous {
            say(&format!("the old kit is kept as {}", previous.display()));
        }
        say(&next_steps);
        printed.map(|_| ())
    }
}
