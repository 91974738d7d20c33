//! The page of a whole visit, n = 40: readings → nine errors, tables read back, volume, pictures, HTML; as a process, so
//! what it prints goes nowhere. docs/performance.md has the figure.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macro makes public functions; a benchmark may stop where its input is wrong"
)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const JOB: &str = include_str!("../fixtures/start/readings/job.toml");
const STEPS: usize = 40;

/// The job to start from with ten times as many steps and points.
fn job() -> String {
    let wider = [
        ("steps = 4 ", "steps = 40 "),
        ("spacing_mm = 100.0", "spacing_mm = 10.0"),
        ("spacing_mm = 75.0", "spacing_mm = 7.5"),
        ("spacing_mm = 50.0", "spacing_mm = 5.0"),
    ];
    wider
        .into_iter()
        .fold(JOB.to_string(), |text, (old, new)| text.replace(old, new))
}

/// Readings that rise and bend; no machine's.
fn readings() -> String {
    let mut text = "diagonal,run,direction,node,moved,deviation_um\n".to_string();
    for diagonal in ["PPP", "NPP", "PNP", "PPN"] {
        for node in 0..=3 * STEPS {
            let moved = match node {
                0 => "",
                node => ["x", "y", "z"][(node - 1) % 3],
            };
            let um = 0.1 * node as f64 + (node as f64 / 9.0).sin();
            writeln!(text, "{diagonal},1,forward,{node},{moved},{um:.3}").expect("text");
        }
    }
    text
}

fn write_page(folder: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    let command = command.current_dir(folder);
    let command = command.args(["report", "job.toml", "-q", "--force", "-o", "page.html"]);
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    let status = status.expect("the program runs");
    assert!(status.code().is_some_and(|code| code < 2));
}

fn report(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a place to write to");
    std::fs::write(folder.path().join("job.toml"), job()).expect("a job");
    std::fs::write(folder.path().join("readings.csv"), readings()).expect("readings");
    criterion.bench_function("report of readings, n = 40", |bencher| {
        bencher.iter(|| write_page(folder.path()));
    });
}

criterion_group!(benches, report);
criterion_main!(benches);
