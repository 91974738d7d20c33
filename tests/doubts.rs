//! What the readings say against a result reaches every output: `separate`, its table, the kit
//! made from the readings, and the kit made from the table.
#![allow(
    clippy::disallowed_methods,
    reason = "powers of a test are compared with a tolerance, not printed"
)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

#[path = "support/diagonals.rs"]
mod simulated;

#[path = "support/run.rs"]
mod run;

use nonius::inputs::job::{Frame, SetUp};
use nonius::machine::separation::noise::NoiseSource;
use nonius::machine::separation::noise::ReadingPlace;
use nonius::machine::separation::{Separation, separate};
use nonius::quantity::axis::{Axis, ErrorTerm, PerAxis};
use nonius::quantity::diagonal::{Diagonal, Pass, PerDiagonal, Run, Volume};
use nonius::quantity::units::Deviation;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use run::nonius;
use serde_json::Value;
use simulated::{Machine, campaign, measurement, naive, runs, volume, with_noise, words};
use std::fs;
use std::path::Path;
use std::process::Output;

const SIGMA_UM: f64 = 0.3;

fn box_30() -> Volume {
    volume([900.0, 720.0, 720.0], 30)
}

/// Several forward runs of a machine with noise.
fn repeated(seed: u64, count: u32) -> Vec<Run> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let machine = Machine::random(&box_30(), &mut random);
    let readings = machine.readings(None);
    (1..=count)
        .flat_map(|run| {
            runs(
                run,
                Pass::Forward,
                &with_noise(&readings, SIGMA_UM, &mut random),
            )
        })
        .collect()
}

fn disturb(runs: &mut [Run], diagonal: Diagonal, number: u32, node: usize, um: f64) {
    let of = |run: &&mut Run| run.diagonal == diagonal && run.number == number;
    let run = runs.iter_mut().find(of).unwrap();
    run.deviations[node] = Deviation::from_um(run.deviations[node].um() + um);
}

fn place(diagonal: Diagonal, run: u32, node: usize) -> ReadingPlace {
    ReadingPlace {
        diagonal,
        pass: Pass::Forward,
        run: Some(run),
        node,
    }
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
            let hit = first.filter(|o| o.readings == [place(Diagonal::Pnp, 2, 40)]);
            named += usize::from(hit.is_some());
            if let Some(outlier) = hit {
                assert!((outlier.size_um - um).abs() < 5.0 * SIGMA_UM, "{outlier:?}");
                assert!((outlier.of_mean_um - outlier.size_um / 3.0).abs() < 1e-12);
                let noise = found.noise.unwrap();
                assert_eq!(noise.source, NoiseSource::Repeats);
                assert!((noise.sigma_um - SIGMA_UM).abs() < 0.03, "{noise:?}");
                let words = &words(&found.doubts)[0];
                assert!(words.contains("PNP run 2 forward node 40"), "{words}");
                assert!(words.contains("that U does not hold"), "{words}");
            }
        }
        assert!(named >= least, "{um} um: {named} of 20");
    }
}

/// Runs under other names: `walked` is the diagonal whose readings stand under a name.
fn renamed(mut runs: Vec<Run>, name_of: impl Fn(Diagonal) -> Diagonal) -> Vec<Run> {
    for run in &mut runs {
        run.diagonal = name_of(run.diagonal);
    }
    runs
}

fn accusation(found: &Separation) -> Option<String> {
    words(&found.doubts)
        .into_iter()
        .find(|doubt| doubt.starts_with("as if"))
}

/// The four programs are alike: a file under another diagonal's name is complete and plausible.
#[test]
fn readings_under_each_others_name_are_told() {
    let pairs = [
        (Diagonal::Pnp, Diagonal::Ppn),
        (Diagonal::Ppp, Diagonal::Npp),
        (Diagonal::Npp, Diagonal::Ppn),
    ];
    for (one, other) in pairs {
        for (seed, count) in [(1, 3), (2, 1), (3, 3)] {
            let exchanged = |diagonal| match diagonal {
                diagonal if diagonal == one => other,
                diagonal if diagonal == other => one,
                diagonal => diagonal,
            };
            let found = naive(&box_30(), &renamed(repeated(seed, count), exchanged));
            let said = format!("as if the readings of {one} and {other} were exchanged");
            assert!(
                words(&found.doubts)[0].starts_with(&said),
                "{:?}",
                words(&found.doubts)
            );
        }
    }
    for seed in 0..20 {
        let found = naive(&box_30(), &repeated(seed, 1));
        assert_eq!(accusation(&found), None);
    }
}

/// Three names passed on in a ring, and two pairs at once.
#[test]
fn more_than_one_exchange_is_named_as_it_happened() {
    use Diagonal::{Npp, Pnp, Ppn, Ppp};
    let ring = |diagonal| match diagonal {
        Ppp => Npp,
        Npp => Pnp,
        Pnp => Ppp,
        Ppn => Ppn,
    };
    let found = naive(&box_30(), &renamed(repeated(3, 3), ring));
    let said = "as if the readings named PPP, NPP, PNP were those of PNP, PPP, NPP:";
    assert!(
        words(&found.doubts)[0].starts_with(said),
        "{:?}",
        words(&found.doubts)
    );
    let pairs = |diagonal| match diagonal {
        Ppp => Npp,
        Npp => Ppp,
        Pnp => Ppn,
        Ppn => Pnp,
    };
    let found = naive(&box_30(), &renamed(repeated(3, 3), pairs));
    let said = "as if the readings named PPP, NPP, PNP, PPN were those of NPP, PPP, PPN, PNP:";
    assert!(
        words(&found.doubts)[0].starts_with(said),
        "{:?}",
        words(&found.doubts)
    );
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
            let box_ = Volume {
                order: recorded,
                ..box_30()
            };
            let found = naive(&box_, &runs(1, Pass::Forward, &readings));
            let [a, b, c] = order;
            let said = format!("or the steps went {a}, {b}, {c}: ");
            match accusation(&found) {
                Some(doubt) => {
                    assert!(order != recorded && doubt.contains(&said), "{said} {doubt}")
                }
                None => assert_eq!(order, recorded, "{:?}", words(&found.doubts)),
            }
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
    for words in [
        "NPP and PNP",
        "NPP and PPN",
        "PNP and PPN",
        "nor steps that went X, Z, Y or",
    ] {
        assert!(said.contains(words), "{said}");
    }
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
    let said = found(50.0, None, 1);
    for words in [
        "from the scatter of the closure: above the 1 µm that are assumed",
        "state `noise_um`",
    ] {
        assert!(said.contains(words), "{said}");
    }
    assert!(found(1000.0, None, 1).contains("above the 1 µm"));
    for sound in [
        found(0.0, None, 1),
        found(0.0, Some(0.3), 3),
        found(0.0, Some(0.2), 3),
    ] {
        assert_eq!(sound, "");
    }
    let said = found(0.0, Some(0.1), 3);
    assert!(
        said.contains("more than 2 times the 0.1 µm that `noise_um` states"),
        "{said}"
    );
}

#[test]
fn with_two_runs_either_may_be_the_disturbed_one() {
    let mut runs = repeated(3, 2);
    disturb(&mut runs, Diagonal::Ppn, 1, 17, -9.0);
    let found = naive(&box_30(), &runs);
    let mut places = found.closure.outliers[0].readings.clone();
    places.sort();
    let wanted = [1, 2].map(|run| place(Diagonal::Ppn, run, 17));
    assert_eq!(places, wanted);
    assert_eq!(
        found.closure.outliers.len(),
        1,
        "the closure names it once more"
    );
}

#[test]
fn sound_readings_are_rarely_doubted() {
    for count in [1, 3] {
        let doubted = (0..200)
            .filter(|seed| {
                let mut runs = repeated(5000 + seed, count);
                // Frame and set-up are right, so only the tests of noise can speak.
                runs.truncate(4 * usize::try_from(count).unwrap());
                !naive(&box_30(), &runs).doubts.is_empty()
            })
            .count();
        assert!(doubted <= 10, "{doubted} of 200 with {count} run(s)");
    }
}

/// Readings of a perfect machine whose X rolls evenly by `urad` over its travel, the levers alone:
/// a step of Y or Z made at x is turned by the roll there.
fn rolling(volume: &Volume, urad: f64) -> PerDiagonal<Vec<f64>> {
    let n = volume.steps;
    PerDiagonal::from_fn(|d| {
        let at = |node: usize| {
            let made = |axis: usize| node / 3 + usize::from(node % 3 > axis);
            let place = |axis: Axis, index: usize| {
                let from_low = if d.sign(axis) > 0.0 {
                    made(index)
                } else {
                    n - made(index)
                };
                volume.along_mm(axis, from_low)
            };
            let roll = urad * place(Axis::X, 0) / volume.size.x.mm();
            let error = PerAxis {
                x: 0.0,
                y: -roll * place(Axis::Z, 2) / 1000.0,
                z: roll * place(Axis::Y, 1) / 1000.0,
            };
            Axis::ALL
                .into_iter()
                .map(|axis| d.sign(axis) * volume.cosine(axis) * error[axis])
                .sum::<f64>()
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
        assert!(
            found.closure.outliers.is_empty(),
            "{:?}",
            found.closure.outliers
        );
        // 2 b (c/R) times the roll of + less that of - diagonals, from -A to +A over the axis.
        let wanted = 4.0 * 24e-3 * volume.cosine(Axis::Z) * urad * 29.0 / 30.0;
        let tolerance = 4.0 * sigma * ramps.u.y + 0.07 * wanted;
        assert!(
            (ramps.change_um.y.abs() - wanted).abs() < tolerance,
            "{ramps:?} {wanted}"
        );
        assert!((ramps.change_um.y + ramps.change_um.z).abs() < 2.0 * tolerance);
        assert!(words(&found.doubts)[0].contains("roll of an axis that carries others"));
        let scatter = found.closure.sigma_um().unwrap();
        assert!((scatter - sigma).abs() < 0.03, "{scatter}");
    }
}

#[test]
fn means_and_single_w_scatter_as_expected() {
    let volume = box_30();
    let perfect = Machine::perfect(&volume).readings(None);
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let (mut single, mut mean, mut ramp, mut count) = (0.0, 0.0, 0.0, 0.0);
    let mut last = None;
    for _ in 0..200 {
        let readings = with_noise(&perfect, SIGMA_UM, &mut random);
        let found = naive(&volume, &runs(1, Pass::Forward, &readings));
        for axis in Axis::ALL {
            single += found.closure.by_interval[axis][7].powi(2);
            mean += found.closure.mean[axis].powi(2);
            ramp += found.closure.ramps.as_ref().unwrap().change_um[axis].powi(2);
            count += 1.0;
        }
        last = Some(found.closure);
    }
    let closure = last.unwrap();
    let expected = 2.0 * std::f64::consts::SQRT_2;
    assert!((closure.scatter.x - expected).abs() < 1e-12);
    let near = |sum: f64, wanted: f64, what: &str| {
        let found = (sum / count).sqrt();
        assert!(
            (found / wanted - 1.0).abs() < 0.1,
            "{what}: {found}, expected {wanted}"
        );
    };
    near(single, expected * SIGMA_UM, "w");
    near(mean, closure.u_mean_um(Axis::X, SIGMA_UM), "mean");
    let u: f64 = closure.ramps.unwrap().u.iter().map(|(_, u)| u * u).sum();
    near(ramp, SIGMA_UM * (u / 3.0).sqrt(), "ramp");
}

fn stated_noise(noise_um: f64) -> Separation {
    let measurement = simulated::measurement(&box_30(), SetUp::AssumePerfect, Frame::AsMeasured);
    let mut campaign = simulated::campaign(&measurement, Vec::new());
    campaign.stated.noise_um = Some(noise_um);
    separate(&campaign, &repeated(1, 1))
}

#[test]
fn the_scatter_is_tested_to_both_sides() {
    let test = |noise_um: f64| {
        let found = stated_noise(noise_um);
        found.closure.test(&found.noise.unwrap()).unwrap()
    };
    let fits = test(SIGMA_UM);
    assert!(fits.probability > 0.01, "{fits:?}");
    for (noise_um, larger) in [(0.15, true), (0.6, false)] {
        let test = test(noise_um);
        assert!(test.probability < 1e-6, "{test:?}");
        assert_eq!(test.larger, larger);
    }
    // Too small a noise makes U too small; too large a one is only wasteful.
    assert!(
        stated_noise(0.15)
            .doubts
            .iter()
            .any(|d| d.to_string().contains("scatters more"))
    );
    assert!(stated_noise(0.6).doubts.is_empty());
    let alone = naive(&box_30(), &repeated(1, 1));
    assert_eq!(
        alone.closure.test(&alone.noise.unwrap()),
        None,
        "nothing to test against"
    );
}

#[test]
fn a_perfect_set_up_is_contradicted_by_the_mean_of_the_closure() {
    let mut machine = Machine::perfect(&box_30());
    machine.lean[Diagonal::Npp] = PerAxis {
        x: 0.0,
        y: 50e-6,
        z: -50e-6,
    };
    let found = naive(&box_30(), &runs(1, Pass::Forward, &machine.readings(None)));
    assert!(
        words(&found.doubts)[0].contains("set-up is assumed perfect"),
        "{:?}",
        words(&found.doubts)
    );
    let solved = simulated::solved(
        &box_30(),
        machine.lines(&Axis::ALL, Some(0.5)),
        &runs(1, Pass::Forward, &machine.readings(None)),
    );
    assert!(solved.stands(), "{:?}", solved.doubts);
}

// As a user runs it.

fn fixture(case: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/diagonals")
        .join(case)
}

fn copy(
    case: &str,
    job: impl Fn(String) -> String,
    readings: impl Fn(String) -> String,
) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let read = |name: &str| fs::read_to_string(fixture(case).join(name)).unwrap();
    let put = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    put("readings.csv", readings(read("readings.csv")));
    put("job.toml", job(read("job.toml")));
    directory
}

fn said(output: &Output, status: i32) -> String {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let talk = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(status), "{text}{talk}");
    text + &talk
}

fn json(output: &Output, status: i32) -> Value {
    said(output, status);
    serde_json::from_slice(&output.stdout).unwrap()
}

fn manifest(directory: &Path, kit: &str) -> Value {
    serde_json::from_slice(&fs::read(directory.join(kit).join("manifest.json")).unwrap()).unwrap()
}

/// The job of the table that `separate -o errors.csv` wrote.
fn two_step(directory: &Path) {
    let job = fs::read_to_string(directory.join("job.toml")).unwrap();
    let (before, after) = job.split_once("[measurement.step_diagonal]").unwrap();
    let (_, after) = after.split_once("[compensation]").unwrap();
    let before = before.replace("readings = \"readings.csv\"", "errors = \"errors.csv\"");
    let job = format!("{before}[compensation]{after}");
    fs::write(directory.join("nine.toml"), job).unwrap();
}

/// Case B with 0.3 µm noise and one reading 20 µm off.
fn disturbed_case_b() -> tempfile::TempDir {
    let spoil = |text: String| {
        let mut random = ChaCha8Rng::seed_from_u64(20);
        let mut out = String::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (before, um) = line.rsplit_once(',').unwrap();
            let Ok(um) = um.parse::<f64>() else {
                out += &format!("{line}\n");
                continue;
            };
            let off = if before == "PPP,1,forward,58,x" {
                20.0
            } else {
                0.0
            };
            let noise = SIGMA_UM * simulated::normal(&mut random);
            let um = if before.contains(",0,") {
                um
            } else {
                um + noise + off
            };
            out += &format!("{before},{um:.6}\n");
        }
        out
    };
    copy("case_b_setup", |job| job, spoil)
}

#[test]
fn a_disturbed_reading_reaches_every_output() {
    let directory = disturbed_case_b();
    let words = "PPP forward node 58";
    let text = said(
        &nonius(directory.path(), "separate job.toml -o errors.csv"),
        1,
    );
    assert!(text.contains("DOUBTFUL") && text.contains(words), "{text}");
    let page = json(
        &nonius(directory.path(), "separate job.toml --format json"),
        1,
    );
    assert!(page["doubts"].to_string().contains(words), "{page}");
    let csv = fs::read_to_string(directory.path().join("errors.csv")).unwrap();
    assert!(
        csv.lines()
            .any(|l| l.starts_with("# doubt:") && l.contains(words)),
        "{csv}"
    );
    two_step(directory.path());
    for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
        let text = said(
            &nonius(directory.path(), &format!("generate {job} -o {kit}")),
            1,
        );
        let (_, verdict) = text.split_once("verdict: undecided").unwrap();
        assert!(verdict.contains(words), "{text}");
        let page = manifest(directory.path(), kit);
        assert!(page["doubts"].to_string().contains(words), "{page}");
        let verify = format!("verify {job} --tables {kit} --format json");
        let page = json(&nonius(directory.path(), &verify), 1);
        assert_eq!(page["verdict"], "undecided");
        assert!(page["causes"].to_string().contains(words), "{page}");
    }
}

#[test]
fn a_kit_without_scales_is_undecided_and_says_what_is_missing() {
    let without = |job: String| {
        let (before, after) = job
            .split_once("[[measurement.step_diagonal.linear]]")
            .unwrap();
        let (_, after) = after.split_once("[compensation]").unwrap();
        format!("{before}[compensation]{after}")
    };
    let directory = copy("case_b_setup", without, |readings| readings);
    let text = said(
        &nonius(directory.path(), "separate job.toml -o errors.csv"),
        1,
    );
    assert!(text.contains("Determined: 6 of 9 errors"), "{text}");
    two_step(directory.path());
    for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
        let text = said(
            &nonius(directory.path(), &format!("generate {job} -o {kit}")),
            1,
        );
        assert!(text.contains("verdict: undecided"), "{text}");
        assert!(text.contains("EXX   not determined"), "{text}");
        assert!(text.contains("no table for EXX, EYY, EZZ: not determined by the measurement: scale of X, Y and Z can be traded"), "{text}");
        let omitted = manifest(directory.path(), kit)["omitted"].clone();
        let terms = omitted
            .as_array()
            .unwrap()
            .iter()
            .map(|o| o["term"].as_str().unwrap());
        assert_eq!(terms.collect::<Vec<_>>(), ["EXX", "EYY", "EZZ"]);
    }
    // Whoever asks for the six alone misses nothing.
    let asked = |job: String| {
        without(job).replace(
            "[compensation]\n",
            "[compensation]\nterms = [\"EYX\", \"EZX\", \"EXY\", \"EZY\", \"EXZ\", \"EYZ\"]\n",
        )
    };
    let directory = copy("case_b_setup", asked, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    assert!(!text.contains("DOUBTFUL"), "{text}");
}

fn with_policy(policy: &str) -> impl Fn(String) -> String + '_ {
    move |job| {
        job.replace(
            "[compensation]\n",
            &format!("[compensation]\nbacklash = \"{policy}\"\n"),
        )
    }
}

#[test]
fn readings_in_both_directions_need_a_word_on_the_reversal() {
    let directory = copy("case_d_bidirectional", |job| job, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 2);
    assert!(text.contains("`backlash` is not stated"), "{text}");
    let end = |policy: &str| {
        let directory = copy("case_d_bidirectional", with_policy(policy), |readings| {
            readings
        });
        said(
            &nonius(directory.path(), "separate job.toml -o errors.csv"),
            0,
        );
        let csv = fs::read_to_string(directory.path().join("errors.csv")).unwrap();
        let last = csv.lines().rfind(|line| line.starts_with("x,")).unwrap();
        let cell = last
            .split(',')
            .nth(last.matches(",+,").count() + 2)
            .unwrap();
        cell.parse::<f64>().unwrap()
    };
    let page = json(
        &nonius(
            &fixture("case_d_bidirectional"),
            "separate job.toml --format json",
        ),
        0,
    );
    let wanted = |name: &str| page["errors"][name]["deviation_um"][10].as_f64().unwrap();
    assert!((end("mean") - wanted("EXX")).abs() < 1e-5);
    assert!((end("forward-only") - wanted("EXX+")).abs() < 1e-5);
    assert!((end("forward-only") - end("mean")).abs() > 0.5);
}

#[test]
fn a_reversal_that_no_curve_holds_is_said_beside_the_figures() {
    for policy in ["mean", "forward-only"] {
        let directory = copy("case_d_bidirectional", with_policy(policy), |readings| {
            readings
        });
        said(
            &nonius(directory.path(), "separate job.toml -o errors.csv"),
            0,
        );
        two_step(directory.path());
        for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
            let text = said(
                &nonius(directory.path(), &format!("generate {job} -o {kit}")),
                1,
            );
            assert!(text.contains("verdict: undecided"), "{text}");
            assert!(!text.contains("reversal not measured"), "{text}");
            let marked = text
                .lines()
                .find(|line| line.starts_with("EXX  ") && line.contains("without"));
            // B_d of the reference is 9.146 µm.
            assert!(
                marked.unwrap().contains("without reversal (about 9.146 µm"),
                "{text}"
            );
            let page = manifest(directory.path(), kit);
            assert_eq!(page["forecast"]["without_reversal_um"], 9.146);
        }
    }
}

#[test]
fn an_assumed_set_up_is_said_of_the_kit_made_from_the_table() {
    let directory = copy("case_a_ideal", |job| job, |readings| readings);
    said(
        &nonius(directory.path(), "separate job.toml -o errors.csv"),
        0,
    );
    two_step(directory.path());
    let text = said(
        &nonius(directory.path(), "generate nine.toml -o kit --explain"),
        0,
    );
    for words in [
        "set-up assumed perfect",
        "reversal is mixed into the curves",
        "angular errors without a measurement, counted as zero",
    ] {
        assert!(
            text.contains(&format!("note: {words}")) || text.contains(words),
            "{text}"
        );
        let notes = manifest(directory.path(), "kit")["notes"].to_string();
        assert!(notes.contains(words), "{notes}");
    }
}

#[test]
fn where_nothing_is_asked_nothing_is_judged_and_worse_is_said() {
    let no_limit = |job: String| {
        let (before, _) = job.split_once("[acceptance]").unwrap();
        // A count of 20 µm: the tables cannot follow the curves.
        before.replace("siemens-840d-sl", "generic").replace(
            "[compensation.axes.x]\n",
            "[compensation.axes.x]\ndetection_unit_um = 20.0\n",
        )
    };
    let directory = copy("case_b_setup", no_limit, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    assert!(
        text.contains("no acceptance is stated in the job, so there is nothing to judge"),
        "{text}"
    );
    assert!(!text.contains("verdict: pass"), "{text}");
    assert!(
        text.contains("WARNING: diagonal PPP becomes larger with the tables: 18.543 →"),
        "{text}"
    );
    let notes = manifest(directory.path(), "kit")["notes"].to_string();
    assert!(notes.contains("diagonal PPP becomes larger"), "{notes}");
}

/// A thousandth of the golden errors: values in mm under a column in µm.
#[test]
fn values_in_mm_under_a_column_in_um_are_doubted() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let table = fs::read_to_string(golden.join("errors.csv")).unwrap();
    let thousandth = |cell: &str| cell.parse::<f64>().map(|um| (um / 1000.0).to_string());
    let slipped = |line: &str| -> String {
        let cells = line.split(',').enumerate().map(|(column, cell)| {
            let is_value = column > 1;
            thousandth(cell)
                .ok()
                .filter(|_| is_value)
                .unwrap_or_else(|| cell.to_string())
        });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    let directory = tempfile::tempdir().unwrap();
    let put = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    put("errors.csv", table.lines().map(slipped).collect());
    let job = fs::read_to_string(golden.join("generic.toml")).unwrap();
    put("job.toml", job.clone());
    let words = "no error exceeds 0.018 µm, and a machine tool below 0.1 µm throughout is unlikely";
    for command in ["generate job.toml -o kit", "verify job.toml --tables kit"] {
        let text = said(&nonius(directory.path(), command), 1);
        assert!(text.contains("verdict: undecided"), "{text}");
        assert!(text.contains(&format!("DOUBTFUL: {words}")), "{text}");
    }
    let text = said(&nonius(directory.path(), "assess job.toml"), 0);
    assert!(text.contains(&format!("doubt: {words}")), "{text}");
    // Whoever states a noise below the errors means them.
    let noise = "date = \"2026-11-20\"\nuncertainty = { noise_um = 0.002 }\n";
    put("fine.toml", job.replace("date = \"2026-11-20\"\n", noise));
    let text = said(&nonius(directory.path(), "generate fine.toml -o fine"), 0);
    assert!(!text.contains("DOUBTFUL"), "{text}");
    // A noise above them says nothing of their unit.
    let coarse = job.replace("date = \"2026-11-20\"\n", &noise.replace("0.002", "0.5"));
    put("coarse.toml", coarse);
    let text = said(
        &nonius(directory.path(), "generate coarse.toml -o coarse"),
        1,
    );
    assert!(text.contains("or state a `noise_um` below it"), "{text}");
    let tiny = "axis,position_mm,ex_um\nx,0,0\nx,900,0.00042\n";
    put("errors.csv", tiny.to_string());
    let text = said(&nonius(directory.path(), "generate job.toml -o tiny"), 1);
    assert!(text.contains("no error exceeds 0.00042 µm"), "{text}");
}
