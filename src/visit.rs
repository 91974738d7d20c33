//! A visit: a job with everything that it names, opened once, wherever its files lie.

pub mod files;
pub(crate) mod inputs;
pub(crate) mod job_files;
pub(crate) mod refusals;
pub(crate) mod second;
