//! `nonius separate` and `generate` from readings: the golden cases, the words with a result, what is refused.
use crate::support::*;
use nonius::inputs::error_table::{Cause, Remarks};
use serde_json::{Value, json};

const NOISE: &str = "[measurement.uncertainty]\nnoise_um = 0.1\nlaser_ppm = 0\nbeam_mrad = 0\n";

fn case_with(name: &str, lines: &str) -> Visit {
    let visit = golden_case(name);
    visit.edit("job.toml", "[compensation]", &format!("{lines}\n[compensation]"));
    visit
}

/// Case B with the first `count` of its three linear axes.
fn with_linear_axes(count: usize) -> Visit {
    let visit = golden_case("case_b_setup");
    let job = visit.read("job.toml");
    let (head, rest) = job.split_once("[compensation]").unwrap();
    let kept: Vec<&str> = head.split("[[").take(1 + count).collect();
    visit.put("job.toml", format!("{}[compensation]{rest}", kept.join("[[")));
    visit
}

/// The document; status 1: an error is not determined, or something speaks against the result.
#[track_caller]
fn separated(visit: &Visit, status: i32) -> Value {
    visit.run("separate job.toml --trials 0 --format json").ends(status).json()
}

#[track_caller]
pub(crate) fn near(found: &Value, wanted: f64, tolerance: f64) {
    assert!((number(found) - wanted).abs() < tolerance, "{found}, expected {wanted}");
}

#[test]
fn the_separated_table_and_the_job_with_readings_make_the_same_control_files() {
    let visit = golden_case("case_b_setup");
    visit.run("generate job.toml -o one").answers();
    visit.yes("separate job.toml -o errors.csv");
    visit.put("nine.toml", without(&visit.read("job.toml"), "[measurement.step_diagonal]"));
    visit.edit("nine.toml", "readings = \"readings.csv\"", "errors = \"errors.csv\"");
    visit.run("generate nine.toml -o two").answers();
    for name in ["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"] {
        assert_eq!(
            visit.read(&format!("one/{name}")),
            visit.read(&format!("two/{name}")),
            "{name}"
        );
    }
    let manifest = visit.read("two/manifest.json");
    assert_eq!(manifest.matches("readings.csv").count(), 1, "the source is traced: {manifest}");
    visit.run("verify job.toml --tables one").says("job and tables agree");
}

#[test]
fn without_linear_axes_the_scales_are_named_and_left_out() {
    for (axes, rank, scales, measure) in [
        (0, 4, "X, Y and Z", "two axes along their length"),
        (1, 5, "Y and Z", "one axis along its length"),
    ] {
        let page = separated(&with_linear_axes(axes), 1);
        assert_eq!(page["rank"]["rank"], rank);
        let traded = format!("scale of {scales} can be traded against each other");
        assert_eq!(page["rank"]["undetermined"][0], format!("{traded}; measure {measure}"));
        assert_eq!(page["errors"].get("EXX").is_some(), axes > 0);
    }
    let visit = with_linear_axes(0);
    let page = separated(&visit, 1);
    assert_eq!(page["rank"]["unknowns"], 6);
    assert!(page["errors"].get("EYX").is_some(), "determined whatever the set-up");
    assert!(page.get("setup_arcsec").is_none());
    // What is not known of the scales (some 20 um/m) times the tilts (0.5 mrad) stays in it.
    near(&page["squareness_um_per_m"]["xy"], 19.1667, 0.05);
    let ran = visit.run("separate job.toml -v").ends(1).omits("-0.000");
    ran.says("NOT DETERMINED by these readings").says("U(95 %)");
}

/// The same seed gives the same bytes.
#[test]
fn the_figures_of_case_d_are_those_of_the_reference() {
    let visit = golden_case("case_d_bidirectional");
    let trials = |seed| visit.yes(&format!("separate job.toml --format json --trials 300 {seed}"));
    let one = trials("");
    assert_eq!(one, trials(""));
    assert_ne!(one, trials("--seed 2"));
    let page = separated(&visit, 0);
    near(&page["diagonals"]["e_d_um"], 28.9797, 1e-6);
    near(&page["diagonals"]["b_d_um"], 9.146_333, 1e-6);
    assert_eq!(page["diagonals"]["label"], "from step-diagonal cell ends, not ISO 230-6");
    assert!(page["errors"].get("EXX+").is_some() && page["errors"].get("EXX-").is_some());
}

/// The straight diagonals of case A, from its cell ends, with more keys of their section and below, and more rows.
pub(crate) fn straight(keys: &str, rows: &str) -> Visit {
    let visit = golden_case("case_a_ideal");
    let kind = format!("kind = \"straight\"\nclosure_errors = \"truth.csv\"\n{keys}");
    visit.edit("job.toml", "order = \"XYZ\"\nsetup = \"assume-perfect\"", &kind);
    let mut text = "diagonal,run,direction,node,deviation_um\n".to_string();
    for (diagonal, values) in cell_ends() {
        for (node, value) in values.iter().enumerate() {
            text += &format!("{diagonal},1,forward,{node},{value}\n");
        }
    }
    visit.put("readings.csv", text + rows);
    visit
}

fn cell_ends() -> [(&'static str, Vec<f64>); 4] {
    let readings = fixture("diagonals/case_a_ideal/readings.csv");
    let rows: Vec<Vec<&str>> = readings.lines().map(|line| line.split(',').collect()).collect();
    DIAGONALS.map(|name| {
        let own = rows.iter().filter(|row| row[0] == name && row[2] == "forward");
        let ends = own.filter(|row| row[3].parse::<usize>().unwrap().is_multiple_of(3));
        (name, ends.map(|row| row[5].parse().unwrap()).collect())
    })
}

/// Runs back, 5 µm lower: in rows `reverse`, or named as ways back, numbered, signed and zeroed along their own travel.
pub(crate) fn runs_back(own_names: bool) -> String {
    let mut text = String::new();
    for ((diagonal, values), name) in cell_ends().iter().zip(["NNN", "PNN", "NPN", "NNP"]) {
        let last = values.len() - 1;
        for (node, value) in values.iter().enumerate() {
            text += &match own_names {
                true => format!("{name},1,forward,{node},{}\n", values[last] - values[last - node]),
                false => format!("{diagonal},1,reverse,{node},{}\n", value - 5.0),
            };
        }
    }
    text
}

#[test]
fn straight_runs_with_a_zero_of_their_own_give_no_reversal() {
    let known = separated(&straight("", &runs_back(false)), 0);
    let visit = straight("", &runs_back(true));
    let own = separated(&visit, 0);
    let [of_known, of_own] = [&known, &own].map(|page| &page["diagonals"]);
    near(&of_known["b_d_um"], 5.0, 1e-6);
    near(&of_known["PPP"]["range_um"], 23.543_453, 1e-6);
    assert_eq!([&of_own["e_d_um"], &of_own["b_d_um"]], [&Value::Null; 2]);
    near(&of_own["PPP"]["range_um"], 18.543_453, 1e-6);
    for plane in ["xy", "xz", "yz"] {
        let wanted = number(&known["squareness_um_per_m"][plane]);
        near(&own["squareness_um_per_m"][plane], wanted, 1e-6);
    }
    labelled(&own, &["their own start"]);
    visit.run("separate job.toml --trials 0 -v").ends(0).says("no E and B");
    // The page of the standards leaves these runs out, with a job and without one.
    for input in ["job.toml", "readings.csv"] {
        visit.run(&format!("standards {input}")).ends(0).says("18.543").omits("37.087");
    }
}

#[test]
fn straight_runs_with_two_linear_axes_know_all_scales_with_their_uncertainty() {
    let linear = |axis: &str, slope: f64| {
        let section = "[[measurement.step_diagonal.linear]]";
        format!("{section}\naxis = \"{axis}\"\nslope_um_per_m = {slope:?}\nu_um_per_m = 0.5\n")
    };
    let keys = [&linear("x", 20.0), &linear("y", -16.666666667), NOISE].concat();
    let page = separated(&straight(&keys, ""), 0);
    assert_eq!((&page["rank"]["rank"], &page["rank"]["undetermined"]), (&json!(6), &json!([])));
    near(&page["scale_um_per_m"]["z"], 13.888_889, 1e-5);
    // h_zz = (S - X² h_xx - Y² h_yy)/Z², u(S)/R² = u_end/(2R): by hand, in µm/m.
    let (r2, ends) = (1_846_800.0_f64, 2.0_f64.sqrt() * 0.1);
    let of_total = r2 * (ends / (2.0 * r2.sqrt() / 1000.0));
    let (of_x, of_y) = (810_000.0_f64 * 0.5, 518_400.0_f64 * 0.5);
    let wanted = of_total.hypot(of_x).hypot(of_y) / 518_400.0;
    near(&page["u_scale_um_per_m"]["z"], wanted, 1e-6);
    // R/(2XY)·u(e_end), e_end of one run: √2·0.1 µm.
    let wanted = 1_358.969 / (2.0 * 0.648e6) * 1000.0 * ends;
    near(&page["u_squareness_um_per_m"]["xy"], wanted, 1e-4);
    labelled(&page, &["laser_ppm as stated", "the middle of the box"]);
}

/// Run 2 reads 1 µm more and less in turn, with the signs that cancel in the closure.
#[test]
fn the_closure_is_tested_against_the_scatter_of_the_runs() {
    let visit = golden_case("case_d_bidirectional");
    let means = "X -0.017 (expected scatter 0.071), Y -0.083 (expected";
    visit.run("separate job.toml --trials 0 -v").says(means).says("in keeping with that noise");
    let disturbed = with_cells(&visit.read("readings.csv"), |cells| {
        if cells.len() > 5 && cells[1] == "2" && cells[3] != "0" {
            let turns = (cells[0] == "PPN") != (cells[3].parse::<u32>().unwrap() % 2 == 0);
            let um = cells[5].parse::<f64>().unwrap() + if turns { -1.0 } else { 1.0 };
            cells[5] = um.to_string();
        }
        true
    });
    visit.put("readings.csv", disturbed);
    visit.run("separate job.toml --trials 0 -v").says("SMALLER than that noise: single runs");
}

#[test]
fn an_assumed_set_up_has_an_uncertainty_only_with_a_stated_tilt() {
    let stated = |lines| separated(&case_with("case_d_bidirectional", lines), 0);
    let page = stated("");
    assert!(page["errors"]["EXX"].get("u_um").is_none(), "{}", page["errors"]["EXX"]);
    labelled(&page, &["state `tilt_arcsec`"]);
    let page = stated("[measurement.uncertainty]\ntilt_arcsec = 10.0\n");
    // R/(2V)·√(1 − (V/R)²)·48.48 µrad = 27.4 µm/m over 0.9 m; noise adds 0.3 µm.
    near(&page["errors"]["EXX"]["u_um"][10], 24.69, 0.05);
}

/// A mirror tilted by 50 µrad in X and Y of every set-up on a perfect machine: totals 0, the closure clean.
#[test]
fn a_hidden_set_up_error_is_said_in_words() {
    let mut rows = "diagonal,run,direction,node,moved,deviation_um\n".to_string();
    for diagonal in DIAGONALS {
        rows += &format!("{diagonal},1,forward,0,,0\n");
        for node in 1..=90 {
            let (axis, um) = [("z", 0.0), ("x", 1.2), ("y", 0.0)][node % 3];
            rows += &format!("{diagonal},1,forward,{node},{axis},{um}\n");
        }
    }
    let visit = golden_case("case_a_ideal");
    visit.put("readings.csv", rows);
    let separate = "separate job.toml --trials 0 -v";
    let words =
        ["WARNING: `setup = \"assume-perfect\"`", "54.359", "-67.949", "proves nothing about"];
    visit.run(separate).ends(0).tells(&words);
    visit.edit("job.toml", "setup = \"assume-perfect\"", "");
    visit.run(separate).ends(1).omits("54.359").tells(&[
        "Determined: 6 of 9 errors",
        "NOT DETERMINED by these readings, and left out:\n  - scale of X, Y and Z can be traded against each other; measure two axes along their length",
        "add two [[measurement.step_diagonal.linear]]",
        "face diagonals of two planes",
    ]);
}

#[test]
fn straight_runs_give_squareness_one_combination_and_a_verdict_of_the_closure_test() {
    let visit = straight("", "");
    let page = separated(&visit, 0);
    for (plane, wanted) in [("xy", 19.166_667), ("xz", -13.055_556), ("yz", 12.5)] {
        near(&page["squareness_um_per_m"][plane], wanted, 2e-6);
    }
    near(&page["diagonals"]["scale_sum_um_mm"], 14760.0, 1e-3);
    for diagonal in DIAGONALS {
        let closure = &page["diagonals"][diagonal]["closure_largest_um"];
        // Both files carry nine decimals.
        assert!(number(closure) <= 1e-6, "{diagonal}: {closure}");
    }
    visit.run("separate job.toml --trials 0 -v").ends(0).says("Closure test").says("no verdict");
    let none = "straight runs hold no nine errors";
    visit.run("separate job.toml -o errors.csv").ends(2).says(none);
    let none = "straight runs of the diagonals hold no nine errors";
    visit.run("generate job.toml -o kit").ends(2).says(none);
    let visit = straight(NOISE, "");
    assert_eq!(separated(&visit, 0)["closure_test"]["agrees"], true);
    visit.edit("readings.csv", "NPP,1,forward,17,", "NPP,1,forward,17,1");
    assert_eq!(separated(&visit, 0)["closure_test"]["agrees"], false);
    visit.edit("job.toml", "noise_um", "angle_urad = 0\nsetup_ppm = 0\nnoise_um");
    let with_u = visit.read("truth.csv").replace('\n', ",0,0,0\n");
    visit.put("truth.csv", with_u.replace("ez_um,0,0,0", "ez_um,u_ex_um,u_ey_um,u_ez_um"));
    visit.run("separate job.toml --trials 0 -v").ends(1).says("NOT in keeping");
}

/// 5 µm at 900 mm are 5.6 µm/m.
#[test]
fn the_uncertainty_of_a_linear_table_is_that_of_its_column() {
    let visit = with_linear_axes(2);
    visit.edit("job.toml", "slope_um_per_m = 20.000000000", "errors = \"x.csv\"");
    visit.edit("job.toml", "-16.666666667", "-16.666666667\nu_um_per_m = 0.1");
    visit.put("x.csv", "axis,position_mm,ex_um,u_ex_um\nx,0,0,0\nx,450,9,2.5\nx,900,18,5\n");
    let page = separated(&visit, 0);
    near(&page["errors"]["EXX"]["u_um"][30], 5.0, 1e-3);
    lacks(&page["labels"].to_string(), &["states no uncertainty"]);
    visit.put("x.csv", "axis,position_mm,ex_um\nx,0,0\nx,450,9\nx,900,18\n");
    let page = visit.run("separate job.toml --trials 100 --format json").ends(0).json();
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    labelled(&page, &["states no uncertainty"]);
    let figures = page["monte_carlo"]["figures"].to_string();
    assert!(!figures.contains("range EXX") && figures.contains("range EYY"), "{figures}");
}

#[track_caller]
fn disagrees(replacements: &[(&str, &str)]) {
    let visit = case_with("case_b_setup", &NOISE.replace("noise_um = 0.1\n", ""));
    for (old, new) in replacements {
        visit.edit("job.toml", old, new);
    }
    visit.run("separate job.toml --trials 0 -v").ends(1).says("they DISAGREE");
    let page = separated(&visit, 1);
    let redundancy = &page["redundancy"];
    assert!(number(&redundancy["probability"]) < 0.001, "{redundancy}");
    let words = redundancy["contradiction"].as_str().unwrap();
    assert!(words.contains("laser_sign") && words.contains("size of the box"));
    labelled(&page, &[words]);
    let ran = visit.run("generate job.toml -o kit").ends(1).omits("verdict: pass");
    ran.says("note: linear axes and diagonals DISAGREE");
    let page = visit.run("verify job.toml --tables kit --format json").ends(1).json();
    assert_ne!(page["verdict"], "pass");
    assert!(page["notes"].to_string().contains("DISAGREE"));
}

const SLOPE_OF_Z: &str = "slope_um_per_m = 13.888888889";

#[test]
fn what_contradicts_the_diagonals_is_told_and_nothing_passes() {
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = 113.9")]);
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = -13.9\nu_um_per_m = 0.5")]);
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = 113.9\nu_um_per_m = 0.5")]);
    disagrees(&[
        ("= 20.000000000", "= 20.000000000\nu_um_per_m = 0.5"),
        ("= -16.666666667", "= -16.666666667\nu_um_per_m = 0.5"),
        (SLOPE_OF_Z, "slope_um_per_m = -13.9\nu_um_per_m = 0.5"),
    ]);
    // A wrong sign of the laser or size of the box.
    disagrees(&[("steps = 30", "steps = 30\nlaser_sign = \"-\"")]);
    disagrees(&[("y = 720.0000, z = 720.0000 }", "y = 720.0000, z = 620.0000 }")]);
    let visit = golden_case("case_b_setup");
    let redundancy = &separated(&visit, 0)["redundancy"];
    assert!(number(&redundancy["probability"]) > 0.05, "{redundancy}");
    assert!(redundancy["contradiction"].is_null());
    assert_eq!(redundancy["degrees_of_freedom"], 1);
    visit.run("separate job.toml --trials 0 -v").ends(0).says("they agree");
}

/// A, B and C in µrad · t · (1 − 0.3 k) for axis k = 0, 1, 2: the angles of case C2.
const ALL: [(&str, f64); 3] = [("ea_urad", 5.0), ("eb_urad", -8.0), ("ec_urad", 12.0)];

/// Case C2 with a table of some of its angles and more keys in [measurement].
fn with_angles(columns: &[(&str, f64)], keys: &str) -> Visit {
    let visit = golden_case("case_c2_mirror");
    let readings = "readings = \"readings.csv\"";
    let angles = format!("{readings}\nangles = \"angles.csv\"\n{keys}");
    visit.edit("job.toml", readings, &angles);
    let names: Vec<&str> = columns.iter().map(|column| column.0).collect();
    let mut text = format!("axis,position_mm,{}\n", names.join(","));
    for (axis, length, share) in [("x", 900.0, 1.0), ("y", 720.0, 0.7), ("z", 720.0, 0.4)] {
        for t in [0.0, 0.5, 1.0] {
            let cell = |column: &(&str, f64)| format!(",{}", column.1 * t * share);
            let cells: String = columns.iter().map(cell).collect();
            text += &format!("{axis},{}{cells}\n", length * t);
        }
    }
    visit.put("angles.csv", text);
    visit
}

#[test]
fn angles_of_a_job_are_taken_off_the_readings() {
    let zero = "{ x = 0.0, y = 0.0, z = 0.0 }";
    let visit = with_angles(&ALL, &format!("offsets_mm = {zero}\ntool_offset_mm = {zero}"));
    let page = separated(&visit, 0);
    let truth = visit.read("truth.csv");
    let mut compared = 0;
    for (axis, name) in [("x,", "X"), ("y,", "Y"), ("z,", "Z")] {
        for (index, row) in truth.lines().filter(|line| line.starts_with(axis)).enumerate() {
            let cells = row.split(',').skip(2).map_while(|cell| cell.parse().ok());
            for (of, wanted) in ["X", "Y", "Z"].iter().zip(cells) {
                near(&page["errors"][format!("E{of}{name}")]["deviation_um"][index], wanted, 6e-4);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 9 * 31, "the truth has nine curves of 31 points");
    lacks(&page["labels"].to_string(), &["without a measurement"]);
    labelled(&page, &["those of the lines through X 0, Y 0, Z 0 mm"]);
    lacks(&page["labels"].to_string(), &["tool_offset_mm is not stated"]);
    let without = separated(&with_angles(&ALL, ""), 0);
    labelled(&without, &["those of the lines through X 450, Y 360, Z 360 mm", "up to 1.200 µm"]); // 12 µrad on 100 mm
    labelled(&without, &["tool_offset_mm is not stated"]);
}

#[test]
fn the_uncertainty_of_measured_angles_counts() {
    let u = [("u_ea_urad", 5.0), ("u_eb_urad", 8.0), ("u_ec_urad", 12.0)];
    let u_um = |columns: &[(&str, f64)]| {
        let visit = with_angles(columns, "");
        let tilt = "[measurement.uncertainty]\ntilt_arcsec = 0\n\n[measurement.step_diagonal]";
        visit.edit("job.toml", "[measurement.step_diagonal]", tilt);
        let page = separated(&visit, 0);
        let silent = if columns.len() > 3 { "counts as 0" } else { "U is not known" };
        lacks(&page["labels"].to_string(), &[silent]);
        page["errors"]["EYX"]["u_um"][15].as_f64().unwrap()
    };
    let (without, with) = (u_um(&ALL), u_um(&[&ALL[..], &u].concat()));
    // The bow of 12/√2 µrad alone bends Y along X by V/8 of it, 0.95 µm, and as much by the mirror.
    assert!(without < 1.0 && with > 1.5, "{without}, {with}");
}

/// Two angles or one of the three: the others contradict the result.
#[test]
fn angles_that_are_missing_are_named_with_what_they_do() {
    let page = separated(&with_angles(&ALL[..2], ""), 1);
    labelled(&page, &["counted as zero: ECX, ECY, ECZ", "state `angle_urad`"]);
    let page = separated(&with_angles(&ALL[2..], ""), 1);
    labelled(&page, &["counted as zero: EAX, EBX, EAY, EBY, EAZ, EBZ"]);
    let page = separated(&golden_case("case_b_setup"), 0);
    labelled(&page, &["EAX, EBX, ECX, EAY, EBY, ECY, EAZ, EBZ, ECZ"]);
}

#[test]
fn a_stated_bound_of_the_angles_widens_curves_and_squareness() {
    let stated = |key: &str| {
        let lines = format!("[measurement.uncertainty]\nnoise_um = 0.001\n{key}\n");
        separated(&case_with("case_b_setup", &lines), 0)
    };
    let u = |page: &Value, index: usize| number(&page["errors"]["EYX"]["u_um"][index]);
    let (without, with) = (stated(""), stated("angle_urad = 10.0"));
    assert!(u(&without, 15) < 0.01);
    // A yaw that grows evenly by 10 µrad makes a bow of 2.25 µm: U = 2u holds it.
    assert!((2.25 / 2.0..10.0).contains(&u(&with, 15)), "{}", u(&with, 15));
    assert!(u(&with, 30) < 0.01, "the frame sets the end: {}", u(&with, 30));
    // A bow of the yaw moves the squareness by as much, whatever the totals say; half of the bound is meant.
    let squareness = |page: &Value| number(&page["u_squareness_um_per_m"]["xy"]);
    assert!(squareness(&without) < 1.0);
    assert!(2.0 * squareness(&with) > 5.0, "{}", squareness(&with));
    let words = "included in U: a straight part and a bow about the middle of the box, each within half of 10";
    labelled(&with, &[words]);
}

#[test]
fn what_is_not_stated_stands_in_the_table_and_leaves_the_verdict_undecided() {
    let made = |keys: &str| {
        let visit = case_with("case_b_setup", &format!("{NOISE}{keys}\n"));
        (visit.run("separate job.toml --trials 0 -o e.csv"), Remarks::read(&visit.read("e.csv")))
    };
    let (ran, remarks) = made("");
    ran.says("not stated: angle_urad, setup_ppm, u_um_per_m;");
    assert_eq!(remarks.silence.not_stated, [Cause::Angles, Cause::SetUps, Cause::Slopes]);
    let (ran, remarks) = made("angle_urad = 5\nsetup_ppm = 0");
    ran.says("not stated: u_um_per_m;").says("neglected by decision: setup_ppm");
    assert_eq!(remarks.silence.neglected, [Cause::SetUps]);
}
