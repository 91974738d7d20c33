//! Errors in the volume and along a tool path.

pub mod assessment;
pub mod definitions;
pub mod findings;
pub mod space;
pub mod tool_path;
pub mod volume_model;
