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
    /// A control that holds this table.
    ///
    /// **unit** `state.unit` has no say: the table is in mm and µm · **limits** fails if an axis
    /// is not one of the control, if the points of a block are not counted 0, 1, 2, … at equally
    /// spaced positions, and if two blocks act on the same pair of axes in the same direction.
    pub fn new(
        table: &GenericTable,
        state: &ControlState,
    ) -> Result<GenericControl, CannotEmulate> {
        let groups = groups(&table.rows)?;
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

fn name_of(row: &GenericRow) -> String {
    let direction = row.direction.map_or("", |direction| direction.symbol());
    format!(
        "{}{direction} from {} to {}",
        row.term, row.base_axis, row.output_axis
    )
}

/// The rows of each pair of axes and direction; each must be one block of one term.
fn groups(rows: &[GenericRow]) -> Result<Vec<Vec<&GenericRow>>, CannotEmulate> {
    let mut groups: Vec<Vec<&GenericRow>> = Vec::new();
    for row in rows {
        let Some(group) = groups.iter_mut().find(|group| same_block(group[0], row)) else {
            groups.push(vec![row]);
            continue;
        };
        if group[0].term != row.term || row.index == 0 {
            let names = format!("{} and {}", name_of(group[0]), name_of(row));
            return Err(CannotEmulate(format!(
                "two blocks act on the same pair of axes in the same direction: {names}"
            )));
        }
        group.push(row);
    }
    Ok(groups)
}

fn load(rows: &[&GenericRow], state: &ControlState) -> Result<LoadedBlock, CannotEmulate> {
    let first = rows[0];
    known_axis(state, &first.base_axis)?;
    known_axis(state, &first.output_axis)?;
    let corrections = corrections(rows)
        .filter(|table| is_faithful(table, rows))
        .ok_or_else(|| {
            CannotEmulate(format!(
                "{}: the points are not two or more finite values, counted from 0, at equally \
                 spaced ascending positions",
                name_of(first)
            ))
        })?;
    Ok(LoadedBlock {
        base: first.base_axis.to_string(),
        output: first.output_axis.to_string(),
        direction: first.direction,
        corrections,
    })
}

#[allow(
    clippy::cast_precision_loss,
    reason = "a table has far fewer than 2^52 rows"
)]
fn corrections(rows: &[&GenericRow]) -> Option<NodeTable> {
    let (first, last) = (rows.first()?.position_mm, rows.last()?.position_mm);
    let step = (last - first) / (rows.len().max(2) - 1) as f64;
    let values: Vec<Correction> = rows
        .iter()
        .map(|row| Correction::from_um(row.correction_um))
        .collect();
    let (start, step) = (Millimetres::new(first), Millimetres::new(step));
    NodeTable::new(start, step, &values, Between::Linear)
}

/// Whether the nodes stand where the rows say, in the order of their index.
fn is_faithful(table: &NodeTable, rows: &[&GenericRow]) -> bool {
    // Off its node by less, a point is displaced by no more than a linear encoder resolves.
    const SAME_PLACE_MM: f64 = 1e-6;
    const SAME_PLACE_RELATIVE: f64 = 1e-9; // rounding of the position itself
    let mut nodes = table.nodes().zip(rows).zip(0_u32..);
    nodes.all(|(((node, value), row), index)| {
        let off = (node.mm() - row.position_mm).abs();
        let allowed = SAME_PLACE_MM + SAME_PLACE_RELATIVE * row.position_mm.abs();
        row.index == index && value.um().is_finite() && off <= allowed
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
