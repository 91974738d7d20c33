//! Tables that are switched on, or of which nothing is said, and that no file of a read-out holds.

use super::read_out::Sorted;
use crate::control::claims::Assumption;
use crate::control::table::siemens::Place;
use crate::judge::findings::{InControl, listed};
use crate::judge::siemens::machine_data::{
    CEC_ON, CEC_POINTS, Datum, LEC_ON, TABLE_ON, of_place, variable,
};
use crate::read::siemens::MachineDatum;

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

    fn is_reserved(&self, place: &Place) -> bool {
        self.held.without_grid.contains(&place.to_string())
    }

    /// Both tables that an axis of the control may have in ENC_COMP.
    fn lec_places(name: &str) -> [Place; 2] {
        [0, 1].map(|encoder| Place::Lec { axis: name.to_string(), encoder })
    }

    /// Of which tables the files say nothing, neither values nor switches.
    fn untold(&self) -> Vec<String> {
        let tells_of = |place: &Place| {
            self.value(LEC_ON, &place.index()).is_some()
                || self.is_reserved(place)
                || self.all.tables.at(place).is_some()
        };
        let mut lec = self.own_names();
        lec.retain(|name| !Self::lec_places(name).iter().any(tells_of));
        let is_of_cec = |own: &MachineDatum| {
            let mut data = [CEC_ON, TABLE_ON, CEC_POINTS].into_iter();
            data.any(|datum| own.variable.starts_with(&variable(datum, "")))
        };
        let mut reserved = self.held.without_grid.iter();
        let tells_of_cec = self.all.tables.cec().next().is_some()
            || reserved.any(|table| table.starts_with("AN_CEC"))
            || self.all.machine_data.iter().any(is_of_cec);
        let lec = (!lec.is_empty()).then(|| format!("ENC_COMP of {}", listed(&lec)));
        let cec = (!tells_of_cec).then(|| "CEC".to_string());
        lec.into_iter().chain(cec).collect()
    }

    /// Whether a table is switched on and has memory, and no file holds it.
    fn is_missing(&self, place: &Place) -> bool {
        let [switch, memory] = of_place(place);
        let is = |datum| self.is_above_zero(datum, &place.index());
        is(switch) == Some(true)
            && is(memory) != Some(false)
            && self.all.tables.at(place).is_none()
            && !self.is_reserved(place)
    }

    /// MD32700 = 1 of an axis of the job without its table. Where the job does not state which
    /// measuring system is active, either may be.
    fn lec_not_read_out(&self) -> Option<InControl> {
        let mut switches = Vec::new();
        for (axis, names) in self.reading.names.iter() {
            let stated = self.stated_encoder(axis);
            let is_active = |place: &Place| {
                stated.is_none() || place.lec().map(|(_, encoder)| encoder) == stated
            };
            for name in names {
                let mut places = Self::lec_places(&name.to_uppercase()).to_vec();
                places.retain(is_active);
                if !places.iter().any(|place| self.all.tables.at(place).is_some()) {
                    let missing = places.iter().filter(|place| self.is_missing(place));
                    switches.extend(missing.map(|place| format!("[{}]", place.index())));
                }
            }
        }
        (!switches.is_empty()).then_some(InControl::LecNotRead { switches })
    }

    /// SD41300 = 1 without the CEC table, or MD32710 = 1 of an axis of the job where nothing else
    /// tells of CEC.
    fn cec_not_read_out(&self) -> Option<InControl> {
        let is_on = |name: &String| self.is_above_zero(CEC_ON, name);
        let mut axes = self.own_names();
        axes.retain(|name| is_on(name).is_some());
        let some_are_off = axes.iter().any(|name| is_on(name) == Some(false));
        axes.retain(|name| is_on(name) == Some(true));
        if axes.is_empty() && some_are_off {
            return None;
        }
        let (switches, memory) = (self.of_tables(TABLE_ON), self.of_tables(CEC_POINTS));
        let absent = switches.iter().filter(|(place, _)| self.is_missing(place));
        let absent: Vec<String> = absent.map(|(place, _)| place.index()).collect();
        if !absent.is_empty() {
            let word = if absent.len() == 1 { "table" } else { "tables" };
            let tables = format!("{word} {}", listed(&absent));
            return Some(InControl::CecNotRead { tables });
        }
        let tells = self.all.tables.cec().next().is_some() || !switches.is_empty();
        let has_memory = memory.is_empty() || memory.iter().any(|(_, has)| *has);
        (!tells && has_memory && !axes.is_empty()).then_some(InControl::CecUnknown { axes })
    }

    /// A datum of every CEC table that was read out: the table, and whether it is above 0.
    fn of_tables(&self, datum: Datum) -> Vec<(Place, bool)> {
        let before = variable(datum, "") + "[";
        let own = |own: &MachineDatum| {
            let table = own.variable.strip_prefix(&before)?.strip_suffix(']')?;
            Some((Place::Cec(table.parse().ok()?), own.value.number()? > 0.0))
        };
        self.all.machine_data.iter().filter_map(own).collect()
    }
}
