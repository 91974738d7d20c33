//! What a Siemens archive or file of machine data says of the compensation.
//!
//! ```text
//!   file ─→ sections (%_N_NAME_EXT) ─→ lines: of a table, of machine data, of no concern ─→ two texts
//! ```
//! An archive holds active data (`…_INI`) and part programs (`…_MPF`, `…_SPF`) one after the other. A
//! program lies in the memory and does nothing until somebody runs it, so what it would write is no
//! state of the control.

use crate::control::controller::LengthUnit;
use crate::read::siemens::{MOST_STATEMENTS, variable_text};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// A Siemens read-out, cut into what the strict reader takes one after the other: a table may be
/// written while its switch stands at 1 elsewhere in the same archive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiemensText {
    /// `$AA_ENC_COMP` and `$AN_CEC` lines.
    pub tables: String,
    /// Machine and setting data of the compensation.
    pub data: String,
    /// Statements that were passed over.
    pub passed_over: usize,
    /// Tables that are reserved but hold no grid (STEP 0), such as `AN_CEC[3]`.
    pub without_grid: Vec<String>,
    /// Part programs.
    pub programs: Programs,
    /// Variables of concern that the file holds with two values.
    pub twice: Vec<String>,
    /// The units that its data are in, where it says so (`METRIC`, `INCH`).
    pub units: Vec<LengthUnit>,
}

/// The part programs of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Programs {
    /// Their names, such as `NONIUS_EEC_MPF`.
    pub names: Vec<String>,
    /// Whether they write tables.
    pub write_tables: bool,
}

/// The data that are read beside tables.
const DATA: [&str; 13] = [
    "MA_ENC_COMP_ENABLE",
    "MA_CEC_ENABLE",
    "MA_CEC_MAX_SUM",
    "MA_CEC_SCALING_SYSTEM_METRIC",
    "MA_BACKLASH",
    "MA_ENC_REFP_MODE",
    "MA_MM_ENC_COMP_MAX_POINTS",
    "MA_REFP_SET_POS",
    "MN_CONVERT_SCALING_SYSTEM",
    "MN_MM_CEC_MAX_POINTS",
    "MN_SCALING_SYSTEM_IS_METRIC",
    "SN_CEC_TABLE_ENABLE",
    "SN_CEC_TABLE_WEIGHT",
];

/// `NAME[indices]=value` of a line, upper case and without blanks.
struct Line {
    name: String,
    indices: Vec<String>,
    value: String,
}

/// The code of a line: upper case, without comment, block number, blanks and checksum.
fn code(text: &str) -> String {
    let text = match text.trim_ascii() {
        "" => return String::new(), // a file can hold millions of blank lines
        _ => without_checksum(text),
    };
    let code = text.split(';').next().unwrap_or_default();
    let code: String = code
        .chars()
        .filter(|c| !c.is_whitespace() && *c != '&')
        .collect();
    let code = code.to_ascii_uppercase();
    match code.strip_prefix('N') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => rest
            .trim_start_matches(|c: char| c.is_ascii_digit())
            .to_string(),
        _ => code,
    }
}

fn line(code: &str) -> Option<Line> {
    let (head, value) = code.strip_prefix('$')?.split_once('=')?;
    let (name, indices) = head.split_once('[').unwrap_or((head, ""));
    let indices = indices.trim_end_matches(']').split(',');
    Some(Line {
        name: name.to_string(),
        indices: indices.map(str::to_string).collect(),
        value: value.to_string(),
    })
}

impl Line {
    /// The table it belongs to.
    fn table(&self) -> Option<String> {
        let first = self.indices.first()?;
        if self.name.starts_with("AN_CEC") {
            return Some(format!("AN_CEC[{first}]"));
        }
        let last = self.indices.last()?;
        self.name
            .starts_with("AA_ENC_COMP")
            .then(|| format!("AA_ENC_COMP[{first},{last}]"))
    }

    /// Of a step, 0: the control reserves memory for the table and nobody filled it.
    fn is_without_grid(&self) -> bool {
        self.value.parse().is_ok_and(|step: f64| step.abs() <= 0.0)
    }

    /// Whether it is read beside tables. Of the reference point values the first alone: the others
    /// are for further reference cams.
    fn is_datum(&self) -> bool {
        let is_other_cam = self.name == "MA_REFP_SET_POS" && self.indices[0] != "0";
        DATA.contains(&self.name.as_str()) && !is_other_cam
    }

    fn variable(&self) -> String {
        variable_text(&self.name, &self.indices)
    }

    /// Its value, so that equal ones are the same text.
    fn plain_value(&self) -> String {
        match (self.value.as_str(), self.value.parse::<f64>()) {
            ("TRUE", _) => "1".to_string(),
            ("FALSE", _) => "0".to_string(),
            (_, Ok(number)) => number.to_string(),
            (text, Err(_)) => text.to_string(),
        }
    }
}

/// Whether code that is no plain assignment writes data of the compensation all the same, as in
/// `IF R1==1 $MA_CEC_ENABLE[AX1]=0`, or is a broken one.
fn speaks_of_compensation(code: &str) -> bool {
    let tables = ["AA_ENC_COMP", "AN_CEC"];
    let mut names = DATA.iter().chain(&tables);
    code.contains('$') && names.any(|name| code.contains(&format!("${name}")))
}

/// Where a file stands, by its lines: the section that the line is in is a part program or lies in
/// a folder of programs and workpieces, or it is active data.
struct Sections {
    of_program: Vec<bool>,
    /// Names of the programs.
    programs: Vec<String>,
}

/// The sections of a file. One without headers is a program where its own name says so.
fn sections(file: &str, text: &str) -> Sections {
    let is_program = |name: &str| {
        let name = name.to_ascii_uppercase().replace('.', "_");
        name.ends_with("_MPF") || name.ends_with("_SPF")
    };
    let mut found = Sections {
        of_program: Vec::new(),
        programs: Vec::new(),
    };
    let mut lines = text.split('\n').peekable();
    let mut inside = is_program(file);
    if inside
        && !lines
            .clone()
            .any(|text| text.trim_start().starts_with("%_N_"))
    {
        found.programs.push(file.to_string());
    }
    while let Some(text) = lines.next() {
        if let Some(name) = text.trim().strip_prefix("%_N_") {
            let path = lines.peek().copied().unwrap_or_default();
            let path = path.trim().to_ascii_uppercase();
            let lies_apart = [
                "_N_WKS_DIR",
                "_N_MPF_DIR",
                "_N_SPF_DIR",
                "_N_CST_DIR",
                "_N_CUS_DIR",
            ];
            let lies_apart = path.starts_with(";$PATH=")
                && lies_apart.iter().any(|folder| path.contains(folder));
            inside = is_program(name) || lies_apart;
            found.programs.extend(inside.then(|| name.to_string()));
        }
        found.of_program.push(inside);
    }
    found
}

/// Whether a file holds active data: an assignment outside part programs.
pub fn has_active_data(file: &str, text: &str) -> bool {
    let of_program = sections(file, text).of_program;
    let lines = text.split('\n').zip(&of_program);
    let mut data = lines.filter(|(_, inside)| !**inside);
    data.any(|(text, _)| line(&code(text)).is_some())
}

/// Whether a table is written in the part programs of a file.
fn writes_tables(text: &str, of_program: &[bool]) -> bool {
    let lines = text.split('\n').zip(of_program);
    let mut inside = lines.filter(|(_, inside)| **inside);
    inside.any(|(text, _)| line(&code(text)).is_some_and(|line| line.table().is_some()))
}

/// Cuts a Siemens read-out. Part programs are read where no file of the read-out holds active data.
///
/// limits end words and headers between the parts of an archive are passed over, but the last end
///        word stays, and what follows it: a file that goes on without one is not complete
pub fn siemens<'t>(file: &str, text: &'t str, reads_programs: bool) -> SiemensText {
    let Sections {
        mut of_program,
        programs,
    } = sections(file, text);
    let programs = Programs {
        write_tables: writes_tables(text, &of_program),
        names: programs,
    };
    if reads_programs {
        of_program.fill(false);
    }
    // Lines are taken apart twice, so that nothing is kept for each of them.
    let lines = || {
        let coded = |(text, inside): (&'t str, &bool)| match *inside || text.is_empty() {
            true => (text, String::new()),
            false => (text, code(text)),
        };
        text.split('\n').zip(&of_program).map(coded)
    };
    let seen = Seen::in_codes(lines().map(|(_, code)| code));
    let mut cut = Cut::default();
    for (index, (text, code)) in lines().enumerate() {
        let behind_end = seen.end.is_some_and(|end| index > end);
        match line(&code) {
            _ if Some(index) == seen.end => cut.put(text, text),
            Some(_) if behind_end => cut.put(text, ""),
            Some(own) => cut.sort(text, &own, &seen.empty),
            None if speaks_of_compensation(&code) => cut.put(text, ""),
            None => cut.put("", ""),
        }
    }
    SiemensText {
        tables: cut.tables.text,
        data: cut.data.text,
        passed_over: cut.passed_over,
        without_grid: seen.empty.into_iter().collect(),
        programs,
        twice: cut.twice.into_iter().collect(),
        units: seen.units.into_iter().collect(),
    }
}

/// What has to be known of all lines before they are sorted.
#[derive(Default)]
struct Seen {
    /// The last end word.
    end: Option<usize>,
    /// Tables with a STEP of 0 and no other.
    empty: BTreeSet<String>,
    /// The units that the data are in: what a control writes before them, whichever it counts in.
    units: Vec<LengthUnit>,
}

impl Seen {
    fn in_codes(codes: impl Iterator<Item = String>) -> Seen {
        let mut seen = Seen::default();
        let mut filled = BTreeSet::new();
        let (mut metric, mut inch) = (false, false);
        for (index, code) in codes.enumerate() {
            if is_end(&code) {
                seen.end = Some(index);
            }
            metric |= code == "METRIC";
            inch |= code == "INCH";
            let Some(step) = line(&code).filter(|line| line.name.ends_with("_STEP")) else {
                continue;
            };
            let kind = match step.is_without_grid() {
                true => &mut seen.empty,
                false => &mut filled,
            };
            kind.extend(step.table());
        }
        seen.empty.retain(|table| !filled.contains(table));
        seen.units.extend(metric.then_some(LengthUnit::Millimetre));
        seen.units.extend(inch.then_some(LengthUnit::Inch));
        seen
    }
}

/// Lines as a text, each where it stood.
#[derive(Default)]
struct Kept {
    text: String,
    has_lines: bool,
}

impl Kept {
    fn put(&mut self, line: &str) {
        if std::mem::replace(&mut self.has_lines, true) {
            self.text.push('\n');
        }
        self.text.push_str(&without_checksum(line));
    }
}

/// The two texts as they grow.
#[derive(Default)]
struct Cut {
    tables: Kept,
    data: Kept,
    passed_over: usize,
    values: BTreeMap<String, String>,
    twice: BTreeSet<String>,
}

impl Cut {
    fn put(&mut self, table: &str, datum: &str) {
        self.tables.put(table);
        self.data.put(datum);
    }

    fn sort(&mut self, text: &str, own: &Line, empty: &BTreeSet<String>) {
        match own.table() {
            Some(key) if empty.contains(&key) => return self.put("", ""),
            // The table has another step too, which is two values of one variable.
            Some(_) if own.name.ends_with("_STEP") && own.is_without_grid() => self.put("", ""),
            Some(_) => self.put(text, ""),
            None if own.is_datum() => self.put("", text),
            None => {
                self.passed_over += 1;
                return self.put("", "");
            }
        }
        // One of the two texts is refused where there are more.
        if self.values.len() > 2 * MOST_STATEMENTS {
            return;
        }
        let (variable, value) = (own.variable(), own.plain_value());
        match self.values.insert(variable.clone(), value.clone()) {
            Some(old) if old != value => {
                self.twice.insert(variable);
            }
            _ => {}
        }
    }
}

/// A line without the checksum that a control may write behind an assignment: blank, apostrophe,
/// four hexadecimal digits (MD11230 `MD_FILE_STYLE`; 840D/810D Start-Up Guide 03/2006, 11.12.1).
/// It is passed over, not checked: how it is computed is not published.
fn without_checksum(line: &str) -> Cow<'_, str> {
    let code = line.split(';').next().unwrap_or_default();
    let Some((statement, sum)) = code.rsplit_once('\'') else {
        return Cow::Borrowed(line);
    };
    let digits = sum.trim_end();
    let is_sum = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    if !is_sum || !statement.contains('=') || !statement.ends_with([' ', '\t']) {
        return Cow::Borrowed(line);
    }
    let blanks = " ".repeat(code.len() - statement.len());
    Cow::Owned(format!("{statement}{blanks}{}", &line[code.len()..]))
}

fn is_end(code: &str) -> bool {
    matches!(code, "M17" | "M30" | "M2" | "M02")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_archive_keeps_its_lines_in_place() {
        let text = "%_N_NC_TEA_INI\nCHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\n\
                    N32450 $MA_BACKLASH[0,AX1]=0.005\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n\
                    %_N_NC_CEC_INI\n$AN_CEC_STEP[3]=0\n$AN_CEC[3,0]=0\n$AN_CEC_STEP[1]=50\nM17\n";
        let cut = siemens("all.arc", text, false);
        let place = |text: &str, word: &str| text.lines().position(|line| line.contains(word));
        assert_eq!(place(&cut.data, "BACKLASH"), Some(3));
        assert_eq!(place(&cut.tables, "AN_CEC_STEP[1]"), Some(9));
        assert_eq!(
            cut.tables.matches("M17").count(),
            1,
            "the last end word only"
        );
        assert_eq!(cut.passed_over, 1);
        assert_eq!(cut.without_grid, ["AN_CEC[3]"]);
        assert_eq!(place(&cut.data, "IS_METRIC"), Some(4));
    }

    #[test]
    fn line_checksums_are_passed_over() {
        let text = "N32450 $MA_BACKLASH[0,AX1]=0.005 '2F34\n$AN_CEC_STEP[3]=0 'ab01 ;later\n\
                    $AN_CEC[1,0]=0.001 '00FF\r\n$AN_CEC[1,1]=0.002 '00F\nM17\n";
        let cut = siemens("all.arc", text, false);
        let lines: Vec<&str> = cut.data.lines().collect();
        assert_eq!(lines[0].trim_end(), "N32450 $MA_BACKLASH[0,AX1]=0.005");
        assert_eq!(lines[0].len(), text.lines().next().unwrap_or("").len());
        assert_eq!(cut.without_grid, ["AN_CEC[3]"]);
        let lines: Vec<&str> = cut.tables.lines().collect();
        assert_eq!(lines[2].trim_end(), "$AN_CEC[1,0]=0.001");
        assert!(lines[3].ends_with("'00F"), "three digits are no checksum");
    }

    #[test]
    fn a_program_in_an_archive_is_no_state() {
        let data = "%_N_AX_EEC_INI\n$AA_ENC_COMP[0,1,AX1]=0.055\nM17\n";
        let program = "%_N_NEW_MPF\n;$PATH=/_N_MPF_DIR\n$AA_ENC_COMP[0,1,AX1]=0.016\nM30\n";
        for text in [format!("{data}{program}"), format!("{program}{data}")] {
            let cut = siemens("all.arc", &text, false);
            assert!(cut.tables.contains("0.055") && !cut.tables.contains("0.016"));
            assert_eq!(cut.programs.names, ["NEW_MPF"]);
            assert!(cut.programs.write_tables && cut.twice.is_empty());
            assert!(has_active_data("all.arc", &text));
        }
        assert!(!has_active_data("new", program));
        assert!(siemens("new", program, true).tables.contains("0.016"));
        let without_header = "$AA_ENC_COMP[0,1,AX1]=0.016\nM30\n";
        assert!(has_active_data("eec.txt", without_header));
        assert!(!has_active_data("EEC.MPF", without_header));
        let workpiece = "%_N_INIT_INI\n;$PATH=/_N_WKS_DIR/_N_A_WPD\n$MA_BACKLASH[0,AX1]=1\nM17\n";
        assert!(!has_active_data("all.arc", workpiece));
    }

    #[test]
    fn two_values_of_one_variable_are_told() {
        let text = "$MA_CEC_ENABLE[AX1]=0\n$MA_BACKLASH[0,AX1]=1\n$MA_CEC_ENABLE[AX1]=TRUE\n\
                    $MA_BACKLASH[0,AX1]=1.000\n$MN_OTHER=1\n$MN_OTHER=2\nM17\n";
        assert_eq!(
            siemens("all.arc", text, false).twice,
            ["$MA_CEC_ENABLE[AX1]"]
        );
        let steps = siemens(
            "all.arc",
            "$AN_CEC_STEP[5]=0\n$AN_CEC_STEP[5]=50\nM17\n",
            false,
        );
        assert_eq!(steps.twice, ["$AN_CEC_STEP[5]"]);
        assert!(steps.without_grid.is_empty());
    }

    #[test]
    fn what_is_no_plain_assignment_is_not_swallowed() {
        let text = "IF R1==1 $MA_CEC_ENABLE[AX1]=0\n$MA_BACKLASH[0,AX1] 0.5\nG0 X1\nM17\n";
        assert_eq!(
            siemens("all.arc", text, false)
                .tables
                .lines()
                .filter(|l| !l.is_empty())
                .count(),
            3
        );
        let cut_off = siemens("all.arc", "$AN_CEC[0,0]=1\nM17\n$MN_OTHER=1\n", false);
        assert!(
            cut_off.tables.contains("$MN_OTHER"),
            "it goes on behind the end"
        );
    }
}
