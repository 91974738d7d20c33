//! Random machines, some of them on purpose without shape, seeded.
use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use nonius::quantity::Axis;
use nonius::volume::space::grid_map::{AxisNode, GridMap};
use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Family {
    /// Slope and two waves, all orders of the chain.
    Smooth,
    /// A new number at every node.
    Noise,
    /// Translations only: a sum of three curves.
    Separable,
    /// Whole numbers from −2 to 2: many equal differences.
    Ties,
    /// Angles a hundred times larger than the translations.
    Angles,
    /// A large constant beside small errors.
    FarOff,
    Steps,
}

impl Family {
    pub(crate) const ALL: [Family; 7] = {
        use Family::*;
        [Smooth, Noise, Separable, Ties, Angles, FarOff, Steps]
    };
}

struct Numbers(ChaCha8Rng);

impl Numbers {
    /// −1…1.
    fn next(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    fn below(&mut self, n: u32) -> usize {
        (self.0.next_u32() % n) as usize
    }
}

fn curve(numbers: &mut Numbers, count: usize, family: Family, size: f64) -> Vec<f64> {
    let [slope, one, two, phase, far] = [(); 5].map(|()| numbers.next());
    let value = |n: usize, numbers: &mut Numbers| {
        let t = n as f64 / count as f64;
        let smooth = slope * t + 0.3 * one * (7.0 * t + phase).sin() + 0.1 * two * (19.0 * t).cos();
        match family {
            Family::Noise => numbers.next(),
            Family::Ties => (numbers.next() * 2.5).trunc(),
            Family::FarOff => 1000.0 * far + smooth,
            Family::Steps => (smooth * 4.0).round(),
            _ => smooth,
        }
    };
    (0..count).map(|n| size * value(n, numbers)).collect()
}

/// The order of the chain and its axes of up to 9 nodes.
pub(crate) fn axes(seed: u64, family: Family) -> ([Axis; 3], [Vec<AxisNode>; 3]) {
    axes_of(seed, family, 1..10)
}

/// The order of the chain and its axes of so many nodes.
pub(crate) fn axes_of(
    seed: u64,
    family: Family,
    nodes: Range<u32>,
) -> ([Axis; 3], [Vec<AxisNode>; 3]) {
    let mut numbers = Numbers(ChaCha8Rng::seed_from_u64(seed));
    let mut chain = Axis::ALL;
    chain.swap(0, numbers.below(3));
    chain.swap(1, 1 + numbers.below(2));
    let turns = match family {
        Family::Separable => 0.0,
        Family::Angles => 500.0,
        Family::Ties => 1.0,
        _ => 10.0,
    };
    let axes = [0, 1, 2].map(|_| {
        let count = nodes.start as usize + numbers.below(nodes.end - nodes.start);
        let size = if family == Family::Ties { 1.0 } else { 1.0 + 50.0 * numbers.next().abs() };
        let vectors = |numbers: &mut Numbers, size: f64| {
            let curves = [(); 3].map(|()| curve(numbers, count, family, size));
            move |n: usize| [curves[0][n], curves[1][n], curves[2][n]]
        };
        let start = if family == Family::Ties { -1.0 } else { numbers.next() };
        let step = if family == Family::Ties { 1.0 } else { 0.3 };
        let (shift, turn) = (vectors(&mut numbers, size), vectors(&mut numbers, turns));
        let node = |n: usize| AxisNode {
            translation_um: shift(n),
            rotation_urad: turn(n),
            arm_m: start + step * n as f64,
        };
        (0..count).map(node).collect()
    });
    (chain, axes)
}

pub(crate) fn random_map(seed: u64, family: Family) -> GridMap {
    let (chain, axes) = axes(seed, family);
    GridMap::new(chain, &axes).expect("a sound map")
}
