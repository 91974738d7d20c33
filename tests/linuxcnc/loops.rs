//! Known errors → kit → the control started with exactly its files → through the volume along axes and diagonals, both
//! ways → every servo cycle against our emulator, the simulated machine against our forecast.

use crate::control::{CYCLE_S, Cycle, Joint, LETTERS, Run, Setup, run};
use crate::machine::{Machine, stands};
use crate::support::{control, generate, response, um_at};
use nonius::kit::Kit;
use nonius::quantity::axis::Direction;
use nonius::read::emulate::Response;
use std::fmt::Write;

/// What the emulator may differ from the control, µm; the rounding of what is printed comes on top.
const EMULATOR_UM: f64 = 1e-3;
/// What the forecast may differ from the machine, µm, likewise.
const FORECAST_UM: f64 = 2e-3;
/// Quick, so that the test is: a reversal of less than half of it × cycle² (2.5 µm) could be left out (docs/linuxcnc.md §2).
pub(crate) const ACCELERATION_MM: f64 = 5000.0;
/// Longest ramp of a reversal, servo cycles.
const RAMP: usize = 100;

/// What one machine showed.
pub(crate) struct Seen {
    pub(crate) machine: &'static str,
    /// Servo cycles in which a joint moved, all joints together.
    pub(crate) cycles: usize,
    /// Largest difference between the table of the control and the emulator, µm.
    pub(crate) emulator_um: f64,
    /// Largest difference between what is left on the machine and the forecast of a term, µm.
    pub(crate) forecast_um: f64,
    /// Largest positioning error before and after, µm.
    pub(crate) before_um: f64,
    pub(crate) after_um: f64,
}

/// A loop around one machine with tables of `points` points, in a unit of `unit_mm` mm.
pub(crate) fn close(machine: &Machine, points: usize, unit: &str) -> Seen {
    let job = job(machine, points, unit);
    let (inputs, kit) = generate(&job, &machine.error_table(2 * points - 1));
    let unit_mm = if unit == "inch" { 25.4 } else { 1.0 };
    let path = path(machine, 2 * points - 1, unit_mm);
    let seen = start(machine, &kit, "joints.ini", unit, vec![path]);
    assert_eq!(seen.messages, "", "{}", machine.name);
    let control = control(&inputs.profile, &kit);
    let cycles = &seen.cycles[0];
    let printed_um = 0.5e-6 * unit_mm * 1000.0;
    let mut largest = (0, 0.0_f64);
    for joint in 0..3 {
        let name = joint.to_string();
        let ways = [Direction::Plus, Direction::Minus]
            .map(|way| response(control.as_ref(), &name, &name, way));
        let (count, difference) = against_emulator(cycles, joint, &ways, unit_mm);
        ramps_are_short(cycles, joint, unit_mm);
        largest = (largest.0 + count, largest.1.max(difference));
    }
    assert!(
        largest.1 <= EMULATOR_UM + 2.0 * printed_um,
        "{}: {} µm",
        machine.name,
        largest.1
    );
    let [before_um, after_um, forecast_um] = against_forecast(machine, &kit, cycles, unit_mm);
    assert!(
        forecast_um <= FORECAST_UM + 4.0 * printed_um,
        "{}: {forecast_um} µm",
        machine.name
    );
    Seen {
        machine: machine.name,
        cycles: largest.0,
        emulator_um: largest.1,
        forecast_um,
        before_um,
        after_um,
    }
}

/// The job of a machine whose positioning errors are to be compensated.
fn job(machine: &Machine, points: usize, unit: &str) -> String {
    let mut job = format!(
        "schema = 1\n[machine]\nname = \"{}\"\n[measurement]\nerrors = \"errors.csv\"\n\
         active_while_measuring = \"none\"\n[compensation]\ncontroller = \"linuxcnc\"\ncontrol_unit = \"{unit}\"\n\
         backlash = \"two-tables\"\nterms = [\"EXX\", \"EYY\", \"EZZ\"]\n[acceptance]\nmax_deviation_um = 10.0\n",
        machine.name
    );
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let [low, high] = machine.travel[axis];
        let spacing = (high - low) / (points - 1) as f64;
        write!(
            job,
            "[machine.axes.{name}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = 0.0\nreference_direction = \"+\"\n\
             [compensation.axes.{name}]\nspacing_mm = {spacing:?}\n"
        )
        .unwrap();
    }
    job
}

/// The control with exactly the files of the kit that `fragment` names.
fn start(machine: &Machine, kit: &Kit, fragment: &str, unit: &str, programs: Vec<String>) -> Run {
    let unit_mm = if unit == "inch" { 25.4 } else { 1.0 };
    let of = |name: &str| kit.files.iter().find(|file| file.path == name).unwrap();
    let lines = String::from_utf8(of(fragment).bytes.clone()).unwrap();
    let tables = kit.files.iter().filter(|file| file.path.ends_with(".comp"));
    run(&Setup {
        unit,
        travel: machine.travel.map(|ends| ends.map(|end| end / unit_mm)),
        acceleration_mm: ACCELERATION_MM,
        joints: sections(&lines),
        files: tables
            .map(|file| (file.path.clone(), file.bytes.clone()))
            .collect(),
        hal: String::new(),
        programs,
    })
}

/// The lines of the sections of the joints.
pub(crate) fn sections(fragment: &str) -> [String; 3] {
    let section = |joint: usize| -> String {
        let head = format!("[JOINT_{joint}]");
        let from = fragment
            .lines()
            .skip_while(|line| line.trim() != head)
            .skip(1);
        let own = from.take_while(|line| !line.starts_with('['));
        own.map(|line| format!("{line}\n")).collect()
    };
    [0, 1, 2].map(section)
}

/// Along each axis in steps, all together up and down; then the other diagonals without a stop.
pub(crate) fn path(machine: &Machine, places: usize, unit_mm: f64) -> String {
    let at = |part: [f64; 3]| -> String {
        let place = |axis: usize| {
            let [low, high] = machine.travel[axis];
            format!(
                " {}{:.8}",
                LETTERS[axis],
                (low + part[axis] * (high - low)) / unit_mm
            )
        };
        [0, 1, 2].map(place).concat()
    };
    let g20 = if unit_mm > 1.0 { "G20" } else { "G21" };
    let mut program = format!("{g20} G90 G17 G61 G94\nF{}\n", 30000.0 / unit_mm);
    let up = (0..places).map(|n| n as f64 / (places - 1) as f64);
    let down = up.clone().rev().skip(1);
    program += &format!("G0{}\n", at([0.02; 3]));
    program += &format!("G0{}\n", at([0.0; 3]));
    for part in up.chain(down) {
        program += &format!("G1{}\nG4 P0.1\n", at([part; 3]));
    }
    for [x, y, z] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        program += &format!(
            "G0{}\nG1{}\nG1{}\n",
            at([x, y, z]),
            at([1.0 - x, 1.0 - y, 1.0 - z]),
            at([x, y, z])
        );
    }
    program + "M2\n"
}

/// How many cycles the joint moves in, and the largest difference of its table from the emulator, µm.
fn against_emulator(
    cycles: &[Cycle],
    joint: usize,
    ways: &[Response; 2],
    unit_mm: f64,
) -> (usize, f64) {
    let moving = cycles
        .iter()
        .map(|cycle| cycle[joint])
        .filter(|joint| joint.speed != 0.0);
    let difference = |at: Joint| {
        let way = &ways[usize::from(at.speed < 0.0)];
        (at.table * unit_mm * 1000.0 - um_at(way, at.command * unit_mm)).abs()
    };
    moving
        .map(difference)
        .fold((0, 0.0), |(count, largest), of| {
            (count + 1, of.max(largest))
        })
}

/// What is added is what the table says but for the ramp after a reversal, which leaves at most half of
/// acceleration × cycle² (docs/linuxcnc.md §2).
fn ramps_are_short(cycles: &[Cycle], joint: usize, unit_mm: f64) {
    let step_um = 0.5 * ACCELERATION_MM * CYCLE_S * CYCLE_S * 1000.0;
    let mut ramp = 0;
    for cycle in cycles {
        let now = cycle[joint];
        let left_um = (now.drive - now.command - now.table).abs() * unit_mm * 1000.0;
        ramp = if left_um > step_um + 0.1 { ramp + 1 } else { 0 };
        assert!(ramp < RAMP, "{left_um} µm are not made up for at {now:?}");
    }
}

/// The largest positioning error without and with the tables, and the largest difference of the latter from its
/// forecast, µm.
fn against_forecast(machine: &Machine, kit: &Kit, cycles: &[Cycle], unit_mm: f64) -> [f64; 3] {
    let places = stands(cycles, 80);
    let mut all = [0.0_f64; 3];
    for axis in 0..3 {
        let [mut before, mut after] = [0.0_f64; 2];
        for place in &places {
            let at = place.drive[axis] * unit_mm;
            let error = machine.error_um(axis, axis, at, place.upwards[axis]);
            let added = (place.drive[axis] - place.command[axis]) * unit_mm * 1000.0;
            before = before.max(error.abs());
            after = after.max((error + added).abs());
        }
        let term = ["EXX", "EYY", "EZZ"][axis];
        let forecast = kit
            .forecast
            .terms
            .iter()
            .find(|of| of.term.to_string() == term)
            .unwrap();
        let off = (forecast.change.after_um - after).abs();
        println!(
            "{}: {term} {before:.4} → {after:.4} µm, forecast {:.4}",
            machine.name, forecast.change.after_um
        );
        all = [all[0].max(before), all[1].max(after), all[2].max(off)];
    }
    all
}
