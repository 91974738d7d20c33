//! The largest of many straight lines, and a few lines that are nowhere below it.
//!
//! max over v of (s·x_v + y_v), as a function of the slope s, is convex and made of straight
//! pieces; the points (x_v, y_v) that count are the upper hull. Chords of a convex function lie
//! above it: a few of them bound what many lines have to be asked for.

/// A line over slopes: s·x + y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Number of the point.
    pub(super) number: usize,
}

impl Line {
    #[inline(always)]
    pub(super) fn at(&self, slope: f64) -> f64 {
        slope * self.x + self.y
    }
}

/// The upper hull of points whose x ascends.
#[derive(Clone, Debug, Default)]
pub(super) struct Envelope {
    hull: Vec<Line>,
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
            self.hull.push(Line { x, y, number });
        }
        self.turns.clear();
        let pairs = self.hull.windows(2);
        self.turns
            .extend(pairs.map(|pair| (pair[0].y - pair[1].y) / (pair[1].x - pair[0].x)));
    }

    /// The lines that can be the largest for a slope of `low..=high`.
    ///
    /// The turns ascend but for rounding, which costs no more than rounding.
    pub(super) fn between(&self, low: f64, high: f64) -> &[Line] {
        let first = self.turns.partition_point(|turn| *turn < low);
        let last = self.turns.partition_point(|turn| *turn <= high);
        &self.hull[first..=last.max(first)]
    }

    /// At most `limit` lines whose largest is nowhere below the envelope for `low..=high`.
    pub(super) fn few(&self, low: f64, high: f64, limit: usize, lines: &mut Vec<Line>) {
        lines.clear();
        let all = self.between(low, high);
        let count = limit.max(1);
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let knot = |n: usize| low + (high - low) * (n as f64 / count as f64);
        if all.len() <= limit || (1..=count).any(|n| knot(n) <= knot(n - 1)) {
            lines.extend_from_slice(all);
            return;
        }
        let mut value = largest(all, low);
        for n in 1..=count {
            let next = largest(all, knot(n));
            let x = (next - value) / (knot(n) - knot(n - 1));
            let y = next - x * knot(n);
            lines.push(Line { x, y, number: n });
            value = next;
        }
    }
}

fn largest(lines: &[Line], slope: f64) -> f64 {
    let start = lines[0].at(slope);
    lines[1..].iter().fold(start, |m, line| {
        let value = line.at(slope);
        if value > m { value } else { m }
    })
}
