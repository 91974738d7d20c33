//! `cargo run --release --manifest-path fuzz/Cargo.toml -- ARGUMENTS`: builds the engine with coverage counters in
//! `nonius` and its members and runs it with the same arguments.
//!
//! Cargo on stable Rust has no way to give flags to one dependency only. So this program names itself as the
//! compiler's wrapper: called by cargo with the compiler and its arguments, it adds the flags for `nonius` and the
//! members of its workspace.
//! Where that build fails (another compiler, no such pass), the engine is built without counters and only mutates.

mod planted;

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

/// Set for the compiler's wrapper, which is this program too.
const AS_WRAPPER: &str = "NONIUS_FUZZ_WRAPPER";

/// One 8-bit counter for every edge between basic blocks, and a call that counts steps (Clang's SanitizerCoverage, in
/// LLVM).
const COUNTERS: [&str; 5] = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=3",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-trace-pc-guard",
    "-Cllvm-args=-sanitizer-coverage-prune-blocks=1",
];

fn main() -> ExitCode {
    let arguments: Vec<OsString> = env::args_os().skip(1).collect();
    if env::var_os(AS_WRAPPER).is_some() {
        return compile(&arguments);
    }
    if arguments.first().is_some_and(|word| word == "planted") {
        return match planted::run() {
            Ok(all_found) => status(all_found),
            Err(why) => {
                eprintln!("{why}");
                ExitCode::from(2)
            }
        };
    }
    if cargo("build", &[], true) {
        return status(cargo("run", &arguments, true));
    }
    if !cargo("build", &[], false) {
        return ExitCode::from(2); // not what a finding ends with
    }
    eprintln!("the compiler takes no coverage counters: plain mutation");
    status(cargo("run", &arguments, false))
}

/// The compiler with its arguments, and the counters where the crate is one of the program's; what runs while it is
/// built has no engine that would take them.
fn compile(arguments: &[OsString]) -> ExitCode {
    let Some((compiler, arguments)) = arguments.split_first() else {
        return ExitCode::from(2);
    };
    let mut command = Command::new(compiler);
    command.args(arguments);
    let is_script = arguments.iter().any(|argument| argument == "build_script_build");
    let folder = env::var_os("CARGO_MANIFEST_DIR").filter(|_| !is_script);
    if folder.is_some_and(|folder| is_member(Path::new(&folder))) {
        command.args(COUNTERS);
    }
    status(command.status().is_ok_and(|status| status.success()))
}

/// Whether a crate is `nonius` or a member of its workspace.
fn is_member(folder: &Path) -> bool {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    root.is_some_and(|root| folder == root || folder.starts_with(root.join("crates")))
}

/// Runs cargo for the engine.
fn cargo(verb: &str, arguments: &[OsString], with_counters: bool) -> bool {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.arg(verb).args([
        "--quiet",
        "--release",
        "--locked",
        "--features",
        "engine",
        "--bin",
        "engine",
    ]);
    command.args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")]);
    if verb == "run" {
        command.arg("--").args(arguments);
    }
    if let (true, Ok(own)) = (with_counters, env::current_exe()) {
        command.env("RUSTC_WRAPPER", own).env(AS_WRAPPER, "1");
    }
    command.status().is_ok_and(|status| status.success())
}

fn status(is_good: bool) -> ExitCode {
    if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
