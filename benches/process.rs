//! The program as a process: `generate` beside an empty program in the same run.
//!
//! `true` is the empty program where the system has one; elsewhere compare with `--version`.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macro makes public functions; a benchmark may stop where its input is wrong"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::process::{Command, Stdio};

fn run(command: &mut Command) {
    let status = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

fn processes(criterion: &mut Criterion) {
    let nonius = || Command::new(env!("CARGO_BIN_EXE_nonius"));
    let folder = tempfile::tempdir().expect("a place to write to");
    let mut kits = 0_u32;
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
                || {
                    kits += 1; // every kit stays until the end: removing them is no work of the program
                    folder.path().join(format!("kit-{kits}"))
                },
                |kit| run(nonius().args(["generate", &job, "-o"]).arg(kit)),
                criterion::BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, processes);
criterion_main!(benches);
