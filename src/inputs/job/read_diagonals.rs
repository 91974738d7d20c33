//! `[measurement.step_diagonal]` of a job: how the body diagonals were measured.

use crate::inputs::job::read_beams::{beams, linear};
use crate::inputs::job::read_places::{
    Axes, TRAVEL_TOLERANCE_MM, between, order, places, size, steps,
};
use crate::inputs::job::read_words::direction;
use crate::inputs::job::{AxisMaterial, DiagonalMeasurement, Frame, Material, Reflector, SetUp};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::document::Section;

const LARGEST_ALPHA_PER_K: f64 = 1e-4; // four times aluminium
const COLDEST_C: f64 = -10.0; // nobody measures outside these temperatures; they refuse °F as well
const WARMEST_C: f64 = 50.0;

/// The section; `readings` is the path beside it.
pub(super) fn diagonals(
    section: &Section<'_>,
    axes: &Axes,
    readings: Option<String>,
) -> Option<DiagonalMeasurement> {
    let kind = kind(section);
    let volume = volume(section, kind, axes);
    let target = target(section, kind);
    let laser_sign = direction(section, "laser_sign").unwrap_or(Direction::Plus);
    let setup = section.choice(
        "setup",
        &[
            ("solve", SetUp::Solve),
            ("assume-perfect", SetUp::AssumePerfect),
        ],
    );
    let frame = section.choice(
        "frame",
        &[
            ("x-primary", Frame::XPrimary),
            ("as-measured", Frame::AsMeasured),
        ],
    );
    let overrun = section.flag("overrun");
    let closure_errors = closure_errors(section, kind);
    let linear = linear(section);
    let beams = beams(section, axes, volume.as_ref());
    let material = section.section("material").map(|s| material(&s));
    section.refuse_unknown_keys();
    Some(DiagonalMeasurement {
        readings: readings?,
        kind,
        volume: volume?,
        laser_sign,
        setup: setup.unwrap_or(SetUp::Solve),
        frame: frame.unwrap_or(Frame::XPrimary),
        target,
        overrun,
        linear,
        beams,
        material: match material {
            Some(material) => Some(material?),
            None => None,
        },
        closure_errors,
    })
}

fn kind(section: &Section<'_>) -> PathKind {
    let words = [("step", PathKind::Step), ("straight", PathKind::Straight)];
    section.choice("kind", &words).unwrap_or(PathKind::Step)
}

fn volume(section: &Section<'_>, kind: PathKind, axes: &Axes) -> Option<Volume> {
    let example = "e.g. { x = 0.0, y = 0.0, z = 0.0 }";
    if !section.has("start_mm") {
        let expected = format!("the corner with the smallest machine coordinates, {example}");
        section.missing("start_mm", &expected);
    }
    if !section.has("size_mm") {
        section.missing(
            "size_mm",
            "the edges of the measured box, e.g. { x = 900.0, y = 720.0, z = 720.0 }",
        );
    }
    let start = places(section, "start_mm");
    let size = size(section);
    let steps = steps(section);
    let order = order(section, kind);
    let (start, size) = (start?, size?);
    refuse_box_outside_travel(section, &start, &size, axes);
    Some(Volume {
        start,
        size,
        steps: steps?,
        order: order?,
    })
}

fn refuse_box_outside_travel(
    section: &Section<'_>,
    start: &PerAxis<Millimetres>,
    size: &PerAxis<Millimetres>,
    axes: &Axes,
) {
    for axis in Axis::ALL {
        let Some(travel) = &axes[axis] else { continue };
        let (from, to) = (start[axis].mm(), digits_of((start[axis] + size[axis]).mm()));
        let key = if from < travel.low.mm() - TRAVEL_TOLERANCE_MM {
            "start_mm"
        } else if to > travel.high.mm() + TRAVEL_TOLERANCE_MM {
            "size_mm"
        } else {
            continue;
        };
        section.problem(
            key,
            format!(
                "the measured box reaches from {axis} {from} mm to {to} mm, but the travel is {} mm … {} mm",
                travel.low.mm(),
                travel.high.mm()
            ),
            "`start_mm` is the corner with the smallest machine coordinates, `size_mm` the edges of the box",
        );
    }
}

/// A sum of coordinates without the digits that binary numbers add.
fn digits_of(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6 + 0.0
}

fn target(section: &Section<'_>, kind: PathKind) -> Reflector {
    let words = [
        ("flat-mirror", Reflector::FlatMirror),
        ("retroreflector", Reflector::Retroreflector),
    ];
    let usual = match kind {
        PathKind::Step => Reflector::FlatMirror,
        PathKind::Straight => Reflector::Retroreflector,
    };
    let target = section.choice("target", &words).unwrap_or(usual);
    if kind == PathKind::Step && target == Reflector::Retroreflector {
        section.problem(
            "target",
            "`target` is `retroreflector`, but the target of single-axis steps leaves the diagonal sideways, expected `flat-mirror`",
            "write `kind = \"straight\"` if all axes moved together",
        );
    }
    target
}

fn closure_errors(section: &Section<'_>, kind: PathKind) -> Option<String> {
    let path = section.text("closure_errors")?;
    if kind == PathKind::Step {
        section.problem(
            "closure_errors",
            "`closure_errors` compares straight runs with an error table, but these runs are of single-axis steps",
            "remove it, or write `kind = \"straight\"` if all axes moved together",
        );
    }
    Some(path)
}

fn material(section: &Section<'_>) -> Option<Material> {
    let stated = [
        (
            "material_corrected",
            "`true` or `false`: correcting the scales twice costs 11 µm/m for each K",
        ),
        (
            "air_corrected",
            "`true` or `false`: whether the readings are corrected for the air already",
        ),
    ];
    for (key, expected) in stated {
        if !section.has(key) {
            section.missing(key, expected);
        }
    }
    let material_corrected = section.flag("material_corrected");
    let air_corrected = section.flag("air_corrected");
    let mut complete = true;
    let axes = PerAxis::from_fn(|axis| {
        let given = section.section(axis.key())?;
        let read = axis_material(&given);
        complete &= read.is_some();
        read
    });
    section.refuse_unknown_keys();
    Some(Material {
        material_corrected: material_corrected?,
        air_corrected: air_corrected?,
        axes: complete.then_some(axes)?,
    })
}

fn axis_material(section: &Section<'_>) -> Option<AxisMaterial> {
    if !section.has("alpha_per_k") {
        section.missing("alpha_per_k", "the expansion of the scale, e.g. 11.5e-6");
    }
    let alpha_per_k = between(
        section,
        "alpha_per_k",
        (-LARGEST_ALPHA_PER_K, LARGEST_ALPHA_PER_K),
        "1/K",
        "a steel scale has 11.5e-6",
    );
    let temperature_c = between(
        section,
        "temperature_c",
        (COLDEST_C, WARMEST_C),
        "°C",
        "give degrees Celsius",
    );
    section.refuse_unknown_keys();
    Some(AxisMaterial {
        alpha_per_k: alpha_per_k?,
        temperature_c,
    })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::expect_used,
        clippy::panic,
        reason = "a test that cannot go on has to stop"
    )]

    use super::*;
    use crate::inputs::job::{Job, LinearSlope, MeasuredData, Measurement};
    use crate::text::document::Source;

    fn measurement(more: &str) -> Measurement {
        let page = format!(
            r#"
schema = 1
[machine]
name = "VMC"
[compensation]
controller = "generic"
[measurement]
readings = "readings.csv"
angles = "angles.csv"
tool_offset_mm = {{ x = 0.0, y = 0.0, z = -120.0 }}
[measurement.uncertainty]
laser_ppm = 0.1
[measurement.step_diagonal]
start_mm = {{ x = 0.0, y = -80.0, z = 0.0 }}
size_mm = {{ x = 100.0, y = 80.0, z = 80.0 }}
steps = 4
{more}
"#
        );
        let source = Source::from_bytes("job.toml", page.as_bytes()).expect("it is text");
        Job::read(source).expect("it is a job").measurement
    }

    fn diagonals(measurement: Measurement) -> DiagonalMeasurement {
        match measurement.data {
            MeasuredData::Diagonals(diagonals) => diagonals,
            MeasuredData::Errors(paths) => panic!("{paths:?} is no file of readings"),
        }
    }

    #[test]
    fn what_is_not_stated_has_the_value_of_the_contract() {
        let measurement = measurement("order = \"zXy\"");
        assert_eq!(measurement.angles.as_deref(), Some("angles.csv"));
        assert_eq!(measurement.uncertainty.laser_ppm, Some(0.1));
        assert_eq!(measurement.levers.offsets, PerAxis::default());
        let tool = measurement.levers.tool.expect("it is stated");
        assert_eq!(tool.z, Millimetres::new(-120.0));
        assert!(measurement.notes.is_empty());
        let read = diagonals(measurement);
        assert_eq!(read.volume.order, [Axis::Z, Axis::X, Axis::Y]);
        assert_eq!(
            (read.kind, read.target),
            (PathKind::Step, Reflector::FlatMirror)
        );
        assert_eq!((read.setup, read.frame), (SetUp::Solve, Frame::XPrimary));
        assert_eq!((read.laser_sign, read.overrun), (Direction::Plus, None));
    }

    #[test]
    fn everything_that_may_be_stated_is_read() {
        let read = diagonals(measurement(
            r#"
kind = "straight"
laser_sign = "-"
setup = "assume-perfect"
frame = "as-measured"
overrun = true
closure_errors = "errors.csv"
[[measurement.step_diagonal.linear]]
axis = "y"
errors = "y-linear.csv"
u_um_per_m = 0.5
[[measurement.step_diagonal.beam]]
from_mm = { x = 0.0, y = 0.0, z = 0.0 }
to_mm = { x = 100.0, y = -80.0, z = 0.0 }
slope_um_per_m = -3.5
[measurement.step_diagonal.material]
material_corrected = false
air_corrected = true
y = { alpha_per_k = 8e-6 }
"#,
        ));
        assert_eq!(
            (read.kind, read.target),
            (PathKind::Straight, Reflector::Retroreflector)
        );
        assert_eq!(
            (read.laser_sign, read.overrun),
            (Direction::Minus, Some(true))
        );
        assert_eq!(read.closure_errors.as_deref(), Some("errors.csv"));
        assert_eq!(
            read.linear[0].slope,
            LinearSlope::Errors("y-linear.csv".to_string())
        );
        assert_eq!(read.beams[0].to.y, Millimetres::new(-80.0));
        let material = read.material.expect("it is stated");
        assert!(material.air_corrected && !material.material_corrected);
        let y = material.axes.y.expect("it is stated");
        assert_eq!((y.alpha_per_k, y.temperature_c), (8e-6, None));
    }
}
