//! A real control executes our tables: LinuxCNC, started with the files of a kit (docs/accuracy.md, docs/linuxcnc.md).
#![cfg(target_os = "linux")]
mod control;
mod facts;
mod loops;
mod machine;
mod proof;
mod visit;

use crate::support::{Visit, is_whole};
use loops::{Case, Seen};
use machine::Machine;

const NO_CROSS: [[f64; 3]; 3] = [[0.0; 3]; 3];

const MILL: Machine = Machine {
    name: "mill",
    travel: [[0.0, 400.0], [0.0, 300.0], [-200.0, 0.0]],
    slope: [35.0, -60.0, 80.0],
    wave: [4.0, -3.0, 2.5],
    reversal: [-6.0, 4.0, -3.0],
    bow: NO_CROSS,
    tilt: NO_CROSS,
};

const INCHES: Machine = Machine {
    name: "inch mill",
    travel: [[0.0, 508.0], [-254.0, 0.0], [-127.0, 127.0]],
    wave: [9.0, 2.0, -5.0],
    ..MILL
};

const LARGE: Machine = Machine {
    name: "large mill",
    travel: [[0.0, 900.0], [-360.0, 360.0], [-720.0, 0.0]],
    slope: [-20.0, 12.0, 30.0],
    ..MILL
};

/// Six errors across and three angles out of square.
const BOW: [[f64; 3]; 3] = [[0.0, 6.0, -2.5], [-4.0, 0.0, 3.0], [5.0, -3.5, 0.0]];
const TILT: [[f64; 3]; 3] = [[0.0, 12.0, -8.0], [25.0, 0.0, 5.0], [-15.0, 9.0, 0.0]];

const fn crooked(name: &'static str, machine: Machine) -> Machine {
    Machine { name, bow: BOW, tilt: TILT, ..machine }
}

const CASES: [Case; 6] = [
    case(MILL, "linuxcnc", 11, 21, "mm"),
    case(INCHES, "linuxcnc", 6, 11, "inch"),
    case(LARGE, "linuxcnc", 16, 31, "mm"),
    case(crooked("crooked mill", MILL), "linuxcnc-hal", 21, 41, "mm"),
    case(crooked("crooked inch mill", INCHES), "linuxcnc-hal", 6, 11, "inch"),
    case(crooked("long mill", LONG), "linuxcnc-hal", 256, 21, "mm"),
];

/// Tables of as many points as a `COMP_FILE` takes, in 102 curves: more than there are numbers in a list.
const LONG: Machine = Machine { travel: [[0.0, 1020.0]; 3], slope: [4.0, -6.0, 8.0], ..MILL };

const fn case(
    machine: Machine,
    controller: &'static str,
    points: usize,
    stops: usize,
    unit: &'static str,
) -> Case {
    Case { machine, controller, points, stops, unit }
}

/// The version of the control where all is asked for, which takes minutes.
fn all_of_it() -> Option<String> {
    if !is_whole() {
        let rest = "the facts, the other machines, the HAL files and a whole visit";
        eprintln!("only the short part: NONIUS_SIMULATIONS=all runs {rest}");
        return None;
    }
    control::installed()
}

/// What the profile says of a table was seen on the control.
#[test]
fn the_real_control_does_with_a_table_what_the_profile_says() {
    if all_of_it().is_some() {
        facts::types_directions_and_ends();
        facts::backlash_and_blank_lines();
        facts::rows_order_and_small_steps();
        facts::before_homing_and_the_zero();
        facts::missing_file();
    }
}

/// What the profile says of HAL files, and their sign, were seen on the control.
#[test]
fn the_real_control_does_with_curves_what_the_profile_says() {
    if all_of_it().is_some() {
        facts::curves_of_hal();
        let crooked = &CASES[3];
        let visit = Visit::with(crooked.job(), crooked.error_table()).with_kit();
        proof::signs_are_proved(&visit, &crooked.machine, &["EXX", "EYX"]);
    }
}

#[test]
fn the_real_control_does_what_the_emulator_says() {
    let Some(version) = control::installed() else { return };
    let count = if all_of_it().is_some() { CASES.len() } else { 1 };
    for case in &CASES[..count] {
        let (name, seen) = (case.machine.name, case.close());
        let Seen { cycles, emulator_um, forecast_um, before_um, after_um } = seen;
        println!(
            "{version}, {name}: {cycles} cycles, emulator within {emulator_um:.5} µm, forecast within {forecast_um:.5} µm; {before_um:.3} → {after_um:.3} µm"
        );
        assert!(cycles >= 10_000);
    }
}

#[test]
fn the_real_control_leads_a_whole_visit() {
    if all_of_it().is_some() {
        println!("{}", visit::visit(&MILL));
    }
}
