//! The same kit on a control that takes every sign the other way round.

use super::case::{Case, Held, count_um, two_tables};
use crate::support::machine::Term;
use crate::support::{self, DUST_UM};
use nonius::control::controller::Dialect;
use nonius::quantity::axis::Direction;
use nonius::read::emulate::Emulator;

/// (c) With the sign turned the residual doubles.
pub(crate) fn turned_sign_doubles(
    case: &Case<'_>,
    term: &Term,
    turned: &dyn Emulator,
    output: &str,
    base: &str,
) -> usize {
    let count = count_um(case, term.term, output);
    let mut seen = 0;
    for direction in Direction::BOTH {
        let placed = case.kit.compiled.placements.iter();
        let placement = placed
            .filter(|p| p.term == term.term)
            .find(|p| p.direction.is_none_or(|d| d == direction))
            .unwrap();
        let right = support::response(case.control, base, output, direction);
        let wrong = support::response(turned, base, output, direction);
        let (right, wrong) = (Held::of(&right), Held::of(&wrong));
        for (a, b) in right.um.iter().zip(&wrong.um) {
            let generic = matches!(case.profile.dialect, Dialect::Generic(_));
            assert!(
                generic || (a + b).abs() < DUST_UM,
                "the sign of the profile acts on every node"
            );
        }
        let reference = case.machine.axis(term.term.along).reference;
        let zero = term.target(case.machine, two_tables(case, term), direction, reference);
        let planned = case
            .kit
            .plan
            .tables
            .iter()
            .find(|t| t.term == term.term && t.direction.is_none_or(|d| d == direction))
            .unwrap();
        let (first, last) =
            (planned.grid.range().0.mm() - 1e-3, planned.grid.range().1.mm() + 1e-3);
        let (mut deviation, mut left) = (0.0_f64, 0.0_f64);
        for (x, um) in right.mm.iter().zip(&right.um) {
            if *x < first || *x > last {
                continue;
            }
            let own = term.target(case.machine, two_tables(case, term), direction, *x) - zero;
            let at_reference = right.um[right.node_at(reference)];
            deviation = deviation.max(own.abs());
            left = left.max((own - (um - at_reference)).abs());
        }
        // The table of a fit may leave the curve, a four-point line does.
        let slack = count.max(placement.fit_residual_um.unwrap_or(0.0))
            + if case.machine.fit == "sample" { 0.0 } else { placement.grid_residual_um };
        if deviation > 12.0 * slack && deviation > 0.1 {
            seen += 1;
            assert!(
                left >= 1.9 * deviation,
                "{}{direction}: deviation {deviation}, with the sign turned {left}",
                term.term
            );
        }
    }
    seen
}
