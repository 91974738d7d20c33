//! The header of a file of runs: which columns, in which layout, unit and sense.

use crate::inputs::refusals::{self, RUNS};
use crate::inputs::table::Table;
use crate::inputs::target_runs::{Stated, Values};
use crate::quantity::axis::Direction;
use crate::text::delimited::{Expected, LengthUnit, Line};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeSet;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
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

#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) content: Content,
    /// `None` only where the content is no length.
    pub(super) unit: Option<LengthUnit>,
}

impl Column {
    fn is_length(&self) -> bool {
        !matches!(self.content, Content::Index | Content::Run | Content::Direction)
    }

    fn is_reading(&self) -> bool {
        matches!(self.content, Content::Reading(_))
    }

    pub(super) fn is_run(&self) -> bool {
        matches!(self.content, Content::RunOf(..))
    }
}

pub(super) struct Layout<'a> {
    pub(super) table: Table<'a, Column>,
    pub(super) target: usize,
    pub(super) form: Form,
    /// What the runs hold; `None` where neither a name nor a statement says it.
    pub(super) values: Option<Values>,
}

#[derive(Clone, Copy)]
pub(super) enum Form {
    RowForTarget,
    RowForReading { run: usize, direction: usize, reading: usize },
}

impl<'a> Layout<'a> {
    /// The layout of a file, with what was stated beside it.
    pub(super) fn read(source: &'a Source, stated: Stated) -> Result<Layout<'a>, Problems> {
        let what = "table, expected a header and the runs of an axis";
        let table = Table::read(source, what, RUNS, |header| {
            refuse_other_tables(header)?;
            let same =
                |a: &Column, b: &Column| a.content == b.content || a.is_reading() && b.is_reading();
            Ok(Expected { known: known_columns(header), same, first_line: RUNS, columns: RUNS })
        })?;
        let mut layout = form(table)?;
        layout.take_unit(stated.unit)?;
        layout.take_values(stated.values)?;
        Ok(layout)
    }

    /// A problem of a column.
    pub(super) fn at(&self, index: usize, problem: Problem) -> Problem {
        problem.at(self.table.header.cell_place(index))
    }

    /// The columns of lengths whose unit is such.
    fn lengths(&self, is_such: impl Fn(Option<LengthUnit>) -> bool) -> Vec<usize> {
        let columns = self.table.kinds.iter().enumerate();
        let such = columns.filter(|(_, column)| column.is_length() && is_such(column.unit));
        such.map(|(index, _)| index).collect()
    }

    /// The unit that was stated goes to the columns whose names have none.
    fn take_unit(&mut self, stated: Option<LengthUnit>) -> Result<(), Problem> {
        let without = self.lengths(|unit| unit.is_none());
        match (without.first(), stated) {
            (None, Some(unit)) => {
                Err(refusals::unit_twice(unit.word()).at(self.table.header.whole()))
            }
            (Some(first), None) => {
                let more = and_more(without.len() - 1, " has none", " have none");
                Err(self.at(*first, refusals::no_unit(&self.table.names[*first], more)))
            }
            (_, _) => {
                without.iter().for_each(|index| self.table.kinds[*index].unit = stated);
                Ok(())
            }
        }
    }

    /// Positions or deviations: a name decides, else what was stated. Columns of runs that have
    /// the unit of the target are left open: the values themselves may show it.
    fn take_values(&mut self, stated: Option<Values>) -> Result<(), Problem> {
        let names = &self.table.names;
        if let (Form::RowForReading { reading, .. }, Some(named)) = (self.form, self.values) {
            return stated.filter(|other| *other != named).map_or(Ok(()), |other| {
                let problem = refusals::other_values(other.word(), &names[reading], named.word());
                Err(self.at(reading, problem))
            });
        }
        let unit = self.table.kinds[self.target].unit;
        let others = self.lengths(|other| other != unit);
        if let (Some(other), None) = (others.first(), stated) {
            let problem = refusals::two_units(&names[*other], &names[self.target]);
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

/// The columns that may stand in a header: those of runs for every number that it holds.
fn known_columns(header: &Line<'_>) -> Vec<(String, Column)> {
    let mut lengths = vec![
        ("target".to_string(), Content::Target),
        ("deviation".to_string(), Content::Reading(Values::Deviations)),
        ("position".to_string(), Content::Reading(Values::Positions)),
    ];
    let ways = [("up", Direction::Plus), ("dn", Direction::Minus), ("down", Direction::Minus)];
    for run in run_numbers(header) {
        lengths.extend(ways.map(|(word, way)| (format!("{word}{run}"), Content::RunOf(way, run))));
    }
    let units = LengthUnit::ALL.map(|unit| (format!("_{}", unit.word()), Some(unit)));
    let with_units = units.into_iter().chain([(String::new(), None)]).flat_map(|(end, unit)| {
        let column = |(name, content): &(String, Content)| {
            (format!("{name}{end}"), Column { content: *content, unit })
        };
        lengths.iter().map(column).collect::<Vec<_>>()
    });
    let others = [("i", Content::Index), ("run", Content::Run), ("direction", Content::Direction)];
    let others = others.map(|(name, content)| (name.to_string(), Column { content, unit: None }));
    with_units.chain(others).collect()
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

/// Which of the two layouts the columns make.
fn form(table: Table<'_, Column>) -> Result<Layout<'_>, Problems> {
    let mut problems = Problems::none();
    let find = |content| table.find(|column| column.content == content);
    let mut require = |found, what, example| table.require(found, what, example, &mut problems);
    let examples = "`target_mm`, `target_in` or `target_um`";
    let target = require(find(Content::Target), "the targets", examples);
    let for_target = table.find(|column| column.is_run());
    let (run, direction) = (find(Content::Run), find(Content::Direction));
    let reading = table.find(|column| column.is_reading());
    let (mut form, mut values) = (Form::RowForTarget, None);
    match (for_target, run.or(direction).or(reading)) {
        (Some(_), Some(other)) => {
            let problem = refusals::other_layout(&table.names[other]);
            return Err(problem.at(table.header.cell_place(other)).into());
        }
        (None, Some(_)) => {
            form = Form::RowForReading {
                run: require(run, "the number of the run", "`run`"),
                direction: require(direction, "the direction of approach", "`direction`"),
                reading: require(reading, "the reading", "`deviation_um` or `position_mm`"),
            };
            values = reading.and_then(|reading| match table.kinds[reading].content {
                Content::Reading(values) => Some(values),
                _ => None,
            });
        }
        (found, None) => _ = require(found, "any run", "`up1_mm`, `dn1_mm` …"),
    }
    problems.or_ok(())?;
    Ok(Layout { table, target, form, values })
}
