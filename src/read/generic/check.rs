//! What the rows of a generic table must be to each other.
//!
//! Rows are gathered into blocks while they are read; [`Reading::finish`] walks each block once.
//! A block that lost a row to a flaw is not walked: its gaps would only repeat the flaw.

use crate::read::lexer::Complaint;
use crate::text::document::MOST_ROWS;

use super::row::{BlockKey, Column, RawRow, RowFlaw, Unusable, read_row};
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Axis;
use std::collections::BTreeMap;

/// Two increments closer than this are the same, µm: the rounding of a difference of two
/// corrections, far below any count of a control.
const SAME_INCREMENT_UM: f64 = 1e-9;
/// How far a position may be from its equally spaced place: this many mm …
const OFF_GRID_MM: f64 = 1e-6;
/// … and this part of the position, for its rounding.
const OFF_GRID_RELATIVE: f64 = 1e-9;

/// Names of axes in one file; pairs of them are compared one by one. No control has more than 32.
const MOST_AXES: usize = 32;

/// The rows of a file while they are being read.
#[derive(Default)]
pub(super) struct Reading<'a> {
    flaws: Vec<RowFlaw>,
    rows: Vec<GenericRow>,
    /// The number of each of them in the file.
    numbers: Vec<usize>,
    blocks: BTreeMap<BlockKey<'a>, Block>,
    /// A row was lost, and nobody knows from which block.
    lost: bool,
    /// What each name of an axis stands for, in the order in which they were met.
    axes: Vec<(String, Axis)>,
}

/// Indices into the rows that were read, in file order.
#[derive(Default)]
struct Block {
    rows: Vec<usize>,
    broken: bool,
}

impl<'a> Reading<'a> {
    /// Whether there is enough to complain about.
    pub(super) fn is_full(&self) -> bool {
        self.flaws.len() >= MOST_COMPLAINTS
    }

    /// Notes a row that could not be taken apart.
    pub(super) fn lose_row(&mut self, flaws: impl IntoIterator<Item = RowFlaw>) {
        self.lost = true;
        self.flaws.extend(flaws);
    }

    /// Takes the next row of the file.
    pub(super) fn take(&mut self, raw: &RawRow<'a>) {
        match read_row(raw, &mut self.flaws) {
            Ok((key, row)) => {
                self.check_axis(raw.number, Column::BaseAxis, &row);
                self.check_axis(raw.number, Column::OutputAxis, &row);
                let block = self.blocks.entry(key).or_default();
                block.rows.push(self.rows.len());
                self.rows.push(row);
                self.numbers.push(raw.number);
            }
            Err(Unusable(Some(key))) => self.blocks.entry(key).or_default().broken = true,
            Err(Unusable(None)) => self.lost = true,
        }
    }

    /// The name of an axis stands for one axis of the machine; so a pair of axes has one term,
    /// and a straightness cannot act on its own moving axis.
    fn check_axis(&mut self, number: usize, column: Column, row: &GenericRow) {
        let (name, axis) = match column {
            Column::BaseAxis => (&row.base_axis, row.term.along),
            _ => (&row.output_axis, row.term.of),
        };
        let met = self
            .axes
            .iter()
            .find(|(met, _)| met.eq_ignore_ascii_case(name));
        let Some((_, known)) = met else {
            return self.meet_axis(number, column, name.clone(), axis);
        };
        if *known == axis {
            return;
        }
        let message = format!(
            "`{name}` stands for the {axis} axis in {}, but for the {known} axis before",
            row.term
        );
        let help = "EYX is Y while X moves: `base_axis` X, `output_axis` Y";
        self.flaws
            .push(RowFlaw::of_cell(number, column.name(), message, help));
    }

    /// Notes the name of an axis; that there are too many is told once.
    fn meet_axis(&mut self, number: usize, column: Column, name: String, axis: Axis) {
        if self.axes.len() > MOST_AXES {
            return;
        }
        if self.axes.len() == MOST_AXES {
            let message = format!("`{name}` is another axis, expected at most {MOST_AXES}");
            let help = "no control has so many: check that this is a table of corrections";
            let flaw = RowFlaw::of_cell(number, column.name(), message, help);
            self.flaws.push(flaw);
        }
        self.axes.push((name, axis));
    }

    /// The table, if nothing is wrong with it.
    pub(super) fn finish(mut self) -> Result<GenericTable, Vec<RowFlaw>> {
        let mut flaws = std::mem::take(&mut self.flaws);
        let whole = self.blocks.values().filter(|block| !block.broken);
        for block in whole.filter(|_| !self.lost) {
            self.walk(block, &mut flaws);
            if flaws.len() >= MOST_COMPLAINTS {
                break;
            }
        }
        if flaws.is_empty() {
            Ok(GenericTable { rows: self.rows })
        } else {
            Err(flaws)
        }
    }

    fn walk(&self, block: &Block, flaws: &mut Vec<RowFlaw>) {
        let before = flaws.len();
        self.walk_indices(block, flaws);
        if flaws.len() > before {
            return; // positions and increments of a jumbled block say nothing new
        }
        if let [only] = block.rows[..] {
            let message = "a block of one point, expected two or more";
            let help = "a line needs two points; the rows after this one may have been lost";
            flaws.push(RowFlaw::of_row(self.numbers[only], message, help));
        }
        for pair in block.rows.windows(2) {
            flaws.extend(self.position_flaw(pair[0], pair[1]));
            flaws.extend(self.increment_flaw(pair[0], pair[1]));
        }
        if flaws.len() == before {
            flaws.extend(self.spacing_flaw(block));
        }
    }

    /// Complains about the first row that is not the next one.
    fn walk_indices(&self, block: &Block, flaws: &mut Vec<RowFlaw>) {
        let mut counted = block.rows.iter().zip(0_u32..);
        let jump = counted.find(|(row, expected)| self.rows[**row].index != *expected);
        if let Some((row, expected)) = jump {
            let message = format!(
                "`index` is {}, expected {expected} as the next of its block",
                self.rows[*row].index
            );
            let help = "each term, pair of axes and direction is one block, counted from 0 \
                        without gaps and written once";
            flaws.push(self.flaw(*row, Column::Index, message, help));
        }
    }

    fn flaw(&self, row: usize, column: Column, message: String, help: &str) -> RowFlaw {
        RowFlaw::of_cell(self.numbers[row], column.name(), message, help)
    }

    fn position_flaw(&self, before: usize, row: usize) -> Option<RowFlaw> {
        let (from, to) = (self.rows[before].position_mm, self.rows[row].position_mm);
        if to > from {
            return None;
        }
        let message = format!("`position_mm` is {to}, expected more than {from} of the row before");
        let help = "the positions of a block ascend";
        Some(self.flaw(row, Column::Position, message, help))
    }

    fn increment_flaw(&self, before: usize, row: usize) -> Option<RowFlaw> {
        let change = self.rows[row].correction_um - self.rows[before].correction_um;
        let increment = self.rows[row].increment_um?;
        if (increment - change).abs() <= SAME_INCREMENT_UM {
            return None;
        }
        let message = format!(
            "`increment_um` is {increment}, expected {change}, the change of the correction"
        );
        let help = "an increment is the correction minus the correction of the row before";
        Some(self.flaw(row, Column::Increment, message, help))
    }

    /// The row with the most unusual step, if the positions are not equally spaced.
    fn spacing_flaw(&self, block: &Block) -> Option<RowFlaw> {
        let at: Vec<f64> = block
            .rows
            .iter()
            .map(|row| self.rows[*row].position_mm)
            .collect();
        if is_equally_spaced(&at) {
            return None;
        }
        let steps: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = median(&steps)?;
        let mut worst = 0;
        for (step, length) in steps.iter().enumerate() {
            if (length - usual).abs() > (steps[worst] - usual).abs() {
                worst = step;
            }
        }
        let message = format!(
            "`position_mm` is {} mm after the row before, expected {usual} mm",
            steps[worst]
        );
        let help = "the positions of a block are equally spaced; a row may be missing";
        Some(self.flaw(block.rows[worst + 1], Column::Position, message, help))
    }
}

#[allow(
    clippy::cast_precision_loss,
    reason = "a table has far fewer than 2^52 rows"
)]
fn is_equally_spaced(at: &[f64]) -> bool {
    let (Some(first), Some(last)) = (at.first(), at.last()) else {
        return true;
    };
    let step = (last - first) / (at.len().max(2) - 1) as f64;
    at.iter().enumerate().all(|(index, position)| {
        let expected = first + step * index as f64;
        (position - expected).abs() <= OFF_GRID_MM + OFF_GRID_RELATIVE * position.abs()
    })
}

/// Of two middle ones the smaller, as a missing row makes a step longer.
fn median(steps: &[f64]) -> Option<f64> {
    let mut sorted = steps.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

/// Nobody reads further, and a binary file has millions.
pub(super) const MOST_COMPLAINTS: usize = 200;

pub(super) fn too_many_rows(place: std::ops::Range<usize>) -> Complaint {
    Complaint::new(
        place,
        format!("the table has more than {MOST_ROWS} rows, too many for any control"),
        "check that this is a table of corrections",
    )
}
