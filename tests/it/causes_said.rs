//! What `verify --after` says of single faults: the number, the place to look at, the words, and
//! what is refused. How often faults are named at all stands in tests/studies/causes.rs.
use crate::support::Random;
use crate::support::run::ended;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Noise of both measurements, µm.
const NOISE_UM: f64 = 0.2;
/// Reversal of the machines that have one, µm.
const REVERSAL_UM: f64 = 6.0;

/// A machine with X and Y, its errors and how they are corrected.
struct Machine {
    controller: &'static str,
    /// Lines under `[compensation]`.
    policy: &'static str,
    both_ways: bool,
    spacing_mm: f64,
    error_um: fn(&Row) -> f64,
}

/// One value of a table: this error at this place, coming from there.
#[derive(Clone, Copy, PartialEq)]
struct Row {
    along: char,
    of: char,
    way: &'static str,
    mm: f64,
}

impl Row {
    fn is_positioning(&self) -> bool {
        self.along == self.of
    }

    fn at(self, mm: f64) -> Row {
        Row { mm, ..self }
    }
}

const SIEMENS: Machine = Machine {
    controller: "siemens-840d-sl",
    policy: "",
    both_ways: false,
    spacing_mm: 30.0,
    error_um: wavy,
};

const HIGH_MM: [(char, f64); 2] = [('x', 900.0), ('y', 720.0)];

fn wavy(row: &Row) -> f64 {
    let phase = f64::from(u32::from(row.along) + 3 * u32::from(row.of));
    let size = if row.is_positioning() { 7.0 } else { 3.0 };
    let wave = |mm: f64| size * (mm / 140.0 + phase).sin() + 0.012 * mm;
    let away = row.way == "-" && row.is_positioning();
    wave(row.mm) - wave(0.0) + if away { REVERSAL_UM } else { 0.0 }
}

/// A straight line and a bow: a shift moves it little.
fn gentle(row: &Row) -> f64 {
    let bow = |mm: f64| 2.0 * (mm / 220.0).sin();
    if row.is_positioning() {
        0.02 * row.mm + bow(row.mm) - bow(0.0)
    } else {
        0.3 * (bow(row.mm) - bow(0.0))
    }
}

fn places(machine: &Machine, high: f64) -> Vec<f64> {
    let mut mm = Vec::new();
    let mut at = 0.0;
    while at <= high {
        mm.push(at);
        at += machine.spacing_mm;
    }
    mm
}

fn table(machine: &Machine, seed: u64, value: impl Fn(Row) -> f64) -> String {
    let mut random = Random::new(seed);
    let mut noise = || NOISE_UM * ((0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0);
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n");
    let ways: &[&'static str] = if machine.both_ways { &["+", "-"] } else { &[""] };
    for (along, high) in HIGH_MM {
        for way in ways {
            for mm in places(machine, high) {
                let row = |of| Row { along, of, way, mm };
                let (ex, ey) = (value(row('x')) + noise(), value(row('y')) + noise());
                writeln!(csv, "{along},{way},{mm},{ex:.6},{ey:.6},{NOISE_UM},{NOISE_UM}").unwrap();
            }
        }
    }
    csv
}

fn job(machine: &Machine, errors: &str, active: &str) -> String {
    let mut text = String::from("schema = 1\n[machine]\nname = \"mill\"\n");
    for (axis, high) in HIGH_MM {
        write!(text, "[machine.axes.{axis}]\ntravel_mm = [0.0, {high:?}]\nreference_mm = 0.0\n")
            .unwrap();
    }
    write!(
        text,
        "[measurement]\nerrors = \"{errors}\"\nactive_while_measuring = \"{active}\"\n[compensation]\ncontroller = \"{}\"\n{}\n",
        machine.controller, machine.policy
    )
    .unwrap();
    for (axis, _) in HIGH_MM {
        write!(text, "[compensation.axes.{axis}]\nspacing_mm = {:?}\n", machine.spacing_mm)
            .unwrap();
        if machine.controller.starts_with("fanuc") {
            text.push_str("detection_unit_um = 0.5\n");
        }
    }
    text + "[acceptance]\nmax_deviation_um = 10.0\n"
}

/// The machine measured and its kit made.
fn visit(machine: &Machine) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("errors.csv"), table(machine, 1, |row| (machine.error_um)(&row))).unwrap();
    fs::write(path.join("job.toml"), job(machine, "errors.csv", "none")).unwrap();
    made(path, "job.toml", "kit");
    directory
}

fn made(path: &Path, job: &str, kit: &str) {
    let (_, _, said) = ended(path, &format!("generate {job} -o {kit}"));
    assert!(path.join(kit).join("manifest.json").is_file(), "{said}");
}

/// The diagnosis of a second measurement.
fn diagnosis(path: &Path, job: &str, kit: &str, after: &str) -> Value {
    let command = format!("verify {job} --tables {kit} --after {after} --format json");
    let (_, text, said) = ended(path, &command);
    let document: Value = serde_json::from_str(&text).unwrap_or_else(|_| panic!("{said}"));
    document["diagnosis"].clone()
}

fn after(machine: &Machine, left: impl Fn(Row) -> f64) -> Value {
    after_with_noise(machine, 2, left)
}

fn after_with_noise(machine: &Machine, seed: u64, left: impl Fn(Row) -> f64) -> Value {
    let directory = visit(machine);
    let path = directory.path();
    fs::write(path.join("after.csv"), table(machine, seed, left)).unwrap();
    diagnosis(path, "job.toml", "kit", "after.csv")
}

fn kinds(found: &Value) -> Vec<&str> {
    let causes = found["causes"].as_array().unwrap();
    causes.iter().map(|cause| cause["kind"].as_str().unwrap()).collect()
}

fn words(found: &Value) -> Vec<&str> {
    let causes = found["causes"].as_array().unwrap();
    causes.iter().map(|cause| cause["words"].as_str().unwrap()).collect()
}

fn decides(found: &Value) -> &str {
    found["decides"].as_str().unwrap_or_else(|| panic!("{found:#}"))
}

/// The two numbers before ` µm if <what>`.
fn amounts(decides: &str, what: &str) -> (f64, f64) {
    let (before, _) =
        decides.split_once(&format!(" µm if {what}")).unwrap_or_else(|| panic!("{decides}"));
    let words: Vec<&str> = before.split_whitespace().collect();
    let number = |from_end: usize| words[words.len() - from_end].parse().unwrap();
    (number(3), number(1))
}

/// The number after `<before> ` and the one after `± `.
fn fitted_mm(words: &str) -> (f64, f64) {
    let (_, rest) = words.split_once(" act ").unwrap();
    let parts: Vec<&str> = rest.split_whitespace().collect();
    assert_eq!(parts[1], "±", "{words}");
    (parts[0].parse().unwrap(), parts[2].parse().unwrap())
}

#[test]
fn a_reversal_without_parameter_shows_where_the_parameter_acts() {
    let machine =
        Machine { policy: "backlash = \"curve-and-parameter\"", both_ways: true, ..SIEMENS };
    let reversal = |row: Row| {
        if row.way == "-" && row.is_positioning() { REVERSAL_UM } else { 0.0 }
    };
    let found = after(&machine, reversal);
    assert_eq!(kinds(&found), ["backlash not"], "{found:#}");
    assert!(words(&found)[0].contains("the backlash parameter is 0"), "{found:#}");
    let said = decides(&found);
    assert!(said.contains("coming there moving + / moving -"), "{said}");
    let (files, fault) = (amounts(said, "the control"), amounts(said, "backlash not"));
    assert!((files.0 - fault.0).abs() < 1e-9, "+ is as planned: {said}");
    assert!(((files.1 - fault.1).abs() - REVERSAL_UM).abs() < 0.3, "- is not: {said}");
}

#[test]
fn one_table_in_both_directions_is_either_table() {
    let machine = Machine { policy: "backlash = \"two-tables\"", both_ways: true, ..SIEMENS };
    let found =
        after(
            &machine,
            |row| {
                if row.way == "-" && row.is_positioning() { REVERSAL_UM } else { 0.0 }
            },
        );
    let said = words(&found).join("\n");
    assert!(kinds(&found).iter().all(|kind| *kind == "backlash not"), "{found:#}");
    assert!(
        said.contains("the table for + acts in both")
            && said.contains("the table for - acts in both"),
        "{said}"
    );
    let said = decides(&found);
    let (files, plus) =
        (amounts(said, "the control"), amounts(said, "backlash not (every axis: table of +"));
    assert!((files.0 - plus.0).abs() < 1e-9 && (files.1 - plus.1).abs() > 5.0, "{said}");
}

#[test]
fn amounts_are_those_of_the_file_and_its_sign_is_left_open() {
    let found = after(&SIEMENS, |row| -wavy(&row));
    let said = decides(&found);
    assert!(said.contains("service display") && said.contains("ENC_COMP"), "{said}");
    assert!(said.contains("the other axes at their reference points"), "{said}");
    assert!(said.contains("its sign on the display is not documented"), "{said}");
    assert!(!said.contains("is -") && !said.contains("is +"), "{said}");
    let turned = after(&SIEMENS, |row| 2.0 * wavy(&row));
    assert_eq!(kinds(&turned), ["sign turned"]);
    assert!(decides(&turned).contains("bump of at most 20 µm"), "{turned:#}");
}

#[test]
fn no_display_is_invented_for_a_control_without_one() {
    for controller in ["fanuc-30i", "fanuc-0i-f", "fanuc-16i", "generic"] {
        let machine = Machine { controller, spacing_mm: 60.0, ..SIEMENS };
        let found = after(&machine, |row| -wavy(&row));
        let said = decides(&found);
        assert!(said.contains("no display of the correction is known"), "{controller}: {said}");
        assert!(!said.contains("service display"), "{controller}: {said}");
    }
}

#[test]
fn the_place_lies_where_was_measured() {
    // Nodes every 130 mm from the reference pass the end of the travel (900 mm).
    let machine = Machine { spacing_mm: 130.0, ..SIEMENS };
    let found = after(&machine, |row| -wavy(&row));
    let said = decides(&found);
    let (_, place) = said.split_once("added: ").unwrap();
    let words: Vec<&str> = place.split_whitespace().collect();
    let mm: f64 = words[2].parse().unwrap();
    let most = places(&machine, 900.0).into_iter().fold(0.0, f64::max);
    assert!((0.0..=most).contains(&mm), "{said}");
}

#[test]
fn a_shift_of_a_control_that_corrects_in_steps_lies_within_its_uncertainty() {
    let machine = Machine { controller: "fanuc-30i", ..SIEMENS };
    let steps = |row: Row, shift: f64| {
        let nearest = ((row.mm - shift) / 30.0).round() * 30.0;
        let high = HIGH_MM.iter().find(|(axis, _)| *axis == row.along).unwrap().1;
        wavy(&row.at(nearest.clamp(0.0, high)))
    };
    for shift in [60.0, 90.0, -40.0, -100.0] {
        let found = after(&machine, |row| {
            wavy(&row) - steps(row, if row.along == 'x' { shift } else { 0.0 })
        });
        assert_eq!(kinds(&found), ["shifted"], "{shift}: {found:#}");
        let (mm, u) = fitted_mm(words(&found)[0]);
        assert!((mm - shift).abs() <= u, "{mm} ± {u}, injected {shift}");
        assert!((10.0..40.0).contains(&u), "half a spacing is not known: {u}");
    }
}

#[test]
fn a_shift_by_two_points_that_moves_a_term_by_some_micrometres_is_named() {
    let machine =
        Machine { controller: "fanuc-30i", spacing_mm: 50.0, error_um: gentle, ..SIEMENS };
    let found = after(&machine, |row| {
        let shift = if row.along == 'x' { 100.0 } else { 0.0 };
        gentle(&row) - gentle(&row.at((row.mm - shift).max(0.0)))
    });
    assert_eq!(found["as_forecast"], false, "{found:#}");
    assert!(kinds(&found).contains(&"shifted"), "{found:#}");
}

#[test]
fn after_an_update_the_old_tables_are_tried() {
    let directory = visit(&SIEMENS);
    let path = directory.path();
    let residual = |row: Row| {
        4.0 * (row.mm / 110.0).sin() + if row.is_positioning() { 0.004 * row.mm } else { 0.0 }
    };
    fs::write(path.join("residual.csv"), table(&SIEMENS, 3, residual)).unwrap();
    fs::write(path.join("update.toml"), job(&SIEMENS, "residual.csv", "kit")).unwrap();
    made(path, "update.toml", "new");
    let named = |name: &str, left: &dyn Fn(Row) -> f64| {
        fs::write(path.join(name), table(&SIEMENS, 4, left)).unwrap();
        let found = diagnosis(path, "update.toml", "new", name);
        kinds(&found).join(", ")
    };
    assert_eq!(named("old.csv", &residual), "old tables active");
    assert_eq!(named("beside.csv", &|row| -wavy(&row)), "old beside new");
    assert!(named("none.csv", &|row| wavy(&row) + residual(row)).starts_with("not active"));
    assert_eq!(named("clean.csv", &|_| 0.0), "");
}

#[test]
fn a_turned_measurement_stands_beside_what_it_looks_like() {
    let twice = after(&SIEMENS, |row| -wavy(&row));
    assert_eq!(kinds(&twice), ["applied twice", "measurement turned"]);
    assert!(decides(&twice).contains("whether the laser counts in +"));
    let three = after(&SIEMENS, |row| -2.0 * wavy(&row));
    assert_eq!(kinds(&three), ["measurement turned", "other factor"]);
    assert!(words(&three)[0].contains("the first measurement has the wrong sign"));
}

#[test]
fn plain_causes_stand_first() {
    for seed in 2..8 {
        let found = after_with_noise(&SIEMENS, seed, |row| wavy(&row));
        assert_eq!(kinds(&found)[..2], ["not active", "wrong unit"], "{found:#}");
    }
}

#[test]
fn millimetres_under_a_heading_for_micrometres_are_refused() {
    let turned = |row: Row| 2.0 * wavy(&row) / 1000.0;
    for left in [&turned as &dyn Fn(Row) -> f64, &|_| 0.0] {
        let directory = visit(&SIEMENS);
        let path = directory.path();
        // The noise, too, is in mm.
        let text = table(&SIEMENS, 2, |row| 1000.0 * left(row));
        fs::write(path.join("after.csv"), in_mm(&text)).unwrap();
        let (status, _, said) = ended(path, "verify job.toml --tables kit --after after.csv");
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains("a slip of their unit"), "{said}");
    }
}

/// The values of a table divided by 1000; u as it stands.
fn in_mm(table: &str) -> String {
    let line = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        for cell in &mut cells[3..5] {
            if let Ok(um) = cell.parse::<f64>() {
                *cell = format!("{:.9}", um / 1000.0);
            }
        }
        cells.join(",")
    };
    table.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn what_nothing_explains_is_named_with_its_place() {
    let found = after(&SIEMENS, |row| {
        let bumped = row.along == 'x' && row.of == 'x' && (row.mm - 450.0).abs() < 1.0;
        if bumped { 5.0 } else { 0.0 }
    });
    assert_eq!(found["as_forecast"], false, "{found:#}");
    assert!(kinds(&found).is_empty(), "{found:#}");
    let by_term = found["by_term"].as_array().unwrap();
    let exx = by_term[0].as_str().unwrap();
    assert!(exx.starts_with("EXX: +") && exx.contains(" µm off the forecast at 450 mm"), "{exx}");
    assert_eq!(by_term[1], "EYX: as forecast");
}

#[test]
fn exchanged_axes_are_said_once() {
    let found = after(&SIEMENS, |row| {
        let swap = |axis| if axis == 'x' { 'y' } else { 'x' };
        let other = Row { along: swap(row.along), of: swap(row.of), ..row };
        wavy(&row) - wavy(&other.at(row.mm.min(720.0)))
    });
    assert!(kinds(&found).contains(&"wrong axis"), "{found:#}");
    let said = words(&found).join("\n");
    assert!(said.contains("were made for X, Y, Z and act on Y, X, Z"), "{said}");
    assert!(!said.contains(",,") && !said.contains("µm um"), "{said}");
}

#[test]
fn a_scale_that_does_not_grow_stays() {
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/readings");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::copy(start.join("readings.csv"), path.join("readings.csv")).unwrap();
    let job = fs::read_to_string(start.join("job.toml")).unwrap();
    let scale = |alpha: &str| format!("{{ alpha_per_k = {alpha}, temperature_c = 20.0 }}");
    let material = format!(
        "\n[measurement.step_diagonal.material]\nmaterial_corrected = false\nair_corrected = true\nx = {}\ny = {}\nz = {}\n",
        scale("0.0"),
        scale("11.5e-6"),
        scale("8.0e-6")
    );
    fs::write(path.join("job.toml"), job + &material).unwrap();
    made(path, "job.toml", "kit");
    let mut csv = String::from("axis,position_mm,ex_um,ey_um,ez_um,u_ex_um,u_ey_um,u_ez_um\n");
    let kelvin = 4.0;
    for (axis, low, step, um_per_m) in
        [("x", 0.0, 100.0, 0.0), ("y", 0.0, 75.0, 11.5), ("z", -200.0, 50.0, 8.0)]
    {
        for index in 0..=4 {
            let mm = low + step * f64::from(index);
            let um = kelvin * um_per_m * mm / 1000.0 + 0.05 * (f64::from(index) * 2.3).sin();
            let wave = 0.02 * f64::from(index).sin();
            let [mut ex, mut ey, mut ez] = [0.02 + wave, -0.03 - wave, 0.01 + wave];
            match axis {
                "x" => ex = um,
                "y" => ey = um,
                _ => ez = um,
            }
            writeln!(csv, "{axis},{mm},{ex:.4},{ey:.4},{ez:.4},0.1,0.1,0.1").unwrap();
        }
    }
    fs::write(path.join("after.csv"), csv).unwrap();
    let found = diagnosis(path, "job.toml", "kit", "after.csv");
    let said = words(&found).join("\n");
    assert!(kinds(&found).contains(&"temperature"), "{found:#}");
    assert!(said.contains("X does not grow (0e-6 per K)"), "{said}");
    assert!(said.contains("K at 11.5e-6 per K") && said.contains("K at 8.0e-6 per K"), "{said}");
}

#[test]
fn a_machine_that_became_warmer_by_one_kelvin_is_named() {
    let link = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/paper_004/jobs_link");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    for name in ["machine.toml", "job.toml", "after.toml", "truth.csv"] {
        fs::copy(link.join(name), path.join(name)).unwrap();
    }
    for command in [
        "simulate machine.toml --without-tables --noise-um 0.3 --seed 11 -o readings.csv",
        "simulate machine.toml --without-tables --noise-um 0.3 --seed 12 --errors -o linear.csv",
        "generate job.toml -o kit",
        "simulate machine.toml --tables kit --noise-um 0.3 --seed 13 --scale-um-per-m 11.5 -o after.csv",
        "simulate machine.toml --tables kit --noise-um 0.3 --seed 14 --scale-um-per-m 11.5 --errors -o linear-after.csv",
    ] {
        let (status, _, said) = ended(path, command);
        assert!(status < Some(2), "{command}: {said}");
    }
    let found = diagnosis(path, "job.toml", "kit", "after.toml");
    assert_eq!(kinds(&found)[0], "temperature", "{found:#}");
    let kelvin = found["causes"][0]["fitted"][0].as_f64().unwrap();
    assert!((kelvin - 1.0).abs() < 0.1, "{kelvin} K, 1 K was injected");
}
