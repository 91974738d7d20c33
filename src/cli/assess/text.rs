//! The page of `nonius assess` for people.

use super::Page;
use crate::assessment::{Assessment, Contribution, Histogram, Windows};
use crate::axis::{Axis, PerAxis};
use crate::cli::show::{self, Column, table};
use crate::definitions::Definitions;
use crate::diagonal::Diagonal;
use crate::volume_model::Component;

pub(super) fn text(page: &Page) -> String {
    let before = &page.before;
    let after = page.after.as_ref().map(|after| &after.assessment);
    show::paragraphs(&[
        heading(page),
        headline(before, after),
        figures(&before.definitions, after.map(|a| &a.definitions)),
        worst_pair(&before.definitions),
        contributions(before, after),
        windows(before, after),
        histogram(before, after),
        tables(page),
        missing(page),
        labels(page),
    ])
}

fn heading(page: &Page) -> String {
    let ends = Axis::ALL.map(|axis| {
        let (low, high) = page.volume.range(axis);
        format!("{axis} {low} … {high}")
    });
    let n = page.before.definitions.grid;
    let chain = match page.volume.chain_is_stated {
        true => page.volume.chain.to_string(),
        false => "not stated".to_string(),
    };
    format!(
        "{}, chain {}\nvolume {} mm; {} x {} x {} nodes",
        page.name,
        chain,
        ends.join(", "),
        n.x,
        n.y,
        n.z
    )
}

/// The answer in one sentence.
fn headline(before: &Assessment, after: Option<&Assessment>) -> String {
    let d = &before.definitions;
    let mut line = format!(
        "volumetric accuracy {:.3} µm: no two places of the volume differ by more in their error",
        d.va.um
    );
    if let Some(after) = after {
        line.push_str(&format!(
            "\nwith the tables {:.3} µm",
            after.definitions.va.um
        ));
    }
    line.push_str("\nframe: as given, nothing was rotated. All figures but the length error change with the alignment of the axes");
    line
}

fn figures(before: &Definitions, after: Option<&Definitions>) -> String {
    let mut columns = vec![Column::Left("figure"), Column::Right("µm")];
    if after.is_some() {
        columns.push(Column::Right("with tables/µm"));
    }
    columns.push(Column::Left("what it is"));
    let first = rows(before);
    let second = after.map(rows);
    let rows = first.into_iter().enumerate().map(|(index, row)| {
        let mut cells = vec![row.0, row.1];
        if let Some(other) = second.as_ref().and_then(|rows| rows.get(index)) {
            cells.push(other.1.clone());
        }
        cells.push(row.2);
        cells
    });
    table(&columns, rows)
}

/// Name, value and meaning of every figure.
fn rows(d: &Definitions) -> Vec<(String, String, String)> {
    let some = |value: Option<f64>| value.map_or_else(|| "not measured".to_string(), um);
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String, what: &str| {
        rows.push((name.to_string(), value, what.to_string()));
    };
    row("VA", um(d.va.um), "largest difference of two error vectors");
    let length = if d.length.exact {
        "largest error of a distance of two nodes; independent of the alignment of the axes"
    } else {
        "largest error of a distance that was found (at least; VA at most); independent of the alignment"
    };
    row("length error", um(d.length.um), length);
    for axis in Axis::ALL {
        row(
            &format!("range {axis}"),
            um(d.ranges_um[axis]),
            &format!("max - min of the error in {axis}"),
        );
    }
    row("box", um(d.box_um), "root of the squared ranges");
    let from = format!("largest error seen from {}", place(d.origin_mm));
    row("largest from", um(d.from_origin_um), &from);
    row(
        "proposed",
        um(d.proposed_um),
        "paper 000 §II with the whole vector: |max e| + |min e|",
    );
    row(
        "existing",
        some(d.by_component.existing),
        "paper 000 §I: nine maxima and nine minima, each as root of squares",
    );
    row(
        "ELSv",
        some(d.by_component.elsv),
        "ranges of the nine, summed in each direction, then root of squares",
    );
    row(
        "ELv",
        some(d.by_component.elv),
        "ranges of EXX, EYY, EZZ, root of squares: positioning alone",
    );
    for diagonal in Diagonal::ALL {
        row(
            &format!("diagonal {diagonal}"),
            um(d.diagonals_um[diagonal]),
            "max - min along it",
        );
    }
    rows
}

fn worst_pair(d: &Definitions) -> String {
    let [p, q] = d.va.places_mm;
    let e = d.va.difference_um;
    let [a, b] = d.length.places_mm;
    format!(
        "largest difference between {} and {}: {:+.3}, {:+.3}, {:+.3} µm in X, Y, Z\nlargest error of a length between {} and {}",
        place(p),
        place(q),
        e.x + 0.0,
        e.y + 0.0,
        e.z + 0.0,
        place(a),
        place(b)
    )
}

fn place(place: PerAxis<f64>) -> String {
    format!(
        "({}, {}, {}) mm",
        short(place.x),
        short(place.y),
        short(place.z)
    )
}

fn short(mm: f64) -> f64 {
    (mm * 1000.0).round() / 1000.0 + 0.0
}

/// Parts and changes of VA below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.000_5;

fn contributions(before: &Assessment, after: Option<&Assessment>) -> String {
    let mut columns = vec![
        Column::Left("error"),
        Column::Right("part of VA/µm"),
        Column::Right("%"),
        Column::Right("VA without it/µm"),
    ];
    if after.is_some() {
        columns.push(Column::Right("part with tables/µm"));
    }
    let va = before.definitions.va.um;
    let with = |component: Component| {
        let mut parts = after?.contributions.iter();
        let part = parts.find(|part| part.component == component)?;
        Some(um(part.um))
    };
    let row = |part: &Contribution| {
        let share = if va > 0.0 { 100.0 * part.um / va } else { 0.0 };
        let mut cells = vec![
            error_name(part.component),
            um(part.um),
            format!("{:.2}", share + 0.0),
            um(part.va_without_um),
        ];
        cells.extend(after.map(|_| with(part.component).unwrap_or_default()));
        cells
    };
    let acts = |part: &&Contribution| {
        part.um.abs() >= SHOWN_UM || (part.va_without_um - va).abs() >= SHOWN_UM
    };
    let (acting, idle): (Vec<&Contribution>, Vec<&Contribution>) =
        before.contributions.iter().partition(acts);
    let mut text = format!(
        "{}\n  the parts add up to VA; a negative one works against the others",
        table(&columns, acting.into_iter().map(row))
    );
    if !idle.is_empty() {
        let names: Vec<String> = idle.iter().map(|part| part.component.to_string()).collect();
        text.push_str(&format!(
            "\n  measured, without effect on VA: {}",
            names.join(", ")
        ));
    }
    text
}

/// A figure with the digits of the page.
fn um(um: f64) -> String {
    format!("{:.3}", um + 0.0)
}

/// Its name, and that of ISO 230-1 where it is another.
fn error_name(component: Component) -> String {
    let (name, iso) = (component.to_string(), component.iso_name());
    if name == iso {
        name
    } else {
        format!("{name} ({iso})")
    }
}

fn windows(before: &Assessment, after: Option<&Assessment>) -> String {
    let Some(found) = &before.windows else {
        return String::new();
    };
    let size = found.size_mm;
    let line = |what: &str, w: &Windows| {
        format!(
            "{what}: best {:.3} µm at {}, worst {:.3} µm at {}, corner {:.3} µm",
            w.best.0,
            place(w.best.1),
            w.worst.0,
            place(w.worst.1),
            w.corner_um
        )
    };
    let mut lines = vec![format!(
        "volumetric accuracy of the {} sub-volumes of {} x {} x {} mm (places: corner with the smallest coordinates)",
        found.count,
        short(size.x),
        short(size.y),
        short(size.z)
    )];
    lines.push(line("  as it is", found));
    let after = after.and_then(|after| after.windows.as_ref());
    lines.extend(after.map(|w| line("  with the tables", w)));
    lines.join("\n")
}

fn histogram(before: &Assessment, after: Option<&Assessment>) -> String {
    let Some(found) = &before.histogram else {
        return String::new();
    };
    let after = after.and_then(|after| after.histogram.as_ref());
    let mut columns = vec![Column::Left("differences/µm"), Column::Right("pairs")];
    if after.is_some() {
        columns.push(Column::Right("with tables"));
    }
    let bins = found.counts.len().max(after.map_or(0, |a| a.counts.len()));
    let rows = (0..bins).map(|bin| {
        #[allow(clippy::cast_precision_loss, reason = "few bins")]
        let from = bin as f64 * found.bin_um;
        let count = |h: &Histogram| format!("{:.0}", h.counts.get(bin).copied().unwrap_or(0.0));
        let mut row = vec![
            format!("{} … {}", short(from), short(from + found.bin_um)),
            count(found),
        ];
        row.extend(after.map(count));
        row
    });
    let how = match &found.sampled {
        None => format!("all {} pairs of nodes were counted", found.pairs),
        Some((drawn, errors)) => {
            let largest = errors.iter().copied().fold(0.0, f64::max);
            format!(
                "estimated from {drawn} of {} pairs; largest standard error of a bin {largest:.0}",
                found.pairs
            )
        }
    };
    format!("{}\n  {how}", table(&columns, rows))
}

fn tables(page: &Page) -> String {
    let Some(after) = &page.after else {
        return String::new();
    };
    let mut lines = vec![format!(
        "with tables: {}, read back from their bytes; angular errors stay",
        after.from
    )];
    if !after.disagreements.is_empty() {
        lines.push("job and tables DISAGREE:".to_string());
        lines.extend(
            after
                .disagreements
                .iter()
                .map(|words| format!("  - {words}")),
        );
    }
    lines.join("\n")
}

fn missing(page: &Page) -> String {
    let missing = page.volume.missing();
    if missing.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = missing
        .iter()
        .map(|m| format!("  {}: {}", m.name, m.consequence))
        .collect();
    format!(
        "not measured, so left out of every figure:\n{}",
        lines.join("\n")
    )
}

fn labels(page: &Page) -> String {
    let lines: Vec<String> = page
        .volume
        .labels
        .iter()
        .map(|label| format!("note: {label}"))
        .collect();
    lines.join("\n")
}
