//! The corrected readings of a measurement, and what their runs say by themselves.

use super::campaign::{Campaign, corrected};
use super::corrections::recorded;
use super::noise::{ENOUGH, Noise, NoiseSource, Outlier, repeats};
use super::readings::{CorrectedRun, Means, RunCounts, means, run_counts};
use crate::inputs::job::Material;
use crate::quantity::axis::PerTerm;
use crate::quantity::diagonal::{Pass, PathKind, Run};

/// The runs of a measurement and what they say by themselves.
pub(super) struct Start {
    /// Expansion of the scales at the mean of the recorded temperatures.
    pub(super) material: Option<Material>,
    /// The corrected runs.
    pub(super) runs: Vec<CorrectedRun>,
    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub(super) zeroed_runs: Vec<CorrectedRun>,
    /// Their means and numbers; jumps of a turn are still in them.
    pub(super) means: Means,
    pub(super) counts: RunCounts,
    /// Disturbed readings of single runs.
    pub(super) outliers: Vec<Outlier>,
    /// σ of a reading where repeats or the job give it.
    pub(super) noise: Option<Noise>,
    /// σ of a measurement that is still to be made, where the closure would tell it, µm.
    pub(super) expected_um: Option<f64>,
    /// By how much reversals are known to change along their axes from elsewhere, µm.
    pub(super) change_um: PerTerm<f64>,
}

impl Start {
    pub(super) fn new(campaign: &Campaign<'_>, raw_runs: &[Run]) -> Start {
        let material = campaign.measurement.material;
        let material = material.map(|material| recorded(&material, raw_runs));
        Start::of(campaign, corrected(campaign, raw_runs), material)
    }

    /// Of corrected runs.
    pub(super) fn of(
        campaign: &Campaign<'_>,
        runs: Vec<CorrectedRun>,
        material: Option<Material>,
    ) -> Start {
        let (noise, outliers) = repeats(&runs);
        let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
        Start {
            material,
            expected_um: None,
            change_um: PerTerm::from_fn(|_| 0.0),
            zeroed_runs: runs.iter().filter(zeroed).cloned().collect(),
            means: means(&runs),
            counts: run_counts(&runs),
            outliers,
            noise: known_noise(campaign, noise),
            runs,
        }
    }
}

/// σ of a reading before the closure is judged: repeats say most; else the closure itself, unless it leaves few
/// degrees of freedom and the job states one.
fn known_noise(campaign: &Campaign<'_>, repeats: Option<Noise>) -> Option<Noise> {
    let stated_um = campaign.stated.noise_um;
    let measurement = campaign.measurement;
    let of_closure =
        3 * measurement.volume.steps >= ENOUGH + 3 && measurement.kind == PathKind::Step;
    let stated = stated_um.filter(|_| !of_closure).map(|sigma_um| Noise {
        sigma_um,
        freedom: None,
        source: NoiseSource::Stated,
    });
    repeats.map(|found| found.with_stated(stated_um)).or(stated)
}
