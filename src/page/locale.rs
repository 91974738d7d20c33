//! How a page and its pictures show what documents hold: words, units of length, decimal mark.

use super::scale;
use super::texts::Texts;
use crate::quantity::units::{Figure, MM_PER_INCH, UM_PER_MM, rounded};

/// In which unit lengths are shown; documents are always in mm and µm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// mm and µm.
    Metric,
    /// Inches and millionths of an inch.
    Inch,
}

/// The words of a language, and the unit of lengths.
#[derive(Clone, Copy)]
pub struct Locale<'a> {
    /// The words.
    pub texts: &'a Texts,
    /// The unit of lengths.
    pub shown: Shown,
}

/// A unit as it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    /// Its sign.
    pub(super) sign: &'static str,
    /// How many of it are one millimetre (of positions) or one micrometre (of deviations).
    pub(super) each: f64,
}

impl Locale<'_> {
    /// Of positions.
    pub(super) fn mm(self) -> Unit {
        let (sign, each) = match self.shown {
            Shown::Metric => ("mm", 1.0),
            Shown::Inch => ("in", 1.0 / MM_PER_INCH),
        };
        Unit { sign, each }
    }

    /// Of deviations.
    pub(super) fn um(self) -> Unit {
        let (sign, each) = match self.shown {
            Shown::Metric => ("µm", 1.0),
            Shown::Inch => ("µin", UM_PER_MM / MM_PER_INCH),
        };
        Unit { sign, each }
    }

    /// The words of a picture; `{mm}` and `{um}` stand for the units of the page.
    pub fn words(self, key: &str) -> String {
        let words = self.texts.of(key).replace("{mm}", self.mm().sign);
        words.replace("{um}", self.um().sign)
    }

    /// The same for words with `{from}` and `{to}`, deviations in µm.
    pub(super) fn between(self, key: &str, (from, to): (f64, f64)) -> String {
        let number = |um: f64| self.decimal(&rounded(um * self.um().each, 6).to_string());
        let words = self.words(key).replace("{from}", &number(from));
        words.replace("{to}", &number(to))
    }

    /// A printed number with the decimal mark of the language.
    pub(super) fn decimal(self, number: &str) -> String {
        number.replace('.', self.texts.of("decimal"))
    }

    /// A deviation without its unit; `decimals` are those of µm.
    pub(super) fn deviation(self, um: f64, decimals: usize) -> String {
        let decimals = match self.shown {
            Shown::Metric => decimals,
            Shown::Inch => decimals.saturating_sub(1),
        };
        let number = format!("{:.decimals$}", Figure(um * self.um().each));
        self.decimal(&number)
    }

    /// A position or a distance with its unit: micrometres, or tenths of a thousandth of an inch.
    pub(super) fn position(self, mm: f64) -> String {
        let decimals = match self.shown {
            Shown::Metric => 3,
            Shown::Inch => 4,
        };
        let number = rounded(mm * self.mm().each, decimals).to_string();
        format!("{} {}", self.decimal(&number).replace('-', "\u{2212}"), self.mm().sign)
    }

    /// Ends of a scale for several panels, µm: round numbers in the unit that is shown.
    pub(super) fn around(self, um: impl Iterator<Item = f64>) -> (f64, f64) {
        let each = self.um().each;
        let (low, high) = scale::around(um.map(|um| um * each));
        (low / each, high / each)
    }

    /// A round deviation below half of another, µm, and how it is shown.
    pub(super) fn below(self, um: f64) -> (f64, String) {
        let unit = self.um();
        let round = scale::below(um * unit.each);
        let shown = format!("{} {}", self.decimal(&round.to_string()), unit.sign);
        (round / unit.each, shown)
    }
}
