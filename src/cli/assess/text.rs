//! The page of `nonius assess` for people.

use super::measured::{ERRORS, count, shows, unknown_axes};
use super::parts::{contributions, grouping, histogram, windows};
use super::{After, Page};
use crate::cli::show::{self, Column, table};
use crate::inputs::job::Levers;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::Diagonal;
use crate::quantity::units::{Figure, Millimetres};
use crate::volume::assessment::{Assessment, GridChoice};
use crate::volume::definitions::Definitions;

pub(super) fn text(page: &Page) -> String {
    let before = &page.before;
    let after = page.after.as_ref().map(|after| &after.assessment);
    show::paragraphs(&[
        heading(page),
        headline(page),
        figures(page),
        worst_pairs(before, after),
        contributions(page),
        windows(before, after),
        histogram(before, after),
        grouping(before, after),
        tables(page),
        missing(page),
        labels(page),
    ])
}

fn heading(page: &Page) -> String {
    let unknown = unknown_axes(&page.volume);
    let ends = Axis::ALL.map(|axis| {
        let (low, high) = page.volume.range(axis);
        if unknown.contains(&axis) {
            return format!("{axis} not measured and its travel not stated");
        }
        let bare = if page.volume.is_measured(axis) {
            ""
        } else {
            " (not measured)"
        };
        format!("{axis} {} … {} mm{bare}", short(low), short(high))
    });
    let chain = match page.volume.chain_is_stated {
        true => page.volume.chain.to_string(),
        false => "not stated".to_string(),
    };
    let mut lines = vec![
        format!("{}, chain {chain}", page.name),
        format!("volume {}; {}", ends.join(", "), nodes(page)),
    ];
    lines.extend(places(&page.basis.levers));
    lines.join("\n")
}

fn nodes(page: &Page) -> String {
    let n = page.before.definitions.grid;
    let own = page.volume.own_nodes().counts();
    let more = if page.grid == GridChoice::OwnNodes && n != own {
        ", those of the tables among them"
    } else {
        ""
    };
    format!("{} x {} x {} nodes{more}", n.x, n.y, n.z)
}

/// The stated places that levers depend on.
fn places(levers: &Levers) -> Option<String> {
    let tool = levers.tool.map(|tool| {
        let mm = PerAxis::from_fn(|axis| tool[axis].mm());
        format!("tool offset {}", place(mm))
    });
    let some = |what: &str, places: PerAxis<Option<Millimetres>>| {
        let stated = places.iter();
        let stated: Vec<String> = stated
            .filter_map(|(axis, at)| Some(format!("{axis} {}", short((*at)?.mm()))))
            .collect();
        (!stated.is_empty()).then(|| format!("{what} {} mm", stated.join(", ")))
    };
    let all = [
        tool,
        some("offsets", levers.offsets),
        some("angles zero at", levers.angles_zero),
        some("straightness optic at", levers.straightness_optic),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The answer in one sentence.
fn headline(page: &Page) -> String {
    let before = &page.before;
    let claim = if before.va_exact {
        "no two places of the volume differ by more in their error"
    } else {
        "no two of these nodes differ by more in their error; other places may"
    };
    let mut lines = vec![format!(
        "volumetric accuracy {:.3} µm: {claim}",
        before.definitions.va.um
    )];
    lines.extend(page.after.as_ref().map(with_tables));
    let measured = count(&page.volume);
    if measured < ERRORS {
        lines.push(format!(
            "{measured} of the {ERRORS} errors were measured: every figure is without the others"
        ));
    }
    let alone = page.basis.active.as_ref().zip(page.basis.without_tables_um);
    lines.extend(alone.map(|(path, um)| {
        format!("as measured, with the tables of `{path}` active; without any tables {um:.3} µm")
    }));
    lines.push(format!(
        "frame: {}. ELv, the diagonals and, to second order, the length error stay when the axes are aligned differently; the other figures change",
        page.basis.frame_words()
    ));
    lines.join("\n")
}

fn with_tables(after: &After) -> String {
    let hedge = if after.assessment.va_exact {
        ""
    } else {
        " at these nodes; other places may differ by more"
    };
    format!(
        "with the tables {:.3} µm{hedge}",
        after.assessment.definitions.va.um
    )
}

fn figures(page: &Page) -> String {
    let before = &page.before.definitions;
    let after = page.after.as_ref().map(|a| &a.assessment.definitions);
    let mut columns = vec![Column::Left("figure"), Column::Right("µm")];
    if after.is_some() {
        columns.push(Column::Right("with tables/µm"));
    }
    columns.push(Column::Left("what it is"));
    let first = rows(page, before);
    let second = after.map(|after| rows(page, after));
    let rows = first.into_iter().enumerate().map(|(index, row)| {
        let mut cells = vec![row.0, row.1];
        if let Some(other) = second.as_ref().and_then(|rows| rows.get(index)) {
            cells.push(other.1.clone());
        }
        cells.push(row.2);
        cells
    });
    let mut lines = vec![table(&columns, rows), PAPERS.to_string()];
    let mut all = [Some(before), after].into_iter().flatten();
    if all.any(|d| !d.length.exact) {
        lines.push(
            "  ≥: not every pair of nodes was compared for the length error; it is VA at most"
                .to_string(),
        );
    }
    lines.join("\n")
}

/// What the numbers of the papers mean, as far as the texts name themselves.
const PAPERS: &str = "  paper 002: Defining and computing machine tool accuracy, University of Huddersfield; 000 and 001: docs/volumetric.md";

/// Name, value and meaning of every figure.
fn rows(page: &Page, d: &Definitions) -> Vec<(String, String, String)> {
    let some = |value: Option<f64>| value.map_or_else(|| "not measured".to_string(), um);
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String, what: &str| {
        rows.push((name.to_string(), value, what.to_string()));
    };
    row(
        "VA",
        um(d.va.um),
        "largest difference of two error vectors (paper 002)",
    );
    let at_least = if d.length.exact { "" } else { "≥ " };
    row(
        "length error",
        format!("{at_least}{}", um(d.length.um)),
        "largest error of a distance of two nodes",
    );
    for axis in Axis::ALL {
        row(
            &format!("range {axis}"),
            some(shows(&page.volume, &page.basis.levers, axis).then_some(d.ranges_um[axis])),
            &format!("max - min of the error in {axis}"),
        );
    }
    row("box", um(d.box_um), "root of the squared ranges");
    let from = format!("largest error seen from {}", place(d.origin_mm));
    row("largest from", um(d.from_origin_um), &from);
    row(
        "proposed",
        um(d.proposed_um),
        "root of the squared maxima of X, Y and Z + the same of the minima (paper 000 §II, whole vector)",
    );
    row(
        "existing",
        some(d.by_component.existing),
        "nine maxima and nine minima, each as root of squares (paper 000 §I)",
    );
    row(
        "ELSv",
        some(d.by_component.elsv),
        "ranges of the nine, summed in each direction, then root of squares",
    );
    row(
        "ELv",
        some(d.by_component.elv),
        "ranges of EXX, EYY, EZZ, root of squares: positioning alone (paper 001)",
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

fn worst_pairs(before: &Assessment, after: Option<&Assessment>) -> String {
    let mut lines = vec![worst_pair(&before.definitions)];
    lines.extend(after.map(|a| format!("with the tables:\n{}", worst_pair(&a.definitions))));
    lines.join("\n")
}

fn worst_pair(d: &Definitions) -> String {
    let [p, q] = d.va.places_mm;
    let e = d.va.difference_um;
    let [a, b] = d.length.places_mm;
    format!(
        "largest difference between {} and {}: {:+.3}, {:+.3}, {:+.3} µm in X, Y, Z\nlargest error of a length between {} and {}",
        place(p),
        place(q),
        Figure(e.x),
        Figure(e.y),
        Figure(e.z),
        place(a),
        place(b)
    )
}

pub(super) fn place(place: PerAxis<f64>) -> String {
    format!(
        "({}, {}, {}) mm",
        short(place.x),
        short(place.y),
        short(place.z)
    )
}

/// Without the dust of binary fractions.
pub(super) fn short(mm: f64) -> f64 {
    Millimetres::new(mm).shown()
}

/// A figure with the digits of the page.
pub(super) fn um(um: f64) -> String {
    format!("{:.3}", (um * 1000.0).round() / 1000.0 + 0.0)
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

/// Doubts first.
fn labels(page: &Page) -> String {
    let labels = page.basis.labels.iter();
    let (doubts, notes): (Vec<&String>, Vec<&String>) =
        labels.partition(|label| label.starts_with("doubt: "));
    let notes = notes.into_iter().map(|label| format!("note: {label}"));
    let lines: Vec<String> = doubts.into_iter().cloned().chain(notes).collect();
    lines.join("\n")
}
