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
use crate::judge::active::{ActiveControl, Origin};
use crate::judge::family::family;
use crate::judge::findings::{InControl, it, listed};
use crate::read::ReadBack;
use crate::text::finding::Finding;
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;

/// Everything surplus, missing or contradictory, one sentence each.
///
/// **limits** what `diagnosis` already explains is not told again; without a diagnosis (tables
/// that cannot be emulated, whose reason is told elsewhere) only what is surplus is told of the
/// tables, and everything of the machine data.
pub fn contents(
    profile: &Profile,
    wanted: &Tables,
    read: &ReadBack,
    diagnosis: Option<&Disagreements>,
) -> Vec<Finding> {
    let family = family(&profile.dialect);
    let mut words = match wanted == &read.tables {
        true => Vec::new(),
        false => {
            let own = family.entries(wanted, &read.tables, diagnosis);
            let found = family.entries(&read.tables, wanted, diagnosis);
            differences(&own, &found, diagnosis.is_some())
        }
    };
    if !read.unwritten.is_empty() {
        let (names, them) = (listed(&read.unwritten), it(read.unwritten.len()));
        words.push(format!(
            "no file writes {names}: the control keeps what it holds there, the job writes {them}"
        ));
    }
    words.extend(family.other_settings(wanted, read));
    let differs = |words| InControl::Differs { words }.into();
    words.into_iter().map(differs).collect()
}

/// What nobody can judge because the files for it are not there, and what to see to instead.
pub fn absent(profile: &Profile, wanted: &Tables, read: &ReadBack) -> Vec<Finding> {
    let mut found = family(&profile.dialect).absent_settings(wanted, read);
    found.extend(read.notes.iter().cloned());
    found
}

/// Tables that are emulated alike, but are for another measuring system than the job states.
pub fn measuring_systems(profile: &Profile, wanted: &Tables, found: &Tables) -> Vec<Finding> {
    let words = family(&profile.dialect).measuring_systems(wanted, found);
    let differs = |words| InControl::Differs { words }.into();
    words.into_iter().map(differs).collect()
}

/// What a read-out holds around the tables, against what the job asks of the control there; what is not read
/// out of a control has no surroundings. What no file holds is taken as the job asks, and said.
pub fn surroundings(
    profile: &Profile,
    plan: &Plan,
    wanted: &Compiled,
    active: &ActiveControl,
) -> Vec<Finding> {
    let Origin::ReadOut(held) = &active.origin else {
        return Vec::new();
    };
    let (mut found, what) = family(&profile.dialect).surroundings(plan, wanted, held);
    found.extend((!what.is_empty()).then_some(InControl::AsAsked { what }));
    found.into_iter().map(Finding::from).collect()
}

/// One sentence for what is surplus of a table, missing, and other; with `all` also the latter two.
fn differences(wanted: &Entries, found: &Entries, all: bool) -> Vec<String> {
    let surplus = found
        .iter()
        .filter(|(key, e)| e.alone && !wanted.contains_key(key));
    let mut words = by_table(surplus.map(|(key, e)| (key, &e.value)), wanted, |them| {
        format!("the job does not write {them}")
    });
    if !all {
        return words;
    }
    let missing = wanted
        .iter()
        .filter(|(key, e)| e.differing && !found.contains_key(key));
    words.extend(by_table(
        missing.map(|(key, e)| (key, &e.value)),
        found,
        |them| format!("missing, the job writes {them}"),
    ));
    let differing = wanted.iter().filter_map(|(key, own)| {
        let got = found.get(key).filter(|got| !got.value.is(&own.value))?;
        (own.differing && got.differing).then_some((key, &got.value, &own.value))
    });
    let differing: Vec<_> = differing.collect();
    for same in differing.chunk_by(|((a, _), ..), ((b, _), ..)| a == b) {
        let named = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Name(name) => Some(format!(
                "{name} is {}, the job writes {}",
                got.words(),
                own.words()
            )),
            Item::Point(_) => None,
        });
        let mut said: Vec<String> = named.collect();
        let points = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Point(point) => Some((*point, (got, own))),
            Item::Name(_) => None,
        });
        let (points, values): (Vec<u32>, Vec<_>) = points.unzip();
        if let (Some(first), Some((got, own))) = (points.first(), values.first()) {
            let (points, got, own) = (runs(&points), got.words(), own.words());
            said.push(format!(
                "{points}: other values (point {first} is {got}, the job writes {own})"
            ));
        }
        let block = &same[0].0.0;
        let block = if block.is_empty() {
            String::new()
        } else {
            format!("{block}: ")
        };
        words.push(format!("{block}{}", said.join("; ")));
    }
    words
}

/// What only one side has: a whole table, or some of its items.
fn by_table<'a>(
    alone: impl Iterator<Item = (&'a (String, Item), &'a Value)>,
    others: &Entries,
    says: impl Fn(&str) -> String,
) -> Vec<String> {
    let alone: Vec<_> = alone.collect();
    let sentence = |same: &[(&(String, Item), &Value)]| {
        let block = &same[0].0.0;
        if !block.is_empty() && !others.keys().any(|(other, _)| other == block) {
            return format!("{block}: {}", says("it"));
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
        format!("{}: {}", what.join(", "), says(it(same.len())))
    };
    let tables = alone.chunk_by(|((a, _), _), ((b, _), _)| a == b);
    tables.map(sentence).collect()
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
    let word = if numbers.len() == 1 {
        "point"
    } else {
        "points"
    };
    format!("{word} {}", listed(&runs))
}
