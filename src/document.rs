//! TOML pages that users write, read key by key with every place kept.
//!
//! Jobs and controller profiles are read through [`Section`]. It notes each problem (wrong type,
//! unknown key, missing key) with its line and goes on, so that one run shows all of them. The
//! places of all keys stay available for later checks through [`Source::place_of`].

use crate::problem::{Place, Problem, Problems, nearest, shown};
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A text file with its name as the user gave it, and the places of its keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The name, as shown in messages.
    pub name: String,
    /// The text, without byte order mark.
    pub text: String,
    /// The place of each value that was read; looked through only for problems.
    spots: Vec<Spot>,
}

impl Source {
    /// A file from its bytes; UTF-8 with or without byte order mark, text only.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Source, Problems> {
        let text = std::str::from_utf8(bytes)
            .ok()
            .filter(|text| !text.contains('\0'))
            .ok_or_else(|| not_text(name, bytes))?;
        Ok(Source {
            name: name.to_string(),
            text: text.strip_prefix('\u{feff}').unwrap_or(text).to_string(),
            spots: Vec::new(),
        })
    }

    /// The place of bytes of the text.
    pub fn place(&self, span: &Range<usize>) -> Place {
        Place::in_text(&self.name, &self.text, span.start, span.end)
    }

    /// The place of a key's value, by its dotted path, e.g. `compensation.axes.x.spacing_mm`.
    pub fn place_of(&self, path: &str) -> Option<Place> {
        let spot = self.spots.iter().find(|spot| spot.is_at(path))?;
        Some(self.place(&spot.span))
    }

    /// A problem at a key, or at the nearest section above it that exists.
    pub fn problem_at(&self, path: &str, message: impl Into<String>) -> Problem {
        let mut path = path;
        let problem = Problem::new(message);
        loop {
            if let Some(place) = self.place_of(path) {
                return problem.at(place);
            }
            match path.rfind('.') {
                Some(dot) => path = &path[..dot],
                None => return problem.at(self.place(&(0..0))),
            }
        }
    }
}

/// Where the value of a key stands.
#[derive(Clone, Debug, PartialEq)]
struct Spot {
    /// Dotted path of its section, with the number of each entry of a list (`linear[1]`).
    section: Arc<str>,
    key: &'static str,
    span: Range<usize>,
}

impl Spot {
    /// Whether a dotted path leads here.
    fn is_at(&self, path: &str) -> bool {
        let section = path.strip_suffix(self.key);
        section.is_some_and(|section| match section.strip_suffix('.') {
            Some(section) => *self.section == *section,
            None => section.is_empty() && self.section.is_empty(),
        })
    }
}

fn not_text(name: &str, bytes: &[u8]) -> Problems {
    let good = std::str::from_utf8(bytes).map_or_else(|error| error.valid_up_to(), str::len);
    let what = if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        "is UTF-16 text".to_string()
    } else if bytes.starts_with(b"PK") {
        "is a spreadsheet or an archive".to_string()
    } else if bytes.contains(&0) {
        "is not a text file".to_string()
    } else {
        let line = bytes[..good].split(|byte| *byte == b'\n').count();
        format!("holds a letter in another encoding in line {line}")
    };
    Problem::new(format!("`{name}` {what}, expected UTF-8 text"))
        .help("save it as plain text in UTF-8 (a spreadsheet: `CSV UTF-8`)")
        .into()
}

/// Reads a TOML page: `read` takes what it knows from the root section and gives a value if it
/// could; every problem is collected. The source comes back with the places of its keys.
pub fn read_page<T>(
    mut source: Source,
    read: impl FnOnce(&Section<'_>) -> Option<T>,
) -> Result<(T, Source), Problems> {
    let (root, errors) = DeTable::parse_recoverable(&source.text);
    if !errors.is_empty() {
        return Err(syntax_problems(&source, &errors));
    }
    let notes = Notes::default();
    let section = Section {
        source: &source,
        table: root.get_ref(),
        span: 0..0,
        path: String::new(),
        spot: Arc::from(""),
        asked: RefCell::default(),
        notes: &notes,
    };
    let value = read(&section);
    section.refuse_unknown_keys();
    let spots = notes.spots.into_inner();
    let problems = notes.problems.into_inner();
    match value {
        Some(value) if problems.is_empty() => {
            source.spots = spots;
            Ok((value, source))
        }
        None if problems.is_empty() => {
            Err(Problem::new(format!("`{}` could not be read", source.name)).into())
        }
        _ => Err(problems),
    }
}

fn syntax_problems(source: &Source, errors: &[toml::de::Error]) -> Problems {
    let mut problems = Problems::none();
    for error in errors {
        let message = error.message().lines().next().unwrap_or("not TOML");
        let span = error.span();
        let written = span.clone().and_then(|span| source.text.get(span));
        let problem = match (message, written) {
            ("duplicate key", Some(key)) => {
                Problem::new(format!("`{}` stands twice in its section", shown(key)))
                    .help("keep one of the two")
            }
            _ => Problem::new(format!("not valid TOML: {message}"))
                .help("see https://toml.io; strings need quotes, numbers a decimal point"),
        };
        problems.push(match span {
            Some(span) => problem.at(source.place(&span)),
            None => problem,
        });
    }
    problems
}

#[derive(Default)]
struct Notes {
    problems: RefCell<Problems>,
    spots: RefCell<Vec<Spot>>,
}

/// A table of the page, e.g. `[machine.axes.x]`.
pub struct Section<'a> {
    source: &'a Source,
    table: &'a DeTable<'a>,
    span: Range<usize>,
    path: String,
    /// The path with the number of each entry of a list (`linear[1]`), by which places are kept.
    spot: Arc<str>,
    asked: RefCell<Vec<&'static str>>,
    notes: &'a Notes,
}

impl<'a> Section<'a> {
    /// Dotted path of the section, empty for the root.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Dotted path of a key of this section.
    pub fn path_of(&self, key: &str) -> String {
        joined(&self.path, key)
    }

    /// Notes a problem at a key (or at the section, if the key is absent).
    pub fn problem(&self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let span = self
            .table
            .get(key)
            .map_or_else(|| self.span.clone(), Spanned::span);
        self.note(|| {
            Problem::new(message)
                .at(self.source.place(&span))
                .help(help)
        });
    }

    fn note(&self, make: impl FnOnce() -> Problem) {
        self.notes.problems.borrow_mut().push_with(make);
    }

    fn value(&self, key: &'static str) -> Option<&'a DeValue<'a>> {
        self.asked.borrow_mut().push(key);
        let value = self.table.get(key)?;
        self.notes.spots.borrow_mut().push(Spot {
            section: Arc::clone(&self.spot),
            key,
            span: value.span(),
        });
        Some(value.get_ref())
    }

    fn wrong_type(&self, key: &str, expected: &str) {
        let found = match self.table.get(key).map(Spanned::get_ref) {
            Some(DeValue::Array(_)) => "a list".to_string(),
            Some(DeValue::Table(_)) => "a section".to_string(),
            _ => format!("`{}`", shown(self.as_written(key).unwrap_or_default())),
        };
        self.problem(
            key,
            format!("`{}` is {found}, expected {expected}", self.path_of(key)),
            format!("write `{key} = …` with {expected}"),
        );
    }

    /// Whether the key is present (it then counts as known).
    pub fn has(&self, key: &'static str) -> bool {
        self.value(key).is_some()
    }

    /// Notes that a required key is missing.
    pub fn missing(&self, key: &str, expected: &str) {
        let place = if self.path.is_empty() {
            format!("`{key}` is missing")
        } else {
            format!("`{key}` is missing in [{}]", self.path)
        };
        self.note(|| {
            Problem::new(format!("{place}, expected {expected}"))
                .at(self.source.place(&self.span))
                .help(format!("add `{key} = …`"))
        });
    }

    /// A sub-section that must be there.
    pub fn required_section(&self, key: &'static str) -> Option<Section<'a>> {
        if !self.has(key) {
            let name = self.path_of(key);
            let end = self.source.text.trim_end().len();
            let span = if self.path.is_empty() {
                end..end
            } else {
                self.span.clone()
            };
            self.note(|| {
                Problem::new(format!("there is no section [{name}]"))
                    .at(self.source.place(&span))
                    .help(format!("add `[{name}]`"))
            });
        }
        self.section(key)
    }

    /// Whether the key holds a list (it then counts as known).
    pub fn is_list(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(DeValue::is_array)
    }

    /// The value of a key as it is written in the page.
    pub fn as_written(&self, key: &str) -> Option<&'a str> {
        let span = self.table.get(key)?.span();
        self.source.text.get(span)
    }

    /// A text, if the key is present.
    pub fn text(&self, key: &'static str) -> Option<String> {
        match self.value(key)? {
            DeValue::String(text) => Some(text.to_string()),
            _ => {
                self.wrong_type(key, "a text in quotes");
                None
            }
        }
    }

    /// A text that must be there.
    pub fn required_text(&self, key: &'static str, expected: &str) -> Option<String> {
        if !self.has(key) {
            self.missing(key, expected);
        }
        self.text(key)
    }

    /// A finite number, if the key is present.
    pub fn number(&self, key: &'static str) -> Option<f64> {
        let number = number_of(self.value(key)?);
        match number {
            None => self.wrong_type(key, "a finite number"),
            Some(number) if number.abs() > LARGEST_NUMBER => self.too_large(key),
            Some(_) => return number,
        }
        None
    }

    /// A position or length in mm, no longer than any machine, if the key is present.
    pub fn millimetres(&self, key: &'static str) -> Option<f64> {
        let number = self.number(key)?;
        if number.abs() > LONGEST_MM {
            self.too_large(key);
            return None;
        }
        Some(number)
    }

    /// Two positions in mm in square brackets, if the key is present.
    pub fn pair_of_millimetres(&self, key: &'static str) -> Option<[f64; 2]> {
        let pair = self.pair(key)?;
        if pair.iter().any(|number| number.abs() > LONGEST_MM) {
            self.too_large(key);
            return None;
        }
        Some(pair)
    }

    /// A number from `low` to `high`, if the key is present.
    pub fn within(&self, key: &'static str, low: f64, high: f64, unit: &str) -> Option<f64> {
        let number = self.positive(key)?;
        if (low..=high).contains(&number) {
            return Some(number);
        }
        let written = shown(self.as_written(key).unwrap_or_default());
        self.problem(
            key,
            format!(
                "`{}` is `{written}`, expected {low} … {high} {unit}",
                self.path_of(key)
            ),
            "check the number and its unit",
        );
        None
    }

    /// A number of at least zero, if the key is present.
    pub fn not_negative(&self, key: &'static str) -> Option<f64> {
        let number = self.number(key)?;
        if number >= 0.0 {
            return Some(number);
        }
        self.problem(
            key,
            format!(
                "`{}` is {number}, expected a number of at least 0",
                self.path_of(key)
            ),
            format!("write `{key} = …` with a number of at least 0"),
        );
        None
    }

    fn too_large(&self, key: &str) {
        let written = shown(self.as_written(key).unwrap_or_default());
        self.problem(
            key,
            format!(
                "`{}` is `{written}`, which is too large for any machine",
                self.path_of(key)
            ),
            "check the number and its unit",
        );
    }

    /// A number greater than zero, if the key is present.
    pub fn positive(&self, key: &'static str) -> Option<f64> {
        let number = self.number(key)?;
        if number > 0.0 {
            return Some(number);
        }
        let path = self.path_of(key);
        self.problem(
            key,
            format!("`{path}` is {number}, expected a number above 0"),
            format!("write `{key} = …` with a number above 0"),
        );
        None
    }

    /// A whole number from 0, if the key is present.
    pub fn whole(&self, key: &'static str) -> Option<u32> {
        let whole = match self.value(key)? {
            DeValue::Integer(integer) => {
                u32::from_str_radix(integer.as_str(), integer.radix()).ok()
            }
            _ => None,
        };
        if whole.is_none() {
            self.wrong_type(key, "a whole number from 0");
        }
        whole
    }

    /// `true` or `false`, if the key is present.
    pub fn flag(&self, key: &'static str) -> Option<bool> {
        match self.value(key)? {
            DeValue::Boolean(flag) => Some(*flag),
            _ => {
                self.wrong_type(key, "`true` or `false`");
                None
            }
        }
    }

    /// One of a list of words, if the key is present.
    pub fn choice<T: Copy>(&self, key: &'static str, words: &[(&'static str, T)]) -> Option<T> {
        self.choice_by(key, words, |known, word| known == word)
    }

    /// The same, in capitals or not.
    pub fn choice_in_any_case<T: Copy>(
        &self,
        key: &'static str,
        words: &[(&'static str, T)],
    ) -> Option<T> {
        self.choice_by(key, words, str::eq_ignore_ascii_case)
    }

    fn choice_by<T: Copy>(
        &self,
        key: &'static str,
        words: &[(&'static str, T)],
        same: impl Fn(&str, &str) -> bool,
    ) -> Option<T> {
        let word = self.text(key)?;
        let found = words.iter().find(|(known, _)| same(known, &word));
        if found.is_none() {
            let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
            let list: Vec<String> = known.iter().map(|word| format!("`{word}`")).collect();
            let help = nearest(&word, known.iter().copied()).map_or_else(
                || "choose one of them".to_string(),
                |near| format!("did you mean `{near}`?"),
            );
            let path = self.path_of(key);
            self.problem(
                key,
                format!(
                    "`{path}` is `{}`, expected one of {}",
                    shown(&word),
                    list.join(", ")
                ),
                help,
            );
        }
        found.map(|(_, value)| *value)
    }

    /// Two finite numbers in square brackets, if the key is present.
    pub fn pair(&self, key: &'static str) -> Option<[f64; 2]> {
        let numbers: Option<Vec<f64>> = match self.value(key)? {
            DeValue::Array(items) => items.iter().map(|item| number_of(item.get_ref())).collect(),
            _ => None,
        };
        match numbers.as_deref() {
            Some([first, second]) if first.abs().max(second.abs()) > LARGEST_NUMBER => {
                self.too_large(key);
                None
            }
            Some([first, second]) => Some([*first, *second]),
            _ => {
                self.wrong_type(key, "two finite numbers, e.g. [0.0, 900.0]");
                None
            }
        }
    }

    /// A list of texts, if the key is present.
    pub fn texts(&self, key: &'static str) -> Option<Vec<String>> {
        let texts: Option<Vec<String>> = match self.value(key)? {
            DeValue::Array(items) => items
                .iter()
                .map(|item| item.get_ref().as_str().map(str::to_string))
                .collect(),
            _ => None,
        };
        if texts.is_none() {
            self.wrong_type(key, "a list of texts, e.g. [\"a\", \"b\"]");
        }
        texts
    }

    /// A list of pairs of whole numbers, if the key is present.
    pub fn whole_pairs(&self, key: &'static str) -> Option<Vec<[u32; 2]>> {
        let pairs: Option<Vec<[u32; 2]>> = match self.value(key)? {
            DeValue::Array(items) => items
                .iter()
                .map(|item| whole_pair(item.get_ref()))
                .collect(),
            _ => None,
        };
        if pairs.is_none() {
            self.wrong_type(key, "pairs of whole numbers, e.g. [[512, 767]]");
        }
        pairs
    }

    /// A sub-section, if it is present.
    pub fn section(&self, key: &'static str) -> Option<Section<'a>> {
        self.value(key)?;
        let entry = self.table.get(key)?;
        match entry.get_ref() {
            DeValue::Table(table) => {
                let spot = joined(&self.spot, key);
                Some(self.child(table, entry.span(), key, &spot))
            }
            _ => {
                self.wrong_type(key, "a section");
                None
            }
        }
    }

    /// A list of sub-sections (`[[key]]`); empty if absent. The places of their keys are kept
    /// under `key[0]`, `key[1]` …
    pub fn sections(&self, key: &'static str) -> Vec<Section<'a>> {
        match self.value(key) {
            None => Vec::new(),
            Some(DeValue::Array(items)) if items.iter().all(|item| item.get_ref().is_table()) => {
                items
                    .iter()
                    .enumerate()
                    .filter_map(|(index, item)| {
                        let table = item.get_ref().as_table()?;
                        let spot = format!("{}[{index}]", joined(&self.spot, key));
                        Some(self.child(table, item.span(), key, &spot))
                    })
                    .collect()
            }
            Some(_) => {
                self.wrong_type(key, "a list of sections");
                Vec::new()
            }
        }
    }

    fn child(
        &self,
        table: &'a DeTable<'a>,
        span: Range<usize>,
        key: &str,
        spot: &str,
    ) -> Section<'a> {
        Section {
            source: self.source,
            table,
            span,
            path: self.path_of(key),
            spot: Arc::from(spot),
            asked: RefCell::default(),
            notes: self.notes,
        }
    }

    /// Keys and texts of a free section (protocol); numbers are kept as they are written.
    pub fn entries(&self) -> Vec<(String, String)> {
        self.table
            .iter()
            .filter_map(|(key, value)| match value.get_ref() {
                DeValue::String(text) => Some((key.get_ref().to_string(), text.to_string())),
                DeValue::Integer(number) => {
                    Some((key.get_ref().to_string(), number.as_str().to_string()))
                }
                DeValue::Float(number) => {
                    Some((key.get_ref().to_string(), number.as_str().to_string()))
                }
                _ => None,
            })
            .collect()
    }

    /// Notes every key that nobody asked for, with the nearest known one. Call it last.
    pub fn refuse_unknown_keys(&self) {
        let known = self.asked.borrow();
        for (key, _) in self.table.iter() {
            let name: &str = key.get_ref();
            if known.contains(&name) {
                continue;
            }
            let help = nearest(name, known.iter().copied()).map_or_else(
                || format!("keys that are known here: {}", list_of(&known)),
                |near| format!("did you mean `{near}`?"),
            );
            let section = if self.path.is_empty() {
                String::new()
            } else {
                format!(" in [{}]", self.path)
            };
            self.note(|| {
                Problem::new(format!("unknown key `{}`{section}", shown(name)))
                    .at(self.source.place(&key.span()))
                    .help(help)
            });
        }
    }
}

/// No length, deviation or feed of a machine comes near, whatever its unit.
pub const LARGEST_NUMBER: f64 = 1e9;
/// No machine has a kilometre of travel.
pub const LONGEST_MM: f64 = 1e6;

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_string()
    } else {
        [path, ".", key].concat()
    }
}

/// Words in back-quotes, each once.
fn list_of(words: &[&str]) -> String {
    let mut list: Vec<String> = Vec::new();
    for word in words {
        let quoted = format!("`{word}`");
        if !list.contains(&quoted) {
            list.push(quoted);
        }
    }
    list.join(", ")
}

fn number_of(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Float(float) => float.as_str(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
        _ => return None,
    };
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

fn whole_pair(value: &DeValue<'_>) -> Option<[u32; 2]> {
    let items = value.as_array()?;
    let numbers: Option<Vec<u32>> = items
        .iter()
        .map(|item| item.get_ref().as_integer()?.as_str().parse().ok())
        .collect();
    numbers?.try_into().ok()
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |half: u8| char::from(DIGITS[usize::from(half)]);
    let digest = Sha256::digest(bytes);
    let digits = digest.iter().flat_map(|byte| [byte >> 4, byte & 15]);
    digits.map(digit).collect()
}
