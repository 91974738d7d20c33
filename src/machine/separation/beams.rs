//! Lines beside the diagonals as formula (7) takes them: slopes between the ends of the box.

use super::campaign::Line;
use super::curves::{Curve, with_slope};
use super::lookup::at;
use super::metric::StraightLine;
use super::uncertainty::Budget;
use crate::quantity::axis::{Axis, ErrorTerm, PerTerm};
use crate::quantity::units::Squared;

/// A line with what the separated shapes contribute between its ends taken off: between places
/// x₁ and x₂ of each axis k, Σ_jk v_j (D_j(k)(x₂) − D_j(k)(x₁)) = L·vᵀhv + that of the shapes.
pub(super) fn without_shapes(
    budget: &Budget<'_>,
    both_ways: bool,
    mean_raw: &PerTerm<Curve>,
    line: &Line,
) -> StraightLine {
    let volume = budget.volume;
    let (mut shape_um, mut variance, mut square_mm) = (0.0, 0.0, 0.0);
    if let Some([from, to]) = line.ends {
        square_mm = Axis::ALL
            .into_iter()
            .map(|axis| (to[axis] - from[axis]).mm().squared())
            .sum();
        for term in ErrorTerm::ALL {
            let [from, to] = [from, to].map(|end| end[term.along]);
            if from == to {
                continue;
            }
            let shape = with_slope(volume, term.along, &mean_raw[term], 0.0);
            let positions = volume.positions(term.along);
            let rise = at(&positions, &shape, to.mm()) - at(&positions, &shape, from.mm());
            let share = line.direction[term.of];
            shape_um += share * rise;
            let spread = budget.shape_variance(term, both_ways, from.mm(), to.mm());
            variance += share * share * spread.unwrap_or(0.0);
        }
    }
    let per_m = if square_mm > 0.0 {
        1000.0 / square_mm.sqrt()
    } else {
        0.0
    };
    StraightLine {
        direction: line.direction,
        slope_um_per_m: line.slope_um_per_m - per_m * shape_um,
        u_um_per_m: line.u_um_per_m.map(|u| u.hypot(per_m * variance.sqrt())),
    }
}

/// A line as it was measured: straight runs hold no shapes to take off a beam.
pub(super) fn whole_line(line: &Line) -> StraightLine {
    StraightLine {
        direction: line.direction,
        slope_um_per_m: line.slope_um_per_m,
        u_um_per_m: line.u_um_per_m,
    }
}
