//! Round numbers for the ticks of an axis.

use crate::quantity::{Figure, larger, power_of_ten, smaller};

/// Ticks at round numbers between two numbers, with as many decimals as they need.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    pub(super) at: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// At most `most` ticks (2 at least), 1, 2 or 5 times a power of ten apart.
    pub(super) fn between(from: f64, to: f64, most: usize) -> Ticks {
        let (step, decimals) = step((to - from).abs(), most);
        let (first, last) = ((from / step - SLACK).ceil(), (to / step + SLACK).floor());
        let mut at = Vec::new();
        let mut number = first;
        while number <= last && at.len() <= most {
            at.push(number * step + 0.0);
            number += 1.0;
        }
        Ticks { at, decimals }
    }

    /// A tick in words.
    pub(super) fn label(&self, number: f64) -> String {
        format!("{:.*}", self.decimals, Figure(number)).replace('-', "\u{2212}")
    }
}

/// A tick that lies this part of a step outside is the end of the axis.
const SLACK: f64 = 1e-9;

/// The round number that is just large enough, and its decimals.
fn step(span: f64, most: usize) -> (f64, usize) {
    const DIGITS: [f64; 3] = [1.0, 2.0, 5.0];
    let fine = (0..=9_u8).rev();
    let fine = fine.flat_map(|n| DIGITS.map(|digit| (digit / power_of_ten(n.into()), n)));
    let coarse = (1..=12).flat_map(|n| DIGITS.map(|digit| (digit * power_of_ten(n), 0)));
    let found = fine.chain(coarse).find(|(step, _)| fits(span, *step, most));
    found.map_or((span, 0), |(step, decimals)| (step, decimals.into()))
}

fn fits(span: f64, step: f64, most: usize) -> bool {
    let intervals = u32::try_from(most.max(2) - 1).unwrap_or(u32::MAX);
    span <= step * f64::from(intervals) * (1.0 + SLACK)
}

/// Round numbers below and above all numbers and zero, for one scale of several panels.
pub(super) fn around(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers
        .fold((0.0, 0.0), |(low, high), number| (smaller(low, number), larger(high, number)));
    let span = larger(high - low, 1e-3);
    let (step, _) = step(span, 6);
    let whole = |number: f64| step * (number / step - SLACK).ceil() + 0.0;
    match (whole(-low), whole(high)) {
        (below, above) if below + above > 0.0 => (0.0 - below, above),
        _ => (-step, step),
    }
}

/// Width of the bins of a histogram of differences up to so many µm.
pub fn bin_um(largest_um: f64) -> f64 {
    larger(below(largest_um / 10.0), 0.001)
}

/// The largest round number (1, 2 or 5 times a power of ten) that is not above half of a number.
pub(super) fn below(number: f64) -> f64 {
    let exponents = (0..=6_u32).map(|n| 1.0 / power_of_ten(n)).chain((1..=6).map(power_of_ten));
    let round = exponents.flat_map(|unit| [unit, 2.0 * unit, 5.0 * unit]);
    round.filter(|round| *round <= number / 2.0).fold(0.0, larger)
}

/// A number of things as a number of a picture.
pub(super) fn count(number: usize) -> f64 {
    u32::try_from(number).map_or(f64::MAX, f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let ticks = Ticks::between(-3.0, 903.0, 6);
        assert_eq!(ticks.at, [0.0, 200.0, 400.0, 600.0, 800.0]);
        assert_eq!(ticks.label(-200.0), "\u{2212}200");
        let ticks = Ticks::between(-0.3, 0.3, 5);
        let labels: Vec<String> = ticks.at.iter().map(|at| ticks.label(*at)).collect();
        assert_eq!(labels, ["\u{2212}0.2", "0.0", "0.2"]);
        assert_eq!(Ticks::between(0.0, 0.0, 4).at.len(), 1);
    }

    #[test]
    fn a_height_is_round_and_holds_all() {
        assert_eq!(around([12.3, -17.0].into_iter()), (-20.0, 20.0));
        assert_eq!(around([0.31, 14.0].into_iter()), (0.0, 15.0));
        let (low, high) = around(std::iter::empty());
        assert!(low < high);
    }
}
