//! The parts of the page behind the first one.

use super::{FigureKind, NONE, Report, linear_document};
use crate::page::svg;
use crate::quantity::ErrorTerm;
use crate::text::{escaped, once};
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
pub(super) struct ReportPart {
    id: &'static str,
    title: String,
    words: Vec<String>,
    pictures: Vec<String>,
    tables: Vec<ReportTable>,
    items: Vec<String>,
    /// Sentences of the program, in English.
    said: Vec<String>,
}

#[derive(Serialize)]
struct ReportTable {
    head: Vec<String>,
    rows: Vec<ReportRow>,
    is_words: bool,
    /// Whether its cells are words of the program.
    is_english: bool,
}

#[derive(Serialize)]
struct ReportRow {
    cells: Vec<String>,
}

impl ReportPart {
    fn is_empty(&self) -> bool {
        let rows = self.tables.iter().flat_map(|table| &table.rows);
        let texts = [&self.words, &self.pictures, &self.items, &self.said];
        rows.count() == 0 && texts.into_iter().all(Vec::is_empty)
    }
}

impl ReportTable {
    fn new(
        head: Vec<String>,
        rows: impl IntoIterator<Item = Vec<String>>,
        is_words: bool,
    ) -> ReportTable {
        let rows = rows.into_iter().map(|cells| ReportRow { cells });
        ReportTable { head, rows: rows.collect(), is_words, is_english: false }
    }
}

/// A line of a table: what it is of, then its figures.
fn line(name: String, figures: impl IntoIterator<Item = String>) -> Vec<String> {
    std::iter::once(name).chain(figures).collect()
}

/// A file with its hash.
fn hashed(path: &str, sha256: &str) -> Vec<String> {
    vec![escaped(path), format!("<code>{}</code>", escaped(sha256))]
}

/// A text of an entry; empty where there is none.
fn text<'a>(entry: &'a Value, key: &str) -> &'a str {
    entry[key].as_str().unwrap_or_default()
}

impl Report<'_> {
    fn part(&self, id: &'static str) -> ReportPart {
        let own = self.visit.pictures.iter().filter(|(of, _)| *of == id);
        ReportPart {
            id,
            title: self.t(id),
            pictures: own.map(|(_, picture)| svg::inline(picture, self.locale)).collect(),
            ..ReportPart::default()
        }
    }

    /// The nine curves, which stand on the first page where they were measured again.
    pub(super) fn curves(&self, are_here: bool) -> Vec<String> {
        if are_here { self.part("curves").pictures } else { Vec::new() }
    }

    /// Behind the first page; parts without anything are left out.
    pub(super) fn parts(&self) -> Vec<ReportPart> {
        let curves =
            ReportPart { pictures: self.curves(!self.visit.is_measured), ..self.part("curves") };
        let drawn = [curves, self.linear(), self.readings()];
        let drawn = drawn.into_iter().filter(|part| !part.pictures.is_empty());
        let (missing, found) = (self.missing(), self.found());
        let reasons = ReportPart { items: self.misses(), ..self.part("reasons") };
        let of_tables = match self.is_found() {
            true => vec![missing, found],
            false => vec![self.tables(), missing, reasons, found, self.assumed(), self.undo()],
        };
        let all = drawn.chain([self.volume()]).chain(of_tables).chain([self.provenance()]);
        all.filter(|part| !part.is_empty()).collect()
    }

    /// Figures of ISO 230-2, a column for each file of runs.
    fn linear(&self) -> ReportPart {
        let files = &self.visit.linear;
        let names: Vec<String> = (1..=files.len()).map(linear_document).collect();
        let rows = FIGURES.map(|(figure, shown)| {
            let at = format!("/iso_230_2/{figure}_um");
            let own = names.iter().map(|name| self.figure(name, &at, FigureKind::Deviation));
            line(shown.to_string(), own)
        });
        let rows = rows.into_iter().filter(|row| row[1..].iter().any(|cell| cell != NONE));
        let head = line(self.unit().to_string(), files.iter().map(|file| escaped(file)));
        let said = names.iter().zip(files).flat_map(|(name, file)| {
            let said = ["label", "notes"].map(|key| format!("/iso_230_2/{key}"));
            let said = said.into_iter().flat_map(|at| self.sentences(name, &at));
            said.map(move |words| format!("{}: {words}", escaped(file)))
        });
        let tables = vec![ReportTable::new(head, rows, false)];
        ReportPart { tables, said: said.collect(), ..self.part("linear") }
    }

    /// Figures of the diagonals as they were read.
    fn readings(&self) -> ReportPart {
        const OF: &str = "/iso_230_6/diagonals";
        let names = self.keys("standards", OF);
        let at = |name: &str, figure: &str| {
            self.figure("standards", &format!("{OF}/{name}/{figure}_um"), FigureKind::Deviation)
        };
        let mut figures = vec!["E", "B", "R", "A", "range"];
        figures.retain(|figure| names.iter().any(|name| at(name, figure) != NONE));
        let row = |name: &String| line(escaped(name), figures.iter().map(|of| at(name, of)));
        let rows = names.iter().map(row);
        let shown = figures.iter().map(|figure| self.named(figure, figure));
        let head = line(format!("{}, {}", self.t("diagonal"), self.unit()), shown);
        ReportPart {
            tables: vec![ReportTable::new(head, rows, false)],
            said: self.sentences("standards", "/iso_230_6/label"),
            ..self.part("readings")
        }
    }

    fn volume(&self) -> ReportPart {
        let part = self.part("volume");
        if self.document("assess").is_null() {
            let said = self.visit.without_volume.iter().map(|words| escaped(words));
            return ReportPart { words: vec![self.t("no_volume")], said: said.collect(), ..part };
        }
        let nodes =
            [0, 1, 2].map(|n| self.figure("assess", &format!("/grid/{n}"), FigureKind::Count));
        let found: HashSet<String> = self.findings().into_iter().collect();
        let labels = self.sentences("assess", "/labels").into_iter();
        ReportPart {
            words: vec![format!("{}: {}", self.t("grid"), nodes.join(" × "))],
            said: labels.filter(|words| !found.contains(words)).collect(),
            ..part
        }
    }

    fn tables(&self) -> ReportPart {
        if !self.is_kit_known() {
            return self.listed("tables", Vec::new(), "no_manifest");
        }
        let rows = self.list("kit", "/tables").enumerate().map(|(n, table)| {
            let figure = |key: &str, kind| self.figure("kit", &format!("/tables/{n}/{key}"), kind);
            let direction = table["direction"].as_str();
            vec![
                escaped(text(table, "term")),
                direction.map_or_else(|| self.t("both"), escaped),
                escaped(text(table, "place")),
                figure("points", FigureKind::Count),
                figure("grid_residual_um", FigureKind::Deviation),
            ]
        });
        let residual = format!("{}, {}", self.t("residual"), self.unit());
        let head = ["term", "direction", "place", "points"].map(|key| self.t(key));
        let placed = ReportTable::new(head.into_iter().chain([residual]).collect(), rows, true);
        let files = self.list("kit", "/files").map(|file| {
            let (path, role) = (text(file, "path"), text(file, "role"));
            let size = self.visit.sizes.get(path).map_or_else(String::new, usize::to_string);
            let mut cells = hashed(path, text(file, "sha256"));
            cells.splice(1..1, [self.named(&format!("role_{role}"), role), size]);
            cells
        });
        let head = ["file", "role", "bytes", "sha256"].map(|key| self.t(key));
        let files = ReportTable::new(head.to_vec(), files, true);
        ReportPart { tables: vec![placed, files], ..self.part("tables") }
    }

    /// The entries of a list, two of their texts each.
    fn pairs(&self, document: &str, at: &str, [name, words]: [&str; 2]) -> Vec<String> {
        let pair = |of: &Value| escaped(&format!("{}: {}", text(of, name), text(of, words)));
        self.list(document, at).map(pair).collect()
    }

    fn missing(&self) -> ReportPart {
        if self.is_found() {
            let missing = self.pairs("assess", "/missing", ["name", "consequence"]);
            return self.listed("missing_found", missing, "nothing_missing_found");
        }
        let known = self.keys("verify", "/terms");
        let names = ErrorTerm::ALL.map(|term| term.to_string());
        let unmeasured = names.into_iter().filter(|name| !known.contains(name));
        let unmeasured = unmeasured.map(|name| format!("{name}: {}", self.t("not_measured")));
        let without = if self.is_kit_known() { "nothing_missing" } else { "no_manifest" };
        let items: Vec<String> = unmeasured.collect();
        let said = self.pairs("kit", "/omitted", ["term", "reason"]);
        let is_none = items.is_empty() && said.is_empty();
        let words = is_none.then(|| self.t(without)).into_iter().collect();
        ReportPart { words, items, said, ..self.part("missing") }
    }

    /// Whether the directory says what it holds.
    fn is_kit_known(&self) -> bool {
        !self.document("kit").is_null()
    }

    fn found(&self) -> ReportPart {
        self.listed("findings", self.findings(), "no_findings")
    }

    /// Every finding once: of two measurements both may have it, and what misses a limit is a reason.
    fn findings(&self) -> Vec<String> {
        let places: &[&str] = if self.is_found() { &["/labels"] } else { &["/causes", "/notes"] };
        let misses = self.visit.grounds.misses.iter();
        let misses: HashSet<String> = misses.map(|miss| escaped(&miss.to_string())).collect();
        let all = places.iter().flat_map(|at| self.sentences(self.main(), at));
        once(all.filter(|words| !misses.contains(words)).collect())
    }

    fn assumed(&self) -> ReportPart {
        let spaced = |words: &str| escaped(&words.replace('_', " "));
        let rows = self.visit.assumptions.iter().map(|assumed| {
            let fact = format!("{}: {}", spaced(&assumed.fact), spaced(&assumed.value));
            vec![fact, escaped(&assumed.consequence)]
        });
        let head = vec![String::new(), self.t("if_wrong")];
        let table = ReportTable { is_english: true, ..ReportTable::new(head, rows, true) };
        ReportPart { tables: vec![table], ..self.part("assumptions") }
    }

    fn undo(&self) -> ReportPart {
        let is_back = |file: &&Value| ["rollback", "disable"].contains(&text(file, "role"));
        let files = self.list("kit", "/files").filter(is_back);
        let items: Vec<String> = files.map(|file| escaped(text(file, "path"))).collect();
        let words = match (self.is_kit_known(), items.is_empty()) {
            (false, _) => "no_manifest",
            (true, true) => "undo_hand",
            (true, false) => "undo_words",
        };
        ReportPart { words: vec![self.t(words)], items, ..self.part("undo") }
    }

    /// What was read now, what the kit was made from, what was measured afterwards.
    fn provenance(&self) -> ReportPart {
        let own = self.visit.inputs.iter().map(|file| hashed(&file.path, &file.sha256));
        let stated = self.list("kit", "/inputs").chain(self.list("verify", "/after"));
        let stated = stated.map(|file| hashed(text(file, "path"), text(file, "sha256")));
        let head = vec![self.t("file"), self.t("sha256")];
        let table = ReportTable::new(head, once(own.chain(stated).collect()), true);
        ReportPart { tables: vec![table], ..self.part("provenance") }
    }

    /// Sentences of the program, or the words of a key where there are none.
    fn listed(&self, id: &'static str, said: Vec<String>, without: &str) -> ReportPart {
        let words = said.is_empty().then(|| self.t(without));
        ReportPart { words: words.into_iter().collect(), said, ..self.part(id) }
    }
}
