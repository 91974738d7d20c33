//! How a control is told to move: facts of its part programs (docs/program.md).

use crate::control::controller::fact::{ControlUnit, Fact, Statement};
use crate::control::controller::family::LanguageFacts;
use crate::text::words::words;

words! {
    /// Family of part programs.
    pub enum Language {
        /// SINUMERIK in its own language (not the ISO dialect).
        Siemens = "siemens",
        /// FANUC, G-code system of a machining centre.
        Fanuc = "fanuc",
        /// LinuxCNC, RS274NGC.
        Linuxcnc = "linuxcnc",
    }
}

impl Language {
    /// What is known of it.
    pub(crate) const fn facts(self) -> &'static LanguageFacts {
        match self {
            Language::Siemens => &super::siemens::LANGUAGE,
            Language::Fanuc => &super::fanuc::LANGUAGE,
            Language::Linuxcnc => &super::linuxcnc::LANGUAGE,
        }
    }
}

/// `[program]` of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramFacts {
    /// Which words the program consists of.
    pub language: Language,
    /// Ending of its files, without a dot.
    pub extension: String,
    /// Name of the template.
    pub template_name: String,
    /// Text of the template.
    pub template: String,
    /// Letters of the axes X, Y, Z in a program.
    pub axis_letters: Fact<Vec<String>>,
    /// Word that makes the positions of a block machine coordinates.
    pub machine_position: Fact<String>,
    /// Words of a move by an increment at a feed.
    pub increment: Fact<String>,
    /// Address of a dwell in seconds, with the word before it.
    pub dwell: Fact<String>,
    /// Blocks that cancel offsets, rotation, scaling and mirroring; none of them writes a datum.
    pub cancel: Fact<Vec<String>>,
    /// Decimals of a position on a metric control.
    pub decimals_mm: Fact<u32>,
    /// Decimals of a position on an inch control.
    pub decimals_inch: Fact<u32>,
    /// All facts in words.
    pub statements: Vec<Statement>,
}

impl ProgramFacts {
    /// Address of the seconds of a dwell: the last letter of that fact.
    pub fn dwell_address(&self) -> char {
        self.dwell.value.chars().last().unwrap_or_default()
    }

    /// The facts that matter for a control with this basic system.
    pub(crate) fn statements_of(&self, unit: ControlUnit) -> impl Iterator<Item = &Statement> {
        let other = match unit {
            ControlUnit::Millimetre => "decimals_inch",
            ControlUnit::Inch => "decimals_mm",
        };
        self.statements.iter().filter(move |s| s.fact != other)
    }

    /// Decimals of a position in the control's unit.
    pub const fn decimals(&self, unit: ControlUnit) -> u32 {
        match unit {
            ControlUnit::Millimetre => self.decimals_mm.value,
            ControlUnit::Inch => self.decimals_inch.value,
        }
    }
}
