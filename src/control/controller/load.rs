//! A profile from its TOML page: every fact with evidence and source, checked before use.
//!
//! A profile may build on a built-in one (`based_on = "fanuc-30i"`): its page is laid over that one,
//! then read once. Whether a page is ours or a user's makes no difference.

use crate::control::checklist::steps;
use crate::control::claims::Precondition;
use crate::control::controller::example::Example;
use crate::control::controller::fact::{Facts, Mechanism, origin};
pub use crate::control::controller::files::TemplateFinder;
use crate::control::controller::files::{Templates, files};
use crate::control::controller::program::program_facts;
use crate::control::controller::{
    CommonFacts, DeclaredFacts, Dialect, Fact, Family, FanucFacts, IsgFacts, LinuxcncFacts,
    Profile, ProfileSource, SiemensFacts, declared, fanuc, generic, isg, job_keys, linuxcnc,
    siemens,
};
use crate::text::{Problems, Section, Source, read_page_over, refuse_large_page, shown};
use toml::de::{DeArray, DeTable, DeValue};

/// Finds a built-in page by its id.
pub type PageFinder<'a> = &'a dyn Fn(&str) -> Option<&'static str>;

/// Reads and checks a profile. All problems of the page are given at once.
pub fn profile(
    source: Source,
    origin: ProfileSource,
    templates: TemplateFinder<'_>,
    pages: PageFinder<'_>,
) -> Result<Profile, Problems> {
    refuse_large_page(&source.name, source.text.len())?;
    let below = pages_below(&source.text, pages);
    let own_end = source.text.len();
    let templates = Templates { find: templates, own_end, proved: &proved() };
    let read = |root: &Section<'_>| read_profile(root, origin, &below, templates);
    Ok(read_page_over(source, &below, lay_over, read)?.0)
}

/// The pages that a page builds on, the nearest first.
fn pages_below(own: &str, pages: PageFinder<'_>) -> Vec<&'static str> {
    let next = |page: &str| pages(&text_of(page, "based_on")?);
    std::iter::successors(next(own), |page| next(page)).collect()
}

fn text_of(page: &str, key: &str) -> Option<String> {
    let table = DeTable::parse(page).ok()?;
    let text = table.get_ref().get(key)?.get_ref().as_str()?;
    Some(text.to_string())
}

/// What a page takes of the one below: what it does not state. Facts are taken one by one, whole; `mechanism`, which
/// says what a fact belongs to, also by itself. Its `steps` and `preconditions` stand before the own ones; its
/// examples hold with its own facts only.
fn lay_over<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match own.get_mut(name).map(toml::Spanned::get_mut) {
            None if matches!(name, "schema" | "id" | "name" | "example" | "no_example") => {}
            None => {
                own.insert(key, value);
            }
            Some(DeValue::Table(own)) => match (name, value.into_inner()) {
                ("facts", DeValue::Table(facts)) => lay_facts_over(own, facts),
                ("program", DeValue::Table(program)) => lay_over(own, program),
                _ => {}
            },
            Some(DeValue::Array(own)) if matches!(name, "steps" | "preconditions") => {
                if let DeValue::Array(steps) = value.into_inner() {
                    *own =
                        steps.into_iter().chain(std::mem::replace(own, DeArray::new())).collect();
                }
            }
            Some(_) => {}
        }
    }
}

fn lay_facts_over<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match (own.get_mut(name), value.get_ref()) {
            (None, _) => {
                own.insert(key, value);
            }
            (Some(own), DeValue::Table(fact)) => {
                let mechanism = fact.iter().find(|(key, _)| key.get_ref() == "mechanism");
                if let (DeValue::Table(own), Some((key, value))) = (own.get_mut(), mechanism)
                    && !own.contains_key("mechanism")
                {
                    own.insert(key.clone(), value.clone());
                }
            }
            _ => {}
        }
    }
}

fn read_profile(
    root: &Section<'_>,
    origin: ProfileSource,
    below: &[&str],
    templates: Templates<'_>,
) -> Option<Profile> {
    if root.whole("schema") != Some(1) {
        root.problem(
            "schema",
            "a profile needs `schema = 1`",
            "write `schema = 1` in its first line",
        );
    }
    let id = root.required_text("id", "a short name such as `fanuc-30i`")?;
    let name = root.required_text("name", "maker and model")?;
    check_base(root, below)?;
    let family = family(root);
    let facts = root.required_section("facts").map(Facts::of);
    let dialect = facts.as_ref().and_then(|facts| dialect(family, facts));
    let common = facts.as_ref().and_then(CommonFacts::read);
    let encoding = facts.as_ref().and_then(|facts| facts.if_stated("encoding"));
    if let Some(facts) = &facts {
        facts.section.refuse_unknown_keys();
    }
    let form = facts.as_ref().and_then(|facts| facts.written("table_form"));
    let files = files(root, form.as_deref(), templates);
    let program = root.sub("program", |own| program_facts(own, templates));
    let job_keys = job_keys(root);
    let checklist = steps(root);
    let preconditions = root.subs("preconditions", Precondition::read);
    let [off_by_hand, page] = ["off_by_hand", "page"].map(|key| root.text(key));
    let display = root.sub("display", display);
    let examples = root.subs("example", Example::read);
    let no_example = root.text("no_example");
    let common = common?;
    check_axis_names(&facts.as_ref()?.section, &common.axis_names.value);
    Some(Profile {
        id,
        name,
        origin,
        family: family?.0,
        dialect: dialect?,
        line_end: common.line_end,
        encoding,
        comments: common.comments,
        axis_names: common.axis_names,
        detection_unit_required: common.detection_unit_required,
        files: files?,
        job_keys,
        preconditions,
        off_by_hand,
        page,
        checklist,
        display,
        examples,
        no_example,
        program,
        statements: facts?.statements.into_inner(),
    })
}

fn check_base(root: &Section<'_>, below: &[&str]) -> Option<()> {
    let Some(id) = root.text("based_on") else {
        return Some(());
    };
    let Some(base) = below.last() else {
        root.problem(
            "based_on",
            format!("`based_on` names `{}`, expected the id of a built-in profile", shown(&id)),
            "`nonius controllers list` shows them",
        );
        return None;
    };
    let (own, base) = (root.text("dialect")?, text_of(base, "dialect")?);
    if own != base {
        root.problem(
            "dialect",
            format!("`dialect` is `{}`, but the profile it builds on speaks `{base}`", shown(&own)),
            "remove `dialect`, or build on another profile",
        );
        return None;
    }
    Some(())
}

/// The facts of the family, and those that its emulator implements in one way only: a page must state
/// that way, with its source.
fn dialect(family: Option<Known>, facts: &Facts<'_>) -> Option<Dialect> {
    let dialect = family.and_then(|(_, read)| read(facts));
    let between = family.map_or("linear", |(family, _)| family.between);
    facts.read("interpolation", |f| f.choice("value", &[(between, ())]));
    let outside = family.map_or(&[][..], |(family, _)| family.outside);
    let outside: Vec<_> = outside.iter().map(|own| (own.word(), *own)).collect();
    facts.read("outside", |f| f.choice("value", &outside));
    for told in ["direction", "value_unit"] {
        facts.if_stated::<String>(told); // pages once had to state it
    }
    dialect
}

fn family(root: &Section<'_>) -> Option<Known> {
    let words = FAMILIES.map(|known| (known.0.word, known));
    let list = words.map(|(word, _)| format!("`{word}`")).join(", ");
    root.require("dialect", &format!("one of {list}"));
    root.choice("dialect", &words)
}

/// `[display]`: where the control shows the correction that acts.
fn display(section: &Section<'_>) -> Option<Fact<String>> {
    let value = section.required_text("value", "the name of the display");
    let origin = origin(section);
    Some(origin?.with(value?))
}

fn check_axis_names(facts: &Section<'_>, names: &[String]) {
    let Some(fact) = facts.section("axis_names") else {
        return;
    };
    if names.len() != 3 {
        fact.problem(
            "value",
            format!("`axis_names` has {} names, expected three", names.len()),
            "name the axes X, Y and Z of the machine, in this order",
        );
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let other = |name: &&String| name.is_empty() || !name.chars().all(plain);
    for name in names.iter().filter(other) {
        fact.problem(
            "value",
            format!("`{}` is no axis name, expected letters, digits and `_`", shown(name)),
            "write it as the control shows it, e.g. `AX1`",
        );
    }
}

// The families of controls that there are.

/// A family, and how the facts of its controls are read.
pub(super) type Known = (&'static Family, fn(&Facts<'_>) -> Option<Dialect>);

/// All of them, in the order in which they are named.
pub(super) const FAMILIES: [Known; 6] = [
    (&siemens::FAMILY, |facts| SiemensFacts::read(facts).map(Dialect::Siemens)),
    (&fanuc::FAMILY, |facts| FanucFacts::read(facts).map(Dialect::Fanuc)),
    (&generic::FAMILY, |facts| DeclaredFacts::typed(facts).map(Dialect::Declared)),
    (&declared::FAMILY, |facts| DeclaredFacts::checked(facts).map(Dialect::Declared)),
    (&linuxcnc::FAMILY, |facts| LinuxcncFacts::read(facts).map(Dialect::Linuxcnc)),
    (&isg::FAMILY, |facts| IsgFacts::read(facts).map(Dialect::Isg)),
];

/// What sign proofs can prove, with the words of profiles.
pub(super) fn proved() -> Vec<(&'static str, Mechanism)> {
    let proofs = FAMILIES.iter().flat_map(|(family, _)| family.proofs);
    let mechanisms = proofs.map(|proof| proof.mechanism);
    mechanisms.map(|own| (own.word(), own)).collect()
}
