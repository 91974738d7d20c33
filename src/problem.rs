//! A program's failure: what is wrong, where, and what to do next.
//!
//! *Error* means the machine's error in this program; whatever keeps the program from doing its
//! work is a [`Problem`]. All problems of one input are collected and shown together. The text
//! is drawn by `annotate-snippets`, the way rustc shows its own.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;

/// A place in a text file that a user wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// How many characters are meant (at least 1).
    pub width: usize,
    /// The whole line, without its line end.
    pub text: String,
}

impl Place {
    /// The place of the bytes `start..end` of `source`.
    pub fn in_text(file: &str, source: &str, start: usize, end: usize) -> Place {
        let start = floor_boundary(source, start);
        let line_start = source[..start].rfind('\n').map_or(0, |at| at + 1);
        let rest = &source[line_start..];
        let text = rest.split('\n').next().unwrap_or("").trim_end_matches('\r');
        let end = floor_boundary(
            source,
            end.clamp(start, line_start + text.len().max(start - line_start)),
        );
        Place {
            file: file.to_string(),
            line: source[..start].matches('\n').count() + 1,
            column: source[line_start..start].chars().count() + 1,
            width: source[start..end].chars().count().max(1),
            text: text.to_string(),
        }
    }
}

fn floor_boundary(source: &str, at: usize) -> usize {
    let mut at = at.min(source.len());
    while !source.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Why the program could not do its work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// One lower-case sentence: what was found and what was expected.
    pub message: String,
    /// Where, if it came from a file.
    pub place: Option<Place>,
    /// What to do next.
    pub help: Option<String>,
}

impl Problem {
    /// A problem without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Problem {
            message: message.into(),
            place: None,
            help: None,
        }
    }

    /// The same, at a place.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.place = Some(place);
        self
    }

    /// The same, with the next step.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The problem as a person reads it: sentence, place, line with carets, next step.
    pub fn render(&self) -> String {
        let level = Level::ERROR.with_name("problem");
        let mut group = Group::with_title(level.primary_title(clean(&self.message)));
        let source;
        if let Some(place) = &self.place {
            source = clean_line(&place.text);
            let start = byte_of_column(&source, place.column);
            let end = byte_of_column(&source, place.column + place.width).max(start);
            group = group.element(
                Snippet::source(source.as_str())
                    .path(place.file.as_str())
                    .line_start(place.line)
                    .annotation(AnnotationKind::Primary.span(start..end)),
            );
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(clean(help)));
        }
        Renderer::plain().render(&[group])
    }
}

fn byte_of_column(text: &str, column: usize) -> usize {
    text.char_indices()
        .nth(column - 1)
        .map_or(text.len(), |(at, _)| at)
}

/// Control characters of a user's text must not reach the terminal, and a sentence is one line.
fn clean(text: &str) -> String {
    text.chars()
        .flat_map(|c| match c {
            '\n' | '\r' | '\t' => c.escape_default().collect(),
            _ if c.is_control() => vec!['\u{fffd}'],
            _ => vec![c],
        })
        .collect()
}

fn clean_line(text: &str) -> String {
    const LONGEST_LINE_SHOWN: usize = 400;
    text.chars()
        .take(LONGEST_LINE_SHOWN)
        .map(|c| {
            if c == '\t' {
                ' '
            } else if c.is_control() {
                '\u{fffd}'
            } else {
                c
            }
        })
        .collect()
}

/// All problems of an input, in the order they were found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// No problem so far.
    pub fn none() -> Self {
        Problems::default()
    }

    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }

    /// Adds all of another list.
    pub fn extend(&mut self, others: Problems) {
        self.0.extend(others.0);
    }

    /// Keeps the value, or notes the problems and gives nothing.
    pub fn take<T>(&mut self, result: Result<T, Problems>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(problems) => {
                self.extend(problems);
                None
            }
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The problems, one by one.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.0.iter()
    }

    /// `Ok` with the value if there is no problem.
    pub fn or_ok<T>(self, value: T) -> Result<T, Problems> {
        if self.is_empty() {
            Ok(value)
        } else {
            Err(self)
        }
    }

    /// All problems as a person reads them, a blank line between.
    pub fn render(&self) -> String {
        let texts: Vec<String> = self.0.iter().map(Problem::render).collect();
        texts.join("\n\n")
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Problems(vec![problem])
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.render())
    }
}

/// The nearest of `known` to a mistyped word, if one is near.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LIKENESS: f64 = 0.75; // jaro-winkler; below it a suggestion misleads more than it helps
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate))
        .filter(|(likeness, _)| *likeness >= LIKENESS)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}
