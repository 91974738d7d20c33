//! What a job says of a path: the state of the control, the limits, and the map of its errors.

use super::map::PathMap;
use super::profile::ProfileLimits;
use crate::inputs::job::Job;
use crate::inputs::nc::{Place, Setup};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::curve::Interpolation;
use crate::quantity::units::Millimetres;
use crate::volume::volume_model::VolumeModel;

fn place(place: PerAxis<Millimetres>) -> Place {
    Axis::ALL.map(|axis| place[axis].mm())
}

/// What the control knows before the program starts.
pub fn setup(job: &Job) -> Setup {
    let path = &job.path;
    let reference = Axis::ALL.map(|axis| job.machine.axes[axis].map_or(0.0, |a| a.reference.mm()));
    Setup {
        start: path.start.map_or(reference, place),
        reference,
        second_reference: path.second_reference.map(place),
        systems: path
            .systems
            .iter()
            .map(|(number, zero)| (*number, place(*zero)))
            .collect(),
        tools: path.tools.clone(),
        inch: path.inch,
        without_point: path.without_point,
        g43_without_h: path.g43_without_h,
        arc_mm: path.arc_mm,
        skip_deletable: path.skip_deletable,
    }
}

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
    let datum: Vec<Place> = job.path.datum.iter().map(|datum| place(*datum)).collect();
    Some(map.zeroed_at(&datum))
}
