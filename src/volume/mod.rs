//! Errors in the volume and along a tool path.

pub mod assessment;
pub mod definitions;
pub mod findings;
pub use nonius_numerics::space;
pub mod tool_path;
pub mod volume_model;
