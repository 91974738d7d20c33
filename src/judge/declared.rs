//! Files that were read out of a declared control, against a job and against a kit.

use crate::control::controller::{DeclaredFacts, Listed};
use crate::control::table::Tables;
use crate::control::table::listed::{ListedTable, ListedTables};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::Entries;
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::judge::listed;
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
        let (old, new) = (listed::own(old), listed::own(new));
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
        listed::entries(self, side, self.first_point.value)
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
        let mut others = listed::take_others(reading, found);
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
