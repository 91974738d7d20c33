//! The list of what was typed into a control by hand, or seen on its screen (contract §4.2).
//!
//! ```text
//!   rows ── value or seen? ── sums of the pages ── corrections ── check (as every generic table)
//! ```
//! A list holds one of deviation, correction and increment; the other two follow. Increments do not say where
//! the correction is zero, so a list names the place, `zero_mm`.

use super::check::{Flaw, RawRow, table};
use super::rows::wrong_count;
use crate::control::table::generic::GenericTable;
use crate::quantity::units;
use crate::text::delimited::{LengthUnit, Line, header_and_rows, refuse_many_columns};
use crate::text::document::{MOST_ROWS, Source};
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What a value of a list is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Deviation,
    Correction,
    Increment,
}

/// Columns of every list.
const COLUMNS: [&str; 9] = [
    "term",
    "base_axis",
    "output_axis",
    "direction",
    "zero_mm",
    "page",
    "point",
    "position_mm",
    "seen",
];
/// The columns that hold words; there may be fifty thousand rows, each with its own.
const NAMES: [&str; 5] = ["term", "base_axis", "output_axis", "direction", "page"];
/// The columns of values; a list has one of them.
const VALUES: [(&str, Kind, LengthUnit); 6] = [
    ("deviation_um", Kind::Deviation, LengthUnit::Um),
    ("deviation_mm", Kind::Deviation, LengthUnit::Mm),
    ("correction_um", Kind::Correction, LengthUnit::Um),
    ("correction_mm", Kind::Correction, LengthUnit::Mm),
    ("increment_um", Kind::Increment, LengthUnit::Um),
    ("increment_mm", Kind::Increment, LengthUnit::Mm),
];
/// What stands under `point` in the row of a sum.
const SUM: &str = "sum";
/// Sums and places closer than this are the same, µm and mm.
const SAME: f64 = 1e-6;
/// Values are freed from binary dust at a femtometre.
const DUST_DECIMALS: u32 = 9;

/// Whether a text is such a list.
pub(super) fn is_list(text: &str) -> bool {
    let header = text.lines().find(|line| !line.trim().is_empty());
    header.is_some_and(|header| {
        let mut cells = header.split([',', ';', '\t']);
        cells.any(|cell| cell.trim().trim_matches('"') == "point")
    })
}

/// Reads a list: what was seen, where it is filled in, else what was to be typed.
pub(super) fn read(file: &str, text: &str) -> Result<GenericTable, Problems> {
    read_as(file, text, false)
}

/// Reads what was seen; a list in which nothing was filled in is refused.
pub(super) fn read_seen(file: &str, text: &str) -> Result<GenericTable, Problems> {
    read_as(file, text, true)
}

fn read_as(file: &str, text: &str, is_seen: bool) -> Result<GenericTable, Problems> {
    let source = Source::from_bytes(file, text.as_bytes())?;
    let Some((header, lines)) = header_and_rows(&source) else {
        return Err(Problem::new(format!("`{file}` is empty")).into());
    };
    let columns = Columns::of(&header)?;
    let too_many = wrong_count(lines.len().min(MOST_ROWS + 1));
    if let Some(problem) = too_many {
        return Err(problem.at(header.whole()).into());
    }
    let mut problems = Problems::none();
    let mut rows = Vec::with_capacity(lines.len());
    rows.extend(lines.iter().filter_map(|line| problems.take(row(line, &columns))));
    let mut points = problems.or_ok(rows)?;
    let sums: Vec<Row<'_>> = points.extract_if(.., |row| row.is_sum()).collect();
    refuse_other_sums(&points, &sums, &columns)?;
    let was_seen = points.iter().any(|point| point.seen_um.is_some());
    if was_seen {
        take_seen(&mut points, &columns)?;
    }
    let corrections = corrections(&points, &columns)?;
    let raw = points.iter().zip(&corrections);
    let table = table(raw.map(|(point, um)| point.raw(*um)), |flaw: &Flaw| {
        let place = points[flaw.row].line.cell_place(columns.place(flaw.column));
        Problem::new(flaw.message.clone()).at(place)
    })?;
    if is_seen && !was_seen {
        take_seen(&mut points, &columns)?;
    }
    Ok(table)
}

/// Where each column stands, and what the values are.
struct Columns {
    names: Vec<String>,
    value: &'static str,
    kind: Kind,
    unit: LengthUnit,
}

impl Columns {
    fn of(header: &Line<'_>) -> Result<Columns, Problems> {
        refuse_many_columns(header, "take the whole file")?;
        let names: Vec<String> = header.cells().iter().map(ToString::to_string).collect();
        let mut problems = Problems::none();
        let values = VALUES.map(|(name, ..)| name);
        for (index, name) in names.iter().enumerate() {
            let is_known = COLUMNS.contains(&name.as_str()) || values.contains(&name.as_str());
            if !is_known || names[..index].contains(name) {
                let message = format!("column `{}` is unknown, or a duplicate", shown(name));
                problems.push(Problem::new(message).at(header.cell_place(index)));
            }
        }
        for name in COLUMNS.iter().filter(|name| !names.iter().any(|own| own == **name)) {
            let message = format!("the header has no column `{name}`");
            problems.push(Problem::new(message).at(header.whole()));
        }
        let own = VALUES.iter().filter(|(name, ..)| names.iter().any(|own| own == name));
        let own: Vec<_> = own.collect();
        let [(value, kind, unit)] = own.as_slice() else {
            let message = format!("the list has {} columns of values, expected one", own.len());
            let help = format!("one of {}", values.join(", "));
            problems.push(Problem::new(message).at(header.whole()).help(help));
            return Err(problems);
        };
        problems.or_ok(Columns { names, value, kind: *kind, unit: *unit })
    }

    /// The cell of a column; whatever is said of a value stands at the value.
    fn place(&self, column: &str) -> usize {
        let column = match column {
            "index" => "point",
            "deviation_um" | "correction_um" | "increment_um" => self.value,
            other => other,
        };
        self.names.iter().position(|own| own == column).unwrap_or(0)
    }
}

/// A point, or the sum of a page.
struct Row<'a> {
    line: Line<'a>,
    /// In the order of [`NAMES`].
    names: [Cow<'a, str>; NAMES.len()],
    point: Option<u32>,
    position_mm: f64,
    zero_mm: f64,
    /// What was to be typed, µm; once what was seen is taken, that.
    um: f64,
    seen_um: Option<f64>,
}

impl Row<'_> {
    fn is_sum(&self) -> bool {
        self.point.is_none()
    }

    fn text(&self, column: &str) -> &str {
        let place = NAMES.iter().position(|own| *own == column);
        place.map_or("", |place| self.names[place].as_ref())
    }

    /// The block it belongs to.
    fn block(&self) -> [&str; 4] {
        ["term", "base_axis", "output_axis", "direction"].map(|column| self.text(column))
    }

    /// The same as a row of the generic table, from the corrections before it and at it.
    fn raw(&self, (before, um): (Option<f64>, f64)) -> Result<RawRow, Problems> {
        let text = |column: &str| self.text(column).to_string();
        Ok(RawRow {
            term: text("term"),
            base_axis: text("base_axis"),
            output_axis: text("output_axis"),
            direction: Some(text("direction")).filter(|symbol| !symbol.is_empty()),
            index: self.point.unwrap_or_default(),
            position_mm: self.position_mm,
            deviation_um: 0.0 - um,
            correction_um: um,
            increment_um: before.map(|before| units::rounded(um - before, DUST_DECIMALS)),
        })
    }
}

fn row<'a>(line: &Line<'a>, columns: &Columns) -> Result<Row<'a>, Problems> {
    const NUMBER: &str = "write digits; a decimal comma needs semicolons between the cells";
    let mut problems = Problems::none();
    let Some(own) = line.cells_under(columns.names.len(), &mut problems) else {
        return Err(problems);
    };
    let cell = |column: &str| own[columns.place(column)].clone();
    let point: Option<u32> = cell("point").parse().ok();
    if point.is_none() && cell("point") != SUM {
        let found = shown(&cell("point"));
        let message = format!("`point` is `{found}`, expected the number of a point or `{SUM}`");
        problems.push(Problem::new(message).at(line.cell_place(columns.place("point"))));
    }
    let mut number = |column: &str| {
        let place = columns.place(column);
        line.number_in(place, &own[place], column, NUMBER, &mut problems)
    };
    let is_point = point.is_some();
    let position_mm = if is_point { number("position_mm") } else { None };
    let zero_mm = if is_point { number("zero_mm") } else { None };
    let value = number(columns.value);
    let seen = match cell("seen").is_empty() {
        true => None,
        false => number("seen"),
    };
    let um = |value: f64| units::rounded(value * columns.unit.um(), DUST_DECIMALS);
    problems.or_ok(Row {
        line: *line,
        names: NAMES.map(cell),
        point,
        position_mm: position_mm.unwrap_or_default(),
        zero_mm: zero_mm.unwrap_or_default(),
        um: um(value.unwrap_or_default()),
        seen_um: seen.map(um),
    })
}

/// A page whose values do not add up to its sum, in either column, or that has none.
fn refuse_other_sums(
    points: &[Row<'_>],
    sums: &[Row<'_>],
    columns: &Columns,
) -> Result<(), Problems> {
    let mut pages: BTreeMap<&str, Vec<&Row<'_>>> = BTreeMap::new();
    for point in points {
        pages.entry(point.text("page")).or_default().push(point);
    }
    let mut problems = Problems::none();
    for (page, own) in pages {
        let mut sums = sums.iter().filter(|sum| sum.text("page") == page);
        match (sums.next(), sums.next()) {
            (Some(sum), None) => other_sums(&own, sum, columns, &mut problems),
            _ => {
                let message = format!("page `{}` has no sum, or more than one", shown(page));
                let problem = Problem::new(message).at(own[0].line.whole());
                problems
                    .push(problem.help(
                        "rows of this page may be missing: take the list from the kit again",
                    ));
            }
        }
    }
    problems.or_ok(())
}

/// What the values of a page, and what was seen of them, add up to, against the sums that stand there.
fn other_sums(own: &[&Row<'_>], sum: &Row<'_>, columns: &Columns, problems: &mut Problems) {
    let total = |um: fn(&Row<'_>) -> Option<f64>| own.iter().map(|row| um(row)).sum();
    let typed = (columns.value, total(|row| Some(row.um)), Some(sum.um));
    let seen = ("seen", total(|row| row.seen_um), sum.seen_um);
    for (column, total, stated) in [typed, seen] {
        let (Some(total), Some(stated)): (Option<f64>, Option<f64>) = (total, stated) else {
            continue;
        };
        if (total - stated).abs() > SAME {
            let unit = columns.unit.word();
            let shown_in = |um: f64| units::rounded(um / columns.unit.um(), DUST_DECIMALS);
            let message = format!(
                "`{column}` adds up to {} {unit} on page {}, its sum is {} {unit}",
                shown_in(total),
                shown(sum.text("page")),
                shown_in(stated)
            );
            let place = sum.line.cell_place(columns.place(column));
            problems.push(Problem::new(message).at(place).help(help_of_sum(own)));
        }
    }
}

/// Where to look first: the rows in which something else was seen than was to be typed.
fn help_of_sum(page: &[&Row<'_>]) -> String {
    let differs = |row: &&&Row<'_>| row.seen_um.is_some_and(|um| (um - row.um).abs() > SAME);
    let lines = page.iter().filter(differs);
    let lines: Vec<String> = lines.map(|row| row.line.number().to_string()).collect();
    match lines.is_empty() {
        true => "take the list from the kit again, or mend the sum".to_string(),
        false => format!(
            "look at the screen again: `seen` differs from the value in line {}",
            lines.join(", ")
        ),
    }
}

/// Takes what was seen, all of it: a missing value is no zero.
fn take_seen(points: &mut [Row<'_>], columns: &Columns) -> Result<(), Problems> {
    let missing = points.iter().filter(|point| point.seen_um.is_none());
    if let Some(first) = missing.clone().next() {
        let message = format!("`seen` is empty in {} of {} lines", missing.count(), points.len());
        return Err(Problem::new(message)
            .at(first.line.cell_place(columns.place("seen")))
            .help("read every point on the control's screen and fill in what it shows")
            .into());
    }
    for point in points {
        point.um = point.seen_um.unwrap_or(point.um);
    }
    Ok(())
}

/// Of each point the correction before it in its block, and its own, µm.
fn corrections(points: &[Row<'_>], columns: &Columns) -> Result<Vec<(Option<f64>, f64)>, Problems> {
    let mut problems = Problems::none();
    let mut blocks: BTreeMap<[&str; 4], Vec<usize>> = BTreeMap::new();
    for (index, point) in points.iter().enumerate() {
        blocks.entry(point.block()).or_default().push(index);
    }
    let mut found = vec![(None, 0.0); points.len()];
    for block in blocks.values() {
        let own: Vec<&Row<'_>> = block.iter().map(|index| &points[*index]).collect();
        let values = match columns.kind {
            Kind::Deviation => own.iter().map(|row| 0.0 - row.um).collect(),
            Kind::Correction => own.iter().map(|row| row.um).collect(),
            Kind::Increment => match added_up(&own, columns) {
                Ok(values) => values,
                Err(problem) => {
                    problems.push(problem);
                    continue;
                }
            },
        };
        let before = std::iter::once(None).chain(values.iter().copied().map(Some));
        for ((index, before), um) in block.iter().zip(before).zip(&values) {
            found[*index] = (before, *um);
        }
    }
    problems.or_ok(found)
}

/// The corrections that increments add up to, zero where the list says.
fn added_up(block: &[&Row<'_>], columns: &Columns) -> Result<Vec<f64>, Problem> {
    let first = block[0];
    if first.um.abs() > 0.0 {
        let message = "the first point of a table has an increment, expected 0";
        let place = first.line.cell_place(columns.place(columns.value));
        return Err(Problem::new(message)
            .at(place)
            .help("an increment is the change from the point before; there is none"));
    }
    let mut sum = 0.0;
    let sums = block.iter().map(|row| {
        sum += row.um;
        sum
    });
    let sums: Vec<f64> = sums.collect();
    let at_zero = block.iter().position(|row| (row.position_mm - row.zero_mm).abs() <= SAME);
    let Some(zero) = at_zero else {
        let message = "no point of this table lies at `zero_mm`, where the correction is zero";
        let place = first.line.cell_place(columns.place("zero_mm"));
        return Err(Problem::new(message)
            .at(place)
            .help("`zero_mm` is the reference point, in machine coordinates"));
    };
    Ok(sums.iter().map(|um| units::rounded(um - sums[zero], DUST_DECIMALS)).collect())
}
