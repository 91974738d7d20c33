//! Renishaw compensation table (`.ren`): a table that was already made for a control.
//!
//! ```text
//!   Compensation type       : Absolute
//!   Compensation resolution : 1 mm          ← one unit of the values
//!   Sign convention         : As errors
//!   No.  Axis position  Forward  Reverse    ← or: Combined
//! ```
//! Type, unit and sign come from these lines; where one is absent it has to be stated.

use crate::axis::Direction;
use crate::document::Source;
use crate::error_table::DraftSeries;
use crate::import::lines::{Line, Word, lines};
use crate::import::placing::Placing;
use crate::import::stated::{Sign, Stated, Unit, Values, missing};
use crate::import::{Component, Kind, Reading};
use crate::problem::{Place, Problem, Problems, shown};

const AGAIN: &str = "the file is incomplete or damaged: save it again";
/// Positions are compared to a tenth of a micrometre.
const SAME_MM: f64 = 1e-4;

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let file = File::of(source);
    let mut problems = Problems::none();
    file.refuse_other_layout(&mut problems);
    let table = file.table(&mut problems);
    let header = Header {
        term: stated.required_term(&mut problems),
        sign: file.sign(stated, &mut problems),
        unit_um: file.unit_um(stated, &mut problems),
    };
    file.require_absolute(stated, &mut problems);
    file.refuse_backlash(&mut problems);
    let Some(table) = table else {
        return Err(problems);
    };
    file.compare_range(&table, &mut problems);
    let placing = Placing::of(&table.targets, &table.place, stated, &mut problems);
    let (Some(term), Some(sign), Some(unit_um), Some(placing)) =
        (header.term, header.sign, header.unit_um, placing)
    else {
        return Err(problems);
    };
    if let Kind::Angle(_) = term.kind {
        problems.push(
            Problem::new(format!(
                "`--term {term}` is an angle, but the file holds lengths"
            ))
            .help("state one of EXX, EYX, EZX, EXY, EYY, EZY, EXZ, EYZ, EZZ"),
        );
    }
    let mut facts = file.facts();
    facts.extend(placing.words(Some(term)));
    problems.or_ok(Reading {
        series: table.series(term, sign, unit_um, &placing),
        facts,
        squareness: Vec::new(),
    })
}

struct Header {
    term: Option<Component>,
    sign: Option<Sign>,
    unit_um: Option<f64>,
}

/// One curve of the table.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Curve {
    Combined,
    Forward,
    Reverse,
}

struct Table {
    place: Place,
    targets: Vec<f64>,
    curves: Vec<(Curve, Vec<f64>)>,
}

impl Table {
    fn series(
        &self,
        term: Component,
        sign: Sign,
        unit_um: f64,
        placing: &Placing,
    ) -> Vec<DraftSeries> {
        let mut series: Vec<DraftSeries> = self
            .curves
            .iter()
            .map(|(curve, values)| {
                let direction: Option<Direction> = match curve {
                    Curve::Combined => None,
                    Curve::Forward => Some(placing.run),
                    Curve::Reverse => Some(placing.run.opposite()),
                };
                let um: Vec<f64> = values.iter().map(|value| value * unit_um).collect();
                let mut series = DraftSeries::new(term.along, direction, placing.positions_mm());
                term.put(&mut series, placing.deviations(&um, term, sign));
                series
            })
            .collect();
        series.sort_by_key(|series| series.direction);
        series
    }
}

struct File<'a> {
    source: &'a Source,
    lines: Vec<Line<'a>>,
    /// Index of the line `No.  Axis position …`.
    heading: Option<usize>,
}

impl<'a> File<'a> {
    fn of(source: &'a Source) -> File<'a> {
        let lines = lines(source);
        let heading = lines.iter().position(|line| {
            let text = line.text.trim().to_lowercase();
            text.starts_with("no") && text.contains("axis position")
        });
        File {
            source,
            lines,
            heading,
        }
    }

    fn value(&self, key: &str) -> Option<Word<'a>> {
        let end = self.heading.unwrap_or(self.lines.len());
        let mut pairs = self.lines[..end].iter().filter_map(Line::key_value);
        pairs.find_map(|(found, value)| (found == key && !value.text.is_empty()).then_some(value))
    }

    fn refuse_other_layout(&self, problems: &mut Problems) {
        if self.heading.is_none() {
            problems.push(
                Problem::new("there is no table with the heading `No.  Axis position`")
                    .at(self.source.place(&(0..0)))
                    .help("other layouts of compensation tables are not known: save the measurement itself (`.rtl`)"),
            );
        }
    }

    fn table(&self, problems: &mut Problems) -> Option<Table> {
        let at = self.heading?;
        let heading = &self.lines[at];
        let curves = curves_of(heading, problems)?;
        let mut targets = Vec::new();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); curves.len()];
        for line in self.lines[at + 1..].iter().filter(|line| !line.is_blank()) {
            let words = line.words(char::is_whitespace);
            if words.len() != curves.len() + 2 {
                let (found, expected) = (words.len(), curves.len() + 2);
                problems.push_with(|| {
                    Problem::new(format!(
                        "the row has {found} numbers, expected {expected} as in the heading"
                    ))
                    .at(line.place())
                    .help(AGAIN)
                });
                continue;
            }
            let number = words[0].count("the number of a point", problems);
            if number.is_some_and(|number| number != targets.len() + 1) {
                let expected = targets.len() + 1;
                problems.push_with(|| {
                    Problem::new(format!(
                        "point {} stands where point {expected} is expected",
                        words[0].text
                    ))
                    .at(words[0].place())
                    .help(AGAIN)
                });
            }
            targets.push(words[1].number("an axis position", problems)?);
            for (column, word) in columns.iter_mut().zip(&words[2..]) {
                column.extend(word.number("a value", problems));
            }
        }
        Some(Table {
            place: heading.place(),
            targets,
            curves: curves.into_iter().zip(columns).collect(),
        })
    }

    fn sign(&self, stated: &Stated, problems: &mut Problems) -> Option<Sign> {
        let Some(line) = self.value("signconvention") else {
            return stated.required_sign(problems);
        };
        let text = line.text.to_lowercase();
        let found = if text.starts_with("as error") {
            Sign::AsError
        } else if text.starts_with("as comp") || text.starts_with("as correction") {
            Sign::AsCorrection
        } else {
            problems.push(unknown(
                &line,
                "sign convention",
                "`As errors` or `As compensation`",
            ));
            return None;
        };
        agreed(found, stated.sign, &line, ("--sign", Sign::word), problems)
    }

    fn require_absolute(&self, stated: &Stated, problems: &mut Problems) {
        let values = match self.value("compensationtype") {
            None => stated.values,
            Some(line) => {
                let found = match line.text.to_lowercase().as_str() {
                    "absolute" => Values::Absolute,
                    "incremental" => Values::Incremental,
                    _ => {
                        problems.push(unknown(&line, "compensation type", "`Absolute`"));
                        return;
                    }
                };
                agreed(
                    found,
                    stated.values,
                    &line,
                    ("--values", Values::word),
                    problems,
                );
                Some(found)
            }
        };
        match values {
            Some(Values::Absolute) => {}
            Some(Values::Incremental) => problems.push(
                Problem::new("the table is incremental, and from which neighbour its values count is not known")
                    .help("save it as an absolute table, or save the measurement itself (`.rtl`)"),
            ),
            None => problems.push(missing(
                "--values",
                "the file has no line `Compensation type`",
                "add `--values absolute` if each value is the whole deviation at its position",
            )),
        }
    }

    /// Micrometres of one unit of the values.
    fn unit_um(&self, stated: &Stated, problems: &mut Problems) -> Option<f64> {
        let Some(line) = self.value("compensationresolution") else {
            if stated.unit.is_none() {
                problems.push(missing(
                    "--unit",
                    "the file has no line `Compensation resolution`",
                    "add the unit of the values: `--unit um`, `mm`, `in` or `uin`",
                ));
            }
            return stated.unit.map(Unit::um);
        };
        let split = line
            .text
            .find(|c: char| c.is_alphabetic())
            .unwrap_or(line.text.len());
        let (number, unit) = line.text.split_at(split);
        let number = number
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|n| *n > 0.0 && n.is_finite());
        let (Some(number), Some(unit)) = (number, Unit::from_text(unit)) else {
            problems.push(unknown(
                &line,
                "compensation resolution",
                "e.g. `1 mm` or `0.001 mm`",
            ));
            return None;
        };
        let um = number * unit.um();
        if let Some(stated) = stated.unit.filter(|s| (s.um() - um).abs() > 1e-9 * um) {
            problems.push(contradiction("--unit", stated.word(), &line));
        }
        Some(um)
    }

    fn refuse_backlash(&self, problems: &mut Problems) {
        let Some(line) = self.value("backlasherror") else {
            return;
        };
        let first = line.text.split_whitespace().next().unwrap_or_default();
        let none = first.eq_ignore_ascii_case("n/a") || first.parse().is_ok_and(|b: f64| b == 0.0);
        if !none {
            problems.push(
                Problem::new(format!(
                    "the table leaves out a backlash of `{}`, whose sense is not known",
                    shown(line.text)
                ))
                .at(line.place())
                .help(
                    "save separate forward and reverse tables, or the measurement itself (`.rtl`)",
                ),
            );
        }
    }

    /// First and last position must be those of the header: else rows are missing.
    fn compare_range(&self, table: &Table, problems: &mut Problems) {
        let ends = [
            (
                "Compensation start",
                "compensationstart",
                table.targets.first(),
            ),
            ("Compensation end", "compensationend", table.targets.last()),
        ];
        for (label, key, found) in ends {
            let Some(line) = self.value(key) else {
                problems.push(
                    Problem::new(format!(
                        "there is no line `{label}`, so it cannot be seen whether rows are missing"
                    ))
                    .at(table.place.clone())
                    .help(AGAIN),
                );
                continue;
            };
            let Some(mm) = millimetres(&line, problems) else {
                continue;
            };
            if found.is_none_or(|found| (found - mm).abs() > SAME_MM) {
                let found = found.map_or("nothing".to_string(), |found| format!("{found} mm"));
                problems.push(
                    Problem::new(format!(
                        "the table has {found} at this end, expected {mm} mm as in `{label}`"
                    ))
                    .at(line.place())
                    .help(AGAIN),
                );
            }
        }
        self.compare_spacing(table, problems);
    }

    fn compare_spacing(&self, table: &Table, problems: &mut Problems) {
        let Some(line) = self.value("compensationspacing") else {
            return;
        };
        let Some(mm) = millimetres(&line, problems) else {
            return;
        };
        for pair in table.targets.windows(2) {
            if ((pair[1] - pair[0]).abs() - mm.abs()).abs() > SAME_MM {
                problems.push_with(|| {
                    Problem::new(format!(
                        "the table goes from {} to {} mm, expected a spacing of {mm} mm",
                        pair[0], pair[1]
                    ))
                    .at(line.place())
                    .help(AGAIN)
                });
            }
        }
    }

    fn facts(&self) -> Vec<String> {
        let keys = [
            ("Test name", "testname"),
            ("Table type", "tabletype"),
            ("Compensation type", "compensationtype"),
            ("Compensation resolution", "compensationresolution"),
            ("Sign convention", "signconvention"),
            ("Reference position", "referenceposition"),
        ];
        let said = keys.into_iter().filter_map(|(label, key)| {
            let value = self.value(key)?;
            Some(format!("the file says: {label}: {}", shown(value.text)))
        });
        said.collect()
    }
}

/// Columns behind `Axis position`.
fn curves_of(heading: &Line<'_>, problems: &mut Problems) -> Option<Vec<Curve>> {
    let text = heading.text.to_lowercase();
    let behind = text.split("axis position").nth(1).unwrap_or_default();
    let names: Vec<&str> = behind.split_whitespace().collect();
    match names[..] {
        ["combined"] => Some(vec![Curve::Combined]),
        ["forward", "reverse"] => Some(vec![Curve::Forward, Curve::Reverse]),
        ["reverse", "forward"] => Some(vec![Curve::Reverse, Curve::Forward]),
        _ => {
            problems.push(
                Problem::new(format!(
                    "the columns are `{}`, expected `Combined`, or `Forward` and `Reverse`",
                    shown(behind.trim())
                ))
                .at(heading.place())
                .help("save the table again with these columns"),
            );
            None
        }
    }
}

/// A length such as `-100 mm`.
fn millimetres(line: &Word<'_>, problems: &mut Problems) -> Option<f64> {
    let mm = line
        .text
        .strip_suffix("mm")
        .and_then(|n| n.trim().parse::<f64>().ok());
    let mm = mm.filter(|mm| mm.is_finite());
    if mm.is_none() {
        problems.push(unknown(line, "length", "a number and `mm`"));
    }
    mm
}

fn unknown(line: &Word<'_>, what: &str, expected: &str) -> Problem {
    Problem::new(format!(
        "the {what} is `{}`, expected {expected}",
        shown(line.text)
    ))
    .at(line.place())
    .help("save the table again with one of these")
}

fn contradiction(option: &str, word: &str, line: &Word<'_>) -> Problem {
    Problem::new(format!(
        "`{option} {word}` contradicts the file, which says `{}`",
        shown(line.text)
    ))
    .at(line.place())
    .help(format!("leave `{option}` out"))
}

/// What the file says, unless something else was stated.
fn agreed<T: Copy + PartialEq>(
    found: T,
    stated: Option<T>,
    line: &Word<'_>,
    (option, word): (&str, fn(T) -> &'static str),
    problems: &mut Problems,
) -> Option<T> {
    match stated.filter(|stated| *stated != found) {
        None => Some(found),
        Some(other) => {
            problems.push(contradiction(option, word(other), line));
            None
        }
    }
}
