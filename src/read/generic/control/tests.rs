use super::*;
use crate::control::control_state::AxisState;
use crate::control::controller::ControlUnit;
use crate::read::emulate::Emulator;
use crate::read::generic::read;

/// Rows of one block without their number, position in mm and deviation in µm.
fn rows(head: &str, points: &[(f64, f64)]) -> String {
    let mut text = String::new();
    for (index, (position, deviation)) in points.iter().enumerate() {
        let increment = match index {
            0 => String::new(),
            _ => (points[index - 1].1 - deviation).to_string(),
        };
        let correction = -deviation;
        text += &format!("{head},{index},{position},{deviation},{correction},{increment}\n");
    }
    text
}

fn table(rows: &[String]) -> GenericTable {
    let header = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um";
    let text = format!("{header}\n{}", rows.concat());
    read("table.csv", &text).unwrap_or_else(|problems| panic!("{problems}"))
}

fn state() -> ControlState {
    let axis = |name: &str| AxisState {
        name: name.to_string(),
        reference: Millimetres::new(0.0),
        reference_direction: Direction::Plus,
        detection_unit_um: None,
        backlash_um: 0.0,
        bidirectional: false,
        interpolated: false,
        travel: (Millimetres::new(0.0), Millimetres::new(1000.0)),
        ends: (Millimetres::new(0.0), Millimetres::new(1000.0)),
        rest: Millimetres::new(0.0),
    };
    ControlState {
        unit: ControlUnit::Inch, // has no say
        axes: ["X", "Y"].map(axis).to_vec(),
    }
}

fn control(rows: &[String]) -> PairControl {
    super::control(&table(rows), &state()).unwrap_or_else(|why| panic!("{}", why.0))
}

fn at(control: &PairControl, pair: [&str; 2], direction: Direction, mm: f64) -> f64 {
    let response = control.response(pair[0], pair[1], direction);
    let response = response.unwrap_or_else(|why| panic!("{}", why.0));
    response.correction(Millimetres::new(mm)).um()
}

/// In + and in −.
fn both(control: &PairControl, pair: [&str; 2], mm: f64) -> [Correction; 2] {
    Direction::BOTH.map(|direction| Correction::from_um(at(control, pair, direction, mm)))
}

const RAMP: [(f64, f64); 3] = [(-50.0, 4.0), (0.0, 0.0), (50.0, -2.0)];
const FLAT: [(f64, f64); 2] = [(0.0, 1.0), (100.0, 1.0)];

/// Straight between points, ends held; the correction is the opposite of the deviation.
#[test]
fn corrections_are_interpolated_and_held() {
    let control = control(&[rows("EXX,X,X,", &RAMP)]);
    let cases = [
        (-90.0, -4.0),
        (-50.0, -4.0),
        (-25.0, -2.0),
        (0.0, 0.0),
        (25.0, 1.0),
        (50.0, 2.0),
        (80.0, 2.0),
    ];
    for (mm, um) in cases {
        for direction in Direction::BOTH {
            let found = at(&control, ["x", "X"], direction, mm);
            assert!((found - um).abs() < 1e-12, "{mm} mm: {found} µm");
        }
    }
}

/// Block directions, and the corrections in + and − at one place.
#[test]
fn a_direction_acts_only_in_its_own() {
    let plus = || rows("EYX,X,Y,+", &FLAT);
    let minus = || rows("EYX,X,Y,-", &RAMP);
    let cases = [
        (vec![rows("EYX,X,Y,", &FLAT)], [-1.0, -1.0]),
        (vec![plus()], [-1.0, 0.0]),
        (vec![minus()], [0.0, 2.0]),
        (vec![plus(), minus()], [-1.0, 2.0]),
    ];
    for (blocks, expected) in cases {
        let control = control(&blocks);
        let found = both(&control, ["X", "Y"], 50.0);
        assert_eq!(found, expected.map(Correction::from_um), "{blocks:?}");
    }
}

#[test]
fn connected_pairs_are_named_once_and_others_get_nothing() {
    let blocks = [rows("EYX,X,Y,+", &FLAT), rows("EYX,X,Y,-", &FLAT), rows("EXX,X,X,", &RAMP)];
    let control = control(&blocks);
    let pair = |base: &str, output: &str| (base.to_string(), output.to_string());
    assert_eq!(control.connected_axes(), [pair("X", "X"), pair("X", "Y")]);
    for other in [["Y", "X"], ["Y", "Y"], ["Y", "Q"]] {
        assert!(at(&control, other, Direction::Plus, 50.0).abs() <= 0.0, "{other:?}");
    }
    assert!(control.response("Q", "Q", Direction::Plus).is_err());
}

/// Reference direction; correction of an axis to itself in + and −.
#[test]
fn backlash_acts_away_from_the_reference_direction() {
    for (reference, expected) in [(Direction::Plus, [-1.0, -9.0]), (Direction::Minus, [7.0, -1.0])]
    {
        let mut state = state();
        state.axes[0].reference_direction = reference;
        state.axes[0].backlash_um = 8.0;
        let blocks = table(&[rows("EXX,X,X,", &FLAT), rows("EYX,X,Y,", &FLAT)]);
        let control = super::control(&blocks, &state).expect("a table");
        let expected = expected.map(Correction::from_um);
        assert_eq!(both(&control, ["X", "X"], 10.0), expected, "{reference}");
        let unmoved = [Correction::from_um(-1.0); 2];
        assert_eq!(both(&control, ["X", "Y"], 10.0), unmoved, "{reference}");
    }
}

/// What the reader takes, and part of the reason.
#[test]
fn what_a_control_would_do_is_not_guessed() {
    let cases = [
        (vec![rows("EYX,X,Y,", &FLAT), rows("EYX,X,Y,+", &FLAT)], "with and without direction"),
        (vec![rows("EYX,X,Y,-", &FLAT), rows("EYX,X,Y,", &FLAT)], "with and without direction"),
        (vec![rows("EZZ,Z,Z,", &FLAT)], "no axis `Z`"),
        (vec![rows("EZX,X,Z,", &FLAT)], "no axis `Z`"),
    ];
    for (blocks, part) in cases {
        let why = super::control(&table(&blocks), &state()).expect_err(part).0;
        assert!(why.contains(part), "{part}: {why}");
    }
    let mut one = table(&[rows("EXX,X,X,", &RAMP)]);
    one.rows.truncate(1);
    assert!(super::control(&one, &state()).is_err());
}

#[test]
fn an_empty_table_connects_nothing() {
    let control = super::control(&GenericTable::default(), &state()).expect("a table");
    assert!(control.connected_axes().is_empty());
}
