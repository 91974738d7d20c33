//! How much memory a case took at its peak. An allocation beyond [`MOST`] fails, and the process ends.
#![allow(
    unsafe_code,
    reason = "an allocator is unsafe by its nature; this one counts and hands on to the system's"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// No case may hold more; the machine has to survive.
const MOST: usize = 1 << 30;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

fn grow(size: usize) -> bool {
    let now = NOW.fetch_add(size, Relaxed) + size;
    PEAK.fetch_max(now, Relaxed);
    if now > MOST {
        NOW.fetch_sub(size, Relaxed);
    }
    now <= MOST
}

// SAFETY: every call goes to the system's allocator with the same arguments, or fails as an allocator may.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match grow(layout.size()) {
            true => unsafe { System.alloc(layout) },
            false => std::ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !grow(size) {
            return std::ptr::null_mut();
        }
        let moved = unsafe { System.realloc(memory, layout, size) };
        let freed = if moved.is_null() { size } else { layout.size() };
        NOW.fetch_sub(freed, Relaxed);
        moved
    }
}

/// What is held now; the peak starts from here.
pub fn start() -> usize {
    let now = NOW.load(Relaxed);
    PEAK.store(now, Relaxed);
    now
}

/// The most that was held since [`start`], beyond what was held then.
pub fn peak(start: usize) -> usize {
    PEAK.load(Relaxed).saturating_sub(start)
}
