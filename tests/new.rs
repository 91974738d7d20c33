//! A visit from an empty folder: `nonius new`, its empty cells filled in, `separate`, `generate`.
#![allow(
    clippy::expect_used,
    clippy::panic,
    reason = "a test may stop at the first thing that is not as expected"
)]

#[path = "support/run.rs"]
mod run;

use nonius::control::controller::builtin;
use run::ended;
use serde_json::Value;
use std::fs::{read_to_string, write};
use std::path::Path;

/// What a person fills in; of an axis by its place.
fn value_of(key: &str, axis: usize, is_siemens: bool) -> String {
    match key {
        "name" => "\"VMC 800\"".to_string(),
        "date" => "\"2026-11-20\"".to_string(),
        "active_while_measuring" => "\"none\"".to_string(),
        "reference_mm" => "0.0".to_string(),
        "reference_direction" => "\"+\"".to_string(),
        "control_unit" => "\"mm\"".to_string(),
        "first_table" => "0".to_string(),
        "first_set" | "measuring_system" => "1".to_string(),
        "reserved_points" => "[]".to_string(),
        "id" if is_siemens => format!("\"AX{}\"", axis + 1),
        "id" => format!("\"{}\"", axis + 1),
        "detection_unit_um" => "1.0".to_string(),
        "backlash" => "\"mean\"".to_string(),
        "slope_um_per_m" => SLOPES[axis].to_string(),
        "max_deviation_um" => "10.0".to_string(),
        other => panic!("nobody said what `{other}` is"),
    }
}

/// Fills in every `""` of a job, and changes nothing else.
fn fill_in_job(at: &Path, is_siemens: bool) {
    let job = read_to_string(at.join("job.toml")).expect("a job");
    let mut axis = 0;
    let filled = job.lines().map(|line| {
        let found = |key: &str| line.starts_with('[') && line.contains(key);
        axis = match [".x]", ".y]", ".z]"].iter().position(|end| found(end)) {
            Some(place) => place,
            None if line.starts_with("axis = ") => usize::from(line.as_bytes()[8] - b'x'),
            None => axis,
        };
        let key = line.split(" = ").next().expect("a line");
        match line.starts_with(|c: char| c.is_ascii_lowercase()) && line.contains("= \"\"") {
            true => line.replacen("\"\"", &value_of(key, axis, is_siemens), 1),
            false => line.to_string(),
        }
    });
    let filled: Vec<String> = filled.collect();
    write(at.join("job.toml"), filled.join("\n")).expect("it can be written");
}

/// Positioning of X, Y and Z, µm/m.
const SLOPES: [f64; 3] = [20.0, -15.0, 25.0];

/// Deviations while an axis moves: a scale that is off, and a bow on both other axes.
fn deviations(axis: usize, at_mm: f64, is_back: bool) -> [f64; 3] {
    let bow = 4e-5 * at_mm * at_mm;
    let lost = if is_back { -3.0 } else { 0.0 };
    let mut deviations = [bow, -0.5 * bow, 0.3 * bow];
    deviations[axis] = SLOPES[axis] * at_mm / 1000.0 + lost;
    deviations
}

/// Fills in the cells of an error table.
fn fill_in_errors(at: &Path) {
    let table = read_to_string(at.join("errors.csv")).expect("a table");
    let filled = table.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let (Some(axis), Ok(mm)) = (
            ["x", "y", "z"].iter().position(|name| *name == cells[0]),
            cells.get(1).unwrap_or(&"").parse::<f64>(),
        ) else {
            return line.to_string();
        };
        let direction = cells.get(5);
        let [x, y, z] = deviations(axis, mm, direction == Some(&"-"));
        let direction = direction.map_or(String::new(), |sign| format!(",{sign}"));
        format!("{},{},{x},{y},{z}{direction}", cells[0], cells[1])
    });
    let filled: Vec<String> = filled.collect();
    write(at.join("errors.csv"), filled.join("\n")).expect("it can be written");
}

fn begun(at: &Path, id: &str, more: &str) {
    let travel = "--travel 800,500,-400:0";
    let command = format!("new --controller {id} {travel} {more} -o visit");
    let (status, page, said) = ended(at, &command);
    assert_eq!(status, Some(0), "{id}: {said}");
    assert!(page.contains("Z -400 … 0 mm"), "{page}");
    assert!(said.contains("visit/job.toml") || cfg!(windows), "{said}");
}

/// The kit of a visit that was filled in: made, and nothing assumed that its job could have stated.
fn kit_of(at: &Path, id: &str) -> i32 {
    let (status, _, said) = ended(at, "generate visit/job.toml -o visit/kit");
    assert!(matches!(status, Some(0 | 1)), "{id}: {said}");
    let manifest = read_to_string(at.join("visit/kit/manifest.json")).expect("a kit");
    let manifest: Value = serde_json::from_str(&manifest).expect("it is JSON");
    let profile = builtin::profile(id).expect("it is built in");
    let facts: Vec<&str> = profile.statements.iter().map(|s| s.fact.as_str()).collect();
    for assumed in manifest["assumptions"].as_array().expect("a list") {
        let fact = assumed["fact"].as_str().expect("a name");
        assert!(
            facts.contains(&fact) || fact.starts_with("pitch_compensation_of_axis"),
            "{id}: {fact}"
        );
    }
    status.unwrap_or(2)
}

#[test]
fn every_control_gets_from_an_empty_folder_to_a_kit() {
    for id in builtin::ids() {
        for more in ["", "--both-directions --steps 8"] {
            let place = tempfile::tempdir().expect("a place to write to");
            let (at, visit) = (place.path(), place.path().join("visit"));
            begun(at, id, more);
            let (status, _, said) = ended(at, "generate visit/job.toml -o visit/kit");
            assert_eq!(status, Some(2), "{id}: {said}");
            assert!(
                said.contains("keys are empty, expected a value of each"),
                "{said}"
            );
            assert!(said.contains("the table holds no deviation"), "{said}");
            assert!(!visit.join("kit").exists());
            fill_in_job(&visit, id.starts_with("siemens"));
            fill_in_errors(&visit);
            let status = kit_of(at, id);
            let takes_all = ["generic", "siemens-840d-sl"].contains(&id);
            assert!(status == 0 || !takes_all, "{id} {more}");
        }
    }
}

/// What a laser shows at a node of a step diagonal: its nominal displacement and the errors along it.
fn reading(
    diagonal: &str,
    node: usize,
    is_back: bool,
    (start, size): ([f64; 3], [f64; 3]),
    steps: usize,
) -> f64 {
    let signs: Vec<f64> = diagonal
        .chars()
        .map(|c| if c == 'P' { 1.0 } else { -1.0 })
        .collect();
    let length = size.iter().map(|s| s * s).sum::<f64>().sqrt();
    let place = |axis: usize, node: usize| {
        let done = (node + 2 - axis) / 3;
        let part = size[axis] * done as f64 / steps as f64;
        start[axis]
            + if signs[axis] > 0.0 {
                part
            } else {
                size[axis] - part
            }
    };
    let errors = |node: usize, is_back: bool| {
        let mut sum = [0.0; 3];
        for (axis, sign) in signs.iter().enumerate() {
            // The deviation of an axis that comes back the other way is that of its own sense of travel.
            let of_axis = deviations(axis, place(axis, node), is_back != (*sign < 0.0));
            for (sum, own) in sum.iter_mut().zip(of_axis) {
                *sum += own;
            }
        }
        sum
    };
    let (here, first) = (errors(node, is_back), errors(0, false));
    let along = |axis: usize| signs[axis] * size[axis] / length;
    (0..3)
        .map(|axis| {
            let moved = place(axis, node) - place(axis, 0);
            along(axis) * (moved + (here[axis] - first[axis]) / 1000.0)
        })
        .sum()
}

/// Fills in the cells of a table of readings.
fn fill_in_readings(at: &Path) {
    let job = read_to_string(at.join("job.toml")).expect("a job");
    let numbers = |key: &str| {
        let line = job
            .lines()
            .find(|line| line.starts_with(key))
            .expect("it is stated");
        let inside = line.split(['{', '}']).nth(1).expect("a place");
        let parts = inside
            .split(',')
            .map(|part| part.split('=').nth(1).expect("a number"));
        let parts: Vec<f64> = parts
            .map(|part| part.trim().parse().expect("a number"))
            .collect();
        [parts[0], parts[1], parts[2]]
    };
    let volume = (numbers("start_mm"), numbers("size_mm"));
    let table = read_to_string(at.join("readings.csv")).expect("a table");
    let steps = table
        .lines()
        .filter(|line| line.starts_with("PPP,forward,"))
        .count()
        / 3;
    let filled = table
        .lines()
        .map(|line| match line.split(',').collect::<Vec<_>>()[..] {
            [diagonal, direction, node, _, ""] => {
                let node = node.parse().expect("a node");
                format!(
                    "{line}{:.6}",
                    reading(diagonal, node, direction == "reverse", volume, steps)
                )
            }
            _ => line.to_string(),
        });
    let filled: Vec<String> = filled.collect();
    write(at.join("readings.csv"), filled.join("\n")).expect("it can be written");
}

#[test]
fn every_control_gets_from_an_empty_folder_to_a_kit_by_readings() {
    for id in builtin::ids() {
        for more in ["--readings", "--readings --both-directions"] {
            let place = tempfile::tempdir().expect("a place to write to");
            let (at, visit) = (place.path(), place.path().join("visit"));
            begun(at, id, more);
            let (status, _, said) = ended(at, "separate visit/job.toml");
            assert_eq!(status, Some(2), "{id}: {said}");
            assert!(
                said.contains("keys are empty, expected a value of each"),
                "{said}"
            );
            assert!(
                said.contains("`displacement_mm` is empty, expected a number"),
                "{said}"
            );
            fill_in_job(&visit, id.starts_with("siemens"));
            if builtin::profile(id).expect("built in").program.is_some() {
                let (status, _, said) = ended(at, "program visit/job.toml -o visit/programs");
                assert_eq!(status, Some(0), "{id}: {said}");
            }
            fill_in_readings(&visit);
            let (status, page, said) = ended(at, "separate visit/job.toml --trials 0");
            assert_eq!(status, Some(0), "{id} {more}: {page}{said}");
            kit_of(at, id);
        }
    }
}

#[test]
fn what_is_there_stays_and_a_slip_of_the_options_is_refused() {
    let place = tempfile::tempdir().expect("a place to write to");
    let at = place.path();
    begun(at, "generic", "");
    for (options, says) in [
        ("--controller generic --travel 1,2,3 -o visit", "visit"),
        (
            "--controller generic --travel 1,2 -o other",
            "names 2 axes, expected X, Y and Z",
        ),
        (
            "--controller generic --travel 1,2,3:3 -o other",
            "the ends of the travel as LOW:HIGH",
        ),
        (
            "--controller generic --travel 5,400,400 --readings -o other",
            "too short for",
        ),
        (
            "--controller fanuc-31i --travel 1,2,3 -o other",
            "did you mean `fanuc-30i`",
        ),
    ] {
        let (status, _, said) = ended(at, &format!("new {options}"));
        assert_eq!(status, Some(2), "{options}");
        assert!(said.contains(says), "{options}: {said}");
        assert!(!at.join("other").exists(), "{options}");
    }
    let (status, document, _) = ended(
        at,
        "new --controller generic --travel 1,2,3 -o visit --force --format json",
    );
    assert_eq!(status, Some(0));
    let document: Value = serde_json::from_str(&document).expect("it is JSON");
    assert_eq!(document["steps"], 10);
    assert!(at.join("visit.previous/job.toml").exists());
}

#[test]
fn a_profile_of_ones_own_is_named_from_inside_the_visit() {
    let place = tempfile::tempdir().expect("a place to write to");
    let at = place.path();
    let page = "schema = 1\nid = \"shop\"\nname = \"shop\"\nbased_on = \"fanuc-30i\"\n";
    write(at.join("shop.toml"), page).expect("it can be written");
    begun(at, "shop.toml", "");
    let visit = at.join("visit");
    fill_in_job(&visit, false);
    fill_in_errors(&visit);
    let (status, _, said) = ended(at, "generate visit/job.toml -o visit/kit");
    assert!(matches!(status, Some(0 | 1)), "{said}");
}
