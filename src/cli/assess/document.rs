//! `nonius assess --format json` (contract §5).

use super::page::{After, Basis, Page, count, shows, unknown_axes};
use crate::kit::manifest::picometres;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::Millimetres;
use crate::volume::assessment::{Assessment, Baseline, Histogram, Windows};
use serde_json::{Map, Value, json};

pub(super) fn document(page: &Page) -> Value {
    let mut document = Map::new();
    document.insert("schema".to_string(), json!(1));
    document.insert("machine".to_string(), json!(page.name));
    let chain = page.volume.chain_is_stated.then_some(page.volume.chain);
    let chain = chain.map(|chain| chain.to_string());
    document.insert("chain".to_string(), json!(chain));
    let mut insert = |key: &str, value: Value| {
        document.insert(key.to_string(), value);
    };
    insert("frame", json!(page.basis.frame));
    insert("volume_mm", json!(volume(page)));
    let levers = page.basis.levers;
    let tool = levers
        .tool
        .map(|tool| vector(PerAxis::from_fn(|a| tool[a].mm())));
    insert("tool_offset_mm", json!(tool));
    insert("offsets_mm", places(levers.offsets));
    insert("angles_zero_mm", places(levers.angles_zero));
    insert("straightness_optic_mm", places(levers.straightness_optic));
    insert("active", json!(active(&page.basis)));
    insert("errors_measured", json!(count(&page.volume)));
    document.extend(figures(page, &page.before));
    let missing = page.volume.missing().into_iter();
    let missing: Vec<Value> = missing
        .map(|m| json!({"name": m.name, "consequence": m.consequence}))
        .collect();
    document.insert("missing".to_string(), json!(missing));
    document.insert(
        "labels".to_string(),
        json!([page.basis.doubts.clone(), page.basis.labels.clone()].concat()),
    );
    let after = page.after.as_ref().map(|after| of_after(page, after));
    document.insert("after".to_string(), json!(after));
    Value::Object(document)
}

/// Range of each axis; null where nothing was measured along it and no travel is stated.
fn volume(page: &Page) -> Value {
    let unknown = unknown_axes(&page.volume);
    per_axis(|axis| {
        let (low, high) = page.volume.range(axis);
        (!unknown.contains(&axis)).then(|| [picometres(low), picometres(high)])
    })
}

fn per_axis<T: serde::Serialize>(value: impl Fn(Axis) -> T) -> Value {
    let all: Map<String, Value> = Axis::ALL
        .into_iter()
        .map(|axis| (axis.key().to_string(), json!(value(axis))))
        .collect();
    Value::Object(all)
}

/// Stated places; null where none is stated.
fn places(places: PerAxis<Option<Millimetres>>) -> Value {
    per_axis(|axis| places[axis].map(|place| picometres(place.mm())))
}

fn active(basis: &Basis) -> Option<Value> {
    let um = basis.without_tables_um.map(picometres);
    let tables = basis.active.as_ref()?;
    Some(json!({"tables": tables, "va_without_um": um}))
}

fn of_after(page: &Page, after: &After) -> Value {
    let mut document = Map::new();
    document.insert("tables".to_string(), json!(after.from));
    document.extend(figures(page, &after.assessment));
    document.insert("disagreements".to_string(), json!(after.disagreements));
    Value::Object(document)
}

fn figures(page: &Page, assessment: &Assessment) -> Map<String, Value> {
    let mut figures = Map::new();
    let grid = assessment.definitions.grid;
    figures.insert("grid".to_string(), json!([grid.x, grid.y, grid.z]));
    figures.insert("definitions".to_string(), definitions(page, assessment));
    let contributions: Vec<Value> = assessment
        .contributions
        .iter()
        .map(|part| {
            json!({
                "term": part.component.to_string(),
                "um": picometres(part.um),
                "va_without_um": picometres(part.va_without_um),
            })
        })
        .collect();
    figures.insert("contributions".to_string(), json!(contributions));
    let windows = assessment.windows.as_ref().map(windows);
    figures.insert("windows".to_string(), json!(windows));
    let histogram = assessment.histogram.as_ref().map(histogram);
    figures.insert("histogram".to_string(), json!(histogram));
    let grouping = assessment.grouping.as_ref().map(grouping);
    figures.insert("grouping".to_string(), json!(grouping));
    figures
}

fn windows(windows: &Windows) -> Value {
    json!({
        "size_mm": vector(windows.size_mm),
        "count": windows.count,
        "grid": [windows.grid.x, windows.grid.y, windows.grid.z],
        "min_um": picometres(windows.best.0),
        "max_um": picometres(windows.worst.0),
        "corner_um": picometres(windows.corner_um),
        "min_at_mm": vector(windows.best.1),
        "max_at_mm": vector(windows.worst.1),
        "map": map(windows),
    })
}

/// Every sub-volume: its smallest coordinates along each axis, and the figures `um[x][y][z]`.
fn map(windows: &Windows) -> Value {
    let mut document = Map::new();
    for (axis, places) in windows.places_mm.iter() {
        let places: Vec<f64> = places.iter().copied().map(picometres).collect();
        document.insert(format!("{}_mm", axis.key()), json!(places));
    }
    let [_, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| windows.places_mm[axis].len());
    let line = |line: &[f64]| line.iter().copied().map(picometres).collect::<Vec<f64>>();
    let slices = windows.map_um.chunks(y * z);
    let figures: Vec<Vec<Vec<f64>>> = slices.map(|s| s.chunks(z).map(line).collect()).collect();
    document.insert("um".to_string(), json!(figures));
    Value::Object(document)
}

fn grouping(found: &Baseline) -> Value {
    let pair = found.longest.map(|(_, pair)| pair.map(vector));
    json!({
        "exact": false,
        "angular_tolerance": found.angular,
        "magnitude_tolerance": found.magnitude,
        "groups": found.groups,
        "records": found.records,
        "um": found.longest.map(|(um, _)| picometres(um)),
        "pair_mm": pair,
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
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counted numbers of pairs"
    )]
    let whole: Vec<u64> = histogram
        .counts
        .iter()
        .flatten()
        .map(|n| *n as u64)
        .collect();
    json!(whole)
}

fn vector(v: PerAxis<f64>) -> Value {
    json!([v.x, v.y, v.z].map(picometres))
}

fn definitions(page: &Page, assessment: &Assessment) -> Value {
    let d = &assessment.definitions;
    let pair = |pair: [PerAxis<f64>; 2]| json!(pair.map(vector));
    let figure = |um: Option<f64>| json!(um.map(picometres));
    let ranges = Axis::ALL.map(|axis| {
        let shown = shows(&page.volume, &page.basis.levers, axis);
        shown.then(|| picometres(d.ranges_um[axis]))
    });
    let diagonals: Map<String, Value> = d
        .diagonals_um
        .iter()
        .map(|(diagonal, um)| (diagonal.name().to_string(), json!(picometres(*um))))
        .collect();
    json!({
        "elv_um": figure(d.by_component.elv),
        "elsv_um": figure(d.by_component.elsv),
        "existing_um": figure(d.by_component.existing),
        "proposed_um": picometres(d.proposed_um),
        "proposed_of_nine_um": figure(d.by_component.proposed),
        "va_um": picometres(d.va.um),
        "va_exact": assessment.va_exact,
        "va_pair_mm": pair(d.va.places_mm),
        "va_difference_um": vector(d.va.difference_um),
        "length_um": picometres(d.length.um),
        "length_pair_mm": pair(d.length.places_mm),
        "length_exact": d.length.exact,
        "ranges_um": ranges,
        "box_um": picometres(d.box_um),
        "max_from_reference_um": picometres(d.from_origin_um),
        "reference_mm": vector(d.origin_mm),
        "diagonals_um": diagonals,
    })
}
