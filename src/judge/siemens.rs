//! SINUMERIK: what was read out of it, against a job and against a kit.

mod before;
mod data;
mod machine_data;
mod not_read_out;
mod read_out;
mod surroundings;

use crate::control::controller::SiemensFacts;
use crate::control::table::Tables;
use crate::control::table::siemens::{
    CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables,
};
use crate::judge::active::{Found, Others, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Value, table};
use crate::judge::family::{Family, Side};
use crate::judge::findings::{Difference, InControl};
use crate::read::ReadBack;
use crate::text::finding::Finding;
use crate::text::problem::Problems;
use crate::write::compensation::Compiled;
use data::{Datum, LEC_ON, TABLE_ON};

impl Family for SiemensFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        read_out::read(reading)
    }

    fn taken(&self, others: &Others, new: &Tables) -> Vec<(String, &'static str)> {
        const HELP: &str = "state a `first_table` behind it in [compensation]";
        let numbers = own(new).cec.iter().map(|table| table.number);
        let taken = numbers.filter(|number| others.cec_tables.contains(number));
        let named = taken.map(|number| (format!("CEC table {number}"), HELP));
        named.collect()
    }

    /// Their switches.
    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let new = switches(own(new));
        let mut left = switches(own(old));
        left.retain(|switch| !new.contains(switch));
        left
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let (tables, others) = (own(side.tables), own(side.others));
        let explained = |base: &str, output: &str| !side.tells(base, output);
        let mut entries = Entries::new();
        for lec in &tables.lec {
            // A table of the other measuring system is told as such (`measuring_systems`).
            let other_system = |t: &LecTable| t.axis == lec.axis && t.encoder != lec.encoder;
            let told = !explained(&lec.axis, &lec.axis) && !others.lec.iter().any(other_system);
            let fields = grid_fields(lec.grid, lec.modulo);
            let told = (told, told);
            table(&mut entries, &lec.name(), &fields, &lec.values, told);
        }
        for cec in &tables.cec {
            let (moving, output) = (&cec.input_axis, &cec.output_axis);
            let same = others.cec.iter().find(|t| t.number == cec.number);
            let is_known = |t: &CecTable| explained(&t.input_axis, &t.output_axis);
            let told = !explained(moving, output) && !same.is_some_and(is_known);
            let direction = match cec.direction {
                CecDirection::Both => "0",
                CecDirection::Plus => "1",
                CecDirection::Minus => "-1",
            };
            let mut fields = grid_fields(cec.grid, cec.modulo);
            fields.extend([
                ("DIRECTION", direction.to_string()),
                ("MULT_BY_TABLE", cec.multiply_by.to_string()),
            ]);
            let name = format!("{} ({output} while {moving} moves)", cec.name());
            table(&mut entries, &name, &fields, &cec.values, (true, told));
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
        let other = own(found).lec.iter().filter_map(|table| {
            let mut wanted = own(wanted).lec.iter();
            let job = wanted.find(|job| job.axis.eq_ignore_ascii_case(&table.axis))?;
            let (is, asked) = (table.encoder + 1, job.encoder + 1);
            let axis = table.axis.clone();
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
    const NONE: &SiemensTables = &SiemensTables { lec: Vec::new(), cec: Vec::new() };
    tables.own().unwrap_or(NONE)
}

/// What switches tables on.
fn switches(tables: &SiemensTables) -> Vec<String> {
    let switch = |(number, name): Datum, index: String| format!("{number} ${name}[{index}]");
    let lec = tables.lec.iter();
    let lec = lec.map(|t| switch(LEC_ON, format!("{},{}", t.encoder, t.axis)));
    let cec = tables.cec.iter();
    lec.chain(cec.map(|t| switch(TABLE_ON, t.number.to_string()))).collect()
}

fn grid_fields(grid: SiemensGrid, modulo: bool) -> Vec<(&'static str, String)> {
    let number = |value: f64| Value::Numbers(vec![Some(value)]).words();
    vec![
        ("MIN", number(grid.min)),
        ("STEP", number(grid.step)),
        ("MAX", number(grid.max)),
        ("IS_MODULO", u8::from(modulo).to_string()),
    ]
}
