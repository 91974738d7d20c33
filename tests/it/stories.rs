//! What a user may rely on around a kit: exit status, files, `--force`, formats of the input.
//! Tampered kits are in `tampered.rs`, refusals in `refuses.rs`.

use crate::support::{Entry, Ran, Tree, Visit, below, replaced};
use serde_json::Value;
use std::fs;

const JOB: &str = "schema = 1\n[machine]\nname = \"VMC 100\"\n\
    axes.x = { travel_mm = [0.0, 101.6], reference_mm = 0.0 }\n\
    [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n\
    [compensation]\ncontroller = \"siemens-840d-sl\"\n[compensation.axes.x]\nspacing_mm = 50.8\n\
    [acceptance]\nmax_deviation_um = 5.0\n";
const TABLE: &str = "axis,position_mm,ex_um\nx,0,0\nx,50.8,2.54\nx,101.6,-1.27\n";

const GENERATE: &str = "generate job.toml -o kit";
const VERIFY: &str = "verify job.toml --tables kit";

/// The files of a kit without the hashes of its inputs.
fn kit_in(visit: &Visit) -> Tree {
    let mut kit = below(&visit.files(), "kit").unwrap();
    let mut manifest = visit.document("kit/manifest.json");
    manifest["inputs"] = Value::Null;
    kit.insert("manifest.json".to_string(), Entry::File(manifest.to_string().into()));
    kit
}

fn kit_of(job: &str, table: &str) -> Tree {
    let visit = Visit::with(job, table).with_kit();
    kit_in(&visit)
}

#[test]
fn a_kit_within_its_acceptance_is_a_yes_and_its_manifest_the_json() {
    let visit = Visit::with(JOB, TABLE).with_kit();
    assert!(visit.at("kit/manifest.json").is_file());
    let printed = visit.yes("generate job.toml -o other --format json");
    assert_eq!(printed, visit.read("other/manifest.json"));
}

#[test]
fn a_forecast_that_misses_the_acceptance_is_a_no_with_files() {
    let visit = Visit::with(JOB, TABLE);
    visit
        .edit("job.toml", "siemens-840d-sl", "fanuc-30i")
        .edit("job.toml", "spacing_mm", "detection_unit_um = 1.0\nspacing_mm")
        .edit("job.toml", "max_deviation_um = 5.0", "max_deviation_um = 0.1");
    visit.run(GENERATE).ends(1);
    assert!(visit.at("kit/manifest.json").is_file());
    assert!(visit.at("kit/PITCH.TXT").is_file());
    visit.run(VERIFY).ends(1);
}

#[test]
fn an_empty_directory_is_taken() {
    let visit = Visit::with(JOB, TABLE);
    fs::create_dir(visit.at("kit")).unwrap();
    visit.yes(GENERATE);
    assert!(!visit.has("kit.previous"));
}

#[test]
fn force_keeps_every_old_kit() {
    let visit = Visit::with(JOB, TABLE);
    let force = || visit.run("generate job.toml -o kit --force").ends(0);
    let files = |kit: &str| below(&visit.files(), kit).unwrap();
    let moved = "moved kit to kit.previous\n";
    assert!(!force().err.contains(moved), "there was none");
    let first = files("kit");
    visit.put("errors.csv", "axis,position_mm,ex_um\nx,0,0\nx,50.8,1\nx,101.6,3\n");
    let Ran { err, .. } = force();
    assert!(err.contains(moved), "{err}");
    assert_eq!(files("kit.previous"), first, "the old kit is kept");
    let second = files("kit");
    assert_ne!(second, first);
    force();
    assert_eq!(files("kit.previous"), first, "the older kit, too");
    assert_eq!(files("kit.previous-2"), second);
    assert_eq!(visit.names(), ["errors.csv", "job.toml", "kit", "kit.previous", "kit.previous-2"]);
}

#[test]
fn a_place_that_cannot_be_written_leaves_nothing() {
    let visit = Visit::with(JOB, TABLE);
    visit.put("blocked", "a file in the way\n");
    let ran = visit.run("generate job.toml -o blocked/kit").ends(2);
    assert_eq!(visit.names(), ["blocked", "errors.csv", "job.toml"]);
    assert!(ran.err.starts_with("problem: "), "{}", ran.err);
}

#[test]
fn a_job_on_standard_input() {
    let visit = Visit::with(JOB, TABLE);
    fs::remove_file(visit.at("job.toml")).unwrap();
    assert!(visit.with_input("generate - -o kit", JOB.as_bytes()).status.success());
    assert_eq!(kit_in(&visit), kit_of(JOB, TABLE));
}

#[test]
fn a_table_as_a_spreadsheet_of_another_country_and_a_job_of_windows() {
    let kit = kit_of(JOB, TABLE);
    let semicolons = TABLE.replace(',', ";").replace('.', ",").replace('\n', "\r\n");
    assert_eq!(kit_of(JOB, &format!("\u{feff}{semicolons}")), kit, "decimal commas");
    assert_eq!(kit_of(&JOB.replace('\n', "\r\n"), TABLE), kit, "line ends of Windows");
}

#[test]
fn inches_are_converted_at_the_edge() {
    let inches = "axis,position_in,ex_uin\nx,0,0\nx,2,100\nx,4,-50\n";
    let (inch, metric) = (kit_of(JOB, inches), kit_of(JOB, TABLE));
    assert_eq!(inch["NONIUS_EEC.MPF"], metric["NONIUS_EEC.MPF"]);
}

#[test]
fn a_kit_of_one_axis_verifies() {
    let job = replaced(JOB, "spacing_mm", "detection_unit_um = 0.1\nspacing_mm");
    for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
        let visit = Visit::with(replaced(&job, "siemens-840d-sl", controller), TABLE).with_kit();
        visit.yes(VERIFY);
    }
}
