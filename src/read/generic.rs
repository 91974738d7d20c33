//! Reader of the generic table (contract §4.1): one CSV for all terms, and its JSON twin.
//!
//! ```text
//!   text ── rows (CSV or JSON), or a typed list ── check (each row, then blocks) ── merge (twins)
//! ```
//! A *block* is the run of rows of one term, pair of axes and direction: the corrections of one
//! axis over the equally spaced positions of another. Deviation, correction and increment say the
//! same thing three times; a file in which they disagree is refused, as a control fed with one of
//! them would do something else than a control fed with another.
//!
//! Written from the contract alone; it knows nothing of the program's own templates.

mod check;
mod control;
mod rows;
mod typed;

use crate::control::control_state::ControlState;
use crate::control::controller::GenericFacts;
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Direction;
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, KitText, ReadBack, each, own};
use crate::text::problem::{Problem, Problems};
use rows::COLUMNS;

impl Family for GenericFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        Ok(Tables::Generic(merge(each(files, read)?)?).into())
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(control::control(own(tables)?, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        text.contains("position_mm")
    }
}

/// Reads one file: JSON if its first character is `{`, a typed list if it has a column `point`, else CSV.
///
/// **shape** rows in file order; columns in any order, blocks may be interleaved · **unit** as the
/// columns say, mm and µm · **limits** refuses what [`GenericTable`] cannot mean: see the module;
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
/// let table = nonius::read::generic::read("table.csv", csv).unwrap();
/// assert_eq!(table.rows[1].increment_um, Some(-2.5));
/// assert_eq!(nonius::read::generic::read("table.json", json), Ok(table));
/// ```
pub fn read(file_name: &str, text: &str) -> Result<GenericTable, Problems> {
    read_with(typed::read, file_name, text)
}

/// Reads a file as the control shows it: of a typed list what was seen counts, nothing else.
pub(crate) fn read_out(file_name: &str, text: &str) -> Result<GenericTable, Problems> {
    read_with(typed::read_seen, file_name, text)
}

fn read_with(
    list: fn(&str, &str) -> Result<GenericTable, Problems>,
    file_name: &str,
    text: &str,
) -> Result<GenericTable, Problems> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim_start().starts_with('{') {
        rows::read_json(file_name, text)
    } else if typed::is_list(text) {
        list(file_name, text)
    } else {
        rows::read_csv(file_name, text)
    }
}

/// Makes one table of the files of a kit, which are twins: all must say the same, row by row.
///
/// **limits** one problem for each table that differs from the first one, naming its first
/// differing row; no table at all gives an empty one.
pub fn merge(tables: Vec<GenericTable>) -> Result<GenericTable, Problems> {
    let mut problems = Problems::none();
    let mut tables = tables.into_iter();
    let first = tables.next().unwrap_or_default();
    for twin in tables {
        if let Some(difference) = first_difference(&first, &twin) {
            problems.push(
                Problem::new(format!("two files of the kit are not twins: {difference}")).help(
                    "CSV and JSON of a kit hold the same rows; one of them was changed or cut \
                     off, generate both again",
                ),
            );
        }
    }
    problems.or_ok(first)
}

fn first_difference(one: &GenericTable, other: &GenericTable) -> Option<String> {
    let mut pairs = one.rows.iter().zip(&other.rows).enumerate();
    if let Some((index, (a, b))) = pairs.find(|(_, (a, b))| a != b) {
        let cells = texts(a).into_iter().zip(texts(b)).zip(COLUMNS);
        let differ = cells.filter(|((a, b), _)| a != b);
        let what: Vec<String> =
            differ.map(|((a, b), column)| format!("`{column}` (`{a}` and `{b}`)")).collect();
        let (row, what) = (index + 1, what.join(", "));
        return Some(format!("row {row} ({}) differs in {what}", name_of(a)));
    }
    let shorter = one.rows.len().min(other.rows.len());
    let longer = if one.rows.len() > shorter { one } else { other };
    let surplus = name_of(longer.rows.get(shorter)?);
    let row = shorter + 1;
    Some(format!("row {row} ({surplus}) stands in only one of them"))
}

fn name_of(row: &GenericRow) -> String {
    let direction = row.direction.map_or("", |direction| direction.symbol());
    let GenericRow { term, base_axis, output_axis, index, .. } = row;
    format!("{term}{direction} from `{base_axis}` to `{output_axis}`, index {index}")
}

/// The cells of a row as text, in the order of [`COLUMNS`]; different numbers have different texts.
fn texts(row: &GenericRow) -> [String; 9] {
    [
        row.term.to_string(),
        row.base_axis.clone(),
        row.output_axis.clone(),
        row.direction.map_or("", Direction::symbol).to_string(),
        row.index.to_string(),
        row.position_mm.to_string(),
        row.deviation_um.to_string(),
        row.correction_um.to_string(),
        row.increment_um.map_or(String::new(), |um| um.to_string()),
    ]
}

#[cfg(test)]
mod tests;
