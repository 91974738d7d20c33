//! The error vectors of a path that can be ends of the largest difference.
//!
//! A vector inside the hull of others is never an end of it, now or later: it is dropped. So
//! memory does not grow with a path, and the figure stays exact. Where too many vectors lie
//! outside the hull that is known, those nearest to it are dropped too, and the room that this
//! leaves is told.

use super::hull::{Hull, Vector};

/// Vectors that are kept before those inside the hull are dropped.
const MOST_VECTORS: usize = 1 << 20;
/// The hull grows until so small a part of them lies outside.
const PART_OUTSIDE: usize = 8;
/// At most so often; every time by the furthest vector of each facet.
const ROUNDS: usize = 8;

/// Error vectors of a path, of which it keeps those that matter.
#[derive(Clone, Debug)]
pub(super) struct Cloud {
    most: usize,
    vectors: Vec<Vector>,
    hull: Option<Hull>,
    /// A vector inside the hull, and the square of its distance from the hull's surface: whatever
    /// lies nearer to it is inside too.
    anchor: Vector,
    depth_square: f64,
    room_um: f64,
}

impl Cloud {
    pub(super) fn new() -> Cloud {
        Cloud::holding(MOST_VECTORS)
    }

    /// The same with another bound of its memory.
    pub(super) fn holding(most: usize) -> Cloud {
        Cloud {
            most,
            vectors: Vec::new(),
            hull: None,
            anchor: [0.0; 3],
            depth_square: -1.0,
            room_um: 0.0,
        }
    }

    #[inline]
    pub(super) fn take(&mut self, vector: Vector) {
        if self.hull.is_none() && self.vectors.len() < self.most {
            self.vectors.push(vector);
        } else if !self.is_near_anchor(&vector) {
            self.sift(vector);
        }
    }

    /// Whether it lies so near to a vector inside the hull that it is inside too.
    #[inline]
    fn is_near_anchor(&self, vector: &Vector) -> bool {
        let way = [0, 1, 2].map(|k| vector[k] - self.anchor[k]);
        way[0] * way[0] + way[1] * way[1] + way[2] * way[2] < self.depth_square
    }

    /// Keeps a vector only if it lies outside the hull.
    #[cold]
    fn sift(&mut self, vector: Vector) {
        if self.vectors.len() == self.most {
            self.refine();
        }
        let Some(hull) = &self.hull else { return };
        let depth = hull.depth(&vector);
        if depth > 0.0 {
            (self.anchor, self.depth_square) = (vector, depth * depth);
        } else if hull.beyond(&vector).0 > hull.start_um() {
            self.vectors.push(vector);
        }
    }

    /// A new hull of all that is kept; what lies inside is dropped, and half of the room is free.
    fn refine(&mut self) {
        self.vectors
            .extend(self.hull.iter().flat_map(Hull::corners));
        let Some(mut hull) = Hull::around(&self.vectors) else {
            return;
        };
        for _ in 0..ROUNDS {
            let furthest = self.drop_inside(&hull);
            if self.vectors.len() <= self.most / PART_OUTSIDE || !hull.grow(&furthest) {
                break;
            }
        }
        self.drop_nearest(&hull);
        self.hull = Some(hull);
    }

    /// Of more vectors than half of the room those nearest to the hull are dropped.
    fn drop_nearest(&mut self, hull: &Hull) {
        let Some(surplus) = self.vectors.len().checked_sub(self.most / 2 + 1) else {
            return;
        };
        let distances = self.vectors.iter().map(|vector| hull.distance(vector));
        let distances: Vec<f64> = distances.collect();
        let mut sorted = distances.clone();
        let bound = *sorted.select_nth_unstable_by(surplus, f64::total_cmp).1;
        let mut kept = distances.iter().map(|distance| *distance > bound);
        self.vectors.retain(|_| kept.next().unwrap_or(true));
        self.room_um += bound; // from what was kept until now
    }

    /// Drops the vectors inside, and gives the furthest of the others at each facet.
    fn drop_inside(&mut self, hull: &Hull) -> Vec<Vector> {
        let mut furthest: Vec<(f64, Vector)> = vec![(0.0, [0.0; 3]); hull.facets()];
        self.vectors.retain(|vector| {
            let (beyond, facet) = hull.beyond(vector);
            if beyond > furthest[facet].0 {
                furthest[facet] = (beyond, *vector);
            }
            beyond > hull.start_um()
        });
        furthest.retain(|(beyond, _)| *beyond > 0.0);
        furthest.sort_by(|a, b| b.0.total_cmp(&a.0));
        furthest.into_iter().map(|(_, vector)| vector).collect()
    }

    /// The vectors among which the ends of the largest difference are, and what that of all of
    /// them may be longer, µm (0 = it is theirs).
    pub(super) fn ends(self) -> (Vec<Vector>, f64) {
        let mut vectors = self.vectors;
        vectors.extend(self.hull.iter().flat_map(Hull::corners));
        (vectors, 2.0 * self.room_um)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use super::*;
    use crate::volume::space::cloud::longest;
    use proptest::prelude::*;

    fn diameter(vectors: &[Vector]) -> f64 {
        longest(vectors).expect("vectors").um()
    }

    fn bracket(vectors: &[Vector], most: usize) -> (f64, f64) {
        let mut cloud = Cloud::holding(most);
        vectors.iter().for_each(|vector| cloud.take(*vector));
        let (ends, room) = cloud.ends();
        let found = diameter(&ends);
        (found, found + room)
    }

    proptest! {
        /// Full, flat, straight and single clouds, with vectors that stand many times.
        #[test]
        fn the_longest_difference_stays(
            parts in proptest::collection::vec([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0], 1..1500),
            first in [-50.0..50.0_f64, -50.0..50.0, -50.0..50.0],
            sizes in [prop::sample::select(vec![0.0, 1e-9, 1.0, 50.0]), prop::sample::select(vec![0.0, 1.0]), prop::sample::select(vec![0.0, 1.0, 9.0])],
            turned in any::<bool>(),
            most in 40_usize..400,
        ) {
            let vectors: Vec<Vector> = parts.iter().map(|p| {
                let q = [0, 1, 2].map(|k| p[k] * sizes[k]);
                let q = if turned { [q[0] + 0.3 * q[1], q[1] - 0.7 * q[0], q[2] + 0.5 * q[0]] } else { q };
                [0, 1, 2].map(|k| first[k] + q[k])
            }).cycle().take(3 * parts.len()).collect();
            let (least, most) = bracket(&vectors, most);
            let exact = diameter(&vectors);
            prop_assert!(least <= exact + 1e-9 && exact <= most + 1e-5, "{least} … {most}: {exact}");
        }
    }

    /// A cloud that fills a box keeps few vectors and stays exact.
    #[test]
    fn a_full_cloud_is_exact_in_little_memory() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            f64::from(u32::try_from(state >> 33).expect("31 bits")) / f64::from(1_u32 << 31)
        };
        let vectors: Vec<Vector> = (0..200_000)
            .map(|_| [next() * 40.0, next() * 9.0, next()])
            .collect();
        let (least, most) = bracket(&vectors, 5_000);
        let exact = diameter(&vectors);
        assert!(
            (least - exact).abs() < 1e-6 && most - least < 1e-12,
            "{least} {most} {exact}"
        );
    }

    /// Every vector of a ball's surface matters: what is dropped is told.
    #[test]
    fn where_all_vectors_matter_a_bracket_is_told() {
        let vectors: Vec<Vector> = (0..20_000_u32)
            .map(|i| {
                let (z, turn) = (f64::from(i) / 10_000.0 - 1.0, f64::from(i) * 2.399_963);
                let r = (1.0 - z * z).max(0.0).sqrt();
                [10.0 * r * turn.cos(), 10.0 * r * turn.sin(), 10.0 * z]
            })
            .collect();
        let (least, most) = bracket(&vectors, 8_000);
        let exact = diameter(&vectors);
        assert!(
            least <= exact && exact <= most && most - least > 0.0 && most - least < 1.0,
            "{least} {most} {exact}"
        );
    }
}
