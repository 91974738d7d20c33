//! Texts of a job in comments of a control's files, which are ASCII: letters of other scripts as the
//! Latin letters that stand for them, German umlauts as German writes them without (ä → ae).

use crate::text::plain::is_unseen;
use deunicode::deunicode_with_tofu;
use std::borrow::Cow;

/// What stands for a letter that has no Latin ones.
const NO_LETTER: &str = "_";
/// The dots of an umlaut that is written as two characters.
const DOTS: char = '\u{308}';

/// The text in ASCII. One with a control or direction character stays as it is: it is refused.
pub(super) fn ascii(text: &str) -> Cow<'_, str> {
    if text.is_ascii() || text.contains(is_unseen) {
        return Cow::Borrowed(text);
    }
    let german = without_umlauts(text);
    Cow::Owned(deunicode_with_tofu(&german, NO_LETTER).trim().to_string())
}

fn without_umlauts(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let mut written = String::new();
    let mut at = 0;
    while let Some(letter) = letters.get(at).copied() {
        let dotted = letters.get(at + 1) == Some(&DOTS);
        let Some((small, pair)) = pair_of(letter, dotted) else {
            written.push(letter);
            at += 1;
            continue;
        };
        let behind = at + 1 + usize::from(dotted);
        let beside = [
            at.checked_sub(1).and_then(|at| letters.get(at)),
            letters.get(behind),
        ];
        let in_capitals = beside
            .into_iter()
            .flatten()
            .any(|letter| letter.is_uppercase());
        match (small, in_capitals) {
            (true, _) => written.push_str(pair),
            (false, true) => written.push_str(&pair.to_uppercase()),
            (false, false) => {
                written.push_str(&pair[..1].to_uppercase());
                written.push_str(&pair[1..]);
            }
        }
        at = behind;
    }
    written
}

/// Whether an umlaut is a small letter, and the two letters for it.
fn pair_of(letter: char, dotted: bool) -> Option<(bool, &'static str)> {
    Some(match (letter, dotted) {
        ('ä', _) | ('a', true) => (true, "ae"),
        ('ö', _) | ('o', true) => (true, "oe"),
        ('ü', _) | ('u', true) => (true, "ue"),
        ('ß', _) => (true, "ss"),
        ('Ä', _) | ('A', true) => (false, "ae"),
        ('Ö', _) | ('O', true) => (false, "oe"),
        ('Ü', _) | ('U', true) => (false, "ue"),
        _ => return None,
    })
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
    fn what_is_not_seen_is_left_to_be_refused() {
        for name in ["M\u{202e}1", "M\u{2066}ä", "ä\n"] {
            assert_eq!(ascii(name), name);
        }
    }
}
