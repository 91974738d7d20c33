//! Errors in space and along a path.

pub mod space;
pub mod volume_model;
pub mod definitions;
pub mod tool_path;
pub mod assessment;
