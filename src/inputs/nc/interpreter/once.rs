//! Blocks whose axis words are not those of a motion: G4, G10, G28, G30, G52, G92, look-ahead.

use super::{AXES, Asked, Interpreter, Reach, named, unknown_system};
use crate::inputs::nc::block::{Block, CodeWord, Span};
use crate::inputs::nc::codes::Once;
use crate::inputs::nc::scan::Wrong;
use crate::inputs::nc::{Move, Place, Refused, Shape, system_name};

impl Interpreter<'_> {
    /// A block whose axis words are not those of a motion; true = it was one.
    pub(super) fn once<F>(
        &mut self,
        block: &mut Block,
        asked: Asked,
        follow: &mut F,
    ) -> Result<bool, Wrong>
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
}
