//! The program as a process: `generate` beside an empty program, in turns.
//!
//! `true` is the empty program on Unix; elsewhere it is `--version`. Each figure is the time of `generate`
//! less that of as many empty programs, half of them before it and half after it: a machine that
//! changes its speed changes it for both. What the empty programs of a figure took is printed under
//! it, as it tells how fast the machine was just then. Kits are written to a disk, and to memory
//! where the system has a folder for that: the difference is that of the disk and its file system.

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use std::cell::OnceCell;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const NONIUS: &str = env!("CARGO_BIN_EXE_nonius");

fn run(command: &mut Command) -> Duration {
    command
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let start = Instant::now();
    let status = command.status();
    let time = start.elapsed();
    assert!(status.is_ok_and(|status| status.success()));
    time
}

fn version() -> Command {
    let mut command = Command::new(NONIUS);
    command.arg("--version");
    command
}

/// `true` by its whole path, so that nobody has to look for it; `None` where the system has none.
fn true_of_system() -> Option<&'static str> {
    ["/usr/bin/true", "/bin/true"].into_iter().find(|path| Path::new(path).exists())
}

fn empty_program() -> Command {
    true_of_system().map_or_else(version, Command::new)
}

/// Where kits are written to.
struct Place {
    name: &'static str,
    root: PathBuf,
    /// Whether the kits are left there.
    stays: bool,
    folder: OnceCell<TempDir>,
}

impl Place {
    /// A folder of its own, made for the first kit.
    fn folder(&self) -> &Path {
        let made = self.folder.get_or_init(|| {
            let mut folder = tempfile::Builder::new();
            let made = folder.prefix("nonius-kits-").tempdir_in(&self.root);
            let mut made = made.expect("a place to write to");
            made.disable_cleanup(self.stays);
            made
        });
        made.path()
    }
}

/// A disk, where kits stay: deleting their thousands of files slows some disks down for minutes,
/// and with them the next run. And memory.
fn places() -> Vec<Place> {
    let disk = ("on disk", Path::new(env!("CARGO_TARGET_TMPDIR")).to_path_buf(), true);
    let memory = ("in memory", PathBuf::from("/dev/shm"), false);
    let is_there = |(_, root, _): &(&str, PathBuf, bool)| root.is_dir();
    let place = |(name, root, stays)| Place { name, root, stays, folder: OnceCell::new() };
    [disk, memory].into_iter().filter(is_there).map(place).collect()
}

/// Time of a program, less that of an empty one: one run before an empty program, one after it.
/// The second figure is what the empty ones took.
fn above_empty(make: &mut dyn FnMut() -> Command) -> (Duration, Duration) {
    loop {
        let (before, own) = (run(&mut empty_program()), run(&mut make()));
        let (own_first, after) = (run(&mut make()), run(&mut empty_program()));
        // An empty program that took longer was interrupted.
        if let Some(above) = (own + own_first).checked_sub(before + after) {
            return (above / 2, (before + after) / 2);
        }
    }
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

fn processes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("process");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(60);
    group.warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_millis(600));
    group.bench_function("empty program", |bencher| {
        bencher.iter_custom(|count| (0..count).map(|_| run(&mut empty_program())).sum());
    });
    let mut measure_beside_empty = |name: String, make: &mut dyn FnMut() -> Command| {
        let mut empties = Vec::new();
        group.bench_function(format!("{name}, above an empty program"), |bencher| {
            bencher.iter_custom(|count| {
                let mut sum = Duration::ZERO;
                for _ in 0..count {
                    let (above, empty) = above_empty(make);
                    sum += above;
                    empties.push(empty);
                }
                sum
            });
        });
        if !empties.is_empty() {
            println!("  the empty program beside it: median {:?}", median(empties));
        }
    };
    if true_of_system().is_some() {
        measure_beside_empty("--version".to_string(), &mut version);
    }
    let places = places();
    let mut kits = 0_u32;
    for controller in ["siemens-840d-sl", "fanuc-30i", "generic"] {
        for place in &places {
            let job = format!("fixtures/nine_errors_900/{controller}.toml");
            measure_beside_empty(format!("generate {controller} {}", place.name), &mut || {
                kits += 1; // removing a kit is no work of the program
                let mut command = Command::new(NONIUS);
                command.args(["generate", &job, "-o"]);
                command.arg(place.folder().join(format!("kit-{kits}")));
                command
            });
        }
    }
    group.finish();
}

criterion_group!(benches, processes);
criterion_main!(benches);
