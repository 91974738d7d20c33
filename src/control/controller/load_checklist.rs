//! `[[checklist]]` of a profile.

use crate::control::controller::checklist::{
    List, ROLES, Step, Subject, When, is_placeholder, pieces,
};
use crate::control::controller::load_facts::evidence;
use crate::control::controller::{Evidence, Mechanism};
use crate::text::document::Section;
use crate::text::problem::shown;

/// The steps; a profile without any has those of the one it builds on.
pub(super) fn checklist(root: &Section<'_>, base: Option<&[Step]>) -> Option<Vec<Step>> {
    let sections = root.sections("checklist");
    if sections.is_empty() {
        return Some(base.unwrap_or_default().to_vec());
    }
    let steps: Vec<Option<Step>> = sections.iter().map(step).collect();
    steps.into_iter().collect()
}

fn step(section: &Section<'_>) -> Option<Step> {
    let part = section.required_text("part", "the heading it stands under");
    let text = section.required_text("text", "what to do");
    let source = section.required_text("source", "manual, edition and chapter, or why");
    let evidence = evidence(section);
    let consequence = section.text("consequence");
    if evidence == Some(Evidence::Assumed) && consequence.is_none() {
        section.missing(
            "consequence",
            "what happens on the machine if the assumption is wrong",
        );
    }
    let list = section.choice("list", &List::WORDS);
    let when = match section.text("when") {
        Some(words) => Some(condition(section, &words)?),
        None => None,
    };
    section.refuse_unknown_keys();
    let text = text?;
    let words = pieces(&text).into_iter().filter_map(|(_, word)| word);
    for word in words.filter(|word| !is_placeholder(word)) {
        section.problem(
            "text",
            format!("`{{{}}}` cannot be filled in", shown(word)),
            "write the word of a role of file, for instance `{enable}`, or `{reference}`",
        );
    }
    Some(Step {
        part: part?,
        text,
        list,
        when,
        evidence: evidence?,
        source: source?,
        consequence,
    })
}

fn condition(section: &Section<'_>, words: &str) -> Option<When> {
    let (absent, word) = match words.strip_prefix("no ") {
        Some(word) => (true, word),
        None => (false, words),
    };
    let role = ROLES.into_iter().find(|role| role.word() == word);
    let mechanism = Mechanism::WORDS.iter().find(|(known, _)| *known == word);
    let subject = role
        .map(Subject::File)
        .or(mechanism.map(|(_, mechanism)| Subject::Uses(*mechanism)));
    if subject.is_none() {
        section.problem(
            "when",
            format!(
                "`{}` is neither a role of file nor a mechanism",
                shown(word)
            ),
            "for instance `when = \"cec\"`, `when = \"rollback\"`, `when = \"no rollback\"`",
        );
    }
    Some(When {
        subject: subject?,
        absent,
    })
}
