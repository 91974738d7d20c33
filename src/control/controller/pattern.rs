//! A line of a control's file as a regular expression with named fields, checked when its profile is loaded.

use super::fact::FactValue;
use crate::text::{Section, Word, joined, nearest, shown, words};
use regex_automata::PatternID;
use regex_automata::meta::{BuildError, Config, Regex};
use std::ops::Range;

words! {
    /// What a part of a line says.
    pub(crate) enum Field {
        /// The axis that the lines below are for, base and output in one.
        Axis = "axis",
        /// The axis that is looked up.
        Base = "base",
        /// The axis that is corrected.
        Output = "output",
        /// The corrected axis, where a line names it a second time.
        Same = "same",
        /// The name of a table, where its lines are told apart by it.
        Table = "table",
        /// Number of a point.
        Point = "point",
        /// Where it lies.
        Position = "position",
        /// Its value, in both directions.
        Value = "value",
        /// Its value while the base axis moves in +.
        Forward = "forward",
        /// Its value while the base axis moves in −.
        Reverse = "reverse",
        /// Where the first point lies.
        Start = "start",
        /// The distance of points.
        Spacing = "spacing",
        /// How many points there are.
        Count = "count",
        /// The number of the last one.
        Last = "last",
        /// The unit of the values, as a word.
        Unit = "unit",
        /// The name of a set of tables, of which the control loads one; the lines before it mean something else.
        Set = "set",
        /// Something else, of which the lines below are, to the next set.
        Other = "other",
        /// The same, in a line that only the whole configuration of a control has.
        Whole = "whole",
    }
}

/// A pattern that takes a whole line.
#[derive(Clone, Debug)]
pub struct Pattern {
    text: String,
    regex: Regex,
    fields: Vec<Group>,
}

/// A named group: its place among all groups, what it says, and of which table of the line.
#[derive(Clone, Copy, Debug)]
struct Group {
    place: usize,
    field: Field,
    table: u8,
}

/// What a line says of one of its tables: each field with its bytes in the line.
pub(crate) type Said = Vec<(Field, Range<usize>)>;

impl PartialEq for Pattern {
    fn eq(&self, other: &Pattern) -> bool {
        self.text == other.text
    }
}

/// Memory of all patterns of a fact together, with what a search takes; those of real lines need a fiftieth.
const MOST_BYTES: usize = 4 << 20;

/// Bytes of a pattern; each may become 7 kB before its memory can be counted.
const LONGEST: usize = 1024;

impl Pattern {
    /// A pattern, or what is wrong with it; its memory is taken from what is left for all of them.
    fn new(text: &str, left: &mut usize) -> Result<Pattern, String> {
        if text.contains(['\n', '\r']) || text.contains(r"\n") || text.contains(r"\r") {
            return Err("holds a line end, so it can take no line".to_string());
        }
        if text.len() > LONGEST {
            return Err(format!("has {} bytes, expected at most {LONGEST}", text.len()));
        }
        let mut builder = Regex::builder();
        let builder = builder.configure(Config::new().nfa_size_limit(Some(*left)));
        let built = builder.build(&format!("^(?:{text})$"));
        let regex = built.map_err(|error| why(&error).unwrap_or_else(|| too_large(left)))?;
        // A search keeps two lists of states, each state with the places of all groups.
        let rest = left.checked_sub(regex.memory_usage() * (1 + regex.captures_len()));
        *left = rest.ok_or_else(|| too_large(left))?;
        if regex.is_match("") {
            return Err("takes an empty line, which means nothing".to_string());
        }
        let names = regex.group_info().pattern_names(PatternID::ZERO).enumerate();
        let named = names.filter_map(|(place, name)| Some(group(place, name?)));
        let mut fields = named.collect::<Result<Vec<Group>, String>>()?;
        fields.sort_by_key(|group| group.table);
        const NAMES: [Field; 4] = [Field::Axis, Field::Base, Field::Output, Field::Table];
        let names_own = |own: &&[Group]| own.iter().any(|group| NAMES.contains(&group.field));
        let tables = fields.chunk_by(|a, b| a.table == b.table);
        if let Some(other) = tables.skip_while(|own| own[0].table == 1).find(|own| !names_own(own))
        {
            let number = other[0].table;
            return Err(format!(
                "says something of a table {number} without `table{number}`, `base{number}`, `output{number}` or `axis{number}`"
            ));
        }
        Ok(Pattern { text: text.to_string(), regex, fields })
    }

    /// The fields that it can have.
    pub(crate) fn fields(&self) -> impl Iterator<Item = Field> {
        self.fields.iter().map(|group| group.field)
    }

    /// Whether its field for the corrected axis takes a name: up to its bracket, the first behind which it is an
    /// expression of its own. `None` = it has no such field.
    pub(crate) fn takes_axis(&self, name: &str) -> Option<bool> {
        let own = [Field::Axis, Field::Output].map(|field| format!("<{}>", field.word()));
        let (before, rest) = own.iter().find_map(|field| self.text.split_once(field))?;
        let case = if before.contains("(?i") { "(?i)" } else { "" };
        let mut ends =
            rest.match_indices(')').map(|(end, _)| format!("{case}^(?:{})$", &rest[..end]));
        ends.find_map(|own| Regex::new(&own).ok()).map(|own| own.is_match(name))
    }

    /// Whether a line of it says anything of tables.
    pub(crate) fn has_fields(&self) -> bool {
        self.fields().any(|field| !matches!(field, Field::Other | Field::Whole))
    }

    /// What a line says, if it is of this pattern, of each table that it names.
    pub(crate) fn take(&self, line: &str) -> Option<Vec<Said>> {
        let mut found = self.regex.create_captures();
        self.regex.captures(line, &mut found);
        let part = |group: &Group| Some((group.field, found.get_group(group.place)?.range()));
        let tables = self.fields.chunk_by(|a, b| a.table == b.table);
        let said = tables.map(|own| own.iter().filter_map(part).collect());
        found.is_match().then(|| said.filter(|own: &Said| !own.is_empty()).collect())
    }
}

/// A field by its name, behind which the second and the third table of a line have their number: `base2`.
fn group(place: usize, name: &str) -> Result<Group, String> {
    let mut numbered = [(2, '2'), (3, '3')].into_iter();
    let numbered = numbered.find_map(|(table, digit)| Some((table, name.strip_suffix(digit)?)));
    let (table, word) = numbered.unwrap_or((1, name));
    let known = Field::WORDS.iter().find(|(known, _)| *known == word);
    known.map(|(_, field)| Group { place, field: *field, table }).ok_or_else(|| {
        let words = Field::WORDS.iter().map(|(word, _)| *word);
        let near = nearest(name, words.clone()).map(|near| format!(", did you mean `{near}`?"));
        let near = near.unwrap_or_else(|| format!(", expected one of {}", joined(words)));
        format!("has the unknown field `{}`{near}", shown(name))
    })
}

/// The last line of what the regular expressions say; the lines above draw the pattern. `None` = it is too large.
fn why(error: &BuildError) -> Option<String> {
    let text = error.syntax_error()?.to_string();
    let last = text.lines().last().unwrap_or_default().trim_start_matches("error: ");
    Some(format!("is no regular expression: {}", shown(last)))
}

/// Nothing is left for those behind it.
fn too_large(left: &mut usize) -> String {
    *left = 0;
    format!("needs, with those before it, more than {} MiB", MOST_BYTES >> 20)
}

impl FactValue for Vec<Pattern> {
    fn read(fact: &Section<'_>) -> Option<Self> {
        let texts = fact.texts("value")?;
        let (mut patterns, mut left) = (Vec::new(), MOST_BYTES);
        for (index, text) in texts.iter().enumerate() {
            if left == 0 {
                break;
            }
            match Pattern::new(text, &mut left) {
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

    fn pattern(text: &str) -> Result<Pattern, String> {
        Pattern::new(text, &mut MOST_BYTES.clone())
    }

    #[test]
    fn a_pattern_takes_a_whole_line_and_says_where_its_fields_stand() {
        let own = pattern(r"(?<position>\S+), *(?<value>\S+)").expect("a pattern");
        let found = own.take("10.5,  -2").expect("a line");
        assert_eq!(found, [[(Field::Position, 0..4), (Field::Value, 7..9)]]);
        assert_eq!(own.take("10.5,  -2 x"), None);
    }

    #[test]
    fn a_line_of_several_tables_says_what_it_says_of_each() {
        let own =
            pattern(r"(?<output>\d)=(?<base>\d)(?<table>[A-Z])(?:\+(?<base2>\d)(?<table2>[A-Z]))?");
        let own = own.expect("a pattern");
        let [first, second] = &own.take("0=0A+1B").expect("a line")[..] else {
            panic!("two tables");
        };
        assert_eq!(first[..], [(Field::Output, 0..1), (Field::Base, 2..3), (Field::Table, 3..4)]);
        assert_eq!(second[..], [(Field::Base, 5..6), (Field::Table, 6..7)]);
        assert_eq!(own.take("0=0A").expect("a line").len(), 1);
    }

    #[test]
    fn the_field_of_an_axis_takes_its_names() {
        for (text, takes, not) in [
            ("AL (?<axis>[XYZ]) END", "Z", "A"),
            (r"(?<output>(?:A\)|B)+) by (?<base>\d)", "A)B", "1"),
            ("(?P<axis>[)]) x", ")", "x"),
        ] {
            let own = pattern(text).expect("a pattern");
            assert_eq!([takes, not].map(|name| own.takes_axis(name)), [Some(true), Some(false)]);
        }
        assert_eq!(pattern(r"(?<value>\S+)").expect("a pattern").takes_axis("X"), None);
    }

    #[test]
    fn a_pattern_takes_letters_and_no_part_of_one() {
        let letter = pattern("(?<axis>.).*").expect("a pattern");
        assert_eq!(letter.take("äX.mp"), Some(vec![vec![(Field::Axis, 0..2)]]));
        assert_eq!(letter.take("加工中心"), Some(vec![vec![(Field::Axis, 0..3)]]));
        assert!(pattern(r"(?-u:(?<axis>\xC3)).*").is_err());
        let long = r"\w".repeat(600);
        assert_eq!(pattern(&long).err(), Some("has 1200 bytes, expected at most 1024".into()));
    }

    #[test]
    fn the_patterns_of_a_fact_share_one_memory() {
        let mut left = MOST_BYTES;
        let usual =
            (0..30).filter(|_| Pattern::new(r"P(?<point>\d+) (?<value>\S+)", &mut left).is_ok());
        assert_eq!(usual.count(), 30);
        for large in [r"x\S{200}", "x(a)(b)(c)(d)(e)(f)(g)(h){50}", "(?:x?){9999999}"] {
            let mut left = MOST_BYTES;
            let kept = (0..1000).take_while(|_| Pattern::new(large, &mut left).is_ok());
            assert!(kept.count() < 1000, "{large}");
            let wrong = Pattern::new(large, &mut left).expect_err(large);
            assert!(wrong.contains("more than 4 MiB"), "{wrong}");
        }
    }

    #[test]
    fn a_pattern_that_cannot_be_meant_is_refused() {
        for (text, says) in [
            (r"(?<postion>\S+)", "unknown field `postion`, did you mean `position`?"),
            (r"(?<value>\S+", "is no regular expression"),
            (r"(?<value>\S*)", "takes an empty line"),
            (r"(?<value>\S+) (?<value2>\S+)", "says something of a table 2 without `table2`"),
            (r"a\n(?<value>\S+)", "can take no line"),
        ] {
            let wrong = pattern(text).expect_err(text);
            assert!(wrong.contains(says), "{text}: {wrong}");
        }
    }
}
