//! The steps of a service visit: as they stand in a profile, and filled in for one kit (docs/visit.md).
//! Nothing here moves a machine.

use crate::control::controller::fact::{Evidence, Fact, Mechanism, Role, origin_or_rule};
use crate::control::refusals;
use crate::text::{Section, Word, joined, section, shown, words};
use serde::Serialize;

section! {
    /// One step.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Step(section: &Section<'_>) {
        /// Heading that it stands under.
        pub part: String = text(), must "the heading it stands under";
        /// What to do; roles of files and [`REFERENCE`] in braces are filled in.
        pub text: Fact<String> = with(what_to_do), must "what to do";
        /// What of this kit is listed below it.
        pub list: Option<List> = choice(List::WORDS);
        /// Kits that it is for; `None` = all.
        pub when: Option<When> = with(condition);
    }
}

words! {
    /// What a step lists of a kit.
    pub enum List {
        /// Where each term goes: what the kit overwrites.
        Places = "places",
        /// Preconditions with their values.
        Preconditions = "preconditions",
        /// What is assumed of the control, with the consequence.
        Assumptions = "assumptions",
        /// The largest movement of each axis when the tables are switched.
        Movement = "movement",
        /// Bumps, and what has to be seen.
        SignProofs = "sign-proofs",
        /// A bump as it is typed by hand, and what has to be seen.
        TypedBump = "typed-bump",
        /// One place of each table, and what the file holds there.
        Display = "display",
        /// Why there is no sign proof of a mechanism or no rollback file, and what the rollback files
        /// do not hold.
        NotWritten = "not-written",
        /// What the rollback files leave to a person, and what moves.
        WayBack = "way-back",
        /// Values that are entered by hand with the tables.
        Enter = "enter",
        /// The same values on rollback.
        PutBack = "put-back",
    }
}

/// When a step stands in a checklist (`when = "cec"`, `when = "no rollback"`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct When {
    /// What is asked about.
    pub subject: Subject,
    /// Whether the kit must not have it.
    pub absent: bool,
}

/// What a condition asks about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The kit holds a file of this role.
    File(Role),
    /// The kit uses this mechanism.
    Uses(Mechanism),
}

/// Roles whose file names a text may ask for, `{enable}`, and a condition may ask about.
pub const ROLES: [Role; 6] =
    [Role::Table, Role::Parameters, Role::Enable, Role::Disable, Role::Rollback, Role::SignProof];

/// What else a text may ask for: the reference points in machine coordinates.
pub const REFERENCE: &str = "reference";

/// The pieces of a text: plain, and the words in braces.
pub(crate) fn pieces(text: &str) -> Vec<(&str, Option<&str>)> {
    let (first, rest) = text.split_once('{').unwrap_or((text, ""));
    let mut pieces = vec![(first, None)];
    for piece in rest.split('{').filter(|piece| !piece.is_empty()) {
        let (word, plain) = piece.split_once('}').unwrap_or((piece, ""));
        pieces.push((plain, Some(word)));
    }
    pieces
}

/// What a kit tells its checklist.
pub struct KitFacts<'a> {
    /// Its files, each with its role.
    pub files: Vec<(Role, String)>,
    /// Machine coordinates of the reference points.
    pub reference: String,
    /// Whether it uses a mechanism.
    pub uses: &'a dyn Fn(Mechanism) -> bool,
    /// What stands in a list.
    pub list: &'a dyn Fn(List) -> ListText,
}

/// What a list tells at its step, and what stands in the annex, one line each.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ListText {
    /// To be done or seen.
    pub items: Vec<String>,
    /// Reasons, sources and ways around.
    pub notes: Vec<String>,
}

impl<T: ToString> From<Vec<T>> for ListText {
    fn from(items: Vec<T>) -> Self {
        ListText { items: items.iter().map(T::to_string).collect(), notes: Vec::new() }
    }
}

/// A paragraph above the steps.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Paragraph {
    /// What it says.
    pub text: String,
    /// What is listed below it.
    pub items: Vec<String>,
}

/// Steps under one heading.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChecklistPart {
    title: String,
    steps: Vec<FilledStep>,
}

/// One step as it is printed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct FilledStep {
    number: String,
    text: String,
    #[serde(flatten)]
    listed: ListText,
    evidence: &'static str,
    source: String,
    consequence: String,
}

/// The steps that are for this kit, numbered through.
pub fn parts(steps: &[Step], kit: &KitFacts<'_>) -> Vec<ChecklistPart> {
    let mut parts: Vec<ChecklistPart> = Vec::new();
    let mut number = 0;
    for step in steps.iter().filter(|step| is_for(step.when, kit)) {
        let listed = step.list.map(kit.list);
        if listed == Some(ListText::default()) {
            continue;
        }
        number += 1;
        let filled = FilledStep {
            number: number.to_string(),
            text: filled(&step.text.value, kit),
            listed: listed.unwrap_or_default(),
            evidence: match step.text.evidence {
                Evidence::Assumed => "ASSUMED",
                Evidence::Manual => "from",
                Evidence::Executed => "seen on a control",
            },
            source: step.text.source.clone(),
            consequence: step.text.consequence.clone().unwrap_or_default(),
        };
        match parts.last_mut() {
            Some(part) if part.title == step.part => part.steps.push(filled),
            _ => parts.push(ChecklistPart { title: step.part.clone(), steps: vec![filled] }),
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
        joined(names.map(|(_, name)| format!("`{name}`")))
    };
    pieces(text)
        .into_iter()
        .map(|(plain, placeholder)| placeholder.map(word).unwrap_or_default() + plain)
        .collect()
}

/// The steps of a visit; none where the page has none. Those of `[[steps]]` stand at the end of their part.
pub(crate) fn steps(root: &Section<'_>) -> Vec<Step> {
    let mut list = root.subs("checklist", Step::read);
    root.subs("steps", |section| {
        let own = Step::read(section)?;
        match list.iter().rposition(|step| step.part == own.part) {
            Some(last) => list.insert(last + 1, own),
            None => no_part(section, &own.part, &list),
        }
        Some(())
    });
    list
}

fn no_part(section: &Section<'_>, part: &str, list: &[Step]) {
    let mut parts: Vec<String> = list.iter().map(|own| format!("`{}`", own.part)).collect();
    parts.dedup();
    section.refuse("part", refusals::no_part(shown(part), parts.join(", ")));
}

fn what_to_do(section: &Section<'_>, key: &'static str) -> Option<Fact<String>> {
    let text = section.text(key);
    let origin = origin_or_rule(section);
    let text = text?;
    let known = |word: &str| word == REFERENCE || ROLES.iter().any(|role| role.word() == word);
    for word in pieces(&text).into_iter().filter_map(|(_, word)| word).filter(|word| !known(word)) {
        section.refuse(key, refusals::not_filled_in(shown(word)));
    }
    Some(origin?.with(text))
}

fn condition(section: &Section<'_>, key: &'static str) -> Option<When> {
    let words = section.text(key)?;
    let word = words.strip_prefix("no ").unwrap_or(&words);
    let role = ROLES.into_iter().find(|role| role.word() == word);
    let mechanism = Mechanism::WORDS.iter().find(|(known, _)| *known == word);
    let subject =
        role.map(Subject::File).or(mechanism.map(|(_, mechanism)| Subject::Uses(*mechanism)));
    if subject.is_none() {
        section.refuse(key, refusals::no_condition(shown(word)));
    }
    Some(When { subject: subject?, absent: word != words })
}
