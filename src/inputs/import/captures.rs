//! Lists of captures, as an instrument saved them → the cells of a form.
//!
//! ```text
//!  form: rows in the order of the captures ─┐
//!  a list for each set-up: values in order ─┴─→ as many as rows? ─→ the form, filled in
//! ```
//! A list says nothing of where its values were taken, so it has to have one for each capture. One too few or
//! too many is located and named, and never filled in or left out.

use crate::inputs::import::encoding::{Measurement, text_of};
use crate::inputs::import::form::{Capture, DISPLACEMENT, Form, ListColumn, Row};
use crate::inputs::import::intake::Intake;
use crate::inputs::import::located::Located;
use crate::inputs::import::stated::{CAPTURES, Counting, Format, Stated};
use crate::inputs::readings::Readings;
use crate::inputs::refusals;
use crate::quantity::{Diagonal, Figure, rounded};
use crate::text::{Line, Problem, Problems, Source, plain};
use std::collections::HashMap;

/// A list, and the diagonal of which it is; `None` = of one axis.
pub type List<'a> = (Option<Diagonal>, Measurement<'a>);

/// Fills a form in, and gives its text; everything that is wrong is told at once.
pub fn fill(
    source: &Source,
    lists: &[List<'_>],
    encoding: Option<&'static encoding_rs::Encoding>,
    stated: &Stated,
) -> Result<String, Problems> {
    let intake = Intake::of(source, stated, Format::List);
    let text = filled(&intake, lists, encoding);
    intake.end(text).map(|(text, _)| text)
}

fn filled(
    intake: &Intake<'_>,
    lists: &[List<'_>],
    encoding: Option<&'static encoding_rs::Encoding>,
) -> Option<String> {
    let (source, stated) = (intake.source, intake.stated);
    let column = intake.notes.take(ListColumn::stated(stated));
    let counting = intake.settled(&CAPTURES, None, stated.captures);
    let form = intake.notes.take(Form::read(source));
    let filling = Filling { form: form?, column: column?, counting: counting? };
    filling.refuse_other_lists(lists, intake);
    let mut values = Vec::new();
    for (of, file) in lists {
        let taken = text_of(*file, encoding, stated).and_then(|(list, _)| {
            let captures = filling.column.captures(&list, stated.decimal)?;
            Ok(filling.values(*of, &captures)?)
        });
        values.extend(intake.notes.take(taken).unwrap_or_default());
    }
    let text = intake.if_sound(filling.text(source, &values, lists, stated))?;
    if !filling.form.of_axis() {
        let filled = Source::from_bytes(&source.name, text.as_bytes());
        intake.notes.take(filled.and_then(|filled| Readings::look_at_cells(&filled)));
    }
    Some(text)
}

/// A form while it is filled in.
struct Filling<'a> {
    form: Form<'a>,
    column: ListColumn,
    counting: Counting,
}

impl Filling<'_> {
    /// A form of diagonals takes a list of each, that of an axis one.
    fn refuse_other_lists(&self, lists: &[List<'_>], intake: &Intake<'_>) {
        let wanted: Vec<Option<Diagonal>> = match self.form.of_axis() {
            true => vec![None],
            false => Diagonal::ALL.map(Some).to_vec(),
        };
        let refuse = |of: Option<Diagonal>, words: &str| {
            let name = of.map(|of| format!("`--{} FILE`", of.name().to_ascii_lowercase()));
            let name = name.unwrap_or("FILE alone".to_string());
            intake.notes.refuse(refusals::other_list(words, name).at(self.form.header.whole()));
        };
        let given: Vec<Option<Diagonal>> = lists.iter().map(|(of, _)| *of).collect();
        let is_empty = |of: &Option<Diagonal>| self.form.rows_of(*of).is_empty();
        let lacking = wanted.iter().filter(|of| !given.contains(of) && !is_empty(of));
        lacking.for_each(|of| refuse(*of, "needs a"));
        given.iter().filter(|of| !wanted.contains(of)).for_each(|of| refuse(*of, "takes no"));
    }

    /// Number of each line of the form and its value, µm, from as many captures as the form has.
    fn values(
        &self,
        of: Option<Diagonal>,
        captures: &[Capture<'_>],
    ) -> Result<Vec<(usize, f64)>, Problem> {
        let rows = self.form.rows_of(of);
        let mut um: Vec<f64> = captures.iter().map(|capture| capture.um).collect();
        if self.counting == Counting::Incremental {
            um.insert(0, 0.0);
            (1..um.len()).for_each(|at| um[at] += um[at - 1]);
        }
        if um.len() != rows.len() {
            let (at, problem) = self.off(of, &rows, &um);
            let first = um.len() - captures.len();
            let capture = at.and_then(|at| captures.get(at.saturating_sub(first)));
            return Err(capture.map_or(problem.clone(), |own| problem.at(own.line.whole())));
        }
        let first_um = rows.first().map_or(0.0, |row| row.target_um);
        let way = |row: &Row<'_>| {
            if self.with_targets() { row.target_um - first_um } else { 0.0 }
        };
        let rows = rows.iter().zip(um);
        Ok(rows.map(|(row, um)| (row.line.number(), um - way(row))).collect())
    }

    /// Whether the values hold the way to the target.
    fn with_targets(&self) -> bool {
        self.form.of_axis() && self.column.column.content == DISPLACEMENT
    }

    /// What is wrong with the number of values, and the value at which it shows.
    fn off(&self, of: Option<Diagonal>, rows: &[&Row<'_>], um: &[f64]) -> (Option<usize>, Problem) {
        let (found, expected) = (um.len(), rows.len());
        let walk = self.form.expected(rows, self.with_targets());
        let name = |place: usize| rows.get(place).map_or(String::new(), |row| self.form.name(row));
        let value = |place: usize| {
            format!("value {}, at {}", place + 1, name(place.min(expected.saturating_sub(1))))
        };
        let (what, (at, help)) = match found.abs_diff(expected) {
            1 if found < expected => {
                let (at, help) = told(walk.missing(um), name);
                ("one is missing".to_string(), (at.map(|at| at.saturating_sub(1)), help))
            }
            1 => ("one is too many".to_string(), told(walk.surplus(um), value)),
            many => {
                let what = if found < expected { "missing" } else { "too many" };
                let help = "only a single one can be located: measure this set-up again, and look at `--captures`";
                (format!("{many} are {what}"), (None, help.to_string()))
            }
        };
        let of = of.map_or("the axis".to_string(), |diagonal| diagonal.to_string());
        (at, refusals::other_captures(of, found, expected, what, help))
    }

    /// The form with its values; comments say where they are from.
    fn text(
        &self,
        form: &Source,
        values: &[(usize, f64)],
        lists: &[List<'_>],
        stated: &Stated,
    ) -> String {
        let (heading, factor) = match self.form.of_axis() {
            true => ("deviation_um", 1.0),
            false => (&*self.column.column.name, self.column.column.factor()),
        };
        let kept = form.text.lines().filter(|line| line.starts_with('#'));
        let kept = kept.map(|line| plain::comment(line.strip_prefix("# ").unwrap_or(&line[1..])));
        let sources = lists.iter().map(|(_, file)| file.comment());
        let own = sources.chain(stated.comments()).map(|words| plain::comment(&words));
        let with_last = |line: &Line<'_>, last: String| {
            let cells = line.cells();
            let cells = cells.iter().take(cells.len() - 1).map(ToString::to_string);
            let cells: Vec<String> = cells.chain([last]).collect();
            cells.join(&char::from(self.form.header.delimiter()).to_string())
        };
        let header = with_last(&self.form.header, heading.to_string());
        let values: HashMap<usize, f64> = values.iter().copied().collect();
        let rows = self.form.rows.iter().map(|row| {
            let own = values.get(&row.line.number());
            let value = own.map(|um| Figure(rounded(um / factor, 9)).to_string());
            with_last(&row.line, value.unwrap_or_default())
        });
        let lines: Vec<String> = kept.chain(own).chain([header]).chain(rows).collect();
        lines.join("\n") + "\n"
    }
}

/// Odds beyond which nobody needs the figure.
const CERTAIN: f64 = 1e9;
/// Places that are named one by one; of more the first and the last are.
const MOST_NAMED: usize = 3;
/// With more of them it is not told which.
const MOST_TOLD: usize = 24;

/// Where it is, with its odds, in words.
fn told(located: Option<Located>, name: impl Fn(usize) -> String) -> (Option<usize>, String) {
    const AGAIN: &str = "nothing is filled in or left out: measure this set-up again";
    let Some(Located { places, odds }) = located else {
        return (None, format!("the values are too few to tell which; {AGAIN}"));
    };
    let count = places.len();
    let first = places.iter().copied().min().unwrap_or_default();
    let last = places.iter().copied().max().unwrap_or_default();
    if count > MOST_TOLD || last - first > 2 * count {
        return (None, format!("which cannot be told, {count} places fit about equally; {AGAIN}"));
    }
    let names = match count > MOST_NAMED {
        true => format!("one of {count} from {} to {}", name(first), name(last)),
        false => places.iter().map(|place| name(*place)).collect::<Vec<_>>().join(" or "),
    };
    let odds = match odds > CERTAIN {
        true => "more than 10⁹".to_string(),
        false => format!("{odds:.0}"),
    };
    let words = format!("most likely it is {names}, {odds} : 1 against any other place; {AGAIN}");
    (places.first().copied(), words)
}
