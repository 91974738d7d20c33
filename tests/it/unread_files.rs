//! What a control loads is protected whatever its role: files that no reader takes (role `report`)
//! get no *pass*, and changed, deleted or unlisted they fail.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A control that loads `loaded.csv`, in a layout that no reader takes; `{keys}` = more of its keys.
const PROFILE: &str = r#"schema = 1
id = "shop-csv"
name = "Shop control"
based_on = "generic"

[[files]]
role = "table"
path = "shop.csv"
template = "generic.csv.tera"

[[files]]
role = "report"
path = "loaded.csv"
template = "loaded.csv.tera"
{keys}

[[files]]
role = "checklist"
path = "checklist.md"
template = "checklist.md.tera"
"#;

const TEMPLATE: &str = "place;value\n{% for row in rows -%}\n{{ row.position_mm }};{{ row.correction_um }}\n{% endfor -%}\n";

/// The sentence of a verdict that rests on a file without reader.
const UNREAD: &str = "`loaded.csv` is not read back (role `report`)";

/// Status, and what was printed.
fn nonius(directory: &Path, arguments: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let told = text(&output.stdout) + &text(&output.stderr);
    (output.status.code().expect("it ends by itself"), told)
}

/// A fresh kit of the shop's control, and what `generate` said.
fn kit(keys: &str) -> (TempDir, PathBuf, (i32, String)) {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let errors = fs::read(fixture.join("errors.csv")).expect("the fixture is there");
    let job = fs::read_to_string(fixture.join("generic.toml")).expect("the fixture is there");
    let job = job.replace("controller = \"generic\"", "controller = \"shop.toml\"");
    let profile = PROFILE.replace("{keys}", keys);
    let write = |name: &str, bytes: &[u8]| {
        fs::write(directory.path().join(name), bytes).expect("an input can be written");
    };
    write("errors.csv", &errors);
    write("job.toml", job.as_bytes());
    write("shop.toml", profile.as_bytes());
    write("loaded.csv.tera", TEMPLATE.as_bytes());
    let said = nonius(directory.path(), &["generate", "job.toml", "-o", "kit"]);
    let kit = directory.path().join("kit");
    (directory, kit, said)
}

fn verify(directory: &TempDir) -> (i32, String) {
    nonius(directory.path(), &["verify", "job.toml", "--tables", "kit"])
}

#[test]
fn a_file_that_no_reader_takes_gets_no_pass() {
    let (directory, kit, (status, told)) = kit("");
    assert_eq!(status, 1, "{told}");
    assert!(told.contains("verdict: undecided") && told.contains(UNREAD), "{told}");
    let manifest = fs::read_to_string(kit.join("manifest.json")).expect("it was written");
    assert!(manifest.contains(UNREAD), "the manifest says so too");
    let checklist = fs::read_to_string(kit.join("checklist.md")).expect("it was written");
    assert!(checklist.contains(UNREAD), "the checklist says so too");
    let (status, told) = verify(&directory);
    assert_eq!(status, 1, "{told}");
    assert!(told.contains("job and tables agree"), "{told}");
    assert!(told.contains("verdict: undecided") && told.contains(UNREAD), "{told}");
}

#[test]
fn without_its_manifest_such_a_kit_gets_no_pass_either() {
    let (directory, kit, _) = kit("");
    fs::remove_file(kit.join("manifest.json")).expect("it was written");
    let (status, told) = verify(&directory);
    assert_eq!(status, 1, "{told}");
    assert!(told.contains("verdict: undecided") && told.contains(UNREAD), "{told}");
}

#[test]
fn a_sheet_that_no_control_loads_is_stated_as_such() {
    let (directory, _, (status, told)) = kit("loaded = false");
    assert_eq!(status, 0, "{told}");
    let (status, told) = verify(&directory);
    assert_eq!(status, 0, "{told}");
    assert!(told.contains("verdict: pass") && !told.contains(UNREAD), "{told}");
}

/// Every change of a kit that no reader would find, and what `verify` says of it.
#[test]
fn a_file_that_no_reader_takes_fails_turned_deleted_or_unlisted() {
    for keys in ["", "loaded = false"] {
        let (directory, kit, _) = kit(keys);
        let path = kit.join("loaded.csv");
        let good = fs::read_to_string(&path).expect("it was written");
        let expect = |what: &str, says: &str| {
            let (status, told) = verify(&directory);
            assert_eq!(status, 1, "{what}\n{told}");
            assert!(told.contains("verdict: fail") && told.contains(says), "{what}\n{told}");
            assert!(!told.contains("what differs is something else"), "{what}\n{told}");
        };
        fs::write(&path, good.replace(";-", ";")).expect("it can be written");
        expect("its signs turned", "`loaded.csv` was changed after it was made");
        fs::remove_file(&path).expect("it can be removed");
        expect("deleted", "`loaded.csv` is listed in manifest.json but missing");
        fs::write(&path, good).expect("it can be written");
        let manifest = kit.join("manifest.json");
        let text = fs::read_to_string(&manifest).expect("it was written");
        let unlisted = text.replace("\"loaded.csv\"", "\"shop.csv\"");
        assert_ne!(text, unlisted, "the manifest was changed");
        fs::write(&manifest, unlisted).expect("it can be written");
        expect("not listed", "`loaded.csv` is not listed in manifest.json");
    }
}

#[test]
fn notes_in_the_checklist_stay_a_note() {
    let (directory, kit, _) = kit("loaded = false");
    let path = kit.join("checklist.md");
    let page = fs::read_to_string(&path).expect("it was written");
    fs::write(&path, page + "done, A.B.\n").expect("it can be written");
    let (status, told) = verify(&directory);
    assert_eq!(status, 0, "{told}");
    assert!(told.contains("`checklist.md` was changed after it was made"), "{told}");
}

#[test]
fn a_kit_with_a_changed_file_is_no_predecessor_whatever_its_role() {
    let (directory, kit, _) = kit("");
    fs::write(kit.join("loaded.csv"), "place;value\n").expect("it can be written");
    let (status, told) = nonius(directory.path(), &["history", "kit"]);
    assert_eq!(status, 1, "{told}");
    assert!(told.contains("`loaded.csv` was changed after it was made"), "{told}");
    let job = directory.path().join("job.toml");
    let text = fs::read_to_string(&job).expect("it was written");
    let after =
        text.replace("active_while_measuring = \"none\"", "active_while_measuring = \"kit\"");
    fs::write(&job, after).expect("it can be written");
    let (status, told) = nonius(directory.path(), &["generate", "job.toml", "-o", "new"]);
    assert_eq!(status, 2, "{told}");
    assert!(told.contains("`loaded.csv` of the kit `kit` was changed after it was made"), "{told}");
}
