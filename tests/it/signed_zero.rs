//! No output has a signed zero: what is nothing is `0`, `0.000` or `+0.000` on every computer.
//!
//! Errors of a few tenths of a nanometre, most of them negative, go through every command: rounded
//! to the digits that are printed they are nothing.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// `-0`, `-0.0`, `−0.000` … that are no part of a word, a date or a longer number.
fn signed_zeros(text: &str) -> Vec<&str> {
    let is_part = |c: char| c.is_alphanumeric() || "._-".contains(c);
    let mut found = Vec::new();
    for (at, sign) in text.match_indices(['-', '−']) {
        let rest = &text[at + sign.len()..];
        let zeros = rest.len() - rest.trim_start_matches(['0', '.']).len();
        let behind = rest[zeros..].chars().next();
        let before = text[..at].chars().next_back();
        let is_number = rest.starts_with('0') && !behind.is_some_and(is_part);
        if is_number && !before.is_some_and(is_part) {
            let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
            found.push(text[start..].lines().next().unwrap_or_default());
        }
    }
    found
}

#[test]
fn the_search_finds_them() {
    for text in ["-0", "a -0.000 b", "[-0.0]", "x,−0.00", "(-0, 1)", "-0.\n"] {
        assert_eq!(signed_zeros(text).len(), 1, "{text}");
    }
    for text in ["2026-01-01", "fanuc-0i", "-0.001", "+0.000", "-01", "1e-0", "- 0"] {
        assert!(signed_zeros(text).is_empty(), "{text}");
    }
}

/// What every test, page and snapshot of the repository expects.
#[test]
fn nothing_that_is_expected_holds_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).display().to_string();
    let patterns = ["tests/snapshots/*.snap", "fixtures/cases/refuses/*.txt"];
    for pattern in patterns {
        let pattern = format!("{}/{pattern}", root.replace('\\', "/"));
        for entry in glob::glob(&pattern).expect("the pattern is valid") {
            let path = entry.expect("it can be read");
            let text = fs::read_to_string(&path).expect("it is text");
            // A case holds its inputs, and may show the line of one as it was written.
            let is_case = path.extension().is_some_and(|end| end == "txt");
            let is_own = |line: &&str| !line.contains('|') && (!is_case || line.starts_with('>'));
            let own = text.lines().filter(is_own);
            let own: Vec<&str> = own.flat_map(signed_zeros).collect();
            assert!(own.is_empty(), "{}: {own:?}", path.display());
        }
    }
}

/// Errors and readings that are nothing but for their sign.
fn inputs(directory: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let write = |name: &str, text: &str| {
        fs::write(directory.join(name), text).expect("an input can be written");
    };
    let read = |name: &str| fs::read_to_string(root.join(name)).expect("the fixture is there");
    let mut errors = "axis,position_mm,ex_um,ey_um,ez_um\n".to_string();
    for (axis, sign, length) in [("x", 1.0, 900.0), ("y", 1.0, 720.0), ("z", -1.0, 720.0)] {
        for part in 0..=4 {
            let node = if sign < 0.0 { 4 - part } else { part };
            let mm = sign * length / 4.0 * f64::from(node);
            let um = -1e-7 * f64::from(node * (4 - part % 3));
            writeln!(errors, "{axis},{mm:?},{um:?},{:?},{um:?}", um / 3.0).expect("it is text");
        }
    }
    write("errors.csv", &errors);
    for control in ["generic", "siemens-840d-sl", "fanuc-30i"] {
        write(&format!("{control}.toml"), &read(&format!("nine_errors_900/{control}.toml")));
    }
    write("part.nc", "G21 G90 G54\nG0 X0 Y0 Z0\nG1 X100 Y50 Z-10 F1000\nX0 Y0 Z0\nM30\n");
    let path = "\n[[path.offset]]\nsystem = \"G54\"\nx_mm = -0.0\ny_mm = 0.0\nz_mm = 0.0\n";
    write("path.toml", &(read("nine_errors_900/generic.toml") + path));
    write("readings.csv", &read("start/readings/readings.csv"));
    write("readings.toml", &read("start/readings/job.toml"));
    let mut runs = "target_mm,run,direction,deviation_um\n".to_string();
    for (target, run) in
        [0, 100, 200, 300, 400].iter().flat_map(|t| (1..6).map(move |run| (t, run)))
    {
        for direction in ["+", "-"] {
            let um = -1e-7 * f64::from(run);
            writeln!(runs, "{target},{run},{direction},{um:?}").expect("it is text");
        }
    }
    write("runs.csv", &runs);
}

#[test]
fn no_command_prints_or_writes_one() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    inputs(directory.path());
    let mut commands: Vec<String> = Vec::new();
    for control in ["generic", "siemens-840d-sl", "fanuc-30i"] {
        commands.push(format!("generate {control}.toml -o kit-{control}"));
        commands.push(format!("generate {control}.toml -o kit-{control} --force --format json"));
        for format in ["text", "json"] {
            commands
                .push(format!("verify {control}.toml --tables kit-{control} --format {format}"));
            commands.push(format!(
                "verify {control}.toml --tables kit-{control} --after errors.csv --format {format}"
            ));
            commands.push(format!("assess {control}.toml --with-tables --format {format}"));
        }
    }
    for format in ["text", "json"] {
        commands.push(format!(
            "path path.toml part.nc --with-tables -o points-{format}.csv --format {format}"
        ));
        commands.push(format!("separate readings.toml --format {format}"));
        commands.push(format!("standards runs.csv --format {format}"));
    }
    for command in &commands {
        let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
            .args(command.split_whitespace())
            .current_dir(directory.path())
            .stdin(Stdio::null())
            .output()
            .expect("the program starts");
        let told = [output.stdout, output.stderr].concat();
        let told = String::from_utf8(told).expect("it prints UTF-8");
        assert_ne!(output.status.code(), Some(2), "{command}\n{told}");
        let found = signed_zeros(&told);
        assert!(found.is_empty(), "{command}: {found:#?}");
    }
    let written = format!("{}/**/*", directory.path().display().to_string().replace('\\', "/"));
    for entry in glob::glob(&written).expect("the pattern is valid") {
        let path = entry.expect("it can be read");
        let is_input =
            path.file_name().is_some_and(|name| name == "path.toml" || name == "errors.csv");
        if path.is_file() && !is_input {
            let text = fs::read_to_string(&path).expect("it is text");
            let found = signed_zeros(&text);
            assert!(found.is_empty(), "{}: {found:#?}", path.display());
        }
    }
}
