//! A visit from an empty folder: `nonius new`, its empty cells filled in, and every command that it names.
use crate::support::run::ended;
use nonius::control::controller::{Dialect, builtin};
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
        "active_backlash_um" => "{ x = 0.0, y = 0.0, z = 0.0 }".to_string(),
        "u_um_per_m" => "0.5".to_string(),
        "control_unit" => "\"mm\"".to_string(),
        "first_table" => "0".to_string(),
        "first_set" | "measuring_system" => "1".to_string(),
        "reserved_points" => "[]".to_string(),
        "id" if is_siemens => format!("\"AX{}\"", axis + 1),
        "id" => format!("\"{}\"", axis + 1),
        "detection_unit_um" => "1.0".to_string(),
        "backlash" => "\"mean\"".to_string(),
        "max_deviation_um" => "10.0".to_string(),
        other => panic!("nobody said what `{other}` is"),
    }
}

/// Keys that nobody knows before the measurement.
const MEASURED: [&str; 4] =
    ["date", "active_while_measuring", "active_backlash_um", "slope_um_per_m"];

/// Fills in the `""` of a job but those of `later`, and changes nothing else.
fn fill_in_job(job: &Path, is_siemens: bool, slopes: [f64; 3], later: &[&str]) {
    let page = read_to_string(job).expect("a job");
    let named = |id: &&str| page.contains(&format!("controller = \"{id}\""));
    let own = builtin::ids()
        .into_iter()
        .find(named)
        .map(|id| builtin::profile(id).expect("it is built in"));
    let own = own.filter(|own| matches!(own.dialect, Dialect::Declared(_)));
    let mut axis = 0;
    let filled = page.lines().map(|line| {
        let found = |key: &str| line.starts_with('[') && line.contains(key);
        axis = match [".x]", ".y]", ".z]"].iter().position(|end| found(end)) {
            Some(place) => place,
            None if line.starts_with("axis = ") => usize::from(line.as_bytes()[8] - b'x'),
            None => axis,
        };
        let key = line.split(" = ").next().expect("a line");
        let is_empty =
            line.starts_with(|c: char| c.is_ascii_lowercase()) && line.contains("= \"\"");
        match key {
            key if !is_empty || later.contains(&key) => line.to_string(),
            "slope_um_per_m" => line.replacen("\"\"", &slopes[axis].to_string(), 1),
            "id" if own.is_some() => {
                let names = own.as_ref().map(|own| own.axis_names.value.clone());
                let name = names.expect("a declared control")[axis].clone();
                line.replacen("\"\"", &format!("\"{name}\""), 1)
            }
            key => line.replacen("\"\"", &value_of(key, axis, is_siemens), 1),
        }
    });
    let filled: Vec<String> = filled.collect();
    write(job, filled.join("\n")).expect("it can be written");
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
    begun_as(at, id, more, "visit");
}

fn begun_as(at: &Path, id: &str, more: &str, name: &str) {
    let travel = "--travel 800,500,-400:0";
    let command = format!("new --controller {id} {travel} {more} -o {name}");
    let (status, page, said) = ended(at, &command);
    assert_eq!(status, Some(0), "{id}: {said}");
    assert!(page.contains("Z -400 … 0 mm"), "{page}");
    assert!(said.contains("/job.toml") || cfg!(windows), "{said}");
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

/// The invented machine as an error table, with rows at the ends of a box of diagonals too.
fn machine(at: &Path, more: &str, box_ends: &[[f64; 2]; 3]) {
    begun_as(at, "generic", more, "machine");
    let table = at.join("machine/errors.csv");
    let page = read_to_string(&table).expect("a table");
    let (mut rows, mut others): (Vec<String>, Vec<String>) =
        page.lines().map(str::to_string).partition(|row| row.contains(",,,"));
    for (axis, ends) in ["x", "y", "z"].iter().zip(box_ends) {
        let both = more.contains("--both-directions");
        let directions: &[&str] = if both { &[",+", ",-"] } else { &[""] };
        for (end, direction) in ends.iter().flat_map(|e| directions.iter().map(move |d| (e, d))) {
            rows.push(format!("{axis},{end},,,{direction}"));
        }
    }
    let key = |row: &String| {
        let cells: Vec<&str> = row.split(',').collect();
        let mm: f64 = cells[1].parse().expect("a position");
        let direction = cells.get(5).copied().unwrap_or("").to_string();
        (cells[0].to_string(), direction, (1e6 * (mm + 1e4)).round().to_bits())
    };
    rows.sort_by_key(key);
    rows.dedup_by_key(|row| key(row));
    others.extend(rows);
    write(&table, others.join("\n")).expect("it can be written");
    fill_in_errors(&at.join("machine"));
}

/// The ends of the box that a job with readings describes.
fn box_ends(job: &Path) -> [[f64; 2]; 3] {
    let job = read_to_string(job).expect("a job");
    let numbers = |key: &str| -> Vec<f64> {
        let line = job.lines().find(|line| line.starts_with(key));
        let inside = line.and_then(|line| line.split(['{', '}']).nth(1));
        let parts = inside.expect("a place").split(',');
        let parts = parts.map(|part| part.split('=').nth(1).expect("a number").trim());
        parts.map(|part| part.parse().expect("a number")).collect()
    };
    let (start, size) = (numbers("start_mm"), numbers("size_mm"));
    [0, 1, 2].map(|axis| [start[axis], start[axis] + size[axis]])
}

/// Slopes of the positioning in an error table between the ends of a box, µm/m, mean of the directions.
fn slopes(table: &Path, ends: &[[f64; 2]; 3]) -> [f64; 3] {
    let page = read_to_string(table).expect("a table");
    let mut lines = page.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| head.iter().position(|cell| *cell == name);
    let column = |name: &str| column(name).unwrap_or_else(|| panic!("no {name} in {page}"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let number = |row: &Vec<&str>, name: &str| -> f64 {
        row[column(name)].parse().expect("a number in the cell")
    };
    [0, 1, 2].map(|axis| {
        let (name, own) = (["x", "y", "z"][axis], ["ex_um", "ey_um", "ez_um"][axis]);
        let at = |end: f64| {
            let here = rows.iter().filter(|row| row[column("axis")] == name);
            let here = here.filter(|row| (number(row, "position_mm") - end).abs() < 1e-6);
            let values: Vec<f64> = here.map(|row| number(row, own)).collect();
            assert!(!values.is_empty(), "{name} at {end}: {page}");
            values.iter().sum::<f64>() / values.len() as f64
        };
        let [low, high] = ends[axis];
        1000.0 * (at(high) - at(low)) / (high - low)
    })
}

/// Runs a command that has to end with one of these statuses; what it prints.
fn done(at: &Path, command: &str, statuses: &[i32]) -> String {
    let (status, page, said) = ended(at, command);
    let is_fine = status.is_some_and(|status| statuses.contains(&status));
    assert!(is_fine, "{command}: {status:?}\n{page}\n{said}");
    page + &said
}

/// A visit of one control, from `new` to the report, its tables filled in by `simulate`.
fn visit(id: &str, more: &str) {
    let place = tempfile::tempdir().expect("a place to write to");
    let (at, visit) = (place.path(), place.path().join("visit"));
    let (job, is_siemens) = (visit.join("job.toml"), id.starts_with("siemens"));
    let are_readings = more.contains("--readings");
    begun_as(at, id, more, "visit");
    let ends = match are_readings {
        true => box_ends(&job),
        false => [[0.0, 800.0], [0.0, 500.0], [-400.0, 0.0]],
    };
    machine(at, &more.replace("--readings", ""), &ends);
    let both =
        if more.contains("--both-directions") && are_readings { "--both-directions" } else { "" };
    let form = if are_readings { both } else { "--errors" };
    let simulate = |tables: &str, output: &str| {
        let machine = "--machine machine/errors.csv";
        let command = format!("simulate visit/job.toml {machine} {tables} -o {output} --force");
        done(at, &command, &[0])
    };
    let refused = done(at, "generate visit/job.toml -o visit/kit", &[2]);
    assert!(refused.contains("keys are empty, expected a value of each"), "{refused}");
    if are_readings {
        before(at, id, is_siemens);
    } else {
        assert!(refused.contains("the table holds no deviation"), "{refused}");
    }
    fill_in_job(&job, is_siemens, SLOPES, &[]);
    let table = if are_readings { "readings.csv" } else { "errors.csv" };
    simulate(&format!("--without-tables {form}"), &format!("visit/{table}"));
    if are_readings {
        done(at, "separate visit/job.toml --trials 0", &[0]);
    }
    let status = kit_of(at, id);
    let takes_all = ["generic", "siemens-840d-sl"].contains(&id);
    assert!(status == 0 || !takes_all || are_readings, "{id} {more}");
    done(at, "verify visit/job.toml --tables visit/kit", &[0, 1]);
    let refused = done(at, "verify visit/job.toml --tables visit", &[2]);
    assert!(refused.contains("it is no kit"), "{id}: {refused}");
    assert_eq!(refused.matches("problem:").count(), 1, "{id}: {refused}");
    done(at, "report visit/job.toml --tables visit/kit -o first.html", &[0, 1]);
    simulate(&format!("--tables visit/kit {form}"), "visit/after.csv");
    if are_readings {
        simulate("--tables visit/kit --errors", "linear.csv");
        let slopes = slopes(&at.join("linear.csv"), &ends);
        fill_in_job(&visit.join("after.toml"), is_siemens, slopes, &[]);
    }
    let after = if are_readings { "after.toml" } else { "after.csv" };
    let tables = format!("visit/job.toml --tables visit/kit --after visit/{after}");
    let page = done(at, &format!("verify {tables}"), &[0, 1]);
    assert!(page.contains("REHEARSAL") && !page.contains("NOT AS FORECAST"), "{id} {more}: {page}");
    done(at, &format!("report {tables} -o visit/report.html"), &[0, 1]);
    let reports = ["first.html", "visit/report.html"].map(|name| read_to_string(at.join(name)));
    let [first, second] = reports.map(|report| report.expect("a report"));
    assert!(first.contains("VMC 800") && second.contains("SIMULATED"), "{id} {more}");
}

/// What comes before the readings asks for nothing that is known only after them.
fn before(at: &Path, id: &str, is_siemens: bool) {
    let visit = at.join("visit");
    fill_in_job(&visit.join("job.toml"), is_siemens, SLOPES, &MEASURED);
    done(at, "plan visit/job.toml", &[0, 1]);
    if builtin::profile(id).expect("built in").program.is_some() {
        let said = done(at, "program visit/job.toml -o visit/programs", &[0]);
        assert!(said.contains("readings.csv, which the job names"), "{said}");
        assert!(!said.contains("an end of the travel"), "{said}");
        assert!(!visit.join("programs/readings.csv").exists());
    }
    let refused = done(at, "separate visit/job.toml", &[2]);
    for line in
        ["keys are empty, expected a value of each", "slope_um_per_m", "active_while_measuring"]
    {
        assert!(refused.contains(line), "{refused}");
    }
    assert!(!refused.contains("detection_unit_um"), "{refused}");
    assert!(refused.contains("`displacement_mm` is empty, expected a number"), "{refused}");
}

#[test]
fn every_control_gets_from_an_empty_folder_to_a_report() {
    for id in builtin::ids().into_iter().filter(|id| *id != "klipper-skew") {
        visit(id, "");
        visit(id, "--both-directions --steps 8");
    }
}

#[test]
fn every_control_gets_from_an_empty_folder_to_a_report_by_readings() {
    for id in builtin::ids().into_iter().filter(|id| *id != "klipper-skew") {
        visit(id, "--readings");
        visit(id, "--readings --both-directions");
    }
}

#[test]
fn the_slopes_of_the_first_job_copied_to_the_second_are_blamed_on_nobody_else() {
    let place = tempfile::tempdir().expect("a place to write to");
    let (at, visit) = (place.path(), place.path().join("visit"));
    begun_as(at, "generic", "--readings", "visit");
    machine(at, "", &box_ends(&visit.join("job.toml")));
    fill_in_job(&visit.join("job.toml"), false, SLOPES, &[]);
    fill_in_job(&visit.join("after.toml"), false, SLOPES, &[]);
    let simulate = "simulate visit/job.toml --machine machine/errors.csv --force";
    done(at, &format!("{simulate} --without-tables -o visit/readings.csv"), &[0]);
    done(at, "generate visit/job.toml -o visit/kit", &[0, 1]);
    done(at, &format!("{simulate} --tables visit/kit -o visit/after.csv"), &[0]);
    let verify = "verify visit/job.toml --tables visit/kit --after visit/after.toml";
    let page = done(at, verify, &[1]);
    assert!(page.contains("`slope_um_per_m` of XYZ afterwards is that of the first job"), "{page}");
    assert!(page.starts_with("REHEARSAL") && page.contains("verdict: undecided"), "{page}");
    assert!(!page.contains("TEMPERATURE"), "{page}");
}

#[test]
fn what_is_there_stays_and_a_slip_of_the_options_is_refused() {
    let place = tempfile::tempdir().expect("a place to write to");
    let at = place.path();
    begun(at, "generic", "");
    for (options, says) in [
        ("--controller generic --travel 1,2,3 -o visit", "visit"),
        ("--controller generic --travel 1,2 -o other", "names 2 axes, expected X, Y and Z"),
        ("--controller generic --travel 1,2,3:3 -o other", "the ends of the travel as LOW:HIGH"),
        ("--controller generic --travel -800,2,3 -o other", "from -800 to 0 mm is `-800:0`"),
        ("--controller generic --travel 5,400,400 --readings -o other", "too short for"),
        ("--controller fanuc-31i --travel 1,2,3 -o other", "did you mean `fanuc-30i`"),
    ] {
        let (status, _, said) = ended(at, &format!("new {options}"));
        assert_eq!(status, Some(2), "{options}");
        assert!(said.contains(says), "{options}: {said}");
        assert!(!at.join("other").exists(), "{options}");
    }
    let (status, document, _) =
        ended(at, "new --controller generic --travel 1,2,3 -o visit --force --format json");
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
    fill_in_job(&visit.join("job.toml"), false, SLOPES, &[]);
    fill_in_errors(&visit);
    let (status, _, said) = ended(at, "generate visit/job.toml -o visit/kit");
    assert!(matches!(status, Some(0 | 1)), "{said}");
}
