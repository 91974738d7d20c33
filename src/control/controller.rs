//! What a control does with its tables: facts, each with its source and its evidence.
//!
//! A profile is a TOML page (`controllers/*.toml`, or a user's own); this module holds it after
//! validation. Nothing in the program knows a control by name: compiler, emulator and checks ask
//! the facts below. Fields that a manual does not settle are facts with evidence
//! [`Evidence::Assumed`]; `generate` prints each of them with its consequence.

pub mod builtin;
pub(crate) mod fact;
pub mod load;
mod load_parts;
pub mod program;

pub use self::fact::{Evidence, Fact, LengthUnit, Mechanism, NumberRange, Role, Statement};

use self::fact::{Word, facts};
use crate::control::checklist::Step;
use crate::quantity::units::{Correction, Deviation};

/// What the numbers in a control's table mean: the machine's error, or what the control adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TableSign {
    /// The table holds the deviation; a positive value makes the axis move in −.
    AsError,
    /// The table holds the correction; a positive value makes the axis move in +.
    AsCorrection,
}

impl Word for TableSign {
    const WORDS: &'static [(&'static str, TableSign)] = &[
        ("as_error", TableSign::AsError),
        ("as_correction", TableSign::AsCorrection),
    ];
}

impl TableSign {
    /// The number (µm) that a table of this sense holds for a deviation.
    pub(crate) fn table_um(self, deviation: Deviation) -> f64 {
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

/// How Siemens tables are delivered (docs/siemens.md §3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableForm {
    /// Part program without header, ends with `M30`.
    Program,
    /// NC active data: `%_N_…_INI`, `CHANDATA(1)`, ends with `M17`.
    Data,
}

impl Word for TableForm {
    const WORDS: &'static [(&'static str, TableForm)] =
        &[("program", TableForm::Program), ("data", TableForm::Data)];
}

/// How a table t that names a factor table m contributes (docs/siemens.md §2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MultiplyMode {
    /// `f_t · f_m` instead of `f_t`.
    Product,
    /// `f_t + f_t · f_m`.
    Additive,
}

impl Word for MultiplyMode {
    const WORDS: &'static [(&'static str, MultiplyMode)] = &[
        ("product", MultiplyMode::Product),
        ("additive", MultiplyMode::Additive),
    ];
}

facts! {
    /// Facts of the Siemens dialect: ENC_COMP and CEC tables (docs/siemens.md).
    SiemensFacts {
        /// Sense of `$AA_ENC_COMP` values.
        lec_sign: TableSign,
        /// Sense of `$AN_CEC` values.
        cec_sign: TableSign,
        /// Program or data form.
        table_form: TableForm,
        /// Most points of one ENC_COMP table.
        lec_points: u32,
        /// Number of CEC tables of the control.
        cec_tables: u32,
        /// Most points of one CEC table.
        cec_points: u32,
        /// Whether the points of a CEC table are fixed by the option (no MD18342 to set).
        cec_memory_fixed: bool,
        /// Decimals of table values in the control's unit; one count is the last decimal.
        value_decimals: u32,
        /// Decimals of MIN, STEP and MAX in the control's unit.
        position_decimals: u32,
        /// Clamp of the CEC total (MD32720), µm.
        cec_max_sum_um: f64,
        /// Contribution of a table that names a factor table.
        multiply_mode: MultiplyMode,
        /// Whether a table used as a factor also contributes by itself.
        factor_contributes: bool,
    }
}

/// Form of the straightness compensation (docs/fanuc.md §2.1, §2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StraightnessForm {
    /// Three straight pieces through four points.
    FourPoint,
    /// One increment for each pitch point of the moving axis, up to 128.
    PerPoint,
}

impl Word for StraightnessForm {
    const WORDS: &'static [(&'static str, StraightnessForm)] = &[
        ("four-point", StraightnessForm::FourPoint),
        ("per-point", StraightnessForm::PerPoint),
    ];
}

/// How parameter 3624 (interval) is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntervalForm {
    /// A real number in mm or inch, with a decimal point.
    Real,
    /// An integer in least input increments.
    Integer,
}

impl Word for IntervalForm {
    const WORDS: &'static [(&'static str, IntervalForm)] = &[
        ("real", IntervalForm::Real),
        ("integer", IntervalForm::Integer),
    ];
}

facts! {
    /// Facts of the Fanuc dialect: stored pitch error compensation (docs/fanuc.md).
    FanucFacts {
        /// Sense of pitch data.
        pitch_sign: TableSign,
        /// Sense of straightness data.
        straightness_sign: TableSign,
        /// Digits of a number below 10000 (`N03620` or `N3620`).
        number_digits: u32,
        /// Whether blocks carry `Q1` (parameter) and `Q0` (pitch data).
        q_identifier: bool,
        /// What is added to a point number in a file.
        point_offset: u32,
        /// Numbers that pitch points may have.
        pitch_points: Vec<NumberRange>,
        /// Numbers that the second run of a bidirectional table may have.
        minus_points: Vec<NumberRange>,
        /// Largest increment of one point.
        increment_max: u32,
        /// Largest magnification (3623).
        magnification_max: u32,
        /// How 3624 is written.
        interval_form: IntervalForm,
        /// Decimals of 3624 on a metric control (with `Integer`: of the least input increment).
        interval_decimals_mm: u32,
        /// Decimals of 3624 on an inch control.
        interval_decimals_inch: u32,
        /// The interval must be at least the largest feed (per minute) divided by this.
        interval_feed_divisor: f64,
        /// Where inside its section a pulse comes out, 0 = lower end, 1 = upper end.
        output_fraction: f64,
        /// Whether 3627 is multiplied by the magnification.
        reversal_magnified: bool,
        /// Form of the straightness compensation.
        straightness_form: StraightnessForm,
        /// Number of straightness sets.
        straightness_sets: u32,
        /// Most pitch points of a moving axis that has straightness compensation.
        straightness_axis_points: u32,
        /// Numbers of straightness data (per-point form).
        straightness_points: Vec<NumberRange>,
        /// First parameter of the magnifications (per-point form), set 1.
        straightness_magnification_parameter: u32,
        /// First parameter of the first data numbers (per-point form), set 1.
        straightness_start_parameter: u32,
        /// Largest amount of the four-point form, detection units.
        straightness_amount_max: u32,
    }
}

facts! {
    /// Facts of the generic dialect (contract §4.1). Its table carries deviation, correction and
    /// increment, so no sign has to be assumed.
    GenericFacts {
        /// Most points of one table, if the control has a limit.
        points: u32,
    }
}

impl FanucFacts {
    /// Whether a parameter holds the magnification or the first data number of a per-point set.
    pub(crate) fn is_of_per_point_set(&self, number: u32) -> bool {
        let firsts = [
            &self.straightness_magnification_parameter,
            &self.straightness_start_parameter,
        ];
        let sets = self.straightness_sets.value;
        let mut firsts = firsts.iter().map(|first| first.value);
        firsts.any(|first| (first..first + sets).contains(&number))
    }
}

facts! {
    /// Facts of every control.
    CommonFacts {
        /// Line end of the emitted files.
        line_end: LineEnd,
        /// Whether the control's files may carry comments.
        comments: bool,
        /// Names of the axes X, Y, Z where the job does not state them.
        axis_names: Vec<String>,
        /// Whether the job must state a detection unit for each axis.
        detection_unit_required: bool,
    }
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
    pub(crate) const fn backlash_parameter(&self) -> &'static str {
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

impl Word for LineEnd {
    const WORDS: &'static [(&'static str, LineEnd)] = &[
        ("LF", LineEnd::Lf),
        ("CR LF", LineEnd::CrLf),
        ("LF CR CR", LineEnd::LfCrCr),
    ];
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
    pub(crate) fn is_loaded_unread(&self) -> bool {
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
    pub checklist: Vec<Step>,
    /// The display that shows the correction that acts on an axis; `None` = none is known.
    pub display: Option<Fact<String>>,
    /// How its part programs are written; `None` = no program can be written for it.
    pub program: Option<program::ProgramFacts>,
    /// All facts in words, in the order of the program's questions.
    pub statements: Vec<Statement>,
}
