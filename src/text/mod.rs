//! Files of people and machines in, problems with places out.

pub mod delimited;
pub mod document;
pub mod finding;
pub(crate) mod html;
pub mod plain;
pub mod problem;
