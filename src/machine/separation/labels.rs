//! What a result rests on: what is assumed of the readings, and what their uncertainty holds.

use super::campaign::Campaign;
use super::curves::noise_gain;
use super::findings::SeparationFinding as Found;
use super::linear_reversal::LinearReversals;
use super::metric::Plane;
use super::noise::coverage_factor;
use super::readings::Means;
use super::reversal::Turn;
use super::solved::{Solved, naive_squareness};
use super::uncertainty::{Budget, u_squareness};
use crate::inputs::job::{Frame, LinearSlope, SetUp};
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::units::{Figure, rounded};
use crate::text::finding::Finding;

/// Of step runs.
pub(super) fn of_steps(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    overrun: Option<bool>,
    turn: Option<&Turn>,
) -> Vec<Finding> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement.setup == SetUp::AssumePerfect {
        labels.push(Found::SetUpAssumed { tilt_arcsec: campaign.stated.tilt_arcsec });
    }
    labels.push(Found::FrameOf { frame: measurement.frame });
    let from = if measurement.overrun.is_some() { "as stated" } else { "judged from the readings" };
    labels.push(match (means.reverse.is_some(), overrun) {
        (false, _) => Found::ForwardOnly,
        (true, Some(true)) => Found::Overran { from },
        (true, Some(false)) => Found::Turned { from },
        (true, None) => Found::OverrunOpen,
    });
    if means.reverse.is_some() && !campaign.reverse_zero_known {
        labels.push(Found::OwnZero);
    }
    labels.extend(turn.map(|turn| {
        Found::FromTurn {
            kept: ErrorTerm::ALL
                .iter()
                .filter(|term| term.is_cross() && turn.in_curves[**term])
                .map(ToString::to_string)
                .collect(),
        }
    }));
    labels.extend(means.reverse.is_some().then_some(Found::Directions));
    labels.extend(Axis::ALL.into_iter().filter_map(|axis| {
        let gain = noise_gain(&measurement.volume, axis);
        (gain > 3.0).then_some(Found::ShortEdge { axis, gain })
    }));
    let labels = labels.into_iter().map(Finding::from);
    labels.chain(common(campaign, budget)).collect()
}

/// Of straight runs.
pub(super) fn of_straight(campaign: &Campaign<'_>, budget: &Budget<'_>) -> Vec<Finding> {
    let runs = match (budget.both_ways(), campaign.reverse_zero_known) {
        (false, _) => Found::StraightForwardOnly,
        (true, true) => Found::StraightOneZero,
        (true, false) => Found::StraightOwnZero,
    };
    let mut labels: Vec<Finding> = vec![runs.into()];
    if campaign.lines.iter().any(|line| line.ends.is_some()) {
        labels.push(Found::WholeBeams.into());
    }
    labels.extend(common(campaign, budget));
    labels
}

/// What is assumed of readings of any kind, and what their uncertainty holds.
fn common(campaign: &Campaign<'_>, budget: &Budget<'_>) -> Vec<Finding> {
    let material = campaign.measurement.material;
    let mut labels = Vec::new();
    if material.is_some_and(|material| !material.air_corrected) {
        labels.push(Found::NoAir);
    }
    labels.push(budget.noise.map_or(Found::NoiseUnknown, |noise| Found::NoiseIs {
        um: noise.sigma_um,
        source: noise.source.words(),
        freedom: noise.freedom,
        k: coverage_factor(noise.freedom_f64()),
    }));
    labels.extend(stated(budget));
    labels.extend(campaign.angle_evidence().labels(campaign.stated.angle_urad));
    labels.extend(lines(campaign));
    labels.into_iter().map(Finding::from).collect()
}

/// What of `[measurement.uncertainty]` counts, and for which axes.
fn stated(budget: &Budget<'_>) -> Vec<Found> {
    let stated = budget.stated;
    let material = |axis: Axis| budget.material.and_then(|material| material.axes[axis]);
    let by_axis = |key, is_stated: bool, known: &dyn Fn(Axis) -> bool, needs| {
        let names = |wanted: bool| {
            let axes = Axis::ALL.iter().filter(|axis| known(**axis) == wanted);
            axes.map(ToString::to_string).collect::<Vec<_>>().join(", ")
        };
        let (with, without) = (names(true), names(false));
        match is_stated {
            false => Found::OfMaterialNotStated { key },
            true => Found::OfMaterial { key, with, without, needs },
        }
    };
    let is_warm = |axis| material(axis).is_some_and(|m| m.temperature_c.is_some());
    let each = u_squareness(budget.volume, budget.volume.diagonal_mm() / 1000.0);
    vec![
        Found::LaserCounts { ppm: stated.of_laser_ppm(), is_stated: stated.laser_ppm.is_some() },
        by_axis(
            "temperature_k",
            stated.temperature_k.is_some(),
            &|axis| material(axis).is_some(),
            "alpha_per_k",
        ),
        by_axis(
            "alpha_per_k",
            stated.alpha_per_k.is_some(),
            &is_warm,
            "alpha_per_k and temperature_c, or a column of temperatures",
        ),
        Found::SetUpCounts {
            ppm: stated.setup_ppm,
            each: by_plane(|plane| format!("{} {:.2}", plane.key(), each.of(plane))),
        },
        Found::BeamCounts { stated },
        Found::SimulatedHold,
    ]
}

fn by_plane(words: impl Fn(Plane) -> String) -> String {
    Plane::ALL.map(words).join(", ")
}

/// What is assumed of linear axes and beams.
fn lines(campaign: &Campaign<'_>) -> Vec<Found> {
    let mut labels = Vec::new();
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_none()) {
        labels.push(Found::LineNotKnown);
    }
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_some()) {
        labels.push(Found::LinesHoldAll);
    }
    let volume = &campaign.measurement.volume;
    let spans: Vec<String> = (campaign.measurement.linear.iter())
        .filter(|linear| matches!(linear.slope, LinearSlope::Stated(_)))
        .map(|linear| {
            let low = volume.start[linear.axis];
            let high = low + volume.size[linear.axis];
            format!("{} {} to {} mm", linear.axis, low.shown(), high.shown())
        })
        .collect();
    if !spans.is_empty() {
        let spans = spans.join(", ");
        labels.push(Found::SlopesOverBox { spans });
    }
    labels
}

/// Where the reversals of single axes come from and what they leave open; `None` without any.
pub(super) fn of_reversals(reversals: &LinearReversals, forward_only: bool) -> Option<Finding> {
    let known = |(axis, reversal): (Axis, &Option<_>)| {
        let um = || {
            reversal.as_ref().map(|b: &super::linear_reversal::LinearReversal| b.um.iter().copied())
        };
        let (low, high) = (um()?.reduce(f64::min)?, um()?.reduce(f64::max)?);
        Some(format!("{axis} {:+.3} to {:+.3}", Figure(low), Figure(high)))
    };
    let found: Vec<String> = reversals.iter().filter_map(known).collect();
    (!found.is_empty())
        .then(|| Finding::from(Found::LinearReversals { found: found.join(", "), forward_only }))
}

impl Solved<'_> {
    /// What the slopes rest on.
    pub(super) fn labels(&self, is_checked: bool) -> Vec<Finding> {
        let squareness = |of: &dyn Fn(Plane) -> f64| {
            by_plane(|p| format!("{} {:.3}", p.key().to_uppercase(), rounded(of(p), 3)))
        };
        let leak = |plane: Plane| 10.0 * self.metric.leak.of(plane);
        let mut labels = Vec::new();
        match (self.setup, self.frame) {
            (SetUp::AssumePerfect, Frame::XPrimary) => {}
            // Their squareness is another one than that of the totals.
            (SetUp::AssumePerfect, Frame::AsMeasured) => labels.push(Found::SeparatedSlopesKept {
                separated: squareness(&|plane| naive_squareness(&self.naive, plane)),
                totals: squareness(&|plane| self.squareness().of(plane).unwrap_or(0.0)),
            }),
            (SetUp::Solve, frame) => {
                if !self.metric.is_complete() {
                    let by_plane = by_plane(|p| format!("{} {:.3}", p.key(), leak(p)));
                    labels.push(Found::Leak { by_plane });
                } else if !is_checked {
                    labels.push(Found::Unchecked);
                }
                if frame == Frame::AsMeasured {
                    labels.push(Found::RotationOfCrossTerms);
                }
            }
        }
        labels.into_iter().map(Finding::from).collect()
    }

    /// What the readings do not determine.
    pub(super) fn undetermined(&self, from_turn: bool, known: &LinearReversals) -> Vec<Finding> {
        let mut open = match self.setup {
            SetUp::Solve => self.metric.undetermined(),
            SetUp::AssumePerfect => Vec::new(),
        };
        let axes = Axis::ALL.iter().filter(|axis| known[**axis].is_none());
        let axes: Vec<String> = axes.map(ToString::to_string).collect();
        if self.budget.both_ways() && !from_turn && !axes.is_empty() {
            let of = match axes.len() {
                3 => "each axis".to_string(),
                _ => axes.join(", "),
            };
            open.push(Found::OpenReversal { of }.into());
        }
        open
    }
}
