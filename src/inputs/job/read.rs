//! Job TOML → [`crate::inputs::job::Job`]: every key of contract §2.3, and nothing else.

use crate::inputs::job::read_compensation::compensation;
use crate::inputs::job::read_measurement::measurement;
use crate::inputs::job::read_path::path;
use crate::inputs::job::read_program::program;
use crate::inputs::job::read_words::{
    LARGEST_LIMIT, SMALLEST_LIMIT, axes, direction, refuse_control_characters,
};
use crate::inputs::job::{
    Acceptance, Compensation, LARGEST_BUMP_UM, LEAST_BUMP_UM, Limits, Machine, MachineAxis,
    Measurement, PathRequest, ProgramRequest, UseOf,
};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::chain::Chain;
use crate::quantity::units::Millimetres;
use crate::text::document::Section;
use crate::text::problem::shown;

const DEFAULT_MAX_CORRECTION_UM: f64 = 500.0; // contract §2.3
/// A reference point may lie this far outside the travel unless the job allows more, mm: some machines
/// have it a few millimetres beyond their limits; what is farther is more often a slip.
const REFERENCE_OUTSIDE_MM: f64 = 100.0; // contract §2.3
const DEFAULT_MAX_SLOPE_UM_PER_MM: f64 = 1.0; // contract §2.3

// Beyond these numbers a job describes no machine; within them no calculation overflows.
const SMALLEST_FEED_MM_PER_MIN: f64 = 1e-3;
const LARGEST_FEED_MM_PER_MIN: f64 = 1e6;

type Parts = (
    Machine,
    Measurement,
    Compensation,
    Limits,
    Acceptance,
    Option<ProgramRequest>,
    PathRequest,
);

pub(super) fn job(root: &Section<'_>, use_of: UseOf) -> Option<Parts> {
    match root.whole("schema") {
        Some(1) => {}
        Some(other) => root.problem(
            "schema",
            format!("`schema` is {other}, but this version reads jobs with `schema = 1`"),
            "use the version of the program that the job was written for",
        ),
        None if root.has("schema") => {}
        None => root.problem(
            "schema",
            "`schema` is missing, expected `schema = 1` in the first line",
            "add `schema = 1` above everything else",
        ),
    }
    let machine = root.required_section("machine").and_then(|s| machine(&s));
    let axes = machine.as_ref().map(|m| m.axes).unwrap_or_default();
    let measurement = root
        .required_section("measurement")
        .and_then(|s| measurement(&s, &axes));
    let compensation = if use_of == UseOf::Figures && !root.has("compensation") {
        Some(Compensation::none())
    } else {
        root.required_section("compensation")
            .and_then(|s| compensation(&s))
    };
    let limits = limits(root);
    let acceptance = acceptance(root, &axes);
    let program = root
        .section("program")
        .map(|s| program(&s, measurement.as_ref()));
    let path = root.section("path").map(|s| path(&s, &axes));
    let path = path.unwrap_or_default();
    let program = match program {
        Some(program) => Some(program?),
        None => None,
    };
    Some((
        machine?,
        measurement?,
        compensation?,
        limits,
        acceptance,
        program,
        path,
    ))
}

fn machine(section: &Section<'_>) -> Option<Machine> {
    let name = section.required_text("name", "the machine's name");
    let serial = section.text("serial");
    refuse_control_characters(section, "name", name.as_deref());
    refuse_control_characters(section, "serial", serial.as_deref());
    let chain = chain(section);
    let axes = axes(section, machine_axis);
    section.refuse_unknown_keys();
    Some(Machine {
        name: name?,
        serial,
        chain,
        axes,
    })
}

/// The kinematic chain, if the job states one.
fn chain(section: &Section<'_>) -> Option<Chain> {
    let text = section.text("chain")?;
    let chain = Chain::parse(&text);
    if chain.is_none() {
        section.problem(
            "chain",
            format!("`chain` is `{}`, expected each of X, Y, Z once, `w` where the workpiece is and `t` at the end", shown(&text)),
            "for instance `wXYZt`, `XwYZt` or `XYwZt`",
        );
    }
    chain
}

fn machine_axis(section: &Section<'_>) -> Option<MachineAxis> {
    if !section.has("travel_mm") {
        section.missing("travel_mm", "the ends of the travel, e.g. [0.0, 900.0]");
    }
    if !section.has("reference_mm") {
        section.missing(
            "reference_mm",
            "the machine coordinate of the reference point",
        );
    }
    let travel = section.pair_of_millimetres("travel_mm");
    if let Some([low, high]) = travel
        && low >= high
    {
        let message = if low > high {
            format!("the travel ends at {high} mm, before it begins at {low} mm")
        } else {
            format!("the travel begins and ends at {low} mm, expected two different ends")
        };
        section.problem(
            "travel_mm",
            message,
            "write [smallest, largest] machine coordinate",
        );
    }
    let reference = section.millimetres("reference_mm");
    let outside = section.not_negative("reference_outside_mm");
    let reference_direction = direction(section, "reference_direction");
    let max_feed = section.within(
        "max_feed_mm_per_min",
        SMALLEST_FEED_MM_PER_MIN,
        LARGEST_FEED_MM_PER_MIN,
        "mm/min",
    );
    section.refuse_unknown_keys();
    let ([low, high], reference) = (travel.filter(|[low, high]| low < high)?, reference?);
    refuse_far_reference(section, [low, high], reference, outside);
    Some(MachineAxis {
        low: Millimetres::new(low),
        high: Millimetres::new(high),
        reference: Millimetres::new(reference),
        reference_direction,
        max_feed,
    })
}

/// The tables are zero at the reference point: far from the travel, they would be zero nowhere on it.
fn refuse_far_reference(
    section: &Section<'_>,
    [low, high]: [f64; 2],
    reference: f64,
    allowed_mm: Option<f64>,
) {
    let most = allowed_mm.unwrap_or(REFERENCE_OUTSIDE_MM);
    let outside = (low - reference).max(reference - high);
    if outside > most {
        section.problem(
            "reference_mm",
            format!("the reference point {reference} mm lies {} mm outside the travel {low} … {high} mm, expected at most {most} mm", Millimetres::new(outside).shown()),
            format!("correct `reference_mm` or `travel_mm` (machine coordinates); if the axis really has it there, write `reference_outside_mm = {}` below it", outside.ceil()),
        );
    }
}

fn limits(root: &Section<'_>) -> Limits {
    let section = root.section("limits");
    let read = |key, unit, default| {
        section
            .as_ref()
            .and_then(|s| s.within(key, SMALLEST_LIMIT, LARGEST_LIMIT, unit))
            .unwrap_or(default)
    };
    let limits = Limits {
        max_correction_um: read("max_correction_um", "µm", DEFAULT_MAX_CORRECTION_UM),
        max_slope_um_per_mm: read("max_slope_um_per_mm", "µm/mm", DEFAULT_MAX_SLOPE_UM_PER_MM),
        max_bump_um: section
            .as_ref()
            .and_then(|s| s.within("max_bump_um", LEAST_BUMP_UM, LARGEST_BUMP_UM, "µm"))
            .unwrap_or(LARGEST_BUMP_UM),
    };
    if let Some(section) = section {
        section.refuse_unknown_keys();
    }
    limits
}

fn acceptance(root: &Section<'_>, axes: &PerAxis<Option<MachineAxis>>) -> Acceptance {
    let Some(section) = root.section("acceptance") else {
        return Acceptance::default();
    };
    let range = section.section("range_mm").map(|s| {
        let range = PerAxis::from_fn(|axis| judged_range(&s, axis, axes[axis]));
        s.refuse_unknown_keys();
        range
    });
    let acceptance = Acceptance {
        max_deviation_um: section.within("max_deviation_um", SMALLEST_LIMIT, LARGEST_LIMIT, "µm"),
        max_diagonal_um: section.within("max_diagonal_um", SMALLEST_LIMIT, LARGEST_LIMIT, "µm"),
        range: range.unwrap_or_default(),
    };
    section.refuse_unknown_keys();
    acceptance
}

/// The part of an axis that is to be judged; it lies inside the travel.
fn judged_range(
    section: &Section<'_>,
    axis: Axis,
    machine: Option<MachineAxis>,
) -> Option<(Millimetres, Millimetres)> {
    let key = axis.key();
    let [low, high] = section.pair_of_millimetres(key)?;
    let (from, to) = (Millimetres::new(low), Millimetres::new(high));
    let inside = machine.is_none_or(|m| from >= m.low && to <= m.high);
    if low < high && inside {
        return Some((from, to));
    }
    let travel = machine.map_or_else(String::new, |m| {
        format!(" inside the travel, {} to {} mm", m.low.mm(), m.high.mm())
    });
    section.problem(
        key,
        format!("the range to be judged is {low} to {high} mm, expected a range{travel}"),
        "write [smallest, largest] machine coordinate",
    );
    None
}
