//! What a control does with its tables: facts, each with its source and its evidence.
//!
//! A profile is a TOML page (`controllers/*.toml`, or a user's own); this module holds it after
//! validation. Nothing in the program knows a control by name: compiler, emulator and checks ask
//! the facts below. Fields that a manual does not settle are facts with evidence
//! [`Evidence::Assumed`]; `generate` prints each of them with its consequence.

pub mod builtin;
mod declared;
pub(crate) mod fact;
mod family;
mod fanuc;
mod files;
mod form;
mod isg;
mod linuxcnc;
pub mod load;
mod pattern;
pub mod program;
mod siemens;

pub use self::declared::{BesideTable, DeclaredFacts, Factor, Typed, TypedValue};
pub(crate) use self::fact::RULE;
pub use self::fact::{
    Comments, ControlUnit, Evidence, Fact, Mechanism, NumberRange, Outside, Role, Statement,
    TableForm, TableSign,
};
pub use self::family::{Family, Proof};
pub use self::fanuc::{FanucFacts, IntervalForm, StraightnessForm};
pub use self::files::{EmittedFile, KitFile, Template};
pub(crate) use self::form::PointLists;
pub use self::form::{Form, Order, Rounding, Size, ValueForm};
pub use self::isg::{IsgFacts, LeverOrigin};
pub(crate) use self::linuxcnc::MOST_JOINTS;
pub use self::linuxcnc::{Columns, CrossTerms, LinuxcncFacts};
pub use self::load::{Added, Example, ExampleAxis, ExampleFile, Profile};
pub use self::pattern::Pattern;
pub(crate) use self::pattern::{Field, Said};
pub use self::siemens::{MultiplyMode, SiemensFacts};
use crate::text::{Section, Word, section, words};
use serde::Serialize;

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
        /// What every job of the control has for it, as it is written.
        pub value: Option<String> = text();
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
