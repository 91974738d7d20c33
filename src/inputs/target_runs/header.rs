//! The header of a file of runs: which columns, in which layout, unit and sense.

use crate::inputs::refusals::{self, RUNS};
use crate::inputs::table::{Column, Content, LENGTHS, Reading, Table, Unit, named};
use crate::inputs::target_runs::{Stated, Values};
use crate::quantity::Direction;
use crate::text::{LengthUnit, Line, Notes, Problem, Problems, Source};
use std::collections::BTreeSet;

pub(super) struct Layout<'a> {
    pub(super) table: Table<'a>,
    /// Which column holds the targets.
    pub(super) target: usize,
    /// Which column holds the readings, in the layout of one row for each of them.
    pub(super) reading: Option<usize>,
    /// What the runs hold; `None` where neither a name nor a statement says it.
    pub(super) values: Option<Values>,
}

impl<'a> Layout<'a> {
    /// The layout of a file, with what was stated beside it.
    pub(super) fn read(
        source: &'a Source,
        notes: &'a Notes,
        stated: Stated,
    ) -> Result<Layout<'a>, Problems> {
        let what = "table, expected a header and the runs of an axis";
        let table = Table::read(source, notes, [what, RUNS, RUNS], |header| {
            refuse_other_tables(header)?;
            Ok(known_columns(header))
        })?;
        let mut layout = Layout::of(table)?;
        layout.take_unit(stated.unit)?;
        layout.take_values(stated.values)?;
        Ok(layout)
    }

    /// Which of the two layouts the columns make.
    fn of(table: Table<'a>) -> Result<Layout<'a>, Problems> {
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
        let target = target.map_or(0, |column| column.index);
        let values = reading.and_then(|column| column.content.as_reading()?.values);
        let reading = reading.map(|column| column.index);
        table.notes.end(Layout { target, reading, values, table })
    }

    /// A problem of a column.
    pub(super) fn at(&self, index: usize, problem: Problem) -> Problem {
        self.table.at(&self.table.columns[index], problem)
    }

    /// The columns of lengths whose unit is such.
    fn lengths(&self, is_such: impl Fn(Option<Unit>) -> bool) -> Vec<usize> {
        let is_length = |own: Content| own == Content::Target || own.is_reading();
        let columns = self.table.columns.iter();
        let such = columns.filter(|column| is_length(column.content) && is_such(column.unit));
        such.map(|column| column.index).collect()
    }

    /// The unit that was stated goes to the columns whose names have none.
    fn take_unit(&mut self, stated: Option<LengthUnit>) -> Result<(), Problem> {
        let without = self.lengths(|unit| unit.is_none());
        match (without.first(), stated) {
            (None, Some(unit)) => {
                return Err(refusals::unit_twice(unit.word()).at(self.table.header.whole()));
            }
            (Some(first), None) => {
                let more = and_more(without.len() - 1, " has none", " have none");
                let name = &self.table.columns[*first].name;
                return Err(self.at(*first, refusals::no_unit(name, more)));
            }
            (_, _) => {}
        }
        without.iter().for_each(|at| self.table.columns[*at].unit = stated.map(Unit::of));
        Ok(())
    }

    /// Positions or deviations: a name decides, else what was stated. Columns of runs that have
    /// the unit of the target are left open: the values themselves may show it.
    fn take_values(&mut self, stated: Option<Values>) -> Result<(), Problem> {
        let columns = &self.table.columns;
        if let Some((reading, named)) = self.reading.zip(self.values) {
            return stated.filter(|other| *other != named).map_or(Ok(()), |other| {
                let name = &columns[reading].name;
                Err(self.at(reading, refusals::other_values(other.word(), name, named.word())))
            });
        }
        let target = &columns[self.target];
        let others = self.lengths(|other| other != target.unit);
        if let (Some(other), None) = (others.first(), stated) {
            let problem = refusals::two_units(&columns[*other].name, &target.name);
            return Err(self.at(*other, problem));
        }
        self.values = stated;
        Ok(())
    }
}

/// What is counted beside the one that is shown.
pub(super) fn and_more(more: usize, one: &str, many: &str) -> String {
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
            let reading = Reading { direction: Some(way), run: Some(run), values: None };
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
