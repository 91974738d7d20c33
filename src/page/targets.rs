//! Positioning at targets, the way the standards draw it: mean and ±2 s for each direction.

use super::locale::Locale;
use super::picture::{Ink, Mark, Panel, Picture, Scale};
use crate::machine::standards::iso_230_2::{Figures, K, TargetFigures};

/// A panel for each set of runs, all at one height: the mean deviation at each target moving + and
/// moving − (x̄↑, x̄↓ of ISO 230-2), µm against mm, with bands of k·s, k = 2.
pub fn targets(
    locale: Locale<'_>,
    heading: &str,
    across: &str,
    of: &[(String, &Figures)],
) -> Picture {
    let drawn: Vec<(&str, &Figures, Vec<Mark>)> =
        of.iter().map(|(name, figures)| (name.as_str(), *figures, marks(figures))).collect();
    let heights = drawn.iter().flat_map(|(.., marks)| marks.iter().flat_map(Mark::heights));
    let um = locale.around(heights);
    let panel = |(name, figures, marks): (&str, &Figures, Vec<Mark>)| {
        let at = |target: Option<&TargetFigures>| target.map_or(0.0, |t| t.target_mm);
        let (from, to) = (at(figures.targets.first()), at(figures.targets.last()));
        let across = Scale::new(across, from, to).shown_in(locale.mm());
        Some(Panel::chart(name.to_string(), across, Scale::of_um(locale, um), marks))
    };
    Picture {
        title: heading.to_string(),
        description: locale.words("targets_alt"),
        columns: if of.len() > 1 { 2 } else { 1 },
        panels: drawn.into_iter().map(panel).collect(),
        note: locale.words("targets_note"),
    }
}

fn marks(figures: &Figures) -> Vec<Mark> {
    let (mut bands, mut lines) = (Vec::new(), Vec::new());
    for (ink, is_up) in [(Ink::Up, true), (Ink::Down, false)] {
        let known = figures.targets.iter().filter_map(|t| match is_up {
            true => Some((t.target_mm, t.mean.up_um?, t.s.up_um)),
            false => Some((t.target_mm, t.mean.down_um?, t.s.down_um)),
        });
        let known: Vec<(f64, f64, Option<f64>)> = known.collect();
        if known.is_empty() {
            continue;
        }
        let places: Option<Vec<_>> =
            known.iter().map(|(mm, um, s)| s.map(|s| (*mm, um - K * s, um + K * s))).collect();
        bands.extend(places.map(|places| Mark::Band(ink, places)));
        let means: Vec<(f64, f64)> = known.iter().map(|(mm, um, _)| (*mm, *um)).collect();
        lines.push(Mark::Line(ink, means.clone()));
        lines.push(Mark::Dots(ink, means));
    }
    bands.into_iter().chain(lines).collect()
}
