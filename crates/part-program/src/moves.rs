//! Moves of the tool, and the circles of G2 and G3.

use std::f64::consts::TAU;

/// A place in machine coordinates, mm: X, Y, Z.
pub type Place = [f64; 3];

/// G17, G18, G19: the two axes of the plane in the order of positive rotation, and the third one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17.
    #[default]
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Numbers of the first, the second and the third axis.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// Part of a circle in a plane, with a straight motion of the third axis (helix).
///
/// The radius runs evenly from the distance of the start to that of the end, which differ by what
/// the program rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Centre along the first and the second axis of the plane, mm.
    pub centre: [f64; 2],
    /// Angle of the start from the first axis towards the second, rad.
    pub from_rad: f64,
    /// Angle swept, rad; positive from the first axis towards the second (G3).
    pub sweep_rad: f64,
    /// Radius at start and end, mm.
    pub radius: [f64; 2],
}

/// How a move goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Straight.
    Line,
    /// Along a circle or a helix.
    Arc(Arc),
}

/// One move of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Where it begins.
    pub from: Place,
    /// Where it ends.
    pub to: Place,
    /// How it goes.
    pub shape: Shape,
    /// G0, and positioning moves of cycles and of G28.
    pub rapid: bool,
    /// The plane that is selected.
    pub plane: Plane,
    /// Length of the tool while G43 is active, mm.
    pub tool_mm: Option<f64>,
    /// Line of the program, from 1.
    pub line: usize,
    /// Number of the hole, from 1, at whose bottom the move ends.
    pub hole: Option<u64>,
}

impl Move {
    /// The place at a part of the move, 0 … 1.
    pub fn at(&self, part: f64) -> Place {
        let (from, to) = (self.from, self.to);
        let between = |k: usize| from[k] + (to[k] - from[k]) * part;
        let mut place = std::array::from_fn(|k| if part >= 1.0 { to[k] } else { between(k) });
        if let Shape::Arc(arc) = self.shape {
            let [first, second, _] = self.plane.axes();
            let angle = arc.from_rad + arc.sweep_rad * part;
            let radius = arc.radius[0] + (arc.radius[1] - arc.radius[0]) * part;
            place[first] = arc.centre[0] + radius * angle.cos();
            place[second] = arc.centre[1] + radius * angle.sin();
        }
        place
    }

    /// Length, mm (of an arc with its mean radius).
    pub fn length_mm(&self) -> f64 {
        let along = |k: usize| self.to[k] - self.from[k];
        match self.shape {
            Shape::Line => (0..3).map(|k| along(k) * along(k)).sum::<f64>().sqrt(),
            Shape::Arc(arc) => {
                let around = arc.sweep_rad * f64::midpoint(arc.radius[0], arc.radius[1]);
                around.hypot(along(self.plane.axes()[2]))
            }
        }
    }
}

/// How far the end of an arc misses the circle in programs that are right, mm: where `u` is the last
/// decimal, start, end and centre are rounded by u/2 along both axes, so the two radii differ by up to
/// 2·√2·u, 0.003 mm with three decimals.
pub(super) const USUAL_MISS_MM: f64 = 0.01;
/// The same with three decimals of an inch: 2·√2·0.0254 mm.
pub(super) const INCH_MISS_MM: f64 = 0.072;
/// No control has a larger radius.
const LARGEST_RADIUS_MM: f64 = 1e7;
/// Below this the radius is no circle, mm.
const SMALLEST_RADIUS_MM: f64 = 1e-6;
/// Start and end that lie no further apart along the circle are in the same direction from the
/// centre, mm: a thousandth of what a program can say.
const SAME_DIRECTION_MM: f64 = 1e-6;

/// What a block says of an arc beside its centre.
#[derive(Clone, Copy)]
pub(crate) struct Turn {
    pub(crate) plane: Plane,
    pub(crate) clockwise: bool,
    pub(crate) from: Place,
    pub(crate) to: Place,
    pub(crate) tolerance_mm: f64,
}

impl Turn {
    /// The arc around a centre; a full circle where the end lies in the direction of the start. What is
    /// wrong comes back in words.
    pub(crate) fn around(self, centre: [f64; 2]) -> Result<Arc, String> {
        let [first, second, _] = self.plane.axes();
        let [start, end] =
            [self.from, self.to].map(|at| [at[first] - centre[0], at[second] - centre[1]]);
        let radius = [start[0].hypot(start[1]), end[0].hypot(end[1])];
        if radius[0] < SMALLEST_RADIUS_MM || radius[0] > LARGEST_RADIUS_MM {
            return Err(format!("the arc has a radius of {:.6} mm", radius[0]));
        }
        if (radius[1] - radius[0]).abs() > self.tolerance_mm {
            return Err(format!(
                "the end of the arc lies {:.4} mm from the centre, its start {:.4} mm; expected the same within {} mm (`arc_mm` in [path])",
                radius[1], radius[0], self.tolerance_mm
            ));
        }
        let from_rad = start[1].atan2(start[0]);
        let forward = (end[1].atan2(end[0]) - from_rad).rem_euclid(TAU);
        let closed = forward.min(TAU - forward) * radius[0] < SAME_DIRECTION_MM;
        let sweep_rad = match (closed, self.clockwise) {
            (true, true) => -TAU,
            (true, false) => TAU,
            (false, true) => -(TAU - forward),
            (false, false) => forward,
        };
        Ok(Arc { centre, from_rad, sweep_rad, radius })
    }

    /// The centre of an arc with a radius; a negative radius takes the long way (over 180°).
    pub(crate) fn centre_of_radius(self, radius: f64) -> Result<[f64; 2], String> {
        let [from, to] = [self.from, self.to].map(|at| {
            let [first, second, _] = self.plane.axes();
            [at[first], at[second]]
        });
        let chord = [to[0] - from[0], to[1] - from[1]];
        let length = chord[0].hypot(chord[1]);
        if length < SAME_DIRECTION_MM {
            return Err("the arc with a radius ends where it begins".to_string());
        }
        let (half, size) = (length / 2.0, radius.abs());
        if size + self.tolerance_mm < half {
            return Err(format!(
                "the radius {size} mm does not reach: start and end are {length:.4} mm apart"
            ));
        }
        let height = (size * size - half * half).max(0.0).sqrt();
        // The centre of a short counter-clockwise arc lies to the left of the chord.
        let left = if self.clockwise == (radius < 0.0) { 1.0 } else { -1.0 };
        let part = left * height / length;
        let [along, across] = chord;
        Ok([from[0] + along / 2.0 - across * part, from[1] + across / 2.0 + along * part])
    }
}
