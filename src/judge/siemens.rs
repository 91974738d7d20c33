//! SINUMERIK: what was read out of it, against a job and against a kit.

mod before;
mod data;
mod machine_data;
mod not_read_out;
mod read_out;
mod surroundings;

use crate::control::controller::SiemensFacts;
use crate::control::table::Tables;
use crate::control::table::siemens::{Place, SiemensTable, SiemensTables};
use crate::judge::active::{Found, Others, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Value, table};
use crate::judge::family::{Family, Side};
use crate::judge::findings::{Difference, InControl};
use crate::read::ReadBack;
use crate::text::{Finding, Problems};
use crate::write::compensation::Compiled;
use data::{numbered, of_place};

impl Family for SiemensFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        read_out::read(reading)
    }

    fn taken(&self, others: &Others, new: &Tables) -> Vec<(String, &'static str)> {
        const HELP: &str = "state a `first_table` behind it in [compensation]";
        let numbers = own(new).tables.iter().filter_map(|table| table.place.cec());
        let taken = numbers.filter(|number| others.cec_tables.contains(number));
        let named = taken.map(|number| (Place::Cec(number).name(), HELP));
        named.collect()
    }

    /// Their switches.
    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let new = own(new);
        let places = own(old).tables.iter().map(|table| &table.place);
        let stays = places.filter(|place| new.at(place).is_none());
        stays.map(|place| numbered(of_place(place)[0], &place.index())).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let others = own(side.others);
        let explained = |t: &SiemensTable| !side.tells(&t.input_axis, &t.output_axis);
        let mut entries = Entries::new();
        for own in &own(side.tables).tables {
            let SiemensTable { place, input_axis: moving, output_axis: output, .. } = own;
            let (mut name, mut told) = (place.name(), (true, !explained(own)));
            if let Some(system) = place.lec() {
                // A table of the other measuring system is told as such (`measuring_systems`).
                let is_other = |other: (&String, u32)| other.0 == system.0 && other != system;
                told.1 &= !others.tables.iter().filter_map(|t| t.place.lec()).any(is_other);
                told.0 = told.1;
            } else {
                name += &format!(" ({output} while {moving} moves)");
                told.1 &= !others.at(place).is_some_and(explained);
            }
            table(&mut entries, &name, &fields(own), &own.values, told);
        }
        entries
    }

    fn other_settings(&self, wanted: &Compiled, read: &ReadBack) -> Vec<Difference> {
        machine_data::differences(own(&wanted.tables), &wanted.stale, &read.machine_data, self)
    }

    fn absent_settings(&self, wanted: &Tables, read: &ReadBack) -> Vec<Finding> {
        machine_data::absent(own(wanted), &read.machine_data, self)
    }

    fn measuring_systems(&self, wanted: &Tables, found: &Tables) -> Vec<Difference> {
        let lec = |tables| own(tables).tables.iter().filter_map(|table| table.place.lec());
        let other = lec(found).filter_map(|(axis, is)| {
            let (_, asked) = lec(wanted).find(|(job, _)| job.eq_ignore_ascii_case(axis))?;
            let (axis, is, asked) = (axis.clone(), is + 1, asked + 1);
            (is != asked).then_some(Difference::ForeignSystem { axis, is, asked })
        });
        other.collect()
    }

    fn surroundings(&self, before: &Before<'_>) -> (Vec<InControl>, Vec<String>) {
        let (wanted, held) = (before.compiled, before.held);
        let tables = own(&wanted.tables);
        let found = surroundings::cec_limits(held, tables, wanted.state.unit);
        (found, surroundings::absent(tables, held))
    }

    fn old(&self, before: &Before<'_>) -> Result<Old, Vec<String>> {
        before::old(before, before.tables().map(own))
    }
}

/// The tables of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &SiemensTables {
    const NONE: &SiemensTables = &SiemensTables::NONE;
    tables.own().unwrap_or(NONE)
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
