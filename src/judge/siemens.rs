//! SINUMERIK: what was read out of it, against a job and against a kit.

mod machine_data;
mod read_out;

use self::machine_data::{
    BACKLASH, CEC_LIMIT, CEC_ON, Datum, LEC_ON, TABLE_ON, WEIGHT, numbered, of_place, switches,
    variable,
};
use crate::control::controller::SiemensFacts;
use crate::control::table::Tables;
use crate::control::table::siemens::{Place, SiemensTable, SiemensTables};
use crate::judge::active::{Others, ReadOutReader};
use crate::judge::disagreement::{Entries, Entry, Item, Value};
use crate::judge::family::{Before, ChangedBy, Family, Old, Side, unknown};
use crate::judge::findings::{Difference, InControl};
use crate::quantity::Axis;
use crate::read::ReadBack;
use crate::text::{Finding, Problems, grouped};
use crate::write::compensation::Compiled;
use crate::write::siemens::encoder;
use ChangedBy::{File, Nobody, Precondition};

impl Family for SiemensFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
        read_out::read(reading)
    }

    fn taken(&self, others: &Others, new: &Tables) -> Vec<(String, &'static str)> {
        const HELP: &str = "state a `first_table` behind it in [compensation]";
        let numbers =
            new.own::<SiemensTables>().tables.iter().filter_map(|table| table.place.cec());
        let taken = numbers.filter(|number| others.cec_tables.contains(number));
        taken.map(|number| (Place::Cec(number).name(), HELP)).collect()
    }

    /// Their switches.
    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new): (&SiemensTables, &SiemensTables) = (old.own(), new.own());
        let places = old.tables.iter().map(|table| &table.place);
        let stays = places.filter(|place| new.at(place).is_none());
        stays.map(|place| numbered(of_place(place)[0], &place.index())).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let [own, others]: [&SiemensTables; 2] = [side.tables, side.others].map(Tables::own);
        let explained = |t: &SiemensTable| !side.tells(&t.input_axis, &t.output_axis);
        let mut entries = Entries::new();
        for own in &own.tables {
            let SiemensTable { place, input_axis: moving, output_axis: output, .. } = own;
            let (mut name, mut alone, mut differing) = (place.name(), true, !explained(own));
            if let Some(system) = place.lec() {
                // A table of the other measuring system is told as such (`measuring_systems`).
                let is_other = |other: (&String, u32)| other.0 == system.0 && other != system;
                differing &= !others.tables.iter().filter_map(|t| t.place.lec()).any(is_other);
                alone = differing;
            } else {
                name += &format!(" ({output} while {moving} moves)");
                differing &= !others.at(place).is_some_and(explained);
            }
            let fields = fields(own).into_iter();
            let fields =
                fields.map(|(field, value)| (Item::Name(field.to_string()), Value::Text(value)));
            let values = (0..).zip(&own.values);
            let values =
                values.map(|(point, value)| (Item::Point(point), Value::Numbers(vec![*value])));
            let entry = |(item, value)| ((name.clone(), item), Entry { value, alone, differing });
            entries.extend(fields.chain(values).map(entry));
        }
        entries
    }

    fn beside(&self, wanted: &Compiled, read: &ReadBack) -> Vec<Finding> {
        machine_data::beside(wanted.tables.own(), &wanted.stale, &read.machine_data, self)
    }

    fn measuring_systems(&self, wanted: &Tables, found: &Tables) -> Vec<Difference> {
        let other = systems(found).filter_map(|(axis, is)| {
            let (_, asked) = systems(wanted).find(|(job, _)| job.eq_ignore_ascii_case(axis))?;
            let (axis, is, asked) = (axis.clone(), is + 1, asked + 1);
            (is != asked).then_some(Difference::ForeignSystem { axis, is, asked })
        });
        other.collect()
    }

    fn surroundings(&self, before: &Before<'_>) -> (Vec<InControl>, Vec<String>) {
        let [tables, held, _] = before.tables().map(Tables::own::<SiemensTables>);
        let found = machine_data::cec_limits(held, tables, before.compiled.state.unit);
        (found, machine_data::not_held(tables, held))
    }

    fn old(&self, before: &Before<'_>) -> Result<Old, Vec<String>> {
        let [kit, held, acted] = before.tables().map(Tables::own::<SiemensTables>);
        let mut old = SiemensTables::default();
        let (mut missing, mut stays) = (Vec::new(), Vec::new());
        for table in &kit.tables {
            let name = table.place.name();
            let is_off = |(of, index): &(Datum, String)| {
                held.number(*of, index).is_some_and(|value| value <= 0.0)
            };
            match held.at(&table.place) {
                Some(found) if found.values.iter().all(Option::is_some) => {
                    old.tables.push(found.clone())
                }
                None if held.reserved.contains(&table.place.to_string()) => {
                    // One that is off may keep the values of the kit.
                    match switches(table).iter().any(is_off) {
                        true => stays.push(name),
                        false => missing.push(format!(
                            "{name} (read out without a grid, and not as switched off)"
                        )),
                    }
                }
                _ => missing.push(name),
            }
        }
        if !missing.is_empty() {
            return Err(missing);
        }
        let mut lacking = Vec::new();
        for (of, index, by) in changed(before, kit, acted) {
            match held.datum(&variable(of, &index)) {
                Some(found) => old.data.push(found.clone()),
                None if by == Nobody => {}
                None => lacking.push((format!("{} ${}", of.0, of.1), format!("[{index}]"), by)),
            }
        }
        Ok(Old { tables: Tables::Siemens(old), unknown: unknown(lacking), stays })
    }
}

/// Axis and measuring system of each ENC_COMP table.
fn systems(tables: &Tables) -> impl Iterator<Item = (&String, u32)> {
    tables.own::<SiemensTables>().tables.iter().filter_map(|table| table.place.lec())
}

/// The parameters of a table as files write them.
fn fields(table: &SiemensTable) -> Vec<(&'static str, String)> {
    let number = |value: f64| Value::Numbers(vec![Some(value)]).words();
    let mut fields = vec![
        ("MIN", number(table.grid.min)),
        ("STEP", number(table.grid.step)),
        ("MAX", number(table.grid.max)),
        ("IS_MODULO", u8::from(table.modulo).to_string()),
    ];
    if table.place.cec().is_some() {
        fields.push(("DIRECTION", table.direction_text().to_string()));
        fields.push(("MULT_BY_TABLE", table.multiply_by.to_string()));
    }
    fields
}

// What a kit changes on a Siemens control: tables, their switches, weights and limit, MD32450.

/// In which order the rollback sets machine data: what makes tables act comes last.
const ORDER: [Datum; 6] = [BACKLASH, CEC_LIMIT, WEIGHT, LEC_ON, TABLE_ON, CEC_ON];

/// All machine and setting data that change when the kit is loaded as its checklist says, each once.
fn changed(
    before: &Before<'_>,
    kit: &SiemensTables,
    acted: &SiemensTables,
) -> Vec<(Datum, String, ChangedBy)> {
    let mut all: Vec<((Datum, String), ChangedBy)> = Vec::new();
    let mut add = |datum: Datum, index: String, by| all.push(((datum, index), by));
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
    let by_somebody = |all: Vec<ChangedBy>| all.into_iter().find(|by| *by != Nobody);
    let all = grouped(all).into_iter();
    let all = all.map(|((of, index), all)| (of, index, by_somebody(all).unwrap_or(Nobody)));
    let mut all: Vec<(Datum, String, ChangedBy)> = all.collect();
    all.sort_by_key(|(of, ..)| ORDER.iter().position(|datum| datum == of));
    all
}
