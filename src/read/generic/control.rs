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

use crate::control::control_state::ControlState;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres};
use crate::read::emulate::{Between, CannotEmulate, Emulated, NodeTable, Response};
use crate::read::pairs::{Pair, PairControl};

/// A control that holds this table, as its reader checked it.
///
/// **unit** `state.unit` has no say: the table is in mm and µm · **limits** fails if an axis
/// is not one of the control, and if a block for one direction acts in addition to one for both.
pub(super) fn control(table: &GenericTable, state: &ControlState) -> Emulated<PairControl> {
    let mut groups: Vec<Vec<&GenericRow>> = Vec::new();
    for row in &table.rows {
        match groups.iter_mut().find(|group| same_block(group[0], row)) {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups.sort_by_key(|group| (&group[0].base_axis, &group[0].output_axis));
    let mut pairs: Vec<Pair> = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        refuse_mixed(group[0], &groups[..index])?;
        let corrections = corrections(group)?;
        let pair = pair_of(group[0], &mut pairs);
        for (way, response) in Direction::BOTH.into_iter().zip(&mut pair.ways) {
            if group[0].direction.is_none_or(|own| own == way) {
                response.push(corrections.clone());
            }
        }
    }
    PairControl::new(pairs, false, state)
}

/// The pair of axes that a row is for.
fn pair_of<'a>(row: &GenericRow, pairs: &'a mut Vec<Pair>) -> &'a mut Pair {
    let (base, output) = (&row.base_axis, &row.output_axis);
    let known = pairs.iter().position(|pair| pair.is_for(base, output));
    let index = known.unwrap_or(pairs.len());
    if known.is_none() {
        pairs.push(Pair {
            base: base.clone(),
            output: output.clone(),
            ways: [Response::default(), Response::default()],
        });
    }
    &mut pairs[index]
}

fn same_block(a: &GenericRow, b: &GenericRow) -> bool {
    same_pair(a, b) && a.direction == b.direction
}

fn same_pair(a: &GenericRow, b: &GenericRow) -> bool {
    a.base_axis.eq_ignore_ascii_case(&b.base_axis)
        && a.output_axis.eq_ignore_ascii_case(&b.output_axis)
}

/// What the rows of a block add.
fn corrections(rows: &[&GenericRow]) -> Emulated<NodeTable> {
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let step = (last.position_mm - first.position_mm) / (rows.len().max(2) - 1) as f64;
    let value = |row: &&GenericRow| Correction::from_um(row.correction_um);
    let values: Vec<Correction> = rows.iter().map(value).collect();
    let [start, step] = [first.position_mm, step].map(Millimetres::new);
    NodeTable::new(start, step, &values, Between::Linear).ok_or_else(|| {
        let (term, base, output) = (first.term, &first.base_axis, &first.output_axis);
        CannotEmulate(format!("{term} from {base} to {output} has fewer than two points"))
    })
}

/// A block for one direction beside one for both: whether they add is not known.
fn refuse_mixed(block: &GenericRow, others: &[Vec<&GenericRow>]) -> Emulated<()> {
    let is_mixed = |other: &Vec<&GenericRow>| {
        same_pair(other[0], block) && other[0].direction.is_none() != block.direction.is_none()
    };
    if others.iter().any(is_mixed) {
        return Err(CannotEmulate(format!(
            "from {} to {} there are blocks with and without direction; which one acts is \
             not known",
            block.base_axis, block.output_axis
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
