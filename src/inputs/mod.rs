//! What a person brings: job, error table, readings, files of other makers, part programs.

pub mod nc;
pub mod error_table;
pub mod import;
pub mod target_runs;
pub mod job;
pub mod readings;
