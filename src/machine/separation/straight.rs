//! Straight runs along the body diagonals: what four totals hold.
//!
//! ```text
//!   T_d = R·e_d(end)      S = X²p_xx + Y²p_yy + Z²p_zz = ΣT/4
//!   φxy = (T1 − T2 − T3 + T4)/(4XY)   φxz = (T1 − T2 + T3 − T4)/(4XZ)   φyz = (T1 + T2 − T3 − T4)/(4YZ)   (4)
//! ```
//! 1 … 4 = PPP, NPP, PNP, PPN. Four numbers, four quantities: three squareness errors and one
//! combination of the three scales, whatever the set-up. Linear axes and other beams add to them.

use crate::machine::separation::totals::{Totals, totals};

use super::agreement::{Agreement, agreement};
use super::beams::whole_line;
use super::campaign::{Campaign, corrected};
use super::corrections::recorded;
use super::doubt::of_noise;
use super::evidence::NineErrors;
use super::labels::common_labels;
use super::line::range;
use super::metric::{self, Metric, PerPlane, Plane, StraightLine, end_gains, solve};
use super::noise::{CorrectedRun, Noise, known_noise, run_counts};
use super::not_counted::{Figures, NotCounted};
use super::plane::per_plane;
use super::prediction::{ClosureTests, closure_tests};
use super::repeats::repeats;
use super::slope_gains::SlopeGains;
use super::uncertainty::{Budget, Slope, SlopeUncertainty};
use crate::inputs::error_table::ErrorTable;
use crate::machine::separation::angle_bound::counted_angles;
use crate::quantity::axis::PerAxis;
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::quantity::units::Squared;
use crate::text::problem::Problems;

/// Figures of one diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalFigures {
    /// Reading error at the far end less that at the start, mean of all runs, µm.
    pub end_um: f64,
    /// Max − min over the nodes that lie on the diagonal, both passes, µm.
    pub range_um: f64,
}

/// Figures of every diagonal, and max − min over all of them, µm. Of a step run only the cell
/// ends count: between them the target is beside the diagonal.
pub fn figures(runs: &[CorrectedRun], kind: PathKind) -> (PerDiagonal<DiagonalFigures>, f64) {
    let every = match kind {
        PathKind::Step => 3,
        PathKind::Straight => 1,
    };
    let mean = |diagonal: Diagonal, pass: Pass| -> Vec<f64> {
        let runs: Vec<&CorrectedRun> = runs
            .iter()
            .filter(|run| run.diagonal == diagonal && run.pass == pass)
            .collect();
        let nodes = runs.first().map_or(0, |run| run.readings_um.len());
        #[allow(clippy::cast_precision_loss, reason = "a handful of runs")]
        let count = runs.len() as f64;
        (0..nodes)
            .step_by(every)
            .map(|node| runs.iter().map(|run| run.readings_um[node]).sum::<f64>() / count)
            .collect()
    };
    let both = PerDiagonal::from_fn(|d| Pass::BOTH.map(|pass| mean(d, pass)));
    let figures = PerDiagonal::from_fn(|d| {
        let ends: Vec<f64> = both[d].iter().filter_map(|pass| total(pass)).collect();
        #[allow(clippy::cast_precision_loss, reason = "two passes at most")]
        let count = ends.len().max(1) as f64;
        DiagonalFigures {
            end_um: ends.iter().sum::<f64>() / count,
            range_um: range(both[d].iter().flatten().copied()),
        }
    });
    let all = both.iter().flat_map(|(_, passes)| passes.iter().flatten());
    let over_all = range(all.copied());
    (figures, over_all)
}

/// Far end less start of a pass, so that an offset between the passes does not count.
fn total(pass: &[f64]) -> Option<f64> {
    Some(pass.last()? - pass.first()?)
}

/// Direction cosines squared: the share of each scale in S, for the words of a report.
pub(crate) fn scale_shares(volume: &Volume) -> PerAxis<f64> {
    PerAxis::from_fn(|axis| volume.cosine(axis).squared())
}

/// What straight runs of the four diagonals say.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightResult {
    /// The measured box.
    pub volume: Volume,
    /// The corrected runs.
    pub runs: Vec<CorrectedRun>,
    /// The runs whose zero is that of the forward run: all, or the forward ones only. Figures
    /// that compare the two directions are made of these.
    pub zeroed_runs: Vec<CorrectedRun>,
    /// Figures of the diagonals: totals of all runs, ranges of the zeroed ones.
    pub diagonals: PerDiagonal<DiagonalFigures>,
    /// Max − min over all diagonals, µm.
    pub range_over_all_um: f64,
    /// Formula (4), from the readings alone.
    pub totals: Totals,
    /// Scales and squareness with linear axes and other beams.
    pub metric: Metric,
    /// Whether linear axes, beams and diagonals agree; `None` where nothing is redundant.
    pub agreement: Option<Agreement>,
    /// Uncertainty of the squareness; `None` = not known.
    pub u_squareness: PerPlane<Option<SlopeUncertainty>>,
    /// What the job does not state and no uncertainty holds.
    pub not_counted: NotCounted,
    /// Uncertainty of the scales; `None` where it or that of a line is not known.
    pub u_scale: PerAxis<Option<SlopeUncertainty>>,
    /// Noise of a single reading: from repeated runs, or stated.
    pub noise: Option<Noise>,
    /// The closure test against nine errors.
    pub closure: Option<ClosureTests>,
    /// Why the result is doubtful, one sentence each; empty = nothing speaks against it.
    pub doubts: Vec<String>,
    /// What was assumed and what the uncertainty holds, in words.
    pub labels: Vec<String>,
}

/// Evaluates straight runs; `errors` = nine errors to be tested by them.
pub fn straight(
    campaign: &Campaign<'_>,
    runs: &[Run],
    errors: Option<&ErrorTable>,
) -> Result<StraightResult, Problems> {
    let measurement = campaign.measurement;
    let volume = &measurement.volume;
    let material = measurement.material;
    let material = material.map(|material| recorded(&material, runs));
    let runs = corrected(campaign, runs);
    let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
    let zeroed_runs: Vec<CorrectedRun> = runs.iter().filter(zeroed).cloned().collect();
    let (all, _) = figures(&runs, PathKind::Straight);
    let (of_zeroed, range_over_all_um) = figures(&zeroed_runs, PathKind::Straight);
    let ends = PerDiagonal::from_fn(|d| all[d].end_um);
    let counts = run_counts(&runs);
    let repeats = repeats(&runs);
    let noise = known_noise(&campaign.stated, repeats.noise);
    let both_ways = runs.iter().any(|run| run.pass == Pass::Reverse);
    let budget = Budget {
        volume,
        noise,
        runs: &counts,
        turned: false,
        stated: campaign.stated,
        material,
    };
    let (equations, uncertainties) = (metric::straight(volume, &ends), budget.totals(both_ways));
    let lines: Vec<StraightLine> = campaign.lines.iter().map(whole_line).collect();
    let mut metric = solve(volume, &equations, &uncertainties, &lines);
    let agreement = agreement(volume, &equations, &uncertainties, &lines, &metric);
    if agreement.as_ref().is_some_and(Agreement::is_refuted) {
        metric.u_known = Default::default();
    }
    let gains = end_gains(volume, &equations, &uncertainties, &lines);
    let known = |u_um_per_m: Option<f64>, by_end: PerDiagonal<f64>| {
        let slope = Slope {
            u_um_per_m: u_um_per_m?,
            by_end,
            rotation_um_per_m: 0.0,
        };
        budget.of_slope(&slope, both_ways)
    };
    let u_scale = |axis| known(metric.u_scale(axis), gains.scale(axis));
    let slope_gains = SlopeGains {
        squareness: per_plane(Plane::ALL.map(|plane| gains.squareness(plane))),
        ..SlopeGains::default()
    };
    let angles = campaign.angle_evidence();
    let angles = angles.bound(volume, measurement.target, &slope_gains);
    let counted = counted_angles(angles.as_ref(), &campaign.stated);
    let u_squareness = |plane| {
        let u = metric.u_squareness(plane);
        let u = u.map(|u| u.hypot(counted.of(plane)));
        known(u, gains.squareness(plane))
    };
    let u_squareness = per_plane(Plane::ALL.map(u_squareness));
    let figures_of = Figures {
        volume,
        errors: &NineErrors::default(),
        u_squareness: u_squareness.map(|u| Some(u?.u_um_per_m)),
        gains: &slope_gains,
    };
    let reflector = measurement.target;
    let not_counted = NotCounted::of(&figures_of, &campaign.stated, reflector, angles.as_ref());
    let outliers = repeats.outliers.iter();
    let disturbed = outliers.map(|outlier| {
        format!(
            "disturbed reading, which stays in the result: {}; repeat that run",
            outlier.words()
        )
    });
    let contradiction = agreement.as_ref().and_then(Agreement::contradiction);
    Ok(StraightResult {
        volume: volume.clone(),
        diagonals: PerDiagonal::from_fn(|d| DiagonalFigures {
            end_um: ends[d],
            range_um: of_zeroed[d].range_um,
        }),
        range_over_all_um,
        totals: totals(volume, &ends),
        u_squareness,
        not_counted,
        u_scale: PerAxis::from_fn(|axis| metric.scale[axis].and_then(|_| u_scale(axis))),
        agreement,
        doubts: disturbed
            .chain(contradiction)
            .chain(of_noise(noise, campaign.stated.noise_um))
            .collect(),
        metric,
        noise,
        closure: match errors {
            None => None,
            Some(table) => Some(closure_tests(volume, table, &runs, noise)?),
        },
        labels: labels(campaign, &budget, both_ways),
        runs,
        zeroed_runs,
    })
}

fn labels(campaign: &Campaign<'_>, budget: &Budget<'_>, both_ways: bool) -> Vec<String> {
    let runs = match (both_ways, campaign.reverse_zero_known) {
        (false, _) => {
            "forward runs only: E, B and a reversal need both directions, and NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the squareness"
        }
        (true, true) => "both directions count from the start of the forward run",
        (true, false) => {
            "reverse runs count from their own start: E, B and ranges are those of the forward runs alone; the totals are the mean of both directions"
        }
    };
    let mut labels = vec![runs.to_string()];
    if campaign.lines.iter().any(|line| line.ends.is_some()) {
        labels.push("beams are taken as if they went from end to end of the box: straight runs hold no shapes to take off".to_string());
    }
    labels.extend(common_labels(campaign, budget));
    labels
}
