//! The volumetric compensation of the ISG kernel from a job to its files and back: angles and what they do away
//! from the lines of measurement, both forms of the parameter file, what is refused.
use crate::support::run::ended;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// X rolls, pitches and yaws; Y yaws. Positions of X from its rest, 100 mm.
const ERRORS: &str = "axis,position_mm,ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad\n\
    x,0,-4,1,0,-10,20,-30\nx,100,0,0,0,0,0,0\nx,200,6,-2,1,10,10,40\n\
    y,0,0,0,0,,,0\ny,150,2,3,-1,,,20\ny,300,5,4,2,,,-10\n\
    z,-200,1,2,3,,,\nz,-100,1,1,1,,,\nz,0,0,0,0,,,\n";

/// Z rests at -100 mm and Y at 50 mm while X is measured.
fn job(more: &str) -> String {
    let axis = |letter: &str, travel: &str, reference: &str, spacing: &str| {
        format!(
            "[machine.axes.{letter}]\ntravel_mm = {travel}\nreference_mm = {reference}\n\
             [compensation.axes.{letter}]\nspacing_mm = {spacing}\n"
        )
    };
    format!(
        "schema = 1\n[machine]\nname = \"M\"\nchain = \"wXYZt\"\n[measurement]\nerrors = \"errors.csv\"\n\
         active_while_measuring = \"none\"\noffsets_mm = {{ x = 100.0, y = 50.0, z = -100.0 }}\n\
         [compensation]\ncontroller = \"isg-volcomp\"\n{more}\n{}{}{}[acceptance]\nmax_deviation_um = 1\n",
        axis("x", "[0, 200]", "100", "100"),
        axis("y", "[0, 300]", "0", "150"),
        axis("z", "[-200, 0]", "0", "100"),
    )
}

fn place(job: &str, errors: &str) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(directory.path().join(name), text).unwrap();
    write("job.toml", job);
    write("errors.csv", errors);
    directory
}

fn read(at: &Path, name: &str) -> String {
    fs::read_to_string(at.join(name)).unwrap()
}

fn kit(job: &str) -> TempDir {
    let directory = place(job, ERRORS);
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(0), "{said}");
    directory
}

fn json(at: &Path, arguments: &str) -> Value {
    let (_, page, said) = ended(at, arguments);
    serde_json::from_str(&page).unwrap_or_else(|_| panic!("{said}"))
}

fn va(at: &Path, arguments: &str) -> [f64; 2] {
    let page = json(at, &format!("assess job.toml {arguments} --format json"));
    let of = |value: &Value| value["definitions"]["va_um"].as_f64().unwrap();
    [of(&page), of(&page["after"])]
}

/// By hand, for X at 0 mm: levers from machine zero, so a = (0, 50, -100) mm; r = (-10, 20, -30) urad;
/// r x a = (20 * -100 + 30 * 50, -(-10 * -100), -10 * 50) = (-0.5, -1.0, -0.5) um. What was measured, less that:
/// -4 + 0.5, 1 + 1, 0 + 0.5. Y at 150 mm: ECY * Z turns nothing, for Z carries along Z: nothing is taken off.
#[test]
fn deviations_are_less_what_angles_do_on_the_line_of_measurement() {
    let directory = kit(&job(""));
    let file = read(directory.path(), "kit/volcomp.csv");
    let rows: Vec<&str> = file.lines().filter(|line| !line.starts_with("//")).collect();
    assert_eq!(rows[0], "X EXX EYX EZX EAX EBX ECX");
    assert_eq!(
        rows[1],
        "0.000000 -0.003500 0.002000 0.000500 -0.000010000 0.000020000 -0.000030000"
    );
    assert_eq!(
        rows[2],
        "100.000000 0.000000 0.000000 0.000000 0.000000000 0.000000000 0.000000000"
    );
    // 200 mm, r = (10, 10, 40): r x a = (10 * -100 - 40 * 50, 10 * 100, 10 * 50) = (-3, 1, 0.5) um.
    assert_eq!(
        rows[3],
        "200.000000 0.009000 -0.003000 0.000500 0.000010000 0.000010000 0.000040000"
    );
    // The angles of Y stand as they were measured: `angles_zero_mm` is not stated.
    assert_eq!(
        rows[5..8],
        [
            "Y EXY EYY EZY ECY",
            "0.000000 0.000000 0.000000 0.000000 0.000000000",
            "150.000000 0.002000 0.003000 -0.001000 0.000020000",
        ]
    );
    assert!(!file.contains("EAY") && !file.contains("C0Y"));
}

/// On the lines of measurement nothing but rounding is left, and neither is away from them.
#[test]
fn the_volume_is_left_without_what_the_angles_did() {
    let directory = kit(&job(""));
    let at = directory.path();
    let manifest: Value = serde_json::from_str(&read(at, "kit/manifest.json")).unwrap();
    let left = &manifest["forecast"]["terms"];
    for term in ["EXX", "EYX", "EZX", "EXY", "EZZ"] {
        let after = left[term]["after_um"].as_f64().unwrap();
        assert!(after < 0.003, "{term}: {after}");
    }
    let [before, after] = va(at, "--with-tables");
    assert!(before > 10.0 && after < 0.02, "{before} {after}");
    // Without angles in the files what they do away from the lines stays.
    let nine =
        "terms = [\"EXX\", \"EYX\", \"EZX\", \"EXY\", \"EYY\", \"EZY\", \"EXZ\", \"EYZ\", \"EZZ\"]";
    let directory = kit(&job(nine));
    assert!(!read(directory.path(), "kit/volcomp.csv").contains("EAX"));
    let [_, after] = va(directory.path(), "--with-tables");
    assert!(after > 5.0, "{after}");
    // A tool is none of the levers that the control counts.
    let tool = "offsets_mm = { x = 100.0, y = 50.0, z = -100.0 }\ntool_offset_mm = { x = 0.0, y = 0.0, z = -100.0 }";
    let job = job("").replace("offsets_mm = { x = 100.0, y = 50.0, z = -100.0 }", tool);
    let directory = kit(&job);
    let [_, after] = va(directory.path(), "--with-tables");
    assert!(after > 1.0, "{after}");
}

/// The same machine in another chain: another lever, another file, nothing left.
#[test]
fn every_chain_has_its_levers() {
    for chain in ["wXYZt", "wZYXt", "YwXZt", "XYwZt", "YXwZt", "XYZwt"] {
        // The volume takes angles as given unless it is told where they are zero.
        let zero = "errors.csv\"\nangles_zero_mm = { x = 100.0, y = 50.0 }\n";
        let job = job("").replace("errors.csv\"\n", zero);
        let directory = kit(&job.replace("wXYZt", chain));
        let [before, after] = va(directory.path(), "--with-tables");
        assert!(before > 5.0 && after < 0.02, "{chain}: {before} {after}");
    }
}

/// The other form holds the same, and what somebody changes in either is found.
#[test]
fn both_forms_are_read_back_and_judged() {
    let own = "schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"isg-volcomp\"\n[facts.file_format]\n\
               value = \"ETALON_EXCHANGE\"\nevidence = \"manual\"\nsource = \"a shop with this software\"\n";
    let mut directories = Vec::new();
    for (controller, file) in [("isg-volcomp", "volcomp.csv"), ("own.toml", "volcomp.txt")] {
        let directory = place(&job("").replace("isg-volcomp", controller), ERRORS);
        let at = directory.path();
        fs::write(at.join("own.toml"), own).unwrap();
        let (status, _, said) = ended(at, "generate job.toml -o kit");
        assert_eq!(status, Some(0), "{said}");
        let (status, _, said) = ended(at, "verify job.toml --tables kit");
        assert_eq!(status, Some(0), "{said}");
        directories.push((directory, file));
    }
    let (exchange, file) = &directories[1];
    let text = read(exchange.path(), &format!("kit/{file}"));
    let words = "[ECY]\r\nGridpoints = {\r\n0.000000 0.000000000\r\n150.000000 0.000020000\r\n";
    assert!(text.contains(words), "{text}");
    for (directory, file) in &directories {
        let at = directory.path();
        let path = at.join("kit").join(file);
        let text = fs::read_to_string(&path).unwrap();
        for (from, to, words) in
            [("0.000030000", "0.000050000", "ECX"), ("0.009000", "-0.009000", "EXX")]
        {
            fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let (status, said, _) = ended(at, "verify job.toml --tables kit --explain");
            assert_eq!(status, Some(1), "{said}");
            assert!(said.contains(words), "{said}");
        }
        fs::write(&path, &text).unwrap();
        let list = read(at, "kit/volcomp.lis");
        for (from, to, words) in [
            ("chain XYZ", "chain YXZ", "chain is YXZ, the job writes XYZ"),
            ("X 1\r\nY 2", "X 2\r\nY 1", "X is 2, the job writes 1"),
        ] {
            fs::write(at.join("kit/volcomp.lis"), list.replace(from, to)).unwrap();
            let (status, said, _) = ended(at, "verify job.toml --tables kit --explain");
            assert_eq!(status, Some(1), "{said}");
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}

/// Files read out under names of their own: angles that differ are seen, though on the lines of measurement, levers
/// from the rest, they do nothing.
#[test]
fn angles_that_were_changed_are_seen_in_files_read_out() {
    let rest = "offsets_mm = { x = 0.0, y = 0.0, z = 0.0 }\nangles_zero_mm = { x = 100.0 }";
    let job = job("").replace("offsets_mm = { x = 100.0, y = 50.0, z = -100.0 }", rest);
    let directory = kit(&job);
    let at = directory.path();
    let table = read(at, "kit/volcomp.csv");
    let list = read(at, "kit/volcomp.lis").replace("volcomp.csv", "OUT.CSV");
    fs::create_dir(at.join("out")).unwrap();
    let minus = table.replace("0.000040000", "-0.000040000");
    let without = table.replace(" ECX", "").replace(" -0.000030000\r", "\r");
    let without = without.replace(" 0.000040000\r", "\r").replace(
        "100.000000 0.000000 0.000000 0.000000 0.000000000 0.000000000 0.000000000\r",
        "100.000000 0.000000 0.000000 0.000000 0.000000000 0.000000000\r",
    );
    let chain = list.replace("chain XYZ", "chain ZYX");
    for (list, table, status, words) in [
        (&list, &table, 0, "job and tables agree"),
        (&list, &minus, 1, "ECX"),
        (&list, &without, 1, "ECX"),
        (&chain, &table, 1, "chain"),
    ] {
        fs::write(at.join("out/machine.lis"), list).unwrap();
        fs::write(at.join("out/out.csv"), table).unwrap();
        let (found, said, problems) = ended(at, "verify job.toml --tables out --explain");
        assert_eq!(found, Some(status), "{said}{problems}");
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn what_the_control_does_not_take_is_refused() {
    for (from, to, words) in [
        ("spacing_mm = 150", "spacing_mm = 150\nids = [\"2\", \"4\"]", "takes one"),
        ("spacing_mm = 150", "spacing_mm = 150\nid = \"Y\"", "a logical axis number"),
        ("chain = \"wXYZt\"\n", "", "`machine.chain` is missing"),
        ("spacing_mm = 150", "points = 2001", "more than the 2000 of a compensation"),
    ] {
        let directory = place(&job("").replace(from, to), ERRORS);
        let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
        assert_eq!(status, Some(2), "{to}: {said}");
        assert!(said.contains(words), "{to}: {said}");
        assert!(!directory.path().join("kit").exists());
    }
    let only_x: String = job("").split("[machine.axes.y]").next().unwrap().to_string();
    let rows: Vec<&str> = ERRORS.lines().take(4).collect();
    let only_x = only_x.replace("y = 50.0, z = -100.0 ", "");
    let directory = place(&only_x.replace(", }", " }"), &rows.join("\n"));
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("[machine.axes.y] is missing"), "{said}");
}

/// New = old + residual for the nine errors; angles that acted are refused.
#[test]
fn old_tables_are_part_of_the_new_ones_unless_they_hold_angles() {
    let plain = ERRORS.replace("ea_urad,eb_urad,ec_urad", "n1,n2,n3");
    let cut = |line: &str| line.split(',').take(5).collect::<Vec<_>>().join(",") + "\n";
    let plain: String = plain.lines().map(cut).collect();
    let again = job("").replace("\"none\"", "\"kit\"");
    let first = place(&job(""), &plain);
    let at = first.path();
    assert_eq!(ended(at, "generate job.toml -o kit").0, Some(0));
    fs::write(at.join("job.toml"), &again).unwrap();
    let (status, _, said) = ended(at, "generate job.toml -o new");
    assert_eq!(status, Some(0), "{said}");
    let file = read(at, "new/volcomp.csv");
    assert!(file.contains("\n200.000000 0.012000 -0.004000 0.002000\r"), "{file}");
    let angles = kit(&job(""));
    fs::write(angles.path().join("job.toml"), again).unwrap();
    let (status, _, said) = ended(angles.path(), "generate job.toml -o new");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("the active tables hold angles (EAX)"), "{said}");
}

/// A second measurement as the emulated control would give it; one without tables misses.
#[test]
fn a_second_measurement_is_judged() {
    let directory = kit(&job(""));
    let at = directory.path();
    let simulate = "simulate job.toml --errors --noise-um 0.05 --seed 3 --force -o after.csv";
    for (tables, expected) in [("--tables kit", "pass"), ("--without-tables", "fail")] {
        let (status, _, said) = ended(at, &format!("{simulate} {tables}"));
        assert_eq!(status, Some(0), "{said}");
        let measured = read(at, "after.csv");
        let measured = measured.lines().filter(|line| !line.starts_with('#'));
        let measured: String = measured.map(|line| format!("{line}\n")).collect();
        fs::write(at.join("after.csv"), measured).unwrap();
        let page = json(at, "verify job.toml --tables kit --after after.csv --format json");
        assert_eq!(page["verdict"], expected, "{tables} {page:#}");
    }
}
