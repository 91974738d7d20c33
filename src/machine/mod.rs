//! What the machine does wrong: separation of the readings, the error model, figures of the standards.

pub mod findings;
pub mod model;
pub mod separation;
pub mod standards;
