//! What the control shall hold, as bytes.

pub mod program;
pub mod grid;
pub mod target;
pub mod selection;
pub mod plan;
pub mod compensation;
pub mod sign_proof;
pub mod emit;
