//! The day at the machine, through the program: separated, made, loaded, measured again; the machines of paper 004.
use crate::support::{Visit, fixture, number, page, replaced, with_cells, without};
use serde_json::Value;

/// The box of the golden machine, as [program] and [measurement.step_diagonal] state it.
const BOX: &str = r#"
start_mm = { x = 0.0, y = 0.0, z = -720.0 }
size_mm = { x = 900.0, y = 720.0, z = 720.0 }
steps = 30
order = "XYZ"
"#;
const SIZE: &str = "{ x = 900.0, y = 720.0, z = 720.0 }";

const SIMULATED: &str = "SIMULATED, not measured";

type Campaign = [&'static str; 3];

const FORWARD: Campaign = ["bidirectional = false", "", ""];

/// machine.toml for the machine itself, job.toml for the measurement before, after.toml for that after.
fn put_jobs(visit: &Visit, golden: &str, [program, how, policy]: Campaign) {
    let golden = replaced(golden, "[compensation]\n", &format!("[compensation]\n{policy}"));
    let (head, rest) = golden.split_once("errors = \"errors.csv\"\n").unwrap();
    let (before, rest) = rest.split_once("[compensation]").unwrap();
    let measured = |readings: &str, measurement: &str, linear: &str| {
        let section = "\n[[measurement.step_diagonal.linear]]\naxis";
        let of =
            |axis| format!("{section} = \"{axis}\"\nerrors = \"{linear}\"\nu_um_per_m = 0.3\n");
        let linear = ["x", "y", "z"].map(of).concat();
        let stated = "angle_urad = 0\nsetup_ppm = 0\nlaser_ppm = 0\nbeam_mrad = 0";
        let how = format!(
            "[measurement.uncertainty]\n{stated}\n[measurement.step_diagonal]\n{how}{BOX}{linear}"
        );
        format!("{head}readings = \"{readings}\"\n{measurement}\n{how}\n[compensation]{rest}")
    };
    let machine = format!("{golden}\n[program]\nwhat = \"step-diagonal\"\n{program}{BOX}");
    visit.put("machine.toml", machine);
    visit.put("job.toml", measured("readings.csv", before, "linear.csv"));
    let after = replaced(before, "\"none\"", "\"kit\"");
    visit.put("after.toml", measured("after.csv", &after, "linear-after.csv"));
}

fn prepared(golden: &str, truth: &str, campaign: Campaign) -> Visit {
    let visit = Visit::new();
    put_jobs(&visit, golden, campaign);
    visit.put("errors.csv", truth);
    measured(&visit, "--without-tables", 1, ["readings.csv", "linear.csv"]);
    visit
}

/// Measures diagonals and linear axes, with what lies in a directory loaded.
fn measured(visit: &Visit, tables: &str, seed: u32, [readings, linear]: [&str; 2]) {
    let simulate = format!("simulate machine.toml --force --noise-um 0.2 --runs 3 {tables}");
    visit.yes(&format!("{simulate} --seed {seed} -o {readings}"));
    visit.yes(&format!("{simulate} --errors --seed {} -o {linear}", seed + 1));
}

fn judged(visit: &Visit, tables: &str) -> Value {
    measured(visit, tables, 3, ["after.csv", "linear-after.csv"]);
    visit.json("verify job.toml --tables kit --after after.toml")
}

/// The rest of a day whose first readings are filed as they are: made, loaded, measured again.
fn judged_with(visit: &Visit, readings: &str) -> Value {
    visit.put("readings.csv", readings);
    visit.run("generate job.toml -o kit --force").answers();
    judged(visit, "--tables kit")
}

fn golden(profile: &str) -> String {
    fixture(&format!("nine_errors_900/{profile}.toml"))
}

fn truth() -> String {
    fixture("nine_errors_900/errors.csv")
}

fn as_found() -> Visit {
    prepared(&golden("siemens-840d-sl"), &truth(), FORWARD)
}

#[test]
fn a_whole_visit_passes() {
    let profiles = ["siemens-840d-sl", "siemens-828d", "linuxcnc", "linuxcnc-hal", "generic"];
    for profile in profiles.into_iter().chain(["fanuc-30i", "fanuc-0i-f", "fanuc-16i"]) {
        let mut job = golden(profile);
        if profile == "linuxcnc" {
            // It corrects no straightness: 14 µm are left across, 18 µm were there along X.
            job = replaced(&job, "max_deviation_um = 10.0", "max_deviation_um = 15.0");
        }
        let visit = prepared(&job, &truth(), FORWARD);
        visit.run("separate job.toml --trials 0").ends(0).says(SIMULATED);
        visit.run("generate job.toml -o kit").ends(0).says(SIMULATED);
        visit.yes("verify job.toml --tables kit");
        let after = judged(&visit, "--tables kit");
        assert_eq!(after["verdict"], "pass", "{profile}: {after:#}");
        assert_eq!(after["diagnosis"]["as_forecast"], true, "{profile}: {after:#}");
        assert!(kinds(&after).is_empty(), "{profile}: {after:#}");
        assert!(after.to_string().contains(SIMULATED));
        for (term, found) in after["terms"].as_object().unwrap() {
            let [left, forecast, u] =
                ["after_um", "forecast_um", "u_um"].map(|key| number(&found[key]));
            // U = 2 u of both measurements: the first is in the tables, the second in `left`.
            let most = forecast + 4.0 * u;
            assert!(left <= most, "{profile} {term}: {left} > {most}");
        }
    }
}

#[test]
fn a_visit_without_loaded_tables_fails() {
    let after = judged(&as_found().with_kit(), "--without-tables");
    assert_eq!(after["verdict"], "fail", "{after:#}");
    let named = kinds(&after);
    assert!(named.contains(&"not active"), "{after:#}");
    let is_slip = |kind: &&str| ["names exchanged", "wrong order"].contains(kind);
    assert!(!named.iter().any(is_slip), "{after:#}");
}

fn causes(after: &Value) -> impl Iterator<Item = &Value> {
    after["diagnosis"]["causes"].as_array().expect("causes").iter()
}

fn kinds(after: &Value) -> Vec<&str> {
    causes(after).filter_map(|cause| cause["kind"].as_str()).collect()
}

#[track_caller]
fn is_named(after: &Value, kind: &str, holds: &str) -> String {
    let own = causes(after).find(|cause| cause["kind"] == kind);
    let words = own.map_or_else(String::new, |cause| cause["words"].to_string());
    assert!(words.contains(holds), "expected {kind}, `{holds}`: {after:#}");
    words
}

fn exchanged(readings: &str, one: &str, other: &str) -> String {
    with_cells(readings, |cells| {
        let swapped = [(one, other), (other, one)].into_iter().find(|(name, _)| cells[0] == *name);
        swapped.into_iter().for_each(|(_, name)| cells[0] = name.to_string());
        true
    })
}

/// Whatever `separate` says of it: the second measurement shows which two names were exchanged.
#[test]
fn readings_saved_under_each_others_name_are_named_after_the_second_measurement() {
    let visit = as_found();
    let right = visit.read("readings.csv");
    let with_ppp = ["NPP", "PNP", "PPN"].map(|name| ["PPP", name]);
    let others = [["NPP", "PNP"], ["NPP", "PPN"], ["PNP", "PPN"]];
    for [a, b] in with_ppp.into_iter().chain(others) {
        let after = judged_with(&visit, &exchanged(&right, a, b));
        let pair = format!("the readings of {a} and {b} of the first measurement were saved");
        let words = is_named(&after, "names exchanged", &pair);
        assert!(!words.contains(", or "), "{words}");
        let others = kinds(&after);
        assert!(others.len() <= 2, "{others:?}");
        if others.len() == 1 {
            let decides = after["diagnosis"]["decides"].as_str().unwrap();
            assert!(decides.starts_with("compare the names"), "{decides}");
        }
    }
}

/// The closure cannot tell an order from exchanged names; what the machine does afterwards can.
#[test]
fn steps_in_another_order_are_told_from_exchanged_names_after_the_second_measurement() {
    let visit = as_found();
    let simulate = "simulate walked.toml --without-tables --noise-um 0.2 --runs 3 --seed 1";
    for order in ["XZY", "YXZ", "YZX", "ZXY", "ZYX"] {
        visit.put("walked.toml", visit.read("machine.toml"));
        visit.edit("walked.toml", "order = \"XYZ\"", &format!("order = \"{order}\""));
        visit.yes(&format!("{simulate} --force -o walked.csv"));
        let recorded = with_cells(&visit.read("walked.csv"), |cells| {
            let node = cells.get(3).and_then(|cell| cell.parse::<usize>().ok());
            if let Some(node) = node.filter(|node| *node > 0) {
                cells[4] = ["z", "x", "y"][node % 3].to_string();
            }
            true
        });
        let after = judged_with(&visit, &recorded);
        assert_eq!(kinds(&after), ["wrong order"], "{order}: {after:#}");
        let [a, b, c] = [0, 1, 2].map(|step| &order[step..=step]);
        let went = format!("the steps of the first measurement went {a}, {b}, {c}");
        is_named(&after, "wrong order", &went);
    }
}

/// An update whose readings were filed wrongly: the old tables go into what the machine was.
#[test]
fn names_exchanged_while_tables_were_active_are_named() {
    let visit = as_found();
    visit.yes("generate job.toml -o old");
    // Years later every error is larger by half.
    let worn_out = with_cells(&truth(), |cells| {
        let of_errors = cells.iter_mut().skip(2);
        let worn = |um: f64| format!("{:.9}", 1.5 * um);
        of_errors.for_each(|cell| *cell = cell.parse().map_or(cell.clone(), worn));
        true
    });
    visit.put("errors.csv", worn_out);
    measured(&visit, "--tables old", 5, ["readings.csv", "linear.csv"]);
    visit.edit("job.toml", "\"none\"", "\"old\"");
    let right = visit.read("readings.csv");
    let after = judged_with(&visit, &exchanged(&right, "NPP", "PNP"));
    assert_eq!(kinds(&after), ["names exchanged"], "{after:#}");
    is_named(&after, "names exchanged", "NPP and PNP");
    let after = judged_with(&visit, &right);
    assert!(kinds(&after).is_empty(), "{after:#}");
}

/// What they were predicted from does not pass for what was measured; a small box leaves it undecided.
#[test]
fn straight_runs_of_a_rehearsal_say_what_they_are() {
    let visit = as_found();
    visit.yes("generate machine.toml -o kit");
    let original = visit.read("machine.toml");
    let judged = |size: &str| {
        let machine = replaced(&original, SIZE, size);
        visit.put("again.toml", &machine);
        visit.yes("simulate again.toml --tables kit --straight --force -o straight.csv");
        let (head, rest) = machine.split_once("errors = \"errors.csv\"").unwrap();
        let (rest, _) = rest.split_once("[program]").unwrap();
        let straight = format!("[measurement.step_diagonal]\nkind = \"straight\"\n{BOX}");
        let section = format!("{}\n[compensation]\n", replaced(&straight, SIZE, size));
        visit
            .put("straight.toml", format!("{head}readings = \"straight.csv\"{rest}"))
            .edit("straight.toml", "\"none\"", "\"kit\"")
            .edit("straight.toml", "[compensation]\n", &section)
            .edit("straight.toml", "max_deviation_um", "max_diagonal_um")
            .put("machine.toml", &machine)
            .edit("machine.toml", "max_deviation_um", "max_diagonal_um")
            .json("verify machine.toml --tables kit --after straight.toml")
    };
    let whole = judged(SIZE);
    assert!(whole["notes"].to_string().contains(SIMULATED));
    assert_eq!(whole["after"].as_array().map(Vec::len), Some(2), "{whole:#}");
    assert!(!whole["causes"].to_string().contains("was measured from"), "{whole:#}");
    let part = judged("{ x = 90.0, y = 720.0, z = 720.0 }");
    assert_eq!(part["verdict"], "undecided");
    assert!(part["causes"].to_string().contains("X was measured from 0 to 90 mm"), "{part:#}");
}

/// The golden machine with lost motion: moving − it stands 6, 4 and 3 µm further in +.
fn with_lost_motion() -> String {
    let mut text = "axis,direction,position_mm,ex_um,ey_um,ez_um\n".to_string();
    for (axis, lost) in [("x", [6.0, 0.0, 0.0]), ("y", [0.0, 4.0, 0.0]), ("z", [0.0, 0.0, 3.0])] {
        for (direction, share) in [("+", 0.0), ("-", 1.0)] {
            for row in truth().lines().filter(|row| row.starts_with(axis)) {
                let cells: Vec<&str> = row.split(',').collect();
                let um = |of: usize| cells[2 + of].parse::<f64>().unwrap() + share * lost[of];
                let [x, y, z] = [0, 1, 2].map(um);
                text += &format!("{axis},{direction},{},{x:.9},{y:.9},{z:.9}\n", cells[1]);
            }
        }
    }
    text
}

/// Neither forward runs nor runs with overrun tell it; the linear axes of the same job do, and the kit takes it away.
#[test]
fn linear_axes_in_both_directions_tell_the_reversal() {
    let mut job = golden("siemens-840d-sl");
    for (travel, wider) in [
        ("[0.0000, 900.0000]", "[-2.0, 902.0]"),
        ("[0.0000, 720.0000]", "[-2.0, 722.0]"),
        ("[-720.0000, 0.0000]", "[-722.0, 2.0]"),
    ] {
        job = replaced(&job, travel, wider);
    }
    for (program, how) in [
        ("bidirectional = false", ""),
        ("bidirectional = true\noverrun_mm = 2.0", "overrun = true"),
    ] {
        let campaign = |policy| [program, how, policy];
        let visit = prepared(&job, &with_lost_motion(), campaign(""));
        let found = visit.json("separate job.toml --trials 0");
        assert!(found["labels"].to_string().contains("reversal of single axes from their linear"));
        for (axis, lost) in [("X", 6.0), ("Y", 4.0), ("Z", 3.0)] {
            let errors = &found["errors"];
            let at_start = |way| number(&errors[format!("E{axis}{axis}{way}")]["deviation_um"][0]);
            let b = at_start("-") - at_start("+");
            assert!((b - lost).abs() < 0.6, "{axis}: {b}");
        }
        assert!(!found["undetermined"].to_string().contains("reversal"), "{found:#}");
        // Without a word on it nothing is made: a mean would leave half of the lost motion.
        visit.run("generate job.toml -o kit").ends(2).says("`backlash` is not stated");
        put_jobs(&visit, &job, campaign("backlash = \"two-tables\"\n"));
        // Of the cross terms nothing tells it.
        let made = visit.run("generate job.toml -o kit").answers();
        made.says("moving -), µm: EXX -").omits("EYX +0.000");
        let planned = format!("[program]\nwhat = \"step-diagonal\"\nruns = 2\n{program}{BOX}");
        visit.put("planned.toml", visit.read("job.toml") + &planned);
        let run = "simulate planned.toml --machine errors.csv --without-tables --force -o s.csv";
        let back = if how.is_empty() { "forward only" } else { "forward, and back" };
        visit.run(run).ends(0).says(&format!("2 run(s), {back}"));
        let after = judged(&visit, "--tables kit");
        // The noise of B is loaded with it, and may be taken for a disturbed reading: pass or undecided.
        assert_ne!(after["verdict"], "fail", "{after:#}");
        let left = number(&after["terms"]["EXX"]["after_um"]);
        assert!(left < 2.0, "6 um of lost motion were there: {left}");
        put_jobs(&visit, &job, campaign("backlash = \"mean\"\n"));
        let forecast = visit.json("generate job.toml -o mean");
        let left = number(&forecast["forecast"]["terms"]["EXX"]["after_um"]);
        assert!(left > 2.5, "the lost motion stays, and the forecast says so: {left}");
    }
}

const MATERIAL: &str = "[measurement.step_diagonal.material]
material_corrected = false
air_corrected = true
x = { alpha_per_k = 11.5e-6, temperature_c = 23.0 }
y = { alpha_per_k = 10.0e-6 }
";
const ANGLES: &str = "axis,position_mm,ea_urad,eb_urad,ec_urad
x,0,0,0,0\nx,400,5,-8,12\ny,0,0,0,0\ny,300,4,3,-6\n";

/// Sign of the laser, expansion and angles: `separate` takes them off the readings, `simulate` puts them on.
#[test]
fn predicted_readings_of_a_job_are_those_that_the_job_takes_apart() {
    let visit = Visit::of("start/readings");
    let job = visit.read("job.toml");
    let job = without(&job, "[[measurement.step_diagonal.linear]]\naxis = \"z\"");
    let readings = "readings = \"readings.csv\"";
    visit
        .put("job.toml", replaced(&job, "[compensation]", &format!("{MATERIAL}\n[compensation]")))
        .edit("job.toml", "name = \"VMC 400\"", "name = \"VMC 400\"\nchain = \"wXYZt\"")
        .edit("job.toml", "order = \"XYZ\"", "laser_sign = \"-\"\norder = \"XYZ\"")
        .edit("job.toml", readings, &format!("{readings}\nangles = \"angles.csv\""))
        .put("again.toml", visit.read("job.toml"))
        .edit("again.toml", "\"readings.csv\"", "\"again.csv\"")
        .put("angles.csv", ANGLES);
    let warm = |line: &str| match line.starts_with(['#', 'd']) {
        true => line.replace("deviation_um", "deviation_um,t_y_c"),
        false => format!("{line},22.5"),
    };
    let readings: Vec<String> = visit.read("readings.csv").lines().map(warm).collect();
    visit.put("readings.csv", readings.join("\n"));
    visit.run("simulate job.toml --without-tables -o again.csv").answers();
    let [first, again] =
        ["job", "again"].map(|job| visit.json(&format!("separate {job}.toml --trials 0")));
    for (term, curve) in first["errors"].as_object().unwrap() {
        for (index, um) in curve["deviation_um"].as_array().unwrap().iter().enumerate() {
            let repeated = &again["errors"][term]["deviation_um"][index];
            let off = (number(um) - number(repeated)).abs();
            // A tilted mirror and slopes, beyond the first order; a sign that is forgotten makes several micrometres.
            assert!(off < 0.05, "{term} {index}: {off}");
        }
    }
    let tilt = number(&again["setup_arcsec"]["NPP"]);
    assert!(tilt < 0.01, "the rehearsed mirror is straight: {tilt}");
}

/// Largest max − min along one diagonal, from a key of every diagonal.
fn largest(document: &Value, key: &str) -> f64 {
    document["diagonals"].as_object().unwrap().values().map(|d| number(&d[key])).fold(0.0, f64::max)
}

/// Figures of the table in docs/accuracy.md, from the top: a machine that was rehearsed, what was found and left, µm.
fn rehearsed((folder, as_found_um, after_um): (&str, f64, f64)) -> Vec<f64> {
    let visit = Visit::of(&format!("paper_004/{folder}"));
    let simulate = "simulate machine.toml --force";
    let read = |tables: &str, noise: &str, seed: u32, scale: f64| {
        let how = format!("--noise-um {noise} --seed {seed} --scale-um-per-m {scale}");
        visit.json(&format!("{simulate} {tables} {how} -o trial.csv"))
    };
    let found = largest(&read("--without-tables", "0", 1, 0.0), "range_um");
    assert!((found - as_found_um).abs() < 0.001, "{found}");
    let mut figures = vec![found];
    for noise in ["0.3", "1.0"] {
        let measure = format!("{simulate} --without-tables --noise-um {noise}");
        visit.yes(&format!("{measure} --seed 11 -o readings.csv"));
        visit.yes(&format!("{measure} --errors --seed 12 -o linear.csv"));
        visit.run("generate job.toml -o kit --force").answers();
        let forecast = &visit.document("kit/manifest.json")["forecast"];
        figures.extend(["after_um", "expanded_um"].map(|key| largest(forecast, key)));
        figures.push(largest(&read("--tables kit", "0", 1, 0.0), "range_um"));
        let warmer = |kelvin: f64| read("--tables kit", noise, 13, 11.5 * kelvin);
        figures.extend([0.0, 0.5, 1.0].map(|kelvin| largest(&warmer(kelvin), "read_range_um")));
    }
    figures.push(after_um);
    figures
}

#[test]
fn the_figures_of_paper_004_are_those_of_the_page() {
    let columns = [("siemens_840", 60.0, 6.8), ("jobs_link", 58.0, 8.7)].map(rehearsed);
    let page = page("docs/accuracy.md");
    let section = page.split("paper 004 rehearsed").nth(1).expect("a section");
    let rows = section.lines().filter(|line| line.starts_with("| ")).skip(2);
    let cells = |row: &str| row.split('|').skip(2).take(2).map(|c| c.trim().to_string()).collect();
    let printed: Vec<Vec<String>> = rows.take(columns[0].len()).map(cells).collect();
    let row = |row| columns.iter().map(|c| format!("{:.1}", c[row])).collect();
    let found: Vec<Vec<String>> = (0..columns[0].len()).map(row).collect();
    assert_eq!(printed, found, "the table in docs/accuracy.md; found: {found:#?}");
}
