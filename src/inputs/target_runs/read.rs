//! Rows of a file of runs → [`Runs`]. Nothing is guessed: not a reading that is missing, and not whether
//! a value is a position or a deviation, unless the values leave no doubt.

use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, RUN, Row, Unit, count};
use crate::inputs::target_runs::header::{Layout, and_more};
use crate::inputs::target_runs::{Runs, Stated, Values, approach, small_um};
use crate::quantity::{Direction, Figure, UM_PER_MM};
use crate::text::{Line, Notes, Problem, Problems, Source};
use std::collections::{BTreeMap, BTreeSet};

/// One value of a run, with the cell it stands in.
struct Reading<'a> {
    line: Line<'a>,
    cell: usize,
    direction: Direction,
    run: u32,
    target: Length,
    value: Length,
}

/// A length in the unit of its column.
#[derive(Clone, Copy)]
struct Length {
    number: f64,
    unit: Unit,
}

impl Length {
    fn um(self) -> f64 {
        self.number * self.unit.factor
    }
}

impl Reading<'_> {
    fn target_mm(&self) -> f64 {
        self.target.um() / UM_PER_MM
    }

    /// x_ij = P_ij − P_i. In one unit the subtraction comes first: it is exact for numbers that
    /// are near to each other.
    fn deviation_um(&self, values: Values) -> f64 {
        let (value, target) = (self.value, self.target);
        match values {
            Values::Deviations => value.um(),
            Values::Positions if value.unit == target.unit => {
                (value.number - target.number) * target.unit.factor
            }
            Values::Positions => value.um() - target.um(),
        }
    }
}

/// Readings of one target: direction and run to the reading.
type OfTarget<'r, 'a> = BTreeMap<(Direction, u32), &'r Reading<'a>>;
/// Targets in mm, ascending, with their readings.
type Targets<'r, 'a> = Vec<(f64, OfTarget<'r, 'a>)>;

impl Runs {
    /// Reads a file of runs; all its problems are given at once.
    ///
    /// Two layouts: one row for each target (`target_mm,up1_mm,…,dn1_mm,…`), or one row for each
    /// reading (`target_mm,run,direction,deviation_um`). See docs/interface.md §2.4.
    pub fn read(source: &Source, stated: Stated) -> Result<Runs, Problems> {
        let notes = Notes::default();
        let layout = Layout::read(source, &notes, stated)?;
        let readings = readings(&layout);
        notes.end(())?;
        if readings.is_empty() {
            return Err(refusals::no_rows().at(layout.table.header.whole()).into());
        }
        let targets = by_target(&layout, &readings);
        if targets.len() < 2 {
            layout.table.refuse(refusals::one_target());
        }
        let runs: BTreeSet<(Direction, u32)> =
            readings.iter().map(|r| (r.direction, r.run)).collect();
        // Every target needs every run that another target has.
        for (_, of_target) in &targets {
            let Some(first) = of_target.values().next() else { continue };
            for (direction, run) in runs.iter().filter(|key| !of_target.contains_key(key)) {
                let problem = || refusals::no_reading(first.target_mm(), run, direction);
                notes.refuse_with(|| problem().at(first.line.cell_place(layout.target)));
            }
        }
        // Without its neighbours a reading cannot be determined to be far.
        notes.end(())?;
        let values = values_of(&layout, &targets)?;
        refuse_far_readings(&layout, values, &targets)?;
        let of = |direction: Direction| {
            let deviations = |(_, of_target): &(f64, OfTarget<'_, '_>)| {
                let of_direction = of_target.values().filter(|r| r.direction == direction);
                of_direction.map(|r| r.deviation_um(values)).collect()
            };
            let measured = runs.iter().any(|(of, _)| *of == direction);
            measured.then(|| targets.iter().map(deviations).collect())
        };
        let targets_mm = targets.iter().map(|(mm, _)| *mm).collect();
        Ok(Runs::new(targets_mm, of(Direction::Plus), of(Direction::Minus))?)
    }
}

/// Readings of a test: each takes some 700 bytes of memory until the figures are printed. A test of 100
/// targets with five runs each way has 1000.
const MOST_READINGS: usize = 50_000;

const DIRECTION: (&str, &str) =
    ("`+` (up) or `-` (down)", "`+` = the axis came from smaller coordinates");

fn readings<'a>(layout: &Layout<'a>) -> Vec<Reading<'a>> {
    let (mut all, columns) = (0, &layout.table.columns);
    let rows = layout.table.rows(|row| {
        let target = length(row, &columns[layout.target]);
        let cells = cells(layout, row);
        all += cells.len();
        if all > MOST_READINGS {
            let message =
                format!("here are more than {MOST_READINGS} readings, too many for a test");
            row.cell(&columns[0]).refuse(message, "check that the file is a test of one axis");
            return None;
        }
        let (line, target) = (row.line, target?);
        let reading =
            |(cell, direction, run, value)| Reading { line, cell, direction, run, target, value };
        Some(cells.into_iter().map(reading).collect::<Vec<_>>())
    });
    rows.into_iter().flatten().collect()
}

/// The readings of a row: cell, direction of approach, number of the run, value.
fn cells(layout: &Layout<'_>, row: &Row<'_, '_>) -> Vec<(usize, Direction, u32, Length)> {
    let columns = &layout.table.columns;
    if let Some(reading) = layout.reading {
        let run = row.parsed(Content::Run, None, count, RUN);
        let direction = row.parsed(Content::Direction, None, approach, DIRECTION);
        let value = length(row, &columns[reading]);
        let all = || Some((reading, direction?, run?, value?));
        return all().into_iter().collect();
    }
    let run = |column: &Column| {
        let reading = column.content.of_run()?;
        let (direction, run) = reading.direction.zip(reading.run)?;
        Some((column.index, direction, run, length(row, column)?))
    };
    columns.iter().filter_map(run).collect()
}

fn length(row: &Row<'_, '_>, column: &Column) -> Option<Length> {
    let help = "a missing reading is not filled in; leave out its run or its target as a whole";
    let number = row.cell(column).reading(help)?;
    Some(Length { number, unit: column.unit? })
}

/// Targets in ascending order with their readings; a reading that comes twice is refused.
fn by_target<'r, 'a>(layout: &Layout<'_>, readings: &'r [Reading<'a>]) -> Targets<'r, 'a> {
    let mut sorted: Vec<&Reading<'_>> = readings.iter().collect();
    sorted.sort_by(|a, b| a.target_mm().total_cmp(&b.target_mm()));
    let mut targets: Targets<'_, '_> = Vec::new();
    for reading in sorted {
        let target_mm = reading.target_mm();
        let key = (reading.direction, reading.run);
        match targets.last_mut() {
            Some((mm, of_target)) if *mm >= target_mm => match of_target.get(&key) {
                None => _ = of_target.insert(key, reading),
                Some(first) => layout.table.notes.refuse_with(|| twice(layout, first, reading)),
            },
            _ => targets.push((target_mm, BTreeMap::from([(key, reading)]))),
        }
    }
    targets
}

fn twice(layout: &Layout<'_>, first: &Reading<'_>, second: &Reading<'_>) -> Problem {
    let (mm, run, way) = (second.target_mm(), second.run, second.direction);
    let what = match layout.reading {
        None => format!("target {mm} mm"),
        Some(_) => format!("target {mm} mm, run {run} moving {way}"),
    };
    refusals::read_twice(what, first.line.number()).at(second.line.cell_place(layout.target))
}

/// Positions or deviations, as named or stated. Else the values are tried as both: they are
/// positions if their deviations are small beside the smallest distance of two targets; anything
/// else has to be stated.
fn values_of(layout: &Layout<'_>, targets: &Targets<'_, '_>) -> Result<Values, Problem> {
    if let Some(values) = layout.values {
        return Ok(values);
    }
    let small_um = small_um(targets.iter().map(|(mm, _)| *mm));
    let fits = |values: Values| {
        let mut readings = targets.iter().flat_map(|(_, of)| of.values());
        readings.all(|reading| reading.deviation_um(values).abs() <= small_um)
    };
    // Both cannot fit: no two targets are that near to zero.
    if fits(Values::Positions) {
        return Ok(Values::Positions);
    }
    let found = match fits(Values::Deviations) {
        true => "they look like deviations",
        false => "they are far from the targets as either",
    };
    let first = layout.table.find(|content| content.of_run().is_some());
    let first = first.unwrap_or(&layout.table.columns[layout.target]);
    let problem = refusals::unclear_values(&first.name, found, refusals::STATE_VALUES);
    Err(layout.table.at(first, problem))
}

/// No machine tool is off by a millimetre and more, unless something else is wrong.
const LARGEST_MM: f64 = 1.0;

/// An axis stands nearer to its own target than to the next one. Where it does not, and by more
/// than a machine can be off, positions were taken for deviations or the other way round, or a row
/// is wrong.
fn refuse_far_readings(
    layout: &Layout<'_>,
    values: Values,
    targets: &Targets<'_, '_>,
) -> Result<(), Problem> {
    let mut far = Vec::new();
    for (index, (mm, of_target)) in targets.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|before| targets.get(before));
        let neighbours = [before, targets.get(index + 1)].into_iter().flatten();
        let distances = neighbours.map(|(other, _)| (other - mm).abs());
        let half_mm = distances.fold(f64::INFINITY, f64::min) / 2.0;
        let limit_um = half_mm.max(LARGEST_MM) * UM_PER_MM;
        let is_far = |reading: &&&Reading<'_>| reading.deviation_um(values).abs() >= limit_um;
        let readings = of_target.values().filter(is_far);
        far.extend(readings.map(|reading| (limit_um / UM_PER_MM, *reading)));
    }
    let first = far.iter().min_by_key(|(_, r)| (r.line.number(), r.cell));
    let Some((limit_mm, reading)) = first else {
        return Ok(());
    };
    let help = match (layout.reading, values) {
        (None, Values::Positions) => {
            "the values are read as positions; if they are deviations add `--values deviations`"
        }
        (None, Values::Deviations) => {
            "the values are read as deviations; if they are positions add `--values positions`"
        }
        (Some(_), _) => {
            "check the row and the units; `position_mm` is where the axis stood, `deviation_um` its distance from the target"
        }
    };
    let off = Figure(reading.deviation_um(values) / UM_PER_MM);
    let more = and_more(far.len() - 1, " reading is as far", " readings are as far");
    Err(refusals::far(off, reading.target_mm(), limit_mm, LARGEST_MM, more, help)
        .at(reading.line.cell_place(reading.cell)))
}
