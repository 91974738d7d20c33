//! One number for a volume: the definitions that are in use, side by side.
//!
//! ```text
//!   nine curves ─→ largest and smallest value ─→ ELv · ELSv · existing · proposed (papers 000, 001)
//!   error vectors at the nodes ─→ ranges · box · VA · largest from one place
//!   places and error vectors   ─→ length error (does not depend on how the axes were aligned)
//! ```
//! Which one to quote when, and why they differ: docs/volumetric.md §4.

use crate::quantity::axis::{Axis, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, PerDiagonal};
use crate::quantity::units::Millimetres;
use crate::volume::space::diameter::diameter;
use crate::volume::volume_model::{Component, ErrorMap, VolumeModel};

/// Largest and smallest value of each of the nine deviations, µm (or any one unit of length).
pub type Extremes = PerTerm<Option<(f64, f64)>>;

/// The definitions that look at the nine deviations one by one. `None` where one that the
/// definition needs was not measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByComponent {
    /// ELv = √(ELx² + ELy² + ELz²), EL = range of the axis' own deviation (paper 001, eq. 1 and 2).
    pub elv: Option<f64>,
    /// ELSv: the same with the sum of the three ranges in each direction (range form).
    pub elsv: Option<f64>,
    /// √Σ max² + √Σ min² over the nine (paper 000 §I).
    pub existing: Option<f64>,
    /// √Σ (Σ max)² + √Σ (Σ min)² over the three directions (paper 000 §II).
    pub proposed: Option<f64>,
}

impl ByComponent {
    /// From the extremes of the nine deviations.
    ///
    /// limits  `max` and `min` are taken as they are: one with the sign of the other counts against
    ///         its own sense, and the first two figures move with the zero of the curves
    pub fn of(extremes: &Extremes) -> ByComponent {
        let range = |(low, high): (f64, f64)| high - low;
        let own = |axis| extremes[ErrorTerm::positioning(axis)];
        let all: Option<Vec<(f64, f64)>> = extremes.iter().map(|(_, pair)| *pair).collect();
        let summed = |of: Axis, value: fn((f64, f64)) -> f64| -> Option<f64> {
            let pairs = Axis::ALL.map(|along| extremes[ErrorTerm { of, along }]);
            pairs.into_iter().map(|pair| pair.map(value)).sum()
        };
        let by_direction =
            |value: fn((f64, f64)) -> f64| root_of_squares(Axis::ALL.map(|of| summed(of, value)));
        let nine = |value: fn((f64, f64)) -> f64| {
            let all = all.as_ref()?;
            root_of_squares(all.iter().map(|pair| Some(value(*pair))))
        };
        let low: fn((f64, f64)) -> f64 = |pair| pair.0;
        let high: fn((f64, f64)) -> f64 = |pair| pair.1;
        ByComponent {
            elv: root_of_squares(Axis::ALL.map(|axis| own(axis).map(range))),
            elsv: by_direction(range),
            existing: nine(high).zip(nine(low)).map(|(a, b)| a + b),
            proposed: by_direction(high).zip(by_direction(low)).map(|(a, b)| a + b),
        }
    }
}

fn root_of_squares(values: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    let squares = values.into_iter().map(|value| value.map(|v| v * v));
    squares.sum::<Option<f64>>().map(f64::sqrt)
}

/// The largest difference of two error vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestDifference {
    /// Its length: the volumetric accuracy VA of paper 002 §4.1, µm.
    pub um: f64,
    /// The two places, mm.
    pub places_mm: [PerAxis<f64>; 2],
    /// e(first) − e(second), µm.
    pub difference_um: PerAxis<f64>,
}

/// All figures of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Definitions {
    /// Nodes of each axis.
    pub grid: PerAxis<usize>,
    /// From the nine deviations, squareness in them.
    pub by_component: ByComponent,
    /// Paper 000's proposed definition with the whole error vector in place of the nine:
    /// |max e| + |min e|, each taken direction by direction, µm. It moves with the zero of e. As in
    /// paper 002 the arms of squareness, like those of angles, count from the offsets; of a
    /// term that a table corrects no squareness is left apart, and it is zero at the reference.
    pub proposed_um: f64,
    /// Volumetric accuracy.
    pub va: LargestDifference,
    /// Range of the error in X, Y and Z over the nodes, µm (ISO 230-1).
    pub ranges_um: PerAxis<f64>,
    /// √ of the sum of the squared ranges, µm.
    pub box_um: f64,
    /// Largest |e − e(place)|, µm.
    pub from_origin_um: f64,
    /// Where that place is: the origin of the levers, mm.
    pub origin_mm: PerAxis<f64>,
    /// Largest error of a length between two nodes.
    pub length: LengthError,
    /// Range along each body diagonal, µm (ISO 230-6, from the model).
    pub diagonals_um: PerDiagonal<f64>,
}

/// All figures of a model at the nodes of its map.
pub fn definitions(model: &VolumeModel, map: &ErrorMap) -> Definitions {
    let origin_mm = model.lever_origin();
    let at_origin = model.error_at(origin_mm);
    let (mut low, mut high) =
        (PerAxis::from_fn(|_| f64::INFINITY), PerAxis::from_fn(|_| f64::NEG_INFINITY));
    let mut from_origin_um = 0.0_f64;
    for (_, error) in map.points() {
        low = PerAxis::from_fn(|axis| low[axis].min(error[axis]));
        high = PerAxis::from_fn(|axis| high[axis].max(error[axis]));
        from_origin_um = from_origin_um.max(error.minus(at_origin).length());
    }
    let ranges_um = high.minus(low);
    let squareness = |component| matches!(component, Component::Squareness(_));
    let squareness_um = model.part_at(origin_mm, squareness);
    Definitions {
        grid: map.counts(),
        by_component: ByComponent::of(&extremes(model)),
        proposed_um: high.minus(squareness_um).length() + low.minus(squareness_um).length(),
        va: largest_difference(map),
        ranges_um,
        box_um: ranges_um.length(),
        from_origin_um,
        origin_mm,
        length: length_error(map),
        diagonals_um: diagonal_ranges(model),
    }
}

/// Largest and smallest value of each deviation over the judged range, squareness in it, zero at
/// the reference (between nodes too: a curve is known there).
fn extremes(model: &VolumeModel) -> Extremes {
    PerTerm::from_fn(|term: ErrorTerm| {
        let (low, high) = model.range(term.along);
        let (from, to) = (Millimetres::new(low), Millimetres::new(high));
        let curve = model.against_reference(term)?;
        Some(curve.extremes_against_line(from, to, 0.0, 0.0))
    })
}

/// The volumetric accuracy of a map: max |e(p) − e(q)| over all pairs of nodes, exact.
pub(crate) fn largest_difference(map: &ErrorMap) -> LargestDifference {
    let found = diameter(map.vectors());
    let [p, q] = found.nodes;
    LargestDifference {
        um: found.um,
        places_mm: found.nodes.map(|node| map.place(node)),
        difference_um: map.error(p).minus(map.error(q)),
    }
}

/// Range of the deviation along each body diagonal of the assessed box, µm: max − min of e · u.
///
/// between two places where a curve bends, e · u of straight curves is a parabola of the way
/// travelled (angle × lever), so its extreme is found from three places; of other curves it is
/// close.
pub(crate) fn diagonal_ranges(model: &VolumeModel) -> PerDiagonal<f64> {
    let bends = bends(model);
    PerDiagonal::from_fn(|diagonal| {
        let along = |t: f64| along(model, diagonal, t);
        let turned = |(axis, t): &(Axis, f64)| match diagonal.sign(*axis) > 0.0 {
            true => *t,
            false => 1.0 - t,
        };
        let mut bends: Vec<f64> = bends.iter().map(turned).collect();
        bends.sort_by(f64::total_cmp);
        let mut ends = (along(0.0), along(0.0));
        for pair in bends.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (first, middle, last) = (along(a), along(f64::midpoint(a, b)), along(b));
            for value in [first, last].into_iter().chain(vertex(first, middle, last)) {
                ends = (ends.0.min(value), ends.1.max(value));
            }
        }
        ends.1 - ends.0
    })
}

/// Extreme of the parabola through three values at 0, ½ and 1, where it lies between them.
fn vertex(first: f64, middle: f64, last: f64) -> Option<f64> {
    let bent = 2.0 * (first - 2.0 * middle + last);
    let slope = last - first - bent;
    let place = -slope / (2.0 * bent);
    (place > 0.0 && place < 1.0).then_some(first + place * (slope + bent * place))
}

/// Parts of the travel (0 … 1) where a curve of an axis bends.
fn bends(model: &VolumeModel) -> Vec<(Axis, f64)> {
    let nodes = model.own_nodes();
    let of_axis = |axis: Axis| {
        let (low, high) = model.range(axis);
        let inside = nodes[axis].iter().filter(move |_| high > low);
        inside.map(move |node| (axis, (node - low) / (high - low)))
    };
    Axis::ALL.into_iter().flat_map(of_axis).collect()
}

/// e · u at the part t of a diagonal, µm.
fn along(model: &VolumeModel, diagonal: Diagonal, t: f64) -> f64 {
    let size = PerAxis::from_fn(|axis| {
        let (low, high) = model.range(axis);
        high - low
    });
    let length = size.length();
    if length <= 0.0 {
        return 0.0;
    }
    let way = PerAxis::from_fn(|axis| diagonal.sign(axis) * size[axis]);
    let place = PerAxis::from_fn(|axis| {
        let travelled = if diagonal.sign(axis) > 0.0 { t } else { 1.0 - t };
        model.range(axis).0 + travelled * size[axis]
    });
    model.error_at(place).dot(way) / length
}

/// Nodes of which every pair is compared: more of them are thinned out.
const MOST_NODES: usize = 10_000;
/// Nodes an axis keeps when a map is thinned out.
const KEPT: usize = 21;
const UM_PER_MM: f64 = 1000.0;

/// Largest | |actual distance| − |nominal distance| | of two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthError {
    /// The largest that was found, µm.
    pub um: f64,
    /// Whether every pair of nodes was compared; else this is a lower bound, and VA an upper one.
    pub exact: bool,
    /// The two places, mm.
    pub places_mm: [PerAxis<f64>; 2],
}

/// The largest error of the distance of two nodes, µm.
///
/// what    | |p − q + e(p) − e(q)| − |p − q| |, all nodes p, q
/// limits  exact up to 10 000 nodes; beyond, at most 21 nodes of each axis are compared, the ends
///         among them, and the figure is a lower bound
pub(crate) fn length_error(map: &ErrorMap) -> LengthError {
    let exact = map.count() <= MOST_NODES;
    let counts = map.counts();
    let kept = PerAxis::from_fn(|axis| if exact { counts[axis] } else { counts[axis].min(KEPT) });
    let number = |index: usize, kept: usize, count: usize| match kept {
        0 | 1 => 0,
        _ => index * (count - 1) / (kept - 1),
    };
    let mut points = Vec::with_capacity(kept.x * kept.y * kept.z);
    for x in 0..kept.x {
        for y in 0..kept.y {
            for z in 0..kept.z {
                points.push(map.point(PerAxis {
                    x: number(x, kept.x, counts.x),
                    y: number(y, kept.y, counts.y),
                    z: number(z, kept.z, counts.z),
                }));
            }
        }
    }
    let (um, pair) = largest(&points);
    LengthError {
        um,
        exact,
        places_mm: pair.map(|index| points.get(index).map_or(PerAxis::default(), |p| p.0)),
    }
}

fn largest(points: &[(PerAxis<f64>, PerAxis<f64>)]) -> (f64, [usize; 2]) {
    let mut found = (0.0, [0, 0]);
    for (index, (place, error)) in points.iter().enumerate() {
        for (further, (other, other_error)) in points[..index].iter().enumerate() {
            let nominal = place.minus(*other).times(UM_PER_MM);
            let shift = error.minus(*other_error);
            // |n + s| − |n| without the loss of digits of a difference of two large numbers.
            let sum = nominal.plus(shift).length() + nominal.length();
            let change = shift.dot(nominal.times(2.0).plus(shift)) / sum;
            if change.abs() > found.0 {
                found = (change.abs(), [further, index]);
            }
        }
    }
    found
}
