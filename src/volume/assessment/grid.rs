//! Which nodes a volume is judged at.

use crate::quantity::axis::PerAxis;
use crate::text::problem::Problem;
use crate::volume::volume_model::{Nodes, VolumeModel};

/// Most nodes of a grid.
pub const MOST_POINTS: usize = 100_000_000;

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
        let measured = match choice {
            GridChoice::OwnNodes => as_it_is.own_nodes(),
            GridChoice::Equal(counts) => as_it_is.equal_nodes(counts),
        };
        let own = |machine: &&VolumeModel| match choice {
            GridChoice::OwnNodes => Some(machine.own_nodes()),
            GridChoice::Equal(_) => None,
        };
        let all = others.iter().filter_map(own);
        let nodes = all.fold(measured.clone(), |nodes, more| nodes.and(&more));
        let counts = nodes.counts();
        let points = [counts.x, counts.y, counts.z]
            .iter()
            .try_fold(1_usize, |all, n| all.checked_mul(*n));
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
