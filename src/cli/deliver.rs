//! A finished kit on its way to the user: written, then shown, then what to do with it.

use crate::cli::outcome::Outcome;
use crate::cli::screen::{Detail, Screen};
use crate::cli::{Format, write};
use crate::kit::manifest::MANIFEST;
use crate::text::problem::Problems;
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
    #[command(flatten)]
    detail: Detail,
}

impl Delivery {
    /// Refuses a directory that is not free, before anything is computed.
    pub(super) fn ensure_free(&self, directory: &Path) -> Result<(), Problems> {
        write::ensure_free(directory, self.force)
    }

    /// The files and then the bytes of the manifest, complete beside their place; the screen or the manifest
    /// is printed, `next_steps` is said.
    pub(super) fn outcome<'a>(
        &self,
        directory: &Path,
        files: impl Iterator<Item = write::NamedBytes<'a>>,
        manifest: &[u8],
        screen: &Screen,
        next_steps: String,
    ) -> Result<Outcome, Problems> {
        let files: Vec<_> = files.collect();
        let ready = write::write_kit(directory, &files, (MANIFEST, manifest), self.force)?;
        let outcome = match self.format {
            Format::Json => Outcome::bytes(manifest.to_vec()),
            Format::Text => Outcome::text(&screen.page(self.detail)),
        };
        let outcome = outcome.writing(ready);
        Ok(match self.detail.talks() {
            true => outcome.saying(next_steps),
            false => outcome,
        })
    }
}
