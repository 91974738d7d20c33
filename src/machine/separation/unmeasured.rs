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
use super::slope_gains::SlopeGains;
use crate::inputs::job::{Levers, Reflector, StatedUncertainty};
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis, Rotation};
use crate::quantity::diagonal::Volume;
use crate::quantity::units::Squared;

const URAD_PER_ARCSEC: f64 = 1e6 * std::f64::consts::PI / (180.0 * 3600.0);

/// What is known of the nine angular errors and of their levers.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleEvidence {
    /// Rotations without a measurement: they count as zero.
    pub missing: Vec<Rotation>,
    /// The axes from workpiece to tool; `None` = `machine.chain` is not stated.
    pub order: Option<[Axis; 3]>,
    /// Places that the lever arms count from.
    pub levers: Levers,
    /// Where the lever arms count from, mm ([`Levers::origin`]).
    pub origin: PerAxis<f64>,
    /// Largest change of a measured rotation over the box, µrad.
    pub largest_urad: f64,
}

impl AngleEvidence {
    /// No angle was measured.
    pub fn nothing(order: Option<[Axis; 3]>) -> AngleEvidence {
        AngleEvidence {
            missing: Rotation::all().collect(),
            order,
            levers: Levers::default(),
            origin: PerAxis::default(),
            largest_urad: 0.0,
        }
    }

    /// What was not measured, what counts of it, and what the levers were taken for; in words.
    pub fn sentences(&self, angle_urad: Option<f64>) -> Vec<String> {
        let missing = self.missing_sentence(angle_urad);
        let mut said: Vec<String> = missing.into_iter().collect();
        if self.missing.len() == 9 {
            return said;
        }
        let far = 0.1 * self.largest_urad;
        let unstated: Vec<String> = Axis::ALL
            .into_iter()
            .filter(|axis| self.levers.offsets[*axis].is_none())
            .map(|axis| format!("{axis} {} mm", self.origin[axis]))
            .collect();
        if !unstated.is_empty() {
            said.push(format!(
                "offsets_mm is not stated: the levers of the measured angles count from the reference ({}), as in `assess`; each 100 mm of lever that is really there falsifies deviations by up to {far:.3} µm",
                unstated.join(", ")
            ));
        }
        if self.levers.tool.is_none() {
            said.push(format!(
                "tool_offset_mm is not stated: the mirror is taken to sit at the point that the axes carry; each 100 mm between them falsifies deviations by up to {far:.3} µm"
            ));
        }
        said
    }

    fn missing_sentence(&self, angle_urad: Option<f64>) -> Option<String> {
        if self.missing.is_empty() {
            return None;
        }
        let names: Vec<String> = self.missing.iter().map(ToString::to_string).collect();
        let names = names.join(", ");
        Some(format!(
            "angular errors without a measurement, counted as zero: {names}; no reading shows pitch and yaw, and the figures are meant for the lines through the middle of the box; {}",
            self.counted(angle_urad)
        ))
    }

    fn counted(&self, angle_urad: Option<f64>) -> String {
        let Some(urad) = angle_urad else {
            return "not included in U: state `angle_urad` in [measurement.uncertainty]"
                .to_string();
        };
        let order = match self.order {
            Some(_) => "",
            None => ", for the worst order of the axes (`machine.chain` is not stated)",
        };
        format!(
            "included in U: each within {urad} µrad of its value at the low end of the box, whatever its shape (angle_urad){order}"
        )
    }

    /// What a bound of 1 µrad on the missing angles makes; `None` where all were measured.
    pub(super) fn bound(
        &self,
        volume: &Volume,
        reflector: Reflector,
        gains: &SlopeGains,
    ) -> Option<AngleBound> {
        let missing = (self.missing.as_slice(), self.order);
        (!missing.0.is_empty()).then(|| AngleBound::of(volume, reflector, missing, gains))
    }
}

/// Slope that a tilt of the mirror, as large in each direction across the diagonals, puts into a
/// curve that is separated as if there were none, µm/m.
fn slope_of_tilt_um_per_m(volume: &Volume, term: ErrorTerm, tilt_arcsec: f64) -> f64 {
    let across = (1.0 - volume.cosine(term.along).squared()).sqrt();
    noise_gain(volume, term.of) * across * tilt_arcsec * URAD_PER_ARCSEC
}

/// Adds what the job states of unmeasured angles and of an assumed set-up to the uncertainties.
/// `bound`: what each µrad makes. `naive`: whether the slope of a term was taken from the
/// increments. Such a term has no uncertainty without a stated tilt.
pub fn book(
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
