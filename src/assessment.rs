//! What the errors do in the volume: figures, contributions, sub-volumes, distribution; as the
//! machine is and as the tables leave it.
//!
//! ```text
//!   model ─→ VolumeModel ─→ Assessment                                    as it is
//!               └─ + what the control adds (emulated from bytes) ─→ Assessment   with the tables
//! ```

mod baseline;
mod exactness;

pub use self::baseline::Baseline;
pub use self::exactness::{corrects_in_steps, holds_everywhere};

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::curve::{ErrorCurve, Interpolation};
use crate::definitions::{Definitions, LargestDifference, definitions, largest_difference};
use crate::emulate::{CannotEmulate, Emulator, Response};
use crate::model::{ErrorModel, Measured};
use crate::plan::{Plan, axis_pairs};
use crate::problem::Problem;
use crate::space::diameter::Diameter;
use crate::space::grid_map::GridMap;
use crate::space::histogram;
use crate::space::sample::estimate;
use crate::space::windows::WindowMap;
use crate::units::{Correction, Deviation, Millimetres};
use crate::volume_model::{Component, ErrorMap, Nodes, VolumeModel};

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
    /// Angular tolerance of the grouping of paper 002, which is put beside the exact figure.
    pub grouping: Option<f64>,
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

/// Volumetric accuracy of every sub-volume of a size.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Size, mm.
    pub size_mm: PerAxis<f64>,
    /// How many there are.
    pub count: usize,
    /// The smallest figure, µm, and the corner with the smallest coordinates of its sub-volume, mm.
    pub best: (f64, PerAxis<f64>),
    /// The largest one.
    pub worst: (f64, PerAxis<f64>),
    /// The sub-volume at the smallest coordinates of the volume, µm.
    pub corner_um: f64,
    /// Smallest coordinates that a sub-volume has along each axis, mm.
    pub places_mm: PerAxis<Vec<f64>>,
    /// Figure of every sub-volume, µm: X slowest, Z fastest, over `places_mm`.
    pub map_um: Vec<f64>,
}

/// How the differences of all pairs of nodes are distributed: bin n holds those from n to n + 1 widths.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Width of a bin, µm.
    pub bin_um: f64,
    /// Pairs in each bin; whole numbers where every pair was counted. `None` = no drawn pair fell
    /// into it, which does not say that none would.
    pub counts: Vec<Option<f64>>,
    /// Number of all pairs.
    pub pairs: u64,
    /// Pairs drawn, and the standard error of each count (`None` = unknown); `None` = every pair
    /// was counted.
    pub sampled: Option<(u64, Vec<Option<f64>>)>,
}

/// What the errors of a machine do in its volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment {
    /// The figures.
    pub definitions: Definitions,
    /// Whether the volumetric accuracy holds for every place of the volume; else for the nodes.
    pub va_exact: bool,
    /// Every measured error, the largest part first.
    pub contributions: Vec<Contribution>,
    /// Sub-volumes, where a size is given.
    pub windows: Option<Windows>,
    /// Distribution, where a width is given.
    pub histogram: Option<Histogram>,
    /// What the grouping of paper 002 finds, where it is asked for.
    pub grouping: Option<Baseline>,
}

/// Judges a volume.
pub fn assess(model: &VolumeModel, request: &Request) -> Result<Assessment, Problem> {
    let nodes = nodes(model, request.grid);
    let map = model.map(&nodes).ok_or_else(no_map)?;
    let definitions = definitions(model, &map);
    let windows = request.window_mm.map(|size| windows(&map, size));
    let histogram = request.histogram_um.map(|bin| histogram(&map, bin));
    let grouping = request.grouping.map(|angular| Baseline::of(&map, angular));
    Ok(Assessment {
        va_exact: holds_everywhere(model, &nodes),
        grouping: grouping.transpose()?,
        contributions: contributions(model, &nodes, &definitions.va)?,
        definitions,
        windows: windows.transpose()?,
        histogram: histogram.transpose()?,
    })
}

fn no_map() -> Problem {
    Problem::new("the nodes of an axis cannot be told apart, expected ascending positions")
        .help("use fewer nodes")
}

fn nodes(model: &VolumeModel, choice: GridChoice) -> Nodes {
    match choice {
        GridChoice::OwnNodes => model.own_nodes(),
        GridChoice::Equal(counts) => model.equal_nodes(counts),
    }
}

/// (e_c(p) − e_c(q)) · u at the worst pair p, q; u = their difference by its length.
fn contributions(
    model: &VolumeModel,
    nodes: &Nodes,
    va: &LargestDifference,
) -> Result<Vec<Contribution>, Problem> {
    let scale = if va.um > 0.0 { 1.0 / va.um } else { 0.0 };
    let along = va.difference_um.times(scale);
    let mut parts = Vec::new();
    for component in model.components() {
        let only = |other: Component| other == component;
        let [p, q] = va.places_mm.map(|place| model.part_at(place, only));
        let without = model.map_of(nodes, |other| other != component);
        parts.push(Contribution {
            component,
            um: p.minus(q).dot(along),
            va_without_um: largest_difference(&without.ok_or_else(no_map)?).um,
        });
    }
    parts.sort_by(|a, b| b.um.abs().total_cmp(&a.um.abs()));
    Ok(parts)
}

/// Part of a node distance by which a size may miss a whole number of them.
const WHOLE: f64 = 1e-6;

/// All sub-volumes of a size, wherever they fit between nodes.
fn windows(map: &ErrorMap, size_mm: PerAxis<f64>) -> Result<Windows, Problem> {
    let mut counts = PerAxis::default();
    for axis in Axis::ALL {
        counts[axis] = nodes_in(axis, &map.nodes()[axis], size_mm[axis])?;
    }
    let size = map.vectors().along_chain([counts.x, counts.y, counts.z]);
    let all = WindowMap::of(map.vectors(), size).ok_or_else(no_map)?;
    let figure = |(number, figure): (usize, Diameter)| (figure.um, map.place(all.low(number)));
    Ok(Windows {
        size_mm,
        count: all.figures.len(),
        best: figure(all.best()),
        worst: figure(all.worst()),
        corner_um: all.corner().um,
        map_um: by_axis(&all, map.vectors()),
        places_mm: PerAxis::from_fn(|axis| {
            let nodes = &map.nodes()[axis];
            nodes[..=nodes.len() - counts[axis]].to_vec()
        }),
    })
}

/// The figures of all sub-volumes, X slowest, Z fastest, whatever the chain.
fn by_axis(all: &WindowMap, vectors: &GridMap) -> Vec<f64> {
    let [x, y, z] = vectors.xyz(all.positions);
    let [_, second, third] = all.positions;
    let places = (0..x).flat_map(|x| (0..y).flat_map(move |y| (0..z).map(move |z| [x, y, z])));
    places
        .map(|place| vectors.along_chain(place))
        .map(|[i, j, k]| all.figures[(i * second + j) * third + k].um)
        .collect()
}

/// Nodes of a sub-volume along one axis, its ends among them.
fn nodes_in(axis: Axis, nodes: &[f64], size_mm: f64) -> Result<usize, Problem> {
    let help =
        "choose `--grid` so that the size is a whole number of node distances, e.g. 21,21,21";
    let ends = nodes.first().zip(nodes.last());
    let (Some((first, last)), Some(steps)) = (ends, nodes.len().checked_sub(1)) else {
        return Err(no_map());
    };
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 nodes")]
    let step = (last - first) / steps.max(1) as f64;
    let even = nodes
        .windows(2)
        .all(|n| (n[1] - n[0] - step).abs() <= step * WHOLE);
    if !even {
        return Err(Problem::new(format!(
            "sub-volumes need equally spaced nodes, and those of {axis} are not"
        ))
        .help(help));
    }
    let wanted = size_mm / step;
    let whole = wanted.round();
    if (wanted - whole).abs() > WHOLE || whole < 1.0 {
        return Err(Problem::new(format!(
            "the sub-volume is {size_mm} mm long in {axis}, which is no whole number of node distances ({step} mm)"
        ))
        .help(help));
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number not above the number of nodes"
    )]
    Ok(whole as usize + 1)
}

/// Pairs drawn where not all can be counted, and where the generator begins.
const DRAWN: u64 = 10_000_000;
const SEED: u64 = 1;

fn histogram(map: &ErrorMap, bin_um: f64) -> Result<Histogram, Problem> {
    let pairs = histogram::pairs(map.count());
    let too_fine = || {
        Problem::new(format!(
            "bins of {bin_um} µm are too narrow for this volume"
        ))
        .help("choose wider ones: at most 4095 are counted")
    };
    let vectors = map.vectors();
    if pairs <= histogram::EXACT_PAIRS {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let counts = histogram::exact(&vectors.vectors(), bin_um, threads);
        #[allow(
            clippy::cast_precision_loss,
            reason = "at most 3·10⁹ pairs are counted"
        )]
        let counts = counts
            .ok_or_else(too_fine)?
            .into_iter()
            .map(|n| Some(n as f64));
        return Ok(Histogram {
            bin_um,
            counts: counts.collect(),
            pairs,
            sampled: None,
        });
    }
    let estimate = estimate(vectors, bin_um, DRAWN, SEED).ok_or_else(too_fine)?;
    Ok(Histogram {
        bin_um,
        counts: estimate.counts,
        pairs,
        sampled: Some((estimate.drawn, estimate.standard_errors)),
    })
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
    let Some((base, output)) = axis_pairs(&plan.names, term).first().copied() else {
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
