//! ENC_COMP, CEC, their switches and MD32450 of a Siemens read-out.

use super::data::{
    BACKLASH, CEC_ON, Datum, LEC_ON, REFERENCE, REFERENCE_MODE, TABLE_ON, UNIT, WEIGHT,
};
use super::surroundings::cec_limits;
use crate::control::claims::Assumption;
use crate::control::controller::ControlUnit;
use crate::control::table::Tables;
use crate::control::table::siemens::{
    CecTable, LecTable, OpenEnd, SiemensGrid, SiemensTables, closed,
};
use crate::judge::active::{Found, Held, NamedBacklash, ReadOutReader};
use crate::judge::findings::InControl;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::UM_PER_MM;
use crate::read::siemens::{
    MachineDatum, MachineValue, ReadOut, SiemensContents, has_active_data, is_switch, merge,
    read_out,
};
use crate::text::problem::Problems;
use std::collections::BTreeMap;

/// Reads the files of a control.
pub(super) fn read(reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
    let texts = reading.texts;
    // Where part programs are all that there is, they count.
    let reads_programs = !texts.iter().any(|(name, text)| has_active_data(name, text));
    let contents = contents(texts, reads_programs, reading)?;
    let (data, contrary) = agreed(&contents);
    let mut all = merge(contents)?;
    let mut told = std::mem::take(&mut all.read_out);
    reading.findings.extend(all.notes.iter().cloned());
    if !all.unwritten.is_empty() {
        let parameters = all.unwritten.clone();
        reading.tell(InControl::NotWritten { parameters });
    }
    if !all.idle.is_empty() {
        let tables = all.idle.clone();
        reading.tell(InControl::Idle { tables });
    }
    told.without_grid.extend(all.idle.iter().cloned());
    let held = Held {
        tables: Tables::Siemens(all.tables.clone()),
        data,
        without_grid: std::mem::take(&mut told.without_grid),
    };
    let mut sorted = Sorted { reading, all, held };
    told.twice.extend(contrary.iter().map(MachineDatum::variable));
    told.twice.iter().for_each(|name| sorted.several_values(name));
    sorted.tell_programs(&told, reads_programs);
    let (lec, cec) = (sorted.lec(), sorted.cec());
    sorted.tell_what_was_not_read_out();
    let unit = sorted.value(UNIT, &[]).map(ControlUnit::of_metric);
    sorted.tell_references(unit);
    Ok(Found {
        tables: Tables::Siemens(SiemensTables { lec, cec }),
        backlash: PerAxis::from_fn(|axis| sorted.backlash(axis)),
        held: sorted.held,
        unit,
    })
}

/// What the texts of a read-out hold, one by one.
fn contents(
    texts: &[(&str, &str)],
    reads_programs: bool,
    reading: &mut ReadOutReader<'_>,
) -> Result<Vec<SiemensContents>, Problems> {
    let mut problems = Problems::none();
    let mut all = Vec::new();
    let mut passed_over = BTreeMap::new();
    for (name, text) in texts {
        let Some(contents) = problems.take(read_out(name, text, reads_programs)) else {
            continue;
        };
        tell_units(reading, name, &contents.read_out.units);
        let told = &contents.read_out;
        passed_over.insert(*name, (told.passed_over, told.without_grid.len()));
        all.push(contents);
    }
    for (file, (data, tables)) in passed_over {
        tell_passed_over(reading, file, data, "other machine data");
        tell_passed_over(reading, file, tables, "reserved tables without a grid");
    }
    problems.or_ok(all)
}

fn tell_passed_over(reading: &mut ReadOutReader<'_>, file: &str, count: usize, what: &'static str) {
    let file = file.to_string();
    if count > 0 {
        reading.tell(InControl::PassedOver { file, count, what });
    }
}

/// `METRIC` and `INCH` tell the unit of what follows, whichever the control counts in.
fn tell_units(reading: &mut ReadOutReader<'_>, name: &str, units: &[ControlUnit]) {
    let own = reading.job.compensation.control_unit;
    for unit in units.iter().filter(|unit| **unit != own) {
        reading.tell(InControl::FileUnit {
            file: name.to_string(),
            unit: unit.word(),
            word: match unit {
                ControlUnit::Millimetre => "METRIC",
                ControlUnit::Inch => "INCH",
            },
            own: own.word(),
        });
    }
}

/// Machine data that every part of a read-out holds with the same value, and those that it holds
/// with several.
fn agreed(parts: &[SiemensContents]) -> (Vec<MachineDatum>, Vec<MachineDatum>) {
    let (mut agreed, mut contrary): (Vec<MachineDatum>, Vec<MachineDatum>) = Default::default();
    let same = |a: &MachineDatum, b: &MachineDatum| a.name == b.name && a.indices == b.indices;
    for datum in parts.iter().flat_map(|part| &part.machine_data) {
        match agreed.iter().find(|known| same(known, datum)) {
            None => agreed.push(datum.clone()),
            Some(known) if known.value == datum.value => {}
            Some(_) => contrary.push(datum.clone()),
        }
    }
    agreed.retain(|datum| !contrary.iter().any(|other| same(other, datum)));
    (agreed, contrary)
}

pub(super) struct Sorted<'a, 'b> {
    pub(super) reading: &'a mut ReadOutReader<'b>,
    pub(super) all: SiemensContents,
    pub(super) held: Held,
}

impl Sorted<'_, '_> {
    /// Part programs: no state beside active data, and where nothing else was read out, what they
    /// would make of it.
    fn tell_programs(&mut self, told: &ReadOut, are_read: bool) {
        const MOST_NAMES: usize = 6;
        let names = match told.programs.len() {
            0 => return,
            1..=MOST_NAMES => told.programs.join(", "),
            many => many.to_string(),
        };
        let has_tables = !self.all.tables.lec.is_empty() || !self.all.tables.cec.is_empty();
        let judges = self.reading.judges();
        self.reading.tell(match (judges, are_read) {
            (true, true) => InControl::ProgramsOnly { names },
            (false, true) => InControl::ProgramsCount { names },
            (false, false) if told.programs_write_tables && !has_tables => {
                InControl::TablesInPrograms { names }
            }
            (_, false) => InControl::ProgramsPassedOver { names },
        });
    }

    /// A variable that the files hold with several values. Switches are made for being changed, and
    /// how much memory is reserved does nothing.
    fn several_values(&mut self, name: &str) {
        if name.contains("_MAX_POINTS") {
            return;
        }
        let bare = name.trim_start_matches('$').split('[').next();
        let is_switch = bare.is_some_and(is_switch);
        let concerns_the_job = self.concerns_the_job(name);
        let name = name.to_string();
        let judges = self.reading.judges();
        self.reading.tell(match (concerns_the_job, is_switch) {
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
            let own = |table: &&CecTable| indices[0].parse() == Ok(table.number);
            let table = self.all.tables.cec.iter().find(own);
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
        let settings = self.reading.job.compensation.axes[axis].as_ref();
        settings?.measuring_system.map(|system| system - 1)
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
            let encoder = self.encoder(own).to_string();
            for axis in names {
                let mode = self.value(REFERENCE_MODE, &[encoder.as_str(), axis.as_str()]);
                let counts = mode.is_none_or(|mode| (mode - ZERO_MARK).abs() <= 0.0);
                let position = self.value(REFERENCE, &["0", axis.as_str()]).filter(|_| counts);
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

    pub(super) fn value(&self, (_, name): Datum, indices: &[&str]) -> Option<f64> {
        let same = |datum: &&MachineDatum| {
            let own = datum.indices.iter().map(String::as_str);
            datum.name == name && own.eq(indices.iter().copied())
        };
        match self.all.machine_data.iter().find(same)?.value {
            MachineValue::Number(number) => Some(number),
            MachineValue::Text(_) => None,
        }
    }

    /// Whether a datum was read out and stands above 0.
    pub(super) fn is_above_zero(&self, datum: Datum, indices: &[&str]) -> Option<bool> {
        self.value(datum, indices).map(|value| value > 0.0)
    }

    /// Whether a switch stands at 1; what no file holds is taken as on, and said.
    fn is_on(&mut self, datum: Datum, indices: &[&str]) -> bool {
        let Some(is_on) = self.is_above_zero(datum, indices) else {
            let (number, name) = datum;
            let what = format!("{number} ${name}[{}]", indices.join(","));
            if !self.reading.assumptions.iter().any(|a| a.fact == what) {
                self.reading.assumptions.push(Assumption::of_job(
                    what,
                    "1 while measuring",
                    "no file holds it; a table that was off would be added to the new one",
                ));
            }
            return true;
        };
        is_on
    }

    fn lec(&mut self) -> Vec<LecTable> {
        let mut own = Vec::new();
        for mut table in self.all.tables.lec.clone() {
            let encoder = table.encoder.to_string();
            let name = format!("$AA_ENC_COMP[{encoder},{}]", table.axis);
            match self.reading.axis(&table.axis) {
                None => self.reading.tell(InControl::OfOthers { what: name, axes: "an axis" }),
                Some(axis) if table.encoder != self.encoder(axis) => {
                    self.other_system(name, axis, &table);
                }
                Some(_) if self.is_on(LEC_ON, &[&encoder, &table.axis]) => {
                    self.close(&name, &mut table.grid, &mut table.values);
                    own.push(table);
                }
                Some(_) => self.reading.tell(InControl::SwitchedOff { table: name, by: LEC_ON.0 }),
            }
        }
        own
    }

    /// A table of the measuring system that the job does not name.
    fn other_system(&mut self, name: String, axis: Axis, table: &LecTable) {
        let switch = self.is_above_zero(LEC_ON, &[&table.encoder.to_string(), &table.axis]);
        let is_off = switch == Some(false);
        let twin = |other: &LecTable| other.axis == table.axis && other.encoder != table.encoder;
        let has_twin = self.all.tables.lec.iter().any(twin);
        let is_stated = self.stated_encoder(axis).is_some();
        let (table, system) = (name, table.encoder + 1);
        let judges = self.reading.judges();
        self.reading.tell(if is_off || (has_twin && (is_stated || !judges)) {
            let off = if is_off { " and switched off" } else { "" };
            InControl::OtherSystem { table, off }
        } else if has_twin {
            InControl::EitherSystem { table, system }
        } else {
            InControl::WrongSystem { table, system }
        });
    }

    fn cec(&mut self) -> Vec<CecTable> {
        let mut own = Vec::new();
        for mut table in self.all.tables.cec.clone() {
            let name = format!("$AN_CEC[{}]", table.number);
            if self.is_of_others(&table) {
                self.reading.others.cec_tables.push(table.number);
            } else if self.acts(&table) {
                self.weigh(&table);
                self.close(&name, &mut table.grid, &mut table.values);
                own.push(table);
            } else {
                self.reading.others.cec_tables.push(table.number);
                self.reading.tell(InControl::SwitchedOff { table: name, by: "SD41300 or MD32710" });
            }
        }
        if !self.reading.judges() {
            // `verify` compares with what the job asks for.
            let unit = self.reading.job.compensation.control_unit;
            let tables = SiemensTables { cec: own.clone(), ..SiemensTables::default() };
            for finding in cec_limits(&self.held, &tables, unit) {
                self.reading.tell(finding);
            }
        }
        own
    }

    /// Ends a table where it ends between two points; nothing is said where both readings are the same.
    fn close(&mut self, name: &str, grid: &mut SiemensGrid, values: &mut Vec<Option<f64>>) {
        let Some((closed_grid, closed_values, end)) = closed(*grid, values) else {
            return;
        };
        (*grid, *values) = (closed_grid, closed_values);
        let unit = self.reading.job.compensation.control_unit;
        let OpenEnd { point, from, differs_by } = end;
        let by = match differs_by {
            Some(by) if by <= 0.0 => return,
            Some(by) => format!("by up to {:.1} µm", by * unit.in_mm() * UM_PER_MM),
            None => "by a value that no file holds".to_string(),
        };
        let word = unit.word();
        let place = format!("{name} behind {from} {word}, where MAX lies between two points");
        let other = format!("the control goes on towards point {}", point + 1);
        let assumption = Assumption::of_job(
            &place,
            format!("the value of point {point} held"),
            format!("the old correction there differs {by} if {other}"),
        );
        let told = InControl::OpenEnd { place, point, other, by };
        self.reading.take(assumption, told);
    }

    /// Whether SD41300 of a table and MD32710 of its output axis stand at 1.
    fn acts(&mut self, table: &CecTable) -> bool {
        self.is_on(TABLE_ON, &[&table.number.to_string()])
            && self.is_on(CEC_ON, &[&table.output_axis])
    }

    /// A weight other than 1, which is not emulated.
    fn weigh(&mut self, table: &CecTable) {
        let number = table.number;
        let weight = self.value(WEIGHT, &[&number.to_string()]);
        if let Some(weight) = weight.filter(|weight| (weight - 1.0).abs() > 0.0) {
            self.reading.tell(InControl::Weight { number, weight });
        }
    }

    /// Whether an axis of a table is none of the job; where it acts on one of the job all the
    /// same, that is said. Whether a factor still acts by itself is a fact that no available manual states.
    fn is_of_others(&mut self, table: &CecTable) -> bool {
        let (moving, output) = (&table.input_axis, &table.output_axis);
        let has_output = self.reading.has(output);
        if has_output && self.reading.has(moving) {
            return false;
        }
        let what = format!("$AN_CEC[{}] ({moving} → {output})", table.number);
        let is_zero = table.values.iter().flatten().all(|value| value.abs() <= 0.0);
        let judges = self.reading.judges();
        let told = if let Some(factor) = self.own_factor(table)
            && self.acts(table)
        {
            InControl::Factor { table: what, factor }
        } else if judges && has_output && !is_zero && self.acts(table) {
            let moving = moving.clone();
            InControl::Follows { what, moving }
        } else {
            let axes = "axes";
            InControl::OfOthers { what, axes }
        };
        self.reading.tell(told);
        true
    }

    /// The table of the job that another table multiplies by.
    fn own_factor(&self, table: &CecTable) -> Option<u32> {
        let number = table.multiply_by.checked_sub(1)?;
        let mut all = self.all.tables.cec.iter();
        let factor = all.find(|other| other.number == number)?;
        let has = |axis: &str| self.reading.has(axis);
        (has(&factor.input_axis) && has(&factor.output_axis)).then_some(number)
    }

    /// MD32450 of the active measuring system, µm.
    fn backlash(&self, axis: Axis) -> NamedBacklash {
        let encoder = self.encoder(axis).to_string();
        let in_um = self.reading.job.compensation.control_unit.in_mm() * UM_PER_MM;
        let of_name = |name: &String| {
            let held = self.value(BACKLASH, &[&encoder, &name.to_uppercase()]);
            (name.clone(), held.map(|value| value * in_um))
        };
        self.reading.names[axis].iter().map(of_name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::siemens::read;

    #[test]
    fn a_switch_with_two_values_is_not_held() {
        let on = "$MA_CEC_ENABLE[AX1]=1\n$MA_ENC_COMP_ENABLE[0,AX1]=TRUE\nM17\n";
        let off = "$MA_CEC_ENABLE[AX1]=0\n$MA_ENC_COMP_ENABLE[0,AX1]=1\nM17\n";
        let parts = [on, off, on].map(|text| read("part", text).unwrap());
        let (data, contrary) = agreed(&parts);
        assert_eq!(contrary[0].name, "MA_CEC_ENABLE");
        let held = Held { data, ..Held::plain(Tables::Siemens(SiemensTables::default())) };
        let axis = |text: &str| text.split(',').map(str::to_string).collect::<Vec<_>>();
        assert_eq!(held.datum("MA_CEC_ENABLE", &axis("AX1")), None);
        assert!(held.datum("MA_ENC_COMP_ENABLE", &axis("0,AX1")).is_some());
        assert!(!held.is_off("MA_CEC_ENABLE", &axis("AX1")));
    }
}
