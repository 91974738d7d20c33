//! Numbers as they are written.

use crate::quantity::units::Figure;

/// A number with a fixed number of decimals, never `-0`.
pub(super) fn fixed(number: f64, decimals: u32) -> String {
    format!("{:.*}", decimals as usize, Figure(number))
}
