//! What files hold beyond, short of or against what the job writes, in words.
//!
//! Emulation sees only what moves an axis of the job. A job owns its tables, their switches and
//! their memory and nothing else, so everything else in a file is told here: foreign points, foreign parameters, foreign machine data.

mod fanuc;
mod generic;
mod siemens;

use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::judge::disagreement::Diagnosis;
use crate::read::readback::kit::ReadBack;

/// Names that are listed before the rest is only counted.
const MOST_NAMES: usize = 6;
/// Numbers of files closer than this are equal, in their own unit.
const EQUAL: f64 = 1e-9;

/// Everything surplus, missing or contradictory, one sentence each.
///
/// **limits** what `diagnosis` already explains is not told again; without a diagnosis (tables
/// that cannot be emulated, whose reason is told elsewhere) only what is surplus is told of the
/// tables, and everything of the machine data.
pub fn contents(
    profile: &Profile,
    wanted: &Tables,
    read: &ReadBack,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    match (&profile.dialect, wanted, &read.tables) {
        (Dialect::Siemens(facts), Tables::Siemens(wanted), Tables::Siemens(found)) => {
            let mut words = siemens::tables(wanted, found, diagnosis);
            words.extend(siemens::unwritten(&read.unwritten));
            words.extend(siemens::machine_data::differences(
                wanted,
                &read.machine_data,
                facts,
            ));
            words
        }
        (Dialect::Fanuc(_), Tables::Fanuc(wanted), Tables::Fanuc(found)) => {
            fanuc::memory(wanted, found, diagnosis)
        }
        (Dialect::Generic(_), Tables::Generic(wanted), Tables::Generic(found)) => {
            generic::rows(wanted, found, diagnosis)
        }
        _ => Vec::new(),
    }
}

/// What nobody can judge because the files for it are not there, and what to see to instead.
pub fn absent(profile: &Profile, wanted: &Tables, read: &ReadBack) -> Vec<String> {
    let mut words = match (&profile.dialect, wanted) {
        (Dialect::Siemens(facts), Tables::Siemens(wanted)) => {
            siemens::machine_data::absent(wanted, &read.machine_data, facts)
        }
        _ => Vec::new(),
    };
    words.extend(read.notes.iter().cloned());
    words
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= EQUAL
}

/// `a, b, c and 4 more`
fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).cloned().collect::<Vec<_>>();
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown.join(", "),
        rest => format!("{} and {rest} more", shown.join(", ")),
    }
}

/// Ascending numbers as `point 7` or `points 3, 1200 to 1205`.
fn runs(numbers: &[u32]) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == *number => *last = *number,
            _ => runs.push((*number, *number)),
        }
    }
    let texts: Vec<String> = runs
        .iter()
        .map(|(first, last)| match first == last {
            true => first.to_string(),
            false => format!("{first} to {last}"),
        })
        .collect();
    let word = if numbers.len() == 1 {
        "point"
    } else {
        "points"
    };
    format!("{word} {}", listed(&texts))
}

/// `it` or `them`, for as many as there are.
fn it(count: usize) -> &'static str {
    if count == 1 { "it" } else { "them" }
}
