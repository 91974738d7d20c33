//! What the errors do in the volume: figures, contributions, sub-volumes, distribution; as the
//! machine is and as the tables leave it.
//!
//! ```text
//!   model ─→ VolumeModel ─→ Assessment                                    as it is
//!               └─ + what the control adds (emulated from bytes) ─→ Assessment   with the tables
//! ```

use crate::axis::{Direction, ErrorTerm, PerAxis, PerTerm};
use crate::curve::{ErrorCurve, Interpolation};
use crate::definitions::{Definitions, LargestDifference, definitions, largest_difference};
use crate::emulate::{CannotEmulate, Emulator, Response};
use crate::forecast::axis_pairs;
use crate::model::{ErrorModel, Measured};
use crate::plan::Plan;
use crate::units::{Correction, Deviation, Millimetres};
use crate::volume_model::{Component, Nodes, VolumeModel};

/// Which nodes to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridChoice {
    /// Every place where a curve bends, and the ends.
    OwnNodes,
    /// So many of each axis, equally spaced.
    Equal(PerAxis<usize>),
}

/// What is asked of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Nodes.
    pub grid: GridChoice,
    /// Size of a sub-volume, mm.
    pub window_mm: Option<PerAxis<f64>>,
    /// Width of the bins of the histogram, µm.
    pub histogram_um: Option<f64>,
}

/// What one of the 21 errors does to the volumetric accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Contribution {
    /// Which error.
    pub component: Component,
    /// Its part at the worst pair, along their difference, µm: the parts add up to VA; a
    /// negative one makes the difference smaller.
    pub um: f64,
    /// VA of the machine without this error, µm.
    pub va_without_um: f64,
}

/// What the errors of a machine do in its volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment {
    /// The figures.
    pub definitions: Definitions,
    /// Every measured error, the largest part first.
    pub contributions: Vec<Contribution>,
}

/// Judges a volume.
pub fn assess(model: &VolumeModel, request: &Request) -> Assessment {
    let nodes = nodes(model, request.grid);
    let definitions = definitions(model, &nodes);
    let contributions = contributions(model, &nodes, &definitions.va);
    Assessment {
        definitions,
        contributions,
    }
}

fn nodes(model: &VolumeModel, choice: GridChoice) -> Nodes {
    match choice {
        GridChoice::OwnNodes => model.own_nodes(),
        GridChoice::Equal(counts) => model.equal_nodes(counts),
    }
}

/// (e_c(p) − e_c(q)) · u at the worst pair p, q; u = their difference by its length.
fn contributions(model: &VolumeModel, nodes: &Nodes, va: &LargestDifference) -> Vec<Contribution> {
    let scale = if va.um > 0.0 { 1.0 / va.um } else { 0.0 };
    let along = va.difference_um.times(scale);
    let part = |component: Component| {
        let only = |other: Component| other == component;
        let [p, q] = va.places_mm.map(|place| model.part_at(place, only));
        Contribution {
            component,
            um: p.minus(q).dot(along),
            va_without_um: largest_difference(&model.map_of(nodes, |other| other != component)).um,
        }
    };
    let mut parts: Vec<Contribution> = model.components().into_iter().map(part).collect();
    parts.sort_by(|a, b| b.um.abs().total_cmp(&a.um.abs()));
    parts
}

/// The machine as the tables of a control leave it: each deviation with what the control adds,
/// at the nodes of the table and of the measurement. Angles stay.
///
/// limits  what a control adds between two nodes in one step or in pulses counts as a straight line
pub fn with_tables(
    volume: &VolumeModel,
    model: &ErrorModel,
    plan: &Plan,
    control: &dyn Emulator,
) -> Result<VolumeModel, CannotEmulate> {
    let mut left = PerTerm::from_fn(|_| None);
    for term in ErrorTerm::ALL {
        if let Some(curve) = volume.deviation(term) {
            left[term] = Some(corrected(term, curve, model, plan, control)?);
        }
    }
    Ok(volume.with_deviations(left))
}

fn corrected(
    term: ErrorTerm,
    curve: &ErrorCurve,
    model: &ErrorModel,
    plan: &Plan,
    control: &dyn Emulator,
) -> Result<ErrorCurve, CannotEmulate> {
    let measured = model.terms[term].as_ref().map(|term| &term.measured);
    let Some((base, output)) = axis_pairs(plan, term).first().copied() else {
        return Ok(curve.clone());
    };
    let directions: &[Direction] = match measured {
        Some(Measured::OneWay(Direction::Plus, _)) => &[Direction::Plus],
        Some(Measured::OneWay(Direction::Minus, _)) => &[Direction::Minus],
        _ => &Direction::BOTH,
    };
    let mut responses: Vec<Response> = Vec::new();
    for direction in directions {
        responses.push(control.response(base, output, *direction)?);
    }
    let places = places(curve, &responses);
    let left: Vec<Deviation> = places
        .iter()
        .map(|place| curve.at(*place) + mean(&responses, *place))
        .map(|left| Deviation::from_um(left.um()))
        .collect();
    Ok(ErrorCurve::through(&places, &left, Interpolation::Linear))
}

/// Mean of what the control adds in each direction.
fn mean(responses: &[Response], place: Millimetres) -> Correction {
    let sum: f64 = responses.iter().map(|r| r.correction(place).um()).sum();
    #[allow(clippy::cast_precision_loss, reason = "two directions at most")]
    let count = responses.len() as f64;
    Correction::from_um(sum / count)
}

/// Where the curve or a correction bends, inside the measured range.
fn places(curve: &ErrorCurve, responses: &[Response]) -> Vec<Millimetres> {
    let (from, to) = curve.measured_range();
    let stretches = responses.iter().flat_map(|r| r.stretches(from, to));
    let mut places: Vec<Millimetres> = stretches
        .flat_map(|stretch| [stretch.from, stretch.to])
        .chain(curve.knots().iter().copied())
        .collect();
    places.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
    places.dedup_by(|next, kept| next <= kept);
    places
}
