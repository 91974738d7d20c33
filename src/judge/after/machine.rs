//! Whether a second job describes the machine of the first one.

use crate::inputs::job::{Job, MachineAxis};
use crate::quantity::axis::Axis;
use crate::text::problem::Problems;

/// Refuses a second job of another machine: serial number, travel, reference point and direction
/// of the reference return have to be those of the first, each shown at both places.
pub fn ensure_same_machine(first: &Job, second: &Job) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let (own, other) = (&first.machine.serial, &second.machine.serial);
    if let (Some(own), Some(other)) = (own, other)
        && own != other
    {
        let said = ["the serial number", own, other];
        differs(first, second, "machine.serial", said, &mut problems);
    }
    for axis in Axis::ALL {
        if let (Some(own), Some(other)) = (first.machine.axes[axis], second.machine.axes[axis]) {
            compare_axis(first, second, axis, [own, other], &mut problems);
        }
    }
    problems.or_ok(())
}

fn compare_axis(
    first: &Job,
    second: &Job,
    axis: Axis,
    [own, other]: [MachineAxis; 2],
    problems: &mut Problems,
) {
    let travel = |a: MachineAxis| format!("{} … {} mm", a.low.mm(), a.high.mm());
    let reference = |a: MachineAxis| format!("{} mm", a.reference.mm());
    let homing = |a: MachineAxis| a.homing().symbol().to_string();
    let asked: [(&str, &str, [String; 2]); 3] = [
        ("travel_mm", "the travel", [own, other].map(travel)),
        (
            "reference_mm",
            "the reference point",
            [own, other].map(reference),
        ),
        (
            "reference_direction",
            "the direction of the reference return",
            [own, other].map(homing),
        ),
    ];
    for (key, what, [here, there]) in asked {
        if here != there {
            let key = format!("machine.axes.{}.{key}", axis.key());
            let what = format!("{what} of axis {axis}");
            differs(first, second, &key, [&what, &here, &there], problems);
        }
    }
}

/// One problem at each of the two places.
fn differs(
    first: &Job,
    second: &Job,
    key: &str,
    [what, here, there]: [&str; 3],
    problems: &mut Problems,
) {
    problems.push(
        second
            .problem_at(
                key,
                format!("the measurement afterwards is of another machine: {what} is {there}, as found {here}"),
            )
            .help("both jobs describe the same machine in the same coordinates"),
    );
    problems.push(first.problem_at(key, format!("as found, {what} is {here}")));
}
