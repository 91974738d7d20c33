//! What was not measured, and what the figures therefore leave out.

use super::{Component, VolumeModel};
use crate::inputs::job::Job;
use crate::machine::model::ErrorModel;
use crate::quantity::{Axis, ErrorTerm, LeverEffect, Millimetres, PerAxis, Rotation, unit};
use crate::text::{Finding, joined};
use crate::volume::findings::VolumeFinding as Found;
use serde::Serialize;

/// An error that was not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// Which: `EYX`, `EAX`, `squareness_xy`.
    #[serde(rename = "name")]
    pub component: Component,
    /// What the figures leave out, in words.
    pub consequence: String,
}

/// Errors of a machine with three axes.
pub const ERRORS: usize = 21;

impl VolumeModel {
    /// How many of the 21 were measured or stated; squareness also counts where the slopes of both
    /// straightnesses hold it.
    pub fn known_errors(&self) -> usize {
        let is_known = |of: &Component| match of {
            Component::Squareness(term) => !self.is_open(*term),
            _ => self.holds(*of),
        };
        Component::all().filter(is_known).count()
    }

    /// Axes along which nothing was measured, and whose travel nobody states: they stand at one place.
    pub fn unknown_axes(&self) -> Vec<Axis> {
        let unknown = |axis: &Axis| {
            let (low, high) = self.ranges[*axis];
            !self.is_measured(*axis) && high <= low
        };
        Axis::ALL.into_iter().filter(unknown).collect()
    }

    /// Whether anything that was measured shows in a direction.
    pub(crate) fn shows(&self, direction: Axis) -> bool {
        let unknown = self.unknown_axes();
        self.components().into_iter().any(|component| match component {
            Component::Deviation(term) | Component::Squareness(term) => term.of == direction,
            Component::Rotation(rotation) => {
                let mut effects = self.chain.effects(rotation).into_iter();
                effects.any(|e| e.direction == direction && !unknown.contains(&e.arm))
                    || self.swings(rotation, direction)
            }
        })
    }

    /// Whether a rotation moves the tool point in a direction, by the stated tool offset.
    fn swings(&self, rotation: Rotation, direction: Axis) -> bool {
        let tool = PerAxis::from_fn(|axis| self.levers.tool.map_or(0.0, |tool| tool[axis].mm()));
        unit(rotation.about).cross(tool)[direction].abs() > 0.0
    }

    /// Whether an error is a rotation whose every lever stands at one place because nobody states the
    /// travel of its axis.
    pub fn has_no_lever(&self, component: Component) -> bool {
        let Component::Rotation(rotation) = component else {
            return false;
        };
        let unknown = self.unknown_axes();
        let effects = self.chain.effects(rotation);
        !effects.is_empty()
            && effects.iter().all(|effect| unknown.contains(&effect.arm))
            && !Axis::ALL.into_iter().any(|d| self.swings(rotation, d))
    }

    /// Which of the 21 errors were neither measured nor stated, and what that leaves out.
    pub fn missing(&self) -> Vec<Missing> {
        let left_out = |component: Component| match component {
            Component::Squareness(term) if self.is_open(term) => {
                Some(format!("{} and {} count as square", term.of, term.along))
            }
            Component::Squareness(_) => None,
            _ if self.holds(component) => None,
            Component::Deviation(ErrorTerm { of, along }) => {
                Some(format!("whatever {along} does in {of} while it moves"))
            }
            Component::Rotation(rotation) => self.left_out(rotation),
        };
        let missing = |component| Some(Missing { component, consequence: left_out(component)? });
        Component::all().filter_map(missing).collect()
    }

    /// The effects of a rotation that was not measured, at the far end of its levers; `None` = it
    /// has none.
    fn left_out(&self, rotation: Rotation) -> Option<String> {
        let effects = self.chain.effects(rotation).into_iter();
        let effects = effects.map(|effect| self.at_far_end(effect));
        let swings = Axis::ALL.into_iter().any(|direction| self.swings(rotation, direction));
        let tool = swings.then(|| "the tool offset swings with it".to_string());
        let words: Vec<String> = effects.chain(tool).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    fn at_far_end(&self, LeverEffect { direction, arm, .. }: LeverEffect) -> String {
        if self.unknown_axes().contains(&arm) {
            return format!(
                "its effect in {direction} is not known: the lever is the travel of {arm}, which is not stated"
            );
        }
        let ((low, high), origin) = (self.ranges[arm], self.origin[arm]);
        let lever = (low - origin).abs().max((high - origin).abs());
        let (um, mm) = (lever / super::MM_PER_M, Millimetres::new(lever).shown());
        format!("up to {um:.3} µm in {direction} for each µrad (lever {mm} mm in {arm})")
    }

    /// Whether a squareness is neither stated nor can stand in slopes of measured straightness.
    fn is_open(&self, term: ErrorTerm) -> bool {
        let in_slopes = [term, term.twin()].iter().all(|term| self.deviations[*term].is_some());
        let is_stated = self.holds(Component::Squareness(term));
        self.without_squareness.contains(&term) || !in_slopes && !is_stated
    }

    /// What the model takes for granted.
    pub(super) fn statements(&self, job: &Job, model: &ErrorModel) -> Vec<Finding> {
        let mut labels = Vec::from_iter((!self.chain_is_stated).then_some(Found::ChainAssumed));
        let stated = joined(self.squareness.iter().map(|s| {
            let (of, along) = (s.term.of.key(), s.term.along.key());
            format!("{of}{along} {:+} µm/m", s.um_per_m)
        }));
        labels.push(match stated.as_str() {
            "" => Found::SquarenessInCurves,
            _ => Found::SquarenessStated { stated },
        });
        labels.extend(self.of_angles(job));
        labels.extend(Axis::ALL.into_iter().filter_map(|axis| of_directions(model, axis)));
        labels.extend(Axis::ALL.into_iter().filter_map(|axis| self.judged_part(job, axis)));
        labels.extend(model.remarks.doubts.iter().cloned().map(|why| Found::Doubtful { why }));
        labels.into_iter().map(Finding::from).collect()
    }

    fn of_angles(&self, job: &Job) -> Vec<Found> {
        if Rotation::all().all(|rotation| self.rotations[rotation].is_none()) {
            return Vec::new();
        }
        let [_, second, third] = self.chain.order().map(|axis| self.lever_place(axis));
        let mut labels = vec![Found::LeverOrigin { second, third }];
        let at_reference = Rotation::all().filter_map(|rotation| {
            let place = job.machine.axes[rotation.along]?.reference;
            let urad = self.rotations[rotation].as_ref()?.at(place).um();
            let zeroed = self.levers.angles_zero[rotation.along].is_some();
            (!zeroed && urad.abs() >= SHOWN_URAD).then(|| format!("{rotation} {urad:+.3} µrad"))
        });
        let angles = joined(at_reference);
        labels.extend((!angles.is_empty()).then_some(Found::AnglesAtReference { angles }));
        let has_angles =
            |axis: Axis| Rotation::all().any(|of| of.along == axis && self.rotations[of].is_some());
        let zeroed = self.levers.angles_zero.iter().filter(|(axis, _)| has_angles(*axis));
        labels.extend(
            zeroed.filter_map(|(axis, place)| Some(Found::AnglesZero { axis, mm: (*place)?.mm() })),
        );
        let tables = Axis::ALL.into_iter().filter(|axis| self.chain.moves_workpiece(*axis));
        labels.extend(tables.map(|axis| match self.levers.straightness_optic[axis] {
            Some(place) => Found::OpticOnTable { axis, mm: place.mm() },
            None => Found::OpticAtTool { axis },
        }));
        labels
    }

    /// Where the levers of an axis count from, and whether that is assumed.
    fn lever_place(&self, axis: Axis) -> String {
        let is_stated = self.levers.offsets[axis].is_some();
        let word = if is_stated { "" } else { " (assumed: the reference)" };
        let mm = Millimetres::new(self.origin[axis]).shown();
        format!("{axis} {mm} mm{word}")
    }

    fn judged_part(&self, job: &Job, axis: Axis) -> Option<Found> {
        let machine = job.machine.axes[axis]?;
        let (low, high) = self.ranges[axis];
        let travel = [machine.low.mm(), machine.high.mm()];
        let shorter = low > travel[0] + EDGE_MM || high < travel[1] - EDGE_MM;
        let judged = [low, high].map(|mm| Millimetres::new(mm).shown());
        shorter.then_some(Found::JudgedPart { axis, judged, travel })
    }
}

/// Angles at the reference below this are none, µrad.
const SHOWN_URAD: f64 = 0.0005;
/// Ranges that miss the travel by less are the same, mm.
const EDGE_MM: f64 = 0.01;

fn of_directions(model: &ErrorModel, axis: Axis) -> Option<Found> {
    let own = model.measured().filter(|(term, _)| term.along == axis);
    let ways = own.map(|(_, of)| of.measured.ways().filter(|(way, _)| way.is_some()).count());
    match ways.max()? {
        2 => Some(Found::BothDirections { axis }),
        1 => Some(Found::OneDirection { axis }),
        _ => None,
    }
}
