//! Values that look like a slip of the pen: a lost motion of the wrong sign, a single value off its neighbours.

use crate::machine::model::ErrorModel;
use crate::quantity::{Direction, ErrorCurve, ErrorTerm, Millimetres};
use crate::write::findings::TableFinding;

/// What to look at in the measured values before tables are made from them.
pub(super) fn slips(model: &ErrorModel) -> Vec<TableFinding> {
    let lone = model.measured().flat_map(|(term, measured)| {
        let curves = measured.measured.ways();
        curves.filter_map(move |(way, curve)| lone_value(term, way, curve))
    });
    unlikely_reversals(model).chain(lone).collect()
}

/// Ordinary lost motion gives B < 0 (contract §1); the other sign is more often a slip.
fn unlikely_reversals(model: &ErrorModel) -> impl Iterator<Item = TableFinding> {
    const NOISE_UM: f64 = 0.5; // below it the sign of B says nothing
    let unlikely = |term: ErrorTerm, um: f64| term.is_positioning() && um > NOISE_UM;
    model
        .measured()
        .filter_map(|(term, measured)| Some((term, measured.reversal()?.um())))
        .filter(move |(term, um)| unlikely(*term, *um))
        .map(|(term, um)| TableFinding::UnlikelyReversal { term, um })
}

/// Fewer values than these tell nothing of a single one.
const FEWEST: usize = 8;
/// So many times the others' distance from their neighbours is not the machine's shape.
const STANDS_OUT: f64 = 5.0;
/// Below it a value does no harm, µm.
const HARMLESS_UM: f64 = 1.0;

/// The value without which all others lie on lines through their neighbours at least five times better than
/// it does. A bend or a jump is none: without one of its values the next one stands out.
fn lone_value(
    term: ErrorTerm,
    direction: Option<Direction>,
    curve: &ErrorCurve,
) -> Option<TableFinding> {
    let at = |at: &Millimetres| (at.mm(), curve.at(*at).um());
    let mut points: Vec<(f64, f64)> = curve.knots().iter().map(at).collect();
    if points.len() < FEWEST {
        return None;
    }
    let (index, off_um) = worst(&points)?;
    points[index].1 -= off_um;
    let (_, rest_um) = worst(&points)?;
    let stands_out = off_um.abs() >= HARMLESS_UM && off_um.abs() > STANDS_OUT * rest_um.abs();
    stands_out.then(|| TableFinding::LoneValue {
        term,
        direction,
        at_mm: points[index].0,
        off_um,
        rest_um: rest_um.abs(),
    })
}

/// The value that is farthest off the line through its two neighbours, and by how much, µm.
fn worst(points: &[(f64, f64)]) -> Option<(usize, f64)> {
    let off = points.windows(3).map(|three| {
        let [(a, ya), (x, y), (b, yb)] = [three[0], three[1], three[2]];
        y - (ya + (yb - ya) * (x - a) / (b - a))
    });
    let off = off.enumerate().map(|(before, um)| (before + 1, um));
    off.max_by(|one, other| one.1.abs().total_cmp(&other.1.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Deviation, Interpolation};

    /// Position and size of the value that stands out of values at 0, 30, 60 … mm.
    fn lone(um: &[f64]) -> Option<(f64, f64)> {
        let places: Vec<Millimetres> =
            (0u32..).map(|n| Millimetres::new(f64::from(n) * 30.0)).take(um.len()).collect();
        let values: Vec<Deviation> = um.iter().copied().map(Deviation::from_um).collect();
        let curve = ErrorCurve::through(&places, &values, Interpolation::Linear);
        match lone_value(ErrorTerm::ALL[0], None, &curve)? {
            TableFinding::LoneValue { at_mm, off_um, .. } => Some((at_mm, off_um)),
            _ => None,
        }
    }

    #[test]
    fn a_wrong_sign_stands_out() {
        let mut um = [0.0, 1.1, 2.0, 2.9, 4.1, 5.0, 6.1, 6.9, 8.0, 9.1];
        assert_eq!(lone(&um), None, "a sound row");
        um[5] = -5.0;
        let (at, off) = lone(&um).unwrap();
        assert!((at - 150.0).abs() < 1e-9 && (off + 10.1).abs() < 1e-9, "{at} {off}");
    }

    #[test]
    fn bends_and_jumps_are_the_machine() {
        let bend = [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 10.0, 15.0, 20.0];
        let jump = [0.0, 0.0, 0.0, 0.0, 8.0, 8.0, 8.0, 8.0, 8.0];
        let wave = [0.0, 5.0, 7.0, 5.0, 0.0, -5.0, -7.0, -5.0, 0.0];
        for um in [bend, jump, wave] {
            assert_eq!(lone(&um), None, "{um:?}");
        }
    }

    #[test]
    fn a_few_values_tell_nothing() {
        assert_eq!(lone(&[0.0, 1.0, 9.0, 3.0, 4.0]), None);
    }
}
