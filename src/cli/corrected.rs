//! The machine as tables leave it, for `assess` and `path`: which tables are asked for, and what
//! they make of the model.

use crate::cli::directory::read_directory;
use crate::inputs::job::UseOf;
use crate::judge::findings::{InControl, words_of};
use crate::kit::{Inputs, LoadedControl, load, load_own, load_read_out};
use crate::text::finding::{Finding, Severity};
use crate::text::problem::{Problem, Problems};
use crate::volume::assessment::with_tables;
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

/// The machine with tables.
pub(super) struct Corrected {
    /// Where the tables come from, in words.
    pub(super) from: String,
    /// Its errors.
    pub(super) volume: VolumeModel,
    /// How the files differ from what the job asks for, one sentence each.
    pub(super) disagreements: Vec<String>,
    /// What no file does, what was passed over, and what is taken for granted.
    pub(super) notes: Vec<String>,
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
        inputs: &Inputs,
        volume: &VolumeModel,
    ) -> Result<Option<Corrected>, Problems> {
        let Some((from, loaded)) = self.loaded(inputs)? else {
            return Ok(None);
        };
        let control = loaded.control.as_ref();
        let volume = with_tables(volume, &inputs.model, &loaded.plan, control).map_err(|e| {
            Problem::new(format!("the tables cannot be emulated: {}", e.0))
                .help("nothing can be said of the machine with them")
        })?;
        let is_grave = |found: &Finding| found.severity() == Severity::Disagreement;
        Ok(Some(Corrected {
            from,
            volume,
            disagreements: words_of(&loaded.findings, Severity::Disagreement),
            notes: loaded
                .findings
                .iter()
                .filter(|f| !is_grave(f))
                .map(ToString::to_string)
                .collect(),
        }))
    }

    fn loaded(&self, inputs: &Inputs) -> Result<Option<(String, LoadedControl)>, Problems> {
        if self.with_tables {
            let from = format!("the tables of the job for {}", inputs.profile.name);
            return Ok(Some((from, load_own(inputs)?)));
        }
        let Some(directory) = &self.tables else {
            return Ok(None);
        };
        let found = read_directory(inputs, directory)?;
        let mut loaded = match found.read_out(inputs, directory)? {
            Some(control) => load_read_out(inputs, &control)?,
            None => load(inputs, &found.kit_files(), found.state.as_ref())
                .map_err(|problems| found.instead_of(problems))?,
        };
        let differs = |words| Finding::from(InControl::Differs { words });
        let note = |words| Finding::from(InControl::Read { words });
        loaded
            .findings
            .extend(found.remarks.into_iter().map(differs));
        loaded
            .findings
            .splice(0..0, found.notes.into_iter().map(note));
        let from = format!("the files of {}", directory.display());
        Ok(Some((from, loaded)))
    }
}
