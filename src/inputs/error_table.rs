//! The measured errors of a machine: the error table of contract §2.1.
//!
//! One row is one position of one axis, with the deviations in X, Y and Z while that axis stands
//! there. What is not measured is absent (`None`), never zero. A table that exists has passed
//! every check of the format; its rows still know their lines, so that later checks can point at them.

mod merged;
mod read;
mod remarks;
mod text;

pub(crate) use self::read::{Column, Quantity, known_columns};
pub use self::read::{Heading, Series};
pub use self::remarks::{Remarks, SIMULATED};
pub use self::text::{Draft, DraftSeries, write};

use self::read::{Columns, FIRST_LINE, Record, refuse_single_positions};
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis};
use crate::text::delimited::header_and_rows;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems};

/// A checked error table.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// The file; of several the first.
    pub source: Source,
    /// The line that names the columns.
    pub header: Place,
    /// What its comments say of it.
    pub remarks: Remarks,
    series: PerAxis<Vec<Series>>,
    /// The headings of the deviations in X, Y, Z: of each table one entry.
    headings: Vec<PerAxis<Option<Heading>>>,
    /// Files of the tables that were merged into this one.
    more: Vec<Source>,
}

impl ErrorTable {
    /// Reads and checks a table; all problems of the file are given at once.
    pub fn read(source: Source) -> Result<ErrorTable, Problems> {
        let Some((header, rows)) = header_and_rows(&source) else {
            return Err(Problem::new(format!(
                "`{}` holds no table, expected a header and measured positions",
                source.name
            ))
            .help(FIRST_LINE)
            .into());
        };
        let columns = Columns::read(&header)?;
        let mut problems = Problems::none();
        let records = rows.iter();
        let records = records.filter_map(|row| columns.record(row, &mut problems));
        let records: Vec<Record<'_>> = records.collect();
        let all_rows_read = problems.is_empty();
        let series = PerAxis::from_fn(|axis| columns.series_of(axis, &records, &mut problems));
        for (axis, series) in series.iter().filter(|_| all_rows_read) {
            refuse_single_positions(axis, &records, series, &mut problems);
        }
        if rows.is_empty() {
            problems.push(
                Problem::new("the table has a header but no rows, expected measured positions")
                    .at(header.whole())
                    .help("write one row for each measured position, e.g. x,0,0"),
            );
        }
        let headings = vec![columns.headings(&header)];
        let header = header.whole();
        let remarks = Remarks::read(&source.text);
        problems.or_ok(()).map(|()| ErrorTable {
            source,
            header,
            remarks,
            series,
            headings,
            more: Vec::new(),
        })
    }

    /// The series of an axis: of each table one without direction, or one or two with.
    pub fn series(&self, axis: Axis) -> &[Series] {
        &self.series[axis]
    }

    /// The heading under which the deviations of a term stand.
    pub(crate) fn heading(&self, term: ErrorTerm) -> Option<&Heading> {
        let mut series = self.series[term.along].iter();
        let own = series.find(|series| series.deviations[term.of].is_some())?;
        self.headings.get(own.table)?[term.of].as_ref()
    }

    /// The place of a row of a series.
    pub fn place(&self, series: &Series, row: usize) -> Option<Place> {
        let line = *series.lines.get(row)?;
        let source = self.source_of(series)?;
        let text = source.text.lines().nth(line - 1)?;
        Some(Place {
            line,
            ..Place::in_text(&source.name, text, 0, text.len())
        })
    }

    /// The file in which a series stands.
    fn source_of(&self, series: &Series) -> Option<&Source> {
        match series.table.checked_sub(1) {
            None => Some(&self.source),
            Some(index) => self.more.get(index),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use super::*;
    use crate::quantity::units::Millimetres;

    #[test]
    fn quotation_marks_and_empty_rows_do_not_matter() {
        let text = b"axis;position_mm;\"ex_um\"\n\"x\";\"0\";0,5\n;;\nx; \"1,5\" ;1\n";
        let source = Source::from_bytes("errors.csv", text).expect("it is text");
        let table = ErrorTable::read(source).expect("it is a table");
        let series = &table.series(Axis::X)[0];
        assert_eq!(series.positions[1], Millimetres::new(1.5));
        assert_eq!(table.place(series, 1).map(|place| place.line), Some(4));
    }
}
