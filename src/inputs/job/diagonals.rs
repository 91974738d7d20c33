//! `[measurement.step_diagonal]`: how the body diagonals were measured (contract §2.3).

use crate::inputs::job::machine::{Axes, inside_travel};
use crate::inputs::refusals;
use crate::quantity::{Axis, Direction, Millimetres, PathKind, PerAxis, Volume};
use crate::text::{LONGEST_MM, Places, Section, Word, section, words};
use std::ops::RangeInclusive;

section! {
    /// A measurement of the four body diagonals.
    #[derive(Clone, Debug, PartialEq)]
    pub struct DiagonalMeasurement(section: &Section<'_>, axes: &Axes, path: String) {
        /// Path of the readings, relative to the job.
        pub readings: String => path;
        /// or "straight": all axes together
        pub kind: PathKind = choice(&KINDS), or PathKind::Step;
        /// straight runs only: compare with what this error table predicts
        pub closure_errors: Option<String> = with(|s, key| of_straight(s, key, kind));
        /// what reflects the beam: or "retroreflector"
        pub target: Reflector = with(|s, key| target(s, key, kind));
        /// The measured box.
        pub volume: Volume => box_inside_travel(section, kind, axes), must;
        // `Minus` where the instrument counts towards the laser head.
        /// where the laser counts the other way
        pub laser_sign: Direction = direction(), or Direction::Plus;
        /// mirror and beam: solved for, or "assume-perfect", labelled in every output
        pub setup: SetUp = choice(SetUp::WORDS), or SetUp::Solve;
        /// of the cross terms: or "as-measured"
        pub frame: Frame = choice(Frame::WORDS), or Frame::XPrimary;
        /// whether the axes ran past the end point before the return pass; absent: judged from the readings
        pub overrun: Option<bool> = flag();
        /// positioning of one axis along its length
        pub linear: Vec<Linear> = with(linear);
        /// displacement along any other straight line
        pub beams as beam: Vec<Beam> = subs(|beam| one_beam(beam, axes, volume.as_ref(), kind));
        /// temperature of the scales, and what was corrected already
        pub material: Option<Material> = sub(Material::read);
    }
}

impl DiagonalMeasurement {
    /// One of which nothing is stated but the path.
    pub(crate) fn along(kind: PathKind, volume: Volume) -> DiagonalMeasurement {
        DiagonalMeasurement {
            readings: String::new(),
            kind,
            closure_errors: None,
            target: Reflector::usual(kind),
            volume,
            laser_sign: Direction::Plus,
            setup: SetUp::Solve,
            frame: Frame::XPrimary,
            overrun: None,
            linear: Vec::new(),
            beams: Vec::new(),
            material: None,
        }
    }
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

section! {
    /// One `[[measurement.step_diagonal.linear]]`: positioning error of an axis along its length.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Linear(section: &Section<'_>) {
        /// `x`, `y` or `z`
        pub axis: Axis = choice_by(&Axis::ALL.map(|axis| (axis.key(), axis)), IN_ANY_CASE), must "`x`, `y` or `z`";
        /// positioning error at the largest coordinate minus that at the smallest, µm, divided by their distance in m
        pub slope as slope_um_per_m: LinearSlope = with(linear_slope), must;
        /// its standard uncertainty (k = 1) without `setup_ppm`; without this line a verdict is at most undecided
        pub u_um_per_m: Option<f64> = not_negative();
    }
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

const PLACE: &str = "a place, e.g. { x = 0.0, y = 0.0, z = 0.0 }";

section! {
    /// One `[[measurement.step_diagonal.beam]]`: displacement measured along any other straight line.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Beam(section: &Section<'_>) {
        /// where the line begins, machine coordinates
        pub from as from_mm: Places = place(), must PLACE;
        /// where it ends
        pub to as to_mm: Places = place(), must PLACE;
        /// displacement error along the line by its length
        pub slope_um_per_m: f64 = with(slope), must "the displacement error by length, µm/m";
        /// its standard uncertainty (k = 1) without `setup_ppm`; without this line a verdict is at most undecided
        pub u_um_per_m: Option<f64> = not_negative();
    }
}

section! {
    /// `[measurement.step_diagonal.material]`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Material(section: &Section<'_>) {
        /// whether the readings hold a correction of the scales' expansion already; must be stated
        pub material_corrected: bool = flag(),
            must "`true` or `false`: correcting the scales twice costs 11 µm/m for each K";
        /// whether they hold a correction of the air's refraction already; must be stated
        pub air_corrected: bool = flag(),
            must "`true` or `false`: whether the readings are corrected for the air already";
        /// Of each axis; absent where the job gives none.
        pub axes: PerAxis<Option<AxisMaterial>> =>
            PerAxis::from_fn(|axis| section.sub(axis.key(), AxisMaterial::read));
    }
}

section! {
    /// Expansion of one axis' scale.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct AxisMaterial(section: &Section<'_>) {
        /// coefficient of linear expansion, 1/K
        pub alpha_per_k: f64 = between(ALPHAS_PER_K, "1/K"),
            must "the expansion of the scale, e.g. 11.5e-6";
        /// mean temperature during the measurement; absent where each reading carries its own
        pub temperature_c: Option<f64> = between(TEMPERATURES_C, "°C");
    }
}

const IN_ANY_CASE: fn(&str, &str) -> bool = str::eq_ignore_ascii_case;
const SMALLEST_SIZE_MM: f64 = 1e-3; // below it a box is no volume of a machine tool
const MOST_STEPS: u32 = 8_000; // eighty times the steps of any published measurement; four diagonals fit into one file
const STEEPEST_UM_PER_M: f64 = 1e4; // 10 mm on a metre: no axis that still cuts is so long or short
const ALPHAS_PER_K: RangeInclusive<f64> = -1e-4..=1e-4; // four times aluminium
pub(crate) const TEMPERATURES_C: RangeInclusive<f64> = -10.0..=50.0; // nobody measures outside these; they refuse °F as well

const KINDS: [(&str, PathKind); 2] = [("step", PathKind::Step), ("straight", PathKind::Straight)];

const STRAIGHT: &str = "`kind = \"straight\"`";

fn target(section: &Section<'_>, key: &'static str, kind: PathKind) -> Reflector {
    let stated = section.choice(key, Reflector::WORDS);
    let fits = kind == PathKind::Straight || stated != Some(Reflector::Retroreflector);
    section.only_with(key, fits, STRAIGHT);
    stated.unwrap_or(Reflector::usual(kind))
}

fn of_straight(section: &Section<'_>, key: &'static str, kind: PathKind) -> Option<String> {
    section.only_with(key, kind == PathKind::Straight, STRAIGHT);
    section.text(key)
}

fn box_inside_travel(section: &Section<'_>, kind: PathKind, axes: &Axes) -> Option<Volume> {
    let volume = volume(section, kind, None, true)?;
    inside_travel(section, |_| "start_mm", &volume.start, axes);
    let end = PerAxis::from_fn(|axis| volume.start[axis] + volume.size[axis]);
    inside_travel(section, |_| "size_mm", &end, axes);
    Some(volume)
}

section! {
    pub(super) struct BoxKeys(section: &Section<'_>) {
        /// corner with the smallest machine coordinates
        start_mm: Option<Places> = place();
        /// edges of the box
        size_mm: Option<Places> = sub(size);
        /// of each axis along a diagonal
        steps: Option<u32> =
            count(1..=MOST_STEPS, "give the number of steps that each axis makes along a diagonal");
        /// in which the axes move
        order: Option<[Axis; 3]> =
            choice_by(&Axis::ORDERS.map(|order| (Axis::letters(&order), order)), IN_ANY_CASE);
    }
}

/// What has to be stated of the box, the last one of step runs.
const OF_BOX: [(&str, &str); 4] = [
    (
        "start_mm",
        "the corner with the smallest machine coordinates, e.g. { x = 10.0, y = 10.0, z = -400.0 }",
    ),
    ("size_mm", "the edges of the measured box, e.g. { x = 900.0, y = 720.0, z = 720.0 }"),
    ("steps", "the number of steps of each axis"),
    ("order", "the order of the single-axis moves inside a cell, e.g. \"XYZ\""),
];

/// The measured box; what is not stated here is that of `usual`.
pub(super) fn volume(
    section: &Section<'_>,
    kind: PathKind,
    usual: Option<&Volume>,
    is_required: bool,
) -> Option<Volume> {
    let is_straight = kind == PathKind::Straight;
    for (key, what) in &OF_BOX[..if is_straight { 3 } else { 4 }] {
        if is_required {
            section.require(key, what);
        }
    }
    let keys = BoxKeys::read(section)?;
    let steps = keys.steps.and_then(|steps| usize::try_from(steps).ok());
    Some(Volume {
        start: keys.start_mm.or(usual.map(|v| v.start))?,
        size: keys.size_mm.or(usual.map(|v| v.size))?,
        steps: steps.or(usual.map(|v| v.steps))?,
        order: keys.order.or(usual.map(|v| v.order)).or(is_straight.then_some(Axis::ALL))?,
    })
}

fn size(section: &Section<'_>) -> Option<Places> {
    let size = PerAxis::from_fn(|axis| {
        section.require(axis.key(), "the edge along this axis, mm");
        section.between(axis.key(), SMALLEST_SIZE_MM..=LONGEST_MM, "mm").map(Millimetres::new)
    });
    size.all()
}

/// The lines along single axes, each axis once.
fn linear(section: &Section<'_>, key: &'static str) -> Vec<Linear> {
    let mut seen = Vec::new();
    section.subs(key, |section| {
        let linear = Linear::read(section)?;
        if seen.contains(&linear.axis) {
            section.refuse("axis", refusals::two_lines(linear.axis));
        }
        seen.push(linear.axis);
        Some(linear)
    })
}

/// The slope, or `errors`, a table of it.
fn linear_slope(section: &Section<'_>, key: &'static str) -> Option<LinearSlope> {
    section.not_both("errors", key, "keep one");
    if !section.has("errors") {
        let slope = "the slope of the positioning error, µm/m, or `errors = …` with a table of it";
        section.require(key, slope);
    }
    let stated = slope(section, key).map(LinearSlope::Stated);
    let errors = section.text("errors").map(LinearSlope::Errors);
    let is_empty = section.as_written(key) == Some("\"\"");
    stated.or(errors).or(is_empty.then_some(LinearSlope::NotYet))
}

fn slope(section: &Section<'_>, key: &'static str) -> Option<f64> {
    section.between(key, -STEEPEST_UM_PER_M..=STEEPEST_UM_PER_M, "µm/m")
}

fn one_beam(
    section: &Section<'_>,
    axes: &Axes,
    volume: Option<&Volume>,
    kind: PathKind,
) -> Option<Beam> {
    let beam = Beam::read(section)?;
    let (from, to) = (beam.from, beam.to);
    if Axis::ALL.iter().all(|axis| (to[*axis] - from[*axis]).mm().abs() < SMALLEST_SIZE_MM) {
        section.refuse("to_mm", refusals::beam_of_one_place());
    }
    for axis in Axis::ALL {
        // Along an axis that moves the shapes of the errors are known inside the box only.
        let moves = volume.filter(|_| from[axis] != to[axis]);
        let boxed = moves.map(|v| (v.start[axis], v.start[axis] + v.size[axis]));
        let travel = axes[axis].map(|machine| (machine.low, machine.high));
        let what = boxed.map_or("the travel", |_| "the box of the diagonals");
        // Straight runs hold no shapes to take off.
        let is_whole = |volume: &Volume| {
            let length = (to[axis] - from[axis]).mm().abs();
            (length - volume.size[axis].mm()).abs() < SMALLEST_SIZE_MM
        };
        if kind == PathKind::Straight && !moves.is_none_or(is_whole) {
            section.refuse("to_mm", refusals::beam_inside(axis));
        }
        if let Some(ends) = boxed.or(travel) {
            section.inside("from_mm", (axis, from[axis]), ends, what);
            section.inside("to_mm", (axis, to[axis]), ends, what);
        }
    }
    Some(beam)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::job::{Job, LinearSlope, MeasuredData, Measurement};
    use crate::text::Source;

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
