//! ENC_COMP and CEC tables by their names.

pub(super) mod machine_data;

use crate::control::table::siemens::{
    CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables,
};
use crate::judge::disagreement::Diagnosis;
use crate::judge::disagreement::contents::words::{it, listed, runs, same};

/// Surplus, missing and other tables.
pub(super) fn tables(
    wanted: &SiemensTables,
    found: &SiemensTables,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    let mut words = lec(wanted, found, diagnosis);
    words.extend(cec(wanted, found, diagnosis));
    words
}

fn lec(
    wanted: &SiemensTables,
    found: &SiemensTables,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    let explained = |axis: &str| diagnosis.is_some_and(|d| d.explains(axis, axis));
    let of_axis = |tables: &SiemensTables, axis: &str| tables.lec.iter().any(|t| t.axis == axis);
    let same_place = |a: &LecTable, b: &LecTable| a.axis == b.axis && a.encoder == b.encoder;
    let mut words = Vec::new();
    for table in &found.lec {
        // A table of the other measuring system is told as such (`measuring_systems`).
        if !of_axis(wanted, &table.axis) && !explained(&table.axis) {
            words.push(format!("{}: the job does not write it", lec_name(table)));
        }
    }
    if diagnosis.is_none() {
        return words;
    }
    for table in wanted.lec.iter().filter(|t| !explained(&t.axis)) {
        match found.lec.iter().find(|other| same_place(other, table)) {
            Some(got) => words.extend(other_contents(
                &lec_name(table),
                (&lec_fields(got), &got.values),
                (&lec_fields(table), &table.values),
            )),
            None if of_axis(found, &table.axis) => {}
            None => words.push(format!("{}: missing, the job writes it", lec_name(table))),
        }
    }
    words
}

fn cec(
    wanted: &SiemensTables,
    found: &SiemensTables,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    let explained = |table: &CecTable| {
        diagnosis.is_some_and(|d| d.explains(&table.input_axis, &table.output_axis))
    };
    let mut words = Vec::new();
    for table in &found.cec {
        if !wanted.cec.iter().any(|t| t.number == table.number) {
            words.push(format!(
                "CEC table {} ({} while {} moves): the job does not write it",
                table.number, table.output_axis, table.input_axis
            ));
        }
    }
    if diagnosis.is_none() {
        return words;
    }
    for table in wanted.cec.iter().filter(|table| !explained(table)) {
        let name = format!("CEC table {}", table.number);
        match found.cec.iter().find(|t| t.number == table.number) {
            Some(got) if explained(got) => {}
            Some(got) => words.extend(other_contents(
                &name,
                (&cec_fields(got), &got.values),
                (&cec_fields(table), &table.values),
            )),
            None => words.push(format!("{name}: missing, the job writes it")),
        }
    }
    words
}

/// Parameters that no file writes, in a sentence: the tables are judged as if they were 0.
pub(super) fn unwritten(parameters: &[String]) -> Option<String> {
    (!parameters.is_empty()).then(|| {
        format!(
            "no file writes {}: the control keeps what it holds there, the job writes {}",
            listed(parameters),
            it(parameters.len())
        )
    })
}

fn lec_name(table: &LecTable) -> String {
    format!("ENC_COMP[{},{}]", table.encoder, table.axis)
}

/// A parameter of a table by name.
type Field = (&'static str, String);

fn grid_fields(grid: SiemensGrid, modulo: bool) -> Vec<Field> {
    // Rounded, so that numbers that are equal read alike.
    let number = |value: f64| format!("{}", (value * 1e9).round() / 1e9 + 0.0);
    vec![
        ("MIN", number(grid.min)),
        ("STEP", number(grid.step)),
        ("MAX", number(grid.max)),
        ("IS_MODULO", u8::from(modulo).to_string()),
    ]
}

fn lec_fields(table: &LecTable) -> Vec<Field> {
    grid_fields(table.grid, table.modulo)
}

fn cec_fields(table: &CecTable) -> Vec<Field> {
    let direction = match table.direction {
        CecDirection::Both => "0",
        CecDirection::Plus => "1",
        CecDirection::Minus => "-1",
    };
    let mut fields = grid_fields(table.grid, table.modulo);
    fields.extend([
        ("INPUT_AXIS", table.input_axis.clone()),
        ("OUTPUT_AXIS", table.output_axis.clone()),
        ("DIRECTION", direction.to_string()),
        ("MULT_BY_TABLE", table.multiply_by.to_string()),
    ]);
    fields
}

/// Parameters and values of a table.
type Contents<'a> = (&'a [Field], &'a [Option<f64>]);

/// Differences of a table that have no effect on an axis of the job.
fn other_contents(name: &str, found: Contents<'_>, wanted: Contents<'_>) -> Option<String> {
    let fields: Vec<String> = found
        .0
        .iter()
        .zip(wanted.0)
        .filter(|(got, wanted)| got != wanted)
        .map(|(got, wanted)| format!("{} is {}, the job writes {}", got.0, got.1, wanted.1))
        .collect();
    if !fields.is_empty() {
        return Some(format!("{name}: {}", fields.join("; ")));
    }
    let equal = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => same(a, b),
        (a, b) => a.is_none() == b.is_none(),
    };
    let numbers: Vec<u32> = (0_u32..)
        .zip(found.1.iter().zip(wanted.1))
        .filter(|(_, (got, wanted))| !equal(**got, **wanted))
        .map(|(number, _)| number)
        .collect();
    let points = runs(&numbers);
    (!numbers.is_empty()).then(|| format!("{name}, {points}: other values than the job writes"))
}
