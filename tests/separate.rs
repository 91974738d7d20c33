//! `nonius separate` and `generate` from readings, as a user runs them: the golden cases, the
//! words that go with a result, what is refused.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn fixture(case: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/diagonals")
        .join(case)
}

/// A copy of a golden case, with its job changed.
fn copy(case: &str, change: impl Fn(String) -> String) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let put = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    let read = |name: &str| fs::read_to_string(fixture(case).join(name)).unwrap();
    put("readings.csv", read("readings.csv"));
    put("truth.csv", read("truth.csv"));
    put("job.toml", change(read("job.toml")));
    directory
}

fn nonius(directory: &Path, command: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    text(output)
}

/// What was printed with the answer no: an error is not determined, or something speaks against
/// the result.
fn answered_no(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{}", stderr(output));
    text(output)
}

fn text(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(directory: &Path, command: &str) -> Value {
    serde_json::from_str(&stdout(&nonius(directory, command))).unwrap()
}

fn refused(output: &Output, words: &str) {
    assert_eq!(output.status.code(), Some(2), "{}", stderr(output));
    let said = stderr(output);
    assert!(said.contains(words), "{said}");
}

#[test]
fn the_separated_table_and_the_job_with_readings_make_the_same_control_files() {
    let directory = copy("case_b_setup", |job| job);
    let from_readings = nonius(directory.path(), "generate job.toml -o one");
    stdout(&from_readings);
    stdout(&nonius(directory.path(), "separate job.toml -o errors.csv"));
    let job = fs::read_to_string(directory.path().join("job.toml")).unwrap();
    let (before, after) = job.split_once("[measurement.step_diagonal]").unwrap();
    let (_, after) = after.split_once("[compensation]").unwrap();
    let job = before.replace("readings = \"readings.csv\"", "errors = \"errors.csv\"");
    fs::write(
        directory.path().join("nine.toml"),
        format!("{job}[compensation]{after}"),
    )
    .unwrap();
    stdout(&nonius(directory.path(), "generate nine.toml -o two"));
    for name in ["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"] {
        let read = |kit: &str| fs::read(directory.path().join(kit).join(name)).unwrap();
        assert_eq!(read("one"), read("two"), "{name}");
    }
    let manifest = fs::read_to_string(directory.path().join("two/manifest.json")).unwrap();
    let sources = |manifest: &str| manifest.matches("readings.csv").count();
    assert_eq!(
        sources(&manifest),
        1,
        "the source of the table is traced: {manifest}"
    );
    stdout(&nonius(directory.path(), "verify job.toml --tables one"));
}

#[test]
fn without_linear_axes_the_scales_are_named_and_left_out() {
    let directory = copy("case_b_setup", |job| {
        let (before, after) = job
            .split_once("[[measurement.step_diagonal.linear]]")
            .unwrap();
        format!(
            "{before}[compensation]{}",
            after.split_once("[compensation]").unwrap().1
        )
    });
    let page = serde_json::from_str::<Value>(&answered_no(&nonius(
        directory.path(),
        "separate job.toml --format json",
    )))
    .unwrap();
    assert_eq!(page["rank"]["rank"], 4);
    assert_eq!(page["rank"]["unknowns"], 6);
    let words = page["rank"]["undetermined"][0].as_str().unwrap();
    assert_eq!(
        words,
        "scale of X, Y and Z can be traded against each other; measure two axes along their length"
    );
    assert!(
        page["errors"].get("EXX").is_none(),
        "not determined, so absent"
    );
    assert!(
        page["errors"].get("EYX").is_some(),
        "determined whatever the set-up"
    );
    assert!(page.get("setup_arcsec").is_none());
    let xy = page["squareness_um_per_m"]["xy"].as_f64().unwrap();
    // What is not known of the scales (some 20 um/m) times the tilts (0.5 mrad) stays in it.
    assert!((xy - 19.1667).abs() < 0.05, "{xy}");
    let text = answered_no(&nonius(directory.path(), "separate job.toml"));
    assert!(text.contains("NOT DETERMINED by these readings"), "{text}");
}

#[test]
fn one_linear_axis_leaves_the_trade_of_the_other_two() {
    let directory = copy("case_b_setup", |job| {
        let parts: Vec<&str> = job.split("[[measurement.step_diagonal.linear]]").collect();
        let tail = parts[3].split_once("[compensation]").unwrap().1;
        format!(
            "{}[[measurement.step_diagonal.linear]]{}[compensation]{tail}",
            parts[0], parts[1]
        )
    });
    let page = serde_json::from_str::<Value>(&answered_no(&nonius(
        directory.path(),
        "separate job.toml --format json",
    )))
    .unwrap();
    assert_eq!(page["rank"]["rank"], 5);
    assert_eq!(
        page["rank"]["undetermined"][0],
        "scale of Y and Z can be traded against each other; measure one axis along its length"
    );
    assert!(page["errors"].get("EXX").is_some());
}

#[test]
fn an_assumed_set_up_is_said_in_every_output() {
    let directory = copy("case_a_ideal", |job| job);
    let words = "set-up assumed perfect";
    let text = stdout(&nonius(directory.path(), "separate job.toml"));
    assert!(text.contains(words), "{text}");
    let page = json(directory.path(), "separate job.toml --format json");
    assert!(page["labels"].to_string().contains(words));
    let csv = stdout(&nonius(directory.path(), "separate job.toml -o -"));
    assert!(csv.contains(words), "{csv}");
    let kit = nonius(directory.path(), "generate job.toml -o kit");
    assert!(stdout(&kit).contains(words) || stderr(&kit).contains(words));
}

#[test]
fn a_measured_linear_axis_serves_as_well_as_its_stated_slope() {
    let directory = copy("case_b_setup", |job| {
        job.replace("slope_um_per_m = 20.000000000", "errors = \"truth.csv\"")
    });
    let page = json(directory.path(), "separate job.toml --format json");
    let stated = json(&fixture("case_b_setup"), "separate job.toml --format json");
    let end = |page: &Value| page["errors"]["EXX"]["deviation_um"][30].as_f64().unwrap();
    assert!((end(&page) - end(&stated)).abs() < 1e-5);
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let directory = fixture("case_d_bidirectional");
    let one = stdout(&nonius(
        &directory,
        "separate job.toml --format json --trials 300",
    ));
    let two = stdout(&nonius(
        &directory,
        "separate job.toml --format json --trials 300",
    ));
    assert_eq!(one, two);
    let other = stdout(&nonius(
        &directory,
        "separate job.toml --format json --trials 300 --seed 2",
    ));
    assert_ne!(one, other);
}

#[test]
fn diagonals_of_case_d_have_the_figures_of_the_reference() {
    let page = json(
        &fixture("case_d_bidirectional"),
        "separate job.toml --format json",
    );
    assert!((page["diagonals"]["e_d_um"].as_f64().unwrap() - 28.9797).abs() < 1e-6);
    assert!((page["diagonals"]["b_d_um"].as_f64().unwrap() - 9.146_333).abs() < 1e-6);
    assert_eq!(
        page["diagonals"]["label"],
        "from step-diagonal cell ends, not ISO 230-6"
    );
    assert!(page["errors"].get("EXX+").is_some() && page["errors"].get("EXX-").is_some());
}

#[test]
fn two_tables_are_refused_where_the_reversal_is_not_determined() {
    let directory = copy("case_d_bidirectional", |job| {
        job.replace(
            "[compensation]\n",
            "[compensation]\nbacklash = \"two-tables\"\n",
        )
    });
    let output = nonius(directory.path(), "generate job.toml -o kit");
    refused(&output, "which these readings do not determine");
    assert!(!directory.path().join("kit").exists());
}

/// The straight diagonals of case A's machine, from its cell ends.
fn straight() -> tempfile::TempDir {
    let directory = copy("case_a_ideal", |job| {
        job.replace(
            "steps = 30\norder = \"XYZ\"\nsetup = \"assume-perfect\"",
            "steps = 30\nkind = \"straight\"\nclosure_errors = \"truth.csv\"",
        )
    });
    let readings = fs::read_to_string(fixture("case_a_ideal").join("readings.csv")).unwrap();
    let mut text = "diagonal,run,direction,node,deviation_um\n".to_string();
    for line in readings.lines().filter(|line| line.contains("forward")) {
        let cells: Vec<&str> = line.split(',').collect();
        let node: usize = cells[3].parse().unwrap();
        if node.is_multiple_of(3) {
            text += &format!("{},1,forward,{},{}\n", cells[0], node / 3, cells[5]);
        }
    }
    fs::write(directory.path().join("readings.csv"), text).unwrap();
    directory
}

#[test]
fn straight_runs_give_squareness_one_combination_and_the_closure_test() {
    let directory = straight();
    let page = json(directory.path(), "separate job.toml --format json");
    for (plane, wanted) in [("xy", 19.166_667), ("xz", -13.055_556), ("yz", 12.5)] {
        let found = page["squareness_um_per_m"][plane].as_f64().unwrap();
        assert!((found - wanted).abs() < 2e-6, "{plane}: {found}");
    }
    let sum = page["diagonals"]["scale_sum_um_mm"].as_f64().unwrap();
    assert!((sum - 14760.0).abs() < 1e-3, "{sum}");
    for diagonal in ["PPP", "NPP", "PNP", "PPN"] {
        let closure = &page["diagonals"][diagonal]["closure_largest_um"];
        // Both files carry nine decimals.
        assert!(closure.as_f64().unwrap() <= 1e-6, "{diagonal}: {closure}");
    }
    let text = stdout(&nonius(directory.path(), "separate job.toml"));
    assert!(text.contains("Closure test"), "{text}");
}

#[test]
fn straight_runs_make_no_table() {
    let directory = straight();
    let output = nonius(directory.path(), "separate job.toml -o errors.csv");
    refused(&output, "straight runs hold no nine errors");
    let output = nonius(directory.path(), "generate job.toml -o kit");
    refused(
        &output,
        "straight runs of the diagonals hold no nine errors",
    );
}

#[test]
fn an_existing_table_is_kept_and_a_job_of_errors_is_not_separated() {
    let directory = copy("case_a_ideal", |job| job);
    fs::write(directory.path().join("errors.csv"), "mine").unwrap();
    let output = nonius(directory.path(), "separate job.toml -o errors.csv");
    refused(&output, "exists, so it is not overwritten");
    assert_eq!(
        fs::read_to_string(directory.path().join("errors.csv")).unwrap(),
        "mine"
    );
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let output = nonius(&fixture, "separate generic.toml");
    refused(&output, "separated already");
}

/// Case B with its three linear axes changed.
fn changed_case_b(change: impl Fn(String) -> String) -> tempfile::TempDir {
    copy("case_b_setup", change)
}

fn disagrees(directory: &Path) {
    let output = nonius(directory, "separate job.toml --trials 0");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("they DISAGREE"), "{text}");
    let output = nonius(directory, "separate job.toml --trials 0 --format json");
    assert_eq!(output.status.code(), Some(1));
    let page: Value = serde_json::from_slice(&output.stdout).unwrap();
    let probability = page["redundancy"]["probability"].as_f64().unwrap();
    assert!(probability < 0.01, "{probability}");
    let words = page["redundancy"]["contradiction"].as_str().unwrap();
    assert!(words.contains("laser_sign") && words.contains("size of the box"));
    assert_eq!(page["doubts"][0], words);
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    assert!(page.get("setup_arcsec").is_none());
    let output = nonius(directory, "generate job.toml -o kit");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains("verdict: pass"), "{text}");
    assert!(
        text.contains("DOUBTFUL: linear axes and diagonals DISAGREE"),
        "{text}"
    );
    let output = nonius(directory, "verify job.toml --tables kit --format json");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let page: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_ne!(page["verdict"], "pass");
    assert!(page["causes"].to_string().contains("DISAGREE"));
}

#[test]
fn slopes_that_contradict_the_diagonals_are_told_and_nothing_passes() {
    let z = "slope_um_per_m = 13.888888889";
    for wrong in [
        "slope_um_per_m = 113.9",
        "slope_um_per_m = -13.9\nu_um_per_m = 0.5",
        "slope_um_per_m = 113.9\nu_um_per_m = 0.5",
    ] {
        let directory = changed_case_b(|job| job.replace(z, wrong));
        disagrees(directory.path());
    }
    let all_known = changed_case_b(|job| {
        let job = job.replace(z, "slope_um_per_m = -13.9");
        let with_u =
            |job: String, line: &str| job.replace(line, &format!("{line}\nu_um_per_m = 0.5"));
        ["20.000000000", "-16.666666667", "-13.9"]
            .iter()
            .fold(job, |job, slope| {
                with_u(job, &format!("slope_um_per_m = {slope}"))
            })
    });
    disagrees(all_known.path());
}

#[test]
fn a_wrong_sign_of_the_laser_or_size_of_the_box_is_told() {
    let sign = changed_case_b(|job| job.replace("steps = 30", "steps = 30\nlaser_sign = \"-\""));
    disagrees(sign.path());
    let size = changed_case_b(|job| {
        job.replace(
            "y = 720.0000, z = 720.0000 }",
            "y = 720.0000, z = 620.0000 }",
        )
    });
    disagrees(size.path());
}

#[test]
fn the_golden_case_agrees() {
    let page = json(
        &fixture("case_b_setup"),
        "separate job.toml --trials 0 --format json",
    );
    assert!(
        page["redundancy"]["probability"].as_f64().unwrap() > 0.05,
        "{page}"
    );
    assert!(page["redundancy"]["contradiction"].is_null());
    assert_eq!(page["redundancy"]["degrees_of_freedom"], 1);
    let text = stdout(&nonius(&fixture("case_b_setup"), "separate job.toml"));
    assert!(text.contains("they agree"), "{text}");
}

/// 5 µm at 900 mm are 5.6 µm/m.
#[test]
fn the_uncertainty_of_a_linear_table_is_that_of_its_column() {
    let directory = copy("case_b_setup", |job| {
        let job = job.replace("slope_um_per_m = 20.000000000", "errors = \"x.csv\"");
        job.replace(
            "slope_um_per_m = -16.666666667",
            "slope_um_per_m = -16.666666667\nu_um_per_m = 0.1",
        )
        .replace(
            "[[measurement.step_diagonal.linear]]\naxis = \"z\"\nslope_um_per_m = 13.888888889\n",
            "",
        )
    });
    let table = "axis,position_mm,ex_um,u_ex_um\nx,0,0,0\nx,450,9,2.5\nx,900,18,5\n";
    fs::write(directory.path().join("x.csv"), table).unwrap();
    let page = json(
        directory.path(),
        "separate job.toml --trials 0 --format json",
    );
    let end = |term: &str| page["errors"][term]["u_um"][30].as_f64().unwrap();
    assert!((end("EXX") - 5.0).abs() < 1e-3, "{}", end("EXX"));
    let labels = page["labels"].to_string();
    assert!(!labels.contains("states no uncertainty"), "{labels}");
    fs::write(
        directory.path().join("x.csv"),
        table
            .replace(",u_ex_um", "")
            .replace(",0,0,0", ",0,0")
            .replace(",2.5", "")
            .replace(",18,5", ",18"),
    )
    .unwrap();
    let page = json(
        directory.path(),
        "separate job.toml --trials 100 --format json",
    );
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    assert!(page["labels"].to_string().contains("states no uncertainty"));
    let figures = page["monte_carlo"]["figures"].to_string();
    assert!(
        !figures.contains("range EXX") && figures.contains("range EYY"),
        "{figures}"
    );
}
