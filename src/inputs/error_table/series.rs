//! Records of an error table → the series of each axis and direction.

use crate::inputs::error_table::columns::{Column, Columns};
use crate::inputs::error_table::rows::Record;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::units::{Deviation, Millimetres};
use crate::text::problem::{Problem, Problems};

pub(super) fn series_of(
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
        lines: rows.iter().map(|row| row.line.number()).collect(),
        table: 0,
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

pub(super) fn refuse_single_positions(
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
            let place = records.iter().find(|record| record.line.number() == line);
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
    pub(super) lines: Vec<usize>,
    /// Which table it stands in: 0 = the first, n = the n-th of `ErrorTable::more`.
    pub(super) table: usize,
}
