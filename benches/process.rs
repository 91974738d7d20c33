//! The program as a process: `generate` beside an empty program, in turns.
//!
//! `true` is the empty program where the system has one; elsewhere it is `--version`. Each figure is
//! the time of `generate` less that of as many empty programs, run in turns: a machine that changes
//! its speed changes it for both. The program is a copy of the one that was built, as an installed one
//! is: what a linker leaves can lie scattered in memory, page by page, and is slower to start. Kits are
//! written to a disk, and to memory where the system has a folder for that: the difference is the disk's.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macro makes public functions; a benchmark may stop where its input is wrong"
)]

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

fn run(command: &mut Command) -> Duration {
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let start = Instant::now();
    let status = command.status();
    let time = start.elapsed();
    assert!(status.is_ok_and(|status| status.success()));
    time
}

/// A copy of the program, written in one piece.
fn install(folder: &Path) -> PathBuf {
    let built = Path::new(env!("CARGO_BIN_EXE_nonius"));
    let copy = folder.join(built.file_name().expect("a program has a name"));
    let bytes = fs::read(built).expect("the program was built");
    fs::write(&copy, bytes).expect("a place for the program");
    let permissions = fs::metadata(built).expect("it was read").permissions();
    fs::set_permissions(&copy, permissions).expect("the copy is ours");
    copy
}

fn version(program: &Path) -> Command {
    let mut command = Command::new(program);
    command.arg("--version");
    command
}

/// What the system has for an empty program.
fn empty_program(program: &Path) -> impl Fn() -> Command {
    let found = Command::new("true").status().is_ok();
    move || {
        if found {
            Command::new("true")
        } else {
            version(program)
        }
    }
}

fn folder_on_disk() -> TempDir {
    tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a place to write to")
}

/// Folders to write to, with what is below them. The one on the disk is left there: deleting its
/// thousands of files slows some disks down for minutes, and with them the next run.
fn places() -> Vec<(&'static str, TempDir)> {
    let mut disk = folder_on_disk();
    disk.disable_cleanup(true);
    let memory = tempfile::tempdir_in("/dev/shm").ok();
    let memory = memory.map(|folder| ("in memory", folder));
    [("on disk", disk)].into_iter().chain(memory).collect()
}

fn processes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("process");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(60);
    // One pair a sample, as every kit stays.
    group.warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_millis(400));
    let installation = folder_on_disk();
    let program = &install(installation.path());
    let empty = empty_program(program);
    group.bench_function("empty program", |bencher| {
        bencher.iter(|| run(&mut empty()))
    });
    let mut empty_first = false;
    let mut measure_above = |name: String, make: &mut dyn FnMut() -> Command| {
        group.bench_function(format!("{name}, above an empty program"), |bencher| {
            bencher.iter_custom(|count| {
                let (mut own, mut nothing) = (Duration::ZERO, Duration::ZERO);
                for _ in 0..count {
                    // What one leaves to the system to do must not always meet the other.
                    empty_first = !empty_first;
                    if empty_first {
                        nothing += run(&mut empty());
                        own += run(&mut make());
                    } else {
                        own += run(&mut make());
                        nothing += run(&mut empty());
                    }
                }
                own.saturating_sub(nothing)
            });
        });
    };
    measure_above("--version".to_string(), &mut || version(program));
    let mut kits = 0_u32;
    for (place, folder) in &places() {
        for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
            let job = format!("fixtures/nine_errors_900/{controller}.toml");
            measure_above(format!("generate {controller} {place}"), &mut || {
                kits += 1; // every kit stays until the end: removing them is no work of the program
                let mut command = Command::new(program);
                command.args(["generate", &job, "-o"]);
                command.arg(folder.path().join(format!("kit-{kits}")));
                command
            });
        }
    }
    group.finish();
}

criterion_group!(benches, processes);
criterion_main!(benches);
