//! One row of the generic table, from raw cells to checked values.
//!
//! Both forms of the file bring their cells as JSON values: a number, a text, or null where the
//! cell is empty. What a cell must be is decided here, once.

use crate::axis::{Direction, ErrorTerm};
use crate::problem::nearest;
use crate::table::generic::GenericRow;
use serde_json::Value;
use std::ops::Range;

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

/// What is wrong at some bytes of the text.
#[derive(Clone, Debug)]
pub(super) struct Complaint {
    pub(super) span: Range<usize>,
    pub(super) message: String,
    pub(super) help: String,
}

impl Complaint {
    pub(super) fn new(
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Complaint {
            span,
            message: message.into(),
            help: help.into(),
        }
    }
}

/// A cell as it was found.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) value: Value,
    pub(super) span: Range<usize>,
}

/// A row as it was found, with its cells in the order of [`Column::ALL`].
#[derive(Clone, Debug)]
pub(super) struct RawRow {
    /// What a message begins with: `rows[3]: ` where the line does not name the row.
    pub(super) label: String,
    pub(super) span: Range<usize>,
    pub(super) cells: [Cell; 9],
}

impl RawRow {
    pub(super) fn cell(&self, column: Column) -> &Cell {
        &self.cells[column as usize]
    }

    /// A complaint about one of its cells.
    pub(super) fn complaint(&self, column: Column, message: &str, help: &str) -> Complaint {
        let span = self.cell(column).span.clone();
        Complaint::new(span, format!("{}{message}", self.label), help)
    }
}

/// What the rows of one block have in common.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BlockKey {
    pub(super) term: ErrorTerm,
    pub(super) base: String,
    pub(super) output: String,
    pub(super) direction: Option<Direction>,
}

/// A row that cannot be used; its complaints are noted. Its block, if that much is known.
#[derive(Debug)]
pub(super) struct Unusable(pub(super) Option<BlockKey>);

/// The values of a row; all flaws inside the row are noted in `complaints`.
pub(super) fn read_row(
    raw: &RawRow,
    complaints: &mut Vec<Complaint>,
) -> Result<(BlockKey, GenericRow), Unusable> {
    let mut cells = Cells { raw, complaints };
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
    fn of_block(self, key: &BlockKey) -> GenericRow {
        GenericRow {
            term: key.term,
            base_axis: key.base.clone(),
            output_axis: key.output.clone(),
            direction: key.direction,
            index: self.index,
            position_mm: self.position_mm,
            deviation_um: self.deviation_um,
            correction_um: self.correction_um,
            increment_um: self.increment_um,
        }
    }
}

/// Reads the cells of a row one by one; `None` means that a complaint was noted.
struct Cells<'a> {
    raw: &'a RawRow,
    complaints: &'a mut Vec<Complaint>,
}

impl Cells<'_> {
    fn key(&mut self) -> Option<BlockKey> {
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
        let found = self.raw.cell(Column::Term).value.as_str();
        let term = found.and_then(ErrorTerm::from_name);
        if term.is_none() {
            let names = ErrorTerm::ALL.map(|term| term.to_string()).join(" ");
            let help = format!("known terms: {names}");
            self.unexpected(Column::Term, "the name of a term", &help);
        }
        term
    }

    fn axis_name(&mut self, column: Column) -> Option<String> {
        let found = self.raw.cell(column).value.as_str();
        let legible = |name: &&str| {
            !name.trim().is_empty() && !name.contains(|c: char| c.is_control() || c == '"')
        };
        let name = found.filter(legible).map(str::to_string);
        if name.is_none() {
            let help = "write the control's name of the axis, as in the job";
            self.unexpected(column, "the name of an axis", help);
        }
        name
    }

    fn direction(&mut self) -> Option<Option<Direction>> {
        let found = match &self.raw.cell(Column::Direction).value {
            Value::Null => Some(None),
            Value::String(text) => Direction::from_symbol(text).map(Some),
            _ => None,
        };
        if found.is_none() {
            let help = "an empty direction means both";
            self.unexpected(Column::Direction, "`+`, `-` or nothing", help);
        }
        found
    }

    fn index(&mut self) -> Option<u32> {
        let found = self.raw.cell(Column::Index).value.as_u64();
        let index = found.and_then(|index| u32::try_from(index).ok());
        if index.is_none() {
            let help = "the points of a block are counted 0, 1, 2, …";
            self.unexpected(Column::Index, "a whole number from 0", help);
        }
        index
    }

    fn number(&mut self, column: Column) -> Option<f64> {
        let found = self.raw.cell(column).value.as_f64();
        let number = found.filter(|number| number.is_finite());
        if number.is_none() {
            let help = "write digits with a decimal point; a row without a value is left out";
            self.unexpected(column, "a finite number", help);
        }
        number
    }

    /// The increment is empty at the first point, and only there.
    fn increment(&mut self, index: Option<u32>) -> Option<Option<f64>> {
        let is_empty = self.raw.cell(Column::Increment).value.is_null();
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
            let complaint = self.raw.complaint(Column::Correction, &message, help);
            self.complaints.push(complaint);
        }
    }

    fn unexpected(&mut self, column: Column, expected: &str, help: &str) {
        let found = match &self.raw.cell(column).value {
            Value::Null => "empty".to_string(),
            Value::String(text) => format!("`{text}`"),
            other => format!("`{other}`"),
        };
        let message = format!("`{}` is {found}, expected {expected}", column.name());
        self.complaints
            .push(self.raw.complaint(column, &message, help));
    }
}
