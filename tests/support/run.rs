//! The program as a user starts it.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs it in a directory, with arguments separated by blanks and nothing on standard input.
pub(crate) fn nonius(directory: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments.split_whitespace())
        .current_dir(directory)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// The same: exit status, data and talk.
pub(crate) fn ended(directory: &Path, arguments: &str) -> (Option<i32>, String, String) {
    let output = nonius(directory, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace('\r', "");
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}
