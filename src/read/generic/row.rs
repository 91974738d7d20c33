//! One row of the generic table, from raw cells to checked values.
//!
//! Both forms of the file bring their cells as [`Cell`]s. What a cell must be is decided here, once.

use crate::control::table::generic::GenericRow;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::text::problem::nearest;
use serde_json::Number;
use std::borrow::Cow;

/// A column of the CSV, a key of a row of the JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    Term,
    BaseAxis,
    OutputAxis,
    Direction,
    Index,
    Position,
    Deviation,
    Correction,
    Increment,
}

impl Column {
    /// In the order of the contract.
    pub(super) const ALL: [Column; 9] = [
        Column::Term,
        Column::BaseAxis,
        Column::OutputAxis,
        Column::Direction,
        Column::Index,
        Column::Position,
        Column::Deviation,
        Column::Correction,
        Column::Increment,
    ];

    /// As it stands in the file.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Column::Term => "term",
            Column::BaseAxis => "base_axis",
            Column::OutputAxis => "output_axis",
            Column::Direction => "direction",
            Column::Index => "index",
            Column::Position => "position_mm",
            Column::Deviation => "deviation_um",
            Column::Correction => "correction_um",
            Column::Increment => "increment_um",
        }
    }

    /// The column of a name; the spelling is exact.
    pub(super) fn from_name(name: &str) -> Option<Column> {
        Column::ALL.into_iter().find(|column| column.name() == name)
    }

    /// Whether its cells are numbers.
    pub(super) const fn is_number(self) -> bool {
        !matches!(
            self,
            Column::Term | Column::BaseAxis | Column::OutputAxis | Column::Direction
        )
    }

    /// What to do about a name that is not a column.
    pub(super) fn help_for(name: &str) -> String {
        let known = Column::ALL.map(Column::name);
        match nearest(name, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("expected {}", known.join(",")),
        }
    }
}

/// What is wrong with a row. Where its bytes are is looked up by the form of the file, as nobody
/// needs the places of the cells of a sound file.
#[derive(Clone, Debug)]
pub(super) struct RowFlaw {
    /// Number of the row in the file, from 0.
    pub(super) row: usize,
    /// The column or key it is shown at; the whole row if there is none.
    pub(super) cell: Option<String>,
    pub(super) message: String,
    pub(super) help: String,
}

impl RowFlaw {
    pub(super) fn of_row(row: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        RowFlaw {
            row,
            cell: None,
            message: message.into(),
            help: help.into(),
        }
    }

    pub(super) fn of_cell(
        row: usize,
        cell: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        RowFlaw {
            cell: Some(cell.to_string()),
            ..RowFlaw::of_row(row, message, help)
        }
    }
}

/// A cell as it was found.
#[derive(Clone, Debug)]
pub(super) enum Cell<'a> {
    Empty,
    Text(Cow<'a, str>),
    Number(Number),
    /// What no column holds, in words: `true`, an array, an object.
    Other(String),
}

/// A row as it was found, with its cells in the order of [`Column::ALL`].
#[derive(Clone, Debug)]
pub(super) struct RawRow<'a> {
    /// Number of the row in the file, from 0.
    pub(super) number: usize,
    pub(super) cells: [Cell<'a>; 9],
}

impl<'a> RawRow<'a> {
    fn cell(&self, column: Column) -> &Cell<'a> {
        &self.cells[column as usize]
    }

    fn text(&self, column: Column) -> Option<&Cow<'a, str>> {
        match self.cell(column) {
            Cell::Text(text) => Some(text),
            _ => None,
        }
    }

    fn number(&self, column: Column) -> Option<&Number> {
        match self.cell(column) {
            Cell::Number(number) => Some(number),
            _ => None,
        }
    }
}

/// What the rows of one block have in common.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BlockKey<'a> {
    pub(super) term: ErrorTerm,
    pub(super) base: Cow<'a, str>,
    pub(super) output: Cow<'a, str>,
    pub(super) direction: Option<Direction>,
}

/// A row that cannot be used; its flaws are noted. Its block, if that much is known.
#[derive(Debug)]
pub(super) struct Unusable<'a>(pub(super) Option<BlockKey<'a>>);

/// The values of a row; all flaws inside the row are noted in `flaws`.
pub(super) fn read_row<'a>(
    raw: &RawRow<'a>,
    flaws: &mut Vec<RowFlaw>,
) -> Result<(BlockKey<'a>, GenericRow), Unusable<'a>> {
    let mut cells = Cells { raw, flaws };
    let key = cells.key();
    let numbers = cells.numbers();
    match (key, numbers) {
        (Some(key), Some(numbers)) => {
            let row = numbers.of_block(&key);
            Ok((key, row))
        }
        (key, _) => Err(Unusable(key)),
    }
}

struct Numbers {
    index: u32,
    position_mm: f64,
    deviation_um: f64,
    correction_um: f64,
    increment_um: Option<f64>,
}

impl Numbers {
    fn of_block(self, key: &BlockKey<'_>) -> GenericRow {
        GenericRow {
            term: key.term,
            base_axis: key.base.as_ref().into(),
            output_axis: key.output.as_ref().into(),
            direction: key.direction,
            index: self.index,
            position_mm: self.position_mm,
            deviation_um: self.deviation_um,
            correction_um: self.correction_um,
            increment_um: self.increment_um,
        }
    }
}

/// Reads the cells of a row one by one; `None` means that a flaw was noted.
struct Cells<'r, 'a> {
    raw: &'r RawRow<'a>,
    flaws: &'r mut Vec<RowFlaw>,
}

impl<'a> Cells<'_, 'a> {
    fn key(&mut self) -> Option<BlockKey<'a>> {
        let term = self.term();
        let base = self.axis_name(Column::BaseAxis);
        let output = self.axis_name(Column::OutputAxis);
        let direction = self.direction();
        Some(BlockKey {
            term: term?,
            base: base?,
            output: output?,
            direction: direction?,
        })
    }

    fn numbers(&mut self) -> Option<Numbers> {
        let index = self.index();
        let position = self.number(Column::Position);
        let deviation = self.number(Column::Deviation);
        let correction = self.number(Column::Correction);
        self.check_opposite(deviation, correction);
        let increment = self.increment(index);
        Some(Numbers {
            index: index?,
            position_mm: position?,
            deviation_um: deviation?,
            correction_um: correction?,
            increment_um: increment?,
        })
    }

    fn term(&mut self) -> Option<ErrorTerm> {
        let found = self.raw.text(Column::Term);
        let term = found.and_then(|name| ErrorTerm::from_name(name));
        if term.is_none() {
            let names = ErrorTerm::ALL.map(|term| term.to_string()).join(" ");
            let help = format!("known terms: {names}");
            self.unexpected(Column::Term, "the name of a term", &help);
        }
        term
    }

    fn axis_name(&mut self, column: Column) -> Option<Cow<'a, str>> {
        let found = self.raw.text(column);
        let legible = |name: &&Cow<'a, str>| {
            !name.trim().is_empty() && !name.contains(|c: char| c.is_control() || c == '"')
        };
        let name = found.filter(legible).cloned();
        if name.is_none() {
            let help = "write the control's name of the axis, as in the job";
            self.unexpected(column, "the name of an axis", help);
        }
        name
    }

    fn direction(&mut self) -> Option<Option<Direction>> {
        let found = match self.raw.cell(Column::Direction) {
            Cell::Empty => Some(None),
            Cell::Text(text) => Direction::from_symbol(text).map(Some),
            _ => None,
        };
        if found.is_none() {
            let help = "an empty direction means both";
            self.unexpected(Column::Direction, "`+`, `-` or nothing", help);
        }
        found
    }

    fn index(&mut self) -> Option<u32> {
        let found = self.raw.number(Column::Index).and_then(Number::as_u64);
        let index = found.and_then(|index| u32::try_from(index).ok());
        if index.is_none() {
            let help = "the points of a block are counted 0, 1, 2, …";
            self.unexpected(Column::Index, "a whole number from 0", help);
        }
        index
    }

    fn number(&mut self, column: Column) -> Option<f64> {
        let found = self.raw.number(column).and_then(Number::as_f64);
        let number = found.filter(|number| number.is_finite());
        if number.is_none() {
            let help = "write digits with a decimal point; a row without a value is left out";
            self.unexpected(column, "a finite number", help);
        }
        number
    }

    /// The increment is empty at the first point, and only there.
    fn increment(&mut self, index: Option<u32>) -> Option<Option<f64>> {
        let is_empty = matches!(self.raw.cell(Column::Increment), Cell::Empty);
        match (index, is_empty) {
            (Some(0) | None, true) => Some(None),
            (Some(0), false) => {
                let help = "there is no point before the first one";
                self.unexpected(Column::Increment, "nothing at index 0", help);
                None
            }
            _ => self.number(Column::Increment).map(Some),
        }
    }

    fn check_opposite(&mut self, deviation: Option<f64>, correction: Option<f64>) {
        let (Some(deviation), Some(correction)) = (deviation, correction) else {
            return;
        };
        if (deviation + correction).abs() > 0.0 {
            let message = format!(
                "`correction_um` is {correction}, expected {}, the opposite of the deviation",
                0.0 - deviation
            );
            let help = "a correction cancels the deviation of its row exactly";
            self.note(Column::Correction, message, help);
        }
    }

    fn unexpected(&mut self, column: Column, expected: &str, help: &str) {
        let found = match self.raw.cell(column) {
            Cell::Empty => "empty".to_string(),
            Cell::Text(text) => format!("`{text}`"),
            Cell::Number(number) => format!("`{number}`"),
            Cell::Other(words) => words.clone(),
        };
        let message = format!("`{}` is {found}, expected {expected}", column.name());
        self.note(column, message, help);
    }

    fn note(&mut self, column: Column, message: String, help: &str) {
        let row = self.raw.number;
        self.flaws
            .push(RowFlaw::of_cell(row, column.name(), message, help));
    }
}
