//! Steps of a service visit as they stand in a profile (docs/field-kit.md): texts are data.

use crate::control::controller::{Evidence, Mechanism, Role};

/// One step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// Heading that it stands under.
    pub part: String,
    /// What to do; `{table}`, `{reference}` … are filled in ([`PLACEHOLDERS`]).
    pub text: String,
    /// What of this kit is listed below it.
    pub list: Option<List>,
    /// Kits that it is for; `None` = all.
    pub when: Option<When>,
    /// How well it is known.
    pub evidence: Evidence,
    /// Where it is from.
    pub source: String,
    /// What happens if it is wrong (required where it is assumed).
    pub consequence: Option<String>,
}

/// What a step lists of a kit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum List {
    /// Where each term goes: what the kit overwrites.
    Places,
    /// Preconditions with their values.
    Preconditions,
    /// What is assumed of the control, with the consequence.
    Assumptions,
    /// The largest movement of each axis when the tables are switched.
    Movement,
    /// Bumps, and what has to be seen.
    SignProofs,
    /// One place of each table, and what the file holds there.
    Display,
    /// Why there is no sign proof of a mechanism or no rollback file, and what the rollback files
    /// do not hold.
    NotWritten,
    /// What the rollback files leave to a person, and what moves.
    WayBack,
}

impl List {
    /// The words of profiles (`list = "…"`).
    pub const WORDS: [(&'static str, List); 8] = [
        ("places", List::Places),
        ("preconditions", List::Preconditions),
        ("assumptions", List::Assumptions),
        ("movement", List::Movement),
        ("sign-proofs", List::SignProofs),
        ("display", List::Display),
        ("not-written", List::NotWritten),
        ("way-back", List::WayBack),
    ];
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
pub const ROLES: [Role; 6] = [
    Role::Table,
    Role::Parameters,
    Role::Enable,
    Role::Disable,
    Role::Rollback,
    Role::SignProof,
];

/// What else a text may ask for: the reference points in machine coordinates.
pub const REFERENCE: &str = "reference";

/// Whether `{word}` can be filled in.
pub(crate) fn is_placeholder(word: &str) -> bool {
    word == REFERENCE || ROLES.iter().any(|role| role.word() == word)
}

/// The pieces of a text: plain, and the words in braces.
pub fn pieces(text: &str) -> Vec<(&str, Option<&str>)> {
    let (first, rest) = text.split_once('{').unwrap_or((text, ""));
    let mut pieces = vec![(first, None)];
    for piece in rest.split('{').filter(|piece| !piece.is_empty()) {
        let (word, plain) = piece.split_once('}').unwrap_or((piece, ""));
        pieces.push((plain, Some(word)));
    }
    pieces
}
