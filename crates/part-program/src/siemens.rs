//! Words of a Siemens program: `X=IC(5)`, `CR=10`, `TRANS X10`, `MCALL CYCLE81(…)`.
//!
//! They become the same block as those of another control, so all that follows is the same: `CR` is the letter R, the
//! names are G words by their number in [`codes`](super::codes).

use crate::block::{Block, CodeWord, CycleCall};
use crate::codes::{SIEMENS_CYCLES, named_word};
use crate::lexer::{Counts, Lexer, NAME, Word};
use crate::wrong::{Span, Wrong, refuse};

/// Arguments of a call; CYCLE83 has twelve that are executed.
const MOST_ARGUMENTS: usize = 40;
/// A call whose first argument says how far the control may leave the path.
const TOLERANCE: &str = "CYCLE832";
/// Calls that only show something, and that one.
const SHOWS: [&str; 5] = ["MSG", "WORKPIECE", "GROUP_BEGIN", "GROUP_END", TOLERANCE];
const HELP: &str = "docs/volume.md lists the words of Siemens programs that are executed";

impl Lexer<'_> {
    /// Puts a word with what belongs to it into a block.
    pub(crate) fn item(&mut self, word: Word, block: &mut Block) -> Result<(), Wrong> {
        let (start, end) = word.span;
        match word.letter {
            NAME => return self.named(word.span, block),
            letter if letter.is_ascii_uppercase() && self.takes(b'=') => {
                return match end - start {
                    1 => self.assigned(block, letter, start),
                    _ => self.extended(word),
                };
            }
            b'L' => {
                let what = format!("`L{}` calls a subprogram, which is not executed", word.value);
                return refuse(word.span, what, HELP);
            }
            _ => block.take(word),
        }
        Ok(())
    }

    fn named(&mut self, span: Span, block: &mut Block) -> Result<(), Wrong> {
        let name = String::from_utf8_lossy(&self.line[span.0..span.1]).to_ascii_uppercase();
        match name.as_str() {
            "CR" if self.takes(b'=') => return self.assigned(block, b'R', span.0),
            "ADIS" if self.takes(b'=') => block.adis = Some(self.expression()?),
            "MCALL" => return self.cycle(block, true, span.0),
            name if SIEMENS_CYCLES.iter().any(|(known, ..)| *known == name) => {
                self.at = span.0;
                return self.cycle(block, false, span.0);
            }
            name if SHOWS.contains(&name) => {
                self.peek();
                let mut arguments = self.clone();
                arguments.at += 1;
                let tolerance = arguments.expression().ok().filter(|_| name == TOLERANCE);
                block.adis = tolerance.or(block.adis);
                return self.pass_over_call(span);
            }
            name => match named_word(name) {
                Some(tenths) => return block.add(b'G', CodeWord { tenths, span }),
                None => return refuse(span, format!("`{name}` is not executed"), HELP),
            },
        }
        Ok(())
    }

    /// `S2=1000`, `M2=3`, `H1=5` are those of another spindle, without effect on the path.
    fn extended(&mut self, word: Word) -> Result<(), Wrong> {
        if matches!(word.letter, b'S' | b'M' | b'H') {
            return self.expression().map(|_| ());
        }
        let what = format!("`{}{}=` is not executed", char::from(word.letter), word.value);
        let help = "axes are X, Y and Z; set R parameters in a line of their own";
        refuse((word.span.0, self.at), what, help)
    }

    /// What stands behind `=`.
    fn assigned(&mut self, block: &mut Block, letter: u8, start: usize) -> Result<(), Wrong> {
        if letter == b'T' && self.peek() == Some(b'"') {
            block.tool_name = Some((self.quoted()?, (start, self.at)));
            return Ok(());
        }
        let word = self.identifier();
        let counts = match word.as_str() {
            "IC" => Counts::Incremental,
            "AC" => Counts::Absolute,
            "DC" | "ACP" | "ACN" | "CAC" | "CIC" | "CDC" | "CACP" | "CACN" => {
                let what =
                    format!("`{word}( )` is not executed: it is for rotary and indexing axes");
                return refuse((start, self.at + word.len()), what, HELP);
            }
            _ => Counts::AsActive,
        };
        let value = if counts == Counts::AsActive {
            self.expression()?
        } else {
            self.at += word.len();
            self.brackets()?
        };
        let span = (start, self.at);
        if counts != Counts::AsActive && !b"XYZIJK".contains(&letter) {
            let what = format!("`{word}( )` is executed with X, Y, Z, I, J, K only");
            return refuse(span, what, HELP);
        }
        block.take(Word { letter, value, has_point: true, counts, span });
        Ok(())
    }

    /// The text between quotation marks.
    fn quoted(&mut self) -> Result<String, Wrong> {
        let start = self.at;
        let rest = &self.line[start + 1..];
        let Some(length) = rest.iter().position(|byte| *byte == b'"') else {
            return refuse((start, start + 1), "the text is not closed", "close it with `\"`");
        };
        self.at = start + length + 2;
        Ok(String::from_utf8_lossy(&rest[..length]).trim().to_string())
    }

    /// Arguments of a call that only shows something.
    fn pass_over_call(&mut self, span: Span) -> Result<(), Wrong> {
        let mut depth = 0_usize;
        while let Some(sign) = self.peek() {
            match sign {
                b'"' => {
                    self.quoted()?;
                    continue;
                }
                b'(' => depth += 1,
                b')' => depth = depth.saturating_sub(1),
                _ if depth == 0 => break,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Ok(());
            }
        }
        refuse(span, "the brackets of the call are not closed", "close them with `)`")
    }

    /// `CYCLE81(…)`, behind `MCALL` too; it stands in a block of its own.
    fn cycle(&mut self, block: &mut Block, modal: bool, start: usize) -> Result<(), Wrong> {
        let name = self.identifier();
        let place = self.at;
        self.at += name.len();
        let span = (start, self.at);
        let cycle = match SIEMENS_CYCLES.iter().find(|(known, ..)| *known == name) {
            Some((_, number, most)) => {
                let arguments = self.arguments()?;
                if arguments.iter().skip(*most).any(Option::is_some) {
                    let what = format!("`{name}` is executed with its first {most} arguments only");
                    return refuse(span, what, "leave out what stands behind them");
                }
                Some((*number, arguments))
            }
            None if name.is_empty() => None,
            None => return refuse((place, span.1), format!("`{name}` is not executed"), HELP),
        };
        if !matches!(self.peek(), None | Some(b';')) || !block.is_empty() {
            let help = "write MCALL and the call of the cycle in a line of their own";
            return refuse(span, "words beside the call of a cycle", help);
        }
        block.cycle = Some(CycleCall { modal, cycle, span });
        Ok(())
    }

    /// `(5, , R1)`: what is left out is missing.
    fn arguments(&mut self) -> Result<Vec<Option<f64>>, Wrong> {
        let mut arguments = Vec::new();
        if !self.takes(b'(') {
            return Err(self.wrong("expected `(` with the arguments here", HELP));
        }
        while arguments.len() < MOST_ARGUMENTS {
            let is_left_out = matches!(self.peek(), Some(b',' | b')'));
            arguments.push(if is_left_out { None } else { Some(self.expression()?) });
            if self.takes(b')') {
                return Ok(arguments);
            }
            if !self.takes(b',') {
                return Err(self.wrong("expected `,` or `)` here", HELP));
            }
        }
        Err(self.wrong("the call has too many arguments", HELP))
    }
}
