//! `verify --after`: the figures of the page and the verdict on what was measured.
use crate::support::run::ended;
use serde_json::Value;
use std::fs;
use std::path::Path;

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

const NONE_ACTIVE: &str = "active_while_measuring = \"none\"";
const KIT_ACTIVE: &str = "active_while_measuring = \"kit\"";

/// A directory with the job, its kit and the second measurement.
fn visit(after: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("job.toml"), JOB).unwrap();
    fs::write(path.join("errors.csv"), ERRORS).unwrap();
    fs::write(path.join("after.csv"), after).unwrap();
    let (_, _, said) = ended(path, "generate job.toml -o kit");
    assert!(path.join("kit/manifest.json").is_file(), "{said}");
    directory
}

fn judged(directory: &Path, after: &str) -> (Option<i32>, Value) {
    let command = format!("verify job.toml --tables kit --after {after} --format json");
    let (status, text, said) = ended(directory, &command);
    (status, serde_json::from_str(&text).unwrap_or_else(|_| panic!("{said}")))
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
    let directory = visit(&table(&[[0.0, 7.0, -3.0], [50.0, 7.3, -3.1], [100.0, 6.5, -2.8]], 0.15));
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(0), &"pass".into()));
    let exx = &document["terms"]["EXX"];
    assert_eq!(exx["before_um"], 16.0);
    assert_eq!(exx["forecast_um"], 0.0);
    assert_eq!(exx["after_um"], 0.5, "6.5 − 7");
    // Two values of the table, each with u = 0.15: the largest and the one at the reference.
    assert_eq!(exx["u_um"], 0.212132);
    assert_eq!(exx["difference_um"], 0.5);
    assert_eq!(document["terms"]["EYX"]["after_um"], 0.2);
    assert_eq!(document["max_residual_um"], 0.5);
    assert_eq!(document["diagnosis"]["as_forecast"], true);
    assert_eq!(document["causes"], serde_json::json!([]));
}

#[test]
fn the_uncertainty_decides_between_fail_and_undecided() {
    for (um, u_um, verdict) in [
        (0.7, 0.1, "pass"), // u = √2·0.1, one-sided 1.645 u = 0.233
        (0.8, 0.1, "undecided"),
        (1.7, 0.2, "undecided"),
        (1.8, 0.2, "fail"), // six values: 2.63 u = 0.743
    ] {
        let directory =
            visit(&table(&[[0.0, 0.0, 0.0], [50.0, um, 0.01], [100.0, 0.0, 0.0]], u_um));
        let (status, document) = judged(directory.path(), "after.csv");
        assert_eq!(document["verdict"], verdict, "{um}, u = {u_um}");
        assert_eq!(status, Some(i32::from(verdict != "pass")));
    }
}

#[test]
fn what_was_not_measured_again_is_named_and_decides_nothing() {
    let directory = visit("axis,position_mm,ex_um\nx,0,0\nx,50,0.1\nx,100,0.1\n");
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(1), &"undecided".into()));
    assert!(document["terms"]["EYX"]["after_um"].is_null());
    assert!(document["causes"].to_string().contains("not measured afterwards"));
    assert!(document["causes"].to_string().contains("EYX"));
}

#[test]
fn a_shorter_range_leaves_it_undecided() {
    let directory = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.1, 0.0]], 0.1));
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["verdict"], "undecided");
    assert!(document["causes"].to_string().contains("less than nine tenths decide nothing"));
}

#[test]
fn tables_that_were_changed_fail_whatever_was_measured() {
    let directory = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [100.0, 0.0, 0.0]], 0.1));
    let file = directory.path().join("kit/compensation.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}\n")).unwrap();
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(1), &"fail".into()));
    assert!(document["causes"].to_string().contains("hash"));
}

#[test]
fn tables_that_do_not_act_are_named_with_the_look_that_decides() {
    let directory = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 6.05, 3.02], [100.0, 16.0, -4.0]], 0.1));
    let (status, page, _) =
        ended(directory.path(), "verify job.toml --tables kit --after after.csv");
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
    ended(directory.path(), "generate job.toml -o kit");
    ended(directory.path(), "separate job.toml -o after.csv");
    let job = fs::read_to_string(directory.path().join("job.toml")).unwrap();
    let after = job.replace(NONE_ACTIVE, KIT_ACTIVE);
    fs::write(directory.path().join("after.toml"), after).unwrap();
    let (_, by_job) = judged(directory.path(), "after.toml");
    let (_, by_table) = judged(directory.path(), "after.csv");
    assert!(by_job["terms"]["EXX"]["after_um"].is_number());
    for part in ["terms", "diagonals", "verdict", "diagnosis"] {
        assert_eq!(by_job[part], by_table[part]);
    }
    let exx = &by_job["terms"]["EXX"];
    assert_eq!(exx["after_um"], exx["before_um"], "the same readings: nothing acts");
}

/// Lengths that were brought to 20 °C are not compared with lengths that were not.
#[test]
fn a_second_job_states_the_material_where_the_first_does() {
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/readings");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::copy(start.join("readings.csv"), path.join("readings.csv")).unwrap();
    let job = fs::read_to_string(start.join("job.toml")).unwrap();
    let material = "[measurement.step_diagonal.material]\nmaterial_corrected = false\nair_corrected = true\nx = { alpha_per_k = 11.5e-6, temperature_c = 22.0 }\n\n";
    let first = job.replace("[compensation]\n", &format!("{material}[compensation]\n"));
    fs::write(path.join("job.toml"), first).unwrap();
    ended(path, "generate job.toml -o kit");
    let (_, _, said) = {
        fs::write(path.join("after.toml"), job.replace(NONE_ACTIVE, KIT_ACTIVE)).unwrap();
        ended(path, "verify job.toml --tables kit --after after.toml")
    };
    assert!(said.contains("does not state [measurement.step_diagonal.material]"), "{said}");
}

/// Rows of an error table in X and Y without uncertainty.
const LEFT: &str = "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,0.2,0.1\nx,100,0.3,0\n";

/// A job of the second measurement.
fn after_job(active: &str, more: &str) -> String {
    let job = JOB.replace("errors.csv", "after.csv").replace(NONE_ACTIVE, active);
    job.replace("[compensation]\n", &format!("{more}[compensation]\n"))
}

fn causes(document: &Value) -> String {
    document["causes"].to_string()
}

#[test]
fn a_second_job_that_does_not_say_what_was_active_is_warned_about() {
    let directory = visit(LEFT);
    let path = directory.path();
    fs::write(path.join("after.toml"), after_job("", "")).unwrap();
    let (_, document) = judged(path, "after.toml");
    assert!(document["notes"].to_string().contains("does not state `active_while_measuring`"));
    fs::write(path.join("after.toml"), after_job(KIT_ACTIVE, "")).unwrap();
    let (status, document) = judged(path, "after.toml");
    assert_eq!(status, Some(0), "{document:#}");
    assert!(!document["notes"].to_string().contains("does not state"));
}

/// A copy of the kit in another folder is the same kit: what it does is compared.
#[test]
fn a_second_job_may_name_the_same_tables_elsewhere() {
    let directory = visit(LEFT);
    let path = directory.path();
    ended(path, "generate job.toml -o archive");
    let archive = after_job("active_while_measuring = \"archive\"", "");
    fs::write(path.join("after.toml"), archive).unwrap();
    let (status, document) = judged(path, "after.toml");
    assert_eq!(status, Some(0), "{document:#}");
}

#[test]
fn the_scale_of_the_laser_is_in_the_uncertainty() {
    let directory = visit(LEFT);
    let path = directory.path();
    let stated = "[measurement.uncertainty]\nnoise_um = 0.1\nlaser_ppm = 5.0\nsetup_ppm = 1.0\n";
    fs::write(path.join("after.toml"), after_job(KIT_ACTIVE, stated)).unwrap();
    let (_, document) = judged(path, "after.toml");
    // 0.1²+ 0.1² + (5 µm/m · 0.1 m)² = 0.27; no laser scale in a straightness.
    assert_eq!(document["terms"]["EXX"]["u_um"], 0.519615);
    assert_eq!(document["terms"]["EYX"]["u_um"], 0.141421);
    let notes = document["notes"].to_string();
    assert!(notes.contains("`setup_ppm`"), "{notes}");
    assert!(!notes.contains("`laser_ppm` of"), "{notes}");
}

#[test]
fn far_fewer_positions_leave_it_undecided() {
    let rows = |step: usize| {
        let at = (0..=100)
            .step_by(step)
            .map(|x| format!("x,{x},{},{}\n", f64::from(x) / 1e3, f64::from(x) / 2e3));
        format!("axis,position_mm,ex_um,ey_um\n{}", at.collect::<String>())
    };
    let directory = visit(LEFT);
    let path = directory.path();
    fs::write(path.join("errors.csv"), rows(10)).unwrap();
    ended(path, "generate job.toml -o kit --force");
    for (step, verdict) in [(20, "pass"), (25, "undecided"), (100, "undecided")] {
        fs::write(path.join("after.csv"), rows(step)).unwrap();
        let (_, document) = judged(path, "after.csv");
        assert_eq!(document["verdict"], verdict, "every {step} mm");
        assert_eq!(causes(&document).contains("known between them"), verdict != "pass");
    }
}

/// Errors in both directions with a lost motion, and what `generate` does with it.
fn both_ways(policy: &str, lost_um: f64) -> tempfile::TempDir {
    let directory = visit(LEFT);
    let path = directory.path();
    fs::write(path.join("errors.csv"), directed(["0", "6", "16"], lost_um)).unwrap();
    let job =
        JOB.replace("[compensation]\n", &format!("[compensation]\nbacklash = \"{policy}\"\n"));
    fs::write(path.join("job.toml"), job).unwrap();
    ended(path, "generate job.toml -o kit --force");
    directory
}

/// Rows of X in both directions; moving - it stands `lost_um` further in +.
fn directed(ex_um: [&str; 3], lost_um: f64) -> String {
    let mut text = "axis,direction,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n".to_string();
    for (way, lost) in [("+", 0.0), ("-", lost_um)] {
        for (at, um) in [0, 50, 100].iter().zip(ex_um) {
            let um: f64 = um.parse().unwrap();
            let ey = f64::from(*at) / 1e4;
            text.push_str(&format!("x,{way},{at},{},{ey},0.05,0.05\n", um + lost));
        }
    }
    text
}

#[test]
fn one_direction_decides_nothing_where_both_were_found() {
    let one_way =
        "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,50,0.1,0\nx,+,100,0.1,0\n";
    for policy in ["two-tables", "curve-and-parameter", "mean"] {
        let directory = both_ways(policy, 3.0);
        fs::write(directory.path().join("after.csv"), one_way).unwrap();
        let (_, document) = judged(directory.path(), "after.csv");
        assert_eq!(document["verdict"], "undecided", "{policy}: {document:#}");
        assert!(causes(&document).contains("reversal that is left: EXX"), "{policy}");
    }
}

/// The reversal that a policy leaves is forecast: it is no noise, and hides nothing.
#[test]
fn a_reversal_left_on_purpose_hides_no_inactive_tables() {
    let (without_u, lost_um) = (|text: String| text.replace(",0.05,0.05", ",,"), 14.0);
    let directory = both_ways("mean", lost_um);
    let path = directory.path();
    let errors = fs::read_to_string(path.join("errors.csv")).unwrap();
    fs::write(path.join("errors.csv"), without_u(errors)).unwrap();
    ended(path, "generate job.toml -o kit --force");
    let as_found = without_u(directed(["0", "6.1", "15.9"], lost_um));
    fs::write(path.join("after.csv"), as_found).unwrap();
    let (_, document) = judged(path, "after.csv");
    assert_eq!(document["diagnosis"]["as_forecast"], false, "{document:#}");
    assert!(causes(&document).contains("NOT ACTIVE"), "{document:#}");
}

#[test]
fn noise_as_large_as_the_errors_hides_whether_the_tables_act() {
    let rows = [[0.0, 0.0, 0.0], [50.0, 5.0, 3.0], [100.0, 9.0, -4.0]];
    let directory = visit(&table(&rows, 20.0));
    let errors = table(&[[0.0, 0.0, 0.0], [50.0, 6.0, 3.0], [100.0, 16.0, -4.0]], 20.0);
    fs::write(directory.path().join("errors.csv"), errors).unwrap();
    ended(directory.path(), "generate job.toml -o kit --force");
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["diagnosis"]["hides_tables"], true, "{document:#}");
    assert!(causes(&document).contains("whether the tables act does not show"));
}

#[test]
fn lost_motion_that_the_first_measurement_could_not_see_is_named() {
    let directory = visit(&directed(["0", "0.05", "0"], 5.0));
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["verdict"], "fail");
    assert!(causes(&document).contains("LOST MOTION, no fault of the tables"), "{document:#}");
    assert!(causes(&document).contains("EXX -5.000"), "{document:#}");
    assert!(!causes(&document).contains("unknown"), "{document:#}");
}

#[test]
fn without_limits_a_turned_sign_is_undecided() {
    let directory = visit("axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,12,6\nx,100,32,-8\n");
    let (job, _) = JOB.split_once("[acceptance]").unwrap();
    fs::write(directory.path().join("job.toml"), job).unwrap();
    let (status, document) = judged(directory.path(), "after.csv");
    assert_eq!((status, &document["verdict"]), (Some(1), &"undecided".into()));
    assert!(causes(&document).contains("SIGN TURNED"), "{document:#}");
}

#[test]
fn what_is_off_the_forecast_is_named_though_it_passes() {
    let directory = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.6, 0.01], [100.0, 0.0, 0.0]], 0.05));
    let errors = table(&[[0.0, 0.0, 0.0], [50.0, 6.0, 3.0], [100.0, 16.0, -4.0]], 0.05);
    fs::write(directory.path().join("errors.csv"), errors).unwrap();
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["verdict"], "pass");
    let notes = document["notes"].to_string();
    assert!(
        notes.contains(
            "both measurements explain (99.9 %, all positions together): EXX 0.600 µm (U = 0.376 µm)"
        ),
        "{notes}"
    );
    assert!(!notes.contains("EYX"), "{notes}");
}

#[test]
fn a_limit_missed_without_a_stated_uncertainty_says_so() {
    let directory = visit("axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,2,0\nx,100,0,0\n");
    let (_, document) = judged(directory.path(), "after.csv");
    assert!(causes(&document).contains("EXX leaves 2.000 µm (U not stated)"), "{document:#}");
}

/// Slopes of cross terms that were separated hold another rotation than those of a given table.
#[test]
fn another_frame_leaves_it_undecided() {
    let directory = visit(&format!("# frame: x-primary\n{LEFT}"));
    let (_, document) = judged(directory.path(), "after.csv");
    assert_eq!(document["verdict"], "undecided");
    assert!(
        causes(&document).contains("as found: as given; afterwards: x-primary"),
        "{document:#}"
    );
}

/// The kit names a parameter in its manifest; the job asks for another one.
#[test]
fn the_backlash_parameter_of_a_kit_is_the_one_of_its_manifest() {
    let directory = both_ways("curve-and-parameter", 3.0);
    let path = directory.path();
    let (status, said, _) = ended(path, "verify job.toml --tables kit");
    assert_eq!(status, Some(0), "{said}");
    fs::write(path.join("errors.csv"), directed(["0", "6", "16"], 5.0)).unwrap();
    let (status, said, _) = ended(path, "verify job.toml --tables kit --format json");
    let document: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((status, &document["verdict"]), (Some(1), &"fail".into()));
    assert!(
        causes(&document).contains("the kit was made for 3 µm, the job asks for 5 µm"),
        "{document:#}"
    );
    assert_eq!(document["terms"]["EXX"]["forecast_um"], 2.0);
    let (_, said, _) = ended(path, "simulate job.toml --tables kit --errors -o -");
    assert!(said.contains("x,-,100,2,"), "{said}");
    assert!(said.contains("3.000 µm as manifest.json of the kit names it"), "{said}");
}

/// Files under names of the control's own, with data of no concern among them.
#[test]
fn a_read_out_is_judged_by_what_it_does() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    fs::copy(from.join("siemens-840d-sl.toml"), path.join("job.toml")).unwrap();
    fs::copy(from.join("errors.csv"), path.join("errors.csv")).unwrap();
    ended(path, "generate job.toml -o kit");
    let tables = |name: &str| {
        let text = fs::read_to_string(path.join("kit").join(name)).unwrap();
        let lines = text.lines().filter(|line| line.starts_with('$'));
        lines.map(|line| format!("{line}\n")).collect::<String>()
    };
    let archive = [
        tables("NONIUS_EEC.MPF"),
        "$MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\n$MA_BACKLASH[0,AX1]=0.006\n".to_string(),
        tables("NONIUS_CEC.MPF"),
        "M30\n".to_string(),
    ]
    .concat();
    fs::create_dir(path.join("out")).unwrap();
    fs::write(path.join("out/all.arc"), &archive).unwrap();
    let (status, said, trouble) = ended(path, "verify job.toml --tables out");
    assert_eq!(status, Some(0), "{said}{trouble}");
    assert!(said.contains("1 other machine data were ignored"), "{said}");
    assert!(said.contains("taken to be on"), "{said}");
    assert!(said.contains("MD32450) of axis AX1 is 6 µm"), "{said}");
    let backlash = archive.replace("M30", "$AA_ENC_COMP[0,3,AX1]=0.5\nM30");
    fs::write(path.join("out/all.arc"), backlash).unwrap();
    let (status, said, _) = ended(path, "verify job.toml --tables out");
    assert_ne!(status, Some(0), "{said}");
}
