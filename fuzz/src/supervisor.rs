//! Starts the workers, begins anew where one was killed, and prints the table.

use crate::finding::Finding;
use crate::worker::{Count, Plan, counts};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// How often a long run prints its table.
const EVERY: Duration = Duration::from_secs(900);

/// A worker that was started.
struct Worker {
    plan: Plan,
    end: Instant,
    child: Option<Child>,
}

/// Runs `jobs` workers; how many cases ran, and how many findings there are.
pub fn supervise(plan: &Plan, jobs: usize) -> (u64, usize) {
    let started = Instant::now();
    // What another run found would hide what this one finds again.
    let older = crate::finding::folder().with_extension("previous");
    if fs::exists(crate::finding::folder()).unwrap_or(false) {
        let _ = fs::remove_dir_all(&older);
        let _ = fs::rename(crate::finding::folder(), older);
    }
    let part = |index: usize| Plan {
        place: plan.place.join(index.to_string()),
        seed: plan.seed + index as u64,
        cases: plan.cases / jobs as u64,
        ..plan.clone()
    };
    let mut workers: Vec<Worker> = (0..jobs)
        .map(|index| Worker { plan: part(index), end: started + plan.time, child: None })
        .collect();
    workers.iter_mut().for_each(Worker::start);
    let mut printed = started;
    while workers.iter_mut().any(Worker::is_running) {
        std::thread::sleep(Duration::from_millis(300));
        if printed.elapsed() > EVERY {
            printed = Instant::now();
            print(&workers);
        }
    }
    print(&workers)
}

impl Worker {
    fn start(&mut self) {
        let _ = fs::create_dir_all(&self.plan.place);
        let left = self.end.saturating_duration_since(Instant::now());
        let done: u64 = counts(&self.plan.place).iter().map(|(_, count)| count.cases).sum();
        let numbers =
            [self.plan.seed, left.as_millis() as u64, self.plan.cases.saturating_sub(done)];
        let said = File::create(self.plan.place.join("said"));
        let own = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("engine"));
        let mut command = Command::new(own);
        command.arg("worker").arg(&self.plan.place).args(numbers.map(|number| number.to_string()));
        command.args(&self.plan.only);
        if let Ok(file) = said {
            command.stderr(file);
        }
        self.child = command.spawn().ok();
    }

    /// Looks after the worker: ended as planned, or killed, which is a finding.
    fn is_running(&mut self) -> bool {
        let Some(child) = &mut self.child else {
            return false;
        };
        match child.try_wait() {
            Ok(None) => true,
            Ok(Some(status)) if status.success() => false,
            Ok(Some(status)) => {
                self.killed(&status.to_string());
                self.plan.seed += 1000;
                self.start();
                Instant::now() < self.end
            }
            Err(_) => false,
        }
    }

    fn killed(&self, status: &str) {
        let Some((target, input)) = crate::watch::current(&self.plan.place) else {
            return;
        };
        let said = fs::read_to_string(self.plan.place.join("said")).unwrap_or_default();
        let last: Vec<&str> = said.lines().filter(|line| !line.starts_with("found: ")).collect();
        let finding = Finding {
            target: &target,
            wrong: format!("killed, {status}: {}", last.last().unwrap_or(&"")),
        };
        finding.write(&self.plan.place, &input);
    }
}

/// The table over all workers, with its cases and findings.
fn print(workers: &[Worker]) -> (u64, usize) {
    let mut all: BTreeMap<String, Count> = BTreeMap::new();
    let mut findings = BTreeSet::new();
    for worker in workers {
        for (name, count) in counts(&worker.plan.place) {
            let sum = all.entry(name).or_default();
            sum.cases += count.cases;
            sum.new += count.new;
            sum.edges = sum.edges.max(count.edges);
            sum.seconds += count.seconds;
        }
        let notes = fs::read_to_string(worker.plan.place.join("findings")).unwrap_or_default();
        findings.extend(notes.lines().map(str::to_string));
    }
    println!(
        "| target | cases | cases/s | edges | new inputs | findings |\n| --- | ---: | ---: | ---: | ---: | ---: |"
    );
    let mut total = Count::default();
    for (name, count) in &all {
        let own = findings.iter().filter(|note| note.split(' ').next() == Some(name)).count();
        row(name, count, own);
        total.cases += count.cases;
        total.new += count.new;
        total.seconds += count.seconds;
        total.edges = total.edges.max(count.edges);
    }
    row("all", &total, findings.len());
    for note in &findings {
        let name = note.split(' ').next_back().unwrap_or_default();
        let path = crate::finding::folder().join(name);
        let words = fs::read_to_string(path.with_extension("txt")).unwrap_or_default();
        println!("found: fuzz/found/{name}.case: {}", words.lines().next().unwrap_or_default());
    }
    if !findings.is_empty() {
        println!(
            "again: cargo run --release --manifest-path fuzz/Cargo.toml -- replay fuzz/found/NAME.case"
        );
    }
    (total.cases, findings.len())
}

/// The sum of all long runs, and the line of this one for their list.
pub fn print_sum(seed: u64, cases: u64, findings: usize) {
    const AIM: u64 = 100_000_000;
    let list = concat!(env!("CARGO_MANIFEST_DIR"), "/runs.csv");
    let known = fs::read_to_string(list).unwrap_or_default();
    let known: u64 =
        known.lines().filter_map(|run| run.split(',').nth(2)?.parse::<u64>().ok()).sum();
    let commit = Command::new("git").args(["rev-parse", "--short", "HEAD"]).output();
    let commit = commit.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_string());
    println!("{} of {AIM} cases, with the long runs of fuzz/runs.csv; this one:", known + cases);
    println!("{},{seed},{cases},{findings}", commit.unwrap_or_default());
}

fn row(name: &str, count: &Count, findings: usize) {
    let rate = count.cases as f64 / count.seconds.max(0.001);
    println!(
        "| {name} | {} | {rate:.0} | {} | {} | {findings} |",
        count.cases, count.edges, count.new
    );
}

/// A directory for files that come and go: in memory, where the system has such a place.
pub fn place() -> PathBuf {
    let memory = Path::new("/dev/shm");
    let base = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    base.join(format!("nonius-fuzz-{}", std::process::id()))
}
