//! Reading an error table: its header says what each column holds, its rows become the series of each axis and
//! direction.

use crate::inputs::error_table::component::{Component, Kind};
use crate::inputs::table::{Row, Table};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::units::{Deviation, MM_PER_INCH, Millimetres};
use crate::text::delimited::{Cell, Expected, LengthUnit, Line};
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quantity {
    Axis,
    Direction,
    Position,
    /// What was measured.
    Value(Kind),
    /// The standard uncertainty of what was measured.
    Uncertainty(Kind),
}

/// A column with what turns its unit into mm, µm or µrad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Column {
    pub(crate) holds: Quantity,
    pub(crate) factor: f64,
}

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

const FIRST_LINE: &str = "first line: axis,position_mm,ex_um,ey_um,ez_um";

/// Units of angles in the names of columns, and how many µrad they have.
const ANGLES_URAD: [(&str, f64); 3] =
    [("urad", 1.0), ("mrad", 1000.0), ("arcsec", std::f64::consts::PI / (180.0 * 3600.0) * 1e6)];

/// Every name that a column may have; of each quantity the first one is written, in mm, µm or µrad.
pub(crate) fn known_columns() -> Vec<(String, Column)> {
    let single = [
        ("axis", Quantity::Axis, 1.0),
        ("direction", Quantity::Direction, 1.0),
        ("position_mm", Quantity::Position, 1.0),
        ("position_in", Quantity::Position, MM_PER_INCH),
    ];
    let single = single.map(|(name, holds, factor)| (name.to_string(), Column { holds, factor }));
    let mut known = single.to_vec();
    let lengths = LengthUnit::ALL.map(|unit| (unit.word(), unit.um()));
    for (axis, letters) in Axis::ALL.into_iter().zip(["xa", "yb", "zc"]) {
        let (deviation, angle) = letters.split_at(1);
        let in_units = [
            (deviation, Kind::Deviation(axis), &lengths[..]),
            (angle, Kind::Angle(axis), &ANGLES_URAD),
        ];
        for (letter, kind, units) in in_units {
            for (u, holds) in [("", Quantity::Value(kind)), ("u_", Quantity::Uncertainty(kind))] {
                let column =
                    |&(unit, factor)| (format!("{u}e{letter}_{unit}"), Column { holds, factor });
                known.extend(units.iter().map(column));
            }
        }
    }
    known
}

/// A table whose header could be read.
pub(super) struct Columns<'a> {
    pub(super) table: Table<'a, Column>,
    position: usize,
}

impl<'a> Columns<'a> {
    pub(super) fn read(source: &'a Source) -> Result<Columns<'a>, Problems> {
        let what = "table, expected a header and measured positions";
        let table = Table::read(source, what, FIRST_LINE, |_| {
            Ok(Expected {
                known: known_columns(),
                same: |a: &Column, b: &Column| a.holds == b.holds,
                first_line: FIRST_LINE,
                columns: "columns: axis, direction, position_mm, ex_um, ey_um, ez_um, u_ex_um …",
            })
        })?;
        let mut problems = Problems::none();
        let mut require = |is_wanted: fn(Quantity) -> bool, what, example| {
            let found = table.find(|column| is_wanted(column.holds));
            table.require(found, what, example, &mut problems)
        };
        require(|holds| holds == Quantity::Axis, "the axis", "`axis`");
        let is_position = |holds| holds == Quantity::Position;
        let examples = "`position_mm` or `position_in`";
        let position = require(is_position, "the position", examples);
        let is_value = |holds| matches!(holds, Quantity::Value(_));
        require(is_value, "any deviation", "`ex_um`, `ey_um` or `ez_um`");
        problems.or_ok(Columns { table, position })
    }

    /// The headings of the deviations in X, Y and Z.
    pub(super) fn headings(&self) -> PerAxis<Option<Heading>> {
        let mut headings = PerAxis::default();
        for (index, column) in self.table.kinds.iter().enumerate() {
            if let Quantity::Value(Kind::Deviation(of)) = column.holds {
                headings[of] = Some(Heading {
                    name: self.table.names[index].clone(),
                    to_um: column.factor,
                    place: self.table.header.cell_place(index),
                });
            }
        }
        headings
    }

    /// A row whose cells can all be read.
    pub(super) fn record(&self, row: &mut Row<'_, 'a>) -> Option<Record<'a>> {
        let (mut axis, mut direction, mut complete) = (None, None, true);
        let mut numbers = Vec::with_capacity(self.table.kinds.len());
        for (index, column) in self.table.kinds.iter().enumerate() {
            let (cell, problems) = row.named(index);
            let mut number = None;
            match column.holds {
                Quantity::Axis => {
                    axis = cell.read(Axis::from_letter, "unknown axis", AXIS, problems);
                }
                _ if cell.text.is_empty() => {}
                Quantity::Direction => {
                    let read = Direction::from_symbol;
                    direction = cell.read(read, "unknown direction", DIRECTION, problems);
                    complete &= direction.is_some();
                }
                _ => {
                    number = read_number(&cell, column.holds, problems);
                    complete &= number.is_some();
                }
            }
            numbers.push(number);
        }
        if row.cell(self.position).is_empty() {
            let message = "the position is empty, expected a number".to_string();
            row.refuse(self.position, message, "every row needs its machine coordinate");
        }
        numbers[self.position].filter(|_| complete)?;
        Some(Record { line: row.line, axis: axis?, direction, numbers: numbers.into_boxed_slice() })
    }
}

// What is expected in a column, and the next step where it is something else.
const AXIS: (&str, &str) = ("`x`, `y` or `z`", "name the moving axis");
const DIRECTION: (&str, &str) =
    ("`+`, `-` or an empty cell", "`+` = the axis came from smaller coordinates");

fn read_number(cell: &Cell<'_, '_>, holds: Quantity, problems: &mut Problems) -> Option<f64> {
    const OF_AXIS: &str =
        "write a plain number; a column that was not measured stays empty for the whole axis";
    match holds {
        Quantity::Position => cell.number(
            "write the machine coordinate as a plain number; its unit stands in the header",
            problems,
        ),
        Quantity::Uncertainty(_) => cell.uncertainty(OF_AXIS, problems),
        _ => cell.number(OF_AXIS, problems),
    }
}

/// A row whose cells could all be read.
pub(super) struct Record<'a> {
    line: Line<'a>,
    axis: Axis,
    direction: Option<Direction>,
    /// One for each column, in its unit; `None` = empty, and for columns that hold no number.
    numbers: Box<[Option<f64>]>,
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
    /// Deviations in X, Y, Z, one for each position; `None` = not measured.
    pub deviations: PerAxis<Option<Vec<Deviation>>>,
    /// Standard uncertainties (k = 1) of the deviations, µm.
    pub uncertainties_um: PerAxis<Option<Vec<f64>>>,
    /// Rotations about X, Y, Z (`ea`, `eb`, `ec`), µrad, right-handed.
    pub angles_urad: PerAxis<Option<Vec<f64>>>,
    /// Standard uncertainties (k = 1) of the rotations, µrad.
    pub angle_uncertainties_urad: PerAxis<Option<Vec<f64>>>,
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
            deviations: PerAxis::default(),
            uncertainties_um: PerAxis::default(),
            angles_urad: PerAxis::default(),
            angle_uncertainties_urad: PerAxis::default(),
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
        let is_measured = |kind: &Kind| match *kind {
            Kind::Deviation(of) => self.deviations[of].is_some(),
            Kind::Angle(about) => self.angles_urad[about].is_some(),
        };
        let kinds = Kind::ALL.into_iter().filter(is_measured);
        kinds.map(|kind| Component { kind, along: self.axis })
    }

    /// Fills in a column of numbers, mm, µm or µrad; `None` = not measured.
    pub(crate) fn put(&mut self, holds: Quantity, values: Option<Vec<f64>>) {
        match holds {
            Quantity::Axis | Quantity::Direction => {}
            Quantity::Position => {
                let mm = values.unwrap_or_default().into_iter();
                self.positions = mm.map(Millimetres::new).collect();
            }
            Quantity::Value(Kind::Deviation(of)) => {
                let um = values.map(|um| um.into_iter().map(Deviation::from_um));
                self.deviations[of] = um.map(Iterator::collect);
            }
            Quantity::Value(Kind::Angle(about)) => self.angles_urad[about] = values,
            Quantity::Uncertainty(Kind::Deviation(of)) => self.uncertainties_um[of] = values,
            Quantity::Uncertainty(Kind::Angle(about)) => {
                self.angle_uncertainties_urad[about] = values;
            }
        }
    }

    /// The number in a row, mm, µm or µrad; `None` = not measured.
    pub(super) fn number(&self, holds: Quantity, row: usize) -> Option<f64> {
        let number = |column: &Option<Vec<f64>>| column.as_ref()?.get(row).copied();
        match holds {
            Quantity::Axis | Quantity::Direction => None,
            Quantity::Position => self.positions.get(row).map(|position| position.mm()),
            Quantity::Value(Kind::Deviation(of)) => {
                Some(self.deviations[of].as_ref()?.get(row)?.um())
            }
            Quantity::Value(Kind::Angle(about)) => number(&self.angles_urad[about]),
            Quantity::Uncertainty(Kind::Deviation(of)) => number(&self.uncertainties_um[of]),
            Quantity::Uncertainty(Kind::Angle(about)) => {
                number(&self.angle_uncertainties_urad[about])
            }
        }
    }
}

impl Columns<'_> {
    /// The series of an axis. That each has two positions is looked at where all rows of the file could be
    /// read.
    pub(super) fn series_of(
        &self,
        axis: Axis,
        records: &[Record<'_>],
        problems: &mut Problems,
    ) -> Vec<Series> {
        let of_axis = || records.iter().filter(|record| record.axis == axis);
        let signed = of_axis().any(|record| record.direction.is_some());
        let unsigned = of_axis().find(|record| record.direction.is_none());
        if let (true, Some(record)) = (signed, unsigned) {
            let message =
                format!("axis {axis} has rows with and without a direction, expected one kind");
            let help = "give every row of the axis `+` or `-`, or none";
            problems.push(Problem::new(message).at(record.line.whole()).help(help));
        }
        let directions = [None, Some(Direction::Plus), Some(Direction::Minus)];
        let rows = directions.map(|direction| {
            let rows = of_axis().filter(|record| record.direction == direction);
            rows.collect::<Vec<&Record<'_>>>()
        });
        let measured = rows.iter().filter(|rows| !rows.is_empty());
        measured.map(|rows| self.series(axis, rows, problems)).collect()
    }

    fn series(&self, axis: Axis, rows: &[&Record<'_>], problems: &mut Problems) -> Series {
        self.refuse_unordered(axis, rows, problems);
        let direction = rows.first().and_then(|row| row.direction);
        let mut series = Series::new(axis, direction, Vec::new());
        series.lines = rows.iter().map(|row| row.line.number()).collect();
        for (index, column) in self.table.kinds.iter().enumerate() {
            series.put(column.holds, self.values(axis, index, rows, problems));
        }
        series
    }

    fn refuse_unordered(&self, axis: Axis, rows: &[&Record<'_>], problems: &mut Problems) {
        let position = |row: &Record<'_>| row.numbers[self.position].unwrap_or_default();
        let unit = self.table.names[self.position].trim_start_matches("position_");
        for pair in rows.windows(2) {
            let (before, here) = (position(pair[0]), position(pair[1]));
            if here > before {
                continue;
            }
            let same = (here - before).abs() < f64::EPSILON * before.abs().max(1.0);
            let (what, help) = if same {
                let help = "average repeated runs, or give them directions `+` and `-`";
                ("is given twice".to_string(), help)
            } else {
                let what = format!("comes after {before} {unit}, expected ascending positions");
                (what, "sort the rows of each axis and direction by position")
            };
            let message = format!("position {here} {unit} of axis {axis} {what}");
            let place = pair[1].line.whole();
            problems.push_with(|| Problem::new(message).at(place).help(help));
        }
    }

    /// The values of a column for some rows: all of them, none of them (not measured), or a problem.
    fn values(
        &self,
        axis: Axis,
        index: usize,
        rows: &[&Record<'_>],
        problems: &mut Problems,
    ) -> Option<Vec<f64>> {
        let empty = || rows.iter().filter(|row| row.numbers[index].is_none());
        if empty().count() == rows.len() {
            return None;
        }
        for row in empty() {
            let name = &self.table.names[index];
            let message = format!(
                "`{name}` is empty in one row of axis {axis}, expected a number as in its other rows"
            );
            let help = "a missing value is never filled in: measure it, or leave the whole column empty for this axis";
            let place = row.line.cell_place(index);
            problems.push_with(|| Problem::new(message).at(place).help(help));
        }
        let factor = self.table.kinds[index].factor;
        let values = rows.iter().map(|row| Some(row.numbers[index]? * factor));
        values.collect()
    }
}

/// A curve needs two positions.
pub(super) fn refuse_single_positions(
    axis: Axis,
    records: &[Record<'_>],
    series: &[Series],
    problems: &mut Problems,
) {
    for series in series.iter().filter(|series| series.lines.len() == 1) {
        let is_its = |record: &&Record<'_>| series.lines == [record.line.number()];
        if let Some(record) = records.iter().find(is_its) {
            let message = format!("axis {axis} has a single position, expected at least two");
            let help = "one position makes no curve: give another one, or leave the axis out";
            problems.push(Problem::new(message).at(record.line.whole()).help(help));
        }
    }
}
