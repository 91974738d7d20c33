//! What the control knows before the program starts.

use crate::inputs::nc::moves::Place;
use std::collections::BTreeMap;

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

impl Setup {
    /// A control whose axes stand at the reference, which knows no zero and no tool.
    pub fn at(reference: Place) -> Setup {
        Setup {
            start: reference,
            reference,
            second_reference: None,
            systems: BTreeMap::new(),
            tools: BTreeMap::new(),
            inch: false,
            without_point: WithoutPoint::Unit,
            g43_without_h: G43WithoutH::Refuse,
            arc_mm: None,
            skip_deletable: false,
        }
    }
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
