//! What a control is and remembers.

pub mod checklist;
pub mod claims;
pub mod control_state;
pub mod controller;
pub mod table;
