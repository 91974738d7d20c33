//! What the control shall hold, as bytes.
//!
//! `task` and `compiled` are what goes from step to step; `family` is what each family of controls does in its
//! own way, in a folder of its own.

mod compiled;
mod control_text;
mod family;
mod task;

pub mod fanuc;
mod generic;
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
