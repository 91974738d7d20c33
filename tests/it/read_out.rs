//! `verify` judges what was read out of a control: the tables of a kit, the state of the control
//! around them, and much of no concern. What contradicts the job is named, what no file holds is
//! taken as the job asks and said, and what acts unseen leaves the verdict undecided.

use crate::support::{Ran, UNCORRECTED, Visit, cec, replaced};
use crate::update::{FANUC_AXES, SIEMENS_AXES, small};
use std::fs;

/// Rows of X: between its directions lies the lost motion, 4 µm, which `"curve-and-parameter"` asks of the parameter.
const ERRORS: &str = "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,50,6,3\nx,+,100,16,-4\nx,-,0,4,0\nx,-,50,10,3\nx,-,100,20,-4\n";
const AGREE: &str = "job and tables agree";

/// A job with its kit, and what is read out of its control.
struct Control(Visit);

fn siemens(policy: &str) -> Control {
    Control::new("siemens-840d-sl", policy, SIEMENS_AXES)
}

fn fanuc(policy: &str) -> Control {
    Control::new("fanuc-30i", policy, FANUC_AXES)
}

impl Control {
    fn new(control: &str, policy: &str, axes: &str) -> Control {
        let acted = if policy == "mean" { "" } else { "active_backlash_um = { x = 0.0 }" };
        let policy = format!("backlash = \"{policy}\"");
        let job = small(control, &format!("{UNCORRECTED}\n{acted}"), &policy, axes);
        Control(Visit::with(job + "[acceptance]\nmax_deviation_um = 100\n", ERRORS).with_kit())
    }

    /// The tables as the control writes them, with `more` before them.
    fn archive(&self, more: &str) -> String {
        let kit = |name| self.0.read(&format!("kit/{name}"));
        if self.0.has("kit/PITCH.TXT") {
            let blocks = (kit("CNC-PARA.TXT") + &kit("PITCH.TXT")).replace(['%', '\r'], "");
            return format!("%\n{more}\n{blocks}\n%\n");
        }
        let mut own = vec!["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"];
        own.retain(|name| self.0.has(&format!("kit/{name}")));
        let tables: String = own.into_iter().map(kit).collect();
        let lines: Vec<&str> = tables.lines().filter(|line| line.starts_with('$')).collect();
        format!("{more}\n{}\nM30\n", lines.join("\n"))
    }

    /// `verify` of a folder ends with this verdict; `refused`: there is none.
    #[track_caller]
    fn verify(&self, tables: &str, verdict: &str) -> Ran {
        // A picture is drawn whatever the verdict is.
        let plot = "--plot curves.svg --force";
        let ran = self.0.run(&format!("verify job.toml --tables {tables} {plot}"));
        match verdict {
            "refused" => ran.ends(2).omits(" (asked"),
            _ => ran.ends(i32::from(verdict != "pass")).says(&format!("verdict: {verdict} (asked")),
        }
    }

    #[track_caller]
    fn judge(&self, verdict: &str, files: &[(&str, &str)]) -> Ran {
        fs::remove_dir_all(self.0.at("out")).ok();
        for (name, text) in files {
            self.0.put(&format!("out/{name}"), text);
        }
        self.verify("out", verdict)
    }

    #[track_caller]
    fn is(&self, more: &str, verdict: &str, says: &str) {
        self.judge(verdict, &[("all.txt", &self.archive(more))]).says(says);
    }

    #[track_caller]
    fn agrees(&self, more: &str) {
        self.is(more, "pass", AGREE);
    }

    /// Every row: what stands beside the tables (`\n` = end of a line), the verdict, and words unless they just agree.
    #[track_caller]
    fn each(&self, rows: &str) {
        for row in rows.trim().lines().map(str::trim).filter(|row| !row.starts_with("# ")) {
            println!("{row}");
            let (more, said) = row.split_once("=> ").unwrap();
            let (verdict, words) = said.split_once(": ").unwrap_or((said, AGREE));
            let more = match more.strip_prefix("CEC9(").and_then(|rest| rest.split_once(')')) {
                Some((axes, rest)) => {
                    let (input, output) = axes.split_once(',').unwrap();
                    cec_9(input, output, rest)
                }
                None => more.to_string(),
            };
            self.is(&more.trim_end().replace("\\n", "\n"), verdict, words);
        }
    }
}

/// The job states that 0 µm acted while measuring; the parameter that is asked for is another.
#[test]
fn the_backlash_parameter_is_judged_as_it_is_now() {
    let of_siemens: fn(f64) -> String =
        |um| format!("N32450 $MA_BACKLASH[0,AX1]={:.4}", um / 1000.0);
    let of_fanuc = |um: f64| format!("N01851Q1A1P{um:.0}A2P0\nN01852Q1A1P{um:.0}A2P0");
    for (policy, asked, both) in [("curve-and-parameter", 4.0, 0), ("two-tables", 0.0, 1)] {
        for (cnc, bits, held, name) in [
            (siemens(policy), "", of_siemens, "MD32450) of axis AX1"),
            (fanuc(policy), &format!("N03605Q1A1P0000000{both}\n"), of_fanuc, "1851) of axis 1"),
        ] {
            cnc.agrees(&(bits.to_string() + &held(asked)));
            let wrong = format!("the control holds 9 µm, the job asks for {asked} µm");
            cnc.is(&held(9.0), "fail", &wrong);
            cnc.is(bits, "pass", &format!("{name}: taken as the job asks, {asked} µm"));
        }
    }
}

#[test]
fn what_stands_around_siemens_tables_is_judged() {
    siemens("mean").each(
        r"
        # A control writes a checksum behind each machine datum, if MD11230 asks for it.
        N10240 $MN_SCALING_SYSTEM_IS_METRIC=1 '2F34\nN32450 $MA_BACKLASH[0,AX1]=0 'A0b1 ;x => pass
        $MN_SCALING_SYSTEM_IS_METRIC=TRUE => pass
        N32000 $MA_MAX_AX_VELO[AX1]=30000 => pass: 1 other machine data were ignored
        => pass: taken to be on
        $MN_SCALING_SYSTEM_IS_METRIC=0 => fail: counts in inch
        $MN_SCALING_SYSTEM_IS_METRIC=2 => refused: write 0 or 1
        # The tables hold as much as 0.004 mm of AX2, and no CEC table corrects AX1.
        $MA_CEC_MAX_SUM[AX2]=0.1 => pass
        $MA_CEC_MAX_SUM[AX2]=0.004 => pass
        $MA_CEC_MAX_SUM[AX1]=0.001 => pass
        $MA_CEC_MAX_SUM[AX2]=0.001 => fail: may add up to 0.0040
        # Of two values the last is judged all the same.
        $MA_CEC_MAX_SUM[AX2]=0.1\n$MA_CEC_MAX_SUM[AX2]=0.001 => fail: may add up to 0.0040
        $MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n => undecided: it counts where MD10260 = 1
        $MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n$MN_CONVERT_SCALING_SYSTEM=1 => fail: MD32711 of AX2 is 0, the job has its CEC tables in mm
        $MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n$MN_CONVERT_SCALING_SYSTEM=0 => pass
        $MA_BACKLASH[0,AX1]=0.007 => pass: MD32450) of axis AX1 is 7 µm; the job does not set it
        # A table that follows a foreign axis decides nothing; one that multiplies reaches into the own ones.
        CEC9(AX7,AX2) => undecided: INCONSISTENT: $AN_CEC[9] (AX7 → AX2) follows axis AX7
        CEC9(AX2,AX7) => pass: $AN_CEC[9] (AX2 → AX7) belongs to axes that the job does not have: ignored
        CEC9(AX2,AX7)$AN_CEC_MULT_BY_TABLE[9]=1 => undecided: multiplies by $AN_CEC[0] of the job
        $SN_CEC_TABLE_WEIGHT[0]=0.5 => fail: SD41310 $SN_CEC_TABLE_WEIGHT[0] is 0.5, expected 1
        $SN_CEC_TABLE_WEIGHT[6]=0.5 => pass
        # What the profile calls Z is an axis of others where the machine of the job has none.
        $AA_ENC_COMP[0,0,AX3]=0\n$AA_ENC_COMP[0,1,AX3]=0.01\n$AA_ENC_COMP_STEP[0,AX3]=100\n$AA_ENC_COMP_MIN[0,AX3]=0\n$AA_ENC_COMP_MAX[0,AX3]=100 => pass: $AA_ENC_COMP[0,AX3] belongs to an axis that the job does not have
        CEC9(AX3,AX2) => undecided: follows axis AX3
        CEC9(AX2,AX3) => pass: ignored
        # A switch at 1 says that a table acts; which one, only the table does.
        $MA_ENC_COMP_ENABLE[0,AX2]=1 => undecided: MD32700 $MA_ENC_COMP_ENABLE[0,AX2] is 1, so an ENC_COMP table acts, and no file holds it
        $MA_ENC_COMP_ENABLE[0,AX2]=1\n$MA_MM_ENC_COMP_MAX_POINTS[0,AX2]=0 => pass
        $MA_ENC_COMP_ENABLE[0,AX2]=1\n$AA_ENC_COMP_STEP[0,AX2]=0 => pass
        $MA_ENC_COMP_ENABLE[0,AX7]=1 => pass
        $SN_CEC_TABLE_ENABLE[7]=1 => undecided: SD41300 $SN_CEC_TABLE_ENABLE of CEC table 7 is 1, and no file holds it
        $SN_CEC_TABLE_ENABLE[7]=1\n$MN_MM_CEC_MAX_POINTS[7]=0 => pass
        $SN_CEC_TABLE_ENABLE[7]=1\n$AN_CEC_STEP[7]=0 => pass
        # A real 840D sl writes the unit, reserved points behind MAX, and numbers of the NCU.
        \nMETRIC\n\nCHANDATA(1) => pass
        INCH => fail: is written in inch (`INCH`), the job counts in mm
        $AA_ENC_COMP[0,3,AX1]=0\n$AA_ENC_COMP[0,4,AX1]=0.5\n$AN_CEC[0,3]=0\n$AN_CEC_INPUT_NCU[0]=1\n$AN_CEC_OUTPUT_NCU[0]=1\n$AN_CEC_TYPE[0]=0 => pass
        # Two values in one file are a cause, but for those of others; what a program decides is not read.
        $MA_ENC_COMP_ENABLE[0,AX1]=0\n$MA_ENC_COMP_ENABLE[0,AX1]=1 => fail: $MA_ENC_COMP_ENABLE[0,AX1] has several values in the files
        $MN_SCALING_SYSTEM_IS_METRIC=0\n$MN_SCALING_SYSTEM_IS_METRIC=1 => fail: $MN_SCALING_SYSTEM_IS_METRIC has several values in the files
        $MA_BACKLASH[0,AX1]=0.001\n$MA_BACKLASH[0,AX1]=0.002 => fail: $MA_BACKLASH[0,AX1] has several values in the files
        $AA_ENC_COMP[0,1,AX1]=9.0\n$AA_ENC_COMP[0,1,AX1]=0.006 => fail: $AA_ENC_COMP[0,1,AX1] has several values in the files
        $MA_BACKLASH[0,AX7]=1\n$MA_BACKLASH[0,AX7]=2\n$MA_BACKLASH[1,AX1]=1\n$MA_BACKLASH[1,AX1]=2 => pass: $MA_BACKLASH[0,AX7], of others, has several values
        IF R1==1 $MA_ENC_COMP_ENABLE[0,AX1]=0 => refused: does not belong here
        # The place of the reference point, where MD34200 does not say that none is approached.
        N34100 $MA_REFP_SET_POS[0,AX1]=0\nN34100 $MA_REFP_SET_POS[1,AX1]=7 => pass
        N34100 $MA_REFP_SET_POS[0,AX1]=-25.0\nN34100 $MA_REFP_SET_POS[1,AX1]=7\nN34200 $MA_ENC_REFP_MODE[0,AX1]=0 => pass
        N34100 $MA_REFP_SET_POS[0,AX1]=-25.0\nN34100 $MA_REFP_SET_POS[1,AX1]=7 => undecided: MD34100 $MA_REFP_SET_POS[0,AX1] is -25 mm",
    );
}

#[test]
fn what_stands_around_fanuc_points_is_judged() {
    fanuc("mean").each(
        r"
        => pass: no file holds 3602, 1006 of axis 1, 1240 of axis 1, 3605 of axis 1
        N03605Q1A1P00000000A2P00000000 => pass
        N03605Q1A1P00000010A2P00000000 => fail: 3605#1 of axis 1 is 1, the job is for 0
        # The reference point is judged within half a digit.
        N01240Q1A1P12.0A2P0.0 => fail: 1240 of axis 1 is 12 mm
        N01240Q1A1P12000A2P0 => fail: 1240 of axis 1 is 12 mm
        N01240Q1A1P0.0004A2P0 => pass
        N01240Q1A1M0.0A2M0.0 => pass
        N01240Q1A1I0.0A2P0.0 => refused: has the letter `I`
        # Unit, names, detection units and travel of the control are those of the job, or another machine's.
        N01001Q1L1P00000000L2P00000001\nN01020Q1A1P88A2P89A3P66\nN01013Q1A1P00000000\nN01820Q1A1P2A2P20\nN01320Q1A1P100.5A2P99999.0\nN01321Q1A1P0.0A2P99999.0 => pass
        N01001Q1L1P00000001L2P00000000\nN01240Q1A1P12.0 => fail: the control that was read out counts in inch, the job in mm
        N01020Q1A1P89A2P88 => fail: 1020 of axis 1 is 89, which is Y; in the job the axis is X
        N01013Q1A1P00000000\nN01820Q1A1P20 => undecided: 1820 of axis 1 is 20 and 1013 says IS-B: a detection unit of 0.1 µm (from memory); the job states 1 µm, so every correction would be 0.1 times as large
        N01013Q1A1P00000010\nN01820Q1A1P2 => undecided: says IS-C: a detection unit of 0.1 µm
        N01013Q1A1P00000000\nN01820Q1A1P102 => undecided: a detection unit of 2 µm
        N01320Q1A1P1.0\nN01321Q1A1P-1000.0 => undecided: 1321 and 1320 of axis 1 are -1000.000 and 1.000 mm, the job has the travel 0.000 to 100.000 mm: the axis does not reach all of it
        N01320Q1A1P120.0\nN01321Q1A1P-0.0 => pass: are 0.000 and 120.000 mm, the job has the travel 0.000 to 100.000 mm
        # Cs axes have point numbers by spindle, also in the space of the compensation.
        N03666Q1S1P0S2P0\nN03671Q1S1P0\nN03676Q1S1P0S2P0\nN05861Q1S1P0 => pass
        N03666Q1S1P0S2P5 => pass: 3666 of S2 = 5: a spindle corrects no axis of the job, ignored
        # Axes that the job does not have, one of them with a usual name.
        N01006Q1A1P00000000A2P00000000A3P00000000\nN03620Q1A3P500\nN03621Q1A3P500\nN03622Q1A3P510\nN03623Q1A3P1\nN03624Q1A3P10.0 => pass: axis 3 (points 500 to 510) belongs to an axis that the job does not have
        N05712Q1P3\nN05722Q1P2 => undecided: follows axis 3
        N05712Q1P4\nN05722Q1P2 => undecided: straightness set 2 (axis 2 while axis 4 moves) follows axis 4
        N05718Q1L1P4\nN05728Q1L1P2 => undecided: straightness set 8 (axis 2 while axis 4 moves) follows axis 4
        N05712Q1P1\nN05722Q1P0 => fail: straightness set 2: parameter 5722 is 0
        N05712Q1P4\nN05722Q1P2\nN13382Q1P0 => pass: belongs to axes that the job does not have
        N05712Q1P4\nN05722Q1P4\nN13392Q1P4294967295\nN03621Q1A4P0\nN03622Q1A4P10 => pass: belongs to axes that the job does not have
        N03620Q1A4P1\nN03621Q1A4P0\nN03622Q1A4P2\nN03623Q1A4P1\nN03624Q1A4P50.0 => undecided: axis 4, which the job does not have, takes points of axis 1
        N03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN03626Q1A4P1\n => undecided: takes points of axis 1
        N03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN03626Q1A4P1\nN03605Q1A4P00000000 => pass: points 500 to 510",
    );
    fanuc("two-tables").each(
        "=> undecided: no file holds 3605 of axis 1, whose bit 0 decides
        N03605Q1A1P00000000 => fail: 3605#0 of axis 1 is 0, the job is for 1",
    );
    fanuc("curve-and-parameter").each(
        r"N01851Q1A1P4\nN01852Q1A1P4 => pass
        N01851Q1A1P4\nN01852Q1A1P0 => undecided: 1852 of axis 1 is 0, 1851 is 4
        N01852Q1A1P4 => undecided: 1852 of axis 1 is 4, 1851 is in no file
        N01851Q1A1P9.0 => fail: the control holds 9 µm, the job asks for 4 µm
        N01851Q1A1P8\nN01851Q1A1P4 => refused: parameter 1851 of axis 1 has another value here
        N03602Q1L1P00000000L2P00000001\nN01851Q1A1P4 => pass",
    );
    // Zeros of paths that a control reserves stand in a file of any name.
    let cnc = fanuc("mean");
    let [own, points] = ["CNC-PARA", "PITCH"].map(|name| cnc.0.read(&format!("kit/{name}.TXT")));
    let of_paths = replaced(&own, "N05711Q1L1P1", "N05711Q1P1L2P0L3P0");
    cnc.judge("pass", &[("CNC-PARA.TXT", &of_paths), ("PITCH.TXT", &points)]);
    let four_digits = Control::new("fanuc-16i", "mean", FANUC_AXES);
    four_digits.is("N1240A1P12000A2P0", "fail", "1240 of axis 1 is 12 mm");
}

#[test]
fn what_switches_and_products_do_now_is_named_and_no_encoding_stops_the_reading() {
    let cnc = siemens("mean");
    let archive = cnc.archive("");
    let off = "$MA_ENC_COMP_ENABLE[0,AX1]=0\nM30\n";
    cnc.judge("fail", &[("a.txt", &archive), ("b.txt", off)])
        .says("$AA_ENC_COMP[0,AX1] is switched off (MD32700 = 0), so it does nothing");
    let on = "$MA_ENC_COMP_ENABLE[0,AX1]=1\nM30\n";
    cnc.judge("fail", &[("a.txt", &archive), ("b.txt", off), ("c.txt", on)])
        .says("$MA_ENC_COMP_ENABLE[0,AX1] has several values in the files, so which")
        .omits("the way back");
    let of_others = cnc.archive(&cec_9("AX7", "AX2", ""));
    cnc.judge("pass", &[("a.txt", &of_others), ("b.txt", "$SN_CEC_TABLE_ENABLE[9]=0\nM30\n")]);
    // A table that multiplies is not emulated, and judged all the same.
    let by = |number: &str| format!("$AN_CEC_MULT_BY_TABLE[0]={number}");
    cnc.judge("fail", &[("all.txt", &replaced(&archive, &by("0"), &by("2")))])
        .says("is multiplied by $AN_CEC[1], which no file holds");
    // Comments and messages of a control may be in one byte for each character.
    let text = cnc.archive("CHANDATA(1) ;~berwachung");
    let bytes: Vec<u8> = text.bytes().map(|b| if b == b'~' { 0xDC } else { b }).collect();
    cnc.0.put("out/all.txt", bytes);
    cnc.verify("out", "pass");
    // An editor may have put its mark before the header of a program.
    cnc.judge("undecided", &[("all.txt", &format!("\u{feff}%_N_NEW_MPF\n{}", cnc.archive("")))]);
}

#[test]
fn functions_that_are_not_used_do_nothing_and_a_slave_of_a_gantry_is_told() {
    let cnc = fanuc("mean");
    let mut idle =
        "N01006Q1A1P00000000A2P00000000A3P00000000\nN03602Q1P00000000\nN08135Q1P00000000\n"
            .to_string();
    for (numbers, zeros) in [
        (3666..=3671, "A1P0A2P0A3P0"),
        (3676..=3677, "A1P0A2P0A3P0"),
        (5861..=5864, "P0"),
        (5871..=5874, "P0"),
        (10800..=10814, "P0"),
        (14985..=14988, "A1P0A2P0A3P0"),
    ] {
        idle.extend(numbers.map(|number| format!("N{number:05}Q1{zeros}\n")));
    }
    cnc.agrees(&idle);
    let used = replaced(&idle, "N10800Q1P0", "N10800Q1P5");
    cnc.is(&used, "fail", "three-dimensional error compensation is not emulated");
    // An axis that takes the points of another one with all of its parameters is the slave of a gantry.
    let parameters = cnc.0.read("kit/CNC-PARA.TXT");
    let slave = ["03620", "03621", "03622", "03623", "03624"].map(|number| {
        let (_, rest) = parameters.split_once(&format!("N{number}Q1A1P")).unwrap();
        let value = rest.split(['A', '\r', '\n']).next().unwrap();
        format!("N{number}Q1A4P{value}\n")
    });
    cnc.is(&slave.concat(), "pass", "takes the points of axis 1, as the slave of a gantry does");
    // A file of another kind has the same mistake in each line: it is said once, and reading stops.
    let text = format!("%\n{}%\n", "X1 Y2 no block\n".repeat(43_000));
    let ran = cnc.judge("refused", &[("all.txt", &text)]);
    let ran = ran.says("the same in 1999 more lines");
    assert_eq!(ran.all().matches("-->").count(), 1, "{}", ran.all());
}

#[test]
fn each_axis_of_a_gantry_is_judged_by_its_own_parameter() {
    let gantry = replaced(SIEMENS_AXES, "id = \"AX1\"", "ids = [\"AX1\", \"AX4\"]");
    let cnc = Control::new("siemens-840d-sl", "curve-and-parameter", &gantry);
    let one = "$MA_BACKLASH[0,AX1]=0.004\n";
    cnc.is(one, "pass", "MD32450) of axis AX4: taken as the job asks, 4 µm");
    let both = |um: &str| format!("{one}$MA_BACKLASH[0,AX4]={um}");
    cnc.agrees(&both("0.004"));
    cnc.is(&both("0"), "fail", "axis AX4: the control holds 0 µm, the job asks for 4 µm");
    // Two screws may have two lost motions, and nothing changes them.
    let cnc = Control::new("siemens-840d-sl", "mean", &gantry);
    cnc.is(&both("0.005"), "pass", "of axis AX4 is 5 µm; the job does not set it");
}

#[test]
fn grids_that_no_point_ends_are_read_as_the_control_takes_them() {
    let cnc = siemens("mean");
    let zeros = |input: &str, output: &str, more: &str| {
        cec_9(input, output, more).replace("=0.1", "=0").replace("=0.2", "=0")
    };
    cnc.is(&zeros("AX7", "AX2", ""), "pass", "ignored");
    let zeros = zeros("AX1", "AX7", "$AN_CEC_INPUT_NCU[9]=1\n$AN_CEC[9,2]=0");
    cnc.is(&replaced(&zeros, "MAX[9]=10", "MAX[9]=85"), "pass", "ignored");
    let unused = replaced(&zeros, "MAX[9]=10", "MAX[9]=-5");
    cnc.is(&unused, "pass", "AN_CEC[9]: zeros without a usable grid, ignored");
    let open = cec_9("AX1", "AX2", "$AN_CEC[9,2]=0.4\n");
    let says = "$AN_CEC[9] behind 10 mm, where MAX lies between two points: the value of point 1 is taken to be held; if the control goes on towards point 2, the correction differs by up to 100.0 µm there";
    cnc.is(&replaced(&open, "MAX[9]=10", "MAX[9]=15"), "fail", says);
    let steps = cec_9("AX1", "AX2", "$AN_CEC_STEP[9]=0").replace("STEP[9]=10", "STEP[9]=50");
    let steps = steps.replace("MAX[9]=10", "MAX[9]=50");
    cnc.is(&steps, "fail", "$AN_CEC_STEP[9] has several values in the files");
}

fn cec_9(input: &str, output: &str, more: &str) -> String {
    cec(9, [input, output], 10, [0.1, 0.2]) + "$AN_CEC_DIRECTION[9]=0\n" + more
}

#[test]
fn part_programs_beside_active_data_are_no_state() {
    let cnc = siemens("mean");
    let bare = cnc.archive("");
    let program = format!("%_N_NEW_EEC_MPF\n;$PATH=/_N_MPF_DIR\n{bare}");
    let active = program.replace("NEW_EEC_MPF", "AX_EEC_INI").replace("_MPF_", "_NC_ACT_");
    let old = replaced(&active, "=0.016", "=0.055");
    let judge = |verdict: &str, text: &str| cnc.judge(verdict, &[("all.txt", text)]);
    let ignored = "part programs were ignored (NEW_EEC_MPF)";
    judge("fail", &format!("{old}{program}")).says(ignored);
    judge("fail", &format!("{program}{old}")).says(ignored);
    let off = "%_N_COMPLETE_TEA_INI\n$MA_ENC_COMP_ENABLE[0,AX1]=0\nM17\n";
    let on = "%_N_ON_MPF\n$MA_ENC_COMP_ENABLE[0,AX1]=1\nM30\n";
    judge("fail", &format!("{off}{active}{on}"));
    judge("pass", &active);
    judge("undecided", &program).says("acts only once they were run");
    // A program in a file of its own is no more a state.
    let data = "%_N_COMPLETE_TEA_INI\n$MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n";
    for name in ["P.MPF", "P"] {
        cnc.judge("fail", &[("TEA.INI", data), (name, &program)])
            .says("missing: the tables hold nothing for it");
        cnc.judge("pass", &[("ALL.INI", &active), (name, &program)]);
    }
    cnc.judge("fail", &[("ALL.INI", &old), ("NEW.MPF", &bare)]);
    // Cut before the switch: what goes on behind the end word is not complete.
    judge("refused", &format!("{active}%_N_COMPLETE_TEA_INI\nN32000 $MA_MAX_AX_VELO[AX1]=10000\n"));
}

#[test]
fn the_measuring_system_that_the_job_does_not_name_is_told() {
    let other = "$AA_ENC_COMP[1,0,AX1]=0\n$AA_ENC_COMP[1,1,AX1]=0.066\n$AA_ENC_COMP_STEP[1,AX1]=100\n$AA_ENC_COMP_MIN[1,AX1]=0\n$AA_ENC_COMP_MAX[1,AX1]=100\n";
    siemens("mean").is(other, "undecided", "which of the two is active: state `measuring_system`");
    let off = format!("{other}$MA_ENC_COMP_ENABLE[1,AX1]=0");
    let says = "for the other measuring system and switched off: ignored";
    siemens("two-tables").is(&off, "pass", says); // in CEC alone
}

/// Points alone tell neither axis nor grid; the checklist is for people, and nothing else needs it.
#[test]
fn a_kit_with_the_controls_own_file_or_without_a_part_is_judged_by_what_is_there() {
    let cnc = fanuc("mean");
    let others: String = (0..200).map(|k| format!("N{:05}Q1P0\n", 100 + k)).collect();
    let whole = cnc.archive(&others);
    let sign = cnc.0.read("kit/checklist.md");
    cnc.judge("pass", &[("CNC-PARA.TXT", &whole), ("checklist.md", &sign)])
        .says("`checklist.md` is a file of a kit that is not loaded with its tables: ignored");
    cnc.judge("fail", &[("points.txt", &cnc.0.read("kit/PITCH.TXT"))])
        .says("no parameter 3620 to 3624, so which axes they correct is not known");
    fs::remove_file(cnc.0.at("kit/checklist.md")).unwrap();
    let says = "note: `checklist.md` is listed in manifest.json but missing";
    cnc.verify("kit", "pass").says(says);
    cnc.0.put("kit/CNC-PARA.TXT", &whole);
    cnc.verify("kit", "fail")
        .says("`CNC-PARA.TXT` holds far more than a kit, so it is the control's own");
}

#[test]
fn rows_of_a_foreign_axis_are_passed_over_or_doubted() {
    let axes = "[compensation.axes.x]\nspacing_mm = 50\n[compensation.axes.y]\nspacing_mm = 50\n";
    let cnc = Control::new("generic", "mean", axes);
    let table = cnc.0.read("kit/compensation.csv");
    let rows = |row: &str| {
        let own = table.lines().filter(|line| line.starts_with("EYX,"));
        let own: Vec<String> = own.map(|line| replaced(line, "EYX,x,y", row)).collect();
        assert!(own.len() > 1, "{table}");
        format!("{}\n{}\n", table.trim_end(), own.join("\n"))
    };
    cnc.judge("pass", &[("table.csv", &rows("EZX,x,a"))])
        .says("(a while x moves) belongs to axes that the job does not have");
    cnc.judge("undecided", &[("table.csv", &rows("EYZ,a,y"))]);
}
