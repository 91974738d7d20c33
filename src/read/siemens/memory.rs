//! Assignments of one file gathered into tables: the meaning of the variables.
//!
//! A table is complete when its file ends; until then its parameters and points may come in any
//! order and the last assignment of each counts (Function Manual Extended Functions 03/2013, K3
//! p. 240-249: the assignments are independent statements).

use super::contents::{MachineDatum, MachineValue, SiemensContents, is_switch, variable_text};
use super::statement::{Assignment, Value};
use super::variable::{Variable, variable};
use crate::control::table::siemens::{CecDirection, CecTable, LecTable, SiemensGrid};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;

/// No control reserves more points for one table (5000 is the largest bound known); keeps a
/// mistyped STEP from filling the memory of the PC.
const MOST_POINTS: f64 = 100_000.0;
/// Statements of one file that concern the compensation, and points of its tables. The largest read-out
/// seen has 900; 31 axes with the 5000 points of the largest table have 155 000.
pub(super) const MOST_STATEMENTS: usize = 200_000;
/// Tables of one file, and machine data: 62 and 31 tables and some 800 data are what a control has.
pub(super) const MOST_TABLES: usize = 1000;
pub(super) const MOST_DATA: usize = 10_000;

/// Who wrote a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Writer {
    /// A program or a person, for a control to load.
    Kit,
    /// The same, with tables as a control held them.
    Rollback,
    /// The control, which writes all that it holds.
    Control,
}

/// A table of the control; ENC_COMP tables come first, in the order of their axes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum TableName {
    Lec { axis: String, encoder: u32 },
    Cec(u32),
}

impl fmt::Display for TableName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableName::Lec { axis, encoder } => write!(f, "AA_ENC_COMP[{encoder},{axis}]"),
            TableName::Cec(number) => write!(f, "AN_CEC[{number}]"),
        }
    }
}

impl TableName {
    /// The table that a variable belongs to, and the parameter of it, which a point has none of.
    fn of(variable: &Variable<'_>) -> Option<(TableName, &'static str)> {
        if let Some(parameter) = variable.name.strip_prefix("AA_ENC_COMP") {
            let (axis, encoder) = (variable.axis.to_string(), variable.encoder);
            return Some((TableName::Lec { axis, encoder }, parameter));
        }
        let parameter = variable.name.strip_prefix("AN_CEC")?;
        Some((TableName::Cec(variable.table), parameter))
    }

    /// Parameters of which the control keeps an older value where no line writes them.
    fn optional(&self) -> &'static [&'static str] {
        match self {
            TableName::Lec { .. } => &["_IS_MODULO"],
            TableName::Cec(_) => &["_IS_MODULO", "_DIRECTION", "_MULT_BY_TABLE"],
        }
    }
}

/// A value and where it stands.
#[derive(Clone, Debug)]
struct Placed {
    value: Value,
    span: Range<usize>,
}

impl Placed {
    fn number(&self) -> f64 {
        match self.value {
            Value::Number(number) => number,
            _ => f64::NAN, // of parameters that are none
        }
    }
}

/// A table while its file is being read.
#[derive(Debug, Default)]
struct Draft {
    head: Range<usize>,
    /// What could not be read of it.
    complaints: Vec<Complaint>,
    protected: bool,
    parameters: BTreeMap<&'static str, Placed>,
    points: BTreeMap<u32, Placed>,
}

/// The tables and machine data of one file while it is being read.
#[derive(Debug)]
pub(super) struct Memory {
    writer: Writer,
    tables: BTreeMap<TableName, Draft>,
    machine: Vec<MachineDatum>,
    /// The first switch behind the last `NEWCONF`.
    waiting: Option<String>,
    /// What a control holds of each variable, and of which it holds two values.
    values: BTreeMap<String, String>,
    twice: BTreeSet<String>,
}

impl Memory {
    pub(super) fn new(writer: Writer) -> Memory {
        Memory {
            writer,
            tables: BTreeMap::new(),
            machine: Vec::new(),
            waiting: None,
            values: BTreeMap::new(),
            twice: BTreeSet::new(),
        }
    }

    /// Carries out one assignment.
    pub(super) fn set(&mut self, set: &Assignment<'_>) -> Result<(), Complaint> {
        let variable = variable(set)?;
        if self.writer == Writer::Control {
            self.note_value(set);
        }
        match TableName::of(&variable) {
            Some((name, parameter)) => self.set_table(name, parameter, &variable, set),
            None => self.set_machine(set, variable.value(set)?),
        }
    }

    /// Whether it holds more than any control.
    pub(super) fn is_full(&self) -> bool {
        self.tables.len() > MOST_TABLES || self.machine.len() > MOST_DATA
    }

    /// Machine data that were written act from here on.
    pub(super) fn activate(&mut self) {
        self.waiting = None;
    }

    /// A switch that does not act when a kit's file has run. Machine data of that class wait
    /// for NEWCONF or a reset (classes: 840Di sl Commissioning Manual 05/2008 p. 356; that MD32700 and MD32710
    /// are of it is assumed).
    pub(super) fn waiting(&mut self) -> Option<String> {
        self.waiting.take().filter(|_| self.writer == Writer::Kit)
    }

    fn note_value(&mut self, set: &Assignment<'_>) {
        let value = match &set.value {
            Ok(Value::Number(number)) => number.to_string(),
            Ok(Value::Truth(truth)) => u8::from(*truth).to_string(),
            Ok(Value::Name(name)) => name.clone(),
            Err(_) => return,
        };
        let variable = variable_text(&set.name, &plain_indices(set));
        let old = self.values.insert(variable.clone(), value.clone());
        if old.is_some_and(|old| old != value) {
            self.twice.insert(variable);
        }
    }

    fn set_table(
        &mut self,
        name: TableName,
        parameter: &'static str,
        variable: &Variable<'_>,
        set: &Assignment<'_>,
    ) -> Result<(), Complaint> {
        let switch = match &name {
            TableName::Lec { axis, encoder } => {
                Some(("MA_ENC_COMP_ENABLE", vec![encoder.to_string(), axis.clone()]))
            }
            TableName::Cec(_) => None,
        };
        let draft = self.tables.entry(name).or_default();
        if draft.head.is_empty() {
            draft.head = set.head.clone();
        }
        match variable.value(set) {
            Ok(value) => draft.put(parameter, variable.point, value, set, self.writer),
            Err(_) if draft.complaints.len() >= MOST_COMPLAINTS => {}
            Err(complaint) => draft.complaints.push(complaint),
        }
        let (switch, indices) = switch.unwrap_or_else(|| {
            let output = draft.name("_OUTPUT_AXIS");
            ("MA_CEC_ENABLE", output.into_iter().collect())
        });
        if self.writer == Writer::Control || draft.protected {
            return Ok(());
        }
        draft.protected = self.machine.iter().any(|datum| {
            let on = matches!(datum.value, MachineValue::Number(number) if number > 0.0);
            datum.name == switch && datum.indices == indices && on
        });
        match draft.protected {
            true => Err(protected(set, switch)),
            false => Ok(()),
        }
    }

    fn set_machine(&mut self, set: &Assignment<'_>, value: Value) -> Result<(), Complaint> {
        let value = match value {
            Value::Number(number) => MachineValue::Number(number),
            Value::Truth(truth) => MachineValue::Number(f64::from(u8::from(truth))),
            Value::Name(name) => MachineValue::Text(name),
        };
        let datum = MachineDatum { name: set.name.to_string(), indices: plain_indices(set), value };
        let waits = datum.name.starts_with("MA_") && is_switch(&datum.name);
        if waits && self.waiting.is_none() {
            self.waiting = Some(datum.variable());
        }
        let mut known = self.machine.iter_mut();
        match known.find(|known| known.name == datum.name && known.indices == datum.indices) {
            Some(known) => known.value = datum.value,
            None => self.machine.push(datum),
        }
        Ok(())
    }

    /// The tables and data, if nothing is missing; complaints are added to `complaints`.
    pub(super) fn finish(self, complaints: &mut Vec<Complaint>) -> SiemensContents {
        let too_many = self.too_many_points();
        let mut all = SiemensContents { machine_data: self.machine, ..SiemensContents::default() };
        all.read_out.twice = self.twice.into_iter().collect();
        if let Some(complaint) = too_many {
            complaints.push(complaint);
            return all;
        }
        for (name, draft) in self.tables {
            let step = draft.parameters.get("_STEP").map(Placed::number);
            if self.writer == Writer::Control && step.is_some_and(|step| step.abs() <= 0.0) {
                // The control reserves memory for the table and nobody filled it.
                all.read_out.without_grid.push(name.to_string());
            } else {
                draft.finish(name, self.writer, &mut all, complaints);
            }
        }
        all
    }

    /// A few lines may ask for many points: MIN, STEP and MAX.
    fn too_many_points(&self) -> Option<Complaint> {
        let steps = |draft: &Draft| {
            let steps = draft.stated_grid()?.steps();
            (0.0..MOST_POINTS).contains(&steps).then_some(steps)
        };
        let points: f64 = self.tables.values().filter_map(steps).sum();
        let head = self.tables.values().next()?.head.clone();
        let is_too_many = points > MOST_STATEMENTS as f64;
        is_too_many.then(|| {
            Complaint::new(
                head,
                format!("the tables would have {points:.0} points together, expected at most {MOST_STATEMENTS}"),
                "no control holds so many; correct MIN, STEP or MAX",
            )
        })
    }
}

impl Draft {
    fn put(
        &mut self,
        parameter: &'static str,
        point: u32,
        value: Value,
        set: &Assignment<'_>,
        writer: Writer,
    ) {
        let span = set.value_span.clone();
        let placed = Placed { value, span };
        if parameter.is_empty() {
            self.points.insert(point, placed);
            return;
        }
        // Of two steps that a control wrote, the one that gives a grid; two values are told.
        let keeps_old = writer == Writer::Control
            && parameter == "_STEP"
            && placed.number().abs() <= 0.0
            && self.parameters.contains_key(parameter);
        if !keeps_old {
            self.parameters.insert(parameter, placed);
        }
    }

    fn name(&self, parameter: &str) -> Option<String> {
        match &self.parameters.get(parameter)?.value {
            Value::Name(name) => Some(name.clone()),
            _ => None,
        }
    }

    /// A number that is read as 0 where no line writes it.
    fn number(&self, parameter: &str) -> f64 {
        self.parameters.get(parameter).map_or(0.0, Placed::number)
    }

    fn direction(&self) -> CecDirection {
        match self.number("_DIRECTION") {
            plus if plus > 0.0 => CecDirection::Plus,
            minus if minus < 0.0 => CecDirection::Minus,
            _ => CecDirection::Both,
        }
    }

    /// MIN, STEP and MAX, where all three are written.
    fn stated_grid(&self) -> Option<SiemensGrid> {
        let number = |parameter| self.parameters.get(parameter).map(Placed::number);
        Some(SiemensGrid { min: number("_MIN")?, step: number("_STEP")?, max: number("_MAX")? })
    }

    /// Adds the table to what the file holds; a control writes tables that nobody filled, too.
    fn finish(
        mut self,
        name: TableName,
        writer: Writer,
        all: &mut SiemensContents,
        complaints: &mut Vec<Complaint>,
    ) {
        let variable = format!("${name}");
        let lacking = name.optional().iter();
        let lacking = lacking.filter(|field| !self.parameters.contains_key(**field));
        all.unwritten.extend(lacking.map(|field| format!("{} of {variable}", &field[1..])));
        let is_readable = self.complaints.is_empty();
        let content = self.content(&variable, writer);
        let is_zero = self.points.values().all(|placed| placed.number().abs() <= 0.0);
        if content.is_none() && writer != Writer::Kit && is_zero && is_readable {
            all.idle.push(name.to_string());
            return;
        }
        let input = self.name("_INPUT_AXIS");
        let output = self.name("_OUTPUT_AXIS");
        if matches!(name, TableName::Cec(_)) && is_readable {
            self.missing(&variable, &["_INPUT_AXIS", "_OUTPUT_AXIS"]);
        }
        complaints.append(&mut self.complaints);
        let Some((grid, values)) = content else {
            return;
        };
        let modulo = self.number("_IS_MODULO") > 0.0;
        match (name, input, output) {
            (TableName::Lec { axis, encoder }, _, _) => {
                all.tables.lec.push(LecTable { encoder, axis, grid, values, modulo })
            }
            (TableName::Cec(number), Some(input_axis), Some(output_axis)) => {
                all.tables.cec.push(CecTable {
                    number,
                    input_axis,
                    output_axis,
                    grid,
                    values,
                    direction: self.direction(),
                    multiply_by: table_number(self.number("_MULT_BY_TABLE")),
                    modulo,
                });
            }
            _ => {}
        }
    }

    /// Complains of parameters that no line writes; where a line could not be read, it may be that one.
    fn missing(&mut self, name: &str, parameters: &[&str]) {
        let lacking = parameters.iter();
        for field in lacking.filter(|field| !self.parameters.contains_key(**field)) {
            self.complaints.push(Complaint::new(
                self.head.clone(),
                format!("{} of {name} is missing", &field[1..]),
                "write it in the same file as the points",
            ));
        }
    }

    /// Grid and values; a control writes reserved points behind MAX too, which have no effect.
    fn content(&mut self, name: &str, writer: Writer) -> Option<(SiemensGrid, Vec<Option<f64>>)> {
        let Some(grid) = self.stated_grid() else {
            if self.complaints.is_empty() {
                self.missing(name, &["_MIN", "_STEP", "_MAX"]);
            }
            return None;
        };
        let last = match self.last_point(name, grid, writer) {
            Ok(last) => last,
            Err((parameter, message, help)) => {
                let span = self.parameters[parameter].span.clone();
                self.complaints.push(Complaint::new(span, message, help));
                return None;
            }
        };
        let behind = self.points.range(last + 1..);
        for (point, placed) in behind.filter(|_| writer == Writer::Kit) {
            self.complaints.push(Complaint::new(
                placed.span.clone(),
                format!("{name} has point {point}, but MIN, STEP and MAX give points 0 to {last}"),
                "remove the point or correct MIN, STEP or MAX",
            ));
        }
        let value = |point| self.points.get(&point).map(Placed::number);
        Some((grid, (0..=last).map(value).collect()))
    }

    /// Index of the last point; else the parameter that is wrong, what is and what to do. Where MAX of a
    /// control's table lies between two points, that of the one behind MAX, if it is there: it may be part
    /// of what the control computes.
    fn last_point(
        &self,
        name: &str,
        grid: SiemensGrid,
        writer: Writer,
    ) -> Result<u32, (&'static str, String, &'static str)> {
        let SiemensGrid { min, step, max } = grid;
        let steps = grid.steps();
        if step <= 0.0 {
            let message = format!("STEP of {name} is {step}, it must be greater than 0");
            return Err(("_STEP", message, "write the distance of two points"));
        }
        if max <= min {
            let message = format!("MAX of {name} is {max}, not greater than MIN {min}");
            let help = "MIN is the position of point 0, MAX that of the last point";
            return Err(("_MAX", message, help));
        }
        if steps >= MOST_POINTS {
            let message = format!("{name} would have {steps:.0} points");
            let help = "no control holds so many; correct MIN, STEP or MAX";
            return Err(("_STEP", message, help));
        }
        let last = grid.last_whole_point();
        if last >= 1 && grid.is_whole() {
            return Ok(last);
        }
        if last < 1 || writer == Writer::Kit {
            let message =
                format!("(MAX-MIN)/STEP of {name} is {steps}, expected a whole number from 1");
            let help = "the last point must lie on MAX; controls differ in what they do otherwise";
            return Err(("_STEP", message, help));
        }
        Ok(last + u32::from(self.points.contains_key(&(last + 1))))
    }
}

/// A table that is switched on is write-protected: alarm 17070 (808D Function Manual
/// 01/2017 p. 109). Told once for each table.
fn protected(set: &Assignment<'_>, switch: &str) -> Complaint {
    Complaint::new(
        set.head.clone(),
        format!("the table is written while `${switch}` is 1; the control stops with alarm 17070"),
        format!("set `${switch}` to 0 before the table and to 1 after it"),
    )
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the variable takes whole numbers from 0 to 1000"
)]
fn table_number(number: f64) -> u32 {
    number as u32
}

/// Indices, of which `01` and `1` are the same.
fn plain_indices(set: &Assignment<'_>) -> Vec<String> {
    let plain = set.indices.iter().map(|index| match index.parse::<u32>() {
        Ok(number) => number.to_string(),
        Err(_) => index.to_string(),
    });
    plain.collect()
}
