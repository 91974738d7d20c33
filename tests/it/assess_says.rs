//! What `nonius assess` says of its figures: what they hold for, what they rest on, what was not
//! measured.

use crate::support::run::nonius;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn page(directory: &Path, arguments: &str) -> String {
    screen(directory, &format!("{arguments} --explain"))
}

fn screen(directory: &Path, arguments: &str) -> String {
    let output = nonius(directory, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn document(directory: &Path, arguments: &str) -> Value {
    serde_json::from_str(&page(directory, &format!("{arguments} --format json"))).unwrap()
}

fn fixtures(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
}

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(directory.path().join(name), text).unwrap();
    }
    directory
}

/// A job for a cube of 300 mm, without anything for a control.
const CUBE: &str = "schema = 1
[machine]
name = \"cube\"
chain = \"wXYZt\"
[machine.axes.x]
travel_mm = [0.0, 300.0]
reference_mm = 0.0
[machine.axes.y]
travel_mm = [0.0, 300.0]
reference_mm = 0.0
[machine.axes.z]
travel_mm = [0.0, 300.0]
reference_mm = 0.0
[measurement]
errors = \"errors.csv\"
active_while_measuring = \"none\"
";

fn um(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn has_label(found: &Value, words: &str) -> bool {
    let labels = found["labels"].as_array().unwrap();
    labels.iter().any(|label| label.as_str().unwrap().contains(words))
}

/// Three axes that rise to 30 µm at 100 and 200 mm: a spline overshoots between them.
const HUMPS: &str = "axis,position_mm,ex_um,ey_um,ez_um
x,0,0,0,0
x,100,10,10,10
x,200,10,10,10
x,300,0,0,0
y,0,0,0,0
y,100,10,10,10
y,200,10,10,10
y,300,0,0,0
z,0,0,0,0
z,100,10,10,10
z,200,10,10,10
z,300,0,0,0
";

#[test]
fn the_volume_is_claimed_only_where_no_place_is_worse() {
    let spline =
        format!("{CUBE}[compensation]\ncontroller = \"generic\"\ncurve = \"natural-spline\"\n");
    let jobs = folder(&[("job.toml", CUBE), ("spline.toml", &spline), ("errors.csv", HUMPS)]);
    let exact = |arguments: &str| {
        let found = document(jobs.path(), arguments);
        let d = &found["definitions"];
        (um(&d["va_um"]), d["va_exact"].as_bool().unwrap())
    };
    // √3 · 30 at the nodes; the spline reaches more in the middle.
    assert_eq!(exact("assess job.toml"), (51.961_524, true));
    assert_eq!(exact("assess job.toml --grid 7,7,7"), (51.961_524, true));
    assert_eq!(exact("assess job.toml --grid 2,2,2"), (0.0, false));
    assert_eq!(exact("assess spline.toml"), (51.961_524, false));
    let (finer, claimed) = exact("assess spline.toml --grid 31,31,31");
    assert!(finer > 59.7 && !claimed, "{finer}");
    let said = page(jobs.path(), "assess spline.toml");
    assert!(said.contains("51.962 µm: no two of these nodes differ by more"), "{said}");
    let said = page(jobs.path(), "assess job.toml");
    assert!(said.contains("51.962 µm: no two places of the volume differ by more"), "{said}");
}

#[test]
fn a_separation_keeps_its_labels_and_its_frame() {
    let found = document(&fixtures("diagonals/case_d_bidirectional"), "assess job.toml");
    assert_eq!(found["frame"], "as-measured");
    assert!(has_label(&found, "set-up assumed perfect"), "{}", found["labels"]);
    assert!(has_label(&found, "a reversal of about"), "{}", found["labels"]);
    let found = document(&fixtures("start/readings"), "assess job.toml");
    assert_eq!(found["frame"], "x-primary");
    let said = page(&fixtures("start/readings"), "assess job.toml");
    assert!(said.contains("frame: X primary, XY plane secondary"), "{said}");
    assert!(!said.contains("nothing was rotated"), "{said}");
}

/// A small rotation of the machine's frame changes VA and not what the page says to stay.
#[test]
fn a_turned_datum_leaves_what_the_page_says_to_stay() {
    let start = fixtures("start/errors");
    let table = std::fs::read_to_string(start.join("errors.csv")).unwrap();
    // e + ω × p, ω = (30, -20, 40) µrad.
    let turned: String = table
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let [axis @ ("x" | "y" | "z"), at, ex, ey, ez] = cells[..] else {
                return format!("{line}\n");
            };
            let number = |cell: &str| cell.parse::<f64>().unwrap();
            let m = number(at) / 1000.0;
            let added = match axis {
                "x" => [0.0, 40.0 * m, 20.0 * m],
                "y" => [-40.0 * m, 0.0, 30.0 * m],
                _ => [-20.0 * m, -30.0 * m, 0.0],
            };
            let [x, y, z] = [ex, ey, ez].map(number);
            format!("{axis},{at},{},{},{}\n", x + added[0], y + added[1], z + added[2])
        })
        .collect();
    let job = std::fs::read_to_string(start.join("job.toml")).unwrap();
    let turned = folder(&[("job.toml", &job), ("errors.csv", &turned)]);
    let (one, other) =
        (document(&start, "assess job.toml"), document(turned.path(), "assess job.toml"));
    let both = |key: &str| (um(&one["definitions"][key]), um(&other["definitions"][key]));
    let change = |key: &str| {
        let (a, b) = both(key);
        (a - b).abs()
    };
    for key in ["va_um", "box_um", "elsv_um", "existing_um", "proposed_um"] {
        assert!(change(key) > 0.1, "{key}: {:?}", both(key));
    }
    assert!(change("elv_um") < 2e-6, "{:?}", both("elv_um"));
    // To second order: 50 µrad of 10 µm, and 50² µrad² of half a metre.
    assert!(change("length_um") < 2e-3, "{:?}", both("length_um"));
    for name in ["PPP", "NPP", "PNP", "PPN"] {
        let range = |of: &Value| um(&of["definitions"]["diagonals_um"][name]);
        assert!((range(&one) - range(&other)).abs() < 2e-6, "{name}");
    }
}

#[test]
fn tables_that_were_active_are_part_of_the_machine_as_measured() {
    let start = fixtures("start/errors");
    let job = std::fs::read_to_string(start.join("job.toml")).unwrap();
    let table = std::fs::read_to_string(start.join("errors.csv")).unwrap();
    let after =
        job.replace("active_while_measuring = \"none\"", "active_while_measuring = \"kit\"");
    let silent = job.replace("active_while_measuring = \"none\"", "");
    let jobs = folder(&[
        ("job.toml", &job),
        ("errors.csv", &table),
        ("after.toml", &after.replace("errors.csv", "residual.csv")),
        ("silent.toml", &silent),
        (
            "residual.csv",
            "axis,position_mm,ex_um,ey_um,ez_um\nx,0,0,0,0\nx,400,1,0,0\ny,0,0,0,0\ny,300,0,0,0\nz,-200,0,0,0\nz,0,0,0,0\n",
        ),
    ]);
    page(jobs.path(), "generate job.toml -o kit");
    let found = document(jobs.path(), "assess after.toml");
    assert_eq!(found["active"]["tables"], "kit");
    assert_eq!(um(&found["definitions"]["va_um"]), 1.0);
    assert!(um(&found["active"]["va_without_um"]) > 14.0, "{}", found["active"]);
    let said = page(jobs.path(), "assess after.toml");
    assert!(
        said.contains("as measured, with the tables of `kit` active; without any tables"),
        "{said}"
    );
    let found = document(jobs.path(), "assess silent.toml");
    assert!(has_label(&found, "`active_while_measuring` is not stated"));
    assert_eq!(found["active"], Value::Null);
}

#[test]
fn places_that_levers_depend_on_are_named() {
    let more = format!(
        "{CUBE}tool_offset_mm = {{ x = 0.0, y = 0.0, z = -120.5 }}\noffsets_mm = {{ x = 4000.0, y = 100.0 }}\n"
    );
    let jobs = folder(&[("job.toml", &more), ("errors.csv", HUMPS)]);
    let found = document(jobs.path(), "assess job.toml");
    assert_eq!(found["tool_offset_mm"], json!([0.0, 0.0, -120.5]));
    assert_eq!(found["offsets_mm"], json!({"x": 4000.0, "y": 100.0, "z": null}));
    assert_eq!(found["volume_mm"]["y"], json!([0.0, 300.0]));
    assert!(has_label(&found, "does not reach: X 4000 mm"), "{}", found["labels"]);
    let said = page(jobs.path(), "assess job.toml");
    assert!(said.contains("tool offset (0, 0, -120.5) mm; offsets X 4000, Y 100 mm"), "{said}");
}

#[test]
fn what_was_not_measured_is_no_error_of_nothing() {
    let table = "axis,position_mm,ex_um,ez_um,ea_urad,eb_urad,ec_urad\nx,0.1,0,0,5,20,10\nx,900.25,10,1,5,20,30\n";
    let jobs =
        folder(&[("x.csv", table), ("angles.csv", "axis,position_mm,ec_urad\nx,0,0\nx,100,9\n")]);
    let found = document(jobs.path(), "assess x.csv --chain wXYZt");
    assert_eq!(found["errors_measured"], 5);
    let ranges = &found["definitions"]["ranges_um"];
    assert_eq!(*ranges, json!([10.0, null, 1.0]));
    assert_eq!(found["volume_mm"]["y"], Value::Null);
    let said = page(jobs.path(), "assess x.csv --chain wXYZt");
    for words in [
        "volume X 0.1 … 900.25 mm, Y not measured and its travel not stated, Z not measured",
        "5 of the 21 errors were measured",
        "range Y       not measured",
        "angles measured and not counted: EAX, EBX, ECX; the travel of Y, Z, their lever, is not stated",
    ] {
        assert!(said.contains(words), "{words}\n{said}");
    }
    // Angles alone make a figure where their levers are known.
    let alone = folder(&[
        ("job.toml", CUBE),
        ("errors.csv", "axis,position_mm,ec_urad\nx,0,0\nx,300,100\n"),
    ]);
    let found = document(alone.path(), "assess job.toml");
    assert_eq!(um(&found["definitions"]["va_um"]), 30.0, "100 µrad of 300 mm");
}

#[test]
fn bins_that_no_drawn_pair_hit_are_unknown() {
    let found = document(&fixtures("machine_h"), "assess job.toml --grid 45,45,45 --histogram 1");
    let histogram = &found["histogram"];
    assert_eq!(histogram["exact"], false);
    let counts = histogram["counts"].as_array().unwrap();
    let errors = histogram["standard_errors"].as_array().unwrap();
    assert_eq!(counts.len(), 1150, "1149.98 µm lies in bin 1149");
    assert!(um(&counts[1149]) >= 1.0, "the last bin holds the largest difference");
    assert!(counts.iter().any(Value::is_null), "no drawn pair fell there");
    for (count, error) in counts.iter().zip(errors) {
        assert!(count.as_f64() != Some(0.0) && error.as_f64() != Some(0.0));
    }
    let said = page(&fixtures("machine_h"), "assess job.toml --grid 45,45,45 --histogram 1");
    assert!(said.contains("no drawn pair fell there"), "{said}");
}

#[test]
fn the_map_of_sub_volumes_holds_the_extremes() {
    let found =
        document(&fixtures("machine_h"), "assess job.toml --window 6000,2000,1000 --grouping 0.1");
    let windows = &found["windows"];
    let map = &windows["map"];
    let [x, y, z] = ["x_mm", "y_mm", "z_mm"].map(|key| map[key].as_array().unwrap());
    assert_eq!((x.len(), y.len(), z.len()), (7, 5, 4));
    let mut all = Vec::new();
    for (i, _) in x.iter().enumerate() {
        for (j, _) in y.iter().enumerate() {
            for (k, _) in z.iter().enumerate() {
                all.push((um(&map["um"][i][j][k]), json!([x[i], y[j], z[k]])));
            }
        }
    }
    assert_eq!(all.len(), 140);
    let worst = all.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert_eq!(worst.0, um(&windows["max_um"]));
    assert_eq!(worst.1, windows["max_at_mm"]);
    assert_eq!(all[0].0, um(&windows["corner_um"]));
    // docs/volumetric.md §9: with another zero of the squareness 240.
    let grouping = &found["grouping"];
    assert_eq!(grouping["records"], 168);
    assert_eq!(grouping["exact"], false);
    assert!(um(&grouping["um"]) <= um(&found["definitions"]["va_um"]));
}

#[test]
fn figures_need_neither_a_control_nor_a_backlash_policy() {
    let both = "axis,position_mm,direction,ex_um\nx,0,+,0\nx,300,+,10\nx,0,-,-2\nx,300,-,8\n";
    let jobs = folder(&[("job.toml", CUBE), ("errors.csv", both)]);
    let found = document(jobs.path(), "assess job.toml");
    assert_eq!(um(&found["definitions"]["va_um"]), 10.0);
    assert!(has_label(&found, "the mean of both counts"), "{}", found["labels"]);
    let refused = nonius(jobs.path(), "generate job.toml -o kit");
    assert_eq!(refused.status.code(), Some(2), "tables need a control");
}

#[test]
fn slips_of_the_unit_are_doubted() {
    let job = format!("{CUBE}[measurement.squareness_um_per_m]\nxy = 5001.0\n");
    let table = "axis,position_mm,ex_mm,ey_um\nx,0,0,0\nx,300,5.1,4999\ny,0,0,0\ny,300,0,0\n";
    let jobs = folder(&[("job.toml", &job), ("errors.csv", table)]);
    let found = document(jobs.path(), "assess job.toml");
    assert!(
        has_label(&found, "doubt: EXX reaches 5100 µm, and more than 5000 µm is unlikely"),
        "{}",
        found["labels"]
    );
    assert!(has_label(&found, "doubt: squareness_xy reaches 5001 µm/m"));
    assert!(!has_label(&found, "EYX reaches"));
}

/// Machine H in full, small enough to be checked against the authority in `expected.json`.
#[test]
fn the_page_and_the_document_of_machine_h() {
    let folder = fixtures("machine_h");
    insta::assert_snapshot!("machine_h_page", screen(&folder, "assess job.toml"));
    insta::assert_snapshot!("machine_h_document", page(&folder, "assess job.toml --format json"));
}

/// The job of docs/volumetric.md runs as it stands.
#[test]
fn the_job_of_the_documentation_is_complete() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/volumetric.md");
    let text = std::fs::read_to_string(path).unwrap();
    let (_, rest) = text.split_once("```toml\n").expect("there is a job");
    let (job, _) = rest.split_once("```").expect("it ends");
    let table = "axis,position_mm,ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad
x,0,0,0,0,0,0,0
x,800,8,1,2,5,-4,3
y,0,0,0,0,0,0,0
y,500,1,6,0,2,1,0
z,-450,-3,2,-4,1,1,1
z,0,0,0,0,0,0,0
";
    let jobs = folder(&[("job.toml", job), ("errors.csv", table)]);
    let found =
        document(jobs.path(), "assess job.toml --grid 17,11,10 --window 300,200,200 --histogram 5");
    assert_eq!(found["errors_measured"], 21);
    assert_eq!(found["missing"], json!([]));
    assert_eq!(found["definitions"]["va_exact"], true);
}
