//! Machines and emulators that know nothing of the program, and real controls.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    reason = "a test stops at what it did not expect, and says what it saw"
)]

#[path = "../support/mod.rs"]
#[allow(dead_code, unused_imports, reason = "each test program uses a part of it")]
mod support;

mod contract;
mod every_control;
mod hal;
mod linuxcnc;
mod rs274;
mod simulate;
