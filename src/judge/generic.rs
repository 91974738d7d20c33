//! The generic table that was read out, against a job and against a kit.

use crate::control::controller::GenericFacts;
use crate::control::table::Tables;
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::read::generic;
use crate::text::problem::Problems;

impl Family for GenericFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let mut problems = Problems::none();
        let mut tables = Vec::new();
        for (name, text) in reading.texts {
            tables.extend(problems.take(generic::read_out(name, text)));
        }
        let mut table = generic::merge(problems.or_ok(tables)?)?;
        let held = Tables::Generic(table.clone());
        if reading.judges() {
            tell_others(reading, &mut table);
        }
        Ok(Found { tables: Tables::Generic(table), ..Found::all(held) })
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
        let same = |a: &GenericRow, b: &GenericRow| {
            a.term == b.term && a.output_axis == b.output_axis && a.direction == b.direction
        };
        let gone = |row: &&GenericRow| row.index == 0 && !new.rows.iter().any(|n| same(row, n));
        let gone = old.rows.iter().filter(gone);
        gone.map(|row| format!("the old table {} of {}", row.term, row.output_axis)).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let own = own(side.tables);
        let entry = |row: &GenericRow| {
            let (base, output) = (&row.base_axis, &row.output_axis);
            let told = side.tells(base, output);
            let way = row.direction.map_or(String::new(), |way| format!(" in {way}"));
            let block = format!("{} ({output} while {base} moves{way})", row.term);
            let numbers = [row.position_mm, row.deviation_um, row.correction_um].map(Some);
            let value = Value::Numbers([&numbers[..], &[row.increment_um]].concat());
            ((block, Item::Point(row.index)), Entry::of(value, told, told))
        };
        own.rows.iter().map(entry).collect()
    }

    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["tables of this format".to_string()])
    }
}

/// The rows of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &GenericTable {
    const NONE: &GenericTable = &GenericTable { rows: Vec::new() };
    tables.own().unwrap_or(NONE)
}

/// Old tables of other axes are refused: the new file would take their place.
fn tell_others(reading: &mut ReadOutReader<'_>, table: &mut GenericTable) {
    let axes = |row: &GenericRow| [row.base_axis.clone(), row.output_axis.clone()];
    let others = reading.take_others(&mut table.rows, axes);
    for row in others.iter().filter(|row| row.index == 0) {
        let (moving, output, term) = (row.base_axis.clone(), &row.output_axis, row.term);
        reading.tell(match reading.has(output) {
            true => InControl::Follows { what: format!("{term} of `{output}`"), moving },
            false => InControl::OfOthers {
                what: format!("{term} ({output} while {moving} moves)"),
                axes: "axes",
            },
        });
    }
}
