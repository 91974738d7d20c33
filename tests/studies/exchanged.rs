//! Diagonals under each other's name and steps in another order: what `separate` finds of them, how
//! often it accuses sound readings, and whether it says what it would hardly find.
//!
//! A hundredth of the simulations runs by default, all of them with `NONIUS_SIMULATIONS=all cargo test
//! --test studies exchanged`; with `NONIUS_UPDATE=1` as well it writes the table of docs/accuracy.md.
use crate::support::diagonals::{
    Machine, Readings, float, noisy_lines, noisy_runs, normal, seeded, solved, squareness_error,
    volume,
};
use crate::support::{in_parallel, is_held, is_whole, published, share, words};
use nonius::machine::separation::Separation;
use nonius::quantity::{Axis, Diagonal, ErrorTerm, Pass, PerDiagonal, Plane, Volume};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

const SIGMA_UM: f64 = 0.3;
const U_LINE_UM_PER_M: f64 = 0.5;
/// Machines of the whole run, by way of measuring; seeds 0, 1, 2 …
const MACHINES: u64 = 400;
/// Sound readings of machines of each waviness in the whole run.
const EVEN_MACHINES: u64 = 1000;

/// How a machine is measured.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    steps: usize,
    repeats: u32,
    both: bool,
}

const WAYS: [Way; 4] = [
    Way { name: "three runs, n = 15", steps: 15, repeats: 3, both: false },
    Way { name: "one run, n = 15", steps: 15, repeats: 1, both: false },
    Way { name: "one run, n = 30", steps: 30, repeats: 1, both: false },
    Way { name: "both directions, n = 15", steps: 15, repeats: 1, both: true },
];

/// What went wrong.
#[derive(Clone, Copy, PartialEq)]
enum Slip {
    Exchanged(Diagonal, Diagonal),
    Order([Axis; 3]),
}

impl Slip {
    fn all() -> Vec<Slip> {
        let [x, y, z] = Axis::ALL;
        let orders = [[x, z, y], [y, x, z], [y, z, x], [z, x, y], [z, y, x]];
        let pairs = (0..4).flat_map(|one| (one + 1..4).map(move |other| (one, other)));
        let pairs = pairs.map(|(a, b)| Slip::Exchanged(Diagonal::ALL[a], Diagonal::ALL[b]));
        pairs.chain(orders.map(Slip::Order)).collect()
    }

    /// As the page says it.
    fn words(self) -> String {
        match self {
            Slip::Exchanged(one, other) => format!("{one} and {other}"),
            Slip::Order([a, b, c]) => format!("{a}, {b}, {c}"),
        }
    }

    fn kind(self) -> &'static str {
        match self {
            Slip::Exchanged(Diagonal::Ppp, _) => "PPP and another",
            Slip::Exchanged(..) => "two of NPP, PNP, PPN",
            Slip::Order(_) => "another order",
        }
    }
}

const KINDS: [&str; 3] = ["two of NPP, PNP, PPN", "PPP and another", "another order"];

/// How far the curves of a machine wave.
#[derive(Clone, Copy)]
struct Wavy {
    /// Times `Machine::random`.
    size: f64,
    /// These do not wave at all: what tells a pair of names apart.
    even: &'static [&'static str],
}

const WAVY: Wavy = Wavy { size: 1.0, even: &[] };

fn machine(volume: &Volume, wavy: Wavy, random: &mut ChaCha8Rng) -> Machine {
    let mut machine = Machine::perfect(volume);
    for term in ErrorTerm::ALL {
        let is_even = wavy.even.contains(&term.to_string().as_str());
        let wave = if is_even { 0.0 } else { wavy.size };
        let (slope, bow, size) = (normal(random), normal(random), wave * normal(random));
        let at = |t: f64| 10.0 * slope * t + 12.0 * bow * t * (1.0 - t) + size * (19.0 * t).sin();
        machine.set(term, at);
    }
    machine.x_primary()
}

/// A machine by its number, measured with the noise of another number, its mirrors leaning; `slip`
/// is what went wrong.
fn measured(
    (seed, noise): (u64, u64),
    way: Way,
    wavy: Wavy,
    slip: Option<Slip>,
) -> (Machine, Separation) {
    let mut random = seeded(seed);
    let box_ = volume([900.0, 720.0, 720.0], way.steps);
    let truth = machine(&box_, wavy, &mut random);
    let mut leant = truth.clone();
    leant.lean_randomly(1e-4, &mut random);
    let mut random = seeded(1_000_000 * (noise + 1) + seed);
    if let Some(Slip::Order(order)) = slip {
        leant.volume.order = order;
    }
    let mut passes = vec![(Pass::Forward, under_names(&leant.readings(None), slip))];
    if way.both {
        passes.push((Pass::Reverse, under_names(&leant.readings(Some(true)), slip)));
    }
    let all = noisy_runs(&passes, way.repeats, SIGMA_UM, &mut random);
    let lines = noisy_lines(&truth, &Axis::ALL, U_LINE_UM_PER_M, &mut random);
    (truth, solved(&box_, lines, &all))
}

fn under_names(readings: &Readings, slip: Option<Slip>) -> Readings {
    PerDiagonal::from_fn(|name| {
        let walked = match slip {
            Some(Slip::Exchanged(one, other)) if name == one => other,
            Some(Slip::Exchanged(one, other)) if name == other => one,
            _ => name,
        };
        readings[walked].clone()
    })
}

/// The sentence on what would hardly show.
fn hardly(found: &Separation) -> Option<String> {
    let mut labels = words(&found.labels).into_iter();
    labels.find(|label| label.starts_with("these readings cannot detect"))
}

/// Whether that sentence holds a slip.
fn is_warned(found: &Separation, slip: Slip) -> bool {
    hardly(found)
        .is_some_and(|said| said.contains("diagonals were swapped") || said.contains(&slip.words()))
}

fn accuses(found: &Separation) -> Option<String> {
    words(&found.doubts).into_iter().find(|doubt| doubt.starts_with("as if"))
}

fn is_wrong(truth: &Machine, found: &Separation) -> bool {
    Plane::ALL.into_iter().any(|plane| {
        let expanded = found.metric.squareness(plane).expanded_um_per_m().unwrap();
        squareness_error(truth, found, plane).abs() > 2.0 * expanded
    })
}

/// What became of some slips.
#[derive(Clone, Copy, Default)]
struct Count {
    slips: usize,
    named: usize,
    otherwise: usize,
    silent: usize,
    /// Of the silent ones: with the sentence.
    warned: usize,
    /// Of the silent ones: squareness off by more than twice its U.
    wrong: usize,
}

impl Count {
    fn add(&mut self, truth: &Machine, found: &Separation, slip: Slip) {
        self.slips += 1;
        let named = accuses(found).is_some_and(|said| said.contains(&slip.words()));
        if named {
            self.named += 1;
        } else if !found.stands() {
            self.otherwise += 1;
        } else {
            self.silent += 1;
            self.warned += usize::from(is_warned(found, slip));
            self.wrong += usize::from(is_wrong(truth, found));
        }
    }
}

/// What became of all machines measured in one way.
#[derive(Default)]
struct Outcome {
    right: usize,
    accused: usize,
    doubted: usize,
    carrying: usize,
    /// By kind; power of at least 95 %, and below.
    by_kind: [[Count; 2]; 3],
}

impl Outcome {
    fn silent(&self) -> usize {
        self.by_kind.iter().flatten().map(|count| count.silent).sum()
    }
}

fn outcome(way: Way, machines: u64) -> Outcome {
    let mut outcome = Outcome::default();
    for seed in 0..machines {
        let (_, right) = measured((seed, 0), way, WAVY, None);
        outcome.right += 1;
        outcome.accused += usize::from(accuses(&right).is_some());
        outcome.doubted += usize::from(!right.stands());
        outcome.carrying += usize::from(hardly(&right).is_some());
        if !right.stands() {
            continue;
        }
        for (index, slip) in Slip::all().into_iter().enumerate() {
            let noise = u64::try_from(index).unwrap() + 1;
            let (truth, found) = measured((seed, noise), way, WAVY, Some(slip));
            let kind = KINDS.iter().position(|kind| *kind == slip.kind()).unwrap();
            let weak = usize::from(is_warned(&right, slip));
            outcome.by_kind[kind][weak].add(&truth, &found, slip);
        }
    }
    outcome
}

/// The rows of the table, by way: slips that were named, and that were silent by kind, and with power.
fn table(outcomes: &[(Way, Outcome)]) -> String {
    let kinds = KINDS.join(" | silent: ");
    let columns = " ---: |".repeat(KINDS.len() + 4);
    let mut text = format!(
        "| slips | named | silent: {kinds} | silent, power ≥ 95 % | right readings accused | … with the sentence |\n| --- |{columns}"
    );
    for (way, outcome) in outcomes {
        let Outcome { right, accused, carrying, by_kind, .. } = outcome;
        let of = |counts: &[Count], which: fn(&Count) -> usize| {
            let (some, all): (usize, usize) =
                (counts.iter().map(which).sum(), counts.iter().map(|count| count.slips).sum());
            format!("{some}/{all}")
        };
        let named = of(by_kind.as_flattened(), |count| count.named);
        let silent = by_kind.each_ref().map(|by_power| of(by_power, |count| count.silent));
        let sure = of(&by_kind.map(|[sure, _]| sure), |count| count.silent);
        let cells = [named, silent.join(" | "), sure].join(" | ");
        let right = format!("{accused}/{right} | {carrying}/{right}");
        write!(text, "\n| {} | {cells} | {right} |", way.name).unwrap();
    }
    text
}

/// What is said of silent slips, and of right readings of other machines.
fn told(outcomes: &[(Way, Outcome)], even: &[(Wavy, usize, u64)]) -> String {
    let all = || outcomes.iter().flat_map(|(_, outcome)| outcome.by_kind.as_flattened());
    let silent: usize = all().map(|count| count.silent).sum();
    let warned: usize = all().map(|count| count.warned).sum();
    let accused = even.iter().map(|(wavy, accused, _)| match wavy.even {
        [] => format!("waves ×{}: {accused}", wavy.size),
        even => format!("{} without waves: {accused}", even.join(" and ")),
    });
    let (accused, machines): (Vec<_>, u64) = (accused.collect(), share(EVEN_MACHINES, 10));
    format!(
        "\n\nOf {silent} silent slips {warned} carry the sentence. Right readings, {}, accused of {machines}: {}.",
        WAYS[0].name,
        accused.join("; ")
    )
}

/// How many machines with smaller waves are accused.
fn even_machines(way: Way) -> Vec<(Wavy, usize, u64)> {
    let machines = share(EVEN_MACHINES, 10);
    let accused = |wavy: Wavy| {
        let found = (0..machines).map(|seed| measured((seed, 0), way, wavy, None).1);
        found.filter(|found| accuses(found).is_some()).count()
    };
    let smaller = [0.0, 0.1, 0.2, 0.4].map(|size| Wavy { size, even: &[] });
    let pairs: [&'static [&'static str]; 3] = [&["EZX", "EZY"], &["EYX", "EYZ"], &["EXY", "EXZ"]];
    let pairs = pairs.map(|even| Wavy { size: 1.0, even });
    let all = smaller.into_iter().chain(pairs);
    all.map(|wavy| (wavy, accused(wavy), machines)).collect()
}

/// No more than `percent` of `all`, with two and a half standard deviations of counting.
#[track_caller]
fn at_most(count: usize, all: usize, percent: f64, what: &str) {
    if all > 0 {
        let stated = percent / 100.0;
        let most = stated + 2.5 * (stated / float(all)).sqrt();
        let held = is_held(float(count) / float(all), all, 0.0..=stated, 0.0..=most);
        assert!(held, "{what}: {count} of {all}, {percent} % stated");
    }
}

#[test]
fn exchanged_names_and_orders_are_found_or_the_page_says_that_it_would_not() {
    let outcomes = in_parallel(WAYS, |way| (way, outcome(way, share(MACHINES, 4))));
    let even = even_machines(WAYS[0]);
    let page = table(&outcomes) + &told(&outcomes, &even);
    println!("{page}");
    for (way, outcome) in &outcomes {
        let (name, silent) = (way.name, outcome.silent());
        at_most(outcome.accused, outcome.right, 1.0, &format!("{name}, accused"));
        for [sure, _] in &outcome.by_kind {
            at_most(sure.silent, sure.slips, 5.0, &format!("{name}, silent"));
        }
        let all = outcome.by_kind.iter().flatten();
        let told: usize = all.clone().map(|count| count.warned).sum();
        at_most(silent - told, silent, 1.0, &format!("{name}, silent without the sentence"));
        let slips: usize = all.map(|count| count.slips).sum();
        println!("{name}: {silent} of {slips} silent");
    }
    for (wavy, accused, machines) in &even {
        at_most(*accused, *machines as usize, 1.0, &format!("{} {:?}", wavy.size, wavy.even));
    }
    if is_whole() {
        published("exchanged", "exchanged", &page);
    }
}
