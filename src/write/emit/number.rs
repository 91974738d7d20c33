//! Numbers as they are written.

use crate::quantity::units::{Figure, power_of_ten};
use compact_str::{CompactString, format_compact};

/// A number with a fixed number of decimals, never `-0`.
pub(super) fn fixed(number: f64, decimals: u32) -> CompactString {
    if let Some(text) = counted(number, decimals) {
        return text;
    }
    format_compact!("{:.*}", decimals as usize, Figure(number))
}

/// The same text from whole counts of the last decimal, where the number is one but for rounding
/// in its last bits, as nearly every number of a table is; the formatter takes several times as long.
pub(super) fn counted(number: f64, decimals: u32) -> Option<CompactString> {
    const LARGEST: f64 = 1e12; // the product below is then off by less than 1e-3
    let scaled = number * power_of_ten(decimals);
    let count = scaled.round();
    let is_count = count.abs() <= LARGEST && (scaled - count).abs() <= 1e-3;
    if !is_count {
        return None; // NaN too: it must not become a zero
    }
    #[allow(clippy::cast_possible_truncation, reason = "below LARGEST")]
    let count = count as i64;
    pointed(count, decimals)
}

/// A whole number with a point before the last `decimals` of its digits; `None` = longer than
/// the numbers of a table are.
fn pointed(count: i64, decimals: u32) -> Option<CompactString> {
    const MOST_DIGITS: u32 = 13;
    const MOST_BYTES: usize = "-1000000000000.".len();
    if decimals >= MOST_DIGITS || count.unsigned_abs() >= 10_u64.pow(MOST_DIGITS) {
        return None;
    }
    let mut text = [b'0'; MOST_BYTES];
    let mut start = text.len();
    let mut put_before = |byte| {
        start -= 1;
        text[start] = byte;
    };
    let mut rest = count.unsigned_abs();
    let mut place = 0;
    while place <= decimals || rest > 0 {
        if place == decimals && place > 0 {
            put_before(b'.');
        }
        put_before(b"0123456789"[(rest % 10) as usize]);
        rest /= 10;
        place += 1;
    }
    if count < 0 {
        put_before(b'-');
    }
    CompactString::from_utf8(&text[start..]).ok()
}
