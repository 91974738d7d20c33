//! Siemens: reader of `$AA_ENC_COMP`, `$AN_CEC` and their machine data, and what the control does with them.
//!
//! ```text
//!   text ── statement (one line) ── variable ── memory (tables of the file) ── merge (tables of the kit)
//! ```
//! Reads both ways in which tables are delivered: a part program (ends with `M30`, `M17` or `M2`)
//! and NC active data (`%_N_…_INI`, `;$PATH=…`, `CHANDATA(1)`, ends with `M17`); Function Manual
//! Extended Functions 03/2013, K3 p. 240-249, and HMI Advanced Operator's Guide 03.04. Of what a control
//! wrote of itself it takes the lines of concern ([`read_out`]). It is
//! written from these documents alone and knows nothing of the program's own templates.
//!
//! It accepts what a control accepts (any case, blanks, block numbers, integers, LF or CRLF) and
//! refuses with line and column what stops a control, what could move the machine, and what the
//! documents leave open.

mod contents;
mod control;
mod memory;

mod statement;

pub(crate) use self::contents::is_switch;
use self::contents::{Concern, concern, header, is_archive, is_program, sections};
pub use self::contents::{SiemensContents, merge};
use self::memory::{MOST_DATA, MOST_STATEMENTS, MOST_TABLES, Memory, Writer};
use self::statement::{BLANKS, Statement, check_characters, code_of, is_end, statement};
use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, Role, SiemensFacts};
use crate::control::table::Tables;
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, FileData, READ_OUT_AS_A_WHOLE, ReadBack};
use crate::read::findings::ReadFinding;
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located};
use crate::read::program::blocks::Cancelled::*;
use crate::read::program::blocks::Meaning::*;
use crate::read::program::blocks::{Code, Meaning, Vocabulary};
use crate::read::refusals;
use crate::text::{Problem, Problems, refuse_long_lines, shown};
use part_program::Language;
use std::ops::Range;

impl Family for SiemensFacts {
    /// A rollback holds a control's own tables, with their grids as they were.
    fn read_kit(&self, texts: &[(&str, &str)], roles: &[Role]) -> Result<ReadBack, Problems> {
        let is_rollback = roles.iter().all(|role| *role == Role::Rollback);
        let writer = if is_rollback { Writer::Rollback } else { Writer::Kit };
        let read = |(name, text): &(&str, &str)| Reader::new(writer, name, text).strict();
        let contents = Problems::all(texts.iter().map(read))?;
        let data = texts.iter().zip(roles).zip(&contents).map(|(((path, _), role), own)| {
            FileData { path: path.to_string(), role: *role, data: own.tables.data.clone() }
        });
        let machine_data = data.collect();
        let SiemensContents { mut tables, notes, unwritten, .. } = merge(contents)?;
        tables.reserved.clear();
        if !is_rollback {
            tables.data.clear(); // its files switch on and off
        }
        Ok(ReadBack { tables: Tables::Siemens(tables), notes, unwritten, machine_data })
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(control::control(tables.own(), self, state)?))
    }

    /// A program of whatever kind has an end word.
    fn may_obey(&self, text: &str) -> bool {
        let is_end_word = |line: Range<usize>| {
            is_end(&text[code_of(text, &line)].trim_matches(BLANKS).to_ascii_uppercase())
        };
        text.contains('$') || lines(text).any(is_end_word)
    }

    fn is_whole(&self, text: &str) -> bool {
        let passed_over = |line: &Range<usize>| concern(text, line).0 == Concern::PassedOver;
        lines(text).filter(passed_over).count() > READ_OUT_AS_A_WHOLE
    }

    fn refusal(&self, name: &str, bytes: &[u8]) -> Option<Problem> {
        is_archive(bytes).then(|| refusals::archive(shown(name)))
    }
}

/// Reads one file of a kit.
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
/// assert_eq!(contents.tables.tables[0].values, [Some(0.001), Some(0.0)]);
/// ```
pub fn read(file_name: &str, text: &str) -> Result<SiemensContents, Problems> {
    Reader::new(Writer::Kit, file_name, text).strict()
}

/// Reads a file that a control wrote of itself, of one or of several sections: what concerns the
/// compensation, the rest ignored. Part programs are read where no file of the read-out holds active
/// data.
///
/// **limits** reserved points behind MAX have no effect and are left out, and MAX may lie between two points
/// ([`crate::control::table::siemens::SiemensTable::close`]): then the point behind it is kept where it is there. End words
/// between sections are ignored, but data behind the last one are refused: a file that goes
/// on without one is not complete
pub fn read_out(
    file_name: &str,
    text: &str,
    reads_programs: bool,
) -> Result<SiemensContents, Problems> {
    Reader::new(Writer::Control, file_name, text).lenient(reads_programs)
}

/// Whether a file holds active data: an assignment outside part programs.
pub fn has_active_data(file: &str, text: &str) -> bool {
    let mut data = sections(file, text).filter(|(_, program)| program.is_none());
    data.any(|(line, _)| {
        let (concern, code) = concern(text, &line);
        let is_assignment = || text[code].contains('=');
        match concern {
            Concern::PassedOver => true,
            Concern::Table | Concern::Data => is_assignment(),
            _ => false,
        }
    })
}

/// A file while it is being read.
#[derive(Default)]
struct Reader<'a> {
    file: &'a str,
    text: &'a str,
    memory: Memory,
    complaints: Vec<Complaint>,
    statements: usize,
    ended: bool,
}

impl<'a> Reader<'a> {
    fn new(writer: Writer, file: &'a str, text: &'a str) -> Self {
        Reader { file, text, memory: Memory::new(writer), ..Reader::default() }
    }

    /// Reads every line: a word that is not known could move the machine.
    fn strict(mut self) -> Result<SiemensContents, Problems> {
        refuse_long_lines(self.file, self.text)?;
        self.complaints.extend(destination(self.text).err());
        for line in lines(self.text) {
            if self.is_full(&line) {
                return self.finish();
            }
            let code = code_of(self.text, &line);
            let result = check_characters(self.text, &line, &code);
            let result = result.and_then(|()| self.carry_out(code));
            self.complaints.extend(result.err());
        }
        if !self.ended {
            self.complaints.push(no_end(self.text.len()));
        }
        self.finish()
    }

    /// Whether nothing more is read.
    fn is_full(&mut self, line: &Range<usize>) -> bool {
        let has_too_many = self.statements > MOST_STATEMENTS || self.memory.is_full();
        if has_too_many {
            let wrong = refusals::much_data(MOST_STATEMENTS, MOST_TABLES, MOST_DATA);
            self.complaints.push(Complaint::new(line.clone(), wrong));
        }
        has_too_many || self.complaints.len() >= MOST_COMPLAINTS
    }

    fn carry_out(&mut self, code: Range<usize>) -> Result<(), Complaint> {
        let found = statement(self.text, code.clone())?;
        let is_blank = || self.text[code.clone()].trim_matches(BLANKS).is_empty();
        if matches!(found, Statement::Nothing) && (!self.ended || is_blank()) {
            return Ok(());
        }
        self.statements += 1;
        if self.ended {
            return Err(Complaint::new(code, refusals::after_end()));
        }
        match found {
            Statement::Nothing => {}
            Statement::End => self.ended = true,
            Statement::Stop => {
                let file = self.file.to_string();
                self.memory.all.notes.push(ReadFinding::Stops { file }.into());
            }
            Statement::Activate => self.memory.waiting = None,
            Statement::Set(set) => self.memory.set(&set)?,
        }
        Ok(())
    }

    /// Reads what is of concern.
    fn lenient(mut self, reads_programs: bool) -> Result<SiemensContents, Problems> {
        refuse_long_lines(self.file, self.text)?;
        let mut behind_end = Vec::new();
        let (mut has_headers, mut has_data) = (false, false);
        for (line, program) in sections(self.file, self.text) {
            if self.is_full(&line) {
                return self.finish();
            }
            if header(&self.text[line.clone()]).is_some() {
                has_headers = true;
                self.memory.all.programs.extend(program.map(str::to_string));
            }
            let (concern, code) = concern(self.text, &line);
            self.memory.all.programs_write_tables |= program.is_some() && concern == Concern::Table;
            if program.is_some() && !reads_programs {
                continue;
            }
            match concern {
                Concern::Nothing => continue,
                Concern::PassedOver => self.memory.all.passed_over += 1,
                Concern::Unit(unit) if self.memory.all.units.contains(&unit) => {}
                Concern::Unit(unit) => self.memory.all.units.push(unit),
                Concern::End => {
                    self.ended = true;
                    behind_end.clear();
                    continue;
                }
                Concern::Table | Concern::Data => {
                    self.statements += 1;
                    let result = check_characters(self.text, &code, &code).and_then(|()| {
                        match statement(self.text, code.clone())? {
                            Statement::Set(set) => self.memory.set(&set),
                            _ => Ok(()),
                        }
                    });
                    self.complaints.extend(result.err());
                }
            }
            has_data = true;
            if self.ended
                && behind_end.len() < MOST_COMPLAINTS
                && !matches!(concern, Concern::Unit(_))
            {
                behind_end.push(Complaint::new(code, refusals::after_end()));
            }
        }
        if !has_headers && is_program(self.file) {
            self.memory.all.programs.push(self.file.to_string());
        }
        self.complaints.append(&mut behind_end);
        if !self.ended && (has_data || self.memory.all.programs.is_empty()) {
            self.complaints.push(no_end(self.text.len()));
        }
        self.finish()
    }

    fn finish(mut self) -> Result<SiemensContents, Problems> {
        if let Some(variable) = self.memory.waiting() {
            let file = self.file.to_string();
            self.memory.all.notes.push(ReadFinding::ActsLater { file, variable }.into());
        }
        let contents = self.memory.finish(&mut self.complaints);
        located(self.file, self.text, self.complaints).or_ok(contents)
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
        Some(folder) if is_data && folder.trim_end() != "/_N_NC_ACT_DIR" => {
            Err(Complaint::new(path, refusals::goes_elsewhere()))
        }
        _ => Ok(()),
    }
}

fn no_end(end: usize) -> Complaint {
    Complaint::new(end..end, refusals::no_end_word())
}

// SINUMERIK part programs of measuring runs: `;` begins a comment, `MSG("…")` is a text for the screen.

/// Its language (Programming Manual).
pub(in crate::read) const VOCABULARY: Vocabulary =
    Vocabulary { language: Language::Siemens, words: &WORDS, blocks };

/// G60 (exact stop) does not change where the axes go.
const WORDS: [(&str, Meaning); 12] = [
    ("G60", Neutral),
    ("D0", Cancel(ToolLength)),
    ("G500", Cancel(Offset)),
    ("TRANS", Cancel(Shift)),
    ("ROT", Cancel(Rotation)),
    ("SCALE", Cancel(Scaling)),
    ("MIRROR", Cancel(Mirroring)),
    ("TRAFOOF", Cancel(Transformation)),
    ("G700", Unit(ControlUnit::Inch)),
    ("G710", Unit(ControlUnit::Millimetre)),
    ("SUPA", Machine),
    ("M30", End),
];

fn blocks(text: &str) -> Result<Vec<Code>, Complaint> {
    let code = |line: std::ops::Range<usize>| {
        let whole = text[line.clone()].trim_end();
        let code = whole.split(';').next().unwrap_or("");
        (!is_message(whole)).then(|| (line.start, code.to_string()))
    };
    Ok(lines(text).filter_map(code).collect())
}

/// `MSG("text")` shows a text, `MSG()` takes it away; nothing moves.
fn is_message(line: &str) -> bool {
    let inside = line.strip_prefix("MSG(");
    let Some(inside) = inside.and_then(|rest| rest.strip_suffix(')')) else {
        return false;
    };
    let text = inside.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    inside.is_empty() || text.is_some_and(|text| !text.contains('"'))
}

#[cfg(test)]
mod tests;
