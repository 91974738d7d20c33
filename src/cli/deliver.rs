//! A finished kit on its way to the user: written, then shown, then what to do with it.

use crate::cli::{Format, print, print_bytes, say, write};
use crate::manifest::MANIFEST;
use crate::problem::Problems;
use clap::Args;
use std::path::Path;

/// Options of every command that writes a kit.
#[derive(Args, Debug)]
pub(super) struct Delivery {
    /// Replace an existing directory; the old one is kept as DIR.previous
    #[arg(long)]
    force: bool,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

impl Delivery {
    /// Refuses a directory that is not free, before anything is computed.
    pub(super) fn ensure_free(&self, directory: &Path) -> Result<(), Problems> {
        write::ensure_free(directory, self.force)
    }

    /// Writes the files and then the bytes of the manifest; prints `report` or the manifest, and
    /// says `next_steps`. The texts are composed before waiting for the disk; nothing is printed of a kit
    /// that could not be written.
    pub(super) fn deliver<'a>(
        &self,
        directory: &Path,
        files: impl Iterator<Item = write::NamedBytes<'a>>,
        manifest: &[u8],
        report: impl FnOnce() -> String,
        next_steps: impl FnOnce() -> String,
    ) -> Result<(), Problems> {
        let texts = || {
            let wanted = self.format == Format::Text;
            (wanted.then(report), next_steps())
        };
        let named = (MANIFEST, manifest);
        let ((report, next_steps), moved) = write::write_kit(
            directory,
            &files.collect::<Vec<_>>(),
            named,
            self.force,
            texts,
        )?;
        let printed = match report {
            None => print_bytes(manifest),
            Some(report) => print(&report),
        };
        // The kit is in its place, also where nothing can be printed.
        moved.iter().for_each(|sentence| say(sentence));
        say(&next_steps);
        printed.map(|_| ())
    }
}
