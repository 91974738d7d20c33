//! `nonius path` (what it refuses: fixtures/cases/refuses/path.txt), and its scanner against one by others.

use crate::support::{Entry, Visit, fixtures, holds, number, refusals};
use part_program::{Language, Word, words};
use proptest::prelude::*;
use serde_json::json;

/// A machine of 100 mm an axis, whose error in µm is (x/10, y/5, z/2), a program, further lines of `[path]`.
fn visit(path: &str, program: &str) -> Visit {
    let visit = Visit::of("base/part");
    visit.edit("job.toml", "[path]\n", &format!("[path]\n{path}\n")).put("part.nc", program);
    visit
}

const PART: &str = "%\nO1 (PART)\nG54 G0 X0 Y0 Z0\nG1 X10. F100\nG3 X20. Y10. I0 J10.\nG99 G81 X50. Y50. Z10. R20.\nX40. Y100.\nG80\nM30\n%\n";

/// e = (x/10, y/5, z/2). Bottoms of the holes: (5, 10, 5), (4, 20, 5); the largest above the second, (4, 20, 10).
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

/// A byte order mark and CR LF are no part of the program.
#[test]
fn every_sample_is_a_row() {
    let visit = visit("sample_mm = 5.0", "\u{feff}G54 G1 X10. Y0\r\nG99 G81 X10. Z10. R20.\r\n");
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
    assert_eq!(visit.mode("points.csv"), visit.mode("job.toml"));
}

#[test]
fn pipes_carry_program_and_samples() {
    let visit = visit("", PART);
    visit.yes("path job.toml part.nc -o points.csv");
    let ran = visit.shell("cat part.nc | $N path job.toml - -o -").ends(0);
    assert_eq!(ran.out, visit.read("points.csv"));
    assert!(ran.err.contains("largest error 22.716 µm"), "{}", ran.err);
    assert!(!visit.has("-"));
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
    holds(first, &["profile accuracy", "\njob and tables DISAGREE:\n  - "]);
}

/// |e| from (0, 50, 0) to (100, 0, 0) is least inside; no component, tangent or normal takes a new value there.
#[test]
fn the_smallest_error_is_exact() {
    let before = "G54 G0 X0 Y100. Z20.\nG1 X100. Y0\nX90.\nX100.\nZ0\nG0 X0 Y50.\n";
    let visit = visit("sample_mm = 1000.0", &format!("{before}G1 X100. Y0\n"));
    let found = visit.run("path job.toml part.nc --format json").ends(0).json();
    let least = &found["extremes"]["e"]["min"];
    assert!((number(&least["um"]) - 50.0_f64.sqrt()).abs() < 2e-6, "{least}");
    assert!((number(&least["at_mm"][0]) - 50.0).abs() < 1e-6, "{least}");
    assert_eq!(least["line"], 7);
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
    let files = refusals::all(&fixtures("")).into_iter().flat_map(|case| case.files);
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
