//! What `nonius standards` takes beside tables of runs: readings of diagonals, jobs that name them, `.rtl` files.
use crate::separate::{near, runs_back, straight};
use crate::support::{Ran, Visit, fixtures, holds, number};
use serde_json::{Value, json};

fn standards(file: &str, options: &str) -> Ran {
    Visit::new().run(&format!("standards \"{}\" {options}", fixtures(file).display()))
}

#[track_caller]
fn document(file: &str, options: &str) -> Value {
    standards(file, &format!("{options} --format json")).ends(0).json()
}

/// Golden figures of case D: the simulation is exact to rounding of the readings (1e-9 µm).
fn golden(part: &Value) {
    assert_eq!(part["label"], "from step-diagonal cell ends, not ISO 230-6");
    let expected = Visit::of("diagonals/case_d_bidirectional").document("expected.json");
    let expected = expected["iso230_6"].as_object().unwrap();
    assert_eq!(expected.len(), 34);
    for (key, um) in expected {
        let figure = |of: &str| format!("{}_um", of.replace("dn", "down"));
        let found = match key.as_str() {
            "E_d" | "B_d" => &part[figure(key)],
            key => {
                let (of, diagonal) = key.rsplit_once('_').unwrap();
                &part["diagonals"][diagonal][figure(of)]
            }
        };
        near(found, number(um), 6e-7); // a document has six decimals
    }
}

/// No figure depends on the box; what does is named as not tested where readings stand alone.
#[test]
fn a_job_with_readings_and_readings_alone_give_the_figures_of_the_diagonals() {
    let part = &document("diagonals/case_d_bidirectional/job.toml", "")["iso_230_6"];
    golden(part);
    let targets = &part["conditions"]["list"][2];
    assert_eq!(targets["outcome"], "met");
    assert_eq!(targets["found"], "11 targets on 1358.97 mm");
    let readings = "diagonals/case_d_bidirectional/readings.csv";
    let part = &document(readings, "")["iso_230_6"];
    golden(part);
    assert_eq!(part["conditions"]["list"][2]["outcome"], "not tested");
    standards(readings, "").says("E up  E down").says("no job: the readings are taken").says("E_d");
}

#[test]
fn one_direction_has_no_figures_of_the_machine() {
    let part = &document("diagonals/case_a_ideal/readings.csv", "")["iso_230_6"];
    assert_eq!(part["E_d_um"], Value::Null);
    near(&part["largest_range_um"], 21.457424184, 1e-6);
    near(&part["range_over_all_um"], 30.825471466, 1e-6);
    for (name, um) in
        [("PPP", 18.543452999), ("NPP", 12.715510628), ("PNP", 13.843169661), ("PPN", 21.457424184)]
    {
        near(&part["diagonals"][name]["range_um"], um, 1e-6);
    }
    assert_eq!(part["B_d_um"], Value::Null);
    assert_eq!(part["diagonals"]["PPN"]["E_um"], Value::Null);
}

/// The offset of such a run to the forward run is not known, so it has no part in E and B.
#[test]
fn runs_under_the_name_of_a_reverse_run_are_left_out_and_named() {
    let [forward, both] = [String::new(), runs_back(true)]
        .map(|rows| straight("", &rows).json("standards readings.csv")["iso_230_6"].clone());
    assert_eq!(forward["diagonals"], both["diagonals"]);
    holds(&both["notes"].to_string(), &["NNN …"]);
}

/// Figures of an `.rtl` file that notes a temperature of the material.
fn of_rtl(sign: &str, way: &str) -> Value {
    let stated = format!("--sign {sign} --targets-run {way} --material-corrected not-stated");
    document("formats/rtl_linear_bidirectional_selfmade.rtl", &stated)
}

/// Two runs out, two back; by hand from the first and the last target of the file.
#[test]
fn the_runs_of_an_rtl_file_keep_their_scatter() {
    let document = of_rtl("as-error", "+");
    assert_eq!(document["runs"], json!({ "up": 2, "down": 2 }));
    let iso = &document["iso_230_2"];
    let first = &iso["targets"][0];
    assert_eq!(first["target_mm"], -200.0);
    near(&first["mean_up_um"], 0.5, 1e-3); // 0.4 and 0.6
    near(&first["s_up_um"], 0.2 / 2.0_f64.sqrt(), 1e-3);
    near(&iso["B_mean_um"], 1.55, 1e-3);
    holds(&iso["notes"].to_string(), &["Axis: X"]);
}

/// Against the axis, the directions change places and every deviation changes its sign.
#[test]
fn the_way_of_the_targets_turns_directions_and_deviations() {
    let [plus, minus] = ["+", "-"].map(|way| of_rtl("as-error", way)["iso_230_2"].clone());
    for (here, there) in
        [("E_um", "E_um"), ("R_um", "R_um"), ("A_um", "A_um"), ("E_up_um", "E_down_um")]
    {
        near(&minus[there], number(&plus[here]), 1e-3);
    }
    let (first, last) = (&minus["targets"][0], &plus["targets"][8]);
    near(&first["target_mm"], -number(&last["target_mm"]), 1e-3);
    near(&first["mean_down_um"], -number(&last["mean_up_um"]), 1e-3);
    near(&first["B_um"], number(&last["B_um"]), 1e-3);
    near(&of_rtl("as-correction", "+")["iso_230_2"]["B_mean_um"], -1.55, 1e-3);
}

const X_AXIS: &str = "standards/x_axis.csv";

/// Above 2 m the document names the figures that the standard does not know.
#[test]
fn a_stated_travel_is_in_the_document_and_marks_figures_beside_the_standard() {
    let stated = document(X_AXIS, "--travel-mm 1000");
    assert_eq!(stated["travel_mm"], 1000.0);
    assert_eq!(stated["iso_230_2"]["condition_missed"], false);
    assert_eq!(stated["iso_230_2"]["editions"], json!([1997, 2006, 2014]));
    assert_eq!(document(X_AXIS, "")["travel_mm"], Value::Null);
    let long = document(X_AXIS, "--travel-mm 2500");
    assert_eq!(long["iso_230_2"]["not_in_the_standard"], json!(["A", "R"]));
    assert_eq!(long["iso_230_2"]["condition_missed"], true);
    standards(X_AXIS, "--travel-mm 2500").says("repeatability, not in the standard above 2 m");
}
