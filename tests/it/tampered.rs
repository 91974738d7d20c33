//! `verify` finds what happens to files between laptop and control, and names it.
//!
//! Kits are changed with an editor's means (no number comes from the program) and judged, in words that name the mistake.

mod as_a_control_reads;

use crate::support::{Ran, Visit, cec, replaced, with_cells};
use std::fs;

const EEC: &str = "NONIUS_EEC.MPF";
const CEC: &str = "NONIUS_CEC.MPF";
const ON: &str = "NONIUS_ENABLE.MPF";
const OFF: &str = "NONIUS_DISABLE.MPF";
const MEMORY: &str = "NONIUS_MEMORY.TXT";
const POINTS: &str = "PITCH.TXT";
const PARAMETERS: &str = "CNC-PARA.TXT";
const CSV: &str = "compensation.csv";

struct Kit(Visit);

impl Kit {
    fn of(control: &str) -> Kit {
        Kit::made(Visit::with_job(&format!("nine_errors_900/{control}.toml")))
    }

    fn made(visit: Visit) -> Kit {
        Kit(visit.with_kit())
    }

    /// As it is read out of a control: only the contents can tell.
    fn without_manifest(control: &str) -> Kit {
        let kit = Kit::of(control);
        kit.remove("manifest.json");
        kit
    }

    fn remove(&self, file: &str) {
        fs::remove_file(self.0.at("kit").join(file)).unwrap();
    }

    #[track_caller]
    fn verify(&self) -> Ran {
        self.0.run("verify job.toml --tables kit")
    }

    #[track_caller]
    fn agrees(&self) -> Ran {
        self.verify().ends(0).says("job and tables agree")
    }

    /// What `verify` says with one file changed, which is put back.
    #[track_caller]
    fn changed(&self, file: &str, change: impl Fn(&str) -> String) -> Ran {
        let name = format!("kit/{file}");
        let good = self.0.read(&name);
        let bad = change(&good);
        assert_ne!(good, bad, "{file}: nothing was changed");
        self.0.put(&name, bad);
        let ran = self.verify();
        self.0.put(&name, good);
        ran
    }

    #[track_caller]
    fn yes(&self, file: &str, change: impl Fn(&str) -> String) -> Ran {
        self.changed(file, change).ends(0)
    }

    #[track_caller]
    fn no(&self, file: &str, change: impl Fn(&str) -> String) -> Ran {
        self.changed(file, change).ends(1)
    }

    #[track_caller]
    fn unread(&self, file: &str, change: impl Fn(&str) -> String) -> Ran {
        self.changed(file, change).ends(2)
    }
}

fn behind_first_percent(blocks: &str) -> impl Fn(&str) -> String {
    move |text| text.replacen('%', &format!("%\n{blocks}"), 1)
}

/// What becomes of each line; `None` = removed.
fn lines(change: impl Fn(&str) -> Option<String>) -> impl Fn(&str) -> String {
    move |text| text.split('\n').filter_map(&change).collect::<Vec<_>>().join("\n")
}

fn cut(head: &str) -> impl Fn(&str) -> String {
    lines(move |line| (!line.trim_start().starts_with(head)).then(|| line.to_string()))
}

fn swap(old: &str, new: &str) -> impl Fn(&str) -> String {
    move |text| replaced(text, old, new)
}

/// The number behind `mark` changed in the lines that begin with one of `heads`.
fn figures(heads: &[&str], mark: char, change: impl Fn(f64) -> f64) -> impl Fn(&str) -> String {
    lines(move |line| {
        if !heads.iter().any(|head| line.trim_start().starts_with(head)) {
            return Some(line.to_string());
        }
        let (name, rest) = line.split_once(mark)?;
        let end = rest.find(' ').unwrap_or(rest.len());
        let value = change(rest[..end].parse().ok()?);
        let value = if mark == '=' { format!("{value:.6}") } else { value.to_string() };
        Some(format!("{name}{mark}{value}{}", &rest[end..]))
    })
}

/// The ENC_COMP table of AX1 for the other measuring system.
fn of_system_2(text: &str) -> String {
    let system = |line: &str| match line.contains(",AX1]") {
        true => line.replace("[0,", "[1,"),
        false => line.to_string(),
    };
    lines(|line| Some(system(line)))(text)
}

const SYSTEM_2: &str = "foreign measuring system: the ENC_COMP table of AX1 is for system 2";

#[test]
fn siemens() {
    let kit = Kit::of("siemens-840d-sl");
    kit.agrees();
    // A note written into the checklist, which no control reads.
    kit.yes("checklist.md", swap("# Checklist", "# Checklist, done"))
        .says("`checklist.md` was changed after it was made");
    let (lec, cec) = (&["$AA_ENC_COMP["], &["$AN_CEC["]);
    kit.no(EEC, figures(lec, '=', |v| -v)).says("EXX (AX1 while AX1 moves): wrong sign");
    kit.no(CEC, figures(cec, '=', |v| -v)).says("EYX (AX2 while AX1 moves): wrong sign");
    kit.no(EEC, figures(&["$AA_ENC_COMP_M"], '=', |v| v + 30.0))
        .says("EXX (AX1 while AX1 moves): shifted reference: the table stands 30.0000 mm");
    kit.no(CEC, figures(&["$AN_CEC_MIN", "$AN_CEC_MAX"], '=', |v| v + 30.0))
        .says("EYX (AX2 while AX1 moves): shifted reference");
    kit.no(EEC, figures(lec, '=', |v| v * 1000.0))
        .says("wrong scale: the corrections are 1000 times too large");
    kit.no(CEC, figures(cec, '=', |v| v * 1000.0)).says("check their scale");
    kit.no(EEC, cut("$AA_ENC_COMP[0,7,AX1]")).says("$AA_ENC_COMP[0,AX1]: point 7 is missing");
    kit.no(CEC, cut("$AN_CEC[0,7]")).says("$AN_CEC[0]: point 7 is missing");
    kit.no(EEC, swap("AX1]", "AX4]")).says("foreign axis: the tables correct AX4 while AX4 moves");
    kit.no(EEC, of_system_2).says(SYSTEM_2);
    kit.no(CEC, swap("OUTPUT_AXIS[0]=(AX2)", "OUTPUT_AXIS[0]=(AX3)"))
        .says("foreign axis: the corrections of EYX are added to its own");
    kit.no(CEC, swap("DIRECTION[0]=0", "DIRECTION[0]=1"))
        .says("EYX (AX2 while AX1 moves in -): missing");
    kit.no(ON, cut("$SN_CEC_TABLE_ENABLE[0]")).says("does not switch on CEC table 0");
    // The transfer broke off.
    kit.unread(EEC, cut("M30")).says("the file has no end word; it is not complete");
    kit.no(EEC, swap("=0.006464", "=0.007464"))
        .says("another value at 150.0000 mm, where the tables correct");
    kit.no(EEC, swap("golden 900", "another machine"))
        .says("its hash is not that of manifest.json");
    // A transfer may change the line ends and nothing else: told as other bytes with the same values.
    let only_bytes = "read back, tables and switches are as the job asks";
    kit.no(EEC, swap("\n", "\r\n")).says(only_bytes);
    kit.changed(EEC, swap("=0.018", "=0.019")).says("another value").omits(only_bytes);
    kit.unread("manifest.json", cut("}")).says("`manifest.json` is damaged");
}

#[test]
fn fanuc() {
    let kit = Kit::of("fanuc-30i");
    kit.agrees();
    kit.no(POINTS, figures(&["N1"], 'P', |v| 0.0 - v))
        .says("EXX (1 while 1 moves): wrong sign")
        .omits("other values"); // what is named by its cause is not told point by point
    kit.no(PARAMETERS, swap("N03620Q1A1P0A", "N03620Q1A1P1A"))
        .says("EXX (1 while 1 moves): shifted reference");
    kit.no(PARAMETERS, swap("N03623Q1A1P1A", "N03623Q1A1P2A"))
        .says("EXX (1 while 1 moves): wrong scale: every correction is double");
    kit.no(PARAMETERS, swap("N03623Q1A1P1A", "N03623Q1A1P3A"))
        .says("wrong scale: every correction is 3.000 times");
    // Each node of one interval (3624) lies between the same steps of the other.
    kit.no(PARAMETERS, swap("A1P30.0A", "A1P30.5A"))
        .says("other spacing: the points are 30.5000 mm apart");
    // One increment mistyped, above the reference point and below one.
    kit.no(POINTS, swap("N10010Q0P0", "N10010Q0P5"))
        .says("EXX (1 while 1 moves): one step is changed: from 270.0000 to 300.0000 mm the correction changes by 5.000 µm, the job asks for 0.000 µm; so every correction from 300.0000 mm on is off by 5.000 µm");
    kit.no(POINTS, swap("N10090Q0P0", "N10090Q0P1"))
        .says("EZZ (3 while 3 moves): one step is changed: from -480.0000 to -456.0000 mm the correction changes by 1.000 µm, the job asks for 0.000 µm; so every correction up to -480.0000 mm is off by -1.000 µm");
    kit.no(POINTS, cut("N10007")).says("point 7 is missing");
    kit.no(POINTS, cut("N16007")).says("point 6007 is missing");
    // Axes 1 and 2 exchanged.
    kit.no(PARAMETERS, |t| t.replace("A1P", "A#P").replace("A2P", "A1P").replace("A#P", "A2P"))
        .says("EXX (1 while 1 moves): foreign axis: these are the corrections of EYY");
    kit.no(PARAMETERS, swap("N05721Q1L1P2", "N05721Q1L1P3"))
        .says("foreign axis: the corrections of EYX are added to its own");
}

/// The rows of a table changed by their cells; without those of which `keep` says no.
fn rows(keep: impl Fn(&mut [String]) -> bool) -> impl Fn(&str) -> String {
    move |text| with_cells(text, |cells| cells[0] == "term" || cells.len() == 1 || keep(cells))
}

fn columns(first: usize, count: usize, change: fn(f64) -> f64) -> impl Fn(&str) -> String {
    rows(move |cells| {
        for cell in cells.iter_mut().skip(first).take(count).filter(|cell| !cell.is_empty()) {
            *cell = change(cell.parse().unwrap()).to_string();
        }
        true
    })
}

#[test]
fn generic() {
    let kit = Kit::of("generic");
    kit.agrees();
    // One of the twins cut.
    kit.unread(CSV, |text| text.replacen("EXX,x,x,,30,", "# EXX,x,x,,30,", 1));
    kit.remove("compensation.json");
    kit.no(CSV, columns(6, 9, |v| 0.0 - v)).says("wrong sign");
    kit.no(CSV, columns(6, 9, |v| v * 1000.0))
        .says("wrong scale: the corrections are 1000 times too large");
    kit.no(CSV, columns(5, 1, |v| v + 12.0)).says("shifted reference: the table stands 12.0000 mm");
    kit.no(CSV, rows(|c| !(c[0] == "EXX" && c[4] == "30")))
        .says("EXX (x while x moves): missing points");
    kit.unread(CSV, rows(|c| !(c[0] == "EXX" && c[4] == "7"))).says("`index` is 8, expected 7");
    kit.no(CSV, rows(|c| c[0] != "EYX")).says("EYX (y while x moves): missing");
    kit.no(CSV, swap("EYX,x,y", "EYX,x,w")).says("foreign axis");
}

#[test]
fn a_whole_file_missing() {
    let siemens = [EEC, CEC].map(|file| ("siemens-840d-sl", file));
    let fanuc = [POINTS, PARAMETERS].map(|file| ("fanuc-30i", file));
    for (control, file) in [&siemens[..], &fanuc, &[("generic", CSV)]].concat() {
        let kit = Kit::of(control);
        kit.remove(file);
        kit.verify().ends(1).says(&format!("`{file}` is listed in manifest.json but missing"));
    }
}

#[test]
fn the_verdict_stands_first_and_a_missing_manifest_is_told() {
    let judged =
        "judged as a kit that is to be loaded, because `compensation.csv` is called as in one";
    let ran = Kit::without_manifest("generic").verify();
    let ran = ran.says("note: there is no manifest.json").says(judged);
    assert!(ran.out.starts_with("verdict: pass (asked: "), "{}", ran.out);
}

#[test]
fn tables_without_files_that_switch_are_judged_with_a_note() {
    let kit = Kit::without_manifest("siemens-840d-sl");
    for name in [ON, OFF, MEMORY] {
        kit.remove(name);
    }
    kit.agrees().tells(&[
        "note: no file switches the tables on; see to MD32700 $MA_ENC_COMP_ENABLE = 1, SD41300",
        "note: no file switches the tables off",
        "note: no file reserves their memory; see to MD38000 $MA_MM_ENC_COMP_MAX_POINTS, MD18342",
    ]);
    kit.no(EEC, of_system_2).says(SYSTEM_2);
}

/// A control keeps what no line writes, and only the reading can find that; one line of each kind is taken out.
#[test]
fn an_assignment_that_a_kit_lacks_is_found_without_its_manifest() {
    for (control, files) in [
        ("siemens-840d-sl", &[EEC, CEC, ON, OFF, MEMORY][..]),
        ("fanuc-30i", &[PARAMETERS, POINTS]),
    ] {
        let kit = Kit::without_manifest(control);
        kit.agrees();
        for file in files {
            let good = kit.0.read(&format!("kit/{file}"));
            let lines: Vec<&str> = good.split_inclusive('\n').collect();
            let mut kinds = Vec::new();
            for (index, line) in lines.iter().enumerate() {
                let code = line.trim();
                let begins = |rest: &&str| rest.starts_with(|c: char| c.is_ascii_digit());
                let number = code.strip_prefix('N').filter(begins);
                let kind = match code.starts_with('$') {
                    true => code.split('[').next(),
                    false => number.and_then(|rest| rest.split(['Q', ' ']).next()),
                };
                let is_point = code.contains("Q0");
                let seen = |kind: &&str| {
                    kinds.iter().any(|(known, is_one)| known == kind || (is_point && *is_one))
                };
                let Some(kind) = kind.filter(|kind| !seen(kind)) else { continue };
                kinds.push((kind, is_point));
                let ran =
                    kit.changed(file, |_| [&lines[..index], &lines[index + 1..]].concat().concat());
                assert!(
                    matches!(ran.status, Some(1 | 2)),
                    "without `{code}` of {file}\n{}",
                    ran.all()
                );
                let fields = ["IS_MODULO", "MULT_BY_TABLE", "DIRECTION"];
                if let Some(field) = fields.iter().find(|field| kind.ends_with(*field)) {
                    ran.says(&format!("no file writes {field} of "));
                }
            }
            assert!(!kinds.is_empty(), "{file}");
        }
    }
}

#[test]
fn what_operating_systems_leave_is_passed_over_and_a_foreign_program_is_not() {
    let kit = Kit::made(Visit::of("start/errors"));
    let visit = &kit.0;
    visit
        .put("kit/.DS_Store", b"\0\0\0\x01Bud1\xff")
        .put("kit/Thumbs.db", b"\xd0\xcf\x11\xe0")
        .put("kit/desktop.ini", "[.ShellClassInfo]\r\n");
    fs::create_dir(visit.at("kit/System Volume Information")).unwrap();
    let words = "`.DS_Store` was ignored: an operating system left it";
    kit.verify().ends(0).says(words);
    let manifest = visit.read("kit/manifest.json");
    kit.remove("manifest.json");
    kit.verify().ends(0).says(words);
    // What is not listed, too, unless the control would read it.
    visit.put("kit/manifest.json", manifest);
    visit.put("kit/offer.pdf", b"%PDF-1.7\n\xff\xfe");
    visit.put("kit/notes.txt", "called the customer on Monday\n");
    let words = "`notes.txt` was ignored: manifest.json does not list it";
    kit.verify().ends(0).says(words);
    visit.put("kit/OLD.MPF", cec(7, ["AX1", "AX2"], 100, [0.01, 0.02]) + "M30\n");
    let words = "`OLD.MPF` is not listed in manifest.json, and the control could read it";
    kit.verify().ends(1).says(words);
    visit.put("kit/OLD.MPF", "$AN_CEC[7,0]=0.01\nM30\n");
    kit.verify().ends(2).says("OLD.MPF");
    // A program for the control is told also where it sets no variable; a text for people is not.
    visit.put("kit/OLD.MPF", "G0 X100\nM30\n");
    kit.verify().ends(2).says("`G0 X100` does not belong here").says("OLD.MPF:1:1");
    visit.put("kit/OLD.MPF", "M30 was looked at\n");
    kit.verify().ends(0).says("`OLD.MPF` was ignored");
}

#[test]
fn other_inputs_and_another_control_are_named() {
    let kit = Kit::made(Visit::of("start/errors"));
    let visit = &kit.0;
    visit.put("job.toml", visit.read("job.toml") + "# a comment\n");
    let words = "the kit was made from other inputs: `job.toml` differ";
    kit.verify().ends(0).says(words);
    let words = "the kit was made for another control: manifest.json names `siemens-840d-sl`";
    visit.edit("job.toml", "siemens-840d-sl", "siemens-828d");
    kit.verify().ends(1).says(words);
    visit.edit("job.toml", "siemens-828d", "fanuc-30i");
    visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
    kit.verify().ends(2).says(words);
}
