//! What the program refuses, and in which words: one folder of `fixtures/cases/refuses` each.
//!
//! The real program runs in a fresh directory that holds the inputs of the case only. It must end
//! with status 2, say exactly what `expected.txt` says, and leave the directory as it was.
//! `NONIUS_UPDATE=1 cargo test --test refuses` rewrites the expectations (fixtures/cases/README.md).

#![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Arguments of a case without a `command` file.
const DEFAULT_COMMAND: &str = "generate job.toml -o kit";
/// Files of a case that are not its inputs.
const NOT_INPUTS: [&str; 2] = ["command", "expected.txt"];
/// A glob that finds nothing must not pass.
const LEAST_CASES: usize = 55;

#[test]
fn every_refusal_says_what_is_wrong_and_writes_nothing() {
    let cases = cases();
    assert!(
        cases.len() >= LEAST_CASES,
        "only {} cases found, expected at least {LEAST_CASES}",
        cases.len()
    );
    let failures: Vec<String> = cases.iter().filter_map(|case| run(case).err()).collect();
    assert!(
        failures.is_empty(),
        "{} of {} cases differ; if the new words are meant, run with NONIUS_UPDATE=1\n\n{}",
        failures.len(),
        cases.len(),
        failures.join("\n\n")
    );
}

fn cases() -> Vec<PathBuf> {
    let pattern = format!(
        "{}/fixtures/cases/refuses/*/",
        env!("CARGO_MANIFEST_DIR").replace('\\', "/")
    );
    glob::glob(&pattern)
        .expect("the pattern is valid")
        .map(|entry| entry.expect("a case can be read"))
        .collect()
}

/// Runs one case; the failure says what differs.
fn run(case: &Path) -> Result<(), String> {
    let name = case.file_name().expect("a case has a name");
    let name = name.to_string_lossy();
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    copy_inputs(case, directory.path());
    let before = content(directory.path());
    let command = fs::read_to_string(case.join("command"));
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(
            command
                .as_deref()
                .unwrap_or(DEFAULT_COMMAND)
                .split_whitespace(),
        )
        .current_dir(directory.path())
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    if content(directory.path()) != before {
        return Err(format!("{name}: something was written"));
    }
    let said = told(&output);
    if output.status.code() != Some(2) {
        return Err(format!("{name}: expected exit status 2\n{said}"));
    }
    let path = case.join("expected.txt");
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        fs::write(&path, said).expect("expected.txt can be written");
        return Ok(());
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    if expected.replace('\r', "") == said {
        return Ok(());
    }
    Err(format!("{name}:\n--- expected\n{expected}--- got\n{said}"))
}

/// Exit status, standard error, then standard output, as one text.
fn told(output: &Output) -> String {
    let text = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).expect("the program prints UTF-8");
        text.replace('\r', "").replace("nonius.exe", "nonius")
    };
    let status = output
        .status
        .code()
        .map_or("none".to_string(), |c| c.to_string());
    format!(
        "exit status {status}\n\n{}{}",
        text(&output.stderr),
        text(&output.stdout)
    )
}

fn copy_inputs(case: &Path, to: &Path) {
    for entry in fs::read_dir(case).expect("a case can be read") {
        let entry = entry.expect("a case can be read");
        let (from, name) = (entry.path(), entry.file_name());
        if NOT_INPUTS.iter().any(|other| name == *other) {
            continue;
        }
        if from.is_dir() {
            fs::create_dir(to.join(&name)).expect("a directory can be made");
            copy_inputs(&from, &to.join(name));
        } else {
            fs::copy(&from, to.join(name)).expect("an input can be copied");
        }
    }
}

/// Every file below a directory with its bytes; directories have none.
fn content(directory: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(directory).expect("the directory can be read") {
        let path = entry.expect("the directory can be read").path();
        if path.is_dir() {
            found.extend(content(&path));
            found.insert(path, None);
        } else {
            let bytes = fs::read(&path).expect("a file can be read");
            found.insert(path, Some(bytes));
        }
    }
    found
}
