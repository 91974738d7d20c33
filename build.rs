//! Links the compiler's unwinder into the program, where the compiler has it as an archive.
//!
//! Otherwise the program loads `libgcc_s.so` at every start, whose beginning asks the processor
//! for its features: 0.1 to 0.3 ms of a command that takes a few (docs/performance.md).

use std::path::Path;
use std::process::Command;

const ARCHIVE: &str = "libgcc_eh.a";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if is_for_this_linux()
        && let Some(folder) = folder_of_the_archive()
    {
        println!("cargo::rustc-link-search=native={folder}");
        println!("cargo::rustc-link-lib=static:-bundle=gcc_eh");
    }
}

/// Whether the program is for a Linux with the GNU C library, and for this machine's.
fn is_for_this_linux() -> bool {
    let of_target = |name: &str| std::env::var(name).unwrap_or_default();
    of_target("CARGO_CFG_TARGET_OS") == "linux"
        && of_target("CARGO_CFG_TARGET_ENV") == "gnu"
        && of_target("TARGET") == of_target("HOST")
}

/// What the C compiler, which links the program, answers; the bare name where it has none.
fn folder_of_the_archive() -> Option<String> {
    let question = format!("-print-file-name={ARCHIVE}");
    let answer = Command::new("cc").arg(question).output().ok()?;
    let path = String::from_utf8(answer.stdout).ok()?;
    let folder = Path::new(path.trim()).parent()?;
    let named = folder.to_str().filter(|folder| !folder.is_empty())?;
    Path::new(path.trim()).is_file().then(|| named.to_string())
}
