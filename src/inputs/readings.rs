//! Readings of the four body diagonals: the file of contract §2.2, checked against its job.
//!
//! ```text
//!  readings.csv ─→ rows ─→ nodes: every node of every run once, the axes in the job's order
//!                                           ─→ values: measured − nominal, along the forward path
//! ```
//! Readings that exist are complete: all four diagonals, every node of every run. A reading that
//! is missing is never filled in.

mod nodes;
mod rows;
mod values;
mod without_job;

use crate::inputs::error_table::Remarks;
use crate::inputs::job::DiagonalMeasurement;
use crate::quantity::diagonal::{Diagonal, Pass, Run};
use crate::text::document::Source;
use crate::text::finding::Finding;
use crate::text::problem::Problems;

/// Checked readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The file.
    pub source: Source,
    /// Every run, by diagonal, number and pass.
    pub runs: Vec<Run>,
    /// Reverse runs that were zeroed at their own start.
    own_zero: Vec<(Diagonal, u32)>,
}

impl Readings {
    /// Reads a file and checks it against what the job says of the measurement; all problems of
    /// the file are given at once.
    pub fn read(source: Source, measurement: &DiagonalMeasurement) -> Result<Readings, Problems> {
        let (runs, own_zero) = runs_of(&source, measurement)?;
        Ok(Readings {
            source,
            runs,
            own_zero,
        })
    }

    /// Reads a file by itself, in a box of unit cells.
    pub(crate) fn without_job(source: Source) -> Result<(Readings, DiagonalMeasurement), Problems> {
        let measurement = without_job::measurement(&source)?;
        Ok((Readings::read(source, &measurement)?, measurement))
    }

    /// What the file says of itself in comments `# note: …`, one sentence each.
    pub fn notes(&self) -> Vec<Finding> {
        Remarks::read(&self.source.text).notes
    }

    /// Whether the values of a run count from the start of the forward run.
    ///
    /// A run under the name of a reverse run (`NNN` …) is zero at its own start, the far corner.
    /// What the machine reads there on the way out belongs to another run, so the offset between
    /// the two ways is not known: its increments are what was measured, a reversal is not.
    pub fn offset_known(&self, run: &Run) -> bool {
        run.pass == Pass::Forward || !self.own_zero.contains(&(run.diagonal, run.number))
    }

    /// Gives the runs of two diagonals each other's name, both passes.
    pub fn exchange(&mut self, one: Diagonal, other: Diagonal) {
        let named = |diagonal: Diagonal| match diagonal {
            own if own == one => other,
            own if own == other => one,
            own => own,
        };
        for run in &mut self.runs {
            run.diagonal = named(run.diagonal);
        }
        for (diagonal, _) in &mut self.own_zero {
            *diagonal = named(*diagonal);
        }
    }
}

type Found = (Vec<Run>, Vec<(Diagonal, u32)>);

fn runs_of(source: &Source, measurement: &DiagonalMeasurement) -> Result<Found, Problems> {
    let (table, quantity) = rows::columns(source)?;
    let rows = rows::rows(&table)?;
    let walks = nodes::walks(&rows);
    let mut problems = Problems::none();
    nodes::check_set(&walks, &table, &mut problems);
    if nodes::check_nodes(&walks, measurement, &mut problems) {
        nodes::check_moves(&walks, &table, measurement, &mut problems);
        values::check(&walks, quantity, measurement, &mut problems);
    }
    values::check_temperatures(&walks, &table, measurement, &mut problems);
    problems.or_ok(())?;
    let mut runs: Vec<Run> = walks
        .iter()
        .map(|(walk, rows)| values::run(*walk, rows, quantity, measurement))
        .collect();
    runs.sort_by_key(|run| (run.diagonal, run.number, run.pass));
    let own = walks.keys().filter(|walk| walk.is_own());
    let own_zero = own.map(|walk| (walk.diagonal, walk.run)).collect();
    Ok((runs, own_zero))
}
