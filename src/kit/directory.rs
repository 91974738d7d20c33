//! A directory with files of a control: a kit, or what was read out; as it stands, and what its manifest
//! says against it.

use super::simulate::Loaded as SimulatedTables;
use super::{
    Inputs, LoadedControl, Verification, load, load_read_out, sha256, verify, verify_read_out,
};
use crate::control::controller::{Profile, Role};
use crate::judge::active::{ActiveControl, ReadOutFor, from_read_out};
use crate::judge::findings::InControl;
use crate::kit::manifest::{HashedFile, MANIFEST};
use crate::read::{KitFile, is_whole, may_be_meant_for};
use crate::text::document::json_page;
use crate::text::finding::{Finding, Severity};
use crate::text::problem::{Problem, Problems, shown};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeSet;

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
pub struct Directory {
    /// How a person called it.
    path: String,
    /// What the control could read.
    files: Vec<NamedFile>,
    /// Sentences that make the verdict `fail`.
    remarks: Vec<String>,
    /// What was ignored, and what may explain a disagreement.
    notes: Vec<String>,
    /// A listed file that is missing is among the remarks.
    names_missing: bool,
    /// How many of the remarks are files with another hash than in the manifest that a reader takes.
    changed: usize,
    /// The kit was made for another control.
    other_control: Option<Problem>,
    /// Inputs of the job that differ from those the kit was made from, in a sentence.
    other_inputs: Option<String>,
    /// `state` of its manifest: the control outside the files.
    state: Option<Value>,
}

impl Directory {
    /// The files of a directory against its manifest, where it has one.
    pub fn of(
        inputs: &Inputs,
        path: String,
        files: Vec<(String, Vec<u8>)>,
        manifest: Option<&[u8]>,
    ) -> Result<Directory, Problem> {
        let profile = &inputs.profile;
        let files = files.into_iter();
        let mut found = Directory {
            path,
            files: files
                .map(|(name, bytes)| (role_of(profile, &name), name, bytes))
                .map(|(role, name, bytes)| (name, role, bytes))
                .collect(),
            ..Directory::default()
        };
        let Some(manifest) = manifest else {
            return Ok(found);
        };
        let document: Value = json_page(manifest).map_err(|error| {
            Problem::new(format!("`manifest.json` is damaged: {error}"))
                .help("make the kit again; without `manifest.json` the tables alone are judged")
        })?;
        found.ignore_unlisted(&document, profile);
        found.compare_hashes(&document);
        found.compare_origin(&document, inputs);
        found.state = Some(document["state"].clone());
        if let Some(name) = found.whole_file(profile) {
            let words = format!(
                "`{}` holds far more than a kit, so it is the control's own: put what was read out into a directory without manifest.json and name that",
                shown(name)
            );
            found.notes.push(words);
        }
        Ok(found)
    }

    /// A file that was left out, and why.
    pub fn ignored(&mut self, name: &str, why: &str) {
        let words = format!("`{}` was ignored: {why}", shown(name));
        self.notes.push(words);
    }

    /// The files as the readers take them.
    pub fn kit_files(&self) -> Vec<KitFile<'_>> {
        self.files.iter().map(kit_file).collect()
    }

    /// The files in the emulated control of the job, with what the manifest says against them.
    pub fn load(&self, inputs: &Inputs) -> Result<LoadedControl, Problems> {
        let mut loaded = match self.read_out(inputs)? {
            Some(control) => load_read_out(inputs, &control)?,
            None => load(inputs, &self.kit_files(), self.state.as_ref())
                .map_err(|problems| self.instead_of(problems))?,
        };
        let differs = |words: &String| {
            Finding::from(InControl::Differs {
                words: words.clone(),
            })
        };
        let note = |words: &String| {
            Finding::from(InControl::Read {
                words: words.clone(),
            })
        };
        loaded.findings.extend(self.remarks.iter().map(differs));
        loaded.findings.splice(0..0, self.notes.iter().map(note));
        Ok(loaded)
    }

    /// The same for a rehearsal: what the manifest says against the files is a note.
    pub(crate) fn rehearse(&self, inputs: &Inputs) -> Result<SimulatedTables, Problems> {
        let mut loaded = match self.read_out(inputs)? {
            Some(active) => SimulatedTables::read_out(inputs, &active)?,
            None => SimulatedTables::read(inputs, &self.kit_files(), self.state.as_ref())
                .map_err(|problems| self.instead_of(problems))?,
        };
        let notes = self.remarks.iter().chain(&self.notes).cloned();
        loaded.notes.splice(0..0, notes);
        Ok(loaded)
    }

    /// The files judged against the job.
    pub fn verify(&self, inputs: &Inputs) -> Result<Verification, Problems> {
        let mut verification = match self.read_out(inputs)? {
            Some(control) => verify_read_out(inputs, &control)?,
            None => self.verify_kit(inputs)?,
        };
        if self.names_missing {
            // A listed file that is missing was named.
            let is_note = |found: &Finding| found.severity() == Severity::Note;
            verification.findings.retain(|found| !is_note(found));
        }
        let notes = self.notes.iter().chain(&self.other_inputs);
        notes.for_each(|words| verification.note(words.clone()));
        Ok(verification)
    }

    fn verify_kit(&self, inputs: &Inputs) -> Result<Verification, Problems> {
        let named = self.state.as_ref();
        let mut verification = verify(inputs, &self.kit_files(), named, self.remarks.clone())
            .map_err(|problems| self.instead_of(problems))?;
        if named.is_none() {
            let words = format!(
                "there is no {MANIFEST}, so nothing tells whether all files are there and as they were made"
            );
            verification.note(words);
            if let Some(name) = self.called_as_a_kit(&inputs.profile) {
                verification.note(format!(
                    "judged as a kit that is to be loaded, because `{}` is called as in one: give files that were read out of the control other names",
                    shown(name)
                ));
            }
        }
        let differences = verification.disagreements().len();
        if differences > 0 && differences == self.changed && self.remarks.len() == differences {
            let words = "read back, tables and switches are as the job asks: what differs is something else (line ends, comments, words such as NEWCONF, more memory); copy the files from the kit again";
            verification.note(words.to_string());
        }
        Ok(verification)
    }

    /// The control that was read out, where the files have no manifest and none is called as in a
    /// kit, or one is the control's whole parameter file (a Fanuc control itself calls it
    /// `CNC-PARA.TXT`). `None` where the files are a kit's.
    fn read_out(&self, inputs: &Inputs) -> Result<Option<ActiveControl>, Problems> {
        let is_called_as_a_kit = self.called_as_a_kit(&inputs.profile).is_some();
        let whole = self.whole_file(&inputs.profile);
        if self.state.is_some() || (is_called_as_a_kit && whole.is_none()) {
            return Ok(None);
        }
        let files = self.files.iter();
        let files = files.map(|(name, _, bytes)| (name.clone(), bytes.clone()));
        let mut control = from_read_out(
            &inputs.job,
            &inputs.profile,
            &self.path,
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
    fn called_as_a_kit(&self, profile: &Profile) -> Option<&str> {
        let own = |name: &str| {
            let mut files = profile.files.iter().filter(|f| f.role.is_read_back());
            files.any(|file| file.path.eq_ignore_ascii_case(name))
        };
        let mut names = self.files.iter().map(|(name, _, _)| name.as_str());
        names.find(|name| own(name))
    }

    /// The name of the control's whole parameter file or archive.
    fn whole_file(&self, profile: &Profile) -> Option<&str> {
        let mut files = self.files.iter();
        let found = files.find(|(_, _, bytes)| is_whole(profile, bytes));
        found.map(|(name, _, _)| name.as_str())
    }

    /// Files of another control cannot be read: that reason in place of what a reader of this
    /// control makes of every line.
    fn instead_of(&self, problems: Problems) -> Problems {
        match &self.other_control {
            Some(reason) => reason.clone().into(),
            None => problems,
        }
    }

    /// A file that the manifest does not list is judged if the profile writes one of that name or the
    /// control could read it, else ignored.
    fn ignore_unlisted(&mut self, document: &Value, profile: &Profile) {
        let listed: BTreeSet<&str> = listed(document).map(|(path, _)| path).collect();
        for file in std::mem::take(&mut self.files) {
            let name = shown(&file.0);
            if listed.contains(file.0.as_str()) {
                self.files.push(file);
            } else if is_of_a_kit(profile, &file.0) || may_be_meant_for(profile, &kit_file(&file)) {
                let words = format!(
                    "`{name}` is not listed in manifest.json, and the control could read it"
                );
                self.remarks.push(words);
                self.files.push(file);
            } else {
                let why = "manifest.json does not list it, and it is no file of this control";
                self.ignored(&file.0, why);
            }
        }
    }

    fn compare_hashes(&mut self, document: &Value) {
        let bytes = |name: &str| {
            let file = self.files.iter().find(|(path, _, _)| path == name);
            Ok(file.map(|(_, role, bytes)| (Some(*role), Cow::Borrowed(bytes.as_slice()))))
        };
        for fault in faults(document, bytes) {
            if fault.role.is_some_and(Role::is_written_into) {
                self.notes.push(fault.words);
                continue;
            }
            match fault.kind {
                FaultKind::Missing => self.names_missing = true,
                FaultKind::Changed => {
                    self.changed += usize::from(fault.role.is_some_and(Role::is_read_back));
                }
                FaultKind::Other => {}
            }
            self.remarks.push(fault.words);
        }
    }

    /// The control and the inputs that a kit was made for, against those of the job.
    fn compare_origin(&mut self, document: &Value, inputs: &Inputs) {
        let id = &inputs.profile.id;
        if let Some(other) = document["controller"].as_str().filter(|other| other != id) {
            let words = format!(
                "the kit was made for another control: manifest.json names `{}`, the job `{id}`",
                shown(other)
            );
            let help = "name the job that this kit was made from, or the kit of this job";
            self.other_control = Some(Problem::new(words.clone()).help(help));
            self.remarks.push(words);
        }
        let Some(known) = document["inputs"].as_array() else {
            return;
        };
        let other = |input: &&HashedFile| !known.iter().any(|k| k["sha256"] == json!(input.sha256));
        let names = inputs.hashes.iter().filter(other);
        let names: Vec<String> = names.map(|i| format!("`{}`", shown(&i.path))).collect();
        if !names.is_empty() {
            self.other_inputs = Some(format!(
                "the kit was made from other inputs: {} differ{} from what manifest.json has",
                names.join(", "),
                if names.len() == 1 { "s" } else { "" }
            ));
        }
    }
}

/// A file that the profile does not know is taken for tables.
fn role_of(profile: &Profile, name: &str) -> Role {
    let mut files = profile.files.iter();
    let known = files.find(|file| file.path.eq_ignore_ascii_case(name));
    known.map_or(Role::Table, |file| file.role)
}

/// Whether the profile writes a file of this name, other than those into which people write.
fn is_of_a_kit(profile: &Profile, name: &str) -> bool {
    let mut files = profile.files.iter();
    files.any(|file| !file.role.is_written_into() && file.path.eq_ignore_ascii_case(name))
}

/// What the manifest lists, by path.
fn listed(document: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let entries = document["files"].as_array().into_iter().flatten();
    entries.map(|entry| (entry["path"].as_str().unwrap_or_default(), entry))
}

/// A difference of the files from what their manifest lists.
pub struct Fault {
    /// Which.
    pub kind: FaultKind,
    /// What the file is for, as far as known.
    pub role: Option<Role>,
    /// One sentence.
    pub words: String,
}

/// What is wrong with a listed file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// It is not there.
    Missing,
    /// Its hash is another one.
    Changed,
    /// It is listed twice, has no name of a file, or cannot be read.
    Other,
}

/// Purpose (where it is known better than from the manifest) and bytes of a file.
type Bytes<'a> = (Option<Role>, Cow<'a, [u8]>);

/// How the files of a directory differ from what its manifest lists.
pub fn faults<'a>(
    document: &Value,
    bytes_of: impl Fn(&str) -> Result<Option<Bytes<'a>>, Problem>,
) -> Vec<Fault> {
    let mut seen = std::collections::BTreeMap::<&str, usize>::new();
    let mut faults = Vec::new();
    for (path, entry) in listed(document) {
        let name = shown(path);
        let mut found = |kind, role, words| faults.push(Fault { kind, role, words });
        let times = seen.entry(path).or_default();
        *times += 1;
        if *times == 2 {
            let words = format!("`{name}` is listed twice in manifest.json");
            found(FaultKind::Other, None, words);
        }
        if *times > 1 {
            continue;
        }
        if !is_plain_name(path) {
            let words = format!("`{name}` is no plain file name");
            found(FaultKind::Other, None, words);
            continue;
        }
        let role = entry["role"].as_str().and_then(Role::of_word);
        match bytes_of(path) {
            Err(problem) => found(FaultKind::Other, None, problem.message),
            Ok(None) => {
                let words = format!("`{name}` is listed in manifest.json but missing");
                found(FaultKind::Missing, role, words);
            }
            Ok(Some((known, bytes))) if Some(&*sha256(&bytes)) != entry["sha256"].as_str() => {
                let words = format!(
                    "`{name}` was changed after it was made: its hash is not that of manifest.json"
                );
                found(FaultKind::Changed, known.or(role), words);
            }
            Ok(Some(_)) => {}
        }
    }
    faults
}

/// A manifest lists files of its own directory and nothing else.
fn is_plain_name(name: &str) -> bool {
    std::path::Path::new(name).file_name() == Some(name.as_ref())
        && !name.contains(['/', '\\', ':'])
}
