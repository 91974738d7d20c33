//! The redundancy of formula (7), what stated uncertainties do through it, beams over a part of
//! the travel, and uncertainties that are not known.
use crate::support::diagonals as simulated;
use crate::support::diagonals::{Machine, curve, mm, runs, solved, volume, with_noise, words};
use nonius::inputs::job::{AxisMaterial, Frame, Material, SetUp, StatedUncertainty};
use nonius::machine::separation::metric::Plane;
use nonius::machine::separation::{MeasuredLine, Separation, separate};
use nonius::quantity::axis::{Axis, ErrorTerm, PerAxis};
use nonius::quantity::diagonal::{Diagonal, Pass};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const SIGMA_UM: f64 = 0.3;

fn machine(seed: u64) -> (Machine, Machine, ChaCha8Rng) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let box_ = volume([900.0, 720.0, 720.0], 30);
    let truth = Machine::random(&box_, &mut random).x_primary();
    let mut leant = truth.clone();
    leant.lean_randomly(3e-4, &mut random);
    (truth, leant, random)
}

fn measured(seed: u64, change: impl Fn(&mut [MeasuredLine])) -> (Machine, Separation) {
    let (truth, leant, mut random) = machine(seed);
    let noisy = with_noise(&leant.readings(None), SIGMA_UM, &mut random);
    let mut lines = truth.lines(&Axis::ALL, Some(0.5));
    change(&mut lines);
    let found = solved(&truth.volume, lines, &runs(1, Pass::Forward, &noisy));
    (truth, found)
}

fn term(name: &str) -> ErrorTerm {
    ErrorTerm::from_name(name).unwrap()
}

fn u_at_end(found: &Separation, name: &str) -> Option<f64> {
    let evidence = found.errors.mean[term(name)].as_ref().unwrap();
    evidence.u_um.as_ref().map(|u| *u.last().unwrap())
}

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!(
        (found - wanted).abs() <= tolerance,
        "{what}: {found}, expected {wanted} within {tolerance}"
    );
}

#[test]
fn a_wrong_linear_axis_is_not_swallowed() {
    let (truth, found) = measured(3, |lines| lines[2].slope_um_per_m += 50.0);
    let agreement = found.agreement.as_ref().unwrap();
    assert_eq!(agreement.freedom, 1);
    assert!(agreement.probability.unwrap() < 1e-12);
    // What the two other axes and the totals say of Z: S, without Z.
    let z = agreement.lines[2];
    let others = z.others.unwrap();
    close(others.found_um_per_m, truth.slope(term("EZZ")), 4.0, "Z");
    let (difference, ratio) = z.difference().unwrap();
    close(difference, 50.0, 4.0, "difference");
    close(ratio, difference / others.u_difference_um_per_m, 1e-9, "ratio");
    assert!(words(&found.doubts)[0].contains("linear axes and diagonals DISAGREE"));
    assert!(words(&found.doubts)[0].contains("Z by +"), "{}", words(&found.doubts)[0]);
    assert!(found.tilts.is_none());
    for name in ["EXX", "EYY", "EZZ", "EXY", "EXZ", "EYZ"] {
        assert_eq!(u_at_end(&found, name), None, "{name}");
    }
    for plane in Plane::ALL {
        assert_eq!(found.u_squareness.of(plane).map(|u| u.u_um_per_m), None);
    }
}

#[test]
fn true_linear_axes_agree_and_each_is_confirmed_by_the_others() {
    let (truth, found) = measured(3, |_| ());
    let agreement = found.agreement.as_ref().unwrap();
    assert!(agreement.probability.unwrap() > 0.01);
    assert!(found.doubts.is_empty(), "{:?}", found.doubts);
    assert!(!agreement.taken_as_exact);
    for (line, axis) in agreement.lines.iter().zip(Axis::ALL) {
        assert_eq!(line.name(), axis.to_string());
        let others = line.others.unwrap();
        let slope = truth.slope(ErrorTerm { of: axis, along: axis });
        let far = (others.found_um_per_m - slope).abs();
        assert!(far < 3.5 * others.u_difference_um_per_m, "{axis}: {far}");
        // V/c⁴ for the totals' mean and c² shares of the others: all three have one ratio.
        let ratio = line.difference().unwrap().1.abs();
        close(ratio, agreement.chi_squared.sqrt(), 2e-3, "ratio");
    }
    // u(Z) against the rest, by hand: √(u² + (X/Z)⁴u² + (Y/Z)⁴u² + (R/Z)⁴·2σ²/(4R²)).
    let volume = &truth.volume;
    let [x, y, z] = Axis::ALL.map(|axis| volume.cosine(axis).powi(2));
    let sigma = found.noise.unwrap().sigma_um / (volume.diagonal_mm() / 1000.0);
    let wanted =
        (0.25 * (1.0 + (x / z).powi(2) + (y / z).powi(2)) + sigma * sigma / 2.0 / z / z).sqrt();
    let u = agreement.lines[2].others.unwrap().u_difference_um_per_m;
    close(u, wanted, 0.002, "u of the difference");
}

#[test]
fn without_redundancy_it_is_said_that_nothing_checks() {
    let (truth, leant, mut random) = machine(4);
    let noisy = with_noise(&leant.readings(None), SIGMA_UM, &mut random);
    let lines = truth.lines(&[Axis::X, Axis::Y], Some(0.5));
    let found = solved(&truth.volume, lines, &runs(1, Pass::Forward, &noisy));
    assert_eq!(found.agreement, None);
    let said = |wanted: &str| words(&found.labels).iter().any(|label| label.contains(wanted));
    assert!(said("nothing checks the linear axes"));
}

/// The same readings with something stated of them; X and Y with u = 0.1 µm/m.
fn with_stated(stated: StatedUncertainty, material: Option<Material>) -> Separation {
    let (truth, leant, mut random) = machine(5);
    let noisy = with_noise(&leant.readings(None), 0.001, &mut random);
    let mut measurement = simulated::measurement(&truth.volume, SetUp::Solve, Frame::XPrimary);
    measurement.material = material;
    let lines = truth.lines(&[Axis::X, Axis::Y], Some(0.1));
    let mut campaign = simulated::campaign(&measurement, lines);
    campaign.stated = stated;
    separate(&campaign, &runs(1, Pass::Forward, &noisy))
}

fn steel(axes: &[Axis], temperature_c: Option<f64>) -> Material {
    let steel = AxisMaterial { alpha_per_k: 11.5e-6, temperature_c };
    Material {
        material_corrected: true,
        air_corrected: true,
        axes: PerAxis::from_fn(|axis| axes.contains(&axis).then_some(steel)),
    }
}

/// Z²p_zz = S − X²p_xx − Y²p_yy: a scale error of the diagonals comes out (R/Z)² = 3.5625 times as
/// large in EZZ, and not at all in EXX, which is the linear axis.
#[test]
fn the_laser_goes_through_the_solution() {
    let plain = with_stated(StatedUncertainty::default(), None);
    let stated = StatedUncertainty { laser_ppm: Some(1.0), ..StatedUncertainty::default() };
    let found = with_stated(stated, None);
    let added = |name: &str| {
        let [with, without] = [&found, &plain].map(|s| u_at_end(s, name).unwrap());
        (with * with - without * without).max(0.0).sqrt()
    };
    close(added("EZZ"), 0.72 * 3.5625, 1e-3, "EZZ");
    for name in ["EXX", "EYY", "EXY", "EXZ", "EYZ"] {
        close(added(name), 0.0, 0.01, name);
    }
    close(u_at_end(&found, "EXX").unwrap(), 0.09, 1e-3, "EXX");
    // The stated cause only weighs: nothing is redundant, so the result stays.
    for term in ErrorTerm::ALL {
        for (a, b) in curve(&found, term).iter().zip(curve(&plain, term)) {
            close(*a, *b, 1e-6, &term.to_string());
        }
    }
}

#[test]
fn the_temperature_goes_through_the_solution() {
    let stated = StatedUncertainty { temperature_k: Some(1.0), ..StatedUncertainty::default() };
    let found = with_stated(stated, Some(steel(&Axis::ALL, Some(22.0))));
    close(u_at_end(&found, "EZZ").unwrap(), 29.50, 0.05, "EZZ");
    close(u_at_end(&found, "EXX").unwrap(), 0.09, 1e-3, "EXX");
    // Of X alone: X² share only.
    let found = with_stated(stated, Some(steel(&[Axis::X], Some(22.0))));
    let wanted = 11.5 * 0.72 * (900.0f64 / 720.0).powi(2);
    close(u_at_end(&found, "EZZ").unwrap(), wanted, 0.05, "EZZ by X");
    let said = |wanted: &str| words(&found.labels).iter().any(|label| label.contains(wanted));
    assert!(said("temperature_k is included in the scales for X"));
    assert!(said("but not for Y, Z"));
}

#[test]
fn changes_between_set_ups_make_squareness_uncertain() {
    let stated = StatedUncertainty { setup_ppm: Some(2.3), ..StatedUncertainty::default() };
    let found = with_stated(stated, None);
    for (plane, area) in
        [(Plane::Xy, 0.9 * 0.72), (Plane::Xz, 0.9 * 0.72), (Plane::Yz, 0.72 * 0.72)]
    {
        // R²/(2 V_j V_k) · u(ε)
        let wanted = 2.3 * found.volume.diagonal_mm().powi(2) / 1e6 / (2.0 * area);
        let u = found.u_squareness.of(plane).map(|u| u.u_um_per_m).unwrap();
        close(u, wanted, 0.01, plane.key());
    }
    let silent = with_stated(StatedUncertainty::default(), None);
    let said = |wanted: &str| words(&silent.labels).iter().any(|label| label.contains(wanted));
    assert!(said("setup_ppm is not stated"));
    assert!(said("xy 1.42, xz 1.42, yz 1.78") || said("xy 1.43, xz 1.43, yz 1.78"));
}

#[test]
fn recorded_temperatures_serve_the_coefficient_of_expansion() {
    let (truth, leant, mut random) = machine(6);
    let noisy = with_noise(&leant.readings(None), 0.001, &mut random);
    let mut measurement = simulated::measurement(&truth.volume, SetUp::Solve, Frame::XPrimary);
    measurement.material = Some(steel(&Axis::ALL, None));
    let lines = truth.lines(&[Axis::X, Axis::Y], Some(0.1));
    let mut campaign = simulated::campaign(&measurement, lines);
    campaign.stated.alpha_per_k = Some(1e-6);
    let mut all = runs(1, Pass::Forward, &noisy);
    let cold = separate(&campaign, &all);
    assert!(
        words(&cold.labels)
            .iter()
            .any(|label| label.contains("alpha_per_k is stated but not included for any axis"))
    );
    for run in &mut all {
        run.temperatures_c = PerAxis::from_fn(|_| Some(vec![35.0; run.deviations.len()]));
    }
    let warm = separate(&campaign, &all);
    close(u_at_end(&warm, "EZZ").unwrap(), 15.0 * 0.72 * 3.5625, 0.05, "EZZ");
    assert!(
        words(&warm.labels)
            .iter()
            .any(|label| label.contains("alpha_per_k is included in the scales"))
    );
}

/// A bow in every axis; an exact beam over a part of X, and one askew inside the box.
#[test]
fn a_beam_over_a_part_of_the_travel_is_freed_of_the_shapes() {
    let (truth, leant, _) = machine(7);
    let all = runs(1, Pass::Forward, &leant.readings(None));
    let at = |name: &str, index: usize| truth.curves[term(name)][index];
    let part = MeasuredLine {
        direction: PerAxis::from_fn(|axis| f64::from(axis == Axis::X)),
        // 0 to 450 mm: interval ends 0 to 15.
        slope_um_per_m: at("EXX", 15) / 0.45,
        u_um_per_m: Some(0.1),
        ends: Some([mm(0.0, 100.0, 100.0), mm(450.0, 100.0, 100.0)]),
    };
    // From (180, 144, 0) to (720, 576, 0): indices 6 and 24 of X and Y.
    let (x, y) = (540.0f64, 432.0f64);
    let length = x.hypot(y);
    let rise = |of: &str, along: &str| {
        let name = format!("E{of}{along}");
        at(&name, 24) - at(&name, 6)
    };
    let skew = MeasuredLine {
        direction: PerAxis { x: x / length, y: y / length, z: 0.0 },
        slope_um_per_m: 1000.0
            * (x * (rise("X", "X") + rise("X", "Y")) + y * (rise("Y", "X") + rise("Y", "Y")))
            / (length * length),
        u_um_per_m: Some(0.1),
        ends: Some([mm(180.0, 144.0, 0.0), mm(720.0, 576.0, 0.0)]),
    };
    let y_axis = truth.lines(&[Axis::Y], Some(0.1));
    for lines in [vec![part, y_axis[0]], vec![part, skew]] {
        let found = solved(&truth.volume, lines, &all);
        for term in ErrorTerm::ALL {
            let (found, wanted) = (curve(&found, term), &truth.curves[term]);
            close(found[30], wanted[30], 0.03, &term.to_string());
        }
    }
    // Taken for the whole travel it is wrong by micrometres.
    let careless = MeasuredLine { ends: None, ..part };
    let found = solved(&truth.volume, vec![careless, y_axis[0]], &all);
    let far = curve(&found, term("EXX"))[30] - truth.curves[term("EXX")][30];
    assert!(far.abs() > 0.3, "{far}");
}

#[test]
fn what_rests_on_an_unknown_uncertainty_has_none() {
    let (_, found) = measured(8, |lines| lines[0].u_um_per_m = None);
    // Three lines: X takes part in all scales.
    for name in ["EXX", "EYY", "EZZ"] {
        assert_eq!(u_at_end(&found, name), None, "{name}");
    }
    for name in ["EXY", "EXZ", "EYZ"] {
        assert!(u_at_end(&found, name).is_some(), "{name}");
    }
    let (truth, leant, mut random) = machine(8);
    let noisy = with_noise(&leant.readings(None), SIGMA_UM, &mut random);
    let mut lines = truth.lines(&[Axis::X, Axis::Y], Some(0.5));
    lines[0].u_um_per_m = None;
    let found = solved(&truth.volume, lines, &runs(1, Pass::Forward, &noisy));
    assert_eq!(u_at_end(&found, "EXX"), None);
    assert_eq!(u_at_end(&found, "EZZ"), None, "it is what X and Y leave of S");
    assert!(u_at_end(&found, "EYY").is_some(), "the linear axis itself");
    assert!(words(&found.labels).iter().any(|label| label.contains("add `u_um_per_m`")));
}

#[test]
fn squareness_has_one_uncertainty() {
    let (truth, leant, mut random) = machine(9);
    let readings = with_noise(&leant.readings(None), SIGMA_UM, &mut random);
    let all = runs(1, Pass::Forward, &readings);
    for setup in [SetUp::Solve, SetUp::AssumePerfect] {
        let measurement = simulated::measurement(&truth.volume, setup, Frame::XPrimary);
        let campaign = simulated::campaign(&measurement, truth.lines(&Axis::ALL, Some(0.5)));
        let found = separate(&campaign, &all);
        for (plane, name) in [(Plane::Xy, "EXY"), (Plane::Xz, "EXZ"), (Plane::Yz, "EYZ")] {
            let metres = truth.volume.size[term(name).along].mm() / 1000.0;
            let u = found.u_squareness.of(plane).map(|u| u.u_um_per_m).unwrap();
            close(u_at_end(&found, name).unwrap(), u * metres, 1e-12, name);
        }
    }
}

/// With unknown scales the tilts let a share of them into the squareness: its size is said.
#[test]
fn the_share_of_unknown_scales_in_squareness_is_told() {
    let mut machine = Machine::perfect(&volume([900.0, 720.0, 720.0], 10));
    machine.set_slope("EXX", 20.0);
    machine.set_slope("EYY", -31.25);
    for d in Diagonal::ALL {
        // Lean of 0.4 mrad, not the same in the four set-ups.
        let size = if d == Diagonal::Npp { 8e-4 } else { 4e-4 };
        let (x, y) = (
            machine.volume.cosine(Axis::X) * d.sign(Axis::X),
            machine.volume.cosine(Axis::Y) * d.sign(Axis::Y),
        );
        let length = x.hypot(y);
        machine.lean[d] = PerAxis { x: size * y / length, y: -size * x / length, z: 0.0 };
    }
    let all = runs(1, Pass::Forward, &machine.readings(None));
    let found = solved(&machine.volume, Vec::new(), &all);
    let xy = found.squareness_um_per_m.xy.unwrap();
    assert!(xy.abs() > 0.005, "the tilts let scales in: {xy}");
    // Length of (20, −31.25, 0) is 37.1: all of it is open, because S = 0.
    let told = found.metric.leak.xy * 20f64.hypot(31.25);
    assert!(xy.abs() <= told * 1.05 + 1e-3, "{xy} against {told}");
    assert!(xy.abs() >= told * 0.2, "{xy} against {told}");
    assert!(
        words(&found.labels).iter().any(|label| label.contains("through the tilts of the mirror"))
    );
}
