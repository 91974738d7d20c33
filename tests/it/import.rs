//! Other makers' files become error tables: whole texts, and what must not matter.
//!
//! What is refused stands in `fixtures/cases/refuses/import*.txt`.
use encoding_rs::{Encoding, GBK, UTF_16LE, WINDOWS_1250, WINDOWS_1252};
use nonius::control::controller::TableSign;
use nonius::inputs::error_table::{ErrorTable, write};
use nonius::inputs::import::stated::{Decimal, MaterialCorrected, Rows, Runs, Stated, Travel};
use nonius::inputs::import::{Component, ImportFinding, Imported, Measurement, import, source_of};
use nonius::kit::sha256;
use nonius::quantity::axis::{Axis, Direction};
use nonius::text::document::Source;
use nonius::text::finding::{Severity, of_severity};
use nonius::text::problem::Problems;
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;

mod as_a_user;

fn formats() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats")
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(formats().join(name)).unwrap()
}

fn run(
    name: &str,
    bytes: &[u8],
    stated: &Stated,
    encoding: Option<&'static Encoding>,
) -> Result<Imported, Problems> {
    let file = Measurement { path: name, name, sha256: &sha256(bytes), bytes };
    import(file, None, encoding, stated)
}

fn table(name: &str, bytes: &[u8], stated: &Stated) -> String {
    let imported = run(name, bytes, stated, None).unwrap_or_else(|p| panic!("{p}"));
    let text = write(&imported.draft);
    let source = Source::from_bytes("errors.csv", text.as_bytes()).unwrap();
    ErrorTable::read(source).unwrap_or_else(|p| panic!("not a table: {p}\n{text}"));
    text
}

/// Rows without comment lines.
fn rows(table: &str) -> String {
    let rows = table.lines().filter(|line| !line.starts_with('#'));
    rows.collect::<Vec<_>>().join("\n")
}

/// What a laser file needs.
fn laser(first_target_at_mm: f64, targets_run: Direction) -> Stated {
    Stated {
        term: Component::from_name("EXX"),
        first_target_at_mm: Some(first_target_at_mm),
        targets_run: Some(targets_run),
        sign: Some(TableSign::AsError),
        ..Stated::default()
    }
}

/// What the `.rtl` of this folder needs beside that: it notes a temperature of the material.
fn rtl_laser(first_target_at_mm: f64, targets_run: Direction) -> Stated {
    Stated {
        material_corrected: Some(MaterialCorrected::Yes),
        ..laser(first_target_at_mm, targets_run)
    }
}

fn signed(sign: TableSign) -> Stated {
    Stated { sign: Some(sign), ..Stated::default() }
}

const RTL: &str = "rtl_linear_bidirectional_selfmade.rtl";
const REN: &str = "ren_table_selfmade.ren";

#[test]
fn renishaw_static_data() {
    let plus = rtl_laser(-200.0, Direction::Plus);
    insta::assert_snapshot!(table(RTL, &bytes(RTL), &plus));
}

#[test]
fn renishaw_static_data_measured_towards_smaller_coordinates() {
    let name = "sample_synthetic.rtl";
    let minus = rtl_laser(0.0, Direction::Minus);
    insta::assert_snapshot!(table(name, &bytes(name), &minus));
}

#[test]
fn renishaw_compensation_table() {
    let mut stated = laser(-100.0, Direction::Plus);
    stated.sign = None; // the file says it
    insta::assert_snapshot!(table(REN, &bytes(REN), &stated));
}

const POS: &str = "pos_linear_selfmade.pos";

#[test]
fn api_position_export() {
    let plus = rtl_laser(-200.0, Direction::Plus);
    insta::assert_snapshot!(table(POS, &bytes(POS), &plus));
}

/// What is said of the file with one text in place of another.
fn pos_refused(from: &str, to: &str, stated: &Stated) -> String {
    let text = String::from_utf8(bytes(POS)).unwrap();
    assert!(text.contains(from), "{from}");
    let changed = text.replacen(from, to, 1);
    run(POS, changed.as_bytes(), stated, None)
        .map(|imported| panic!("it is read: {}", imported.text))
        .unwrap_err()
        .to_string()
}

#[test]
fn rows_of_an_api_export_that_contradict_themselves_are_refused() {
    let plus = rtl_laser(0.0, Direction::Plus);
    let edited = |from: &str, to: &str| pos_refused(from, to, &plus);
    assert!(
        edited("     0.001200", "     0.001300").contains("1 of 10 rows contradict themselves")
    );
    assert!(edited("EndPos:\t400", "EndPos:\t500").contains("expected 500 as in `EndPos`"));
    assert!(edited("RunNum: 2", "RunNum: 3").contains("expected 15"));
    assert!(
        edited("\t     0\t", "\t     2\t").contains("status is 2 (Path Error) in 1 of 10 rows")
    );
    assert!(edited("Unidirection\t", "Bidirection\t").contains("expected 20"));
    assert!(edited("Unit:\tmm", "Unit:\tm").contains("`Unit` is `m`"));
    assert!(
        edited("Linear Data Table", "Angular Data Table")
            .contains("expected a `Linear Data Table`")
    );
    assert!(edited("(X)", "(Y)").contains("names axis `(Y)`"));
    assert!(edited("\t 0.001300", "\t 0.002300").contains("--rows"));
    let turned = Stated { sign: Some(TableSign::AsCorrection), ..plus };
    assert!(pos_refused("(X)", "(X)", &turned).contains("contradicts the file"));
}

#[test]
fn averages_of_an_api_export_are_taken_only_when_asked_for() {
    let text = String::from_utf8(bytes(POS)).unwrap();
    let text = text.replacen("\t 0.001300", "\t 0.002300", 1);
    let taken = |rows: Rows| {
        let stated = Stated { rows: Some(rows), ..rtl_laser(0.0, Direction::Plus) };
        run(POS, text.as_bytes(), &stated, None).unwrap_or_else(|p| panic!("{p}"))
    };
    let measured = taken(Rows::Measured);
    assert!(rows(&measured.text).contains("x,+,100,1.3,"), "{}", measured.text);
    assert!(
        measured
            .findings
            .iter()
            .any(|f| matches!(f.kind(), Some(ImportFinding::AveragesDiffer { .. })))
    );
    let averages = taken(Rows::Averages);
    assert!(rows(&averages.text).contains("x,+,100,2.3"), "{}", averages.text);
}

#[test]
fn etalon_exchange() {
    let name = "etalon_exchange_selfmade.txt";
    insta::assert_snapshot!(table(name, &bytes(name), &signed(TableSign::AsError)));
}

#[test]
fn isg_components_given_as_corrections() {
    let name = "isg_component_errors_selfmade.csv";
    insta::assert_snapshot!(table(name, &bytes(name), &signed(TableSign::AsCorrection)));
}

const STATUS_PRO: &str = "Example\n\"AXn [mm]\";\"Delta [mm]\";\"Note\"\n\
    \"100,000\";\"-0,0021\";\"a;b\"\n\"0,000\";\"0,0005\";\"\"\n;;\n";

#[test]
fn mapped_columns_with_decimal_comma() {
    let stated = Stated {
        columns: Some("AXn [mm]=position_mm,Delta [mm]=ex_mm".to_string()),
        axis: Some(Axis::X),
        travel: Some(Travel::Both),
        ..signed(TableSign::AsError)
    };
    insta::assert_snapshot!(table("status.csv", STATUS_PRO.as_bytes(), &stated));
}

#[test]
fn mapped_targets_begin_with_the_first_row_of_the_file() {
    let mut stated = Stated {
        columns: Some("AXn [mm]=target_mm,Delta [mm]=ex_mm".to_string()),
        axis: Some(Axis::X),
        travel: Some(Travel::Both),
        ..laser(50.0, Direction::Plus)
    };
    stated.term = None;
    // Target 1 is 100 in the file and 50 on the machine; the axis went to larger coordinates
    // while the file counted down: deviations are turned.
    let text = table("status.csv", STATUS_PRO.as_bytes(), &stated);
    assert_eq!(rows(&text), "axis,position_mm,ex_um\nx,50,2.1\nx,150,-0.5");
}

#[test]
fn mapped_runs_are_averaged() {
    let text = "p,e,r,d\n0,1,1,+\n10,5,1,+\n10,7,2,+\n0,3,2,+\n0,-1,1,-\n10,0.5,1,-\n";
    let stated = Stated {
        columns: Some("p=position_mm,e=ey_um,r=run,d=direction".to_string()),
        axis: Some(Axis::Z),
        ..signed(TableSign::AsError)
    };
    let expected = "axis,direction,position_mm,ey_um,u_ey_um\n\
        z,+,0,2,1\nz,+,10,6,1\nz,-,0,-1,\nz,-,10,0.5,";
    assert_eq!(rows(&table("runs.csv", text.as_bytes(), &stated)), expected);
}

#[test]
fn corrections_are_turned_once() {
    let mut stated = rtl_laser(-200.0, Direction::Plus);
    let errors = rows(&table(RTL, &bytes(RTL), &stated));
    stated.sign = Some(TableSign::AsCorrection);
    let corrections = rows(&table(RTL, &bytes(RTL), &stated));
    assert!(errors.contains("x,+,-200,0.5,0.1"));
    assert!(corrections.contains("x,+,-200,-0.5,0.1"));
}

#[test]
fn a_straightness_keeps_its_sense_when_the_targets_run_the_other_way() {
    let stated = Stated {
        columns: Some("t=target_mm,e=ex_um,s=ey_um".to_string()),
        axis: Some(Axis::X),
        travel: Some(Travel::Both),
        term: None,
        ..laser(0.0, Direction::Minus)
    };
    let text = table("s.csv", b"t;e;s\n0;1;2\n100;3;4\n", &stated);
    assert_eq!(rows(&text), "axis,position_mm,ex_um,ey_um\nx,-100,-3,4\nx,0,-1,2");
    // What was turned is said of that column only.
    let sense: Vec<&str> = text.lines().filter(|l| l.contains("sense:")).collect();
    assert_eq!(
        sense,
        ["# sense: the file counts its targets against the axis, so EXX is turned as well"]
    );
}

/// The file with other words in it.
fn changed(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(bytes(RTL)).unwrap();
    assert!(text.contains(from), "{from}");
    text.replace(from, to).into_bytes()
}

#[test]
fn spelling_of_the_header_does_not_matter() {
    let stated = rtl_laser(-200.0, Direction::Plus);
    let expected = rows(&table(RTL, &bytes(RTL), &stated));
    let twins = [
        changed("\r\n", "\n"),
        changed("Air press ", "Air Press"),
        changed("HEADER::", "\u{feff}HEADER::"),
        changed("Target-count: 9", "Target-Count : 9"),
        changed("Targets :\r\n", "Targets: "),
        changed("Serial No: 0001\r\n", "Serial No: 0001  "),
        changed("Axis:X", "Axis: x-axis"),
        changed("-200.000000  -150.000000", "-200.000000\r\n -150.000000"),
        changed("0.000000 \r\n50", "0.000000 \r\n\r\n50"),
    ];
    for (index, twin) in twins.iter().enumerate() {
        assert_eq!(rows(&table(RTL, twin, &stated)), expected, "twin {index}");
    }
}

#[test]
fn fields_of_the_user_text_may_share_a_line() {
    let shared = changed("0001\r\nDate", "0001 Date");
    let shared = String::from_utf8(shared).unwrap();
    let shared = shared.replace("By:example\r\nAxis:X", "By:example Axis:X");
    let text = table(RTL, shared.as_bytes(), &rtl_laser(-200.0, Direction::Plus));
    assert!(text.contains("# the file says: Serial No: 0001\n"), "{text}");
    assert!(text.contains("# the file says: By: example\n"), "{text}");
    assert!(text.contains("# the file says: Axis: X\n"), "{text}");
}

#[test]
fn ten_targets_fill_two_lines_of_five() {
    let targets: Vec<String> = (0..10).map(|n| format!("{}", n * 10)).collect();
    let deviations: Vec<String> = (1..=10).map(|n| format!("1 {n} {n}.5")).collect();
    let text = format!(
        "HEADER::\nTARGET DATA::\nTarget-count: 10\nTargets :\n{}\n{}\nFlags: 0 1 2 0\nRUNS::\nRun-count: 1\nDEVIATIONS::\nRun Target Data:\n{}\nEOF::\n",
        targets[..5].join("  "),
        targets[5..].join("  "),
        deviations.join("\n")
    );
    let text = rows(&table("ten.rtl", text.as_bytes(), &laser(0.0, Direction::Plus)));
    assert_eq!(text.lines().count(), 11);
    assert!(text.ends_with("x,+,90,10.5"), "{text}");
}

#[test]
fn return_runs_that_were_never_made_are_left_out_and_said() {
    let text = String::from_utf8(changed("Flags: 0 0 2 0", "Flags: 0 1 2 0")).unwrap();
    let zeros: Vec<String> = text
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            [run @ ("2" | "4"), target, _] => format!("{run} {target} 0.000"),
            _ => line.to_string(),
        })
        .collect();
    let text = table(RTL, zeros.join("\n").as_bytes(), &rtl_laser(-200.0, Direction::Plus));
    assert!(text.contains("runs 2, 4 hold only zeros"), "{text}");
    assert!(!text.contains("x,-,"), "{text}");
    assert!(text.contains("x,+,200,4.7,0.1"), "{text}");
}

#[test]
fn every_run_goes_out_where_it_is_stated() {
    let mut stated = rtl_laser(-200.0, Direction::Plus);
    stated.runs = Some(Runs::Unidirectional);
    let text = table(RTL, &changed("Flags: 0 0 2 0", "Flags: 0 1 2 0"), &stated);
    assert!(text.contains("runs: 4 moving +;"), "{text}");
    // Target 1: 0.4, -1.1, 0.6, -1.0 µm.
    assert!(text.contains("x,+,-200,-0.275,"), "{text}");
}

#[test]
fn other_encodings_are_read_where_they_are_stated() {
    let stated = rtl_laser(-200.0, Direction::Plus);
    let text = String::from_utf8(changed("Example mill", "¤")).unwrap();
    let (before, behind) = text.split_once('¤').unwrap();
    let cases = [
        (Some(WINDOWS_1252), b"Fr\xe4se".as_slice(), "Fräse"),
        (Some(WINDOWS_1250), b"Fr\xe9zka \xf8", "Frézka ř"),
        (Some(GBK), b"\xbb\xfa\xb4\xb2".as_slice(), "机床"),
    ];
    for (encoding, name, expected) in cases {
        let bytes = [before.as_bytes(), name, behind.as_bytes()].concat();
        let imported = run(RTL, &bytes, &stated, encoding).unwrap();
        let text = write(&imported.draft);
        assert!(text.contains(&format!("Machine: {expected}\n")), "{text}");
    }
    let wide: Vec<u8> =
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let unmarked = run(RTL, &wide[2..], &stated, Some(UTF_16LE)).unwrap();
    assert!(write(&unmarked.draft).contains("# text: UTF-16LE, as stated"));
    let imported = run(RTL, &wide, &stated, None).unwrap();
    assert!(write(&imported.draft).contains("# text: UTF-16"));
}

#[test]
fn squareness_has_the_sign_of_the_contract() {
    // ISO 230-1: EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz.
    let text = "C0Y B0Z A0Z X0Y\n1e-6 2e-6 3e-6 0.5\n#\nY EYY\n0 0\n100 0.001\n";
    let imported = run("s.csv", text.as_bytes(), &signed(TableSign::AsError), None).unwrap();
    let found: Vec<(&str, f64)> =
        imported.squareness.iter().map(|s| (s.pair, s.um_per_m)).collect();
    assert_eq!(found, [("xy", -1.0), ("xz", 2.0), ("yz", -3.0)]);
    assert!(
        imported.findings.iter().any(
            |f| matches!(f.kind(), Some(ImportFinding::LeftOut { name, .. }) if name == "X0Y")
        )
    );
}

#[test]
fn the_source_is_found_in_the_comments_only() {
    let hash = "a".repeat(64);
    let text = format!("# source: my file.rtl sha256 {hash}\naxis,position_mm\n");
    assert_eq!(source_of(&text), Some(("my file.rtl".to_string(), hash.clone())));
    assert_eq!(source_of(&format!("axis\n# source: x sha256 {hash}\n")), None);
    assert_eq!(source_of("# source: x sha256 abc\n"), None);
}

/// Reversal B = mean of + less mean of −, µm.
fn reversal_um(table: &str) -> f64 {
    let mean = |direction: &str| {
        let rows = rows(table);
        let values: Vec<f64> = rows
            .lines()
            .filter(|row| row.starts_with(&format!("x,{direction},")))
            .map(|row| row.split(',').nth(3).unwrap().parse().unwrap())
            .collect();
        values.iter().sum::<f64>() / f64::from(u32::try_from(values.len()).unwrap())
    };
    mean("+") - mean("-")
}

/// A number beyond all numbers is none (found by fuzzing: "inf °C").
#[test]
fn a_temperature_beyond_all_numbers_is_not_told() {
    let rtl = "HEADER::\nFile type : rtl\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\n\
        Flags: 0 1 2 0\nENVIRONMENT::\nMat temp 2 : 1e9931643\nRUNS::\nRun-count: 1\nDEVIATIONS::\n1 1 0\n1 2 1\nEOF::\n";
    let stated = Stated { material_corrected: None, ..laser(0.0, Direction::Plus) };
    let text = table("x.rtl", rtl.as_bytes(), &stated);
    assert!(!text.contains("inf"), "{text}");
}

#[test]
fn turned_targets_keep_the_reversal_of_the_machine() {
    // The axis goes from 500 to 400 mm while the laser counts 0 to 100; ordinary lost motion of
    // 4 µm: short of the target by 2 µm both ways.
    let way = Direction::Minus;
    let rtl = "HEADER::\nFile type : rtl\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\n\
        Flags: 0 0 2 0\nRUNS::\nRun-count: 2\nDEVIATIONS::\n1 1 -2\n1 2 -2\n2 2 2\n2 1 2\nEOF::\n";
    let text = table("x.rtl", rtl.as_bytes(), &laser(500.0, way));
    assert!((reversal_um(&text) + 4.0).abs() < 1e-9, "{text}");
    // In the columns `+` is the outward run, which moves the axis −.
    let stated = Stated {
        columns: Some("t=target_mm,d=ex_um,dir=direction".to_string()),
        axis: Some(Axis::X),
        term: None,
        plus_moves: Some(way),
        ..laser(500.0, way)
    };
    let csv = "t;d;dir\n0;-2;+\n100;-2;+\n0;2;-\n100;2;-\n";
    let mapped = table("x.csv", csv.as_bytes(), &stated);
    assert_eq!(rows(&mapped), rows(&text).replace(",u_ex_um", ""));
    assert!(
        mapped.contains("# direction: rows with `+` = the axis moving -, as stated\n"),
        "{mapped}"
    );
}

/// Two columns, both directions together.
fn two_columns(decimal: Option<Decimal>) -> Stated {
    Stated {
        columns: Some("Pos=position_mm,Dev=ex_um".to_string()),
        axis: Some(Axis::X),
        travel: Some(Travel::Both),
        decimal,
        ..signed(TableSign::AsError)
    }
}

#[test]
fn a_comma_is_read_as_decimal_where_it_shows_or_is_stated() {
    let comma = Some(Decimal::Comma);
    let expected = "axis,position_mm,ex_um\nx,1,2\nx,1.5,3.25";
    let cases = [
        ("Pos;Dev\n1,000;2\n1,500;3,25\n", None),
        ("Pos\tDev\n1,000\t2\n1,500\t3,25\n", None),
        ("Pos;Dev\n1;2,000\n1,500;3,250\n", comma),
        ("Pos,Dev\n1,2\n\"1,5\",\"3,25\"\n", comma),
        ("Pos,Dev\n1.000,2\n1.500,3.25\n", None),
        ("Pos;Dev\n1.000;2\n1.500;3.25\n", Some(Decimal::Point)),
    ];
    for (text, decimal) in cases {
        let found = table("x.csv", text.as_bytes(), &two_columns(decimal));
        assert_eq!(rows(&found), expected, "{text}");
    }
    // A leading zero stands before decimals, never before thousands.
    let text = table("x.csv", b"Pos;Dev\n0;0,125\n5;1,000\n", &two_columns(None));
    assert_eq!(rows(&text), "axis,position_mm,ex_um\nx,0,0.125\nx,5,1");
}

#[test]
fn a_column_may_be_named_by_its_number() {
    let mut stated = two_columns(None);
    stated.columns = Some("Pos=position_mm,#3=ex_um".to_string());
    let text = table("x.csv", b"Pos;Dev;Dev\n0;1;11\n5;2;12\n", &stated);
    assert_eq!(rows(&text), "axis,position_mm,ex_um\nx,0,11\nx,5,12");
}

#[test]
fn a_mapped_text_may_have_any_ending() {
    let text = table("x.pos", b"Pos;Dev\n0;1\n5;2\n", &two_columns(None));
    assert_eq!(rows(&text), "axis,position_mm,ex_um\nx,0,1\nx,5,2");
}

#[test]
fn angles_over_several_runs_state_no_uncertainty() {
    let stated = Stated {
        columns: Some("t=position_mm,a=ea_urad,run=run".to_string()),
        axis: Some(Axis::X),
        travel: Some(Travel::Both),
        ..signed(TableSign::AsError)
    };
    let text = table("a.csv", b"t;a;run\n0;1;1\n9;2;1\n0;1.5;2\n9;2.5;2\n", &stated);
    assert_eq!(rows(&text), "axis,position_mm,ea_urad\nx,0,1.25\nx,9,2.25");
    assert!(text.contains("their mean, no u is written for angles"), "{text}");
}

#[test]
fn zeros_of_every_return_run_mean_what_is_stated() {
    let text = String::from_utf8(bytes(RTL)).unwrap();
    let zeros: Vec<String> = text
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            [run @ ("2" | "4"), target, _] => format!("{run} {target} 0.000"),
            _ => line.to_string(),
        })
        .collect();
    let zeros = zeros.join("\n");
    let mut stated = rtl_laser(-200.0, Direction::Plus);
    assert!(run("x.rtl", zeros.as_bytes(), &stated, None).is_err());
    stated.runs = Some(Runs::Unidirectional);
    let never = table("x.rtl", zeros.as_bytes(), &stated);
    assert!(!never.contains("x,-,"), "{never}");
    stated.runs = Some(Runs::Bidirectional);
    let measured = table("x.rtl", zeros.as_bytes(), &stated);
    assert!(measured.contains("x,-,200,0,0"), "{measured}");
}

#[test]
fn an_axis_that_is_not_clear_is_stated() {
    let mut stated = rtl_laser(-200.0, Direction::Plus);
    for clear in ["X", "Linear X", "x-axis", "X1 linear"] {
        table(RTL, &changed("Axis:X", &format!("Axis:{clear}")), &stated);
    }
    for unclear in ["Linear", "XY", "X and Y", "Table"] {
        let file = changed("Axis:X", &format!("Axis:{unclear}"));
        stated.axis = None;
        assert!(run(RTL, &file, &stated, None).is_err(), "{unclear}");
        stated.axis = Some(Axis::X);
        table(RTL, &file, &stated);
    }
}

#[test]
fn the_expansion_of_the_material_is_said_where_it_counts() {
    let warm = changed("20.30 20.40 20.35", "35.00 35.00 35.00");
    let mut stated = rtl_laser(-200.0, Direction::Plus);
    let warnings = |stated: &Stated, file: &[u8]| {
        let found = run(RTL, file, stated, None).unwrap().findings;
        let notes = of_severity(&found, Severity::Note);
        notes.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let reversal = warnings(&stated, &warm);
    assert!(reversal.len() == 1 && reversal[0].contains("B = +1.550 µm is above 0"));
    let warnings = |stated: &Stated, file: &[u8]| {
        let mut warnings = warnings(stated, file);
        warnings.retain(|warning| !warning.contains("B ="));
        warnings
    };
    for corrected in [MaterialCorrected::No, MaterialCorrected::NotStated] {
        stated.material_corrected = Some(corrected);
        let said = warnings(&stated, &warm);
        // 11.7 µm/m per K × 15 K × 0.4 m.
        assert!(said.len() == 1 && said[0].contains("= 70.2 µm"), "{said:?}");
    }
    // 0.4 K are worth 1.9 µm; 0.1 K are not worth a word.
    assert!(warnings(&stated, &bytes(RTL))[0].contains("= 1.9 µm"));
    let mild = changed("20.30 20.40 20.35", "20.00 20.10 19.90");
    assert!(warnings(&stated, &mild).is_empty());
}
