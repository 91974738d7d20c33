//! Ranges of numbers, how they are added and multiplied, and the ranges of rows of them as a tree.

use std::ops::{Add, Mul, Sub};

/// All values from `low` to `high`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Add for Interval {
    type Output = Interval;
    fn add(self, other: Interval) -> Interval {
        Interval { low: self.low + other.low, high: self.high + other.high }
    }
}

impl Sub for Interval {
    type Output = Interval;
    fn sub(self, other: Interval) -> Interval {
        Interval { low: self.low - other.high, high: self.high - other.low }
    }
}

impl Mul for Interval {
    type Output = Interval;
    fn mul(self, other: Interval) -> Interval {
        let [a, b] = [self.low * other.low, self.low * other.high];
        let [c, d] = [self.high * other.low, self.high * other.high];
        Interval { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }
    }
}

impl Interval {
    pub(super) fn of(value: f64) -> Interval {
        Interval { low: value, high: value }
    }

    fn or(self, other: Interval) -> Interval {
        let low = if other.low < self.low { other.low } else { self.low };
        let high = if other.high > self.high { other.high } else { self.high };
        Interval { low, high }
    }

    pub(super) fn largest(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    pub(super) fn smallest(self) -> f64 {
        self.low.max(-self.high).max(0.0)
    }
}

/// The ranges of rows, halved again and again: all of them are branch 1, the halves of branch n are 2n and 2n + 1, and
/// from the number of the rows on a branch is a single row.
pub(super) fn tree<const N: usize>(mut rows: Vec<[Interval; N]>) -> Vec<[Interval; N]> {
    let count = rows.len();
    rows.rotate_right(count.next_power_of_two() - count); // so that every branch is of neighbours
    let mut tree = [rows.as_slice(), &rows].concat();
    for n in (1..count).rev() {
        let [one, two] = [tree[2 * n], tree[2 * n + 1]];
        for m in 0..N {
            tree[n][m] = one[m].or(two[m]);
        }
    }
    tree
}

/// The last row of a branch, of so many; of a single one itself.
pub(super) fn last_row(mut branch: usize, count: usize) -> usize {
    while branch < count {
        branch = 2 * branch + 1;
    }
    (branch + count - count.next_power_of_two()) % count
}
