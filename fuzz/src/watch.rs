//! The case that runs, as a file that outlives this process; and a thread that ends the process when a case takes too
//! long. Processor time counts, which a busy machine does not change; a case that only waits is ended later.

use rustix::time::{ClockId, clock_gettime};
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Processor time of a case in this process.
const BUSY: Duration = Duration::from_secs(10);
/// Time by the clock on the wall, also of the processes that a case starts.
const WAITING: Duration = Duration::from_secs(120);

static BEGAN: Mutex<Option<(Duration, Instant)>> = Mutex::new(None);
static CURRENT: OnceLock<File> = OnceLock::new();

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    let (seconds, rest) = (time.tv_sec.try_into(), time.tv_nsec.try_into());
    Duration::new(seconds.unwrap_or(0), rest.unwrap_or(0))
}

/// A case begins.
pub fn begin(target: &str, input: &[u8]) {
    let head = format!("{target} {}\n", input.len());
    if let Some(file) = CURRENT.get() {
        // Without the note a killed case is not known; it is found again.
        let _ = file.write_all_at(&[head.as_bytes(), input].concat(), 0);
    }
    *BEGAN.lock().unwrap_or_else(PoisonError::into_inner) =
        Some((processor_time(), Instant::now()));
}

/// The case is over.
pub fn end() {
    *BEGAN.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// Target and input of the case that ran last in a directory.
pub fn current(place: &Path) -> Option<(String, Vec<u8>)> {
    let bytes = fs::read(place.join("current")).ok()?;
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let head = std::str::from_utf8(&bytes[..end]).ok()?;
    let (target, length) = head.split_once(' ')?;
    let input = bytes.get(end + 1..end + 1 + length.parse::<usize>().ok()?)?;
    Some((target.to_string(), input.to_vec()))
}

/// Cases are noted in the directory from now on.
pub fn note_in(place: &Path) {
    if let Ok(file) = File::create(place.join("current")) {
        let _ = CURRENT.set(file);
    }
}

/// Watches from now on; `what` is named when a case is ended.
pub fn start(what: &Path) {
    let what = what.display().to_string();
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(500));
            let began = *BEGAN.lock().unwrap_or_else(PoisonError::into_inner);
            let Some((busy, waiting)) = began else {
                continue;
            };
            if processor_time().saturating_sub(busy) > BUSY || waiting.elapsed() > WAITING {
                eprintln!("time: {} s and more: {what}", BUSY.as_secs());
                std::process::abort();
            }
        }
    });
}
