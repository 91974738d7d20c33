//! The templates of profiles; those of the program are parsed once. Only this room uses Tera.

use crate::control::controller::Template;
use crate::text::{LARGEST_FILE_MIB, Place, Problem};
use crate::write::refusals;
use regex_automata::meta::Regex;
use std::borrow::Cow;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Error, Result as Written, Write};
use std::ops::Range;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// Bytes of one file.
const MOST_BYTES: u64 = LARGEST_FILE_MIB << 20;
/// Tags that one file executes; nearly every one writes a byte.
const MOST_TAGS: u64 = LARGEST_FILE_MIB << 20;

/// What all templates have: the filters and functions of Tera.
static WITHOUT_ANY: LazyLock<tera::Tera> = LazyLock::new(|| {
    let mut without_any = tera::Tera::default();
    without_any.autoescape_on(Vec::<&'static str>::new());
    without_any
});

/// A template that stands alone and sees nothing of others.
struct Parsed {
    name: String,
    alone: tera::Tera,
    layout: Layout,
}

impl Parsed {
    fn of(Template { name, text }: &Template) -> Result<Arc<Parsed>, Problem> {
        let mut alone = WITHOUT_ANY.clone();
        let refuse = |error: tera::Error| template_problem(name, text, &error);
        alone.add_raw_template(name, text).map_err(refuse)?;
        let layout = Layout::of(text).map_err(|wrong| no_layout(name, text, wrong))?;
        Ok(Arc::new(Parsed { name: name.clone(), alone, layout }))
    }
}

/// The templates of the program that were asked for, by their texts: parsed once in a process.
static BUILT_IN: Mutex<BTreeMap<&str, Arc<Parsed>>> = Mutex::new(BTreeMap::new());

/// A template, parsed.
fn parsed(template: &Template) -> Result<Arc<Parsed>, Problem> {
    let Cow::Borrowed(text) = &template.text else {
        return Parsed::of(template);
    };
    let mut known = BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(Arc::clone(match known.entry(text) {
        Entry::Occupied(known) => known.into_mut(),
        Entry::Vacant(new) => new.insert(Parsed::of(template)?),
    }))
}

/// A page of what a document holds.
pub(crate) fn page(template: &Template, document: &serde_json::Value) -> Result<String, Problem> {
    text(template, &tera::Context::from_serialize(document).map_err(refusals::no_context)?)
}

/// One file as text with `\n` line ends.
pub(in crate::write) fn text(
    template: &Template,
    context: &tera::Context,
) -> Result<String, Problem> {
    let Template { name, text: source } = template;
    let parsed = parsed(template)?;
    let is_own = matches!(source, Cow::Owned(_)); // those of the program are known
    if is_own && parsed.layout.work(context) > MOST_TAGS {
        return Err(refusals::much_work(name, MOST_TAGS));
    }
    let mut text = Bounded::default();
    let rendered = parsed.alone.render_to(&parsed.name, context, &mut text);
    if text.is_full {
        return Err(refusals::much_text(name, LARGEST_FILE_MIB));
    }
    rendered.map_err(|error| template_problem(name, source, &error))?;
    String::from_utf8(text.bytes).map_err(|_| refusals::no_text(name))
}

/// A text that does not grow beyond the limit of a file.
#[derive(Default)]
struct Bounded {
    bytes: Vec<u8>,
    is_full: bool,
}

impl Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> Written<usize> {
        if (self.bytes.len() + bytes.len()) as u64 > MOST_BYTES {
            self.is_full = true;
            return Err(Error::other("too long"));
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Written<()> {
        Ok(())
    }
}

/// A problem of a template that says more than a layout.
fn no_layout(name: &str, template: &str, (span, message): Wrong) -> Problem {
    refusals::no_layout(name, message).at(Place::in_text(name, template, span.start, span.end))
}

/// A problem of a template at its place in the template.
fn template_problem(name: &str, template: &str, error: &tera::Error) -> Problem {
    let (message, place) = match error.kind() {
        tera::ErrorKind::SyntaxError(report) | tera::ErrorKind::RenderingError(report) => {
            let span = report.span();
            let text = template.lines().nth(span.start_line.max(1) - 1);
            let place = Place {
                file: name.to_string(),
                line: span.start_line,
                column: span.start_col + 1,
                width: span.end_col.saturating_sub(span.start_col).max(1),
                text: text.unwrap_or_default().to_string(),
                skipped: 0,
            };
            (report.message().to_string(), Some(place))
        }
        _ => (error.to_string(), None),
    };
    let mut problem = refusals::not_rendered(name, message);
    problem.place = place;
    problem
}

// What a template may say, and how much work it is, before it is rendered.
//
// The engine bounds neither loops nor texts that grow (`{% set s = s ~ s %}` forty times is a terabyte), and
// has no place to count them. So a template says what a layout needs and no more: names, loops over lists
// of the context, choices. Then no value is longer than one of the context, and how many tags are executed at
// most follows from the lengths of the lists.

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

/// Where a template says more than a layout, bytes of it; what was found and what was expected.
type Wrong = (Range<usize>, String);

/// Of each tag of a template the loops around it, each with the first and the last name of its list.
#[derive(Default)]
struct Layout {
    tags: Vec<Vec<(String, String)>>,
}

/// A word or sign and where it stands in the template.
type Token<'a> = (&'a str, Range<usize>);

impl Layout {
    /// The layout of a template that the engine has parsed.
    fn of(template: &str) -> Result<Layout, Wrong> {
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
            let words: Vec<Token<'_>> = words.collect();
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
    fn work(&self, context: &tera::Context) -> u64 {
        let roots = self.tags.iter().flatten().map(|(root, _)| root.as_str());
        let mut longest = BTreeMap::new();
        for root in roots.collect::<BTreeSet<&str>>() {
            if let Some(value) = context.get(root) {
                measure(root, value, &mut longest);
            }
        }
        let of_all = longest.values().copied().max().unwrap_or(1);
        let length = |list: &str| longest.get(list).copied().unwrap_or(of_all).max(1);
        let turns = |loops: &Vec<(String, String)>| {
            loops.iter().map(|(_, list)| length(list)).fold(1, u64::saturating_mul)
        };
        self.tags.iter().map(turns).fold(0, u64::saturating_add)
    }
}

/// Notes the longest list, map or text of each name in a value.
fn measure<'a>(name: &'a str, value: &'a tera::Value, longest: &mut BTreeMap<&'a str, u64>) {
    let known = longest.entry(name).or_default();
    *known = value.len().map_or(0, |length| length as u64).max(*known);
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
fn check(words: &[Token<'_>]) -> Result<(), Wrong> {
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
fn list_of(words: &[Token<'_>]) -> Result<(String, String), Wrong> {
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
    (span.clone(), format!("{found} is more than a layout needs"))
}

#[cfg(test)]
mod tests {
    use super::{BTreeMap, Template, text};
    use crate::text::Problems;
    use crate::text::plain::tests::texts_of;
    use proptest::prelude::*;
    use serde_json::json;

    #[test]
    fn a_template_sees_nothing_of_those_rendered_before() {
        let nothing = tera::Context::new();
        let first = named("first", "one line\n");
        assert_eq!(text(&first, &nothing).expect("it is text"), "one line\n");
        let including = named("second", "{% include \"first\" %}");
        assert!(text(&including, &nothing).is_err());
        assert_eq!(text(&first, &nothing).expect("it is text"), "one line\n");
    }

    /// One of a user.
    fn named(name: &str, text: &str) -> Template {
        Template { name: name.to_string(), text: text.to_string().into() }
    }

    /// A context with a list of tables, each with its points.
    fn context(tables: usize, points: usize) -> tera::Context {
        let points: Vec<_> =
            (0..points).map(|k| BTreeMap::from([("value", k.to_string())])).collect();
        let tables: Vec<_> = (0..tables).map(|_| BTreeMap::from([("points", &points)])).collect();
        let mut context = tera::Context::new();
        context.insert("tables", &tables);
        context.insert("name", "a \"name\"");
        context
    }

    fn said(template: &str, context: &tera::Context) -> Result<String, String> {
        let rendered = text(&named("own.tera", template), context);
        rendered.map_err(|problem| Problems::from(problem).render())
    }

    #[test]
    fn what_a_layout_needs_is_rendered() {
        let (seen, nothing) = (context(2, 2), context(0, 0));
        let layout = "{#- a {% set %} -#}{{- name }}: {% for t in tables -%}\n{% for p in t.points %}{{ p.value }}\
                      {% if not loop.last and p.value == \"0\" %},{% elif (p.value != 'x%}') %};{% else %}{% endif %}\
                      {% endfor %}{% else %}none{% endfor -%}{{ \"}}\" }}{{ missing | default(value=name) | upper }}";
        let both = said(layout, &seen);
        assert_eq!(both, Ok("a \"name\": 0,1;0,1;}}A \"NAME\"".to_string()));
        let none = said(layout, &nothing);
        assert_eq!(none, Ok("a \"name\": none}}A \"NAME\"".to_string()));
    }

    #[test]
    fn fields_come_in_their_order() {
        let mut context = tera::Context::new();
        let table = json!({ "g": "1", "a": "2", "f": "3", "b": "4", "e": "5", "c": "6", "d": "7" });
        context.insert("table", &table);
        let layout = "{% for value in table %}{{ value }}{% endfor %}";
        assert_eq!(said(layout, &context), Ok("1234567".to_string()));
    }

    #[test]
    fn what_could_grow_without_bound_is_refused_with_its_place() {
        for (template, found) in [
            ("{% set s = \"x\" %}{% set s = s ~ s %}{{ s }}", "`set`"),
            ("{{ name ~ name }}", "`~`"),
            ("{% for a in range(end=100000) %}{% endfor %}", "`range(…)`"),
            ("{{ range(end=9) | length }}", "`range(…)`"),
            ("{% for t in [1, 2] %}{% endfor %}", "`[`"),
            ("{% for t in tables | first %}{% endfor %}", "this loop"),
            ("{{ [t for t in tables] }}", "`[`"),
            ("{{ tables[0] }}", "`[`"),
            ("{{ {\"a\": 1} }}", "`{`"),
            ("{{ name | replace(from=\"a\", to=\"aa\") }}", "the filter `replace`"),
            ("{{ tables | sort }}", "the filter `sort`"),
            ("{% filter upper %}{% endfilter %}", "`filter`"),
            ("{% raw %}{{ x }}{% endraw %}", "`raw`"),
            ("{% block a %}{% endblock %}", "`block`"),
            ("{{ 1 + 1 }}", "`+`"),
            ("{% for k, v in tables %}{% endfor %}", "this loop"),
            ("{% for t in \"abc\" %}{% endfor %}", "this loop"),
        ] {
            let refused = said(&format!("one\n{template}"), &context(1, 1));
            let words = refused.expect_err(template);
            let says =
                format!("template `own.tera` is refused: {found} is more than a layout needs");
            assert!(words.contains(&says), "{template}\n{words}");
            assert!(words.contains("own.tera:2:"), "{template}\n{words}");
        }
    }

    /// Counted from the lists, before anything is rendered: it takes no time to refuse them.
    #[test]
    fn loops_that_never_end_are_refused_with_the_name_of_the_template() {
        let seen = context(60, 500);
        let nested = |depth: usize, body: &str| {
            let begin = "{% for t in tables %}{% for p in t.points %}".repeat(depth);
            format!("{begin}{body}{}", "{% endfor %}{% endfor %}".repeat(depth))
        };
        assert!(said(&nested(1, "{{ p.value }}"), &seen).is_ok());
        for body in ["", "{{ p.value }}", "{% for letter in name %}{% endfor %}"] {
            let words = said(&nested(2, body), &seen).expect_err("too much work");
            let says = "template `own.tera` executes more than 67108864 tags";
            assert!(words.contains(says), "{words}");
        }
        let other = "{% for x in name %}{% for y in x %}{% for t in tables %}{% for u in tables %}{% for v in tables %}{% for w in tables %}{{ w }}{% endfor %}{% endfor %}{% endfor %}{% endfor %}{% endfor %}{% endfor %}";
        assert!(said(other, &seen).is_err());
        let in_else =
            format!("{{% for x in tables.x %}}{{% else %}}{}{{% endfor %}}", nested(3, ""));
        assert!(said(&in_else, &seen).is_err());
    }

    #[test]
    fn a_file_that_nobody_could_read_back_is_refused() {
        let seen = context(60, 500);
        let long = format!(
            "{{% for t in tables %}}{{{{ t }}}}{{% for p in t.points %}}{}{{% endfor %}}{{% endfor %}}",
            "x".repeat(5000)
        );
        let words = said(&long, &seen).expect_err("150 MB");
        assert!(words.contains("template `own.tera` writes more than 64 MiB"), "{words}");
        assert!(words.contains("too much for a file of a kit"), "{words}");
    }

    const PARTS: &str = "{,{%,{{,{{-,{%-,{#,},%},}},-}},-%},#}, , for, in,if,set,endfor,endif,tables,t,\",',(,~,),==,.";

    proptest! {
        #[test]
        fn any_text_is_rendered_or_refused(template in texts_of(PARTS.split(','), 12)) {
            let rendered = said(&template, &context(1, 2));
            let length = rendered.map_or_else(|words| words.len(), |text| text.len() + 1);
            prop_assert!((1..10_000).contains(&length));
        }
    }
}
