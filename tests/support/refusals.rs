//! The cases of fixtures/cases/refuses, in the form that fixtures/cases/README.md says.

use super::tree::{Entry, Tree, tree};
use std::fs;
use std::path::{Path, PathBuf};

/// What stands before the name of a case.
const HEAD: &str = "\n== ";

pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) command: String,
    pub(crate) files: Tree,
    /// Exit status, then everything that is printed.
    pub(crate) expected: String,
}

pub(crate) fn pages(fixtures: &Path) -> Vec<PathBuf> {
    let folder = fs::read_dir(fixtures.join("cases/refuses")).expect("the cases are there");
    let mut pages: Vec<PathBuf> = folder.flatten().map(|entry| entry.path()).collect();
    pages.sort();
    pages
}

pub(crate) fn all(fixtures: &Path) -> Vec<Case> {
    let read = |page: PathBuf| cases(fixtures, &fs::read_to_string(page).expect("it is text"));
    pages(fixtures).into_iter().flat_map(read).collect()
}

pub(crate) fn cases(fixtures: &Path, page: &str) -> Vec<Case> {
    let parts = page.split(HEAD).skip(1);
    parts.map(|part| case(fixtures, part)).collect()
}

/// The file with what is said now, in the order of its cases.
pub(crate) fn with_expectations(page: &str, said: &[String]) -> String {
    let mut parts = page.split(HEAD);
    let mut written = parts.next().unwrap_or_default().to_string();
    for (part, said) in parts.zip(said) {
        written += HEAD;
        for line in part.lines().take_while(|line| !line.starts_with('>')) {
            written += &format!("{line}\n");
        }
        for line in said.lines() {
            written += &format!("> {line}\n").replace("> \n", ">\n");
        }
    }
    written
}

fn case(fixtures: &Path, part: &str) -> Case {
    let mut lines = part.lines();
    let mut case = Case {
        name: lines.next().unwrap_or_default().to_string(),
        command: "generate job.toml -o kit".to_string(), // without a line `$`
        files: Tree::new(),
        expected: String::new(),
    };
    let mut lines = lines.peekable();
    while let Some(line) = lines.next() {
        let told = line.get(2..).unwrap_or_default();
        match line.get(..1) {
            Some("$") => case.command = unescaped(told),
            Some("<") => case.files.extend(tree(&fixtures.join(told))),
            Some("!") => assert!(case.files.remove(told).is_some(), "{}: {line}", case.name),
            Some("@") => {
                let is_own = |line: &&str| line.is_empty() || line.starts_with([' ', '-', '+']);
                let own: Vec<&str> = std::iter::from_fn(|| lines.next_if(is_own)).collect();
                put(fixtures, told, &own, &mut case);
            }
            Some(">") => case.expected += &format!("{told}\n"),
            _ => panic!("{}: `{line}` begins with none of $ < ! @ >", case.name),
        }
    }
    case
}

/// A file as a whole, a copy of another one, or one of both with other lines in it.
fn put(fixtures: &Path, head: &str, own: &[&str], case: &mut Case) {
    let (name, source) = head.split_once(" = ").unzip();
    let crlf = head.strip_suffix(" CR LF");
    let name = name.or(crlf).unwrap_or(head).to_string();
    let source = source.map(|path| fs::read(fixtures.join(path)).expect("the source is there"));
    let whole = source.is_none() && own.iter().all(|line| line.starts_with('+'));
    let before = match case.files.remove(&name) {
        Some(Entry::File(bytes)) => Some(bytes),
        _ => None,
    };
    let bytes = match source.or(before) {
        Some(bytes) if !whole => edited(bytes, own, &case.name),
        _ if crlf.is_some() => lines_of(own, "+").replace('\n', "\r\n").into_bytes(),
        _ => lines_of(own, "+").into_bytes(),
    };
    case.files.insert(name, Entry::File(bytes));
}

/// Each group of lines replaced, which stands in the file once; the line ends stay.
fn edited(bytes: Vec<u8>, own: &[&str], case: &str) -> Vec<u8> {
    if own.is_empty() {
        return bytes;
    }
    let text = String::from_utf8(bytes).expect("only a file of text is edited");
    let mut lines = format!("\n{}", text.replace("\r\n", "\n"));
    for group in own.split(|line| line.is_empty()) {
        let (old, new) = (lines_of(group, " -"), lines_of(group, " +"));
        let (old, new) = (format!("\n{old}"), format!("\n{new}"));
        let windows = lines.as_bytes().windows(old.len());
        let found = windows.filter(|part| *part == old.as_bytes()).count();
        assert_eq!(found, 1, "{case}: times that these lines are found{old}");
        lines = lines.replace(&old, &new);
    }
    lines.remove(0);
    if text.contains("\r\n") {
        lines = lines.replace('\n', "\r\n");
    }
    lines.into_bytes()
}

/// The text of the lines that begin with one of the marks.
fn lines_of(own: &[&str], marks: &str) -> String {
    let marked = own.iter().filter(|line| line.starts_with(|mark| marks.contains(mark)));
    marked.map(|line| unescaped(line.get(2..).unwrap_or_default()) + "\n").collect()
}

/// A text in which `\u{…}` stands for what an editor does not show.
fn unescaped(text: &str) -> String {
    let Some((before, rest)) = text.split_once("\\u{") else { return text.to_string() };
    let (code, rest) = rest.split_once('}').expect("an escape ends with a brace");
    let code = u32::from_str_radix(code, 16).expect("an escape is hexadecimal");
    let code = char::from_u32(code).expect("an escape is a character");
    format!("{before}{code}{}", unescaped(rest))
}
