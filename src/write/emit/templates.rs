//! The templates of a profile, each parsed once. The only user of Tera beside its contexts.

use crate::control::controller::Template;
use crate::text::{LARGEST_FILE_MIB, Place, Problem};
use crate::write::emit::layout::{Layout, Wrong};
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{Error, Result as Written, Write};
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

/// The templates of one profile, in which a name always means the same text.
#[derive(Default)]
pub struct Templates {
    /// Those of a user that were asked for, by their names.
    own: RefCell<BTreeMap<String, Arc<Parsed>>>,
}

impl Templates {
    /// A page of what a document holds.
    pub(crate) fn page(
        &self,
        template: &Template,
        document: &serde_json::Value,
    ) -> Result<String, Problem> {
        let context = tera::Context::from_serialize(document)
            .map_err(|error| Problem::new(format!("the page cannot be made: {error}")))?;
        self.text(template, &context)
    }

    fn parsed(&self, template: &Template) -> Result<Arc<Parsed>, Problem> {
        fn found<K: Ord>(
            entry: Entry<'_, K, Arc<Parsed>>,
            of: &Template,
        ) -> Result<Arc<Parsed>, Problem> {
            Ok(Arc::clone(match entry {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(Parsed::of(of)?),
            }))
        }
        match &template.text {
            Cow::Borrowed(text) => {
                let mut parsed = BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner);
                found(parsed.entry(text), template)
            }
            Cow::Owned(_) => found(self.own.borrow_mut().entry(template.name.clone()), template),
        }
    }

    /// One file as text with `\n` line ends.
    pub(super) fn text(
        &self,
        template: &Template,
        context: &tera::Context,
    ) -> Result<String, Problem> {
        let Template { name, text: source } = template;
        let parsed = self.parsed(template)?;
        let is_own = matches!(source, Cow::Owned(_)); // those of the program are known
        if is_own && parsed.layout.work(context) > MOST_TAGS {
            let what =
                format!("executes more than {MOST_TAGS} tags, counted from the lists of its loops");
            return Err(too_much(name, &what));
        }
        let mut text = Bounded { bytes: Vec::new(), most: MOST_BYTES, is_full: false };
        let rendered = parsed.alone.render_to(&parsed.name, context, &mut text);
        if text.is_full {
            return Err(too_much(name, &format!("writes more than {LARGEST_FILE_MIB} MiB")));
        }
        rendered.map_err(|error| template_problem(name, source, &error))?;
        String::from_utf8(text.bytes)
            .map_err(|_| Problem::new(format!("template `{name}` does not write text")))
    }
}

/// A text that does not grow beyond a limit.
struct Bounded {
    bytes: Vec<u8>,
    most: u64,
    is_full: bool,
}

impl Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> Written<usize> {
        if (self.bytes.len() + bytes.len()) as u64 > self.most {
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

fn too_much(name: &str, what: &str) -> Problem {
    Problem::new(format!("template `{name}` {what}, too much for a file of a kit"))
        .help("a loop inside another one runs once for each of its items: loop over the lists of that item")
}

/// A problem of a template that says more than a layout.
fn no_layout(name: &str, template: &str, wrong: Wrong) -> Problem {
    let place = Place::in_text(name, template, wrong.span.start, wrong.span.end);
    Problem::new(format!("template `{name}` is refused: {}", wrong.message))
        .at(place)
        .help("a template prints names of the context with `{{ … }}`, loops over its lists with `for … in` and chooses with `if` (docs/templates.md §1)")
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
    let problem = Problem::new(format!("template `{name}` cannot be rendered: {message}"))
        .help("`nonius context JOB` prints what a template sees");
    match place {
        Some(place) => problem.at(place),
        None => problem,
    }
}

#[cfg(test)]
mod tests {
    use super::{Template, Templates};
    use crate::text::Problems;
    use crate::text::plain::tests::texts_of;
    use proptest::prelude::*;
    use serde_json::json;

    #[test]
    fn a_template_sees_nothing_of_those_rendered_before() {
        let (templates, nothing) = (Templates::default(), tera::Context::new());
        let first = named("first", "one line\n");
        assert_eq!(templates.text(&first, &nothing).expect("it is text"), "one line\n");
        let including = named("second", "{% include \"first\" %}");
        assert!(templates.text(&including, &nothing).is_err());
        assert_eq!(templates.text(&first, &nothing).expect("it is text"), "one line\n");
    }

    /// One of a user.
    fn named(name: &str, text: &str) -> Template {
        Template { name: name.to_string(), text: text.to_string().into() }
    }

    /// A context with a list of tables, each with its points.
    fn context(tables: usize, points: usize) -> tera::Context {
        let points: Vec<_> = (0..points).map(|k| json!({ "value": k.to_string() })).collect();
        let tables: Vec<_> = (0..tables).map(|_| json!({ "points": points })).collect();
        let mut context = tera::Context::new();
        context.insert("tables", &tables);
        context.insert("name", "a \"name\"");
        context
    }

    fn said(template: &str, context: &tera::Context) -> Result<String, String> {
        let rendered = Templates::default().text(&named("own.tera", template), context);
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
