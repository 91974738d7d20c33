//! Which line comes next: calls, returns, conditions and loops.

use super::{Call, Control};
use crate::flow::Flow;
use crate::jumps::Index;
use crate::lines::Text;
use crate::wrong::{Excerpt, Refused};

/// Calls inside each other; controls have 4 to 10.
const DEEPEST_CALLS: usize = 16;
/// What a line counts that is passed over in search of a block.
const PASSED: f64 = 0.1;
/// What a call and a return count: the text is taken up again elsewhere, which takes as long as this many blocks.
const JUMP: f64 = 10.0;

impl Control {
    /// Goes where a line leads; `place` says so.
    pub(super) fn go(
        &mut self,
        text: &mut dyn Text,
        flow: Flow,
        place: Option<Excerpt>,
    ) -> Result<(), Refused> {
        let (Some(place), false) = (place, matches!(flow, Flow::Call(_, 0))) else {
            return Ok(());
        };
        if matches!(flow, Flow::Call(..)) && self.calls.len() == DEEPEST_CALLS {
            let message = format!("more than {DEEPEST_CALLS} subprograms call each other");
            let help = "a subprogram must not call itself without end";
            return Err(Refused::new(message).at(place).help(help));
        }
        let back = text.mark();
        let index = match self.index.take() {
            Some(index) => index,
            None => Index::read(text)?,
        };
        let (to, passed) = self.index.insert(index).target(flow, text, back)?;
        self.repeated += passed as f64 * PASSED;
        match (to, flow) {
            (Ok(begin), Flow::Call(program, times)) => {
                self.entered = true;
                self.calls.push(Call { program, line: place.line, begin, back, left: times - 1 });
                self.jump(text, begin)
            }
            (Ok(mark), _) => {
                self.jumped |= mark.lines < place.line; // what follows may be executed again
                self.jump(text, mark)
            }
            (Err(missing), Flow::Call(..)) => {
                if self.found.insert((place.line, place.span.0)) {
                    let message = format!("there is no subprogram {missing} in the file");
                    let help = "put the subprograms behind the main program, each from `O…` to M99";
                    self.problems.push(Refused::new(message).at(place).help(help));
                }
                text.go_to(back)
            }
            (Err(missing), _) => {
                let message = format!("{missing} is not in the program");
                let help = "write it into the same program, or remove what leads to it";
                Err(Refused::new(message).at(place).help(help))
            }
        }
    }

    fn jump(&mut self, text: &mut dyn Text, to: crate::Mark) -> Result<(), Refused> {
        self.repeated += JUMP;
        text.go_to(to)
    }

    /// M99: the subprogram once more, or on behind its call.
    pub(super) fn go_back(&mut self, text: &mut dyn Text) -> Result<(), Refused> {
        let Some(mut call) = self.calls.pop() else {
            return Ok(());
        };
        if call.left == 0 {
            return self.jump(text, call.back);
        }
        call.left -= 1;
        self.entered = true;
        let begin = call.begin;
        self.calls.push(call);
        self.jump(text, begin)
    }
}
