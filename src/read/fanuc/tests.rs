//! Files of the kinds that controls write, and each way in which a file can be wrong.

use super::*;
use crate::control::controller::{Evidence, Fact, IntervalForm, StraightnessForm, TableSign};
use crate::text::Problem;
use crate::text::plain::tests::texts_of;

fn fact<T>(value: T) -> Fact<T> {
    Fact { value, evidence: Evidence::Manual, source: "test".to_string(), consequence: None }
}

fn ranges(bounds: &[(u32, u32)]) -> Fact<Vec<NumberRange>> {
    fact(bounds.iter().map(|&(first, last)| NumberRange { first, last }).collect())
}

/// A 30i-class control with per-point straightness.
pub(crate) fn facts_30i() -> FanucFacts {
    FanucFacts {
        pitch_sign: fact(TableSign::AsCorrection),
        straightness_sign: fact(TableSign::AsCorrection),
        number_digits: fact(5),
        q_identifier: fact(true),
        point_offset: fact(10000),
        pitch_points: ranges(&[(0, 1535)]),
        minus_points: ranges(&[(0, 1535), (3000, 4535)]),
        increment_max: fact(7),
        magnification_max: fact(100),
        interval_form: fact(IntervalForm::Real),
        interval_decimals_mm: fact(3),
        interval_decimals_inch: fact(4),
        interval_feed_divisor: fact(7500.0),
        output_fraction: fact(0.5),
        reversal_magnified: fact(false),
        straightness_form: fact(StraightnessForm::PerPoint),
        straightness_sets: fact(6),
        straightness_axis_points: fact(128),
        straightness_points: ranges(&[(6000, 6767)]),
        straightness_magnification_parameter: fact(13381),
        straightness_start_parameter: fact(13391),
        straightness_amount_max: fact(32767),
    }
}

/// A 16i-class control: four digits, no `Q`, integer interval, four-point straightness.
pub(crate) fn facts_16i() -> FanucFacts {
    FanucFacts {
        number_digits: fact(4),
        q_identifier: fact(false),
        pitch_points: ranges(&[(0, 1023)]),
        minus_points: ranges(&[(0, 1023)]),
        interval_form: fact(IntervalForm::Integer),
        straightness_form: fact(StraightnessForm::FourPoint),
        straightness_sets: fact(3),
        straightness_points: ranges(&[]),
        ..facts_30i()
    }
}

fn read_30i(text: &str) -> Result<FanucMemory, Problems> {
    read("PITCH.TXT", text, &facts_30i())
}

fn wrong(text: &str) -> Vec<Problem> {
    match read_30i(text) {
        Ok(memory) => panic!("{text:?} was read as {memory:?}"),
        Err(problems) => problems.iter().cloned().collect(),
    }
}

const LINES: [&str; 6] = [
    "%",
    "N03605Q1A1P00000011A2P00000000",
    "N03620Q1A1P40A2P140 ",
    "N03624Q1A1P50.0A2P-25.4",
    "N10033Q0P-2",
    "%",
];

#[test]
fn every_kind_of_line_end_gives_the_same_memory() {
    let expected = read_30i(&LINES.join("\n")).expect("a good file");
    for end in ["\r\n", "\n\r\r", "\n\n", "\n\r\r\n\r\r", " \n", " \t\r\n"] {
        assert_eq!(read_30i(&LINES.join(end)).expect("a good file"), expected, "{end:?}");
    }
    assert_eq!(expected.parameter(3605, Some(1)), Some(ParameterValue::Bits(3)));
    assert_eq!(expected.parameter(3620, Some(2)), Some(ParameterValue::Integer(140)));
    assert_eq!(expected.parameter(3624, Some(2)), Some(ParameterValue::Real(-25.4)));
    assert_eq!(expected.points.get(&33), Some(&-2));
}

/// B-63524EN/01 p. 649: LF ends a block, not `;`; letters in lower case are skipped.
#[test]
fn what_a_control_understands_otherwise_is_refused() {
    for (end, says) in
        [("\r", "carriage return alone"), (";\n", "`;` ends no block"), (";", "`;` ends no block")]
    {
        let text = LINES.join(end).replacen(end, "\n", 1);
        let problems = wrong(&format!("{text}\n"));
        let told = |problem: &Problem| problem.message.contains(says);
        assert!(problems.iter().any(told), "{end:?}: {problems:?}");
    }
    for block in ["n03620Q1A1P40", "N03620q1A1P40", "N03620Q1a1P40", "N03620Q1A1p40"] {
        let problems = wrong(&format!("%\n{block}\n%\n"));
        assert!(problems[0].message.contains("lower case"), "{problems:?}");
    }
}

#[test]
fn blanks_and_text_around_the_record_mean_nothing() {
    let text = "% Pitch \u{e9}\n N03620 Q1 A1P40\tA2P140 \n%\nchecksum 12, \u{e9}";
    let memory = read_30i(text).expect("a good file");
    assert_eq!(memory.parameters.len(), 2);
    let unit = ControlUnit::Millimetre;
    let whole = read_out("CNC-PARA.TXT", &format!("cnc 2\n{text}"), &facts_30i(), unit);
    assert_eq!(whole.expect("a good file").memory, memory);
    assert!(read_30i("%\n%").expect("an empty record").parameters.is_empty());
}

/// Lines of the form a 30i writes (B-63950EN/02 §3.3.2–3.3.7).
#[test]
fn path_one_and_unit_letters_are_read() {
    let text =
        "%\nN00010Q1P00000001\nN05711Q1P00000001\nN01240Q1L1M0.5\nN03620Q1L1A1P88T1A2P89\n%\n";
    let memory = read_out("CNC-PARA.TXT", text, &facts_30i(), ControlUnit::Millimetre);
    let found = memory.expect("a good file");
    assert_eq!(found.passed_over, 1);
    let memory = found.memory;
    assert_eq!(
        memory.parameter(5711, None),
        Some(ParameterValue::Integer(1)),
        "not a known bit parameter"
    );
    assert_eq!(memory.parameter(1240, None), Some(ParameterValue::Real(0.5)));
    assert_eq!(memory.parameter(3620, Some(2)), Some(ParameterValue::Integer(89)));
}

/// Legacy rule (B-63534EN, B-63330EN/03 §3): a number from 10000 on is a point.
#[test]
fn legacy_files_need_no_q() {
    let text = "%\r\nN3620A1P40A2P140\r\nN3624A1P50000\r\nN10033P2\r\nN3605A1P00000001\r\n%\r\n";
    let memory = read("A.TXT", text, &facts_16i()).expect("a good file");
    assert_eq!(memory.parameter(3620, Some(1)), Some(ParameterValue::Integer(40)));
    assert_eq!(memory.parameter(3624, Some(1)), Some(ParameterValue::Integer(50000)));
    assert_eq!(memory.parameter(3605, Some(1)), Some(ParameterValue::Bits(1)));
    assert_eq!(memory.points.into_iter().collect::<Vec<_>>(), [(33, 2)]);
}

#[test]
fn straightness_parameters_in_the_space_of_the_points_are_parameters() {
    let memory = read_30i("%\nN13381Q1P1\nN13396Q1P6640\nN16000Q0P7\n%\n").expect("a good file");
    assert_eq!(memory.parameter(13396, None), Some(ParameterValue::Integer(6640)));
    assert_eq!(memory.points.get(&6000), Some(&7));
}

#[test]
fn later_parameters_overwrite_and_equal_points_may_repeat() {
    let memory = read_30i(
        "%\nN03623Q1A1P1\nN03623Q1A1P2\nN10033Q0P1\nN10033Q0P1\nN10034Q0P-128\nN10035Q0P127\n%\n",
    );
    let memory = memory.expect("a good file");
    assert_eq!(memory.points.values().collect::<Vec<_>>(), [&1, &-128, &127]);
    assert_eq!(memory.parameter(3623, Some(1)), Some(ParameterValue::Integer(2)));
}

/// One bad block between good ones: the words that must be in the message, and where it is.
#[test]
fn each_bad_block_is_named_with_its_column() {
    let cases = [
        ("N10033Q0P1.0", "expected a whole number", 10),
        ("N10033Q0P128", "expected -128 to 127", 10),
        ("N10033Q0P-129", "expected -128 to 127", 10),
        ("N10033Q0P99999999999999999999", "expected -128 to 127", 10),
        ("N10033Q0A1P1", "without axis", 12),
        ("N10033Q0M1", "plain `P`", 10),
        ("N10033Q0P1P1", "more than one value", 1),
        ("N12000Q0P1", "no point 2000", 1),
        ("N00033Q0P1", "below 10000", 1),
        ("N10033Q1P2", "parameter 10033, not pitch point 33", 1),
        ("N10033P2", "ambiguous", 1),
        ("N10033Q2P2", "neither `Q0` nor `Q1`", 8),
        ("N10033Q00P2", "`Q00` is neither `Q0` nor `Q1`", 8),
        ("N03620Q01A1P2", "`Q01` is neither `Q0` nor `Q1`", 8),
        ("N10033Q0P1(X)", "comment", 11),
        ("(X AXIS)", "comment", 1),
        ("O1234", "program number", 1),
        ("G10L52", "G10", 1),
        ("N3620P1R40", "G10", 8),
        ("N03624Q1A1P50,0", "decimal comma", 14),
        ("N03624Q1A1P50.", "the block ends", 14),
        ("N03624Q1A1P.5", "`.` where a digit", 12),
        ("N03624Q1A1P+5", "`+` where a digit", 12),
        ("N03624Q1A1I2.0", "the letter `I`", 12),
        ("N03624Q1A1P1E3", "`E`", 13),
        ("N03620Q1S1P1", "spindle parameter is not ours", 9),
        ("N05711Q1L1P1L2P1", "path 2", 13),
        ("N03620Q1T2A1P1", "path 2", 9),
        ("N03620Q1A0P1", "count from 1", 9),
        ("N03620Q1A1P1A1P2", "two values", 16),
        ("N03620Q1A1", "the block ends", 10),
        ("N03620Q1", "the block ends", 8),
        ("N99999999999Q1P1", "too large", 2),
        ("N03620Q1A1P99999999999999999999", "too large", 12),
        ("N03605Q1A1P1", "eight bits", 12),
        ("N03605Q1A1P00000002", "eight bits", 12),
        ("N10033Q0P\u{2212}1", "not an ASCII character", 10),
        ("3620P1", "begins with `N`", 1),
        ("/N10033Q0P1", "found `/`", 1),
        ("M30", "found `M`", 1),
        ("\u{b}N10033Q0P1", "found `\\u{b}`", 1),
        ("\0N10033Q0P1", "found `\\0`", 1),
        ("%", "inside the record", 1),
        ("NP1", "`P` where a digit", 2),
    ];
    for (block, words, column) in cases {
        let text = format!("%\n\r\rN03620Q1A1P40\n\r\r{block}\n\r\rN03621Q1A1P33\n\r\r%\n\r\r");
        let problems = wrong(&text);
        assert_eq!(problems.len(), 1, "{block}: {problems:?}");
        assert!(problems[0].message.contains(words), "{block}: {}", problems[0].message);
        let place = problems[0].place.as_ref().expect("a place");
        assert_eq!((place.line, place.column), (3, column), "{block}");
        assert_eq!(place.text, block, "the line is shown without its line end");
    }
}

#[test]
fn broken_frames_are_named() {
    let cases = [
        ("", "no opening `%`"),
        ("N03620Q1A1P40\n", "no opening `%`"),
        ("N03620Q1A1P40\n%\n", "no opening `%`"),
        ("%\nN03620Q1A1P40\nN036", "no closing `%`"),
        ("%", "no closing `%`"),
        ("%N03620Q1A1P40\n%", "line of the opening"),
        ("%\nN03620Q1A1P40%", "inside a block"),
        ("%%", "inside a block"),
        ("N03620Q1A1P40\n%\n%\n", "before the opening `%`"),
        ("\n%\n%\n", "before the opening `%`"),
        ("%\n%\nN03620Q1A1P40\n", "behind the closing `%`"),
        ("%\n%\nsum 12\nn 10003 Q0P7", "behind the closing `%`"),
        ("\u{feff}%\n%\n", "before the opening `%`"),
        ("% PITCH\rN03620Q1A1P40\n%\n", "carriage return alone"),
    ];
    for (text, words) in cases {
        let problems = wrong(text);
        assert!(problems[0].message.contains(words), "{text:?}: {problems:?}");
        assert!(problems[0].place.is_some() && problems[0].help.is_some(), "{text:?}");
    }
}

#[test]
fn all_problems_of_a_file_come_together() {
    let problems = wrong("%\nN10033Q0P1\nN10033Q0P2\nN10034Q0P1.5\nN1Q1S1P1\n%\n");
    let lines: Vec<usize> =
        problems.iter().filter_map(|p| p.place.as_ref().map(|at| at.line)).collect();
    assert_eq!(lines, [3, 4, 5]);
    assert!(problems[0].message.contains("is 2 here and 1"), "{}", problems[0].message);
}

#[test]
fn a_g10_program_is_one_problem() {
    let problems = wrong("%\nG10L52\nN3620P1R40\nN3621P1R33\nG11\nN10033P2\n%\n");
    assert_eq!(problems.len(), 2, "{problems:?}");
    assert!(problems[0].help.as_ref().is_some_and(|help| help.contains("N…P…")));
}

#[test]
fn files_of_a_kit_make_one_memory_unless_they_disagree() {
    let parameters = read_30i("%\nN03623Q1A1P1\n%").expect("a good file");
    let points = read_30i("%\nN10033Q0P1\n%").expect("a good file");
    let both = merge(vec![parameters.clone(), points.clone(), points]).expect("they agree");
    assert_eq!((both.parameters.len(), both.points.len()), (1, 1));
    let other = read_30i("%\nN03623Q1A1P2\nN10033Q0P2\n%").expect("a good file");
    let problems = merge(vec![both, other]).expect_err("they disagree");
    let messages: Vec<&str> = problems.iter().map(|p| p.message.as_str()).collect();
    assert!(messages[0].contains("parameter 3623 of axis 1"), "{messages:?}");
    assert!(messages[1].contains("point 33"), "{messages:?}");
}

proptest::proptest! {
    /// Whatever stands in a file, it is read or its problems can be shown.
    #[test]
    fn no_text_stops_the_reader(
        text in texts_of("%NQPALSG0123456789.,;(\r\n \u{e9}-".chars(), 60),
    ) {
        for text in [format!("%\n{text}%"), text] {
            if let Err(problems) = read_30i(&text) {
                proptest::prop_assert!(!problems.render().is_empty());
            }
        }
    }
}
