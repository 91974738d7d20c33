//! What `generate` says beside its figures: assumptions that matter apart from those that cannot,
//! preconditions as sentences, the verdict where a person looks last.

#![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn nonius(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("the program starts")
}

/// The job to start from with a control of one's choice, and what `generate` says of it.
fn told(controller: &str, profile: Option<&str>) -> (TempDir, String, String) {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/errors");
    let job = fs::read_to_string(start.join("job.toml")).expect("the job is there");
    let job = job
        .replace("siemens-840d-sl", controller)
        .replace("# detection_unit_um", "detection_unit_um");
    fs::write(directory.path().join("job.toml"), job).expect("the job can be written");
    fs::copy(start.join("errors.csv"), directory.path().join("errors.csv"))
        .expect("the table can be copied");
    if let Some(page) = profile {
        fs::write(directory.path().join(controller), page).expect("the profile can be written");
    }
    let output = nonius(directory.path(), &["generate", "job.toml", "-o", "kit", "--explain"]);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("it is text");
    let (data, talk) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{talk}");
    (directory, data, talk)
}

#[test]
fn names_in_other_letters_and_paths_with_blanks_are_taken() {
    let (directory, _, _) = told("siemens-840d-sl", None);
    let job = directory.path().join("job.toml");
    let page = fs::read_to_string(&job).expect("the job is there");
    let named = |line: &str| match line.starts_with("name = ") {
        true => "name = \"Fräse Süd, groß\"".to_string(),
        false => line.to_string(),
    };
    let page: Vec<String> = page.lines().map(named).collect();
    fs::write(&job, page.join("\n")).expect("the job can be written");
    let output = nonius(directory.path(), &["generate", "job.toml", "-o", "my kit"]);
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).expect("it is text");
    assert!(said.contains("`Fräse Süd, groß` stands as `Fraese Sued, gross`"), "{said}");
    assert!(said.contains("nonius verify job.toml --tables \"my kit\""), "{said}");
}

#[test]
fn the_verdict_stands_in_the_first_line() {
    let (_directory, data, _talk) = told("siemens-840d-sl", None);
    assert!(data.starts_with("verdict: pass (asked: "), "{data}");
}

#[test]
fn assumptions_without_effect_stand_apart_with_the_reason() {
    let (_directory, data, _talk) = told("fanuc-30i", None);
    let (used, idle) =
        data.split_once("assumed too, without effect on this kit:").expect("both groups are there");
    assert!(used.contains("pitch_sign = as_correction\n      if wrong: "));
    assert!(used.contains("straightness_magnification_parameter"), "a 30i kit uses it");
    let line = "  straightness_amount_max = 32767: this kit holds no four-point straightness\n";
    assert!(idle.contains(line), "{idle}");
    assert!(idle.contains("interval_decimals_inch = 4: this kit is in mm"), "{idle}");
    let (_directory, data, _talk) = told("fanuc-0i-f", None);
    let (used, idle) =
        data.split_once("assumed too, without effect on this kit:").expect("both groups are there");
    assert!(used.contains("straightness_amount_max"), "a 0i-F kit uses it");
    assert!(idle.contains("straightness_magnification_parameter"), "{idle}");
}

#[test]
fn what_is_to_be_decided_is_on_the_screen_and_has_its_box_in_the_steps() {
    let of_siemens = ["first_table = 0; if wrong: CEC tables already in use"];
    let of_fanuc = [
        "first_set = 1; if wrong: straightness sets already in use",
        "reserved_points = none; if wrong: points already used",
    ];
    let controls = [("siemens-840d-sl", &of_siemens[..]), ("fanuc-30i", &of_fanuc)];
    for (id, open) in controls {
        let (directory, data, talk) = told(id, None);
        let text = |name: &str| {
            let path = directory.path().join("kit").join(name);
            fs::read_to_string(path).expect("the checklist is there")
        };
        let (work, page) = (text("checklist.md"), text("checklist.html"));
        let (work, annex) = work.split_once("## Annex").expect("an annex");
        let (page, _) = page.split_once("class=\"annex\"").expect("an annex");
        let boxed = "<li><span class=\"box\">&#160;</span> <strong>DECIDE,</strong>";
        for line in open {
            let said = format!("DECIDE BEFORE LOADING, assumed: {line}");
            assert!(data.contains(&said) || talk.contains(&said), "{data}{talk}");
            let item = format!("\n   - [ ] **DECIDE,** assumed: {line}");
            assert!(work.contains(&item), "{id}: {item}\n{work}");
            let item = format!("{boxed} assumed: {}", line.split_once(';').expect("two parts").0);
            assert!(page.contains(&item), "{id}: {item}\n{page}");
            assert!(!annex.contains(line), "{id}: {line}\n{annex}");
        }
    }
}

#[test]
fn preconditions_are_sentences_and_axes_share_one() {
    let (_directory, data, talk) = told("fanuc-30i", None);
    assert!(data.contains("\n  1240 of axis 1, 2, 3 must be 0 mm:\n"), "{data}");
    let power = "the power of the control must be switched off and on after loading 3620 to 3627:";
    assert!(data.contains(power), "{data}");
    assert!(talk.contains("checklist.html, why: docs/fanuc.md §4.2"), "{talk}");
}

#[test]
fn what_no_file_of_an_own_profile_sets_is_noted() {
    let page = r#"
schema = 1
id = "own"
name = "own"
based_on = "siemens-840d-sl"

[[files]]
role = "table"
path = "EEC.MPF"
template = "siemens-eec.mpf.tera"

[[files]]
role = "table"
path = "CEC.MPF"
template = "siemens-cec.mpf.tera"
"#;
    let (directory, data, _talk) = told("own.toml", Some(page));
    for note in [
        "note: no file switches the tables on; see to MD32700",
        "note: no file reserves their memory; see to MD38000",
    ] {
        assert!(data.contains(note), "{note}\n{data}");
    }
    let output = nonius(directory.path(), &["verify", "job.toml", "--tables", "kit"]);
    let verified = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(verified.contains("note: no file switches the tables on"), "{verified}");
}

#[test]
fn a_reversal_within_its_uncertainty_is_told_as_noise() {
    let (directory, _, _) = told("siemens-840d-sl", None);
    let job = fs::read_to_string(directory.path().join("job.toml")).expect("the job is there");
    let job = job.replace("[compensation]\n", "[compensation]\nbacklash = \"two-tables\"\n");
    fs::write(directory.path().join("job.toml"), job).expect("the job can be written");
    // EXX: 3 µm between the directions; EYX: 1 µm, with u = 0.5 µm (U of a difference 1.4 µm).
    let table = "axis,direction,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n\
        x,+,0,0,0,0.5,0.5\nx,+,400,3,1,0.5,0.5\nx,-,0,-3,0,0.5,0.5\nx,-,400,0,2,0.5,0.5\n";
    fs::write(directory.path().join("errors.csv"), table).expect("the table can be written");
    let output = nonius(directory.path(), &["generate", "job.toml", "-o", "noisy", "--force"]);
    let said = String::from_utf8(output.stdout).expect("it is text")
        + &String::from_utf8(output.stderr).expect("it is text");
    assert!(
        said.contains("EYX: its reversal, 1.0 µm at most, lies within the U = 1.4 µm"),
        "{said}"
    );
    assert!(!said.contains("EXX: its reversal"), "{said}");
}

/// X was measured in both directions, Y and Z were not: that is neither "not measured" nor nothing.
#[test]
fn the_errors_without_a_reversal_are_named() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/machines/five_points");
    for name in ["siemens-840d-sl.toml", "errors.csv"] {
        fs::copy(job.join(name), directory.path().join(name)).expect("a copy");
    }
    let run = |arguments: &[&str]| {
        let output = nonius(directory.path(), arguments);
        String::from_utf8(output.stdout).expect("it is text")
    };
    let said = run(&["generate", "siemens-840d-sl.toml", "-o", "kit"]);
    let names = "EXY, EYY, EZY, EXZ, EYZ, EZZ";
    let words = format!("reversal of {names} not measured");
    assert!(said.contains(&words), "{said}");
    let german = run(&["report", "siemens-840d-sl.toml", "--language", "de", "-o", "-"]);
    let words = format!("Umkehrspanne von {names} nicht gemessen");
    assert!(german.contains(&words), "{german}");
}
