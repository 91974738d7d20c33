//! The page of `nonius path` for people.

use super::holes::{Hole, length};
use super::{Followed, Page};
use crate::cli::show::{self, Column, table};
use crate::quantity::axis::Axis;
use crate::quantity::units::Figure;
use crate::volume::tool_path::{Channel, Extreme, Outside};

pub(super) fn text(page: &Page) -> String {
    show::paragraphs(&[
        heading(page),
        headline(page),
        warnings(page).join("\n"),
        disagreements(page),
        extremes("as it is", &page.before),
        page.after.as_ref().map_or_else(String::new, |after| {
            extremes(&format!("with {}", after.from), &after.followed)
        }),
        holes(page),
        outside_sentences(page).join("\n"),
        notes(page),
    ])
}

/// A number of things.
fn counted(number: u64, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

fn heading(page: &Page) -> String {
    let s = &page.before.summary;
    let mut counts = vec![counted(s.lines, "straight move"), counted(s.arcs, "arc")];
    if page.ran.holes > 0 {
        counts.push(counted(page.ran.holes, "hole"));
    }
    if s.rapids_left_out > 0 {
        counts.push(format!(
            "{} left out",
            counted(s.rapids_left_out, "rapid move")
        ));
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
        format!("largest error {:.3} µm", largest(before)),
        format!(
            "profile accuracy {}: no two samples of the path differ by more in their error",
            accuracy(before)
        ),
    ];
    if let Some(after) = after {
        lines.push(format!(
            "with the tables: largest error {:.3} µm, profile accuracy {}",
            largest(&after.followed),
            accuracy(&after.followed)
        ));
    }
    let datum = &page.inputs.job.path.datum;
    if !datum.is_empty() {
        lines.push(format!(
            "all of them less the mean error at {} ([[path.datum]])",
            counted(datum.len() as u64, "probed place")
        ));
    }
    lines.join("\n")
}

fn largest(followed: &Followed) -> f64 {
    let range = followed.summary.range(Channel::Length);
    range.map_or(0.0, |range| range.max.um)
}

/// The figure, or what it lies between.
fn accuracy(followed: &Followed) -> String {
    let (least, room) = (followed.accuracy_um, followed.summary.room_um);
    if room > 0.0 {
        format!(
            "between {least:.3} and {:.3} µm (too many samples to keep all that count)",
            least + room
        )
    } else {
        format!("{least:.3} µm")
    }
}

/// What may make the figures those of another machine.
pub(super) fn warnings(page: &Page) -> Vec<String> {
    let tool = page.inputs.job.measurement.levers.tool;
    let stated = tool.is_some_and(|tool| Axis::ALL.iter().any(|axis| tool[*axis].mm().abs() > 0.0));
    if stated && page.before.summary.with_tool {
        vec!["CHECK: `tool_offset_mm` of [measurement] and the tool length of G43 both move the tool point; state the way to the tool in one of them only".to_string()]
    } else {
        Vec::new()
    }
}

fn disagreements(page: &Page) -> String {
    let found = page.after.iter().flat_map(|after| &after.disagreements);
    let lines: Vec<String> = found.map(|words| format!("  - {words}")).collect();
    if lines.is_empty() {
        return String::new();
    }
    format!("job and tables DISAGREE:\n{}", lines.join("\n"))
}

fn extremes(name: &str, followed: &Followed) -> String {
    let columns = [
        Column::Left(""),
        Column::Right("min/µm"),
        Column::Left("at x, y, z/mm"),
        Column::Right("line"),
        Column::Right("max/µm"),
        Column::Left("at x, y, z/mm"),
        Column::Right("line"),
    ];
    let cells = |e: &Extreme| {
        let [x, y, z] = e.place.map(Figure);
        [
            format!("{:+.3}", Figure(e.um)),
            format!("{x:.3}, {y:.3}, {z:.3}"),
            e.line.to_string(),
        ]
    };
    let rows = Channel::ALL.into_iter().filter_map(|channel| {
        let range = followed.summary.range(channel)?;
        let name = [channel.name().to_string()];
        Some(
            name.into_iter()
                .chain(cells(&range.min))
                .chain(cells(&range.max))
                .collect(),
        )
    });
    format!("{name}\n{}", table(&columns, rows))
}

fn holes(page: &Page) -> String {
    let worst = page.holes.worst();
    if worst.is_empty() {
        return String::new();
    }
    let mut columns = vec![
        Column::Right("hole"),
        Column::Right("line"),
        Column::Left("bottom at x, y, z/mm"),
        Column::Right("ex/µm"),
        Column::Right("ey/µm"),
        Column::Right("ez/µm"),
        Column::Right("|e|/µm"),
    ];
    if page.after.is_some() {
        columns.push(Column::Right("with tables |e|/µm"));
    }
    let shown = worst.len() as u64;
    let what = if shown < page.ran.holes {
        format!(
            "the {shown} worst of {} holes (`-o` writes all)",
            page.ran.holes
        )
    } else {
        "holes, the worst first".to_string()
    };
    format!("{what}\n{}", table(&columns, worst.iter().map(hole)))
}

fn hole(hole: &Hole) -> Vec<String> {
    let [x, y, z] = hole.place.map(Figure);
    let mut cells = vec![
        hole.number.to_string(),
        hole.line.to_string(),
        format!("{x:.3}, {y:.3}, {z:.3}"),
    ];
    cells.extend(hole.error_um.map(|um| format!("{:+.3}", Figure(um))));
    cells.push(format!("{:.3}", length(hole.error_um)));
    cells.extend(hole.after_um.map(|after| format!("{:.3}", length(after))));
    cells
}

pub(super) fn outside_sentences(page: &Page) -> Vec<String> {
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
pub(super) fn remarks(page: &Page) -> Vec<String> {
    let path = &page.inputs.job.path;
    let s = &page.before.summary;
    let mut notes: Vec<String> = page.ran.notes.iter().map(ToString::to_string).collect();
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
    let doubts = page.inputs.model.doubts(|_| true);
    notes.extend(doubts.into_iter().map(|doubt| format!("doubtful: {doubt}")));
    notes.extend(page.volume.labels.iter().cloned());
    notes.extend(page.after.iter().flat_map(|after| after.notes.clone()));
    notes.push(how(page));
    notes
}

/// What holds for every path.
fn how(page: &Page) -> String {
    let path = &page.inputs.job.path;
    let s = &page.before.summary;
    let mut parts = vec![format!(
        "{} at most {} mm apart",
        counted(s.samples, "sample"),
        path.sample_mm
    )];
    if s.arcs > 0 {
        parts.push(format!("arcs on chords within {} mm", path.chord_mm));
    }
    parts.push(
        "without following errors, reversal (mean of the directions) and temperature".to_string(),
    );
    parts.join("; ")
}

fn notes(page: &Page) -> String {
    let mut lines: Vec<String> = remarks(page)
        .iter()
        .map(|note| format!("note: {note}"))
        .collect();
    let missing = page.volume.missing();
    if !missing.is_empty() {
        let names: Vec<String> = missing.into_iter().map(|m| m.name).collect();
        lines.push(format!("not measured, so left out: {}", names.join(", ")));
    }
    lines.join("\n")
}
