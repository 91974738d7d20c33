//! A real control executes our tables: LinuxCNC, started with the files of a kit (docs/accuracy.md, docs/linuxcnc.md).
#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::float_cmp,
    reason = "a test may stop at what it did not expect, and says what it saw or skips; a joint at rest has speed 0"
)]

#[path = "linuxcnc/control.rs"]
mod control;
#[path = "linuxcnc/facts.rs"]
mod facts;
#[path = "linuxcnc/loops.rs"]
mod loops;
#[path = "linuxcnc/machine.rs"]
mod machine;
mod support;
#[path = "linuxcnc/visit.rs"]
mod visit;

use machine::Machine;

/// What the profile says of a table was seen on the control.
#[test]
fn what_the_control_does_with_a_table() {
    if control::installed().is_some() {
        facts::types_directions_and_ends();
        facts::backlash_and_blank_lines();
        facts::rows_order_and_small_steps();
    }
}

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

/// Whether all is asked for, which takes minutes: the other machines and the whole visit.
fn all_is_asked_for() -> bool {
    let all = std::env::var("NONIUS_SIMULATIONS").is_ok_and(|value| value == "all");
    if !all {
        eprintln!(
            "only the short part: NONIUS_SIMULATIONS=all runs the other machines and a whole visit"
        );
    }
    all
}

/// Known errors → kit → control → every servo cycle and the machine.
#[test]
fn the_control_does_what_the_emulator_says() {
    let Some(version) = control::installed() else {
        return;
    };
    let inches = Machine {
        name: "inch mill",
        travel: [[0.0, 508.0], [-254.0, 0.0], [-127.0, 127.0]],
        wave: [9.0, 2.0, -5.0],
        ..MILL
    };
    let large = Machine {
        name: "large mill",
        travel: [[0.0, 900.0], [-360.0, 360.0], [-720.0, 0.0]],
        slope: [-20.0, 12.0, 30.0],
        ..MILL
    };
    let machines = [(MILL, 11, "mm"), (inches, 6, "inch"), (large, 16, "mm")];
    let count = if all_is_asked_for() { 3 } else { 1 };
    for (machine, points, unit) in machines.into_iter().take(count) {
        let seen = loops::close(&machine, points, unit);
        println!(
            "{version}, {}: {} cycles, emulator within {:.5} µm, forecast within {:.5} µm; {:.3} → {:.3} µm",
            seen.machine,
            seen.cycles,
            seen.emulator_um,
            seen.forecast_um,
            seen.before_um,
            seen.after_um
        );
        assert!(seen.cycles >= 10_000);
    }
}

/// Measured, compensated and measured again, all on the control.
#[test]
fn a_whole_visit_passes() {
    if all_is_asked_for() && control::installed().is_some() {
        println!("{}", visit::visit(&MILL));
    }
}
