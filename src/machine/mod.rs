//! The errors of the machine: separation of the readings, the error model, figures by standard.

pub mod findings;
pub mod model;
pub mod separation;
pub mod standards;
