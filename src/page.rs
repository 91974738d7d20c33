//! What a person looks at: pictures of errors, and the page that is handed over.
//!
//! ```text
//!   results of machine, judge, volume ─→ curves, diagonals, vectors … ─→ Picture ─→ svg
//! ```
//! A picture holds numbers in their units and no drawing: how long a tick is and where a label stands is
//! decided once, in `svg`. Its text is text, its colours are told apart in grey too.

mod curves;
mod path;
pub mod picture;
mod report;
mod scale;
mod svg;
mod targets;
mod texts;
mod volume;

pub use curves::{Curves, separated, terms};
pub use path::{HoleErrors, Trace, path};
pub use picture::{Ink, Picture};
pub use report::{Report, Shown};
pub use scale::bin_um;
pub use targets::targets;
pub use texts::Texts;
pub use volume::{Side, volume};
