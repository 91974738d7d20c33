//! Parts of the page of `nonius assess` below the figures: contributions, sub-volumes,
//! distribution, grouping.

use super::Page;
use super::measured::{has_no_lever, unknown_axes};
use super::text::{place, short, um};
use crate::cli::show::{Column, table};
use crate::quantity::units::Figure;
use crate::volume::assessment::{Assessment, Contribution, Histogram, Windows};
use crate::volume::volume_model::Component;

/// Parts and changes of VA below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.000_5;

pub(super) fn contributions(page: &Page) -> String {
    let before = &page.before;
    let after = page.after.as_ref().map(|after| &after.assessment);
    let mut columns = vec![
        Column::Left("error"),
        Column::Right("part of VA/µm"),
        Column::Right("%"),
        Column::Right("VA without it/µm"),
    ];
    if after.is_some() {
        columns.push(Column::Right("part with tables/µm"));
        columns.push(Column::Right("VA without it, with tables/µm"));
    }
    let va = before.definitions.va.um;
    let row = |part: &Contribution| {
        let share = if va > 0.0 { 100.0 * part.um / va } else { 0.0 };
        let mut cells = vec![
            error_name(part.component),
            um(part.um),
            format!("{:.2}", Figure(share)),
            um(part.va_without_um),
        ];
        let other = after.map(|after| with_tables(after, part.component));
        cells.extend(other.into_iter().flatten());
        cells
    };
    let acts = |part: &&Contribution| {
        let other = after.and_then(|after| Some((after, find(after, part.component)?)));
        acts(before, part) || other.is_some_and(|(after, part)| acts(after, part))
    };
    let (acting, idle): (Vec<&Contribution>, Vec<&Contribution>) =
        before.contributions.iter().partition(acts);
    let mut lines = vec![
        table(&columns, acting.into_iter().map(row)),
        "  the parts add up to VA; a negative one works against the others".to_string(),
    ];
    lines.extend(without_effect(page, &idle));
    lines.join("\n")
}

fn find(assessment: &Assessment, component: Component) -> Option<&Contribution> {
    let mut parts = assessment.contributions.iter();
    parts.find(|part| part.component == component)
}

/// Whether anything of it shows on the page.
fn acts(of: &Assessment, part: &Contribution) -> bool {
    let change = (part.va_without_um - of.definitions.va.um).abs();
    part.um.abs() >= SHOWN_UM || change >= SHOWN_UM
}

/// A table takes off squareness and straightness as one: what is left of both stands at the latter.
fn with_tables(after: &Assessment, component: Component) -> [String; 2] {
    match (find(after, component), component) {
        (Some(part), _) => [um(part.um), um(part.va_without_um)],
        (None, Component::Squareness(term)) => [format!("in {term}"), String::new()],
        (None, _) => <[String; 2]>::default(),
    }
}

/// Errors that change nothing, and angles of which nobody can say what they change.
fn without_effect(page: &Page, idle: &[&Contribution]) -> Vec<String> {
    let names = |parts: &[&&Contribution]| {
        let names: Vec<String> = parts.iter().map(|p| p.component.to_string()).collect();
        names.join(", ")
    };
    let (open, idle): (Vec<&&Contribution>, Vec<&&Contribution>) = idle
        .iter()
        .partition(|part| has_no_lever(&page.volume, &page.basis.levers, part.component));
    let mut lines = Vec::new();
    if !idle.is_empty() {
        lines.push(format!(
            "  measured, without effect on VA: {}",
            names(&idle)
        ));
    }
    if !open.is_empty() {
        let axes = unknown_axes(&page.volume);
        let axes: Vec<String> = axes.iter().map(ToString::to_string).collect();
        lines.push(format!(
            "  angles measured and not counted: {}; the travel of {}, their lever, is not stated",
            names(&open),
            axes.join(", ")
        ));
    }
    lines
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

pub(super) fn windows(before: &Assessment, after: Option<&Assessment>) -> String {
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
        "volumetric accuracy of the {} sub-volumes of {} x {} x {} mm between {} x {} x {} nodes (places: corner with the smallest coordinates)",
        found.count,
        short(size.x),
        short(size.y),
        short(size.z),
        found.grid.x,
        found.grid.y,
        found.grid.z
    )];
    lines.push(line("  as it is", found));
    let after = after.and_then(|after| after.windows.as_ref());
    lines.extend(after.map(|w| line("  with the tables", w)));
    lines.join("\n")
}

pub(super) fn histogram(before: &Assessment, after: Option<&Assessment>) -> String {
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
        let mut row = vec![
            format!("{} … {}", short(from), short(from + found.bin_um)),
            in_bin(found, bin),
        ];
        row.extend(after.map(|h| in_bin(h, bin)));
        row
    });
    let mut lines = vec![table(&columns, rows), format!("  {}", how(found))];
    lines.extend(
        after
            .filter(|after| after.sampled != found.sampled)
            .map(|after| format!("  with the tables {}", how(after))),
    );
    lines.join("\n")
}

/// Pairs of a bin; behind the last bin there are none for certain.
fn in_bin(histogram: &Histogram, bin: usize) -> String {
    let Some(count) = histogram.counts.get(bin) else {
        return "0".to_string();
    };
    let Some(count) = count else {
        return "–".to_string();
    };
    let errors = histogram.sampled.as_ref().map(|(_, errors)| errors);
    let unknown = errors.is_some_and(|errors| errors.get(bin).copied().flatten().is_none());
    let at_least = if unknown { "≥ " } else { "" };
    format!("{at_least}{count:.0}")
}

fn how(histogram: &Histogram) -> String {
    let Some((drawn, errors)) = &histogram.sampled else {
        return format!("all {} pairs of nodes were counted", histogram.pairs);
    };
    let largest = errors.iter().flatten().copied().fold(0.0, f64::max);
    #[allow(clippy::cast_precision_loss, reason = "an estimate")]
    let unseen = 3.0 * histogram.pairs as f64 / *drawn as f64;
    format!(
        "estimated from {drawn} of {} pairs; largest standard error of a bin {largest:.0}; – and ≥: no drawn pair fell there, fewer than {unseen:.0} pairs of all (3/n, 95 %) may",
        histogram.pairs
    )
}

pub(super) fn grouping(before: &Assessment, after: Option<&Assessment>) -> String {
    let line = |what: &str, of: &Assessment| {
        let found = of.grouping.as_ref()?;
        let longest = match found.longest {
            Some((um, [p, q])) => {
                format!("{um:.3} µm between {} and {}", place(p), place(q))
            }
            None => "no two vectors are kept".to_string(),
        };
        Some(format!(
            "{what}{longest}; exact {:.3} µm (kept {} of {} vectors, groups: {})",
            of.definitions.va.um, found.records, found.vectors, found.groups
        ))
    };
    let Some(found) = &before.grouping else {
        return String::new();
    };
    let mut lines = vec![format!(
        "grouping of paper 002 §4.2, tolerances {} (angle) and {} (length), for comparison only: it may miss the largest difference",
        found.angular, found.magnitude
    )];
    lines.extend(line("  as it is: ", before));
    lines.extend(after.and_then(|after| line("  with the tables: ", after)));
    lines.join("\n")
}
