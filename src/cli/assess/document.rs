//! `nonius assess --format json` (contract §5).

use super::{After, Page};
use crate::assessment::{Assessment, Histogram, Windows};
use crate::axis::PerAxis;
use crate::definitions::Definitions;
use crate::manifest::picometres;
use serde_json::{Map, Value, json};

pub(super) fn document(page: &Page) -> Value {
    let mut document = Map::new();
    document.insert("schema".to_string(), json!(1));
    document.insert("machine".to_string(), json!(page.name));
    let chain = page.volume.chain_is_stated.then_some(page.volume.chain);
    let chain = chain.map(|chain| chain.to_string());
    document.insert("chain".to_string(), json!(chain));
    document.insert("frame".to_string(), json!("as given"));
    document.extend(figures(&page.before));
    let missing = page.volume.missing().into_iter();
    let missing: Vec<Value> = missing
        .map(|m| json!({"name": m.name, "consequence": m.consequence}))
        .collect();
    document.insert("missing".to_string(), json!(missing));
    document.insert("labels".to_string(), json!(page.volume.labels));
    let after = page.after.as_ref().map(after);
    document.insert("after".to_string(), json!(after));
    Value::Object(document)
}

fn after(after: &After) -> Value {
    let mut document = Map::new();
    document.insert("tables".to_string(), json!(after.from));
    document.extend(figures(&after.assessment));
    document.insert("disagreements".to_string(), json!(after.disagreements));
    Value::Object(document)
}

fn figures(assessment: &Assessment) -> Map<String, Value> {
    let mut figures = Map::new();
    let grid = assessment.definitions.grid;
    figures.insert("grid".to_string(), json!([grid.x, grid.y, grid.z]));
    figures.insert(
        "definitions".to_string(),
        definitions(&assessment.definitions),
    );
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
    figures
}

fn windows(windows: &Windows) -> Value {
    json!({
        "size_mm": vector(windows.size_mm),
        "count": windows.count,
        "min_um": picometres(windows.best.0),
        "max_um": picometres(windows.worst.0),
        "corner_um": picometres(windows.corner_um),
        "min_at_mm": vector(windows.best.1),
        "max_at_mm": vector(windows.worst.1),
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
    let whole: Vec<u64> = histogram.counts.iter().map(|n| *n as u64).collect();
    json!(whole)
}

fn vector(v: PerAxis<f64>) -> Value {
    json!([v.x, v.y, v.z].map(picometres))
}

fn definitions(d: &Definitions) -> Value {
    let pair = |pair: [PerAxis<f64>; 2]| json!(pair.map(vector));
    let figure = |um: Option<f64>| json!(um.map(picometres));
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
        "va_pair_mm": pair(d.va.places_mm),
        "va_difference_um": vector(d.va.difference_um),
        "length_um": picometres(d.length.um),
        "length_pair_mm": pair(d.length.places_mm),
        "length_exact": d.length.exact,
        "ranges_um": vector(d.ranges_um),
        "box_um": picometres(d.box_um),
        "max_from_reference_um": picometres(d.from_origin_um),
        "reference_mm": vector(d.origin_mm),
        "diagonals_um": diagonals,
    })
}
