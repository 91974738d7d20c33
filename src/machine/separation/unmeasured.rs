//! What was not measured and what the job does not state, so that no uncertainty holds it: angular errors without
//! a table, and the beam against the mirror. To say nothing must not look better than to state a bound, so its
//! size stands beside the uncertainty:
//!
//! ```text
//!   U holds below x:   √(u² + (x·effect)²) = 1.1·u for the first figure      a tenth more
//! ```

use super::campaign::Campaign;
use super::linear::Variance;
use super::metric::{PerPlane, Plane};
use super::solved::NineErrors;
use crate::inputs::job::Reflector;
use crate::quantity::axis::PerTerm;
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
    /// What the job leaves out; `planes`: u² of the squareness.
    pub(super) fn of(
        campaign: &Campaign<'_>,
        errors: &NineErrors,
        planes: &PerPlane<Option<Variance>>,
    ) -> NotCounted {
        let stated = &campaign.stated;
        let silent = |cause: usize| Silent::of(errors, planes, cause);
        let is_open = !campaign.angle_evidence().missing.is_empty();
        NotCounted {
            angles: (is_open && stated.angle_urad.is_none()).then(|| silent(0)),
            beam: stated.beam_mrad.is_none().then(|| {
                let mut silent = silent(1);
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
    /// `cause`: 0 = angles, 1 = beam.
    fn of(errors: &NineErrors, planes: &PerPlane<Option<Variance>>, cause: usize) -> Silent {
        let curves = errors.mean.iter().map(|(_, found)| {
            let found = found.as_ref()?;
            let u = found.u_um.as_ref()?;
            Some((u.iter().copied().fold(0.0, f64::max), found.moved_um[cause]))
        });
        let planes = Plane::ALL.map(|plane| {
            let found = planes.of(plane)?;
            Some((found.all.sqrt(), [found.by_urad, found.by_mrad][cause].sqrt()))
        });
        let known = curves.chain(planes).flatten().filter(|(_, moved)| *moved > 1e-9);
        Silent {
            holds_below: known.map(|(u, moved)| A_TENTH * u / moved).reduce(f64::min),
            by_term: PerTerm::from_fn(|term| {
                errors.mean[term].as_ref().map_or(0.0, |found| found.moved_um[cause])
            }),
        }
    }
}
