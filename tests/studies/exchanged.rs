//! Diagonals under each other's name and steps in another order: what `separate` finds of them, how
//! often it accuses sound readings, and whether it says what it would hardly find.
use crate::support::diagonals::*;
use crate::support::{in_parallel, is_held, markdown, published_if_whole, share, words};
use nonius::machine::separation::Separation;
use nonius::quantity::{Axis, Diagonal, ErrorTerm, PerDiagonal};

#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    steps: usize,
    repeats: u32,
    back: Option<bool>,
}

const WAYS: [Way; 4] = [
    Way { name: "three runs, n = 15", steps: 15, repeats: 3, back: None },
    Way { name: "one run, n = 15", steps: 15, repeats: 1, back: None },
    Way { name: "one run, n = 30", steps: 30, repeats: 1, back: None },
    Way { name: "both directions, n = 15", steps: 15, repeats: 1, back: Some(true) },
];

const KINDS: [&str; 3] = ["two of NPP, PNP, PPN", "PPP and another", "another order"];

/// What went wrong, in the words of the page: which diagonal was walked under each name, and the order of the steps.
struct Slip {
    kind: usize,
    words: String,
    walked: PerDiagonal<Diagonal>,
    order: [Axis; 3],
}

impl Slip {
    fn none() -> Slip {
        let walked = PerDiagonal::from_fn(|name| name);
        Slip { kind: 0, words: String::new(), walked, order: Axis::ALL }
    }

    fn exchanged(one: Diagonal, other: Diagonal) -> Slip {
        let (kind, words) = (usize::from(one == Diagonal::Ppp), format!("{one} and {other}"));
        let mut slip = Slip { kind, words, ..Slip::none() };
        (slip.walked[one], slip.walked[other]) = (other, one);
        slip
    }

    fn all() -> Vec<Slip> {
        let [x, y, z] = Axis::ALL;
        let orders = [[x, z, y], [y, x, z], [y, z, x], [z, x, y], [z, y, x]];
        let orders = orders.map(|order| {
            let words = order.map(|axis| axis.to_string()).join(", ");
            Slip { kind: 2, words, order, ..Slip::none() }
        });
        let [ppp, npp, pnp, ppn] = Diagonal::ALL;
        let pairs =
            [(ppp, npp), (ppp, pnp), (ppp, ppn), (npp, pnp), (npp, ppn), (pnp, ppn)].into_iter();
        pairs.map(|(one, other)| Slip::exchanged(one, other)).chain(orders).collect()
    }
}

#[derive(Clone, Copy)]
struct Wavy {
    size: f64,
    even: &'static [&'static str],
}

const WAVY: Wavy = Wavy { size: 1.0, even: &[] };

/// A machine by its number, measured with the noise of another number, its mirrors leaning.
fn measured((seed, noise): (u64, u64), way: Way, wavy: Wavy, slip: &Slip) -> Separation {
    let mut random = seeded(seed);
    let box_ = box_of(way.steps);
    let is_even = |term: ErrorTerm| wavy.even.contains(&term.to_string().as_str());
    let size = |term| if is_even(term) { 0.0 } else { wavy.size };
    let truth = Machine::waving(&box_, size, &mut random).x_primary();
    let mut leant = truth.clone();
    leant.lean_randomly(1e-4, &mut random);
    leant.volume.order = slip.order;
    let mut random = seeded(1_000_000 * (noise + 1) + seed);
    let under_names = |back| {
        let readings = leant.readings(back);
        PerDiagonal::from_fn(|name| readings[slip.walked[name]].clone())
    };
    let all = visit_runs(under_names, way.back, way.repeats, SIGMA_UM, &mut random);
    let lines = noisy_lines(&truth, &Axis::ALL, U_LINE_UM_PER_M, &mut random);
    solved(&box_, lines, &all)
}

fn hardly(found: &Separation) -> Option<String> {
    let mut labels = words(&found.labels).into_iter();
    labels.find(|label| label.starts_with("these readings cannot detect"))
}

fn is_warned(found: &Separation, slip: &Slip) -> bool {
    hardly(found)
        .is_some_and(|said| said.contains("diagonals were swapped") || said.contains(&slip.words))
}

fn accuses(found: &Separation) -> Option<String> {
    words(&found.doubts).into_iter().find(|doubt| doubt.starts_with("as if"))
}

struct Slipped {
    kind: usize,
    is_sure: bool,
    is_named: bool,
    is_silent: bool,
    is_warned: bool,
}

#[derive(Default)]
struct Outcome {
    right: usize,
    accused: usize,
    carrying: usize,
    slips: Vec<Slipped>,
}

impl Outcome {
    /// How many slips of some are so, and how many they are.
    fn count(
        &self,
        some: impl Fn(&Slipped) -> bool,
        is_so: impl Fn(&Slipped) -> bool,
    ) -> (usize, usize) {
        let some: Vec<_> = self.slips.iter().filter(|slip| some(slip)).collect();
        (some.iter().filter(|slip| is_so(slip)).count(), some.len())
    }
}

fn outcome(way: Way, machines: u64) -> Outcome {
    let mut outcome = Outcome::default();
    for seed in 0..machines {
        let right = measured((seed, 0), way, WAVY, &Slip::none());
        outcome.right += 1;
        outcome.accused += usize::from(accuses(&right).is_some());
        outcome.carrying += usize::from(hardly(&right).is_some());
        if !right.stands() {
            continue;
        }
        for (noise, slip) in (1..).zip(Slip::all()) {
            let found = measured((seed, noise), way, WAVY, &slip);
            let is_named = accuses(&found).is_some_and(|said| said.contains(&slip.words));
            let is_silent = !is_named && found.stands();
            outcome.slips.push(Slipped {
                kind: slip.kind,
                is_sure: !is_warned(&right, &slip),
                is_named,
                is_silent,
                is_warned: is_silent && is_warned(&found, &slip),
            });
        }
    }
    outcome
}

fn row((way, outcome): &(Way, Outcome)) -> String {
    let (right, of) = (outcome.right, |(some, all): (usize, usize)| format!("{some}/{all}"));
    let named = of(outcome.count(|_| true, |slip| slip.is_named));
    let silent =
        [0, 1, 2].map(|kind| of(outcome.count(|slip| slip.kind == kind, |slip| slip.is_silent)));
    let sure = of(outcome.count(|slip| slip.is_sure, |slip| slip.is_silent));
    let (accused, carrying) = (of((outcome.accused, right)), of((outcome.carrying, right)));
    [way.name, &named, &silent.join(" | "), &sure, &accused, &carrying].join(" | ")
}

fn told(outcomes: &[(Way, Outcome)], even: &[(Way, Wavy, usize)], machines: u64) -> String {
    let all = || outcomes.iter().flat_map(|(_, outcome)| &outcome.slips);
    let silent = all().filter(|slip| slip.is_silent).count();
    let warned = all().filter(|slip| slip.is_warned).count();
    let accused = even.iter().map(|(way, wavy, accused)| match wavy.even {
        [] if way.repeats == 1 => format!("{}, waves ×{}: {accused}", way.name, wavy.size),
        [] => format!("waves ×{}: {accused}", wavy.size),
        even => format!("{} without waves: {accused}", even.join(" and ")),
    });
    format!(
        "\n\nOf {silent} silent slips {warned} carry the sentence. Right readings, {}, accused of {machines}: {}.",
        WAYS[0].name,
        accused.collect::<Vec<_>>().join("; ")
    )
}

fn even_machines(machines: u64) -> Vec<(Way, Wavy, usize)> {
    let accused = |(way, wavy): (Way, Wavy)| {
        let found = (0..machines).map(|seed| measured((seed, 0), way, wavy, &Slip::none()));
        (way, wavy, found.filter(|found| accuses(found).is_some()).count())
    };
    let smaller = [0.0, 0.1, 0.2, 0.4].map(|size| Wavy { size, even: &[] });
    let pairs: [&'static [&'static str]; 3] = [&["EZX", "EZY"], &["EYX", "EYZ"], &["EXY", "EXZ"]];
    let pairs = pairs.map(|even| Wavy { size: 1.0, even });
    let straight = [(WAYS[3], smaller[0]), (WAYS[1], smaller[0])];
    smaller
        .into_iter()
        .chain(pairs)
        .map(|wavy| (WAYS[0], wavy))
        .chain(straight)
        .map(accused)
        .collect()
}

/// No more than `percent` of `all`, with two and a half standard deviations of counting.
#[track_caller]
fn at_most((count, all): (usize, usize), percent: f64, what: &str) {
    if all > 0 {
        let stated = percent / 100.0;
        let most = stated + 2.5 * (stated / float(all)).sqrt();
        let held = is_held(float(count) / float(all), all, 0.0..=stated, 0.0..=most);
        assert!(held, "{what}: {count} of {all}, {percent} % stated");
    }
}

#[test]
fn exchanged_names_and_orders_are_found_or_the_page_says_that_it_would_not() {
    let outcomes = in_parallel(WAYS, |way| (way, outcome(way, share(400, 4)))); // seeds 0, 1, 2 …
    let machines = share(1000, 10); // of each waviness, with sound readings
    let even = even_machines(machines);
    let head = format!(
        "slips | named | silent: {} | silent, power ≥ 95 % | right readings accused | … with the sentence",
        KINDS.join(" | silent: ")
    );
    let page = markdown(&head, outcomes.iter().map(row)) + &told(&outcomes, &even, machines);
    println!("{page}");
    for (way, outcome) in &outcomes {
        let name = way.name;
        at_most((outcome.accused, outcome.right), 1.0, &format!("{name}, accused"));
        for kind in 0..KINDS.len() {
            let sure =
                outcome.count(|slip| slip.kind == kind && slip.is_sure, |slip| slip.is_silent);
            at_most(sure, 5.0, &format!("{name}, silent"));
        }
        let untold = outcome.count(|slip| slip.is_silent, |slip| !slip.is_warned);
        at_most(untold, 1.0, &format!("{name}, silent without the sentence"));
    }
    for (_, wavy, accused) in &even {
        at_most((*accused, machines as usize), 1.0, &format!("{} {:?}", wavy.size, wavy.even));
    }
    published_if_whole("exchanged", "exchanged", &page);
}
