//! The generic table (contract §4.1): deviation, correction and increment of every point; and what a person types into
//! a control that reads no file: numbers of points and values, in the sense and unit of its screen, with a sum for each
//! page (contract §4.2).

use crate::control::controller::{Typed, TypedValue};
use crate::control::table::{ListedTable, ListedTables};
use crate::quantity::{Direction, ErrorTerm, Figure, rounded};
use crate::write::control_text::{Seen, seen};
use crate::write::family::FileSource;
use crate::write::listed::DUST_DECIMALS;

/// Places of the reference and distances are written to the nanometre, as positions are.
const POSITION_DECIMALS: u32 = 6;
/// Rows of a printed page (A4 or Letter) with room for handwriting.
const ROWS_OF_A_PAGE: usize = 32;
/// Sums and millimetres are freed from binary dust below any digit of a screen.
const SUM_DECIMALS: u32 = 12;

/// A table in one direction.
struct Block<'a> {
    table: &'a ListedTable,
    term: ErrorTerm,
    direction: Option<Direction>,
    is_rounded: bool,
}

/// One point of it.
struct SheetRow {
    index: usize,
    position_mm: f64,
    correction_um: f64,
    /// The change from the point before.
    increment_um: Option<f64>,
}

/// What templates see.
pub(super) fn of_tables(typed: &Typed, emitted: &FileSource<'_>, held: &ListedTables) -> Seen {
    let blocks = blocks(typed, emitted, held);
    let rows = blocks.iter().flat_map(|block| block.rows().map(move |row| (block, row)));
    let mut rows = rows.filter(|_| !typed.is_held()).peekable(); // they are µm
    let row = || {
        let (block, row) = rows.next()?;
        Some(block.of_row(&row, rows.peek().is_none()))
    };
    let rows: Vec<Seen> = std::iter::from_fn(row).collect();
    let mut page = 0;
    let is_rounded = blocks.iter().all(|own| own.is_rounded); // nobody types nine decimals
    let typed_in = blocks.iter().filter(|_| is_rounded);
    let sheet = typed_in.filter_map(|block| block.sheet(typed, emitted, &mut page));
    seen! {
        "sheet": sheet.collect::<Vec<Seen>>(),
        "typed": seen! {
            "column": typed.column(),
            "value": typed.value.value.words(),
            "unit": match typed.unit_word() {
                "um" => "µm",
                "count" => "counts",
                other => other,
            },
        },
        "rows": rows,
    }
}

/// The tables in the order of the plan, each direction by itself.
fn blocks<'a>(typed: &Typed, emitted: &FileSource<'_>, held: &'a ListedTables) -> Vec<Block<'a>> {
    let mut blocks = Vec::new();
    for placed in &emitted.compiled.placements {
        let unit_um = emitted.task.detection_unit_um(placed.term.of);
        let is_rounded = typed.is_held() || unit_um.is_some();
        for axis in &emitted.compiled.state.axes {
            let is_own =
                |own: &&ListedTable| own.term == Some(placed.term) && own.output == axis.name;
            let table = held.tables.iter().find(is_own);
            let (term, direction) = (placed.term, placed.direction);
            blocks.extend(table.map(|table| Block { table, term, direction, is_rounded }));
        }
    }
    blocks
}

impl Block<'_> {
    fn rows(&self) -> impl Iterator<Item = SheetRow> {
        let mut before: Option<f64> = None;
        self.table.points.iter().enumerate().map(move |(index, point)| {
            let reverse = point.reverse.filter(|_| self.direction == Some(Direction::Minus));
            let correction_um = reverse.unwrap_or(point.forward);
            let change = before.replace(correction_um).map(|before| correction_um - before);
            let increment_um = change.map(|um| match self.is_rounded {
                true => rounded(um, DUST_DECIMALS),
                false => um + 0.0,
            });
            SheetRow { index, position_mm: point.position, correction_um, increment_um }
        })
    }

    /// A row of CSV and JSON, with every number as finished text.
    fn of_row(&self, row: &SheetRow, is_last: bool) -> Seen {
        let increment = row.increment_um.map(number);
        seen! {
            "term": self.term.to_string(),
            "base_axis": self.table.base.as_str(),
            "output_axis": self.table.output.as_str(),
            "direction": self.direction.map_or("", Direction::symbol),
            "direction_json": match self.direction {
                None => "null",
                Some(Direction::Plus) => "\"+\"",
                Some(Direction::Minus) => "\"-\"",
            },
            "index": row.index.to_string(),
            "position_mm": number(row.position_mm),
            "deviation_um": number(0.0 - row.correction_um),
            "correction_um": number(row.correction_um),
            "increment_um": increment.clone().unwrap_or_default(),
            "increment_um_json": increment.as_deref().unwrap_or("null"),
            "comma": if is_last { "" } else { "," },
        }
    }

    /// The pages to be typed in.
    fn sheet(&self, typed: &Typed, emitted: &FileSource<'_>, page: &mut usize) -> Option<Seen> {
        let mut rows: Vec<SheetRow> = self.rows().collect();
        let zero_mm = emitted.compiled.state.axis(&self.table.base)?.reference.mm();
        let zero_mm = rounded(zero_mm, POSITION_DECIMALS);
        let zero = rows.iter().position(|row| row.position_mm >= zero_mm)?;
        if typed.value.value == TypedValue::Outward {
            // Below the reference a section ends at its lower point.
            (0..zero).for_each(|at| rows[at].increment_um = rows[at + 1].increment_um);
            rows[zero].increment_um = None;
        }
        let spacing = rows.get(1)?.position_mm - rows.first()?.position_mm;
        let pages = rows.chunks(ROWS_OF_A_PAGE).map(|rows| {
            *page += 1;
            seen_page(rows, typed, *page)
        });
        Some(seen! {
            "pages": pages.collect::<Vec<Seen>>(),
            "term": self.term.to_string(),
            "base_axis": self.table.base.as_str(),
            "output_axis": self.table.output.as_str(),
            "direction": self.direction.map_or("", Direction::symbol),
            "zero_mm": number(zero_mm),
            "zero_point": zero.to_string(),
            "spacing_mm": number(rounded(spacing, POSITION_DECIMALS)),
            "points": rows.len().to_string(),
        })
    }
}

fn seen_page(rows: &[SheetRow], typed: &Typed, page: usize) -> Seen {
    // Before the first point nothing changes.
    let um = |row: &SheetRow| match typed.value.value {
        TypedValue::Deviation => 0.0 - row.correction_um,
        TypedValue::Correction => row.correction_um,
        TypedValue::Increment | TypedValue::Outward => row.increment_um.unwrap_or(0.0),
    };
    let size = if typed.is_held() { 1.0 } else { typed.unit.value.um };
    let value = |row: &SheetRow| rounded(um(row) / size, SUM_DECIMALS);
    let seen = rows.iter().map(|row| {
        seen! {
            "point": row.index.to_string(),
            "position_mm": number(row.position_mm),
            "value": number(value(row)),
        }
    });
    seen! {
        "number": page.to_string(),
        "rows": seen.collect::<Vec<Seen>>(),
        "sum": number(rounded(rows.iter().map(value).sum(), SUM_DECIMALS)),
    }
}

/// The shortest decimal text of a number.
fn number(value: f64) -> String {
    Figure(value).to_string()
}
