//! The order of the rooms is the order of `src/lib.rs`: an import points backwards only, and inside a room
//! no files stand in a ring. What reads a control's files knows nothing of what writes them, and files are touched by the command line alone.
use crate::support::{Entry, fixtures, page, tree};
use std::collections::{BTreeMap, BTreeSet};

fn texts(folder: &str, end: &str) -> Vec<(String, String)> {
    let files = tree(&fixtures("..").join(folder)).into_iter();
    let texts = files.filter(|(name, _)| name.ends_with(end)).map(|(name, entry)| match entry {
        Entry::File(bytes) => (name, String::from_utf8(bytes).unwrap()),
        other => panic!("{name}: {other:?}"),
    });
    texts.collect()
}

/// The code of every file under src/ without comments and test modules: path, room, lines.
fn sources() -> Vec<(String, String, Vec<String>)> {
    let mut files = texts("src", ".rs");
    files.retain(|(name, _)| name != "main.rs" && name != "lib.rs" && !name.contains("tests"));
    assert!(files.len() > 40, "only {} files were found", files.len());
    let parted = files.into_iter().map(|(name, text)| {
        let room = name.split(['/', '.']).next().unwrap().to_string();
        let code = text.lines().take_while(|line| !line.ends_with("mod tests {"));
        let code = code.filter(|line| !line.trim_start().starts_with("//")).map(str::to_string);
        (name, room, code.collect())
    });
    parted.collect()
}

/// Rooms that a line names as `crate::…`.
fn named(line: &str) -> Vec<String> {
    let word = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let mut parts = line.split("crate::");
    parts.next();
    parts.map(word).collect()
}

fn rooms() -> Vec<String> {
    let lib = page("src/lib.rs");
    let names = lib.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    names.map(str::to_string).collect()
}

#[test]
fn there_are_twelve_rooms_and_an_import_points_back_in_their_order() {
    let order = rooms();
    assert_eq!(order.len(), 13, "twelve rooms and the command line: {order:?}");
    let place = |room: &str| {
        let found = order.iter().position(|known| *known == room);
        found.unwrap_or_else(|| panic!("`{room}` is not a room of src/lib.rs"))
    };
    for (file, room, code) in sources() {
        for other in code.iter().flat_map(|line| named(line)) {
            let comes = "comes after its room in src/lib.rs";
            assert!(place(&other) <= place(&room), "src/{file}: crate::{other} {comes}");
        }
    }
}

/// A file or a name from the root of the crate.
type Route = Vec<String>;

/// A file: what its names stand for, and what it uses.
#[derive(Default)]
struct Module {
    names: BTreeMap<String, Route>,
    uses: Vec<Route>,
}

fn words(path: &str) -> Route {
    path.split("::").map(|word| word.trim().to_string()).filter(|word| !word.is_empty()).collect()
}

/// `a::{b, c::{d, e as f}}` → each path with its name here.
fn spread(tree: &str) -> Vec<(String, String)> {
    let Some((stem, rest)) = tree.split_once('{') else {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, tree));
        let whole = |path: &str| path.trim().trim_end_matches("::self").to_string();
        return vec![(whole(path), words(&whole(name)).pop().unwrap())];
    };
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in rest[..rest.rfind('}').unwrap()].chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(String::new());
        } else {
            parts.last_mut().unwrap().push(c);
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| spread(&format!("{}{}", stem.trim(), part.trim()))).collect()
}

/// A path as it stands in the file `here`, from the root; `None` where it is not of this crate.
fn from_root(here: &[String], names: &BTreeMap<String, Route>, path: &str) -> Option<Route> {
    let path = words(path);
    let above = path.iter().take_while(|word| *word == "super").count();
    let (start, rest) = match path.first()?.as_str() {
        "crate" => (Vec::new(), 1),
        "self" => (here.to_vec(), 1),
        "super" => (here[..here.len() - above].to_vec(), above),
        first => (names.get(first)?.clone(), 1),
    };
    Some([&start, &path[rest..]].concat())
}

/// A file and what it gives on or imports; to give on what files below define is no use of them.
fn module(file: &str, lines: &[String]) -> (Route, Module) {
    let here = words(&file.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::"));
    let (mut found, mut code, mut imports) = (Module::default(), String::new(), Vec::new());
    let mut lines = lines.iter().map(|line| line.trim());
    while let Some(line) = lines.next() {
        let limited = line.split_once(") ").filter(|_| line.starts_with("pub("));
        let bare = limited.map_or(line, |(_, rest)| rest).trim_start_matches("pub ");
        if let Some(child) = bare.strip_prefix("mod ").and_then(|line| line.strip_suffix(';')) {
            found.names.insert(child.to_string(), [&here[..], &[child.to_string()]].concat());
        } else if let Some(tree) = bare.strip_prefix("use ") {
            let tree = match tree.strip_suffix(';') {
                Some(tree) => tree.to_string(),
                None => {
                    let more = lines.by_ref().take_while(|line| *line != "};");
                    format!("{tree}{}}}", more.collect::<String>())
                }
            };
            let is_private = bare == line;
            imports.extend(spread(&tree).into_iter().map(|(path, name)| (path, name, is_private)));
        } else {
            let (before, after) = line.split_once("pub(in ").unwrap_or((line, ""));
            let after = after.split_once(')').map_or("", |(_, rest)| rest);
            code.extend([before, after, "\n"]);
        }
    }
    for (path, name, is_private) in imports {
        let Some(full) = from_root(&here, &found.names, &path) else { continue };
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let again = || {
            code.split_inclusive(|c| !is_word(c)).any(|word| {
                let bare = word.trim_end_matches(|c| !is_word(c));
                bare == name && (word.ends_with('(') || name.starts_with(char::is_uppercase))
            })
        };
        if is_private || !full.starts_with(&here) || again() {
            found.uses.push(full.clone());
        }
        found.names.insert(name, full);
    }
    let paths = code.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    let paths = paths.filter(|path| path.contains("::"));
    found.uses.extend(paths.filter_map(|path| from_root(&here, &found.names, path)));
    (here, found)
}

/// The file that defines what is named, through all files that only give it on.
fn defining(modules: &BTreeMap<Route, Module>, path: &[String]) -> Option<Route> {
    let length = (1..=path.len()).rev().find(|length| modules.contains_key(&path[..*length]))?;
    let given = path.get(length).and_then(|name| modules[&path[..length]].names.get(name));
    match given.filter(|given| given[..] != path[..=length]) {
        Some(given) => defining(modules, &[given, &path[length + 1..]].concat()),
        None => Some(path[..length].to_vec()),
    }
}

#[test]
fn no_files_of_a_room_stand_in_a_ring() {
    let modules: BTreeMap<_, _> =
        sources().iter().map(|(file, _, code)| module(file, code)).collect();
    let arrows: BTreeMap<&Route, BTreeSet<Route>> = modules
        .iter()
        .map(|(name, module)| {
            let to = module.uses.iter().filter_map(|path| defining(&modules, path));
            (name, to.filter(|to| to != name).collect())
        })
        .collect();
    let reached = |from: &Route| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(name) = next.pop() {
            next.extend(arrows[name].iter().filter(|to| seen.insert((*to).clone())));
        }
        seen
    };
    let in_ring = |(from, to): (&&Route, &BTreeSet<Route>)| {
        let back = to.iter().filter(|to| reached(to).contains(*from)).map(|to| to.join("::"));
        ((*from).clone(), back.collect::<Vec<String>>())
    };
    let rooms = rooms();
    let found = arrows.iter().map(in_ring).filter(|(_, back)| !back.is_empty());
    let found = found.filter(|(from, _)| rooms.contains(&from[0]));
    let wrong: Vec<String> =
        found.map(|(from, to)| format!("{} -> {}", from.join("::"), to.join(" "))).collect();
    assert!(wrong.is_empty(), "{} files use each other:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn what_reads_a_controls_files_knows_nothing_of_what_writes_them() {
    let known = ["quantity", "text", "control", "read"];
    for (file, room, code) in sources() {
        let mut others = code.iter().flat_map(|line| named(line));
        let other = others.find(|name| room == "read" && !known.contains(&name.as_str()));
        assert_eq!(other, None, "src/{file}");
        let tera = code.iter().any(|line| line.contains("tera::"));
        let may = file.starts_with("write/emit") || file == "write/control_text.rs";
        assert!(!tera || may, "src/{file} uses tera");
    }
}

#[test]
fn only_the_command_line_touches_files_environment_and_terminal() {
    let reserved = "std::fs std::env std::io std::process println! print!( SystemTime Instant";
    // A text with a limit, bytes that are read as a workbook, and what a disk and files in memory have in common.
    let in_memory = [
        ("write/emit/templates.rs", "std::io::{Error,"),
        ("inputs/import/spreadsheet.rs", "std::io::Cursor"),
        ("visit/", "std::io::"),
    ];
    for (file, _, code) in sources().iter().filter(|(_, room, _)| room != "cli") {
        let is_meant = |line: &&String| {
            !in_memory.iter().any(|(own, words)| file.starts_with(own) && line.contains(words))
        };
        let touches = |line: &&String| reserved.split(' ').any(|word| line.contains(word));
        assert_eq!(code.iter().filter(is_meant).find(touches), None, "src/{file}");
    }
}

#[test]
fn templates_lay_out_and_do_not_compute() {
    let computing = ["|", "round", " + ", " - ", " * ", " / ", " % ", "set ", "macro"];
    let templates = texts("templates", ".tera");
    for (name, text) in &templates {
        let tags = [("{{", "}}"), ("{%", "%}")].iter().flat_map(|(open, close)| {
            let parts = text.split(open).skip(1);
            parts.map(move |part| part.split(close).next().unwrap().trim_matches(['-', ' ']))
        });
        let tags: Vec<&str> = tags.collect();
        assert!(!tags.is_empty(), "{name} has no tag");
        let computes = |tag: &&str| computing.iter().any(|word| tag.contains(word));
        assert_eq!(tags.into_iter().find(computes), None, "{name}");
    }
    assert!(templates.len() > 5, "only {} templates were found", templates.len());
}
