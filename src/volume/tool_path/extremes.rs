//! Smallest and largest values along a path, with the places where they are, and where a polynomial turns.

use crate::text::words;
use part_program::Place;
use serde::Serialize;

words! {
    /// What is followed along a path, by its name in tables and documents.
    pub enum Channel {
        /// Error in X.
        X = "ex",
        /// Error in Y.
        Y = "ey",
        /// Error in Z.
        Z = "ez",
        /// Along the path: positive ahead.
        Tangent = "tangent",
        /// Across the path in the selected plane: positive to the left.
        Normal = "normal",
        /// Length of the error vector.
        Length = "|e|",
    }
}

impl Channel {
    /// All of them, in the order in which they are shown.
    pub const ALL: [Channel; 6] =
        [Channel::X, Channel::Y, Channel::Z, Channel::Tangent, Channel::Normal, Channel::Length];
}

/// An extreme value and where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extreme {
    /// µm.
    pub um: f64,
    /// Machine coordinates, mm.
    #[serde(rename = "at_mm")]
    pub place: Place,
    /// Line of the program.
    pub line: usize,
}

/// Smallest and largest value of a channel; of several places with the same one, the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The smallest.
    pub min: Extreme,
    /// The largest.
    pub max: Extreme,
}

/// Of no value.
impl Default for Range {
    fn default() -> Range {
        let none = |um| Extreme { um, place: [0.0; 3], line: 0 };
        Range { min: none(f64::INFINITY), max: none(f64::NEG_INFINITY) }
    }
}

impl Range {
    /// Whether a value lies outside.
    #[inline]
    pub(super) fn is_passed_by(&self, um: f64) -> bool {
        um < self.min.um || um > self.max.um
    }

    #[inline]
    pub(super) fn take(&mut self, um: f64, place: Place, line: usize) {
        if um < self.min.um {
            self.min = Extreme { um, place, line };
        }
        if um > self.max.um {
            self.max = Extreme { um, place, line };
        }
    }

    /// Whether anything was taken.
    pub(super) fn is_found(&self) -> bool {
        self.min.um.is_finite()
    }
}

/// Halvings of an interval until it has no more floating-point numbers inside.
const HALVINGS: usize = 80;

/// The places inside 0 … 1 where the polynomial c₀ + c₁t + c₂t² … has the value zero and changes
/// its sign, ascending.
fn crossings(coefficients: &[f64]) -> Vec<f64> {
    match coefficients {
        [] | [_] => Vec::new(),
        [zero, slope] => {
            let root = -zero / slope;
            if root > 0.0 && root < 1.0 { vec![root] } else { Vec::new() }
        }
        _ => {
            let mut ends = vec![0.0];
            ends.extend(crossings(&derivative(coefficients)));
            ends.push(1.0);
            ends.windows(2).filter_map(|pair| crossing(coefficients, pair[0], pair[1])).collect()
        }
    }
}

/// The turning points of a polynomial inside 0 … 1.
pub(super) fn turning_points(coefficients: &[f64]) -> Vec<f64> {
    crossings(&derivative(coefficients))
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    let terms = coefficients.iter().enumerate().skip(1);
    terms.map(|(power, coefficient)| coefficient * power as f64).collect()
}

fn value(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// The crossing between two places, where the polynomial is monotone.
fn crossing(coefficients: &[f64], mut low: f64, mut high: f64) -> Option<f64> {
    let (at_low, at_high) = (value(coefficients, low), value(coefficients, high));
    if at_low == 0.0 || at_low * at_high >= 0.0 {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if value(coefficients, middle) * at_low > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(f64::midpoint(low, high))
}

/// The polynomial through equally spaced values on 0 … 1: three of a parabola, five of a quartic.
pub(super) fn through(values: &[f64]) -> Vec<f64> {
    match values {
        [a, b, c] => vec![*a, 4.0 * b - 3.0 * a - c, 2.0 * (a - 2.0 * b + c)],
        [a, b, c, d, e] => {
            let d1 = b - a;
            let d2 = c - 2.0 * b + a;
            let d3 = d - 3.0 * c + 3.0 * b - a;
            let d4 = e - 4.0 * d + 6.0 * c - 4.0 * b + a;
            // Newton's form in 4t, written out in powers of t.
            vec![
                *a,
                4.0 * (d1 - d2 / 2.0 + d3 / 3.0 - d4 / 4.0),
                16.0 * (d2 / 2.0 - d3 / 2.0 + d4 * 11.0 / 24.0),
                64.0 * (d3 / 6.0 - d4 / 4.0),
                256.0 * d4 / 24.0,
            ]
        }
        _ => values.first().map(|value| vec![*value]).unwrap_or_default(),
    }
}

/// The sum of the squares of polynomials.
pub(super) fn squares(polynomials: &[Vec<f64>]) -> Vec<f64> {
    let longest = polynomials.iter().map(Vec::len).max().unwrap_or(0);
    let mut sum = vec![0.0; (2 * longest).saturating_sub(1)];
    for polynomial in polynomials {
        for (i, a) in polynomial.iter().enumerate() {
            for (j, b) in polynomial.iter().enumerate() {
                sum[i + j] += a * b;
            }
        }
    }
    sum
}
