//! Blocks that move: where their words lead, lines, arcs and the start of cycles.

use super::{AXES, Interpreter, unknown_system};
use crate::block::Block;
use crate::codes::{Cycle, Motion};
use crate::moves::{INCH_MISS_MM, Turn, USUAL_MISS_MM};
use crate::wrong::{Span, Wrong, refuse};
use crate::{Arc, Language, MM_PER_INCH, Move, Place, Shape, WithoutPoint};

const ABSOLUTE_CENTRE: &str = "the centre fits if it counts from the program's zero: write G90.1 before, if the control is set so";
const CENTRES: [u8; 3] = *b"IJK";
/// No machine has a kilometre of travel.
const FARTHEST_MM: f64 = 1e6;
/// Least input increment without a decimal point (IS-B).
const INCREMENT_MM: f64 = 0.001;
const INCREMENT_IN: f64 = 0.0001;

impl Interpreter {
    pub(super) fn set_motion(&mut self, motion: Motion) {
        if !matches!(self.motion, Some(Motion::Cycle(_))) {
            let third = self.plane.axes()[2];
            let zero = self.offsets.base.map(|base| base[third]);
            self.cycle = Cycle { initial: self.at[third], zero, ..Cycle::default() };
        }
        self.motion = Some(motion);
    }

    /// A block whose axis words are those of the motion that is active.
    pub(super) fn motion(&mut self, block: &mut Block) -> Result<(), Wrong> {
        if let Some(Motion::Cycle(number)) = self.motion {
            return self.cycle_block(block, number);
        }
        let is_arc = matches!(self.motion, Some(Motion::Arc(_)));
        if !(block.has_any(&AXES) || is_arc && block.has_any(b"IJKR")) {
            return Ok(());
        }
        match self.motion {
            Some(motion @ (Motion::Rapid | Motion::Straight)) => {
                let to = self.target(block, !self.in_machine)?;
                self.go(to, Shape::Line, motion == Motion::Rapid);
                Ok(())
            }
            Some(Motion::Arc(clockwise)) => self.arc(block, clockwise),
            _ => {
                let what =
                    "axis words, but no motion is active (after `G80` controls differ in it)";
                refuse(self.span, what, "write G0, G1, G2 or G3 before the coordinates")
            }
        }
    }

    /// Where the axis words of a block lead; `plainly` = not by G53, G28 or G30, whose increments take no change of
    /// the length in.
    #[inline]
    pub(super) fn target(&mut self, block: &mut Block, plainly: bool) -> Result<Place, Wrong> {
        let words = self.axis_words(block);
        let incremental = AXES.map(|letter| block.is_incremental(letter, self.incremental));
        let counts = (0..3).any(|axis| words[axis].is_some() && !incremental[axis]);
        let base = if counts { self.zero()? } else { [0.0; 3] };
        let mut to = self.at;
        for axis in 0..3 {
            let Some(value) = words[axis] else { continue };
            self.ensure_settled(axis, incremental[axis] && plainly)?;
            to[axis] = if incremental[axis] { self.at[axis] + value } else { base[axis] + value };
            if axis == 2 {
                if incremental[2] && plainly {
                    to[2] += self.offsets.pending_z;
                }
                self.offsets.pending_z = 0.0; // what G43 or G49 left is made up for
            }
        }
        if to.iter().all(|mm| mm.abs() <= FARTHEST_MM) {
            return Ok(to);
        }
        let what = "the move leads farther than a kilometre";
        refuse(self.span, what, "check the coordinate and its decimal point")
    }

    /// Whether an incremental move takes a change of the zero in depends on a setting of a Siemens control.
    fn ensure_settled(&mut self, axis: usize, is_incremental: bool) -> Result<(), Wrong> {
        let is_open = self.setup.language == Language::Siemens && self.offsets.moved[axis];
        if is_incremental && is_open {
            let letter = char::from(AXES[axis]);
            let what = format!(
                "an incremental {letter} after the zero changed: setting data 42440 decides whether the change is moved too"
            );
            return refuse(self.span, what, "position the axis absolutely first");
        }
        self.offsets.moved[axis] = false;
        Ok(())
    }

    /// What absolute words of this block count from. G53 leaves out the tool length too; that of Siemens does not.
    fn zero(&mut self) -> Result<Place, Wrong> {
        match (self.in_machine, self.setup.language) {
            (false, _) => self.base(),
            (true, Language::Iso) => Ok([0.0; 3]),
            (true, Language::Siemens) => Ok([0.0, 0.0, self.offsets.tool.unwrap_or(0.0)]),
        }
    }

    pub(crate) fn base(&mut self) -> Result<Place, Wrong> {
        match self.offsets.base {
            Some(base) => Ok(base),
            None => Err(self.lose(self.span, self.offsets.active)),
        }
    }

    /// A coordinate system whose zero is not known: told once, and no move is followed any more.
    pub(super) fn lose(&mut self, span: Span, system: u32) -> Wrong {
        self.is_lost = true;
        self.offsets.set_system(system, [Some(0.0); 3], false);
        self.offsets.select(system);
        unknown_system(span, system)
    }

    pub(super) fn axis_words(&mut self, block: &mut Block) -> [Option<f64>; 3] {
        AXES.map(|letter| self.length(block, letter))
    }

    /// A length word in mm, as the units and the decimal point say.
    #[inline]
    pub(crate) fn length(&mut self, block: &mut Block, letter: u8) -> Option<f64> {
        let value = block.value(letter)?;
        let unit = if self.is_inch() { MM_PER_INCH } else { 1.0 };
        if self.inch.is_none() && value != 0.0 {
            self.tally.without_unit.get_or_insert(self.line);
        }
        if block.has_point(letter) {
            return Some(value * unit);
        }
        if value != 0.0 {
            self.tally.without_point.get_or_insert((0, self.line)).0 += 1;
        }
        Some(match (self.setup.without_point, self.is_inch()) {
            (WithoutPoint::Unit, _) => value * unit,
            (WithoutPoint::Increment, false) => value * INCREMENT_MM,
            (WithoutPoint::Increment, true) => value * INCREMENT_IN * MM_PER_INCH,
        })
    }

    fn arc(&mut self, block: &mut Block, clockwise: bool) -> Result<(), Wrong> {
        let usual_mm = if self.is_inch() { INCH_MISS_MM } else { USUAL_MISS_MM };
        let tolerance_mm = self.setup.arc_mm.unwrap_or(usual_mm);
        let (plane, from) = (self.plane, self.at);
        let to = self.target(block, true)?;
        let turn = Turn { plane, clockwise, from, to, tolerance_mm };
        let span = self.span;
        let in_words =
            |what| Wrong::new(span, what, "check end, centre and plane (G17, G18, G19) of the arc");
        let centre = if let Some(radius) = self.length(block, b'R') {
            if block.has_any(&CENTRES) {
                return refuse(
                    block.span(b'R'),
                    "the arc has a radius and a centre",
                    "keep one of them",
                );
            }
            turn.centre_of_radius(radius).map_err(in_words)?
        } else {
            self.centre(block, self.absolute_centre)?
        };
        // Lathes have Z and X, and write no G18.
        let turns = block.has(b'K') && block.has_any(b"XZ") && !block.has_any(b"YJ");
        if turns && !self.has_plane {
            self.turns(block.span(b'K'), "an arc with K, but without G18,");
        }
        let arc = turn.around(centre).map_err(|what| {
            let mut wrong = in_words(what);
            let known = self.offsets.base.filter(|_| !self.absolute_centre);
            let absolute = known.and_then(|_| self.centre(block, true).ok());
            if absolute.is_some_and(|centre| turn.around(centre).is_ok()) {
                wrong.help = ABSOLUTE_CENTRE.to_string();
            }
            self.at = to; // what follows is judged from where the program means to be
            wrong
        })?;
        self.tally_miss(arc, tolerance_mm);
        self.go(to, Shape::Arc(arc), false);
        Ok(())
    }

    /// Arcs that miss their circle by more than programs in millimetres do are told.
    fn tally_miss(&mut self, arc: Arc, allowed_mm: f64) {
        let miss = (arc.radius[1] - arc.radius[0]).abs();
        if miss > USUAL_MISS_MM {
            let arcs = self.tally.rough_arcs.get_or_insert_default();
            arcs.count += 1;
            arcs.allowed_mm = arcs.allowed_mm.max(allowed_mm);
            if miss > arcs.most_mm {
                (arcs.most_mm, arcs.line) = (miss, self.line);
            }
        }
    }

    /// The centre by I, J, K: those of the plane, from the start or the program's zero.
    fn centre(&mut self, block: &mut Block, from_zero: bool) -> Result<[f64; 2], Wrong> {
        let [first, second, _] = self.plane.axes();
        let words = [first, second].map(|axis| self.length(block, CENTRES[axis]));
        if words == [None; 2] {
            let what = "the arc has neither a centre in its plane nor a radius";
            return refuse(self.span, what, "write two of I, J, K, or R");
        }
        let absolute = [first, second].map(|axis| !block.is_incremental(CENTRES[axis], !from_zero));
        let base = if absolute == [false; 2] { self.at } else { self.base()? };
        if from_zero && words.iter().any(Option::is_none) {
            return refuse(self.span, "with G90.1 both centre words are needed", "write both");
        }
        let from = |k: usize, axis: usize| if absolute[k] { base[axis] } else { self.at[axis] };
        Ok([0, 1].map(|k| from(k, [first, second][k]) + words[k].unwrap_or(0.0)))
    }

    /// Makes a move, and stands at its end.
    #[inline]
    pub(crate) fn go(&mut self, to: Place, shape: Shape, rapid: bool) {
        let step = Move {
            from: self.at,
            to,
            shape,
            rapid,
            plane: self.plane,
            tool_mm: self.offsets.tool,
            line: self.line,
            hole: self.hole,
        };
        self.at = to;
        let stays = (0..3).all(|k| (to[k] - step.from[k]).abs() <= 0.0);
        let is_point = matches!(step.shape, Shape::Line) && stays;
        if !is_point && !self.is_lost {
            self.moves.push(step);
        }
    }
}
