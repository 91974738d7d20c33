//! The longest difference in a cloud of vectors without a grid: tool paths, measured maps.

use super::grid_map::Vector;
use super::pair::{DirectionCell, Ends, Frame, Longest, Point, room, search, square};

/// Vectors looked at together when the furthest one is sought.
const BLOCK: usize = 256;

/// Steps from one vector to the one furthest from it, before the directions are cut.
const STEPS: usize = 8;

/// The longest difference of two vectors, exact; `None` where there is no vector, or one is not
/// finite.
///
/// Vectors that cannot be an end are left out first: with the middle m and the radius R of the
/// cloud, no difference from p is longer than |p − m| + R.
pub fn longest(vectors: &[Vector]) -> Option<Longest> {
    let (low, high) = bounds(vectors)?;
    let room = room((0..3).map(|c| high[c] - low[c]).sum());
    let mut longest = Longest::none(0);
    walk(vectors, &mut longest);
    let middle = [0, 1, 2].map(|c| low[c] + (high[c] - low[c]) / 2.0);
    let radius = square(&vectors[furthest(vectors, &middle)], &middle).sqrt();
    let least = longest.um() - radius - room;
    let ends = ends(vectors, &middle, least);
    for cell in DirectionCell::half_sphere() {
        search(cell, &ends, Frame { middle, room }, &mut longest);
    }
    Some(longest)
}

/// Smallest and largest components.
pub(super) fn bounds(vectors: &[Vector]) -> Option<(Vector, Vector)> {
    let first = *vectors.first()?;
    let (mut low, mut high) = (first, first);
    let mut sum = 0.0;
    for vector in vectors {
        for c in 0..3 {
            low[c] = if vector[c] < low[c] { vector[c] } else { low[c] };
            high[c] = if vector[c] > high[c] { vector[c] } else { high[c] };
            sum += vector[c] * 0.0;
        }
    }
    sum.is_finite().then_some((low, high))
}

/// The place of the vector furthest from `from`, the first of several.
fn furthest(vectors: &[Vector], from: &Vector) -> usize {
    let mut best = (-1.0, 0);
    for (block, list) in vectors.chunks(BLOCK).enumerate() {
        let mut squares = [-1.0; BLOCK];
        for (value, vector) in squares.iter_mut().zip(list) {
            *value = square(vector, from);
        }
        let largest = squares.iter().fold(best.0, |m, s| if *s > m { *s } else { m });
        if largest > best.0 {
            let place = squares.iter().position(|s| *s >= largest).unwrap_or(0);
            best = (largest, block * BLOCK + place);
        }
    }
    best.1
}

/// From a vector to the one furthest from it, and so on while the step grows.
fn walk(vectors: &[Vector], longest: &mut Longest) {
    let point = |number: usize| Point { at: vectors[number], number };
    let mut from = 0;
    for _ in 0..STEPS {
        let to = furthest(vectors, &vectors[from]);
        if !longest.offer(&point(from), &point(to)) {
            break;
        }
        from = to;
    }
}

fn ends(vectors: &[Vector], middle: &Vector, least: f64) -> Ends {
    let least = if least > 0.0 { least * least * (1.0 - 1e-12) } else { 0.0 };
    let vectors = vectors.iter().enumerate();
    let far = vectors.filter(|(_, vector)| square(vector, middle) >= least);
    let top: Vec<Point> = far.map(|(number, at)| Point { at: *at, number }).collect();
    Ends { bottom: top.clone(), top }
}
