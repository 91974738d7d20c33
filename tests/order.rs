//! The order of the rooms is the order of `src/lib.rs`: an import points backwards only. What reads a
//! control's files knows nothing of what writes them, and files are touched by the command line alone.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

use std::path::Path;

/// The code of every file under src/ without comments and test modules: path, room, lines.
fn sources() -> Vec<(String, String, Vec<String>)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    for path in glob::glob(&format!("{}/**/*.rs", src.display())).unwrap() {
        let path = path.unwrap();
        let name = path.strip_prefix(&src).unwrap().to_str().unwrap();
        let name = name.replace('\\', "/");
        if name == "main.rs" || name == "lib.rs" || name.contains("tests") {
            continue;
        }
        let room = name.split(['/', '.']).next().unwrap().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text
            .lines()
            .take_while(|line| *line != "mod tests {")
            .filter(|line| !line.trim_start().starts_with("//"))
            .map(str::to_string)
            .collect();
        files.push((name, room, code));
    }
    assert!(files.len() > 40, "only {} files were found", files.len());
    files
}

/// Rooms that a line names as `crate::…`.
fn named(line: &str) -> Vec<String> {
    let word = |rest: &str| {
        rest.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let mut parts = line.split("crate::");
    parts.next();
    parts.map(word).collect()
}

fn rooms() -> Vec<String> {
    let lib = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    let lines = lib.unwrap();
    let names = lines.lines();
    let names = names.filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    names.map(str::to_string).collect()
}

#[test]
fn there_are_ten_rooms_and_an_import_points_back_in_their_order() {
    let order = rooms();
    assert_eq!(order.len(), 11, "ten rooms and the command line: {order:?}");
    let place = |room: &str| {
        let found = order.iter().position(|known| *known == room);
        found.unwrap_or_else(|| panic!("`{room}` is not a room of src/lib.rs"))
    };
    for (file, room, code) in sources() {
        for other in code.iter().flat_map(|line| named(line)) {
            assert!(
                place(&other) <= place(&room),
                "src/{file} names crate::{other}, which comes after `{room}` in src/lib.rs"
            );
        }
    }
}

#[test]
fn what_reads_a_controls_files_knows_nothing_of_what_writes_them() {
    let known = ["quantity", "text", "control", "read"];
    for (file, room, code) in sources() {
        if room == "read" {
            let other = code.iter().flat_map(|line| named(line));
            let other = other
                .into_iter()
                .find(|name| !known.contains(&name.as_str()));
            assert_eq!(other, None, "src/{file}");
        }
        let tera = code.iter().any(|line| line.contains("tera::"));
        assert!(
            !tera || file.starts_with("write/emit"),
            "src/{file} uses tera"
        );
    }
}

#[test]
fn only_the_command_line_touches_files_environment_and_terminal() {
    let reserved = [
        "std::fs",
        "std::env",
        "std::io",
        "std::process",
        "println!",
        "print!(",
        "SystemTime",
    ];
    for (file, _, code) in sources().iter().filter(|(_, room, _)| room != "cli") {
        for line in code {
            if file == "write/emit/templates.rs" && line.contains("std::io::{Error,") {
                continue; // the engine writes into a text in memory that does not grow beyond a limit
            }
            let found = reserved.iter().find(|word| line.contains(**word));
            assert!(found.is_none(), "src/{file}: {line}");
        }
    }
}

#[test]
fn templates_lay_out_and_do_not_compute() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates");
    let computing = [
        "|", "round", " + ", " - ", " * ", " / ", " % ", "set ", "macro",
    ];
    let mut templates = 0;
    for path in glob::glob(&format!("{}/*.tera", folder.display())).unwrap() {
        let path = path.unwrap();
        templates += 1;
        let text = std::fs::read_to_string(&path).unwrap();
        let mut tags: Vec<&str> = Vec::new();
        for (open, close) in [("{{", "}}"), ("{%", "%}")] {
            let parts = text.split(open).skip(1);
            tags.extend(parts.map(|part| part.split(close).next().unwrap()));
        }
        assert!(!tags.is_empty(), "{} has no tag", path.display());
        for tag in tags {
            let inside = tag.trim_matches(['-', ' ']);
            for word in computing {
                assert!(!inside.contains(word), "{}: {tag}", path.display());
            }
        }
    }
    assert!(templates > 5, "only {templates} templates were found");
}
