//! What `nonius standards` takes beside tables of runs: readings of the body diagonals, jobs that
//! name them, and `.rtl` files.
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fixture(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(path)
}

fn standards(file: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .arg("standards")
        .arg(file)
        .args(options)
        .output()
        .unwrap()
}

fn document(file: &Path, options: &[&str]) -> Value {
    let options = [options, &["--format", "json"]].concat();
    let output = standards(file, &options);
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn near(found: &Value, expected: f64) {
    let um = found.as_f64().unwrap();
    assert!((um - expected).abs() < 1e-3, "{um}, expected {expected}");
}

/// Golden figures of case D, to the digits of the reference.
fn golden(document: &Value) {
    let part = &document["iso_230_6"];
    assert_eq!(part["label"], "from step-diagonal cell ends, not ISO 230-6");
    near(&part["E_d_um"], 28.9797);
    near(&part["B_d_um"], 9.1463);
    for (name, e_um) in [("PPP", 26.0335), ("NPP", 20.5642), ("PNP", 21.6609), ("PPN", 28.9797)] {
        let of = &part["diagonals"][name];
        near(&of["E_um"], e_um);
        near(&of["range_um"], e_um);
        for figure in ["E_up", "E_down", "M", "B", "B_mean", "R", "A"] {
            assert!(of[format!("{figure}_um")].is_number(), "{name} {figure}");
        }
    }
    near(&part["diagonals"]["PPP"]["E_up_um"], 19.8554);
    near(&part["diagonals"]["PPP"]["E_down_um"], 17.0333);
}

#[test]
fn a_job_with_readings_gives_the_figures_of_its_diagonals() {
    let document = document(&fixture("diagonals/case_d_bidirectional/job.toml"), &[]);
    golden(&document);
    let targets = &document["iso_230_6"]["conditions"]["list"][2];
    assert_eq!(targets["outcome"], "met");
    assert_eq!(targets["found"], "11 targets on 1358.97 mm");
}

/// No figure depends on the box; what does is named as not tested.
#[test]
fn readings_alone_give_the_same_figures() {
    let readings = fixture("diagonals/case_d_bidirectional/readings.csv");
    let document = document(&readings, &[]);
    golden(&document);
    let targets = &document["iso_230_6"]["conditions"]["list"][2];
    assert_eq!(targets["outcome"], "not tested");
    let text = String::from_utf8(standards(&readings, &[]).stdout).unwrap();
    for words in ["E up  E down", "no job: the readings are taken", "E_d"] {
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn one_direction_has_no_figures_of_the_machine() {
    let document = document(&fixture("diagonals/case_a_ideal/readings.csv"), &[]);
    let part = &document["iso_230_6"];
    assert_eq!(part["E_d_um"], Value::Null);
    near(&part["largest_range_um"], 21.4574);
    near(&part["range_over_all_um"], 30.8255);
    near(&part["diagonals"]["PPN"]["E_up_um"], 21.4574);
    assert_eq!(part["diagonals"]["PPN"]["E_um"], Value::Null);
}

/// The forward runs of case A, and each of them walked back under its own name (NNN …): numbered,
/// signed and zeroed from the far corner.
fn with_own_reverse_runs(readings: &str) -> String {
    let rows: Vec<Vec<&str>> = readings
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
        .collect();
    let mut text = "diagonal,node,moved,deviation_um\n".to_string();
    let mut add = |name: &str, node: usize, moved: &str, um: f64| {
        text += &format!("{name},{node},{moved},{um:.9}\n");
    };
    for (name, back) in [("PPP", "NNN"), ("NPP", "PNN"), ("PNP", "NPN"), ("PPN", "NNP")] {
        let walk: Vec<&Vec<&str>> = rows.iter().filter(|row| row[0] == name).collect();
        let um = |node: usize| walk[node][5].parse::<f64>().unwrap();
        let last = walk.len() - 1;
        for (node, row) in walk.iter().enumerate() {
            add(name, node, row[4], um(node));
        }
        for node in 0..=last {
            let moved = if node == 0 { "" } else { walk[last + 1 - node][4] };
            add(back, node, moved, um(last) - um(last - node));
        }
    }
    text
}

/// The offset of such a run to the forward run is not known, so it has no part in E and B.
#[test]
fn runs_under_the_name_of_a_reverse_run_are_left_out_and_named() {
    let forward = fixture("diagonals/case_a_ideal/readings.csv");
    let text = std::fs::read_to_string(&forward).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let both = folder.path().join("readings.csv");
    std::fs::write(&both, with_own_reverse_runs(&text)).unwrap();
    let (alone, both) = (document(&forward, &[]), document(&both, &[]));
    let figures = |of: &Value| of["iso_230_6"]["diagonals"].clone();
    assert_eq!(figures(&alone), figures(&both));
    let notes = both["iso_230_6"]["notes"].to_string();
    assert!(notes.contains("NNN …"), "{notes}");
}

/// Figures of an `.rtl` file that notes a temperature of the material.
fn of_rtl(sign: &str, targets_run: &str) -> Value {
    let file = fixture("formats/rtl_linear_bidirectional_selfmade.rtl");
    let way = ["--sign", sign, "--targets-run", targets_run];
    let material = ["--material-corrected", "not-stated"];
    document(&file, &[&way[..], &material[..]].concat())
}

/// Two runs out, two back; by hand from the first and the last target of the file.
#[test]
fn the_runs_of_an_rtl_file_keep_their_scatter() {
    let document = of_rtl("as-error", "+");
    assert_eq!(document["runs"], serde_json::json!({ "up": 2, "down": 2 }));
    let iso = &document["iso_230_2"];
    let first = &iso["targets"][0];
    assert_eq!(first["target_mm"], -200.0);
    near(&first["mean_up_um"], 0.5); // 0.4 and 0.6
    near(&first["s_up_um"], 0.2 / 2.0_f64.sqrt());
    near(&iso["B_mean_um"], 1.55);
    let notes = iso["notes"].to_string();
    assert!(notes.contains("Axis: X"), "{notes}");
}

/// Against the axis, the directions change places and every deviation changes its sign.
#[test]
fn the_way_of_the_targets_turns_directions_and_deviations() {
    let of = |way| of_rtl("as-error", way);
    let (plus, minus) = (of("+"), of("-"));
    let (plus, minus) = (&plus["iso_230_2"], &minus["iso_230_2"]);
    for (here, there) in
        [("E_um", "E_um"), ("R_um", "R_um"), ("A_um", "A_um"), ("E_up_um", "E_down_um")]
    {
        near(&minus[there], plus[here].as_f64().unwrap());
    }
    let (first, last) = (&minus["targets"][0], &plus["targets"][8]);
    near(&first["target_mm"], -last["target_mm"].as_f64().unwrap());
    near(&first["mean_down_um"], -last["mean_up_um"].as_f64().unwrap());
    near(&first["B_um"], last["B_um"].as_f64().unwrap());
    let turned = of_rtl("as-correction", "+");
    near(&turned["iso_230_2"]["B_mean_um"], -1.55);
}

#[test]
fn a_stated_travel_is_in_the_document() {
    let file = fixture("standards/x_axis.csv");
    let stated = document(&file, &["--travel-mm", "1000"]);
    assert_eq!(stated["travel_mm"], 1000.0);
    assert_eq!(stated["iso_230_2"]["condition_missed"], false);
    assert_eq!(stated["iso_230_2"]["editions"], serde_json::json!([1997, 2006, 2014]));
    assert_eq!(document(&file, &[])["travel_mm"], Value::Null);
}

/// Above 2 m the document names the figures that the standard does not know.
#[test]
fn figures_beside_the_standard_are_marked() {
    let file = fixture("standards/x_axis.csv");
    let long = document(&file, &["--travel-mm", "2500"]);
    let marked = &long["iso_230_2"]["not_in_the_standard"];
    assert_eq!(*marked, serde_json::json!(["A", "R"]));
    assert_eq!(long["iso_230_2"]["condition_missed"], true);
    let text = standards(&file, &["--travel-mm", "2500"]).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("repeatability, not in the standard above 2 m"), "{text}");
}
