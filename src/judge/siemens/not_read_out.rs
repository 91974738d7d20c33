//! Tables that are switched on, or of which nothing is said, and that no file of a read-out holds.

use super::data::{CEC_ON, CEC_POINTS, Datum, LEC_ON, LEC_POINTS, TABLE_ON};
use super::read_out::Sorted;
use crate::control::claims::Assumption;
use crate::control::table::siemens::LecTable;
use crate::judge::findings::{InControl, listed};
use crate::read::siemens::{MachineDatum, MachineValue};

impl Sorted<'_, '_> {
    /// Tables that are switched on and in no file of the read-out, so that what they do is not known.
    pub(super) fn tell_what_was_not_read_out(&mut self) {
        let absent = [self.lec_not_read_out(), self.cec_not_read_out()];
        absent.into_iter().flatten().for_each(|told| self.reading.tell(told));
        for what in self.untold() {
            let assumption = Assumption::of_job(
                &what,
                "none while measuring",
                "no file holds such a table or its switches; an old table would be lost with the new ones",
            );
            self.reading.take(assumption, InControl::Untold { what });
        }
    }

    /// Names of the job's axes as the control writes them.
    fn own_names(&self) -> Vec<String> {
        let names = self.reading.names.iter().flat_map(|(_, names)| names);
        names.map(|name| name.to_uppercase()).collect()
    }

    fn is_reserved(&self, table: &str) -> bool {
        self.held.without_grid.iter().any(|name| name == table)
    }

    /// Of which tables the files say nothing, neither values nor switches.
    fn untold(&self) -> Vec<String> {
        let tells_of_lec = |name: &String| {
            let of_system = |encoder: &str| {
                self.value(LEC_ON, &[encoder, name]).is_some()
                    || self.is_reserved(&format!("AA_ENC_COMP[{encoder},{name}]"))
            };
            ["0", "1"].into_iter().any(of_system)
                || self.all.tables.lec.iter().any(|table| table.axis == *name)
        };
        let mut lec = self.own_names();
        lec.retain(|name| !tells_of_lec(name));
        let is_of_cec =
            |d: &MachineDatum| [CEC_ON, TABLE_ON, CEC_POINTS].iter().any(|own| own.1 == d.name);
        let mut reserved = self.held.without_grid.iter();
        let tells_of_cec = !self.all.tables.cec.is_empty()
            || reserved.any(|table| table.starts_with("AN_CEC"))
            || self.all.machine_data.iter().any(is_of_cec);
        let lec = (!lec.is_empty()).then(|| format!("ENC_COMP of {}", listed(&lec)));
        let cec = (!tells_of_cec).then(|| "CEC".to_string());
        lec.into_iter().chain(cec).collect()
    }

    /// MD32700 = 1 of an axis of the job without its table. Where the job does not state which
    /// measuring system is active, either may be.
    fn lec_not_read_out(&self) -> Option<InControl> {
        let mut switches = Vec::new();
        for (axis, names) in self.reading.names.iter() {
            let stated = self.stated_encoder(axis);
            for (name, encoder) in names.iter().flat_map(|name| [(name, 0_u32), (name, 1)]) {
                let (name, number) = (name.to_uppercase(), encoder.to_string());
                let is = |datum| self.is_above_zero(datum, &[&number, &name]);
                let holds = |table: &LecTable| {
                    table.axis == name && (table.encoder == encoder || stated.is_none())
                };
                if is(LEC_ON) == Some(true)
                    && is(LEC_POINTS) != Some(false)
                    && stated.is_none_or(|stated| stated == encoder)
                    && !self.all.tables.lec.iter().any(holds)
                    && !self.is_reserved(&format!("AA_ENC_COMP[{number},{name}]"))
                {
                    switches.push(format!("[{number},{name}]"));
                }
            }
        }
        (!switches.is_empty()).then_some(InControl::LecNotRead { switches })
    }

    /// SD41300 = 1 without the CEC table, or MD32710 = 1 of an axis of the job where nothing else
    /// tells of CEC.
    fn cec_not_read_out(&self) -> Option<InControl> {
        let is_on = |name: &String| self.is_above_zero(CEC_ON, &[name]);
        let mut axes = self.own_names();
        axes.retain(|name| is_on(name).is_some());
        let some_are_off = axes.iter().any(|name| is_on(name) == Some(false));
        axes.retain(|name| is_on(name) == Some(true));
        if axes.is_empty() && some_are_off {
            return None;
        }
        let held = &self.all.tables.cec;
        let (switches, memory) = (self.of_tables(TABLE_ON), self.of_tables(CEC_POINTS));
        let is_absent = |number: &String| {
            !held.iter().any(|t| t.number.to_string() == *number)
                && !memory.contains(&(number.clone(), false))
                && !self.is_reserved(&format!("AN_CEC[{number}]"))
        };
        let on = switches.iter().filter(|(_, is_on)| *is_on);
        let absent = on.map(|(number, _)| number.clone()).filter(is_absent);
        let absent: Vec<String> = absent.collect();
        let tells = !held.is_empty() || !switches.is_empty();
        let has_memory = memory.is_empty() || memory.iter().any(|(_, has)| *has);
        match absent.as_slice() {
            [] => {
                (!tells && has_memory && !axes.is_empty()).then_some(InControl::CecUnknown { axes })
            }
            some => {
                let word = if some.len() == 1 { "table" } else { "tables" };
                let tables = format!("{word} {}", listed(some));
                Some(InControl::CecNotRead { tables })
            }
        }
    }

    /// A datum of every CEC table that was read out: number of the table, and whether it is above 0.
    fn of_tables(&self, (_, name): Datum) -> Vec<(String, bool)> {
        let own = self.all.machine_data.iter().filter(|d| d.name == name);
        own.filter_map(|datum| match (&datum.indices[..], &datum.value) {
            ([table], MachineValue::Number(value)) => Some((table.clone(), *value > 0.0)),
            _ => None,
        })
        .collect()
    }
}
