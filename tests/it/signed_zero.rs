//! No output has a signed zero: what is nothing is `0`, `0.000` or `+0.000` on every computer.
//!
//! Errors of a few tenths of a nanometre, most of them negative, go through every command: rounded
//! to the digits that are printed they are nothing.

use crate::support::{G54, Visit, fixture, fixtures};
use std::fmt::Write as _;

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

/// What every test, page and snapshot of the repository expects.
#[test]
fn the_search_finds_them_and_nothing_that_is_expected_holds_one() {
    for text in ["-0", "a -0.000 b", "[-0.0]", "x,−0.00", "(-0, 1)", "-0.\n"] {
        assert_eq!(signed_zeros(text).len(), 1, "{text}");
    }
    for text in ["2026-01-01", "fanuc-0i", "-0.001", "+0.000", "-01", "1e-0", "- 0"] {
        assert!(signed_zeros(text).is_empty(), "{text}");
    }
    for folder in ["../tests/it/snapshots", "cases/refuses"] {
        let mut count = 0;
        for entry in std::fs::read_dir(fixtures(folder)).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            // A case holds its inputs, and may show the line of one as it was written.
            let is_case = path.extension().is_some_and(|end| end == "txt");
            let is_own = |line: &&str| !line.contains('|') && (!is_case || line.starts_with('>'));
            let own: Vec<&str> = text.lines().filter(is_own).flat_map(signed_zeros).collect();
            assert!(own.is_empty(), "{}: {own:?}", path.display());
            count += 1;
        }
        assert!(count > 10, "{folder}: {count}");
    }
}

/// Errors and readings that are nothing but for their sign.
fn inputs() -> Visit {
    let visit = Visit::new();
    let mut errors = "axis,position_mm,ex_um,ey_um,ez_um\n".to_string();
    for (axis, sign, length) in [("x", 1.0, 900.0), ("y", 1.0, 720.0), ("z", -1.0, 720.0)] {
        for part in 0..=4 {
            let node = if sign < 0.0 { 4 - part } else { part };
            let mm = sign * length / 4.0 * f64::from(node);
            let um = -1e-7 * f64::from(node * (4 - part % 3));
            writeln!(errors, "{axis},{mm:?},{um:?},{:?},{um:?}", um / 3.0).unwrap();
        }
    }
    visit.put("errors.csv", &errors);
    for control in CONTROLS {
        visit.copy(&format!("nine_errors_900/{control}.toml"), &format!("{control}.toml"));
    }
    visit.put("part.nc", "G21 G90 G54\nG0 X0 Y0 Z0\nG1 X100 Y50 Z-10 F1000\nX0 Y0 Z0\nM30\n");
    let path = G54.replace("x_mm = 0.0", "x_mm = -0.0");
    visit.put("path.toml", fixture("nine_errors_900/generic.toml") + &path);
    visit.copy("start/readings/readings.csv", "readings.csv");
    visit.copy("start/readings/job.toml", "readings.toml");
    let mut runs = "target_mm,run,direction,deviation_um\n".to_string();
    for target in [0, 100, 200, 300, 400] {
        for (run, direction) in (1..6).flat_map(|run| ["+", "-"].map(|way| (run, way))) {
            writeln!(runs, "{target},{run},{direction},{:?}", -1e-7 * f64::from(run)).unwrap();
        }
    }
    visit.put("runs.csv", &runs);
    visit
}

const CONTROLS: [&str; 3] = ["generic", "siemens-840d-sl", "fanuc-30i"];

/// Grids and trials are few: an unoptimised program takes seconds for each thousand of them.
#[test]
fn no_command_prints_or_writes_one() {
    let visit = inputs();
    let run = |command: &str| {
        let told = visit.run(command).answers().omits("\u{fffd}").all();
        let found = signed_zeros(&told);
        assert!(found.is_empty(), "{command}: {found:#?}");
    };
    for control in CONTROLS {
        run(&format!("generate {control}.toml -o kit-{control}"));
        run(&format!("generate {control}.toml -o kit-{control} --force --format json"));
    }
    for format in ["--format text", "--format json"] {
        for control in CONTROLS {
            let verify = format!("verify {control}.toml --tables kit-{control} {format}");
            run(&verify);
            run(&format!("{verify} --after errors.csv"));
            run(&format!("assess {control}.toml --with-tables --grid 11,11,11 {format}"));
        }
        let points = format.replace("--format ", "points-");
        run(&format!("path path.toml part.nc --with-tables -o {points}.csv {format}"));
        run(&format!("separate readings.toml --trials 50 {format}"));
        run(&format!("standards runs.csv {format}"));
    }
    for (name, text) in visit.texts() {
        let found = signed_zeros(&text);
        let is_input = ["path.toml", "errors.csv"].contains(&name.as_str());
        assert!(is_input || found.is_empty(), "{name}: {found:#?}");
    }
}
