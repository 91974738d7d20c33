//! Texts of the report in the reader's language, as data.

use crate::text::document::Source;
use crate::text::html::escaped;
use crate::text::plain;
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeMap;

/// The words of a report by their keys; every key of the English ones is there.
#[derive(Clone, Debug)]
pub struct Texts {
    /// The language as HTML names it.
    pub language: String,
    words: BTreeMap<String, String>,
}

const LANGUAGES: [(&str, &str); 3] = [
    ("en", include_str!("../../templates/report/en.toml")),
    ("de", include_str!("../../templates/report/de.toml")),
    ("zh", include_str!("../../templates/report/zh.toml")),
];

impl Texts {
    /// The languages that are shipped.
    pub fn languages() -> impl Iterator<Item = &'static str> {
        LANGUAGES.into_iter().map(|(name, _)| name)
    }

    /// A shipped language; `None` = not among them.
    pub(crate) fn shipped(language: &str) -> Option<Result<Texts, Problems>> {
        let (name, page) = LANGUAGES.into_iter().find(|(name, _)| *name == language)?;
        Some(
            Source::from_bytes(name, page.as_bytes()).and_then(|source| Texts::read(&source, name)),
        )
    }

    /// The language of whatever stands on no page.
    pub(crate) fn english() -> Result<Texts, Problems> {
        let [(name, page), ..] = LANGUAGES;
        Texts::read(&Source::from_bytes(name, page.as_bytes())?, name)
    }

    /// A file of one's own: it has to hold every key of the English texts and no other.
    pub fn read(source: &Source, language: &str) -> Result<Texts, Problems> {
        let words = table(source)?;
        let [(_, english), ..] = LANGUAGES;
        let english = table(&Source::from_bytes("en", english.as_bytes())?)?;
        let missing: Vec<&str> =
            english.keys().filter(|key| !words.contains_key(*key)).map(String::as_str).collect();
        let unknown: Vec<&str> =
            words.keys().filter(|key| !english.contains_key(*key)).map(String::as_str).collect();
        let mut problems = Problems::none();
        for (what, keys) in [("lacks", missing), ("holds the unknown keys", unknown)] {
            if !keys.is_empty() {
                let words = format!("`{}` {what}: {}", source.name, keys.join(", "));
                let help = "the keys are those of the English texts (docs/report.md)";
                problems.push(Problem::new(words).help(help));
            }
        }
        let language = language.to_string();
        problems.or_ok(Texts { language, words })
    }

    /// The words of a key.
    pub(super) fn of(&self, key: &str) -> &str {
        self.words.get(key).map_or("", String::as_str)
    }

    /// Whether there are words of this key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.words.contains_key(key)
    }

    /// All of them as text of a page.
    pub(super) fn escaped(&self) -> BTreeMap<&str, String> {
        let words = self.words.iter();
        words.map(|(key, words)| (key.as_str(), escaped(words))).collect()
    }
}

fn table(source: &Source) -> Result<BTreeMap<String, String>, Problems> {
    toml::from_str(&source.text).map_err(|error| {
        let words = plain::page(error.message()).into_owned();
        Problem::new(format!("`{}` holds no texts: {words}", source.name))
            .help("lines of the form `key = \"words\"`")
            .into()
    })
}
