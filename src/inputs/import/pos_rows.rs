//! The measured rows of a `.pos` file.

use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{Passes, Way};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::words::{AGAIN, Piece};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};

/// Columns that the measurement itself needs: position, reading, error, status.
const NEEDED: [&str; 4] = ["Position", "LasRead", "LinearError", "Status"];
/// What the file calls its laser states.
const STATES: [&str; 5] = ["Laser Normal", "Warm Up", "Path Error", "Over Speed", "Wireless Error"];
const NORMAL: f64 = 0.0;
const WARM_UP: f64 = 1.0;
/// A sensor that is not connected; the footer says `N/A` then.
const NO_SENSOR: f64 = -1.0;

/// A row of numbers, in the file's unit.
pub(super) struct Row<'a> {
    pub(super) line: Piece<'a>,
    numbers: Vec<f64>,
    /// One unit of the last decimal of each.
    digits: Vec<f64>,
}

/// The rows below a heading, as far as they begin with numbers.
fn rows_below<'a>(lines: &[Piece<'a>], columns: usize) -> Result<Vec<Row<'a>>, Problems> {
    let mut problems = Problems::none();
    let mut rows = Vec::new();
    for line in lines.iter().take_while(|line| line.begins_with_number()) {
        let words = line.row(columns, char::is_whitespace, &mut problems);
        let words = words.unwrap_or_default();
        let numbers = words.iter().filter_map(|word| word.number("a value", &mut problems));
        rows.push(Row {
            line: *line,
            numbers: numbers.collect(),
            digits: words.iter().map(|word| last_digit(word.text)).collect(),
        });
    }
    problems.or_ok(rows)
}

/// One unit of the last decimal of a number.
fn last_digit(text: &str) -> f64 {
    let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    (0..decimals).fold(1.0, |digit, _| digit / 10.0)
}

/// Numbers that were written alike.
fn is(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.0
}

/// What was measured.
pub(super) struct Measured<'a> {
    pub(super) heading: Piece<'a>,
    columns: Vec<&'a str>,
    /// Where the columns of the measurement stand.
    at: [usize; 4],
    pub(super) rows: Vec<Row<'a>>,
}

impl<'a> Measured<'a> {
    pub(super) fn read(lines: &[Piece<'a>], source: &Source) -> Result<Self, Problems> {
        let names = |line: &Piece<'a>| -> Vec<&'a str> {
            let words = line.words(char::is_whitespace);
            words.iter().map(|word| word.text).collect()
        };
        for (number, heading) in lines.iter().enumerate() {
            let columns = names(heading);
            let at = NEEDED.map(|name| columns.iter().position(|column| *column == name));
            if let [Some(position), Some(reading), Some(error), Some(status)] = at {
                let rows = rows_below(&lines[number + 1..], columns.len())?;
                return Ok(Measured {
                    heading: *heading,
                    columns,
                    at: [position, reading, error, status],
                    rows,
                });
            }
        }
        let message = format!(
            "there is no table with the columns {}: the file holds no measured rows",
            NEEDED.join(", ")
        );
        let help =
            "save the measurement with its readings, or map the columns of a CSV with `--columns`";
        Err(Problem::new(message).at(source.place(&(0..0))).help(help).into())
    }

    /// The position of a row, and one unit of its last decimal.
    pub(super) fn position(&self, row: &Row<'_>) -> (f64, f64) {
        let [position, ..] = self.at;
        (row.numbers[position], row.digits[position])
    }

    /// Error = ± reading − position within the decimals of all rows: the reading with its sign. Another row
    /// was changed.
    pub(super) fn relation(&self, changed: &str) -> Result<&'static str, Problems> {
        let [position, reading, error, _] = self.at;
        let expected =
            |row: &Row<'_>, sign: f64| sign * row.numbers[reading] - row.numbers[position];
        let misses = |sign: f64| {
            let fits = |row: &&Row<'_>| {
                // Half a digit each, and the binary dust of the difference.
                let digits = row.digits[position] + row.digits[reading] + row.digits[error];
                (expected(row, sign) - row.numbers[error]).abs() <= digits / 2.0 + 1e-9
            };
            let missed: Vec<&Row<'_>> = self.rows.iter().filter(|row| !fits(row)).collect();
            missed
        };
        let (direct, turned) = (misses(1.0), misses(-1.0));
        let (missed, sign, word) = if turned.len() < direct.len() {
            (turned, -1.0, "−LasRead")
        } else {
            (direct, 1.0, "LasRead")
        };
        let Some(first) = missed.first() else {
            return Ok(word);
        };
        let message = format!(
            "{} of {} rows contradict themselves: here the error is {}, but reading less position is {:.6}",
            missed.len(),
            self.rows.len(),
            first.numbers[error],
            expected(first, sign)
        );
        Err(first.line.problem(message, changed).into())
    }

    /// Readings that the laser itself calls bad.
    pub(super) fn refuse_bad_status(&self, problems: &mut Problems) {
        let [.., at] = self.at;
        let is_bad =
            |row: &&Row<'_>| ![NORMAL, WARM_UP].iter().any(|good| is(row.numbers[at], *good));
        let Some(row) = self.rows.iter().find(is_bad) else {
            return;
        };
        let status = row.numbers[at];
        let mut states = STATES.iter().zip(0_u8..);
        let state = states.find(|(_, number)| is(f64::from(*number), status));
        let message = format!(
            "the laser's status is {status} ({}) in {} of {} rows",
            state.map_or("unknown", |(words, _)| words),
            self.rows.iter().filter(is_bad).count(),
            self.rows.len()
        );
        let help = "such a reading is no measurement: measure the run again";
        problems.push(row.line.problem(message, help));
    }

    pub(super) fn warm_up(&self) -> Option<ImportFinding> {
        let [.., status] = self.at;
        let is_warming = |row: &&Row<'_>| is(row.numbers[status], WARM_UP);
        let (rows, of) = (self.rows.iter().filter(is_warming).count(), self.rows.len());
        (rows > 0).then_some(ImportFinding::WarmingUp { rows, of })
    }

    /// The passes of some targets each: forward where the positions are those of the first one, reverse
    /// where they come the other way round.
    pub(super) fn sorted(&self, targets: usize) -> Result<Passes, Problems> {
        let [position, _, error, _] = self.at;
        let column = |pass: &[Row<'_>], index: usize| -> Vec<f64> {
            pass.iter().map(|row| row.numbers[index]).collect()
        };
        let targets = column(&self.rows[..targets], position);
        let same = |found: &[f64]| found.iter().zip(&targets).all(|(a, b)| is(*a, *b));
        let (mut forward, mut reverse) = (Vec::new(), Vec::new());
        for pass in self.rows.chunks(targets.len()) {
            let mut found = column(pass, position);
            let mut errors = column(pass, error);
            if same(&found) {
                forward.push(errors);
                continue;
            }
            found.reverse();
            errors.reverse();
            if !same(&found) {
                let message = "a run has other positions than the first one";
                return Err(pass[0].line.problem(message, AGAIN).into());
            }
            reverse.push(errors);
        }
        let mut ways = vec![(Way::Forward, forward), (Way::Reverse, reverse)];
        ways.retain(|(_, runs)| !runs.is_empty());
        let place = self.heading.place();
        Ok(Passes { targets, place, ways })
    }

    /// Names and columns of air and material, and whether a sensor was connected.
    fn sensors(&self) -> impl Iterator<Item = (&'a str, Option<String>)> {
        let others = self.columns.iter().enumerate();
        let others = others.filter(|(index, _)| !self.at.contains(index));
        others.map(|(index, name)| (*name, self.range(index)))
    }

    /// The values of a column in words; `None` = there was no sensor.
    fn range(&self, index: usize) -> Option<String> {
        let values = || self.rows.iter().map(|row| row.numbers[index]);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let words = if low < high { format!("{low} … {high}") } else { low.to_string() };
        values().any(|value| !is(value, NO_SENSOR)).then_some(words)
    }

    /// The file names no unit of its temperatures.
    pub(super) fn material_warning(
        &self,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<ImportFinding> {
        let mut sensors = self.sensors();
        let material =
            sensors.find(|(name, values)| name.starts_with("MatTemp") && values.is_some());
        let (name, values) = material?;
        let noted =
            format!("a temperature of the material ({name} {})", values.unwrap_or_default());
        let stake = "the file names no unit of it";
        stated.material_warning(&noted, self.heading.place(), stake, problems)
    }

    /// Air and material as the file has them; it names no unit of theirs.
    pub(super) fn surroundings(&self) -> impl Iterator<Item = ImportFinding> {
        let (mut values, mut sensors) = (Vec::new(), Vec::new());
        for (name, range) in self.sensors() {
            match range {
                None => sensors.push(name.to_string()),
                Some(range) => values.push(format!("{name} {range}")),
            }
        }
        let noted = (!values.is_empty()).then_some(ImportFinding::Surroundings { values });
        let absent = (!sensors.is_empty()).then_some(ImportFinding::NotMeasured { sensors });
        noted.into_iter().chain(absent)
    }
}
