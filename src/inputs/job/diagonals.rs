//! `[measurement.step_diagonal]`: how the body diagonals were measured (contract §2.3).

use crate::inputs::job::machine::{Axes, inside_travel};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::document::keys::Places;
use crate::text::document::{LONGEST_MM, Section};
use crate::text::words::{Word, words};

/// A measurement of the four body diagonals.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagonalMeasurement {
    /// Path of the readings, relative to the job.
    pub readings: String,
    /// Single-axis steps or straight.
    pub kind: PathKind,
    /// The measured box.
    pub volume: Volume,
    /// `Minus` where the instrument counts towards the laser head.
    pub laser_sign: Direction,
    /// Whether the tilt of the mirror is solved for.
    pub setup: SetUp,
    /// Frame of the cross terms.
    pub frame: Frame,
    /// What the beam is reflected by.
    pub target: Reflector,
    /// Whether the axes ran past the end point before the reverse pass; `None` = judged from the data.
    pub overrun: Option<bool>,
    /// Measurements of single axes along their length.
    pub linear: Vec<Linear>,
    /// Measurements along other straight lines.
    pub beams: Vec<Beam>,
    /// Temperature of the scales and what was corrected already.
    pub material: Option<Material>,
    /// Path of an error table that a straight run is compared with (closure test).
    pub closure_errors: Option<String>,
}

words! {
    /// What is assumed of the direction of mirror and beam in the four set-ups.
    pub enum SetUp {
        /// Unknown in every set-up, solved for.
        Solve = "solve",
        /// Exactly along the nominal diagonals: labelled in every output.
        AssumePerfect = "assume-perfect",
    }
}

words! {
    /// Frame in which the slopes of the cross terms are given.
    pub enum Frame {
        /// X primary, XY plane secondary: EYX, EZX and EZY have no slope.
        XPrimary = "x-primary",
        /// The slopes as they fell out.
        AsMeasured = "as-measured",
    }
}

impl Frame {
    /// The frame of a word.
    pub(crate) fn from_word(word: &str) -> Option<Frame> {
        let known = Frame::WORDS.iter().find(|(known, _)| *known == word);
        known.map(|(_, frame)| *frame)
    }
}

words! {
    /// What reflects the beam.
    pub enum Reflector {
        /// A flat mirror: needed for single-axis steps; it turns with the tool.
        FlatMirror = "flat-mirror",
        /// A retroreflector: for straight runs.
        Retroreflector = "retroreflector",
    }
}

impl Reflector {
    /// What such runs are measured with where nobody says it.
    pub(super) const fn usual(kind: PathKind) -> Reflector {
        match kind {
            PathKind::Step => Reflector::FlatMirror,
            PathKind::Straight => Reflector::Retroreflector,
        }
    }
}

/// One `[[measurement.step_diagonal.linear]]`: positioning error of an axis along its length.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// The axis.
    pub axis: Axis,
    /// Its slope.
    pub slope: LinearSlope,
    /// Standard uncertainty (k = 1) of the slope, µm/m.
    pub u_um_per_m: Option<f64>,
}

/// Where the slope of a linear measurement comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum LinearSlope {
    /// Stated, µm/m.
    Stated(f64),
    /// The positioning error in an error table: its path, relative to the job.
    Errors(String),
    /// Not measured yet: in jobs that are read for a plan or for programs.
    NotYet,
}

/// One `[[measurement.step_diagonal.beam]]`: displacement measured along any other straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the line begins, machine coordinates.
    pub from: PerAxis<Millimetres>,
    /// Where it ends.
    pub to: PerAxis<Millimetres>,
    /// Displacement error along the line by its length, µm/m.
    pub slope_um_per_m: f64,
    /// Standard uncertainty (k = 1) of the slope, µm/m.
    pub u_um_per_m: Option<f64>,
}

/// `[measurement.step_diagonal.material]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The readings hold a correction of the scales' expansion already.
    pub material_corrected: bool,
    /// The readings hold a correction of the air's refraction already.
    pub air_corrected: bool,
    /// Of each axis; absent where the job gives none.
    pub axes: PerAxis<Option<AxisMaterial>>,
}

/// Expansion of one axis' scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMaterial {
    /// Coefficient of linear expansion, 1/K.
    pub alpha_per_k: f64,
    /// Mean temperature during the measurement, °C; `None` where each reading carries its own.
    pub temperature_c: Option<f64>,
}

const SMALLEST_SIZE_MM: f64 = 1e-3; // below it a box is no volume of a machine tool
const MOST_STEPS: u32 = 8_000; // eighty times the steps of any published measurement; four diagonals fit into one file
const STEEPEST_UM_PER_M: f64 = 1e4; // 10 mm on a metre: no axis that still cuts is so long or short
const LARGEST_ALPHA_PER_K: f64 = 1e-4; // four times aluminium
const COLDEST_C: f64 = -10.0; // nobody measures outside these temperatures; they refuse °F as well
const WARMEST_C: f64 = 50.0;

const ORDERS: [(&str, [Axis; 3]); 6] = [
    ("XYZ", Axis::ORDERS[0]),
    ("XZY", Axis::ORDERS[1]),
    ("YXZ", Axis::ORDERS[2]),
    ("YZX", Axis::ORDERS[3]),
    ("ZXY", Axis::ORDERS[4]),
    ("ZYX", Axis::ORDERS[5]),
];
const KINDS: [(&str, PathKind); 2] = [("step", PathKind::Step), ("straight", PathKind::Straight)];

/// The section; `readings` is the path beside it.
pub(super) fn diagonals(
    section: &Section<'_>,
    axes: &Axes,
    readings: String,
) -> Option<DiagonalMeasurement> {
    let kind = section.choice("kind", &KINDS).unwrap_or(PathKind::Step);
    let is_straight = kind == PathKind::Straight;
    let straight = "`kind = \"straight\"`";
    section.only_with("closure_errors", is_straight, straight);
    let target = section.choice("target", Reflector::WORDS);
    let is_mirror = target != Some(Reflector::Retroreflector);
    section.only_with("target", is_straight || is_mirror, straight);
    let volume = volume(section, kind, None, true);
    if let Some(volume) = &volume {
        inside_travel(section, |_| "start_mm", &volume.start, axes);
        let end = PerAxis::from_fn(|axis| volume.start[axis] + volume.size[axis]);
        inside_travel(section, |_| "size_mm", &end, axes);
    }
    Some(DiagonalMeasurement {
        readings,
        kind,
        laser_sign: section.direction("laser_sign").unwrap_or(Direction::Plus),
        setup: section.choice("setup", SetUp::WORDS).unwrap_or(SetUp::Solve),
        frame: section.choice("frame", Frame::WORDS).unwrap_or(Frame::XPrimary),
        target: target.unwrap_or(Reflector::usual(kind)),
        overrun: section.flag("overrun"),
        closure_errors: section.text("closure_errors"),
        linear: linear(section),
        beams: section.subs("beam", |beam| one_beam(beam, axes, volume.as_ref())),
        material: section.sub("material", material),
        volume: volume?, // what stands above is read for its problems
    })
}

/// The measured box; what is not stated here is that of `usual`.
pub(super) fn volume(
    section: &Section<'_>,
    kind: PathKind,
    usual: Option<&Volume>,
    is_required: bool,
) -> Option<Volume> {
    let order = "the order of the single-axis moves inside a cell, e.g. \"XYZ\"";
    let needed = [
        (
            "start_mm",
            "the corner with the smallest machine coordinates, e.g. { x = 10.0, y = 10.0, z = -400.0 }",
        ),
        ("size_mm", "the edges of the measured box, e.g. { x = 900.0, y = 720.0, z = 720.0 }"),
        ("steps", "the number of steps of each axis"),
        ("order", order),
    ];
    let count_needed = if kind == PathKind::Step { 4 } else { 3 };
    for (key, what) in needed.into_iter().take(count_needed) {
        if is_required {
            section.require(key, what);
        }
    }
    let start = section.place("start_mm").or(usual.map(|v| v.start));
    let size = section.sub("size_mm", size).map_or(usual.map(|v| v.size), |size| size);
    let help = "give the number of steps that each axis makes along a diagonal";
    let steps = section.count("steps", 1..=MOST_STEPS, help);
    let steps = steps.and_then(|steps| usize::try_from(steps).ok());
    let order = section.choice_in_any_case("order", &ORDERS);
    let straight = (kind == PathKind::Straight).then_some(Axis::ALL);
    Some(Volume {
        start: start?,
        size: size?,
        steps: steps.or(usual.map(|v| v.steps))?,
        order: order.or(usual.map(|v| v.order)).or(straight)?,
    })
}

fn size(section: &Section<'_>) -> Option<Places> {
    let size = PerAxis::from_fn(|axis| {
        section.require(axis.key(), "the edge along this axis, mm");
        let size = section.between(axis.key(), SMALLEST_SIZE_MM..=LONGEST_MM, "mm");
        size.map(Millimetres::new)
    });
    size.all()
}

fn material(section: &Section<'_>) -> Material {
    section.require(
        "material_corrected",
        "`true` or `false`: correcting the scales twice costs 11 µm/m for each K",
    );
    section.require(
        "air_corrected",
        "`true` or `false`: whether the readings are corrected for the air already",
    );
    Material {
        material_corrected: section.flag("material_corrected").unwrap_or_default(),
        air_corrected: section.flag("air_corrected").unwrap_or_default(),
        axes: PerAxis::from_fn(|axis| section.sub(axis.key(), axis_material)),
    }
}

fn axis_material(section: &Section<'_>) -> AxisMaterial {
    let steel = "the expansion of the scale, e.g. 11.5e-6";
    section.require("alpha_per_k", steel);
    let alpha = -LARGEST_ALPHA_PER_K..=LARGEST_ALPHA_PER_K;
    AxisMaterial {
        alpha_per_k: section.between("alpha_per_k", alpha, "1/K").unwrap_or_default(),
        temperature_c: section.between("temperature_c", COLDEST_C..=WARMEST_C, "°C"),
    }
}

/// The lines along single axes, each axis once.
fn linear(section: &Section<'_>) -> Vec<Linear> {
    let mut seen = Vec::new();
    section.subs("linear", |section| {
        let linear = one_linear(section)?;
        if seen.contains(&linear.axis) {
            let axis = linear.axis;
            let message = format!("axis {axis} has two linear measurements, expected one");
            section.problem("axis", message, "keep one of the two, or give their mean");
        }
        seen.push(linear.axis);
        Some(linear)
    })
}

fn one_linear(section: &Section<'_>) -> Option<Linear> {
    section.require("axis", "`x`, `y` or `z`");
    section.not_both("errors", "slope_um_per_m", "keep one");
    if !section.has("errors") {
        let slope = "the slope of the positioning error, µm/m, or `errors = …` with a table of it";
        section.require("slope_um_per_m", slope);
    }
    let axis = section.choice_in_any_case("axis", &Axis::ALL.map(|axis| (axis.key(), axis)));
    let stated = slope(section).map(LinearSlope::Stated);
    let errors = section.text("errors").map(LinearSlope::Errors);
    let is_empty = section.as_written("slope_um_per_m") == Some("\"\"");
    let not_yet = is_empty.then_some(LinearSlope::NotYet);
    let u_um_per_m = section.not_negative("u_um_per_m");
    Some(Linear { axis: axis?, slope: stated.or(errors).or(not_yet)?, u_um_per_m })
}

fn slope(section: &Section<'_>) -> Option<f64> {
    let slopes = -STEEPEST_UM_PER_M..=STEEPEST_UM_PER_M;
    section.between("slope_um_per_m", slopes, "µm/m")
}

fn one_beam(section: &Section<'_>, axes: &Axes, volume: Option<&Volume>) -> Option<Beam> {
    let example = "a place, e.g. { x = 0.0, y = 0.0, z = 0.0 }";
    let slope_um_per_m = "the displacement error by length, µm/m";
    section.require("from_mm", example);
    section.require("to_mm", example);
    section.require("slope_um_per_m", slope_um_per_m);
    let (from, to) = (section.place("from_mm"), section.place("to_mm"));
    let slope_um_per_m = slope(section);
    let u_um_per_m = section.not_negative("u_um_per_m");
    let (from, to) = (from?, to?);
    let length = |axis: Axis| (to[axis] - from[axis]).mm().abs();
    let is_short = |axis: &Axis| length(*axis) < SMALLEST_SIZE_MM;
    if Axis::ALL.iter().all(is_short) {
        let message = "the beam begins and ends at one place, expected two";
        section.problem("to_mm", message, "give the two ends of the measured line");
    }
    refuse_unreachable(section, (from, to), axes, volume);
    Some(Beam { from, to, slope_um_per_m: slope_um_per_m?, u_um_per_m })
}

/// Notes ends of a beam outside the travel, or outside the box of the diagonals along an axis that moves:
/// what the shapes of the errors contribute to a beam is known inside it only.
fn refuse_unreachable(
    section: &Section<'_>,
    (from, to): (Places, Places),
    axes: &Axes,
    volume: Option<&Volume>,
) {
    for axis in Axis::ALL {
        let moves = volume.filter(|_| from[axis] != to[axis]);
        let boxed = moves.map(|v| (v.start[axis], v.start[axis] + v.size[axis]));
        let travel = axes[axis].map(|machine| (machine.low, machine.high));
        let what = boxed.map_or("the travel", |_| "the box of the diagonals");
        if let Some(ends) = boxed.or(travel) {
            section.inside("from_mm", (axis, from[axis]), ends, what);
            section.inside("to_mm", (axis, to[axis]), ends, what);
        }
    }
}

#[cfg(test)]
mod tests {
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
        // The middle of the box.
        assert_eq!(measurement.levers.offsets.y, Some(Millimetres::new(-40.0)));
        assert_eq!(measurement.levers.angles_zero, measurement.levers.offsets);
        let tool = measurement.levers.tool.expect("it is stated");
        assert_eq!(tool.z, Millimetres::new(-120.0));
        assert!(measurement.notes().is_empty());
        let read = diagonals(measurement);
        assert_eq!(read.volume.order, [Axis::Z, Axis::X, Axis::Y]);
        assert_eq!((read.kind, read.target), (PathKind::Step, Reflector::FlatMirror));
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
        assert_eq!((read.kind, read.target), (PathKind::Straight, Reflector::Retroreflector));
        assert_eq!((read.laser_sign, read.overrun), (Direction::Minus, Some(true)));
        assert_eq!(read.closure_errors.as_deref(), Some("errors.csv"));
        assert_eq!(read.linear[0].slope, LinearSlope::Errors("y-linear.csv".to_string()));
        assert_eq!(read.beams[0].to.y, Millimetres::new(-80.0));
        let material = read.material.expect("it is stated");
        assert!(material.air_corrected && !material.material_corrected);
        let y = material.axes.y.expect("it is stated");
        assert_eq!((y.alpha_per_k, y.temperature_c), (8e-6, None));
    }
}
