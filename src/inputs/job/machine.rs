//! `[machine]`, `[limits]` and `[acceptance]`: the machine, what is refused, and what is judged by.

use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::chain::Chain;
use crate::quantity::units::Millimetres;
use crate::text::document::Section;
use crate::text::document::keys::{LIMITS, Places};
use crate::text::problem::shown;

/// The machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name, as in reports.
    pub name: String,
    /// Serial number.
    pub serial: Option<String>,
    /// Kinematic chain in the notation of contract §1, e.g. `wXYZt`.
    pub chain: Option<Chain>,
    /// Its axes; absent where the job does not describe one.
    pub axes: PerAxis<Option<MachineAxis>>,
}

/// One axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineAxis {
    /// Smallest machine coordinate.
    pub low: Millimetres,
    /// Largest machine coordinate.
    pub high: Millimetres,
    /// Reference (home) point: every table is zero here.
    pub reference: Millimetres,
    /// Direction of the reference return, if the job states it.
    pub reference_direction: Option<Direction>,
    /// Largest feed, mm/min.
    pub max_feed: Option<f64>,
}

/// The axes of a machine.
pub(super) type Axes = PerAxis<Option<MachineAxis>>;

impl MachineAxis {
    /// The stated direction of the reference return, or +.
    pub(crate) fn homing(&self) -> Direction {
        self.reference_direction.unwrap_or(Direction::Plus)
    }

    /// Both ends of the travel, with the reference where it lies outside.
    pub(crate) fn reach(&self) -> (Millimetres, Millimetres) {
        let mm = |place: Millimetres| place.mm();
        let (low, high, reference) = (mm(self.low), mm(self.high), mm(self.reference));
        (Millimetres::new(low.min(reference)), Millimetres::new(high.max(reference)))
    }
}

/// `[limits]`: refuse rather than emit nonsense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest correction, µm.
    pub max_correction_um: f64,
    /// Largest slope, µm/mm.
    pub max_slope_um_per_mm: f64,
    /// Largest bump of a sign proof, µm; never more than [`LARGEST_BUMP_UM`].
    pub max_bump_um: f64,
}

/// No sign proof moves an axis by more, µm.
pub const LARGEST_BUMP_UM: f64 = 20.0;

/// A smaller bump is not seen beyond doubt on a dial gauge of 1 µm, µm.
pub const LEAST_BUMP_UM: f64 = 5.0;

impl Default for Limits {
    fn default() -> Self {
        Limits { max_correction_um: 500.0, max_slope_um_per_mm: 1.0, max_bump_um: LARGEST_BUMP_UM }
    }
}

/// `[acceptance]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Acceptance {
    /// Bound of what is left of every term, µm.
    pub max_deviation_um: Option<f64>,
    /// Bound of max − min along every body diagonal, µm.
    pub max_diagonal_um: Option<f64>,
    /// Part of an axis that is judged, machine coordinates; `None` = the whole travel.
    pub range: PerAxis<Option<(Millimetres, Millimetres)>>,
}

impl Acceptance {
    /// Whether there is no limit to judge by.
    pub(crate) fn asks_nothing(&self) -> bool {
        self.max_deviation_um.is_none() && self.max_diagonal_um.is_none()
    }
}

/// A reference point may lie this far outside the travel unless the job allows more, mm: some machines
/// have it a few millimetres beyond their limits; what is farther is more often a slip.
const REFERENCE_OUTSIDE_MM: f64 = 100.0; // contract §2.3

pub(super) fn machine(section: &Section<'_>) -> Machine {
    section.require("name", "the machine's name");
    Machine {
        name: section.plain_text("name").unwrap_or_default(),
        serial: section.plain_text("serial"),
        chain: chain(section),
        axes: section.axes(machine_axis),
    }
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
    section.require("travel_mm", "the ends of the travel, e.g. [0.0, 900.0]");
    section.require("reference_mm", "the machine coordinate of the reference point");
    let travel = section.pair_of_millimetres("travel_mm");
    let travel = travel.and_then(|travel| section.ascending("travel_mm", travel));
    let reference = section.millimetres("reference_mm").map(Millimetres::new);
    let outside = section.not_negative("reference_outside_mm");
    let reference_direction = section.direction("reference_direction");
    let max_feed = section.between("max_feed_mm_per_min", 1e-3..=1e6, "mm/min");
    let ((low, high), reference) = (travel?, reference?);
    let axis = MachineAxis { low, high, reference, reference_direction, max_feed };
    refuse_far_reference(section, &axis, outside.unwrap_or(REFERENCE_OUTSIDE_MM));
    Some(axis)
}

/// The tables are zero at the reference point: far from the travel, they would be zero nowhere on it.
fn refuse_far_reference(section: &Section<'_>, axis: &MachineAxis, most: f64) {
    let (low, high, reference) = (axis.low.mm(), axis.high.mm(), axis.reference.mm());
    let outside = (low - reference).max(reference - high);
    if outside > most {
        section.problem(
            "reference_mm",
            format!("the reference point {reference} mm lies {} mm outside the travel {low} … {high} mm, expected at most {most} mm", Millimetres::new(outside).shown()),
            format!("correct `reference_mm` or `travel_mm` (machine coordinates); if the axis really has it there, write `reference_outside_mm = {}` below it", outside.ceil()),
        );
    }
}

/// Notes the coordinates of a place where the machine cannot be.
pub(super) fn inside_travel(
    section: &Section<'_>,
    key: impl Fn(Axis) -> &'static str,
    place: &Places,
    axes: &Axes,
) {
    for (axis, machine) in axes.iter() {
        if let Some(MachineAxis { low, high, .. }) = machine {
            section.inside(key(axis), (axis, place[axis]), (*low, *high), "the travel");
        }
    }
}

pub(super) fn limits(section: &Section<'_>) -> Limits {
    let usual = Limits::default();
    let read = |key, range, unit, usual| section.between(key, range, unit).unwrap_or(usual);
    let bump = LEAST_BUMP_UM..=LARGEST_BUMP_UM;
    Limits {
        max_correction_um: read("max_correction_um", LIMITS, "µm", usual.max_correction_um),
        max_slope_um_per_mm: read(
            "max_slope_um_per_mm",
            LIMITS,
            "µm/mm",
            usual.max_slope_um_per_mm,
        ),
        max_bump_um: read("max_bump_um", bump, "µm", usual.max_bump_um),
    }
}

pub(super) fn acceptance(section: &Section<'_>, axes: &Axes) -> Acceptance {
    let range = |s: &Section<'_>, axis: Axis| {
        let range = s.pair_of_millimetres(axis.key())?;
        let (from, to) = s.ascending(axis.key(), range)?;
        if let Some(MachineAxis { low, high, .. }) = axes[axis] {
            s.inside(axis.key(), (axis, from), (low, high), "the travel");
            s.inside(axis.key(), (axis, to), (low, high), "the travel");
        }
        Some((from, to))
    };
    let ranges = |s: &Section<'_>| PerAxis::from_fn(|axis| range(s, axis));
    Acceptance {
        max_deviation_um: section.between("max_deviation_um", LIMITS, "µm"),
        max_diagonal_um: section.between("max_diagonal_um", LIMITS, "µm"),
        range: section.sub("range_mm", ranges).unwrap_or_default(),
    }
}
