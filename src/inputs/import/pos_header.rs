//! Lines `Key: value` above and below the tables of a `.pos` file; several may share a line.

use crate::inputs::import::lines::{Word, lines};
use crate::text::delimited::LengthUnit;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

/// The version of the format that was at hand.
const KNOWN_VERSION: &str = "5";
/// Keys that are copied into the table, as [`Header::value`] takes them and as the file writes them.
const COPIED: [(&str, &str); 6] = [
    ("instrumentsn", "Instrument(S/N)"),
    ("testdate", "TestDate"),
    ("machid", "MachID"),
    ("machname", "MachName"),
    ("testtype", "TestType"),
    ("zerooffset", "ZeroOffset"),
];

/// The fields of a file.
pub(super) struct Header<'a> {
    first: Word<'a>,
    fields: Vec<(String, Word<'a>)>,
}

impl<'a> Header<'a> {
    pub(super) fn of(source: &'a Source) -> Result<Self, Problems> {
        let lines = lines(source);
        let first = lines.iter().find(|line| !line.is_blank());
        let first = first.map(|line| line.part(0, line.text.len()));
        let Some(first) = first.filter(|first| is_first_line(first.text)) else {
            return Err(Problem::new(
                "the first line is not `API … Data Table`, expected a full export of the format `pos`",
            )
            .at(source.place(&(0..0)))
            .help("save the measurement itself, not an evaluation; or map the columns: `--columns \"Position=target_mm,Error=ex_mm\"`")
            .into());
        };
        let mut fields: Vec<(String, Word<'a>)> = Vec::new();
        for line in &lines {
            let mut open: Option<String> = None;
            for part in line.words(|c| c == '\t') {
                let pair = part.line().key_value();
                match (open.take(), pair) {
                    (Some(key), _) => fields.push((key, part)),
                    (None, Some((key, value))) if value.text.is_empty() => open = Some(key),
                    (None, Some(pair)) => fields.push(pair),
                    (None, None) => {}
                }
            }
        }
        Ok(Header { first, fields })
    }

    /// The first value of a key; the key in small letters and digits only.
    pub(super) fn value(&self, key: &str) -> Option<Word<'a>> {
        let mut found = self.fields.iter().filter(|(found, _)| found == key);
        found.next().map(|(_, value)| *value)
    }

    /// Other tables of the maker hold angles or straightness.
    pub(super) fn check(&self, problems: &mut Problems) {
        if !self.first.text.to_lowercase().contains("linear data table") {
            problems.push(
                Problem::new(format!(
                    "the file is `{}`, expected a `Linear Data Table`",
                    shown(self.first.text)
                ))
                .at(self.first.place())
                .help("export a CSV with the unit, and map its columns with `--columns`"),
            );
        }
    }

    pub(super) fn facts(&self) -> Vec<String> {
        let said = |(key, name): (&str, &str)| {
            let value = self.value(key)?;
            Some(format!("the file says: {name}: {}", shown(value.text)))
        };
        COPIED.into_iter().filter_map(said).collect()
    }

    pub(super) fn version_warning(&self) -> Option<String> {
        let version = self.value("fileversion").map_or("none", |word| word.text);
        (version != KNOWN_VERSION).then(|| {
            format!(
                "`File Version` is {}; the format is known from version {KNOWN_VERSION} only: compare a value with the screen of the maker's program",
                shown(version)
            )
        })
    }

    /// The unit of a key, which has to stand there.
    pub(super) fn unit(
        &self,
        key: &str,
        name: &str,
        problems: &mut Problems,
    ) -> Option<LengthUnit> {
        let word = self.value(key);
        let unit = word.and_then(|word| LengthUnit::from_text(word.text));
        if unit.is_none() {
            let found = word.map_or("missing".to_string(), |w| format!("`{}`", shown(w.text)));
            let place = word.map_or_else(|| self.first.place(), |word| word.place());
            problems.push(
                Problem::new(format!(
                    "`{name}` is {found}, expected a unit of length such as mm or inch"
                ))
                .at(place)
                .help(AGAIN),
            );
        }
        unit
    }

    /// A whole number from 1 that the rows depend on.
    pub(super) fn count(&self, key: &str, name: &str, problems: &mut Problems) -> Option<usize> {
        match self.value(key) {
            Some(word) => word.count(&format!("`{name}`"), problems),
            None => {
                let problem = Problem::new(format!("there is no `{name}`"));
                problems.push(problem.at(self.first.place()).help(AGAIN));
                None
            }
        }
    }

    /// Whether the runs go there and back.
    pub(super) fn is_bidirectional(&self, problems: &mut Problems) -> Option<bool> {
        let word = self.value("testtype");
        let text = word.map_or(String::new(), |word| word.text.to_lowercase());
        match (text.starts_with("uni"), text.starts_with("bi")) {
            (true, _) => Some(false),
            (_, true) => Some(true),
            _ => {
                let place = word.map_or_else(|| self.first.place(), |word| word.place());
                problems.push(
                    Problem::new(format!(
                        "`TestType` is `{}`, expected `Unidirection` or `Bidirection`",
                        shown(&text)
                    ))
                    .at(place)
                    .help(AGAIN),
                );
                None
            }
        }
    }
}

/// Whether a text begins as such a file does.
pub(super) fn is_first_line(text: &str) -> bool {
    let text = text.trim().to_lowercase();
    text.starts_with("api ") && text.contains("laser measurement") && text.contains("data table")
}

pub(super) const AGAIN: &str = "the file is incomplete or was changed: save it again";
