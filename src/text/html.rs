//! Text of others as HTML: nothing in it is obeyed.

use crate::text::plain;

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
    const NAMES: [(char, &str); 5] =
        [('&', "&amp;"), ('<', "&lt;"), ('>', "&gt;"), ('"', "&quot;"), ('\'', "&#39;")];
    let text = plain::line(text);
    let mut out = String::with_capacity(text.len());
    for part in text.split_inclusive(NAMES.map(|(sign, _)| sign)) {
        let name = NAMES.iter().find(|(sign, _)| part.ends_with(*sign));
        out.push_str(name.map_or(part, |_| &part[..part.len() - 1]));
        out.push_str(name.map_or("", |(_, name)| name));
    }
    out
}

/// A text of the checklist: escaped, its marks as elements, [`BLANK`] as a place to write on, [`BOX`] as one to tick.
pub(crate) fn marked(text: &str) -> String {
    elements(&escaped(&text.replace('\n', " ")))
}

fn elements(text: &str) -> String {
    let (mut out, mut rest) = (String::with_capacity(text.len()), text);
    while let Some(at) = rest.find(['*', '`', '_', '[']) {
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
mod tests {
    use super::*;

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
