//! What LinuxCNC does with a table, found on the control: the facts that its profile calls executed.

use crate::control::{Cycle, Setup, run};
use crate::machine::stands;

/// Rounding of what is printed, mm, and of single precision.
const PRINTED_MM: f64 = 1.5e-6;

/// To places on both sides and beyond both ends, first upwards, then downwards; one second of rest in all.
const THERE_AND_BACK: &str = "G21 G90 G61 F12000\nG1 X-20 Y-20 Z-20\nG4 P0.2\nG1 X25 Y25 Z25\nG4 P0.2\n\
    G1 X160 Y160 Z160\nG4 P0.2\nG1 X25 Y25 Z25\nG4 P0.2\nG1 X-20 Y-20 Z-20\nG4 P0.2\nG1 X0 Y0 Z0\nM2\n";

/// What was added to each joint at −20 (arrived downwards), 25 and 160 (upwards), 25 and −20 (downwards), µm, and what the
/// operator was told.
fn added(joints: [impl Into<String>; 3], tables: [&str; 3]) -> ([[f64; 5]; 3], String) {
    let file = |(name, text): (&str, &str)| (name.to_string(), text.as_bytes().to_vec());
    let seen = run(&Setup {
        unit: "mm",
        travel: [[-50.0, 200.0]; 3],
        acceleration_mm: 1000.0,
        joints: joints.map(Into::into),
        files: ["x.comp", "y.comp", "z.comp"]
            .into_iter()
            .zip(tables)
            .map(file)
            .collect(),
        hal: String::new(),
        programs: vec![THERE_AND_BACK.to_string()],
    });
    let cycles: &[Cycle] = &seen.cycles[0];
    let places = stands(cycles, 150);
    let of = |joint: usize| {
        let at =
            |place: usize| (places[place].drive[joint] - places[place].command[joint]) * 1000.0;
        [0, 1, 2, 3, 4].map(at)
    };
    assert!(places.len() >= 5, "{places:?}");
    ([0, 1, 2].map(of), seen.messages)
}

fn close(got: [f64; 5], expected: [f64; 5]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < PRINTED_MM * 1000.0;
    assert!(
        got.iter().zip(&expected).all(near),
        "{got:?}, not {expected:?}"
    );
}

/// Type 1 is what is added, type 0 the position reached (nominal + error, so its negative is added), no type means 0; the second
/// column upwards, the third downwards; straight between the rows, the end value
/// outside. What follows the third number is ignored, tabs and CR LF are spaces.
pub(crate) fn types_directions_and_ends() {
    let type_1 = "0 0.010 0.014 ; text\r\n50\t0.020 0.024 7 8\r\n100 -0.030 -0.026\n";
    let type_0 = "0 -0.010 -0.014\n50 49.980 49.976\n100 100.030 100.026\n";
    let (added, messages) = added(
        [
            "COMP_FILE = x.comp\nCOMP_FILE_TYPE = 1",
            "COMP_FILE = y.comp\nCOMP_FILE_TYPE = 0",
            "COMP_FILE = z.comp",
        ],
        [type_1, type_0, type_0],
    );
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
        [
            "",
            "0 0.001 0.002\n100 0.001 0.002\n",
            "-50 0.005 0.005\n0 0.005 0.005\n\n50 0.9 0.9\n",
        ],
    );
    close(added[0], [-10.0, 10.0, 10.0, -10.0, -10.0]);
    close(added[1], [2.0, 1.0, 1.0, 2.0, 2.0]);
    close(added[2], [5.0; 5]);
    assert_eq!(messages, "");
}

/// 256 rows are kept, the others dropped with a message; a row that does not ascend is dropped with a message. A step between a quarter
/// and a half of acceleration × cycle² (here 0.25 to 0.5 µm) is not made while the table stays as it is: the ramp
/// would brake before it begins.
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
