//! What all controls of a family have in common, and all part programs of a language, whichever profile names them.

use crate::control::controller::fact::{ControlUnit, Mechanism, Outside};
use crate::control::table::Tables;

/// A family of controls: what is known of it and stands in no profile.
#[derive(Debug, PartialEq)]
pub struct Family {
    /// The word of profiles.
    pub word: &'static str,
    /// What its manuals call the backlash parameter.
    pub(crate) backlash_parameter: &'static str,
    /// What its emulator does between two points; a profile has to state it.
    pub(crate) between: &'static str,
    /// What its emulator can do outside a table; a profile states one of them.
    pub(crate) outside: &'static [Outside],
    /// The tables of a control that holds none.
    pub(crate) no_tables: Tables,
    /// What an old table is set to that new files leave in the control.
    pub(crate) off: &'static str,
    /// Whether compensation off and on have no common zero: the power goes off between them, so that the reference
    /// point is found anew, or the correction is not zero at the reference.
    pub(crate) restarts: bool,
    /// The mechanisms of which a sign proof can show the sign.
    pub(crate) proofs: &'static [Proof],
}

/// A mechanism of which a sign proof can show the sign.
#[derive(Debug, PartialEq, Eq)]
pub struct Proof {
    /// Which.
    pub mechanism: Mechanism,
    /// What people call it.
    pub(crate) name: &'static str,
    /// The fact of a profile that states its sign.
    pub(crate) sign_fact: &'static str,
    /// What a person has to see to besides.
    pub(crate) beside: Option<&'static str>,
}

impl Proof {
    /// One beside which a person has nothing to see to.
    pub(super) const fn of(
        mechanism: Mechanism,
        name: &'static str,
        sign_fact: &'static str,
    ) -> Proof {
        Proof { mechanism, name, sign_fact, beside: None }
    }
}

/// A family of part programs: what is known of it and stands in no profile.
#[derive(Debug)]
pub(crate) struct LanguageFacts {
    /// Word of a program in mm.
    pub(super) metric: &'static str,
    /// Word of a program in inch.
    pub(super) inch: &'static str,
    /// Addresses of a dwell in seconds, and how it is written.
    pub(super) dwell: (&'static [char], &'static str),
    /// Of programs with numbers the first that may be protected, and by what; `None` = they have names.
    pub(crate) numbered: Option<(u32, &'static str)>,
    /// What else has to be so before cycle start: what, how, why, source.
    pub(crate) preconditions: &'static [[&'static str; 4]],
}

impl LanguageFacts {
    /// The word of a unit.
    pub(crate) const fn unit_word(&self, unit: ControlUnit) -> &'static str {
        match unit {
            ControlUnit::Millimetre => self.metric,
            ControlUnit::Inch => self.inch,
        }
    }
}
