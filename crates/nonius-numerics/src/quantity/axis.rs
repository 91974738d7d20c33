//! Axes, directions, the nine error terms and the nine rotations, with the names of ISO 230-1.
//!
//! `EYX` is the deviation in **Y** while **X** moves: direction first, moving axis second.
//! Terms are indexed by their two axes, never by a number.

use serde::{Deserialize, Serialize, Serializer};
use std::fmt;
use std::ops::{Index, IndexMut};

/// A linear axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// The X axis.
    X,
    /// The Y axis.
    Y,
    /// The Z axis.
    Z,
}

impl Axis {
    /// The three axes in their usual order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// All orders of the three.
    pub const ORDERS: [[Axis; 3]; 6] = [
        [Axis::X, Axis::Y, Axis::Z],
        [Axis::X, Axis::Z, Axis::Y],
        [Axis::Y, Axis::X, Axis::Z],
        [Axis::Y, Axis::Z, Axis::X],
        [Axis::Z, Axis::X, Axis::Y],
        [Axis::Z, Axis::Y, Axis::X],
    ];

    /// Capital letter, as in `EYX`.
    pub const fn letter(self) -> char {
        ['X', 'Y', 'Z'][self as usize]
    }

    /// Capital letters of several axes in their order, as in `XYZ`.
    pub fn letters(axes: &[Axis]) -> String {
        axes.iter().map(|axis| axis.letter()).collect()
    }

    /// Small letter, as in the error table and in job keys.
    pub const fn key(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    /// The axis of a letter of either case.
    pub fn from_letter(text: &str) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.key().eq_ignore_ascii_case(text))
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.letter())
    }
}

/// Direction of travel of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Direction {
    /// Towards larger coordinates.
    #[serde(rename = "+")]
    Plus,
    /// Towards smaller coordinates.
    #[serde(rename = "-")]
    Minus,
}

impl Direction {
    /// Both directions, + first.
    pub const BOTH: [Direction; 2] = [Direction::Plus, Direction::Minus];

    /// `+` or `-`, as in the error table.
    pub const fn symbol(self) -> &'static str {
        ["+", "-"][self as usize]
    }

    /// The direction of a symbol.
    pub fn from_symbol(text: &str) -> Option<Direction> {
        Direction::BOTH.into_iter().find(|direction| direction.symbol() == text)
    }

    /// The other direction.
    pub const fn opposite(self) -> Direction {
        match self {
            Direction::Plus => Direction::Minus,
            Direction::Minus => Direction::Plus,
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.symbol())
    }
}

/// One of the nine error terms: the deviation in direction `of` while axis `along` moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ErrorTerm {
    /// Direction of the deviation; the axis a control has to correct.
    pub of: Axis,
    /// The moving axis; the axis whose position is looked up.
    pub along: Axis,
}

impl ErrorTerm {
    /// The nine terms in the contract's order: EXX EYX EZX · EXY EYY EZY · EXZ EYZ EZZ.
    pub const ALL: [ErrorTerm; 9] = {
        let mut terms = [ErrorTerm { of: Axis::X, along: Axis::X }; 9];
        let mut index = 0;
        while index < 9 {
            terms[index] = ErrorTerm { of: Axis::ALL[index % 3], along: Axis::ALL[index / 3] };
            index += 1;
        }
        terms
    };

    /// The positioning error of an axis.
    pub const fn positioning(axis: Axis) -> ErrorTerm {
        ErrorTerm { of: axis, along: axis }
    }

    /// The other cross term of the same two axes.
    pub const fn twin(self) -> ErrorTerm {
        ErrorTerm { of: self.along, along: self.of }
    }

    /// Positioning (`EXX`, `EYY`, `EZZ`): an axis corrects itself.
    pub fn is_positioning(self) -> bool {
        self.of == self.along
    }

    /// Straightness (a cross term): one axis moves, another one is corrected.
    pub fn is_cross(self) -> bool {
        self.of != self.along
    }

    /// The term of a name such as `EYX`.
    pub fn from_name(name: &str) -> Option<ErrorTerm> {
        ErrorTerm::ALL.into_iter().find(|term| term.to_string() == name)
    }
}

impl fmt::Display for ErrorTerm {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(&format!("E{}{}", self.of, self.along))
    }
}

impl Serialize for ErrorTerm {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// One of the nine angular errors: the rotation about axis `about` while axis `along` moves,
/// right-handed (ISO 230-1: `EAX` = roll of X, A about X, B about Y, C about Z).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rotation {
    /// Axis of the rotation.
    pub about: Axis,
    /// The moving axis.
    pub along: Axis,
}

impl Rotation {
    /// The nine of them: EAX EBX ECX · EAY EBY ECY · EAZ EBZ ECZ.
    pub fn all() -> impl Iterator<Item = Rotation> {
        ErrorTerm::ALL.into_iter().map(|term| Rotation { about: term.of, along: term.along })
    }
}

impl fmt::Display for Rotation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = ['A', 'B', 'C'][self.about as usize];
        out.pad(&format!("E{letter}{}", self.along))
    }
}

/// One value for each axis.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct PerAxis<T> {
    /// Of the X axis.
    pub x: T,
    /// Of the Y axis.
    pub y: T,
    /// Of the Z axis.
    pub z: T,
}

/// A place or a vector: in documents `[x, y, z]`.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Xyz<T>(pub PerAxis<T>);

impl<T: Serialize> Serialize for Xyz<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let PerAxis { x, y, z } = &self.0;
        [x, y, z].serialize(to)
    }
}

impl<T> PerAxis<T> {
    /// The value of each axis from a function of the axis.
    #[inline]
    pub fn from_fn(mut of: impl FnMut(Axis) -> T) -> Self {
        PerAxis { x: of(Axis::X), y: of(Axis::Y), z: of(Axis::Z) }
    }

    /// Axis and value, in the order X, Y, Z.
    pub fn iter(&self) -> impl Iterator<Item = (Axis, &T)> {
        Axis::ALL.into_iter().map(|axis| (axis, &self[axis]))
    }
}

impl<T> Index<Axis> for PerAxis<T> {
    type Output = T;
    #[inline]
    fn index(&self, axis: Axis) -> &T {
        match axis {
            Axis::X => &self.x,
            Axis::Y => &self.y,
            Axis::Z => &self.z,
        }
    }
}

impl<T> IndexMut<Axis> for PerAxis<T> {
    fn index_mut(&mut self, axis: Axis) -> &mut T {
        match axis {
            Axis::X => &mut self.x,
            Axis::Y => &mut self.y,
            Axis::Z => &mut self.z,
        }
    }
}

impl<T: Copy> PerAxis<Option<T>> {
    /// The values of all axes, if there are three.
    pub fn all(&self) -> Option<PerAxis<T>> {
        let (x, y, z) = (self.x?, self.y?, self.z?);
        Some(PerAxis { x, y, z })
    }
}

impl<T> PerAxis<Vec<T>> {
    /// How many values each axis has.
    pub fn counts(&self) -> PerAxis<usize> {
        PerAxis::from_fn(|axis| self[axis].len())
    }
}

impl PerAxis<f64> {
    /// The vector product a × b (right-handed).
    ///
    /// ```
    /// use nonius_numerics::quantity::PerAxis;
    /// let (x, y) = (PerAxis { x: 1.0, y: 0.0, z: 0.0 }, PerAxis { x: 0.0, y: 1.0, z: 0.0 });
    /// assert_eq!(x.cross(y), PerAxis { x: 0.0, y: 0.0, z: 1.0 });
    /// ```
    #[must_use]
    #[inline]
    pub fn cross(self, other: PerAxis<f64>) -> PerAxis<f64> {
        PerAxis {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// The scalar product a · b.
    #[must_use]
    #[inline]
    pub fn dot(self, other: PerAxis<f64>) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Its length, √(a · a).
    #[must_use]
    #[inline]
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The sum of two vectors.
    #[must_use]
    #[inline]
    pub fn plus(self, other: PerAxis<f64>) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| self[axis] + other[axis])
    }

    /// The difference of two vectors.
    #[must_use]
    #[inline]
    pub fn minus(self, other: PerAxis<f64>) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| self[axis] - other[axis])
    }

    /// The vector times a number.
    #[must_use]
    #[inline]
    pub fn times(self, factor: f64) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| factor * self[axis])
    }
}

/// One value for each of the nine error terms.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct PerTerm<T>([[T; 3]; 3]);

impl<T> PerTerm<T> {
    /// The value of each term from a function of the term.
    pub fn from_fn(mut value: impl FnMut(ErrorTerm) -> T) -> Self {
        PerTerm(Axis::ALL.map(|along| Axis::ALL.map(|of| value(ErrorTerm { of, along }))))
    }

    /// Term and value, in the order of [`ErrorTerm::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (ErrorTerm, &T)> {
        ErrorTerm::ALL.into_iter().map(|term| (term, &self[term]))
    }
}

/// By the names of the terms.
impl<T: Serialize> Serialize for PerTerm<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.iter().map(|(term, value)| (term.to_string(), value)))
    }
}

impl<T> Index<ErrorTerm> for PerTerm<T> {
    type Output = T;
    fn index(&self, term: ErrorTerm) -> &T {
        &self.0[term.along as usize][term.of as usize]
    }
}

/// The nine rotations stand in the same 3 × 3 container: axis of rotation, moving axis.
impl<T> Index<Rotation> for PerTerm<T> {
    type Output = T;
    fn index(&self, rotation: Rotation) -> &T {
        &self.0[rotation.along as usize][rotation.about as usize]
    }
}

impl<T> IndexMut<Rotation> for PerTerm<T> {
    fn index_mut(&mut self, rotation: Rotation) -> &mut T {
        &mut self.0[rotation.along as usize][rotation.about as usize]
    }
}

impl<T> IndexMut<ErrorTerm> for PerTerm<T> {
    fn index_mut(&mut self, term: ErrorTerm) -> &mut T {
        &mut self.0[term.along as usize][term.of as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_stand_in_the_order_of_the_contract() {
        let names: Vec<String> = ErrorTerm::ALL.iter().map(ToString::to_string).collect();
        assert_eq!(
            names.join(" "),
            "EXX EYX EZX EXY EYY EZY EXZ EYZ EZZ",
            "direction first, moving axis second"
        );
    }

    #[test]
    fn eyx_is_y_while_x_moves() {
        let term = ErrorTerm::from_name("EYX").expect("a known name");
        assert_eq!((term.of, term.along), (Axis::Y, Axis::X));
        assert!(term.is_cross());
    }
}
