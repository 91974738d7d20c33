//! Renishaw compensation table (`.ren`): a table that was already made for a control.
//!
//! ```text
//!   Compensation type       : Absolute
//!   Compensation resolution : 1 mm          ← one unit of the values
//!   Sign convention         : As errors
//!   No.  Axis position  Forward  Reverse    ← or: Combined
//! ```
//! Type, unit and sign come from these lines; where one is absent it has to be stated.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::Sign;
use crate::inputs::import::lines::{Line, Word, lines};
use crate::inputs::import::placing::Placing;
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{Component, Reading};
use crate::quantity::axis::Direction;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};

pub(super) const AGAIN: &str = "the file is incomplete or damaged: save it again";

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let file = File::of(source);
    let mut problems = Problems::none();
    file.refuse_other_layout(&mut problems);
    let table = file.table(&mut problems);
    let header = Header {
        term: stated.required_deviation(&mut problems),
        sign: file.sign(stated, &mut problems),
        unit_um: file.unit_um(stated, &mut problems),
    };
    file.require_absolute(stated, &mut problems);
    let Some(table) = table else {
        return Err(problems);
    };
    file.refuse_other_curves(&table, &mut problems);
    file.refuse_backlash(&table, &mut problems);
    file.compare_range(&table, &mut problems);
    let placing = Placing::of(&table.targets, &table.place, stated, &mut problems);
    let (Some(term), Some(sign), Some(unit_um), Some(placing)) =
        (header.term, header.sign, header.unit_um, placing)
    else {
        return Err(problems);
    };
    let mut facts = file.facts();
    facts.extend(placing.words());
    facts.extend(placing.sense_words(term));
    facts.extend(table.curve_words(&placing));
    problems.or_ok(Reading {
        series: table.series(term, sign, unit_um, &placing),
        facts,
        ..Reading::default()
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

/// The table as it stands in the file.
pub(super) struct Table {
    pub(super) place: Place,
    pub(super) targets: Vec<f64>,
    curves: Vec<(Curve, Vec<f64>)>,
}

impl Table {
    /// Whether one curve holds for both directions.
    pub(super) fn is_combined(&self) -> bool {
        self.curves
            .iter()
            .any(|(curve, _)| *curve == Curve::Combined)
    }

    /// How the directions of the curves are understood; the file does not say it.
    fn curve_words(&self, placing: &Placing) -> Option<String> {
        let way = placing.run;
        (!self.is_combined()).then(|| {
            format!("direction: `Forward` is taken as the way from the first position to the last = the axis moving {way}")
        })
    }

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

/// Lines and heading of a file.
pub(super) struct File<'a> {
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

    /// The value behind a key above the table.
    pub(super) fn value(&self, key: &str) -> Option<Word<'a>> {
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
        let (mut targets, mut complete) = (Vec::new(), true);
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); curves.len()];
        let rows = self.lines[at + 1..].iter().filter(|line| !line.is_blank());
        for (row, line) in rows.enumerate() {
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
                complete = false;
                continue;
            }
            let number = words[0].count("the number of a point", problems);
            let expected = row + 1;
            if number.is_some_and(|number| number != expected) {
                problems.push_with(|| {
                    Problem::new(format!(
                        "point {} stands where point {expected} is expected",
                        words[0].text
                    ))
                    .at(words[0].place())
                    .help(AGAIN)
                });
            }
            targets.extend(words[1].number("an axis position", problems));
            for (column, word) in columns.iter_mut().zip(&words[2..]) {
                column.extend(word.number("a value", problems));
            }
            let filled = columns.iter().all(|column| column.len() == row + 1);
            complete &= filled && targets.len() == row + 1;
        }
        complete.then_some(Table {
            place: heading.place(),
            targets,
            curves: curves.into_iter().zip(columns).collect(),
        })
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
