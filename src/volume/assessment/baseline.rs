//! The grouping of paper 002 beside the exact figure: a lower bound, kept for comparison.

use crate::quantity::axis::PerAxis;
use crate::text::problem::Problem;
use crate::volume::space::grouping::{Tolerance, grouping};
use crate::volume::volume_model::ErrorMap;

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
        let count = map.count();
        if count > MOST_NODES {
            return Err(Problem::new(format!(
                "the grid has {count} nodes, but the grouping compares what it keeps pair by pair: {MOST_NODES} at most"
            ))
            .help("use fewer nodes with `--grid`, or leave `--grouping` out"));
        }
        let tolerance = Tolerance {
            angular,
            magnitude: MAGNITUDE,
        };
        let vectors = map.vectors();
        let found = grouping(&vectors.vectors(), tolerance);
        let place = |number: usize| map.place(vectors.node(number));
        Ok(Baseline {
            angular,
            magnitude: MAGNITUDE,
            vectors: count,
            groups: found.groups,
            records: found.records.len(),
            longest: found
                .longest
                .filter(|_| found.records.len() > 1)
                .map(|l| (l.um(), l.pair.map(place))),
        })
    }
}
