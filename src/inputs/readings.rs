//! Readings of the four body diagonals: the file of contract §2.2, checked against its job.
//!
//! ```text
//!  readings.csv ─→ rows ─→ walks: every node of every run once ─→ moves: the axes in the
//!                          job's order ─→ values: measured − nominal, along the forward path
//! ```
//! Readings that exist are complete: all four diagonals, every node of every run. A reading that
//! is missing is never filled in.

mod columns;
mod moves;
mod rows;
mod values;
mod walks;

use self::columns::Columns;
use crate::inputs::error_table::Remarks;
use crate::inputs::job::DiagonalMeasurement;
use crate::quantity::diagonal::{Diagonal, Pass, Run};
use crate::text::delimited::header_and_rows;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};

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

    /// What the file says of itself in comments `# note: …`, one sentence each.
    pub fn notes(&self) -> Vec<String> {
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
    let Some((header, lines)) = header_and_rows(source) else {
        return Err(Problem::new(format!(
            "`{}` holds no readings, expected a header and a row for each node",
            source.name
        ))
        .help("first line: diagonal,run,direction,node,moved,deviation_um")
        .into());
    };
    let columns = Columns::read(header)?;
    let rows = rows::read(&columns, &lines)?;
    let walks = walks::of(&rows);
    let mut problems = Problems::none();
    walks::check_set(&walks, &columns, &mut problems);
    if walks::check_nodes(&walks, measurement, &mut problems) {
        moves::check(&walks, &columns, measurement, &mut problems);
        values::check(&walks, &columns, measurement, &mut problems);
    }
    values::check_temperatures(&walks, &columns, measurement, &mut problems);
    problems.or_ok(())?;
    let mut runs: Vec<Run> = walks
        .iter()
        .map(|(walk, rows)| values::run(*walk, rows, columns.quantity, measurement))
        .collect();
    runs.sort_by_key(|run| (run.diagonal, run.number, run.pass));
    let own = walks.keys().filter(|walk| walk.is_own());
    let own_zero = own.map(|walk| (walk.diagonal, walk.run)).collect();
    Ok((runs, own_zero))
}
