//! Options that ask for tables, for `assess` and `path`.

use crate::inputs::job::UseOf;
use crate::kit::{Inputs, load_own};
use crate::text::problem::Problems;
use crate::visit::files::Files;
use crate::visit::tables::{Corrected, NamedControl, of_directory, own_tables};
use crate::volume::volume_model::VolumeModel;
use clap::Args;
use std::path::PathBuf;

/// Options that ask for tables.
#[derive(Args, Debug)]
pub(super) struct AskedTables {
    /// Also as the files of this directory leave the machine
    #[arg(long, value_name = "DIR", conflicts_with = "with_tables")]
    tables: Option<PathBuf>,
    /// Also as the tables that the job asks for would leave the machine
    #[arg(long)]
    with_tables: bool,
}

impl AskedTables {
    /// Whether any are asked for.
    pub(super) fn is_any(&self) -> bool {
        self.tables.is_some() || self.with_tables
    }

    /// What the job has to hold for them.
    pub(super) fn use_of(&self) -> UseOf {
        UseOf::with(self.is_any())
    }

    /// The machine with them; `volume` is the machine as it was measured.
    pub(super) fn corrected(
        &self,
        files: &dyn Files,
        inputs: &Inputs,
        volume: &VolumeModel,
    ) -> Result<Option<Corrected>, Problems> {
        let loaded = self.loaded(files, inputs)?;
        let corrected = loaded.map(|loaded| Corrected::of(inputs, volume, loaded));
        corrected.transpose()
    }

    /// Of the control with them, and where they come from.
    fn loaded(&self, files: &dyn Files, inputs: &Inputs) -> Result<Option<NamedControl>, Problems> {
        if self.with_tables {
            return Ok(Some((own_tables(inputs), load_own(inputs)?)));
        }
        let directory = self.tables.as_deref();
        directory.map(|own| of_directory(files, inputs, own)).transpose()
    }
}
