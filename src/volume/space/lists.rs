//! The longest difference between two lists of candidates, by cutting directions and lists at once.

use super::direction_cell::DirectionCell;
use super::grid_map::Vector;
use super::pair::{Longest, Point, dot};

/// Lists this short in product are compared pair by pair.
const COMPARED: usize = 1024;

/// Candidates for the two ends of a difference whose direction lies in a cell.
pub(super) struct Ends {
    pub(super) top: Vec<Point>,
    pub(super) bottom: Vec<Point>,
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
    fn along(&self, d: &Vector, point: &Point) -> f64 {
        let [x, y, z] = self.middle;
        dot(d, &[point.at[0] - x, point.at[1] - y, point.at[2] - z])
    }

    /// The point furthest along `d`, and how far. The list is not empty.
    fn furthest(&self, points: &[Point], d: &Vector) -> (f64, Point) {
        let mut best = (self.along(d, &points[0]), points[0]);
        for point in &points[1..] {
            let along = self.along(d, point);
            if along > best.0 {
                best = (along, *point);
            }
        }
        best
    }

    fn kept(&self, points: &[Point], d: &Vector, least: f64) -> Vec<Point> {
        let near = |point: &&Point| self.along(d, point) >= least;
        points.iter().filter(near).copied().collect()
    }
}

/// Keeps of equal vectors the one with the smallest number.
fn without_equals(points: &mut Vec<Point>) {
    let bits = |point: &Point| point.at.map(|c| (c + 0.0).to_bits());
    points.sort_unstable_by_key(|point| (bits(point), point.number));
    points.dedup_by_key(|point| bits(point));
}

fn compare(ends: &Ends, longest: &mut Longest) {
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
