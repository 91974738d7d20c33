//! What the figures of `nonius assess` hold for, what they rest on, what was not measured.

use super::assess::document;
use crate::support::*;
use serde_json::{Value, json};

#[track_caller]
fn explained(visit: &Visit, command: &str) -> Ran {
    visit.run(&format!("{command} --explain")).ends(0)
}

/// A job for a cube of 300 mm, without anything for a control.
fn cube() -> String {
    let axes = ["x", "y", "z"].map(|axis| {
        format!("[machine.axes.{axis}]\ntravel_mm = [0.0, 300.0]\nreference_mm = 0.0\n")
    });
    let head = "schema = 1\n[machine]\nname = \"cube\"\nchain = \"wXYZt\"\n";
    let measured = "[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n";
    format!("{head}{}{measured}", axes.concat())
}

/// Three axes that rise to 30 µm at 100 and 200 mm: a spline overshoots between them.
fn humps() -> String {
    let rows = "A,0,0,0,0\nA,100,10,10,10\nA,200,10,10,10\nA,300,0,0,0\n";
    let axes = ["x", "y", "z"].map(|axis| rows.replace('A', axis));
    format!("axis,position_mm,ex_um,ey_um,ez_um\n{}", axes.concat())
}

#[test]
fn the_volume_is_claimed_only_where_no_place_is_worse() {
    let visit = Visit::with(cube(), humps());
    let spline = "[compensation]\ncontroller = \"generic\"\ncurve = \"natural-spline\"\n";
    visit.put("spline.toml", cube() + spline);
    let exact = |arguments: &str| {
        let d = &document(&visit, &format!("assess {arguments}"))["definitions"];
        (number(&d["va_um"]), d["va_exact"].as_bool().unwrap())
    };
    // √3 · 30 at the nodes; the spline reaches more in the middle.
    assert_eq!(exact("job.toml"), (51.961_524, true));
    assert_eq!(exact("job.toml --grid 7,7,7"), (51.961_524, true));
    assert_eq!(exact("job.toml --grid 2,2,2"), (0.0, false));
    assert_eq!(exact("spline.toml"), (51.961_524, false));
    let (finer, claimed) = exact("spline.toml --grid 11,11,11");
    assert!(finer > 59.7 && !claimed, "{finer}");
    for (job, places) in [("spline.toml", "of these nodes"), ("job.toml", "places of the volume")] {
        let words = format!("51.962 µm: no two {places} differ by more");
        explained(&visit, &format!("assess {job}")).says(&words);
    }
}

#[test]
fn a_separation_keeps_its_labels_and_its_frame() {
    let found = document(&Visit::of("diagonals/case_d_bidirectional"), "assess job.toml");
    assert_eq!(found["frame"], "as-measured");
    labelled(&found, &["set-up assumed perfect", "a reversal of about"]);
    let visit = Visit::of("start/readings");
    assert_eq!(document(&visit, "assess job.toml")["frame"], "x-primary");
    let said = explained(&visit, "assess job.toml").omits("nothing was rotated");
    said.says("frame: X primary, XY plane secondary");
}

#[test]
fn a_turned_datum_leaves_what_the_page_says_to_stay() {
    let visit = Visit::of("start/errors");
    let one = document(&visit, "assess job.toml");
    // e + ω × p, ω = (30, -20, 40) µrad.
    let turned = with_cells(&visit.read("errors.csv"), |cells| {
        let m = cells.get(1).and_then(|mm| mm.parse::<f64>().ok()).unwrap_or_default() / 1000.0;
        let added = match cells[0].as_str() {
            "x" => [0.0, 40.0 * m, 20.0 * m],
            "y" => [-40.0 * m, 0.0, 30.0 * m],
            "z" => [-20.0 * m, -30.0 * m, 0.0],
            _ => return true,
        };
        for (cell, um) in cells[2..].iter_mut().zip(added) {
            *cell = (cell.parse::<f64>().unwrap() + um).to_string();
        }
        true
    });
    visit.put("errors.csv", turned);
    let other = document(&visit, "assess job.toml");
    let both = |key: &str| [&one, &other].map(|found| number(&found["definitions"][key]));
    let change = |key: &str| (both(key)[0] - both(key)[1]).abs();
    for key in ["va_um", "box_um", "elsv_um", "existing_um", "proposed_um"] {
        assert!(change(key) > 0.1, "{key}: {:?}", both(key));
    }
    assert!(change("elv_um") < 2e-6, "{:?}", both("elv_um"));
    // To second order: 50 µrad of 10 µm, and 50² µrad² of half a metre.
    assert!(change("length_um") < 2e-3, "{:?}", both("length_um"));
    for name in DIAGONALS {
        let range = |of: &Value| number(&of["definitions"]["diagonals_um"][name]);
        assert!((range(&one) - range(&other)).abs() < 2e-6, "{name}");
    }
}

#[test]
fn tables_that_were_active_are_part_of_the_machine_as_measured() {
    let visit = Visit::of("start/errors");
    let job = visit.read("job.toml");
    let active = "active_while_measuring = \"none\"";
    let after = replaced(&job, active, "active_while_measuring = \"kit\"");
    visit.put("after.toml", replaced(&after, "errors.csv", "residual.csv"));
    visit.put("silent.toml", replaced(&job, active, ""));
    let residual = "axis,position_mm,ex_um,ey_um,ez_um\nx,0,0,0,0\nx,400,1,0,0\ny,0,0,0,0\ny,300,0,0,0\nz,-200,0,0,0\nz,0,0,0,0\n";
    visit.put("residual.csv", residual);
    visit.yes("generate job.toml -o kit");
    let found = document(&visit, "assess after.toml");
    assert_eq!(found["active"]["tables"], "kit");
    assert_eq!(number(&found["definitions"]["va_um"]), 1.0);
    assert!(number(&found["active"]["va_without_um"]) > 14.0, "{}", found["active"]);
    let words = "as measured, with the tables of `kit` active; without any tables";
    explained(&visit, "assess after.toml").says(words);
    let found = document(&visit, "assess silent.toml");
    labelled(&found, &["`active_while_measuring` is not stated"]);
    assert_eq!(found["active"], Value::Null);
}

#[test]
fn places_that_levers_depend_on_are_named() {
    let offsets = "tool_offset_mm = { x = 0.0, y = 0.0, z = -120.5 }\noffsets_mm = { x = 4000.0, y = 100.0 }\n";
    let visit = Visit::with(cube() + offsets, humps());
    let found = document(&visit, "assess job.toml");
    assert_eq!(found["tool_offset_mm"], json!([0.0, 0.0, -120.5]));
    assert_eq!(found["offsets_mm"], json!({"x": 4000.0, "y": 100.0, "z": null}));
    assert_eq!(found["volume_mm"]["y"], json!([0.0, 300.0]));
    labelled(&found, &["does not reach: X 4000 mm"]);
    let words = "tool offset (0, 0, -120.5) mm; offsets X 4000, Y 100 mm";
    explained(&visit, "assess job.toml").says(words);
}

#[test]
fn what_was_not_measured_is_no_error_of_nothing() {
    // Angles alone make a figure where their levers are known.
    let visit = Visit::with(cube(), "axis,position_mm,ec_urad\nx,0,0\nx,300,100\n");
    let found = document(&visit, "assess job.toml");
    assert_eq!(number(&found["definitions"]["va_um"]), 30.0, "100 µrad of 300 mm");
    let table = "axis,position_mm,ex_um,ez_um,ea_urad,eb_urad,ec_urad\nx,0.1,0,0,5,20,10\nx,900.25,10,1,5,20,30\n";
    visit.put("x.csv", table);
    let found = document(&visit, "assess x.csv --chain wXYZt");
    assert_eq!(found["errors_measured"], 5);
    assert_eq!(found["definitions"]["ranges_um"], json!([10.0, null, 1.0]));
    assert_eq!(found["volume_mm"]["y"], Value::Null);
    explained(&visit, "assess x.csv --chain wXYZt").tells(&[
        "volume X 0.1 … 900.25 mm, Y not measured and its travel not stated, Z not measured",
        "5 of the 21 errors were measured",
        "range Y       not measured",
        "angles measured and not counted: EAX, EBX, ECX; the travel of Y, Z, their lever, is not stated",
    ]);
}

#[test]
fn bins_that_no_drawn_pair_hit_are_unknown() {
    // More pairs than are counted one by one: ten million are drawn, twice.
    if short_or(true, false) {
        return;
    }
    let visit = Visit::of("machine_h");
    let command = "assess job.toml --grid 200,200,2 --histogram 1";
    let histogram = &document(&visit, command)["histogram"];
    assert_eq!(histogram["exact"], false);
    let [counts, errors] =
        ["counts", "standard_errors"].map(|key| histogram[key].as_array().unwrap());
    assert_eq!(counts.len(), 1150, "1149.98 µm lies in bin 1149");
    assert!(number(&counts[1149]) >= 1.0, "the last bin holds the largest difference");
    assert!(counts.iter().any(Value::is_null), "no drawn pair fell there");
    assert!(counts.iter().chain(errors).all(|value| value.as_f64() != Some(0.0)));
    explained(&visit, command).says("no drawn pair fell there");
}

#[test]
fn the_map_of_sub_volumes_holds_the_extremes() {
    let command = "assess job.toml --window 6000,2000,1000 --grouping 0.1";
    let found = document(&Visit::of("machine_h"), command);
    let windows = &found["windows"];
    let map = &windows["map"];
    let [x, y, z] = ["x_mm", "y_mm", "z_mm"].map(|key| map[key].as_array().unwrap());
    assert_eq!((x.len(), y.len(), z.len()), (7, 5, 4));
    let mut all = Vec::new();
    for (i, x) in x.iter().enumerate() {
        for (j, y) in y.iter().enumerate() {
            for (k, z) in z.iter().enumerate() {
                all.push((number(&map["um"][i][j][k]), json!([x, y, z])));
            }
        }
    }
    let worst = all.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert_eq!(worst.0, number(&windows["max_um"]));
    assert_eq!(worst.1, windows["max_at_mm"]);
    assert_eq!(all[0].0, number(&windows["corner_um"]));
    // With another zero of the squareness 240.
    let grouping = &found["grouping"];
    assert_eq!(grouping["records"], 168);
    assert_eq!(grouping["exact"], false);
    assert!(number(&grouping["um"]) <= number(&found["definitions"]["va_um"]));
    // Of two vectors one is kept: that is no difference of 0.
    let one = Visit::with(cube(), "axis,position_mm,ex_um\nx,0,0\nx,300,10\n");
    let command = "assess errors.csv --grid 2,1,1 --grouping 0.1";
    explained(&one, command).says("no two vectors are kept; exact 10.000 µm");
}

#[test]
fn figures_need_neither_a_control_nor_a_backlash_policy() {
    let both = "axis,position_mm,direction,ex_um\nx,0,+,0\nx,300,+,10\nx,0,-,-2\nx,300,-,8\n";
    let visit = Visit::with(cube(), both);
    let found = document(&visit, "assess job.toml");
    assert_eq!(number(&found["definitions"]["va_um"]), 10.0);
    labelled(&found, &["the mean of both counts"]);
    visit.run("generate job.toml -o kit").ends(2); // tables need a control
}

#[test]
fn slips_of_the_unit_are_doubted() {
    let job = cube() + "[measurement.squareness_um_per_m]\nxy = 5001.0\n";
    let table = "axis,position_mm,ex_mm,ey_um\nx,0,0,0\nx,300,5.1,4999\ny,0,0,0\ny,300,0,0\n";
    let found = document(&Visit::with(&job, table), "assess job.toml");
    labelled(
        &found,
        &[
            "doubt: EXX reaches 5100 µm, and more than 5000 µm is unlikely",
            "doubt: squareness_xy reaches 5001 µm/m",
        ],
    );
    assert!(!found["labels"].to_string().contains("EYX reaches"), "{}", found["labels"]);
}

/// Machine H in full, small enough to be checked against the authority in `expected.json`.
#[test]
fn the_page_and_the_document_of_machine_h() {
    let visit = Visit::of("machine_h");
    insta::assert_snapshot!("machine_h_page", visit.yes("assess job.toml"));
    let document = visit.yes("assess job.toml --format json --explain");
    insta::assert_snapshot!("machine_h_document", document);
}

#[test]
fn the_job_of_the_documentation_is_complete() {
    let text = page("docs/volume.md");
    let (job, _) =
        text.split_once("```toml\n").and_then(|(_, rest)| rest.split_once("```")).unwrap();
    let table = "axis,position_mm,ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad\nx,0,0,0,0,0,0,0\nx,800,8,1,2,5,-4,3\ny,0,0,0,0,0,0,0\ny,500,1,6,0,2,1,0\nz,-450,-3,2,-4,1,1,1\nz,0,0,0,0,0,0,0\n";
    let options = "--grid 17,11,10 --window 300,200,200 --histogram 5";
    let found = document(&Visit::with(job, table), &format!("assess job.toml {options}"));
    assert_eq!(found["errors_measured"], 21);
    assert_eq!(found["missing"], json!([]));
    assert_eq!(found["definitions"]["va_exact"], true);
}
