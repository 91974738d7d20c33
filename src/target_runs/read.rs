//! A file of runs, in one of two layouts, to [`Runs`]. Nothing is guessed: not the unit, not
//! whether a value is a position or a deviation, not a reading that is missing.

use crate::axis::Direction;
use crate::document::Source;
use crate::problem::{Problem, Problems, nearest, shown};
use crate::target_runs::rows::{Row, rows_of};
use crate::target_runs::{LengthUnit, Runs, Stated, Values};
use crate::units::UM_PER_MM;
use std::collections::{BTreeMap, BTreeSet};

/// No position or deviation of a machine comes near, whatever its unit.
const LARGEST_NUMBER: f64 = 1e9;

const FIRST_LINE: &str = "first line: target_mm,up1_mm,up2_mm,dn1_mm,dn2_mm \
                          or target_mm,run,direction,deviation_um";

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
// Header

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    /// Number of the target; not used.
    Index,
    Target,
    /// All readings of one run, in the layout of one row for each target.
    RunOf(Direction, u32),
    /// Number of the run, in the layout of one row for each reading.
    Run,
    Direction,
    Reading(Values),
}

#[derive(Debug)]
struct Column {
    name: String,
    content: Content,
    /// `None` only where the content is no length.
    unit: Option<LengthUnit>,
}

struct Layout {
    columns: Vec<Column>,
    target: usize,
    form: Form,
    values: Values,
    decimal_comma: bool,
}

#[derive(Clone, Copy)]
enum Form {
    RowForTarget,
    RowForReading {
        run: usize,
        direction: usize,
        reading: usize,
    },
}

impl Layout {
    fn read(header: &Row<'_>, stated: Stated) -> Result<Layout, Problems> {
        refuse_other_first_line(header)?;
        let mut problems = Problems::none();
        let mut columns: Vec<Column> = Vec::new();
        for (index, name) in header.cells().into_iter().enumerate() {
            let Some((content, unit)) = content_of(name) else {
                problems.push(unknown_column(header, index, name));
                continue;
            };
            if let Some(twin) = columns.iter().find(|c| same_content(c.content, content)) {
                problems.push(twin_column(header, index, name, &twin.name));
            }
            columns.push(Column {
                name: name.to_string(),
                content,
                unit,
            });
        }
        let mut layout = problems.or_ok(()).and_then(|()| form(header, columns))?;
        layout.decimal_comma = header.decimal_comma();
        layout.take_unit(header, stated.unit)?;
        layout.take_values(header, stated.values)?;
        Ok(layout)
    }

    fn lengths(&self) -> impl Iterator<Item = (usize, &Column)> {
        let columns = self.columns.iter().enumerate();
        columns.filter(|(_, column)| is_length(column.content))
    }

    /// The unit that was stated goes to the columns whose names have none.
    fn take_unit(&mut self, header: &Row<'_>, stated: Option<LengthUnit>) -> Result<(), Problem> {
        let without: Vec<usize> = self
            .lengths()
            .filter(|(_, column)| column.unit.is_none())
            .map(|(index, _)| index)
            .collect();
        match (without.first(), stated) {
            (None, None) => Ok(()),
            (None, Some(unit)) => Err(Problem::new(format!(
                "the unit {} was stated, but every column names its own",
                unit.ending()
            ))
            .at(header.whole())
            .help("leave out `--unit`")),
            (Some(first), None) => Err(Problem::new(format!(
                "column `{}` has no unit, expected `{0}_mm`, `{0}_in` or `{0}_um`{}",
                self.columns[*first].name,
                and_more(without.len() - 1, " column has none", " columns have none"),
            ))
            .at(header.cell(*first))
            .help("name the unit in the header, or state it for all of them: `--unit mm`, `--unit in` or `--unit um`")),
            (Some(_), Some(unit)) => {
                for index in without {
                    self.columns[index].unit = Some(unit);
                }
                Ok(())
            }
        }
    }

    /// Positions or deviations: a name decides, else what was stated, else positions where the
    /// values have the unit of the target.
    fn take_values(&mut self, header: &Row<'_>, stated: Option<Values>) -> Result<(), Problem> {
        if let Form::RowForReading { reading, .. } = self.form {
            return match stated {
                Some(other) if other != self.values => Err(Problem::new(format!(
                    "{} were stated, but column `{}` holds {}",
                    other.word(),
                    self.columns[reading].name,
                    self.values.word()
                ))
                .at(header.cell(reading))
                .help("leave out `--values`")),
                _ => Ok(()),
            };
        }
        let unit = self.columns[self.target].unit;
        let other = self.lengths().find(|(_, column)| column.unit != unit);
        match (stated, other) {
            (Some(values), _) => self.values = values,
            (None, None) => self.values = Values::Positions,
            (None, Some((index, column))) => {
                return Err(Problem::new(format!(
                    "column `{}` has another unit than `{}`, expected to be told whether it holds \
                     positions or deviations",
                    column.name, self.columns[self.target].name
                ))
                .at(header.cell(index))
                .help("add `--values deviations` or `--values positions`"));
            }
        }
        Ok(())
    }
}

fn and_more(more: usize, one: &str, many: &str) -> String {
    match more {
        0 => String::new(),
        1 => format!(" (1 more{one})"),
        more => format!(" ({more} more{many})"),
    }
}

fn is_length(content: Content) -> bool {
    matches!(
        content,
        Content::Target | Content::RunOf(..) | Content::Reading(_)
    )
}

fn same_content(a: Content, b: Content) -> bool {
    a == b || matches!((a, b), (Content::Reading(_), Content::Reading(_)))
}

/// The content and unit of a column's name.
fn content_of(name: &str) -> Option<(Content, Option<LengthUnit>)> {
    let named = LengthUnit::ALL.into_iter().find_map(|unit| {
        let quantity = name.strip_suffix(unit.ending())?.strip_suffix('_')?;
        Some((quantity, unit))
    });
    let (quantity, unit) = match named {
        Some((quantity, unit)) => (quantity, Some(unit)),
        None => (name, None),
    };
    let content = quantity_of(quantity)?;
    (unit.is_none() || is_length(content)).then_some((content, unit))
}

fn quantity_of(quantity: &str) -> Option<Content> {
    match quantity {
        "i" => return Some(Content::Index),
        "target" => return Some(Content::Target),
        "run" => return Some(Content::Run),
        "direction" => return Some(Content::Direction),
        "position" => return Some(Content::Reading(Values::Positions)),
        "deviation" => return Some(Content::Reading(Values::Deviations)),
        _ => {}
    }
    let word = quantity.trim_end_matches(|c: char| c.is_ascii_digit());
    let run = quantity[word.len()..].parse().ok()?;
    match word {
        "up" => Some(Content::RunOf(Direction::Plus, run)),
        "dn" | "down" => Some(Content::RunOf(Direction::Minus, run)),
        _ => None,
    }
}

fn refuse_other_first_line(header: &Row<'_>) -> Result<(), Problem> {
    let numbers = header
        .cells()
        .iter()
        .any(|cell| cell.parse::<f64>().is_ok());
    let message = if header.has_tabs() {
        "the columns are separated by tabs, expected commas or semicolons"
    } else if numbers {
        "the first line holds numbers, expected the names of the columns"
    } else {
        return Ok(());
    };
    Err(Problem::new(message).at(header.whole()).help(FIRST_LINE))
}

fn unknown_column(header: &Row<'_>, index: usize, name: &str) -> Problem {
    let stem = name.rsplit_once('_').map(|(stem, _)| stem);
    let known_stem = stem.and_then(quantity_of);
    let place = header.cell(index);
    match (known_stem, stem) {
        (Some(content), Some(stem)) if is_length(content) => Problem::new(format!(
            "column `{}` has an unknown unit, expected `{stem}_mm`, `{stem}_in` or `{stem}_um`",
            shown(name)
        ))
        .at(place)
        .help("the unit is part of the column's name"),
        _ => {
            let known = [
                "target_mm",
                "up1_mm",
                "dn1_mm",
                "run",
                "direction",
                "position_mm",
                "deviation_um",
            ];
            let help = nearest(name, known).map_or_else(
                || FIRST_LINE.to_string(),
                |near| format!("did you mean `{near}`?"),
            );
            Problem::new(format!("unknown column `{}`", shown(name)))
                .at(place)
                .help(help)
        }
    }
}

fn twin_column(header: &Row<'_>, index: usize, name: &str, twin: &str) -> Problem {
    Problem::new(format!(
        "column `{}` gives the same as column `{}` before it",
        shown(name),
        shown(twin)
    ))
    .at(header.cell(index))
    .help("keep one of the two")
}

/// Which of the two layouts the columns make.
fn form(header: &Row<'_>, columns: Vec<Column>) -> Result<Layout, Problems> {
    let at = |wanted: &dyn Fn(Content) -> bool| columns.iter().position(|c| wanted(c.content));
    let mut problems = Problems::none();
    let mut require = |found: Option<usize>, what: &str, example: &str| {
        if found.is_none() {
            problems.push(
                Problem::new(format!("there is no column for {what}, expected {example}"))
                    .at(header.whole())
                    .help(FIRST_LINE),
            );
        }
        found.unwrap_or_default()
    };
    let target = require(
        at(&|c| c == Content::Target),
        "the targets",
        "`target_mm`, `target_in` or `target_um`",
    );
    let for_target = at(&|c| matches!(c, Content::RunOf(..)));
    let run = at(&|c| c == Content::Run);
    let direction = at(&|c| c == Content::Direction);
    let reading = at(&|c| matches!(c, Content::Reading(_)));
    let for_reading = run.or(direction).or(reading);
    let (form, values) = match (for_target, for_reading) {
        (Some(_), Some(other)) => {
            return Err(Problem::new(format!(
                "column `{}` belongs to another layout than `up1`, `dn1` …",
                columns[other].name
            ))
            .at(header.cell(other))
            .help(FIRST_LINE)
            .into());
        }
        (None, Some(_)) => {
            let run = require(run, "the number of the run", "`run`");
            let direction = require(direction, "the direction of approach", "`direction`");
            let reading = require(reading, "the reading", "`deviation_um` or `position_mm`");
            let values = match columns.get(reading).map(|c| c.content) {
                Some(Content::Reading(values)) => values,
                _ => Values::Positions,
            };
            let form = Form::RowForReading {
                run,
                direction,
                reading,
            };
            (form, values)
        }
        (found, None) => {
            require(found, "any run", "`up1_mm`, `dn1_mm` …");
            (Form::RowForTarget, Values::Positions)
        }
    };
    problems.or_ok(()).map(|()| Layout {
        columns,
        target,
        form,
        values,
        decimal_comma: false,
    })
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
