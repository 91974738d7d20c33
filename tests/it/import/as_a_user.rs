//! Imports as a user runs them: from the file of a laser to the kit that names it.

use super::*;
use crate::support::Visit;

const IMPORT: &str = "import x.rtl --term EXX --first-target-at-mm -200 --targets-run + \
    --sign as-error --material-corrected yes";

const JOB: &str = "schema = 1\n[machine]\nname = \"Example mill\"\nserial = \"0001\"\nchain = \"wXYZt\"\n\
    axes.x = { travel_mm = [-200.0, 200.0], reference_mm = 0.0 }\n\
    axes.y = { travel_mm = [0.0, 100.0], reference_mm = 0.0 }\n\
    axes.z = { travel_mm = [0.0, 100.0], reference_mm = 0.0 }\n\
    [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n\
    [compensation]\ncontroller = \"generic\"\nbacklash = \"two-tables\"\n\
    [compensation.axes.x]\nspacing_mm = 50.0\n";

fn visit() -> Visit {
    let visit = Visit::new();
    visit.put("x.rtl", file(RTL)).put("job.toml", JOB);
    visit
}

#[test]
fn an_imported_measurement_becomes_a_kit_that_names_it() {
    let visit = visit();
    visit.yes(&format!("{IMPORT} -o errors.csv"));
    visit.yes("generate job.toml -o kit");
    let manifest = visit.document("kit/manifest.json");
    let inputs = manifest["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 3, "{inputs:?}");
    let measurement = serde_json::json!({
        "path": "x.rtl", "sha256": sha256(file(RTL).as_bytes()), "through": "errors.csv",
    });
    assert_eq!(inputs[2], measurement);
    assert_eq!(inputs[1].get("through"), None);
    let csv = visit.read("kit/compensation.csv");
    // Moving + at -200 mm: 0.5 µm, at the reference 3.1 µm.
    assert!(csv.contains("EXX,x,x,+,0,-200,-2.6,2.6,"), "{csv}");
}

#[test]
fn three_files_of_a_laser_become_one_job() {
    let visit = visit();
    let mut job = replaced(JOB, "\"errors.csv\"", "[\"errors.csv\", \"y.csv\", \"z.csv\"]");
    for a in ["y", "z"] {
        let hash = "a".repeat(64);
        let text = format!("axis,position_mm,e{a}_um\n{a},0,0\n{a},100,1\n");
        visit.put(&format!("{a}.csv"), format!("# source: {a}.csv.dat sha256 {hash}\n{text}"));
        job += &format!("[compensation.axes.{a}]\nspacing_mm = 50.0\n");
    }
    visit.put("job.toml", job);
    visit.run(&format!("{IMPORT} -o errors.csv")).ends(0).says("errors = [\"x.csv\", \"y.csv\"]");
    visit.yes("generate job.toml -o kit");
    let manifest = visit.document("kit/manifest.json");
    let inputs = manifest["inputs"].as_array().unwrap().iter();
    let names: Vec<&str> = inputs.map(|input| input["path"].as_str().unwrap()).collect();
    let tables = ["errors.csv", "x.rtl", "y.csv", "y.csv.dat", "z.csv", "z.csv.dat"];
    assert_eq!(names, [&["job.toml"], &tables[..]].concat());
    let terms = manifest["forecast"]["terms"].as_object().unwrap();
    assert_eq!(terms.keys().collect::<Vec<_>>(), ["EXX", "EYY", "EZZ"]);
}

#[test]
fn an_imported_linear_measurement_beside_readings_is_named_in_the_manifest() {
    let visit = Visit::of("diagonals/case_b_setup");
    let hash = "b".repeat(64);
    let text = "axis,position_mm,ex_um\nx,0,0\nx,900,18\n";
    visit.put("x-linear.csv", format!("# source: linear.rtl sha256 {hash}\n{text}"));
    visit.edit("job.toml", "slope_um_per_m = 20.000000000", "errors = \"x-linear.csv\"");
    visit.run("generate job.toml -o kit").answers();
    holds(&visit.read("kit/manifest.json"), &["\"through\": \"x-linear.csv\""]);
}

#[test]
fn an_existing_table_is_replaced_only_when_forced() {
    let visit = Visit::new();
    visit.put("x.rtl", file(RTL)).put("errors.csv", "mine\n");
    visit.run(&format!("{IMPORT} -o errors.csv")).ends(2);
    assert_eq!(visit.read("errors.csv"), "mine\n");
    let document =
        visit.run(&format!("{IMPORT} -o errors.csv --force --format json")).ends(0).json();
    let table = visit.read("errors.csv");
    assert!(table.starts_with("# source: x.rtl sha256 "));
    assert_eq!(document["schema"], 1);
    assert_eq!(document["series"][1]["direction"], "-");
    assert_eq!(visit.files().len(), 2);
    assert_eq!(visit.yes(&format!("{IMPORT} -o -")), table);
}

const PLACED: &str = "--term EXX --first-target-at-mm 12.3 --targets-run +";

/// Each run has a column of its own: it is understood, shown, and taken with `--yes` or the command that is printed.
#[test]
fn a_column_for_each_run_is_understood() {
    let visit = Visit::new();
    visit.copy("standards/x_axis.csv", "x.csv").copy("formats/runs_selfmade.xlsx", "x.xlsx");
    let run = |name: &str, more: &str| visit.run(&format!("import {name} -o e.csv --force {more}"));
    for (name, row) in [("x.csv", "x,+,12.3,-0.24,"), ("x.xlsx", "x,+,12.3,2,")] {
        let import = |more: &str| run(name, more);
        import("--yes").ends(2).says("`--term` is not stated");
        import("--yes --term EXX").ends(2).says("`--first-target-at-mm` is not stated");
        import(&format!("--yes {PLACED} --sign as-correction")).says("contradicts the file");
        import(&format!("--yes {}", PLACED.replace("EXX", "EYX"))).says("which only positioning");
        let told = import(PLACED).ends(2).says("confirmed: --columns \"").err;
        let (_, understood) = told.split_once("confirmed: ").unwrap();
        let stated = understood.lines().next().unwrap().replace("=up1_mm", "=up1_actual_mm");
        visit.shell(&format!("$N import {name} {PLACED} {stated} -o errors.csv --force")).ends(0);
        import(&format!("{PLACED} --yes")).ends(0).says("understood from the file and confirmed");
        assert_eq!(rows(&visit.read("errors.csv")), rows(&visit.read("e.csv")));
        // 12.3000, 12.2991, 12.2994, 12.3004 and 12.2999 at target 12.3.
        holds(&visit.read("e.csv"), &[row, "# degrees of freedom: "]);
    }
    visit.put("x.rtl", file(RTL));
    run("x.rtl", &IMPORT["import x.rtl".len()..].replace("--term EXX", "--yes")).ends(0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A deviation belongs to the target that its line names.
    #[test]
    fn the_order_of_the_lines_does_not_matter(keys in proptest::collection::vec(any::<u32>(), 36)) {
        let text = file(RTL);
        let (head, rest) = text.split_once("Run Target Data:\r\n").unwrap();
        let (lines, tail) = rest.split_once("\r\n\r\n").unwrap();
        let lines: Vec<&str> = lines.split("\r\n").collect();
        prop_assert_eq!(lines.len(), keys.len());
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.sort_by_key(|index| keys[*index]);
        let lines: Vec<&str> = order.into_iter().map(|index| lines[index]).collect();
        let shuffled = format!("{head}Run Target Data:\r\n{}\r\n\r\n{tail}", lines.join("\r\n"));
        let stated = of_rtl();
        prop_assert_eq!(rows(&table(RTL, shuffled, &stated)), rows(&table(RTL, &text, &stated)));
    }
}
