//! The error vectors of a path that can be ends of the largest difference.
//!
//! A vector inside the hull of others is never an end of it, now or later: it is dropped. So
//! memory does not grow with a path, and the figure stays exact. Where too many vectors lie
//! outside the hull that is known, those nearest to it are dropped too, and the room that this
//! leaves is told.

use crate::volume::space::grid_map::Vector;
use crate::volume::space::pair::{cross, dot, minus, square};

/// Vectors that are kept before those inside the hull are dropped.
pub(super) const MOST_VECTORS: usize = 1 << 20;
/// The hull grows until so small a part of them lies outside.
const PART_OUTSIDE: usize = 8;
/// At most so often; every time by the furthest vector of each facet.
const ROUNDS: usize = 8;

/// Error vectors of a path, of which it keeps those that matter.
#[derive(Clone, Debug, Default)]
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
    /// With a bound of its memory.
    pub(super) fn holding(most: usize) -> Cloud {
        Cloud { most, depth_square: -1.0, ..Cloud::default() }
    }

    #[inline]
    pub(super) fn take(&mut self, vector: Vector) {
        if self.hull.is_none() && self.vectors.len() < self.most {
            self.vectors.push(vector);
        } else if square(&vector, &self.anchor) >= self.depth_square {
            // not so near to a vector inside the hull that it is inside too
            self.sift(vector);
        }
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
        } else if hull.beyond(&vector).0 > hull.start_um {
            self.vectors.push(vector);
        }
    }

    /// A new hull of all that is kept; what lies inside is dropped, and half of the room is free.
    fn refine(&mut self) {
        self.vectors.extend(self.hull.iter().flat_map(Hull::corners));
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
        let distances: Vec<f64> = self.vectors.iter().map(|vector| hull.distance(vector)).collect();
        let mut sorted = distances.clone();
        let bound = *sorted.select_nth_unstable_by(surplus, f64::total_cmp).1;
        let mut kept = distances.iter().map(|distance| *distance > bound);
        self.vectors.retain(|_| kept.next().unwrap_or(true));
        self.room_um += bound; // from what was kept until now
    }

    /// Drops the vectors inside, and gives the furthest of the others at each facet.
    fn drop_inside(&mut self, hull: &Hull) -> Vec<Vector> {
        let mut furthest: Vec<(f64, Vector)> = vec![(0.0, [0.0; 3]); hull.facets.len()];
        self.vectors.retain(|vector| {
            let (beyond, facet) = hull.beyond(vector);
            if beyond > furthest[facet].0 {
                furthest[facet] = (beyond, *vector);
            }
            beyond > hull.start_um
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

/// How far the six first corners are from the middle, as a part of the size of the cloud: vectors
/// in a plane or on a line have a hull with an inside too. The square root of what rounding leaves
/// of a number: a smaller part is lost in it, a larger one lets the hull reach further out.
const START: f64 = 1e-8;
/// Each costs a product for every vector.
const MOST_FACETS: usize = 500;

#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [usize; 3],
    /// Outwards; its product with a way from the middle is 1 where the way meets the plane.
    scaled: Vector,
    /// Of its plane from the middle, µm.
    distance: f64,
}

/// The convex hull of chosen vectors, from inside: a closed surface of triangles around a middle.
/// Whatever lies behind all its facets is a mean of them.
///
/// ```text
///   six vectors close around the middle ─→ + furthest vector outside ─→ + … (facets that see it
///   give way to new ones through it)
/// ```
/// The surface stays closed by construction, so a vector behind the planes of all facets lies
/// between the middle and the surface, whatever rounding does to the facets.
#[derive(Clone, Debug)]
struct Hull {
    middle: Vector,
    /// Less the middle; the first six are none of the vectors.
    corners: Vec<Vector>,
    facets: Vec<Facet>,
    start_um: f64,
}

impl Hull {
    /// A small one around the mean of vectors; `None` where there are none.
    fn around(vectors: &[Vector]) -> Option<Hull> {
        let count = vectors.len() as f64;
        let mean = |k: usize| vectors.iter().map(|vector| vector[k]).sum::<f64>() / count;
        let middle = [mean(0), mean(1), mean(2)];
        let squares = vectors.iter().map(|vector| minus(vector, &middle));
        let size = squares.map(|v| dot(&v, &v)).fold(1.0, f64::max).sqrt();
        if vectors.is_empty() || !size.is_finite() {
            return None;
        }
        let start_um = size * START;
        let corner = |number: usize| -> Vector {
            let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
            std::array::from_fn(|k| if k == number / 2 { sign * start_um } else { 0.0 })
        };
        let mut hull =
            Hull { middle, corners: (0..6).map(corner).collect(), facets: Vec::new(), start_um };
        for (x, y, z) in [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)] {
            let (above, below) = (hull.facet([x, y, z])?, hull.facet([y, x, z + 1])?);
            hull.facets.extend([above, below]);
        }
        Some(hull)
    }

    /// The vectors at its corners, and the middle: within `start_um` all that lies inside
    /// is a mean of them.
    fn corners(&self) -> impl Iterator<Item = Vector> + '_ {
        let corners = self.corners.iter().skip(6).copied().chain([[0.0; 3]]);
        corners.map(|corner| [0, 1, 2].map(|k| corner[k] + self.middle[k]))
    }

    /// How deep a vector lies below the surface, µm; 0 or less: it does not.
    fn depth(&self, vector: &Vector) -> f64 {
        let way = minus(vector, &self.middle);
        let depths = self.facets.iter();
        let depths = depths.map(|facet| facet.distance * (1.0 - dot(&facet.scaled, &way)));
        depths.fold(f64::INFINITY, |a, b| if b < a { b } else { a })
    }

    /// How far a vector lies behind the point where the way to it from the middle leaves the hull,
    /// µm, and the facet there. Its distance from the hull is not larger.
    fn beyond(&self, vector: &Vector) -> (f64, usize) {
        let way = minus(vector, &self.middle);
        let mut found = (0.0, 0);
        for (number, facet) in self.facets.iter().enumerate() {
            let times = dot(&facet.scaled, &way);
            if times > found.0 {
                found = (times, number);
            }
        }
        let (times, facet) = found;
        let part = if times > 1.0 { 1.0 - 1.0 / times } else { 0.0 };
        (dot(&way, &way).sqrt() * part, facet)
    }

    /// At most so far is a vector from the hull, µm.
    fn distance(&self, vector: &Vector) -> f64 {
        let ways = self.corners().map(|corner| minus(vector, &corner));
        let nearest = ways.map(|way| dot(&way, &way)).fold(f64::INFINITY, f64::min);
        self.beyond(vector).0.min(nearest.sqrt())
    }

    /// Takes vectors as corners; whether there is a new one.
    fn grow(&mut self, vectors: &[Vector]) -> bool {
        let before = self.corners.len();
        for vector in vectors {
            if self.facets.len() < MOST_FACETS {
                self.insert(minus(vector, &self.middle));
            }
        }
        self.corners.len() > before
    }

    fn insert(&mut self, corner: Vector) {
        let sees = |facet: &Facet| dot(&facet.scaled, &corner) > 1.0;
        let seen: Vec<Facet> = self.facets.iter().filter(|facet| sees(facet)).copied().collect();
        let edges: Vec<(usize, usize)> =
            seen.iter().flat_map(|facet| edges(facet.corners)).collect();
        let outline = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a)));
        let number = self.corners.len();
        self.corners.push(corner);
        let new: Option<Vec<Facet>> = outline.map(|(a, b)| self.facet([*a, *b, number])).collect();
        match new {
            Some(new) if !new.is_empty() => {
                self.facets.retain(|facet| !sees(facet));
                self.facets.extend(new);
            }
            _ => _ = self.corners.pop(),
        }
    }

    /// A facet; `None` where rounding leaves it no plane, or brings that nearer to the middle than
    /// the first facets, which all others lie around, are (0.58 of the start).
    fn facet(&self, corners: [usize; 3]) -> Option<Facet> {
        let [a, b, c] = corners.map(|number| self.corners[number]);
        let across = cross(&minus(&b, &a), &minus(&c, &a));
        let size = dot(&across, &across).sqrt();
        let normal = across.map(|part| part / size);
        let distance = dot(&normal, &a).min(dot(&normal, &b)).min(dot(&normal, &c));
        let scaled = normal.map(|part| part / distance);
        (distance > self.start_um / 4.0).then_some(Facet { corners, scaled, distance })
    }
}

fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::space::diameter::longest;
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
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from(u32::try_from(state >> 33).expect("31 bits")) / f64::from(1_u32 << 31)
        };
        let vectors: Vec<Vector> =
            (0..200_000).map(|_| [next() * 40.0, next() * 9.0, next()]).collect();
        let (least, most) = bracket(&vectors, 5_000);
        let exact = diameter(&vectors);
        assert!((least - exact).abs() < 1e-6 && most - least < 1e-12, "{least} {most} {exact}");
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
