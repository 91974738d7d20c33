//! The volumetric compensation of the ISG kernel from a job to its files and back (refused: cases/refuses/controls.txt).
use crate::support::{Visit, holds, number, replaced};

/// Z rests at -100 mm and Y at 50 mm while X is measured.
const OFFSETS: &str = "offsets_mm = { x = 100.0, y = 50.0, z = -100.0 }";

/// X rolls, pitches and yaws; Y yaws. Positions of X from its rest, 100 mm.
fn visit(old: &str, new: &str) -> Visit {
    let visit = Visit::of("base/isg");
    visit.edit("job.toml", old, new);
    visit
}

#[track_caller]
pub(super) fn kit(old: &str, new: &str) -> Visit {
    visit(old, new).with_kit()
}

/// The volumetric accuracy without and with the tables.
fn va(visit: &Visit) -> [f64; 2] {
    let page = visit.json("assess job.toml --with-tables");
    [&page, &page["after"]].map(|page| number(&page["definitions"]["va_um"]))
}

/// By hand, for X at 0 mm: levers from machine zero, so a = (0, 50, -100) mm; r = (-10, 20, -30) urad;
/// r x a = (20 * -100 + 30 * 50, -(-10 * -100), -10 * 50) = (-0.5, -1.0, -0.5) um. What was measured, less that:
/// -4 + 0.5, 1 + 1, 0 + 0.5. Y at 150 mm: ECY * Z turns nothing, for Z carries along Z: nothing is taken off.
#[test]
fn deviations_are_less_what_angles_do_on_the_line_of_measurement() {
    let file = kit("", "").read("kit/volcomp.csv");
    let rows: Vec<&str> = file.lines().filter(|line| !line.starts_with("//")).collect();
    let of_x = [
        "X EXX EYX EZX EAX EBX ECX",
        "0.000000 -0.003500 0.002000 0.000500 -0.000010000 0.000020000 -0.000030000",
        "100.000000 0.000000 0.000000 0.000000 0.000000000 0.000000000 0.000000000",
        // 200 mm, r = (10, 10, 40): r x a = (10 * -100 - 40 * 50, 10 * 100, 10 * 50) = (-3, 1, 0.5) um.
        "200.000000 0.009000 -0.003000 0.000500 0.000010000 0.000010000 0.000040000",
    ];
    // The angles of Y stand as they were measured: `angles_zero_mm` is not stated.
    let of_y = [
        "Y EXY EYY EZY ECY",
        "0.000000 0.000000 0.000000 0.000000 0.000000000",
        "150.000000 0.002000 0.003000 -0.001000 0.000020000",
    ];
    assert_eq!((&rows[..4], &rows[5..8]), (&of_x[..], &of_y[..]));
    assert!(!file.contains("EAY") && !file.contains("C0Y"));
}

#[test]
fn the_volume_is_left_without_what_the_angles_did_and_the_kit_is_read_back_and_judged() {
    let visit = kit("", "");
    let left = &visit.document("kit/manifest.json")["forecast"]["terms"];
    for term in ["EXX", "EYX", "EZX", "EXY", "EZZ"] {
        let after = number(&left[term]["after_um"]);
        assert!(after < 0.003, "{term}: {after}");
    }
    let [before, after] = va(&visit);
    assert!(before > 10.0 && after < 0.02, "{before} {after}");
    // Without angles in the files what they do away from the lines stays.
    let nine = "terms = ['EXX', 'EYX', 'EZX', 'EXY', 'EYY', 'EZY', 'EXZ', 'EYZ', 'EZZ']";
    let visit = kit("[compensation]", &format!("[compensation]\n{nine}"));
    assert!(!visit.read("kit/volcomp.csv").contains("EAX"));
    let [_, after] = va(&visit);
    assert!(after > 5.0, "{after}");
    // A tool is none of the levers that the control counts.
    let tool = format!("{OFFSETS}\ntool_offset_mm = {{ x = 0.0, y = 0.0, z = -100.0 }}");
    let [_, after] = va(&kit(OFFSETS, &tool));
    assert!(after > 1.0, "{after}");
    let visit = kit("", "");
    visit.yes("verify job.toml --tables kit");
    let (file, list) = ("kit/volcomp.csv", "kit/volcomp.lis");
    for (file, from, to, status, words) in [
        (file, "0.000030000", "0.000050000", 1, "ECX"),
        (file, "0.009000", "-0.009000", 1, "EXX"),
        (list, "chain XYZ", "chain YXZ", 1, "chain is YXZ, the job writes XYZ"),
        (list, "X 1\r\nY 2", "X 2\r\nY 1", 1, "X is 2, the job writes 1"),
        (list, "ISG_CSV", "ETALON_EXCHANGE", 2, "expected ISG_CSV: write the parameters in that"),
    ] {
        let verify = "verify job.toml --tables kit --explain";
        visit.run_with(file, from, to, verify).ends(status).says(words);
    }
}

/// Tables of ECX every 80 mm from the reference at 100 mm. At 180 and 20 mm they say what was measured; at the ends
/// -4 for -10 and 4.5 for 0 urad, so (6, 4.5) urad * 300 mm stay, seen along a diagonal times 200 / sqrt(170000).
#[test]
fn an_angle_of_the_tables_bends_at_its_own_places() {
    let errors = "axis,position_mm,ex_um,ey_um,ez_um,ec_urad\nx,0,0,0,0,0\nx,100,0,0,0,30\nx,200,0,0,0,-10\n\
        y,0,0,0,0,\ny,150,0,0,0,\ny,300,0,0,0,\nz,-200,0,0,0,\nz,-100,0,0,0,\nz,0,0,0,0,\n";
    let visit = kit(OFFSETS, "offsets_mm = { x = 0.0, y = 0.0, z = 0.0 }");
    visit.put("errors.csv", errors).edit("job.toml", "x.spacing_mm = 100", "x.spacing_mm = 80");
    let left = visit.json("assess job.toml --with-tables")["after"]["definitions"].clone();
    assert_eq!((number(&left["va_um"]), left["va_exact"].as_bool()), (1.8, Some(true)));
    for (diagonal, left_um) in [("PPP", 1.8), ("NPP", 1.35), ("PNP", 1.35), ("PPN", 1.8)] {
        let seen = number(&left["diagonals_um"][diagonal]);
        assert!((seen - left_um * 200.0 / 170_000_f64.sqrt()).abs() < 1e-6, "{diagonal} {seen}");
    }
}

#[test]
fn every_chain_has_its_levers() {
    for chain in ["wXYZt", "wZYXt", "YwXZt", "XYwZt", "YXwZt", "XYZwt"] {
        // The volume takes angles as given unless it is told where they are zero.
        let zero = "errors.csv\"\nangles_zero_mm = { x = 100.0, y = 50.0 }\n";
        let visit = visit("errors.csv\"\n", zero);
        visit.edit("job.toml", "wXYZt", chain).yes("generate job.toml -o kit");
        let [before, after] = va(&visit);
        assert!(before > 5.0 && after < 0.02, "{chain}: {before} {after}");
    }
}

/// Under names of their own: on the lines of measurement, levers from the rest, these angles do nothing.
#[test]
fn angles_that_were_changed_are_seen_in_files_read_out() {
    let rest = "offsets_mm = { x = 0.0, y = 0.0, z = 0.0 }\nangles_zero_mm = { x = 100.0 }";
    let visit = kit(OFFSETS, rest);
    let table = visit.read("kit/volcomp.csv");
    let list = visit.read("kit/volcomp.lis").replace("volcomp.csv", "OUT.CSV");
    let minus = table.replace("0.000040000", "-0.000040000");
    let zeros = "100.000000 0.000000 0.000000 0.000000 0.000000000 0.000000000";
    let without = [" -0.000030000\r", " 0.000040000\r", " ECX\r"].iter();
    let without = without.fold(table.clone(), |text, last| text.replace(last, "\r"));
    let without = replaced(&without, &format!("{zeros} 0.000000000\r"), &format!("{zeros}\r"));
    let chain = list.replace("chain XYZ", "chain ZYX");
    for (list, table, status, words) in [
        (&list, &table, 0, "job and tables agree"),
        (&list, &minus, 1, "ECX"),
        (&list, &without, 1, "ECX"),
        (&chain, &table, 1, "chain"),
    ] {
        visit.put("out/machine.lis", list).put("out/out.csv", table);
        visit.run("verify job.toml --tables out --explain").ends(status).says(words);
    }
}

#[test]
fn old_tables_are_part_of_the_new_ones_unless_they_hold_angles() {
    let cut = |line: &str| line.split(',').take(5).collect::<Vec<_>>().join(",") + "\n";
    let first = visit("", "");
    first.put("errors.csv", first.read("errors.csv").lines().map(cut).collect::<String>());
    first.yes("generate job.toml -o kit");
    first.edit("job.toml", "\"none\"", "\"kit\"").yes("generate job.toml -o new");
    holds(&first.read("new/volcomp.csv"), &["\n200.000000 0.012000 -0.004000 0.002000\r"]);
    let angles = kit("", "");
    let again = angles.edit("job.toml", "\"none\"", "\"kit\"").run("generate job.toml -o new");
    again.ends(2).says("the active tables hold angles (EAX)");
}
