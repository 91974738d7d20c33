//! What a kit changes on a Siemens control: tables, their switches, weights and limit, MD32450.

use super::data::{
    BACKLASH, CEC_LIMIT, CEC_ON, Datum, LEC_ON, TABLE_ON, WEIGHT, number, of_place, switches,
    variable,
};
use crate::control::table::Tables;
use crate::control::table::siemens::SiemensTables;
use crate::judge::before::{Before, ChangedBy, Old, unknown};
use crate::quantity::Axis;
use crate::read::siemens::datum;
use crate::write::siemens::encoder;
use ChangedBy::{File, Nobody, Precondition};

/// In which order the rollback sets machine data: what makes tables act comes last.
const ORDER: [Datum; 6] = [BACKLASH, CEC_LIMIT, WEIGHT, LEC_ON, TABLE_ON, CEC_ON];

/// A machine or setting datum that a kit changes.
struct Changed {
    datum: Datum,
    index: String,
    by: ChangedBy,
}

/// Of the tables of a kit, of those held and of those that acted.
pub(super) fn old(
    before: &Before<'_>,
    [kit, held, acted]: [&SiemensTables; 3],
) -> Result<Old, Vec<String>> {
    let (mut tables, mut missing, mut stays) = (Vec::new(), Vec::new(), Vec::new());
    for table in &kit.tables {
        let name = table.place.name();
        let held_at = |(of, index): &(Datum, String)| number(&before.held.data, *of, index);
        let is_off = |switch| held_at(switch).is_some_and(|value| value <= 0.0);
        match held.at(&table.place) {
            Some(found) if found.values.iter().all(Option::is_some) => tables.push(found.clone()),
            None if before.held.without_grid.contains(&table.place.to_string()) => {
                // One that is off may keep the values of the kit.
                match switches(table).iter().any(is_off) {
                    true => stays.push(name),
                    false => missing
                        .push(format!("{name} (read out without a grid, and not as switched off)")),
                }
            }
            _ => missing.push(name),
        }
    }
    if !missing.is_empty() {
        return Err(missing);
    }
    let (mut data, mut lacking) = (Vec::new(), Vec::new());
    for Changed { datum: of, index, by } in changed(before, kit, acted) {
        match datum(&before.held.data, &variable(of, &index)) {
            Some(found) => data.push(found.clone()),
            None if by == Nobody => {}
            None => lacking.push((format!("{} ${}", of.0, of.1), format!("[{index}]"), by)),
        }
    }
    let tables = Tables::Siemens(SiemensTables { tables });
    Ok(Old { tables, data, unknown: unknown(lacking), stays })
}

/// All machine data that change when the kit is loaded as its checklist says, each once.
fn changed(before: &Before<'_>, kit: &SiemensTables, acted: &SiemensTables) -> Vec<Changed> {
    let mut all: Vec<Changed> = Vec::new();
    let mut add = |datum: Datum, index: String, by: ChangedBy| match all
        .iter_mut()
        .find(|known| known.datum == datum && known.index == index)
    {
        Some(known) if known.by == Nobody => known.by = by,
        Some(_) => {}
        None => all.push(Changed { datum, index, by }),
    };
    for table in &kit.tables {
        switches(table).into_iter().for_each(|(datum, index)| add(datum, index, File));
        if table.place.cec().is_some() {
            add(CEC_LIMIT, table.output_axis.clone(), Precondition);
            add(WEIGHT, table.place.index(), Precondition);
        }
    }
    // Old tables that would act in addition to the new ones have to be switched off.
    for place in acted.tables.iter().map(|table| &table.place) {
        add(of_place(place)[0], place.index(), Precondition);
    }
    for axis in Axis::ALL {
        let Some(by) = before.backlash(axis) else { continue };
        let system = encoder(before.task, axis);
        let mut data = vec![(BACKLASH, system, by)];
        if before.plan.has_two_tables(axis) {
            // The error is in CEC tables: no ENC_COMP table of the axis may act.
            data.push((LEC_ON, system, Precondition));
            data.push((LEC_ON, 1 - system.min(1), Nobody));
        }
        for (datum, system, by) in data {
            for own in &before.plan.names[axis] {
                add(datum, format!("{system},{}", own.to_uppercase()), by);
            }
        }
    }
    let place = |c: &Changed| ORDER.iter().position(|datum| *datum == c.datum);
    all.sort_by_key(place);
    all
}
