//! Klipper: what was read out of it, against a job and against a kit.

use crate::control::controller::KlipperFacts;
use crate::control::table::Tables;
use crate::control::table::klipper::{FACTORS, KlipperTables, Skew};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::read::klipper;
use crate::text::problem::Problems;

impl Family for KlipperFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        Ok(Found::all(Tables::Klipper(klipper::read(reading.texts)?)))
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let Some(skew) = own(side.tables) else {
            return Entries::new();
        };
        let block = || "skew_correction".to_string();
        let name = (block(), Item::Name("its name".to_string()));
        let name = (name, Entry::of(Value::Text(skew.name.clone()), true, true));
        let factors = FACTORS.iter().zip(skew.factors());
        let factors = factors.map(|((term, name), factor)| {
            let (base, output) = (term.along.key(), term.of.key());
            let told = side.tells(base, output);
            let item = (block(), Item::Name((*name).to_string()));
            let value = Value::Numbers(vec![Some(factor)]);
            (item, Entry::of(value, told, told))
        });
        factors.chain([name]).collect()
    }

    /// The configuration that was kept is the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["printer.cfg".to_string()])
    }
}

/// The profile of a memory.
fn own(tables: &Tables) -> Option<&Skew> {
    tables.own::<KlipperTables>()?.skew.as_ref()
}
