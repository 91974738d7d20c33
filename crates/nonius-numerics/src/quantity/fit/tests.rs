use super::*;
use crate::quantity::Interpolation;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// Rounding noise of micrometres.
const NOISE_UM: f64 = 1e-9;
const KINDS: [Interpolation; 3] =
    [Interpolation::Linear, Interpolation::Pchip, Interpolation::NaturalSpline];
const FITS: [Fit; 3] = [Fit::Sample, Fit::LeastSquares, Fit::Minimax];

fn curve(positions: &[f64], deviations: &[f64], kind: Interpolation) -> ErrorCurve {
    let positions: Vec<Millimetres> = positions.iter().copied().map(Millimetres::new).collect();
    let deviations: Vec<Deviation> = deviations.iter().copied().map(Deviation::from_um).collect();
    ErrorCurve::through(&positions, &deviations, kind)
}

fn grid(first: f64, step: f64, count: usize, reference_node: usize) -> Nodes {
    let (first, step) = (Millimetres::new(first), Millimetres::new(step));
    Nodes { first, step, count, reference_node }
}

fn over_table(curve: &ErrorCurve, nodes: &Nodes, values: &[Deviation]) -> f64 {
    residual(curve, nodes, values, nodes.first, nodes.position(nodes.count - 1))
}

fn left_by(curve: &ErrorCurve, nodes: &Nodes, fit: Fit) -> f64 {
    over_table(curve, nodes, &table_values(curve, nodes, fit))
}

/// The hat function of a node: 1 there, 0 at the others, held outside.
fn hat(nodes: &Nodes, node: usize, x: f64) -> f64 {
    let place = (x - nodes.first.mm()) / nodes.step.mm();
    let place = place.clamp(0.0, (nodes.count - 1) as f64);
    (1.0 - (place - node as f64).abs()).max(0.0)
}

fn table_at(nodes: &Nodes, values: &[Deviation], x: f64) -> f64 {
    let parts = values.iter().enumerate();
    parts.map(|(node, value)| value.um() * hat(nodes, node, x)).sum()
}

/// Largest of c·y under A·y ≤ b, y ≥ 0, with b ≥ 0: the simplex method with Bland's rule.
fn largest_of(rows: &[Vec<f64>], bounds: &[f64], gains: &[f64]) -> f64 {
    let (count, width) = (rows.len(), gains.len() + rows.len() + 1);
    let mut tableau: Vec<Vec<f64>> = rows.to_vec();
    for (i, row) in tableau.iter_mut().enumerate() {
        row.resize(width, 0.0);
        row[gains.len() + i] = 1.0;
        row[width - 1] = bounds[i];
    }
    let mut last: Vec<f64> = gains.iter().map(|gain| -gain).collect();
    last.resize(width, 0.0);
    tableau.push(last);
    let mut basis: Vec<usize> = (gains.len()..width - 1).collect();
    while let Some(enters) = (0..width - 1).find(|&j| tableau[count][j] < -1e-9) {
        let ratio = |i: usize| tableau[i][width - 1] / tableau[i][enters];
        let leaves = (0..count)
            .filter(|&i| tableau[i][enters] > 1e-7)
            .min_by(|&i, &k| ratio(i).total_cmp(&ratio(k)).then(basis[i].cmp(&basis[k])))
            .expect("the programs here are bounded");
        let pivot = tableau[leaves][enters];
        tableau[leaves].iter_mut().for_each(|cell| *cell /= pivot);
        let pivot_row = tableau[leaves].clone();
        for (i, row) in tableau.iter_mut().enumerate().filter(|(i, _)| *i != leaves) {
            let factor = row[enters];
            row.iter_mut().zip(&pivot_row).for_each(|(cell, own)| *cell -= factor * own);
            row[width - 1] = if i < count { row[width - 1].max(0.0) } else { row[width - 1] };
        }
        basis[leaves] = enters;
    }
    tableau[count][width - 1]
}

/// What no table can get below: the dual linear program on some places of the curve,
/// max Σ d(x)·y with Σ φ_i(x)·y = 0 at every free node and Σ |y| ≤ 1.
fn lower_bound(curve: &ErrorCurve, nodes: &Nodes, free: &[usize], places: &[f64]) -> f64 {
    let both = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        places.iter().flat_map(|&x| [of(x), -of(x)]).collect()
    };
    let mut rows = vec![vec![1.0; 2 * places.len()]];
    for &node in free {
        rows.push(both(&|x| hat(nodes, node, x)));
        rows.push(both(&|x| -hat(nodes, node, x)));
    }
    let mut bounds = vec![0.0; rows.len()];
    bounds[0] = 1.0;
    largest_of(&rows, &bounds, &both(&|x| curve.um_at(x)))
}

/// Even places of a stretch, and those where the curve can be farthest from these values.
fn places(curve: &ErrorCurve, nodes: &Nodes, values: &[Deviation], side: [usize; 2]) -> Vec<f64> {
    let mut places = Vec::new();
    for node in side[0]..side[1] {
        let (from, to) = (nodes.position(node).mm(), nodes.position(node + 1).mm());
        let slope = (values[node + 1].um() - values[node].um()) / (to - from);
        curve.visit_candidates(from, to, -slope, |x, _| places.push(x));
        places.extend((1..8).map(|part| from + (to - from) * f64::from(part) / 8.0));
    }
    places
}

/// Shown to be optimal, side by side: the duals of a linear program certify that no table is
/// better than this one.
#[track_caller]
fn assert_optimal(curve: &ErrorCurve, nodes: &Nodes) {
    let values = table_values(curve, nodes, Fit::Minimax);
    let (reference, last) = (nodes.reference_node, nodes.count - 1);
    for side in [[0, reference], [reference, last]] {
        let free: Vec<usize> = (side[0]..=side[1]).filter(|&node| node != reference).collect();
        let places = places(curve, nodes, &values, side);
        let bound = lower_bound(curve, nodes, &free, &places);
        let [from, to] = side.map(|node| nodes.position(node));
        let got = residual(curve, nodes, &values, from, to);
        assert!(
            (got - bound).abs() <= 1e-7 * (1.0 + bound) || free.is_empty(),
            "got {got}, possible {bound}, side {side:?}, {nodes:?}"
        );
    }
}

#[test]
fn a_parabola_on_one_section_has_the_answer_of_the_textbook() {
    // d = x², line c·x on [0, h]. The residual x² − c·x is lowest at c/2 with −c²/4 and ends at
    // h² − c·h. Equal and opposite: c² + 4hc − 4h² = 0, c = 2(√2 − 1)·h, t = (3 − 2√2)·h².
    let h = 3.0;
    let parabola = ErrorCurve::from_cubics(&[0.0, h], &[[0.0, 0.0, 1.0, 0.0]]);
    let nodes = grid(0.0, h, 2, 0);
    let values = table_values(&parabola, &nodes, Fit::Minimax);
    let root = 2.0_f64.sqrt();
    assert!((values[1].um() - 2.0 * (root - 1.0) * h * h).abs() < NOISE_UM);
    let got = over_table(&parabola, &nodes, &values);
    assert!((got - (3.0 - 2.0 * root) * h * h).abs() < NOISE_UM);
    assert!((left_by(&parabola, &nodes, Fit::Sample) - h * h / 4.0).abs() < NOISE_UM);
}

#[test]
fn least_squares_of_a_parabola_on_one_section() {
    // ∫₀¹ (x² − c·x)·x dx = 1/4 − c/3 = 0: c = 3/4.
    let parabola = ErrorCurve::from_cubics(&[0.0, 1.0], &[[0.0, 0.0, 1.0, 0.0]]);
    let values = table_values(&parabola, &grid(0.0, 1.0, 2, 0), Fit::LeastSquares);
    assert!((values[1].um() - 0.75).abs() < NOISE_UM);
}

#[test]
fn a_table_on_the_knots_of_a_linear_curve_is_the_curve() {
    let line = curve(&[0.0, 10.0, 20.0, 30.0], &[1.0, 0.0, -4.0, 2.0], Interpolation::Linear);
    let nodes = grid(0.0, 10.0, 4, 1);
    for fit in FITS {
        let values = table_values(&line, &nodes, fit);
        for (value, expected) in values.iter().zip([1.0, 0.0, -4.0, 2.0]) {
            assert!((value.um() - expected).abs() < NOISE_UM, "{fit:?}: {values:?}");
        }
    }
}

#[test]
fn a_table_of_one_node_is_zero() {
    let line = curve(&[0.0, 10.0], &[0.0, 3.0], Interpolation::Linear);
    let nodes = grid(0.0, 10.0, 1, 0);
    for fit in FITS {
        let values = table_values(&line, &nodes, fit);
        assert_eq!(values, [Deviation::ZERO]);
        let (from, to) = (Millimetres::new(-5.0), Millimetres::new(5.0));
        assert!((residual(&line, &nodes, &values, from, to) - 1.5).abs() < NOISE_UM);
    }
}

#[test]
fn outside_its_nodes_the_table_is_held() {
    let line = curve(&[0.0, 100.0], &[0.0, 10.0], Interpolation::Linear);
    let nodes = grid(20.0, 20.0, 3, 0);
    let values: Vec<Deviation> = [0.0, 4.0, 6.0].map(Deviation::from_um).to_vec();
    let left =
        |from, to| residual(&line, &nodes, &values, Millimetres::new(from), Millimetres::new(to));
    for (from, to, expected) in [
        (0.0, 10.0, 1.0),
        (70.0, 90.0, 3.0),
        (50.0, 90.0, 3.0),
        (20.0, 60.0, 2.0),
        (35.0, 50.0, 0.5),
        (-9.0, 120.0, 4.0),
    ] {
        let got = left(from, to);
        assert!((got - expected).abs() < NOISE_UM, "{from}..{to}: got {got}, not {expected}");
    }
}

/// A measured axis: positions, deviations, zero at one of the nodes of a table near it.
#[derive(Clone, Debug)]
struct Case {
    curve: ErrorCurve,
    nodes: Nodes,
}

prop_compose! {
    fn case(max_nodes: usize)(
        steps in proptest::collection::vec((2.0..30.0f64, -9.0..9.0f64), 1..14),
        kind in 0..3usize,
        count in 2..=max_nodes,
        shares in (-0.2..0.2f64, 0.8..1.2f64),
        reference in any::<prop::sample::Index>(),
    ) -> Case {
        let mut x = 0.0;
        let (positions, values): (Vec<f64>, Vec<f64>) =
            steps.iter().map(|&(step, um)| { x += step; (x - 2.0, um) }).unzip();
        let length = x * (shares.1 - shares.0);
        let step = length / (count - 1) as f64;
        let nodes = grid(x * shares.0, step, count, reference.index(count));
        let curve = curve(&positions, &values, KINDS[kind]);
        let curve = curve.rezeroed_at(nodes.position(nodes.reference_node));
        Case { curve, nodes }
    }
}

fn scaled(curve: &ErrorCurve, factor: f64) -> ErrorCurve {
    let none = curve.difference(curve).expect("a curve overlaps itself");
    let mut sum = none.clone();
    for _ in 0..4 {
        sum = sum.mean_with(curve).expect("overlap"); // factors 1/2, 3/4, 7/8, 15/16
    }
    let turned = none.difference(&sum).expect("overlap");
    if factor < 0.0 { turned } else { sum }
}

fn least_squares_densely(case: &Case) -> Vec<f64> {
    let Case { curve, nodes } = case;
    let mut rows: Vec<(f64, f64)> = Vec::new();
    let mut breaks: Vec<f64> = (0..nodes.count).map(|node| nodes.position(node).mm()).collect();
    let last = breaks[nodes.count - 1];
    breaks.extend(curve.knots_between(nodes.first.mm(), last).iter().map(|knot| knot.mm()));
    breaks.sort_by(f64::total_cmp);
    for pair in breaks.windows(2) {
        rows.extend(gauss_points(pair[0], pair[1]));
    }
    let free: Vec<usize> = (0..nodes.count).filter(|&node| node != nodes.reference_node).collect();
    let matrix = DMatrix::from_fn(rows.len(), free.len(), |row, column| {
        rows[row].1.sqrt() * hat(nodes, free[column], rows[row].0)
    });
    let right = DVector::from_iterator(
        rows.len(),
        rows.iter().map(|&(x, weight)| weight.sqrt() * curve.um_at(x)),
    );
    let solved = matrix.svd(true, true).solve(&right, 1e-14).expect("both bases were asked for");
    let mut values: Vec<f64> = solved.iter().copied().collect();
    values.insert(nodes.reference_node, 0.0);
    values
}

proptest! {
    #[test]
    fn no_table_is_better_than_minimax(case in case(6)) {
        assert_optimal(&case.curve, &case.nodes);
    }

    #[test]
    fn minimax_leaves_least_and_the_reference_is_zero(case in case(40)) {
        let Case { curve, nodes } = &case;
        let best = left_by(curve, nodes, Fit::Minimax);
        prop_assert!(best <= left_by(curve, nodes, Fit::Sample));
        prop_assert!(best <= left_by(curve, nodes, Fit::LeastSquares) * (1.0 + 2e-9) + 1e-11);
        for fit in FITS {
            let values = table_values(curve, nodes, fit);
            prop_assert_eq!(values.len(), nodes.count);
            prop_assert_eq!(values[nodes.reference_node], Deviation::ZERO);
            prop_assert!(values.iter().all(|value| value.um().is_finite()));
        }
    }

    #[test]
    fn least_squares_is_that_of_a_dense_solution(case in case(12)) {
        let values = table_values(&case.curve, &case.nodes, Fit::LeastSquares);
        for (value, dense) in values.iter().zip(least_squares_densely(&case)) {
            prop_assert!((value.um() - dense).abs() < 1e-8, "{} {}", value.um(), dense);
        }
    }

    #[test]
    fn a_scaled_or_turned_curve_scales_the_table(case in case(12), turned: bool) {
        let Case { curve, nodes } = &case;
        let factor = if turned { -0.9375 } else { 0.9375 };
        let other = scaled(curve, factor);
        for fit in FITS {
            let mut values = table_values(curve, nodes, fit);
            values.iter_mut().for_each(|value| *value = Deviation::from_um(value.um() * factor));
            assert_same(&other, nodes, &values, &table_values(&other, nodes, fit), fit);
        }
    }

    #[test]
    fn a_mirrored_axis_mirrors_the_table(case in case(12), kind in 0..3usize) {
        let Case { curve, nodes } = &case;
        let last = nodes.count - 1;
        let points = curve.knots().iter().map(|knot| (knot.mm(), curve.um_at(knot.mm())));
        let (knots, values): (Vec<f64>, Vec<f64>) = points.clone().unzip();
        let (turned_knots, turned): (Vec<f64>, Vec<f64>) =
            points.rev().map(|(x, um)| (-x, um)).unzip();
        let ahead = super::tests::curve(&knots, &values, KINDS[kind]);
        let back = super::tests::curve(&turned_knots, &turned, KINDS[kind]);
        let first = -nodes.position(last).mm();
        let mirrored = grid(first, nodes.step.mm(), nodes.count, last - nodes.reference_node);
        for fit in FITS {
            let mut mirror = table_values(&back, &mirrored, fit);
            mirror.reverse();
            assert_same(&ahead, nodes, &table_values(&ahead, nodes, fit), &mirror, fit);
        }
    }
}

/// Two tables of one curve that are the same up to rounding. Where the line may touch t at a
/// node with the slope of the curve, the minimax value there moves by the *root* of the rounding
/// in t, so minimax tables are compared by what they leave and only loosely by their values.
#[track_caller]
fn assert_same(curve: &ErrorCurve, nodes: &Nodes, one: &[Deviation], two: &[Deviation], fit: Fit) {
    let tolerance = if fit == Fit::Minimax { 1e-3 } else { 1e-8 };
    for (one, two) in one.iter().zip(two) {
        let difference = (one.um() - two.um()).abs();
        assert!(difference < tolerance, "{fit:?}: {one:?} and {two:?}");
    }
    let left = [one, two].map(|values| over_table(curve, nodes, values));
    assert!((left[0] - left[1]).abs() < 1e-7, "{fit:?}: {left:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn residual_is_that_of_dense_sampling(
        case in case(12), from in -40.0..100.0f64, length in 0.0..300.0f64, fit in 0..3usize,
    ) {
        let Case { curve, nodes } = &case;
        let values = table_values(curve, nodes, FITS[fit]);
        let (start, end) = (Millimetres::new(from), Millimetres::new(from + length));
        let exact = residual(curve, nodes, &values, start, end);
        let sampled = (0..=100_000)
            .map(|part| from + length * f64::from(part) / 1e5)
            .map(|x| (curve.um_at(x) - table_at(nodes, &values, x)).abs())
            .fold(0.0, f64::max);
        prop_assert!(exact >= sampled - NOISE_UM && exact <= sampled + 0.01, "{exact} {sampled}");
    }
}
