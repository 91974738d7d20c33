//! `verify` judges what was read out of a control: the tables of a kit, the state of the control
//! around them, and much of no concern. What contradicts the job is named, what no file holds is
//! taken as the job asks and said, and what acts unseen leaves the verdict undecided.

use crate::support::run::ended;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Lost motion of X, µm: what `"curve-and-parameter"` asks of the backlash parameter.
const LOST_UM: f64 = 4.0;

const SIEMENS: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"AX1\"\n[compensation.axes.y]\nspacing_mm = 50\nid = \"AX2\"\n";
const FANUC: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"1\"\ndetection_unit_um = 1.0\n[compensation.axes.y]\nspacing_mm = 50\nid = \"2\"\ndetection_unit_um = 1.0\n";

/// A job with its kit, and a place for what is read out.
struct Visit {
    directory: TempDir,
    read_out: PathBuf,
    is_fanuc: bool,
}

impl Visit {
    fn new(control: &str, policy: &str, axes: &str) -> Visit {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path();
        let acted = if policy == "mean" { "" } else { "active_backlash_um = { x = 0.0 }" };
        let measurement = format!("active_while_measuring = \"none\"\n{acted}");
        let job = format!(
            "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{measurement}\n[compensation]\ncontroller = \"{control}\"\nbacklash = \"{policy}\"\n[machine.axes.x]\ntravel_mm = [0, 100]\nreference_mm = 0\n[machine.axes.y]\ntravel_mm = [0, 100]\nreference_mm = 0\n{axes}[acceptance]\nmax_deviation_um = 100\n"
        );
        let mut errors = "axis,direction,position_mm,ex_um,ey_um\n".to_string();
        for (way, lost) in [("+", 0.0), ("-", LOST_UM)] {
            for (at, ex, ey) in [(0, 0.0, 0.0), (50, 6.0, 3.0), (100, 16.0, -4.0)] {
                errors.push_str(&format!("x,{way},{at},{},{ey}\n", ex + lost));
            }
        }
        fs::write(path.join("job.toml"), job).unwrap();
        fs::write(path.join("errors.csv"), errors).unwrap();
        let (status, _, said) = ended(path, "generate job.toml -o kit");
        assert_eq!(status, Some(0), "{said}");
        let read_out = path.join("out");
        fs::create_dir(&read_out).unwrap();
        let is_fanuc = control.starts_with("fanuc");
        Visit { directory, read_out, is_fanuc }
    }

    fn of(is_fanuc: bool, policy: &str) -> Visit {
        match is_fanuc {
            true => Visit::new("fanuc-30i", policy, FANUC),
            false => Visit::new("siemens-840d-sl", policy, SIEMENS),
        }
    }

    fn kit(&self, name: &str) -> String {
        fs::read_to_string(self.directory.path().join("kit").join(name)).unwrap()
    }

    /// The tables as the control writes them, with `more` before them.
    fn archive(&self, more: &str) -> String {
        if self.is_fanuc {
            let files = ["CNC-PARA.TXT", "PITCH.TXT"].map(|name| self.kit(name));
            let blocks = files.concat().replace(['%', '\r'], "");
            return format!("%\n{more}\n{blocks}\n%\n");
        }
        let tables = ["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"].map(|name| {
            let path = self.directory.path().join("kit").join(name);
            let text = fs::read_to_string(path).unwrap_or_default();
            let lines = text.lines().filter(|line| line.starts_with('$'));
            lines.map(|line| format!("{line}\n")).collect::<String>()
        });
        format!("{more}\n{}M30\n", tables.concat())
    }

    /// Verdict (`refused` without one) and page.
    fn judge_bytes(&self, files: &[(&str, &str)]) -> (&'static str, String) {
        for entry in fs::read_dir(&self.read_out).unwrap() {
            fs::remove_file(entry.unwrap().path()).unwrap();
        }
        for (name, text) in files {
            fs::write(self.read_out.join(name), text).unwrap();
        }
        self.verify("out")
    }

    fn verify(&self, tables: &str) -> (&'static str, String) {
        let command = format!("verify job.toml --tables {tables}");
        let (status, page, said) = ended(self.directory.path(), &command);
        let is = |word: &&&str| page.contains(&format!("verdict: {word} (asked"));
        let verdict = ["pass", "fail", "undecided"].iter().find(is);
        let verdict = verdict.copied().unwrap_or("refused");
        let expected = match verdict {
            "pass" => 0,
            "refused" => 2,
            _ => 1,
        };
        assert_eq!(status, Some(expected), "{page}{said}");
        (verdict, page + &said)
    }

    fn judge(&self, more: &str) -> (&'static str, String) {
        self.judge_bytes(&[("all.txt", &self.archive(more))])
    }

    /// `more` beside the tables, the verdict, and words that the page has to hold.
    #[track_caller]
    fn expect(&self, more: &str, verdict: &str, says: &str) {
        let (found, page) = self.judge(more);
        assert_eq!(found, verdict, "{more}\n{page}");
        assert!(page.contains(says), "`{says}` is not in\n{page}");
    }
}

/// What a control holds of an axis, in µm.
fn parameter(is_fanuc: bool, um: f64) -> String {
    match is_fanuc {
        true => format!("N01851Q1A1P{um:.0}A2P0\nN01852Q1A1P{um:.0}A2P0"),
        false => format!("N32450 $MA_BACKLASH[0,AX1]={:.4}", um / 1000.0),
    }
}

/// The job states that 0 µm acted while measuring; the parameter that is asked for is another.
#[test]
fn the_backlash_parameter_is_judged_as_it_is_now() {
    for is_fanuc in [false, true] {
        for (policy, asked) in [("curve-and-parameter", LOST_UM), ("two-tables", 0.0)] {
            let visit = Visit::of(is_fanuc, policy);
            visit.expect(&parameter(is_fanuc, asked), "pass", "job and tables agree");
            let wrong = format!("the control holds 9 µm, the job asks for {asked} µm");
            visit.expect(&parameter(is_fanuc, 9.0), "fail", &wrong);
            let name = if is_fanuc { "1851) of axis 1" } else { "MD32450) of axis AX1" };
            let absent = format!("{name}: taken as the job asks, {asked} µm");
            visit.expect("", "pass", &absent);
        }
    }
}

#[test]
fn a_parameter_that_the_job_does_not_set_is_told() {
    let visit = Visit::of(false, "mean");
    let says = "MD32450) of axis AX1 is 7 µm; the job does not set it";
    visit.expect("$MA_BACKLASH[0,AX1]=0.007", "pass", says);
}

#[test]
fn what_stands_around_siemens_tables_is_judged() {
    let visit = Visit::of(false, "mean");
    let agree = "job and tables agree";
    // A control writes a checksum behind each machine datum, if MD11230 asks for it.
    let sums = "N10240 $MN_SCALING_SYSTEM_IS_METRIC=1 '2F34\nN32450 $MA_BACKLASH[0,AX1]=0 'A0b1 ;x";
    visit.expect(sums, "pass", agree);
    visit.expect("$MN_SCALING_SYSTEM_IS_METRIC=TRUE", "pass", agree);
    visit.expect("$MN_SCALING_SYSTEM_IS_METRIC=0", "fail", "counts in inch");
    visit.expect("$MN_SCALING_SYSTEM_IS_METRIC=2", "refused", "write 0 or 1");
    visit.expect("$MA_CEC_MAX_SUM[AX2]=0.1", "pass", agree);
    visit.expect("$MA_CEC_MAX_SUM[AX2]=0.004", "pass", agree); // as much as the tables hold
    visit.expect("$MA_CEC_MAX_SUM[AX1]=0.001", "pass", agree); // no CEC table corrects AX1
    visit.expect("$MA_CEC_MAX_SUM[AX2]=0.001", "fail", "may add up to 0.0040");
    let inch = "$MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n";
    visit.expect(inch, "undecided", "it counts where MD10260 = 1");
    let with = |converts: u8| format!("{inch}$MN_CONVERT_SCALING_SYSTEM={converts}");
    visit.expect(&with(1), "fail", "MD32711 of AX2 is 0, the job has its CEC tables in mm");
    visit.expect(&with(0), "pass", agree);
}

#[test]
fn a_table_that_follows_a_foreign_axis_decides_nothing() {
    let foreign = |input: &str, output: &str| cec(input, output, "");
    let visit = Visit::of(false, "mean");
    let says = "DOUBTFUL: $AN_CEC[9] (AX7 → AX2) follows axis AX7";
    visit.expect(&foreign("AX7", "AX2"), "undecided", says);
    let says = "$AN_CEC[9] (AX2 → AX7) belongs to axes that the job does not have: ignored";
    visit.expect(&foreign("AX2", "AX7"), "pass", says);
    let off = foreign("AX7", "AX2");
    let (verdict, page) = visit.judge_bytes(&[
        ("a.txt", &visit.archive(&off)),
        ("b.txt", "$SN_CEC_TABLE_ENABLE[9]=0\nM30\n"),
    ]);
    assert_eq!(verdict, "pass", "{page}");
    let visit = Visit::of(true, "mean");
    let set = "N05712Q1P4\nN05722Q1P2";
    visit.expect(set, "undecided", "straightness set 2 (axis 2 while axis 4 moves) follows axis 4");
}

#[test]
fn switches_are_named_by_what_they_do_now() {
    let visit = Visit::of(false, "mean");
    let off = "$MA_ENC_COMP_ENABLE[0,AX1]=0\n";
    let (verdict, page) = visit
        .judge_bytes(&[("a.txt", &visit.archive("")), ("b.txt", &(off.to_string() + "M30\n"))]);
    assert_eq!(verdict, "fail", "{page}");
    assert!(
        page.contains("$AA_ENC_COMP[0,AX1] is switched off (MD32700 = 0), so it does nothing"),
        "{page}"
    );
    let on = "$MA_ENC_COMP_ENABLE[0,AX1]=1\n";
    let (verdict, page) = visit.judge_bytes(&[
        ("a.txt", &visit.archive("")),
        ("b.txt", &(off.to_string() + "M30\n")),
        ("c.txt", &(on.to_string() + "M30\n")),
    ]);
    assert_eq!(verdict, "fail", "{page}");
    assert!(
        page.contains("$MA_ENC_COMP_ENABLE[0,AX1] has several values in the files, so which"),
        "{page}"
    );
    assert!(!page.contains("the way back"), "{page}");
}

#[test]
fn what_stands_around_fanuc_points_is_judged() {
    let visit = Visit::of(true, "mean");
    let agree = "job and tables agree";
    visit.expect("", "pass", "no file holds 3605 of axis 1");
    visit.expect("N03605Q1A1P00000000A2P00000000", "pass", agree);
    visit.expect(
        "N03605Q1A1P00000010A2P00000000",
        "fail",
        "3605#1 of axis 1 is 1, the job is for 0",
    );
    visit.expect("N01240Q1A1P12.0A2P0.0", "fail", "1240 of axis 1 is 12 mm");
    visit.expect("N01240Q1A1M0.0A2M0.0", "pass", agree);
    visit.expect("N01240Q1A1I0.0A2P0.0", "refused", "has the letter `I`");
    let visit = Visit::of(true, "two-tables");
    visit.expect("N03605Q1A1P00000001", "pass", agree);
    visit.expect("N03605Q1A1P00000000", "fail", "3605#0 of axis 1 is 0, the job is for 1");
    let visit = Visit::of(true, "curve-and-parameter");
    let held = |rapid: &str| format!("N01851Q1A1P4\n{rapid}");
    visit.expect(&held("N01852Q1A1P4"), "pass", agree);
    visit.expect(&held("N01852Q1A1P0"), "undecided", "1852 of axis 1 is 0, 1851 is 4");
    visit.expect("N01852Q1A1P4", "undecided", "1852 of axis 1 is 4, 1851 is in no file");
}

/// A control writes every parameter it has; what does nothing must not stop the reading.
#[test]
fn functions_that_are_not_used_do_nothing() {
    let visit = Visit::of(true, "mean");
    let mut idle =
        "N01006Q1A1P00000000A2P00000000A3P00000000\nN03602Q1P00000000\nN08135Q1P00000000\n"
            .to_string();
    let ranges = [
        (3666, 3671, "A1P0A2P0A3P0"),
        (3676, 3677, "A1P0A2P0A3P0"),
        (5861, 5864, "P0"),
        (5871, 5874, "P0"),
        (10800, 10814, "P0"),
        (14985, 14988, "A1P0A2P0A3P0"),
    ];
    for (first, last, zeros) in ranges {
        for number in first..=last {
            idle.push_str(&format!("N{number:05}Q1{zeros}\n"));
        }
    }
    visit.expect(&idle, "pass", "job and tables agree");
    let used = idle.replace("N10800Q1P0", "N10800Q1P5");
    visit.expect(&used, "fail", "three-dimensional error compensation is not emulated");
}

#[test]
fn each_axis_of_a_gantry_is_judged_by_its_own_parameter() {
    let gantry = SIEMENS.replace("id = \"AX1\"", "ids = [\"AX1\", \"AX4\"]");
    let visit = Visit::new("siemens-840d-sl", "curve-and-parameter", &gantry);
    let one = "$MA_BACKLASH[0,AX1]=0.004\n";
    visit.expect(one, "pass", "MD32450) of axis AX4: taken as the job asks, 4 µm");
    let both = |um: &str| format!("{one}$MA_BACKLASH[0,AX4]={um}");
    visit.expect(&both("0.004"), "pass", "job and tables agree");
    let wrong = "axis AX4: the control holds 0 µm, the job asks for 4 µm";
    visit.expect(&both("0"), "fail", wrong);
    // Two screws may have two lost motions, and nothing changes them.
    let visit = Visit::new("siemens-840d-sl", "mean", &gantry);
    visit.expect(&both("0.005"), "pass", "of axis AX4 is 5 µm; the job does not set it");
}

/// What the profile calls Z is an axis of others where the machine of the job has none.
#[test]
fn an_axis_of_a_usual_name_that_the_job_does_not_have_belongs_to_others() {
    let visit = Visit::of(true, "mean");
    let z = "N01006Q1A1P00000000A2P00000000A3P00000000\nN03620Q1A3P500\nN03621Q1A3P500\nN03622Q1A3P510\nN03623Q1A3P1\nN03624Q1A3P10.0";
    visit.expect(
        z,
        "pass",
        "axis 3 (points 500 to 510) belongs to an axis that the job does not have",
    );
    let set = "N05712Q1P3\nN05722Q1P2";
    visit.expect(set, "undecided", "follows axis 3");
    let visit = Visit::of(false, "mean");
    let lec = "$AA_ENC_COMP[0,0,AX3]=0\n$AA_ENC_COMP[0,1,AX3]=0.01\n$AA_ENC_COMP_STEP[0,AX3]=100\n$AA_ENC_COMP_MIN[0,AX3]=0\n$AA_ENC_COMP_MAX[0,AX3]=100";
    visit.expect(lec, "pass", "$AA_ENC_COMP[0,AX3] belongs to an axis that the job does not have");
    visit.expect(&cec("AX3", "AX2", ""), "undecided", "follows axis AX3");
    visit.expect(&cec("AX2", "AX3", ""), "pass", "ignored");
}

/// A switch at 1 says that a table acts; which one, only the table does.
#[test]
fn switches_of_tables_that_were_not_read_out_leave_it_undecided() {
    let visit = Visit::of(false, "mean");
    let lec = "$MA_ENC_COMP_ENABLE[0,AX2]=1";
    let says =
        "MD32700 $MA_ENC_COMP_ENABLE[0,AX2] is 1, so an ENC_COMP table acts, and no file holds it";
    visit.expect(lec, "undecided", says);
    let says = "SD41300 $SN_CEC_TABLE_ENABLE of CEC table 7 is 1, and no file holds it";
    visit.expect("$SN_CEC_TABLE_ENABLE[7]=1", "undecided", says);
    let agree = "job and tables agree";
    for without_effect in [
        "$MA_ENC_COMP_ENABLE[0,AX2]=1\n$MA_MM_ENC_COMP_MAX_POINTS[0,AX2]=0",
        "$MA_ENC_COMP_ENABLE[0,AX2]=1\n$AA_ENC_COMP_STEP[0,AX2]=0",
        "$MA_ENC_COMP_ENABLE[0,AX7]=1",
        "$SN_CEC_TABLE_ENABLE[7]=1\n$MN_MM_CEC_MAX_POINTS[7]=0",
        "$SN_CEC_TABLE_ENABLE[7]=1\n$AN_CEC_STEP[7]=0",
    ] {
        visit.expect(without_effect, "pass", agree);
    }
}

/// The forms that a real 840D sl writes: the unit, reserved points behind MAX, numbers of the NCU, tables
/// that nobody filled.
#[test]
fn what_a_control_writes_around_its_tables_does_not_stop_the_reading() {
    let visit = Visit::of(false, "mean");
    let agree = "job and tables agree";
    visit.expect("\nMETRIC\n\nCHANDATA(1)", "pass", agree);
    visit.expect("INCH", "fail", "is written in inch (`INCH`), the job counts in mm");
    let reserved = "$AA_ENC_COMP[0,3,AX1]=0\n$AA_ENC_COMP[0,4,AX1]=0.5\n$AN_CEC[0,3]=0\n$AN_CEC_INPUT_NCU[0]=1\n$AN_CEC_OUTPUT_NCU[0]=1\n$AN_CEC_TYPE[0]=0";
    visit.expect(reserved, "pass", agree);
    let zeros = |axis: &str| {
        cec("AX1", axis, "$AN_CEC_INPUT_NCU[9]=1\n$AN_CEC[9,2]=0")
            .replace("=0.1", "=0")
            .replace("=0.2", "=0")
            .replace("MAX[9]=10", "MAX[9]=85")
    };
    visit.expect(&zeros("AX7"), "pass", "ignored");
    let unused = zeros("AX7").replace("MAX[9]=85", "MAX[9]=-5");
    visit.expect(&unused, "pass", "AN_CEC[9]: zeros without a usable grid, ignored");
    let open = cec("AX1", "AX2", "").replace("MAX[9]=10", "MAX[9]=15");
    let (verdict, page) = visit.judge(&format!("{open}$AN_CEC[9,2]=0.4\n"));
    assert_eq!(verdict, "fail", "{page}");
    let says = "$AN_CEC[9] behind 10 mm, where MAX lies between two points: the value of point 1 is taken to be held; if the control goes on towards point 2, the correction differs by up to 100.0 µm there";
    assert!(page.contains(says), "{page}");
}

/// A header of an archive: 512 bytes with name, size, the sum of its other bytes, and folder.
fn header(name: &str, size: usize, folder: &str) -> Vec<u8> {
    let mut header = vec![0_u8; 512];
    for (at, text) in [(0, name), (124, &size.to_string()), (384, folder)] {
        header[at..at + text.len()].copy_from_slice(text.as_bytes());
    }
    let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
    let sum = sum.to_string();
    header[148..148 + sum.len()].copy_from_slice(sum.as_bytes());
    header
}

#[test]
fn a_commissioning_archive_is_read_as_it_is() {
    let visit = Visit::of(false, "mean");
    let other = visit.archive("").replace("=0.016", "=0.055");
    let programs = (0..8).map(|k| (format!("_N_P{k}_MPF"), "\\MPF.DIR\\", other.clone()));
    let definitions = "REDEF $MA_CEC_ENABLE APR 7 APW 7\n".to_string();
    let mut files = vec![
        (
            "_N_INITIAL_INI".to_string(),
            "\\_NC_ACT.DIR\\",
            "METRIC\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n".to_string(),
        ),
        ("_N_AX_EEC_INI".to_string(), "\\_NC_ACT.DIR\\", visit.archive("METRIC")),
        ("_N_MACCESS_DEF".to_string(), "\\DEF.DIR\\", definitions),
        ("@@_N_IBN_SS".to_string(), "\\_NC_ACT.DIR\\", String::new()),
    ];
    files.extend(programs);
    let mut bytes = header("@@MMCIBN.002", 0, "");
    for (name, folder, text) in &files {
        bytes.extend(header(name, text.len(), folder));
        bytes.extend(text.as_bytes());
        bytes.resize(bytes.len().next_multiple_of(512), 0);
    }
    fs::write(visit.read_out.join("test.arc"), &bytes).unwrap();
    let (verdict, page) = visit.verify("out");
    assert_eq!(verdict, "pass", "{page}");
    assert!(page.contains("part programs were ignored (8)"), "{page}");
    fs::write(visit.read_out.join("test.arc"), &bytes[..3000]).unwrap();
    let (verdict, page) = visit.verify("out");
    assert_eq!(verdict, "refused", "{page}");
    assert!(page.contains("the archive `test.arc` is damaged or cut off"), "{page}");
}

/// Cs axes have point numbers by spindle, also in the space of the compensation.
#[test]
fn parameters_of_spindles_correct_no_axis() {
    let visit = Visit::of(true, "mean");
    let zero = "N03666Q1S1P0S2P0\nN03671Q1S1P0\nN03676Q1S1P0S2P0\nN05861Q1S1P0";
    visit.expect(zero, "pass", "job and tables agree");
    let says = "3666 of S2 = 5: a spindle corrects no axis of the job, ignored";
    visit.expect("N03666Q1S1P0S2P5", "pass", says);
}

/// Points alone tell neither axis nor grid.
#[test]
fn points_without_their_parameters_leave_it_undecided() {
    let visit = Visit::of(true, "mean");
    let (verdict, page) = visit.judge_bytes(&[("points.txt", &visit.kit("PITCH.TXT"))]);
    assert_eq!(verdict, "fail", "{page}");
    assert!(
        page.contains("no parameter 3620 to 3624, so which axes they correct is not known"),
        "{page}"
    );
}

/// A file of another kind has the same mistake in each line: it is said once, and reading stops.
#[test]
fn a_long_file_of_another_kind_is_refused_at_once() {
    let visit = Visit::of(true, "mean");
    let text = format!("%\n{}%\n", "X1 Y2 no block\n".repeat(43_000));
    let (verdict, page) = visit.judge_bytes(&[("all.txt", &text)]);
    assert_eq!(verdict, "refused", "{page}");
    assert_eq!(page.matches("-->").count(), 1, "{page}");
    assert!(page.contains("the same in 1999 more lines"), "{page}");
}

/// CEC table 9, and `more` of it.
fn cec(input: &str, output: &str, more: &str) -> String {
    format!(
        "$AN_CEC[9,0]=0.1\n$AN_CEC[9,1]=0.2\n$AN_CEC_INPUT_AXIS[9]=({input})\n$AN_CEC_OUTPUT_AXIS[9]=({output})\n$AN_CEC_STEP[9]=10\n$AN_CEC_MIN[9]=0\n$AN_CEC_MAX[9]=10\n$AN_CEC_DIRECTION[9]=0\n{more}"
    )
}

#[test]
fn tables_of_others_that_reach_into_the_own_ones_are_told() {
    let visit = Visit::of(false, "mean");
    let factor = cec("AX2", "AX7", "$AN_CEC_MULT_BY_TABLE[9]=1");
    visit.expect(&factor, "undecided", "multiplies by $AN_CEC[0] of the job");
    let zeros = cec("AX7", "AX2", "").replace("=0.1", "=0").replace("=0.2", "=0");
    visit.expect(&zeros, "pass", "ignored");
    let weight = |table: u32| format!("$SN_CEC_TABLE_WEIGHT[{table}]=0.5");
    visit.expect(&weight(0), "fail", "SD41310 $SN_CEC_TABLE_WEIGHT[0] is 0.5, expected 1");
    visit.expect(&weight(6), "pass", "job and tables agree");
    let visit = Visit::of(true, "mean");
    let shared = "N03620Q1A4P1\nN03621Q1A4P0\nN03622Q1A4P2\nN03623Q1A4P1\nN03624Q1A4P50.0";
    visit.expect(
        shared,
        "undecided",
        "axis 4, which the job does not have, takes points of axis 1",
    );
    let of_axis_1 = |parameter: &str| -> String {
        let text = visit.kit("CNC-PARA.TXT");
        let block = text
            .lines()
            .map(str::trim)
            .find(|line| line.starts_with(&format!("N{parameter}Q1A1P")));
        let value = block.unwrap().split(['P', 'A']).nth(2).unwrap().to_string();
        format!("N{parameter}Q1A4P{value}\n")
    };
    let slave = ["03620", "03621", "03622", "03623", "03624"].map(of_axis_1).concat();
    visit.expect(&slave, "pass", "takes the points of axis 1, as the slave of a gantry does");
    let own = "N03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN03626Q1A4P1\n";
    visit.expect(own, "undecided", "takes points of axis 1");
    visit.expect(&format!("{own}N03605Q1A4P00000000"), "pass", "points 500 to 510");
    let huge = "N05712Q1P4\nN05722Q1P4\nN13392Q1P4294967295\nN03621Q1A4P0\nN03622Q1A4P10";
    visit.expect(huge, "pass", "belongs to axes that the job does not have");
    let idle = "N05712Q1P4\nN05722Q1P2\nN13382Q1P0";
    visit.expect(idle, "pass", "belongs to axes that the job does not have");
}

/// An archive holds part programs beside the active data; they do nothing before they are run.
#[test]
fn part_programs_in_an_archive_are_no_state() {
    let visit = Visit::of(false, "mean");
    let program = format!("%_N_NEW_EEC_MPF\n;$PATH=/_N_MPF_DIR\n{}", visit.archive(""));
    let active = program.replace("NEW_EEC_MPF", "AX_EEC_INI").replace("_MPF_", "_NC_ACT_");
    let old = active.replace("=0.016", "=0.055");
    assert_ne!(old, active);
    let judge = |text: &str| visit.judge_bytes(&[("all.arc", text)]);
    for text in [format!("{old}{program}"), format!("{program}{old}")] {
        let (verdict, page) = judge(&text);
        assert_eq!(verdict, "fail", "{page}");
        assert!(page.contains("part programs were ignored (NEW_EEC_MPF)"), "{page}");
    }
    let off = "%_N_COMPLETE_TEA_INI\n$MA_ENC_COMP_ENABLE[0,AX1]=0\nM17\n";
    let on = "%_N_ON_MPF\n$MA_ENC_COMP_ENABLE[0,AX1]=1\nM30\n";
    assert_eq!(judge(&format!("{off}{active}{on}")).0, "fail");
    assert_eq!(judge(&active).0, "pass");
    let (verdict, page) = judge(&program);
    assert_eq!(verdict, "undecided", "{page}");
    assert!(page.contains("acts only once they were run"), "{page}");
    // A program in a file of its own is no more a state than one in the archive.
    let data = "%_N_COMPLETE_TEA_INI\n$MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n";
    for name in ["P.MPF", "P"] {
        let (verdict, page) = visit.judge_bytes(&[("TEA.INI", data), (name, &program)]);
        assert_eq!(verdict, "fail", "{page}");
        assert!(page.contains("missing: the tables hold nothing for it"), "{page}");
        let (verdict, page) = visit.judge_bytes(&[("ALL.ARC", &active), (name, &program)]);
        assert_eq!(verdict, "pass", "{page}");
    }
    let without_header = visit.archive("");
    let files = [("ALL.ARC", old.as_str()), ("NEW.MPF", &without_header)];
    assert_eq!(visit.judge_bytes(&files).0, "fail");
    // Cut before the switch: what goes on behind the end word is not complete.
    let cut = format!("{active}%_N_COMPLETE_TEA_INI\nN32000 $MA_MAX_AX_VELO[AX1]=10000\n");
    assert_eq!(judge(&cut).0, "refused");
}

#[test]
fn two_values_in_one_file_are_a_cause() {
    let visit = Visit::of(false, "mean");
    for (variable, one, other) in [
        ("$MA_ENC_COMP_ENABLE[0,AX1]", "0", "1"),
        ("$MN_SCALING_SYSTEM_IS_METRIC", "0", "1"),
        ("$MA_BACKLASH[0,AX1]", "0.001", "0.002"),
        ("$AA_ENC_COMP[0,1,AX1]", "9.0", "0.006"),
    ] {
        let says = format!("{variable} has several values in the files");
        visit.expect(&format!("{variable}={one}\n{variable}={other}"), "fail", &says);
    }
    let others = "$MA_BACKLASH[0,AX7]=1\n$MA_BACKLASH[0,AX7]=2\n$MA_BACKLASH[1,AX1]=1\n$MA_BACKLASH[1,AX1]=2";
    visit.expect(others, "pass", "$MA_BACKLASH[0,AX7], of others, has several values");
    let steps = cec("AX1", "AX2", "$AN_CEC_STEP[9]=0").replace("STEP[9]=10", "STEP[9]=50");
    let steps = steps.replace("MAX[9]=10", "MAX[9]=50");
    visit.expect(&steps, "fail", "$AN_CEC_STEP[9] has several values in the files");
    let fanuc = Visit::of(true, "curve-and-parameter");
    let twice = "N01851Q1A1P8\nN01851Q1A1P4";
    fanuc.expect(twice, "refused", "parameter 1851 of axis 1 has another value here");
    let paths = "N03602Q1L1P00000000L2P00000001\nN01851Q1A1P4";
    fanuc.expect(paths, "pass", "job and tables agree");
    let hidden = "IF R1==1 $MA_ENC_COMP_ENABLE[0,AX1]=0";
    visit.expect(hidden, "refused", "does not belong here");
}

/// Comments and messages of a control may be in one byte for each character.
#[test]
fn latin_1_and_a_byte_order_mark_do_not_stop_the_reading() {
    let visit = Visit::of(false, "mean");
    let text = visit.archive("CHANDATA(1) ;~berwachung");
    let bytes: Vec<u8> = text.bytes().map(|b| if b == b'~' { 0xDC } else { b }).collect();
    fs::write(visit.read_out.join("all.arc"), bytes).unwrap();
    let (verdict, page) = visit.verify("out");
    assert_eq!(verdict, "pass", "{page}");
    // An editor may have put its mark before the header of a program.
    let program = format!("\u{feff}%_N_NEW_MPF\n{}", visit.archive(""));
    let (verdict, page) = visit.judge_bytes(&[("all.arc", &program)]);
    assert_eq!(verdict, "undecided", "{page}");
}

#[test]
fn the_measuring_system_that_the_job_does_not_name_is_told() {
    let other = "$AA_ENC_COMP[1,0,AX1]=0\n$AA_ENC_COMP[1,1,AX1]=0.066\n$AA_ENC_COMP_STEP[1,AX1]=100\n$AA_ENC_COMP_MIN[1,AX1]=0\n$AA_ENC_COMP_MAX[1,AX1]=100\n";
    let visit = Visit::of(false, "mean");
    visit.expect(other, "undecided", "which of the two is active: state `measuring_system`");
    let off = format!("{other}$MA_ENC_COMP_ENABLE[1,AX1]=0");
    let visit = Visit::of(false, "two-tables"); // in CEC alone
    visit.expect(&off, "pass", "for the other measuring system and switched off: ignored");
}

#[test]
fn the_reference_point_is_judged_within_half_a_digit() {
    let visit = Visit::of(false, "mean");
    let set =
        |mm: &str| format!("N34100 $MA_REFP_SET_POS[0,AX1]={mm}\nN34100 $MA_REFP_SET_POS[1,AX1]=7");
    visit.expect(&set("0"), "pass", "job and tables agree");
    let absolute = format!("{}\nN34200 $MA_ENC_REFP_MODE[0,AX1]=0", set("-25.0"));
    visit.expect(&absolute, "pass", "job and tables agree");
    visit.expect(&set("-25.0"), "undecided", "MD34100 $MA_REFP_SET_POS[0,AX1] is -25 mm");
    let visit = Visit::of(true, "mean");
    visit.expect("N01240Q1A1P12000A2P0", "fail", "1240 of axis 1 is 12 mm");
    visit.expect("N01240Q1A1P0.0004A2P0", "pass", "job and tables agree");
    let four_digits = FANUC;
    let visit = Visit::new("fanuc-16i", "mean", four_digits);
    visit.expect("N1240A1P12000A2P0", "fail", "1240 of axis 1 is 12 mm");
    let visit = Visit::of(true, "curve-and-parameter");
    let wrong = "the control holds 9 µm, the job asks for 4 µm";
    visit.expect("N01851Q1A1P9.0", "fail", wrong);
}

#[test]
fn a_control_file_among_files_of_a_kit_is_judged() {
    let visit = Visit::of(true, "mean");
    let others: String = (0..200).map(|k| format!("N{:05}Q1P0\n", 100 + k)).collect();
    let whole = visit.archive(&others);
    let sign = visit.kit("checklist.md");
    let (verdict, page) = visit.judge_bytes(&[("CNC-PARA.TXT", &whole), ("checklist.md", &sign)]);
    assert_eq!(verdict, "pass", "{page}");
    assert!(
        page.contains(
            "`checklist.md` is a file of a kit that is not loaded with its tables: ignored"
        ),
        "{page}"
    );
    let kit = visit.directory.path().join("kit");
    fs::write(kit.join("CNC-PARA.TXT"), &whole).unwrap();
    let (verdict, page) = visit.verify("kit");
    assert_eq!(verdict, "fail", "{page}");
    assert!(
        page.contains("`CNC-PARA.TXT` holds far more than a kit, so it is the control's own"),
        "{page}"
    );
    fs::remove_file(kit.join("CNC-PARA.TXT")).unwrap();
}

#[test]
fn rows_of_a_foreign_axis_are_passed_over_or_doubted() {
    let axes = "[compensation.axes.x]\nspacing_mm = 50\n[compensation.axes.y]\nspacing_mm = 50\n";
    let visit = Visit::new("generic", "mean", axes);
    let table = visit.kit("compensation.csv");
    let rows = |row: &str| {
        let own: Vec<String> = table
            .lines()
            .filter(|line| line.starts_with("EYX,"))
            .map(|line| line.replacen("EYX,x,y", row, 1))
            .collect();
        assert!(own.len() > 1, "{table}");
        format!("{}\n{}\n", table.trim_end(), own.join("\n"))
    };
    let (verdict, page) = visit.judge_bytes(&[("table.csv", &rows("EZX,x,a"))]);
    assert_eq!(verdict, "pass", "{page}");
    assert!(
        page.contains("(a while x moves) belongs to axes that the job does not have"),
        "{page}"
    );
    let (verdict, page) = visit.judge_bytes(&[("table.csv", &rows("EYZ,a,y"))]);
    assert_eq!(verdict, "undecided", "{page}");
}

/// The checklist is for people: without it nothing is missing that the control reads.
#[test]
fn a_missing_checklist_is_a_note() {
    let visit = Visit::of(true, "mean");
    let kit: &Path = &visit.directory.path().join("kit");
    fs::remove_file(kit.join("checklist.md")).unwrap();
    let (verdict, page) = visit.verify("kit");
    assert_eq!(verdict, "pass", "{page}");
    assert!(page.contains("note: `checklist.md` is listed in manifest.json but missing"), "{page}");
}
