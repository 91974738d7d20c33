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
use crate::inputs::import::words::{AGAIN, Fields, Piece, lines};
use crate::text::delimited::{LengthUnit, plain_number};
use crate::text::document::{LARGEST_NUMBER, Source};
use crate::text::problem::{Problem, Problems, shown};

/// Positions are compared to a tenth of a micrometre.
const SAME_MM: f64 = 1e-4;
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
const SIGNS: [(&str, TableSign); 3] = [
    ("As error", TableSign::AsError),
    ("As comp", TableSign::AsCorrection),
    ("As correction", TableSign::AsCorrection),
];

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
        .take(begins(&header, "Sign convention", &SIGNS))
        .and_then(|found| SIGN.settled(found, stated.sign, stated, &mut problems));
    let unit_um = problems.take(resolution_um(&header)).and_then(|found| {
        let said = stated.unit.map(LengthUnit::um);
        UNIT.settled(found, said, stated, &mut problems)
    });
    let absolute = [("Absolute", Values::Absolute)];
    if let Some(found) = problems.take(begins(&header, "Compensation type", &absolute)) {
        VALUES.settled(found, stated.values, stated, &mut problems);
    }
    let (Some(mut passes), Some(unit_um)) = (passes, unit_um) else {
        return Err(problems);
    };
    compare(&header, &passes, &mut problems);
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

/// The meaning of a text by its beginning, and where it stands; `None` = there is no such line.
fn begins<'a, T: Copy>(
    header: &Fields<'a>,
    label: &str,
    known: &[(&str, T)],
) -> Result<Option<(T, Piece<'a>)>, Problems> {
    let Some(line) = header.value(label) else {
        return Ok(None);
    };
    let text = line.text.to_lowercase();
    let is_begin = |(begin, _): &&(&str, T)| text.starts_with(&begin.to_lowercase());
    if let Some((_, meaning)) = known.iter().find(is_begin) {
        return Ok(Some((*meaning, line)));
    }
    let words: Vec<String> = known.iter().map(|(begin, _)| format!("`{begin}`")).collect();
    let expected = format!("a text that begins with {}", words.join(" or "));
    let label = format!("`{label}`");
    Err(line.unexpected(&label, &expected, SAVE_SO).into())
}

const SAVE_SO: &str = "save the table again so, or the measurement itself (`.rtl`)";

/// Micrometres of one unit of the values, and where that stands; `None` = there is no such line.
fn resolution_um<'a>(header: &Fields<'a>) -> Result<Option<(f64, Piece<'a>)>, Problems> {
    let label = "Compensation resolution";
    let Some(line) = header.value(label) else {
        return Ok(None);
    };
    match length(line.text).filter(|(number, _)| *number > 0.0) {
        Some((number, unit)) => Ok(Some((number * unit.um(), line))),
        None => {
            let expected = "e.g. `1 mm` or `0.001 mm`";
            Err(line.unexpected(&format!("`{label}`"), expected, SAVE_SO).into())
        }
    }
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
    let Some((heading, rows)) = table.split_first() else {
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
    let mut problems = Problems::none();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); ways.len() + 1];
    let rows = rows.iter().filter(|line| !line.is_blank());
    for (line, expected) in rows.zip(1..) {
        let width = columns.len() + 1;
        let Some(words) = line.row(width, char::is_whitespace, &mut problems) else {
            continue;
        };
        let number = words[0].count("the number of a point", &mut problems);
        if number.is_some_and(|number| number != expected) {
            let message =
                format!("point {} stands where point {expected} is expected", words[0].text);
            problems.push_with(|| words[0].problem(message, AGAIN));
        }
        for (column, word) in columns.iter_mut().zip(&words[1..]) {
            column.extend(word.number("a value", &mut problems));
        }
    }
    let mut columns = columns.into_iter();
    problems.or_ok(Passes {
        targets: columns.next().unwrap_or_default(),
        place: heading.place(),
        ways: ways.into_iter().zip(columns.map(|values| vec![values])).collect(),
    })
}

/// Whether one curve holds for both directions.
fn is_combined(passes: &Passes) -> bool {
    passes.ways.iter().any(|(way, _)| *way == Way::Both)
}

/// What the lines above the table say of it: its columns, a backlash beside it, ends and spacing.
fn compare(header: &Fields<'_>, passes: &Passes, problems: &mut Problems) {
    let combined = is_combined(passes);
    let table_type = header.value("Table type");
    if let Some(line) =
        table_type.filter(|line| line.text.to_lowercase().contains("combined") != combined)
    {
        let columns = if combined { "`Combined`" } else { "`Forward` and `Reverse`" };
        let found = shown(line.text);
        let message = format!("the file says `{found}`, but its columns are {columns}");
        let help = "save the table again: which of the two holds is not known";
        problems.push(line.problem(message, help));
    }
    refuse_backlash(header, passes, problems);
    let targets = &passes.targets;
    compare_end(header, "Compensation start", (passes, targets.first()), problems);
    compare_end(header, "Compensation end", (passes, targets.last()), problems);
    compare_spacing(header, targets, problems);
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

fn compare_spacing(header: &Fields<'_>, targets: &[f64], problems: &mut Problems) {
    let Some((line, spacing)) = millimetres(header, "Compensation spacing", problems) else {
        return;
    };
    let differs = |step: f64| (step.abs() - spacing.abs()).abs() > SAME_MM;
    for pair in targets.windows(2).filter(|pair| differs(pair[1] - pair[0])) {
        let (from, to) = (pair[0], pair[1]);
        let message =
            format!("the table goes from {from} to {to} mm, expected a spacing of {spacing} mm");
        problems.push_with(|| line.problem(message, AGAIN));
    }
}

/// First and last position must be those of the header: else rows are missing.
fn compare_end(
    header: &Fields<'_>,
    label: &str,
    (passes, found): (&Passes, Option<&f64>),
    problems: &mut Problems,
) {
    if header.value(label).is_none() {
        let message =
            format!("there is no line `{label}`, so it cannot be seen whether rows are missing");
        problems.push(Problem::new(message).at(passes.place.clone()).help(AGAIN));
    }
    let Some((line, expected)) = millimetres(header, label, problems) else {
        return;
    };
    if found.is_none_or(|found| (found - expected).abs() > SAME_MM) {
        let found = found.map_or("nothing".to_string(), |found| format!("{found} mm"));
        let message =
            format!("the table has {found} at this end, expected {expected} mm as in `{label}`");
        problems.push(line.problem(message, AGAIN));
    }
}

/// A length of the header in millimetres, if it is there.
fn millimetres<'a>(
    header: &Fields<'a>,
    label: &str,
    problems: &mut Problems,
) -> Option<(Piece<'a>, f64)> {
    let line = header.value(label)?;
    let found = length(line.text).filter(|(_, unit)| *unit == LengthUnit::Mm);
    if found.is_none() {
        problems.push(line.unexpected(&format!("`{label}`"), "a number and `mm`", SAVE_SO));
    }
    found.map(|(mm, _)| (line, mm))
}
