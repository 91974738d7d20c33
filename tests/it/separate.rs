//! `nonius separate` and `generate` from readings, as a user runs them: the golden cases, the
//! words that go with a result, what is refused.
use crate::support::run::{ended, nonius};
use crate::support::skipped;
use nonius::inputs::error_table::Remarks;
use nonius::quantity::axis::ErrorTerm;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

mod contradictions;

mod angles;

fn fixture(case: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals").join(case)
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

/// Labels where what is left of the angles contradicts the result.
fn labels_of_a_doubtful(directory: &Path) -> String {
    let page = answered_no(&nonius(directory, "separate job.toml --format json"));
    serde_json::from_str::<Value>(&page).unwrap()["labels"].to_string()
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
    fs::write(directory.path().join("nine.toml"), format!("{job}[compensation]{after}")).unwrap();
    stdout(&nonius(directory.path(), "generate nine.toml -o two"));
    for name in ["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"] {
        let read = |kit: &str| fs::read(directory.path().join(kit).join(name)).unwrap();
        assert_eq!(read("one"), read("two"), "{name}");
    }
    let manifest = fs::read_to_string(directory.path().join("two/manifest.json")).unwrap();
    let sources = |manifest: &str| manifest.matches("readings.csv").count();
    assert_eq!(sources(&manifest), 1, "the source of the table is traced: {manifest}");
    stdout(&nonius(directory.path(), "verify job.toml --tables one"));
}

#[test]
fn without_linear_axes_the_scales_are_named_and_left_out() {
    let directory = copy("case_b_setup", |job| {
        let (before, after) = job.split_once("[[measurement.step_diagonal.linear]]").unwrap();
        format!("{before}[compensation]{}", after.split_once("[compensation]").unwrap().1)
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
    assert!(page["errors"].get("EXX").is_none(), "not determined, so absent");
    assert!(page["errors"].get("EYX").is_some(), "determined whatever the set-up");
    assert!(page.get("setup_arcsec").is_none());
    let xy = page["squareness_um_per_m"]["xy"].as_f64().unwrap();
    // What is not known of the scales (some 20 um/m) times the tilts (0.5 mrad) stays in it.
    assert!((xy - 19.1667).abs() < 0.05, "{xy}");
    let text = answered_no(&nonius(directory.path(), "separate job.toml -v"));
    assert!(text.contains("NOT DETERMINED by these readings"), "{text}");
    assert!(text.contains("U(95 %)") && !text.contains("-0.000"), "{text}");
}

#[test]
fn one_linear_axis_leaves_the_trade_of_the_other_two() {
    let directory = copy("case_b_setup", |job| {
        let parts: Vec<&str> = job.split("[[measurement.step_diagonal.linear]]").collect();
        let tail = parts[3].split_once("[compensation]").unwrap().1;
        format!("{}[[measurement.step_diagonal.linear]]{}[compensation]{tail}", parts[0], parts[1])
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
    let text = stdout(&nonius(directory.path(), "separate job.toml -v"));
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
    let one = stdout(&nonius(&directory, "separate job.toml --format json --trials 300"));
    let two = stdout(&nonius(&directory, "separate job.toml --format json --trials 300"));
    assert_eq!(one, two);
    let other =
        stdout(&nonius(&directory, "separate job.toml --format json --trials 300 --seed 2"));
    assert_ne!(one, other);
}

#[test]
fn diagonals_of_case_d_have_the_figures_of_the_reference() {
    let page = json(&fixture("case_d_bidirectional"), "separate job.toml --format json");
    assert!((page["diagonals"]["e_d_um"].as_f64().unwrap() - 28.9797).abs() < 1e-6);
    assert!((page["diagonals"]["b_d_um"].as_f64().unwrap() - 9.146_333).abs() < 1e-6);
    assert_eq!(page["diagonals"]["label"], "from step-diagonal cell ends, not ISO 230-6");
    assert!(page["errors"].get("EXX+").is_some() && page["errors"].get("EXX-").is_some());
}

#[test]
fn two_tables_are_refused_where_the_reversal_is_not_determined() {
    let directory = copy("case_d_bidirectional", |job| {
        job.replace("[compensation]\n", "[compensation]\nbacklash = \"two-tables\"\n")
    });
    let output = nonius(directory.path(), "generate job.toml -o kit");
    refused(&output, "which these readings do not determine");
    assert!(!directory.path().join("kit").exists());
}

/// The straight diagonals of case A's machine, from its cell ends.
fn straight() -> tempfile::TempDir {
    straight_with("", |readings| readings)
}

/// Reading errors of the forward run at the nodes of a diagonal.
type Forward = (String, Vec<f64>);

/// The same with more keys in `[measurement.step_diagonal]` and below, and other rows.
fn straight_with(keys: &str, change: impl Fn(String) -> String) -> tempfile::TempDir {
    let directory = copy("case_a_ideal", |job| {
        job.replace(
            "steps = 30\norder = \"XYZ\"\nsetup = \"assume-perfect\"",
            &format!("steps = 30\nkind = \"straight\"\nclosure_errors = \"truth.csv\"\n{keys}"),
        )
    });
    let mut text = "diagonal,run,direction,node,deviation_um\n".to_string();
    for (diagonal, values) in cell_ends() {
        for (node, value) in values.iter().enumerate() {
            text += &format!("{diagonal},1,forward,{node},{value}\n");
        }
    }
    fs::write(directory.path().join("readings.csv"), change(text)).unwrap();
    directory
}

fn cell_ends() -> Vec<Forward> {
    let readings = fs::read_to_string(fixture("case_a_ideal").join("readings.csv")).unwrap();
    let mut all: Vec<Forward> = Vec::new();
    for line in readings.lines().filter(|line| line.contains("forward")) {
        let cells: Vec<&str> = line.split(',').collect();
        if !cells[3].parse::<usize>().unwrap().is_multiple_of(3) {
            continue;
        }
        if all.last().is_none_or(|(name, _)| name != cells[0]) {
            all.push((cells[0].to_string(), Vec::new()));
        }
        all.last_mut().unwrap().1.push(cells[5].parse().unwrap());
    }
    all
}

/// Runs back over the same nodes, 5 µm lower everywhere: in rows `reverse`, or under the names of
/// the ways back, numbered, signed and zeroed along their own travel.
fn runs_back(own_names: bool) -> String {
    let back = [("PPP", "NNN"), ("NPP", "PNN"), ("PNP", "NPN"), ("PPN", "NNP")];
    let mut text = String::new();
    for (diagonal, values) in cell_ends() {
        let last = values.len() - 1;
        let (_, name) = back.iter().find(|(name, _)| *name == diagonal).unwrap();
        for (node, value) in values.iter().enumerate() {
            text += &if own_names {
                format!("{name},1,forward,{node},{}\n", values[last] - values[last - node])
            } else {
                format!("{diagonal},1,reverse,{node},{}\n", value - 5.0)
            };
        }
    }
    text
}

#[test]
fn straight_runs_with_a_zero_of_their_own_give_no_reversal() {
    let figures = |own_names: bool| {
        let directory = straight_with("", |rows| rows + &runs_back(own_names));
        let text = stdout(&nonius(directory.path(), "separate job.toml -v"));
        (json(directory.path(), "separate job.toml --format json"), text)
    };
    let (known, _) = figures(false);
    let (own, text) = figures(true);
    let close = |value: &Value, wanted: f64| (value.as_f64().unwrap() - wanted).abs() < 1e-6;
    assert!(close(&known["diagonals"]["b_d_um"], 5.0), "{known}");
    assert!(close(&known["diagonals"]["PPP"]["range_um"], 23.543_453), "{known}");
    assert_eq!(own["diagonals"]["e_d_um"], Value::Null);
    assert_eq!(own["diagonals"]["b_d_um"], Value::Null);
    assert!(close(&own["diagonals"]["PPP"]["range_um"], 18.543_453), "{own}");
    for plane in ["xy", "xz", "yz"] {
        let wanted = known["squareness_um_per_m"][plane].as_f64().unwrap();
        assert!(close(&own["squareness_um_per_m"][plane], wanted));
    }
    assert!(own["labels"].to_string().contains("their own start"), "{own}");
    assert!(text.contains("no E and B"), "{text}");
}

const TWO_AXES: &str = "
[[measurement.step_diagonal.linear]]
axis = \"x\"
slope_um_per_m = 20.0
u_um_per_m = 0.5
[[measurement.step_diagonal.linear]]
axis = \"y\"
slope_um_per_m = -16.666666667
u_um_per_m = 0.5
[measurement.uncertainty]
noise_um = 0.1
";

#[test]
fn straight_runs_with_two_linear_axes_know_all_scales_with_their_uncertainty() {
    let directory = straight_with(TWO_AXES, |rows| rows);
    let page = json(directory.path(), "separate job.toml --format json");
    assert_eq!(page["rank"]["rank"], 6);
    assert_eq!(page["rank"]["undetermined"].as_array().unwrap().len(), 0);
    let z = page["scale_um_per_m"]["z"].as_f64().unwrap();
    assert!((z - 13.888_889).abs() < 1e-5, "{z}");
    // h_zz = (S - X² h_xx - Y² h_yy)/Z², u(S)/R² = u_end/(2R): by hand, in µm/m.
    let (r2, ends) = (1_846_800.0_f64, 2.0_f64.sqrt() * 0.1);
    let of_total = r2 * (ends / (2.0 * r2.sqrt() / 1000.0));
    let wanted = (of_total.powi(2) + (810_000.0_f64 * 0.5).powi(2) + (518_400.0_f64 * 0.5).powi(2))
        .sqrt()
        / 518_400.0;
    let u = page["u_scale_um_per_m"]["z"].as_f64().unwrap();
    assert!((u - wanted).abs() < 1e-6, "{u} {wanted}");
    let u = page["u_squareness_um_per_m"]["xy"].as_f64().unwrap();
    // R/(2XY)·u(e_end), e_end of one run: √2·0.1 µm.
    assert!((u - 1_358.969 / (2.0 * 0.648e6) * 1000.0 * ends).abs() < 1e-4, "{u}");
    let labels = page["labels"].to_string();
    assert!(labels.contains("laser_ppm is not stated"), "{labels}");
    assert!(labels.contains("the middle of the box"), "{labels}");
}

#[test]
fn the_closure_test_has_a_verdict() {
    let uncertainty = "[measurement.uncertainty]\nnoise_um = 0.1\n";
    let agrees = straight_with(uncertainty, |rows| rows);
    let page = json(agrees.path(), "separate job.toml --format json");
    assert_eq!(page["closure_test"]["agrees"], true);
    let differs =
        straight_with(uncertainty, |rows| rows.replace("NPP,1,forward,17,", "NPP,1,forward,17,1"));
    let page = json(differs.path(), "separate job.toml --format json");
    assert_eq!(page["closure_test"]["agrees"], false, "{page}");
    let text = stdout(&nonius(differs.path(), "separate job.toml -v"));
    assert!(text.contains("NOT in keeping"), "{text}");
    let unknown = straight();
    let text = stdout(&nonius(unknown.path(), "separate job.toml -v"));
    assert!(text.contains("no verdict"), "{text}");
}

#[test]
fn an_assumed_set_up_has_an_uncertainty_only_with_a_stated_tilt() {
    let stated = |keys: &str| {
        let directory = copy("case_d_bidirectional", |job| {
            job.replacen("[compensation]", &format!("{keys}\n[compensation]"), 1)
        });
        json(directory.path(), "separate job.toml --format json --trials 0")
    };
    let page = stated("");
    assert!(page["errors"]["EXX"].get("u_um").is_none(), "{}", page["errors"]["EXX"]);
    assert!(page["labels"].to_string().contains("state `tilt_arcsec`"));
    let page = stated("[measurement.uncertainty]\ntilt_arcsec = 10.0\n");
    let u = page["errors"]["EXX"]["u_um"][10].as_f64().unwrap();
    // R/(2V)·√(1 − (V/R)²)·48.48 µrad = 27.4 µm/m over 0.9 m; noise adds 0.3 µm.
    assert!((u - 24.69).abs() < 0.05, "{u}");
}

/// A mirror tilted by 50 µrad in X and Y of every set-up on a perfect machine: the totals are 0
/// and the closure is clean.
#[test]
fn a_hidden_set_up_error_is_said_in_words() {
    let rows = |text: String| {
        let mut out = text.lines().nth(1).unwrap().to_string() + "\n";
        for diagonal in ["PPP", "NPP", "PNP", "PPN"] {
            for node in 0..=90 {
                let (axis, um) = match node % 3 {
                    _ if node == 0 => ("", 0.0),
                    1 => ("x", 1.2),
                    2 => ("y", 0.0),
                    _ => ("z", 0.0),
                };
                out += &format!("{diagonal},1,forward,{node},{axis},{um}\n");
            }
        }
        out
    };
    let put = |directory: &tempfile::TempDir, answer: fn(&Output) -> String| {
        let path = directory.path().join("readings.csv");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, rows(text)).unwrap();
        answer(&nonius(directory.path(), "separate job.toml -v"))
    };
    let naive = put(&copy("case_a_ideal", |job| job), stdout);
    for words in
        ["WARNING: `setup = \"assume-perfect\"`", "54.359", "-67.949", "proves nothing about"]
    {
        assert!(naive.contains(words), "{words}: {naive}");
    }
    let solved = copy("case_a_ideal", |job| job.replace("setup = \"assume-perfect\"", ""));
    let solved = put(&solved, answered_no);
    for words in [
        "Determined: 6 of 9 errors",
        "NOT DETERMINED by these readings, and left out:\n  - scale of X, Y and Z can be traded against each other; measure two axes along their length",
        "add two [[measurement.step_diagonal.linear]]",
        "face diagonals of two planes",
    ] {
        assert!(solved.contains(words), "{words}: {solved}");
    }
    assert!(!solved.contains("54.359"), "{solved}");
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
    let text = stdout(&nonius(directory.path(), "separate job.toml -v"));
    assert!(text.contains("Closure test"), "{text}");
}

#[test]
fn straight_runs_make_no_table() {
    let directory = straight();
    let output = nonius(directory.path(), "separate job.toml -o errors.csv");
    refused(&output, "straight runs hold no nine errors");
    let output = nonius(directory.path(), "generate job.toml -o kit");
    refused(&output, "straight runs of the diagonals hold no nine errors");
}

#[test]
fn an_existing_table_is_kept_and_a_job_of_errors_is_not_separated() {
    let directory = copy("case_a_ideal", |job| job);
    fs::write(directory.path().join("errors.csv"), "mine").unwrap();
    let output = nonius(directory.path(), "separate job.toml -o errors.csv");
    refused(&output, "exists, so it is not overwritten");
    assert_eq!(fs::read_to_string(directory.path().join("errors.csv")).unwrap(), "mine");
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let output = nonius(&fixture, "separate generic.toml");
    refused(&output, "separated already");
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
    let page = json(directory.path(), "separate job.toml --trials 0 --format json");
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
    let page = json(directory.path(), "separate job.toml --trials 100 --format json");
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    assert!(page["labels"].to_string().contains("states no uncertainty"));
    let figures = page["monte_carlo"]["figures"].to_string();
    assert!(!figures.contains("range EXX") && figures.contains("range EYY"), "{figures}");
}
