//! What a control adds to an axis that interpolates a generic table (contract §4.1).
//!
//! ```text
//!   block (base, output, direction) → NodeTable: linear between points, ends held
//!   correction(A) = Σ blocks with output A − backlash of A, away from the reference direction
//! ```
//! The values are taken from `correction_um`, which is already what the control adds, so no sign
//! is assumed; positions are millimetres whatever the unit of the control. A block without
//! direction acts in both. What a control would do with two tables for the same travel is not
//! known, so such tables are refused.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres};
use crate::read::emulate::{Between, CannotEmulate, Emulator, NodeTable, Response};

/// A control that interpolates generic tables, with its tables in memory.
#[derive(Clone, Debug)]
pub struct GenericControl {
    blocks: Vec<LoadedBlock>,
    state: ControlState,
}

#[derive(Clone, Debug)]
struct LoadedBlock {
    base: String,
    output: String,
    direction: Option<Direction>,
    corrections: NodeTable,
}

impl LoadedBlock {
    fn connects(&self, base: &str, output: &str) -> bool {
        self.base.eq_ignore_ascii_case(base) && self.output.eq_ignore_ascii_case(output)
    }

    fn acts_in(&self, direction: Direction) -> bool {
        self.direction.is_none_or(|own| own == direction)
    }
}

impl GenericControl {
    /// A control that holds this table, as its reader checked it.
    ///
    /// **unit** `state.unit` has no say: the table is in mm and µm · **limits** fails if an axis
    /// is not one of the control, and if a block for one direction acts in addition to one for both.
    pub fn new(
        table: &GenericTable,
        state: &ControlState,
    ) -> Result<GenericControl, CannotEmulate> {
        let mut groups: Vec<Vec<&GenericRow>> = Vec::new();
        for row in &table.rows {
            match groups.iter_mut().find(|group| same_block(group[0], row)) {
                Some(group) => group.push(row),
                None => groups.push(vec![row]),
            }
        }
        let load = |rows: &Vec<&GenericRow>| load(rows, state);
        let blocks: Vec<LoadedBlock> = groups.iter().map(load).collect::<Result<_, _>>()?;
        refuse_mixed(&blocks)?;
        Ok(GenericControl {
            blocks,
            state: state.clone(),
        })
    }
}

impl Emulator for GenericControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let pair = |block: &LoadedBlock| (block.base.clone(), block.output.clone());
        let mut pairs: Vec<_> = self.blocks.iter().map(pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn response(
        &self,
        base: &str,
        output: &str,
        direction: Direction,
    ) -> Result<Response, CannotEmulate> {
        let acting = self
            .blocks
            .iter()
            .filter(|block| block.connects(base, output) && block.acts_in(direction));
        let tables = acting.map(|block| block.corrections.clone()).collect();
        let constant = if base.eq_ignore_ascii_case(output) {
            known_axis(&self.state, base)?.backlash(direction)
        } else {
            Correction::ZERO
        };
        Ok(Response::new(tables, constant))
    }
}

fn known_axis<'a>(state: &'a ControlState, name: &str) -> Result<&'a AxisState, CannotEmulate> {
    let axis = state.axis(name);
    axis.ok_or_else(|| CannotEmulate(format!("foreign axis: the control has no axis `{name}`")))
}

fn same_block(a: &GenericRow, b: &GenericRow) -> bool {
    a.base_axis.eq_ignore_ascii_case(&b.base_axis)
        && a.output_axis.eq_ignore_ascii_case(&b.output_axis)
        && a.direction == b.direction
}

fn load(rows: &[&GenericRow], state: &ControlState) -> Result<LoadedBlock, CannotEmulate> {
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    known_axis(state, &first.base_axis)?;
    known_axis(state, &first.output_axis)?;
    let step = (last.position_mm - first.position_mm) / (rows.len().max(2) - 1) as f64;
    let value = |row: &&GenericRow| Correction::from_um(row.correction_um);
    let values: Vec<Correction> = rows.iter().map(value).collect();
    let [start, step] = [first.position_mm, step].map(Millimetres::new);
    let corrections = NodeTable::new(start, step, &values, Between::Linear);
    Ok(LoadedBlock {
        base: first.base_axis.clone(),
        output: first.output_axis.clone(),
        direction: first.direction,
        corrections: corrections.ok_or_else(|| {
            let (term, base, output) = (first.term, &first.base_axis, &first.output_axis);
            CannotEmulate(format!(
                "{term} from {base} to {output} has fewer than two points"
            ))
        })?,
    })
}

/// A block for one direction beside one for both: whether they add is not known.
fn refuse_mixed(blocks: &[LoadedBlock]) -> Result<(), CannotEmulate> {
    for block in blocks.iter().filter(|block| block.direction.is_none()) {
        let pair = |other: &&LoadedBlock| other.connects(&block.base, &block.output);
        if blocks.iter().filter(pair).any(|b| b.direction.is_some()) {
            return Err(CannotEmulate(format!(
                "from {} to {} there are blocks with and without direction; which one acts is \
                 not known",
                block.base, block.output
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
