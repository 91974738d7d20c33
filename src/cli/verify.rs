//! `nonius verify JOB --tables DIR`

use crate::cli::inputs::{self, plain_words, read_file};
use crate::cli::{Answer, Format, print, print_json, show};
use crate::controller::{Profile, Role};
use crate::forecast::Verdict;
use crate::kit::{Inputs, Verification, sha256, verify};
use crate::manifest::{diagonals, picometres};
use crate::problem::{Problem, Problems};
use crate::readback::kit::KitFile;
use serde_json::{Map, Value, json};
use std::path::Path;

pub(super) fn run(job: &Path, directory: &Path, format: Format) -> Result<Answer, Problems> {
    let inputs = inputs::read(job)?;
    let found = read_directory(&inputs.profile, directory)?;
    let files: Vec<KitFile<'_>> = found
        .files
        .iter()
        .map(|(path, role, bytes)| KitFile {
            path,
            role: *role,
            bytes,
        })
        .collect();
    let mut verification = verify(&inputs, &files, found.remarks)?;
    if found.has_manifest {
        verification.absent.clear(); // a listed file that is missing was named
    }
    match format {
        Format::Json => print_json(&document(&inputs, &verification))?,
        Format::Text => print(&report(&inputs, directory, &verification))?,
    };
    Ok(if verification.verdict == Verdict::Pass {
        Answer::Yes
    } else {
        Answer::No
    })
}

/// The files of a directory, and what its manifest says against them.
struct Found {
    files: Vec<(String, Role, Vec<u8>)>,
    remarks: Vec<String>,
    has_manifest: bool,
}

fn read_directory(profile: &Profile, directory: &Path) -> Result<Found, Problems> {
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
    if !names.iter().any(|name| name != "manifest.json") {
        return Err(Problem::new(format!(
            "`{}` holds no file of a control, expected its tables",
            directory.display()
        ))
        .help("name the directory with the control's files, as `nonius generate` wrote it")
        .into());
    }
    let mut files = Vec::new();
    for name in names.iter().filter(|name| *name != "manifest.json") {
        let bytes = read_file(&directory.join(name))?;
        files.push((name.clone(), role_of(profile, name), bytes));
    }
    let manifest = directory.join("manifest.json");
    let has_manifest = manifest.is_file();
    let remarks = if has_manifest {
        changed_files(&read_file(&manifest)?, &files)?
    } else {
        Vec::new()
    };
    Ok(Found {
        files,
        remarks,
        has_manifest,
    })
}

/// A file that the profile does not know is taken for tables.
fn role_of(profile: &Profile, name: &str) -> Role {
    let known = profile
        .files
        .iter()
        .find(|file| file.path.eq_ignore_ascii_case(name));
    known.map_or(Role::Table, |file| file.role)
}

fn changed_files(
    manifest: &[u8],
    files: &[(String, Role, Vec<u8>)],
) -> Result<Vec<String>, Problems> {
    let document: Value = serde_json::from_slice(manifest).map_err(|error| {
        Problem::new(format!("`manifest.json` is damaged: {error}"))
            .help("make the kit again; without `manifest.json` the tables alone are judged")
    })?;
    let listed = document["files"].as_array().cloned().unwrap_or_default();
    let mut remarks = Vec::new();
    for entry in &listed {
        let (path, hash) = (
            entry["path"].as_str().unwrap_or_default(),
            entry["sha256"].as_str().unwrap_or_default(),
        );
        match files.iter().find(|(name, _, _)| name == path) {
            None => remarks.push(format!("`{path}` is listed in manifest.json but missing")),
            Some((_, _, bytes)) if sha256(bytes) != hash => {
                remarks.push(format!(
                    "`{path}` was changed after it was made: its hash is not that of manifest.json"
                ));
            }
            Some(_) => {}
        }
    }
    for (name, _, _) in files {
        if !listed.iter().any(|entry| entry["path"] == json!(name)) {
            remarks.push(format!("`{name}` is not listed in manifest.json"));
        }
    }
    Ok(remarks)
}

fn report(inputs: &Inputs, directory: &Path, verification: &Verification) -> String {
    let heading = format!(
        "{} - {}, tables read from {}",
        inputs.job.machine.name,
        inputs.profile.name,
        directory.display()
    );
    let forecast = verification.forecast.as_ref();
    let agreement = if verification.disagreements.is_empty() {
        "job and tables agree".to_string()
    } else {
        let lines: Vec<String> = verification
            .disagreements
            .iter()
            .map(|words| format!("  - {words}"))
            .collect();
        format!("job and tables DISAGREE:\n{}", lines.join("\n"))
    };
    show::paragraphs(&[
        heading,
        agreement,
        forecast.map(show::forecast).unwrap_or_default(),
        show::verdict(
            verification.verdict,
            inputs.job.acceptance,
            forecast,
            !verification.disagreements.is_empty(),
        ),
        show::doubts(&inputs.job.measurement.doubts),
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
    let notes: Vec<&String> = verification
        .absent
        .iter()
        .chain(&verification.compiled.notes)
        .collect();
    let misses = forecast.map(|f| f.misses(inputs.job.acceptance));
    let causes: Vec<String> = verification
        .disagreements
        .iter()
        .cloned()
        .chain(misses.unwrap_or_default())
        .chain(inputs.job.measurement.doubts.iter().cloned())
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
