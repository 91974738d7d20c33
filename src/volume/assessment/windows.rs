//! Sub-volumes of a size, wherever they fit between nodes.

use super::Grid;
use crate::quantity::axis::{Axis, PerAxis};
use crate::text::problem::Problem;
use crate::volume::space::diameter::Diameter;
use crate::volume::space::windows::WindowMap;
use crate::volume::volume_model::{Nodes, VolumeModel};

/// Volumetric accuracy of every sub-volume of a size.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Size, mm.
    pub size_mm: PerAxis<f64>,
    /// How many there are.
    pub count: usize,
    /// Nodes of each axis that they lie between: those of the measurement, where the nodes of the
    /// tables would make distances unequal.
    pub grid: PerAxis<usize>,
    /// The smallest figure, µm, and the corner with the smallest coordinates of its sub-volume, mm.
    pub best: (f64, PerAxis<f64>),
    /// The largest one.
    pub worst: (f64, PerAxis<f64>),
    /// The sub-volume at the smallest coordinates of the volume, µm.
    pub corner_um: f64,
    /// The map: where the corners with the smallest coordinates lie along each axis, mm.
    pub places_mm: Nodes,
    /// The figures of the map, µm; X slowest, Z fastest.
    pub map_um: Vec<f64>,
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
    let map = model.map(nodes).ok_or_else(no_map)?;
    let size = map.vectors().along_chain([counts.x, counts.y, counts.z]);
    let all = WindowMap::of(map.vectors(), size).ok_or_else(no_map)?;
    let figure = |(number, figure): (usize, Diameter)| (figure.um, map.place(all.low(number)));
    let places_mm = PerAxis::from_fn(|axis| {
        let last = nodes[axis].len() + 1 - counts[axis];
        nodes[axis][..last].to_vec()
    });
    let corners = places_mm.counts();
    let places = (0..corners.x)
        .flat_map(|x| (0..corners.y).flat_map(move |y| (0..corners.z).map(move |z| [x, y, z])));
    let at = |xyz| all.at(map.vectors().along_chain(xyz)).um;
    Ok(Windows {
        size_mm,
        count: all.figures.len(),
        grid: map.counts(),
        best: figure(all.best()),
        worst: figure(all.worst()),
        corner_um: all.corner().um,
        map_um: places.map(at).collect(),
        places_mm,
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

pub(super) fn no_map() -> Problem {
    Problem::new("the nodes of an axis cannot be told apart, expected ascending positions")
        .help("use fewer nodes")
}
