//! The page that is handed over: documents of the commands, pictures and texts → HTML.
//!
//! ```text
//!   JSON of verify, assess, separate, manifest ─→ figures, each with where it is from ─┐
//!   pictures ─→ SVG ───────────────────────────────────────────────────────────────────┼→ template → HTML
//!   texts of a language ───────────────────────────────────────────────────────────────┘
//! ```
//! A figure is `<span data-value="18" data-of="verify /terms/EXX/before_um">18.00</span>`: the number of
//! the document, the command and the place in its JSON, and what a person reads. Nothing is computed here.

mod grounds;
mod parts;

use super::locale::Locale;
use super::picture::Picture;
use super::svg;
use crate::control::claims::Assumption;
use crate::control::controller::Template;
use crate::inputs::job::Job;
use crate::judge::active::HashedFile;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Grounds;
use crate::kit::visit_plan::WhatDecides;
use crate::quantity::{ErrorTerm, Figure};
use crate::text::{Problems, escaped, plain};
use crate::write::emit::{self, TOOL};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What a figure is, which decides its unit and its decimals.
#[derive(Clone, Copy)]
enum FigureKind {
    /// µm in the document.
    Deviation,
    /// The same with a decimal more, against a limit.
    Reason,
    /// µm/m in the document and on the page.
    Slope,
    /// A whole number.
    Count,
}

/// Everything that goes on the page.
pub struct Report<'a> {
    /// Its words and units, which are those of its pictures.
    pub locale: Locale<'a>,
    /// The company's sign as a data URI.
    pub logo: Option<String>,
    /// A template of one's own, by its name.
    pub template: Option<Template>,
    /// The job.
    pub job: &'a Job,
    /// What was measured and found.
    pub visit: &'a Visit,
}

/// A picture with the part that it stands in.
pub type PagePicture = (&'static str, Picture);

/// What was measured and found; what is not there stays empty.
#[derive(Default)]
pub struct Visit {
    /// Name of the control.
    pub control: String,
    /// What `verify` says; `None` = as found, there are no tables to judge.
    pub verdict: Option<Verdict>,
    /// Whether any of the readings were simulated.
    pub is_rehearsal: bool,
    /// Why the figures are doubtful, none is left out.
    pub doubts: Vec<String>,
    /// Whether the tables were measured.
    pub is_measured: bool,
    /// `date` and protocol of that measurement, as the second job states them.
    pub protocol_after: Vec<(String, String)>,
    /// What the verdict is made of.
    pub grounds: Grounds,
    /// What would decide it.
    pub decides: Option<WhatDecides>,
    /// How the files differ from the job, or from their manifest.
    pub disagreements: Vec<String>,
    /// What is assumed of the control and matters, until a measurement has shown it.
    pub assumptions: Vec<Assumption>,
    /// Whether the second measurement has shown a sign that was assumed.
    pub is_sign_shown: bool,
    /// Every file that was read, with its hash.
    pub inputs: Vec<HashedFile>,
    /// The JSON of each command, by its name.
    pub documents: Value,
    /// Name and size of the files of the tables, bytes.
    pub sizes: BTreeMap<String, usize>,
    /// The pictures.
    pub pictures: Vec<PagePicture>,
    /// Why there are no figures of the volume.
    pub without_volume: Vec<String>,
    /// The files of runs of one axis.
    pub linear: Vec<String>,
}

/// What the job states of the visit, under its name.
#[derive(Serialize)]
struct VisitFact {
    label: String,
    value: String,
}

/// The verdict: its word and what it is of, the limits, why, what would decide it.
#[derive(Serialize)]
struct Answer {
    kind: &'static str,
    word: String,
    of: String,
    asked: Vec<String>,
    because: Vec<String>,
    decides: Vec<String>,
}

/// The name of the document of a file of runs, counted from 1.
pub fn linear_document(number: usize) -> String {
    format!("standards:{number}")
}

/// The column of a figure in the template, and its place in an entry of a document.
type FigureColumn = (&'static str, &'static str);

/// A line of the first page by its columns.
type FirstPageLine = BTreeMap<&'static str, String>;

const FIGURES: [FigureColumn; 4] = [
    ("found", "/before_um"),
    ("forecast", "/forecast_um"),
    ("left", "/after_um"),
    ("at_most", "/at_most_um"),
];

const SLOPES: [FigureColumn; 3] = [
    ("found", "/before_um_per_m"),
    ("left", "/after_um_per_m"),
    ("expanded", "/expanded_um_per_m"),
];

/// In place of a figure that there is not.
const NONE: &str = "\u{2013}";

const TEMPLATE: (&str, &str) =
    ("report.html.tera", include_str!("../../templates/report/report.html.tera"));

/// Text in a string of a style sheet: every mark as its number, so that none ends string or sheet.
fn style_text(text: &str) -> String {
    let one = |c: char| match c {
        c if c == ' ' || c.is_alphanumeric() => c.to_string(),
        c => format!("\\{:x} ", u32::from(c)),
    };
    plain::line(text).chars().map(one).collect()
}

impl Report<'_> {
    /// The page, self-contained: no script, nothing from elsewhere.
    pub(crate) fn html(&self) -> Result<String, Problems> {
        let context = json!({
            "lang": escaped(&self.locale.texts.language),
            "t": self.locale.texts.escaped(),
            "tool": TOOL,
            "style": svg::style(),
            "logo": self.logo.as_deref().unwrap_or_default(),
            "unit": self.unit(),
            "running": self.running(),
            "in_english": if self.is_as_said() { String::new() } else { self.t("in_english") },
            "title": self.t(if self.is_found() { "title_found" } else { "title" }),
            "machine": { "name": escaped(&self.job.machine.name) },
            "visit": self.visit(),
            "verdict": self.verdict(),
            "warnings": self.warnings(),
            "has_forecast": !self.is_found(),
            "has_left": self.visit.is_measured,
            "terms": self.lines("terms", FigureKind::Deviation, FIGURES),
            "diagonals": self.diagonals(),
            "squareness": self.lines("squareness", FigureKind::Slope, SLOPES),
            "curves": self.curves(self.visit.is_measured),
            "parts": self.parts(),
        });
        let (name, text) = TEMPLATE;
        let usual = || Template { name: name.to_string(), text: text.into() };
        Ok(emit::page(&self.template.clone().unwrap_or_else(usual), &context)?)
    }

    fn t(&self, key: &str) -> String {
        escaped(self.locale.texts.of(key))
    }

    /// The words of a key where there are any, else this text.
    fn named(&self, key: &str, text: &str) -> String {
        if self.locale.texts.has(key) { self.t(key) } else { escaped(text) }
    }

    /// Whether the page is in English, mm and µm, as the program's own sentences are.
    fn is_as_said(&self) -> bool {
        self.locale.either(self.locale.texts.language.starts_with("en"), false)
    }

    /// Machine and serial number, as the text of a style sheet.
    fn running(&self) -> String {
        let machine = &self.job.machine;
        let serial = machine.serial.iter();
        let serial = serial.map(|own| format!(", {} {own}", self.locale.texts.of("serial")));
        style_text(&format!("{}{}", machine.name, serial.collect::<String>()))
    }

    /// Whether there are no tables, only what was measured.
    fn is_found(&self) -> bool {
        self.visit.verdict.is_none()
    }

    /// The command that the figures of the first page are from.
    fn main(&self) -> &'static str {
        if self.is_found() { "assess" } else { "verify" }
    }

    fn unit(&self) -> &'static str {
        self.locale.um().sign
    }

    fn document(&self, name: &str) -> &Value {
        &self.visit.documents[name]
    }

    /// A stated length with its unit.
    fn length(&self, um: f64) -> String {
        let (metric, inch) = (self.locale.decimal(&um.to_string()), self.locale.deviation(um, 2));
        format!("{} {}", self.locale.either(metric, inch), self.unit())
    }

    /// A number of a document as the reader writes it; a dash where it is none.
    fn figure(&self, document: &str, at: &str, kind: FigureKind) -> String {
        let Some(number) = self.document(document).pointer(at).and_then(Value::as_f64) else {
            return NONE.to_string();
        };
        let words = match kind {
            FigureKind::Deviation => self.locale.deviation(number, 2),
            FigureKind::Reason => self.locale.deviation(number, 3),
            FigureKind::Slope => self.locale.decimal(&format!("{:.2}", Figure(number))),
            FigureKind::Count => format!("{:.0}", Figure(number)),
        };
        let (at, words) = (escaped(at), escaped(&words.replace('-', "\u{2212}")));
        format!("<span data-value=\"{number}\" data-of=\"{document} {at}\">{words}</span>")
    }

    /// What the second job states under a key.
    fn after(&self, key: &str) -> Option<&str> {
        let mut stated = self.visit.protocol_after.iter();
        stated.find(|(own, _)| own == key).map(|(_, value)| value.as_str())
    }

    /// What the first job states under a key; where the second states something else, both by name.
    fn both(&self, key: &str, first: Option<&str>) -> String {
        match (first.unwrap_or_default(), self.after(key).unwrap_or_default()) {
            (first, "") => first.to_string(),
            (first, after) if first == after => first.to_string(),
            ("", after) => format!("{}: {after}", self.t("left")),
            (first, after) => format!("{}: {first}; {}: {after}", self.t("found"), self.t("left")),
        }
    }

    /// What stands at the head: known keys of the protocol under their names, an empty line for those
    /// that every visit has, then all others as they are stated.
    fn visit(&self) -> Vec<VisitFact> {
        const ALWAYS: [&str; 3] = ["by", "instrument", "temperature_c"];
        let machine = &self.job.machine;
        let protocol = &self.job.measurement.protocol;
        let stated = |key: &str| {
            let mut own = protocol.iter().filter(|(own, _)| own == key);
            self.both(key, own.next().map(|(_, value)| value.as_str()))
        };
        let line = |label: String, value: String| VisitFact { label, value: escaped(&value) };
        let mut lines = vec![
            line(self.t("machine"), machine.name.clone()),
            line(self.t("serial"), machine.serial.clone().unwrap_or_default()),
            line(self.t("control"), self.visit.control.clone()),
            line(self.t("date"), self.both("date", self.job.measurement.date.as_deref())),
        ];
        lines.extend(ALWAYS.map(|key| line(self.t(key), stated(key))));
        let after = self.visit.protocol_after.iter();
        let own = |key: &&String| protocol.iter().any(|(own, _)| own == *key);
        let added = after.map(|(key, _)| key).filter(|key| !own(key) && *key != "date");
        let others = protocol.iter().map(|(key, _)| key).chain(added);
        let others = others.filter(|key| !ALWAYS.contains(&key.as_str()));
        lines.extend(others.map(|key| line(self.named(key, key), stated(key))));
        lines
    }

    fn verdict(&self) -> Answer {
        let word = match self.visit.verdict.map(Verdict::word) {
            None => "as_found",
            Some("pass") if self.job.acceptance.asks_nothing() => "nothing_asked",
            Some(word) => word,
        };
        let of = match (self.is_found(), self.visit.is_measured) {
            (true, _) => "of_found",
            (false, true) => "of_measurement",
            (false, false) => "of_forecast",
        };
        Answer {
            kind: if self.visit.is_measured || word != "pass" { word } else { "forecast" },
            word: match of == "of_forecast" && word != "nothing_asked" {
                true => self.fill("forecast_word", [("verdict", self.t(word))]),
                false => self.t(word),
            },
            of: self.t(of),
            asked: self.asked(),
            because: self.because(),
            decides: self.decides(),
        }
    }

    /// What never leaves the first page: a rehearsal, a sign that is only assumed.
    fn warnings(&self) -> Vec<String> {
        let simulated = self.visit.is_rehearsal.then(|| self.t("rehearsal"));
        let is_assumed = self.visit.assumptions.iter().any(Assumption::is_sign);
        let assumed = is_assumed.then(|| self.t("sign_assumed"));
        let date = self.after("date");
        let date = date.map_or_else(String::new, |date| format!(" ({})", escaped(date)));
        let shown = self.visit.is_sign_shown.then(|| self.fill("sign_shown", [("date", date)]));
        simulated.into_iter().chain(assumed).chain(shown).collect()
    }

    fn list(&self, document: &str, at: &str) -> impl Iterator<Item = &Value> {
        self.document(document).pointer(at).and_then(Value::as_array).into_iter().flatten()
    }

    /// A sentence, or all of a list.
    fn sentences(&self, document: &str, at: &str) -> Vec<String> {
        let own = self.document(document).pointer(at).into_iter();
        own.chain(self.list(document, at)).filter_map(Value::as_str).map(escaped).collect()
    }

    fn keys(&self, document: &str, at: &str) -> Vec<String> {
        let found = self.document(document).pointer(at).and_then(Value::as_object);
        found.map_or_else(Vec::new, |found| found.keys().cloned().collect())
    }

    /// A line for each entry of the main document: its name, its kind, its figures under the names that the template
    /// has for them.
    fn lines<const N: usize>(
        &self,
        of: &str,
        kind: FigureKind,
        figures: [FigureColumn; N],
    ) -> Vec<FirstPageLine> {
        let line = |name: String| {
            let at = |key: &str| self.figure(self.main(), &format!("/{of}/{name}{key}"), kind);
            let term = match name.as_bytes() {
                [b'E', a, b] if a == b => "positioning",
                _ => "straightness",
            };
            let words = [("name", escaped(&name.to_uppercase())), ("kind", self.t(term))];
            words.into_iter().chain(figures.map(|(column, key)| (column, at(key)))).collect()
        };
        self.keys(self.main(), &format!("/{of}")).into_iter().map(line).collect()
    }

    /// As found only where all nine errors were measured: their readings are predicted from them.
    fn diagonals(&self) -> Vec<FirstPageLine> {
        if !self.is_found() {
            return self.lines("diagonals", FigureKind::Deviation, FIGURES);
        }
        let is_complete = self.keys("assess", "/terms").len() == ErrorTerm::ALL.len();
        let figures = [("found", ""), FIGURES[1], FIGURES[2], FIGURES[3]];
        let lines = self.lines("definitions/diagonals_um", FigureKind::Deviation, figures);
        if is_complete { lines } else { Vec::new() }
    }
}
