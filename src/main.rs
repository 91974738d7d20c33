//! The `nonius` program: arguments in, exit code out.

fn main() {}
