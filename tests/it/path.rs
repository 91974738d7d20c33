//! `nonius path` through the program, and its scanner against one by others.

use crate::support::{Entry, Ran, Visit, fixtures, number, refusals};
use part_program::{Language, Word, words};
use proptest::prelude::*;
use serde_json::{Value, json};

/// 100 mm an axis; the error at a place in mm is (x/10, y/5, z/2) µm.
const ERRORS: &str = "axis,position_mm,ex_um,ey_um,ez_um
x,0,0,0,0\nx,100,10,0,0\ny,0,0,0,0\ny,100,0,20,0\nz,0,0,0,0\nz,100,0,0,50\n";

/// The machine with a program and further lines of `[path]`.
fn visit(path: &str, program: &str) -> Visit {
    let visit = Visit::of("base/path");
    let tool = "[[path.tool]]\nnumber = 1\nlength_mm = 12.5\n";
    let mut job = visit.read("job.toml") + path + "\n" + tool;
    for axis in ["x", "y", "z"] {
        job += &format!("[compensation.axes.{axis}]\nspacing_mm = 50.0\n");
    }
    for (system, z) in [("G54", 0.0), ("G55", 30.0)] {
        let place = format!("x_mm = 0.0\ny_mm = 0.0\nz_mm = {z:?}");
        job += &format!("[[path.offset]]\nsystem = \"{system}\"\n{place}\n");
    }
    visit.put("errors.csv", ERRORS).put("job.toml", job).put("part.nc", program);
    visit
}

fn summary(path: &str, program: &str) -> Value {
    visit(path, program).run("path job.toml part.nc --format json").ends(0).json()
}

/// Where the moves of a program end, machine coordinates.
fn ends(program: &str) -> Vec<String> {
    let visit = visit("moves = \"all\"\nsample_mm = 1000.0", program);
    visit.yes("path job.toml part.nc -o points.csv");
    let points = visit.read("points.csv");
    let rows: Vec<&str> = points.lines().skip(1).collect();
    let end = |pair: &[&str]| {
        let place = pair[pair.len() - 1].split(',').skip(2).take(3);
        let place = place.map(|mm| mm.trim_end_matches('0').trim_end_matches('.'));
        place.collect::<Vec<_>>().join(" ")
    };
    rows.chunks(2).map(end).collect()
}

#[track_caller]
fn refused(path: &str, program: &str) -> Ran {
    let visit = visit(path, program);
    let ran = visit.run("path job.toml part.nc -o points.csv").ends(2);
    assert!(!visit.has("points.csv"), "{program}");
    ran
}

const PART: &str = "%\nO1 (PART)\nG54 G0 X0 Y0 Z0\nG1 X10. F100\nG3 X20. Y10. I0 J10.\nG99 G81 X50. Y50. Z10. R20.\nX40. Y100.\nG80\nM30\n%\n";

/// By hand: e = (x/10, y/5, z/2). The holes' bottoms (50, 50, 10) and (40, 100, 10): (5, 10, 5),
/// (4, 20, 5); the largest above the second one, at R = 20: (4, 20, 10).
#[test]
fn the_page_says_what_was_calculated_by_hand() {
    let ran = visit("sample_mm = 5.0", PART).run("path job.toml part.nc -v").ends(0);
    let mut lines = ran.out.lines().skip_while(|line| !line.starts_with("hole ")).skip(1);
    for row in [
        "2 7 40.000, 100.000, 10.000 +4.000 +20.000 +5.000 21.000",
        "1 6 50.000, 50.000, 10.000 +5.000 +10.000 +5.000 12.247",
    ] {
        let cells: Vec<&str> = lines.next().unwrap().split_whitespace().collect();
        assert_eq!(cells.join(" "), row);
    }
    let moves =
        "3 straight moves, 1 arc, 2 holes, 5 rapid moves left out; places in machine coordinates";
    ran.tells(&["path 45.70", moves, "largest error 22.716 µm", "holes, the worst first"]);
}

#[test]
fn every_sample_is_a_row() {
    let visit = visit("sample_mm = 5.0", "G54 G1 X10. Y0\nG99 G81 X10. Z10. R20.\n");
    visit.yes("path job.toml part.nc -o points.csv");
    let expected = "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held,hole
1,0.0000,0.0000,0.0000,0.0000,0.000000,0.000000,0.000000,0.000000,0.000000,0.000000,no,
1,5.0000,5.0000,0.0000,0.0000,0.500000,0.000000,0.000000,0.500000,0.500000,0.000000,no,
1,10.0000,10.0000,0.0000,0.0000,1.000000,0.000000,0.000000,1.000000,1.000000,0.000000,no,
2,10.0000,10.0000,0.0000,20.0000,1.000000,0.000000,10.000000,10.049876,-10.000000,,no,
2,15.0000,10.0000,0.0000,15.0000,1.000000,0.000000,7.500000,7.566373,-7.500000,,no,
2,20.0000,10.0000,0.0000,10.0000,1.000000,0.000000,5.000000,5.099020,-5.000000,,no,1
";
    assert_eq!(visit.read("points.csv"), expected);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |name: &str| visit.at(name).metadata().unwrap().permissions().mode();
        assert_eq!(mode("points.csv"), mode("job.toml"));
    }
}

#[test]
fn pipes_carry_program_and_samples() {
    let visit = visit("", PART);
    visit.yes("path job.toml part.nc -o points.csv");
    let piped = "path job.toml - -o -";
    let output = visit.with_input(piped, PART.as_bytes());
    assert_eq!(output.stdout, visit.read("points.csv").as_bytes());
    let ran = Ran::of(piped, &output).ends(0);
    assert!(ran.err.contains("largest error 22.716 µm"), "{}", ran.err);
    assert!(!visit.has("-"));
    for (arguments, words) in [
        ("path - -", "cannot both come from standard input"),
        ("path job.toml part.nc -o - --format json", "cannot both go to standard output"),
        ("path job.toml part.nc -o errors.csv --force", "would replace or change `errors.csv`"),
    ] {
        visit.run(arguments).ends(2).says(words);
    }
}

#[test]
fn tables_take_the_error_off() {
    let visit = visit("", PART).with_kit();
    for tables in ["--tables kit", "--with-tables"] {
        let command = format!("path job.toml part.nc {tables} --format json -o p.csv --force");
        let found = visit.run(&command).ends(0).json();
        assert_eq!(found["after"]["disagreements"], json!([]));
        assert!(number(&found["after"]["extremes"]["e"]["max"]["um"]) < 1e-3, "{found}");
        assert!(number(&found["worst_holes"][0]["after_e_um"]) < 1e-3);
    }
    let after =
        ",hole,after_ex_um,after_ey_um,after_ez_um,after_e_um,after_tangent_um,after_normal_um";
    assert!(visit.read("p.csv").lines().next().unwrap().ends_with(after));
    // Another machine: the files are no longer those of the job.
    visit.edit("errors.csv", "x,100,10", "x,100,-10");
    let page = visit.yes("path job.toml part.nc --tables kit");
    let (first, _) = page.split_once("\n\n").unwrap();
    assert!(first.contains("profile accuracy"), "{page}");
    assert!(first.contains("\njob and tables DISAGREE:\n  - "), "{page}");
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
        assert!((number(&found[key]) - accuracy).abs() < 2e-6, "{key}: {}", found[key]);
    }
}

/// |e| along the line from (0, 50, 0) to (100, 0, 0), where e = (10 t, 10 (1 − t), 0), is least
/// inside. Components, tangent and normal take no value there that they did not take before.
#[test]
fn the_smallest_error_is_exact() {
    let before = "G54 G0 X0 Y100. Z20.\nG1 X100. Y0\nX90.\nX100.\nZ0\nG0 X0 Y50.\n";
    let found = summary("sample_mm = 1000.0", &format!("{before}G1 X100. Y0\n"));
    let least = &found["extremes"]["e"]["min"];
    assert!((number(&least["um"]) - 50.0_f64.sqrt()).abs() < 2e-6, "{least}");
    assert!((number(&least["at_mm"][0]) - 50.0).abs() < 1e-6, "{least}");
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
    // A length that is made up for acts once.
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
    let look_ahead = "G54 G5.1 Q1\nG05 P10000\nG8 P1\nG1 X5.\nG5.1 Q0\n";
    let notes = summary("", look_ahead)["notes"].to_string();
    assert!(notes.contains("look-ahead (G5, G5.1, G8) is switched on 3 times"), "{notes}");
    // Words of the line of O are executed, each time.
    let called = ends("G54 G0 X1.\nM98 P2 L2\nM30\nO2 G91 X10.\nG90 Y5.\nM99\n");
    assert_eq!(called, ["1 0 0", "11 0 0", "11 5 0", "21 5 0"]);
    // A byte order mark, and CR LF.
    assert_eq!(ends("\u{feff}O1\r\nG54 G0 X5.\r\nM30\r\n"), ["5 0 0"]);
}

/// Both directions make the full circle where start and end lie in one direction from the centre.
#[test]
fn an_arc_to_its_own_direction_is_a_full_circle() {
    for word in ["G2", "G3"] {
        let found = summary("", &format!("G54 G0 X60. Y50. Z0\n{word} X60.005 Y50. I-10.\n"));
        let length = number(&found["length_mm"]);
        assert!((length - 20.0025 * std::f64::consts::PI).abs() < 0.02, "{word}: {length}");
    }
}

#[test]
fn what_controls_do_differently_or_not_at_all_is_refused() {
    const OPEN: &str = "controls differ in where that is now";
    for (program, words) in [
        ("G54 G0 Z50.\nG98 G81 X10. Z5. R20.\nG55 X20.\n", OPEN),
        ("G54 G0 Z50.\nG43 H1\nG91 G99 G81 X10. Z-5. R-20.\n", OPEN),
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
        refused("", program).says(words);
    }
    // A fault is told once.
    let ran = refused("", "G54 G1 X5.\nM98 P2 L30\nX10. Y[1/0]\nM30\nO2\nX#1\nM99\n");
    assert_eq!(ran.err.matches("problem: ").count(), 2, "{}", ran.err);
    ran.says("part.nc:3:9").says("part.nc:6:2");
    let ran = refused("", "G65 P9010 X5.\n");
    assert_eq!(ran.err.matches("problem: ").count(), 1, "{}", ran.err);
}

#[test]
fn places_of_the_job_outside_the_travel_are_refused() {
    let outside = "puts X at 5000 mm, outside the travel 0 … 100 mm";
    for (path, words) in [
        ("start_mm = { x = 5000.0, y = 0.0, z = 0.0 }", outside),
        ("second_reference_mm = { x = 0.0, y = -1.0, z = 0.0 }", "puts Y at -1 mm"),
        ("[[path.datum]]\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 99999.0", "puts Z at 99999 mm"),
    ] {
        refused(path, "G54 G1 X5.\n").says(words);
    }
}

#[test]
fn a_datum_stands_in_the_headline_and_two_ways_to_the_tool_are_told() {
    let datum = "[[path.datum]]\nx_mm = 100.0\ny_mm = 0.0\nz_mm = 0.0";
    let ran = visit(datum, "G54 G1 X50.\n").run("path job.toml part.nc -v").ends(0);
    ran.says("largest error 10.000 µm").says("all of them less the mean error at 1 probed place");
    let visit = visit("", "G54 G43 H1 G1 X50. Z20.\n");
    let offset = "tool_offset_mm = { x = 0.0, y = 0.0, z = -50.0 }\nactive_while";
    visit.edit("job.toml", "active_while", offset);
    let check = "CHECK: `tool_offset_mm` of [measurement] and the tool length of G43";
    visit.run("path job.toml part.nc -v").ends(0).says(check);
}

/// Letters and numbers of a line, as this crate reads them; `None` where it refuses the line.
fn own(line: &str) -> Option<Vec<(char, f64)>> {
    let word = |word: Word| (char::from(word.letter), word.value);
    words(line.as_bytes(), Language::Iso).map(|read| read.map(word).ok()).collect()
}

/// The same as the crate `gcode` reads them (numbers of single precision).
fn theirs(line: &str) -> Option<Vec<(char, f64)>> {
    use gcode::{Code, Value};
    let value = |value: &Value| match value {
        Value::Literal(number) => f64::from(*number),
        _ => f64::NAN,
    };
    let word = |a: &gcode::Argument| (a.letter.to_ascii_uppercase(), value(&a.value));
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
            words.extend(arguments.iter().map(word));
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
    for words in [&mut own, &mut theirs] {
        words.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }
    let near = |(a, b): (&(char, f64), &(char, f64))| {
        a.0 == b.0 && (a.1 - b.1).abs() <= f64::from(f32::EPSILON) * (1e-3 + a.1.abs())
    };
    let same = own.len() == theirs.len() && own.iter().zip(&theirs).all(near);
    same.then_some(()).ok_or_else(|| format!("{line:?}: {own:?}, {theirs:?}"))
}

fn value() -> impl Strategy<Value = String> {
    let parts = (any::<bool>(), 0_u32..20_000, 0_u32..10_000, 0_usize..5);
    parts.prop_map(|(minus, whole, decimals, places)| {
        let decimals = if places == 0 { String::new() } else { format!(".{decimals:0places$}") };
        format!("{}{whole}{decimals}", if minus { "-" } else { "" })
    })
}

/// A line such as `N10 G1 X1.5Y-2 (comment) F100`.
fn line() -> impl Strategy<Value = String> {
    let code = prop::sample::select(vec![
        "G0", "G01", "g2", "G54", "G54.1", "G91.1", "M3", "m8", "M98", "T12",
    ]);
    let letters = prop::sample::select("XYZIJKRFSPQHDLxyz".chars().collect::<Vec<_>>());
    let words = proptest::collection::vec((letters, value()), 0..7);
    let comment = prop::sample::select(vec!["", " (a comment)", " ; the rest"]);
    let number = proptest::option::of(1_u32..99_999);
    let codes = proptest::collection::vec(code, 0..3);
    let parts = (number, codes, words, any::<bool>(), comment);
    parts.prop_map(|(n, codes, words, spaced, comment)| {
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
    let cases = refusals::all(&fixtures(""));
    let files = cases.into_iter().flat_map(|case| case.files);
    let mut compared = 0;
    for (_, entry) in files.filter(|(name, _)| name.ends_with(".nc")) {
        let Entry::File(bytes) = entry else { continue };
        let text = String::from_utf8(bytes).unwrap();
        let is_plain = |line: &&str| !line.contains(['#', '[', '/', '%', 'O']);
        let plain = text.lines().chain(PART.lines()).filter(is_plain);
        for line in plain.filter(|line| own(line).is_some()) {
            same_words(line).unwrap();
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}
