//! What a user may rely on around a kit: exit status, files, formats of the input.

use crate::support::{Entry, Tree, Visit, below};
use serde_json::Value;
use std::fs;

const JOB: &str = "schema = 1\n[machine]\nname = \"VMC 100\"\n\
    axes.x = { travel_mm = [0.0, 101.6], reference_mm = 0.0 }\n\
    [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n\
    [compensation]\ncontroller = \"siemens-840d-sl\"\n[compensation.axes.x]\nspacing_mm = 50.8\n\
    [acceptance]\nmax_deviation_um = 5.0\n";
const TABLE: &str = "axis,position_mm,ex_um\nx,0,0\nx,50.8,2.54\nx,101.6,-1.27\n";

/// The files of a kit without the hashes of its inputs.
fn kit_in(visit: &Visit) -> Tree {
    let mut kit = below(&visit.files(), "kit").unwrap();
    let mut manifest = visit.document("kit/manifest.json");
    manifest["inputs"] = Value::Null;
    kit.insert("manifest.json".to_string(), Entry::File(manifest.to_string().into()));
    kit
}

fn kit_of(job: &str, table: &str) -> Tree {
    kit_in(&Visit::with(job, table).with_kit())
}

#[test]
fn a_kit_within_its_acceptance_is_a_yes_into_an_empty_directory_and_its_manifest_the_json() {
    let visit = Visit::with(JOB, TABLE);
    fs::create_dir(visit.at("kit")).unwrap();
    let ran = visit.run("generate job.toml -o kit --force").ends(0).omits("moved kit");
    assert!(!visit.has("kit.previous"), "{}", ran.err);
    assert!(visit.at("kit/manifest.json").is_file());
    let printed = visit.yes("generate job.toml -o other --format json");
    assert_eq!(printed, visit.read("other/manifest.json"));
}

#[test]
fn a_job_on_standard_input_or_of_windows_and_a_table_with_decimal_commas_make_the_same_kit() {
    let (visit, kit) = (Visit::new(), kit_of(JOB, TABLE));
    visit.put("errors.csv", TABLE).put("text", JOB);
    visit.shell("$N generate - -o kit < text").ends(0);
    assert_eq!(kit_in(&visit), kit);
    let semicolons = TABLE.replace(',', ";").replace('.', ",").replace('\n', "\r\n");
    assert_eq!(kit_of(JOB, &format!("\u{feff}{semicolons}").replace('-', "−")), kit, "commas");
    assert_eq!(kit_of(&JOB.replace('\n', "\r\n"), TABLE), kit, "line ends of Windows");
}
