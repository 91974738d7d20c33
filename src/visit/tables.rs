//! The directory of a kit, or of what was read out of a control; and the machine as such tables leave it.

use crate::kit::directory::Directory;
use crate::kit::{Asked, Inputs, Loaded};
use crate::text::{Finding, Problem, Problems, Severity};
use crate::visit::files::{Files, Kind, plain_words, printed, with_slashes};
use crate::visit::inputs::read_all;
use crate::volume::assessment::with_tables;
use crate::volume::volume_model::VolumeModel;
use std::path::Path;

/// The machine with tables.
pub(crate) struct Corrected {
    /// Where the tables come from, in words.
    pub(crate) from: String,
    /// Its errors.
    pub(crate) volume: VolumeModel,
    /// How the files differ from what the job asks for.
    pub(crate) disagreements: Vec<Finding>,
    /// What no file does, what was ignored, and what is taken for granted.
    pub(crate) notes: Vec<Finding>,
}

impl Corrected {
    /// `volume` is the machine as it was measured.
    pub(crate) fn of(volume: &VolumeModel, loaded: &Loaded<'_>) -> Result<Corrected, Problems> {
        let Asked { inputs, plan, .. } = &loaded.asked;
        let volume = with_tables(volume, &inputs.model, plan, loaded.control()?).map_err(|e| {
            Problem::new(format!("the tables cannot be emulated: {}", e.0))
                .help("nothing can be said of the machine with them")
        })?;
        let found = loaded.findings.iter().chain(&loaded.unread).cloned();
        let (disagreements, notes) =
            found.partition(|found| found.severity() == Severity::Disagreement);
        Ok(Corrected { from: loaded.from(), volume, disagreements, notes })
    }
}

/// What operating systems leave on a USB stick; no file of a control is called so.
fn is_left_by_a_computer(name: &str) -> bool {
    let names = ["thumbs.db", "desktop.ini"];
    name.starts_with('.') || names.contains(&name.to_ascii_lowercase().as_str())
}

/// Reads the files of a directory, and its manifest where it has one.
pub(crate) fn read_directory(
    files: &dyn Files,
    inputs: &Inputs,
    path: &Path,
) -> Result<Directory, Problems> {
    let name = printed(path);
    let refuse = |words: String| {
        Problem::new(format!("`{name}` {words}"))
            .help("name the directory with the control's files, as `nonius generate` wrote it")
    };
    if files.is(Kind::File, path) {
        return Err(refuse("is a file, expected the directory that holds it".to_string()).into());
    }
    let names = files
        .names(path)
        .map_err(|error| refuse(format!("cannot be read: {}", plain_words(&error))))?;
    let (left, names): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|n| is_left_by_a_computer(n));
    let (manifest, own) = read_all(files, path, names)?;
    if own.is_empty() {
        let words = "holds no file of a control, expected its tables".to_string();
        return Err(refuse(words).into());
    }
    let mut found = Directory::of(inputs, with_slashes(path), own, manifest.as_deref())?;
    for name in &left {
        found.ignored(name, "an operating system left it");
    }
    Ok(found)
}
