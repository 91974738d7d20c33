//! How a control is told to move: facts of its part programs (docs/measuring.md).

use crate::control::controller::fact::{ControlUnit, Fact, Facts, Statement};
use crate::control::controller::family::LanguageFacts;
use crate::control::controller::files::{Template, Templates};
use crate::control::refusals;
use crate::text::{Section, Word, section, shown, words};

words! {
    /// Family of part programs.
    pub enum Language {
        /// SINUMERIK in its own language (not the ISO dialect).
        Siemens = "siemens",
        /// FANUC, G-code system of a machining centre.
        Fanuc = "fanuc",
        /// LinuxCNC, RS274NGC.
        Linuxcnc = "linuxcnc",
    }
}

impl Language {
    /// What is known of it.
    pub(crate) const fn facts(self) -> &'static LanguageFacts {
        match self {
            Language::Siemens => &super::siemens::LANGUAGE,
            Language::Fanuc => &super::fanuc::LANGUAGE,
            Language::Linuxcnc => &super::linuxcnc::LANGUAGE,
        }
    }
}

section! {
    /// `[program]` of a profile.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ProgramFacts(facts: &Facts<'_>, page: &Section<'_>, templates: Templates<'_>) {
        /// Which words the program consists of.
        pub language: Language => language(page), must;
        /// Ending of its files, without a dot.
        pub extension: String => extension(page);
        /// How it is laid out.
        pub template: Template => templates.named(page, (page, "template")), must;
        /// Letters of the axes X, Y, Z in a program.
        pub axis_letters: Fact<Vec<String>> = read(three_letters), must;
        /// Word that makes the positions of a block machine coordinates.
        pub machine_position: Fact<String> = stated(), must;
        /// Words of a move by an increment at a feed.
        pub increment: Fact<String> = stated(), must;
        /// Address of a dwell in seconds, with the word before it.
        pub dwell: Fact<String> = read(|fact| dwell_words(fact, language)), must;
        /// Blocks that cancel offsets, rotation, scaling and mirroring; none of them writes a datum.
        pub cancel: Fact<Vec<String>> = stated(), must;
        /// Decimals of a position on a metric control.
        pub decimals_mm: Fact<u32> = read(decimals), must;
        /// Decimals of a position on an inch control.
        pub decimals_inch: Fact<u32> = read(decimals), must;
        /// All facts in words.
        pub statements: Vec<Statement> => facts.statements.take();
    }
}

impl ProgramFacts {
    /// Address of the seconds of a dwell: the last letter of that fact.
    pub fn dwell_address(&self) -> char {
        self.dwell.value.chars().last().unwrap_or_default()
    }

    /// The facts that matter for a control with this basic system.
    pub(crate) fn statements_of(&self, unit: ControlUnit) -> impl Iterator<Item = &Statement> {
        let other = match unit {
            ControlUnit::Millimetre => "decimals_inch",
            ControlUnit::Inch => "decimals_mm",
        };
        self.statements.iter().filter(move |s| s.fact != other)
    }

    /// Decimals of a position in the control's unit.
    pub const fn decimals(&self, unit: ControlUnit) -> u32 {
        match unit {
            ControlUnit::Millimetre => self.decimals_mm.value,
            ControlUnit::Inch => self.decimals_inch.value,
        }
    }
}

/// The section `[program]` of a page.
pub(super) fn program_facts(
    section: &Section<'_>,
    templates: Templates<'_>,
) -> Option<ProgramFacts> {
    let facts = section.required_section("facts").unwrap_or_else(|| section.absent("facts"));
    let facts = Facts::of(facts);
    let program = ProgramFacts::read(&facts, section, templates);
    facts.section.refuse_unknown_keys();
    program
}

fn language(section: &Section<'_>) -> Option<Language> {
    section.require("language", "`siemens` or `fanuc` or `linuxcnc`");
    section.choice("language", Language::WORDS)
}

fn extension(section: &Section<'_>) -> String {
    let extension = section.text("extension").unwrap_or("NC".to_string());
    if extension.is_empty() || !extension.chars().all(|c| c.is_ascii_alphanumeric()) {
        section.refuse("extension", refusals::no_extension());
    }
    extension
}

const MOST_DECIMALS: u32 = 6;

fn decimals(fact: &Section<'_>) -> Option<u32> {
    let decimals = fact.whole("value")?;
    if decimals > MOST_DECIMALS {
        fact.refuse("value", refusals::many_decimals(decimals, MOST_DECIMALS));
    }
    Some(decimals)
}

/// The word of a dwell and the address of its seconds. Another address counts something else:
/// milliseconds (Fanuc `P`) or turns of a spindle (Siemens `S`).
fn dwell_words(fact: &Section<'_>, language: Option<Language>) -> Option<String> {
    let text = fact.text("value")?;
    let (addresses, expected) = language?.facts().dwell;
    if !text.ends_with(addresses) {
        fact.refuse("value", refusals::other_dwell(shown(&text), expected));
    }
    Some(text)
}

/// One capital letter for each of X, Y and Z: what every control takes as an address.
fn three_letters(fact: &Section<'_>) -> Option<Vec<String>> {
    let letters = fact.texts("value")?;
    let plain = |text: &String| text.len() == 1 && text.chars().all(|c| "XYZUVWABC".contains(c));
    if letters.len() != 3 || !letters.iter().all(plain) {
        fact.refuse("value", refusals::no_letters());
    }
    Some(letters)
}
