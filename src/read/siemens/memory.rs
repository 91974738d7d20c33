//! Assignments of one file gathered into tables: the meaning of the variables.
//!
//! A table is complete when its file ends; until then its parameters and points may come in any
//! order and the last assignment of each counts (Function Manual Extended Functions 03/2013, K3
//! p. 240-249: the assignments are independent statements).

use super::contents::{Cell, SiemensContents, is_switch, variable};
use super::statement::Assignment;
use crate::control::table::siemens::{
    MachineDatum, MachineValue, Place, SiemensGrid, SiemensTable,
};
use crate::quantity::Direction;
use crate::read::lexer::{Complaint, MOST_COMPLAINTS};
use crate::read::refusals;
use std::collections::BTreeMap;
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Writer {
    /// A program or a person, for a control to load.
    #[default]
    Kit,
    /// The same, with tables as a control held them.
    Rollback,
    /// The control, which writes all that it holds.
    Control,
}

/// Parameters of which the control keeps an older value where no line writes them.
fn optional(place: &Place) -> &'static [&'static str] {
    match place {
        Place::Lec { .. } => &["_IS_MODULO"],
        Place::Cec(_) => &["_IS_MODULO", "_DIRECTION", "_MULT_BY_TABLE"],
    }
}

/// A value and where it stands.
#[derive(Clone, Debug)]
struct CellValue {
    value: MachineValue,
    span: Range<usize>,
}

impl CellValue {
    fn number(&self) -> f64 {
        self.value.number().unwrap_or(f64::NAN) // of parameters that are none
    }

    fn is_zero(&self) -> bool {
        self.number().abs() <= 0.0
    }
}

/// A table while its file is being read.
#[derive(Debug, Default)]
struct TableDraft {
    writer: Writer,
    head: Range<usize>,
    /// What could not be read of it.
    complaints: Vec<Complaint>,
    protected: bool,
    cells: BTreeMap<Cell, CellValue>,
}

/// The tables and machine data of one file while it is being read.
#[derive(Debug, Default)]
pub(super) struct Memory {
    writer: Writer,
    tables: BTreeMap<Place, TableDraft>,
    /// The first switch behind the last `NEWCONF`.
    pub(super) waiting: Option<String>,
    /// Whether a switch was on.
    was_on: bool,
    /// What is known before the end of the file.
    pub(super) all: SiemensContents,
}

impl Memory {
    pub(super) fn new(writer: Writer) -> Memory {
        Memory { writer, ..Memory::default() }
    }

    /// Carries out one assignment.
    pub(super) fn set(&mut self, set: &Assignment<'_>) -> Result<(), Complaint> {
        let variable = variable(set)?;
        let value = variable.value(set);
        match variable.cell(set) {
            Some((place, cell)) => self.set_table(place, cell, value, set),
            None => {
                self.set_machine(MachineDatum { variable: set.variable(), value: value? });
                Ok(())
            }
        }
    }

    /// Whether it holds more than any control.
    pub(super) fn is_full(&self) -> bool {
        self.tables.len() > MOST_TABLES || self.all.tables.data.len() > MOST_DATA
    }

    /// A switch that does not act when a kit's file has run. Machine data of that class wait
    /// for NEWCONF or a reset (classes: 840Di sl Commissioning Manual 05/2008 p. 356; that MD32700 and MD32710
    /// are of it is assumed).
    pub(super) fn waiting(&mut self) -> Option<String> {
        self.waiting.take().filter(|_| self.writer == Writer::Kit)
    }

    fn set_table(
        &mut self,
        place: Place,
        cell: Cell,
        value: Result<MachineValue, Complaint>,
        set: &Assignment<'_>,
    ) -> Result<(), Complaint> {
        let begin = || TableDraft { writer: self.writer, ..TableDraft::default() };
        let draft = self.tables.entry(place.clone()).or_insert_with(begin);
        if draft.head.is_empty() {
            draft.head = set.head.clone();
        }
        match value {
            Ok(value) => {
                if draft.put(cell, CellValue { value, span: set.value_span.clone() }) {
                    self.all.twice.insert(set.variable());
                }
            }
            Err(_) if draft.complaints.len() >= MOST_COMPLAINTS => {}
            Err(complaint) => draft.complaints.push(complaint),
        }
        if self.writer == Writer::Control || draft.protected || !self.was_on {
            return Ok(());
        }
        let (switch, index) = match place {
            Place::Lec { .. } => ("$MA_ENC_COMP_ENABLE", place.index()),
            Place::Cec(_) => ("$MA_CEC_ENABLE", draft.name("_OUTPUT_AXIS").unwrap_or_default()),
        };
        let switched = self.all.tables.datum(&format!("{switch}[{index}]"));
        draft.protected = switched.and_then(|on| on.value.number()).is_some_and(|on| on > 0.0);
        // Alarm 17070 (808D Function Manual 01/2017 p. 109). Told once for each table.
        match draft.protected {
            true => Err(Complaint::new(set.head.clone(), refusals::protected(switch))),
            false => Ok(()),
        }
    }

    fn set_machine(&mut self, datum: MachineDatum) {
        self.was_on |=
            is_switch(&datum.variable) && datum.value.number().is_some_and(|on| on > 0.0);
        if datum.variable.starts_with("$MA_") && is_switch(&datum.variable) {
            self.waiting.get_or_insert_with(|| datum.variable.clone());
        }
        let MachineDatum { variable, value } = datum.clone();
        let is_other = self.all.tables.set(datum).is_some_and(|old| old != value);
        if is_other && self.writer == Writer::Control {
            self.all.twice.insert(variable);
        }
    }

    /// The tables and data, if nothing is missing; complaints are added to `complaints`.
    pub(super) fn finish(mut self, complaints: &mut Vec<Complaint>) -> SiemensContents {
        if let Some(complaint) = self.too_many_points() {
            complaints.push(complaint);
            return self.all;
        }
        for (place, draft) in self.tables {
            if self.writer == Writer::Control && draft.cell("_STEP").is_some_and(CellValue::is_zero)
            {
                // The control reserves memory for the table and nobody filled it.
                self.all.tables.reserved.push(place.to_string());
            } else {
                draft.finish(place, &mut self.all, complaints);
            }
        }
        self.all
    }

    /// A few lines may ask for many points: MIN, STEP and MAX.
    fn too_many_points(&self) -> Option<Complaint> {
        let steps = |draft: &TableDraft| {
            let steps = draft.stated_grid()?.steps();
            (0.0..MOST_POINTS).contains(&steps).then_some(steps)
        };
        let points: f64 = self.tables.values().filter_map(steps).sum();
        let head = self.tables.values().next()?.head.clone();
        let is_too_many = points > MOST_STATEMENTS as f64;
        is_too_many
            .then(|| Complaint::new(head, refusals::points_together(points, MOST_STATEMENTS)))
    }
}

impl TableDraft {
    /// Sets a cell; gives whether a control holds two values of it. Of two steps that a control wrote, the one
    /// that gives a grid counts.
    fn put(&mut self, cell: Cell, placed: CellValue) -> bool {
        let of_control = self.cells.get(&cell).filter(|_| self.writer == Writer::Control);
        let is_other = of_control.is_some_and(|old| old.value != placed.value);
        if !(cell.0 == "_STEP" && of_control.is_some() && placed.is_zero()) {
            self.cells.insert(cell, placed);
        }
        is_other
    }

    fn cell(&self, parameter: &'static str) -> Option<&CellValue> {
        self.cells.get(&(parameter, 0))
    }

    fn name(&self, parameter: &'static str) -> Option<String> {
        match &self.cell(parameter)?.value {
            MachineValue::Text(name) => Some(name.clone()),
            MachineValue::Number(_) => None,
        }
    }

    /// A number that is read as 0 where no line writes it.
    fn number(&self, parameter: &'static str) -> f64 {
        self.cell(parameter).map_or(0.0, CellValue::number)
    }

    fn direction(&self) -> Option<Direction> {
        match self.number("_DIRECTION") {
            plus if plus > 0.0 => Some(Direction::Plus),
            minus if minus < 0.0 => Some(Direction::Minus),
            _ => None,
        }
    }

    /// MIN, STEP and MAX, where all three are written.
    fn stated_grid(&self) -> Option<SiemensGrid> {
        let [min, step, max] =
            ["_MIN", "_STEP", "_MAX"].map(|of| self.cell(of).map(CellValue::number));
        Some(SiemensGrid { min: min?, step: step?, max: max? })
    }

    /// Points from this one on.
    fn points(&self, first: u32) -> impl Iterator<Item = (u32, &CellValue)> {
        self.cells.range(("", first)..=("", u32::MAX)).map(|((_, point), placed)| (*point, placed))
    }

    /// Adds the table to what the file holds; a control writes tables that nobody filled, too.
    fn finish(mut self, place: Place, all: &mut SiemensContents, complaints: &mut Vec<Complaint>) {
        let variable = format!("${place}");
        let lacking = optional(&place).iter().filter(|field| self.cell(field).is_none());
        all.unwritten.extend(lacking.map(|field| format!("{} of {variable}", &field[1..])));
        let is_readable = self.complaints.is_empty();
        let content = self.content(&variable);
        let is_zero = self.points(0).all(|(_, placed)| placed.is_zero());
        if content.is_none() && self.writer != Writer::Kit && is_zero && is_readable {
            all.idle.push(place.to_string());
            all.tables.reserved.push(place.to_string());
            return;
        }
        let axes = match &place {
            Place::Lec { axis, .. } => [axis, axis].map(|axis| Some(axis.clone())),
            Place::Cec(_) => {
                let names = ["_INPUT_AXIS", "_OUTPUT_AXIS"];
                if is_readable {
                    self.missing(&variable, &names);
                }
                names.map(|name| self.name(name))
            }
        };
        complaints.append(&mut self.complaints);
        if let (Some((grid, values)), [Some(input_axis), Some(output_axis)]) = (content, axes) {
            all.tables.tables.push(SiemensTable {
                place,
                input_axis,
                output_axis,
                grid,
                values,
                direction: self.direction(),
                multiply_by: table_number(self.number("_MULT_BY_TABLE")),
                modulo: self.number("_IS_MODULO") > 0.0,
            });
        }
    }

    /// Complains of parameters that no line writes; where a line could not be read, it may be that one.
    fn missing(&mut self, name: &str, parameters: &[&'static str]) {
        for field in parameters.iter().filter(|field| !self.cells.contains_key(&(**field, 0))) {
            let missing = refusals::parameter_missing(&field[1..], name);
            self.complaints.push(Complaint::new(self.head.clone(), missing));
        }
    }

    /// Grid and values; a control writes reserved points behind MAX too, which have no effect.
    fn content(&mut self, name: &str) -> Option<(SiemensGrid, Vec<Option<f64>>)> {
        let Some(grid) = self.stated_grid() else {
            if self.complaints.is_empty() {
                self.missing(name, &["_MIN", "_STEP", "_MAX"]);
            }
            return None;
        };
        let last = self.last_point(name, grid);
        let last = last.map_err(|complaint| self.complaints.push(complaint)).ok()?;
        let behind = self.points(last + 1).filter(|_| self.writer == Writer::Kit);
        let behind = behind.map(|(point, placed)| {
            Complaint::new(placed.span.clone(), refusals::point_behind(name, point, last))
        });
        let behind: Vec<Complaint> = behind.collect();
        self.complaints.extend(behind);
        let value = |point| self.cells.get(&("", point)).map(CellValue::number);
        Some((grid, (0..=last).map(value).collect()))
    }

    /// Index of the last point; else what is wrong with MIN, STEP and MAX. Where MAX of a
    /// control's table lies between two points, that of the one behind MAX, if it is there: it may be part
    /// of what the control computes.
    fn last_point(&self, name: &str, grid: SiemensGrid) -> Result<u32, Complaint> {
        let wrong = |parameter, problem| {
            let span = self.cell(parameter).map_or(self.head.clone(), |of| of.span.clone());
            Err(Complaint::new(span, problem))
        };
        let SiemensGrid { min, step, max } = grid;
        let steps = grid.steps();
        if step <= 0.0 {
            return wrong("_STEP", refusals::no_step(name, step));
        }
        if max <= min {
            return wrong("_MAX", refusals::max_not_above(name, max, min));
        }
        if steps >= MOST_POINTS {
            return wrong("_STEP", refusals::many_points(name, steps));
        }
        let last = grid.last_whole_point();
        if last >= 1 && grid.is_whole() {
            return Ok(last);
        }
        if last < 1 || self.writer == Writer::Kit {
            return wrong("_STEP", refusals::no_whole_steps(name, steps));
        }
        Ok(last + u32::from(self.cells.contains_key(&("", last + 1))))
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the variable takes whole numbers from 0 to 1000"
)]
fn table_number(number: f64) -> u32 {
    number as u32
}
