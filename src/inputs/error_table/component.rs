//! EXX … ECZ: a deviation or a rotation while one axis moves.

use crate::quantity::{Axis, ErrorTerm, Rotation};
use std::fmt;

/// A component of the error table: a deviation or a rotation while one axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// What deviates.
    pub kind: Kind,
    /// The moving axis.
    pub along: Axis,
}

/// Deviation or rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Deviation in the direction of an axis.
    Deviation(Axis),
    /// Rotation about an axis.
    Angle(Axis),
}

impl Kind {
    /// All of them, deviations first.
    pub const ALL: [Kind; 6] = [
        Kind::Deviation(Axis::X),
        Kind::Deviation(Axis::Y),
        Kind::Deviation(Axis::Z),
        Kind::Angle(Axis::X),
        Kind::Angle(Axis::Y),
        Kind::Angle(Axis::Z),
    ];

    /// Its word in the names of columns, e.g. `ex` or `ea`.
    pub(crate) fn word(self) -> String {
        Component { kind: self, along: Axis::X }.to_string()[..2].to_ascii_lowercase()
    }
}

impl Component {
    /// The component of a name such as `EYX` or `ECX`.
    pub fn from_name(name: &str) -> Option<Component> {
        let all = Axis::ALL.into_iter();
        let mut all = all.flat_map(|along| Kind::ALL.map(|kind| Component { kind, along }));
        all.find(|component| component.to_string() == name)
    }

    /// Whether an axis is measured along itself (`EXX`): the sense of its targets is then that of
    /// the deviation.
    pub(crate) fn is_positioning(self) -> bool {
        self.kind == Kind::Deviation(self.along)
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let along = self.along;
        match self.kind {
            Kind::Deviation(of) => ErrorTerm { of, along }.fmt(out),
            Kind::Angle(about) => Rotation { about, along }.fmt(out),
        }
    }
}
