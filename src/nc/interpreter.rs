//! The modal state of a control, and what one block makes of it.

use crate::nc::arc::{around, centre_of_radius};
use crate::nc::block::{Block, CALL, CodeWord, Span};
use crate::nc::codes::{Code, Level, Motion, Once, code, is_call, why_not};
use crate::nc::cycle::Cycle;
use crate::nc::offsets::Offsets;
use crate::nc::scan::Wrong;
use crate::nc::{EXTENDED, Move, Place, Plane, Refused, Setup, Shape, WithoutPoint, system_name};
use crate::units::MM_PER_INCH;
use std::collections::BTreeMap;

pub(super) const AXES: [u8; 3] = *b"XYZ";
const CENTRES: [u8; 3] = *b"IJK";
/// No machine has a kilometre of travel.
const FARTHEST_MM: f64 = 1e6;
/// Least input increment without a decimal point (IS-B).
const INCREMENT_MM: f64 = 0.001;
const INCREMENT_IN: f64 = 0.0001;

/// What comes after a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    Call { program: u32, times: u32 },
    Return,
    End,
}

/// What was passed over or understood in a way that a person should know.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Tally {
    /// M words without motion, with how often they stand.
    pub(super) m: BTreeMap<u16, u64>,
    /// Coordinates without a decimal point, and the first line with one.
    pub(super) without_point: u64,
    pub(super) first_without_point: usize,
    pub(super) holes: u64,
    /// G5, G5.1, G8.
    pub(super) look_ahead: u64,
}

/// Where the axis words of a block count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// The program's zero.
    Program,
    /// G53: the machine's.
    Machine,
    /// The program's, on the way to a reference point (G28, G30).
    Home,
}

/// Words of a block beside the axes.
#[derive(Clone, Copy, Default)]
struct Asked {
    motion: Option<Motion>,
    end_cycle: Option<CodeWord>,
    machine: Option<Span>,
    once: Option<(Once, CodeWord)>,
    system: Option<(Option<u32>, Span)>,
    tool: Option<(bool, Span)>,
}

/// A control while it executes a program.
pub(super) struct Interpreter<'s> {
    setup: &'s Setup,
    pub(super) at: Place,
    pub(super) plane: Plane,
    pub(super) incremental: bool,
    pub(super) level: Level,
    pub(super) offsets: Offsets,
    pub(super) cycle: Option<Cycle>,
    pub(super) tally: Tally,
    pub(super) line: usize,
    motion: Option<Motion>,
    inch: bool,
    absolute_centre: bool,
    /// The last H.
    tool_number: Option<u32>,
    /// Number of the hole that the next move drills.
    pub(super) hole: Option<u64>,
    /// A zero or a length is not known: moves are judged as words only.
    is_lost: bool,
}

impl<'s> Interpreter<'s> {
    pub(super) fn new(setup: &'s Setup) -> Interpreter<'s> {
        Interpreter {
            setup,
            at: setup.start,
            plane: Plane::Xy,
            incremental: false,
            level: Level::Initial,
            offsets: Offsets::new(setup),
            cycle: None,
            tally: Tally::default(),
            line: 0,
            motion: None,
            inch: setup.inch,
            absolute_centre: false,
            tool_number: None,
            hole: None,
            is_lost: false,
        }
    }

    /// Executes a block; what is wrong goes into its list.
    pub(super) fn block<F>(&mut self, block: &mut Block, line: usize, follow: &mut F) -> Flow
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        self.line = line;
        let asked = if block.g.is_empty() {
            Asked::default()
        } else {
            self.modes(block)
        };
        for letter in *b"NFSTD" {
            block.value(letter); // without effect on the path
        }
        let done = self
            .select(block, asked)
            .and_then(|()| self.once(block, asked, follow))
            .and_then(|taken| {
                if taken {
                    Ok(())
                } else {
                    self.motion(block, asked, follow)
                }
            });
        let flow = self.programs(block);
        match (done, flow) {
            (Err(wrong), _) | (Ok(()), Err(wrong)) => {
                if block.wrong.is_empty() {
                    block.wrong.push(wrong); // else it may follow from what is wrong already
                }
                Flow::Next
            }
            (Ok(()), Ok(flow)) => {
                if !block.nothing_unused() && block.wrong.is_empty() {
                    refuse_unused(block, self.motion);
                }
                flow
            }
        }
    }

    /// G words: modes at once, the others as what is asked of this block.
    fn modes(&mut self, block: &mut Block) -> Asked {
        let mut asked = Asked::default();
        let mut groups: [Option<CodeWord>; 32] = [None; 32];
        for index in 0..block.g.len() {
            let word = block.g[index];
            let Some(code) = code(word.tenths) else {
                let message = format!("`{}` is not executed", word.name('G'));
                block
                    .wrong
                    .push(Wrong::new(word.span, message, why_not(word.tenths)));
                continue;
            };
            let group = &mut groups[usize::from(code.group())];
            if let Some(other) = group.filter(|other| other.tenths != word.tenths) {
                let message = format!(
                    "`{}` and `{}` stand in one block, but exclude each other",
                    other.name('G'),
                    word.name('G')
                );
                block.wrong.push(Wrong::new(
                    word.span,
                    message,
                    "keep one of them, or split the block",
                ));
            }
            *group = Some(word);
            self.mode(code, word, &mut asked);
        }
        if let (Some(end), Some(Motion::Cycle(_))) = (asked.end_cycle, asked.motion) {
            block.wrong.push(Wrong::new(
                end.span,
                "`G80` ends a cycle that the same block begins",
                "split the block",
            ));
        }
        asked
    }

    fn mode(&mut self, code: Code, word: CodeWord, asked: &mut Asked) {
        match code {
            Code::Motion(motion) => asked.motion = Some(motion),
            Code::EndCycle => asked.end_cycle = Some(word),
            Code::Plane(plane) => self.plane = plane,
            Code::Inch(inch) => self.inch = inch,
            Code::Incremental(incremental) => self.incremental = incremental,
            Code::AbsoluteCentre(absolute) => self.absolute_centre = absolute,
            Code::Level(level) => self.level = level,
            Code::System(system) => asked.system = Some((system, word.span)),
            Code::ToolLength(on) => asked.tool = Some((on, word.span)),
            Code::Once(once) => asked.once = Some((once, word)),
            Code::MachineCoordinates => asked.machine = Some(word.span),
            Code::Harmless(_) => {}
        }
    }

    /// Coordinate system and tool length.
    fn select(&mut self, block: &mut Block, asked: Asked) -> Result<(), Wrong> {
        if let Some((system, span)) = asked.system {
            let number = match system {
                Some(number) => number,
                None => EXTENDED + named(block, b'P', span, "G54.1")?,
            };
            if !self.offsets.knows(number) {
                return Err(self.lose(span, number));
            }
            self.offsets.select(number);
        }
        let number = block.whole(b'H')?;
        self.tool_number = number.or(self.tool_number);
        match (asked.tool, number) {
            (Some((false, _)), _) => self.offsets.no_tool(),
            (Some((true, span)), _) => self.use_tool(if number.is_some() {
                block.span(b'H')
            } else {
                span
            })?,
            (None, Some(_)) if self.offsets.tool().is_some() => self.use_tool(block.span(b'H'))?,
            _ => {}
        }
        Ok(())
    }

    fn use_tool(&mut self, span: Span) -> Result<(), Wrong> {
        let Some(number) = self.tool_number else {
            self.is_lost = true;
            return Err(Wrong::new(
                span,
                "`G43` without H: no tool offset was named yet",
                "write H with the number of the tool offset, e.g. `G43 H1`",
            ));
        };
        if self.offsets.use_tool(number) {
            return Ok(());
        }
        self.is_lost = true;
        Err(Wrong::new(
            span,
            format!("the length of tool offset H{number} is not known"),
            format!("add `[[path.tool]]` with `number = {number}` and `length_mm` to the job"),
        ))
    }

    /// A block whose axis words are not those of a motion; true = it was one.
    fn once<F>(&mut self, block: &mut Block, asked: Asked, follow: &mut F) -> Result<bool, Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        let Some((once, word)) = asked.once else {
            return Ok(false);
        };
        if let Some(span) = asked.machine {
            return Err(Wrong::new(
                span,
                format!("`G53` and `{}` stand in one block", word.name('G')),
                "split the block",
            ));
        }
        self.choose_motion(asked);
        match once {
            Once::Dwell => ["P", "X", "U"]
                .iter()
                .for_each(|letter| _ = block.value(letter.as_bytes()[0])),
            Once::SetOffset => self.set_offset(block, word.span)?,
            Once::Reference => self.go_home(block, word.span, self.setup.reference, follow)?,
            Once::SecondReference => self.go_second(block, word.span, follow)?,
            Once::Local => self.local(block)?,
            Once::Shift => self.shift(block, word.span)?,
            Once::CancelShift => self.offsets.cancel_shift(),
            Once::LookAhead => self.look_ahead(block, word)?,
        }
        Ok(true)
    }

    /// G5 P10000, G5.1 Q1, G8 P1 and their ends: the path stays.
    fn look_ahead(&mut self, block: &mut Block, word: CodeWord) -> Result<(), Wrong> {
        let (letter, on) = match word.tenths {
            50 => (b'P', 10_000),
            51 => (b'Q', 1),
            _ => (b'P', 1),
        };
        block.value(b'R');
        match named(block, letter, word.span, &word.name('G'))? {
            0 => {}
            number if number == on => self.tally.look_ahead += 1,
            number => {
                let (name, letter) = (word.name('G'), char::from(letter));
                return Err(Wrong::new(
                    word.span,
                    format!(
                        "`{name} {letter}{number}` is not executed, expected {letter}{on} or {letter}0 (look-ahead)"
                    ),
                    "splines and smoothing change the path: let the CAM system write short lines without them",
                ));
            }
        }
        Ok(())
    }

    /// G10 L2 P… X… Y… Z…
    fn set_offset(&mut self, block: &mut Block, span: Span) -> Result<(), Wrong> {
        if named(block, b'L', span, "G10")? != 2 {
            return Err(Wrong::new(
                block.span(b'L'),
                "`G10` is executed with L2 only (zero of a coordinate system)",
                "state other data in the job, and remove the block",
            ));
        }
        let number = match named(block, b'P', span, "G10 L2")? {
            0 => {
                return Err(Wrong::new(
                    block.span(b'P'),
                    "`G10 L2 P0` is not executed: on some controls it moves all systems (external offset), on others the active one",
                    "write the number of the system, P1 (G54) … P9 (G59.3), or state its zero in the job",
                ));
            }
            number @ 1..=9 => number,
            number => {
                return Err(Wrong::new(
                    block.span(b'P'),
                    format!("`P{number}` is no coordinate system, expected 1 (G54) … 9 (G59.3)"),
                    "write the number of the system",
                ));
            }
        };
        let words = self.axis_words(block)?;
        if self.offsets.set_system(number, words, self.incremental) {
            return Ok(());
        }
        Err(unknown_system(span, &system_name(number)))
    }

    fn local(&mut self, block: &mut Block) -> Result<(), Wrong> {
        for (axis, word) in self.axis_words(block)?.into_iter().enumerate() {
            if let Some(value) = word {
                self.offsets.set_local(axis, value);
            }
        }
        Ok(())
    }

    fn shift(&mut self, block: &mut Block, span: Span) -> Result<(), Wrong> {
        self.base(span)?;
        for (axis, word) in self.axis_words(block)?.into_iter().enumerate() {
            if let Some(value) = word {
                self.offsets.call(axis, self.at[axis], value);
            }
        }
        Ok(())
    }

    fn go_second<F>(&mut self, block: &mut Block, span: Span, follow: &mut F) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        if block.whole(b'P')?.is_some_and(|number| number != 2) {
            return Err(Wrong::new(
                block.span(b'P'),
                "only the second reference point (`G30`, `G30 P2`) is known",
                "write the move with G53",
            ));
        }
        let Some(place) = self.setup.second_reference else {
            return Err(Wrong::new(
                span,
                "the second reference point is not known",
                "add `second_reference_mm = { x = …, y = …, z = … }` to [path] of the job",
            ));
        };
        self.go_home(block, span, place, follow)
    }

    /// G28, G30: through a place to a reference point, with the axes that are named.
    fn go_home<F>(
        &mut self,
        block: &mut Block,
        span: Span,
        home: Place,
        follow: &mut F,
    ) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        if !block.has_any(&AXES) {
            return Err(Wrong::new(
                span,
                "no axis is named",
                "write the axes that go to the reference point, e.g. `G91 G28 Z0`",
            ));
        }
        let named = AXES.map(|letter| block.has(letter));
        let through = self.target(block, span, Reach::Home)?;
        self.go(through, Shape::Line, true, span, follow)?;
        let end = std::array::from_fn(|k| if named[k] { home[k] } else { self.at[k] });
        self.go(end, Shape::Line, true, span, follow)
    }

    /// G80, then the motion word of the block.
    fn choose_motion(&mut self, asked: Asked) {
        let motions = [asked.end_cycle.map(|_| Motion::Ended), asked.motion];
        motions
            .into_iter()
            .flatten()
            .for_each(|motion| self.set_motion(motion));
    }

    fn set_motion(&mut self, motion: Motion) {
        let was_cycle = matches!(self.motion, Some(Motion::Cycle(_)));
        if matches!(motion, Motion::Cycle(_)) {
            let third = self.plane.axes()[2];
            if !was_cycle {
                let zero = self.offsets.base().map(|base| base[third]);
                self.cycle = Some(Cycle::new(self.at[third], zero));
            }
        } else {
            self.cycle = None;
        }
        self.motion = Some(motion);
    }

    fn motion<F>(&mut self, block: &mut Block, asked: Asked, follow: &mut F) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        self.choose_motion(asked);
        if let Some(Motion::Cycle(number)) = self.motion {
            return self.cycle_block(block, number, asked.machine, follow);
        }
        let is_arc = matches!(self.motion, Some(Motion::Arc { .. }));
        if !(block.has_any(&AXES) || is_arc && block.has_any(b"IJKR")) {
            return match asked.machine {
                Some(span) => Err(Wrong::new(
                    span,
                    "`G53` without an axis",
                    "name the axes and their machine coordinates",
                )),
                None => Ok(()),
            };
        }
        let span = first_span(block);
        if asked.machine.is_some() && self.incremental {
            return Err(Wrong::new(
                span,
                "`G53` takes machine coordinates, but G91 is active",
                "write G90 before",
            ));
        }
        match self.motion {
            Some(motion @ (Motion::Rapid | Motion::Straight)) => {
                let reach = if asked.machine.is_some() {
                    Reach::Machine
                } else {
                    Reach::Program
                };
                let to = self.target(block, span, reach)?;
                self.go(to, Shape::Line, motion == Motion::Rapid, span, follow)
            }
            Some(Motion::Arc { clockwise }) => {
                if let Some(span) = asked.machine {
                    return Err(Wrong::new(
                        span,
                        "`G53` with an arc",
                        "position with G0 or G1 first",
                    ));
                }
                self.arc(block, clockwise, span, follow)
            }
            Some(Motion::Ended) => Err(Wrong::new(
                span,
                "axis words after `G80`: controls differ in which motion is active then",
                "write G0 or G1 before the coordinates",
            )),
            _ => Err(Wrong::new(
                span,
                "axis words, but no motion is active",
                "write G0, G1, G2 or G3 before the first coordinates",
            )),
        }
    }

    /// Where the axis words of a block lead.
    #[inline]
    fn target(&mut self, block: &mut Block, span: Span, reach: Reach) -> Result<Place, Wrong> {
        let words = self.axis_words(block)?;
        let base = if reach == Reach::Machine || self.incremental {
            [0.0; 3]
        } else {
            self.base(span)?
        };
        let mut to = self.at;
        for axis in 0..3 {
            let Some(value) = words[axis] else { continue };
            to[axis] = if self.incremental {
                self.at[axis] + value
            } else {
                base[axis] + value
            };
            if axis == 2 {
                if self.incremental && reach == Reach::Program {
                    to[2] += self.offsets.pending_z;
                }
                self.offsets.pending_z = 0.0; // what G43 or G49 left is made up for
            }
        }
        if to.iter().all(|mm| mm.abs() <= FARTHEST_MM) {
            return Ok(to);
        }
        Err(Wrong::new(
            span,
            "the move leads farther than a kilometre",
            "check the coordinate and its decimal point",
        ))
    }

    pub(super) fn base(&mut self, span: Span) -> Result<Place, Wrong> {
        match self.offsets.base() {
            Some(base) => Ok(base),
            None => Err(self.lose(span, self.offsets.active())),
        }
    }

    /// A coordinate system whose zero is not known: told once, and no move is followed any more.
    fn lose(&mut self, span: Span, system: u32) -> Wrong {
        self.is_lost = true;
        self.offsets.set_system(system, [Some(0.0); 3], false);
        self.offsets.select(system);
        unknown_system(span, &system_name(system))
    }

    fn axis_words(&mut self, block: &mut Block) -> Result<[Option<f64>; 3], Wrong> {
        Ok([
            self.length(block, b'X'),
            self.length(block, b'Y'),
            self.length(block, b'Z'),
        ])
    }

    /// A length word in mm, as the units and the decimal point say.
    #[inline]
    pub(super) fn length(&mut self, block: &mut Block, letter: u8) -> Option<f64> {
        let value = block.value(letter)?;
        let unit = if self.inch { MM_PER_INCH } else { 1.0 };
        if block.has_point(letter) {
            return Some(value * unit);
        }
        self.tally.without_point += u64::from(value != 0.0);
        if self.tally.first_without_point == 0 && value != 0.0 {
            self.tally.first_without_point = self.line;
        }
        Some(match (self.setup.without_point, self.inch) {
            (WithoutPoint::Unit, _) => value * unit,
            (WithoutPoint::Increment, false) => value * INCREMENT_MM,
            (WithoutPoint::Increment, true) => value * INCREMENT_IN * MM_PER_INCH,
        })
    }

    fn arc<F>(
        &mut self,
        block: &mut Block,
        clockwise: bool,
        span: Span,
        follow: &mut F,
    ) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        let ends = (self.at, self.target(block, span, Reach::Program)?);
        let in_words = |message| {
            Wrong::new(
                span,
                message,
                "check end, centre and plane (G17, G18, G19) of the arc",
            )
        };
        let centre = if block.has(b'R') {
            let radius = self.length(block, b'R').unwrap_or(0.0);
            if block.has_any(&CENTRES) {
                return Err(Wrong::new(
                    block.span(b'R'),
                    "the arc has a radius and a centre",
                    "keep one of them",
                ));
            }
            centre_of_radius(self.plane, clockwise, ends, radius).map_err(in_words)?
        } else {
            self.centre(block, span)?
        };
        let arc = around(self.plane, clockwise, ends, centre);
        match arc {
            Ok(arc) => self.go(ends.1, Shape::Arc(arc), false, span, follow),
            Err(message) => {
                self.at = ends.1; // what follows is judged from where the program means to be
                Err(in_words(message))
            }
        }
    }

    /// The centre by I, J, K: those of the plane.
    fn centre(&mut self, block: &mut Block, span: Span) -> Result<[f64; 2], Wrong> {
        let [first, second, _] = self.plane.axes();
        let words = [first, second].map(|axis| (axis, self.length(block, CENTRES[axis])));
        if words.iter().all(|(_, word)| word.is_none()) {
            return Err(Wrong::new(
                span,
                "the arc has neither a centre in its plane nor a radius",
                "write two of I, J, K, or R",
            ));
        }
        let base = if self.absolute_centre {
            self.base(span)?
        } else {
            self.at
        };
        if self.absolute_centre && words.iter().any(|(_, word)| word.is_none()) {
            return Err(Wrong::new(
                span,
                "with G90.1 both centre words are needed",
                "write both",
            ));
        }
        Ok(words.map(|(axis, word)| base[axis] + word.unwrap_or(0.0)))
    }

    /// Makes a move, and stands at its end.
    pub(super) fn go<F>(
        &mut self,
        to: Place,
        shape: Shape,
        rapid: bool,
        span: Span,
        follow: &mut F,
    ) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        let step = Move {
            from: self.at,
            to,
            shape,
            rapid,
            plane: self.plane,
            tool_mm: self.offsets.tool(),
            line: self.line,
            hole: self.hole,
        };
        self.at = to;
        let stays = (0..3).all(|k| (to[k] - step.from[k]).abs() <= 0.0);
        if matches!(step.shape, Shape::Line) && stays {
            return Ok(());
        }
        if self.is_lost {
            return Ok(());
        }
        follow(&step).map_err(|refused| Wrong::new(span, refused.message, refused.help))
    }

    /// M words: calls, ends, and those without effect on the path.
    fn programs(&mut self, block: &mut Block) -> Result<Flow, Wrong> {
        let mut flow = Flow::Next;
        for index in 0..block.m.len() {
            let word = block.m[index];
            let next = match word.tenths {
                20 | 300 => Flow::End,
                CALL => call(block, word.span)?,
                990 => Flow::Return,
                tenths if is_call(tenths) || tenths % 10 != 0 => {
                    return Err(Wrong::new(
                        word.span,
                        format!("`{}` is not executed", word.name('M')),
                        "M98 and M99 call and end subprograms of the same file",
                    ));
                }
                tenths => {
                    *self.tally.m.entry(tenths / 10).or_default() += 1;
                    continue;
                }
            };
            if flow != Flow::Next {
                return Err(Wrong::new(
                    word.span,
                    "two M words end or call a program",
                    "keep one of them",
                ));
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
        Some(times) => Flow::Call {
            program: number,
            times,
        },
        None if number > 9999 => Flow::Call {
            program: number % 10_000,
            times: number / 10_000,
        },
        None => Flow::Call {
            program: number,
            times: 1,
        },
    })
}

/// A whole number that a word needs.
fn named(block: &mut Block, letter: u8, span: Span, word: &str) -> Result<u32, Wrong> {
    let letter_shown = char::from(letter);
    block.whole(letter)?.ok_or_else(|| {
        Wrong::new(
            span,
            format!("`{word}` needs `{letter_shown}`"),
            format!("write `{letter_shown}` with its number in the same block"),
        )
    })
}

fn unknown_system(span: Span, name: &str) -> Wrong {
    Wrong::new(
        span,
        format!("the zero of {name} in machine coordinates is not known"),
        format!(
            "add `[[path.offset]]` with `system = \"{name}\"`, `x_mm`, `y_mm`, `z_mm` to the job (zeros, if the program is in machine coordinates)"
        ),
    )
}

/// The first axis word of a block, or its centre.
pub(super) fn first_span(block: &Block) -> Span {
    let letters = b"XYZIJKR";
    let places = letters.iter().filter(|letter| block.has(**letter));
    places
        .map(|letter| block.span(*letter))
        .min()
        .unwrap_or((0, 1))
}

/// Words that nothing in the block takes.
fn refuse_unused(block: &mut Block, motion: Option<Motion>) {
    let unused: Vec<(char, Span)> = block.unused().collect();
    for (letter, span) in unused {
        let (message, help) = match letter {
            'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'E' => (
                format!("axis `{letter}` is not executed: the model has X, Y and Z"),
                "let the CAM system write a program of three axes",
            ),
            'O' => (
                "`O` begins a program before the one above ended".to_string(),
                "end a program with M30, a subprogram with M99",
            ),
            'I' | 'J' | 'K' | 'R' if !matches!(motion, Some(Motion::Arc { .. })) => (
                format!("`{letter}` without an arc or a cycle"),
                "write G2 or G3, or remove the word",
            ),
            _ => (
                format!("`{letter}` belongs to no word of this block"),
                "remove it, or write the word that it belongs to",
            ),
        };
        block.wrong.push(Wrong::new(span, message, help));
    }
}
