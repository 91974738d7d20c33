//! What a template may say, and how much work it is, before it is rendered.
//!
//! The engine bounds neither loops nor texts that grow (`{% set s = s ~ s %}` forty times is a terabyte), and
//! has no place to count them. So a template says what a layout needs and no more: names, loops over lists
//! of the context, choices. Then no value is longer than one of the context, and how many tags are executed at
//! most follows from the lengths of the lists.

use regex_automata::meta::Regex;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::LazyLock;

/// Filters whose result does not grow with a list.
const FILTERS: [&str; 7] = ["default", "first", "last", "length", "lower", "trim", "upper"];
/// Words behind which a bracket groups; behind any other it would call a function.
const GROUPING: [&str; 5] = ["if", "elif", "and", "or", "not"];
const SIGNS: &str = "=!<>.,|()";

#[allow(clippy::expect_used, reason = "both are written here, and every test compiles them")]
/// A comment, `{{ … }}` or `{% … %}`; and a word, a text in quotes or a sign of these.
static PATTERNS: LazyLock<[Regex; 2]> = LazyLock::new(|| {
    let quoted = r#""(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|`(?:\\.|[^`\\])*`"#;
    let inside = format!(r#"-?((?:{quoted}|[^"'`])*?)-?"#);
    [
        format!(r"(?s)\{{#.*?#\}}|\{{\{{{inside}\}}\}}|\{{%{inside}%\}}"),
        format!(r"(?s){quoted}|[A-Za-z0-9_]+|[^ \t\r\n]"),
    ]
    .map(|pattern| Regex::new(&pattern).expect("it is a pattern"))
});

/// Where a template says more than a layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    /// Bytes of the template.
    pub(super) span: Range<usize>,
    /// What was found and what was expected.
    pub(super) message: String,
}

/// Of each tag of a template the loops around it, each with the first and the last name of its list.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    tags: Vec<Vec<(String, String)>>,
}

/// A word or sign and where it stands in the template.
type Placed<'a> = (&'a str, Range<usize>);

impl Layout {
    /// The layout of a template that the engine has parsed.
    pub(super) fn of(template: &str) -> Result<Layout, Wrong> {
        let mut layout = Layout::default();
        let mut open: Vec<Option<(String, String)>> = Vec::new(); // `None` is a choice
        let [tag, word] = &*PATTERNS;
        for found in tag.captures_iter(template) {
            let (print, does) = (found.get_group(1), found.get_group(2));
            let Some(inside) = print.or(does) else {
                continue; // a comment
            };
            let words = word.find_iter(&template[inside.range()]).map(|word| {
                let span = inside.start + word.start()..inside.start + word.end();
                (&template[span.clone()], span)
            });
            let words: Vec<Placed<'_>> = words.collect();
            check(&words)?;
            layout.tags.push(open.iter().flatten().cloned().collect());
            let Some((kind, span)) = words.first().filter(|_| does.is_some()) else {
                continue;
            };
            match *kind {
                "for" => open.push(Some(list_of(&words)?)),
                "if" => open.push(None),
                "endfor" | "endif" => _ = open.pop(),
                "elif" | "else" => {}
                other => return Err(wrong(span, &format!("`{other}`"))),
            }
        }
        Ok(layout)
    }

    /// Tags that rendering executes, at most: all branches count, and each list is as long as the longest of
    /// its name, or of all where none has its name.
    pub(super) fn work(&self, context: &tera::Context) -> u64 {
        let loops = self.tags.iter().flatten();
        let roots: BTreeSet<&str> = loops.clone().map(|(root, _)| root.as_str()).collect();
        let measured = |longest: &mut [(&str, Option<u64>)]| {
            let values = roots.iter().filter_map(|root| Some((*root, context.get(root)?)));
            values.for_each(|(root, value)| measure(root, value, longest));
        };
        let lists: BTreeSet<&str> = loops.map(|(_, list)| list.as_str()).collect();
        let mut longest: Vec<_> = lists.into_iter().map(|list| (list, None)).collect();
        measured(&mut longest);
        let mut all = [(ANY, None)];
        if longest.iter().any(|(_, length)| length.is_none()) {
            measured(&mut all);
        }
        let length = |list: &str| {
            let own = longest.iter().find(|(name, _)| *name == list);
            own.and_then(|(_, length)| *length).or(all[0].1).map_or(1, |n| 1.max(n))
        };
        let turns = |loops: &Vec<(String, String)>| {
            loops.iter().map(|(_, list)| length(list)).fold(1, u64::saturating_mul)
        };
        self.tags.iter().map(turns).fold(0, u64::saturating_add)
    }
}

/// Lists of any name.
const ANY: &str = "";

/// Notes the longest list, map or text of each of these names in a value.
fn measure(name: &str, value: &tera::Value, longest: &mut [(&str, Option<u64>)]) {
    for (_, known) in longest.iter_mut().filter(|(own, _)| *own == name || *own == ANY) {
        let length = value.len().map_or(0, |length| length as u64);
        *known = Some(length).max(*known);
    }
    for item in value.as_array().into_iter().flatten() {
        measure(LISTED, item, longest);
    }
    for (key, item) in value.as_map().into_iter().flatten() {
        measure(key.as_str().unwrap_or(LISTED), item, longest);
    }
}

/// What stands in a list has no name.
const LISTED: &str = "-";

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')
}

/// Refuses what no layout needs.
fn check(words: &[Placed<'_>]) -> Result<(), Wrong> {
    let mut before = "";
    for (word, span) in words {
        let is_sign = !is_word(word) && !word.starts_with(['"', '\'', '`']);
        let calls = is_word(before) && ![&GROUPING[..], &FILTERS].concat().contains(&before);
        let refused = match *word {
            "(" if calls => Some(format!("`{before}(…)`")),
            other if is_sign && !SIGNS.contains(other) => Some(format!("`{other}`")),
            other if before == "|" && !FILTERS.contains(&other) => {
                Some(format!("the filter `{other}`"))
            }
            _ => None,
        };
        if let Some(found) = refused {
            return Err(wrong(span, &found));
        }
        before = word;
    }
    Ok(())
}

/// First and last name of the list of `for name in path`, which says nothing else.
fn list_of(words: &[Placed<'_>]) -> Result<(String, String), Wrong> {
    let texts: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
    let path = texts.get(3..).unwrap_or_default().join(" ");
    let names: Vec<&str> = path.split(" . ").collect();
    let is_path = names.iter().all(|name| is_word(name) && !name.contains(' '));
    match texts.get(2) == Some(&"in") && is_path {
        true => Ok((names[0].to_string(), names[names.len() - 1].to_string())),
        false => Err(wrong(&words[0].1, "this loop")),
    }
}

fn wrong(span: &Range<usize>, found: &str) -> Wrong {
    Wrong { span: span.clone(), message: format!("{found} is more than a layout needs") }
}
