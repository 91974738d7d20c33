//! What `verify --after` says of single faults, and what is refused; how often they are named: tests/studies/causes.rs.
use crate::support::{Random, Visit, error_rows, holds, job_measured, number};
use serde_json::Value;

const NOISE_UM: f64 = 0.2;
const PARAMETER: &str = "backlash = \"curve-and-parameter\"";
const TWO_TABLES: &str = "backlash = \"two-tables\"";
/// Reversal of the machines that have one, µm.
const REVERSAL_UM: f64 = 6.0;

struct Machine {
    controller: &'static str,
    /// A line under `[compensation]`; with one, measured in both directions.
    policy: &'static str,
    spacing_mm: f64,
    error_um: fn(Row) -> f64,
    /// Noise of the second measurement.
    seed: u64,
}

/// One value of a table: this error at this place, coming from there.
#[derive(Clone, Copy, PartialEq)]
struct Row {
    along: char,
    of: char,
    is_back: bool,
    mm: f64,
}

impl Row {
    fn is_positioning(self) -> bool {
        self.along == self.of
    }

    fn at(self, mm: f64) -> Row {
        Row { mm, ..self }
    }

    /// The reversal of the machine, left where its axes move in -.
    fn reversal(self) -> f64 {
        if self.is_back && self.is_positioning() { REVERSAL_UM } else { 0.0 }
    }
}

const SIEMENS: Machine = Machine {
    controller: "siemens-840d-sl",
    policy: "",
    spacing_mm: 30.0,
    error_um: wavy,
    seed: 2,
};

const HIGH_MM: [(&str, f64); 2] = [("x", 900.0), ("y", 720.0)];

fn wavy(row: Row) -> f64 {
    let phase = f64::from(u32::from(row.along) + 3 * u32::from(row.of));
    let size = if row.is_positioning() { 7.0 } else { 3.0 };
    let wave = |mm: f64| size * (mm / 140.0 + phase).sin() + 0.012 * mm;
    wave(row.mm) - wave(0.0) + row.reversal()
}

/// A straight line and a bow: a shift moves it little.
fn gentle(row: Row) -> f64 {
    let bow = |mm: f64| 2.0 * (mm / 220.0).sin();
    let (slope, part) = if row.is_positioning() { (0.02, 1.0) } else { (0.0, 0.3) };
    slope * row.mm + part * (bow(row.mm) - bow(0.0))
}

fn places(machine: &Machine, high: f64) -> impl Iterator<Item = f64> {
    (0..).map(|index| machine.spacing_mm * f64::from(index)).take_while(move |mm| *mm <= high)
}

fn table(machine: &Machine, seed: u64, value: impl Fn(Row) -> f64) -> String {
    let mut random = Random::new(seed);
    let mut noise = || NOISE_UM * ((0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0);
    let axes = HIGH_MM.map(|(axis, high)| (axis, places(machine, high).collect()));
    let ways: &[&str] = if machine.policy.is_empty() { &[""] } else { &["+", "-"] };
    error_rows("ex_um,ey_um,u_ex_um,u_ey_um", &axes, ways, |axis, way, mm| {
        let (along, is_back) = (axis.chars().next().unwrap(), way == "-");
        let [ex, ey] = ['x', 'y'].map(|of| value(Row { along, of, is_back, mm }) + noise());
        [ex, ey, NOISE_UM, NOISE_UM]
    })
}

fn job(machine: &Machine, errors: &str, active: &str) -> String {
    let Machine { controller, policy, spacing_mm, .. } = machine;
    let unit = if controller.starts_with("fanuc") { "detection_unit_um = 0.5" } else { "" };
    let keys = format!("spacing_mm = {spacing_mm:?}\n{unit}");
    let axes = HIGH_MM.map(|(axis, high)| (axis, [0.0, high], 0.0, keys.clone()));
    let measured = format!("errors = \"{errors}\"\nactive_while_measuring = \"{active}\"");
    let control = format!("controller = \"{controller}\"\n{policy}");
    job_measured(&measured, &control, axes) + "[acceptance]\nmax_deviation_um = 10.0\n"
}

fn visit(machine: &Machine) -> Visit {
    let errors = table(machine, 1, machine.error_um);
    Visit::with(job(machine, "errors.csv", "none"), errors).with_any_kit()
}

struct Found {
    kinds: Vec<String>,
    words: Vec<String>,
    decides: String,
    page: Value,
}

fn diagnosis(visit: &Visit, arguments: &str) -> Found {
    let page = visit.json(&format!("verify {arguments}"))["diagnosis"].clone();
    println!("{page:#}");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let of = |key: &str| page["causes"].as_array().unwrap().iter().map(|c| text(&c[key])).collect();
    Found { kinds: of("kind"), words: of("words"), decides: text(&page["decides"]), page }
}

fn after(machine: &Machine, left: impl Fn(Row) -> f64) -> Found {
    let visit = visit(machine);
    visit.put("after.csv", table(machine, machine.seed, left));
    diagnosis(&visit, "job.toml --tables kit --after after.csv")
}

/// The two numbers before ` µm if <what>`.
#[track_caller]
fn amounts(decides: &str, what: &str) -> (f64, f64) {
    let (before, _) =
        decides.split_once(&format!(" µm if {what}")).unwrap_or_else(|| panic!("{decides}"));
    let words: Vec<&str> = before.split_whitespace().collect();
    let number = |from_end: usize| words[words.len() - from_end].parse().unwrap();
    (number(3), number(1))
}

/// Shown where the parameter acts; one table in both directions is either table.
#[test]
fn a_reversal_that_stays_is_a_parameter_or_a_table_that_does_not_act() {
    let left = |policy| after(&Machine { policy, ..SIEMENS }, Row::reversal);
    let found = left(PARAMETER);
    assert_eq!(found.kinds, ["backlash not"]);
    holds(&found.words[0], &["the backlash parameter is 0"]);
    let said = &found.decides;
    holds(said, &["coming there moving + / moving -"]);
    let (files, fault) = (amounts(said, "the control"), amounts(said, "backlash not"));
    assert!((files.0 - fault.0).abs() < 1e-9, "+ is as planned: {said}");
    assert!(((files.1 - fault.1).abs() - REVERSAL_UM).abs() < 0.3, "- is not: {said}");
    let found = left(TWO_TABLES);
    assert!(found.kinds.iter().all(|kind| *kind == "backlash not"));
    let either = ["the table for + acts in both", "the table for - acts in both"];
    holds(&found.words.join("\n"), &either);
    let said = &found.decides;
    let files = amounts(said, "the control");
    let plus = amounts(said, "backlash not (every axis: table of +");
    assert!((files.0 - plus.0).abs() < 1e-9 && (files.1 - plus.1).abs() > 5.0, "{said}");
    // Bit 0 of 3605: neither the table for - nor the reversal at the reference acts.
    let (policy, leaning) = (TWO_TABLES, |row: Row| wavy(row) + row.reversal() * row.mm / 900.0);
    let machine = Machine { controller: "fanuc-30i", policy, error_um: leaning, ..SIEMENS };
    let plus_only = |row: Row| leaning(row) - leaning(Row { is_back: false, ..row });
    assert_eq!(after(&machine, plus_only).kinds, ["backlash not"]);
    assert_eq!(after(&machine, |row| 2.0 * leaning(row)).kinds, ["sign turned"]);
}

/// A turned measurement stands beside what it looks like.
#[test]
fn amounts_are_those_of_the_file_and_its_sign_is_left_open() {
    let twice = after(&SIEMENS, |row| -wavy(row));
    assert_eq!(twice.kinds, ["applied twice", "measurement turned"]);
    let said = &twice.decides;
    holds(said, &["service display", "ENC_COMP", "the other axes at their reference points"]);
    holds(said, &["its sign on the display is not documented", "whether the laser counts in +"]);
    assert!(!said.contains("is -") && !said.contains("is +"), "{said}");
    let turned = after(&SIEMENS, |row| 2.0 * wavy(row));
    assert_eq!(turned.kinds, ["sign turned"]);
    holds(&turned.decides, &["bump of at most 20 µm"]);
    let three = after(&SIEMENS, |row| -2.0 * wavy(row));
    assert_eq!(three.kinds, ["measurement turned", "other factor"]);
    holds(&three.words[0], &["the first measurement has the wrong sign"]);
    for controller in ["fanuc-30i", "fanuc-0i-f", "fanuc-16i", "generic"] {
        let said = after(&Machine { controller, ..SIEMENS }, |row| -wavy(row)).decides;
        holds(&said, &["no display of the correction is known"]);
        assert!(!said.contains("service display"), "{controller}: {said}");
    }
}

#[test]
fn the_place_lies_where_was_measured() {
    // Nodes every 130 mm from the reference pass the end of the travel (900 mm).
    let machine = Machine { spacing_mm: 130.0, ..SIEMENS };
    let said = after(&machine, |row| -wavy(row)).decides;
    let (_, place) = said.split_once("added: ").unwrap();
    let mm: f64 = place.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((0.0..=780.0).contains(&mm), "{said}");
}

#[test]
fn a_shift_of_a_control_that_corrects_in_steps_lies_within_its_uncertainty() {
    let machine = Machine { controller: "fanuc-30i", ..SIEMENS };
    let steps = |row: Row, shift: f64| {
        let nearest = ((row.mm - shift) / 30.0).round() * 30.0;
        let high = HIGH_MM.iter().find(|(axis, _)| axis.starts_with(row.along)).unwrap().1;
        wavy(row.at(nearest.clamp(0.0, high)))
    };
    for shift in [60.0, 90.0, -40.0, -100.0] {
        let found = after(&machine, |row| {
            wavy(row) - steps(row, if row.along == 'x' { shift } else { 0.0 })
        });
        assert_eq!(found.kinds, ["shifted"], "{shift}");
        let (_, fitted) = found.words[0].split_once(" act ").unwrap();
        let (mm, rest) = fitted.split_once(" ± ").unwrap();
        let [mm, u] = [mm, rest.split_once(" mm").unwrap().0].map(|mm| mm.parse::<f64>().unwrap());
        assert!((mm - shift).abs() <= u, "{mm} ± {u}, injected {shift}");
        assert!((10.0..40.0).contains(&u), "half a spacing is not known: {u}");
    }
    // By two points, which moves a term by some micrometres.
    let machine = Machine { spacing_mm: 50.0, error_um: gentle, ..machine };
    let found = after(&machine, |row| {
        let shift = if row.along == 'x' { 100.0 } else { 0.0 };
        gentle(row) - gentle(row.at((row.mm - shift).max(0.0)))
    });
    assert_eq!(found.page["as_forecast"], false);
    assert!(found.kinds.contains(&"shifted".to_string()));
}

#[test]
fn after_an_update_the_old_tables_are_tried() {
    let machine = Machine { policy: PARAMETER, ..SIEMENS };
    let visit = visit(&machine);
    let lost = |row: Row| row.reversal() / 2.0;
    let cross = |row: Row| if row.is_positioning() { 0.0 } else { 1.0 };
    let slope = |row: Row| 0.004 * row.mm * (1.0 - cross(row));
    let residual = |row: Row| 4.0 * (row.mm / 110.0).sin() + slope(row) + lost(row);
    visit.put("residual.csv", table(&machine, 3, residual));
    visit.put("update.toml", job(&machine, "residual.csv", "kit"));
    visit.run("generate update.toml -o new").answers();
    let named = |left: &dyn Fn(Row) -> f64| {
        visit.put("left.csv", table(&machine, 4, left));
        diagnosis(&visit, "update.toml --tables new --after left.csv").kinds.join(", ")
    };
    // A parameter has one value: it does not act beside another one.
    let old_tables = |row: Row| wavy(row) - row.reversal();
    assert_eq!(named(&residual), "old tables active");
    assert_eq!(named(&|row| cross(row) * residual(row)), "old tables active");
    assert_eq!(named(&|row| -old_tables(row)), "old beside new");
    assert_eq!(named(&|row| -cross(row) * old_tables(row)), "old beside new");
    assert_eq!(named(&lost), "backlash not");
    assert!(named(&|row| wavy(row) + residual(row)).starts_with("not active"));
    assert_eq!(named(&|_| 0.0), "");
}

#[test]
fn plain_causes_stand_first_and_what_nothing_explains_is_named_with_its_place() {
    let bump = Row { along: 'x', of: 'x', is_back: false, mm: 450.0 };
    let found = after(&SIEMENS, |row| if row == bump { 5.0 } else { 0.0 });
    assert!(found.page["as_forecast"] == false && found.kinds.is_empty());
    let words = ["\"EXX: +", " µm off the forecast at 450 mm", "\"EYX: as forecast\""];
    holds(&found.page["by_term"].to_string(), &words);
    for seed in 2..8 {
        let found = after(&Machine { seed, ..SIEMENS }, wavy);
        assert_eq!(found.kinds[..2], ["not active", "wrong unit"], "{seed}");
    }
}

#[test]
fn what_a_chord_leaves_between_the_first_targets_is_no_fault() {
    let visit = visit(&Machine { spacing_mm: 180.0, ..SIEMENS });
    let left = |row: Row| {
        let (low, share) = ((row.mm / 180.0).floor() * 180.0, (row.mm / 180.0).fract());
        wavy(row) - (1.0 - share) * wavy(row.at(low)) - share * wavy(row.at(low + 180.0))
    };
    visit.put("after.csv", table(&Machine { spacing_mm: 90.0, ..SIEMENS }, 2, left));
    let left = diagnosis(&visit, "job.toml --tables kit --after after.csv").page;
    assert_eq!(left["as_forecast"], true);
    holds(&left["sigma_from"].to_string(), &["µm between the first targets, where"]);
}

#[test]
fn exchanged_axes_are_said_once() {
    let found = after(&SIEMENS, |row| {
        let swap = |axis| if axis == 'x' { 'y' } else { 'x' };
        let other = Row { along: swap(row.along), of: swap(row.of), ..row };
        wavy(row) - wavy(other.at(row.mm.min(720.0)))
    });
    assert!(found.kinds.contains(&"wrong axis".to_string()));
    let said = found.words.join("\n");
    holds(&said, &["were made for X, Y, Z and act on Y, X, Z"]);
    assert!(!said.contains(",,") && !said.contains("µm um"), "{said}");
}

#[test]
fn a_scale_that_does_not_grow_stays() {
    let visit = Visit::of("start/readings");
    let mut job = visit.read("job.toml")
        + "\n[measurement.step_diagonal.material]\nmaterial_corrected = false\nair_corrected = true\n";
    for (axis, alpha) in [("x", "0.0"), ("y", "11.5e-6"), ("z", "8.0e-6")] {
        job += &format!("{axis} = {{ alpha_per_k = {alpha}, temperature_c = 20.0 }}\n");
    }
    visit.put("job.toml", job).run("generate job.toml -o kit").answers();
    let axes = [("x", 0.0, 100.0), ("y", 0.0, 75.0), ("z", -200.0, 50.0)]
        .map(|(axis, low, step)| (axis, (0..=4).map(|n| low + step * f64::from(n)).collect()));
    let after =
        error_rows("ex_um,ey_um,ez_um,u_ex_um,u_ey_um,u_ez_um", &axes, &[""], |axis, _, mm| {
            let (place, um_per_m) = [(0, 0.0), (1, 11.5), (2, 8.0)]["xyz".find(axis).unwrap()];
            let wave = 0.02 * (mm / 75.0).sin();
            let mut e = [0.02 + wave, -0.03 - wave, 0.01 + wave, 0.1, 0.1, 0.1];
            e[place] = 4.0 * um_per_m * mm / 1000.0 + 10.0 * wave; // 4 K
            e
        });
    visit.put("after.csv", after);
    let found = diagnosis(&visit, "job.toml --tables kit --after after.csv");
    assert!(found.kinds.contains(&"temperature".to_string()));
    let words = ["X does not grow (0e-6 per K)", "K at 11.5e-6 per K", "K at 8.0e-6 per K"];
    holds(&found.words.join("\n"), &words);
}

#[test]
fn a_machine_that_became_warmer_by_one_kelvin_is_named() {
    let visit = Visit::of("paper_004/jobs_link");
    for command in [
        "simulate machine.toml --noise-um 0.3 --seed 11 --without-tables -o readings.csv",
        "simulate machine.toml --noise-um 0.3 --seed 12 --without-tables --errors -o linear.csv",
        "generate job.toml -o kit",
        "simulate machine.toml --noise-um 0.3 --seed 13 --tables kit --scale-um-per-m 11.5 -o after.csv",
        "simulate machine.toml --noise-um 0.3 --seed 14 --tables kit --scale-um-per-m 11.5 --errors -o linear-after.csv",
    ] {
        visit.run(command).answers();
    }
    let found = diagnosis(&visit, "job.toml --tables kit --after after.toml");
    assert_eq!(found.kinds[0], "temperature");
    let kelvin = number(&found.page["causes"][0]["fitted"][0]);
    assert!((kelvin - 1.0).abs() < 0.1, "{kelvin} K, 1 K was injected");
}
