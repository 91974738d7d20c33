//! `verify` finds what happens to files between laptop and control, and names it.
//!
//! Kits of the nine errors of `fixtures/nine_errors_900` are changed with an editor's means (no
//! number comes from the program) and judged. Each answer is no (1), or cannot be read (2), in
//! words that name the mistake.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A change of one file of a kit.
struct Change {
    what: &'static str,
    file: &'static str,
    /// What becomes of each line; `None` = removed.
    line: fn(&str) -> Option<String>,
    /// What `verify` says.
    says: &'static str,
    status: i32,
}

fn nonius(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// A fresh kit beside its job.
fn kit(control: &str) -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    for (from, to) in [("errors.csv", "errors.csv"), (&format!("{control}.toml"), "job.toml")] {
        fs::copy(fixture.join(from), directory.path().join(to)).expect("the fixture is there");
    }
    let output = nonius(directory.path(), &["generate", "job.toml", "-o", "kit"]);
    assert!(output.status.success(), "{control}: the kit is made");
    let kit = directory.path().join("kit");
    (directory, kit)
}

fn expect_verdict(directory: &Path, what: &str, status: i32, says: &str) {
    let output = nonius(directory, &["verify", "job.toml", "--tables", "kit"]);
    let told = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(output.status.code(), Some(status), "{what}\n{told}");
    assert!(told.contains(says), "{what}: expected `{says}` in\n{told}");
}

/// What `verify` says of a kit with one file changed, which is put back.
fn expect_of_changed(
    directory: &Path,
    (what, file): (&str, &str),
    change: impl Fn(&str) -> String,
    (status, says): (i32, &str),
) {
    let path = directory.join("kit").join(file);
    let good = fs::read_to_string(&path).expect("the file is there");
    let bad = change(&good);
    assert_ne!(good, bad, "{what}: nothing was changed");
    fs::write(&path, bad).expect("the file can be written");
    expect_verdict(directory, what, status, says);
    fs::write(&path, good).expect("the file can be written");
}

fn find_all(control: &str, changes: &[Change]) {
    let (directory, _) = kit(control);
    expect_verdict(directory.path(), "untouched", 0, "job and tables agree");
    for change in changes {
        let lines = |good: &str| {
            let lines: Vec<String> = good.split('\n').filter_map(change.line).collect();
            lines.join("\n")
        };
        let (file, said) = ((change.what, change.file), (change.status, change.says));
        expect_of_changed(directory.path(), file, lines, said);
    }
}

fn behind_first_percent(text: &str, blocks: &str) -> String {
    text.replacen('%', &format!("%\n{blocks}"), 1)
}

/// The line with the number behind `mark` changed, if it begins with `head`.
fn number(line: &str, head: &str, mark: char, change: impl Fn(f64) -> String) -> Option<String> {
    if !line.trim_start().starts_with(head) {
        return Some(line.to_string());
    }
    let (name, rest) = line.split_once(mark)?;
    let end = rest.find(' ').unwrap_or(rest.len());
    let value: f64 = rest[..end].parse().ok()?;
    Some(format!("{name}{mark}{}{}", change(value), &rest[end..]))
}

fn without(line: &str, head: &str) -> Option<String> {
    (!line.trim_start().starts_with(head)).then(|| line.to_string())
}

fn replaced(line: &str, from: &str, to: &str) -> Option<String> {
    Some(line.replace(from, to))
}

mod what_others_own;

mod as_a_control_reads;

const EEC: &str = "NONIUS_EEC.MPF";
const CEC: &str = "NONIUS_CEC.MPF";

#[test]
fn siemens() {
    find_all(
        "siemens-840d-sl",
        &[
            Change {
                what: "a note written into the checklist, which no control reads",
                file: "checklist.md",
                line: |line| Some(line.replace("# Checklist", "# Checklist, done")),
                says: "`checklist.md` was changed after it was made",
                status: 0,
            },
            Change {
                what: "every sign of ENC_COMP turned",
                file: EEC,
                line: |line| number(line, "$AA_ENC_COMP[", '=', |v| format!("{:.6}", -v)),
                says: "EXX (AX1 while AX1 moves): wrong sign",
                status: 1,
            },
            Change {
                what: "every sign of CEC turned",
                file: CEC,
                line: |line| number(line, "$AN_CEC[", '=', |v| format!("{:.6}", -v)),
                says: "EYX (AX2 while AX1 moves): wrong sign",
                status: 1,
            },
            Change {
                what: "MIN and MAX of ENC_COMP shifted",
                file: EEC,
                line: |line| number(line, "$AA_ENC_COMP_M", '=', |v| format!("{:.6}", v + 30.0)),
                says: "EXX (AX1 while AX1 moves): shifted reference: the table stands 30.0000 mm",
                status: 1,
            },
            Change {
                what: "MIN and MAX of CEC shifted",
                file: CEC,
                line: |line| {
                    if line.starts_with("$AN_CEC_MU") {
                        return Some(line.to_string());
                    }
                    number(line, "$AN_CEC_M", '=', |v| format!("{:.6}", v + 30.0))
                },
                says: "EYX (AX2 while AX1 moves): shifted reference",
                status: 1,
            },
            Change {
                what: "ENC_COMP in µm",
                file: EEC,
                line: |line| number(line, "$AA_ENC_COMP[", '=', |v| format!("{:.6}", v * 1000.0)),
                says: "wrong scale: the corrections are 1000 times too large",
                status: 1,
            },
            Change {
                what: "CEC in µm",
                file: CEC,
                line: |line| number(line, "$AN_CEC[", '=', |v| format!("{:.6}", v * 1000.0)),
                says: "check their scale",
                status: 1,
            },
            Change {
                what: "a point of ENC_COMP deleted",
                file: EEC,
                line: |line| without(line, "$AA_ENC_COMP[0,7,AX1]"),
                says: "$AA_ENC_COMP[0,AX1]: point 7 is missing",
                status: 1,
            },
            Change {
                what: "a point of CEC deleted",
                file: CEC,
                line: |line| without(line, "$AN_CEC[0,7]"),
                says: "$AN_CEC[0]: point 7 is missing",
                status: 1,
            },
            Change {
                what: "an axis of ENC_COMP renamed",
                file: EEC,
                line: |line| replaced(line, "AX1]", "AX4]"),
                says: "foreign axis: the tables correct AX4 while AX4 moves",
                status: 1,
            },
            Change {
                what: "ENC_COMP of the other measuring system",
                file: EEC,
                line: |line| match line.contains(",AX1]") {
                    true => Some(line.replace("[0,", "[1,")),
                    false => Some(line.to_string()),
                },
                says: "foreign measuring system: the ENC_COMP table of AX1 is for system 2",
                status: 1,
            },
            Change {
                what: "an output axis of CEC renamed",
                file: CEC,
                line: |line| replaced(line, "OUTPUT_AXIS[0]=(AX2)", "OUTPUT_AXIS[0]=(AX3)"),
                says: "foreign axis: the corrections of EYX are added to its own",
                status: 1,
            },
            Change {
                what: "a table acts in one direction only",
                file: CEC,
                line: |line| replaced(line, "DIRECTION[0]=0", "DIRECTION[0]=1"),
                says: "EYX (AX2 while AX1 moves in -): missing",
                status: 1,
            },
            Change {
                what: "a table is not switched on",
                file: "NONIUS_ENABLE.MPF",
                line: |line| without(line, "$SN_CEC_TABLE_ENABLE[0]"),
                says: "does not switch on CEC table 0",
                status: 1,
            },
            Change {
                what: "the transfer broke off",
                file: EEC,
                line: |line| without(line, "M30"),
                says: "the file has no end word; it is not complete",
                status: 2,
            },
            Change {
                what: "one value mistyped",
                file: EEC,
                line: |line| replaced(line, "=0.006464", "=0.007464"),
                says: "another value at 150.0000 mm, where the tables correct",
                status: 1,
            },
            Change {
                what: "a comment changed",
                file: EEC,
                line: |line| replaced(line, "golden 900", "another machine"),
                says: "its hash is not that of manifest.json",
                status: 1,
            },
            Change {
                what: "the manifest damaged",
                file: "manifest.json",
                line: |line| without(line, "}"),
                says: "`manifest.json` is damaged",
                status: 2,
            },
        ],
    );
}

#[test]
fn fanuc() {
    let (points, parameters) = ("PITCH.TXT", "CNC-PARA.TXT");
    find_all(
        "fanuc-30i",
        &[
            Change {
                what: "the sign of every point turned",
                file: points,
                line: |line| number(line, "N1", 'P', |v| format!("{}", 0.0 - v)),
                says: "EXX (1 while 1 moves): wrong sign",
                status: 1,
            },
            Change {
                what: "the reference point of axis 1 moved (3620)",
                file: parameters,
                line: |line| replaced(line, "N03620Q1A1P0A", "N03620Q1A1P1A"),
                says: "EXX (1 while 1 moves): shifted reference",
                status: 1,
            },
            Change {
                what: "magnification of axis 1 doubled (3623)",
                file: parameters,
                line: |line| replaced(line, "N03623Q1A1P1A", "N03623Q1A1P2A"),
                says: "EXX (1 while 1 moves): wrong scale: every correction is double",
                status: 1,
            },
            Change {
                what: "magnification of axis 1 tripled (3623)",
                file: parameters,
                line: |line| replaced(line, "N03623Q1A1P1A", "N03623Q1A1P3A"),
                says: "wrong scale: every correction is 3.000 times",
                status: 1,
            },
            Change {
                what: "interval of axis 1 in µm (3624)",
                file: parameters,
                line: |line| replaced(line, "A1P30.0A", "A1P30000.0A"),
                says: "other spacing: the points are 30000.0000 mm apart",
                status: 1,
            },
            Change {
                what: "one increment mistyped",
                file: points,
                line: |line| replaced(line, "N10010Q0P0", "N10010Q0P5"),
                says: "EXX (1 while 1 moves): one step is changed: from 270.0000 to 300.0000 mm the correction changes by 5.000 µm, the job asks for 0.000 µm; so every correction from 300.0000 mm on is off by 5.000 µm",
                status: 1,
            },
            Change {
                what: "one increment below the reference point mistyped",
                file: points,
                line: |line| replaced(line, "N10090Q0P0", "N10090Q0P1"),
                says: "EZZ (3 while 3 moves): one step is changed: from -480.0000 to -456.0000 mm the correction changes by 1.000 µm, the job asks for 0.000 µm; so every correction up to -480.0000 mm is off by -1.000 µm",
                status: 1,
            },
            Change {
                what: "a pitch point deleted",
                file: points,
                line: |line| without(line, "N10007"),
                says: "point 7 is missing",
                status: 1,
            },
            Change {
                what: "a straightness point deleted",
                file: points,
                line: |line| without(line, "N16007"),
                says: "point 6007 is missing",
                status: 1,
            },
            Change {
                what: "axes 1 and 2 exchanged",
                file: parameters,
                line: |line| {
                    replaced(&line.replace("A1P", "A#P").replace("A2P", "A1P"), "A#P", "A2P")
                },
                says: "EXX (1 while 1 moves): foreign axis: these are the corrections of EYY",
                status: 1,
            },
            Change {
                what: "a straightness set moves another axis",
                file: parameters,
                line: |line| replaced(line, "N05721Q1P2", "N05721Q1P3"),
                says: "foreign axis: the corrections of EYX are added to its own",
                status: 1,
            },
        ],
    );
}

#[test]
fn generic() {
    let (directory, kit) = kit("generic");
    expect_verdict(directory.path(), "untouched", 0, "job and tables agree");
    let (csv, json) = (kit.join("compensation.csv"), kit.join("compensation.json"));
    let good = fs::read_to_string(&csv).expect("the file is there");
    let cut = good.replacen("EXX,x,x,,30,", "# EXX,x,x,,30,", 1);
    fs::write(&csv, cut).expect("the file can be written");
    let output = nonius(directory.path(), &["verify", "job.toml", "--tables", "kit"]);
    assert_eq!(output.status.code(), Some(2), "one twin cut");
    fs::remove_file(json).expect("the file can be removed");
    let columns = |first: usize, change: fn(f64) -> f64| {
        move |cells: &mut Vec<String>| {
            let last = if first == 5 { 6 } else { cells.len() };
            for cell in cells[first..last].iter_mut().filter(|c| !c.is_empty()) {
                *cell = change(cell.parse().expect("a number")).to_string();
            }
            true
        }
    };
    type Row<'a> = &'a dyn Fn(&mut Vec<String>) -> bool;
    let changes: [(&str, Row<'_>, i32, &str); 7] = [
        ("every sign turned", &columns(6, |v| 0.0 - v), 1, "wrong sign"),
        (
            "scaled",
            &columns(6, |v| v * 1000.0),
            1,
            "wrong scale: the corrections are 1000 times too large",
        ),
        ("shifted", &columns(5, |v| v + 12.0), 1, "shifted reference: the table stands 12.0000 mm"),
        (
            "last point deleted",
            &|c| !(c[0] == "EXX" && c[4] == "30"),
            1,
            "EXX (x while x moves): missing points",
        ),
        ("a point deleted", &|c| !(c[0] == "EXX" && c[4] == "7"), 2, "`index` is 8, expected 7"),
        ("a term deleted", &|c| c[0] != "EYX", 1, "EYX (y while x moves): missing"),
        (
            "an axis renamed",
            &|c| {
                if c[0] == "EYX" {
                    c[2] = "w".to_string();
                }
                true
            },
            1,
            "foreign axis",
        ),
    ];
    for (what, change, status, says) in changes {
        let mut lines = good.lines();
        let mut bad = format!("{}\n", lines.next().expect("there is a header"));
        for line in lines {
            let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
            if change(&mut cells) {
                bad += &format!("{}\n", cells.join(","));
            }
        }
        fs::write(&csv, bad).expect("the file can be written");
        expect_verdict(directory.path(), what, status, says);
    }
}

#[test]
fn a_whole_file_missing() {
    for (control, file) in [
        ("siemens-840d-sl", EEC),
        ("siemens-840d-sl", CEC),
        ("fanuc-30i", "PITCH.TXT"),
        ("fanuc-30i", "CNC-PARA.TXT"),
        ("generic", "compensation.csv"),
    ] {
        let (directory, kit) = kit(control);
        fs::remove_file(kit.join(file)).expect("the file can be removed");
        let says = format!("`{file}` is listed in manifest.json but missing");
        expect_verdict(directory.path(), file, 1, &says);
    }
}

#[test]
fn the_verdict_stands_first_and_a_missing_manifest_is_told() {
    let (directory, kit) = kit("generic");
    fs::remove_file(kit.join("manifest.json")).expect("the file can be removed");
    let output = nonius(directory.path(), &["verify", "job.toml", "--tables", "kit"]);
    let page = String::from_utf8_lossy(&output.stdout);
    assert!(page.contains("note: there is no manifest.json"), "{page}");
    let why =
        "judged as a kit that is to be loaded, because `compensation.csv` is called as in one";
    assert!(page.contains(why), "{page}");
    assert!(page.starts_with("verdict: pass (asked: "), "{page}");
}

/// A transfer may change the line ends of a file and nothing else.
#[test]
fn a_file_with_other_bytes_and_the_same_values_is_told_as_such() {
    let (directory, kit) = kit("siemens-840d-sl");
    let path = kit.join(EEC);
    let good = fs::read_to_string(&path).expect("the file is there");
    let only_bytes = "read back, tables and switches are as the job asks";
    fs::write(&path, good.replace('\n', "\r\n")).expect("the file can be written");
    expect_verdict(directory.path(), "line ends", 1, only_bytes);
    fs::write(&path, good.replace("=0.018", "=0.019")).expect("the file can be written");
    let output = nonius(directory.path(), &["verify", "job.toml", "--tables", "kit"]);
    let page = String::from_utf8_lossy(&output.stdout);
    assert!(page.contains("another value") && !page.contains(only_bytes), "{page}");
}

#[test]
fn tables_without_files_that_switch_are_judged_with_a_note() {
    let (directory, kit) = kit("siemens-840d-sl");
    let remove = |name: &str| fs::remove_file(kit.join(name)).expect("the file can be removed");
    for name in ["manifest.json", "NONIUS_ENABLE.MPF", "NONIUS_DISABLE.MPF", "NONIUS_MEMORY.TXT"] {
        remove(name);
    }
    for says in [
        "job and tables agree",
        "note: no file switches the tables on; see to MD32700 $MA_ENC_COMP_ENABLE = 1, SD41300",
        "note: no file switches the tables off",
        "note: no file reserves their memory; see to MD38000 $MA_MM_ENC_COMP_MAX_POINTS, MD18342",
    ] {
        expect_verdict(directory.path(), "tables alone", 0, says);
    }
    let path = kit.join(EEC);
    let good = fs::read_to_string(&path).expect("the file is there");
    let turned = |line: &str| match line.contains(",AX1]") {
        true => line.replace("[0,", "[1,") + "\n",
        false => line.to_string() + "\n",
    };
    let bad: String = good.lines().map(turned).collect();
    fs::write(&path, bad).expect("the file can be written");
    let says = "foreign measuring system: the ENC_COMP table of AX1 is for system 2";
    expect_verdict(directory.path(), "the other measuring system", 1, says);
}

/// A control keeps what no line writes. Without a manifest nothing but the reading can find that; of each
/// variable and parameter one line is taken out.
#[test]
fn an_assignment_that_a_kit_lacks_is_found_without_its_manifest() {
    for (control, files) in [
        (
            "siemens-840d-sl",
            &[EEC, CEC, "NONIUS_ENABLE.MPF", "NONIUS_DISABLE.MPF", "NONIUS_MEMORY.TXT"][..],
        ),
        ("fanuc-30i", &["CNC-PARA.TXT", "PITCH.TXT"]),
    ] {
        let (directory, kit) = kit(control);
        fs::remove_file(kit.join("manifest.json")).expect("the file can be removed");
        expect_verdict(directory.path(), "whole", 0, "job and tables agree");
        for file in files {
            each_kind_of_line_is_missed(directory.path(), &kit.join(file));
        }
    }
}

fn each_kind_of_line_is_missed(directory: &Path, path: &Path) {
    let good = fs::read_to_string(path).expect("the file is there");
    let lines: Vec<&str> = good.split_inclusive('\n').collect();
    let mut kinds = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let code = line.trim();
        let number =
            code.strip_prefix('N').filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        let kind = match code.starts_with('$') {
            true => code.split('[').next(),
            false => number.and_then(|rest| rest.split(['Q', ' ']).next()),
        };
        let Some(kind) = kind else {
            continue;
        };
        let is_point = code.contains("Q0");
        let seen = |known: &(String, bool)| known.0 == kind || (is_point && known.1);
        if kinds.iter().any(seen) {
            continue;
        }
        kinds.push((kind.to_string(), is_point));
        let bad: String = [&lines[..index], &lines[index + 1..]].concat().concat();
        fs::write(path, bad).expect("the file can be written");
        let output = nonius(directory, &["verify", "job.toml", "--tables", "kit"]);
        let page = String::from_utf8_lossy(&output.stdout);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            matches!(output.status.code(), Some(1 | 2)),
            "without `{code}` of {}\n{page}{said}",
            path.display()
        );
        let tells =
            ["IS_MODULO", "MULT_BY_TABLE", "DIRECTION"].iter().find(|field| kind.ends_with(*field));
        if let Some(field) = tells {
            let words = format!("no file writes {field} of ");
            assert!(page.contains(&words), "`{words}` is not in\n{page}");
        }
    }
    assert!(!kinds.is_empty(), "{}", path.display());
    fs::write(path, good).expect("the file can be written");
}
