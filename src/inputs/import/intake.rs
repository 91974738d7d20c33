//! A file while it is taken in: its text piece by piece, each with its place, what was stated beside it, what is
//! wrong with both, and what is said of it.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Series};
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::stated::{
    AXIS, Fact, Format, ImportFacts, MATERIAL_CORRECTED, MaterialCorrected, SIGN, TERM, word,
};
use crate::inputs::refusals::{self, AGAIN, MISSING};
use crate::inputs::table::{RUN, count};
use crate::quantity::Axis;
use crate::text::{
    Finding, LARGEST_NUMBER, Line, Notes, Place, Problem, Problems, Source, lines, plain_number,
    shown,
};
use std::cell::RefCell;

/// Two axes whose squareness a file gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squareness {
    /// `xy`, `xz` or `yz`.
    pub pair: &'static str,
    /// φ in µm/m; positive = the angle between the two positive axis directions is less than 90°.
    pub um_per_m: f64,
    /// The name in the file, e.g. `C0Y`.
    pub name: &'static str,
}

/// What a file holds.
pub(super) type Contents = (Vec<Series>, Vec<Squareness>);

/// A file while it is taken in.
pub(super) struct Intake<'a> {
    pub(super) source: &'a Source,
    pub(super) stated: &'a ImportFacts,
    pub(super) format: Format,
    /// What is wrong.
    pub(super) notes: Notes,
    findings: RefCell<Vec<Finding>>,
}

impl<'a> Intake<'a> {
    pub(super) fn of(source: &'a Source, stated: &'a ImportFacts, format: Format) -> Intake<'a> {
        let notes = Notes::default();
        stated.refuse_foreign(format, &notes);
        Intake { source, stated, format, notes, findings: RefCell::default() }
    }

    /// The value, if nothing is wrong so far.
    pub(super) fn if_sound<T>(&self, value: T) -> Option<T> {
        self.notes.is_sound().then_some(value)
    }

    /// Says what was found.
    pub(super) fn say(&self, found: impl IntoIterator<Item = ImportFinding>) {
        self.findings.borrow_mut().extend(found.into_iter().map(Finding::from));
    }

    /// Says what was not said before.
    pub(super) fn say_once(&self, found: impl IntoIterator<Item = ImportFinding>) {
        for found in found.into_iter().map(Finding::from) {
            if !self.findings.borrow().contains(&found) {
                self.findings.borrow_mut().push(found);
            }
        }
    }

    /// What came of it: the value with all that is said, if nothing is wrong.
    pub(super) fn end<T>(self, value: Option<T>) -> Result<(T, Vec<Finding>), Problems> {
        Ok((self.notes.end(value)?.ok_or_else(Problems::none)?, self.findings.into_inner()))
    }

    /// Its first letter.
    pub(super) fn top(&self) -> Place {
        self.source.place(&(0..0))
    }

    /// All lines, without their ends.
    pub(super) fn lines(&'a self) -> Vec<Piece<'a>> {
        let line = |line: Line<'a>| Piece { intake: self, start: line.start, text: line.text() };
        lines(self.source).map(line).collect()
    }

    /// Lines as a table of so many numbers each, column by column.
    pub(super) fn numbers(
        &self,
        lines: &[Piece<'a>],
        columns: usize,
        is_separator: fn(char) -> bool,
    ) -> Option<Vec<Vec<f64>>> {
        let (mut table, mut whole) = (vec![Vec::new(); columns], true);
        for line in lines {
            let words = line.row(columns, is_separator).unwrap_or_default();
            let numbers = words.iter().filter_map(|word| word.number("a value"));
            let numbers: Vec<f64> = numbers.collect();
            whole &= numbers.len() == columns;
            table.iter_mut().zip(numbers).for_each(|(column, own)| column.push(own));
        }
        whole.then_some(table)
    }
}

/// What has to be known of a file: what it says itself, else what was stated; both must agree.
impl Intake<'_> {
    /// What the file says, and where; else what was stated. Both must agree, and one has to say it.
    pub(super) fn settled<T: PartialEq>(
        &self,
        fact: &Fact,
        found: Option<(T, Piece<'_>)>,
        stated: Option<T>,
    ) -> Option<T> {
        match (found, stated) {
            (Some((found, place)), Some(stated)) if found != stated => {
                let statement = fact.statement(self.stated).unwrap_or_default();
                place.refused(refusals::contradicted(statement, shown(place.text), fact.option))
            }
            (None, None) => self.notes.refused(fact.missing()),
            (found, stated) => found.map(|(found, _)| found).or(stated),
        }
    }

    /// The sign, which most files do not carry.
    pub(super) fn sign(&self, found: Option<(TableSign, Piece<'_>)>) -> Option<TableSign> {
        self.settled(&SIGN, found, self.stated.sign)
    }

    /// The component, whose axis must be that of `--axis`, and whose kind the format must hold.
    pub(super) fn term(&self) -> Option<Component> {
        let term = self.settled(&TERM, None, self.stated.term)?;
        if let Some(axis) = self.stated.axis.filter(|axis| *axis != term.along) {
            self.notes.refuse(refusals::other_axis_stated(axis.key(), term, term.along));
        }
        let (fits, held) = match self.format {
            Format::Ren | Format::Columns => {
                (matches!(term.kind, Kind::Deviation(_)), "deviations")
            }
            _ => (term.is_positioning(), "positioning: EXX, EYY or EZZ"),
        };
        if !fits {
            self.notes.refuse(refusals::other_term(term, word(self.format), held));
        }
        Some(term)
    }

    /// The axis that the file names must be the one that moved. `--axis` overrules an entry that names none of
    /// them clearly, and one of `pos`, where operators leave it as it was: that is a warning.
    pub(super) fn check_axis(&self, named: &Piece<'_>) {
        let letter = only_letter(named.text);
        let moved = self.stated.term.map(|term| term.along).or(self.stated.axis);
        if letter.is_some() && moved.is_none_or(|axis| Some(axis.letter()) == letter) {
            return;
        }
        let (entry, of_pos) = (shown(named.text), self.format == Format::Pos);
        if let Some(axis) = self.stated.axis.filter(|_| letter.is_none() || of_pos) {
            return self.say([ImportFinding::OtherAxis { entry, axis }]);
        }
        let help = match of_pos {
            true => "take the right file; if the entry was only left as it was, add `--axis`",
            false => "state the term of the axis that moved, or take the right file",
        };
        named.refuse(match moved.filter(|_| letter.is_some()) {
            Some(moved) => refusals::other_axis(entry, moved, help),
            None => AXIS.missing_because(&format!(
                "the axis of the file is `{entry}`, which names none of X, Y, Z, or several"
            )),
        });
    }

    /// Whether the readings hold the expansion of the material has to be stated where the file notes a
    /// temperature of it; where they do or may, a warning says what is at stake, if that is `notable`.
    pub(super) fn check_material(&self, noted: String, at: Place, stake: String, notable: bool) {
        let state = match self.stated.material_corrected {
            Some(MaterialCorrected::Yes) => return,
            Some(MaterialCorrected::No) => {
                "the expansion of the material is still in the deviations"
            }
            Some(MaterialCorrected::NotStated) => {
                "whether the expansion of the material is in the deviations is not stated"
            }
            None => {
                let why = format!(
                    "the file notes {noted}, but not whether the readings were brought to 20 °C"
                );
                return self.notes.refuse(MATERIAL_CORRECTED.missing_because(&why).at(at));
            }
        };
        self.say(notable.then_some(ImportFinding::Material { state, noted, stake }));
    }
}

/// The axis that a text such as `Linear Y` or `x-axis` names.
pub(super) fn named_axis(text: &str) -> Option<Axis> {
    only_letter(text).and_then(|letter| Axis::from_letter(letter.encode_utf8(&mut [0; 4])))
}

/// The name of an axis, also a rotary one, that stands alone in a text.
fn only_letter(text: &str) -> Option<char> {
    let text = text.to_uppercase();
    let words = text.split(|c: char| !c.is_alphabetic());
    let mut names: Vec<&str> =
        words.filter(|word| word.len() == 1 && "ABCUVWXYZ".contains(word)).collect();
    names.dedup();
    match names[..] {
        [name] => name.chars().next(),
        _ => None,
    }
}

/// A piece of a text, a line or a word of it, which knows where it stands and notes what is wrong with it.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    pub(super) intake: &'a Intake<'a>,
    start: usize,
    pub(super) text: &'a str,
}

impl<'a> Piece<'a> {
    /// Bytes `from..to`, without blanks around them.
    pub(super) fn part(&self, from: usize, to: usize) -> Piece<'a> {
        let text = &self.text[from..to];
        let indent = text.len() - text.trim_start().len();
        Piece { start: self.start + from + indent, text: text.trim(), ..*self }
    }

    /// What stands behind the first such sign.
    pub(super) fn behind(&self, sign: char) -> Option<Piece<'a>> {
        Some(self.part(self.text.find(sign)? + 1, self.text.len()))
    }

    /// What stands before a comment sign.
    pub(super) fn before(&self, sign: &str) -> Piece<'a> {
        let end = self.text.find(sign).unwrap_or(self.text.len());
        Piece { text: &self.text[..end], ..*self }
    }

    pub(super) fn is_blank(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// Whether it begins like a number.
    pub(super) fn begins_with_number(&self) -> bool {
        let digits = self.text.trim_start().trim_start_matches(['+', '-', '.', ',']);
        digits.starts_with(|c: char| c.is_ascii_digit())
    }

    /// Key and value of `key : value`; the key in small letters and digits.
    pub(super) fn key_value(&self) -> Option<(String, Piece<'a>)> {
        let (key, _) = self.text.split_once(':')?;
        Some((key_of(key), self.behind(':')?))
    }

    /// Words between separators; adjacent separators are one.
    pub(super) fn words(&self, is_separator: fn(char) -> bool) -> Vec<Piece<'a>> {
        let mut end = 0;
        let parts = self.text.split_inclusive(is_separator).map(|part| {
            let start = end;
            end += part.len();
            self.part(start, start + part.trim_end_matches(is_separator).len())
        });
        parts.filter(|word| !word.text.is_empty()).collect()
    }

    /// The words of a row of a table: as many as its heading has.
    pub(super) fn row(
        &self,
        columns: usize,
        is_separator: fn(char) -> bool,
    ) -> Option<Vec<Piece<'a>>> {
        let words = self.words(is_separator);
        if words.len() == columns {
            return Some(words);
        }
        self.refused(refusals::other_count(words.len(), columns))
    }

    pub(super) fn place(&self) -> Place {
        let word = self.part(0, self.text.len());
        self.intake.source.place(&(word.start..word.start + word.text.len().max(1)))
    }

    /// Notes what is wrong here.
    pub(super) fn refuse(&self, problem: Problem) {
        self.intake.notes.refuse_with(|| problem.at(self.place()));
    }

    /// Notes what is wrong here, and gives nothing.
    pub(super) fn refused<T>(&self, problem: Problem) -> Option<T> {
        self.refuse(problem);
        None
    }

    /// Notes that something else was expected here.
    pub(super) fn unexpected(&self, what: &str, expected: &str, help: &str) {
        self.refuse(refusals::something_else(what, shown(self.text), expected, help))
    }

    /// A finite number with a decimal point.
    pub(super) fn number(&self, what: &str) -> Option<f64> {
        let help = match self.text.contains(',') {
            true => "a decimal comma cannot be read here: save the file again with a decimal point",
            false => MISSING,
        };
        let number = |text: &str| plain_number(text).filter(|n| n.abs() <= LARGEST_NUMBER);
        self.read(what, "a finite number", help, number)
    }

    /// A whole number from 1.
    pub(super) fn count(&self, what: &str) -> Option<usize> {
        self.read(what, RUN.0, AGAIN, count)
    }

    /// What the text means, or the next step.
    pub(super) fn read<T>(
        &self,
        what: &str,
        expected: &str,
        help: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let meaning = read(self.text);
        if meaning.is_none() {
            self.unexpected(what, expected, help);
        }
        meaning
    }
}

fn key_of(label: &str) -> String {
    label.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Values with their keys, in the order of the file.
pub(super) struct Fields<'a>(pub(super) Vec<(String, Piece<'a>)>);

impl<'a> Fields<'a> {
    /// Those of lines `key : value`.
    pub(super) fn of(lines: &[Piece<'a>]) -> Fields<'a> {
        Fields(lines.iter().filter_map(Piece::key_value).collect())
    }

    /// The first value of a key, which is named as the file writes it.
    pub(super) fn value(&self, label: &str) -> Option<Piece<'a>> {
        let key = key_of(label);
        self.0.iter().find(|(found, _)| *found == key).map(|(_, value)| *value)
    }

    /// What the file says of some keys.
    pub(super) fn said(&self, labels: &[&str]) -> impl Iterator<Item = ImportFinding> {
        labels.iter().filter_map(|label| {
            let value = self.value(label).filter(|value| !value.text.is_empty())?;
            Some(ImportFinding::Says { entry: format!("{label}: {}", shown(value.text)) })
        })
    }
}
