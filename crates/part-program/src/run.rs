//! A whole program: lines, subprograms, and the end.
//!
//! The main program begins with the text and ends with M2, M30, M99, a second `%` or the text; a
//! subprogram that `%` or the end of the text breaks off is a problem.
//! Subprograms follow it, each from `O…` to M99. Jumps go to lines by the index of [`jumps`](super::jumps).

mod calls;

use crate::block::{Block, CALL};
use crate::flow::{Flow, begin, statement};
use crate::interpreter::Interpreter;
use crate::jumps::Index;
use crate::lines::{Line, Mark, Text, without_mark};
use crate::notes::notes;
use crate::variables::Variables;
use crate::wrong::{Excerpt, Refused, Span, Wrong};
use crate::{Move, Setup};
use std::collections::BTreeSet;

/// Problems that are told of one program.
const MOST_PROBLEMS: usize = 20;
/// Work that a program asks for beyond its own lines: blocks of subprograms, holes that a cycle repeats (K, L),
/// and the millimetres that both go, as a path is followed in such steps. The lines of a file end by themselves,
/// however large it is; this many blocks are hours of a control (a thousand in a second are many) and
/// seconds here. The largest programs seen have 60 MB, three million blocks and 10 km, and may stand in
/// a subprogram as a whole.
const MOST_REPEATED: f64 = 2e7;

/// What was executed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ran {
    /// Blocks, with all repeats.
    pub blocks: u64,
    /// Holes of canned cycles.
    pub holes: u64,
    /// What a person has to know of how the program was understood.
    pub notes: Vec<String>,
}

/// Executes a program; `follow` gets every move. All problems are given, up to a number; after
/// one of them the moves are those of the blocks that could be executed.
pub fn run(
    text: &mut dyn Text,
    setup: &Setup,
    mut follow: impl FnMut(&Move) -> Result<(), Refused>,
) -> Result<Ran, Vec<Refused>> {
    let interpreter = Interpreter::new(setup);
    let mut control = Control { interpreter, ..Control::default() };
    let ended = control.execute(text, &mut follow);
    control.close(ended)
}

/// A call that is being executed.
struct Call {
    program: u32,
    /// The block that calls.
    line: usize,
    begin: Mark,
    back: Mark,
    /// Runs after this one.
    left: u32,
}

#[derive(Default)]
struct Control {
    interpreter: Interpreter,
    problems: Vec<Refused>,
    /// Lines and bytes at which something is wrong.
    found: BTreeSet<(usize, usize)>,
    calls: Vec<Call>,
    index: Option<Index>,
    variables: Variables,
    /// A line was gone to that may stand before: lines count as repeated.
    jumped: bool,
    blocks: u64,
    /// Of [`MOST_REPEATED`].
    repeated: f64,
    deletable: u64,
    percent: bool,
    begun: bool,
    /// The next line is that of a subprogram's `O`.
    entered: bool,
}

type Follow<'f> = &'f mut dyn FnMut(&Move) -> Result<(), Refused>;

impl Control {
    fn execute(&mut self, text: &mut dyn Text, follow: Follow<'_>) -> Result<(), Refused> {
        let mut block = Block::default();
        while self.found.len() < MOST_PROBLEMS {
            let Some(line) = text.next_line()? else {
                return self.ended();
            };
            let (flow, place) = self.line(without_mark(line), &mut block, follow)?;
            match flow {
                Flow::Next => {}
                Flow::End => return Ok(()),
                Flow::TextEnd => return self.ended(),
                Flow::Return if self.calls.is_empty() => return Ok(()),
                Flow::Return => self.go_back(text)?,
                _ => self.go(text, flow, place)?,
            }
        }
        Ok(())
    }

    /// Executes a line; where it leads elsewhere, with the place that says so.
    #[inline]
    fn line(
        &mut self,
        line: Line<'_>,
        block: &mut Block,
        follow: Follow<'_>,
    ) -> Result<(Flow, Option<Excerpt>), Refused> {
        self.blocks += 1;
        let language = self.interpreter.setup.language;
        if let Some(at) = begin(line.bytes, language) {
            let flow = self.statement(line, at)?;
            return Ok((flow, Some(excerpt(line, (at, line.bytes.len())))));
        }
        block.read(line.bytes, language, &self.variables);
        if block.percent {
            // The first `%` begins the text, the next one ends it.
            let is_end = self.begun || std::mem::replace(&mut self.percent, true);
            return Ok((if is_end { Flow::TextEnd } else { Flow::Next }, None));
        }
        if block.delete && self.is_left_out() {
            return Ok((Flow::Next, None));
        }
        if std::mem::take(&mut self.entered) {
            block.value(b'O');
        }
        if !self.begun && block.wrong.is_empty() {
            // The first O word names the main program.
            self.begun =
                block.value(b'O').is_some() || block.has_any(b"XYZ") || !block.g.is_empty();
        }
        let holes = self.interpreter.tally.holes;
        let flow = self.interpreter.block(block, line.number);
        if let Some(wrong) = self.interpreter.turning.take() {
            self.problems.clear(); // what else was found follows from it
            return Err(refused(line, &wrong));
        }
        self.follow(block, holes, line.number, follow)?;
        for wrong in &block.wrong {
            if self.found.insert((line.number, wrong.span.0)) {
                self.problems.push(refused(line, wrong));
            }
        }
        let call = block.m_word(CALL).filter(|_| matches!(flow, Flow::Call(..)));
        Ok((flow, call.map(|word| excerpt(line, word.span))))
    }

    /// Counts a line that begins with `/`; whether it is left out.
    fn is_left_out(&mut self) -> bool {
        self.deletable += 1;
        self.interpreter.setup.skip_deletable
    }

    /// Executes a line that sets variables or decides what comes next.
    fn statement(&mut self, line: Line<'_>, at: usize) -> Result<Flow, Refused> {
        if line.bytes.trim_ascii_start().first() == Some(&b'/') && self.is_left_out() {
            return Ok(Flow::Next);
        }
        self.begun = true;
        if self.is_repeated() {
            self.count(0, 0.0, line.number)?;
        }
        // Where it is wrong, what follows would be judged by a value that is not known, and a loop might not end.
        let executed =
            statement(line.bytes, at, self.interpreter.setup.language, &mut self.variables);
        executed.map_err(|wrong| refused(line, &wrong))
    }

    fn is_repeated(&self) -> bool {
        self.jumped || !self.calls.is_empty()
    }

    /// Follows the moves of a block to the first one that is refused. They count where the block is one
    /// of a subprogram or repeats holes.
    #[inline]
    fn follow(
        &mut self,
        block: &mut Block,
        holes: u64,
        line: usize,
        follow: Follow<'_>,
    ) -> Result<(), Refused> {
        let holes = self.interpreter.tally.holes - holes;
        let repeats = self.is_repeated() || holes > 1;
        let mut length_mm = 0.0;
        for (step, span) in self.interpreter.moves.drain(..) {
            if repeats {
                length_mm += step.length_mm();
            }
            if let Err(refused) = follow(&step) {
                if block.wrong.is_empty() {
                    let help = refused.help.unwrap_or_default();
                    block.wrong.push(Wrong::new(span, refused.message, help)); // else it may follow from what is wrong already
                }
                break;
            }
        }
        if repeats {
            self.count(holes, length_mm, line)?;
        }
        Ok(())
    }

    fn count(&mut self, holes: u64, length_mm: f64, line: usize) -> Result<(), Refused> {
        self.repeated += 1.0 + holes as f64 + length_mm;
        if self.repeated <= MOST_REPEATED {
            return Ok(());
        }
        let line = self.calls.first().map_or(line, |call| call.line);
        let message = format!(
            "the repeats of subprograms, loops and cycles make more than {MOST_REPEATED} blocks and mm; the last of them begin in line {line}"
        );
        let help = "check the numbers of repeats (L and P of M98, K and L of cycles), and the conditions of loops";
        Err(Refused::new(message).help(help))
    }

    /// The text is over.
    fn ended(&self) -> Result<(), Refused> {
        let Some(call) = self.calls.last() else {
            return Ok(());
        };
        let message = format!("subprogram O{} ends without M99", call.program);
        Err(Refused::new(message).help("end it with M99, before the text or `%` ends it"))
    }

    fn close(mut self, ended: Result<(), Refused>) -> Result<Ran, Vec<Refused>> {
        self.problems.extend(ended.err());
        if self.found.len() >= MOST_PROBLEMS {
            let message =
                format!("reading stopped after {MOST_PROBLEMS} problems; there may be more");
            self.problems.push(Refused::new(message));
        }
        if !self.problems.is_empty() {
            return Err(self.problems);
        }
        let tally = &self.interpreter.tally;
        let notes = notes(tally, self.deletable, &self.interpreter.setup);
        Ok(Ran { blocks: self.blocks, holes: tally.holes, notes })
    }
}

fn refused(line: Line<'_>, wrong: &Wrong) -> Refused {
    Refused::new(&*wrong.message).at(excerpt(line, wrong.span)).help(&*wrong.help)
}

/// Bytes of a line; those that are no UTF-8 (comments) are shown as such.
fn excerpt(line: Line<'_>, (start, end): Span) -> Excerpt {
    let length = |bytes: usize| {
        let part = line.bytes.get(..bytes).unwrap_or(line.bytes);
        String::from_utf8_lossy(part).len()
    };
    let text = String::from_utf8_lossy(line.bytes).into_owned();
    Excerpt { line: line.number, text, span: (length(start), length(end)) }
}
