//! Volumetric accuracy of machine H; CONTRIBUTING.md has the figures and how to rerun them.

#[path = "../tests/support/machine_h.rs"]
mod machine_h;

use criterion::{Criterion, criterion_group, criterion_main};
use machine_h::machine_h;
use nonius::volume::space::boxes::Boxes;
use nonius::volume::space::diameter;
use nonius::volume::space::diameter::WindowMap;
use nonius::volume::space::diameter::diameter;
use nonius::volume::space::grid_map::Vector;
use nonius::volume::space::histogram::{Tolerance, estimate, exact, grouping};
use nonius::volume::space::pair::square;
use std::hint::black_box;

/// Every pair, one after the other.
fn all_pairs(vectors: &[Vector]) -> f64 {
    let mut longest = 0.0;
    for (n, p) in vectors.iter().enumerate() {
        for q in &vectors[n + 1..] {
            let square = square(p, q);
            if square > longest {
                longest = square;
            }
        }
    }
    longest.sqrt()
}

fn volumetric(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("volumetric");
    for n in [21, 101, 201, 401] {
        let map = machine_h([n; 3]);
        group.bench_function(format!("diameter, {n} nodes an axis"), |bencher| {
            bencher.iter(|| diameter(black_box(&map)))
        });
    }
    for n in [21, 101, 401] {
        let map = machine_h([n; 3]);
        let widest = diameter(&map);
        group.bench_function(format!("length error and ranges, {n} nodes an axis"), |bencher| {
            bencher.iter(|| {
                let boxes = Boxes::of(black_box(&map));
                (boxes.length_error(&widest, 200_000), boxes.ranges())
            })
        });
    }
    let map = machine_h([21; 3]);
    let vectors = map.vectors();
    group.bench_function("cloud, 21 nodes an axis", |bencher| {
        bencher.iter(|| diameter::longest(black_box(&vectors)))
    });
    group.sample_size(10);
    group.bench_function("all pairs, 21 nodes an axis", |bencher| {
        bencher.iter(|| all_pairs(black_box(&vectors)))
    });
    for angular in [0.05, 0.1, 0.2] {
        let tolerance = Tolerance { angular, magnitude: 0.9 };
        group.bench_function(format!("grouping {angular}, 21 nodes an axis"), |bencher| {
            bencher.iter(|| grouping(black_box(&vectors), tolerance))
        });
    }
    group.bench_function("1331 windows of 11 nodes, 21 nodes an axis", |bencher| {
        bencher.iter(|| WindowMap::of(black_box(&map), [11; 3]))
    });
    for threads in [1, 2] {
        group
            .bench_function(format!("histogram, 21 nodes an axis, {threads} threads"), |bencher| {
                bencher.iter(|| exact(black_box(&vectors), 10.0, threads))
            });
    }
    let large = machine_h([101; 3]);
    group.bench_function("estimated histogram, 101 nodes an axis, 1 million pairs", |bencher| {
        bencher.iter(|| estimate(black_box(&large), 10.0, 1_000_000, 1502))
    });
    let vectors = large.vectors();
    group.bench_function("cloud, 101 nodes an axis", |bencher| {
        bencher.iter(|| diameter::longest(black_box(&vectors)))
    });
    group.finish();
}

criterion_group!(benches, volumetric);
criterion_main!(benches);
