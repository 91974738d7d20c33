//! `nonius path` through the program, and its scanner against one by others.

use crate::support::refusals;
use nonius::inputs::nc::scan;
use proptest::prelude::*;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// 100 mm an axis; the error at a place in mm is (x/10, y/5, z/2) µm.
const ERRORS: &str = "axis,position_mm,ex_um,ey_um,ez_um
x,0,0,0,0\nx,100,10,0,0\ny,0,0,0,0\ny,100,0,20,0\nz,0,0,0,0\nz,100,0,0,50\n";

fn job(path: &str) -> String {
    let axes: String = ["x", "y", "z"]
        .iter()
        .map(|axis| {
            format!("[machine.axes.{axis}]\ntravel_mm = [0.0, 100.0]\nreference_mm = 0.0\n")
        })
        .collect();
    let grids: String = ["x", "y", "z"]
        .iter()
        .map(|axis| format!("[compensation.axes.{axis}]\nspacing_mm = 50.0\n"))
        .collect();
    let offsets: String = [("G54", 0.0), ("G55", 30.0)]
        .iter()
        .map(|(name, z)| {
            format!("[[path.offset]]\nsystem = \"{name}\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = {z:?}\n")
        })
        .collect();
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n{axes}[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n[compensation]\ncontroller = \"generic\"\n{grids}[path]\n{path}\n{offsets}[[path.tool]]\nnumber = 1\nlength_mm = 12.5\n"
    )
}

/// A directory with the job (further lines of its `[path]`) and the program.
fn prepared(path: &str, program: &str) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("errors.csv"), ERRORS).unwrap();
    fs::write(directory.path().join("job.toml"), job(path)).unwrap();
    fs::write(directory.path().join("part.nc"), program).unwrap();
    directory
}

fn nonius(directory: &Path, arguments: &str, input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments.split_whitespace())
        .current_dir(directory)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stdin = child.stdin.take().unwrap();
    let _ = stdin.write_all(input.as_bytes()); // it may stop before it reads
    drop(stdin);
    child.wait_with_output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn done(directory: &Path, arguments: &str) -> String {
    let output = nonius(directory, arguments, "");
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", said(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn summary(path: &str, program: &str) -> Value {
    let directory = prepared(path, program);
    serde_json::from_str(&done(directory.path(), "path job.toml part.nc --format json")).unwrap()
}

/// Rows of the CSV, as cells.
fn samples(path: &str, program: &str) -> Vec<Vec<String>> {
    let directory = prepared(path, program);
    done(directory.path(), "path job.toml part.nc -o points.csv");
    let text = fs::read_to_string(directory.path().join("points.csv")).unwrap();
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').map(String::from).collect()).collect()
}

/// Where the moves of a program end, machine coordinates.
fn ends(program: &str) -> Vec<String> {
    let rows = samples("moves = \"all\"\nsample_mm = 1000.0", program);
    let ends = rows.chunks(2).map(|pair| pair.last().unwrap());
    ends.map(|row| {
        row[2..5]
            .iter()
            .map(|mm| mm.trim_end_matches('0').trim_end_matches('.'))
            .collect::<Vec<_>>()
            .join(" ")
    })
    .collect()
}

fn refused(path: &str, program: &str) -> String {
    let directory = prepared(path, program);
    let output = nonius(directory.path(), "path job.toml part.nc -o points.csv", "");
    assert_eq!(
        output.status.code(),
        Some(2),
        "{program}: {}",
        String::from_utf8_lossy(&output.stdout)
    );
    assert!(!directory.path().join("points.csv").exists());
    said(&output)
}

const PART: &str = "%\nO1 (PART)\nG54 G0 X0 Y0 Z0\nG1 X10. F100\nG3 X20. Y10. I0 J10.\nG99 G81 X50. Y50. Z10. R20.\nX40. Y100.\nG80\nM30\n%\n";

/// By hand: e = (x/10, y/5, z/2). The holes' bottoms (50, 50, 10) and (40, 100, 10): (5, 10, 5),
/// (4, 20, 5); the largest above the second one, at R = 20: (4, 20, 10).
#[test]
fn the_page_says_what_was_calculated_by_hand() {
    let directory = prepared("sample_mm = 5.0", PART);
    let page = done(directory.path(), "path job.toml part.nc -v");
    for words in [
        "path 45.70",
        "3 straight moves, 1 arc, 2 holes, 5 rapid moves left out; places in machine coordinates",
        "largest error 22.716 µm",
        "holes, the worst first",
    ] {
        assert!(page.contains(words), "{words}: {page}");
    }
    let rows: Vec<Vec<&str>> = page
        .lines()
        .skip_while(|line| !line.starts_with("hole "))
        .skip(1)
        .take(2)
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(
        rows[0],
        ["2", "7", "40.000,", "100.000,", "10.000", "+4.000", "+20.000", "+5.000", "21.000"]
    );
    assert_eq!(
        rows[1],
        ["1", "6", "50.000,", "50.000,", "10.000", "+5.000", "+10.000", "+5.000", "12.247"]
    );
}

#[test]
fn every_sample_is_a_row() {
    let directory = prepared("sample_mm = 5.0", "G54 G1 X10. Y0\nG99 G81 X10. Z10. R20.\n");
    done(directory.path(), "path job.toml part.nc -o points.csv");
    let text = fs::read_to_string(directory.path().join("points.csv")).unwrap();
    let expected = "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held,hole
1,0.0000,0.0000,0.0000,0.0000,0.000000,0.000000,0.000000,0.000000,0.000000,0.000000,no,
1,5.0000,5.0000,0.0000,0.0000,0.500000,0.000000,0.000000,0.500000,0.500000,0.000000,no,
1,10.0000,10.0000,0.0000,0.0000,1.000000,0.000000,0.000000,1.000000,1.000000,0.000000,no,
2,10.0000,10.0000,0.0000,20.0000,1.000000,0.000000,10.000000,10.049876,-10.000000,,no,
2,15.0000,10.0000,0.0000,15.0000,1.000000,0.000000,7.500000,7.566373,-7.500000,,no,
2,20.0000,10.0000,0.0000,10.0000,1.000000,0.000000,5.000000,5.099020,-5.000000,,no,1
";
    assert_eq!(text, expected);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode =
            |name: &str| fs::metadata(directory.path().join(name)).unwrap().permissions().mode();
        assert_eq!(mode("points.csv"), mode("job.toml"));
    }
}

#[test]
fn pipes_carry_program_and_samples() {
    let directory = prepared("", PART);
    done(directory.path(), "path job.toml part.nc -o points.csv");
    let file = fs::read(directory.path().join("points.csv")).unwrap();
    let output = nonius(directory.path(), "path job.toml - -o -", PART);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(output.stdout, file);
    assert!(said(&output).contains("largest error 22.716 µm"));
    assert!(!directory.path().join("-").exists());
    for (arguments, words) in [
        ("path - -", "cannot both come from standard input"),
        ("path job.toml part.nc -o - --format json", "cannot both go to standard output"),
        ("path job.toml part.nc -o part.nc --force", "would replace or change `part.nc`"),
        ("path job.toml part.nc -o errors.csv --force", "would replace or change `errors.csv`"),
    ] {
        let output = nonius(directory.path(), arguments, "");
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        assert!(said(&output).contains(words), "{arguments}: {}", said(&output));
    }
    assert_eq!(fs::read_to_string(directory.path().join("part.nc")).unwrap(), PART);
}

#[test]
fn tables_take_the_error_off() {
    let directory = prepared("", PART);
    done(directory.path(), "generate job.toml -o kit");
    for tables in ["--tables kit", "--with-tables"] {
        let text = done(
            directory.path(),
            &format!("path job.toml part.nc {tables} --format json -o p.csv --force"),
        );
        let found: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(found["after"]["disagreements"], serde_json::json!([]));
        assert!(found["after"]["extremes"]["e"]["max"]["um"].as_f64().unwrap() < 1e-3, "{text}");
        assert!(found["worst_holes"][0]["after_e_um"].as_f64().unwrap() < 1e-3);
    }
    let head = fs::read_to_string(directory.path().join("p.csv")).unwrap();
    assert!(head.lines().next().unwrap().ends_with(
        ",hole,after_ex_um,after_ey_um,after_ez_um,after_e_um,after_tangent_um,after_normal_um"
    ));
    // Another machine: the files are no longer those of the job.
    fs::write(directory.path().join("errors.csv"), ERRORS.replace("x,100,10", "x,100,-10"))
        .unwrap();
    let page = done(directory.path(), "path job.toml part.nc --tables kit");
    let paragraphs: Vec<&str> = page.split("\n\n").collect();
    assert!(
        paragraphs[0].contains("profile accuracy")
            && paragraphs[0].contains("\njob and tables DISAGREE:\n  - "),
        "{page}"
    );
}

/// Two samples lie far away from two millions of others.
#[test]
fn profile_accuracy_is_exact_beyond_a_million_samples() {
    let program = "G54 G1 X0 Y0 Z0\nM98 P2 L4000\nG0 X100. Y100.\nG1 Z1.\nM30\nO2\nX1. Y0.5\nX0 Y0 Z0.5\nZ0\nM99\n";
    let found = summary("sample_mm = 0.005", program);
    assert!(found["samples"].as_u64().unwrap() > 1_900_000, "{found}");
    // Between (0, 0, 0) and (100, 100, 1): (10, 20, 0.5) µm.
    let accuracy = (100.0_f64 + 400.0 + 0.25).sqrt();
    for key in ["profile_accuracy_um", "profile_accuracy_at_most_um"] {
        assert!((found[key].as_f64().unwrap() - accuracy).abs() < 2e-6, "{key}: {}", found[key]);
    }
}

/// |e| along the line from (0, 50, 0) to (100, 0, 0), where e = (10 t, 10 (1 − t), 0), is least
/// inside. Components, tangent and normal take no value there that they did not take before.
#[test]
fn the_smallest_error_is_exact() {
    let before = "G54 G0 X0 Y100. Z20.\nG1 X100. Y0\nX90.\nX100.\nZ0\nG0 X0 Y50.\n";
    let found = summary("sample_mm = 1000.0", &format!("{before}G1 X100. Y0\n"));
    let least = &found["extremes"]["e"]["min"];
    assert!((least["um"].as_f64().unwrap() - 50.0_f64.sqrt()).abs() < 2e-6, "{least}");
    assert!((least["at_mm"][0].as_f64().unwrap() - 50.0).abs() < 1e-6, "{least}");
    assert_eq!(least["line"], 7);
}

#[test]
fn a_cycle_follows_zero_and_length() {
    let start = "G54 G0 X0 Y0 Z50.\nG99 G81 X10. Y10. Z5. R20.\n";
    let hole = |change: &str| ends(&format!("{start}{change} X20.\nG80\n"))[5..].to_vec();
    assert_eq!(hole(""), ["20 10 20", "20 10 5", "20 10 20"]);
    assert_eq!(hole("G55")[1..], ["20 10 50", "20 10 35", "20 10 50"]);
    let length = ends("G54 G0 X0 Y0 Z50.\nG43 H0\nG99 G81 X10. Y10. Z5. R20.\nH1 X20.\nG80\n");
    assert_eq!(length[length.len() - 2..], ["20 10 17.5", "20 10 32.5"]);
    for program in [
        "G54 G0 Z50.\nG98 G81 X10. Z5. R20.\nG55 X20.\n",
        "G54 G0 Z50.\nG43 H1\nG91 G99 G81 X10. Z-5. R-20.\n",
    ] {
        assert!(refused("", program).contains("controls differ in where that is now"), "{program}");
    }
}

#[test]
fn a_length_that_is_made_up_for_acts_once() {
    let start = "G54 G0 G43 H1 X0 Y0 Z50.\n";
    let last = |program: &str| ends(&format!("{start}{program}")).last().unwrap().clone();
    assert_eq!(last("G49 G53 Z90.\nG91 G1 Z-5.\n"), "0 0 85");
    assert_eq!(last("G1 X5.\nG91 G28 Z0 G49\n"), "5 0 0");
    assert_eq!(ends(&format!("{start}G91 G28 Z0 G49\n")), ["0 0 62.5", "0 0 0"]);
    assert_eq!(last("G49\nG91 G1 Z-5.\n"), "0 0 45");
}

#[test]
fn safety_lines_and_look_ahead_are_words() {
    assert_eq!(ends("G0 G17 G40 G49 G80 G90 G54\nX5.\nG80 G1 Y5.\n"), ["5 0 0", "5 5 0"]);
    let found = summary("", "G54 G5.1 Q1\nG05 P10000\nG8 P1\nG1 X5.\nG5.1 Q0\n");
    assert!(
        found["notes"].to_string().contains("look-ahead (G5, G5.1, G8) is switched on 3 times")
    );
    // Words of the line of O are executed, each time.
    assert_eq!(
        ends("G54 G0 X1.\nM98 P2 L2\nM30\nO2 G91 X10.\nG90 Y5.\nM99\n"),
        ["1 0 0", "11 0 0", "11 5 0", "21 5 0"]
    );
    // A byte order mark, and CR LF.
    assert_eq!(ends("\u{feff}O1\r\nG54 G0 X5.\r\nM30\r\n"), ["5 0 0"]);
}

/// Both directions make the full circle where start and end lie in one direction from the centre.
#[test]
fn an_arc_to_its_own_direction_is_a_full_circle() {
    for word in ["G2", "G3"] {
        let found = summary("", &format!("G54 G0 X60. Y50. Z0\n{word} X60.005 Y50. I-10.\n"));
        let length = found["length_mm"].as_f64().unwrap();
        assert!((length - 20.0025 * std::f64::consts::PI).abs() < 0.02, "{word}: {length}");
    }
}

#[test]
fn what_controls_do_differently_or_not_at_all_is_refused() {
    for (program, words) in [
        ("G54 G1 X5.\nG10 L2 P0 X5.\n", "`G10 L2 P0` is not executed"),
        ("G54 G1 X5.\nM98 P2\nX9.\nM30\n%\nO2\nX6.\n%\n", "ends without M99"),
        ("G54 G1 X5.\nX6. %\n", "part.nc:2:5"),
        ("G54 G43 G1 Z5.\n", "`G43` without H"),
        ("G54 G0 X5.\r(end)\rG1 X9. ; all\rX20.\r", "a carriage return inside a line"),
        ("G54 G0 X5.\nG81 X10. Z5. R9.\nG80 X20.\n", "no motion is active (after `G80`"),
        ("G54 G1 X10,5\n", "write numbers with a point"),
        ("G54 G1 X5.\nM8 M98 P77\n", "part.nc:2:4"),
        ("G54 G5.1 Q2\nG1 X5.\n", "splines and smoothing change the path"),
    ] {
        let said = refused("", program);
        assert!(said.contains(words), "{program}: {said}");
    }
}

#[test]
fn a_fault_is_told_once() {
    let said = refused("", "G54 G1 X5.\nM98 P2 L30\nX10. Y[1/0]\nM30\nO2\nX#1\nM99\n");
    assert_eq!(said.matches("problem: ").count(), 2, "{said}");
    assert!(said.contains("part.nc:3:9") && said.contains("part.nc:6:2"), "{said}");
    let said = refused("", "G65 P9010 X5.\n");
    assert_eq!(said.matches("problem: ").count(), 1, "{said}");
}

#[test]
fn places_of_the_job_outside_the_travel_are_refused() {
    for (path, words) in [
        (
            "start_mm = { x = 5000.0, y = 0.0, z = 0.0 }",
            "puts X at 5000 mm, outside the travel 0 … 100 mm",
        ),
        ("second_reference_mm = { x = 0.0, y = -1.0, z = 0.0 }", "puts Y at -1 mm"),
        ("[[path.datum]]\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 99999.0", "puts Z at 99999 mm"),
    ] {
        let said = refused(path, "G54 G1 X5.\n");
        assert!(said.contains(words), "{path}: {said}");
    }
}

#[test]
fn a_datum_stands_in_the_headline() {
    let directory =
        prepared("[[path.datum]]\nx_mm = 100.0\ny_mm = 0.0\nz_mm = 0.0", "G54 G1 X50.\n");
    let page = done(directory.path(), "path job.toml part.nc -v");
    assert!(
        page.contains("largest error 10.000 µm")
            && page.contains("all of them less the mean error at 1 probed place"),
        "{page}"
    );
}

#[test]
fn two_ways_to_the_tool_are_told() {
    let directory = prepared("", "G54 G43 H1 G1 X50. Z20.\n");
    let job = fs::read_to_string(directory.path().join("job.toml")).unwrap();
    let with_tool = job
        .replace("active_while", "tool_offset_mm = { x = 0.0, y = 0.0, z = -50.0 }\nactive_while");
    fs::write(directory.path().join("job.toml"), with_tool).unwrap();
    let page = done(directory.path(), "path job.toml part.nc -v");
    assert!(
        page.contains("CHECK: `tool_offset_mm` of [measurement] and the tool length of G43"),
        "{page}"
    );
}

/// Letters and numbers of a line, as this crate reads them; `None` where it refuses the line.
fn own(line: &str) -> Option<Vec<(char, f64)>> {
    let words: Result<Vec<scan::Word>, scan::Wrong> = scan::words(line.as_bytes()).collect();
    let words = words.ok()?;
    Some(words.iter().map(|word| (char::from(word.letter), word.value)).collect())
}

/// The same as the crate `gcode` reads them (numbers of single precision).
fn theirs(line: &str) -> Option<Vec<(char, f64)>> {
    use gcode::{Code, Value};
    let value = |value: &Value| match value {
        Value::Literal(number) => f64::from(*number),
        _ => f64::NAN,
    };
    let mut words = Vec::new();
    for block in gcode::parse(line).ok()?.blocks {
        words.extend(block.line_number.map(|number| ('N', f64::from(number))));
        for code in &block.codes {
            let (letter, number, arguments) = match code {
                Code::General(code) => ('G', code.number, &code.args),
                Code::Miscellaneous(code) => ('M', code.number, &code.args),
                Code::ToolChange(code) => ('T', code.number, &code.args),
                _ => return None,
            };
            let tenth = number.minor().map_or(0, std::num::NonZeroU32::get);
            words.push((letter, f64::from(number.major()) + f64::from(tenth) / 10.0));
            words
                .extend(arguments.iter().map(|a| (a.letter.to_ascii_uppercase(), value(&a.value))));
        }
        let bare = block.word_addresses.iter();
        words.extend(bare.map(|a| (a.letter.to_ascii_uppercase(), value(&a.value))));
    }
    Some(words)
}

/// Compares the words of a line without regard to their order.
fn same_words(line: &str) -> Result<(), String> {
    let (Some(mut own), Some(mut theirs)) = (own(line), theirs(line)) else {
        return Err(format!("{line:?} is read by one of the two only"));
    };
    let order = |a: &(char, f64), b: &(char, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    own.sort_by(order);
    theirs.sort_by(order);
    let near = |a: &(char, f64), b: &(char, f64)| {
        a.0 == b.0 && (a.1 - b.1).abs() <= f64::from(f32::EPSILON) * (1e-3 + a.1.abs())
    };
    if own.len() == theirs.len() && own.iter().zip(&theirs).all(|(a, b)| near(a, b)) {
        Ok(())
    } else {
        Err(format!("{line:?}: {own:?}, {theirs:?}"))
    }
}

fn number() -> impl Strategy<Value = String> {
    (any::<bool>(), 0_u32..20_000, proptest::option::of("[0-9]{1,4}")).prop_map(
        |(minus, whole, decimals)| {
            let mut text = format!("{}{whole}", if minus { "-" } else { "" });
            if let Some(decimals) = decimals {
                let _ = write!(text, ".{decimals}");
            }
            text
        },
    )
}

/// A line such as `N10 G1 X1.5Y-2 (comment) F100`.
fn line() -> impl Strategy<Value = String> {
    let code = prop::sample::select(vec![
        "G0", "G01", "g2", "G54", "G54.1", "G91.1", "M3", "m8", "M98", "T12",
    ]);
    let words = proptest::collection::vec(
        (prop::sample::select("XYZIJKRFSPQHDLxyz".chars().collect::<Vec<_>>()), number()),
        0..7,
    );
    let comment = prop::sample::select(vec!["", " (a comment)", " ; the rest"]);
    (
        proptest::option::of(1_u32..99_999),
        proptest::collection::vec(code, 0..3),
        words,
        any::<bool>(),
        comment,
    )
        .prop_map(|(n, codes, words, spaced, comment)| {
            let mut parts: Vec<String> = n.iter().map(|n| format!("N{n}")).collect();
            parts.extend(codes.iter().map(|code| (*code).to_string()));
            parts.extend(words.iter().map(|(letter, number)| format!("{letter}{number}")));
            parts.join(if spaced { " " } else { "" }) + comment
        })
}

proptest! {
    #[test]
    fn words_are_those_that_another_scanner_reads(line in line()) {
        prop_assert!(same_words(&line).is_ok(), "{}", same_words(&line).unwrap_err());
    }
}

/// Lines of the fixtures without what only one of the two knows (`#`, `[ ]`, `/`, `%`, O).
#[test]
fn fixtures_are_read_as_another_scanner_reads_them() {
    let cases = refusals::all(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures")));
    let files = cases.into_iter().flat_map(|case| case.files);
    let mut compared = 0;
    for (_, bytes) in files.filter(|(name, _)| name.ends_with(".nc")) {
        let text = String::from_utf8(bytes).unwrap();
        for line in text.lines().chain(PART.lines()) {
            let plain = !line.contains(['#', '[', '/', '%', 'O']);
            if plain && own(line).is_some() {
                same_words(line).unwrap();
                compared += 1;
            }
        }
    }
    assert!(compared > 20, "{compared}");
}
