//! What was not measured and stands in no noise: angular errors without a table, the tilt of a
//! mirror that is assumed to be perfect. Each is named; with a stated size it enters u.
//!
//! ```text
//!   angle_urad    u²(i) += angle² Σ b²(i)      b: false bow of one rotation that grows evenly by 1 µrad
//!                                              over the box, by the forward model and formula (1)
//!   tilt_arcsec   u²(i) += u²(p) (x_i − x_0)²  u(p_jk) = R/(2V_j) √(1 − (V_k/R)²) · tilt
//! ```
//! A slope that was taken from the increments holds the tilt of the mirror: without
//! `tilt_arcsec` its uncertainty is not known.

use super::corrections::AngleModel;
use super::curves::{Curve, curves, noise_gain, with_slope};
use super::evidence::{Evidence, NineErrors};
use super::increments::{Group, Means};
use crate::axis::{Axis, ErrorTerm, PerAxis, PerTerm, Rotation};
use crate::diagonal::{Pass, PathKind, PerDiagonal, Volume};
use crate::job::{Levers, Reflector, StatedUncertainty};
use crate::units::{Figure, Squared};

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

    /// What was not measured, what it may do, and what the levers were taken for; in words.
    pub fn sentences(
        &self,
        volume: &Volume,
        (kind, reflector): (PathKind, Reflector),
        angle_urad: Option<f64>,
    ) -> Vec<String> {
        let missing = self.missing_sentence(volume, (kind, reflector), angle_urad);
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

    fn missing_sentence(
        &self,
        volume: &Volume,
        (kind, reflector): (PathKind, Reflector),
        angle_urad: Option<f64>,
    ) -> Option<String> {
        if self.missing.is_empty() {
            return None;
        }
        let names: Vec<String> = self.missing.iter().map(ToString::to_string).collect();
        let names = names.join(", ");
        let does = match kind {
            PathKind::Straight => "squareness and scales are those of the lines through the middle of the box, where the angles grow evenly; `angle_urad` is not used with straight runs".to_string(),
            PathKind::Step => format!(
                "{}; the closure does not show it; {}",
                self.bows_in_words(volume, reflector),
                self.booked(angle_urad)
            ),
        };
        Some(format!(
            "angular errors without a measurement, counted as zero: {names}; {does}"
        ))
    }

    fn bows_in_words(&self, volume: &Volume, reflector: Reflector) -> String {
        let bow = bow_um_per_urad(volume, reflector);
        let bent = |axis: &Axis| {
            let bends = |rotation: &Rotation| rotation.along == *axis && !rotation.is_roll();
            self.missing.iter().any(bends)
        };
        let bent = Axis::ALL.into_iter().filter(bent);
        let bows: Vec<String> = bent
            .map(|axis| format!("{axis} {:.3}", Figure(bow[axis])))
            .collect();
        if bows.is_empty() {
            return "only roll is missing, which bends no curve".to_string();
        }
        format!(
            "each µrad of pitch or yaw between the ends of an axis bends curves by up to (µm) {}",
            bows.join(", ")
        )
    }

    fn booked(&self, angle_urad: Option<f64>) -> String {
        match (angle_urad, self.order) {
            (None, _) => {
                "not included in U: state `angle_urad` in [measurement.uncertainty]".to_string()
            }
            (Some(urad), Some(_)) => format!(
                "included in U as angles that grow evenly by {urad} µrad (k = 1, angle_urad) each"
            ),
            (Some(urad), None) => format!(
                "included in U as angles that grow evenly by {urad} µrad (k = 1, angle_urad) each, for the worst order of the axes (`machine.chain` is not stated)"
            ),
        }
    }

    /// Squares of the false bows of all missing rotations of 1 µrad, µm²; the largest of all
    /// orders of the axes where the order is not known. `whole` = curves whose slope is theirs.
    fn square_bows_um2(
        &self,
        volume: &Volume,
        reflector: Reflector,
        whole: &dyn Fn(ErrorTerm) -> bool,
    ) -> PerTerm<Curve> {
        let orders = match &self.order {
            Some(order) => std::slice::from_ref(order),
            None => ALL_ORDERS.as_slice(),
        };
        let mut largest = PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]);
        for order in orders {
            let mut sums = PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]);
            for rotation in &self.missing {
                let bows = false_bows_um(volume, *order, *rotation, reflector);
                for (term, bow) in bows.iter() {
                    let shape = with_slope(volume, term.along, bow, 0.0);
                    let bow = if whole(term) { bow } else { &shape };
                    let pairs = sums[term].iter_mut().zip(bow);
                    pairs.for_each(|(sum, bow)| *sum += bow * bow);
                }
            }
            for (term, sum) in sums.iter() {
                let pairs = largest[term].iter_mut().zip(sum);
                pairs.for_each(|(largest, sum): (&mut f64, &f64)| *largest = largest.max(*sum));
            }
        }
        largest
    }
}

const ALL_ORDERS: [[Axis; 3]; 6] = [
    [Axis::X, Axis::Y, Axis::Z],
    [Axis::X, Axis::Z, Axis::Y],
    [Axis::Y, Axis::X, Axis::Z],
    [Axis::Y, Axis::Z, Axis::X],
    [Axis::Z, Axis::X, Axis::Y],
    [Axis::Z, Axis::Y, Axis::X],
];

/// What the separation makes of one rotation that grows evenly by 1 µrad over the box, µm. The
/// machine is perfect on the lines through the middle of the box, so all of it is false.
pub fn false_bows_um(
    volume: &Volume,
    order: [Axis; 3],
    rotation: Rotation,
    reflector: Reflector,
) -> PerTerm<Curve> {
    let model = AngleModel::unit(volume, order, rotation, reflector);
    let forward = PerDiagonal::from_fn(|diagonal| {
        model.effect_um(volume, PathKind::Step, diagonal, Pass::Forward)
    });
    let means = Means {
        forward,
        reverse: None,
    };
    curves(volume, &means.increments(volume, Group::ForwardOnly))
}

/// Largest false bow of any curve for each µrad of pitch or yaw between the ends of an axis, µm:
/// V/8 for the lever, as much again for the mirror. Roll makes none.
pub fn bow_um_per_urad(volume: &Volume, reflector: Reflector) -> PerAxis<f64> {
    let parts = match reflector {
        Reflector::FlatMirror => 2.0,
        Reflector::Retroreflector => 1.0,
    };
    PerAxis::from_fn(|axis| parts * volume.size[axis].mm() / 8.0 / 1000.0)
}

/// Slope that a tilt of the mirror, as large in each direction across the diagonals, puts into a
/// curve that is separated as if there were none, µm/m.
pub fn slope_of_tilt_um_per_m(volume: &Volume, term: ErrorTerm, tilt_arcsec: f64) -> f64 {
    let across = (1.0 - volume.cosine(term.along).squared()).sqrt();
    noise_gain(volume, term.of) * across * tilt_arcsec * URAD_PER_ARCSEC
}

/// Adds what the job states of unmeasured angles and of an assumed set-up to the uncertainties.
/// `naive`: whether the slope of a term was taken from the increments. Such a term has no
/// uncertainty without a stated tilt.
pub fn book(
    errors: &mut NineErrors,
    volume: &Volume,
    reflector: Reflector,
    stated: &StatedUncertainty,
    angles: &AngleEvidence,
    naive: &dyn Fn(ErrorTerm) -> bool,
) {
    let bows = stated.angle_urad.map(|urad| {
        let squares = angles.square_bows_um2(volume, reflector, naive);
        PerTerm::from_fn(|term| squares[term].iter().map(|s| s * urad * urad).collect())
    });
    let widen = |term: ErrorTerm, evidence: &mut Evidence| {
        let tilt = if naive(term) {
            stated.tilt_arcsec
        } else {
            Some(0.0)
        };
        evidence.u_um = tilt.zip(evidence.u_um.take()).map(|(tilt, u_um)| {
            let slope = slope_of_tilt_um_per_m(volume, term, tilt);
            widened(volume, term, &u_um, slope, bows.as_ref())
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
    bows: Option<&PerTerm<Curve>>,
) -> Vec<f64> {
    let at = |(index, u): (usize, &f64)| {
        let tilt = slope_um_per_m * volume.along_mm(term.along, index) / 1000.0;
        let bow = bows.map_or(0.0, |bows| bows[term][index]);
        (u * u + tilt * tilt + bow).sqrt()
    };
    u_um.iter().enumerate().map(at).collect()
}
