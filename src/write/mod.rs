//! What the control shall hold, as bytes.

pub mod compensation;
pub mod emit;
pub mod grid;
pub mod plan;
pub mod program;
pub mod selection;
pub mod sign_proof;
pub mod target;
