//! What is written, and the curve that it follows.

use crate::control::controller::FanucFacts;
use crate::control::table::fanuc::FanucMemory;
use crate::text::problem::Problem;
use crate::write::compensation::Placement;
use crate::write::grid::Grid;
use crate::write::plan::{PlannedTable, Task};

/// What is written so far.
#[derive(Default)]
pub(super) struct Output {
    pub(super) memory: FanucMemory,
    pub(super) placements: Vec<Placement>,
    pub(super) notes: Vec<String>,
}

/// One curve to be put into increments.
pub(super) struct Curve {
    pub(super) wanted_um: Vec<f64>,
    /// Whether its value at the reference goes to parameter 3627.
    pub(super) carries_reversal: bool,
}

/// The smallest magnification with which every increment is legal, and the totals with it.
///
/// Returns the detection units of 3627 as well (0 if no curve carries the reversal).
pub(super) fn magnify(
    facts: &FanucFacts,
    grid: Grid,
    curves: &[Curve],
    unit_um: f64,
) -> Option<(u32, i64, Vec<Totals>)> {
    let steepest = curves
        .iter()
        .flat_map(|curve| {
            curve
                .wanted_um
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs())
        })
        .fold(0.0, f64::max);
    let legal = f64::from(facts.increment_max.value);
    // Rounding of two totals can add or save one count, so the search begins a little below.
    let least = whole((steepest / (unit_um * (legal + 1.0))).floor()).max(1);
    let least = u32::try_from(least).unwrap_or(u32::MAX);
    (least..=facts.magnification_max.value).find_map(|magnification| {
        let count_um = unit_um * f64::from(magnification);
        let step_um = if facts.reversal_magnified.value {
            count_um
        } else {
            unit_um
        };
        let mut reversal = 0;
        let totals: Vec<Totals> = curves
            .iter()
            .map(|curve| {
                let at_reference = curve.wanted_um[usize::try_from(-grid.first).unwrap_or(0)];
                let units = if curve.carries_reversal {
                    (at_reference / step_um).round()
                } else {
                    0.0
                };
                if curve.carries_reversal {
                    reversal = whole(units);
                }
                Totals::round(grid, &curve.wanted_um, units * step_um, count_um)
            })
            .collect();
        let fits = totals
            .iter()
            .all(|t| t.largest_increment() <= i64::from(facts.increment_max.value));
        fits.then_some((magnification, reversal, totals))
    })
}

pub(super) fn too_steep(
    task: Task<'_>,
    facts: &FanucFacts,
    planned: &PlannedTable,
    unit_um: f64,
) -> Problem {
    let most =
        f64::from(facts.increment_max.value) * f64::from(facts.magnification_max.value) * unit_um;
    let steepest = steepest_um(planned);
    task.job
        .problem_at(
            &format!("compensation.axes.{}", planned.term.along.key()),
            format!(
                "{} changes by {steepest:.1} µm between two points, more than {} × {} × {unit_um} µm = {most:.3} µm that the control can add",
                planned.term, facts.increment_max.value, facts.magnification_max.value
            ),
        )
        .help("use a smaller spacing, or check the measurement and `detection_unit_um`")
}

pub(super) fn wanted(
    planned: &PlannedTable,
    sign: crate::control::controller::TableSign,
) -> Vec<f64> {
    planned
        .values
        .iter()
        .map(|value| sign.table_um(*value))
        .collect()
}

/// Totals at the nodes of a grid in counts, and the count they are in.
pub(super) struct Totals {
    pub(super) grid: Grid,
    pub(super) counts: Vec<i64>,
}

impl Totals {
    /// `wanted_um`: what the table is to stand for at each node, in the sense of the table;
    /// `zero_um`: what is already there at the reference (parameter 3627).
    pub(super) fn round(grid: Grid, wanted_um: &[f64], zero_um: f64, count_um: f64) -> Totals {
        let reference = usize::try_from(-grid.first).unwrap_or(0);
        let counts = wanted_um
            .iter()
            .enumerate()
            .map(|(node, um)| {
                if node == reference {
                    0
                } else {
                    whole(((um - zero_um) / count_um).round())
                }
            })
            .collect();
        Totals { grid, counts }
    }

    /// The increment of the section that ends at a node; zero outside the grid.
    pub(super) fn increment(&self, node: i64) -> i64 {
        if node <= self.grid.first || node > self.grid.last {
            return 0;
        }
        let at = |node: i64| self.counts[usize::try_from(node - self.grid.first).unwrap_or(0)];
        at(node) - at(node - 1)
    }

    fn largest_increment(&self) -> i64 {
        self.counts
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .max()
            .unwrap_or(0)
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "counts of a checked correction, far below 2^52"
)]
fn whole(rounded: f64) -> i64 {
    rounded as i64
}

/// Largest change between two points, µm.
pub(super) fn steepest_um(planned: &PlannedTable) -> f64 {
    let changes = planned.values.windows(2).map(|p| (p[1] - p[0]).um().abs());
    changes.fold(0.0, f64::max)
}
