//! Laws of the separation, on machines that the test simulates with arithmetic of its own.
use crate::support::diagonals::*;
use crate::support::{error_table, short_or, words};
use nonius::inputs::job::{Frame, Levers, Reflector, SetUp};
use nonius::machine::separation::corrections::AngleEffects;
use nonius::machine::separation::curves::Curve;
use nonius::machine::separation::{Separation, separate};
use nonius::quantity::{
    Axis, Chain, Diagonal, Direction, ErrorTerm, Pass, PerAxis, PerDiagonal, PerTerm, Plane,
    Rotation, Run, Volume,
};
use proptest::prelude::*;
use std::fmt::Display;

/// Sums of a few hundred readings of up to a millimetre.
const DUST_UM: f64 = 1e-8;

fn all_close(found: &[f64], wanted: &[f64], tolerance: f64, what: impl Display) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (index, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        close(*found, *wanted, tolerance, format_args!("{what} {index}"));
    }
}

fn curves_close(separation: &Separation, wanted: &PerTerm<Vec<f64>>, tolerance: f64) {
    for term in ErrorTerm::ALL {
        all_close(curve(separation, term), &wanted[term], tolerance, term);
    }
}

fn forward(machine: &Machine) -> Vec<Run> {
    runs(1, Pass::Forward, &machine.readings(None))
}

fn any_machine() -> impl Strategy<Value = (Machine, u64)> {
    let edge = || 200.0..2000.0f64;
    let corner = || -1000.0..1000.0f64;
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let orders = prop::sample::select(orders.to_vec());
    let volume = ((edge(), edge(), edge()), (corner(), corner(), corner()), orders, 2usize..24);
    (volume, any::<u64>()).prop_map(|((size, start, order, steps), seed)| {
        let (start, size) = (mm(start.0, start.1, start.2), mm(size.0, size.1, size.2));
        let volume = Volume { start, size, steps, order: order.map(|index| Axis::ALL[index]) };
        (Machine::random(&volume, &mut seeded(seed)), seed)
    })
}

fn directed() -> impl Iterator<Item = (ErrorTerm, Direction)> {
    ErrorTerm::ALL.into_iter().flat_map(|term| Direction::BOTH.map(|way| (term, way)))
}

/// X becomes Y, Y becomes Z, Z becomes X.
fn next(axis: Axis) -> Axis {
    Axis::ALL[((axis as usize) + 1) % 3]
}

fn before(axis: Axis) -> Axis {
    next(next(axis))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(short_or(32, 96)))]

    #[test]
    fn a_machine_comes_back((machine, _) in any_machine()) {
        let separation = naive(&machine.volume, &forward(&machine));
        curves_close(&separation, &machine.curves, DUST_UM);
        for plane in Plane::ALL {
            close(squareness_error(&machine.x_primary(), &separation, plane), 0.0, 1e-6, plane.key());
        }
        for axis in Axis::ALL {
            for w in &separation.closure.by_interval[axis] {
                close(*w, 0.0, DUST_UM, "closure");
            }
        }
    }

    #[test]
    fn the_result_is_linear_in_the_readings((machine, seed) in any_machine(), a in -3.0..3.0f64, b in -3.0..3.0f64) {
        let mut random = seeded(seed ^ 1);
        let first = with_noise(&machine.readings(None), 2.0, &mut random);
        let second = with_noise(&machine.readings(None), 2.0, &mut random);
        let sum = PerDiagonal::from_fn(|d| {
            first[d].iter().zip(&second[d]).map(|(x, y)| a * x + b * y).collect()
        });
        let [first, second, sum] = [first, second, sum].map(|r| naive(&machine.volume, &runs(1, Pass::Forward, &r)));
        let wanted = PerTerm::from_fn(|term| {
            let pairs = curve(&first, term).iter().zip(curve(&second, term));
            pairs.map(|(x, y)| a * x + b * y).collect::<Vec<f64>>()
        });
        curves_close(&sum, &wanted, DUST_UM);
        for plane in Plane::ALL {
            let of = |s: &Separation| s.metric.squareness(plane).um_per_m.unwrap();
            close(of(&sum), a * of(&first) + b * of(&second), 1e-6, plane.key());
        }
    }

    #[test]
    fn renamed_axes_rename_the_results((machine, seed) in any_machine()) {
        let volume = &machine.volume;
        let mut random = seeded(seed ^ 2);
        let readings = with_noise(&machine.readings(None), 1.0, &mut random);
        let renamed_volume = Volume {
            start: PerAxis::from_fn(|axis| volume.start[before(axis)]),
            size: PerAxis::from_fn(|axis| volume.size[before(axis)]),
            steps: volume.steps,
            order: volume.order.map(next),
        };
        let [ppp, npp, pnp, ppn] = Diagonal::ALL;
        let renamed = PerDiagonal::from_fn(|d| readings[[ppp, ppn, npp, pnp][d as usize]].clone());
        let plain = naive(volume, &runs(1, Pass::Forward, &readings));
        let found = naive(&renamed_volume, &runs(1, Pass::Forward, &renamed));
        let wanted = PerTerm::from_fn(|term| {
            let old = ErrorTerm { of: before(term.of), along: before(term.along) };
            curve(&plain, old).to_vec()
        });
        curves_close(&found, &wanted, DUST_UM);
        for (new, old) in [(Plane::Yz, Plane::Xy), (Plane::Xy, Plane::Xz), (Plane::Xz, Plane::Yz)] {
            let (new, old) = (found.metric.squareness(new).um_per_m, plain.metric.squareness(old).um_per_m);
            close(new.unwrap(), old.unwrap(), 1e-6, "squareness");
        }
    }

    #[test]
    fn a_tilted_mirror_changes_nothing_of_first_order((machine, seed) in any_machine(), size in 1e-5..5e-4f64) {
        let mut random = seeded(seed ^ 3);
        let straight = machine.x_primary();
        let mut leant = straight.clone();
        leant.lean_randomly(size, &mut random);
        // Formula (7) neglects products of slopes: (50 um/m)^2 = 0.0025 um/m, some of them, by the gain.
        let gain = Axis::ALL.into_iter().map(|axis| 1.0 / machine.volume.cosine(axis)).fold(0.0, f64::max);
        let most = straight.curves.iter().map(|(_, curve)| largest(curve)).fold(0.0, f64::max);
        for (axes, u) in [(&Axis::ALL[..], Some(0.5)), (&[Axis::X, Axis::Y], None)] {
            let found = solved(&machine.volume, straight.lines(axes, u), &forward(&leant));
            curves_close(&found, &straight.curves, 0.01 * gain * gain + 4.0 * size * most * gain);
            for plane in Plane::ALL {
                close(squareness_error(&straight, &found, plane), 0.0, 0.01 * gain * gain, plane.key());
            }
            for d in Diagonal::ALL {
                let tilt = found.tilts.unwrap()[d];
                close(tilt.arcsec, size.to_degrees() * 3600.0, 0.05 * gain * gain, "arcsec");
                let same = dot(&tilt.direction, &leant.lean[d]) / size;
                prop_assert!(same > 1.0 - 1e-5 * (5e-4 / size).powi(2) * gain.powi(4), "direction: {same}");
            }
        }
    }

    #[test]
    fn the_turn_gives_the_lost_motion_from_each_diagonal((mut machine, seed) in any_machine(), own_zero: bool) {
        machine.lost_um = PerAxis { x: 8.0, y: 5.0, z: -3.0 };
        let mut all = forward(&machine);
        let mut random = seeded(seed ^ 9);
        let mut shifted = machine.readings(Some(false));
        for d in Diagonal::ALL {
            let offset = if own_zero { 20.0 * normal(&mut random) } else { 0.0 };
            shifted[d].iter_mut().for_each(|um| *um += offset);
        }
        all.extend(runs(1, Pass::Reverse, &shifted));
        let mut given = measurement(&machine.volume, SetUp::AssumePerfect, Frame::AsMeasured);
        // A zero of its own tells nothing; two steps leave no interval to know the noise from.
        given.overrun = (own_zero || machine.volume.steps < 3).then_some(false);
        let mut campaign = campaign(&given, Vec::new());
        campaign.reverse_zero_known = !own_zero;
        let found = separate(&campaign, &all);
        prop_assert!(found.closure.outliers.is_empty());
        prop_assert_eq!(found.overrun, Some(false));
        let turn = found.turn.as_ref().unwrap();
        for axis in Axis::ALL {
            let lost = machine.lost_um[axis];
            for d in Diagonal::ALL {
                close(turn.by_diagonal[d][axis].um, lost, DUST_UM, format!("{d} {axis}"));
            }
            for of in Axis::ALL {
                let term = ErrorTerm { of, along: axis };
                close(turn.reversal[term].um, if of == axis { lost } else { 0.0 }, DUST_UM, term);
            }
        }
        for (term, way) in directed() {
            let found = &found.errors.directed(way).unwrap()[term].as_ref().unwrap().deviation_um;
            all_close(found, &machine.directed(term, way), DUST_UM, format!("{term} {way}"));
        }
    }

    #[test]
    fn both_directions_are_told_apart_after_an_overrun((machine, seed) in any_machine()) {
        let mut random = seeded(seed ^ 4);
        let minus = Machine::random(&machine.volume, &mut random);
        // A pass moves some axes in + and others in -: both machines' curves, each where it moves.
        let mut both = machine.clone();
        for term in ErrorTerm::ALL {
            let pairs = || machine.curves[term].iter().zip(&minus.curves[term]);
            both.curves[term] = pairs().map(|(plus, minus)| (plus + minus) / 2.0).collect();
            both.apart_um[term] = pairs().map(|(plus, minus)| plus - minus).collect();
        }
        let mut all = forward(&both);
        all.extend(runs(1, Pass::Reverse, &both.readings(Some(true))));
        let mut stated = measurement(&machine.volume, SetUp::AssumePerfect, Frame::AsMeasured);
        stated.overrun = Some(true);
        let found = separate(&campaign(&stated, Vec::new()), &all);
        // The mean slope of both is put back; assume-perfect leaves it as it is.
        for (term, way) in directed() {
            let truth = if way == Direction::Plus { &machine } else { &minus };
            let found = &found.errors.directed(way).unwrap()[term].as_ref().unwrap().deviation_um;
            all_close(found, &truth.curves[term], DUST_UM, format!("{term} {way}"));
        }
        prop_assert!(words(&found.undetermined).iter().any(|words| words.contains("reversal of each axis")));
    }
}

#[test]
fn rank_and_words_follow_the_linear_axes() {
    let mut random = seeded(5);
    let machine = Machine::random(&box_of(12), &mut random).x_primary();
    let runs = forward(&machine);
    // What is said of it: tests/it/separate.rs.
    for (axes, rank) in [(&[][..], 4), (&[Axis::X], 5), (&[Axis::X, Axis::Y], 6)] {
        let found = solved(&machine.volume, machine.lines(axes, Some(0.5)), &runs);
        assert_eq!(found.metric.rank, rank);
        assert_eq!(found.undetermined.is_empty(), rank == 6, "{:?}", found.undetermined);
        assert_eq!(found.tilts.is_some(), rank == 6);
        for axis in Axis::ALL {
            let known = rank == 6 || axes.contains(&axis);
            assert_eq!(found.errors.mean[own(axis)].is_some(), known, "{axis}");
        }
        for plane in Plane::ALL {
            close(squareness_error(&machine, &found, plane), 0.0, 0.002, plane.key());
        }
        for term in ErrorTerm::ALL {
            let at = |index| machine.volume.along_mm(term.along, index) / 1000.0;
            let curve = machine.curves[term].iter().enumerate();
            let beside = curve.map(|(index, um)| um - machine.slope(term) * at(index));
            all_close(&found.shapes[term], &beside.collect::<Vec<_>>(), DUST_UM, term);
        }
    }
}

#[test]
fn a_disturbed_reading_is_named_with_its_twins() {
    let volume = box_of(30);
    for seed in 0..24 {
        let mut random = seeded(seed);
        let machine = Machine::random(&volume, &mut random);
        let mut readings = with_noise(&machine.readings(None), 0.3, &mut random);
        let d = Diagonal::ALL[usize::try_from(seed).unwrap() % 4];
        let node = 4 + 3 * usize::try_from(seed).unwrap() + usize::try_from(seed / 4).unwrap() % 3;
        readings[d][node] += 7.0;
        let found = naive(&volume, &runs(1, Pass::Forward, &readings));
        let named = found.closure.outliers.iter().find(|outlier| {
            let mut readings = outlier.readings.iter();
            readings.any(|r| (r.diagonal, r.node, r.pass) == (d, node, Pass::Forward))
        });
        let named = named.unwrap_or_else(|| panic!("{d} {node}: {:?}", found.closure.outliers));
        close(named.size_um.abs(), 7.0, 3.0, "size");
        assert!(named.readings.len() <= 4, "{:?}", named.readings);
        let sigma = found.noise.unwrap().sigma_um;
        close(sigma, 0.3, 0.1, "noise without the disturbed reading");
    }
}

/// What is made of one rotation that grows evenly by 1 µrad over the box, levers from its middle, µm: all of it is false.
fn false_bows(
    volume: &Volume,
    chain: Chain,
    rotation: Rotation,
    mirror: Reflector,
) -> PerTerm<Curve> {
    let size = volume.size[rotation.along].mm();
    let (axis, angle) = (rotation.along.key(), ["ea", "eb", "ec"][rotation.about as usize]);
    let text = format!("axis,position_mm,{angle}_urad\n{axis},0,-0.5\n{axis},{size},0.5\n");
    let table = error_table(&text);
    let mut measurement = measurement(volume, SetUp::AssumePerfect, Frame::AsMeasured);
    measurement.target = mirror;
    let origin = PerAxis::from_fn(|axis| volume.size[axis].mm() / 2.0);
    let levers = (chain.order(), Levers::default(), origin);
    let effects = AngleEffects::of_table(&table, levers, &measurement);
    let of = |d| effects.of(d, Pass::Forward).unwrap().to_vec();
    naive(volume, &runs(1, Pass::Forward, &PerDiagonal::from_fn(of))).shapes
}

/// docs/method.md §10: c₀V/8 by the lever, as much by the mirror, and no more for any other angle
/// and order of the axes.
#[test]
fn an_angle_that_grows_evenly_makes_the_bow_of_the_formula() {
    let volume = box_of(30);
    let yaw = Rotation { about: Axis::Z, along: Axis::X };
    let straightness = ErrorTerm::from_name("EYX").unwrap();
    for (mirror, wanted) in [(Reflector::Retroreflector, 0.1125), (Reflector::FlatMirror, 0.225)] {
        let chain = Chain::parse("wXYZt").unwrap();
        let bows = false_bows(&volume, chain, yaw, mirror);
        let bow = largest(&bows[straightness]);
        close(bow, wanted, 0.003, "EYX");
    }
    for order in ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] {
        let chain = Chain::parse(&format!("w{order}t")).unwrap();
        for rotation in Rotation::all() {
            let limit = match rotation.about == rotation.along {
                true => 0.01,
                false => 1.001 * 2.0 * volume.size[rotation.along].mm() / 8.0 / 1000.0,
            };
            let bows = false_bows(&volume, chain, rotation, Reflector::FlatMirror);
            for (term, bow) in bows.iter() {
                let bow = largest(bow);
                assert!(bow <= limit, "{order} {rotation} {term}: {bow}");
            }
        }
    }
}
