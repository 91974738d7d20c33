//! A whole program: lines, subprograms, and the end.
//!
//! The main program begins with the text and ends with M2, M30, M99, a second `%` or the text; a
//! subprogram that `%` or the end of the text breaks off is a problem.
//! Subprograms follow it, each from `O…` to M99; an index of the `O` words is made when the first
//! one is called.

use crate::inputs::findings::PathFinding;
use crate::inputs::nc::block::{Block, CALL, Span};
use crate::inputs::nc::interpreter::{Flow, Interpreter, RoughArcs, Tally};
use crate::inputs::nc::moves::USUAL_MISS_MM;
use crate::inputs::nc::scan::{Wrong, words};
use crate::inputs::nc::{Move, Refused, Setup, WithoutPoint};
use crate::text::finding::Finding;
use crate::text::problem::{Place, Problem, Problems};
use std::collections::{BTreeMap, BTreeSet};

/// Problems that are told of one program.
const MOST_PROBLEMS: usize = 20;
/// Calls inside each other; controls have 4 to 10.
const DEEPEST_CALLS: usize = 16;
/// Subprograms in a file.
const MOST_PROGRAMS: usize = 10_000;
/// Work that a program asks for beyond its own lines: blocks of subprograms, holes that a cycle repeats (K, L),
/// and the millimetres that both go, as a path is followed in such steps. The lines of a file end by themselves,
/// however large it is; this many blocks are hours of a control (a thousand in a second are many) and
/// seconds here. The largest programs seen have 60 MB, three million blocks and 10 km, and may stand in
/// a subprogram as a whole.
const MOST_REPEATED: f64 = 2e7;
/// What a call and a return count: the text is taken up again elsewhere, which takes as long as this many blocks.
const JUMP: f64 = 10.0;

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
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Problem>;
    /// Where the next line begins.
    fn mark(&self) -> Mark;
    /// Goes on at a mark.
    fn go_to(&mut self, mark: Mark) -> Result<(), Problem>;
}

/// What was executed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ran {
    /// Blocks, with all repeats.
    pub blocks: u64,
    /// Holes of canned cycles.
    pub holes: u64,
    /// What a person has to know of how the program was understood.
    pub notes: Vec<Finding>,
}

/// Executes a program; `follow` gets every move. All problems are given, up to a number; after
/// one of them the moves are those of the blocks that could be executed.
pub fn run(
    text: &mut dyn Text,
    name: &str,
    setup: &Setup,
    mut follow: impl FnMut(&Move) -> Result<(), Refused>,
) -> Result<Ran, Problems> {
    let mut control = Control {
        name,
        setup,
        interpreter: Interpreter::new(setup),
        problems: Problems::none(),
        found: BTreeSet::new(),
        calls: Vec::new(),
        index: None,
        blocks: 0,
        repeated: 0.0,
        deletable: 0,
        percent: false,
        begun: false,
        entered: false,
    };
    control.execute(text, &mut follow)?;
    control.close()
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
    name: &'s str,
    setup: &'s Setup,
    interpreter: Interpreter<'s>,
    problems: Problems,
    /// Lines and bytes at which something is wrong.
    found: BTreeSet<(usize, usize)>,
    calls: Vec<Call>,
    index: Option<BTreeMap<u32, Mark>>,
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
    Call(u32, u32, Place),
    Return,
    /// M2, M30.
    End,
    /// The second `%`.
    TextEnd,
}

type Follow<'f> = &'f mut dyn FnMut(&Move) -> Result<(), Refused>;

impl Control<'_> {
    fn execute(&mut self, text: &mut dyn Text, follow: Follow<'_>) -> Result<(), Problems> {
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
                Next::Call(program, times, place) => self.call(text, program, times, place)?,
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
    ) -> Result<Next, Problems> {
        block.read(line.bytes);
        self.blocks += 1;
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
            return Err(self.problem(line, &wrong).into()); // what else was found follows from it
        }
        self.follow(block, holes, line.number, follow)?;
        for wrong in &block.wrong {
            if self.found.insert((line.number, wrong.start)) {
                self.problems.push(self.problem(line, wrong));
            }
        }
        Ok(match flow {
            Flow::Next => Next::Line,
            Flow::Return => Next::Return,
            Flow::End => Next::End,
            Flow::Call { program, times } => {
                let span = block.m_word(CALL).map_or((0, 1), |word| word.span);
                Next::Call(program, times, self.place(line, span))
            }
        })
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
    ) -> Result<(), Problems> {
        let holes = self.interpreter.tally.holes - holes;
        let repeats = !self.calls.is_empty() || holes > 1;
        let mut length_mm = 0.0;
        for (step, span) in self.interpreter.moves.drain(..) {
            if repeats {
                length_mm += step.length_mm();
            }
            if let Err(refused) = follow(&step) {
                if block.wrong.is_empty() {
                    let wrong = Wrong::new(span, refused.message, refused.help);
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

    fn count(&mut self, holes: u64, length_mm: f64, line: usize) -> Result<(), Problems> {
        self.repeated += 1.0 + holes as f64 + length_mm;
        if self.repeated <= MOST_REPEATED {
            return Ok(());
        }
        let line = self.calls.first().map_or(line, |call| call.line);
        let message = format!(
            "the repeats of subprograms and cycles make more than {MOST_REPEATED} blocks and mm; the last of them begin in line {line}"
        );
        let help = "check the numbers of repeats: L and P of M98, K and L of cycles";
        Err(self.all(Problem::new(message).help(help)))
    }

    /// The text is over.
    fn ended(&mut self) -> Result<(), Problems> {
        let Some(call) = self.calls.last() else {
            return Ok(());
        };
        let message = format!("subprogram O{} ends without M99", call.program);
        Err(self.all(Problem::new(message).help("end it with M99, before the text or `%` ends it")))
    }

    /// The problems so far, and one that ends the run.
    fn all(&mut self, problem: Problem) -> Problems {
        let mut problems = std::mem::take(&mut self.problems);
        problems.push(problem);
        problems
    }

    fn call(
        &mut self,
        text: &mut dyn Text,
        program: u32,
        times: u32,
        place: Place,
    ) -> Result<(), Problems> {
        if self.calls.len() == DEEPEST_CALLS {
            let message = format!("more than {DEEPEST_CALLS} subprograms call each other");
            let help = "a subprogram must not call itself";
            return Err(self.all(Problem::new(message).at(place).help(help)));
        }
        let back = text.mark();
        let index = match self.index.take() {
            Some(index) => index,
            None => index(text).map_err(|problem| self.all(problem))?,
        };
        let begin = self.index.insert(index).get(&program).copied();
        let Some(begin) = begin else {
            text.go_to(back)?;
            if self.found.insert((place.line, place.column)) {
                let message = format!("there is no subprogram O{program} in the file");
                let help = "put the subprograms behind the main program, each from `O…` to M99";
                self.problems
                    .push(Problem::new(message).at(place).help(help));
            }
            return Ok(());
        };
        text.go_to(begin)?;
        self.entered = true;
        self.repeated += JUMP;
        self.calls.push(Call {
            program,
            line: place.line,
            begin,
            back,
            left: times - 1,
        });
        Ok(())
    }

    fn go_back(&mut self, text: &mut dyn Text) -> Result<(), Problem> {
        self.repeated += JUMP;
        let Some(call) = self.calls.last_mut() else {
            return Ok(());
        };
        if call.left > 0 {
            call.left -= 1;
            self.entered = true;
            return text.go_to(call.begin);
        }
        let back = call.back;
        self.calls.pop();
        text.go_to(back)
    }

    fn close(mut self) -> Result<Ran, Problems> {
        if self.found.len() >= MOST_PROBLEMS {
            self.problems.push(Problem::new(format!(
                "reading stopped after {MOST_PROBLEMS} problems; there may be more"
            )));
        }
        let tally = &self.interpreter.tally;
        self.problems.or_ok(Ran {
            blocks: self.blocks,
            holes: tally.holes,
            notes: notes(tally, self.deletable, self.setup),
        })
    }

    fn problem(&self, line: Line<'_>, wrong: &Wrong) -> Problem {
        Problem::new(wrong.message.clone())
            .at(self.place(line, (wrong.start, wrong.end)))
            .help(wrong.help.clone())
    }

    /// The place of bytes of a line; bytes that are no UTF-8 (comments) are shown as such.
    fn place(&self, line: Line<'_>, (start, end): Span) -> Place {
        let text = String::from_utf8_lossy(line.bytes);
        let length = |bytes: usize| {
            let part = line.bytes.get(..bytes).unwrap_or(line.bytes);
            String::from_utf8_lossy(part).len()
        };
        let mut place = Place::in_text(self.name, &text, length(start), length(end));
        place.line = line.number;
        place
    }
}

/// The bytes that some editors put before a text (UTF-8).
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

fn without_mark(line: Line<'_>) -> Line<'_> {
    let first = line.number == 1;
    let bytes = line.bytes.strip_prefix(BYTE_ORDER_MARK).filter(|_| first);
    Line {
        bytes: bytes.unwrap_or(line.bytes),
        ..line
    }
}

/// The lines that begin with `O` or `:`, by its number.
fn index(text: &mut dyn Text) -> Result<BTreeMap<u32, Mark>, Problem> {
    text.go_to(Mark::default())?;
    let mut index = BTreeMap::new();
    loop {
        let mark = text.mark();
        let Some(line) = text.next_line()? else {
            return Ok(index);
        };
        let number = line.number;
        let Some(program) = program_number(without_mark(line).bytes) else {
            continue;
        };
        if index.len() == MOST_PROGRAMS {
            return Err(Problem::new(format!(
                "the file holds more than {MOST_PROGRAMS} programs"
            )));
        }
        if index.insert(program, mark).is_some() {
            return Err(Problem::new(format!(
                "program O{program} is given twice in the file, again in line {number}"
            ))
            .help("give one of them another number"));
        }
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the number is checked to lie in the range before it is used"
)]
fn program_number(line: &[u8]) -> Option<u32> {
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace())?;
    if !matches!(first, b'O' | b'o' | b'N' | b'n' | b':') {
        return None;
    }
    let mut words = words(line).filter_map(Result::ok);
    let word = words.find(|word| word.letter != b'N')?;
    (word.letter == b'O' && (0.0..=99_999_999.0).contains(&word.value)).then_some(word.value as u32)
}

fn notes(tally: &Tally, deletable: u64, setup: &Setup) -> Vec<Finding> {
    let what = match setup.skip_deletable {
        true => "left out",
        false => "executed",
    };
    let count = deletable;
    let lines = PathFinding::Deletable { count, what };
    let count = tally.look_ahead;
    let look_ahead = PathFinding::LookAhead { count };
    let words = tally.m.iter();
    let words = words.map(|(m, count)| format!("M{m}{} ({count})", tally.with_words(*m)));
    let words: Vec<String> = words.collect();
    let has_words = !words.is_empty();
    let blend = |(mm, line)| PathFinding::Blend { mm, line };
    let found = [
        without_point(tally, setup),
        (deletable > 0).then_some(lines),
        (tally.look_ahead > 0).then_some(look_ahead),
        tally.blend.map(blend),
        tally.rough_arcs.as_ref().map(rough_arcs),
        tally.other_mode.map(|line| PathFinding::OtherMode { line }),
        has_words.then_some(PathFinding::WithoutMotion { words }),
    ];
    found.into_iter().flatten().map(Finding::from).collect()
}

fn without_point(tally: &Tally, setup: &Setup) -> Option<PathFinding> {
    let (count, line) = (tally.without_point, tally.first_without_point);
    let meaning = match setup.without_point {
        WithoutPoint::Unit => "whole mm or inches (`X100` = 100 mm)",
        WithoutPoint::Increment => "least input increments (`X100` = 0.1 mm)",
    };
    let found = PathFinding::WithoutPoint {
        count,
        line,
        meaning,
    };
    (count > 0).then_some(found)
}

fn rough_arcs(arcs: &RoughArcs) -> PathFinding {
    PathFinding::RoughArcs {
        usual_mm: USUAL_MISS_MM,
        count: arcs.count,
        most_mm: arcs.most_mm,
        line: arcs.line,
        allowed_mm: arcs.allowed_mm,
    }
}
