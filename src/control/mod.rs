//! What a control is and remembers.

pub mod controller;
pub mod claims;
pub mod table;
pub mod control_state;
pub mod checklist;
