//! What a control does with its tables: facts, each with its source and its evidence.
//!
//! A profile is a TOML page (`controllers/*.toml`, or a user's own); this module holds it after
//! validation. Nothing in the program knows a control by name: compiler, emulator and checks ask
//! the facts below. Fields that a manual does not settle are facts with evidence
//! [`Evidence::Assumed`]; `generate` prints each of them with its consequence.

pub mod builtin;
pub mod checklist;
pub mod load;
mod load_check;
mod load_checklist;
mod load_facts;
mod load_files;
mod load_program;
pub mod program;

use crate::quantity::units::{Correction, Deviation};

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
    pub const fn not_used(self) -> &'static str {
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

/// What the numbers in a control's table mean: the machine's error, or what the control adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableSign {
    /// The table holds the deviation; a positive value makes the axis move in −.
    AsError,
    /// The table holds the correction; a positive value makes the axis move in +.
    AsCorrection,
}

impl TableSign {
    /// The number (µm) that a table of this sense holds for a deviation.
    pub fn table_um(self, deviation: Deviation) -> f64 {
        match self {
            TableSign::AsError => deviation.um(),
            TableSign::AsCorrection => (-deviation).um(),
        }
    }

    /// What the control adds when its table holds `um` micrometres.
    pub fn correction(self, um: f64) -> Correction {
        match self {
            TableSign::AsError => -Deviation::from_um(um),
            TableSign::AsCorrection => Correction::from_um(um),
        }
    }
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
    pub fn of_metric(value: f64) -> LengthUnit {
        if value > 0.0 {
            LengthUnit::Millimetre
        } else {
            LengthUnit::Inch
        }
    }

    /// The other way: `1 (metric)` or `0 (inch)`.
    pub const fn as_metric(self) -> &'static str {
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

/// An inclusive block of point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberRange {
    /// First number.
    pub first: u32,
    /// Last number.
    pub last: u32,
}

impl NumberRange {
    /// Whether a number lies in the block.
    pub const fn contains(self, number: u32) -> bool {
        self.first <= number && number <= self.last
    }

    /// Whether two blocks share a number.
    pub const fn overlaps(self, other: NumberRange) -> bool {
        self.first <= other.last && other.first <= self.last
    }
}

/// How Siemens tables are delivered (docs/siemens.md §3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableForm {
    /// Part program without header, ends with `M30`.
    Program,
    /// NC active data: `%_N_…_INI`, `CHANDATA(1)`, ends with `M17`.
    Data,
}

/// How a table t that names a factor table m contributes (docs/siemens.md §2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MultiplyMode {
    /// `f_t · f_m` instead of `f_t`.
    Product,
    /// `f_t + f_t · f_m`.
    Additive,
}

/// Facts of the Siemens dialect: ENC_COMP and CEC tables (docs/siemens.md).
#[derive(Clone, Debug, PartialEq)]
pub struct SiemensFacts {
    /// Sense of `$AA_ENC_COMP` values.
    pub lec_sign: Fact<TableSign>,
    /// Sense of `$AN_CEC` values.
    pub cec_sign: Fact<TableSign>,
    /// Program or data form.
    pub table_form: Fact<TableForm>,
    /// Most points of one ENC_COMP table.
    pub lec_points: Fact<u32>,
    /// Number of CEC tables of the control.
    pub cec_tables: Fact<u32>,
    /// Most points of one CEC table.
    pub cec_points: Fact<u32>,
    /// Whether the points of a CEC table are fixed by the option (no MD18342 to set).
    pub cec_memory_fixed: Fact<bool>,
    /// Decimals of table values in the control's unit; one count is the last decimal.
    pub value_decimals: Fact<u32>,
    /// Decimals of MIN, STEP and MAX in the control's unit.
    pub position_decimals: Fact<u32>,
    /// Clamp of the CEC total (MD32720), µm.
    pub cec_max_sum_um: Fact<f64>,
    /// Contribution of a table that names a factor table.
    pub multiply_mode: Fact<MultiplyMode>,
    /// Whether a table used as a factor also contributes by itself.
    pub factor_contributes: Fact<bool>,
}

/// Form of the straightness compensation (docs/fanuc.md §2.1, §2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StraightnessForm {
    /// Three straight pieces through four points.
    FourPoint,
    /// One increment for each pitch point of the moving axis, up to 128.
    PerPoint,
}

/// How parameter 3624 (interval) is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntervalForm {
    /// A real number in mm or inch, with a decimal point.
    Real,
    /// An integer in least input increments.
    Integer,
}

/// Facts of the Fanuc dialect: stored pitch error compensation (docs/fanuc.md).
#[derive(Clone, Debug, PartialEq)]
pub struct FanucFacts {
    /// Sense of pitch data.
    pub pitch_sign: Fact<TableSign>,
    /// Sense of straightness data.
    pub straightness_sign: Fact<TableSign>,
    /// Digits of a number below 10000 (`N03620` or `N3620`).
    pub number_digits: Fact<u32>,
    /// Whether blocks carry `Q1` (parameter) and `Q0` (pitch data).
    pub q_identifier: Fact<bool>,
    /// What is added to a point number in a file.
    pub point_offset: Fact<u32>,
    /// Numbers that pitch points may have.
    pub pitch_points: Fact<Vec<NumberRange>>,
    /// Numbers that the second run of a bidirectional table may have.
    pub minus_points: Fact<Vec<NumberRange>>,
    /// Largest increment of one point.
    pub increment_max: Fact<u32>,
    /// Largest magnification (3623).
    pub magnification_max: Fact<u32>,
    /// How 3624 is written.
    pub interval_form: Fact<IntervalForm>,
    /// Decimals of 3624 on a metric control (with `Integer`: of the least input increment).
    pub interval_decimals_mm: Fact<u32>,
    /// Decimals of 3624 on an inch control.
    pub interval_decimals_inch: Fact<u32>,
    /// The interval must be at least the largest feed (per minute) divided by this.
    pub interval_feed_divisor: Fact<f64>,
    /// Where inside its section a pulse comes out, 0 = lower end, 1 = upper end.
    pub output_fraction: Fact<f64>,
    /// Whether 3627 is multiplied by the magnification.
    pub reversal_magnified: Fact<bool>,
    /// Form of the straightness compensation.
    pub straightness_form: Fact<StraightnessForm>,
    /// Number of straightness sets.
    pub straightness_sets: Fact<u32>,
    /// Most pitch points of a moving axis that has straightness compensation.
    pub straightness_axis_points: Fact<u32>,
    /// Numbers of straightness data (per-point form).
    pub straightness_points: Fact<Vec<NumberRange>>,
    /// First parameter of the magnifications (per-point form), set 1.
    pub straightness_magnification_parameter: Fact<u32>,
    /// First parameter of the first data numbers (per-point form), set 1.
    pub straightness_start_parameter: Fact<u32>,
    /// Largest amount of the four-point form, detection units.
    pub straightness_amount_max: Fact<u32>,
}

/// Facts of the generic dialect (contract §4.1). Its table carries deviation, correction and
/// increment, so no sign has to be assumed.
#[derive(Clone, Debug, PartialEq)]
pub struct GenericFacts {
    /// Most points of one table, if the control has a limit.
    pub points: Fact<u32>,
}

/// The family of formats that a control reads.
#[allow(
    clippy::large_enum_variant,
    reason = "one profile is loaded in a run; a box would only be in the way"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum Dialect {
    /// `$AA_ENC_COMP` and `$AN_CEC` assignments.
    Siemens(SiemensFacts),
    /// Numbered parameters and pitch points.
    Fanuc(FanucFacts),
    /// One CSV and its JSON twin.
    Generic(GenericFacts),
}

impl Dialect {
    /// What its manuals call the backlash parameter.
    pub const fn backlash_parameter(&self) -> &'static str {
        match self {
            Dialect::Siemens(_) => "backlash parameter (MD32450)",
            Dialect::Fanuc(_) => "backlash parameter (1851)",
            Dialect::Generic(_) => "backlash parameter",
        }
    }

    /// The word used in profiles.
    pub const fn word(&self) -> &'static str {
        match self {
            Dialect::Siemens(_) => "siemens",
            Dialect::Fanuc(_) => "fanuc",
            Dialect::Generic(_) => "generic",
        }
    }
}

/// End of a line in the files of a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineEnd {
    /// `\n`
    Lf,
    /// `\r\n`
    CrLf,
    /// `\n\r\r`, what a 30i-class control itself writes.
    LfCrCr,
}

impl LineEnd {
    /// The bytes.
    pub const fn text(self) -> &'static str {
        match self {
            LineEnd::Lf => "\n",
            LineEnd::CrLf => "\r\n",
            LineEnd::LfCrCr => "\n\r\r",
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
    pub fn of_word(word: &str) -> Option<Role> {
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
    pub const fn is_read_back(self) -> bool {
        !matches!(self, Role::Checklist | Role::Report)
    }

    /// Whether people write into the file what they note; every other file has to stay as it was made.
    pub const fn is_written_into(self) -> bool {
        matches!(self, Role::Checklist)
    }
}

/// One file that a profile emits.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedFile {
    /// What it is for.
    pub role: Role,
    /// Its name in the kit.
    pub path: String,
    /// Name of the template.
    pub template_name: String,
    /// Text of the template.
    pub template: String,
    /// Emitted only if the kit holds such tables (`lec`, `cec`, `points`); absent = always.
    pub when: Option<String>,
    /// What a sign proof proves; other files have none.
    pub mechanism: Option<Mechanism>,
    /// Whether a control may load it; `false` is stated only of a `report`.
    pub may_be_loaded: bool,
}

impl EmittedFile {
    /// Whether a control may load the file, and no reader of this program takes it.
    pub fn is_loaded_unread(&self) -> bool {
        self.role == Role::Report && self.may_be_loaded
    }
}

/// Where a profile came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Compiled into the program.
    BuiltIn,
    /// A user's own, with the path as it was given.
    File(String),
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

/// A control, as the program knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The id, as in `controllers list`.
    pub id: String,
    /// Maker and model.
    pub name: String,
    /// Built in, or a user's own.
    pub origin: Origin,
    /// The format family with its facts.
    pub dialect: Dialect,
    /// Line end of the emitted files.
    pub line_end: Fact<LineEnd>,
    /// Whether the control's files may carry comments.
    pub comments: Fact<bool>,
    /// Names of the axes X, Y, Z where the job does not state them.
    pub axis_names: Fact<Vec<String>>,
    /// Whether the job must state a detection unit for each axis.
    pub detection_unit_required: Fact<bool>,
    /// The files of a kit, in the order of the manifest.
    pub files: Vec<EmittedFile>,
    /// The steps of a service visit, in order.
    pub checklist: Vec<checklist::Step>,
    /// The display that shows the correction that acts on an axis; `None` = none is known.
    pub display: Option<Fact<String>>,
    /// How its part programs are written; `None` = no program can be written for it.
    pub program: Option<program::ProgramFacts>,
    /// All facts in words, in the order of the program's questions.
    pub statements: Vec<Statement>,
}
