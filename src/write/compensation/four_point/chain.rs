//! A chain of straight lines outwards from the reference point.

/// The rounded line at a node from `inner` to `outer`, both included. The division comes last:
/// all before it is exact, so a half is met as a half.
pub(super) fn output_between(inner: (usize, f64), outer: (usize, f64), node: usize) -> f64 {
    let (before, after) = ((node - inner.0) as f64, (outer.0 - node) as f64);
    ((inner.1 * after + outer.1 * before) / (before + after)).round()
}

/// One side of the reference, nodes counted outwards from it.
pub(super) struct Side {
    pub(super) wanted: Vec<f64>,
    pub(super) amount_max: f64,
    /// 1/k for every distance k.
    pub(super) inverse: Vec<f64>,
    /// Outwards is towards node 0.
    pub(super) mirrored: bool,
}

/// Pieces outwards from the reference: where each ends, the amount there, and what is left.
pub(super) struct Chain {
    pub(super) ends: Vec<usize>,
    pub(super) amounts: Vec<f64>,
    pub(super) residual: f64,
}

impl Chain {
    pub(super) fn knots(&self) -> impl DoubleEndedIterator<Item = (usize, f64)> {
        self.ends.iter().copied().zip(self.amounts.iter().copied())
    }
}
