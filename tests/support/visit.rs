//! A visit in a folder of its own: its inputs, the program run there, what was printed and written.

use super::tree::{Entry, Tree, difference, lay, tree};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

pub(crate) fn fixtures(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
}

/// A path of the measured data beside the repository; `None`, told in one line, where they are not there.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let path = fixtures("../../shared/data").join(name);
    let is_here = path.exists();
    if !is_here {
        super::tree::skipped("../shared is not here");
    }
    is_here.then_some(path)
}

pub(crate) fn fixture(name: &str) -> String {
    fs::read_to_string(fixtures(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The text of a page of the repository, e.g. `docs/interface.md`.
pub(crate) fn page(name: &str) -> String {
    fixture(&format!("../{name}")).replace('\r', "")
}

/// The fenced block of a page behind words that stand in it, without its indent.
#[track_caller]
pub(crate) fn block_behind(page: &str, words: &str) -> String {
    let (_, rest) = page.split_once(words).unwrap_or_else(|| panic!("no page has `{words}`"));
    let mut lines = rest.lines().skip_while(|line| !line.trim_start().starts_with("```"));
    let (indent, _) = lines.next().and_then(|fence| fence.split_once("```")).expect("a fence");
    let lines = lines.take_while(|line| line.trim() != "```");
    lines.map(|line| format!("{}\n", line.strip_prefix(indent).unwrap_or(line))).collect()
}

/// A text with every `old` replaced; there is one at least.
pub(crate) fn replaced(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "`{old}` is not in\n{text}");
    text.replace(old, new)
}

/// The program; `NONIUS_PROGRAM` names another one (packaging/wine-tests: that of Windows).
pub(crate) fn nonius() -> String {
    std::env::var("NONIUS_PROGRAM").unwrap_or_else(|_| env!("CARGO_BIN_EXE_nonius").to_string())
}

pub(crate) fn is_of_windows() -> bool {
    cfg!(windows) || nonius().contains("/.wine/")
}

/// The program with arguments separated by blanks (those in "…" are kept), nothing on standard input.
pub(crate) fn program(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(nonius());
    for (index, part) in arguments.split('"').enumerate() {
        match index % 2 {
            0 => command.args(part.split_whitespace()),
            _ => command.arg(part),
        };
    }
    command.current_dir(folder).stdin(Stdio::null());
    command
}

pub(crate) struct Ran {
    pub(crate) command: String,
    pub(crate) status: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    pub(crate) fn of(command: &str, output: &Output) -> Ran {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace('\r', "");
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        Ran { command: command.to_string(), status: output.status.code(), out, err }
    }

    /// Standard output, then standard error.
    pub(crate) fn all(&self) -> String {
        format!("{}{}", self.out, self.err)
    }

    /// Ended with this status.
    #[track_caller]
    pub(crate) fn ends(self, status: i32) -> Ran {
        assert_eq!(self.status, Some(status), "nonius {}\n{}", self.command, self.all());
        self
    }

    /// Did what was asked for: the answer is yes or no.
    #[track_caller]
    pub(crate) fn answers(self) -> Ran {
        assert!(matches!(self.status, Some(0 | 1)), "nonius {}\n{}", self.command, self.all());
        self
    }

    #[track_caller]
    pub(crate) fn says(self, words: &str) -> Ran {
        let all = self.all();
        assert!(all.contains(words), "nonius {}: expected `{words}` in\n{all}", self.command);
        self
    }

    #[track_caller]
    pub(crate) fn tells(self, words: &[&str]) -> Ran {
        words.iter().fold(self, |ran, words| ran.says(words))
    }

    #[track_caller]
    pub(crate) fn omits(self, words: &str) -> Ran {
        let all = self.all();
        assert!(!all.contains(words), "nonius {}: unexpected `{words}` in\n{all}", self.command);
        self
    }

    /// Standard output as JSON.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        let read = serde_json::from_str(&self.out);
        read.unwrap_or_else(|e| panic!("nonius {}: {e}\n{}", self.command, self.all()))
    }
}

/// Runs the program in the folder of the repository.
pub(crate) fn in_repository(command: &str) -> Ran {
    Ran::of(command, &program(&fixtures(".."), command).output().expect("the program starts"))
}

#[track_caller]
pub(crate) fn is_shown(page: &str, words: &str, printed: &str) {
    let shown = block_behind(page, words);
    let is_shown = !shown.is_empty() && printed.contains(shown.trim());
    assert!(is_shown, "the page shows\n{shown}\nthe program prints\n{printed}");
}

/// Whether another program ran and ended with 0; what it complains of is not shown.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command.stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// A folder that is removed at the end, with the inputs of a visit.
pub(crate) struct Visit(TempDir);

impl Visit {
    pub(crate) fn new() -> Visit {
        Visit(tempfile::tempdir().expect("a temporary folder can be made"))
    }

    /// A copy of a folder of the fixtures.
    pub(crate) fn of(fixture: &str) -> Visit {
        let visit = Visit::new();
        lay(&tree(&fixtures(fixture)), visit.folder());
        visit
    }

    /// A job of the fixtures as `job.toml`, e.g. `nine_errors_900/generic.toml`, with the error table beside it.
    pub(crate) fn with_job(job: &str) -> Visit {
        let (folder, _) = job.rsplit_once('/').expect("a folder and a job");
        Visit::with(fixture(job), fixture(&format!("{folder}/errors.csv")))
    }

    pub(crate) fn with(job: impl AsRef<[u8]>, errors: impl AsRef<[u8]>) -> Visit {
        let visit = Visit::new();
        visit.put("job.toml", job).put("errors.csv", errors);
        visit
    }

    /// With a kit that keeps the acceptance.
    #[track_caller]
    pub(crate) fn with_kit(self) -> Visit {
        self.yes("generate job.toml -o kit");
        self
    }

    /// With a kit, whether it keeps the acceptance or not.
    #[track_caller]
    pub(crate) fn with_any_kit(self) -> Visit {
        self.run("generate job.toml -o kit").answers();
        self
    }

    /// The folder, or what lies in it by that name.
    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, and the folders above it.
    pub(crate) fn put(&self, name: &str, text: impl AsRef<[u8]>) -> &Visit {
        let path = self.at(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
        fs::write(path, text).unwrap_or_else(|e| panic!("{name}: {e}"));
        self
    }

    /// Replaces every `old` in a file; there is one at least.
    #[track_caller]
    pub(crate) fn edit(&self, name: &str, old: &str, new: &str) -> &Visit {
        self.put(name, replaced(&self.read(name), old, new))
    }

    /// Puts lines at the beginning of a section of the job, e.g. `[compensation]`.
    #[track_caller]
    pub(crate) fn under(&self, section: &str, lines: &str) -> &Visit {
        self.edit("job.toml", &format!("{section}\n"), &format!("{section}\n{lines}\n"))
    }

    /// Runs a command with every `old` of a file replaced, which is put back.
    #[track_caller]
    pub(crate) fn run_with(&self, name: &str, old: &str, new: &str, command: &str) -> Ran {
        let good = self.read(name);
        let ran = self.edit(name, old, new).run(command);
        self.put(name, good);
        ran
    }

    #[track_caller]
    pub(crate) fn append(&self, name: &str, text: &str) -> &Visit {
        self.put(name, self.read(name) + text)
    }

    /// Gives every row of an error table one more column, or several.
    pub(crate) fn with_column(&self, table: &str, name: &str, value: &str) {
        let text = self.read(table);
        let rows = text.lines().map(|line| match line.as_bytes()[0] {
            b'#' => format!("{line}\n"),
            b'a' => format!("{line}{name}\n"),
            _ => format!("{line}{value}\n"),
        });
        self.put(table, rows.collect::<String>());
    }

    pub(crate) fn copy(&self, from: &str, name: &str) -> &Visit {
        self.put(name, fs::read(fixtures(from)).unwrap_or_else(|e| panic!("{from}: {e}")))
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.at(name).exists()
    }

    #[track_caller]
    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    #[track_caller]
    pub(crate) fn document(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of what lies in the folder itself, in their order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder()).expect("a folder");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> =
            names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub(crate) fn files(&self) -> Tree {
        tree(self.folder())
    }

    /// The text of each file that lies in the folder, with its name.
    pub(crate) fn texts(&self) -> Vec<(String, String)> {
        let text = |(name, entry)| match entry {
            Entry::File(bytes) => Some((name, String::from_utf8_lossy(&bytes).into_owned())),
            _ => None,
        };
        self.files().into_iter().filter_map(text).collect()
    }

    /// What may be done with a file or directory, as `chmod` takes it.
    #[cfg(unix)]
    pub(crate) fn mode(&self, name: &str) -> u32 {
        let found = fs::metadata(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        std::os::unix::fs::PermissionsExt::mode(&found.permissions()) & 0o7777
    }

    #[cfg(unix)]
    pub(crate) fn set_mode(&self, name: &str, mode: u32) {
        let mode = std::os::unix::fs::PermissionsExt::from_mode(mode);
        fs::set_permissions(self.at(name), mode).unwrap_or_else(|e| panic!("{name}: {e}"));
    }

    /// Runs a command in the folder, e.g. `generate job.toml -o kit`.
    pub(crate) fn run(&self, command: &str) -> Ran {
        let output = program(self.folder(), command).output().expect("the program starts");
        Ran::of(command, &output)
    }

    /// Runs a line of a shell that is refused and changes nothing; `$N` is the program.
    #[track_caller]
    pub(crate) fn refuses(&self, line: &str) -> Ran {
        let before = self.files();
        let ran = self.shell(line).ends(2);
        assert_eq!(difference(&before, &self.files()), "", "{line}");
        ran
    }

    /// Runs a line of a shell in the folder; `$N` is the program.
    pub(crate) fn shell(&self, line: &str) -> Ran {
        Ran::of(line, &self.by_shell(line).output().expect("a shell"))
    }

    pub(crate) fn by_shell(&self, line: &str) -> Command {
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).env("N", nonius()).current_dir(self.folder());
        shell
    }

    /// Runs a command that has to end with 0; standard output.
    #[track_caller]
    pub(crate) fn yes(&self, command: &str) -> String {
        self.run(command).ends(0).out
    }

    /// Runs a command that answers yes or no, with `--format json`; the document.
    #[track_caller]
    pub(crate) fn json(&self, command: &str) -> Value {
        self.run(&format!("{command} --format json")).answers().json()
    }
}

pub(crate) fn golden_case(name: &str) -> Visit {
    Visit::of(&format!("diagonals/{name}"))
}

/// A job without what stands from the beginning of a table up to `[compensation]`.
#[track_caller]
pub(crate) fn without(job: &str, table: &str) -> String {
    let (before, rest) = job.split_once(table).expect(table);
    let (_, after) = rest.split_once("[compensation]").expect("a control");
    format!("{before}[compensation]{after}")
}

pub(crate) fn cells(row: &str) -> Vec<&str> {
    row.split(',').collect()
}

/// The lines of a table with their cells changed; without those of which `change` says no.
pub(crate) fn with_cells(text: &str, mut change: impl FnMut(&mut [String]) -> bool) -> String {
    let changed = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        change(&mut cells).then(|| cells.join(",") + "\n")
    };
    text.lines().filter_map(changed).collect()
}

/// Words among the `labels` of a document.
#[track_caller]
pub(crate) fn labelled(document: &Value, words: &[&str]) {
    holds(&document["labels"].to_string(), words);
}

/// A profile of one's own, built on another one, with more of its keys.
pub(crate) fn own_profile(base: &str, keys: &str) -> String {
    format!("schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"{base}\"\n{keys}")
}

#[track_caller]
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The last digit that documents hold.
pub(crate) const LAST_DIGIT: f64 = 1.001e-6;

#[track_caller]
pub(crate) fn holds(text: &str, words: &[&str]) {
    for words in words {
        assert!(text.contains(words), "expected `{words}` in\n{text}");
    }
}

#[track_caller]
pub(crate) fn lacks(text: &str, words: &[&str]) {
    let found = words.iter().find(|word| text.contains(**word));
    assert_eq!(found, None, "stands in\n{text}");
}

#[track_caller]
pub(crate) fn near(what: &str, got: f64, want: f64, room: f64) {
    assert!((got - want).abs() <= room, "{what}: {got}, expected {want}");
}
