//! Rows of the generic table, block by block.

use crate::control::table::generic::{GenericRow, GenericTable};
use crate::judge::disagreement::Diagnosis;
use crate::judge::disagreement::contents::words::{it, runs, same};

/// Surplus, missing and other rows.
pub(super) fn rows(
    wanted: &GenericTable,
    found: &GenericTable,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    if wanted == found {
        return Vec::new();
    }
    let open =
        |row: &GenericRow| !diagnosis.is_some_and(|d| d.explains(&row.base_axis, &row.output_axis));
    let without = |rows: &GenericTable, others: &GenericTable| -> Vec<GenericRow> {
        let alone = |row: &&GenericRow| open(row) && twin(row, others).is_none();
        rows.rows.iter().filter(alone).cloned().collect()
    };
    let mut words = by_block(&without(found, wanted), |count| {
        format!("the job does not write {}", it(count))
    });
    if diagnosis.is_none() {
        return words;
    }
    words.extend(by_block(&without(wanted, found), |count| {
        format!("missing, the job writes {}", it(count))
    }));
    let differs =
        |row: &&GenericRow| open(row) && twin(row, found).is_some_and(|got| !equal(row, got));
    let other: Vec<GenericRow> = wanted.rows.iter().filter(differs).cloned().collect();
    words.extend(by_block(&other, |_| {
        "other numbers than the job writes".to_string()
    }));
    words
}

fn same_block(a: &GenericRow, b: &GenericRow) -> bool {
    a.term == b.term
        && a.direction == b.direction
        && a.base_axis.eq_ignore_ascii_case(&b.base_axis)
        && a.output_axis.eq_ignore_ascii_case(&b.output_axis)
}

fn twin<'a>(row: &GenericRow, table: &'a GenericTable) -> Option<&'a GenericRow> {
    let is_twin = |other: &&GenericRow| same_block(row, other) && row.index == other.index;
    table.rows.iter().find(is_twin)
}

fn equal(a: &GenericRow, b: &GenericRow) -> bool {
    let increments = match (a.increment_um, b.increment_um) {
        (Some(a), Some(b)) => same(a, b),
        (a, b) => a.is_none() == b.is_none(),
    };
    increments
        && same(a.position_mm, b.position_mm)
        && same(a.deviation_um, b.deviation_um)
        && same(a.correction_um, b.correction_um)
}

/// One sentence for all rows of a block.
fn by_block(rows: &[GenericRow], words: impl Fn(usize) -> String) -> Vec<String> {
    let mut blocks: Vec<(&GenericRow, Vec<u32>)> = Vec::new();
    for row in rows {
        match blocks.iter_mut().find(|(first, _)| same_block(first, row)) {
            Some((_, indices)) => indices.push(row.index),
            None => blocks.push((row, vec![row.index])),
        }
    }
    let sentence = |(row, indices): &(&GenericRow, Vec<u32>)| {
        format!(
            "{} ({} while {} moves), {}: {}",
            row.term,
            row.output_axis,
            row.base_axis,
            runs(indices),
            words(indices.len())
        )
    };
    blocks.iter().map(sentence).collect()
}
