//! ENC_COMP, CEC, their switches and MD32450 of a Siemens read-out.

use super::held::agreed;
use super::{Held, Others, axis_of};
use crate::control::claims::Assumption;
use crate::control::controller::LengthUnit;
use crate::control::table::Tables;
use crate::control::table::siemens::{CecTable, LecTable, OpenEnd, SiemensTables, closed};
use crate::inputs::job::Job;
use crate::judge::active::found::{
    Contrary, Found, NamedBacklash, ReadOutFor, beside_words, listed,
};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::UM_PER_MM;
use crate::read::control_data::{self, Programs, Text, has_active_data};
use crate::read::siemens::{
    MachineDatum, MachineValue, SiemensContents, is_switch, merge, read_out,
};
use crate::text::problem::Problems;

type Names = PerAxis<Vec<String>>;

/// The last digit of a value in a table; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

/// Reads the files of a control.
pub(super) fn read(
    job: &Job,
    names: &Names,
    texts: &[Text<'_>],
    purpose: ReadOutFor,
) -> Result<Found, Problems> {
    let are_active = texts.iter().map(|(name, text)| has_active_data(name, text));
    let are_active: Vec<bool> = are_active.collect();
    let reads_programs = !are_active.contains(&true);
    let mut problems = Problems::none();
    let mut cuts = Cuts::default();
    for ((name, text), is_active) in texts.iter().zip(are_active) {
        let cut = control_data::siemens(name, text, reads_programs);
        let is_passed_over = !reads_programs && !is_active && !cut.programs.names.is_empty();
        let parts = [&cut.tables, &cut.data];
        for part in parts.into_iter().filter(|_| !is_passed_over) {
            cuts.contents.extend(problems.take(read_out(name, part)));
        }
        cuts.add(job, name, cut);
    }
    let Cuts {
        contents,
        programs,
        mut without_grid,
        mut twice,
        other_units,
        passed_over,
    } = cuts;
    let contents = problems.or_ok(contents)?;
    let (data, contrary) = agreed(&contents);
    let all = merge(contents)?;
    let mut notes: Vec<String> = passed_over.iter().flat_map(PassedOver::notes).collect();
    notes.extend(all.notes.iter().cloned());
    if !all.unwritten.is_empty() {
        let parameters = listed(&all.unwritten);
        notes.push(format!("no file holds {parameters}: 0 is assumed"));
    }
    if !all.idle.is_empty() {
        let tables = listed(&all.idle);
        notes.push(format!(
            "{tables}: zeros without a usable grid, passed over"
        ));
    }
    without_grid.extend(all.idle.iter().cloned());
    let held = Held {
        tables: Tables::Siemens(all.tables.clone()),
        data,
        without_grid,
    };
    let mut sorted = Sorted {
        job,
        names,
        all: &all,
        purpose,
        notes,
        assumptions: Vec::new(),
        others: Others::default(),
        contrary: other_units,
        beside: Vec::new(),
    };
    twice.extend(contrary.iter().map(MachineDatum::variable));
    twice.iter().for_each(|name| sorted.several_values(name));
    sorted.tell_programs(&programs, reads_programs);
    let lec = sorted.lec();
    let cec = sorted.cec();
    sorted.tell_what_was_not_read_out(&held.without_grid);
    let backlash = PerAxis::from_fn(|axis| sorted.backlash(axis));
    let metric = sorted.value("MN_SCALING_SYSTEM_IS_METRIC", &[]);
    Ok(Found {
        tables: Tables::Siemens(SiemensTables { lec, cec }),
        held,
        backlash,
        others: sorted.others,
        assumptions: sorted.assumptions,
        notes: sorted.notes,
        unit: metric.map(LengthUnit::of_metric),
        contrary: sorted.contrary,
        beside: sorted.beside,
    })
}

/// What the texts of a read-out hold, as they are read one after the other.
#[derive(Default)]
struct Cuts {
    contents: Vec<SiemensContents>,
    programs: Programs,
    without_grid: Vec<String>,
    twice: Vec<String>,
    other_units: Vec<Contrary>,
    passed_over: Vec<PassedOver>,
}

impl Cuts {
    fn add(&mut self, job: &Job, name: &str, cut: control_data::SiemensText) {
        let own = job.compensation.control_unit;
        let others = cut.units.iter().filter(|unit| **unit != own);
        let others = others.map(|unit| in_other_unit(name, *unit, own));
        self.other_units.extend(others);
        self.count(control_data::file_of(name), &cut);
        self.programs.names.extend(cut.programs.names);
        self.programs.write_tables |= cut.programs.write_tables;
        self.twice.extend(cut.twice);
        self.without_grid.extend(cut.without_grid);
    }

    /// Adds what was passed over to that of the same file; an archive has many texts.
    fn count(&mut self, file: &str, cut: &control_data::SiemensText) {
        if self.passed_over.last().is_none_or(|last| last.file != file) {
            self.passed_over.push(PassedOver {
                file: file.to_string(),
                ..PassedOver::default()
            });
        }
        if let Some(last) = self.passed_over.last_mut() {
            last.data += cut.passed_over;
            last.tables += cut.without_grid.len();
        }
    }
}

/// How much of a file was passed over.
#[derive(Default)]
struct PassedOver {
    file: String,
    data: usize,
    /// Reserved tables without a grid.
    tables: usize,
}

impl PassedOver {
    fn notes(&self) -> Vec<String> {
        let PassedOver { file, data, tables } = self;
        let kinds = [
            (*data, "other machine data"),
            (*tables, "reserved tables without a grid"),
        ];
        let some = kinds.into_iter().filter(|(count, _)| *count > 0);
        some.map(|(count, what)| format!("`{file}`: {count} {what} were passed over"))
            .collect()
    }
}

/// `METRIC` and `INCH` tell the unit of what follows, whichever the control counts in.
fn in_other_unit(name: &str, unit: LengthUnit, own: LengthUnit) -> Contrary {
    let word = match unit {
        LengthUnit::Millimetre => "METRIC",
        LengthUnit::Inch => "INCH",
    };
    let own = own.word();
    Contrary::new(
        format!(
            "`{name}` is written in {} (`{word}`), the job counts in {own}",
            unit.word()
        ),
        "correct `control_unit`, or read the files out again in the basic system of the control",
    )
}

struct Sorted<'a> {
    job: &'a Job,
    names: &'a Names,
    all: &'a SiemensContents,
    purpose: ReadOutFor,
    notes: Vec<String>,
    assumptions: Vec<Assumption>,
    others: Others,
    contrary: Vec<Contrary>,
    beside: Vec<String>,
}

impl Sorted<'_> {
    /// Part programs: no state beside active data, and where nothing else was read out, what they
    /// would make of it.
    fn tell_programs(&mut self, programs: &Programs, are_read: bool) {
        const MOST_NAMES: usize = 6;
        let names = match programs.names.len() {
            0..=MOST_NAMES => programs.names.join(", "),
            many => many.to_string(),
        };
        if names.is_empty() {
            return;
        }
        let has_tables = !self.all.tables.lec.is_empty() || !self.all.tables.cec.is_empty();
        match (self.purpose, are_read) {
            (ReadOutFor::Judging, true) => self.beside.push(format!(
                "nothing but part programs was read out ({names}): what they write acts only once they were run, and as long as nothing else was loaded"
            )),
            (ReadOutFor::OldTables, false) if programs.write_tables && !has_tables => {
                self.contrary.push(Contrary::new(
                    format!("the read-out holds tables in part programs only ({names}), and whether they were run it does not tell"),
                    "read out the active data (…_EEC_INI, …_CEC_INI), or name the kit that was loaded",
                ));
            }
            (ReadOutFor::OldTables, true) => self.notes.push(format!(
                "part programs ({names}) count as run and active: nothing else was read out"
            )),
            (_, false) => self.notes.push(format!(
                "part programs were passed over ({names}), they do nothing before they are run"
            )),
        }
    }

    /// A variable that the files hold with several values. Switches are made for being changed, and
    /// how much memory is reserved does nothing.
    fn several_values(&mut self, name: &str) {
        if name.contains("_MAX_POINTS") {
            return;
        }
        let bare = name.trim_start_matches('$').split('[').next();
        let is_switch = bare.is_some_and(is_switch);
        if !self.concerns_the_job(name) {
            let left = self.purpose.leaves();
            self.notes.push(format!(
                "{name}, of others, has several values in the files: {left}"
            ));
        } else if is_switch && self.purpose == ReadOutFor::OldTables {
            self.notes.push(format!("{name} has several values in the files: the last of them, by the names of the files and by their lines, counts as active, and the way back leaves it to a person"));
        } else {
            self.contrary.push(Contrary::new(
                format!("{name} has several values in the files, so which of them the control holds is not known"),
                "name the files of one read-out",
            ));
        }
    }

    /// Whether a variable, as files write it, is one of an axis or table of the job.
    fn concerns_the_job(&self, variable: &str) -> bool {
        let Some((name, indices)) = variable.trim_end_matches(']').split_once('[') else {
            return true; // of the whole control
        };
        let indices: Vec<&str> = indices.split(',').collect();
        if name.starts_with("$AN_CEC") || name.starts_with("$SN_CEC") {
            let has = |axis: &str| axis_of(self.names, axis).is_some();
            let own = |table: &&CecTable| indices[0].parse() == Ok(table.number);
            let table = self.all.tables.cec.iter().find(own);
            return table.is_none_or(|table| has(&table.input_axis) || has(&table.output_axis));
        }
        let Some(axis) = indices.last().and_then(|axis| axis_of(self.names, axis)) else {
            return false;
        };
        indices.len() == 1
            || name == "$MA_REFP_SET_POS"
            || indices[0].parse() == Ok(self.encoder(axis))
    }

    fn encoder(&self, axis: Axis) -> u32 {
        let settings = self.job.compensation.axes[axis].as_ref();
        settings.and_then(|s| s.measuring_system).unwrap_or(1) - 1
    }

    fn value(&self, name: &str, indices: &[&str]) -> Option<f64> {
        let same = |datum: &&MachineDatum| {
            let own = datum.indices.iter().map(String::as_str);
            datum.name == name && own.eq(indices.iter().copied())
        };
        match self.all.machine_data.iter().find(same)?.value {
            MachineValue::Number(number) => Some(number),
            MachineValue::Text(_) => None,
        }
    }

    /// Whether a switch stands at 1; what no file holds is taken as on, and said.
    fn is_on(&mut self, name: &str, number: &str, indices: &[&str]) -> bool {
        let what = format!("{number} ${name}[{}]", indices.join(","));
        match self.value(name, indices) {
            Some(value) => value > 0.0,
            None => {
                if !self.assumptions.iter().any(|a| a.fact == what) {
                    self.assumptions.push(Assumption::of_job(
                        what,
                        "1 while measuring",
                        "no file holds it; a table that was off would be added to the new one",
                    ));
                }
                true
            }
        }
    }

    fn lec(&mut self) -> Vec<LecTable> {
        let mut own = Vec::new();
        for table in &self.all.tables.lec {
            let name = format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis);
            let Some(axis) = axis_of(self.names, &table.axis) else {
                let left = match self.purpose {
                    ReadOutFor::OldTables => self.purpose.leaves(),
                    ReadOutFor::Judging => {
                        "passed over (an axis of the job under another name? state `id`)"
                    }
                };
                self.notes.push(format!(
                    "{name} belongs to an axis that the job does not have: {left}"
                ));
                continue;
            };
            if table.encoder != self.encoder(axis) {
                self.other_system(&name, axis, table);
            } else if self.is_on(
                "MA_ENC_COMP_ENABLE",
                "MD32700",
                &[&table.encoder.to_string(), &table.axis],
            ) {
                let mut table = table.clone();
                if let Some((grid, values, end)) = closed(table.grid, &table.values) {
                    (table.grid, table.values) = (grid, values);
                    self.tell_open_end(&name, &end);
                }
                own.push(table);
            } else {
                self.notes.push(match self.purpose {
                    ReadOutFor::OldTables => format!("{name} was switched off (MD32700 = 0): it counts as not active, and the new table overwrites it"),
                    ReadOutFor::Judging => format!("{name} is switched off (MD32700 = 0), so it does nothing"),
                });
            }
        }
        own
    }

    /// A table of the measuring system that the job does not name.
    fn other_system(&mut self, name: &str, axis: Axis, table: &LecTable) {
        let switch = [table.encoder.to_string(), table.axis.clone()];
        let switch = self.value("MA_ENC_COMP_ENABLE", &[&switch[0], &switch[1]]);
        let is_off = switch.is_some_and(|value| value <= 0.0);
        let twin = |other: &&LecTable| other.axis == table.axis && other.encoder != table.encoder;
        let has_twin = self.all.tables.lec.iter().any(|other| twin(&other));
        let settings = self.job.compensation.axes[axis].as_ref();
        let is_stated = settings.is_some_and(|s| s.measuring_system.is_some());
        let system = table.encoder + 1;
        if is_off || (has_twin && (is_stated || self.purpose == ReadOutFor::OldTables)) {
            let left = self.purpose.leaves();
            let off = if is_off { " and switched off" } else { "" };
            self.notes.push(format!(
                "{name} is for the other measuring system{off}: {left}"
            ));
        } else if has_twin {
            self.beside.push(format!("{name} is for measuring system {system}, and the files do not tell which of the two is active: state `measuring_system`"));
        } else {
            self.contrary.push(Contrary::new(
                format!("{name} is for measuring system {system}, and there is none for the one of the job"),
                "state `measuring_system` in [compensation.axes] as it is active on the control",
            ));
        }
    }

    fn cec(&mut self) -> Vec<CecTable> {
        let mut own = Vec::new();
        for table in &self.all.tables.cec {
            if self.is_of_others(table) {
                self.others.cec_tables.push(table.number);
            } else if self.acts(table) {
                self.weigh(table);
                let mut table = table.clone();
                if let Some((grid, values, end)) = closed(table.grid, &table.values) {
                    (table.grid, table.values) = (grid, values);
                    self.tell_open_end(&format!("$AN_CEC[{}]", table.number), &end);
                }
                own.push(table);
            } else {
                self.others.cec_tables.push(table.number);
                let name = format!("$AN_CEC[{}]", table.number);
                self.notes.push(match self.purpose {
                    ReadOutFor::OldTables => format!("{name} was switched off (SD41300 or MD32710 = 0): it counts as not active and is left as it is"),
                    ReadOutFor::Judging => format!("{name} is switched off (SD41300 or MD32710 = 0), so it does nothing"),
                });
            }
        }
        if self.purpose == ReadOutFor::OldTables {
            self.outputs(&own);
        }
        own
    }

    /// Where a table ends between two points; nothing is said where both readings are the same.
    fn tell_open_end(&mut self, name: &str, end: &OpenEnd) {
        let unit = self.job.compensation.control_unit;
        let by = match end.differs_by {
            Some(by) if by <= 0.0 => return,
            Some(by) => format!("by up to {:.1} µm", by * unit.in_mm() * UM_PER_MM),
            None => "by a value that no file holds".to_string(),
        };
        let (point, from, word) = (end.point, end.from, unit.word());
        let fact = format!("{name} behind {from} {word}, where MAX lies between two points");
        let other = format!("the control goes on towards point {}", point + 1);
        match self.purpose {
            ReadOutFor::OldTables => self.assumptions.push(Assumption::of_job(
                fact,
                format!("the value of point {point} held"),
                format!("the old correction there differs {by} if {other}"),
            )),
            ReadOutFor::Judging => self.beside.push(format!(
                "{fact}: the value of point {point} is taken to be held; if {other}, the correction differs {by} there"
            )),
        }
    }

    /// Tables that are switched on and in no file of the read-out, so that what they do is not known.
    /// `reserved` = tables that the files hold without a grid.
    fn tell_what_was_not_read_out(&mut self, reserved: &[String]) {
        let lec = self.lec_not_read_out(reserved);
        let cec = self.cec_not_read_out(reserved);
        for Contrary { words, help } in lec.into_iter().chain(cec) {
            match self.purpose {
                ReadOutFor::OldTables => self.contrary.push(Contrary { words, help }),
                ReadOutFor::Judging => self.beside.push(words),
            }
        }
        for what in self.untold(reserved) {
            match self.purpose {
                ReadOutFor::OldTables => self.assumptions.push(Assumption::of_job(
                    what,
                    "none while measuring",
                    "no file holds such a table or its switches; an old table would be lost with the new ones",
                )),
                ReadOutFor::Judging => {
                    let words = format!("{what}: no file holds such a table or its switches, so none is taken to act");
                    self.notes.push(words);
                }
            }
        }
    }

    /// Of which tables the files say nothing, neither values nor switches.
    fn untold(&self, reserved: &[String]) -> Vec<String> {
        let names = self.names.iter().flat_map(|(_, names)| names);
        let names: Vec<String> = names.map(|name| name.to_uppercase()).collect();
        let tells_of_lec = |name: &&String| {
            let datum = |e: &&str| self.value("MA_ENC_COMP_ENABLE", &[e, name]).is_some();
            let is_reserved = |e: &&str| reserved.contains(&format!("AA_ENC_COMP[{e},{name}]"));
            ["0", "1"].iter().any(|e| datum(e) || is_reserved(e))
                || self.all.tables.lec.iter().any(|table| table.axis == **name)
        };
        let lec: Vec<String> = names.iter().filter(|n| !tells_of_lec(n)).cloned().collect();
        let mut untold = Vec::new();
        if !lec.is_empty() {
            untold.push(format!("ENC_COMP of {}", listed(&lec)));
        }
        let has_data = [
            "MA_CEC_ENABLE",
            "SN_CEC_TABLE_ENABLE",
            "MN_MM_CEC_MAX_POINTS",
        ];
        let is_of_cec = |datum: &MachineDatum| has_data.contains(&datum.name.as_str());
        let is_reserved = reserved.iter().any(|table| table.starts_with("AN_CEC"));
        if self.all.tables.cec.is_empty()
            && !is_reserved
            && !self.all.machine_data.iter().any(is_of_cec)
        {
            untold.push("CEC".to_string());
        }
        untold
    }

    /// Whether a datum was read out and stands above 0.
    fn is_above_zero(&self, name: &str, indices: &[&str]) -> Option<bool> {
        self.value(name, indices).map(|value| value > 0.0)
    }

    /// MD32700 = 1 of an axis of the job without its table. Where the job does not state which
    /// measuring system is active, either may be.
    fn lec_not_read_out(&self, reserved: &[String]) -> Option<Contrary> {
        let mut switches = Vec::new();
        for (axis, names) in self.names.iter() {
            let settings = self.job.compensation.axes[axis].as_ref();
            let is_stated = settings.is_some_and(|s| s.measuring_system.is_some());
            for (name, encoder) in names.iter().flat_map(|name| [(name, 0_u32), (name, 1)]) {
                let (name, number) = (name.to_uppercase(), encoder.to_string());
                let is = |datum| self.is_above_zero(datum, &[&number, &name]);
                let is_held =
                    self.all.tables.lec.iter().any(|table| {
                        table.axis == name && (table.encoder == encoder || !is_stated)
                    });
                let is_reserved = reserved.contains(&format!("AA_ENC_COMP[{number},{name}]"));
                let is_active = encoder == self.encoder(axis) || !is_stated;
                if is("MA_ENC_COMP_ENABLE") == Some(true)
                    && is("MA_MM_ENC_COMP_MAX_POINTS") != Some(false)
                    && is_active
                    && !is_held
                    && !is_reserved
                {
                    switches.push(format!("[{number},{name}]"));
                }
            }
        }
        (!switches.is_empty()).then(|| Contrary::new(
            format!("MD32700 $MA_ENC_COMP_ENABLE{} is 1, so an ENC_COMP table acts, and no file holds it", listed(&switches)),
            "read out the tables too ($AA_ENC_COMP, `AX_EEC.INI`) and name all files together, or name the commissioning archive (.arc)",
        ))
    }

    /// SD41300 = 1 without the CEC table, or MD32710 = 1 of an axis of the job where nothing else
    /// tells of CEC.
    fn cec_not_read_out(&self, reserved: &[String]) -> Option<Contrary> {
        let names = self.names.iter().flat_map(|(_, names)| names);
        let is_on = |name: &&String| self.is_above_zero("MA_CEC_ENABLE", &[&name.to_uppercase()]);
        let (on, off): (Vec<&String>, Vec<&String>) = names
            .filter(|name| is_on(name).is_some())
            .partition(|name| is_on(name) == Some(true));
        if on.is_empty() && !off.is_empty() {
            return None;
        }
        let switches: Vec<(String, bool)> = self.of_tables("SN_CEC_TABLE_ENABLE");
        let memory = self.of_tables("MN_MM_CEC_MAX_POINTS");
        let is_absent = |number: &String| {
            let is_held = self
                .all
                .tables
                .cec
                .iter()
                .any(|t| t.number.to_string() == *number);
            let has_none = memory.contains(&(number.clone(), false));
            !is_held && !has_none && !reserved.contains(&format!("AN_CEC[{number}]"))
        };
        let absent = switches
            .iter()
            .filter(|(number, is_on)| *is_on && is_absent(number));
        let absent: Vec<String> = absent.map(|(number, _)| number.clone()).collect();
        let tells = !self.all.tables.cec.is_empty() || !switches.is_empty();
        let has_memory = memory.is_empty() || memory.iter().any(|(_, has)| *has);
        let words = if !absent.is_empty() {
            let (tables, them) = match absent.len() {
                1 => (format!("table {}", absent[0]), "it"),
                _ => (format!("tables {}", listed(&absent)), "them"),
            };
            format!("SD41300 $SN_CEC_TABLE_ENABLE of CEC {tables} is 1, and no file holds {them}")
        } else if !tells && has_memory && !on.is_empty() {
            let on: Vec<String> = on.into_iter().cloned().collect();
            format!(
                "MD32710 $MA_CEC_ENABLE of {} is 1, and no file holds a CEC table or SD41300",
                listed(&on)
            )
        } else {
            return None;
        };
        Some(Contrary::new(
            words,
            "read out the tables too ($AN_CEC, `NC_CEC.INI`) and name all files together, or name the commissioning archive (.arc)",
        ))
    }

    /// A datum of every CEC table that was read out: number of the table, and whether it is above 0.
    fn of_tables(&self, name: &str) -> Vec<(String, bool)> {
        let own = self
            .all
            .machine_data
            .iter()
            .filter(|datum| datum.name == name);
        own.filter_map(|datum| match (&datum.indices[..], &datum.value) {
            ([table], MachineValue::Number(value)) => Some((table.clone(), *value > 0.0)),
            _ => None,
        })
        .collect()
    }

    /// Whether SD41300 of a table and MD32710 of its output axis stand at 1.
    fn acts(&mut self, table: &CecTable) -> bool {
        self.is_on(
            "SN_CEC_TABLE_ENABLE",
            "SD41300",
            &[&table.number.to_string()],
        ) && self.is_on("MA_CEC_ENABLE", "MD32710", &[&table.output_axis])
    }

    /// What else decides how far old CEC tables acted on an axis: MD32720 cuts their sum, MD32711
    /// (with MD10260 = 1) says their unit. `verify` judges both where the files are read for it.
    fn outputs(&mut self, own: &[CecTable]) {
        let mut outputs: Vec<&str> = own.iter().map(|t| t.output_axis.as_str()).collect();
        outputs.sort_unstable();
        outputs.dedup();
        let unit = self.job.compensation.control_unit;
        let tables = SiemensTables {
            cec: own.to_vec(),
            ..SiemensTables::default()
        };
        for output in outputs {
            let sum = tables.largest_cec_sum(output);
            let limit = self.value("MA_CEC_MAX_SUM", &[output]);
            if let Some(limit) = limit.filter(|limit| *limit < sum - LAST_DIGIT / 2.0) {
                self.contrary.push(Contrary::new(
                    format!("MD32720 of {output} is {limit} {unit}, and its CEC tables add up to as much as {sum:.6} {unit}: the control cuts off what is more, so what acted is not known", unit = unit.word()),
                    "measure with these tables switched off",
                ));
            }
            let metric = self.value("MA_CEC_SCALING_SYSTEM_METRIC", &[output]);
            let converts = self.value("MN_CONVERT_SCALING_SYSTEM", &[]);
            let other = metric.filter(|metric| LengthUnit::of_metric(*metric) != unit);
            if let Some(metric) = other.filter(|_| converts.is_none_or(|on| on > 0.0)) {
                self.contrary.push(Contrary::new(
                    format!("MD32711 of {output} is {metric}, so its CEC tables are not in {} (where MD10260 = 1)", unit.word()),
                    "state the `control_unit` of the tables, or read out MD10260 = 0 as well",
                ));
            }
        }
    }

    /// A weight other than 1, which is not emulated.
    fn weigh(&mut self, table: &CecTable) {
        let weight = self.value("SN_CEC_TABLE_WEIGHT", &[&table.number.to_string()]);
        if let Some(weight) = weight.filter(|weight| (weight - 1.0).abs() > 0.0) {
            self.contrary.push(Contrary::new(
                format!("SD41310 $SN_CEC_TABLE_WEIGHT[{}] is {weight}, expected 1: the table acts with this factor, which is not emulated", table.number),
                "set it to 1, or measure with this table switched off",
            ));
        }
    }

    /// Whether an axis of a table is none of the job; where it acts on one of the job all the
    /// same, that is said.
    fn is_of_others(&mut self, table: &CecTable) -> bool {
        let has = |axis: &str| axis_of(self.names, axis).is_some();
        let (input, output) = (has(&table.input_axis), has(&table.output_axis));
        if input && output {
            return false;
        }
        let name = format!(
            "$AN_CEC[{}] ({} → {})",
            table.number, table.input_axis, table.output_axis
        );
        let is_zero = table
            .values
            .iter()
            .flatten()
            .all(|value| value.abs() <= 0.0);
        if let Some(factor) = self.own_factor(table)
            && self.acts(table)
        {
            self.takes_as_factor(&name, factor);
        } else if self.purpose == ReadOutFor::Judging && output && !is_zero && self.acts(table) {
            self.beside.push(beside_words(&name, &table.input_axis));
        } else {
            let left = self.purpose.leaves();
            self.notes.push(format!(
                "{name} belongs to axes that the job does not have: {left}"
            ));
        }
        true
    }

    /// The table of the job that another table multiplies by.
    fn own_factor(&self, table: &CecTable) -> Option<u32> {
        let number = table.multiply_by.checked_sub(1)?;
        let has = |axis: &str| axis_of(self.names, axis).is_some();
        let mut all = self.all.tables.cec.iter();
        let factor = all.find(|other| other.number == number)?;
        (has(&factor.input_axis) && has(&factor.output_axis)).then_some(number)
    }

    /// Whether a factor still acts by itself is a fact that no manual at hand states.
    fn takes_as_factor(&mut self, name: &str, factor: u32) {
        let words = format!(
            "{name}, of axes that the job does not have, multiplies by $AN_CEC[{factor}] of the job: whether that one still acts by itself is not known"
        );
        match self.purpose {
            ReadOutFor::Judging => self.beside.push(words),
            ReadOutFor::OldTables => self
                .contrary
                .push(Contrary::new(words, "measure with that table switched off")),
        }
    }

    /// MD32450 of the active measuring system, µm.
    fn backlash(&self, axis: Axis) -> NamedBacklash {
        let encoder = self.encoder(axis).to_string();
        let in_um = self.job.compensation.control_unit.in_mm() * UM_PER_MM;
        let of_name = |name: &String| {
            let held = self.value("MA_BACKLASH", &[&encoder, &name.to_uppercase()]);
            (name.clone(), held.map(|value| value * in_um))
        };
        self.names[axis].iter().map(of_name).collect()
    }
}
