//! How far the vectors of a grid reach along a direction, without looking at all of them.
//!
//! Along a direction d the map is a sum in which the third axis stands alone but for one slope:
//! f(i,j,k) = α_i + γ_i·y_j + μ_j + (β_i + ν_j)·z_k + κ_k. Over k the largest value is the
//! envelope of the lines z_k·s + κ_k at the slope s = β_i + ν_j, and a few chords bound it; for
//! each chord the largest value over j is again an envelope, of y_j·γ_i plus a constant, and a
//! few chords bound that. What is left is a handful of planes over (γ_i, β_i): one bound for
//! each row i. Only rows whose bound counts are looked at node by node.
//!
//! The largest of many straight lines, and a few lines that are nowhere below it.
//!
//! max over v of (s·x_v + y_v), as a function of the slope s, is convex and made of straight
//! pieces; the points (x_v, y_v) that count are the upper hull. Chords of a convex function lie
//! above it: a few of them bound what many lines have to be asked for.

use super::grid_map::{ARM, BY_SECOND, BY_THIRD, Distinct, GridMap, Node, ROLL, Row, Vector};
use super::pair::{Point, dot};

/// Nodes of an axis for each chord of a bound.
const NODES_A_CHORD: usize = 24;

/// Chords of a bound at most.
const CHORDS: usize = 8;

/// The sum f along a direction, with the bounds of its rows.
#[derive(Default)]
pub(super) struct Support {
    alpha: Vec<f64>,
    gamma: Vec<f64>,
    beta: Vec<f64>,
    mu: Vec<f64>,
    nu: Vec<f64>,
    kappa: Vec<f64>,
    /// Smallest and largest ν.
    nu_range: (f64, f64),
    third: Envelope,
    second: Envelope,
    chords: Vec<HullLine>,
    chords_of_chord: Vec<HullLine>,
    /// Bound of each row.
    rows: Vec<f64>,
    /// Values of a row's lines, the third axis at its best.
    line: Vec<f64>,
}

fn fill(values: &mut Vec<f64>, nodes: &[(usize, Row)], value: impl Fn(&Row) -> f64) {
    values.clear();
    values.extend(nodes.iter().map(|(_, row)| value(row)));
}

fn range(values: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    values.iter().fold(start, |(low, high), v| {
        (if *v < low { *v } else { low }, if *v > high { *v } else { high })
    })
}

impl Support {
    /// Turns to the direction `d`, given in the order of the chain; returns a bound of f.
    pub(super) fn aim(&mut self, grid: &Distinct, d: &Vector) -> f64 {
        let [first, second, third] = &grid.axes;
        let along = |row: &Row| dot(d, &[row[0], row[1], row[2]]);
        let swung = |row: &Row| d[0] * row[BY_THIRD] - d[1] * row[ROLL];
        fill(&mut self.alpha, first, along);
        fill(&mut self.gamma, first, |row| d[0] * row[BY_SECOND] + d[2] * row[ROLL]);
        fill(&mut self.beta, first, swung);
        fill(&mut self.mu, second, along);
        fill(&mut self.nu, second, swung);
        fill(&mut self.kappa, third, along);
        self.nu_range = range(&self.nu);
        let arms = third.iter().map(|(_, row)| row[ARM]);
        self.third.fill(arms.zip(self.kappa.iter().copied()));
        self.bound_rows(grid);
        range(&self.rows).1
    }

    fn bound_rows(&mut self, grid: &Distinct) {
        let limit = |nodes: usize| (1 + nodes / NODES_A_CHORD).min(CHORDS);
        let (low, high) = range(&self.beta);
        let slopes = (low + self.nu_range.0, high + self.nu_range.1);
        let (low, high) = range(&self.gamma);
        self.rows.clear();
        self.rows.resize(self.alpha.len(), f64::NEG_INFINITY);
        let chords = limit(grid.axes[2].len());
        self.third.few(slopes.0, slopes.1, chords, &mut self.chords);
        for chord in &self.chords {
            let arms = grid.axes[1].iter().map(|(_, row)| row[ARM]);
            let heights = self.mu.iter().zip(&self.nu).map(|(mu, nu)| mu + nu * chord.x);
            self.second.fill(arms.zip(heights));
            let planes = &mut self.chords_of_chord;
            self.second.few(low, high, limit(grid.axes[1].len()), planes);
            for plane in planes {
                let slopes = self.gamma.iter().zip(&self.beta);
                let height = plane.y + chord.y;
                for (row, (gamma, beta)) in self.rows.iter_mut().zip(slopes) {
                    let value = (gamma * plane.x + beta * chord.x) + height;
                    *row = if value > *row { value } else { *row };
                }
            }
        }
        for (row, alpha) in self.rows.iter_mut().zip(&self.alpha) {
            *row += alpha;
        }
    }

    /// Computes the largest f of every line of row `i`.
    fn look_at_row(&mut self, grid: &Distinct, i: usize) {
        let (beta, gamma, alpha) = (self.beta[i], self.gamma[i], self.alpha[i]);
        let (low, high) = self.nu_range;
        let lines = self.third.between(beta + low, beta + high);
        self.line.clear();
        let first = lines[0];
        self.line.extend(self.nu.iter().map(|nu| first.at(beta + nu)));
        for line in &lines[1..] {
            for (best, nu) in self.line.iter_mut().zip(&self.nu) {
                let value = line.at(beta + nu);
                *best = if value > *best { value } else { *best };
            }
        }
        let nodes = self.mu.iter().zip(&grid.axes[1]);
        for (best, (mu, (_, row))) in self.line.iter_mut().zip(nodes) {
            *best += (alpha + gamma * row[ARM]) + mu;
        }
    }

    /// The largest f, and its node as places in `grid`.
    pub(super) fn furthest(&mut self, grid: &Distinct) -> (f64, Node) {
        let mut best = (f64::NEG_INFINITY, 0, 0);
        let bound = range(&self.rows).1;
        let start = self.rows.iter().position(|row| *row >= bound).unwrap_or(0);
        for i in std::iter::once(start).chain(0..self.rows.len()) {
            if self.rows[i] > best.0 {
                self.look_at_row(grid, i);
                let high = range(&self.line).1;
                if high > best.0 {
                    let j = self.line.iter().position(|value| *value >= high);
                    best = (high, i, j.unwrap_or(0));
                }
            }
        }
        let (value, i, j) = best;
        let slope = self.beta[i] + self.nu[j];
        let lines = self.third.between(slope, slope);
        let k = highest(lines, slope);
        (value, [i, j, k.number])
    }

    /// The vectors with f ≥ `least`; `None` where they are more than `most`.
    pub(super) fn beyond(
        &mut self,
        (map, grid): (&GridMap, &Distinct),
        least: f64,
        most: usize,
    ) -> Option<Vec<Point>> {
        let mut points = Vec::new();
        for i in 0..self.rows.len() {
            if self.rows[i] < least {
                continue;
            }
            self.look_at_row(grid, i);
            for (j, (second, row)) in grid.axes[1].iter().enumerate() {
                if self.line[j] < least {
                    continue;
                }
                let start = (self.alpha[i] + self.gamma[i] * row[ARM]) + self.mu[j];
                let slope = self.beta[i] + self.nu[j];
                for ((third, row), kappa) in grid.axes[2].iter().zip(&self.kappa) {
                    if start + (slope * row[ARM] + kappa) >= least {
                        let node = [grid.axes[0][i].0, *second, *third];
                        points.push(Point { at: map.at(node), number: map.number(node) });
                    }
                }
                if points.len() > most {
                    return None;
                }
            }
        }
        Some(points)
    }
}

/// A line over slopes: s·x + y.
#[derive(Clone, Copy, Debug)]
pub(super) struct HullLine {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Number of the point.
    pub(super) number: usize,
}

impl HullLine {
    #[inline(always)]
    pub(super) fn at(&self, slope: f64) -> f64 {
        slope * self.x + self.y
    }
}

/// The upper hull of points whose x ascends.
#[derive(Clone, Debug, Default)]
pub(super) struct Envelope {
    hull: Vec<HullLine>,
    /// Slope at which the next point of the hull takes over.
    turns: Vec<f64>,
}

impl Envelope {
    /// Makes it the envelope of other points. A point is left out only where it is clearly below.
    pub(super) fn fill(&mut self, points: impl Iterator<Item = (f64, f64)>) {
        self.hull.clear();
        for (number, (x, y)) in points.enumerate() {
            while let [.., a, b] = self.hull.as_slice() {
                let chord = a.y + (y - a.y) * ((b.x - a.x) / (x - a.x));
                let margin = 8.0 * f64::EPSILON * (a.y.abs() + y.abs());
                if b.y >= chord - margin {
                    break;
                }
                self.hull.pop();
            }
            self.hull.push(HullLine { x, y, number });
        }
        self.turns.clear();
        let pairs = self.hull.windows(2);
        self.turns.extend(pairs.map(|pair| (pair[0].y - pair[1].y) / (pair[1].x - pair[0].x)));
    }

    /// The lines that can be the largest for a slope of `low..=high`.
    ///
    /// The turns ascend but for rounding, which costs no more than rounding.
    pub(super) fn between(&self, low: f64, high: f64) -> &[HullLine] {
        let first = self.turns.partition_point(|turn| *turn < low);
        let last = self.turns.partition_point(|turn| *turn <= high);
        &self.hull[first..=last.max(first)]
    }

    /// At most `limit` lines whose largest is nowhere below the envelope for `low..=high`.
    pub(super) fn few(&self, low: f64, high: f64, limit: usize, lines: &mut Vec<HullLine>) {
        lines.clear();
        let all = self.between(low, high);
        let count = limit.max(1);
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let knot = |n: usize| low + (high - low) * (n as f64 / count as f64);
        if all.len() <= limit || (1..=count).any(|n| knot(n) <= knot(n - 1)) {
            lines.extend_from_slice(all);
            return;
        }
        let mut value = highest(all, low).at(low);
        for n in 1..=count {
            let next = highest(all, knot(n)).at(knot(n));
            let x = (next - value) / (knot(n) - knot(n - 1));
            let y = next - x * knot(n);
            lines.push(HullLine { x, y, number: n });
            value = next;
        }
    }
}

/// The highest line at a slope, the first of several.
fn highest(lines: &[HullLine], slope: f64) -> HullLine {
    lines[1..].iter().fold(lines[0], |best, line| {
        let is_higher = line.at(slope) > best.at(slope);
        if is_higher { *line } else { best }
    })
}
