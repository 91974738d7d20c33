//! A file of runs → [`Runs`]: its header says columns, layout, unit and sense. Nothing is guessed: not a reading that is
//! missing, and not whether a value is a position or a deviation, unless the values leave no doubt.

use crate::inputs::refusals::{self, RUNS, STATE_VALUES};
use crate::inputs::table::{
    self, Column, Content, LENGTHS, RUN, Table, TableRow, Unit, count, named,
};
use crate::inputs::target_runs::{RunFacts, Runs, Values, approach, small_um};
use crate::quantity::{Direction, Figure, UM_PER_MM};
use crate::text::{Line, Notes, Problem, Problems, Source};
use std::collections::{BTreeMap, BTreeSet};

/// A table, its columns with units.
struct Layout<'a> {
    table: Table<'a>,
    /// The column of the targets.
    target: Column,
    /// The column of the readings, in the layout of one row for each of them.
    reading: Option<Column>,
    /// What the runs hold; `None` where neither a name nor a statement says it.
    values: Option<Values>,
}

/// One value of a run, with the cell it stands in.
struct Reading<'a> {
    line: Line<'a>,
    cell: usize,
    direction: Direction,
    run: u32,
    target_mm: f64,
    /// x_ij = P_ij − P_i, as a position and as a deviation.
    um: [f64; 2],
}

/// Targets in mm, ascending, with their readings by direction and run.
type Targets<'r, 'a> = Vec<(f64, BTreeMap<(Direction, u32), &'r Reading<'a>>)>;

impl Runs {
    /// Reads a file of runs; all its problems are given at once.
    ///
    /// Two layouts: one row for each target (`target_mm,up1_mm,…,dn1_mm,…`), or one row for each
    /// reading (`target_mm,run,direction,deviation_um`). See docs/interface.md §2.4.
    pub fn read(source: &Source, stated: RunFacts) -> Result<Runs, Problems> {
        let notes = Notes::default();
        let layout = Layout::read(source, &notes, stated)?;
        let readings = layout.readings();
        notes.end(())?;
        if readings.is_empty() {
            return Err(refusals::no_rows().at(layout.table.header.whole()).into());
        }
        let targets = layout.by_target(&readings);
        if targets.len() < 2 {
            layout.table.refuse(refusals::one_target());
        }
        let runs: BTreeSet<(Direction, u32)> =
            readings.iter().map(|r| (r.direction, r.run)).collect();
        // Every target needs every run that another target has.
        for (_, of_target) in &targets {
            let Some(first) = of_target.values().next() else { continue };
            for (direction, run) in runs.iter().filter(|key| !of_target.contains_key(key)) {
                let problem = || refusals::no_reading(first.target_mm, run, direction);
                let place = || first.line.cell_place(layout.target.index);
                notes.refuse_with(|| problem().at(place()));
            }
        }
        // Without its neighbours a reading cannot be determined to be far.
        notes.end(())?;
        let values = layout.values_of(&targets)?;
        layout.refuse_far_readings(values, &targets)?;
        let of = |direction: Direction| {
            let measured = runs.iter().any(|(of, _)| *of == direction);
            let of_targets = targets.iter().map(|(_, of_target)| {
                let own = of_target.values().filter(|r| r.direction == direction);
                own.map(|r| r.um[values as usize]).collect()
            });
            measured.then(|| of_targets.collect())
        };
        let targets_mm = targets.iter().map(|(mm, _)| *mm).collect();
        Ok(Runs::new(targets_mm, of(Direction::Plus), of(Direction::Minus))?)
    }
}

impl<'a> Layout<'a> {
    /// The layout of a file, with what was stated beside it.
    fn read(source: &'a Source, notes: &'a Notes, stated: RunFacts) -> Result<Self, Problems> {
        let what = "table, expected a header and the runs of an axis";
        let mut table = Table::read(source, notes, [what, RUNS, RUNS], |header| {
            refuse_other_tables(header)?;
            Ok(known_columns(header))
        })?;
        let [target, run, direction] =
            [Content::Target, Content::Run, Content::Direction].map(|own| table.column(own));
        let of_run = table.find(|content| content.of_run().is_some());
        let reading = table.find(|content| content.is_reading() && content.of_run().is_none());
        table.require(target, "the targets", "`target_mm`, `target_in` or `target_um`");
        match (of_run, run.or(direction).or(reading)) {
            (Some(_), Some(other)) => {
                return Err(table.at(other, refusals::other_layout(&other.name)).into());
            }
            (None, Some(_)) => {
                table.require(run, "the number of the run", "`run`");
                table.require(direction, "the direction of approach", "`direction`");
                table.require(reading, "the reading", "`deviation_um` or `position_mm`");
            }
            (found, None) => table.require(found, "any run", "`up1_mm`, `dn1_mm` …"),
        }
        let [target, reading] = [target, reading].map(|column| column.map(|column| column.index));
        notes.end(())?;
        take_unit(&mut table, stated.unit.map(Unit::of))?;
        let column = |index: usize| table.columns[index].clone();
        let (target, reading) = (column(target.unwrap_or_default()), reading.map(column));
        let values = values_by_name(&table, &target, reading.as_ref(), stated.values)?;
        Ok(Layout { table, target, reading, values })
    }

    fn readings(&self) -> Vec<Reading<'a>> {
        let mut all = 0;
        let rows = self.table.rows(|row| {
            let target = length(row, &self.target);
            let cells = self.cells(row);
            all += cells.len();
            if all > MOST_READINGS {
                let cell = row.cell(&self.table.columns[0]);
                cell.refuse(refusals::too_many_readings(MOST_READINGS));
                return None;
            }
            let (line, target) = (row.line, target?);
            let target_um = target * self.target.factor_um();
            let reading = |(column, direction, run, value): (&Column, Direction, u32, f64)| {
                let value_um = value * column.factor_um();
                // In one unit the subtraction comes first: it is exact for numbers that are near to each other.
                let off_um = match column.unit == self.target.unit {
                    true => (value - target) * column.factor_um(),
                    false => value_um - target_um,
                };
                let (um, target_mm) = ([off_um, value_um], target_um / UM_PER_MM);
                Reading { line, cell: column.index, direction, run, target_mm, um }
            };
            Some(cells.into_iter().map(reading).collect::<Vec<_>>())
        });
        rows.into_iter().flatten().collect()
    }

    /// The readings of a row: column, direction of approach, number of the run, value.
    fn cells(&self, row: &TableRow<'_, '_>) -> Vec<(&Column, Direction, u32, f64)> {
        if let Some(column) = &self.reading {
            let run = row.parsed(Content::Run, None, count, RUN);
            let direction = row.parsed(Content::Direction, None, approach, DIRECTION);
            let value = length(row, column);
            let all = || Some((column, direction?, run?, value?));
            return all().into_iter().collect();
        }
        let cells = self.table.columns.iter().filter_map(|column| {
            let reading = column.content.of_run()?;
            let (direction, run) = reading.direction.zip(reading.run)?;
            Some((column, direction, run, length(row, column)?))
        });
        cells.collect()
    }

    /// Targets in ascending order with their readings; a reading that comes twice is refused.
    fn by_target<'r>(&self, readings: &'r [Reading<'a>]) -> Targets<'r, 'a> {
        let mut sorted: Vec<&Reading<'_>> = readings.iter().collect();
        sorted.sort_by(|a, b| a.target_mm.total_cmp(&b.target_mm));
        let targets = sorted.chunk_by(|a, b| a.target_mm >= b.target_mm).map(|readings| {
            let mut of_target = BTreeMap::new();
            for reading in readings {
                let first = *of_target.entry((reading.direction, reading.run)).or_insert(*reading);
                if !std::ptr::eq(first, *reading) {
                    self.table.notes.refuse_with(|| self.twice(first, reading));
                }
            }
            (readings[0].target_mm, of_target)
        });
        targets.collect()
    }

    fn twice(&self, first: &Reading<'_>, second: &Reading<'_>) -> Problem {
        let Reading { target_mm: mm, run, direction: way, .. } = second;
        let what = match &self.reading {
            None => format!("target {mm} mm"),
            Some(_) => format!("target {mm} mm, run {run} moving {way}"),
        };
        let place = second.line.cell_place(self.target.index);
        refusals::read_twice(what, first.line.number()).at(place)
    }

    /// Positions or deviations, as named or stated. Else the values are tried as both: they are
    /// positions if their deviations are small beside the smallest distance of two targets; anything
    /// else has to be stated.
    fn values_of(&self, targets: &Targets<'_, '_>) -> Result<Values, Problem> {
        let small_um = small_um(targets.iter().map(|(mm, _)| *mm));
        let fits = |values: &Values| {
            let mut readings = targets.iter().flat_map(|(_, of)| of.values());
            readings.all(|reading| reading.um[*values as usize].abs() <= small_um)
        };
        // Both cannot fit: no two targets are that near to zero.
        if let Some(values) = self.values.or(Some(Values::Positions).filter(fits)) {
            return Ok(values);
        }
        let found = match fits(&Values::Deviations) {
            true => "they look like deviations",
            false => "they are far from the targets as either",
        };
        let first = self.table.find(|content| content.of_run().is_some()).unwrap_or(&self.target);
        Err(self.table.at(first, refusals::unclear_values(&first.name, found, STATE_VALUES)))
    }

    /// An axis stands nearer to its own target than to the next one. Where it does not, and by more
    /// than a machine can be off, positions were taken for deviations or the other way round, or a row
    /// is wrong.
    fn refuse_far_readings(
        &self,
        values: Values,
        targets: &Targets<'_, '_>,
    ) -> Result<(), Problem> {
        let off_um = |reading: &Reading<'_>| reading.um[values as usize];
        let mut far = Vec::new();
        for (index, (mm, of_target)) in targets.iter().enumerate() {
            let before = index.checked_sub(1).and_then(|before| targets.get(before));
            let neighbours = [before, targets.get(index + 1)].into_iter().flatten();
            let distances = neighbours.map(|(other, _)| (other - mm).abs());
            let half_mm = distances.fold(f64::INFINITY, f64::min) / 2.0;
            let limit_um = half_mm.max(LARGEST_MM) * UM_PER_MM;
            let readings = of_target.values().filter(|reading| off_um(reading).abs() >= limit_um);
            far.extend(readings.map(|reading| (limit_um / UM_PER_MM, *reading)));
        }
        let first = far.iter().min_by_key(|(_, r)| (r.line.number(), r.cell));
        let Some((limit_mm, reading)) = first else {
            return Ok(());
        };
        let help = match (&self.reading, values) {
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
        let off = Figure(off_um(reading) / UM_PER_MM);
        let more = and_more(far.len() - 1, " reading is as far", " readings are as far");
        let place = reading.line.cell_place(reading.cell);
        Err(refusals::far(off, reading.target_mm, limit_mm, LARGEST_MM, more, help).at(place))
    }
}

/// Readings of a test: each takes some 700 bytes of memory until the figures are printed. A test of 100
/// targets with five runs each way has 1000.
const MOST_READINGS: usize = 50_000;
/// No machine tool is off by a millimetre and more, unless something else is wrong.
const LARGEST_MM: f64 = 1.0;
const DIRECTION: (&str, &str) =
    ("`+` (up) or `-` (down)", "`+` = the axis came from smaller coordinates");

fn length(row: &TableRow<'_, '_>, column: &Column) -> Option<f64> {
    let help = "a missing reading is not filled in; leave out its run or its target as a whole";
    row.cell(column).reading(help)
}

/// Whether a column holds lengths.
fn is_length(column: &Column) -> bool {
    column.content == Content::Target || column.content.is_reading()
}

/// The unit that was stated goes to the columns whose names have none.
fn take_unit(table: &mut Table<'_>, stated: Option<Unit>) -> Result<(), Problem> {
    let is_without = |column: &Column| is_length(column) && column.unit.is_none();
    let mut without = table.columns.iter().filter(|column| is_without(column));
    match (without.next(), stated) {
        (None, Some(unit)) => {
            return Err(refusals::unit_twice(unit.word).at(table.header.whole()));
        }
        (Some(first), None) => {
            let more = and_more(without.count(), " has none", " have none");
            return Err(table.at(first, refusals::no_unit(&first.name, more)));
        }
        (_, _) => {}
    }
    table.columns.iter_mut().filter(|own| is_without(own)).for_each(|own| own.unit = stated);
    Ok(())
}

/// Positions or deviations: a name decides, else what was stated. Columns of runs that have
/// the unit of the target are left open: the values themselves may show it.
fn values_by_name(
    table: &Table<'_>,
    target: &Column,
    reading: Option<&Column>,
    stated: Option<Values>,
) -> Result<Option<Values>, Problem> {
    let named = reading.and_then(|column| Some((column, column.content.as_reading()?.values?)));
    if let Some((column, named)) = named {
        return stated.filter(|other| *other != named).map_or(Ok(Some(named)), |other| {
            Err(table.at(column, refusals::other_values(other.word(), &column.name, named.word())))
        });
    }
    let mut others = table.columns.iter().filter(|own| is_length(own) && own.unit != target.unit);
    match others.next().filter(|_| stated.is_none()) {
        Some(other) => Err(table.at(other, refusals::two_units(&other.name, &target.name))),
        None => Ok(stated),
    }
}

/// What is counted beside the one that is shown.
fn and_more(more: usize, one: &str, many: &str) -> String {
    match more {
        0 => String::new(),
        1 => format!(" (1 more{one})"),
        more => format!(" ({more} more{many})"),
    }
}

/// The columns that may stand in a header, a length with or without its unit: those of runs for every number that
/// it holds.
fn known_columns(header: &Line<'_>) -> Vec<Column> {
    let mut lengths = vec![
        ("target".to_string(), Content::Target),
        ("deviation".to_string(), Content::reading(Values::Deviations)),
        ("position".to_string(), Content::reading(Values::Positions)),
    ];
    let ways = [("up", Direction::Plus), ("dn", Direction::Minus), ("down", Direction::Minus)];
    for run in run_numbers(header) {
        lengths.extend(ways.map(|(word, way)| {
            let reading = table::Reading {
                direction: Some(way),
                run: Some(run),
                ..table::Reading::default()
            };
            (format!("{word}{run}"), Content::Reading(reading))
        }));
    }
    let mut known = named(&[
        ("i", Content::Index, &[]),
        ("run", Content::Run, &[]),
        ("direction", Content::Direction, &[]),
    ]);
    for (name, content) in lengths {
        known.extend(named(&[(&name, content, &LENGTHS), (&name, content, &[])]));
    }
    known
}

/// Numbers that stand behind the words of a header, as in `up3_mm`; 1 always.
fn run_numbers(header: &Line<'_>) -> BTreeSet<u32> {
    let number = |name: &str| {
        let number = name.trim_start_matches(|c: char| !c.is_ascii_digit());
        let number: String = number.chars().take_while(char::is_ascii_digit).collect();
        // `up01` is no name: the number has to read the same when it is written again.
        number.parse().ok().filter(|run: &u32| *run > 0 && run.to_string() == number)
    };
    header.cells().iter().filter_map(|name| number(name)).chain([1]).collect()
}

/// Tables that are something else, or that name their targets as an error table does.
fn refuse_other_tables(header: &Line<'_>) -> Result<(), Problem> {
    let cells = header.cells();
    let has = |starts: &[&str]| {
        let mut cells = cells.iter().map(|cell| cell.to_ascii_lowercase());
        cells.any(|cell| starts.iter().any(|start| cell.starts_with(start)))
    };
    if has(&["axis"]) && has(&["ex_", "ey_", "ez_"]) {
        Err(refusals::other_table().at(header.whole()))
    } else if has(&["pos", "nominal"]) && !has(&["target"]) {
        Err(refusals::targets_unnamed().at(header.whole()))
    } else {
        Ok(())
    }
}
