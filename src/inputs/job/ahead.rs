//! What a job that cannot be read would be asked for next: all problems of one input come at once.

use crate::control::controller::Profile;
use crate::inputs::job::refuse_table;
use crate::quantity::axis::Axis;
use crate::text::document::{Section, Source, read_page};
use crate::text::problem::Problems;

/// The problems that a job would have with its control, as far as the page alone shows them:
/// a control that cannot be found, axes without a grid or without a detection unit.
///
/// **limits** only for a job that is refused already. An axis with a section counts as one that
/// is compensated, because its measured errors are not read.
pub fn ahead(source: Source, find: impl Fn(&str) -> Result<Profile, Problems>) -> Problems {
    let mut found = Problems::none();
    if refuse_table(&source).is_ok() {
        let page = read_page(source, |root| {
            ROOT.into_iter().for_each(|key| _ = root.has(key));
            if let Some(compensation) = root.section("compensation") {
                ask_for_all(&compensation, find);
            }
            Some(())
        });
        found.take(page);
    }
    found
}

/// The keys of a job, in the order in which it is read: an unknown one is told once.
const ROOT: [&str; 8] = [
    "schema",
    "machine",
    "measurement",
    "compensation",
    "limits",
    "acceptance",
    "program",
    "path",
];

fn ask_for_all(section: &Section<'_>, find: impl Fn(&str) -> Result<Profile, Problems>) {
    let profile = section.text("controller").and_then(|word| {
        let told = |problems: Problems| {
            for problem in problems.iter() {
                let help = problem.help.clone().unwrap_or_default();
                section.problem("controller", &problem.message, help);
            }
        };
        find(&word).map_err(told).ok()
    });
    let Some(axes) = section.section("axes") else {
        return;
    };
    for axis in Axis::ALL {
        if let Some(section) = axes.section(axis.key()) {
            ask(&section, axis, profile.as_ref());
        }
    }
}

fn ask(section: &Section<'_>, axis: Axis, profile: Option<&Profile>) {
    let path = section.path();
    let chosen = ["spacing_mm", "points", "max_residual_um"];
    if !chosen.into_iter().any(|key| section.has(key)) {
        section.problem("", without_grid(axis, path), GRID_HELP);
    }
    let counts = profile.filter(|profile| profile.detection_unit_required.value);
    if let Some(profile) = counts.filter(|_| !section.has("detection_unit_um")) {
        section.problem("", without_unit(path, &profile.name), UNIT_HELP);
    }
}

/// The next step for [`without_grid`].
pub const GRID_HELP: &str = "add `spacing_mm = …`, `points = …` or `max_residual_um = …`";
/// The next step for [`without_unit`].
pub const UNIT_HELP: &str =
    "read it from the control (CMR, DMR, feed gear); it is often 1.0 (IS-B) or 0.1 (IS-C)";

/// An axis whose points nobody chose; `path` is that of its section.
pub(crate) fn without_grid(axis: Axis, path: &str) -> String {
    format!("axis {axis} is compensated, but [{path}] does not say how its points are chosen")
}

/// An axis without detection unit, on a control that counts in it.
pub(crate) fn without_unit(path: &str, control: &str) -> String {
    format!("[{path}] has no `detection_unit_um`, and {control} counts in it")
}
