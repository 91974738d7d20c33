//! The program and its library as a user meets them, a module a subject.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::float_cmp,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    reason = "a test stops at what it did not expect, and says what it saw"
)]

#[path = "../support/mod.rs"]
#[allow(dead_code, unused_imports, reason = "each test program uses a part of it")]
mod support;

/// What the fuzzer holds files of a control against; its test runs here.
#[path = "../../fuzz/src/grammar.rs"]
mod grammar;

/// Counts what a run holds (large.rs).
#[global_allocator]
static COUNTED: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, usize::MAX);

mod after;
mod agreement;
mod assess;
mod assess_says;
mod browser;
mod causes_said;
mod declared;
mod determinism;
mod doubts;
mod faults;
mod field_kit;
mod foreign_text;
mod import;
mod isg;
mod joints;
mod keys;
mod large;
mod left_by_tables;
mod lists;
mod lost;
mod new;
mod order;
mod outcome;
mod outputs;
mod path;
mod profiles;
mod program;
mod properties;
mod read_out;
mod readings;
mod readme;
mod real_controls;
mod real_inputs;
mod refuses;
mod report;
mod repro;
mod separate;
mod separation;
mod shortage;
mod signed_zero;
mod skew;
mod snapshots;
mod space;
mod standards;
mod standards_inputs;
mod stories;
mod tampered;
mod told;
mod typed;
mod unread_files;
mod update;
mod verdicts;
mod visit;
mod volumetric;
