//! Files of people and machines in, problems with places out.

pub mod plain;
pub mod problem;
pub mod document;
pub mod delimited;
