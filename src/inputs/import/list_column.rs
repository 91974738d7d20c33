//! The column of a list that holds its values: stated by its name or number, with what it holds and in which unit.

use crate::inputs::import::mapping::Named;
use crate::inputs::import::stated::{DECIMAL, Decimal, LIST_COLUMNS, Stated};
use crate::inputs::refusals;
use crate::text::delimited::{LengthUnit, Line, lines};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

/// One value of a list.
pub(super) struct Capture<'a> {
    pub(super) line: Line<'a>,
    pub(super) um: f64,
}

/// Which column of the lists holds what.
pub(super) struct ListColumn {
    name: Named,
    /// `displacement`, the way as it was read; else `deviation`, measured − nominal.
    pub(super) quantity: &'static str,
    pub(super) unit: LengthUnit,
}

/// The way as it was read.
pub(super) const DISPLACEMENT: &str = "displacement";

impl ListColumn {
    pub(super) fn stated(stated: &Stated) -> Result<ListColumn, Problem> {
        let text = stated.columns.as_deref();
        let text = text.ok_or_else(|| LIST_COLUMNS.missing())?;
        ListColumn::parse(text).ok_or_else(|| refusals::no_readings(shown(text)))
    }

    fn parse(text: &str) -> Option<ListColumn> {
        let (name, target) = text.rsplit_once('=')?;
        let name = Named::of(name);
        let (quantity, unit) = target.trim().split_once('_')?;
        let unit = LengthUnit::ALL.into_iter().find(|known| known.word() == unit)?;
        let quantity = [DISPLACEMENT, "deviation"].into_iter().find(|known| *known == quantity)?;
        (name != Named::Number(0)).then_some(ListColumn { name, quantity, unit })
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
            Some(Capture { line: *line, um: number * self.unit.um() })
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
