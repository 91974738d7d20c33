//! `nonius assess --format json` (contract §5). Lengths are rounded where a document is printed.

use super::page::{After, Basis, Page, count, shows, unknown_axes};
use crate::cli::outcome::joined;
use crate::quantity::axis::{Axis, PerAxis};
use crate::volume::assessment::{Assessment, Baseline, Contribution, Histogram, Windows};
use serde_json::{Value, json};

pub(in crate::cli) fn document(page: &Page) -> Value {
    let chain = page.volume.chain_is_stated.then_some(page.volume.chain);
    let levers = &page.basis.levers;
    let tool = levers.tool.map(|tool| Axis::ALL.map(|axis| tool[axis]));
    let missing = page.volume.missing().into_iter();
    let missing: Vec<Value> = missing
        .map(|m| json!({"name": m.component.to_string(), "consequence": m.consequence}))
        .collect();
    let labels = page.basis.doubts.iter().chain(&page.basis.labels);
    joined([
        json!({
            "schema": 1,
            "machine": page.name,
            "chain": chain.map(|chain| chain.to_string()),
            "frame": page.basis.frame,
            "volume_mm": volume(page),
            "tool_offset_mm": tool,
            "offsets_mm": levers.offsets,
            "angles_zero_mm": levers.angles_zero,
            "straightness_optic_mm": levers.straightness_optic,
            "active": active(&page.basis),
            "errors_measured": count(&page.volume),
            "terms": page.found.terms,
            "squareness": page.found.squareness,
        }),
        figures(page, &page.before),
        json!({
            "missing": missing,
            "labels": labels.collect::<Vec<_>>(),
            "after": page.after.as_ref().map(|after| of_after(page, after)),
        }),
    ])
}

/// Range of each axis; null where nothing was measured along it and no travel is stated.
fn volume(page: &Page) -> PerAxis<Option<(f64, f64)>> {
    let unknown = unknown_axes(&page.volume);
    PerAxis::from_fn(|axis| (!unknown.contains(&axis)).then(|| page.volume.range(axis)))
}

fn active(basis: &Basis) -> Option<Value> {
    let tables = basis.active.as_ref()?;
    Some(json!({"tables": tables, "va_without_um": basis.without_tables_um}))
}

fn of_after(page: &Page, after: &After) -> Value {
    joined([
        json!({ "tables": after.from }),
        figures(page, &after.assessment),
        json!({ "disagreements": after.disagreements }),
    ])
}

fn figures(page: &Page, assessment: &Assessment) -> Value {
    let grid = assessment.definitions.grid;
    let contribution = |part: &Contribution| {
        json!({
            "term": part.component.to_string(),
            "um": part.um,
            "va_without_um": part.va_without_um,
        })
    };
    let contributions = assessment.contributions.iter();
    json!({
        "grid": [grid.x, grid.y, grid.z],
        "definitions": definitions(page, assessment),
        "contributions": contributions.map(contribution).collect::<Vec<_>>(),
        "windows": assessment.windows.as_ref().map(windows),
        "histogram": assessment.histogram.as_ref().map(histogram),
        "grouping": assessment.grouping.as_ref().map(grouping),
    })
}

fn windows(windows: &Windows) -> Value {
    json!({
        "size_mm": vector(windows.size_mm),
        "count": windows.count,
        "grid": [windows.grid.x, windows.grid.y, windows.grid.z],
        "min_um": windows.best.0,
        "max_um": windows.worst.0,
        "corner_um": windows.corner_um,
        "min_at_mm": vector(windows.best.1),
        "max_at_mm": vector(windows.worst.1),
        "map": map(windows),
    })
}

/// Every sub-volume: its smallest coordinates along each axis, and the figures `um[x][y][z]`.
fn map(windows: &Windows) -> Value {
    let places = &windows.places_mm;
    let slices = windows.map_um.chunks(places.y.len() * places.z.len());
    let figures: Vec<Vec<&[f64]>> = slices.map(|s| s.chunks(places.z.len()).collect()).collect();
    json!({ "x_mm": places.x, "y_mm": places.y, "z_mm": places.z, "um": figures })
}

fn grouping(found: &Baseline) -> Value {
    json!({
        "exact": false,
        "angular_tolerance": found.angular,
        "magnitude_tolerance": found.magnitude,
        "groups": found.groups,
        "records": found.records,
        "um": found.longest.map(|(um, _)| um),
        "pair_mm": found.longest.map(|(_, pair)| pair.map(vector)),
    })
}

fn histogram(histogram: &Histogram) -> Value {
    let mut document = json!({
        "bin_um": histogram.bin_um,
        "counts": counts(histogram),
        "exact": histogram.sampled.is_none(),
        "pairs": histogram.pairs,
    });
    if let Some((drawn, standard_errors)) = &histogram.sampled {
        document["drawn"] = json!(drawn);
        document["standard_errors"] = json!(standard_errors);
    }
    document
}

/// Whole numbers where every pair was counted.
fn counts(histogram: &Histogram) -> Value {
    if histogram.sampled.is_some() {
        return json!(histogram.counts);
    }
    #[allow(clippy::cast_possible_truncation, reason = "counted numbers of pairs")]
    let whole: Vec<u64> = histogram.counts.iter().flatten().map(|n| *n as u64).collect();
    json!(whole)
}

fn vector(v: PerAxis<f64>) -> [f64; 3] {
    [v.x, v.y, v.z]
}

fn definitions(page: &Page, assessment: &Assessment) -> Value {
    let d = &assessment.definitions;
    let ranges = Axis::ALL.map(|axis| {
        let shown = shows(&page.volume, &page.basis.levers, axis);
        shown.then(|| d.ranges_um[axis])
    });
    json!({
        "elv_um": d.by_component.elv,
        "elsv_um": d.by_component.elsv,
        "existing_um": d.by_component.existing,
        "proposed_um": d.proposed_um,
        "proposed_of_nine_um": d.by_component.proposed,
        "va_um": d.va.um,
        "va_exact": assessment.va_exact,
        "va_pair_mm": d.va.places_mm.map(vector),
        "va_difference_um": vector(d.va.difference_um),
        "length_um": d.length.um,
        "length_bound_um": d.length.bound_um,
        "length_pair_mm": d.length_mm.map(vector),
        "length_exact": d.length.is_exact(),
        "ranges_um": ranges,
        "box_um": d.box_um,
        "max_from_reference_um": d.from_origin.um,
        "max_from_reference_bound_um": d.from_origin.bound_um,
        "reference_mm": vector(d.origin_mm),
        "diagonals_um": d.diagonals_um,
    })
}
