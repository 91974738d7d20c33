//! Quantities with their unit and their sign in the type.
//!
//! Two units live inside the program: positions in millimetres, deviations in micrometres.
//! A [`Deviation`] is what the machine does wrong (actual − commanded, ISO 230-1); a
//! [`Correction`] is what a control must add to the command. **The only place in the program
//! where one turns into the other are the two `impl Neg` below**; every table
//! value, forecast and report goes through it. Which of the two a *control's table* holds is a
//! fact of its profile.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::{Add, Neg, Sub};

/// Millimetres in one inch, exactly (contract §1).
pub const MM_PER_INCH: f64 = 25.4;
/// Micrometres in one millimetre.
pub const UM_PER_MM: f64 = 1000.0;
/// Microradians in one second of arc.
pub const URAD_PER_ARCSEC: f64 = std::f64::consts::PI / 648_000.0 * 1e6;
/// Two computed positions nearer than this are one, mm: a picometre, what their rounding adds.
pub const SAME_PLACE_MM: f64 = 1e-9;
/// A position nearer than this to one that a file states is at it, mm: the last digit that files hold.
pub const AT_PLACE_MM: f64 = 1e-6;

/// Powers of ten that `f64` holds exactly.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// 10ⁿ, as near as `f64` comes to it, the same on every computer: from a table, and beyond it from the
/// decimal text. (`powi` and `powf` of some computers miss the last digit.) Divide by it for 10⁻ⁿ:
/// no negative power is exact.
///
/// ```
/// use nonius_numerics::quantity::power_of_ten;
/// assert_eq!(12_000.0 / power_of_ten(3), 12.0);
/// ```
pub fn power_of_ten(exponent: u32) -> f64 {
    let known = usize::try_from(exponent).ok();
    let known = known.and_then(|exponent| POWERS_OF_TEN.get(exponent).copied());
    known.unwrap_or_else(|| format!("1e{exponent}").parse().unwrap_or(f64::INFINITY))
}

/// To so many decimals, half away from zero; a zero has no sign.
pub fn rounded(number: f64, decimals: u32) -> f64 {
    let scale = power_of_ten(decimals);
    (number * scale).round() / scale + 0.0
}

/// A figure of a manifest or a document, to be read and the same everywhere: to 1e-6 of its unit.
pub fn picometres(um: f64) -> f64 {
    rounded(um, 6)
}

/// The larger of two; unlike `f64::max` it gives no −0 for 0 and −0 with any compiler.
pub fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Smallest and largest of some numbers; (∞, −∞) of none.
pub fn ends(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    numbers.fold(none, |(low, high), number| (low.min(number), high.max(number)))
}

/// The smaller of two.
pub fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// Squares as products, the same on every computer.
pub trait Squared {
    /// x².
    #[must_use]
    fn squared(self) -> Self;
}

impl Squared for f64 {
    fn squared(self) -> f64 {
        self * self
    }
}

/// A number as it is printed: a zero has no sign, also one that is left by rounding to the decimals
/// asked for. Without decimals it is the shortest text that reads back to the same number, below 10⁻⁹ with
/// an exponent in place of up to 300 zeros. All else is as the formatter of numbers writes it.
///
/// ```
/// use nonius_numerics::quantity::Figure;
/// assert_eq!(format!("{:.3} {:+.1}", Figure(-0.0004), Figure(-0.04)), "0.000 +0.0");
/// assert_eq!(format!("{:+.3} {}", Figure(-0.0006), Figure(-0.0)), "-0.001 0");
/// assert_eq!(format!("{} {}", Figure(-0.0000002), Figure(5e-324)), "-0.0000002 5e-324");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Figure(pub f64);

impl Figure {
    /// With so many decimals at most, at least one, without zeros at the end.
    pub fn trimmed(self, decimals: usize) -> String {
        format!("{self:.decimals$}").trim_end_matches('0').trim_end_matches('.').to_string()
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_nothing = match out.precision() {
            None => self.0.abs() <= 0.0,
            Some(decimals) => {
                let digits = u32::try_from(decimals).unwrap_or(u32::MAX);
                let is_below_a_digit = self.0.abs() * power_of_ten(digits) < 1.0;
                is_below_a_digit && is_zeros(&format!("{:.decimals$}", self.0.abs()))
            }
        };
        let number = if is_nothing { 0.0 } else { self.0 };
        match !is_nothing && number.abs() < 1e-9 && out.precision().is_none() {
            true => fmt::LowerExp::fmt(&number, out),
            false => fmt::Display::fmt(&number, out),
        }
    }
}

fn is_zeros(text: &str) -> bool {
    text.bytes().all(|byte| byte == b'0' || byte == b'.')
}

/// A position on an axis, machine coordinates, or a length; millimetres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Millimetres(f64);

impl Millimetres {
    /// A position or length given in millimetres.
    pub const fn new(mm: f64) -> Self {
        Self(mm + 0.0) // −0 becomes 0
    }

    /// The plain number, in millimetres.
    pub const fn mm(self) -> f64 {
        self.0
    }

    /// The number as a sentence shows it: to the micrometre, without the dust of binary fractions.
    pub fn shown(self) -> f64 {
        rounded(self.0, 3)
    }
}

impl Add for Millimetres {
    type Output = Millimetres;
    fn add(self, other: Millimetres) -> Millimetres {
        Millimetres(self.0 + other.0)
    }
}

impl Sub for Millimetres {
    type Output = Millimetres;
    fn sub(self, other: Millimetres) -> Millimetres {
        Millimetres(self.0 - other.0)
    }
}

/// The machine's error at a place: actual − commanded, tool relative to workpiece, machine
/// coordinates (contract §1; ISO 230-1). Micrometres.
///
/// Two deviations cannot be added by mistake:
/// ```compile_fail
/// use nonius_numerics::quantity::Deviation;
/// let _ = Deviation::from_um(1.0) + Deviation::from_um(1.0);
/// ```
/// The difference of two deviations of one curve is a deviation again (re-zeroing):
/// ```
/// use nonius_numerics::quantity::Deviation;
/// let zeroed = Deviation::from_um(3.0) - Deviation::from_um(1.0);
/// assert_eq!(zeroed, Deviation::from_um(2.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Deviation(f64);

impl Deviation {
    /// No deviation.
    pub const ZERO: Deviation = Deviation(0.0);

    /// A deviation of `um` micrometres, positive where the machine goes too far in +.
    pub const fn from_um(um: f64) -> Self {
        Self(um + 0.0) // −0 becomes 0
    }

    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

impl Sub for Deviation {
    type Output = Deviation;
    fn sub(self, other: Deviation) -> Deviation {
        Deviation(self.0 - other.0)
    }
}

/// What a control adds to the commanded position: positive moves the axis further in +.
/// Micrometres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Correction(f64);

impl Correction {
    /// No correction.
    pub const ZERO: Correction = Correction(0.0);

    /// A correction of `um` micrometres.
    pub const fn from_um(um: f64) -> Self {
        Self(um + 0.0) // −0 becomes 0
    }

    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

/// The corrections of several tables on one axis add (docs/siemens.md §2.3, docs/fanuc.md §2.3).
impl Add for Correction {
    type Output = Correction;
    fn add(self, other: Correction) -> Correction {
        Correction(self.0 + other.0)
    }
}

/// What is left: deviation + correction, micrometres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Residual(f64);

impl Residual {
    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

impl Add<Correction> for Deviation {
    type Output = Residual;
    fn add(self, correction: Correction) -> Residual {
        Residual(self.0 + correction.0)
    }
}

/// **The change of sign**: the correction that cancels a deviation, and back.
///
/// ```
/// use nonius_numerics::quantity::{Correction, Deviation};
/// assert_eq!(-Deviation::from_um(2.5), Correction::from_um(-2.5));
/// ```
impl Neg for Deviation {
    type Output = Correction;
    fn neg(self) -> Correction {
        Correction(0.0 - self.0) // not −x: the correction of nothing is 0, not −0
    }
}

/// The inverse: another maker's table of corrections, read as the deviations it cancels.
impl Neg for Correction {
    type Output = Deviation;
    fn neg(self) -> Deviation {
        Deviation(0.0 - self.0) // as above
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What a person would call a minus sign before nothing.
    fn has_signed_zero(text: &str) -> bool {
        text.strip_prefix('-').is_some_and(is_zeros)
    }

    #[test]
    fn no_quantity_is_minus_zero() {
        let nothing = -0.0_f64;
        let all = [
            Millimetres::new(nothing).mm(),
            Deviation::from_um(nothing).um(),
            Correction::from_um(nothing).um(),
            (-Deviation::ZERO).um(),
            (-Correction::ZERO).um(),
        ];
        assert!(all.iter().all(|number| number.is_sign_positive()), "{all:?}");
    }

    #[test]
    fn powers_of_ten_are_those_of_their_decimal_text() {
        for exponent in 0..=308 {
            let text: f64 = format!("1{}", "0".repeat(exponent as usize)).parse().unwrap();
            assert_eq!(power_of_ten(exponent).to_bits(), text.to_bits(), "1e{exponent}");
        }
    }

    proptest! {
        #[test]
        fn a_figure_has_no_signed_zero_and_is_else_as_the_formatter_writes_it(
            number in prop_oneof![-1e-2..1e-2_f64, -1e6..1e6_f64, Just(-0.0), Just(-0.5)],
            decimals in 0_usize..9,
        ) {
            let text = format!("{:.decimals$}", Figure(number));
            let plain = format!("{number:.decimals$}");
            prop_assert!(!has_signed_zero(&text), "{text}");
            if !has_signed_zero(&plain) {
                prop_assert_eq!(text, plain);
            }
            let signed = format!("{:+.decimals$}", Figure(number));
            prop_assert!(!has_signed_zero(&signed), "{signed}");
            let shortest = Figure(number).to_string();
            prop_assert!(!has_signed_zero(&shortest), "{shortest}");
        }
    }
}
