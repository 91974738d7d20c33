//! The order of the modules is the order of `src/lib.rs`: an import points backwards only. The
//! parts that check each other share no code, and files are touched by the command line alone.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

use std::path::Path;

/// The code of every file under src/ without comments and test modules: path, module, lines.
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
        let module = name.split(['/', '.']).next().unwrap().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text
            .lines()
            .take_while(|line| *line != "mod tests {")
            .filter(|line| !line.trim_start().starts_with("//"))
            .map(str::to_string)
            .collect();
        files.push((name, module, code));
    }
    assert!(files.len() > 40, "only {} files were found", files.len());
    files
}

/// Modules that a line names as `crate::…`.
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

#[test]
fn an_import_points_back_in_the_order_of_the_modules() {
    let lib = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    let lib = lib.unwrap();
    let order: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    let place = |module: &str| {
        let found = order.iter().position(|known| *known == module);
        found.unwrap_or_else(|| panic!("`{module}` is not a module of src/lib.rs"))
    };
    for (file, module, code) in sources() {
        for other in code.iter().flat_map(|line| named(line)) {
            assert!(
                place(&other) <= place(&module),
                "src/{file} names crate::{other}, which comes after `{module}` in src/lib.rs"
            );
        }
    }
}

#[test]
fn what_is_made_and_what_checks_it_share_no_code() {
    let apart = [
        (
            ["readback", "emulate"].as_slice(),
            ["emit", "compensation", "program"].as_slice(),
        ),
        (
            &["emit", "compensation", "program"],
            &["readback", "emulate"],
        ),
    ];
    for (file, module, code) in sources() {
        let named: Vec<String> = code.iter().flat_map(|line| named(line)).collect();
        for (ours, theirs) in &apart {
            let other = named.iter().find(|name| theirs.contains(&name.as_str()));
            assert!(
                !ours.contains(&module.as_str()) || other.is_none(),
                "src/{file} names crate::{other:?}"
            );
        }
        let tera = code.iter().any(|line| line.contains("tera::"));
        assert!(!tera || module == "emit", "src/{file} uses tera");
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
    for (file, _, code) in sources().iter().filter(|(_, module, _)| module != "cli") {
        for line in code {
            if file == "emit/templates.rs" && line.contains("std::io::{Error,") {
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

#[test]
fn unsafe_code_stands_in_one_module() {
    for (file, _, code) in sources() {
        let found = code
            .iter()
            .any(|line| line.contains("unsafe {") || line.contains("unsafe fn"));
        assert!(
            !found || file == "space/processor.rs",
            "src/{file} has unsafe code"
        );
    }
}
