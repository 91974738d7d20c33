//! What `assess` and `path` say of a machine with tables, against the forecast; where errors and levers count from.

use crate::support::{G54, LAST_DIGIT, Visit, near, number, replaced};
use serde_json::Value;

/// A machine of three axes of 0 … 900 mm with an error table; `measurement` = further lines of its job.
fn visit(measurement: &str, compensation: &str, errors: &str) -> Visit {
    let axis = "{ travel_mm = [0.0, 900.0], reference_mm = 0.0 }";
    let page = format!(
        "schema = 1\n[machine]\nname = \"M\"\nchain = \"wXYZt\"\n\
         axes = {{ x = {axis}, y = {axis}, z = {axis} }}\n\
         [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n{measurement}\n\
         [compensation]\n{compensation}\n{G54}"
    );
    let visit = Visit::with(page, errors);
    visit.put("p.nc", "G1 X900.\nM30\n");
    visit
}

/// The controls of these tests: their facts, and spacings for X, Y and Z.
fn control(id: &str, further: &str) -> String {
    let axes = [("x", 100), ("y", 200), ("z", 300)].map(|(axis, first)| {
        let steps = format!(", first_point = {first}, detection_unit_um = 1, interpolated = false");
        let steps = if id.starts_with("fanuc") { &steps } else { "" };
        format!("axes.{axis} = {{ spacing_mm = 90.0{steps} }}\n")
    });
    format!("controller = \"{id}\"\n{further}\n{}", axes.concat())
}

fn along_x(rows: &str) -> String {
    let level = "y,0,0,0,0\ny,900,0,0,0\nz,0,0,0,0\nz,900,0,0,0\n";
    format!("axis,position_mm,ex_um,ey_um,ez_um\n{rows}{level}")
}

#[track_caller]
fn defined(found: &Value, key: &str) -> f64 {
    number(&found["definitions"][key])
}

/// The forecast reads the same bytes, and knows nothing of volumes and paths.
#[test]
fn what_is_left_along_one_axis_is_what_the_forecast_says() {
    let straight = "x,0,0,0,0\nx,900,100,0,0\n";
    let curves = ["linear", "pchip", "natural-spline"];
    let ids = ["siemens-840d-sl", "fanuc-30i", "generic"];
    for shape in [straight, "x,0,0,0,0\nx,300,20,0,0\nx,600,-20,0,0\nx,900,0,0,0\n"] {
        for (curve, id) in curves.into_iter().flat_map(|curve| ids.map(|id| (curve, id))) {
            let what = format!("{id}, {curve}, {shape}");
            let curved = control(id, &format!("curve = \"{curve}\""));
            let visit = visit("", &curved, &along_x(shape)).with_any_kit();
            let manifest = visit.document("kit/manifest.json");
            let forecast = number(&manifest["forecast"]["terms"]["EXX"]["after_um"]);
            let is_easy = shape == straight && !id.starts_with("fanuc");
            assert!(is_easy || forecast > 0.01, "{what}: {forecast} is too easy");
            let path = &visit.json("path job.toml p.nc --tables kit")["after"];
            let extreme = |of: &str, end: &str| number(&path["extremes"][of][end]["um"]);
            near(&format!("{what}, path"), extreme("e", "max"), forecast, 2.0 * LAST_DIGIT);
            let range = extreme("ex", "max") - extreme("ex", "min");
            let accuracy = number(&path["profile_accuracy_um"]);
            assert!(accuracy <= range + 2.0 * LAST_DIGIT, "{what}");
            // The reference is a node where nothing is left, so VA is not less than the largest error.
            let after = &visit.json("assess job.toml --tables kit")["after"];
            let from = defined(after, "max_from_reference_um");
            if curve == "linear" {
                near(&format!("{what}, assess"), from, forecast, 2.0 * LAST_DIGIT);
                near(&format!("{what}, accuracy"), accuracy, range, 2.0 * LAST_DIGIT);
                near(&format!("{what}, VA"), defined(after, "va_um"), range, 2.0 * LAST_DIGIT);
            }
        }
    }
}

/// A control that steps: 10 µm of table on 90 mm, half way between two nodes the whole step.
#[test]
fn a_staircase_is_a_staircase() {
    let visit = visit("", &control("fanuc-30i", ""), &along_x("x,0,0,0,0\nx,900,100,0,0\n"));
    visit.put("p.nc", "G1 X38.\nX900.\nM30\n");
    visit.run("generate job.toml -o kit").answers();
    let path = visit.json("path job.toml p.nc --tables kit -o points.csv");
    let points = visit.read("points.csv");
    let mut rows = points.lines().filter(|line| !line.starts_with('#'));
    let header = rows.next().unwrap();
    let cell = |row: &str, name: &str| -> f64 {
        let mut cells = header.split(',').zip(row.split(','));
        cells.find(|(other, _)| *other == name).unwrap().1.parse().unwrap()
    };
    let at_38 = rows.find(|row| (cell(row, "x_mm") - 38.0).abs() < 1e-9).unwrap();
    near("x = 38", cell(at_38, "after_ex_um"), 38.0 / 9.0, 1e-3);
    near("profile accuracy", number(&path["after"]["profile_accuracy_um"]), 10.0, LAST_DIGIT);
    // The same way back: both values of each jump are met again.
    visit.put("p.nc", "G0 X900.\nG1 X0.\nM30\n");
    for path in [path, visit.json("path job.toml p.nc --tables kit")] {
        let ex = &path["after"]["extremes"]["ex"];
        near("max", number(&ex["max"]["um"]), 5.0, LAST_DIGIT);
        near("min", number(&ex["min"]["um"]), -5.0, LAST_DIGIT);
    }
    let after = &visit.json("assess job.toml --tables kit")["after"];
    near("VA", defined(after, "va_um"), 10.0, LAST_DIGIT);
}

fn measured_again(naked: &str, left: &str) -> Visit {
    let visit = visit("", &control("generic", ""), &along_x(naked)).with_kit();
    visit.edit("job.toml", "measuring = \"none\"", "measuring = \"kit\"");
    visit.put("errors.csv", along_x(left));
    visit
}

#[test]
fn as_it_is_means_as_it_was_measured() {
    let naked = "x,0,0,0,0\nx,450,30,0,0\nx,900,40,0,0\n";
    let visit = measured_again(naked, "x,0,0,0,0\nx,450,3,0,0\nx,900,-2,0,0\n");
    let found = visit.json("assess job.toml --with-tables");
    near("as it is", defined(&found, "va_um"), 5.0, LAST_DIGIT);
    near("with the new tables", defined(&found["after"], "va_um"), 0.0, LAST_DIGIT);
    let found = visit.json("assess job.toml --tables kit");
    near("with the old tables", defined(&found["after"], "va_um"), 5.0, LAST_DIGIT);
    let path = visit.json("path job.toml p.nc --tables kit");
    near("before", number(&path["profile_accuracy_um"]), 5.0, LAST_DIGIT);
    near("after", number(&path["after"]["profile_accuracy_um"]), 5.0, LAST_DIGIT);
}

/// Measured at its ends only: a new table that is too coarse leaves the bends, along the diagonals too.
#[test]
fn what_lies_under_an_old_table_bends_where_the_table_does() {
    let bent = "x,0,0,0,0\nx,270,12,0,0\nx,900,0,0,0\n";
    let visit = measured_again(bent, "x,0,0,0,0\nx,900,0,0,0\n");
    visit.edit("job.toml", "spacing_mm = 90.0", "spacing_mm = 900.0");
    let forecast = &visit.json("generate job.toml -o new")["forecast"];
    let diagonals = forecast["diagonals"].as_object().unwrap();
    assert_eq!(diagonals.len(), 4);
    for diagonal in diagonals.values() {
        near("as measured", number(&diagonal["before_um"]), 0.0, LAST_DIGIT);
        let left = number(&diagonal["after_um"]);
        near("left", left, 12.0 / 3.0_f64.sqrt(), LAST_DIGIT); // a cube: cosine 1/√3
    }
}

/// No error, or none that is not a reversal: all figures count from the reference.
#[test]
fn nothing_left_is_nothing_in_every_definition() {
    let generic = control("generic", "");
    let measurement = "squareness_um_per_m.xy = 100.0\noffsets_mm.y = 300.0";
    let errors = along_x("x,0,0,0,0\nx,900,5,0,0\n");
    let shorter = visit(measurement, &generic, &replaced(&errors, "y,900", "y,400"));
    let y = "y = { travel_mm = [0.0, 900.0], reference_mm =";
    shorter.edit("job.toml", &format!("{y} 0.0"), &format!("{y} 900.0"));
    shorter.edit("job.toml", "spacing_mm = 90.0", "spacing_mm = 50.0");
    let found = shorter.json("assess job.toml --with-tables");
    near("before", defined(&found, "va_um"), 45.0, LAST_DIGIT);
    let after = &found["after"];
    let keys = ["va_um", "proposed_um", "proposed_of_nine_um", "existing_um"];
    for key in keys.iter().chain(&["max_from_reference_um"]) {
        near(key, defined(after, key), 0.0, 2.0 * LAST_DIGIT);
    }
    for part in after["contributions"].as_array().unwrap() {
        near(&part["term"].to_string(), number(&part["um"]), 0.0, 2.0 * LAST_DIGIT);
        assert_ne!(part["term"], "squareness_xy", "it is in EXY, which the table corrects");
    }
    let reversal = "axis,position_mm,ex_um,ey_um,ez_um,direction\nx,0,0,0,0,+\nx,900,0,0,0,+\nx,0,-20,0,0,-\nx,900,-20,0,0,-\ny,0,0,0,0,\ny,900,0,0,0,\nz,0,0,0,0,\nz,900,0,0,0,\n";
    let visit = visit("", &control("generic", "backlash = \"mean\""), reversal);
    let found = visit.json("assess job.toml --with-tables");
    for key in keys {
        near(key, defined(&found, key), 0.0, LAST_DIGIT);
        near(key, defined(&found["after"], key), 0.0, LAST_DIGIT);
    }
}

#[test]
fn squareness_and_a_slope_of_the_table_are_one_machine() {
    let level = along_x("x,0,0,0,0\nx,900,10,0,0\n");
    let without = "G54 G1 X100. Y100. Z122.4\nX300. Z50.\nM30\n";
    let with = "G54 G1 G43 H1 X100. Y100. Z10.\nG49 X300. Z50.\nM30\n";
    let offsets = "offsets_mm = { x = 0.0, y = 500.0, z = 700.0 }";
    let offset = "tool_offset_mm = { x = 0.0, y = 0.0, z = -100.0 }";
    for (lines, program) in [("", with), (offsets, with), (offset, without)] {
        let figures = |stated: &str, errors: &str| {
            let visit = visit(&format!("{lines}\n{stated}"), "controller = \"generic\"", errors);
            let tool = "[[path.tool]]\nnumber = 1\nlength_mm = 112.4\n";
            visit.put("p.nc", program).put("job.toml", visit.read("job.toml") + tool);
            let path = visit.json("path job.toml p.nc");
            (path["extremes"].clone(), path["profile_accuracy_um"].clone())
        };
        let stated = figures("squareness_um_per_m.xz = 1000.0", &level);
        let sloped = figures("", &replaced(&level, "z,900,0,0,0", "z,900,900,0,0"));
        assert_eq!(stated, sloped, "{lines}");
    }
}

/// Where the resting axes are said to have stood changes the curves, and the levers: not the volume.
#[test]
fn readings_and_levers_count_from_one_place() {
    let visit = Visit::of("diagonals/case_c_angles");
    visit.put("angles.csv", "axis,position_mm,ea_urad,eb_urad,ec_urad\nx,0,0,0,0\nx,900,5,-8,12\ny,0,0,0,0\ny,720,-6,9,4\nz,0,0,0,0\nz,720,3,-7,2\n");
    visit.edit("job.toml", "[measurement]\n", "[measurement]\nangles = \"angles.csv\"\n");
    // Every third node of the readings: all of them take seconds.
    let va = || defined(&visit.json("assess job.toml --grid 11,11,11"), "va_um");
    let first = va();
    assert!(first > 1.0, "{first}");
    visit.edit("job.toml", "720.0000]\nreference_mm = 0.0", "720.0000]\nreference_mm = 720.0");
    near("another reference", va(), first, 1e-3);
    let offsets = "[measurement]\noffsets_mm = { x = 0.0, y = 100.0, z = 250.0 }\n";
    visit.edit("job.toml", "[measurement]\n", offsets);
    near("stated offsets", va(), first, 1e-3);
}

#[test]
fn one_grid_for_before_and_after_with_at_most_so_many_nodes() {
    let errors = along_x("x,0,0,0,0\nx,300,20,0,0\nx,600,-20,0,0\nx,900,0,0,0\n");
    let coarse = visit("", &replaced(&control("generic", ""), "90.0", "250.0"), &errors);
    let found = coarse.json("assess job.toml --with-tables --histogram 5 --window 300,900,900");
    assert_eq!(found["grid"], found["after"]["grid"]);
    assert_eq!(found["histogram"]["pairs"], found["after"]["histogram"]["pairs"]);
    assert_eq!(found["windows"]["count"], 3);
    let row = |axis, node| format!("{axis},{},{},0,0\n", f64::from(node) * 1.9, node % 7);
    let rows = ["x", "y", "z"].map(|axis| (0..465).map(|node| row(axis, node)).collect::<String>());
    let errors = format!("axis,position_mm,ex_um,ey_um,ez_um\n{}", rows.concat());
    let visit = visit("", "controller = \"generic\"", &errors);
    visit.run("assess job.toml").ends(2).says("465 x 465 x 465, more than 100000000");
}

/// Its lever is added there, zero at the reference, so a finer grid finds nothing new; tables do not hold it.
#[test]
fn an_optic_on_the_table_counts_where_it_was_measured() {
    let errors = "axis,position_mm,ex_um,ey_um,ez_um,ec_urad\nx,0,0,0,0,50\nx,900,0,0,0,0\ny,0,0,0,0,\ny,900,0,0,0,\nz,0,0,0,0,\nz,900,0,0,0,\n";
    let grids = "axes.x.spacing_mm = 90\naxes.y.spacing_mm = 90\naxes.z.spacing_mm = 90";
    let controller = format!("controller = \"generic\"\n{grids}");
    let visit = visit("straightness_optic_mm = { x = 900.0 }", &controller, errors);
    visit.edit("job.toml", "wXYZt", "XwYZt");
    let va = defined(&visit.json("assess job.toml"), "va_um");
    near("finer", va, defined(&visit.json("assess job.toml --grid 21,21,2"), "va_um"), LAST_DIGIT);
    near("VA", va, 45.0 * 2_f64.sqrt(), LAST_DIGIT);
    visit.run("generate job.toml --dry-run").ends(1).says("undecided").says("convert it");
    near("sum", defined(&visit.json("assess job.toml"), "proposed_um"), 90.0, LAST_DIGIT);
}
