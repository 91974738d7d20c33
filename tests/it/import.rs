//! Other makers' files become error tables: whole texts, and what must not matter.
//!
//! What is refused stands in `fixtures/cases/refuses/import*.txt`.
use crate::support::{error_table, fixture, holds, lacks, replaced, words};
use encoding_rs::{Encoding, GBK, UTF_16LE, WINDOWS_1250, WINDOWS_1252};
use nonius::control::controller::TableSign;
use nonius::inputs::error_table::write;
use nonius::inputs::import::stated::{Decimal, ImportFacts, MaterialCorrected, Runs, Travel};
use nonius::inputs::import::{Component, ImportFinding, Imported, Measurement, import, source_of};
use nonius::kit::sha256;
use nonius::quantity::{Axis, Direction};
use nonius::text::{Problems, Severity, of_severity};
use proptest::prelude::*;

mod as_a_user;

const RTL: &str = "rtl_linear_bidirectional_selfmade.rtl";

fn file(name: &str) -> String {
    fixture(&format!("formats/{name}"))
}

fn rtl(from: &str, to: &str) -> String {
    replaced(&file(RTL), from, to)
}

pub(super) fn run(
    name: &str,
    file: impl AsRef<[u8]>,
    stated: &ImportFacts,
    encoding: Option<&'static Encoding>,
) -> Result<Imported, Problems> {
    let bytes = file.as_ref();
    let stated = ImportFacts { encoding, ..stated.clone() };
    import(Measurement { path: name, name, sha256: &sha256(bytes), bytes }, &stated)
}

#[track_caller]
fn table(name: &str, file: impl AsRef<[u8]>, stated: &ImportFacts) -> String {
    let text = write(&run(name, file, stated, None).unwrap_or_else(|p| panic!("{p}")).draft);
    error_table(&text);
    text
}

fn rows(table: &str) -> String {
    table.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n")
}

#[track_caller]
fn becomes(name: &str, file: &str, stated: &ImportFacts, expected: &str) -> String {
    let text = table(name, file, stated);
    assert_eq!(rows(&text), expected, "{file}");
    text
}

fn laser(first_target_at_mm: f64, targets_run: Direction) -> ImportFacts {
    ImportFacts {
        term: Component::from_name("EXX"),
        first_target_at_mm: Some(first_target_at_mm),
        targets_run: Some(targets_run),
        ..signed(TableSign::AsError)
    }
}

/// What the `.rtl` of this folder needs beside that: it notes a temperature of the material.
fn rtl_laser(first_target_at_mm: f64, targets_run: Direction) -> ImportFacts {
    let material_corrected = Some(MaterialCorrected::Yes);
    ImportFacts { material_corrected, ..laser(first_target_at_mm, targets_run) }
}

fn of_rtl() -> ImportFacts {
    rtl_laser(-200.0, Direction::Plus)
}

fn signed(sign: TableSign) -> ImportFacts {
    ImportFacts { sign: Some(sign), ..ImportFacts::default() }
}

fn mapped(columns: &str, axis: Axis) -> ImportFacts {
    ImportFacts {
        columns: Some(columns.to_string()),
        axis: Some(axis),
        travel: Some(Travel::Both),
        ..signed(TableSign::AsError)
    }
}

fn two_columns(decimal: Option<Decimal>) -> ImportFacts {
    ImportFacts { decimal, ..mapped("Pos=position_mm,Dev=ex_um", Axis::X) }
}

const STATUS_PRO: &str = "Example\n\"AXn [mm]\";\"Delta [mm]\";\"Note\"\n\
    \"100,000\";\"-0,0021\";\"a;b\"\n\"0,000\";\"0,0005\";\"\"\n;;\n";

#[test]
fn every_format_becomes_the_table_that_was_checked() {
    let plus = of_rtl();
    let minus = rtl_laser(0.0, Direction::Minus);
    let towards_smaller = "renishaw_static_data_measured_towards_smaller_coordinates";
    let signed_by_file = ImportFacts { sign: None, ..laser(-100.0, Direction::Plus) };
    let (error, correction) = (signed(TableSign::AsError), signed(TableSign::AsCorrection));
    for (snapshot, name, stated) in [
        ("renishaw_static_data", RTL, &plus),
        (towards_smaller, "sample_synthetic.rtl", &minus),
        ("renishaw_compensation_table", "ren_table_selfmade.ren", &signed_by_file),
        ("api_position_export", "pos_linear_selfmade.pos", &plus),
        ("etalon_exchange", "etalon_exchange_selfmade.txt", &error),
        ("isg_components_given_as_corrections", "isg_component_errors_selfmade.csv", &correction),
    ] {
        insta::assert_snapshot!(snapshot, table(name, file(name), stated));
    }
    let stated = mapped("AXn [mm]=position_mm,Delta [mm]=ex_mm", Axis::X);
    let text = table("status.csv", STATUS_PRO, &stated);
    insta::assert_snapshot!("mapped_columns_with_decimal_comma", text);
}

/// Target 1 is 100 in the file, 50 on the machine; the axis went up while the file counted down: deviations are turned.
#[test]
fn mapped_targets_begin_with_the_first_row_and_a_straightness_keeps_its_sense() {
    let stated = ImportFacts {
        first_target_at_mm: Some(50.0),
        targets_run: Some(Direction::Plus),
        ..mapped("AXn [mm]=target_mm,Delta [mm]=ex_mm", Axis::X)
    };
    becomes("status.csv", STATUS_PRO, &stated, "axis,position_mm,ex_um\nx,50,2.1\nx,150,-0.5");
    let stated = ImportFacts {
        first_target_at_mm: Some(0.0),
        targets_run: Some(Direction::Minus),
        ..mapped("t=target_mm,e=ex_um,s=ey_um,u=u_ey_um", Axis::X)
    };
    let expected = "axis,position_mm,ex_um,ey_um,u_ey_um\nx,-100,-3,4,0.4\nx,0,-1,2,0.2";
    let text = becomes("s.csv", "t;e;s;u\n0;1;2;0.2\n100;3;4;0.4\n", &stated, expected);
    let sense: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("# sense: ")).collect();
    assert_eq!(sense, ["the file counts its targets against the axis, so EXX is turned as well"]);
}

#[test]
fn mapped_runs_are_averaged_angles_without_an_uncertainty() {
    let text = "p,e,r,d\n0,1,1,+\n10,5,1,+\n10,7,2,+\n0,3,2,+\n0,-1,1,-\n10,0.5,1,-\n";
    let columns = mapped("p=position_mm,e=ey_um,r=run,d=direction", Axis::Z);
    let expected = "axis,direction,position_mm,ey_um,u_ey_um\n\
        z,+,0,2,1\nz,+,10,6,1\nz,-,0,-1,\nz,-,10,0.5,";
    becomes("runs.csv", text, &ImportFacts { travel: None, ..columns }, expected);
    let stated = mapped("t=position_mm,a=ea_urad,run=run", Axis::X);
    let expected = "axis,position_mm,ea_urad\nx,0,1.25\nx,9,2.25";
    let text = becomes("a.csv", "t;a;run\n0;1;1\n9;2;1\n0;1.5;2\n9;2.5;2\n", &stated, expected);
    assert!(text.contains("their mean, no u is written for angles"), "{text}");
}

#[test]
fn spelling_of_the_header_does_not_matter() {
    let expected = rows(&table(RTL, file(RTL), &of_rtl()));
    for (from, to) in [
        ("\r\n", "\n"),
        ("Air press ", "Air Press"),
        ("HEADER::", "\u{feff}HEADER::"),
        ("Target-count: 9", "Target-Count : 9"),
        ("Targets :\r\n", "Targets: "),
        ("Serial No: 0001\r\n", "Serial No: 0001  "),
        ("Axis:X", "Axis: x-axis"),
        ("-200.000000  -150.000000", "-200.000000\r\n -150.000000"),
        ("0.000000 \r\n50", "0.000000 \r\n\r\n50"),
    ] {
        assert_eq!(rows(&table(RTL, rtl(from, to), &of_rtl())), expected, "{from:?}");
    }
}

#[test]
fn ten_targets_fill_two_lines_of_five() {
    let targets = "0  10  20  30  40\n50  60  70  80  90";
    let deviations: String = (1..=10).map(|n| format!("1 {n} {n}.5\n")).collect();
    let text = format!(
        "HEADER::\nTARGET DATA::\nTarget-count: 10\nTargets :\n{targets}\nFlags: 0 1 2 0\nRUNS::\nRun-count: 1\nDEVIATIONS::\nRun Target Data:\n{deviations}EOF::\n"
    );
    let text = rows(&table("ten.rtl", text, &laser(0.0, Direction::Plus)));
    assert_eq!(text.lines().count(), 11);
    assert!(text.ends_with("x,+,90,10.5"), "{text}");
}

#[test]
fn fields_of_the_user_text_may_share_a_line() {
    let shared = rtl("0001\r\nDate", "0001 Date");
    let shared = replaced(&shared, "By:example\r\nAxis:X", "By:example Axis:X");
    let text = table(RTL, shared, &of_rtl());
    for field in ["Serial No: 0001", "By: example", "Axis: X"] {
        holds(&text, &[&format!("# the file says: {field}\n")]);
    }
}

#[test]
fn corrections_are_turned_once() {
    for (sign, row) in
        [(TableSign::AsError, "x,+,-200,0.5,0.1"), (TableSign::AsCorrection, "x,+,-200,-0.5,0.1")]
    {
        holds(&table(RTL, file(RTL), &ImportFacts { sign: Some(sign), ..of_rtl() }), &[row]);
    }
}

fn never_returned(text: &str) -> String {
    let zeros = text.lines().map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
        [run @ ("2" | "4"), target, _] => format!("{run} {target} 0.000"),
        _ => line.to_string(),
    });
    zeros.collect::<Vec<_>>().join("\n")
}

/// Zeros of return runs are left out where none was made; a run goes out where that is stated.
#[test]
fn return_runs_mean_what_is_stated() {
    let runs = |runs| ImportFacts { runs: Some(runs), ..of_rtl() };
    let both = rtl("Flags: 0 0 2 0", "Flags: 0 1 2 0");
    let left_out = table(RTL, never_returned(&both), &of_rtl());
    holds(&left_out, &["runs 2, 4 hold only zeros", "x,+,200,4.7,0.1"]);
    lacks(&left_out, &["x,-,"]);
    // Target 1: 0.4, -1.1, 0.6, -1.0 µm.
    let all_out = ["runs: 4 moving +;", "x,+,-200,-0.275,"];
    holds(&table(RTL, &both, &runs(Runs::Unidirectional)), &all_out);
    let zeros = never_returned(&file(RTL));
    assert!(run("x.rtl", &zeros, &of_rtl(), None).is_err());
    lacks(&table("x.rtl", &zeros, &runs(Runs::Unidirectional)), &["x,-,"]);
    holds(&table("x.rtl", &zeros, &runs(Runs::Bidirectional)), &["x,-,200,0,0"]);
}

#[test]
fn other_encodings_are_read_where_they_are_stated() {
    let text = rtl("Example mill", "¤");
    let (before, behind) = text.split_once('¤').unwrap();
    let of = |name: &[u8]| [before.as_bytes(), name, behind.as_bytes()].concat();
    let wide: Vec<u8> =
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for (encoding, bytes, expected) in [
        (Some(WINDOWS_1252), of(b"Fr\xe4se"), "Machine: Fräse\n"),
        (Some(WINDOWS_1250), of(b"Fr\xe9zka \xf8"), "Machine: Frézka ř\n"),
        (Some(GBK), of(b"\xbb\xfa\xb4\xb2"), "Machine: 机床\n"),
        (Some(UTF_16LE), wide[2..].to_vec(), "# text: UTF-16LE, as stated"),
        (None, wide.clone(), "# text: UTF-16"),
    ] {
        let text = write(&run(RTL, bytes, &of_rtl(), encoding).unwrap().draft);
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

/// ISO 230-1: EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz.
#[test]
fn squareness_has_the_sign_of_the_contract() {
    let text = "C0Y B0Z A0Z X0Y\n1e-6 2e-6 3e-6 0.5\n#\nY EYY\n0 0\n100 0.001\n";
    let imported = run("s.csv", text, &signed(TableSign::AsError), None).unwrap();
    let found: Vec<_> = imported.squareness.iter().map(|s| (s.pair, s.um_per_m)).collect();
    assert_eq!(found, [("xy", -1.0), ("xz", 2.0), ("yz", -3.0)]);
    let mut kinds = imported.findings.iter().filter_map(|found| found.kind());
    let is_it =
        |kind: &ImportFinding| matches!(kind, ImportFinding::LeftOut { name, .. } if name == "X0Y");
    assert!(kinds.any(is_it));
}

#[test]
fn the_source_is_found_in_the_comments_only() {
    let hash = "a".repeat(64);
    let text = format!("# source: my file.rtl sha256 {hash}\naxis,position_mm\n");
    assert_eq!(source_of(&text), Some(("my file.rtl".to_string(), hash.clone())));
    assert_eq!(source_of(&format!("axis\n# source: x sha256 {hash}\n")), None);
    assert_eq!(source_of("# source: x sha256 abc\n"), None);
}

/// A number beyond all numbers is none (found by fuzzing: "inf °C").
#[test]
fn a_temperature_beyond_all_numbers_is_not_told() {
    let rtl = "HEADER::\nFile type : rtl\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\n\
        Flags: 0 1 2 0\nENVIRONMENT::\nMat temp 2 : 1e9931643\nRUNS::\nRun-count: 1\nDEVIATIONS::\n1 1 0\n1 2 1\nEOF::\n";
    lacks(&table("x.rtl", rtl, &laser(0.0, Direction::Plus)), &["inf"]);
}

/// The axis goes from 500 to 400 mm while the laser counts 0 to 100; 2 µm short of the target both ways.
#[test]
fn turned_targets_keep_the_reversal_of_the_machine() {
    let way = Direction::Minus;
    let rtl = "HEADER::\nFile type : rtl\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\n\
        Flags: 0 0 2 0\nRUNS::\nRun-count: 2\nDEVIATIONS::\n1 1 -2\n1 2 -2\n2 2 2\n2 1 2\nEOF::\n";
    let text = table("x.rtl", rtl, &laser(500.0, way));
    let mean_um = |begin: &str| {
        let own = text.lines().filter(|row| row.starts_with(begin));
        let value = |row: &str| row.split(',').nth(3).unwrap().parse::<f64>().unwrap();
        own.clone().map(value).sum::<f64>() / own.count() as f64
    };
    assert!((mean_um("x,+,") - mean_um("x,-,") + 4.0).abs() < 1e-9, "{text}");
    // In the columns `+` is the outward run, which moves the axis −.
    let stated = ImportFacts {
        travel: None,
        first_target_at_mm: Some(500.0),
        targets_run: Some(way),
        plus_moves: Some(way),
        ..mapped("t=target_mm,d=ex_um,dir=direction", Axis::X)
    };
    let csv = "t;d;dir\n0;-2;+\n100;-2;+\n0;2;-\n100;2;-\n";
    let text = becomes("x.csv", csv, &stated, &rows(&text).replace(",u_ex_um", ""));
    assert!(text.contains("# direction: rows with `+` = the axis moving -, as stated\n"), "{text}");
}

#[test]
fn a_comma_is_read_as_decimal_where_it_shows_or_is_stated_and_columns_are_found_by_number() {
    let comma = Some(Decimal::Comma);
    let expected = "axis,position_mm,ex_um\nx,1,2\nx,1.5,3.25";
    for (text, decimal) in [
        ("Pos;Dev\n1,000;2\n1,500;3,25\n", None),
        ("Pos\tDev\n1,000\t2\n1,500\t3,25\n", None),
        ("Pos;Dev\n1;2,000\n1,500;3,250\n", comma),
        ("Pos,Dev\n1,2\n\"1,5\",\"3,25\"\n", comma),
        ("Pos,Dev\n1.000,2\n1.500,3.25\n", None),
        ("Pos;Dev\n1.000;2\n1.500;3.25\n", Some(Decimal::Point)),
    ] {
        becomes("x.csv", text, &two_columns(decimal), expected);
    }
    // A leading zero stands before decimals, never before thousands.
    let expected = "axis,position_mm,ex_um\nx,0,0.125\nx,5,1";
    becomes("x.csv", "Pos;Dev\n0;0,125\n5;1,000\n", &two_columns(None), expected);
    let numbered = mapped("Pos=position_mm,#3=ex_um", Axis::X);
    let expected = "axis,position_mm,ex_um\nx,0,11\nx,5,12";
    becomes("x.csv", "Pos;Dev;Dev\n0;1;11\n5;2;12\n", &numbered, expected);
    let expected = "axis,position_mm,ex_um\nx,0,1\nx,5,2";
    becomes("x.pos", "Pos;Dev\n0;1\n5;2\n", &two_columns(None), expected);
}

#[test]
fn an_axis_that_is_not_clear_is_stated() {
    let named = |axis: &str| rtl("Axis:X", &format!("Axis:{axis}"));
    for clear in ["X", "Linear X", "x-axis", "X1 linear"] {
        table(RTL, named(clear), &of_rtl());
    }
    for unclear in ["Linear", "XY", "X and Y", "Table"] {
        assert!(run(RTL, named(unclear), &of_rtl(), None).is_err(), "{unclear}");
        table(RTL, named(unclear), &ImportFacts { axis: Some(Axis::X), ..of_rtl() });
    }
}

#[test]
fn the_expansion_of_the_material_is_said_where_it_counts() {
    let at = |temperatures: &str| rtl("20.30 20.40 20.35", temperatures);
    let notes = |corrected: MaterialCorrected, file: &str| {
        let stated = ImportFacts { material_corrected: Some(corrected), ..of_rtl() };
        words(&of_severity(&run(RTL, file, &stated, None).unwrap().findings, Severity::Note))
    };
    let warm = at("35.00 35.00 35.00");
    let reversal = notes(MaterialCorrected::Yes, &warm);
    assert!(reversal.len() == 1 && reversal[0].contains("B = +1.550 µm is above 0"));
    let warnings = |corrected: MaterialCorrected, file: &str| {
        let mut warnings = notes(corrected, file);
        warnings.retain(|warning| !warning.contains("B ="));
        warnings
    };
    for corrected in [MaterialCorrected::No, MaterialCorrected::NotStated] {
        let said = warnings(corrected, &warm);
        // 11.7 µm/m per K × 15 K × 0.4 m.
        assert!(said.len() == 1 && said[0].contains("= 70.2 µm"), "{said:?}");
    }
    // 0.4 K are worth 1.9 µm; 0.1 K are not worth a word.
    let corrected = MaterialCorrected::NotStated;
    assert!(warnings(corrected, &file(RTL))[0].contains("= 1.9 µm"));
    assert!(warnings(corrected, &at("20.00 20.10 19.90")).is_empty());
}
