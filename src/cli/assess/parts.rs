//! Parts of the page of `nonius assess` below the figures: contributions, sub-volumes,
//! distribution, grouping.

use super::page::Page;
use crate::cli::screen::table;
use crate::cli::show;
use crate::quantity::axis::PerAxis;
use crate::quantity::units::{Figure, Millimetres};
use crate::volume::assessment::{Assessment, Contribution, Histogram, Sampled};
use crate::volume::volume_model::Component;

/// Parts and changes of VA below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.000_5;

pub(super) fn contributions(page: &Page) -> String {
    let before = &page.before;
    let after = page.after.as_ref().map(|after| &after.assessment);
    let with = after.map_or("", |_| "\t>part with tables/µm\t>VA without it, with tables/µm");
    let heading = format!("error\t>part of VA/µm\t>%\t>VA without it/µm{with}");
    let va = before.definitions.va_um;
    let row = |part: &Contribution| {
        let share = Figure(if va > 0.0 { 100.0 * part.um / va } else { 0.0 });
        let other = after.map(|after| with_tables(after, part.component));
        format!(
            "{}\t{}\t{share:.2}\t{}{}",
            error_name(part.component),
            um(part.um),
            um(part.va_without_um),
            other.unwrap_or_default()
        )
    };
    let acts = |part: &&Contribution| {
        let other = after.and_then(|after| Some((after, find(after, part.component)?)));
        acts(before, part) || other.is_some_and(|(after, part)| acts(after, part))
    };
    let (acting, idle): (Vec<&Contribution>, Vec<&Contribution>) =
        before.contributions.iter().partition(acts);
    let mut lines = vec![
        table(&heading, acting.into_iter().map(row)),
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
    let change = (part.va_without_um - of.definitions.va_um).abs();
    part.um.abs() >= SHOWN_UM || change >= SHOWN_UM
}

/// A table takes off squareness and straightness as one: what is left of both stands at the latter.
fn with_tables(after: &Assessment, component: Component) -> String {
    match (find(after, component), component) {
        (Some(part), _) => format!("\t{}\t{}", um(part.um), um(part.va_without_um)),
        (None, Component::Squareness(term)) => format!("\tin {term}\t"),
        (None, _) => "\t\t".to_string(),
    }
}

/// Errors that change nothing, and angles of which nobody can say what they change.
fn without_effect(page: &Page, idle: &[&Contribution]) -> Vec<String> {
    let names = |parts: &[&&Contribution]| {
        let names: Vec<String> = parts.iter().map(|p| p.component.to_string()).collect();
        names.join(", ")
    };
    let (open, idle): (Vec<&&Contribution>, Vec<&&Contribution>) =
        idle.iter().partition(|part| page.volume.has_no_lever(part.component));
    let mut lines = Vec::new();
    if !idle.is_empty() {
        let names = names(&idle);
        lines.push(format!("  measured, without effect on VA: {names}"));
    }
    if !open.is_empty() {
        let axes = page.volume.unknown_axes();
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
    if name == iso { name } else { format!("{name} ({iso})") }
}

pub(super) fn windows(page: &Page) -> String {
    let Some(found) = &page.before.windows else {
        return String::new();
    };
    let line = |(side, of): (&str, &Assessment)| {
        let found = of.windows.as_ref()?;
        let (best, best_at) = (found.min_um, place(found.min_at_mm.0));
        let (worst, worst_at) = (found.max_um, place(found.max_at_mm.0));
        let corner = found.corner_um;
        Some(format!(
            "  {side}: best {best:.3} µm at {best_at}, worst {worst:.3} µm at {worst_at}, corner {corner:.3} µm"
        ))
    };
    let by = |of: [String; 3]| of.join(" x ");
    let (size, grid) = (found.size_mm.0, found.grid.0);
    let head = format!(
        "volumetric accuracy of the {} sub-volumes of {} mm between {} nodes (places: corner with the smallest coordinates)",
        found.count,
        by([size.x, size.y, size.z].map(|mm| short(mm).to_string())),
        by([grid.x, grid.y, grid.z].map(|nodes| nodes.to_string())),
    );
    let lines = std::iter::once(head).chain(page.sides().filter_map(line));
    lines.collect::<Vec<_>>().join("\n")
}

pub(super) fn histogram(before: &Assessment, after: Option<&Assessment>) -> String {
    let Some(found) = &before.histogram else {
        return String::new();
    };
    let after = after.and_then(|after| after.histogram.as_ref());
    let with = after.map_or("", |_| "\t>with tables");
    let (own, others) = (bins(found), after.map(bins));
    let most = own.len().max(others.as_ref().map_or(0, Vec::len));
    let rows = (0..most).map(|bin| {
        let from = bin as f64 * found.bin_um;
        let other = others.as_ref().map(|others| format!("\t{}", in_bin(others, bin)));
        let (from, to) = (short(from), short(from + found.bin_um));
        let (own, other) = (in_bin(&own, bin), other.unwrap_or_default());
        format!("{from} … {to}\t{own}{other}")
    });
    let heading = format!("differences/µm\t>pairs{with}");
    let mut lines = vec![table(&heading, rows), format!("  {}", how(found))];
    lines.extend(
        after
            .filter(|after| after.sampled != found.sampled)
            .map(|after| format!("  with the tables {}", how(after))),
    );
    lines.join("\n")
}

/// Pairs of each bin.
fn bins(histogram: &Histogram) -> Vec<String> {
    let errors = histogram.sampled.as_ref().map(|sampled| &sampled.standard_errors);
    let words = |(bin, count): (usize, Option<f64>)| {
        let Some(count) = count else {
            return "–".to_string();
        };
        let unknown = errors.is_some_and(|errors| errors.get(bin).copied().flatten().is_none());
        let at_least = if unknown { "≥ " } else { "" };
        format!("{at_least}{count:.0}")
    };
    histogram.counts.each().into_iter().enumerate().map(words).collect()
}

/// Behind the last bin there are none for certain.
fn in_bin(bins: &[String], bin: usize) -> &str {
    bins.get(bin).map_or("0", String::as_str)
}

fn how(histogram: &Histogram) -> String {
    let Some(Sampled { drawn, standard_errors: errors }) = &histogram.sampled else {
        return format!("all {} pairs of nodes were counted", histogram.pairs);
    };
    let largest = errors.iter().flatten().copied().fold(0.0, f64::max);
    let unseen = 3.0 * histogram.pairs as f64 / *drawn as f64;
    format!(
        "estimated from {drawn} of {} pairs; largest standard error of a bin {largest:.0}; – and ≥: no drawn pair fell there, fewer than {unseen:.0} pairs of all (3/n, 95 %) may",
        histogram.pairs
    )
}

pub(super) fn grouping(page: &Page) -> String {
    let Some(found) = &page.before.grouping else {
        return String::new();
    };
    let line = |(side, of): (&str, &Assessment)| {
        let found = of.grouping.as_ref()?;
        let pair = found.pair_mm.map(|pair| pair.map(|at| place(at.0)));
        let longest = match found.um.zip(pair) {
            Some((um, [p, q])) => format!("{um:.3} µm between {p} and {q}"),
            None => "no two vectors are kept".to_string(),
        };
        Some(format!(
            "  {side}: {longest}; exact {:.3} µm (kept {} of {} vectors, groups: {})",
            of.definitions.va_um, found.records, found.vectors, found.groups
        ))
    };
    let head = format!(
        "grouping of paper 002 §4.2, tolerances {} (angle) and {} (length), for comparison only: it may miss the largest difference",
        found.angular_tolerance, found.magnitude_tolerance
    );
    let lines = std::iter::once(head).chain(page.sides().filter_map(line));
    lines.collect::<Vec<_>>().join("\n")
}

pub(super) fn place(place: PerAxis<f64>) -> String {
    format!("({}, {}, {}) mm", short(place.x), short(place.y), short(place.z))
}

/// Without the dust of binary fractions.
pub(super) fn short(mm: f64) -> f64 {
    Millimetres::new(mm).shown()
}

/// A figure with the digits of the page.
pub(super) fn um(um: f64) -> String {
    show::um(Some(um))
}
