//! What a control does with its tables: facts, each with its source and its evidence.
//!
//! A profile is a TOML page (`controllers/*.toml`, or a user's own); this module holds it after
//! validation. Nothing in the program knows a control by name: compiler, emulator and checks ask
//! the facts below. Fields that a manual does not settle are facts with evidence
//! [`Evidence::Assumed`]; `generate` prints each of them with its consequence.

pub mod builtin;
mod declared;
mod example;
pub(crate) mod fact;
mod family;
mod fanuc;
mod files;
mod form;
mod generic;
mod isg;
mod linuxcnc;
pub mod load;
mod pattern;
pub mod program;
mod siemens;

pub use self::declared::{BesideTable, DeclaredFacts, Factor};
pub use self::example::{Added, Example, ExampleAxis, ExampleFile};
pub(crate) use self::fact::RULE;
pub use self::fact::{
    Comments, ControlUnit, Evidence, Fact, Mechanism, NumberRange, Outside, Role, Statement,
    TableForm, TableSign,
};
use self::fact::{Facts, origin_or_rule};
pub use self::family::{Family, Proof};
pub use self::fanuc::{FanucFacts, IntervalForm, StraightnessForm};
pub use self::files::{EmittedFile, Template};
pub(crate) use self::form::Listed;
pub use self::form::{Form, Order, Rounding, Size, ValueForm};
pub use self::generic::{Typed, TypedValue};
pub use self::isg::{IsgFacts, LeverOrigin};
pub(crate) use self::linuxcnc::MOST_JOINTS;
pub use self::linuxcnc::{Columns, CrossTerms, LinuxcncFacts};
pub use self::pattern::Pattern;
pub(crate) use self::pattern::{Field, Said};
pub use self::siemens::{MultiplyMode, SiemensFacts};
use crate::control::checklist::Step;
use crate::control::claims::Precondition;
use crate::text::{Section, Word, section, words};
use serde::Serialize;

section! {
    /// Facts of every control.
    #[derive(Clone, Debug, PartialEq)]
    pub struct CommonFacts(facts: &Facts<'_>) {
        /// Line end of the emitted files.
        pub line_end: Fact<LineEnd> = stated(), must;
        /// Whether the control's files may carry comments.
        pub comments: Fact<Comments> = stated(), must;
        /// Names of the axes X, Y, Z where the job does not state them.
        pub axis_names: Fact<Vec<String>> = stated(), must;
        /// Whether the job must state a detection unit for each axis.
        pub detection_unit_required: Fact<bool> = stated(), must;
    }
}

/// The family of formats that a control reads.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a program holds a handful of profiles")]
pub enum Dialect {
    /// `$AA_ENC_COMP` and `$AN_CEC` assignments.
    Siemens(SiemensFacts),
    /// Numbered parameters and pitch points.
    Fanuc(FanucFacts),
    /// Tables in lines as the profile declares them, or as the generic table has them.
    Declared(DeclaredFacts),
    /// Tables of joints, named in the ini file, and curves of a HAL file.
    Linuxcnc(LinuxcncFacts),
    /// Volumetric compensation of the ISG kernel.
    Isg(IsgFacts),
}

words! {
    /// End of a line in the files of a control.
    pub enum LineEnd {
        /// `\n`
        Lf = "LF",
        /// `\r\n`
        CrLf = "CR LF",
        /// `\n\r\r`, what a 30i-class control itself writes.
        LfCrCr = "LF CR CR",
    }
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

words! {
    /// How the characters of a control's files are stored.
    pub enum Encoding {
        /// UTF-8, of which plain letters and digits are ASCII.
        Utf8 = "utf-8",
        /// UTF-16, the low byte first.
        Utf16Le = "utf-16le",
    }
}

/// Where a profile came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProfileSource {
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
    pub origin: ProfileSource,
    /// What all controls of its family have in common.
    pub family: &'static Family,
    /// The format family with its facts.
    pub dialect: Dialect,
    /// Line end of the emitted files.
    pub line_end: Fact<LineEnd>,
    /// How the characters of the emitted files are stored; `None` = not stated, UTF-8.
    pub encoding: Option<Fact<Encoding>>,
    /// Whether the control's files may carry comments.
    pub comments: Fact<Comments>,
    /// Names of the axes X, Y, Z where the job does not state them.
    pub axis_names: Fact<Vec<String>>,
    /// Whether the job must state a detection unit for each axis.
    pub detection_unit_required: Fact<bool>,
    /// The files of a kit, in the order of the manifest.
    pub files: Vec<EmittedFile>,
    /// Keys of a job that it needs, in order.
    pub job_keys: Vec<JobKey>,
    /// What a person has to see to on the control whatever the kit holds.
    pub preconditions: Vec<Precondition>,
    /// What switches tables off, as a remark on a kit without a file for it; `None` = a person has to see to it.
    pub off_by_hand: Option<String>,
    /// The page that explains the order of loading.
    pub page: Option<String>,
    /// The steps of a service visit, in order.
    pub checklist: Vec<Step>,
    /// The display that shows the correction that acts on an axis; `None` = none is known.
    pub display: Option<Fact<String>>,
    /// Files of others, and what the control adds for them.
    pub examples: Vec<Example>,
    /// Why there is none.
    pub no_example: Option<String>,
    /// How its part programs are written; `None` = no program can be written for it.
    pub program: Option<program::ProgramFacts>,
    /// All facts in words, in the order of the program's questions.
    pub statements: Vec<Statement>,
}

impl Profile {
    /// The file of a kit that is called so.
    pub(crate) fn file(&self, name: &str) -> Option<&EmittedFile> {
        self.files.iter().find(|file| file.is_called(name))
    }

    /// How the characters of the control's files are stored.
    pub(crate) fn encoding(&self) -> Encoding {
        let stated = self.encoding.as_ref();
        stated.map_or(Encoding::Utf8, |fact| fact.value)
    }
}

// Keys of a job that a control needs: what only a person at the machine knows, and where it is read there.

words! {
    /// The section of a job that a key stands in, without the axis.
    pub enum JobSection {
        /// Each `[machine.axes.x]`.
        MachineAxes = "machine.axes",
        /// `[measurement]`.
        Measurement = "measurement",
        /// `[compensation]`.
        Compensation = "compensation",
        /// Each `[compensation.axes.x]`.
        CompensationAxes = "compensation.axes",
    }
}

section! {
    /// One `[[job]]` of a profile.
    #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
    pub struct JobKey(page: &Section<'_>, origin: Option<Fact<()>>) {
        /// Where it stands in a job.
        pub section: JobSection = choice(JobSection::WORDS),
            must "the section of a job that the key stands in";
        /// The key.
        pub key: String = text(), must "a key of a job";
        /// What an optional key may hold, as it is written; `None` = the job has to state it.
        pub example: Option<String> = text();
        /// What to write, and where it is read on the control.
        pub text: String = text(), must "what to write, and where the control shows it";
        /// How well that is known.
        pub evidence: Evidence => origin.as_ref().map(|origin| origin.evidence), must;
        /// Where it is from.
        pub source: String => origin.as_ref().map(|origin| origin.source.clone()), must;
        /// What happens if it is wrong.
        pub consequence: Option<String> => origin.and_then(|origin| origin.consequence);
    }
}

/// The keys of a page, in its order; none where it names none.
fn job_keys(root: &Section<'_>) -> Vec<JobKey> {
    root.subs("job", |section| JobKey::read(section, origin_or_rule(section)))
}
