//! What `assess` and `path` say of a machine with tables, against the forecast of `generate`,
//! which finds it in another way; and where errors and levers count from.

use crate::support::run::nonius;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

fn json(directory: &Path, arguments: &str) -> Value {
    let output = nonius(directory, &format!("{arguments} --format json"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_ne!(output.status.code(), Some(2), "{arguments}: {said}");
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number, not {value}"))
}

fn near(what: &str, got: f64, want: f64, room: f64) {
    assert!((got - want).abs() <= room, "{what}: {got}, expected {want}");
}

/// The last digit that the documents hold, µm.
const LAST_DIGIT: f64 = 1.001e-6;

/// A job of three axes of 0 … 900 mm; `measurement` and `compensation` are further lines.
fn job(measurement: &str, compensation: &str) -> String {
    let mut page = "schema = 1\n[machine]\nname = \"M\"\nchain = \"wXYZt\"\n".to_string();
    for axis in ["x", "y", "z"] {
        writeln!(page, "[machine.axes.{axis}]\ntravel_mm = [0.0, 900.0]\nreference_mm = 0.0")
            .unwrap();
    }
    let errors = if measurement.contains("readings = ") { "" } else { "errors = \"errors.csv\"\n" };
    let active = if measurement.contains("active_while_measuring") {
        ""
    } else {
        "active_while_measuring = \"none\"\n"
    };
    format!(
        "{page}[measurement]\n{errors}{active}{measurement}\n[compensation]\n{compensation}\n[[path.offset]]\nsystem = \"G54\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n"
    )
}

/// The controls of these tests: their facts, and spacings for X, Y and Z.
fn control(id: &str, further: &str) -> String {
    let mut page = format!("controller = \"{id}\"\n{further}\n");
    for (index, axis) in ["x", "y", "z"].into_iter().enumerate() {
        writeln!(page, "[compensation.axes.{axis}]\nspacing_mm = 90.0").unwrap();
        if id.starts_with("fanuc") {
            let first = 100 * (index + 1);
            let steps = "detection_unit_um = 1.0\ninterpolated = false";
            writeln!(page, "first_point = {first}\n{steps}").unwrap();
        }
    }
    page
}

fn written(files: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(directory.path().join(name), text).unwrap();
    }
    directory
}

const HEADER: &str = "axis,position_mm,ex_um,ey_um,ez_um\n";
const LEVEL_YZ: &str = "y,0,0,0,0\ny,900,0,0,0\nz,0,0,0,0\nz,900,0,0,0\n";
const ALONG_X: &str = "G1 X900.\nM30\n";

/// One axis with errors: the largest error that is left along it, and the largest difference, are
/// those of the forecast, which reads the same bytes and knows nothing of volumes and paths.
#[test]
fn what_is_left_along_one_axis_is_what_the_forecast_says() {
    let shapes =
        ["x,0,0,0,0\nx,900,100,0,0\n", "x,0,0,0,0\nx,300,20,0,0\nx,600,-20,0,0\nx,900,0,0,0\n"];
    let controls = [("siemens-840d-sl", ""), ("fanuc-30i", ""), ("generic", "")];
    for shape in shapes {
        for curve in ["linear", "pchip", "natural-spline"] {
            for (id, further) in controls {
                let what = format!("{id}, {curve}");
                let compensation = control(id, &format!("curve = \"{curve}\"\n{further}"));
                let directory = written(&[
                    ("job.toml", &job("", &compensation)),
                    ("errors.csv", &format!("{HEADER}{shape}{LEVEL_YZ}")),
                    ("p.nc", ALONG_X),
                ]);
                let at = directory.path();
                let kit = nonius(at, "generate job.toml -o kit");
                assert_ne!(kit.status.code(), Some(2), "{what}: {kit:?}");
                let manifest = std::fs::read(at.join("kit/manifest.json")).unwrap();
                let manifest: Value = serde_json::from_slice(&manifest).unwrap();
                let forecast = number(&manifest["forecast"]["terms"]["EXX"]["after_um"]);
                let straight = shape == shapes[0] && !id.starts_with("fanuc");
                assert!(straight || forecast > 0.01, "{what}: {forecast} is too easy");

                let path = json(at, "path job.toml p.nc --tables kit");
                let largest = number(&path["after"]["extremes"]["e"]["max"]["um"]);
                near(&format!("{what}, path"), largest, forecast, 2.0 * LAST_DIGIT);

                // Both ends of the range of X lie in it, so VA is not less than the largest
                // error: the reference is one of the nodes, where nothing is left.
                let after = json(at, "assess job.toml --tables kit")["after"].clone();
                let from = number(&after["definitions"]["max_from_reference_um"]);
                if curve == "linear" {
                    near(&format!("{what}, assess"), from, forecast, 2.0 * LAST_DIGIT);
                }
                let range = number(&path["after"]["extremes"]["ex"]["max"]["um"])
                    - number(&path["after"]["extremes"]["ex"]["min"]["um"]);
                let accuracy = number(&path["after"]["profile_accuracy_um"]);
                assert!(accuracy <= range + 2.0 * LAST_DIGIT, "{what}");
                if curve == "linear" {
                    near(&format!("{what}, accuracy"), accuracy, range, 2.0 * LAST_DIGIT);
                    let va = number(&after["definitions"]["va_um"]);
                    near(&format!("{what}, VA"), va, range, 2.0 * LAST_DIGIT);
                }
            }
        }
    }
}

/// A control that steps: 10 µm of table on 90 mm, half way between two nodes the whole step.
#[test]
fn a_staircase_is_a_staircase() {
    let errors = format!("{HEADER}x,0,0,0,0\nx,900,100,0,0\n{LEVEL_YZ}");
    let directory = written(&[
        ("job.toml", &job("", &control("fanuc-30i", ""))),
        ("errors.csv", &errors),
        ("p.nc", "G1 X38.\nX900.\nM30\n"),
    ]);
    let at = directory.path();
    assert_ne!(nonius(at, "generate job.toml -o kit").status.code(), Some(2));
    let path = json(at, "path job.toml p.nc --tables kit -o points.csv");
    let points = std::fs::read_to_string(at.join("points.csv")).unwrap();
    let mut rows = points.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|other| *other == name).unwrap();
    let (x, ex) = (column("x_mm"), column("after_ex_um"));
    let cells = rows.map(|row| row.split(',').collect::<Vec<&str>>());
    let at_38 = cells.map(|row| (row[x].parse::<f64>().unwrap(), row[ex].parse::<f64>().unwrap()));
    let (_, um) = at_38.into_iter().find(|(x, _)| (x - 38.0).abs() < 1e-9).unwrap();
    near("x = 38", um, 38.0 / 9.0, 1e-3);
    near("profile accuracy", number(&path["after"]["profile_accuracy_um"]), 10.0, LAST_DIGIT);
    // The same way back: both values of each jump are met again.
    std::fs::write(at.join("p.nc"), "G0 X900.\nG1 X0.\nM30\n").unwrap();
    let back = json(at, "path job.toml p.nc --tables kit");
    for (end, um) in [("max", 5.0), ("min", -5.0)] {
        for path in [&path, &back] {
            let found = number(&path["after"]["extremes"]["ex"][end]["um"]);
            near(end, found, um, LAST_DIGIT);
        }
    }
    let after = &json(at, "assess job.toml --tables kit")["after"];
    near("VA", number(&after["definitions"]["va_um"]), 10.0, LAST_DIGIT);
}

/// A kit that was active while measuring: the machine as it is is the one that was measured, and
/// the new tables are added to the machine without the old ones.
#[test]
fn as_it_is_means_as_it_was_measured() {
    let naked = format!("{HEADER}x,0,0,0,0\nx,450,30,0,0\nx,900,40,0,0\n{LEVEL_YZ}");
    let left = format!("{HEADER}x,0,0,0,0\nx,450,3,0,0\nx,900,-2,0,0\n{LEVEL_YZ}");
    let compensation = control("generic", "");
    let directory = written(&[
        ("old.toml", &job("", &compensation)),
        ("job.toml", &job("active_while_measuring = \"kit\"", &compensation)),
        ("errors.csv", &naked),
        ("p.nc", ALONG_X),
    ]);
    let at = directory.path();
    assert_eq!(nonius(at, "generate old.toml -o kit").status.code(), Some(0));
    std::fs::write(at.join("errors.csv"), left).unwrap();
    let found = json(at, "assess job.toml --with-tables");
    let va = |found: &Value| number(&found["definitions"]["va_um"]);
    near("as it is", va(&found), 5.0, LAST_DIGIT);
    near("with the new tables", va(&found["after"]), 0.0, LAST_DIGIT);
    let found = json(at, "assess job.toml --tables kit");
    near("with the old tables", va(&found["after"]), 5.0, LAST_DIGIT);
    let path = json(at, "path job.toml p.nc --tables kit");
    for which in ["before", "after"] {
        let summary = if which == "after" { &path["after"] } else { &path };
        let accuracy = number(&summary["profile_accuracy_um"]);
        near(which, accuracy, 5.0, LAST_DIGIT);
    }
}

/// Measured at its ends only, while an old table was active: what lies under that table bends where
/// the table does, and a new one that is too coarse leaves it, along the diagonals too.
#[test]
fn what_lies_under_an_old_table_bends_where_the_table_does() {
    let naked = format!("{HEADER}x,0,0,0,0\nx,270,12,0,0\nx,900,0,0,0\n{LEVEL_YZ}");
    let left = format!("{HEADER}x,0,0,0,0\nx,900,0,0,0\n{LEVEL_YZ}");
    let fine = control("generic", "");
    let coarse = fine.replace("spacing_mm = 90.0", "spacing_mm = 900.0");
    let directory = written(&[
        ("old.toml", &job("", &fine)),
        ("job.toml", &job("active_while_measuring = \"kit\"", &coarse)),
        ("errors.csv", &naked),
    ]);
    let at = directory.path();
    assert_eq!(nonius(at, "generate old.toml -o kit").status.code(), Some(0));
    std::fs::write(at.join("errors.csv"), left).unwrap();
    let forecast = &json(at, "generate job.toml -o new")["forecast"];
    let diagonals = forecast["diagonals"].as_object().unwrap();
    assert_eq!(diagonals.len(), 4);
    for diagonal in diagonals.values() {
        near("as measured", number(&diagonal["before_um"]), 0.0, LAST_DIGIT);
        let left = number(&diagonal["after_um"]);
        near("left", left, 12.0 / 3.0_f64.sqrt(), LAST_DIGIT); // a cube: cosine 1/√3
    }
}

/// Figures of a machine that has no error left, or none that is not a reversal, are zero: all of
/// them count from the reference.
#[test]
fn nothing_left_is_nothing_in_every_definition() {
    let generic = control("generic", "");
    let whole =
        format!("{HEADER}x,0,0,0,0\nx,900,5,0,0\ny,0,0,0,0\ny,400,0,0,0\nz,0,0,0,0\nz,900,0,0,0\n");
    let page = job(
        "[measurement.squareness_um_per_m]\nxy = 100.0\n[measurement.offsets_mm]\ny = 300.0",
        &generic,
    );
    let page = page.replace(
        "[machine.axes.y]\ntravel_mm = [0.0, 900.0]\nreference_mm = 0.0",
        "[machine.axes.y]\ntravel_mm = [0.0, 900.0]\nreference_mm = 900.0",
    );
    let page = page.replace("spacing_mm = 90.0", "spacing_mm = 50.0");
    let directory = written(&[("job.toml", &page), ("errors.csv", &whole)]);
    let found = json(directory.path(), "assess job.toml --with-tables");
    near("before", number(&found["definitions"]["va_um"]), 45.0, LAST_DIGIT);
    let after = &found["after"];
    for key in
        ["va_um", "proposed_um", "proposed_of_nine_um", "existing_um", "max_from_reference_um"]
    {
        near(key, number(&after["definitions"][key]), 0.0, 2.0 * LAST_DIGIT);
    }
    for part in after["contributions"].as_array().unwrap() {
        near(&part["term"].to_string(), number(&part["um"]), 0.0, 2.0 * LAST_DIGIT);
        assert_ne!(part["term"], "squareness_xy", "it is in EXY, which the table corrects");
    }

    let reversal = "axis,position_mm,ex_um,ey_um,ez_um,direction\nx,0,0,0,0,+\nx,900,0,0,0,+\nx,0,-20,0,0,-\nx,900,-20,0,0,-\ny,0,0,0,0,\ny,900,0,0,0,\nz,0,0,0,0,\nz,900,0,0,0,\n";
    let policy = control("generic", "backlash = \"mean\"");
    let directory = written(&[("job.toml", &job("", &policy)), ("errors.csv", reversal)]);
    let found = json(directory.path(), "assess job.toml --with-tables");
    for figures in [&found["definitions"], &found["after"]["definitions"]] {
        for key in ["va_um", "proposed_um", "proposed_of_nine_um", "existing_um"] {
            near(key, number(&figures[key]), 0.0, LAST_DIGIT);
        }
    }
}

/// Squareness stated, and the same slope in the table: one machine, with any offsets and tool.
#[test]
fn squareness_and_a_slope_of_the_table_are_one_machine() {
    let level = format!("{HEADER}x,0,0,0,0\nx,900,10,0,0\n{LEVEL_YZ}");
    let sloped = level.replace("z,900,0,0,0", "z,900,900,0,0");
    let without = "G54 G1 X100. Y100. Z122.4\nX300. Z50.\nM30\n";
    let with = "G54 G1 G43 H1 X100. Y100. Z10.\nG49 X300. Z50.\nM30\n";
    let tool = "[[path.tool]]\nnumber = 1\nlength_mm = 112.4\n";
    let offsets = "offsets_mm = { x = 0.0, y = 500.0, z = 700.0 }";
    let offset = "tool_offset_mm = { x = 0.0, y = 0.0, z = -100.0 }";
    for (lines, program) in [("", with), (offsets, with), (offset, without)] {
        let stated = format!("{lines}\n[measurement.squareness_um_per_m]\nxz = 1000.0");
        let directory = written(&[
            ("stated.toml", &(job(&stated, "controller = \"generic\"") + tool)),
            (
                "sloped.toml",
                &(job(lines, "controller = \"generic\"").replace("errors.csv", "sloped.csv")
                    + tool),
            ),
            ("errors.csv", &level),
            ("sloped.csv", &sloped),
            ("p.nc", program),
        ]);
        let [stated, sloped] = ["stated", "sloped"].map(|name| {
            let path = json(directory.path(), &format!("path {name}.toml p.nc"));
            (path["extremes"].clone(), path["profile_accuracy_um"].clone())
        });
        assert_eq!(stated, sloped, "{lines}");
    }
}

/// With readings and measured angles, where the resting axes are said to have stood changes the
/// curves, and assess counts its levers from the same place: the volume is the same.
#[test]
fn readings_and_levers_count_from_one_place() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals/case_c_angles");
    let page = std::fs::read_to_string(folder.join("job.toml")).unwrap();
    let directory = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, directory.path().join(path.file_name().unwrap())).unwrap();
    }
    let angles = "axis,position_mm,ea_urad,eb_urad,ec_urad\nx,0,0,0,0\nx,900,5,-8,12\ny,0,0,0,0\ny,720,-6,9,4\nz,0,0,0,0\nz,720,3,-7,2\n";
    std::fs::write(directory.path().join("angles.csv"), angles).unwrap();
    let mut found = Vec::new();
    for (reference, offsets) in [
        ("0.0000", ""),
        ("720.0", ""),
        ("720.0", "offsets_mm = { x = 0.0, y = 100.0, z = 250.0 }\n"),
    ] {
        let measured = format!("[measurement]\nangles = \"angles.csv\"\n{offsets}");
        let with = page.replace("[measurement]\n", &measured);
        let mut lines: Vec<String> = with.lines().map(ToString::to_string).collect();
        for line in lines.iter_mut().filter(|l| l.starts_with("reference_mm")).skip(1) {
            *line = format!("reference_mm = {reference}");
        }
        std::fs::write(directory.path().join("job.toml"), lines.join("\n")).unwrap();
        found.push(number(&json(directory.path(), "assess job.toml")["definitions"]["va_um"]));
    }
    assert!(found[0] > 1.0, "{found:?}");
    near("another reference", found[1], found[0], 1e-3);
    near("stated offsets", found[2], found[0], 1e-3);
}

/// Own nodes are as many as a grid may have.
#[test]
fn too_many_own_nodes_are_refused() {
    let mut errors = HEADER.to_string();
    for axis in ["x", "y", "z"] {
        for node in 0..465 {
            writeln!(errors, "{axis},{},{},0,0", f64::from(node) * 1.9, node % 7).unwrap();
        }
    }
    let directory =
        written(&[("job.toml", &job("", "controller = \"generic\"")), ("errors.csv", &errors)]);
    let refused = nonius(directory.path(), "assess job.toml");
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("465 x 465 x 465, more than 100000000"), "{said}");
}

/// Before and after are judged at the same nodes; sub-volumes need even ones.
#[test]
fn one_grid_for_before_and_after() {
    let errors = format!("{HEADER}x,0,0,0,0\nx,300,20,0,0\nx,600,-20,0,0\nx,900,0,0,0\n{LEVEL_YZ}");
    let compensation = control("generic", "").replace("90.0", "250.0");
    let directory = written(&[("job.toml", &job("", &compensation)), ("errors.csv", &errors)]);
    let found =
        json(directory.path(), "assess job.toml --with-tables --histogram 5 --window 300,900,900");
    assert_eq!(found["grid"], found["after"]["grid"]);
    assert_eq!(found["histogram"]["pairs"], found["after"]["histogram"]["pairs"]);
    assert_eq!(found["windows"]["count"], 3);
}

/// The lever of an optic on the table is added where the straightness was measured, so a finer grid
/// finds nothing new.
#[test]
fn an_optic_on_the_table_counts_where_it_was_measured() {
    let errors = "axis,position_mm,ex_um,ey_um,ez_um,ec_urad\nx,0,0,0,0,50\nx,900,0,0,0,0\ny,0,0,0,0,\ny,900,0,0,0,\nz,0,0,0,0,\nz,900,0,0,0,\n";
    let page = job("straightness_optic_mm = { x = 0.0 }", "controller = \"generic\"");
    let page = page.replace("wXYZt", "XwYZt");
    let directory = written(&[("job.toml", &page), ("errors.csv", errors)]);
    let va = ["", " --grid 21,21,2"].map(|grid| {
        let found = json(directory.path(), &format!("assess job.toml{grid}"));
        number(&found["definitions"]["va_um"])
    });
    near("own nodes and a finer grid", va[0], va[1], LAST_DIGIT);
    // ECX·y alone: the lever of X is zero at both measured positions.
    near("VA", va[0], 45.0, LAST_DIGIT);
}
