//! Moves of the tool.

/// A place in machine coordinates, mm: X, Y, Z.
pub type Place = [f64; 3];

/// G17, G18, G19: the two axes of the plane in the order of positive rotation, and the third one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// G17.
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
        match self.shape {
            Shape::Line => straight(self.from, self.to, part),
            Shape::Arc(arc) => {
                let mut place = straight(self.from, self.to, part);
                let [first, second, _] = self.plane.axes();
                let angle = arc.from_rad + arc.sweep_rad * part;
                let radius = arc.radius[0] + (arc.radius[1] - arc.radius[0]) * part;
                place[first] = arc.centre[0] + radius * angle.cos();
                place[second] = arc.centre[1] + radius * angle.sin();
                place
            }
        }
    }

    /// Length, mm (of an arc with its mean radius).
    pub fn length_mm(&self) -> f64 {
        let square = |value: f64| value * value;
        match self.shape {
            Shape::Line => (0..3)
                .map(|k| square(self.to[k] - self.from[k]))
                .sum::<f64>()
                .sqrt(),
            Shape::Arc(arc) => {
                let third = self.plane.axes()[2];
                let around = arc.sweep_rad * f64::midpoint(arc.radius[0], arc.radius[1]);
                around.hypot(self.to[third] - self.from[third])
            }
        }
    }
}

fn straight(from: Place, to: Place, part: f64) -> Place {
    std::array::from_fn(|k| {
        if part >= 1.0 {
            to[k]
        } else {
            from[k] + (to[k] - from[k]) * part
        }
    })
}
