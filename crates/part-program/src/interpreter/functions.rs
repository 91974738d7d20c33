//! Blocks that are no plain motion: G4, G10, G28, G30, G52, G92, look-ahead, and the canned cycles G73,
//! G81 … G89 as the moves they make.
//!
//! ```text
//!   position ─ rapid ─→ over the hole ─ rapid ─→ R ─ feed ─→ Z ─→ R (G99) or initial level (G98)
//! ```
//! G85, G89 and G84 leave the hole at the feed, the others at rapid. Pecks of G73 and G83 go the same
//! way again, so the hole is fed once here.
//!
//! The drilling cycles of Siemens, CYCLE81, CYCLE82 and CYCLE83, make the same moves from RFP + SDIS to DP (or RFP − DPR)
//! and RTP.
//!
//! R and Z stay as they were written. What they count from, zero or the level above, is the mode (G90,
//! G91) of the block that drills, as in RS274/NGC: their numbers are modal, their meaning is not.

use super::{AXES, Interpreter, named, unknown_system};
use crate::block::{Block, CALL, CodeWord, CycleCall};
use crate::codes::{ATRANS, Cycle, Drill, TRANS};
use crate::setup::Offsets;
use crate::wrong::{Span, Wrong, refuse};
use crate::{Place, Shape};

/// Holes of one block.
const MOST_REPEATS: u32 = 9999;

impl Interpreter {
    /// A block whose axis words are not those of a motion.
    pub(super) fn once(&mut self, block: &mut Block, word: CodeWord) -> Result<(), Wrong> {
        match word.tenths {
            40 => {
                for letter in *b"PXU" {
                    block.value(letter);
                }
                Ok(())
            }
            100 => self.set_offset(block, word.span),
            280 => self.go_home(block, word.span, self.setup.reference),
            300 => self.go_second(block, word.span),
            520 | 920 | 921 | TRANS | ATRANS => self.move_zero(block, word.tenths),
            _ => self.look_ahead(block, word),
        }
    }

    /// G52 and TRANS put the zero, ATRANS moves it further, G92 says where the axes are; TRANS those of all axes,
    /// also of those that it does not name. G92.1 takes back what G92 did.
    fn move_zero(&mut self, block: &mut Block, tenths: u16) -> Result<(), Wrong> {
        let base = if tenths == 920 { self.base()? } else { [0.0; 3] };
        let words = if tenths == 921 { [None; 3] } else { self.axis_words(block) };
        let Offsets { local, shift, .. } = &mut self.offsets;
        for axis in 0..3 {
            match (tenths, words[axis]) {
                (921, _) => shift[axis] = 0.0,
                (920, Some(mm)) => shift[axis] += self.at[axis] - (base[axis] + mm),
                (ATRANS, Some(mm)) => local[axis] += mm,
                (520, Some(mm)) => local[axis] = mm,
                (TRANS, mm) => local[axis] = mm.unwrap_or(0.0),
                _ => {}
            }
        }
        self.offsets.update();
        Ok(())
    }

    /// G5 P10000, G5.1 Q1, G8 P1 and their ends: the path stays.
    fn look_ahead(&mut self, block: &mut Block, word: CodeWord) -> Result<(), Wrong> {
        let (letter, on) = match word.tenths {
            50 => (b'P', 10_000),
            51 => (b'Q', 1),
            _ => (b'P', 1),
        };
        block.value(b'R');
        let name = word.name('G');
        let number = named(block, letter, word.span, &name)?;
        if number != 0 && number != on {
            let letter = char::from(letter);
            let what = format!(
                "`{name} {letter}{number}` is not executed, expected {letter}{on} or {letter}0 (look-ahead)"
            );
            let help = "splines and smoothing change the path: let the CAM system write short lines without them";
            return refuse(word.span, what, help);
        }
        self.tally.look_ahead += u64::from(number != 0);
        Ok(())
    }

    /// G10 L2 P… X… Y… Z…
    fn set_offset(&mut self, block: &mut Block, span: Span) -> Result<(), Wrong> {
        if named(block, b'L', span, "G10")? != 2 {
            let what = "`G10` is executed with L2 only (zero of a coordinate system)";
            let help = "state other data in the job, and remove the block";
            return refuse(block.span(b'L'), what, help);
        }
        let number = named(block, b'P', span, "G10 L2")?;
        if !(1..=9).contains(&number) {
            let what = format!(
                "`G10 L2 P{number}` is not executed: expected a coordinate system, P1 (G54) … P9 (G59.3); P0 moves all systems on some controls, on others the active one"
            );
            let help = "write the number of the system, or state its zero in the job";
            return refuse(block.span(b'P'), what, help);
        }
        let words = self.axis_words(block);
        if self.offsets.set_system(number, words, self.incremental) {
            return Ok(());
        }
        Err(unknown_system(span, number))
    }

    fn go_second(&mut self, block: &mut Block, span: Span) -> Result<(), Wrong> {
        if block.whole(b'P')?.is_some_and(|number| number != 2) {
            let what = "only the second reference point (`G30`, `G30 P2`) is known";
            return refuse(block.span(b'P'), what, "write the move with G53");
        }
        let Some(place) = self.setup.second_reference else {
            let help = "add `second_reference_mm = { x = …, y = …, z = … }` to [path] of the job";
            return refuse(span, "the second reference point is not known", help);
        };
        self.go_home(block, span, place)
    }

    /// G28, G30: through a place to a reference point, with the axes that are named.
    fn go_home(&mut self, block: &mut Block, span: Span, home: Place) -> Result<(), Wrong> {
        if !block.has_any(&AXES) {
            let help = "write the axes that go to the reference point, e.g. `G91 G28 Z0`";
            return refuse(span, "no axis is named", help);
        }
        let named = AXES.map(|letter| block.has(letter));
        let through = self.target(block, false)?;
        self.go(through, Shape::Line, true);
        let end = std::array::from_fn(|k| if named[k] { home[k] } else { self.at[k] });
        self.go(end, Shape::Line, true);
        Ok(())
    }

    /// A block while a cycle is active.
    pub(super) fn cycle_block(&mut self, block: &mut Block, number: u16) -> Result<(), Wrong> {
        let drills = block.has_any(&AXES) || block.has(b'R');
        for letter in *b"PQ" {
            block.value(letter);
        }
        let times = match block.whole(b'K')? {
            Some(times) => times,
            // An M98 of the block needs L for itself.
            None if block.m_word(CALL).is_some() => 1,
            None => block.whole(b'L')?.unwrap_or(1),
        };
        if times > MOST_REPEATS {
            let what = format!("{times} repeats of a cycle, expected at most {MOST_REPEATS}");
            return Err(Wrong::new(self.span, what, "check K or L"));
        }
        if !drills {
            return Ok(());
        }
        let levels = self.levels(block)?;
        let (first, step) = self.place_of_hole(block)?;
        for repeat in 0..times {
            let repeat = f64::from(if self.incremental { repeat } else { 0 });
            self.hole(number, std::array::from_fn(|k| first[k] + step[k] * repeat), levels);
        }
        Ok(())
    }

    /// R, Z and the initial level in machine coordinates.
    fn levels(&mut self, block: &mut Block) -> Result<[f64; 3], Wrong> {
        let third = self.plane.axes()[2];
        let incremental = self.incremental;
        let written = [b'R', AXES[third]].map(|letter| self.length(block, letter));
        let [above, below] = written.map(|depth| depth.map(|mm| (mm, incremental)));
        let cycle = &mut self.cycle;
        cycle.retract = above.or(cycle.retract);
        cycle.bottom = below.or(cycle.bottom);
        let cycle = *cycle;
        let (Some(retract), Some(bottom)) = (cycle.retract, cycle.bottom) else {
            let help = "write R and the depth in the block that calls the cycle";
            return refuse(self.span, "the cycle has no R level or no bottom", help);
        };
        if retract.1 != incremental || bottom.1 != incremental {
            self.tally.other_mode.get_or_insert(self.line);
        }
        self.check_initial(&cycle)?;
        // In G91 each depth counts from the level above.
        let zero = if incremental { None } else { Some(self.base()?[third]) };
        let retract = zero.unwrap_or(cycle.initial) + retract.0;
        let bottom = zero.unwrap_or(retract) + bottom.0;
        Ok([retract, bottom, cycle.initial])
    }

    /// Controls differ in where the initial level is after a change of zero or length.
    fn check_initial(&self, cycle: &Cycle) -> Result<(), Wrong> {
        let third = self.plane.axes()[2];
        let zero = self.offsets.base.map(|base| base[third]);
        let counts = !self.retracts || self.incremental;
        let pending = self.incremental && third == 2 && self.offsets.pending_z.abs() > 0.0;
        if !pending && (!counts || zero == cycle.zero) {
            return Ok(());
        }
        let what = "the zero or the tool length changed, and the cycle counts from the initial level: controls differ in where that is now";
        let help = "end the cycle with G80, position with G0 in G90, and call it again";
        refuse(self.span, what, help)
    }

    /// Where the hole is, and the step from one repeat to the next.
    fn place_of_hole(&mut self, block: &mut Block) -> Result<(Place, Place), Wrong> {
        let [first, second, _] = self.plane.axes();
        let base = if self.incremental { self.at } else { self.base()? };
        let (mut over, mut step) = (self.at, [0.0; 3]);
        for axis in [first, second] {
            if let Some(value) = self.length(block, AXES[axis]) {
                over[axis] = base[axis] + value;
                step[axis] = value;
            }
        }
        Ok((over, step))
    }

    pub(super) fn hole(&mut self, number: u16, over: Place, [retract, bottom, initial]: [f64; 3]) {
        let [first, second, third] = self.plane.axes();
        self.tally.holes += 1;
        let mut to = self.at;
        if (to[third] - retract) * (retract - bottom) < 0.0 {
            to[third] = retract; // below R: up first
            self.go(to, Shape::Line, true);
        }
        (to[first], to[second]) = (over[first], over[second]);
        self.go(to, Shape::Line, true);
        let mut reach = |control: &mut Self, level: f64, rapid: bool| {
            to[third] = level;
            control.go(to, Shape::Line, rapid);
        };
        reach(self, retract, true);
        self.hole = Some(self.tally.holes);
        reach(self, bottom, false);
        self.hole = None;
        reach(self, retract, !matches!(number, 84 | 85 | 89));
        if !self.retracts && (initial - retract) * (retract - bottom) > 0.0 {
            reach(self, initial, true);
        }
        if third == 2 {
            self.offsets.pending_z = 0.0; // Z stands where the depths say
        }
    }

    /// A cycle of the block, or the one that MCALL drills behind its move.
    pub(super) fn drills(&mut self, block: &mut Block, moves: bool) -> Result<(), Wrong> {
        if let Some(call) = block.cycle.take() {
            let drill = self.drill_of(&call)?;
            if call.modal {
                self.modal_drill = drill;
                return Ok(());
            }
            return drill.map_or(Ok(()), |drill| self.drill(drill));
        }
        match self.modal_drill.filter(|_| moves && block.has_any(&AXES)) {
            Some(drill) => self.drill(drill),
            None => Ok(()),
        }
    }

    fn drill(&mut self, (number, levels): Drill) -> Result<(), Wrong> {
        let base = self.base()?[self.plane.axes()[2]];
        let [back, retract, bottom] = levels.map(|mm| base + mm);
        self.hole(number, self.at, [retract, bottom, back]);
        Ok(())
    }

    fn drill_of(&self, call: &CycleCall) -> Result<Option<Drill>, Wrong> {
        let Some((number, arguments)) = &call.cycle else {
            return Ok(None);
        };
        let argument = |index: usize| arguments.get(index).copied().flatten();
        // Safety and DPR are stated without a sign; where DP and DPR stand, the control takes DPR.
        let safety = argument(2).unwrap_or(0.0).abs();
        let depth = |reference: f64| argument(4).map(|depth| reference - depth.abs());
        let levels = argument(0)
            .zip(argument(1))
            .map(|(back, reference)| (back, reference, depth(reference).or(argument(3))));
        let (what, help) = match levels {
            _ if self.is_inch() => (
                "a cycle with G70 or G700 is not executed",
                "controls differ in the unit of its arguments: write it in millimetres",
            ),
            None => ("the cycle lacks RTP or RFP", "write its first two arguments"),
            Some((_, _, None)) => ("the cycle lacks its depth", "write DP or DPR"),
            Some((back, reference, Some(bottom)))
                if back < reference + safety || bottom >= reference =>
            {
                (
                    "the levels of the cycle are not in the order RTP, RFP + SDIS, depth",
                    "check its first five arguments",
                )
            }
            Some((back, reference, Some(bottom))) => {
                return Ok(Some((*number, [back, reference + safety, bottom])));
            }
        };
        refuse(call.span, what, help)
    }
}
