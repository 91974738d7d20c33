//! From all inputs that were found, the smallest that together take every edge: the corpus of the repository.

use crate::bundle::Bundle;
use crate::case::note_panics;
use crate::queue::Queue;
use crate::random::hash;
use crate::targets::all;
use std::fs;
use std::path::Path;

/// A file of the corpus is not larger, and all files of a target together are not.
const LARGEST: usize = 6 << 10;
const MOST: usize = 36 << 10;

/// Writes `corpus/` anew from itself and from the directory of a run.
pub fn distil(run: &Path) {
    note_panics();
    for target in all() {
        let mut found = Bundle::default();
        for worker in 0..64 {
            found.add_directory(
                &run.join(worker.to_string()).join("queue").join(target.name),
                "",
            );
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(target.name);
        found.add_directory(&folder, "");
        let mut inputs: Vec<Vec<u8>> = found
            .0
            .into_iter()
            .map(|(_, bytes)| bytes)
            .filter(|input| input.len() <= LARGEST)
            .collect();
        inputs.sort_by_key(Vec::len);
        let mut known = Queue::default();
        for seed in &target.seeds {
            known.add(seed, &target.run(run, seed).trace);
        }
        let mut size = 0;
        let _ = fs::remove_dir_all(&folder);
        let _ = fs::create_dir_all(&folder);
        for input in inputs {
            let ran = target.run(run, &input);
            if ran.wrong.is_none() && size + input.len() <= MOST && known.add(&input, &ran.trace) {
                size += input.len();
                let _ = fs::write(folder.join(format!("{:016x}", hash(&input))), input);
            }
        }
        println!("{}: {} edges, {size} bytes", target.name, known.edges());
    }
}
