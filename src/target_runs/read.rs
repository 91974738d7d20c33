//! A file of runs, in one of two layouts, to [`Runs`]. Nothing is guessed: not the unit, not
//! whether a value is a position or a deviation, not a reading that is missing.

use crate::axis::Direction;
use crate::document::Source;
use crate::problem::{Problem, Problems, shown};
use crate::target_runs::header::{Content, FIRST_LINE, Form, Layout, and_more};
use crate::target_runs::rows::{Row, rows_of};
use crate::target_runs::{LengthUnit, Runs, Stated, Values};
use crate::units::UM_PER_MM;
use std::collections::{BTreeMap, BTreeSet};

/// No position or deviation of a machine comes near, whatever its unit.
const LARGEST_NUMBER: f64 = 1e9;

pub(super) fn runs(source: &Source, stated: Stated) -> Result<Runs, Problems> {
    let rows = rows_of(source);
    let Some((header, rows)) = rows.split_first() else {
        return Err(Problem::new(format!(
            "`{}` holds no table, expected a header and the runs of an axis",
            source.name
        ))
        .help(FIRST_LINE)
        .into());
    };
    let layout = Layout::read(header, stated)?;
    if rows.is_empty() {
        return Err(
            Problem::new("the table has a header but no rows, expected readings")
                .at(header.whole())
                .help("write one row for each target, or one for each reading")
                .into(),
        );
    }
    let readings = read_rows(&layout, rows)?;
    complete(&layout, header, &readings)
}

// ---------------------------------------------------------------------------------------------
// Rows

/// One value of a run, with the cell it stands in.
struct Reading<'a> {
    row: Row<'a>,
    cell: usize,
    target_mm: f64,
    direction: Direction,
    run: u32,
    deviation_um: f64,
}

fn read_rows<'a>(layout: &Layout, rows: &[Row<'a>]) -> Result<Vec<Reading<'a>>, Problems> {
    let mut problems = Problems::none();
    let mut readings = Vec::new();
    for row in rows {
        let cells = row.cells();
        if cells.len() == layout.columns.len() {
            read_row(layout, *row, &cells, &mut readings, &mut problems);
        } else {
            problems.push_with(|| wrong_length(row, cells.len(), layout.columns.len()));
        }
    }
    problems.or_ok(readings)
}

fn wrong_length(row: &Row<'_>, found: usize, expected: usize) -> Problem {
    let help = if found > expected {
        "remove what is too much; a decimal comma needs semicolons between the columns"
    } else {
        "every target needs a value of every run; a run with gaps has to be left out as a whole"
    };
    Problem::new(format!(
        "the row has {found} cells, expected {expected} as in the header"
    ))
    .at(row.whole())
    .help(help)
}

fn read_row<'a>(
    layout: &Layout,
    row: Row<'a>,
    cells: &[&str],
    readings: &mut Vec<Reading<'a>>,
    problems: &mut Problems,
) {
    let target = read_length(layout, &row, cells, layout.target, problems);
    let mut add = |cell: usize, direction, run, length: Option<Length>| {
        if let (Some(target), Some(direction), Some(run), Some(length)) =
            (target, direction, run, length)
        {
            readings.push(Reading {
                row,
                cell,
                target_mm: target.um() / UM_PER_MM,
                direction,
                run,
                deviation_um: deviation_um(layout.values, length, target),
            });
        }
    };
    match layout.form {
        Form::RowForReading {
            run,
            direction,
            reading,
        } => {
            let number = read_run(&row, run, cells[run], problems);
            let travel = read_direction(&row, direction, cells[direction], problems);
            let length = read_length(layout, &row, cells, reading, problems);
            add(reading, travel, number, length);
        }
        Form::RowForTarget => {
            for (cell, column) in layout.columns.iter().enumerate() {
                if let Content::RunOf(direction, run) = column.content {
                    let length = read_length(layout, &row, cells, cell, problems);
                    add(cell, Some(direction), Some(run), length);
                }
            }
        }
    }
}

/// A length in the unit of its column.
#[derive(Clone, Copy)]
struct Length {
    number: f64,
    unit: LengthUnit,
}

impl Length {
    fn um(self) -> f64 {
        self.number * self.unit.um()
    }
}

/// x_ij = P_ij − P_i. In one unit the subtraction comes first: it is exact for numbers that are
/// near to each other.
fn deviation_um(values: Values, reading: Length, target: Length) -> f64 {
    match values {
        Values::Deviations => reading.um(),
        Values::Positions if reading.unit == target.unit => {
            (reading.number - target.number) * target.unit.um()
        }
        Values::Positions => reading.um() - target.um(),
    }
}

fn read_length(
    layout: &Layout,
    row: &Row<'_>,
    cells: &[&str],
    index: usize,
    problems: &mut Problems,
) -> Option<Length> {
    let (column, cell) = (&layout.columns[index], cells[index]);
    let mut refuse = |message: String, help: &str| {
        problems.push_with(|| Problem::new(message).at(row.cell(index)).help(help));
    };
    if cell.is_empty() {
        refuse(
            format!("`{}` is empty, expected a number", column.name),
            "a missing reading is not filled in; leave out its run or its target as a whole",
        );
        return None;
    }
    let text = if layout.decimal_comma {
        cell.replace(',', ".")
    } else {
        cell.to_string()
    };
    let plain = text
        .chars()
        .all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
    match text.parse::<f64>().ok().filter(|_| plain) {
        Some(number) if number.abs() <= LARGEST_NUMBER => Some(Length {
            number,
            unit: column.unit?,
        }),
        Some(_) => {
            refuse(
                format!(
                    "`{}` is `{}`, which is too large for any machine",
                    column.name,
                    shown(cell)
                ),
                "check the cell",
            );
            None
        }
        None => {
            refuse(
                format!(
                    "`{}` is `{}`, expected a finite number",
                    column.name,
                    shown(cell)
                ),
                "write a plain number; its unit stands in the header",
            );
            None
        }
    }
}

fn read_run(row: &Row<'_>, index: usize, cell: &str, problems: &mut Problems) -> Option<u32> {
    let number = cell.parse().ok().filter(|run| *run > 0);
    if number.is_none() {
        problems.push_with(|| {
            Problem::new(format!(
                "the run is `{}`, expected a whole number from 1",
                shown(cell)
            ))
            .at(row.cell(index))
            .help("number the runs 1, 2, 3 …")
        });
    }
    number
}

fn read_direction(
    row: &Row<'_>,
    index: usize,
    cell: &str,
    problems: &mut Problems,
) -> Option<Direction> {
    let direction = match cell {
        "up" => Some(Direction::Plus),
        "dn" | "down" => Some(Direction::Minus),
        symbol => Direction::from_symbol(symbol),
    };
    if direction.is_none() {
        problems.push_with(|| {
            Problem::new(format!(
                "unknown direction `{}`, expected `+` (up) or `-` (down)",
                shown(cell)
            ))
            .at(row.cell(index))
            .help("`+` = the axis came from smaller coordinates")
        });
    }
    direction
}

// ---------------------------------------------------------------------------------------------
// All readings together

/// Readings of one target: direction and run to the reading.
type OfTarget<'r, 'a> = BTreeMap<(Direction, u32), &'r Reading<'a>>;

/// Runs from readings that are complete, each once.
fn complete(layout: &Layout, header: &Row<'_>, readings: &[Reading<'_>]) -> Result<Runs, Problems> {
    let mut problems = Problems::none();
    let targets = by_target(layout, readings, &mut problems);
    if targets.len() < 2 {
        problems.push(
            Problem::new("there is one target only, expected at least two")
                .at(header.whole())
                .help("a positioning test has five or more targets"),
        );
    }
    let runs: BTreeSet<(Direction, u32)> = readings.iter().map(|r| (r.direction, r.run)).collect();
    for (_, of_target) in &targets {
        refuse_gaps(layout, of_target, &runs, &mut problems);
    }
    // Without its neighbours a reading cannot be told to be far.
    if problems.is_empty() {
        refuse_far_readings(layout, &targets, &mut problems);
    }
    problems.or_ok(())?;
    let of = |direction: Direction| {
        let measured = runs.iter().any(|(of, _)| *of == direction);
        measured.then(|| {
            let deviations = |of_target: &OfTarget<'_, '_>| {
                let of_direction = of_target.iter().filter(|((of, _), _)| *of == direction);
                of_direction
                    .map(|(_, reading)| reading.deviation_um)
                    .collect()
            };
            targets
                .iter()
                .map(|(_, of_target)| deviations(of_target))
                .collect()
        })
    };
    let targets_mm = targets.iter().map(|(mm, _)| *mm).collect();
    Ok(Runs::new(
        targets_mm,
        of(Direction::Plus),
        of(Direction::Minus),
    )?)
}

/// Targets in ascending order with their readings; a reading that comes twice is refused.
fn by_target<'r, 'a>(
    layout: &Layout,
    readings: &'r [Reading<'a>],
    problems: &mut Problems,
) -> Vec<(f64, OfTarget<'r, 'a>)> {
    let mut sorted: Vec<&Reading<'_>> = readings.iter().collect();
    sorted.sort_by(|a, b| a.target_mm.total_cmp(&b.target_mm));
    let mut targets: Vec<(f64, OfTarget<'_, '_>)> = Vec::new();
    for reading in sorted {
        let new = targets.last().is_none_or(|(mm, _)| *mm < reading.target_mm);
        if new {
            targets.push((reading.target_mm, BTreeMap::new()));
        }
        let Some((_, of_target)) = targets.last_mut() else {
            continue;
        };
        let key = (reading.direction, reading.run);
        match of_target.get(&key) {
            None => {
                of_target.insert(key, reading);
            }
            Some(first) => problems.push_with(|| twice(layout, first, reading)),
        }
    }
    targets
}

fn twice(layout: &Layout, first: &Reading<'_>, second: &Reading<'_>) -> Problem {
    let what = match layout.form {
        Form::RowForTarget => format!("target {} mm", second.target_mm),
        Form::RowForReading { .. } => format!(
            "target {} mm, run {} moving {}",
            second.target_mm, second.run, second.direction
        ),
    };
    Problem::new(format!(
        "{what} stands here again, the first time in line {}",
        first.row.number()
    ))
    .at(second.row.cell(layout.target))
    .help("keep one of the two rows")
}

/// Every target needs every run that another target has.
fn refuse_gaps(
    layout: &Layout,
    of_target: &OfTarget<'_, '_>,
    runs: &BTreeSet<(Direction, u32)>,
    problems: &mut Problems,
) {
    let Some(first) = of_target.values().next() else {
        return;
    };
    for (direction, run) in runs.iter().filter(|key| !of_target.contains_key(key)) {
        problems.push_with(|| {
            Problem::new(format!(
                "target {} mm has no reading of run {run} moving {direction}, which other targets \
                 have",
                first.target_mm
            ))
            .at(first.row.cell(layout.target))
            .help(
                "a missing reading is not filled in; write a target the same way in every row, or \
                 leave out the run or the target as a whole",
            )
        });
    }
}

/// An axis stands nearer to its own target than to the next one. Where it does not, positions
/// were taken for deviations or the other way round, or a row is wrong.
fn refuse_far_readings(
    layout: &Layout,
    targets: &[(f64, OfTarget<'_, '_>)],
    problems: &mut Problems,
) {
    let mut far = Vec::new();
    for (index, (mm, of_target)) in targets.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|before| targets.get(before));
        let neighbours = [before, targets.get(index + 1)];
        let distance = neighbours
            .into_iter()
            .flatten()
            .map(|(other, _)| (other - mm).abs());
        let half_mm = distance.fold(f64::INFINITY, f64::min) / 2.0;
        let readings = of_target.values();
        far.extend(
            readings
                .filter(|r| r.deviation_um.abs() >= half_mm * UM_PER_MM)
                .map(|reading| (half_mm, *reading)),
        );
    }
    let Some((half_mm, reading)) = far.iter().min_by_key(|(_, r)| (r.row.number(), r.cell)) else {
        return;
    };
    let help = match (layout.form, layout.values) {
        (Form::RowForTarget, Values::Positions) => {
            "the values are read as positions; if they are deviations add `--values deviations`"
        }
        (Form::RowForTarget, Values::Deviations) => {
            "the values are read as deviations; if they are positions add `--values positions`"
        }
        _ => {
            "check the row and the units; `position_mm` is where the axis stood, `deviation_um` its distance from the target"
        }
    };
    problems.push(
        Problem::new(format!(
            "the reading is {:.4} mm from its target at {} mm, expected less than half the way to \
             the next target, {:.4} mm{}",
            reading.deviation_um / UM_PER_MM,
            reading.target_mm,
            half_mm,
            and_more(far.len() - 1, " reading is as far", " readings are as far"),
        ))
        .at(reading.row.cell(reading.cell))
        .help(help),
    );
}
