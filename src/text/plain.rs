//! Text of others (machine names, manifests, comments of foreign files) on its way to a person:
//! characters that a person does not see, and that a terminal, a spreadsheet or a control may
//! obey, are shown as `�`.

use std::borrow::Cow;

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
    let escaped = document.split_inclusive(goes).map(|part| {
        let seen = part.trim_end_matches(goes);
        let units = part[seen.len()..].encode_utf16().map(|unit| format!("\\u{unit:04x}"));
        seen.to_string() + &units.collect::<String>()
    });
    Cow::Owned(escaped.collect())
}

// Text of others as HTML: nothing in it is obeyed.

/// Where a person writes, in texts for a page.
pub(crate) const BLANK: &str = "________";
/// The same on an HTML page, as large as handwriting; its style says how large.
const BLANK_IN_HTML: &str = "<span class=\"blank\">&#160;</span>";

/// What a person ticks, in texts for a page.
pub(crate) const BOX: &str = "[ ]";
const BOX_IN_HTML: &str = "<span class=\"box\">&#160;</span>";

/// The marks of the checklist's texts, the longer ones first, and their elements.
const MARKS: [(&str, &str); 3] = [("**", "strong"), ("*", "em"), ("`", "code")];

/// Text of people as text of a page or a drawing.
pub(crate) fn escaped(text: &str) -> String {
    let text = line(text);
    let (mut out, mut rest) = (String::with_capacity(text.len()), &*text);
    let name = |byte| match byte {
        b'&' => "&amp;",
        b'<' => "&lt;",
        b'>' => "&gt;",
        b'"' => "&quot;",
        b'\'' => "&#39;",
        _ => "",
    };
    while let Some(at) = rest.bytes().position(|byte| !name(byte).is_empty()) {
        out.push_str(&rest[..at]);
        out.push_str(name(rest.as_bytes()[at]));
        rest = &rest[at + 1..];
    }
    out + rest
}

/// A text of the checklist: escaped, its marks as elements, [`BLANK`] as a place to write on, [`BOX`] as one to tick.
pub(crate) fn marked(text: &str) -> String {
    elements(&escaped(&text.replace('\n', " ")))
}

fn elements(text: &str) -> String {
    let (mut out, mut rest) = (String::with_capacity(text.len()), text);
    while let Some(at) = rest.bytes().position(|byte| b"*`_[".contains(&byte)) {
        let (before, from) = rest.split_at(at);
        let (element, after) = element(from);
        out.push_str(before);
        out.push_str(&element);
        rest = after;
    }
    out + rest
}

/// What begins with a mark, and the text behind it; a mark without its end is a letter.
fn element(text: &str) -> (String, &str) {
    if let Some(after) = text.strip_prefix(BLANK) {
        return (BLANK_IN_HTML.to_string(), after);
    }
    if let Some(after) = text.strip_prefix(BOX) {
        return (BOX_IN_HTML.to_string(), after);
    }
    for (mark, tag) in MARKS {
        let inside = text.strip_prefix(mark);
        let inside = inside.filter(|inside| !inside.starts_with([' ', '*']));
        if let Some((inside, after)) = inside.and_then(|inside| inside.split_once(mark)) {
            let inside = match tag {
                "code" => inside.to_string(),
                _ => elements(inside),
            };
            return (format!("<{tag}>{inside}</{tag}>"), after);
        }
    }
    let (letter, after) = text.split_at(1);
    (letter.to_string(), after)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{comment, escaped, json, line, marked, page};
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

    #[test]
    fn text_of_others_is_shown_and_not_obeyed() {
        assert_eq!(escaped("<b a=\"1\">&\u{1b}['"), "&lt;b a=&quot;1&quot;&gt;&amp;�[&#39;");
    }

    #[test]
    fn marks_are_elements_and_the_rest_is_text() {
        for (text, html) in [
            ("run `A<1>.MPF` **now**", "run <code>A&lt;1&gt;.MPF</code> <strong>now</strong>"),
            ("*(of `MD_1`)*: 3", "<em>(of <code>MD_1</code>)</em>: 3"),
            ("found: ________ µm", "found: <span class=\"blank\">&#160;</span> µm"),
            ("[ ] a[0,X]", "<span class=\"box\">&#160;</span> a[0,X]"),
            ("2 * 3 ` **4", "2 * 3 ` **4"),
            ("`<**`*</i>*", "<code>&lt;**</code><em>&lt;/i&gt;</em>"),
        ] {
            assert_eq!(marked(text), html, "{text}");
        }
    }
}
