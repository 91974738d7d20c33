//! What the errors do in the volume: figures, contributions, sub-volumes, distribution; as the
//! machine is and as the tables leave it.
//!
//! ```text
//!   model ─→ VolumeModel ─→ Assessment                                    as it is
//!               └─ + what the control adds (emulated from bytes) ─→ Assessment   with the tables
//! ```

pub(crate) use self::grid::holds_everywhere;
use self::grid::no_map;
pub use self::grid::{Grid, GridChoice, MOST_POINTS, Windows};
pub(crate) use self::tables::with_tables;
use crate::quantity::axis::PerAxis;
use crate::text::problem::Problem;
use crate::volume::definitions::{Definitions, LargestDifference, definitions};
use crate::volume::space::diameter::diameter;
use crate::volume::space::grouping::{Tolerance, grouping};
use crate::volume::space::histogram;
use crate::volume::space::sample::estimate;
use crate::volume::volume_model::{Component, ErrorMap, Nodes, VolumeModel};

mod grid;
mod tables;

/// What is asked of a volume beside its figures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Request {
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

/// Judges a volume at the nodes of a grid, the same for all machines that are to be compared.
pub fn assess(model: &VolumeModel, grid: &Grid, request: &Request) -> Result<Assessment, Problem> {
    let nodes = grid.nodes();
    let map = model.map(nodes).ok_or_else(no_map)?;
    let definitions = definitions(model, &map);
    let windows = request.window_mm.map(|size| grid::windows(model, grid, size));
    let histogram = request.histogram_um.map(|bin| histogram(&map, bin));
    let grouping = request.grouping.map(|angular| Baseline::of(&map, angular));
    Ok(Assessment {
        va_exact: holds_everywhere(model, nodes),
        grouping: grouping.transpose()?,
        contributions: contributions(model, nodes, &definitions.va)?,
        definitions,
        windows: windows.transpose()?,
        histogram: histogram.transpose()?,
    })
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
            va_without_um: diameter(without.ok_or_else(no_map)?.vectors()).um,
        });
    }
    parts.sort_by(|a, b| b.um.abs().total_cmp(&a.um.abs()));
    Ok(parts)
}

/// Pairs drawn where not all can be counted, and where the generator begins.
const DRAWN: u64 = 10_000_000;
const SEED: u64 = 1;

fn histogram(map: &ErrorMap, bin_um: f64) -> Result<Histogram, Problem> {
    let pairs = histogram::pairs(map.vectors().count());
    let too_fine = || {
        Problem::new(format!("bins of {bin_um} µm are too narrow for this volume"))
            .help("choose wider ones: at most 4095 are counted")
    };
    let vectors = map.vectors();
    if pairs <= histogram::EXACT_PAIRS {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let counts = histogram::exact(&vectors.vectors(), bin_um, threads);
        let counts = counts.ok_or_else(too_fine)?.into_iter().map(|n| Some(n as f64));
        return Ok(Histogram { bin_um, counts: counts.collect(), pairs, sampled: None });
    }
    let estimate = estimate(vectors, bin_um, DRAWN, SEED).ok_or_else(too_fine)?;
    Ok(Histogram {
        bin_um,
        counts: estimate.counts,
        pairs,
        sampled: Some((estimate.drawn, estimate.standard_errors)),
    })
}

/// The paper's magnitude tolerance: a shorter vector of a group is dismissed.
const MAGNITUDE: f64 = 0.9;
/// Nodes that are grouped at most: what is kept is compared pair by pair.
const MOST_NODES: usize = 50_000;

/// What the grouping keeps and finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Baseline {
    /// Angular tolerance.
    pub angular: f64,
    /// Magnitude tolerance.
    pub magnitude: f64,
    /// Vectors that are grouped.
    pub vectors: usize,
    /// Groups.
    pub groups: usize,
    /// Vectors that are kept and compared (*records*).
    pub records: usize,
    /// Largest difference of two that are kept, µm, and their places, mm; `None` = no two are kept.
    pub longest: Option<(f64, [PerAxis<f64>; 2])>,
}

impl Baseline {
    /// Groups the error vectors of a map as they are, zero at the reference.
    ///
    /// source paper 002 §4.2, see [`crate::volume::space::grouping`]
    /// limits not exact: the volumetric accuracy is at least this; 50 000 nodes at most
    pub fn of(map: &ErrorMap, angular: f64) -> Result<Baseline, Problem> {
        let count = map.vectors().count();
        if count > MOST_NODES {
            return Err(Problem::new(format!(
                "the grid has {count} nodes, but the grouping compares what it keeps pair by pair: {MOST_NODES} at most"
            ))
            .help("use fewer nodes with `--grid`, or leave `--grouping` out"));
        }
        let tolerance = Tolerance { angular, magnitude: MAGNITUDE };
        let vectors = map.vectors();
        let found = grouping(&vectors.vectors(), tolerance);
        let place = |number: usize| map.place(vectors.node(number));
        let longest = found.longest.filter(|_| found.records.len() > 1);
        Ok(Baseline {
            angular,
            magnitude: MAGNITUDE,
            vectors: count,
            groups: found.groups,
            records: found.records.len(),
            longest: longest.map(|l| (l.um(), l.pair.map(place))),
        })
    }
}
