//! `nonius verify JOB --tables DIR [--after FILE|JOB]`

mod page;
mod second;

use crate::active::from_read_out;
use crate::cli::inputs::{self, plain_words, read_file};
use crate::cli::{Answer, Format, print, print_json, say, show};
use crate::controller::{Profile, Role};
use crate::forecast::{Forecast, Verdict};
use crate::kit::{Inputs, Verification, sha256, verify, verify_read_out};
use crate::manifest::{HashedFile, MANIFEST, diagonals, picometres};
use crate::problem::{Problem, Problems, shown};
use crate::readback::control_data;
use crate::readback::kit::{KitFile, may_be_meant_for};
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Options of `verify`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Directory with the control's files
    #[arg(long, value_name = "DIR")]
    tables: PathBuf,
    /// A measurement with these tables active, against the forecast: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB")]
    after: Option<PathBuf>,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Answer, Problems> {
    let (directory, format) = (options.tables.as_path(), options.format);
    let inputs = inputs::read(&options.job)?;
    let second = options
        .after
        .as_deref()
        .map(|path| second::read(&inputs, path, directory))
        .transpose()?;
    let found = read_directory(&inputs, directory)?;
    let mut verification = judged(&inputs, directory, &found)?;
    if found.names_missing {
        verification.absent.clear(); // a listed file that is missing was named
    }
    let notes = found.notes.iter().chain(&found.other_inputs);
    verification.absent.extend(notes.cloned());
    if let Some(second) = second {
        return page::answer(&inputs, directory, &verification, &second, format);
    }
    match format {
        Format::Json => print_json(&document(&inputs, &verification))?,
        Format::Text => {
            let verdict = verdict(&inputs, &verification);
            print_page(
                &report(&inputs, directory, &verification, &verdict),
                &verdict,
            )?
        }
    };
    Ok(if verification.verdict == Verdict::Pass {
        Answer::Yes
    } else {
        Answer::No
    })
}

/// The files of a directory against the job.
fn judged(inputs: &Inputs, directory: &Path, found: &Found) -> Result<Verification, Problems> {
    if !found.is_read_out(&inputs.profile) {
        return judged_as_kit(inputs, found);
    }
    let files = found.files.iter();
    let files = files.map(|(name, _, bytes)| (name.clone(), bytes.clone()));
    let path = directory.display().to_string();
    let control = from_read_out(&inputs.job, &inputs.profile, &path, files.collect())?;
    let mut verification = verify_read_out(inputs, &control)?;
    let whole = found.whole_file(&inputs.profile);
    if let Some(name) = whole.filter(|_| found.is_called_as_a_kit(&inputs.profile)) {
        let words = format!(
            "`{}` holds far more than a kit: judged as read out of the control, not as to be loaded",
            shown(name)
        );
        verification.absent.insert(0, words);
    }
    Ok(verification)
}

fn judged_as_kit(inputs: &Inputs, found: &Found) -> Result<Verification, Problems> {
    let named = found.state.as_ref();
    let mut verification = verify(inputs, &found.kit_files(), named, found.remarks.clone())
        .map_err(|problems| found.instead_of(problems))?;
    if named.is_none() {
        let words = format!(
            "there is no {MANIFEST}, so nothing tells whether all files are there and as they were made"
        );
        verification.absent.push(words);
    }
    Ok(verification)
}

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
    other_inputs: Option<String>,
    /// A listed file that is missing is among the remarks.
    names_missing: bool,
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

    /// Files without a manifest that were read out of the control: none is called as in a kit, or
    /// one is the control's whole parameter file (a Fanuc control itself calls it `CNC-PARA.TXT`).
    fn is_read_out(&self, profile: &Profile) -> bool {
        self.state.is_none()
            && (!self.is_called_as_a_kit(profile) || self.whole_file(profile).is_some())
    }

    /// Whether a file has a name that a kit's file has.
    fn is_called_as_a_kit(&self, profile: &Profile) -> bool {
        let own = |name: &str| {
            let mut files = profile.files.iter();
            files.any(|file| file.path.eq_ignore_ascii_case(name))
        };
        self.files.iter().any(|(name, _, _)| own(name))
    }

    /// The name of the control's whole parameter file or archive.
    fn whole_file(&self, profile: &Profile) -> Option<&str> {
        let is_whole = |bytes: &[u8]| {
            std::str::from_utf8(bytes)
                .is_ok_and(|text| control_data::is_whole(text, &profile.dialect))
        };
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
    let mut names: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        if entry.file_type().map_err(refuse)?.is_file() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
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

fn parsed(manifest: &[u8]) -> Result<Value, Problem> {
    serde_json::from_slice(manifest).map_err(|error| {
        Problem::new(format!("`manifest.json` is damaged: {error}"))
            .help("make the kit again; without `manifest.json` the tables alone are judged")
    })
}

fn listed(document: &Value) -> Vec<Value> {
    document["files"].as_array().cloned().unwrap_or_default()
}

/// A file that the manifest does not list is judged if the control could read it, else passed over.
fn pass_over_unlisted(found: &mut Found, document: &Value, profile: &Profile) {
    let listed = listed(document);
    let files = std::mem::take(&mut found.files);
    for file in files {
        let name = shown(&file.0);
        if listed.iter().any(|entry| entry["path"] == json!(file.0)) {
            found.files.push(file);
        } else if may_be_meant_for(profile, &kit_file(&file)) {
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
    for entry in &listed(document) {
        let (path, hash) = (
            entry["path"].as_str().unwrap_or_default(),
            entry["sha256"].as_str().unwrap_or_default(),
        );
        match found.files.iter().find(|(name, _, _)| name == path) {
            None => {
                found.names_missing = true;
                let words = format!("`{}` is listed in manifest.json but missing", shown(path));
                found.remarks.push(words);
            }
            Some((_, role, bytes)) if sha256(bytes) != hash => {
                let words = format!(
                    "`{path}` was changed after it was made: its hash is not that of manifest.json"
                );
                if role.is_for_people() {
                    found.notes.push(words);
                } else {
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

fn heading(inputs: &Inputs, directory: &Path) -> String {
    format!(
        "{} - {}, tables read from {}",
        inputs.job.machine.name,
        inputs.profile.name,
        directory.display()
    )
}

fn agreement(verification: &Verification) -> String {
    if verification.disagreements.is_empty() {
        return "job and tables agree".to_string();
    }
    let lines: Vec<String> = verification
        .disagreements
        .iter()
        .map(|words| format!("  - {words}"))
        .collect();
    format!("job and tables DISAGREE:\n{}", lines.join("\n"))
}

fn verdict(inputs: &Inputs, verification: &Verification) -> String {
    show::verdict(
        verification.verdict,
        inputs.job.acceptance,
        verification.forecast.as_ref(),
        !verification.disagreements.is_empty(),
        &verification.doubts,
    )
}

/// The page, and the verdict once more after it: the page is long.
fn print_page(page: &str, verdict: &str) -> Result<Answer, Problems> {
    let printed = print(page)?;
    say(verdict);
    Ok(printed)
}

fn report(inputs: &Inputs, directory: &Path, verification: &Verification, verdict: &str) -> String {
    let forecast = verification.forecast.as_ref();
    show::paragraphs(&[
        heading(inputs, directory),
        agreement(verification),
        forecast.map(show::forecast).unwrap_or_default(),
        verdict.to_string(),
        absent(&verification.absent),
        show::remarks(&verification.plan, &verification.compiled, forecast),
        show::assumptions(&verification.compiled.assumptions),
    ])
}

fn absent(notes: &[String]) -> String {
    let lines: Vec<String> = notes.iter().map(|note| format!("note: {note}")).collect();
    lines.join("\n")
}

fn document(inputs: &Inputs, verification: &Verification) -> Value {
    let mut terms = Map::new();
    for term in verification.forecast.iter().flat_map(|f| &f.terms) {
        terms.insert(
            term.term.to_string(),
            json!({
                "before_um": picometres(term.before_um),
                "forecast_um": picometres(term.after_um),
                "u_um": term.u_um.map(picometres),
                "max_residual_um": picometres(term.after_um),
            }),
        );
    }
    let forecast = verification.forecast.as_ref();
    let notes: Vec<String> = verification
        .absent
        .iter()
        .chain(&verification.compiled.notes)
        .cloned()
        .chain(forecast.map(Forecast::worsened).unwrap_or_default())
        .collect();
    let misses = forecast.map(|f| f.misses(inputs.job.acceptance));
    let causes: Vec<String> = verification
        .disagreements
        .iter()
        .cloned()
        .chain(misses.unwrap_or_default())
        .chain(verification.doubts.iter().cloned())
        .collect();
    json!({
        "schema": 1,
        "verdict": verification.verdict.word(),
        "terms": terms,
        "max_residual_um": forecast.map(|f| picometres(f.max_residual_um())),
        "diagonals": forecast.map(|f| diagonals(&f.diagonals, "forecast_um")),
        "causes": causes,
        "assumptions": verification.compiled.assumptions,
        "notes": notes,
    })
}
