//! Reading an error table: its header says what each column holds, its rows become the series of each axis and
//! direction.

use crate::inputs::kind::{Component, Kind};
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, INCH, LENGTHS, MM, Table, TableRow, Unit, named};
use crate::quantity::{Axis, Direction, Millimetres, PerAxis, URAD_PER_ARCSEC};
use crate::text::{Line, Notes, Place, Problems, Source};
use std::collections::BTreeMap;

/// The heading of a column of deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// As it is written, e.g. `ex_mm`.
    pub name: String,
    /// Micrometres in its unit.
    pub to_um: f64,
    /// Where it stands.
    pub place: Place,
}

impl Heading {
    /// The same heading for values in micrometres, e.g. `ex_um`.
    pub(crate) fn in_micrometres(&self) -> String {
        let quantity = self.name.rsplit_once('_').map(|(quantity, _)| quantity);
        format!("{}_um", quantity.unwrap_or(&self.name))
    }
}

const WORDS: [&str; 3] = [
    "table, expected a header and measured positions",
    "first line: axis,position_mm,ex_um,ey_um,ez_um",
    "columns: axis, direction, position_mm, ex_um, ey_um, ez_um, u_ex_um …",
];

/// Units of angles.
const ANGLES: [Unit; 3] = [
    Unit { word: "urad", factor: 1.0 },
    Unit { word: "mrad", factor: 1000.0 },
    Unit { word: "arcsec", factor: URAD_PER_ARCSEC },
];

/// Every column that there may be, in the order in which they are written; of each quantity the first one is
/// written, in mm, µm or µrad.
pub(crate) fn known_columns() -> Vec<Column> {
    let mut known = named(&[
        ("axis", Content::Axis, &[]),
        ("direction", Content::Direction, &[]),
        ("position", Content::Position, &[MM, INCH]),
    ]);
    let measured = Kind::ALL.map(|kind| ("", kind, Content::Value(kind)));
    let uncertain = Kind::ALL.map(|kind| ("u_", kind, Content::Uncertainty(kind)));
    for (begins, kind, content) in measured.into_iter().chain(uncertain) {
        let units = match kind {
            Kind::Deviation(_) => &LENGTHS[..],
            Kind::Angle(_) => &ANGLES[..],
        };
        known.extend(named(&[(&(begins.to_string() + &kind.word()), content, units)]));
    }
    known
}

/// The table of a file whose header can be read.
pub(super) fn table<'a>(source: &'a Source, notes: &'a Notes) -> Result<Table<'a>, Problems> {
    let table = Table::read(source, notes, WORDS, |_| Ok(known_columns()))?;
    table.require(table.column(Content::Axis), "the axis", "`axis`");
    let examples = "`position_mm` or `position_in`";
    table.require(table.column(Content::Position), "the position", examples);
    let value = table.find(|holds| matches!(holds, Content::Value(_)));
    table.require(value, "any deviation", "`ex_um`, `ey_um` or `ez_um`");
    notes.end(table)
}

/// The headings of the deviations in X, Y and Z.
pub(super) fn headings(table: &Table<'_>) -> PerAxis<Option<Heading>> {
    PerAxis::from_fn(|of| {
        let column = table.column(Content::Value(Kind::Deviation(of)))?;
        let (name, to_um) = (column.name.clone(), column.factor());
        Some(Heading { name, to_um, place: table.header.cell_place(column.index) })
    })
}

// What is expected in a column, and the next step where it is something else.
const AXIS: (&str, &str) = ("`x`, `y` or `z`", "name the moving axis");
const DIRECTION: (&str, &str) =
    ("`+`, `-` or an empty cell", "`+` = the axis came from smaller coordinates");
const NUMBER: &str =
    "write a plain number; a column that was not measured stays empty for the whole axis";
const COORDINATE: &str =
    "write the machine coordinate as a plain number; its unit stands in the header";

/// A row whose cells could all be read.
pub(super) struct Record<'a> {
    line: Line<'a>,
    axis: Axis,
    direction: Option<Direction>,
    /// In the unit of its column.
    position: f64,
    /// One for each column, in its unit; `None` = empty, and for columns that hold no number.
    numbers: Box<[Option<f64>]>,
}

/// A row whose cells can all be read.
pub(super) fn record<'a>(table: &Table<'a>, row: &TableRow<'_, 'a>) -> Option<Record<'a>> {
    let (mut axis, mut direction, mut complete) = (None, None, true);
    let mut numbers = vec![None; table.columns.len()].into_boxed_slice();
    for (column, own) in table.columns.iter().zip(&mut numbers) {
        let cell = row.cell(column);
        match column.content {
            Content::Axis => axis = cell.read(Axis::from_letter, "unknown axis", AXIS),
            _ if cell.text.is_empty() => {}
            Content::Direction => {
                direction = cell.read(Direction::from_symbol, "unknown direction", DIRECTION);
                complete &= direction.is_some();
            }
            holds => {
                *own = match holds {
                    Content::Position => cell.number(COORDINATE),
                    Content::Uncertainty(_) => cell.uncertainty(NUMBER),
                    _ => cell.number(NUMBER),
                };
                complete &= own.is_some();
            }
        }
    }
    let position = table.column(Content::Position)?;
    let cell = row.cell(position);
    if cell.text.is_empty() {
        cell.refuse(refusals::empty_position());
    }
    let position = numbers[position.index].filter(|_| complete)?;
    Some(Record { line: row.line, axis: axis?, direction, position, numbers })
}

/// All measured positions of one axis in one direction (or without regard to direction).
///
/// Whoever fills one keeps to the rules of the format: as many values as positions.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The moving axis.
    pub axis: Axis,
    /// Direction of travel; `None` = both.
    pub direction: Option<Direction>,
    /// Machine coordinates, strictly ascending.
    pub positions: Vec<Millimetres>,
    /// What was measured, one value for each position: deviations, µm, actual − commanded; rotations, µrad,
    /// right-handed.
    pub values: BTreeMap<Kind, Vec<f64>>,
    /// Standard uncertainties (k = 1) of the values.
    pub uncertainties: BTreeMap<Kind, Vec<f64>>,
    pub(super) lines: Vec<usize>,
    /// Which table it stands in: 0 = the first, n = the n-th of `ErrorTable::more`.
    pub(super) table: usize,
}

impl Series {
    /// A series at positions where nothing was measured yet.
    pub fn new(axis: Axis, direction: Option<Direction>, positions: Vec<Millimetres>) -> Series {
        Series {
            axis,
            direction,
            positions,
            values: BTreeMap::new(),
            uncertainties: BTreeMap::new(),
            lines: Vec::new(),
            table: 0,
        }
    }

    /// The first and the last position, mm.
    pub(crate) fn ends_mm(&self) -> [Option<f64>; 2] {
        [self.positions.first(), self.positions.last()].map(|end| end.map(|end| end.mm()))
    }

    /// What was measured, e.g. `EXX` and `EAX`.
    pub(crate) fn components(&self) -> impl Iterator<Item = Component> {
        self.values.keys().map(|kind| Component { kind: *kind, along: self.axis })
    }

    /// Fills in a column of numbers, mm, µm or µrad.
    pub(crate) fn put(&mut self, holds: Content, values: Vec<f64>) {
        match holds {
            Content::Position => {
                self.positions = values.into_iter().map(Millimetres::new).collect();
            }
            Content::Value(kind) => _ = self.values.insert(kind, values),
            Content::Uncertainty(kind) => _ = self.uncertainties.insert(kind, values),
            _ => {}
        }
    }

    /// The number in a row, mm, µm or µrad; `None` = not measured.
    pub(super) fn number(&self, holds: Content, row: usize) -> Option<f64> {
        let column = match holds {
            Content::Position => return self.positions.get(row).map(|position| position.mm()),
            Content::Value(kind) => self.values.get(&kind),
            Content::Uncertainty(kind) => self.uncertainties.get(&kind),
            _ => None,
        };
        column?.get(row).copied()
    }
}

/// The series of each axis. That each has two positions is looked at where all rows of the file could be
/// read.
pub(super) fn series_of(table: &Table<'_>, records: &[Record<'_>]) -> PerAxis<Vec<Series>> {
    let (mut groups, mut all) = (BTreeMap::new(), PerAxis::<Vec<Series>>::default());
    for record in records {
        groups.entry((record.axis, record.direction)).or_insert_with(Vec::new).push(record);
    }
    for ((axis, direction), rows) in &groups {
        let is_directed = groups.keys().any(|(other, way)| other == axis && way.is_some());
        if direction.is_none() && is_directed {
            table.notes.refuse(refusals::mixed_directions(axis).at(rows[0].line.whole()));
        }
        all[*axis].push(series(*axis, table, rows));
    }
    all
}

fn series(axis: Axis, table: &Table<'_>, rows: &[&Record<'_>]) -> Series {
    let position = table.column(Content::Position);
    let unit = position.and_then(|column| column.unit).map_or("", |unit| unit.word);
    for pair in rows.windows(2).filter(|pair| pair[1].position <= pair[0].position) {
        let [before, here] = [pair[0].position, pair[1].position];
        let is_same = (here - before).abs() < f64::EPSILON * before.abs().max(1.0);
        let problem = || match is_same {
            true => refusals::given_twice_along(here, unit, axis),
            false => refusals::unordered(here, unit, axis, before),
        };
        table.notes.refuse_with(|| problem().at(pair[1].line.whole()));
    }
    let mut series = Series::new(axis, rows[0].direction, Vec::new());
    series.lines = rows.iter().map(|row| row.line.number()).collect();
    for (index, column) in table.columns.iter().enumerate() {
        let empty = rows.iter().filter(|row| row.numbers[index].is_none());
        if empty.clone().count() == rows.len() {
            continue;
        }
        for row in empty {
            let problem = || refusals::empty_in_one_row(&column.name, axis);
            table.notes.refuse_with(|| problem().at(row.line.cell_place(index)));
        }
        let values = rows.iter().map(|row| Some(row.numbers[index]? * column.factor()));
        if let Some(values) = values.collect() {
            series.put(column.content, values);
        }
    }
    series
}

/// A curve needs two positions.
pub(super) fn refuse_single_positions(table: &Table<'_>, series: &PerAxis<Vec<Series>>) {
    for series in series.iter().flat_map(|(_, series)| series) {
        if let Some(line) = table.lines.iter().find(|line| series.lines == [line.number()]) {
            table.notes.refuse(refusals::single_position(series.axis).at(line.whole()));
        }
    }
}
