//! The redundancy of formula (7), what stated uncertainties do through it, beams over a part, what is not known.
use crate::support::diagonals::*;
use crate::support::{holds, term, words};
use nonius::inputs::job::{AxisMaterial, Frame, Material, SetUp, StatedUncertainty};
use nonius::machine::separation::{MeasuredLine, Separation, separate};
use nonius::quantity::{Axis, Diagonal, ErrorTerm, Pass, PerAxis, Plane, Run};

/// A machine, and its readings with a mirror that leans and such a noise.
fn measured(seed: u64, sigma: f64) -> (Machine, Vec<Run>) {
    let mut random = seeded(seed);
    let truth = Machine::random(&volume([900.0, 720.0, 720.0], 30), &mut random).x_primary();
    let mut leant = truth.clone();
    leant.lean_randomly(3e-4, &mut random);
    let readings = with_noise(&leant.readings(None), sigma, &mut random);
    (truth, runs(1, Pass::Forward, &readings))
}

/// Solved with linear axes of u = 0.5 µm/m that a change was made to.
fn found_with(
    seed: u64,
    axes: &[Axis],
    change: impl Fn(&mut [MeasuredLine]),
) -> (Machine, Separation) {
    let (truth, all) = measured(seed, SIGMA_UM);
    let mut lines = truth.lines(axes, Some(0.5));
    change(&mut lines);
    let found = solved(&truth.volume, lines, &all);
    (truth, found)
}

fn u_at_end(found: &Separation, name: &str) -> Option<f64> {
    found.errors.mean[term(name)].as_ref().unwrap().u_um().map(|u| *u.last().unwrap())
}

fn u_squareness(found: &Separation, plane: Plane) -> f64 {
    found.metric.squareness(plane).u.unwrap().u
}

#[track_caller]
fn labelled(found: &Separation, wanted: &[&str]) {
    holds(&words(&found.labels).concat(), wanted);
}

#[test]
fn a_wrong_linear_axis_is_not_swallowed() {
    let (truth, found) = found_with(3, &Axis::ALL, |lines| lines[2].slope_um_per_m += 50.0);
    let agreement = found.agreement.as_ref().unwrap();
    assert_eq!(agreement.freedom, 1);
    assert!(agreement.probability.unwrap() < 1e-12);
    // What the two other axes and the totals say of Z: S, without Z.
    let z = &agreement.lines[2];
    close(z.by_others_um_per_m.unwrap(), truth.slope(term("EZZ")), 4.0, "Z");
    let (difference, u) = (z.difference_um_per_m.unwrap(), z.u_difference_um_per_m.unwrap());
    close(difference, 50.0, 4.0, "difference");
    close(z.ratio().unwrap(), difference / u, 1e-9, "ratio");
    labelled(&found, &["linear axes and diagonals DISAGREE", "Z by +"]);
    assert!(!found.stands(), "what they may falsify counts by its size");
    assert!(u_at_end(&found, "EZZ").is_some());
}

#[test]
fn true_linear_axes_agree_and_each_is_confirmed_by_the_others() {
    let (truth, found) = found_with(3, &Axis::ALL, |_| ());
    let agreement = found.agreement.as_ref().unwrap();
    assert!(agreement.probability.unwrap() > 0.01);
    assert!(found.doubts.is_empty(), "{:?}", found.doubts);
    for (line, axis) in agreement.lines.iter().zip(Axis::ALL) {
        assert_eq!(line.name, axis.to_string());
        let slope = truth.slope(ErrorTerm { of: axis, along: axis });
        let far = (line.by_others_um_per_m.unwrap() - slope).abs();
        assert!(far < 3.5 * line.u_difference_um_per_m.unwrap(), "{axis}: {far}");
        // V/c⁴ for the totals' mean and c² shares of the others: all three have one ratio.
        let ratio = line.ratio().unwrap().abs();
        close(ratio, agreement.chi_squared.sqrt(), 2e-3, "ratio");
    }
    // u(Z) against the rest, by hand: √(u² + (X/Z)⁴u² + (Y/Z)⁴u² + (R/Z)⁴·2σ²/(4R²)).
    let [x, y, z] = Axis::ALL.map(|axis| truth.volume.cosine(axis).powi(2));
    let sigma = found.noise.unwrap().sigma_um / (truth.volume.diagonal_mm() / 1000.0);
    let lines = 0.25 * (1.0 + (x / z).powi(2) + (y / z).powi(2));
    let wanted = (lines + sigma * sigma / 2.0 / z / z).sqrt();
    let u = agreement.lines[2].u_difference_um_per_m.unwrap();
    close(u, wanted, 0.002, "u of the difference");
}

/// The same readings; X and Y with u = 0.1 µm/m; a material at a temperature that is stated or recorded.
fn with_stated(
    seed: u64,
    stated: StatedUncertainty,
    material: Option<Material>,
    recorded_c: Option<f64>,
) -> Separation {
    let (truth, mut all) = measured(seed, 0.001);
    let mut measurement = measurement(&truth.volume, SetUp::Solve, Frame::XPrimary);
    measurement.material = material;
    let lines = truth.lines(&[Axis::X, Axis::Y], Some(0.1));
    let mut campaign = campaign(&measurement, lines);
    campaign.stated = stated;
    for run in &mut all {
        let record = recorded_c.map(|celsius| vec![celsius; run.deviations.len()]);
        run.temperatures_c = PerAxis::from_fn(|_| record.clone());
    }
    separate(&campaign, &all)
}

fn steel(axes: &[Axis], temperature_c: Option<f64>) -> Option<Material> {
    let steel = AxisMaterial { alpha_per_k: 11.5e-6, temperature_c };
    let axes = PerAxis::from_fn(|axis| axes.contains(&axis).then_some(steel));
    Some(Material { material_corrected: true, air_corrected: true, axes })
}

/// Z²p_zz = S − X²p_xx − Y²p_yy: a scale of the diagonals is 3.5625 = (R/Z)² times as large in EZZ, and none of EXX.
#[test]
fn the_laser_goes_through_the_solution() {
    let plain = with_stated(5, exact(), None, None);
    let stated = StatedUncertainty { laser_ppm: Some(1.0), ..exact() };
    let found = with_stated(5, stated, None, None);
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
            close(*a, *b, 1e-6, term);
        }
    }
}

#[test]
fn the_temperature_and_the_coefficient_of_expansion_go_through_the_solution() {
    let stated = StatedUncertainty { temperature_k: Some(1.0), ..exact() };
    let found = with_stated(5, stated, steel(&Axis::ALL, Some(22.0)), None);
    close(u_at_end(&found, "EZZ").unwrap(), 29.50, 0.05, "EZZ");
    close(u_at_end(&found, "EXX").unwrap(), 0.09, 1e-3, "EXX");
    // Of X alone: X² share only.
    let found = with_stated(5, stated, steel(&[Axis::X], Some(22.0)), None);
    let wanted = 11.5 * 0.72 * (900.0f64 / 720.0).powi(2);
    close(u_at_end(&found, "EZZ").unwrap(), wanted, 0.05, "EZZ by X");
    labelled(&found, &["temperature_k is included in the scales for X", "but not for Y, Z"]);
    // Recorded temperatures serve the coefficient.
    let stated = StatedUncertainty { alpha_per_k: Some(1e-6), ..exact() };
    let cold = with_stated(6, stated, steel(&Axis::ALL, None), None);
    labelled(&cold, &["alpha_per_k is stated but not included for any axis"]);
    let warm = with_stated(6, stated, steel(&Axis::ALL, None), Some(35.0));
    close(u_at_end(&warm, "EZZ").unwrap(), 15.0 * 0.72 * 3.5625, 0.05, "EZZ");
    labelled(&warm, &["alpha_per_k is included in the scales"]);
}

#[test]
fn changes_between_set_ups_make_squareness_uncertain() {
    let stated = StatedUncertainty { setup_ppm: Some(2.3), ..exact() };
    let found = with_stated(5, stated, None, None);
    for plane in Plane::ALL {
        let (a, b) = plane.axes();
        let area = found.volume.size[a].mm() * found.volume.size[b].mm();
        // R²/(2 V_j V_k) · u(ε)
        let wanted = 2.3 * found.volume.diagonal_mm().powi(2) / (2.0 * area);
        close(u_squareness(&found, plane), wanted, 0.01, plane.key());
    }
    let silent = with_stated(5, exact(), None, None);
    labelled(&silent, &["setup_ppm is not stated"]);
    let said = words(&silent.labels).concat();
    let sizes = ["xy 1.42, xz 1.42, yz 1.78", "xy 1.43, xz 1.43, yz 1.78"];
    assert!(sizes.iter().any(|sizes| said.contains(sizes)), "{said}");
}

/// A bow in every axis; an exact beam over a part of X, and one askew inside the box.
#[test]
fn a_beam_over_a_part_of_the_travel_is_freed_of_the_shapes() {
    let (truth, all) = measured(7, 0.0);
    let at = |of: Axis, along: Axis, index: usize| truth.curves[ErrorTerm { of, along }][index];
    let part = MeasuredLine {
        direction: PerAxis::from_fn(|axis| f64::from(axis == Axis::X)),
        // 0 to 450 mm: interval ends 0 to 15.
        slope_um_per_m: at(Axis::X, Axis::X, 15) / 0.45,
        u_um_per_m: Some(0.1),
        ends: Some([mm(0.0, 100.0, 100.0), mm(450.0, 100.0, 100.0)]),
    };
    // From (180, 144, 0) to (720, 576, 0): indices 6 and 24 of X and Y.
    let travel = [540.0f64, 432.0f64, 0.0];
    let length = travel[0].hypot(travel[1]);
    let rise = |of| {
        let rises = [Axis::X, Axis::Y].map(|along| at(of, along, 24) - at(of, along, 6));
        rises[0] + rises[1]
    };
    let skew = MeasuredLine {
        direction: PerAxis::from_fn(|axis| travel[axis as usize] / length),
        slope_um_per_m: 1000.0 * (travel[0] * rise(Axis::X) + travel[1] * rise(Axis::Y))
            / (length * length),
        u_um_per_m: Some(0.1),
        ends: Some([mm(180.0, 144.0, 0.0), mm(720.0, 576.0, 0.0)]),
    };
    let y_axis = truth.lines(&[Axis::Y], Some(0.1))[0];
    for lines in [vec![part, y_axis], vec![part, skew]] {
        let found = solved(&truth.volume, lines, &all);
        for term in ErrorTerm::ALL {
            close(curve(&found, term)[30], truth.curves[term][30], 0.03, term);
        }
    }
    // Taken for the whole travel it is wrong by micrometres.
    let careless = MeasuredLine { ends: None, ..part };
    let found = solved(&truth.volume, vec![careless, y_axis], &all);
    let far = curve(&found, term("EXX"))[30] - truth.curves[term("EXX")][30];
    assert!(far.abs() > 0.3, "{far}");
}

#[test]
fn what_rests_on_an_unknown_uncertainty_has_none_and_squareness_has_one() {
    // Three lines: X takes part in all scales.
    let (_, found) = found_with(8, &Axis::ALL, |lines| lines[0].u_um_per_m = None);
    for name in ["EXX", "EYY", "EZZ", "EXY", "EXZ", "EYZ"] {
        let known = term(name).is_cross();
        assert_eq!(u_at_end(&found, name).is_some(), known, "{name}");
    }
    // Two: EZZ is what X and Y leave of S, EYY the linear axis itself.
    let (_, found) = found_with(8, &[Axis::X, Axis::Y], |lines| lines[0].u_um_per_m = None);
    for (name, known) in [("EXX", false), ("EZZ", false), ("EYY", true)] {
        assert_eq!(u_at_end(&found, name).is_some(), known, "{name}");
    }
    labelled(&found, &["add `u_um_per_m`"]);
    // Without redundancy.
    assert_eq!(found.agreement, None);
    labelled(&found, &["nothing checks the linear axes"]);
    let (truth, all) = measured(9, SIGMA_UM);
    for setup in [SetUp::Solve, SetUp::AssumePerfect] {
        let measurement = measurement(&truth.volume, setup, Frame::XPrimary);
        let campaign = campaign(&measurement, truth.lines(&Axis::ALL, Some(0.5)));
        let found = separate(&campaign, &all);
        for (plane, name) in [(Plane::Xy, "EXY"), (Plane::Xz, "EXZ"), (Plane::Yz, "EYZ")] {
            let metres = truth.volume.size[term(name).along].mm() / 1000.0;
            let u = u_squareness(&found, plane);
            close(u_at_end(&found, name).unwrap(), u * metres, 1e-12, name);
        }
    }
}

#[test]
fn the_share_of_unknown_scales_in_squareness_is_told() {
    let mut machine = Machine::perfect(&volume([900.0, 720.0, 720.0], 10));
    machine.set(term("EXX"), |t| 0.9 * 20.0 * t);
    machine.set(term("EYY"), |t| 0.72 * -31.25 * t);
    for d in Diagonal::ALL {
        // Lean of 0.4 mrad, not the same in the four set-ups.
        let size = if d == Diagonal::Npp { 8e-4 } else { 4e-4 };
        let [x, y] = [Axis::X, Axis::Y].map(|axis| machine.volume.cosine(axis) * d.sign(axis));
        let length = x.hypot(y);
        machine.lean[d] = PerAxis { x: size * y / length, y: -size * x / length, z: 0.0 };
    }
    let all = runs(1, Pass::Forward, &machine.readings(None));
    let found = solved(&machine.volume, Vec::new(), &all);
    let xy = found.metric.squareness(Plane::Xy).um_per_m.unwrap();
    assert!(xy.abs() > 0.005, "the tilts let scales in: {xy}");
    // Length of (20, −31.25, 0) is 37.1: all of it is open, because S = 0.
    let told = found.metric.leak.of(Plane::Xy) * 20f64.hypot(31.25);
    assert!(xy.abs() <= told * 1.05 + 1e-3, "{xy} against {told}");
    assert!(xy.abs() >= told * 0.2, "{xy} against {told}");
    labelled(&found, &["through the tilts of the mirror"]);
}
