//! Work on all cores.

use std::panic::resume_unwind;
use std::sync::Mutex;

/// Takes each item once, on all cores; the results in the order of the items.
pub(crate) fn in_parallel<I, T: Send>(
    items: impl IntoIterator<Item = I, IntoIter: Send>,
    of: impl Fn(I) -> T + Sync,
) -> Vec<T> {
    let left = Mutex::new(items.into_iter().enumerate());
    let next = || left.lock().expect("no item panics while it is taken").next();
    let work = || {
        let own = std::iter::from_fn(next).map(|(index, item)| (index, of(item)));
        own.collect::<Vec<_>>()
    };
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    let mut found: Vec<(usize, T)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    });
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, result)| result).collect()
}
