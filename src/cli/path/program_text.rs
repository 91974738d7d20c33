//! A part program on disk, read line by line.

use crate::inputs::nc::{Line, Mark, Text};
use crate::text::problem::Problem;
use crate::visit::files::{Files, Long, plain_words};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// No control reads a longer line.
const LONGEST_LINE: u64 = 4096;
/// Filled again whenever a subprogram is called or ends that is not in it.
const BUFFER_BYTES: usize = 1 << 16;

/// A program that is open.
pub(super) struct ProgramText {
    name: String,
    reader: BufReader<Box<dyn Long>>,
    line: Vec<u8>,
    mark: Mark,
}

impl ProgramText {
    /// Opens a file; `-` = standard input.
    pub(super) fn open(files: &dyn Files, path: &Path) -> Result<ProgramText, Problem> {
        let (name, long) = files.long(path).map_err(|problem| match problem.help {
            Some(_) => problem,
            None => problem.help("check the path of the part program"),
        })?;
        Ok(ProgramText {
            name,
            reader: BufReader::with_capacity(BUFFER_BYTES, long),
            line: Vec::new(),
            mark: Mark::default(),
        })
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }
}

fn failed(name: &str, error: &std::io::Error) -> Problem {
    Problem::new(format!("`{name}` cannot be read: {}", plain_words(error)))
}

impl Text for ProgramText {
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Problem> {
        self.line.clear();
        let mut part = (&mut self.reader).take(LONGEST_LINE);
        let read =
            part.read_until(b'\n', &mut self.line).map_err(|error| failed(&self.name, &error))?;
        if read == 0 {
            return Ok(None);
        }
        let ended = self.line.last() == Some(&b'\n');
        if !ended && self.line.len() as u64 == LONGEST_LINE {
            let number = self.mark.lines + 1;
            return Err(Problem::new(format!(
                "line {number} of `{}` has more than {LONGEST_LINE} characters, expected the blocks of a part program",
                self.name
            ))
            .help("check that the file is a part program with one block in each line, ended by LF or CR LF"));
        }
        self.mark.bytes += read as u64;
        self.mark.lines += 1;
        let end = self.line.len() - usize::from(ended);
        Ok(Some(Line { number: self.mark.lines, bytes: &self.line[..end] }))
    }

    fn mark(&self) -> Mark {
        self.mark
    }

    fn go_to(&mut self, mark: Mark) -> Result<(), Problem> {
        let by = i64::try_from(mark.bytes).ok();
        let here = i64::try_from(self.mark.bytes).ok();
        // What is in the buffer is not read again.
        let moved = match by.zip(here) {
            Some((to, here)) => self.reader.seek_relative(to - here),
            None => self.reader.seek(SeekFrom::Start(mark.bytes)).map(|_| ()),
        };
        moved.map_err(|error| failed(&self.name, &error))?;
        self.mark = mark;
        Ok(())
    }
}
