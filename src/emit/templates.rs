//! The templates of a profile, each parsed once. The only user of Tera beside its contexts.

use crate::problem::{Place, Problem};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// The templates of one profile, in which a name always means the same text.
pub struct Templates {
    /// What all of them have: the filters and functions of Tera.
    without_any: tera::Tera,
    /// Those that were asked for; each stands alone and sees nothing of the others.
    parsed: RefCell<BTreeMap<String, tera::Tera>>,
}

impl Default for Templates {
    fn default() -> Templates {
        let mut without_any = tera::Tera::default();
        without_any.autoescape_on(Vec::<&'static str>::new());
        Templates {
            without_any,
            parsed: RefCell::default(),
        }
    }
}

impl Templates {
    /// One file as text with `\n` line ends.
    pub(super) fn text(
        &self,
        name: &str,
        template: &str,
        context: &tera::Context,
    ) -> Result<String, Problem> {
        let refuse = |error: tera::Error| template_problem(name, template, &error);
        let mut parsed = self.parsed.borrow_mut();
        let alone = match parsed.entry(name.to_string()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let mut alone = self.without_any.clone();
                alone.add_raw_template(name, template).map_err(refuse)?;
                new.insert(alone)
            }
        };
        alone.render(name, context).map_err(refuse)
    }
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
    use super::Templates;

    #[test]
    #[allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]
    fn a_template_sees_nothing_of_those_rendered_before() {
        let (templates, nothing) = (Templates::default(), tera::Context::new());
        let first = templates.text("first", "one line\n", &nothing);
        assert_eq!(first.expect("it is text"), "one line\n");
        let including = "{% include \"first\" %}";
        assert!(templates.text("second", including, &nothing).is_err());
        let again = templates.text("first", "one line\n", &nothing);
        assert_eq!(again.expect("it is text"), "one line\n");
    }
}
