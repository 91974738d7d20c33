//! One screen: the verdict, the figures, the worst findings, the next step. Everything else is one
//! option away (`--explain`).

use super::show::paragraphs;
use clap::Args;
use std::io::IsTerminal;

/// Findings on the screen; those that decide the verdict stand under it and are not counted.
const MOST_FINDINGS: usize = 5;
/// Columns of the screen.
const WIDTH: usize = 100;

/// How much is printed.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct Detail {
    /// Print everything: all findings, assumptions and preconditions
    #[arg(short = 'v', long)]
    explain: bool,
    /// Print the verdict only, and a sign that is assumed
    #[arg(short, long, conflicts_with = "explain")]
    quiet: bool,
}

impl Detail {
    /// Whether what was written and the next steps are said.
    pub(super) fn talks(self) -> bool {
        !self.quiet
    }
}

/// What stands elsewhere, and is announced with its count.
pub(super) struct More {
    /// How many.
    pub(super) count: usize,
    /// Of what, e.g. `assumptions`.
    pub(super) what: &'static str,
    /// All of it, for `--explain`.
    pub(super) text: String,
}

/// What a command has to tell.
pub(super) struct Screen {
    /// The answer, and what decided it.
    pub(super) verdict: String,
    /// Tables, in their order.
    pub(super) figures: Vec<String>,
    /// What a person should know, worst first.
    pub(super) findings: Vec<String>,
    /// What never leaves the screen, e.g. a sign that is only assumed.
    pub(super) always: Vec<String>,
    /// Everything else.
    pub(super) more: Vec<More>,
}

impl Screen {
    /// The page.
    pub(super) fn page(&self, detail: Detail) -> String {
        let verdict = wrapped(&self.verdict);
        if detail.quiet {
            let always = self.always.iter().map(|words| wrapped(words));
            return std::iter::once(verdict)
                .chain(always)
                .collect::<Vec<_>>()
                .join("\n");
        }
        let mut parts = vec![verdict];
        parts.extend(self.figures.iter().cloned());
        let shown = match detail.explain {
            true => self.findings.len(),
            false => MOST_FINDINGS,
        };
        let worst = self.findings.iter().take(shown).chain(&self.always);
        let worst: Vec<String> = worst.map(|words| wrapped(words)).collect();
        parts.push(worst.join("\n"));
        match detail.explain {
            true => parts.extend(self.more.iter().map(|more| more.text.clone())),
            false => parts.push(self.announced()),
        }
        paragraphs(&parts)
    }

    /// What is not on the screen, in one line.
    fn announced(&self) -> String {
        let hidden = self.findings.len().saturating_sub(MOST_FINDINGS);
        let findings = (hidden > 0).then(|| format!("{hidden} more findings"));
        let more = self.more.iter().filter(|more| more.count > 0);
        let more = more.map(|more| format!("{} {}", more.count, more.what));
        let all: Vec<String> = findings.into_iter().chain(more).collect();
        match all.is_empty() {
            true => String::new(),
            false => wrapped(&format!("not shown: {} (--explain)", all.join(", "))),
        }
    }
}

/// For a person's screen: lines that are longer, broken at blanks; what follows is indented. Another
/// program gets its lines whole.
pub(super) fn wrapped(text: &str) -> String {
    match std::io::stdout().is_terminal() {
        true => broken_lines(text),
        false => text.to_string(),
    }
}

fn broken_lines(text: &str) -> String {
    let lines: Vec<String> = text.lines().map(broken).collect();
    lines.join("\n")
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

#[cfg(test)]
mod tests {
    use super::{Detail, More, Screen, broken_lines};

    #[test]
    fn long_lines_are_broken_at_blanks_and_lose_nothing() {
        let line = format!("  verdict: {}", "word ".repeat(60).trim_end());
        let page = broken_lines(&line);
        assert!(page.lines().all(|line| line.chars().count() <= 100));
        assert!(
            page.lines()
                .skip(1)
                .all(|line| line.starts_with("    word"))
        );
        let words = |text: &str| text.split_whitespace().count();
        assert_eq!(words(&page), words(&line));
        assert_eq!(broken_lines("a  b\nc"), "a  b\nc");
    }

    #[test]
    fn what_is_not_shown_is_announced_with_its_count() {
        let screen = Screen {
            verdict: "verdict: pass".to_string(),
            figures: vec!["table".to_string()],
            findings: (1..=7).map(|number| format!("finding {number}")).collect(),
            always: vec!["sign assumed".to_string()],
            more: vec![More {
                count: 3,
                what: "assumptions",
                text: "all of them".to_string(),
            }],
        };
        let detail = |explain, quiet| Detail { explain, quiet };
        let page = screen.page(detail(false, false));
        assert!(page.contains("finding 5\nsign assumed") && !page.contains("finding 6"));
        assert!(page.ends_with("not shown: 2 more findings, 3 assumptions (--explain)"));
        let all = screen.page(detail(true, false));
        assert!(all.contains("finding 7\nsign assumed") && all.ends_with("all of them"));
        assert_eq!(
            screen.page(detail(false, true)),
            "verdict: pass\nsign assumed"
        );
    }
}
