//! How much of the machine was measured: what is missing must not look like an error of 0.

use crate::inputs::job::Levers;
use crate::quantity::axis::{Axis, PerAxis, Rotation};
use crate::quantity::chain::unit;
use crate::volume::volume_model::{Component, VolumeModel};

/// Errors of a machine with three axes.
pub(super) const ERRORS: usize = 21;

/// How many of the 21 were measured or stated; squareness also counts where the slopes of both
/// straightnesses hold it.
pub(super) fn count(volume: &VolumeModel) -> usize {
    let missing = volume.missing();
    let squareness = missing.iter().filter(|m| m.name.starts_with("squareness_"));
    let components = volume.components();
    let others = components
        .iter()
        .filter(|component| !matches!(component, Component::Squareness(_)));
    others.count() + 3 - squareness.count().min(3)
}

/// Axes along which nothing was measured, and whose travel nobody states: they stand at one place.
pub(super) fn unknown_axes(volume: &VolumeModel) -> Vec<Axis> {
    let unknown = |axis: &Axis| {
        let (low, high) = volume.range(*axis);
        !volume.is_measured(*axis) && high <= low
    };
    Axis::ALL.into_iter().filter(unknown).collect()
}

/// Whether anything that was measured shows in a direction.
pub(super) fn shows(volume: &VolumeModel, levers: &Levers, direction: Axis) -> bool {
    volume
        .components()
        .into_iter()
        .any(|component| match component {
            Component::Deviation(term) | Component::Squareness(term) => term.of == direction,
            Component::Rotation(rotation) => {
                let mut effects = volume.chain.effects(rotation).into_iter();
                let unknown = unknown_axes(volume);
                effects.any(|e| e.direction == direction && !unknown.contains(&e.arm))
                    || swings(levers, rotation, direction)
            }
        })
}

/// Whether a rotation moves the tool point in a direction, by the stated tool offset.
fn swings(levers: &Levers, rotation: Rotation, direction: Axis) -> bool {
    let tool = levers.tool.map_or(PerAxis::default(), |tool| {
        PerAxis::from_fn(|axis| tool[axis].mm())
    });
    unit(rotation.about).cross(tool)[direction].abs() > 0.0
}

/// Whether an error is a rotation whose every lever stands at one place because nobody states the
/// travel of its axis.
pub(super) fn has_no_lever(volume: &VolumeModel, levers: &Levers, component: Component) -> bool {
    let Component::Rotation(rotation) = component else {
        return false;
    };
    let unknown = unknown_axes(volume);
    let effects = volume.chain.effects(rotation);
    !effects.is_empty()
        && effects.iter().all(|effect| unknown.contains(&effect.arm))
        && !Axis::ALL.into_iter().any(|d| swings(levers, rotation, d))
}
