//! `[[…linear]]` and `[[…beam]]` of a job: lines that were measured beside the diagonals.

use crate::inputs::job::read_places::{
    Axes, SMALLEST_SIZE_MM, TRAVEL_TOLERANCE_MM, between, places,
};
use crate::inputs::job::{Beam, Linear, LinearSlope};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::Volume;
use crate::quantity::units::Millimetres;
use crate::text::document::Section;

const STEEPEST_UM_PER_M: f64 = 1e4; // 10 mm on a metre: no axis that still cuts is so long or short

pub(super) fn linear(section: &Section<'_>) -> Vec<Linear> {
    let mut measured: Vec<Linear> = Vec::new();
    for section in section.sections("linear") {
        let Some(linear) = one_linear(&section) else {
            continue;
        };
        if measured.iter().any(|other| other.axis == linear.axis) {
            section.problem(
                "axis",
                format!(
                    "axis {} has two linear measurements, expected one",
                    linear.axis
                ),
                "keep one of the two, or give their mean",
            );
        }
        measured.push(linear);
    }
    measured
}

fn one_linear(section: &Section<'_>) -> Option<Linear> {
    if !section.has("axis") {
        section.missing("axis", "`x`, `y` or `z`");
    }
    let axis = section.choice_in_any_case("axis", &Axis::ALL.map(|axis| (axis.key(), axis)));
    let stated = slope(section);
    let errors = section.text("errors");
    let u_um_per_m = section.not_negative("u_um_per_m");
    match (section.has("slope_um_per_m"), section.has("errors")) {
        (true, true) => section.problem(
            "errors",
            "`slope_um_per_m` and `errors` are both given for one axis, expected one of the two",
            "keep one",
        ),
        (false, false) => section.missing(
            "slope_um_per_m",
            "the slope of the positioning error, µm/m, or `errors = …` with a table of it",
        ),
        _ => {}
    }
    section.refuse_unknown_keys();
    let stated = stated.map(LinearSlope::Stated);
    Some(Linear {
        axis: axis?,
        slope: stated.or(errors.map(LinearSlope::Errors))?,
        u_um_per_m,
    })
}

fn slope(section: &Section<'_>) -> Option<f64> {
    between(
        section,
        "slope_um_per_m",
        (-STEEPEST_UM_PER_M, STEEPEST_UM_PER_M),
        "µm/m",
        "20 µm too long on a metre is 20",
    )
}

pub(super) fn beams(section: &Section<'_>, axes: &Axes, volume: Option<&Volume>) -> Vec<Beam> {
    let sections = section.sections("beam");
    let read = sections.iter().filter_map(|s| beam(s, axes, volume));
    read.collect()
}

fn beam(section: &Section<'_>, axes: &Axes, volume: Option<&Volume>) -> Option<Beam> {
    for key in ["from_mm", "to_mm"] {
        if !section.has(key) {
            section.missing(key, "a place, e.g. { x = 0.0, y = 0.0, z = 0.0 }");
        }
    }
    if !section.has("slope_um_per_m") {
        section.missing("slope_um_per_m", "the displacement error by length, µm/m");
    }
    let from = end_of_beam(section, "from_mm", axes);
    let to = end_of_beam(section, "to_mm", axes);
    let slope_um_per_m = slope(section);
    let u_um_per_m = section.not_negative("u_um_per_m");
    section.refuse_unknown_keys();
    let (from, to) = (from?, to?);
    if Axis::ALL
        .iter()
        .all(|axis| (to[*axis] - from[*axis]).mm().abs() < SMALLEST_SIZE_MM)
    {
        section.problem(
            "to_mm",
            "the beam begins and ends at one place, expected two",
            "give the two ends of the measured line",
        );
    }
    if let Some(volume) = volume {
        refuse_outside_box(section, volume, from, to);
    }
    Some(Beam {
        from,
        to,
        slope_um_per_m: slope_um_per_m?,
        u_um_per_m,
    })
}

/// What the shapes of the errors contribute between the ends of a beam is known inside the box
/// only. An axis that rests may stand anywhere.
fn refuse_outside_box(
    section: &Section<'_>,
    volume: &Volume,
    from: PerAxis<Millimetres>,
    to: PerAxis<Millimetres>,
) {
    for axis in Axis::ALL {
        let low = volume.start[axis].mm();
        let high = low + volume.size[axis].mm();
        let outside =
            |here: f64| here < low - TRAVEL_TOLERANCE_MM || here > high + TRAVEL_TOLERANCE_MM;
        let rests = (to[axis] - from[axis]).mm() == 0.0;
        for (key, place) in [("from_mm", from), ("to_mm", to)] {
            let here = place[axis].mm();
            if !rests && outside(here) {
                section.problem(
                    key,
                    format!("the beam moves {axis} to {here} mm, but the diagonals go from {low} to {high} mm"),
                    "measure it inside the box of the diagonals: outside it the shapes of the errors are not known, and nothing is extrapolated",
                );
            }
        }
    }
}

fn end_of_beam(
    section: &Section<'_>,
    key: &'static str,
    axes: &Axes,
) -> Option<PerAxis<Millimetres>> {
    let place = places(section, key)?;
    let mut reachable = true;
    for axis in Axis::ALL {
        let Some(travel) = &axes[axis] else { continue };
        let (low, high, here) = (travel.low.mm(), travel.high.mm(), place[axis].mm());
        if here < low - TRAVEL_TOLERANCE_MM || here > high + TRAVEL_TOLERANCE_MM {
            reachable = false;
            section.problem(
                key,
                format!(
                    "an end of the beam is at {axis} {here} mm, but the travel is {low} mm … {high} mm"
                ),
                "give machine coordinates",
            );
        }
    }
    reachable.then_some(place)
}
