//! A line of a control's file as a regular expression with named fields, checked when its profile is loaded.

use super::fact::{Stated, Word};
use crate::text::document::Section;
use crate::text::problem::{nearest, shown};
use regex::bytes::{Captures, Regex, RegexBuilder};
use std::ops::Range;

/// What a part of a line says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Field {
    /// The axis that the lines below are for, base and output in one.
    Axis,
    /// The axis that is looked up.
    Base,
    /// The axis that is corrected.
    Output,
    /// Number of a point.
    Point,
    /// Where it lies.
    Position,
    /// Its value, in both directions.
    Value,
    /// Its value while the base axis moves in +.
    Forward,
    /// Its value while the base axis moves in −.
    Reverse,
    /// Where the first point lies.
    Start,
    /// The distance of points.
    Spacing,
    /// How many points there are.
    Count,
    /// The number of the last one.
    Last,
    /// The unit of the values, as a word.
    Unit,
}

impl Field {
    /// The word of profiles.
    pub(crate) fn word(self) -> &'static str {
        self.word_of()
    }
}

impl Word for Field {
    const WORDS: &'static [(&'static str, Field)] = &[
        ("axis", Field::Axis),
        ("base", Field::Base),
        ("output", Field::Output),
        ("point", Field::Point),
        ("position", Field::Position),
        ("value", Field::Value),
        ("forward", Field::Forward),
        ("reverse", Field::Reverse),
        ("start", Field::Start),
        ("spacing", Field::Spacing),
        ("count", Field::Count),
        ("last", Field::Last),
        ("unit", Field::Unit),
    ];
}

/// A pattern that takes a whole line.
#[derive(Clone, Debug)]
pub struct Pattern {
    text: String,
    regex: Regex,
    fields: Vec<Field>,
}

impl PartialEq for Pattern {
    fn eq(&self, other: &Pattern) -> bool {
        self.text == other.text
    }
}

/// Memory of one pattern, far above what lines of tables need.
const MOST_BYTES: usize = 1 << 20;

impl Pattern {
    /// A pattern, or what is wrong with it.
    fn new(text: &str) -> Result<Pattern, String> {
        if text.contains(['\n', '\r']) || text.contains(r"\n") || text.contains(r"\r") {
            return Err("holds a line end, so it can take no line".to_string());
        }
        let whole = format!("^(?:{text})$");
        let mut builder = RegexBuilder::new(&whole);
        let builder = builder.unicode(false).size_limit(MOST_BYTES);
        let regex = builder.build().map_err(|error| why(&error))?;
        if regex.is_match(b"") {
            return Err("takes an empty line, which means nothing".to_string());
        }
        let names = regex.capture_names().flatten();
        let fields = names.map(field).collect::<Result<Vec<Field>, String>>()?;
        let text = text.to_string();
        Ok(Pattern { text, regex, fields })
    }

    /// The fields that it can have.
    pub(crate) fn fields(&self) -> impl Iterator<Item = Field> {
        self.fields.iter().copied()
    }

    /// Whether a line of it says anything.
    pub(crate) fn has_fields(&self) -> bool {
        !self.fields.is_empty()
    }

    /// What a line says, if it is of this pattern: each field with its bytes in the line.
    pub(crate) fn take(&self, line: &str) -> Option<Vec<(Field, Range<usize>)>> {
        let found: Captures<'_> = self.regex.captures(line.as_bytes())?;
        let part = |field: Field| Some((field, found.name(field.word_of())?.range()));
        Some(self.fields().filter_map(part).collect())
    }
}

fn field(name: &str) -> Result<Field, String> {
    let known = Field::WORDS.iter().find(|(word, _)| *word == name);
    known.map(|(_, field)| *field).ok_or_else(|| {
        let words = Field::WORDS.iter().map(|(word, _)| *word);
        let near = nearest(name, words.clone()).map(|near| format!(", did you mean `{near}`?"));
        let list: Vec<&str> = words.collect();
        let near = near.unwrap_or_else(|| format!(", expected one of {}", list.join(", ")));
        format!("has the unknown field `{}`{near}", shown(name))
    })
}

/// The last line of what the regular expressions say; the lines above draw the pattern.
fn why(error: &regex::Error) -> String {
    let text = error.to_string();
    let last = text.lines().last().unwrap_or_default();
    let last = last.trim_start_matches("error: ");
    format!("is no regular expression: {}", shown(last))
}

impl Stated for Vec<Pattern> {
    fn read(fact: &Section<'_>) -> Option<Self> {
        let texts = fact.texts("value")?;
        let mut patterns = Vec::new();
        for (index, text) in texts.iter().enumerate() {
            match Pattern::new(text) {
                Ok(pattern) => patterns.push(pattern),
                Err(wrong) => fact.problem_in(
                    "value",
                    index,
                    format!("the pattern `{}` {wrong}", shown(text)),
                    "a pattern is a regular expression for a whole line, with fields such as (?<position>\\S+)",
                ),
            }
        }
        (patterns.len() == texts.len()).then_some(patterns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_takes_a_whole_line_and_says_where_its_fields_stand() {
        let pattern = Pattern::new(r"(?<position>\S+), *(?<value>\S+)").expect("a pattern");
        let found = pattern.take("10.5,  -2").expect("a line");
        assert_eq!(found, [(Field::Position, 0..4), (Field::Value, 7..9)]);
        assert_eq!(pattern.take("10.5,  -2 x"), None);
    }

    #[test]
    fn a_pattern_that_cannot_be_meant_is_refused() {
        for (text, says) in [
            (r"(?<postion>\S+)", "unknown field `postion`, did you mean `position`?"),
            (r"(?<value>\S+", "is no regular expression"),
            (r"(?<value>\S*)", "takes an empty line"),
            (r"a\n(?<value>\S+)", "can take no line"),
        ] {
            let wrong = Pattern::new(text).expect_err(text);
            assert!(wrong.contains(says), "{text}: {wrong}");
        }
    }
}
