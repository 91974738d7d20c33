//! Variables, expressions, jumps, and the words of Siemens.

use super::*;

fn last(program: &str) -> String {
    ends(program).last().cloned().unwrap_or_default()
}

fn siemens() -> Setup {
    let systems = [(0, [0.0; 3]), (1, [100.0, 0.0, 0.0]), (505, [0.0, 7.0, 0.0])];
    Setup { language: Language::Siemens, systems: BTreeMap::from(systems), ..control() }
}

/// Ends of the moves of a Siemens program, `r` before those of rapid ones.
fn ends_of_siemens(program: &str) -> Vec<String> {
    let (moves, _) = run_with(&siemens(), program).expect("a program");
    let show = |step: &Move| {
        let [x, y, z] = step.to.map(|mm| (mm * 1e6).round() / 1e6 + 0.0);
        format!("{}{x} {y} {z}", if step.rapid { "r" } else { "" })
    };
    moves.iter().map(show).collect()
}

/// What is said of a program that is refused, with its first place.
fn why(setup: &Setup, program: &str) -> (String, (usize, usize)) {
    let problems = run_with(setup, program).expect_err(program);
    let first = problems.first().expect("a problem");
    (first.message.clone(), place(first).unwrap_or_default())
}

#[test]
fn expressions_have_the_values_that_are_calculated_by_hand() {
    for (expression, value) in [
        ("[1+2*3]", 7.0),
        ("[[1+2]*3]", 9.0),
        ("[10-4-3]", 3.0),
        ("[24/4/2]", 3.0),
        ("[2**3*2]", 16.0),
        ("[7 MOD 4 * 2]", 6.0),
        ("-[1-3]", 2.0),
        ("[2*-3]", -6.0),
        ("[SIN[30]*4]", 2.0),
        ("[ATAN[3]/[3]]", 45.0),
        ("[sqrt[9]+abs[-1]]", 4.0),
        ("[FIX[2.9]+FUP[2.1]]", 5.0),
        ("[ROUND[2.5]]", 3.0),
        ("[1 LT 2]", 1.0),
        ("[1 EQ 2]", 0.0),
        ("[7 MOD 4]", 3.0),
    ] {
        let program = format!("#1 = {expression}\nG1 X1 Y#1 Z1");
        assert_eq!(last(&program), format!("1 {value} 1"), "{expression}");
    }
}

#[test]
fn variables_stand_for_numbers() {
    assert_eq!(last("#1=1 #2=3 (both)\nG#1 X-#1 Y#2\nG1 X##1"), "1 3 0");
    assert_eq!(last("#<Deep Hole>=4.5\n#100=#<deephole>\nG1 Z[-#100*2]"), "0 0 -9");
    assert_eq!(last("G20\n#1=1\nG1 X#1"), "25.4 0 0");
    let increments = Setup { without_point: WithoutPoint::Increment, ..control() };
    let (moves, _) = run_with(&increments, "#1=7\nG1 X#1").expect("a program");
    assert!(near(moves[0].to, [7.0, 0.0, 0.0]), "a variable is in mm");
}

#[test]
fn what_has_no_value_is_refused_with_its_place() {
    for (program, words, place) in [
        ("G1 X#1", "`#1` has no value", (1, 5)),
        ("#1=#5021", "`#5021` is a variable of the control", (1, 4)),
        ("#5221=3", "setting it may move zeros or axes", (1, 1)),
        ("#1=[1/0]", "division by zero", (1, 6)),
        ("#1=SQRT[-1]", "`SQRT` of -1 has no value", (1, 4)),
        ("#1=[2**0.5]", "`**` with the exponent 0.5", (1, 6)),
        ("#1=[-7 MOD 4]", "controls differ in the sign of the rest", (1, 8)),
        ("#1=FIX[-2.5]", "`FIX` of the negative number -2.5", (1, 4)),
        ("#1=ATAN[-1]/[1]", "`ATAN` is -45° or 315°", (1, 4)),
        ("#1=[[1 EQ 1] AND [2 EQ 2]]", "`AND` is not executed", (1, 14)),
        ("#1=0.3\n#2=FIX[#1/0.1]", "`FIX` of a number that rounding", (2, 4)),
        ("#1=FUP[0.28*100]", "`FUP` of a number that rounding", (1, 4)),
        ("#1=[0.3 MOD 0.1]", "`MOD` of a number that rounding", (1, 9)),
        ("#1=[0.1+0.2]\n#2=[#1 LT 0.3]", "rounding decides", (2, 8)),
        ("#1=[1.00001 EQ 1]", "rounding decides", (1, 13)),
        ("#1=1\nG1 X[ROUND[#1]]", "`ROUND` in a word", (2, 6)),
        ("#1=1 #2=#1", "`#1` is set in the same block", (1, 9)),
        ("#1=1 G1 X2", "something stands behind the statement", (1, 6)),
        ("#1=[1+2", "the bracket is not closed", (1, 4)),
        ("#1=BIN[3]", "`BIN` is not executed in expressions", (1, 4)),
        ("#1=1+", "lacks a number", (1, 5)),
        ("IF [3] GOTO 1", "the condition has the value 3", (1, 4)),
        ("GOTO 7", "N7 is not in the program", (1, 1)),
        ("END1", "DO1 is not in the program", (1, 1)),
        ("O1 while [1 EQ 1]", "a word behind `O…` is not executed", (1, 1)),
        ("N1 o<hole> call [1]", "a word behind `O…`", (1, 4)),
        ("IF [1 EQ 1] THEN G1 X1", "only a variable is set behind `THEN`", (1, 13)),
    ] {
        let (said, at) = why(&control(), program);
        assert!(said.contains(words), "{program:?}: {said}");
        assert_eq!(at, place, "{program:?}: {said}");
    }
    let deep = format!("#1={}1{}", "[".repeat(40), "]".repeat(40));
    assert!(why(&control(), &deep).0.contains("more than 32 brackets"));
}

#[test]
fn loops_and_jumps_of_fanuc() {
    let count = "G91 G1\n#1=0\nWHILE [#1 LT 3] DO1\n#1=#1+1\nX1\nEND1\nY1";
    assert_eq!(last(count), "3 1 0");
    let said = "G91 G1\n#1=0\nWHILE [#1 LT 3] DO1 (DO IT)\n#1=#1+1\nX1\nEND1";
    assert_eq!(last(said), "3 0 0");
    let nested = "G91 G1\n#1=0\nWHILE[#1LT2]DO1\n#2=0\nWHILE[#2LT3]DO2\nX1\n#2=#2+1\nEND2\nY1\n#1=#1+1\nEND1";
    assert_eq!(last(nested), "6 2 0");
    let jump = "G91 G1\n#1=5\nN10 X1\n#1=#1-1\nIF [#1 GT 0] GOTO 10\nGOTO 30\nX100\nN30 Y1";
    assert_eq!(last(jump), "5 1 0");
    let then = "#1=4\nIF [#1 EQ 4] THEN #2=7\nIF [#1 EQ 5] THEN #2=9\nG1 X#2";
    assert_eq!(last(then), "7 0 0");
    // N counts in its own program only.
    let scope = "G91 G1\nM98 P7\nGOTO 10\nX100\nN10 Y1\nM30\nO7\nGOTO 10\nX100\nN10 X1\nM99";
    assert_eq!(ends(scope), ["1 0 0", "1 1 0"]);
    // What is not gone to is not executed; words of LinuxCNC begin no program.
    assert_eq!(last("G91 G1\nGOTO 10\no5 call\nN10 X1\nM30\no5 sub\no5 endsub"), "1 0 0");
    let twice = why(&control(), "GOTO 10\nN10 G1 X1\nN10 X2").0;
    assert!(twice.contains("N10, which is given twice"), "{twice}");
}

#[test]
fn words_of_siemens_are_executed() {
    let program = "R1=4\nG1 X=IC(5) Y=2*(1+2) ; X9\nG91 X1 Y=AC(1) Z=-R1/2";
    assert_eq!(ends_of_siemens(program), ["5 6 0", "6 1 -2"]);
    let arc = "G1 X1\nG3 X0 Y1 CR=-1\nG2 X=IC(2) Y1 I=AC(1) J0";
    assert_eq!(ends_of_siemens(arc), ["1 0 0", "0 1 0", "2 1 0"]);
    assert_eq!(ends_of_siemens("%_N_A_MPF\n/1 N10 G1X5Y6F100 S2=30\nRET\nX9"), ["5 6 0"]);
}

#[test]
fn tolerances_of_siemens_are_told() {
    let tolerance = |program| notes(&siemens(), program);
    assert!(tolerance("CYCLE832(0.05,_FINISH,1)\nG1 X1").contains("up to 0.050 mm"));
    assert!(tolerance("G1 X1 ADIS=0.2").contains("up to 0.200 mm"));
    assert!(!tolerance("MSG(\"(5)\")\nG1 X1").contains("leave the path"));
}

#[test]
fn zeros_of_siemens() {
    let program = "R1=2\nG1 X1\nTRANS X10 Y=R1\nX1 Y0\nATRANS X5\nX1\nTRANS Y1\nX1 Y1\nG54 X0\nG505 Y0\nTRANS\nG500 X0 Y0";
    let expected = ["1 0 0", "11 2 0", "16 2 0", "1 2 0", "100 2 0", "100 8 0", "0 0 0"];
    assert_eq!(ends_of_siemens(program), expected);
    // D1 is active behind M6; G53 and SUPA leave the zeros out, but not the length.
    let tool = "G54 G0 Z10\nT1 M6\nZ10\nT=\"DRILL\"\nM6\nZ0\nG53 Z5\nSUPA Z0 D0\nD1 Z1";
    assert_eq!(
        ends_of_siemens(tool),
        ["r0 0 10", "r0 0 60", "r0 0 80", "r0 0 85", "r0 0 0", "r0 0 81"]
    );
}

#[test]
fn cycles_of_siemens() {
    let program = "G0 Z30\nMCALL CYCLE81(20,0,2,-8)\nX5\nMCALL\nX6\nCYCLE83(25,,1)";
    assert!(why(&siemens(), program).0.contains("lacks RTP or RFP"));
    let program = "G0 Z30\nMCALL CYCLE81(20,0,2,-8,5)\nX5\nTRANS X1\nMCALL ; ended\nX6\nCYCLE82(20,0,2,-3,,1)";
    assert_eq!(
        ends_of_siemens(program),
        [
            "r0 0 30", "r5 0 30", "r5 0 2", "5 0 -5", "r5 0 2", "r5 0 20", "r7 0 20", "r7 0 2",
            "7 0 -3", "r7 0 2", "r7 0 20"
        ]
    );
}

#[test]
fn what_is_not_executed_of_siemens_is_refused_by_name() {
    for (program, words, place) in [
        ("G1 X5 (X6)", "a sign that begins no word", (1, 7)),
        ("IF R1==5 GOTOF END", "`IF` is not executed", (1, 1)),
        ("G1 X5 AR=30", "`AR` is not executed", (1, 7)),
        ("ROT Z30", "`ROT` is not executed", (1, 1)),
        ("TRAORI", "`TRAORI` is not executed", (1, 1)),
        ("G110 X1", "`G110` is not executed", (1, 1)),
        ("G58 X1", "`G58` is not executed", (1, 1)),
        ("G41 X1", "`G41` is not executed", (1, 1)),
        ("G1 X1=5", "`X1=` is not executed", (1, 4)),
        ("G1 X=DC(5)", "`DC( )` is not executed", (1, 4)),
        ("G1 F=IC(5)", "`IC( )` is executed with X, Y, Z", (1, 4)),
        ("G1 X=R5", "`R5` has no value", (1, 6)),
        ("G1 X=A+1", "`A` is not executed in expressions", (1, 6)),
        ("L100 P2", "`L100` calls a subprogram", (1, 1)),
        ("POCKET3(1,2)", "`POCKET3` is not executed", (1, 1)),
        ("MCALL HOLES1(1)", "`HOLES1` is not executed", (1, 7)),
        ("CYCLE81(5,0,1,-3,,0,1)", "first 5 arguments", (1, 1)),
        ("CYCLE81(5,0,1,-3) X5", "words beside the call of a cycle", (1, 1)),
        ("CYCLE81(5,9,1,-3)", "not in the order RTP", (1, 1)),
        ("G70\nCYCLE81(5,0,1,-3)", "G70 or G700", (2, 1)),
        ("G55 G1 X1", "the zero of G55", (1, 1)),
        ("D1", "no T and M6 changed a tool in", (1, 1)),
        ("T1 M6\nD2", "`D2` is not executed", (2, 1)),
        ("T=\"X\"", "the length of tool `X` is not known", (1, 1)),
        ("T7\nM6", "the length of tool T7 is not known", (2, 1)),
        ("T1 M6\nG18 G1 X5", "a tool length with G18", (2, 8)),
        ("M98 P5", "`M98` is not executed in Siemens programs", (1, 1)),
        ("MSG(\"a\"", "the brackets of the call are not closed", (1, 1)),
        ("R1=5 X10", "something stands behind the statement", (1, 6)),
    ] {
        let (said, at) = why(&siemens(), program);
        assert!(said.contains(words), "{program:?}: {said}");
        assert_eq!(at, place, "{program:?}: {said}");
    }
}

/// Texts of these letters.
fn texts_of(letters: &str) -> impl Strategy<Value = String> {
    let letter = prop::sample::select(letters.chars().collect::<Vec<_>>());
    prop::collection::vec(letter, 0..=120).prop_map(|letters| letters.into_iter().collect())
}

proptest! {
    #[test]
    fn no_text_brings_the_languages_down(
        text in texts_of("GXYZRDONWHILESUBMCATFPJKQV0123456789#<>=+*/.,;%:([]) \n-"),
    ) {
        let _ = run_with(&control(), &text);
        let _ = run_with(&siemens(), &text);
    }
}
