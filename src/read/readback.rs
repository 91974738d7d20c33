//! Emitted bytes back to tables: one reader per dialect, written from the formats' references.
//!
//! A reader shares nothing with the templates but the table type ([`crate::control::table`]). It is
//! tolerant where a control is, and names line and column where a control would stop.

mod complaint;
pub mod control_data;
pub mod fanuc;
pub mod generic;
pub mod kit;
pub mod program;
pub mod siemens;
