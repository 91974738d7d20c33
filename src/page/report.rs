//! The page that is handed over: documents of the commands, pictures and texts → HTML.
//!
//! ```text
//!   JSON of verify, assess, separate, manifest ─→ figures, each with where it is from ─┐
//!   pictures ─→ SVG ───────────────────────────────────────────────────────────────────┼→ template → HTML
//!   texts of a language ───────────────────────────────────────────────────────────────┘
//! ```
//! A figure is `<span data-value="18" data-of="verify /terms/EXX/before_um">18.00</span>`: the number of
//! the document, the command and the place in its JSON, and what a person reads. Nothing is computed here.

use super::picture::Picture;
use super::svg;
use super::texts::Texts;
use crate::inputs::job::Job;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::{Figure, MM_PER_INCH, UM_PER_MM};
use crate::text::html::escaped;
use crate::text::problem::Problems;
use crate::write::emit::{TOOL, Templates};
use serde::Serialize;
use serde_json::{Value, json};

/// In which unit lengths are shown; documents are always in mm and µm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// mm and µm.
    Metric,
    /// Inches and millionths of an inch.
    Inch,
}

/// What a figure is, which decides its unit and its decimals.
#[derive(Clone, Copy)]
enum Kind {
    /// µm in the document.
    Deviation,
    /// µm/m in the document and on the page.
    Slope,
    /// A whole number.
    Count,
}

/// Everything that goes on the page.
pub struct Report<'a> {
    /// The words.
    pub texts: &'a Texts,
    /// The unit of lengths.
    pub shown: Shown,
    /// The company's sign as a data URI.
    pub logo: Option<String>,
    /// A template of one's own, by its name.
    pub template: Option<(String, String)>,
    /// The job.
    pub job: &'a Job,
    /// Name of the control.
    pub control: &'a str,
    /// Whether any of the readings were simulated.
    pub is_rehearsal: bool,
    /// Why the figures are doubtful: sentences of `verify`, none is left out.
    pub doubts: Vec<String>,
    /// Whether the tables were measured.
    pub is_measured: bool,
    /// The limits, and all that the verdict rests on and does not count: a sentence of `verify`.
    pub asked: String,
    /// The JSON of each command, by its name.
    pub documents: Vec<(&'static str, Value)>,
    /// Name and size of the files of the tables, bytes.
    pub sizes: Vec<(String, usize)>,
    /// The pictures by the part that they stand in.
    pub pictures: Vec<(&'static str, Picture)>,
}

/// What was found, on the first page; the part of findings has all.
const MOST_CAUSES: usize = 3;

const TEMPLATE: (&str, &str) = (
    "report.html.tera",
    include_str!("../../templates/report/report.html.tera"),
);

/// A part of the page behind the first one.
#[derive(Default, Serialize)]
struct Part {
    id: &'static str,
    title: String,
    words: Vec<String>,
    pictures: Vec<String>,
    tables: Vec<Table>,
    items: Vec<String>,
}

#[derive(Serialize)]
struct Table {
    head: Vec<String>,
    rows: Vec<Row>,
    is_words: bool,
}

#[derive(Serialize)]
struct Row {
    cells: Vec<String>,
}

impl Table {
    fn new(
        head: Vec<String>,
        rows: impl IntoIterator<Item = Vec<String>>,
        is_words: bool,
    ) -> Table {
        let rows = rows.into_iter().map(|cells| Row { cells });
        Table {
            head,
            rows: rows.collect(),
            is_words,
        }
    }
}

impl Report<'_> {
    /// The page, self-contained: no script, nothing from elsewhere.
    pub fn html(&self) -> Result<String, Problems> {
        let context = json!({
            "lang": escaped(&self.texts.language),
            "t": self.texts.escaped(),
            "tool": TOOL,
            "style": svg::STYLE,
            "logo": self.logo.as_deref().unwrap_or_default(),
            "unit": self.unit(),
            "machine": { "name": escaped(&self.job.machine.name) },
            "visit": self.visit(),
            "verdict": self.verdict(),
            "warnings": self.warnings(),
            "has_left": self.is_measured,
            "terms": self.lines("terms"),
            "diagonals": self.lines("diagonals"),
            "squareness": self.squareness(),
            "parts": self.parts(),
        });
        let own = self
            .template
            .as_ref()
            .map(|(name, text)| (name.as_str(), text.as_str()));
        let (name, template) = own.unwrap_or(TEMPLATE);
        Ok(Templates::default().page(name, template, &context)?)
    }

    fn t(&self, key: &str) -> String {
        escaped(self.texts.of(key))
    }

    fn unit(&self) -> &'static str {
        match self.shown {
            Shown::Metric => "µm",
            Shown::Inch => "µin",
        }
    }

    fn document(&self, name: &str) -> &Value {
        let found = self.documents.iter().find(|(own, _)| *own == name);
        found.map_or(&Value::Null, |(_, document)| document)
    }

    /// A stated length with its unit.
    fn length(&self, um: f64) -> String {
        match self.shown {
            Shown::Metric => format!("{um} µm"),
            Shown::Inch => format!("{:.1} µin", Figure(um * UM_PER_MM / MM_PER_INCH)),
        }
    }

    /// A number of a document as the reader writes it; a dash where it is none.
    fn figure(&self, document: &str, at: &str, kind: Kind) -> String {
        let Some(number) = self.document(document).pointer(at).and_then(Value::as_f64) else {
            return "\u{2013}".to_string();
        };
        let (factor, decimals) = match (kind, self.shown) {
            (Kind::Deviation, Shown::Metric) => (1.0, 2),
            (Kind::Deviation, Shown::Inch) => (UM_PER_MM / MM_PER_INCH, 1),
            (Kind::Slope, _) => (1.0, 2),
            (Kind::Count, _) => (1.0, 0),
        };
        let words = format!("{:.decimals$}", Figure(number * factor));
        let words = words
            .replace('.', self.texts.of("decimal"))
            .replace('-', "\u{2212}");
        format!(
            "<span data-value=\"{number}\" data-of=\"{document} {}\">{}</span>",
            escaped(at),
            escaped(&words)
        )
    }

    /// What stands at the head: known keys of the protocol under their names, an empty line for those
    /// that every visit has, then all others as they are stated.
    fn visit(&self) -> Vec<Value> {
        const ALWAYS: [&str; 3] = ["by", "instrument", "temperature_c"];
        let machine = &self.job.machine;
        let protocol = &self.job.measurement.protocol;
        let stated = |key: &str| {
            protocol
                .iter()
                .find(|(own, _)| own == key)
                .map(|(_, v)| v.clone())
        };
        let line =
            |label: String, value: String| json!({ "label": label, "value": escaped(&value) });
        let mut lines = vec![
            line(self.t("machine"), machine.name.clone()),
            line(self.t("serial"), machine.serial.clone().unwrap_or_default()),
            line(self.t("control"), self.control.to_string()),
            line(
                self.t("date"),
                self.job.measurement.date.clone().unwrap_or_default(),
            ),
        ];
        lines.extend(ALWAYS.map(|key| line(self.t(key), stated(key).unwrap_or_default())));
        let others = protocol
            .iter()
            .filter(|(key, _)| !ALWAYS.contains(&key.as_str()));
        lines.extend(others.map(|(key, value)| {
            let label = if self.texts.has(key) {
                self.t(key)
            } else {
                escaped(key)
            };
            line(label, value.clone())
        }));
        lines
    }

    fn verdict(&self) -> Value {
        let acceptance = self.job.acceptance;
        let word = self.document("verify")["verdict"]
            .as_str()
            .unwrap_or_default();
        let limits = [
            ("asked_deviation", acceptance.max_deviation_um),
            ("asked_diagonal", acceptance.max_diagonal_um),
        ];
        let is_asked = limits.iter().any(|(_, um)| um.is_some());
        let word = if word == "pass" && !is_asked {
            "nothing_asked"
        } else {
            word
        };
        let asked = limits.into_iter().filter_map(|(key, um)| {
            Some(format!("{}: \u{2264} {}", self.t(key), self.length(um?)))
        });
        json!({
            "kind": if self.is_measured || word != "pass" { word } else { "forecast" },
            "word": self.t(word),
            "of": self.t(if self.is_measured { "of_measurement" } else { "of_forecast" }),
            "asked": asked.chain([escaped(&self.asked)]).collect::<Vec<_>>(),
            "because": self.because(),
        })
    }

    /// All doubts, then the first of what does not keep a limit and of what was found.
    fn because(&self) -> Vec<String> {
        let doubts: Vec<String> = self.doubts.iter().map(|words| escaped(words)).collect();
        let causes = self.sentences("verify", "/causes", usize::MAX);
        let others = causes.into_iter().filter(|words| !doubts.contains(words));
        let others: Vec<String> = others.take(MOST_CAUSES).collect();
        [doubts, others].concat()
    }

    /// What never leaves the first page: a rehearsal, a sign that is only assumed.
    fn warnings(&self) -> Vec<String> {
        let simulated = self.is_rehearsal.then(|| self.t("rehearsal"));
        let signs = self.list("verify", "/assumptions").filter_map(|assumed| {
            let fact = assumed["fact"].as_str()?;
            let matters = assumed.get("without_effect").is_none_or(Value::is_null);
            let value = assumed["value"].as_str()?;
            (fact.ends_with("_sign") && matters).then(|| escaped(&format!("{fact} = {value}")))
        });
        let signs: Vec<String> = signs.collect();
        let signs =
            (!signs.is_empty()).then(|| format!("{} {}", self.t("sign_assumed"), signs.join(", ")));
        simulated.into_iter().chain(signs).collect()
    }

    fn list(&self, document: &str, at: &str) -> impl Iterator<Item = &Value> {
        self.document(document)
            .pointer(at)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
    }

    fn sentences(&self, document: &str, at: &str, most: usize) -> Vec<String> {
        let words = self.list(document, at).filter_map(Value::as_str);
        words.take(most).map(escaped).collect()
    }

    fn keys(&self, document: &str, at: &str) -> Vec<String> {
        let found = self
            .document(document)
            .pointer(at)
            .and_then(Value::as_object);
        found.map_or_else(Vec::new, |found| found.keys().cloned().collect())
    }

    /// The lines of terms or of diagonals.
    fn lines(&self, of: &str) -> Vec<Value> {
        let names = self.keys("verify", &format!("/{of}")).into_iter();
        let line = |name: String| {
            let at =
                |key: &str| self.figure("verify", &format!("/{of}/{name}/{key}"), Kind::Deviation);
            let kind = match name.as_bytes() {
                [b'E', a, b] if a == b => "positioning",
                _ => "straightness",
            };
            json!({
                "name": escaped(&name), "kind": self.t(kind),
                "found": at("before_um"), "forecast": at("forecast_um"), "left": at("after_um"),
                "expanded": at("expanded_um"),
            })
        };
        names.map(line).collect()
    }

    fn squareness(&self) -> Vec<Value> {
        let planes = self.keys("verify", "/squareness").into_iter();
        let line = |plane: String| {
            let at = |key: &str| {
                self.figure("verify", &format!("/squareness/{plane}/{key}"), Kind::Slope)
            };
            json!({
                "name": escaped(&plane.to_uppercase()),
                "found": at("before_um_per_m"), "left": at("after_um_per_m"),
            })
        };
        planes.map(line).collect()
    }

    fn part(&self, id: &'static str) -> Part {
        let own = self.pictures.iter().filter(|(of, _)| *of == id);
        Part {
            id,
            title: self.t(id),
            pictures: own.map(|(_, picture)| svg::inline(picture)).collect(),
            ..Part::default()
        }
    }

    /// Behind the first page; parts that would be empty are left out.
    fn parts(&self) -> Vec<Part> {
        let drawn = ["curves", "readings"].map(|id| self.part(id));
        let drawn = drawn.into_iter().filter(|part| !part.pictures.is_empty());
        let volume = (!self.document("assess").is_null()).then(|| self.volume());
        drawn
            .chain(volume)
            .chain([
                self.tables(),
                self.missing(),
                self.found(),
                self.assumed(),
                self.undo(),
                self.provenance(),
            ])
            .collect()
    }

    fn volume(&self) -> Part {
        let nodes = [0, 1, 2].map(|n| self.figure("assess", &format!("/grid/{n}"), Kind::Count));
        Part {
            words: vec![format!("{}: {}", self.t("grid"), nodes.join(" × "))],
            items: self.sentences("assess", "/labels", usize::MAX),
            ..self.part("volume")
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
                self.figure(
                    "kit",
                    &format!("/tables/{n}/grid_residual_um"),
                    Kind::Deviation,
                ),
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
                .sizes
                .iter()
                .find(|(name, _)| Some(name.as_str()) == file["path"].as_str());
            let size = size.map_or_else(String::new, |(_, bytes)| bytes.to_string());
            vec![
                text("path"),
                text("role"),
                size,
                format!("<code>{}</code>", text("sha256")),
            ]
        });
        let head = ["file", "role"].map(|key| self.t(key)).into_iter();
        let head = head.chain(["Byte".to_string(), self.t("sha256")]);
        let files = Table::new(head.collect(), files, true);
        Part {
            tables: vec![placed, files],
            ..self.part("tables")
        }
    }

    fn missing(&self) -> Part {
        let known = self.keys("verify", "/terms");
        let names = ErrorTerm::ALL.map(|term| term.to_string());
        let unmeasured = names.into_iter().filter(|name| !known.contains(name));
        let unmeasured = unmeasured.map(|name| format!("{name}: {}", self.t("not_measured")));
        let omitted = self.list("kit", "/omitted").map(|omitted| {
            let text = |key: &str| omitted[key].as_str().unwrap_or_default();
            escaped(&format!("{}: {}", text("term"), text("reason")))
        });
        let items: Vec<String> = unmeasured.chain(omitted).collect();
        match self.is_kit_known() {
            true => self.listed("missing", items, "nothing_missing"),
            false => self.listed("missing", items, "no_manifest"),
        }
    }

    /// Whether the directory says what it holds.
    fn is_kit_known(&self) -> bool {
        !self.document("kit").is_null()
    }

    fn found(&self) -> Part {
        let causes = self.sentences("verify", "/causes", usize::MAX).into_iter();
        let notes = self.sentences("verify", "/notes", usize::MAX);
        self.listed("findings", causes.chain(notes).collect(), "no_findings")
    }

    fn assumed(&self) -> Part {
        let rows = self.list("verify", "/assumptions").map(|assumed| {
            let text = |key: &str| assumed[key].as_str().map(escaped).unwrap_or_default();
            vec![
                format!("{} = {}", text("fact"), text("value")),
                text("consequence"),
            ]
        });
        let head = vec![String::new(), self.t("if_wrong")];
        let table = Table::new(head, rows, true);
        Part {
            tables: vec![table],
            ..self.part("assumptions")
        }
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
        Part {
            words: vec![self.t(words)],
            items: files,
            ..self.part("undo")
        }
    }

    fn provenance(&self) -> Part {
        let before = self.list("kit", "/inputs");
        let files = before.chain(self.list("verify", "/after")).map(|file| {
            let text = |key: &str| file[key].as_str().map(escaped).unwrap_or_default();
            vec![text("path"), format!("<code>{}</code>", text("sha256"))]
        });
        let head = vec![self.t("file"), self.t("sha256")];
        let table = Table::new(head, files, true);
        Part {
            tables: vec![table],
            ..self.part("provenance")
        }
    }

    fn listed(&self, id: &'static str, items: Vec<String>, without: &str) -> Part {
        let words = if items.is_empty() {
            vec![self.t(without)]
        } else {
            Vec::new()
        };
        Part {
            words,
            items,
            ..self.part(id)
        }
    }
}
