//! A table that a person brings: what its columns may hold, its header, and its rows cell by cell.
//!
//! One vocabulary for all of them: an error table, readings of the diagonals, runs of an axis, and the sheets of
//! other programs, whose columns are mapped to these words.

use crate::inputs::error_table::Kind;
use crate::inputs::refusals;
use crate::inputs::target_runs::Values;
use crate::quantity::{Axis, Direction, UM_PER_MM};
use crate::text::{
    LengthUnit, Line, Notes, Problem, Problems, Source, header_and_rows, refuse_other_first_line,
    shown, unknown_column,
};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Content {
    /// The moving axis.
    Axis,
    /// Direction of travel.
    Direction,
    /// Number of the run.
    Run,
    /// Number of the target; not used.
    Index,
    /// A machine coordinate.
    Position,
    /// A position that counts from the instrument's zero.
    Target,
    /// What was measured of an error.
    Value(Kind),
    /// The standard uncertainty of what was measured.
    Uncertainty(Kind),
    /// What the instrument showed at the target.
    Reading(Reading),
    /// The diagonal, the node on it, and the axis that moved there.
    Diagonal,
    Node,
    Moved,
    /// Of the scale of an axis, °C.
    Temperature(Axis),
}

/// A reading at a target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// The way of the axis, where the column has one of its own.
    pub(crate) direction: Option<Direction>,
    /// The run, where the column has one of its own.
    pub(crate) run: Option<u32>,
    /// Where the axis stood, or how far from the target; `None` = the values show it.
    pub(crate) values: Option<Values>,
}

impl Content {
    /// A reading whose direction and run stand in other columns.
    pub(crate) const fn reading(values: Values) -> Content {
        Content::Reading(Reading { direction: None, run: None, values: Some(values) })
    }

    /// What was read, of a column that holds it.
    pub(crate) const fn as_reading(self) -> Option<Reading> {
        match self {
            Content::Reading(reading) => Some(reading),
            _ => None,
        }
    }

    pub(crate) const fn is_reading(self) -> bool {
        self.as_reading().is_some()
    }

    /// The reading of a sheet that has a column for each run.
    pub(crate) fn of_run(self) -> Option<Reading> {
        self.as_reading().filter(|reading| reading.run.is_some())
    }

    /// Whether two columns give the same.
    pub(crate) fn is_same(self, other: Content) -> bool {
        let place = |reading: Reading| (reading.direction, reading.run);
        match (self.as_reading(), other.as_reading()) {
            (Some(own), Some(other)) => place(own) == place(other),
            _ => self == other,
        }
    }
}

/// A unit as it ends the name of a column, and how many µm or µrad it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    pub(crate) word: &'static str,
    pub(crate) factor: f64,
}

impl Unit {
    pub(crate) const fn of(length: LengthUnit) -> Unit {
        Unit { word: length.word(), factor: length.um() }
    }
}

const UM: Unit = Unit::of(LengthUnit::Um);
pub(crate) const MM: Unit = Unit::of(LengthUnit::Mm);
pub(crate) const INCH: Unit = Unit::of(LengthUnit::In);
/// Units of lengths.
pub(crate) const LENGTHS: [Unit; 4] = [UM, MM, INCH, Unit::of(LengthUnit::Uin)];

/// A column by its name; without a unit it holds words or counts, or its name does not say the unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// Its place in the row.
    pub(crate) index: usize,
    pub(crate) name: String,
    pub(crate) content: Content,
    pub(crate) unit: Option<Unit>,
}

impl Column {
    /// What turns its numbers into mm (places), µm or µrad.
    pub(crate) fn factor(&self) -> f64 {
        match self.content {
            Content::Position | Content::Target => self.factor_um() / UM_PER_MM,
            _ => self.factor_um(),
        }
    }

    /// What turns its numbers into µm or µrad.
    pub(crate) fn factor_um(&self) -> f64 {
        self.unit.map_or(1.0, |unit| unit.factor)
    }
}

/// Every name of some quantities: each with every unit of it, or alone where it has none.
pub(crate) fn named(quantities: &[(&str, Content, &[Unit])]) -> Vec<Column> {
    let of = |(name, content, units): &(&str, Content, &[Unit])| {
        let column = |name, unit| Column { index: 0, name, content: *content, unit };
        match units {
            [] => vec![column(name.to_string(), None)],
            units => {
                let named = |unit: &Unit| column(format!("{name}_{}", unit.word), Some(*unit));
                units.iter().map(named).collect::<Vec<Column>>()
            }
        }
    };
    quantities.iter().flat_map(of).collect()
}

/// A table whose columns are known.
pub(crate) struct Table<'a> {
    pub(crate) header: Line<'a>,
    pub(crate) columns: Vec<Column>,
    pub(crate) lines: Vec<Line<'a>>,
    pub(crate) notes: &'a Notes,
    /// What its first line should be.
    pub(crate) first_line: &'static str,
}

impl<'a> Table<'a> {
    /// Reads the header; the words are what the table should hold, its first line, and its columns.
    pub(super) fn read(
        source: &'a Source,
        notes: &'a Notes,
        [what, first_line, columns]: [&'static str; 3],
        known: impl FnOnce(&Line<'a>) -> Result<Vec<Column>, Problem>,
    ) -> Result<Table<'a>, Problems> {
        let (header, lines) = header_and_rows(source)
            .ok_or_else(|| refusals::no_table_at_all(&source.name, what, first_line))?;
        let known = known(&header)?;
        refuse_other_first_line(&header, first_line)?;
        let names: Vec<&str> = known.iter().map(|column| column.name.as_str()).collect();
        let mut found = Vec::<Column>::new();
        for (index, name) in header.cells().iter().enumerate() {
            let refuse = |problem: Problem| notes.refuse(problem.at(header.cell_place(index)));
            let Some(own) = known.iter().find(|own| own.name == **name) else {
                refuse(unknown_column(name, &names, columns));
                continue;
            };
            if let Some(twin) = found.iter().find(|other| other.content.is_same(own.content)) {
                refuse(refusals::same_column(name, &twin.name));
            }
            found.push(Column { index, ..own.clone() });
        }
        notes.end(Table { header, columns: found, lines, notes, first_line })
    }

    /// The first column that holds such a thing.
    pub(super) fn find(&self, is_wanted: impl Fn(Content) -> bool) -> Option<&Column> {
        self.columns.iter().find(|column| is_wanted(column.content))
    }

    /// The first column that holds it.
    pub(super) fn column(&self, content: Content) -> Option<&Column> {
        self.find(|own| own == content)
    }

    /// Notes that a column is needed and was not found.
    pub(super) fn require(&self, found: Option<&Column>, what: &str, example: &str) {
        if found.is_none() {
            self.refuse(refusals::no_column_for(what, example, self.first_line));
        }
    }

    /// Notes a problem of the header as a whole.
    pub(super) fn refuse(&self, problem: Problem) {
        self.notes.refuse(problem.at(self.header.whole()));
    }

    /// A problem of a column.
    pub(super) fn at(&self, column: &Column, problem: Problem) -> Problem {
        problem.at(self.header.cell_place(column.index))
    }

    /// What `read` makes of each row that can be read; the problems of the others are noted.
    pub(super) fn rows<T>(&self, mut read: impl FnMut(&TableRow<'_, 'a>) -> Option<T>) -> Vec<T> {
        let width = self.header.cells().len();
        let mut rows = Vec::with_capacity(self.lines.len());
        for line in &self.lines {
            if let Some(cells) = self.notes.take(line.cells_under(width)) {
                rows.extend(read(&TableRow { line: *line, table: self, cells }));
            }
        }
        rows
    }
}

/// What the number of a run has to be, as every count, and the next step where it is something else.
pub(super) const RUN: (&str, &str) = ("a whole number from 1", "number the runs 1, 2, 3 …");

/// A whole number from 1.
pub(super) fn count<N: FromStr + PartialOrd + From<u8>>(text: &str) -> Option<N> {
    text.parse().ok().filter(|count| *count >= N::from(1))
}

/// The cells of one row, while it is read.
pub(crate) struct TableRow<'t, 'a> {
    pub(crate) line: Line<'a>,
    table: &'t Table<'a>,
    cells: Vec<Cow<'a, str>>,
}

impl TableRow<'_, '_> {
    /// A cell under the name of its column.
    pub(super) fn cell<'r>(&'r self, column: &'r Column) -> Cell<'r> {
        Cell { notes: self.table.notes, line: &self.line, column, text: &self.cells[column.index] }
    }

    /// What the cell of a column means; `absent` where the table has no such column.
    pub(super) fn parsed<T>(
        &self,
        content: Content,
        absent: Option<T>,
        parse: impl Fn(&str) -> Option<T>,
        expected: (&str, &str),
    ) -> Option<T> {
        let Some(column) = self.table.column(content) else { return absent };
        self.cell(column).read(parse, format_args!("`{}` is", column.name), expected)
    }
}

/// A cell, which notes what is wrong with it.
pub(crate) struct Cell<'r> {
    notes: &'r Notes,
    line: &'r Line<'r>,
    column: &'r Column,
    pub(crate) text: &'r str,
}

impl Cell<'_> {
    /// Notes what is wrong here.
    pub(super) fn refuse(&self, problem: Problem) {
        let index = self.column.index;
        self.notes.refuse_with(|| problem.at(self.line.cell_place(index)).in_column(index));
    }

    /// What is read from the cell; where that is nothing, a problem says what was expected and the next step.
    pub(super) fn read<T>(
        &self,
        read: impl Fn(&str) -> Option<T>,
        what: impl fmt::Display,
        (expected, help): (&str, &str),
    ) -> Option<T> {
        let value = read(self.text);
        if value.is_none() {
            self.refuse(refusals::other_cell(what, shown(self.text), expected, help));
        }
        value
    }

    /// The finite number of the cell in the unit of its column; `expected` is the next step where it is none.
    pub(super) fn number(&self, expected: &str) -> Option<f64> {
        let Column { index, name, .. } = self.column;
        self.notes.with(|problems| self.line.number_in(*index, self.text, name, expected, problems))
    }

    /// A number that must be there.
    pub(super) fn reading(&self, missing: &str) -> Option<f64> {
        if self.text.is_empty() {
            self.refuse(refusals::empty_cell(&self.column.name, missing));
            return None;
        }
        self.number("write a plain number; its unit stands in the header")
    }

    /// A number that is not below 0.
    pub(super) fn uncertainty(&self, expected: &str) -> Option<f64> {
        let number = self.number(expected)?;
        if number < 0.0 {
            self.refuse(refusals::no_uncertainty(&self.column.name, shown(self.text)));
        }
        Some(number).filter(|number| *number >= 0.0)
    }
}
