//! The variables that a compensation file may write, what the files of a control hold of them, the files of a kit put
//! together; and what the lines that a control wrote of itself say of the compensation.

use super::statement::{Assignment, BLANKS, Value, block_number, code_of, is_end, take_word};
use crate::control::controller::ControlUnit;
use crate::control::table::siemens::{
    MachineDatum, MachineValue, Place, SiemensTable, SiemensTables,
};
use crate::read::lexer::{Complaint, Cursor, lines};
use crate::read::refusals;
use crate::text::{Finding, Problems, nearest};
use Allowed::{Any, AxisName, Number, Truth, Whole};
use Index::{Axis, Encoder, Point, Table};
use std::collections::BTreeSet;
use std::ops::Range;

/// What one file, or all files of a kit together, write into a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensContents {
    /// The tables, the machine and setting data.
    pub tables: SiemensTables,
    /// Remarks for the user that are no problem.
    pub notes: Vec<Finding>,
    /// Parameters of tables that the file does not write, such as `IS_MODULO of $AN_CEC[0]`: the control
    /// keeps an older one. They are read as 0, the value of a table that was never written.
    pub unwritten: Vec<String>,
    /// Tables of a control that hold zeros and no usable grid, such as `AN_CEC[3]`.
    pub idle: Vec<String>,
    /// Of files that a control wrote, how many data were ignored, as they are of no concern.
    pub passed_over: usize,
    /// Names of its part programs, such as `NONIUS_EEC_MPF`.
    pub programs: Vec<String>,
    /// Whether they write tables.
    pub programs_write_tables: bool,
    /// Variables of concern that are held with two values, switches also those of several files.
    pub twice: BTreeSet<String>,
    /// The units that its data are in, where it says so (`METRIC`, `INCH`).
    pub units: Vec<ControlUnit>,
}

/// Whether a machine or setting datum switches tables on and off, and so is made for being changed.
pub(crate) fn is_switch(variable: &str) -> bool {
    let name = variable.split('[').next();
    matches!(name, Some("$MA_ENC_COMP_ENABLE" | "$MA_CEC_ENABLE" | "$SN_CEC_TABLE_ENABLE"))
}

/// Puts the files of a kit into one memory, in the order in which they are loaded.
///
/// A point or parameter that two files write with different values is a problem, because the
/// result would depend on the order of loading. The switches `ENC_COMP_ENABLE`, `CEC_ENABLE` and
/// `CEC_TABLE_ENABLE` are made for being changed: of these the last one counts.
pub fn merge(contents: Vec<SiemensContents>) -> Result<SiemensContents, Problems> {
    let mut problems = Problems::none();
    let mut all = SiemensContents::default();
    for file in contents {
        for mut table in file.tables.tables {
            match all.tables.tables.iter_mut().find(|known| known.place == table.place) {
                Some(known) => merge_table(known, &mut table, &mut problems),
                None => all.tables.tables.push(table),
            }
        }
        for datum in file.tables.data {
            let MachineDatum { variable, value } = datum.clone();
            match all.tables.set(datum).is_some_and(|old| old != value) {
                false => {}
                true if is_switch(&variable) => _ = all.twice.insert(variable),
                true => problems.push(refusals::contradiction(variable)),
            }
        }
        all.tables.reserved.extend(file.tables.reserved);
        all.notes.extend(file.notes);
        all.unwritten.extend(file.unwritten);
        all.idle.extend(file.idle);
        all.passed_over += file.passed_over;
        all.units.extend(file.units);
        all.programs.extend(file.programs);
        all.programs_write_tables |= file.programs_write_tables;
        all.twice.extend(file.twice);
    }
    all.tables.tables.sort_by(|a, b| a.place.cmp(&b.place));
    problems.or_ok(all)
}

/// Makes the points of both the same; exact, as all were read from decimal digits. What is left
/// different are parameters.
fn merge_table(known: &mut SiemensTable, table: &mut SiemensTable, problems: &mut Problems) {
    let place = &table.place;
    for (point, (known, value)) in known.values.iter_mut().zip(&mut table.values).enumerate() {
        if let (Some(a), Some(b)) = (*known, *value)
            && (a - b).abs() > 0.0
        {
            let what = format!("point {point} of ${place} ({a} and {b})");
            problems.push(refusals::contradiction(what));
        }
        *known = known.or(*value);
        *value = *known;
    }
    if known != table {
        problems.push(refusals::contradiction(format!("the parameters of ${place}")));
    }
}

// The variables that a compensation file may write: their names, indices and allowed values.
//
// Function Manual Extended Functions 03/2013, K3 p. 237-249 and 268.

/// Largest table or point number that is read at all.
const LARGEST_INDEX: u32 = 99_999;

/// What one index names.
#[derive(Clone, Copy)]
enum Index {
    Encoder,
    Table,
    Point,
    Axis,
}

/// What a variable may be set to.
#[derive(Clone, Copy)]
enum Allowed {
    /// A number, TRUE, FALSE or a name.
    Any,
    Number,
    /// A whole number in a range, in words.
    Whole(i32, i32, &'static str),
    /// 0 or FALSE, 1 or TRUE.
    Truth,
    AxisName,
}

/// Index + 1 of a table, or 0; the limit is far above the 62 tables of an 840D sl.
const TABLE_NUMBER: Allowed = Whole(0, 1000, "0 or the number of a table (its index + 1)");
/// A number of an NCU, no truth: 1, as a real control writes beside the axes of a table, or 0 where nobody
/// filled it. Others link axes of several NCUs.
const OWN_NCU: Allowed = Whole(0, 1, "0 or 1");
const TYPE: Allowed = Whole(0, 0, "0, or remove the line: its meaning is not documented");

/// Every variable that a compensation file may write. `$MA_`, `$MN_`, `$SN_` are closed too: a
/// mistyped name stops a control just as an unknown one does. Without an index: one value for the control.
const VARIABLES: [(&str, &[Index], Allowed); 31] = [
    ("AA_ENC_COMP", &[Encoder, Point, Axis], Number),
    ("AA_ENC_COMP_STEP", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_MIN", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_MAX", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_IS_MODULO", &[Encoder, Axis], Truth),
    ("AN_CEC", &[Table, Point], Number),
    ("AN_CEC_INPUT_AXIS", &[Table], AxisName),
    ("AN_CEC_OUTPUT_AXIS", &[Table], AxisName),
    ("AN_CEC_STEP", &[Table], Number),
    ("AN_CEC_MIN", &[Table], Number),
    ("AN_CEC_MAX", &[Table], Number),
    ("AN_CEC_DIRECTION", &[Table], Whole(-1, 1, "-1, 0 or 1")),
    ("AN_CEC_MULT_BY_TABLE", &[Table], TABLE_NUMBER),
    ("AN_CEC_IS_MODULO", &[Table], Truth),
    ("AN_CEC_TYPE", &[Table], TYPE),
    ("AN_CEC_INPUT_NCU", &[Table], OWN_NCU),
    ("AN_CEC_OUTPUT_NCU", &[Table], OWN_NCU),
    ("MA_ENC_COMP_ENABLE", &[Encoder, Axis], Any),
    ("MA_MM_ENC_COMP_MAX_POINTS", &[Encoder, Axis], Any),
    ("MA_BACKLASH", &[Encoder, Axis], Number),
    ("MA_CEC_ENABLE", &[Axis], Any),
    ("MA_CEC_MAX_SUM", &[Axis], Number),
    ("MA_CEC_MAX_VELO", &[Axis], Number),
    ("MA_CEC_SCALING_SYSTEM_METRIC", &[Axis], Truth),
    ("MA_ENC_REFP_MODE", &[Encoder, Axis], Number),
    ("MA_REFP_SET_POS", &[Encoder, Axis], Number),
    ("MN_CONVERT_SCALING_SYSTEM", &[], Truth),
    ("MN_MM_CEC_MAX_POINTS", &[Table], Any),
    ("MN_SCALING_SYSTEM_IS_METRIC", &[], Truth),
    ("SN_CEC_TABLE_ENABLE", &[Table], Any),
    ("SN_CEC_TABLE_WEIGHT", &[Table], Number),
];

/// Whether a name is that of a point or parameter of a table; known or not.
pub(super) fn is_of_table(name: &str) -> bool {
    name.starts_with("AA_ENC_COMP") || name.starts_with("AN_CEC")
}

/// The machine and setting data that are read beside tables, where a control wrote all it has.
pub(super) fn data() -> impl Iterator<Item = &'static str> {
    let names = VARIABLES.iter().map(|(name, _, _)| *name);
    names.filter(|name| !is_of_table(name) && *name != "MA_CEC_MAX_VELO")
}

/// What an assignment sets.
#[derive(Clone, Copy)]
pub(super) struct Variable {
    /// Name without `$`, upper case.
    name: &'static str,
    allowed: Allowed,
}

/// A parameter of a table, or a point of it, which has a number and no name.
pub(super) type Cell = (&'static str, u32);

/// The variable of an assignment; a complaint if it is unknown or the indices do not fit it.
pub(super) fn variable(set: &Assignment<'_>) -> Result<Variable, Complaint> {
    let known = VARIABLES.iter().find(|(name, _, _)| *name == set.name);
    let Some((name, indices, allowed)) = known else {
        return Err(unknown(set));
    };
    let mut pairs = indices.iter().zip(&set.indices);
    if indices.len() == set.indices.len() && pairs.all(|(index, text)| index.takes(text)) {
        return Ok(Variable { name, allowed: *allowed });
    }
    let example = |index: &Index| match index {
        Encoder | Table => "0",
        Point => "5",
        Axis => "AX1",
    };
    let example: Vec<&str> = indices.iter().map(example).collect();
    let wrong = refusals::no_index(set.indices.join(","), name, example.join(","));
    Err(Complaint::new(set.head.clone(), wrong))
}

impl Index {
    fn takes(self, text: &str) -> bool {
        let is_up_to = |largest: u32| text.parse().is_ok_and(|number: u32| number <= largest);
        match self {
            Encoder => is_up_to(1),
            Table | Point => is_up_to(LARGEST_INDEX),
            Axis => text.starts_with(|c: char| c.is_ascii_alphabetic()),
        }
    }
}

impl Variable {
    /// The table that it belongs to, and what of it; `None` of machine data.
    pub(super) fn cell(self, set: &Assignment<'_>) -> Option<(Place, Cell)> {
        let number = |at: usize| set.indices.get(at)?.parse().ok();
        let (first, point) = (number(0).unwrap_or(0), number(1).unwrap_or(0));
        if let Some(parameter) = self.name.strip_prefix("AA_ENC_COMP") {
            let axis = set.indices.last()?.to_string();
            return Some((Place::Lec { axis, encoder: first }, (parameter, point)));
        }
        Some((Place::Cec(first), (self.name.strip_prefix("AN_CEC")?, point)))
    }

    /// The value that is assigned, if the variable may have it; truths as numbers.
    pub(super) fn value(self, set: &Assignment<'_>) -> Result<MachineValue, Complaint> {
        let value = set.value.clone()?;
        let number = match value {
            Value::Number(number) => Some(number),
            Value::Truth(_) | Value::Name(_) => None,
        };
        let is_whole = |least: i32, most: i32| {
            let is = |whole: i32| number.is_some_and(|own| (own - f64::from(whole)).abs() <= 0.0);
            (least..=most).any(is)
        };
        let (takes_it, words) = match self.allowed {
            Any => (true, ""),
            Number => (number.is_some(), "a number"),
            Whole(least, most, words) => (is_whole(least, most), words),
            Truth => (matches!(value, Value::Truth(_)) || is_whole(0, 1), "0 or 1"),
            AxisName => (matches!(value, Value::Name(_)), "an axis name such as `(AX1)`"),
        };
        if !takes_it {
            let wrong = refusals::not_this_value(self.name, words);
            return Err(Complaint::new(set.value_span.clone(), wrong));
        }
        Ok(match value {
            Value::Number(number) => MachineValue::Number(number),
            Value::Truth(truth) => MachineValue::Number(f64::from(u8::from(truth))),
            Value::Name(name) => MachineValue::Text(name),
        })
    }
}

fn unknown(set: &Assignment<'_>) -> Complaint {
    let known = VARIABLES.iter().map(|(name, _, _)| *name);
    let help = match nearest(&set.name, known) {
        Some(known) => format!("did you mean `${known}`?"),
        None => "only variables of ENC_COMP and CEC and their machine data are read".to_string(),
    };
    Complaint::new(set.head.clone(), refusals::unknown_variable(&set.name, help))
}

// What a control wrote of itself: what the lines of its files say of the compensation.
//
// ```text
//   file ─→ sections (%_N_NAME_EXT) ─→ lines: of a table, of machine data, of no concern
// ```
// A file holds active data (`…_INI`) and part programs (`…_MPF`, `…_SPF`), one or many after the other. A
// program lies in the memory and does nothing until somebody runs it, so what it would write is no
// state of the control.

/// Whether a file is a commissioning archive of an 840D sl: its first header begins so (a real one of 2016).
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"@@MMCIBN.")
}

/// The lines of a file with the part program that each stands in: a section that is one, or lies in a
/// folder of programs and workpieces. A file without headers is a program where its own name says so.
pub(super) fn sections<'a>(
    file: &'a str,
    text: &'a str,
) -> impl Iterator<Item = (Range<usize>, Option<&'a str>)> {
    const APART: [&str; 5] = ["_N_WKS_DIR", "_N_MPF_DIR", "_N_SPF_DIR", "_N_CST_DIR", "_N_CUS_DIR"];
    let mut lines = lines(text).peekable();
    let mut program = is_program(file).then_some(file);
    std::iter::from_fn(move || {
        let line = lines.next()?;
        if let Some(name) = header(&text[line.clone()]) {
            let next = lines.peek().map_or("", |next| text[next.clone()].trim());
            let path = next.to_ascii_uppercase();
            let lies_apart =
                path.starts_with(";$PATH=") && APART.iter().any(|folder| path.contains(folder));
            program = (is_program(name) || lies_apart).then_some(name);
        }
        Some((line, program))
    })
}

/// The name in the header of a section.
pub(super) fn header(line: &str) -> Option<&str> {
    line.trim().strip_prefix("%_N_")
}

/// Whether a name is that of a part program.
pub(super) fn is_program(name: &str) -> bool {
    let name = name.to_ascii_uppercase().replace('.', "_");
    name.ends_with("_MPF") || name.ends_with("_SPF")
}

/// What a line is to the compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Concern {
    /// None.
    Nothing,
    /// An assignment of no concern.
    PassedOver,
    /// `METRIC` or `INCH`: the unit of the data, whichever the control counts in.
    Unit(ControlUnit),
    /// An end word.
    End,
    /// Of a table.
    Table,
    /// A machine or setting datum that is read beside tables; or no plain assignment that writes data of the
    /// compensation all the same, as `IF R1==1 $MA_CEC_ENABLE[AX1]=0`, or is a broken one.
    Data,
}

/// What a line is to the compensation, and its code.
pub(super) fn concern(text: &str, line: &Range<usize>) -> (Concern, Range<usize>) {
    let code = code_of(text, line);
    let code = code.start..code.start + without_checksum(&text[code.clone()]).len();
    let mut cursor = Cursor::new(text, code.clone(), BLANKS);
    cursor.peek_word();
    block_number(&mut cursor);
    cursor.peek_word();
    let whole = cursor.text(cursor.rest());
    let found = match cursor.eat("$") {
        Some(_) => assignment(&mut cursor, whole),
        None => word(whole),
    };
    (found, code)
}

fn assignment(cursor: &mut Cursor<'_>, whole: &str) -> Concern {
    let name = take_word(cursor);
    // Of the reference point values the first alone: the others are for further reference cams.
    let is_other_cam = || {
        let mut behind = cursor.clone();
        behind.eat("[");
        behind.peek_word();
        name == "MA_REFP_SET_POS" && behind.digits() != "0"
    };
    if is_of_table(&name) {
        Concern::Table
    } else if data().any(|known| known == name) && !is_other_cam() {
        Concern::Data
    } else if whole.contains('=') {
        Concern::PassedOver
    } else {
        mentions_data(whole)
    }
}

fn word(whole: &str) -> Concern {
    const LONGEST: usize = 6;
    if whole.len() > LONGEST {
        return mentions_data(whole);
    }
    match whole.to_ascii_uppercase().as_str() {
        "METRIC" => Concern::Unit(ControlUnit::Millimetre),
        "INCH" => Concern::Unit(ControlUnit::Inch),
        word if is_end(word) => Concern::End,
        _ => Concern::Nothing,
    }
}

fn mentions_data(code: &str) -> Concern {
    if !code.contains('$') {
        return Concern::Nothing;
    }
    let code = code.to_ascii_uppercase();
    let mut names = data().chain(["AA_ENC_COMP", "AN_CEC"]);
    match names.any(|name| code.contains(&format!("${name}"))) {
        true => Concern::Data,
        false => Concern::Nothing,
    }
}

/// Code without the checksum that a control may write behind an assignment: blank, apostrophe,
/// four hexadecimal digits (MD11230 `MD_FILE_STYLE`; 840D/810D Start-Up Guide 03/2006, 11.12.1).
/// It is ignored, not checked: how it is computed is not published.
fn without_checksum(code: &str) -> &str {
    let Some((statement, sum)) = code.rsplit_once('\'') else {
        return code;
    };
    let digits = sum.trim_end();
    let is_sum = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    match is_sum && statement.contains('=') && statement.ends_with([' ', '\t']) {
        true => statement,
        false => code,
    }
}
