//! Sections of a Renishaw file: `NAME::`, lines, `EOF::`.

use crate::inputs::import::lines::{Line, Word, lines};
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};
use std::collections::BTreeSet;

/// More runs or targets than this are a damaged file.
pub(super) const MOST: usize = 10_000;
pub(super) const AGAIN: &str = "the file is incomplete or damaged: save it again";
/// Keys that the numbers depend on, as [`Line::key_value`] writes them.
const SINGLE_KEYS: [(&str, &[&str]); 3] = [
    ("HEADER", &["filetype"]),
    ("TARGET DATA", &["targetcount", "targets", "flags"]),
    ("RUNS", &["runcount"]),
];

/// Lines of each section, by its name in capital letters.
pub(super) struct Sections<'a> {
    pub(super) source: &'a Source,
    found: Vec<(String, Vec<Line<'a>>)>,
}

impl<'a> Sections<'a> {
    pub(super) fn of(source: &'a Source) -> Result<Self, Problems> {
        let mut found: Vec<(String, Vec<Line<'a>>)> = Vec::new();
        let mut problems = Problems::none();
        let mut names = BTreeSet::new();
        let mut is_over = false;
        for line in lines(source) {
            // Some editors end a text with the control character 26.
            if is_over && !line.text.trim_matches('\u{1a}').trim().is_empty() {
                problems.push(behind_end(&line));
                is_over = false; // told once
            }
            if let Some(name) = line.text.trim().strip_suffix("::") {
                let name = name.trim().to_uppercase();
                is_over |= name == "EOF";
                if !names.insert(name.clone()) {
                    problems.push_with(|| twice(&format!("section `{}::`", shown(&name)), &line));
                }
                found.push((name, Vec::new()));
            } else if let Some((_, lines)) = found.last_mut() {
                lines.push(line);
            }
        }
        if found.is_empty() {
            return Err(Problem::new(
                "there is no section such as `HEADER::`, expected a file of the format `rtl`",
            )
            .at(source.place(&(0..0)))
            .help("take the file as it was saved, or leave `--from` out")
            .into());
        }
        let sections = Sections { source, found };
        sections.refuse_double_keys(&mut problems);
        for needed in ["TARGET DATA", "RUNS", "DEVIATIONS", "EOF"] {
            if sections.lines(needed).is_none() {
                problems.push(sections.absent(&format!("there is no section `{needed}::`")));
            }
        }
        problems.or_ok(sections)
    }

    pub(super) fn lines(&self, section: &str) -> Option<&[Line<'a>]> {
        let found = self.found.iter().find(|(name, _)| name == section);
        found.map(|(_, lines)| lines.as_slice())
    }

    pub(super) fn value(&self, section: &str, key: &str) -> Option<Word<'a>> {
        let mut pairs = self.lines(section)?.iter().filter_map(Line::key_value);
        pairs.find_map(|(found, value)| (found == key).then_some(value))
    }

    /// A key that stands twice may have two values; those of texts are of no account.
    fn refuse_double_keys(&self, problems: &mut Problems) {
        for (section, keys) in SINGLE_KEYS {
            for key in keys {
                let lines = self.lines(section).unwrap_or_default().iter();
                let mut found =
                    lines.filter(|line| line.key_value().is_some_and(|(other, _)| other == *key));
                if let (Some(_), Some(second)) = (found.next(), found.next()) {
                    let label = second.text.split(':').next().unwrap_or_default().trim();
                    problems.push(twice(&format!("`{}`", shown(label)), second));
                }
            }
        }
    }

    /// The place of the first line of a section whose key begins so; else the start of the file.
    pub(super) fn place_of(&self, section: &str, begins: &str) -> Place {
        let lines = self.lines(section).unwrap_or_default().iter();
        let mut found = lines.filter(|line| {
            line.key_value()
                .is_some_and(|(key, _)| key.starts_with(begins))
        });
        let place = found.next().map(Line::place);
        place.unwrap_or_else(|| self.source.place(&(0..0)))
    }

    /// A problem at the end of the file, where something is missing.
    pub(super) fn absent(&self, message: &str) -> Problem {
        let end = self.source.text.trim_end().len();
        let start = self.source.text[..end].rfind('\n').map_or(0, |at| at + 1);
        Problem::new(message)
            .at(self.source.place(&(start..end)))
            .help(AGAIN)
    }

    pub(super) fn count(
        &self,
        section: &str,
        key: &str,
        label: &str,
        problems: &mut Problems,
    ) -> Option<usize> {
        let Some(value) = self.value(section, key) else {
            problems.push(self.absent(&format!("there is no `{label}` in section `{section}::`")));
            return None;
        };
        let count = value.count(&format!("`{label}`"), problems)?;
        if count > MOST {
            problems.push(
                Problem::new(format!("`{label}` is {count}, expected at most {MOST}"))
                    .at(value.place())
                    .help(AGAIN),
            );
            return None;
        }
        Some(count)
    }
}

fn twice(what: &str, line: &Line<'_>) -> Problem {
    Problem::new(format!("{what} stands twice"))
        .at(line.place())
        .help("which of the two holds is not known: save the file again")
}

/// Nothing stands behind `EOF::`; two files may have been put together.
fn behind_end(line: &Line<'_>) -> Problem {
    Problem::new("there is text behind `EOF::`")
        .at(line.place())
        .help("take one file at a time, as it was saved")
}
