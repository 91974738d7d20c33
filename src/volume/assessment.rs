//! What the errors do in the volume: figures, contributions, sub-volumes, distribution; as the
//! machine is and as the tables leave it; which nodes a volume is judged at.
//!
//! ```text
//!   model ─→ VolumeModel ─→ Assessment                                    as it is
//!               └─ + what the control adds (emulated from bytes) ─→ Assessment   with the tables
//! ```

mod tables;

pub(crate) use self::tables::with_tables;
use crate::quantity::{Axis, PerAxis, Xyz};
use crate::text::Problem;
use crate::volume::definitions::{Definitions, definitions};
use crate::volume::space::diameter::{Diameter, WindowMap, diameter};
use crate::volume::space::histogram;
use crate::volume::space::histogram::{Estimate, Tolerance, estimate, grouping};
use crate::volume::volume_model::{Component, ErrorMap, Nodes, VolumeModel, of_both};
use nonius_numerics::threads;
use serde::Serialize;

/// What is asked of a volume beside its figures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Request {
    /// Size of a sub-volume, mm.
    pub window_mm: Option<PerAxis<f64>>,
    /// Width of the bins of the histogram, µm.
    pub histogram_um: Option<f64>,
    /// Angular tolerance of the grouping of paper 002, which is put beside the exact figure.
    pub grouping: Option<f64>,
    /// Whether the error at each node is told, too.
    pub vectors: bool,
}

/// The errors at the nodes of a grid, X slowest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vectors {
    /// The nodes, mm.
    pub places_mm: Vec<Xyz<f64>>,
    /// The error at each of them, µm.
    pub um: Vec<Xyz<f64>>,
}

impl Vectors {
    fn of(model: &VolumeModel, nodes: &Nodes) -> Vectors {
        let pairs = nodes.x.iter().flat_map(|x| nodes.y.iter().map(move |y| (*x, *y)));
        let of = |(x, y)| nodes.z.iter().map(move |z| Xyz(PerAxis { x, y, z: *z }));
        let places_mm: Vec<Xyz<f64>> = pairs.flat_map(of).collect();
        let um = places_mm.iter().map(|place| Xyz(model.error_at(place.0))).collect();
        Vectors { places_mm, um }
    }
}

/// What one of the 21 errors does to the volumetric accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contribution {
    /// Which error.
    #[serde(rename = "term")]
    pub component: Component,
    /// Its part at the worst pair, along their difference, µm: the parts add up to VA; a
    /// negative one makes the difference smaller.
    pub um: f64,
    /// VA of the machine without this error, µm.
    pub va_without_um: f64,
}

/// How the differences of all pairs of nodes are distributed: bin n holds those from n to n + 1 widths.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Width of a bin, µm.
    pub bin_um: f64,
    /// Pairs in each bin.
    pub counts: Counts,
    /// Whether every pair was counted.
    pub exact: bool,
    /// Number of all pairs.
    pub pairs: u64,
    /// Where some were drawn.
    #[serde(flatten)]
    pub sampled: Option<Estimate>,
}

/// Pairs in each bin.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Counts {
    /// Every pair was counted.
    Counted(Vec<u64>),
    /// Some were drawn. `None` = no drawn pair fell into it, which does not say that none would.
    Estimated(Vec<Option<f64>>),
}

impl Counts {
    /// By their bins.
    pub fn each(&self) -> Vec<Option<f64>> {
        match self {
            Counts::Counted(counts) => counts.iter().map(|n| Some(*n as f64)).collect(),
            Counts::Estimated(counts) => counts.clone(),
        }
    }
}

/// What the errors of a machine do in its volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assessment {
    /// Nodes of each axis.
    pub grid: Xyz<usize>,
    /// The figures.
    pub definitions: Definitions,
    /// Every measured error, the largest part first.
    pub contributions: Vec<Contribution>,
    /// Sub-volumes, where a size is given.
    pub windows: Option<Windows>,
    /// Distribution, where a width is given.
    pub histogram: Option<Histogram>,
    /// What the grouping of paper 002 finds, where it is asked for.
    pub grouping: Option<Baseline>,
    /// The error at each node, where it is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vectors: Option<Vectors>,
}

/// Judges a volume at the nodes of a grid, the same for all machines that are to be compared.
pub fn assess(model: &VolumeModel, grid: &Grid, request: &Request) -> Result<Assessment, Problem> {
    let nodes = &grid.nodes;
    let map = model.map(nodes).ok_or_else(no_map)?;
    let definitions = definitions(model, &map);
    let windows = request.window_mm.map(|size| windows(model, grid, size));
    let histogram = request.histogram_um.map(|bin| histogram(&map, bin));
    let grouping = request.grouping.map(|angular| Baseline::of(&map, angular));
    Ok(Assessment {
        grid: Xyz(nodes.counts()),
        grouping: grouping.transpose()?,
        contributions: contributions(model, nodes, &definitions)?,
        definitions,
        windows: windows.transpose()?,
        histogram: histogram.transpose()?,
        vectors: request.vectors.then(|| Vectors::of(model, nodes)),
    })
}

/// (e_c(p) − e_c(q)) · u at the worst pair p, q; u = their difference by its length.
fn contributions(
    model: &VolumeModel,
    nodes: &Nodes,
    found: &Definitions,
) -> Result<Vec<Contribution>, Problem> {
    let scale = if found.va_um > 0.0 { 1.0 / found.va_um } else { 0.0 };
    let along = found.va_difference_um.0.times(scale);
    let mut parts = Vec::new();
    for component in model.components() {
        let only = |other: Component| other == component;
        let [p, q] = found.va_pair_mm.map(|place| model.part_at(place.0, only));
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
        let counts = histogram::exact(&vectors.vectors(), bin_um, threads::count());
        let counts = Counts::Counted(counts.ok_or_else(too_fine)?);
        return Ok(Histogram { bin_um, counts, exact: true, pairs, sampled: None });
    }
    let mut estimate = estimate(vectors, bin_um, DRAWN, SEED).ok_or_else(too_fine)?;
    let counts = Counts::Estimated(std::mem::take(&mut estimate.counts));
    Ok(Histogram { bin_um, counts, exact: false, pairs, sampled: Some(estimate) })
}

/// The paper's magnitude tolerance: a shorter vector of a group is dismissed.
const MAGNITUDE: f64 = 0.9;
/// Nodes that are grouped at most: what is kept is compared pair by pair.
const MOST_NODES: usize = 50_000;

/// What the grouping keeps and finds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// No: it may miss the largest difference.
    pub exact: bool,
    /// Angular tolerance.
    pub angular_tolerance: f64,
    /// Magnitude tolerance.
    pub magnitude_tolerance: f64,
    /// Vectors that are grouped.
    #[serde(skip)]
    pub vectors: usize,
    /// Groups.
    pub groups: usize,
    /// Vectors that are kept and compared.
    pub records: usize,
    /// Largest difference of two that are kept, µm; `None` = no two are kept.
    pub um: Option<f64>,
    /// Their places, mm.
    pub pair_mm: Option<[Xyz<f64>; 2]>,
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
            exact: false,
            angular_tolerance: angular,
            magnitude_tolerance: MAGNITUDE,
            vectors: count,
            groups: found.groups,
            records: found.records.len(),
            um: longest.map(|longest| longest.um()),
            pair_mm: longest.map(|longest| longest.pair.map(|number| Xyz(place(number)))),
        })
    }
}

/// Most nodes of a grid.
pub const MOST_POINTS: usize = 100_000_000;

/// Most sub-volumes of a size: each is kept with its figure.
const MOST_WINDOWS: usize = 200_000;

/// Which nodes to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridChoice {
    /// Every place where a curve bends, and the ends.
    OwnNodes,
    /// So many of each axis, equally spaced.
    Equal(PerAxis<usize>),
}

/// The nodes that all machines of a comparison are judged at.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    nodes: Nodes,
    /// The nodes of the machine as it is, where the others have more.
    measured: Nodes,
}

impl Grid {
    /// The nodes for the machine as it is and the others that are compared with it (with tables,
    /// without): of own nodes those of all of them, because curves that the tables bend have
    /// their extremes at the nodes of the tables too.
    ///
    /// limits  [`MOST_POINTS`]
    pub fn of(
        choice: GridChoice,
        as_it_is: &VolumeModel,
        others: &[&VolumeModel],
    ) -> Result<Grid, Problem> {
        let (measured, others) = match choice {
            GridChoice::OwnNodes => (as_it_is.own_nodes(), others),
            GridChoice::Equal(counts) => (as_it_is.equal_nodes(counts), &[][..]),
        };
        let others = others.iter().map(|other| other.own_nodes());
        let nodes = others.fold(measured.clone(), |nodes, other| of_both(&nodes, &other));
        let counts = nodes.counts();
        if counts.x.saturating_mul(counts.y).saturating_mul(counts.z) > MOST_POINTS {
            return Err(Problem::new(format!(
                "the own nodes of this machine are {} x {} x {}, more than {MOST_POINTS} together",
                counts.x, counts.y, counts.z
            ))
            .help("choose fewer with `--grid`, e.g. 101,101,101"));
        }
        Ok(Grid { nodes, measured })
    }
}

/// Volumetric accuracy of every sub-volume of a size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Windows {
    /// Size, mm.
    pub size_mm: Xyz<f64>,
    /// How many there are.
    pub count: usize,
    /// Nodes of each axis that they lie between: those of the measurement, where the nodes of the
    /// tables would make distances unequal.
    pub grid: Xyz<usize>,
    /// The smallest figure, µm.
    pub min_um: f64,
    /// The largest one.
    pub max_um: f64,
    /// The sub-volume at the smallest coordinates of the volume, µm.
    pub corner_um: f64,
    /// The corner with the smallest coordinates of the best sub-volume, mm.
    pub min_at_mm: Xyz<f64>,
    /// The same of the worst one.
    pub max_at_mm: Xyz<f64>,
    /// Every sub-volume.
    pub map: FigureMap,
}

/// The figures of all sub-volumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FigureMap {
    /// Their smallest coordinates along X, mm.
    pub x_mm: Vec<f64>,
    /// The same along Y.
    pub y_mm: Vec<f64>,
    /// The same along Z.
    pub z_mm: Vec<f64>,
    /// The figures by their number along X, Y and Z, µm.
    pub um: Vec<Vec<Vec<f64>>>,
}

/// Part of a node distance by which a size may miss a whole number of them.
const WHOLE: f64 = 1e-6;

fn windows(model: &VolumeModel, grid: &Grid, size_mm: PerAxis<f64>) -> Result<Windows, Problem> {
    let fits = |nodes| Some((nodes, nodes_of(nodes, size_mm)?));
    let found = fits(&grid.nodes).or_else(|| fits(&grid.measured));
    let (nodes, counts) = found.ok_or_else(|| between_nodes(&grid.nodes, size_mm))?;
    let places_mm = PerAxis::from_fn(|axis| {
        let last = nodes[axis].len() + 1 - counts[axis];
        nodes[axis][..last].to_vec()
    });
    let corners = places_mm.counts();
    let count = corners.x.saturating_mul(corners.y).saturating_mul(corners.z);
    if count > MOST_WINDOWS {
        let message =
            format!("there are {count} sub-volumes of this size, more than {MOST_WINDOWS}");
        return Err(Problem::new(message).help("choose fewer nodes with `--grid`"));
    }
    let map = model.map(nodes).ok_or_else(no_map)?;
    let size = map.vectors().along_chain([counts.x, counts.y, counts.z]);
    let all = WindowMap::of(map.vectors(), size).ok_or_else(no_map)?;
    let figure = |(number, figure): (usize, Diameter)| (figure.um, map.place(all.low(number)));
    let at = |xyz| all.at(map.vectors().along_chain(xyz)).um;
    let along_z = |x, y| (0..corners.z).map(|z| at([x, y, z])).collect();
    let along_y = |x| (0..corners.y).map(|y| along_z(x, y)).collect();
    let (best, worst) = (figure(all.best()), figure(all.worst()));
    let PerAxis { x: x_mm, y: y_mm, z: z_mm } = places_mm;
    Ok(Windows {
        size_mm: Xyz(size_mm),
        count,
        grid: Xyz(nodes.counts()),
        min_um: best.0,
        max_um: worst.0,
        corner_um: all.at([0; 3]).um,
        min_at_mm: Xyz(best.1),
        max_at_mm: Xyz(worst.1),
        map: FigureMap { x_mm, y_mm, z_mm, um: (0..corners.x).map(along_y).collect() },
    })
}

/// Nodes of a sub-volume along each axis, its ends among them.
fn nodes_of(nodes: &Nodes, size_mm: PerAxis<f64>) -> Option<PerAxis<usize>> {
    let count = |axis| {
        let own: &[f64] = &nodes[axis];
        let step = (own[own.len() - 1] - own[0]) / (own.len() - 1) as f64;
        let is_even = own.windows(2).all(|n| (n[1] - n[0] - step).abs() <= step * WHOLE);
        whole(size_mm[axis] / step).filter(|_| is_even).map(|steps| steps + 1)
    };
    PerAxis::from_fn(count).all()
}

/// So many node distances, if it is a whole number of them.
fn whole(distances: f64) -> Option<usize> {
    let whole = distances.round();
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a larger number than of nodes fits nowhere"
    )]
    ((distances - whole).abs() <= WHOLE && whole >= 1.0).then_some(whole as usize)
}

/// With what to choose: the first numbers of nodes from 21 on that will do.
fn between_nodes(nodes: &Nodes, size_mm: PerAxis<f64>) -> Problem {
    let fitting = |axis: Axis| {
        let part = size_mm[axis] / (nodes[axis].last()? - nodes[axis].first()?);
        (21..=1001_u32).find(|count| whole(part * f64::from(count - 1)).is_some())
    };
    let example = match Axis::ALL.map(fitting) {
        [Some(x), Some(y), Some(z)] if f64::from(x * y * z) <= MOST_WINDOWS as f64 => {
            format!(", e.g. {x},{y},{z}")
        }
        _ => String::new(),
    };
    let PerAxis { x, y, z } = size_mm;
    Problem::new(format!("{x} x {y} x {z} mm is no whole number of equal node distances"))
        .help(format!("choose `--grid` so that every length of the sub-volume is one{example}"))
}

fn no_map() -> Problem {
    Problem::new("the nodes of an axis cannot be told apart, expected ascending positions")
        .help("use fewer nodes")
}
