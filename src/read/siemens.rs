//! Reader of Siemens compensation files: `$AA_ENC_COMP`, `$AN_CEC` and their machine data.
//!
//! ```text
//!   text ── statement (one line) ── variable ── memory (tables of the file) ── merge (tables of the kit)
//! ```
//! Reads both ways in which tables are delivered: a part program (ends with `M30`, `M17` or `M2`)
//! and NC active data (`%_N_…_INI`, `;$PATH=…`, `CHANDATA(1)`, ends with `M17`); Function Manual
//! Extended Functions 03/2013, K3 p. 240-249, and HMI Advanced Operator's Guide 03.04. It is
//! written from these documents alone and knows nothing of the program's own templates.
//!
//! It accepts what a control accepts (any case, blanks, block numbers, integers, LF or CRLF) and
//! refuses with line and column what stops a control, what could move the machine, and what the
//! documents leave open.

mod assignment;
mod contents;
pub mod control;
mod memory;
mod statement;
mod variable;

pub(super) use self::contents::variable_text;
use self::contents::{MOST_DATA, MOST_TABLES, Writer};
pub use self::contents::{MOST_STATEMENTS, MachineDatum, MachineValue, SiemensContents, is_switch};

use self::control::SiemensControl;
use crate::control::control_state::ControlState;
use crate::control::controller::{Role, SiemensFacts};
use crate::control::table::Tables;
use crate::control::table::siemens::{CecTable, LecTable, SiemensGrid};
use crate::read::control_data;
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::family::{Family, FileData, KitText, ReadBack, each, other_family};
use crate::read::lexer::Complaint;
use crate::text::plain::is_unseen;
use crate::text::problem::{LineIndex, Problem, Problems, refuse_long_lines};
use memory::Memory;
use statement::{Statement, statement};
use std::ops::Range;

impl Family for SiemensFacts {
    /// A rollback holds a control's own tables, with their grids as they were.
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        let is_rollback = files.iter().all(|file| file.role == Role::Rollback);
        let contents = each(files, if is_rollback { read_out } else { read })?;
        let data = files
            .iter()
            .zip(&contents)
            .map(|(file, contents)| FileData {
                path: file.path.to_string(),
                role: file.role,
                data: contents.machine_data.clone(),
            });
        let machine_data = data.collect();
        let merged = merge(contents)?;
        Ok(ReadBack {
            tables: Tables::Siemens(merged.tables),
            notes: merged.notes,
            unwritten: merged.unwritten,
            machine_data,
        })
    }

    fn control(
        &self,
        tables: &Tables,
        state: &ControlState,
    ) -> Result<Box<dyn Emulator>, CannotEmulate> {
        let Tables::Siemens(tables) = tables else {
            return Err(other_family());
        };
        Ok(Box::new(SiemensControl::new(tables, self, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        text.contains('$')
    }

    fn passed_over(&self, text: &str) -> usize {
        control_data::siemens("", text, true).passed_over
    }
}

/// Reads one file.
///
/// **shape** points 0 to k = (MAX−MIN)/STEP; a point the file does not write is `None` ·
/// **unit** and **sign** as in the file · **source** see the module · **limits** a ratio further
/// than 1e-3 from a whole number is refused, controls differ in what they do with it; so is every
/// word outside the grammar; after 200 problems it stops looking for more.
///
/// ```
/// let text = "$AN_CEC[0,0]=0.001\n$AN_CEC[0,1]=0\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n\
///             $AN_CEC_OUTPUT_AXIS[0]=(AX2)\n$AN_CEC_STEP[0]=50\n$AN_CEC_MIN[0]=0\n\
///             $AN_CEC_MAX[0]=50\nM30\n";
/// let contents = nonius::read::siemens::read("cec.mpf", text).unwrap();
/// assert_eq!(contents.tables.cec[0].values, [Some(0.001), Some(0.0)]);
/// ```
pub fn read(file_name: &str, text: &str) -> Result<SiemensContents, Problems> {
    read_from(Writer::Kit, file_name, text)
}

/// Reads a file that a control wrote of itself; as [`read`], but reserved points behind MAX have no
/// effect and are left out, and MAX may lie between two points ([`crate::control::table::siemens::closed`]):
/// then the point behind it is kept where it is there.
pub fn read_out(file_name: &str, text: &str) -> Result<SiemensContents, Problems> {
    // Comments are in the letters of the control's language, in whatever bytes: no control obeys them.
    let is_seen = |c: char| !is_unseen(c) || matches!(c, '\n' | '\r' | '\t');
    let seen = text.chars();
    let seen: String = seen
        .map(|c| {
            if is_seen(c) {
                c
            } else {
                char::REPLACEMENT_CHARACTER
            }
        })
        .collect();
    read_from(Writer::Control, file_name, &seen)
}

fn read_from(writer: Writer, file_name: &str, text: &str) -> Result<SiemensContents, Problems> {
    refuse_long_lines(file_name, text)?;
    let mut complaints = Vec::new();
    let mut memory = Memory::default();
    read_lines((file_name, text), &mut memory, &mut complaints);
    memory.note_waiting(writer, file_name);
    let contents = memory.finish(writer, &mut complaints);
    complaints.sort_by_key(|complaint| complaint.span.start);
    let mut problems = Problems::none();
    let index = LineIndex::default();
    for Complaint {
        span,
        message,
        help,
    } in complaints
    {
        problems.push_with(|| {
            let place = index.place(file_name, text, span.start, span.end);
            Problem::new(message).at(place).help(help)
        });
    }
    problems.or_ok(contents)
}

fn read_lines(
    (file_name, text): (&str, &str),
    memory: &mut Memory,
    complaints: &mut Vec<Complaint>,
) {
    const MOST_COMPLAINTS: usize = 200; // nobody reads further, and a binary file has millions
    let mut ended = false;
    complaints.extend(destination(text).err());
    let mut statements = 0;
    for line in lines(text) {
        if complaints.len() >= MOST_COMPLAINTS {
            return;
        }
        if statements > MOST_STATEMENTS || memory.is_full() {
            return complaints.push(too_many(line));
        }
        let result = match statement(text, line.clone()) {
            Ok(Statement::Nothing) if ended && has_code(text, &line) => Err(after_end(line)),
            Ok(Statement::Nothing) => continue,
            Ok(_) if ended => Err(after_end(line)),
            Ok(Statement::End) => {
                ended = true;
                Ok(())
            }
            Ok(Statement::Stop) => {
                memory.note(format!(
                    "`{file_name}`: M0 waits for cycle start before the program goes on"
                ));
                Ok(())
            }
            Ok(Statement::Activate) => {
                memory.activate();
                Ok(())
            }
            Ok(Statement::Set(set)) => memory.set(&set),
            Err(complaint) => Err(complaint),
        };
        statements += 1;
        complaints.extend(result.err());
    }
    if !ended {
        complaints.push(Complaint::new(
            text.len()..text.len(),
            "the file has no end word; it is not complete",
            "a compensation file ends with `M17` or `M30`: transfer it again, or take it out of the directory if it is no file of the control",
        ));
    }
}

/// A `;$PATH=` behind a `%_N_…_INI` says where the data go: only in this folder do they act (HMI Advanced
/// Operator's Guide 03.04, p. 369-370).
fn destination(text: &str) -> Result<(), Complaint> {
    let mut lines = lines(text);
    let (Some(header), Some(path)) = (lines.next(), lines.next()) else {
        return Ok(());
    };
    let header = text[header].trim_end().to_ascii_uppercase();
    let is_data = header.starts_with("%_N_") && header.ends_with("_INI");
    let named = text[path.clone()].to_ascii_uppercase();
    match named.strip_prefix(";$PATH=") {
        Some(folder) if is_data && folder.trim_end() != "/_N_NC_ACT_DIR" => Err(Complaint::new(
            path,
            "the file does not go to the active data of the control",
            "write `;$PATH=/_N_NC_ACT_DIR`, or leave the line out",
        )),
        _ => Ok(()),
    }
}

fn has_code(text: &str, line: &Range<usize>) -> bool {
    let code = text[line.clone()].split(';').next().unwrap_or("");
    !code.trim_matches([' ', '\t', '&']).is_empty()
}

fn too_many(line: Range<usize>) -> Complaint {
    Complaint::new(
        line,
        format!(
            "here are more than {MOST_STATEMENTS} statements, {MOST_TABLES} tables or {MOST_DATA} machine data of the compensation, too many for any control"
        ),
        "check that this is a file of the control",
    )
}

fn after_end(line: Range<usize>) -> Complaint {
    Complaint::new(
        line,
        "a statement follows the end word",
        "the control does not read on; move the end word to the end of the file",
    )
}

/// The lines as bytes of the text, without LF and the CRs before it.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    text.as_bytes()
        .split(|byte| *byte == b'\n')
        .map(move |line| {
            let start = at;
            at += line.len() + 1;
            let returns = line.iter().rev().take_while(|byte| **byte == b'\r');
            start..start + line.len() - returns.count()
        })
}

/// Puts the files of a kit into one memory, in the order in which they are loaded.
///
/// A point or parameter that two files write with different values is a problem, because the
/// result would depend on the order of loading. The switches `ENC_COMP_ENABLE`, `CEC_ENABLE` and
/// `CEC_TABLE_ENABLE` are made for being changed: of these the last one counts.
pub fn merge(contents: Vec<SiemensContents>) -> Result<SiemensContents, Problems> {
    let mut problems = Problems::none();
    let mut all = SiemensContents::default();
    for file in contents {
        for table in file.tables.lec {
            merge_lec(&mut all.tables.lec, table, &mut problems);
        }
        for table in file.tables.cec {
            merge_cec(&mut all.tables.cec, table, &mut problems);
        }
        for datum in file.machine_data {
            merge_datum(&mut all.machine_data, datum, &mut problems);
        }
        all.notes.extend(file.notes);
        all.unwritten.extend(file.unwritten);
        all.idle.extend(file.idle);
    }
    let place = |table: &LecTable| (table.axis.clone(), table.encoder);
    all.tables.lec.sort_by_key(place);
    all.tables.cec.sort_by_key(|table| table.number);
    problems.or_ok(all)
}

fn merge_lec(all: &mut Vec<LecTable>, table: LecTable, problems: &mut Problems) {
    let same = |known: &&mut LecTable| known.axis == table.axis && known.encoder == table.encoder;
    let Some(known) = all.iter_mut().find(same) else {
        all.push(table);
        return;
    };
    let name = format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis);
    if !same_grid(known.grid, table.grid) || known.modulo != table.modulo {
        problems.push(conflict(&format!("the parameters of {name}")));
        return;
    }
    merge_values(&name, &mut known.values, &table.values, problems);
}

fn merge_cec(all: &mut Vec<CecTable>, table: CecTable, problems: &mut Problems) {
    let Some(known) = all.iter_mut().find(|known| known.number == table.number) else {
        all.push(table);
        return;
    };
    let name = format!("$AN_CEC[{}]", table.number);
    let parameters = |of: &CecTable| {
        (
            of.input_axis.clone(),
            of.output_axis.clone(),
            of.direction,
            of.multiply_by,
            of.modulo,
        )
    };
    if !same_grid(known.grid, table.grid) || parameters(known) != parameters(&table) {
        problems.push(conflict(&format!("the parameters of {name}")));
        return;
    }
    merge_values(&name, &mut known.values, &table.values, problems);
}

fn merge_values(
    name: &str,
    known: &mut [Option<f64>],
    values: &[Option<f64>],
    problems: &mut Problems,
) {
    for (point, (known, value)) in known.iter_mut().zip(values).enumerate() {
        match (*known, *value) {
            (Some(a), Some(b)) if !same_number(a, b) => {
                problems.push(conflict(&format!("point {point} of {name} ({a} and {b})")));
            }
            (None, Some(_)) => *known = *value,
            _ => {}
        }
    }
}

fn merge_datum(all: &mut Vec<MachineDatum>, datum: MachineDatum, problems: &mut Problems) {
    let same =
        |known: &&mut MachineDatum| known.name == datum.name && known.indices == datum.indices;
    match all.iter_mut().find(same) {
        None => all.push(datum),
        Some(known) if is_switch(&datum.name) => known.value = datum.value,
        Some(known) if known.value == datum.value => {}
        Some(_) => {
            problems.push(conflict(&datum.variable()));
        }
    }
}

fn conflict(what: &str) -> Problem {
    Problem::new(format!("two files write {what} with different values"))
        .help("what the control holds would depend on the order of loading; remove one of the two")
}

fn same_grid(a: SiemensGrid, b: SiemensGrid) -> bool {
    same_number(a.min, b.min) && same_number(a.step, b.step) && same_number(a.max, b.max)
}

/// Whether two numbers of files are the same; exact, as both were read from decimal digits.
fn same_number(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.0
}

#[cfg(test)]
mod tests;
