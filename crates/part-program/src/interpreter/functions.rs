//! Blocks that are no plain motion: G4, G10, G28, G30, G52, G92, look-ahead, and the canned cycles G73,
//! G81 … G89 as the moves they make.
//!
//! ```text
//!   position ─ rapid ─→ over the hole ─ rapid ─→ R ─ feed ─→ Z ─→ R (G99) or initial level (G98)
//! ```
//! G85, G89 and G84 leave the hole at the feed, the others at rapid. Pecks of G73 and G83 go the same
//! way again, so the hole is fed once here.
//!
//! R and Z stay as they were written. What they count from, zero or the level above, is the mode (G90,
//! G91) of the block that drills, as in RS274/NGC: their numbers are modal, their meaning is not.

use super::{AXES, Interpreter, Reach, named, unknown_system};
use crate::block::{Block, CodeWord, Span};
use crate::codes::{Cycle, Depth, Level, Once};
use crate::setup::Offsets;
use crate::wrong::Wrong;
use crate::{Place, Shape, system_name};

/// Holes of one block.
const MOST_REPEATS: u32 = 9999;

impl Interpreter<'_> {
    /// A block whose axis words are not those of a motion.
    pub(super) fn once(
        &mut self,
        block: &mut Block,
        once: Once,
        word: CodeWord,
    ) -> Result<(), Wrong> {
        match once {
            Once::Dwell => {
                for letter in *b"PXU" {
                    block.value(letter);
                }
                Ok(())
            }
            Once::SetOffset => self.set_offset(block, word.span),
            Once::Reference => self.go_home(block, word.span, self.setup.reference),
            Once::SecondReference => self.go_second(block, word.span),
            Once::Local => {
                self.each_word(block, |offsets, axis, _, mm| offsets.set_local(axis, mm))
            }
            Once::Translate(add) => self.translate(block, add),
            Once::Shift => {
                self.base()?;
                self.each_word(block, |offsets, axis, at, mm| offsets.call(axis, at, mm))
            }
            Once::CancelShift => {
                self.offsets.cancel_shift();
                Ok(())
            }
            Once::LookAhead => self.look_ahead(block, word),
        }
    }

    /// Changes the zero by each axis word of the block: its axis, where that stands, its value in mm.
    fn each_word(
        &mut self,
        block: &mut Block,
        change: impl Fn(&mut Offsets, usize, f64, f64),
    ) -> Result<(), Wrong> {
        for (axis, word) in self.axis_words(block).into_iter().enumerate() {
            if let Some(mm) = word {
                change(&mut self.offsets, axis, self.at[axis], mm);
            }
        }
        Ok(())
    }

    /// TRANS puts the zero of all axes, also of those that it does not name; ATRANS moves it further.
    fn translate(&mut self, block: &mut Block, add: bool) -> Result<(), Wrong> {
        for (axis, word) in self.axis_words(block).into_iter().enumerate() {
            let mm = word.unwrap_or(0.0);
            match add {
                true => self.offsets.add_local(axis, mm),
                false => self.offsets.set_local(axis, mm),
            }
        }
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
            return Err(Wrong::new(
                word.span,
                format!(
                    "`{name} {letter}{number}` is not executed, expected {letter}{on} or {letter}0 (look-ahead)"
                ),
                "splines and smoothing change the path: let the CAM system write short lines without them",
            ));
        }
        self.tally.look_ahead += u64::from(number != 0);
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
        let number = named(block, b'P', span, "G10 L2")?;
        if !(1..=9).contains(&number) {
            return Err(Wrong::new(
                block.span(b'P'),
                format!(
                    "`G10 L2 P{number}` is not executed: expected a coordinate system, P1 (G54) … P9 (G59.3); P0 moves all systems on some controls, on others the active one"
                ),
                "write the number of the system, or state its zero in the job",
            ));
        }
        let words = self.axis_words(block);
        if self.offsets.set_system(number, words, self.incremental) {
            return Ok(());
        }
        Err(unknown_system(span, &system_name(number)))
    }

    fn go_second(&mut self, block: &mut Block, span: Span) -> Result<(), Wrong> {
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
        self.go_home(block, span, place)
    }

    /// G28, G30: through a place to a reference point, with the axes that are named.
    fn go_home(&mut self, block: &mut Block, span: Span, home: Place) -> Result<(), Wrong> {
        if !block.has_any(&AXES) {
            return Err(Wrong::new(
                span,
                "no axis is named",
                "write the axes that go to the reference point, e.g. `G91 G28 Z0`",
            ));
        }
        let named = AXES.map(|letter| block.has(letter));
        let through = self.target(block, Reach::Home)?;
        self.go(through, Shape::Line, true);
        let end = std::array::from_fn(|k| if named[k] { home[k] } else { self.at[k] });
        self.go(end, Shape::Line, true);
        Ok(())
    }
}

impl Interpreter<'_> {
    /// A block while a cycle is active.
    pub(super) fn cycle_block(&mut self, block: &mut Block, number: u16) -> Result<(), Wrong> {
        let drills = block.has_any(&AXES) || block.has(b'R');
        for letter in *b"PQ" {
            block.value(letter);
        }
        let times = match block.whole(b'K')? {
            Some(times) => times,
            None => block.whole_if_free(b'L')?.unwrap_or(1),
        };
        if times > MOST_REPEATS {
            let message = format!("{times} repeats of a cycle, expected at most {MOST_REPEATS}");
            return Err(Wrong::new(self.span, message, "check K or L"));
        }
        if !drills {
            return Ok(());
        }
        let levels = self.levels(block)?;
        let (first, step) = self.place_of_hole(block)?;
        for repeat in 0..times {
            let repeat = f64::from(if self.incremental { repeat } else { 0 });
            let over = std::array::from_fn(|k| first[k] + step[k] * repeat);
            self.hole(number, over, levels);
        }
        Ok(())
    }

    /// R, Z and the initial level in machine coordinates.
    fn levels(&mut self, block: &mut Block) -> Result<[f64; 3], Wrong> {
        let span = self.span;
        let third = self.plane.axes()[2];
        let incremental = self.incremental;
        let depth = |mm| Depth { mm, incremental };
        let written =
            (self.length(block, b'R').map(depth), self.length(block, AXES[third]).map(depth));
        let Some(cycle) = self.cycle.as_mut() else {
            return Err(Wrong::new(span, "no cycle is active", "write G81 … G89"));
        };
        cycle.retract = written.0.or(cycle.retract);
        cycle.bottom = written.1.or(cycle.bottom);
        let cycle = *cycle;
        let (Some(retract), Some(bottom)) = (cycle.retract, cycle.bottom) else {
            return Err(Wrong::new(
                span,
                "the cycle has no R level or no bottom",
                "write R and the depth in the block that calls the cycle",
            ));
        };
        if [retract, bottom].iter().any(|depth| depth.incremental != incremental) {
            self.tally.other_mode.get_or_insert(self.line);
        }
        self.check_initial(&cycle)?;
        let retract = self.level_of(retract, cycle.initial)?;
        let bottom = self.level_of(bottom, retract)?;
        Ok([retract, bottom, cycle.initial])
    }

    /// The machine coordinate of a depth; in G91 it counts from a level.
    fn level_of(&mut self, depth: Depth, from: f64) -> Result<f64, Wrong> {
        let third = self.plane.axes()[2];
        let zero = if self.incremental { from } else { self.base()?[third] };
        Ok(zero + depth.mm)
    }

    /// Controls differ in where the initial level is after a change of zero or length.
    fn check_initial(&self, cycle: &Cycle) -> Result<(), Wrong> {
        let third = self.plane.axes()[2];
        let zero = self.offsets.base.map(|base| base[third]);
        let counts = self.level == Level::Initial || self.incremental;
        let pending = self.incremental && third == 2 && self.offsets.pending_z.abs() > 0.0;
        if !pending && (!counts || zero == cycle.zero) {
            return Ok(());
        }
        Err(Wrong::new(
            self.span,
            "the zero or the tool length changed, and the cycle counts from the initial level: controls differ in where that is now",
            "end the cycle with G80, position with G0 in G90, and call it again",
        ))
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
        let feeds_out = matches!(number, 84 | 85 | 89);
        reach(self, retract, !feeds_out);
        if self.level == Level::Initial && (initial - retract) * (retract - bottom) > 0.0 {
            reach(self, initial, true);
        }
        if third == 2 {
            self.offsets.pending_z = 0.0; // Z stands where the depths say
        }
    }
}
