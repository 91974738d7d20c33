//! Expressions: numbers, variables, brackets, operators and functions of one argument, as a grammar has them. What has
//! no value is refused with its place.

use crate::grammar::{Function, Grammar, Operator, ROUNDING, applied, evaluated};
use crate::variables::{Name, Variables};
use crate::wrong::{Wrong, refuse_long_number};

/// Brackets inside each other.
const DEEPEST: usize = 32;
/// Reads expressions from a place of a line on.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    pub(super) line: &'a [u8],
    pub(super) at: usize,
    grammar: &'static Grammar,
    pub(super) variables: &'a Variables,
    depth: usize,
    /// It is the number of a word.
    in_word: bool,
    /// What the block sets before this place.
    pub(super) set: Vec<Name>,
}

type Value = Result<f64, Wrong>;

impl<'a> Reader<'a> {
    pub(super) fn new(
        line: &'a [u8],
        at: usize,
        grammar: &'static Grammar,
        variables: &'a Variables,
    ) -> Reader<'a> {
        Reader { line, at, grammar, variables, depth: 0, in_word: false, set: Vec::new() }
    }

    /// The number of a word: a variable, or an expression in brackets.
    pub(super) fn number_of_word(&mut self) -> Value {
        self.in_word = true;
        self.primary()
    }

    /// The next sign that is no blank, which stays.
    pub(super) fn peek(&mut self) -> Option<u8> {
        while matches!(self.line.get(self.at), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
        self.line.get(self.at).map(u8::to_ascii_uppercase)
    }

    /// Passes over a sign.
    pub(super) fn takes(&mut self, sign: u8) -> bool {
        let is_next = self.peek() == Some(sign);
        self.at += usize::from(is_next);
        is_next
    }

    /// The letters that stand next, in capitals; they stay.
    pub(super) fn letters(&mut self) -> String {
        self.peek();
        let rest = self.line[self.at..].iter();
        let letters = rest.take_while(|byte| byte.is_ascii_alphabetic());
        letters.map(|byte| char::from(byte.to_ascii_uppercase())).collect()
    }

    /// Passes over a word.
    pub(super) fn takes_word(&mut self, word: &str) -> bool {
        self.peek();
        let next = self.line.get(self.at..self.at + word.len());
        let is_next = next.is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()));
        self.at += if is_next { word.len() } else { 0 };
        is_next
    }

    /// Whether round brackets are those of expressions, and no comments.
    pub(super) fn round_brackets(&self) -> bool {
        self.grammar.open == b'('
    }

    pub(super) fn wrong(&self, message: impl Into<String>, help: &str) -> Wrong {
        let start = self.at.min(self.line.len().saturating_sub(1));
        Wrong::new((start, start + 1), message, help)
    }

    /// An expression with all its operators.
    pub(super) fn expression(&mut self) -> Value {
        self.bound(0)
    }

    fn bound(&mut self, least: u8) -> Value {
        let mut value = self.primary()?;
        while let Some((sign, level, operator)) = self.operator(least) {
            let place = (self.at, self.at + sign.len());
            self.at += sign.len();
            let right = self.bound(level + 1)?;
            value = applied(operator, sign, value, right)
                .map_err(|(message, help)| Wrong::new(place, message, help))?;
        }
        Ok(value)
    }

    fn operator(&mut self, least: u8) -> Option<(&'static str, u8, Operator)> {
        self.peek();
        let rest = &self.line[self.at..];
        let is_next = |sign: &str| {
            let next = rest.get(..sign.len());
            next.is_some_and(|next| next.eq_ignore_ascii_case(sign.as_bytes()))
        };
        let mut operators = self.grammar.operators.iter();
        let found = operators.find(|(sign, ..)| is_next(sign)).copied();
        found.filter(|(_, level, _)| *level >= least)
    }

    /// A number, a variable, brackets or a function, with its sign.
    pub(super) fn primary(&mut self) -> Value {
        if self.depth == DEEPEST {
            let message = format!("more than {DEEPEST} brackets inside each other");
            return Err(self.wrong(message, "split the expression"));
        }
        self.depth += 1;
        let value = match self.peek() {
            Some(b'-') => {
                self.at += 1;
                self.primary().map(|value| -value)
            }
            Some(b'+') => {
                self.at += 1;
                self.primary()
            }
            Some(sign) if sign == self.grammar.open => self.brackets(),
            Some(sign) if sign == self.grammar.variable && self.begins_variable() => {
                self.variable()
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'A'..=b'Z') => self.function(),
            _ => Err(self.wrong(
                "the expression lacks a number here",
                "expected a number, a variable or a bracket",
            )),
        };
        self.depth -= 1;
        value
    }

    /// `R` begins a variable only before its number; `#` always does.
    fn begins_variable(&self) -> bool {
        let next = self.line.get(self.at + 1);
        self.grammar.variable == b'#' || next.is_some_and(u8::is_ascii_digit)
    }

    pub(super) fn brackets(&mut self) -> Value {
        let start = self.at;
        if !self.takes(self.grammar.open) {
            let open = char::from(self.grammar.open);
            return Err(self.wrong(format!("expected `{open}` here"), "write it in brackets"));
        }
        let value = self.expression()?;
        if self.takes(self.grammar.close) {
            return Ok(value);
        }
        let message = "the bracket is not closed, or something stands in it that is not executed";
        let end = self.at.min(self.line.len()).max(start + 1);
        Err(Wrong::new((start, end), message, HELP))
    }

    fn number(&mut self) -> Value {
        let start = self.at;
        let rest = self.line[start..].iter();
        let length = rest.take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
        self.at += length;
        let bytes = &self.line[start..self.at];
        let digits = bytes.iter().filter(|byte| byte.is_ascii_digit()).count();
        refuse_long_number((start, self.at), digits)?;
        let written = String::from_utf8_lossy(bytes);
        written.parse().map_err(|_| {
            let message = format!("`{written}` is no number");
            Wrong::new((start, self.at), message, "write it like `10.5`")
        })
    }

    /// The name of a variable, behind its sign.
    pub(super) fn name(&mut self) -> Result<Name, Wrong> {
        let start = self.at;
        self.at += 1; // the sign
        if self.grammar.variable == b'R' {
            let number = self.number()?;
            return whole(number, (start, self.at)).map(Name::R);
        }
        if self.takes(b'<') {
            let rest = self.line[self.at..].iter();
            let length = rest.take_while(|byte| **byte != b'>').count();
            let written = String::from_utf8_lossy(&self.line[self.at..self.at + length]);
            let name = written.replace([' ', '\t'], "").to_ascii_lowercase();
            self.at += length;
            if !self.takes(b'>') || name.is_empty() {
                return Err(Wrong::new((start, self.at), "the name is not closed with `>`", HELP));
            }
            return Ok(Name::Named(name));
        }
        let number = self.primary()?;
        whole(number, (start, self.at)).map(Name::Number)
    }

    fn variable(&mut self) -> Value {
        let start = self.at;
        let name = self.name()?;
        let place = (start, self.at);
        if name.is_of_control() {
            let message =
                format!("`{name}` is a variable of the control, whose value only it knows");
            return Err(Wrong::new(place, message, "write the number in its place"));
        }
        if self.set.contains(&name) {
            let message = format!(
                "`{name}` is set in the same block: controls differ in whether that counts here"
            );
            return Err(Wrong::new(place, message, "set it in a line before"));
        }
        self.variables.get(&name).copied().ok_or_else(|| {
            let message = format!("`{name}` has no value: the program did not set it");
            Wrong::new(place, message, "set it at the beginning of the program")
        })
    }

    fn function(&mut self) -> Value {
        let word = self.letters();
        let place = (self.at, self.at + word.len());
        let mut functions = self.grammar.functions.iter();
        let Some((_, function)) = functions.find(|(name, _)| *name == word) else {
            return Err(Wrong::new(
                place,
                format!("`{word}` is not executed in expressions"),
                HELP,
            ));
        };
        if self.in_word && *function == Function::Round {
            let message = "`ROUND` in a word: some controls round to their least increment there";
            return Err(Wrong::new(place, message, "set a variable to it in a line before"));
        }
        self.at = place.1;
        let mut value = self.brackets()?;
        if *function == Function::Atan {
            if !self.takes(b'/') {
                return Err(Wrong::new(place, "`ATAN` needs two numbers", "write `ATAN[y]/[x]`"));
            }
            value = value.atan2(self.brackets()?).to_degrees();
        }
        evaluated(*function, &word, value)
            .map_err(|(message, help)| Wrong::new(place, message, help))
    }
}

const HELP: &str = "docs/path.md lists the expressions that are executed";

/// A whole number from 0 that names something.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the number is checked to lie in the range before it is used"
)]
pub(super) fn whole(value: f64, place: (usize, usize)) -> Result<u32, Wrong> {
    if (0.0..=99_999_999.0).contains(&value) && (value - value.round()).abs() < ROUNDING {
        return Ok(value.round() as u32);
    }
    let message = format!("{value} is no whole number from 0");
    Err(Wrong::new(place, message, "expected the number of a variable, a block or a loop"))
}
