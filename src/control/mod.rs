//! Facts about a control, and the tables in its memory.

pub mod checklist;
pub mod claims;
pub mod control_state;
pub mod controller;
mod refusals;
pub mod table;
