//! What operators and functions of a language are, and what they do.
//!
//! Where controls differ in a result (the rest of a negative number, a comparison that rounding decides), there is
//! none.

/// Comparisons of numbers that are nearer than this, and not the same, are decided by rounding.
pub(super) const ROUNDING: f64 = 1e-9;
/// Exponents that are executed.
const MOST_POWER: f64 = 64.0;
/// LinuxCNC takes numbers that are nearer than this for equal.
const EQUAL: f64 = 1e-4;

/// How a language writes expressions.
#[derive(Debug)]
pub(super) struct Grammar {
    pub(super) open: u8,
    pub(super) close: u8,
    /// What begins a variable.
    pub(super) variable: u8,
    /// Words and signs, how tightly they bind, and what they do.
    pub(super) operators: &'static [(&'static str, u8, Operator)],
    pub(super) functions: &'static [(&'static str, Function)],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Rest,
    Power,
    Compare(Comparison),
    /// AND, OR.
    Logic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparison {
    Equal,
    Other,
    More,
    AtLeast,
    Less,
    AtMost,
}

impl Comparison {
    fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Comparison::Equal => same(a, b),
            Comparison::Other => !same(a, b),
            Comparison::More => a > b,
            Comparison::AtLeast => a >= b,
            Comparison::Less => a < b,
            Comparison::AtMost => a <= b,
        }
    }

    /// Numbers that are nearer and not the same are decided by rounding.
    fn nearest(self) -> f64 {
        match self {
            Comparison::Equal | Comparison::Other => EQUAL,
            _ => ROUNDING,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    /// `ATAN[y]/[x]`.
    Atan,
    Sqrt,
    Abs,
    /// Controls differ in it for negative numbers: down, or towards zero.
    Fix,
    Fup,
    Round,
    Ln,
    Exp,
    Square,
    Truncate,
}

/// Fanuc's and LinuxCNC's: `[#1+2]*SIN[30]`.
pub(super) const ISO: Grammar = Grammar {
    open: b'[',
    close: b']',
    variable: b'#',
    operators: &[
        ("**", 4, Operator::Power),
        ("*", 3, Operator::Multiply),
        ("/", 3, Operator::Divide),
        ("MOD", 3, Operator::Rest),
        ("+", 2, Operator::Add),
        ("-", 2, Operator::Subtract),
        ("EQ", 1, Operator::Compare(Comparison::Equal)),
        ("NE", 1, Operator::Compare(Comparison::Other)),
        ("GT", 1, Operator::Compare(Comparison::More)),
        ("GE", 1, Operator::Compare(Comparison::AtLeast)),
        ("LT", 1, Operator::Compare(Comparison::Less)),
        ("LE", 1, Operator::Compare(Comparison::AtMost)),
        ("AND", 0, Operator::Logic),
        ("OR", 0, Operator::Logic),
    ],
    functions: &[
        ("SIN", Function::Sin),
        ("COS", Function::Cos),
        ("TAN", Function::Tan),
        ("ASIN", Function::Asin),
        ("ACOS", Function::Acos),
        ("ATAN", Function::Atan),
        ("SQRT", Function::Sqrt),
        ("ABS", Function::Abs),
        ("FIX", Function::Fix),
        ("FUP", Function::Fup),
        ("ROUND", Function::Round),
        ("LN", Function::Ln),
        ("EXP", Function::Exp),
    ],
};

/// Siemens': `(R1+2)*SIN(30)`.
pub(super) const SIEMENS: Grammar = Grammar {
    open: b'(',
    close: b')',
    variable: b'R',
    operators: &[
        ("*", 3, Operator::Multiply),
        ("/", 3, Operator::Divide),
        ("+", 2, Operator::Add),
        ("-", 2, Operator::Subtract),
    ],
    functions: &[
        ("SIN", Function::Sin),
        ("COS", Function::Cos),
        ("TAN", Function::Tan),
        ("ASIN", Function::Asin),
        ("ACOS", Function::Acos),
        ("SQRT", Function::Sqrt),
        ("ABS", Function::Abs),
        ("POT", Function::Square),
        ("TRUNC", Function::Truncate),
        ("ROUND", Function::Round),
        ("LN", Function::Ln),
        ("EXP", Function::Exp),
    ],
};

/// A number, or what is wrong and what to do.
pub(super) type Evaluated = Result<f64, (String, &'static str)>;

pub(super) fn applied(operator: Operator, sign: &str, a: f64, b: f64) -> Evaluated {
    let truth = |truth: bool| Ok(if truth { 1.0 } else { 0.0 });
    match operator {
        Operator::Add => finite(a + b),
        Operator::Subtract => finite(a - b),
        Operator::Multiply => finite(a * b),
        Operator::Divide if b.abs() <= 0.0 => {
            Err(("division by zero".to_string(), "check the divisor"))
        }
        Operator::Divide => finite(a / b),
        Operator::Rest if a < 0.0 || b <= 0.0 => Err((
            format!("`{sign}` of {a} and {b}: controls differ in the sign of the rest"),
            "write it with positive numbers",
        )),
        Operator::Rest if is_nearly_whole(a / b) => Err(undecided(sign)),
        Operator::Rest => finite(a % b),
        Operator::Power => power(a, b).and_then(finite),
        Operator::Compare(comparison) => {
            let apart = (a - b).abs();
            if apart > 0.0 && apart < comparison.nearest() {
                let message = format!(
                    "`{sign}` of numbers that are {apart:e} apart: rounding decides, and controls differ"
                );
                return Err((message, "compare with a number between two steps"));
            }
            truth(comparison.holds(a, b))
        }
        Operator::Logic => Err((
            format!("`{sign}` is not executed: controls differ in what it binds"),
            "write one condition after the other",
        )),
    }
}

/// By multiplication, so that it is the same on every computer.
fn power(a: f64, b: f64) -> Evaluated {
    if !(0.0..=MOST_POWER).contains(&b) || (b - b.round()).abs() > 0.0 {
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

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.0
}

/// Whether a number is whole but for rounding: then rounding decides to which side it goes.
fn is_nearly_whole(a: f64) -> bool {
    let apart = (a - a.round()).abs();
    apart > 0.0 && apart < ROUNDING
}

fn undecided(word: &str) -> (String, &'static str) {
    let message =
        format!("`{word}` of a number that rounding puts beside a whole one: controls differ");
    (message, "add or take off half of the smallest step first")
}

fn finite(value: f64) -> Evaluated {
    if value.is_finite() {
        return Ok(value);
    }
    Err(("the expression has no finite value".to_string(), "check its numbers"))
}

pub(super) fn evaluated(function: Function, word: &str, a: f64) -> Evaluated {
    let outside = || (format!("`{word}` of {a} has no value"), "check the number");
    let signed = || {
        (
            format!("`{word}` of the negative number {a}: controls differ in it"),
            "write it with a positive number",
        )
    };
    let is_whole = (a - a.round()).abs() <= 0.0;
    match function {
        Function::Sin => Ok(a.to_radians().sin()),
        Function::Cos => Ok(a.to_radians().cos()),
        Function::Tan => finite(a.to_radians().tan()),
        Function::Asin | Function::Acos if a.abs() > 1.0 => Err(outside()),
        Function::Asin => Ok(a.asin().to_degrees()),
        Function::Acos => Ok(a.acos().to_degrees()),
        Function::Atan if a < 0.0 => Err((
            format!("`ATAN` is {a}° or {}°: controls differ in it", a + 360.0),
            "write it with a positive first number",
        )),
        Function::Atan => Ok(a),
        Function::Sqrt if a < 0.0 => Err(outside()),
        Function::Sqrt => Ok(a.sqrt()),
        Function::Abs => Ok(a.abs()),
        Function::Fix | Function::Fup if a < 0.0 && !is_whole => Err(signed()),
        Function::Fix | Function::Fup | Function::Truncate if is_nearly_whole(a) => {
            Err(undecided(word))
        }
        Function::Round if is_nearly_whole(a - 0.5) => Err(undecided(word)),
        Function::Fix | Function::Truncate => Ok(a.trunc()),
        Function::Fup => Ok(a.ceil()),
        Function::Round => Ok(a.round()),
        Function::Ln if a <= 0.0 => Err(outside()),
        Function::Ln => Ok(a.ln()),
        Function::Exp => finite(a.exp()),
        Function::Square => finite(a * a),
    }
}
