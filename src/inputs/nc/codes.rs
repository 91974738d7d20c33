//! The G and M words that are known, and the groups of which a block takes one.

use crate::inputs::nc::Plane;

/// What a modal motion word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Straight,
    /// G2 (true) or G3.
    Arc {
        clockwise: bool,
    },
    /// G73, G81 … G89 by its number.
    Cycle(u16),
    /// None: G80 ended it.
    Ended,
}

/// Where a canned cycle ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    /// G98.
    Initial,
    /// G99.
    Retract,
}

/// A word that takes the axis words of its block for itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Once {
    Dwell,
    SetOffset,
    Reference,
    SecondReference,
    Local,
    Shift,
    CancelShift,
    LookAhead,
}

/// What a G word does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Code {
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
    Level(Level),
    Once(Once),
    MachineCoordinates,
    /// G64: P and Q say how far the control may leave the path.
    Blend,
    /// G96: X is a diameter.
    Turning,
    /// Known to be without effect on the path, with its reason in words.
    Harmless(u8),
}

impl Code {
    /// Words of one group exclude each other in a block.
    pub(super) fn group(self) -> u8 {
        match self {
            Code::Motion(_) => 0,
            Code::Plane(_) => 1,
            Code::Inch(_) => 2,
            Code::Incremental(_) => 3,
            Code::AbsoluteCentre(_) => 4,
            Code::System(_) => 5,
            Code::ToolLength(_) => 6,
            Code::Level(_) => 7,
            Code::Once(_) => 8,
            Code::MachineCoordinates => 9,
            Code::EndCycle => 10,
            Code::Blend => 23,
            Code::Turning => 26,
            Code::Harmless(group) => group,
        }
    }
}

/// The meaning of a G word by its number in tenths, if it is known.
pub(super) fn code(tenths: u16) -> Option<Code> {
    Some(match tenths {
        0 => Code::Motion(Motion::Rapid),
        10 => Code::Motion(Motion::Straight),
        20 => Code::Motion(Motion::Arc { clockwise: true }),
        30 => Code::Motion(Motion::Arc { clockwise: false }),
        40 => Code::Once(Once::Dwell),
        50 | 51 | 80 => Code::Once(Once::LookAhead),
        90 => Code::Harmless(20), // exact stop in this block
        100 => Code::Once(Once::SetOffset),
        170 => Code::Plane(Plane::Xy),
        180 => Code::Plane(Plane::Zx),
        190 => Code::Plane(Plane::Yz),
        200 => Code::Inch(true),
        210 => Code::Inch(false),
        280 => Code::Once(Once::Reference),
        300 => Code::Once(Once::SecondReference),
        400 => Code::Harmless(21), // no cutter radius compensation
        430 => Code::ToolLength(true),
        490 => Code::ToolLength(false),
        500 => Code::Harmless(22), // no scaling
        520 => Code::Once(Once::Local),
        530 => Code::MachineCoordinates,
        540 | 550 | 560 | 570 | 580 | 590 => Code::System(Some(u32::from(tenths) / 10 - 53)),
        541 => Code::System(None),
        591..=593 => Code::System(Some(u32::from(tenths) - 591 + 7)),
        610 => Code::Harmless(23), // exact stop
        640 => Code::Blend,
        690 => Code::Harmless(24), // no rotation
        800 => Code::EndCycle,
        730 | 810 | 820 | 830 | 840 | 850 | 860 | 880 | 890 => {
            Code::Motion(Motion::Cycle(tenths / 10))
        }
        900 => Code::Incremental(false),
        901 => Code::AbsoluteCentre(true),
        910 => Code::Incremental(true),
        911 => Code::AbsoluteCentre(false),
        920 => Code::Once(Once::Shift),
        921 => Code::Once(Once::CancelShift),
        930 | 940 | 950 => Code::Harmless(25), // kind of feed
        960 => Code::Turning,
        970 => Code::Harmless(26), // a spindle speed in turns
        980 => Code::Level(Level::Initial),
        990 => Code::Level(Level::Retract),
        _ => return None,
    })
}

/// The next step for a G word that is not executed.
pub(super) fn why_not(tenths: u16) -> &'static str {
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
        _ => "docs/path.md lists the words that are executed",
    }
}

/// M words that call programs or move axes on their own.
pub(super) fn is_call(tenths: u16) -> bool {
    matches!(tenths, 960 | 970 | 1960 | 1970 | 1980 | 1990)
}
