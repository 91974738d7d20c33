//! A whole program: lines, subprograms, and the end.
//!
//! The main program begins with the text and ends with M2, M30, M99, a second `%` or the text; a
//! subprogram that `%` or the end of the text breaks off is a problem.
//! Subprograms follow it, each from `O…` to M99. Jumps go to lines by the index of [`jumps`](super::jumps).

mod calls;

use crate::block::{Block, CALL, Span};
use crate::flow::{self, Statement};
use crate::interpreter::{Flow, Interpreter};
use crate::jumps::Index;
use crate::lines::{Line, Mark, Text, without_mark};
use crate::notes::notes;
use crate::siemens;
use crate::variables::Variables;
use crate::wrong::Excerpt;
use crate::wrong::Wrong;
use crate::{Language, Move, Refused, Setup};
use std::collections::BTreeSet;

/// Vec<Refused> that are told of one program.
const MOST_PROBLEMS: usize = 20;
/// Calls inside each other; controls have 4 to 10.
const DEEPEST_CALLS: usize = 16;
/// Work that a program asks for beyond its own lines: blocks of subprograms, holes that a cycle repeats (K, L),
/// and the millimetres that both go, as a path is followed in such steps. The lines of a file end by themselves,
/// however large it is; this many blocks are hours of a control (a thousand in a second are many) and
/// seconds here. The largest programs seen have 60 MB, three million blocks and 10 km, and may stand in
/// a subprogram as a whole.
const MOST_REPEATED: f64 = 2e7;
/// What a line counts that is passed over in search of a block.
const PASSED: f64 = 0.1;
/// What a call and a return count: the text is taken up again elsewhere, which takes as long as this many blocks.
const JUMP: f64 = 10.0;

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
    let mut control = Control {
        setup,
        interpreter: Interpreter::new(setup),
        problems: Vec::new(),
        found: BTreeSet::new(),
        calls: Vec::new(),
        index: None,
        variables: Variables::default(),
        jumped: false,
        blocks: 0,
        repeated: 0.0,
        deletable: 0,
        percent: false,
        begun: false,
        entered: false,
    };
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

struct Control<'s> {
    setup: &'s Setup,
    interpreter: Interpreter<'s>,
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

/// What a line asks of the text.
enum Next {
    Line,
    Call(u32, u32, Excerpt),
    Statement(Statement, Excerpt),
    Return,
    /// M2, M30.
    End,
    /// The second `%`.
    TextEnd,
}

type Follow<'f> = &'f mut dyn FnMut(&Move) -> Result<(), Refused>;

impl Control<'_> {
    fn execute(&mut self, text: &mut dyn Text, follow: Follow<'_>) -> Result<(), Refused> {
        let mut block = Block::new();
        while self.found.len() < MOST_PROBLEMS {
            let Some(line) = text.next_line()? else {
                return self.ended();
            };
            match self.line(without_mark(line), &mut block, follow)? {
                Next::Line => {}
                Next::End => return Ok(()),
                Next::TextEnd => return self.ended(),
                Next::Return if self.calls.is_empty() => return Ok(()),
                Next::Return => self.go_back(text)?,
                Next::Call(_, 0, _) => {}
                Next::Call(program, times, place) => {
                    self.call(text, program, times, place)?;
                }
                Next::Statement(statement, place) => self.go(text, statement, place)?,
            }
        }
        Ok(())
    }

    /// Executes a line.
    #[inline]
    fn line(
        &mut self,
        line: Line<'_>,
        block: &mut Block,
        follow: Follow<'_>,
    ) -> Result<Next, Refused> {
        self.blocks += 1;
        if let Some(at) = self.statement_at(line.bytes) {
            return self.statement(line, at);
        }
        self.read(line.bytes, block);
        if block.percent {
            // The first `%` begins the text, the next one ends it.
            let is_end = self.begun || std::mem::replace(&mut self.percent, true);
            return Ok(if is_end { Next::TextEnd } else { Next::Line });
        }
        if block.delete {
            self.deletable += 1;
            if self.setup.skip_deletable {
                return Ok(Next::Line);
            }
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
            return Err(Control::problem(line, &wrong));
        }
        self.follow(block, holes, line.number, follow)?;
        for wrong in &block.wrong {
            if self.found.insert((line.number, wrong.start)) {
                self.problems.push(Control::problem(line, wrong));
            }
        }
        Ok(match flow {
            Flow::Next => Next::Line,
            Flow::Return => Next::Return,
            Flow::End => Next::End,
            Flow::Call { program, times } => {
                let span = block.m_word(CALL).map_or((0, 1), |word| word.span);
                Next::Call(program, times, Control::place(line, span))
            }
        })
    }

    /// Where a line begins that is none of words.
    #[inline]
    fn statement_at(&self, line: &[u8]) -> Option<usize> {
        match self.setup.language {
            Language::Iso => flow::begin(line),
            Language::Siemens => siemens::begin(line),
        }
    }

    #[inline]
    fn read(&self, line: &[u8], block: &mut Block) {
        match self.setup.language {
            Language::Iso => block.read(line, &self.variables),
            Language::Siemens => siemens::read(block, line, &self.variables),
        }
    }

    /// Executes a line that sets variables or decides what comes next.
    fn statement(&mut self, line: Line<'_>, at: usize) -> Result<Next, Refused> {
        if line.bytes.trim_ascii_start().first() == Some(&b'/') {
            self.deletable += 1;
            if self.setup.skip_deletable {
                return Ok(Next::Line);
            }
        }
        self.begun = true;
        if self.is_repeated() {
            self.count(0, 0.0, line.number)?;
        }
        let executed = match self.setup.language {
            Language::Iso => flow::statement(line.bytes, at, &mut self.variables),
            Language::Siemens => siemens::statement(line.bytes, at, &mut self.variables),
        };
        match executed {
            Ok(statement) => {
                let place = Control::place(line, (at, line.bytes.len()));
                Ok(Next::Statement(statement, place))
            }
            // What follows would be judged by a value that is not known, and a loop might not end.
            Err(wrong) => Err(Control::problem(line, &wrong)),
        }
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
                    let wrong = Wrong::new(span, refused.message, refused.help.unwrap_or_default());
                    block.wrong.push(wrong); // else it may follow from what is wrong already
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
    fn ended(&mut self) -> Result<(), Refused> {
        let Some(call) = self.calls.last() else {
            return Ok(());
        };
        let message = format!("subprogram O{} ends without M99", call.program);
        let help = "end it with M99, before the text or `%` ends it";
        Err(Refused::new(message).help(help))
    }

    fn close(mut self, ended: Result<(), Refused>) -> Result<Ran, Vec<Refused>> {
        self.problems.extend(ended.err());
        if self.found.len() >= MOST_PROBLEMS {
            self.problems.push(Refused::new(format!(
                "reading stopped after {MOST_PROBLEMS} problems; there may be more"
            )));
        }
        if !self.problems.is_empty() {
            return Err(self.problems);
        }
        let tally = &self.interpreter.tally;
        let notes = notes(tally, self.deletable, self.setup);
        Ok(Ran { blocks: self.blocks, holes: tally.holes, notes })
    }

    fn problem(line: Line<'_>, wrong: &Wrong) -> Refused {
        Refused::new(wrong.message.clone())
            .at(Control::place(line, (wrong.start, wrong.end)))
            .help(wrong.help.clone())
    }

    /// Bytes of a line; those that are no UTF-8 (comments) are shown as such.
    fn place(line: Line<'_>, (start, end): Span) -> Excerpt {
        let length = |bytes: usize| {
            let part = line.bytes.get(..bytes).unwrap_or(line.bytes);
            String::from_utf8_lossy(part).len()
        };
        let text = String::from_utf8_lossy(line.bytes).into_owned();
        Excerpt { line: line.number, text, span: (length(start), length(end)) }
    }
}
