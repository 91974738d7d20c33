//! What is known of the nine angular errors and of their levers.

use crate::inputs::job::{Levers, Reflector};
use crate::machine::separation::angle_bound::AngleBound;
use crate::machine::separation::slope_gains::SlopeGains;
use crate::quantity::axis::{Axis, PerAxis, Rotation};
use crate::quantity::diagonal::Volume;

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
