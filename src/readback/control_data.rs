//! Files read out of a control: the lines that concern the compensation, the rest passed over.
//!
//! An archive of machine data or a full parameter file holds thousands of numbers of no concern,
//! in forms that the readers of compensation files refuse. Here such lines are blanked out, at
//! the same places, so that the strict readers judge what is left and their line numbers hold.

use crate::controller::{Dialect, FanucFacts};
use std::borrow::Cow;

/// A file with more data of no concern than this was read out of a control as a whole, which has
/// thousands. What a kit writes is of concern throughout; a person may have added a few lines.
const READ_OUT_AS_A_WHOLE: usize = 100;

/// Whether a file is a control's whole parameter file or archive.
pub fn is_whole(text: &str, dialect: &Dialect) -> bool {
    let passed_over = match dialect {
        Dialect::Siemens(_) => siemens(text).passed_over,
        Dialect::Fanuc(facts) => fanuc(text, facts).1,
        Dialect::Generic(_) => 0,
    };
    passed_over > READ_OUT_AS_A_WHOLE
}

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
}

/// The data that are read beside tables.
const DATA: [&str; 10] = [
    "MA_ENC_COMP_ENABLE",
    "MA_CEC_ENABLE",
    "MA_CEC_MAX_SUM",
    "MA_CEC_SCALING_SYSTEM_METRIC",
    "MA_BACKLASH",
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

fn line(text: &str) -> Option<Line> {
    let text = without_checksum(text);
    let code = text.split(';').next().unwrap_or_default();
    let code: String = code
        .chars()
        .filter(|c| !c.is_whitespace() && *c != '&')
        .collect();
    let code = code.to_ascii_uppercase();
    let code = match code.strip_prefix('N') {
        Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => &code,
    };
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

    /// A step of 0: the control reserves memory for the table and nobody filled it.
    fn is_without_grid(&self) -> bool {
        self.name.ends_with("_STEP") && self.value.parse().is_ok_and(|step: f64| step.abs() <= 0.0)
    }
}

/// Cuts a Siemens read-out.
///
/// limits end words and headers between the parts of an archive are passed over, but the last end
///        word stays: a file without one is not complete
pub fn siemens(text: &str) -> SiemensText {
    let lines: Vec<&str> = text.split('\n').collect();
    let end = lines.iter().rposition(|line| is_end(line));
    let empty: std::collections::BTreeSet<_> = lines
        .iter()
        .filter_map(|text| line(text))
        .filter(Line::is_without_grid)
        .filter_map(|line| line.table())
        .collect();
    let (mut tables, mut data) = (Vec::new(), Vec::new());
    let mut passed_over = 0;
    for (index, text) in lines.iter().enumerate() {
        let (mut table, mut datum) = ("", "");
        if Some(index) == end {
            (table, datum) = (text, text);
        } else if let Some(own) = line(text) {
            match own.table() {
                Some(key) if empty.contains(&key) => {}
                Some(_) => table = text,
                None if DATA.contains(&own.name.as_str()) => datum = text,
                None => passed_over += 1,
            }
        }
        tables.push(without_checksum(table));
        data.push(without_checksum(datum));
    }
    SiemensText {
        tables: tables.join("\n"),
        data: data.join("\n"),
        passed_over,
        without_grid: empty.into_iter().collect(),
    }
}

/// A line without the checksum that a control may write behind an assignment: blank, apostrophe,
/// four hexadecimal digits (MD11230 `MD_FILE_STYLE`; 840D/810D Start-Up Guide 03/2006, 11.12.1).
/// It is passed over, not checked: how it is computed is not published.
fn without_checksum(line: &str) -> Cow<'_, str> {
    let code = line.split(';').next().unwrap_or_default();
    let Some((statement, sum)) = code.rsplit_once(" '") else {
        return Cow::Borrowed(line);
    };
    let digits = sum.trim_end();
    let is_sum = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    if !is_sum || !statement.contains('=') {
        return Cow::Borrowed(line);
    }
    let blanks = " ".repeat(code.len() - statement.len());
    Cow::Owned(format!("{statement}{blanks}{}", &line[code.len()..]))
}

fn is_end(line: &str) -> bool {
    let code = line.split(';').next().unwrap_or_default();
    let word = code.split_whitespace().last().unwrap_or_default();
    ["M17", "M30", "M2", "M02"]
        .iter()
        .any(|end| word.eq_ignore_ascii_case(end))
}

/// First and last number of the Fanuc parameters that pitch, straightness and backlash need, and
/// of those whose compensation is not emulated and must be seen.
const PARAMETERS: [(u32, u32); 15] = [
    (1006, 1006),
    (1240, 1240),
    (1851, 1852),
    (3602, 3602),
    (3605, 3605),
    (3620, 3627),
    (3666, 3671),
    (3676, 3677),
    (5711, 5716),
    (5721, 5726),
    (5731, 5784),
    (5861, 5874),
    (8135, 8135),
    (10800, 10814),
    (14985, 14988),
];

/// The blocks of a Fanuc read-out that concern the compensation, and how many were passed over.
///
/// shape  as long as the file, byte for byte; other blocks are blanks
pub fn fanuc(text: &str, facts: &FanucFacts) -> (String, usize) {
    let mut kept = String::with_capacity(text.len());
    let mut passed_over = 0;
    for block in text.split_inclusive(['\n', '\r', ';']) {
        match number(block) {
            Some((number, rest)) if !concerns(number, rest, facts) => {
                passed_over += 1;
                kept.extend(block.chars().flat_map(|c| {
                    let blank = if matches!(c, '\n' | '\r' | ';') {
                        c
                    } else {
                        ' '
                    };
                    std::iter::repeat_n(blank, c.len_utf8())
                }));
            }
            _ => kept.push_str(block),
        }
    }
    (kept, passed_over)
}

/// The number after `N`, and what follows it.
fn number(block: &str) -> Option<(u32, &str)> {
    let rest = block.trim_start().strip_prefix(['N', 'n'])?.trim_start();
    let digits = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    Some((rest[..digits].parse().ok()?, rest[digits..].trim_start()))
}

fn concerns(number: u32, rest: &str, facts: &FanucFacts) -> bool {
    let identifier: String = rest
        .chars()
        .filter(|c| !c.is_whitespace())
        .take(2)
        .collect();
    let is_large = number >= facts.point_offset.value;
    match identifier.to_ascii_uppercase().as_str() {
        "Q0" => return true,
        "Q1" => {}
        _ if is_large => return true,
        _ => {}
    }
    let sets = facts.straightness_sets.value;
    let per_point = [
        facts.straightness_magnification_parameter.value,
        facts.straightness_start_parameter.value,
    ];
    PARAMETERS.iter().any(|(a, b)| (*a..=*b).contains(&number))
        || per_point
            .iter()
            .any(|first| (*first..*first + sets).contains(&number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_archive_keeps_its_lines_in_place() {
        let text = "%_N_NC_TEA_INI\nCHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\n\
                    N32450 $MA_BACKLASH[0,AX1]=0.005\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nM17\n\
                    %_N_NC_CEC_INI\n$AN_CEC_STEP[3]=0\n$AN_CEC[3,0]=0\n$AN_CEC_STEP[1]=50\nM17\n";
        let cut = siemens(text);
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
        let cut = siemens(text);
        let lines: Vec<&str> = cut.data.lines().collect();
        assert_eq!(lines[0].trim_end(), "N32450 $MA_BACKLASH[0,AX1]=0.005");
        assert_eq!(lines[0].len(), text.lines().next().unwrap_or("").len());
        assert_eq!(cut.without_grid, ["AN_CEC[3]"]);
        let lines: Vec<&str> = cut.tables.lines().collect();
        assert_eq!(lines[2].trim_end(), "$AN_CEC[1,0]=0.001");
        assert!(lines[3].ends_with("'00F"), "three digits are no checksum");
    }
}
