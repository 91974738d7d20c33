//! What a job does not state and no uncertainty holds: unmeasured angles, the beam against the
//! mirror. To say nothing must not look better than to state a bound, so the size stands beside it.
//!
//! ```text
//!   U holds below x:   √(u² + (x·effect)²) = 1.1·u for the first figure      a tenth more
//! ```

use super::angle_bound::AngleBound;
use super::evidence::NineErrors;
use super::metric::{PerPlane, Plane};
use super::slope_gains::SlopeGains;
use crate::inputs::job::{Reflector, StatedUncertainty};
use crate::quantity::axis::{ErrorTerm, PerTerm};
use crate::quantity::diagonal::Volume;
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

/// The figures of a result and what moves them.
pub(super) struct Figures<'a> {
    pub(super) volume: &'a Volume,
    pub(super) errors: &'a NineErrors,
    pub(super) u_squareness: PerPlane<Option<f64>>,
    pub(super) gains: &'a SlopeGains,
}

impl NotCounted {
    /// What `stated` leaves out; `angles` = what a bound on the unmeasured ones does.
    pub(super) fn of(
        figures: &Figures<'_>,
        stated: &StatedUncertainty,
        reflector: Reflector,
        angles: Option<&AngleBound>,
    ) -> NotCounted {
        let angles = angles.filter(|_| stated.angle_urad.is_none());
        let beam = stated.beam_mrad.is_none();
        NotCounted {
            angles: angles.map(|bound| {
                let curve = |term| bound.largest_um(term);
                figures.silent(curve, bound.squareness_um_per_m)
            }),
            beam: beam.then(|| {
                let curve = |term| figures.gains.of_beam_um(figures.volume, term);
                let squareness = figures.gains.squareness_of_beam(figures.volume);
                let mut silent = figures.silent(curve, squareness);
                silent.holds_below = silent.holds_below.map(f64::sqrt);
                silent
            }),
            retroreflector: reflector == Reflector::Retroreflector,
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
            format!(
                "{what} not counted; U holds below {} {unit}",
                rounded_down(bound)
            )
        })
        .collect()
    }
}

impl Figures<'_> {
    fn silent(&self, curve: impl Fn(ErrorTerm) -> f64, squareness: PerPlane<f64>) -> Silent {
        let by_term = PerTerm::from_fn(|term| {
            let determined = self.errors.mean[term].is_some();
            if determined { curve(term) } else { 0.0 }
        });
        let curves = self.errors.mean.iter().map(|(term, found)| {
            let u = found.as_ref()?.u_um.as_ref()?;
            Some((u.iter().copied().fold(0.0, f64::max), by_term[term]))
        });
        let planes = Plane::ALL.map(|p| Some((self.u_squareness.of(p)?, squareness.of(p))));
        let known = curves.chain(planes).flatten();
        let bounds = known
            .filter(|(_, effect)| *effect > 1e-9)
            .map(|(u, effect)| A_TENTH * u / effect);
        let holds_below = bounds.reduce(f64::min);
        Silent {
            by_term,
            holds_below,
        }
    }
}
