//! What a control and a reader could understand differently: a value that the reader takes must be one that the
//! control gets.

use super::*;

/// A file, what becomes of its text, the status, and what `verify` says.
type Read = (&'static str, fn(&str) -> String, i32, &'static str);

/// What a control and a reader could understand differently, in kits without manifest: a value that the
/// reader takes must be one that the control gets. Sources: docs/siemens.md §3.3, docs/fanuc.md §3.4.
fn judged_as_a_control_would(control: &str, cases: &[Read]) {
    let (directory, kit) = kit(control);
    fs::remove_file(kit.join("manifest.json")).expect("the file can be removed");
    for (file, change, status, says) in cases {
        let what = format!("{file}: {says}");
        expect_of_changed(directory.path(), (&what, file), change, (*status, says));
    }
}

#[test]
fn siemens_files_are_read_as_the_control_reads_them() {
    const ON: &str = "NONIUS_ENABLE.MPF";
    const OFF: &str = "NONIUS_DISABLE.MPF";
    let cases: [Read; 14] = [
        (
            EEC,
            |text| format!("STOPRE\n{}", text.replace("M30", "STOPRE\nM30")),
            0,
            "job and tables agree",
        ),
        (
            CEC,
            |text| format!("NEWCONF\n{}", text.replace("M30", "newconf\nM30")),
            0,
            "job and tables agree",
        ),
        (
            ON,
            |text| text.replace("NEWCONF\n", ""),
            0,
            "note: `NONIUS_ENABLE.MPF` sets $MA_ENC_COMP_ENABLE[0,AX1] and no NEWCONF follows",
        ),
        (
            OFF,
            |text| format!("NEWCONF\n{}", text.replace("NEWCONF\n", "")),
            0,
            "note: `NONIUS_DISABLE.MPF` sets $MA_CEC_ENABLE[AX1] and no NEWCONF follows",
        ),
        (EEC, |text| format!("CHANDATA(1)\n{text}"), 0, "job and tables agree"),
        (EEC, |text| format!("CHANDATA(2)\n{text}"), 2, "`CHANDATA(2)` names another channel"),
        (
            CEC,
            |text| text.replace("M30", "chandata( 02 )\nM30"),
            2,
            "`CHANDATA(2)` names another channel",
        ),
        (
            EEC,
            |text| format!("; a note\u{2028}$AA_ENC_COMP[0,1,AX1]=0.5\n{text}"),
            2,
            "character U+2028 in the file",
        ),
        (EEC, |text| format!("; a note \u{202e}\n{text}"), 2, "character U+202E in the file"),
        (EEC, |text| format!("; Fr\u{e4}se\n{text}"), 0, "job and tables agree"),
        (EEC, |text| text.replacen('\n', "\r", 1), 2, "control character U+000D"),
        (
            EEC,
            |text| format!("%_N_AX_EEC_INI\n;$PATH=/_N_WKS_DIR/_N_A_WPD\n{text}"),
            2,
            "does not go to the active data",
        ),
        (
            EEC,
            |text| format!("%_N_AX_EEC_INI\n;$PATH=/_N_NC_ACT_DIR\n{text}"),
            0,
            "job and tables agree",
        ),
        (EEC, |text| format!("\u{feff}{text}"), 2, "character U+FEFF in the file"),
    ];
    judged_as_a_control_would("siemens-840d-sl", &cases);
    let no_code: [Read; 7] = [
        (EEC, |text| format!("GOTOF END\n{text}"), 2, "`GOTOF END` does not belong here"),
        (EEC, |text| format!("IF R1==0\n{text}"), 2, "`IF R1==0` does not belong here"),
        (EEC, |text| format!("CALL \"X\"\n{text}"), 2, "does not belong here"),
        (EEC, |text| format!("/{text}"), 2, "does not belong here"),
        (EEC, |text| format!("M17\n{text}"), 2, "a statement follows the end word"),
        (EEC, |text| format!("{text}%_N_B_MPF\nM30\n"), 2, "first line"),
        (EEC, |text| text.replacen("$AA", "\0$AA", 1), 2, "control character U+0000"),
    ];
    judged_as_a_control_would("siemens-840d-sl", &no_code);
}

#[test]
fn fanuc_files_are_read_as_the_control_reads_them() {
    const POINTS: &str = "PITCH.TXT";
    const PARAMETERS: &str = "CNC-PARA.TXT";
    let cases: [Read; 14] = [
        (POINTS, |text| format!("N10003Q0P7\n{text}"), 2, "stands before the opening `%`"),
        (POINTS, |text| format!("\n{text}"), 2, "stands before the opening `%`"),
        (POINTS, |text| format!("\u{feff}{text}"), 2, "stands before the opening `%`"),
        (POINTS, |text| format!("{text}N10003Q0P7\n"), 2, "a block stands behind the closing `%`"),
        (
            POINTS,
            |text| format!("{text}sum 12\nn 10003 Q0P7"),
            2,
            "a block stands behind the closing `%`",
        ),
        (POINTS, |text| format!("{text}checked by hand\n"), 0, "job and tables agree"),
        (POINTS, |text| text.replace("\n\r\r", "\r"), 2, "carriage return"),
        (POINTS, |text| text.replacen("\n\r\rN10002", "\rN10002", 1), 2, "carriage return"),
        (POINTS, |text| text.replacen("\n\r\rN10000", "\rN10000", 1), 2, "carriage return"),
        (POINTS, |text| text.replacen("\n\r\rN10002", ";N10002", 1), 2, "`;` ends no block"),
        (POINTS, |text| text.replacen("N10002", "n10002", 1), 2, "lower case"),
        (PARAMETERS, |text| text.replacen("A1P", "A1M", 1), 2, "the letter `M`, expected `P`"),
        (POINTS, |text| text.replacen("N10002", "\u{b}N10002", 1), 2, "expected"),
        (POINTS, |text| text.replacen("N10002", "\tN10002", 1), 0, "job and tables agree"),
    ];
    judged_as_a_control_would("fanuc-30i", &cases);
    let other_kinds: [Read; 7] = [
        (POINTS, |text| text.replacen("N10002", "/N10002", 1), 2, "found `/`"),
        (POINTS, |text| text.replacen("N10002", "(N10002", 1), 2, "a comment"),
        (POINTS, |text| text.replacen("N10002", "M30\nN10002", 1), 2, "found `M`"),
        (POINTS, |text| text.replacen("N10002", "%\nN10002", 1), 2, "inside the record"),
        (POINTS, |text| format!("{text}{text}"), 2, "inside the record"),
        (
            POINTS,
            |text| text.replacen("N10002", "G10L50\nN10003R5\nG11\nN10002", 1),
            2,
            "a G10 program",
        ),
        (
            POINTS,
            |text| text.replacen("N10002", "\0N10002", 1),
            2,
            "a block that begins with `N` was expected",
        ),
    ];
    judged_as_a_control_would("fanuc-30i", &other_kinds);
}

/// What the program prints of a machine with the tables in `kit`, without how they are called.
fn figures(directory: &Path, command: &[&str]) -> String {
    let arguments = [command, &["job.toml", "--tables", "kit", "-v"]].concat();
    let output = nonius(directory, &arguments);
    assert_eq!(output.status.code(), Some(0), "{command:?}");
    let page = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines = page.lines().filter(|line| !line.starts_with("note: "));
    lines.collect::<Vec<_>>().join("\n")
}

/// A control itself calls its whole parameter file `CNC-PARA.TXT`, with thousands of others in it.
#[test]
fn a_whole_parameter_file_is_judged_by_what_concerns_the_tables() {
    let (directory, kit) = kit("fanuc-30i");
    let assess: &[&str] = &["assess"];
    let simulate: &[&str] = &["simulate", "--errors", "--force", "-o", "simulated.csv"];
    let of_the_kit = [assess, simulate].map(|command| figures(directory.path(), command));
    fs::remove_file(kit.join("manifest.json")).expect("the file can be removed");
    let path = kit.join("CNC-PARA.TXT");
    let good = fs::read_to_string(&path).expect("the file is there");
    let others = |count: usize| -> String {
        let blocks = (0..count).map(|k| format!("N{:05}Q1P0\n", 100 + k));
        blocks.collect()
    };
    for other in ["SIGN-PITCH.TXT", "SIGN-STRAIGHT.TXT", "checklist.md"] {
        fs::remove_file(kit.join(other)).expect("the file can be removed");
    }
    let blocks = format!("{}N01240Q1A1P0.0A2P0.0A3P0.0A4P5.0\n", others(200));
    let whole = behind_first_percent(&good, &blocks);
    fs::write(&path, &whole).expect("the file can be written");
    for says in [
        "job and tables agree",
        "`CNC-PARA.TXT` holds far more than a kit: taken as read out of the control",
        "`CNC-PARA.TXT`: 200 other parameters were ignored",
    ] {
        expect_verdict(directory.path(), "the whole file", 0, says);
    }
    let read_out = [assess, simulate].map(|command| figures(directory.path(), command));
    assert_eq!(read_out, of_the_kit, "the same tables, the same figures");
    let moved = whole.replace("N03620Q1A1P0A", "N03620Q1A1P1A");
    assert_ne!(moved, whole, "3620 is changed");
    fs::write(&path, moved).expect("the file can be written");
    let says = "EXX (1 while 1 moves): shifted reference";
    expect_verdict(directory.path(), "the reference moved", 1, says);
    let few = behind_first_percent(&good, &others(50));
    fs::write(&path, few).expect("the file can be written");
    let says = "and 44 more: the job does not write them";
    expect_verdict(directory.path(), "a kit with others' parameters", 1, says);
}
