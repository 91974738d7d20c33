//! Several files as one input, so that all of them are changed alike:
//!
//! ```text
//! === job.toml
//! schema = 1
//! …
//! === errors.csv
//! …
//! ```

use crate::tree::{Entry, Tree, tree};
use std::collections::BTreeSet;
use std::path::Path;

/// Files with their names, in order.
#[derive(Clone, Default)]
pub struct Bundle(pub Vec<(String, Vec<u8>)>);

const HEAD: &[u8] = b"=== ";
/// Files of a folder; nobody keeps more with a job.
const MOST: usize = 1000;

impl Bundle {
    /// Splits an input. Names that would lie elsewhere are left out, also those that are there already, what comes after
    /// [`MOST`] of them, and what stands before the first.
    pub fn read(input: &[u8]) -> Bundle {
        let mut files: Vec<(String, Vec<u8>)> = Vec::new();
        for line in input.split_inclusive(|byte| *byte == b'\n') {
            match (line.strip_prefix(HEAD), files.last_mut()) {
                (Some(name), _) => {
                    files.push((String::from_utf8_lossy(name).trim().to_string(), Vec::new()))
                }
                (None, Some((_, bytes))) => bytes.extend_from_slice(line),
                (None, None) => {}
            }
        }
        for (_, bytes) in &mut files {
            bytes.pop(); // the line end before the next head is no part of the file
        }
        let mut known = BTreeSet::new();
        files.retain(|(name, _)| is_inside(name) && known.insert(name.clone()));
        files.truncate(MOST);
        Bundle(files)
    }

    /// The input that [`Bundle::read`] splits into these files.
    pub fn bytes(&self) -> Vec<u8> {
        let mut all = Vec::new();
        for (name, bytes) in &self.0 {
            all.extend_from_slice(format!("=== {name}\n").as_bytes());
            all.extend_from_slice(bytes);
            all.push(b'\n');
        }
        all
    }

    /// The first file of a name.
    pub fn file(&self, name: &str) -> Option<&[u8]> {
        self.0.iter().find(|(own, _)| own == name).map(|(_, bytes)| bytes.as_slice())
    }

    /// Adds what lies in a directory, also in its folders, in order of the names; a directory that is not there is empty.
    pub fn add_directory(&mut self, directory: &Path) {
        if directory.is_dir() {
            self.add(tree(directory));
        }
    }

    /// Adds the files of a directory that was read.
    pub fn add(&mut self, tree: Tree) {
        let file = |(name, entry)| match entry {
            Entry::File(bytes) => Some((name, bytes)),
            _ => None,
        };
        self.0.extend(tree.into_iter().filter_map(file));
    }
}

/// A name that cannot leave its directory; of letters, every class is one.
pub fn is_inside(name: &str) -> bool {
    (1..=80).contains(&name.len())
        && !name.contains('\0')
        && name.split('/').all(|part| !matches!(part, "" | "." | ".."))
}
