//! What keys of a section have in common: places, ranges, and keys that need or exclude each other.
//!
//! Every problem is noted at its key, and a page with a problem is refused, so a value that could not
//! be read may come back as its default.

use super::Section;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::units::Millimetres;
use crate::text::plain::is_unseen;
use std::ops::RangeInclusive;

/// What a place may pass the travel by: the last digit of a coordinate, mm.
const TRAVEL_TOLERANCE_MM: f64 = 1e-4;

/// A limit of a correction or of what is left: none of a machine is smaller or larger, µm or µm/mm.
pub(crate) const LIMITS: RangeInclusive<f64> = 1e-6..=1e9;

/// One place, or one length of each axis.
pub(crate) type Places = PerAxis<Millimetres>;

impl Section<'_> {
    /// A sub-section, if it is there, of which `read` takes all keys that may stand in it.
    pub(crate) fn sub<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Section<'_>) -> T,
    ) -> Option<T> {
        self.section(key).map(|section| whole(&section, read))
    }

    /// The same of a list of sub-sections.
    pub(crate) fn subs<T>(
        &self,
        key: &'static str,
        mut read: impl FnMut(&Section<'_>) -> Option<T>,
    ) -> Vec<T> {
        let sections = self.sections(key);
        let read = sections.iter().filter_map(|section| whole(section, &mut read));
        read.collect()
    }

    /// The sub-sections `axes.x`, `axes.y`, `axes.z`.
    pub(crate) fn axes<T>(&self, read: impl Fn(&Section<'_>) -> Option<T>) -> PerAxis<Option<T>> {
        let of = |axes: &Section<'_>, axis: Axis| axes.sub(axis.key(), &read).flatten();
        let axes = self.sub("axes", |axes| PerAxis::from_fn(|axis| of(axes, axis)));
        axes.unwrap_or_else(|| PerAxis::from_fn(|_| None))
    }

    /// Notes a key that is missing, with what it is.
    pub(crate) fn require(&self, key: &'static str, expected: &str) {
        if !self.has(key) {
            self.missing(key, expected);
        }
    }

    /// Notes a key that has an effect only with something else, which is not so.
    pub(crate) fn only_with(&self, key: &'static str, is_so: bool, with: &str) {
        if self.has(key) && !is_so {
            let path = self.path_of(key);
            self.problem(
                key,
                format!("`{path}` as it stands goes only with {with}"),
                format!("remove or change it, or write {with}"),
            );
        }
    }

    /// Notes two keys of which one is enough.
    pub(crate) fn not_both(&self, key: &'static str, other: &'static str, help: &str) {
        if self.has(key) && self.has(other) {
            let message = format!("`{other}` and `{key}` are both given, expected one of the two");
            self.problem(key, message, help);
        }
    }

    /// A number between two bounds, if the key is present.
    pub(crate) fn between(
        &self,
        key: &'static str,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Option<f64> {
        let number = self.number(key)?;
        self.in_range(key, number, range, unit)
    }

    /// A length above 0 and up to a bound, mm, if the key is present.
    pub(crate) fn length_up_to(&self, key: &'static str, most_mm: f64) -> Option<f64> {
        let number = self.positive(key)?;
        self.in_range(key, number, 0.0..=most_mm, "mm")
    }

    fn in_range(
        &self,
        key: &'static str,
        number: f64,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Option<f64> {
        if !range.contains(&number) {
            let expected = format!("{} … {} {unit}", range.start(), range.end());
            self.out_of_range(key, &expected, "check the number and its unit");
        }
        Some(number).filter(|number| range.contains(number))
    }

    /// A whole number between two bounds, if the key is present.
    pub(crate) fn count(
        &self,
        key: &'static str,
        range: RangeInclusive<u32>,
        help: &str,
    ) -> Option<u32> {
        let number = self.whole(key)?;
        if !range.contains(&number) {
            let expected = match range.end() {
                &u32::MAX => format!("at least {}", range.start()),
                most => format!("{} … {most}", range.start()),
            };
            self.out_of_range(key, &expected, help);
        }
        Some(number).filter(|number| range.contains(number))
    }

    fn out_of_range(&self, key: &'static str, expected: &str, help: &str) {
        let (path, written) = (self.path_of(key), self.written(key));
        let message = format!("`{path}` is `{written}`, expected {expected}");
        self.problem(key, message, help);
    }

    /// Two ends of a range on an axis, the smaller one first.
    pub(crate) fn ascending(
        &self,
        key: &'static str,
        [low, high]: [f64; 2],
    ) -> Option<(Millimetres, Millimetres)> {
        if low < high {
            return Some((Millimetres::new(low), Millimetres::new(high)));
        }
        let path = self.path_of(key);
        self.problem(
            key,
            format!("`{path}` makes a range from {low} to {high} mm, expected the smaller coordinate first"),
            "write the smallest machine coordinate, then the largest",
        );
        None
    }

    /// Notes a coordinate that lies outside a range of its axis.
    pub(crate) fn inside(
        &self,
        key: &'static str,
        (axis, at): (Axis, Millimetres),
        (low, high): (Millimetres, Millimetres),
        range: &str,
    ) {
        let (low, high) = (low.mm(), high.mm());
        if at.mm() < low - TRAVEL_TOLERANCE_MM || at.mm() > high + TRAVEL_TOLERANCE_MM {
            let (path, at) = (self.path_of(key), at.shown());
            self.problem(
                key,
                format!("`{path}` puts {axis} at {at} mm, outside {range} {low} … {high} mm"),
                "machine coordinates are meant: check them, and `travel_mm`",
            );
        }
    }

    /// The coordinates that stand under these keys; all three must be given.
    pub(crate) fn coordinates(&self, keys: PerAxis<&'static str>) -> Option<Places> {
        let read = PerAxis::from_fn(|axis| {
            self.require(keys[axis], "a number of each axis, mm");
            self.millimetres(keys[axis]).map(Millimetres::new)
        });
        read.all()
    }

    /// A place `{ x = …, y = …, z = … }`, if the key is present.
    pub(crate) fn place(&self, key: &'static str) -> Option<Places> {
        let read = |s: &Section<'_>| s.coordinates(PerAxis::from_fn(Axis::key));
        self.sub(key, read).flatten()
    }

    /// Places of some of the axes.
    pub(crate) fn some_places(&self, key: &'static str) -> PerAxis<Option<Millimetres>> {
        let of = |s: &Section<'_>, axis: Axis| s.millimetres(axis.key()).map(Millimetres::new);
        let read = self.sub(key, |s| PerAxis::from_fn(|axis| of(s, axis)));
        read.unwrap_or_default()
    }

    /// A text that is printed; a character that is not seen would reach files and the terminal as a command.
    pub(crate) fn plain_text(&self, key: &'static str) -> Option<String> {
        let text = self.text(key)?;
        if text.contains(is_unseen) {
            let path = self.path_of(key);
            self.problem(
                key,
                format!("`{path}` holds a line break or another character that is not seen"),
                "write it in one line of plain letters and digits",
            );
        }
        Some(text)
    }

    /// `"+"` or `"-"`.
    pub(crate) fn direction(&self, key: &'static str) -> Option<Direction> {
        self.choice(key, &Direction::BOTH.map(|way| (way.symbol(), way)))
    }
}

fn whole<T>(section: &Section<'_>, read: impl FnOnce(&Section<'_>) -> T) -> T {
    let value = read(section);
    section.refuse_unknown_keys();
    value
}
