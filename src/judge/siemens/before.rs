//! What a kit changes on a Siemens control: tables, their switches, weights and limit, MD32450.

use super::data::{BACKLASH, CEC_LIMIT, CEC_ON, Datum, LEC_ON, TABLE_ON, WEIGHT};
use crate::control::table::Tables;
use crate::control::table::siemens::{LecTable, SiemensTables};
use crate::judge::before::{Before, ChangedBy, Lacking, Old, unknown};
use crate::quantity::axis::Axis;
use crate::write::siemens::encoder;
use ChangedBy::{File, Nobody, Precondition};

/// In which order the rollback sets machine data: what makes tables act comes last.
const ORDER: [Datum; 6] = [BACKLASH, CEC_LIMIT, WEIGHT, LEC_ON, TABLE_ON, CEC_ON];

/// A machine or setting datum that a kit changes.
struct Changed {
    datum: Datum,
    indices: Vec<String>,
    by: ChangedBy,
}

/// Of the tables of a kit, of those held and of those that acted.
pub(super) fn old(
    before: &Before<'_>,
    [kit, held, acted]: [&SiemensTables; 3],
) -> Result<Old, Vec<String>> {
    let is_off = |datum: Datum, indices: &[String]| before.held.is_off(datum.1, indices);
    let mut gathered = Gathered::default();
    for table in &kit.lec {
        let found = held.lec.iter().find(|t| is_place(t, table));
        let (name, off) = (table.name(), || is_off(LEC_ON, &lec_indices(table)));
        let values = found.map(|found| found.values.as_slice());
        if gathered.takes(before, &name, format!("AA_{name}"), values, off) {
            gathered.tables.lec.extend(found.cloned());
        }
    }
    for table in &kit.cec {
        let found = held.cec.iter().find(|t| t.number == table.number);
        let output = std::slice::from_ref(&table.output_axis);
        let off = || is_off(TABLE_ON, &[table.number.to_string()]) || is_off(CEC_ON, output);
        let variable = format!("AN_CEC[{}]", table.number);
        let values = found.map(|found| found.values.as_slice());
        if gathered.takes(before, &table.name(), variable, values, off) {
            gathered.tables.cec.extend(found.cloned());
        }
    }
    if !gathered.missing.is_empty() {
        return Err(gathered.missing);
    }
    Ok(gathered.with_data(before, changed(before, kit, acted)))
}

/// Old tables, and what of them is missing.
#[derive(Default)]
struct Gathered {
    tables: SiemensTables,
    missing: Vec<String>,
    stays: Vec<String>,
}

impl Gathered {
    /// Whether a table that was read out is whole. One that was reserved without a grid and is off
    /// may keep the values of the kit.
    fn takes(
        &mut self,
        before: &Before<'_>,
        name: &str,
        variable: String,
        values: Option<&[Option<f64>]>,
        is_off: impl Fn() -> bool,
    ) -> bool {
        match values {
            Some(values) if values.iter().all(Option::is_some) => return true,
            None if before.held.without_grid.contains(&variable) => {
                if is_off() {
                    self.stays.push(name.to_string());
                } else {
                    self.missing
                        .push(format!("{name} (read out without a grid, and not as switched off)"));
                }
            }
            _ => self.missing.push(name.to_string()),
        }
        false
    }

    fn with_data(self, before: &Before<'_>, changed: Vec<Changed>) -> Old {
        let found = |c: &Changed| before.held.datum(c.datum.1, &c.indices).cloned();
        let lacking = changed.iter().filter(|c| c.by != Nobody && found(c).is_none());
        let lacking = lacking.map(|c| -> Lacking {
            let ((number, name), index) = (c.datum, format!("[{}]", c.indices.join(",")));
            (format!("{number} ${name}"), index, c.by)
        });
        Old {
            tables: Tables::Siemens(self.tables),
            data: changed.iter().filter_map(found).collect(),
            unknown: unknown(lacking),
            stays: self.stays,
        }
    }
}

fn is_place(one: &LecTable, other: &LecTable) -> bool {
    one.axis == other.axis && one.encoder == other.encoder
}

fn lec_indices(table: &LecTable) -> [String; 2] {
    [table.encoder.to_string(), table.axis.clone()]
}

/// All machine data that change when the kit is loaded as its checklist says, each once.
fn changed(before: &Before<'_>, kit: &SiemensTables, acted: &SiemensTables) -> Vec<Changed> {
    let mut all: Vec<Changed> = Vec::new();
    let mut add = |datum: Datum, indices: Vec<String>, by: ChangedBy| {
        let known = |c: &&mut Changed| c.datum == datum && c.indices == indices;
        match all.iter_mut().find(known) {
            Some(known) if known.by == Nobody => known.by = by,
            Some(_) => {}
            None => all.push(Changed { datum, indices, by }),
        }
    };
    for table in &kit.lec {
        add(LEC_ON, lec_indices(table).to_vec(), File);
    }
    for table in &kit.cec {
        let number = vec![table.number.to_string()];
        add(TABLE_ON, number.clone(), File);
        add(CEC_ON, vec![table.output_axis.clone()], File);
        add(CEC_LIMIT, vec![table.output_axis.clone()], Precondition);
        add(WEIGHT, number, Precondition);
    }
    // Old tables that would act in addition to the new ones have to be switched off.
    for table in &acted.lec {
        if !kit.lec.iter().any(|new| is_place(new, table)) {
            add(LEC_ON, lec_indices(table).to_vec(), Precondition);
        }
    }
    for table in &acted.cec {
        add(TABLE_ON, vec![table.number.to_string()], Precondition);
    }
    for axis in Axis::ALL {
        for (datum, system, by) in of_axis(before, axis) {
            for own in &before.plan.names[axis] {
                add(datum, vec![system.to_string(), own.to_uppercase()], by);
            }
        }
    }
    let place = |c: &Changed| ORDER.iter().position(|datum| *datum == c.datum);
    all.sort_by_key(place);
    all
}

/// What the positioning tables of an axis change beside their switches: name, measuring system, by
/// whom.
fn of_axis(before: &Before<'_>, axis: Axis) -> Vec<(Datum, u32, ChangedBy)> {
    let own = |t: &&crate::write::plan::PlannedTable| t.term.is_positioning() && t.term.of == axis;
    let mut tables = before.plan.tables.iter().filter(own).peekable();
    if tables.peek().is_none() {
        return Vec::new();
    }
    let system = encoder(before.task, axis);
    let parameter = if before.plan.sets_backlash(axis) { Precondition } else { Nobody };
    let mut list = vec![(BACKLASH, system, parameter)];
    if tables.any(|t| t.direction.is_some()) {
        // The error is in CEC tables: no ENC_COMP table of the axis may act.
        list.push((LEC_ON, system, Precondition));
        list.push((LEC_ON, 1 - system.min(1), Nobody));
    }
    list
}
