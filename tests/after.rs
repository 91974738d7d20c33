//! `verify --after`: the figures of the page and the verdict on what was measured.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const JOB: &str = r#"schema = 1
[machine]
name = "VMC 900"
[machine.axes.x]
travel_mm = [0.0, 100.0]
reference_mm = 0.0
[machine.axes.y]
travel_mm = [0.0, 100.0]
reference_mm = 0.0
[measurement]
errors = "errors.csv"
active_while_measuring = "none"
[compensation]
controller = "generic"
[compensation.axes.x]
spacing_mm = 50.0
[acceptance]
max_deviation_um = 1.0
"#;
const ERRORS: &str = "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,6,3\nx,100,16,-4\n";

fn nonius(directory: &Path, arguments: &str) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments.split_whitespace())
        .current_dir(directory)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace('\r', "");
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// A directory with the job, its kit and the second measurement.
fn visit(after: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("job.toml"), JOB).unwrap();
    fs::write(path.join("errors.csv"), ERRORS).unwrap();
    fs::write(path.join("after.csv"), after).unwrap();
    let (_, _, said) = nonius(path, "generate job.toml -o kit");
    assert!(path.join("kit/manifest.json").is_file(), "{said}");
    directory
}

fn judged(directory: &Path, after: &str) -> (Option<i32>, Value) {
    let command = format!("verify job.toml --tables kit --after {after} --format json");
    let (status, text, said) = nonius(directory, &command);
    (
        status,
        serde_json::from_str(&text).unwrap_or_else(|_| panic!("{said}")),
    )
}

/// A table in X and Y with the same standard uncertainty everywhere.
fn table(rows: &[[f64; 3]], u_um: f64) -> String {
    let mut text = String::from("axis,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n");
    for [at, ex, ey] in rows {
        text.push_str(&format!("x,{at},{ex},{ey},{u_um},{u_um}\n"));
    }
    text
}

#[test]
fn figures_are_zero_at_the_reference_whatever_the_laser_counted_from() {
    let directory = visit(&table(
        &[[0.0, 7.0, -3.0], [50.0, 7.3, -3.1], [100.0, 6.5, -2.8]],
        0.15,
    ));
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(0), &"pass".into()));
    let exx = &document["terms"]["EXX"];
    assert_eq!(exx["before_um"], 16.0);
    assert_eq!(exx["forecast_um"], 0.0);
    assert_eq!(exx["after_um"], 0.5, "6.5 − 7");
    assert_eq!(exx["u_um"], 0.15);
    assert_eq!(exx["difference_um"], 0.5);
    assert_eq!(document["terms"]["EYX"]["after_um"], 0.2);
    assert_eq!(document["max_residual_um"], 0.5);
    assert_eq!(document["diagnosis"]["as_forecast"], true);
    assert_eq!(document["causes"], serde_json::json!([]));
}

#[test]
fn the_uncertainty_decides_between_fail_and_undecided() {
    for (um, u_um, verdict) in [
        (0.8, 0.1, "pass"),
        (0.8, 0.2, "undecided"),
        (1.4, 0.2, "undecided"),
        (1.6, 0.2, "fail"),
    ] {
        let directory = visit(&table(
            &[[0.0, 0.0, 0.0], [50.0, um, 0.0], [100.0, 0.0, 0.0]],
            u_um,
        ));
        let (status, document) = judged(directory.path(), "after.csv");
        assert_eq!(document["verdict"], verdict, "{um} ± {}", 2.0 * u_um);
        assert_eq!(status, Some(i32::from(verdict != "pass")));
    }
}

#[test]
fn what_was_not_measured_again_is_named_and_decides_nothing() {
    let directory = visit("axis,position_mm,ex_um\nx,0,0\nx,50,0.1\nx,100,0.1\n");
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!(
        (status, &document["verdict"]),
        (Some(1), &"undecided".into())
    );
    assert!(document["terms"]["EYX"]["after_um"].is_null());
    assert!(
        document["causes"]
            .to_string()
            .contains("not measured afterwards")
    );
    assert!(document["causes"].to_string().contains("EYX"));
}

#[test]
fn a_shorter_range_leaves_it_undecided() {
    let directory = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.1, 0.0]], 0.1));
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["verdict"], "undecided");
    assert!(
        document["causes"]
            .to_string()
            .contains("nothing is known of the rest")
    );
}

#[test]
fn tables_that_were_changed_fail_whatever_was_measured() {
    let directory = visit(&table(
        &[[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [100.0, 0.0, 0.0]],
        0.1,
    ));
    let file = directory.path().join("kit/compensation.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}\n")).unwrap();
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(1), &"fail".into()));
    assert!(document["causes"].to_string().contains("hash"));
}

#[test]
fn tables_that_do_not_act_are_named_with_the_look_that_decides() {
    let directory = visit(&table(
        &[[0.0, 0.0, 0.0], [50.0, 6.0, 3.0], [100.0, 16.0, -4.0]],
        0.1,
    ));
    let (status, page, _) = nonius(
        directory.path(),
        "verify job.toml --tables kit --after after.csv",
    );
    assert_eq!(status, Some(1));
    assert!(page.contains("NOT ACTIVE: all tables do not act"), "{page}");
    assert!(page.contains("to decide:"), "{page}");
    assert!(page.contains("verdict: fail"), "{page}");
}

#[test]
fn a_job_with_readings_gives_what_its_separated_table_gives() {
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/readings");
    let directory = tempfile::tempdir().unwrap();
    for name in ["job.toml", "readings.csv"] {
        fs::copy(start.join(name), directory.path().join(name)).unwrap();
    }
    nonius(directory.path(), "generate job.toml -o kit");
    nonius(directory.path(), "separate job.toml -o after.csv");
    let (_, by_job) = judged(directory.path(), "job.toml");
    let (_, by_table) = judged(directory.path(), "after.csv");
    assert!(by_job["terms"]["EXX"]["after_um"].is_number());
    for part in ["terms", "diagonals", "verdict", "diagnosis"] {
        assert_eq!(by_job[part], by_table[part]);
    }
    let exx = &by_job["terms"]["EXX"];
    assert_eq!(
        exx["after_um"], exx["before_um"],
        "the same readings: nothing acts"
    );
}
