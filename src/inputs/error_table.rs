//! The measured errors of a machine: the error table of contract §2.1.
//!
//! One row is one position of one axis, with the deviations in X, Y and Z while that axis stands
//! there. What is not measured is absent (`None`), never zero. A table that exists has passed
//! every check of the format; its rows still know their lines, so that later checks can point at them.

mod read;
mod remarks;

pub(crate) use self::read::known_columns;
pub use self::read::{Heading, Series};
use self::read::{headings, record, refuse_single_positions, series_of, table};
pub use self::remarks::{
    Cause, LargestErrors, Remarks, SIMULATED, Silence, Sizes, is_simulated, keys,
};
pub use crate::inputs::kind::{Component, Kind};
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content};
use crate::quantity::{AT_PLACE_MM, Axis, Direction, ErrorTerm, Figure, PerAxis};
use crate::text::{Notes, Place, Problem, Problems, Source, joined, lines, plain};

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
        let notes = Notes::default();
        let table = table(&source, &notes)?;
        let records = table.rows(|row| record(&table, row));
        let all_rows_read = notes.is_sound();
        let series = series_of(&table, &records);
        if all_rows_read {
            refuse_single_positions(&table, &series);
        }
        if table.lines.is_empty() {
            table.refuse(refusals::no_positions());
        }
        let (header, headings) = (table.header.whole(), vec![headings(&table)]);
        notes.end(())?;
        let remarks = Remarks::read(&source.text);
        Ok(ErrorTable { header, remarks, series, headings, more: Vec::new(), source })
    }

    /// Whether it is a single file.
    pub(crate) fn is_single(&self) -> bool {
        self.more.is_empty()
    }

    /// The series of an axis: of each table one without direction, or one or two with.
    pub fn series(&self, axis: Axis) -> &[Series] {
        &self.series[axis]
    }

    /// The heading under which the deviations of a term stand.
    pub(crate) fn heading(&self, term: ErrorTerm) -> Option<&Heading> {
        let mut series = self.series[term.along].iter();
        let own = series.find(|series| series.values.contains_key(&Kind::Deviation(term.of)))?;
        self.headings.get(own.table)?[term.of].as_ref()
    }

    /// The place of a row of a series.
    pub fn place(&self, series: &Series, row: usize) -> Option<Place> {
        let line = *series.lines.get(row)?;
        Some(lines(self.source_of(series)?).nth(line - 1)?.whole())
    }

    /// The file in which a series stands.
    fn source_of(&self, series: &Series) -> Option<&Source> {
        std::iter::once(&self.source).chain(&self.more).nth(series.table)
    }
}

/// Several error tables of one machine → one: a laser measures an axis a file. Every component of an axis
/// comes from one table: two files have two zeros, and what lies between them is not measured.
impl ErrorTable {
    /// Whether every cell of a table can be read and any value was filled in, whatever was measured.
    pub(crate) fn look_at_cells(source: Source) -> Result<(), Problems> {
        let table = ErrorTable::read(source)?;
        let all = table.series.iter().flat_map(|(_, series)| series);
        match all.flat_map(Series::components).next() {
            Some(_) => Ok(()),
            None => Err(table.holds_nothing().into()),
        }
    }

    /// That no deviation was filled in.
    pub(crate) fn holds_nothing(&self) -> Problem {
        refusals::holds_nothing().at(self.header.clone())
    }

    /// One table with the series of all; `None` = there is none. What stands in two of them, or
    /// does not fit together, is a problem at its first row.
    pub fn merged(tables: Vec<ErrorTable>) -> Result<Option<ErrorTable>, Problems> {
        let mut problems = Problems::none();
        let mut tables = tables.into_iter();
        let Some(mut whole) = tables.next() else {
            return Ok(None);
        };
        for other in tables {
            for axis in Axis::ALL {
                if let Some(new) = other.series[axis].first()
                    && let Some(mut problem) = whole.misfit(axis, new, &other)
                {
                    problem.place = other.place(new, 0);
                    problems.push(problem);
                }
            }
            whole.add(other);
        }
        problems.or_ok(Some(whole))
    }

    fn add(&mut self, other: ErrorTable) {
        let before = self.more.len() + 1;
        self.more.push(other.source);
        self.more.extend(other.more);
        self.headings.extend(other.headings);
        self.remarks.extend(other.remarks);
        for axis in Axis::ALL {
            let series = other.series[axis].iter().cloned();
            self.series[axis]
                .extend(series.map(|series| Series { table: before + series.table, ..series }));
        }
    }

    /// What does not fit together.
    fn misfit(&self, axis: Axis, new: &Series, other: &ErrorTable) -> Option<Problem> {
        let known = &self.series[axis];
        if let Some(old) = known.iter().find(|old| !shared(old, new).is_empty()) {
            let one = self.source_of(old).map_or("", |source| &source.name);
            let names = joined(shared(old, new));
            return Some(refusals::in_two_tables(names, one, &other.source.name));
        }
        let is_directed = |series: &Series| series.direction.is_some();
        if known.iter().any(|old| is_directed(old) != is_directed(new)) {
            return Some(refusals::directed_in_one(axis));
        }
        self.other_range(axis, &other.series[axis]).then(|| refusals::other_range(axis))
    }

    fn other_range(&self, axis: Axis, new: &[Series]) -> bool {
        let differ = |old: &Series, new: &Series| {
            let ends = |series: &Series| series.ends_mm().into_iter().flatten();
            let mut ends = ends(old).zip(ends(new));
            old.direction == new.direction && ends.any(|(a, b)| (a - b).abs() > AT_PLACE_MM)
        };
        let known = &self.series[axis];
        new.iter().any(|new| known.iter().any(|old| differ(old, new)))
    }
}

/// Components of an axis that both series hold, e.g. `EXX`.
fn shared(old: &Series, new: &Series) -> Vec<Component> {
    old.components().filter(|own| new.values.contains_key(&own.kind)).collect()
}

// Writing an error table: rows in memory → the CSV of contract §2.1.
//
// ```text
//   # comment lines, as given
//   axis,direction,position_mm,ex_um,ea_urad,u_ex_um
//   x,+,0,1.5,-2.25,0.1
// ```
// Axes in the order X, Y, Z; within an axis the series in the order of the draft. Only what was
// measured has a column. Numbers are the shortest text that reads back to the same number, lines
// end with LF: the same draft gives the same bytes everywhere.

/// An error table that is going to be written.
///
/// Whoever fills it keeps to the rules of the format: positions strictly ascending, as many values
/// as positions, an axis either with directions or without. [`ErrorTable::read`] judges
/// what was written like any other table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    /// Lines above the header, without their `#`.
    pub comments: Vec<String>,
    /// The measured curves.
    pub series: Vec<Series>,
}

/// The text of a draft.
pub fn write(draft: &Draft) -> String {
    let columns = columns(draft);
    let header = columns.iter().map(|column| column.name.clone()).collect::<Vec<String>>();
    let of = |axis: Axis| draft.series.iter().filter(move |series| series.axis == axis);
    let rows = Axis::ALL.into_iter().flat_map(of).flat_map(|series| {
        let columns = &columns;
        let rows = 0..series.positions.len();
        rows.map(|row| columns.iter().map(|column| cell(series, column.content, row)).collect())
    });
    let table = std::iter::once(header).chain(rows).map(|cells| cells.join(","));
    let comments = draft.comments.iter().map(|comment| plain::comment(comment));
    comments.chain(table).map(|line| line + "\n").collect()
}

/// Empty = not measured.
fn cell(series: &Series, holds: Content, row: usize) -> String {
    match holds {
        Content::Axis => series.axis.key().to_string(),
        Content::Direction => series.direction.map_or("", Direction::symbol).to_string(),
        _ => series.number(holds, row).map_or_else(String::new, |it| Figure(it).to_string()),
    }
}

/// Where and which way, then deviations, angles and uncertainties; only those that some series holds.
fn columns(draft: &Draft) -> Vec<Column> {
    let mut columns = known_columns();
    columns.dedup_by_key(|column| column.content);
    columns.retain(|column| {
        let is_held = |series: &Series| !cell(series, column.content, 0).is_empty();
        let is_needed = matches!(column.content, Content::Axis | Content::Position);
        is_needed || draft.series.iter().any(is_held)
    });
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::error_table::ErrorTable;
    use crate::quantity::Millimetres;
    use crate::text::Source;

    #[test]
    fn quotation_marks_and_empty_rows_do_not_matter() {
        let text = b"axis;position_mm;\"ex_um\"\n\"x\";\"0\";0,5\n;;\nx; \"1,5\" ;1\n";
        let source = Source::from_bytes("errors.csv", text).expect("it is text");
        let table = ErrorTable::read(source).expect("it is a table");
        let series = &table.series(Axis::X)[0];
        assert_eq!(series.positions[1], Millimetres::new(1.5));
        assert_eq!(table.place(series, 1).map(|place| place.line), Some(4));
    }

    fn table(name: &str, text: &str) -> ErrorTable {
        let source = Source::from_bytes(name, text.as_bytes()).expect("it is text");
        ErrorTable::read(source).expect("it is a table")
    }

    fn said(tables: Vec<ErrorTable>) -> String {
        ErrorTable::merged(tables).map_or_else(|p| p.render(), |_| String::new())
    }

    #[test]
    fn each_row_keeps_its_file_and_line() {
        let merged = ErrorTable::merged(vec![
            table("x.csv", "axis,position_mm,ex_um\nx,0,0\nx,9,1\n"),
            table("y.csv", "# laser\naxis,position_mm,ey_um\ny,0,0\ny,9,2\n"),
            table("xs.csv", "axis,position_mm,ey_um\nx,0,0\nx,4,1\nx,9,3\n"),
        ]);
        let merged = merged.expect("they fit").expect("there are some");
        let places: Vec<(String, usize)> = [(Axis::X, 0), (Axis::Y, 0), (Axis::X, 1)]
            .into_iter()
            .filter_map(|(axis, n)| merged.place(&merged.series(axis)[n], 1))
            .map(|place| (place.file, place.line))
            .collect();
        let expected = [("x.csv", 3), ("y.csv", 4), ("xs.csv", 3)];
        assert_eq!(places, expected.map(|(file, line)| (file.to_string(), line)));
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let x = || table("x.csv", "axis,position_mm,ex_um\nx,0,0\nx,9,1\n");
        let again =
            table("a.csv", "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,9,1,0\n");
        let directed = table("d.csv", "axis,direction,position_mm,ey_um\nx,+,0,0\nx,+,9,1\n");
        let shorter = table("s.csv", "axis,position_mm,ey_um\nx,0,0\nx,8,1\n");
        assert!(said(vec![x(), again]).contains("EXX stands in two tables, `x.csv` and `a.csv`"));
        assert!(said(vec![x(), directed]).contains("with directions in one table"));
        assert!(said(vec![x(), shorter]).contains("another range"));
    }

    fn series(axis: Axis, direction: Option<Direction>, mm: &[f64]) -> Series {
        Series::new(axis, direction, mm.iter().copied().map(Millimetres::new).collect())
    }

    /// X in both directions with uncertainties, Z without direction and with an angle.
    fn draft() -> Draft {
        let mut plus = series(Axis::X, Some(Direction::Plus), &[-0.1, 1.0 / 3.0]);
        plus.values.insert(Kind::Deviation(Axis::X), vec![0.1 + 0.2, -0.0]);
        plus.uncertainties.insert(Kind::Deviation(Axis::X), vec![1e-7, 2.5]);
        let mut minus = plus.clone();
        minus.direction = Some(Direction::Minus);
        let mut z = series(Axis::Z, None, &[-720.0, 1e-9]);
        z.values.insert(Kind::Deviation(Axis::Y), vec![f64::MIN_POSITIVE, 123_456.789]);
        z.values.insert(Kind::Angle(Axis::Z), vec![1.0, -2.25]);
        Draft { comments: vec!["first\nline ".to_string()], series: vec![z, plus, minus] }
    }

    fn read(text: &str) -> ErrorTable {
        let source = Source::from_bytes("errors.csv", text.as_bytes()).expect("it is text");
        ErrorTable::read(source).expect("it is a table")
    }

    #[test]
    fn only_what_was_measured_has_a_column() {
        let mut x = series(Axis::X, None, &[0.0, 30.0]);
        x.values.insert(Kind::Deviation(Axis::Y), vec![0.0, -0.25]);
        let draft = Draft { comments: vec!["made by hand".to_string()], series: vec![x] };
        let expected = "# made by hand\naxis,position_mm,ey_um\nx,0,0\nx,30,-0.25\n";
        assert_eq!(write(&draft), expected);
    }

    #[test]
    fn comments_come_first_and_axes_in_their_order() {
        let text = write(&draft());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "# first�line");
        assert_eq!(lines[1], "axis,direction,position_mm,ex_um,ey_um,ec_urad,u_ex_um");
        assert_eq!(lines[2], "x,+,-0.1,0.30000000000000004,,,0.0000001");
        assert!(lines[6].starts_with("z,,-720,,"), "{}", lines[6]);
        assert!(!text.contains('\r') && text.ends_with('\n'));
    }

    #[test]
    fn what_is_written_reads_back_to_the_same_numbers() {
        let draft = draft();
        let text = write(&draft);
        assert!(!text.contains(&"0".repeat(20)), "{text}");
        let table = read(&text);
        for wanted in &draft.series {
            let found = table.series(wanted.axis);
            let found = found.iter().find(|s| s.direction == wanted.direction);
            let found = found.expect("the series is there");
            let wanted = Series { lines: found.lines.clone(), ..wanted.clone() };
            assert_eq!(*found, wanted);
        }
    }
}
