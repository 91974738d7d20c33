//! Reader of the generic table (contract §4.1): one CSV for all terms, and its JSON twin.
//!
//! ```text
//!   text ── csv | json (raw rows with their places) ── row (cells) ── check (blocks) ── merge (twins)
//! ```
//! A *block* is the run of rows of one term, pair of axes and direction: the corrections of one
//! axis over the equally spaced positions of another. Deviation, correction and increment say the
//! same thing three times; a file in which they disagree is refused, as a control fed with one of
//! them would do something else than a control fed with another.
//!
//! Written from the contract alone; it knows nothing of the program's own templates.

mod check;
pub mod control;
mod csv;
mod json;
mod row;

use self::check::MOST_COMPLAINTS;

use self::control::GenericControl;
use crate::control::control_state::ControlState;
use crate::control::controller::GenericFacts;
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::family::{Family, KitText, ReadBack, each, other_family};
use crate::read::lexer::Complaint;
use crate::text::problem::{LineIndex, Problem, Problems, refuse_long_lines};
use row::Column;

impl Family for GenericFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        Ok(Tables::Generic(merge(each(files, read)?)?).into())
    }

    fn control(
        &self,
        tables: &Tables,
        state: &ControlState,
    ) -> Result<Box<dyn Emulator>, CannotEmulate> {
        let Tables::Generic(table) = tables else {
            return Err(other_family());
        };
        Ok(Box::new(GenericControl::new(table, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        text.contains("position_mm")
    }

    fn passed_over(&self, _: &str) -> usize {
        0
    }
}

/// Reads one file: JSON if its first character is `{`, else CSV.
pub fn read(file_name: &str, text: &str) -> Result<GenericTable, Problems> {
    let visible = text.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
    if visible.starts_with('{') {
        read_json(file_name, text)
    } else {
        read_csv(file_name, text)
    }
}

/// Reads the CSV.
///
/// **shape** rows in file order; columns in any order, blocks may be interleaved · **unit** as the
/// columns say, mm and µm · **limits** refuses what [`GenericTable`] cannot mean: see the module;
/// a file that lost its last rows *whole* cannot be told from a shorter one, only its twin can
/// ([`merge`]).
///
/// ```
/// let text = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um\n\
///             EXX,X,X,,0,0,0,0,\n\
///             EXX,X,X,,1,50,2.5,-2.5,-2.5\n";
/// let table = nonius::read::generic::read_csv("table.csv", text).unwrap();
/// assert_eq!(table.rows[1].increment_um, Some(-2.5));
/// ```
pub fn read_csv(file_name: &str, text: &str) -> Result<GenericTable, Problems> {
    refuse_long_lines(file_name, text)?;
    csv::read(text).map_err(|complaints| located(file_name, text, complaints))
}

/// Reads the JSON twin; the same checks as [`read_csv`].
///
/// **limits** a flaw of a row is shown at its key or at the row, not at the value; with a flaw
/// outside the rows (syntax, `schema`, an unknown key) the rows are not looked at.
///
/// ```
/// let text = r#"{"schema":1,"rows":[
///     {"term":"EXX","base_axis":"X","output_axis":"X","direction":null,"index":0,
///      "position_mm":0,"deviation_um":0,"correction_um":0,"increment_um":null},
///     {"term":"EXX","base_axis":"X","output_axis":"X","direction":null,"index":1,
///      "position_mm":50,"deviation_um":2.5,"correction_um":-2.5,"increment_um":-2.5}]}"#;
/// let table = nonius::read::generic::read_json("table.json", text).unwrap();
/// assert_eq!(table.rows[1].increment_um, Some(-2.5));
/// ```
pub fn read_json(file_name: &str, text: &str) -> Result<GenericTable, Problems> {
    json::read(text).map_err(|complaints| located(file_name, text, complaints))
}

fn located(file_name: &str, text: &str, mut complaints: Vec<Complaint>) -> Problems {
    complaints.sort_by_key(|complaint| complaint.span.start);
    complaints.truncate(MOST_COMPLAINTS);
    let mut problems = Problems::none();
    let index = LineIndex::default();
    // JSON may stand in one line; of a long one the columns are not counted again and again.
    let has_places = refuse_long_lines(file_name, text).is_ok();
    for complaint in complaints {
        if !has_places {
            let problem = Problem::new(format!("`{file_name}`: {}", complaint.message));
            problems.push(problem.help(complaint.help));
            continue;
        }
        let place = index.place(file_name, text, complaint.span.start, complaint.span.end);
        let problem = Problem::new(complaint.message).at(place);
        problems.push(problem.help(complaint.help));
    }
    problems
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
    let pairs = one.rows.iter().zip(&other.rows).enumerate();
    for (index, (a, b)) in pairs {
        if a != b {
            let what = columns_that_differ(a, b).join(", ");
            return Some(format!(
                "row {} ({}) differs in {what}",
                index + 1,
                name_of(a)
            ));
        }
    }
    let shorter = one.rows.len().min(other.rows.len());
    let longer = if one.rows.len() > shorter { one } else { other };
    let surplus = longer.rows.get(shorter)?;
    Some(format!(
        "row {} ({}) stands in only one of them",
        shorter + 1,
        name_of(surplus)
    ))
}

fn name_of(row: &GenericRow) -> String {
    let direction = row.direction.map_or("", |direction| direction.symbol());
    let GenericRow {
        term,
        base_axis,
        output_axis,
        index,
        ..
    } = row;
    format!("{term}{direction} from `{base_axis}` to `{output_axis}`, index {index}")
}

fn columns_that_differ(a: &GenericRow, b: &GenericRow) -> Vec<String> {
    let (a, b) = (texts(a), texts(b));
    let pairs = Column::ALL.into_iter().zip(a.into_iter().zip(b));
    pairs
        .filter(|(_, (a, b))| a != b)
        .map(|(column, (a, b))| format!("`{}` (`{a}` and `{b}`)", column.name()))
        .collect()
}

/// The cells of a row as text, in the order of [`Column::ALL`]; different numbers have different
/// texts.
fn texts(row: &GenericRow) -> [String; 9] {
    let number = |value: f64| (value + 0.0).to_string(); // −0 is 0
    [
        row.term.to_string(),
        row.base_axis.to_string(),
        row.output_axis.to_string(),
        row.direction
            .map_or(String::new(), |direction| direction.symbol().to_string()),
        row.index.to_string(),
        number(row.position_mm),
        number(row.deviation_um),
        number(row.correction_um),
        row.increment_um.map_or(String::new(), number),
    ]
}

#[cfg(test)]
mod tests;
