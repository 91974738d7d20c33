//! Assignments of one file gathered into tables: the meaning of the variables.
//!
//! A table is complete when its file ends; until then its parameters and points may come in any
//! order and the last assignment of each counts (Function Manual Extended Functions 03/2013, K3
//! p. 240-249: the assignments are independent statements).

use super::variable::{self, Key, number_of};
use super::{
    MOST_DATA, MOST_STATEMENTS, MOST_TABLES, MachineDatum, MachineValue, SiemensContents, Writer,
    is_switch, variable_text,
};
use crate::control::table::siemens::{CecDirection, CecTable, LecTable, SiemensGrid};
use crate::read::lexer::Complaint;
use crate::read::siemens::assignment::{Assignment, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// No control reserves more points for one table (5000 is the largest bound known); keeps a
/// mistyped STEP from filling the memory of the PC.
const MOST_POINTS: f64 = 100_000.0;

/// A number and where it stands.
#[derive(Clone, Debug)]
struct Placed {
    number: f64,
    span: Range<usize>,
}

/// What LEC and CEC tables have in common.
#[derive(Debug, Default)]
struct Draft {
    head: Range<usize>,
    unreadable: bool,
    protected: bool,
    min: Option<Placed>,
    step: Option<Placed>,
    max: Option<Placed>,
    modulo: Option<bool>,
    points: BTreeMap<u32, Placed>,
}

#[derive(Debug)]
struct LecDraft {
    axis: String,
    encoder: u32,
    draft: Draft,
}

#[derive(Debug, Default)]
struct CecDraft {
    draft: Draft,
    input: Option<String>,
    output: Option<String>,
    direction: Option<CecDirection>,
    multiply_by: Option<u32>,
}

/// The tables and machine data of one file while it is being read.
#[derive(Debug, Default)]
pub(super) struct Memory {
    lec: Vec<LecDraft>,
    cec: BTreeMap<u32, CecDraft>,
    machine: Vec<MachineDatum>,
    /// The first switch behind the last `NEWCONF`.
    waiting: Option<String>,
    notes: Vec<String>,
}

impl Memory {
    /// Carries out one assignment.
    pub(super) fn set(&mut self, set: &Assignment<'_>) -> Result<(), Complaint> {
        let key = variable::key(set)?;
        if set.name.starts_with("AA_") {
            self.set_lec(key, set)
        } else if set.name.starts_with("AN_") {
            self.set_cec(key, set)
        } else {
            self.set_machine(set)
        }
    }

    /// Whether it holds more than any control.
    pub(super) fn is_full(&self) -> bool {
        self.lec.len() + self.cec.len() > MOST_TABLES || self.machine.len() > MOST_DATA
    }

    /// Adds a remark that is no problem.
    pub(super) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Machine data that were written act from here on.
    pub(super) fn activate(&mut self) {
        self.waiting = None;
    }

    /// Says of a kit's file that its switches do not act when it has run. Machine data of that class wait
    /// for NEWCONF or a reset (classes: 840Di sl Commissioning Manual 05/2008 p. 356; that MD32700 and MD32710
    /// are of it is assumed).
    pub(super) fn note_waiting(&mut self, writer: Writer, file_name: &str) {
        let waiting = self.waiting.take().filter(|_| writer == Writer::Kit);
        self.notes.extend(waiting.map(|variable| {
            format!("`{file_name}` sets {variable} and no NEWCONF follows: it acts from the next NEWCONF or reset on, wherever the axes stand then")
        }));
    }

    fn set_lec(&mut self, key: Key<'_>, set: &Assignment<'_>) -> Result<(), Complaint> {
        let encoder = |text: &String| text.parse() == Ok(key.encoder);
        let enabled = is_on(
            &self.machine,
            "MA_ENC_COMP_ENABLE",
            |indices| matches!(indices, [number, axis] if encoder(number) && *axis == key.axis),
        );
        let draft = self.lec_of(key);
        let head = draft.begin(set);
        let result = draft.set("AA_ENC_COMP", key.point, set);
        draft.unreadable |= result.is_err();
        result.and_then(|()| draft.refuse_if(enabled, head, "MA_ENC_COMP_ENABLE"))
    }

    /// The table of an axis and an encoder; a new one where it was not met before.
    fn lec_of(&mut self, key: Key<'_>) -> &mut Draft {
        let is_it = |known: &LecDraft| known.encoder == key.encoder && known.axis == key.axis;
        let known = self.lec.iter().position(is_it);
        let place = known.unwrap_or_else(|| {
            self.lec.push(LecDraft {
                axis: key.axis.to_string(),
                encoder: key.encoder,
                draft: Draft::default(),
            });
            self.lec.len() - 1
        });
        &mut self.lec[place].draft
    }

    fn set_cec(&mut self, key: Key<'_>, set: &Assignment<'_>) -> Result<(), Complaint> {
        let table = self.cec.entry(key.table).or_default();
        let head = table.draft.begin(set);
        let result = table.set(key.point, set);
        table.draft.unreadable |= result.is_err();
        let output = table.output.as_ref();
        let enabled = output.is_some_and(|output| {
            is_on(
                &self.machine,
                "MA_CEC_ENABLE",
                |indices| matches!(indices, [axis] if axis == output),
            )
        });
        result.and_then(|()| table.draft.refuse_if(enabled, head, "MA_CEC_ENABLE"))
    }

    fn set_machine(&mut self, set: &Assignment<'_>) -> Result<(), Complaint> {
        if variable::is_number(&set.name) {
            variable::number_of(set)?;
        }
        if variable::is_truth(&set.name) {
            variable::truth(set)?;
        }
        let value = match set.value.clone()? {
            Value::Number(number) => MachineValue::Number(number),
            Value::Truth(truth) => MachineValue::Number(f64::from(u8::from(truth))),
            Value::Name(name) => MachineValue::Text(name),
        };
        let waits = set.name.starts_with("MA_") && is_switch(&set.name);
        if waits && self.waiting.is_none() {
            self.waiting = Some(variable_text(&set.name, &plain_indices(set)));
        }
        if let Some(known) = self
            .machine
            .iter_mut()
            .find(|datum| datum.name == set.name && same_indices(&datum.indices, &set.indices))
        {
            known.value = value;
            return Ok(());
        }
        self.machine.push(MachineDatum {
            name: set.name.to_string(),
            indices: plain_indices(set),
            value,
        });
        Ok(())
    }

    /// A few lines may ask for many points: MIN, STEP and MAX.
    fn too_many_points(&self) -> Option<Complaint> {
        let lec = self.lec.iter().map(|table| &table.draft);
        let drafts = || {
            lec.clone()
                .chain(self.cec.values().map(|table| &table.draft))
        };
        let points: f64 = drafts().filter_map(Draft::steps).sum();
        #[allow(clippy::cast_precision_loss, reason = "a small constant")]
        let is_too_many = points > MOST_STATEMENTS as f64;
        let head = drafts().next()?.head.clone();
        is_too_many.then(|| {
            Complaint::new(
                head,
                format!("the tables would have {points:.0} points together, expected at most {MOST_STATEMENTS}"),
                "no control holds so many; correct MIN, STEP or MAX",
            )
        })
    }

    /// The tables, if nothing is missing; complaints are added to `complaints`.
    pub(super) fn finish(
        mut self,
        writer: Writer,
        complaints: &mut Vec<Complaint>,
    ) -> SiemensContents {
        let too_many = self.too_many_points();
        let mut all = SiemensContents {
            machine_data: self.machine,
            notes: self.notes,
            ..SiemensContents::default()
        };
        if let Some(complaint) = too_many {
            complaints.push(complaint);
            return all;
        }
        self.lec
            .sort_by(|a, b| (&a.axis, a.encoder).cmp(&(&b.axis, b.encoder)));
        for table in self.lec {
            let name = format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis);
            all.unwritten.extend(table.draft.unwritten(&name));
            match table.draft.finish(&name, writer, complaints) {
                Some(Content::Table(grid, values)) => all.tables.lec.push(LecTable {
                    encoder: table.encoder,
                    axis: table.axis,
                    grid,
                    values,
                    modulo: table.draft.modulo.unwrap_or(false),
                }),
                Some(Content::Nothing) => all.idle.push(name[1..].to_string()),
                None => {}
            }
        }
        for (number, table) in self.cec {
            table.finish(number, writer, &mut all, complaints);
        }
        all
    }
}

/// What a table holds when its file ends.
enum Content {
    Table(SiemensGrid, Vec<Option<f64>>),
    /// Zeros without a usable grid: memory that nobody filled.
    Nothing,
}

impl Draft {
    /// Notes where the table begins; gives the place of this assignment.
    fn begin(&mut self, set: &Assignment<'_>) -> Range<usize> {
        if self.head.is_empty() {
            self.head = set.head.clone();
        }
        set.head.clone()
    }

    /// A parameter that no line writes; not told if a line could not be read, as it may be that one.
    fn missing(&self, name: &str, field: &str, complaints: &mut Vec<Complaint>) {
        if !self.unreadable {
            complaints.push(Complaint::new(
                self.head.clone(),
                format!("{field} of {name} is missing"),
                "write it in the same file as the points",
            ));
        }
    }

    /// A table that is switched on is write-protected: alarm 17070 (808D Function Manual
    /// 01/2017 p. 109). Told once for each table.
    fn refuse_if(&mut self, on: bool, at: Range<usize>, switch: &str) -> Result<(), Complaint> {
        if !on || std::mem::replace(&mut self.protected, true) {
            return Ok(());
        }
        Err(Complaint::new(
            at,
            format!(
                "the table is written while `${switch}` is 1; the control stops with alarm 17070"
            ),
            format!("set `${switch}` to 0 before the table and to 1 after it"),
        ))
    }

    /// Carries out `set`, whose variable is `family` or one of its parameters.
    fn set(&mut self, family: &str, point: u32, set: &Assignment<'_>) -> Result<(), Complaint> {
        match set.name.strip_prefix(family).unwrap_or_default() {
            "_IS_MODULO" => self.modulo = Some(variable::truth(set)?),
            "_STEP" => self.step = Some(placed(set)?),
            "_MIN" => self.min = Some(placed(set)?),
            "_MAX" => self.max = Some(placed(set)?),
            _ => {
                self.points.insert(point, placed(set)?);
            }
        }
        Ok(())
    }

    /// Sections of its grid, where it states one that a table may have.
    fn steps(&self) -> Option<f64> {
        let (min, step, max) = (self.min.as_ref()?, self.step.as_ref()?, self.max.as_ref()?);
        let steps = (max.number - min.number) / step.number;
        (0.0..MOST_POINTS).contains(&steps).then_some(steps)
    }

    /// The parameter that no line writes, so that the control would keep an older one.
    fn unwritten(&self, name: &str) -> Option<String> {
        self.modulo
            .is_none()
            .then(|| format!("IS_MODULO of {name}"))
    }

    /// Its content; a control writes reserved points behind MAX too, which have no effect, and tables
    /// that nobody filled.
    fn finish(
        &self,
        name: &str,
        writer: Writer,
        complaints: &mut Vec<Complaint>,
    ) -> Option<Content> {
        let mut own = Vec::new();
        let whole = self.whole(name, writer, &mut own);
        let is_zero = self
            .points
            .values()
            .all(|placed| placed.number.abs() <= 0.0);
        if whole.is_none() && writer == Writer::Control && is_zero && !self.unreadable {
            return Some(Content::Nothing);
        }
        complaints.append(&mut own);
        whole.map(|(grid, values)| Content::Table(grid, values))
    }

    fn whole(
        &self,
        name: &str,
        writer: Writer,
        complaints: &mut Vec<Complaint>,
    ) -> Option<(SiemensGrid, Vec<Option<f64>>)> {
        let grid = self.grid(name, complaints)?;
        let last = self
            .last_point(name, grid, writer)
            .map_err(|complaint| complaints.push(complaint))
            .ok()?;
        let behind = self.points.range(last + 1..);
        for (point, placed) in behind.filter(|_| writer == Writer::Kit) {
            complaints.push(Complaint::new(
                placed.span.clone(),
                format!("{name} has point {point}, but MIN, STEP and MAX give points 0 to {last}"),
                "remove the point or correct MIN, STEP or MAX",
            ));
        }
        let value = |point| self.points.get(&point).map(|placed| placed.number);
        Some((grid, (0..=last).map(value).collect()))
    }

    /// Index of the last point. Where MAX of a control's table lies between two points, that of the
    /// one behind MAX, if it is there: it may be part of what the control computes.
    fn last_point(&self, name: &str, grid: SiemensGrid, writer: Writer) -> Result<u32, Complaint> {
        let Some(step) = &self.step else {
            return Ok(0); // a grid has one
        };
        let steps = grid.steps();
        let refuse =
            |message: String, help: &str| Err(Complaint::new(step.span.clone(), message, help));
        if steps >= MOST_POINTS {
            let message = format!("{name} would have {steps:.0} points");
            return refuse(
                message,
                "no control holds so many; correct MIN, STEP or MAX",
            );
        }
        let last = grid.last_whole_point();
        if last >= 1 && grid.is_whole() {
            return Ok(last);
        }
        if last < 1 || writer == Writer::Kit {
            return refuse(
                format!("(MAX-MIN)/STEP of {name} is {steps}, expected a whole number from 1"),
                "the last point must lie on MAX; controls differ in what they do otherwise",
            );
        }
        let is_there = self.points.contains_key(&(last + 1));
        Ok(last + u32::from(is_there))
    }

    fn grid(&self, name: &str, complaints: &mut Vec<Complaint>) -> Option<SiemensGrid> {
        for (field, value) in [("MIN", &self.min), ("STEP", &self.step), ("MAX", &self.max)] {
            if value.is_none() {
                self.missing(name, field, complaints);
            }
        }
        let (min, step, max) = (self.min.as_ref()?, self.step.as_ref()?, self.max.as_ref()?);
        if step.number <= 0.0 {
            complaints.push(Complaint::new(
                step.span.clone(),
                format!(
                    "STEP of {name} is {}, it must be greater than 0",
                    step.number
                ),
                "write the distance of two points",
            ));
            return None;
        }
        if max.number <= min.number {
            complaints.push(Complaint::new(
                max.span.clone(),
                format!(
                    "MAX of {name} is {}, not greater than MIN {}",
                    max.number, min.number
                ),
                "MIN is the position of point 0, MAX that of the last point",
            ));
            return None;
        }
        Some(SiemensGrid {
            min: min.number,
            step: step.number,
            max: max.number,
        })
    }
}

impl CecDraft {
    fn set(&mut self, point: u32, set: &Assignment<'_>) -> Result<(), Complaint> {
        const FAMILY: &str = "AN_CEC";
        match set.name.strip_prefix(FAMILY).unwrap_or_default() {
            "_INPUT_AXIS" => self.input = Some(variable::axis(set)?),
            "_OUTPUT_AXIS" => self.output = Some(variable::axis(set)?),
            "_DIRECTION" => self.direction = Some(variable::direction(set)?),
            "_MULT_BY_TABLE" => self.multiply_by = Some(variable::table_number(set)?),
            "_TYPE" => variable::only_zero(set, "its meaning is not documented")?,
            "_INPUT_NCU" | "_OUTPUT_NCU" => variable::own_ncu(set)?,
            _ => self.draft.set(FAMILY, point, set)?,
        }
        Ok(())
    }

    /// The parameters that no line writes, so that the control would keep older ones.
    fn unwritten(&self, name: &str) -> Vec<String> {
        let parameters = [
            ("DIRECTION", self.direction.is_none()),
            ("MULT_BY_TABLE", self.multiply_by.is_none()),
        ];
        let lacking = parameters.into_iter().filter(|(_, lacks)| *lacks);
        let lacking = lacking.map(|(field, _)| format!("{field} of {name}"));
        self.draft
            .unwritten(name)
            .into_iter()
            .chain(lacking)
            .collect()
    }

    /// Adds the table to what the file holds.
    fn finish(
        self,
        number: u32,
        writer: Writer,
        all: &mut SiemensContents,
        complaints: &mut Vec<Complaint>,
    ) {
        let name = format!("$AN_CEC[{number}]");
        all.unwritten.extend(self.unwritten(&name));
        let content = self.draft.finish(&name, writer, complaints);
        if let Some(Content::Nothing) = content {
            all.idle.push(name[1..].to_string());
            return;
        }
        for (field, axis) in [("INPUT_AXIS", &self.input), ("OUTPUT_AXIS", &self.output)] {
            if axis.is_none() {
                self.draft.missing(&name, field, complaints);
            }
        }
        let (Some(Content::Table(grid, values)), Some(input_axis), Some(output_axis)) =
            (content, self.input, self.output)
        else {
            return;
        };
        all.tables.cec.push(CecTable {
            number,
            input_axis,
            output_axis,
            grid,
            values,
            direction: self.direction.unwrap_or(CecDirection::Both),
            multiply_by: self.multiply_by.unwrap_or(0),
            modulo: self.draft.modulo.unwrap_or(false),
        });
    }
}

/// Whether the file has switched on `name` for the indices that `wanted` knows.
fn is_on(machine: &[MachineDatum], name: &str, wanted: impl Fn(&[String]) -> bool) -> bool {
    machine.iter().any(|datum| {
        let on = matches!(datum.value, MachineValue::Number(number) if number > 0.0);
        datum.name == name && wanted(&datum.indices) && on
    })
}

fn placed(set: &Assignment<'_>) -> Result<Placed, Complaint> {
    Ok(Placed {
        number: number_of(set)?,
        span: set.value_span.clone(),
    })
}

fn same_indices(plain_indices: &[String], indices: &[Cow<'_, str>]) -> bool {
    plain_indices.len() == indices.len()
        && plain_indices
            .iter()
            .zip(indices)
            .all(|(a, b)| *a == plain(b))
}

fn plain_indices(set: &Assignment<'_>) -> Vec<String> {
    set.indices.iter().map(|index| plain(index)).collect()
}

/// `01` and `1` are the same index.
fn plain(index: &str) -> String {
    match index.parse::<u32>() {
        Ok(number) => number.to_string(),
        Err(_) => index.to_string(),
    }
}
