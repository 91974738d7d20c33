//! A directory with files of a control: a kit, or what was read out; as it stands, and what its manifest
//! says against it.

use super::simulate::rehearsed;
use super::{Inputs, JobTables, Loaded, Verification, sha256, verify, verify_read_out};
use crate::control::controller::{KitFile, Profile, Role};
use crate::judge::active::{
    ActiveControl, Fault, HashedFile, KitManifest, ReadOutFor, State, faults, from_read_out,
};
use crate::judge::findings::{FileFault, InControl};
use crate::kit::findings::InDirectory;
use crate::kit::refusals;
use crate::read::{is_whole, may_be_meant_for};
use crate::text::{
    Finding, FindingKind, Problem, Problems, Severity, json_page, of_severity, shown,
};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The files of a directory, and what its manifest says against them.
#[derive(Default)]
pub struct Directory {
    /// How a person called it.
    path: String,
    /// What the control could read.
    pub(crate) files: Vec<KitFile>,
    /// What makes the verdict `fail` (disagreements); what was ignored, and what may explain a
    /// disagreement (notes).
    findings: Vec<Finding>,
    /// How many of them are files with another hash than in the manifest that a reader takes.
    changed: usize,
    /// The kit was made for another control.
    other_control: Option<Problem>,
    /// Inputs of the job that differ from those the kit was made from.
    other_inputs: Option<Finding>,
    /// What its manifest says.
    manifest: Option<KitManifest>,
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
        let named = |(path, bytes): (String, _)| {
            // What the profile does not know is taken for tables.
            let role = profile.file(&path).map_or(Role::Table, |file| file.role);
            KitFile { path, role, bytes }
        };
        let files = files.into_iter().map(named).collect();
        let mut found = Directory { path, files, ..Directory::default() };
        let Some(manifest) = manifest else {
            found.ensure_holds_no_input(inputs)?;
            return Ok(found);
        };
        let document: KitManifest = json_page(manifest).map_err(refusals::damaged_manifest)?;
        found.ignore_unlisted(&document.files, profile);
        found.compare_hashes(&document.files);
        found.compare_origin(&document, inputs);
        found.manifest = Some(document);
        if let Some(file) = found.whole_file(profile).map(shown) {
            found.findings.push(InDirectory::WholeControl { file }.into());
        }
        Ok(found)
    }

    /// The folder of a visit is no kit: with a file among them that the tables are made from (no old table of the control)
    /// every file would be complained of.
    fn ensure_holds_no_input(&self, inputs: &Inputs) -> Result<(), Problem> {
        let is_input = |file: &&KitFile| {
            let own = sha256(&file.bytes);
            let mut active = inputs.active.iter().flat_map(|active| &active.files);
            active.all(|(_, bytes)| *bytes != file.bytes)
                && inputs.hashes.iter().any(|input| input.sha256 == own)
        };
        let found = self.files.iter().find(is_input);
        found.map_or(Ok(()), |file| Err(refusals::holds_input(&self.path, shown(&file.path))))
    }

    /// A file that was left out, and why.
    pub fn ignored(&mut self, name: &str, why: &'static str) {
        self.findings.push(InDirectory::Ignored { file: shown(name), why }.into());
    }

    /// The files in the emulated control of the job, with what the manifest says against them.
    pub(crate) fn load<'a>(&self, inputs: &'a Inputs) -> Result<Loaded<'a>, Problems> {
        let active = self.read_out(inputs)?;
        let loaded = JobTables::of(inputs).and_then(|asked| match active {
            Some(active) => Loaded::read_out(asked, &active),
            None => Loaded::kit(asked, &self.files, self.state()),
        });
        let mut loaded = loaded.map_err(|problems| self.instead_of(problems))?;
        self.add_to(&mut loaded);
        Ok(loaded)
    }

    /// The control outside the files, as the manifest says.
    fn state(&self) -> Option<&State> {
        self.manifest.as_ref()?.state.as_ref()
    }

    /// Where the files lie, and what the manifest says against them.
    fn add_to(&self, loaded: &mut Loaded<'_>) {
        loaded.directory = Some(self.path.clone());
        let own = std::mem::take(&mut loaded.findings);
        loaded.findings = [self.notes(), own, self.faults()].concat();
        if let (Some(reason), Err(_)) = (&self.other_control, &loaded.control) {
            loaded.control = Err(reason.clone().into());
        }
    }

    /// The same for a rehearsal: what the manifest says against the files is a note.
    pub(crate) fn rehearse<'a>(&self, inputs: &'a Inputs) -> Result<Loaded<'a>, Problems> {
        let mut loaded = match self.read_out(inputs)? {
            Some(active) => Loaded::read_out(JobTables::of(inputs)?, &active)?,
            None => rehearsed(inputs, &self.files, self.state())
                .map_err(|problems| self.instead_of(problems))?,
        };
        let own = loaded.findings.clone();
        self.add_to(&mut loaded);
        loaded.findings = [self.faults(), self.notes(), own].concat();
        Ok(loaded)
    }

    /// What the manifest says against the files.
    fn faults(&self) -> Vec<Finding> {
        of_severity(&self.findings, Severity::Disagreement)
    }

    fn notes(&self) -> Vec<Finding> {
        of_severity(&self.findings, Severity::Note)
    }

    /// The files judged against the job.
    pub fn verify<'a>(&self, inputs: &'a Inputs) -> Result<Verification<'a>, Problems> {
        let mut verification = match self.read_out(inputs)? {
            Some(control) => verify_read_out(inputs, &control)?,
            None => self.verify_kit(inputs)?,
        };
        let is_missing = |f: &Finding| matches!(f.kind(), Some(FileFault::Missing { .. }));
        if self.findings.iter().any(is_missing) {
            // A listed file that is missing was named.
            let is_note = |found: &Finding| found.severity() == Severity::Note;
            verification.findings.retain(|found| !is_note(found));
        }
        verification.findings.extend(self.notes().into_iter().chain(self.other_inputs.clone()));
        self.add_to(&mut verification.loaded);
        Ok(verification)
    }

    fn verify_kit<'a>(&self, inputs: &'a Inputs) -> Result<Verification<'a>, Problems> {
        let mut verification = verify(inputs, &self.files, self.state(), self.faults())
            .map_err(|problems| self.instead_of(problems))?;
        if self.manifest.is_none() {
            let called = self.called_as_a_kit(&inputs.profile).map(shown);
            let called = called.map(|file| InDirectory::CalledAsAKit { file });
            let notes = [InDirectory::NoManifest].into_iter().chain(called);
            verification.findings.extend(notes.map(Finding::from));
        }
        let differences = verification.disagreements().len();
        if differences > 0 && [self.changed, self.faults().len()] == [differences; 2] {
            verification.findings.push(InDirectory::ActsTheSame.into());
        }
        Ok(verification)
    }

    /// The control that was read out, where the files have no manifest and none is called as in a
    /// kit, or one is the control's whole parameter file (a Fanuc control itself calls it
    /// `CNC-PARA.TXT`). `None` where the files are a kit's.
    fn read_out(&self, inputs: &Inputs) -> Result<Option<ActiveControl>, Problems> {
        let is_called_as_a_kit = self.called_as_a_kit(&inputs.profile).is_some();
        let whole = self.whole_file(&inputs.profile);
        if self.manifest.is_some() || (is_called_as_a_kit && whole.is_none()) {
            return Ok(None);
        }
        let files = self.files.iter().map(|file| (file.path.clone(), file.bytes.clone()));
        let Inputs { job, profile, .. } = inputs;
        let files = files.collect();
        let mut control = from_read_out(job, profile, &self.path, files, ReadOutFor::Judging)?;
        if let Some(file) = whole.filter(|_| is_called_as_a_kit).map(shown) {
            control.findings.insert(0, InControl::FarMore { file }.into());
        }
        Ok(Some(control))
    }

    /// A file with a name that a kit's file for the control has.
    fn called_as_a_kit(&self, profile: &Profile) -> Option<&str> {
        let own = profile.files.iter().filter(|file| file.role.is_read_back());
        let mut names = self.files.iter().map(|file| file.path.as_str());
        names.find(|name| own.clone().any(|file| file.is_called(name)))
    }

    /// The name of a file that was read out of the control as a whole.
    fn whole_file(&self, profile: &Profile) -> Option<&str> {
        self.files.iter().find(|file| is_whole(profile, &file.bytes)).map(|file| file.path.as_str())
    }

    /// Files of another control cannot be read: that reason in place of what a reader of this
    /// control makes of every line.
    fn instead_of(&self, problems: Problems) -> Problems {
        self.other_control.as_ref().map_or(problems, |reason| reason.clone().into())
    }

    /// A file that the manifest does not list is judged if the profile writes one of that name or the
    /// control could read it, else ignored.
    fn ignore_unlisted(&mut self, listed: &[HashedFile], profile: &Profile) {
        let listed: BTreeSet<&str> = listed.iter().map(|file| file.path.as_str()).collect();
        for file in std::mem::take(&mut self.files) {
            let path = file.path.as_str();
            if listed.contains(path) {
                self.files.push(file);
            } else if profile.file(path).is_some_and(|own| !own.role.is_written_into())
                || may_be_meant_for(profile, &file)
            {
                self.findings.push(InDirectory::NotListed { file: shown(path) }.into());
                self.files.push(file);
            } else {
                let why = "manifest.json does not list it, and it is no file of this control";
                self.ignored(path, why);
            }
        }
    }

    fn compare_hashes(&mut self, listed: &[HashedFile]) {
        let bytes = |name: &str| {
            let file = self.files.iter().find(|file| file.path == name);
            Ok(file.map(|file| (Some(file.role), Cow::Borrowed(file.bytes.as_slice()))))
        };
        for Fault { kind, role } in faults(listed, bytes) {
            if role.is_some_and(Role::is_written_into) {
                self.findings.push(InDirectory::WrittenInto { fault: kind.into() }.into());
                continue;
            }
            let is_changed = matches!(kind, FileFault::Changed { .. });
            self.changed += usize::from(is_changed && role.is_some_and(Role::is_read_back));
            self.findings.push(kind.into());
        }
    }

    /// The control and the inputs that a kit was made for, against those of the job.
    fn compare_origin(&mut self, document: &KitManifest, inputs: &Inputs) {
        let id = &inputs.profile.id;
        if let Some(other) = document.controller.as_ref().filter(|other| *other != id) {
            let found = InDirectory::OtherControl { made_for: shown(other), own: id.clone() };
            self.other_control = Some(refusals::other_control(found.words()));
            self.findings.push(found.into());
        }
        let Some(known) = &document.inputs else {
            return;
        };
        let other = |input: &&HashedFile| !known.iter().any(|k| k.sha256 == input.sha256);
        let names = inputs.hashes.iter().filter(other);
        let names: Vec<String> = names.map(|i| format!("`{}`", shown(&i.path))).collect();
        if !names.is_empty() {
            self.other_inputs = Some(InDirectory::OtherInputs { names }.into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::controller::builtin;
    use crate::inputs::error_table::ErrorTable;
    use crate::inputs::job::Job;
    use crate::kit::hashed;
    use crate::text::Source;

    #[test]
    fn old_tables_are_files_of_the_control_and_errors_are_none() {
        let folder = format!("{}/fixtures/base/read-out/", env!("CARGO_MANIFEST_DIR"));
        let bytes = |name: &str| std::fs::read(folder.clone() + name).unwrap();
        let source = |name| Source::from_bytes(name, &bytes(name)).unwrap();
        let old = [bytes("old.arc"), b"M17\n".to_vec()].concat();
        let of_control = || vec![("old.arc".to_string(), old.clone())];
        let hashes = vec![hashed("errors.csv", &bytes("errors.csv")), hashed("old.arc", &old)];
        let job = Job::read(source("job.toml")).unwrap();
        let errors = ErrorTable::read(source("errors.csv")).unwrap();
        let profile = builtin::profile(&job.compensation.controller).unwrap();
        let purpose = ReadOutFor::OldTables;
        let active = from_read_out(&job, &profile, "old.arc", of_control(), purpose).unwrap();
        let inputs = Inputs::new(job, profile, &errors, hashes).unwrap();
        let inputs = inputs.with_active(active).unwrap();
        let found = |files| Directory::of(&inputs, "out".to_string(), files, None);
        assert!(found(of_control()).unwrap().read_out(&inputs).unwrap().is_some());
        let both = [of_control(), vec![("a.csv".to_string(), bytes("errors.csv"))]].concat();
        assert!(found(both).err().unwrap().message.contains("holds `a.csv`"));
    }
}
