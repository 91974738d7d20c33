//! Generic tables that were read out.

use super::reading::{Found, Held, Reading};
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::judge::findings::InControl;
use crate::quantity::axis::PerAxis;
use crate::read::Text;
use crate::read::generic;
use crate::text::problem::Problems;

pub(super) fn read(reading: &mut Reading<'_>, texts: &[Text<'_>]) -> Result<Found, Problems> {
    let mut problems = Problems::none();
    let mut tables = Vec::new();
    for (name, text) in texts {
        tables.extend(problems.take(generic::read(name, text)));
    }
    let mut table = generic::merge(problems.or_ok(tables)?)?;
    let held = Held::plain(Tables::Generic(table.clone()));
    if reading.judges() {
        take_others(reading, &mut table);
    }
    Ok(Found {
        held,
        tables: Tables::Generic(table),
        backlash: PerAxis::default(),
        unit: None,
    })
}

/// Old tables of other axes are refused: the new file would take their place.
fn take_others(reading: &mut Reading<'_>, table: &mut GenericTable) {
    let is_other =
        |row: &GenericRow| !reading.has(&row.base_axis) || !reading.has(&row.output_axis);
    let others: Vec<GenericRow> = table.rows.extract_if(.., |row| is_other(row)).collect();
    for row in others.iter().filter(|row| row.index == 0) {
        let (moving, output, term) = (row.base_axis.clone(), &row.output_axis, row.term);
        reading.tell(match reading.has(output) {
            true => InControl::Follows {
                what: format!("{term} of `{output}`"),
                moving,
            },
            false => InControl::OfOthers {
                what: format!("{term} ({output} while {moving} moves)"),
                axes: "axes",
            },
        });
    }
}

/// Old tables that the new file does not hold.
pub(super) fn left_over(old: &GenericTable, new: &GenericTable) -> Vec<String> {
    let same = |a: &GenericRow, b: &GenericRow| {
        a.term == b.term && a.output_axis == b.output_axis && a.direction == b.direction
    };
    let gone = |row: &&GenericRow| row.index == 0 && !new.rows.iter().any(|n| same(row, n));
    let gone = old.rows.iter().filter(gone);
    gone.map(|row| format!("the old table {} of {}", row.term, row.output_axis))
        .collect()
}
