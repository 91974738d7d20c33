//! The extremes of a path against what is found by dense sampling.
use super::*;
use crate::quantity::{Axis, PerAxis};
use crate::volume::volume_model::AxisState;
use part_program::{Arc, Move, Place, Plane, Shape};
use proptest::prelude::*;

fn state(deviation_um: [f64; 3], rotation_urad: [f64; 3]) -> AxisState {
    let vector = |[x, y, z]: [f64; 3]| PerAxis { x, y, z };
    AxisState { deviation_um: vector(deviation_um), rotation_urad: vector(rotation_urad) }
}

/// A machine of straight curves whose levers count from zero.
fn linear(nodes: [Vec<f64>; 3], state: impl Fn(Axis, f64) -> AxisState) -> PathMap {
    let [x, y, z] = nodes;
    PathMap::new(Axis::ALL, &PerAxis { x, y, z }, PerAxis::default(), false, state)
}

/// Three axes with nodes at 0, 10 … 40 and values from a list.
fn machine(values: &[f64], order: [Axis; 3], cubic: bool) -> PathMap {
    let nodes = || (0..5_u8).map(|node| f64::from(node) * 10.0).collect::<Vec<f64>>();
    let table = |axis: usize, what: usize, node: usize| {
        values[(axis * 30 + what * 5 + node) % values.len()]
    };
    let at = |axis: usize, what: usize, position: f64| {
        let u = (position / 10.0).clamp(0.0, 3.999_999_999_999);
        let node = [0.0, 1.0, 2.0, 3.0].iter().filter(|n| **n <= u).count() - 1;
        let inside = position.clamp(0.0, 40.0) / 10.0 - [0.0, 1.0, 2.0, 3.0][node];
        let smooth = if cubic { inside * inside * (3.0 - 2.0 * inside) } else { inside };
        let (low, high) = (table(axis, what, node), table(axis, what, node + 1));
        low + smooth * (high - low)
    };
    let nodes = PerAxis { x: nodes(), y: nodes(), z: nodes() };
    let origins = PerAxis { x: 5.0, y: 0.0, z: -3.0 };
    PathMap::new(order, &nodes, origins, cubic, |axis, position| {
        let six = [0, 1, 2, 3, 4, 5].map(|what| at(axis as usize, what, position));
        state([six[0], six[1], six[2]], [six[3], six[4], six[5]].map(|urad| urad * 300.0))
    })
}

fn limits() -> ProfileLimits {
    ProfileLimits {
        chord_mm: 0.001,
        sample_mm: 1e4,
        rapid: false,
        measured_tool_mm: 0.0,
        measured: [Some((0.0, 40.0)); 3],
        travel: [None; 3],
        refuse_outside: false,
    }
}

fn line(from: Place, to: Place) -> Move {
    Move {
        from,
        to,
        shape: Shape::Line,
        rapid: false,
        plane: Plane::Xy,
        tool_mm: None,
        line: 7,
        hole: None,
    }
}

fn followed(map: &PathMap, limits: ProfileLimits, step: &Move) -> Summary {
    let mut profile = Profile::new(map, limits);
    profile.follow(step, &mut |_| {}).expect("it can be followed");
    profile.summary()
}

/// The five channels by sampling: smallest and largest.
fn sampled(map: &PathMap, step: &Move, count: u32) -> [(f64, f64); 4] {
    let mut found = [(f64::INFINITY, f64::NEG_INFINITY); 4];
    for sample in 0..=count {
        let [x, y, z] = map.error_at(step.at(f64::from(sample) / f64::from(count)), 0.0);
        let values = [x, y, z, (x * x + y * y + z * z).sqrt()];
        for (range, value) in found.iter_mut().zip(values) {
            *range = (range.0.min(value), range.1.max(value));
        }
    }
    found
}

fn compared(map: &PathMap, step: &Move) -> Result<(), TestCaseError> {
    let summary = followed(map, limits(), step);
    let dense = sampled(map, step, 4000);
    for (channel, (min, max)) in
        [Channel::X, Channel::Y, Channel::Z, Channel::Length].into_iter().zip(dense)
    {
        let range = summary.range(channel).expect("a range");
        let (low, high) = (range.min.um, range.max.um);
        let room = 1e-9 * (1.0 + max.abs().max(min.abs()));
        prop_assert!(high >= max - room, "{channel:?}: {high} < {max}");
        // Between two samples of a kink the path may be this much further.
        prop_assert!(high <= max + 0.1, "{channel:?}: {high} > {max}");
        prop_assert!(low <= min + room, "{channel:?}: {low} > {min}");
        let [x, y, z] = map.error_at(range.max.place, 0.0);
        let there = [x, y, z, 0.0, 0.0, (x * x + y * y + z * z).sqrt()];
        let index = Channel::ALL.iter().position(|c| *c == channel).expect("a channel");
        prop_assert!((there[index] - high).abs() < 1e-9 * (1.0 + high.abs()));
    }
    Ok(())
}

fn place() -> impl Strategy<Value = Place> {
    [-5.0..45.0, -5.0..45.0, -5.0..45.0_f64]
}

proptest! {
    #[test]
    fn straight_moves_have_exact_extremes(
        values in proptest::collection::vec(-5.0..5.0_f64, 90),
        from in place(),
        to in place(),
        order in proptest::sample::select(vec![Axis::ORDERS[0], Axis::ORDERS[2], Axis::ORDERS[5]]),
        cubic in any::<bool>(),
    ) {
        compared(&machine(&values, order, cubic), &line(from, to))?;
    }
}

#[test]
fn a_parabola_between_nodes_is_found() {
    // ECX = x µrad per mm, arm y = 30 − x on the move: e_x = −ECX·y/1000 has its vertex at x = 15.
    let map = linear([vec![0.0, 30.0], vec![0.0, 30.0], vec![0.0]], |axis, x| {
        state([0.0; 3], [0.0, 0.0, if axis == Axis::X { x } else { 0.0 }])
    });
    let summary = followed(&map, limits(), &line([0.0, 30.0, 0.0], [30.0, 0.0, 0.0]));
    let least = summary.range(Channel::X).expect("a range").min;
    assert!((least.um + 0.225).abs() < 1e-12, "{}", least.um);
    assert!((least.place[0] - 15.0).abs() < 1e-9);
    assert_eq!(least.line, 7);
}

#[test]
fn tool_length_swings_with_every_axis() {
    let map = linear([vec![0.0], vec![0.0], vec![0.0]], |axis, _| {
        state([0.0; 3], [0.0, if axis == Axis::Z { 10.0 } else { 0.0 }, 0.0])
    });
    // EBZ = 10 µrad × 100 mm below: the tip goes 1 µm towards −X.
    assert!((map.error_at([0.0; 3], 100.0)[0] + 1.0).abs() < 1e-12);
}

#[test]
fn a_circle_is_followed_within_its_tolerance() {
    // ex = x/10 µm: on a circle of 10 mm around 0 the largest is 1 µm.
    let map = linear([vec![-50.0, 50.0], vec![0.0], vec![0.0]], |axis, x| {
        state([if axis == Axis::X { x / 10.0 } else { 0.0 }, 0.0, 0.0], [0.0; 3])
    });
    let mut step = line([0.0, 10.0, 0.0], [0.0, 10.0, 0.0]);
    step.shape = Shape::Arc(Arc {
        centre: [0.0, 0.0],
        from_rad: std::f64::consts::FRAC_PI_2,
        sweep_rad: std::f64::consts::TAU,
        radius: [10.0, 10.0],
    });
    let summary = followed(&map, limits(), &step);
    let most = summary.range(Channel::X).expect("a range").max.um;
    assert!((most - 1.0).abs() < 2e-4, "{most}");
    assert!((summary.length_mm - 20.0 * std::f64::consts::PI).abs() < 0.01);
    // Along the path and across it: ex·cos, ex·sin of the circle.
    let normal = summary.range(Channel::Normal).expect("a range");
    assert!((normal.min.um + 1.0).abs() < 2e-3 && normal.max.um.abs() < 2e-3);
}

#[test]
fn what_was_probed_is_the_datum() {
    let map = machine(&[1.0, 2.0, 4.0, -3.0, 0.5, 7.0, 1.5], Axis::ALL, false);
    let (a, b) = ([3.0, 4.0, 5.0], [30.0, 20.0, 10.0]);
    let (at_a, at_b) = (map.error_at(a, 0.0), map.error_at(b, 0.0));
    let zeroed = map.zeroed_at(&[a, b]);
    for k in 0..3 {
        let expected = (at_a[k] - at_b[k]) / 2.0;
        assert!((zeroed.error_at(a, 0.0)[k] - expected).abs() < 1e-12);
    }
}

#[test]
fn places_outside_the_measured_range_are_named_or_refused() {
    let map = machine(&[1.0], Axis::ALL, false);
    let step = line([0.0; 3], [50.0, 0.0, 0.0]);
    let summary = followed(&map, limits(), &step);
    assert_eq!(summary.outside.len(), 1);
    assert_eq!(summary.outside[0].reached_mm, (50.0, 50.0));
    let refuse = ProfileLimits { refuse_outside: true, ..limits() };
    assert!(Profile::new(&map, refuse).follow(&step, &mut |_| {}).is_err());
    let travel = ProfileLimits { travel: [Some((0.0, 45.0)), None, None], ..limits() };
    assert!(Profile::new(&map, travel).follow(&step, &mut |_| {}).is_err());
}
