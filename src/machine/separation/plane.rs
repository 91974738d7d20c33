//! Planes of two axes, for squareness, and the six unknowns of formula (7).

use crate::quantity::axis::{Axis, ErrorTerm};
use serde::{Serialize, Serializer};

/// Number of unknowns: three scales, three squareness errors.
pub(super) const UNKNOWNS: usize = 6;

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

    /// Its two cross terms; the first one carries the squareness in the X-primary frame.
    pub(super) const fn terms(self) -> [ErrorTerm; 2] {
        let (a, b) = self.axes();
        [ErrorTerm { of: a, along: b }, ErrorTerm { of: b, along: a }]
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

impl<T> PerPlane<T> {
    /// The value of each plane from a function of the plane.
    pub(crate) fn from_fn(of: impl FnMut(Plane) -> T) -> PerPlane<T> {
        let [xy, xz, yz] = Plane::ALL.map(of);
        PerPlane { xy, xz, yz }
    }
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
        PerPlane::from_fn(|plane| to(self.of(plane)))
    }
}

/// By the names of the planes; a plane without a figure is absent.
impl Serialize for PerPlane<Option<f64>> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let known = Plane::ALL.into_iter();
        to.collect_map(known.filter_map(|plane| Some((plane.key(), self.of(plane)?))))
    }
}

/// One of the unknowns of (7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unknown {
    Scale(Axis),
    Squareness(Plane),
}

impl Unknown {
    pub(super) const ALL: [Unknown; UNKNOWNS] = [
        Unknown::Scale(Axis::X),
        Unknown::Scale(Axis::Y),
        Unknown::Scale(Axis::Z),
        Unknown::Squareness(Plane::Xy),
        Unknown::Squareness(Plane::Xz),
        Unknown::Squareness(Plane::Yz),
    ];

    /// The one that the slope of a term is a part of.
    pub(super) fn of(term: ErrorTerm) -> Unknown {
        let of_plane = |plane: &Plane| plane.terms().contains(&term);
        let plane = Plane::ALL.into_iter().find(of_plane);
        plane.map_or(Unknown::Scale(term.along), Unknown::Squareness)
    }

    pub(super) fn index(self) -> usize {
        let place = Self::ALL.iter().position(|known| *known == self);
        place.unwrap_or(0)
    }
}
