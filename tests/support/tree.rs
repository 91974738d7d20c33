//! A directory as it lies on the disk: names and bytes, compared before and after a run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    Directory,
    File(Vec<u8>),
    /// A link and where it leads, or a device.
    Other(String),
}

/// Everything below a directory; names with `/`, links not followed.
pub(crate) type Tree = BTreeMap<String, Entry>;

pub(crate) fn tree(directory: &Path) -> Tree {
    let mut found = Tree::new();
    add(directory, "", &mut found);
    found
}

fn add(directory: &Path, prefix: &str, found: &mut Tree) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let entry = entry.expect("an entry");
        let kind = entry.file_type().expect("a kind");
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        let what = if kind.is_dir() {
            add(&entry.path(), &format!("{name}/"), found);
            Entry::Directory
        } else if kind.is_file() {
            Entry::File(fs::read(entry.path()).expect("a file"))
        } else {
            let to = fs::read_link(entry.path()).unwrap_or_default();
            Entry::Other(format!("{kind:?} {}", to.display()))
        };
        found.insert(name, what);
    }
}

/// What lies below one of its directories; `None` where there is none.
pub(crate) fn below(tree: &Tree, directory: &str) -> Option<Tree> {
    if tree.get(directory) != Some(&Entry::Directory) {
        return None;
    }
    let prefix = format!("{directory}/");
    let inner = |(name, entry): (&String, &Entry)| {
        let name = name.strip_prefix(&prefix)?;
        Some((name.to_string(), entry.clone()))
    };
    Some(tree.iter().filter_map(inner).collect())
}

/// Writes a tree into an empty directory, and the directories that its names ask for.
pub(crate) fn lay(tree: &Tree, directory: &Path) {
    for (name, entry) in tree {
        let path = directory.join(name);
        let above = path.parent().expect("a directory");
        fs::create_dir_all(above).expect("a directory can be made");
        match entry {
            Entry::Directory => fs::create_dir_all(path).expect("a directory can be made"),
            Entry::File(bytes) => fs::write(path, bytes).expect("a file can be written"),
            Entry::Other(what) => panic!("{name}: {what} is not laid"),
        }
    }
}

pub(crate) fn copies(tree: &Tree, bytes: &[u8]) -> usize {
    let is_copy = |entry: &&Entry| matches!(entry, Entry::File(found) if found == bytes);
    tree.values().filter(is_copy).count()
}

/// Names that one tree has and the other has not, or with other content.
pub(crate) fn difference(before: &Tree, after: &Tree) -> String {
    let names = before.keys().chain(after.keys());
    let differs = |name: &&String| before.get(*name) != after.get(*name);
    let mut names: Vec<&str> = names.filter(differs).map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    names.join(", ")
}

pub(crate) fn skipped(why: &str) {
    told(&format!("skipped: {why}"));
}

/// Whether a program is here; says so where it is not.
pub(crate) fn is_installed(program: &str) -> bool {
    let is_here = Command::new(program).arg("--version").output().is_ok();
    if !is_here {
        skipped(&format!("`{program}` is not installed"));
    }
    is_here
}

/// Says something of a test past the capture of the test runner.
pub(crate) fn told(what: &str) {
    let thread = std::thread::current();
    let line = format!("{}: {what}\n", thread.name().unwrap_or("a test"));
    let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
}
