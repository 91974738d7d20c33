use super::*;
use proptest::prelude::*;

const POSITIONS: [f64; 6] = [0.0, 10.0, 25.0, 40.0, 60.0, 100.0];
const DEVIATIONS: [f64; 6] = [0.0, 1.5, -0.5, -3.0, 2.0, 1.0];
const ASKED: [f64; 5] = [2.5, 12.0, 30.0, 50.0, 95.0];
const KINDS: [Interpolation; 3] =
    [Interpolation::Linear, Interpolation::Pchip, Interpolation::NaturalSpline];
/// A millionth of a nanometre: rounding noise of micrometres.
const NOISE_UM: f64 = 1e-9;

fn curve(positions: &[f64], deviations: &[f64], kind: Interpolation) -> ErrorCurve {
    let positions: Vec<Millimetres> = positions.iter().copied().map(Millimetres::new).collect();
    let deviations: Vec<Deviation> = deviations.iter().copied().map(Deviation::from_um).collect();
    ErrorCurve::through(&positions, &deviations, kind)
}

fn sample(kind: Interpolation) -> ErrorCurve {
    curve(&POSITIONS, &DEVIATIONS, kind)
}

#[track_caller]
fn assert_close(got: f64, expected: f64) {
    let difference = got - expected;
    assert!(
        difference.abs() < NOISE_UM * (1.0 + expected.abs()),
        "got {got}, expected {expected}, difference {difference:e}"
    );
}

#[track_caller]
fn assert_values(curve: &ErrorCurve, positions: &[f64], expected: &[f64]) {
    for (&x, &um) in positions.iter().zip(expected) {
        assert_close(curve.um_at(x), um);
    }
}

// SciPy 1.17.1: PchipInterpolator(POSITIONS, DEVIATIONS)(ASKED), .integrate(0, 100) / 100
#[test]
fn pchip_is_that_of_scipy() {
    let pchip = sample(Interpolation::Pchip);
    let expected = [
        0.6046874999999999,
        1.437053497942387,
        -1.4773662551440327,
        -0.49999999999999956,
        1.330078125,
    ];
    assert_values(&pchip, &ASKED, &expected);
}

// SciPy 1.17.1: PchipInterpolator([0, 1, 2, 3], …)([0.25, 0.5, 1.5, 2.75]) and ([0.5, 1.5, 2.5]);
// slope at the first point limited to three chords, and to zero.
#[test]
fn pchip_ends_are_limited_as_in_scipy() {
    let steep = curve(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, -8.0, -8.5], Interpolation::Pchip);
    let expected = [0.578125, 0.875, -3.3815789473684212, -8.466282894736842];
    assert_values(&steep, &[0.25, 0.5, 1.5, 2.75], &expected);
    let flat = curve(&[0.0, 1.0, 2.0, 3.0], &[0.0, 0.1, 2.0, 1.0], Interpolation::Pchip);
    assert_values(&flat, &[0.5, 1.5, 2.5], &[0.02625, 1.07375, 1.80625]);
}

// SciPy 1.17.1: CubicSpline(POSITIONS, DEVIATIONS, bc_type='natural')(ASKED), .integrate(0, 100)
#[test]
fn natural_spline_is_that_of_scipy() {
    let spline = sample(Interpolation::NaturalSpline);
    let expected = [
        0.5007447167266187,
        1.5233396749267254,
        -1.7271449507061016,
        -1.0517086330935246,
        1.8112297661870493,
    ];
    assert_values(&spline, &ASKED, &expected);
}

#[test]
fn every_kind_meets_the_points_and_holds_the_ends() {
    for kind in KINDS {
        let curve = sample(kind);
        assert_values(&curve, &POSITIONS, &DEVIATIONS);
        assert_values(&curve, &[-50.0, 100.0, 400.0], &[0.0, 1.0, 1.0]);
    }
}

#[test]
fn one_point_is_a_constant_and_two_are_a_line() {
    for kind in KINDS {
        let constant = curve(&[5.0], &[2.0], kind);
        assert_values(&constant, &[-1.0, 5.0, 9.0], &[2.0, 2.0, 2.0]);
        assert_close(constant.end_point_slope_um_per_m(), 0.0);
        let line = curve(&[0.0, 200.0], &[1.0, 5.0], kind);
        assert_close(line.um_at(50.0), 2.0);
        assert_close(line.end_point_slope_um_per_m(), 20.0);
    }
}

#[test]
fn slope_and_zero_act_inside_the_measured_range_only() {
    let tilted = sample(Interpolation::Pchip).plus_slope(20.0, Millimetres::new(50.0));
    assert_values(&tilted, &[0.0, 50.0, 100.0, 300.0], &[-1.0, -0.5, 2.0, 2.0]);
    let zeroed = tilted.rezeroed_at(Millimetres::new(100.0));
    assert_values(&zeroed, &[0.0, 100.0, 300.0], &[-3.0, 0.0, 0.0]);
}

#[test]
fn mean_and_difference_cover_the_overlap() {
    let there = sample(Interpolation::NaturalSpline);
    let back = curve(&[-5.0, 33.0, 80.0], &[1.0, 2.0, 6.0], Interpolation::Pchip);
    let (mean, difference) = (there.mean_with(&back), there.difference(&back));
    let (mean, difference) = (mean.expect("overlap"), difference.expect("overlap"));
    let range = (Millimetres::new(0.0), Millimetres::new(80.0));
    assert_eq!(mean.measured_range(), range);
    assert_eq!(mean.knots().len(), 7);
    for x in [0.0, 7.0, 25.0, 30.0, 36.0, 61.0, 80.0] {
        let (one, two) = (there.um_at(x), back.um_at(x));
        assert_close(mean.um_at(x), (one + two) / 2.0);
        assert_close(difference.um_at(x), one - two);
    }
}

#[test]
fn curves_apart_have_no_mean_and_touching_ones_a_point() {
    let here = sample(Interpolation::Linear);
    let apart = curve(&[101.0, 120.0], &[0.0, 1.0], Interpolation::Linear);
    assert_eq!(here.mean_with(&apart), None);
    let touching = curve(&[100.0, 120.0], &[3.0, 1.0], Interpolation::Linear);
    let mean = here.mean_with(&touching).expect("one common point");
    assert_eq!(mean.knots().len(), 1);
    assert_close(mean.um_at(0.0), 2.0);
}

#[test]
fn extremes_of_a_parabola_against_a_line() {
    // x² − 2x on [0, 3] + (0 → 3): x² − x, lowest at 0.5 with −0.25, highest at 3 with 6.
    let parabola = ErrorCurve::from_cubics(&[0.0, 3.0], &[[0.0, -2.0, 1.0, 0.0]]);
    let (from, to) = (Millimetres::new(0.0), Millimetres::new(3.0));
    let (low, high) = parabola.extremes_against_line(from, to, 0.0, 3.0);
    assert_close(low, -0.25);
    assert_close(high, 6.0);
    assert_close(parabola.largest_magnitude(from, to), 3.0);
    assert_close(parabola.largest_magnitude(from, Millimetres::new(1.5)), 1.0);
}

#[test]
fn extremes_at_a_point_are_its_value() {
    let pchip = sample(Interpolation::Pchip);
    let place = Millimetres::new(10.0);
    assert_close(pchip.largest_magnitude(place, place), 1.5);
    let (low, high) = pchip.extremes_against_line(place, place, -1.0, 1.0);
    assert_close(low, 0.5);
    assert_close(high, 2.5);
}

proptest! {
    #[test]
    fn extremes_are_those_of_dense_sampling(
        steps in proptest::collection::vec((0.5..30.0f64, -9.0..9.0f64), 1..12),
        kind in 0..3usize, from in -20.0..100.0f64, length in 0.0..150.0f64,
        line in (-5.0..5.0f64, -5.0..5.0f64),
    ) {
        let mut x = 0.0;
        let (positions, values): (Vec<f64>, Vec<f64>) =
            steps.iter().map(|&(step, um)| { x += step; (x, um) }).unzip();
        let curve = curve(&positions, &values, KINDS[kind]);
        let ends = (Millimetres::new(from), Millimetres::new(from + length));
        let (low, high) = curve.extremes_against_line(ends.0, ends.1, line.0, line.1);
        let (mut sampled_low, mut sampled_high) = (f64::INFINITY, f64::NEG_INFINITY);
        // Corners between the samples would be missed by slope x distance, so knots are samples too.
        let at_knots = positions.iter().map(|x| (x - from) / length).filter(|u| (0.0..=1.0).contains(u));
        for u in (0..=4000).map(|part| f64::from(part) / 4000.0).chain(at_knots) {
            let sum = curve.um_at(from + length * u) + line.0 + (line.1 - line.0) * u;
            sampled_low = sampled_low.min(sum);
            sampled_high = sampled_high.max(sum);
        }
        prop_assert!(low <= sampled_low + NOISE_UM && low >= sampled_low - 0.05);
        prop_assert!(high >= sampled_high - NOISE_UM && high <= sampled_high + 0.05);
    }
}
