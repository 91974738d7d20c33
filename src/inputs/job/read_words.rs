//! Values that several sections of a job have.

use crate::quantity::axis::{Direction, PerAxis};
use crate::text::document::Section;
use crate::text::plain::is_unseen;

pub(super) const SMALLEST_LIMIT: f64 = 1e-6;

pub(super) const LARGEST_LIMIT: f64 = 1e9;

pub(super) fn axes<T>(
    parent: &Section<'_>,
    read: impl Fn(&Section<'_>) -> Option<T>,
) -> PerAxis<Option<T>> {
    let Some(section) = parent.section("axes") else {
        return PerAxis::default();
    };
    let axes = PerAxis::from_fn(|axis| section.section(axis.key()).and_then(|axis| read(&axis)));
    section.refuse_unknown_keys();
    axes
}

/// Such a text would reach files and the terminal as commands.
pub(super) fn refuse_control_characters(section: &Section<'_>, key: &str, text: Option<&str>) {
    if text.is_some_and(|text| text.contains(is_unseen)) {
        section.problem(
            key,
            format!(
                "`{}` holds a line break or another character that is not seen",
                section.path_of(key)
            ),
            "write it in one line of plain letters and digits",
        );
    }
}

pub(super) fn direction(section: &Section<'_>, key: &'static str) -> Option<Direction> {
    section.choice(key, &[("+", Direction::Plus), ("-", Direction::Minus)])
}
