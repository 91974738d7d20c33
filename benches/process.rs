//! The program as a process: `generate` beside an empty program in the same run.
//!
//! `true` is the empty program where the system has one; elsewhere compare with `--version`.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macro makes public functions; a benchmark may stop where its input is wrong"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::fs::File;
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn run(command: &mut Command) {
    let status = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// Waits until the disk has taken what earlier rounds left: their kits are removed between
/// rounds, and that is no work of the program that is timed.
fn settled(place: TempDir) -> TempDir {
    let handle = File::open(place.path()).and_then(|directory| directory.sync_all());
    handle.expect("a directory that can be synced");
    place
}

fn processes(criterion: &mut Criterion) {
    let nonius = || Command::new(env!("CARGO_BIN_EXE_nonius"));
    let folder = tempfile::tempdir().expect("a place to write to");
    let mut group = criterion.benchmark_group("process");
    group.sample_size(60);
    if Command::new("true").status().is_ok() {
        group.bench_function("empty program", |bencher| {
            bencher.iter(|| run(&mut Command::new("true")))
        });
    }
    group.bench_function("nonius --version", |bencher| {
        bencher.iter(|| run(nonius().arg("--version")))
    });
    for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
        let job = format!("fixtures/nine_errors_900/{controller}.toml");
        group.bench_function(format!("generate {controller}"), |bencher| {
            bencher.iter_batched(
                || settled(tempfile::tempdir_in(folder.path()).expect("a new directory")),
                |place| {
                    run(nonius()
                        .args(["generate", &job, "-o"])
                        .arg(place.path().join("kit")));
                    place
                },
                criterion::BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, processes);
criterion_main!(benches);
