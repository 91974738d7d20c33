//! The header of a file of runs: which columns, in which layout, unit and sense.

use crate::inputs::target_runs::{Stated, Values};
use crate::quantity::axis::Direction;
use crate::text::delimited::{Expected, LengthUnit, Line, columns_of};
use crate::text::problem::{Problem, Problems, shown};
use std::collections::BTreeSet;

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

#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) content: Content,
    /// `None` only where the content is no length.
    pub(super) unit: Option<LengthUnit>,
}

pub(super) struct Layout {
    pub(super) columns: Vec<Column>,
    pub(super) names: Vec<String>,
    pub(super) target: usize,
    pub(super) form: Form,
    /// What the runs hold; `None` where neither a name nor a statement says it.
    pub(super) values: Option<Values>,
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
    pub(super) fn read(header: &Line<'_>, stated: Stated) -> Result<Layout, Problems> {
        refuse_other_tables(header)?;
        let expected = Expected {
            known: known_columns(header),
            same: |a: &Column, b: &Column| same_content(a.content, b.content),
            first_line: FIRST_LINE,
            columns: FIRST_LINE,
        };
        let (columns, names) = columns_of(header, &expected)?;
        let mut layout = form(header, columns, names)?;
        layout.take_unit(header, stated.unit)?;
        layout.take_values(header, stated.values)?;
        Ok(layout)
    }

    fn lengths(&self) -> impl Iterator<Item = (usize, &Column)> {
        let columns = self.columns.iter().enumerate();
        columns.filter(|(_, column)| is_length(column.content))
    }

    /// The unit that was stated goes to the columns whose names have none.
    fn take_unit(&mut self, header: &Line<'_>, stated: Option<LengthUnit>) -> Result<(), Problem> {
        let without: Vec<usize> = self
            .lengths()
            .filter(|(_, column)| column.unit.is_none())
            .map(|(index, _)| index)
            .collect();
        match (without.first(), stated) {
            (None, None) => Ok(()),
            (None, Some(unit)) => Err(Problem::new(format!(
                "the unit {} was stated, but every column names its own",
                unit.word()
            ))
            .at(header.whole())
            .help("leave out `--unit`")),
            (Some(first), None) => Err(Problem::new(format!(
                "column `{}` has no unit, expected {}{}",
                self.names[*first],
                units_of(&self.names[*first]),
                and_more(without.len() - 1, " column has none", " columns have none"),
            ))
            .at(header.cell_place(*first))
            .help("name the unit in the header, or state it for all of them: `--unit mm`, `in`, `um` or `uin`")),
            (Some(_), Some(unit)) => {
                for index in without {
                    self.columns[index].unit = Some(unit);
                }
                Ok(())
            }
        }
    }

    /// Positions or deviations: a name decides, else what was stated. Columns of runs that have
    /// the unit of the target are left open: the values themselves may show it.
    fn take_values(&mut self, header: &Line<'_>, stated: Option<Values>) -> Result<(), Problem> {
        if let (Form::RowForReading { reading, .. }, Some(named)) = (self.form, self.values) {
            return match stated {
                Some(other) if other != named => Err(Problem::new(format!(
                    "{} were stated, but column `{}` holds {}",
                    other.word(),
                    self.names[reading],
                    named.word()
                ))
                .at(header.cell_place(reading))
                .help("leave out `--values`")),
                _ => Ok(()),
            };
        }
        self.values = stated;
        let unit = self.columns[self.target].unit;
        let other = self.lengths().find(|(_, column)| column.unit != unit);
        match other {
            Some((index, _)) if stated.is_none() => Err(Problem::new(format!(
                "column `{}` has another unit than `{}`, expected to be told whether it holds \
                 positions or deviations",
                self.names[index], self.names[self.target]
            ))
            .at(header.cell_place(index))
            .help(STATE_VALUES)),
            _ => Ok(()),
        }
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

fn is_length(content: Content) -> bool {
    matches!(
        content,
        Content::Target | Content::RunOf(..) | Content::Reading(_)
    )
}

fn same_content(a: Content, b: Content) -> bool {
    a == b || matches!((a, b), (Content::Reading(_), Content::Reading(_)))
}

/// `` `up1_mm`, `up1_in` … ``: the names that a quantity can have with its unit.
fn units_of(quantity: &str) -> String {
    let names = LengthUnit::ALL.map(|unit| format!("`{quantity}_{}`", unit.word()));
    names.join(", ")
}

/// The columns that may stand in a header: those of runs for every number that it holds.
fn known_columns(header: &Line<'_>) -> Vec<(String, Column)> {
    let mut quantities = vec![
        ("target".to_string(), Content::Target),
        (
            "deviation".to_string(),
            Content::Reading(Values::Deviations),
        ),
        ("position".to_string(), Content::Reading(Values::Positions)),
    ];
    for run in run_numbers(header) {
        for (word, direction) in [
            ("up", Direction::Plus),
            ("dn", Direction::Minus),
            ("down", Direction::Minus),
        ] {
            quantities.push((format!("{word}{run}"), Content::RunOf(direction, run)));
        }
    }
    let mut known = Vec::new();
    for unit in LengthUnit::ALL.map(Some).into_iter().chain([None]) {
        let ending = unit.map_or_else(String::new, |unit| format!("_{}", unit.word()));
        let with_unit = |(name, content): &(String, Content)| {
            let content = *content;
            (format!("{name}{ending}"), Column { content, unit })
        };
        known.extend(quantities.iter().map(with_unit));
    }
    let others = [
        ("i", Content::Index),
        ("run", Content::Run),
        ("direction", Content::Direction),
    ];
    let unitless = |(name, content): (&str, Content)| {
        (
            name.to_string(),
            Column {
                content,
                unit: None,
            },
        )
    };
    known.extend(others.map(unitless));
    known
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
    let has = |is: &dyn Fn(&str) -> bool| cells.iter().position(|name| is(name));
    let is_deviation = |name: &str| ["ex_", "ey_", "ez_"].iter().any(|e| name.starts_with(e));
    if let (Some(_), Some(_)) = (has(&|name| name == "axis"), has(&is_deviation)) {
        return Err(Problem::new(
            "this is an error table, expected the raw runs of a positioning test: repeatability cannot be taken from means",
        )
        .at(header.whole())
        .help(FIRST_LINE));
    }
    let is_target = |name: &str| name == "target" || name.starts_with("target_");
    let is_run = |name: &str| {
        let digits = name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let word = &name[..name.len() - digits.len()];
        ["up", "dn", "down"].contains(&word) && digits.starts_with(|c: char| c.is_ascii_digit())
    };
    let is_position = |name: &str| {
        let name = name.to_ascii_lowercase();
        ["position", "pos", "nominal"].contains(&name.split(['_', ' ']).next().unwrap_or_default())
    };
    match (has(&is_target), has(&is_run), has(&is_position)) {
        (None, Some(_), Some(index)) => Err(Problem::new(format!(
            "unknown column `{}`, expected the targets in {}",
            shown(&cells[index]),
            units_of("target")
        ))
        .at(header.cell_place(index))
        .help("name it `target_mm` if it holds the target positions in mm")),
        _ => Ok(()),
    }
}

/// Which of the two layouts the columns make.
fn form(header: &Line<'_>, columns: Vec<Column>, names: Vec<String>) -> Result<Layout, Problems> {
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
                names[other]
            ))
            .at(header.cell_place(other))
            .help(FIRST_LINE)
            .into());
        }
        (None, Some(_)) => {
            let run = require(run, "the number of the run", "`run`");
            let direction = require(direction, "the direction of approach", "`direction`");
            let reading = require(reading, "the reading", "`deviation_um` or `position_mm`");
            let values = match columns.get(reading).map(|c| c.content) {
                Some(Content::Reading(values)) => Some(values),
                _ => None,
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
            (Form::RowForTarget, None)
        }
    };
    problems.or_ok(()).map(|()| Layout {
        columns,
        names,
        target,
        form,
        values,
    })
}
