//! The forecast against looks and walks of the test's own.

use super::case::{Case, Held, NEAR_UM};
use crate::support::machine::{Errors, Term};
use crate::support::{self, DUST_UM, um_at};
use nonius::judge::forecast::TermForecast;
use nonius::quantity::{Axis, Direction, Interpolation};
use nonius::read::emulate::Response;

/// (b) The forecast is the largest of what a dense look finds, and not much more.
pub(crate) fn forecast_holds(case: &Case<'_>, term: &Term, forecast: &TermForecast) {
    let machine = case.machine;
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    for direction in Direction::BOTH {
        let Some((from, to)) = term.errors(direction).map(Errors::range) else { continue };
        for (base, output) in machine.pairs(term.term) {
            let response = support::response(case.control, base, output, direction);
            let held = match response.tables().first() {
                Some(_) => Held::of(&response),
                None => Held { mm: vec![from, to], um: vec![0.0, 0.0] },
            };
            for x in case.places(term, &held, from, to) {
                let deviation = term.deviation(direction, x);
                before = before.max(deviation.abs());
                after = after.max((deviation + um_at(&response, x)).abs());
            }
        }
    }
    let name = term.term;
    let linear = machine.kind == Interpolation::Linear;
    for (what, said, seen) in
        [("before", forecast.change.before_um, before), ("after", forecast.change.after_um, after)]
    {
        let near = if linear { NEAR_UM } else { 0.02 * before + 0.01 };
        assert!(said >= seen - DUST_UM, "{name}: {what} {said} µm, but {seen} µm was seen");
        assert!(said <= seen + near, "{name}: {what} {said} µm, but only {seen} µm was seen");
    }
    assert_eq!(forecast.compensated, case.is_compensated(name), "{name}");
}

pub(crate) fn diagonals_hold<'a>(case: &Case<'a>) {
    let machine = case.machine;
    if machine.terms.len() < 9 {
        assert!(case.kit.forecast.diagonals.is_empty());
        return;
    }
    let ends = Axis::ALL.map(|axis| {
        let terms = machine.terms.iter().filter(|t| t.term.along == axis);
        let errors = terms.flat_map(|t| Direction::BOTH.map(|way| t.errors(way)));
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        let ranges = errors.flatten().map(Errors::range);
        ranges.fold(all, |(l, h), (low, high)| (l.max(low), h.min(high)))
    });
    let length = ends.iter().map(|(l, h)| (h - l) * (h - l)).sum::<f64>().sqrt();
    for diagonal in &case.kit.forecast.diagonals {
        let is_up: Vec<bool> = diagonal.diagonal.name().chars().map(|of| of == 'P').collect();
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for reverse in [false, true] {
            let on_walk = |term: &'a Term| {
                let [of, along] = [term.term.of, term.term.along].map(|axis| axis as usize);
                let is_plus = is_up[along] != reverse;
                let direction = if is_plus { Direction::Plus } else { Direction::Minus };
                term.errors(direction)?;
                let (base, output) = machine.pairs(term.term)[0];
                let (low, high) = ends[along];
                let (from, to) = if is_up[along] { (low, high) } else { (high, low) };
                let side = (ends[of].1 - ends[of].0) / length;
                let cosine = if is_up[of] { side } else { -side };
                let response = support::response(case.control, base, output, direction);
                Some(OnWalk { term, direction, from, to, cosine, response })
            };
            let walk: Vec<OnWalk<'_>> = machine.terms.iter().filter_map(on_walk).collect();
            for t in steps_of_walk(case, &walk) {
                let mut sums = [0.0; 2];
                for OnWalk { term, direction, from, to, cosine, response } in &walk {
                    let x = from + t * (to - from);
                    let deviation = term.deviation(*direction, x);
                    sums[0] += cosine * deviation;
                    sums[1] += cosine * (deviation + um_at(response, x));
                }
                for (extent, sum) in extent.iter_mut().zip(sums) {
                    *extent = [extent[0].min(sum), extent[1].max(sum)];
                }
            }
        }
        let said = [diagonal.change.before_um, diagonal.change.after_um];
        for (said, [low, high]) in said.iter().zip(extent) {
            // The top of a cubic lies between two steps.
            let is_linear = machine.kind == Interpolation::Linear;
            let near = if is_linear { 1e-3 } else { 0.05 * said + 0.02 };
            let is_near = (high - low - DUST_UM..=high - low + near).contains(said);
            assert!(is_near, "{}: said {said}, seen {}", diagonal.diagonal, high - low);
        }
    }
}

/// One term on a walk along a diagonal: where its moving axis begins and ends, and what it gets.
struct OnWalk<'a> {
    term: &'a Term,
    direction: Direction,
    from: f64,
    to: f64,
    cosine: f64,
    response: Response,
}

/// Beside every bend and jump and between them; never where axes jump together, for which of them is first is rounding.
fn steps_of_walk(case: &Case<'_>, walk: &[OnWalk<'_>]) -> Vec<f64> {
    let mut breaks = vec![0.0, 1.0];
    for OnWalk { term, from, to, response, .. } in walk {
        let (bends, jumps) = match response.tables().first() {
            Some(_) => case.bends_and_jumps(term, &Held::of(response)),
            None => (term.knots(), Vec::new()),
        };
        breaks.extend(bends.iter().chain(&jumps).map(|x| (x - from) / (to - from)));
    }
    breaks.retain(|t| (0.0..=1.0).contains(t));
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-8);
    let between = |pair: &[f64]| {
        let inside = [0.25, 0.5, 0.75].map(|part| pair[0] + part * (pair[1] - pair[0]));
        [pair[0] + 1e-9, pair[1] - 1e-9].into_iter().chain(inside)
    };
    breaks.windows(2).flat_map(between).collect()
}
