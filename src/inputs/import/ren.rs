//! Renishaw compensation table (`.ren`): a table that was already made for a control.
//!
//! ```text
//!   Compensation type       : Absolute
//!   Compensation resolution : 1 mm          ← one unit of the values
//!   Sign convention         : As errors
//!   No.  Axis position  Forward  Reverse    ← or: Combined
//! ```
//! Type, unit and sign come from these lines; where one is absent it has to be stated.

use crate::control::controller::TableSign;
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Fields, Intake, Piece};
use crate::inputs::import::reading::Passes;
use crate::inputs::import::stated::{UNIT, VALUES, Values};
use crate::inputs::refusals::{self, SAVE_SO};
use crate::quantity::Pass;
use crate::text::{LARGEST_NUMBER, LengthUnit, Problem, plain_number, shown};

/// Positions are compared to a tenth of a micrometre.
const SAME_MM: f64 = 1e-4;
/// Lines above the table that are copied into ours.
const COPIED: [&str; 7] = [
    "Test name",
    "Table type",
    "Compensation type",
    "Compensation resolution",
    "Sign convention",
    "Reference position",
    "Backlash error",
];
/// How the texts of `Sign convention` begin.
const SIGNS: &[(&str, TableSign)] = &[
    ("As error", TableSign::AsError),
    ("As comp", TableSign::AsCorrection),
    ("As correction", TableSign::AsCorrection),
];
const ABSOLUTE: &[(&str, Values)] = &[("Absolute", Values::Absolute)];

pub(super) fn read<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let lines = intake.lines();
    let (above, below) = lines.split_at(lines.iter().position(is_heading).unwrap_or(lines.len()));
    let mut fields = Fields::of(above);
    fields.0.retain(|(_, value)| !value.text.is_empty());
    let header = Header { fields, place: below.first().copied() };
    let passes = passes(intake, below);
    let term = intake.term();
    let sign = header.begins("Sign convention", SIGNS).and_then(|found| intake.sign(found));
    let unit_um = |text: &str| {
        let (number, unit) = length(text)?;
        (number > 0.0).then(|| number * unit.um())
    };
    let stated = intake.stated;
    let unit_um = header
        .line("Compensation resolution", "e.g. `1 mm` or `0.001 mm`", unit_um)
        .and_then(|found| intake.settled(&UNIT, found, stated.unit.map(LengthUnit::um)));
    if let Some(found) = header.begins("Compensation type", ABSOLUTE) {
        intake.settled(&VALUES, found, stated.values);
    }
    let (mut passes, unit_um) = (passes?, unit_um?);
    let is_combined = passes.ways.iter().any(|(way, _)| way.is_none());
    header.refuse_backlash(is_combined);
    header.refuse_missing_rows(&passes.targets);
    passes.ways.iter_mut().flat_map(|(_, runs)| runs).flatten().for_each(|value| *value *= unit_um);
    intake.say(header.fields.said(&COPIED));
    let directed = stated.targets_run.filter(|_| !is_combined);
    let way = directed.map(|moves| ImportFinding::ForwardIs { moves });
    passes.contents(term, sign, way.into_iter().collect(), intake)
}

fn is_heading(line: &Piece<'_>) -> bool {
    let text = line.text.trim().to_lowercase();
    text.starts_with("no") && text.contains("axis position")
}

/// Number and unit of a length such as `-100 mm`.
fn length(text: &str) -> Option<(f64, LengthUnit)> {
    let number = text.trim_end_matches(char::is_alphabetic);
    let unit = LengthUnit::from_text(&text[number.len()..])?;
    let number = plain_number(number.trim()).filter(|n| n.abs() <= LARGEST_NUMBER)?;
    Some((number, unit))
}

/// The table from its heading on, its values as they stand in the file.
fn passes<'a>(intake: &'a Intake<'a>, table: &[Piece<'a>]) -> Option<Passes> {
    let Some((heading, lines)) = table.split_first() else {
        return intake.notes.refused(refusals::no_table().at(intake.top()));
    };
    let text = heading.text.to_lowercase();
    let behind = text.split("axis position").nth(1).unwrap_or_default();
    let ways = match behind.split_whitespace().collect::<Vec<&str>>()[..] {
        ["combined"] => vec![None],
        ["forward", "reverse"] => vec![Some(Pass::Forward), Some(Pass::Reverse)],
        ["reverse", "forward"] => vec![Some(Pass::Reverse), Some(Pass::Forward)],
        _ => {
            return heading.refused(refusals::other_columns(shown(behind.trim())));
        }
    };
    let lines: Vec<Piece<'a>> = lines.iter().filter(|line| !line.is_blank()).copied().collect();
    let mut columns = intake.numbers(&lines, ways.len() + 2, char::is_whitespace)?.into_iter();
    let (numbers, targets) = (columns.next()?, columns.next()?);
    let mut whole = Some(());
    for (line, (number, expected)) in lines.iter().zip(numbers.iter().zip(1_u32..)) {
        if (number - f64::from(expected)).abs() > 0.0 {
            let first = line.words(char::is_whitespace)[0];
            whole = first.refused(refusals::other_point(number, expected));
        }
    }
    let ways = ways.into_iter().zip(columns).map(|(way, values)| (way, vec![values])).collect();
    whole.map(|()| Passes { targets, place: heading.place(), ways })
}

/// The lines above the table.
struct Header<'a> {
    fields: Fields<'a>,
    /// Where the table is named.
    place: Option<Piece<'a>>,
}

impl<'a> Header<'a> {
    /// The meaning of a line, and where it stands: `Some(None)` = there is no such line.
    fn line<T>(
        &self,
        label: &str,
        expected: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Option<Option<(T, Piece<'a>)>> {
        let Some(line) = self.fields.value(label) else {
            return Some(None);
        };
        let meaning = line.read(&format!("`{label}`"), expected, SAVE_SO, read)?;
        Some(Some((meaning, line)))
    }

    /// Likewise, by how its text begins.
    fn begins<T: Copy>(&self, label: &str, known: &[(&str, T)]) -> Option<Option<(T, Piece<'a>)>> {
        let words: Vec<String> = known.iter().map(|(begin, _)| format!("`{begin}`")).collect();
        self.line(label, &format!("a text that begins with {}", words.join(" or ")), |text| {
            let is = |begin: &str| text.to_lowercase().starts_with(&begin.to_lowercase());
            known.iter().find(|(begin, _)| is(begin)).map(|(_, what)| *what)
        })
    }

    /// That something cannot be known of the table.
    fn lacks(&self, problem: Problem) {
        self.place.into_iter().for_each(|place| place.refuse(problem.clone()));
    }

    /// A combined table may leave out a backlash that stands in a line of its own.
    fn refuse_backlash(&self, is_combined: bool) {
        match self.fields.value("Backlash error") {
            Some(line) => {
                let first = line.text.split_whitespace().next().unwrap_or_default();
                if !first.eq_ignore_ascii_case("n/a") && plain_number(first) != Some(0.0) {
                    line.refuse(refusals::backlash(shown(line.text)));
                }
            }
            None if is_combined => self.lacks(refusals::backlash_unknown()),
            None => {}
        }
    }

    /// Spacing, first and last position must be those of the header: else rows are missing or were changed.
    fn refuse_missing_rows(&self, targets: &[f64]) {
        let mm = |label: &str| {
            let mm = |text: &str| length(text).filter(|(_, unit)| *unit == LengthUnit::Mm);
            let line = self.line(label, "a number and `mm`", mm)?;
            Some(line.map(|((mm, _), line)| (mm, line)))
        };
        let differ = |a: f64, b: f64| (a - b).abs() > SAME_MM;
        if let Some(Some((spacing, line))) = mm("Compensation spacing") {
            let is_off = |pair: &&[f64]| differ((pair[1] - pair[0]).abs(), spacing.abs());
            for pair in targets.windows(2).filter(is_off) {
                line.refuse(refusals::other_spacing(pair[0], pair[1], spacing));
            }
        }
        let ends = [("Compensation start", targets.first()), ("Compensation end", targets.last())];
        for (label, found) in ends {
            match mm(label) {
                Some(Some((mm, line))) if found.is_none_or(|found| differ(*found, mm)) => {
                    let found = found.map_or("nothing".to_string(), |found| format!("{found} mm"));
                    line.refuse(refusals::other_end(found, mm, label));
                }
                Some(None) => self.lacks(refusals::end_unknown(label)),
                _ => {}
            }
        }
    }
}
