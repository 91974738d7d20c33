//! Two error vectors, their difference, and the largest one so far.
//!
//! Cells of directions: a half sphere, cut finer only where a longest difference may point.
//!
//! For a unit direction d let w(d) be the extent of the error vectors along d. A difference of
//! length L within the angle θ of d has w(d) ≥ L·cos θ, so a cell of directions with
//! w(d) < D·cos θ holds no difference as long as D.
//! The longest difference between two lists of candidates is found by cutting directions and lists at once.

use super::grid_map::Vector;

/// Room for rounding of a comparison, in units of the largest numbers that went into it.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Square of the length of `p − q`, µm². **The only place where one is computed.**
#[inline(always)]
pub fn square(p: &Vector, q: &Vector) -> f64 {
    let [x, y, z] = minus(p, q);
    (x * x + y * y) + z * z
}

/// A vector with its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NumberedVector {
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
        Longest { square_um2: 0.0, pair: [number; 2] }
    }

    /// Takes the pair where it is longer, or as long with smaller numbers. True where longer.
    #[inline]
    pub(super) fn offer(&mut self, p: &NumberedVector, q: &NumberedVector) -> bool {
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

/// The difference p − q.
#[inline(always)]
pub fn minus(p: &Vector, q: &Vector) -> Vector {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// Vector product, right-handed.
#[inline(always)]
pub fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Scalar product.
#[inline(always)]
pub fn dot(d: &Vector, p: &Vector) -> f64 {
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

/// A square on a face of the cube −1…1 and the directions through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionCell {
    /// Axis of the face.
    face: usize,
    /// Centre on the face.
    centre: [f64; 2],
    /// Half the side.
    half: f64,
}

impl DirectionCell {
    /// Twelve cells that hold every direction or its opposite.
    pub(super) fn half_sphere() -> impl Iterator<Item = DirectionCell> {
        let faces = (0..3).map(|face| DirectionCell { face, centre: [0.0; 2], half: 1.0 });
        faces.flat_map(|face| face.quarters())
    }

    /// The cell cut in four.
    pub(super) fn quarters(self) -> [DirectionCell; 4] {
        let half = self.half / 2.0;
        self.around(half).map(|centre| DirectionCell { centre, half, ..self })
    }

    /// Four places so far from the centre in both directions of the face.
    fn around(self, away: f64) -> [[f64; 2]; 4] {
        let [u, v] = self.centre;
        [(-away, -away), (-away, away), (away, -away), (away, away)].map(|(x, y)| [u + x, v + y])
    }

    /// True where a bound for `length` gains less than `room` from cutting the cell.
    pub(super) fn is_fine(self, length: f64, room: f64) -> bool {
        length * (1.0 - self.cosine()) <= room
    }

    fn through(self, u: f64, v: f64) -> Vector {
        let mut direction = [0.0; 3];
        direction[self.face] = 1.0;
        direction[(self.face + 1) % 3] = u;
        direction[(self.face + 2) % 3] = v;
        unit(direction).unwrap_or(direction)
    }

    /// Direction of the centre.
    pub(super) fn direction(self) -> Vector {
        self.through(self.centre[0], self.centre[1])
    }

    /// Cosine of the largest angle between the centre and a direction of the cell: a corner's.
    pub(super) fn cosine(self) -> f64 {
        let centre = self.direction();
        let corners = self.around(self.half).map(|[u, v]| dot(&centre, &self.through(u, v)));
        corners.into_iter().fold(1.0, f64::min)
    }
}

/// Lists this short in product are compared pair by pair.
const COMPARED: usize = 1024;

/// Candidates for the two ends of a difference whose direction lies in a cell.
pub(super) struct Ends {
    pub(super) top: Vec<NumberedVector>,
    pub(super) bottom: Vec<NumberedVector>,
}

/// Where lengths along a direction are counted from, and what they may be wrong by.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// A vector amid the others: differences from it are rounded relative to their own size.
    pub(super) middle: Vector,
    /// Room for rounding, µm.
    pub(super) room: f64,
}

impl Frame {
    #[inline(always)]
    fn along(&self, d: &Vector, point: &NumberedVector) -> f64 {
        dot(d, &minus(&point.at, &self.middle))
    }

    /// The point furthest along `d`, and how far. The list is not empty.
    fn furthest(&self, points: &[NumberedVector], d: &Vector) -> (f64, NumberedVector) {
        let mut best = (self.along(d, &points[0]), points[0]);
        for point in &points[1..] {
            let along = self.along(d, point);
            if along > best.0 {
                best = (along, *point);
            }
        }
        best
    }

    fn kept(&self, points: &[NumberedVector], d: &Vector, least: f64) -> Vec<NumberedVector> {
        let near = |point: &&NumberedVector| self.along(d, point) >= least;
        points.iter().filter(near).copied().collect()
    }
}

/// Keeps of equal vectors the one with the smallest number.
fn without_equals(points: &mut Vec<NumberedVector>) {
    let bits = |point: &NumberedVector| point.at.map(|c| (c + 0.0).to_bits());
    points.sort_unstable_by_key(|point| (bits(point), point.number));
    points.dedup_by_key(|point| bits(point));
}

/// Compares every vector of one list with every one of the other.
pub(super) fn compare(ends: &Ends, longest: &mut Longest) {
    for p in &ends.top {
        for q in &ends.bottom {
            longest.offer(p, q);
        }
    }
}

/// Finds every difference between the lists with a direction in `cell` that is as long as the
/// longest one so far.
pub(super) fn search(cell: DirectionCell, ends: &Ends, frame: Frame, longest: &mut Longest) {
    if ends.top.is_empty() || ends.bottom.is_empty() {
        return;
    }
    let d = cell.direction();
    let opposite = d.map(|c| -c);
    let (high, top) = frame.furthest(&ends.top, &d);
    let (depth, bottom) = frame.furthest(&ends.bottom, &opposite);
    longest.offer(&top, &bottom);
    let needed = longest.um() * cell.cosine() - frame.room;
    if high + depth < needed {
        return;
    }
    let mut ends = Ends {
        top: frame.kept(&ends.top, &d, needed - depth),
        bottom: frame.kept(&ends.bottom, &opposite, needed - high),
    };
    let many = |ends: &Ends| ends.top.len() * ends.bottom.len() > COMPARED;
    if many(&ends) {
        without_equals(&mut ends.top);
        without_equals(&mut ends.bottom);
    }
    if !many(&ends) || cell.is_fine(longest.um(), frame.room) {
        compare(&ends, longest);
    } else {
        for quarter in cell.quarters() {
            search(quarter, &ends, frame, longest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_is_within_the_angle_of_a_cell_or_its_opposite_is() {
        for n in 0..2000 {
            let turn = f64::from(n) * 2.399_963;
            let z = 1.0 - (f64::from(n) + 0.5) / 1000.0;
            let r = (1.0 - z * z).sqrt();
            let d = [r * turn.cos(), r * turn.sin(), z];
            let within =
                |cell: DirectionCell| dot(&d, &cell.direction()).abs() >= cell.cosine() - 1e-12;
            let cell = DirectionCell::half_sphere().find(|cell| within(*cell));
            let cell = cell.expect("a cell");
            assert!(cell.cosine() > 0.8);
            assert!(DirectionCell::half_sphere().flat_map(DirectionCell::quarters).any(within));
        }
    }
}
