//! What the flat mirror of a step diagonal has to cover.
//!
//! The mirror stands across the diagonal and is carried along; a step of one axis carries it
//! sideways as well, so the beam meets it at another spot. In the mirror's plane the spots of a cell are
//! ```text
//!        · after the 2nd move          s(node) = d − (d·u)u,  d = node − start, u = the beam
//!       ╱ ╲
//!      ╱   ╲                           after the 1st move of axis k it is
//!     ·─────· after the 1st            step_k · √(1 − (V_k/R)²)
//!   cell ends
//! ```
//! Preload and overrun lie beside the cell ends by p − (p·u)u.

use crate::inputs::job::{ProgramRequest, RunType};
use crate::quantity::{Axis, Diagonal, PathKind, PerAxis, Squared, unit};

/// Size of the mirror that a step diagonal needs, without the diameter of the beam; the same for
/// all four diagonals, because their spots are mirror images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorSize {
    /// Farthest spot from that of the cell ends inside a cell: after the first and the second move, mm.
    pub excursion_mm: [f64; 2],
    /// Farthest spot from that of the cell ends, with preload and overrun, mm.
    pub farthest_mm: f64,
    /// Diameter of the smallest circle around all spots, mm.
    pub circle_mm: f64,
}

type Spot = [f64; 2];

pub(super) fn needed(request: &ProgramRequest) -> Option<MirrorSize> {
    if request.what != RunType::StepDiagonal {
        return None;
    }
    let volume = &request.volume;
    let start = volume.inside_mm(Diagonal::Ppp, PathKind::Step, 0);
    let from_start =
        |node: usize| volume.inside_mm(Diagonal::Ppp, PathKind::Step, node).minus(start);
    let beyond = |mm: f64| PerAxis { x: mm, y: mm, z: mm }; // PPP goes ahead on every axis
    let plane = Plane::across(volume.laser(Diagonal::Ppp));
    let spots = [
        plane.spot(from_start(0)),
        plane.spot(from_start(1)),
        plane.spot(from_start(2)),
        plane.spot(beyond(-request.preload.mm())),
        plane.spot(beyond(overrun_mm(request))),
    ];
    let distances = spots.map(|spot| distance(spot, spots[0]));
    Some(MirrorSize {
        excursion_mm: [distances[1], distances[2]],
        farthest_mm: distances.into_iter().fold(0.0, f64::max),
        circle_mm: smallest_circle_mm(&spots),
    })
}

/// How far past the end point: only a run in both directions goes there.
pub(super) fn overrun_mm(request: &ProgramRequest) -> f64 {
    if request.bidirectional { request.overrun.mm() } else { 0.0 }
}

/// Two directions across the beam.
struct Plane {
    across: [PerAxis<f64>; 2],
}

impl Plane {
    fn across(beam: PerAxis<f64>) -> Plane {
        // Any direction that is not the beam's; that of its smallest component is safest.
        let smallest = Axis::ALL
            .into_iter()
            .min_by(|a, b| beam[*a].abs().total_cmp(&beam[*b].abs()))
            .unwrap_or(Axis::X);
        let first = beam.cross(unit(smallest));
        let length = first.length();
        let first = PerAxis::from_fn(|axis| first[axis] / length);
        Plane { across: [first, beam.cross(first)] }
    }

    fn spot(&self, place: PerAxis<f64>) -> Spot {
        self.across.map(|across| across.dot(place))
    }
}

fn distance(a: Spot, b: Spot) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The smallest circle around a few spots is that of two of them or of three of them.
fn smallest_circle_mm(spots: &[Spot]) -> f64 {
    let mut circles = Vec::new();
    for (i, a) in spots.iter().enumerate() {
        for (j, b) in spots.iter().enumerate().take(i) {
            circles.push(([(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0], distance(*a, *b) / 2.0));
            circles.extend(spots.iter().take(j).filter_map(|c| around(*a, *b, *c)));
        }
    }
    let holds_all = |(centre, radius): &(Spot, f64)| {
        let slack = 1e-9 * (1.0 + radius);
        spots.iter().all(|spot| distance(*spot, *centre) <= radius + slack)
    };
    let radii = circles.into_iter().filter(holds_all).map(|(_, radius)| radius);
    2.0 * radii.reduce(f64::min).unwrap_or(0.0)
}

/// The circle through three spots, if they are not in line.
fn around(a: Spot, b: Spot, c: Spot) -> Option<(Spot, f64)> {
    let (b, c) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let twice = 2.0 * (b[0] * c[1] - b[1] * c[0]);
    let (bb, cc) = (b[0].squared() + b[1].squared(), c[0].squared() + c[1].squared());
    if twice.abs() <= 1e-12 * (bb + cc) {
        return None;
    }
    let centre = [(c[1] * bb - b[1] * cc) / twice, (b[0] * cc - c[0] * bb) / twice];
    let radius = centre[0].hypot(centre[1]);
    Some(([centre[0] + a[0], centre[1] + a[1]], radius))
}
