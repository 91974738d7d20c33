//! What a job says of a path: the limits, and the map of its errors.

use super::map::PathMap;
use super::profile::ProfileLimits;
use crate::inputs::job::Job;
use crate::quantity::axis::Axis;
use crate::quantity::curve::Interpolation;
use crate::volume::volume_model::VolumeModel;

/// How the path is followed.
pub fn limits(job: &Job, volume: &VolumeModel) -> ProfileLimits {
    let path = &job.path;
    ProfileLimits {
        chord_mm: path.chord_mm,
        sample_mm: path.sample_mm,
        rapid: path.rapid,
        measured_tool_mm: path.measured_tool_mm.unwrap_or(0.0),
        measured: Axis::ALL.map(|axis| volume.is_measured(axis).then(|| volume.range(axis))),
        travel: Axis::ALL.map(|axis| job.machine.axes[axis].map(|a| (a.low.mm(), a.high.mm()))),
        refuse_outside: path.refuse_outside,
    }
}

/// The errors of a machine along a path, less the mean error at the probed places of the job.
/// `None` where curves do not ascend, which a model that exists does not do.
pub fn path_map(job: &Job, volume: &VolumeModel) -> Option<PathMap> {
    let number = |axis: Axis| Axis::ALL.iter().position(|other| *other == axis);
    let [first, second, third] = volume.chain.order().map(number);
    let origin = volume.lever_origin();
    let cubic = job.compensation.curve != Interpolation::Linear;
    let map = PathMap::new(
        [first?, second?, third?],
        Axis::ALL.map(|axis| volume.bends(axis)),
        Axis::ALL.map(|axis| origin[axis]),
        cubic,
        |axis, position_mm| {
            let state = volume.state(Axis::ALL[axis], position_mm, |_| true);
            (
                Axis::ALL.map(|of| state.deviation_um[of]),
                Axis::ALL.map(|about| state.rotation_urad[about]),
            )
        },
    )?;
    Some(map.zeroed_at(&job.path.datum))
}
