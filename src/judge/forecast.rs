//! What the tables will leave: deviation without compensation + emulated correction, over the
//! whole measured range, in every measured direction. Where tables were active while measuring,
//! what was measured and the deviation without them are two models of the same machine.
//!
//! ```text
//!   ErrorModel ───────────────┐
//!                             ├→ residual of every term, of every body diagonal → Forecast
//!   bytes → Tables → Emulator ┘
//! ```
//! Extremes are exact: a correction is a straight line between its breaks, a curve a cubic
//! between its knots, so no position has to be sampled.

mod figures;
mod reasons;
mod share;

pub use self::figures::{Basis, Change, DiagonalForecast, Forecast, Of, TermForecast};
pub(crate) use self::figures::{Missed, shares};
pub(crate) use self::reasons::terms_words;
pub use self::reasons::{Grounds, Miss, RestsOn};
pub use self::share::{JudgedRange, Machine};
pub(crate) use self::share::{is_whole_travel, judged_ranges, range_of, widest_gap_mm, words};

use crate::judge::conformity::{Magnitude, Sigma, expanded_um, largest_um};
use crate::judge::field::Field;
use crate::machine::model::{
    ErrorModel, MeasuredTerm, PointUncertainty, Range, TermCurves, within,
};
use crate::quantity::{
    AT_PLACE_MM, Axis, Diagonal, Direction, ErrorCurve, ErrorTerm, Millimetres, Pass, PerAxis,
    Squared, Volume, ends, larger,
};
use crate::read::emulate::Response;
use crate::text::grouped;
use crate::write::grid::EDGE_MM;
use crate::write::plan::Plan;

/// Computes the forecast from a machine and what the control adds, over the ranges that are judged.
pub fn forecast(
    machine: Machine<'_>,
    plan: &Plan,
    control: &Field,
    ranges: &[JudgedRange],
) -> Forecast {
    let model = machine.as_measured;
    let sigma = Sigma::with_freedom(model.remarks.degrees_of_freedom);
    let largest = model.remarks.largest.as_ref();
    let judged = share::stated(ranges);
    let comparable = machine.was_under_tables().then(|| control.straightened());
    let mut terms = Vec::new();
    for (term, measured) in model.measured() {
        let left = |control| residuals(machine, control, term, judged[term.along]);
        let figures = left(control);
        let (u_um, after_um) = (measured.u_um(), largest_um(&figures));
        let comparable_um = comparable.as_ref().map_or(after_um, |of| largest_um(&left(of)));
        terms.push(TermForecast {
            term,
            change: Change {
                before_um: measured.largest_within_um(judged[term.along]),
                after_um,
                comparable_um,
                u_um,
                expanded_um: u_um.map(|_| {
                    expanded_um(&figures, &sigma, largest.map(|largest| largest.single.terms[term]))
                }),
                at_most_um: None,
            },
            figures,
            compensated: plan.tables.iter().any(|t| t.term == term),
            one_way: one_way(&measured.measured),
        });
    }
    let mut diagonals = along_diagonals(machine, control, &judged, &sigma);
    if let Some(lines) = &comparable {
        let compared = along_diagonals(machine, lines, &judged, &sigma);
        for (own, compared) in diagonals.iter_mut().zip(compared) {
            own.change.comparable_um = compared.change.after_um;
        }
    }
    let not_determined = model.remarks.not_determined.iter().map(|(term, _)| *term);
    let not_determined = not_determined.filter(|term| model.terms[*term].is_none());
    let forecast = Forecast {
        basis: Basis::Forecast,
        sigma,
        ranges: ranges.to_vec(),
        silence: model.remarks.silence.clone(),
        largest: largest.cloned(),
        measured: model.remarks.measured.clone(),
        doubtful: model.remarks.doubtful.clone().unwrap_or_default(),
        diagonals,
        terms,
        unmeasured: PerAxis::from_fn(|axis| unmeasured(model, plan, axis)),
        not_determined: not_determined.collect(),
        without_reversal_um: model.remarks.hidden_reversal_um,
    };
    forecast.bounded(Basis::Forecast)
}

const fn one_way(measured: &TermCurves) -> Option<Option<Direction>> {
    match measured {
        TermCurves::BothWays { .. } => None,
        TermCurves::OneWay(direction, _) => Some(Some(*direction)),
        TermCurves::Undirected(_) => Some(None),
    }
}

/// What is left of a term around each of its measured positions, |deviation + correction|.
fn residuals(
    machine: Machine<'_>,
    control: &Field,
    term: ErrorTerm,
    judged: Option<Range>,
) -> Vec<Magnitude> {
    let mut left = Vec::new();
    for direction in Direction::BOTH {
        let known = machine.as_measured.terms[term].as_ref();
        let Some((known, (measured, curve))) = known.zip(machine.curves(term, direction)) else {
            continue;
        };
        let cells = cells(known, direction, within(measured.measured_range(), judged));
        for response in control.ways(term, direction) {
            left.extend(cells.iter().map(|cell| (*cell, largest_in(curve, response, *cell))));
        }
    }
    let figure = |(cell, um): (Cell, Vec<f64>)| Magnitude {
        um: um.into_iter().fold(0.0, larger),
        u_um: cell.u_um,
    };
    grouped(left).into_iter().map(figure).collect()
}

/// The stretch of a curve that a measured position stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    /// In which it was measured.
    way: Option<Direction>,
    from: Millimetres,
    to: Millimetres,
    u_um: f64,
}

/// Half-way to the neighbouring positions on either side; the whole range where no uncertainty is
/// stated.
fn cells(known: &MeasuredTerm, direction: Direction, (from, to): Range) -> Vec<Cell> {
    let own = |way: Option<Direction>| way.is_none_or(|way| way == direction);
    let points: Vec<_> = known.uncertainty.iter().filter(|p| own(p.direction)).collect();
    if points.is_empty() {
        return vec![Cell { way: None, from, to, u_um: 0.0 }];
    }
    let middle = |index: usize| {
        let (a, b) = (points[index].at, points[index + 1].at);
        Millimetres::new(f64::midpoint(a.mm(), b.mm()))
    };
    let cell = |(index, point): (usize, &&PointUncertainty)| {
        let low = if index == 0 { from } else { middle(index - 1) };
        let high = if index + 1 == points.len() { to } else { middle(index) };
        let (low, high) = within((low, high), Some((from, to)));
        let (way, u_um) = (point.direction, point.u_um);
        (low < high).then_some(Cell { way, from: low, to: high, u_um })
    };
    points.iter().enumerate().filter_map(cell).collect()
}

/// Largest |deviation + correction| on a stretch, µm.
fn largest_in(curve: &ErrorCurve, response: &Response, cell: Cell) -> f64 {
    let mut largest = 0.0;
    for [(from, start), (to, end)] in response.stretches(cell.from, cell.to) {
        let (low, high) = curve.extremes_against_line(from, to, start.um(), end.um());
        largest = larger(largest, larger(high, -low));
    }
    for end in [cell.from, cell.to] {
        for beside in [-AT_THE_END_MM, AT_THE_END_MM] {
            let correction = response.correction(end + Millimetres::new(beside));
            largest = larger(largest, (curve.at(end) + correction).um().abs());
        }
    }
    largest
}

/// A correction that jumps at an end of the measured range (a picometre either way) counts with
/// both its values there.
const AT_THE_END_MM: f64 = 1e-9;

fn unmeasured(model: &ErrorModel, plan: &Plan, axis: Axis) -> Vec<Range> {
    let (Some(grid), Some((low, high))) = (plan.grids[axis], model.ranges[axis]) else {
        return Vec::new();
    };
    let (first, last) = grid.range();
    let ends = [(first, low), (high, last)].into_iter();
    ends.filter(|(from, to)| to.mm() - from.mm() > EDGE_MM).collect()
}

// What the tables leave along the four body diagonals of the measured box.
//
// The deviation along the beam is a sum over the nine terms. Between two places where a curve or
// a correction bends, it is a cubic of the way, so its extremes are found without sampling.

/// The measured box; none where an axis was not measured.
fn measured_box(model: &ErrorModel, judged: &PerAxis<Option<Range>>) -> Option<Volume> {
    let ends = PerAxis::from_fn(|axis| Some(within(model.ranges[axis]?, judged[axis]))).all()?;
    let size = PerAxis::from_fn(|axis| ends[axis].1 - ends[axis].0);
    Some(Volume { start: PerAxis::from_fn(|axis| ends[axis].0), size, steps: 1, order: Axis::ALL })
}

/// How far inside its edge an axis stands at t of a diagonal, or at which t it stands so far inside, in parts of each.
fn turned(diagonal: Diagonal, axis: Axis, part: f64) -> f64 {
    if diagonal.sign(axis) > 0.0 { part } else { 1.0 - part }
}

/// How far along a diagonal an axis stands somewhere, 0 to 1 on its forward run.
fn travelled(measured_box: &Volume, diagonal: Diagonal, axis: Axis, mm: f64) -> f64 {
    let (low, size) = (measured_box.start[axis], measured_box.size[axis]);
    turned(diagonal, axis, (mm - low.mm()) / size.mm())
}

/// Where an axis stands at t.
fn position(measured_box: &Volume, diagonal: Diagonal, axis: Axis, t: f64) -> Millimetres {
    let inside = turned(diagonal, axis, t) * measured_box.size[axis].mm();
    measured_box.start[axis] + Millimetres::new(inside)
}

/// The four diagonals; none where a term or a direction of it was not measured.
fn along_diagonals(
    machine: Machine<'_>,
    control: &Field,
    judged: &PerAxis<Option<Range>>,
    sigma: &Sigma,
) -> Vec<DiagonalForecast> {
    let model = machine.as_measured;
    let Some(measured_box) = measured_box(model, judged) else {
        return Vec::new();
    };
    let one_way = |(_, m): (ErrorTerm, &MeasuredTerm)| matches!(m.measured, TermCurves::OneWay(..));
    if model.measured().count() < ErrorTerm::ALL.len() || model.measured().any(one_way) {
        // A diagonal travels some axis in the direction that was not measured.
        return Vec::new();
    }
    let travels = travels(machine, control, &measured_box);
    let of_diagonal = |diagonal: Diagonal| {
        let [forward, reverse] =
            Pass::BOTH.map(|pass| Walk::new(&travels, &measured_box, diagonal, pass));
        let mut met = forward.extremes();
        if reverse.parts != forward.parts {
            met.extend(reverse.extremes());
        }
        let u_um = uncertainties(model, &measured_box, diagonal);
        let scale_um = model.laser_um_per_m * measured_box.diagonal_mm() / 1000.0;
        let sizes = [0, 1].map(|of| {
            let (low, high) = ends(met.iter().map(|both| both[of]));
            high - low
        });
        let largest_um =
            model.remarks.largest.as_ref().map(|largest| largest.single.diagonals[diagonal]);
        let doubtful_um =
            model.remarks.doubtful.as_ref().map_or(0.0, |sizes| sizes.diagonals[diagonal]);
        DiagonalForecast::new(diagonal, sizes, sigma, &u_um, scale_um, largest_um, doubtful_um)
    };
    Diagonal::ALL.into_iter().map(of_diagonal).collect()
}

/// One term while its axis travels one way: its curves, its correction and where they bend.
#[derive(PartialEq)]
struct Travel<'a> {
    measured: &'a ErrorCurve,
    /// Without tables; absent where none was active while measuring.
    uncompensated: Option<&'a ErrorCurve>,
    response: &'a Response,
    /// Places inside the measured box where a curve or the correction bends or jumps, mm.
    bends: Vec<Vec<f64>>,
}

/// Every measured term both ways; the four diagonals share them.
fn travels<'a>(
    machine: Machine<'a>,
    control: &'a Field,
    measured_box: &Volume,
) -> Vec<(ErrorTerm, Direction, Travel<'a>)> {
    let mut travels = Vec::new();
    for (term, _) in machine.as_measured.measured() {
        for direction in Direction::BOTH {
            let Some((measured, uncompensated)) = machine.curves(term, direction) else {
                continue;
            };
            let Some(response) = control.ways(term, direction).next() else {
                continue;
            };
            let uncompensated = (!std::ptr::eq(measured, uncompensated)).then_some(uncompensated);
            let low = measured_box.start[term.along];
            let high = low + measured_box.size[term.along];
            let knots = |curve: &ErrorCurve| curve.knots().iter().map(|x| x.mm()).collect();
            let of_curves = [Some(measured), uncompensated].into_iter().flatten().map(knots);
            let bends = of_curves.chain([response.breaks(low, high)]).collect();
            travels.push((term, direction, Travel { measured, uncompensated, response, bends }));
        }
    }
    travels
}

/// Standard uncertainty of the deviation along the beam, µm, wherever an axis stands at one of its
/// measured positions: three terms per axis, weighted with the direction cosine. A value by itself
/// counts, since max − min is a difference and the reference drops out. A term of which nothing is
/// stated counts as 0; empty where nothing is stated at all.
fn uncertainties(model: &ErrorModel, measured_box: &Volume, diagonal: Diagonal) -> Vec<f64> {
    if model.measured().all(|(_, m)| m.uncertainty.is_empty()) {
        return Vec::new();
    }
    let places = model.measured().flat_map(|(term, measured)| {
        let points = measured.uncertainty.iter();
        points.map(move |p| travelled(measured_box, diagonal, term.along, p.at.mm()))
    });
    let on_it = |t: &f64| (-SAME_PART..=1.0 + SAME_PART).contains(t);
    let mut places: Vec<f64> = places.filter(on_it).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < SAME_PART);
    let u_um = |t: &f64| {
        let variances = model.measured().map(|(term, measured)| {
            let at = position(measured_box, diagonal, term.along, *t);
            (measured_box.cosine(term.of) * near_um(measured, at)).squared()
        });
        variances.sum::<f64>().sqrt()
    };
    places.iter().map(u_um).collect()
}

/// Places on a diagonal that differ by less are one, in parts of its length.
const SAME_PART: f64 = 1e-9;

/// The larger of the uncertainties on either side of a place, µm.
fn near_um(measured: &MeasuredTerm, at: Millimetres) -> f64 {
    let distance = |point: &&PointUncertainty| (point.at - at).mm();
    let points = || measured.uncertainty.iter();
    let below = points().filter(|p| distance(p) <= AT_PLACE_MM);
    let above = points().filter(|p| distance(p) >= -AT_PLACE_MM);
    let nearest_below = below.map(|p| distance(&p)).reduce(larger);
    let nearest_above = above.map(|p| -distance(&p)).reduce(larger);
    let is_near = |p: &&PointUncertainty| {
        let near =
            |edge: Option<f64>, own: f64| edge.is_some_and(|e| (own - e).abs() < AT_PLACE_MM);
        near(nearest_below, distance(p)) || near(nearest_above, -distance(p))
    };
    points().filter(is_near).map(|p| p.value_um).fold(0.0, larger)
}

/// One run along a diagonal, t from 0 to 1.
struct Walk<'a> {
    parts: Vec<(ErrorTerm, &'a Travel<'a>)>,
    measured_box: &'a Volume,
    diagonal: Diagonal,
    /// Cosines of the beam to the axes.
    beam: PerAxis<f64>,
}

impl<'a> Walk<'a> {
    fn new(
        travels: &'a [(ErrorTerm, Direction, Travel<'a>)],
        measured_box: &'a Volume,
        diagonal: Diagonal,
        pass: Pass,
    ) -> Walk<'a> {
        let is_on_it = |(term, direction, _): &&(ErrorTerm, Direction, Travel<'_>)| {
            diagonal.travelled(term.along, pass) == *direction
        };
        let parts = travels.iter().filter(is_on_it).map(|(term, _, travel)| (*term, travel));
        let beam = measured_box.laser(diagonal);
        Walk { parts: parts.collect(), measured_box, diagonal, beam }
    }

    /// Places t where a curve or a correction bends or jumps; the terms of an axis mostly share them.
    fn breaks(&self) -> Vec<f64> {
        let mut breaks = vec![0.0, 1.0];
        for axis in Axis::ALL {
            let own = self.parts.iter().filter(|(term, _)| term.along == axis);
            let mut bends: Vec<&[f64]> = Vec::new();
            for places in own.flat_map(|(_, travel)| &travel.bends) {
                if !bends.contains(&places.as_slice()) {
                    bends.push(places);
                }
            }
            let places = bends.into_iter().flatten();
            breaks.extend(places.map(|mm| travelled(self.measured_box, self.diagonal, axis, *mm)));
        }
        breaks.retain(|t| (0.0..=1.0).contains(t));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
        breaks
    }

    /// Deviation along the beam at t, as measured and with the tables, µm.
    fn deviation(&self, t: f64) -> [f64; 2] {
        let mut before = 0.0;
        let mut after = 0.0;
        let places = PerAxis::from_fn(|axis| position(self.measured_box, self.diagonal, axis, t));
        for (term, travel) in &self.parts {
            let (at, cosine) = (places[term.along], self.beam[term.of]);
            let measured = travel.measured.at(at);
            let bare = travel.uncompensated.map_or(measured, |curve| curve.at(at));
            before += cosine * measured.um();
            after += cosine * (bare + travel.response.correction(at)).um();
        }
        [before, after]
    }

    /// Both sums where they may be extreme: between two breaks they are cubics in t, which four places determine.
    fn extremes(&self) -> Vec<[f64; 2]> {
        const PLACES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
        let breaks = self.breaks();
        let between = breaks.windows(2).flat_map(|pair| {
            let values = PLACES.map(|s| self.deviation(pair[0] + s * (pair[1] - pair[0])));
            let [before, after] = [0, 1].map(|of| cubic_extremes(values.map(|both| both[of])));
            before.into_iter().zip(after).map(|(before, after)| [before, after])
        });
        // A correction can jump just at a corner.
        between.chain([0.0, 1.0].map(|corner| self.deviation(corner))).collect()
    }
}

/// The cubic through values at 1/8, 3/8, 5/8, 7/8: at both ends of 0…1 and where it is extreme inside.
fn cubic_extremes(values: [f64; 4]) -> [f64; 4] {
    // Newton's forward differences with u = (s − 1/8) / (1/4), so s = 0 and 1 are u = −½ and 3½.
    const FIRST: f64 = -0.5;
    const LAST: f64 = 3.5;
    let d1 = values[1] - values[0];
    let d2 = values[2] - 2.0 * values[1] + values[0];
    let d3 = values[3] - 3.0 * values[2] + 3.0 * values[1] - values[0];
    // derivative: d3/2·u² + (d2 − d3)·u + (d1 − d2/2 + d3/3)
    let (a, b, c) = (d3 / 2.0, d2 - d3, d1 - d2 / 2.0 + d3 / 3.0);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    let inside = |u: f64| if u > FIRST && u < LAST { u } else { FIRST };
    [FIRST, LAST, inside(q / a), inside(c / q)].map(|u| {
        values[0] + u * d1 + u * (u - 1.0) / 2.0 * d2 + u * (u - 1.0) * (u - 2.0) / 6.0 * d3
    })
}
