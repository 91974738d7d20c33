//! Work that is divided among threads.

use std::ops::Range;

/// As many threads as the computer runs at once; a page in a browser has one.
pub fn count() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// What each part of the work gives, in their order: a thread for each, one of them this one.
pub fn of_parts<P: Send, T: Send>(parts: Vec<P>, work: impl Fn(P) -> T + Sync) -> Vec<T> {
    let (work, mut parts) = (&work, parts.into_iter());
    let first = parts.next();
    std::thread::scope(|scope| {
        let running: Vec<_> = parts.map(|part| scope.spawn(move || work(part))).collect();
        let own = first.map(work);
        let joined = running
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|reason| std::panic::resume_unwind(reason)));
        own.into_iter().chain(joined).collect()
    })
}

/// What each number below `many` gives that `step` divides, in their order, whatever the number of threads.
pub fn of_numbers<T: Send>(many: usize, step: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let share = many.div_ceil(step * count()).max(1) * step;
    let ranges: Vec<Range<usize>> =
        (0..many).step_by(share).map(|from| from..many.min(from + share)).collect();
    let each = of_parts(ranges, |own| own.step_by(step).map(&of).collect::<Vec<T>>());
    each.into_iter().flatten().collect()
}
