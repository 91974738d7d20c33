//! Each way in which a kit cannot be emulated, with the words it is refused with.

use super::*;

fn refused(blocks: &[String], facts: &FanucFacts, state: &ControlState, words: &str) {
    match load(blocks, facts, state) {
        Ok(_) => panic!("not refused: {words}"),
        Err(CannotEmulate(message)) => {
            assert!(message.contains(words), "{message:?}, expected {words:?}")
        }
    }
}

#[test]
fn wrong_pitch_blocks_are_refused() {
    let replacements = [
        ("N03620", "N03620Q1A1P32", "expected 3621 ≤ 3620 < 3622"),
        ("N03620", "N03620Q1A1P49", "expected 3621 ≤ 3620 < 3622"),
        ("N03620", "N03620Q1A1P40.0", "not a whole number"),
        ("N03620", "N03620Q1P40", "names no axis"),
        ("N03620", "", "parameter 3620 of axis 1 is missing"),
        ("N03620", "N03620Q1A1P40A3P1", "name axis 3"),
        ("N03622", "N03622Q1A1P1536", "not in one block"),
        ("N03622", "N03622Q1A1P-1", "is -1"),
        ("N03623", "", "parameter 3623 of axis 1 is missing"),
        ("N03623", "N03623Q1A1P101", "expected 0 to 100"),
        ("N03624", "", "parameter 3624 of axis 1 is missing"),
        ("N03624", "N03624Q1A1P0.0", "interval above 0"),
        ("N03624", "N03624Q1A1P-50.0", "interval above 0"),
        ("N03624", "N03624Q1A1P50", "no decimal point"),
        ("N10036", "", "point 36 is missing"),
    ];
    for (start, by, words) in replacements {
        refused(&replaced(&s1(), start, by), &facts_30i(), &state(), words);
    }
}

#[test]
fn what_is_not_emulated_is_refused() {
    let additions = [
        ("N03625Q1A1P360.0", "rotary"),
        ("N03602Q1P00000001", "total values"),
        ("N03605Q1A1P00000100", "arbitrary-pitch"),
        ("N03605Q1P00000001", "names no axis"),
        ("N03605Q1A1P00000001", "parameter 3626 of axis 1 is missing"),
        ("N08135Q1P00000001", "not available"),
        ("N05861Q1A1P33", "inclination"),
        ("N05871Q1A1P3", "inclination"),
        ("N01240Q1A1P10.0", "reference position"),
        ("N01851Q1A1P3", "backlash"),
        ("N01006Q1A1P00100000", "contradicts"),
        ("N05711Q1A1P1", "no axis owns"),
        ("N13381Q1A1P1", "no axis owns"),
    ];
    for (block, words) in additions {
        let blocks = [s1(), vec![block.to_string()]].concat();
        refused(&blocks, &facts_30i(), &state(), words);
    }
    let mut memory = FanucMemory::default();
    let key = crate::control::table::fanuc::ParameterKey { number: 10803, axis: None };
    memory.parameters.insert(key, crate::control::table::fanuc::ParameterValue::Integer(5));
    assert!(super::super::control(&memory, &facts_30i(), &state()).is_err(), "3-D");
}

#[test]
fn wrong_second_runs_are_refused() {
    let cases = [
        ("N03626", "N03626Q1A1P2000", "2000 to 2007"),
        ("N03626", "N03626Q1A1P27", "share points"),
        ("N03627", "", "parameter 3627 of axis 1 is missing"),
        ("N03627", "N03627Q1A1P40000", "is 40000"),
        ("N10037", "", "point 37 is missing"),
    ];
    for (start, by, words) in cases {
        let spare = points(28, &[0, 0]);
        let blocks = [replaced(&bidirectional(), start, by), spare].concat();
        refused(&blocks, &facts_30i(), &state(), words);
    }
}

#[test]
fn axes_that_share_points_are_refused() {
    let second =
        ["N03620Q1A2P40", "N03621Q1A2P40", "N03622Q1A2P49", "N03623Q1A2P1", "N03624Q1A2P50.0"];
    let blocks = [s1(), second.map(String::from).to_vec()].concat();
    refused(&blocks, &facts_30i(), &state(), "share points");
}

#[test]
fn wrong_states_are_refused() {
    let mut state = state();
    state.axes[0].detection_unit_um = None;
    refused(&s1(), &facts_30i(), &state, "detection unit is not stated");
    state.axes[0].detection_unit_um = Some(0.0);
    refused(&s1(), &facts_30i(), &state, "more than 0");
    state.axes[0].name = "X".to_string();
    refused(&s1(), &facts_30i(), &state, "does not state");
}

#[test]
fn wrong_four_point_sets_are_refused() {
    let cases = [
        ("N05711", "", "parameter 5711 is missing"),
        ("N05711", "N05711Q1P2", "both moving and compensation"),
        ("N05711", "N05711Q1P3", "name axis 3"),
        ("N05721", "N05721Q1P0", "parameter 5721 is 0"),
        ("N05732", "N05732Q1P62", "do not ascend"),
        ("N05732", "N05732Q1P0", "two amounts"),
        ("N05734", "N05734Q1P128", "not all in 0 to 127"),
        ("N05764", "", "parameter 5764 is missing"),
        ("N05764", "N05764Q1P40000", "is 40000"),
        ("N03622", "N03622Q1A1P128", "at most 128"),
        ("N03624", "", "parameter 3624 of axis 1 is missing"),
    ];
    for (start, by, words) in cases {
        refused(&replaced(&four_point(), start, by), &facts_four_point(), &state(), words);
    }
    let blocks = [four_point(), vec!["N05714Q1P1".to_string()]].concat();
    refused(&blocks, &facts_four_point(), &state(), "has 3 sets");
    let mut facts = facts_four_point();
    facts.straightness_sets.value = 4;
    refused(&four_point(), &facts, &state(), "room for 3");
}

#[test]
fn wrong_per_point_sets_are_refused() {
    assert_eq!(facts_30i().straightness_form.value, StraightnessForm::PerPoint);
    let cases = [
        ("N05712", "", "parameter 5712 is missing"),
        ("N05722", "N05722Q1P1", "both moving and compensation"),
        ("N13382", "", "parameter 13382 is missing"),
        ("N13392", "", "parameter 13392 is missing"),
        ("N13392", "N13392Q1P100", "not in one block"),
        ("N16130", "", "point 6130 is missing"),
    ];
    for (start, by, words) in cases {
        refused(&replaced(&per_point(), start, by), &facts_30i(), &state(), words);
    }
    let twice = ["N05713Q1P2", "N05723Q1P1", "N13383Q1P1", "N13393Q1P6130"].map(String::from);
    let other = grid([23, 20, 27], "10.0")
        .join(" ")
        .replace("A1", "A2")
        .replace("N03623Q1A2P1", "N03623Q1A2P0");
    let other = other.split(' ').map(String::from).collect();
    let blocks = [per_point(), twice.to_vec(), other, points(6136, &[0, 0])].concat();
    refused(&blocks, &facts_30i(), &state(), "share points");
}
