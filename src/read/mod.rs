//! Bytes to what the control would add. Knows nothing of how they were written.
//!
//! ```text
//!   bytes ─→ family: its reader ─→ Tables ─→ its control ─→ Response (base axis, output axis, direction)
//! ```
//! One folder for each family of controls: what its files say, written from the formats' references
//! alone, and what a control adds that holds them. A reader shares nothing with the templates but the
//! table type ([`crate::control::table`]); it is tolerant where a control is, and names line and column
//! where a control would stop.

pub mod emulate;
mod family;
pub mod fanuc;
mod findings;
pub mod generic;
mod lexer;
pub mod program;
pub mod siemens;

pub use self::family::{
    FileData, KitFile, ReadBack, Text, emulator, is_whole, read, read_apart, texts,
};
pub(crate) use self::family::{file_of, load, may_be_meant_for, unread};
