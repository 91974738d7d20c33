//! Klipper: the factors of a skew correction (docs/klipper.md §1).

use crate::quantity::axis::{Axis, ErrorTerm};

/// `[skew_correction NAME]`: how far one axis leans towards another, mm in a mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Skew {
    /// The name by which it is loaded.
    pub name: String,
    /// `xy_skew`: X while Y moves.
    pub xy: f64,
    /// `xz_skew`: X while Z moves.
    pub xz: f64,
    /// `yz_skew`: Y while Z moves.
    pub yz: f64,
}

/// What a printer holds: one skew correction or none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KlipperTables {
    /// The correction that is loaded.
    pub skew: Option<Skew>,
}

/// The terms whose slopes it takes off, with the names of their factors.
pub const FACTORS: [(ErrorTerm, &str); 3] = [
    (term(Axis::X, Axis::Y), "xy_skew"),
    (term(Axis::X, Axis::Z), "xz_skew"),
    (term(Axis::Y, Axis::Z), "yz_skew"),
];

const fn term(of: Axis, along: Axis) -> ErrorTerm {
    ErrorTerm { of, along }
}

impl Skew {
    /// A correction without effect.
    pub(crate) fn none(name: &str) -> Skew {
        Skew { name: name.to_string(), xy: 0.0, xz: 0.0, yz: 0.0 }
    }

    /// The factors in the order of [`FACTORS`].
    pub(crate) const fn factors(&self) -> [f64; 3] {
        [self.xy, self.xz, self.yz]
    }

    /// The same with other factors, in that order.
    pub(crate) fn with(self, [xy, xz, yz]: [f64; 3]) -> Skew {
        Skew { xy, xz, yz, ..self }
    }
}

/// The factor of a term.
pub(crate) fn factor_name(term: ErrorTerm) -> Option<&'static str> {
    let own = FACTORS.iter().find(|(own, _)| *own == term);
    own.map(|(_, name)| *name)
}
