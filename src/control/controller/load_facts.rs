//! `[facts.NAME]` of a profile: value, evidence, source, consequence, mechanism.

use crate::control::controller::{Evidence, Fact, Mechanism, NumberRange, Statement, TableSign};
use crate::text::document::Section;
use std::cell::RefCell;

/// Reads `[facts.NAME]` sections: value, evidence, source, consequence, mechanism.
pub(super) struct FactReader<'a> {
    pub(super) section: Option<&'a Section<'a>>,
    pub(super) inherited: &'a [Statement],
    pub(super) statements: RefCell<Vec<Statement>>,
}

impl FactReader<'_> {
    pub(super) fn fact<T: Clone>(
        &self,
        name: &'static str,
        base: Option<&Fact<T>>,
        value: impl FnOnce(&Section<'_>) -> Option<T>,
    ) -> Option<Fact<T>> {
        let inherited = self
            .inherited
            .iter()
            .find(|statement| statement.fact == name);
        let Some(fact) = self.section.and_then(|section| section.section(name)) else {
            if base.is_none()
                && let Some(section) = self.section
            {
                let _ = section.required_section(name);
            }
            self.statements.borrow_mut().extend(inherited.cloned());
            return base.cloned();
        };
        let stated = value(&fact);
        if !fact.has("value") {
            fact.missing("value", "what is stated");
        }
        let evidence = evidence(&fact);
        let source = fact.required_text(
            "source",
            "manual, edition and chapter, or why it is assumed",
        );
        let consequence = fact.text("consequence");
        if evidence == Some(Evidence::Assumed) && consequence.is_none() {
            fact.missing(
                "consequence",
                "what happens on the machine if the assumption is wrong",
            );
        }
        let mechanism = fact.choice("mechanism", &Mechanism::WORDS);
        fact.refuse_unknown_keys();
        let known = Fact {
            value: stated?,
            evidence: evidence?,
            source: source?,
            consequence,
        };
        self.statements.borrow_mut().push(Statement {
            fact: name.to_string(),
            value: fact
                .as_written("value")
                .unwrap_or_default()
                .trim_matches('"')
                .to_string(),
            evidence: known.evidence,
            source: known.source.clone(),
            consequence: known.consequence.clone(),
            mechanism: mechanism.or(inherited.and_then(|statement| statement.mechanism)),
        });
        Some(known)
    }

    pub(super) fn sign(
        &self,
        name: &'static str,
        base: Option<&Fact<TableSign>>,
    ) -> Option<Fact<TableSign>> {
        self.fact(name, base, |f| {
            f.choice(
                "value",
                &[
                    ("as_error", TableSign::AsError),
                    ("as_correction", TableSign::AsCorrection),
                ],
            )
        })
    }

    pub(super) fn whole(&self, name: &'static str, base: Option<&Fact<u32>>) -> Option<Fact<u32>> {
        self.fact(name, base, |f| f.whole("value"))
    }

    pub(super) fn positive(
        &self,
        name: &'static str,
        base: Option<&Fact<f64>>,
    ) -> Option<Fact<f64>> {
        self.fact(name, base, |f| f.positive("value"))
    }

    pub(super) fn flag(&self, name: &'static str, base: Option<&Fact<bool>>) -> Option<Fact<bool>> {
        self.fact(name, base, |f| f.flag("value"))
    }

    pub(super) fn ranges(
        &self,
        name: &'static str,
        base: Option<&Fact<Vec<NumberRange>>>,
    ) -> Option<Fact<Vec<NumberRange>>> {
        self.fact(name, base, |f| {
            let pairs = f.whole_pairs("value")?;
            if pairs.iter().any(|[first, last]| first > last) {
                f.problem(
                    "value",
                    "a block ends before it begins",
                    "write [first, last]",
                );
                return None;
            }
            Some(
                pairs
                    .iter()
                    .map(|[first, last]| NumberRange {
                        first: *first,
                        last: *last,
                    })
                    .collect(),
            )
        })
    }
}

pub(super) fn evidence(fact: &Section<'_>) -> Option<Evidence> {
    if !fact.has("evidence") {
        fact.missing("evidence", "`manual`, `assumed` or `executed`");
    }
    fact.choice(
        "evidence",
        &[
            ("manual", Evidence::Manual),
            ("assumed", Evidence::Assumed),
            ("executed", Evidence::Executed),
        ],
    )
}
