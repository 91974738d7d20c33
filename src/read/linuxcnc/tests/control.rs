//! The figures that a running LinuxCNC 2.9.0~pre1 showed (pins of a joint, six decimals of a millimetre).
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, Dialect, builtin};
use crate::control::table::ListedTables;
use crate::quantity::{Direction, Millimetres};
use crate::read::emulate::Emulator;
use crate::read::linuxcnc::read;
use crate::read::listed::PairControl;

fn control(comp: &str, kind: &str, unit: ControlUnit, backlash_um: f64) -> PairControl {
    let Dialect::Linuxcnc(facts) = builtin::profile("linuxcnc").unwrap().dialect else {
        unreachable!("it is LinuxCNC");
    };
    let ini = format!("[JOINT_0]\nCOMP_FILE = x.comp\nCOMP_FILE_TYPE = {kind}\n");
    let texts = [("m.ini", ini.as_str()), ("x.comp", comp)];
    let tables = match comp {
        "" => ListedTables::default(),
        _ => read(&texts, &facts).unwrap().tables,
    };
    let axes = vec![AxisState { backlash_um, ..AxisState::plain("0", [0.0, 1000.0]) }];
    let state = ControlState { unit, axes };
    crate::read::listed::control(&tables, &facts, &state).unwrap()
}

fn added_mm(control: &PairControl, direction: Direction, at: f64) -> f64 {
    let response = control.response("0", "0", direction).unwrap();
    response.correction(Millimetres::new(at)).um() / 1000.0
}

const TYPE_1: &str =
    "-100 -0.01 -0.006\n0 -0.002 0.003\n50 0.02 0.029\n200 -0.03 -0.018\n300 -0.005 0.001\n";

/// Rows at equal distances are held as one table; both forms are the same straight lines.
#[test]
fn equal_and_other_distances_of_rows_give_the_same_lines() {
    let equal = control("0 0.1 0\n50 0.3 0\n100 0.2 0\n", "1", ControlUnit::Millimetre, 0.0);
    let other =
        control("0 0.1 0\n20 0.18 0\n50 0.3 0\n100 0.2 0\n", "1", ControlUnit::Millimetre, 0.0);
    for step in -10..=60_i32 {
        let at = 2.5 * f64::from(step);
        let [a, b] = [&equal, &other].map(|control| added_mm(control, Direction::Plus, at));
        assert!((a - b).abs() < 1e-8, "{at}: {a}, {b}");
    }
    let tables =
        |control: &PairControl| control.response("0", "0", Direction::Plus).unwrap().tables().len();
    assert_eq!((tables(&equal), tables(&other)), (1, 3));
}

#[test]
fn a_single_row_acts_everywhere() {
    let control = control("0 0.010 -0.010\n", "1", ControlUnit::Millimetre, 0.0);
    for at in [-50.0, 0.0, 100.0] {
        assert!((added_mm(&control, Direction::Plus, at) - 0.010).abs() < 1e-9);
        assert!((added_mm(&control, Direction::Minus, at) + 0.010).abs() < 1e-9);
    }
}

/// BACKLASH 0.020 was seen to add +0.010 moving up and -0.010 moving down: 20 µm apart, which homing upwards
/// counts from 0. Beside a table it adds nothing.
#[test]
fn backlash_acts_without_a_table_only() {
    let alone = control("", "1", ControlUnit::Millimetre, 20.0);
    let beside = control(TYPE_1, "1", ControlUnit::Millimetre, 20.0);
    let apart = |control| {
        let [up, down] = Direction::BOTH.map(|way| added_mm(control, way, 50.0));
        up - down
    };
    assert!((apart(&alone) - 0.020).abs() < 1e-12);
    assert!((apart(&beside) + 0.009).abs() < 1e-8);
}

#[test]
fn a_trim_is_a_c_float() {
    let control = control("0 0 0\n100 0.010 0\n", "1", ControlUnit::Millimetre, 0.0);
    let added = added_mm(&control, Direction::Plus, 200.0);
    assert!((added - 0.009_999_999_776).abs() < 1e-12, "{added:.15}");
}

#[test]
fn inches_are_lengths_of_both_columns() {
    let control = control("0 0 0\n10 0.001 0\n", "1", ControlUnit::Inch, 0.0);
    assert!((added_mm(&control, Direction::Plus, 127.0) - 0.0127).abs() < 1e-8);
    assert!((added_mm(&control, Direction::Plus, 254.0) - 0.0254).abs() < 1e-8);
}
