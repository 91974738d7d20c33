//! ISG kernel: what was read out of it, against a job and against a kit.

use crate::control::controller::IsgFacts;
use crate::control::table::Tables;
use crate::control::table::isg::{Curve, IsgTables};
use crate::judge::active::{Found, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::quantity::{Axis, PerAxis};
use crate::read::isg;
use crate::text::Problems;

impl Family for IsgFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let (tables, findings) = isg::read(reading.texts)?;
        reading.findings.extend(findings);
        Ok(Found::all(Tables::Isg(tables)))
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let tables = own(side.tables);
        let name = |axis: Axis| tables.axes[axis].map_or(String::new(), |own| own.to_string());
        let letters = |chosen: PerAxis<bool>| {
            let chosen = Axis::ALL.into_iter().filter(|axis| chosen[*axis]);
            Axis::letters(&chosen.collect::<Vec<Axis>>())
        };
        let axes = Axis::ALL.map(|axis| (axis.to_string(), name(axis)));
        let settings = [
            ("chain".to_string(), Axis::letters(&tables.chain)),
            ("negate".to_string(), letters(tables.negated)),
            ("set_to_zero".to_string(), letters(tables.zeroed)),
        ];
        let stated = axes.into_iter().chain(settings);
        let stated = stated.map(|(key, value)| {
            let item = ("list".to_string(), Item::Name(key));
            (item, Entry::of(Value::Text(value), true, true))
        });
        let of_curve = |curve: &Curve| {
            let block = curve.parameter.to_string();
            let pair = curve.parameter.pair();
            let told = pair.is_none_or(|(base, output)| side.tells(&name(base), &name(output)));
            let points = (0_u32..).zip(curve.points.clone());
            points.map(move |(index, point)| {
                let numbers = [point.position, point.value].map(Some).to_vec();
                let item = (block.clone(), Item::Point(index));
                (item, Entry::of(Value::Numbers(numbers), told, told))
            })
        };
        stated.chain(tables.curves.iter().flat_map(of_curve)).collect()
    }

    /// The files that were kept are the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["the list and the parameter files of the control".to_string()])
    }
}

/// The tables of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &IsgTables {
    const NONE: &IsgTables = &IsgTables::NONE;
    tables.own().unwrap_or(NONE)
}
