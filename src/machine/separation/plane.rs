//! Planes of two axes, for squareness.

use crate::quantity::axis::Axis;

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
        match self {
            Plane::Xy => "xy",
            Plane::Xz => "xz",
            Plane::Yz => "yz",
        }
    }

    /// Its two axes.
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Plane::Xy => (Axis::X, Axis::Y),
            Plane::Xz => (Axis::X, Axis::Z),
            Plane::Yz => (Axis::Y, Axis::Z),
        }
    }
}

/// One value for each plane.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PerPlane<T> {
    /// XY.
    pub xy: T,
    /// XZ.
    pub xz: T,
    /// YZ.
    pub yz: T,
}

impl<T: Copy> PerPlane<T> {
    /// The value of a plane.
    pub const fn of(&self, plane: Plane) -> T {
        match plane {
            Plane::Xy => self.xy,
            Plane::Xz => self.xz,
            Plane::Yz => self.yz,
        }
    }

    /// Another value for each plane.
    pub fn map<U>(&self, to: impl Fn(T) -> U) -> PerPlane<U> {
        per_plane([to(self.xy), to(self.xz), to(self.yz)])
    }
}

/// Values for XY, XZ and YZ.
pub(super) fn per_plane<T>([xy, xz, yz]: [T; 3]) -> PerPlane<T> {
    PerPlane { xy, xz, yz }
}
