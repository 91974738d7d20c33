//! The `nonius` program: arguments in, exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    nonius::cli::run(std::env::args_os())
}
