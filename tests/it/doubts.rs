//! What the readings say against a result reaches every output: `separate`, its table, the kit
//! made from the readings, and the kit made from the table.
use crate::support::diagonals::{
    Machine, campaign, measurement, naive, normal, runs, solved, volume, with_noise, words,
};
use crate::support::visit::{Ran, Visit, number};
use nonius::inputs::job::{Frame, SetUp};
use nonius::machine::separation::noise::{NoiseSource, Outlier, ReadingPlace};
use nonius::machine::separation::{Separation, separate};
use nonius::quantity::axis::{Axis, ErrorTerm, PerAxis};
use nonius::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Run, Volume};
use nonius::quantity::units::Deviation;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;

mod in_every_output;

const SIGMA_UM: f64 = 0.3;

fn box_30() -> Volume {
    volume([900.0, 720.0, 720.0], 30)
}

/// Several forward runs of a machine with noise.
fn repeated(seed: u64, count: u32) -> Vec<Run> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let readings = Machine::random(&box_30(), &mut random).readings(None);
    let mut noisy = || with_noise(&readings, SIGMA_UM, &mut random);
    (1..=count).flat_map(|run| runs(run, Pass::Forward, &noisy())).collect()
}

fn disturb(runs: &mut [Run], diagonal: Diagonal, number: u32, node: usize, um: f64) {
    let of = |run: &&mut Run| run.diagonal == diagonal && run.number == number;
    let run = runs.iter_mut().find(of).unwrap();
    run.deviations[node] = Deviation::from_um(run.deviations[node].um() + um);
}

#[track_caller]
fn says(said: &str, words: &[&str]) {
    words.iter().for_each(|words| assert!(said.contains(words), "expected `{words}` in\n{said}"));
}

fn place(diagonal: Diagonal, run: u32, node: usize) -> ReadingPlace {
    ReadingPlace { diagonal, pass: Pass::Forward, run: Some(run), node }
}

#[test]
fn a_disturbed_reading_of_three_runs_is_named_with_its_run() {
    for (um, least) in [(8.0, 20), (3.0, 20), (2.0, 15)] {
        let mut named = 0;
        for seed in 0..20 {
            let mut runs = repeated(seed, 3);
            disturb(&mut runs, Diagonal::Pnp, 2, 40, um);
            let found = naive(&box_30(), &runs);
            let first = found.closure.outliers.first();
            let is_it = |o: &&Outlier| o.readings == [place(Diagonal::Pnp, 2, 40)];
            if let Some(outlier) = first.filter(is_it) {
                named += 1;
                assert!((outlier.size_um - um).abs() < 5.0 * SIGMA_UM, "{outlier:?}");
                assert!((outlier.of_mean_um - outlier.size_um / 3.0).abs() < 1e-12);
                let noise = found.noise.unwrap();
                assert_eq!(noise.source, NoiseSource::Repeats);
                assert!((noise.sigma_um - SIGMA_UM).abs() < 0.03, "{noise:?}");
                let words = &words(&found.doubts)[0];
                says(words, &["PNP run 2 forward node 40", "that U does not hold"]);
            }
        }
        assert!(named >= least, "{um} um: {named} of 20");
    }
}

fn accusation(found: &Separation) -> Option<String> {
    words(&found.doubts).into_iter().find(|doubt| doubt.starts_with("as if"))
}

/// The four programs are alike: a file under another diagonal's name is complete and plausible. Two names
/// exchanged, three passed on in a ring, and two pairs at once: what `names` gives for PPP, NPP, PNP, PPN.
#[test]
fn readings_under_each_others_name_are_told() {
    use Diagonal::{Npp, Pnp, Ppn, Ppp};
    let [some, repeats] = [&[(1, 3), (2, 1), (3, 3)][..], &[(3, 3)]];
    let ring = "readings named PPP, NPP, PNP were those of PNP, PPP, NPP:";
    let pairs = "readings named PPP, NPP, PNP, PPN were those of NPP, PPP, PPN, PNP:";
    for (names, campaigns, said) in [
        ([Ppp, Npp, Ppn, Pnp], some, "readings of PNP and PPN were exchanged"),
        ([Npp, Ppp, Pnp, Ppn], some, "readings of PPP and NPP were exchanged"),
        ([Ppp, Ppn, Pnp, Npp], some, "readings of NPP and PPN were exchanged"),
        ([Npp, Pnp, Ppp, Ppn], repeats, ring),
        ([Npp, Ppp, Ppn, Pnp], repeats, pairs),
    ] {
        for (seed, count) in campaigns {
            let mut runs = repeated(*seed, *count);
            for run in &mut runs {
                let walked = Diagonal::ALL.iter().position(|walked| *walked == run.diagonal);
                run.diagonal = names[walked.unwrap()];
            }
            let doubts = words(&naive(&box_30(), &runs).doubts);
            assert!(doubts[0].starts_with(&format!("as if the {said}")), "{said}: {doubts:?}");
        }
    }
    for seed in 0..20 {
        assert_eq!(accusation(&naive(&box_30(), &repeated(seed, 1))), None);
    }
}

/// A walk whose steps went in another order than the job records, read against its own nominal list.
#[test]
fn steps_in_another_order_are_told() {
    let [x, y, z] = Axis::ALL;
    for recorded in [[x, y, z], [z, x, y]] {
        for order in Axis::ORDERS {
            let mut random = ChaCha8Rng::seed_from_u64(5);
            let mut machine = Machine::random(&box_30(), &mut random);
            machine.volume.order = order;
            let readings = with_noise(&machine.readings(None), 0.1, &mut random);
            let box_ = Volume { order: recorded, ..box_30() };
            let found = naive(&box_, &runs(1, Pass::Forward, &readings));
            let [a, b, c] = order;
            let said = format!("or the steps went {a}, {b}, {c}: ");
            let is_told = accusation(&found).map(|doubt| doubt.contains(&said));
            assert_eq!(is_told, (order != recorded).then_some(true), "{said}, not {recorded:?}");
        }
    }
}

/// A machine without waves tells no names apart: that is said, and no finding.
#[test]
fn names_that_readings_cannot_show_are_said_and_change_no_answer() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut smooth = Machine::perfect(&box_30());
    for term in ErrorTerm::ALL {
        smooth.set(term, |t| 9.0 * t + 200.0 * t * (1.0 - t));
    }
    let readings = with_noise(&smooth.readings(None), SIGMA_UM, &mut random);
    let found = naive(&box_30(), &runs(1, Pass::Forward, &readings));
    let hardly = |found: &Separation| {
        let mut labels = words(&found.labels).into_iter();
        labels.find(|label| label.starts_with("these readings would hardly show"))
    };
    let said = hardly(&found).unwrap();
    let pairs = ["NPP and PNP", "NPP and PPN", "PNP and PPN"];
    says(&said, &[&pairs[..], &["nor steps that went X, Z, Y or"]].concat());
    assert!(!said.contains("PPP"), "{said}");
    assert!(found.doubts.is_empty(), "{:?}", words(&found.doubts));
    let rough = (1..10).map(|seed| naive(&box_30(), &repeated(seed, 3)));
    assert!(rough.map(|found| hardly(&found)).any(|said| said.is_none()));
}

/// With few steps and no stated noise a disturbed reading makes the scatter that it would have to
/// stand out of.
#[test]
fn a_scatter_far_above_the_noise_is_a_finding() {
    let box_4 = volume([400.0, 300.0, 200.0], 4);
    let found = |off_um: f64, noise_um: Option<f64>, count: u32| {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let readings = Machine::random(&box_4, &mut random).readings(None);
        let noisy = |run| {
            let mut noisy = with_noise(&readings, SIGMA_UM, &mut random);
            noisy[Diagonal::Ppp][1] += off_um;
            runs(run, Pass::Forward, &noisy)
        };
        let all: Vec<Run> = (1..=count).flat_map(noisy).collect();
        let measurement = measurement(&box_4, SetUp::Solve, Frame::XPrimary);
        let mut campaign = campaign(&measurement, Vec::new());
        campaign.stated.noise_um = noise_um;
        words(&separate(&campaign, &all).doubts).join("\n")
    };
    let above = "from the scatter of the closure: above the 1 µm that are assumed";
    says(&found(50.0, None, 1), &[above, "state `noise_um`"]);
    says(&found(1000.0, None, 1), &["above the 1 µm"]);
    for sound in [found(0.0, None, 1), found(0.0, Some(0.3), 3), found(0.0, Some(0.2), 3)] {
        assert_eq!(sound, "");
    }
    let twice = "more than 2 times the 0.1 µm that `noise_um` states";
    says(&found(0.0, Some(0.1), 3), &[twice]);
}

#[test]
fn with_two_runs_either_may_be_the_disturbed_one() {
    let mut runs = repeated(3, 2);
    disturb(&mut runs, Diagonal::Ppn, 1, 17, -9.0);
    let found = naive(&box_30(), &runs);
    let [outlier] = &found.closure.outliers[..] else { panic!("the closure names it once more") };
    let mut places = outlier.readings.clone();
    places.sort();
    assert_eq!(places, [1, 2].map(|run| place(Diagonal::Ppn, run, 17)));
}

/// Readings of a perfect machine whose X rolls evenly by `urad` over its travel, the levers alone:
/// a step of Y or Z made at x is turned by the roll there.
fn rolling(volume: &Volume, urad: f64) -> PerDiagonal<Vec<f64>> {
    let n = volume.steps;
    PerDiagonal::from_fn(|d| {
        let at = |node: usize| {
            let made = |axis: usize| node / 3 + usize::from(node % 3 > axis);
            let place = |axis: Axis, index: usize| {
                let from_low = if d.sign(axis) > 0.0 { made(index) } else { n - made(index) };
                volume.along_mm(axis, from_low)
            };
            let roll = urad * place(Axis::X, 0) / volume.size.x.mm();
            let y = -roll * place(Axis::Z, 2) / 1000.0;
            let z = roll * place(Axis::Y, 1) / 1000.0;
            let along = |axis: Axis, um: f64| d.sign(axis) * volume.cosine(axis) * um;
            along(Axis::Y, y) + along(Axis::Z, z)
        };
        (0..=3 * n).map(|node| at(node) - at(0)).collect()
    })
}

#[test]
fn roll_makes_ramps_and_accuses_no_reading() {
    let volume = box_30();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for (sigma, urad) in [(0.0, 20.0), (0.1, 60.0)] {
        let readings = with_noise(&rolling(&volume, urad), sigma, &mut random);
        let found = naive(&volume, &runs(1, Pass::Forward, &readings));
        let ramps = found.closure.ramps.as_ref().unwrap();
        assert!(ramps.is_roll(), "{ramps:?}");
        assert!(found.closure.outliers.is_empty(), "{:?}", found.closure.outliers);
        // 2 b (c/R) times the roll of + less that of - diagonals, from -A to +A over the axis.
        let wanted = 4.0 * 24e-3 * volume.cosine(Axis::Z) * urad * 29.0 / 30.0;
        let tolerance = 4.0 * sigma * ramps.u.y + 0.07 * wanted;
        assert!((ramps.change_um.y.abs() - wanted).abs() < tolerance, "{ramps:?} {wanted}");
        assert!((ramps.change_um.y + ramps.change_um.z).abs() < 2.0 * tolerance);
        assert!(words(&found.doubts)[0].contains("roll of an axis that carries others"));
        let scatter = found.closure.sigma_um().unwrap();
        assert!((scatter - sigma).abs() < 0.03, "{scatter}");
    }
}

/// Too small a noise makes U too small; too large a one is only wasteful.
#[test]
fn the_scatter_is_tested_to_both_sides() {
    let readings = repeated(1, 1);
    for (noise_um, larger) in [(SIGMA_UM, None), (0.15, Some(true)), (0.6, Some(false))] {
        let measurement = measurement(&box_30(), SetUp::AssumePerfect, Frame::AsMeasured);
        let mut campaign = campaign(&measurement, Vec::new());
        campaign.stated.noise_um = Some(noise_um);
        let found = separate(&campaign, &readings);
        let test = found.closure.test(&found.noise.unwrap()).unwrap();
        let doubts = words(&found.doubts).concat();
        if let Some(larger) = larger {
            assert!(test.probability < 1e-6 && test.larger == larger, "{test:?}");
            assert_eq!([doubts.contains("scatters more"), doubts.is_empty()], [larger, !larger]);
        } else {
            assert!(test.probability > 0.01, "{test:?}");
        }
    }
    let alone = naive(&box_30(), &readings);
    assert_eq!(alone.closure.test(&alone.noise.unwrap()), None, "nothing to test against");
}

#[test]
fn a_perfect_set_up_is_contradicted_by_the_mean_of_the_closure() {
    let mut machine = Machine::perfect(&box_30());
    machine.lean[Diagonal::Npp] = PerAxis { x: 0.0, y: 50e-6, z: -50e-6 };
    let runs = runs(1, Pass::Forward, &machine.readings(None));
    let doubts = words(&naive(&box_30(), &runs).doubts);
    assert!(doubts[0].contains("set-up is assumed perfect"), "{doubts:?}");
    let solved = solved(&box_30(), machine.lines(&Axis::ALL, Some(0.5)), &runs);
    assert!(solved.stands(), "{:?}", solved.doubts);
}
