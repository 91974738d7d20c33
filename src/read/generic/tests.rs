use super::*;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, builtin};
use crate::control::table::Tables;
use crate::quantity::Millimetres;
use crate::read::emulate::{Emulated, Emulator};
use crate::read::emulator;
use crate::text::Problem;
use std::fmt::Write;

const HEADER: &str = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um\n";
/// Lines 2 to 4 of the file, then 5 and 6.
const EXX: &str = "EXX,X,X,,0,-50,0,0,\nEXX,X,X,,1,0,1.5,-1.5,-1.5\nEXX,X,X,,2,50,-1,1,2.5\n";
const EYX: &str = "EYX,X,Y,+,0,0,0,0,\nEYX,X,Y,+,1,25.4,0.1,-0.1,-0.1\n";

fn csv_text() -> String {
    format!("{HEADER}{EXX}{EYX}")
}

/// The JSON twin of a CSV in the order of the contract, one row on a line from line 2 on.
fn json_text(csv: &str) -> String {
    let mut text = "{\"schema\":1,\"rows\":[".to_string();
    for (number, line) in csv.lines().skip(1).enumerate() {
        let comma = if number == 0 { "" } else { "," };
        let cells = COLUMNS.iter().enumerate().zip(line.split(','));
        let cells = cells.map(|((place, column), cell)| match (cell, place) {
            ("", _) => format!("\"{column}\":null"),
            (cell, 4..) => format!("\"{column}\":{cell}"),
            (cell, _) => format!("\"{column}\":\"{cell}\""),
        });
        let cells: Vec<String> = cells.collect();
        write!(text, "{comma}\n{{{}}}", cells.join(",")).expect("a string");
    }
    text + "\n]}\n"
}

fn table(text: &str) -> Vec<GenericRow> {
    read("table", text).unwrap_or_else(|problems| panic!("{text}\n{problems}"))
}

/// Each problem as `line:column message`; all have a help text.
fn flaws(text: &str) -> Vec<String> {
    let problems = read("table", text).expect_err(text);
    let shown = |problem: &Problem| {
        let place = problem.place.as_ref().expect("a place");
        assert!(problem.help.is_some(), "{problem:?}");
        format!("{}:{} {}", place.line, place.column, problem.message)
    };
    problems.iter().map(shown).collect()
}

/// Each case replaces a part of `text` (`¶` is a line end) and names a problem by its place and
/// words: `part | replacement | line:column | words`. All misses are shown at once.
fn check(text: &str, cases: &str) {
    let mut misses = String::new();
    for case in cases.trim().lines().filter(|line| !line.starts_with("--")) {
        let cells: Vec<String> =
            case.split('|').map(|cell| cell.trim().replace('¶', "\n")).collect();
        let [from, to, place, words] = &cells[..] else {
            panic!("four cells: {case}");
        };
        assert!(text.contains(from), "{case}");
        let found = flaws(&text.replacen(from, to, 1));
        let fits = |flaw: &String| flaw.starts_with(&format!("{place} ")) && flaw.contains(words);
        if !found.iter().any(fits) {
            writeln!(misses, "{case}: {found:#?}").expect("a string");
        }
    }
    assert!(misses.is_empty(), "{misses}");
}

#[test]
fn a_row_is_read_as_it_stands() {
    let rows = table(&csv_text());
    let expected = GenericRow {
        term: "EYX".into(),
        base_axis: "X".into(),
        output_axis: "Y".into(),
        direction: Some("+".into()),
        index: 1,
        position_mm: 25.4,
        deviation_um: 0.1,
        correction_um: -0.1,
        increment_um: Some(-0.1),
    };
    assert_eq!((rows.len(), &rows[4]), (5, &expected));
    assert_eq!((&rows[0].direction, rows[0].increment_um), (&None, None));
}

#[test]
fn what_means_the_same_is_read_the_same() {
    let plain = csv_text();
    let swapped: String = plain
        .lines()
        .map(|line| line.split(',').rev().collect::<Vec<_>>().join(",") + "\n")
        .collect();
    let lines: Vec<&str> = plain.lines().collect();
    let cases = [
        ("JSON", json_text(&plain)),
        ("JSON on one line", json_text(&plain).replace('\n', "")),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("other order of columns", swapped),
        ("no line end at the end", plain.trim_end().to_string()),
        ("blank lines", format!("\n{plain}\n \n")),
        ("byte order mark", format!("\u{feff}{plain}")),
        ("quotes and blanks", plain.replace(",X,", ", \"X\" ,")),
        ("negative zero", plain.replace(",0,0,\n", ",0,-0,\n")),
        ("exponents", plain.replace(",50,", ",5e1,")),
    ];
    for (case, text) in cases {
        assert_eq!(table(&text), table(&plain), "{case}");
    }
    let interleaved = [0, 1, 4, 2, 5, 3].map(|line| lines[line]).join("\n");
    assert_eq!(table(&interleaved).len(), 5);
}

#[test]
fn each_flaw_of_a_csv_is_refused_at_its_place() {
    check(&csv_text(), CSV_FLAWS);
}

const CSV_FLAWS: &str = r#"
-- the header
index             | indx               | 1:38 | unknown column `indx`
index,            |                    | 1:1  | no column `index`
increment_um      | increment_um,index | 1:96 | `index` stands in the header twice
increment_um      | increment_um,      | 1:96 | unknown column ``
,base_axis,       | ;base_axis;        | 1:1  | no column `term`
-- the cells of a row
1.5,-1.5,-1.5     | 1.5,-1.5           | 3:1  | the row has 8 cells, expected 9
,-0.1,-0.1¶       | ,-0.1              | 6:1  | the row has 8 cells, expected 9
EYX,X,Y,+,1,25.4,0.1,-0.1,-0.1¶ | EYX  | 6:1  | the row has 1 cell, expected 9
1.5,-1.5          | 1,5,-1.5           | 3:1  | the row has 10 cells, expected 9
EYX,X,Y,+,1       | # note¶EYX,X,Y,+,1 | 6:1  | the row has 1 cell, expected 9
EXX,X,X,,2        | EXX,"X,X,,2        | 4:1  | a quotation mark is opened but not closed
EXX,X,X,,2        | EXW,X,X,,2         | 4:1  | `term` is `EXW`, expected the name of a term
EXX,X,X,,2        | exx,X,X,,2         | 4:1  | `term` is `exx`
EXX,X,X,,2        | ,X,X,,2            | 4:1  | `term` is ``
EXX,X,X,,2        | EXX,,X,,2          | 4:5  | `base_axis` is ``, expected the name of an axis
EXX,X,X,,2        | EXX,X,X"",,2       | 4:7  | expected the name of an axis
EXX,X,X,,2        | EXX,X,X,0,2        | 4:9  | `direction` is `0`, expected `+`, `-` or nothing
EXX,X,X,,2        | EXX,X,X,,2.0       | 4:10 | `index` is `2.0`, expected a whole number from 0
EXX,X,X,,2        | EXX,X,X,,-2        | 4:10 | expected a whole number
EXX,X,X,,2        | EXX,X,X,,4294967296| 4:10 | expected a whole number
EXX,X,X,,2        | EXX,X,X,,          | 4:10 | `index` is ``
2,50,             | 2,NaN,             | 4:12 | `position_mm` is `NaN`, expected a finite number
2,50,             | 2,-inf,            | 4:12 | expected a finite number
2,50,             | 2,1e400,           | 4:12 | `position_mm` is `1e400`, expected a finite number
2,50,             | 2,50mm,            | 4:12 | expected a finite number
2,50,             | 2,,                | 4:12 | `position_mm` is empty
50,-1,1,2.5       | 50,,1,2.5          | 4:15 | `deviation_um` is empty
50,-1,1,2.5       | 50,-1,,2.5         | 4:18 | `correction_um` is empty
50,-1,1,2.5       | 50,-1,1,           | 4:20 | `increment_um` is empty
50,-1,1,2.5       | 50,-1,1,nan        | 4:20 | `increment_um` is `nan`
-50,0,0,          | -50,0,0,0          | 2:20 | `increment_um` is `0`, expected nothing at index 0
50,-1,1,2.5       | 50,1,1,2.5         | 4:17 | expected -1, the opposite of the deviation
50,-1,1,          | 50,-1.0000000001,1,| 4:29 | the opposite of the deviation
-- the rows of a block
50,-1,1,2.5       | 50,-1,1,2.50000001 | 4:20 | expected 2.5, the change of the correction
50,-1,1,2.5       | 50,-1,1,-2.5       | 4:20 | the change of the correction
EXX,X,X,,0,-50,0,0,¶         |         | 2:10 | `index` is 1, expected 0
EXX,X,X,,1,0,1.5,-1.5,-1.5¶  |         | 3:10 | `index` is 2, expected 1
EYX,X,Y,+,0       | EXX,X,X,,0         | 5:10 | `index` is 0, expected 3
EYX,X,Y,+,1       | EYX,X,Y,-,1        | 6:11 | `index` is 1, expected 0
EYX,X,Y,+,1,25.4,0.1,-0.1,-0.1¶ |      | 5:1  | block of one point
2,50,             | 2,0,               | 4:12 | `position_mm` is 0, expected more than 0
2,50,             | 2,-60,             | 4:12 | `position_mm` is -60, expected more than 0
2,50,             | 2,50.00001,        | 4:12 | expected 50 mm
1,0,1.5           | 1,0.1,1.5          | 3:12 | 50.1 mm after the row before
-- terms and axes
EYX,X,Y,+,0       | EYX,X,X,+,0        | 5:7  | `X` stands for the Y axis in EYX, but for the X axis
EYX,X,Y,+,0       | EYZ,x,Y,+,0        | 5:5  | `x` stands for the Z axis in EYZ
-- the directions of a pair of axes
+,1,25.4,0.1,-0.1,-0.1¶ | +,1,25.4,0.1,-0.1,-0.1¶EYX,X,Y,,0,0,0,0,¶EYX,X,Y,,1,25.4,0,0,0¶ | 7:9 | blocks with and without direction
+,1,25.4,0.1,-0.1,-0.1¶ | +,1,25.4,0.1,-0.1,-0.1¶EYX,X,Y,-,0,0,0,0,¶EYX,X,Y,-,1,25,0,0,0¶ | 6:13 | a position that the block of the other direction does not have
+,1,25.4,0.1,-0.1,-0.1¶ | +,1,25.4,0.1,-0.1,-0.1¶EYX,X,Y,-,0,0,0,0,¶EYX,X,Y,-,1,25.4,0,0,0¶EYX,X,Y,-,2,50.8,0,0,0¶ | 9:13 | a position that the block of the other
"#;

#[test]
fn each_flaw_of_a_json_is_refused_at_its_place() {
    check(&json_text(&csv_text()), JSON_FLAWS);
}

const JSON_FLAWS: &str = r#"
-- the file
¶]}             |                          | 7:1   | EOF while parsing a list
]}              | ]}]                      | 7:3   | trailing characters
-0.1}           | NaN}                     | 6:149 | expected value
-0.1}           | 1e999}                   | 6:153 | number out of range
{"schema":1,    | {                        | 7:2   | missing field `schema`
"schema":1      | "schema":2               | 1:1   | `schema` is 2, expected 1
"schema":1      | "schema":"1"             | 1:13  | invalid type: string "1"
"schema":1      | "schema":1,"unit":"mm"   | 1:18  | unknown field `unit`
"schema":1      | "schema":1,"schema":1    | 1:20  | duplicate field `schema`
"rows":[        | "rows":[5,               | 1:21  | invalid type: integer `5`, expected an object
-- the keys of a row
"term"          | "trm"                    | 2:6   | unknown field `trm`
"index":0,      |                          | 2:138 | missing field `index`
"direction":null, |                        | 2:131 | missing field `direction`
"index":0       | "index":0,"index":0      | 2:82  | duplicate field `index`
"EXX"           | 7                        | 2:9   | invalid type: integer `7`
"EXX"           | {"EXX":["}"]}            | 2:8   | invalid type: map
"base_axis":"X" | "base_axis":null         | 2:30  | invalid type: null
"base_axis":"X" | "base_axis":""           | 2:15  | `base_axis` is ``
null            | ""                       | 2:49  | `direction` is ``, expected `+`, `-` or nothing
null            | 0                        | 2:61  | invalid type: integer `0`
"index":0       | "index":0.0              | 2:76  | invalid type: floating point `0.0`
:-50            | :"-50"                   | 2:94  | invalid type: string "-50"
"deviation_um":0| "deviation_um":null      | 2:112 | invalid type: null
null}           | 0}                       | 2:129 | expected nothing at index 0
"correction_um":1,| "correction_um":2,     | 4:111 | rows[2]: `correction_um` is 2, expected 1
-- the rows of a block
"index":2       | "index":3                | 4:66  | rows[2]: `index` is 3, expected 2
:2.5            | :2                       | 4:129 | rows[2]: `increment_um` is 2, expected 2.5
:50,            | :60,                     | 4:76  | rows[2]: `position_mm` is 60 mm after
"#;

/// Files without a single row.
#[test]
fn a_file_without_rows_is_refused() {
    let cases = [
        ("", "1:1 the file is empty, expected a generic table"),
        ("\r\n \n", "1:1 the file is empty, expected a generic table"),
        (HEADER, "1:1 the table has no rows"),
        ("{\"schema\":1,\"rows\":[ ]}", "1:13 the table has no rows"),
        (
            "{\"schema\":1,\"rows\":{}}",
            "1:19 the JSON cannot be read: invalid type: map, expected a sequence",
        ),
    ];
    for (text, flaw) in cases {
        assert_eq!(flaws(text), [flaw], "{text}");
    }
}

/// A flaw is told once: a block that lost a row is not searched for the gap.
#[test]
fn a_flaw_brings_no_others() {
    let cases = [
        ("1,0,1.5", "1,zero,1.5"),
        ("EXX,X,X,,1", "EXQ,X,X,,1"),
        ("EXX,X,X,,1", "EXX;X;X;;1"),
        ("2,50,", "2,-60,"),
    ];
    for (from, to) in cases {
        let found = flaws(&csv_text().replace(from, to));
        assert_eq!(found.len(), 1, "{to}: {found:#?}");
    }
}

#[test]
fn all_flaws_are_told_in_the_order_of_the_file_each_cause_once() {
    let text = csv_text().replace("-50,", "x,").replace("50,-1", "50,-2").replace("25.4", "-25.4"); // told when each row can be read
    let found = flaws(&text);
    let places: Vec<&str> =
        found.iter().map(|flaw| flaw.split(' ').next().expect("a place")).collect();
    assert_eq!(places, ["2:12", "4:18"], "{found:#?}");
    assert_eq!(
        flaws(&format!("{HEADER}{}", "a,b\n".repeat(1000))).len(),
        1 // the same in 999 more lines
    );
    let letters = format!("{HEADER}{}", "a,b,c,d,e,f,g,h,i\n".repeat(1000));
    assert!(flaws(&letters).len() <= 9, "one for each column at most");
    let jumbled: String =
        (0..30).fold(String::new(), |rows, n| format!("{rows}EXX,A{n},B,,1,0,0,0,0\n"));
    assert_eq!(flaws(&format!("{HEADER}{jumbled}")).len(), 1);
}

#[test]
fn a_long_grid_of_fractions_is_equally_spaced() {
    let mut text = HEADER.to_string();
    for index in 0..=1000 {
        let position = -1000.0 + 25.4 / 3.0 * f64::from(index);
        let increment = if index == 0 { "" } else { "0" };
        writeln!(text, "EZZ,3,3,-,{index},{position},2,-2,{increment}").expect("a string");
    }
    assert_eq!(table(&text).len(), 1001);
}

#[test]
fn twins_give_one_table() {
    let csv = table(&csv_text());
    let json = table(&json_text(&csv_text()));
    assert_eq!(merge(vec![csv.clone(), json]), Ok(csv.clone()));
    assert_eq!(merge(vec![csv.clone()]), Ok(csv));
    assert_eq!(merge(Vec::new()), Ok(Vec::new()));
}

#[test]
fn what_is_no_twin_is_refused_with_its_first_differing_row() {
    let twin = |from: &str, to: &str| table(&csv_text().replace(from, to));
    let cases = [
        (
            twin("1,25.4,", "1,25.400000000000002,"),
            "row 5 (EYX+ from `X` to `Y`, index 1) differs in `position_mm` (`25.4` and `25.400000000000002`)",
        ),
        (
            twin(",1.5,-1.5,-1.5", ",1.5,-1.5,-1.5000000001"),
            "row 2 (EXX from `X` to `X`, index 1) differs in `increment_um`",
        ),
        (
            twin("X,Y,+", "X,Y,"),
            "row 4 (EYX+ from `X` to `Y`, index 0) differs in `direction` (`+` and ``)",
        ),
        (twin("X,Y,", "X,AX2,"), "differs in `output_axis` (`Y` and `AX2`)"),
        (twin(EYX, ""), "row 4 (EYX+ from `X` to `Y`, index 0) stands in only one"),
    ];
    for (other, part) in cases {
        let first = table(&csv_text());
        let problems = merge(vec![first, other]).expect_err(part).render();
        assert!(problems.contains(part), "{part}\n{problems}");
    }
}

/// Rows of one block without their number, position in mm and deviation in µm.
fn rows(head: &str, points: &[(f64, f64)]) -> String {
    let mut text = String::new();
    for (index, (position, deviation)) in points.iter().enumerate() {
        let increment = match index {
            0 => String::new(),
            _ => (points[index - 1].1 - deviation).to_string(),
        };
        let correction = -deviation;
        text += &format!("{head},{index},{position},{deviation},{correction},{increment}\n");
    }
    text
}

fn of_blocks(rows: &[String]) -> ListedTables {
    let text = format!("{HEADER}{}", rows.concat());
    tables(&[("table.csv", &text)], None, false).unwrap_or_else(|problems| panic!("{problems}"))
}

fn state() -> ControlState {
    let axis = |name: &str| AxisState::plain(name, [0.0, 1000.0]);
    ControlState {
        unit: ControlUnit::Inch, // has no say
        axes: ["X", "Y"].map(axis).to_vec(),
    }
}

fn emulated(tables: ListedTables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
    emulator(&builtin::profile("generic").unwrap(), &Tables::Listed(tables), state)
}

fn control(rows: &[String]) -> Box<dyn Emulator> {
    emulated(of_blocks(rows), &state()).unwrap_or_else(|why| panic!("{}", why.0))
}

fn at(control: &dyn Emulator, pair: [&str; 2], direction: Direction, mm: f64) -> f64 {
    let response = control.response(pair[0], pair[1], direction);
    let response = response.unwrap_or_else(|why| panic!("{}", why.0));
    response.correction(Millimetres::new(mm)).um()
}

/// In + and in −, freed from dust.
fn both(control: &dyn Emulator, pair: [&str; 2], mm: f64) -> [u64; 2] {
    let um = Direction::BOTH.map(|direction| at(control, pair, direction, mm));
    um.map(|um| ((um * 1e6).round() / 1e6 + 0.0).to_bits())
}

const RAMP: [(f64, f64); 3] = [(-50.0, 4.0), (0.0, 0.0), (50.0, -2.0)];
const FLAT: [(f64, f64); 3] = [(-50.0, 1.0), (0.0, 1.0), (50.0, 1.0)];

/// Straight between points, ends held; the correction is the opposite of the deviation.
#[test]
fn corrections_are_interpolated_and_held() {
    let control = control(&[rows("EXX,X,X,", &RAMP)]);
    let cases = [
        (-90.0, -4.0),
        (-50.0, -4.0),
        (-25.0, -2.0),
        (0.0, 0.0),
        (25.0, 1.0),
        (50.0, 2.0),
        (80.0, 2.0),
    ];
    for (mm, um) in cases {
        for direction in Direction::BOTH {
            let found = at(control.as_ref(), ["x", "X"], direction, mm);
            assert!((found - um).abs() < 1e-12, "{mm} mm: {found} µm");
        }
    }
}

/// Block directions, and the corrections in + and − at one place.
#[test]
fn a_direction_acts_only_in_its_own() {
    let plus = || rows("EYX,X,Y,+", &FLAT);
    let minus = || rows("EYX,X,Y,-", &RAMP);
    let cases = [
        (vec![rows("EYX,X,Y,", &FLAT)], [-1.0, -1.0]),
        (vec![plus()], [-1.0, 0.0]),
        (vec![minus()], [0.0, 2.0]),
        (vec![plus(), minus()], [-1.0, 2.0]),
    ];
    for (blocks, expected) in cases {
        let control = control(&blocks);
        let found = both(control.as_ref(), ["X", "Y"], 50.0);
        assert_eq!(found, expected.map(f64::to_bits), "{blocks:?}");
    }
}

#[test]
fn connected_pairs_are_named_once_and_others_get_nothing() {
    let blocks = [rows("EYX,X,Y,+", &FLAT), rows("EYX,X,Y,-", &FLAT), rows("EXX,X,X,", &RAMP)];
    let control = control(&blocks);
    let pair = |base: &str, output: &str| (base.to_string(), output.to_string());
    assert_eq!(control.connected_axes(), [pair("X", "X"), pair("X", "Y")]);
    for other in [["Y", "X"], ["Y", "Y"], ["Y", "Q"]] {
        assert!(at(control.as_ref(), other, Direction::Plus, 50.0).abs() <= 0.0, "{other:?}");
    }
    assert!(control.response("Q", "Q", Direction::Plus).is_err());
}

/// Reference direction; correction of an axis to itself in + and −.
#[test]
fn backlash_acts_away_from_the_reference_direction() {
    for (reference, expected) in [(Direction::Plus, [-1.0, -9.0]), (Direction::Minus, [7.0, -1.0])]
    {
        let mut state = state();
        state.axes[0].reference_direction = reference;
        state.axes[0].backlash_um = 8.0;
        let blocks = of_blocks(&[rows("EXX,X,X,", &FLAT), rows("EYX,X,Y,", &FLAT)]);
        let control = emulated(blocks, &state).unwrap_or_else(|why| panic!("{}", why.0));
        assert_eq!(
            both(control.as_ref(), ["X", "X"], 10.0),
            expected.map(f64::to_bits),
            "{reference}"
        );
        assert_eq!(
            both(control.as_ref(), ["X", "Y"], 10.0),
            [(-1.0_f64).to_bits(); 2],
            "{reference}"
        );
    }
}

/// What the reader takes, and part of the reason.
#[test]
fn what_a_control_would_do_is_not_guessed() {
    for block in [rows("EZZ,Z,Z,", &FLAT), rows("EZX,X,Z,", &FLAT)] {
        let why = emulated(of_blocks(&[block]), &state()).err().unwrap().0;
        assert!(why.contains("no axis `Z`"), "{why}");
    }
}

#[test]
fn an_empty_table_connects_nothing() {
    let control = emulated(ListedTables::NONE, &state()).unwrap_or_else(|why| panic!("{}", why.0));
    assert!(control.connected_axes().is_empty());
}
