//! `verify` on a stick as it comes back: files of operating systems, files that the kit does not
//! list, a kit of another control, a job that was changed since.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn nonius(directory: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let told = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    (output.status.code(), told)
}

/// A fresh kit of the job to start from, beside its inputs.
fn kit() -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/errors");
    for name in ["job.toml", "errors.csv"] {
        fs::copy(start.join(name), directory.path().join(name)).expect("the fixture is there");
    }
    let (status, told) = nonius(directory.path(), &["generate", "job.toml", "-o", "kit"]);
    assert_eq!(status, Some(0), "{told}");
    let kit = directory.path().join("kit");
    (directory, kit)
}

fn expect(directory: &Path, status: i32, says: &str) {
    let (found, told) = nonius(directory, &["verify", "job.toml", "--tables", "kit"]);
    assert_eq!(found, Some(status), "{told}");
    assert!(told.contains(says), "expected `{says}` in\n{told}");
}

fn write(path: PathBuf, bytes: &[u8]) {
    fs::write(path, bytes).expect("the file can be written");
}

#[test]
fn what_operating_systems_leave_is_passed_over_with_or_without_manifest() {
    let (directory, kit) = kit();
    write(kit.join(".DS_Store"), b"\0\0\0\x01Bud1\xff");
    write(kit.join("Thumbs.db"), b"\xd0\xcf\x11\xe0");
    write(kit.join("desktop.ini"), b"[.ShellClassInfo]\r\n");
    fs::create_dir(kit.join("System Volume Information")).expect("a directory can be made");
    let words = "`.DS_Store` was ignored: an operating system left it";
    expect(directory.path(), 0, words);
    fs::remove_file(kit.join("manifest.json")).expect("it is there");
    expect(directory.path(), 0, words);
}

#[test]
fn an_unlisted_file_is_passed_over_unless_the_control_would_read_it() {
    let (directory, kit) = kit();
    write(kit.join("offer.pdf"), b"%PDF-1.7\n\xff\xfe");
    write(kit.join("notes.txt"), b"called the customer on Monday\n");
    expect(directory.path(), 0, "`notes.txt` was ignored: manifest.json does not list it");
    write(kit.join("OLD.MPF"), b"$AN_CEC[7,0]=0.01\n$AN_CEC[7,1]=0.02\n$AN_CEC_INPUT_AXIS[7]=(AX1)\n$AN_CEC_OUTPUT_AXIS[7]=(AX2)\n$AN_CEC_STEP[7]=100\n$AN_CEC_MIN[7]=0\n$AN_CEC_MAX[7]=100\nM30\n");
    expect(
        directory.path(),
        1,
        "`OLD.MPF` is not listed in manifest.json, and the control could read it",
    );
    write(kit.join("OLD.MPF"), b"$AN_CEC[7,0]=0.01\nM30\n");
    expect(directory.path(), 2, "OLD.MPF");
}

#[test]
fn a_kit_of_another_control_is_named_as_such() {
    let (directory, _kit) = kit();
    let path = directory.path().join("job.toml");
    let job = fs::read_to_string(&path).expect("it is there");
    let fanuc = job.replace("# detection_unit_um", "detection_unit_um");
    let words = "the kit was made for another control: manifest.json names `siemens-840d-sl`";
    write(path.clone(), fanuc.replace("siemens-840d-sl", "fanuc-30i").as_bytes());
    expect(directory.path(), 2, words);
    write(path, job.replace("siemens-840d-sl", "siemens-828d").as_bytes());
    expect(directory.path(), 1, words);
}

#[test]
fn other_inputs_are_named_beside_the_verdict() {
    let (directory, _kit) = kit();
    let path = directory.path().join("job.toml");
    let job = fs::read_to_string(&path).expect("it is there");
    write(path, format!("{job}# a comment\n").as_bytes());
    let words = "the kit was made from other inputs: `job.toml` differ";
    expect(directory.path(), 0, words);
}
