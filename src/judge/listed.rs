//! Tables that list their points one by one, as any control holds them.

use crate::control::controller::Listed;
use crate::control::table::Tables;
use crate::control::table::listed::{ListedTable, ListedTables, Point};
use crate::judge::active::ReadOutReader;
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::Side;

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
