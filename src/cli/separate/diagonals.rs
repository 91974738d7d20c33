//! Figures of the body diagonals, for people and for documents.

use super::words::{shown, three};
use crate::cli::standards::diagonals::{diagonal_json, figures_table};
use crate::inputs::target_runs::Runs;
use crate::machine::separation::diagonal_runs::diagonal_runs;
use crate::machine::separation::noise::CorrectedRun;
use crate::machine::standards::{self, DiagonalMotion, Diagonals};
use crate::quantity::diagonal::{Diagonal, PathKind, Volume};
use crate::text::problem::Problems;
use serde_json::Value;

/// Figures by standard, with the runs that they are made of.
pub(super) struct StandardFigures {
    runs: Vec<(&'static str, Runs)>,
    /// Figures of every diagonal and of all four, with the label of the motion.
    pub(super) all: Diagonals,
}

impl StandardFigures {
    /// `runs`: only those that count from the start of the forward run, or the two directions
    /// cannot be compared.
    pub(super) fn of(
        volume: &Volume,
        kind: PathKind,
        runs: &[CorrectedRun],
    ) -> Result<StandardFigures, Problems> {
        let motion = match kind {
            PathKind::Step => DiagonalMotion::StepDiagonalCellEnds,
            PathKind::Straight => DiagonalMotion::StraightRuns,
        };
        let mut each: Vec<(&'static str, Runs)> = Vec::new();
        for diagonal in Diagonal::ALL {
            each.push((
                diagonal.name(),
                diagonal_runs(volume, kind, diagonal, runs)?,
            ));
        }
        let named: Vec<(&str, &Runs)> = each.iter().map(|(name, runs)| (*name, runs)).collect();
        let all = standards::diagonal(&named, motion);
        Ok(StandardFigures { runs: each, all })
    }

    /// Every figure of a diagonal by its name in the standards.
    pub(super) fn document(&self, diagonal: Diagonal) -> Value {
        let mut each = self.runs.iter().zip(&self.all.diagonals);
        let found = each.find(|((name, _), _)| *name == diagonal.name());
        found.map_or(Value::Null, |((_, runs), of)| diagonal_json(runs, of))
    }
}

/// The table of the diagonals: far ends, and every figure of the standards.
pub(super) fn diagonal_table(
    figures: &StandardFigures,
    end_um: impl Fn(Diagonal) -> f64,
) -> String {
    let figures = &figures.all;
    let ends = Diagonal::ALL.map(|d| format!("{d} {}", three(end_um(d))));
    let machine = match (figures.e_d_um, figures.b_d_um) {
        (Some(e_d), Some(b_d)) => format!(
            "machine: E_d {} µm, B_d {} µm (largest of the four)",
            three(e_d),
            three(b_d)
        ),
        _ => "no E and B: they need runs in both directions that count from one zero".to_string(),
    };
    format!(
        "Body diagonals as read (corrected readings, no compensation forecast), {}\n{}\nfar end less start, mean of all runs (µm): {}\nlargest range {} µm; over all four {} µm\n{machine}",
        figures.label,
        figures_table(figures),
        ends.join(", "),
        shown(figures.largest_range_um),
        shown(figures.range_over_all_um),
    )
}
