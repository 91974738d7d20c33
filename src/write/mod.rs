//! From the errors of the machine to the bytes that the control loads.
//!
//! `task` passes from step to step; `family` is the trait that each family of controls implements in
//! its own folder.

mod control_text;
mod family;
mod task;

mod declared;
pub mod fanuc;
mod isg;
mod linuxcnc;
mod listed;
mod refusals;
pub mod siemens;

pub mod compensation;
pub mod emit;
pub mod findings;
pub mod grid;
pub mod plan;
pub mod program;
pub mod selection;
pub mod sign_proof;
pub mod target;
