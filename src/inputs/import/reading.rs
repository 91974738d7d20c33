//! A file to be imported, and what it gave in our words.

use crate::inputs::error_table::DraftSeries;

/// A file to be imported.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    /// The file as the user named it, for messages.
    pub path: &'a str,
    /// Its name without folders, for the table.
    pub name: &'a str,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// Two axes whose squareness a file gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squareness {
    /// `xy`, `xz` or `yz`.
    pub pair: &'static str,
    /// φ in µm/m; positive = the angle between the two positive axis directions is less than 90°.
    pub um_per_m: f64,
    /// The name in the file, e.g. `C0Y`.
    pub name: &'static str,
}

/// What a file gave, in our words.
#[derive(Clone, Debug, Default)]
pub(super) struct Reading {
    pub(super) series: Vec<DraftSeries>,
    /// What the file states and what was done with it.
    pub(super) facts: Vec<String>,
    /// What the user should look at before the table is used.
    pub(super) warnings: Vec<String>,
    pub(super) squareness: Vec<Squareness>,
}
