//! The user's files: job, error table, readings, files of other makers, part programs.

pub mod error_table;
pub mod findings;
pub mod import;
pub mod job;
pub mod kind;
pub mod part_program;
pub mod readings;
mod refusals;
mod table;
pub mod target_runs;
