//! Whether the control interpolates between its points, as a read-out says.

use crate::control::controller::Profile;
use crate::control::table::Tables;
use crate::inputs::job::Job;
use crate::judge::active::{ActiveControl, fanuc};
use crate::write::plan::axis_names;

/// Lets the job say what the files do of 3605#1 (lines or steps between the points), where it does
/// not state it; gives what is to be told.
pub fn take_interpolation(
    job: &mut Job,
    profile: &Profile,
    active: &ActiveControl,
) -> Option<String> {
    let Tables::Fanuc(memory) = &active.tables else {
        return None;
    };
    let names = axis_names(job, profile).ok()?;
    let mut on = Vec::new();
    for (axis, names) in names.iter() {
        let Some(settings) = &mut job.compensation.axes[axis] else {
            continue;
        };
        if settings.interpolated.is_some() || settings.parameter_3605.is_some() {
            continue;
        }
        let in_state = |name: &String| active.state.axis(name).is_some_and(|a| a.interpolated);
        let in_state = names.iter().all(in_state).then_some(true);
        settings.interpolated = fanuc::interpolated(memory, names).or(in_state);
        if settings.interpolated == Some(true) {
            on.extend(names.iter().cloned());
        }
    }
    (!on.is_empty()).then(|| {
        format!(
            "3605#1 of axis {} was 1 while measuring: the forecast is for interpolated pitch compensation, lines between the points",
            on.join(", ")
        )
    })
}
