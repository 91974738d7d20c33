//! What the readings say against a result reaches every output: `separate`, its table, the kits made of both.
use crate::support::diagonals::*;
use crate::support::*;
use nonius::inputs::job::{Frame, SetUp};
use nonius::machine::separation::readings::{NoiseSource, Outlier, ReadingPlace};
use nonius::machine::separation::separate;
use nonius::quantity::{
    Axis, Deviation, Diagonal, ErrorTerm, Pass, PerAxis, PerDiagonal, Run, Volume,
};
use nonius::text::Finding;
use serde_json::Value;

fn repeated(seed: u64, count: u32) -> Vec<Run> {
    let mut random = seeded(seed);
    let readings = Machine::random(&box_of(30), &mut random).readings(None);
    let mut noisy = || with_noise(&readings, SIGMA_UM, &mut random);
    (1..=count).flat_map(|run| runs(run, Pass::Forward, &noisy())).collect()
}

fn disturb(runs: &mut [Run], diagonal: Diagonal, number: u32, node: usize, um: f64) {
    let of = |run: &&mut Run| run.diagonal == diagonal && run.number == number;
    let run = runs.iter_mut().find(of).unwrap();
    run.deviations[node] = Deviation::from_um(run.deviations[node].um() + um);
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
            let found = naive(&box_of(30), &runs);
            let first = found.closure.outliers.first();
            let is_it = |o: &&Outlier| o.readings == [place(Diagonal::Pnp, 2, 40)];
            if let Some(outlier) = first.filter(is_it) {
                named += 1;
                assert!((outlier.size_um - um).abs() < 5.0 * SIGMA_UM, "{outlier:?}");
                assert!((outlier.of_mean_um - outlier.size_um / 3.0).abs() < 1e-12);
                let noise = found.noise.unwrap();
                assert_eq!(noise.source, NoiseSource::Repeats);
                assert!((noise.sigma_um - SIGMA_UM).abs() < 0.03, "{noise:?}");
                let words = words(&found.labels).concat();
                holds(&words, &["PNP run 2 forward node 40", "counts in full beside U"]);
            }
        }
        assert!(named >= least, "{um} um: {named} of 20");
    }
}

fn beginning(findings: &[Finding], start: &str) -> Option<String> {
    words(findings).into_iter().find(|words| words.starts_with(start))
}

/// Two names exchanged, three passed on in a ring, two pairs at once: what `names` gives for PPP, NPP, PNP, PPN.
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
            let doubts = words(&naive(&box_of(30), &runs).doubts);
            assert!(doubts[0].starts_with(&format!("as if the {said}")), "{said}: {doubts:?}");
        }
    }
    for seed in 0..20 {
        assert_eq!(beginning(&naive(&box_of(30), &repeated(seed, 1)).doubts, "as if"), None);
    }
}

/// A walk whose steps went in another order than the job records, read against its own nominal list.
#[test]
fn steps_in_another_order_are_told() {
    let [x, y, z] = Axis::ALL;
    for recorded in [[x, y, z], [z, x, y]] {
        for order in Axis::ORDERS {
            let mut random = seeded(5);
            let mut machine = Machine::random(&box_of(30), &mut random);
            machine.volume.order = order;
            let readings = with_noise(&machine.readings(None), 0.1, &mut random);
            let box_ = Volume { order: recorded, ..box_of(30) };
            let found = naive(&box_, &runs(1, Pass::Forward, &readings));
            let [a, b, c] = order;
            let said = format!("or the steps went {a}, {b}, {c}: ");
            let is_told = beginning(&found.doubts, "as if").map(|doubt| doubt.contains(&said));
            assert_eq!(is_told, (order != recorded).then_some(true), "{said}, not {recorded:?}");
        }
    }
}

#[test]
fn names_that_readings_cannot_show_are_said_and_change_no_answer() {
    let mut random = seeded(1);
    let mut smooth = Machine::perfect(&box_of(30));
    for term in ErrorTerm::ALL {
        smooth.set(term, |t| 9.0 * t + 200.0 * t * (1.0 - t));
    }
    let readings = with_noise(&smooth.readings(None), SIGMA_UM, &mut random);
    let found = naive(&box_of(30), &runs(1, Pass::Forward, &readings));
    let hardly = |labels: &[Finding]| beginning(labels, "these readings cannot detect");
    let said = hardly(&found.labels).unwrap();
    let pairs = ["NPP and PNP", "NPP and PPN", "PNP and PPN"];
    holds(&said, &[&pairs[..], &["or whether the steps went X, Z, Y or"]].concat());
    assert!(!said.contains("PPP"), "{said}");
    assert!(found.doubts.is_empty(), "{:?}", words(&found.doubts));
    let rough = |seed| naive(&box_of(30), &repeated(seed, 3));
    assert!((1..10).any(|seed| hardly(&rough(seed).labels).is_none()));
}

/// With few steps a disturbed reading makes the scatter that it would have to stand out of.
#[test]
fn a_scatter_far_above_the_noise_is_a_finding() {
    let box_4 = volume([400.0, 300.0, 200.0], 4);
    let found = |off_um: f64, noise_um: Option<f64>, count: u32| {
        let mut random = seeded(2);
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
    holds(&found(50.0, None, 1), &[above, "state `noise_um`"]);
    holds(&found(1000.0, None, 1), &["above the 1 µm"]);
    let sound =
        [(None, 1), (Some(0.3), 3), (Some(0.2), 3)].map(|(um, count)| found(0.0, um, count));
    assert_eq!(sound, [""; 3]);
    holds(&found(0.0, Some(0.1), 3), &["more than 2 times the 0.1 µm that `noise_um` states"]);
}

#[test]
fn with_two_runs_either_may_be_the_disturbed_one() {
    let mut runs = repeated(3, 2);
    disturb(&mut runs, Diagonal::Ppn, 1, 17, -9.0);
    let found = naive(&box_of(30), &runs);
    let [outlier] = &found.closure.outliers[..] else { panic!("the closure names it once more") };
    let mut places = outlier.readings.clone();
    places.sort();
    assert_eq!(places, [1, 2].map(|run| place(Diagonal::Ppn, run, 17)));
}

/// Readings of a perfect machine whose X rolls evenly by `urad` over its travel; a step of Y or Z is turned by it.
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
    let volume = box_of(30);
    let mut random = seeded(11);
    for (sigma, urad) in [(0.0, 20.0), (0.1, 60.0)] {
        let readings = with_noise(&rolling(&volume, urad), sigma, &mut random);
        let found = naive(&volume, &runs(1, Pass::Forward, &readings));
        let ramps = found.closure.ramps.as_ref().unwrap();
        assert!(ramps.roll, "{ramps:?}");
        assert!(found.closure.outliers.is_empty(), "{:?}", found.closure.outliers);
        // 2 b (c/R) times the roll of + less that of - diagonals, from -A to +A over the axis.
        let wanted = 4.0 * 24e-3 * volume.cosine(Axis::Z) * urad * 29.0 / 30.0;
        let tolerance = 4.0 * sigma * ramps.u.y + 0.07 * wanted;
        assert!((ramps.change_um.y.abs() - wanted).abs() < tolerance, "{ramps:?} {wanted}");
        assert!((ramps.change_um.y + ramps.change_um.z).abs() < 2.0 * tolerance);
        assert!(words(&found.labels).concat().contains("roll of an axis that carries others"));
        let scatter = found.closure.sigma_um().unwrap();
        assert!((scatter - sigma).abs() < 0.03, "{scatter}");
    }
}

#[test]
fn a_stated_noise_that_the_scatter_contradicts_is_told_and_does_not_count() {
    let readings = repeated(1, 1);
    for (noise_um, contradicted) in [(SIGMA_UM, false), (0.15, true), (0.6, true)] {
        let measurement = measurement(&box_of(30), SetUp::AssumePerfect, Frame::AsMeasured);
        let mut campaign = campaign(&measurement, Vec::new());
        campaign.stated.noise_um = Some(noise_um);
        let found = separate(&campaign, &readings);
        let said = words(&found.labels).concat();
        assert_eq!(said.contains("contradicts it and does not count"), contradicted, "{said}");
        assert_eq!(found.noise, found.closure.noise());
    }
}

/// Without overrun the first and last interval of each axis, in both groups of readings, hold its reversal.
#[test]
fn without_overrun_the_closure_leaves_the_turns_out() {
    let machine = Machine::perfect(&box_of(30));
    let freedom = |overrun: bool| {
        let mut measurement = measurement(&box_of(30), SetUp::Solve, Frame::XPrimary);
        measurement.overrun = Some(overrun);
        let forward = runs(1, Pass::Forward, &machine.readings(None));
        let back = runs(1, Pass::Reverse, &machine.readings(Some(overrun)));
        let campaign = campaign(&measurement, machine.lines(&Axis::ALL, Some(0.5)));
        separate(&campaign, &[forward, back].concat()).closure.freedom
    };
    assert_eq!(freedom(true) - freedom(false), 2 * 3 * 2);
}

#[test]
fn a_perfect_set_up_is_contradicted_by_the_mean_of_the_closure() {
    let mut machine = Machine::perfect(&box_of(30));
    machine.lean[Diagonal::Npp] = PerAxis { x: 0.0, y: 50e-6, z: -50e-6 };
    let runs = runs(1, Pass::Forward, &machine.readings(None));
    let doubts = words(&naive(&box_of(30), &runs).doubts);
    assert!(doubts[0].contains("set-up is assumed perfect"), "{doubts:?}");
    let solved = solved(&box_of(30), machine.lines(&Axis::ALL, Some(0.5)), &runs);
    assert!(solved.stands(), "{:?}", solved.doubts);
}

#[track_caller]
fn two_step(visit: &Visit, status: i32) -> Ran {
    let ran = visit.run("separate job.toml -o errors.csv").ends(status);
    let job = without(&visit.read("job.toml"), "[measurement.step_diagonal]");
    visit.put("nine.toml", replaced(&job, "readings = \"readings", "errors = \"errors"));
    ran
}

/// A kit from the readings, and one from the table: what is said, and its manifest.
#[track_caller]
fn kits(visit: &Visit) -> [(Ran, Value); 2] {
    ["job", "nine"].map(|job| {
        let ran = visit.run(&format!("generate {job}.toml -o kit-{job}")).ends(1);
        (ran.says("verdict: undecided"), visit.document(&format!("kit-{job}/manifest.json")))
    })
}

#[test]
fn a_disturbed_reading_reaches_every_output() {
    // 0.3 µm noise and one reading 20 µm off.
    let mut random = seeded(20);
    let visit = golden_case("case_b_setup");
    let spoilt = with_cells(&visit.read("readings.csv"), |cells| {
        let Some(um) = cells.last().and_then(|um| um.parse::<f64>().ok()) else {
            return !cells[0].starts_with('#');
        };
        let off = if cells[..5] == ["PPP", "1", "forward", "58", "x"] { 20.0 } else { 0.0 };
        let noise = SIGMA_UM * normal(&mut random);
        cells[5] = format!("{:.6}", if cells[3] == "0" { um } else { um + noise + off });
        true
    });
    visit.put("readings.csv", spoilt);
    let words = "PPP forward node 58";
    two_step(&visit, 1).says("note: disturbed reading").says(words);
    let page = visit.run("separate job.toml --format json").ends(1).json();
    holds(&page["labels"].to_string(), &[words]);
    let csv = visit.read("errors.csv");
    holds(&csv, &["# note: disturbed reading", words, "# doubtful beside that, um: "]);
    for (ran, page) in kits(&visit) {
        holds(ran.all().split_once("verdict: undecided").unwrap().1, &[words]);
        holds(&page["notes"].to_string(), &[words]);
    }
    for job in ["job", "nine"] {
        let verify = format!("verify {job}.toml --tables kit-{job} --format json");
        let page = visit.run(&verify).ends(1).json();
        assert_eq!(page["verdict"], "undecided");
        holds(&page["notes"].to_string(), &[words]);
    }
}

#[test]
fn a_kit_without_scales_is_undecided_and_says_what_is_missing() {
    let visit = golden_case("case_b_setup");
    let table = "[[measurement.step_diagonal.linear]]";
    visit.put("job.toml", without(&visit.read("job.toml"), table));
    two_step(&visit, 1).says("Determined: 6 of 9 errors");
    for (ran, page) in kits(&visit) {
        ran.says("EXX             not determined").says("no table for EXX, EYY, EZZ: not determined by the measurement: scale of X, Y and Z can be traded");
        let omitted = page["omitted"].as_array().unwrap();
        let terms: Vec<_> = omitted.iter().map(|o| &o["term"]).collect();
        assert_eq!(terms, ["EXX", "EYY", "EZZ"]);
    }
    // Whoever asks for the six alone misses nothing.
    visit.under("[compensation]", "terms = ['EYX', 'EZX', 'EXY', 'EZY', 'EXZ', 'EYZ']");
    visit.run("generate job.toml -o six").ends(1).omits("INCONSISTENT");
}

#[test]
fn readings_in_both_directions_need_a_word_on_the_reversal() {
    let case = "case_d_bidirectional";
    golden_case(case).run("generate job.toml -o kit").ends(2).says("`backlash` is not stated");
    let page = golden_case(case).run("separate job.toml --format json").ends(0).json();
    let [mean, forward] = [("mean", "EXX"), ("forward-only", "EXX+")].map(|(policy, name)| {
        let visit = golden_case(case);
        visit.under("[compensation]", &format!("backlash = \"{policy}\""));
        visit.yes("separate job.toml -o errors.csv");
        let csv = visit.read("errors.csv");
        let last = csv.lines().rfind(|line| line.starts_with("x,")).unwrap();
        let cell = last.split(',').nth(last.matches(",+,").count() + 2).unwrap();
        let um: f64 = cell.parse().unwrap();
        let wanted = number(&page["errors"][name]["deviation_um"][10]);
        assert!((um - wanted).abs() < 1e-5, "{policy}: {um}, {wanted}");
        um
    });
    assert!((forward - mean).abs() > 0.5);
}

#[test]
fn a_reversal_that_no_curve_holds_is_said_beside_the_figures() {
    for policy in ["mean", "forward-only"] {
        let visit = golden_case("case_d_bidirectional");
        visit.under("[compensation]", &format!("backlash = \"{policy}\""));
        two_step(&visit, 0);
        for (ran, page) in kits(&visit) {
            let text = ran.omits("reversal not measured").all();
            // B_d of the reference is 9.146 µm.
            let mark = "without reversal (about 9.146 µm";
            let is_marked = |line: &str| line.starts_with("EXX  ") && line.contains(mark);
            assert!(text.lines().any(is_marked), "{text}");
            assert_eq!(page["forecast"]["without_reversal_um"], 9.146);
        }
    }
}

#[test]
fn an_assumed_set_up_is_said_of_the_kit_made_from_the_table() {
    let visit = golden_case("case_a_ideal");
    two_step(&visit, 0);
    let angles = "angular errors without a measurement, counted as zero";
    let words = ["set-up assumed perfect", "reversal is mixed into the curves", angles];
    holds(&visit.run("generate nine.toml -o kit --explain").ends(1).all(), &words);
    holds(&visit.document("kit/manifest.json")["notes"].to_string(), &words);
}

#[test]
fn where_nothing_is_asked_nothing_is_judged_and_worse_is_said() {
    let visit = golden_case("case_b_setup");
    let job = visit.read("job.toml");
    visit.put("job.toml", job.split("[acceptance]").next().unwrap());
    visit.edit("job.toml", "siemens-840d-sl", "generic");
    // A count of 20 µm: the tables cannot follow the curves.
    visit.under("[compensation.axes.x]", "detection_unit_um = 20.0");
    let ran = visit.run("generate job.toml -o kit").ends(0).omits("verdict: pass");
    ran.says("no acceptance is stated in the job, so there is nothing to judge")
        .says("WARNING: diagonal PPP becomes larger with the tables: 18.544 →");
    let notes = visit.document("kit/manifest.json")["notes"].to_string();
    holds(&notes, &["diagonal PPP becomes larger"]);
}

#[test]
fn values_in_mm_under_a_column_in_um_are_doubted() {
    let visit = Visit::of("start/errors");
    let slip = |axis: &str| {
        let slipped = with_cells(&fixture("start/errors/errors.csv"), |cells| {
            let is_own = cells[0].starts_with(axis);
            for cell in cells.iter_mut().skip(2).filter(|_| is_own) {
                *cell = cell.parse::<f64>().map_or(cell.clone(), |um| (um / 1000.0).to_string());
            }
            true
        });
        visit.put("errors.csv", slipped);
    };
    // Of one axis of three: refused, unless a noise is stated below them.
    slip("x");
    let words = "EXX reaches 0.008 µm only, and EYY 5.000 µm: are the values of `ex_um` in the rows of X mm?";
    visit.run("generate job.toml -o kit").ends(2).says(words).says("EYX reaches");
    slip("");
    let words = "no error exceeds 0.008 µm, and a machine tool below 0.1 µm throughout is unlikely";
    for command in ["generate job.toml -o kit", "verify job.toml --tables kit"] {
        let ran = visit.run(command).ends(1).says("verdict: undecided");
        ran.says(&format!("INCONSISTENT: {words}"));
    }
    visit.run("assess job.toml").ends(0).says(&format!("doubt: {words}"));
    let stated = |noise_um: &str| {
        let noise = format!("[measurement]\nuncertainty = {{ noise_um = {noise_um} }}\n");
        let generate = format!("generate job.toml -o kit-{noise_um}");
        visit.run_with("job.toml", "[measurement]\n", &noise, &generate)
    };
    // Whoever states a noise below the errors means them.
    stated("0.002").ends(0).omits("INCONSISTENT");
    // A noise above them says nothing of their unit.
    stated("0.5").ends(1).says("or state a `noise_um` below it");
    visit.put("errors.csv", "axis,position_mm,ex_um\nx,0,0\nx,400,0.00042\n");
    visit.run("generate job.toml -o tiny").ends(1).says("no error exceeds 0.00042 µm");
}
