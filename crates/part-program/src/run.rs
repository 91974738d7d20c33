//! A whole program: lines, subprograms, and the end.
//!
//! The main program begins with the text and ends with M2, M30, M99, a second `%` or the text; a
//! subprogram that `%` or the end of the text breaks off is a problem.
//! Subprograms follow it, each from `O…` to M99. Jumps go to lines by the index of [`flow`](super::flow).

use crate::block::{Block, CALL};
use crate::expression::Variables;
use crate::flow::{Flow, Index, begin};
use crate::interpreter::Interpreter;
use crate::lexer::Lexer;
use crate::notes::notes;
use crate::wrong::{Excerpt, Refused, Span, Wrong};
use crate::{Move, Setup};
use std::collections::BTreeSet;

/// The bytes that some editors put before a text (UTF-8).
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A line of a program: its number from 1, and its bytes without line end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// From 1.
    pub number: usize,
    /// Without line end.
    pub bytes: &'a [u8],
}

/// Where a line begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Bytes before it.
    pub bytes: u64,
    /// Lines before it.
    pub lines: usize,
}

/// A program that is read line by line and can be taken up again at a place.
pub trait Text {
    /// The next line; `None` at the end.
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused>;
    /// Where the next line begins.
    fn mark(&self) -> Mark;
    /// Goes on at a mark.
    fn go_to(&mut self, mark: Mark) -> Result<(), Refused>;
}

/// The first line without the mark that some editors put before it.
pub(crate) fn without_mark(line: Line<'_>) -> Line<'_> {
    let bytes = line.bytes.strip_prefix(BYTE_ORDER_MARK).filter(|_| line.number == 1);
    Line { bytes: bytes.unwrap_or(line.bytes), ..line }
}

/// Problems that are told of one program.
const MOST_PROBLEMS: usize = 20;
/// Work that a program asks for beyond its own lines: blocks of subprograms, holes that a cycle repeats (K, L),
/// and the millimetres that both go, as a path is followed in such steps. The lines of a file end by themselves,
/// however large it is; this many blocks are hours of a control (a thousand in a second are many) and
/// seconds here. The largest programs seen have 60 MB, three million blocks and 10 km, and may stand in
/// a subprogram as a whole.
const MOST_REPEATED: f64 = 2e7;

/// Calls inside each other; controls have 4 to 10.
const DEEPEST_CALLS: usize = 16;
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
    let mut control = Control { interpreter: Interpreter::new(setup), ..Control::default() };
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

/// What comes after a line, and the place that says so where it leads elsewhere.
type Next = (Flow, Option<Excerpt>);
type Follow<'f> = &'f mut dyn FnMut(&Move) -> Result<(), Refused>;

impl Control {
    fn execute(&mut self, text: &mut dyn Text, follow: Follow<'_>) -> Result<(), Refused> {
        let mut block = Block::default();
        while self.found.len() < MOST_PROBLEMS {
            let Some(line) = text.next_line()? else {
                return self.ended();
            };
            let next = self.line(without_mark(line), &mut block, follow)?;
            match next.0 {
                Flow::Next => {}
                Flow::End => return Ok(()),
                Flow::TextEnd => return self.ended(),
                Flow::Return => match self.calls.pop() {
                    Some(call) => self.go_back(text, call)?,
                    None => return Ok(()),
                },
                _ => self.go(text, next)?,
            }
        }
        Ok(())
    }

    /// Executes a line; where it leads elsewhere, with the place that says so.
    fn line(
        &mut self,
        line: Line<'_>,
        block: &mut Block,
        follow: Follow<'_>,
    ) -> Result<Next, Refused> {
        self.blocks += 1;
        let language = self.interpreter.setup.language;
        if let Some(at) = begin(line.bytes, language) {
            let flow = self.statement(line, at)?;
            let leads = flow != Flow::Next;
            return Ok((flow, leads.then(|| excerpt(line, (at, line.bytes.len())))));
        }
        block.read(line.bytes, language, &self.variables);
        if block.has(b'%') {
            // The first `%` begins the text, the next one ends it.
            let is_end = self.begun || std::mem::replace(&mut self.percent, true);
            return Ok((if is_end { Flow::TextEnd } else { Flow::Next }, None));
        }
        if block.has(b'/') && self.is_left_out() {
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
        let flow = self.interpreter.block(block, line.number);
        if let Some(wrong) = self.interpreter.turning.take() {
            self.problems.clear(); // what else was found follows from it
            return Err(refused(line, &wrong));
        }
        self.follow(block, follow)?;
        for wrong in &block.wrong {
            if self.found.insert((line.number, wrong.span.0)) {
                self.problems.push(refused(line, wrong));
            }
        }
        let call = block.m_word(CALL).filter(|_| !matches!(flow, Flow::Call(_, 0)));
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
        let language = self.interpreter.setup.language;
        let variables = Some(&self.variables);
        let lexer = Lexer { line: line.bytes, at, language, variables, ..Lexer::default() };
        let (flow, values) = lexer.statement().map_err(|wrong| refused(line, &wrong))?;
        self.variables.extend(values);
        Ok(flow)
    }

    fn is_repeated(&self) -> bool {
        self.jumped || !self.calls.is_empty()
    }

    /// Follows the moves of a block to the first one that is refused. They count where the block is one
    /// of a subprogram or repeats holes.
    #[inline]
    fn follow(&mut self, block: &mut Block, follow: Follow<'_>) -> Result<(), Refused> {
        let holes = self.interpreter.tally.holes - self.interpreter.holes_before;
        let repeats = self.is_repeated() || holes > 1;
        let mut length_mm = 0.0;
        for step in self.interpreter.moves.drain(..) {
            if repeats {
                length_mm += step.length_mm();
            }
            if let Err(refused) = follow(&step) {
                if block.wrong.is_empty() {
                    let help = refused.help.unwrap_or_default();
                    block.wrong.push(Wrong::new(self.interpreter.span, refused.message, help)); // else it may follow from what is wrong already
                }
                break;
            }
        }
        if repeats {
            self.count(holes, length_mm, self.interpreter.line)?;
        }
        Ok(())
    }

    fn count(&mut self, holes: u64, length_mm: f64, line: usize) -> Result<(), Refused> {
        self.repeated += 1.0 + holes as f64 + length_mm;
        if self.repeated <= MOST_REPEATED {
            return Ok(());
        }
        let line = self.calls.first().map_or(line, |call| call.line);
        let what = format!(
            "the repeats of subprograms, loops and cycles make more than {MOST_REPEATED} blocks and mm; the last of them begin in line {line}"
        );
        let help = "check the numbers of repeats (L and P of M98, K and L of cycles), and the conditions of loops";
        Err(Refused::new(what).help(help))
    }

    /// Goes where a line leads.
    fn go(&mut self, text: &mut dyn Text, (flow, place): Next) -> Result<(), Refused> {
        let (label, place) = match (flow, place) {
            (Flow::Call(program, _), Some(place)) => (("O", program), place),
            (Flow::To(label), Some(place)) => (label, place),
            _ => return Ok(()),
        };
        if matches!(flow, Flow::Call(..)) && self.calls.len() == DEEPEST_CALLS {
            let what = format!("more than {DEEPEST_CALLS} subprograms call each other");
            let help = "a subprogram must not call itself without end";
            return Err(Refused::new(what).at(place).help(help));
        }
        let back = text.mark();
        let index = match self.index.take() {
            Some(index) => index,
            None => Index::read(text)?,
        };
        let (to, passed) = self.index.insert(index).target(label, text)?;
        self.repeated += passed as f64 * PASSED;
        match (to, flow) {
            (Some(begin), Flow::Call(program, times)) => {
                self.entered = true;
                self.calls.push(Call { program, line: place.line, begin, back, left: times - 1 });
                self.jump(text, begin)
            }
            (Some(mark), _) => {
                self.jumped |= mark.lines < place.line; // what follows may be executed again
                self.jump(text, mark)
            }
            (None, Flow::Call(program, _)) => {
                if self.found.insert((place.line, place.span.0)) {
                    let what = format!("there is no subprogram O{program} in the file");
                    let help = "put the subprograms behind the main program, each from `O…` to M99";
                    self.problems.push(Refused::new(what).at(place).help(help));
                }
                text.go_to(back)
            }
            (None, _) => {
                let what = format!("{}{} is not in the program", label.0, label.1);
                let help = "write it into the same program, or remove what leads to it";
                Err(Refused::new(what).at(place).help(help))
            }
        }
    }

    fn jump(&mut self, text: &mut dyn Text, to: Mark) -> Result<(), Refused> {
        self.repeated += JUMP;
        text.go_to(to)
    }

    /// M99: the subprogram once more, or on behind its call.
    fn go_back(&mut self, text: &mut dyn Text, mut call: Call) -> Result<(), Refused> {
        if call.left == 0 {
            return self.jump(text, call.back);
        }
        call.left -= 1;
        self.entered = true;
        let begin = call.begin;
        self.calls.push(call);
        self.jump(text, begin)
    }

    /// The text is over.
    fn ended(&self) -> Result<(), Refused> {
        let Some(call) = self.calls.last() else {
            return Ok(());
        };
        let what = format!("subprogram O{} ends without M99", call.program);
        Err(Refused::new(what).help("end it with M99, before the text or `%` ends it"))
    }

    fn close(mut self, ended: Result<(), Refused>) -> Result<Ran, Vec<Refused>> {
        self.problems.extend(ended.err());
        if self.found.len() >= MOST_PROBLEMS {
            let what = format!("reading stopped after {MOST_PROBLEMS} problems; there may be more");
            self.problems.push(Refused::new(what));
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
    let shown = |bytes| String::from_utf8_lossy(bytes).into_owned();
    let length = |at: usize| shown(&line.bytes[..at.min(line.bytes.len())]).len();
    Excerpt { line: line.number, text: shown(line.bytes), span: (length(start), length(end)) }
}
