//! Words and numbers of options.

use std::ops::RangeInclusive;

/// A number within a range; beyond it a unit was mistaken.
pub(super) fn number(text: &str, range: RangeInclusive<f64>, unit: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let (low, high) = (range.start(), range.end());
    let found = number.filter(|number| range.contains(number));
    found.ok_or_else(|| {
        format!("expected a number from {low} to {high} {unit}, with a decimal point")
    })
}

/// A number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok();
    let number = number.filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number above 0, e.g. 10".to_string())
}
