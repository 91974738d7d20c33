//! Text of others (machine names, manifests, comments of foreign files) on its way to a person:
//! characters that a person does not see, and that a terminal, a spreadsheet or a control may
//! obey, are shown as `�`.

use std::borrow::Cow;
use std::fmt::Write;

/// What stands for a character that is not seen.
const INSTEAD: char = '\u{fffd}';

/// Control characters; those that turn the direction of the text, end a line in some programs only,
/// or take no room (Unicode: Default_Ignorable_Code_Point without the two joiners, which some scripts need).
#[inline]
pub fn is_unseen(c: char) -> bool {
    if c.is_ascii() {
        return c.is_ascii_control();
    }
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let ends_a_line = matches!(c, '\u{2028}' | '\u{2029}');
    let takes_no_room = matches!(c, '\u{ad}' | '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}'
        | '\u{200b}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{ffa0}' | '\u{fff0}'..='\u{fffb}'
        | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e0fff}');
    turns || ends_a_line || takes_no_room || c.is_control()
}

/// A page: its line ends and tabs stay.
pub fn page(text: &str) -> Cow<'_, str> {
    shown_but(text, |c| matches!(c, '\n' | '\t'))
}

/// One line, for instance a comment: a blank for a tab, `�` for a line end.
pub fn line(text: &str) -> Cow<'_, str> {
    match text.contains('\t') {
        true => Cow::Owned(shown_but(&text.replace('\t', " "), |_| false).into_owned()),
        false => shown_but(text, |_| false),
    }
}

/// A line of a table of rows and columns that is none of them. A spreadsheet takes it apart at its separators, too: what
/// would then be a formula gets an apostrophe, which makes it a text.
pub(crate) fn comment(text: &str) -> String {
    let mut comment = "#".to_string();
    for cell in format!(" {}", line(text).trim_end()).split_inclusive([',', ';']) {
        let begins = cell.trim_start_matches([' ', '"']);
        let number = begins.trim_end_matches([' ', '"', ',', ';']).parse::<f64>();
        let is_number = number.is_ok_and(f64::is_finite); // `-inf` is a word
        let is_formula = begins.starts_with(['=', '+', '-', '@', '＝', '＋', '－', '＠']);
        comment += &cell[..cell.len() - begins.len()];
        comment += if is_formula && !is_number { "'" } else { "" };
        comment += begins;
    }
    comment
}

fn shown_but(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let goes = |c: char| is_unseen(c) && !stays(c);
    if !text.contains(goes) {
        return Cow::Borrowed(text);
    }
    let seen = text.chars().map(|c| if goes(c) { INSTEAD } else { c });
    Cow::Owned(seen.collect())
}

/// A JSON document whose texts hold no such character: `\u202e` in its place, which reads back to the
/// same text. Only texts of a document can hold one, apart from its line ends.
pub(crate) fn json(document: &str) -> Cow<'_, str> {
    let goes = |c: char| is_unseen(c) && c != '\n';
    if !document.contains(goes) {
        return Cow::Borrowed(document);
    }
    let mut escaped = String::with_capacity(document.len());
    for c in document.chars() {
        if goes(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                // Writing to a text never fails.
                let _ = write!(escaped, "\\u{unit:04x}");
            }
        } else {
            escaped.push(c);
        }
    }
    Cow::Owned(escaped)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{comment, json, line, page};
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::select;

    /// Texts of up to so many of these parts.
    pub(crate) fn texts_of(
        parts: impl Iterator<Item = impl ToString>,
        most: usize,
    ) -> impl Strategy<Value = String> {
        let parts: Vec<String> = parts.map(|part| part.to_string()).collect();
        vec(select(parts), 0..=most).prop_map(|parts| parts.concat())
    }

    #[test]
    fn what_a_terminal_would_obey_is_shown() {
        let foreign = "a\u{1b}]0;title\u{7}\tb\u{202e}c\r\nd\u{9b}31m";
        assert_eq!(page(foreign), "a�]0;title�\tb�c�\nd�31m");
        assert_eq!(line("one\ttwo\n\u{2028}three"), "one two��three");
        assert_eq!(page("Fräse 加工中心"), "Fräse 加工中心");
    }

    #[test]
    fn no_cell_of_a_comment_is_a_formula() {
        for (text, written) in [
            ("Machine: a,=cmd|'/C calc'!A0;=1+1", "# Machine: a,'=cmd|'/C calc'!A0;'=1+1"),
            ("a, \"@SUM(A1)\",\t+a;-b", "# a, \"'@SUM(A1)\", '+a;'-b"),
            ("=1,-inf;-2+3+cmd|x", "# '=1,'-inf;'-2+3+cmd|x"),
            (
                "on the lines X, Y, Z, mm: 450, -360, +36.5",
                "# on the lines X, Y, Z, mm: 450, -360, +36.5",
            ),
            ("zero at X 0 +, Y 0 -: all 1 ", "# zero at X 0 +, Y 0 -: all 1"),
        ] {
            assert_eq!(comment(text), written);
            assert_eq!(comment(&written[2..]), written);
        }
    }

    fn unseen() -> Vec<char> {
        let ranges = ('\u{7f}'..='\u{9f}').chain('\u{202a}'..='\u{202e}');
        ranges.chain(['\u{ad}', '\u{e0001}']).collect()
    }

    proptest! {
        #[test]
        fn json_reads_back_to_the_same_text(
            chars in vec(prop_oneof![any::<char>(), select(unseen())], 0..64),
        ) {
            let text = String::from_iter(chars);
            let document = serde_json::to_string_pretty(&[&text]).expect("a text");
            let escaped = json(&document);
            prop_assert!(!escaped.contains(|c| super::is_unseen(c) && c != '\n'));
            let found: Vec<String> = serde_json::from_str(&escaped).expect("JSON");
            prop_assert_eq!(found, vec![text]);
        }
    }
}
