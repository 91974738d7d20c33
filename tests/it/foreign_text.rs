//! Text of others reaches no terminal, checklist or table with characters that a person does not see.

use nonius::control::controller::builtin;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Sets a terminal's title, turns the direction of the text, hides what follows, ends a line.
const FOREIGN: &str = "A\u{1b}]0;owned\u{7}\u{202e}B\u{9b}8mC\u{2028}D";

fn fixture(name: &str) -> std::path::PathBuf {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    fixtures.join(name)
}

fn is_unseen(c: char) -> bool {
    let named = "\u{202e}\u{2028}\u{200b}".contains(c);
    named || (c.is_control() && !"\n\t".contains(c))
}

/// Runs the program and looks at everything that it tells.
fn told(at: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments)
        .current_dir(at)
        .output()
        .expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8(text).expect("text");
    let found = text.chars().find(|c| is_unseen(*c));
    assert_eq!(found, None, "{arguments:?}\n{}", text.escape_debug());
    (output.status.code(), text)
}

fn start() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a directory");
    for name in ["job.toml", "errors.csv"] {
        fs::copy(fixture("start/errors").join(name), place.path().join(name)).expect("a fixture");
    }
    place
}

#[test]
fn of_a_manifest() {
    let place = start();
    let at = place.path();
    told(at, &["generate", "job.toml", "-o", "kit"]);
    let path = at.join("kit/manifest.json");
    let manifest = fs::read_to_string(&path).expect("a manifest");
    let mut document: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    for key in ["tool", "controller"] {
        document[key] = FOREIGN.into();
    }
    document["machine"] = serde_json::json!({ "name": FOREIGN, "measured": FOREIGN });
    document["files"][0]["path"] = FOREIGN.into();
    document["inputs"][0]["path"] = FOREIGN.into();
    document["predecessor"] = serde_json::json!({ "path": FOREIGN, "manifest_sha256": "0" });
    fs::write(&path, document.to_string()).expect("a manifest");
    for format in ["text", "json"] {
        told(at, &["history", "kit", "--format", format]);
        told(at, &["verify", "job.toml", "--tables", "kit", "--format", format]);
    }
    document["files"] = serde_json::json!([{ "path": format!("../{FOREIGN}"), "sha256": "0" }]);
    fs::write(&path, document.to_string()).expect("a manifest");
    told(at, &["history", "kit"]);
}

#[test]
fn of_comments_in_an_error_table() {
    let place = start();
    let at = place.path();
    let table = fs::read_to_string(at.join("errors.csv")).expect("the table");
    let doubtful = format!("# doubt: {FOREIGN}\n# simulated: {FOREIGN}\n{table}");
    fs::write(at.join("errors.csv"), doubtful).expect("a table");
    let (_, text) = told(at, &["generate", "job.toml", "-o", "kit"]);
    assert!(text.contains("owned"), "the doubt is told\n{text}");
    for entry in fs::read_dir(at.join("kit")).expect("the kit") {
        let path = entry.expect("an entry").path();
        let content = String::from_utf8_lossy(&fs::read(&path).expect("a file")).into_owned();
        let found = content.chars().find(|c| is_unseen(*c) && *c != '\r');
        assert_eq!(found, None, "{}", path.display());
    }
    told(at, &["assess", "errors.csv"]);
    told(at, &["simulate", "job.toml", "--errors", "-o", "-"]);
}

#[test]
fn of_the_header_of_another_makers_file() {
    let place = start();
    let at = place.path();
    let rtl = format!(
        "HEADER::\nFile type : rtl\nOwner: {FOREIGN}\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\nFlags: 0 1 2 0\n\
         USER-TEXT::\nMachine: {FOREIGN}\nSerial No: {FOREIGN}\nDate: {FOREIGN}\nAxis:X\nTITLE: {FOREIGN}\n\
         RUNS::\nRun-count: 1\nDEVIATIONS::\nRun Target Data:\n1 1 0.5\n1 2 1.5\nEOF::\n"
    );
    fs::write(at.join("x.rtl"), rtl).expect("a file");
    let stated = "--sign as-error --targets-run + --axis x --material-corrected yes";
    let imported = format!("import x.rtl -o - --term EXX --first-target-at-mm 0 {stated}");
    let figures = format!("standards x.rtl --runs unidirectional {stated}");
    for command in [imported, figures] {
        let words: Vec<&str> = command.split(' ').collect();
        let (status, text) = told(at, &words);
        assert_eq!(status, Some(0), "{command}\n{text}");
    }
}

#[test]
fn of_names_of_machines_and_files() {
    let place = start();
    let at = place.path();
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    for name in ["A\\u202EB", "A\\u001BB", "A\\u2028B", "A\\u200BB"] {
        let lines = job.lines().map(|line| match line.starts_with("name = ") {
            true => format!("name = \"{name}\"\n"),
            false => format!("{line}\n"),
        });
        fs::write(at.join("named.toml"), lines.collect::<String>()).expect("a job");
        let (status, text) = told(at, &["generate", "named.toml", "-o", "kit"]);
        assert_eq!(status, Some(2), "{name}\n{text}");
        assert!(text.contains("not seen"), "{text}");
    }
    #[cfg(unix)]
    {
        let odd = format!("{FOREIGN}.toml");
        told(at, &["generate", &odd, "-o", "kit"]);
        fs::rename(at.join("job.toml"), at.join(&odd)).expect("a name");
        told(at, &["generate", &odd, "-o", "kit"]);
    }
}

#[test]
fn no_profile_names_a_file_that_a_laptop_or_shell_takes_for_something_else() {
    let place = start();
    let at = place.path();
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    fs::write(at.join("own.toml"), job.replace("siemens-840d-sl", "./shop.toml")).expect("a job");
    for name in ["CON", "nul.csv", "Com1.MPF", "LPT9", "-rf", "A.", "..", "a/b", "a:b", "a b"] {
        let profile = format!(
            "schema = 1\nid = \"shop\"\nname = \"shop\"\nbased_on = \"generic\"\n[[files]]\nrole = \"table\"\npath = \"{name}\"\ntemplate = \"generic.csv.tera\"\n"
        );
        fs::write(at.join("shop.toml"), profile).expect("a profile");
        let (status, text) = told(at, &["generate", "own.toml", "-o", "kit"]);
        assert_eq!(status, Some(2), "{name}\n{text}");
        assert!(text.contains("is no file name"), "{name}\n{text}");
    }
}

/// Marks that mean something to a page, a drawing, a spreadsheet, a shell or a control.
const MARKS: &str = "A<b>\";(x)&";

/// Names of files and comments with them go nowhere; a machine's name with them is refused or only shown.
#[test]
fn marks_of_others_mean_nothing() {
    for id in builtin::ids() {
        let place = start();
        let at = place.path();
        let read = |name: &str| fs::read_to_string(at.join(name)).expect("a fixture");
        let job = read("job.toml").replace("siemens-840d-sl", id);
        let job = job.replace("# detection_unit_um", "detection_unit_um");
        let (named, table) = (format!("{MARKS}.toml"), format!("{MARKS}.csv"));
        fs::write(at.join(&table), format!("# {MARKS}\n{}", read("errors.csv"))).expect("a table");
        let job = job.replace("\"errors.csv\"", &format!("'{table}'"));
        fs::write(at.join(&named), &job).expect("a job");
        let of_machine = job.lines().map(|line| match line.starts_with("name = ") {
            true => format!("name = '{MARKS}'\n"),
            false => format!("{line}\n"),
        });
        fs::write(at.join("machine.toml"), of_machine.collect::<String>()).expect("a job");
        let plot = ["--plot", "kit.svg"];
        let (status, text) = told(at, &[&["generate", &named, "-o", "kit"][..], &plot].concat());
        assert_ne!(status, Some(2), "{id}: {text}");
        told(at, &["report", &named, "--tables", "kit", "-o", "report.html"]);
        told(at, &["generate", "machine.toml", "-o", "second"]);
        told(at, &["report", "machine.toml", "-o", "machine.html"]);
        harmless(at, id);
    }
}

fn harmless(at: &Path, id: &str) {
    let inside = |folder: &Path| fs::read_dir(folder).into_iter().flatten().collect::<Vec<_>>();
    let places = ["", "kit", "second"].map(|folder| inside(&at.join(folder)));
    for entry in places.into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let is_text_for_people = name.ends_with(".json") || name.ends_with(".md");
        if path.is_dir() || is_text_for_people || name.starts_with('A') || name == "machine.toml" {
            continue;
        }
        let content = String::from_utf8_lossy(&fs::read(&path).expect("a file")).into_owned();
        assert!(!content.contains("<b>"), "{id}: {}", path.display());
        let is_page = name.ends_with(".html") || name.ends_with(".svg");
        assert!(is_page || !content.contains("\";("), "{id}: {}", path.display());
    }
}
