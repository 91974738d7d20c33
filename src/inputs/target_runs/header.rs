//! The header of a file of runs: which columns, in which layout, unit and sense.

use crate::inputs::table::Table;
use crate::inputs::target_runs::{Stated, Values};
use crate::quantity::axis::Direction;
use crate::text::delimited::{Expected, LengthUnit, Line};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeSet;

const FIRST_LINE: &str = "first line: target_mm,up1_mm,up2_mm,dn1_mm,dn2_mm \
                          or target_mm,run,direction,deviation_um";

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

impl Content {
    fn is_length(self) -> bool {
        !matches!(self, Content::Index | Content::Run | Content::Direction)
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) content: Content,
    /// `None` only where the content is no length.
    pub(super) unit: Option<LengthUnit>,
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
        let table = Table::read(source, what, FIRST_LINE, |header| {
            refuse_other_tables(header)?;
            Ok(Expected {
                known: known_columns(header),
                same: |a: &Column, b: &Column| {
                    let is_reading = |c: &Column| matches!(c.content, Content::Reading(_));
                    a.content == b.content || is_reading(a) && is_reading(b)
                },
                first_line: FIRST_LINE,
                columns: FIRST_LINE,
            })
        })?;
        let mut layout = form(table)?;
        layout.take_unit(stated.unit)?;
        layout.take_values(stated.values)?;
        Ok(layout)
    }

    /// The columns of lengths whose unit is such.
    fn lengths(&self, is_such: impl Fn(Option<LengthUnit>) -> bool) -> Vec<usize> {
        let columns = self.table.kinds.iter().enumerate();
        let such = columns.filter(|(_, c)| c.content.is_length() && is_such(c.unit));
        such.map(|(index, _)| index).collect()
    }

    /// The unit that was stated goes to the columns whose names have none.
    fn take_unit(&mut self, stated: Option<LengthUnit>) -> Result<(), Problem> {
        let without = self.lengths(|unit| unit.is_none());
        let message = match (without.first(), stated) {
            (None, Some(unit)) => {
                let unit = unit.word();
                let message = format!("the unit {unit} was stated, but every column names its own");
                return Err(self.table.at_header(message, "leave out `--unit`"));
            }
            (Some(first), None) => format!(
                "column `{0}` has no unit, expected `{0}_mm`, `_um`, `_in` or `_uin`{1}",
                self.table.names[*first],
                and_more(without.len() - 1, " has none", " have none"),
            ),
            (_, _) => {
                for index in without {
                    self.table.kinds[index].unit = stated;
                }
                return Ok(());
            }
        };
        let help = "name the unit in the header, or state it for all of them: `--unit mm`, `in`, `um` or `uin`";
        Err(self.table.at_column(without[0], message, help))
    }

    /// Positions or deviations: a name decides, else what was stated. Columns of runs that have
    /// the unit of the target are left open: the values themselves may show it.
    fn take_values(&mut self, stated: Option<Values>) -> Result<(), Problem> {
        let names = &self.table.names;
        if let (Form::RowForReading { reading, .. }, Some(named)) = (self.form, self.values) {
            let Some(other) = stated.filter(|other| *other != named) else {
                return Ok(());
            };
            let (other, named) = (other.word(), named.word());
            let name = &names[reading];
            let message = format!("{other} were stated, but column `{name}` holds {named}");
            let help = "leave out `--values`";
            return Err(self.table.at_column(reading, message, help));
        }
        self.values = stated;
        let unit = self.table.kinds[self.target].unit;
        let others = self.lengths(|other| other != unit);
        let Some(other) = others.first().filter(|_| stated.is_none()) else {
            return Ok(());
        };
        let message = format!(
            "column `{}` has another unit than `{}`, expected to be told whether it holds \
             positions or deviations",
            names[*other], names[self.target]
        );
        Err(self.table.at_column(*other, message, STATE_VALUES))
    }
}

/// The next step where it is open what the runs hold.
pub(super) const STATE_VALUES: &str = "add `--values deviations` or `--values positions`";

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
    let mut quantities = vec![
        ("target".to_string(), Content::Target),
        ("deviation".to_string(), Content::Reading(Values::Deviations)),
        ("position".to_string(), Content::Reading(Values::Positions)),
    ];
    let words = [("up", Direction::Plus), ("dn", Direction::Minus), ("down", Direction::Minus)];
    for run in run_numbers(header) {
        let content = |direction| Content::RunOf(direction, run);
        quantities
            .extend(words.map(|(word, direction)| (format!("{word}{run}"), content(direction))));
    }
    let others = [("i", Content::Index), ("run", Content::Run), ("direction", Content::Direction)];
    let others = others.map(|(name, content)| (name.to_string(), content));
    let units = LengthUnit::ALL.map(Some).into_iter().chain([None]);
    let with_units = units.flat_map(|unit| {
        let ending = unit.map_or(String::new(), |unit| format!("_{}", unit.word()));
        let column = move |(name, content): &(String, Content)| {
            let content = *content;
            (format!("{name}{ending}"), Column { content, unit })
        };
        quantities.iter().map(column)
    });
    let unit = None;
    let others = others.map(|(name, content)| (name, Column { content, unit }));
    with_units.chain(others).collect()
}

/// Numbers that stand behind the words of a header, as in `up3_mm`; 1 always.
fn run_numbers(header: &Line<'_>) -> BTreeSet<u32> {
    let mut numbers = BTreeSet::from([1]);
    for name in header.cells() {
        let digits = |c: char| c.is_ascii_digit();
        let number = name.trim_start_matches(|c| !digits(c));
        let number: String = number.chars().take_while(|c| digits(*c)).collect();
        // `up01` is no name: the number has to read the same when it is written again.
        let run = number.parse().ok();
        numbers.extend(run.filter(|run: &u32| *run > 0 && run.to_string() == number));
    }
    numbers
}

/// Tables that are something else, or that name their targets as an error table does.
fn refuse_other_tables(header: &Line<'_>) -> Result<(), Problem> {
    let cells = header.cells();
    let has = |starts: &[&str]| {
        let mut cells = cells.iter().map(|cell| cell.to_ascii_lowercase());
        cells.any(|cell| starts.iter().any(|start| cell.starts_with(start)))
    };
    let message = if has(&["axis"]) && has(&["ex_", "ey_", "ez_"]) {
        "this is an error table, expected the raw runs of a positioning test: repeatability cannot be taken from means"
    } else if has(&["pos", "nominal"]) && !has(&["target"]) {
        TARGETS
    } else {
        return Ok(());
    };
    Err(Problem::new(message).at(header.whole()).help(FIRST_LINE))
}

const TARGETS: &str =
    "there is no column for the targets, expected `target_mm`, `target_in` or `target_um`";

/// Which of the two layouts the columns make.
fn form(table: Table<'_, Column>) -> Result<Layout<'_>, Problems> {
    let mut problems = Problems::none();
    let find = |content| table.find(|column| column.content == content);
    let mut require = |found, what, example| table.require(found, what, example, &mut problems);
    let examples = "`target_mm`, `target_in` or `target_um`";
    let target = require(find(Content::Target), "the targets", examples);
    let for_target = table.find(|column| matches!(column.content, Content::RunOf(..)));
    let (run, direction) = (find(Content::Run), find(Content::Direction));
    let reading = table.find(|column| matches!(column.content, Content::Reading(_)));
    let (form, values) = match (for_target, run.or(direction).or(reading)) {
        (Some(_), Some(other)) => {
            let name = &table.names[other];
            let message = format!("column `{name}` belongs to another layout than `up1`, `dn1` …");
            return Err(table.at_column(other, message, FIRST_LINE).into());
        }
        (None, Some(_)) => {
            let form = Form::RowForReading {
                run: require(run, "the number of the run", "`run`"),
                direction: require(direction, "the direction of approach", "`direction`"),
                reading: require(reading, "the reading", "`deviation_um` or `position_mm`"),
            };
            let values = reading.and_then(|reading| match table.kinds[reading].content {
                Content::Reading(values) => Some(values),
                _ => None,
            });
            (form, values)
        }
        (found, None) => {
            require(found, "any run", "`up1_mm`, `dn1_mm` …");
            (Form::RowForTarget, None)
        }
    };
    problems.or_ok(())?;
    Ok(Layout { table, target, form, values })
}
