//! Blocks that move: where their words lead, lines, arcs and the start of cycles.

use super::{AXES, Interpreter, Reach, unknown_system};
use crate::MM_PER_INCH;
use crate::block::Block;
use crate::codes::{Cycle, Motion};
use crate::moves::{INCH_MISS_MM, USUAL_MISS_MM, around, centre_of_radius};
use crate::wrong::{Span, Wrong, refuse};
use crate::{Arc, Language, Move, Place, Shape, WithoutPoint, system_name};

const ABSOLUTE_CENTRE: &str = "the centre fits if it counts from the program's zero: write G90.1 before, if the control is set so";
const CENTRES: [u8; 3] = *b"IJK";
/// No machine has a kilometre of travel.
const FARTHEST_MM: f64 = 1e6;
/// Least input increment without a decimal point (IS-B).
const INCREMENT_MM: f64 = 0.001;
const INCREMENT_IN: f64 = 0.0001;

impl Interpreter {
    pub(super) fn set_motion(&mut self, motion: Motion) {
        if !matches!(motion, Motion::Cycle(_)) {
            self.cycle = None;
        } else if !matches!(self.motion, Some(Motion::Cycle(_))) {
            let third = self.plane.axes()[2];
            let zero = self.offsets.base.map(|base| base[third]);
            self.cycle = Some(Cycle { initial: self.at[third], zero, ..Cycle::default() });
        }
        self.motion = Some(motion);
    }

    /// A block whose axis words are those of the motion that is active; `machine` = G53.
    pub(super) fn motion(&mut self, block: &mut Block, machine: bool) -> Result<(), Wrong> {
        if let Some(Motion::Cycle(number)) = self.motion {
            return self.cycle_block(block, number);
        }
        let is_arc = matches!(self.motion, Some(Motion::Arc { .. }));
        if !(block.has_any(&AXES) || is_arc && block.has_any(b"IJKR")) {
            return Ok(());
        }
        match self.motion {
            Some(motion @ (Motion::Rapid | Motion::Straight)) => {
                let reach = match machine {
                    true => Reach::Machine,
                    false => Reach::Program,
                };
                let to = self.target(block, reach)?;
                self.go(to, Shape::Line, motion == Motion::Rapid);
                Ok(())
            }
            Some(Motion::Arc { clockwise }) => self.arc(block, clockwise),
            _ => Err(Wrong::new(
                self.span,
                "axis words, but no motion is active (after `G80` controls differ in it)",
                "write G0, G1, G2 or G3 before the coordinates",
            )),
        }
    }

    /// Where the axis words of a block lead.
    #[inline]
    pub(super) fn target(&mut self, block: &mut Block, reach: Reach) -> Result<Place, Wrong> {
        let words = self.axis_words(block);
        let incremental = AXES.map(|letter| block.is_incremental(letter, self.incremental));
        let counts = (0..3).any(|axis| words[axis].is_some() && !incremental[axis]);
        let base = match reach {
            Reach::Machine => self.machine_base(),
            _ if counts => self.base()?,
            _ => [0.0; 3],
        };
        let mut to = self.at;
        for axis in 0..3 {
            let Some(value) = words[axis] else { continue };
            self.ensure_settled(axis, incremental[axis] && reach == Reach::Program)?;
            to[axis] = if incremental[axis] { self.at[axis] + value } else { base[axis] + value };
            if axis == 2 {
                if incremental[2] && reach == Reach::Program {
                    to[2] += self.offsets.pending_z;
                }
                self.offsets.pending_z = 0.0; // what G43 or G49 left is made up for
            }
        }
        if to.iter().all(|mm| mm.abs() <= FARTHEST_MM) {
            return Ok(to);
        }
        let message = "the move leads farther than a kilometre";
        refuse(self.span, message, "check the coordinate and its decimal point")
    }

    /// Whether an incremental move takes a change of the zero in depends on a setting of a Siemens control.
    fn ensure_settled(&mut self, axis: usize, is_incremental: bool) -> Result<(), Wrong> {
        let is_open = self.setup.language == Language::Siemens && self.offsets.moved[axis];
        if is_incremental && is_open {
            let letter = char::from(AXES[axis]);
            let message = format!(
                "an incremental {letter} after the zero changed: setting data 42440 decides whether the change is moved too"
            );
            return refuse(self.span, message, "position the axis absolutely first");
        }
        self.offsets.moved[axis] = false;
        Ok(())
    }

    /// G53 leaves out the tool length too; that of Siemens does not.
    fn machine_base(&self) -> Place {
        let length = self.offsets.tool.unwrap_or(0.0);
        match self.setup.language {
            Language::Iso => [0.0; 3],
            Language::Siemens => [0.0, 0.0, length],
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
        unknown_system(span, &system_name(system))
    }

    pub(super) fn axis_words(&mut self, block: &mut Block) -> [Option<f64>; 3] {
        AXES.map(|letter| self.length(block, letter))
    }

    /// A length word in mm, as the units and the decimal point say.
    #[inline]
    pub(crate) fn length(&mut self, block: &mut Block, letter: u8) -> Option<f64> {
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

    fn arc(&mut self, block: &mut Block, clockwise: bool) -> Result<(), Wrong> {
        let tolerance_mm = self.arc_mm();
        let ends = (self.at, self.target(block, Reach::Program)?);
        let span = self.span;
        let in_words = |message| {
            Wrong::new(span, message, "check end, centre and plane (G17, G18, G19) of the arc")
        };
        let centre = if block.has(b'R') {
            let radius = self.length(block, b'R').unwrap_or(0.0);
            if block.has_any(&CENTRES) {
                let message = "the arc has a radius and a centre";
                return refuse(block.span(b'R'), message, "keep one of them");
            }
            centre_of_radius(self.plane, clockwise, ends, radius, tolerance_mm).map_err(in_words)?
        } else {
            self.centre(block)?
        };
        if self.is_turning_arc(block) {
            self.turns(block.span(b'K'), "an arc with K, but without G18,");
        }
        match around(self.plane, clockwise, ends, centre, tolerance_mm) {
            Ok(arc) => {
                self.tally_miss(arc, tolerance_mm);
                self.go(ends.1, Shape::Arc(arc), false);
                Ok(())
            }
            Err(message) => {
                let mut wrong = in_words(message);
                if self.fits_as_absolute(block, clockwise, ends, tolerance_mm) {
                    wrong.help = ABSOLUTE_CENTRE.to_string();
                }
                self.at = ends.1; // what follows is judged from where the program means to be
                Err(wrong)
            }
        }
    }

    /// In a program that never chose a plane: lathes have Z and X, and write no G18.
    fn is_turning_arc(&self, block: &Block) -> bool {
        !self.has_plane && block.has_any(b"XZ") && block.has(b'K') && !block.has_any(b"YJ")
    }

    /// Whether the centre words make an arc if they count from the program's zero.
    fn fits_as_absolute(
        &mut self,
        block: &mut Block,
        clockwise: bool,
        ends: (Place, Place),
        tolerance_mm: f64,
    ) -> bool {
        let [first, second, _] = self.plane.axes();
        let words = [first, second].map(|axis| self.length(block, CENTRES[axis]));
        let (Some(base), [Some(a), Some(b)]) = (self.offsets.base, words) else {
            return false;
        };
        let centre = [base[first] + a, base[second] + b];
        !self.absolute_centre && around(self.plane, clockwise, ends, centre, tolerance_mm).is_ok()
    }

    /// How far the end of an arc may miss its circle.
    fn arc_mm(&self) -> f64 {
        let usual = if self.inch { INCH_MISS_MM } else { USUAL_MISS_MM };
        self.setup.arc_mm.unwrap_or(usual)
    }

    /// Arcs that miss their circle by more than programs in millimetres do are told.
    fn tally_miss(&mut self, arc: Arc, allowed_mm: f64) {
        let miss = (arc.radius[1] - arc.radius[0]).abs();
        if miss <= USUAL_MISS_MM {
            return;
        }
        let line = self.line;
        let arcs = self.tally.rough_arcs.get_or_insert_default();
        arcs.count += 1;
        arcs.allowed_mm = arcs.allowed_mm.max(allowed_mm);
        if miss > arcs.most_mm {
            (arcs.most_mm, arcs.line) = (miss, line);
        }
    }

    /// The centre by I, J, K: those of the plane.
    fn centre(&mut self, block: &mut Block) -> Result<[f64; 2], Wrong> {
        let [first, second, _] = self.plane.axes();
        let words = [first, second].map(|axis| (axis, self.length(block, CENTRES[axis])));
        if words.iter().all(|(_, word)| word.is_none()) {
            let message = "the arc has neither a centre in its plane nor a radius";
            return refuse(self.span, message, "write two of I, J, K, or R");
        }
        let absolute =
            [first, second].map(|axis| !block.is_incremental(CENTRES[axis], !self.absolute_centre));
        let base = match absolute {
            [false, false] => self.at,
            _ => self.base()?,
        };
        if self.absolute_centre && words.iter().any(|(_, word)| word.is_none()) {
            return refuse(self.span, "with G90.1 both centre words are needed", "write both");
        }
        let from = |k: usize, axis: usize| {
            if absolute[k] { base[axis] } else { self.at[axis] }
        };
        Ok([0, 1].map(|k| from(k, words[k].0) + words[k].1.unwrap_or(0.0)))
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
            self.moves.push((step, self.span));
        }
    }
}
