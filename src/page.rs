//! Pictures of errors, and the report that is handed over.
//!
//! ```text
//!   results of machine, judge, volume ─→ curves, diagonals, vectors … ─→ Picture ─→ svg
//! ```
//! A picture holds numbers in their units and no drawing: `svg` decides the length of a tick and the place of a
//! label. Text remains text, and the colours can be distinguished in grey. Words and units of a picture are those of a
//! `Locale`: of the page that it stands on, or English and mm in a file of its own.

mod curves;
mod locale;
pub mod picture;
mod report;
mod svg;
mod volume;

pub use curves::{Curves, separated, targets, terms};
pub use locale::{DisplayUnit, Locale, Texts, bin_um};
pub use picture::{Ink, Picture};
pub use report::{PagePicture, Report, Visit, linear_document};
pub use volume::{HoleErrors, Side, Trace, path, volume};
