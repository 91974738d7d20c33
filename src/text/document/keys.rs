//! A struct that is its own schema: what a section of a page may hold stands once; and what its keys have in common:
//! places, ranges, and keys that need or exclude each other.
//!
//! Every problem is noted at its key, and a page with a problem is refused, so a value that could not
//! be read may come back as its default.

use super::Section;
use crate::quantity::{Axis, Direction, Millimetres, PerAxis};
use crate::text::{is_unseen, refusals, shown};
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
        read: impl FnOnce(&Section<'_>) -> Option<T>,
    ) -> Option<T> {
        whole(&self.section(key)?, read)
    }

    /// The same of one that stands for nothing stated where it is not there.
    pub(crate) fn sub_or_usual<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Section<'_>) -> Option<T>,
    ) -> Option<T> {
        whole(&self.section(key).unwrap_or_else(|| self.absent(key)), read)
    }

    /// The same of a list of sub-sections.
    pub(crate) fn subs<T>(
        &self,
        key: &'static str,
        mut read: impl FnMut(&Section<'_>) -> Option<T>,
    ) -> Vec<T> {
        self.sections(key).iter().filter_map(|section| whole(section, &mut read)).collect()
    }

    /// What stands under `x`, `y` and `z` of a sub-section.
    pub(crate) fn axes<T>(
        &self,
        key: &'static str,
        read: impl Fn(&Section<'_>, Axis) -> Option<T>,
    ) -> PerAxis<Option<T>> {
        self.sub(key, |s| Some(PerAxis::from_fn(|axis| read(s, axis)))).unwrap_or_default()
    }

    /// What a function makes of the key.
    pub(crate) fn with<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Section<'_>, &'static str) -> T,
    ) -> T {
        read(self, key)
    }

    /// Notes a key that is missing, with what it is.
    pub(crate) fn require(&self, key: &'static str, expected: &str) {
        if !self.has(key) && !self.is_absent() {
            let place = format!("`{key}` is missing{}", self.within());
            self.refuse(key, refusals::missing(place, expected, key));
        }
    }

    /// Notes a key that has an effect only with something else, which is not so.
    pub(crate) fn only_with(&self, key: &'static str, is_so: bool, with: &str) {
        if self.has(key) && !is_so {
            self.refuse(key, refusals::only_with(self.path_of(key), with));
        }
    }

    /// Notes two keys of which one is enough.
    pub(crate) fn not_both(&self, key: &'static str, other: &'static str, help: &str) {
        if self.has(key) && self.has(other) {
            self.refuse(key, refusals::not_both(key, other, help));
        }
    }

    /// A number between two bounds, if the key is present.
    pub(crate) fn between(
        &self,
        key: &'static str,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Option<f64> {
        let expected = || format!("{} … {} {unit}", range.start(), range.end());
        self.in_range(key, self.number(key)?, &range, (expected, "check the number and its unit"))
    }

    /// A whole number between two bounds, if the key is present.
    pub(crate) fn count(
        &self,
        key: &'static str,
        range: RangeInclusive<u32>,
        help: &str,
    ) -> Option<u32> {
        let expected = || match range.end() {
            &u32::MAX => format!("at least {}", range.start()),
            most => format!("{} … {most}", range.start()),
        };
        self.in_range(key, self.whole(key)?, &range, (expected, help))
    }

    fn in_range<T: PartialOrd>(
        &self,
        key: &'static str,
        value: T,
        range: &RangeInclusive<T>,
        (expected, help): (impl Fn() -> String, &str),
    ) -> Option<T> {
        if range.contains(&value) {
            return Some(value);
        }
        let (path, written) = (self.path_of(key), self.written(key));
        self.refuse(key, refusals::other_value(path, written, expected(), help));
        None
    }

    /// Two ends of a range on an axis, the smaller one first, if the key is present.
    pub(crate) fn ascending(&self, key: &'static str) -> Option<(Millimetres, Millimetres)> {
        self.in_order(key, self.pair_of_millimetres(key)?)
    }

    /// The ends of a range, the second of which stands under a key.
    pub(crate) fn in_order(
        &self,
        key: &'static str,
        [low, high]: [f64; 2],
    ) -> Option<(Millimetres, Millimetres)> {
        if low < high {
            return Some((Millimetres::new(low), Millimetres::new(high)));
        }
        self.refuse(key, refusals::backwards(self.path_of(key), low, high));
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
            self.refuse(key, refusals::outside(path, axis, at, range, low, high));
        }
    }

    /// A machine coordinate, if the key is present.
    pub(crate) fn coordinate(&self, key: &'static str) -> Option<Millimetres> {
        self.millimetres(key).map(Millimetres::new)
    }

    /// The coordinates that stand under these keys; all three must be given.
    pub(crate) fn coordinates(&self, keys: PerAxis<&'static str>) -> Option<Places> {
        let read = PerAxis::from_fn(|axis| {
            self.require(keys[axis], "a number of each axis, mm");
            self.coordinate(keys[axis])
        });
        read.all()
    }

    /// A place `{ x = …, y = …, z = … }`, if the key is present.
    pub(crate) fn place(&self, key: &'static str) -> Option<Places> {
        self.sub(key, |s| s.coordinates(PerAxis::from_fn(Axis::key)))
    }

    /// Places of some of the axes.
    pub(crate) fn some_places(&self, key: &'static str) -> PerAxis<Option<Millimetres>> {
        self.axes(key, |s, axis| s.coordinate(axis.key()))
    }

    /// A text that is printed; a character that is not seen would reach files and the terminal as a command.
    pub(crate) fn plain_text(&self, key: &'static str) -> Option<String> {
        let text = self.text(key)?;
        if text.contains(is_unseen) {
            self.refuse(key, refusals::unseen(self.path_of(key)));
        }
        Some(text)
    }

    /// What is made of a text; where that is nothing, a problem says what was expected and the next step.
    pub(crate) fn parsed<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&str) -> Option<T>,
        [expected, help]: [&str; 2],
    ) -> Option<T> {
        let text = self.text(key)?;
        let value = read(&text);
        if value.is_none() {
            self.refuse(key, refusals::other_value(key, shown(&text), expected, help));
        }
        value
    }

    /// `"+"` or `"-"`.
    pub(crate) fn direction(&self, key: &'static str) -> Option<Direction> {
        self.choice(key, &Direction::BOTH.map(|way| (way.symbol(), way)))
    }
}

fn whole<T>(section: &Section<'_>, read: impl FnOnce(&Section<'_>) -> Option<T>) -> Option<T> {
    let value = read(section);
    section.refuse_unknown_keys();
    value
}

/// A key of a section, for those who write pages and for the documents about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The key.
    pub name: &'static str,
    /// What it says, with unit and default.
    pub words: &'static str,
    /// The type that it is read into.
    pub of: &'static str,
}

/// A struct that is read from a section of a page. Each key stands here once, with its words, how it is
/// read, and what stands for an absent one:
///
/// ```text
/// key: Type = method(arguments)           what that method of the section makes of the key
/// field as key: Type = method(arguments)  the same, under another name
/// field: Type => expression               made of the section; fields above can be named
///   , or usual                            what stands for nothing
///   , must "words"                        the key has to be there, with what it is
///   , must                                nothing is made without it; why, is told already
/// ```
///
/// Every field is read before a missing one ends it, so all problems of the section are told at once.
macro_rules! section {
    (
        $(#[$of:meta])*
        $how:vis struct $name:ident($section:ident: $from:ty $(, $given:ident: $given_type:ty)*) {
            $(
                $(#[doc = $words:literal])*
                $shown:vis $field:ident $(as $key:ident)?: $type:ty
                    $(= $read:ident($($with:expr),*))? $(=> $value:expr)?
                    $(, or $usual:expr)? $(, must $($what:expr)?)?;
            )+
        }
    ) => {
        $(#[$of])*
        $how struct $name { $($(#[doc = $words])* $shown $field: $type,)+ }

        impl $name {
            /// Its keys, in the order in which they are read.
            $how const KEYS: &'static [Option<$crate::text::Key>] = &[$(
                $crate::text::part!(
                    @key $crate::text::part!(@name $field $($key)?),
                    concat!($($words),*), $type $(, $read)?
                )
            ),+];

            pub(crate) fn read($section: $from $(, $given: $given_type)*) -> Option<Self> {
                $(
                    $crate::text::part!(
                        @require $section $crate::text::part!(@name $field $($key)?) $($(, $what)?)?
                    );
                    let $field = $crate::text::part!(
                        @read $crate::text::part!(@name $field $($key)?),
                        $($section.$read($($with),*))? $(=> $value)?
                    )$(.unwrap_or($usual))?;
                )+
                Some(Self {
                    $($field: $crate::text::part!(@field $field $(or $usual)? $(must $($what)?)?)),+
                })
            }
        }
    };
}
pub(crate) use section;

/// A part of what [`section!`] makes of a field.
macro_rules! part {
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $key:ident) => { stringify!($key) };
    (@key $name:expr, $words:expr, $type:ty) => { None };
    (@key $name:expr, $words:expr, $type:ty, $read:ident) => {
        Some($crate::text::Key {
            name: $name,
            words: $words,
            of: stringify!($type),
        })
    };
    (@require $section:ident $name:expr) => {};
    (@require $section:ident $name:expr, $what:expr) => { $section.require($name, $what) };
    (@read $name:expr, $section:ident.$read:ident($($with:expr),*)) => {
        $section.$read($name, $($with),*)
    };
    (@read $name:expr, => $value:expr) => { $value };
    (@field $field:ident must $($what:expr)?) => { $field? };
    (@field $field:ident $($or:tt)*) => { $field };
}
pub(crate) use part;
