//! Blocks whose axis words are not those of a motion: G4, G10, G28, G30, G52, G92, look-ahead.

use super::{AXES, Interpreter, Reach, named, unknown_system};
use crate::inputs::nc::block::{Block, CodeWord, Span};
use crate::inputs::nc::codes::Once;
use crate::inputs::nc::scan::Wrong;
use crate::inputs::nc::setup::Offsets;
use crate::inputs::nc::{Place, Shape, system_name};

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
