//! The two tables of a `.pos` file: measured rows, and the maker's averages.

use crate::inputs::import::lines::{Line, lines, looks_like_number};
use crate::inputs::import::pos_header::{AGAIN, Header};
use crate::text::delimited::plain_number;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};

pub(super) const CHANGED: &str = "the file was edited: save it again, or take the maker's averages with `--rows averages` if they are what was changed on purpose";
/// Columns that the measurement itself needs.
const POSITION: &str = "Position";
const READING: &str = "LasRead";
const ERROR: &str = "LinearError";
const STATUS: &str = "Status";
/// What the file calls its laser states.
const STATES: [&str; 5] = [
    "Laser Normal",
    "Warm Up",
    "Path Error",
    "Over Speed",
    "Wireless Error",
];
const NORMAL: f64 = 0.0;
const WARM_UP: f64 = 1.0;
/// A sensor that is not connected; the footer says `N/A` then.
const NO_SENSOR: f64 = -1.0;
/// The maker's program rounds position + error to a number of 24 binary digits.
const SINGLE_PRECISION: f64 = 1.0 / (1 << 23) as f64;

/// How the errors follow from the laser's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    /// Error = reading − position.
    Direct,
    /// Error = −reading − position: the laser counts against the positions.
    Turned,
}

impl Relation {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Relation::Direct => "LasRead",
            Relation::Turned => "−LasRead",
        }
    }

    fn factor(self) -> f64 {
        match self {
            Relation::Direct => 1.0,
            Relation::Turned => -1.0,
        }
    }
}

/// One measured row, in the file's unit.
pub(super) struct Row {
    pub(super) place: Place,
    pub(super) position: f64,
    /// One unit of the last decimal of the position.
    pub(super) position_digit: f64,
    reading: f64,
    error: f64,
    /// Half a unit of the last decimal of each of the three.
    rounding: f64,
    status: f64,
    /// In the order of [`Measured::columns`].
    others: Vec<f64>,
}

/// What was measured.
pub(super) struct Measured<'a> {
    heading: Line<'a>,
    /// Columns behind those of the measurement: air, material.
    columns: Vec<&'a str>,
    pub(super) rows: Vec<Row>,
}

/// The passes over the targets, in the file's unit and in the order of the targets.
pub(super) struct Passes {
    pub(super) targets: Vec<f64>,
    pub(super) forward: Vec<Vec<f64>>,
    pub(super) reverse: Vec<Vec<f64>>,
}

impl<'a> Measured<'a> {
    pub(super) fn read(source: &'a Source) -> Result<Self, Problems> {
        let all = lines(source);
        let names = |line: &Line<'a>| -> Vec<&'a str> {
            let words = line.words(char::is_whitespace);
            words.iter().map(|word| word.text).collect()
        };
        let heading = all.iter().position(|line| {
            let names = names(line);
            [POSITION, READING, ERROR, STATUS].map(|name| names.contains(&name)) == [true; 4]
        });
        let Some(at) = heading else {
            return Err(Problem::new(format!(
                "there is no table with the columns `{POSITION}`, `{READING}`, `{ERROR}` and `{STATUS}`: the file holds no measured rows"
            ))
            .at(source.place(&(0..0)))
            .help("save the measurement with its readings, or map the columns of a CSV with `--columns`")
            .into());
        };
        let columns = names(&all[at]);
        let mut problems = Problems::none();
        let rows = all[at + 1..]
            .iter()
            .take_while(|line| begins_with_number(line));
        let rows = rows.filter_map(|line| row(line, &columns, &mut problems));
        let rows: Vec<Row> = rows.collect();
        let is_other = |name: &&str| ![POSITION, READING, ERROR, STATUS].contains(name);
        let measured = Measured {
            heading: all[at],
            columns: columns.into_iter().filter(is_other).collect(),
            rows,
        };
        problems.or_ok(measured)
    }

    pub(super) fn place(&self) -> Place {
        self.heading.place()
    }

    /// Error = ± reading − position within the decimals of all rows; another row was changed.
    pub(super) fn relation(&self, problems: &mut Problems) -> Option<Relation> {
        let misses = |relation: Relation| {
            let fits = move |row: &&Row| {
                (relation.factor() * row.reading - row.position - row.error).abs() <= row.rounding
            };
            self.rows.iter().filter(move |row| !fits(row))
        };
        let best = [Relation::Direct, Relation::Turned]
            .into_iter()
            .min_by_key(|relation| misses(*relation).count())?;
        let Some(first) = misses(best).next() else {
            return (!self.rows.is_empty()).then_some(best);
        };
        let expected = best.factor() * first.reading - first.position;
        problems.push(
            Problem::new(format!(
                "{} of {} rows contradict themselves: here the error is {}, but reading less position is {expected:.6}",
                misses(best).count(),
                self.rows.len(),
                first.error
            ))
            .at(first.place.clone())
            .help(CHANGED),
        );
        None
    }

    /// Readings that the laser itself calls bad.
    pub(super) fn refuse_bad_status(&self, problems: &mut Problems) {
        let is_bad = |row: &&Row| !(is(row.status, NORMAL) || is(row.status, WARM_UP));
        let count = self.rows.iter().filter(is_bad).count();
        if let Some(row) = self.rows.iter().find(is_bad) {
            let state = STATES.iter().zip(0_u8..);
            let state = state
                .into_iter()
                .find(|(_, n)| is(f64::from(*n), row.status));
            let state = state.map_or("unknown", |(words, _)| words);
            problems.push(
                Problem::new(format!(
                    "the laser's status is {} ({state}) in {count} of {} rows",
                    row.status,
                    self.rows.len()
                ))
                .at(row.place.clone())
                .help("such a reading is no measurement: measure the run again"),
            );
        }
    }

    pub(super) fn warm_up(&self) -> Option<String> {
        let is_warming = |row: &&Row| is(row.status, WARM_UP);
        let count = self.rows.iter().filter(is_warming).count();
        (count > 0).then(|| {
            format!(
                "the laser was still warming up in {count} of {} rows",
                self.rows.len()
            )
        })
    }

    /// Rows of each pass: `NumofPos` each, `RunNum` in one direction or in both.
    pub(super) fn passes(&self, header: &Header<'_>, problems: &mut Problems) -> Option<Passes> {
        let positions = header.count("numofpos", "NumofPos", problems)?;
        let runs = header.count("runnum", "RunNum", problems)?;
        let both = header.is_bidirectional(problems)?;
        let expected = positions * runs * if both { 2 } else { 1 };
        if self.rows.len() != expected {
            let ways = if both { ", there and back" } else { "" };
            problems.push(
                Problem::new(format!(
                    "{} rows are measured, expected {expected}: {positions} positions, {runs} runs{ways}",
                    self.rows.len()
                ))
                .at(self.place())
                .help(AGAIN),
            );
            return None;
        }
        self.sorted(positions, (runs, both), problems)
    }

    fn sorted(
        &self,
        positions: usize,
        (runs, both): (usize, bool),
        problems: &mut Problems,
    ) -> Option<Passes> {
        let mut passes = Passes {
            targets: self.rows[..positions]
                .iter()
                .map(|row| row.position)
                .collect(),
            forward: Vec::new(),
            reverse: Vec::new(),
        };
        for pass in self.rows.chunks(positions) {
            let mut found: Vec<f64> = pass.iter().map(|row| row.position).collect();
            let mut errors: Vec<f64> = pass.iter().map(|row| row.error).collect();
            if same(&found, &passes.targets) {
                passes.forward.push(errors);
                continue;
            }
            found.reverse();
            errors.reverse();
            if !same(&found, &passes.targets) {
                problems.push(self.other_positions(pass));
                return None;
            }
            passes.reverse.push(errors);
        }
        let back = if both { runs } else { 0 };
        if (passes.forward.len(), passes.reverse.len()) != (runs, back) {
            problems.push(
                Problem::new(format!(
                    "{} runs go from the first position to the last and {} go back, expected {runs} and {back} as in `RunNum` and `TestType`",
                    passes.forward.len(),
                    passes.reverse.len()
                ))
                .at(self.place())
                .help("the order of the rows shows the way of the axis; it is known from no file of this kind, so it is not guessed"),
            );
            return None;
        }
        Some(passes)
    }

    fn other_positions(&self, pass: &[Row]) -> Problem {
        let problem = Problem::new("a run has other positions than the first one");
        let place = pass
            .first()
            .map_or_else(|| self.place(), |row| row.place.clone());
        problem.at(place).help(AGAIN)
    }

    /// Name and values of the material's temperature, if a sensor was connected.
    pub(super) fn material(&self) -> Option<(&'a str, String)> {
        let found = self.columns.iter().zip(0..).find(|(name, index)| {
            name.starts_with("MatTemp") && self.column(*index).any(|value| !is(value, NO_SENSOR))
        });
        found.map(|(name, index)| (*name, self.range(index)))
    }

    fn column(&self, index: usize) -> impl Iterator<Item = f64> {
        self.rows
            .iter()
            .filter_map(move |row| row.others.get(index).copied())
    }

    /// The values of a column in words.
    fn range(&self, index: usize) -> String {
        let low = self.column(index).fold(f64::INFINITY, f64::min);
        let high = self.column(index).fold(f64::NEG_INFINITY, f64::max);
        match low < high {
            true => format!("{low} … {high}"),
            false => format!("{low}"),
        }
    }

    /// Air and material as the file has them; it names no unit of theirs.
    pub(super) fn surroundings(&self) -> Vec<String> {
        let (mut noted, mut absent) = (Vec::new(), Vec::new());
        for (index, name) in self.columns.iter().enumerate() {
            match self.column(index).all(|value| is(value, NO_SENSOR)) {
                true => absent.push(*name),
                false => noted.push(format!("{name} {}", self.range(index))),
            }
        }
        let noted = (!noted.is_empty()).then(|| {
            format!(
                "air and material, the file names no units: {}",
                noted.join(", ")
            )
        });
        let absent =
            (!absent.is_empty()).then(|| format!("not measured (−1): {}", absent.join(", ")));
        noted.into_iter().chain(absent).collect()
    }
}

/// Numbers that were written alike.
fn is(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.0
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is(*a, *b))
}

fn begins_with_number(line: &Line<'_>) -> bool {
    looks_like_number(line.text.trim_start())
}

fn row(line: &Line<'_>, columns: &[&str], problems: &mut Problems) -> Option<Row> {
    let words = line.words(char::is_whitespace);
    if words.len() != columns.len() {
        problems.push_with(|| {
            Problem::new(format!(
                "the row has {} numbers, expected {} as in the heading",
                words.len(),
                columns.len()
            ))
            .at(line.place())
            .help(AGAIN)
        });
        return None;
    }
    let mut numbers = Vec::new();
    for (name, word) in columns.iter().zip(&words) {
        numbers.push(word.number(&format!("`{}`", shown(name)), problems));
    }
    let numbers: Vec<f64> = numbers.into_iter().collect::<Option<_>>()?;
    let at = |name: &str| columns.iter().position(|column| *column == name);
    let (position, reading, error) = (at(POSITION)?, at(READING)?, at(ERROR)?);
    let status = at(STATUS)?;
    let digit = |index: usize| last_digit(words[index].text);
    let own = [position, reading, error, status];
    let others = (0..numbers.len()).filter(|index| !own.contains(index));
    Some(Row {
        place: line.place(),
        position: numbers[position],
        position_digit: digit(position),
        reading: numbers[reading],
        error: numbers[error],
        // Half a digit each, and the binary dust of the difference.
        rounding: (digit(position) + digit(reading) + digit(error)) / 2.0 + 1e-9,
        status: numbers[status],
        others: others.map(|index| numbers[index]).collect(),
    })
}

/// One unit of the last decimal of a number.
fn last_digit(text: &str) -> f64 {
    let decimals = text
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len());
    (0..decimals).fold(1.0, |digit, _| digit / 10.0)
}

/// What the maker's program made of the rows.
pub(super) struct Averages<'a> {
    pub(super) place: Place,
    pub(super) targets: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// One unit of the last decimal of each value.
    digits: Vec<f64>,
    rows: Vec<Line<'a>>,
}

impl<'a> Averages<'a> {
    /// The table of a unidirectional measurement; `None` = there is none.
    pub(super) fn read(source: &'a Source) -> Result<Option<Self>, Problems> {
        let all = lines(source);
        let heading = all.iter().position(|line| {
            line.text.starts_with(POSITION) && line.text.contains("Unidirectional Avg Error")
        });
        let Some(at) = heading else { return Ok(None) };
        let mut problems = Problems::none();
        let rows = all[at + 1..]
            .iter()
            .take_while(|line| begins_with_number(line));
        let mut averages = Averages {
            place: all[at].place(),
            targets: Vec::new(),
            values: Vec::new(),
            digits: Vec::new(),
            rows: rows.copied().collect(),
        };
        for line in &averages.rows {
            let [position, value] = line.words(char::is_whitespace)[..] else {
                problems.push_with(|| {
                    let problem = Problem::new("the row has not two numbers, position and error");
                    problem.at(line.place()).help(AGAIN)
                });
                continue;
            };
            averages
                .targets
                .extend(position.number("`Position`", &mut problems));
            averages.digits.push(last_digit(value.text));
            averages
                .values
                .extend(value.number("`Avg Error`", &mut problems));
        }
        problems.or_ok(Some(averages))
    }

    /// The first row that is not the mean of what was measured, in words, and where it stands.
    pub(super) fn difference(&self, passes: &Passes) -> Option<(String, Place)> {
        for (index, line) in self.rows.iter().enumerate() {
            let (at, found) = (self.targets[index], self.values[index]);
            let expected = passes
                .mean_at(index)
                .filter(|(position, _)| is(*position, at));
            let Some((_, mean)) = expected else {
                return Some((
                    format!("none is measured at {at} in row {}", index + 1),
                    line.place(),
                ));
            };
            if (found - mean).abs() > at.abs() * SINGLE_PRECISION + self.digits[index] {
                return Some((
                    format!("{found} at {at}, where {mean} was measured"),
                    line.place(),
                ));
            }
        }
        let (own, measured) = (self.targets.len(), passes.targets.len());
        (own != measured).then(|| {
            (
                format!("{own} positions instead of {measured}"),
                self.place.clone(),
            )
        })
    }

    /// How many positions stand in no measured row.
    pub(super) fn without_row(&self, measured: &Measured<'_>) -> usize {
        let is_measured = |at: &&f64| measured.rows.iter().any(|row| is(row.position, **at));
        self.targets.len() - self.targets.iter().filter(is_measured).count()
    }
}

impl Passes {
    /// A target and the mean of its values.
    fn mean_at(&self, index: usize) -> Option<(f64, f64)> {
        let values = self.forward.iter().chain(&self.reverse);
        let values: Vec<f64> = values.filter_map(|pass| pass.get(index).copied()).collect();
        let (mean, _) = crate::inputs::import::placing::mean(&values);
        Some((*self.targets.get(index)?, mean))
    }
}

impl<'a> Header<'a> {
    /// The header names the first and the last position of a pass.
    pub(super) fn compare_ends(&self, measured: &Measured<'_>, problems: &mut Problems) {
        let count = self.value("numofpos").and_then(|w| w.text.parse().ok());
        let last = count.and_then(|count: usize| measured.rows.get(count.checked_sub(1)?));
        let ends = [
            ("inipos", "IniPos", measured.rows.first()),
            ("endpos", "EndPos", last),
        ];
        for (key, name, row) in ends {
            let (Some(word), Some(row)) = (self.value(key), row) else {
                continue;
            };
            let Some(expected) = plain_number(word.text) else {
                continue;
            };
            if (row.position - expected).abs() > row.position_digit {
                problems.push(
                    Problem::new(format!(
                        "the row stands at position {}, expected {expected} as in `{name}`",
                        row.position
                    ))
                    .at(row.place.clone())
                    .help(CHANGED),
                );
            }
        }
    }
}
