//! Reader of LinuxCNC: the ini file (or lines for it, never both) and the tables that its `COMP_FILE` name.
//!
//! ```text
//!   texts ─┬ with [SECTION] lines ── ini ──→ joints: COMP_FILE, COMP_FILE_TYPE, BACKLASH, HOME_OFFSET; unit
//!          ├ with statements of HAL ── hal ──→ curves of one joint by another
//!          └ the others, by the name of a COMP_FILE ── comp ──→ rows
//! ```
//! A table says neither its joint nor its type nor its unit, so none is read without the ini. Written from
//! the C source and the runs named in docs/linuxcnc.md §4; of HAL files the form of a kit is read, no other.

mod files;

use self::files::Ini;
pub(crate) use self::files::Joint;
use crate::control::control_state::ControlState;
use crate::control::controller::{Columns, ControlUnit, CrossTerms, LinuxcncFacts, Role};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, ReadBack, file_name, quoted};
use crate::read::findings::ReadFinding;
use crate::read::lexer::{Complaint, Cursor, lines, located};
use crate::read::listed;
use crate::read::program::blocks::Meaning::{self, End, Neutral};
use crate::read::program::blocks::{Code, Vocabulary, refuse, without_comments};
use crate::read::refusals;
use crate::text::{Finding, Problem, Problems, shown};
use part_program::Language;
use std::collections::BTreeMap;
use std::ops::Range;

impl Family for LinuxcncFacts {
    fn read_kit(&self, texts: &[(&str, &str)], _roles: &[Role]) -> Result<ReadBack, Problems> {
        let read = read(texts, self)?;
        Ok(ReadBack { notes: read.notes, ..Tables::Listed(read.tables).into() })
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(listed::control(tables.own(), self, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        let is_hal = self.cross_terms.value == CrossTerms::Hal && files::is_hal(text);
        let begins_with_a_row =
            || lines(text).next().is_some_and(|span| row(text, &span).is_some());
        is_hal || files::is_ini(text) || begins_with_a_row()
    }

    fn is_whole(&self, text: &str) -> bool {
        is_machines(text)
    }
}

/// What texts of a control hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Contents {
    /// The tables that act.
    pub(crate) tables: ListedTables,
    /// What the ini says of each joint.
    pub(crate) joints: BTreeMap<u32, Joint>,
    /// `[TRAJ]LINEAR_UNITS`.
    pub(crate) unit: Option<ControlUnit>,
    /// Whether it is the ini of a machine, in which a setting that is not stated has its default.
    pub(crate) is_whole: bool,
    /// What is to be told of files that do nothing, as nothing names them.
    pub(crate) notes: Vec<Finding>,
}

/// Reads the ini and the tables that it names, and a HAL file; names and texts in any order.
///
/// **shape** tables ascending by joint · **unit** as in the files · **limits** refuses what the control does not
/// do: a table that it stops reading before its end, a row that it drops, a file that is not there
pub(crate) fn read(texts: &[(&str, &str)], facts: &LinuxcncFacts) -> Result<Contents, Problems> {
    let (inis, others): (Vec<_>, Vec<_>) = texts.iter().partition(|(_, text)| files::is_ini(text));
    let takes_hal = facts.cross_terms.value == CrossTerms::Hal;
    let is_hal = |(_, text): &(&str, &str)| takes_hal && files::is_hal(text);
    let (hals, others): (Vec<_>, Vec<_>) = others.into_iter().partition(is_hal);
    if inis.is_empty() && (hals.is_empty() || !others.is_empty()) {
        return Err(refusals::no_ini(quoted(&others)).into());
    }
    let (ini_name, text) = match inis.is_empty() {
        true => ("", ""), // a HAL file alone
        false => the_ini(&inis)?,
    };
    let ini = Ini::read(ini_name, text)?;
    let mut problems = Problems::none();
    let mut tables = problems.take(cross(&hals, facts)).unwrap_or_default();
    let mut named: Vec<&str> = Vec::new();
    for (number, joint) in &ini.joints {
        let Some(path) = joint.comp_file.as_deref() else {
            continue;
        };
        match others.iter().find(|(name, _)| file_name(name) == file_name(path)) {
            None => problems.push(refusals::no_comp_file(number, shown(path))),
            Some((name, text)) => {
                named.push(name);
                let of_profile = joint.columns.unwrap_or(Columns::Reached) == facts.columns.value;
                let rows = problems.take(rows(name, text, facts));
                let points = rows.map(|rows| match of_profile {
                    true => rows,
                    false => rows.into_iter().map(in_other_columns).collect(),
                });
                let [base, output] = [number, number].map(ToString::to_string);
                tables.extend(points.map(|points| ListedTable {
                    term: None,
                    base,
                    output,
                    points,
                }));
            }
        }
    }
    if let Some(problem) = ambiguous(&ini) {
        problems.push(problem);
    }
    let names = texts.iter().map(|(name, _)| *name);
    named.extend(hals.iter().map(|(name, _)| *name));
    let unnamed = names.filter(|name| *name != ini_name && !named.contains(name));
    problems.or_ok(Contents {
        tables: ListedTables::of(tables),
        notes: unnamed.map(|name| ReadFinding::NotNamed { file: shown(name) }.into()).collect(),
        joints: ini.joints,
        unit: ini.unit,
        is_whole: is_machines(text),
    })
}

/// What the HAL file adds.
fn cross(hals: &[(&str, &str)], facts: &LinuxcncFacts) -> Result<Vec<ListedTable>, Problems> {
    match hals {
        [] => Ok(Vec::new()),
        [(name, text)] => files::tables(name, text, facts),
        [_, (name, _), ..] => Err(refusals::second_hal(shown(name)).into()),
    }
}

/// A row of positions reached as one of trims, or the other way: nominal − column.
fn in_other_columns(row: Point) -> Point {
    let other = |column: f64| row.position - column;
    Point { forward: other(row.forward), reverse: row.reverse.map(other), ..row }
}

/// The ini file of a machine has its kinematics, which lines for its joints do not.
fn is_machines(text: &str) -> bool {
    files::sections(text).any(|section| section == "KINS" || section == "EMC")
}

/// The one ini that counts: that of the machine, which says by what it leaves out, too; else the only one.
fn the_ini<'a>(inis: &[(&'a str, &'a str)]) -> Result<(&'a str, &'a str), Problem> {
    let machines: Vec<_> = inis.iter().filter(|(_, text)| is_machines(text)).collect();
    match (&machines[..], inis) {
        ([of_machine], _) => Ok(**of_machine),
        ([], [only]) => Ok(*only),
        _ => Err(refusals::several_inis(quoted(inis))),
    }
}

/// Two COMP_FILE of different folders with one name: which of them is meant is not seen here.
fn ambiguous(ini: &Ini) -> Option<Problem> {
    let paths: Vec<&str> =
        ini.joints.values().flat_map(|joint| joint.comp_file.as_deref()).collect();
    let twin = |path: &&&str| {
        paths.iter().any(|other| other != *path && file_name(other) == file_name(path))
    };
    let path = paths.iter().find(twin)?;
    Some(refusals::same_name(shown(file_name(path))))
}

// LinuxCNC part programs of measuring runs: `(…)` is a comment, `(MSG,…)` a text for the screen.

/// Its language (LinuxCNC documentation, G-Code; RS274NGC).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Iso, words: &WORDS, blocks };

/// G61.1 (exact stop) does not change where the axes go.
const WORDS: [(&str, Meaning); 2] = [("G61.1", Neutral), ("M2", End)];

/// A comment that begins with one of these words does something.
const ACTIVE: [&str; 6] = ["LOG", "PROBE", "DEBUG", "PRINT", "PY", "ABORT"];

fn blocks(text: &str) -> Result<Vec<Code>, Complaint> {
    let mut blocks = Vec::new();
    for line in lines(text) {
        let code = without_comments(text, &line)?;
        if comments(&text[line.clone()]).any(is_active) {
            return Err(refuse(line, "a comment that LinuxCNC executes"));
        }
        let code = code.trim();
        if !code.is_empty() {
            blocks.push((line.start, code.to_string()));
        }
    }
    Ok(blocks)
}

/// What stands behind each opening bracket.
fn comments(line: &str) -> impl Iterator<Item = &str> {
    line.split('(').skip(1)
}

fn is_active(comment: &str) -> bool {
    let word = comment.trim_start().to_ascii_uppercase();
    ACTIVE.iter().any(|active| word.starts_with(active))
}

// A table of a joint: `nominal forward reverse`, one row for each line.
//
// LinuxCNC stops reading without a word at the first line that does not begin with three numbers, drops rows
// that do not ascend, and takes 256 (usrmotintf.cc, usrmotLoadComp). A file in which a row is lost so is
// refused at that place: nobody meant it.

/// LinuxCNC reads a line in pieces of this many characters.
const LONGEST_LINE: usize = 253;

/// Positions and values of a table lie below it, in mm or inch.
const LONGEST: f64 = 1e6;

/// The rows of a file.
fn rows(file: &str, text: &str, facts: &LinuxcncFacts) -> Result<Vec<Point>, Problems> {
    let refuse = |complaint| Err(located(file, text, vec![complaint]));
    let mut rows: Vec<Point> = Vec::new();
    let mut lines = lines(text).map(|span| (row(text, &span), span));
    let stop = loop {
        match lines.next() {
            Some((Some(row), span)) => match wrong(&rows, row, &span, facts.rows.value) {
                Some(complaint) => return refuse(complaint),
                None => rows.push(row),
            },
            other => break other.map_or(0..0, |(_, span)| span),
        }
    };
    if lines.any(|(row, _)| row.is_some()) {
        return refuse(Complaint::new(stop, refusals::stops_reading()));
    }
    if rows.is_empty() {
        return refuse(Complaint::new(stop, refusals::no_first_row()));
    }
    Ok(rows)
}

/// The three numbers that a line begins with.
fn row(text: &str, span: &Range<usize>) -> Option<Point> {
    let mut cursor = Cursor::new(text, span.clone(), &[' ', '\t']);
    let [position, forward] = [number(&mut cursor)?, number(&mut cursor)?];
    Some(Point { position, forward, reverse: Some(number(&mut cursor)?) })
}

/// A number as `scanf` takes it; what stands behind it is left.
fn number(cursor: &mut Cursor<'_>) -> Option<f64> {
    cursor.peek_word();
    let start = cursor.at;
    cursor.eat("+-");
    let whole = cursor.digits();
    cursor.at += usize::from(cursor.peek() == Some('.'));
    if whole.is_empty() && cursor.digits().is_empty() {
        return None;
    }
    cursor.digits();
    let mantissa = cursor.at;
    if cursor.take(|c| "eE".contains(c)).len() == 1 {
        cursor.take(|c| "+-".contains(c));
    }
    if cursor.digits().is_empty() {
        cursor.at = mantissa;
    }
    Some(cursor.text(start..cursor.at).parse::<f64>().ok()? + 0.0) // −0 is 0
}

/// What is wrong with a row behind those before it.
fn wrong(before: &[Point], row: Point, span: &Range<usize>, most: u32) -> Option<Complaint> {
    let is_length = |number: f64| number.abs() < LONGEST;
    let complaint = |wrong| Some(Complaint::new(span.clone(), wrong));
    if span.len() > LONGEST_LINE {
        return complaint(refusals::long_row(span.len(), LONGEST_LINE));
    }
    if ![row.position, row.forward].into_iter().chain(row.reverse).all(is_length) {
        return complaint(refusals::beyond_machines());
    }
    let last = before.last().map(|last| last.position);
    if let Some(last) = last.filter(|last| row.position <= *last) {
        let drops = ": LinuxCNC drops the row";
        return complaint(refusals::not_ascending(row.position, last, drops));
    }
    (before.len() >= most as usize)
        .then(|| Complaint::new(span.clone(), refusals::row_behind(most)))
}

#[cfg(test)]
mod tests;
