//! The last digit of a position in a part program.

use crate::control::controller::LengthUnit;
use crate::quantity::units::power_of_ten;

/// A length as a number of the control's last digits.
pub type Digits = i64;

/// What one last digit is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Basic system of the control.
    pub unit: LengthUnit,
    /// Decimals of a position in that unit.
    pub decimals: u32,
}

/// How far a length may be from whole digits to be one: what binary numbers add, not a length.
const WHOLE: f64 = 1e-4;

impl Resolution {
    /// One last digit, mm.
    pub(crate) fn digit_mm(self) -> f64 {
        self.unit.in_mm() / self.per_unit()
    }

    /// One last digit for people.
    pub(crate) fn digit_words(self) -> String {
        let decimals = usize::try_from(self.decimals).unwrap_or(0);
        let digit = format!(
            "{:.*} {}",
            decimals,
            1.0 / self.per_unit(),
            self.unit.word()
        );
        match self.unit {
            LengthUnit::Millimetre => digit,
            LengthUnit::Inch => format!("{digit} ({} mm)", self.mm(1)),
        }
    }

    fn per_unit(self) -> f64 {
        power_of_ten(self.decimals)
    }

    /// A length in mm.
    pub fn mm(self, digits: Digits) -> f64 {
        #[allow(
            clippy::cast_precision_loss,
            reason = "no machine has 2^52 digits of travel"
        )]
        let digits = digits as f64;
        // Division last: 1500 digits of 0.001 mm are 1.5 mm exactly.
        digits * self.unit.in_mm() / self.per_unit()
    }

    /// A length that is a whole number of digits.
    pub fn digits(self, mm: f64) -> Option<Digits> {
        let exact = mm / self.digit_mm();
        ((exact - exact.round()).abs() < WHOLE).then(|| self.nearest(mm))
    }

    /// The nearest whole number of digits.
    pub fn nearest(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm()).round())
    }

    /// The largest whole number of digits that is not longer.
    pub fn at_most(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm() + WHOLE).floor())
    }

    /// The smallest whole number of digits that is not shorter.
    pub(crate) fn at_least(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm() - WHOLE).ceil())
    }

    /// A length as it stands in a program, in the control's unit; never `-0`.
    pub fn text(self, digits: Digits) -> String {
        let places = usize::try_from(self.decimals).unwrap_or(0);
        let sign = if digits < 0 { "-" } else { "" };
        let all = format!("{:0>width$}", digits.unsigned_abs(), width = places + 1);
        let (whole, part) = all.split_at(all.len() - places);
        format!("{sign}{whole}.{part}")
    }
}

fn whole(rounded: f64) -> Digits {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lengths of a job are below 1e6 mm"
    )]
    let digits = rounded as Digits;
    digits
}

#[cfg(test)]
mod tests {
    use super::*;

    const MICRON: Resolution = Resolution {
        unit: LengthUnit::Millimetre,
        decimals: 3,
    };

    #[test]
    fn a_length_is_written_with_all_its_digits() {
        assert_eq!(MICRON.text(-1), "-0.001");
        assert_eq!(MICRON.text(0), "0.000");
        assert_eq!(MICRON.text(900_000), "900.000");
        let ten_thousandth = Resolution {
            unit: LengthUnit::Inch,
            decimals: 4,
        };
        assert_eq!(ten_thousandth.digits(25.4), Some(10_000));
        assert_eq!(ten_thousandth.text(10_000), "1.0000");
    }

    #[test]
    fn a_length_between_two_digits_is_none() {
        assert_eq!(MICRON.digits(0.0005), None);
        assert_eq!(MICRON.digits(29.99), Some(29_990));
        assert_eq!((MICRON.at_most(1.0), MICRON.at_least(1.0)), (1000, 1000));
        assert_eq!(
            (MICRON.at_most(1.0009), MICRON.at_least(1.0001)),
            (1000, 1001)
        );
    }
}
