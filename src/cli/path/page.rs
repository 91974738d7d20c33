//! What `nonius path` prints: the screen, and the document for scripts.

use super::samples::{Hole, Holes};
use crate::cli::outcome::joined;
use crate::cli::screen::{More, Screen, list, paragraphs, table};
use crate::cli::show;
use crate::kit::Inputs;
use crate::page::{Ink, Locale, Picture, Trace, path};
use crate::quantity::{Axis, Figure};
use crate::text::{Problem, Severity, counted, of_severity};
use crate::visit::inputs::Corrected;
use crate::volume::space::diameter::longest;
use crate::volume::tool_path::{Channel, Extreme, Outside, Profile, Summary};
use crate::volume::volume_model::VolumeModel;
use part_program::Ran;
use serde_json::{Map, Value, json};

/// What is printed.
pub(super) struct Page {
    pub(super) program: String,
    pub(super) inputs: Inputs,
    pub(super) volume: VolumeModel,
    pub(super) ran: Ran,
    pub(super) before: Followed,
    pub(super) after: Option<After>,
    pub(super) holes: Holes,
    pub(super) traces: Vec<Trace>,
}

impl Page {
    /// The error along the path, and at the worst holes.
    pub(super) fn picture(&self, locale: Locale<'_>) -> Picture {
        let hole = |hole: &Hole| {
            let of = |[x, y, _]: [f64; 3]| (x, y);
            let before = (Ink::AsFound, of(hole.error_um));
            let after = hole.after_um.map(|um| (Ink::Forecast, of(um)));
            (of(hole.at_mm), std::iter::once(before).chain(after).collect())
        };
        let holes: Vec<_> = self.holes.worst().iter().map(hole).collect();
        let machine = &self.inputs.job.machine.name;
        let heading = format!("{machine}: error along {}", self.program);
        path(locale, &heading, &self.traces, &holes)
    }
}

/// The path with tables.
pub(super) struct After {
    pub(super) tables: Corrected,
    pub(super) followed: Followed,
}

/// The path on one machine.
pub(super) struct Followed {
    pub(super) summary: Summary,
    /// Largest difference of two error vectors of the samples, µm.
    accuracy_um: f64,
}

impl Followed {
    pub(super) fn of(profile: Profile<'_>, program: &str) -> Result<Followed, Problem> {
        let summary = profile.summary();
        let Some(found) = longest(&summary.vectors) else {
            let message = format!("`{program}` holds no move that counts");
            return Err(Problem::new(message)
                .help("G1, G2, G3 and the feed moves of cycles count; with `moves = \"all\"` in [path] rapid moves too"));
        };
        Ok(Followed { accuracy_um: found.um(), summary })
    }

    fn largest_um(&self) -> f64 {
        let range = self.summary.range(Channel::Length);
        range.map_or(0.0, |range| range.max.um)
    }

    /// The figure, or what it lies between.
    fn accuracy_words(&self) -> String {
        let (least, room) = (self.accuracy_um, self.summary.room_um);
        if room <= 0.0 {
            return format!("{least:.3} µm");
        }
        let most = least + room;
        format!("between {least:.3} and {most:.3} µm (too many samples to keep all that count)")
    }

    fn figures(&self) -> Value {
        let s = &self.summary;
        let extremes = Channel::ALL.into_iter().map(|channel| {
            let key = match channel {
                Channel::Length => "e",
                channel => channel.word(),
            };
            (key.to_string(), json!(s.range(channel)))
        });
        json!({
            "length_mm": s.length_mm,
            "moves": {"straight": s.lines, "arcs": s.arcs, "rapid_left_out": s.rapids_left_out},
            "extremes": extremes.collect::<Map<_, _>>(),
            "profile_accuracy_um": self.accuracy_um,
            "profile_accuracy_at_most_um": self.accuracy_um + s.room_um,
            "samples": s.samples,
        })
    }

    fn extremes(&self, name: &str) -> String {
        let cells = |e: &Extreme| {
            let [x, y, z] = e.place.map(Figure);
            format!("{:+.3}\t{x:.3}, {y:.3}, {z:.3}\t{}", Figure(e.um), e.line)
        };
        let rows = Channel::ALL.into_iter().filter_map(|channel| {
            let range = self.summary.range(channel)?;
            let (min, max) = (cells(&range.min), cells(&range.max));
            Some(format!("{}\t{min}\t{max}", channel.word()))
        });
        let heading = "\t>min/µm\tat x, y, z/mm\t>line\t>max/µm\tat x, y, z/mm\t>line";
        format!("{name}\n{}", table(heading, rows))
    }
}

impl Page {
    pub(super) fn screen(&self) -> Screen {
        let after = self.after.as_ref();
        let disagreements = after.map_or(&[][..], |after| &after.tables.disagreements);
        let with = after.map(|after| {
            let name = format!("with {}", after.tables.from);
            after.followed.extremes(&name)
        });
        let figures = [self.before.extremes("as it is"), with.unwrap_or_default()];
        let missing: Vec<String> = missing(self);
        let left_out = format!("not measured, so left out: {}", missing.join(", "));
        let mut findings = [warnings(self), doubts(self)].concat();
        findings.extend(outside_sentences(self));
        findings.extend((!missing.is_empty()).then_some(left_out));
        findings.extend(show::notes(remarks(self)));
        findings.push(format!("note: {}", how(self)));
        let disagreements = list("job and tables DISAGREE:", disagreements);
        let verdict = [headline(self), heading(self), disagreements];
        Screen {
            verdict: verdict.join("\n").trim_end().to_string(),
            figures: paragraphs(&figures),
            findings,
            more: vec![More::new(self.holes.worst().len(), ["hole", "holes"], holes(self))],
            ..Screen::default()
        }
    }

    pub(super) fn document(&self) -> Value {
        let notes = [remarks(self), doubts(self), vec![how(self)]].concat();
        let after = self.after.as_ref().map(|after| {
            joined([
                json!({ "tables": after.tables.from }),
                after.followed.figures(),
                json!({ "disagreements": after.tables.disagreements }),
            ])
        });
        let document = json!({
            "schema": 1,
            "machine": self.inputs.job.machine.name,
            "program": self.program,
            "blocks": self.ran.blocks,
            "holes": self.ran.holes,
            "worst_holes": self.holes.worst(),
            "outside": outside_sentences(self),
            "missing": missing(self),
            "warnings": warnings(self),
            "notes": notes,
            "after": after,
        });
        joined([document, self.before.figures()])
    }
}

fn missing(page: &Page) -> Vec<String> {
    let missing = page.volume.missing().into_iter();
    missing.map(|m| m.component.to_string()).collect()
}

/// A number of things.
fn heading(page: &Page) -> String {
    let s = &page.before.summary;
    let mut counts = vec![counted(s.lines, "straight move"), counted(s.arcs, "arc")];
    if page.ran.holes > 0 {
        counts.push(counted(page.ran.holes, "hole"));
    }
    if s.rapids_left_out > 0 {
        counts.push(format!("{} left out", counted(s.rapids_left_out, "rapid move")));
    }
    format!(
        "{} on {}\npath {:.3} mm: {}; places in machine coordinates",
        page.program,
        page.inputs.job.machine.name,
        s.length_mm,
        counts.join(", ")
    )
}

fn headline(page: &Page) -> String {
    let (before, after) = (&page.before, page.after.as_ref());
    let mut lines = vec![
        format!("largest error {:.3} µm", before.largest_um()),
        format!(
            "profile accuracy {}: no two samples of the path differ by more in their error",
            before.accuracy_words()
        ),
    ];
    if let Some(after) = after {
        lines.push(format!(
            "with the tables: largest error {:.3} µm, profile accuracy {}",
            after.followed.largest_um(),
            after.followed.accuracy_words()
        ));
    }
    let datum = &page.inputs.job.path.datum;
    if !datum.is_empty() {
        lines.push(format!(
            "all of them less the mean error at {} ([[path.datum]])",
            counted(datum.len(), "probed place")
        ));
    }
    lines.join("\n")
}

/// What may make the figures those of another machine.
fn warnings(page: &Page) -> Vec<String> {
    let tool = page.inputs.job.measurement.levers.tool;
    let stated = tool.is_some_and(|tool| Axis::ALL.iter().any(|axis| tool[*axis].mm().abs() > 0.0));
    let twice = stated && page.before.summary.with_tool;
    let words = "CHECK: `tool_offset_mm` of [measurement] and the tool length of G43 both move the tool point; state the way to the tool in one of them only";
    twice.then(|| words.to_string()).into_iter().collect()
}

fn holes(page: &Page) -> String {
    let worst = page.holes.worst();
    if worst.is_empty() {
        return String::new();
    }
    let (shown, all) = (worst.len() as u64, page.ran.holes);
    let what = match shown < all {
        true => format!("the {shown} worst of {all} holes (`-o` writes all)"),
        false => "holes, the worst first".to_string(),
    };
    let column = page.after.as_ref().map_or("", |_| "\t>with tables |e|/µm");
    let heading = ">hole\t>line\tbottom at x, y, z/mm\t>ex/µm\t>ey/µm\t>ez/µm\t>|e|/µm";
    let rows = worst.iter().map(hole);
    format!("{what}\n{}", table(&format!("{heading}{column}"), rows))
}

fn hole(hole: &Hole) -> String {
    let [x, y, z] = hole.at_mm.map(Figure);
    let [ex, ey, ez] = hole.error_um.map(Figure);
    let after = hole.after_e_um.map_or_else(String::new, |e| format!("\t{e:.3}"));
    format!(
        "{}\t{}\t{x:.3}, {y:.3}, {z:.3}\t{ex:+.3}\t{ey:+.3}\t{ez:+.3}\t{:.3}{after}",
        hole.number, hole.line, hole.e_um
    )
}

fn outside_sentences(page: &Page) -> Vec<String> {
    let sentence = |o: &Outside| {
        let (low, high) = o.measured_mm;
        let below = (o.reached_mm.0 < low).then(|| format!("{:.3} mm", Figure(o.reached_mm.0)));
        let above = (o.reached_mm.1 > high).then(|| format!("{:.3} mm", Figure(o.reached_mm.1)));
        let reached: Vec<String> = below.into_iter().chain(above).collect();
        format!(
            "not measured: the path reaches {} = {}, first in line {}, measured is {low} … {high} mm; beyond it each curve, squareness included, is held at its end",
            Axis::ALL[o.axis],
            reached.join(" and "),
            o.line,
        )
    };
    page.before.summary.outside.iter().map(sentence).collect()
}

/// What a reader of the figures has to know.
fn remarks(page: &Page) -> Vec<String> {
    let path = &page.inputs.job.path;
    let s = &page.before.summary;
    let mut notes: Vec<String> = page.ran.notes.clone();
    let mut unstated = Vec::new();
    if !path.has_start {
        unstated.push("`start_mm` (the axes start at the reference)");
    }
    if s.with_tool && path.measured_tool_mm.is_none() {
        unstated
            .push("`measured_tool_mm` (the errors are taken as measured with a tool of length 0)");
    }
    if !unstated.is_empty() {
        notes.push(format!("not stated in [path]: {}", unstated.join(", ")));
    }
    if s.with_tool && !path.datum.is_empty() {
        notes.push("the datum is taken as probed with a tool of the measured length".to_string());
    }
    let labels = page.volume.labels.iter().filter(|label| label.severity() != Severity::Doubt);
    notes.extend(labels.map(ToString::to_string));
    let notes_after = page.after.iter().flat_map(|after| &after.tables.notes);
    notes.extend(notes_after.map(ToString::to_string));
    notes
}

/// Why the figures may be wrong.
fn doubts(page: &Page) -> Vec<String> {
    let doubts = of_severity(&page.volume.labels, Severity::Doubt);
    doubts.iter().map(ToString::to_string).collect()
}

/// What holds for every path.
fn how(page: &Page) -> String {
    let path = &page.inputs.job.path;
    let s = &page.before.summary;
    let mut parts =
        vec![format!("{} at most {} mm apart", counted(s.samples, "sample"), path.sample_mm)];
    if s.arcs > 0 {
        parts.push(format!("arcs on chords within {} mm", path.chord_mm));
    }
    parts.push(
        "without following errors, reversal (mean of the directions) and temperature".to_string(),
    );
    parts.join("; ")
}
