//! Benchmarks of `nonius path`: the error at points of a path, and a program from end to end.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nonius::quantity::{Axis, PerAxis};
use nonius::volume::tool_path::{PathMap, Profile, ProfileLimits};
use nonius::volume::volume_model::AxisState;
use part_program::{Line, Mark, Move, Plane, Refused, Setup, Shape, Text, run};
use std::fmt::Write;
use std::hint::black_box;

const LINES: u32 = 200_000;

/// A machine of 900 mm with 31 nodes an axis and all eighteen curves.
fn machine() -> PathMap {
    let nodes = || (0..31_u8).map(|node| f64::from(node) * 30.0).collect::<Vec<f64>>();
    let nodes = PerAxis { x: nodes(), y: nodes(), z: nodes() };
    PathMap::new(Axis::ALL, &nodes, PerAxis::default(), false, |axis, x| {
        let shift = [0.3, 1.1, 2.7][axis as usize];
        let wave = |k: f64| 5.0 * (x / 97.0 * k + shift).sin();
        AxisState {
            deviation_um: PerAxis { x: wave(1.0), y: wave(1.7), z: wave(2.3) },
            rotation_urad: PerAxis { x: wave(0.7), y: wave(1.3), z: wave(1.9) },
        }
    })
}

fn limits(sample_mm: f64) -> ProfileLimits {
    ProfileLimits {
        chord_mm: 0.001,
        sample_mm,
        rapid: false,
        measured_tool_mm: 0.0,
        measured: [Some((0.0, 900.0)); 3],
        travel: [Some((0.0, 900.0)); 3],
        refuse_outside: true,
    }
}

/// 200 000 lines, about 7 MB.
fn program() -> String {
    let mut text = String::from("G21 G90 G17 G0 X450. Y450. Z450.\nF2000\n");
    for line in 0..LINES {
        let t = f64::from(line) * 0.001;
        let (x, y, z) =
            (450.0 + 200.0 * t.cos(), 450.0 + 200.0 * t.sin(), 450.0 + 100.0 * (t * 0.1).sin());
        let _ = writeln!(text, "N{line} G1 X{x:.4} Y{y:.4} Z{z:.4}");
    }
    text
}

struct Bytes<'a> {
    text: &'a [u8],
    mark: Mark,
}

impl Text for Bytes<'_> {
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused> {
        let rest = &self.text
            [usize::try_from(self.mark.bytes).unwrap_or(usize::MAX).min(self.text.len())..];
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            return Ok(None);
        };
        self.mark.bytes += end as u64 + 1;
        self.mark.lines += 1;
        Ok(Some(Line { number: self.mark.lines, bytes: &rest[..end] }))
    }
    fn mark(&self) -> Mark {
        self.mark
    }
    fn go_to(&mut self, mark: Mark) -> Result<(), Refused> {
        self.mark = mark;
        Ok(())
    }
}

fn points(criterion: &mut Criterion) {
    const POINTS: u32 = 1_000_000;
    let map = machine();
    let mut group = criterion.benchmark_group("path");
    group.throughput(Throughput::Elements(u64::from(POINTS)));
    group.bench_function("a million points on a diagonal", |bencher| {
        bencher.iter(|| {
            let step = Move {
                from: [0.0; 3],
                to: [900.0; 3],
                shape: Shape::Line,
                rapid: false,
                plane: Plane::Xy,
                tool_mm: None,
                line: 1,
                hole: None,
            };
            let length = step.length_mm();
            let mut profile = Profile::new(&map, limits(length / f64::from(POINTS)));
            profile.follow(black_box(&step), &mut |_| {}).expect("inside");
            profile.summary()
        });
    });
    group.finish();
}

fn whole_program(criterion: &mut Criterion) {
    let (map, text) = (machine(), program());
    let mut setup = Setup::at([0.0; 3]);
    setup.systems.insert(1, [0.0; 3]);
    let mut group = criterion.benchmark_group("path, program");
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("200 000 lines", |bencher| {
        bencher.iter(|| {
            let mut profile = Profile::new(&map, limits(1.0));
            let mut bytes = Bytes { text: text.as_bytes(), mark: Mark::default() };
            run(&mut bytes, &setup, |step| profile.follow(step, &mut |_| {})).expect("a program");
            profile.summary()
        });
    });
    group.finish();
}

criterion_group!(benches, points, whole_program);
criterion_main!(benches);
