//! Places, sizes and orders of axes as a job writes them.

use crate::inputs::job::MachineAxis;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::PathKind;
use crate::quantity::units::Millimetres;
use crate::text::document::{LONGEST_MM, Section};
use crate::text::problem::shown;

pub(super) const SMALLEST_SIZE_MM: f64 = 1e-3; // below it a box is no volume of a machine tool

/// What a place or a box may pass the travel by: the last digit of a coordinate, mm.
pub(super) const TRAVEL_TOLERANCE_MM: f64 = 1e-6;

pub(super) type Axes = PerAxis<Option<MachineAxis>>;

/// A place, by its coordinates in a section; all three must be given.
pub(super) fn places(parent: &Section<'_>, key: &'static str) -> Option<PerAxis<Millimetres>> {
    let section = parent.section(key)?;
    let read = PerAxis::from_fn(|axis| {
        if !section.has(axis.key()) {
            section.missing(axis.key(), "a number of each axis, mm");
        }
        section.millimetres(axis.key())
    });
    section.refuse_unknown_keys();
    all_of(read)
}

/// Places of some of the axes.
pub(super) fn some_places(parent: &Section<'_>, key: &'static str) -> PerAxis<Option<Millimetres>> {
    let Some(section) = parent.section(key) else {
        return PerAxis::default();
    };
    let read = PerAxis::from_fn(|axis| section.millimetres(axis.key()).map(Millimetres::new));
    section.refuse_unknown_keys();
    read
}

pub(super) fn size(parent: &Section<'_>) -> Option<PerAxis<Millimetres>> {
    let section = parent.section("size_mm")?;
    let read = PerAxis::from_fn(|axis| {
        if !section.has(axis.key()) {
            section.missing(axis.key(), "the edge along this axis, mm");
        }
        section.within(axis.key(), SMALLEST_SIZE_MM, LONGEST_MM, "mm")
    });
    section.refuse_unknown_keys();
    all_of(read)
}

pub(super) fn all_of(read: PerAxis<Option<f64>>) -> Option<PerAxis<Millimetres>> {
    let (x, y, z) = (read.x?, read.y?, read.z?);
    Some(PerAxis { x, y, z }).map(|place| PerAxis::from_fn(|axis| Millimetres::new(place[axis])))
}

pub(super) fn steps(section: &Section<'_>) -> Option<usize> {
    if !section.has("steps") {
        section.missing("steps", "the number of steps of each axis");
    }
    let steps = section.whole("steps")?;
    if !(1..=MOST_STEPS).contains(&steps) {
        section.problem(
            "steps",
            format!("`steps` is {steps}, expected 1 … {MOST_STEPS}"),
            "give the number of steps that each axis makes along a diagonal",
        );
        return None;
    }
    usize::try_from(steps).ok()
}

pub(super) fn order(section: &Section<'_>, kind: PathKind) -> Option<[Axis; 3]> {
    let [x, y, z] = Axis::ALL;
    if !section.has("order") {
        if kind == PathKind::Straight {
            return Some(Axis::ALL);
        }
        section.missing(
            "order",
            "the order of the single-axis moves inside a cell, e.g. \"XYZ\"",
        );
    }
    section.choice_in_any_case(
        "order",
        &[
            ("XYZ", [x, y, z]),
            ("XZY", [x, z, y]),
            ("YXZ", [y, x, z]),
            ("YZX", [y, z, x]),
            ("ZXY", [z, x, y]),
            ("ZYX", [z, y, x]),
        ],
    )
}

/// A number of either sign between two bounds, if the key is present.
pub(super) fn between(
    section: &Section<'_>,
    key: &'static str,
    (low, high): (f64, f64),
    unit: &str,
    help: &str,
) -> Option<f64> {
    let number = section.number(key)?;
    if (low..=high).contains(&number) {
        return Some(number);
    }
    let written = shown(section.as_written(key).unwrap_or_default());
    section.problem(
        key,
        format!(
            "`{}` is `{written}`, expected {low} … {high} {unit}",
            section.path_of(key)
        ),
        help,
    );
    None
}

const MOST_STEPS: u32 = 8_000; // eighty times the steps of any published measurement; four diagonals fit into one file
