//! A fact of a control, and how sure it is.

/// How well a fact is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Read in a manual of the maker, or in data that a real control wrote.
    Manual,
    /// Taken from memory, inference or a weaker source; a control may differ.
    Assumed,
    /// Seen on a real control that executed our file.
    Executed,
}

impl Evidence {
    /// The word used in profiles and manifests.
    pub const fn word(self) -> &'static str {
        match self {
            Evidence::Manual => "manual",
            Evidence::Assumed => "assumed",
            Evidence::Executed => "executed",
        }
    }
}

/// What of a control a fact belongs to: it matters for a kit only where the kit uses that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// Siemens: measuring-system error compensation.
    EncComp,
    /// Siemens: cross-error compensation.
    Cec,
    /// Siemens: CEC tables that multiply each other.
    CecProducts,
    /// Fanuc: stored pitch error compensation.
    Pitch,
    /// Fanuc: pitch tables of their own for travel in −.
    Bidirectional,
    /// Fanuc: straightness compensation of either form.
    Straightness,
    /// Fanuc: straightness through four points.
    FourPoint,
    /// Fanuc: straightness with one increment for each point.
    PerPoint,
    /// Basic system mm.
    Metric,
    /// Basic system inch.
    Inch,
    /// Nothing: a wrong value has no consequence.
    Nothing,
}

impl Mechanism {
    /// The words of profiles (`mechanism = "…"`).
    pub const WORDS: [(&'static str, Mechanism); 11] = [
        ("enc-comp", Mechanism::EncComp),
        ("cec", Mechanism::Cec),
        ("cec-products", Mechanism::CecProducts),
        ("pitch", Mechanism::Pitch),
        ("bidirectional", Mechanism::Bidirectional),
        ("straightness", Mechanism::Straightness),
        ("four-point", Mechanism::FourPoint),
        ("per-point", Mechanism::PerPoint),
        ("metric", Mechanism::Metric),
        ("inch", Mechanism::Inch),
        ("none", Mechanism::Nothing),
    ];

    /// What a sign proof can prove, with the words of profiles.
    pub const PROVED: [(&'static str, Mechanism); 5] = [
        ("enc-comp", Mechanism::EncComp),
        ("cec", Mechanism::Cec),
        ("pitch", Mechanism::Pitch),
        ("four-point", Mechanism::FourPoint),
        ("per-point", Mechanism::PerPoint),
    ];

    /// Why a fact has no effect on a kit that does not use what it belongs to.
    pub(crate) const fn not_used(self) -> &'static str {
        match self {
            Mechanism::EncComp => "this kit holds no ENC_COMP table",
            Mechanism::Cec => "this kit holds no CEC table",
            Mechanism::CecProducts => "this kit holds no product of CEC tables",
            Mechanism::Pitch => "this kit holds no pitch points",
            Mechanism::Bidirectional => "this kit holds one table for both directions",
            Mechanism::Straightness => "this kit holds no straightness table",
            Mechanism::FourPoint => "this kit holds no four-point straightness",
            Mechanism::PerPoint => "this kit holds no 128-point straightness",
            Mechanism::Metric => "this kit is in inch",
            Mechanism::Inch => "this kit is in mm",
            Mechanism::Nothing => "a wrong value has no consequence",
        }
    }
}

/// A statement about a control, with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact<T> {
    /// What is stated.
    pub value: T,
    /// How well it is known.
    pub evidence: Evidence,
    /// Manual, edition, chapter; or why it is assumed.
    pub source: String,
    /// What happens on the machine if it is wrong (required for assumed facts).
    pub consequence: Option<String>,
}

/// Basic system of the control: the unit of positions (and Siemens values) in its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Millimetre,
    /// Inches (25.4 mm).
    Inch,
}

impl LengthUnit {
    /// Millimetres in one unit.
    pub const fn in_mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => crate::quantity::units::MM_PER_INCH,
        }
    }

    /// The unit that machine data such as MD10240 and MD32711 stand for: 1 = metric, 0 = inch.
    pub(crate) fn of_metric(value: f64) -> LengthUnit {
        if value > 0.0 {
            LengthUnit::Millimetre
        } else {
            LengthUnit::Inch
        }
    }

    /// The other way: `1 (metric)` or `0 (inch)`.
    pub(crate) const fn as_metric(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "1 (metric)",
            LengthUnit::Inch => "0 (inch)",
        }
    }

    /// `mm` or `inch`.
    pub const fn word(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Inch => "inch",
        }
    }
}

/// What an emitted file is for (contract §4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Compensation values.
    Table,
    /// Parameters, or memory reservation.
    Parameters,
    /// Switches the compensation on.
    Enable,
    /// Switches it off.
    Disable,
    /// Restores what was read out of the control.
    Rollback,
    /// Tables that are zero but for one bump, to prove the sign of a mechanism.
    SignProof,
    /// What to do at the machine, for people.
    Checklist,
    /// Whatever else a user's template writes; no reader of this program takes it, so nothing shows
    /// what a control would hold that loads it.
    Report,
}

impl Role {
    /// Every role.
    pub const ALL: [Role; 8] = [
        Role::Table,
        Role::Parameters,
        Role::Enable,
        Role::Disable,
        Role::Rollback,
        Role::SignProof,
        Role::Checklist,
        Role::Report,
    ];

    /// The role of a word in a profile or a manifest.
    pub(crate) fn of_word(word: &str) -> Option<Role> {
        Role::ALL.into_iter().find(|role| role.word() == word)
    }

    /// The word used in profiles and manifests.
    pub const fn word(self) -> &'static str {
        match self {
            Role::Table => "table",
            Role::Parameters => "parameters",
            Role::Enable => "enable",
            Role::Disable => "disable",
            Role::Rollback => "rollback",
            Role::SignProof => "sign-proof",
            Role::Checklist => "checklist",
            Role::Report => "report",
        }
    }

    /// Whether the file stands beside the kit: a control loads it instead of the tables, never
    /// with them.
    pub const fn stands_apart(self) -> bool {
        matches!(self, Role::Rollback | Role::SignProof)
    }

    /// Whether a reader of this program takes the file.
    pub(crate) const fn is_read_back(self) -> bool {
        !matches!(self, Role::Checklist | Role::Report)
    }

    /// Whether people write into the file what they note; every other file has to stay as it was made.
    pub(crate) const fn is_written_into(self) -> bool {
        matches!(self, Role::Checklist)
    }
}

/// A fact as it stands in the profile, for people and for the manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statement {
    /// Name of the fact.
    pub fact: String,
    /// Its value as written in the profile.
    pub value: String,
    /// How well it is known.
    pub evidence: Evidence,
    /// Where it is from.
    pub source: String,
    /// What happens if it is wrong.
    pub consequence: Option<String>,
    /// What it belongs to; `None` = it matters for every kit.
    pub mechanism: Option<Mechanism>,
}
