//! Separation of step diagonals, n = 30; CONTRIBUTING.md has the figures and how to rerun them.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nonius::inputs::job::{DiagonalMeasurement, Job, LinearSlope, MeasuredData};
use nonius::inputs::readings::Readings;
use nonius::machine::separation::corrections::AngleEffects;
use nonius::machine::separation::monte_carlo::{Trials, simulate};
use nonius::machine::separation::{Campaign, MeasuredLine, separate};
use nonius::quantity::{Deviation, PerAxis, Run};
use nonius::text::Source;
use nonius::visit::files::Memory;
use std::hint::black_box;
use std::io::{BufRead, BufReader, Lines, Write};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

const JOB: &[u8] = include_bytes!("../fixtures/diagonals/case_b_setup/job.toml");
const READINGS: &[u8] = include_bytes!("../fixtures/diagonals/case_b_setup/readings.csv");

/// Trials of one sample, here and in the numpy script.
const TRIALS: u64 = 4000;

fn measurement() -> DiagonalMeasurement {
    let source = Source::from_bytes("job.toml", JOB).expect("a text");
    let job = Job::read(source).expect("a job");
    match job.measurement.data {
        MeasuredData::Diagonals(measurement) => measurement,
        _ => panic!("the job has readings"),
    }
}

fn lines(measurement: &DiagonalMeasurement) -> Vec<MeasuredLine> {
    let stated = |linear: &nonius::inputs::job::Linear| match linear.slope {
        LinearSlope::Stated(slope_um_per_m) => Some(MeasuredLine {
            direction: PerAxis::from_fn(|axis| f64::from(axis == linear.axis)),
            slope_um_per_m,
            u_um_per_m: linear.u_um_per_m,
            ends: None,
        }),
        LinearSlope::Errors(_) | LinearSlope::NotYet => None,
    };
    measurement.linear.iter().filter_map(stated).collect()
}

/// Readings of a real instrument scatter: about 0.2 µm, the same in every run of the benchmark.
fn disturb(runs: &mut [Run]) {
    let mut place = 0.0_f64;
    for deviation in runs.iter_mut().flat_map(|run| &mut run.deviations) {
        place += 1.0;
        let scatter = 0.3 * (place * place * 12.9898).sin();
        *deviation = Deviation::from_um(deviation.um() + scatter);
    }
}

fn separation(criterion: &mut Criterion) {
    let measurement = measurement();
    let source = Source::from_bytes("readings.csv", READINGS).expect("a text");
    let mut runs = Readings::read(source, &measurement).expect("readings").runs;
    disturb(&mut runs);
    let campaign = Campaign {
        measurement: &measurement,
        stated: nonius::inputs::job::StatedUncertainty::default(),
        lines: lines(&measurement),
        reversals: Default::default(),
        angles: AngleEffects::unmeasured(None),
        reverse_zero_known: true,
    };
    let whole = separate(&campaign, &runs);
    let mut group = criterion.benchmark_group("separation");
    group.bench_function("separate, one forward run", |bencher| {
        bencher.iter(|| separate(black_box(&campaign), black_box(&runs)))
    });
    group.sample_size(10);
    group.throughput(Throughput::Elements(TRIALS));
    let plan = Trials { trials: 4000, seed: 1502 };
    group.bench_function("Monte Carlo, 4000 trials", |bencher| {
        bencher.iter(|| simulate(black_box(&whole), plan, || ()))
    });
    match Numpy::start() {
        Some(mut numpy) => {
            group.bench_function("numpy, 4000 simpler trials, one process", |bencher| {
                bencher.iter_custom(|batches| numpy.time(batches))
            });
        }
        None => tell("no python3 with numpy here: the comparison with numpy is left out"),
    }
    group.finish();
}

fn tell(line: &str) {
    eprintln!("{line}");
}

/// From the files of a job to its answer; case B has one forward run, case D both directions.
fn answered(criterion: &mut Criterion) {
    let of_both = [
        include_bytes!("../fixtures/diagonals/case_d_bidirectional/job.toml").as_slice(),
        include_bytes!("../fixtures/diagonals/case_d_bidirectional/readings.csv"),
    ];
    let mut group = criterion.benchmark_group("separate in process");
    for (case, [job, readings]) in [("B", [JOB, READINGS]), ("D", of_both)] {
        for options in ["--trials 0", "--trials 2000", "--trials 0 -o errors.csv"] {
            let command = format!("separate job.toml {options}");
            group.bench_function(format!("case {case}, {options}"), |bencher| {
                bencher.iter(|| {
                    let files = Memory::of([("job.toml", job), ("readings.csv", readings)]);
                    nonius::cli::answer(&files, command.split(' '))
                });
            });
        }
    }
    group.finish();
}

/// `benches/monte_carlo_numpy.py`, which times its own batches.
struct Numpy {
    batches: ChildStdin,
    seconds: Lines<BufReader<ChildStdout>>,
}

impl Numpy {
    fn start() -> Option<Numpy> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/monte_carlo_numpy.py");
        let mut child = Command::new("python3")
            .arg(script)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut seconds = BufReader::new(child.stdout.take()?).lines();
        tell(&seconds.next()?.ok()?);
        let batches = child.stdin.take()?;
        Some(Numpy { batches, seconds })
    }

    fn time(&mut self, batches: u64) -> Duration {
        writeln!(self.batches, "{batches}").expect("python3 takes a number");
        let line = self.seconds.next().expect("an answer").expect("a line");
        Duration::from_secs_f64(line.parse().expect("seconds"))
    }
}

criterion_group!(benches, separation, answered);
criterion_main!(benches);
