//! What a kit relies on without being able to prove it: assumptions and preconditions.

use crate::text::Section;
use serde::Serialize;

/// A fact about the control that nobody has shown yet (contract §4).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Assumption {
    /// Name of the fact.
    pub fact: String,
    /// What is assumed.
    pub value: String,
    /// `assumed`, always; kept as a field because scripts read it.
    pub evidence: &'static str,
    /// What happens on the machine if it is wrong.
    pub consequence: String,
    /// What only the job can say, and what is lost if it is wrong.
    #[serde(skip)]
    pub to_decide: bool,
    /// Why it cannot matter for this kit, where it cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_effect: Option<&'static str>,
}

impl Assumption {
    /// An assumption that comes from the job, not from a profile.
    pub(crate) fn of_job(
        fact: impl Into<String>,
        value: impl Into<String>,
        consequence: impl Into<String>,
    ) -> Self {
        Assumption {
            fact: fact.into(),
            value: value.into(),
            evidence: crate::control::controller::Evidence::Assumed.word(),
            consequence: consequence.into(),
            to_decide: false,
            without_effect: None,
        }
    }

    /// Whether it is the sign of a table, or which sense is typed in, and matters.
    pub(crate) fn is_sign(&self) -> bool {
        let is_sense = self.fact.ends_with("_sign") || self.fact == "typed_value";
        is_sense && self.without_effect.is_none()
    }

    /// `fact = value; if wrong: consequence`, without patterns, which nobody compares with a control.
    pub(crate) fn words(&self) -> String {
        let (fact, value, consequence) = (&self.fact, &self.value, &self.consequence);
        match value.contains("(?<") {
            true => format!("{fact}; if wrong: {consequence}"),
            false => format!("{fact} = {value}; if wrong: {consequence}"),
        }
    }

    /// The same, to be decided before anything is loaded.
    pub(crate) fn undecided(self) -> Self {
        Assumption { to_decide: true, ..self }
    }
}

/// What a person has to see to on the control; no file of the kit writes it (contract §4).
/// `what` and `value` read as a sentence: "`what` must be `value`".
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Precondition {
    /// Parameter, machine datum or option.
    pub what: String,
    /// Value that it must have.
    pub value: String,
    /// Why.
    pub why: String,
    /// Where that is from.
    pub source: String,
    /// When a person sees to it.
    #[serde(skip)]
    pub when: SeenTo,
}

/// When a person sees to a precondition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeenTo {
    /// Before anything is loaded.
    Before,
    /// The same; unless it holds, data are overwritten or an axis moves.
    Danger,
    /// The same, with a box of its own.
    Boxed,
    /// The value is entered after the tables, and put back on rollback.
    Entered,
    /// After loading: there is nothing to compare before.
    After,
}

impl Precondition {
    /// A precondition from its four texts.
    pub fn new(
        what: impl Into<String>,
        value: impl Into<String>,
        why: impl Into<String>,
        source: impl Into<String>,
    ) -> Self {
        Precondition {
            what: what.into(),
            value: value.into(),
            why: why.into(),
            source: source.into(),
            when: SeenTo::Before,
        }
    }

    /// One `[[preconditions]]` of a profile.
    pub(crate) fn read(section: &Section<'_>) -> Option<Precondition> {
        let texts = ["what", "value", "why", "source"];
        let [what, value, why, source] = texts.map(|key| section.required_text(key, "a text"));
        Some(Precondition::new(what?, value?, why?, source?))
    }

    /// The same, where data are overwritten or an axis moves unless it holds.
    pub(crate) fn dangerous(self) -> Self {
        self.seen_to(SeenTo::Danger)
    }

    /// The same, seen to at this time.
    pub(crate) fn seen_to(self, when: SeenTo) -> Self {
        Precondition { when, ..self }
    }
}

/// Preconditions that differ only in the last word of what they concern (`… of axis 1`) as one, for
/// people: all these words, and the first of them.
pub fn shared(preconditions: &[Precondition]) -> Vec<(String, &Precondition)> {
    let mut shared: Vec<(String, &Precondition)> = Vec::new();
    for p in preconditions {
        let (head, last) = head_and_last(&p.what);
        let same = |other: &&mut (String, &Precondition)| {
            let o = other.1;
            let asked = (&o.value, &o.why, &o.source) == (&p.value, &p.why, &p.source);
            asked && !head.is_empty() && head_and_last(&o.what).0 == head
        };
        match shared.iter_mut().find(same) {
            Some((words, _)) => *words = format!("{words}, {last}"),
            None => shared.push((p.what.clone(), p)),
        }
    }
    shared
}

fn head_and_last(what: &str) -> (&str, &str) {
    what.rsplit_once(' ').unwrap_or(("", what))
}
