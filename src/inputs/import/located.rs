//! Where a list has one value too few or too many: the place at which the rest fits best.
//!
//! Along a pass the increment from one capture to the next varies slowly, in steps of one axis at a time from
//! each third one to the next. A list that is off by one behind a place breaks that there, so the squares of
//! these differences are added up for every place that it can be.

use crate::quantity::Squared;
use nalgebra::Vector4;
use std::ops::Range;

/// What a reading scatters at least, µm: the last digit of a laser.
const LEAST_SCATTER_UM: f64 = 0.01;
/// A place that is less likely than the best one by this factor is not named.
const NOT_NAMED: f64 = 20.0;
/// Differences without which nothing can be told.
const LEAST_DIFFERENCES: f64 = 4.0;

/// The captures that were expected, in their order.
pub(super) struct Expected {
    /// Whether a pass begins with each.
    pub(super) begins: Vec<bool>,
    /// Whether each is taken where the one before was, moving the other way.
    pub(super) turns: Vec<bool>,
    /// The same capture in the run before.
    pub(super) twins: Vec<Option<usize>>,
    /// What of its value is its place, µm.
    pub(super) nominal_um: Vec<f64>,
    /// After how many captures the same axis moves again.
    pub(super) period: usize,
}

/// A reversal may be larger than the scatter by this factor.
const REVERSAL_BY_SCATTER: f64 = 100.0;

/// The likely places, best first, and how much likelier they are together than all others.
pub(super) struct Located {
    pub(super) places: Vec<usize>,
    pub(super) odds: f64,
}

/// Squares of differences that are linear in one unknown value x, `(a + b·x)²`, added up: a², ab, b², their number.
type Misfit = Vector4<f64>;

/// The mean square with the unknown value that fits best, and the scatter of a reading.
fn mean_square(misfit: &Misfit) -> f64 {
    let [aa, ab, bb, count] = [misfit.x, misfit.y, misfit.z, misfit.w];
    let taken = if bb > 0.0 { ab.squared() / bb } else { 0.0 };
    (aa - taken).max(0.0) / count.max(1.0) + LEAST_SCATTER_UM.squared()
}

/// Terms that are added to ranges of places, and what each place gets: a tree, in which nothing is ever subtracted.
struct Sums(Vec<Misfit>);

impl Sums {
    fn add(&mut self, range: Range<usize>, term: Misfit) {
        let places = self.0.len() / 2;
        let (mut from, mut to) = (range.start + places, range.end + places);
        while from < to {
            for at in [(from % 2 == 1).then_some(from), (to % 2 == 1).then(|| to - 1)] {
                at.into_iter().for_each(|at| self.0[at] += term);
            }
            (from, to) = (from.div_ceil(2), to / 2);
        }
    }

    fn of(&self, place: usize) -> Misfit {
        let above = std::iter::successors(Some(place + self.0.len() / 2), |at| Some(at / 2));
        above.take_while(|at| *at > 0).fold(Misfit::zeros(), |sum, at| sum + self.0[at])
    }
}

impl Expected {
    /// Which capture has no value: `values` are one fewer than the captures. The value of that capture is the
    /// unknown one, so that the way over the gap counts.
    pub(super) fn missing(&self, values: &[f64]) -> Option<Located> {
        self.located(self.begins.len(), |at, place, unknown| match at == place {
            true => Some(self.nominal_um[at] + unknown),
            false => values.get(at - usize::from(at > place)).copied(),
        })
    }

    /// Which value belongs to no capture: `values` are one more than the captures.
    pub(super) fn surplus(&self, values: &[f64]) -> Option<Located> {
        self.located(values.len(), |at, place, _| {
            values.get(at + usize::from(at >= place)).copied()
        })
    }

    /// `value(at, place, unknown)` = that of capture `at` where the list goes wrong at `place`.
    fn located(
        &self,
        places: usize,
        value: impl Fn(usize, usize, f64) -> Option<f64>,
    ) -> Option<Located> {
        let mut sums = Sums(vec![Misfit::zeros(); 2 * places]);
        for at in 0..self.begins.len() {
            // A term changes only where the list goes wrong at a capture that it takes, or behind it.
            let takes = [at, self.twins[at].unwrap_or(at.saturating_sub(self.period))];
            let near = takes.into_iter().flat_map(|at| at.saturating_sub(1)..at + 2);
            let mut edges: Vec<usize> = near.chain([0, places]).collect();
            edges.sort_unstable();
            for edge in edges.windows(2).filter(|edge| edge[0] < edge[1].min(places)) {
                let (from, to) = (edge[0], edge[1].min(places));
                sums.add(from..to, self.term(at, |at, unknown| value(at, from, unknown)));
            }
        }
        weighed(&(0..places).map(|place| sums.of(place)).collect::<Vec<Misfit>>())
    }

    /// The square of the difference of two increments of the same kind.
    fn term(&self, at: usize, value: impl Fn(usize, f64) -> Option<f64>) -> Misfit {
        let difference = |unknown: f64| {
            let error = |at: usize| Some(value(at, unknown)? - self.nominal_um[at]);
            let increment = |at: usize| Some(error(at)? - error(at - 1)?);
            if self.turns[at] {
                return Some(increment(at)? / REVERSAL_BY_SCATTER);
            }
            let other = self.twins[at].or(at.checked_sub(self.period))?;
            let same_pass =
                self.twins[at].is_some() || !self.begins[other + 1..=at].contains(&true);
            let increments = !self.begins[at] && !self.begins[other] && same_pass;
            increments.then(|| Some(increment(at)? - increment(other)?)).flatten()
        };
        let Some((a, whole)) = difference(0.0).zip(difference(1.0)) else {
            return Misfit::zeros();
        };
        let b = whole - a;
        Misfit::new(a.squared(), a * b, b.squared(), 1.0)
    }
}

/// Likelihoods of normal scatter of unknown size. Each reading is in several differences, so half as many are
/// counted as independent.
fn weighed(misfits: &[Misfit]) -> Option<Located> {
    let all = misfits.iter().map(|own| own.w).fold(0.0, f64::max);
    let likelihood = |own: &Misfit| -0.5 * (all / 2.0) * mean_square(own).ln();
    let logs: Vec<f64> = misfits.iter().map(likelihood).collect();
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weight = |place: &usize| (logs[*place] - best).exp();
    let (mut places, others): (Vec<usize>, Vec<usize>) =
        (0..logs.len()).partition(|place| weight(place) * NOT_NAMED >= 1.0);
    places.sort_by(|one, other| logs[*other].total_cmp(&logs[*one]));
    let sum = |places: &[usize]| places.iter().map(weight).sum::<f64>();
    let odds = sum(&places) / sum(&others).max(f64::MIN_POSITIVE);
    (all >= LEAST_DIFFERENCES).then_some(Located { places, odds })
}

#[cfg(test)]
mod tests {
    use super::Expected;
    use std::cell::Cell;

    #[test]
    fn each_capture_is_looked_at_a_few_times_also_where_its_twin_is_far() {
        for captures in [1_000, 10_000, 100_000] {
            let run = captures / 2;
            let expected = Expected {
                begins: (0..captures).map(|at| at % run == 0).collect(),
                turns: vec![false; captures],
                twins: (0..captures).map(|at: usize| at.checked_sub(run)).collect(),
                nominal_um: vec![0.0; captures],
                period: 1,
            };
            let looks = Cell::new(0);
            let value = |at: usize, place: usize, _: f64| {
                looks.set(looks.get() + 1);
                Some(f64::from(u8::from(at >= place)) + at as f64)
            };
            assert!(expected.located(captures, value).is_some());
            assert!(looks.get() <= 60 * captures, "{} looks at {captures}", looks.get());
        }
    }

    /// Three axes in turn with steps of 20, 16 and 16 mm, a bow, and a scatter of some tenths of a µm.
    fn walk(captures: u32) -> Vec<f64> {
        let mut sum = 0.0;
        let values = (0..captures).map(|k| {
            let scatter = f64::from(k * 7919 % 13) / 20.0;
            let step = [16_000.0, 20_000.0, 16_000.0][k as usize % 3];
            sum += if k == 0 { 0.0 } else { step + 0.02 * f64::from(k) };
            sum + scatter
        });
        values.collect()
    }

    #[test]
    fn the_place_of_a_missing_or_doubled_capture_is_found() {
        let whole = walk(61);
        let expected = Expected {
            begins: (0..61).map(|at| at == 0).collect(),
            turns: vec![false; 61],
            twins: vec![None; 61],
            nominal_um: vec![0.0; 61],
            period: 3,
        };
        for place in [0, 1, 2, 17, 30, 58, 59, 60] {
            let mut values = whole.clone();
            values.remove(place);
            let found = expected.missing(&values).expect("there are enough values");
            assert!(found.places.contains(&place), "missing {place}: {:?}", found.places);
            let mut values = whole.clone();
            values.insert(place, whole[place] + 0.1);
            let found = expected.surplus(&values).expect("there are enough values");
            assert!(found.places.contains(&place), "twice {place}: {:?}", found.places);
            assert!(found.places.len() <= 2 && found.odds > 1e6, "twice {place}");
        }
    }
}
