//! What a control does with its tables: facts, each with its source and its evidence.
//!
//! A profile is a TOML page (`controllers/*.toml`, or a user's own); this module holds it after
//! validation. Nothing in the program knows a control by name: compiler, emulator and checks ask
//! the facts below. Fields that a manual does not settle are facts with evidence
//! [`Evidence::Assumed`]; `generate` prints each of them with its consequence.

pub mod builtin;
mod declared;
pub(crate) mod fact;
mod families;
mod family;
mod fanuc;
mod generic;
mod isg;
mod job_keys;
mod klipper;
mod linuxcnc;
pub mod load;
mod load_parts;
mod pattern;
pub mod program;
mod siemens;

pub use self::declared::{BesideTable, DeclaredFacts, Order, Size, ValueForm};
pub(crate) use self::fact::RULE;
pub use self::fact::{
    Comments, ControlUnit, Evidence, Fact, Mechanism, NumberRange, Outside, Role, Statement,
    TableForm, TableSign,
};
pub use self::family::{Family, Proof};
pub use self::fanuc::{FanucFacts, IntervalForm, StraightnessForm};
pub use self::generic::{GenericFacts, TypedValue};
pub use self::isg::{IsgFacts, LeverOrigin};
pub use self::job_keys::{JobKey, JobSection};
pub use self::klipper::KlipperFacts;
pub use self::linuxcnc::{CrossTerms, LinuxcncFacts};
pub(crate) use self::pattern::Field;
pub use self::pattern::Pattern;
pub use self::siemens::{MultiplyMode, SiemensFacts};

use self::fact::facts;
use crate::control::checklist::Step;
use crate::text::words::words;

facts! {
    /// Facts of every control.
    CommonFacts {
        /// Line end of the emitted files.
        line_end: LineEnd,
        /// Whether the control's files may carry comments.
        comments: Comments,
        /// Names of the axes X, Y, Z where the job does not state them.
        axis_names: Vec<String>,
        /// Whether the job must state a detection unit for each axis.
        detection_unit_required: bool,
    }
}

/// The family of formats that a control reads.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialect {
    /// `$AA_ENC_COMP` and `$AN_CEC` assignments.
    Siemens(SiemensFacts),
    /// Numbered parameters and pitch points.
    Fanuc(FanucFacts),
    /// One CSV and its JSON twin.
    Generic(GenericFacts),
    /// Lines and tables as the profile declares them.
    Declared(DeclaredFacts),
    /// Tables of joints, named in the ini file, and curves of a HAL file.
    Linuxcnc(LinuxcncFacts),
    /// Volumetric compensation of the ISG kernel.
    Isg(IsgFacts),
    /// Skew correction of Klipper.
    Klipper(KlipperFacts),
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

/// One file that a profile emits.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedFile {
    /// What it is for.
    pub role: Role,
    /// Its name in the kit; of one for each item of a list with the item's field in braces.
    pub path: String,
    /// The list of which each item gets a file of its own (`joints`); absent = one file.
    pub each: Option<String>,
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
    /// Whether it is a page for a browser: its template sees every text as HTML.
    pub(crate) fn is_page(&self) -> bool {
        self.path.to_ascii_lowercase().ends_with(".html")
    }

    /// What stands before and behind the field in braces, and the field: `joint-{number}.comp`.
    pub(crate) fn field(&self) -> Option<[&str; 3]> {
        let (before, rest) = self.path.split_once('{')?;
        let (field, behind) = rest.split_once('}')?;
        Some([before, field, behind])
    }

    /// Whether a file is called so, in capitals or not.
    pub fn is_called(&self, name: &str) -> bool {
        let Some([before, _, behind]) = self.field() else {
            return self.path.eq_ignore_ascii_case(name);
        };
        let name = name.to_ascii_lowercase();
        let inside = name.strip_prefix(&before.to_ascii_lowercase());
        let inside = inside.and_then(|rest| rest.strip_suffix(&behind.to_ascii_lowercase()));
        inside.is_some_and(|item| {
            !item.is_empty() && item.bytes().all(|byte| byte.is_ascii_alphanumeric())
        })
    }

    /// Whether a control may load the file, and no reader of this program takes it.
    pub(crate) fn is_loaded_unread(&self) -> bool {
        self.role == Role::Report && self.may_be_loaded
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
    /// The steps of a service visit, in order.
    pub checklist: Vec<Step>,
    /// The display that shows the correction that acts on an axis; `None` = none is known.
    pub display: Option<Fact<String>>,
    /// How its part programs are written; `None` = no program can be written for it.
    pub program: Option<program::ProgramFacts>,
    /// All facts in words, in the order of the program's questions.
    pub statements: Vec<Statement>,
}

impl Profile {
    /// How the characters of the control's files are stored.
    pub(crate) fn encoding(&self) -> Encoding {
        let stated = self.encoding.as_ref();
        stated.map_or(Encoding::Utf8, |fact| fact.value)
    }
}
