//! Angles: taken off the readings, named where they are missing, held by U where a bound is stated.

use super::*;
use crate::support::tree::skipped;
use crate::support::visit::fixtures;
use nonius::inputs::error_table::Remarks;
use nonius::quantity::axis::ErrorTerm;

/// A, B and C in µrad · t · (1 − 0.3 k) for axis k = 0, 1, 2: the angles of case C2.
const ALL: [(&str, f64); 3] = [("ea_urad", 5.0), ("eb_urad", -8.0), ("ec_urad", 12.0)];

/// Case C2 with a table of some of its angles and more keys in [measurement].
fn with_angles(columns: &[(&str, f64)], keys: &str) -> Visit {
    let visit = case("case_c2_mirror");
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
        let rows = truth.lines().filter(|line| line.starts_with(axis));
        for (index, row) in rows.enumerate() {
            let cells = row.split(',').skip(2).map_while(|cell| cell.parse().ok());
            for (of, wanted) in ["X", "Y", "Z"].iter().zip(cells) {
                near(&page["errors"][format!("E{of}{name}")]["deviation_um"][index], wanted, 6e-4);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 9 * 31, "the truth has nine curves of 31 points");
    not_labelled(&page, "without a measurement");
    not_labelled(&page, "offsets_mm is not stated");
    not_labelled(&page, "tool_offset_mm is not stated");
    let without = separated(&with_angles(&ALL, ""), 0);
    labelled(&without, "offsets_mm is not stated");
    labelled(&without, "up to 1.200 µm"); // 12 µrad on 100 mm
    labelled(&without, "tool_offset_mm is not stated");
}

/// Two angles or one of the three: what is left of them contradicts the result.
#[test]
fn angles_that_are_missing_are_named_with_what_they_do() {
    let page = separated(&with_angles(&ALL[..2], ""), 1);
    labelled(&page, "counted as zero: ECX, ECY, ECZ");
    labelled(&page, "state `angle_urad`");
    let page = separated(&with_angles(&ALL[2..], ""), 1);
    labelled(&page, "counted as zero: EAX, EBX, EAY, EBY, EAZ, EBZ");
    let page = separated(&case("case_b_setup"), 0);
    labelled(&page, "EAX, EBX, ECX, EAY, EBY, ECY, EAZ, EBZ, ECZ");
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
    // A bow of the yaw moves the squareness by as much, whatever the totals say.
    let squareness = |page: &Value| number(&page["u_squareness_um_per_m"]["xy"]);
    assert!(squareness(&without) < 1.0);
    assert!(2.0 * squareness(&with) > 10.0, "{}", squareness(&with));
    labelled(&with, "included in U: each within 10 µrad of its value at the low end");
}

/// A yaw bowed by 10 µrad with 10 stated: the squareness is off by 10 µm/m, and U says so.
#[test]
fn a_bowed_yaw_within_the_stated_bound_is_held() {
    let case = "../../shared/data/repro/yaw_bow";
    if !fixtures(case).is_dir() {
        return skipped("../shared is not here");
    }
    let page = separated(&Visit::of(case), 0);
    // Estimate less truth of its truth.txt: -13.947 + 24.046, 10.041 - 9.801, -14.765 + 14.708.
    for (plane, truth) in [("xy", -24.046), ("xz", 9.801), ("yz", -14.708)] {
        let of = |key: &str| number(&page[key][plane]);
        let error = of("squareness_um_per_m") - truth;
        assert!(error.abs() < 2.0 * of("u_squareness_um_per_m"), "{plane}: {error}");
    }
}

/// What is not counted goes from the readings through the error table into whatever is made of it.
#[test]
fn what_is_not_counted_is_said_and_stands_in_the_table_until_it_is_stated() {
    let made = |keys: &str| {
        let visit = case_with("case_b_setup", &format!("{NOISE}{keys}\n"));
        let ran = visit.run("separate job.toml --trials 0 -o e.csv");
        (ran, Remarks::read(&visit.read("e.csv")))
    };
    let (ran, remarks) = made("");
    ran.says("angles not counted; U holds below 0.")
        .says("beam against mirror normal not counted; U holds below 0.");
    let exy = ErrorTerm::from_name("EXY").unwrap();
    assert!(remarks.angles_not_counted.unwrap()[exy] > 0.5);
    assert!(remarks.beam_not_counted.unwrap()[exy] > 0.1);
    let (ran, remarks) = made("angle_urad = 5\nbeam_mrad = 0.5");
    ran.omits("not counted");
    assert_eq!((remarks.angles_not_counted, remarks.beam_not_counted), (None, None));
}
