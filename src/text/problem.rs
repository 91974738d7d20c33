//! A program's failure: what is wrong, where, and what to do next.
//!
//! *Error* means the machine's error in this program; whatever keeps the program from doing its
//! work is a [`Problem`]. All problems of one input are collected and shown together. The text
//! is drawn by `annotate-snippets`, the way rustc shows its own.

use crate::text::{joined, line as seen};
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use serde::Serialize;
use std::cell::RefCell;
use std::fmt;
use std::sync::OnceLock;

/// A place in a text file that a user wrote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    /// The file as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// How many characters are meant (at least 1).
    pub width: usize,
    /// The line without its line end; of a long line the part around the column.
    #[serde(skip)]
    pub text: String,
    /// How many characters of the line stand before `text`.
    #[serde(skip)]
    pub skipped: usize,
}

/// Longest part of a user's text that is repeated in a sentence, in characters.
const LONGEST_QUOTE: usize = 60;
/// Longest part of a line that is shown, in characters.
const LONGEST_LINE: usize = 200;
/// Longest sentence; a bound for whatever was put into it.
const LONGEST_SENTENCE: usize = 1000;
/// How many different problems of one input are kept; the rest is counted.
const MOST_PROBLEMS: usize = 200;
/// How many problems of one input are looked at; the rest is counted.
const MOST_LOOKED_AT: usize = 2000;
/// Lines that are named where a problem stands in many.
const MOST_LINES: usize = 3;
/// How many problems are shown; the rest is counted.
const MOST_SHOWN: usize = 100;

/// A user's text as it is repeated in a sentence: cut where it is long.
pub fn shown(text: &str) -> String {
    cut(text, LONGEST_QUOTE)
}

fn cut(text: &str, longest: usize) -> String {
    match text.char_indices().nth(longest) {
        None => text.to_string(),
        Some((at, _)) => format!("{}…", &text[..at]),
    }
}

/// The part of a line that is shown of a column, which begins at a byte of it, and how many characters stand before it.
fn window(line: &str, at: usize, column: usize) -> (String, usize) {
    if line.chars().nth(LONGEST_LINE).is_none() {
        return (line.to_string(), 0);
    }
    if column <= LONGEST_LINE / 2 {
        return (cut(line, LONGEST_LINE), 0);
    }
    let shown = LONGEST_LINE / 4; // characters before the column, one of them the sign of what is left out
    let before = line.get(..at).unwrap_or(line);
    let start = before.char_indices().nth_back(shown - 2).map_or(0, |(byte, _)| byte);
    (format!("…{}", cut(&line[start..], LONGEST_LINE)), column - shown - 1)
}

/// Lines of the places of one text: how many line ends stand before each block of bytes, counted once for the whole
/// text when the first place is asked for.
#[derive(Clone, Debug, Default)]
pub struct LineIndex {
    before: OnceLock<Vec<usize>>,
}

/// Bytes of a text in which line ends are counted again for each place.
const INDEX_BLOCK: usize = 1 << 10;

impl LineIndex {
    /// The place of the bytes `start..end` of `source`, which is the same text in every call.
    pub fn place(&self, file: &str, source: &str, start: usize, end: usize) -> Place {
        let start = floor_boundary(source, start);
        let line_start = source[..start].rfind('\n').map_or(0, |at| at + 1);
        // Lines of some controls end with LF CR CR, so the next one begins with what is left.
        let rest = source[line_start..].trim_start_matches('\r');
        let line_start = source.len() - rest.len();
        let start = start.max(line_start);
        let text = rest.split('\n').next().unwrap_or("").trim_end_matches('\r');
        let end = floor_boundary(
            source,
            end.clamp(start, line_start + text.len().max(start - line_start)),
        );
        let column = source[line_start..start].chars().count() + 1;
        let width = source[start..end].chars().count().max(1);
        let (text, skipped) = window(text, start - line_start, column);
        let (file, line) = (file.to_string(), self.line(source.as_bytes(), start));
        Place { file, line, column, width, text, skipped }
    }

    /// The number of the line in which a byte of the text stands.
    fn line(&self, text: &[u8], at: usize) -> usize {
        let ends = |part: &[u8]| part.iter().filter(|byte| **byte == b'\n').count();
        let counted = |before: &mut usize, block| {
            *before += ends(block);
            Some(*before)
        };
        let blocks = || text.chunks(INDEX_BLOCK).scan(0, counted);
        let before = self.before.get_or_init(|| std::iter::once(0).chain(blocks()).collect());
        let block = at / INDEX_BLOCK;
        before[block] + ends(&text[block * INDEX_BLOCK..at]) + 1
    }
}

/// It follows from the text, so two texts that are equal have equal ones.
impl PartialEq for LineIndex {
    fn eq(&self, _: &LineIndex) -> bool {
        true
    }
}

impl Place {
    /// The place of the bytes `start..end` of `source`. For several places in one long text there is
    /// [`LineIndex`].
    pub(crate) fn in_text(file: &str, source: &str, start: usize, end: usize) -> Place {
        LineIndex::default().place(file, source, start, end)
    }
}

fn floor_boundary(source: &str, at: usize) -> usize {
    let mut before = (0..=at.min(source.len())).rev();
    before.find(|at| source.is_char_boundary(*at)).unwrap_or_default()
}

/// Why the program could not do its work.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// One lower-case sentence: what was found and what was expected.
    pub message: String,
    /// Where, if it came from a file.
    pub place: Option<Place>,
    /// Other places of the same file that it concerns.
    pub(crate) also: Vec<Place>,
    /// The column of a table that it stands in, counted from 0.
    #[serde(skip)]
    column: Option<u16>,
    /// What to do next.
    pub help: Option<String>,
    /// The other lines in which the same stands.
    lines: Vec<usize>,
    /// Other words were taken as the same cause: the column is wrong from row to row.
    #[serde(skip)]
    is_shifted: bool,
}

impl Problem {
    /// A problem without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Problem { message: bounded(message.into()), ..Problem::default() }
    }

    /// The same, in a column of a table: in the next rows it is told once.
    #[must_use]
    pub(crate) fn in_column(mut self, index: usize) -> Self {
        self.column = u16::try_from(index).ok();
        self
    }

    /// The same, at a place.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.place = Some(place);
        self
    }

    /// The same, with the next step.
    #[must_use]
    pub(crate) fn help(mut self, help: impl ToString) -> Self {
        self.help = Some(bounded(help.to_string()));
        self
    }

    /// The file of its place.
    fn file(&self) -> Option<&str> {
        self.place.as_ref().map(|place| &*place.file)
    }

    /// The line of its place.
    fn line(&self) -> Option<usize> {
        self.place.as_ref().map(|place| place.line)
    }

    /// The problem as a person reads it: sentence, place, line with carets, next step, and what is to be
    /// known of other places.
    fn render(&self) -> String {
        let level = Level::ERROR.with_name("problem");
        let mut group = Group::with_title(level.primary_title(seen(&self.message)));
        let source;
        if let Some(place) = &self.place {
            source = seen(&place.text);
            let column = place.column.saturating_sub(place.skipped).max(1);
            let start = byte_of_column(&source, column);
            let end = byte_of_column(&source, column + place.width).max(start);
            let mut snippet = Snippet::source(&*source).line_start(place.line);
            if place.skipped == 0 {
                snippet = snippet.path(seen(&place.file));
            } else {
                let origin = Origin::path(seen(&place.file));
                group = group.element(origin.line(place.line).char_column(place.column));
            }
            group = group.element(snippet.annotation(AnnotationKind::Primary.span(start..end)));
        }
        let notes = self.same_in().into_iter().chain(self.also_at());
        group = group.elements(notes.map(|note| Level::NOTE.message(note)));
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(seen(help)));
        }
        Renderer::plain().render(&[group])
    }

    /// The other lines that it concerns, as they are written.
    fn also_at(&self) -> Option<String> {
        let line = |place: &Place| format!("line {}: {}", place.line, seen(place.text.trim()));
        let shown = self.also.iter().take(MOST_SHOWN).map(line);
        let more = self.also.len().saturating_sub(MOST_SHOWN);
        let more = (more > 0).then(|| format!("and in {more} more lines"));
        let lines: Vec<String> = shown.chain(more).collect();
        (!lines.is_empty()).then(|| format!("also\n{}", lines.join("\n")))
    }
}

/// A sentence of any length, cut where nobody reads it to its end.
pub(crate) fn bounded(sentence: String) -> String {
    if sentence.len() <= LONGEST_SENTENCE { sentence } else { cut(&sentence, LONGEST_SENTENCE) }
}

fn byte_of_column(text: &str, column: usize) -> usize {
    text.char_indices().nth(column - 1).map_or(text.len(), |(at, _)| at)
}

// One problem, and where else the same one stands.
impl Problem {
    /// Whether another one has the same cause: the same words in the same file, or it stands in the same column of the
    /// next row, whatever the cell holds.
    fn is_same(&self, other: &Problem) -> bool {
        let last = self.lines.last().copied().or(self.line());
        let is_continued = self.column.is_some()
            && self.column == other.column
            && last.map(|line| line + 1) == other.line();
        (self.file(), &self.help) == (other.file(), &other.help)
            && (self.message == other.message || is_continued)
    }

    /// Takes one with the same cause; in the same line it is the same one.
    fn take(&mut self, other: Problem) {
        for new in other.line().into_iter().chain(other.lines) {
            if Some(new) != self.line() && !self.lines.contains(&new) {
                self.lines.push(new);
            }
        }
        self.is_shifted |= self.message != other.message;
    }

    /// The other lines in which the same stands.
    fn same_in(&self) -> Option<String> {
        let lines = joined(&self.lines[..self.lines.len().min(MOST_LINES)]);
        let note = match self.lines.len() {
            0 => return None,
            1 => format!("the same in line {lines}"),
            2..=MOST_LINES => format!("the same in lines {lines}"),
            more => format!("the same in {more} more lines, the next are {lines}"),
        };
        let look = "; compare the cells of these rows with the header";
        Some(note + if self.is_shifted { look } else { "" })
    }
}

/// The problems of an input, in the order they were found. Those that differ in their place only are
/// one, which counts the places. A long list is cut: what comes after the first hundred is only
/// counted when it is shown.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Problems {
    #[serde(rename = "problems")]
    kept: Vec<Problem>,
    #[serde(skip)]
    looked_at: usize,
    more: usize,
}

impl Problems {
    /// No problem so far.
    pub fn none() -> Self {
        Problems::default()
    }

    /// Adds one.
    pub(crate) fn push(&mut self, problem: Problem) {
        self.push_with(|| problem);
    }

    /// Adds one that is only made if it is going to be looked at.
    pub(crate) fn push_with(&mut self, make: impl FnOnce() -> Problem) {
        if self.looked_at >= MOST_LOOKED_AT {
            self.more += 1;
            return;
        }
        self.add(make());
    }

    fn add(&mut self, new: Problem) {
        self.looked_at += 1;
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.is_same(&new)) {
            kept.take(new);
        } else if self.kept.len() < MOST_PROBLEMS {
            self.kept.push(new);
        } else {
            self.more += 1 + new.lines.len();
        }
    }

    /// Adds all of another list.
    pub(crate) fn extend(&mut self, others: Problems) {
        for other in others.kept {
            self.add(other);
        }
        self.more += others.more;
    }

    /// Keeps the value, or notes the problems and gives nothing.
    pub fn take<T>(&mut self, result: Result<T, impl Into<Problems>>) -> Option<T> {
        result.map_err(|problems| self.extend(problems.into())).ok()
    }

    /// All values, or the problems of all that have none.
    pub(crate) fn all<T, P: Into<Problems>>(
        results: impl Iterator<Item = Result<T, P>>,
    ) -> Result<Vec<T>, Problems> {
        let mut problems = Problems::none();
        let mut values = Vec::with_capacity(results.size_hint().0);
        values.extend(results.filter_map(|result| problems.take(result)));
        problems.or_ok(values)
    }

    /// Whether the next one would only be counted.
    pub(crate) fn is_full(&self) -> bool {
        self.kept.len() >= MOST_PROBLEMS || self.looked_at >= MOST_LOOKED_AT
    }

    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The different problems that were kept, each at its first place.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.kept.iter()
    }

    /// `Ok` with the value if there is no problem.
    pub(crate) fn or_ok<T>(self, value: T) -> Result<T, Problems> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }

    /// All problems as a person reads them, a blank line between.
    pub fn render(&self) -> String {
        let (shown, not_shown) = self.kept.split_at(self.kept.len().min(MOST_SHOWN));
        let mut texts: Vec<String> = shown.iter().map(Problem::render).collect();
        let not_shown: usize = not_shown.iter().map(|kept| 1 + kept.lines.len()).sum();
        match self.more + not_shown {
            0 => {}
            1 => texts.push("… and 1 more problem".to_string()),
            more => texts.push(format!("… and {more} more problems")),
        }
        texts.join("\n\n")
    }
}

/// Problems of an input while it is looked through, each noted where it is met.
#[derive(Debug, Default)]
pub(crate) struct Notes(RefCell<Problems>);

impl Notes {
    /// What is done with all of them so far.
    pub(crate) fn with<T>(&self, act: impl FnOnce(&mut Problems) -> T) -> T {
        act(&mut self.0.borrow_mut())
    }

    /// Notes what is wrong.
    pub(crate) fn refuse(&self, problem: Problem) {
        self.with(|problems| problems.push(problem));
    }

    /// Notes what is wrong, which is only made if it is going to be looked at.
    pub(crate) fn refuse_with(&self, make: impl FnOnce() -> Problem) {
        self.with(|problems| problems.push_with(make));
    }

    /// Notes what is wrong, and gives nothing.
    pub(crate) fn refused<T>(&self, problem: Problem) -> Option<T> {
        self.refuse(problem);
        None
    }

    /// The value, or its problems are noted.
    pub(crate) fn take<T>(&self, result: Result<T, impl Into<Problems>>) -> Option<T> {
        self.with(|problems| problems.take(result))
    }

    /// Whether nothing is wrong so far.
    pub(crate) fn is_sound(&self) -> bool {
        self.0.borrow().is_empty()
    }

    /// Whether the next one would only be counted.
    pub(crate) fn is_full(&self) -> bool {
        self.0.borrow().is_full()
    }

    /// The value, if nothing is wrong; else all problems, which are taken from here.
    pub(crate) fn end<T>(&self, value: T) -> Result<T, Problems> {
        self.0.take().or_ok(value)
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        let mut problems = Problems::none();
        problems.push(problem);
        problems
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.render())
    }
}

/// The next step after a mistyped word: the nearest of `known`, or something else where none is near.
pub(crate) fn did_you_mean<'a>(
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
    otherwise: &str,
) -> String {
    let near = nearest(word, known).map(|near| format!("did you mean `{near}`?"));
    near.unwrap_or_else(|| otherwise.to_string())
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

/// What a room refuses: each kind a function of its facts, with its words and the next step, one a line.
macro_rules! refusals {
    ($($kind:ident($($fact:ident),*) => $words:literal $(, $help:expr)?;)*) => {
        $(pub(crate) fn $kind($($fact: impl std::fmt::Display),*) -> $crate::text::Problem {
            $crate::text::Problem::new(format!($words))$(.help($help))?
        })*
    };
}
pub(crate) use refusals;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_is_counted_and_twins_are_dropped() {
        let mut problems = Problems::none();
        for row in 0..250 {
            problems.push(Problem::new(format!("row {row}")));
            problems.push(Problem::new("row 0"));
        }
        assert_eq!(problems.iter().count(), MOST_PROBLEMS);
        let text = problems.render();
        assert!(text.ends_with("more problems"), "{text}");
        assert_eq!(text.matches("row 0\n").count(), 1);
    }

    #[test]
    fn a_long_line_is_shown_around_its_column() {
        let text = format!("a\r\n{}\r\n", "äb".repeat(150));
        let start = text.find('\n').unwrap_or_default() + 1 + 150 / 2 * 3;
        let place = Place::in_text("r.csv", &text, start, start + 3);
        assert_eq!([place.line, place.column, place.width, place.skipped], [2, 151, 2, 100]);
        let shown: Vec<char> = place.text.chars().collect();
        assert_eq!((shown[0], shown[50], shown[51], shown.len()), ('…', 'ä', 'b', 200));
    }

    #[test]
    fn one_cause_in_many_lines_is_one_message_that_counts() {
        let text = "empty\n".repeat(801);
        let mut problems = Problems::none();
        for line in 0..801 {
            let place = Place::in_text("r.csv", &text, line * 6, line * 6 + 5);
            let problem = Problem::new("`um` is empty").at(place).help("measure it");
            problems.push(problem);
        }
        let mut all = Problems::from(Problem::new("before"));
        all.extend(problems);
        let shown = all.render();
        assert_eq!(shown.matches("`um` is empty").count(), 1, "{shown}");
        assert!(shown.contains("the same in 800 more lines, the next are 2, 3, 4"), "{shown}");
    }

    /// As those of a profile are on their way through the job that names it.
    #[test]
    fn a_problem_that_is_passed_on_keeps_its_other_lines() {
        let mut problems = Problems::none();
        for line in 0..2 {
            let place = Place::in_text("own.toml", "a\na\n", line * 2, line * 2 + 1);
            problems.push(Problem::new("it is wrong").at(place));
        }
        let mut passed = Problems::none();
        problems.iter().for_each(|problem| passed.push(problem.clone()));
        assert!(passed.render().contains("the same in line 2"), "{passed}");
    }

    #[test]
    fn a_long_line_is_cut_around_its_column() {
        let line = format!("{}wrong{}", "ä".repeat(5000), "b".repeat(5000));
        let start = "ä".len() * 5000;
        let place = Place::in_text("table.csv", &line, start, start + 5);
        assert_eq!((place.column, place.width), (5001, 5));
        assert!(place.text.chars().count() <= LONGEST_LINE + 2);
        let text = Problem::new("it is wrong").at(place).render();
        assert!(text.contains("table.csv:1:5001"), "{text}");
        let lines: Vec<&str> = text.lines().collect();
        let carets = lines.iter().position(|line| line.contains('^'));
        let carets = carets.expect("the place is marked");
        let at = |text: &str, what: &str| text.find(what).map(|at| text[..at].chars().count());
        assert_eq!(at(lines[carets], "^^^^^"), at(lines[carets - 1], "wrong"));
    }

    #[test]
    fn a_long_text_is_cut_in_a_sentence() {
        assert_eq!(shown(&"x".repeat(3_000_000)).chars().count(), LONGEST_QUOTE + 1);
        assert_eq!(shown("short"), "short");
        let message = Problem::new("x".repeat(3_000_000)).message;
        assert_eq!(message.chars().count(), LONGEST_SENTENCE + 1);
    }

    #[test]
    fn line_ends_are_counted_once_for_all_places_of_a_text() {
        let text = "ä,1\r\n".repeat(3 * INDEX_BLOCK);
        let index = LineIndex::default();
        for line in [0, 1, 2, INDEX_BLOCK, 2 * INDEX_BLOCK + 1, 3 * INDEX_BLOCK - 1] {
            let start = line * "ä,1\r\n".len() + "ä,".len();
            let place = index.place("a.csv", &text, start, start + 1);
            assert_eq!((place.line, place.column, place.width), (line + 1, 3, 1));
            let counted = index.before.get().map(Vec::len);
            assert_eq!(counted, Some(text.len().div_ceil(INDEX_BLOCK) + 1));
        }
        let end = index.place("a.csv", &text, text.len(), text.len() + 1);
        assert_eq!((end.line, end.column), (3 * INDEX_BLOCK + 1, 1));
    }
}
