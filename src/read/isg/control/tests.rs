use super::IsgControl;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, Evidence, Fact, IsgFacts, LeverOrigin, TableSign};
use crate::quantity::{Axis, Direction, Millimetres, PerAxis};
use crate::read::emulate::Emulator;
use crate::read::isg::read;

fn fact<T>(value: T) -> Fact<T> {
    Fact { value, evidence: Evidence::Manual, source: "a test".to_string(), consequence: None }
}

fn facts(angle_sign: TableSign) -> IsgFacts {
    IsgFacts {
        error_sign: fact(TableSign::AsError),
        angle_sign: fact(angle_sign),
        lever_origin: fact(LeverOrigin::MachineZero),
        records: fact(2000),
        value_decimals: fact(6),
        angle_decimals: fact(9),
        position_decimals: fact(6),
    }
}

/// The axes 1, 2, 3, resting at 0, 200 and -300 mm.
fn state() -> ControlState {
    let axis = |(name, rest): (&str, f64)| AxisState {
        rest: Millimetres::new(rest),
        ..AxisState::plain(name, [-500.0, 500.0])
    };
    ControlState {
        unit: ControlUnit::Inch, // has no say
        axes: [("1", 0.0), ("2", 200.0), ("3", -300.0)].map(axis).to_vec(),
    }
}

fn control(list: &str, csv: &str) -> IsgControl {
    let list = format!("x 1\ny 2\nz 3\n{list}\nfile[0] a.csv\nfile_format[0] ISG_CSV\n");
    let (tables, _) = read(&[("a.lis", &list), ("a.csv", csv)]).unwrap();
    IsgControl::new(&tables, &facts(TableSign::AsError), &state()).unwrap()
}

fn um(control: &IsgControl, base: &str, output: &str, at: f64) -> f64 {
    let response = control.response(base, output, Direction::Minus).unwrap();
    response.correction(Millimetres::new(at)).um()
}

#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}");
}

#[test]
fn an_error_is_taken_off_straight_between_points_and_held_outside() {
    let own = control("", "X EXX EYX\n0 0.001 0\n100 0.003 -0.004\n");
    for (at, expected) in [(-50.0, -1.0), (0.0, -1.0), (25.0, -1.5), (100.0, -3.0), (400.0, -3.0)] {
        close(um(&own, "1", "1", at), expected);
    }
    close(um(&own, "1", "2", 50.0), 2.0);
    close(um(&own, "2", "1", 50.0), 0.0);
    assert!(own.response("1", "7", Direction::Plus).is_err());
    let pairs = [("1", "1"), ("1", "2")].map(|(a, b)| (a.to_string(), b.to_string()));
    assert_eq!(own.connected_axes(), pairs);
    let turned = control("negate X\nset_to_zero Y", "X EXX EYX\n0 0.001 0\n100 0.003 -0.004\n");
    close(um(&turned, "1", "1", 100.0), 3.0);
    close(um(&turned, "1", "2", 100.0), 0.0);
}

/// By hand, all axes of the tool: ECX 10 urad turns about Z what X carries, so Y 200 mm from zero goes by
/// -10 urad * 200 mm = -2 um in X (e = -ECX y); EBX 10 urad with Z at -300 mm: e_x = EBX z = -3 um; EAX: e_y = -EAX z = +3 um,
/// e_z = EAX y = +2 um. The control adds minus that.
#[test]
fn angles_act_at_the_levers_of_the_axes_behind() {
    let with = |name: &str| control("chain XYZ", &format!("X {name}\n0 0\n100 0.00001\n"));
    close(um(&with("ECX"), "1", "1", 100.0), 2.0);
    close(um(&with("EBX"), "1", "1", 100.0), 3.0);
    close(um(&with("EAX"), "1", "2", 100.0), -3.0);
    close(um(&with("EAX"), "1", "3", 50.0), -1.0);
    // Z is the last axis: nothing swings; behind Y stands Z alone.
    let with = |name: &str, axis: &str| {
        control("chain XYZ", &format!("{axis} {name}\n0 0\n100 0.00001\n"))
    };
    close(um(&with("EBZ", "Z"), "3", "1", 100.0), 0.0);
    close(um(&with("EBY", "Y"), "2", "1", 100.0), 3.0);
    close(um(&with("ECY", "Y"), "2", "1", 100.0), 0.0);
    // In the chain ZYX it is X that the others carry, at rest at 0; Y swings with Z.
    let other = control("chain ZYX", "Z ECZ\n0 0\n100 0.00001\n");
    close(um(&other, "3", "1", 100.0), 2.0);
}

/// What an angle does as the axes behind leave their rest is told of as a rotation, on no line: as in the model.
#[test]
fn an_angle_at_rest_is_told_of_as_a_rotation() {
    let own = control("", "X ECX\n-100 0\n100 0.00002\n"); // 10 urad where X rests
    close(um(&own, "2", "1", 300.0), 0.0);
    let rotation = own.rotation("1", Axis::Z).unwrap();
    close(rotation.correction(Millimetres::new(0.0)).um(), -10.0);
    close(rotation.correction(Millimetres::new(100.0)).um(), -20.0);
    assert!(own.rotation("1", Axis::X).is_none());
    // X at 100 mm, Y 150 mm from its rest: 20 urad · 150 mm in X, against e = -ECX y.
    let at = PerAxis { x: 100.0, y: 350.0, z: 0.0 };
    close(own.swing("1", Some(at)), 3.0);
    close(own.swing("3", Some(at)), 0.0);
    let far = own.swing("1", None);
    assert!(far >= 3.0, "a bound of the whole travel: {far}");
    assert_eq!(own.levers(), Some([Axis::X, Axis::Y, Axis::Z]));
}

/// ISO: Y turned by +C0Y goes to -X, Z turned by +B0Z to +X, Z turned by +A0Z to -Y.
#[test]
fn constants_tilt_their_axis() {
    let own = control("", "C0Y B0Z A0Z\n0.00001 0.00002 0.00003\n");
    close(um(&own, "2", "1", 100.0), 1.0);
    close(um(&own, "3", "1", 100.0), -2.0);
    close(um(&own, "3", "2", 100.0), 3.0);
    close(um(&own, "2", "3", 100.0), 0.0);
}

#[test]
fn angles_beside_a_turned_correction_are_not_emulated() {
    let list = "x 1\ny 2\nz 3\nnegate X\nfile[0] a.csv\nfile_format[0] ISG_CSV\n";
    let (tables, _) = read(&[("a.lis", list), ("a.csv", "X ECX\n0 0\n1 1e-5\n")]).unwrap();
    assert!(IsgControl::new(&tables, &facts(TableSign::AsError), &state()).is_err());
}
