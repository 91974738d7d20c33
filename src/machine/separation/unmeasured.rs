//! What was not measured and stands in no noise: angular errors without a table, the tilt of a
//! mirror that is assumed to be perfect. Each is named; with a stated size it enters u.
//!
//! ```text
//!   angle_urad    u² += angle² · u₁²           u₁: of a bound of 1 µrad, see [`super::angle_bound`]
//!   tilt_arcsec   u²(i) += u²(p) (x_i − x_0)²  u(p_jk) = R/(2V_j) √(1 − (V_k/R)²) · tilt
//! ```
//! A slope that was taken from the increments holds the tilt of the mirror: without
//! `tilt_arcsec` its uncertainty is not known.

use super::angle_bound::AngleBound;
use super::curves::noise_gain;
use super::evidence::{Evidence, NineErrors};
use crate::inputs::job::StatedUncertainty;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::diagonal::Volume;
use crate::quantity::units::Squared;

const URAD_PER_ARCSEC: f64 = 1e6 * std::f64::consts::PI / (180.0 * 3600.0);

/// Slope that a tilt of the mirror, as large in each direction across the diagonals, puts into a
/// curve that is separated as if there were none, µm/m.
fn slope_of_tilt_um_per_m(volume: &Volume, term: ErrorTerm, tilt_arcsec: f64) -> f64 {
    let across = (1.0 - volume.cosine(term.along).squared()).sqrt();
    noise_gain(volume, term.of) * across * tilt_arcsec * URAD_PER_ARCSEC
}

/// Adds what the job states of unmeasured angles and of an assumed set-up to the uncertainties.
/// `bound`: what each µrad makes. `naive`: whether the slope of a term was taken from the
/// increments. Such a term has no uncertainty without a stated tilt.
pub(crate) fn book(
    errors: &mut NineErrors,
    volume: &Volume,
    stated: &StatedUncertainty,
    bound: Option<&AngleBound>,
    naive: &dyn Fn(ErrorTerm) -> bool,
) {
    let bound = bound.zip(stated.angle_urad);
    let widen = |term: ErrorTerm, evidence: &mut Evidence| {
        let tilt = if naive(term) {
            stated.tilt_arcsec
        } else {
            Some(0.0)
        };
        evidence.u_um = tilt.zip(evidence.u_um.take()).map(|(tilt, u_um)| {
            let slope = slope_of_tilt_um_per_m(volume, term, tilt);
            widened(volume, term, &u_um, slope, bound)
        });
    };
    let all = [
        Some(&mut errors.mean),
        errors.plus.as_mut(),
        errors.minus.as_mut(),
    ];
    for curves in all.into_iter().flatten() {
        for term in ErrorTerm::ALL {
            if let Some(evidence) = &mut curves[term] {
                widen(term, evidence);
            }
        }
    }
}

fn widened(
    volume: &Volume,
    term: ErrorTerm,
    u_um: &[f64],
    slope_um_per_m: f64,
    bound: Option<(&AngleBound, f64)>,
) -> Vec<f64> {
    let at = |(index, u): (usize, &f64)| {
        let tilt = slope_um_per_m * volume.along_mm(term.along, index) / 1000.0;
        let angles = bound.map_or(0.0, |(bound, urad)| urad * bound.curves_um[term][index]);
        (u * u + tilt * tilt + angles * angles).sqrt()
    };
    u_um.iter().enumerate().map(at).collect()
}
