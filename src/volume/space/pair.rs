//! Two error vectors, their difference, and the largest one so far.

use super::grid_map::Vector;

/// Room for rounding of a comparison, in units of the largest numbers that went into it.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Square of the length of `p − q`, µm². **The only place where one is computed.**
#[inline(always)]
pub fn square(p: &Vector, q: &Vector) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y) + z * z
}

/// A vector with its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) at: Vector,
    pub(super) number: usize,
}

/// The largest difference and where it is: numbers of vectors, the smaller one first.
///
/// Of several pairs with the same square the one with the smallest numbers stands here; a map
/// that is constant has the pair (0, 0) and the length 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Longest {
    /// Square of the difference, µm².
    pub square_um2: f64,
    /// Numbers of the two vectors.
    pub pair: [usize; 2],
}

impl Longest {
    /// Length of the difference, µm.
    #[inline]
    pub fn um(&self) -> f64 {
        self.square_um2.sqrt()
    }

    /// A first guess: the vector `number` with itself.
    pub(super) fn none(number: usize) -> Longest {
        Longest {
            square_um2: 0.0,
            pair: [number; 2],
        }
    }

    /// Takes the pair where it is longer, or as long with smaller numbers. True where longer.
    #[inline]
    pub(super) fn offer(&mut self, p: &Point, q: &Point) -> bool {
        let square_um2 = square(&p.at, &q.at);
        if square_um2 < self.square_um2 {
            return false;
        }
        let longer = square_um2 > self.square_um2;
        let pair = [p.number.min(q.number), p.number.max(q.number)];
        if longer || pair < self.pair {
            *self = Longest { square_um2, pair };
        }
        longer
    }
}

/// What a bound may be wrong by, µm, where the largest magnitudes add up to `size_um`.
#[inline]
pub(super) fn room(size_um: f64) -> f64 {
    ROUNDING * size_um
}

/// Scalar product.
#[inline(always)]
pub(super) fn dot(d: &Vector, p: &Vector) -> f64 {
    (d[0] * p[0] + d[1] * p[1]) + d[2] * p[2]
}

/// The direction of a vector; `None` where it has no length.
#[inline]
pub(super) fn unit(v: Vector) -> Option<Vector> {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if largest <= 0.0 || !largest.is_finite() {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot(&v, &v).sqrt();
    Some(v.map(|c| c / length))
}
