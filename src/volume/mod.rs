//! Errors in space and along a path.

pub mod assessment;
pub mod definitions;
pub mod findings;
pub mod space;
pub mod tool_path;
pub mod volume_model;
