//! What the user states because the file does not carry it.

use crate::axis::{Axis, Direction};
use crate::import::Component;
use crate::problem::{Problem, Problems};
use crate::units::{Correction, Deviation, MM_PER_INCH, UM_PER_MM};

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

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Micrometres.
    Um,
    /// Millimetres.
    Mm,
    /// Inches.
    In,
    /// Microinches.
    Uin,
}

impl Unit {
    /// The word of `--unit`.
    pub const fn word(self) -> &'static str {
        match self {
            Unit::Um => "um",
            Unit::Mm => "mm",
            Unit::In => "in",
            Unit::Uin => "uin",
        }
    }

    /// How many micrometres it has.
    pub const fn um(self) -> f64 {
        match self {
            Unit::Um => 1.0,
            Unit::Mm => UM_PER_MM,
            Unit::In => MM_PER_INCH * UM_PER_MM,
            Unit::Uin => MM_PER_INCH * UM_PER_MM / 1e6,
        }
    }

    /// The unit of a text such as `mm`, `µm` or `inch`.
    pub(super) fn from_text(text: &str) -> Option<Unit> {
        match text.trim().to_lowercase().as_str() {
            "um" | "µm" | "μm" | "micron" | "microns" => Some(Unit::Um),
            "mm" => Some(Unit::Mm),
            "in" | "inch" | "inches" => Some(Unit::In),
            "uin" | "µin" | "μin" | "microinch" => Some(Unit::Uin),
            _ => None,
        }
    }
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
    /// Latin-1 as Windows writes it (windows-1252).
    Latin1,
    /// Simplified Chinese.
    Gbk,
}

impl Encoding {
    /// The word of `--encoding`.
    pub const fn word(self) -> &'static str {
        match self {
            Encoding::Utf8 => "utf-8",
            Encoding::Latin1 => "latin-1",
            Encoding::Gbk => "gbk",
        }
    }
}

/// What was stated on the command line; `None` = nothing.
#[derive(Clone, Debug, Default)]
pub struct Stated {
    /// `--axis`: the moving axis.
    pub axis: Option<Axis>,
    /// `--term`: which component was measured.
    pub term: Option<Component>,
    /// `--first-target-at-mm`: machine coordinate of the first target.
    pub first_target_at_mm: Option<f64>,
    /// `--targets-run`: the way of the axis from the first target to the last.
    pub targets_run: Option<Direction>,
    /// `--direction`: travel of rows without one.
    pub travel: Option<Travel>,
    /// `--sign`: what the values mean.
    pub sign: Option<Sign>,
    /// `--unit`: of the values.
    pub unit: Option<Unit>,
    /// `--values`: absolute or incremental.
    pub values: Option<Values>,
    /// `--runs`: how they were travelled.
    pub runs: Option<Runs>,
    /// `--columns`: `NAME=COLUMN,…`.
    pub columns: Option<String>,
}

impl Stated {
    /// Every option with its value, in a fixed order.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let text = |word: &str| word.to_string();
        let all = [
            (
                "--columns",
                self.columns.as_ref().map(|c| format!("\"{c}\"")),
            ),
            ("--axis", self.axis.map(|a| text(a.key()))),
            ("--term", self.term.map(|t| t.to_string())),
            (
                "--first-target-at-mm",
                self.first_target_at_mm.map(|mm| format!("{}", mm + 0.0)),
            ),
            ("--targets-run", self.targets_run.map(|d| text(d.symbol()))),
            ("--direction", self.travel.map(|t| text(t.word()))),
            ("--sign", self.sign.map(|s| text(s.word()))),
            ("--unit", self.unit.map(|u| text(u.word()))),
            ("--values", self.values.map(|v| text(v.word()))),
            ("--runs", self.runs.map(|r| text(r.word()))),
        ];
        let given = all.into_iter();
        given
            .filter_map(|(option, value)| Some((option, value?)))
            .collect()
    }

    /// A statement that has no meaning for the format is a mistake of the user.
    pub(super) fn foreign_to(&self, format: &str, takes: &[&str]) -> Problems {
        let mut problems = Problems::none();
        for (option, _) in self.given() {
            if !takes.contains(&option) {
                problems.push(
                    Problem::new(format!("`{option}` has no meaning for format `{format}`")).help(
                        format!("leave it out; `{format}` takes {}", takes.join(", ")),
                    ),
                );
            }
        }
        problems
    }

    /// The sign, or the problem that it is missing.
    pub(super) fn required_sign(&self, problems: &mut Problems) -> Option<Sign> {
        if self.sign.is_none() {
            problems.push(missing(
                "--sign",
                "the file does not say whether its values are deviations or corrections",
                "add `--sign as-error` (measured - target) or `--sign as-correction` (what has to be added)",
            ));
        }
        self.sign
    }

    /// The component, whose axis must be that of `--axis`.
    pub(super) fn required_term(&self, problems: &mut Problems) -> Option<Component> {
        let Some(term) = self.term else {
            problems.push(missing(
                "--term",
                "the file does not say which deviation was measured",
                "add e.g. `--term EXX` (positioning of X) or `--term EYX` (deviation in Y while X moves)",
            ));
            return None;
        };
        if let Some(axis) = self.axis.filter(|axis| *axis != term.along) {
            problems.push(
                Problem::new(format!(
                    "`--axis {}` contradicts `--term {term}`, in which {} moves",
                    axis.key(),
                    term.along
                ))
                .help("the last letter of a term is the moving axis"),
            );
        }
        Some(term)
    }
}

/// A statement that the file cannot do without.
pub(super) fn missing(option: &str, why: &str, help: &str) -> Problem {
    Problem::new(format!("`{option}` is not stated: {why}")).help(help)
}
