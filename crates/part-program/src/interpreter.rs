//! The modal state of a control, and what one block makes of it.

mod functions;
mod motion;
mod tools;

use crate::block::{Block, CALL, CodeWord};
use crate::codes::{Code, Cycle, Drill, GROUPS, Motion, code, why_not};
use crate::flow::Flow;
use crate::setup::Offsets;
use crate::wrong::{Span, Wrong, refuse};
use crate::{EXTENDED, Language, MM_PER_INCH, Move, Place, Plane, Setup, system_name};
use std::collections::{BTreeMap, BTreeSet};

pub(super) const AXES: [u8; 3] = *b"XYZ";
/// G50: with S or a coordinate that of turning.
const SPINDLE_LIMIT: u16 = 500;
/// M words that call programs or move axes on their own.
const CALLS: [u16; 6] = [960, 970, 1960, 1970, 1980, 1990];
/// M17 of Siemens.
const SUB_END: u16 = 170;

/// What was ignored or understood in a way that a person should know.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tally {
    /// M words without motion, with how often they stand and the letters beside them.
    pub(super) m: BTreeMap<u16, (u64, BTreeSet<char>)>,
    /// The line of the first length that is taken as mm because nothing says its unit.
    pub(super) without_unit: Option<usize>,
    /// Coordinates without a decimal point, and the first line with one.
    pub(super) without_point: Option<(u64, usize)>,
    pub(super) holes: u64,
    /// G5, G5.1, G8.
    pub(super) look_ahead: u64,
    /// Largest P or Q of G64 in mm, and its line.
    pub(super) blend: Option<(f64, usize)>,
    pub(super) rough_arcs: Option<RoughArcs>,
    /// First line that drills in another mode (G90, G91) than R and Z were written in.
    pub(super) other_mode: Option<usize>,
}

/// Arcs whose end misses the circle by more than usual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RoughArcs {
    pub(super) count: u64,
    pub(super) most_mm: f64,
    pub(super) line: usize,
    pub(super) allowed_mm: f64,
}

/// Words of a block beside the axes.
#[derive(Clone, Copy, Default)]
struct BlockModes {
    motion: Option<Motion>,
    end_cycle: Option<CodeWord>,
    machine: Option<Span>,
    once: Option<CodeWord>,
    system: Option<(Option<u32>, Span)>,
    tool: Option<(bool, Span)>,
    blend: bool,
    returns: bool,
}

/// A control while it executes a program.
#[derive(Default)]
pub(super) struct Interpreter {
    pub(super) setup: Setup,
    /// The moves of the block.
    pub(super) moves: Vec<Move>,
    /// The first axis word of the block, or its centre.
    pub(super) span: Span,
    pub(super) at: Place,
    pub(super) plane: Plane,
    /// G17, G18 or G19 stood in the program.
    has_plane: bool,
    pub(super) incremental: bool,
    /// G99: a cycle ends at R, else (G98) at the initial level.
    pub(super) retracts: bool,
    pub(super) offsets: Offsets,
    /// Of the cycle that is active, or begins next.
    pub(super) cycle: Cycle,
    pub(super) tally: Tally,
    pub(super) line: usize,
    /// G53: the block counts from the machine's zero.
    in_machine: bool,
    /// Holes that were drilled before the block.
    pub(super) holes_before: u64,
    motion: Option<Motion>,
    inch: Option<bool>,
    absolute_centre: bool,
    /// The last H.
    tool_number: Option<u32>,
    /// The last T.
    called_tool: Option<u32>,
    /// The tool that the last M6 changed in.
    spindle_tool: Option<u32>,
    /// What shows that the program is one for turning.
    pub(super) turning: Option<Wrong>,
    /// What MCALL drills behind each move.
    modal_drill: Option<Drill>,
    /// Number of the hole that the next move drills.
    pub(super) hole: Option<u64>,
    /// A zero or a length is not known: moves are judged as words only.
    is_lost: bool,
}

impl Interpreter {
    pub(super) fn new(setup: &Setup) -> Interpreter {
        Interpreter {
            at: setup.start,
            inch: setup.inch,
            offsets: Offsets::new(setup),
            setup: setup.clone(),
            ..Interpreter::default()
        }
    }

    /// Executes a block; what is wrong goes into its list.
    pub(super) fn block(&mut self, block: &mut Block, line: usize) -> Flow {
        (self.line, self.holes_before) = (line, self.tally.holes);
        self.span = first_span(block);
        let asked = if block.g.is_empty() { BlockModes::default() } else { self.modes(block) };
        self.change_tool(block);
        if asked.blend || block.adis.is_some() {
            self.blend(block);
        }
        for letter in *b"NFSTD" {
            block.value(letter); // without effect on the path, or taken already
        }
        let done = self.select(block, asked).and_then(|()| self.moved(block, asked));
        let done = done.and_then(|()| self.drills(block, asked.once.is_none()));
        let flow = done.and(self.programs(block));
        if block.wrong.is_empty() {
            match &flow {
                Ok(_) => refuse_unused(block, self.motion),
                Err(wrong) => block.wrong.push(wrong.clone()), // else it may follow from what is wrong already
            }
        }
        match flow {
            Ok(_) if asked.returns => Flow::Return,
            flow => flow.unwrap_or(Flow::Next),
        }
    }

    fn moved(&mut self, block: &mut Block, asked: BlockModes) -> Result<(), Wrong> {
        self.in_machine = asked.machine.is_some();
        if let Some(span) = asked.machine {
            let motion = asked.motion.or(asked.end_cycle.map(|_| Motion::Ended)).or(self.motion);
            let is_straight = matches!(motion, Some(Motion::Rapid | Motion::Straight));
            let fits = is_straight && !self.incremental && asked.once.is_none();
            if !fits || !block.has_any(&AXES) {
                let what = "`G53` is executed with G90, G0 or G1, and an axis only";
                return refuse(span, what, "write it in a block of its own, e.g. `G90 G53 G0 Z0`");
            }
        }
        for motion in asked.end_cycle.map(|_| Motion::Ended).into_iter().chain(asked.motion) {
            self.set_motion(motion);
        }
        match asked.once {
            Some(word) => self.once(block, word),
            None => self.motion(block),
        }
    }

    /// G words: modes at once, the others as what is asked of this block.
    fn modes(&mut self, block: &mut Block) -> BlockModes {
        let mut asked = BlockModes::default();
        let mut groups: [Option<CodeWord>; GROUPS] = [None; GROUPS];
        for index in 0..block.g.len() {
            let word = block.g[index];
            let Some((group, code)) = code(word.tenths, self.setup.language) else {
                let what = format!("`{}` is not executed", word.name('G'));
                block.wrong.push(Wrong::new(word.span, what, why_not(word.tenths)));
                continue;
            };
            let group = &mut groups[group];
            if let Some(other) = group.filter(|other| other.tenths != word.tenths) {
                let what = format!(
                    "`{}` and `{}` stand in one block, but exclude each other",
                    other.name('G'),
                    word.name('G')
                );
                let help = "keep one of them, or split the block";
                block.wrong.push(Wrong::new(word.span, what, help));
            }
            *group = Some(word);
            if word.tenths == SPINDLE_LIMIT && block.has_any(b"SXZUW") {
                self.turns(word.span, "`G50` with S or a coordinate");
            }
            self.mode(code, word, &mut asked);
        }
        if let (Some(end), Some(Motion::Cycle(_))) = (asked.end_cycle, asked.motion) {
            let what = "`G80` ends a cycle that the same block begins";
            block.wrong.push(Wrong::new(end.span, what, "split the block"));
        }
        asked
    }

    fn mode(&mut self, code: Code, word: CodeWord, asked: &mut BlockModes) {
        match code {
            Code::Motion(motion) => asked.motion = Some(motion),
            Code::EndCycle => asked.end_cycle = Some(word),
            Code::Plane(plane) => (self.plane, self.has_plane) = (plane, true),
            Code::Inch(inch) => self.inch = Some(inch),
            Code::Incremental(incremental) => self.incremental = incremental,
            Code::AbsoluteCentre(absolute) => self.absolute_centre = absolute,
            Code::Retract(retracts) => self.retracts = retracts,
            Code::System(system) => asked.system = Some((system, word.span)),
            Code::ToolLength(on) => asked.tool = Some((on, word.span)),
            Code::Once => asked.once = Some(word),
            Code::MachineCoordinates => asked.machine = Some(word.span),
            Code::Blend => asked.blend = true,
            Code::Turning => self.turns(word.span, "`G96` (constant cutting speed)"),
            Code::Return => asked.returns = true,
            Code::Harmless => {}
        }
    }

    /// What shows that the program is one for turning.
    fn turns(&mut self, span: Span, what: &str) {
        let what = format!(
            "{what} stands in turning programs, in which X is a diameter: `path` follows milling programs of X, Y and Z"
        );
        let help = "take a milling program; if this is one, remove the word: the path of the milling tool does not depend on it";
        self.turning = Some(Wrong::new(span, what, help));
    }

    pub(super) fn is_inch(&self) -> bool {
        self.inch == Some(true)
    }

    /// G64 P… Q…: how far the control may leave the path, in the program's unit.
    fn blend(&mut self, block: &mut Block) {
        let unit = if self.is_inch() { MM_PER_INCH } else { 1.0 };
        for value in [block.value(b'P'), block.value(b'Q'), block.adis.take()] {
            let mm = value.map(|value| value * unit);
            let mm = mm.filter(|mm| self.tally.blend.is_none_or(|(most, _)| *mm > most));
            self.tally.blend = mm.map(|mm| (mm, self.line)).or(self.tally.blend);
        }
    }

    /// Coordinate system and tool length.
    fn select(&mut self, block: &mut Block, asked: BlockModes) -> Result<(), Wrong> {
        if let Some((system, span)) = asked.system {
            let number = match system {
                Some(number) => number,
                None => EXTENDED + named(block, b'P', span, "G54.1")?,
            };
            if !self.offsets.systems.contains_key(&number) {
                return Err(self.lose(span, number));
            }
            self.offsets.select(number);
        }
        if self.setup.language == Language::Siemens {
            return self.edge(block);
        }
        let number = block.whole(b'H')?;
        self.tool_number = number.or(self.tool_number);
        let span = number.map(|_| block.span(b'H'));
        match (asked.tool, span) {
            (Some((false, _)), _) => self.offsets.change_tool(None),
            (Some((true, own)), span) => self.use_tool(span.unwrap_or(own), number)?,
            (None, Some(span)) if self.offsets.tool.is_some() => self.use_tool(span, number)?,
            _ => {}
        }
        Ok(())
    }

    /// An M word without motion; P, Q and L that nothing else took are its own (M19 P90).
    fn tally_m(&mut self, block: &mut Block, m: u16) {
        let (count, letters) = self.tally.m.entry(m).or_default();
        *count += 1;
        if block.m_word(CALL).is_none() {
            // else P and L are those of the call
            letters.extend(b"PQL".iter().filter(|l| block.takes(**l)).map(|l| char::from(*l)));
        }
    }

    /// M words: calls, ends, and those without effect on the path.
    fn programs(&mut self, block: &mut Block) -> Result<Flow, Wrong> {
        let mut flow = Flow::Next;
        let is_siemens = self.setup.language == Language::Siemens;
        for index in 0..block.m.len() {
            let word = block.m[index];
            let refused = |of: &str, help: &str| {
                refuse(word.span, format!("`{}` is not executed{of}", word.name('M')), help)
            };
            let next = match word.tenths {
                20 | 300 => Flow::End,
                SUB_END if is_siemens => Flow::Return,
                CALL | 990 if is_siemens => {
                    return refused(" in Siemens programs", "M17 and RET end a subprogram");
                }
                CALL => call(block, word.span)?,
                990 => Flow::Return,
                tenths if CALLS.contains(&tenths) || tenths % 10 != 0 => {
                    return refused("", "M98 and M99 call and end subprograms of the same file");
                }
                tenths => {
                    self.tally_m(block, tenths / 10);
                    continue;
                }
            };
            if flow != Flow::Next {
                return refuse(word.span, "two M words end or call a program", "keep one of them");
            }
            flow = next;
        }
        Ok(flow)
    }
}

/// M98 P… L…; without L the digits before the last four of P are the number of calls.
fn call(block: &mut Block, span: Span) -> Result<Flow, Wrong> {
    let number = named(block, b'P', span, "M98")?;
    Ok(match block.whole(b'L')? {
        Some(times) => Flow::Call(number, times),
        None if number > 9999 => Flow::Call(number % 10_000, number / 10_000),
        None => Flow::Call(number, 1),
    })
}

/// A whole number that a word needs.
fn named(block: &mut Block, letter: u8, span: Span, word: &str) -> Result<u32, Wrong> {
    let number = block.whole(letter)?;
    let letter = char::from(letter);
    let help = || format!("write `{letter}` with its number in the same block");
    number.ok_or_else(|| Wrong::new(span, format!("`{word}` needs `{letter}`"), help()))
}

fn unknown_system(span: Span, system: u32) -> Wrong {
    let name = system_name(system);
    let help = format!(
        "add `[[path.offset]]` with `system = \"{name}\"`, `x_mm`, `y_mm`, `z_mm` to the job (zeros, if the program is in machine coordinates)"
    );
    Wrong::new(span, format!("the zero of {name} in machine coordinates is not known"), help)
}

/// The first axis word of a block, or its centre.
fn first_span(block: &Block) -> Span {
    let places = b"XYZIJKR".iter().filter(|letter| block.has(**letter));
    places.map(|letter| block.span(*letter)).min().unwrap_or((0, 1))
}

/// Words that nothing in the block takes.
fn refuse_unused(block: &mut Block, motion: Option<Motion>) {
    for word in block.unused() {
        let letter = char::from(word.letter);
        let (what, help) = match letter {
            'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'E' => (
                format!("axis `{letter}` is not executed: the model has X, Y and Z"),
                "let the CAM system write a program of three axes",
            ),
            'O' => (
                "`O` begins a program before the one above ended".to_string(),
                "end a program with M30, a subprogram with M99",
            ),
            'I' | 'J' | 'K' | 'R' if !matches!(motion, Some(Motion::Arc(_))) => (
                format!("`{letter}` without an arc or a cycle"),
                "write G2 or G3, or remove the word",
            ),
            _ => (
                format!("`{letter}` belongs to no word of this block"),
                "remove it, or write the word that it belongs to",
            ),
        };
        block.wrong.push(Wrong::new(word.span, what, help));
    }
}
