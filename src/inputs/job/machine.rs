//! `[machine]`, `[limits]` and `[acceptance]`: the machine, what is refused, and what is judged by.

use crate::inputs::refusals;
use crate::quantity::{Axis, Chain, Direction, Millimetres, PerAxis};
use crate::text::{LIMITS, Places, Section, section};

section! {
    /// The machine.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Machine(section: &Section<'_>) {
        /// the machine, as files and reports shall name it
        pub name: String = plain_text(), or String::new(), must "the machine's name";
        /// its serial number; optional
        pub serial: Option<String> = plain_text();
        /// kinematic chain (section 1), e.g. `wXYZt`; optional, needed with angles
        pub chain: Option<Chain> = parsed(Chain::parse, CHAIN);
        /// likewise y, z: every axis that was measured or is corrected
        pub axes: Axes = axes(|s, axis| s.sub(axis.key(), MachineAxis::checked));
    }
}

const CHAIN: [&str; 2] = [
    "each of X, Y, Z once, `w` where the workpiece is and `t` at the end",
    "for instance `wXYZt`, `XwYZt` or `XYwZt`",
];

section! {
    /// One axis of the machine.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MachineAxis(section: &Section<'_>) {
        /// machine coordinates of both ends
        travel as travel_mm: (Millimetres, Millimetres) = ascending(),
            must "the ends of the travel, e.g. [0.0, 900.0]";
        /// Smallest machine coordinate.
        pub low: Millimetres => travel.map(|(low, _)| low), must;
        /// Largest machine coordinate.
        pub high: Millimetres => travel.map(|(_, high)| high), must;
        /// reference (home) point, machine coordinate: every table is zero here
        pub reference as reference_mm: Millimetres = coordinate(),
            must "the machine coordinate of the reference point";
        /// how far it may lie outside travel_mm; default 100
        reference_outside_mm: f64 = not_negative(), or REFERENCE_OUTSIDE_MM;
        /// direction of the reference return, "+" or "-"
        pub reference_direction: Option<Direction> = direction();
        /// largest feed; enables the check of the smallest Fanuc interval
        pub max_feed as max_feed_mm_per_min: Option<f64> = between(1e-3..=1e6, "mm/min");
    }
}

/// The axes of a machine.
pub(super) type Axes = PerAxis<Option<MachineAxis>>;

impl MachineAxis {
    /// The tables are zero at the reference point: far from the travel, they would be zero nowhere on it.
    fn checked(section: &Section<'_>) -> Option<MachineAxis> {
        let axis = MachineAxis::read(section)?;
        let [low, high, reference] = [axis.low, axis.high, axis.reference].map(Millimetres::mm);
        let (outside, most) = ((low - reference).max(reference - high), axis.reference_outside_mm);
        if outside > most {
            let (far, next) = (Millimetres::new(outside).shown(), outside.ceil());
            let problem = refusals::far_reference(reference, far, low, high, most, next);
            section.refuse("reference_mm", problem);
        }
        Some(axis)
    }

    /// One without feed and direction of its return.
    #[cfg(test)]
    pub(crate) fn of([low, high, reference]: [f64; 3]) -> MachineAxis {
        let [low, high, reference] = [low, high, reference].map(Millimetres::new);
        MachineAxis {
            travel: (low, high),
            low,
            high,
            reference,
            reference_outside_mm: REFERENCE_OUTSIDE_MM,
            reference_direction: None,
            max_feed: None,
        }
    }

    /// Where a reference point of it may lie.
    pub(super) fn range_of_references(&self) -> (Millimetres, Millimetres) {
        let outside = Millimetres::new(self.reference_outside_mm);
        (self.low - outside, self.high + outside)
    }

    /// The stated direction of the reference return, or +.
    pub(crate) fn homing(&self) -> Direction {
        self.reference_direction.unwrap_or(Direction::Plus)
    }
}

/// No sign proof moves an axis by more, µm.
pub const LARGEST_BUMP_UM: f64 = 20.0;

/// A smaller bump is not seen beyond doubt on a dial gauge of 1 µm, µm.
pub const LEAST_BUMP_UM: f64 = 5.0;

section! {
    /// `[limits]`: refuse rather than emit nonsense.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Limits(section: &Section<'_>) {
        /// largest correction; default 500 µm
        pub max_correction_um: f64 = between(LIMITS, "µm"), or 500.0;
        /// largest slope; default 1.0 µm/mm
        pub max_slope_um_per_mm: f64 = between(LIMITS, "µm/mm"), or 1.0;
        /// largest bump of the sign proofs, 5 … 20; default 20 µm
        pub max_bump_um: f64 = between(LEAST_BUMP_UM..=LARGEST_BUMP_UM, "µm"), or LARGEST_BUMP_UM;
    }
}

section! {
    /// `[acceptance]`.
    #[derive(Clone, Copy, Debug, PartialEq, Default)]
    pub struct Acceptance(section: &Section<'_>, axes: &Axes) {
        /// limit of the residual of each error, µm; remove the line where nothing is agreed
        pub max_deviation_um: Option<f64> = between(LIMITS, "µm");
        /// limit of max − min along every body diagonal, µm; optional
        pub max_diagonal_um: Option<f64> = between(LIMITS, "µm");
        /// the part of an axis that is judged, machine coordinates; likewise y, z; default: the travel
        pub range as range_mm: PerAxis<Option<(Millimetres, Millimetres)>> =
            axes(|s, axis| range(s, axis, axes));
    }
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

/// The part of an axis that is judged.
fn range(section: &Section<'_>, axis: Axis, axes: &Axes) -> Option<(Millimetres, Millimetres)> {
    let (from, to) = section.ascending(axis.key())?;
    if let Some(MachineAxis { low, high, .. }) = axes[axis] {
        section.inside(axis.key(), (axis, from), (low, high), "the travel");
        section.inside(axis.key(), (axis, to), (low, high), "the travel");
    }
    Some((from, to))
}
