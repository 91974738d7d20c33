//! What people see: one screen with the verdict, the figures, the worst findings and the next step;
//! everything else is one option away (`--explain`). Tables, lists, and paths as a shell reads them.

use crate::text::{counted, plain};
use crate::visit::files::printed;
use clap::Args;
use std::io::IsTerminal;
#[cfg(feature = "disk")]
use std::io::Write;
use std::path::Path;

/// Findings on the screen; those that decide the verdict stand under it and are not counted.
const MOST_FINDINGS: usize = 5;
/// Columns of the screen.
const WIDTH: usize = 100;

/// How much is printed.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct Detail {
    /// Print everything: all findings, tables and assumptions
    #[arg(short = 'v', long)]
    explain: bool,
    /// Print the verdict only, and what is assumed and has to be decided or proved
    #[arg(short, long, conflicts_with = "explain")]
    pub(super) quiet: bool,
}

/// What stands elsewhere, and is announced.
pub(super) struct More {
    /// In words; empty where there is none.
    what: String,
    text: String,
}

impl More {
    /// So many of something, e.g. one `assumption` or several `assumptions`, and all of it for `--explain`.
    pub(super) fn new(count: usize, [one, several]: [&str; 2], text: String) -> More {
        let what = match count {
            0 => String::new(),
            1 => format!("1 {one}"),
            many => format!("{many} {several}"),
        };
        More { what, text }
    }

    /// A part of the page that nobody counts, e.g. `closure`; empty where there is none.
    pub(super) fn part(what: &str, text: impl Into<Option<String>>) -> More {
        let text = text.into().unwrap_or_default();
        More { what: if text.is_empty() { String::new() } else { what.to_string() }, text }
    }
}

/// What a command has to tell.
#[derive(Default)]
pub(super) struct Screen {
    /// The answer, and what decided it.
    pub(super) verdict: String,
    /// Tables, in their order.
    pub(super) figures: String,
    /// What a person should know, worst first.
    pub(super) findings: Vec<String>,
    /// What never leaves the screen, e.g. a sign that is only assumed.
    pub(super) always: Vec<String>,
    /// Everything else.
    pub(super) more: Vec<More>,
}

impl Screen {
    /// A verdict alone.
    pub(super) fn of(verdict: String) -> Screen {
        Screen { verdict, ..Screen::default() }
    }

    /// The page.
    pub(super) fn page(&self, detail: Detail) -> String {
        let verdict = wrapped(&self.verdict);
        if detail.quiet {
            let always = self.always.iter().map(|words| wrapped(words));
            return std::iter::once(verdict).chain(always).collect::<Vec<_>>().join("\n");
        }
        let mut parts = vec![verdict, self.figures.clone()];
        let shown = if detail.explain { self.findings.len() } else { MOST_FINDINGS };
        let worst = self.findings.iter().take(shown).chain(&self.always);
        parts.push(worst.map(|words| wrapped(words)).collect::<Vec<_>>().join("\n"));
        match detail.explain {
            true => parts.extend(self.more.iter().map(|more| more.text.clone())),
            false => parts.push(self.announced()),
        }
        paragraphs(&parts)
    }

    /// What is not on the screen, in one line.
    fn announced(&self) -> String {
        let hidden = self.findings.len().saturating_sub(MOST_FINDINGS);
        let findings = (hidden > 0).then(|| counted(hidden, "more finding"));
        let more = self.more.iter().map(|more| more.what.clone()).filter(|what| !what.is_empty());
        let all: Vec<String> = findings.into_iter().chain(more).collect();
        match all.is_empty() {
            true => String::new(),
            false => wrapped(&format!("not shown: {} (--explain)", all.join(", "))),
        }
    }
}

/// Talk, as it goes to standard error.
pub(super) fn spoken(text: &str) -> String {
    format!("{}\n", plain::page(text.trim_end()))
}

/// Says it at once, to a person who looks on.
#[cfg(feature = "disk")]
pub(super) fn say(text: &str) {
    tell(&spoken(text));
}

/// Words as they are.
#[cfg(feature = "disk")]
pub(super) fn tell(text: &str) {
    // Nothing can be said about a standard error that is closed.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Paragraphs with a blank line between; empty ones are left out.
pub(super) fn paragraphs(parts: &[String]) -> String {
    let parts: Vec<&str> =
        parts.iter().map(String::as_str).filter(|part| !part.is_empty()).collect();
    parts.join("\n\n")
}

/// A table without lines. Heading and rows have a tab between their cells; a column whose heading
/// begins with `>` stands right.
pub(super) fn table(heading: &str, rows: impl IntoIterator<Item = String>) -> String {
    let is_right: Vec<bool> = heading.split('\t').map(|name| name.starts_with('>')).collect();
    let lines: Vec<String> = std::iter::once(heading.replace('>', "")).chain(rows).collect();
    let width = |column| {
        let cells = lines.iter().filter_map(|line| line.split('\t').nth(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..is_right.len()).map(width).collect();
    let aligned = |line: &String| {
        let cells = line.split('\t').zip(widths.iter().zip(&is_right));
        let cells = cells.map(|(cell, (width, is_right))| match is_right {
            true => format!("{cell:>width$}"),
            false => format!("{cell:<width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    lines.iter().map(aligned).collect::<Vec<_>>().join("\n")
}

/// A heading with lines; nothing without any.
pub(super) fn headed(heading: &str, lines: impl Iterator<Item = String>) -> String {
    let lines: String = lines.map(|line| format!("\n{line}")).collect();
    if lines.is_empty() { lines } else { format!("{heading}{lines}") }
}

/// A heading with a line for each entry; nothing without entries.
pub(super) fn list(heading: &str, entries: &[impl std::fmt::Display]) -> String {
    headed(heading, entries.iter().map(|entry| format!("  - {entry}")))
}

/// For a person's screen: lines that are longer, broken at blanks; what follows is indented. Another
/// program gets its lines whole.
pub(super) fn wrapped(text: &str) -> String {
    if std::io::stdout().is_terminal() { broken_lines(text) } else { text.to_string() }
}

fn broken_lines(text: &str) -> String {
    text.lines().map(broken).collect::<Vec<_>>().join("\n")
}

fn broken(line: &str) -> String {
    let indent = " ".repeat(2 + line.len() - line.trim_start().len());
    let mut written = String::new();
    let mut column = 0;
    for (number, word) in line.split(' ').enumerate() {
        let length = word.chars().count();
        if number > 0 && column + 1 + length > WIDTH && column > indent.len() {
            written.push('\n');
            written.push_str(&indent);
            column = indent.len();
        } else if number > 0 {
            written.push(' ');
            column += 1;
        }
        written.push_str(word);
        column += length;
    }
    written
}

/// A path as one word of a command: quoted where the shell of this computer needs it.
pub(super) fn shell_word(path: &Path) -> String {
    match path.to_str() {
        Some(word) if word.starts_with('-') => shell_word(&Path::new(".").join(path)), // no option
        None => format!("$'{}'", path.as_os_str().as_encoded_bytes().escape_ascii()),
        Some(_) if cfg!(windows) => cmd_word(&printed(path)),
        Some(word) => posix_word(word),
    }
}

/// Letters of file names that no shell reads as anything else.
fn is_plain(c: char) -> bool {
    c.is_alphanumeric() || "_-./:+@".contains(c)
}

/// Double quotes where they are enough, so that a blank looks the same everywhere; else single ones.
fn posix_word(word: &str) -> String {
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_string()
    } else if word.contains(['"', '$', '`', '\\', '!']) {
        format!("'{}'", word.replace('\'', r"'\''"))
    } else {
        format!("\"{word}\"")
    }
}

/// A name of Windows holds no `"`; a backslash before the closing mark would take it away.
fn cmd_word(word: &str) -> String {
    if !word.is_empty() && word.chars().all(|c| is_plain(c) || c == '\\') {
        return word.to_string();
    }
    let end = if word.ends_with('\\') { "\\" } else { "" };
    format!("\"{word}{end}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_at_blanks_and_lose_nothing() {
        let line = format!("  verdict: {}", "word ".repeat(60).trim_end());
        let page = broken_lines(&line);
        assert!(page.lines().all(|line| line.chars().count() <= 100));
        assert!(page.lines().skip(1).all(|line| line.starts_with("    word")));
        let words = |text: &str| text.split_whitespace().count();
        assert_eq!(words(&page), words(&line));
        assert_eq!(broken_lines("a  b\nc"), "a  b\nc");
    }

    #[test]
    fn what_is_not_shown_is_announced_with_its_count() {
        let screen = Screen {
            verdict: "verdict: pass".to_string(),
            figures: "table".to_string(),
            findings: (1..=7).map(|number| format!("finding {number}")).collect(),
            always: vec!["sign assumed".to_string()],
            more: vec![More::new(3, ["assumption", "assumptions"], "all of them".to_string())],
        };
        let detail = |explain, quiet| Detail { explain, quiet };
        let page = screen.page(detail(false, false));
        assert!(page.contains("finding 5\nsign assumed") && !page.contains("finding 6"));
        assert!(page.ends_with("not shown: 2 more findings, 3 assumptions (--explain)"));
        let all = screen.page(detail(true, false));
        assert!(all.contains("finding 7\nsign assumed") && all.ends_with("all of them"));
        assert_eq!(screen.page(detail(false, true)), "verdict: pass\nsign assumed");
    }

    #[test]
    fn paths_are_one_word_in_a_shell() {
        for (path, expected) in [
            ("kit/job.toml", "kit/job.toml"),
            ("Fräse/job.toml", "Fräse/job.toml"),
            ("my kit", "\"my kit\""),
            ("it's", "\"it's\""),
            ("a$b 'c'", r"'a$b '\''c'\'''"),
            ("a;rm (1)&", "\"a;rm (1)&\""),
            ("~x", "\"~x\""),
            ("", "\"\""),
        ] {
            assert_eq!(posix_word(path), expected);
        }
    }

    #[test]
    fn paths_are_one_word_in_the_windows_command_line() {
        for (path, expected) in [
            (r"C:\kit\job.toml", r"C:\kit\job.toml"),
            (r"C:\my kit\", r#""C:\my kit\\""#),
            ("a&b", "\"a&b\""),
            ("a,b", "\"a,b\""),
        ] {
            assert_eq!(cmd_word(path), expected);
        }
    }

    #[test]
    fn cells_stand_below_their_headings() {
        let rows = ["EXX\t1.5".to_string(), "diagonal\t-10.25".to_string()];
        let page = "term      after/µm\nEXX            1.5\ndiagonal    -10.25";
        assert_eq!(table("term\t>after/µm", rows), page);
    }
}
