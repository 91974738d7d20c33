use super::*;
use crate::control::controller::ControlUnit;
use crate::control::table::siemens::{MachineDatum, MachineValue, Place, SiemensTable};

/// A complete small LEC table; `{}` stands for more lines.
const LEC: &str = "$AA_ENC_COMP[1,0,AX1]=0.001
$AA_ENC_COMP[1,1,AX1]=0.002
$AA_ENC_COMP[1,2,AX1]=0.0
$AA_ENC_COMP_STEP[1,AX1]=50
$AA_ENC_COMP_MIN[1,AX1]=-50.0
$AA_ENC_COMP_MAX[1,AX1]=50.0
$AA_ENC_COMP_IS_MODULO[1,AX1]=0
";
const LEC_FILE: &str = "$AA_ENC_COMP[1,0,AX1]=0.001
$AA_ENC_COMP[1,1,AX1]=0.002
$AA_ENC_COMP[1,2,AX1]=0.0
$AA_ENC_COMP_STEP[1,AX1]=50
$AA_ENC_COMP_MIN[1,AX1]=-50.0
$AA_ENC_COMP_MAX[1,AX1]=50.0
$AA_ENC_COMP_IS_MODULO[1,AX1]=0
M17
";
const CEC: &str = "$AN_CEC[0,0]=0.001
$AN_CEC[0,1]=0.002
$AN_CEC_INPUT_AXIS[0]=(AX1)
$AN_CEC_OUTPUT_AXIS[0]=(AX2)
$AN_CEC_STEP[0]=50.0
$AN_CEC_MIN[0]=0.0
$AN_CEC_MAX[0]=50.0
$AN_CEC_DIRECTION[0]=0
$AN_CEC_MULT_BY_TABLE[0]=0
$AN_CEC_IS_MODULO[0]=0
";

fn contents(text: &str) -> SiemensContents {
    read("test.mpf", text).unwrap_or_else(|problems| panic!("{text}\n{problems}"))
}

fn messages(text: &str) -> Vec<String> {
    let problems = read("test.mpf", text).expect_err(text);
    for problem in problems.iter() {
        assert!(problem.place.is_some() && problem.help.is_some(), "{problem:?}");
    }
    problems.iter().map(|p| p.message.clone()).collect()
}

/// What is refused: text, place (line:column), part of the message.
#[test]
fn each_flaw_is_refused_at_its_place() {
    let end = "M30\n";
    let lec = |from: &str, to: &str| format!("{}{end}", LEC.replacen(from, to, 1));
    let cec = |from: &str, to: &str| format!("{}{end}", CEC.replacen(from, to, 1));
    let step = "$AA_ENC_COMP_STEP[1,AX1]=50\n";
    let with = |line: &str| lec(step, &format!("{line}{step}"));
    let cases = [
        (lec("=0.001", "=0,001"), "1:23", "decimal comma"),
        (lec("]=0.001", "] 0.001"), "1:23", "`=` is missing"),
        (lec("=0.001", "=1EX-3"), "1:23", "exponent"),
        (lec("=0.001", "=1e-3"), "1:23", "exponent"),
        (lec("=0.001", "=n/a"), "1:23", "is not a value"),
        (lec("=0.001", "="), "1:23", "value is missing"),
        (lec("=0.001", "=-"), "1:23", "is not a number"),
        (lec("=0.001", "=0.001.2"), "1:23", "is not a number"),
        (lec("=0.001", "=0.001+1"), "1:28", "follows a complete statement"),
        (lec("=0.001", "=0.001 M30"), "1:29", "follows a complete statement"),
        (lec("=0.001", "=(AX1)"), "1:23", "cannot have this value"),
        (lec("ENC_COMP[1,0", "ENC_KOMP[1,0"), "1:1", "unknown variable"),
        (lec("$AA_ENC_COMP[1,0", "$AC_TIMER[1,0"), "1:1", "unknown variable"),
        (lec("[1,0,AX1]", "[1.0,AX1]"), "1:15", "`,` or `]`"),
        (lec("[1,0,AX1]", "1,0,AX1]"), "1:14", "`=` is missing"),
        (lec("[1,0,AX1]", "[1,AX1]"), "1:1", "is not an index"),
        (lec("[1,0,AX1]", "[2,0,AX1]"), "1:1", "is not an index"),
        (lec("[1,0,AX1]", "[1,-1,AX1]"), "1:16", "a number or an axis"),
        (with("G0 X100\n"), "4:1", "does not belong here"),
        (with("X100\n"), "4:1", "does not belong here"),
        (with("N40 G1 F500\n"), "4:5", "does not belong here"),
        (with("M3\n"), "4:1", "does not belong here"),
        (with("/NEWCONF\n"), "4:1", "does not belong here"),
        (with("CHANDATA\n"), "4:9", "channel number"),
        (with("chandata( 02 )\n"), "4:9", "`CHANDATA(2)` names another channel"),
        (with("GOTOF END\n"), "4:1", "does not belong here"),
        (with("IF R1==0\n"), "4:1", "does not belong here"),
        (with("CALL \"X\"\n"), "4:1", "does not belong here"),
        (with("; a note\u{2028}\n"), "4:9", "character U+2028"),
        (with("; \u{202e}\n"), "4:3", "character U+202E"),
        (lec("$AA", "\u{feff}$AA"), "1:1", "character U+FEFF"),
        (lec("$AA", "\0$AA"), "1:1", "control character U+0000"),
        (lec("\n", "\r"), "1:28", "control character U+000D"),
        (with("%_N_AX_EEC_INI\n"), "4:1", "first line"),
        (with("$AA_ENC_COMP_STEP[1,AX1]=5\u{b5}\n"), "4:27", "not an ASCII"),
        (with("; \u{7}\n"), "4:3", "control character U+0007"),
        (lec("=0\n", "=-1\n"), "7:31", "cannot have this value"),
        (lec("=0\n", "=2\n"), "7:31", "cannot have this value"),
        (lec("=50\n", "=0\n"), "4:26", "must be greater than 0"),
        (lec("=50\n", "=-50\n"), "4:26", "must be greater than 0"),
        (lec("=50\n", "=49\n"), "4:26", "expected a whole number"),
        (lec("=50\n", "=300\n"), "4:26", "expected a whole number"),
        (lec("=50\n", "=0.0001\n"), "4:26", "would have 1000000 points"),
        (lec("=50.0\n", "=-50.0\n"), "6:25", "not greater than MIN"),
        (lec(step, ""), "1:1", "STEP of $AA_ENC_COMP[1,AX1] is missing"),
        (lec("$AA_ENC_COMP_MIN[1,AX1]=-50.0", ""), "1:1", "MIN of"),
        (lec("$AA_ENC_COMP_MAX[1,AX1]=50.0", ""), "1:1", "MAX of"),
        (lec("[1,2,", "[1,3,"), "3:23", "has point 3"),
        (cec("$AN_CEC_INPUT_AXIS[0]=(AX1)\n", ""), "1:1", "INPUT_AXIS of"),
        (cec("$AN_CEC_OUTPUT_AXIS[0]=(AX2)\n", ""), "1:1", "OUTPUT_AXIS of"),
        (cec("=(AX1)", "=AX1"), "3:23", "is not a value"),
        (cec("=(AX1)", "=(AX1"), "3:23", "is not an axis name"),
        (cec("=(AX1)", "=1"), "3:23", "cannot have this value"),
        (cec("DIRECTION[0]=0", "DIRECTION[0]=2"), "8:22", "cannot have this value"),
        (cec("DIRECTION[0]=0", "DIRECTION[0]=0.5"), "8:22", "cannot have this value"),
        (cec("TABLE[0]=0", "TABLE[0]=-1"), "9:26", "cannot have this value"),
        (cec("IS_MODULO[0]=0", "TYPE[0]=1"), "10:17", "cannot have this value"),
        (cec("IS_MODULO[0]=0", "INPUT_NCU[0]=2"), "10:22", "cannot have this value"),
        (cec("IS_MODULO[0]=0", "OUTPUT_NCU[0]=-1"), "10:23", "cannot have this value"),
        (cec("IS_MODULO[0]=0", "INPUT_NCU[0]=TRUE"), "10:22", "cannot have this value"),
        (cec("IS_MODULO[0]=0", "OUTPUT_NCU[0]=FALSE"), "10:23", "cannot have this value"),
        (format!("{LEC}M30\nNEWCONF\n"), "9:1", "follows the end word"),
        (format!("{LEC}M30\n$AA_ENC_COMP[1,0,AX1]=0\n"), "9:1", "follows the end word"),
        (LEC.to_string(), "8:1", "no end word"),
        (String::new(), "1:1", "no end word"),
        (format!("%_N_TOO LONG_INI\n{LEC}M17"), "1:1", "header"),
        (format!("%_N_A_INI\n;$PATH=/_N_WKS_DIR/_N_A_WPD\n{LEC}M17"), "2:1", "active data"),
        (format!("$MA_ENC_COMP_ENABEL[1,AX1]=1\n{LEC}M17"), "1:1", "unknown variable"),
        (format!("$MA_ENC_COMP_ENABLE[1,AX1]=1\n{LEC}M17"), "2:1", "alarm 17070"),
        (format!("$SN_CEC_TABLE_WEIGHT[0]=TRUE\n{CEC}M17"), "1:25", "cannot have this value"),
        (format!("$MA_CEC_ENABLE[AX2]=1\n{CEC}M17"), "5:1", "alarm 17070"),
    ];
    for (text, place, message) in cases {
        let problems = read("test.mpf", &text).expect_err(&text);
        assert_eq!(problems.iter().count(), 1, "{text}\n{problems}");
        let problem = problems.iter().next().expect("one problem");
        let found = problem.place.as_ref().expect("a place");
        assert!(problem.message.contains(message), "{message}: {problem:?}");
        assert_eq!(format!("{}:{}", found.line, found.column), place, "{text}\n{problems}");
        assert!(problem.help.is_some(), "{problem:?}");
    }
}

#[test]
fn all_problems_of_a_file_are_told_in_its_order() {
    let text = format!("G0 X1\n{}{}", LEC.replace("=0.002", "=0,002"), CEC.replace("=50.0", "=0"));
    let found = messages(&text);
    assert_eq!(found.len(), 4, "{found:#?}");
    for (message, part) in found.iter().zip(["G0", "comma", "STEP", "end word"]) {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_binary_file_gives_a_bounded_list() {
    assert_eq!(messages(&"\u{1}\n".repeat(5000)).len(), 1);
}

/// Structure of the file: Function Manual Extended Functions 03/2013, K3 p. 242; `$PATH` from
/// HMI Advanced Operator's Guide 03.04.
#[test]
fn program_form_and_data_form_are_the_same_tables() {
    let program = contents(&format!("{LEC}{CEC}M30\n"));
    let data =
        contents(&format!("%_N_NC_CEC_INI\n;$PATH=/_N_NC_ACT_DIR\nCHANDATA(1)\n{LEC}{CEC}M17\n"));
    assert_eq!(program, data);
    assert_eq!(program.tables.tables[0].values, [Some(0.001), Some(0.002), Some(0.0)]);
    assert_eq!(program.tables.tables[1].direction, None);
    assert!(program.notes.is_empty(), "{:?}", program.notes);
    assert!(program.unwritten.is_empty(), "{:?}", program.unwritten);
}

#[test]
fn forms_that_a_control_accepts_are_accepted() {
    let plain = contents(&format!("{LEC}{CEC}M30\n"));
    let both = format!("{LEC}{CEC}");
    let numbered: String = both.lines().map(|line| format!("N10 {line}\n")).collect();
    let forms = [
        both.replace('\n', "\r\n") + "M30\r\n",
        both.to_lowercase() + "m17",
        both.replace('[', " [ ").replace(']', " ]\t").replace('=', " = ") + "M2",
        both.replace('\n', " ; \u{b5}m comment\n") + "M02 ; end\n\n  \n; after\n",
        both.replace("(AX1)", "\"AX1\"").replace("(AX2)", "( AX2 )") + "  M30",
        numbered + "N20 M30",
        both.replace("]=0\n", "]=FALSE\n")
            .replace("DIRECTION[0]=FALSE", "DIRECTION[0]=0")
            .replace("TABLE[0]=FALSE", "TABLE[0]=+0.0")
            + "M30",
        both.replace("=0.001\n", "=9\n") + &both + "STOPRE\nNEWCONF\nM30",
        both + "$AN_CEC_TYPE[0]=0\n$AN_CEC_INPUT_NCU[0]=0\n$AN_CEC_OUTPUT_NCU[0]=1\nM30",
    ];
    for text in forms {
        assert_eq!(contents(&text), plain, "{text}");
    }
}

#[test]
fn parameters_that_no_line_writes_and_stops_are_told() {
    let text = CEC.replace("$AN_CEC_DIRECTION[0]=0\n", "M0\n");
    let contents = contents(&(text + "M17"));
    assert_eq!(contents.tables.tables[0].direction, None);
    assert_eq!(contents.unwritten, ["DIRECTION of $AN_CEC[0]"]);
    assert!(contents.notes[0].to_string().contains("M0 waits"), "{:?}", contents.notes);
}

/// As a real control writes them: points behind MAX, MAX between two points, tables that nobody filled.
#[test]
fn a_control_may_write_more_than_acts() {
    let held = |text: &str| super::read_out("eec.ini", &format!("{text}M17\n"), false).unwrap();
    let reserved = format!("{LEC}$AA_ENC_COMP[1,3,AX1]=0.009\n$AA_ENC_COMP[1,4,AX1]=0\n");
    assert_eq!(held(&reserved).tables, held(LEC).tables);
    assert!(!messages(&format!("{reserved}M17\n")).is_empty());
    let grid = held(LEC).tables.tables[0].grid;
    let open = |points: &str| {
        let max = grid.max + grid.step / 2.0;
        let text = format!("{LEC}$AA_ENC_COMP_MAX[1,AX1]={max}\n{points}");
        held(&text).tables.tables[0].clone()
    };
    let without = open("");
    assert_eq!((without.values.len(), without.grid.is_whole()), (3, false));
    let with = open("$AA_ENC_COMP[1,3,AX1]=0.004\n$AA_ENC_COMP[1,4,AX1]=7\n");
    assert_eq!(with.values.len(), 4);
    let closed = |table: &SiemensTable| {
        let mut table = table.clone();
        let end = table.close();
        (table, end)
    };
    let (table, end) = closed(&with);
    assert_eq!((table.grid, table.values.len()), (grid, 3));
    assert_eq!(end.map(|end| (end.point, end.differs_by)), Some((2, Some(0.002))));
    assert_eq!(closed(&without).1.unwrap().differs_by, None);
    assert_eq!(closed(&held(LEC).tables.tables[0]).1, None);
    let empty = "$AN_CEC[8,0]=0\n$AN_CEC_STEP[8]=10\n$AN_CEC_MIN[8]=5\n$AN_CEC_MAX[8]=5\n";
    assert_eq!(held(empty).idle, ["AN_CEC[8]"]);
    let filled = format!("{}M17\n", empty.replace("[8,0]=0", "[8,0]=0.1"));
    assert!(super::read_out("cec.ini", &filled, false).is_err());
}

/// 802D sl Function Manual 11/2012: a point left out keeps what the control holds.
#[test]
fn a_point_left_out_is_missing_and_not_zero() {
    let contents = contents(&(LEC.replace("$AA_ENC_COMP[1,1,AX1]=0.002\n", "") + "M30"));
    assert_eq!(contents.tables.tables[0].values, [Some(0.001), None, Some(0.0)]);
}

/// A generated file of a public archive tool: 770 / 19.7436 = 38.99998.
#[test]
fn a_rounded_step_is_tolerated() {
    let text =
        LEC.replace("=50\n", "=19.7436\n").replace("=-50.0", "=-215").replace("=50.0", "=555");
    assert_eq!(contents(&(text + "M30")).tables.tables[0].values.len(), 40);
}

#[test]
fn tables_come_back_in_order() {
    let lec = format!("{}{}{LEC}", LEC.replace("AX1", "AX2"), LEC.replace("[1,", "[0,"));
    let cec = format!("{}{CEC}", CEC.replace("CEC[0", "CEC[7").replace("S[0]", "S[7]"));
    let cec = cec.replacen("$AN_CEC_STEP[0]", "$AN_CEC_STEP[7]", 1);
    let cec = cec.replacen("$AN_CEC_MIN[0]", "$AN_CEC_MIN[7]", 1);
    let cec = cec.replacen("$AN_CEC_MAX[0]", "$AN_CEC_MAX[7]", 1);
    let tables = contents(&(lec + &cec + "M30")).tables;
    let lec = [("AX1", 0), ("AX1", 1), ("AX2", 1)];
    let lec = lec.map(|(axis, encoder)| Place::Lec { axis: axis.to_string(), encoder });
    let order = lec.into_iter().chain([0, 7].map(Place::Cec));
    assert!(tables.tables.iter().map(|table| table.place.clone()).eq(order));
}

/// A line in the style of `%_N_COMPLETE_TEA_INI`.
#[test]
fn machine_data_keep_their_last_value() {
    let text = "N38000 $MA_MM_ENC_COMP_MAX_POINTS[1,AX1]=26\n$MA_ENC_COMP_ENABLE[1,AX1]=0\n\
                NEWCONF\n$ma_enc_comp_enable[01,ax1]=TRUE\nM30\n";
    let datum = |name: &str, value| MachineDatum {
        variable: format!("${name}[1,AX1]"),
        value: MachineValue::Number(value),
    };
    let expected = [datum("MA_MM_ENC_COMP_MAX_POINTS", 26.0), datum("MA_ENC_COMP_ENABLE", 1.0)];
    assert_eq!(contents(text).tables.data, expected);
}

fn merged(texts: &[String]) -> Result<SiemensContents, Problems> {
    merge(texts.iter().map(|text| contents(&format!("{text}M30\n"))).collect())
}

#[test]
fn files_of_a_kit_make_one_memory() {
    let first = LEC.replace("$AA_ENC_COMP[1,1,AX1]=0.002\n", "");
    let all = merged(&[CEC.to_string(), first, LEC.to_string()]).expect("no conflict");
    assert_eq!(all.tables, contents(&format!("{LEC}{CEC}M30")).tables);
}

#[test]
fn conflicting_files_are_refused() {
    let memory = |points| format!("$MA_MM_ENC_COMP_MAX_POINTS[1,AX1]={points}\n");
    let cases = [
        (LEC.to_string(), LEC.replace("=0.002", "=0.003"), "point 1 of $AA_ENC_COMP[1,AX1]"),
        (LEC.to_string(), LEC.replace("50", "60"), "parameters of $AA_ENC_COMP[1,AX1]"),
        (LEC.to_string(), LEC.replace("=0\n", "=1\n"), "parameters of $AA_ENC_COMP[1,AX1]"),
        (CEC.to_string(), CEC.replace("=0.002", "=0.003"), "point 1 of $AN_CEC[0]"),
        (CEC.to_string(), CEC.replace("ION[0]=0", "ION[0]=1"), "parameters of $AN_CEC[0]"),
        (CEC.to_string(), CEC.replace("AX2", "AX3"), "parameters of $AN_CEC[0]"),
        (memory(26), memory(27), "$MA_MM_ENC_COMP_MAX_POINTS[1,AX1]"),
    ];
    for (first, second, message) in cases {
        let problems = merged(&[first, second]).expect_err(message);
        assert!(problems.render().contains(message), "{message}: {problems}");
    }
}

#[test]
fn a_switch_may_be_changed_by_a_later_file() {
    let switch = |on| format!("$MA_ENC_COMP_ENABLE[1,AX1]={on}\n");
    let all = merged(&[switch(0), switch(1)]).expect("no conflict");
    assert_eq!(all.tables.data[0].value, MachineValue::Number(1.0));
}

/// What a control wrote, as a file of active data, with programs beside them.
fn held(text: &str) -> SiemensContents {
    super::read_out("all.txt", text, false).unwrap_or_else(|problems| panic!("{text}\n{problems}"))
}

#[test]
fn of_several_sections_what_is_of_concern_is_read_at_its_place() {
    let text = "%_N_NC_TEA_INI\nCHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\n\
                N32450 $MA_BACKLASH[0,AX1]=0.005\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n\
                %_N_NC_CEC_INI\nMETRIC\n$AN_CEC_STEP[3]=0\n$AN_CEC_INPUT_AXIS[3]=(\n$AN_CEC[3,0]=0\nM17\n";
    let found = held(text);
    let data = found.tables.data.iter().map(|datum| datum.variable.as_str());
    assert_eq!(data.collect::<Vec<_>>(), ["$MA_BACKLASH[0,AX1]", "$MN_SCALING_SYSTEM_IS_METRIC"]);
    assert_eq!(found.passed_over, 1);
    assert_eq!(found.tables.reserved, ["AN_CEC[3]"]);
    assert_eq!(found.units, [ControlUnit::Millimetre]);
    let wrong = text.replace("=0.005", "=0,005");
    let problems = super::read_out("all.txt", &wrong, false).expect_err("a comma");
    let place = problems.iter().next().and_then(|p| p.place.clone()).unwrap();
    assert_eq!((place.line, place.column), (4, 28));
}

#[test]
fn line_checksums_are_passed_over() {
    let text = "N32450 $MA_BACKLASH[0,AX1]=0.005 '2F34\n$AN_CEC_STEP[3]=0 'ab01 ;later\n\
                $MA_CEC_MAX_SUM[AX1]=0.001 '00FF\r\nM17\n";
    let found = held(text);
    assert_eq!(found.tables.data[0].value, MachineValue::Number(0.005));
    assert_eq!(found.tables.data[1].value, MachineValue::Number(0.001));
    assert_eq!(found.tables.reserved, ["AN_CEC[3]"]);
    let three_digits = text.replace("'00FF", "'00F");
    assert!(super::read_out("all.txt", &three_digits, false).is_err());
}

#[test]
fn a_program_beside_active_data_is_no_state() {
    let data = format!("%_N_AX_EEC_INI\n{LEC}M17\n");
    let other = LEC.replace("=0.002", "=0.016");
    let program = format!("%_N_NEW_MPF\n;$PATH=/_N_MPF_DIR\nG0 X1\n{other}M30\n");
    for text in [format!("{data}{program}"), format!("{program}{data}")] {
        let found = held(&text);
        assert_eq!(found.tables, held(LEC_FILE).tables);
        assert_eq!(found.programs, ["NEW_MPF"]);
        assert!(found.programs_write_tables && found.twice.is_empty());
        assert!(has_active_data("all.txt", &text));
    }
    assert!(!has_active_data("new", &program));
    assert!(held(&program).tables.tables.is_empty(), "and no end is missed");
    let read = super::read_out("new", &program, true).unwrap();
    assert_eq!(read.tables.tables[0].values[1], Some(0.016));
    assert!(has_active_data("eec.txt", LEC_FILE));
    assert!(!has_active_data("EEC.MPF", LEC_FILE));
    assert_eq!(super::read_out("EEC.MPF", LEC_FILE, false).unwrap().programs, ["EEC.MPF"]);
    let workpiece = "%_N_INIT_INI\n;$PATH=/_N_WKS_DIR/_N_A_WPD\n$MA_BACKLASH[0,AX1]=1\nM17\n";
    assert!(!has_active_data("all.txt", workpiece));
}

#[test]
fn two_values_of_one_variable_are_told() {
    let text = "$MA_CEC_ENABLE[AX1]=0\n$MA_BACKLASH[0,AX1]=1\n$MA_CEC_ENABLE[AX1]=TRUE\n\
                $MA_BACKLASH[0,AX1]=1.000\n$MN_OTHER=1\n$MN_OTHER=2\nM17\n";
    assert!(held(text).twice.iter().eq(["$MA_CEC_ENABLE[AX1]"]));
    for steps in [["0", "50"], ["50", "0"]] {
        let [first, second] =
            steps.map(|step| CEC.replace("STEP[0]=50.0", &format!("STEP[0]={step}")));
        let found = held(&format!("{first}{second}M17\n"));
        assert!(found.twice.iter().eq(["$AN_CEC_STEP[0]"]));
        assert!(found.tables.reserved.is_empty());
        assert_eq!(found.tables.tables[0].values.len(), 2);
    }
}

#[test]
fn what_is_no_plain_assignment_is_not_swallowed() {
    for line in ["IF R1==1 $MA_CEC_ENABLE[AX1]=0", "$MA_BACKLASH[0,AX1] 0.5", "$AN_CEC[0,0]"] {
        assert!(super::read_out("all.txt", &format!("{line}\nM17\n"), false).is_err(), "{line}");
    }
    assert!(held("G0 X1\nMSG(\"$MA\")\nM17\n").tables.data.is_empty());
    let goes_on = "$MA_BACKLASH[0,AX1]=1\nM17\n$MN_OTHER=1\n";
    let problems = super::read_out("all.txt", goes_on, false).expect_err("behind the end");
    assert!(problems.render().contains("follows the end word"));
    assert!(held(&format!("{goes_on}M17\n")).tables.data.len() == 1);
}
