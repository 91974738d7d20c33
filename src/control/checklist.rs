//! The steps of a profile, filled in for one kit (docs/field-kit.md). Nothing here moves a machine.

use crate::control::controller::checklist::{List, REFERENCE, Step, Subject, When, pieces};
use crate::control::controller::{Evidence, Mechanism, Role};
use serde::Serialize;

/// What a kit tells its checklist.
pub struct KitFacts<'a> {
    /// Its files, each with its role.
    pub files: Vec<(Role, String)>,
    /// Machine coordinates of the reference points.
    pub reference: String,
    /// Whether it uses a mechanism.
    pub uses: &'a dyn Fn(Mechanism) -> bool,
    /// What stands in a list.
    pub list: &'a dyn Fn(List) -> Listed,
}

/// What a list tells at its step, and what stands in the annex, one line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listed {
    /// To be done or seen.
    pub items: Vec<String>,
    /// Reasons, sources and ways around.
    pub notes: Vec<String>,
}

impl From<Vec<String>> for Listed {
    fn from(items: Vec<String>) -> Self {
        Listed {
            items,
            notes: Vec::new(),
        }
    }
}

/// Steps under one heading.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Part {
    title: String,
    steps: Vec<FilledStep>,
}

/// One step as it is printed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct FilledStep {
    number: String,
    text: String,
    items: Vec<String>,
    notes: Vec<String>,
    evidence: &'static str,
    source: String,
    consequence: String,
}

/// The steps that are for this kit, numbered through.
pub fn parts(steps: &[Step], kit: &KitFacts<'_>) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut number = 0;
    for step in steps.iter().filter(|step| is_for(step.when, kit)) {
        let items = step.list.map(kit.list);
        let is_empty = |l: &Listed| l.items.is_empty() && l.notes.is_empty();
        if items.as_ref().is_some_and(is_empty) {
            continue;
        }
        let Listed { items, notes } = items.unwrap_or_default();
        number += 1;
        let filled = FilledStep {
            number: number.to_string(),
            text: filled(&step.text, kit),
            items,
            notes,
            evidence: match step.evidence {
                Evidence::Assumed => "ASSUMED",
                Evidence::Manual => "from",
                Evidence::Executed => "seen on a control",
            },
            source: step.source.clone(),
            consequence: step.consequence.clone().unwrap_or_default(),
        };
        match parts.last_mut() {
            Some(part) if part.title == step.part => part.steps.push(filled),
            _ => parts.push(Part {
                title: step.part.clone(),
                steps: vec![filled],
            }),
        }
    }
    parts
}

fn is_for(when: Option<When>, kit: &KitFacts<'_>) -> bool {
    when.is_none_or(|when| {
        let has = match when.subject {
            Subject::File(role) => kit.files.iter().any(|(other, _)| *other == role),
            Subject::Uses(mechanism) => (kit.uses)(mechanism),
        };
        has != when.absent
    })
}

/// `{enable}` becomes the names of the files of that role.
fn filled(text: &str, kit: &KitFacts<'_>) -> String {
    let word = |word: &str| {
        if word == REFERENCE {
            return kit.reference.clone();
        }
        let names = kit.files.iter().filter(|(role, _)| role.word() == word);
        let names: Vec<String> = names.map(|(_, name)| format!("`{name}`")).collect();
        names.join(", ")
    };
    pieces(text)
        .into_iter()
        .map(|(plain, placeholder)| placeholder.map(word).unwrap_or_default() + plain)
        .collect()
}
