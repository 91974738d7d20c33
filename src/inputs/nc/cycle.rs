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

use crate::inputs::nc::block::Block;
use crate::inputs::nc::codes::{Cycle, Depth, Level};
use crate::inputs::nc::interpreter::{AXES, Interpreter};
use crate::inputs::nc::scan::Wrong;
use crate::inputs::nc::{Place, Shape};

/// Holes of one block.
const MOST_REPEATS: u32 = 9999;

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
            return Err(Wrong::new(
                self.span,
                format!("{times} repeats of a cycle, expected at most {MOST_REPEATS}"),
                "check K or L",
            ));
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
        self.check_initial(&cycle)?;
        let retract = self.level_of(retract, cycle.initial)?;
        let bottom = self.level_of(bottom, retract)?;
        Ok([retract, bottom, cycle.initial])
    }

    /// The machine coordinate of a depth; in G91 it counts from a level.
    fn level_of(&mut self, depth: Depth, from: f64) -> Result<f64, Wrong> {
        let third = self.plane.axes()[2];
        let zero = if self.incremental {
            from
        } else {
            self.base()?[third]
        };
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
        let base = if self.incremental {
            self.at
        } else {
            self.base()?
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

    fn hole(&mut self, number: u16, over: Place, [retract, bottom, initial]: [f64; 3]) {
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
