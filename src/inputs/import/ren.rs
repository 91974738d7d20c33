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
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Passes, Way};
use crate::inputs::import::stated::{Format, SIGN, Stated, UNIT, VALUES, Values};
use crate::inputs::import::words::{AGAIN, Fields, Piece, lines, rows};
use crate::text::delimited::{LengthUnit, plain_number};
use crate::text::document::{LARGEST_NUMBER, Source};
use crate::text::problem::{Problem, Problems, shown};

/// Positions are compared to a tenth of a micrometre.
const SAME_MM: f64 = 1e-4;
const SAVE_SO: &str = "save the table again so, or the measurement itself (`.rtl`)";
const SEPARATE: &str =
    "save separate forward and reverse tables, or the measurement itself (`.rtl`)";
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

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let lines = lines(source);
    let heading = lines.iter().position(is_heading);
    let (above, below) = lines.split_at(heading.unwrap_or(lines.len()));
    let mut header = Fields::of(above);
    header.0.retain(|(_, value)| !value.text.is_empty());
    let mut problems = Problems::none();
    let passes = problems.take(passes(source, below));
    let term = stated.required_term(Format::Ren, &mut problems);
    let sign = problems
        .take(begins(&header, "Sign convention", SIGNS))
        .and_then(|found| SIGN.settled(found, stated.sign, stated, &mut problems));
    let unit_um = |text: &str| {
        let (number, unit) = length(text)?;
        (number > 0.0).then(|| number * unit.um())
    };
    let expected = "e.g. `1 mm` or `0.001 mm`";
    let unit_um = problems
        .take(line_of(&header, "Compensation resolution", expected, unit_um))
        .and_then(|found| {
            let said = stated.unit.map(LengthUnit::um);
            UNIT.settled(found, said, stated, &mut problems)
        });
    if let Some(found) = problems.take(begins(&header, "Compensation type", ABSOLUTE)) {
        VALUES.settled(found, stated.values, stated, &mut problems);
    }
    let (Some(mut passes), Some(unit_um)) = (passes, unit_um) else {
        return Err(problems);
    };
    refuse_backlash(&header, &passes, &mut problems);
    refuse_missing_ends(&header, &passes, &mut problems);
    passes.scale(unit_um);
    let said = FileContents::saying(header.said(&COPIED));
    let directed = stated.targets_run.filter(|_| !is_combined(&passes));
    let way = directed.map(|moves| ImportFinding::ForwardIs { moves });
    passes.reading((term, sign), said, way.into_iter().collect(), stated, problems)
}

fn is_heading(line: &Piece<'_>) -> bool {
    let text = line.text.trim().to_lowercase();
    text.starts_with("no") && text.contains("axis position")
}

/// The meaning of a line above the table, and where it stands; `None` = there is no such line.
fn line_of<'a, T>(
    header: &Fields<'a>,
    label: &str,
    expected: &str,
    read: impl Fn(&str) -> Option<T>,
) -> Result<Option<(T, Piece<'a>)>, Problem> {
    let Some(line) = header.value(label) else {
        return Ok(None);
    };
    let meaning = read(line.text).map(|meaning| Some((meaning, line)));
    meaning.ok_or_else(|| line.unexpected(&format!("`{label}`"), expected, SAVE_SO))
}

/// Likewise, by how its text begins.
fn begins<'a, T: Copy>(
    header: &Fields<'a>,
    label: &str,
    known: &[(&str, T)],
) -> Result<Option<(T, Piece<'a>)>, Problem> {
    let words: Vec<String> = known.iter().map(|(begin, _)| format!("`{begin}`")).collect();
    let expected = format!("a text that begins with {}", words.join(" or "));
    line_of(header, label, &expected, |text| {
        let text = text.to_lowercase();
        let mut known = known.iter();
        known.find(|(begin, _)| text.starts_with(&begin.to_lowercase())).map(|(_, what)| *what)
    })
}

/// Number and unit of a length such as `-100 mm`.
fn length(text: &str) -> Option<(f64, LengthUnit)> {
    let number = text.trim_end_matches(char::is_alphabetic);
    let unit = LengthUnit::from_text(&text[number.len()..])?;
    let number = plain_number(number.trim()).filter(|n| n.abs() <= LARGEST_NUMBER)?;
    Some((number, unit))
}

/// The table from its heading on, its values as they stand in the file.
fn passes(source: &Source, table: &[Piece<'_>]) -> Result<Passes, Problems> {
    let Some((heading, lines)) = table.split_first() else {
        return Err(Problem::new("there is no table with the heading `No.  Axis position`")
            .at(source.place(&(0..0)))
            .help("other layouts of compensation tables are not known: save the measurement itself (`.rtl`)")
            .into());
    };
    let text = heading.text.to_lowercase();
    let behind = text.split("axis position").nth(1).unwrap_or_default();
    let ways = match behind.split_whitespace().collect::<Vec<&str>>()[..] {
        ["combined"] => vec![Way::Both],
        ["forward", "reverse"] => vec![Way::Forward, Way::Reverse],
        ["reverse", "forward"] => vec![Way::Reverse, Way::Forward],
        _ => {
            let message = format!(
                "the columns are `{}`, expected `Combined`, or `Forward` and `Reverse`",
                shown(behind.trim())
            );
            return Err(heading.problem(message, "save the table again with these columns").into());
        }
    };
    let lines = lines.iter().filter(|line| !line.is_blank());
    let rows = rows(lines, ways.len() + 2, char::is_whitespace)?;
    let mut problems = Problems::none();
    for (row, expected) in rows.iter().zip(1_u32..) {
        let (words, number) = (row.line.words(char::is_whitespace), row.numbers[0]);
        if (number - f64::from(expected)).abs() > 0.0 {
            let message = format!("point {number} stands where point {expected} is expected");
            problems.push_with(|| words[0].problem(message, AGAIN));
        }
    }
    let column = |index: usize| rows.iter().map(|row| row.numbers[index]).collect::<Vec<f64>>();
    let ways = ways.into_iter().zip(2..).map(|(way, index)| (way, vec![column(index)])).collect();
    problems.or_ok(Passes { targets: column(1), place: heading.place(), ways })
}

/// Whether one curve holds for both directions.
fn is_combined(passes: &Passes) -> bool {
    passes.ways.iter().any(|(way, _)| *way == Way::Both)
}

/// A combined table may leave out a backlash that stands in a line of its own.
fn refuse_backlash(header: &Fields<'_>, passes: &Passes, problems: &mut Problems) {
    match header.value("Backlash error") {
        Some(line) => {
            let first = line.text.split_whitespace().next().unwrap_or_default();
            if !first.eq_ignore_ascii_case("n/a") && plain_number(first) != Some(0.0) {
                let found = shown(line.text);
                let message = format!(
                    "the table leaves out a backlash of `{found}`, whose sense is not known"
                );
                problems.push(line.problem(message, SEPARATE));
            }
        }
        None if is_combined(passes) => {
            let message = "there is no line `Backlash error`, so it is not known whether the combined table leaves out a backlash";
            problems.push(Problem::new(message).at(passes.place.clone()).help(SEPARATE));
        }
        None => {}
    }
}

/// Spacing, first and last position must be those of the header: else rows are missing or were changed.
fn refuse_missing_ends(header: &Fields<'_>, passes: &Passes, problems: &mut Problems) {
    let mm = |text: &str| length(text).filter(|(_, unit)| *unit == LengthUnit::Mm);
    let targets = &passes.targets;
    let spacing = problems.take(line_of(header, "Compensation spacing", "a number and `mm`", mm));
    if let Some(Some(((spacing, _), line))) = spacing {
        let differs = |step: f64| (step.abs() - spacing.abs()).abs() > SAME_MM;
        for pair in targets.windows(2).filter(|pair| differs(pair[1] - pair[0])) {
            let (from, to) = (pair[0], pair[1]);
            let message = format!(
                "the table goes from {from} to {to} mm, expected a spacing of {spacing} mm"
            );
            problems.push_with(|| line.problem(message, AGAIN));
        }
    }
    for (label, found) in
        [("Compensation start", targets.first()), ("Compensation end", targets.last())]
    {
        match problems.take(line_of(header, label, "a number and `mm`", mm)) {
            Some(Some(((expected, _), line)))
                if found.is_none_or(|found| (found - expected).abs() > SAME_MM) =>
            {
                let found = found.map_or("nothing".to_string(), |found| format!("{found} mm"));
                let message = format!(
                    "the table has {found} at this end, expected {expected} mm as in `{label}`"
                );
                problems.push(line.problem(message, AGAIN));
            }
            Some(None) => {
                let message = format!(
                    "there is no line `{label}`, so it cannot be seen whether rows are missing"
                );
                problems.push(Problem::new(message).at(passes.place.clone()).help(AGAIN));
            }
            _ => {}
        }
    }
}
