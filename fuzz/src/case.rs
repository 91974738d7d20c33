//! One case of a reader, in this process: no panic, clean text, little memory.

use crate::coverage::{self, Edge};
use crate::readers::Answer;
use crate::{memory, oracles};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

/// What a case may hold at its peak: eight times what went in and came out, and 32 MiB.
pub fn memory_limit(bytes: usize) -> usize {
    8 * bytes + (32 << 20)
}

/// What came of a case.
#[derive(Default)]
pub struct Ran {
    /// What is wrong, if anything.
    pub wrong: Option<String>,
    /// The edges it took.
    pub trace: Vec<Edge>,
    /// What it answered, to compare with a second time.
    pub answer: String,
    /// Edges, each as often as it was taken.
    pub steps: u64,
}

static PANIC: Mutex<Option<String>> = Mutex::new(None);

/// A panic is noted with its place and not printed.
pub fn note_panics() {
    set_hook(Box::new(|panic: &PanicHookInfo<'_>| {
        let place =
            panic.location().map(|at| format!("{}:{}", at.file(), at.line())).unwrap_or_default();
        let words = panic.payload().downcast_ref::<String>().map(String::as_str);
        let words = words.or(panic.payload().downcast_ref::<&str>().copied());
        let words = words.unwrap_or("(no words)");
        *PANIC.lock().unwrap_or_else(PoisonError::into_inner) =
            Some(format!("panic at {place}: {words}"));
    }));
}

/// Runs a reader on an input.
pub fn read(reader: fn(&[u8]) -> Answer, input: &[u8]) -> Ran {
    coverage::clear();
    let start = memory::start();
    let answer = catch_unwind(AssertUnwindSafe(|| {
        reader(input).unwrap_or_else(|problems| problems.render())
    }));
    let peak = memory::peak(start);
    let (trace, steps) = (coverage::trace(coverage::counters()), coverage::steps());
    let Ok(answer) = answer else {
        let wrong = PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
        return Ran { wrong, trace, answer: String::new(), steps };
    };
    let limit = memory_limit(input.len() + answer.len());
    let wrong = match oracles::judge(&answer, input) {
        Ok(()) if peak > limit => Some(format!("memory: {} MiB at its peak", peak >> 20)),
        judged => judged.err(),
    };
    Ran { wrong, trace, answer, steps }
}
