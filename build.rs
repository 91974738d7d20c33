//! Links the compiler's unwinder into the program, where the compiler has it as an archive.
//!
//! Otherwise the program loads `libgcc_s.so` at every start, which costs time
//! (docs/performance.md, docs/decisions.md). Where it is not certain that the archive fits, all
//! stays as it was.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if is_for_this_linux()
        && is_linked_by_cc()
        && let Some(archive) = archive()
    {
        println!("cargo::rerun-if-changed={archive}");
        println!("cargo::rustc-link-lib=static:-bundle=gcc_eh");
    }
}

/// Whether the program is for a Linux with the GNU C library, and for this machine's.
fn is_for_this_linux() -> bool {
    variable("CARGO_CFG_TARGET_OS") == "linux"
        && variable("CARGO_CFG_TARGET_ENV") == "gnu"
        && variable("TARGET") == variable("HOST")
}

/// Whether nobody has chosen another linker than the C compiler: its libraries may be others.
fn is_linked_by_cc() -> bool {
    variable("RUSTC_LINKER").is_empty() && !variable("CARGO_ENCODED_RUSTFLAGS").contains("link")
}

fn variable(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}

/// Where the C compiler has the archive; it answers with the bare name where it has none.
fn archive() -> Option<String> {
    let question = "-print-file-name=libgcc_eh.a";
    let answer = Command::new("cc").arg(question).output().ok()?;
    let path = String::from_utf8(answer.stdout).ok()?.trim().to_string();
    let is_there = Path::new(&path).is_absolute() && Path::new(&path).is_file();
    is_there.then_some(path)
}
