//! What operators and functions of a language are, and what they do.
//!
//! Where controls differ in a result (the rest of a negative number, a comparison that rounding decides), there is
//! none.

use crate::Language;

/// Comparisons of numbers that are nearer than this, and not the same, are decided by rounding.
pub(crate) const ROUNDING: f64 = 1e-9;
/// Exponents that are executed.
const MOST_POWER: f64 = 64.0;
/// LinuxCNC takes numbers that are nearer than this for equal.
const EQUAL: f64 = 1e-4;

/// Signs and words of operators, and how tightly they bind.
type Operators = [(&'static str, u8)];

/// Fanuc's and LinuxCNC's.
const OPERATORS: &Operators = &[
    ("**", 4),
    ("*", 3),
    ("/", 3),
    ("+", 2),
    ("-", 2),
    ("MOD", 3),
    ("EQ", 1),
    ("NE", 1),
    ("GT", 1),
    ("GE", 1),
    ("LT", 1),
    ("LE", 1),
    ("AND", 0),
    ("OR", 0),
];
/// Functions of both languages.
const FUNCTIONS: &str = "SIN COS TAN ASIN ACOS SQRT ABS ROUND LN EXP";

/// How a language writes expressions: `[#1+2]*SIN[30]`, `(R1+2)*SIN(30)`.
impl Language {
    pub(crate) fn operators(self) -> &'static Operators {
        match self {
            Language::Iso => OPERATORS,
            Language::Siemens => &OPERATORS[1..5],
        }
    }

    pub(crate) fn has_function(self, word: &str) -> bool {
        let own = match self {
            Language::Iso => "ATAN FIX FUP",
            Language::Siemens => "POT TRUNC",
        };
        FUNCTIONS.split(' ').chain(own.split(' ')).any(|known| known == word)
    }

    pub(crate) fn brackets(self) -> (u8, u8) {
        match self {
            Language::Iso => (b'[', b']'),
            Language::Siemens => (b'(', b')'),
        }
    }

    /// What begins a variable.
    pub(crate) fn variable(self) -> u8 {
        match self {
            Language::Iso => b'#',
            Language::Siemens => b'R',
        }
    }
}

/// A number, or what is wrong and what to do.
pub(crate) type Evaluated = Result<f64, (String, &'static str)>;

/// What an operator makes of two numbers.
pub(crate) fn applied(sign: &str, a: f64, b: f64) -> Evaluated {
    let refuse = |message: String, help| Err((message, help));
    match sign {
        "+" => finite(a + b),
        "-" => finite(a - b),
        "*" => finite(a * b),
        "/" if b.abs() <= 0.0 => refuse("division by zero".to_string(), "check the divisor"),
        "/" => finite(a / b),
        "**" => power(a, b).and_then(finite),
        "MOD" if a < 0.0 || b <= 0.0 => {
            let message =
                format!("`{sign}` of {a} and {b}: controls differ in the sign of the rest");
            refuse(message, "write it with positive numbers")
        }
        "MOD" if is_nearly_whole(a / b) => undecided(sign),
        "MOD" => finite(a % b),
        "AND" | "OR" => {
            let message = format!("`{sign}` is not executed: controls differ in what it binds");
            refuse(message, "write one condition after the other")
        }
        _ => compared(sign, a, b),
    }
}

/// 1 where a comparison holds, else 0.
fn compared(sign: &str, a: f64, b: f64) -> Evaluated {
    let apart = (a - b).abs();
    let nearest = if matches!(sign, "EQ" | "NE") { EQUAL } else { ROUNDING };
    if apart > 0.0 && apart < nearest {
        let message = format!(
            "`{sign}` of numbers that are {apart:e} apart: rounding decides, and controls differ"
        );
        return Err((message, "compare with a number between two steps"));
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
    if !(0.0..=MOST_POWER).contains(&b) || b.fract() > 0.0 {
        let message = format!("`**` with the exponent {b} is not executed");
        return Err((message, "write a whole exponent from 0 to 64"));
    }
    let (mut product, mut left) = (1.0, b);
    while left > 0.0 {
        product *= a;
        left -= 1.0;
    }
    Ok(product)
}

/// Whether a number is whole but for rounding: then rounding decides to which side it goes.
fn is_nearly_whole(a: f64) -> bool {
    let apart = (a - a.round()).abs();
    apart > 0.0 && apart < ROUNDING
}

fn undecided(word: &str) -> Evaluated {
    let message =
        format!("`{word}` of a number that rounding puts beside a whole one: controls differ");
    Err((message, "add or take off half of the smallest step first"))
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
            let message = format!("`ATAN` is {a}° or {}°: controls differ in it", a + 360.0);
            return Err((message, "write it with a positive first number"));
        }
        "ATAN" => a,
        "ABS" => a.abs(),
        "SQRT" => a.sqrt(),
        "LN" => a.ln(),
        "EXP" => a.exp(),
        "POT" => a * a,
        "FIX" | "FUP" if a < 0.0 && a.fract().abs() > 0.0 => {
            let message = format!("`{word}` of the negative number {a}: controls differ in it");
            return Err((message, "write it with a positive number"));
        }
        "ROUND" if is_nearly_whole(a - 0.5) => return undecided(word),
        "ROUND" => a.round(),
        _ if is_nearly_whole(a) => return undecided(word),
        "FUP" => a.ceil(),
        _ => a.trunc(), // FIX, TRUNC
    })
}
