//! What sections of a job have in common: places, ranges, and keys that need or exclude each other.
//!
//! Every problem is noted at its key, and a job with a problem is refused, so a value that could not
//! be read may come back as its default.

use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::units::Millimetres;
use crate::text::document::Section;
use crate::text::plain::is_unseen;
use crate::text::problem::shown;
use std::ops::RangeInclusive;

/// What a place may pass the travel by: the last digit of a coordinate, mm.
const TRAVEL_TOLERANCE_MM: f64 = 1e-4;

/// A limit of a correction or of what is left: none of a machine is smaller or larger, µm or µm/mm.
pub(super) const LIMITS: RangeInclusive<f64> = 1e-6..=1e9;

/// One place, or one length of each axis.
pub(super) type Places = PerAxis<Millimetres>;

/// A sub-section, if it is there, of which `read` takes all keys that may stand in it.
pub(super) fn sub<T>(
    parent: &Section<'_>,
    key: &'static str,
    read: impl FnOnce(&Section<'_>) -> T,
) -> Option<T> {
    parent.section(key).map(|section| whole(&section, read))
}

/// The same of a list of sub-sections.
pub(super) fn subs<T>(
    parent: &Section<'_>,
    key: &'static str,
    mut read: impl FnMut(&Section<'_>) -> Option<T>,
) -> Vec<T> {
    let sections = parent.sections(key);
    let read = sections
        .iter()
        .filter_map(|section| whole(section, &mut read));
    read.collect()
}

fn whole<T>(section: &Section<'_>, read: impl FnOnce(&Section<'_>) -> T) -> T {
    let value = read(section);
    section.refuse_unknown_keys();
    value
}

/// The sub-sections `axes.x`, `axes.y`, `axes.z`.
pub(super) fn axes<T>(
    parent: &Section<'_>,
    read: impl Fn(&Section<'_>) -> Option<T>,
) -> PerAxis<Option<T>> {
    let of = |axes: &Section<'_>, axis: Axis| sub(axes, axis.key(), &read).flatten();
    let axes = sub(parent, "axes", |axes| {
        PerAxis::from_fn(|axis| of(axes, axis))
    });
    axes.unwrap_or_else(|| PerAxis::from_fn(|_| None))
}

/// Notes the keys that are missing, each with what it is.
pub(super) fn require(section: &Section<'_>, keys: &[(&'static str, &str)]) {
    for (key, expected) in keys {
        if !section.has(key) {
            section.missing(key, expected);
        }
    }
}

/// Notes a key that has an effect only with something else, which is not so.
pub(super) fn only_with(section: &Section<'_>, key: &'static str, is_so: bool, with: &str) {
    if section.has(key) && !is_so {
        let path = section.path_of(key);
        section.problem(
            key,
            format!("`{path}` as it stands goes only with {with}"),
            format!("remove or change it, or write {with}"),
        );
    }
}

/// Notes two keys of which one is enough.
pub(super) fn not_both(section: &Section<'_>, key: &'static str, other: &'static str, help: &str) {
    if section.has(key) && section.has(other) {
        let message = format!("`{other}` and `{key}` are both given, expected one of the two");
        section.problem(key, message, help);
    }
}

/// A number between two bounds, if the key is present.
pub(super) fn between(
    section: &Section<'_>,
    key: &'static str,
    range: RangeInclusive<f64>,
    unit: &str,
) -> Option<f64> {
    let number = section.number(key)?;
    let expected = format!("{} … {} {unit}", range.start(), range.end());
    let help = "check the number and its unit";
    in_range(section, key, range.contains(&number), (expected, help)).then_some(number)
}

/// A whole number between two bounds, if the key is present.
pub(super) fn count(
    section: &Section<'_>,
    key: &'static str,
    range: RangeInclusive<u32>,
    help: &str,
) -> Option<u32> {
    let number = section.whole(key)?;
    let expected = match range.end() {
        &u32::MAX => format!("at least {}", range.start()),
        most => format!("{} … {most}", range.start()),
    };
    in_range(section, key, range.contains(&number), (expected, help)).then_some(number)
}

/// Notes a number that lies outside its range.
fn in_range(
    section: &Section<'_>,
    key: &'static str,
    is_inside: bool,
    (expected, help): (String, &str),
) -> bool {
    if !is_inside {
        let path = section.path_of(key);
        let written = shown(section.as_written(key).unwrap_or_default());
        let message = format!("`{path}` is `{written}`, expected {expected}");
        section.problem(key, message, help);
    }
    is_inside
}

/// Two ends of a range on an axis, the smaller one first.
pub(super) fn ascending(
    section: &Section<'_>,
    key: &'static str,
    [low, high]: [f64; 2],
) -> Option<(Millimetres, Millimetres)> {
    if low < high {
        return Some((Millimetres::new(low), Millimetres::new(high)));
    }
    let path = section.path_of(key);
    section.problem(
        key,
        format!(
            "`{path}` makes a range from {low} to {high} mm, expected the smaller coordinate first"
        ),
        "write the smallest machine coordinate, then the largest",
    );
    None
}

/// Notes a coordinate that lies outside a range of its axis.
pub(super) fn inside(
    section: &Section<'_>,
    key: &'static str,
    (axis, at): (Axis, f64),
    (low, high): (Millimetres, Millimetres),
    range: &str,
) {
    let (low, high) = (low.mm(), high.mm());
    if at < low - TRAVEL_TOLERANCE_MM || at > high + TRAVEL_TOLERANCE_MM {
        let (path, at) = (section.path_of(key), Millimetres::new(at).shown());
        section.problem(
            key,
            format!("`{path}` puts {axis} at {at} mm, outside {range} {low} … {high} mm"),
            "machine coordinates are meant: check them, and `travel_mm`",
        );
    }
}

/// The coordinates that stand under these keys; all three must be given.
pub(super) fn coordinates(section: &Section<'_>, keys: PerAxis<&'static str>) -> Option<Places> {
    let read = PerAxis::from_fn(|axis| {
        require(section, &[(keys[axis], "a number of each axis, mm")]);
        section.millimetres(keys[axis]).map(Millimetres::new)
    });
    all_of(read)
}

/// A place `{ x = …, y = …, z = … }`, if the key is present.
pub(super) fn place(parent: &Section<'_>, key: &'static str) -> Option<Places> {
    sub(parent, key, |s| coordinates(s, PerAxis::from_fn(Axis::key))).flatten()
}

/// Places of some of the axes.
pub(super) fn some_places(parent: &Section<'_>, key: &'static str) -> PerAxis<Option<Millimetres>> {
    let of = |s: &Section<'_>, axis: Axis| s.millimetres(axis.key()).map(Millimetres::new);
    let read = sub(parent, key, |s| PerAxis::from_fn(|axis| of(s, axis)));
    read.unwrap_or_default()
}

/// The values of all axes, if there are three.
pub(super) fn all_of<T: Copy>(read: PerAxis<Option<T>>) -> Option<PerAxis<T>> {
    let (x, y, z) = (read.x?, read.y?, read.z?);
    Some(PerAxis { x, y, z })
}

/// A text that is printed; a character that is not seen would reach files and the terminal as a command.
pub(super) fn plain_text(section: &Section<'_>, key: &'static str) -> Option<String> {
    let text = section.text(key)?;
    if text.contains(is_unseen) {
        let path = section.path_of(key);
        section.problem(
            key,
            format!("`{path}` holds a line break or another character that is not seen"),
            "write it in one line of plain letters and digits",
        );
    }
    Some(text)
}

/// `"+"` or `"-"`.
pub(super) fn direction(section: &Section<'_>, key: &'static str) -> Option<Direction> {
    section.choice(key, &[("+", Direction::Plus), ("-", Direction::Minus)])
}
