//! The values of a table: the straight-line figure on the table's grid that follows a curve.
//!
//! A control joins the values of its table by straight lines. Reading the curve off at the grid
//! points ([`Fit::Sample`]) is what every shop does; it leaves the whole sag of the curve between
//! two grid points on one side. The other fits use the same number of points better:
//! [`Fit::LeastSquares`] keeps the mean square of what is left smallest, [`Fit::Minimax`] the
//! largest amount that is left anywhere.
//!
//! ```text
//!   curve   .·''·.            sampled: values on the curve, error on one side, e
//!        __/______\__  table  minimax: line raised by half of it, error ± e/2
//! ```
//! All fits keep the value 0 at the reference, where the control moves to when it is homed, and
//! look at the whole table, first to last node, with the ends of the curve held.

mod minimax;
mod nodes;

pub use self::nodes::Nodes;

use crate::quantity::curve::solve_tridiagonal;
use crate::quantity::{Deviation, ErrorCurve, Millimetres};

/// How table values follow from the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// The value of the curve at each node.
    Sample,
    /// The smallest integral of the squared residual.
    LeastSquares,
    /// The smallest largest residual.
    Minimax,
}

/// The values of the table at its nodes, unrounded.
///
/// * [`Fit::Sample`]: v_i = d(x_i).
/// * [`Fit::LeastSquares`]: min ∫ (d − Σ v_i φ_i)² dx with the hat functions φ_i of the grid,
///   i.e. h/6·(v_i−1 + 4 v_i + v_i+1) = ∫ d φ_i dx (Galerkin; the first and last row are h/6·(2 1)).
///   The integrals are exact: three-point Gauss on every stretch between knots and nodes, where
///   cubic × line has degree 4. Row and column of the reference drop out, so the two sides of it
///   are solved by themselves.
/// * [`Fit::Minimax`]: min max |d − Σ v_i φ_i|, see the module `minimax`; never worse than
///   `Sample` on either side of the reference.
///
/// shape  `nodes.count` values, in the order of the nodes; exactly 0 at the reference
/// unit   µm
/// sign   that of the curve: actual − commanded
/// limits the curve is zero at the reference ([`ErrorCurve::rezeroed_at`]); outside the measured
///        range its ends are held and count like measured values
///
/// ```
/// use nonius_numerics::quantity::{
///     Deviation, ErrorCurve, Fit, Interpolation, Millimetres, Nodes, residual, table_values,
/// };
/// let curve = ErrorCurve::through(
///     &[0.0, 50.0, 100.0].map(Millimetres::new),
///     &[0.0, 4.0, 4.0].map(Deviation::from_um),
///     Interpolation::Linear,
/// );
/// let (first, step) = (Millimetres::new(0.0), Millimetres::new(100.0));
/// let nodes = Nodes { first, step, count: 2, reference_node: 0 };
/// let sampled = table_values(&curve, &nodes, Fit::Sample);
/// let best = table_values(&curve, &nodes, Fit::Minimax);
/// let left = |values: &[Deviation]| residual(&curve, &nodes, values, first, step);
/// assert!((left(&sampled) - 2.0).abs() < 1e-12);
/// assert!((left(&best) - 4.0 / 3.0).abs() < 1e-9);
/// ```
pub fn table_values(curve: &ErrorCurve, nodes: &Nodes, fit: Fit) -> Vec<Deviation> {
    let values = match fit {
        Fit::Sample => sampled(curve, nodes),
        Fit::LeastSquares => least_squares(curve, nodes),
        Fit::Minimax => minimax::values(curve, nodes),
    };
    values.into_iter().map(Deviation::from_um).collect()
}

/// The largest |curve − table| over a stretch, found exactly from the cubics, µm.
///
/// shape  `values[i]` belongs to node i; straight lines between, held outside the nodes
/// sign   none: a magnitude
/// limits `from` ≤ `to`; as many values as nodes
pub fn residual(
    curve: &ErrorCurve,
    nodes: &Nodes,
    values: &[Deviation],
    from: Millimetres,
    to: Millimetres,
) -> f64 {
    assert_eq!(values.len(), nodes.count);
    let positions: Vec<Millimetres> = (0..nodes.count).map(|node| nodes.position(node)).collect();
    // Straight lines between the nodes, held outside.
    let table_at = |x: Millimetres| {
        let right = positions.partition_point(|node| *node < x);
        if right == 0 || right == nodes.count {
            return values[right.saturating_sub(1)].um();
        }
        let (left, width) = (positions[right - 1], positions[right] - positions[right - 1]);
        let u = (x - left).mm() / width.mm();
        (1.0 - u) * values[right - 1].um() + u * values[right].um()
    };
    let mut corners = Vec::with_capacity(nodes.count + 2);
    corners.push((from, table_at(from)));
    let at_nodes = positions.iter().zip(values).map(|(node, value)| (*node, value.um()));
    corners.extend(at_nodes.filter(|(node, _)| from < *node && *node < to));
    corners.push((to, table_at(to)));
    let magnitudes = corners.windows(2).map(|pair| {
        let [(start, start_um), (end, end_um)] = [pair[0], pair[1]];
        let (low, high) = curve.extremes_against_line(start, end, -start_um, -end_um);
        high.abs().max(low.abs())
    });
    magnitudes.fold(0.0, f64::max)
}

fn sampled(curve: &ErrorCurve, nodes: &Nodes) -> Vec<f64> {
    let value = |node| curve.um_at(nodes.position(node).mm());
    let mut values: Vec<f64> = (0..nodes.count).map(value).collect();
    values[nodes.reference_node] = 0.0;
    values
}

/// The normal equations of the hat functions. The row of the reference is v = 0, coupled to none.
fn least_squares(curve: &ErrorCurve, nodes: &Nodes) -> Vec<f64> {
    let (reference, last) = (nodes.reference_node, nodes.count - 1);
    let mut loads = hat_loads(curve, nodes);
    loads[reference] = 0.0;
    let at_end = |node| node == 0 || node == last;
    let diagonal = (0..nodes.count).map(|node| if at_end(node) { 2.0 } else { 4.0 }).collect();
    let coupled = |left| left != reference && left + 1 != reference;
    let beside: Vec<f64> = (0..last).map(|left| if coupled(left) { 1.0 } else { 0.0 }).collect();
    solve_tridiagonal(diagonal, &beside, loads)
}

/// 6/h · ∫ d φ_i dx for every node, µm.
fn hat_loads(curve: &ErrorCurve, nodes: &Nodes) -> Vec<f64> {
    let mut loads = vec![0.0; nodes.count];
    for node in 1..nodes.count {
        let (left, right) = (nodes.position(node - 1).mm(), nodes.position(node).mm());
        let inside = curve.knots_between(left, right).iter().map(|knot| knot.mm());
        let mut from = left;
        for to in inside.chain([right]) {
            for (x, weight) in gauss_points(from, to) {
                let u = (x - left) / (right - left);
                let part = 6.0 * weight / (right - left) * curve.um_at(x);
                loads[node - 1] += part * (1.0 - u);
                loads[node] += part * u;
            }
            from = to;
        }
    }
    loads
}

/// Places and weights of the three-point Gauss–Legendre rule, exact up to degree 5.
fn gauss_points(from: f64, to: f64) -> [(f64, f64); 3] {
    let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
    let reach = half * 0.6_f64.sqrt();
    [
        (middle - reach, half * 5.0 / 9.0),
        (middle, half * 8.0 / 9.0),
        (middle + reach, half * 5.0 / 9.0),
    ]
}

#[cfg(test)]
mod tests;
