//! Klipper: what was read out of it, against a job and against a kit.

use crate::control::controller::KlipperFacts;
use crate::control::table::Tables;
use crate::control::table::klipper::{FACTORS, Skew};
use crate::judge::active::{Found, Held, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::Disagreements;
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::Family;
use crate::quantity::axis::PerAxis;
use crate::read::{Text, klipper};
use crate::text::problem::Problems;

impl Family for KlipperFacts {
    fn read_out(
        &self,
        _reading: &mut ReadOutReader<'_>,
        texts: &[Text<'_>],
    ) -> Result<Found, Problems> {
        let texts: Vec<(&str, &str)> = texts
            .iter()
            .map(|(name, text)| (&**name, &**text))
            .collect();
        let tables = Tables::Klipper(klipper::read(&texts)?);
        Ok(Found {
            held: Held::plain(tables.clone()),
            tables,
            backlash: PerAxis::default(),
            unit: None,
        })
    }

    /// The profile that is loaded last acts alone.
    fn left_over(&self, _old: &Tables, _new: &Tables) -> Vec<String> {
        Vec::new()
    }

    fn entries(
        &self,
        tables: &Tables,
        _others: &Tables,
        diagnosis: Option<&Disagreements>,
    ) -> Entries {
        let Some(skew) = own(tables) else {
            return Entries::new();
        };
        let block = || "skew_correction".to_string();
        let name = (block(), Item::Name("its name".to_string()));
        let name = (name, Entry::of(Value::Text(skew.name.clone()), true, true));
        let factors = FACTORS.iter().zip(skew.factors());
        let factors = factors.map(|((term, name), factor)| {
            let (base, output) = (term.along.key(), term.of.key());
            let told = !diagnosis.is_some_and(|d| d.explains(base, output));
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
    match tables {
        Tables::Klipper(own) => own.skew.as_ref(),
        _ => None,
    }
}
