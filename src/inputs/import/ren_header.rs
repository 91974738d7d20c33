//! Lines above the table of a `.ren` file: type, unit, sign, range.

use crate::inputs::import::choices::{Sign, Values};
use crate::inputs::import::lines::Word;
use crate::inputs::import::ren::{AGAIN, File, Table};
use crate::inputs::import::stated::{Stated, missing};
use crate::text::delimited::{LengthUnit, plain_number};
use crate::text::problem::{Problem, Problems, shown};

/// Positions are compared to a tenth of a micrometre.
const SAME_MM: f64 = 1e-4;
const SEPARATE: &str =
    "save separate forward and reverse tables, or the measurement itself (`.rtl`)";

impl File<'_> {
    pub(super) fn sign(&self, stated: &Stated, problems: &mut Problems) -> Option<Sign> {
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

    pub(super) fn require_absolute(&self, stated: &Stated, problems: &mut Problems) {
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
    pub(super) fn unit_um(&self, stated: &Stated, problems: &mut Problems) -> Option<f64> {
        let Some(line) = self.value("compensationresolution") else {
            if stated.unit.is_none() {
                problems.push(missing(
                    "--unit",
                    "the file has no line `Compensation resolution`",
                    "add the unit of the values: `--unit um`, `mm`, `in` or `uin`",
                ));
            }
            return stated.unit.map(LengthUnit::um);
        };
        let split = line
            .text
            .find(|c: char| c.is_alphabetic())
            .unwrap_or(line.text.len());
        let (number, unit) = line.text.split_at(split);
        let number = plain_number(number.trim()).filter(|n| *n > 0.0 && n.is_finite());
        let (Some(number), Some(unit)) = (number, LengthUnit::from_text(unit)) else {
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

    /// Curves and `Table type` must say the same: one table for both directions, or two.
    pub(super) fn refuse_other_curves(&self, table: &Table, problems: &mut Problems) {
        let Some(line) = self.value("tabletype") else {
            return;
        };
        let says_combined = line.text.to_lowercase().contains("combined");
        if says_combined != table.is_combined() {
            let columns = if table.is_combined() {
                "`Combined`"
            } else {
                "`Forward` and `Reverse`"
            };
            problems.push(contradiction_of_columns(&line, columns));
        }
    }

    /// A combined table may leave out a backlash that stands in a line of its own.
    pub(super) fn refuse_backlash(&self, table: &Table, problems: &mut Problems) {
        let Some(line) = self.value("backlasherror") else {
            if table.is_combined() {
                problems.push(
                    Problem::new("there is no line `Backlash error`, so it is not known whether the combined table leaves out a backlash")
                        .at(table.place.clone())
                        .help(SEPARATE),
                );
            }
            return;
        };
        let first = line.text.split_whitespace().next().unwrap_or_default();
        let none = first.eq_ignore_ascii_case("n/a") || plain_number(first) == Some(0.0);
        if !none {
            problems.push(
                Problem::new(format!(
                    "the table leaves out a backlash of `{}`, whose sense is not known",
                    shown(line.text)
                ))
                .at(line.place())
                .help(SEPARATE),
            );
        }
    }

    /// First and last position must be those of the header: else rows are missing.
    pub(super) fn compare_range(&self, table: &Table, problems: &mut Problems) {
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

    pub(super) fn facts(&self) -> Vec<String> {
        let keys = [
            ("Test name", "testname"),
            ("Table type", "tabletype"),
            ("Compensation type", "compensationtype"),
            ("Compensation resolution", "compensationresolution"),
            ("Sign convention", "signconvention"),
            ("Reference position", "referenceposition"),
            ("Backlash error", "backlasherror"),
        ];
        let said = keys.into_iter().filter_map(|(label, key)| {
            let value = self.value(key)?;
            Some(format!("the file says: {label}: {}", shown(value.text)))
        });
        said.collect()
    }
}

/// A length such as `-100 mm`.
fn millimetres(line: &Word<'_>, problems: &mut Problems) -> Option<f64> {
    let mm = line
        .text
        .strip_suffix("mm")
        .and_then(|n| plain_number(n.trim()));
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

fn contradiction_of_columns(line: &Word<'_>, columns: &str) -> Problem {
    Problem::new(format!(
        "the file says `{}`, but its columns are {columns}",
        shown(line.text)
    ))
    .at(line.place())
    .help("save the table again: which of the two holds is not known")
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
