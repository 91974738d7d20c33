//! Which line comes next: calls, returns, conditions and loops.

use super::{Call, Control, DEEPEST_CALLS, JUMP, PASSED};
use crate::inputs::nc::flow::{Keyword, Label, Statement};
use crate::inputs::nc::jumps::Index;
use crate::inputs::nc::lines::{Mark, Text};
use crate::text::problem::{Place, Problem, Problems};

impl Control<'_> {
    /// The index of the text, which is read where this is asked for the first time.
    fn index(&mut self, text: &mut dyn Text) -> Result<&mut Index, Problems> {
        let index = match self.index.take() {
            Some(index) => index,
            None => Index::read(text).map_err(|problem| self.all(problem))?,
        };
        Ok(self.index.insert(index))
    }

    pub(super) fn call(
        &mut self,
        text: &mut dyn Text,
        label: &Label,
        times: u32,
        place: Place,
    ) -> Result<(), Problems> {
        if self.calls.len() == DEEPEST_CALLS {
            let message = format!("more than {DEEPEST_CALLS} subprograms call each other");
            let help = "a subprogram must not call itself without end";
            return Err(self.all(Problem::new(message).at(place).help(help)));
        }
        let (program, is_sub) = match label {
            Label::Word(name, _) => (name.clone(), true),
            Label::Program(number) => (number.to_string(), false),
            Label::Do(_) | Label::End(_) => return Ok(()),
        };
        let back = text.mark();
        let Some(spot) = self.index(text)?.first(label) else {
            text.go_to(back)?;
            if self.found.insert((place.line, place.column)) {
                let message = format!("there is no subprogram O{program} in the file");
                let help = match is_sub {
                    true => "put it into the file, from `O… sub` to `O… endsub`",
                    false => "put the subprograms behind the main program, each from `O…` to M99",
                };
                self.problems.push(Problem::new(message).at(place).help(help));
            }
            return Ok(());
        };
        let begin = if is_sub { spot.end } else { spot.begin };
        text.go_to(begin)?;
        self.entered = !is_sub;
        self.repeated += JUMP;
        self.calls.push(Call { program, is_sub, line: place.line, begin, back, left: times - 1 });
        Ok(())
    }

    pub(super) fn go_back(&mut self, text: &mut dyn Text) -> Result<(), Problem> {
        self.repeated += JUMP;
        let Some(call) = self.calls.last_mut() else {
            return Ok(());
        };
        if call.left > 0 {
            call.left -= 1;
            self.entered = true;
            return text.go_to(call.begin);
        }
        let (back, is_sub) = (call.back, call.is_sub);
        self.calls.pop();
        if is_sub {
            self.variables.leave();
        }
        text.go_to(back)
    }

    /// Goes where a statement leads.
    pub(super) fn go(
        &mut self,
        text: &mut dyn Text,
        statement: Statement,
        place: Place,
    ) -> Result<(), Problems> {
        let here = text.mark();
        let to = match statement {
            Statement::Done | Statement::Do(_, true) => return Ok(()),
            Statement::Word(name, keyword, holds) => {
                return self.word(text, name, (keyword, holds), place);
            }
            Statement::Call(name, arguments) => {
                let calls = self.calls.len();
                self.call(text, &Label::Word(name, Keyword::Sub), 1, place)?;
                if self.calls.len() > calls {
                    self.variables.enter(&arguments);
                }
                return Ok(());
            }
            Statement::GoTo(number) => {
                let found = self.index(text)?.block(text, number, here);
                let (to, passed) = found.map_err(|problem| self.all(problem))?;
                self.repeated += passed as f64 * PASSED;
                to.ok_or(format!("N{number}"))
            }
            Statement::Do(number, false) => {
                let end = self.index(text)?.after(&[Label::End(number)], here);
                let end = end.map(|(spot, _)| spot.end);
                end.ok_or(format!("END{number}"))
            }
            Statement::End(number) => {
                let begin = self.index(text)?.before(&Label::Do(number), here);
                let begin = begin.map(|spot| spot.begin);
                begin.ok_or(format!("DO{number}"))
            }
        };
        self.jump(text, to, place)
    }

    /// A line of LinuxCNC's `O…`.
    fn word(
        &mut self,
        text: &mut dyn Text,
        name: String,
        (keyword, holds): (Keyword, bool),
        place: Place,
    ) -> Result<(), Problems> {
        let here = text.mark();
        let label = |keyword| Label::Word(name.clone(), keyword);
        let seeking = std::mem::take(&mut self.seeking);
        let behind: &[Keyword] = match keyword {
            Keyword::If if holds => return Ok(()),
            Keyword::ElseIf if seeking && holds => return Ok(()),
            Keyword::While if holds => return Ok(()),
            Keyword::EndIf | Keyword::Call => return Ok(()),
            Keyword::EndSub | Keyword::Return => {
                if self.calls.last().is_some_and(|call| call.is_sub) {
                    return Ok(self.go_back(text)?);
                }
                return self.jump(text, Err(format!("a call of O{name}")), place);
            }
            Keyword::EndWhile | Keyword::Continue => {
                let begin = self.index(text)?.before(&label(Keyword::While), here);
                let begin = begin.map(|spot| spot.begin);
                return self.jump(text, begin.ok_or(format!("O{name} while")), place);
            }
            Keyword::Sub => &[Keyword::EndSub],
            Keyword::If => &[Keyword::ElseIf, Keyword::Else, Keyword::EndIf],
            Keyword::ElseIf if seeking => &[Keyword::ElseIf, Keyword::Else, Keyword::EndIf],
            Keyword::ElseIf | Keyword::Else => &[Keyword::EndIf],
            Keyword::While | Keyword::Break => &[Keyword::EndWhile],
        };
        let labels: Vec<Label> = behind.iter().map(|keyword| label(*keyword)).collect();
        let found = self.index(text)?.after(&labels, here);
        let to = found.map(|(spot, found)| {
            self.seeking = found == label(Keyword::ElseIf);
            if self.seeking { spot.begin } else { spot.end }
        });
        self.jump(text, to.ok_or(format!("the end of O{name}")), place)
    }

    fn jump(
        &mut self,
        text: &mut dyn Text,
        to: Result<Mark, String>,
        place: Place,
    ) -> Result<(), Problems> {
        match to {
            Ok(mark) => {
                self.jumped |= mark.lines < place.line; // what follows may be executed again
                self.repeated += JUMP;
                Ok(text.go_to(mark)?)
            }
            Err(missing) => {
                let message = format!("{missing} is not in the program");
                let help = "write it into the same program, or remove what leads to it";
                Err(self.all(Problem::new(message).at(place).help(help)))
            }
        }
    }
}
