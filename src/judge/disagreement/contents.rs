//! What files hold beyond, short of or against what the job writes, in words.
//!
//! Emulation sees only what moves an axis of the job. A job owns its tables, their switches and
//! their memory and nothing else, so everything else in a file is told here: foreign points, foreign
//! parameters, foreign machine data. Every family lists what its tables hold, entry by entry; the lists
//! are compared alike.

use super::diagnosis::Disagreements;
use super::entries::{Entries, Item, Value};
use crate::control::controller::Profile;
use crate::control::table::Tables;
use crate::judge::before::Before;
use crate::judge::family::{Side, family};
use crate::judge::findings::{Difference, InControl, listed};
use crate::read::ReadBack;
use crate::text::finding::Finding;
use crate::write::compensation::Compiled;

/// Everything surplus, missing or contradictory.
///
/// **limits** what `diagnosis` already explains is not told again; without a diagnosis (tables
/// that cannot be emulated, whose reason is told elsewhere) only what is surplus is told of the
/// tables, and everything of the machine data.
pub fn contents(
    profile: &Profile,
    compiled: &Compiled,
    read: &ReadBack,
    diagnosis: Option<&Disagreements>,
) -> Vec<Finding> {
    let (family, wanted) = (family(&profile.dialect), &compiled.tables);
    let mut found = match wanted == &read.tables {
        true => Vec::new(),
        false => {
            let entries = |tables, others| family.entries(&Side { tables, others, diagnosis });
            let own = entries(wanted, &read.tables);
            let got = entries(&read.tables, wanted);
            differences(&own, &got, diagnosis.is_some())
        }
    };
    if !read.unwritten.is_empty() {
        let parameters = read.unwritten.clone();
        found.push(Difference::NotWritten { parameters });
    }
    found.extend(family.other_settings(compiled, read));
    found.into_iter().map(Finding::from).collect()
}

/// What nobody can judge because the files for it are not there, and what to see to instead.
pub fn absent(profile: &Profile, wanted: &Tables, read: &ReadBack) -> Vec<Finding> {
    let mut found = family(&profile.dialect).absent_settings(wanted, read);
    found.extend(read.notes.iter().cloned());
    found
}

/// Tables that are emulated alike, but are for another measuring system than the job states.
pub fn measuring_systems(profile: &Profile, wanted: &Tables, found: &Tables) -> Vec<Finding> {
    let other = family(&profile.dialect).measuring_systems(wanted, found);
    other.into_iter().map(Finding::from).collect()
}

/// What a read-out holds around the tables, against what the job asks of the control there. What no
/// file holds is taken as the job asks, and said.
pub(crate) fn surroundings(before: &Before<'_>) -> Vec<Finding> {
    let (mut found, what) = family(&before.task.profile.dialect).surroundings(before);
    found.extend((!what.is_empty()).then_some(InControl::AsAsked { what }));
    found.into_iter().map(Finding::from).collect()
}

/// What is surplus of a table, missing, and other; with `all` also the latter two.
fn differences(wanted: &Entries, found: &Entries, all: bool) -> Vec<Difference> {
    let surplus = found.iter().filter(|(key, e)| e.alone && !wanted.contains_key(key));
    let surplus = by_table(surplus.map(|(key, e)| (key, &e.value)), wanted).into_iter();
    let surplus = surplus.map(|(what, items)| Difference::Surplus { what, items });
    let mut differences: Vec<Difference> = surplus.collect();
    if !all {
        return differences;
    }
    let missing = wanted.iter().filter(|(key, e)| e.differing && !found.contains_key(key));
    let missing = by_table(missing.map(|(key, e)| (key, &e.value)), found).into_iter();
    differences.extend(missing.map(|(what, items)| Difference::Missing { what, items }));
    let differing = wanted.iter().filter_map(|(key, own)| {
        let got = found.get(key).filter(|got| !got.value.is(&own.value))?;
        (own.differing && got.differing).then_some((key, &got.value, &own.value))
    });
    let differing: Vec<_> = differing.collect();
    for same in differing.chunk_by(|((a, _), ..), ((b, _), ..)| a == b) {
        let named = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Name(name) => {
                Some(format!("{name} is {}, the job writes {}", got.words(), own.words()))
            }
            Item::Point(_) => None,
        });
        let mut values: Vec<String> = named.collect();
        let points = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Point(point) => Some((*point, (got, own))),
            Item::Name(_) => None,
        });
        let (points, both): (Vec<u32>, Vec<_>) = points.unzip();
        if let (Some(first), Some((got, own))) = (points.first(), both.first()) {
            let (points, got, own) = (runs(&points), got.words(), own.words());
            values.push(format!(
                "{points}: other values (point {first} is {got}, the job writes {own})"
            ));
        }
        let table = same[0].0.0.clone();
        differences.push(Difference::OtherValues { table, values });
    }
    differences
}

/// What only one side has, and how many: a whole table, or some of its items.
fn by_table<'a>(
    alone: impl Iterator<Item = (&'a (String, Item), &'a Value)>,
    others: &Entries,
) -> Vec<(String, usize)> {
    let alone: Vec<_> = alone.collect();
    let of_table = |same: &[(&(String, Item), &Value)]| {
        let block = &same[0].0.0;
        if !block.is_empty() && !others.keys().any(|(other, _)| other == block) {
            return (block.clone(), 1);
        }
        let (mut names, mut points) = (Vec::new(), Vec::new());
        for ((_, item), value) in same {
            match item {
                Item::Name(name) => names.push(format!("{name} = {}", value.words())),
                Item::Point(point) => points.push(*point),
            }
        }
        let names = (!names.is_empty()).then(|| listed(&names));
        let points = (!points.is_empty()).then(|| runs(&points));
        let block = (!block.is_empty()).then(|| block.clone());
        let what: Vec<String> = block.into_iter().chain(points).chain(names).collect();
        (what.join(", "), same.len())
    };
    let tables = alone.chunk_by(|((a, _), _), ((b, _), _)| a == b);
    tables.map(of_table).collect()
}

/// Ascending numbers as `point 7` or `points 3, 1200 to 1205`.
fn runs(numbers: &[u32]) -> String {
    let runs: Vec<String> = numbers
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| match run {
            [one] => one.to_string(),
            run => format!("{} to {}", run[0], run[run.len() - 1]),
        })
        .collect();
    let word = if numbers.len() == 1 { "point" } else { "points" };
    format!("{word} {}", listed(&runs))
}
