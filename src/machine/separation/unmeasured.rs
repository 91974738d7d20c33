//! What was not measured and stands in no noise: angular errors without a table, the tilt of a
//! mirror that is assumed to be perfect, the beam against the mirror. With a stated size it enters u:
//!
//! ```text
//!   angle_urad    u² += angle² · u₁²           u₁: of a bound of 1 µrad, see [`super::angle_bound`]
//!   tilt_arcsec   u²(i) += u²(p) (x_i − x_0)²  u(p_jk) = R/(2V_j) √(1 − (V_k/R)²) · tilt
//! ```
//! A slope that was taken from the increments holds the tilt of the mirror: without
//! `tilt_arcsec` its uncertainty is not known. To say nothing must not look better than to state a bound,
//! so the size of what no uncertainty holds stands beside it:
//!
//! ```text
//!   U holds below x:   √(u² + (x·effect)²) = 1.1·u for the first figure      a tenth more
//! ```

use super::angle_bound::AngleBound;
use super::campaign::Campaign;
use super::metric::{PerPlane, Plane};
use super::slopes::SlopeGains;
use super::solved::NineErrors;
use super::uncertainty::SlopeUncertainty;
use crate::inputs::job::{Reflector, StatedUncertainty};
use crate::quantity::axis::{ErrorTerm, PerTerm};
use crate::quantity::units::rounded_down;

/// √(1.1² − 1): what adds a tenth to an uncertainty, by that uncertainty.
const A_TENTH: f64 = 0.458_257_569_495_584;

/// One cause that is not counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Silent {
    /// Standard uncertainty (k = 1) that it would make where a curve is moved most, µm for each
    /// unit; 0 where the curve is not determined.
    pub by_term: PerTerm<f64>,
    /// The bound that makes some U a tenth larger; `None` where none is known.
    pub holds_below: Option<f64>,
}

/// What is not counted in the uncertainties.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NotCounted {
    /// Angles without a measurement, for each µrad of their bound.
    pub angles: Option<Silent>,
    /// The beam against the mirror's normal, for each mrad² of its bound.
    pub beam: Option<Silent>,
    /// A retroreflector has no normal: the beam then counts against the diagonal.
    retroreflector: bool,
}

impl NotCounted {
    /// What the job leaves out; `angles` = what a bound on the unmeasured ones does.
    pub(super) fn of(
        campaign: &Campaign<'_>,
        angles: Option<&AngleBound>,
        errors: &NineErrors,
        u_squareness: &PerPlane<Option<SlopeUncertainty>>,
        gains: &SlopeGains,
    ) -> NotCounted {
        let (stated, volume) = (&campaign.stated, &campaign.measurement.volume);
        let silent = |curve: &dyn Fn(ErrorTerm) -> f64, plane: &dyn Fn(Plane) -> f64| {
            Silent::of(errors, u_squareness, curve, plane)
        };
        let angles = angles.filter(|_| stated.angle_urad.is_none());
        let beam = stated.beam_mrad.is_none();
        NotCounted {
            angles: angles.map(|bound| {
                let of_plane = |plane| bound.squareness_um_per_m.of(plane);
                silent(&|term| bound.largest_um(term), &of_plane)
            }),
            beam: beam.then(|| {
                let of_plane = |plane| gains.squareness_of_beam(volume, plane);
                let mut silent = silent(&|term| gains.of_beam_um(volume, term), &of_plane);
                silent.holds_below = silent.holds_below.map(f64::sqrt);
                silent
            }),
            retroreflector: campaign.measurement.target == Reflector::Retroreflector,
        }
    }

    /// One sentence for each cause, for the line beside a result.
    pub fn sentences(&self) -> Vec<String> {
        let below = |silent: &Option<Silent>| silent.as_ref()?.holds_below;
        let beam = if self.retroreflector {
            "beam against the diagonal"
        } else {
            "beam against mirror normal"
        };
        let angles = below(&self.angles).map(|urad| ("angles", urad, "µrad"));
        let beam = below(&self.beam).map(|mrad| (beam, mrad, "mrad"));
        let said = angles.into_iter().chain(beam);
        said.map(|(what, bound, unit)| {
            format!("{what} not counted; U holds below {} {unit}", rounded_down(bound))
        })
        .collect()
    }
}

impl Silent {
    /// By what one unit of the cause does to a curve and to a squareness.
    fn of(
        errors: &NineErrors,
        u_squareness: &PerPlane<Option<SlopeUncertainty>>,
        curve: &dyn Fn(ErrorTerm) -> f64,
        plane: &dyn Fn(Plane) -> f64,
    ) -> Silent {
        let by_term = PerTerm::from_fn(|term| {
            let determined = errors.mean[term].is_some();
            if determined { curve(term) } else { 0.0 }
        });
        let curves = errors.mean.iter().map(|(term, found)| {
            let u = found.as_ref()?.u_um.as_ref()?;
            Some((u.iter().copied().fold(0.0, f64::max), by_term[term]))
        });
        let planes = Plane::ALL.map(|p| Some((u_squareness.of(p)?.u_um_per_m, plane(p))));
        let known = curves.chain(planes).flatten();
        let bounds =
            known.filter(|(_, effect)| *effect > 1e-9).map(|(u, effect)| A_TENTH * u / effect);
        Silent { holds_below: bounds.reduce(f64::min), by_term }
    }
}

impl NineErrors {
    /// Adds what the job states of unmeasured angles to the uncertainties; `bound`: what each µrad makes.
    /// `separated`: whether the slope of a term was taken from the increments. Such a term has no uncertainty
    /// without a stated tilt.
    pub(super) fn add_unmeasured(
        &mut self,
        stated: &StatedUncertainty,
        bound: Option<&AngleBound>,
        separated: impl Fn(ErrorTerm) -> bool,
    ) {
        let bound = bound.zip(stated.angle_urad);
        let all = [Some(&mut self.mean), self.plus.as_mut(), self.minus.as_mut()];
        for curves in all.into_iter().flatten() {
            for term in ErrorTerm::ALL {
                let Some(evidence) = &mut curves[term] else {
                    continue;
                };
                let is_known = !separated(term) || stated.tilt_arcsec.is_some();
                let u_um = evidence.u_um.take().filter(|_| is_known);
                let widened = |(index, u): (usize, f64)| {
                    u.hypot(bound.map_or(0.0, |(of, urad)| urad * of.curves_um[term][index]))
                };
                evidence.u_um = u_um.map(|u| u.into_iter().enumerate().map(widened).collect());
            }
        }
    }
}
