//! The document of `standards --format json` for an axis.

use crate::cli::standards::Results;
use crate::inputs::target_runs::Runs;
use crate::kit::manifest::picometres;
use crate::machine::standards::{self, Condition, Met, iso_230_2, vdi_3441};
use crate::quantity::axis::Direction;
use serde_json::{Map, Value, json};

pub(super) fn document(runs: &Runs, results: &Results) -> Value {
    json!({
        "schema": 1,
        "targets": runs.targets_mm().len(),
        "length_mm": picometres(runs.length_mm()),
        "travel_mm": results.travel.stated_mm().map(picometres),
        "runs": { "up": runs.count(Direction::Plus), "down": runs.count(Direction::Minus) },
        "iso_230_2": iso_json(results),
        "vdi_dgq_3441": results.vdi.as_ref().map(vdi_json),
    })
}

fn iso_json(results: &Results) -> Value {
    let mut document = Map::new();
    document.insert("editions".to_string(), json!(iso_230_2::EDITIONS));
    document.insert("confidence".to_string(), json!(standards::ISO_230_2.word()));
    let missed = results.conditions.iter().any(|of| of.met == Met::No);
    document.insert("condition_missed".to_string(), json!(missed));
    document.insert(
        "label".to_string(),
        json!(iso_230_2::label(&results.conditions)),
    );
    for (letter, um) in results.iso.axis.named_um() {
        insert(&mut document, letter, um);
    }
    let foreign: &[&str] = if results.travel.is_long() {
        &["A", "R"]
    } else {
        &[]
    };
    document.insert("not_in_the_standard".to_string(), json!(foreign));
    let targets: Vec<Value> = results.iso.targets.iter().map(iso_target_json).collect();
    document.insert("targets".to_string(), json!(targets));
    document.insert(
        "conditions".to_string(),
        conditions_json(&results.conditions),
    );
    document.insert("notes".to_string(), json!(results.notes));
    Value::Object(document)
}

fn iso_target_json(of: &iso_230_2::TargetFigures) -> Value {
    let mut target = Map::new();
    target.insert("target_mm".to_string(), json!(picometres(of.target_mm)));
    for (name, um) in [
        ("mean", of.mean.both_um),
        ("mean_up", of.mean.up_um),
        ("mean_down", of.mean.down_um),
        ("s_up", of.s.up_um),
        ("s_down", of.s.down_um),
        ("B", of.b_um),
        ("R", of.r.both_um),
        ("R_up", of.r.up_um),
        ("R_down", of.r.down_um),
    ] {
        insert(&mut target, name, um);
    }
    Value::Object(target)
}

pub(super) fn conditions_json(conditions: &[Condition]) -> Value {
    let list: Vec<Value> = conditions
        .iter()
        .map(|of| {
            let found = (!of.found.is_empty()).then_some(&of.found);
            json!({
                "asked": of.asked,
                "found": found,
                "outcome": of.met.word(),
                "editions": of.editions,
                "confidence": of.confidence.word(),
            })
        })
        .collect();
    json!({ "list": list })
}

fn vdi_json(figures: &vdi_3441::Figures) -> Value {
    let mut document = Map::new();
    document.insert("confidence".to_string(), json!(standards::VDI_3441.word()));
    for (name, um) in [
        ("P", figures.p_um),
        ("P_a", Some(figures.p_a_um)),
        ("P_s", figures.p_s_um),
        ("U", Some(figures.u_um)),
        ("U_mean", Some(figures.u_mean_um)),
    ] {
        insert(&mut document, name, um);
    }
    let targets: Vec<Value> = figures
        .targets
        .iter()
        .map(|of| {
            let mut target = Map::new();
            target.insert("target_mm".to_string(), json!(picometres(of.target_mm)));
            insert(&mut target, "mean", Some(of.mean_um));
            insert(&mut target, "U", Some(of.u_um));
            insert(&mut target, "s_mean", of.s_um);
            Value::Object(target)
        })
        .collect();
    document.insert("targets".to_string(), json!(targets));
    Value::Object(document)
}

/// A figure under its letter and unit; `null` where it is absent.
pub(super) fn insert(document: &mut Map<String, Value>, name: &str, um: Option<f64>) {
    document.insert(format!("{name}_um"), json!(um.map(picometres)));
}
