//! Part programs: the moves that a control makes of G-code, in machine coordinates.
//!
//! ```text
//!   line ─→ lexer: words with places ─→ block ─→ Interpreter: modal state ─→ Move, Move, …
//!              ▲                                       │
//!            Text (a line at a time) ←─ run: M98, M99 ─┘
//! ```
//! Every word is executed, known to be without effect on the path, or **refused with its place**:
//! nothing is ignored. A program is read line by line, so memory does not grow with it.
//!
//! The language is that of Fanuc-like controls (ISO 6983); docs/volume.md lists the words, and what
//! a control may do differently.

#![doc = include_str!("../README.md")]

mod block;
mod codes;
mod expression;
mod flow;
mod interpreter;
mod lexer;
mod moves;
mod notes;
mod run;
mod setup;
mod siemens;
mod wrong;

pub use self::lexer::{Counts, NAME, Word, words};
pub use self::moves::{Arc, Move, Place, Plane, Shape};
pub(crate) use self::setup::{EXTENDED, system_name};
pub use self::setup::{G43WithoutH, Language, Setup, WithoutPoint, system_number};
pub use self::wrong::{Excerpt, Refused, Wrong};

/// Millimetres of an inch.
pub(crate) const MM_PER_INCH: f64 = 25.4;

pub use self::run::{Line, Mark, Ran, Text, run};

#[cfg(test)]
mod tests;
