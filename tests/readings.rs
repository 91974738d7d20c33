//! Readings of the body diagonals: what is read from them, and what is refused in which words.
#![allow(
    clippy::expect_used,
    clippy::float_cmp,
    reason = "a test that cannot go on has to stop; numbers that are only read stay what they are"
)]

use nonius::axis::{Axis, Direction, PerAxis};
use nonius::diagonal::{Diagonal, Pass, PathKind, Run, Volume};
use nonius::document::Source;
use nonius::job::{DiagonalMeasurement, Job, MeasuredData};
use nonius::readings::Readings;
use nonius::units::Millimetres;
use std::fs;
use std::path::{Path, PathBuf};

fn golden(case: &str) -> (DiagonalMeasurement, Readings) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals");
    let source = |file: &str| -> Source {
        let path: PathBuf = folder.join(case).join(file);
        Source::from_bytes(file, &fs::read(path).expect("it is there")).expect("it is text")
    };
    let job = Job::read(source("job.toml")).expect("it is a job");
    let MeasuredData::Diagonals(measurement) = job.measurement.data else {
        panic!("{case} has no readings");
    };
    let readings = Readings::read(source(&measurement.readings), &measurement);
    (
        measurement.clone(),
        readings.expect("the readings are complete"),
    )
}

fn find(readings: &Readings, diagonal: Diagonal, number: u32, pass: Pass) -> &Run {
    let wanted = |run: &&Run| (run.diagonal, run.number, run.pass) == (diagonal, number, pass);
    readings.runs.iter().find(wanted).expect("the run is there")
}

#[test]
fn the_golden_readings_are_read_completely() {
    for (case, steps, runs) in [
        ("case_a_ideal", 30, 4),
        ("case_b_setup", 30, 4),
        ("case_c_angles", 30, 4),
        ("case_c2_mirror", 30, 4),
        ("case_d_bidirectional", 10, 24),
    ] {
        let (measurement, readings) = golden(case);
        assert_eq!(measurement.volume.steps, steps, "{case}");
        assert_eq!(readings.runs.len(), runs, "{case}");
        for run in &readings.runs {
            assert_eq!(
                run.deviations.len(),
                3 * steps + 1,
                "{case} {}",
                run.diagonal
            );
            assert_eq!(run.temperatures_c, PerAxis::default());
            assert!(readings.offset_known(run));
        }
    }
}

#[test]
fn a_reading_stands_at_its_node() {
    let (_, readings) = golden("case_a_ideal");
    let run = find(&readings, Diagonal::Ppp, 1, Pass::Forward);
    assert_eq!(run.deviations[0].um(), 0.0);
    assert_eq!(run.deviations[2].um(), 1.591414825);
    let (_, readings) = golden("case_d_bidirectional");
    let run = find(&readings, Diagonal::Ppp, 1, Pass::Reverse);
    assert_eq!(run.deviations[0].um(), -6.4112);
    assert_eq!(run.deviations[7].um(), 2.5334);
}

#[test]
fn linear_measurements_of_the_job_are_read() {
    let (measurement, _) = golden("case_b_setup");
    let axes: Vec<Axis> = measurement.linear.iter().map(|l| l.axis).collect();
    assert_eq!(axes, Axis::ALL);
}
