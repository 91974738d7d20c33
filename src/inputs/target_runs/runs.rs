//! Runs to targets, checked.

use crate::quantity::axis::Direction;
use crate::text::delimited::LengthUnit;
use crate::text::problem::Problem;

/// What the values of the runs are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Values {
    /// Where the axis stood, P_ij.
    Positions,
    /// How far from the target it stood, x_ij = P_ij − P_i.
    Deviations,
}

impl Values {
    /// Both.
    pub const ALL: [Values; 2] = [Values::Positions, Values::Deviations];

    /// `positions` or `deviations`.
    pub const fn word(self) -> &'static str {
        match self {
            Values::Positions => "positions",
            Values::Deviations => "deviations",
        }
    }
}

/// What a person says about a file beside its header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stated {
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
    pub(super) targets_mm: Vec<f64>,
    up_um: Option<Vec<Vec<f64>>>,
    down_um: Option<Vec<Vec<f64>>>,
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
    /// # Ok::<(), nonius::text::problem::Problem>(())
    /// ```
    pub fn new(
        targets_mm: Vec<f64>,
        up_um: Option<Vec<Vec<f64>>>,
        down_um: Option<Vec<Vec<f64>>>,
    ) -> Result<Runs, Problem> {
        if targets_mm.len() < 2 {
            return Err(Problem::new(format!(
                "{} target, expected at least two",
                targets_mm.len()
            )));
        }
        let ascending = targets_mm.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascending || !targets_mm.iter().all(|mm| mm.is_finite()) {
            return Err(Problem::new(
                "the targets do not ascend, expected each larger than the one before",
            ));
        }
        if up_um.is_none() && down_um.is_none() {
            return Err(Problem::new(
                "no direction was measured, expected one or both",
            ));
        }
        for (um, direction) in [(&up_um, Direction::Plus), (&down_um, Direction::Minus)] {
            if let Some(um) = um {
                refuse_incomplete(um, targets_mm.len(), direction)?;
            }
        }
        Ok(Runs {
            targets_mm,
            up_um,
            down_um,
        })
    }

    /// The targets, ascending, mm.
    pub fn targets_mm(&self) -> &[f64] {
        &self.targets_mm
    }

    /// Deviations of a direction of approach in µm: for every target those of all runs.
    pub fn deviations_um(&self, direction: Direction) -> Option<&[Vec<f64>]> {
        match direction {
            Direction::Plus => self.up_um.as_deref(),
            Direction::Minus => self.down_um.as_deref(),
        }
    }

    /// Number of runs in a direction; 0 = not measured.
    pub fn count(&self, direction: Direction) -> usize {
        self.deviations_um(direction)
            .and_then(<[Vec<f64>]>::first)
            .map_or(0, Vec::len)
    }

    /// From the first to the last target, mm.
    pub fn length_mm(&self) -> f64 {
        match (self.targets_mm.first(), self.targets_mm.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }
}

fn refuse_incomplete(um: &[Vec<f64>], targets: usize, direction: Direction) -> Result<(), Problem> {
    let runs = um.first().map_or(0, Vec::len);
    if um.len() != targets || runs == 0 || um.iter().any(|of| of.len() != runs) {
        return Err(Problem::new(format!(
            "the runs moving {direction} are not complete, expected as many at each of the \
             {targets} targets"
        )));
    }
    if um.iter().flatten().any(|um| !um.is_finite()) {
        return Err(Problem::new(format!(
            "a deviation moving {direction} is not a finite number"
        )));
    }
    Ok(())
}
