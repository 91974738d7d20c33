//! What LinuxCNC does with a table, found on the control: the facts that its profile calls executed.

use super::control::{Joint, Setup, is_refused, run};
use super::machine::stands;

/// Rounding of what is printed, mm, and of single precision.
const PRINTED_MM: f64 = 1.5e-6;

/// To places on both sides and beyond both ends, first upwards, then downwards; one second of rest in all.
const THERE_AND_BACK: &str = "G21 G90 G61 F12000\nG1 X-20 Y-20 Z-20\nG4 P0.2\nG1 X25 Y25 Z25\nG4 P0.2\n\
    G1 X160 Y160 Z160\nG4 P0.2\nG1 X25 Y25 Z25\nG4 P0.2\nG1 X-20 Y-20 Z-20\nG4 P0.2\nG1 X0 Y0 Z0\nM2\n";

fn bare(program: &str) -> Setup<'static> {
    Setup {
        unit: "mm",
        travel: [[-50.0, 200.0]; 3],
        acceleration_mm: 1000.0,
        programs: vec![program.to_string()],
        ..Setup::default()
    }
}

fn file((name, text): (&str, &str)) -> (String, Vec<u8>) {
    (name.to_string(), text.as_bytes().to_vec())
}

/// What was added to each joint at −20 (arrived downwards), 25 and 160 (upwards), 25 and −20 (downwards), µm, and what the
/// operator was told.
fn added(joints: [impl Into<String>; 3], tables: [&str; 3]) -> ([[f64; 5]; 3], String) {
    let files = ["x.comp", "y.comp", "z.comp"].into_iter().zip(tables);
    let seen = run(&Setup {
        joints: joints.map(Into::into),
        files: files.map(file).collect(),
        ..bare(THERE_AND_BACK)
    });
    let places = stands(&seen.cycles[0]);
    let commands: Vec<f64> = places.iter().map(|place| place.command[0].round()).collect();
    assert!(commands.starts_with(&[-20.0, 25.0, 160.0, 25.0, -20.0]), "{places:?}");
    let added = |joint: usize| {
        [0, 1, 2, 3, 4].map(|at: usize| (places[at].drive[joint] - places[at].command[joint]) * 1e3)
    };
    ([0, 1, 2].map(added), seen.messages)
}

fn close(got: [f64; 5], expected: [f64; 5]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < PRINTED_MM * 1000.0;
    assert!(got.iter().zip(&expected).all(near), "{got:?}, not {expected:?}");
}

/// Type 1 is what is added, type 0 (or none) the position reached (nominal + error); the second column upwards, the third
/// downwards; straight between the rows, the end value outside. What follows is ignored, tabs and CR LF are spaces.
pub(crate) fn types_directions_and_ends() {
    let type_1 = "0 0.010 0.014 ; text\r\n50\t0.020 0.024 7 8\r\n100 -0.030 -0.026\n";
    let type_0 = "0 -0.010 -0.014\n50 49.980 49.976\n100 100.030 100.026\n";
    let joints = [
        "COMP_FILE = x.comp\nCOMP_FILE_TYPE = 1",
        "COMP_FILE = y.comp\nCOMP_FILE_TYPE = 0",
        "COMP_FILE = z.comp",
    ];
    let (added, messages) = added(joints, [type_1, type_0, type_0]);
    for joint in added {
        close(joint, [14.0, 15.0, -30.0, 19.0, 14.0]);
    }
    assert_eq!(messages, "");
}

/// `BACKLASH` alone adds half of it with the sign of the motion, beside a table it is ignored; a blank line ends the reading
/// without a word.
pub(crate) fn backlash_and_blank_lines() {
    let (added, messages) = added(
        [
            "BACKLASH = 0.020",
            "BACKLASH = 0.020\nCOMP_FILE = y.comp\nCOMP_FILE_TYPE = 1",
            "COMP_FILE = z.comp\nCOMP_FILE_TYPE = 1",
        ],
        ["", "0 0.001 0.002\n100 0.001 0.002\n", "-50 0.005 0.005\n0 0.005 0.005\n\n50 0.9 0.9\n"],
    );
    close(added[0], [-10.0, 10.0, 10.0, -10.0, -10.0]);
    close(added[1], [2.0, 1.0, 1.0, 2.0, 2.0]);
    close(added[2], [5.0; 5]);
    assert_eq!(messages, "");
}

/// Rows after the 256th, and one that does not ascend, are dropped with a message. A step between a quarter and a half of
/// acceleration × cycle² (here 0.25 to 0.5 µm) is not made while the table stays: the ramp would brake before it begins.
pub(crate) fn rows_order_and_small_steps() {
    let rows: String = (0..257)
        .map(|n| format!("{} {v} {v}\n", f64::from(n) * 0.5, v = f64::from(n) * 1e-4))
        .collect();
    let (added, messages) = added(
        ["x", "y", "z"].map(|name| format!("COMP_FILE = {name}.comp\nCOMP_FILE_TYPE = 1")),
        [
            "0 0.0004 0.0004\n100 0.0004 0.0004\n",
            &rows,
            "0 0.002 0.002\n100 0.002 0.002\n50 0.9 0.9\n150 0.002 0.002\n",
        ],
    );
    close(added[0], [0.0; 5]);
    close(added[1], [0.0, 5.0, 25.5, 5.0, 0.0]);
    close(added[2], [2.0; 5]);
    let told = |what: &str| assert!(messages.contains(what), "{messages}");
    told("joint 1: too many compensation entries");
    told("joint 2: compensation values must increase");
    assert!(!messages.contains("joint 0"), "{messages}");
}

pub(crate) fn missing_file() {
    let joints = ["COMP_FILE = none.comp", "", ""].map(Into::into);
    is_refused(&Setup { joints, ..bare(THERE_AND_BACK) }, "can't open compensation file");
}

/// A switch of joint 0 that its encoder closes, 30 mm from where the power came on.
const SWITCH: &str = "loadrt comp count=1\naddf comp.0 servo-thread\nsetp comp.0.in0 30\nsetp comp.0.hyst 0\n\
    net nonius-0-encoder => comp.0.in1\nnet closed comp.0.out => joint.0.home-sw-in\n";

/// A curve that moves joint 2 by 0.1 mm for 50 mm of joint 0.
const CURVE: &str = "loadrt lincurve count=1 personality=2\nloadrt sum2 count=2\n\
    addf lincurve.0 servo-thread\naddf sum2.0 servo-thread\naddf sum2.1 servo-thread\n\
    net nonius-0-position joint.0.pos-cmd => lincurve.0.in\nnet correction lincurve.0.out => sum2.0.in1 sum2.1.in1\n\
    net command joint.2.motor-pos-cmd => sum2.0.in0\nnet nonius-2-drive sum2.0.out\n\
    net nonius-2-encoder sum2.1.in0\nnet feedback sum2.1.out => joint.2.motor-pos-fb\nsetp sum2.1.gain1 -1\n\
    setp lincurve.0.x-val-00 -50\nsetp lincurve.0.y-val-00 -0.1\nsetp lincurve.0.x-val-01 100\nsetp lincurve.0.y-val-01 0.2\n";

/// Tables and curves act before homing, on a position that is not the machine's. The zero of a joint is afterwards off
/// by what acted when it was homed: at a switch that is the value of the table there.
pub(crate) fn before_homing_and_the_zero() {
    let comp = "-50 -0.1 -0.1\n100 0.2 0.2\n";
    let files = [("x.comp", comp), ("y.comp", comp), ("curve.hal", CURVE)];
    let seen = run(&Setup {
        joints: [
            "COMP_FILE = x.comp\nCOMP_FILE_TYPE = 1\nHOME_OFFSET = 50\nHOME_SEARCH_VEL = 20\nHOME_LATCH_VEL = 0.2",
            "COMP_FILE = y.comp\nCOMP_FILE_TYPE = 1",
            "",
        ]
        .map(Into::into),
        files: files.map(file).to_vec(),
        hal: SWITCH.to_string(),
        jog: Some(25.0),
        ..bare("G21 G90 G61 F5000\nG1 X-10 Y-10 Z-10\nG1 X0 Y0 Z0\nG4 P0.2\nM2\n")
    });
    assert_eq!(seen.messages, "");
    let motor_um = |joint: &Joint| (joint.drive + joint.offset) * 1000.0;
    let [jogged, zero] = [&seen.jog, &seen.cycles[0]].map(|cycles| cycles[cycles.len() - 1]);
    for (joint, at) in jogged.iter().zip(&zero) {
        assert!((joint.command - 25.0).abs() < PRINTED_MM && at.command.abs() < PRINTED_MM);
    }
    // 25 mm after power-on each gets 0.050 mm, and was homed there or, joint 0, at the switch at 30 mm.
    let near = |got: f64, expected: f64, within: f64| {
        assert!((got - expected).abs() < within, "{got} µm, not {expected}");
    };
    let rounding = 2.0 * PRINTED_MM * 1000.0;
    for joint in &jogged {
        near(motor_um(joint), 25_050.0, rounding);
    }
    // The switch goes 0.2 µm in one servo cycle at HOME_LATCH_VEL, and is seen two cycles late.
    near(motor_um(&zero[0]), 30_000.0 - 50_000.0 - 100.0, 2.0 * 0.2);
    for joint in &zero[1..] {
        near(motor_um(joint), 25_050.0 - 50.0, rounding);
    }
}

/// A list of 64 numbers loads, curve 64 takes the first of them; a longer list does not load, nor a component that is loaded
/// already. As many curves as the memory of HAL does not hold keep the control from starting.
pub(crate) fn curves_of_hal() {
    let load = |count: usize, numbers: usize| {
        let list = vec!["16"; numbers].join(",");
        format!("loadrt lincurve count={count} personality={list}\n")
    };
    let with = |hal: String| Setup { hal, ..bare("G21 G90 F5000\nG1 X1\nM2\n") };
    let last = "setp lincurve.69.y-val-15 1\n";
    run(&with(load(70, 64) + last));
    for (hal, told) in [
        (load(65, 65), "insmod for lincurve failed"),
        (load(2, 2) + &load(2, 2), "lincurve: already exists"),
        (load(260, 64), "insufficient memory"),
    ] {
        is_refused(&with(hal), told);
    }
}
