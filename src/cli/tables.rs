//! Options that ask for tables, for `assess` and `path`.

use crate::inputs::job::UseOf;
use crate::kit::{Inputs, generate};
use crate::text::Problems;
use crate::visit::files::Files;
use crate::visit::inputs::{Corrected, read_directory};
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
        let loaded = match &self.tables {
            Some(directory) => read_directory(files, inputs, directory)?.load(inputs)?,
            None if self.with_tables => generate(inputs)?.load(inputs)?,
            None => return Ok(None),
        };
        Corrected::of(volume, &loaded).map(Some)
    }
}
