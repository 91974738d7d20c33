//! Benchmarks of the main job; see docs/performance.md.

fn main() {}
