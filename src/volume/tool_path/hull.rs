//! The convex hull of chosen vectors, from inside: whatever lies behind all its facets is a mean
//! of them.
//!
//! ```text
//!   six vectors close around the middle ─→ + furthest vector outside ─→ + … (facets that see it
//!   give way to new ones through it)
//! ```
//! The surface stays closed by construction, so a vector behind the planes of all facets lies
//! between the middle and the surface, whatever rounding does to the facets.

/// An error vector, µm.
pub(super) type Vector = [f64; 3];

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

/// A closed surface of triangles around a middle.
#[derive(Clone, Debug)]
pub(super) struct Hull {
    middle: Vector,
    /// Less the middle; the first six are none of the vectors.
    corners: Vec<Vector>,
    facets: Vec<Facet>,
    start_um: f64,
}

impl Hull {
    /// A small one around the mean of vectors; `None` where there are none.
    #[allow(clippy::cast_precision_loss, reason = "a mean needs no last digit")]
    pub(super) fn around(vectors: &[Vector]) -> Option<Hull> {
        let count = vectors.len() as f64;
        let mean = |k: usize| vectors.iter().map(|vector| vector[k]).sum::<f64>() / count;
        let middle = [mean(0), mean(1), mean(2)];
        let squares = vectors.iter().map(|vector| minus(*vector, middle));
        let size = squares.map(|v| dot(v, v)).fold(1.0, f64::max).sqrt();
        if vectors.is_empty() || !size.is_finite() {
            return None;
        }
        let start_um = size * START;
        let corner = |number: usize| -> Vector {
            let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
            std::array::from_fn(|k| {
                if k == number / 2 {
                    sign * start_um
                } else {
                    0.0
                }
            })
        };
        let mut hull = Hull {
            middle,
            corners: (0..6).map(corner).collect(),
            facets: Vec::new(),
            start_um,
        };
        for (x, y, z) in [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)] {
            let (above, below) = (hull.facet([x, y, z])?, hull.facet([y, x, z + 1])?);
            hull.facets.extend([above, below]);
        }
        Some(hull)
    }

    /// The vectors at its corners, and the middle: within [`Hull::start_um`] all that lies inside
    /// is a mean of them.
    pub(super) fn corners(&self) -> impl Iterator<Item = Vector> + '_ {
        let corners = self.corners.iter().skip(6).copied();
        let corners = corners.chain([[0.0; 3]]);
        corners.map(|corner| [0, 1, 2].map(|k| corner[k] + self.middle[k]))
    }

    pub(super) fn facets(&self) -> usize {
        self.facets.len()
    }

    /// What the hull may reach further out than its vectors, µm.
    pub(super) fn start_um(&self) -> f64 {
        self.start_um
    }

    /// How deep a vector lies below the surface, µm; 0 or less: it does not.
    pub(super) fn depth(&self, vector: &Vector) -> f64 {
        let way = minus(*vector, self.middle);
        let depths = self.facets.iter();
        let depths = depths.map(|facet| facet.distance * (1.0 - dot(facet.scaled, way)));
        depths.fold(f64::INFINITY, |a, b| if b < a { b } else { a })
    }

    /// How far a vector lies behind the point where the way to it from the middle leaves the hull,
    /// µm, and the facet there. Its distance from the hull is not larger.
    pub(super) fn beyond(&self, vector: &Vector) -> (f64, usize) {
        let way = minus(*vector, self.middle);
        let mut found = (0.0, 0);
        for (number, facet) in self.facets.iter().enumerate() {
            let times = dot(facet.scaled, way);
            if times > found.0 {
                found = (times, number);
            }
        }
        let (times, facet) = found;
        let part = if times > 1.0 { 1.0 - 1.0 / times } else { 0.0 };
        (dot(way, way).sqrt() * part, facet)
    }

    /// At most so far is a vector from the hull, µm.
    pub(super) fn distance(&self, vector: &Vector) -> f64 {
        let ways = self.corners().map(|corner| minus(*vector, corner));
        let nearest = ways.map(|way| dot(way, way)).fold(f64::INFINITY, f64::min);
        self.beyond(vector).0.min(nearest.sqrt())
    }

    /// Takes vectors as corners; whether there is a new one.
    pub(super) fn grow(&mut self, vectors: &[Vector]) -> bool {
        let before = self.corners.len();
        for vector in vectors {
            if self.facets.len() < MOST_FACETS {
                self.insert(minus(*vector, self.middle));
            }
        }
        self.corners.len() > before
    }

    fn insert(&mut self, corner: Vector) {
        let sees = |facet: &Facet| dot(facet.scaled, corner) > 1.0;
        let seen: Vec<Facet> = self
            .facets
            .iter()
            .filter(|facet| sees(facet))
            .copied()
            .collect();
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
        let across = cross(minus(b, a), minus(c, a));
        let size = dot(across, across).sqrt();
        let normal = across.map(|part| part / size);
        let distance = dot(normal, a).min(dot(normal, b)).min(dot(normal, c));
        (distance > self.start_um / 4.0).then(|| Facet {
            corners,
            scaled: normal.map(|part| part / distance),
            distance,
        })
    }
}

fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
