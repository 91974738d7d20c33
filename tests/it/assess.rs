//! `nonius assess`: machine H to the digits, the tables of paper 000, before and after.

use crate::support::run::nonius;
use nonius::inputs::error_table::ErrorTable;
use nonius::inputs::job::Job;
use nonius::machine::model::ErrorModel;
use nonius::quantity::axis::{Axis, ErrorTerm, PerTerm};
use nonius::text::document::Source;
use nonius::volume::definitions::ByComponent;
use nonius::volume::space::cloud::longest;
use nonius::volume::volume_model::VolumeModel;
use serde_json::Value;
use std::path::Path;

fn fixtures(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
}

fn json(directory: &Path, arguments: &str) -> Value {
    let output = nonius(directory, &format!("{arguments} --format json"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

fn page(directory: &Path, arguments: &str) -> String {
    let output = nonius(directory, &format!("{arguments} --explain"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn assert_near(what: &str, got: &Value, want: f64, room: f64) {
    let got = got.as_f64().unwrap_or_else(|| panic!("{what} is missing"));
    assert!((got - want).abs() <= room, "{what}: {got}, expected {want}");
}

/// The last digit that the document holds.
const LAST_DIGIT: f64 = 1.001e-6;

#[test]
fn machine_h_has_the_figures_of_its_authority() {
    let folder = fixtures("machine_h");
    let expected: Value =
        serde_json::from_slice(&std::fs::read(folder.join("expected.json")).unwrap()).unwrap();
    let found = json(&folder, "assess job.toml --window 6000,2000,1000");
    assert_eq!(found["grid"], expected["grid"]);
    assert_eq!(found["frame"], "as given");
    let definitions = &found["definitions"];
    for key in ["va_um", "box_um", "length_um", "max_from_reference_um", "proposed_um"] {
        assert_near(key, &definitions[key], expected[key].as_f64().unwrap(), LAST_DIGIT);
    }
    for (index, range) in expected["ranges_um"].as_array().unwrap().iter().enumerate() {
        assert_near("range", &definitions["ranges_um"][index], range.as_f64().unwrap(), LAST_DIGIT);
    }
    for (place, want) in expected["va_pair_mm"].as_array().unwrap().iter().enumerate() {
        for (axis, mm) in want.as_array().unwrap().iter().enumerate() {
            assert_near("pair", &definitions["va_pair_mm"][place][axis], mm.as_f64().unwrap(), 0.0);
        }
    }
    let windows = &expected["windows_6x2x1_m"];
    for key in ["min_um", "max_um", "corner_um"] {
        assert_near(key, &found["windows"][key], windows[key].as_f64().unwrap(), LAST_DIGIT);
    }
    assert_eq!(found["windows"]["min_at_mm"], serde_json::json!([6000.0, 2000.0, 1000.0]));
    let parts = found["contributions"].as_array().unwrap();
    let part = |name: &str| parts.iter().find(|p| p["term"] == name).unwrap();
    for (key, column) in [("contributions_um", "um"), ("va_without_um", "va_without_um")] {
        for (name, um) in expected[key].as_object().unwrap() {
            assert_near(name, &part(name)[column], um.as_f64().unwrap(), 0.000_501);
        }
    }
    let sum: f64 = parts.iter().map(|p| p["um"].as_f64().unwrap()).sum();
    assert!((sum - 1_149.980_852).abs() < 3e-5, "{sum}");
}

/// The same machine aligned differently: VA follows the frame, the length error does not.
#[test]
fn machine_h_in_other_frames() {
    let folder = fixtures("machine_h");
    let read =
        |name: &str| Source::from_bytes(name, &std::fs::read(folder.join(name)).unwrap()).unwrap();
    let job = Job::read(read("job.toml")).unwrap();
    let model = ErrorModel::build(&job, &ErrorTable::read(read("errors.csv")).unwrap()).unwrap();
    let volume = VolumeModel::build(&job, &model).unwrap();
    let map = volume.map(&volume.own_nodes()).unwrap();
    let turned = |from: (Axis, Axis), slope: f64| {
        let (of, along) = from;
        let vectors: Vec<[f64; 3]> = map
            .points()
            .map(|(place, mut e)| {
                e[of] -= slope * place[along] / 1000.0;
                e[along] += slope * place[of] / 1000.0;
                [e.x, e.y, e.z]
            })
            .collect();
        longest(&vectors).unwrap().um()
    };
    let as_given = turned((Axis::X, Axis::Y), 0.0);
    assert!((as_given - 1_149.980_851_990).abs() < 1e-6, "{as_given}");
    let xy = turned((Axis::X, Axis::Y), -77.0);
    assert!((xy - 1_281.844_366_5).abs() < 1e-6, "{xy}");
    let xz = turned((Axis::X, Axis::Z), 181.0);
    assert!((xz - 2_243.642_669_4).abs() < 1e-6, "{xz}");
}

/// The corner pair is the worst one on every grid whose nodes hold the corners.
#[test]
fn machine_h_keeps_its_figure_on_other_grids() {
    let folder = fixtures("machine_h");
    for grid in ["2,2,2", "25,17,13", "21,21,21"] {
        let found = json(&folder, &format!("assess job.toml --grid {grid}"));
        assert_near(grid, &found["definitions"]["va_um"], 1_149.980_852, LAST_DIGIT);
    }
    let histogram = &json(&folder, "assess job.toml --histogram 50")["histogram"];
    let counts = histogram["counts"].as_array().unwrap();
    let sum: u64 = counts.iter().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!((sum, counts.len()), (819 * 818 / 2, 23), "1149.98 µm lies in bin 22");
    assert_eq!(histogram["exact"], true);
}

/// Columns of paper 000 in its own order; D‹moving›‹direction›, so DYX is EXY. Read the other way
/// round its own sums (DX max 0.03106) cannot be had.
const COLUMNS: [&str; 9] = ["EXX", "EYX", "EZX", "EYY", "EXY", "EZY", "EZZ", "EXZ", "EYZ"];

fn by_component(min: [f64; 9], max: [f64; 9]) -> ByComponent {
    let mut extremes = PerTerm::from_fn(|_: ErrorTerm| None);
    for (index, name) in COLUMNS.iter().enumerate() {
        extremes[ErrorTerm::from_name(name).unwrap()] = Some((min[index], max[index]));
    }
    ByComponent::of(&extremes)
}

fn near(got: Option<f64>, want: f64, room: f64) {
    let got = got.expect("all nine are there");
    assert!((got - want).abs() <= room, "{got}, expected {want}");
}

/// Paper 000, example 1 (mm): printed figures beside those that its own rows give.
#[test]
fn example_1_of_paper_000() {
    let max = [
        0.013_632, 0.007_299, 0.008_677, 0.036_034, 0.002_505, 0.002_594, 0.004_117, 0.014_923,
        0.001_638,
    ];
    let min = [
        -0.003_73, 0.0, -0.008_93, -0.005_59, -0.014_55, -0.025_81, -0.008_09, -0.009_26, -0.006_76,
    ];
    let found = by_component(min, max);
    near(found.existing, 0.077_858_511, 1e-9);
    near(found.proposed, 0.109_175_844, 1e-9);
    near(found.elv, 0.046_722_663, 1e-9);
    near(found.elsv, 0.100_543_486, 1e-9);
    // Printed: 0.109176, and 0.077857 in the table but 0.077856 in the text (0.0778585 from its rows).
    near(found.proposed, 0.109_176, 5e-7);
    near(found.existing, 0.077_857, 2e-6);
    near(found.proposed.zip(found.existing).map(|(new, old)| new / old), 1.402_233_909, 1e-8);
}

/// Paper 000, example 2 (inch): three minima are printed without their minus signs.
#[test]
fn example_2_of_paper_000() {
    let max =
        [0.000_484, 0.000_316, 0.000_039, -6e-7, 2.2e-6, 0.000_201, 0.000_179, 6.2e-6, 0.000_056];
    let printed =
        [0.000_651, -1.3e-5, -0.000_5, 0.000_44, -0.001_89, 0.0, -0.000_3, 0.001_12, -0.000_4];
    let mut min = printed;
    for lost in [0, 3, 7] {
        min[lost] = -min[lost];
    }
    let found = by_component(min, max);
    near(found.existing, 0.003_079_338, 1e-9);
    near(found.existing, 0.003_084, 6e-6);
    near(found.proposed, 0.004_595, 7e-6);
    near(found.proposed.zip(found.existing).map(|(new, old)| new / old), 1.49, 0.005);
    let as_printed = by_component(printed, max);
    assert!((as_printed.proposed.unwrap() - 0.004_595).abs() > 0.001, "the signs were lost");
}

/// With every error tabled and the control's grid on the measured nodes nothing but rounding is
/// left; what the tables cannot hold (angles) stays.
#[test]
fn the_tables_take_off_what_they_hold() {
    let found = json(&fixtures("start/errors"), "assess job.toml --with-tables");
    let (before, after) = (&found["definitions"], &found["after"]["definitions"]);
    assert!(before["va_um"].as_f64().unwrap() > 14.0);
    assert!(after["va_um"].as_f64().unwrap() < 0.02, "{after}");
    assert_eq!(found["after"]["disagreements"], serde_json::json!([]));
    assert_eq!(found["missing"].as_array().unwrap().len(), 5);

    let directory = tempfile::tempdir().unwrap();
    let folder = fixtures("machine_h");
    let job = std::fs::read_to_string(folder.join("job.toml")).unwrap();
    let axes = "\n[compensation.axes.x]\nspacing_mm = 1000.0\n[compensation.axes.y]\nspacing_mm = 500.0\n[compensation.axes.z]\nspacing_mm = 200.0\n[limits]\nmax_correction_um = 2000.0\n";
    let errors = std::fs::read_to_string(folder.join("errors.csv")).unwrap();
    std::fs::write(directory.path().join("job.toml"), format!("{job}{axes}")).unwrap();
    std::fs::write(directory.path().join("errors.csv"), &errors).unwrap();
    let kit = nonius(directory.path(), "generate job.toml -o kit");
    assert_eq!(kit.status.code(), Some(0), "{}", String::from_utf8_lossy(&kit.stderr));
    let found = json(directory.path(), "assess job.toml --tables kit");
    // The angles alone: deviations and squareness struck out of the same table.
    let alone: String = errors
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            match cells.as_slice() {
                [axis @ ("x" | "y" | "z"), at, _, _, _, a, b, c] => {
                    format!("{axis},{at},0,0,0,{a},{b},{c}\n")
                }
                _ => format!("{line}\n"),
            }
        })
        .collect();
    std::fs::write(directory.path().join("errors.csv"), alone).unwrap();
    let without_squareness: String = job
        .lines()
        .filter(|line| {
            !line.starts_with("xy =") && !line.starts_with("xz =") && !line.starts_with("yz =")
        })
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(directory.path().join("angles.toml"), without_squareness).unwrap();
    let angles = json(directory.path(), "assess angles.toml");
    let (left, alone) = (&found["after"]["definitions"]["va_um"], &angles["definitions"]["va_um"]);
    // Z nodes of the table (200 mm) are not those of the measurement (333.3 mm): between them a
    // table of straight lines leaves a little.
    assert_near("what is left", left, alone.as_f64().unwrap(), 3.0);
    assert!(left.as_f64().unwrap() > 60.0, "{left}");
}

/// The diagonals of a machine of nine errors are those of the forecast, which finds them in
/// another way.
#[test]
fn the_diagonals_agree_with_the_forecast() {
    let folder = fixtures("start/errors");
    let directory = tempfile::tempdir().unwrap();
    for name in ["job.toml", "errors.csv"] {
        std::fs::copy(folder.join(name), directory.path().join(name)).unwrap();
    }
    let manifest = json(directory.path(), "generate job.toml -o kit");
    let found = json(directory.path(), "assess job.toml --tables kit");
    for name in ["PPP", "NPP", "PNP", "PPN"] {
        let forecast = &manifest["forecast"]["diagonals"][name];
        assert_near(
            name,
            &found["definitions"]["diagonals_um"][name],
            forecast["before_um"].as_f64().unwrap(),
            LAST_DIGIT,
        );
        assert_near(
            name,
            &found["after"]["definitions"]["diagonals_um"][name],
            forecast["after_um"].as_f64().unwrap(),
            LAST_DIGIT,
        );
    }
}

/// Angles may stand in a table of their own; both ways are the same machine.
#[test]
fn angles_of_their_own_table_are_read() {
    let folder = fixtures("machine_h");
    let directory = tempfile::tempdir().unwrap();
    let table = std::fs::read_to_string(folder.join("errors.csv")).unwrap();
    let columns = |keep: &[usize]| -> String {
        let rows = table.lines().filter(|line| !line.starts_with('#'));
        let cut = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            keep.iter().map(|k| cells[*k]).collect::<Vec<_>>().join(",") + "\n"
        };
        rows.map(cut).collect()
    };
    let job = std::fs::read_to_string(folder.join("job.toml")).unwrap();
    let job =
        job.replace("errors = \"errors.csv\"", "errors = \"errors.csv\"\nangles = \"angles.csv\"");
    let put = |name: &str, text: String| std::fs::write(directory.path().join(name), text).unwrap();
    put("job.toml", job);
    put("errors.csv", columns(&[0, 1, 2, 3, 4]));
    put("angles.csv", columns(&[0, 1, 5, 6, 7]));
    let (apart, whole) =
        (json(directory.path(), "assess job.toml"), json(&folder, "assess job.toml"));
    assert_eq!(apart["definitions"], whole["definitions"]);
    assert_eq!(apart["contributions"], whole["contributions"]);
}

/// A zero of the angles that the squareness was not measured with makes another machine.
#[test]
fn angles_can_be_zeroed_where_the_squareness_was_measured() {
    let folder = fixtures("machine_h");
    let directory = tempfile::tempdir().unwrap();
    std::fs::copy(folder.join("errors.csv"), directory.path().join("errors.csv")).unwrap();
    let job = std::fs::read_to_string(folder.join("job.toml")).unwrap();
    let job =
        job.replace("[compensation]", "[measurement.angles_zero_mm]\nx = 0.0\n\n[compensation]");
    std::fs::write(directory.path().join("job.toml"), job).unwrap();
    let found = json(directory.path(), "assess job.toml");
    // By a program of its own: all angles less their value at 0.
    assert_near("VA", &found["definitions"]["va_um"], 1_148.470_874, LAST_DIGIT);
    let page = page(directory.path(), "assess job.toml");
    assert!(page.contains("angles of X count from 0 mm"), "{page}");
}

#[test]
fn the_page_of_a_small_machine() {
    let found = page(
        &fixtures("start/errors"),
        "assess job.toml --with-tables --window 100,100,50 --histogram 5",
    );
    insta::assert_snapshot!(found);
}
