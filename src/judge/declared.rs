//! Files that were read out of a declared control, against a job and against a kit.

use crate::control::controller::{DeclaredFacts, Listed};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::read::declared::tables;
use crate::text::Problems;

impl Family for DeclaredFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let mut found = tables(reading.texts, self, true)?;
        let held = Tables::Listed(found.clone());
        // A new list takes the place of the whole old one: an old table of another axis would be lost, and is
        // refused where it is emulated.
        if self.typed.is_none() || reading.judges() {
            self.tell_others(reading, &mut found);
        }
        Ok(Found { tables: Tables::Listed(found), ..Found::all(held) })
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
        // Typed by hand, a table for each direction stays beside one for both.
        let is_same = |one: &ListedTable, other: &ListedTable| {
            one.is_for(&other.base, &other.output)
                && (self.typed.is_none() || one.has_two() == other.has_two())
        };
        let stays = |table: &&ListedTable| !new.iter().any(|new| is_same(new, table));
        old.iter()
            .filter(stays)
            .map(|table| format!("the old {}", self.table_name(table)))
            .collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        entries(self, side, self.first_point.value)
    }

    /// The files that were read out are the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["tables of this format".to_string()])
    }
}

impl DeclaredFacts {
    /// Tables of axes that the job does not have; one that moves an axis of the job is told as such. A set of factors
    /// holds all, 0 for an axis that the machine does not have.
    fn tell_others(&self, reading: &mut ReadOutReader<'_>, found: &mut ListedTables) {
        let mut others = take_others(reading, found);
        others.retain(|table| self.factors.is_none() || !table.is_zero());
        for table in others {
            let what = format!("the {}", self.table_name(&table));
            let moving = table.base.clone();
            reading.tell(match reading.has(&table.output) {
                true => InControl::Follows { what, moving },
                false => InControl::OfOthers { what, axes: "axes" },
            });
        }
    }
}

// Tables that list their points one by one, as any control holds them.

/// The tables of a memory; a memory of another family holds none.
pub(super) fn own(tables: &Tables) -> &[ListedTable] {
    tables.own().map_or(&[], |own: &ListedTables| &own.tables)
}

/// Point by point what tables hold, of which the first one has this number, and the name of their set.
pub(super) fn entries(facts: &impl Listed, side: &Side<'_>, first_point: u32) -> Entries {
    let of_table = |table: &ListedTable| {
        let told = side.tells(&table.base, &table.output);
        let name = facts.table_name(table);
        let entry = move |(index, point): (u32, &Point)| {
            let numbers = vec![Some(point.position), Some(point.forward), point.reverse];
            let key = (name.clone(), Item::Point(index));
            (key, Entry::of(Value::Numbers(numbers), told, told))
        };
        (first_point..).zip(&table.points).map(entry).collect::<Vec<_>>()
    };
    let set = side.tables.own().and_then(|own: &ListedTables| own.set.clone());
    let set = set.map(|name| {
        let key = ("set of tables".to_string(), Item::Name("its name".to_string()));
        (key, Entry::of(Value::Text(name), true, true))
    });
    own(side.tables).iter().flat_map(of_table).chain(set).collect()
}

/// Takes out tables of axes that the job does not have.
pub(super) fn take_others(
    reading: &ReadOutReader<'_>,
    found: &mut ListedTables,
) -> Vec<ListedTable> {
    let axes = |table: &ListedTable| [table.base.clone(), table.output.clone()];
    reading.take_others(&mut found.tables, axes)
}
