//! The runs of one axis to its targets, as a positioning test measures them: every target several
//! times from either side (ISO 230-2).
//!
//! ```text
//!            P1        P2        P3        P4
//!  run 1 ↑ ──●─────────●─────────●─────────●──┐    moving up: approached in the + direction
//!  run 1 ↓ ──●─────────●─────────●─────────●──┘    moving down: approached in the - direction
//! ```
//!
//! A file of runs becomes [`Runs`]; [`crate::machine::standards`] turns them into figures.

mod read;

use crate::inputs::refusals;
use crate::quantity::{Direction, UM_PER_MM};
use crate::text::{LengthUnit, Problem, words};

words! {
    /// What the values of the runs are.
    #[derive(clap::ValueEnum)]
    pub enum Values {
        /// Where the axis stood, P_ij.
        Positions = "positions",
        /// How far from the target it stood, x_ij = P_ij − P_i.
        Deviations = "deviations",
    }
}

/// The direction of approach of a word: `+` or `up`, `-`, `dn` or `down`.
pub(crate) fn approach(word: &str) -> Option<Direction> {
    match word {
        "up" => Some(Direction::Plus),
        "dn" | "down" => Some(Direction::Minus),
        symbol => Direction::from_symbol(symbol),
    }
}

/// Deviations are small beside the distance of the targets: at most this part of it.
const SMALL: f64 = 0.1;

/// Up to which distance from its target, µm, a value is certainly a position: a tenth of the smallest distance
/// of two targets.
pub(crate) fn small_um(targets_mm: impl IntoIterator<Item = f64>) -> f64 {
    let mut targets: Vec<f64> = targets_mm.into_iter().collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup();
    let distances = targets.windows(2).map(|pair| pair[1] - pair[0]);
    SMALL * distances.fold(f64::INFINITY, f64::min) * UM_PER_MM
}

/// What a person says about a file beside its header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunFacts {
    /// Unit of the columns whose names have none.
    pub unit: Option<LengthUnit>,
    /// What the run columns hold, where their names do not say it.
    pub values: Option<Values>,
}

/// The runs of one axis: for every target the deviations of all runs, complete.
///
/// shape  targets ascend strictly, two or more; of a direction every target has the same number of
///        runs, one or more; one direction may be missing as a whole
/// unit   targets in mm, deviations in µm
/// sign   deviation x_ij = P_ij − P_i, actual − commanded
/// source ISO 230-2, target positions P_i and actual positions P_ij
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    targets_mm: Vec<f64>,
    /// Up and down.
    um: [Option<Vec<Vec<f64>>>; 2],
}

impl Runs {
    /// Checked runs. `up_um[i][j]` is the deviation of run j at target i, approached in the +
    /// direction; `down_um` likewise in the - direction; `None` = not measured.
    ///
    /// ```
    /// use nonius::inputs::target_runs::Runs;
    /// let up = vec![vec![0.0, 0.2], vec![1.0, 1.2]];
    /// let runs = Runs::new(vec![0.0, 100.0], Some(up), None)?;
    /// assert_eq!(runs.length_mm(), 100.0);
    /// # Ok::<(), nonius::text::Problem>(())
    /// ```
    pub fn new(
        targets_mm: Vec<f64>,
        up_um: Option<Vec<Vec<f64>>>,
        down_um: Option<Vec<Vec<f64>>>,
    ) -> Result<Runs, Problem> {
        let ascending = targets_mm.is_sorted_by(|a, b| a < b);
        if targets_mm.len() < 2 || !ascending || !targets_mm.iter().all(|mm| mm.is_finite()) {
            return Err(refusals::few_targets());
        }
        let um = [up_um, down_um];
        let is_complete = |um: &Vec<Vec<f64>>| {
            let runs = um.first().map_or(0, Vec::len);
            let is_full = |of: &Vec<f64>| of.len() == runs && of.iter().all(|um| um.is_finite());
            runs > 0 && um.len() == targets_mm.len() && um.iter().all(is_full)
        };
        if !um.iter().any(Option::is_some) || !um.iter().flatten().all(is_complete) {
            return Err(refusals::incomplete_runs(targets_mm.len()));
        }
        Ok(Runs { targets_mm, um })
    }

    /// The targets, ascending, mm.
    pub fn targets_mm(&self) -> &[f64] {
        &self.targets_mm
    }

    /// Deviations of a direction of approach in µm: for every target those of all runs.
    pub fn deviations_um(&self, direction: Direction) -> Option<&[Vec<f64>]> {
        self.um[direction as usize].as_deref()
    }

    /// Number of runs in a direction; 0 = not measured.
    pub fn count(&self, direction: Direction) -> usize {
        self.deviations_um(direction).and_then(<[Vec<f64>]>::first).map_or(0, Vec::len)
    }

    /// From the first to the last target, mm.
    pub fn length_mm(&self) -> f64 {
        let ends = self.targets_mm.first().zip(self.targets_mm.last());
        ends.map_or(0.0, |(first, last)| last - first)
    }
}
