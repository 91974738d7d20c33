//! The error vectors at the nodes of a grid, in the structured form of [`crate::volume::space`].
//! The range of each axis is what every one of its curves covers.

use super::{Component, MM_PER_M, VolumeModel};
use crate::inputs::job::Job;
use crate::quantity::{Axis, ErrorCurve, ErrorTerm, PerAxis, Rotation, SAME_PLACE_MM};
use crate::text::{Problem, Problems};
use crate::volume::space::grid_map::{AxisNode, GridMap, Node};

/// The positions of each axis, mm, ascending.
pub type Nodes = PerAxis<Vec<f64>>;

/// The nodes of both.
pub(crate) fn of_both(one: &Nodes, other: &Nodes) -> Nodes {
    PerAxis::from_fn(|axis| ascending(one[axis].iter().chain(&other[axis]).copied()))
}

fn ascending(nodes: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut nodes: Vec<f64> = nodes.collect();
    nodes.sort_by(f64::total_cmp);
    nodes.dedup_by(|next, kept| *next - *kept < SAME_PLACE_MM);
    nodes
}

/// The machine at the nodes of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    nodes: Nodes,
    vectors: GridMap,
}

impl VolumeModel {
    /// Every place where a curve bends, with the ends of the range: between neighbouring nodes of
    /// linear curves the error is a straight line in each coordinate, so its extremes and its
    /// largest differences lie at nodes.
    pub fn own_nodes(&self) -> Nodes {
        PerAxis::from_fn(|axis| {
            let (low, high) = self.range(axis);
            let inside = self.bends(axis).into_iter().filter(|bend| *bend > low && *bend < high);
            ascending(inside.chain([low, high]))
        })
    }

    /// So many equally spaced nodes of each axis over its range; of a range of no length, one.
    pub(crate) fn equal_nodes(&self, counts: PerAxis<usize>) -> Nodes {
        PerAxis::from_fn(|axis| {
            let (low, high) = self.range(axis);
            if high - low < SAME_PLACE_MM || counts[axis] < 2 {
                return vec![low];
            }
            let last = counts[axis] - 1;
            let place = |index: usize| low + (high - low) * (index as f64 / last as f64);
            (0..last).map(place).chain([high]).collect()
        })
    }

    /// The machine at these nodes; `None` where those of an axis do not ascend.
    pub fn map(&self, nodes: &Nodes) -> Option<ErrorMap> {
        self.map_of(nodes, |_| true)
    }

    /// The machine with some of its components only, at these nodes.
    pub fn map_of(&self, nodes: &Nodes, keep: impl Fn(Component) -> bool) -> Option<ErrorMap> {
        let order = self.chain.order();
        let lists = order.map(|axis| {
            let node = |mm: &f64| {
                let [x, y, z, a, b, c] = self.state(axis, *mm, &keep).values();
                let arm_m = (mm - self.origin[axis]) / MM_PER_M;
                AxisNode { translation_um: [x, y, z], rotation_urad: [a, b, c], arm_m }
            };
            nodes[axis].iter().map(node).collect()
        });
        Some(ErrorMap { nodes: nodes.clone(), vectors: GridMap::new(order, &lists)? })
    }

    /// Every curve of an axis with its name.
    fn named_curves(&self, axis: Axis) -> impl Iterator<Item = (String, &ErrorCurve)> {
        let deviations = Axis::ALL.map(|of| {
            let term = ErrorTerm { of, along: axis };
            Some((term.to_string(), self.deviations[term].as_ref()?))
        });
        let rotations = Axis::ALL.map(|about| {
            let rotation = Rotation { about, along: axis };
            Some((rotation.to_string(), self.rotations[rotation].as_ref()?))
        });
        deviations.into_iter().chain(rotations).flatten()
    }

    /// Every curve of an axis.
    pub(super) fn curves_along(&self, axis: Axis) -> impl Iterator<Item = &ErrorCurve> {
        self.named_curves(axis).map(|(_, curve)| curve)
    }

    /// What all curves of an axis cover; of an axis without curves its travel, because the
    /// rotations of others swing it all the same. Curves that have no range in common are of no
    /// use together, and are refused.
    pub(super) fn common_ranges(&self, job: &Job) -> Result<PerAxis<(f64, f64)>, Problems> {
        let mut problems = Problems::none();
        let mut ranges = PerAxis::from_fn(|axis| (self.origin[axis], self.origin[axis]));
        for axis in Axis::ALL {
            match (self.common_range(job, axis), job.machine.axes[axis]) {
                (Err(problem), _) => problems.push(problem),
                (Ok(Some(range)), _) => ranges[axis] = range,
                (Ok(None), Some(machine)) => ranges[axis] = (machine.low.mm(), machine.high.mm()),
                (Ok(None), None) => {}
            }
        }
        problems.or_ok(ranges)
    }

    fn common_range(&self, job: &Job, axis: Axis) -> Result<Option<(f64, f64)>, Problem> {
        let ends = |(name, curve): (String, &ErrorCurve)| {
            let (low, high) = curve.measured_range();
            (name, low.mm(), high.mm())
        };
        let curves: Vec<(String, f64, f64)> = self.named_curves(axis).map(ends).collect();
        let last_to_begin = curves.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let first_to_end = curves.iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let (Some((late, low, to)), Some((early, from, high))) = (last_to_begin, first_to_end)
        else {
            return Ok(None);
        };
        if low < high {
            return Ok(Some((*low, *high)));
        }
        let words = format!(
            "the curves of {axis} have no range in common: {early} was measured from {from} to {high} mm, {late} from {low} to {to} mm"
        );
        let help = "measure both over the range that is to be judged, or leave one of them out";
        Err(job.problem_at("measurement", words).help(help))
    }
}

impl ErrorMap {
    /// The vectors without their places.
    pub fn vectors(&self) -> &GridMap {
        &self.vectors
    }

    /// The nodes.
    pub(crate) fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Every node with its error vector, µm, in the order of the vectors.
    pub fn points(&self) -> impl Iterator<Item = (PerAxis<f64>, PerAxis<f64>)> {
        let nodes = (0..self.vectors.count()).map(|number| self.vectors.node(number));
        nodes.map(|node| (self.place(node), self.error(node)))
    }

    /// Place of a node, its numbers in the order of the chain, mm.
    pub fn place(&self, node: Node) -> PerAxis<f64> {
        let mut place = PerAxis::default();
        for (axis, number) in self.vectors.chain().into_iter().zip(node) {
            place[axis] = self.nodes[axis][number];
        }
        place
    }

    /// Error vector of a node, its numbers in the order of the chain, µm.
    pub fn error(&self, node: Node) -> PerAxis<f64> {
        let [x, y, z] = self.vectors.at(node);
        PerAxis { x, y, z }
    }
}
