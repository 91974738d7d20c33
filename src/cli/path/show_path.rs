//! What `nonius path` prints, for people and for scripts.

use super::{Followed, Page};
use crate::axis::Axis;
use crate::cli::show::{self, Column, table};
use crate::manifest::picometres;
use crate::tool_path::{Channel, Extreme};
use serde_json::{Map, Value, json};

pub(super) fn text(page: &Page) -> String {
    let after = page.after.as_ref().map(|(_, after, _)| after);
    show::paragraphs(&[
        heading(page),
        headline(&page.before, after),
        extremes("as it is", &page.before),
        page.after
            .as_ref()
            .map_or_else(String::new, |(from, after, _)| {
                extremes(&format!("with {from}"), after)
            }),
        outside(page),
        notes(page),
    ])
}

fn heading(page: &Page) -> String {
    let s = &page.before.summary;
    let mut counts = vec![
        counted(s.lines, "straight move", ""),
        counted(s.arcs, "arc", ""),
    ];
    if page.ran.holes > 0 {
        counts.push(counted(page.ran.holes, "hole", ""));
    }
    if s.rapids_left_out > 0 {
        counts.push(counted(s.rapids_left_out, "rapid move", " left out"));
    }
    format!(
        "{} on {}\npath {:.3} mm: {}",
        page.program,
        page.inputs.job.machine.name,
        s.length_mm,
        counts.join(", ")
    )
}

fn counted(count: u64, one: &str, more: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {one}{plural}{more}")
}

fn headline(before: &Followed, after: Option<&Followed>) -> String {
    let longest = |followed: &Followed| {
        followed
            .summary
            .range(Channel::Length)
            .map_or(0.0, |r| r.max.um)
    };
    let mut lines = vec![
        format!("largest error {:.3} µm", longest(before)),
        format!(
            "profile accuracy {:.3} µm: no two samples of the path differ by more in their error",
            before.accuracy_um
        ),
    ];
    if let Some(after) = after {
        lines.push(format!(
            "with the tables: largest error {:.3} µm, profile accuracy {:.3} µm",
            longest(after),
            after.accuracy_um
        ));
    }
    lines.join("\n")
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
        let [x, y, z] = e.place.map(|mm| mm + 0.0);
        [
            format!("{:+.3}", e.um + 0.0),
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

fn outside(page: &Page) -> String {
    let lines = outside_sentences(page);
    lines.join("\n")
}

fn outside_sentences(page: &Page) -> Vec<String> {
    let outside = page.before.summary.outside.iter();
    let sentence = |o: &crate::tool_path::Outside| {
        format!(
            "not measured: the path reaches {} {:.3} … {:.3} mm from line {} on, measured is {} … {} mm; beyond it the end values are held",
            Axis::ALL[o.axis],
            o.reached_mm.0,
            o.reached_mm.1,
            o.line,
            o.measured_mm.0,
            o.measured_mm.1
        )
    };
    outside.map(sentence).collect()
}

/// What a reader of the figures has to know.
fn remarks(page: &Page) -> Vec<String> {
    let path = &page.inputs.job.path;
    let s = &page.before.summary;
    let mut notes = page.ran.notes.clone();
    notes.push("the machine is taken to be where the program sends it: no following error, no reversal (mean of the directions), no temperature".to_string());
    if path.start.is_none() {
        notes.push(
            "the axes start at the reference: `start_mm` is not stated in [path]".to_string(),
        );
    }
    if s.with_tool && path.measured_tool_mm.is_none() {
        notes.push("the errors are taken as measured with a tool of length 0: `measured_tool_mm` is not stated in [path]".to_string());
    }
    if s.arcs > 0 {
        notes.push(format!("arcs are followed on chords within {} mm; their tangent and normal are those of the chords", path.chord_mm));
    }
    let every = if s.kept_every > 1 {
        format!(
            "every {}th of them makes the profile accuracy",
            s.kept_every
        )
    } else {
        "all of them make the profile accuracy".to_string()
    };
    notes.push(format!(
        "{} samples at most {} mm apart: {every}",
        s.samples, path.sample_mm
    ));
    if !path.datum.is_empty() {
        notes.push(format!(
            "the mean error at {} probed places is subtracted",
            path.datum.len()
        ));
    }
    let doubts = page.inputs.model.doubts(|_| true);
    notes.extend(doubts.into_iter().map(|doubt| format!("doubtful: {doubt}")));
    notes.extend(page.volume.labels.iter().cloned());
    if let Some((_, _, disagreements)) = &page.after {
        notes.extend(
            disagreements
                .iter()
                .map(|words| format!("the tables: {words}")),
        );
    }
    notes
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

pub(super) fn document(page: &Page) -> Value {
    let mut document = Map::new();
    document.insert("schema".to_string(), json!(1));
    document.insert("machine".to_string(), json!(page.inputs.job.machine.name));
    document.insert("program".to_string(), json!(page.program));
    document.insert("blocks".to_string(), json!(page.ran.blocks));
    document.insert("holes".to_string(), json!(page.ran.holes));
    document.extend(figures(&page.before));
    document.insert("outside".to_string(), json!(outside_sentences(page)));
    let missing: Vec<String> = page.volume.missing().into_iter().map(|m| m.name).collect();
    document.insert("missing".to_string(), json!(missing));
    document.insert("notes".to_string(), json!(remarks(page)));
    let after = page.after.as_ref().map(|(from, after, disagreements)| {
        let mut map = Map::new();
        map.insert("tables".to_string(), json!(from));
        map.extend(figures(after));
        map.insert("disagreements".to_string(), json!(disagreements));
        Value::Object(map)
    });
    document.insert("after".to_string(), json!(after));
    Value::Object(document)
}

fn figures(followed: &Followed) -> Map<String, Value> {
    let s = &followed.summary;
    let extreme = |e: &Extreme| json!({"um": picometres(e.um), "at_mm": e.place, "line": e.line});
    let mut ranges = Map::new();
    for channel in Channel::ALL {
        let range = s.range(channel);
        let key = if channel == Channel::Length {
            "e"
        } else {
            channel.name()
        };
        let value = range.map(|r| json!({"min": extreme(&r.min), "max": extreme(&r.max)}));
        ranges.insert(key.to_string(), json!(value));
    }
    let mut figures = Map::new();
    figures.insert("length_mm".to_string(), json!(s.length_mm));
    figures.insert(
        "moves".to_string(),
        json!({"straight": s.lines, "arcs": s.arcs, "rapid_left_out": s.rapids_left_out}),
    );
    figures.insert("extremes".to_string(), Value::Object(ranges));
    figures.insert(
        "profile_accuracy_um".to_string(),
        json!(picometres(followed.accuracy_um)),
    );
    figures.insert("samples".to_string(), json!(s.samples));
    figures.insert("samples_kept_every".to_string(), json!(s.kept_every));
    figures
}
