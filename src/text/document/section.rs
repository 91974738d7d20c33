//! One section of a page, read key by key.

use crate::text::{Notes, Problem, Problems, did_you_mean, nearest, once, refusals, shown};

use super::{LARGEST_NUMBER, LONGEST_MM, Source};
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Room for the keys that a section is asked for, so that it grows only for large ones.
const USUAL_KEYS: usize = 16;

/// A table of the page, e.g. `[machine.axes.x]`.
pub struct Section<'a> {
    source: &'a Source,
    table: &'a DeTable<'a>,
    span: Range<usize>,
    path: String,
    asked: RefCell<Vec<&'a str>>,
    noted: &'a Noted,
}

/// Endings of keys that are units of length.
const LENGTHS: [&str; 4] = ["um", "mm", "inch", "in"];

impl<'a> Section<'a> {
    /// The page itself.
    pub(super) fn root(source: &'a Source, table: &'a DeTable<'a>, noted: &'a Noted) -> Self {
        Section {
            source,
            table,
            span: 0..0,
            path: String::new(),
            asked: RefCell::new(Vec::with_capacity(USUAL_KEYS)),
            noted,
        }
    }

    /// Dotted path of the section, empty for the root.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Dotted path of a key of this section.
    pub(crate) fn path_of(&self, key: &str) -> String {
        joined(&self.path, key)
    }

    /// Notes a problem at a key (or at the section, if the key is absent).
    pub fn problem(&self, key: &str, message: impl Into<String>, help: impl ToString) {
        self.refuse(key, Problem::new(message).help(help));
    }

    /// The same of a problem that is made already.
    pub(crate) fn refuse(&self, key: &str, problem: Problem) {
        let span = self.table.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        self.note(|| problem.at(self.source.place(&span)));
    }

    /// The same at an entry of a list.
    pub(crate) fn problem_in(&self, key: &str, index: usize, message: String, help: &str) {
        let list = self.table.get(key).and_then(|list| list.get_ref().as_array());
        let span = list.and_then(|list| list.get(index)).map_or(self.span.clone(), Spanned::span);
        self.note(|| Problem::new(message).at(self.source.place(&span)).help(help));
    }

    /// Notes problems of a file that the page names.
    pub(crate) fn note_all(&self, problems: Problems) {
        self.noted.problems.with(|all| all.extend(problems));
    }

    fn note(&self, make: impl FnOnce() -> Problem) {
        self.noted.problems.refuse_with(make);
    }

    /// The value of a key; of one that is to be filled in there is none.
    fn value(&self, key: &'static str) -> Option<&'a DeValue<'a>> {
        self.asked.borrow_mut().push(key);
        self.table.get(key).map(Spanned::get_ref).filter(|value| !is_empty(value))
    }

    fn unexpected(&self, key: &str, found: &str, expected: &str) {
        self.refuse(key, refusals::unexpected(self.path_of(key), found, expected, key));
    }

    /// Whether the key is present (it then counts as known).
    pub fn has(&self, key: &'static str) -> bool {
        self.value(key).is_some() || self.table.contains_key(key)
    }

    /// Whether it stands for one that is not there.
    pub(super) fn is_absent(&self) -> bool {
        std::ptr::eq(self.table, &raw const self.noted.nothing)
    }

    /// Where its keys stand, in words.
    pub(super) fn within(&self) -> String {
        if self.path.is_empty() { String::new() } else { format!(" in [{}]", self.path) }
    }

    /// A sub-section that must be there.
    pub(crate) fn required_section(&self, key: &'static str) -> Option<Section<'a>> {
        if !self.has(key) && !self.is_absent() {
            let name = self.path_of(key);
            let end = self.source.text.trim_end().len();
            let span = if self.path.is_empty() { end..end } else { self.span.clone() };
            self.note(|| refusals::no_section(name).at(self.source.place(&span)));
        }
        self.section(key)
    }

    /// Where the value of a key begins in the text of the page.
    pub(crate) fn begins_at(&self, key: &str) -> Option<usize> {
        Some(self.table.get(key)?.span().start)
    }

    /// Whether the key holds a section (it then counts as known).
    pub(crate) fn is_section(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(DeValue::is_table)
    }

    /// Whether the key holds a list (it then counts as known).
    pub(crate) fn is_list(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(DeValue::is_array)
    }

    /// The same as a message shows it.
    pub(super) fn written(&self, key: &str) -> String {
        shown(self.as_written(key).unwrap_or_default())
    }

    /// The value of a key as it is written in the page.
    pub(crate) fn as_written(&self, key: &str) -> Option<&'a str> {
        let span = self.table.get(key)?.span();
        self.source.text.get(span)
    }

    /// The value of a key, if it is present and `read` can make something of it.
    fn typed<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&'a DeValue<'a>) -> Option<T>,
    ) -> Option<T> {
        let written = self.value(key)?;
        let value = read(written);
        if value.is_none() {
            let found = match written {
                DeValue::Array(_) => "a list".to_string(),
                DeValue::Table(_) => "a section".to_string(),
                _ => format!("`{}`", self.written(key)),
            };
            self.unexpected(key, &found, expected);
        }
        value
    }

    /// A text, if the key is present.
    pub fn text(&self, key: &'static str) -> Option<String> {
        self.typed(key, "a text in quotes", text_of)
    }

    /// A text that must be there.
    pub(crate) fn required_text(&self, key: &'static str, expected: &str) -> Option<String> {
        self.require(key, expected);
        self.text(key)
    }

    /// A finite number, if the key is present.
    pub fn number(&self, key: &'static str) -> Option<f64> {
        let number = self.typed(key, "a finite number", number_of)?;
        self.sized(key, number, number.abs() <= LARGEST_NUMBER)
    }

    /// A position or length in mm, no longer than any machine, if the key is present.
    pub fn millimetres(&self, key: &'static str) -> Option<f64> {
        let number = self.number(key)?;
        self.sized(key, number, number.abs() <= LONGEST_MM)
    }

    /// A number of at least zero, if the key is present.
    pub(crate) fn not_negative(&self, key: &'static str) -> Option<f64> {
        self.signed(key, "a number of at least 0", |number| number >= 0.0)
    }

    /// A number greater than zero, if the key is present.
    pub(crate) fn positive(&self, key: &'static str) -> Option<f64> {
        self.signed(key, "a number above 0", |number| number > 0.0)
    }

    fn signed(&self, key: &'static str, expected: &str, is_such: fn(f64) -> bool) -> Option<f64> {
        let number = self.number(key)?;
        if !is_such(number) {
            self.unexpected(key, &number.to_string(), expected);
            return None;
        }
        Some(number)
    }

    /// What was read, unless it is too large.
    fn sized<T>(&self, key: &str, value: T, fits: bool) -> Option<T> {
        if !fits {
            self.refuse(key, refusals::too_large(self.path_of(key), self.written(key)));
        }
        fits.then_some(value)
    }

    /// A whole number from 0, if the key is present.
    pub fn whole(&self, key: &'static str) -> Option<u32> {
        self.typed(key, "a whole number from 0", whole_of)
    }

    /// `true` or `false`, if the key is present.
    pub(crate) fn flag(&self, key: &'static str) -> Option<bool> {
        self.typed(key, "`true` or `false`", |value| value.as_bool())
    }

    /// One of a list of words, if the key is present.
    pub(crate) fn choice<T: Copy>(
        &self,
        key: &'static str,
        words: &[(&'static str, T)],
    ) -> Option<T> {
        self.choice_by(key, words, |known, word| known == word)
    }

    /// The same, by whatever two words have in common.
    pub(crate) fn choice_by<T: Copy>(
        &self,
        key: &'static str,
        words: &[(impl AsRef<str>, T)],
        same: impl Fn(&str, &str) -> bool,
    ) -> Option<T> {
        let word = self.text(key)?;
        let found = words.iter().find(|(known, _)| same(known.as_ref(), &word));
        if found.is_none() {
            let known: Vec<&str> = words.iter().map(|(known, _)| known.as_ref()).collect();
            let help = did_you_mean(&word, known.iter().copied(), "choose one of them");
            let (path, list) = (self.path_of(key), quoted(&known));
            self.refuse(key, refusals::other_word(path, shown(&word), list, help));
        }
        found.map(|(_, value)| *value)
    }

    /// Two positions in mm in square brackets, if the key is present.
    pub fn pair_of_millimetres(&self, key: &'static str) -> Option<[f64; 2]> {
        let numbers = |value: &DeValue<'_>| list_of(value, number_of)?.try_into().ok();
        let pair: [f64; 2] = self.typed(key, "two finite numbers, e.g. [0.0, 900.0]", numbers)?;
        self.sized(key, pair, pair.iter().all(|mm| mm.abs() <= LONGEST_MM))
    }

    /// A list of texts, if the key is present.
    pub fn texts(&self, key: &'static str) -> Option<Vec<String>> {
        self.typed(key, "a list of texts, e.g. [\"a\", \"b\"]", |value| list_of(value, text_of))
    }

    /// A list of pairs of whole numbers, if the key is present.
    pub(crate) fn whole_pairs(&self, key: &'static str) -> Option<Vec<[u32; 2]>> {
        let pair = |value: &DeValue<'_>| list_of(value, whole_of)?.try_into().ok();
        self.typed(key, "pairs of whole numbers, e.g. [[512, 767]]", |value| list_of(value, pair))
    }

    /// A sub-section, if it is present.
    pub fn section(&self, key: &'static str) -> Option<Section<'a>> {
        let table = self.typed(key, "a section", DeValue::as_table)?;
        let span = self.table.get(key)?.span();
        Some(self.child(table, span, key))
    }

    /// A list of sub-sections (`[[key]]`); empty if absent.
    pub fn sections(&self, key: &'static str) -> Vec<Section<'a>> {
        let items = self.typed(key, "a list of sections", |value| {
            value.as_array().filter(|items| items.iter().all(|item| item.get_ref().is_table()))
        });
        let child = |item: &'a Spanned<DeValue<'a>>| {
            Some(self.child(item.get_ref().as_table()?, item.span(), key))
        };
        items.into_iter().flatten().filter_map(child).collect()
    }

    /// A sub-section that is not there: no key of it is stated, and none is required.
    pub(crate) fn absent(&self, key: &str) -> Section<'a> {
        self.child(&self.noted.nothing, self.span.clone(), key)
    }

    fn child(&self, table: &'a DeTable<'a>, span: Range<usize>, key: &str) -> Section<'a> {
        Section { span, path: self.path_of(key), ..Section::root(self.source, table, self.noted) }
    }

    /// Keys and texts of a free sub-section (protocol); numbers are kept as they are written.
    pub(crate) fn entries(&self, key: &'static str) -> Vec<(String, String)> {
        let text = |value: &DeValue<'_>| match value {
            DeValue::String(text) => Some(text.to_string()),
            DeValue::Integer(number) => Some(number.to_string()),
            DeValue::Float(number) => Some(number.as_str().to_string()),
            _ => None,
        };
        let section = self.section(key);
        let entries = section.iter().flat_map(|own| own.table);
        entries
            .filter_map(|(key, value)| Some((key.get_ref().to_string(), text(value.get_ref())?)))
            .collect()
    }

    /// Takes every key as known: what is wrong already decides which there can be.
    pub(crate) fn ask_no_more(&self) {
        self.asked.borrow_mut().extend(self.table.keys().map(|key| &**key.get_ref()));
    }

    /// Notes every key that nobody asked for, with the nearest known one. Call it last.
    pub(crate) fn refuse_unknown_keys(&self) {
        let known = self.asked.borrow();
        for (key, _) in self.table.iter() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                self.note(|| self.unknown_key(name, key.span(), &known));
            }
        }
    }

    fn unknown_key(&self, name: &str, span: Range<usize>, known: &[&str]) -> Problem {
        let unit = |name: &str| {
            let (_, end) = name.rsplit_once('_')?;
            LENGTHS.into_iter().find(|unit| *unit == end)
        };
        let help = match nearest(name, known.iter().copied()) {
            None => format!("keys that are known here: {}", quoted(known)),
            Some(near) => {
                let is_other = unit(near).zip(unit(name)).is_some_and(|(own, other)| own != other);
                let units = " its unit is another: 1 mm = 1000 µm, 1 inch = 25.4 mm";
                format!("did you mean `{near}`?{}", if is_other { units } else { "" })
            }
        };
        refusals::unknown_key(shown(name), self.within(), help).at(self.source.place(&span))
    }
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { [path, ".", key].concat() }
}

/// Words in back-quotes, each once.
fn quoted(words: &[&str]) -> String {
    let once = once(words.to_vec()).into_iter();
    once.map(|word| format!("`{word}`")).collect::<Vec<String>>().join(", ")
}

/// Whether a key is to be filled in: `""` stands for every kind of value.
fn is_empty(value: &DeValue<'_>) -> bool {
    value.as_str() == Some("")
}

/// Where the value of a key stands, by its dotted path, and whether it is to be filled in.
type Spot = (String, Range<usize>, bool);

/// The keys of a table and of its sections; entries of a list with their number (`linear[1]`).
pub(super) fn spots(table: &DeTable<'_>, path: &str, found: &mut Vec<Spot>) {
    for (key, value) in table {
        let path = joined(path, key.get_ref());
        value.get_ref().as_table().into_iter().for_each(|section| spots(section, &path, found));
        for (index, entry) in value.get_ref().as_array().into_iter().flatten().enumerate() {
            let sections = entry.get_ref().as_table().into_iter();
            sections.for_each(|section| spots(section, &format!("{path}[{index}]"), found));
        }
        found.push((path, value.span(), is_empty(value.get_ref())));
    }
}

fn text_of(value: &DeValue<'_>) -> Option<String> {
    value.as_str().map(str::to_string)
}

fn number_of(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Float(float) => float.as_str(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
        _ => return None,
    };
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite())?;
    Some(number + 0.0) // −0 becomes 0
}

/// A whole number from 0, in whatever base it is written.
fn whole_of(value: &DeValue<'_>) -> Option<u32> {
    let integer = value.as_integer()?;
    u32::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// Every entry of a list, if all of them can be read.
fn list_of<T>(value: &DeValue<'_>, read: impl Fn(&DeValue<'_>) -> Option<T>) -> Option<Vec<T>> {
    value.as_array()?.iter().map(|item| read(item.get_ref())).collect()
}

/// What is noted of a page while it is read.
#[derive(Default)]
pub(super) struct Noted {
    pub(super) problems: Notes,
    /// A section that is not there.
    nothing: DeTable<'static>,
}
