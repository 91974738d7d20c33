//! Programs with hand-made expected moves.
mod language;

use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A program in memory.
struct Lines<'a> {
    text: &'a [u8],
    mark: Mark,
}

impl Text for Lines<'_> {
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused> {
        let start = usize::try_from(self.mark.bytes).expect("a short text");
        let rest = &self.text[start.min(self.text.len())..];
        if rest.is_empty() {
            return Ok(None);
        }
        let line = rest.split(|byte| *byte == b'\n').next().unwrap_or(rest);
        self.mark.bytes += line.len() as u64 + 1;
        self.mark.lines += 1;
        Ok(Some(Line { number: self.mark.lines, bytes: line }))
    }
    fn mark(&self) -> Mark {
        self.mark
    }
    fn go_to(&mut self, mark: Mark) -> Result<(), Refused> {
        self.mark = mark;
        Ok(())
    }
}

fn control() -> Setup {
    Setup {
        language: Language::Iso,
        start: [0.0; 3],
        reference: [0.0, 0.0, 500.0],
        second_reference: Some([10.0, 20.0, 30.0]),
        systems: BTreeMap::from([
            (1, [0.0; 3]),
            (2, [100.0, 200.0, 300.0]),
            (107, [1.0, 2.0, 3.0]),
        ]),
        tools: BTreeMap::from([(1, 50.0), (2, 80.0)]),
        tool_names: BTreeMap::from([("DRILL".to_string(), 2)]),
        inch: Some(false),
        without_point: WithoutPoint::Unit,
        g43_without_h: G43WithoutH::Refuse,
        arc_mm: None,
        skip_deletable: false,
    }
}

fn run_with(setup: &Setup, program: &str) -> Result<(Vec<Move>, Ran), Vec<Refused>> {
    let mut moves = Vec::new();
    let mut text = Lines { text: program.as_bytes(), mark: Mark::default() };
    let ran = run(&mut text, setup, |step| {
        moves.push(*step);
        Ok(())
    })?;
    Ok((moves, ran))
}

fn moves(program: &str) -> Vec<Move> {
    run_with(&control(), program).expect("a program").0
}

/// Ends of the moves, `r` before those of rapid ones.
fn ends(program: &str) -> Vec<String> {
    let show = |step: &Move| {
        let [x, y, z] = step.to.map(|mm| (mm * 1e6).round() / 1e6 + 0.0);
        format!("{}{x} {y} {z}", if step.rapid { "r" } else { "" })
    };
    moves(program).iter().map(show).collect()
}

/// Line and column.
fn place(refused: &Refused) -> Option<(usize, usize)> {
    refused.place.as_ref().map(|place| (place.line, place.text[..place.span.0].chars().count() + 1))
}

fn refused(program: &str) -> Vec<(usize, usize)> {
    let problems = run_with(&control(), program).expect_err("it is refused");
    problems.iter().filter_map(place).collect()
}

#[test]
fn modal_words_stand_alone_and_hold() {
    assert_eq!(ends("G0\nX1\nG1\nY2\nX3 Z4"), ["r1 0 0", "1 2 0", "3 2 4"]);
    assert_eq!(ends("g 1 x1 0 . 5\n n5 y-.25"), ["10.5 0 0", "10.5 -0.25 0"]);
    assert_eq!(ends("G1 X1\nG91\nX1\nX1 G90 Y5"), ["1 0 0", "2 0 0", "1 5 0"]);
    assert_eq!(ends("G20 G1 X1.\nG21 X1."), ["25.4 0 0", "1 0 0"]);
    assert_eq!(ends("G1 X1\nM30\nX9"), ["1 0 0"]);
    assert_eq!(ends("%\nO1\nG1 X1\n%\nX9"), ["1 0 0"]);
    assert_eq!(ends("G1 X1 (X2) ; X3"), ["1 0 0"]);
    assert_eq!(ends("G4 X5\nG4 P100\nG1 X1"), ["1 0 0"]);
}

#[test]
fn zeros_of_coordinate_systems_add() {
    assert_eq!(
        ends("G55 G1 X1 Y1 Z1\nG53 G0 X0\nX0"),
        ["101 201 301", "r0 201 301", "r100 201 301"]
    );
    assert_eq!(ends("G54.1 P7 G1 X1"), ["2 0 0"]);
    assert_eq!(ends("G52 X10\nG1 X1\nG52 X0\nX1"), ["11 0 0", "1 0 0"]);
    assert_eq!(ends("G1 X5\nG92 X0 Y7\nX1\nY7\nG92.1\nX1"), ["5 0 0", "6 0 0", "1 0 0"]);
    assert_eq!(ends("G10 L2 P2 X7\nG55 G1 X1"), ["8 0 0"]);
    assert_eq!(ends("G10 L2 P3 X7 Y0 Z0\nG56 G1 X1"), ["8 0 0"]);
    assert_eq!(ends("G91 G10 L2 P2 X7\nG90 G55 G1 X1"), ["108 0 0"]);
}

#[test]
fn tool_length_moves_the_spindle() {
    assert_eq!(ends("G0 G43 H1 Z10\nG49 Z10"), ["r0 0 60", "r0 0 10"]);
    assert_eq!(ends("G43 H1\nG91 G1 Z1\nZ1\nH2 Z0"), ["0 0 51", "0 0 52", "0 0 82"]);
    assert_eq!(moves("G43 H2 G1 X1")[0].tool_mm, Some(80.0));
}

#[test]
fn reference_points_are_approached_through_a_place() {
    assert_eq!(ends("G0 X5 Z5\nG91 G28 Z0"), ["r5 0 5", "r5 0 500"]);
    assert_eq!(ends("G0 X5\nG28 X7 Y0"), ["r5 0 0", "r7 0 0", "r0 0 0"]);
    assert_eq!(ends("G30 Y4"), ["r0 4 0", "r0 20 0"]);
}

fn arc(program: &str) -> (Arc, Move) {
    let step = *moves(program).last().expect("a move");
    match step.shape {
        Shape::Arc(arc) => (arc, step),
        Shape::Line => panic!("{program} ends with a line"),
    }
}

fn near(a: Place, b: Place) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn arcs_turn_as_their_plane_says() {
    // Clockwise as seen from the positive third axis: from +first over −second … by the right hand.
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let (_, xy) = arc("G17 G1 X1\nG3 X0 Y1 I-1");
    assert!(near(xy.at(0.5), [quarter, quarter, 0.0]));
    let (_, zx) = arc("G18 G1 Z1\nG3 Z0 X1 K-1");
    assert!(near(zx.at(0.5), [quarter, 0.0, quarter]));
    let (_, yz) = arc("G19 G1 Y1\nG3 Y0 Z1 J-1");
    assert!(near(yz.at(0.5), [0.0, quarter, quarter]));
    let (long, _) = arc("G1 X1\nG2 X0 Y1 I-1");
    assert!((long.sweep_rad + 1.5 * std::f64::consts::PI).abs() < 1e-9);
}

#[test]
fn a_radius_takes_the_short_way_and_a_negative_one_the_long_way() {
    let half_pi = std::f64::consts::FRAC_PI_2;
    for (words, sweep, centre) in [
        ("G3 X0 Y1 R1", half_pi, [0.0, 0.0]),
        ("G3 X0 Y1 R-1", 3.0 * half_pi, [1.0, 1.0]),
        ("G2 X0 Y1 R1", -half_pi, [1.0, 1.0]),
        ("G2 X0 Y1 R-1", -3.0 * half_pi, [0.0, 0.0]),
    ] {
        let (arc, step) = arc(&format!("G1 X1\n{words}"));
        assert!((arc.sweep_rad - sweep).abs() < 1e-9, "{words}: {}", arc.sweep_rad);
        assert!(
            (arc.centre[0] - centre[0]).abs() + (arc.centre[1] - centre[1]).abs() < 1e-9,
            "{words}"
        );
        assert!(near(step.at(1.0), step.to), "{words}");
    }
}

#[test]
fn full_circles_helices_and_absolute_centres() {
    let (circle, step) = arc("G1 X10\nG2 I-10");
    assert!((circle.sweep_rad + std::f64::consts::TAU).abs() < 1e-12);
    assert!(near(step.at(0.25), [0.0, -10.0, 0.0]) && near(step.at(0.5), [-10.0, 0.0, 0.0]));
    let (_, helix) = arc("G1 X10\nG3 X10 Y0 Z5 I-10");
    assert!(near(helix.at(0.5), [-10.0, 0.0, 2.5]));
    let expected = (20.0 * std::f64::consts::PI).hypot(5.0);
    assert!((helix.length_mm() - expected).abs() < 1e-9);
    let (absolute, _) = arc("G1 X10\nG90.1 G3 X0 Y10 I0 J0");
    assert!(absolute.centre.iter().all(|mm| mm.abs() < 1e-12));
    let (inch, step) = arc("G20 G1 X1.\nG3 X0 Y1. I-1.");
    assert!((inch.radius[0] - 25.4).abs() < 1e-9 && near(step.to, [0.0, 25.4, 0.0]));
    let (incremental, step) = arc("G91 G1 X1\nG3 X-1 Y1 I-1");
    assert!((incremental.sweep_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!(near(step.to, [0.0, 1.0, 0.0]));
}

#[test]
fn cycles_drill_holes() {
    let drill = "G0 Z50\nG99 G81 X10 Y20 Z-5 R2\nX30\nG98 X40\nG80";
    assert_eq!(
        ends(drill),
        [
            "r0 0 50",
            "r10 20 50",
            "r10 20 2",
            "10 20 -5",
            "r10 20 2",
            "r30 20 2",
            "30 20 -5",
            "r30 20 2",
            "r40 20 2",
            "40 20 -5",
            "r40 20 2",
            "r40 20 50"
        ]
    );
    assert_eq!(ends("G0 Z9\nG99 G85 X1 Z0 R2\nG80").last().map(String::as_str), Some("1 0 2"));
    let row = "G0 Z10\nG91 G99 G81 X5 Z-4 R-8 K2\nG80";
    assert_eq!(
        ends(row),
        ["r0 0 10", "r5 0 10", "r5 0 2", "5 0 -2", "r5 0 2", "r10 0 2", "10 0 -2", "r10 0 2"]
    );
    assert_eq!(run_with(&control(), row).expect("a program").1.holes, 2);
    assert_eq!(ends("G18 G0 Y9\nG81 X1 Z2 Y-1 R1\nG80")[1..3], ["r1 9 2", "r1 1 2"]);
}

/// A cycle goes on from another zero or with another length; a length that is made up for acts once.
#[test]
fn a_cycle_follows_zero_and_length() {
    let hole = |before: &str, change: &str| {
        let cycle = "G99 G81 X10 Y10 Z5 R20\n";
        ends(&format!("G0 X0 Y0 Z50\n{before}{cycle}{change} X20\nG80"))[6..].to_vec()
    };
    assert_eq!(hole("", ""), ["20 10 5", "r20 10 20"]);
    // Y is not commanded and stays.
    assert_eq!(hole("", "G55"), ["r120 10 320", "120 10 305", "r120 10 320"]);
    assert_eq!(hole("G43 H0\n", "H1"), ["r20 10 70", "20 10 55", "r20 10 70"]);
    let last = |program: &str| ends(&format!("G0 G43 H1 Z50\n{program}")).pop();
    assert_eq!(last("G49 G53 Z90\nG91 G1 Z-5").as_deref(), Some("0 0 85"));
    assert_eq!(last("G1 X5\nG91 G28 Z0 G49").as_deref(), Some("r5 0 500"));
    assert_eq!(last("G49\nG91 G1 Z-5").as_deref(), Some("0 0 45"));
}

#[test]
fn safety_lines_and_look_ahead_are_words() {
    let safety = "G0 G17 G40 G49 G80 G90 G54\nX5\nG80 G1 Y5";
    assert_eq!(ends(safety), ["r5 0 0", "5 5 0"]);
    let look_ahead = "G5.1 Q1\nG05 P10000\nG8 P1\nG1 X5\nG5.1 Q0";
    let told = "look-ahead (G5, G5.1, G8) is switched on 3 times";
    assert!(notes(&control(), look_ahead).contains(told));
    // Words of the line of O are executed, each time.
    let called = ends("G0 X1\nM98 P2 L2\nM30\nO2 G91 X10\nG90 Y5\nM99");
    assert_eq!(called, ["r1 0 0", "r11 0 0", "r11 5 0", "r21 5 0"]);
}

/// Both directions, where start and end lie in one direction from the centre.
#[test]
fn an_arc_to_its_own_direction_is_a_full_circle() {
    for word in ["G2", "G3"] {
        let (circle, _) = arc(&format!("G1 X60 Y50\n{word} X60.005 Y50 I-10"));
        assert!((circle.sweep_rad.abs() - std::f64::consts::TAU).abs() < 1e-3, "{word}");
    }
}

#[test]
fn depths_of_a_cycle_are_read_in_the_mode_of_the_block_that_drills() {
    // RS274/NGC: the numbers of R and Z are modal, their meaning is that of the block.
    let program = "G0 Z100\nG91 G81 X0 Z-120 R-98\nG90 Y-25\nG80";
    let (steps, ran) = run_with(&control(), program).expect("a program");
    let bottoms: Vec<f64> =
        steps.iter().filter(|step| step.hole.is_some()).map(|step| step.to[2]).collect();
    assert_eq!(bottoms, [-118.0, -120.0]);
    assert!(ran.notes.iter().any(|note| note.contains("inside a cycle in line 3")));
}

#[test]
fn a_chip_breaking_cycle_is_fed_once() {
    assert_eq!(ends("G0 Z9\nG99 G73 X1 Z-6 R2 Q1.5\nG80")[2..], ["r1 0 2", "1 0 -6", "r1 0 2"]);
}

fn notes(setup: &Setup, program: &str) -> String {
    let (_, ran) = run_with(setup, program).expect("a program");
    ran.notes.join("\n")
}

#[test]
fn words_beside_g64_and_m_words_are_told() {
    assert_eq!(ends("G64 P0.05 Q0.02\nG1 X1"), ["1 0 0"]);
    assert!(notes(&control(), "G20\nG64 P.002\nG1 X1.").contains("up to 0.051 mm"));
    let program = "G1 X1.\nM19 P90\nM66 P1 L3 Q2.\nM8";
    assert!(notes(&control(), program).ends_with("M8 (1), M19 P (1), M66 L P Q (1)"));
    assert_eq!(ends("G91 G1\nM98 P7 L2 M8\nM30\nO7\nX1\nM99").len(), 2);
}

#[test]
fn a_colon_begins_a_program_as_o_does() {
    assert_eq!(ends("%\n:0100\nG91 G1\nM98 P7\nM30\n:7\nX1\nM99"), ["1 0 0"]);
    assert_eq!(refused("G1 X1:"), [(1, 6)]);
}

#[test]
fn g43_without_h_is_what_the_job_says() {
    assert_eq!(refused("G0\nG43 H1\nG43 Z1."), [(3, 1)]);
    let with = |g43_without_h| Setup { g43_without_h, ..control() };
    let tool = |setup: &Setup, program: &str| {
        let (steps, _) = run_with(setup, program).expect("a program");
        steps.last().and_then(|step| step.tool_mm)
    };
    let program = "G0 G43 H1 Z1.\nT2 M6\nG43 Z3.";
    assert_eq!(tool(&with(G43WithoutH::LastH), program), Some(50.0));
    assert_eq!(tool(&with(G43WithoutH::Tool), program), Some(80.0));
    let prepared = "G0 T1 M6\nT2\nG43 Z3.";
    assert_eq!(tool(&with(G43WithoutH::Tool), prepared), Some(50.0));
    assert!(run_with(&with(G43WithoutH::Tool), "G0 T1\nG43 Z3.").is_err());
}

#[test]
fn arcs_of_inch_programs_with_three_decimals_are_followed_and_told() {
    // A quarter of 0.7071 in: the ends miss the circle by 0.001 in = 0.02 mm.
    let arc = "G1 X1. Y0\nG3 X.5 Y.501 I-.5 J0";
    assert!(run_with(&control(), &format!("G21 {arc}")).is_ok());
    let inch = notes(&control(), &format!("G20 {arc}"));
    assert!(inch.contains("misses the circle by more than 0.01 mm: 1, most by 0.0254 mm in line 2; taken up to 0.072 mm"), "{inch}");
    let far = "G20 G1 X1. Y0\nG3 X.5 Y.503 I-.5 J0";
    assert_eq!(refused(far), [(2, 4)]);
    let wide = Setup { arc_mm: Some(0.1), ..control() };
    assert!(run_with(&wide, far).is_ok());
}

#[test]
fn turning_programs_are_refused_with_one_message() {
    for program in [
        "O1\nG50 S2000\nG0 X86. Z0.25\nG41 X1",
        "G0 X86. Z1.\nG96 S200 M3\nG1 X80. U1",
        "G50 X200. Z300.",
        "G0 X20. Z1.\nG1 Z0\nG3 X22. Z-1. I0 K-1.\nG1 Z-5.",
    ] {
        let problems = run_with(&control(), program).expect_err("it is refused");
        let messages: Vec<&str> = problems.iter().map(|p| p.message.as_str()).collect();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(messages[0].contains("turning"), "{messages:?}");
    }
    assert_eq!(ends("G50\nG97 S800\nG1 X1"), ["1 0 0"]);
}

#[test]
fn centres_that_fit_as_absolute_ones_are_told() {
    let problems =
        run_with(&control(), "G1 X10. Y5.\nG3 X0 Y15. I0 J5.").expect_err("it is refused");
    let help = problems.first().and_then(|p| p.help.clone());
    assert!(help.is_some_and(|help| help.contains("G90.1")));
}

#[test]
fn subprograms_are_called_and_repeated() {
    let program = "G91 G1\nM98 P7 L2\nX100\nM30\nO7\nX1\nM98 P8\nM99\nO8\nY1\nM99";
    assert_eq!(ends(program), ["1 0 0", "1 1 0", "2 1 0", "2 2 0", "102 2 0"]);
    assert_eq!(ends("G91 G1\nM98 P30007\nM30\nO7\nX1\nM99").len(), 3);
    assert_eq!(refused("M98 P9"), [(1, 1)]);
    assert_eq!(refused("M98 P1\nM30\nO1\nM98 P1\nM99"), [(4, 1)]);
}

#[test]
fn deletable_lines_are_executed_or_left_out() {
    let program = "G1 X1\n/X2\n/2 X3\nX4";
    assert_eq!(ends(program).len(), 4);
    let skip = Setup { skip_deletable: true, ..control() };
    assert_eq!(run_with(&skip, program).expect("a program").0.len(), 2);
}

#[test]
fn what_is_not_executed_is_refused_with_line_and_column() {
    for (program, place) in [
        ("G1 X#1", (1, 5)),
        ("G1\nX1 Y[1+2", (2, 5)),
        ("G41 D1", (1, 1)),
        ("G1 X1 A5", (1, 7)),
        ("X1", (1, 1)),
        ("G56 G1 X1", (1, 1)),
        ("G43 H9 Z1", (1, 5)),
        ("G1 X1\nG2 X2", (2, 4)),
        ("G1 X1\nG2 X2 I5", (2, 4)),
        ("G1 X1\nG2 X9 R1", (2, 4)),
        ("G1 X1 I5", (1, 7)),
        ("G0 G1 X1", (1, 4)),
        ("G87 X1 Z1 R1", (1, 1)),
        ("G81 X1", (1, 5)),
        ("G91 G53 X1 G0", (1, 5)),
        ("M198 P1", (1, 1)),
        ("G1 X1 X2", (1, 7)),
        ("G10 L20 P1 X1", (1, 5)),
        ("G28", (1, 1)),
        ("G1 X1\nO5", (2, 1)),
        ("G1 X99999999", (1, 4)),
    ] {
        assert!(refused(program).contains(&place), "{program:?}: {:?}", refused(program));
    }
}

#[test]
fn coordinates_without_a_point_are_told() {
    let increments = Setup { without_point: WithoutPoint::Increment, ..control() };
    let (steps, ran) = run_with(&increments, "G1 X100\nY1.").expect("a program");
    assert!(near(steps[1].to, [0.1, 1.0, 0.0]));
    assert!(
        ran.notes[0].starts_with("coordinates without a decimal point: 1, the first in line 1; ")
    );
}
