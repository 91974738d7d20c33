//! Lists of captures, as an instrument saved them → the cells of a form, as `nonius new` and `nonius program` write it.
//!
//! ```text
//!  form: rows in the order of the captures, last cell empty ─┐
//!  a list for each set-up: values in order ──────────────────┴─→ as many as rows? ─→ the form, filled in
//! ```
//! A list says nothing of where its values were taken, so it has to have one for each capture; which column of it holds
//! them, what and in which unit is stated. One too few or too many is located and named, and never filled in or left out.

use crate::inputs::import::encoding::{Measurement, text_of};
use crate::inputs::import::intake::Intake;
use crate::inputs::import::located::{Expected, Located};
use crate::inputs::import::mapping::ColumnName;
use crate::inputs::import::stated::{
    CAPTURES, Counting, DECIMAL, Decimal, Format, ImportFacts, LIST_COLUMNS,
};
use crate::inputs::readings::Readings;
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, LENGTHS, named};
use crate::inputs::target_runs::Values;
use crate::quantity::{Diagonal, Figure, MM_PER_INCH, UM_PER_MM, rounded};
use crate::text::{
    Line, Problem, Problems, Source, header_and_rows, joined, lines, plain, plain_number, shown,
    written_number,
};
use std::borrow::Cow;
use std::collections::HashMap;

/// A list, and the diagonal of which it is; `None` = of one axis.
pub type List<'a> = (Option<Diagonal>, Measurement<'a>);

/// Fills a form in, and gives its text; everything that is wrong is told at once.
pub fn fill(source: &Source, lists: &[List<'_>], stated: &ImportFacts) -> Result<String, Problems> {
    let intake = Intake::of(source, stated, Format::List);
    let text = filled(&intake, lists);
    intake.end(text).map(|(text, _)| text)
}

fn filled(intake: &Intake<'_>, lists: &[List<'_>]) -> Option<String> {
    let (source, stated) = (intake.source, intake.stated);
    let column = intake.notes.take(list_column(stated));
    let counting = intake.settled(&CAPTURES, None, stated.captures);
    let form = intake.notes.take(Form::read(source));
    let (mut form, column, counting) = (form?, column?, counting?);
    form.with_targets = form.of_axis && column.1.content == DISPLACEMENT;
    form.refuse_other_lists(lists, intake);
    for (of, file) in lists {
        let taken = text_of(*file, stated).and_then(|(list, _)| {
            Ok(form.take(*of, &captures(&column, &list, stated.decimal)?, counting)?)
        });
        intake.notes.take(taken);
    }
    let own = lists.iter().map(|(_, file)| file.comment()).chain(stated.comments());
    let text = intake.if_sound(form.text(source, &column.1, own))?;
    if !form.of_axis {
        let filled = Source::from_bytes(&source.name, text.as_bytes());
        intake.notes.take(filled.and_then(|filled| Readings::look_at_cells(&filled)));
    }
    Some(text)
}

/// The value at which it shows that there are too few or too many, and the problem.
type Off = (Option<usize>, Problem);

/// A form while it is filled in.
struct Form<'a> {
    header: Line<'a>,
    names: Vec<Cow<'a, str>>,
    rows: Vec<CaptureRow<'a>>,
    /// Whether it is that of one axis, with its targets.
    of_axis: bool,
    /// Whether the values of the lists hold the way to the target.
    with_targets: bool,
}

/// One capture.
struct CaptureRow<'a> {
    cells: Vec<Cow<'a, str>>,
    /// Of which diagonal; `None` = of one axis.
    of: Option<Diagonal>,
    /// Target of an axis, µm; 0 of a diagonal.
    target_um: f64,
    /// What fills it in, µm.
    value_um: Option<f64>,
}

/// The column that numbers the steps of a diagonal by the axis that moved.
const MOVED: &str = "moved";
const DIAGONAL: &str = "diagonal";
const TARGETS: [(&str, f64); 2] =
    [("target_mm", UM_PER_MM), ("target_in", MM_PER_INCH * UM_PER_MM)];

impl<'a> Form<'a> {
    fn read(source: &'a Source) -> Result<Form<'a>, Problems> {
        let Some((header, lines)) = header_and_rows(source) else {
            return Err(refusals::no_form(&source.name).into());
        };
        let names = header.cells();
        let of_axis = TARGETS.iter().any(|(target, _)| names.iter().any(|name| name == target));
        let is_whole = names.last().is_some_and(|name| {
            name.starts_with("displacement_") || name.starts_with("deviation_")
        }) && of_axis != names.iter().any(|name| name == DIAGONAL);
        if !is_whole {
            return Err(refusals::no_form_header().at(header.whole()).into());
        }
        let mut form = Form { header, names, rows: Vec::new(), of_axis, with_targets: false };
        form.rows = Problems::all(lines.iter().map(|line| form.row(line)))?;
        Ok(form)
    }

    fn row(&self, line: &Line<'a>) -> Result<CaptureRow<'a>, Problem> {
        let cells = line.cells_under(self.names.len())?;
        if cells.last().is_some_and(|value| !value.is_empty()) {
            return Err(refusals::filled_already().at(line.whole()));
        }
        let cell = |name: &str| self.column(name).map(|index| &*cells[index]);
        let of = cell(DIAGONAL).and_then(Diagonal::from_name).map(|(of, _)| of);
        let target = TARGETS.iter().find_map(|(name, um)| Some(plain_number(cell(name)?)? * um));
        if of.is_none() && target.is_none() {
            return Err(refusals::no_capture().at(line.whole()));
        }
        Ok(CaptureRow { cells, of, target_um: target.unwrap_or_default(), value_um: None })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own == name)
    }

    /// A form of diagonals takes a list of each, that of an axis one.
    fn refuse_other_lists(&self, lists: &[List<'_>], intake: &Intake<'_>) {
        let wanted: Vec<Option<Diagonal>> =
            if self.of_axis { vec![None] } else { Diagonal::ALL.map(Some).to_vec() };
        let refuse = |of: &Option<Diagonal>, words: &str| {
            let name = of.map(|of| format!("`--{} FILE`", of.name().to_ascii_lowercase()));
            let name = name.unwrap_or("FILE alone".to_string());
            intake.notes.refuse(refusals::other_list(words, name).at(self.header.whole()));
        };
        let given: Vec<Option<Diagonal>> = lists.iter().map(|(of, _)| *of).collect();
        let is_empty = |of: &Option<Diagonal>| self.rows.iter().all(|row| row.of != *of);
        let lacking = wanted.iter().filter(|of| !given.contains(of) && !is_empty(of));
        lacking.for_each(|of| refuse(of, "needs a"));
        given.iter().filter(|of| !wanted.contains(of)).for_each(|of| refuse(of, "takes no"));
    }

    /// Takes the captures of one list, as many as the form has.
    fn take(
        &mut self,
        of: Option<Diagonal>,
        captures: &[Capture<'_>],
        counting: Counting,
    ) -> Result<(), Problem> {
        let mut um: Vec<f64> = captures.iter().map(|(_, um)| *um).collect();
        if counting == Counting::Incremental {
            um.insert(0, 0.0);
            (1..um.len()).for_each(|at| um[at] += um[at - 1]);
        }
        let rows: Vec<&CaptureRow<'_>> = self.rows.iter().filter(|row| row.of == of).collect();
        if um.len() != rows.len() {
            let first = um.len() - captures.len();
            let (at, problem) = self.off(of, &rows, &um, first);
            let capture = at.and_then(|at| captures.get(at.saturating_sub(first)));
            return Err(capture.map_or(problem.clone(), |(line, _)| problem.at(line.whole())));
        }
        let first_um = rows.first().map_or(0.0, |row| row.target_um);
        for (row, um) in self.rows.iter_mut().filter(|row| row.of == of).zip(um) {
            let way_um = if self.with_targets { row.target_um - first_um } else { 0.0 };
            row.value_um = Some(um - way_um);
        }
        Ok(())
    }

    /// What is wrong with the number of values, the `first` of which are not in the list.
    fn off(&self, of: Option<Diagonal>, rows: &[&CaptureRow<'_>], um: &[f64], first: usize) -> Off {
        let (found, expected, walk) = (um.len(), rows.len(), self.expected(rows));
        let row = |place: usize| rows.get(place).or(rows.last());
        let name = |place| row(place).map_or(String::new(), |row| self.name(row));
        let value = |at: usize| format!("value {} ({})", (at + 1 - first).max(1), name(at));
        let off = found.abs_diff(expected);
        let what = format!("{off} {}", if found < expected { "missing" } else { "too many" });
        let (at, help) = match off {
            1 if found < expected => {
                let (at, help) = told(walk.missing(um), name);
                (at.map(|at| at.saturating_sub(1)), help)
            }
            1 => told(walk.surplus(um), value),
            _ => (None, format!("only one can be located; {AGAIN}")),
        };
        let of = of.map_or("the axis".to_string(), |diagonal| diagonal.to_string());
        (at, refusals::other_captures(of, found - first, expected, what, help))
    }

    /// A capture, as a person finds it in the form.
    fn name(&self, row: &CaptureRow<'_>) -> String {
        let named = self.names.iter().zip(&row.cells);
        let named = named.filter(|(name, cell)| !cell.is_empty() && *name != DIAGONAL);
        joined(named.map(|(name, cell)| format!("{name} {}", shown(cell))))
    }

    /// What is expected of the values of one list.
    fn expected(&self, rows: &[&CaptureRow<'_>]) -> Expected {
        let cell =
            |at: usize, name: &str| self.column(name).map_or("", |index| &rows[at].cells[index]);
        let place = |at: usize| (cell(at, "node"), rows[at].target_um.to_bits());
        let pass = |at: usize| (cell(at, "run"), cell(at, "direction"));
        let begins = |at: usize| at == 0 || pass(at) != pass(at - 1);
        let turns = |at: usize| at > 0 && begins(at) && place(at) == place(at - 1);
        let mut met = HashMap::new();
        let twin = |at: usize| met.insert((place(at), pass(at).1), at);
        let nominal = |row: &&CaptureRow<'_>| if self.with_targets { row.target_um } else { 0.0 };
        Expected {
            begins: (0..rows.len()).map(begins).collect(),
            turns: (0..rows.len()).map(turns).collect(),
            twins: (0..rows.len()).map(twin).collect(),
            nominal_um: rows.iter().map(nominal).collect(),
            period: if self.column(MOVED).is_some() { 3 } else { 1 },
        }
    }

    /// The form with its values; comments say where they are from.
    fn text(&self, form: &Source, column: &Column, own: impl Iterator<Item = String>) -> String {
        let (heading, factor) =
            if self.of_axis { ("deviation_um", 1.0) } else { (&*column.name, column.factor()) };
        let kept = form.text.lines().filter(|line| line.starts_with('#'));
        let kept = kept.map(|line| plain::comment(line.strip_prefix("# ").unwrap_or(&line[1..])));
        let own = own.map(|words| plain::comment(&words));
        let with_last = |cells: &[Cow<'_, str>], last: &str| {
            let cells = cells.iter().take(cells.len() - 1).map(AsRef::as_ref);
            let cells: Vec<&str> = cells.chain([last]).collect();
            cells.join(&char::from(self.header.delimiter()).to_string())
        };
        let header = with_last(&self.names, heading);
        let rows = self.rows.iter().map(|row| {
            let value = row.value_um.map(|um| Figure(rounded(um / factor, 9)).to_string());
            with_last(&row.cells, &value.unwrap_or_default())
        });
        kept.chain(own).chain([header]).chain(rows).collect::<Vec<_>>().join("\n") + "\n"
    }
}

/// What comes before another measurement.
const AGAIN: &str = "nothing is filled in or left out: look at `--captures` and at both ends of the list before you measure this set-up again";
/// Odds beyond which nobody needs the figure.
const CERTAIN: f64 = 1e9;
/// Places that are named one by one; of more the first and the last are.
const MOST_NAMED: usize = 3;
/// With more of them it is not told which.
const MOST_TOLD: usize = 24;

/// Where it is, with its odds, in words.
fn told(located: Option<Located>, name: impl Fn(usize) -> String) -> (Option<usize>, String) {
    let Some(Located { places, odds }) = located else {
        return (None, format!("the values are too few to tell which; {AGAIN}"));
    };
    let count = places.len();
    let first = places.iter().copied().min().unwrap_or_default();
    let last = places.iter().copied().max().unwrap_or_default();
    if count > MOST_TOLD || last - first > 2 * count {
        return (None, format!("{count} places fit about equally; {AGAIN}"));
    }
    let names = match count > MOST_NAMED {
        true => format!("one of {count} from {} to {}", name(first), name(last)),
        false => places.iter().map(|place| name(*place)).collect::<Vec<_>>().join(" or "),
    };
    let odds = if odds > CERTAIN { "more than 10⁹".to_string() } else { format!("{odds:.0}") };
    let words = format!("most likely it is {names}, {odds} : 1 against any other place; {AGAIN}");
    (places.first().copied(), words)
}

/// One value of a list, µm, and its line.
type Capture<'a> = (Line<'a>, f64);

/// Which column of the lists holds what: `displacement_…`, the way as it was read; else `deviation_…`, measured − nominal.
type ListColumn = (ColumnName, Column);

/// The way as it was read.
const DISPLACEMENT: Content = Content::reading(Values::Positions);

fn list_column(stated: &ImportFacts) -> Result<ListColumn, Problem> {
    let text = stated.columns.as_deref().ok_or_else(|| LIST_COLUMNS.missing())?;
    let known = named(&[
        ("displacement", DISPLACEMENT, &LENGTHS),
        ("deviation", Content::reading(Values::Deviations), &LENGTHS),
    ]);
    let pair = text.rsplit_once('=').map(|(name, target)| (ColumnName::of(name), target.trim()));
    let found =
        pair.filter(|(name, _)| *name != ColumnName::Number(0)).and_then(|(name, target)| {
            Some((name, known.into_iter().find(|known| known.name == target)?))
        });
    found.ok_or_else(|| refusals::no_readings(shown(text)))
}

/// The values of a list: below the name of the column, or from the first number in it.
fn captures<'a>(
    (name, column): &ListColumn,
    source: &'a Source,
    decimal: Option<Decimal>,
) -> Result<Vec<Capture<'a>>, Problems> {
    let all = content(source, decimal)?;
    let (words, found) = match name {
        ColumnName::Text(name) => {
            let place = |line: &Line<'_>| line.cells().iter().position(|cell| cell == name);
            let found = all.iter().zip(1..).find_map(|(line, below)| Some((place(line)?, below)));
            (shown(name), found)
        }
        ColumnName::Number(number) => {
            let is_number = |cell: &Cow<'_, str>| written_number(cell, true).is_some();
            let has_one = |line: &Line<'_>| line.cells().get(number - 1).is_some_and(is_number);
            let start = all.iter().position(has_one);
            (format!("#{number}"), start.map(|start| (number - 1, start)))
        }
    };
    let Some((index, start)) = found else {
        return Err(refusals::no_list_column(&source.name, words).into());
    };
    let mut problems = Problems::none();
    let expected =
        "every line below the first value holds one: a missing capture is never filled in";
    let captures = all[start..].iter().filter_map(|line| {
        let cells = line.cells();
        let cell = cells.get(index).map_or("", |cell| cell);
        let at = index.min(cells.len() - 1);
        let number = line.number_in(at, cell, &words, expected, &mut problems)?;
        Some((*line, number * column.factor()))
    });
    let captures = captures.collect();
    problems.or_ok(captures)
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
