//! Numbers and texts as they stand in a control's files, which are ASCII: letters of other scripts as the
//! Latin letters that stand for them, German umlauts as German writes them without (ä → ae).

use crate::quantity::{Figure, power_of_ten};
use crate::text::is_unseen;
use deunicode::deunicode_with_tofu;
use std::borrow::Cow;
use tera::Map;
use tera::value::Key;

// What templates see: texts, lists and names, as the template engine holds them. Made once, so that no other tree of
// the same texts stands between.

/// A finished text, a list, or names with what they stand for.
pub(crate) type Seen = tera::Value;

/// Names in this order.
pub(crate) fn named<const N: usize>(names: [(&'static str, Seen); N]) -> Seen {
    names.into_iter().map(|(name, own)| (Key::Str(name), own)).collect::<Map>().into()
}

/// Names, and one more.
pub(crate) fn with(names: Seen, name: &'static str, own: Seen) -> Seen {
    let mut names = names.into_map().unwrap_or_default();
    names.insert(Key::Str(name), own);
    names.into()
}

/// `seen! { "name": text, … }`: names in this order, each with a text, a list of texts, or what is seen of something.
macro_rules! seen {
    ($($name:literal: $own:expr),* $(,)?) => {
        $crate::write::control_text::named([$(($name, $own.into())),*])
    };
}

pub(crate) use seen;

/// A number with a fixed number of decimals, never `-0`. Where it is the nearest to so many last digits, and they are
/// far from all that it can tell apart, they are its text: nothing has to be searched.
#[allow(clippy::cast_possible_truncation, reason = "a whole number of up to 15 digits")]
pub(crate) fn fixed(number: f64, decimals: u32) -> String {
    let (scale, places) = (power_of_ten(decimals), decimals as usize);
    let digits = (number * scale).round();
    let is_nearest = (digits / scale).to_bits() == (number + 0.0).to_bits();
    if !((1..16).contains(&decimals) && digits.abs() <= 1e15 && is_nearest) {
        return format!("{:.*}", places, Figure(number));
    }
    with_point(digits as i64, places)
}

/// So many last digits as a number with so many decimals, never `-0`.
pub(crate) fn with_point(digits: i64, decimals: usize) -> String {
    let sign = if digits < 0 { "-" } else { "" };
    let digits = format!("{:0least$}", digits.unsigned_abs(), least = decimals + 1);
    let (whole, parts) = digits.split_at(digits.len() - decimals);
    [sign, whole, ".", parts].concat()
}

/// The same without trailing zeros.
pub(crate) fn trimmed(number: f64, decimals: u32) -> String {
    Figure(number).trimmed(decimals as usize)
}

/// Whether a text cannot end a comment, start a block or a program.
pub(crate) fn is_comment_text(text: &str) -> bool {
    let safe = |c: char| (' '..='~').contains(&c) && !"%;()[]{}<>".contains(c);
    text.chars().all(safe) && text.len() <= LONGEST_TEXT
}

/// Longest name in a comment: the line stays below 80 characters.
const LONGEST_TEXT: usize = 60;
/// What a text in a comment has to be.
pub(crate) const COMMENT_TEXT: &str =
    "up to 60 printable characters without line breaks, `%`, `;` or brackets";

/// What stands for a letter that has no Latin ones.
const NO_LETTER: &str = "_";

/// The text in ASCII. One with a control or direction character stays as it is: it is refused.
pub(crate) fn ascii(text: &str) -> Cow<'_, str> {
    if text.is_ascii() || text.contains(is_unseen) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(deunicode_with_tofu(&without_umlauts(text), NO_LETTER).trim().to_string())
}

fn without_umlauts(text: &str) -> String {
    const PAIRS: [(char, &str); 7] =
        [('ä', "ae"), ('ö', "oe"), ('ü', "ue"), ('Ä', "Ae"), ('Ö', "Oe"), ('Ü', "Ue"), ('ß', "ss")];
    // An umlaut may be a letter and its dots.
    let joined = PAIRS[..6].iter().fold(text.to_string(), |text, (umlaut, pair)| {
        text.replace(&format!("{}\u{308}", &pair[..1]), &umlaut.to_string())
    });
    let letters: Vec<char> = joined.chars().collect();
    let is_capital = |at: usize| letters.get(at).is_some_and(|letter| letter.is_uppercase());
    let written = |(at, letter): (usize, &char)| {
        let in_capitals =
            letter.is_uppercase() && (is_capital(at.wrapping_sub(1)) || is_capital(at + 1));
        match PAIRS.iter().find(|(umlaut, _)| umlaut == letter) {
            Some((_, pair)) if in_capitals => pair.to_uppercase(),
            Some((_, pair)) => (*pair).to_string(),
            None => letter.to_string(),
        }
    };
    letters.iter().enumerate().map(written).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_scripts_become_latin_letters() {
        for (name, expected) in [
            ("Fräse Süd, groß", "Fraese Sued, gross"),
            ("FRÄSE Über", "FRAESE Ueber"),
            ("Fra\u{308}se", "Fraese"),
            ("Ö", "Oe"),
            ("é à ñ č ø ł", "e a n c o l"),
            ("Станок 5", "Stanok 5"),
            ("VMC 900", "VMC 900"),
        ] {
            assert_eq!(ascii(name), expected);
        }
        assert!(ascii("机床 7").is_ascii() && !ascii("机床 \u{e000}").contains('?'));
    }

    #[test]
    fn numbers_are_written_as_the_formatter_does() {
        use proptest::prelude::*;
        let number = (-1_000_000_000_i64..1_000_000_000, 0..14_u32, -1e-9..1e-9_f64);
        proptest!(|((digits, of, beside) in number, decimals in 0..14_u32)| {
            for number in [digits as f64 / power_of_ten(of), digits as f64 / power_of_ten(of) + beside] {
                let usual = format!("{:.*}", decimals as usize, Figure(number));
                prop_assert_eq!(fixed(number, decimals), usual);
            }
        });
    }

    #[test]
    fn numbers_have_their_decimals_and_no_negative_zero() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-0.012, 3), "-0.012");
        assert_eq!(fixed(1234.5, 0), "1234"); // half to even, as the formatter of numbers does
        assert_eq!(fixed(-0.3, 1), "-0.3");
        assert_eq!(fixed(-1e12, 0), "-1000000000000");
        assert_eq!(fixed(-1.0, 12), "-1.000000000000");
        assert_eq!(fixed(-0.05, 13), "-0.0500000000000");
        assert_eq!(fixed(f64::NAN, 3), "NaN"); // no input brings one here; a control would refuse it
    }

    #[test]
    fn what_is_not_seen_is_left_to_be_refused() {
        for name in ["M\u{202e}1", "M\u{2066}ä", "ä\n"] {
            assert_eq!(ascii(name), name);
        }
    }
}
