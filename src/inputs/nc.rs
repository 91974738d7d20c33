//! Part programs: the moves that a control makes of G-code, in machine coordinates.
//!
//! ```text
//!   line ─→ scan: words with places ─→ block ─→ Interpreter: modal state ─→ Move, Move, …
//!              ▲                                       │
//!            Text (a line at a time) ←─ run: M98, M99 ─┘
//! ```
//! Every word is executed, known to be without effect on the path, or **refused with its place**:
//! nothing is ignored. A program is read line by line, so memory does not grow with it.
//!
//! The language is that of Fanuc-like controls (ISO 6983); docs/path.md lists the words, and what
//! a control may do differently.

mod arc;
mod block;
mod codes;
mod cycle;
mod interpreter;
mod offsets;
mod run;
pub mod scan;
#[cfg(test)]
mod tests;

pub use self::run::{Line, Mark, Ran, Refused, Text, run};

use std::collections::BTreeMap;

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

/// How coordinates without a decimal point are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WithoutPoint {
    /// `X100` = 100 mm (or inches), "calculator type".
    Unit,
    /// `X100` = 100 least input increments: 0.001 mm, or 0.0001 in.
    Increment,
}

/// Which tool offset G43 without H takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum G43WithoutH {
    /// Refused.
    #[default]
    Refuse,
    /// That of the last H.
    LastH,
    /// The one with the number of the tool that the last M6 changed in.
    Tool,
}

/// What the control knows before the program starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Where the axes stand, machine coordinates, mm.
    pub start: Place,
    /// First reference point (G28), mm.
    pub reference: Place,
    /// Second reference point (G30), mm.
    pub second_reference: Option<Place>,
    /// Origins of the workpiece coordinate systems in machine coordinates, mm: G54 = 1 … G59 = 6,
    /// G59.1 … G59.3 = 7 … 9, G54.1 P*n* = 100 + *n*.
    pub systems: BTreeMap<u32, Place>,
    /// Tool lengths by number of the offset (H), mm.
    pub tools: BTreeMap<u32, f64>,
    /// Inches until G21.
    pub inch: bool,
    /// Coordinates without a decimal point.
    pub without_point: WithoutPoint,
    /// G43 without H.
    pub g43_without_h: G43WithoutH,
    /// How far the end of an arc may miss its circle, mm; `None` = as the program's unit needs.
    pub arc_mm: Option<f64>,
    /// Lines that begin with `/` are left out.
    pub skip_deletable: bool,
}

/// The number of a coordinate system by its name, `G54` … `G59.3`, `G54.1 P7`.
///
/// ```
/// use nonius::inputs::nc::system_number;
/// assert_eq!(system_number("G55"), Some(2));
/// assert_eq!(system_number("g59.2"), Some(8));
/// assert_eq!(system_number("G54.1 P48"), Some(148));
/// assert_eq!(system_number("G53"), None);
/// ```
pub fn system_number(name: &str) -> Option<u32> {
    let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
    let name = name.to_ascii_uppercase();
    let plain = [
        "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3",
    ];
    if let Some(index) = plain.iter().position(|known| *known == name) {
        return u32::try_from(index).ok().map(|index| index + 1);
    }
    let number: u32 = name.strip_prefix("G54.1P")?.parse().ok()?;
    (1..=MOST_EXTENDED)
        .contains(&number)
        .then_some(EXTENDED + number)
}

/// The name of a coordinate system by its number.
pub fn system_name(number: u32) -> String {
    match number {
        0..=6 => format!("G{}", 53 + number),
        7..=EXTENDED => format!("G59.{}", number - 6),
        _ => format!("G54.1 P{}", number - EXTENDED),
    }
}

/// Numbers of G54.1 P*n* begin behind this one.
pub(crate) const EXTENDED: u32 = 100;
/// No control has more (Fanuc: 48, optionally 300).
const MOST_EXTENDED: u32 = 300;
