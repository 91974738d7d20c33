//! The choices that a statement offers, each with its word.

use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Deviation};

/// What a value means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Measured − target, in the sense in which the file counts its positions.
    AsError,
    /// What has to be added: target − measured.
    AsCorrection,
}

impl Sign {
    /// The word of `--sign`.
    pub const fn word(self) -> &'static str {
        match self {
            Sign::AsError => "as-error",
            Sign::AsCorrection => "as-correction",
        }
    }

    /// A value of a file as a deviation.
    pub(super) fn deviation(self, value: f64) -> f64 {
        match self {
            Sign::AsError => value,
            Sign::AsCorrection => (-Correction::from_um(value)).um(),
        }
    }
}

/// A deviation whose axis the file counts the other way round.
pub(super) fn turned(um: f64) -> f64 {
    (Deviation::ZERO - Deviation::from_um(um)).um()
}

/// How the values of a compensation table count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Each value is the whole deviation or correction at its position.
    Absolute,
    /// Each value is a change from a neighbour.
    Incremental,
}

impl Values {
    /// The word of `--values`.
    pub const fn word(self) -> &'static str {
        match self {
            Values::Absolute => "absolute",
            Values::Incremental => "incremental",
        }
    }
}

/// Which of the two tables of a file is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// What was measured.
    Measured,
    /// What the maker's program made of it.
    Averages,
}

impl Rows {
    /// The word of `--rows`.
    pub const fn word(self) -> &'static str {
        match self {
            Rows::Measured => "measured",
            Rows::Averages => "averages",
        }
    }
}

/// How the runs of a measurement were travelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// All runs from the first target to the last.
    Unidirectional,
    /// Odd runs from the first target to the last, even runs back.
    Bidirectional,
}

impl Runs {
    /// The word of `--runs`.
    pub const fn word(self) -> &'static str {
        match self {
            Runs::Unidirectional => "unidirectional",
            Runs::Bidirectional => "bidirectional",
        }
    }
}

/// Direction of travel of rows that do not name one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// In one direction.
    One(Direction),
    /// Not distinguished.
    Both,
}

impl Travel {
    /// The word of `--direction`.
    pub const fn word(self) -> &'static str {
        match self {
            Travel::One(direction) => direction.symbol(),
            Travel::Both => "both",
        }
    }
}

/// An encoding of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8.
    Utf8,
    /// UTF-16, the smaller byte first.
    Utf16Le,
    /// UTF-16, the larger byte first.
    Utf16Be,
    /// Western European Windows.
    Windows1252,
    /// Central European Windows.
    Windows1250,
    /// Simplified Chinese.
    Gbk,
}

impl Encoding {
    /// All of them.
    pub const ALL: [Encoding; 6] = [
        Encoding::Utf8,
        Encoding::Utf16Le,
        Encoding::Utf16Be,
        Encoding::Windows1252,
        Encoding::Windows1250,
        Encoding::Gbk,
    ];

    /// The word of `--encoding`; `latin-1` is another word for `windows-1252`.
    pub const fn word(self) -> &'static str {
        match self {
            Encoding::Utf8 => "utf-8",
            Encoding::Utf16Le => "utf-16le",
            Encoding::Utf16Be => "utf-16be",
            Encoding::Windows1252 => "windows-1252",
            Encoding::Windows1250 => "windows-1250",
            Encoding::Gbk => "gbk",
        }
    }
}

/// The sign before the decimals of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
}

impl Decimal {
    /// The word of `--decimal`.
    pub const fn word(self) -> &'static str {
        match self {
            Decimal::Point => "point",
            Decimal::Comma => "comma",
        }
    }
}

/// Whether the instrument brought the readings to 20 °C of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialCorrected {
    /// The expansion of the material is taken out already.
    Yes,
    /// It is still in the readings.
    No,
    /// Nobody knows any more.
    NotStated,
}

impl MaterialCorrected {
    /// The word of `--material-corrected`.
    pub const fn word(self) -> &'static str {
        match self {
            MaterialCorrected::Yes => "yes",
            MaterialCorrected::No => "no",
            MaterialCorrected::NotStated => "not-stated",
        }
    }
}
