//! What a user may rely on around a kit: exit status, files, `--force`, formats of the input.
//! Tampered kits are in `tampered.rs`, refusals in `refuses.rs`.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

const JOB: &str = r#"
schema = 1

[machine]
name = "VMC 100"

[machine.axes.x]
travel_mm = [0.0, 101.6]
reference_mm = 0.0

[measurement]
errors = "errors.csv"
active_while_measuring = "none"

[compensation]
controller = "siemens-840d-sl"

[compensation.axes.x]
spacing_mm = 50.8

[acceptance]
max_deviation_um = 5.0
"#;
const TABLE: &str = "axis,position_mm,ex_um\nx,0,0\nx,50.8,2.54\nx,101.6,-1.27\n";

/// A fresh directory with a job and an error table.
fn machine(job: &str, table: &[u8]) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    put(directory.path(), "job.toml", job.as_bytes());
    put(directory.path(), "errors.csv", table);
    directory
}

fn put(directory: &Path, name: &str, bytes: &[u8]) {
    fs::write(directory.join(name), bytes).expect("a file can be written");
}

fn nonius(directory: &Path, command: &str) -> Output {
    program(directory, command).stdin(Stdio::null()).output().expect("the program starts")
}

fn program(directory: &Path, command: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_nonius"));
    program.args(command.split_whitespace()).current_dir(directory);
    program
}

fn expect_status(output: &Output, status: i32) {
    assert_eq!(
        output.status.code(),
        Some(status),
        "{}{}",
        String::from_utf8_lossy(&output.stderr),
        String::from_utf8_lossy(&output.stdout)
    );
}

/// The files of a directory with their bytes.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(directory).expect("the directory can be read");
    let entry = |entry: std::io::Result<fs::DirEntry>| {
        let path = entry.expect("the directory can be read").path();
        let name = path.file_name().expect("a file has a name");
        let bytes = fs::read(&path).expect("a file can be read");
        (name.to_string_lossy().into_owned(), bytes)
    };
    entries.map(entry).collect()
}

/// A kit without the hashes of its inputs.
fn without_inputs(kit: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(kit);
    let manifest = files.remove("manifest.json").expect("a kit has a manifest");
    let mut manifest: serde_json::Value =
        serde_json::from_slice(&manifest).expect("the manifest is JSON");
    manifest["inputs"] = serde_json::Value::Null;
    files.insert("manifest.json".to_string(), manifest.to_string().into());
    files
}

fn kit_of(job: &str, table: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let directory = machine(job, table);
    expect_status(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    without_inputs(&directory.path().join("kit"))
}

#[test]
fn a_kit_within_its_acceptance_is_a_yes() {
    let directory = machine(JOB, TABLE.as_bytes());
    let output = nonius(directory.path(), "generate job.toml -o kit");
    expect_status(&output, 0);
    assert!(directory.path().join("kit/manifest.json").is_file());
}

#[test]
fn a_forecast_that_misses_the_acceptance_is_a_no_with_files() {
    let job = JOB
        .replace("siemens-840d-sl", "fanuc-30i")
        .replace("spacing_mm", "detection_unit_um = 1.0\nspacing_mm")
        .replace("max_deviation_um = 5.0", "max_deviation_um = 0.1");
    let directory = machine(&job, TABLE.as_bytes());
    expect_status(&nonius(directory.path(), "generate job.toml -o kit"), 1);
    assert!(directory.path().join("kit/manifest.json").is_file());
    assert!(directory.path().join("kit/PITCH.TXT").is_file());
    let verify = nonius(directory.path(), "verify job.toml --tables kit");
    expect_status(&verify, 1);
}

#[test]
fn an_empty_directory_is_taken() {
    let directory = machine(JOB, TABLE.as_bytes());
    fs::create_dir(directory.path().join("kit")).expect("a directory can be made");
    expect_status(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    assert!(!directory.path().join("kit.previous").exists());
}

#[test]
fn force_keeps_every_old_kit() {
    let directory = machine(JOB, TABLE.as_bytes());
    let at = |name: &str| directory.path().join(name);
    let force = || nonius(directory.path(), "generate job.toml -o kit --force");
    let kept = |output: &Output| {
        let told = String::from_utf8_lossy(&output.stderr);
        told.contains("moved kit to kit.previous\n")
    };
    let output = force();
    expect_status(&output, 0);
    assert!(!kept(&output), "there was none");
    let first = files(&at("kit"));

    put(directory.path(), "errors.csv", b"axis,position_mm,ex_um\nx,0,0\nx,50.8,1\nx,101.6,3\n");
    let output = force();
    expect_status(&output, 0);
    assert!(kept(&output));
    assert_eq!(files(&at("kit.previous")), first, "the old kit is kept");
    let second = files(&at("kit"));
    assert_ne!(second, first);

    expect_status(&force(), 0);
    assert_eq!(files(&at("kit.previous")), first, "the older kit, too");
    assert_eq!(files(&at("kit.previous-2")), second);
    assert_eq!(
        names(directory.path()),
        ["errors.csv", "job.toml", "kit", "kit.previous", "kit.previous-2"]
    );
}

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).expect("the directory can be read");
    let name = |entry: std::io::Result<fs::DirEntry>| {
        let entry = entry.expect("the directory can be read");
        entry.file_name().to_string_lossy().into_owned()
    };
    let mut names: Vec<String> = entries.map(name).collect();
    names.sort();
    names
}

#[test]
fn a_place_that_cannot_be_written_leaves_nothing() {
    let directory = machine(JOB, TABLE.as_bytes());
    put(directory.path(), "blocked", b"a file in the way\n");
    let output = nonius(directory.path(), "generate job.toml -o blocked/kit");
    expect_status(&output, 2);
    assert_eq!(names(directory.path()), ["blocked", "errors.csv", "job.toml"]);
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("problem: "));
}

#[test]
fn json_on_standard_output_is_the_manifest() {
    let directory = machine(JOB, TABLE.as_bytes());
    let output = nonius(directory.path(), "generate job.toml -o kit --format json");
    expect_status(&output, 0);
    let manifest = fs::read(directory.path().join("kit/manifest.json")).expect("it is there");
    assert_eq!(String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&manifest));
}

#[test]
fn the_same_input_gives_the_same_bytes_from_anywhere() {
    let directory = machine(JOB, TABLE.as_bytes());
    let other = tempfile::tempdir().expect("a temporary directory can be made");
    expect_status(&nonius(directory.path(), "generate job.toml -o one"), 0);
    expect_status(&nonius(directory.path(), "generate job.toml -o two"), 0);
    let output = program(other.path(), "generate")
        .arg(directory.path().join("job.toml"))
        .args(["-o", "three"])
        .output()
        .expect("the program starts");
    expect_status(&output, 0);
    let one = files(&directory.path().join("one"));
    assert_eq!(files(&directory.path().join("two")), one);
    assert_eq!(files(&other.path().join("three")), one);
}

#[test]
fn a_job_on_standard_input() {
    let directory = machine(JOB, TABLE.as_bytes());
    fs::remove_file(directory.path().join("job.toml")).expect("a file can be removed");
    let mut child = program(directory.path(), "generate - -o kit")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut input = child.stdin.take().expect("it was asked for");
    input.write_all(JOB.as_bytes()).expect("the program reads");
    drop(input);
    assert!(child.wait().expect("the program ends").success());
    let kit = without_inputs(&directory.path().join("kit"));
    assert_eq!(kit, kit_of(JOB, TABLE.as_bytes()));
}

#[test]
fn a_table_as_a_spreadsheet_of_another_country_writes_it() {
    let semicolons = TABLE.replace(',', ";").replace('.', ",").replace('\n', "\r\n");
    let with_mark = format!("\u{feff}{semicolons}");
    assert_eq!(kit_of(JOB, with_mark.as_bytes()), kit_of(JOB, TABLE.as_bytes()));
}

#[test]
fn a_job_with_windows_line_ends() {
    let job = JOB.replace('\n', "\r\n");
    assert_eq!(kit_of(&job, TABLE.as_bytes()), kit_of(JOB, TABLE.as_bytes()));
}

#[test]
fn inches_are_converted_at_the_edge() {
    let inches = "axis,position_in,ex_uin\nx,0,0\nx,2,100\nx,4,-50\n";
    let (inch, metric) = (kit_of(JOB, inches.as_bytes()), kit_of(JOB, TABLE.as_bytes()));
    assert_eq!(inch["NONIUS_EEC.MPF"], metric["NONIUS_EEC.MPF"]);
}

#[test]
fn a_kit_of_one_axis_verifies() {
    for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
        let job = JOB
            .replace("siemens-840d-sl", controller)
            .replace("spacing_mm", "detection_unit_um = 0.1\nspacing_mm");
        let directory = machine(&job, TABLE.as_bytes());
        expect_status(&nonius(directory.path(), "generate job.toml -o kit"), 0);
        let verify = nonius(directory.path(), "verify job.toml --tables kit");
        expect_status(&verify, 0);
    }
}
