//! Benchmarks of the main job; CONTRIBUTING.md has the figures and how to rerun them.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nonius::control::controller::{Role, builtin};
use nonius::inputs::error_table::ErrorTable;
use nonius::inputs::job::Job;
use nonius::kit::{Inputs, emulator, forecast, generate};
use nonius::quantity::{Direction, Millimetres};
use nonius::text::Source;
use nonius::visit::files::Memory;
use std::hint::black_box;

const JOB: &str = include_str!("../fixtures/nine_errors_900/siemens-840d-sl.toml");
const ERRORS: &str = include_str!("../fixtures/nine_errors_900/errors.csv");

/// The job of the shipped fixture for any control (a detection unit does no harm elsewhere).
fn job_text(controller: &str) -> String {
    JOB.replace("siemens-840d-sl", controller)
        .replace("[compensation.axes.y]", "detection_unit_um = 1.0\n[compensation.axes.y]")
        .replace("[compensation.axes.z]", "detection_unit_um = 1.0\n[compensation.axes.z]")
        .replace("[acceptance]", "detection_unit_um = 1.0\n[acceptance]")
}

/// From the bytes of the files to a complete kit.
fn inputs(job: &str, controller: &str) -> Inputs {
    let source = |name: &str, text: &str| Source::from_bytes(name, text.as_bytes()).expect("text");
    let job = Job::read(source("job.toml", job)).expect("a valid job");
    let table = ErrorTable::read(source("errors.csv", ERRORS)).expect("a valid table");
    let profile = builtin::profile(controller).expect("a built-in profile");
    Inputs::new(job, profile, &table, Vec::new()).expect("inputs that fit")
}

fn whole_job(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("whole job, 31 points an axis");
    for controller in builtin::ids() {
        let text = job_text(controller);
        group.bench_function(controller, |bencher| {
            bencher.iter(|| {
                let kit = generate(&inputs(black_box(&text), controller)).expect("a kit");
                kit.manifest_bytes().expect("a manifest")
            });
        });
    }
    group.finish();
}

/// One machine of many in one process: the same control, nearly the same job.
fn one_of_many(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("one of many, 840D sl");
    let inputs = inputs(JOB, "siemens-840d-sl");
    group.bench_function("kit", |bencher| bencher.iter(|| generate(black_box(&inputs))));
    let mut bare = inputs.clone();
    bare.profile.files.retain(|file| file.role != Role::Checklist);
    let name = "kit without its checklist";
    group.bench_function(name, |bencher| bencher.iter(|| generate(black_box(&bare))));
    group.bench_function("forecast", |bencher| bencher.iter(|| forecast(black_box(&inputs))));
    for words in
        ["generate job.toml -o kit", "generate job.toml -o kit --without-checklist --format json"]
    {
        group.bench_function(words, |bencher| {
            bencher.iter(|| {
                let all = [("job.toml", JOB.as_bytes()), ("errors.csv", ERRORS.as_bytes())];
                nonius::cli::answer(&Memory::of(all), words.split(' '))
            });
        });
    }
    group.finish();
}

/// One evaluation = the correction of one output axis at one position of one base axis.
fn emulation(criterion: &mut Criterion) {
    const POSITIONS: u32 = 10_000;
    let mut group = criterion.benchmark_group("emulator");
    group.throughput(Throughput::Elements(u64::from(POSITIONS)));
    for (controller, base, output) in [("siemens-840d-sl", "AX1", "AX2"), ("fanuc-30i", "1", "2")] {
        let kit = generate(&inputs(&job_text(controller), controller)).expect("a kit");
        let profile = builtin::profile(controller).expect("a built-in profile");
        let control = emulator(&profile, &kit.compiled.tables, &kit.compiled.state)
            .expect("an emulated control");
        let response = control.response(base, output, Direction::Plus).expect("a response");
        let positions: Vec<Millimetres> = (0..POSITIONS)
            .map(|k| Millimetres::new(f64::from(k * 7919 % POSITIONS) * 0.09))
            .collect();
        group.bench_function(controller, |bencher| {
            bencher.iter(|| positions.iter().map(|at| response.correction(*at).um()).sum::<f64>());
        });
    }
    group.finish();
}

criterion_group!(benches, whole_job, one_of_many, emulation);
criterion_main!(benches);
