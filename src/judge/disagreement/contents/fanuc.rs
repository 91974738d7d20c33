//! Points and parameters by their numbers.

use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::judge::disagreement::Diagnosis;
use crate::judge::disagreement::contents::words::{it, listed, runs, same};

/// Surplus, missing and other points and parameters.
pub(super) fn memory(
    wanted: &FanucMemory,
    found: &FanucMemory,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    let mut words = surplus(wanted, found);
    if let Some(diagnosis) = diagnosis {
        words.extend(points(wanted, found, diagnosis));
        words.extend(parameters(wanted, found, diagnosis));
    }
    words
}

/// What no table of the job owns; told always, whatever else is wrong.
fn surplus(wanted: &FanucMemory, found: &FanucMemory) -> Vec<String> {
    let mut words = Vec::new();
    let is_foreign = |point: &&u32| !wanted.points.contains_key(point);
    let points: Vec<u32> = found.points.keys().filter(is_foreign).copied().collect();
    if !points.is_empty() {
        let them = it(points.len());
        words.push(format!("{}: the job does not write {them}", runs(&points)));
    }
    let parameters: Vec<String> = found
        .parameters
        .iter()
        .filter(|(key, _)| !wanted.parameters.contains_key(key))
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    if !parameters.is_empty() {
        let (names, them) = (listed(&parameters), it(parameters.len()));
        words.push(format!("{names}: the job does not write {them}"));
    }
    words
}

/// Points of the job that are not there or hold something else without a known effect.
fn points(wanted: &FanucMemory, found: &FanucMemory, diagnosis: &Diagnosis) -> Vec<String> {
    if !diagnosis.words.is_empty() {
        return Vec::new();
    }
    let (mut missing, mut other) = (Vec::new(), Vec::new());
    for (point, value) in &wanted.points {
        match found.points.get(point) {
            None => missing.push(*point),
            Some(got) if got != value => other.push((*point, *value, *got)),
            Some(_) => {}
        }
    }
    let mut words = Vec::new();
    if !missing.is_empty() {
        let them = it(missing.len());
        words.push(format!(
            "{}: missing, the job writes {them}",
            runs(&missing)
        ));
    }
    if let Some((first, value, got)) = other.first() {
        let numbers: Vec<u32> = other.iter().map(|(point, _, _)| *point).collect();
        words.push(format!(
            "{}: other values (point {first} is {got}, the job writes {value})",
            runs(&numbers)
        ));
    }
    words
}

/// Parameters of the job that are not there or hold something else without a known effect.
fn parameters(wanted: &FanucMemory, found: &FanucMemory, diagnosis: &Diagnosis) -> Vec<String> {
    let sentence = |(key, value): (&ParameterKey, &ParameterValue)| match found.parameters.get(key)
    {
        None => Some(format!("{key}: missing, the job writes {value}")),
        Some(got) if equal(*got, *value) => None,
        Some(got) => Some(format!("{key} is {got}, the job writes {value}")),
    };
    wanted
        .parameters
        .iter()
        .filter(|(key, _)| !explained(**key, diagnosis))
        .filter_map(sentence)
        .collect()
}

/// A parameter of an axis acts on the terms of that axis; one without axis on cross terms.
fn explained(key: ParameterKey, diagnosis: &Diagnosis) -> bool {
    let axis = key.axis.map(|axis| axis.to_string());
    diagnosis.pairs.iter().any(|(base, output)| match &axis {
        Some(axis) => base == axis || output == axis,
        None => base != output,
    })
}

#[allow(clippy::cast_precision_loss, reason = "parameters are far below 2^52")]
fn equal(a: ParameterValue, b: ParameterValue) -> bool {
    use ParameterValue::{Integer, Real};
    match (a, b) {
        (Real(a), Real(b)) => same(a, b),
        (Real(a), Integer(b)) | (Integer(b), Real(a)) => same(a, b as f64),
        _ => a == b,
    }
}
