//! Files that were read out of a declared control, against a job and against a kit.

use crate::control::controller::DeclaredFacts;
use crate::control::table::Tables;
use crate::control::table::declared::{DeclaredTable, DeclaredTables, Point};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::read::declared::read;
use crate::text::problem::Problems;

impl Family for DeclaredFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let mut found = read(reading.texts, self)?;
        let held = Tables::Declared(found.clone());
        tell_others(reading, &mut found);
        Ok(Found { tables: Tables::Declared(found), ..Found::all(held) })
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
        let stays = |table: &&DeclaredTable| {
            let mut new = new.iter();
            !new.any(|new| new.is_for(&table.base, &table.output))
        };
        old.iter().filter(stays).map(|table| format!("the old {}", table.name())).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let of_table = |table: &DeclaredTable| {
            let told = side.tells(&table.base, &table.output);
            let name = table.name();
            let entry = move |(index, point): (u32, &Point)| {
                let numbers = vec![Some(point.position), Some(point.forward), point.reverse];
                let key = (name.clone(), Item::Point(index));
                (key, Entry::of(Value::Numbers(numbers), told, told))
            };
            let points = (self.first_point.value..).zip(&table.points);
            points.map(entry).collect::<Vec<_>>()
        };
        own(side.tables).iter().flat_map(of_table).collect()
    }

    /// The files that were read out are the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["tables of this format".to_string()])
    }
}

/// The tables of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &[DeclaredTable] {
    tables.own().map_or(&[], |own: &DeclaredTables| &own.tables)
}

/// Tables of axes that the job does not have; one that moves an axis of the job is told as such.
fn tell_others(reading: &mut ReadOutReader<'_>, found: &mut DeclaredTables) {
    let axes = |table: &DeclaredTable| [table.base.clone(), table.output.clone()];
    for table in reading.take_others(&mut found.tables, axes) {
        let what = format!("the {}", table.name());
        let moving = table.base.clone();
        reading.tell(match reading.has(&table.output) {
            true => InControl::Follows { what, moving },
            false => InControl::OfOthers { what, axes: "axes" },
        });
    }
}
