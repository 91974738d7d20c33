//! The directory of a kit, or of what was read out of a control; and the machine as such tables leave it,
//! for `assess` and `path`.

use crate::cli::files::{file_names, plain_words, read_file};
use crate::inputs::job::UseOf;
use crate::kit::directory::Directory;
use crate::kit::manifest::MANIFEST;
use crate::kit::{Inputs, LoadedControl, load_own};
use crate::text::finding::{Finding, Severity};
use crate::text::problem::{Problem, Problems};
use crate::volume::assessment::with_tables;
use crate::volume::volume_model::VolumeModel;
use clap::Args;
use std::path::{Path, PathBuf};

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
    /// How the files differ from what the job asks for.
    pub(super) disagreements: Vec<Finding>,
    /// What no file does, what was ignored, and what is taken for granted.
    pub(super) notes: Vec<Finding>,
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
        let loaded = self.loaded(inputs)?;
        let corrected = loaded.map(|loaded| Corrected::of(inputs, volume, loaded));
        corrected.transpose()
    }

    /// Of the control with them, and where they come from.
    fn loaded(&self, inputs: &Inputs) -> Result<Option<NamedControl>, Problems> {
        if self.with_tables {
            return Ok(Some((own_tables(inputs), load_own(inputs)?)));
        }
        let directory = self.tables.as_deref();
        directory.map(|own| of_directory(inputs, own)).transpose()
    }
}

/// Where tables come from, in words, and the control with them.
pub(super) type NamedControl = (String, LoadedControl);

/// The words for the tables that a job asks for.
pub(super) fn own_tables(inputs: &Inputs) -> String {
    format!("the tables of the job for {}", inputs.profile.name)
}

/// The control with the files of a directory.
pub(super) fn of_directory(inputs: &Inputs, directory: &Path) -> Result<NamedControl, Problems> {
    let loaded = read_directory(inputs, directory)?.load(inputs)?;
    Ok((format!("the files of {}", directory.display()), loaded))
}

impl Corrected {
    /// `volume` is the machine as it was measured.
    pub(super) fn of(
        inputs: &Inputs,
        volume: &VolumeModel,
        (from, loaded): NamedControl,
    ) -> Result<Corrected, Problems> {
        let control = loaded.control.as_ref();
        let volume = with_tables(volume, &inputs.model, &loaded.plan, control).map_err(|e| {
            Problem::new(format!("the tables cannot be emulated: {}", e.0))
                .help("nothing can be said of the machine with them")
        })?;
        let found = loaded.findings.into_iter();
        let (disagreements, notes) =
            found.partition(|found| found.severity() == Severity::Disagreement);
        Ok(Corrected { from, volume, disagreements, notes })
    }
}

/// What operating systems leave on a USB stick; no file of a control is called so.
fn is_left_by_a_computer(name: &str) -> bool {
    let names = ["thumbs.db", "desktop.ini"];
    name.starts_with('.') || names.contains(&name.to_ascii_lowercase().as_str())
}

/// Reads the files of a directory, and its manifest where it has one.
pub(super) fn read_directory(inputs: &Inputs, path: &Path) -> Result<Directory, Problems> {
    let name = path.display();
    let refuse = |words: String| {
        Problem::new(format!("`{name}` {words}"))
            .help("name the directory with the control's files, as `nonius generate` wrote it")
    };
    if path.is_file() {
        return Err(refuse("is a file, expected the directory that holds it".to_string()).into());
    }
    let names = file_names(path)
        .map_err(|error| refuse(format!("cannot be read: {}", plain_words(&error))))?;
    let (left, names): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|n| is_left_by_a_computer(n));
    let (manifest, names): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|name| name == MANIFEST);
    if names.is_empty() {
        let words = "holds no file of a control, expected its tables".to_string();
        return Err(refuse(words).into());
    }
    let read = |name: &String| read_file(&path.join(name));
    let files = names.into_iter().map(|name| {
        let bytes = read(&name)?;
        Ok((name, bytes))
    });
    let files: Vec<_> = files.collect::<Result<_, Problem>>()?;
    let manifest = manifest.first().map(read).transpose()?;
    let mut found = Directory::of(inputs, name.to_string(), files, manifest.as_deref())?;
    for name in &left {
        found.ignored(name, "an operating system left it");
    }
    Ok(found)
}
