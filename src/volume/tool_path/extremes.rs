//! Smallest and largest values along a path, with the places where they are.

use crate::inputs::nc::Place;

/// What is followed along a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Error in X.
    X,
    /// Error in Y.
    Y,
    /// Error in Z.
    Z,
    /// Along the path: positive ahead.
    Tangent,
    /// Across the path in the selected plane: positive to the left.
    Normal,
    /// Length of the error vector.
    Length,
}

impl Channel {
    /// All of them, in the order in which they are shown.
    pub const ALL: [Channel; 6] = [
        Channel::X,
        Channel::Y,
        Channel::Z,
        Channel::Tangent,
        Channel::Normal,
        Channel::Length,
    ];

    /// Its name in tables and documents.
    pub const fn name(self) -> &'static str {
        match self {
            Channel::X => "ex",
            Channel::Y => "ey",
            Channel::Z => "ez",
            Channel::Tangent => "tangent",
            Channel::Normal => "normal",
            Channel::Length => "|e|",
        }
    }
}

/// An extreme value and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// µm.
    pub um: f64,
    /// Machine coordinates, mm.
    pub place: Place,
    /// Line of the program.
    pub line: usize,
}

/// Smallest and largest value of a channel; of several places with the same one, the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub min: Extreme,
    /// The largest.
    pub max: Extreme,
}

impl Range {
    pub(super) const NONE: Range = Range {
        min: Extreme {
            um: f64::INFINITY,
            place: [0.0; 3],
            line: 0,
        },
        max: Extreme {
            um: f64::NEG_INFINITY,
            place: [0.0; 3],
            line: 0,
        },
    };

    /// Whether a value lies outside.
    #[inline]
    pub(super) fn is_passed_by(&self, um: f64) -> bool {
        um < self.min.um || um > self.max.um
    }

    #[inline]
    pub(super) fn take(&mut self, um: f64, place: Place, line: usize) {
        if um < self.min.um {
            self.min = Extreme { um, place, line };
        }
        if um > self.max.um {
            self.max = Extreme { um, place, line };
        }
    }

    /// The range, if anything was taken.
    pub(super) fn found(self) -> Option<Range> {
        self.min.um.is_finite().then_some(self)
    }
}
