//! Seeded simulations: what writes the tables of docs/accuracy.md. How many are run: `NONIUS_SIMULATIONS` (CONTRIBUTING.md).
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    reason = "a test stops at what it did not expect, and says what it saw"
)]

#[path = "../support/mod.rs"]
#[allow(dead_code, unused_imports, reason = "each test program uses a part of it")]
mod support;

mod acts;
mod causes;
mod coverage;
mod coverage_bounds;
mod doubts;
mod endless;
mod exchanged;
mod good_practice;
mod plan;
mod right_kits;
mod separation_laws;
mod silence;
