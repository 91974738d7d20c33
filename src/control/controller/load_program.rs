//! `[program]` of a profile.

use crate::control::controller::load_facts::FactReader;
use crate::control::controller::load_files::TemplateFinder;
use crate::control::controller::program::{Language, ProgramFacts};
use crate::text::document::Section;
use crate::text::problem::shown;
use std::cell::RefCell;

const MOST_DECIMALS: u32 = 6;

/// The section; without it a profile has what the one it builds on has.
pub(super) fn program(
    root: &Section<'_>,
    base: Option<&ProgramFacts>,
    templates: TemplateFinder<'_>,
) -> Option<Option<ProgramFacts>> {
    match root.section("program") {
        None => Some(base.cloned()),
        Some(section) => stated(&section, base, templates).map(Some),
    }
}

fn stated(
    section: &Section<'_>,
    base: Option<&ProgramFacts>,
    templates: TemplateFinder<'_>,
) -> Option<ProgramFacts> {
    let words = [Language::Siemens, Language::Fanuc].map(|l| (l.word(), l));
    if base.is_none() && !section.has("language") {
        section.missing("language", "`siemens` or `fanuc`");
    }
    let language = section
        .choice("language", &words)
        .or(base.map(|b| b.language));
    let extension = section
        .text("extension")
        .or(base.map(|b| b.extension.clone()))
        .unwrap_or_else(|| "NC".to_string());
    if extension.is_empty() || !extension.chars().all(|c| c.is_ascii_alphanumeric()) {
        section.problem(
            "extension",
            "`extension` is no ending of a file, expected letters and digits",
            "for instance `extension = \"MPF\"`",
        );
    }
    let template = template(section, base, templates);
    let facts = match base {
        Some(_) => section.section("facts"),
        None => section.required_section("facts"),
    };
    let reader = FactReader {
        section: facts.as_ref(),
        inherited: base.map_or(&[], |b| b.statements.as_slice()),
        statements: RefCell::default(),
    };
    let axis_letters = reader.fact("axis_letters", base.map(|b| &b.axis_letters), three_letters);
    let machine_position =
        reader.fact("machine_position", base.map(|b| &b.machine_position), |f| {
            f.text("value")
        });
    let increment = reader.fact("increment", base.map(|b| &b.increment), |f| f.text("value"));
    let dwell = reader.fact("dwell", base.map(|b| &b.dwell), |f| dwell(f, language));
    let cancel = reader.fact("cancel", base.map(|b| &b.cancel), |f| f.texts("value"));
    let decimals = |f: &Section<'_>| {
        let decimals = f.whole("value")?;
        if decimals > MOST_DECIMALS {
            let message =
                format!("a position has {decimals} decimals, expected 0 … {MOST_DECIMALS}");
            f.problem(
                "value",
                message,
                "write the decimals that the control reads",
            );
        }
        Some(decimals)
    };
    let decimals_mm = reader.fact("decimals_mm", base.map(|b| &b.decimals_mm), decimals);
    let decimals_inch = reader.fact("decimals_inch", base.map(|b| &b.decimals_inch), decimals);
    if let Some(facts) = &facts {
        facts.refuse_unknown_keys();
    }
    section.refuse_unknown_keys();
    let (template_name, template) = template?;
    Some(ProgramFacts {
        language: language?,
        extension,
        template_name,
        template,
        axis_letters: axis_letters?,
        machine_position: machine_position?,
        increment: increment?,
        dwell: dwell?,
        cancel: cancel?,
        decimals_mm: decimals_mm?,
        decimals_inch: decimals_inch?,
        statements: reader.statements.into_inner(),
    })
}

fn template(
    section: &Section<'_>,
    base: Option<&ProgramFacts>,
    templates: TemplateFinder<'_>,
) -> Option<(String, String)> {
    if let (false, Some(base)) = (section.has("template"), base) {
        return Some((base.template_name.clone(), base.template.clone()));
    }
    let name = section.required_text("template", "the name of a template")?;
    let Some(text) = templates(&name) else {
        section.problem(
            "template",
            format!("there is no template `{name}`"),
            "put it beside the profile, or name a built-in one (docs/templates.md)",
        );
        return None;
    };
    Some((name, text))
}

/// The word of a dwell and the address of its seconds. Another address counts something else:
/// milliseconds (Fanuc `P`) or turns of a spindle (Siemens `S`).
fn dwell(fact: &Section<'_>, language: Option<Language>) -> Option<String> {
    let text = fact.text("value")?;
    let address = text.chars().last();
    let (right, expected) = match language {
        Some(Language::Siemens) => (address == Some('F'), "`G4 F`"),
        _ => (matches!(address, Some('X' | 'U')), "`G04 X` or `G04 U`"),
    };
    if !right {
        fact.problem(
            "value",
            format!("`dwell` is `{}`, expected the word of a dwell and the address of its seconds: {expected}", shown(&text)),
            "seconds with a decimal point are written behind it",
        );
    }
    Some(text)
}

/// One capital letter for each of X, Y and Z: what every control takes as an address.
fn three_letters(fact: &Section<'_>) -> Option<Vec<String>> {
    let letters = fact.texts("value")?;
    let plain = |text: &String| text.len() == 1 && text.chars().all(|c| "XYZUVWABC".contains(c));
    if letters.len() != 3 || !letters.iter().all(plain) {
        fact.problem(
            "value",
            "`axis_letters` names the addresses of X, Y and Z, one letter each",
            "for instance [\"X\", \"Y\", \"Z\"]",
        );
    }
    Some(letters)
}
