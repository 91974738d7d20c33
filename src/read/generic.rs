//! Reader of the generic table (contract §4.1): one CSV for all terms, and its JSON twin.
//!
//! ```text
//!   text ── rows (CSV or JSON), or a typed list ── check (each row, then blocks) ── merge (twins) ── tables
//! ```
//! A *block* is the run of rows of one term, pair of axes and direction: the corrections of one
//! axis over the equally spaced positions of another. Deviation, correction and increment say the
//! same thing three times; a file in which they disagree is refused, as a control fed with one of
//! them would do something else than a control fed with another.
//!
//! Written from the contract alone; it knows nothing of the program's own templates.

mod check;
mod refusals;
mod rows;
mod typed;

pub use self::check::GenericRow;

use self::rows::COLUMNS;
use crate::control::table::{ListedTable, ListedTables, Point};
use crate::quantity::Direction;
use crate::text::{Problems, joined};

/// Reads one file: JSON if its first character is `{`, a typed list if it has a column `point`, else CSV.
///
/// **shape** rows in file order; columns in any order, blocks may be interleaved · **unit** as the
/// columns say, mm and µm · **limits** refuses what a table cannot mean: see the module;
/// a file that lost its last rows *whole* cannot be told from a shorter one, only its twin can
/// ([`merge`]).
///
/// ```
/// let csv = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um\n\
///            EXX,X,X,,0,0,0,0,\n\
///            EXX,X,X,,1,50,2.5,-2.5,-2.5\n";
/// let json = r#"{"schema":1,"rows":[
///     {"term":"EXX","base_axis":"X","output_axis":"X","direction":null,"index":0,
///      "position_mm":0,"deviation_um":0,"correction_um":0,"increment_um":null},
///     {"term":"EXX","base_axis":"X","output_axis":"X","direction":null,"index":1,
///      "position_mm":50,"deviation_um":2.5,"correction_um":-2.5,"increment_um":-2.5}]}"#;
/// let rows = nonius::read::generic::read("table.csv", csv).unwrap();
/// assert_eq!(rows[1].increment_um, Some(-2.5));
/// assert_eq!(nonius::read::generic::read("table.json", json), Ok(rows));
/// ```
pub fn read(file_name: &str, text: &str) -> Result<Vec<GenericRow>, Problems> {
    rows_of(file_name, text, None, false)
}

/// The rows of a file; of a typed list as the control shows it, what was seen counts and nothing else. Of a control
/// whose tables are `held` in a unit of their own, a typed list with that column, its numbers as they stand.
fn rows_of(
    file_name: &str,
    text: &str,
    held: Option<&str>,
    as_shown: bool,
) -> Result<Vec<GenericRow>, Problems> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if let Some(column) = held.filter(|_| !typed::is_list(text)) {
        return Err(refusals::no_list(file_name, column).into());
    }
    if text.trim_start().starts_with('{') {
        rows::read_json(file_name, text)
    } else if typed::is_list(text) {
        typed::read(file_name, text, held, as_shown)
    } else {
        rows::read_csv(file_name, text)
    }
}

/// The tables of the files of a kit, or, `as_shown`, of those that a control showed.
pub(crate) fn tables(
    texts: &[(&str, &str)],
    held: Option<&str>,
    as_shown: bool,
) -> Result<ListedTables, Problems> {
    let files = texts.iter().map(|(name, text)| rows_of(name, text, held, as_shown));
    Ok(in_tables(&merge(Problems::all(files)?)?))
}

/// Checked rows as tables: one for each pair of axes; a direction without rows gets nothing.
fn in_tables(rows: &[GenericRow]) -> ListedTables {
    let mut tables: Vec<ListedTable> = Vec::new();
    for row in rows {
        let known = tables.iter().position(|own| own.is_for(&row.base_axis, &row.output_axis));
        let at = known.unwrap_or(tables.len());
        if known.is_none() {
            let (base, output) = (row.base_axis.clone(), row.output_axis.clone());
            tables.push(ListedTable { term: row.term(), base, output, points: Vec::new() });
        }
        let (points, index) = (&mut tables[at].points, row.index as usize);
        if points.len() <= index {
            let position = row.position_mm + 0.0; // −0 is 0
            let reverse = row.direction.as_ref().map(|_| 0.0);
            points.push(Point { position, forward: 0.0, reverse });
        }
        match row.way() {
            Some(Direction::Minus) => points[index].reverse = Some(row.correction_um + 0.0),
            _ => points[index].forward = row.correction_um + 0.0,
        }
    }
    ListedTables::of(tables)
}

/// Makes the rows of one table of the files of a kit, which are twins: all must say the same, row by row.
///
/// **limits** one problem for each file that differs from the first one, naming its first
/// differing row; no file at all gives no rows.
pub fn merge(files: Vec<Vec<GenericRow>>) -> Result<Vec<GenericRow>, Problems> {
    let mut problems = Problems::none();
    let mut files = files.into_iter();
    let first = files.next().unwrap_or_default();
    for twin in files {
        if let Some(difference) = first_difference(&first, &twin) {
            problems.push(refusals::no_twins(difference));
        }
    }
    problems.or_ok(first)
}

fn first_difference(one: &[GenericRow], other: &[GenericRow]) -> Option<String> {
    let mut pairs = one.iter().zip(other).enumerate();
    if let Some((index, (a, b))) = pairs.find(|(_, (a, b))| a != b) {
        let differ = a.texts().into_iter().zip(b.texts()).zip(COLUMNS).filter(|((a, b), _)| a != b);
        let what = joined(differ.map(|((a, b), column)| format!("`{column}` (`{a}` and `{b}`)")));
        let row = index + 1;
        return Some(format!("row {row} ({}) differs in {what}", a.name()));
    }
    let shorter = one.len().min(other.len());
    let longer = if one.len() > shorter { one } else { other };
    let surplus = longer.get(shorter)?.name();
    let row = shorter + 1;
    Some(format!("row {row} ({surplus}) stands in only one of them"))
}

#[cfg(test)]
mod tests;
