//! What a result rests on: what is assumed of the readings, and what their uncertainty holds.

use super::campaign::{Estimate, LinearReversals};
use super::curves::noise_gain;
use super::reversal::Turn;
use super::solved::{CurvesAndSlopes, naive_squareness};
use super::start::Start;
use crate::inputs::job::{Frame, LinearSlope, SetUp};
use crate::machine::findings::SeparationFinding as Found;
use crate::quantity::{Axis, Figure, PerAxis, Plane, Squared, ends, rounded};
use crate::text::{Finding, joined};

/// Of step runs.
pub(super) fn of_steps(start: &Start<'_>, turn: Option<&Turn>) -> impl Iterator<Item = Found> {
    let campaign = start.campaign;
    let measurement = campaign.measurement;
    let (backs, tilt_arcsec) = (start.both_ways(), campaign.stated.tilt_arcsec);
    let is_perfect = measurement.setup == SetUp::AssumePerfect;
    let from = if measurement.overrun.is_some() { "as stated" } else { "judged from the readings" };
    let way = match start.overrun {
        _ if !backs => Found::ForwardOnly,
        Some(true) => Found::Overran { from },
        Some(false) => Found::Turned { from },
        None => Found::OverrunOpen,
    };
    let labels = [
        is_perfect.then_some(Found::SetUpAssumed { tilt_arcsec }),
        Some(Found::FrameOf { frame: measurement.frame }),
        Some(way),
        (backs && !campaign.reverse_zero_known).then_some(Found::OwnZero),
        turn.map(|turn| Found::FromTurn { change_um: turn.change_um.clone() }),
        backs.then_some(Found::Directions),
    ];
    let short = Axis::ALL.map(|axis| (axis, noise_gain(&measurement.volume, axis)));
    let short = short.map(|(axis, gain)| (gain > 3.0).then_some(Found::ShortEdge { axis, gain }));
    labels.into_iter().chain(short).flatten().chain(common(start))
}

/// Of straight runs.
pub(super) fn of_straight(start: &Start<'_>) -> Vec<Finding> {
    let campaign = start.campaign;
    let runs = match (start.both_ways(), campaign.reverse_zero_known) {
        (false, _) => Found::StraightForwardOnly,
        (true, true) => Found::StraightOneZero,
        (true, false) => Found::StraightOwnZero,
    };
    std::iter::once(runs).chain(common(start)).map(Finding::from).collect()
}

/// What is assumed of readings of any kind and of lines beside them, and what their uncertainty holds, for which axes.
fn common(start: &Start<'_>) -> impl Iterator<Item = Found> {
    let (campaign, volume) = (start.campaign, start.volume());
    let (measurement, stated) = (campaign.measurement, campaign.stated);
    let has_air = measurement.material.is_none_or(|material| material.air_corrected);
    let material = |axis: Axis| start.material.and_then(|material| material.axes[axis]);
    let by_axis = |key, stated: Option<f64>, known: &dyn Fn(Axis) -> bool, needs| {
        let known = PerAxis::from_fn(known);
        Found::OfMaterial { key, is_stated: stated.is_some(), known, needs }
    };
    let is_warm = |axis| material(axis).is_some_and(|m| m.temperature_c.is_some());
    let warm = "alpha_per_k and temperature_c, or a column of temperatures";
    let is_known = |axis| material(axis).is_some();
    // u(φ) = R/(2 V_j V_k)·u(e_end)
    let each = |plane: Plane| {
        let (a, b) = plane.axes();
        volume.diagonal_mm().squared() / (2.0 * volume.size[a].mm() * volume.size[b].mm())
    };
    let each = joined(Plane::ALL.map(|plane| format!("{} {:.2}", plane.key(), each(plane))));
    let states_u =
        |wanted: bool| campaign.lines.iter().any(|line| line.u_um_per_m.is_some() == wanted);
    let linear = measurement.linear.iter();
    let linear = linear.filter(|linear| matches!(linear.slope, LinearSlope::Stated(_)));
    let spans = joined(linear.map(|linear| {
        let low = volume.start[linear.axis];
        let high = low + volume.size[linear.axis];
        format!("{} {} to {} mm", linear.axis, low.shown(), high.shown())
    }));
    let of_readings = [
        (!has_air).then_some(Found::NoAir),
        Some(start.noise.map_or(Found::NoiseUnknown, |noise| Found::NoiseIs { noise })),
        Some(Found::LaserCounts {
            ppm: stated.of_laser_ppm(),
            is_stated: stated.laser_ppm.is_some(),
        }),
        Some(by_axis("temperature_k", stated.temperature_k, &is_known, "alpha_per_k")),
        Some(by_axis("alpha_per_k", stated.alpha_per_k, &is_warm, warm)),
        Some(Found::SetUpCounts { ppm: stated.setup_ppm, each }),
        Some(Found::BeamCounts { stated }),
        Some(Found::SimulatedHold),
    ];
    let of_lines = [
        states_u(false).then_some(Found::LineNotKnown),
        states_u(true).then_some(Found::LinesHoldAll),
        (!spans.is_empty()).then_some(Found::SlopesOverBox { spans }),
    ];
    let of_angles = campaign.angles.evidence.labels(stated.angle_urad);
    of_readings.into_iter().chain(of_angles).chain(of_lines).flatten()
}

/// Where the reversals of single axes come from and what they leave open; `None` without any.
pub(super) fn of_reversals(reversals: &LinearReversals, forward_only: bool) -> Option<Found> {
    let known = |(axis, reversal): (Axis, &Option<Vec<Estimate>>)| {
        let (low, high) = ends(reversal.as_ref()?.iter().map(|b| b.um));
        Some(format!("{axis} {:+.3} to {:+.3}", Figure(low), Figure(high)))
    };
    let found = joined(reversals.iter().filter_map(known));
    (!found.is_empty()).then_some(Found::LinearReversals { found, forward_only })
}

impl CurvesAndSlopes<'_> {
    /// What the slopes rest on.
    pub(super) fn labels(&self, is_checked: bool) -> impl Iterator<Item = Found> {
        let squareness = |of: &dyn Fn(Plane) -> f64| {
            let by = |p: Plane| format!("{} {:.3}", p.key().to_uppercase(), rounded(of(p), 3));
            joined(Plane::ALL.map(by))
        };
        let leak = |plane: Plane| 10.0 * self.metric.leak.of(plane);
        let totals = self.metric.squareness_um_per_m();
        let as_measured = self.start.campaign.measurement.frame == Frame::AsMeasured;
        let is_complete = self.metric.is_complete();
        let solves = self.setup() == SetUp::Solve;
        let labels = [
            // Their squareness is another one than that of the totals.
            (!solves && as_measured).then(|| Found::SeparatedSlopesKept {
                separated: squareness(&|plane| naive_squareness(&self.naive, plane)),
                totals: squareness(&|plane| totals.of(plane).unwrap_or(0.0)),
            }),
            (solves && !is_complete).then(|| Found::Leak {
                by_plane: joined(Plane::ALL.map(|p| format!("{} {:.3}", p.key(), leak(p)))),
            }),
            (solves && is_complete && !is_checked).then_some(Found::Unchecked),
            (solves && as_measured).then_some(Found::RotationOfCrossTerms),
        ];
        labels.into_iter().flatten()
    }

    /// What the readings do not determine.
    pub(super) fn undetermined(&self, from_turn: bool, known: &LinearReversals) -> Vec<Finding> {
        let mut open = match self.setup() {
            SetUp::Solve => self.metric.undetermined(),
            SetUp::AssumePerfect => Vec::new(),
        };
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| known[*axis].is_none()).collect();
        if self.start.both_ways() && !from_turn && !axes.is_empty() {
            let of = if axes.len() == 3 { "each axis".to_string() } else { joined(axes) };
            open.push(Found::OpenReversal { of }.into());
        }
        open
    }
}
