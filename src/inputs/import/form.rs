//! A form of readings, as `nonius new` and `nonius program` write it: its rows are the captures in their order,
//! and the cells of its last column are empty. And the column of a list that fills it: stated by its name or number,
//! with what it holds and in which unit.

use crate::inputs::import::located::Expected;
use crate::inputs::import::mapping::Named;
use crate::inputs::import::stated::{DECIMAL, Decimal, LIST_COLUMNS, Stated};
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, LENGTHS, named};
use crate::inputs::target_runs::Values;
use crate::quantity::{Diagonal, MM_PER_INCH, UM_PER_MM};
use crate::text::{
    Line, Problem, Problems, Source, header_and_rows, joined, lines, plain_number, shown,
};
use std::borrow::Cow;
use std::collections::HashMap;

/// A form whose values are empty.
pub(super) struct Form<'a> {
    pub(super) header: Line<'a>,
    names: Vec<Cow<'a, str>>,
    pub(super) rows: Vec<Row<'a>>,
}

/// One capture.
pub(super) struct Row<'a> {
    pub(super) line: Line<'a>,
    cells: Vec<Cow<'a, str>>,
    /// Of which diagonal; `None` = of one axis.
    pub(super) of: Option<Diagonal>,
    /// Target of an axis, µm; 0 of a diagonal.
    pub(super) target_um: f64,
}

/// The column that numbers the steps of a diagonal by the axis that moved.
const MOVED: &str = "moved";
const DIAGONAL: &str = "diagonal";
const TARGETS: [(&str, f64); 2] =
    [("target_mm", UM_PER_MM), ("target_in", MM_PER_INCH * UM_PER_MM)];

impl<'a> Form<'a> {
    pub(super) fn read(source: &'a Source) -> Result<Form<'a>, Problems> {
        let Some((header, lines)) = header_and_rows(source) else {
            return Err(refusals::no_form(&source.name).into());
        };
        let mut form = Form { names: header.cells(), header, rows: Vec::new() };
        let holds_values = |name: &Cow<'_, str>| {
            name.starts_with("displacement_") || name.starts_with("deviation_")
        };
        if !form.names.last().is_some_and(holds_values)
            || form.of_axis() == form.column(DIAGONAL).is_some()
        {
            return Err(refusals::no_form_header().at(header.whole()).into());
        }
        let mut problems = Problems::none();
        for line in lines {
            let cells = line.cells_under(form.names.len());
            form.rows.extend(problems.take(cells.and_then(|cells| form.row(line, cells))));
        }
        problems.or_ok(form)
    }

    fn row(&self, line: Line<'a>, cells: Vec<Cow<'a, str>>) -> Result<Row<'a>, Problem> {
        if cells.last().is_some_and(|value| !value.is_empty()) {
            return Err(refusals::filled_already().at(line.whole()));
        }
        let cell = |name: &str| self.column(name).map(|index| &*cells[index]);
        let of = cell(DIAGONAL).and_then(Diagonal::from_name).map(|(of, _)| of);
        let target = TARGETS.iter().find_map(|(name, um)| Some(plain_number(cell(name)?)? * um));
        if of.is_none() && target.is_none() {
            return Err(refusals::no_capture().at(line.whole()));
        }
        let target_um = target.unwrap_or_default();
        Ok(Row { line, cells, of, target_um })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own == name)
    }

    /// Whether it is that of one axis, with its targets.
    pub(super) fn of_axis(&self) -> bool {
        TARGETS.iter().any(|(name, _)| self.column(name).is_some())
    }

    /// The captures of one list.
    pub(super) fn rows_of(&self, of: Option<Diagonal>) -> Vec<&Row<'a>> {
        self.rows.iter().filter(|row| row.of == of).collect()
    }

    /// A capture, as a person finds it in the form.
    pub(super) fn name(&self, row: &Row<'_>) -> String {
        let named = self.names.iter().zip(&row.cells);
        let named = named.filter(|(name, cell)| !cell.is_empty() && *name != DIAGONAL);
        joined(named.map(|(name, cell)| format!("{name} {}", shown(cell))))
    }

    /// What is expected of the values of one list; with targets they hold the way there.
    pub(super) fn expected(&self, rows: &[&Row<'_>], with_targets: bool) -> Expected {
        let cell =
            |at: usize, name: &str| self.column(name).map_or("", |index| &rows[at].cells[index]);
        let place = |at: usize| (cell(at, "node"), rows[at].target_um.to_bits());
        let pass = |at: usize| (cell(at, "run"), cell(at, "direction"));
        let begins = |at: usize| at == 0 || pass(at) != pass(at - 1);
        let turns = |at: usize| at > 0 && begins(at) && place(at) == place(at - 1);
        let mut met = HashMap::new();
        let twin = |at: usize| met.insert((place(at), pass(at).1), at);
        let nominal = |row: &&Row<'_>| if with_targets { row.target_um } else { 0.0 };
        Expected {
            begins: (0..rows.len()).map(begins).collect(),
            turns: (0..rows.len()).map(turns).collect(),
            twins: (0..rows.len()).map(twin).collect(),
            nominal_um: rows.iter().map(nominal).collect(),
            period: if self.column(MOVED).is_some() { 3 } else { 1 },
        }
    }
}

/// One value of a list.
pub(super) struct Capture<'a> {
    pub(super) line: Line<'a>,
    pub(super) um: f64,
}

/// Which column of the lists holds what.
pub(super) struct ListColumn {
    name: Named,
    /// `displacement_…`, the way as it was read; else `deviation_…`, measured − nominal.
    pub(super) column: Column,
}

/// The way as it was read.
pub(super) const DISPLACEMENT: Content = Content::reading(Values::Positions);

impl ListColumn {
    pub(super) fn stated(stated: &Stated) -> Result<ListColumn, Problem> {
        let text = stated.columns.as_deref();
        let text = text.ok_or_else(|| LIST_COLUMNS.missing())?;
        ListColumn::parse(text).ok_or_else(|| refusals::no_readings(shown(text)))
    }

    fn parse(text: &str) -> Option<ListColumn> {
        let (name, target) = text.rsplit_once('=')?;
        let name = Named::of(name);
        let known = named(&[
            ("displacement", DISPLACEMENT, &LENGTHS),
            ("deviation", Content::reading(Values::Deviations), &LENGTHS),
        ]);
        let column = known.into_iter().find(|known| known.name == target.trim())?;
        (name != Named::Number(0)).then_some(ListColumn { name, column })
    }

    /// The values of a list: below the name of the column, or from the first number in it.
    pub(super) fn captures<'a>(
        &self,
        source: &'a Source,
        decimal: Option<Decimal>,
    ) -> Result<Vec<Capture<'a>>, Problems> {
        let all = content(source, decimal)?;
        let Some((index, start)) = self.found(&all) else {
            return Err(refusals::no_list_column(&source.name, self.words()).into());
        };
        let mut problems = Problems::none();
        let expected =
            "every line below the first value holds one: a missing capture is never filled in";
        let captures = all[start..].iter().filter_map(|line| {
            let cells = line.cells();
            let cell = cells.get(index).map_or("", |cell| cell);
            let at = index.min(cells.len() - 1);
            let number = line.number_in(at, cell, &self.words(), expected, &mut problems)?;
            Some(Capture { line: *line, um: number * self.column.factor() })
        });
        let captures = captures.collect();
        problems.or_ok(captures)
    }

    /// Where the column stands, and at which line its values begin.
    fn found(&self, all: &[Line<'_>]) -> Option<(usize, usize)> {
        match &self.name {
            Named::Text(name) => all.iter().zip(1..).find_map(|(line, below)| {
                Some((line.cells().iter().position(|cell| cell == name)?, below))
            }),
            Named::Number(number) => {
                let is_number = |cell: &str| cell.replace(',', ".").parse::<f64>().is_ok();
                let has_one = |line: &Line<'_>| {
                    line.cells().get(number - 1).is_some_and(|cell| is_number(cell))
                };
                Some((number - 1, all.iter().position(has_one)?))
            }
        }
    }

    fn words(&self) -> String {
        match &self.name {
            Named::Text(name) => shown(name),
            Named::Number(number) => format!("#{number}"),
        }
    }
}

/// The lines of a list without comments and empty ones. A comma between digits may stand before decimals or
/// between columns, so one of the two has to be stated.
fn content(source: &Source, decimal: Option<Decimal>) -> Result<Vec<Line<'_>>, Problem> {
    let all = lines(source)
        .filter(|line| !line.text().trim_start().starts_with('#') && !line.is_empty_row());
    let all: Vec<Line<'_>> = all.collect();
    let is_open = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit();
    let mut open = all.iter().filter(|line| line.text().as_bytes().windows(3).any(is_open));
    if let (None, Some(line)) = (decimal, open.next()) {
        return Err(DECIMAL.missing_because("a comma stands between digits").at(line.whole()));
    }
    let has_comma = decimal == Some(Decimal::Comma);
    let separated = |line: &Line<'_>| {
        if has_comma && line.delimiter() == b',' { b';' } else { line.delimiter() }
    };
    Ok(all.iter().map(|line| line.separated_by(separated(line), has_comma)).collect())
}
