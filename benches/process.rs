//! The program as a process: `generate` beside an empty program in the same run.
//!
//! `true` is the empty program where the system has one; elsewhere compare with `--version`. Kits
//! are written to a disk, and to memory where the system has a folder for that: the difference is
//! the disk's.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macro makes public functions; a benchmark may stop where its input is wrong"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

fn run(command: &mut Command) {
    let status = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// Folders to write to, with what is below them.
fn places() -> Vec<(&'static str, TempDir)> {
    let disk = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a place to write to");
    let memory = tempfile::tempdir_in("/dev/shm").ok();
    let memory = memory.map(|folder| ("in memory", folder));
    [("on disk", disk)].into_iter().chain(memory).collect()
}

fn processes(criterion: &mut Criterion) {
    let nonius = || Command::new(env!("CARGO_BIN_EXE_nonius"));
    let mut group = criterion.benchmark_group("process");
    group.sample_size(60);
    group.warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2)); // few kits: deleting thousands slows some disks down
    if Command::new("true").status().is_ok() {
        group.bench_function("empty program", |bencher| {
            bencher.iter(|| run(&mut Command::new("true")))
        });
    }
    group.bench_function("nonius --version", |bencher| {
        bencher.iter(|| run(nonius().arg("--version")))
    });
    let mut kits = 0_u32;
    for (place, folder) in &places() {
        for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
            let job = format!("fixtures/nine_errors_900/{controller}.toml");
            group.bench_function(format!("generate {controller}, {place}"), |bencher| {
                bencher.iter_batched(
                    || {
                        kits += 1; // every kit stays until the end: removing them is no work of the program
                        folder.path().join(format!("kit-{kits}"))
                    },
                    |kit| run(nonius().args(["generate", &job, "-o"]).arg(kit)),
                    criterion::BatchSize::PerIteration,
                );
            });
        }
    }
    group.finish();
}

criterion_group!(benches, processes);
criterion_main!(benches);
