//! How a page and its pictures show what documents hold: words, units of length, decimal mark, round numbers; and
//! the texts in the reader's language, as data.

use crate::quantity::{Figure, MM_PER_INCH, UM_PER_MM, larger, power_of_ten, rounded, smaller};
use crate::text::{Problem, Problems, Source, escaped, plain};
use std::collections::BTreeMap;

/// In which unit lengths are shown; documents are always in mm and µm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DisplayUnit {
    /// mm and µm
    #[value(name = "mm")]
    Metric,
    /// Inches and µin
    Inch,
}

/// The words of a language, and the unit of lengths.
#[derive(Clone, Copy)]
pub struct Locale<'a> {
    /// The words.
    pub texts: &'a Texts,
    /// The unit of lengths.
    pub shown: DisplayUnit,
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
    /// What goes with the unit that is shown.
    pub(super) fn either<T>(self, metric: T, inch: T) -> T {
        if self.shown == DisplayUnit::Metric { metric } else { inch }
    }

    /// Of positions.
    pub(super) fn mm(self) -> Unit {
        let (sign, each) = self.either(("mm", 1.0), ("in", 1.0 / MM_PER_INCH));
        Unit { sign, each }
    }

    /// Of deviations.
    pub(super) fn um(self) -> Unit {
        let (sign, each) = self.either(("µm", 1.0), ("µin", UM_PER_MM / MM_PER_INCH));
        Unit { sign, each }
    }

    /// The words of a picture; `{mm}` and `{um}` stand for the units of the page.
    pub fn words(self, key: &str) -> String {
        self.texts.of(key).replace("{mm}", self.mm().sign).replace("{um}", self.um().sign)
    }

    /// The same for words with `{from}` and `{to}`, deviations in µm.
    pub(super) fn between(self, key: &str, (from, to): (f64, f64)) -> String {
        let number = |um: f64| self.decimal(&rounded(um * self.um().each, 6).to_string());
        self.words(key).replace("{from}", &number(from)).replace("{to}", &number(to))
    }

    /// A printed number with the decimal mark of the language.
    pub(super) fn decimal(self, number: &str) -> String {
        number.replace('.', self.texts.of("decimal"))
    }

    /// A deviation without its unit; `decimals` are those of µm.
    pub(super) fn deviation(self, um: f64, decimals: usize) -> String {
        let decimals = self.either(decimals, decimals.saturating_sub(1));
        self.decimal(&format!("{:.decimals$}", Figure(um * self.um().each)))
    }

    /// A position or a distance with its unit: micrometres, or tenths of a thousandth of an inch.
    pub(super) fn position(self, mm: f64) -> String {
        let number = rounded(mm * self.mm().each, self.either(3, 4)).to_string();
        format!("{} {}", self.decimal(&number).replace('-', "\u{2212}"), self.mm().sign)
    }

    /// Ends of a scale for several panels, µm: round numbers in the unit that is shown.
    pub(super) fn around(self, um: impl Iterator<Item = f64>) -> (f64, f64) {
        let each = self.um().each;
        let (low, high) = around(um.map(|um| um * each));
        (low / each, high / each)
    }

    /// A round deviation below half of another, µm, and how it is shown.
    pub(super) fn below(self, um: f64) -> (f64, String) {
        let unit = self.um();
        let round = below(um * unit.each);
        let shown = format!("{} {}", self.decimal(&round.to_string()), unit.sign);
        (round / unit.each, shown)
    }
}

/// The words of a report by their keys; every key of the English ones is there.
#[derive(Clone, Debug)]
pub struct Texts {
    /// The language as HTML names it.
    pub language: String,
    words: Words,
}

/// Words by their keys.
type Words = BTreeMap<String, String>;

const LANGUAGES: [(&str, &str); 3] = [
    ("en", include_str!("../../templates/report/en.toml")),
    ("de", include_str!("../../templates/report/de.toml")),
    ("zh", include_str!("../../templates/report/zh.toml")),
];

impl Texts {
    /// The languages that are shipped.
    pub fn languages() -> impl Iterator<Item = &'static str> {
        LANGUAGES.into_iter().map(|(name, _)| name)
    }

    /// A shipped language; `None` = not among them.
    pub(crate) fn shipped(language: &str) -> Option<Result<Texts, Problems>> {
        LANGUAGES.into_iter().find(|(name, _)| *name == language).map(Texts::own)
    }

    /// The language of whatever stands on no page.
    pub fn english() -> Result<Texts, Problems> {
        Texts::own(LANGUAGES[0])
    }

    fn own((name, page): (&str, &str)) -> Result<Texts, Problems> {
        Texts::read(&Source::from_bytes(name, page.as_bytes())?, name)
    }

    /// A file of one's own: it has to hold every key of the English texts and no other.
    pub fn read(source: &Source, language: &str) -> Result<Texts, Problems> {
        let words = table(source)?;
        let [(_, english), ..] = LANGUAGES;
        let english = table(&Source::from_bytes("en", english.as_bytes())?)?;
        let absent = |keys: &Words, from: &Words| {
            keys.keys().filter(|key| !from.contains_key(*key)).cloned().collect::<Vec<_>>()
        };
        let (missing, unknown) = (absent(&english, &words), absent(&words, &english));
        let mut problems = Problems::none();
        for (what, keys) in [("lacks", missing), ("holds the unknown keys", unknown)] {
            if !keys.is_empty() {
                let words = format!("`{}` {what}: {}", source.name, keys.join(", "));
                let help = "the keys are those of the English texts (docs/visit.md §11)";
                problems.push(Problem::new(words).help(help));
            }
        }
        problems.or_ok(Texts { language: language.to_string(), words })
    }

    /// The words of a key.
    pub(super) fn of(&self, key: &str) -> &str {
        self.words.get(key).map_or("", String::as_str)
    }

    /// Whether there are words of this key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.words.contains_key(key)
    }

    /// All of them as text of a page.
    pub(super) fn escaped(&self) -> BTreeMap<&str, String> {
        let words = self.words.iter();
        words.map(|(key, words)| (key.as_str(), escaped(words))).collect()
    }
}

fn table(source: &Source) -> Result<Words, Problems> {
    toml::from_str(&source.text).map_err(|error| {
        let words = plain::page(error.message()).into_owned();
        Problem::new(format!("`{}` holds no texts: {words}", source.name))
            .help("lines of the form `key = \"words\"`")
            .into()
    })
}

// Round numbers for the ticks of an axis.

/// Ticks at round numbers between two numbers, with as many decimals as they need.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    pub(super) at: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// At most `most` ticks (2 at least), 1, 2 or 5 times a power of ten apart.
    pub(super) fn between(from: f64, to: f64, most: usize) -> Ticks {
        let (step, decimals) = step((to - from).abs(), most);
        let (first, last) = ((from / step - SLACK).ceil(), (to / step + SLACK).floor());
        let mut at = Vec::new();
        let mut number = first;
        while number <= last && at.len() <= most {
            at.push(number * step + 0.0);
            number += 1.0;
        }
        Ticks { at, decimals }
    }

    /// A tick in words.
    pub(super) fn label(&self, number: f64) -> String {
        format!("{:.*}", self.decimals, Figure(number)).replace('-', "\u{2212}")
    }
}

/// A tick that lies this part of a step outside is the end of the axis.
const SLACK: f64 = 1e-9;

/// The round number that is just large enough, and its decimals.
fn step(span: f64, most: usize) -> (f64, usize) {
    const DIGITS: [f64; 3] = [1.0, 2.0, 5.0];
    let fine = (0..=9_u8).rev();
    let fine = fine.flat_map(|n| DIGITS.map(|digit| (digit / power_of_ten(n.into()), n)));
    let coarse = (1..=12).flat_map(|n| DIGITS.map(|digit| (digit * power_of_ten(n), 0)));
    let found = fine.chain(coarse).find(|(step, _)| fits(span, *step, most));
    found.map_or((span, 0), |(step, decimals)| (step, decimals.into()))
}

fn fits(span: f64, step: f64, most: usize) -> bool {
    let intervals = u32::try_from(most.max(2) - 1).unwrap_or(u32::MAX);
    span <= step * f64::from(intervals) * (1.0 + SLACK)
}

/// Round numbers below and above all numbers and zero, for one scale of several panels.
pub(super) fn around(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers
        .fold((0.0, 0.0), |(low, high), number| (smaller(low, number), larger(high, number)));
    let span = larger(high - low, 1e-3);
    let (step, _) = step(span, 6);
    let whole = |number: f64| step * (number / step - SLACK).ceil() + 0.0;
    match (whole(-low), whole(high)) {
        (below, above) if below + above > 0.0 => (0.0 - below, above),
        _ => (-step, step),
    }
}

/// Width of the bins of a histogram of differences up to so many µm.
pub fn bin_um(largest_um: f64) -> f64 {
    larger(below(largest_um / 10.0), 0.001)
}

/// The largest round number (1, 2 or 5 times a power of ten) that is not above half of a number.
pub(super) fn below(number: f64) -> f64 {
    let exponents = (0..=6_u32).map(|n| 1.0 / power_of_ten(n)).chain((1..=6).map(power_of_ten));
    let round = exponents.flat_map(|unit| [unit, 2.0 * unit, 5.0 * unit]);
    round.filter(|round| *round <= number / 2.0).fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let ticks = Ticks::between(-3.0, 903.0, 6);
        assert_eq!(ticks.at, [0.0, 200.0, 400.0, 600.0, 800.0]);
        assert_eq!(ticks.label(-200.0), "\u{2212}200");
        let ticks = Ticks::between(-0.3, 0.3, 5);
        let labels: Vec<String> = ticks.at.iter().map(|at| ticks.label(*at)).collect();
        assert_eq!(labels, ["\u{2212}0.2", "0.0", "0.2"]);
        assert_eq!(Ticks::between(0.0, 0.0, 4).at.len(), 1);
    }

    #[test]
    fn a_height_is_round_and_holds_all() {
        assert_eq!(around([12.3, -17.0].into_iter()), (-20.0, 20.0));
        assert_eq!(around([0.31, 14.0].into_iter()), (0.0, 15.0));
        let (low, high) = around(std::iter::empty());
        assert!(low < high);
    }
}
