//! The page of a whole visit, n = 40: files of readings → nine errors, tables read back, volume, pictures, HTML; in
//! process, and as a process, so what it prints goes nowhere. CONTRIBUTING.md has the figures.

use criterion::{Criterion, criterion_group, criterion_main};
use nonius::cli::run;
use std::ffi::OsString;
use std::fmt::Write;
use std::hint::black_box;
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
    wider.into_iter().fold(JOB.to_string(), |text, (old, new)| text.replace(old, new))
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

fn arguments(folder: &Path) -> [OsString; 7] {
    let [job, page] = ["job.toml", "page.html"].map(|name| folder.join(name).into_os_string());
    let words = ["nonius", "report", "-q", "--force", "-o"].map(OsString::from);
    let [program, report, quiet, force, output] = words;
    [program, report, quiet, force, job, output, page]
}

/// Files, command line and verdict included.
fn write_in_process(folder: &Path) {
    run(black_box(arguments(folder)));
}

fn write_page(folder: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    let command = command.args(&arguments(folder)[1..]);
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    let status = status.expect("the program runs");
    assert!(status.code().is_some_and(|code| code < 2));
}

fn report(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a place to write to");
    std::fs::write(folder.path().join("job.toml"), job()).expect("a job");
    std::fs::write(folder.path().join("readings.csv"), readings()).expect("readings");
    let mut group = criterion.benchmark_group("report of readings, n = 40");
    group.bench_function("process", |bencher| {
        bencher.iter(|| write_page(folder.path()));
    });
    group.bench_function("in process", |bencher| {
        bencher.iter(|| write_in_process(folder.path()));
    });
    group.finish();
}

criterion_group!(benches, report);
criterion_main!(benches);
