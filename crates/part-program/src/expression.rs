//! Expressions: numbers, variables, brackets, operators and functions of one argument. What has no value is refused
//! with its place.

use crate::grammar::{ROUNDING, applied, evaluated};
use crate::lexer::Lexer;
use crate::variables::is_of_control;
use crate::wrong::{Span, Wrong, refuse, refuse_long_number};

/// Brackets inside each other.
const DEEPEST: usize = 32;
const HELP: &str = "docs/path.md lists the expressions that are executed";

type Value = Result<f64, Wrong>;

impl Lexer<'_> {
    /// An expression with all its operators.
    pub(crate) fn expression(&mut self) -> Value {
        self.bound(0)
    }

    fn bound(&mut self, least: u8) -> Value {
        let mut value = self.primary()?;
        while let Some((sign, level)) = self.operator(least) {
            let place = (self.at, self.at + sign.len());
            self.at = place.1;
            let right = self.bound(level + 1)?;
            value = applied(sign, value, right)
                .map_err(|(message, help)| Wrong::new(place, message, help))?;
        }
        Ok(value)
    }

    fn operator(&mut self, least: u8) -> Option<(&'static str, u8)> {
        let mut operators = self.language.operators().iter();
        let found = operators.find(|(sign, _)| self.is_next(sign)).copied();
        found.filter(|(_, level)| *level >= least)
    }

    /// A number, a variable, brackets or a function, with its sign.
    pub(crate) fn primary(&mut self) -> Value {
        if self.depth == DEEPEST {
            let message = format!("more than {DEEPEST} brackets inside each other");
            return Err(self.wrong(message, "split the expression"));
        }
        self.depth += 1;
        let value = match self.peek() {
            Some(sign @ (b'-' | b'+')) => {
                self.at += 1;
                self.primary().map(|value| if sign == b'-' { -value } else { value })
            }
            Some(sign) if sign == self.language.brackets().0 => self.brackets(),
            Some(sign) if sign == self.language.variable() && self.begins_variable(sign) => {
                self.variable()
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'A'..=b'Z') => self.function(),
            _ => {
                let help = "expected a number, a variable or a bracket";
                Err(self.wrong("the expression lacks a number here", help))
            }
        };
        self.depth -= 1;
        value
    }

    /// `R` begins a variable only before its number; `#` always does.
    fn begins_variable(&self, sign: u8) -> bool {
        sign == b'#' || self.line.get(self.at + 1).is_some_and(u8::is_ascii_digit)
    }

    pub(crate) fn brackets(&mut self) -> Value {
        let start = self.at;
        let (open, close) = self.language.brackets();
        if !self.takes(open) {
            let open = char::from(open);
            return Err(self.wrong(format!("expected `{open}` here"), "write it in brackets"));
        }
        let value = self.expression()?;
        if self.takes(close) {
            return Ok(value);
        }
        let message = "the bracket is not closed, or something stands in it that is not executed";
        refuse((start, self.at.min(self.line.len()).max(start + 1)), message, HELP)
    }

    fn number(&mut self) -> Value {
        let start = self.at;
        let written = self.run_of(|byte| byte.is_ascii_digit() || *byte == b'.');
        self.at += written.len();
        let place = (start, self.at);
        refuse_long_number(place, written.bytes().filter(u8::is_ascii_digit).count())?;
        let message = || format!("`{written}` is no number");
        written.parse().map_err(|_| Wrong::new(place, message(), "write it like `10.5`"))
    }

    /// The name of a variable, from its sign on.
    pub(crate) fn name(&mut self) -> Result<String, Wrong> {
        let start = self.at;
        let sign = char::from(self.language.variable());
        self.at += 1;
        if sign == '#' && self.takes(b'<') {
            let rest = &self.line[self.at..];
            let length = rest.iter().position(|byte| *byte == b'>').unwrap_or(rest.len());
            let written = String::from_utf8_lossy(&rest[..length]);
            let name = written.replace([' ', '\t'], "").to_ascii_lowercase();
            self.at += length;
            if !self.takes(b'>') || name.is_empty() {
                return refuse((start, self.at), "the name is not closed with `>`", HELP);
            }
            return Ok(format!("#<{name}>"));
        }
        let number = if sign == '#' { self.primary()? } else { self.number()? };
        Ok(format!("{sign}{}", whole(number, (start, self.at))?))
    }

    fn variable(&mut self) -> Value {
        let start = self.at;
        let name = self.name()?;
        let place = (start, self.at);
        if is_of_control(&name) {
            let message =
                format!("`{name}` is a variable of the control, whose value only it knows");
            return refuse(place, message, "write the number in its place");
        }
        if self.set.contains(&name) {
            let message = format!(
                "`{name}` is set in the same block: controls differ in whether that counts here"
            );
            return refuse(place, message, "set it in a line before");
        }
        self.variables.and_then(|known| known.get(&name)).copied().ok_or_else(|| {
            let message = format!("`{name}` has no value: the program did not set it");
            Wrong::new(place, message, "set it at the beginning of the program")
        })
    }

    fn function(&mut self) -> Value {
        let word = self.run_of(u8::is_ascii_alphabetic);
        let place = (self.at, self.at + word.len());
        if !self.language.has_function(&word) {
            return refuse(place, format!("`{word}` is not executed in expressions"), HELP);
        }
        if self.in_word && word == "ROUND" {
            let message = "`ROUND` in a word: some controls round to their least increment there";
            return refuse(place, message, "set a variable to it in a line before");
        }
        self.at = place.1;
        let mut value = self.brackets()?;
        if word == "ATAN" {
            if !self.takes(b'/') {
                return refuse(place, "`ATAN` needs two numbers", "write `ATAN[y]/[x]`");
            }
            value = value.atan2(self.brackets()?).to_degrees();
        }
        evaluated(&word, value).map_err(|(message, help)| Wrong::new(place, message, help))
    }

    /// A whole number from 0, as those of variables, blocks and loops are.
    pub(crate) fn whole_number(&mut self) -> Result<u32, Wrong> {
        self.peek();
        let start = self.at;
        let value = self.primary()?;
        whole(value, (start, self.at))
    }
}

/// A whole number from 0 that names something.
fn whole(value: f64, place: Span) -> Result<u32, Wrong> {
    if (value - value.round()).abs() < ROUNDING
        && let Some(number) = natural(value).and(natural(value.round()))
    {
        return Ok(number);
    }
    let message = format!("{value} is no whole number from 0");
    refuse(place, message, "expected the number of a variable, a block or a loop")
}

/// The whole part of a number from 0 on that a control can have.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the number is checked to lie in the range before it is used"
)]
pub(crate) fn natural(value: f64) -> Option<u32> {
    (0.0..=99_999_999.0).contains(&value).then_some(value as u32)
}
