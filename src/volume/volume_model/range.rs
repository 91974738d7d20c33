//! The range of each axis that every one of its curves covers.

use super::VolumeModel;
use crate::inputs::job::Job;
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis, Rotation};
use crate::quantity::curve::ErrorCurve;
use crate::text::problem::{Problem, Problems};

impl VolumeModel {
    /// Every curve of an axis with its name.
    fn named_curves(&self, axis: Axis) -> impl Iterator<Item = (String, &ErrorCurve)> {
        let deviations = Axis::ALL.map(|of| {
            let term = ErrorTerm { of, along: axis };
            Some((term.to_string(), self.deviations[term].as_ref()?))
        });
        let rotations = Axis::ALL.map(|about| {
            let rotation = Rotation { about, along: axis };
            Some((rotation.to_string(), self.rotations[rotation].as_ref()?))
        });
        deviations.into_iter().chain(rotations).flatten()
    }

    /// Every curve of an axis.
    pub(super) fn curves_along(&self, axis: Axis) -> impl Iterator<Item = &ErrorCurve> {
        self.named_curves(axis).map(|(_, curve)| curve)
    }

    /// What all curves of an axis cover; of an axis without curves its travel, because the
    /// rotations of others swing it all the same. Curves that have no range in common are of no
    /// use together, and are refused.
    pub(super) fn common_ranges(&self, job: &Job) -> Result<PerAxis<(f64, f64)>, Problems> {
        let mut problems = Problems::none();
        let mut ranges = PerAxis::from_fn(|axis| (self.origin[axis], self.origin[axis]));
        for axis in Axis::ALL {
            match (self.common_range(job, axis), job.machine.axes[axis]) {
                (Err(problem), _) => problems.push(problem),
                (Ok(Some(range)), _) => ranges[axis] = range,
                (Ok(None), Some(machine)) => ranges[axis] = (machine.low.mm(), machine.high.mm()),
                (Ok(None), None) => {}
            }
        }
        problems.or_ok(ranges)
    }

    fn common_range(&self, job: &Job, axis: Axis) -> Result<Option<(f64, f64)>, Problem> {
        let ends = |(name, curve): (String, &ErrorCurve)| {
            let (low, high) = curve.measured_range();
            (name, low.mm(), high.mm())
        };
        let curves: Vec<(String, f64, f64)> = self.named_curves(axis).map(ends).collect();
        let last_to_begin = curves.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let first_to_end = curves.iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let (Some((late, low, to)), Some((early, from, high))) = (last_to_begin, first_to_end)
        else {
            return Ok(None);
        };
        if low < high {
            return Ok(Some((*low, *high)));
        }
        Err(job
            .problem_at(
                "measurement",
                format!("the curves of {axis} have no range in common: {early} was measured from {from} to {high} mm, {late} from {low} to {to} mm"),
            )
            .help("measure both over the range that is to be judged, or leave one of them out"))
    }
}
