//! One process that runs cases, target after target, until its time or its number of cases is over.
//!
//! What it is at stands in its directory, so that whoever started it can go on when it was killed: `current` (target
//! and input of the case that runs), `counts`, `findings`, `queue/TARGET/` (inputs that found something new).

use crate::case::{Ran, note_panics};
use crate::finding::{Finding, hash};
use crate::queue::Queue;
use crate::random::Random;
use crate::targets::{Target, all};
use crate::{mutate, watch};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What a worker is asked for.
#[derive(Clone)]
pub struct Plan {
    /// Its directory.
    pub place: PathBuf,
    /// From which all its cases follow.
    pub seed: u64,
    /// How long it runs.
    pub time: Duration,
    /// How many cases it runs at most.
    pub cases: u64,
    /// A target alone.
    pub only: Option<String>,
}

/// What was done on one target.
#[derive(Clone, Debug, Default)]
pub struct Count {
    /// Cases that ran.
    pub cases: u64,
    /// Inputs that took an edge as none before.
    pub new: u64,
    /// Edges that were taken.
    pub edges: usize,
    /// How long it took.
    pub seconds: f64,
}

/// A target with its state.
struct Fuzzed {
    target: Target,
    queue: Queue,
    random: Random,
    /// Inputs that did not run yet, the last one next.
    pending: Vec<Vec<u8>>,
    count: Count,
}

/// One input in so many is made large, and then run at half its size and whole: a tenth of the cases.
const LARGE_ONE_IN: usize = 20;
/// Bytes of such a case, as powers of two, each as often: most readers refuse a page beyond some size.
const LARGE: std::ops::Range<usize> = 12..21;
/// Steps below which growth is no finding: a fifth of a second of the released program. A line has at most 64 kB and a
/// table 1,000 columns, each of which may look along the whole of the line.
const MANY_STEPS: u64 = 300_000_000;
/// Twice the input may take so many times the steps: an exponent of 1.3.
const STEPS_OF_TWICE: f64 = 2.5;

/// How often all targets have their turn, at least.
const ROUNDS: f64 = 2.0;
/// The longest turn of a target with one share, s.
const TURN_S: f64 = 4.0;

/// Runs cases as planned.
pub fn work(plan: &Plan) {
    note_panics();
    watch::note_in(&plan.place);
    watch::start(&plan.place.join("current"));
    let wanted = |target: &Target| plan.only.as_deref().is_none_or(|only| only == target.name);
    let targets = all().into_iter().filter(wanted);
    let mut fuzzed: Vec<Fuzzed> = targets.map(|target| Fuzzed::new(target, plan)).collect();
    let shares: u32 = fuzzed.iter().map(|of| of.target.share).sum();
    let turn = (plan.time.as_secs_f64() / ROUNDS / f64::from(shares.max(1))).min(TURN_S);
    let end = Instant::now() + plan.time;
    let is_over = |cases: u64| Instant::now() >= end || cases >= plan.cases;
    let mut cases = 0;
    while !is_over(cases) && !fuzzed.is_empty() {
        for of in &mut fuzzed {
            let started = Instant::now();
            let turn = Duration::from_secs_f64(turn * f64::from(of.target.share));
            while started.elapsed() < turn && !is_over(cases) {
                of.step(plan);
                cases += 1;
            }
            of.count.seconds += started.elapsed().as_secs_f64();
        }
        write_counts(plan, &fuzzed);
    }
}

impl Fuzzed {
    fn new(target: Target, plan: &Plan) -> Fuzzed {
        let mut random = Random::new(plan.seed ^ hash(target.name.as_bytes()));
        let mut pending = target.seeds.clone();
        for end in (1..pending.len()).rev() {
            pending.swap(end, random.below(end + 1));
        }
        let mut found = crate::bundle::Bundle::default();
        found.add_directory(&plan.place.join("queue").join(target.name));
        pending.extend(found.0.into_iter().map(|(_, bytes)| bytes));
        let count = counts(&plan.place).into_iter().find(|(name, _)| name == target.name);
        Fuzzed {
            target,
            queue: Queue::default(),
            random,
            pending,
            count: count.map(|(_, count)| count).unwrap_or_default(),
        }
    }

    /// One case: an input that did not run yet, or a changed one, in turns; or one made large.
    fn step(&mut self, plan: &Plan) {
        if self.queue.edges() > 0 && self.random.one_in(LARGE_ONE_IN) {
            return self.step_large(plan);
        }
        let is_seed = self.queue.edges() == 0 || self.random.one_in(2);
        let (input, is_known) = match self.pending.pop().filter(|_| is_seed) {
            Some(seed) => (seed, true),
            None => {
                let other = self.queue.next(&mut self.random).to_vec();
                let input = self.queue.next(&mut self.random).to_vec();
                (mutate::mutated(&mut self.random, &input, &other, &self.target.words), false)
            }
        };
        let ran = watched(&self.target, plan, &input);
        self.count.cases += 1;
        let is_new = self.queue.add(&input, &ran.trace);
        if is_known && ran.trace.is_empty() {
            self.queue.keep(&input, &[]);
        }
        let differs =
            || is_new && !is_known && watched(&self.target, plan, &input).answer != ran.answer;
        let wrong = ran
            .wrong
            .clone()
            .or_else(|| differs().then(|| "twice the same case, two answers".to_string()));
        if let Some(wrong) = wrong {
            self.report(plan, &input, wrong);
        } else if is_new && !is_known {
            self.count.new += 1;
            keep(plan, self.target.name, &input);
        }
        self.count.edges = self.queue.edges();
    }

    /// An input of the queue with something in it many times: memory as for every case, and steps against its half. Where
    /// they grow too fast, twice as often again, until they do not, or are too many.
    fn step_large(&mut self, plan: &Plan) {
        let input = self.queue.next(&mut self.random).to_vec();
        let first = LARGE.start + self.random.below(LARGE.len());
        let part = Random::new(self.random.bits());
        for power in first..LARGE.end {
            let Some(pair) = mutate::grown(&mut part.clone(), &input, 1 << power) else {
                return;
            };
            let pair = pair.map(|input| (watched(&self.target, plan, &input), input));
            self.count.cases += 2;
            for (ran, input) in &pair {
                if let Some(wrong) = &ran.wrong {
                    return self.report(plan, input, wrong.clone());
                }
            }
            let [few, many] = [0, 1].map(|index| pair[index].0.steps);
            if many as f64 <= STEPS_OF_TWICE * few as f64 {
                return;
            }
            if many > MANY_STEPS {
                let wrong = format!("steps: {few} for half of the input, {many} for all");
                return self.report(plan, &pair[1].1, wrong);
            }
        }
    }

    fn report(&self, plan: &Plan, input: &[u8], wrong: String) {
        let finding = Finding { target: self.target.name, wrong };
        if !finding.is_wanted(input) {
            return;
        }
        let again = |input: &[u8]| watched(&self.target, plan, input).wrong;
        let small = match finding.wrong.starts_with("steps") {
            true => input.to_vec(), // one run alone does not show them
            false => finding.smallest(input, again),
        };
        finding.write(&plan.place, &small);
    }
}

/// Runs a case under the eyes of the watchdog.
fn watched(target: &Target, plan: &Plan, input: &[u8]) -> Ran {
    watch::begin(target.name, input);
    let ran = target.run(&plan.place, input);
    watch::end();
    ran
}

fn keep(plan: &Plan, target: &str, input: &[u8]) {
    let folder = plan.place.join("queue").join(target);
    let _ = fs::create_dir_all(&folder);
    let _ = fs::write(folder.join(format!("{:016x}", hash(input))), input);
}

fn write_counts(plan: &Plan, fuzzed: &[Fuzzed]) {
    let line = |of: &Fuzzed| {
        format!(
            "{} {} {} {} {}\n",
            of.target.name, of.count.cases, of.count.new, of.count.edges, of.count.seconds
        )
    };
    let text: String = fuzzed.iter().map(line).collect();
    let new = plan.place.join("counts.new");
    let _ = fs::write(&new, text).and_then(|()| fs::rename(new, plan.place.join("counts")));
}

/// The counts of a worker.
pub fn counts(place: &Path) -> Vec<(String, Count)> {
    let text = fs::read_to_string(place.join("counts")).unwrap_or_default();
    let line = |line: &str| {
        let mut words = line.split(' ');
        let name = words.next()?.to_string();
        let (cases, new, edges) =
            (words.next()?.parse().ok()?, words.next()?.parse().ok()?, words.next()?.parse().ok()?);
        Some((name, Count { cases, new, edges, seconds: words.next()?.parse().ok()? }))
    };
    text.lines().filter_map(line).collect()
}
