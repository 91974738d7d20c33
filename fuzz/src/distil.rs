//! From all inputs that were found, those that together take every edge that the fixtures do not take: the corpus of the repository.

use crate::bundle::Bundle;
use crate::case::{Ran, note_panics};
use crate::finding::hash;
use crate::targets::{Target, all};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// A file of the corpus is not larger, and all files of a target together are not.
const LARGEST: usize = 6 << 10;
const MOST: usize = 36 << 10;

/// Writes `corpus/` anew from itself and from the directory of a run; of one target or of all.
pub fn distil(run: &Path, only: Option<&str>) {
    note_panics();
    let wanted = |name: &str| only.is_none_or(|only| only == name);
    for target in all().into_iter().filter(|target| wanted(target.name)) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = folder.join("corpus").join(target.name);
        let mut found = Bundle::default();
        found.add_directory(&folder);
        let own: BTreeSet<Vec<u8>> = found.0.iter().map(|(_, bytes)| bytes.clone()).collect();
        for worker in 0..64 {
            let queue = run.join(worker.to_string()).join("queue");
            found.add_directory(&queue.join(target.name));
        }
        let mut known = BTreeSet::new();
        for seed in target.seeds.iter().filter(|seed| !own.contains(*seed)) {
            known.extend(edges(&target.run(run, seed)));
        }
        let _ = fs::remove_dir_all(&folder);
        let _ = fs::create_dir_all(&folder);
        let inputs = found.0.into_iter().map(|(_, bytes)| bytes);
        let mut size = 0;
        for input in most_first(&target, run, inputs, &mut known) {
            if size + input.len() <= MOST {
                size += input.len();
                let _ = fs::write(folder.join(format!("{:016x}", hash(&input))), input);
            }
        }
        println!("{}: {} edges, {size} bytes", target.name, known.len());
    }
}

/// The inputs that take edges which are not known yet, those with the most edges first.
fn most_first(
    target: &Target,
    run: &Path,
    inputs: impl Iterator<Item = Vec<u8>>,
    known: &mut BTreeSet<usize>,
) -> Vec<Vec<u8>> {
    let is_new = |ran: &Ran, known: &BTreeSet<usize>| edges(ran).any(|edge| !known.contains(&edge));
    let mut ran: Vec<(Vec<u8>, Ran)> = inputs
        .filter(|input| input.len() <= LARGEST)
        .map(|input| {
            let ran = target.run(run, &input);
            (input, ran)
        })
        .filter(|(_, ran)| ran.wrong.is_none() && is_new(ran, known))
        .collect();
    ran.sort_by_key(|(_, ran)| std::cmp::Reverse(ran.trace.len()));
    ran.retain(|(_, ran)| {
        let stays = is_new(ran, known);
        known.extend(edges(ran));
        stays
    });
    ran.into_iter().map(|(input, _)| input).collect()
}

fn edges(ran: &Ran) -> impl Iterator<Item = usize> {
    ran.trace.iter().map(|(edge, _)| *edge)
}
