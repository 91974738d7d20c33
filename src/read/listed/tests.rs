use super::*;
use crate::control::controller::{
    BesideTable, ControlUnit, DeclaredFacts, Dialect, Fact, Size, TableSign, builtin,
};
use crate::quantity::Direction;
use crate::read::emulate::Emulator;

/// Weihong with its end values held and points anywhere.
fn weihong() -> DeclaredFacts {
    match builtin::profile("weihong").unwrap().dialect {
        Dialect::Declared(mut facts) => {
            set(&mut facts.outside, Outside::Hold);
            set(&mut facts.points_beyond_travel, true);
            facts
        }
        other => panic!("{other:?}"),
    }
}

fn set<T>(fact: &mut Fact<T>, value: T) {
    fact.value = value;
}

fn table(points: &[(f64, f64, Option<f64>)]) -> ListedTables {
    let point = |(position, forward, reverse): &(f64, f64, Option<f64>)| Point {
        position: *position,
        forward: *forward,
        reverse: *reverse,
    };
    let points = points.iter().map(point).collect();
    let (base, output) = ("X".to_string(), "X".to_string());
    ListedTables::of(vec![ListedTable { term: None, base, output, points }])
}

/// X from 0 to 1000 mm, its reference at 10 mm, 4 µm in the backlash parameter.
fn state() -> ControlState {
    ControlState {
        unit: ControlUnit::Millimetre,
        axes: vec![AxisState {
            reference: Millimetres::new(10.0),
            backlash_um: 4.0,
            ..AxisState::plain("X", [0.0, 1000.0])
        }],
    }
}

/// What X gets at places while it moves in + and in −.
fn um(facts: &DeclaredFacts, tables: &ListedTables, places: &[f64]) -> Vec<[f64; 2]> {
    let control = control(tables, facts, &state()).unwrap();
    let ways = Direction::BOTH.map(|way| control.response("x", "X", way).unwrap());
    let at = |place: &f64| {
        ways.each_ref()
            .map(|way| (way.correction(Millimetres::new(*place)).um() * 1e6).round() / 1e6)
    };
    places.iter().map(at).collect()
}

/// NK200 manual, p. 65: 0.03 mm of backlash alone; e = reached − commanded, so the control adds −0.03 mm.
#[test]
fn the_error_of_a_direction_is_taken_off_and_the_parameter_does_nothing() {
    let tables = table(&[(0.0, 0.0, Some(0.03)), (1000.0, 0.0, Some(0.03))]);
    let mut facts = weihong();
    assert_eq!(um(&facts, &tables, &[-5.0, 500.0]), [[0.0, -30.0]; 2]);
    set(&mut facts.own_sign, TableSign::AsCorrection);
    assert_eq!(um(&facts, &tables, &[500.0]), [[0.0, 30.0]]);
    set(&mut facts.backlash, BesideTable::Adds);
    assert_eq!(um(&facts, &tables, &[500.0]), [[0.0, 26.0]]);
}

#[test]
fn positions_and_increments_say_the_same_as_amounts() {
    let mut facts = weihong();
    set(&mut facts.backlash, BesideTable::Adds);
    let expected = [[2.0, -2.0], [0.0, -4.0], [-5.0, -9.0], [-10.0, -14.0]];
    let places = [0.0, 10.0, 15.0, 20.0];
    let amounts = table(&[(0.0, -0.002, None), (10.0, 0.0, None), (20.0, 0.01, None)]);
    assert_eq!(um(&facts, &amounts, &places), expected);
    set(&mut facts.value_form, ValueForm::Position);
    let reached = table(&[(0.0, -0.002, None), (10.0, 10.0, None), (20.0, 20.01, None)]);
    assert_eq!(um(&facts, &reached, &places), expected);
    // Counts of 0.5 µm, the change from the point before, zero at the reference.
    set(&mut facts.value_form, ValueForm::Increment);
    set(&mut facts.value_size, Size::fixed(0.5));
    let changes = table(&[(0.0, 0.0, None), (10.0, 4.0, None), (20.0, 20.0, None)]);
    assert_eq!(um(&facts, &changes, &places), expected);
}

/// Counts of half a detection unit: without one there is no control.
#[test]
fn a_count_has_the_size_of_its_axis() {
    let mut facts = weihong();
    set(&mut facts.value_size, Size { um: 0.5, is_of_axis: true });
    let held = table(&[(0.0, 4.0, None), (10.0, 0.0, None), (20.0, -20.0, None)]);
    let mut state = state();
    assert!(control(&held, &facts, &state).is_err());
    state.axes[0].detection_unit_um = Some(0.1);
    let moved = control(&held, &facts, &state).unwrap();
    let moved = moved.response("X", "X", Direction::Plus).unwrap();
    let um = [0.0, 20.0].map(|at| moved.correction(Millimetres::new(at)).um());
    // The values are errors: 20 counts of 0.05 µm too little, so 1 µm is added.
    assert!((um[0] + 0.2).abs() < 1e-9 && (um[1] - 1.0).abs() < 1e-9, "{um:?}");
}

/// No axis leaves its travel: the last value of a table that ends there has no step behind it.
#[test]
fn a_table_that_covers_the_travel_keeps_its_last_value_where_nothing_is_added_outside() {
    let mut facts = weihong();
    let tables = table(&[(0.0, 0.002, Some(0.004)), (1000.0, -0.006, Some(0.0))]);
    let both = |facts: &DeclaredFacts| {
        let control = control(&tables, facts, &state()).unwrap();
        Direction::BOTH.map(|way| control.response("X", "X", way).unwrap())
    };
    let held = both(&facts);
    set(&mut facts.outside, Outside::Zero);
    assert_eq!(both(&facts), held);
    let ends = [[-2.0, -4.0], [2.0, -2.0], [6.0, 0.0]];
    assert_eq!(um(&facts, &tables, &[0.0, 500.0, 1000.0]), ends);
}

/// The reference counts as travel; a position is rounded to 0.001 mm.
#[test]
fn a_table_that_ends_inside_the_travel_is_not_evaluated_where_outside_is_not_known() {
    let mut facts = weihong();
    set(&mut facts.outside, Outside::Unknown);
    let of = |first, last| table(&[(last, 0.0, Some(0.0)), (first, 0.001, Some(0.0))]);
    for (first, last) in [(0.0, 1000.0), (-5.0, 1000.1), (0.001, 999.999)] {
        assert!(control(&of(first, last), &facts, &state()).is_ok());
    }
    for (first, last) in [(0.0, 999.9), (0.1, 1000.0), (400.0, 600.0)] {
        let why = control(&of(first, last), &facts, &state()).unwrap_err().0;
        let covered = format!("the table of X covers {first:.3} mm to {last:.3} mm");
        assert!(why.starts_with(&covered), "{why}");
        assert!(why.contains("0.000 mm to 1000.000 mm"), "{why}");
        assert!(why.ends_with("outside a table is not known"), "{why}");
    }
}

/// Inside the travel a correction does not jump: of two columns both have to end with nothing.
#[test]
fn a_table_that_ends_inside_the_travel_ends_with_nothing_where_nothing_is_added_outside() {
    let mut facts = weihong();
    set(&mut facts.outside, Outside::Zero);
    let of = |forward, reverse| table(&[(0.0, 0.002, Some(0.0)), (500.0, forward, Some(reverse))]);
    assert!(control(&of(0.0, 0.0), &facts, &state()).is_ok());
    for (forward, reverse) in [(0.001, 0.0), (0.0, -0.001)] {
        let why = control(&of(forward, reverse), &facts, &state()).unwrap_err();
        assert!(why.0.contains("would jump at its end"), "{}", why.0);
    }
}

#[test]
fn a_column_of_zeros_stands_for_the_other_where_the_profile_says_so() {
    let mut facts = weihong();
    let zeros = table(&[(0.0, 0.002, Some(0.0)), (1000.0, 0.002, Some(0.0))]);
    let own = table(&[(0.0, 0.002, Some(0.0)), (1000.0, 0.002, Some(0.001))]);
    assert_eq!(um(&facts, &zeros, &[500.0]), [[-2.0, 0.0]]);
    set(&mut facts.zero_reverse_is_forward, true);
    assert_eq!(um(&facts, &zeros, &[500.0]), [[-2.0, -2.0]]);
    assert_eq!(um(&facts, &own, &[1000.0]), [[-2.0, -1.0]]);
}

#[test]
fn points_beyond_the_travel_are_refused_where_the_control_does_not_use_them() {
    let mut facts = weihong();
    set(&mut facts.points_beyond_travel, false);
    let of = |first, last| table(&[(first, 0.0, Some(0.0)), (last, 0.001, Some(0.0))]);
    for (first, last) in [(0.0, 1000.0), (-0.001, 1000.001), (1.0, 999.0)] {
        assert!(control(&of(first, last), &facts, &state()).is_ok());
    }
    // The reference lies outside the travel: a table that holds it is beyond.
    let mut outside = state();
    outside.axes[0].ends.0 = Millimetres::new(50.0);
    assert!(control(&of(0.0, 1000.0), &facts, &outside).is_err());
    for (first, last) in [(-0.1, 1000.0), (0.0, 1000.1)] {
        let why = control(&of(first, last), &facts, &state()).unwrap_err();
        assert!(why.0.contains("points beyond the travel"), "{}", why.0);
    }
}
