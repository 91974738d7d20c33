//! The variables of a program: `#1`, `#<name>`, `R1`. One that was not set has no value: never 0.

use std::collections::BTreeMap;
use std::fmt;

/// Variables from this number on belong to the control (tool data, positions, signals).
const FIRST_OF_CONTROL: u32 = 1000;

/// A variable as it is written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Name {
    /// `#1`.
    Number(u32),
    /// `#<name>`, in small letters.
    Named(String),
    /// `R1` of Siemens.
    R(u32),
}

impl Name {
    /// Whether it is one of the control's own, whose value no program tells.
    pub(super) fn is_of_control(&self) -> bool {
        matches!(self, Name::Number(number) if *number >= FIRST_OF_CONTROL || *number == 0)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Name::Number(number) => write!(f, "#{number}"),
            Name::Named(name) => write!(f, "#<{name}>"),
            Name::R(number) => write!(f, "R{number}"),
        }
    }
}

/// The values that a program has set.
pub(super) type Variables = BTreeMap<Name, f64>;
