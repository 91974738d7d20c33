//! One number for a volume: the definitions that are in use, side by side.
//!
//! ```text
//!   nine curves ─→ largest and smallest value ─→ ELv · ELSv · existing · proposed (papers 000, 001)
//!   error vectors at the nodes ─→ ranges · box · VA · largest from one place
//!   places and error vectors   ─→ length error (does not depend on how the axes were aligned)
//! ```
//! Which one to quote when, and why they differ: docs/volume.md §4.

use crate::machine::separation::curves::range;
use crate::quantity::{
    Axis, ErrorCurve, ErrorTerm, Millimetres, PerAxis, PerDiagonal, PerTerm, SAME_PLACE_MM, Xyz,
};
use crate::volume::space::boxes::Boxes;
use crate::volume::space::diameter::diameter;
use crate::volume::volume_model::{Component, ErrorMap, Nodes, VolumeModel};
use serde::Serialize;

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
        let summed = |of: Axis, value: fn((f64, f64)) -> f64| -> Option<f64> {
            let pairs = Axis::ALL.map(|along| extremes[ErrorTerm { of, along }]);
            pairs.into_iter().map(|pair| pair.map(value)).sum()
        };
        let by_direction =
            |value: fn((f64, f64)) -> f64| root_of_squares(Axis::ALL.map(|of| summed(of, value)));
        let nine = |value: fn((f64, f64)) -> f64| {
            root_of_squares(extremes.iter().map(|(_, pair)| pair.map(value)))
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
    values.into_iter().map(|value| value.map(|v| v * v)).sum::<Option<f64>>().map(f64::sqrt)
}

/// All figures of a volume. `None` where an error that the figure needs was not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Definitions {
    /// [`ByComponent::elv`] of the nine deviations, squareness in them, µm.
    pub elv_um: Option<f64>,
    /// [`ByComponent::elsv`], µm.
    pub elsv_um: Option<f64>,
    /// [`ByComponent::existing`], µm.
    pub existing_um: Option<f64>,
    /// Paper 000's proposed definition with the whole error vector in place of the nine:
    /// |max e| + |min e|, each taken direction by direction, µm. It moves with the zero of e. As in
    /// paper 002 the arms of squareness, like those of angles, count from the offsets; of a
    /// term that a table corrects no squareness is left apart, and it is zero at the reference.
    pub proposed_um: f64,
    /// [`ByComponent::proposed`], µm.
    pub proposed_of_nine_um: Option<f64>,
    /// Length of the largest difference of two error vectors: the volumetric accuracy VA of paper 002 §4.1, µm.
    pub va_um: f64,
    /// Whether it holds for every place of the volume; else for the nodes.
    pub va_exact: bool,
    /// The two places, mm.
    pub va_pair_mm: [Xyz<f64>; 2],
    /// e(first) − e(second), µm.
    pub va_difference_um: Xyz<f64>,
    /// Largest error of a length between two nodes: | |actual distance| − |nominal distance| |, µm.
    pub length_um: f64,
    /// No such error is larger, µm.
    pub length_bound_um: f64,
    /// The two places, mm.
    pub length_pair_mm: [Xyz<f64>; 2],
    /// Whether its search came to its end.
    pub length_exact: bool,
    /// Range of the error in X, Y and Z over the nodes, µm (ISO 230-1); `None` where nothing that was measured shows.
    pub ranges_um: Xyz<Option<f64>>,
    /// √ of the sum of the squared ranges, µm.
    pub box_um: f64,
    /// Largest |e − e(reference)| over the nodes, µm.
    pub max_from_reference_um: f64,
    /// No such difference is larger, µm.
    pub max_from_reference_bound_um: f64,
    /// Where the levers count from, mm.
    pub reference_mm: Xyz<f64>,
    /// Range along each body diagonal, µm (ISO 230-6, from the model).
    pub diagonals_um: PerDiagonal<f64>,
}

/// Steps of a search at most: about a second.
const STEPS: usize = 200_000;

/// All figures of a model at the nodes of its map.
///
/// limits  length error and largest error from a place are searched for in [`STEPS`] steps each: exact where the search
///         comes to its end, else with a bound
pub fn definitions(model: &VolumeModel, map: &ErrorMap) -> Definitions {
    let origin_mm = model.lever_origin();
    let boxes = Boxes::of(map.vectors());
    let [x, y, z] = boxes.ranges();
    let low = PerAxis { x: x.0, y: y.0, z: z.0 };
    let high = PerAxis { x: x.1, y: y.1, z: z.1 };
    let PerAxis { x, y, z } = model.error_at(origin_mm);
    let widest = diameter(map.vectors());
    let length = boxes.length_error(&widest, STEPS);
    let [i, j, k, other @ ..] = length.at;
    let mut length_mm = [[i, j, k], other].map(|node| map.place(node));
    length_mm
        .sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)));
    let ranges = high.minus(low);
    let squareness = |component| matches!(component, Component::Squareness(_));
    let squareness_um = model.part_at(origin_mm, squareness);
    let nine = ByComponent::of(&extremes(model));
    let [p, q] = widest.nodes.map(|node| map.error(node));
    let from_reference = boxes.furthest_from([x, y, z], STEPS);
    Definitions {
        elv_um: nine.elv,
        elsv_um: nine.elsv,
        existing_um: nine.existing,
        proposed_um: high.minus(squareness_um).length() + low.minus(squareness_um).length(),
        proposed_of_nine_um: nine.proposed,
        va_um: widest.um,
        va_exact: holds_everywhere(model, map.nodes()),
        va_pair_mm: widest.nodes.map(|node| Xyz(map.place(node))),
        va_difference_um: Xyz(p.minus(q)),
        length_um: length.um,
        length_bound_um: length.bound_um,
        length_pair_mm: length_mm.map(Xyz),
        length_exact: length.is_exact(),
        ranges_um: Xyz(PerAxis::from_fn(|axis| model.shows(axis).then_some(ranges[axis]))),
        box_um: ranges.length(),
        max_from_reference_um: from_reference.um,
        max_from_reference_bound_um: from_reference.bound_um,
        reference_mm: Xyz(origin_mm),
        diagonals_um: diagonal_ranges(model),
    }
}

/// Whether no place of the volume differs by more than the nodes do.
///
/// why    where each curve runs straight between neighbouring nodes, the error is a straight line
///        in each coordinate and |e(p) − e(q)| convex in it, so its largest value lies at nodes
fn holds_everywhere(model: &VolumeModel, nodes: &Nodes) -> bool {
    let own = model.own_nodes();
    Axis::ALL.into_iter().all(|axis| {
        let is_node = |place: f64| {
            let next = nodes[axis].partition_point(|node| *node < place - SAME_PLACE_MM);
            nodes[axis].get(next).is_some_and(|n| *n <= place + SAME_PLACE_MM)
        };
        model.all_along(axis).all(ErrorCurve::is_straight) && own[axis].iter().copied().all(is_node)
    })
}

/// Largest and smallest value of each deviation over the judged range, squareness in it, zero at
/// the reference (between nodes too: a curve is known there).
fn extremes(model: &VolumeModel) -> Extremes {
    PerTerm::from_fn(|term: ErrorTerm| {
        let (low, high) = model.range(term.along);
        let (from, to) = (Millimetres::new(low), Millimetres::new(high));
        Some(model.against_reference(term)?.extremes_against_line(from, to, 0.0, 0.0))
    })
}

/// Range of the deviation along each body diagonal of the assessed box, µm: max − min of e · u.
///
/// between two places where a curve bends, e · u of straight curves is a parabola of the way
/// travelled (angle × lever), so its extreme is found from three places; of other curves it is
/// close.
fn diagonal_ranges(model: &VolumeModel) -> PerDiagonal<f64> {
    let low = PerAxis::from_fn(|axis| model.range(axis).0);
    let size = PerAxis::from_fn(|axis| model.range(axis).1).minus(low);
    let nodes = model.own_nodes();
    PerDiagonal::from_fn(|diagonal| {
        let way = PerAxis::from_fn(|axis| diagonal.sign(axis) * size[axis]);
        let travelled = |axis, t: f64| if way[axis] < 0.0 { 1.0 - t } else { t };
        let along = |t: f64| {
            let place = PerAxis::from_fn(|axis| low[axis] + travelled(axis, t) * size[axis]);
            model.error_at(place).dot(way) / size.length()
        };
        let bends = Axis::ALL.into_iter().filter(|axis| size[*axis] > 0.0).flat_map(|axis| {
            let part = move |node: &f64| (node - low[axis]) / size[axis];
            nodes[axis].iter().map(move |node| travelled(axis, part(node)))
        });
        let mut bends: Vec<f64> = bends.collect();
        bends.sort_by(f64::total_cmp);
        let extremes = bends.windows(2).flat_map(|pair| {
            let (a, b) = (pair[0], pair[1]);
            let (first, middle, last) = (along(a), along(f64::midpoint(a, b)), along(b));
            let bent = 2.0 * (first - 2.0 * middle + last);
            let slope = last - first - bent;
            let turn = -slope / (2.0 * bent);
            let vertex = (turn > 0.0 && turn < 1.0).then_some(first + turn * (slope + bent * turn));
            [first, last].into_iter().chain(vertex)
        });
        range(extremes)
    })
}
