use super::*;
use crate::control::control_state::AxisState;
use crate::control::controller::{Evidence, Fact, TableForm, TableSign};
use crate::read::emulate::Emulator;
use crate::read::siemens::read;
use std::fmt::Write;

fn fact<T>(value: T) -> Fact<T> {
    Fact { value, evidence: Evidence::Manual, source: "test".to_string(), consequence: None }
}

fn facts() -> SiemensFacts {
    SiemensFacts {
        lec_sign: fact(TableSign::AsError),
        cec_sign: fact(TableSign::AsError),
        table_form: fact(TableForm::Program),
        lec_points: fact(5000),
        cec_tables: fact(62),
        cec_points: fact(2000),
        cec_memory_fixed: fact(false),
        value_decimals: fact(6),
        position_decimals: fact(6),
        cec_max_sum_um: fact(100_000.0),
        multiply_mode: fact(MultiplyMode::Product),
        factor_contributes: fact(false),
    }
}

fn axis(name: &str) -> AxisState {
    AxisState::plain(name, [0.0, 1000.0])
}

fn state() -> ControlState {
    ControlState {
        unit: ControlUnit::Millimetre,
        axes: ["X1", "Y1", "Z1", "X2"].map(axis).to_vec(),
    }
}

fn tables(text: &str) -> SiemensTables {
    let contents = read("test.mpf", text).unwrap_or_else(|problems| panic!("{problems}"));
    contents.tables
}

fn control_with(text: &str, facts: &SiemensFacts, state: &ControlState) -> PairControl {
    super::control(&tables(text), facts, state).unwrap_or_else(|why| panic!("{}", why.0))
}

fn control(text: &str) -> PairControl {
    control_with(text, &facts(), &state())
}

fn lec_text(axis: &str, grid: [f64; 3], modulo: u8, values: &[f64]) -> String {
    let mut text = String::new();
    for (point, value) in values.iter().enumerate() {
        writeln!(text, "$AA_ENC_COMP[0,{point},{axis}]={value}").expect("a string");
    }
    for (name, value) in ["MIN", "STEP", "MAX"].iter().zip(grid) {
        writeln!(text, "$AA_ENC_COMP_{name}[0,{axis}]={value}").expect("a string");
    }
    writeln!(text, "$AA_ENC_COMP_IS_MODULO[0,{axis}]={modulo}").expect("a string");
    text
}

/// `axes` is input and output, `switches` is DIRECTION and MULT_BY_TABLE.
fn cec_text(t: u32, axes: [&str; 2], grid: [f64; 3], switches: [i32; 2], values: &[f64]) -> String {
    let mut text = String::new();
    for (point, value) in values.iter().enumerate() {
        writeln!(text, "$AN_CEC[{t},{point}]={value}").expect("a string");
    }
    for (name, value) in ["MIN", "STEP", "MAX"].iter().zip(grid) {
        writeln!(text, "$AN_CEC_{name}[{t}]={value}").expect("a string");
    }
    let ([input, output], [direction, multiply]) = (axes, switches);
    writeln!(
        text,
        "$AN_CEC_INPUT_AXIS[{t}]=({input})\n$AN_CEC_OUTPUT_AXIS[{t}]=({output})\n\
         $AN_CEC_DIRECTION[{t}]={direction}\n$AN_CEC_MULT_BY_TABLE[{t}]={multiply}\n\
         $AN_CEC_IS_MODULO[{t}]=0"
    )
    .expect("a string");
    text
}

fn file(parts: &[String]) -> String {
    format!("CHANDATA(1)\n{}M17\n", parts.concat())
}

fn at(position: f64) -> Millimetres {
    Millimetres::new(position)
}

fn assert_um(found: Correction, expected_um: f64) {
    assert!(
        (found.um() - expected_um).abs() < 1e-6,
        "{} µm, expected {expected_um} µm",
        found.um()
    );
}

/// Own-axis response at a position.
fn own(control: &PairControl, axis: &str, position: f64, direction: Direction) -> Correction {
    let response = control.response(axis, axis, direction).expect("a response");
    response.correction(at(position))
}

fn why<T>(result: Emulated<T>) -> String {
    result.err().expect("cannot be emulated").0
}

/// Example of a table with 801 points: Function Manual Extended Functions 03/2013, K3 p. 242.
#[test]
fn example_of_the_manual_lec() {
    let mut values = vec![0.0; 801];
    values[..3].copy_from_slice(&[0.003, 0.010, 0.012]);
    let text =
        format!("%_N_AX_EEC_INI\n{}", file(&[lec_text("X1", [-200.0, 1.0, 600.0], 0, &values)]));
    let control = control(&text);
    let expected_mm = [
        (-250.0, -0.003),
        (-200.0, -0.003),
        (-199.5, -0.0065),
        (-199.0, -0.010),
        (-198.5, -0.011),
        (-198.25, -0.0115),
        (700.0, 0.0),
    ];
    for (position, mm) in expected_mm {
        assert_um(own(&control, "X1", position, Direction::Plus), mm * 1000.0);
        assert_um(own(&control, "X1", position, Direction::Minus), mm * 1000.0);
    }
}

/// Grid of four rows: Extended Functions, example for the sag of a cross beam (p. 288 of the
/// edition read); spacing of the rows inferred, 300 mm.
fn grid() -> String {
    let mut parts = Vec::new();
    for (row, value) in (0..4).zip([0.2, 0.7, 1.2, 1.7]) {
        let f = [0.0, value, 0.0];
        let x = [0.0, 500.0, 1000.0];
        let number_of_g = i32::try_from(row + 5).expect("small");
        parts.push(cec_text(row, ["X1", "Z1"], x, [0, number_of_g], &f));
        let g = [0, 1, 2, 3].map(|point| if point == row { 1.0 } else { 0.0 });
        let y = [0.0, 300.0, 900.0];
        parts.push(cec_text(row + 4, ["Y1", "Z1"], y, [0, 0], &g));
    }
    file(&parts)
}

#[test]
fn products_have_no_response_of_one_axis() {
    let control = control(&grid());
    for base in ["X1", "Y1"] {
        let reason = why(control.response(base, "Z1", Direction::Plus));
        assert!(reason.contains("product"), "{reason}");
        assert!(control.connected_axes().contains(&(base.to_string(), "Z1".to_string())));
    }
    let other = control.response("Z1", "X1", Direction::Plus).expect("a response");
    assert_um(other.correction(at(0.0)), 0.0);
}

#[test]
fn a_table_may_be_multiplied_by_itself_but_not_in_a_chain() {
    let table =
        |t, multiply| cec_text(t, ["X1", "Z1"], [0.0, 10.0, 10.0], [0, multiply], &[0.5, 0.5]);
    let own_square = control(&file(&[table(0, 1)]));
    assert_eq!(own_square.connected_axes().len(), 1);
    let load = |text: &str| super::control(&tables(text), &facts(), &state());
    let chain = why(load(&file(&[table(0, 2), table(1, 3), table(2, 0)])));
    assert!(chain.contains("chain"), "{chain}");
    let absent = why(load(&file(&[table(0, 5)])));
    assert!(absent.contains("$AN_CEC[4], which no file holds"), "{absent}");
}

/// Direction-dependent leadscrew compensation: Function Manual Extended Functions 03/2013, K3
/// p. 264 (grid of the manual, 11 points; its values were not at hand).
#[test]
fn example_of_the_manual_directional_tables() {
    let values = |sign: f64| (0..11).map(|n| sign * 0.001 * f64::from(n)).collect::<Vec<_>>();
    let grid = [-585.0, 58.0, -5.0];
    let plus = cec_text(0, ["X1", "X1"], grid, [1, 0], &values(1.0));
    let minus = cec_text(1, ["X1", "X1"], grid, [-1, 0], &values(-2.0));
    let text = file(&[plus, minus]);
    assert_eq!(tables(&text).tables[0].values.len(), 11);
    let control = control(&text);
    assert_um(own(&control, "X1", -5.0, Direction::Plus), -10.0);
    assert_um(own(&control, "X1", -5.0, Direction::Minus), 20.0);
    assert_um(own(&control, "X1", -556.0, Direction::Plus), -0.5);
    assert_um(own(&control, "X1", -600.0, Direction::Minus), 0.0);
}

/// Rotary axis of a real archive: 0 to 360 in steps of 10, 37 points.
#[test]
fn example_of_an_archive_modulo() {
    let mut values: Vec<f64> = (0..37).map(|n| 0.001 * f64::from((n * 7) % 11)).collect();
    values[36] = values[0];
    let text = file(&[lec_text("X1", [0.0, 10.0, 360.0], 1, &values)]);
    assert_eq!(tables(&text).tables[0].values.len(), 37);
    let turning = control(&text);
    let um = |position| own(&turning, "X1", position, Direction::Plus).um();
    assert_um(Correction::from_um(um(365.0)), um(5.0));
    assert_um(Correction::from_um(um(-5.0)), um(355.0));
    assert!((um(5.0) - um(355.0)).abs() > 0.1, "the two places differ");
    values[36] += 0.001;
    let open = tables(&file(&[lec_text("X1", [0.0, 10.0, 360.0], 1, &values)]));
    let reason = why(super::control(&open, &facts(), &state()));
    assert!(reason.contains("both ends differ"), "{reason}");
}

#[test]
fn cec_tables_of_one_output_add_and_never_feed_each_other() {
    let grid = [0.0, 100.0, 100.0];
    let parts = [
        cec_text(0, ["X1", "Z1"], grid, [0, 0], &[0.0, 0.010]),
        cec_text(1, ["Y1", "Z1"], grid, [0, 0], &[0.0, 0.020]),
        cec_text(2, ["Y1", "X1"], grid, [0, 0], &[50.0, 50.0]),
    ];
    let control = control(&file(&parts));
    for (base, um) in [("x1", -5.0), ("y1", -10.0)] {
        let response = control.response(base, "z1", Direction::Plus);
        assert_um(response.expect("a response").correction(at(50.0)), um);
    }
    let pairs = [("X1", "Z1"), ("Y1", "X1"), ("Y1", "Z1")];
    let pairs = pairs.map(|(base, output)| (base.to_string(), output.to_string()));
    assert_eq!(control.connected_axes(), pairs);
}

#[test]
fn the_sign_of_the_profile_turns_the_correction() {
    let lec = lec_text("X1", [0.0, 100.0, 100.0], 0, &[0.0, 0.010]);
    let cec = cec_text(0, ["X1", "Z1"], [0.0, 100.0, 100.0], [0, 0], &[0.0, 0.004]);
    let text = file(&[lec, cec]);
    for (sign, turn) in [(TableSign::AsError, -1.0), (TableSign::AsCorrection, 1.0)] {
        let mut facts = facts();
        facts.lec_sign = fact(sign);
        let control = control_with(&text, &facts, &state());
        assert_um(own(&control, "X1", 50.0, Direction::Plus), turn * 5.0);
        facts.cec_sign = fact(sign);
        let control = control_with(&text, &facts, &state());
        let response = control.response("X1", "Z1", Direction::Minus);
        assert_um(response.expect("a response").correction(at(50.0)), turn * 2.0);
    }
}

#[test]
fn on_an_inch_control_positions_and_values_are_inches() {
    let mut state = state();
    state.unit = ControlUnit::Inch;
    let text = file(&[lec_text("X1", [0.0, 1.0, 2.0], 0, &[0.0, 0.001, 0.0])]);
    let control = control_with(&text, &facts(), &state);
    assert_um(own(&control, "X1", 25.4, Direction::Plus), -25.4);
    assert_um(own(&control, "X1", 12.7, Direction::Plus), -12.7);
    let products = why(super::control(&tables(&grid()), &facts(), &state));
    assert!(products.contains("inch"), "{products}");
}

#[test]
fn a_sum_of_cec_that_would_be_clamped_is_refused() {
    let grid = [0.0, 100.0, 100.0];
    let parts = [
        cec_text(0, ["X1", "Z1"], grid, [0, 0], &[-0.7, 0.7]),
        cec_text(1, ["Y1", "Z1"], grid, [0, 0], &[-0.7, 0.7]),
        lec_text("Z1", grid, 0, &[0.5, 0.5]),
    ];
    let mut facts = facts();
    facts.cec_max_sum_um = fact(1000.0);
    let control = control_with(&file(&parts), &facts, &state());
    let reason = why(control.response("X1", "Z1", Direction::Plus));
    assert!(reason.contains("CEC_MAX_SUM"), "{reason}");
    assert!(control.response("Z1", "Z1", Direction::Plus).is_ok());
}

/// Positive backlash: the encoder leads, so the axis has to go further after a reversal; zero
/// belongs to the direction of the reference return.
#[test]
fn backlash_acts_away_from_the_reference_direction() {
    let text = file(&[lec_text("X1", [0.0, 100.0, 100.0], 0, &[0.001, 0.001])]);
    let cases = [
        (Direction::Plus, Direction::Plus, -1.0),
        (Direction::Plus, Direction::Minus, -1.0 - 8.0),
        (Direction::Minus, Direction::Plus, -1.0 + 8.0),
        (Direction::Minus, Direction::Minus, -1.0),
    ];
    for (reference, direction, expected_um) in cases {
        let mut state = state();
        state.axes[0].backlash_um = 8.0;
        state.axes[0].reference_direction = reference;
        let control = control_with(&text, &facts(), &state);
        assert_um(own(&control, "X1", 10.0, direction), expected_um);
        let cross = control.response("X1", "Y1", direction).expect("a response");
        assert_um(cross.correction(at(10.0)), 0.0);
    }
}

#[test]
fn both_axes_of_a_gantry_have_their_own_table() {
    let grid = [0.0, 100.0, 100.0];
    let parts = [lec_text("X1", grid, 0, &[0.0, 0.010]), lec_text("X2", grid, 0, &[0.0, -0.020])];
    let control = control(&file(&parts));
    assert_um(own(&control, "X1", 100.0, Direction::Plus), -10.0);
    assert_um(own(&control, "X2", 100.0, Direction::Plus), 20.0);
    let between = control.response("X1", "X2", Direction::Plus).expect("a response");
    assert_um(between.correction(at(100.0)), 0.0);
}

#[test]
fn what_the_control_would_do_is_not_guessed() {
    let grid = [0.0, 100.0, 200.0];
    let lec = lec_text("X1", grid, 0, &[0.0, 0.010, 0.0]);
    let cec = cec_text(3, ["X1", "Z1"], grid, [0, 0], &[0.0, 0.010, 0.0]);
    let load =
        |text: &str, facts: &SiemensFacts| why(super::control(&tables(text), facts, &state()));
    let gap = file(&[lec.replace("$AA_ENC_COMP[0,1,X1]=0.01\n", "")]);
    let reason = load(&gap, &facts());
    assert!(reason.contains("$AA_ENC_COMP[0,X1]: point 1"), "{reason}");
    let gap = file(&[cec.replace("$AN_CEC[3,2]=0\n", "")]);
    let reason = load(&gap, &facts());
    assert!(reason.contains("$AN_CEC[3]: point 2"), "{reason}");
    let mut small = facts();
    small.lec_points = fact(2);
    small.cec_points = fact(2);
    assert!(load(&file(std::slice::from_ref(&lec)), &small).contains("the control holds 2"));
    assert!(load(&file(std::slice::from_ref(&cec)), &small).contains("the control holds 2"));
    small.cec_tables = fact(3);
    assert!(load(&file(&[cec]), &small).contains("has 3 tables"));
    let two = file(&[lec.clone(), lec.replace("[0,", "[1,")]);
    let reason = why(control(&two).response("X1", "X1", Direction::Plus));
    assert!(reason.contains("measuring systems 0 and 1"), "{reason}");
}
