//! The one look that decides between causes: where the corrections that act differ most.
//!
//! A control may show the compensation value that acts; reading it costs nothing. No manual says
//! with which sign, so amounts are compared. Where no display is known the tables are read back;
//! where only a sign is in question a bump decides; where the control does as planned
//! (temperature), a linear run; where the first readings may be filed wrongly, their records.

use crate::judge::after::SeenDeviation;
use crate::judge::causes::change::{Change, Question, number};
use crate::judge::causes::data::{Data, Fit, minus, plus, quantile};
use crate::judge::causes::hypotheses::{CHECKS, Hypothesis};
use crate::quantity::{Axis, Direction, ErrorTerm, Figure, Millimetres, ends};
use crate::text::joined;
use nalgebra::{DMatrix, DVector};

/// What a display and a dial gauge tell apart, µm.
const TOLD_APART_UM: f64 = 0.5;
/// The last digit that is shown, µm.
const SHOWN_UM: f64 = 0.001;
const READ_BACK: &str = "read tables and parameters out of the control and compare them with the files (`nonius verify JOB --tables DIR`), then look whether they are switched on, once";

/// Hypotheses that the data do not exclude, fitted.
type Standing<'a> = [(&'a Hypothesis, Fit)];

/// What acts at one place, coming there moving + and moving −, without its sign, µm.
type BothWays = [f64; 2];

/// The sentence.
pub(super) fn decides(question: &Question<'_>, standing: &Standing<'_>) -> String {
    let changes = || standing.iter().map(|(tried, _)| &tried.change);
    if changes().all(|change| matches!(change, Change::Warmer(_))) {
        return linear_run(question, standing);
    }
    let looks = !changes().all(|change| matches!(change, Change::Recorded(_)));
    let look = looks.then(|| match question.display {
        Some(display) => by_display(question, standing, display),
        None => format!("no display of the correction is known of this control: {READ_BACK}"),
    });
    let is_due = |kind: &str| {
        let needs_bump = looks && question.display.is_none() && kind == "sign turned";
        needs_bump || standing.iter().any(|(tried, _)| tried.kind.1 == kind)
    };
    let checks = CHECKS.into_iter().filter(|(kind, _)| is_due(kind));
    let steps = look.into_iter().chain(checks.map(|(_, check)| check.to_string()));
    steps.collect::<Vec<String>>().join("; ")
}

/// The place, among the nodes of the tables where the second measurement looked, where most of the hypotheses and
/// the files differ, by the most. Temperature, a turned measurement and slips of its records leave the control as planned.
fn by_display(question: &Question<'_>, standing: &Standing<'_>, display: &str) -> String {
    let told_apart_um = TOLD_APART_UM.max(2.0 * question.count_um);
    let places = question.terms().into_iter().flat_map(|term| {
        let along = question.parts().filter(|part| part.term.along == term.along);
        let (low, high) = ends(along.map(|part| part.at.mm()));
        let nodes = question.control.nodes(term).into_iter();
        nodes.filter(move |at| (low..=high).contains(&at.mm())).map(move |at| (term, at))
    });
    let looks = places.map(|(term, at)| {
        let acting = |change: &Change, fitted: &[f64]| {
            let part = |direction| SeenDeviation { term, direction, at, weight: 1.0 };
            Direction::BOTH.map(|way| change.effect(question, fitted, &part(way))[0].abs())
        };
        let with = standing.iter().map(|(tried, fit)| acting(&tried.change, &fit.fitted));
        let shown: Vec<BothWays> = [acting(&Change::None, &[])].into_iter().chain(with).collect();
        let (mut groups, mut gap_um) = (Vec::new(), f64::INFINITY);
        for own in &shown {
            let distances = groups.iter().map(|other| apart_um(own, other));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            if nearest > told_apart_um {
                groups.push(*own);
                gap_um = gap_um.min(nearest);
            }
        }
        ((groups.len(), gap_um), (term, at), shown)
    });
    let best = looks.reduce(|best, other| if other.0 > best.0 { other } else { best });
    let Some((_, place, shown)) = best.filter(|((groups, _), ..)| *groups > 1) else {
        return format!(
            "where was measured, what {display} shows is the same for all within {told_apart_um:.3} µm: {READ_BACK}"
        );
    };
    let said = display_at(standing, place, &shown, display);
    let is_near = |(at, one)| shown[at + 1..].iter().any(|o| apart_um(one, o) <= told_apart_um);
    match shown.iter().enumerate().skip(1).any(is_near) {
        false => said,
        true => format!("{said}; where that leaves more than one, {READ_BACK}"),
    }
}

/// Distance of two amounts, the larger of both directions, µm.
fn apart_um(one: &BothWays, other: &BothWays) -> f64 {
    let way = |at: usize| (one[at] - other[at]).abs();
    way(0).max(way(1))
}

/// `shown` = as planned, then with each hypothesis.
fn display_at(
    standing: &Standing<'_>,
    (ErrorTerm { of, along }, at): (ErrorTerm, Millimetres),
    shown: &[BothWays],
    display: &str,
) -> String {
    let mut said: Vec<(String, &BothWays)> = Vec::new();
    for ((tried, _), own) in standing.iter().zip(&shown[1..]) {
        match said.iter_mut().find(|(_, other)| apart_um(own, other) < SHOWN_UM) {
            Some((words, _)) => add_label(words, &tried.label),
            None => said.push((tried.label.clone(), own)),
        }
    }
    let mut all = said.iter().map(|(_, own)| *own).chain([&shown[0]]);
    let alike = all.all(|[plus, minus]| (plus - minus).abs() < SHOWN_UM);
    let amount = |[plus, minus]: &BothWays| match alike {
        true => format!("{plus:.3} µm"),
        false => format!("{plus:.3} / {minus:.3} µm"),
    };
    let cases = joined(said.iter().map(|(words, own)| format!("{} if {words}", amount(own))));
    let coming = if alike { "" } else { " coming there moving + / moving -," };
    let (mm, as_said) = (Figure(at.mm()).trimmed(3), amount(&shown[0]));
    format!(
        "look at {display}: {along} at {mm} mm, the other axes at their reference points,{coming} the amount for axis {of} is {as_said} if the control does what the files say, {cases} (its sign on the display is not documented)"
    )
}

/// Labels of one value are joined; many are cut.
fn add_label(words: &mut String, label: &str) {
    const MOST: usize = 3;
    let joined = words.matches(" or ").count() + 1;
    match words.contains(label) {
        true => {}
        false if joined < MOST => *words += &format!(" or {label}"),
        false if !words.ends_with(" …") => words.push_str(" …"),
        false => {}
    }
}

/// Temperature leaves the control alone: the axis on which the explanations differ most.
fn linear_run(question: &Question<'_>, standing: &Standing<'_>) -> String {
    let spread = |axis: &Axis| {
        let slopes = standing.iter().map(|(tried, fit)| match &tried.change {
            Change::Warmer(places) => question.um_per_m(*axis, number(&fit.fitted, places[*axis])),
            _ => 0.0,
        });
        let (low, high) = ends(slopes);
        if standing.len() == 1 { high.abs() } else { high - low }
    };
    let axis = Axis::ALL.into_iter().max_by(|a, b| spread(a).total_cmp(&spread(b)));
    let axis = axis.unwrap_or(Axis::X);
    format!(
        "repeat one bidirectional linear run of axis {axis} with the machine at another temperature, with its sensors on scale and workpiece: a temperature moves the slope ({:.1} µm/m per K), a fault of the tables does not",
        question.alpha_per_k[axis] * 1e6
    )
}

// The numbers of a change, fitted: factors and slopes in closed form, shifts by search.

/// Singular values below this share of a column's length are rounding.
const NEGLIGIBLE: f64 = 1e-9;
/// Steps to either side in which a shift is searched over half the length of the tables.
const SHIFTS: f64 = 40.0;
/// Sums of squares that differ by less are rounding.
const SAME_SQUARE: f64 = 1.0 + 1e-9;
/// Share of the cases in which the true shift lies within its stated uncertainty.
const COVERED: f64 = 0.95;

impl Data<'_> {
    /// The change with its numbers fitted.
    pub(super) fn fit(&self, change: &Change) -> Fit {
        let fitted = match (change, change.numbers()) {
            (_, 0) => Vec::new(),
            (Change::Shifted(_), count) => self.shifted(change, count),
            (_, count) => self.linear(change, count),
        };
        self.evaluated(change, fitted)
    }

    /// Weighted least squares of numbers that act in proportion.
    fn linear(&self, change: &Change, count: usize) -> Vec<f64> {
        let weighted = |values: Vec<f64>| self.weighted(&self.less_zeros(&values));
        let mut numbers = vec![0.0; count];
        let base = self.effects(change, &numbers);
        let left = minus(&self.measured_um, &plus(&self.found_um, &base));
        let left = DVector::from_vec(weighted(left));
        let mut columns = Vec::new();
        for index in 0..count {
            numbers[index] = 1.0;
            columns.extend(weighted(minus(&self.effects(change, &numbers), &base)));
            numbers[index] = 0.0;
        }
        let matrix = DMatrix::from_vec(left.len(), count, columns);
        let solved = matrix.svd(true, true).solve(&left, NEGLIGIBLE);
        solved.map_or(numbers, |found| found.iter().copied().collect())
    }

    /// A shift acts through the shape of the tables: searched on a grid, then narrowed. Axes are
    /// searched one after the other; twice where they meet on a diagonal.
    fn shifted(&self, change: &Change, count: usize) -> Vec<f64> {
        let mut fitted = vec![0.0; count];
        let meet = self.question.seen.iter().any(|o| o.diagonal.is_some());
        for _ in 0..if meet && count > 1 { 2 } else { 1 } {
            for (axis, place) in change.shifts() {
                let of = |mm| self.square(&self.with(change, &fitted, place, mm));
                fitted[place] = self.search(axis, of);
            }
        }
        fitted
    }

    /// A change with one of its numbers changed.
    fn with(&self, change: &Change, fitted: &[f64], place: usize, number: f64) -> Fit {
        let mut tried = fitted.to_vec();
        tried[place] = number;
        self.evaluated(change, tried)
    }

    fn search(&self, axis: Axis, square: impl Fn(f64) -> f64) -> f64 {
        let most = self.longest_shift(axis);
        if most <= 0.0 {
            return 0.0;
        }
        let step = most / SHIFTS;
        let best = |places: &mut dyn Iterator<Item = f64>| {
            places.map(|mm| (square(mm), mm)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let next = |mm: &f64| Some(mm + step);
        let mut grid = std::iter::successors(Some(-most), next).take_while(|mm| *mm <= most);
        let (_, middle) = best(&mut grid);
        let narrow = narrowed(middle - step, middle + step, &square);
        let (least, best) = best(&mut [middle, narrow].into_iter());
        let limit = least * SAME_SQUARE + f64::MIN_POSITIVE;
        let (low, high) = interval(best, most, square, limit);
        f64::midpoint(low, high)
    }

    /// Half the length of the tables along an axis, mm; 0 without tables.
    fn longest_shift(&self, axis: Axis) -> f64 {
        let along = ErrorTerm::ALL.into_iter().filter(|term| term.along == axis);
        let nodes = along.flat_map(|term| self.question.control.nodes(term));
        let (low, high) = ends(nodes.map(|at| at.mm()));
        ((high - low) / 2.0).max(0.0)
    }

    /// How far a fitted shift may lie from the true one, mm: to the farther end of the shifts
    /// whose score is within that of 95 % (one degree of freedom), one number for each.
    pub(super) fn shift_uncertainty_mm(&self, change: &Change, fit: &Fit) -> Vec<f64> {
        let limit = self.score(fit) + quantile(COVERED, 1.0);
        let of = |(axis, place): (Axis, usize)| {
            let best = fit.fitted[place];
            let score = |mm: f64| self.score(&self.with(change, &fit.fitted, place, mm));
            let (low, high) = interval(best, self.longest_shift(axis), score, limit);
            (high - best).max(best - low)
        };
        change.shifts().into_iter().map(of).collect()
    }
}

/// The stretch around `best` on which `of` stays within `limit`, to `most` on either side. Where a
/// control corrects in steps the squares do so too: every shift of a plateau is as good.
fn interval(best: f64, most: f64, of: impl Fn(f64) -> f64, limit: f64) -> (f64, f64) {
    const FIRST_MM: f64 = 1e-3;
    const ROUNDS: usize = 20;
    let edge = |sign: f64| {
        let within = |mm: f64| of(best + sign * mm) <= limit;
        let (mut inside, mut outside) = (0.0, FIRST_MM);
        while outside < most && within(outside) {
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..ROUNDS {
            let middle = f64::midpoint(inside, outside);
            *if within(middle) { &mut inside } else { &mut outside } = middle;
        }
        best + sign * inside
    };
    (edge(-1.0), edge(1.0))
}

/// Golden section.
fn narrowed(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_895;
    const ROUNDS: usize = 24; // 10⁻⁵ of the first width
    for _ in 0..ROUNDS {
        let (a, b) = (high - SHARE * (high - low), low + SHARE * (high - low));
        if of(a) <= of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    f64::midpoint(low, high)
}
