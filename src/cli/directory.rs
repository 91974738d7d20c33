//! A directory with files of a control: a kit, or what was read out; read as it stands, and what
//! its manifest says against it.

use super::inputs::{file_names, plain_words, read_file};
use crate::control::controller::{Profile, Role};
use crate::judge::active::{ActiveControl, ReadOutFor, from_read_out};
use crate::judge::findings::InControl;
use crate::kit::manifest::{HashedFile, MANIFEST};
use crate::kit::{Inputs, sha256};
use crate::read::{KitFile, may_be_meant_for};
use crate::text::document::json_page;
use crate::text::problem::{Problem, Problems, shown};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Name, purpose and bytes of a file.
type NamedFile = (String, Role, Vec<u8>);

/// The file as a reader takes it.
fn kit_file((path, role, bytes): &NamedFile) -> KitFile<'_> {
    KitFile {
        path,
        role: *role,
        bytes,
    }
}

/// The files of a directory, and what its manifest says against them.
#[derive(Default)]
pub(super) struct Found {
    /// What the control could read.
    files: Vec<NamedFile>,
    /// Sentences that make the verdict `fail`.
    pub(super) remarks: Vec<String>,
    /// What was passed over, and what may explain a disagreement.
    pub(super) notes: Vec<String>,
    /// Inputs of the job that differ from those the kit was made from, in a sentence.
    pub(super) other_inputs: Option<String>,
    /// A listed file that is missing is among the remarks.
    pub(super) names_missing: bool,
    /// How many of the remarks are files with another hash than in the manifest that a reader takes.
    pub(super) changed: usize,
    /// The kit was made for another control.
    other_control: Option<Problem>,
    /// `state` of its manifest: the control outside the files.
    pub(super) state: Option<Value>,
}

impl Found {
    /// The files as the readers take them.
    pub(super) fn kit_files(&self) -> Vec<KitFile<'_>> {
        self.files.iter().map(kit_file).collect()
    }

    /// The control that was read out, where the files have no manifest and none is called as in a
    /// kit, or one is the control's whole parameter file (a Fanuc control itself calls it
    /// `CNC-PARA.TXT`). `None` where the files are a kit's.
    pub(super) fn read_out(
        &self,
        inputs: &Inputs,
        directory: &Path,
    ) -> Result<Option<ActiveControl>, Problems> {
        if self.state.is_some() {
            return Ok(None);
        }
        let is_called_as_a_kit = self.called_as_a_kit(&inputs.profile).is_some();
        let whole = self.whole_file(&inputs.profile);
        if is_called_as_a_kit && whole.is_none() {
            return Ok(None);
        }
        let files = self.files.iter();
        let files = files.map(|(name, _, bytes)| (name.clone(), bytes.clone()));
        let path = directory.display().to_string();
        let mut control = from_read_out(
            &inputs.job,
            &inputs.profile,
            &path,
            files.collect(),
            ReadOutFor::Judging,
        )?;
        if let Some(name) = whole.filter(|_| is_called_as_a_kit) {
            let file = shown(name);
            control
                .findings
                .insert(0, InControl::FarMore { file }.into());
        }
        Ok(Some(control))
    }

    /// A file with a name that a kit's file for the control has.
    pub(super) fn called_as_a_kit(&self, profile: &Profile) -> Option<&str> {
        let own = |name: &str| {
            let mut files = profile.files.iter().filter(|f| f.role.is_read_back());
            files.any(|file| file.path.eq_ignore_ascii_case(name))
        };
        let mut names = self.files.iter().map(|(name, _, _)| name.as_str());
        names.find(|name| own(name))
    }

    /// The name of the control's whole parameter file or archive.
    fn whole_file(&self, profile: &Profile) -> Option<&str> {
        let is_whole = |bytes: &[u8]| crate::read::is_whole(profile, bytes);
        let found = self.files.iter().find(|(_, _, bytes)| is_whole(bytes));
        found.map(|(name, _, _)| name.as_str())
    }

    /// Files of another control cannot be read: that reason in place of what a reader of this
    /// control makes of every line.
    pub(super) fn instead_of(&self, problems: Problems) -> Problems {
        match &self.other_control {
            Some(reason) => reason.clone().into(),
            None => problems,
        }
    }
}

/// What operating systems leave on a stick; no file of a control is called so.
fn is_left_by_a_computer(name: &str) -> bool {
    let names = ["thumbs.db", "desktop.ini"];
    name.starts_with('.') || names.contains(&name.to_ascii_lowercase().as_str())
}

/// Reads the files of a directory, and its manifest where it has one.
pub(super) fn read_directory(inputs: &Inputs, directory: &Path) -> Result<Found, Problems> {
    let refuse = |error: std::io::Error| {
        Problem::new(format!(
            "`{}` cannot be read: {}",
            directory.display(),
            plain_words(&error)
        ))
        .help("name the directory with the control's files, as `nonius generate` wrote it")
    };
    if directory.is_file() {
        return Err(Problem::new(format!(
            "`{}` is a file, expected the directory that holds it",
            directory.display()
        ))
        .help("name the directory with the control's files, as `nonius generate` wrote it")
        .into());
    }
    let names = file_names(directory).map_err(refuse)?;
    let (left, names): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|n| is_left_by_a_computer(n));
    if !names.iter().any(|name| name != MANIFEST) {
        return Err(Problem::new(format!(
            "`{}` holds no file of a control, expected its tables",
            directory.display()
        ))
        .help("name the directory with the control's files, as `nonius generate` wrote it")
        .into());
    }
    let mut found = Found::default();
    for name in names.iter().filter(|name| *name != MANIFEST) {
        let bytes = read_file(&directory.join(name))?;
        let role = role_of(&inputs.profile, name);
        found.files.push((name.clone(), role, bytes));
    }
    found.notes.extend(left.iter().map(|name| {
        format!(
            "`{}` was passed over: an operating system left it",
            shown(name)
        )
    }));
    let manifest = directory.join(MANIFEST);
    if manifest.is_file() {
        let document = parsed(&read_file(&manifest)?)?;
        pass_over_unlisted(&mut found, &document, &inputs.profile);
        compare_hashes(&mut found, &document);
        compare_origin(&mut found, &document, inputs);
        found.state = Some(document["state"].clone());
        if let Some(name) = found.whole_file(&inputs.profile) {
            let words = format!(
                "`{}` holds far more than a kit, so it is the control's own: put what was read out into a directory without manifest.json and name that",
                shown(name)
            );
            found.notes.push(words);
        }
    }
    Ok(found)
}

/// A file that the profile does not know is taken for tables.
fn role_of(profile: &Profile, name: &str) -> Role {
    let known = profile
        .files
        .iter()
        .find(|file| file.path.eq_ignore_ascii_case(name));
    known.map_or(Role::Table, |file| file.role)
}

/// Whether the profile writes a file of this name, other than those into which people write.
fn is_of_a_kit(profile: &Profile, name: &str) -> bool {
    let mut files = profile.files.iter();
    files.any(|file| !file.role.is_written_into() && file.path.eq_ignore_ascii_case(name))
}

fn parsed(manifest: &[u8]) -> Result<Value, Problem> {
    json_page(manifest).map_err(|error| {
        Problem::new(format!("`manifest.json` is damaged: {error}"))
            .help("make the kit again; without `manifest.json` the tables alone are judged")
    })
}

/// What the manifest lists, by path.
fn listed(document: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let entries = document["files"].as_array().into_iter().flatten();
    entries.map(|entry| (entry["path"].as_str().unwrap_or_default(), entry))
}

/// A file that the manifest does not list is judged if the profile writes one of that name or the
/// control could read it, else passed over.
fn pass_over_unlisted(found: &mut Found, document: &Value, profile: &Profile) {
    let listed: BTreeSet<&str> = listed(document).map(|(path, _)| path).collect();
    let files = std::mem::take(&mut found.files);
    for file in files {
        let name = shown(&file.0);
        if listed.contains(file.0.as_str()) {
            found.files.push(file);
        } else if is_of_a_kit(profile, &file.0) || may_be_meant_for(profile, &kit_file(&file)) {
            let words =
                format!("`{name}` is not listed in manifest.json, and the control could read it");
            found.remarks.push(words);
            found.files.push(file);
        } else {
            found.notes.push(format!("`{name}` was passed over: manifest.json does not list it, and it is no file of this control"));
        }
    }
}

fn compare_hashes(found: &mut Found, document: &Value) {
    let files: BTreeMap<&str, &NamedFile> = found
        .files
        .iter()
        .map(|file| (file.0.as_str(), file))
        .collect();
    let mut times: BTreeMap<&str, usize> = BTreeMap::new();
    for (path, entry) in listed(document) {
        let times = times.entry(path).or_default();
        *times += 1;
        if *times > 1 {
            let words = format!("`{}` is listed twice in manifest.json", shown(path));
            found.remarks.extend((*times == 2).then_some(words));
            continue;
        }
        let hash = entry["sha256"].as_str().unwrap_or_default();
        match files.get(path) {
            None => {
                let words = format!("`{}` is listed in manifest.json but missing", shown(path));
                let role = entry["role"].as_str().and_then(Role::of_word);
                if role.is_some_and(Role::is_written_into) {
                    found.notes.push(words);
                } else {
                    found.names_missing = true;
                    found.remarks.push(words);
                }
            }
            Some((_, role, bytes)) if sha256(bytes) != hash => {
                let words = format!(
                    "`{path}` was changed after it was made: its hash is not that of manifest.json"
                );
                if role.is_written_into() {
                    found.notes.push(words);
                } else {
                    found.changed += usize::from(role.is_read_back());
                    found.remarks.push(words);
                }
            }
            Some(_) => {}
        }
    }
}

/// The control and the inputs that a kit was made for, against those of the job.
fn compare_origin(found: &mut Found, document: &Value, inputs: &Inputs) {
    let id = &inputs.profile.id;
    if let Some(other) = document["controller"].as_str().filter(|other| other != id) {
        let words = format!(
            "the kit was made for another control: manifest.json names `{}`, the job `{id}`",
            shown(other)
        );
        let help = "name the job that this kit was made from, or the kit of this job";
        found.other_control = Some(Problem::new(words.clone()).help(help));
        found.remarks.push(words);
    }
    let Some(known) = document["inputs"].as_array() else {
        return;
    };
    let other = |input: &&HashedFile| !known.iter().any(|k| k["sha256"] == json!(input.sha256));
    let names: Vec<String> = inputs
        .hashes
        .iter()
        .filter(other)
        .map(|i| format!("`{}`", shown(&i.path)))
        .collect();
    if !names.is_empty() {
        found.other_inputs = Some(format!(
            "the kit was made from other inputs: {} differ{} from what manifest.json has",
            names.join(", "),
            if names.len() == 1 { "s" } else { "" }
        ));
    }
}
