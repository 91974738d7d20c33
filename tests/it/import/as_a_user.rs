//! Imports as a user runs them: from the file of a laser to the kit that names it.

use super::*;

fn nonius(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

const IMPORT: [&str; 14] = [
    "import",
    "x.rtl",
    "-o",
    "errors.csv",
    "--term",
    "EXX",
    "--first-target-at-mm",
    "-200",
    "--targets-run",
    "+",
    "--sign",
    "as-error",
    "--material-corrected",
    "yes",
];

const JOB: &str = r#"schema = 1
[machine]
name = "Example mill"
serial = "0001"
chain = "wXYZt"
[machine.axes.x]
travel_mm = [-200.0, 200.0]
reference_mm = 0.0
[machine.axes.y]
travel_mm = [0.0, 100.0]
reference_mm = 0.0
[machine.axes.z]
travel_mm = [0.0, 100.0]
reference_mm = 0.0
[measurement]
errors = "errors.csv"
active_while_measuring = "none"
[compensation]
controller = "generic"
backlash = "two-tables"
[compensation.axes.x]
spacing_mm = 50.0
"#;

#[test]
fn an_imported_measurement_becomes_a_kit_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.rtl"), bytes(RTL)).unwrap();
    std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
    let (status, _, said) = nonius(folder.path(), &IMPORT);
    assert_eq!(status, Some(0), "{said}");
    let (status, _, said) = nonius(folder.path(), &["generate", "job.toml", "-o", "kit"]);
    assert_eq!(status, Some(0), "{said}");
    let manifest = std::fs::read(folder.path().join("kit/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    let inputs = manifest["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 3, "{inputs:?}");
    let measurement = serde_json::json!({
        "path": "x.rtl", "sha256": sha256(&bytes(RTL)), "through": "errors.csv",
    });
    assert_eq!(inputs[2], measurement);
    assert_eq!(inputs[1].get("through"), None);
    let generic = glob::glob(&format!("{}/kit/*.csv", folder.path().display())).unwrap();
    let csv: String = generic.map(|path| std::fs::read_to_string(path.unwrap()).unwrap()).collect();
    // Moving + at -200 mm: 0.5 µm, at the reference 3.1 µm.
    assert!(csv.contains("EXX,x,x,+,0,-200,-2.6,2.6,"), "{csv}");
}

#[test]
fn three_files_of_a_laser_become_one_job() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    std::fs::write(inside("x.rtl"), bytes(RTL)).unwrap();
    for (name, axis) in [("y.csv", "Y"), ("z.csv", "Z")] {
        let text = format!(
            "# source: {name}.dat sha256 {}\naxis,position_mm,e{a}_um\n{a},0,0\n{a},100,1\n",
            "a".repeat(64),
            a = axis.to_lowercase()
        );
        std::fs::write(inside(name), text).unwrap();
    }
    let job =
        JOB.replace("errors = \"errors.csv\"", "errors = [\"errors.csv\", \"y.csv\", \"z.csv\"]");
    let spaced =
        "[compensation.axes.y]\nspacing_mm = 50.0\n[compensation.axes.z]\nspacing_mm = 50.0\n";
    std::fs::write(inside("job.toml"), format!("{job}{spaced}")).unwrap();
    let (status, _, said) = nonius(folder.path(), &IMPORT);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("errors = [\"x.csv\", \"y.csv\"]"), "{said}");
    let (status, _, said) = nonius(folder.path(), &["generate", "job.toml", "-o", "kit"]);
    assert_eq!(status, Some(0), "{said}");
    let manifest = std::fs::read(inside("kit/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    let names: Vec<&str> = manifest["inputs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|input| input["path"].as_str().unwrap())
        .collect();
    let tables = ["errors.csv", "x.rtl", "y.csv", "y.csv.dat", "z.csv", "z.csv.dat"];
    assert_eq!(names, [&["job.toml"], &tables[..]].concat());
    let terms = manifest["forecast"]["terms"].as_object().unwrap();
    assert_eq!(terms.keys().collect::<Vec<_>>(), ["EXX", "EYY", "EZZ"]);
}

#[test]
fn an_imported_linear_measurement_beside_readings_is_named_in_the_manifest() {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals/case_b_setup");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(case).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let linear = format!(
        "# source: linear.rtl sha256 {}\naxis,position_mm,ex_um\nx,0,0\nx,900,18\n",
        "b".repeat(64)
    );
    std::fs::write(folder.path().join("x-linear.csv"), linear).unwrap();
    let job = std::fs::read_to_string(folder.path().join("job.toml")).unwrap();
    let at = job.find("slope_um_per_m").unwrap();
    let end = at + job[at..].find('\n').unwrap();
    let job = format!("{}errors = \"x-linear.csv\"{}", &job[..at], &job[end..]);
    std::fs::write(folder.path().join("job.toml"), job).unwrap();
    let (status, _, said) = nonius(folder.path(), &["generate", "job.toml", "-o", "kit"]);
    assert_ne!(status, Some(2), "{said}");
    let manifest = std::fs::read_to_string(folder.path().join("kit/manifest.json")).unwrap();
    assert!(manifest.contains("\"through\": \"x-linear.csv\""), "{manifest}");
}

#[test]
fn an_existing_table_is_replaced_only_when_forced() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.rtl"), bytes(RTL)).unwrap();
    std::fs::write(folder.path().join("errors.csv"), "mine\n").unwrap();
    let read = || std::fs::read_to_string(folder.path().join("errors.csv")).unwrap();
    assert_eq!(nonius(folder.path(), &IMPORT).0, Some(2));
    assert_eq!(read(), "mine\n");
    let forced = [&IMPORT[..], &["--force", "--format", "json"]].concat();
    let (status, out, said) = nonius(folder.path(), &forced);
    assert_eq!(status, Some(0), "{said}");
    assert!(read().starts_with("# source: x.rtl sha256 "));
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(document["schema"], 1);
    assert_eq!(document["series"][1]["direction"], "-");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let mut to_stdout = IMPORT;
    to_stdout[3] = "-";
    assert_eq!(nonius(folder.path(), &to_stdout).1, read());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A deviation belongs to the target that its line names.
    #[test]
    fn the_order_of_the_lines_does_not_matter(keys in proptest::collection::vec(any::<u32>(), 36)) {
        let text = String::from_utf8(bytes(RTL)).unwrap();
        let (head, rest) = text.split_once("Run Target Data:\r\n").unwrap();
        let (lines, tail) = rest.split_once("\r\n\r\n").unwrap();
        let mut lines: Vec<&str> = lines.split("\r\n").collect();
        prop_assert_eq!(lines.len(), keys.len());
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.sort_by_key(|index| keys[*index]);
        lines = order.into_iter().map(|index| lines[index]).collect();
        let shuffled = format!("{head}Run Target Data:\r\n{}\r\n\r\n{tail}", lines.join("\r\n"));
        let stated = rtl_laser(-200.0, Direction::Plus);
        prop_assert_eq!(
            rows(&table(RTL, shuffled.as_bytes(), &stated)),
            rows(&table(RTL, &bytes(RTL), &stated))
        );
    }
}
