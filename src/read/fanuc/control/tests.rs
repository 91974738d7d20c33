//! Files in, corrections out: the examples of the manuals and the semantics one by one.

mod refusals;

use super::*;
use crate::control::control_state::AxisState;
use crate::control::controller::{ControlUnit, IntervalForm, StraightnessForm, TableSign};
use crate::quantity::{Deviation, Millimetres};
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::fanuc::read;
use crate::read::fanuc::tests::{facts_16i, facts_30i};
use Direction::{Minus, Plus};

/// Pitch example of B-63980EN/01 p. 100, one number for each section from 33 to 49.
const S1: [i32; 17] = [2, 1, 1, -2, 0, -1, 0, -1, 2, 1, 0, -1, -1, -2, 0, 1, 2];
/// The two tables of the constructed bidirectional example.
const PLUS: [i32; 8] = [-1, 1, 1, 2, 1, 0, -1, -2];
const MINUS: [i32; 8] = [-1, 0, 2, 1, 1, 1, -1, -2];

fn axis_state(name: &str) -> AxisState {
    AxisState { detection_unit_um: Some(1.0), ..AxisState::plain(name, [0.0, 1000.0]) }
}

fn state() -> ControlState {
    ControlState { unit: ControlUnit::Millimetre, axes: vec![axis_state("1"), axis_state("2")] }
}

fn load(blocks: &[String], facts: &FanucFacts, state: &ControlState) -> Emulated<PairControl> {
    let text = format!("%\n\r\r{}\n\r\r%\n\r\r", blocks.join("\n\r\r"));
    let memory = read("CNC.TXT", &text, facts).expect("a good file");
    super::control(&memory, facts, state)
}

fn control(blocks: &[String]) -> PairControl {
    load(blocks, &facts_30i(), &state()).expect("a control")
}

/// 3620 to 3624 of axis 1 with magnification 1.
fn grid(numbers: [u32; 3], interval: &str) -> Vec<String> {
    let [reference, first, last] = numbers;
    vec![
        format!("N03620Q1A1P{reference}"),
        format!("N03621Q1A1P{first}"),
        format!("N03622Q1A1P{last}"),
        "N03623Q1A1P1".to_string(),
        format!("N03624Q1A1P{interval}"),
    ]
}

fn points(first: u32, values: &[i32]) -> Vec<String> {
    let number = |(index, value)| format!("N{:05}Q0P{value}", 10000 + first + index);
    (0..).zip(values).map(number).collect()
}

fn s1() -> Vec<String> {
    [grid([40, 33, 49], "50.0"), points(33, &S1)].concat()
}

fn bidirectional() -> Vec<String> {
    let mut blocks = [grid([23, 20, 27], "10.0"), points(20, &PLUS), points(30, &MINUS)].concat();
    blocks.extend(["N03605Q1A1P00000001", "N03626Q1A1P30", "N03627Q1A1P-4"].map(String::from));
    blocks
}

/// Four-point set 1: axis 1 moves, axis 2 is shifted, without pitch data.
fn four_point() -> Vec<String> {
    let mut blocks = replaced(&grid([60, 0, 127], "10.0"), "N03623", "N03623Q1A1P0");
    blocks.extend(["N05711Q1P1", "N05721Q1P2"].map(String::from));
    for (number, value) in (5731..).zip([0, 60, 61, 127]).chain((5761..).zip([-5, 0, 0, 11])) {
        blocks.push(format!("N{number:05}Q1P{value}"));
    }
    blocks
}

fn facts_four_point() -> FanucFacts {
    let legacy = facts_16i();
    FanucFacts {
        straightness_form: legacy.straightness_form,
        straightness_sets: legacy.straightness_sets,
        ..facts_30i()
    }
}

/// Per-point set 2: axis 1 moves, axis 2 is shifted, magnification 2.
fn per_point() -> Vec<String> {
    let mut blocks = replaced(&grid([23, 20, 27], "10.0"), "N03623", "N03623Q1A1P0");
    let set = ["N05712Q1P1", "N05722Q1P2", "N13382Q1P2", "N13392Q1P6128"];
    blocks.extend(set.map(String::from));
    blocks.extend(points(6128, &PLUS));
    blocks
}

/// The blocks with the one that begins with `start` replaced; nothing leaves it out.
fn replaced(blocks: &[String], start: &str, by: &str) -> Vec<String> {
    assert!(blocks.iter().any(|block| block.starts_with(start)), "no block {start}");
    let swap = |block: &String| {
        if block.starts_with(start) { by.to_string() } else { block.clone() }
    };
    blocks.iter().map(swap).filter(|block| !block.is_empty()).collect()
}

fn at(control: &PairControl, pair: (&str, &str), direction: Direction, mm: f64) -> f64 {
    let response = control.response(pair.0, pair.1, direction).expect("a response");
    response.correction(Millimetres::new(mm)).um()
}

fn pitch(control: &PairControl, direction: Direction, mm: f64) -> f64 {
    at(control, ("1", "1"), direction, mm)
}

fn close(found: f64, expected: f64, what: impl std::fmt::Debug) {
    assert!((found - expected).abs() < 1e-9, "{what:?}: {found}, expected {expected}");
}

/// B-63980EN/01 p. 100: sums at all nodes, steps in the middle of the sections, held ends.
#[test]
fn manual_example_in_step_form() {
    let control = control(&s1());
    let nodes = [0, 2, 3, 4, 2, 2, 1, 1, 0, 2, 3, 3, 2, 1, -1, -1, 0, 2].map(f64::from);
    for (index, expected) in (0..).zip(nodes) {
        let x = -400.0 + 50.0 * f64::from(index);
        close(pitch(&control, Plus, x), expected, x);
        close(pitch(&control, Minus, x), expected, x);
    }
    let between =
        [(24.0, 0.0), (25.0, 2.0), (374.0, -1.0), (375.0, 0.0), (424.0, 0.0), (425.0, 2.0)];
    let outside = [(600.0, 2.0), (-450.0, 0.0), (-376.0, 0.0), (-375.0, 2.0)];
    for (x, expected) in between.into_iter().chain(outside) {
        close(pitch(&control, Plus, x), expected, x);
    }
    assert_eq!(control.connected_axes(), [("1".to_string(), "1".to_string())]);
}

/// B-63980EN/01 p. 100, interpolated: single pulses, within half a unit of the straight line.
#[test]
fn manual_example_in_interpolated_form() {
    let mut blocks = s1();
    blocks.push("N03605Q1A1P00000010".to_string());
    let control = control(&blocks);
    for (x, line, pulses) in
        [(25.0, 1.0, 1.0), (10.0, 0.4, 0.0), (60.0, 2.2, 2.0), (-360.0, 1.6, 2.0)]
    {
        close(pitch(&control, Plus, x), pulses, x);
        assert!((pulses - line).abs() <= 0.5, "{x}");
    }
    close(pitch(&control, Plus, 300.0), -1.0, "a node");
}

/// docs/fanuc.md §4.2, figure of B-64303CM-1/01 §1.3.1: the minus side is subtracted.
#[test]
fn figure_of_the_0i_d() {
    let control =
        control(&[grid([33, 31, 37], "10.0"), points(31, &[-3, 1, 1, 1, 2, -1, -3])].concat());
    for (node, expected) in (-3..).zip([1.0, -2.0, -1.0, 0.0, 1.0, 3.0, 2.0, -1.0]) {
        close(pitch(&control, Plus, 10.0 * f64::from(node)), expected, node);
    }
}

/// Both directions; the reversal at the reference is 3627.
#[test]
fn bidirectional_example() {
    let control = control(&bidirectional());
    let plus = [-3, -4, -3, -2, 0, 1, 1, 0, -2].map(f64::from);
    let minus = [-6, -7, -7, -5, -4, -3, -2, -3, -5].map(f64::from);
    for (index, (plus, minus)) in (0..).zip(plus.into_iter().zip(minus)) {
        let x = -40.0 + 10.0 * f64::from(index);
        close(pitch(&control, Plus, x), plus, x);
        close(pitch(&control, Minus, x), minus, x);
    }
    close(pitch(&control, Minus, 0.0) - pitch(&control, Plus, 0.0), -4.0, "reversal");
}

/// docs/fanuc.md §2.3: with a reference return in −, 3627 and backlash belong to travel in +.
#[test]
fn return_in_minus_swaps_the_roles() {
    let mut state = state();
    for (direction, um) in [(Plus, -4.0 - 3.0), (Minus, -4.0 + 3.0)] {
        state.axes[0].reference_direction = direction;
        state.axes[0].backlash_um = 3.0;
        let control = load(&bidirectional(), &facts_30i(), &state).expect("a control");
        close(pitch(&control, direction.opposite(), 0.0), um, direction);
        close(pitch(&control, direction, 0.0), 0.0, direction);
    }
}

#[test]
fn backlash_acts_without_tables_and_does_not_connect() {
    let mut state = state();
    state.axes[1].backlash_um = 3.0;
    let control = load(&s1(), &facts_30i(), &state).expect("a control");
    close(at(&control, ("2", "2"), Minus, 10.0), -3.0, "2");
    close(at(&control, ("2", "2"), Plus, 10.0), 0.0, "2");
    close(at(&control, ("2", "1"), Minus, 10.0), 0.0, "no table");
    assert_eq!(control.connected_axes().len(), 1);
    assert!(control.response("3", "3", Plus).is_err());
}

#[test]
fn magnification_and_detection_unit_scale_the_data() {
    let mut state = state();
    state.axes[0].detection_unit_um = Some(0.1);
    let blocks = replaced(&bidirectional(), "N03623", "N03623Q1A1P3");
    let mut facts = facts_30i();
    for (magnified, reversal) in [(false, -0.4), (true, -1.2)] {
        facts.reversal_magnified.value = magnified;
        let control = load(&blocks, &facts, &state).expect("a control");
        close(pitch(&control, Plus, -30.0), -1.2, magnified);
        close(pitch(&control, Minus, 0.0), reversal, magnified);
    }
    let control = load(&["N03623Q1A1P0".to_string()], &facts, &state).expect("switched off");
    assert!(control.connected_axes().is_empty());
    close(pitch(&control, Minus, -30.0), 0.0, "magnification 0");
}

#[test]
fn a_turned_sign_gives_the_opposite() {
    let mut facts = facts_four_point();
    facts.pitch_sign.value = TableSign::AsError;
    facts.straightness_sign.value = TableSign::AsError;
    let control = load(&bidirectional(), &facts, &state()).expect("a control");
    close(pitch(&control, Plus, -30.0), 4.0, "+");
    close(pitch(&control, Minus, -30.0), 7.0, "-");
    let control = load(&four_point(), &facts, &state()).expect("a control");
    close(at(&control, ("1", "2"), Plus, -600.0), 5.0, "straightness");
}

/// The state counts where no file writes 3605; the file counts where it does.
#[test]
fn switches_come_from_the_file_first() {
    let mut state = state();
    state.axes[0].bidirectional = true;
    let blocks = replaced(&bidirectional(), "N03605", "");
    let control = load(&blocks, &facts_30i(), &state).expect("a control");
    close(pitch(&control, Minus, 0.0), -4.0, "by state");
    let blocks = replaced(&bidirectional(), "N03605", "N03605Q1A1P00000000");
    let control = load(&blocks, &facts_30i(), &state).expect("a control");
    close(pitch(&control, Minus, 0.0), 0.0, "by file");
}

/// Four digits, no `Q`, integer interval: 50000 least increments are 50 mm, 20000 are 2 inch.
#[test]
fn interval_in_every_unit_and_form() {
    let mut state = state();
    state.axes[0].reference = Millimetres::new(100.0);
    let legacy = |interval| {
        let blocks = [grid([40, 33, 49], interval), points(33, &S1)].concat();
        let plain = |block: String| block.replace("N0", "N").replace("Q1", "").replace("Q0", "");
        blocks.into_iter().map(plain).collect::<Vec<_>>()
    };
    let mut facts = facts_16i();
    assert_eq!(facts.interval_form.value, IntervalForm::Integer);
    let control = load(&legacy("50000"), &facts, &state).expect("a control");
    close(pitch(&control, Plus, 100.0 - 250.0), 4.0, "mm");
    state.unit = ControlUnit::Inch;
    let control = load(&legacy("20000"), &facts, &state).expect("a control");
    close(pitch(&control, Plus, 100.0 - 5.0 * 50.8), 4.0, "inch, integer");
    facts.interval_form.value = IntervalForm::Real;
    let control = load(&legacy("2.0"), &facts, &state).expect("a control");
    close(pitch(&control, Plus, 100.0 - 5.0 * 50.8), 4.0, "inch, real");
    let first = control.response("1", "1", Plus).expect("a response").tables()[0].first();
    close(first.mm(), 100.0 - 8.0 * 50.8, "first node");
}

/// Rounded half away from zero at each point, held outside.
#[test]
fn four_point_straightness_example() {
    let mut state = state();
    state.axes[0].reference = Millimetres::new(100.0);
    state.axes[1].detection_unit_um = Some(0.5);
    let control = load(&four_point(), &facts_four_point(), &state).expect("a control");
    let expected =
        [(0, -5), (12, -4), (30, -3), (60, 0), (61, 0), (94, 6), (127, 11), (-9, -5), (140, 11)];
    for (point, units) in expected {
        let x = 100.0 + 10.0 * f64::from(point - 60);
        close(at(&control, ("1", "2"), Plus, x), 0.5 * f64::from(units), point);
    }
    assert_eq!(control.connected_axes(), [("1".to_string(), "2".to_string())]);
}

/// docs/fanuc.md §2.4: amounts count from the reference, and two sets of one pair add.
#[test]
fn four_point_sets_are_relative_and_add() {
    let mut blocks = four_point();
    blocks.extend(["N05712Q1P1", "N05722Q1P2"].map(String::from));
    for (number, value) in (5741..).zip([0, 60, 61, 127]).chain((5771..).zip([7, 10, 10, 20])) {
        blocks.push(format!("N{number:05}Q1P{value}"));
    }
    let control = load(&blocks, &facts_four_point(), &state()).expect("a control");
    close(at(&control, ("1", "2"), Minus, 0.0), 0.0, "reference");
    close(at(&control, ("1", "2"), Minus, 670.0), 11.0 + 10.0, "d");
    close(at(&control, ("1", "2"), Minus, -600.0), -5.0 - 3.0, "a");
}

/// docs/fanuc.md §2.5: like pitch data, on the grid of the moving axis, in units of the other.
#[test]
fn per_point_straightness() {
    let mut state = state();
    state.axes[0].reference = Millimetres::new(5.0);
    state.axes[1].detection_unit_um = Some(0.1);
    let control = load(&per_point(), &facts_30i(), &state).expect("a control");
    let sums = [-3, -4, -3, -2, 0, 1, 1, 0, -2];
    for (node, sum) in (-4..).zip(sums) {
        let x = 5.0 + 10.0 * f64::from(node);
        close(at(&control, ("1", "2"), Plus, x), 0.2 * f64::from(sum), node);
    }
    let off = replaced(&per_point(), "N13382", "N13382Q1P0");
    let control = load(&off, &facts_30i(), &state).expect("a control");
    assert!(control.connected_axes().is_empty(), "magnification 0");
}

/// Differences of rounded totals leave at most half a unit; increments rounded
/// one by one end 1.1 µm off.
#[test]
fn quantisation_with_carry() {
    let errors = [0.0, 0.6, 1.3, 1.9, 2.4, 3.0, 4.1, 4.9].map(Deviation::from_um);
    let residuals = |values: [i32; 8]| {
        let control = control(&[grid([0, 0, 7], "10.0"), points(0, &values)].concat());
        let node = |(index, error): (i32, Deviation)| {
            let x = Millimetres::new(10.0 * f64::from(index));
            let response = control.response("1", "1", Plus).expect("a response");
            (error + response.correction(x)).um()
        };
        (0..).zip(errors).map(node).collect::<Vec<f64>>()
    };
    let carried = residuals([0, -1, 0, -1, 0, -1, -1, -1]);
    assert!(carried.iter().all(|um| um.abs() <= 0.5 + 1e-9), "{carried:?}");
    close(carried[7], -0.1, "end");
    close(residuals([0, -1, -1, -1, 0, -1, -1, -1])[7], -1.1, "naive end");
}
