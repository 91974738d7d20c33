use super::*;
use proptest::prelude::*;

const MAX: u32 = 32767;

/// Generated cases: 400 where simulations are asked for (.ci/run).
fn cases(few: u32) -> ProptestConfig {
    let asked = std::env::var_os("NONIUS_SIMULATIONS").is_some();
    ProptestConfig::with_cases(if asked { 400 } else { few })
}

fn fit(wanted: &[f64], reference: usize) -> FourPoint {
    let best = best_fit(wanted, reference, MAX).expect("a fit");
    assert_admissible(&best, wanted, reference);
    best
}

/// Everything promised but being the best.
fn assert_admissible(best: &FourPoint, wanted: &[f64], reference: usize) {
    let last = wanted.len() - 1;
    assert_eq!((best.nodes[0], best.nodes[3]), (0, last), "{best:?}");
    assert!(best.nodes.is_sorted(), "{best:?}");
    for at in 0..3 {
        let same_node = best.nodes[at] == best.nodes[at + 1];
        assert!(!same_node || best.amounts[at] == best.amounts[at + 1], "{best:?}");
    }
    let knot = best.nodes.iter().position(|&node| node == reference);
    assert_eq!(best.amounts[knot.expect("the reference is a point")], 0, "{best:?}");
    assert!((best.residual - left(best, wanted)).abs() <= 0.0, "{best:?}");
}

/// What the control puts out at a node; held outside the points.
fn output(points: &FourPoint, node: usize) -> i64 {
    let knot = |index: usize| (points.nodes[index], points.amounts[index]);
    match points.nodes.partition_point(|&point| point < node) {
        0 => points.amounts[0],
        4 => points.amounts[3],
        next => whole(output_between(knot(next - 1), knot(next), node)),
    }
}

fn left(points: &FourPoint, wanted: &[f64]) -> f64 {
    let distance = |(node, wanted): (usize, &f64)| (output(points, node) as f64 - wanted).abs();
    wanted.iter().enumerate().map(distance).fold(0.0, f64::max)
}

fn shape(nodes: [usize; 4], amounts: [i64; 4]) -> Vec<f64> {
    let points = FourPoint { nodes, amounts, residual: 0.0 };
    (0..=nodes[3]).map(|node| output(&points, node) as f64).collect()
}

/// All nodes in their order, distinct or not, and all amounts up to `most`: the least residual.
fn brute_force(wanted: &[f64], reference: usize, most: i64) -> f64 {
    let last = wanted.len() - 1;
    let mut least = f64::INFINITY;
    let pairs = (0..=last).flat_map(|b| (b..=last).map(move |c| (b, c)));
    for nodes in pairs.map(|(b, c)| [0, b, c, last]).filter(|nodes| nodes.contains(&reference)) {
        let mut lists: Vec<[i64; 4]> = vec![[0; 4]];
        for knot in 0..4 {
            let range = if nodes[knot] == reference { 0..=0 } else { -most..=most };
            let with = |list: &[i64; 4], amount| {
                let mut list = *list;
                list[knot] = amount;
                list
            };
            let fits = |list: &[i64; 4]| {
                knot == 0 || nodes[knot] != nodes[knot - 1] || list[knot] == list[knot - 1]
            };
            lists = lists.iter().flat_map(|list| range.clone().map(|x| with(list, x))).collect();
            lists.retain(fits);
        }
        for amounts in lists {
            let points = FourPoint { nodes, amounts, residual: 0.0 };
            least = least.min(left(&points, wanted));
        }
    }
    least
}

fn negated(wanted: &[f64]) -> Vec<f64> {
    wanted.iter().map(|amount| -amount).collect()
}

fn mirrored(wanted: &[f64]) -> Vec<f64> {
    wanted.iter().rev().copied().collect()
}

#[test]
fn three_pieces_are_found_from_either_end_and_from_inside() {
    let cases = [
        ([0, 4, 9, 15], [0, 13, -7, 20], 0),
        ([0, 4, 9, 15], [31, -13, 7, 0], 15),
        ([0, 4, 9, 15], [31, 0, 17, -40], 4),
        ([0, 4, 9, 15], [31, 8, 0, -40], 9),
    ];
    for (nodes, amounts, reference) in cases {
        let best = fit(&shape(nodes, amounts), reference);
        assert!(best.residual <= 0.0, "{best:?}");
        assert_eq!(best.nodes, nodes);
        assert_eq!(best.amounts, amounts);
    }
}

#[test]
fn the_line_is_rounded_half_away_from_zero() {
    let points = FourPoint { nodes: [0, 2, 4, 6], amounts: [0, 1, -2, -7], residual: 0.0 };
    let outputs: Vec<i64> = (0..8).map(|node| output(&points, node)).collect();
    assert_eq!(outputs, [0, 1, 1, -1, -2, -5, -7, -7]);
}

#[test]
fn straight_lines_leave_nothing() {
    for reference in [0_usize, 3, 10] {
        let wanted: Vec<f64> =
            (0..=10).map(|node| 3.0 * (f64::from(node) - reference as f64)).collect();
        let best = fit(&wanted, reference);
        assert!(best.residual <= 0.0, "{best:?}");
        let distinct = best.nodes.windows(2).all(|pair| pair[0] < pair[1]);
        assert!(distinct, "{best:?}");
    }
}

#[test]
fn a_point_is_repeated_only_where_fewer_pieces_are_better() {
    let best = fit(&[0.0, 1.0, 0.0, 0.0, -1.0], 0);
    assert_eq!(best.nodes, [0, 1, 4, 4]);
    assert_eq!(best.amounts, [0, 1, -1, -1]);
    assert!(best.residual <= 0.0);
    assert_eq!(fit(&[0.0; 9], 0).nodes, [0, 1, 2, 8]);
    assert_eq!(fit(&[0.0; 9], 8).nodes, [0, 1, 2, 8]);
    assert_eq!(fit(&[0.0; 9], 5).nodes, [0, 1, 5, 8]);
    assert_eq!(fit(&[0.0; 9], 1).nodes, [0, 1, 2, 8]);
}

#[test]
fn fewer_than_four_nodes_repeat_the_last() {
    assert_eq!(fit(&[0.0, 5.0], 0).nodes, [0, 1, 1, 1]);
    assert_eq!(fit(&[5.0, 0.0], 1).amounts, [5, 0, 0, 0]);
    let best = fit(&[4.0, 0.0, -9.0], 1);
    assert_eq!((best.nodes, best.amounts), ([0, 1, 2, 2], [4, 0, -9, -9]));
}

#[test]
fn amounts_stay_within_the_controls() {
    let best = best_fit(&[0.0, 50.0, 90.0, 120.0, 200.0], 0, 100).expect("a fit");
    assert_eq!(best.amounts[3], 100);
    assert!((best.residual - 100.0).abs() <= 0.0);
    assert!(best_fit(&[0.0, 50.0], 0, 0).is_some_and(|best| best.amounts == [0; 4]));
}

#[test]
fn what_cannot_be_fitted_is_none() {
    assert_eq!(best_fit(&[], 0, MAX), None);
    assert_eq!(best_fit(&[0.0], 0, MAX), None);
    assert_eq!(best_fit(&[0.0, 1.0], 2, MAX), None);
    assert_eq!(best_fit(&[0.0, 1.0], 1, MAX), None);
    assert_eq!(best_fit(&[0.0, f64::NAN], 0, MAX), None);
    assert_eq!(best_fit(&[0.0, 1e7], 0, MAX), None);
}

prop_compose! {
    fn case(nodes: usize, most: f64)(
        mut wanted in proptest::collection::vec(-most..most, 2..=nodes),
        reference in any::<prop::sample::Index>(),
        // Halves and whole numbers put the rounding of ties to the test.
        grain in prop::sample::select(vec![0.0, 0.25, 0.5, 1.0]),
    ) -> (Vec<f64>, usize) {
        if grain > 0.0 {
            wanted.iter_mut().for_each(|amount| *amount = (*amount / grain).round() * grain);
        }
        let reference = reference.index(wanted.len());
        wanted[reference] = 0.0;
        (wanted, reference)
    }
}

proptest! {
    #![proptest_config(cases(40))]
    #[test]
    fn no_points_are_better((wanted, reference) in case(7, 4.0)) {
        let best = best_fit(&wanted, reference, 7).expect("a fit");
        assert_admissible(&best, &wanted, reference);
        let least = brute_force(&wanted, reference, 7);
        prop_assert!((best.residual - least).abs() <= 0.0, "{best:?}, but {least}");
    }

    #[test]
    fn no_points_with_small_amounts_are_better((wanted, reference) in case(7, 6.0)) {
        let best = best_fit(&wanted, reference, 3).expect("a fit");
        prop_assert!(best.amounts.iter().all(|amount| amount.abs() <= 3));
        let least = brute_force(&wanted, reference, 3);
        prop_assert!((best.residual - least).abs() <= 0.0, "{best:?}, but {least}");
    }

    #[test]
    fn no_worse_than_any_points_at_hand(
        (wanted, reference) in case(40, 60.0),
        breaks in any::<[prop::sample::Index; 2]>(),
        noise in proptest::collection::vec(-2i64..=2, 4),
    ) {
        let last = wanted.len() - 1;
        let mut nodes = [0, breaks[0].index(wanted.len()), reference, last];
        if reference == 0 || reference == last {
            nodes[2] = breaks[1].index(wanted.len());
        }
        nodes.sort_unstable();
        let mut amounts = [0; 4];
        for knot in 0..4 {
            amounts[knot] = whole(wanted[nodes[knot]].round()) + noise[knot];
            if nodes[knot] == reference {
                amounts[knot] = 0;
            } else if knot > 0 && nodes[knot] == nodes[knot - 1] {
                amounts[knot] = amounts[knot - 1];
            }
        }
        let given = FourPoint { nodes, amounts, residual: 0.0 };
        prop_assert!(fit(&wanted, reference).residual <= left(&given, &wanted));
        let exact: Vec<f64> = (0..=last).map(|node| output(&given, node) as f64).collect();
        prop_assert!(fit(&exact, reference).residual <= 0.0);
    }

    #[test]
    fn mirrored_and_negated_leave_the_same((wanted, reference) in case(30, 30.0)) {
        let residual = fit(&wanted, reference).residual;
        let other_end = wanted.len() - 1 - reference;
        prop_assert_eq!(fit(&mirrored(&wanted), other_end).residual.to_bits(), residual.to_bits());
        prop_assert_eq!(fit(&negated(&wanted), reference).residual.to_bits(), residual.to_bits());
    }

    #[test]
    fn large_amounts_are_fitted_too((wanted, reference) in case(20, 9e5)) {
        let best = best_fit(&wanted, reference, u32::MAX).expect("a fit");
        assert_admissible(&best, &wanted, reference);
    }
}

proptest! {
    #![proptest_config(cases(24))]
    #[test]
    fn no_points_of_more_nodes_are_better((wanted, reference) in case(13, 5.0)) {
        let best = best_fit(&wanted, reference, 4).expect("a fit");
        let least = brute_force(&wanted, reference, 4);
        prop_assert!((best.residual - least).abs() <= 0.0, "{best:?}, but {least}");
    }
}
