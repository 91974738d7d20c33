//! `active_while_measuring` of a job and the keys that belong to it.

use crate::inputs::job::{ActiveSettings, ActiveTables, NotMeasured};
use crate::quantity::axis::PerAxis;
use crate::text::document::Section;

/// The tables that were active, and what the job says to them.
pub(super) fn active(section: &Section<'_>) -> (ActiveTables, ActiveSettings) {
    let tables = match section.text("active_while_measuring").as_deref() {
        None => ActiveTables::NotStated,
        Some("none") => ActiveTables::None,
        Some(path) => ActiveTables::Path(path.to_string()),
    };
    let settings = ActiveSettings {
        not_measured: section.choice(
            "active_terms_not_measured",
            &[("keep", NotMeasured::Keep), ("drop", NotMeasured::Drop)],
        ),
        rezero: section
            .choice("active_reference", &[("same", false), ("rezero", true)])
            .unwrap_or(false),
        backlash_um: backlash(section),
    };
    if !matches!(tables, ActiveTables::Path(_)) {
        refuse_alone(section, "active_terms_not_measured");
        refuse_alone(section, "active_reference");
    }
    if tables == ActiveTables::NotStated && section.has("active_backlash_um") {
        section.problem(
            "active_backlash_um",
            "`active_backlash_um` states the backlash parameters while measuring, but not whether tables were active",
            "write `active_while_measuring = \"none\"` if none were, or name their files",
        );
    }
    (tables, settings)
}

fn backlash(section: &Section<'_>) -> PerAxis<Option<f64>> {
    let Some(of_axes) = section.section("active_backlash_um") else {
        return PerAxis::default();
    };
    let read = PerAxis::from_fn(|axis| of_axes.number(axis.key()));
    of_axes.refuse_unknown_keys();
    read
}

/// A key that speaks of tables which the job does not name.
fn refuse_alone(section: &Section<'_>, key: &'static str) {
    if section.has(key) {
        section.problem(
            key,
            format!(
                "`{key}` speaks of tables that were active while measuring, but the job names none"
            ),
            "name their files with `active_while_measuring = \"PATH\"`, or remove it",
        );
    }
}
