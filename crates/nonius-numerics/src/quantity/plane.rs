//! The three planes of two axes, and values for each of them.

use super::axis::{Axis, ErrorTerm};
use serde::{Serialize, Serializer};

/// A plane of two axes, for squareness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// X and Y.
    Xy,
    /// X and Z.
    Xz,
    /// Y and Z.
    Yz,
}

impl Plane {
    /// The three planes, XY first.
    pub const ALL: [Plane; 3] = [Plane::Xy, Plane::Xz, Plane::Yz];

    /// Its key in documents.
    pub const fn key(self) -> &'static str {
        ["xy", "xz", "yz"][self as usize]
    }

    /// Its two axes.
    pub const fn axes(self) -> (Axis, Axis) {
        [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)][self as usize]
    }

    /// The cross term that carries the squareness in the X-primary frame, and to which a stated one is added: EXY, EXZ,
    /// EYZ.
    pub const fn carrier(self) -> ErrorTerm {
        let (of, along) = self.axes();
        ErrorTerm { of, along }
    }

    /// Its two cross terms, the carrier first.
    pub const fn terms(self) -> [ErrorTerm; 2] {
        [self.carrier(), self.carrier().twin()]
    }
}

/// One value for each plane.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PerPlane<T>([T; 3]);

impl<T> PerPlane<T> {
    /// The value of each plane from a function of the plane.
    pub fn from_fn(of: impl FnMut(Plane) -> T) -> PerPlane<T> {
        PerPlane(Plane::ALL.map(of))
    }
}

impl<T: Copy> PerPlane<T> {
    /// The value of a plane.
    pub const fn of(&self, plane: Plane) -> T {
        self.0[plane as usize]
    }

    /// Another value for each plane.
    pub fn map<U>(&self, to: impl Fn(T) -> U) -> PerPlane<U> {
        PerPlane(self.0.map(to))
    }
}

/// By the names of the planes; a plane without a figure is absent.
impl Serialize for PerPlane<Option<f64>> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let known = Plane::ALL.into_iter();
        to.collect_map(known.filter_map(|plane| Some((plane.key(), self.of(plane)?))))
    }
}
