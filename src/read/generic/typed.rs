//! The list of what was typed into a control by hand, or seen on its screen (contract §4.2).
//!
//! ```text
//!   rows ── value or seen? ── sums of the pages ── corrections ── check (as every generic table)
//! ```
//! A list holds one of deviation, correction and increment; the other two follow. Increments do not say where
//! the correction is zero, so a list names the place, `zero_mm`.

use super::check::{Flaw, GenericRow, checked};
use super::refusals;
use super::rows::{Cells, columns, place_among, wrong_count};
use crate::control::controller::TypedValue;
use crate::quantity::rounded;
use crate::text::{
    LengthUnit, Line, MOST_ROWS, Problem, Problems, Source, Word, header_and_rows,
    refuse_many_columns, shown,
};
use std::collections::BTreeMap;

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
/// The units of values, with their µm; a column is called by what its values are and their unit, a list has one.
const UNITS: [(&str, f64); 4] = [
    ("um", LengthUnit::Um.um()),
    ("mm", LengthUnit::Mm.um()),
    ("inch", LengthUnit::In.um()),
    (COUNT, 1.0),
];
/// Counts have no size of their own.
const COUNT: &str = "count";
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

/// Reads a list: what was seen, where it is filled in, else what was to be typed, unless that does not count.
pub(super) fn read(
    file: &str,
    text: &str,
    held: Option<&str>,
    as_shown: bool,
) -> Result<Vec<GenericRow>, Problems> {
    let source = Source::from_bytes(file, text.as_bytes())?;
    let Some((header, lines)) = header_and_rows(&source) else {
        return Err(refusals::empty(file).into());
    };
    let columns = Columns::of(&header, held)?;
    if let Some(problem) = wrong_count(lines.len().min(MOST_ROWS + 1)) {
        return Err(problem.at(header.whole()).into());
    }
    let mut points = Problems::all(lines.iter().map(|line| point(*line, &columns)))?;
    let sums: Vec<SheetPoint<'_>> = points.extract_if(.., |point| point.is_sum).collect();
    refuse_other_sums(&points, &sums, &columns)?;
    let was_seen = points.iter().any(|point| point.seen_um.is_some());
    let (unseen, mut told_last) = (unseen(&points, &columns), Problems::none());
    match (was_seen, unseen) {
        (true, Some(problem)) => return Err(problem.into()),
        (false, Some(problem)) if as_shown => told_last.push(problem),
        _ => points.iter_mut().for_each(|point| point.um = point.seen_um.unwrap_or(point.um)),
    }
    say_all(&mut points, &columns)?;
    let lines: Vec<Line<'_>> = points.iter().map(|point| point.line).collect();
    let rows = checked(points.into_iter().map(|point| Ok(point.row)), |flaw: Flaw| {
        let place = lines[flaw.row].cell_place(columns.place(flaw.column));
        flaw.problem.at(place)
    })?;
    told_last.or_ok(rows)
}

/// The columns of a list, and what the values are.
struct Columns {
    names: Vec<String>,
    value: String,
    kind: TypedValue,
    unit: &'static str,
    /// What 1 is in a table.
    size: f64,
}

impl Columns {
    fn of(header: &Line<'_>, held: Option<&str>) -> Result<Columns, Problems> {
        const HELP: &str = "take the whole file";
        refuse_many_columns(header, HELP)?;
        let all = UNITS.into_iter().flat_map(|unit| {
            let kinds = TypedValue::WORDS.iter();
            kinds.map(move |(word, kind)| (format!("{word}_{}", unit.0), *kind, unit))
        });
        let is_taken = |name: &str, unit| held.map_or(unit != COUNT, |held| held == name);
        let all: Vec<_> = all.filter(|(name, _, (unit, _))| is_taken(name, *unit)).collect();
        let values: Vec<&str> = all.iter().map(|(name, ..)| name.as_str()).collect();
        let names = columns(header, (&COLUMNS, &values), HELP)?;
        let own: Vec<_> = all.iter().filter(|(name, ..)| names.contains(name)).collect();
        let [(value, kind, (unit, um))] = own.as_slice() else {
            let wrong = refusals::columns_of_values(own.len(), values.join(", "));
            return Err(wrong.at(header.whole()).into());
        };
        let size = if held.is_some() { 1.0 } else { *um };
        Ok(Columns { value: value.clone(), kind: *kind, unit, size, names })
    }

    /// The cell of a column; whatever is said of a value stands at the value.
    fn place(&self, column: &str) -> usize {
        let column = match column {
            "index" => "point",
            "deviation_um" | "correction_um" | "increment_um" => &self.value,
            other => other,
        };
        place_among(&self.names, column)
    }

    /// A problem at a cell of a column.
    fn at(&self, line: &Line<'_>, column: &str, problem: Problem) -> Problem {
        problem.at(line.cell_place(self.place(column)))
    }
}

/// A point, or the sum of a page.
struct SheetPoint<'a> {
    line: Line<'a>,
    /// Its deviation, correction and increment once the values are known that count.
    row: GenericRow,
    page: String,
    is_sum: bool,
    zero_mm: f64,
    /// What was to be typed, µm; once what was seen is taken, that.
    um: f64,
    seen_um: Option<f64>,
}

fn point<'a>(line: Line<'a>, columns: &Columns) -> Result<SheetPoint<'a>, Problems> {
    const NUMBER: &str = "write digits; a decimal comma needs semicolons between the cells";
    let mut cells = Cells::of(line, &columns.names, NUMBER)?;
    let text = cells.text("point");
    let index: Option<u32> = text.parse().ok();
    if index.is_none() && text != SUM {
        cells.refuse("point", refusals::no_point(shown(&text), SUM));
    }
    let mut of_point = |column| if index.is_some() { cells.number(column) } else { 0.0 };
    let [position_mm, zero_mm] = ["position_mm", "zero_mm"].map(&mut of_point);
    let um = |value: f64| rounded(value * columns.size, DUST_DECIMALS);
    let point = SheetPoint {
        line,
        row: GenericRow {
            term: cells.text("term"),
            base_axis: cells.text("base_axis"),
            output_axis: cells.text("output_axis"),
            direction: cells.text_if_any("direction"),
            index: index.unwrap_or_default(),
            position_mm,
            ..GenericRow::default()
        },
        page: cells.text("page"),
        is_sum: index.is_none(),
        zero_mm,
        um: um(cells.number(&columns.value)),
        seen_um: cells.number_if_any("seen").map(um),
    };
    cells.problems.or_ok(point)
}

/// A page whose values do not add up to its sum, in either column, or that has none.
fn refuse_other_sums(
    points: &[SheetPoint<'_>],
    sums: &[SheetPoint<'_>],
    columns: &Columns,
) -> Result<(), Problems> {
    let mut pages: BTreeMap<&str, Vec<&SheetPoint<'_>>> = BTreeMap::new();
    for point in points {
        pages.entry(&point.page).or_default().push(point);
    }
    let mut problems = Problems::none();
    for (page, own) in pages {
        let mut sums = sums.iter().filter(|sum| sum.page == page);
        match (sums.next(), sums.next()) {
            (Some(sum), None) => other_sums(&own, sum, columns, &mut problems),
            _ => {
                let wrong = refusals::not_one_sum(shown(page));
                problems.push(wrong.at(own[0].line.whole()));
            }
        }
    }
    problems.or_ok(())
}

/// What the values of a page, and what was seen of them, add up to, against the sums that stand there.
fn other_sums(
    own: &[&SheetPoint<'_>],
    sum: &SheetPoint<'_>,
    columns: &Columns,
    problems: &mut Problems,
) {
    let total = |um: fn(&SheetPoint<'_>) -> Option<f64>| own.iter().map(|point| um(point)).sum();
    let typed = (columns.value.as_str(), total(|point| Some(point.um)), Some(sum.um));
    let seen = ("seen", total(|point| point.seen_um), sum.seen_um);
    for (column, total, stated) in [typed, seen] {
        let (Some(total), Some(stated)): (Option<f64>, Option<f64>) = (total, stated) else {
            continue;
        };
        if (total - stated).abs() > SAME {
            let shown_in = |um: f64| rounded(um / columns.size, DUST_DECIMALS);
            let (total, stated, page) = (shown_in(total), shown_in(stated), shown(&sum.page));
            let help = help_of_sum(own);
            let wrong = refusals::other_sum(column, total, columns.unit, page, stated, help);
            problems.push(columns.at(&sum.line, column, wrong));
        }
    }
}

/// Where to look first: the rows in which something else was seen than was to be typed.
fn help_of_sum(page: &[&SheetPoint<'_>]) -> String {
    let differs =
        |point: &&&SheetPoint<'_>| point.seen_um.is_some_and(|um| (um - point.um).abs() > SAME);
    let lines = page.iter().filter(differs);
    let lines: Vec<String> = lines.map(|point| point.line.number().to_string()).collect();
    match lines.is_empty() {
        true => "take the list from the kit again, or mend the sum".to_string(),
        false => format!(
            "look at the screen again: `seen` differs from the value in line {}",
            lines.join(", ")
        ),
    }
}

/// A missing value is no zero: what was seen counts whole or not at all.
fn unseen(points: &[SheetPoint<'_>], columns: &Columns) -> Option<Problem> {
    let missing = points.iter().filter(|point| point.seen_um.is_none());
    let wrong = refusals::not_seen(missing.clone().count(), points.len());
    Some(columns.at(&missing.clone().next()?.line, "seen", wrong))
}

/// Says of each point deviation, correction and increment, whichever of them the list holds.
fn say_all(points: &mut [SheetPoint<'_>], columns: &Columns) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let mut blocks: BTreeMap<[&str; 4], Vec<usize>> = BTreeMap::new();
    for (index, SheetPoint { row, .. }) in points.iter().enumerate() {
        let direction = row.direction.as_deref().unwrap_or_default();
        let block = [&row.term, &row.base_axis, &row.output_axis, direction];
        blocks.entry(block).or_default().push(index);
    }
    let blocks: Vec<Vec<usize>> = blocks.into_values().collect();
    for block in &blocks {
        let zero_um = match columns.kind.is_increment() {
            true => problems.take(sum_at_zero(points, block, columns)),
            false => Some(0.0),
        };
        let (mut sum, mut before) = (0.0, None);
        for index in block {
            let SheetPoint { row, um, .. } = &mut points[*index];
            sum += *um;
            row.correction_um = match columns.kind {
                TypedValue::Deviation => 0.0 - *um,
                TypedValue::Correction => *um,
                TypedValue::Increment | TypedValue::Outward => {
                    rounded(sum - zero_um.unwrap_or_default(), DUST_DECIMALS)
                }
            };
            row.deviation_um = 0.0 - row.correction_um;
            let change = before.replace(row.correction_um).map(|before| row.correction_um - before);
            row.increment_um = change.map(|um: f64| rounded(um, DUST_DECIMALS));
        }
    }
    problems.or_ok(())
}

/// What increments add up to where the correction is zero. Outward ones become those from the point before: up to the
/// reference, which has none, each moves on by one point.
fn sum_at_zero(
    points: &mut [SheetPoint<'_>],
    block: &[usize],
    columns: &Columns,
) -> Result<f64, Problem> {
    let first = &points[block[0]].line;
    let is_zero = |point: &SheetPoint<'_>| (point.row.position_mm - point.zero_mm).abs() <= SAME;
    let Some(zero) = block.iter().position(|index| is_zero(&points[*index])) else {
        return Err(columns.at(first, "zero_mm", refusals::nowhere_zero()));
    };
    let (place, what) = match columns.kind {
        TypedValue::Outward => (zero, "the reference point"),
        _ => (0, "the first point of a table"),
    };
    let start = &points[block[place]];
    if start.um.abs() > 0.0 {
        let wrong = refusals::increment_from_nothing(what);
        return Err(columns.at(&start.line, &columns.value, wrong));
    }
    for at in (1..=place).rev() {
        points[block[at]].um = points[block[at - 1]].um;
    }
    points[block[0]].um = 0.0;
    Ok(block[..=zero].iter().fold(0.0, |sum, index| sum + points[*index].um))
}
