//! A test without its data says so where the user sees it.

use std::io::Write;

/// The end of a test whose data beside the repository are not there, in one line on the terminal.
/// The test runner swallows what `eprintln!` prints, and would show nothing but `ok`.
pub(crate) fn skipped() {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let line = format!("skipped: {test}: ../shared is not here\n");
    std::io::stderr().write_all(line.as_bytes()).ok();
}
