//! The drilling cycles of Siemens: CYCLE81, CYCLE82, CYCLE83.
//!
//! ```text
//!   position ─ rapid ─→ RFP + SDIS ─ feed ─→ DP, or RFP − DPR ─ rapid ─→ RTP
//! ```
//! The pecks of CYCLE83 go the same way again, so the hole is fed once here.

use super::{AXES, Interpreter};
use crate::block::{Block, CycleCall};
use crate::codes::Drill;
use crate::wrong::Wrong;

impl Interpreter<'_> {
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

    fn drill(&mut self, drill: Drill) -> Result<(), Wrong> {
        let base = self.base()?[self.plane.axes()[2]];
        let [back, retract, bottom] = drill.levels.map(|mm| base + mm);
        self.hole(drill.number, self.at, [retract, bottom, back]);
        Ok(())
    }

    fn drill_of(&self, call: &CycleCall) -> Result<Option<Drill>, Wrong> {
        let refuse = |message: &str, help: &str| Err(Wrong::new(call.span, message, help));
        let Some((number, arguments)) = &call.cycle else {
            return Ok(None);
        };
        if self.inch {
            return refuse(
                "a cycle with G70 or G700 is not executed",
                "controls differ in the unit of its arguments: write it in millimetres",
            );
        }
        let argument = |index: usize| arguments.get(index).copied().flatten();
        let (Some(back), Some(reference)) = (argument(0), argument(1)) else {
            return refuse("the cycle lacks RTP or RFP", "write its first two arguments");
        };
        // Both are stated without a sign; where DP and DPR stand, the control takes DPR.
        let safety = argument(2).unwrap_or(0.0).abs();
        let bottom = argument(4).map(|depth| reference - depth.abs()).or(argument(3));
        let Some(bottom) = bottom else {
            return refuse("the cycle lacks its depth", "write DP or DPR");
        };
        let retract = reference + safety;
        if back < retract || bottom >= reference {
            return refuse(
                "the levels of the cycle are not in the order RTP, RFP + SDIS, depth",
                "check its first five arguments",
            );
        }
        Ok(Some(Drill { number: *number, levels: [back, retract, bottom] }))
    }
}
