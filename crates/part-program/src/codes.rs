//! The G and M words that are known, the groups of which a block takes one, and what a cycle remembers.

use crate::{Language, Plane};

/// What a modal motion word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    Rapid,
    Straight,
    /// G2 (true) or G3.
    Arc(bool),
    /// G73, G81 … G89 by its number.
    Cycle(u16),
    /// None: G80 ended it.
    Ended,
}

/// What a G word does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Code {
    Motion(Motion),
    /// G80.
    EndCycle,
    Plane(Plane),
    Inch(bool),
    Incremental(bool),
    AbsoluteCentre(bool),
    /// Number of a coordinate system; `None` = the one that P names.
    System(Option<u32>),
    ToolLength(bool),
    /// G99, G98: a cycle ends at R, or at the initial level.
    Retract(bool),
    /// A word that takes the axis words of its block for itself (G4, G10, G28, G52, G92, TRANS, look-ahead).
    Once,
    MachineCoordinates,
    /// G64: P and Q say how far the control may leave the path.
    Blend,
    /// G96: X is a diameter.
    Turning,
    /// RET.
    Return,
    /// Known to be without effect on the path.
    Harmless,
}

/// The group of a G word by its number in tenths, of which a block takes one word, and what it does.
pub(crate) fn code(tenths: u16, language: Language) -> Option<(usize, Code)> {
    if language == Language::Siemens {
        return siemens_code(tenths);
    }
    let number = u32::from(tenths);
    Some(match tenths {
        0 => (0, Code::Motion(Motion::Rapid)),
        10 => (0, Code::Motion(Motion::Straight)),
        20 => (0, Code::Motion(Motion::Arc(true))),
        30 => (0, Code::Motion(Motion::Arc(false))),
        730 | 810 | 820 | 830 | 840 | 850 | 860 | 880 | 890 => {
            (0, Code::Motion(Motion::Cycle(tenths / 10)))
        }
        170 => (1, Code::Plane(Plane::Xy)),
        180 => (1, Code::Plane(Plane::Zx)),
        190 => (1, Code::Plane(Plane::Yz)),
        200 | 210 => (2, Code::Inch(tenths == 200)),
        900 | 910 => (3, Code::Incremental(tenths == 910)),
        901 | 911 => (4, Code::AbsoluteCentre(tenths == 901)),
        540 | 550 | 560 | 570 | 580 | 590 => (5, Code::System(Some(number / 10 - 53))),
        541 => (5, Code::System(None)),
        591..=593 => (5, Code::System(Some(number - 591 + 7))),
        430 | 490 => (6, Code::ToolLength(tenths == 430)),
        980 | 990 => (7, Code::Retract(tenths == 990)),
        40 | 50 | 51 | 80 | 100 | 280 | 300 | 520 | 920 | 921 => (8, Code::Once),
        530 => (9, Code::MachineCoordinates),
        800 => (10, Code::EndCycle),
        90 => (11, Code::Harmless),  // exact stop in this block
        400 => (12, Code::Harmless), // no cutter radius compensation
        500 => (13, Code::Harmless), // no scaling
        610 => (14, Code::Harmless), // exact stop
        640 => (14, Code::Blend),
        690 => (15, Code::Harmless),             // no rotation
        930 | 940 | 950 => (16, Code::Harmless), // kind of feed
        960 => (17, Code::Turning),
        970 => (17, Code::Harmless), // a spindle speed in turns
        _ => return None,
    })
}

/// Numbers of words with names begin here.
pub(crate) const NAMED_FROM: u16 = 10_000;
pub(crate) const TRANS: u16 = NAMED_FROM;
pub(crate) const ATRANS: u16 = NAMED_FROM + 1;

/// The words of Siemens that have names, with their groups.
const NAMED: [(&str, usize, Code); 18] = [
    ("TRANS", 8, Code::Once),
    ("ATRANS", 8, Code::Once),
    ("SUPA", 9, Code::MachineCoordinates),
    ("RET", 18, Code::Return),
    ("STOPRE", 19, Code::Harmless), // no blocks are prepared in advance
    ("BRISK", 20, Code::Harmless),  // acceleration
    ("SOFT", 20, Code::Harmless),
    ("DRIVE", 20, Code::Harmless),
    ("FFWON", 21, Code::Harmless), // feed-forward
    ("FFWOF", 21, Code::Harmless),
    ("CFC", 22, Code::Harmless), // feed on contours
    ("CFTCP", 22, Code::Harmless),
    ("CFIN", 22, Code::Harmless),
    ("NORM", 23, Code::Harmless), // approach of a contour with G41
    ("KONT", 23, Code::Harmless),
    ("COMPOF", 24, Code::Harmless),  // no compressor
    ("DIAMOF", 25, Code::Harmless),  // X is no diameter
    ("TRAFOOF", 26, Code::Harmless), // no transformation
];

/// The number of a word with a name.
pub(crate) fn named_word(name: &str) -> Option<u16> {
    let index = NAMED.iter().position(|(known, ..)| *known == name)?;
    u16::try_from(index).ok().map(|index| NAMED_FROM + index)
}

fn named(tenths: u16) -> Option<&'static (&'static str, usize, Code)> {
    NAMED.get(usize::from(tenths.checked_sub(NAMED_FROM)?))
}

/// The name of a word by its number.
pub(crate) fn name_of(tenths: u16) -> Option<&'static str> {
    named(tenths).map(|(name, ..)| *name)
}

/// Drilling cycles of Siemens, with the number of arguments that are executed:
/// RTP, RFP, SDIS, DP, DPR, then DTB, then FDEP, FDPR, DAM, DTB, DTS, FRF, VARI.
pub(crate) const SIEMENS_CYCLES: [(&str, u16, usize); 3] =
    [("CYCLE81", 81, 5), ("CYCLE82", 82, 6), ("CYCLE83", 83, 12)];

/// The same as [`code`] in the language of Siemens.
fn siemens_code(tenths: u16) -> Option<(usize, Code)> {
    if let Some((_, group, code)) = named(tenths) {
        return Some((*group, *code));
    }
    let number = u32::from(tenths / 10);
    Some(match tenths {
        0..=30 | 170 | 180 | 190 | 900 | 910 | 40 | 90 | 400 | 940 | 950 | 970 => {
            code(tenths, Language::Iso)?
        }
        700 | 7000 => (2, Code::Inch(true)),
        710 | 7100 => (2, Code::Inch(false)),
        540 | 550 | 560 | 570 => (5, Code::System(Some(number - 53))),
        5000 => (5, Code::System(Some(0))),
        5050..=5990 => (5, Code::System(Some(number))),
        530 | 1530 => (9, Code::MachineCoordinates),
        600 => (14, Code::Harmless),                // exact stop
        6010 | 6020 | 6030 => (27, Code::Harmless), // its kind
        640 | 6410 | 6420 | 6430 | 6440 | 6450 => (14, Code::Blend),
        4500 | 4510 => (28, Code::Harmless), // corners with G41
        960 | 9610 => (17, Code::Turning),
        _ => return None,
    })
    .filter(|_| tenths.is_multiple_of(10))
}

/// More than there are groups.
pub(crate) const GROUPS: usize = 29;

/// The next step for a G word that is not executed.
pub(crate) fn why_not(tenths: u16) -> &'static str {
    match tenths {
        410 | 420 => {
            "cutter radius compensation moves the path by the radius: let the CAM system write the path of the tool's centre"
        }
        410..=429 => "let the CAM system write the path of the tool's centre",
        440 => "give the tool length with the other sign, and use G43",
        740 | 760 => "write the cycle as G81 … G89, or as single moves",
        870 => {
            "back boring moves sideways by an amount that the control knows: write the moves out"
        }
        650 | 660 | 670 => "macros are not executed: let the CAM system write moves",
        680 | 681 => "let the CAM system write the turned path",
        510 => "let the CAM system write the scaled path",
        61 | 431..=435 => "path modes and compensation of several axes are not executed",
        700 | 710 => "write G20 for inches, G21 for millimetres",
        _ => "docs/volume.md lists the words that are executed",
    }
}

/// Modal values of a cycle. Its depths are kept as they are written: a change of zero or length
/// inside the cycle moves them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cycle {
    /// Where the tool stood along the third axis when the cycle was called, machine coordinate, mm.
    pub(crate) initial: f64,
    /// The program's zero there at that time.
    pub(crate) zero: Option<f64>,
    pub(crate) retract: Option<Depth>,
    pub(crate) bottom: Option<Depth>,
}

/// A cycle with its levels, mm from the program's zero: RTP, RFP + SDIS, bottom.
pub(crate) type Drill = (u16, [f64; 3]);

/// A depth as it is written, mm, and whether that block was incremental.
pub(crate) type Depth = (f64, bool);
