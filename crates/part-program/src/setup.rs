//! What the control knows before the program starts, and where the zero of the program lies then:
//! coordinate systems, G52, G92 and the tool length.
//!
//! ```text
//!   machine = program + system (G54 …) + local (G52) + shift (G92) + tool length in Z (G43)
//! ```

use crate::moves::Place;
use std::collections::BTreeMap;

/// How coordinates without a decimal point are meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WithoutPoint {
    /// `X100` = 100 mm (or inches), "calculator type".
    #[default]
    Unit,
    /// `X100` = 100 least input increments: 0.001 mm, or 0.0001 in.
    Increment,
}

/// In which words a program is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// Of Fanuc-like controls and LinuxCNC (ISO 6983).
    #[default]
    Iso,
    /// Of SINUMERIK 840D and 828D.
    Siemens,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// In which words the program is written.
    pub language: Language,
    /// Where the axes stand, machine coordinates, mm.
    pub start: Place,
    /// First reference point (G28), mm.
    pub reference: Place,
    /// Second reference point (G30), mm.
    pub second_reference: Option<Place>,
    /// Origins of the workpiece coordinate systems in machine coordinates, mm: G54 = 1 … G59 = 6,
    /// G59.1 … G59.3 = 7 … 9, G54.1 P*n* = 100 + *n*; of Siemens G500 = 0, G505 … G599 by their numbers.
    pub systems: BTreeMap<u32, Place>,
    /// Tool lengths by number of the offset (H), mm.
    pub tools: BTreeMap<u32, f64>,
    /// Numbers of tools by their names (`T="DRILL"` of Siemens).
    pub tool_names: BTreeMap<String, u32>,
    /// Inches, or mm, until the program says its unit; `None` = mm, and the notes say where they are assumed.
    pub inch: Option<bool>,
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
        Setup { start: reference, reference, ..Setup::default() }
    }
}

/// The number of a coordinate system by its name, `G54` … `G59.3`, `G54.1 P7`.
///
/// ```
/// use part_program::system_number;
/// assert_eq!(system_number("G55"), Some(2));
/// assert_eq!(system_number("g59.2"), Some(8));
/// assert_eq!(system_number("G54.1 P48"), Some(148));
/// assert_eq!(system_number("G505"), Some(505));
/// assert_eq!(system_number("G53"), None);
/// ```
pub fn system_number(name: &str) -> Option<u32> {
    let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
    let name = name.to_ascii_uppercase();
    let plain = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];
    if let Some(index) = plain.iter().position(|known| *known == name) {
        return u32::try_from(index).ok().map(|index| index + 1);
    }
    if name == "G500" {
        return Some(0);
    }
    let of_siemens = name.strip_prefix('G').and_then(|number| number.parse().ok());
    if let Some(number) = of_siemens.filter(|number| SIEMENS_SYSTEMS.contains(number)) {
        return Some(number);
    }
    let number: u32 = name.strip_prefix("G54.1P")?.parse().ok()?;
    (1..=MOST_EXTENDED).contains(&number).then_some(EXTENDED + number)
}

/// The name of a coordinate system by its number.
pub(crate) fn system_name(number: u32) -> String {
    match number {
        0 => "G500".to_string(),
        1..=6 => format!("G{}", 53 + number),
        number if SIEMENS_SYSTEMS.contains(&number) => format!("G{number}"),
        7..=EXTENDED => format!("G59.{}", number - 6),
        _ => format!("G54.1 P{}", number - EXTENDED),
    }
}

/// Numbers of G54.1 P*n* begin behind this one.
pub(crate) const EXTENDED: u32 = 100;

/// G505 … G599.
const SIEMENS_SYSTEMS: std::ops::RangeInclusive<u32> = 505..=599;

/// No control has more (Fanuc: 48, optionally 300).
const MOST_EXTENDED: u32 = 300;

/// Zeros and tool lengths while a program is executed.
#[derive(Clone, Debug, Default)]
pub(super) struct Offsets {
    /// Those of the job, and what G10 made of them.
    pub(super) systems: BTreeMap<u32, Place>,
    pub(super) active: u32,
    /// G52, TRANS: the zero of the program within its system.
    pub(super) local: Place,
    /// G92.
    pub(super) shift: Place,
    pub(super) tool: Option<f64>,
    /// What the tool length changed since Z was last positioned.
    pub(super) pending_z: f64,
    /// The zero without the tool, and the axes that were not positioned absolutely since it changed.
    zero: Option<Place>,
    pub(super) moved: [bool; 3],
    /// Machine coordinates of the program's zero; `None` where that of the system is not known.
    pub(super) base: Option<Place>,
}

impl Offsets {
    pub(super) fn new(setup: &Setup) -> Offsets {
        let mut offsets = Offsets {
            systems: setup.systems.clone(),
            active: u32::from(setup.language == Language::Iso), // G54, or G500
            ..Offsets::default()
        };
        offsets.update();
        offsets.moved = [false; 3];
        offsets
    }

    pub(super) fn update(&mut self) {
        let system = self.systems.get(&self.active);
        let zero: Option<Place> =
            system.map(|system| std::array::from_fn(|k| system[k] + self.local[k] + self.shift[k]));
        for axis in 0..3 {
            self.moved[axis] |= self.zero.map(|zero| zero[axis]) != zero.map(|zero| zero[axis]);
        }
        self.zero = zero;
        let tool = [0.0, 0.0, self.tool.unwrap_or(0.0)];
        self.base = zero.map(|zero| std::array::from_fn(|k| zero[k] + tool[k]));
    }

    pub(super) fn select(&mut self, system: u32) {
        self.active = system;
        self.update();
    }

    /// G10 L2: sets words of a system; of one that is not known all three are needed.
    pub(super) fn set_system(&mut self, system: u32, words: [Option<f64>; 3], add: bool) -> bool {
        let complete = !add && words.iter().all(Option::is_some);
        let Some(old) = self.systems.get(&system).copied().or(complete.then_some([0.0; 3])) else {
            return false;
        };
        let new = |k: usize| words[k].map_or(old[k], |mm| if add { old[k] + mm } else { mm });
        self.systems.insert(system, std::array::from_fn(new));
        self.update();
        true
    }

    /// G43, G49: what the length is from now on.
    pub(super) fn change_tool(&mut self, length: Option<f64>) {
        self.pending_z += length.unwrap_or(0.0) - self.tool.unwrap_or(0.0);
        self.tool = length;
        self.update();
    }
}
