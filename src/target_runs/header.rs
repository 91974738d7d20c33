//! The header of a file of runs: which columns, in which layout, unit and sense.

use crate::axis::Direction;
use crate::problem::{Problem, Problems, nearest, shown};
use crate::target_runs::rows::Row;
use crate::target_runs::{LengthUnit, Stated, Values};

pub(super) const FIRST_LINE: &str = "first line: target_mm,up1_mm,up2_mm,dn1_mm,dn2_mm \
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

#[derive(Debug)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) content: Content,
    /// `None` only where the content is no length.
    pub(super) unit: Option<LengthUnit>,
}

pub(super) struct Layout {
    pub(super) columns: Vec<Column>,
    pub(super) target: usize,
    pub(super) form: Form,
    pub(super) values: Values,
    pub(super) decimal_comma: bool,
}

#[derive(Clone, Copy)]
pub(super) enum Form {
    RowForTarget,
    RowForReading {
        run: usize,
        direction: usize,
        reading: usize,
    },
}

impl Layout {
    /// The layout of a header, with what was stated beside it.
    pub(super) fn read(header: &Row<'_>, stated: Stated) -> Result<Layout, Problems> {
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

/// What is counted beside the one that is shown.
pub(super) fn and_more(more: usize, one: &str, many: &str) -> String {
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
