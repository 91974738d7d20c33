//! What files hold beyond, short of or against what the job writes, in words.
//!
//! Emulation sees only what moves an axis of the job. A job owns its tables, their switches and
//! their memory and nothing else, so everything else in a file is told here: foreign points, foreign
//! parameters, foreign machine data. Every family lists what its tables hold, entry by entry; the lists
//! are compared alike.

use super::{Entries, Entry, Item, Value};
use crate::control::controller::Profile;
use crate::control::table::Tables;
use crate::judge::disagreement::Disagreements;
use crate::judge::family::{Before, Side, family};
use crate::judge::findings::{Difference, InControl, listed};
use crate::read::ReadBack;
use crate::text::Finding;
use crate::write::compensation::Compiled;

/// Everything surplus, missing or contradictory; what nobody can judge because the files for it are not there, and what
/// the reader has to say.
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
    let mut differences = match wanted == &read.tables {
        true => Vec::new(),
        false => {
            let entries = |tables, others| family.entries(&Side { tables, others, diagnosis });
            let own = entries(wanted, &read.tables);
            let got = entries(&read.tables, wanted);
            of_entries(&own, &got, diagnosis.is_some())
        }
    };
    if !read.unwritten.is_empty() {
        differences.push(Difference::NotWritten { parameters: read.unwritten.clone() });
    }
    let mut found: Vec<Finding> = differences.into_iter().map(Finding::from).collect();
    found.extend(family.beside(compiled, read));
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
fn of_entries(wanted: &Entries, found: &Entries, all: bool) -> Vec<Difference> {
    let surplus = by_table(found, wanted, |entry| entry.alone).into_iter();
    let surplus = surplus.map(|(what, items)| Difference::Surplus { what, items });
    let mut differences: Vec<Difference> = surplus.collect();
    if !all {
        return differences;
    }
    let missing = by_table(wanted, found, |entry| entry.differing).into_iter();
    differences.extend(missing.map(|(what, items)| Difference::Missing { what, items }));
    let differing = wanted.iter().filter_map(|(key, own)| {
        let got = found.get(key).filter(|got| !got.value.is(&own.value))?;
        (own.differing && got.differing).then(|| (key, [got, own].map(|of| of.value.words())))
    });
    let differing: Vec<_> = differing.collect();
    for same in differing.chunk_by(|((a, _), _), ((b, _), _)| a == b) {
        let (names, points) = parted(same.iter().map(|((_, item), both)| (item, both)));
        let named = |(name, [got, own]): &(&str, &[String; 2])| {
            format!("{name} is {got}, the job writes {own}")
        };
        let mut values: Vec<String> = names.iter().map(named).collect();
        values.extend(points.first().map(|(first, [got, own])| {
            let points = runs(&points);
            format!("{points}: other values (point {first} is {got}, the job writes {own})")
        }));
        differences.push(Difference::OtherValues { table: same[0].0.0.clone(), values });
    }
    differences
}

/// What only one side has, and how many: a whole table, or some of its items.
fn by_table(own: &Entries, others: &Entries, told: fn(&Entry) -> bool) -> Vec<(String, usize)> {
    let alone = own.iter().filter(|(key, entry)| told(entry) && !others.contains_key(key));
    let alone: Vec<_> = alone.collect();
    let of_table = |same: &[(&(String, Item), &Entry)]| {
        let block = &same[0].0.0;
        if !block.is_empty() && !others.keys().any(|(other, _)| other == block) {
            return (block.clone(), 1);
        }
        let (names, points) = parted(same.iter().map(|((_, item), entry)| (item, &entry.value)));
        let name = |(name, value): &(&str, &Value)| format!("{name} = {}", value.words());
        let names: Vec<String> = names.iter().map(name).collect();
        let block = (!block.is_empty()).then(|| block.clone()).into_iter();
        let points = (!points.is_empty()).then(|| runs(&points));
        let names = (!names.is_empty()).then(|| listed(&names));
        (block.chain(points).chain(names).collect::<Vec<String>>().join(", "), same.len())
    };
    alone.chunk_by(|((a, _), _), ((b, _), _)| a == b).map(of_table).collect()
}

/// Names and points of a table, each with its own.
type Parted<'a, T> = (Vec<(&'a str, T)>, Vec<(u32, T)>);

fn parted<'a, T>(items: impl Iterator<Item = (&'a Item, T)>) -> Parted<'a, T> {
    let (mut names, mut points) = (Vec::new(), Vec::new());
    for (item, own) in items {
        match item {
            Item::Name(name) => names.push((name.as_str(), own)),
            Item::Point(point) => points.push((*point, own)),
        }
    }
    (names, points)
}

/// Ascending numbers as `point 7` or `points 3, 1200 to 1205`.
fn runs<T>(points: &[(u32, T)]) -> String {
    let runs = points.chunk_by(|(a, _), (b, _)| a + 1 == *b).map(|run| match run {
        [(one, _)] => one.to_string(),
        run => format!("{} to {}", run[0].0, run[run.len() - 1].0),
    });
    let word = if points.len() == 1 { "point" } else { "points" };
    format!("{word} {}", listed(&runs.collect::<Vec<String>>()))
}
