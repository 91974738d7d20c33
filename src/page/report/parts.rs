//! The parts of the page behind the first one.

use super::{Kind, NONE, Report, linear_document};
use crate::page::svg;
use crate::quantity::axis::ErrorTerm;
use crate::text::finding::once;
use crate::text::html::escaped;
use serde::Serialize;
use serde_json::Value;
use std::collections::HashSet;

/// Figures of ISO 230-2 by their names in the document of `standards`, and as the standard writes them.
const FIGURES: [(&str, &str); 12] = [
    ("A", "A"),
    ("A_up", "A\u{2191}"),
    ("A_down", "A\u{2193}"),
    ("E", "E"),
    ("E_up", "E\u{2191}"),
    ("E_down", "E\u{2193}"),
    ("R", "R"),
    ("R_up", "R\u{2191}"),
    ("R_down", "R\u{2193}"),
    ("M", "M"),
    ("B", "B"),
    ("B_mean", "B\u{0304}"),
];

/// A part of the page behind the first one.
#[derive(Default, Serialize)]
pub(super) struct Part {
    id: &'static str,
    title: String,
    words: Vec<String>,
    pictures: Vec<String>,
    tables: Vec<Table>,
    items: Vec<String>,
    /// Sentences of the program, in English.
    said: Vec<String>,
}

#[derive(Serialize)]
struct Table {
    head: Vec<String>,
    rows: Vec<Row>,
    is_words: bool,
    /// Whether its cells are words of the program.
    is_english: bool,
}

#[derive(Serialize)]
struct Row {
    cells: Vec<String>,
}

impl Part {
    fn is_empty(&self) -> bool {
        let rows = self.tables.iter().flat_map(|table| &table.rows);
        let texts = [&self.words, &self.pictures, &self.items, &self.said];
        rows.count() == 0 && texts.into_iter().all(Vec::is_empty)
    }
}

impl Table {
    fn new(
        head: Vec<String>,
        rows: impl IntoIterator<Item = Vec<String>>,
        is_words: bool,
    ) -> Table {
        let rows = rows.into_iter().map(|cells| Row { cells });
        Table { head, rows: rows.collect(), is_words, is_english: false }
    }

    fn in_english(self) -> Table {
        Table { is_english: true, ..self }
    }
}

impl Report<'_> {
    fn part(&self, id: &'static str) -> Part {
        let own = self.visit.pictures.iter().filter(|(of, _)| *of == id);
        Part {
            id,
            title: self.t(id),
            pictures: own.map(|(_, picture)| svg::inline(picture, self.locale)).collect(),
            ..Part::default()
        }
    }

    /// The nine curves, which stand on the first page where they were measured again.
    pub(super) fn curves(&self, are_here: bool) -> Vec<String> {
        if are_here { self.part("curves").pictures } else { Vec::new() }
    }

    /// Behind the first page; parts without anything are left out.
    pub(super) fn parts(&self) -> Vec<Part> {
        let curves = Part { pictures: self.curves(!self.visit.is_measured), ..self.part("curves") };
        let drawn = [curves, self.linear(), self.readings()];
        let drawn = drawn.into_iter().filter(|part| !part.pictures.is_empty());
        let of_tables = match self.is_found() {
            true => [Vec::new(), vec![self.missing(), self.found()], Vec::new()],
            false => [
                vec![self.tables()],
                vec![self.missing(), self.reasons(), self.found()],
                vec![self.assumed(), self.undo()],
            ],
        };
        drawn
            .chain([self.volume()])
            .chain(of_tables.into_iter().flatten())
            .chain([self.provenance()])
            .filter(|part| !part.is_empty())
            .collect()
    }

    /// Figures of ISO 230-2, a column for each file of runs.
    fn linear(&self) -> Part {
        let files = &self.visit.linear;
        let names: Vec<String> = (1..=files.len()).map(linear_document).collect();
        let rows = FIGURES.map(|(figure, shown)| {
            let at = format!("/iso_230_2/{figure}_um");
            let own = names.iter().map(|name| self.figure(name, &at, Kind::Deviation));
            std::iter::once(shown.to_string()).chain(own).collect::<Vec<_>>()
        });
        let rows = rows.into_iter().filter(|row| row.iter().skip(1).any(|cell| cell != NONE));
        let head = std::iter::once(self.unit().to_string()).chain(files.iter().map(|f| escaped(f)));
        let said = names.iter().zip(files).flat_map(|(name, file)| {
            let label = self.document(name).pointer("/iso_230_2/label");
            let label = label.and_then(Value::as_str).map(escaped);
            let notes = self.sentences(name, "/iso_230_2/notes", usize::MAX);
            let said = label.into_iter().chain(notes);
            said.map(move |words| format!("{}: {words}", escaped(file)))
        });
        Part {
            tables: vec![Table::new(head.collect(), rows, false)],
            said: said.collect(),
            ..self.part("linear")
        }
    }

    /// Figures of the diagonals as they were read.
    fn readings(&self) -> Part {
        const OF: &str = "/iso_230_6/diagonals";
        let names = self.keys("standards", OF);
        let figures = ["E", "B", "R", "A", "range"];
        let at = |name: &str, figure: &str| {
            let at = format!("{OF}/{name}/{figure}_um");
            self.figure("standards", &at, Kind::Deviation)
        };
        let is_there = |figure: &&str| names.iter().any(|name| at(name, figure) != NONE);
        let figures: Vec<&str> = figures.into_iter().filter(is_there).collect();
        let rows = names.iter().map(|name| {
            let own = figures.iter().map(|figure| at(name, figure));
            std::iter::once(escaped(name)).chain(own).collect()
        });
        let shown = figures.iter().map(|figure| match *figure {
            "range" => self.t("range"),
            letter => letter.to_string(),
        });
        let head = std::iter::once(format!("{}, {}", self.t("diagonal"), self.unit()));
        let label = self.document("standards").pointer("/iso_230_6/label");
        let label = label.and_then(Value::as_str).map(escaped);
        Part {
            tables: vec![Table::new(head.chain(shown).collect(), rows, false)],
            said: label.into_iter().collect(),
            ..self.part("readings")
        }
    }

    fn volume(&self) -> Part {
        let part = self.part("volume");
        if self.document("assess").is_null() {
            let why = self.visit.without_volume.iter().map(|words| escaped(words));
            let words = vec![self.t("no_volume")];
            return Part { words, said: why.collect(), ..part };
        }
        let nodes = [0, 1, 2].map(|n| self.figure("assess", &format!("/grid/{n}"), Kind::Count));
        let found: HashSet<String> = self.findings().into_iter().collect();
        let labels = self.sentences("assess", "/labels", usize::MAX).into_iter();
        Part {
            words: vec![format!("{}: {}", self.t("grid"), nodes.join(" × "))],
            said: labels.filter(|words| !found.contains(words)).collect(),
            ..part
        }
    }

    fn tables(&self) -> Part {
        let rows = self.list("kit", "/tables").enumerate().map(|(n, table)| {
            let text = |key: &str| table[key].as_str().map(escaped);
            vec![
                text("term").unwrap_or_default(),
                text("direction").unwrap_or_else(|| self.t("both")),
                text("place").unwrap_or_default(),
                self.figure("kit", &format!("/tables/{n}/points"), Kind::Count),
                self.figure("kit", &format!("/tables/{n}/grid_residual_um"), Kind::Deviation),
            ]
        });
        if !self.is_kit_known() {
            return self.listed("tables", Vec::new(), "no_manifest");
        }
        let residual = format!("{}, {}", self.t("residual"), self.unit());
        let head = ["term", "direction", "place", "points"].map(|key| self.t(key));
        let placed = Table::new(head.into_iter().chain([residual]).collect(), rows, true);
        let files = self.list("kit", "/files").map(|file| {
            let text = |key: &str| file[key].as_str().map(escaped).unwrap_or_default();
            let size = self
                .visit
                .sizes
                .iter()
                .find(|(name, _)| Some(name.as_str()) == file["path"].as_str());
            let size = size.map_or_else(String::new, |(_, bytes)| bytes.to_string());
            let role = format!("role_{}", file["role"].as_str().unwrap_or_default());
            vec![
                text("path"),
                match self.locale.texts.has(&role) {
                    true => self.t(&role),
                    false => text("role"),
                },
                size,
                format!("<code>{}</code>", text("sha256")),
            ]
        });
        let head = ["file", "role", "bytes", "sha256"].map(|key| self.t(key));
        let files = Table::new(head.to_vec(), files, true);
        Part { tables: vec![placed.in_english(), files], ..self.part("tables") }
    }

    fn missing(&self) -> Part {
        if self.is_found() {
            let missing = self.list("assess", "/missing").map(|missing| {
                let text = |key: &str| missing[key].as_str().unwrap_or_default();
                escaped(&format!("{}: {}", text("name"), text("consequence")))
            });
            return self.listed("missing_found", missing.collect(), "nothing_missing_found");
        }
        let known = self.keys("verify", "/terms");
        let names = ErrorTerm::ALL.map(|term| term.to_string());
        let unmeasured = names.into_iter().filter(|name| !known.contains(name));
        let unmeasured = unmeasured.map(|name| format!("{name}: {}", self.t("not_measured")));
        let omitted = self.list("kit", "/omitted").map(|omitted| {
            let text = |key: &str| omitted[key].as_str().unwrap_or_default();
            escaped(&format!("{}: {}", text("term"), text("reason")))
        });
        let without = match self.is_kit_known() {
            true => "nothing_missing",
            false => "no_manifest",
        };
        let items: Vec<String> = unmeasured.collect();
        let said: Vec<String> = omitted.collect();
        let is_none = items.is_empty() && said.is_empty();
        Part {
            words: is_none.then(|| self.t(without)).into_iter().collect(),
            items,
            said,
            ..self.part("missing")
        }
    }

    /// Whether the directory says what it holds.
    fn is_kit_known(&self) -> bool {
        !self.document("kit").is_null()
    }

    /// All that does not keep a limit.
    fn reasons(&self) -> Part {
        Part { items: self.misses(), ..self.part("reasons") }
    }

    fn found(&self) -> Part {
        self.listed("findings", self.findings(), "no_findings")
    }

    /// Every finding once: of two measurements both may have it, and what misses a limit is a reason.
    fn findings(&self) -> Vec<String> {
        let places = match self.is_found() {
            true => ["/labels", ""],
            false => ["/causes", "/notes"],
        };
        let misses = self.visit.grounds.misses.iter();
        let misses: HashSet<String> = misses.map(|miss| escaped(&miss.to_string())).collect();
        let all = places.map(|at| self.sentences(self.main(), at, usize::MAX));
        once(all.into_iter().flatten().filter(|words| !misses.contains(words)).collect())
    }

    fn assumed(&self) -> Part {
        let spaced = |words: &str| escaped(&words.replace('_', " "));
        let rows = self.visit.assumptions.iter().map(|assumed| {
            let fact = format!("{}: {}", spaced(&assumed.fact), spaced(&assumed.value));
            vec![fact, escaped(&assumed.consequence)]
        });
        let head = vec![String::new(), self.t("if_wrong")];
        Part { tables: vec![Table::new(head, rows, true).in_english()], ..self.part("assumptions") }
    }

    fn undo(&self) -> Part {
        let files = self.list("kit", "/files").filter_map(|file| {
            let role = file["role"].as_str()?;
            let is_back = role == "rollback" || role == "disable";
            is_back.then(|| escaped(file["path"].as_str().unwrap_or_default()))
        });
        let files: Vec<String> = files.collect();
        let words = match (self.is_kit_known(), files.is_empty()) {
            (false, _) => "no_manifest",
            (true, true) => "undo_hand",
            (true, false) => "undo_words",
        };
        Part { words: vec![self.t(words)], items: files, ..self.part("undo") }
    }

    /// What was read now, what the kit was made from, what was measured afterwards.
    fn provenance(&self) -> Part {
        let row = |path: &str, sha256: &str| {
            vec![escaped(path), format!("<code>{}</code>", escaped(sha256))]
        };
        let own = self.visit.inputs.iter();
        let own = own.map(|file| row(&file.path, &file.sha256));
        let stated = self.list("kit", "/inputs").chain(self.list("verify", "/after"));
        let stated = stated.map(|file| {
            let text = |key: &str| file[key].as_str().unwrap_or_default();
            row(text("path"), text("sha256"))
        });
        let head = vec![self.t("file"), self.t("sha256")];
        let table = Table::new(head, once(own.chain(stated).collect()), true);
        Part { tables: vec![table], ..self.part("provenance") }
    }

    /// Sentences of the program, or the words of a key where there are none.
    fn listed(&self, id: &'static str, said: Vec<String>, without: &str) -> Part {
        let words = said.is_empty().then(|| self.t(without));
        Part { words: words.into_iter().collect(), said, ..self.part(id) }
    }
}
