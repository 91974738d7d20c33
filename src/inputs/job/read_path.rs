//! `[path]` of a job.

use crate::inputs::job::read_places::{all_of, places};
use crate::inputs::job::{MachineAxis, PathRequest};
use crate::inputs::nc::{G43WithoutH, WithoutPoint, system_number};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::Millimetres;
use crate::text::document::Section;
use crate::text::problem::shown;
use std::collections::BTreeMap;

const MOST_TOOL_NUMBER: u32 = 9999;
const LONGEST_TOOL_MM: f64 = 10_000.0;
const FINEST_CHORD_MM: f64 = 1e-5;
const COARSEST_CHORD_MM: f64 = 1.0;
const FINEST_ARC_MM: f64 = 1e-4;
/// Beyond a tenth of a millimetre the arc is not the one that was meant.
const COARSEST_ARC_MM: f64 = 0.1;
const FINEST_SAMPLE_MM: f64 = 1e-3;
const COARSEST_SAMPLE_MM: f64 = 1e4;

/// A place so near to the travel is inside (rounding), mm.
const TRAVEL_TOLERANCE_MM: f64 = 1e-4;

const COORDINATES: PerAxis<&str> = PerAxis {
    x: "x_mm",
    y: "y_mm",
    z: "z_mm",
};

pub(super) fn path(section: &Section<'_>, axes: &PerAxis<Option<MachineAxis>>) -> PathRequest {
    let usual = PathRequest::default();
    let inside = |key: &'static str| {
        let place = places(section, key)?;
        for axis in Axis::ALL {
            check_travel(section, key, (axis, place[axis]), axes);
        }
        Some(place)
    };
    let request = PathRequest {
        start: inside("start_mm"),
        second_reference: inside("second_reference_mm"),
        systems: systems(section),
        tools: tools(section),
        measured_tool_mm: section.within("measured_tool_mm", 0.0, LONGEST_TOOL_MM, "mm"),
        inch: section
            .choice("program_unit", &[("mm", false), ("inch", true)])
            .unwrap_or(usual.inch),
        without_point: section
            .choice(
                "without_point",
                &[
                    ("unit", WithoutPoint::Unit),
                    ("increment", WithoutPoint::Increment),
                ],
            )
            .unwrap_or(usual.without_point),
        g43_without_h: section
            .choice(
                "g43_without_h",
                &[
                    ("refuse", G43WithoutH::Refuse),
                    ("last-h", G43WithoutH::LastH),
                    ("tool", G43WithoutH::Tool),
                ],
            )
            .unwrap_or(usual.g43_without_h),
        arc_mm: section.within("arc_mm", FINEST_ARC_MM, COARSEST_ARC_MM, "mm"),
        skip_deletable: section
            .choice("block_delete", &[("execute", false), ("skip", true)])
            .unwrap_or(usual.skip_deletable),
        rapid: section
            .choice("moves", &[("feed", false), ("all", true)])
            .unwrap_or(usual.rapid),
        chord_mm: section
            .within("chord_mm", FINEST_CHORD_MM, COARSEST_CHORD_MM, "mm")
            .unwrap_or(usual.chord_mm),
        sample_mm: section
            .within("sample_mm", FINEST_SAMPLE_MM, COARSEST_SAMPLE_MM, "mm")
            .unwrap_or(usual.sample_mm),
        refuse_outside: section
            .choice("outside", &[("hold", false), ("refuse", true)])
            .unwrap_or(usual.refuse_outside),
        datum: datum(section, axes),
    };
    section.refuse_unknown_keys();
    request
}

/// `[[path.offset]]`.
fn systems(section: &Section<'_>) -> BTreeMap<u32, PerAxis<Millimetres>> {
    let mut systems = BTreeMap::new();
    for entry in section.sections("offset") {
        let name = entry.required_text(
            "system",
            "a coordinate system, e.g. \"G54\" or \"G54.1 P7\"",
        );
        let place = place(&entry);
        entry.refuse_unknown_keys();
        let Some(name) = name else { continue };
        let Some(number) = system_number(&name) else {
            entry.problem(
                "system",
                format!("`{}` is no coordinate system", shown(&name)),
                "expected G54 … G59, G59.1 … G59.3 or G54.1 P1 … P300",
            );
            continue;
        };
        let Some(place) = place else { continue };
        if systems.insert(number, place).is_some() {
            entry.problem(
                "system",
                format!("`{}` stands twice", shown(&name)),
                "keep one of the two",
            );
        }
    }
    systems
}

/// `[[path.tool]]`.
fn tools(section: &Section<'_>) -> BTreeMap<u32, f64> {
    let mut tools = BTreeMap::new();
    for entry in section.sections("tool") {
        for (key, expected) in [
            ("number", "the number of the tool offset (H)"),
            ("length_mm", "the length of the tool"),
        ] {
            if !entry.has(key) {
                entry.missing(key, expected);
            }
        }
        let number = entry.whole("number");
        let length = entry.within("length_mm", -LONGEST_TOOL_MM, LONGEST_TOOL_MM, "mm");
        entry.refuse_unknown_keys();
        let (Some(number), Some(length)) = (number, length) else {
            continue;
        };
        if number == 0 || number > MOST_TOOL_NUMBER {
            entry.problem(
                "number",
                format!("`number` is {number}, expected 1 … {MOST_TOOL_NUMBER}"),
                "H0 is no length",
            );
        } else if tools.insert(number, length).is_some() {
            entry.problem(
                "number",
                format!("tool offset {number} stands twice"),
                "keep one of the two",
            );
        }
    }
    tools
}

/// `[[path.datum]]`.
fn datum(section: &Section<'_>, axes: &PerAxis<Option<MachineAxis>>) -> Vec<PerAxis<Millimetres>> {
    let entries = section.sections("datum");
    let read = entries.iter().filter_map(|entry| {
        let place = place(entry);
        entry.refuse_unknown_keys();
        for (axis, mm) in place
            .iter()
            .flat_map(|p| Axis::ALL.map(|axis| (axis, p[axis])))
        {
            check_travel(entry, COORDINATES[axis], (axis, mm), axes);
        }
        place
    });
    read.collect()
}

/// A place where the machine cannot be.
fn check_travel(
    section: &Section<'_>,
    key: &'static str,
    (axis, at): (Axis, Millimetres),
    axes: &PerAxis<Option<MachineAxis>>,
) {
    let Some(travel) = axes[axis] else { return };
    let (low, high) = (travel.low.mm(), travel.high.mm());
    let room = low - TRAVEL_TOLERANCE_MM..=high + TRAVEL_TOLERANCE_MM;
    if !room.contains(&at.mm()) {
        section.problem(
            key,
            format!(
                "`{}` puts {axis} at {} mm, outside the travel {low} … {high} mm",
                section.path_of(key),
                at.mm()
            ),
            "machine coordinates are meant: check them, and `travel_mm`",
        );
    }
}

/// `x_mm`, `y_mm`, `z_mm`.
fn place(entry: &Section<'_>) -> Option<PerAxis<Millimetres>> {
    let read = PerAxis::from_fn(|axis| {
        if !entry.has(COORDINATES[axis]) {
            entry.missing(COORDINATES[axis], "a machine coordinate, mm");
        }
        entry.millimetres(COORDINATES[axis])
    });
    all_of(read)
}
