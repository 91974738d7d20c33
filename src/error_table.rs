//! The measured errors of a machine: the error table of contract §2.1.
//!
//! One row is one position of one axis, with the deviations in X, Y and Z while that axis stands
//! there. What is not measured is absent (`None`), never zero. A table that exists has passed
//! every check of the format; its rows still know their lines, so that later checks can point at them.

mod text;

pub use text::{Draft, DraftSeries, write};

use crate::axis::{Axis, Direction, PerAxis};
use crate::document::Source;
use crate::problem::{Place, Problem, Problems, nearest, shown};
use crate::units::{Deviation, MM_PER_INCH, Millimetres, UM_PER_MM};
use std::borrow::Cow;
use std::ops::Range;

/// All measured positions of one axis in one direction (or without regard to direction).
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Direction of travel; `None` = both.
    pub direction: Option<Direction>,
    /// Machine coordinates, strictly ascending.
    pub positions: Vec<Millimetres>,
    /// Deviations in X, Y, Z, one for each position; `None` = not measured.
    pub deviations: PerAxis<Option<Vec<Deviation>>>,
    /// Standard uncertainties (k = 1) of the deviations, µm.
    pub uncertainties_um: PerAxis<Option<Vec<f64>>>,
    /// Rotations about X, Y, Z (`ea`, `eb`, `ec`), µrad, right-handed.
    pub angles_urad: PerAxis<Option<Vec<f64>>>,
    lines: Vec<usize>,
}

/// A checked error table.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// The file.
    pub source: Source,
    /// The line that names the columns.
    pub header: Place,
    series: PerAxis<Vec<Series>>,
}

impl ErrorTable {
    /// Reads and checks a table; all problems of the file are given at once.
    pub fn read(source: Source) -> Result<ErrorTable, Problems> {
        let lines = Lines::of(&source);
        let Some((header, rows)) = lines.split_header() else {
            return Err(Problem::new(format!(
                "`{}` holds no table, expected a header and measured positions",
                source.name
            ))
            .help(FIRST_LINE)
            .into());
        };
        let columns = Columns::read(&header)?;
        let (records, mut problems) = read_rows(&columns, &rows);
        let all_rows_read = problems.is_empty();
        let mut series = PerAxis::from_fn(|_| Vec::new());
        for axis in Axis::ALL {
            series[axis] = series_of(axis, &records, &columns, &mut problems);
        }
        if all_rows_read {
            refuse_single_positions(&records, &series, &mut problems);
        }
        if rows.is_empty() {
            problems.push(
                Problem::new("the table has a header but no rows, expected measured positions")
                    .at(header.place(0..header.text.len()))
                    .help("write one row for each measured position, e.g. x,0,0"),
            );
        }
        let header = header.place(0..header.text.len());
        problems.or_ok(()).map(|()| ErrorTable {
            source,
            header,
            series,
        })
    }

    /// The series of an axis: one without direction, or one or two with.
    pub fn series(&self, axis: Axis) -> &[Series] {
        &self.series[axis]
    }

    /// The place of a row of a series.
    pub fn place(&self, series: &Series, row: usize) -> Option<Place> {
        let line = *series.lines.get(row)?;
        let text = self.source.text.lines().nth(line - 1)?;
        Some(Place {
            line,
            ..Place::in_text(&self.source.name, text, 0, text.len())
        })
    }
}

/// One line of the file. Its cells and places are found when they are asked for: a table may have
/// a million of them.
#[derive(Clone, Copy)]
struct Line<'a> {
    file: &'a str,
    number: usize,
    text: &'a str,
    delimiter: u8,
}

impl<'a> Line<'a> {
    fn cells(&self) -> Vec<Cow<'a, str>> {
        cells_of(self.text, self.delimiter)
    }

    fn place(&self, span: Range<usize>) -> Place {
        let inside = Place::in_text(self.file, self.text, span.start, span.end);
        Place {
            line: self.number,
            ..inside
        }
    }

    fn whole(&self) -> Place {
        self.place(0..self.text.len())
    }

    fn cell_place(&self, index: usize) -> Place {
        let starts = starts_of(self.text, self.delimiter);
        let start = starts.get(index).copied().unwrap_or(self.text.len());
        let end = starts
            .get(index + 1)
            .map_or(self.text.len(), |next| next - 1);
        let cell = &self.text[start.min(end)..end];
        let indent = cell.len() - cell.trim_start().len();
        self.place(start + indent..start + indent + cell.trim().len().max(1))
    }
}

struct Lines<'a> {
    lines: Vec<Line<'a>>,
}

impl<'a> Lines<'a> {
    fn of(source: &'a Source) -> Lines<'a> {
        let content = source
            .text
            .split('\n')
            .enumerate()
            .map(|(index, text)| (index + 1, text.trim_end_matches('\r')))
            .filter(|(_, text)| !text.trim().is_empty() && !text.trim_start().starts_with('#'));
        let mut content = content.peekable();
        let delimiter = match content.peek() {
            Some((_, header)) if header.contains(';') => b';',
            _ => b',',
        };
        let lines = content
            .map(|(number, text)| Line {
                file: &source.name,
                number,
                text,
                delimiter,
            })
            .filter(|line| !is_empty_row(line.text, delimiter))
            .collect();
        Lines { lines }
    }

    fn split_header(self) -> Option<(Line<'a>, Vec<Line<'a>>)> {
        let mut lines = self.lines.into_iter();
        let header = lines.next()?;
        Some((header, lines.collect()))
    }
}

/// A row of nothing but separators, as spreadsheets write below a table.
fn is_empty_row(line: &str, delimiter: u8) -> bool {
    let empty = |c: char| c == char::from(delimiter) || c == '"' || c.is_whitespace();
    line.chars().all(empty)
}

fn cells_of(line: &str, delimiter: u8) -> Vec<Cow<'_, str>> {
    if !line.contains('"') {
        let cells = line.split(char::from(delimiter));
        return cells.map(|cell| Cow::Borrowed(cell.trim())).collect();
    }
    let starts = starts_of(line, delimiter);
    let ends = starts.iter().skip(1).map(|next| next - 1);
    starts
        .iter()
        .zip(ends.chain(std::iter::once(line.len())))
        .map(|(start, end)| unquoted(line[*start..end].trim()))
        .collect()
}

/// A cell without the quotation marks around it; two of them inside stand for one.
fn unquoted(cell: &str) -> Cow<'_, str> {
    let inside = cell.strip_prefix('"').and_then(|c| c.strip_suffix('"'));
    match inside {
        Some(inside) if inside.contains('"') => Cow::Owned(inside.replace("\"\"", "\"")),
        Some(inside) => Cow::Borrowed(inside.trim()),
        None => Cow::Borrowed(cell),
    }
}

fn starts_of(line: &str, delimiter: u8) -> Vec<usize> {
    let mut quoted = false;
    let mut starts = vec![0];
    for (at, byte) in line.bytes().enumerate() {
        quoted ^= byte == b'"';
        if byte == delimiter && !quoted {
            starts.push(at + 1);
        }
    }
    starts
}

/// What a column holds; factors turn the column's unit into mm, µm or µrad.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    Axis,
    Direction,
    Position { to_mm: f64 },
    Deviation { of: Axis, to_um: f64 },
    Uncertainty { of: Axis, to_um: f64 },
    Angle { about: Axis, to_urad: f64 },
    AngleUncertainty { about: Axis },
}

const FIRST_LINE: &str = "first line: axis,position_mm,ex_um,ey_um,ez_um";

const MRAD: f64 = 1000.0;
/// Microradians in one second of arc.
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0) * 1e6;

fn known_columns() -> Vec<(String, Column)> {
    let mut known = vec![
        ("axis".to_string(), Column::Axis),
        ("direction".to_string(), Column::Direction),
        ("position_mm".to_string(), Column::Position { to_mm: 1.0 }),
        (
            "position_in".to_string(),
            Column::Position { to_mm: MM_PER_INCH },
        ),
    ];
    let lengths = [
        ("um", 1.0),
        ("mm", UM_PER_MM),
        ("in", MM_PER_INCH * UM_PER_MM),
        ("uin", MM_PER_INCH * UM_PER_MM / 1e6),
    ];
    let angles = [("urad", 1.0), ("mrad", MRAD), ("arcsec", ARCSEC)];
    for (of, letter, angle) in [
        (Axis::X, 'x', 'a'),
        (Axis::Y, 'y', 'b'),
        (Axis::Z, 'z', 'c'),
    ] {
        for (unit, to_um) in lengths {
            known.push((format!("e{letter}_{unit}"), Column::Deviation { of, to_um }));
            known.push((
                format!("u_e{letter}_{unit}"),
                Column::Uncertainty { of, to_um },
            ));
        }
        for (unit, to_urad) in angles {
            known.push((
                format!("e{angle}_{unit}"),
                Column::Angle { about: of, to_urad },
            ));
            known.push((
                format!("u_e{angle}_{unit}"),
                Column::AngleUncertainty { about: of },
            ));
        }
    }
    known
}

struct Columns {
    kinds: Vec<Column>,
    names: Vec<String>,
    decimal_comma: bool,
}

impl Columns {
    fn read(header: &Line<'_>) -> Result<Columns, Problems> {
        let known = known_columns();
        refuse_other_first_line(header)?;
        let mut problems = Problems::none();
        let mut kinds: Vec<Column> = Vec::new();
        let names: Vec<String> = header.cells().iter().map(ToString::to_string).collect();
        for (index, name) in names.iter().enumerate() {
            match known.iter().find(|(known, _)| known == name) {
                Some((_, kind)) => {
                    let twin = kinds.iter().position(|other| same_content(other, kind));
                    if let Some(twin) = twin {
                        problems.push(
                            Problem::new(format!(
                                "column `{name}` gives the same as column `{}` before it",
                                names[twin]
                            ))
                            .at(header.cell_place(index))
                            .help("keep one of the two"),
                        );
                    }
                    kinds.push(*kind);
                }
                None => problems.push(unknown_column(header, index, name, &known)),
            }
        }
        if problems.is_empty() {
            require_columns(header, &kinds, &mut problems);
        }
        problems.or_ok(Columns {
            kinds,
            names,
            decimal_comma: header.text.contains(';'),
        })
    }

    fn position_unit(&self) -> &'static str {
        let inch = |kind: &Column| matches!(kind, Column::Position { to_mm } if *to_mm > 1.0);
        if self.kinds.iter().any(inch) {
            "in"
        } else {
            "mm"
        }
    }

    fn index_of(&self, wanted: impl Fn(&Column) -> bool) -> Option<usize> {
        self.kinds.iter().position(wanted)
    }
}

fn same_content(a: &Column, b: &Column) -> bool {
    match (a, b) {
        (Column::Position { .. }, Column::Position { .. }) => true,
        (Column::Deviation { of: a, .. }, Column::Deviation { of: b, .. })
        | (Column::Uncertainty { of: a, .. }, Column::Uncertainty { of: b, .. })
        | (Column::Angle { about: a, .. }, Column::Angle { about: b, .. })
        | (Column::AngleUncertainty { about: a }, Column::AngleUncertainty { about: b }) => a == b,
        (Column::Axis, Column::Axis) | (Column::Direction, Column::Direction) => true,
        _ => false,
    }
}

/// A table without header, or with tabs, would be one unknown column after the other.
fn refuse_other_first_line(header: &Line<'_>) -> Result<(), Problem> {
    let message = if header.text.contains('\t') {
        "the columns are separated by tabs, expected commas or semicolons"
    } else if header
        .cells()
        .iter()
        .any(|cell| cell.parse::<f64>().is_ok())
    {
        "the first line holds numbers, expected the names of the columns"
    } else {
        return Ok(());
    };
    Err(Problem::new(message)
        .at(header.place(0..header.text.len()))
        .help(FIRST_LINE))
}

fn unknown_column(
    header: &Line<'_>,
    index: usize,
    name: &str,
    known: &[(String, Column)],
) -> Problem {
    let names = || known.iter().map(|(name, _)| name.as_str());
    let with_unit = |quantity: &str| -> Vec<String> {
        names()
            .filter(|known| known.rsplit_once('_').is_some_and(|(q, _)| q == quantity))
            .map(|known| format!("`{known}`"))
            .collect()
    };
    let without = (with_unit(name), "has no unit");
    let other = name.rsplit_once('_').map(|(quantity, _)| quantity);
    let other = (
        other.map(with_unit).unwrap_or_default(),
        "has an unknown unit",
    );
    for (list, what) in [without, other] {
        if !list.is_empty() {
            return Problem::new(format!(
                "column `{}` {what}, expected {}",
                shown(name),
                list.join(", ")
            ))
            .at(header.cell_place(index))
            .help("the unit is part of the column's name");
        }
    }
    let help = nearest(name, names()).map_or_else(
        || "columns: axis, direction, position_mm, ex_um, ey_um, ez_um, u_ex_um …".to_string(),
        |near| format!("did you mean `{near}`?"),
    );
    Problem::new(format!("unknown column `{}`", shown(name)))
        .at(header.cell_place(index))
        .help(help)
}

fn require_columns(header: &Line<'_>, kinds: &[Column], problems: &mut Problems) {
    let whole = header.place(0..header.text.len());
    let mut require = |present: bool, what: &str, example: &str| {
        if !present {
            problems.push(
                Problem::new(format!("there is no column for {what}, expected {example}"))
                    .at(whole.clone())
                    .help(FIRST_LINE),
            );
        }
    };
    require(kinds.contains(&Column::Axis), "the axis", "`axis`");
    require(
        kinds
            .iter()
            .any(|kind| matches!(kind, Column::Position { .. })),
        "the position",
        "`position_mm` or `position_in`",
    );
    require(
        kinds
            .iter()
            .any(|kind| matches!(kind, Column::Deviation { .. } | Column::Angle { .. })),
        "any deviation",
        "`ex_um`, `ey_um` or `ez_um`",
    );
}

/// A row whose cells could all be read.
struct Record<'a> {
    line: Line<'a>,
    axis: Axis,
    direction: Option<Direction>,
    position_mm: f64,
    /// One for each column; `None` = empty, and for columns that hold no number.
    numbers: Box<[Option<f64>]>,
}

fn read_rows<'a>(columns: &Columns, rows: &[Line<'a>]) -> (Vec<Record<'a>>, Problems) {
    let mut problems = Problems::none();
    let records = rows
        .iter()
        .filter_map(|row| read_row(columns, row, &mut problems))
        .collect();
    (records, problems)
}

fn read_row<'a>(columns: &Columns, row: &Line<'a>, problems: &mut Problems) -> Option<Record<'a>> {
    let expected = columns.kinds.len();
    if row.text.matches('"').count() % 2 == 1 {
        problems.push(
            Problem::new("a quotation mark is opened but not closed in this row")
                .at(row.place(0..row.text.len()))
                .help("remove it; numbers need none"),
        );
        return None;
    }
    let cells = row.cells();
    if cells.len() != expected {
        problems.push_with(|| wrong_length(row, cells.len(), expected));
        return None;
    }
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

fn wrong_length(row: &Line<'_>, found: usize, expected: usize) -> Problem {
    let help = if found > expected {
        "remove what is too much; a decimal comma needs semicolons between the columns"
    } else {
        "leave a cell of a column that was not measured empty, but keep its separator"
    };
    Problem::new(format!(
        "the row has {found} cells, expected {expected} as in the header"
    ))
    .at(row.place(0..row.text.len()))
    .help(help)
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
    let quoted = || shown(cell);
    let refuse =
        |message: String, help: &str| Problem::new(message).at(row.cell_place(index)).help(help);
    let text = if columns.decimal_comma {
        cell.replace(',', ".")
    } else {
        cell.to_string()
    };
    let plain = text
        .chars()
        .all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
    let number = text.parse::<f64>().ok().filter(|_| plain);
    match number {
        Some(number) if number.abs() <= LARGEST_NUMBER => {
            let uncertainty = matches!(
                columns.kinds[index],
                Column::Uncertainty { .. } | Column::AngleUncertainty { .. }
            );
            if uncertainty && number < 0.0 {
                problems.push_with(|| {
                    refuse(
                        format!(
                            "`{name}` is {}, expected an uncertainty of at least 0",
                            quoted()
                        ),
                        "write the standard uncertainty, k = 1",
                    )
                });
                return None;
            }
            Some(number)
        }
        Some(_) => {
            problems.push_with(|| {
                refuse(
                    format!(
                        "`{name}` is `{}`, which is too large for any machine",
                        quoted()
                    ),
                    "check the cell",
                )
            });
            None
        }
        None => {
            let help = if cell.contains(',') {
                "a decimal comma needs semicolons between the columns; or write a decimal point"
            } else if matches!(columns.kinds[index], Column::Position { .. }) {
                "write the machine coordinate as a plain number; its unit stands in the header"
            } else {
                "write a plain number; a column that was not measured stays empty for the whole axis"
            };
            problems.push_with(|| {
                refuse(
                    format!("`{name}` is `{}`, expected a finite number", quoted()),
                    help,
                )
            });
            None
        }
    }
}

/// No position, deviation or uncertainty of a machine comes near, whatever its unit.
const LARGEST_NUMBER: f64 = 1e9;

fn series_of(
    axis: Axis,
    records: &[Record<'_>],
    columns: &Columns,
    problems: &mut Problems,
) -> Vec<Series> {
    let of_axis: Vec<&Record<'_>> = records
        .iter()
        .filter(|record| record.axis == axis)
        .collect();
    refuse_mixed_directions(axis, &of_axis, problems);
    let directions = [None, Some(Direction::Plus), Some(Direction::Minus)];
    directions
        .into_iter()
        .filter_map(|direction| {
            let rows: Vec<&Record<'_>> = of_axis
                .iter()
                .copied()
                .filter(|record| record.direction == direction)
                .collect();
            (!rows.is_empty()).then(|| build_series(axis, direction, &rows, columns, problems))
        })
        .collect()
}

fn refuse_mixed_directions(axis: Axis, records: &[&Record<'_>], problems: &mut Problems) {
    let signed = records.iter().any(|record| record.direction.is_some());
    let unsigned = records.iter().find(|record| record.direction.is_none());
    if let (true, Some(record)) = (signed, unsigned) {
        problems.push(
            Problem::new(format!(
                "axis {axis} has rows with and without a direction, expected one kind"
            ))
            .at(record.line.whole())
            .help("give every row of the axis `+` or `-`, or none"),
        );
    }
}

fn build_series(
    axis: Axis,
    direction: Option<Direction>,
    rows: &[&Record<'_>],
    columns: &Columns,
    problems: &mut Problems,
) -> Series {
    refuse_unordered(axis, rows, columns, problems);
    let mut series = Series {
        direction,
        positions: Vec::new(),
        deviations: PerAxis::default(),
        uncertainties_um: PerAxis::default(),
        angles_urad: PerAxis::default(),
        lines: rows.iter().map(|row| row.line.number).collect(),
    };
    for (index, kind) in columns.kinds.iter().enumerate() {
        let name = &columns.names[index];
        let mut values = |factor: f64| column_values(axis, name, index, rows, factor, problems);
        match *kind {
            Column::Position { to_mm } => {
                series.positions = rows
                    .iter()
                    .map(|row| Millimetres::new(row.position_mm * to_mm))
                    .collect();
            }
            Column::Deviation { of, to_um } => {
                series.deviations[of] =
                    values(to_um).map(|um| um.into_iter().map(Deviation::from_um).collect());
            }
            Column::Uncertainty { of, to_um } => series.uncertainties_um[of] = values(to_um),
            Column::Angle { about, to_urad } => series.angles_urad[about] = values(to_urad),
            Column::AngleUncertainty { .. } => drop(values(1.0)),
            Column::Axis | Column::Direction => {}
        }
    }
    series
}

fn refuse_unordered(axis: Axis, rows: &[&Record<'_>], columns: &Columns, problems: &mut Problems) {
    let unit = columns.position_unit();
    for pair in rows.windows(2) {
        let (before, here) = (pair[0].position_mm, pair[1].position_mm);
        if here > before {
            continue;
        }
        let same = (here - before).abs() < f64::EPSILON * before.abs().max(1.0);
        let (message, help) = if same {
            (
                format!("position {here} {unit} of axis {axis} stands twice"),
                "average repeated runs, or give them directions `+` and `-`",
            )
        } else {
            (
                format!(
                    "position {here} {unit} of axis {axis} comes after {before} {unit}, expected ascending positions"
                ),
                "sort the rows of each axis and direction by position",
            )
        };
        problems.push_with(|| Problem::new(message).at(pair[1].line.whole()).help(help));
    }
}

fn refuse_single_positions(
    records: &[Record<'_>],
    series: &PerAxis<Vec<Series>>,
    problems: &mut Problems,
) {
    for axis in Axis::ALL {
        for line in series[axis].iter().filter_map(|s| match s.lines[..] {
            [only] => Some(only),
            _ => None,
        }) {
            let problem = Problem::new(format!(
                "axis {axis} has a single position, expected at least two"
            ))
            .help("one position makes no curve: give another one, or leave the axis out");
            let place = records.iter().find(|record| record.line.number == line);
            problems.push(match place {
                Some(record) => problem.at(record.line.whole()),
                None => problem,
            });
        }
    }
}

/// The values of a column for some rows: all of them, none of them (not measured), or a problem.
fn column_values(
    axis: Axis,
    name: &str,
    index: usize,
    rows: &[&Record<'_>],
    factor: f64,
    problems: &mut Problems,
) -> Option<Vec<f64>> {
    if rows.iter().all(|row| row.numbers[index].is_none()) {
        return None;
    }
    for row in rows.iter().filter(|row| row.numbers[index].is_none()) {
        problems.push(
            Problem::new(format!("`{name}` is empty in one row of axis {axis}, expected a number as in its other rows"))
                .at(row.line.cell_place(index))
                .help("a missing value is never filled in: measure it, or leave the whole column empty for this axis"),
        );
    }
    rows.iter()
        .map(|row| row.numbers[index].map(|number| number * factor))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use super::*;

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
