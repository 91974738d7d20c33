//! Expressions: numbers, variables, brackets, operators and functions of one argument. What has no value is refused
//! with its place. Where controls differ in a result (the rest of a negative number, a comparison that rounding decides),
//! there is none.

use crate::Language;
use crate::lexer::Lexer;
use crate::wrong::{Span, Wrong, refuse, refuse_long_number};
use std::collections::BTreeMap;

/// Brackets inside each other.
const DEEPEST: usize = 32;
const HELP: &str = "docs/volume.md lists the expressions that are executed";

type Value = Result<f64, Wrong>;

/// Variables from this number on belong to the control (tool data, positions, signals).
const FIRST_OF_CONTROL: u32 = 1000;

/// The values that a program has set, by the names as written: `#1`, `#<name>`, `R1`. One that was not set has no value:
/// never 0.
pub(crate) type Variables = BTreeMap<String, f64>;

/// Whether a variable is one of the control's own, whose value no program tells.
pub(crate) fn is_of_control(name: &str) -> bool {
    let number = name.strip_prefix('#').and_then(|number| number.parse().ok());
    number.is_some_and(|number: u32| number >= FIRST_OF_CONTROL || number == 0)
}

impl Lexer<'_> {
    /// An expression with all its operators.
    pub(crate) fn expression(&mut self) -> Value {
        self.bound(0)
    }

    fn bound(&mut self, least: usize) -> Value {
        let mut value = self.primary()?;
        while let Some((sign, level)) = self.operator(least) {
            let place = (self.at, self.at + sign.len());
            self.at = place.1;
            value = applied(sign, value, self.bound(level + 1)?)
                .map_err(|(what, help)| Wrong::new(place, what, help))?;
        }
        Ok(value)
    }

    /// The operator that stands next, if it binds at least so tightly.
    fn operator(&mut self, least: usize) -> Option<(&'static str, usize)> {
        let levels = OPERATORS.iter().enumerate().skip(least).rev();
        let mut all =
            levels.flat_map(|(level, signs)| signs.iter().map(move |sign| (*sign, level)));
        let first = self.peek()?;
        let is_own = |sign: &str, language: Language| {
            sign.as_bytes()[0] == first && (language == Language::Iso || SIEMENS.contains(sign))
        };
        all.find(|(sign, _)| is_own(sign, self.language) && self.is_next(sign))
    }

    /// A number, a variable, brackets or a function, with its sign.
    pub(crate) fn primary(&mut self) -> Value {
        if self.depth == DEEPEST {
            let what = format!("more than {DEEPEST} brackets inside each other");
            return Err(self.wrong(what, "split the expression"));
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
        let what = "the bracket is not closed, or something stands in it that is not executed";
        refuse((start, self.at.min(self.line.len()).max(start + 1)), what, HELP)
    }

    fn number(&mut self) -> Value {
        let start = self.at;
        self.at += self.length_of(|byte| byte.is_ascii_digit() || *byte == b'.');
        let (place, bytes) = ((start, self.at), &self.line[start..self.at]);
        refuse_long_number(place, bytes.iter().filter(|byte| byte.is_ascii_digit()).count())?;
        let written = String::from_utf8_lossy(bytes);
        let what = || format!("`{written}` is no number");
        written.parse().map_err(|_| Wrong::new(place, what(), "write it like `10.5`"))
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
            let what = format!("`{name}` is a variable of the control, whose value only it knows");
            return refuse(place, what, "write the number in its place");
        }
        if self.set.contains(&name) {
            let what = format!(
                "`{name}` is set in the same block: controls differ in whether that counts here"
            );
            return refuse(place, what, "set it in a line before");
        }
        self.variables.and_then(|known| known.get(&name)).copied().ok_or_else(|| {
            let what = format!("`{name}` has no value: the program did not set it");
            Wrong::new(place, what, "set it at the beginning of the program")
        })
    }

    fn function(&mut self) -> Value {
        let word = self.run_of(u8::is_ascii_alphabetic);
        let place = (self.at, self.at + word.len());
        if !self.language.has_function(&word) {
            return refuse(place, format!("`{word}` is not executed in expressions"), HELP);
        }
        if self.in_word && word == "ROUND" {
            let what = "`ROUND` in a word: some controls round to their least increment there";
            return refuse(place, what, "set a variable to it in a line before");
        }
        self.at = place.1;
        let mut value = self.brackets()?;
        if word == "ATAN" {
            if !self.takes(b'/') {
                return refuse(place, "`ATAN` needs two numbers", "write `ATAN[y]/[x]`");
            }
            value = value.atan2(self.brackets()?).to_degrees();
        }
        evaluated(&word, value).map_err(|(what, help)| Wrong::new(place, what, help))
    }

    /// A whole number from 0, as those of variables, blocks and loops are.
    pub(crate) fn whole_number(&mut self) -> Result<u32, Wrong> {
        self.peek();
        let start = self.at;
        whole(self.primary()?, (start, self.at))
    }
}

/// A whole number from 0 that names something.
fn whole(value: f64, place: Span) -> Result<u32, Wrong> {
    let what = || format!("{value} is no whole number from 0");
    let help = "expected the number of a variable, a block or a loop";
    nearly_natural(value).ok_or_else(|| Wrong::new(place, what(), help))
}

/// The number that a control can have and that a value is but for rounding.
pub(crate) fn nearly_natural(value: f64) -> Option<u32> {
    natural(value).and(natural(value.round())).filter(|_| (value - value.round()).abs() < ROUNDING)
}

/// The whole part of a number from 0 on that a control can have.
#[allow(clippy::cast_possible_truncation, reason = "it is checked to lie in the range")]
pub(crate) fn natural(value: f64) -> Option<u32> {
    (0.0..=99_999_999.0).contains(&value).then_some(value as u32)
}

/// Comparisons of numbers that are nearer than this, and not the same, are decided by rounding.
pub(crate) const ROUNDING: f64 = 1e-9;
/// Exponents that are executed.
const MOST_POWER: u32 = 64;
/// LinuxCNC takes numbers that are nearer than this for equal.
const EQUAL: f64 = 1e-4;

/// Signs and words of operators, those that bind tightest last; Siemens has those of [`SIEMENS`].
pub(crate) const OPERATORS: [&[&str]; 5] = [
    &["AND", "OR"],
    &["EQ", "NE", "GT", "GE", "LT", "LE"],
    &["+", "-"],
    &["*", "/", "MOD"],
    &["**"],
];
const SIEMENS: &str = "+-*/";
/// Functions of both languages.
const FUNCTIONS: &str = "SIN COS TAN ASIN ACOS SQRT ABS ROUND LN EXP";

/// How a language writes expressions: `[#1+2]*SIN[30]`, `(R1+2)*SIN(30)`.
impl Language {
    pub(crate) fn has_function(self, word: &str) -> bool {
        let own = if self == Language::Iso { "ATAN FIX FUP" } else { "POT TRUNC" };
        FUNCTIONS.split(' ').chain(own.split(' ')).any(|known| known == word)
    }

    pub(crate) fn brackets(self) -> (u8, u8) {
        if self == Language::Iso { (b'[', b']') } else { (b'(', b')') }
    }

    /// What begins a variable.
    pub(crate) fn variable(self) -> u8 {
        if self == Language::Iso { b'#' } else { b'R' }
    }
}

/// A number, or what is wrong and what to do.
pub(crate) type Evaluated = Result<f64, (String, &'static str)>;

/// What an operator makes of two numbers.
pub(crate) fn applied(sign: &str, a: f64, b: f64) -> Evaluated {
    let refuse = |what: String, help| Err((what, help));
    match sign {
        "+" => finite(a + b),
        "-" => finite(a - b),
        "*" => finite(a * b),
        "/" if b.abs() <= 0.0 => refuse("division by zero".to_string(), "check the divisor"),
        "/" => finite(a / b),
        "**" => power(a, b).and_then(finite),
        "MOD" if a < 0.0 || b <= 0.0 => {
            let what = format!("`{sign}` of {a} and {b}: controls differ in the sign of the rest");
            refuse(what, "write it with positive numbers")
        }
        "MOD" if is_nearly_whole(a / b) => undecided(sign),
        "MOD" => finite(a % b),
        "AND" | "OR" => {
            let what = format!("`{sign}` is not executed: controls differ in what it binds");
            refuse(what, "write one condition after the other")
        }
        _ => compared(sign, a, b),
    }
}

/// 1 where a comparison holds, else 0.
fn compared(sign: &str, a: f64, b: f64) -> Evaluated {
    let apart = (a - b).abs();
    let nearest = if matches!(sign, "EQ" | "NE") { EQUAL } else { ROUNDING };
    if apart > 0.0 && apart < nearest {
        let what = format!(
            "`{sign}` of numbers that are {apart:e} apart: rounding decides, and controls differ"
        );
        return Err((what, "compare with a number between two steps"));
    }
    let holds = match sign {
        "EQ" => apart <= 0.0,
        "NE" => apart > 0.0,
        "GT" => a > b,
        "GE" => a >= b,
        "LT" => a < b,
        _ => a <= b,
    };
    Ok(f64::from(u8::from(holds)))
}

/// By multiplication, so that it is the same on every computer.
fn power(a: f64, b: f64) -> Evaluated {
    let times = natural(b).filter(|times| *times <= MOST_POWER && b.fract() <= 0.0);
    let refused = || format!("`**` with the exponent {b} is not executed");
    let times = times.ok_or_else(|| (refused(), "write a whole exponent from 0 to 64"))?;
    Ok((0..times).map(|_| a).product())
}

/// Whether a number is whole but for rounding: then rounding decides to which side it goes.
fn is_nearly_whole(a: f64) -> bool {
    let apart = (a - a.round()).abs();
    apart > 0.0 && apart < ROUNDING
}

fn undecided(word: &str) -> Evaluated {
    let what =
        format!("`{word}` of a number that rounding puts beside a whole one: controls differ");
    Err((what, "add or take off half of the smallest step first"))
}

fn finite(value: f64) -> Evaluated {
    let refused = || ("the expression has no finite value".to_string(), "check its numbers");
    if value.is_finite() { Ok(value) } else { Err(refused()) }
}

/// What a function makes of a number; angles in degrees. `ATAN` is given its angle.
pub(crate) fn evaluated(word: &str, a: f64) -> Evaluated {
    let has_value = match word {
        "ASIN" | "ACOS" => a.abs() <= 1.0,
        "SQRT" => a >= 0.0,
        "LN" => a > 0.0,
        _ => true,
    };
    if !has_value {
        return Err((format!("`{word}` of {a} has no value"), "check the number"));
    }
    finite(match word {
        "SIN" => a.to_radians().sin(),
        "COS" => a.to_radians().cos(),
        "TAN" => a.to_radians().tan(),
        "ASIN" => a.asin().to_degrees(),
        "ACOS" => a.acos().to_degrees(),
        "ATAN" if a < 0.0 => {
            let what = format!("`ATAN` is {a}° or {}°: controls differ in it", a + 360.0);
            return Err((what, "write it with a positive first number"));
        }
        "ATAN" => a,
        "ABS" => a.abs(),
        "SQRT" => a.sqrt(),
        "LN" => a.ln(),
        "EXP" => a.exp(),
        "POT" => a * a,
        "FIX" | "FUP" if a < 0.0 && a.fract().abs() > 0.0 => {
            let what = format!("`{word}` of the negative number {a}: controls differ in it");
            return Err((what, "write it with a positive number"));
        }
        "ROUND" if is_nearly_whole(a - 0.5) => return undecided(word),
        "ROUND" => a.round(),
        _ if is_nearly_whole(a) => return undecided(word),
        "FUP" => a.ceil(),
        _ => a.trunc(), // FIX, TRUNC
    })
}
