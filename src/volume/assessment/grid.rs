//! Which nodes a volume is judged at, and sub-volumes of a size, wherever they fit between nodes.

use crate::quantity::axis::{Axis, Listed, PerAxis};
use crate::text::problem::Problem;
use crate::volume::space::diameter::{Diameter, WindowMap};
use crate::volume::volume_model::{Nodes, VolumeModel};
use serde::Serialize;

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
        let nodes =
            others.iter().fold(measured.clone(), |nodes, other| nodes.and(&other.own_nodes()));
        let counts = nodes.counts();
        let points = counts.x.checked_mul(counts.y);
        let points = points.and_then(|points| points.checked_mul(counts.z));
        if points.is_none_or(|points| points > MOST_POINTS) {
            return Err(Problem::new(format!(
                "the own nodes of this machine are {} x {} x {}, more than {MOST_POINTS} together",
                counts.x, counts.y, counts.z
            ))
            .help("choose fewer with `--grid`, e.g. 101,101,101"));
        }
        Ok(Grid { nodes, measured })
    }

    /// The nodes.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// The nodes of the machine as it is.
    pub fn measured(&self) -> &Nodes {
        &self.measured
    }
}

/// Volumetric accuracy of every sub-volume of a size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Windows {
    /// Size, mm.
    pub size_mm: Listed<f64>,
    /// How many there are.
    pub count: usize,
    /// Nodes of each axis that they lie between: those of the measurement, where the nodes of the
    /// tables would make distances unequal.
    pub grid: Listed<usize>,
    /// The smallest figure, µm.
    pub min_um: f64,
    /// The largest one.
    pub max_um: f64,
    /// The sub-volume at the smallest coordinates of the volume, µm.
    pub corner_um: f64,
    /// The corner with the smallest coordinates of the best sub-volume, mm.
    pub min_at_mm: Listed<f64>,
    /// The same of the worst one.
    pub max_at_mm: Listed<f64>,
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

pub(super) fn windows(
    model: &VolumeModel,
    grid: &Grid,
    size_mm: PerAxis<f64>,
) -> Result<Windows, Problem> {
    let fits = |nodes| Ok((nodes, nodes_of(nodes, size_mm)?));
    let (nodes, counts) = fits(grid.nodes()).or_else(|_: Problem| fits(grid.measured()))?;
    let places_mm = PerAxis::from_fn(|axis| {
        let last = nodes[axis].len() + 1 - counts[axis];
        nodes[axis][..last].to_vec()
    });
    let corners = places_mm.counts();
    let count = corners.x.saturating_mul(corners.y).saturating_mul(corners.z);
    if count > MOST_WINDOWS {
        let message =
            format!("there are {count} sub-volumes of this size, more than {MOST_WINDOWS}");
        return Err(Problem::new(message).help("choose fewer nodes with `--grid`, e.g. 41,41,41"));
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
        size_mm: Listed(size_mm),
        count,
        grid: Listed(nodes.counts()),
        min_um: best.0,
        max_um: worst.0,
        corner_um: all.at([0; 3]).um,
        min_at_mm: Listed(best.1),
        max_at_mm: Listed(worst.1),
        map: FigureMap { x_mm, y_mm, z_mm, um: (0..corners.x).map(along_y).collect() },
    })
}

fn nodes_of(nodes: &Nodes, size_mm: PerAxis<f64>) -> Result<PerAxis<usize>, Problem> {
    let mut counts = PerAxis::default();
    for axis in Axis::ALL {
        counts[axis] = nodes_in(axis, &nodes[axis], size_mm[axis])?;
    }
    Ok(counts)
}

/// Nodes of a sub-volume along one axis, its ends among them.
fn nodes_in(axis: Axis, nodes: &[f64], size_mm: f64) -> Result<usize, Problem> {
    let help =
        "choose `--grid` so that the size is a whole number of node distances, e.g. 21,21,21";
    let ends = nodes.first().zip(nodes.last());
    let (Some((first, last)), Some(steps)) = (ends, nodes.len().checked_sub(1)) else {
        return Err(no_map());
    };
    let step = (last - first) / steps.max(1) as f64;
    let even = nodes.windows(2).all(|n| (n[1] - n[0] - step).abs() <= step * WHOLE);
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
        reason = "a whole number not above the number of nodes"
    )]
    Ok(whole as usize + 1)
}

pub(super) fn no_map() -> Problem {
    Problem::new("the nodes of an axis cannot be told apart, expected ascending positions")
        .help("use fewer nodes")
}
