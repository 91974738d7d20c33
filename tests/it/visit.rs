//! The day at the machine from end to end, through the program itself: as found, separated, made,
//! loaded into the emulated control, measured again, judged. And the two machines of paper 004.
use nonius::quantity::diagonal::Diagonal;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

fn fixtures(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
}

fn put(directory: &Path, name: &str, text: &str) {
    fs::write(directory.join(name), text).expect("a file can be written");
}

fn ended(directory: &Path, command: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// Runs a command; the exit status and what stands on standard output.
fn nonius(directory: &Path, command: &str) -> (i32, String) {
    let output = ended(directory, command);
    let status = output.status.code().expect("it ends by itself");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(status < 2, "nonius {command}\n{said}");
    (status, String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The exit status of a command and everything that it said.
fn told(directory: &Path, command: &str) -> (i32, String) {
    let output = ended(directory, command);
    let said = [output.stdout, output.stderr].concat();
    let status = output.status.code().expect("it ends by itself");
    (status, String::from_utf8_lossy(&said).into_owned())
}

fn yes(directory: &Path, command: &str) -> String {
    let (status, said) = nonius(directory, command);
    assert_eq!(status, 0, "nonius {command}\n{said}");
    said
}

fn json(directory: &Path, command: &str) -> Value {
    let (_, said) = nonius(directory, &format!("{command} --format json"));
    serde_json::from_str(&said).expect("it is JSON")
}

/// The box of the golden machine, as [program] and [measurement.step_diagonal] state it.
const BOX: &str = r#"
start_mm = { x = 0.0, y = 0.0, z = -720.0 }
size_mm = { x = 900.0, y = 720.0, z = 720.0 }
steps = 30
order = "XYZ"
"#;

/// How the golden machine is measured.
struct Campaign {
    /// Lines under [program].
    program: &'static str,
    /// Lines under [measurement.step_diagonal].
    how: &'static str,
    /// Lines under [compensation].
    policy: &'static str,
}

/// The jobs of a visit: the machine itself, the measurement before, the one after.
fn jobs(golden: &str, campaign: &Campaign) -> [String; 3] {
    let golden =
        golden.replace("[compensation]\n", &format!("[compensation]\n{}", campaign.policy));
    let machine =
        format!("{golden}\n[program]\nwhat = \"step-diagonal\"\n{}{BOX}", campaign.program);
    let measured = |readings: &str, linear: &str| {
        let (head, rest) =
            golden.split_once("errors = \"errors.csv\"\n").expect("the job names its errors");
        let (measurement, rest) = rest.split_once("[compensation]").expect("a section");
        let mut how = format!("[measurement.step_diagonal]\n{}{BOX}", campaign.how);
        for axis in ["x", "y", "z"] {
            how += &format!(
                "\n[[measurement.step_diagonal.linear]]\naxis = \"{axis}\"\nerrors = \"{linear}\"\nu_um_per_m = 0.3\n"
            );
        }
        let measurement = match readings {
            "after.csv" => measurement.replace("\"none\"", "\"kit\""),
            _ => measurement.to_string(),
        };
        format!("{head}readings = \"{readings}\"\n{measurement}\n{how}\n[compensation]{rest}")
    };
    [machine, measured("readings.csv", "linear.csv"), measured("after.csv", "linear-after.csv")]
}

/// A folder with the jobs and the true curves, measured as found, and with the kit made from that.
fn prepared(golden: &str, truth: &str, campaign: &Campaign) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let at = directory.path();
    let [machine, job, after] = jobs(golden, campaign);
    put(at, "errors.csv", truth);
    put(at, "machine.toml", &machine);
    put(at, "job.toml", &job);
    put(at, "after.toml", &after);
    let simulate = "simulate machine.toml --without-tables --noise-um 0.2 --runs 3";
    yes(at, &format!("{simulate} --seed 1 -o readings.csv"));
    yes(at, &format!("{simulate} --errors --seed 2 -o linear.csv"));
    directory
}

/// The second measurement, with what lies in a directory loaded.
fn measured_again(at: &Path, tables: &str) {
    let simulate = "simulate machine.toml --force --noise-um 0.2 --runs 3";
    yes(at, &format!("{simulate} {tables} --seed 3 -o after.csv"));
    yes(at, &format!("{simulate} {tables} --errors --seed 4 -o linear-after.csv"));
}

const FORWARD: Campaign = Campaign { program: "bidirectional = false", how: "", policy: "" };

fn golden(profile: &str) -> (String, String) {
    let folder = fixtures("nine_errors_900");
    let job = fs::read_to_string(folder.join(format!("{profile}.toml")));
    let truth = fs::read_to_string(folder.join("errors.csv"));
    (job.expect("a job"), truth.expect("a table"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("it is a number")
}

const PROFILES: [&str; 8] = [
    "siemens-840d-sl",
    "siemens-828d",
    "fanuc-30i",
    "fanuc-0i-f",
    "fanuc-16i",
    "linuxcnc",
    "linuxcnc-hal",
    "generic",
];

#[test]
fn a_whole_visit_passes_with_every_control() {
    for profile in PROFILES {
        let (mut job, truth) = golden(profile);
        if profile == "linuxcnc" {
            // It corrects no straightness: 14 µm are left across, 18 µm were there along X.
            job = job.replace("max_deviation_um = 10.0", "max_deviation_um = 15.0");
        }
        let visit = prepared(&job, &truth, &FORWARD);
        let at = visit.path();
        let said = yes(at, "separate job.toml --trials 0");
        assert!(said.contains("SIMULATED, not measured"), "{said}");
        let said = yes(at, "generate job.toml -o kit");
        assert!(said.contains("SIMULATED, not measured"), "{said}");
        yes(at, "verify job.toml --tables kit");
        measured_again(at, "--tables kit");
        let after = json(at, "verify job.toml --tables kit --after after.toml");
        assert_eq!(after["verdict"], "pass", "{profile}: {after:#}");
        assert!(after.to_string().contains("SIMULATED, not measured"));
        for (term, found) in after["terms"].as_object().expect("terms") {
            let left = number(&found["after_um"]);
            let forecast = number(&found["forecast_um"]);
            let expanded = 2.0 * number(&found["u_um"]);
            // Both measurements are uncertain: the first is in the tables, the second in `left`.
            let most = forecast + 2.0 * expanded;
            assert!(left <= most, "{profile} {term}: {left} > {most}");
        }
    }
}

/// The kit forgotten: the same second measurement must not pass.
#[test]
fn a_visit_without_loaded_tables_fails() {
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &truth, &FORWARD);
    let at = visit.path();
    yes(at, "generate job.toml -o kit");
    measured_again(at, "--without-tables");
    let after = json(at, "verify job.toml --tables kit --after after.toml");
    assert_eq!(after["verdict"], "fail", "{after:#}");
    let named = kinds(&after);
    assert!(named.contains(&"not active"), "{after:#}");
    let slips = ["names exchanged", "wrong order"];
    assert!(!slips.iter().any(|slip| named.contains(slip)), "{after:#}");
}

/// Kinds of the causes that the page names.
fn kinds(after: &Value) -> Vec<&str> {
    let causes = after["diagnosis"]["causes"].as_array().expect("causes");
    causes.iter().filter_map(|c| c["kind"].as_str()).collect()
}

/// What the page says of the cause of this kind.
fn words_of(after: &Value, kind: &str) -> String {
    let causes = after["diagnosis"]["causes"].as_array().expect("causes");
    let own = causes.iter().find(|cause| cause["kind"] == kind);
    own.map_or_else(String::new, |cause| cause["words"].to_string())
}

/// Every reading with its cells changed; comments and header stay.
fn rewritten(readings: &str, change: impl Fn(&mut Vec<String>)) -> String {
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        if cells.len() > 1 && Diagonal::from_name(&cells[0]).is_some() {
            change(&mut cells);
        }
        cells.join(",") + "\n"
    };
    readings.lines().map(row).collect()
}

/// The rest of a day whose first readings are filed as they are: made, loaded, measured again.
fn judged_with(at: &Path, readings: &str) -> Value {
    put(at, "readings.csv", readings);
    nonius(at, "generate job.toml -o kit --force");
    measured_again(at, "--tables kit");
    json(at, "verify job.toml --tables kit --after after.toml")
}

/// Whatever `separate` says of it: the second measurement shows which two names were exchanged.
#[test]
fn readings_saved_under_each_others_name_are_named_after_the_second_measurement() {
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &truth, &FORWARD);
    let at = visit.path();
    let right = fs::read_to_string(at.join("readings.csv")).expect("readings");
    for (index, one) in Diagonal::ALL.into_iter().enumerate() {
        for other in Diagonal::ALL.into_iter().skip(index + 1) {
            let (a, b) = (one.name(), other.name());
            let exchanged = rewritten(&right, |cells| match cells[0].as_str() {
                own if own == a => cells[0] = b.to_string(),
                own if own == b => cells[0] = a.to_string(),
                _ => {}
            });
            let after = judged_with(at, &exchanged);
            let words = words_of(&after, "names exchanged");
            let pair = format!("the readings of {a} and {b} of the first measurement were saved");
            assert!(words.contains(&pair), "{a}, {b}: {after:#}");
            assert!(!words.contains(", or "), "{words}");
            let others: Vec<&str> = kinds(&after);
            assert!(others.len() <= 2, "{others:?}");
            if others.len() == 1 {
                let decides = after["diagnosis"]["decides"].as_str().expect("words");
                assert!(decides.starts_with("compare the names"), "{decides}");
            }
        }
    }
    let after = judged_with(at, &right);
    assert_eq!(after["diagnosis"]["as_forecast"], true, "{after:#}");
    assert!(kinds(&after).is_empty(), "{after:#}");
}

/// The closure cannot tell an order from exchanged names; what the machine does afterwards can.
#[test]
fn steps_in_another_order_are_told_from_exchanged_names_after_the_second_measurement() {
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &truth, &FORWARD);
    let at = visit.path();
    let machine = fs::read_to_string(at.join("machine.toml")).expect("a job");
    for order in ["XZY", "YXZ", "YZX", "ZXY", "ZYX"] {
        let walked = machine.replace("order = \"XYZ\"", &format!("order = \"{order}\""));
        put(at, "walked.toml", &walked);
        let simulate = "simulate walked.toml --without-tables --noise-um 0.2 --runs 3 --seed 1";
        yes(at, &format!("{simulate} --force -o walked.csv"));
        let walked = fs::read_to_string(at.join("walked.csv")).expect("readings");
        let recorded = rewritten(&walked, |cells| {
            let node: usize = cells[3].parse().expect("a number");
            if node > 0 {
                cells[4] = ["z", "x", "y"][node % 3].to_string();
            }
        });
        let after = judged_with(at, &recorded);
        assert_eq!(kinds(&after), ["wrong order"], "{order}: {after:#}");
        let letters: Vec<String> = order.chars().map(String::from).collect();
        let went = format!("the steps of the first measurement went {}", letters.join(", "));
        let words = words_of(&after, "wrong order");
        assert!(words.contains(&went), "{words}");
    }
}

/// An update whose readings were filed wrongly: the old tables go into what the machine was.
#[test]
fn names_exchanged_while_tables_were_active_are_named() {
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &truth, &FORWARD);
    let at = visit.path();
    yes(at, "generate job.toml -o old");
    let worn = worn_out(&truth);
    put(at, "errors.csv", &worn);
    let simulate = "simulate machine.toml --force --noise-um 0.2 --runs 3 --tables old";
    yes(at, &format!("{simulate} --seed 5 -o readings.csv"));
    yes(at, &format!("{simulate} --errors --seed 6 -o linear.csv"));
    let update = fs::read_to_string(at.join("job.toml")).expect("a job");
    let update = update.replace("\"none\"", "\"old\"");
    put(at, "job.toml", &update);
    let right = fs::read_to_string(at.join("readings.csv")).expect("readings");
    let exchanged = rewritten(&right, |cells| match cells[0].as_str() {
        "NPP" => cells[0] = "PNP".to_string(),
        "PNP" => cells[0] = "NPP".to_string(),
        _ => {}
    });
    let after = judged_with(at, &exchanged);
    assert_eq!(kinds(&after), ["names exchanged"], "{after:#}");
    let words = words_of(&after, "names exchanged");
    assert!(words.contains("NPP and PNP"), "{words}");
    let after = judged_with(at, &right);
    assert!(kinds(&after).is_empty(), "{after:#}");
}

/// The golden machine years later: every error is larger by half.
fn worn_out(truth: &str) -> String {
    let row = |line: &str| {
        let cells = line.split(',').enumerate();
        let worn = cells.map(|(index, cell)| match cell.parse::<f64>() {
            Ok(um) if index >= 2 => format!("{:.9}", 1.5 * um),
            _ => cell.to_string(),
        });
        worn.collect::<Vec<String>>().join(",") + "\n"
    };
    truth.lines().map(row).collect()
}

/// Straight runs of a rehearsal: what they are stands on the page, and what they were predicted
/// from does not pass for what was measured; a small box leaves it undecided.
#[test]
fn straight_runs_of_a_rehearsal_say_what_they_are() {
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &truth, &FORWARD);
    let at = visit.path();
    yes(at, "generate machine.toml -o kit");
    let judged = |size: &str| {
        let machine = fs::read_to_string(at.join("machine.toml")).expect("a job");
        let machine = machine.replace("{ x = 900.0, y = 720.0, z = 720.0 }", size);
        put(at, "again.toml", &machine);
        yes(at, "simulate again.toml --tables kit --straight --force -o straight.csv");
        let (head, rest) = machine.split_once("errors = \"errors.csv\"").expect("errors");
        let (rest, _) = rest.split_once("[program]").expect("a program");
        let section =
            format!("[measurement.step_diagonal]\nkind = \"straight\"\n{BOX}\n[compensation]\n");
        let section = section.replace("{ x = 900.0, y = 720.0, z = 720.0 }", size);
        let rest = rest.replace("\"none\"", "\"kit\"").replace("[compensation]\n", &section);
        put(at, "straight.toml", &format!("{head}readings = \"straight.csv\"{rest}"));
        let limit = machine.replace("max_deviation_um", "max_diagonal_um");
        put(at, "machine.toml", &limit);
        let judged = json(at, "verify machine.toml --tables kit --after straight.toml");
        put(at, "machine.toml", &machine);
        judged
    };
    let whole = judged("{ x = 900.0, y = 720.0, z = 720.0 }");
    assert!(whole["notes"].to_string().contains("SIMULATED, not measured"));
    assert_eq!(whole["after"].as_array().map(Vec::len), Some(2), "{whole:#}");
    assert!(!whole["causes"].to_string().contains("was measured from"), "{whole:#}");
    let part = judged("{ x = 90.0, y = 720.0, z = 720.0 }");
    assert_eq!(part["verdict"], "undecided");
    assert!(part["causes"].to_string().contains("X was measured from 0 to 90 mm"), "{part:#}");
}

/// The golden machine with lost motion: moving − it stands 6, 4 and 3 µm further in +.
fn with_lost_motion(truth: &str) -> String {
    let mut text = "axis,direction,position_mm,ex_um,ey_um,ez_um\n".to_string();
    let rows = || truth.lines().filter(|line| line.starts_with(['x', 'y', 'z']));
    for axis in ["x", "y", "z"] {
        for direction in ["+", "-"] {
            for row in rows().filter(|row| row.starts_with(axis)) {
                let cells: Vec<&str> = row.split(',').collect();
                let value = |index: usize| -> f64 { cells[index].parse().expect("a number") };
                let lost = |own: &str, um: f64| match axis == own && direction == "-" {
                    true => um,
                    false => 0.0,
                };
                let x = value(2) + lost("x", 6.0);
                let y = value(3) + lost("y", 4.0);
                let z = value(4) + lost("z", 3.0);
                text += &format!("{axis},{direction},{},{x:.9},{y:.9},{z:.9}\n", cells[1]);
            }
        }
    }
    text
}

#[test]
fn a_visit_in_both_directions_takes_the_lost_motion_away() {
    let campaign = Campaign {
        program: "bidirectional = true\noverrun_mm = 0.0",
        how: "overrun = false",
        policy: "backlash = \"two-tables\"\n",
    };
    let (job, truth) = golden("siemens-840d-sl");
    let visit = prepared(&job, &with_lost_motion(&truth), &campaign);
    let at = visit.path();
    let found = json(at, "separate job.toml --trials 0");
    let (plus, minus) = (&found["errors"]["EXX+"], &found["errors"]["EXX-"]);
    let at_start = |curve: &Value| number(&curve["deviation_um"][0]);
    let lost = at_start(minus) - at_start(plus);
    assert!((lost - 6.0).abs() < 0.5, "{lost}");
    yes(at, "generate job.toml -o kit");
    measured_again(at, "--tables kit");
    let after = json(at, "verify job.toml --tables kit --after after.toml");
    assert_eq!(after["verdict"], "pass", "{after:#}");
}

/// Neither forward runs nor runs with overrun tell the reversal of an axis; the linear axes of the
/// same job do, and the kit takes it away.
#[test]
fn linear_axes_in_both_directions_tell_the_reversal() {
    let (job, truth) = golden("siemens-840d-sl");
    for (program, how) in [
        ("bidirectional = false", ""),
        ("bidirectional = true\noverrun_mm = 2.0", "overrun = true"),
    ] {
        let job = job.replace("travel_mm = [0.0000, 900.0000]", "travel_mm = [-2.0, 902.0]");
        let job = job.replace("travel_mm = [0.0000, 720.0000]", "travel_mm = [-2.0, 722.0]");
        let job = job.replace("travel_mm = [-720.0000, 0.0000]", "travel_mm = [-722.0, 2.0]");
        let campaign = |policy| Campaign { program, how, policy };
        let visit = prepared(&job, &with_lost_motion(&truth), &campaign(""));
        let at = visit.path();
        let found = json(at, "separate job.toml --trials 0");
        let labels = found["labels"].to_string();
        assert!(labels.contains("reversal of single axes from their linear"), "{labels}");
        for (axis, lost) in [("X", 6.0), ("Y", 4.0), ("Z", 3.0)] {
            let curve = |sign: &str| &found["errors"][format!("E{axis}{axis}{sign}")];
            let b = number(&curve("-")["deviation_um"][0]) - number(&curve("+")["deviation_um"][0]);
            assert!((b - lost).abs() < 0.6, "{axis}: {b}");
        }
        assert!(!found["undetermined"].to_string().contains("reversal"), "{found:#}");
        // Without a word on it nothing is made: a mean would leave half of the lost motion.
        let (status, said) = told(at, "generate job.toml -o kit");
        assert_eq!(status, 2, "{said}");
        assert!(said.contains("`backlash` is not stated"), "{said}");
        let [machine, stated, after] = jobs(&job, &campaign("backlash = \"two-tables\"\n"));
        put(at, "machine.toml", &machine);
        put(at, "job.toml", &stated);
        put(at, "after.toml", &after);
        yes(at, "generate job.toml -o kit");
        measured_again(at, "--tables kit");
        let after = json(at, "verify job.toml --tables kit --after after.toml");
        // The noise of B from place to place is loaded with it, and a forward run that mixes both
        // directions may take it for a disturbed reading: pass or undecided.
        assert_ne!(after["verdict"], "fail", "{after:#}");
        let left = number(&after["terms"]["EXX"]["after_um"]);
        assert!(left < 2.0, "6 um of lost motion were there: {left}");
        let [_, mean, _] = jobs(&job, &campaign("backlash = \"mean\"\n"));
        put(at, "job.toml", &mean);
        let forecast = json(at, "generate job.toml -o mean");
        let left = number(&forecast["forecast"]["terms"]["EXX"]["after_um"]);
        assert!(left > 2.5, "the lost motion stays, and the forecast says so: {left}");
    }
}

/// What a tilted mirror and slopes do beyond the first order, µm; a sign or a correction that is
/// forgotten makes several micrometres.
const SECOND_ORDER_UM: f64 = 0.05;

/// Sign of the laser, expansion and angles: what `separate` takes off the readings of a job,
/// `simulate` puts on the readings that it predicts for the same job.
#[test]
fn predicted_readings_of_a_job_are_those_that_the_job_takes_apart() {
    let start = fixtures("start").join("readings");
    let read = |name: &str| fs::read_to_string(start.join(name)).expect("a fixture");
    let job = read("job.toml");
    let (job, _) = job.split_once("[[measurement.step_diagonal.linear]]\naxis = \"z\"").map_or_else(
        || panic!("three linear axes"),
        |(head, rest)| {
            let (_, rest) = rest.split_once("[compensation]").expect("a section");
            (format!("{head}[measurement.step_diagonal.material]\nmaterial_corrected = false\nair_corrected = true\nx = {{ alpha_per_k = 11.5e-6, temperature_c = 23.0 }}\ny = {{ alpha_per_k = 10.0e-6 }}\n\n[compensation]{rest}"), ())
        },
    );
    let job = job
        .replace("name = \"VMC 400\"", "name = \"VMC 400\"\nchain = \"wXYZt\"")
        .replace("order = \"XYZ\"", "laser_sign = \"-\"\norder = \"XYZ\"")
        .replace(
            "readings = \"readings.csv\"",
            "readings = \"readings.csv\"\nangles = \"angles.csv\"",
        );
    let warm = |line: &str| match line.starts_with(['#', 'd']) {
        true => line.replace("deviation_um", "deviation_um,t_y_c"),
        false => format!("{line},22.5"),
    };
    let readings: Vec<String> = read("readings.csv").lines().map(warm).collect();
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let at = directory.path();
    put(at, "job.toml", &job);
    put(at, "again.toml", &job.replace("\"readings.csv\"", "\"again.csv\""));
    put(at, "readings.csv", &readings.join("\n"));
    put(
        at,
        "angles.csv",
        "axis,position_mm,ea_urad,eb_urad,ec_urad\nx,0,0,0,0\nx,400,5,-8,12\ny,0,0,0,0\ny,300,4,3,-6\n",
    );
    nonius(at, "simulate job.toml --without-tables -o again.csv");
    let [first, again] =
        ["job.toml", "again.toml"].map(|job| json(at, &format!("separate {job} --trials 0")));
    for (term, curve) in first["errors"].as_object().expect("errors") {
        let um = |document: &Value, index: usize| {
            number(&document["errors"][term]["deviation_um"][index])
        };
        for index in 0..curve["deviation_um"].as_array().expect("a curve").len() {
            let off = (um(&first, index) - um(&again, index)).abs();
            assert!(off < SECOND_ORDER_UM, "{term} {index}: {off}");
        }
    }
    let tilt = |document: &Value| number(&document["setup_arcsec"]["NPP"]);
    assert!(tilt(&again) < 0.01, "the rehearsed mirror is straight: {}", tilt(&again));
}

/// A rehearsed machine of paper 004.
struct Paper {
    folder: &'static str,
    as_found_um: f64,
    after_um: f64,
}

const PAPER_004: [Paper; 2] = [
    Paper { folder: "siemens_840", as_found_um: 60.0, after_um: 6.8 },
    Paper { folder: "jobs_link", as_found_um: 58.0, after_um: 8.7 },
];

/// Largest max − min along one diagonal, from a key of every diagonal.
fn largest(document: &Value, key: &str) -> f64 {
    let diagonals = document["diagonals"].as_object().expect("diagonals");
    diagonals.values().map(|d| number(&d[key])).fold(0.0, f64::max)
}

/// Figures of the table in docs/accuracy.md, from the top.
fn rehearsed(paper: &Paper) -> Vec<f64> {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let at = directory.path();
    for name in ["truth.csv", "machine.toml", "job.toml", "after.toml"] {
        let from = fixtures("paper_004").join(paper.folder).join(name);
        fs::copy(from, at.join(name)).expect("a fixture can be copied");
    }
    let simulate = "simulate machine.toml --force";
    let read = |tables: &str, noise: &str, seed: u32, scale: f64| {
        let scale = format!("--scale-um-per-m {scale}");
        json(
            at,
            &format!("{simulate} {tables} --noise-um {noise} --seed {seed} {scale} -o trial.csv"),
        )
    };
    let found = largest(&read("--without-tables", "0", 1, 0.0), "range_um");
    assert!((found - paper.as_found_um).abs() < 0.001, "{found}");
    let mut figures = vec![found];
    for noise in ["0.3", "1.0"] {
        let measure = format!("{simulate} --without-tables --noise-um {noise}");
        yes(at, &format!("{measure} --seed 11 -o readings.csv"));
        yes(at, &format!("{measure} --errors --seed 12 -o linear.csv"));
        nonius(at, "generate job.toml -o kit --force");
        let kit = fs::read_to_string(at.join("kit/manifest.json")).expect("a manifest");
        let kit: Value = serde_json::from_str(&kit).expect("it is JSON");
        let forecast = &kit["forecast"];
        figures.push(largest(forecast, "after_um"));
        figures.push(largest(forecast, "expanded_um"));
        figures.push(largest(&read("--tables kit", "0", 1, 0.0), "range_um"));
        for kelvin in [0.0, 0.5, 1.0] {
            let scale = 11.5 * kelvin;
            figures.push(largest(&read("--tables kit", noise, 13, scale), "read_range_um"));
        }
    }
    figures.push(paper.after_um);
    figures
}

#[test]
fn the_figures_of_paper_004_are_those_of_the_page() {
    let columns: Vec<Vec<f64>> = PAPER_004.iter().map(rehearsed).collect();
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md"))
        .expect("the page is there");
    let section = page.split("paper 004 rehearsed").nth(1).expect("a section");
    let rows = section.lines().filter(|line| line.starts_with("| ")).skip(2);
    let printed: Vec<Vec<String>> = rows
        .take(columns[0].len())
        .map(|row| row.split('|').skip(2).take(2).map(|c| c.trim().to_string()).collect())
        .collect();
    let found: Vec<Vec<String>> = (0..columns[0].len())
        .map(|row| columns.iter().map(|c| format!("{:.1}", c[row])).collect())
        .collect();
    assert_eq!(printed, found, "the table in docs/accuracy.md; found: {found:#?}");
}
