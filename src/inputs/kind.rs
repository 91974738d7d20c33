//! What a file is, by its name and by what stands in its first line of content.

use crate::quantity::{Axis, ErrorTerm, Rotation};
use std::fmt;

/// What a person may give where several kinds of file will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A job (TOML).
    Job,
    /// Runs of one axis as Renishaw writes them.
    Rtl,
    /// A table of readings of the body diagonals.
    Readings,
    /// Another table: errors, or runs of one axis.
    Table,
}

/// The first line of a text that is neither empty nor begins as a comment does: a key or a section, or the names of columns.
pub(super) fn head<'a>(text: &'a str, comment: &str) -> &'a str {
    let is_content = |line: &&str| !line.is_empty() && !line.starts_with(comment);
    text.lines().map(str::trim).find(is_content).unwrap_or_default()
}

/// Whether a line names a column, in capitals or not.
pub(super) fn has_column(head: &str, name: &str) -> bool {
    let mut cells = head.split([',', ';', '\t']);
    cells.any(|cell| cell.trim().trim_matches('"').eq_ignore_ascii_case(name))
}

impl FileKind {
    /// By the ending of the name, else by the first line of content.
    pub fn of(name: &str, bytes: &[u8]) -> FileKind {
        let text = String::from_utf8_lossy(bytes);
        let head = head(text.trim_start_matches('\u{feff}'), "#");
        let name = name.to_ascii_lowercase();
        let is_key = |c: char| c.is_ascii_alphanumeric() || "_-.\" ".contains(c);
        let key = head.split_once('=').map(|(key, _)| key);
        if name.ends_with(".rtl") || head == "HEADER::" {
            FileKind::Rtl
        } else if name.ends_with(".toml")
            || head.starts_with('[')
            || key.is_some_and(|key| key.chars().all(is_key))
        {
            FileKind::Job
        } else if has_column(head, "diagonal") {
            FileKind::Readings
        } else {
            FileKind::Table
        }
    }

    /// In words.
    pub const fn words(self) -> &'static str {
        let words =
            ["a job", "an `.rtl` file", "readings of the body diagonals", "a table of runs"];
        words[self as usize]
    }
}

// EXX … ECZ: a deviation or a rotation while one axis moves.

/// A component of the error table: a deviation or a rotation while one axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// What deviates.
    pub kind: Kind,
    /// The moving axis.
    pub along: Axis,
}

/// Deviation or rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Deviation in the direction of an axis.
    Deviation(Axis),
    /// Rotation about an axis.
    Angle(Axis),
}

impl Kind {
    /// All of them, deviations first.
    pub const ALL: [Kind; 6] = {
        use {Axis::*, Kind::*};
        [Deviation(X), Deviation(Y), Deviation(Z), Angle(X), Angle(Y), Angle(Z)]
    };

    /// Its word in the names of columns, e.g. `ex` or `ea`.
    pub(crate) fn word(self) -> String {
        Component { kind: self, along: Axis::X }.to_string()[..2].to_ascii_lowercase()
    }
}

impl Component {
    /// The component of a name such as `EYX` or `ECX`.
    pub fn from_name(name: &str) -> Option<Component> {
        let all = Axis::ALL.into_iter();
        let mut all = all.flat_map(|along| Kind::ALL.map(|kind| Component { kind, along }));
        all.find(|component| component.to_string() == name)
    }

    /// Whether an axis is measured along itself (`EXX`): the sense of its targets is then that of
    /// the deviation.
    pub(crate) fn is_positioning(self) -> bool {
        self.kind == Kind::Deviation(self.along)
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let along = self.along;
        match self.kind {
            Kind::Deviation(of) => ErrorTerm { of, along }.fmt(out),
            Kind::Angle(about) => Rotation { about, along }.fmt(out),
        }
    }
}
