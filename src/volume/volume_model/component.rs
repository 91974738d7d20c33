//! The 21 errors one by one.

use crate::quantity::axis::{ErrorTerm, Rotation};
use std::fmt;

/// One of the 21 errors of a three-axis machine: nine deviations, nine rotations, three squareness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// `EXX` … `EZZ`.
    Deviation(ErrorTerm),
    /// `EAX` … `ECZ`.
    Rotation(Rotation),
    /// The squareness that is stated as a slope of this term: φxy of EXY.
    Squareness(ErrorTerm),
}

impl Component {
    /// Its name in ISO 230-1 with the sign that turns it into ours, where the two differ
    /// (contract §1): EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz.
    pub(crate) fn iso_name(self) -> String {
        match self {
            Component::Squareness(term) => match (term.of.letter(), term.along.letter()) {
                ('X', 'Y') => "-EC0Y".to_string(),
                ('X', 'Z') => "EB0Z".to_string(),
                ('Y', 'Z') => "-EA0Z".to_string(),
                _ => self.to_string(),
            },
            _ => self.to_string(),
        }
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Component::Deviation(term) => term.fmt(out),
            Component::Rotation(rotation) => rotation.fmt(out),
            Component::Squareness(term) => {
                out.pad(&format!("squareness_{}{}", term.of.key(), term.along.key()))
            }
        }
    }
}
