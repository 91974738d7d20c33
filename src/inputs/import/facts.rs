//! What has to be known of a file: what it says itself, else what was stated; both must agree.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::intake::{Intake, Piece};
use crate::inputs::import::stated::{
    AXIS, Fact, Format, MATERIAL_CORRECTED, MaterialCorrected, SIGN, TERM, word,
};
use crate::inputs::refusals;
use crate::quantity::axis::Axis;
use crate::text::problem::{Place, shown};

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
            (None, None) => self.refused(fact.missing()),
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
            self.refuse(refusals::other_axis_stated(axis.key(), term, term.along));
        }
        let (fits, held) = match self.format {
            Format::Ren | Format::Columns => {
                (matches!(term.kind, Kind::Deviation(_)), "deviations")
            }
            _ => (term.is_positioning(), "positioning: EXX, EYY or EZZ"),
        };
        if !fits {
            self.refuse(refusals::other_term(term, word(self.format), held));
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
                return self.refuse(MATERIAL_CORRECTED.missing_because(&why).at(at));
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
