//! Nothing that a person made is lost: no output replaces an input, `--force` removes only what
//! this program made and nobody touched, and no input is cut or exchanged without a word.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Far more than any of these runs takes; a run that waits for ever is ended then.
const PATIENCE: Duration = Duration::from_secs(60);

/// A fresh directory with the files of a fixture.
fn copy_of(fixture: &str) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(fixture);
    for entry in fs::read_dir(from).expect("the fixture is there") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            let name = path.file_name().expect("a file has a name");
            fs::copy(&path, directory.path().join(name)).expect("a file can be copied");
        }
    }
    directory
}

fn run(directory: &Path, command: &str, stdin: Stdio) -> (Option<i32>, String) {
    let told = tempfile::tempfile().expect("a file for what is told");
    let mut child = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(directory)
        .stdin(stdin)
        .stdout(Stdio::null())
        .stderr(told.try_clone().expect("a second handle"))
        .spawn()
        .expect("the program starts");
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => break status,
            None if begun.elapsed() > PATIENCE => {
                let _ = child.kill();
                let _ = child.wait();
                return (None, format!("`{command}` waits for ever"));
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    (status.code(), content(told))
}

fn content(mut file: File) -> String {
    use std::io::{Read, Seek};
    let mut text = String::new();
    file.rewind().expect("a file can be gone back in");
    file.read_to_string(&mut text).expect("what is told is text");
    text
}

fn nonius(directory: &Path, command: &str) -> (Option<i32>, String) {
    run(directory, command, Stdio::null())
}

fn expect(directory: &Path, command: &str, status: i32, says: &str) {
    let (found, told) = nonius(directory, command);
    assert_eq!(found, Some(status), "{command}\n{told}");
    assert!(told.contains(says), "expected `{says}` of {command}\n{told}");
}

/// Every file below a directory, links not followed.
fn all_files(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).expect("a directory") {
        let entry = entry.expect("an entry");
        let kind = entry.file_type().expect("a kind");
        if kind.is_dir() {
            found.extend(all_files(&entry.path()));
        } else if kind.is_file() {
            found.push((entry.path(), fs::read(entry.path()).expect("a file")));
        }
    }
    found.sort();
    found
}

/// The command is refused, says so, and changes nothing.
fn refused(directory: &Path, command: &str, says: &str) {
    let before = all_files(directory);
    expect(directory, command, 2, says);
    assert!(all_files(directory) == before, "{command} changed something");
}

fn put(path: PathBuf, text: impl AsRef<[u8]>) {
    fs::write(path, text).expect("a file can be written");
}

/// How many files below the directory have these bytes.
fn copies(directory: &Path, bytes: &[u8]) -> usize {
    let files = all_files(directory);
    files.iter().filter(|(_, found)| found == bytes).count()
}

const WOULD_REPLACE: &str = "which this run reads";

#[test]
fn no_output_replaces_an_input() {
    let place = copy_of("diagonals/case_b_setup");
    let at = place.path();
    for command in [
        "simulate job.toml -o readings.csv --force",
        "simulate job.toml -o ./../{}/job.toml --force",
        "separate job.toml -o readings.csv --force",
        "separate job.toml -o job.toml --force",
    ] {
        let name = at.file_name().expect("a name").to_string_lossy();
        refused(at, &command.replace("{}", &name), WOULD_REPLACE);
    }
    put(at.join("part.nc"), "G21 G90 G1 X10 F100\nX20\nM30\n");
    refused(at, "path job.toml part.nc -o part.nc --force", WOULD_REPLACE);
}

#[cfg(unix)]
#[test]
fn no_output_replaces_an_input_through_links_or_standard_input() {
    let place = copy_of("diagonals/case_b_setup");
    let at = place.path();
    fs::hard_link(at.join("readings.csv"), at.join("hard.csv")).expect("a link");
    std::os::unix::fs::symlink("readings.csv", at.join("soft.csv")).expect("a link");
    std::os::unix::fs::symlink(".", at.join("here")).expect("a link");
    for (output, says) in [
        ("hard.csv", WOULD_REPLACE),
        ("here/readings.csv", WOULD_REPLACE),
        ("soft.csv", "is a link"),
    ] {
        let command = format!("simulate job.toml -o {output} --force");
        refused(at, &command, says);
    }
    let before = all_files(at);
    let stdin = File::open(at.join("job.toml")).expect("the job");
    let (status, told) = run(at, "simulate - -o job.toml --force", stdin.into());
    assert_eq!(status, Some(2), "{told}");
    assert!(told.contains(WOULD_REPLACE), "{told}");
    assert!(all_files(at) == before);
}

#[test]
fn no_output_lies_in_a_kit_that_is_read() {
    let place = copy_of("start/errors");
    let at = place.path();
    expect(at, "generate job.toml -o kit", 0, "wrote");
    for command in [
        "simulate job.toml --tables kit --errors -o kit/after.csv",
        "simulate job.toml --tables kit --errors -o kit/manifest.json --force",
    ] {
        refused(at, command, WOULD_REPLACE);
    }
    expect(at, "simulate job.toml --tables kit --errors -o after.csv", 0, "wrote");
}

#[cfg(unix)]
#[test]
fn an_output_is_a_regular_file_or_new() {
    use std::os::unix::fs::FileTypeExt;
    let place = copy_of("start/errors");
    let at = place.path();
    fifo(&at.join("pipe"));
    fs::create_dir(at.join("folder")).expect("a directory");
    // A device of the test's own; only root can make one.
    let device = at.join("device");
    let made =
        Command::new("mknod").arg(&device).args(["c", "1", "3"]).stderr(Stdio::null()).status();
    let has_device = made.is_ok_and(|status| status.success());
    for (output, says) in [
        ("pipe", "is no regular file"),
        ("folder", "is a directory"),
        ("device", "is no regular file"),
    ] {
        if output != "device" || has_device {
            let command = format!("simulate job.toml --errors -o {output} --force");
            refused(at, &command, says);
        }
    }
    let kind = |path: &Path| fs::symlink_metadata(path).expect("it is there").file_type();
    assert!(kind(&at.join("pipe")).is_fifo());
    assert!(!has_device || kind(&device).is_char_device());
}

#[cfg(unix)]
#[test]
fn a_kit_does_not_take_the_place_of_a_link_that_leads_nowhere() {
    let place = copy_of("start/errors");
    let at = place.path();
    std::os::unix::fs::symlink("not-there", at.join("kit")).expect("a link");
    refused(at, "generate job.toml -o kit", "is a link or a file");
    assert!(at.join("kit").is_symlink());
}

#[cfg(unix)]
fn fifo(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
}

#[test]
fn force_twice_keeps_job_and_measurement_that_were_moved_into_the_kit() {
    let place = copy_of("start/errors");
    let at = place.path();
    let job = fs::read(at.join("job.toml")).expect("the job");
    let table = fs::read(at.join("errors.csv")).expect("the table");
    expect(at, "generate job.toml -o kit", 0, "wrote");
    for name in ["job.toml", "errors.csv"] {
        fs::rename(at.join(name), at.join("kit").join(name)).expect("a file can be moved");
    }
    refused(at, "generate kit/job.toml -o kit --force", WOULD_REPLACE);
    let _ = nonius(at, "generate kit.previous/job.toml -o kit --force");
    assert_eq!(copies(at, &job), 1);
    assert_eq!(copies(at, &table), 1);
}

#[test]
fn force_never_removes_what_was_put_into_a_kit() {
    let place = copy_of("start/errors");
    let at = place.path();
    expect(at, "generate job.toml -o kit", 0, "wrote");
    put(at.join("kit/archive.arc"), "what was read out");
    let force = "generate job.toml -o kit --force";
    expect(at, force, 0, "moved kit to kit.previous\n");
    expect(at, force, 0, "moved kit to kit.previous-2\n");
    expect(at, force, 0, "moved kit to kit.previous-3\n");
    assert_eq!(copies(at, b"what was read out"), 1);
    assert!(at.join("kit.previous/archive.arc").is_file());
    assert!(at.join("kit.previous-2/manifest.json").is_file());
}

#[test]
fn force_removes_nothing_that_lies_where_older_kits_are_kept() {
    let place = copy_of("start/errors");
    let at = place.path();
    let force = "generate job.toml -o kit --force";
    expect(at, force, 0, "wrote");
    fs::create_dir(at.join("kit.previous")).expect("a directory");
    put(at.join("kit.previous/photo.jpg"), "of the machine");
    put(at.join("kit.previous/manifest.json"), r#"{"files":[]}"#);
    expect(at, force, 0, "moved kit to kit.previous-2\n");
    expect(at, force, 0, "moved kit to kit.previous-3\n");
    assert_eq!(copies(at, b"of the machine"), 1);
}

/// What is replaced gives its permissions.
#[cfg(unix)]
#[test]
fn what_is_replaced_keeps_its_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let place = copy_of("start/errors");
    let at = place.path();
    let simulate = "simulate job.toml --errors -o after.csv --force";
    expect(at, simulate, 0, "wrote");
    expect(at, "generate job.toml -o kit", 0, "wrote");
    for (name, mode) in [("after.csv", 0o600), ("kit", 0o2750)] {
        let permissions = fs::Permissions::from_mode(mode);
        fs::set_permissions(at.join(name), permissions).expect("a mode");
    }
    expect(at, simulate, 0, "wrote");
    expect(at, "generate job.toml -o kit --force", 0, "wrote");
    for (name, mode) in [("after.csv", 0o600), ("kit", 0o2750)] {
        let found = fs::metadata(at.join(name)).expect("it is there");
        assert_eq!(found.permissions().mode() & 0o7777, mode, "{name}");
    }
}

#[test]
fn force_never_removes_readings_filled_into_the_folder_of_a_measuring_run() {
    let place = copy_of("start/errors");
    let at = place.path();
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    put(at.join("run.toml"), with_program(&job));
    let force = "program run.toml -o run --force";
    expect(at, force, 0, "wrote");
    let files = all_files(&at.join("run"));
    let mut paths = files.iter().map(|(path, _)| path.clone());
    let readings = paths
        .rfind(|path| path.extension().is_some_and(|e| e == "csv"))
        .expect("a table of readings");
    put(readings, "filled in at the machine");
    expect(at, force, 0, "moved run to run.previous\n");
    expect(at, force, 0, "moved run to run.previous-2\n");
    assert_eq!(copies(at, b"filled in at the machine"), 1);
}

/// The job with a run along its axes.
fn with_program(job: &str) -> String {
    let program = r#"
[program]
what = "single-axis"
bidirectional = false
start_mm = { x = 10.0, y = 10.0, z = -190.0 }
size_mm = { x = 300.0, y = 200.0, z = 100.0 }
steps = 5
"#;
    format!("{job}{program}")
}

/// A valid job, as long as comments make it.
fn long_job(at: &Path, bytes: usize) -> String {
    const LINE: usize = 80;
    let mut job = fs::read_to_string(at.join("job.toml")).expect("the job");
    while job.len() < bytes {
        let rest = (bytes - job.len()).min(LINE);
        job.extend(std::iter::repeat_n('#', rest - 1));
        job.push('\n');
    }
    job
}

#[test]
fn standard_input_beyond_the_limit_is_refused_like_a_file() {
    const LARGEST_INPUT: usize = 64 << 20;
    const LARGEST_JOB: usize = 256 << 10;
    let place = copy_of("start/errors");
    let at = place.path();
    for (bytes, refusal) in [
        (LARGEST_JOB, None),
        (LARGEST_JOB + 1, Some("more than 256 KiB")),
        (LARGEST_INPUT + 1, Some("more than 64 MiB")),
    ] {
        put(at.join("long.toml"), long_job(at, bytes));
        let stdin = File::open(at.join("long.toml")).expect("the job");
        let piped = run(at, "context -", stdin.into());
        let named = nonius(at, "context long.toml");
        for (found, told) in [piped, named] {
            assert_eq!(found, Some(if refusal.is_some() { 2 } else { 0 }), "{told}");
            assert!(told.contains(refusal.unwrap_or_default()), "{told}");
        }
    }
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_without_a_writer_are_refused_at_once() {
    let place = copy_of("start/errors");
    let at = place.path();
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    fifo(&at.join("pipe"));
    for (input, says) in
        [("/dev/zero", "is no regular file"), ("pipe", "nothing was written into it")]
    {
        put(at.join("other.toml"), job.replace("errors.csv", input));
        refused(at, "generate other.toml -o kit", says);
        refused(at, &format!("generate {input} -o kit"), says);
        refused(at, &format!("import {input} -o x.csv"), says);
    }
    refused(at, "path job.toml /dev/zero", "is no regular file");
}

/// A shell's `<(…)` is such a pipe.
#[cfg(unix)]
#[test]
fn a_pipe_with_a_writer_is_read() {
    let place = copy_of("start/errors");
    let at = place.path();
    fifo(&at.join("pipe"));
    let (from, to) = (at.join("job.toml"), at.join("pipe"));
    // Opened for both, so that it does not wait for the reader; the bytes fit into the pipe.
    let mut both = File::options().read(true).write(true).open(to).expect("a pipe");
    let job = fs::read(from).expect("the job");
    std::io::Write::write_all(&mut both, &job).expect("the pipe takes it");
    let writer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(3));
        drop(both);
    });
    expect(at, "generate pipe -o kit", 0, "wrote");
    writer.join().expect("the writer ends");
}

#[test]
fn history_follows_no_path_out_of_a_kit() {
    let place = copy_of("start/errors");
    let at = place.path();
    expect(at, "generate job.toml -o kit", 0, "wrote");
    let manifest = at.join("kit/manifest.json");
    let listed = fs::read_to_string(&manifest).expect("a manifest");
    let mut document: serde_json::Value = serde_json::from_str(&listed).expect("JSON");
    for path in ["../errors.csv", "/dev/zero", "sub/x.csv", "..\\errors.csv", ".."] {
        document["files"][0]["path"] = path.into();
        put(manifest.clone(), document.to_string());
        let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
            .args(["history", "kit"])
            .current_dir(at)
            .output()
            .expect("the program starts");
        let told = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{told}");
        let words = format!("`{path}` is no plain file name");
        assert!(told.contains(&words), "expected `{words}` in\n{told}");
    }
}

#[test]
fn a_template_that_cannot_be_read_is_not_replaced_by_the_built_in_one() {
    let place = copy_of("start/errors");
    let at = place.path();
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    let own = job.replace("siemens-840d-sl", "shop.toml");
    put(at.join("own.toml"), own);
    put(at.join("shop.toml"), SHOP);
    expect(at, "generate own.toml -o kit", 0, "wrote");
    let template = at.join("generic.csv.tera");
    put(template.clone(), b"{# Fr\xe4se #}{{ nothing }}");
    refused(at, "generate own.toml -o other", "generic.csv.tera");
    refused(at, "controllers check shop.toml", "generic.csv.tera");
    fs::remove_file(&template).expect("it is there");
    fs::create_dir(&template).expect("a directory");
    refused(at, "generate own.toml -o other", "generic.csv.tera");
}

const SHOP: &str = r#"
schema = 1
id = "shop"
name = "Control of the shop"
based_on = "generic"

[[files]]
role = "table"
path = "TABLE.CSV"
template = "generic.csv.tera"
"#;
