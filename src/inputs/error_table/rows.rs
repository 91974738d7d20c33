//! Rows of an error table → records whose cells could all be read.

use crate::inputs::error_table::columns::{Column, Columns};
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::Line;
use crate::text::problem::{Problem, Problems, shown};

/// A row whose cells could all be read.
pub(super) struct Record<'a> {
    pub(super) line: Line<'a>,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    pub(super) position_mm: f64,
    /// One for each column; `None` = empty, and for columns that hold no number.
    pub(super) numbers: Box<[Option<f64>]>,
}

pub(super) fn read_rows<'a>(columns: &Columns, rows: &[Line<'a>]) -> (Vec<Record<'a>>, Problems) {
    let mut problems = Problems::none();
    let records = rows
        .iter()
        .filter_map(|row| read_row(columns, row, &mut problems))
        .collect();
    (records, problems)
}

fn read_row<'a>(columns: &Columns, row: &Line<'a>, problems: &mut Problems) -> Option<Record<'a>> {
    let expected = columns.kinds.len();
    let cells = row.cells_under(expected, problems)?;
    let mut complete = true;
    let mut axis = None;
    let mut direction = Some(None);
    let mut numbers = Vec::with_capacity(expected);
    for (index, kind) in columns.kinds.iter().enumerate() {
        let cell = &*cells[index];
        let mut number = None;
        match kind {
            Column::Axis => axis = read_axis(row, index, cell, problems),
            Column::Direction => direction = read_direction(row, index, cell, problems),
            _ if cell.is_empty() => {}
            _ => {
                number = read_number(columns, row, index, cell, problems);
                complete &= number.is_some();
            }
        }
        numbers.push(number);
    }
    let at = columns.index_of(|kind| matches!(kind, Column::Position { .. }))?;
    if cells[at].is_empty() {
        problems.push_with(|| {
            Problem::new("the position is empty, expected a number")
                .at(row.cell_place(at))
                .help("every row needs its machine coordinate")
        });
    }
    if !complete {
        return None;
    }
    Some(Record {
        line: *row,
        axis: axis?,
        direction: direction?,
        position_mm: numbers[at]?,
        numbers: numbers.into_boxed_slice(),
    })
}

fn read_axis(row: &Line<'_>, index: usize, cell: &str, problems: &mut Problems) -> Option<Axis> {
    let axis = Axis::from_letter(cell);
    if axis.is_none() {
        problems.push(
            Problem::new(format!(
                "unknown axis `{}`, expected `x`, `y` or `z`",
                shown(cell)
            ))
            .at(row.cell_place(index))
            .help("name the moving axis"),
        );
    }
    axis
}

fn read_direction(
    row: &Line<'_>,
    index: usize,
    cell: &str,
    problems: &mut Problems,
) -> Option<Option<Direction>> {
    if cell.is_empty() {
        return Some(None);
    }
    let direction = Direction::from_symbol(cell);
    if direction.is_none() {
        problems.push(
            Problem::new(format!(
                "unknown direction `{}`, expected `+`, `-` or an empty cell",
                shown(cell)
            ))
            .at(row.cell_place(index))
            .help("`+` = the axis came from smaller coordinates"),
        );
    }
    direction.map(Some)
}

fn read_number(
    columns: &Columns,
    row: &Line<'_>,
    index: usize,
    cell: &str,
    problems: &mut Problems,
) -> Option<f64> {
    let name = &columns.names[index];
    let kind = columns.kinds[index];
    let expected = if matches!(kind, Column::Position { .. }) {
        "write the machine coordinate as a plain number; its unit stands in the header"
    } else {
        "write a plain number; a column that was not measured stays empty for the whole axis"
    };
    let number = row.number_in(index, cell, name, expected, problems)?;
    let uncertainty = matches!(
        kind,
        Column::Uncertainty { .. } | Column::AngleUncertainty { .. }
    );
    if uncertainty && number < 0.0 {
        problems.push_with(|| {
            Problem::new(format!(
                "`{name}` is {}, expected an uncertainty of at least 0",
                shown(cell)
            ))
            .at(row.cell_place(index))
            .help("write the standard uncertainty, k = 1")
        });
        return None;
    }
    Some(number)
}
