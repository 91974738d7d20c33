//! ENC_COMP, CEC, their switches and MD32450 of a Siemens read-out.

use super::machine_data::cec_limits;
use crate::control::claims::Assumption;
use crate::control::controller::ControlUnit;
use crate::control::table::Tables;
use crate::control::table::siemens::{MachineDatum, OpenEnd, Place, SiemensTable, SiemensTables};
use crate::judge::active::ReadOutReader;
use crate::judge::findings::{InControl, listed};
use crate::judge::siemens::machine_data::{
    BACKLASH, CEC_ON, CEC_POINTS, Datum, LEC_ON, REFERENCE, REFERENCE_MODE, TABLE_ON, UNIT, WEIGHT,
    numbered, of_place, switches, variable,
};
use crate::quantity::{Axis, UM_PER_MM};
use crate::read::siemens::{SiemensContents, has_active_data, is_switch, merge, read_out};
use crate::text::Problems;

/// Reads the files of a control.
pub(super) fn read(reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
    let texts = reading.texts;
    // Where part programs are all that there is, they count.
    let reads_programs = !texts.iter().any(|(name, text)| has_active_data(name, text));
    let all = merge(contents(texts, reads_programs, reading)?)?;
    reading.active.findings.extend(all.notes.iter().cloned());
    if !all.unwritten.is_empty() {
        reading.tell(InControl::NotWritten { parameters: all.unwritten.clone() });
    }
    if !all.idle.is_empty() {
        reading.tell(InControl::Idle { tables: all.idle.clone() });
    }
    let mut sorted = ReadOutContents { reading, all };
    let twice = std::mem::take(&mut sorted.all.twice);
    twice.iter().for_each(|variable| sorted.several_values(variable.clone()));
    sorted.tell_programs(reads_programs);
    let tables = sorted.tables();
    sorted.tell_what_was_not_read_out();
    let unit = sorted.value(UNIT, "").map(ControlUnit::of_metric);
    sorted.tell_references(unit);
    let backlash = sorted.reading.backlash(|axis, name| sorted.backlash(axis, name));
    sorted.reading.active.held_backlash = backlash;
    let mut held = sorted.all.tables;
    held.data.retain(|own| !(is_switch(&own.variable) && twice.contains(&own.variable)));
    sorted.reading.found(Tables::Siemens(tables), Tables::Siemens(held));
    sorted.reading.check_unit(unit);
    Ok(())
}

/// What the texts of a read-out hold, one by one.
fn contents(
    texts: &[(&str, &str)],
    reads_programs: bool,
    reading: &mut ReadOutReader<'_>,
) -> Result<Vec<SiemensContents>, Problems> {
    let all = Problems::all(texts.iter().map(|(name, text)| read_out(name, text, reads_programs)))?;
    let mut passed_over = Vec::new();
    for ((name, _), told) in texts.iter().zip(&all) {
        tell_units(reading, name, &told.units);
        passed_over.push((*name, told.passed_over, "other machine data"));
        let reserved = told.tables.reserved.len() - told.idle.len();
        passed_over.push((*name, reserved, "reserved tables without a grid"));
    }
    passed_over.sort_by_key(|(file, ..)| *file);
    for (file, count, what) in passed_over.into_iter().filter(|(_, count, _)| *count > 0) {
        reading.tell(InControl::PassedOver { file: file.to_string(), count, what });
    }
    Ok(all)
}

/// `METRIC` and `INCH` tell the unit of what follows, whichever the control counts in.
fn tell_units(reading: &mut ReadOutReader<'_>, name: &str, units: &[ControlUnit]) {
    let own = reading.job.compensation.control_unit;
    for unit in units.iter().filter(|unit| **unit != own) {
        let word = match unit {
            ControlUnit::Millimetre => "METRIC",
            ControlUnit::Inch => "INCH",
        };
        let (file, unit, own) = (name.to_string(), unit.word(), own.word());
        reading.tell(InControl::FileUnit { file, unit, word, own });
    }
}

pub(super) struct ReadOutContents<'a, 'b> {
    pub(super) reading: &'a mut ReadOutReader<'b>,
    pub(super) all: SiemensContents,
}

impl ReadOutContents<'_, '_> {
    /// Part programs: no state beside active data, and where nothing else was read out, what they
    /// would make of it.
    fn tell_programs(&mut self, are_read: bool) {
        const MOST_NAMES: usize = 6;
        let names = match self.all.programs.len() {
            0 => return,
            1..=MOST_NAMES => self.all.programs.join(", "),
            many => many.to_string(),
        };
        let has_tables = !self.all.tables.tables.is_empty();
        self.reading.tell(match (self.reading.judges(), are_read) {
            (true, true) => InControl::ProgramsOnly { names },
            (false, true) => InControl::ProgramsCount { names },
            (false, false) if self.all.programs_write_tables && !has_tables => {
                InControl::TablesInPrograms { names }
            }
            (_, false) => InControl::ProgramsPassedOver { names },
        });
    }

    /// A variable that the files hold with several values. Switches are made for being changed, and
    /// how much memory is reserved does nothing.
    fn several_values(&mut self, name: String) {
        if name.contains("_MAX_POINTS") {
            return;
        }
        let (concerns_the_job, judges) = (self.concerns_the_job(&name), self.reading.judges());
        self.reading.tell(match (concerns_the_job, is_switch(&name)) {
            (false, _) => InControl::SeveralOfOthers { name },
            (true, true) if !judges => InControl::LastCounts { name },
            (true, _) => InControl::SeveralValues { name },
        });
    }

    /// Whether a variable, as files write it, is one of an axis or table of the job.
    fn concerns_the_job(&self, variable: &str) -> bool {
        let Some((name, indices)) = variable.trim_end_matches(']').split_once('[') else {
            return true; // of the whole control
        };
        let indices: Vec<&str> = indices.split(',').collect();
        if name.starts_with("$AN_CEC") || name.starts_with("$SN_CEC") {
            let table = indices[0].parse().ok().and_then(|at| self.all.tables.at(&Place::Cec(at)));
            return table.is_none_or(|table| {
                self.reading.has(&table.input_axis) || self.reading.has(&table.output_axis)
            });
        }
        let Some(axis) = indices.last().and_then(|axis| self.reading.axis(axis)) else {
            return false;
        };
        indices.len() == 1
            || name == "$MA_REFP_SET_POS"
            || indices[0].parse() == Ok(self.encoder(axis))
    }

    /// The measuring system that the job states for an axis, from 0.
    pub(super) fn stated_encoder(&self, axis: Axis) -> Option<u32> {
        self.reading.job.compensation.axes[axis].as_ref()?.measuring_system.map(|system| system - 1)
    }

    fn encoder(&self, axis: Axis) -> u32 {
        self.stated_encoder(axis).unwrap_or(0)
    }

    /// MD34100, the position at the zero mark of an incremental measuring system. With an absolute or
    /// a distance-coded one (MD34200 other than 1) it says nothing (both from memory). The index of
    /// MD34100 is a reference cam, that of MD34200 the measuring system. Old tables count from wherever they do. Its
    /// unit is that of the control that was read out (MD10240), which need not be the job's.
    fn tell_references(&mut self, unit: Option<ControlUnit>) {
        const SAME_MM: f64 = 1e-3;
        const ZERO_MARK: f64 = 1.0;
        let job = self.reading.job;
        let unit = unit.unwrap_or(job.compensation.control_unit);
        if !self.reading.judges() {
            return;
        }
        for (own, names) in self.reading.names.clone().iter() {
            let encoder = self.encoder(own);
            for axis in names {
                let mode = self.value(REFERENCE_MODE, &format!("{encoder},{axis}"));
                let counts = mode.is_none_or(|mode| (mode - ZERO_MARK).abs() <= 0.0);
                let position = self.value(REFERENCE, &format!("0,{axis}")).filter(|_| counts);
                let machine = job.machine.axes[own].as_ref();
                let (Some(position), Some(machine)) = (position, machine) else { continue };
                let own_mm = machine.reference.mm();
                if (position * unit.in_mm() - own_mm).abs() > SAME_MM {
                    let (axis, unit) = (axis.clone(), unit.word());
                    self.reading.tell(InControl::ReferencePoint { axis, position, unit, own_mm });
                }
            }
        }
    }

    pub(super) fn value(&self, datum: Datum, index: &str) -> Option<f64> {
        self.all.tables.number(datum, index)
    }

    /// Whether a datum was read out and stands above 0.
    pub(super) fn is_above_zero(&self, datum: Datum, index: &str) -> Option<bool> {
        self.value(datum, index).map(|value| value > 0.0)
    }

    /// Whether a switch stands at 1; what no file holds is taken as on, and said.
    fn is_on(&mut self, datum: Datum, index: &str) -> bool {
        self.is_above_zero(datum, index).unwrap_or_else(|| {
            let what = numbered(datum, index);
            if !self.reading.active.assumptions.iter().any(|a| a.fact == what) {
                let wrong = "no file holds it; a table that was off would be added to the new one";
                let on = Assumption::of_job(what, "1 while measuring", wrong);
                self.reading.active.assumptions.push(on);
            }
            true
        })
    }

    /// The tables that act on axes of the job.
    fn tables(&mut self) -> SiemensTables {
        let mut own = Vec::new();
        for mut table in self.all.tables.tables.clone() {
            if let Some(told) = self.set_aside(&table) {
                self.reading.active.others.cec_tables.extend(table.place.cec());
                self.reading.tell(told);
            } else {
                self.weigh(&table);
                self.close(&mut table);
                own.push(table);
            }
        }
        let own = SiemensTables::of(own);
        if !self.reading.judges() {
            // `verify` compares with what the job asks for.
            let unit = self.reading.job.compensation.control_unit;
            for finding in cec_limits(&self.all.tables, &own, unit) {
                self.reading.tell(finding);
            }
        }
        own
    }

    /// A table of the measuring system that the job does not name.
    fn other_system(&self, place: &Place, encoder: u32, axis: Axis) -> InControl {
        let is_off = self.is_above_zero(LEC_ON, &place.index()) == Some(false);
        let has_twin = self.all.tables.lec().map(|table| &table.place).any(|other| {
            other != place && other.lec().map(|of| of.0) == place.lec().map(|of| of.0)
        });
        let (is_stated, judges) = (self.stated_encoder(axis).is_some(), self.reading.judges());
        let (table, system) = (format!("${place}"), encoder + 1);
        if is_off || (has_twin && (is_stated || !judges)) {
            let off = if is_off { " and switched off" } else { "" };
            InControl::OtherSystem { table, off }
        } else if has_twin {
            InControl::EitherSystem { table, system }
        } else {
            InControl::WrongSystem { table, system }
        }
    }

    /// Ends a table where it ends between two points; nothing is said where both readings are the same.
    fn close(&mut self, table: &mut SiemensTable) {
        let Some(OpenEnd { point, from, differs_by }) = table.close() else {
            return;
        };
        let unit = self.reading.job.compensation.control_unit;
        let by = match differs_by {
            Some(by) if by <= 0.0 => return,
            Some(by) => format!("by up to {:.1} µm", by * unit.in_mm() * UM_PER_MM),
            None => "by a value that no file holds".to_string(),
        };
        let word = unit.word();
        let place =
            format!("${} behind {from} {word}, where MAX lies between two points", table.place);
        let other = format!("the control goes on towards point {}", point + 1);
        let held = format!("the value of point {point} held");
        let wrong = format!("the old correction there differs {by} if {other}");
        let assumption = Assumption::of_job(&place, held, wrong);
        self.reading.take(assumption, InControl::OpenEnd { place, point, other, by });
    }

    /// Whether all switches of a table stand at 1.
    fn acts(&mut self, table: &SiemensTable) -> bool {
        switches(table).iter().all(|(datum, index)| self.is_on(*datum, index))
    }

    /// A weight other than 1, which is not emulated.
    fn weigh(&mut self, table: &SiemensTable) {
        let weight = self.value(WEIGHT, &table.place.index());
        let weight = weight.filter(|weight| (weight - 1.0).abs() > 0.0);
        if let (Some(number), Some(weight)) = (table.place.cec(), weight) {
            self.reading.tell(InControl::Weight { number, weight });
        }
    }

    /// Why a table is not taken: an axis of it is none of the job, it is for another measuring system, or off.
    fn set_aside(&mut self, table: &SiemensTable) -> Option<InControl> {
        let name = format!("${}", table.place);
        let (of_others, by) = match table.place.lec() {
            Some((axis, encoder)) => match self.reading.axis(axis) {
                Some(own) if encoder == self.encoder(own) => (None, LEC_ON.0),
                Some(own) => return Some(self.other_system(&table.place, encoder, own)),
                None => return Some(InControl::OfOthers { what: name, axes: "an axis" }),
            },
            None => (self.cec_of_others(table), "SD41300 or MD32710"),
        };
        let is_off = of_others.is_none() && !self.acts(table);
        of_others.or_else(|| is_off.then_some(InControl::SwitchedOff { table: name, by }))
    }

    /// A table of which an axis is none of the job; where it acts on one of the job all the same, that is said.
    /// Whether a factor still acts by itself is a fact that no available manual states.
    fn cec_of_others(&mut self, table: &SiemensTable) -> Option<InControl> {
        let (moving, output) = (&table.input_axis, &table.output_axis);
        let has_output = self.reading.has(output);
        if has_output && self.reading.has(moving) {
            return None;
        }
        let what = format!("${} ({moving} → {output})", table.place);
        let is_zero = table.values.iter().flatten().all(|value| value.abs() <= 0.0);
        Some(
            if let Some(factor) = self.own_factor(table)
                && self.acts(table)
            {
                InControl::Factor { table: what, factor }
            } else if self.reading.judges() && has_output && !is_zero && self.acts(table) {
                InControl::Follows { what, moving: moving.clone() }
            } else {
                InControl::OfOthers { what, axes: "axes" }
            },
        )
    }

    /// The table of the job that another table multiplies by.
    fn own_factor(&self, table: &SiemensTable) -> Option<u32> {
        let number = table.multiply_by.checked_sub(1)?;
        let factor = self.all.tables.at(&Place::Cec(number))?;
        let has = |axis: &str| self.reading.has(axis);
        (has(&factor.input_axis) && has(&factor.output_axis)).then_some(number)
    }

    /// MD32450 of the active measuring system, µm.
    fn backlash(&self, axis: Axis, name: &str) -> Option<f64> {
        let in_um = self.reading.job.compensation.control_unit.in_mm() * UM_PER_MM;
        let index = format!("{},{}", self.encoder(axis), name.to_uppercase());
        Some(self.value(BACKLASH, &index)? * in_um)
    }

    // Tables that are switched on, or of which nothing is said, and that no file of a read-out holds.

    /// Tables that are switched on and in no file of the read-out, so that what they do is not known.
    pub(super) fn tell_what_was_not_read_out(&mut self) {
        let absent = [self.lec_not_read_out(), self.cec_not_read_out()];
        absent.into_iter().flatten().for_each(|told| self.reading.tell(told));
        for what in self.untold() {
            let wrong = "no file holds such a table or its switches; an old table would be lost with the new ones";
            let none = Assumption::of_job(&what, "none while measuring", wrong);
            self.reading.take(none, InControl::Untold { what });
        }
    }

    /// Names of the job's axes as the control writes them.
    fn own_names(&self) -> Vec<String> {
        self.reading.named().map(|(_, name)| name.to_uppercase()).collect()
    }

    fn is_reserved(&self, place: &Place) -> bool {
        self.all.tables.reserved.contains(&place.to_string())
    }

    /// The tables that an axis of the control may have in ENC_COMP, or that for the stated measuring system.
    fn lec_places(name: &str, stated: Option<u32>) -> Vec<Place> {
        let encoders = (0..=1).filter(|own| stated.is_none_or(|stated| stated == *own));
        encoders.map(|encoder| Place::Lec { axis: name.to_uppercase(), encoder }).collect()
    }

    /// Of which tables the files say nothing, neither values nor switches.
    fn untold(&self) -> Vec<String> {
        let tells_of = |place: &Place| {
            self.value(LEC_ON, &place.index()).is_some()
                || self.is_reserved(place)
                || self.all.tables.at(place).is_some()
        };
        let mut lec = self.own_names();
        lec.retain(|name| !Self::lec_places(name, None).iter().any(tells_of));
        let is_of_cec = |own: &MachineDatum| {
            let mut data = [CEC_ON, TABLE_ON, CEC_POINTS].into_iter();
            data.any(|datum| own.variable.starts_with(&variable(datum, "")))
        };
        let mut reserved = self.all.tables.reserved.iter();
        let tells_of_cec = self.all.tables.cec().next().is_some()
            || reserved.any(|table| table.starts_with("AN_CEC"))
            || self.all.tables.data.iter().any(is_of_cec);
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
        for (axis, name) in self.reading.named() {
            let places = Self::lec_places(name, self.stated_encoder(axis));
            if !places.iter().any(|place| self.all.tables.at(place).is_some()) {
                let missing = places.iter().filter(|place| self.is_missing(place));
                switches.extend(missing.map(|place| format!("[{}]", place.index())));
            }
        }
        (!switches.is_empty()).then_some(InControl::LecNotRead { switches })
    }

    /// SD41300 = 1 without the CEC table, or MD32710 = 1 of an axis of the job where nothing else
    /// tells of CEC.
    fn cec_not_read_out(&self) -> Option<InControl> {
        let is_on = |name: &String| self.is_above_zero(CEC_ON, name);
        let known = self.own_names().into_iter().filter(|name| is_on(name).is_some());
        let (axes, off): (Vec<_>, Vec<_>) = known.partition(|name| is_on(name) == Some(true));
        if axes.is_empty() && !off.is_empty() {
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
        self.all.tables.data.iter().filter_map(own).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::siemens::read;

    #[test]
    fn a_switch_of_two_files_has_two_values() {
        let on = "$MA_CEC_ENABLE[AX1]=1\n$MA_ENC_COMP_ENABLE[0,AX1]=TRUE\nM17\n";
        let off = "$MA_CEC_ENABLE[AX1]=0\n$MA_ENC_COMP_ENABLE[0,AX1]=1\nM17\n";
        let parts = [on, off, on].map(|text| read("part", text).unwrap());
        let all = merge(parts.to_vec()).unwrap();
        assert!(all.twice.iter().eq(["$MA_CEC_ENABLE[AX1]"]));
        assert_eq!(all.tables.data.len(), 2);
    }
}
