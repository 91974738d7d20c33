//! Reads text and bytes, and reports problems with file, line and column.

pub mod delimited;
pub mod document;
pub mod finding;
pub(crate) mod html;
pub mod plain;
pub mod problem;
mod refused;
pub(crate) mod words;

pub(crate) use self::document::part;
