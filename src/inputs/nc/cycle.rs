//! Canned cycles G73, G81 … G89 as the moves they make.
//!
//! ```text
//!   position ─ rapid ─→ over the hole ─ rapid ─→ R ─ feed ─→ Z ─→ R (G99) or initial level (G98)
//! ```
//! G85, G89 and G84 leave the hole at the feed, the others at rapid. Pecks of G73 and G83 go the same
//! way again, so the hole is fed once here.
//!
//! R and Z stay as they were written. What they count from, zero or the level above, is the mode (G90,
//! G91) of the block that drills, as in RS274/NGC: their numbers are modal, their meaning is not.

use crate::inputs::nc::block::{Block, Span};
use crate::inputs::nc::codes::Level;
use crate::inputs::nc::depths::{Cycle, Depth};
use crate::inputs::nc::interpreter::{AXES, Interpreter, first_span};
use crate::inputs::nc::scan::Wrong;
use crate::inputs::nc::{Move, Place, Refused, Shape};

/// Holes of one block.
const MOST_REPEATS: u32 = 9999;

impl Interpreter<'_> {
    /// A block while a cycle is active.
    pub(super) fn cycle_block<F>(
        &mut self,
        block: &mut Block,
        number: u16,
        machine: Option<Span>,
        follow: &mut F,
    ) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        if let Some(span) = machine {
            return Err(Wrong::new(
                span,
                "`G53` while a cycle is active",
                "end the cycle with G80",
            ));
        }
        let drills = block.has_any(&AXES) || block.has(b'R');
        ["P", "Q"]
            .iter()
            .for_each(|letter| _ = block.value(letter.as_bytes()[0]));
        let times = match block.whole(b'K')? {
            Some(times) => times,
            None => block.whole_if_free(b'L')?.unwrap_or(1),
        };
        if times > MOST_REPEATS {
            return Err(Wrong::new(
                first_span(block),
                format!("{times} repeats of a cycle, expected at most {MOST_REPEATS}"),
                "check K or L",
            ));
        }
        if !drills {
            return Ok(());
        }
        let span = first_span(block);
        let (retract, bottom, initial) = self.depths(block, span)?;
        let place = self.place_of_hole(block, span)?;
        for repeat in 0..times {
            let step = if self.incremental {
                f64::from(repeat)
            } else {
                0.0
            };
            let over: Place = std::array::from_fn(|k| place.0[k] + place.1[k] * step);
            self.hole(number, over, (retract, bottom, initial), span, follow)?;
        }
        Ok(())
    }

    /// R, Z and the initial level in machine coordinates.
    fn depths(&mut self, block: &mut Block, span: Span) -> Result<(f64, f64, f64), Wrong> {
        let third = self.plane.axes()[2];
        let incremental = self.incremental;
        let depth = |mm| Depth { mm, incremental };
        let written = (
            self.length(block, b'R').map(depth),
            self.length(block, AXES[third]).map(depth),
        );
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
        if [retract, bottom]
            .iter()
            .any(|depth| depth.incremental != incremental)
        {
            self.tally.other_mode.get_or_insert(self.line);
        }
        self.check_initial(&cycle, span)?;
        let retract = self.level_of(retract, cycle.initial, span)?;
        let bottom = self.level_of(bottom, retract, span)?;
        Ok((retract, bottom, cycle.initial))
    }

    /// The machine coordinate of a depth; in G91 it counts from a level.
    fn level_of(&mut self, depth: Depth, from: f64, span: Span) -> Result<f64, Wrong> {
        let third = self.plane.axes()[2];
        let zero = if self.incremental {
            from
        } else {
            self.base(span)?[third]
        };
        Ok(zero + depth.mm)
    }

    /// Controls differ in where the initial level is after a change of zero or length.
    fn check_initial(&self, cycle: &Cycle, span: Span) -> Result<(), Wrong> {
        let third = self.plane.axes()[2];
        let zero = self.offsets.base().map(|base| base[third]);
        let counts = self.level == Level::Initial || self.incremental;
        let pending = self.incremental && third == 2 && self.offsets.pending_z.abs() > 0.0;
        if !pending && (!counts || zero == cycle.zero) {
            return Ok(());
        }
        Err(Wrong::new(
            span,
            "the zero or the tool length changed, and the cycle counts from the initial level: controls differ in where that is now",
            "end the cycle with G80, position with G0 in G90, and call it again",
        ))
    }

    /// Where the hole is, and the step from one repeat to the next.
    fn place_of_hole(&mut self, block: &mut Block, span: Span) -> Result<(Place, Place), Wrong> {
        let [first, second, _] = self.plane.axes();
        let base = if self.incremental {
            self.at
        } else {
            self.base(span)?
        };
        let (mut over, mut step) = (self.at, [0.0; 3]);
        for axis in [first, second] {
            if let Some(value) = self.length(block, AXES[axis]) {
                over[axis] = base[axis] + value;
                step[axis] = value;
            }
        }
        Ok((over, step))
    }

    fn hole<F>(
        &mut self,
        number: u16,
        over: Place,
        (retract, bottom, initial): (f64, f64, f64),
        span: Span,
        follow: &mut F,
    ) -> Result<(), Wrong>
    where
        F: FnMut(&Move) -> Result<(), Refused>,
    {
        let [first, second, third] = self.plane.axes();
        self.tally.holes += 1;
        let mut to = self.at;
        if (to[third] - retract) * (retract - bottom) < 0.0 {
            to[third] = retract; // below R: up first
            self.go(to, Shape::Line, true, span, follow)?;
        }
        (to[first], to[second]) = (over[first], over[second]);
        self.go(to, Shape::Line, true, span, follow)?;
        let back = match self.level {
            Level::Initial if (initial - retract) * (retract - bottom) > 0.0 => Some(initial),
            _ => None,
        };
        let feeds_out = matches!(number, 84 | 85 | 89);
        let levels = [
            (Some(retract), true, None),
            (Some(bottom), false, Some(self.tally.holes)),
            (Some(retract), !feeds_out, None),
            (back, true, None),
        ];
        for (level, rapid, hole) in levels {
            if let Some(level) = level {
                to[third] = level;
                self.hole = hole;
                let gone = self.go(to, Shape::Line, rapid, span, follow);
                self.hole = None;
                gone?;
            }
        }
        if third == 2 {
            self.offsets.pending_z = 0.0; // Z stands where the depths say
        }
        Ok(())
    }
}
