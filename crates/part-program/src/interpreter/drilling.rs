//! The drilling cycles of Siemens: CYCLE81, CYCLE82, CYCLE83.
//!
//! ```text
//!   position ─ rapid ─→ RFP + SDIS ─ feed ─→ DP, or RFP − DPR ─ rapid ─→ RTP
//! ```
//! The pecks of CYCLE83 go the same way again, so the hole is fed once here.

use super::{AXES, Interpreter};
use crate::block::{Block, CycleCall};
use crate::codes::Drill;
use crate::wrong::{Wrong, refuse};

impl Interpreter {
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
        let (message, help) = match levels {
            _ if self.inch => (
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
                let levels = [back, reference + safety, bottom];
                return Ok(Some((*number, levels)));
            }
        };
        refuse(call.span, message, help)
    }
}
