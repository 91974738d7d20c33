//! Which edges of the program a case took, and how often.
//!
//! The compiler puts an 8-bit counter on every edge of `nonius` (src/launcher.rs asks for it) and calls
//! [`__sanitizer_cov_8bit_counters_init`] with their memory before `main`. Without the flags there is no counter, every
//! trace is empty, and the queue stays as it is: plain mutation.
#![allow(
    unsafe_code,
    reason = "the counters are memory that the compiler made; nothing else reaches it"
)]

use std::sync::atomic::{AtomicPtr, AtomicU64, AtomicUsize, Ordering};

static START: AtomicPtr<u8> = AtomicPtr::new(std::ptr::null_mut());
static LENGTH: AtomicUsize = AtomicUsize::new(0);
static STEPS: AtomicU64 = AtomicU64::new(0);

/// An edge, and how often it was taken, as one bit: 1, 2, 3, 4–7, 8–15, 16–31, 32–127, more.
pub type Edge = (usize, u8);

/// Called by code of the compiler before `main`, once for each part of the program, with the same memory.
#[unsafe(no_mangle)]
pub extern "C" fn __sanitizer_cov_8bit_counters_init(start: *mut u8, stop: *mut u8) {
    START.store(start, Ordering::Relaxed);
    LENGTH.store(stop as usize - start as usize, Ordering::Relaxed);
}

/// Called by code of the compiler before `main`; its guards are not used.
#[unsafe(no_mangle)]
pub extern "C" fn __sanitizer_cov_trace_pc_guard_init(_start: *mut u32, _stop: *mut u32) {}

/// Called by code of the compiler at every edge.
#[unsafe(no_mangle)]
pub extern "C" fn __sanitizer_cov_trace_pc_guard(_guard: *mut u32) {
    // No read-modify-write: of several threads one may lose a step, and one alone is much faster.
    STEPS.store(STEPS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

/// How many edges were taken since [`clear`], each as often as it was.
pub fn steps() -> u64 {
    STEPS.load(Ordering::Relaxed)
}

/// How many edges there are.
pub fn edges() -> usize {
    LENGTH.load(Ordering::Relaxed)
}

/// All counters at zero.
pub fn clear() {
    STEPS.store(0, Ordering::Relaxed);
    let start = START.load(Ordering::Relaxed);
    if !start.is_null() {
        // SAFETY: the compiler's array of this length. A thread of the program that counts meanwhile loses a count.
        unsafe { std::ptr::write_bytes(start, 0, edges()) }
    }
}

/// The counters as they are.
pub fn counters() -> &'static [u8] {
    let start = START.load(Ordering::Relaxed);
    if start.is_null() {
        return &[];
    }
    // SAFETY: the compiler's array of this length, for as long as the process runs. Cases are over when it is read.
    unsafe { std::slice::from_raw_parts(start, edges()) }
}

/// The edges that were taken.
pub fn trace(counters: &[u8]) -> Vec<Edge> {
    let mut taken = Vec::new();
    for (block, counters) in counters.chunks(BLOCK).enumerate() {
        if counters.iter().fold(0, |any, count| any | count) == 0 {
            continue;
        }
        let hit = counters.iter().enumerate().filter(|(_, count)| **count > 0);
        taken.extend(hit.map(|(index, count)| (block * BLOCK + index, class(*count))));
    }
    taken
}

/// Counters that are compared at once; most are zero.
const BLOCK: usize = 64;

fn class(count: u8) -> u8 {
    match count {
        0..=3 => 1 << (count.max(1) - 1),
        4..=7 => 8,
        8..=15 => 16,
        16..=31 => 32,
        32..=127 => 64,
        128.. => 128,
    }
}
