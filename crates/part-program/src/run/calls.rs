//! Which line comes next: calls, returns, conditions and loops.

use super::{Call, Control, DEEPEST_CALLS, JUMP, PASSED};
use crate::flow::{Label, Statement};
use crate::jumps::Index;
use crate::lines::{Mark, Text};
use crate::wrong::{Excerpt, Refused};

impl Control<'_> {
    /// The index of the text, which is read where this is asked for the first time.
    fn index(&mut self, text: &mut dyn Text) -> Result<&mut Index, Refused> {
        let index = match self.index.take() {
            Some(index) => index,
            None => Index::read(text)?,
        };
        Ok(self.index.insert(index))
    }

    pub(super) fn call(
        &mut self,
        text: &mut dyn Text,
        program: u32,
        times: u32,
        place: Excerpt,
    ) -> Result<(), Refused> {
        if self.calls.len() == DEEPEST_CALLS {
            let message = format!("more than {DEEPEST_CALLS} subprograms call each other");
            let help = "a subprogram must not call itself without end";
            return Err(Refused::new(message).at(place).help(help));
        }
        let back = text.mark();
        let Some(begin) = self.index(text)?.first(&Label::Program(program)) else {
            text.go_to(back)?;
            if self.found.insert((place.line, place.span.0)) {
                let message = format!("there is no subprogram O{program} in the file");
                let help = "put the subprograms behind the main program, each from `O…` to M99";
                self.problems.push(Refused::new(message).at(place).help(help));
            }
            return Ok(());
        };
        text.go_to(begin)?;
        self.entered = true;
        self.repeated += JUMP;
        self.calls.push(Call { program, line: place.line, begin, back, left: times - 1 });
        Ok(())
    }

    pub(super) fn go_back(&mut self, text: &mut dyn Text) -> Result<(), Refused> {
        self.repeated += JUMP;
        let Some(call) = self.calls.last_mut() else {
            return Ok(());
        };
        if call.left > 0 {
            call.left -= 1;
            self.entered = true;
            return text.go_to(call.begin);
        }
        let back = call.back;
        self.calls.pop();
        text.go_to(back)
    }

    /// Goes where a statement leads.
    pub(super) fn go(
        &mut self,
        text: &mut dyn Text,
        statement: Statement,
        place: Excerpt,
    ) -> Result<(), Refused> {
        let here = text.mark();
        let to = match statement {
            Statement::Done => return Ok(()),
            Statement::GoTo(number) => {
                let found = self.index(text)?.block(text, number, here);
                let (to, passed) = found?;
                self.repeated += passed as f64 * PASSED;
                to.ok_or(format!("N{number}"))
            }
            Statement::Leave(number) => {
                let end = self.index(text)?.after(&Label::End(number), here);
                end.ok_or(format!("END{number}"))
            }
            Statement::End(number) => {
                let begin = self.index(text)?.before(&Label::Do(number), here);
                begin.ok_or(format!("DO{number}"))
            }
        };
        self.jump(text, to, place)
    }

    fn jump(
        &mut self,
        text: &mut dyn Text,
        to: Result<Mark, String>,
        place: Excerpt,
    ) -> Result<(), Refused> {
        match to {
            Ok(mark) => {
                self.jumped |= mark.lines < place.line; // what follows may be executed again
                self.repeated += JUMP;
                text.go_to(mark)
            }
            Err(missing) => {
                let message = format!("{missing} is not in the program");
                let help = "write it into the same program, or remove what leads to it";
                Err(Refused::new(message).at(place).help(help))
            }
        }
    }
}
