//! Where to look along an axis, and how far off a control may be there.

use super::case::{Case, Held};
use crate::support::machine::Term;
use nonius::control::controller::{Dialect, StraightnessForm};
use nonius::quantity::curve::Interpolation;
use nonius::quantity::units::power_of_ten;

/// Positions of a dense look along an axis: straight lines bend at known places, cubics peak.
const DENSE: [usize; 2] = [240, 2000];
/// Beside a jump, mm: near enough that no curve moves by more than [`NEAR_UM`].
const BESIDE_MM: f64 = 1e-7;
/// What a curve moves within [`BESIDE_MM`], µm.
pub(crate) const NEAR_UM: f64 = 1e-5;

/// Half the last digit of positions in the control's files, mm.
pub(crate) fn half_position_digit(case: &Case<'_>) -> f64 {
    match &case.profile.dialect {
        Dialect::Declared(facts) => {
            0.5e-3 * facts.position_size.value.um / power_of_ten(facts.position_decimals.value)
        }
        Dialect::Siemens(_) | Dialect::Linuxcnc(_) if case.machine.inch => 0.5e-6 * 25.4,
        Dialect::Siemens(_)
        | Dialect::Generic(_)
        | Dialect::Linuxcnc(_)
        | Dialect::Isg(_)
        | Dialect::Klipper(_) => 0.5e-6,
        Dialect::Fanuc(_) => 0.0,
    }
}

/// Steepest slope that the generator makes, µm/mm.
pub(crate) const STEEPEST_UM_PER_MM: f64 = 20.0;

/// Where the deviation of a term or its correction bends, and where the correction jumps.
pub(crate) fn bends_and_jumps(case: &Case<'_>, term: &Term, held: &Held) -> (Vec<f64>, Vec<f64>) {
    let mut bends = term.knots();
    bends.extend(&held.mm);
    let mut jumps = Vec::new();
    if matches!(case.profile.dialect, Dialect::Fanuc(_)) {
        jumps.extend(held.mm.windows(2).map(|p| (p[0] + p[1]) / 2.0));
        let unit = case.machine.axis(term.term.of).unit_um.unwrap();
        for (pair, um) in held.mm.windows(2).zip(held.um.windows(2)) {
            let pulses = ((um[1] - um[0]) / unit).abs().round();
            let mut pulse = 0.5;
            while pulse < pulses {
                jumps.push(pair[0] + (pair[1] - pair[0]) * pulse / pulses);
                pulse += 1.0;
            }
        }
    }
    (bends, jumps)
}

pub(crate) fn places(case: &Case<'_>, term: &Term, held: &Held, from: f64, to: f64) -> Vec<f64> {
    let dense = DENSE[usize::from(case.machine.kind != Interpolation::Linear)];
    let (mut places, jumps) = bends_and_jumps(case, term, held);
    places.extend(jumps.iter().flat_map(|x| [x - BESIDE_MM, x + BESIDE_MM]));
    places.extend((0..=dense).map(|i| from + (to - from) * i as f64 / dense as f64));
    places.retain(|x| *x >= from && *x <= to);
    places
}

/// Largest distance of what a control puts out from the straight line between its nodes.
pub(crate) fn jump_um(case: &Case<'_>, term: &Term, held: &Held, x: f64) -> f64 {
    let Dialect::Fanuc(facts) = &case.profile.dialect else {
        return 0.0;
    };
    let increment = held.increment_at(x);
    let machine = case.machine;
    let pulses = machine.axis(term.term.along).interpolated
        && (term.term.is_positioning()
            || facts.straightness_form.value == StraightnessForm::FourPoint);
    if pulses {
        let unit = machine.axis(term.term.of).unit_um.unwrap();
        (unit / 2.0).min(increment / 2.0)
    } else {
        increment / 2.0
    }
}
